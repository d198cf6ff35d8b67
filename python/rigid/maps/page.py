"""What the page of a map holds: the map, the starts and the outcomes of bodies, as plain data."""

from __future__ import annotations

import itertools
import math
import os
import re
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._checks.arguments import brief, resolve_threads, whole
from .._checks.progress import Listening, ProgressOption
from .._files import published, require_ending
from ..animation.explorer import Explorer, packed, page_of
from ..animation.raster import AZIMUTH, ELEVATION
from ..drawing import colours
from ..model.criteria import Regular
from ..model.forces import FORCES, forces_in_words
from ..model.mixture import Mixture
from ..model.noise import Samples
from .axes import Axis
from .contours import zero_lines
from .data import CLASSES, STATUS, MapData
from .grid import Pixels
from .job import requests
from .plot import DASHES, View, cell_edges, fine_curves
from .samples import Outcomes, outcomes, starts
from .spec import MapSpec
from .theory import predict
from .watched import watched
from .words import axis_label, class_words, default_title, own_unit

MOST_BYTES = 500_000
"""Most compressed bytes of the bodies in a page, unless a number of bodies is given."""

MOST_SAMPLES = 64
"""Most bodies of each pixel in a page, unless a number is given."""


def explore(
    data: MapData,
    path: str | os.PathLike[str] | None,
    *,
    samples: int | None,
    threads: int | None,
    saved_as: str | os.PathLike[str] | None,
    progress: ProgressOption,
) -> Path | Explorer:
    """The page of a map, or its new file; see :meth:`rigid.StabilityMap.explore`."""
    target = None if path is None else Path(path)
    if target is not None:
        require_ending(target, [".html"])
    most = data.spec.samples
    if samples is not None:
        samples = whole("samples", samples)
        if not 1 <= samples <= most:
            raise ValueError(f"samples = {brief(samples)}: must lie in 1 .. {most}, as in the map")
    count = samples or _affordable(data)
    with Listening(progress):
        seen = outcomes(data, range(count), None, resolve_threads(threads))
    draw = _draw(data.spec)
    drawn = content_of_starts(data, range(count)) if draw is None else {"draw": draw}
    drawn |= content_of_numbers(data, range(count))
    if saved_as is None:
        saved_as = "map.npz" if target is None else target.with_suffix(".npz").name
    held = content_of_map(data, count, load=_load(os.fspath(saved_as), data.spec))
    page = page_of(held | drawn | content_of_outcomes(seen))
    if target is None:
        return Explorer(page)
    with published(target) as file:
        file.write(page.encode())
    return target


def _load(file: str, spec: MapSpec) -> str:
    """Python code that reads the map as ``result``, and says what must be defined before."""
    names = {
        argument: name if name.isidentifier() else argument
        for argument, name in spec.left_out.items()
    }
    given = "".join(f", {argument}={name}" for argument, name in names.items())
    note = f"# First define {' and '.join(names.values())} as for the map: no file has functions.\n"
    return (
        f"import rigid\n\n{note if names else ''}"
        f"result = rigid.load_map({file!r}{given})  # the file of result.save\n"
    )


def content_of_starts(data: MapData, samples: range, pixel: int | None = None) -> dict[str, Any]:
    """The starts of bodies as plain data."""
    start = starts(data, samples, pixel)
    return {
        "omega": packed(start.omega, np.float64),
        "attitude": packed(start.attitude, np.float64),
    }


