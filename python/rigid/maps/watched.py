"""The quantities that a criterion watches, with its limits: what the explorer draws over time.

``page/quantities.js`` computes them from the motion.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..model.bounds import (
    NearStart,
    NoFlip,
    PointingWithin,
    RateWithin,
    ReturnsNear,
    SpinAbove,
    TiltBelow,
    TiltBetween,
)
from ..model.criterion import Criterion
from ..model.orbit_axes import DIRECTIONS
from ..model.scene import HeavyTop
from .spec import MapSpec

Chart = dict[str, Any]

RATES = {"what": "rates", "label": "ω (rad/s)"}
TURN = {"what": "turn", "label": "rotation from the start (°)"}
DISTANCE = {"what": "distance", "label": "distance from the planet (semi-major axes)"}
SUBSCRIPTS = "₁₂₃"


def watched(spec: MapSpec) -> list[tuple[Chart, list[NDArray[np.float64]]]]:
    """Each quantity with its limits in each pixel; the quantities of the criterion come first.

    Angles are in degrees. Joined criteria that watch the same quantity share a chart. The rates are
    always there, for a heavy top the tilt of its centre of mass, and on an orbit the direction of
    axis 1 and a distance that changes.
    """
    has_orbit = "orbit" in spec.forces
    charts: list[tuple[Chart, list[NDArray[np.float64]]]] = []
    count = math.prod(spec.shape)
    for number, leaf in enumerate(spec.stable.leaves):
        found = _of(leaf, has_orbit)
        if found is None:
            continue
        chart, limits_of = found
        rows = np.empty((len(limits_of(leaf)), count))
        for part in spec.parts:
            of_part = limits_of(part.spec.stable.leaves[number])
            rows[:, part.pixels] = np.array(of_part)[:, np.newaxis]
        same = [limits for known, limits in charts if known == chart]
        if same:
            same[0].extend(rows)
        else:
            charts.append((chart, list(rows)))
    kinds = [chart["what"] for chart, _ in charts]
    if isinstance(spec.scene, HeavyTop) and "tilt" not in kinds:
        charts.append((_tilt(None, "vertical"), []))
    if has_orbit and "pointing" not in kinds:
        charts.append((_pointing(1, "radial", either=True), []))
    if has_orbit and _is_eccentric(spec):
        charts.append((DISTANCE, []))
    if "rates" not in kinds:
        charts.append((RATES, []))
    return charts


def _is_eccentric(spec: MapSpec) -> bool:
    """Whether the distance from the planet changes in some pixel."""
    orbit = spec.grid.scene.further_numbers().get("orbit")
    return isinstance(orbit, np.ndarray) and bool(np.any(orbit[..., 1]))


def _of(
    leaf: Criterion, has_orbit: bool
) -> tuple[Chart, Callable[[Any], tuple[float, ...]]] | None:
    """What a criterion watches, and how its limits are read; None if it has no limits."""
    match leaf:
        case NoFlip():
            return RATES, lambda _: (0.0,)
        case TiltBelow():
            # The vertical of a body on an orbit is the normal.
            is_normal = has_orbit and leaf.reference == "vertical"
            reference = "normal" if is_normal else str(leaf.reference)
            return _tilt(leaf.axis, reference), _degrees("angle")
        case TiltBetween():
            return _tilt(leaf.axis, "vertical"), _degrees("low", "high")
        case RateWithin():
            vector = "ω" if leaf.of == "omega" else "L"
            where = "in space" if leaf.frame == "space" else "in the body"
            label = f"angle of {vector} from its start {where} (°)"
            chart = {"what": "direction", "of": leaf.of, "frame": leaf.frame, "label": label}
            return chart, _degrees("angle")
        case PointingWithin(axis=int(axis)):
            return _pointing(axis, leaf.of, either=leaf.either), _degrees("angle")
        case NearStart():
            return TURN, _degrees("angle")
        case ReturnsNear():
            return {**TURN, "after": leaf.after}, _degrees("angle")
        case SpinAbove(axis=None):
            return {"what": "speed", "label": "|ω| (rad/s)"}, lambda given: (given.rate,)
        case SpinAbove(axis=int(axis)):
            sign = "−" if axis < 0 else ""
            label = f"{sign}ω{SUBSCRIPTS[abs(axis) - 1]} (rad/s)"
            return {"what": "rate", "axis": axis, "label": label}, lambda given: (given.rate,)
    return None


def _tilt(axis: int | None, reference: str) -> Chart:
    """The tilt of a body axis, or of the centre of mass without one."""
    of = "the centre of mass" if axis is None else f"axis {axis}".replace("-", "−")
    origins = {"start": "its start", "normal": "the normal of the orbit"}
    origin = origins.get(reference, "the vertical")
    label = f"tilt of {of} from {origin} (°)"
    return {"what": "tilt", "axis": axis, "reference": reference, "label": label}


def _pointing(axis: int, of: str, *, either: bool) -> Chart:
    """The angle of a body axis from a direction of the orbit."""
    label = f"angle of axis {axis} from {DIRECTIONS[of]} (°)".replace("axis -", "axis −")
    return {"what": "pointing", "axis": axis, "of": of, "either": either, "label": label}


def _degrees(*names: str) -> Callable[[Any], tuple[float, ...]]:
    """Limits in degrees of a criterion that has them in rad."""
    return lambda leaf: tuple(math.degrees(getattr(leaf, name)) for name in names)
