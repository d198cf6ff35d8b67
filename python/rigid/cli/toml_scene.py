"""Scene, start and criterion from the tables of a TOML file."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from functools import partial, reduce
from inspect import Signature, signature
from operator import add, and_, or_
from typing import Any

from numpy.typing import ArrayLike

from .._checks.arguments import finite_float, vector
from ..model import noise
from ..model.body import Body
from ..model.criterion import CRITERIA, Criterion
from ..model.forces import FORCES
from ..model.mixture import Mixture, mixture
from ..model.noise import NOISE_KINDS, Noise
from ..model.orbit import Orbit
from ..model.sampled import RotorTable
from ..model.scene import SCENES, Scene, check_scene
from ..model.start import Start
from ..model.torque import Torque
from .toml_table import Table, keys

MOST_DEPTH = 16
"""Most levels of joined criteria: at most eight criteria can be joined."""

_JOINS: Mapping[str, Callable[[Criterion, Criterion], Criterion]] = {"all": and_, "any": or_}
"""The operation that joins the criteria of a list."""

NOISES: Mapping[str, Callable[..., Noise]] = {kind: getattr(noise, kind) for kind in NOISE_KINDS}
"""What the key ``kind`` of a noise names."""


def scene_of_keys(
    scene: type[Scene],
    *,
    moments: ArrayLike | None = None,
    physical: bool = True,
    box: ArrayLike | None = None,
    mass: float | None = None,
    torque: ArrayLike | None = None,
    torque_in_space: ArrayLike | None = None,
    **own: Any,
) -> Scene:
    """A scene of one body, by its class and the keys of a table.

    Parameters
    ----------
    moments : array_like, shape (3,)
        Principal moments of inertia (kg m²), instead of ``box``.
    physical : bool
        Whether a body must be able to have the moments.
    box : array_like, shape (3,)
        Sides (m) of a homogeneous box along axes 1, 2, 3.
    mass : float
        Mass (kg) of the box, by default 1.
    torque : array_like, shape (3,), optional
        Constant torque in the body (N m).
    torque_in_space : array_like, shape (3,), optional
        Constant torque in space (N m).
    **own
        The other arguments of the class.
    """
    if (moments is None) == (box is None):
        raise ValueError("needs either 'moments' or 'box' (with 'mass')")
    if box is not None:
        a, b, c = vector("box", box, 3).tolist()
        body = Body.box(a, b, c, mass=1.0 if mass is None else finite_float("mass", mass))
    elif mass is not None:
        raise ValueError("mass: belongs to a box; omit the mass beside moments")
    else:
        assert moments is not None
        body = Body(vector("moments", moments, 3), physical=physical)
    for name, axes in scene.fields.items():
        if not axes and name in own:
            finite_float(name, own[name])
    given = ((Torque.body, torque), (Torque.space, torque_in_space))
    parts = [make(value) for make, value in given if value is not None]
    made: Callable[..., Scene] = scene
    return check_scene(made(body, torque=reduce(add, parts) if parts else None, **own))


def _made_of_keys(scene: type[Scene]) -> Callable[..., Scene]:
    """:func:`scene_of_keys` of a class, with the signature that tells all its keys."""
    make: Any = partial(scene_of_keys, scene)
    every = {**signature(make).parameters, **signature(scene).parameters}
    named = [one for name, one in every.items() if name not in ("own", "body", "frame")]
    make.__signature__ = Signature(named)
    return make  # type: ignore[no-any-return]


KINDS: Mapping[str, Callable[..., Scene]] = {
    scene.title.replace(" ", "-"): _made_of_keys(scene) for scene in SCENES.values()
}
"""What the key ``kind`` of a scene names."""


ORBITS: tuple[Callable[..., Orbit], ...] = Orbit, Orbit.flyby, Orbit.table
"""What makes an orbit of its table."""


def _force(table: Table, key: str) -> Any:
    return FORCES[key].of_data(table[key])


def _orbit(table: Table, key: str) -> Any:
    """The orbit of a table, by the function that takes most of its keys."""
    orbit = table.table(key)
    return orbit.call(max(ORBITS, key=lambda make: len(orbit.keys() & keys(make).keys())))


def _rotor(table: Table, key: str) -> Any:
    given = table[key]
    return table.table(key).call(RotorTable) if isinstance(given, dict) else given


_READ: Mapping[str, Callable[[Table, str], Any]] = {
    **dict.fromkeys(FORCES, _force),
    "orbit": _orbit,
    "rotor": _rotor,
}


def read_scene(table: Table) -> Scene:
    """The scene of a table ``[scene]``."""
    return table.choose("kind", KINDS, read=_READ)


def read_starts(document: Table, axes: Collection[str]) -> Start | Mixture:
    """The start of a table ``[start]``, or the mixture of several tables ``[[start]]``.

    Fields that an axis of the map sets may be omitted.
    """
    if not isinstance(document["start"], list):
        return read_start(document.table("start"), axes)
    tables = document.tables("start")
    starts = [read_start(table, axes, "weight") for table in tables]
    weights = [table.get("weight", 1.0) for table in tables]
    return document.build(lambda: mixture(starts, weights))


def read_start(table: Table, axes: Collection[str], *beside: str, **given: Any) -> Start:
    """The start of one table, which may have further keys ``beside``."""
    defaults: dict[str, Any] = {}
    if "omega" not in table and "spin" in axes:
        defaults["spin"] = 0.0
    noises = {
        "noise": partial(_noise, axes, "kappa"),
        "attitude_noise": partial(_noise, axes, "attitude_kappa"),
    }
    table.only(*beside, *(key for key in keys(Start) if key not in given))
    if not ("omega" in table or "spin" in table or defaults):
        rates = [name for name in axes if name in ("omega1", "omega2", "omega3")]
        if rates:
            raise table.error(
                f"needs the key 'omega': the axis {rates[0]} varies a component of it"
            )
        raise table.error("needs the key 'omega' or 'spin'")
    return table.call(Start, *beside, read=noises, defaults=defaults, **given)


def _noise(axes: Collection[str], kappa: str, table: Table, key: str) -> Noise:
    own = table.table(key)
    varied: dict[str, Any] = {}
    for name, axis, what in (("size", key, "the size"), ("kappa", kappa, "kappa")):
        if axis in axes:
            if name in own:
                raise own.error(f"{name}: an axis of the map sets {what}; omit the key here")
            varied[name] = None if "cov" in own else 0.0
    return own.choose("kind", NOISES, defaults=varied)


def read_criterion(table: Table, depth: int = 1) -> Criterion:
    """The criterion of a table, or the joined criteria under ``all``, ``any`` or ``not``."""
    if depth > MOST_DEPTH:
        raise table.error(f"criteria are joined more than {MOST_DEPTH} deep")
    for key, join in _JOINS.items():
        if key in table:
            table.only(key)
            parts = [read_criterion(part, depth + 1) for part in table.tables(key)]
            if len(parts) < 2:
                raise table.error(f"{key}: joins two criteria or more")
            joined: Criterion = table.build(partial(reduce, join, parts))
            return joined
    if "not" in table:
        table.only("not")
        part = read_criterion(table.table("not"), depth + 1)
        return table.build(lambda: ~part)
    return table.choose("criterion", CRITERIA, *_JOINS, "not")
