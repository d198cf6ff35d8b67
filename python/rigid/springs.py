"""Particles under forces between pairs: their small oscillations, and the limit of the rigid body.

A body of stiff springs approximates a rigid body with an error that falls as the inverse of the
stiffness. The cost rises as the square root of the stiffness, so rigid motion is not computed this
way.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._checks.arguments import finite_float, of_shape, shaped, sorted_times, vector
from ._checks.arrays import Floats
from ._checks.overflow import numbers_of_user, refuses_overflow
from ._checks.quantities import plain
from .model.body import Body
from .model.scene import FreeBody
from .particles.systems import degrees_of_freedom, pairs_of, refuse_coincidence
from .solve.simulate import simulate

__all__ = ["Law", "Modes", "PairSystem", "SpringPath", "pair_system", "spring_body"]

Counts = NDArray[np.intp]

Law = Callable[[Floats], tuple[Floats, Floats, Floats]]
"""Function of distances ``(..., P)``: energies of the pairs and their first two derivatives."""

_MOST_STEPS, _FAR = 500, 1e3
"""Steps of a search of an equilibrium, and the growth at which particles fly apart."""

SMALL = 1e-9
"""A force, or a squared frequency, below this fraction of the largest stiffness is zero."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Modes:
    """Small oscillations about an equilibrium.

    Attributes
    ----------
    omega_squared : ndarray, shape (..., 3 N)
        Squared frequencies (rad²/s²), ascending; negative for unstable modes.
    shapes : ndarray, shape (..., 3 N, N, 3)
        Displacements of the particles in each mode, with ``Σ m u² = 1``.
    zero : ndarray of int, shape (...)
        Number of modes with the frequency zero, whose squared frequency is below 1e-9 of the
        largest: 6 for a body that its forces hold together, the translations and the rotations; 5
        if the body lies on a line; more if the body can deform without force.
    """

    omega_squared: Floats
    shapes: Floats
    zero: Counts

    @property
    def stiff_step(self) -> Floats:
        """Inverse of the largest frequency (s): ``sqrt(m / k)`` with the reduced mass m.

        Steps of an explicit method must be shorter than a multiple of this time: 2 for leapfrog,
        2.83 for the classical Runge-Kutta method. inf if all frequencies are zero.
        """
        with np.errstate(divide="ignore"):
            largest = np.maximum(self.omega_squared[..., -1], 0.0)
            step: Floats = np.where(largest > 0.0, 1.0 / np.sqrt(largest), np.inf)[()]
        return step


