"""Fits on arcs that grow as long as the parameters predict the motion."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .least_squares import Minimum, minimum
from .unknowns import Unknowns

__all__ = ["Arcs", "largest_chi2"]

Floats = NDArray[np.float64]

_CHANCE = 1e-6
"""Chance of a sum of squares of unit normal numbers that is called impossible."""

_AHEAD = 2.0 * (1.0 - math.sin(1.0))
"""Mean square of the misfit of an arc, over the variance, whose phase at the end is 1 rad off.

The misfit of two oscillations of variance s² is 2 s² (1 - cos δ); here δ grows as the time does.
"""

_GROWTH = 1.2, 2.0
"""Least and largest growth of an arc. A chaotic motion is lost at once, not by and by."""

_GUESSES, _TRIED = 100, 4
"""Moments all over what a body can have; how many of the nearest are starts of a fit."""

_UNEXPLAINED = 2
"""Most arcs whose chi² no start explains; after these the fit ends without another start."""

_GAIN_OF_PART, _GAIN = 1e-2, 1e-8
"""Where the iteration on an arc and on the whole ends: a tenth of a std, and 1e-4 of it."""

_EVALUATIONS = 50
"""Most evaluations of the derivatives on one arc from one start."""


def largest_chi2(freedom: Any) -> Any:
    """Value that chi² of so many degrees of freedom exceeds with a chance of one in a million.

    Laurent and Massart, *Ann. Statist.* 28 (2000) 1302, lemma 1.
    """
    x = -math.log(_CHANCE)
    return freedom + 2.0 * np.sqrt(freedom * x) + 2.0 * x


@dataclass(slots=True, eq=False)
class Arcs:
    """Measurements, of which growing parts around ``t = 0`` are fitted.

    Over many turns the sum of squares has a minimum beside each guess whose phase ends up a whole
    turn off. So an arc reaches as far as the present parameters predict the motion. Where chi²
    says that the minimum of an arc is wrong, the fit starts again with other moments.

    Attributes
    ----------
    unknowns : Unknowns
    t : ndarray, shape (m,)
    measured, sigma : ndarray, shape (m, 3)
    evaluations : int
        Evaluations of the derivatives until now.
    """

    unknowns: Unknowns
    t: Floats
    measured: Floats
    sigma: Floats
    evaluations: int = 0

    @np.errstate(over="ignore", invalid="ignore")  # a start whose residuals overflow is not taken
    def minimum(self) -> Minimum:
        """The minimum for all measurements, found on growing arcs."""
        x, unexplained = self.unknowns.first, 0
        order = np.argsort(np.abs(self.t), kind="stable")
        least, most = 2 * len(x), len(order)
        while True:
            count = max(least, min(most, self._predicted(x, order)))
            whole = count >= len(order)
            part = np.sort(order[:count])
            largest = largest_chi2(part.size * 3 - len(x))
            best = self._beside(x, part, whole)
            if best.squares > largest and unexplained < _UNEXPLAINED:
                for other in self._nearest(part):
                    found = self._beside(other, part, whole)
                    if found.squares < best.squares:
                        best = found
                    if best.squares <= largest:
                        break
                else:
                    unexplained += 1
            if whole:
                return best
            x = best.x
            least, most = (math.ceil(share * count) for share in _GROWTH)
            if unexplained == _UNEXPLAINED:  # it will fail: sooner is better
                least = most

    def _residuals(self, x: Floats, part: NDArray[np.intp] | slice = slice(None)) -> Floats:
        """``(model - measured) / sigma``, shape (m, 3)."""
        rates = self.unknowns.rates(x, self.t[part])
        return (rates - self.measured[part]) / self.sigma[part]

    def _predicted(self, x: Floats, order: NDArray[np.intp]) -> int:
        """The number of measurements over which the phase goes wrong by less than 1 rad."""
        numbers = 3 * np.arange(1, len(order) + 1)
        misfit = np.cumsum(np.sum(np.square(self._residuals(x)[order]), axis=1))
        varies = np.mean(np.square((self.measured - self.measured.mean(axis=0)) / self.sigma))
        signal = max(float(varies) - 1.0, 0.0)
        below = misfit <= largest_chi2(numbers) + _AHEAD * signal * numbers
        return len(order) if below.all() else int(np.argmin(below))

    def _nearest(self, part: NDArray[np.intp]) -> list[Floats]:
        """The guesses of other moments whose motions are nearest to the measured one."""
        guesses = self.unknowns.other_moments(_GUESSES)
        squares = [np.sum(np.square(self._residuals(guess, part))) for guess in guesses]
        return [guesses[k] for k in np.argsort(squares)[:_TRIED]]

    def _beside(self, x: Floats, part: NDArray[np.intp], whole: bool) -> Minimum:
        """The minimum near ``x``.

        A part of the measurements may be too short to determine all parameters. There each
        coordinate counts as measured too: the first guess, with its size for a standard deviation.
        """
        unknowns = self.unknowns

        def residuals(x: Floats) -> Floats:
            own = self._residuals(x, part).ravel()
            return own if whole else np.append(own, (x - unknowns.first) / unknowns.sizes)

        def jacobian(x: Floats) -> Floats:
            self.evaluations += 1
            slopes = unknowns.slopes(x, self.t[part]) / self.sigma[part][..., np.newaxis]
            own = slopes.reshape(-1, len(x)) @ unknowns.steer
            return own if whole else np.vstack([own, np.diag(1.0 / unknowns.sizes)])

        gain = _GAIN if whole else _GAIN_OF_PART
        box, sizes = unknowns.box, unknowns.sizes
        return minimum(residuals, jacobian, x, box, sizes, gain=gain, most=_EVALUATIONS)
