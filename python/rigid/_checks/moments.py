"""Principal moments and tensors of inertia that a body can have, and the nearest of these."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _core
from .arguments import brief, first_place, shaped
from .arrays import Floats
from .warned import warn_caller

MEASURED = 1e-2
"""Largest excess of a moment over the sum of the others, as a share of it, that passes for the
rounding of a flat body. Three digits give less: an error of 0.005 in two moments of 1.00."""

ROUNDING = 1e-12
"""An excess below this share comes from sums of doubles, and needs no warning."""


SYMMETRY = 1e-5
"""Share of its largest entry by which a tensor may differ from its transpose: five printed digits,
or single precision. Turned tensors of floats of 24 bits differ by some 1e-7."""


class MomentsWarning(UserWarning):
    """No body has the measured moments; the moments of the nearest flat body are used."""


def box_moments(a: ArrayLike, b: ArrayLike, c: ArrayLike, mass: ArrayLike) -> Floats:
    """Moments of homogeneous boxes, ``(..., 3)``; the arguments broadcast."""
    a, b, c, mass = np.broadcast_arrays(a, b, c, mass)
    with np.errstate(over="ignore"):  # the check of moments reports an overflow
        squares = np.stack([b * b + c * c, a * a + c * c, a * a + b * b], axis=-1)
        moments: Floats = np.asarray(mass)[..., None] / 12.0 * squares
    return moments


def rods(moments: Floats) -> NDArray[np.bool_]:
    """Whether a thin rod has these moments, shape (..., 3): zero about its axis, else equal."""
    low, middle, high = np.moveaxis(np.sort(moments, axis=-1), -1, 0)
    thin: NDArray[np.bool_] = (low == 0.0) & (middle == high) & (high > 0.0) & (high < np.inf)
    return thin


def hold_rods(moments: Floats) -> bool:
    """Whether a rod is among the bodies of these moments, shape (..., 3)."""
    return not moments.all() and bool(rods(moments).any())


def symmetry_axis(moments: Sequence[float] | Floats) -> int | None:
    """The axis 1, 2 or 3 about which two of three moments are exactly equal, or None."""
    i1, i2, i3 = moments
    if i1 == i2:
        return 3
    if i3 == i1:
        return 2
    return 1 if i2 == i3 else None


def refuse_rods(moments: Floats) -> None:
    """Raise ValueError for moments, shape (..., 3), of a rod where a spin about its axis counts."""
    thin = rods(moments)
    if thin.any():
        index, place = first_place(np.atleast_1d(thin))
        values = ", ".join(f"{moment:g}" for moment in np.atleast_2d(moments)[index])
        raise ValueError(
            f"moments{place if moments.ndim > 1 else ''} = ({values}): a rod has no moment about "
            "its axis, and a spin about the axis counts here; give a small moment"
        )


def without_spin(moments: Floats) -> Floats:
    """Moments, shape (..., 3), with which a rod moves by Euler's equations.

    A body with two equal moments that does not spin about its axis never begins to, and the third
    moment has no part in its motion: the core computes a rod as a sphere.
    """
    if not hold_rods(moments):
        return moments
    thin = rods(moments)
    whole: Floats = np.where(thin[..., None], moments.max(axis=-1, keepdims=True), moments)
    return whole


def possible(moments: Floats, physical: bool = True) -> NDArray[np.bool_]:
    """Whether a rigid body can have these moments, shape (..., 3), by the rules of the core."""
    rows = np.ascontiguousarray(moments, dtype=np.float64).reshape(-1, 3)
    bodies: NDArray[np.bool_] = _core.moment_status(rows, physical) == 0
    return bodies.reshape(moments.shape[:-1])


def can_move(moments: Floats, physical: bool) -> NDArray[np.bool_]:
    """Whether the core can move a body with these moments, shape (n, 3): rods as spheres."""
    known: NDArray[np.bool_] = _core.moment_status(without_spin(moments), physical) == 0
    return known


def _refuse_tensor(array: Floats) -> None:
    """Raise ValueError for tensors of inertia, matrices, where the rows are bodies.

    A tensor is symmetric and positive definite. Its rows are three bodies only if no body has the
    tensor: then the sum of its products is at least half of its trace, and a body has at most a
    quarter. So the refusal hides no error of other moments.
    """
    if array.shape[-2:] != (3, 3) or not array.size or not np.isfinite(array).all():
        return
    largest = np.abs(array).max(axis=(-2, -1), keepdims=True)
    apart = np.abs(array - np.swapaxes(array, -1, -2))
    if (largest == 0.0).any() or (apart > SYMMETRY * largest).any():
        return
    rows = np.moveaxis(array / largest, (-2, -1), (0, 1))
    (a, d, e), (_, b, f), (_, _, c) = rows
    minor = a * b - d * d
    least = a * f * f - 2.0 * d * e * f + b * e * e
    if ((a > 0.0) & (minor > 0.0) & (c * minor > least)).all():
        raise ValueError(
            f"moments = {brief(array.tolist())}: a symmetric matrix is a tensor of inertia, and "
            "here rows are bodies; take rigid.Body.from_tensor, or give three bodies in another "
            "order"
        )


def checked_moments(moments: Floats, physical: bool = True) -> Floats:
    """The moments, shape (..., 3), if bodies can have them; else the moments of the nearest bodies.

    Rods pass.

    Only an excess up to :data:`MEASURED` is mended, with a warning. Moments that are not
    ``physical`` need only be finite and positive.

    Raises
    ------
    ValueError
        For the first other moments; the core says which rule they break. For a tensor of inertia.
    """
    _refuse_tensor(moments)
    good = possible(moments, physical) | rods(moments)
    if good.all():
        return moments

    def refused(index: tuple[int, ...], place: str) -> None:
        try:
            _core.check_moments(moments[index].tolist())
        except ValueError as error:
            raise ValueError(str(error).replace("moments", f"moments{place}", 1)) from None

    wrong = ~good & ((moments.min(axis=-1) <= 0.0) | (not physical))
    if wrong.any():
        refused(*first_place(wrong))
    return _nearest_moments("moments", moments, ~good, refused)


def _nearest_moments(
    name: str,
    moments: Floats,
    bad: NDArray[np.bool_],
    refused: Callable[[tuple[int, ...], str], None],
) -> Floats:
    """The moments, the bad ones replaced by the nearest possible ones, with one warning.

    Moments are possible if none exceeds the sum of the other two: a cone in the space of moments,
    whose faces are the flat bodies. The nearest point of a face changes each moment by a third of
    the excess, and so keeps their order. ``refused`` raises the error of moments with a larger
    excess than :data:`MEASURED`.
    """
    near, excess = _core.nearest_possible(np.ascontiguousarray(moments).reshape(-1, 3))
    near, excess = near.reshape(moments.shape), excess.reshape(bad.shape)
    lost = bad & ~(excess <= MEASURED)
    if lost.any():
        refused(*first_place(lost))
    change = np.where(bad, excess, 0.0)
    many = int((change > ROUNDING).sum())
    if many:
        index, place = first_place(change == change.max())
        before, after = (", ".join(f"{x:.6g}" for x in array[index]) for array in (moments, near))
        others = f"; {many - 1} others are taken so, too" if many > 1 else ""
        warn_caller(
            f"{name}{place} = ({before}): the nearest possible moments, ({after}), are taken; the "
            f"largest exceeds the sum of the others by {100.0 * change[index]:.2g} %{others}",
            MomentsWarning,
        )
    nearest: Floats = np.where(bad[..., np.newaxis], near, moments)
    return nearest


def symmetric_tensor(name: str, value: ArrayLike) -> Floats:
    """``value`` as finite symmetric matrices ``(..., 3, 3)``, made exactly symmetric."""
    t = shaped(name, value, 3, 3)
    apart = t - np.swapaxes(t, -1, -2)
    scale = np.abs(t).max(axis=(-2, -1), keepdims=True)
    bad = np.abs(apart) > SYMMETRY * scale
    if np.any(bad):
        index, place = first_place(bad)
        mirror = t[(*index[:-2], index[-1], index[-2])]
        raise ValueError(
            f"{name}{place} = {t[index]}, but its mirror entry is {mirror}: a tensor of inertia is "
            f"symmetric, to {SYMMETRY:g} of the largest entry"
        )
    return t - 0.5 * apart


def possible_tensor(name: str, value: ArrayLike) -> Floats:
    """``value`` as symmetric matrices that are tensors of inertia of bodies or rods."""
    t = symmetric_tensor(name, value)
    moments, axes = np.linalg.eigh(t)
    change = possible_moments(name, moments) - moments
    if not change.any():
        return t
    changed: Floats = t + axes @ (change[..., np.newaxis] * np.swapaxes(axes, -1, -2))
    return changed


def possible_moments(name: str, ascending: Floats) -> Floats:
    """Ascending principal moments; a rounded tensor of a flat body gets possible ones.

    Raises
    ------
    ValueError
        For moments that are further from possible ones.
    """
    small, middle, large = np.moveaxis(ascending, -1, 0)
    bad = large - middle - small > ROUNDING * np.abs(ascending).max(axis=-1)

    def refused(index: tuple[int, ...], place: str) -> None:
        moments = ", ".join(f"{moment:g}" for moment in ascending[index])
        raise ValueError(
            f"{name}{place}: no body has the principal moments ({moments}); none may be negative "
            "or exceed the sum of the other two"
        )

    return _nearest_moments(name, ascending, bad, refused) if np.any(bad) else ascending