@dataclass(frozen=True, slots=True, eq=False)
class _Pulls:
    """Pairs (..., P): unit vectors from the second to the first particle, and values of the law."""

    direction: Floats
    distance: Floats
    energy: Floats
    tension: Floats
    stiffness: Floats


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PairSystem:
    """Particles with a potential ``V = Σ V_ij(|r_i - r_j|)``; create them by :func:`pair_system`.

    Attributes
    ----------
    masses : ndarray, shape (N,)
        Masses (kg).
    positions : ndarray, shape (N, 3)
        The reference configuration (m).
    pairs : ndarray of int, shape (P, 2)
        Indices of the particles that act on each other.
    law : callable
        Energy and its derivatives, see :data:`Law`.
    """

    masses: Floats
    positions: Floats
    pairs: Counts
    law: Law

    def energy(self, positions: ArrayLike | None = None) -> Floats:
        """Potential energy (J), shape (...), of positions (..., N, 3) or of the reference.

        Parameters
        ----------
        positions : array_like, shape (..., N, 3), optional
            Positions (m); by default the reference configuration.

        Returns
        -------
        ndarray, shape (...)
            Energy (J).

        Raises
        ------
        ValueError
            If the positions are not finite, or two particles of a pair coincide.

        Examples
        --------
        >>> from rigid import springs
        >>> system = springs.pair_system([1.0, 1.0], [[0, 0, 0], [1, 0, 0]], stiffness=50.0)
        >>> float(system.energy([[0, 0, 0], [1.2, 0, 0]]).round(12))
        1.0
        """
        total: Floats = self._pulls(positions).energy.sum(axis=-1)
        return total

    def forces(self, positions: ArrayLike | None = None) -> Floats:
        """Forces (N) on the particles, ``-∂V/∂r``, shape (..., N, 3).

        Parameters
        ----------
        positions : array_like, shape (..., N, 3), optional
            Positions (m); by default the reference configuration.

        Returns
        -------
        ndarray, shape (..., N, 3)
            Forces (N).

        Raises
        ------
        ValueError
            If the positions are not finite, or two particles of a pair coincide.

        Examples
        --------
        >>> from rigid import springs
        >>> system = springs.pair_system([1.0, 1.0], [[0, 0, 0], [1, 0, 0]], stiffness=50.0)
        >>> system.forces([[0, 0, 0], [1.2, 0, 0]])[:, 0].round(12).tolist()
        [10.0, -10.0]
        """
        pulls = self._pulls(positions)
        return -(self._incidence().T @ (pulls.tension[..., np.newaxis] * pulls.direction))

    def hessian(self, positions: ArrayLike | None = None) -> Floats:
        """Second derivatives ``∂²V/∂r∂r`` (N/m), shape (..., 3 N, 3 N).

        Each pair has the stiffness ``V''`` along its line and ``V'/d`` perpendicular to it.

        Parameters
        ----------
        positions : array_like, shape (..., N, 3), optional
            Positions (m); by default the reference configuration.

        Returns
        -------
        ndarray, shape (..., 3 N, 3 N)
            Second derivatives (N/m).

        Raises
        ------
        ValueError
            If the positions are not finite, or two particles of a pair coincide.

        Examples
        --------
        >>> from rigid import springs
        >>> system = springs.pair_system([1.0, 1.0], [[0, 0, 0], [1, 0, 0]], stiffness=50.0)
        >>> float(system.hessian()[0, 3])
        -50.0
        """
        pulls = self._pulls(positions)
        across = (pulls.tension / pulls.distance)[..., np.newaxis, np.newaxis]
        along = pulls.stiffness[..., np.newaxis, np.newaxis] - across
        lines = pulls.direction[..., :, np.newaxis] * pulls.direction[..., np.newaxis, :]
        blocks = along * lines + across * np.eye(3)
        sign = self._incidence()
        joined = np.einsum("pa,...pij,pb->...aibj", sign, blocks, sign, optimize=True)
        size = 3 * len(self.masses)
        return np.asarray(joined.reshape(*joined.shape[:-4], size, size))

    def equilibrium(self, positions: ArrayLike | None = None) -> Floats:
        """Positions of a stable equilibrium: a minimum of the potential energy near a start.

        Newton steps with the sizes of the second derivatives, and so downhill also where these are
        negative, within a radius of trust (J. Nocedal and S. Wright, *Numerical Optimization*,
        ch. 4). At a saddle the search goes on along the steepest way down. A potential of distances
        does not determine place and orientation; the mean of the positions stays.

        Parameters
        ----------
        positions : array_like, shape (N, 3), optional
            The start (m); by default the reference configuration.

        Returns
        -------
        ndarray, shape (N, 3)
            Positions (m), for :meth:`modes`.

        Raises
        ------
        ValueError
            If no minimum is found: the particles fly apart, or 500 steps do not end.

        Examples
        --------
        >>> from rigid import springs
        >>> def lennard_jones(d):
        ...     near, far = d**-12.0, 2.0 * d**-6.0
        ...     return near - far, (6 * far - 12 * near) / d, (156 * near - 42 * far) / d**2
        >>> start = [[0, 0, 0], [1.5, 0, 0], [0.2, 0.8, 0]]
        >>> triple = springs.pair_system([1.0] * 3, start, law=lennard_jones)
        >>> found = triple.equilibrium()
        >>> float(triple.energy(found).round(12)), int(triple.modes(found).zero)
        (-3.0, 6)
        """
        r = self.positions if positions is None else shaped("positions", positions, None, 3)
        if r.ndim != 2:
            raise ValueError(f"positions: expected shape (N, 3), got {r.shape}")
        energy, size = float(self.energy(r)), float(np.ptp(r, axis=0).max())
        radius, rounded = 0.1 * size, 8.0 * np.finfo(np.float64).eps
        for _ in range(_MOST_STEPS):
            pulls = self._pulls(r)
            sizes = np.abs(pulls.tension) + np.abs(pulls.stiffness) * pulls.distance
            scale = float(sizes.max(initial=0.0))
            force = self.forces(r).ravel()
            curved, modes = np.linalg.eigh(self.hessian(r))
            along, bound = force @ modes, SMALL * np.abs(curved).max()
            share = np.where(np.abs(curved) <= bound, SMALL, rounded)  # of the forces, that is zero
            step = along / np.maximum(np.abs(curved), bound or 1.0)
            step[np.abs(along) <= share * scale] = 0.0
            length = float(np.linalg.norm(step))
            if length <= rounded * size:
                if curved[0] >= -bound:
                    return r
                step, length = np.where(np.arange(len(step)) == 0, radius, 0.0), radius
            step *= min(1.0, radius / length)
            move = (modes @ step).reshape(r.shape)
            there = r + (move - move.mean(axis=0))
            expected = float(0.5 * step @ (curved * step) - along @ step)
            try:
                change = float(self.energy(there)) - energy
            except ValueError:  # two particles meet, or the law ends
                change = np.inf
            # The change of an energy cannot be told from its rounding close to the minimum.
            terms = np.abs(pulls.energy) + np.abs(pulls.tension) * pulls.distance
            noise = rounded * float(terms.sum())
            small = max(abs(expected), abs(change)) <= noise
            if change < 0.0 or small:
                r, energy = there, energy + change
                radius *= 2.0 if small or change < 0.5 * expected else 1.0
            else:
                radius *= 0.25
            if np.ptp(r, axis=0).max() > _FAR * size:
                raise ValueError(
                    f"positions: no equilibrium was found; the particles fly apart, to "
                    f"{np.ptp(r, axis=0).max():.3g} m from {size:.3g} m"
                )
        raise ValueError(
            f"positions: no equilibrium was found in {_MOST_STEPS} steps; the largest force is "
            f"{np.abs(force).max():.3g}"
        )

    def modes(self, positions: ArrayLike | None = None) -> Modes:
        """Frequencies and shapes of the small oscillations about an equilibrium.

        The squared frequencies are the eigenvalues of ``M^-½ (∂²V/∂r∂r) M^-½`` (Goldstein,
        *Classical Mechanics*, § 6.2; Landau and Lifshitz, *Mechanics*, § 23). The lecture notes,
        § 5.1, print the eigenvalues of the second derivatives, which are no frequencies
        (erratum G-02); six of these eigenvalues are zero, not positive (erratum G-01).

        Parameters
        ----------
        positions : array_like, shape (..., N, 3), optional
            Positions (m); by default the reference configuration.

        Returns
        -------
        Modes

        Raises
        ------
        ValueError
            If the forces do not vanish; :meth:`equilibrium` finds where they do.

        Examples
        --------
        >>> from rigid import springs
        >>> system = springs.pair_system([1.0, 1.0], [[0, 0, 0], [1, 0, 0]], stiffness=50.0)
        >>> modes = system.modes()
        >>> int(modes.zero), float(modes.omega_squared[-1].round(9))
        (5, 100.0)
        """
        pulls = self._pulls(positions)
        scale = np.abs(pulls.tension) + np.abs(pulls.stiffness) * pulls.distance
        largest = np.abs(self.forces(positions)).max(axis=(-2, -1))
        if (largest > SMALL * scale.max(axis=-1, initial=0.0)).any():
            raise ValueError(
                f"positions: must be an equilibrium, where no force acts (equilibrium() finds "
                f"one); the largest force is {float(largest.max()):g}"
            )
        root = np.repeat(np.sqrt(self.masses), 3)
        weighted = self.hessian(positions) / root / root[:, np.newaxis]
        squared, columns = np.linalg.eigh(weighted)
        shapes = np.swapaxes(columns, -1, -2) / root
        bound = SMALL * np.abs(squared).max(axis=-1, keepdims=True)
        return Modes(
            omega_squared=squared,
            shapes=shapes.reshape(*shapes.shape[:-1], len(self.masses), 3),
            zero=(np.abs(squared) <= bound).sum(axis=-1),
        )

    def _incidence(self) -> Floats:
        """Shape (P, N): +1 for the first particle of a pair, -1 for the second."""
        one = np.eye(len(self.masses))
        return np.asarray(one[self.pairs[:, 0]] - one[self.pairs[:, 1]])

    def _pulls(self, positions: ArrayLike | None) -> _Pulls:
        r = self.positions if positions is None else shaped("positions", positions, None, 3)
        if r.shape[-2] != len(self.masses):
            raise ValueError(f"positions: expected {len(self.masses)} particles, got {r.shape}")
        first, second = self.pairs.T
        apart = r[..., first, :] - r[..., second, :]
        distance = np.linalg.norm(apart, axis=-1)
        refuse_coincidence(distance, first, second)
        found = [np.asarray(plain("law", values)) for values in self.law(distance)]
        if any(one.shape != distance.shape or not np.isfinite(one).all() for one in found):
            raise ValueError(
                "law: must return energy, first and second derivative of each distance, all finite"
            )
        energy, tension, stiffness = found
        return _Pulls(apart / distance[..., np.newaxis], distance, energy, tension, stiffness)


