"""Specifications of maps and reports in TOML, the built-in ones and the user's own.

Every mistake is one line that names the file, the place in it, and the nearest valid name.
"""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal, localcontext
from importlib import resources
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any, TypeVar

from numpy.typing import ArrayLike

from ._check import finite_float, nearest, one_of, positive_int, vector
from .bodies import Body
from .criteria import Criterion, NoFlip, TiltBelow
from .forces import Torque
from .grid import PARAMETERS, Axis, check_applicable, make_axes, pixels
from .mapspec import MAX_STEPS, MapSpec, checked_seed, seed_from
from .methods import AUTO, map_methods
from .reportspec import ERRORS, ReportSpec, make_spec
from .scenes import FreeBody, HeavyTop, Scene
from .starts import NOISE_KINDS, Noise, Start

__all__ = [
    "NamedReport",
    "NamedSpec",
    "SpecError",
    "builtin_names",
    "parse_report",
    "parse_spec",
    "read_report",
    "read_spec",
    "report_names",
]

_T = TypeVar("_T")
_BUILTIN = resources.files("rigid") / "builtin"
_BUILTIN_REPORTS = _BUILTIN / "reports"


class SpecError(ValueError):
    """A specification cannot be used; the message is one line that tells the place."""


@dataclass(frozen=True, slots=True)
class NamedSpec:
    """A specification with its name: that of the built-in map, or the stem of the file."""

    name: str
    spec: MapSpec


@dataclass(frozen=True, slots=True)
class NamedReport:
    """The specification of a report with its name and the horizon of its long version."""

    name: str
    spec: ReportSpec
    t_end_long: float


def builtin_names() -> list[str]:
    """Names of the built-in maps, sorted."""
    return _names(_BUILTIN)


def read_spec(source: str) -> NamedSpec:
    """Read a built-in map by its name, or a file by its path.

    Parameters
    ----------
    source : str
        A path if it ends in ``.toml`` or holds a directory separator, else a name.

    Returns
    -------
    NamedSpec

    Raises
    ------
    SpecError
        If there is no such map or file, or something in it is wrong.

    Examples
    --------
    >>> from rigid.specfile import read_spec
    >>> read_spec("thrown-box").spec.samples
    64
    """
    name, text, file = _read(source, "map", _BUILTIN)
    return NamedSpec(name, parse_spec(text, file))


def report_names() -> list[str]:
    """Names of the built-in reports, sorted."""
    return _names(_BUILTIN_REPORTS)


def read_report(source: str, *, methods: Sequence[str] | None = None) -> NamedReport:
    """Read a built-in report by its name, or a file by its path; as :func:`read_spec`.

    Examples
    --------
    >>> from rigid.specfile import read_report
    >>> read_report("lagrange-top").spec.scene.mgl
    1.0
    """
    name, text, file = _read(source, "report", _BUILTIN_REPORTS)
    return parse_report(name, text, file, methods)


def _names(folder: Traversable) -> list[str]:
    names = (entry.name for entry in folder.iterdir())
    return sorted(name.removesuffix(".toml") for name in names if name.endswith(".toml"))


def _read(source: str, what: str, folder: Traversable) -> tuple[str, str, str]:
    """Name, text and file name of a specification."""
    path = Path(source)
    if path.suffix != ".toml" and path.name == source:
        names = _names(folder)
        if source not in names:
            raise SpecError(
                f"no built-in {what} is called {source!r}{nearest(source, names)} "
                f"(known: {', '.join(names)}; a file ends in .toml)"
            )
        return source, (folder / f"{source}.toml").read_text(encoding="utf-8"), f"{source}.toml"
    try:
        return path.stem, path.read_text(encoding="utf-8"), path.name
    except OSError as error:
        raise SpecError(f"{source}: cannot be read: {error.strerror}") from None
    except UnicodeDecodeError:
        raise SpecError(f"{source}: is not UTF-8 text") from None


