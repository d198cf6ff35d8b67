"""The map explorer: one page with a map, the bodies of its pixels, and films of their motions.

The page has the verdicts of some bodies of each pixel. It draws their starts as the core does
(``page/draw.js``), and computes their motions by a Taylor series (``page/motion.js``).
"""

from __future__ import annotations

import base64
import math
import operator
import os
import re
import zlib
from pathlib import Path
from typing import TYPE_CHECKING, Any, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._checks.arguments import brief, resolve_threads
from .._checks.progress import Listening, ProgressOption
from .._files import published, require_ending
from ..drawing import colours
from ..maps.data import CLASSES, STATUS
from ..maps.plot import cell_edges
from ..maps.result import StabilityMap
from ..maps.samples import Outcomes, Starts
from ..maps.words import class_words, default_title
from ..model.criteria import Regular
from ..model.mixture import Mixture
from ..model.start import Samples
from .raster import AZIMUTH, ELEVATION
from .watched import watched
from .web import Page, assembled

if TYPE_CHECKING:
    from os import PathLike

    from ..maps.parameters import Axis
    from ..maps.spec import MapSpec

__all__ = [
    "Explorer",
    "content_of_map",
    "content_of_outcomes",
    "content_of_starts",
    "drawn_edges",
    "explore",
    "page_of",
]

MOST_BYTES = 500_000
"""Most compressed bytes of the bodies in a page, unless a number of bodies is given."""

MOST_SAMPLES = 64
"""Most bodies of each pixel in a page, unless a number is given."""

SCRIPTS = (
    *("vectors.js", "stage.js", "charts.js", "player.js"),
    *("motion.js", "draw.js", "quantities.js", "solids.js", "map.js", "explorer.js"),
)


class Explorer(Page):
    """The page of a map, which a notebook shows.

    Attributes
    ----------
    page : str
        The page as HTML; it needs no network.
    """

    __slots__ = ()

    title = "map explorer"
    height = 720


@overload
def explore(
    result: StabilityMap,
    path: None = None,
    *,
    samples: int | None = None,
    threads: int | None = None,
    saved_as: str | PathLike[str] | None = None,
    progress: ProgressOption = None,
) -> Explorer: ...


@overload
def explore(
    result: StabilityMap,
    path: str | PathLike[str],
    *,
    samples: int | None = None,
    threads: int | None = None,
    saved_as: str | PathLike[str] | None = None,
    progress: ProgressOption = None,
) -> Path: ...


def explore(
    result: StabilityMap,
    path: str | PathLike[str] | None = None,
    *,
    samples: int | None = None,
    threads: int | None = None,
    saved_as: str | PathLike[str] | None = None,
    progress: ProgressOption = None,
) -> Path | Explorer:
    """Write a page to explore a map; see :meth:`rigid.StabilityMap.explore`, which calls this.

    The page is one file and needs no network. It shows the map with its layers and the lines of
    theory. A click on a pixel lists bodies of it by their outcome, and shows the motion of one body
    as a film.

    The page draws the starts of the bodies as the map has drawn them, bit for bit. It holds the
    starts of mixtures, given samples, covariances and von Mises-Fisher directions. It computes the
    motions by a Taylor series of order 24 with a relative error of about 1e-14 a step. The outcomes
    come from the map. A chaotic motion may therefore differ from the motion that the map has
    classified; ``result.replay`` gives this motion. Motions under torques that act in space or
    change in time, and of satellites, are not computed in the page.

    Parameters
    ----------
    result : StabilityMap
        The map.
    path : path-like, optional
        The page; its name must end in ``.html``. Without a path the page is returned, and a
        notebook shows it.
    samples : int, optional
        Bodies of each pixel that the page has, the first ones. By default as many as need 0.7 MB,
        at least 1 and at most 64.
    threads : int, optional
        Threads that classify the bodies again. Default: ``RIGID_NUM_THREADS``, else the cores that
        this process may use.
    saved_as : path-like, optional
        The file to which :meth:`rigid.StabilityMap.save` writes the map. The Python code that the
        page offers reads this file. Default: the name of the page with the suffix ``.npz``.
    progress : None, bool or callable
        As in :func:`rigid.simulate`.

    Returns
    -------
    pathlib.Path or Explorer
        Path of the new file; without a path, the page.

    Raises
    ------
    OSError
        If the file cannot be written, or the path names something other than a file.
    TypeError, ValueError
        Naming the argument, its value and the rule: a name that does not end in ``.html``, more
        samples than the map has.

    Examples
    --------
    >>> import pathlib, tempfile, rigid
    >>> from rigid.animation.explorer import explore
    >>> result = rigid.stability_map(
    ...     rigid.FreeBody, axes={"spin": [1.0, 2.0]}, samples=10, t_end=50.0,
    ...     stable=rigid.no_flip(), rng=2026,
    ... )
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     explore(result, pathlib.Path(folder, "map.html")).name
    'map.html'
    """
    target = None if path is None else Path(path)
    if target is not None:
        require_ending(target, [".html"])
    most = result.spec.samples
    if samples is not None:
        samples = operator.index(samples)
        if not 1 <= samples <= most:
            raise ValueError(f"samples = {brief(samples)}: must lie in 1 .. {most}, as in the map")
    count = samples or _affordable(result)
    with Listening(progress):
        seen = result.outcomes(range(count), threads=resolve_threads(threads))
    draw = _draw(result.spec)
    starts = content_of_starts(result.starts(range(count))) if draw is None else {"draw": draw}
    if saved_as is None:
        saved_as = "map.npz" if target is None else target.with_suffix(".npz").name
    held = content_of_map(result, count, load=_load(os.fspath(saved_as), result.spec))
    page = page_of(held | starts | content_of_outcomes(seen))
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


