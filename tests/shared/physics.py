"""What the tests share: the methods, reference trajectories, and physics written down once more."""

import json
import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import brentq

import rigid
from rigid.model.scene import Scene

Floats = NDArray[np.float64]

#: All methods.
EVERY_METHOD = rigid.methods()

#: Everything that is said of a method through Python is tested over this list: those that move any
#: body at any output time. What is said of compositions, processed kernels and drifts (order,
#: structure, bits) is tested on the core, over its own list: tests/rust. Series of all orders are
#: one loop; here are the lowest order, the lowest that sums with compensation, and the highest.
METHODS = tuple(
    method
    for method in EVERY_METHOD
    if method.name not in ("taylor20", "splitting4", "splitting8", "etd4")
    and method.family not in ("free motion and kicks", "Moser–Veselov")
)

#: The names of all, and as an error message lists those of a run.
NAMES = [method.name for method in EVERY_METHOD]
LISTED = ", ".join(map(repr, ["exact", *NAMES]))

#: Unit roundoff of float64.
ROUNDOFF = 2.0**-53

GOLDEN = Path(__file__).parents[1] / "golden"


@dataclass(frozen=True)
class Golden:
    """A trajectory known to 25 digits, in the conventions of the library."""

    id: str
    scene: Scene
    omega0: Floats
    attitude0: Floats
    t: Floats
    omega: Floats
    attitude: Floats
    energy: Floats
    L_space: Floats
    kappa_omega: Floats
    kappa_att: Floats

    def step_turning(self, angle: float) -> float:
        """A step in which the body turns or swings by at most about that angle (rad)."""
        rate = float(np.linalg.norm(self.omega, axis=-1).max())
        swinging = np.linalg.norm(self.scene.weight) / min(self.scene.body.moments[:2])
        return angle / (rate + float(np.sqrt(swinging)))

    def run(self, method: str, *, until: float = np.inf, **options: Any) -> rigid.Run:
        """The trajectory computed at the reference times up to ``until``."""
        times = self.t[self.t <= until]
        return rigid.simulate(
            self.scene, self.omega0, self.attitude0, t=times, method=method, **options
        )


def golden(family: str) -> list[Golden]:
    """The scenes of a file of reference trajectories whose body axes are principal axes."""
    scenes = json.loads((GOLDEN / f"{family}.json").read_text())["scenes"]
    return [_golden(scene) for scene in scenes if not isinstance(scene["inertia"][0], list)]


def golden_scene(identifier: str) -> Golden:
    """The scene with that id."""
    (found,) = (case for case in golden(identifier.split("/")[0]) if case.id == identifier)
    return found


def _golden(scene: dict[str, Any]) -> Golden:
    def column(key: str) -> Floats:
        # A condition number that does not exist (no rate to be relative to) is null: none granted.
        values = [sample[key] for sample in scene["samples"]]
        return np.array([0.0 if value is None else value for value in values]).astype(np.float64)

    com = np.array(scene["com"])
    distance = float(np.linalg.norm(com))
    mgl = scene["mass"] * scene["gravity"] * distance
    body = rigid.Body(scene["inertia"])
    outside: dict[str, Any] = {}
    if any(scene.get("torque_body", [])):
        outside["torque"] = rigid.Torque.body(scene["torque_body"])
    if scene.get("damping"):
        outside["damping"] = scene["damping"]
    return Golden(
        id=scene["id"],
        scene=(
            rigid.HeavyTop(body, mgl=mgl, com=com / distance, **outside)
            if mgl
            else rigid.FreeBody(body, **outside)
        ),
        omega0=np.array(scene["omega0"]),
        attitude0=np.roll(scene["q0"], 1),
        t=column("t"),
        omega=column("omega"),
        attitude=np.roll(column("q"), 1, axis=-1),
        energy=column("energy"),
        L_space=column("L_space"),
        kappa_omega=column("kappa_omega"),
        kappa_att=column("kappa_att"),
    )


def telling(step: float, method: rigid.Method) -> float:
    """A step at which a method errs about as much as one of order 4 does at ``step``."""
    return float(step ** (4.0 / max(method.order, 4)))


def moves(method: rigid.Method, scene: Scene) -> bool:
    """Whether the method knows what acts on the scene."""
    return (method.tops or not scene.directions) and set(scene.forces) <= set(method.forces)


def present(array: Floats | None) -> Floats:
    """The array, which must be there."""
    assert array is not None
    return array


def rotation_angle(attitude: ArrayLike, reference: ArrayLike) -> Floats:
    """Angle between two attitudes (rad), small angles without cancellation; lengths and signs free.

    Scalar and vector part of ``conj(reference) * attitude`` are the cosine and sine of its half.
    """
    a, b = (np.moveaxis(np.asarray(q, dtype=np.float64), -1, 0) for q in (attitude, reference))
    vector = np.array(
        [
            b[0] * a[1] - b[1] * a[0] - b[2] * a[3] + b[3] * a[2],
            b[0] * a[2] - b[2] * a[0] - b[3] * a[1] + b[1] * a[3],
            b[0] * a[3] - b[3] * a[0] - b[1] * a[2] + b[2] * a[1],
        ]
    )
    angle: Floats = 2.0 * np.arctan2(np.linalg.norm(vector, axis=0), np.abs((a * b).sum(axis=0)))
    return angle


def rotation_matrix(attitude: ArrayLike) -> Floats:
    """``R`` with ``v_space = R v_body``, shape (..., 3, 3)."""
    q = np.asarray(attitude, dtype=np.float64)
    w, x, y, z = np.moveaxis(q / np.linalg.norm(q, axis=-1, keepdims=True), -1, 0)
    rows = [
        [w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z],
    ]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))


