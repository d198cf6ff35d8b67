"""Linear damping of a body: the matrices that its coefficients are."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._checks.arguments import first_place, numbers
from .._checks.arrays import Floats
from .batch import Shape, Vector, frozen, three
from .torque import forces_of

Damping: TypeAlias = tuple[Vector, Vector, Vector] | Floats
"""The damping matrix of one body, or of many with shape (..., 3, 3)."""


def checked_damping(damping: ArrayLike, shape: Shape) -> Damping | None:
    """The matrices of a damping given by coefficients or matrices; None if all are zero.

    ``shape`` has the axes of the bodies that the damping is for.

    Raises
    ------
    ValueError
        If it has another shape, is not finite, not symmetric, or would add energy.
    """
    array = numbers("damping", damping)
    width = _components(array.shape, shape)
    finite = np.isfinite(array)
    if not finite.all():
        raise ValueError(f"{_whose(array, finite, width)}: must be finite")
    if width < 2:
        if np.any(array < 0.0):
            raise ValueError(f"{_whose(array, array >= 0.0, width)}: must not be negative")
        axes = array if width else array[..., np.newaxis]
        array = axes[..., np.newaxis] * np.eye(3)
    turned = np.swapaxes(array, -1, -2)
    size = np.abs(array).max(axis=(-2, -1), keepdims=True, initial=0.0)
    symmetric = np.abs(array - turned) <= 1e-12 * size
    if not symmetric.all():
        raise ValueError(f"{_whose(array, symmetric, 2)}: must be a symmetric matrix")
    if not size.any():
        return None
    # As a difference: the sum of two huge entries could overflow.
    matrices = array + 0.5 * (turned - array)
    _check_adds_no_energy(matrices)
    if shape and matrices.size == 9:
        matrices = matrices.reshape(3, 3)
    return matrices_of(matrices)


def matrices_of(matrices: ArrayLike) -> Damping:
    """A damping matrix as tuples, the matrices of many bodies as an array."""
    array = np.asarray(matrices)
    if array.ndim > 2:
        return frozen(array)
    first, second, third = map(three, array)
    return first, second, third


def _components(given: Shape, shape: Shape) -> int:
    """How many of the last axes of a damping are the axes of one body."""

    def fits(width: int) -> bool:
        if given[len(given) - width :] != (3,) * width or width > len(given):
            return False
        if not shape:
            return True
        try:
            return np.broadcast_shapes(given[: len(given) - width], shape) == shape
        except ValueError:
            return False

    ways = [width for width in (2, 1, 0) if fits(width)]
    if not ways:
        raise ValueError(
            f"damping: expected shape (), (3,) or (3, 3) after the axes {shape} of the bodies, "
            f"got {given}"
        )
    if len(ways) > 1 and shape:
        raise ValueError(
            f"damping: shape {given} can be read in two ways for bodies of shape {shape}; write "
            f"{(*shape, 3, 3)} for a matrix of each, {(*(1,) * len(shape), 3)} for three "
            f"coefficients and {(*(1,) * len(shape), 3, 3)} for a matrix of all"
        )
    return ways[0]


def _whose(array: Floats, good: NDArray[np.bool_], width: int) -> str:
    """The damping of the first body that is bad, as a message names it."""
    good = np.asarray(good.all(axis=tuple(range(good.ndim - width, good.ndim))))
    index, place = first_place(~good)
    return f"damping{place} = {array[index].tolist()}"


def _check_adds_no_energy(matrices: Floats) -> None:
    """Raise ValueError for a matrix that is not positive semi-definite."""
    try:
        forces_of(None, matrices, matrices.shape[:-2])
    except ValueError as error:
        for index in np.ndindex(matrices.shape[:-2]):
            place = str(list(index)) if index else ""
            try:
                forces_of(None, matrices[index])
            except ValueError as own:
                raise ValueError(str(own).replace("damping", f"damping{place}", 1)) from None
        raise error from None


def damping_words(damping: Damping) -> str:
    """The damping in a few words."""
    matrix = np.array(damping)
    if matrix.ndim > 2:
        return "damping of each"
    diagonal = np.diag(matrix)
    if np.any(matrix - np.diag(diagonal)):
        rows = ", ".join(f"({', '.join(f'{part:g}' for part in row)})" for row in matrix)
        return f"damping ({rows})"
    if np.all(diagonal == diagonal[0]):
        return f"damping {diagonal[0]:g}"
    return f"damping ({', '.join(f'{part:g}' for part in diagonal)})"
