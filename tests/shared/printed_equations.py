"""The equations of motion as the guides print them, solved by SciPy: a truth for any scene."""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from physics import Floats, place_on_orbit
from rigid.model.scene import Scene


def _or_zero(array: Any) -> Floats:
    return np.zeros(3) if array is None else np.array(array)


def solved(
    scene: Scene,
    omega: ArrayLike,
    attitude: ArrayLike,
    times: Floats,
    called: Callable[[float, Floats, Floats], Floats] | None = None,
) -> tuple[Floats, Floats]:
    """Rates (m, 3) and rotation matrices (m, 3, 3) at times from 0 on, by DOP853 of SciPy.

    Its tolerance is 1e-13 in each of some hundred steps. Torques are constant; the torque of a
    function is ``called(t, omega, matrix)``.
    """
    moments, rotor = np.array(scene.body.moments), _or_zero(scene.rotor)
    drag, damping = _or_zero(scene.drag), np.diag(_or_zero(None))
    damping = damping if scene.damping is None else np.array(scene.damping)
    sink = _or_zero(None if scene.dissipation is None else scene.dissipation.coefficient)
    torque = scene.torque if called is None else None
    orbit = scene.orbit

    def rate(t: float, y: Floats) -> Floats:
        w, matrix = y[:3], y[3:].reshape(3, 3)
        momentum = moments * w + rotor
        acting = np.cross(momentum, w) - damping @ w - np.linalg.norm(w) * drag * w
        acting = acting - np.cross(scene.weight, matrix[2])
        if torque is not None:
            acting = acting + torque.in_body[0] + matrix.T @ np.array(torque.in_space[0])
        if called is not None:
            acting = acting + called(t, w, matrix)
        if orbit is not None:
            place = place_on_orbit(orbit, t)
            o = matrix.T @ place
            cube = 3.0 * orbit.rate**2 / np.linalg.norm(place) ** 5
            acting = acting + cube * np.cross(o, moments * o)
        e = sink / moments * (acting / moments)
        acting = acting + np.cross(momentum, e)
        v1, v2, v3 = w + e
        hat = np.array([[0.0, -v3, v2], [v3, 0.0, -v1], [-v2, v1, 0.0]])
        return np.concatenate([acting / moments, (matrix @ hat).ravel()])

    matrix = Rotation.from_quat(attitude, scalar_first=True).as_matrix()
    start = np.concatenate([omega, matrix.ravel()])
    found = solve_ivp(rate, (0.0, times[-1]), start, "DOP853", t_eval=times, rtol=1e-13, atol=1e-15)
    return found.y[:3].T, found.y[3:].T.reshape(-1, 3, 3)
