"""The equations of motion as the guides print them, solved by SciPy: a truth for any scene."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from physics import Floats, cross, place_on_orbit
from rigid.model.scene import Scene


def _or_zero(array: Any) -> Floats:
    return np.zeros(3) if array is None else np.array(array)


Called = Callable[[float, Floats, Floats], Floats]
"""The torque of a function: of time, rates and matrix."""


def printed(scene: Scene, called: Called | None = None) -> Callable[[float, Floats], Floats]:
    """The rates of change of rates and rotation matrix, the rows of which follow the rates.

    Torques of the scene are constant.
    """
    moments, rotor = np.array(scene.body.moments), _or_zero(scene.rotor)
    drag, damping = _or_zero(scene.drag), np.diag(_or_zero(None))
    damping = damping if scene.damping is None else np.array(scene.damping)
    sink = _or_zero(None if scene.dissipation is None else scene.dissipation.coefficient)
    torque = scene.torque if called is None else None
    weight, orbit = np.array(scene.weight), scene.orbit

    def rate(t: float, y: Floats) -> Floats:
        w, matrix = y[:3], y[3:].reshape(3, 3)
        momentum = moments * w + rotor
        acting = cross(momentum, w) - damping @ w - np.linalg.norm(w) * drag * w
        acting = acting - cross(weight, matrix[2])
        if torque is not None:
            acting = acting + torque.in_body[0] + matrix.T @ np.array(torque.in_space[0])
        if called is not None:
            acting = acting + called(t, w, matrix)
        if orbit is not None:
            place = place_on_orbit(orbit, t)
            o = matrix.T @ place
            cube = 3.0 * orbit.rate**2 / np.linalg.norm(place) ** 5
            acting = acting + cube * cross(o, moments * o)
        e = sink / moments * (acting / moments)
        acting = acting + cross(momentum, e)
        v1, v2, v3 = w + e
        hat = np.array([[0.0, -v3, v2], [v3, 0.0, -v1], [-v2, v1, 0.0]])
        return np.concatenate([acting / moments, (matrix @ hat).ravel()])

    return rate


def starting(omega: ArrayLike, attitude: ArrayLike) -> Floats:
    """The state for :func:`printed`."""
    matrix = Rotation.from_quat(attitude, scalar_first=True).as_matrix()
    return np.concatenate([omega, matrix.ravel()])


def solved(
    scene: Scene,
    omega: ArrayLike,
    attitude: ArrayLike,
    times: ArrayLike,
    called: Called | None = None,
) -> tuple[Floats, Floats]:
    """Rates (m, 3) and rotation matrices (m, 3, 3) at times from 0 on, by DOP853 of SciPy.

    Its tolerance is 1e-13 in each of some hundred steps.
    """
    ends, start = (0.0, np.max(times)), starting(omega, attitude)
    rate = printed(scene, called)
    found = solve_ivp(rate, ends, start, "DOP853", t_eval=times, rtol=1e-13, atol=1e-15)
    return found.y[:3].T, found.y[3:].T.reshape(-1, 3, 3)


def with_states(
    moments: Floats,
    acting: Callable[[float, Floats, Floats, Floats], tuple[Floats, Floats]],
    start: Sequence[ArrayLike],
    times: ArrayLike,
    *,
    rtol: float = 1e-13,
    atol: ArrayLike = 1e-16,
) -> Floats:
    """Rates, quaternions and further states at times from 0 on, by DOP853 of SciPy.

    ``acting(t, omega, quaternion, states)`` is the torque and the rates of the states.
    """

    def slope(t: float, y: Floats) -> Floats:
        omega, q = y[:3], y[3:7] / np.linalg.norm(y[3:7])
        torque, rates = acting(t, omega, q, y[7:])
        turning = 0.5 * np.concatenate([[-q[1:] @ omega], q[0] * omega + cross(q[1:], omega)])
        gained = (torque - cross(omega, moments * omega)) / moments
        return np.concatenate([gained, turning, rates])

    ends, first = (0.0, np.max(times)), np.concatenate(start)
    found = solve_ivp(slope, ends, first, "DOP853", times, rtol=rtol, atol=atol)
    states: Floats = found.y.T
    return states


def gathers(
    t: float,
    omega: Any,
    attitude: Any,
    data: Any,
    torque: Any,
    states: Any,
    rates: Any,
    orbit_position: Any,
) -> None:
    """The integral of the place over the time."""
    for k in range(3):
        torque[k] = 0.0
        rates[k] = orbit_position[k]
