"""Parameters of a scene by which a motion is differentiated, and their changes in the core."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from .._checks.arguments import brief, nearest
from ..model.scene import Scene
from .arrays import in_rows
from .bodies import Bodies

__all__ = ["check_parameters", "parameter_changes"]

Floats = NDArray[np.float64]

_LEN = 15
"""Numbers of a change: moments, ``mgl com``, damping 11, 22, 33, 23, 31, 12, torque in the body."""

_OF_BODY: dict[str, tuple[int, ...]] = {
    **{f"I{k + 1}": (k,) for k in range(3)},
    "damping": (6, 7, 8),
    **{f"damping{k + 1}": (6 + k,) for k in range(3)},
    **{f"torque{k + 1}": (12 + k,) for k in range(3)},
}
"""The numbers that a parameter of any scene adds one to."""

_OF_WEIGHT = ("mgl", "com1", "com2", "com3")

_GROUPS = {"com": _OF_WEIGHT[1:]}


def check_parameters(tangent: bool | str | Sequence[str], scene: Scene) -> tuple[str, ...] | None:
    """The parameters of the argument ``tangent``: none of True; None if it is False.

    Raises
    ------
    ValueError
        For an unknown name, one given twice, weight of a scene without weight, or no name.
    """
    if tangent is False:
        return None
    if isinstance(tangent, bool | np.bool_):
        return () if tangent else None
    given = (tangent,) if isinstance(tangent, str) else tangent
    # A set has no order, and the columns have one.
    is_ordered = isinstance(given, Sequence | np.ndarray) and not isinstance(given, bytes)
    names = tuple(given) if is_ordered else ()
    if not names:
        raise ValueError(f"tangent = {brief(tangent)}: must be True, False or names of parameters")
    weight = (*_OF_WEIGHT, *_GROUPS) if "mgl" in scene.fields else ()
    known = (*_OF_BODY, *weight)
    every: list[str] = []
    for name in names:
        if name not in known:
            why = f": a {scene.title} has no weight" if name in (*_OF_WEIGHT, *_GROUPS) else ""
            raise ValueError(
                f"tangent = {brief(name)}{why or ': is no parameter'}; known are "
                f"{', '.join(map(repr, known))}{nearest(name, known)}"
            )
        for own in _GROUPS.get(name, (name,)):
            if own in every:
                raise ValueError(f"tangent = {brief(tangent)}: {own!r} is named twice")
            every.append(str(own))
    return tuple(every)


def parameter_changes(
    scene: Scene, bodies: Bodies, names: Sequence[str]
) -> tuple[Floats, NDArray[np.intc]]:
    """A change of each parameter of each body, shape (n, k, 15), and the power of two in its unit.

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
        exponents[:, column] = -bodies.scale_exponent
        if name == "mgl":
            changes[:, column, 3:6] = in_rows(np.asarray(scene.com), bodies.shape)  # type: ignore[attr-defined]
        else:
            changes[:, column, list(_OF_BODY[name])] = 1.0
    return changes, exponents