@refuses_overflow
def pair_system(
    masses: ArrayLike,
    positions: ArrayLike,
    *,
    pairs: ArrayLike | None = None,
    stiffness: ArrayLike | None = None,
    rest: ArrayLike | None = None,
    law: Law | None = None,
) -> PairSystem:
    """Particles joined by springs, or by another potential of their distances.

    ``V = Σ k (d - d0)²/2``, or the sum of the given law over the pairs (lecture notes, § 5.1).

    Parameters
    ----------
    masses : array_like, shape (N,)
        Masses (kg), positive.
    positions : array_like, shape (N, 3)
        Reference configuration (m).
    pairs : array_like of int, shape (P, 2), optional
        Indices of the particles that act on each other. Default: all pairs, in the order of
        ``numpy.triu_indices(N, 1)``.
    stiffness : float or array_like, shape (P,)
        Stiffness (N/m) of the springs, >= 0. Pass either ``stiffness`` or ``law``.
    rest : float or array_like, shape (P,), optional
        Rest lengths (m) of the springs. Default: the distances of the reference configuration.
    law : callable, optional
        Function of distances ``(..., P)`` that returns energy, first and second derivative, each of
        the shape of the distances. Pass a law instead of springs.

    Returns
    -------
    PairSystem
        Call its methods ``energy``, ``forces``, ``hessian`` and ``modes``.

    Raises
    ------
    ValueError
        If a mass is not positive, a stiffness or a length is negative, two joined particles
        coincide, or not exactly one of ``stiffness`` and ``law`` is given.

    Examples
    --------
    >>> import numpy as np
    >>> from rigid import springs
    >>> molecule = springs.pair_system([1.0, 3.0], [[0, 0, 0], [2, 0, 0]], stiffness=12.0)
    >>> modes = molecule.modes()
    >>> int(modes.zero), float(np.sqrt(modes.omega_squared[-1]).round(9))  # sqrt(k / (3/4))
    (5, 4.0)
    """
    m, r = _bodies(masses, positions)
    first, second = pairs_of(pairs, len(m))
    given = law
    if law is not None:
        if stiffness is not None or rest is not None:
            raise ValueError("stiffness, rest, law: give stiffness and rest, or a law, not both")
    elif stiffness is None:
        raise ValueError("stiffness, law: give the stiffness of springs or a law")
    else:
        distances = np.linalg.norm(r[first] - r[second], axis=-1)
        k = _of_pairs("stiffness", stiffness, len(first))
        lengths = distances if rest is None else _of_pairs("rest", rest, len(first))

        def law(distances: Floats) -> tuple[Floats, Floats, Floats]:
            stretch = distances - lengths
            tension = k * stretch
            return 0.5 * tension * stretch, tension, np.broadcast_to(k, distances.shape)

    system = PairSystem(masses=m, positions=r, pairs=np.stack([first, second], axis=-1), law=law)
    checked = system if given is None else replace(system, law=numbers_of_user()(given))
    checked.energy()  # raises if particles coincide or the law returns wrong values
    return system


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SpringPath:
    """The motion of a body of springs, and of the rigid body that it approximates.

    Attributes
    ----------
    t : ndarray, shape (m,)
        Times (s).
    positions : ndarray, shape (m, N, 3)
        Positions of the particles (m).
    rigid : ndarray, shape (m, N, 3)
        Positions of the particles in the rigid body (m).
    distance : ndarray, shape (m,)
        Largest distance between both positions of a particle (m).
    evaluations : int
        Number of evaluations of the forces.
    stiff_step : float
        Step limit of the stiffest oscillation (s), see :attr:`Modes.stiff_step`.
    """

    t: Floats
    positions: Floats
    rigid: Floats
    distance: Floats
    evaluations: int
    stiff_step: float


