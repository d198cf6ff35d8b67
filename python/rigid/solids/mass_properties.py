"""Mass, centre of mass and tensor of inertia of bodies."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from .._checks.arguments import brief, first_place, shaped
from .._checks.arrays import Floats
from .._checks.matrices import rotation_matrices
from .._checks.moments import possible_tensor, symmetric_tensor
from .._checks.overflow import refuses_overflow


@dataclass(frozen=True, slots=True, init=False, eq=False)
class MassProperties:
    """Mass, centre of mass, and the tensor of inertia about the centre of mass.

    All components refer to the axes in which the body was described. Leading axes of the arrays
    count bodies.

    Parameters
    ----------
    mass : array_like, shape (...)
        Mass (kg).
    centre : array_like, shape (..., 3)
        Centre of mass (m).
    tensor : array_like, shape (..., 3, 3)
        Tensor of inertia about the centre of mass (kg m²), products with their minus signs.

    Raises
    ------
    ValueError
        If a mass is not positive, the tensor is not symmetric (to 1e-5 of its largest entry), or
        its principal moments are impossible: one is negative or above the sum of the other two.

    Warns
    -----
    MomentsWarning
        As :class:`rigid.Body`: a moment that exceeds the sum by at most 1 % is mended.

    Examples
    --------
    >>> from rigid import solids
    >>> rod = solids.rod(2.0, mass=3.0)
    >>> rod.tensor.diagonal()
    array([1., 1., 0.])
    >>> rod.about([0.0, 0.0, 1.0]).diagonal()
    array([4., 4., 0.])
    """

    mass: Floats
    centre: Floats
    tensor: Floats

    def __init__(self, *, mass: ArrayLike, centre: ArrayLike, tensor: ArrayLike) -> None:
        mass, centre = shaped("mass", mass, positive=True), shaped("centre", centre, 3)
        tensor = possible_tensor("tensor", tensor)
        leading = np.broadcast_shapes(mass.shape, centre.shape[:-1], tensor.shape[:-2])
        set_field = object.__setattr__  # the dataclass is frozen
        set_field(self, "mass", np.broadcast_to(mass.copy(), leading))
        set_field(self, "centre", np.broadcast_to(centre.copy(), (*leading, 3)))
        set_field(self, "tensor", np.broadcast_to(tensor, (*leading, 3, 3)))

    def about(self, point: ArrayLike) -> Floats:
        """The tensor of inertia about a point of the body (Steiner), shape (..., 3, 3).

        Parameters
        ----------
        point : array_like, shape (..., 3)
            The point (m), such as a pivot, in the coordinates of ``centre``.

        Returns
        -------
        ndarray, shape (..., 3, 3)
            Tensor (kg m²).

        Raises
        ------
        ValueError
            If the point is not finite or has another shape.

        Examples
        --------
        >>> from rigid import solids
        >>> solids.rod(2.0, mass=3.0).about([0.0, 0.0, -1.0]).diagonal()
        array([4., 4., 0.])
        """
        return steiner(self.tensor, self.mass, shaped("point", point, 3) - self.centre)

    def placed(
        self, shift: ArrayLike = (0.0, 0.0, 0.0), turn: ArrayLike | None = None
    ) -> MassProperties:
        """The body after a rotation about the origin and then a shift.

        Parameters
        ----------
        shift : array_like, shape (..., 3)
            Shift (m).
        turn : array_like, shape (..., 3, 3), optional
            Active rotation.

        Returns
        -------
        MassProperties

        Raises
        ------
        ValueError
            If the shift is not finite, or the turn is no rotation matrix.

        Examples
        --------
        >>> import numpy as np
        >>> from rigid import rotations, solids
        >>> lying = solids.rod(2.0, mass=3.0).placed([1, 0, 0], rotations.rotation_y(np.pi / 2))
        >>> lying.centre, lying.tensor.diagonal().round(15)
        (array([1., 0., 0.]), array([0., 1., 1.]))
        """
        centre, tensor = self.centre, self.tensor
        if turn is not None:
            centre = rotate_tensor(turn, centre, order=1)
            tensor = rotate_tensor(turn, tensor)
        return MassProperties(
            mass=self.mass, centre=centre + shaped("shift", shift, 3), tensor=tensor
        )


@refuses_overflow
def inertia_tensor(
    masses: ArrayLike, points: ArrayLike, about: ArrayLike = (0.0, 0.0, 0.0)
) -> Floats:
    """The tensor of inertia of mass points: ``sum m (r² 1 - r ⊗ r)``.

    Goldstein, § 5.3; Ercan 2016, eqs. (23), (32). The products of inertia have minus
    signs and ``I_11 = sum m (y² + z²)``: the matrix printed in the lecture notes, § 5.4, has
    neither (erratum G-09).

    Parameters
    ----------
    masses : array_like, shape (..., n)
        Masses (kg), none negative.
    points : array_like, shape (..., n, 3)
        Positions (m).
    about : array_like, shape (..., 3)
        The point that ``r`` starts from; the origin if not said.

    Returns
    -------
    ndarray, shape (..., 3, 3)
        kg m²; zero for no points.

    Raises
    ------
    ValueError
        If a mass is negative, a value is not finite, or the shapes do not broadcast.

    Examples
    --------
    >>> from rigid import inertia
    >>> inertia.inertia_tensor([1.0, 2.0], [[1.0, 1.0, 0.0], [0.0, 0.0, 3.0]])
    array([[19., -1.,  0.],
           [-1., 19.,  0.],
           [ 0.,  0.,  2.]])
    """
    m, r = _cloud(masses, points)
    return tensor_of_squares(_squares(m, r - shaped("about", about, 3)[..., None, :]))


@refuses_overflow
def point_masses(masses: ArrayLike, points: ArrayLike) -> MassProperties:
    """Mass, centre of mass, and tensor about the centre of mass, of mass points.

    Parameters
    ----------
    masses : array_like, shape (..., n)
        Masses (kg), none negative, not all zero.
    points : array_like, shape (..., n, 3)
        Positions (m).

    Returns
    -------
    MassProperties

    Raises
    ------
    ValueError
        As :func:`inertia_tensor`, and if there is no mass.

    Examples
    --------
    >>> from rigid import inertia
    >>> dumbbell = inertia.point_masses([1.0, 3.0], [[0.0, 0.0, 0.0], [0.0, 0.0, 4.0]])
    >>> dumbbell.centre, dumbbell.tensor.diagonal()
    (array([0., 0., 3.]), array([12., 12.,  0.]))
    """
    m, r = _cloud(masses, points)
    total = m.sum(axis=-1)
    if np.any(total <= 0.0):
        _, place = first_place(total <= 0.0)
        raise ValueError(f"masses{place}: their sum is 0; a body needs mass")
    # The second mean removes the rounding error of the first one far from the origin.
    centre = (m[..., None] * r).sum(axis=-2) / total[..., None]
    centre = centre + (m[..., None] * (r - centre[..., None, :])).sum(axis=-2) / total[..., None]
    squares = _squares(m, r - centre[..., None, :])
    return MassProperties(mass=total, centre=centre, tensor=tensor_of_squares(squares))


def compose(parts: Iterable[MassProperties]) -> MassProperties:
    """One body composed of parts: masses add, and tensors about the common centre of mass add.

    Tensors add if they have the same point and the same axes; principal moments do not add (lecture
    notes, § 5.4, erratum G-15).

    Parameters
    ----------
    parts : iterable of MassProperties
        In common axes; their leading axes broadcast.

    Returns
    -------
    MassProperties

    Raises
    ------
    TypeError
        If a part is no :class:`MassProperties`.
    ValueError
        If there are no parts.

    Examples
    --------
    >>> from rigid import inertia, solids
    >>> ball = solids.sphere(0.1, mass=1.0)
    >>> dumbbell = inertia.compose([ball.placed([0, 0, 1]), ball.placed([0, 0, -1])])
    >>> dumbbell.tensor.diagonal().round(3)
    array([2.008, 2.008, 0.008])
    """
    pieces = list(parts)
    if not pieces:
        raise ValueError("parts: a body needs at least one")
    for k, part in enumerate(pieces):
        if not isinstance(part, MassProperties):
            raise TypeError(f"parts[{k}] = {brief(part)}: must be rigid.inertia.MassProperties")
    leading = np.broadcast_shapes(*(part.mass.shape for part in pieces))
    mass = np.stack([np.broadcast_to(part.mass, leading) for part in pieces], axis=-1)
    centre = np.stack([np.broadcast_to(part.centre, (*leading, 3)) for part in pieces], axis=-2)
    own = sum(part.tensor for part in pieces)
    together = point_masses(mass, centre)
    return MassProperties(mass=together.mass, centre=together.centre, tensor=own + together.tensor)


@refuses_overflow
def steiner(
    tensor: ArrayLike,
    mass: ArrayLike,
    shift: ArrayLike,
    *,
    centre: ArrayLike = (0.0, 0.0, 0.0),
) -> Floats:
    """The tensor of inertia about another point: the parallel-axis theorem.

    From the centre of mass by ``a``: ``I' = I + M (a² 1 - a ⊗ a)`` (Goldstein, § 5.3; lecture
    notes, eq. (5.13)). From any other point, with ``c`` from that point to the centre of mass:
    ``I' = I + M ((a² - 2 a·c) 1 - a ⊗ a + a ⊗ c + c ⊗ a)``; pass ``shift = centre`` for the tensor
    about the centre of mass. The short form holds from the centre of mass only.

    Parameters
    ----------
    tensor : array_like, shape (..., 3, 3)
        Tensor of inertia about the first point (kg m²).
    mass : array_like, shape (...)
        Mass (kg).
    shift : array_like, shape (..., 3)
        Vector from the first point to the new point (m).
    centre : array_like, shape (..., 3)
        Vector from the first point to the centre of mass (m); zero by default.

    Returns
    -------
    ndarray, shape (..., 3, 3)
        Tensor of inertia about the new point.

    Raises
    ------
    ValueError
        If the tensor is not symmetric, the mass is negative, or a value is not finite.

    Examples
    --------
    >>> import numpy as np
    >>> from rigid import inertia
    >>> there = inertia.steiner(np.diag([1.0, 1.0, 0.5]), 2.0, [0.0, 0.0, 3.0])
    >>> there.diagonal()
    array([19. , 19. ,  0.5])
    >>> back = [0.0, 0.0, -3.0]
    >>> inertia.steiner(there, 2.0, back, centre=back).diagonal()
    array([1. , 1. , 0.5])
    """
    t, m = symmetric_tensor("tensor", tensor), shaped("mass", mass, nonnegative=True)
    a, c = shaped("shift", shift, 3), shaped("centre", centre, 3)
    mixed = a[..., :, None] * c[..., None, :]
    squares = a[..., :, None] * a[..., None, :] - mixed - np.swapaxes(mixed, -1, -2)
    return t + tensor_of_squares(m[..., None, None] * squares)


def rotate_tensor(turn: ArrayLike, tensor: ArrayLike, *, order: int = 2) -> Floats:
    """A tensor in turned axes: ``R T R.T``, and ``R v`` for a vector.

    With ``R`` from body to space the function takes components in the body to components in space.
    Textbooks write ``I' = lambda I lambda.T`` with the passive ``lambda = R.T`` (Goldstein, § 5.2;
    Ercan 2016, eq. (31); the last ``lambda_kl`` of the proof is a misprint for ``I_kl``, erratum
    D-17).

    Parameters
    ----------
    turn : array_like, shape (..., 3, 3)
        Rotations ``R``.
    tensor : array_like, shape (...), (..., 3) or (..., 3, 3)
        Tensors of the order.
    order : {0, 1, 2}
        Number of indices of the tensor; a scalar (order 0) does not change.

    Returns
    -------
    ndarray
        Shape of the broadcast leading axes.

    Raises
    ------
    ValueError
        If a matrix is not a rotation to 3.1e-4, or the order is not 0, 1 or 2.

    Examples
    --------
    >>> import numpy as np
    >>> from rigid import inertia, rotations
    >>> quarter = rotations.rotation_z(np.pi / 2)
    >>> inertia.rotate_tensor(quarter, np.diag([1.0, 2.0, 2.5])).diagonal()
    array([2. , 1. , 2.5])
    """
    if order not in (0, 1, 2):
        raise ValueError(f"order = {brief(order)}: must be 0, 1 or 2")
    r = rotation_matrices("turn", turn)
    t = shaped("tensor", tensor, *(3,) * order)
    if order == 2:
        rotated: Floats = r @ t @ np.swapaxes(r, -1, -2)
        return rotated
    if order == 1:
        vector: Floats = np.matvec(r, t)
        return vector
    return np.broadcast_to(t, np.broadcast_shapes(t.shape, r.shape[:-2])).copy()


def tensor_of_squares(squares: Floats) -> Floats:
    """``tr(S) 1 - S`` with the second moments ``S = sum m r ⊗ r``, computed without ``x² - x²``."""
    tensor = -squares
    diagonal = np.diagonal(squares, axis1=-2, axis2=-1)
    for i in range(3):
        tensor[..., i, i] = diagonal[..., (i + 1) % 3] + diagonal[..., (i + 2) % 3]
    return tensor + 0.0  # no negative zeros


def _cloud(masses: ArrayLike, points: ArrayLike) -> tuple[Floats, Floats]:
    r = shaped("points", points, 3)
    m = shaped("masses", masses, nonnegative=True)
    if r.ndim < 2 or m.ndim < 1 or m.shape[-1] != r.shape[-2]:
        raise ValueError(
            f"masses: expected shape (..., n) to go with points (..., n, 3), "
            f"got {m.shape} and {r.shape}"
        )
    return m, r


def _squares(m: Floats, r: Floats) -> Floats:
    """``sum m r ⊗ r``."""
    squares: Floats = np.swapaxes(r, -1, -2) @ (m[..., None] * r)
    return squares