def page_of(content: dict[str, Any] | None) -> str:
    """The page of a map; without content, the page that waits for maps."""
    return assembled("explorer.html", ("film.css", "explorer.css"), SCRIPTS, map=content)


def content_of_starts(start: Starts) -> dict[str, Any]:
    """The starts of bodies as plain data."""
    return {
        "omega": _packed(start.omega, np.float64),
        "attitude": _packed(start.attitude, np.float64),
    }


def content_of_outcomes(seen: Outcomes) -> dict[str, Any]:
    """The outcomes of bodies as plain data."""
    outcome = np.full(seen.outcome.shape, len(CLASSES), dtype=np.uint8)
    for code, name in enumerate(CLASSES):
        outcome[seen.outcome == name] = code
    return {
        "outcome": _packed(outcome, np.uint8),
        "left": _packed(seen.left, np.float32),  # the page shows four digits
    }


def content_of_map(
    result: StabilityMap,
    count: int,
    *,
    load: str = "",
    python: str = "result",
    whole: MapSpec | None = None,
) -> dict[str, Any]:
    """A map as plain data, without the bodies.

    Parameters
    ----------
    result : StabilityMap
    count : int
        Bodies of each pixel that the page has.
    load : str
        Python code that makes the map, in front of the code of a body.
    python : str
        The name of the map in the Python code of a body.
    whole : MapSpec, optional
        The map that this one is a finer part of: its axes say which scales are logarithmic.
    """
    spec = result.spec
    theory = result.theory()
    shape = spec.shape if len(spec.shape) > 1 else (1, *spec.shape)
    is_regular = isinstance(spec.stable, Regular)
    asks = "criterion" if is_regular else "stable"
    return {
        "title": spec.title or default_title(spec),
        "load": load,
        "python": python,
        "detail": f"{asks}: {spec.criterion}; {spec.samples} bodies per pixel"
        + ("" if spec.half_width is None else " at most"),
        "complete": result.complete,
        "shape": shape,
        "dimensions": len(spec.shape),
        "axes": [
            _axis(axis, drawn.geometric)
            for axis, drawn in zip(spec.axes, (whole or spec).axes, strict=True)
        ],
        "layers": _layers(result),
        "status": _packed(result.status, np.uint8),
        "statuses": STATUS,
        "counts": {
            name: _packed(getattr(result, name), np.int32) for name in ("samples", *CLASSES)
        },
        "curves": []
        if theory is None
        else [
            {"label": _plain_words(curve.label), "field": _packed(curve.field, np.float32)}
            for curve in theory.curves
        ],
        "samples": count,
        "of": spec.samples,
        "classes": CLASSES,
        "words": class_words(spec),
        "leaves": not is_regular,
        "horizon": _packed(spec.horizons, np.float64),
        "motion": _motion(spec),
        "charts": [
            chart | {"limits": [_packed(limits, np.float64) for limits in of_chart]}
            for chart, of_chart in watched(spec)
        ],
        "scene": spec.scene.title,
        "inks": {
            "outcomes": colours.OUTCOMES,
            "axes": [ink.colour for ink in colours.AXES],
            "body": colours.FACE,
            "space": colours.SPACE.colour,
            "omega": colours.OMEGA.colour,
            "L": colours.L.colour,
            "vertical": colours.VERTICAL.colour,
        },
        "camera": [AZIMUTH, ELEVATION],
    }


