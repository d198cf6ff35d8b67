"""Euler's equations and their constants of motion."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from .._checks.arguments import numbers, one_of, require, times_of_each
from .._checks.arrays import AttitudeLike, Floats, attitudes, of_size_one, vectors
from .._checks.overflow import refuses_overflow
from ..model.batch import Shape, batch_shape
from ..model.body_like import BodyLike, moments_of
from ..model.frame import turned
from ..model.sampled import RotorTable
from ..model.scene import HeavyTop, Scene, check_scene, scene_from_dict
from ..model.torque import Torque
from ..rotations.apply import to_body, to_space
from ..solve.run import Run

NEXT, AFTER = [1, 2, 0], [2, 0, 1]


@refuses_overflow
def euler_rhs(
    body: BodyLike,
    omega: ArrayLike,
    torque: ArrayLike | None = None,
    *,
    attitude: AttitudeLike | None = None,
    frame: str = "body",
) -> Floats:
    """Angular acceleration by Euler's equations, ``I omega' = (I omega) × omega + torque``.

    ``omega1' = ((I2 - I3) omega2 omega3 + N1) / I1`` and cyclic: Landau and Lifshitz, *Mechanics*,
    § 36; Ercan 2016, eqs. (41), (42).

    Parameters
    ----------
    body : Body, FreeBody or array_like, shape (..., 3)
        The body, or principal moments (kg m²).
    omega : array_like, shape (..., 3)
        Angular velocity in the body (rad/s).
    torque : array_like, shape (..., 3), optional
        Torque (N m) about the fixed point, or about the centre of mass if there is none.
    attitude : array_like, shape (..., 4), or scipy Rotation, optional
        Attitude, needed for a torque in space.
    frame : {"body", "space"}
        Frame of the components of the torque.

    Returns
    -------
    ndarray, shape (..., 3)
        ``omega'`` in the body (rad/s²). The derivative of the vector omega is the same vector in
        the body and in space.

    Raises
    ------
    ValueError
        If a value is not finite, no body has the moments, or a torque in space lacks its attitude.

    Examples
    --------
    >>> from rigid import free
    >>> free.euler_rhs((1.0, 2.0, 3.0), [1.0, 2.0, 3.0])
    array([-6.        ,  3.        , -0.66666667])
    """
    moments, rates = moments_of(body), vectors("omega", omega)
    differences = moments[..., NEXT] - moments[..., AFTER]
    # Differences of equal moments are exactly zero; the product I omega × omega is not.
    moved = differences * rates[..., NEXT] * rates[..., AFTER]
    if torque is not None:
        moved = moved + _body_torque(torque, attitude, frame)
    return moved / moments


def _body_torque(torque: ArrayLike, attitude: AttitudeLike | None, frame: str) -> Floats:
    array = vectors("torque", torque)
    if one_of("frame", frame, ("body", "space")) == "body":
        return array
    if attitude is None:
        raise ValueError("frame = 'space': a torque in space needs the attitude of the body")
    return to_body(attitudes(attitude), array)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Invariants:
    """Energy and angular momentum of states; the last of the leading axes counts times.

    Attributes
    ----------
    kinetic, potential, energy : ndarray, shape (...)
        ``½ omega·I omega``, ``mgl com·gamma`` and their sum (J).
    L : ndarray, shape (...)
        Size of the angular momentum (kg m²/s); constant for a free body.
    L_body : ndarray, shape (..., 3)
        Angular momentum in the body, ``I omega``; of a run along its body axes, :attr:`Run.frame`.
    L_space : ndarray, shape (..., 3), or None
        Angular momentum in space, if the attitude is known; constant for a free body.
    p_phi : ndarray, shape (...), or None
        Angular momentum about the vertical, if the vertical is known; constant for free bodies and
        heavy tops.
    p_psi : ndarray, shape (...), or None
        Angular momentum of a heavy top about the direction to the centre of mass; constant for a
        symmetric top only.
    """

    kinetic: Floats
    potential: Floats
    energy: Floats
    L: Floats
    L_body: Floats
    L_space: Floats | None
    p_phi: Floats | None
    p_psi: Floats | None

    def drift(self, name: str) -> Floats:
        """The largest difference of a quantity from its first value, over the known times.

        Parameters
        ----------
        name : str
            One of the attributes; for a vector, the length of the difference counts.

        Returns
        -------
        ndarray

        Raises
        ------
        ValueError
            If the quantity is unknown or there are no times to compare.

        Examples
        --------
        >>> import numpy as np, rigid
        >>> body = rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0)))
        >>> run = rigid.simulate(body, [0.1, 1.0, 0.1], t=np.linspace(0.0, 50.0, 11))
        >>> bool(rigid.free.invariants(run).drift("energy") < 1e-14)
        True
        """
        values = getattr(self, one_of("name", name, self.__slots__))
        if values is None:
            raise ValueError(f"{name} is not known: it needs an attitude or a vertical, or a top")
        if name.startswith("L_"):
            values = np.moveaxis(values, -1, 0)
        if self.energy.ndim == 0 or self.energy.shape[-1] == 0:
            raise ValueError(f"{name} of shape {values.shape}: has no times to compare")
        change = np.abs(values - values[..., :1])
        if name.startswith("L_"):
            change = np.linalg.norm(change, axis=0)
        return np.asarray(np.fmax.reduce(change, axis=-1))[()]


def invariants(
    motion: Run | Scene,
    omega: ArrayLike | None = None,
    attitude: AttitudeLike | None = None,
) -> Invariants:
    """Energy and angular momentum of a run, or of given states.

    The energy and the angular momentum in space of a free body are constant, but the angular
    velocity is not (Ercan 2016, § 2, calls the rotation constant; erratum D-02). For a heavy top
    the energy and the angular momentum about the vertical are constant; for a symmetric top also
    the angular momentum about the symmetry axis (Landau and Lifshitz, § 35).

    Parameters
    ----------
    motion : Run, FreeBody or HeavyTop
        A run of :func:`rigid.simulate`, or the scene to which the states belong; of one body or
        many.
    omega : array_like, shape (..., 3)
        Angular velocity in the body (rad/s); its leading axes broadcast with the attitudes and the
        bodies.
    attitude : array_like, shape (..., 4), or scipy Rotation, optional
        Attitudes; required for a top.

    Returns
    -------
    Invariants

    Raises
    ------
    TypeError
        If ``motion`` is neither a run nor a scene.
    ValueError
        If states are missing or not finite, if their axes do not broadcast with the axes of the
        bodies, or if you pass states together with a run.

    Examples
    --------
    >>> import numpy as np, rigid
    >>> body = rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0)))
    >>> run = rigid.simulate(body, [0.02, 1.0, 0.02], t=np.linspace(0.0, 40.0, 401))
    >>> kept = rigid.free.invariants(run)
    >>> bool(kept.drift("L_space") < 1e-12), bool(np.ptp(run.omega[:, 1]) > 1.9)
    (True, True)
    """
    scene, rates, quaternions, gamma = _states(motion, omega, attitude)
    shape = rates.shape[:-1]
    if not isinstance(motion, Run):
        shape = batch_shape({"scene": scene.shape, **_axes(rates, quaternions)})
    momentum = _of_each(scene.body.moments, motion) * rates
    kinetic = 0.5 * (momentum * rates).sum(axis=-1)
    if scene.rotor is not None and isinstance(motion, Run):
        momentum = momentum + scene.momentum_of_rotor(motion.t)
    elif isinstance(scene.rotor, RotorTable):
        raise ValueError(f"rotor = {scene.rotor!r}: is a table, which only invariants(run) knows")
    elif scene.rotor is not None:
        momentum = momentum + scene.rotor
    unit, power = of_size_one(momentum)
    potential, p_psi = np.zeros_like(kinetic), None
    if "gamma" in scene.directions:
        if gamma is None:
            raise ValueError("attitude = None: the energy of a heavy top needs it")
        potential = _along(gamma, _of_each(scene.weight, motion))
    if isinstance(scene, HeavyTop):
        p_psi = _along(momentum, _of_each(scene.com, motion))
    return Invariants(
        kinetic=_filled(kinetic, shape),
        potential=_filled(potential, shape),
        energy=_filled(kinetic + potential, shape),
        L=_filled(np.ldexp(np.linalg.norm(unit, axis=-1), power[..., 0]), shape),
        L_body=_filled(_turned(motion, momentum), (*shape, 3)),
        L_space=None
        if quaternions is None
        else _filled(to_space(quaternions, momentum), (*shape, 3)),
        p_phi=None if gamma is None else _filled((momentum * gamma).sum(axis=-1), shape),
        p_psi=None if p_psi is None else _filled(p_psi, shape),
    )


def _filled(array: Floats, shape: Shape) -> Floats:
    """The array with all these axes, also those along which it does not vary."""
    if np.shape(array) == shape:
        return array[()]
    return np.array(np.broadcast_to(array, shape))


def _axes(rates: Floats, quaternions: Floats | None, last: int = 1) -> dict[str, Shape]:
    """The axes of states, without the ``last`` ones of each array."""
    axes = {"omega": rates.shape[:-last]}
    return axes if quaternions is None else {**axes, "attitude": quaternions.shape[:-last]}


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PowerBalance:
    """Power and kinetic energy at the times of a motion.

    Attributes
    ----------
    power : ndarray, shape (..., m)
        Power of the torque, ``torque·omega`` (W), less what an energy sink drains.
    rate : ndarray, shape (..., m)
        Rate of change of the kinetic energy (W), by differences of order 2.
    residual : ndarray, shape (..., m)
        ``rate - power``: zero up to the error of the differences.
    """

    power: Floats
    rate: Floats
    residual: Floats


def power_balance(
    motion: Run | Scene,
    omega: ArrayLike | None = None,
    attitude: AttitudeLike | None = None,
    *,
    t: ArrayLike | None = None,
    torque: ArrayLike | None = None,
    frame: str = "body",
) -> PowerBalance:
    """Rate of change of the kinetic energy and power of the torque: ``dT/dt = torque·omega``.

    Ercan 2016, § 9.2. The torques of the weight of a heavy top and of a gravity gradient are
    included.

    Parameters
    ----------
    motion, omega, attitude
        As in :func:`invariants`; the rates have shape (..., m, 3), and the axes before m broadcast
        with the axes of the bodies.
    t : array_like, shape (m,) or (..., m)
        Times of the states (s), at least three; the same for all bodies, or for each. Omit them for
        a run.
    torque : array_like, shape (..., m, 3), optional
        Additional torque (N m).
    frame : {"body", "space"}
        Frame of the components of the torque: of a run the body axes are :attr:`Run.frame`.

    Returns
    -------
    PowerBalance

    Raises
    ------
    ValueError
        As in :func:`invariants`, and if there are fewer than three distinct times.

    Examples
    --------
    >>> import numpy as np, rigid
    >>> top = rigid.HeavyTop(rigid.Body((1.0, 1.5, 0.5)), mgl=1.0)
    >>> run = rigid.simulate(top, [0.2, 0.1, 5.0], t=np.linspace(0.0, 1.0, 1001))
    >>> bool(np.abs(rigid.free.power_balance(run).residual).max() < 1e-5)
    True
    """
    scene, rates, quaternions, gamma = _states(motion, omega, attitude)
    if isinstance(motion, Run) and t is not None:
        raise ValueError("t: a run has its own times")
    times = times_of_each("t", motion.t if isinstance(motion, Run) else [] if t is None else t)
    shape = batch_shape(
        {"scene": scene.shape, **_axes(rates, quaternions, 2), "t": times.shape[:-1]}
    )
    count = times.shape[-1]
    if count < 3 or rates.shape[-2:-1] != (count,):
        raise ValueError(
            f"t of shape {times.shape}, omega of shape {rates.shape}: the rate of the kinetic "
            "energy needs three distinct times or more, and states at each"
        )
    rule = "is given twice; the rate of the kinetic energy needs distinct times"
    require("t", times[..., :-1], np.diff(times) > 0.0, rule)
    rates = np.broadcast_to(rates, (*shape, count, 3))
    kinetic = 0.5 * (_at_times(scene.body.moments) * rates * rates).sum(axis=-1)
    acting = np.zeros(3)
    if scene.torque is not None:
        own, in_space = _torque_at(scene.torque, times, shape)
        acting = acting + own
        if scene.torque.acts_in_space:
            acting = acting + _body_torque(in_space, quaternions, "space")
    if scene.damping is not None:
        acting = acting - rates @ np.array(scene.damping)
    rotor = scene.momentum_of_rotor(times)
    if isinstance(scene.rotor, RotorTable):
        change = _time_derivative(np.moveaxis(rotor, -1, 0), times)
        acting = acting - np.moveaxis(change, 0, -1)
    for force, value in scene.further():
        if force.name not in ("orbit", "rotor"):  # a constant rotor has no power
            acting = acting + force.torque(_at_times(force.numbers(value)), rates)
    if "function" in scene.forces:
        raise ValueError("torque: the torque of a function is not known from the states")
    if "gamma" in scene.directions:
        if gamma is None:
            raise ValueError("attitude = None: the torque of the weight needs it")
        acting = acting + np.cross(gamma, _at_times(scene.weight))
    if torque is not None:
        added = _body_torque(torque, quaternions, frame)
        acting = acting + (_turned(motion, added, back=True) if frame == "body" else added)
    acting = acting + _gravity_gradient(scene, quaternions, times)
    power = (acting * rates).sum(axis=-1) + _sink_power(scene, rates, acting, rotor)
    rate = _time_derivative(kinetic, times)
    return PowerBalance(power=power, rate=rate, residual=rate - power)


def _gravity_gradient(scene: Scene, quaternions: Floats | None, times: Floats) -> Floats:
    """The torque of the gravity gradient, ``3 n² (a/r)³ o × I o``; zero without an orbit."""
    orbit = scene.orbit
    if orbit is None:
        return np.zeros(3)
    if quaternions is None:
        raise ValueError("attitude = None: the torque of a gravity gradient needs it")
    place = orbit.position(times)
    distance = np.linalg.norm(place, axis=-1, keepdims=True)
    o = to_body(quaternions, place / distance)
    strength = 3.0 * np.asarray(orbit.gm)[..., np.newaxis, np.newaxis] / distance**3
    torque: Floats = strength * np.cross(o, _at_times(scene.body.moments) * o)
    return torque


def _sink_power(scene: Scene, rates: Floats, acting: Floats, rotor: Floats) -> Floats | float:
    """The power of an energy sink, ``omega·(L × I⁻¹ P omega')``."""
    if scene.dissipation is None:
        return 0.0
    moments = _at_times(scene.body.moments)
    momentum = moments * rates + rotor
    change = (np.cross(momentum, rates) + acting) / moments
    turn = _at_times(scene.dissipation.coefficient) * change / moments
    power: Floats = (rates * np.cross(momentum, turn)).sum(axis=-1)
    return power


def _torque_at(torque: Torque, times: Floats, shape: Shape) -> tuple[Floats, Floats]:
    """Torque in the body and in space at the times of all bodies, or of each."""
    if times.ndim == 1:
        return torque.at(times)
    own = np.broadcast_to(times, (*shape, times.shape[-1]))
    body, space = np.empty((2, *own.shape, 3))
    for index in np.ndindex(shape):
        body[index], space[index] = torque.of(shape, index).at(own[index])
    return body, space


def _time_derivative(values: Floats, times: Floats) -> Floats:
    """Derivative along the last axis, by differences of order 2."""
    if times.ndim == 1:
        return np.asarray(np.gradient(values, times, axis=-1, edge_order=2))
    derivative = np.empty(values.shape)
    own = np.broadcast_to(times, values.shape)
    for index in np.ndindex(values.shape[:-1]):
        derivative[index] = np.gradient(values[index], own[index], edge_order=2)
    return derivative


def _at_times(vectors: ArrayLike) -> Floats:
    """Vectors of the bodies, shaped to broadcast with states that have an axis for the times."""
    return np.asarray(vectors)[..., np.newaxis, :]


def _of_each(vectors: ArrayLike, motion: Run | Scene) -> Floats:
    """Vectors of the bodies, shaped to broadcast with the states of a run."""
    array = np.asarray(vectors)
    return _at_times(array) if isinstance(motion, Run) and array.ndim > 1 else array


def _turned(motion: Run | Scene, vectors: Floats, *, back: bool = False) -> Floats:
    """Vectors from the principal axes to the body axes of a run, or ``back``, if these differ."""
    axes = motion.frame if isinstance(motion, Run) else None
    if axes is None:
        return vectors
    return turned(axes.T if back else axes, vectors)


def _along(vectors: Floats, of_bodies: Floats) -> Floats:
    """Products of vectors with the vector of all bodies, or with the vector of each body."""
    if of_bodies.ndim == 1:
        product: Floats = vectors @ of_bodies
    else:
        product = (vectors * of_bodies).sum(axis=-1)
    return product


def _states(
    motion: Run | Scene, omega: ArrayLike | None, attitude: AttitudeLike | None
) -> tuple[Scene, Floats, Floats | None, Floats | None]:
    """Scene, rates, and, if known, attitudes and upward verticals in the body."""
    if isinstance(motion, Run):
        if omega is not None or attitude is not None:
            raise ValueError("omega, attitude: a run has its own states")
        motion = motion.in_frame(None) if motion.frame is not None else motion
        scene = scene_from_dict(motion.spec["scene"])
        rates, attitude, gamma = numbers("omega", motion.omega), motion.attitude, motion.gamma
        if attitude is not None:  # NaN after the event that ended a body, as the rates are
            attitude = np.nan_to_num(attitude, nan=1.0)
    else:
        scene, gamma = check_scene(motion, many=True), None
        if omega is None:
            raise ValueError("omega = None: states are needed, or a run")
        rates = vectors("omega", omega)
    quaternions = None if attitude is None else attitudes(attitude)
    if quaternions is not None:
        batch_shape(_axes(rates, quaternions))
        if gamma is None:
            gamma = to_body(quaternions, np.array([0.0, 0.0, 1.0]))
    return scene, rates, quaternions, gamma