def quaternion_product(p: Floats, q: Floats) -> Floats:
    """Product of quaternions, scalar first, shape (..., 4)."""
    a, b, c, d = np.moveaxis(p, -1, 0)
    w, x, y, z = np.moveaxis(q, -1, 0)
    rows = [
        a * w - b * x - c * y - d * z,
        a * x + b * w + c * z - d * y,
        a * y + c * w + d * x - b * z,
        a * z + d * w + b * y - c * x,
    ]
    return np.stack(np.broadcast_arrays(*rows), axis=-1)


def gamma_of(attitude: ArrayLike) -> Floats:
    """``gamma = R.T e3``, the upward vertical seen from the body, shape (..., 3)."""
    return rotation_matrix(attitude)[..., 2, :]


def angular_momentum(scene: Scene, omega: ArrayLike) -> Floats:
    """``I omega``, in the body, shape (..., 3)."""
    momentum: Floats = np.array(scene.body.moments) * np.asarray(omega)
    return momentum


def energy(scene: Scene, omega: ArrayLike, gamma: ArrayLike | None = None) -> Floats:
    """Kinetic and, with ``gamma``, potential energy, shape (...)."""
    kinetic: Floats = 0.5 * (angular_momentum(scene, omega) * np.asarray(omega)).sum(axis=-1)
    return kinetic if gamma is None else kinetic + np.asarray(gamma) @ scene.weight


def tilted(angle: float) -> Floats:
    """The attitude turned about axis 1 of space by ``angle`` (rad)."""
    return np.array([np.cos(angle / 2), np.sin(angle / 2), 0.0, 0.0])


def golden_number(name: str) -> Any:
    """A number, or an array of them, of the table of worked cases."""
    value = json.loads((GOLDEN / "worked_cases.json").read_text())[name]
    return np.array(value, dtype=np.float64) if isinstance(value, list) else float(value)


def rotated(attitude: Floats, vector: Floats) -> Floats:
    """A vector of the body in space, shape (..., 3)."""
    w, x = attitude[..., :1], attitude[..., 1:]
    twice = 2.0 * np.cross(x, vector)
    turned: Floats = vector + w * twice + np.cross(x, twice)
    return turned


def cross(u: ArrayLike, v: ArrayLike) -> Floats:
    """The vector product of two vectors, in a tenth of the time of NumPy's, of arrays of them."""
    (u1, u2, u3), (v1, v2, v3) = np.asarray(u).tolist(), np.asarray(v).tolist()
    return np.array([u2 * v3 - u3 * v2, u3 * v1 - u1 * v3, u1 * v2 - u2 * v1])


def angle_between(u: Floats, v: Floats) -> Floats:
    """Angles between vectors, accurate for small and for large ones (W. Kahan)."""
    tiny = np.finfo(np.float64).tiny  # a body at rest has no direction
    u, v = (x / np.maximum(np.linalg.norm(x, axis=-1, keepdims=True), tiny) for x in (u, v))
    half = np.arctan2(np.linalg.norm(u - v, axis=-1), np.linalg.norm(u + v, axis=-1))
    angle: Floats = 2.0 * half
    return angle


def slope(values: ArrayLike, step: float) -> Floats:
    """Derivative at the middle of five equidistant values; its error is step⁴/30 of the fifth."""
    v = np.asarray(values, dtype=np.float64)
    change: Floats = (v[0] - 8.0 * v[1] + 8.0 * v[3] - v[4]) / (12.0 * step)
    return change


def derivative(
    function: Callable[[float], Floats], t: float, step: float, order: int = 1
) -> Floats:
    """By central differences of sixth order, of the first or second order."""
    weights = {
        1: np.array([-1, 9, -45, 0, 45, -9, 1]) / (60 * step),
        2: np.array([2, -27, 270, -490, 270, -27, 2]) / (180 * step**2),
    }[order]
    values = np.array([function(t + k * step) for k in range(-3, 4)])
    return np.tensordot(weights, values, axes=1)


def tensor_of_points(masses: Floats, points: Floats) -> Floats:
    """The tensor of inertia of mass points about the origin, term by term."""
    total = np.zeros((3, 3))
    for mass, r in zip(masses, points, strict=True):
        total += mass * ((r @ r) * np.eye(3) - np.outer(r, r))
    return total


def place_on_orbit(orbit: rigid.Orbit, t: float) -> NDArray[np.float64]:
    """From the planet to the body in space, by bisection of Kepler's equation."""
    mean, e = float(orbit.rate) * t + float(orbit.anomaly), float(orbit.eccentricity)
    if e > 1.0:
        far = np.arcsinh(mean / (e - 1.0))
        ends = min(2.0 * far, -1e-300), max(2.0 * far, 1e-300)
        anomaly = brentq(lambda at: e * math.sinh(at) - at - mean, *ends, xtol=1e-15)
        across = cross(orbit.normal, orbit.periapsis) * np.sqrt(e**2 - 1.0)
        passing: NDArray[np.float64] = (e - np.cosh(anomaly)) * np.array(orbit.periapsis)
        passing += np.sinh(anomaly) * across
        return passing
    anomaly = brentq(lambda at: at - e * math.sin(at) - mean, mean - 1.0, mean + 1.0, xtol=1e-15)
    across = cross(orbit.normal, orbit.periapsis) * np.sqrt(1.0 - e**2)
    along = (np.cos(anomaly) - e) * np.array(orbit.periapsis)
    place: NDArray[np.float64] = along + np.sin(anomaly) * across
    return place
