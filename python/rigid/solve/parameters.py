"""Parameters of a scene by which a motion is differentiated, and their changes in the core."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _core
from .._checks.arguments import brief, of_known
from ..model.forces import FORCES
from ..model.scene import Scene
from .arrays import in_rows
from .bodies import Bodies

Floats = NDArray[np.float64]

_PLACES, _LEN = _core.change_places()
"""Numbers of a change: moments, ``mgl com``, damping 11, 22, 33, 23, 31, 12, and torque in the
body. The numbers of the further forces begin at these places."""

_OF_BODY: dict[str, tuple[int, ...]] = {
    **{f"I{k + 1}": (k,) for k in range(3)},
    "damping": (6, 7, 8),
    **{f"damping{k + 1}": (6 + k,) for k in range(3)},
    **{f"torque{k + 1}": (12 + k,) for k in range(3)},
}
"""The numbers to which a parameter of any scene adds one."""

_OF_FORCE: Mapping[str, tuple[str, tuple[int, ...]]] = {
    f"{force}{axis or ''}": (force, (axis - 1,) if axis else (0, 1, 2))
    for force in ("rotor", "dissipation", "drag")
    for axis in range(4)
    if axis or force != "rotor"
} | {name: ("orbit", (k,)) for k, name in enumerate(("rate", "eccentricity", "anomaly"))}
"""The force, and which of its numbers, of each parameter that a scene has only with the force."""

_OF_WEIGHT = ("mgl", "com1", "com2", "com3")

_GROUPS = {"com": _OF_WEIGHT[1:]}


def check_parameters(tangent: bool | str | Sequence[str], scene: Scene) -> tuple[str, ...] | None:
    """The parameters in the argument ``tangent``: none for True; None for False.

    Raises
    ------
    ValueError
        For an unknown name, one given twice, weight of a scene without weight, or no name.
    """
    if tangent is False:
        return None
    if isinstance(tangent, bool | np.bool_):
        return () if tangent else None
    weight = (*_OF_WEIGHT, *_GROUPS) if "mgl" in scene.fields else ()
    acting = [name for name, (force, _) in _OF_FORCE.items() if force in scene.forces]

    def why_not(name: object) -> str:
        if name in (*_OF_WEIGHT, *_GROUPS):
            return f"a {scene.title} has no weight"
        force = _OF_FORCE.get(name) if isinstance(name, str) else None
        return "is no parameter" if force is None else f"the scene has no {force[0]}"

    known = (*_OF_BODY, *weight, *acting)
    return checked_names("tangent", tangent, known, _GROUPS, why_not, "True, False or ")


def checked_names(
    argument: str,
    given: Any,
    known: Sequence[str],
    groups: Mapping[str, Sequence[str]],
    why_not: Callable[[object], str],
    others: str = "",
) -> tuple[str, ...]:
    """The names of parameters in an argument; a name of a group stands for the names in it.

    Raises
    ------
    ValueError
        For no name, one given twice, or an unknown one, with the reason of ``why_not(name)``;
        ``others`` says what else the argument may be.
    """
    names = (given,) if isinstance(given, str) else given
    # A set has no order, and the columns have one.
    is_ordered = isinstance(names, Sequence | np.ndarray) and not isinstance(names, bytes)
    if not is_ordered or not len(names):
        raise ValueError(f"{argument} = {brief(given)}: must be {others}names of parameters")
    every: list[str] = []
    for name in names:
        if name not in known:
            reason = f"{why_not(name)}{of_known(name, known)}"
            raise ValueError(f"{argument} = {brief(name)}: {reason}")
        for own in groups.get(name, (name,)):
            if own in every:
                raise ValueError(f"{argument} = {brief(given)}: {own!r} is named twice")
            every.append(str(own))
    return tuple(every)


def parameter_changes(
    scene: Scene, bodies: Bodies, names: Sequence[str]
) -> tuple[Floats, NDArray[np.intc]]:
    """The change of each parameter of each body, shape (n, k, m), and the power of two in its unit.

    A change of a parameter in SI units is that change times ``2**exponent``, shape (n, k): moments,
    weight, damping and torque are counted in the unit of the bodies.
    """
    changes = np.zeros((len(bodies), len(names), _LEN))
    exponents = np.zeros((len(bodies), len(names)), dtype=np.intc)
    for column, name in enumerate(names):
        if name.startswith("com"):
            mgl = np.asarray(scene.mgl)[..., np.newaxis]  # type: ignore[attr-defined]
            own = np.ldexp(in_rows(mgl, bodies.shape), -bodies.scale_exponent[:, np.newaxis])
            changes[:, column, 2 + int(name[3:])] = own[:, 0]
            continue
        if name in _OF_FORCE:
            force, own_numbers = _OF_FORCE[name]
            first = _PLACES[force]
            changes[:, column, [first + k for k in own_numbers]] = 1.0
            if name == "eccentricity":  # The second semi-axis, sqrt(1 - e²) long, changes too.
                numbers = in_rows(np.asarray(scene.further_numbers()[force]), bodies.shape)
                e = numbers[:, 1:2]
                changes[:, column, first + 6 : first + 9] = -e / (1.0 - e * e) * numbers[:, 6:]
            if FORCES[force].has_mass:
                exponents[:, column] = -bodies.scale_exponent
            continue
        exponents[:, column] = -bodies.scale_exponent
        if name == "mgl":
            changes[:, column, 3:6] = in_rows(np.asarray(scene.com), bodies.shape)  # type: ignore[attr-defined]
        else:
            changes[:, column, list(_OF_BODY[name])] = 1.0
    return changes, exponents