def _affordable(result: StabilityMap) -> int:
    """The number of bodies per pixel that fit into a page."""
    # Times of leaving are hardly compressed, and a class takes two bits at most.
    done = max(int(result.samples.sum()), 1)
    size = result.status.size * (4.0 * int(result.unstable.sum()) / done + 0.25)
    if _draw(result.spec) is None:
        first = result.starts(0)
        size += len(_compressed(first.omega)) + len(_compressed(first.attitude))
    return int(max(1, min(MOST_BYTES // size, MOST_SAMPLES, result.spec.samples)))


def _draw(spec: MapSpec) -> dict[str, Any] | None:
    """What ``page/draw.js`` draws the starts from; None if it lacks a distribution of this map."""
    start = spec.start
    if isinstance(start, Mixture) or isinstance(start.noise, Samples) or start.joint:
        return None
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
        "numbers": _packed(numbers, np.int32),
        **{name: _packed(getattr(grid, name), np.float64) for name in columns},
    }


def _axis(axis: Axis, geometric: bool) -> dict[str, Any]:
    return {
        "name": _plain_words(axis.parameter.symbol),
        "label": _plain_words(axis.label),
        "unit": "" if axis.unit == "1" else axis.unit,
        "values": list(axis.values),
        "edges": drawn_edges(axis, geometric).tolist(),
        "geometric": geometric,
    }


def drawn_edges(axis: Axis, geometric: bool) -> NDArray[np.float64]:
    """The borders of the cells of an axis as the page draws them; logarithms where geometric."""
    edges = cell_edges(axis)
    return np.log(edges) if geometric else edges


def _layers(result: StabilityMap) -> list[dict[str, Any]]:
    """The quantities to draw, with the ranges of their colours; empty ones are omitted."""
    done = np.where(result.samples > 0, result.samples, np.nan).astype(np.float64)
    shares: dict[str, ArrayLike] = {
        "share": result.filled,
        "lower": result.lower,
        "upper": result.upper,
        "undecided": result.undecided / done,
        "failed": result.failed / done,
    }
    is_regular = isinstance(result.spec.stable, Regular)
    first = "a body was found chaotic" if is_regular else "a body left"
    values: dict[str, tuple[str, ArrayLike, bool]] = {
        "earliest": (f"earliest time at which {first} (s)", result.earliest, False),
        "energy_drift": ("worst drift of the energy", result.energy_drift, True),
        "momentum_drift": ("worst drift of the momentum", result.momentum_drift, True),
        "unit_drift": ("worst drift of unit lengths", result.unit_drift, True),
    }
    if is_regular:
        values["exponent"] = ("mean exponent (1/s)", result.exponent, False)
        values["largest_exponent"] = ("largest exponent (1/s)", result.largest_exponent, False)
        values["mean_megno"] = ("mean MEGNO", result.mean_megno, False)
    for name, measured in result.measures.items():
        unit = "" if measured.measure.unit == "1" else f" ({measured.measure.unit})"
        for of in ("mean", "least", "largest"):
            label = f"{measured.measure.words}{unit}, {of} of the pixel"
            values[f"{name}.{of}"] = (label, getattr(measured, of), False)
    words = {
        "share": "share regular" if is_regular else "share stable",
        "lower": "lower end of the 95 % interval",
        "upper": "upper end of the 95 % interval",
        "undecided": "share undecided",
        "failed": "share failed",
    }
    layers = [
        {"name": name, "label": words[name], "low": 0.0, "high": 1.0, "log": False}
        | {"data": _packed(np.asarray(array), np.float32)}
        for name, array in shares.items()
    ]
    for name, (label, given, log) in values.items():
        array = np.array(given, dtype=np.float64)
        array[~np.isfinite(array) | (log & (array <= 0.0))] = np.nan
        known = array[np.isfinite(array)]
        if not known.size:
            continue
        low, high = float(known.min()), float(known.max())
        layers.append(
            {"name": name, "label": label, "low": low, "high": high, "log": log}
            | {"data": _packed(array, np.float32)}
        )
    return layers


def _motion(spec: MapSpec) -> dict[str, Any] | None:
    """The numbers of the equations of motion of each pixel; None if the page cannot solve them."""
    grid = spec.grid
    if spec.whole.torque is not None or not {*spec.forces} <= {"torque", "damping"}:
        return None
    count, torque = len(grid.moments), grid.scene.torque
    in_body = np.zeros((count, 3)) if torque is None else np.asarray(torque.in_body)[:, 0]
    columns = (grid.moments, grid.weight, grid.damping.reshape(-1, 9), in_body)
    return {"numbers": _packed(np.concatenate(columns, axis=1), np.float64)}


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


def _compressed(array: NDArray[Any]) -> bytes:
    """Little-endian bytes, deflated. Bytes of equal weight stand together: they repeat more."""
    little = np.ascontiguousarray(array, dtype=array.dtype.newbyteorder("<"))
    planes = little.reshape(-1).view(np.uint8).reshape(-1, little.dtype.itemsize).T
    return zlib.compress(np.ascontiguousarray(planes).tobytes(), 9)


def _packed(array: ArrayLike, dtype: Any) -> dict[str, Any]:
    """An array for ``unpacked`` of the page."""
    plain = np.asarray(array).astype(dtype)
    return {
        "type": plain.dtype.name,
        "data": base64.b64encode(_compressed(plain)).decode(),
    }
