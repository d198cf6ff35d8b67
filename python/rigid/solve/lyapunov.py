"""Lyapunov exponents and chaos indicators of motions."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _core
from .._checks.arguments import numbers, positive_int, resolve_threads, sorted_times
from .._checks.arrays import AttitudeLike, Floats
from .._checks.float_environment import in_standard_floats
from .._checks.progress import Listening, ProgressOption
from ..model.bodies import Bodies, bodies_of
from ..model.body import Body
from ..model.criteria import Regular, norm_of
from ..model.scene import Scene, check_scene
from .choose_method import choose_method
from .closed_form import NO_FORM, closed_forms
from .growth import Growth
from .methods import EXACT, TO_ROUNDING
from .request import MOST_STEPS, Problem
from .solution import solve
from .status import Status
from .tangent import check_tangent

GENERIC = _core.generic_deviations()
"""Deviation vectors at the start: rates in the unit of the body, rotation vectors in rad. Each has
a part along the direction of the fastest growth."""

ANOTHER = "taylor20"
"""The method of the second run of :data:`TO_ROUNDING`."""

LOOKS = 100
"""Number of times at which a motion is compared with a second run; it is lost from one of them."""

CHECKPOINTS = tuple(1.0 / parts for parts in _core.CHECKPOINT_PARTS)
"""Shares of the horizon at which the mean MEGNO is read for the verdict."""

ROUNDING = 4.0 * float(np.finfo(np.float64).eps)
"""Error of a logarithm of two sizes, each a sum of six squares, that another run may share."""

FEWEST = 64
"""Least number of steps until the first time and the first checkpoint: means need them."""

FEWEST_AGAIN = 91
"""Least number of steps of the second run: series of two orders in the same steps round alike, bit
by bit."""


@in_standard_floats
def lyapunov(
    scene: Scene | Body,
    omega: ArrayLike,
    attitude: AttitudeLike | None = None,
    *,
    t: ArrayLike,
    of: str | None = None,
    exponents: int = 1,
    start: ArrayLike | None = None,
    method: str | None = None,
    step: float | None = None,
    check: bool = True,
    max_steps: int = MOST_STEPS,
    threads: int | None = None,
    progress: ProgressOption = None,
) -> Growth:
    """Measure how fast neighbouring motions separate: exponents, MEGNO, FLI, SALI and GALI.

    A small deviation vector is integrated with the motion, by the linear equations of the tangent.
    It is a change of the rates together with a rotation vector. Its size is divided by powers of
    two on the way, which changes no digit; so no horizon is too long.

    Parameters
    ----------
    scene : FreeBody, HeavyTop or Body
        One body or many, with weight, applied torque and damping.
    omega : array_like, shape (3,) or (..., 3)
        Angular velocity at ``t = 0`` in the body (rad/s).
    attitude : array_like, shape (4,) or (..., 4), or scipy Rotation, optional
        Attitude at ``t = 0``. Default: body and space axes coincide.
    t : array_like, shape (m,)
        Times (s), ascending and positive.
    of : {"rates", "attitude"}, optional
        The size of a deviation vector: ``|dw|² / scale²`` of the rates plus the square of the angle
        by which the vertical in the body changes, or by which the attitude does. The scale is
        ``sqrt(|omega|² + mgl / I_min)`` at the start. Exponents do not depend on it. Default:
        ``"rates"``; ``"attitude"`` on an orbit and under a torque in space that is not vertical.
    exponents : int
        Number of exponents, from the largest down, by Gram-Schmidt: 1 to 6, to 5 of the rates.
    start : array_like, shape (6,) or (exponents, 6), optional
        Deviation vectors at the start: changes of the rates (rad/s), and rotation vectors in the
        body (rad). Default: generic ones, the same for all bodies in their units; the first, whose
        growth the verdict is on, is projected on the level of ``L·gamma`` of a top.
    method : str, optional
        One of the :func:`rigid.methods` with a tangent. Default: ``"taylor16"``.
    step : float, optional
        Largest step (s). Default: the default step of the method, and at least 64 steps until the
        first time.
    check : bool
        Whether a second run, by another method, estimates the error and confirms the verdict with
        another deviation vector.
    max_steps : int
        Most steps; a body that needs more is not run.
    threads : int, optional
        Default: ``RIGID_NUM_THREADS``, else the cores that this process may use.
    progress : None, bool or callable
        As in :func:`simulate`.

    Returns
    -------
    Growth
        Named arrays; see :class:`Growth`.

    Raises
    ------
    ValueError
        Naming the argument, its value and the rule: as :func:`simulate`; times that are not
        positive; a method without a tangent; the size of the rates on an orbit or under a torque in
        space that is not vertical; deviation vectors of size zero or that depend on each other.

    Notes
    -----
    ``L·gamma`` of a top without torque and damping is conserved. The change of the motion with
    ``L·gamma`` says nothing about chaos: at a resonance it is quadratic in the time, and some tops
    are integrable at one value only. So both deviation vectors of a verdict keep ``L·gamma``.

    All integrals are integrals of ``Λ = ln |v|`` over the time. They are sums over the steps of a
    Runge-Kutta method; a Taylor method knows ``Λ`` inside its steps too.

    References
    ----------
    P. M. Cincotta, C. Simó, Astron. Astrophys. Suppl. 147 (2000) 205 (MEGNO). C. Froeschlé,
    E. Lega, R. Gonczi, Celest. Mech. Dyn. Astron. 67 (1997) 41 (FLI). C. Skokos, T. Bountis,
    C. Antonopoulos, Physica D 231 (2007) 30 (GALI). G. Benettin, L. Galgani, A. Giorgilli,
    J.-M. Strelcyn, Meccanica 15 (1980) 9 and 21 (exponents).

    Examples
    --------
    >>> import rigid
    >>> top = rigid.HeavyTop(rigid.Body((1.0, 1.6, 0.7)), mgl=1.2, com=(0.6, 0.0, 0.8))
    >>> slow, fast = [[0.3, 0.4, 1.0], [0.1, 0.0, 20.0]]
    >>> growth = rigid.lyapunov(top, [slow, fast], [0.9, 0.3, 0.2, 0.1], t=[200.0, 400.0])
    >>> growth.verdict.tolist()
    ['chaotic', 'regular']
    >>> growth.exponent[:, -1].round(2).tolist()
    [0.28, 0.02]
    """
    scene = check_scene(scene, many=True)
    of = norm_of(of, scene)
    count = positive_int("exponents", exponents)
    most = 6 if of == "attitude" else 5
    if count > most:
        raise ValueError(f"exponents = {count}: must be at most {most} for of = {of!r}")
    times = sorted_times("t", t)
    if not len(times) or times[0] <= 0.0:
        raise ValueError(f"t = {times[0] if len(times) else '[]'}: must be positive times")
    if method == EXACT:
        raise ValueError("method = 'exact': deviation vectors are integrated; name another method")
    check_tangent(method, forces=scene.forces)
    bodies = bodies_of(scene, omega, attitude)
    problem = Problem(
        scene=scene,
        record="axis",
        bodies=bodies,
        times=times,
        method=method or TO_ROUNDING,
        step=step,
        max_steps=positive_int("max_steps", max_steps),
        threads=resolve_threads(threads),
    )
    # The second run has two bodies for each, and the motion alone is checked last.
    with Listening(progress, 3 if check else 1):
        return growth_of(problem, of=of, count=count, start=start, check=check)


def growth_of(
    problem: Problem,
    *,
    of: str,
    count: int = 1,
    start: ArrayLike | None = None,
    check: bool = True,
) -> Growth:
    """The growth of deviation vectors of the bodies of a problem, whose method is named."""
    scene, bodies, times, method = problem.scene, problem.bodies, problem.times, problem.method
    assert bodies is not None
    assert times is not None
    assert method is not None
    choice = choose_method(problem)
    every = np.union1d(times, times[-1] * np.array(CHECKPOINTS))
    grown = partial(_grown, replace(problem, times=every), of)
    vectors = _deviations(bodies, start, count, of)
    found = grown(bodies, vectors, method, choice.steps, FEWEST)
    output = np.searchsorted(every, times)
    marks = np.searchsorted(every, times[-1] * np.array(CHECKPOINTS))
    log, largest, mean, mean_megno = np.moveaxis(found["logs"], -1, 0)
    error = np.full((len(bodies), len(times)), np.nan)
    second = None
    lost_from = np.full(len(bodies), np.nan)
    status = found["status"]
    if check:
        another = ANOTHER if method == TO_ROUNDING else TO_ROUNDING
        pairs = _pairs(bodies, vectors[:, 0])
        twice = bodies.select(np.repeat(np.arange(len(bodies)), 2)).doubted()
        again = grown(twice, pairs, another, None, FEWEST_AGAIN)
        apart = np.abs(again["logs"][0::2, output, 0] - log[:, output])
        rounding = ROUNDING * np.maximum(1.0, np.abs(log[:, output]))
        second = np.ascontiguousarray(2.0 * again["logs"][1::2, marks, 3])
        looks = np.union1d(times, np.linspace(0.0, times[-1], LOOKS + 1)[1:])
        lost_from = solve(replace(problem, record="rates", times=looks)).states["lost_from"]
        error = 3.0 * apart + rounding
    else:
        status = np.where(status == Status.OK, Status.UNCHECKED, status).astype(np.uint8)
    means = np.ascontiguousarray(2.0 * mean_megno[:, marks])
    verdict = np.array(_core.verdicts(means, second, Regular().limits))
    # Beside a separatrix deviation vectors grow exponentially, although all motions are regular.
    known = closed_forms(Regular(), bodies.moments, bodies.weight) != NO_FORM
    integrable = known & ~bodies.under_forces()
    verdict = np.where((verdict == "chaotic") & integrable, "undecided", verdict)
    verdict = np.where(np.isin(status, (Status.OK, Status.UNCHECKED)), verdict, "failed")

    # Two runs of a motion that is lost are two motions, which grow alike if they are regular only.
    lost = (times >= lost_from[:, np.newaxis]) & (verdict != "regular")[:, np.newaxis]
    error = np.where(lost, -np.inf, error).max(axis=1)
    several = count > 1
    words = f"{count} deviation vector{'s' if several else ''} of the {of}, growth by their tangent"
    choice.plan.amend(words)
    columns = {
        "t": times,
        "log_growth": log[:, output],
        "megno": 2.0 * (log - mean)[:, output],
        "mean_megno": 2.0 * mean_megno[:, output],
        "fli": largest[:, output],
        "spectrum": found["log_diagonal"][:, output] / times[:, np.newaxis],
        "zeros": _zeros(scene, bodies, of),
        "error": np.where(lost.all(axis=1), np.nan, error),
        "lost_from": lost_from,
        "verdict": verdict,
        "energy_drift": found["energy_drift"],
        "status": status,
        "steps": found["steps"],
    }
    if several:
        columns["sali"] = found["sali"][:, output, 0]
        columns["gali"] = np.exp(found["log_gali"][:, output, 1:])
    return Growth(
        _columns=columns,
        _shape=bodies.shape,
        plan=choice.plan(),
        spec={
            "scene": scene.to_dict(),
            "method": method,
            "step": problem.step,
            "of": of,
            "exponents": count,
        },
    )


def _grown(
    problem: Problem,
    of: str,
    bodies: Bodies,
    vectors: Floats,
    method: str,
    steps: Floats | None,
    fewest: int,
) -> dict[str, Any]:
    """The growth of deviation vectors (n, k, 6) by a method, with its longest steps (s)."""
    times = problem.times
    assert times is not None
    if steps is None:
        longest, _ = bodies.planned_steps(method, (0.0, float(times[-1])), "states")
        steps = np.minimum(longest, times[0] / fewest)
    return _core.growth(
        bodies,
        method=method,
        deviations=np.ascontiguousarray(vectors.reshape(-1, 6)),
        of_attitude=of == "attitude",
        times=times,
        step=np.ascontiguousarray(steps),
        max_steps=problem.max_steps,
        threads=problem.threads,
    )


def _pairs(bodies: Bodies, first: Floats) -> Floats:
    """For each body twice, the same deviation vector (n, 6) and another, (n, 2, 6)."""
    starts = _core.deviation_starts(bodies)
    # A unit that overflows belongs to a body that is not run.
    with np.errstate(invalid="ignore"):
        apart = (first[:, np.newaxis] - starts[:, 1:]) / _units(bodies)
    alike = np.linalg.norm(apart, axis=2) < 1e-8
    return np.stack([first, np.where(alike, starts[:, 0], starts[:, 1])], axis=1)


def _units(bodies: Bodies) -> Floats:
    """The units of the six numbers of a deviation vector (rad/s and rad), (n, 1, 6)."""
    units = np.ones((len(bodies), 1, 6))
    units[..., :3] = _core.rate_units(bodies)[:, np.newaxis, np.newaxis]
    return units


def _deviations(bodies: Bodies, start: ArrayLike | None, count: int, of: str) -> Floats:
    """Deviation vectors of each body at its start, (n, k, 6)."""
    if start is None:
        several = GENERIC[:count] * _units(bodies)
        several[:, 0] = _core.deviation_starts(bodies)[:, 0]
        return several
    given = np.atleast_2d(numbers("start", start))
    if given.shape != (count, 6):
        raise ValueError(f"start: expected shape ({count}, 6), got {np.shape(start)}")
    if not np.isfinite(given).all():
        raise ValueError("start: must be finite")
    # Growth does not depend on the size: by powers of two, so that no square leaves the doubles.
    given = np.ldexp(given, -np.frexp(np.abs(given).max(axis=1, keepdims=True))[1])
    several = np.broadcast_to(given, (len(bodies), count, 6))
    for body, vectors in enumerate(_measured(bodies, several, of)):
        sizes = np.linalg.norm(vectors, axis=1)
        if not (sizes > 1e-12 * np.linalg.norm(given, axis=1)).all():
            raise ValueError(f"start: a deviation vector of body {body} has no size by of = {of!r}")
        if np.linalg.matrix_rank(vectors / sizes[:, np.newaxis], tol=1e-8) < count:
            raise ValueError(f"start: the deviation vectors of body {body} depend on each other")
    return np.array(several)


def _measured(bodies: Bodies, vectors: Floats, of: str) -> Floats:
    """The vectors whose lengths are the sizes of deviation vectors (n, k, 6)."""
    scaled = vectors / _units(bodies)
    if of == "attitude":
        return scaled
    turned = np.cross(bodies.gammas()[:, np.newaxis], scaled[..., 3:])
    return np.concatenate([scaled[..., :3], turned], axis=-1)


def _zeros(scene: Scene, bodies: Bodies, of: str) -> NDArray[np.intp]:
    """Number of exponents of each body that are zero by theory."""
    heavy = np.broadcast_to(np.any(bodies.weight != 0.0, axis=1), (len(bodies),))
    acting = set(scene.forces) - {"rotor"}
    if not acting and not scene.tables:
        # Flow, energy, turns about the vertical and L·gamma; of a free body all of space, and L.
        zeros = np.where(heavy, 4, 6)
    elif acting == {"orbit"} and not scene.tables:
        # On a circle flow and Jacobi's integral, in the frame of the orbit.
        circular = np.asarray(scene.further_numbers()["orbit"])[..., 1] == 0.0
        zeros = np.where(np.broadcast_to(circular, bodies.shape or 1).ravel(), 2, 0)
    elif acting <= {"dissipation"}:
        # Turns of all space, and |L|; a rotor by a table has no energy either.
        zeros = np.full(len(bodies), 4)
    elif scene.orbit is not None or (scene.torque is not None and scene.torque.acts_in_space):
        zeros = np.zeros(len(bodies), dtype=np.intp)
    else:
        # Turns of all space, or of the vertical.
        zeros = np.where(heavy, 1, 3)
    # The rates do not see the turn about the vertical, nor a free body's momentum along it.
    hidden = 1 if of == "rates" else 0
    found: NDArray[np.intp] = np.maximum(zeros - hidden, 0)
    return found