def content_of_numbers(data: MapData, samples: range, pixel: int | None = None) -> dict[str, Any]:
    """Where parameters vary: the numbers of the equations of motion that differ between bodies.

    ``columns`` tells which of the numbers of the pixel are replaced.
    """
    spec = data.spec
    if spec.is_called or not spec.vary or spec.grid.scene.tables:
        return {}
    pixels = np.arange(data.status.size) if pixel is None else np.array([pixel])
    flat = (pixels[:, np.newaxis] * spec.samples + np.array(samples)).ravel()
    of_pixel = numbers_of_motion(spec.grid)[flat // spec.samples]
    own = of_pixel.copy()
    for some in requests(spec, flat):
        own[some.places] = numbers_of_motion(some.bodies())
    columns = np.flatnonzero(((own != of_pixel) & np.isfinite(own)).any(axis=0))
    return {"own": {"columns": columns.tolist(), "values": packed(own[:, columns], np.float64)}}


def content_of_outcomes(seen: Outcomes) -> dict[str, Any]:
    """The outcomes of bodies as plain data."""
    outcome = np.full(seen.outcome.shape, len(CLASSES), dtype=np.uint8)
    for code, name in enumerate(CLASSES):
        outcome[seen.outcome == name] = code
    return {
        "outcome": packed(outcome, np.uint8),
        "left": packed(seen.left, np.float32),  # the page shows four digits
    }


def content_of_map(
    data: MapData,
    count: int,
    *,
    load: str = "",
    python: str = "result",
    whole: MapSpec | None = None,
) -> dict[str, Any]:
    """A map as plain data, without the bodies.

    Parameters
    ----------
    data : MapData
    count : int
        Bodies of each pixel that the page has.
    load : str
        Python code that makes the map, in front of the code of a body.
    python : str
        The name of the map in the Python code of a body.
    whole : MapSpec, optional
        The map that this one is a finer part of: its axes say which scales are logarithmic.
    """
    spec = data.spec
    shape = spec.shape if len(spec.shape) > 1 else (1, *spec.shape)
    is_regular = isinstance(spec.stable, Regular)
    asks = "criterion" if is_regular else "stable"
    rate, _ = spec.clock.shown("rad/s")
    return {
        "title": spec.title or default_title(spec),
        "load": load,
        "python": python,
        "detail": f"{asks}: {spec.criterion}; "
        + ("one body per pixel" if spec.samples == 1 else f"{spec.samples} bodies per pixel")
        + ("" if spec.half_width is None else " at most"),
        "complete": data.complete,
        "shape": shape,
        "dimensions": len(spec.shape),
        "axes": [
            _axis(spec, axis, drawn.geometric)
            for axis, drawn in zip(spec.axes, (whole or spec).axes, strict=True)
        ],
        "layers": _layers(data),
        "status": packed(data.status, np.uint8),
        "statuses": STATUS,
        "counts": {name: packed(getattr(data, name), np.int32) for name in ("samples", *CLASSES)},
        "curves": _curves(data, whole or spec),
        "samples": count,
        "of": spec.samples,
        "classes": CLASSES,
        "words": class_words(spec),
        "leaves": not is_regular,
        "horizon": packed(spec.horizons, np.float64),
        "clock": dict(zip(("unit", "factor"), spec.clock.shown("s"), strict=True)),
        "motion": _motion(spec),
        "charts": [
            chart
            | {
                "label": chart["label"].replace("(rad/s)", f"({rate})"),
                "limits": [packed(limits, np.float64) for limits in of_chart],
            }
            for chart, of_chart in watched(spec)
        ],
        "scene": spec.scene.title
        + (f" under {forces_in_words(spec.forces)}" if spec.forces else ""),
        "inks": {
            "outcomes": colours.OUTCOMES,
            "axes": [ink.colour for ink in colours.AXES],
            "body": colours.FACE,
            "space": colours.SPACE.colour,
            "omega": colours.OMEGA.colour,
            "L": colours.L.colour,
            "vertical": colours.VERTICAL.colour,
            "planet": colours.PLANET.colour,
            "path": colours.FAINT,
        },
        "camera": [AZIMUTH, ELEVATION],
    }


def _affordable(data: MapData) -> int:
    """The number of bodies per pixel that fit into a page."""
    # Times of leaving are hardly compressed, and a class takes two bits at most.
    done = max(int(data.samples.sum()), 1)
    size = data.status.size * (4.0 * int(data.unstable.sum()) / done + 0.25)
    first = content_of_starts(data, range(1)) if _draw(data.spec) is None else {}
    first |= content_of_numbers(data, range(1)).get("own", {})
    size += sum(0.75 * len(one["data"]) for one in first.values() if isinstance(one, dict))
    return int(max(1, min(MOST_BYTES // size, MOST_SAMPLES, data.spec.samples)))


def _draw(spec: MapSpec) -> dict[str, Any] | None:
    """What ``page/draw.js`` draws the starts from; None if it lacks a distribution of this map."""
    start = spec.start
    if isinstance(start, Mixture) or isinstance(start.noise, Samples) or start.joint:
        return None
    if spec.vary and {"energy", "l_gamma"} & {axis.parameter.place for axis in spec.axes}:
        return None  # the start of a body follows from its own moments
    laws = []
    for noise in (start.noise, start.attitude_noise):
        if noise is not None and (noise.cov is not None or noise.is_direction):
            return None
        laws.append(None if noise is None else noise.kind)
    numbers = np.empty(math.prod(spec.shape), dtype=np.int32)  # by which each pixel draws
    for part in spec.parts:
        numbers[part.pixels] = np.arange(len(part.pixels))
    grid = spec.grid
    columns = ("omega", "omega_size", "attitude", "attitude_size")
    return {
        "key": [str(spec.seed % 2**64), str(spec.seed >> 64)],
        "laws": laws,
        "numbers": packed(numbers, np.int32),
        **{name: packed(getattr(grid, name), np.float64) for name in columns},
    }


def _axis(spec: MapSpec, axis: Axis, geometric: bool) -> dict[str, Any]:
    return {
        "name": _plain_words(axis.parameter.symbol),
        "label": _plain_words(axis_label(spec, axis)),
        "unit": "" if axis.unit == "1" else own_unit(spec, axis.unit),
        "values": list(axis.values),
        "edges": drawn_edges(axis, geometric).tolist(),
        "geometric": geometric,
    }


def drawn_edges(axis: Axis, geometric: bool) -> NDArray[np.float64]:
    """The borders of the cells of an axis as the page draws them; logarithms where geometric."""
    edges = cell_edges(axis)
    return np.log(edges) if geometric else edges


def _layers(data: MapData) -> list[dict[str, Any]]:
    """The quantities to draw, with the ranges of their colours; empty ones are omitted."""
    layers: list[dict[str, Any]] = []

    def add(
        name: str,
        label: str,
        given: ArrayLike,
        *,
        unit: str = "1",
        log: bool = False,
        ends: tuple[float, float] | None = None,
    ) -> None:
        """Add a layer; ``{}`` in its label is the place of the unit."""
        shown, factor = data.spec.clock.shown(unit)
        array = factor * np.array(given, dtype=np.float64)
        array[~np.isfinite(array) | (log & (array <= 0.0))] = np.nan
        known = array[np.isfinite(array)]
        if not known.size and ends is None:
            return
        low, high = ends or (float(known.min()), float(known.max()))
        label = label.format("" if shown == "1" else f" ({shown})")
        layer = {"name": name, "label": label, "low": low, "high": high, "log": log}
        layers.append({**layer, "data": packed(array, np.float32)})

    done = np.where(data.samples > 0, data.samples, np.nan).astype(np.float64)
    is_regular = isinstance(data.spec.stable, Regular)
    for name, label, share in (
        ("share", "share regular" if is_regular else "share stable", data.filled),
        ("lower", "lower end of the 95 % interval", data.lower),
        ("upper", "upper end of the 95 % interval", data.upper),
        ("undecided", "share undecided", data.undecided / done),
        ("failed", "share failed", data.failed / done),
    ):
        add(name, label, share, ends=(0.0, 1.0))
    first = "a body was found chaotic" if is_regular else "a body left"
    add("earliest", f"earliest time at which {first}{{}}", data.earliest, unit="s")
    add("energy_drift", "worst drift of the energy", data.energy_drift, log=True)
    add("momentum_drift", "worst drift of the momentum", data.momentum_drift, log=True)
    add("unit_drift", "worst drift of unit lengths", data.unit_drift, log=True)
    if is_regular:
        add("exponent", "mean exponent{}", data.exponent, unit="1/s")
        add("largest_exponent", "largest exponent{}", data.largest_exponent, unit="1/s")
        add("mean_megno", "mean MEGNO", data.mean_megno)
    for name, measured in data.measures.items():
        for of in ("mean", "least", "largest"):
            label = f"{measured.measure.words}{{}}, {of} of the pixel"
            add(f"{name}.{of}", label, getattr(measured, of), unit=measured.measure.unit)
    return layers


def _curves(data: MapData, whole: MapSpec) -> list[dict[str, Any]]:
    """The lines of theory that the picture has, in each plane of the first two axes.

    Points are where the page draws them; NaN stands between lines.
    """
    theory, shape = predict(data.spec), data.spec.shape
    if theory is None or not theory.curves or len(shape) < 2:
        return []
    drawn: dict[str, dict[str, Any]] = {}
    for plane, index in enumerate(np.ndindex(shape[:-2])):
        at = {len(shape) - 1 - k: place for k, place in enumerate(index)}
        axes, curves = fine_curves(View.of(data, theory, at))
        x, y = (
            np.log(axis.values) if drawn_as.geometric else np.array(axis.values)
            for axis, drawn_as in zip(axes, whole.axes, strict=False)
        )
        for curve, dashes in zip(curves, itertools.cycle(DASHES)):
            label = _plain_words(curve.label)
            known = drawn.setdefault(label, {"label": label, "dashes": dashes, "planes": {}})
            lines = zero_lines(x, y, curve.field)
            if lines:
                ended = [np.append(line, [[np.nan] * 2], axis=0) for line in lines]
                known["planes"][str(plane)] = packed(np.concatenate(ended), np.float32)
    return [curve for curve in drawn.values() if curve["planes"]]


def _motion(spec: MapSpec) -> dict[str, Any] | None:
    """The numbers of the equations of motion of each pixel; None if the page cannot integrate."""
    if spec.is_called or spec.grid.scene.tables:
        return None
    return {"numbers": packed(numbers_of_motion(spec.grid), np.float64)}


def numbers_of_motion(bodies: Pixels) -> NDArray[np.float64]:
    """The numbers of the equations of motion of bodies, in the order of ``page/motion.js``."""
    count, torque = len(bodies.moments), bodies.scene.torque
    further = bodies.scene.further_numbers()
    columns: list[ArrayLike] = [bodies.moments, bodies.weight, bodies.damping.reshape(-1, 9)]
    for values in (None, None) if torque is None else (torque.in_body, torque.in_space):
        columns.append(np.zeros(3) if values is None else np.asarray(values)[..., 0, :])
    columns += [further.get(name, np.zeros(force.width)) for name, force in FORCES.items()]
    each = [np.broadcast_to(column, (count, np.shape(column)[-1])) for column in columns]
    return np.concatenate(each, axis=1)


_TEX = {
    r"\omega": "ω",
    r"\gamma": "γ",
    r"\kappa": "κ",
    r"\cdot": "·",
    r"\sqrt": "√",
    r"\,": " ",
    "_{end}": "_end",
    "{": "(",
    "}": ")",
    "$": "",
}

SUBSCRIPTS = str.maketrans("0123456789", "₀₁₂₃₄₅₆₇₈₉")


def _plain_words(label: str) -> str:
    """A label without TeX."""
    label = re.sub(r"_(?:\{(\d+)\}|(\d+))", _subscript, label)
    for tex, plain in _TEX.items():
        label = label.replace(tex, plain)
    return label


def _subscript(found: re.Match[str]) -> str:
    return (found[1] or found[2]).translate(SUBSCRIPTS)
