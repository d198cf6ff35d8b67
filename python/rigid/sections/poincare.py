"""All points at which motions cross a surface, or states at equal times."""

from __future__ import annotations

import math
from collections.abc import Collection
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from .._checks.arguments import brief, finite_float, positive_int, resolve_threads
from .._checks.arrays import AttitudeLike, Floats
from .._checks.progress import Listening, ProgressOption
from ..model.bodies import bodies_of
from ..model.body import Body
from ..model.scene import Scene, check_scene
from ..rotations.apply import to_body
from ..solve.choose_method import choose_method
from ..solve.methods import adaptive_methods
from ..solve.request import MOST_STEPS, Problem
from ..solve.simulate import simulate
from ..solve.status import Status
from ..solve.surfaces import Watched, default_method, default_tolerance, found_points
from .crossings import Crossings
from .surface import Section, at_equal_times, checked_section

if TYPE_CHECKING:
    from ..solve.run import Run


MOST_POINTS = 1e8
"""Most points of a body at equal times."""


def poincare(
    scene: Scene | Body,
    omega: ArrayLike,
    attitude: AttitudeLike | None = None,
    section: Section | str | None = None,
    *,
    every: float | None = None,
    t_end: float,
    count: int | None = None,
    method: str | None = None,
    tolerance: float | None = None,
    check: bool = True,
    max_steps: int = MOST_STEPS,
    threads: int | None = None,
    progress: ProgressOption = None,
) -> Crossings:
    """Find all points at which bodies cross a surface of section, or states at equal times.

    A Taylor method knows the motion inside each step as a polynomial, and with it the function that
    is zero on the surface. Its zeros are isolated by Descartes' rule of signs, so that two
    crossings in one step are not missed, and no grid of steps has to be fine enough.

    Parameters
    ----------
    scene : FreeBody, HeavyTop or Body
        One body or many, with weight, applied torque and damping.
    omega : array_like, shape (3,) or (..., 3)
        Angular velocity at ``t = 0`` in the body (rad/s).
    attitude : array_like, shape (4,) or (..., 4), or scipy Rotation, optional
        Attitude at ``t = 0``. Default: body and space axes coincide.
    section : Section or str, optional
        The surface, made by :func:`section`, or its name. Default: ``"height"``.
    every : float, optional
        Instead of a surface: the points are the states at the multiples of this time (s), such as
        the period of an orbit. Such a section is called stroboscopic.
    t_end : float
        Time at which the motions end (s).
    count : int, optional
        Number of points of a body after which its motion ends.
    method : str, optional
        A Taylor method. Default: ``"taylor20"``; under :meth:`Torque.call` ``"dop853"`` alone.
    tolerance : float, optional
        Size of the last terms of a step, relative to the motion; by default below rounding. For
        ``"dop853"`` the error of a step; by default 1e-12.
    check : bool
        Whether a second run, by a method of another order, estimates the errors of the points.
    max_steps : int
        Most steps; a body that needs more ends there.
    threads : int, optional
        Default: ``RIGID_NUM_THREADS``, else the cores that this process may use.
    progress : None, bool or callable
        As in :func:`simulate`.

    Returns
    -------
    Crossings
        Named arrays with a row for each point; see :class:`Crossings`.

    Raises
    ------
    ValueError
        Naming the argument, its value and the rule: as :func:`simulate`; a method that is no
        series, a ``t_end`` that is not positive, ``"height"`` of a body without weight; an
        ``every`` that is not positive or above ``t_end``, or beside a section.
    MemoryError
        As soon as the points do not fit into the memory of the machine: give a ``count``, or for
        fewer bodies at once.

    Notes
    -----
    States at equal times are the states of :func:`simulate` with the same method: no surface is
    crossed, and ``error`` is the error of the states. J. Wisdom, S. J. Peale, F. Mignard, Icarus 58
    (1984) 137, fig. 2.

    Points do not depend on the other bodies of a call, nor on threads and instruction set. A start
    on the surface is no point.

    References
    ----------
    H. Poincaré, Les méthodes nouvelles de la mécanique céleste III, Gauthier-Villars (1899).
    M. Hénon, Physica D 5 (1982) 412 (the time of a crossing). S. Schmidt, H. R. Dullin,
    P. H. Richter, SIAM J. Appl. Dyn. Syst. 7 (2008) 371 (complete sections). F. Rouillier,
    P. Zimmermann, J. Comput. Appl. Math. 162 (2004) 33 (zeros by Descartes' rule).

    Examples
    --------
    >>> import rigid
    >>> top = rigid.HeavyTop(rigid.Body((2.0, 2.0, 1.0)), mgl=1.0, com=(1.0, 0.0, 0.0))
    >>> points = rigid.poincare(top, [0.5, 0.25, 1.5], t_end=100.0)
    >>> points
    <Crossings: 25 points of 1 body, centre of mass highest; complete>
    >>> points.gamma[0].round(3).tolist()
    [0.643, 0.763, 0.066]
    >>> rigid.poincare(top, [0.5, 0.25, 1.5], every=2.0, t_end=100.0)
    <Crossings: 50 points of 1 body, every 2 s; complete>
    """
    scene = check_scene(scene, many=True)
    end = finite_float("t_end", t_end, positive=True)
    most = None if count is None else positive_int("count", count)
    chosen = default_method(scene.forces) if method is None else method
    _check_method(chosen, scene.forces)
    given = default_tolerance(scene.forces) if tolerance is None else tolerance
    how: dict[str, Any] = {
        "method": chosen,
        "tolerance": finite_float("tolerance", given, positive=True),
        "max_steps": positive_int("max_steps", max_steps),
        "threads": resolve_threads(threads),
    }
    if every is None:
        surface = checked_section(section)
        bodies = bodies_of(scene, omega, attitude)
        problem = Problem(
            scene=scene, record="attitude", bodies=bodies, reach=(0.0, end), states=0, **how
        )
        shape, plan = bodies.shape, choose_method(problem).plan()
        with Listening(progress):
            columns = _crossed(problem, surface, most, check=check)
    else:
        if section is not None:
            raise ValueError(f"section = {brief(section)}: leave it out beside every")
        period = finite_float("every", every, positive=True)
        surface, times = at_equal_times(period), _multiples(period, end, most)
        run = simulate(scene, omega, attitude, t=times, check=check, progress=progress, **how)
        shape, plan, columns = np.shape(run.status), run.plan, _at_times(run)
    return Crossings(
        _columns=columns,
        _shape=shape,
        section=surface,
        plan=plan,
        orbit=scene.orbit,
        spec={
            "scene": scene.to_dict(),
            "method": chosen,
            "tolerance": how["tolerance"],
            "section": surface.to_dict(),
            "t_end": end,
            "count": count,
        },
    )