def parse_spec(text: str, file: str) -> MapSpec:
    """The specification that a TOML text describes; ``file`` names it in messages.

    Raises
    ------
    SpecError
        See :func:`read_spec`.
    """
    content = _parsed(text, file)
    document = _Table(file, "", content)
    document.only("title", "scene", "x", "y", "start", "stable", "run")
    scene = _scene(document.table("scene"))
    axes = _axes([document.table(letter) for letter in "xy" if letter == "x" or "y" in content])
    names = [axis.name for axis in axes]
    start = _start(document.table("start"), names)
    document.build(lambda: check_applicable(scene, start, axes))
    stable = _criterion(document.table("stable"), scene, start)
    run = document.table("run")
    run.only("t_end", "samples", "method", "step", "check", "max_steps", "seed")
    return run.build(
        lambda: MapSpec(
            scene=scene,
            start=start,
            axes=axes,
            stable=stable,
            t_end=run.take("t_end", finite_float),
            samples=run.take("samples", positive_int),
            method=run.choice("method", map_methods(), default=AUTO),
            step=run.take("step", finite_float, default=None),
            check=run.take("check", finite_float, default=1.0),
            max_steps=run.take("max_steps", positive_int, default=MAX_STEPS),
            seed=seed_from(run.take("seed", checked_seed, default=None)),
            title=document.take("title", _text, default=None),
        )
    )


def parse_report(
    name: str, text: str, file: str, methods: Sequence[str] | None = None
) -> NamedReport:
    """The report that a TOML text describes; ``methods`` replaces those of the text."""
    document = _Table(file, "", _parsed(text, file))
    document.only("title", "scene", "start", "run")
    scene = _scene(document.table("scene"))
    nominal = document.table("start")
    nominal.only("omega", "spin", "axis", "tilt")
    start = _start(nominal, [])
    run = document.table("run")
    run.only("t_end", "t_end_long", "unit", "bodies", "errors", "seed", "methods")
    row = document.build(lambda: pixels(scene, start, ()))
    t_end = run.take("t_end", finite_float)
    spec = run.build(
        lambda: make_spec(
            scene,
            row.omega[0],
            row.attitude[0],
            t_end=t_end,
            methods=run.take("methods", _as_is, default=None) if methods is None else methods,
            bodies=run.take("bodies", positive_int, default=64),
            errors=run.take("errors", _as_is, default=ERRORS),
            seed=run.take("seed", checked_seed, default=0),
            unit=run.take("unit", _text, default="s"),
            title=document.take("title", _text, default=None),
        )
    )
    return NamedReport(name, spec, run.take("t_end_long", _positive, default=t_end))


def _parsed(text: str, file: str) -> dict[str, Any]:
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise SpecError(f"{file}: is not valid TOML: {error}") from None


_REQUIRED: Any = object()


class _Table:
    """A table of a file; whatever is wrong with it is reported with its place."""

    __slots__ = ("_file", "_name", "_values")

    def __init__(self, file: str, name: str, values: Mapping[str, Any]) -> None:
        self._file, self._name, self._values = file, name, values

    def __contains__(self, key: str) -> bool:
        return key in self._values

    def error(self, text: str) -> SpecError:
        place = f"{self._file}: [{self._name}]" if self._name else f"{self._file}:"
        return SpecError(f"{place} {text}")

    def only(self, *known: str) -> None:
        """Raise for a key that is not known."""
        for key in self._values:
            if key not in known:
                raise self.error(
                    f"unknown key {key!r}{nearest(key, known)} (known: {', '.join(known)})"
                )

    def take(self, key: str, convert: Callable[[str, Any], _T], *, default: Any = _REQUIRED) -> Any:
        """The value of a key as ``convert(key, value)``."""
        if key not in self._values:
            if default is _REQUIRED:
                raise self.error(f"needs the key {key!r}")
            return default
        return self.build(lambda: convert(key, self._values[key]))

    def choice(self, key: str, known: Iterable[str], *, default: Any = _REQUIRED) -> str:
        """One of the known words."""
        word: str = self.take(key, lambda name, value: one_of(name, value, known), default=default)
        return word

    def table(self, key: str) -> _Table:
        """The table under a key."""
        values: Mapping[str, Any] = self.take(key, _mapping)
        return _Table(self._file, f"{self._name}.{key}" if self._name else key, values)

    def build(self, make: Callable[[], _T]) -> _T:
        """``make()``, with its complaints put in place."""
        try:
            return make()
        except SpecError:
            raise
        except (OverflowError, TypeError, ValueError) as error:
            raise self.error(str(error)) from None


def _as_is(_key: str, value: object) -> Any:
    """For values that the constructor they go to checks by itself."""
    return value


def _text(key: str, value: object) -> str:
    if not isinstance(value, str):
        raise TypeError(f"{key} = {value!r}: must be a string")
    return value


def _mapping(key: str, value: object) -> Mapping[str, Any]:
    if not isinstance(value, dict):
        raise TypeError(f"{key} = {value!r}: must be a table")
    return value


def _positive(key: str, value: object) -> float:
    return finite_float(key, value, positive=True)


def _three(key: str, value: ArrayLike) -> tuple[float, float, float]:
    first, second, third = vector(key, value, 3).tolist()
    return first, second, third


