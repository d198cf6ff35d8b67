"""One body of a map, computed again with its trajectory."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _core
from .._checks.arguments import brief, sorted_times, whole
from ..drawing.colours import HUES, on_ground
from ..drawing.figure import html_text, html_with_picture
from ..model.criteria import Regular, norm_of
from ..model.criterion import Criterion
from ..model.judged import Custom
from ..solve.growth import Growth
from ..solve.lyapunov import growth_of
from ..solve.methods import EXACT, GROWTH_SECOND
from ..solve.request import Problem
from ..solve.run import Run
from ..solve.simulate import replayed, simulate
from .data import CLASSES, COLUMNS, STATUS, MapData
from .grid import Pixels
from .job import requests, spans, to_core
from .judge import TOLERANCE, is_adaptive
from .spec import MapSpec

if TYPE_CHECKING:
    from matplotlib.axes import Axes


MOST_STEPS = 10_000_000
"""Most steps of a pixel that is computed again before a replay: some tenths of a second."""

PARTS = 64
"""Number of times of a growth by default; a whole number of steps lies between two times."""

STEPS_OF_A_BODY = 100
"""The closed form of a body takes about as long as these steps."""


@dataclass(frozen=True, slots=True)
class Part:
    """One criterion of a map for one body.

    Attributes
    ----------
    criterion : Criterion
    outcome : str
        ``"stable"``, ``"unstable"``, ``"undecided"`` or ``"failed"``, by this criterion alone.
    left : float
        Time in s at which the first run passed a limit of the criterion; NaN for never. With
        :func:`rigid.returns` the time of the return.
    """

    criterion: Criterion
    outcome: str
    left: float


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Replay:
    """One body of a map, computed again: bit for bit the motion that the map has classified.

    Attributes
    ----------
    pixel : tuple of int
        Index in the arrays of the map, ``[..., y, x]``.
    sample : int
        Number of the body in its pixel, from 0.
    parameters : dict
        Values of the axes at this pixel, and of the parameters that vary.
    omega, attitude : ndarray, shapes (3,), (4,)
        Start of the body: rad/s in the body; quaternion (w, x, y, z).
    method : str
        ``"exact"`` if it was classified in closed form, else the method.
    outcome : str
        ``"stable"``, ``"unstable"``, ``"undecided"`` or ``"failed"``.
    status : str
        Status at the end of the integration.
    flips : int
        Sign changes until the run ended.
    left : float
        Time at which it left stability, s; NaN if it did not.
    tilt : float
        Largest observed tilt (rad), NaN if the criterion is not a tilt limit.
    exponent, mean_megno : float
        Exponent (1/s) and mean MEGNO at the end, NaN if no deviation vector was integrated.
    energy_drift, momentum_drift, unit_drift : float
        Worst drift of the energy, of the conserved momentum (relative) and of the length of the
        directions that were integrated; NaN by closed form, which conserves them.
    parts : tuple of Part
        Each criterion of joined ones, from left to right; the criterion alone if none are joined.
    measures : dict of str to float
        The value of each measure of the map; NaN for none.
    step : float
        Time step in s; NaN by closed form.
    steps : int
        Time steps taken.
    run : Run or Growth
        The trajectory until the horizon, with the same method and step; the growth of the
        deviation vector with :func:`rigid.regular`; the states at the times of
        :func:`rigid.judged`.
    """

    pixel: tuple[int, ...]
    sample: int
    parameters: dict[str, float]
    omega: NDArray[np.float64]
    attitude: NDArray[np.float64]
    method: str
    outcome: str
    status: str
    flips: int
    left: float
    tilt: float
    exponent: float
    mean_megno: float
    energy_drift: float
    momentum_drift: float
    unit_drift: float
    parts: tuple[Part, ...]
    measures: dict[str, float]
    step: float
    steps: int
    run: Any

    def __repr__(self) -> str:
        """Place in the map, and how the body ended."""
        place = ", ".join(f"{name} {value:g}" for name, value in self.parameters.items())
        left = f" at {self.left:.4g} s" if math.isfinite(self.left) else ""
        return (
            f"<Replay: pixel {self.pixel} ({place}), sample {self.sample}; "
            f"{self.outcome}{left}; {self.method}>"
        )

    def _repr_html_(self) -> str:
        """The rates over time, and when the body left."""
        if not isinstance(self.run, Run) or len(self.run.t) < 2:
            return html_text(repr(self))

        def draw(ax: Axes) -> None:
            self.run.plot(ax)
            if math.isfinite(self.left):
                ax.axvline(
                    self.left, color=on_ground(ax, HUES["black"]), linestyle="--", linewidth=1.0
                )
                ax.annotate(
                    "left",
                    (self.left, 1.0),
                    xycoords=("data", "axes fraction"),
                    xytext=(3.0, -3.0),
                    textcoords="offset points",
                    va="top",
                )

        return html_with_picture(draw, repr(self), height=3.0)


def replay(
    data: MapData, pixel: int | tuple[int, ...], sample: int, t: ArrayLike | None = None
) -> Replay:
    """One body of a map again; see :meth:`rigid.StabilityMap.replay`."""
    spec = data.spec
    index = pixel_index(pixel, spec.shape)
    number = whole("sample", sample)
    if not 0 <= number < spec.samples:
        raise IndexError(f"sample = {brief(sample)}: must lie in 0 .. {spec.samples - 1}")
    if data.status[index]:
        raise ValueError(f"pixel = {index}: no body exists there: {STATUS[data.status[index]]}")
    flat = int(np.ravel_multi_index(index, spec.shape))
    # The earliest loss of stability is a time, whose last bits tell more than any count does.
    for place, one in ((flat, number), (int(np.argmin(data.earliest)), 0)):
        _require_same_bits(data, place, one)
    (some,) = requests(spec, np.array([flat * spec.samples + number]))
    part, (job, at) = some.part.spec, some.request()
    omega, attitude = start = job.starts(at)
    found = job.outcomes(at, 1)
    named = named_outcomes(spec, found)
    measures = {name: values.item() for name, values in named.pop("measures").items()}
    record = {name: values.item() for name, values in named.items()}
    record["status"] = _core.status_names()[record["status"]]
    body = some.bodies()
    scene = body.scene[0]
    step, method = record["step"], record["method"]
    times = np.linspace(0.0, part.t_end, 501) if t is None else t
    run: Any
    if isinstance(spec.stable, Regular):
        run = _growth(part, body, start, record, t)
    elif isinstance(part.stable, Custom):
        run = replayed(
            scene,
            *start,
            t=sorted_times("t", part.stable.times if t is None else t),
            method=method,
            step=step if math.isfinite(step) else None,
            tolerance=TOLERANCE if is_adaptive(part, method) else None,
        )
    elif method == EXACT:
        run = simulate(scene, *start, t=times, method=method)
    elif not math.isfinite(step):  # it was not run: only its start is known
        run = simulate(scene, *start, t=[0.0], method=method)
    elif t is None and not scene.tables:  # whose knots end steps
        total = round(min(part.t_end / step, spec.max_steps))
        ends = np.linspace(0, total, min(total, 500) + 1).astype(np.int64)
        strides = np.diff(ends, prepend=0).tolist()
        run = replayed(scene, *start, t=ends * step, method=method, step=step, strides=strides)
    else:
        run = simulate(scene, *start, t=times, method=method, step=step)
    classes = [CLASSES[code] for code in found["part_class"][0]]
    return Replay(
        pixel=index,
        sample=number,
        parameters={
            name: value.item()
            for name, value in {**spec.values(np.array([flat])), **body.drawn}.items()
        },
        omega=omega,
        attitude=attitude,
        parts=_parts(spec.stable, zip(classes, found["part_left"][0].tolist(), strict=True)),
        measures=measures,
        run=run,
        **record,
    )


def named_outcomes(spec: MapSpec, found: Mapping[str, NDArray[Any]]) -> dict[str, Any]:
    """The outcomes of bodies from the core, by the names that users know."""
    kept = {name: found[name] for name in found if not name.startswith("part_")}
    return {
        "outcome": np.array(CLASSES)[kept.pop("class")],
        "method": np.where(kept.pop("exact"), EXACT, spec.scheme),
        "measures": dict(zip(map(str, spec.measure), kept.pop("measures").T, strict=True)),
        **kept,
    }


def _parts(stable: Criterion, conditions: Iterable[tuple[str, float]]) -> tuple[Part, ...]:
    """The joined criteria of a body, from classes and times of leaving of their conditions."""
    parts = []
    rest = iter(conditions)
    for leaf in stable.leaves:
        classes, times = zip(*itertools.islice(rest, len(leaf.conditions())), strict=True)
        # All conditions of one criterion are to be kept; what is not known has no effect beside one
        # that was left.
        worst_first = ("unstable", "failed", "undecided", "stable")
        outcome = next(name for name in worst_first if name in classes)
        if leaf.logic()[-1] == "~":
            outcome = {"unstable": "stable", "stable": "unstable"}.get(outcome, outcome)
        parts.append(Part(leaf, outcome, float(np.fmin.reduce(times))))
    return tuple(parts)


def _growth(
    spec: MapSpec,
    body: Pixels,
    start: Sequence[NDArray[np.float64]],
    record: Mapping[str, Any],
    t: ArrayLike | None,
) -> Growth:
    """The growth of the deviation vector of a body, at whole numbers of the steps taken."""
    assert isinstance(spec.stable, Regular)
    step = record["step"]
    taken = math.isfinite(step)
    times = spec.t_end / PARTS * np.arange(1.0, PARTS + 1.0, dtype=np.float64)
    if t is not None:
        times = sorted_times("t", t)
        if not times.size or times[0] <= 0.0:
            raise ValueError("t: must be positive times")
    # Of the very start of the map: an attitude given by a user would be normalised first.
    omega, attitude = (rows[np.newaxis] for rows in start)
    batch = body.bodies(np.array([0]), omega, attitude)
    return growth_of(
        Problem(
            scene=body.scene[0],
            record="axis",
            bodies=replace(batch, shape=()),
            times=times,
            method=record["method"] if taken else GROWTH_SECOND,
            step=step if taken else None,
            max_steps=spec.max_steps,
        ),
        of=norm_of(spec.stable.of, spec.scene),
    )


def _require_same_bits(data: MapData, flat: int, sample: int) -> None:
    """Raise ValueError if this build computes other numbers for a pixel than the map holds.

    All bodies of the pixel are computed again if they took few steps; otherwise the numbers of one
    body must be possible in this pixel.
    """
    spec, bodies = data.spec, int(data.samples.flat[flat])
    if sample >= bodies:
        return  # the map says nothing about this body
    whole = data.steps.flat[flat] + STEPS_OF_A_BODY * bodies <= MOST_STEPS
    first = 0 if whole else sample
    # As the functions are now: what they take may have changed since the last replay.
    again = _computed(spec.renewed(), flat, range(first, bodies if whole else first + 1))
    index = tuple(int(i) for i in np.unravel_index(flat, spec.shape))
    who = "its bodies" if whole else f"sample {sample}"
    for measured, rows in zip(data.measures.values(), again["measures"], strict=True):
        mine = measured.bins[measured.bins[:, 0] == flat]
        if whole and not np.array_equal(mine[:, 1:], rows[:, 1:]):
            raise ValueError(
                f"pixel = {index}: {who} computed again give other values of {measured.measure}: "
                f"{_cause(spec)}"
            )
    for column in COLUMNS:
        if not column.reproducible:
            continue
        new, old = again[column.name], data.columns[column.name].flat[flat]
        if not whole and not column.counts and column.reduction == "sum":
            continue  # of terms of both signs
        possible = {"sum": new <= old, "max": not new > old, "min": new >= old}
        same = new == old or math.isnan(old)  # NaN: the map says nothing about it
        if not (same if whole else possible[column.reduction]):
            raise ValueError(
                f"pixel = {index}: {who} computed again give {column.name} = {new}, the "
                f"map has {old}: {_cause(spec)}"
            )


def _cause(spec: MapSpec) -> str:
    """The reason why this build computes other numbers than a map holds."""
    return spec.doubt or (
        f"this build of rigid {_core.__version__} does not give the bits of rigid {spec.version}, "
        "which made the map; replay it there, or compute it again"
    )


@lru_cache(maxsize=64)
def _computed(spec: MapSpec, pixel: int, bodies: range) -> dict[str, Any]:
    """Columns and bins of the measures of some bodies of one pixel, computed by this build."""
    merged = _core.MapStatistics(1, len(spec.measure))
    ((part, _, own),) = spec.by_part(np.array([pixel]))
    for span in spans(spec, range(spec.samples)):
        begin, end = (max(bodies.start, span.start), min(bodies.stop, span.stop))
        if begin < end:
            job = to_core(part.spec, own, len(span), span.start, part.fixed)
            found = job.run(begin - span.start, end - span.start, 1)
            assert found is not None
            merged.merge({**found, "pixels": np.zeros(1, np.int64)})
    columns = {name: values[0] for name, values in merged.arrays().items()}
    return {"measures": merged.bins(), **columns}


def pixel_index(pixel: int | tuple[int, ...], shape: tuple[int, ...]) -> tuple[int, ...]:
    """The index of a pixel in arrays of this shape."""
    if isinstance(pixel, tuple):
        index = tuple(whole("pixel", part) for part in pixel)
        inside = len(index) == len(shape) and all(
            0 <= part < length for part, length in zip(index, shape, strict=True)
        )
    else:
        inside = 0 <= whole("pixel", pixel) < math.prod(shape)
        index = tuple(int(part) for part in np.unravel_index(pixel, shape)) if inside else ()
    if not inside:
        raise IndexError(f"pixel = {brief(pixel)}: lies outside the map of shape {shape}")
    return index
