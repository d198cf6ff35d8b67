"""Specifications of maps in TOML, the built-in ones and the user's own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal, localcontext
from functools import partial
from inspect import Parameter, signature

from .._checks.arguments import brief, finite_float, one_of, positive_int
from ..maps.parameters import (
    MOST_AXES,
    PARAMETERS,
    Axis,
    axis_letter,
    check_applicable,
    make_axes,
)
from ..maps.sequential import checked_half_width, stop_table
from ..maps.spec import MapSpec
from ..model import measures
from ..model.measures import MEASURES, Measure
from ..model.seed import checked_seed, seed_from
from ..solve.methods import known_method, map_methods
from .toml_keys import AXIS, MAP, MAP_RUN
from .toml_scene import read_criterion, read_scene, read_starts
from .toml_table import BUILTIN, Table, as_is, names_in, parsed, read_source, text

__all__ = ["MAPS", "NamedSpec", "builtin_names", "parse_spec", "read_spec"]

MAPS = BUILTIN
"""The folder of the built-in maps."""

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


def builtin_names() -> list[str]:
    """Names of the built-in maps, sorted."""
    return names_in(MAPS)


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
    name, content, file = read_source(source, "map", MAPS)
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
    document.only(*dict.fromkeys((*MAP, *letters[: len(given) + 1])))
    scene = read_scene(document.table("scene"))
    axes = _axes([document.table(letter) for letter in letters[: max(1, len(given))]])
    start = read_starts(document, [axis.name for axis in axes])
    for one in start.starts:
        document.build(partial(check_applicable, scene, one, axes))
    stable = read_criterion(document.table("stable"), scene, start.starts[0])
    run = document.table("run")
    run.only(*MAP_RUN)
    half_width = run.take("half_width", _half_width, default=None)
    if half_width is not None and "samples" in run:
        raise run.error("samples, half_width: give one of the two")
    # The longest horizon of an axis follows from its values.
    longest = {"default": 1.0} if "t_end" in (axis.name for axis in axes) else {}
    return run.build(
        lambda: MapSpec(
            scene=scene,
            start=start,
            axes=axes,
            stable=stable,
            t_end=run.take("t_end", finite_float, **longest),
            samples=run.take("samples", positive_int)
            if half_width is None
            else stop_table(half_width).last,
            half_width=half_width,
            refine=run.take("refine", positive_int, default=None),
            budget=run.take("budget", positive_int, default=None),
            method=run.take("method", _method, default=MapSpec.method),
            step=run.take("step", finite_float, default=MapSpec.step),
            check=run.take("check", finite_float, default=MapSpec.check),
            max_steps=run.take("max_steps", positive_int, default=MapSpec.max_steps),
            seed=seed_from(run.take("seed", checked_seed, default=None)),
            measure=run.take("measure", _measures, default=()),
            title=document.take("title", text, default=None),
        )
    )


def _measures(key: str, value: object) -> tuple[Measure, ...]:
    """The measures of a list of names and of tables with a name."""
    if not isinstance(value, list):
        raise TypeError(f"{key} = {brief(value)}: must be a list of names or of tables")
    return tuple(_measure(f"{key}[{place}]", one) for place, one in enumerate(value))


def _measure(key: str, value: object) -> Measure:
    table = {"name": value} if isinstance(value, str) else value
    if not isinstance(table, dict) or "name" not in table:
        raise TypeError(f"{key} = {brief(value)}: must be a name, or a table with a name")
    name = one_of(f"{key}.name", table["name"], MEASURES)
    make = getattr(measures, name)
    options = {option: given for option, given in table.items() if option != "name"}
    known = signature(make).parameters
    for option in options:
        if option not in known:
            has = f"has {' and '.join(known)}" if known else "has no options"
            raise ValueError(f"{key}.{option}: {name} {has}")
    for option, parameter in known.items():
        if parameter.default is Parameter.empty and option not in options:
            raise ValueError(f"{key}: {name} needs {option}")
    found: Measure = make(**options)
    return found


def _method(key: str, value: object) -> str:
    return known_method(key, value, map_methods())


def _half_width(_key: str, value: object) -> float:
    return checked_half_width(value)


def _axes(tables: list[Table]) -> tuple[Axis, ...]:
    axes = tuple(_axis(table) for table in tables)
    if len({axis.name for axis in axes}) < len(axes):
        names = [axis.name for axis in axes]
        place = next(place for place, name in enumerate(names) if name in names[:place])
        first = axis_letter(names.index(names[place]))
        raise tables[place].error(f"name = {names[place]!r}: the axis [{first}] has this name")
    return axes


def _axis(table: Table) -> Axis:
    table.only(*AXIS)
    name = table.choice("name", PARAMETERS)
    known_as = f"axes[{name!r}]"
    known = {known_as: "values"}
    if "values" in table:
        table.only("name", "values")
        values = table.take("values", as_is)
    else:
        number = partial(finite_float, unit=PARAMETERS[name].unit)
        first, last = table.take("from", number), table.take("to", number)
        count = table.take("count", _count)
        logarithmic = table.choice("scale", ("linear", "log"), default="linear") == "log"
        if logarithmic and not (first > 0.0 and last > 0.0):
            raise table.error(f"scale = 'log': the ends must be positive, got {first} and {last}")
        if first == last:
            raise table.error(f"from = {first:g}, to = {last:g}: must differ")
        values = _spaced(first, last, count, logarithmic)
        known |= {f"{known_as}[0]": "from", f"{known_as}[{count - 1}]": "to"}
    try:
        return make_axes({name: values})[0]
    except (OverflowError, TypeError, ValueError) as error:
        message = str(error)
        for of_python, of_file in reversed(known.items()):
            message = message.replace(of_python, of_file)
        raise table.error(message) from None


def _count(key: str, value: object) -> int:
    count = positive_int(key, value, minimum=2)
    if count > MOST_VALUES:
        raise ValueError(f"{key} = {count}: must be at most {MOST_VALUES}")
    return count


def _spaced(first: float, last: float, count: int, logarithmic: bool) -> list[float]:
    """Evenly spaced values, correctly rounded so that they are the same on every machine."""
    with localcontext() as context:
        context.prec = 40
        begin, end = Decimal(first), Decimal(last)
        if logarithmic:
            begin, end = begin.ln(), end.ln()
        exact = [begin + (end - begin) * i / (count - 1) for i in range(1, count - 1)]
        inner = [float(value.exp() if logarithmic else value) for value in exact]
    return [first, *inner, last]