def _scene(table: _Table) -> Scene:
    kind = table.choice("kind", ("free-body", "heavy-top"))
    shape = ("moments", "box", "mass")
    forces = ("torque", "torque_in_space", "damping")
    if kind == "free-body":
        table.only("kind", *shape, *forces)
        body = _body(table)
        return table.build(lambda: FreeBody(body, **_forces(table)))
    table.only("kind", *shape, "mgl", "com", *forces)
    body = _body(table)
    mgl = table.take("mgl", finite_float)
    com = table.take("com", _three, default=(0.0, 0.0, 1.0))
    return table.build(lambda: HeavyTop(body, mgl=mgl, com=com, **_forces(table)))


def _forces(table: _Table) -> dict[str, Any]:
    """Constant torques in the body and in space, and damping, as far as they are given."""
    torque: Torque | None = None
    for key, make in (("torque", Torque.body), ("torque_in_space", Torque.space)):
        if key in table:
            part = make(table.take(key, _as_is))
            torque = part if torque is None else torque + part
    return {"torque": torque, "damping": table.take("damping", _as_is, default=None)}


def _body(table: _Table) -> Body:
    if ("moments" in table) == ("box" in table):
        raise table.error("needs either 'moments' or 'box' (with 'mass')")
    if "moments" in table:
        if "mass" in table:
            raise table.error("mass belongs to a box; the moments need none")
        moments = table.take("moments", _three)
        return table.build(lambda: Body(moments))
    a, b, c = table.take("box", _three)
    mass = table.take("mass", finite_float, default=1.0)
    return table.build(lambda: Body.box(a, b, c, mass=mass))


def _axes(tables: list[_Table]) -> tuple[Axis, ...]:
    axes = tuple(_axis(table) for table in tables)
    if len({axis.name for axis in axes}) < len(axes):
        raise tables[-1].error(f"name = {axes[-1].name!r}: is already that of [x]")
    return axes


def _axis(table: _Table) -> Axis:
    table.only("name", "values", "from", "to", "count", "scale")
    name = table.choice("name", PARAMETERS)
    if "values" in table:
        table.only("name", "values")
        values = table.take("values", _as_is)
    else:
        first, last = table.take("from", finite_float), table.take("to", finite_float)
        count = table.take("count", lambda key, value: positive_int(key, value, minimum=2))
        logarithmic = table.choice("scale", ("linear", "log"), default="linear") == "log"
        if logarithmic and not (first > 0.0 and last > 0.0):
            raise table.error(f"scale = 'log': the ends must be positive, got {first} and {last}")
        values = _spaced(first, last, count, logarithmic)
    return table.build(lambda: make_axes({name: values}))[0]


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


def _start(table: _Table, axes: list[str]) -> Start:
    table.only("omega", "spin", "axis", "tilt", "noise", "attitude_noise")
    omega = table.take("omega", _three, default=None)
    spin = table.take("spin", finite_float, default=0.0 if "spin" in axes else None)
    axis = table.take("axis", _as_is, default=3)
    tilt = table.take("tilt", finite_float, default=0.0)
    noise, attitude_noise = (
        _noise(table.table(name), name in axes) if name in table else None
        for name in ("noise", "attitude_noise")
    )
    return table.build(
        lambda: Start(
            omega=omega,
            spin=spin,
            axis=axis,
            tilt=tilt,
            noise=noise,
            attitude_noise=attitude_noise,
        )
    )


def _noise(table: _Table, on_axis: bool) -> Noise:
    kind = table.choice("kind", NOISE_KINDS)
    if kind == "uniform_attitude":
        table.only("kind")
        return Noise(kind)
    table.only("kind", "size")
    if on_axis:
        if "size" in table:
            raise table.error("size is that of the axis; leave it out here")
        return Noise(kind, 0.0)
    return table.build(lambda: Noise(kind, table.take("size", _as_is)))


def _criterion(table: _Table, scene: Scene, start: Start) -> Criterion:
    if table.choice("criterion", ("no_flip", "tilt_below")) == "no_flip":
        table.only("criterion", "axis")
        axis = table.take("axis", _as_is, default=None)
        return table.build(lambda: NoFlip(axis).resolved(scene, start))
    table.only("criterion", "angle", "axis", "reference")
    angle = table.take("angle", finite_float)
    axis = table.take("axis", _as_is, default=3)
    reference = table.take("reference", _as_is, default=None)
    return table.build(lambda: TiltBelow(angle, axis, reference).resolved(scene, start))
