"""Mean power of an energy sink over a period of the free motion."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from . import _core
from ._checks.arrays import Floats


def mean_loss(
    moments: Iterable[Floats],
    sink: Iterable[Floats],
    square: Floats | float,
    x: Floats,
    rest: Floats,
) -> Floats:
    """Mean of ``omega'·P omega'`` over a polhode: the mean power of an energy sink.

    The polhode encircles axis 1, the axis of the smallest or of the largest moment: ``w1 = a1 dn``,
    ``w2 = a2 sn``, ``w3 = a3 cn`` with the parameter m (Landau and Lifshitz, *Mechanics*, § 37).

    Parameters
    ----------
    moments, sink : iterable of 3 ndarray
        Moments (kg m²) and coefficients of the sink (kg m² s) of the encircled axis, the axis of
        the middle moment, and the third axis. All arrays broadcast.
    square : float or ndarray
        ``L²``.
    x, rest : ndarray
        Share ``x`` of the way from the energy of axis 1 to the energy of the separatrix, at L, in
        (0, 1), and ``1 - x`` without cancellation.

    Returns
    -------
    ndarray
        The mean power (W).
    """
    i1, i2, i3 = moments
    p1, p2, p3 = sink
    # Squares of the amplitudes, and means of products of squares of Jacobi functions.
    near, far = i1 * (i3 - i2) / (i2 * (i3 - i1)), i3 * (i2 - i1) / (i2 * (i3 - i1))  # sum: 1
    left = rest + near * x
    a1, a2, a3 = left * square / i1**2, x * square / i2**2, far * x * square / i3**2
    sncn, sndn, cndn = mean_products(near * x / left, rest / left)
    # ((I3 - I2)/I1)² sn² cn², with near divided out of m = near x / left: both vanish at I2 = I3.
    slip = (i3 - i2) * i2 * (i3 - i1) / i1**3 * left / x
    power = p1 * slip * a2 * a3 * sncn
    power += p2 * ((i3 - i1) / i2) ** 2 * a1 * a3 * cndn
    power += p3 * ((i2 - i1) / i3) ** 2 * a1 * a2 * sndn
    return power


def mean_products(m: Floats, mc: Floats) -> tuple[Floats, Floats, Floats]:
    """Means of ``m sn² cn²``, ``sn² dn²`` and ``cn² dn²`` over a period; ``mc`` is ``1 - m``.

    The mean of sn² is ``R_D(0, mc, 1) / (3 R_F(0, mc, 1))`` (DLMF 19.25.1); the mean of sn⁴ follows
    from the derivative of ``sn cn dn``.
    """
    shape, complement = mc.shape, mc.ravel()
    zero, one = np.zeros_like(complement), np.ones_like(complement)
    rd = _core.elliptic("rd", [zero, complement, one])[0]
    rf = _core.elliptic("rf", [zero, complement, one])[0]
    square = (rd / (3.0 * rf)).reshape(shape)
    # The difference loses digits where m is small; there the mean is m/8 + O(m³).
    sncn = np.where(m < 1e-5, 0.125 * m, (1.0 - 2.0 * square + m * square) / 3.0)
    return sncn, mc * square + sncn, 1.0 - square - sncn
