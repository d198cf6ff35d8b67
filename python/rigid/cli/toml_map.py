"""Specifications of maps in TOML, the built-in ones and the user's own."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal, localcontext
from functools import partial
from typing import Any

from numpy.typing import ArrayLike

from .._checks.arguments import brief, finite_float, one_of, positive_int
from .._core import __version__
from ..maps.axes import (
    MOST_AXES,
    Axis,
    axis_letter,
    check_applicable,
    make_axes,
)
from ..maps.sequential import checked_half_width, stop_table
from ..maps.spec import MapSpec
from ..maps.vary import Varied, make_varied
from ..model import measures
from ..model.measures import MEASURES, Measure
from ..model.noise import Noise, normal, uniform
from ..model.parameters import PARAMETERS
from ..model.seed import seed_from
from .toml_scene import read_criterion, read_scene, read_starts
from .toml_table import Table, parsed, read_source

MAKES: Mapping[str, Callable[..., Measure]] = {name: getattr(measures, name) for name in MEASURES}
"""The functions that make the measures, by their names."""

VARIATIONS: Mapping[str, Callable[..., Noise]] = {"normal": normal, "uniform": uniform}
"""What the key ``kind`` of a parameter that varies names."""

MOST_VALUES = 100_000
"""Most values of an axis that is given by its ends and a number."""


@dataclass(frozen=True, slots=True)
class NamedSpec:
    """A specification with its name: the name of the built-in map, or the stem of the file.

    Attributes
    ----------
    name : str
    spec : MapSpec
    seeded : bool
        Whether the file has a seed; otherwise the seed was drawn.
    """

    name: str
    spec: MapSpec
    seeded: bool


def read_spec(source: str, changes: Sequence[str] = ()) -> NamedSpec:
    """Read a built-in map by its name, or a file by its path.

    Parameters
    ----------
    source : str
        A path if it ends in ``.toml`` or holds a directory separator, else a name.
    changes : sequence of str
        Keys to replace, such as ``"run.t_end=10"``.

    Returns
    -------
    NamedSpec

    Raises
    ------
    SpecError
        If there is no such map or file, or something in it is wrong.

    Examples
    --------
    >>> from rigid.cli.toml_map import read_spec
    >>> read_spec("thrown-box").spec.samples
    64
    """
    name, content, file = read_source(source, "map")
    spec = parse_spec(content, file, changes)
    return NamedSpec(name, spec, "seed" in parsed(content, file, changes).table("run"))


def parse_spec(content: str, file: str, changes: Sequence[str] = ()) -> MapSpec:
    """The specification that a TOML text describes; ``file`` names it in messages.

    Raises
    ------
    SpecError
        See :func:`read_spec`.
    """
    document = parsed(content, file, changes)
    letters = [axis_letter(place) for place in range(MOST_AXES)]
    given = [letter for letter in letters if letter in document]
    document.only("title", "scene", *letters[: len(given) + 1], "start", "vary", "stable", "run")
    scene = read_scene(document.table("scene"))
    axes = _axes([document.table(letter) for letter in letters[: max(1, len(given))]])
    names = [axis.name for axis in axes]
    start = read_starts(document, names)
    for one in start.starts:
        document.build(partial(check_applicable, scene, one, axes))
    vary = _varied(document.table("vary")) if "vary" in document else ()
    criterion = document.table("stable")
    stable = read_criterion(criterion)
    criterion.build(lambda: stable.resolved(scene, start.starts[0]))
    run = document.table("run")
    defaults: dict[str, Any] = {"seed": seed_from(None)}
    if "t_end" in names:
        defaults["t_end"] = 1.0  # the longest horizon of the axis takes its place
    if "half_width" in run:
        if "samples" in run:
            raise run.error("samples, half_width: give one of the two")
        defaults["samples"] = run.build(
            lambda: stop_table(checked_half_width(run["half_width"])).last
        )
    return run.call(
        MapSpec,
        read={"measure": _measures},
        defaults=defaults,
        scene=scene,
        start=start,
        axes=axes,
        vary=vary,
        stable=stable,
        title=document.text("title"),
        own=None,
        version=__version__,
    )


def _measures(table: Table, key: str) -> tuple[Measure, ...]:
    """The measures of a list of names and of tables with a name."""
    return tuple(one.choose("name", MAKES) for one in table.tables(key, "name"))


def _varied(table: Table) -> tuple[Varied, ...]:
    """The parameters that vary from body to body, each with a table of its distribution."""
    noises = {name: table.table(name).choose("kind", VARIATIONS) for name in table}
    return table.build(lambda: make_varied(noises))


def _axes(tables: list[Table]) -> tuple[Axis, ...]:
    axes = tuple(
        table.call(listed) if "values" in table else table.call(spaced, "values")
        for table in tables
    )
    names = [axis.name for axis in axes]
    for place, name in enumerate(names):
        if name in names[:place]:
            first = axis_letter(names.index(name))
            raise tables[place].error(f"name = {name!r}: the axis [{first}] has this name")
    return axes


def listed(name: str, values: ArrayLike) -> Axis:
    """An axis by its values.

    Parameters
    ----------
    name : str
        The parameter that varies, see below.
    values : array_like, shape (n,)
        Its values, instead of ``from``, ``to`` and ``count``.
    """
    return _axis(one_of("name", name, PARAMETERS), values, {"": "values"})


def spaced(name: str, from_: float, to: float, count: int, scale: str = "linear") -> Axis:
    """An axis by its ends and the number of its values.

    Parameters
    ----------
    name : str
        The parameter that varies, see below.
    from_ : float
        First value.
    to : float
        Last value.
    count : int
        How many values.
    scale : {"linear", "log"}
        Whether differences or ratios of the values are equal.
    """
    unit = PARAMETERS[one_of("name", name, PARAMETERS)].unit
    first, last = finite_float("from", from_, unit=unit), finite_float("to", to, unit=unit)
    if positive_int("count", count, minimum=2) > MOST_VALUES:
        raise ValueError(f"count = {brief(count)}: must be at most {MOST_VALUES}")
    logarithmic = one_of("scale", scale, ("linear", "log")) == "log"
    if logarithmic and not (first > 0.0 and last > 0.0):
        raise ValueError(f"scale = 'log': the ends must be positive, got {first} and {last}")
    if first == last:
        raise ValueError(f"from = {first:g}, to = {last:g}: must differ")
    values = _spaced(first, last, count, logarithmic)
    return _axis(name, values, {"[0]": "from", f"[{count - 1}]": "to", "": "values"})


def _axis(name: str, values: ArrayLike, words: Mapping[str, str]) -> Axis:
    """The axis; ``words`` are the names of its values, by their places, in messages."""
    try:
        return make_axes({name: values})[0]
    except (OverflowError, TypeError, ValueError) as error:
        message = str(error)
        for place, word in words.items():
            message = message.replace(f"axes[{name!r}]{place}", word)
        raise ValueError(message) from None


def _spaced(first: float, last: float, count: int, logarithmic: bool) -> list[float]:
    """Evenly spaced values, correctly rounded so that they are the same on every machine."""
    gaps, inner = count - 1, range(1, count - 1)
    if logarithmic:
        with localcontext() as context:
            context.prec = 40
            begin, end = Decimal(first).ln(), Decimal(last).ln()
            exact = [(begin + (end - begin) * i / gaps).exp() for i in inner]
        return [first, *map(float, exact), last]
    # Over one denominator, because the quotient of two whole numbers is rounded once.
    (a, b), (c, d) = first.as_integer_ratio(), last.as_integer_ratio()
    between = [(a * d * (gaps - i) + b * c * i) / (b * d * gaps) for i in inner]
    return [first, *between, last]