@refuses_overflow
def spring_body(
    masses: ArrayLike,
    positions: ArrayLike,
    omega: ArrayLike,
    *,
    stiffness: ArrayLike,
    t: ArrayLike,
    velocity: ArrayLike = (0.0, 0.0, 0.0),
    pairs: ArrayLike | None = None,
    rtol: float = 1e-10,
) -> SpringPath:
    """Motion of particles joined by springs, and of the rigid body that they approximate.

    At the start the springs have their rest lengths, and the particles move as a rigid body. The
    distance from the rigid body falls as ``1 / stiffness``, the steps as ``sqrt(m / stiffness)``
    (lecture notes, § 5.1: the rigid body as the limit of infinite frequencies). SciPy integrates
    the springs (DOP853), and :func:`rigid.simulate` the rigid body.

    Parameters
    ----------
    masses, positions, pairs, stiffness : array_like
        As in :func:`pair_system`.
    omega, velocity : array_like, shape (3,)
        Angular velocity (rad/s) at the start and velocity (m/s) of the centre of mass, in space.
    t : array_like, shape (m,)
        Times (s), ascending and not negative.
    rtol : float
        Relative tolerance of a step. The absolute tolerance is ``0.01 rtol`` times the size of the
        body.

    Returns
    -------
    SpringPath

    Raises
    ------
    ValueError
        If the springs do not hold the particles together to first order, as in a plane or on a
        line, or an argument is out of range.

    Examples
    --------
    >>> import numpy as np
    >>> from rigid import springs
    >>> corner = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    >>> soft, stiff = (
    ...     springs.spring_body(np.ones(4), corner, [0, 1, 0.3], stiffness=k, t=[0.0, 1.0])
    ...     for k in (1e3, 1e4)
    ... )
    >>> bool(7 < soft.distance[-1] / stiff.distance[-1] < 13)
    True
    """
    from scipy.integrate import solve_ivp

    times = sorted_times("t", t)
    if times.size == 0 or times[0] < 0.0 or times[-1] == 0.0:
        raise ValueError(
            f"t, shape {times.shape}: the springs start at t = 0; no time may be negative, and the "
            "last must be positive"
        )
    w, v = vector("omega", omega, 3), vector("velocity", velocity, 3)
    tolerance = finite_float("rtol", rtol, positive=True)
    system = pair_system(masses, positions, pairs=pairs, stiffness=stiffness)
    m, r = system.masses, system.positions
    left = int(degrees_of_freedom(r, pairs=system.pairs).first_order)
    if left != 6:
        raise ValueError(
            f"positions, pairs: the springs leave {left} coordinates to first order, a rigid body "
            "has 6"
        )
    com = m @ r / m.sum()
    arms = r - com

    def rate(_: float, state: Floats) -> Floats:
        r, v = state.reshape(2, *arms.shape)
        return np.concatenate([v, system.forces(r) / m[:, np.newaxis]], axis=None)

    start = np.concatenate([arms, np.cross(w, arms)], axis=None)
    size = float(np.abs(arms).max())
    solution = solve_ivp(
        rate,
        (0.0, times[-1]),
        start,
        method="DOP853",
        t_eval=times,
        rtol=tolerance,
        atol=0.01 * tolerance * size,
    )
    drift = com + v * times[:, np.newaxis, np.newaxis]
    moved = solution.y[: 3 * len(m)].T.reshape(-1, len(m), 3)
    turned = arms @ np.swapaxes(_turns(m, arms, w, times), -1, -2)
    return SpringPath(
        t=times,
        positions=moved + drift,
        rigid=turned + drift,
        distance=np.linalg.norm(moved - turned, axis=-1).max(axis=-1),
        evaluations=int(solution.nfev),
        stiff_step=float(system.modes().stiff_step),
    )


