"""Least squares inside a box: Levenberg and Marquardt's method with geodesic acceleration."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["UNTOLD", "Minimum", "minimum"]

Floats = NDArray[np.float64]

UNTOLD = 1.0
"""Standard deviation, as a share of the sizes, above which a combination is not determined."""

_BEND = 0.75
"""Largest bend of a step, as a share of its straight part; value of the paper."""

_PROBE = 0.1
"""Share of the straight step at which the residuals show the bend; value of the paper."""

_WIDEST = 1e12
"""Damping with which a step is no longer than rounding."""


@dataclass(frozen=True, slots=True, eq=False)
class Minimum:
    """The result of the iteration.

    Attributes
    ----------
    x : ndarray, shape (k,)
    residuals : ndarray, shape (m,)
    slopes : ndarray, shape (m, k)
        Their derivatives.
    gain : float
        By how much a whole straight step would lower the sum of squares; infinite where the
        derivatives overflow.
    """

    x: Floats
    residuals: Floats
    slopes: Floats
    gain: float

    @property
    def squares(self) -> float:
        """Sum of the squares of the residuals."""
        return float(self.residuals @ self.residuals)


def minimum(
    residuals: Callable[[Floats], Floats],
    jacobian: Callable[[Floats], Floats],
    x: Floats,
    box: tuple[Floats, Floats],
    sizes: Floats,
    *,
    gain: float,
    most: int,
) -> Minimum:
    """The minimum of the sum of squares of residuals near ``x``, inside the box.

    Where two numbers enter by their product, the valley of the sum of squares is narrow and curved,
    and a straight step is short. A step here is a piece of a parabola. Its bend is the second
    derivative of the residuals along the straight step, from one more evaluation of the residuals
    (Transtrum and Sethna, arXiv:1201.5885, 2012).

    Parameters
    ----------
    residuals, jacobian : callable
        Residuals of unit variance, shape (m,), and their derivatives, (m, k). Residuals may be NaN
        away from ``x``.
    x : ndarray, shape (k,)
    box : pair of ndarray, shape (k,)
        Bounds of ``x``.
    sizes : ndarray, shape (k,)
        Natural sizes of ``x``, by which steps are measured. A combination that the residuals do not
        determine to within its size does not keep the iteration going.
    gain : float
        The iteration ends where a whole straight step would lower the sum of squares by less, in
        units of the variance that the residuals have.
    most : int
        Most evaluations of the derivatives.
    """
    low, high = box
    x = np.clip(x, low, high)
    now, damping = residuals(x), 1e-3
    for count in range(1, most + 1):
        slopes = jacobian(x)
        if not np.isfinite(np.sum(np.square(slopes))):
            left_to_gain = np.inf
            break
        # The orthogonal factor once: all else has as many numbers as x.
        turned, scaled = np.linalg.qr(slopes * sizes)
        pull = slopes.T @ now
        free = ~(((x <= low) & (pull > 0.0)) | ((x >= high) & (pull < 0.0)))
        left, strengths, _ = np.linalg.svd(scaled[:, free], full_matrices=False)
        told = turned @ left[:, strengths > 1.0 / UNTOLD]
        left_to_gain = float(np.sum(np.square(told.T @ now)))
        squares = float(now @ now)
        if count == most or left_to_gain <= gain * max(1.0, squares / len(now)):
            break
        reach = (low - x) / sizes, (high - x) / sizes
        unit = np.linalg.norm(scaled, 2)
        while damping < _WIDEST:
            weight = np.sqrt(damping) * unit
            straight, moving = _step(scaled, -turned.T @ now, weight, free, reach)
            probe = residuals(x + _PROBE * straight * sizes)
            curved = ((probe - now) / _PROBE - turned @ (scaled @ straight)) / _PROBE
            bend, _ = _step(scaled, -turned.T @ curved, weight, moving, (-np.inf, np.inf))
            if np.linalg.norm(bend) <= _BEND * np.linalg.norm(straight):
                there = np.clip(x + (straight + bend) * sizes, low, high)
                then = residuals(there)
                if then @ then < squares:
                    break
            damping *= 4.0
        else:  # no step lowers the sum of squares: rounding hides the rest
            break
        x, now, damping = there, then, damping / 10.0
    return Minimum(x, now, slopes, left_to_gain)


def _step(
    scaled: Floats,
    wanted: Floats,
    weight: float,
    free: NDArray[np.bool_],
    reach: tuple[Floats | float, Floats | float],
) -> tuple[Floats, NDArray[np.bool_]]:
    """The damped step whose ``scaled`` is nearest to ``wanted``, and the coordinates left free.

    A coordinate that would go too far stays at the end of its reach, and the others adapt.
    """
    step = np.zeros(len(free))
    while free.any():
        many = int(free.sum())
        rows = np.vstack([scaled[:, free], weight * np.eye(many)])
        right = np.append(wanted - scaled[:, ~free] @ step[~free], np.zeros(many))
        step[free] = np.linalg.lstsq(rows, right)[0]
        inside = np.clip(step, *reach)
        beyond = free & (step != inside)
        step = inside
        if not beyond.any():
            break
        free = free & ~beyond
    return step, free
