"""Scene, start and criterion from the tables of a TOML file."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial, reduce
from inspect import Parameter, signature
from itertools import chain
from operator import and_, or_
from typing import Any

from .._checks.arguments import finite_float
from ..model.body import Body
from ..model.criteria import CRITERIA, Criterion
from ..model.forces import FORCES
from ..model.measures import asks_for_an_axis
from ..model.mixture import Mixture, mixture
from ..model.orbit import Orbit
from ..model.scene import SCENES, FreeBody, Scene
from ..model.start import NOISE_KINDS, Noise, Start, von_mises_fisher
from ..model.torque import Torque
from .toml_keys import FREE_SCENE, NOISE, ORBIT, SCENE, START
from .toml_table import Table, as_is, three

__all__ = ["read_criterion", "read_scene", "read_start", "read_starts"]

MOST_DEPTH = 16
"""Most levels of joined criteria: at most eight criteria can be joined."""

_JOINS: Mapping[str, Callable[[Criterion, Criterion], Criterion]] = {"all": and_, "any": or_}
"""The operation that joins the criteria of a list."""

_KINDS = {scene.title.replace(" ", "-"): scene for scene in SCENES.values()}


def read_scene(table: Table) -> Scene:
    """The scene of a table ``[scene]``."""
    if "kind" not in table:
        table.only(*SCENE, *FREE_SCENE)
    scene = _KINDS[table.choice("kind", _KINDS)]
    others = {name for kind in SCENES.values() for name in kind.fields} - {*scene.fields}
    others |= set() if scene is FreeBody else {*FREE_SCENE}
    table.only(*(key for key in (*SCENE, *FREE_SCENE) if key not in others))
    body = _body(table)
    own: dict[str, Any] = {}
    for name, field in scene.fields.items():
        convert = finite_float if field.width == 1 else three
        if name in table or field.default is None:
            own[name] = table.take(name, convert)
    acting = {**_torque_and_damping(table), **_further(table)}
    return table.build(lambda: scene(body, **own, **acting))  # type: ignore[call-arg]


def _further(table: Table) -> dict[str, Any]:
    """The further forces that are given."""
    return {name: _made(table, name) for name in FORCES if name in table}


def _made(table: Table, name: str) -> Any:
    if name == "orbit":
        orbit = table.table(name)
        orbit.only(*ORBIT)
        given = {
            key: orbit.take(key, three if key in ("normal", "periapsis") else finite_float)
            for key in ORBIT
            if key == "rate" or key in orbit
        }
        return orbit.build(lambda: Orbit(**given))
    data = table.take(name, as_is)
    return table.build(lambda: FORCES[name].of_data(data))


def _torque_and_damping(table: Table) -> dict[str, Any]:
    """Constant torques and damping, as far as they are given."""
    torque: Torque | None = None
    for key, make in (("torque", Torque.body), ("torque_in_space", Torque.space)):
        if key in table:
            part = make(table.take(key, as_is))
            torque = part if torque is None else torque + part
    return {"torque": torque, "damping": table.take("damping", as_is, default=None)}


def _body(table: Table) -> Body:
    if ("moments" in table) == ("box" in table):
        raise table.error("needs either 'moments' or 'box' (with 'mass')")
    if "moments" in table:
        if "mass" in table:
            raise table.error("mass: belongs to a box; omit the mass beside moments")
        moments = table.take("moments", three)
        physical = table.take("physical", as_is, default=True)
        return table.build(lambda: Body(moments, physical=physical))
    a, b, c = table.take("box", three)
    mass = table.take("mass", finite_float, default=1.0)
    return table.build(lambda: Body.box(a, b, c, mass=mass))


def read_starts(document: Table, axes: list[str]) -> Start | Mixture:
    """The start of a table ``[start]``, or the mixture of several tables ``[[start]]``.

    Fields that an axis of the map sets may be omitted.
    """
    if not document.is_list("start"):
        return read_start(document.table("start"), axes)
    tables = document.tables("start")
    starts = [read_start(table, axes, "weight") for table in tables]
    weights = [table.take("weight", finite_float, default=1.0) for table in tables]
    return document.build(lambda: mixture(starts, weights))


def read_start(table: Table, axes: list[str], *more: str) -> Start:
    """The start of one table, which may have further keys."""
    table.only(*(key for key in START if key != "weight"), *more)
    omega = table.take("omega", three, default=None)
    spin = table.take(
        "spin", finite_float, default=0.0 if "spin" in axes and omega is None else None
    )
    if omega is None and spin is None:
        rates = [name for name in axes if name in ("omega1", "omega2", "omega3")]
        if rates:
            raise table.error(
                f"needs the key 'omega': the axis {rates[0]} varies a component of it"
            )
        raise table.error("needs the key 'omega' or 'spin'")
    axis = table.take("axis", as_is, default=3)
    tilt = table.take("tilt", finite_float, default=0.0)
    attitude = table.take("attitude", as_is, default=None)
    noise, attitude_noise = (
        _noise(table.table(name), name in axes, kappa in axes) if name in table else None
        for name, kappa in (("noise", "kappa"), ("attitude_noise", "attitude_kappa"))
    )
    return table.build(
        lambda: Start(
            omega=omega,
            spin=spin,
            axis=axis,
            tilt=tilt,
            attitude=attitude,
            noise=noise,
            attitude_noise=attitude_noise,
        )
    )


def _noise(table: Table, on_axis: bool, kappa_on_axis: bool) -> Noise:
    if "kind" not in table:
        table.only(*NOISE)
    kind = table.choice("kind", NOISE_KINDS)
    if kind == "uniform_attitude":
        table.only("kind")
        return Noise(kind)
    if kind == "von_mises_fisher":
        table.only("kind", "kappa")
        if kappa_on_axis:
            if "kappa" in table:
                raise table.error("kappa: an axis of the map sets kappa; omit the key here")
            return Noise(kind, 0.0)
        return table.build(lambda: von_mises_fisher(table.take("kappa", as_is)))
    table.only(*(key for key in NOISE if key != "kappa"))
    if "cov" in table:
        if "size" in table:
            raise table.error("size, cov: give one of the two")
        return table.build(lambda: Noise(kind, cov=table.take("cov", as_is)))
    if on_axis:
        if "size" in table:
            raise table.error("size: an axis of the map sets the size; omit the key here")
        return Noise(kind, 0.0)
    return table.build(lambda: Noise(kind, table.take("size", as_is)))


def read_criterion(table: Table, scene: Scene, start: Start) -> Criterion:
    """The criterion of a table ``[stable]``, with its defaults resolved."""
    criterion = _criterion(table)
    resolved = table.build(lambda: criterion.resolved(scene, start))
    # The map knows the bodies of all pixels, of which a default axis follows.
    return criterion if asks_for_an_axis(criterion) else resolved


def _joined(join: Callable[[Criterion, Criterion], Criterion], parts: list[Criterion]) -> Criterion:
    return reduce(join, parts)


def _criterion(table: Table, depth: int = 1) -> Criterion:
    """One criterion, or the joined criteria under ``all``, ``any`` or ``not``."""
    if depth > MOST_DEPTH:
        raise table.error(f"criteria are joined more than {MOST_DEPTH} deep")
    for key, join in _JOINS.items():
        if key in table:
            table.only(key)
            parts = [_criterion(part, depth + 1) for part in table.tables(key)]
            if len(parts) < 2:
                raise table.error(f"{key}: joins two criteria or more")
            return table.build(partial(_joined, join, parts))
    if "not" in table:
        table.only("not")
        part = _criterion(table.table("not"), depth + 1)
        return table.build(lambda: ~part)
    if "criterion" not in table:
        every = (signature(criterion).parameters for criterion in CRITERIA.values())
        table.only(*dict.fromkeys(("criterion", *_JOINS, "not", *chain(*every))))
    criterion = CRITERIA[table.choice("criterion", CRITERIA)]
    parameters = signature(criterion).parameters
    table.only("criterion", *parameters)
    values = {
        name: table.take(name, as_is)
        for name, parameter in parameters.items()
        if name in table or parameter.default is Parameter.empty
    }
    return table.build(lambda: criterion(**values))