def _turns(masses: Floats, arms: Floats, omega: Floats, times: Floats) -> Floats:
    """Rotations (m, 3, 3) of the rigid body since the start, in space."""
    tensor = np.einsum("n,nij->ij", masses, _squares(arms))
    body, axes = Body.from_tensor(tensor)
    run = simulate(FreeBody(body), axes.T @ omega, t=times)
    matrices = run.rotation().as_matrix().reshape(-1, 3, 3)
    turns: Floats = axes @ matrices @ axes.T
    return turns


def _squares(arms: Floats) -> Floats:
    """``r² 1 - r r`` for each arm."""
    own = (arms * arms).sum(axis=-1)[:, np.newaxis, np.newaxis]
    return np.asarray(own * np.eye(3) - arms[:, :, np.newaxis] * arms[:, np.newaxis, :])


def _bodies(masses: ArrayLike, positions: ArrayLike) -> tuple[Floats, Floats]:
    r = shaped("positions", positions, None, 3)
    if r.ndim != 2 or len(r) == 0:
        raise ValueError(f"positions: expected shape (N, 3) of one or more, got {r.shape}")
    m = vector("masses", masses, len(r))
    return of_shape("masses", m, len(r), positive=True).copy(), r.copy()


def _of_pairs(name: str, value: ArrayLike, count: int) -> Floats:
    """One number for each pair, or one for all."""
    array = shaped(name, value, nonnegative=True)
    return vector(name, array, count) if array.ndim else np.full(count, array)
