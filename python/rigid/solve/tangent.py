"""The tangent of a motion: its derivative by start and parameters, and how much it magnifies.

A small deviation vector of a motion is a change of its rates and a rotation vector in the body. It
obeys linear equations, which are integrated with the motion: one lane for each column. The vector
of a parameter begins at zero, and the change of the parameter is a torque in its equations.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _core
from .._checks.arguments import brief, of_known, one_of, resolve_threads, sorted_times
from .._checks.arrays import AttitudeLike, Floats
from ..model.batch import in_rows
from ..model.bodies import Bodies, bodies_of
from ..model.body import Body
from ..model.forces import CHANGES, FORCES, forces_in_words
from ..model.parameters import OF_WEIGHT, PARAMETERS
from ..model.scene import Scene, check_scene
from .methods import EXACT, TO_ROUNDING, run_methods, tangent_methods
from .request import MOST_STEPS, Request
from .status import Status

ROUNDING = 2.0**-53
"""Tolerance of a tangent for which no method is given."""

_GROUPS = {"com": ("com1", "com2", "com3")}
"""Names that stand for several parameters."""


def check_tangent(
    method: str | None, *, forces: tuple[str, ...], by_parameters: bool = False
) -> None:
    """Raise ValueError for a method without a tangent; a closed form has an integrated one."""
    if "function" in forces:
        raise ValueError(
            "torque: the derivative of a function is not known, so no deviation vectors are "
            "integrated; take starts that differ by 1e-6 and compare their runs"
        )
    known = tangent_methods(forced=bool(forces) or by_parameters)
    if method in (None, EXACT, *known):
        return
    one_of("method", method, run_methods())
    where = f"under {forces_in_words(forces)}" if forces else "by parameters"
    why = "has no tangent, because its steps are not differentiated"
    if method in tangent_methods():
        why = f"has no tangent {where}"
    raise ValueError(f"method = {method!r}: {why}; {', '.join(map(repr, known))} have one")


def check_parameters(tangent: bool | str | Sequence[str], scene: Scene) -> tuple[str, ...] | None:
    """The parameters in the argument ``tangent``: none for True; None for False.

    Raises
    ------
    ValueError
        For an unknown name, one given twice, weight of a scene without weight, or no name.
    """
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


def tangent_of(
    request: Request, method: str | None, change: tuple[Floats, NDArray[np.intc]] | None
) -> tuple[Floats, Floats | None, str]:
    """The tangent of the bodies of a request, the derivative by parameters, and a sentence.

    A method that the user has named returns the tangent too, with the steps of the motion or the
    same tolerance. Else it is integrated by ``taylor16``, whose errors are of the size of rounding.
    """
    words = f"tangent by {method} too"
    if method not in tangent_methods():
        request = replace(request, method=TO_ROUNDING, tolerance=ROUNDING, steps=None)
        words = f"tangent by {TO_ROUNDING}, its last terms below {ROUNDING:.1e}"
    sensitivity = None if change is None else _sensitivity(request, *change)
    return tangent_matrices(request), sensitivity, words


def tangent_matrices(request: Request) -> Floats:
    """Derivatives of (rates, rotation vector) by their values at the start, shape (n, m, 6, 6).

    Parameters
    ----------
    request : Request
        The bodies and times, with a method that has a tangent.

    Returns
    -------
    ndarray
        NaN for a body that was not run or whose motion overflows; infinite where the derivative
        leaves the range of doubles.
    """
    starts = np.tile(np.eye(6), (len(request.bodies), 1))
    return _columns(request, "tangent", 6, deviations=starts)


def _sensitivity(request: Request, changes: Floats, exponents: NDArray[np.intc]) -> Floats:
    """Derivatives of (rates, rotation vector) by parameters, shape (n, m, 6, k)."""
    rows = np.ascontiguousarray(changes.reshape(-1, changes.shape[2]))
    found = _columns(request, "sensitivity", changes.shape[1], changes=rows)
    with np.errstate(over="ignore"):
        return np.ldexp(found, exponents[:, np.newaxis, np.newaxis, :])


def _columns(request: Request, record: str, width: int, **causes: Any) -> Floats:
    """Deviation vectors of each body in columns, shape (n, m, 6, width), a lane for each column.

    Their causes are deviation vectors at the start or changes of parameters, (n width, ...).
    """
    count = len(request.bodies)
    columns = replace(request.select(np.repeat(np.arange(count), width)), record=record)
    found = columns.states(**causes)
    matrices = found["tangent"].reshape(count, width, request.times.shape[-1], 6)
    moves = np.isin(found["status"][::width], (Status.OK, Status.DRIFTED))
    known = np.where(moves[:, None, None, None] & ~np.isfinite(matrices), np.inf, matrices)
    return np.ascontiguousarray(known.transpose(0, 2, 3, 1))


def condition(
    scene: Scene | Body,
    omega: ArrayLike,
    attitude: AttitudeLike | None = None,
    *,
    t: ArrayLike,
    threads: int | None = None,
) -> Floats:
    """Factor by which a motion magnifies the worst small change of its start.

    The largest singular value of the derivative of the state with respect to the start, with rates
    in units of ``sqrt(|omega|² + mgl / I_min)`` and attitudes in rad. The factor is a
    property of the motion, not of a method: an error of 1e-16 in the start, the size of rounding,
    becomes ``1e-16 condition`` with every method. It grows like ``t`` on regular motions and
    exponentially on chaotic ones and near a separatrix.

    The derivative is the tangent of the motion (see :attr:`Run.tangent`), integrated by
    ``taylor16``. Its relative error is about ``1e-16 condition``, as for the motion: of a factor
    above 1e16 only the size is known.

    Parameters
    ----------
    scene : FreeBody, HeavyTop or Body
        The body, or many, with their weight, applied torque and damping.
    omega : array_like, shape (3,) or (..., 3)
        Angular velocity at ``t = 0`` in the body (rad/s).
    attitude : array_like, shape (4,) or (..., 4), or scipy Rotation, optional
        Attitude at ``t = 0``. Default: body and space axes coincide.
    t : array_like, shape (m,)
        Times (s), ascending.
    threads : int, optional
        Default: ``RIGID_NUM_THREADS``, else the cores that this process may use.

    Returns
    -------
    ndarray, shape (..., m), or (m,) of a single body
        1 at ``t = 0``. Infinite beyond the range of doubles; NaN for a body whose motion overflows.

    Raises
    ------
    ValueError
        As :func:`rigid.simulate`.

    Notes
    -----
    Chaos indicators are functions of the linearised flow (Skokos & Gerlach, Phys. Rev. E 82
    (2010) 036704, doi 10.1103/PhysRevE.82.036704); its largest singular value bounds them all.

    Examples
    --------
    >>> import rigid
    >>> box = rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0)))
    >>> stable = rigid.condition(box, [1.0, 1e-3, 1e-3], t=[10.0])
    >>> tumbling = rigid.condition(box, [1e-3, 1.0, 1e-3], t=[10.0])
    >>> print(f"{stable[0]:.0f} {tumbling[0]:.0f}")
    10 490
    """
    scene = check_scene(scene, many=True)
    bodies = bodies_of(scene, omega, attitude)
    factors = amplification(bodies, sorted_times("t", t), resolve_threads(threads))
    return factors.reshape(*bodies.shape, factors.shape[1])


def amplification(bodies: Bodies, times: Floats, threads: int) -> Floats:
    """The condition of some bodies at these times, shape (n, m)."""
    matrices = tangent_matrices(
        Request(
            bodies=bodies,
            times=times,
            method=TO_ROUNDING,
            record="rates",
            max_steps=MOST_STEPS,
            threads=threads,
            tolerance=ROUNDING,
        )
    )
    scale = _core.rate_units(bodies)[:, None, None, None]
    matrices[..., :3, 3:] /= scale
    matrices[..., 3:, :3] *= scale
    finite = np.isfinite(matrices).all(axis=(-2, -1))
    lost = np.where(np.isnan(matrices).any(axis=(-2, -1)), np.nan, np.inf)
    matrices[~finite] = 0.0
    return np.where(finite, np.linalg.norm(matrices, 2, axis=(-2, -1)), lost)