def _crossed(
    problem: Problem, surface: Section, most: int | None, *, check: bool
) -> dict[str, Any]:
    """The columns of the points at which the bodies of a problem cross a surface."""
    bodies, method = problem.bodies, problem.method
    assert bodies is not None
    assert method is not None
    # The height of the centre of mass has another normal in each body.
    normals = surface.normals(problem.scene, np.broadcast_to(bodies.weight, (len(bodies), 3)))
    watched = Watched((surface.event(),), (True,), most)
    found = found_points(problem, watched, method, check=check, normals=normals[:, np.newaxis])
    lost = np.isfinite(found["lost_from"]) if check else True
    told = Status.FLAGGED if check else Status.UNCHECKED
    return {
        **found,
        "complete": found["complete"][:, 0],
        "status": np.where((found["status"] == Status.OK) & lost, np.uint8(told), found["status"]),
        "stays": found["stays"] > 0,
    }


def _multiples(period: float, end: float, most: int | None) -> Floats:
    """The multiples of a time until the end, at most so many."""
    if period > end:
        raise ValueError(f"every = {period:g}: must not be above t_end = {end:g}")
    if end / period > MOST_POINTS:
        raise ValueError(
            f"every = {period:g}: gives more than {MOST_POINTS:g} points until t_end = {end:g}"
        )
    known = math.floor(end / period * (1.0 + 1e-12))
    return period * np.arange(1.0, min(known, most or known) + 1.0)


def _at_times(run: Run) -> dict[str, Any]:
    """The columns of the states of a run as points."""
    columns = run._columns
    # Those that a body did not reach are no points.
    reached = np.isfinite(columns["omega"]).all(axis=2)
    body, at = np.nonzero(reached)
    attitude = columns["attitude"][reached]
    attitude = np.where(attitude[:, :1] < 0.0, -attitude, attitude)
    attitude /= np.linalg.norm(attitude, axis=1, keepdims=True)
    return {
        "body": body,
        "t": run.t[at],
        "omega": columns["omega"][reached],
        "gamma": to_body(attitude, np.array([0.0, 0.0, 1.0])),
        "attitude": attitude,
        "direction": np.ones(len(at), dtype=np.int8),
        "slope": np.ones(len(at)),
        "grazing": np.zeros(len(at), dtype=np.bool_),
        "error": columns["error"][body],
        "complete": reached.all(axis=1),
        "end": np.where(reached, run.t, 0.0).max(axis=1),
        "stays": np.zeros(len(reached), dtype=np.bool_),
        **{name: columns[name] for name in ("lost_from", "energy_drift", "status", "steps")},
    }


def _check_method(method: str, forces: Collection[str]) -> None:
    """Raise ValueError unless it is a Taylor method, or the method of a callback in its place."""
    names = adaptive_methods(forces)
    if method not in names:
        who = "a Taylor method" if len(names) > 1 else f"{names[0]!r} under a function"
        raise ValueError(
            f"method = {brief(method)}: only {who} is a polynomial inside its steps, of "
            f"which no crossing is missed; take one of {', '.join(map(repr, names))}"
        )
