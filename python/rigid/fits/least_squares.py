"""Least squares inside a box: Levenberg and Marquardt's method with geodesic acceleration."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .._checks.arrays import Floats

UNTOLD = 1.0
"""Standard deviation, as a share of the sizes, above which a combination is not determined."""

_BEND = 0.75
"""Largest bend of a step, as a share of its straight part; value of the paper."""

_PROBE = 0.1
"""Share of the straight step at which the residuals show the bend; value of the paper."""

_WIDEST = 1e12
"""Damping with which a step is no longer than rounding."""


_DIFFERENCE = 1e-5
"""Share of a size by which differences are taken: rates err by 1e-8, so their slopes by 1e-3."""


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
    for count in itertools.count(1):
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


def descents(
    residuals: Callable[[Floats], Floats],
    x: Floats,
    box: tuple[Floats, Floats],
    sizes: Floats,
    *,
    rounds: int,
) -> tuple[Floats, Floats, Floats]:
    """Levenberg and Marquardt's method from many starts together, for so many rounds.

    Parameters
    ----------
    residuals : callable
        Residuals of unit variance, shape (n, m), of n places. Among them are the coordinates over
        their sizes, so that no normal matrix is singular.
    x : ndarray, shape (n, k)
    box, sizes : pair of ndarray, ndarray, shape (k,)
        As in :func:`minimum`.

    Returns
    -------
    x : ndarray, shape (n, k)
    squares : ndarray, shape (n,)
        Sums of squares; infinite where the residuals overflow.
    normal : ndarray, shape (n, k, k)
        Products of the derivatives by the coordinates over their sizes.
    """
    count, many = x.shape

    def at(x: Floats) -> tuple[Floats, Floats, Floats]:
        steps = np.where(x + _DIFFERENCE * sizes > box[1], -_DIFFERENCE, _DIFFERENCE)
        moved = np.repeat(x[:, np.newaxis], many + 1, axis=1)
        moved[:, 1:] += (steps * sizes)[:, np.newaxis] * np.eye(many)
        found = residuals(moved.reshape(-1, many)).reshape(count, many + 1, -1)
        now, slopes = found[:, 0], (found[:, 1:] - found[:, :1]) / steps[..., np.newaxis]
        squares = np.einsum("nm,nm->n", now, now)
        normal, pull = slopes @ np.swapaxes(slopes, 1, 2), np.einsum("nkm,nm->nk", slopes, now)
        lost = ~np.isfinite(squares + np.trace(normal, axis1=1, axis2=2))
        squares[lost], normal[lost], pull[lost] = np.inf, np.eye(many), 0.0
        return squares, normal, pull

    squares, normal, pull = at(x)
    damping = np.full(count, 1e-3)
    for _ in range(rounds):
        weight = damping * np.trace(normal, axis1=1, axis2=2)
        damped = normal + weight[:, np.newaxis, np.newaxis] * np.eye(many)
        step = np.linalg.solve(damped, pull[..., np.newaxis])[..., 0] * sizes
        there = np.clip(x - step, *box)
        found = at(there)
        better = found[0] < squares
        x = np.where(better[:, np.newaxis], there, x)
        for old, new in zip((squares, normal, pull), found, strict=True):
            old[better] = new[better]
        damping = np.where(better, damping / 10.0, damping * 4.0)
    return x, squares, normal


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
