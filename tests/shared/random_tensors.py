"""Random tensors of inertia, and how well they are rebuilt from their principal axes."""

import numpy as np

from physics import Floats
from rigid import inertia, rotations


def random_tensors(n: int, rng: np.random.Generator) -> Floats:
    """Of bodies of all sizes and shapes; a third each symmetric, spherical or rod, and any."""
    parts = rng.uniform(0.0, 1.0, (n, 3))
    parts[: n // 6, 0] = parts[: n // 6, 1]
    parts[n // 6 : n // 3, 1:] = parts[n // 6 : n // 3, :1]
    parts[n // 3 : n // 2, :2] = 0.0
    moments = (parts + np.roll(parts, 1, axis=1)) * 10.0 ** rng.uniform(-9.0, 9.0, (n, 1))
    turn = rotations.quaternion_to_matrix(rng.normal(size=(n, 4)))
    tensors = turn @ (moments[..., None] * np.swapaxes(turn, -1, -2))
    symmetric: Floats = 0.5 * (tensors + np.swapaxes(tensors, -1, -2))
    return symmetric


def rebuilt(axes: inertia.PrincipalAxes) -> Floats:
    product: Floats = (axes.axes * axes.moments[..., None, :]) @ np.swapaxes(axes.axes, -1, -2)
    return product


def worst_principal_axes(n: int, rng: np.random.Generator) -> float:
    """The largest error of principal axes among so many random tensors."""
    tensors = random_tensors(n, rng)
    found = inertia.principal_axes(tensors)
    scale = found.moments[:, 2]
    assert np.all(np.diff(found.moments, axis=1) >= 0.0)
    assert np.all(np.linalg.det(found.axes) > 0.0)
    residual = tensors @ found.axes - found.axes * found.moments[:, None, :]
    errors = [
        np.abs(rebuilt(found) - tensors).max(axis=(1, 2)) / scale,
        np.abs(residual).max(axis=(1, 2)) / scale,
        rotations.orthogonality_error(found.axes).error,
    ]
    return float(np.max(errors))
