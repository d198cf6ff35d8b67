"""Closed forms of the free body."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _core
from .._checks.arguments import require
from .._checks.arrays import Floats, of_size_one, vectors
from .._checks.moments import without_spin
from .._checks.shown import short_repr
from ..model.batch import batch_shape, in_rows, rows_of_each
from ..model.body import Body, rates_of_rods
from ..model.body_like import body_of
from ..model.scene import FreeBody
from .common import in_shape


@short_repr
@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FreeMotion:
    """Period, flip time, amplitudes and precession of free bodies in closed form.

    Arrays of a single body lack the leading axis ``n``.

    Bodies and rates of other leading axes give these axes in the place of ``n``.

    Attributes
    ----------
    axis : ndarray of int8, shape (n,)
        The body axis 1, 2 or 3 that the polhode encircles, with the sign of the rate about this
        axis; 0 if the polhode encircles no axis: at rest, on the separatrix, or for a sphere.
    m, mc : ndarray, shape (n,)
        Parameter of the elliptic functions, and ``1 - m`` computed without cancellation near the
        separatrix.
    period : ndarray, shape (n,)
        Period of the rates in the body (s); inf on the separatrix and for constant rates.
    flip_time : ndarray, shape (n,)
        Time between sign changes of a rate (s), half the period; inf if no rate changes sign.
    amplitude : ndarray, shape (n, 3)
        Largest ``|omega_k|`` (rad/s).
    precession : ndarray, shape (n,)
        Mean rate at which the encircled axis goes about the angular momentum (rad/s);
        :func:`rigid.free.spin_periods` has the rate of the long axis. ``abs(omega)`` for constant
        rates.
    turn : ndarray, shape (n,)
        Angle of this precession in a period (rad); inf without a period.
    """

    axis: NDArray[np.int8]
    m: Floats
    mc: Floats
    period: Floats
    flip_time: Floats
    amplitude: Floats
    precession: Floats
    turn: Floats


SLOWEST = 1e-300
"""Rates (rad/s) below it have periods outside the range of doubles."""


def free_body(body: Body | FreeBody, omega: ArrayLike) -> FreeMotion:
    """Period, flip time, amplitudes and precession of a free body.

    Landau and Lifshitz, *Mechanics*, § 37.

    Parameters
    ----------
    body : Body or FreeBody
        The body, or many.
    omega : array_like, shape (3,) or (..., 3)
        Angular velocity in the body at any time of the motion (rad/s).

    Returns
    -------
    FreeMotion

    Raises
    ------
    TypeError
        If ``body`` is neither a :class:`rigid.Body` nor a :class:`rigid.FreeBody`.
    ValueError
        If ``omega`` is not finite, has the wrong shape, or is not zero but below 1e-300 rad/s; if
        torque or damping acts on the body; or if a rod would spin about its axis.

    Examples
    --------
    >>> import rigid
    >>> motion = rigid.exact.free_body(rigid.Body((1.0, 2.0, 3.0)), [1e-6, 1.0, 0.0])
    >>> int(motion.axis), round(float(motion.flip_time), 6)
    (1, 52.660597)
    """
    rates = vectors("omega", omega)
    moments, _ = of_size_one(vectors("moments", body_of(body).moments))  # their ratios alone matter
    shape = batch_shape({"body": moments.shape[:-1], "omega": rates.shape[:-1]})
    rates = rates_of_rods("omega", rates, moments)
    size = np.abs(rates).max(axis=-1)
    rule = f"must be zero or reach {SLOWEST:g} rad/s: count the time in another unit"
    require("omega", size, (size == 0.0) | (size >= SLOWEST), rule)
    columns = in_rows(without_spin(moments), shape), rows_of_each(rates, shape)
    return FreeMotion(**in_shape(_core.free_quantities(*columns), shape))
