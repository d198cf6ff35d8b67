"""Moments and weight of a body about a fixed point, from its mass and its centre of mass."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from .. import _core
from .._checks.arguments import brief, finite_float, vector
from .._checks.arrays import Floats
from .batch import Vector, three


def about_pivot(
    tensor: Floats, mass: float, com: ArrayLike, g: float
) -> tuple[Vector, Floats, float, Vector]:
    """Principal moments, principal axes, ``mgl`` and direction of the centre of mass of a top.

    ``I + m (r² 1 - r ⊗ r)`` is the tensor about the fixed point, with ``r = com`` from the fixed
    point to the centre of mass (Goldstein, *Classical Mechanics*, § 5.3).

    Parameters
    ----------
    tensor : ndarray, shape (3, 3)
        Tensor of inertia about the centre of mass (kg m²).
    mass : float
        Mass (kg).
    com : array_like, shape (3,)
        Centre of mass, from the fixed point (m).
    g : float
        Acceleration of gravity (m/s²).
    """
    r = vector("com", com, 3)
    g = finite_float("g", g, nonnegative=True)
    x, y, z = r.tolist()
    squares = np.diag([y * y + z * z, x * x + z * z, x * x + y * y])
    products = -np.outer(r, r)
    np.fill_diagonal(products, 0.0)
    total = tensor + mass * (squares + products)
    if np.count_nonzero(total - np.diag(np.diagonal(total))):
        principal, columns = _core.principal_axes(total.tolist())
        axes = np.array(columns)
    else:
        principal, axes = np.diagonal(total).tolist(), np.eye(3)
    length = float(np.linalg.norm(r))
    direction = axes.T @ (r / length if length else np.array([0.0, 0.0, 1.0]))
    direction = direction / np.linalg.norm(direction)
    return three(principal), axes, mass * g * length, three(direction)


def checked_properties(properties: object) -> tuple[Floats, float, Floats]:
    """Tensor about the centre of mass, mass and centre of mass of one body."""
    from ..solids.mass_properties import MassProperties

    if not isinstance(properties, MassProperties):
        raise TypeError(f"properties = {brief(properties)}: must be a rigid.inertia.MassProperties")
    if properties.mass.ndim:
        raise ValueError(f"properties: expected one body, got shape {properties.mass.shape}")
    return properties.tensor, float(properties.mass), properties.centre
