"""Parameters of a scene by which a motion is differentiated, and their changes in the core."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._checks.arguments import brief, of_known
from .._checks.arrays import Floats
from ..model.forces import FORCES
from ..model.parameters import CHANGES, OF_WEIGHT, PARAMETERS
from ..model.scene import Scene
from .arrays import in_rows
from .bodies import Bodies

_GROUPS = {"com": ("com1", "com2", "com3")}


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
    known = differentiable(scene)
    if "com1" in known:
        known = (*known, *_GROUPS)
    words = partial(why_not, scene=scene)
    return checked_names("tangent", tangent, known, _GROUPS, words, "True, False or ")


def why_not(name: object, scene: Scene, what: str = "") -> str:
    """The reason why the motion of a scene has no derivative by the parameter of a name."""
    row = PARAMETERS.get(_GROUPS.get(str(name), (str(name),))[0])
    place = None if row is None else row.place
    if place in OF_WEIGHT:
        return f"a {scene.title} has no weight"
    return f"the scene has no {place}" if place in FORCES else f"is no parameter{what}"


def differentiable(scene: Scene) -> tuple[str, ...]:
    """The parameters by which the motion of a scene has derivatives."""
    return tuple(name for name, row in PARAMETERS.items() if row.has_derivative(scene))


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
    changes = np.zeros((len(bodies), len(names), CHANGES))
    exponents = np.zeros((len(bodies), len(names)), dtype=np.intc)
    for column, name in enumerate(names):
        row = PARAMETERS[name]
        first, change = row.change(scene)
        changes[:, column, first : first + change.shape[-1]] = in_rows(change, bodies.shape)
        if row.place not in FORCES or FORCES[row.place].has_mass:
            exponents[:, column] = -bodies.scale_exponent
    return changes, exponents
