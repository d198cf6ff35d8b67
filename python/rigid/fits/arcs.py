"""Fits on arcs that grow as long as the parameters predict the motion."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from .._checks.arrays import Floats
from .least_squares import Minimum, descents, minimum
from .unknowns import Unknowns

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

_EVALUATIONS, _ALL_EVALUATIONS = 50, 500
"""Most evaluations of the derivatives on one arc from one start, and of a whole fit.

Right fits of hundreds of samples took 58 at most, so 100 always remain.
"""

_DERIVED = 2 * 10**6
"""Most steps of all these evaluations: some minutes."""

_FARTHEST = 10**7
"""Largest phase (rad) of a fit: a hundred runs of so many turns take an hour."""

_DEARER = 10
"""How many times the steps of the first guess a run may take."""

_DRAWN_FOR_EACH, _DESCENTS, _ROUNDS = 32, 1024, 20
"""Starts across a gap that are drawn for each that descends, the best; rounds of their descent."""

_WORK, _FEWEST = 3 * 10**7, 64
"""Most steps of the descents across a gap, by the first guess: seconds. Fewest descents."""

_KNOWN_AGAIN = 5
"""Least number of descents that must end in the minimum that was found before.

A minimum like it is then missed with a chance of e⁻⁵.
"""

_FOLLOWED, _KEPT = 16, 4
"""Most other minima across a gap that are followed to the end, and that are kept there."""


def largest_chi2(freedom: Any, chance: float = _CHANCE) -> Any:
    """Value that chi² of so many degrees of freedom exceeds with at most this chance.

    Laurent and Massart, *Ann. Statist.* 28 (2000) 1302, lemma 1.
    """
    x = -math.log(chance)
    return freedom + 2.0 * np.sqrt(freedom * x) + 2.0 * x


def largest_of(freedom: int, searched: int) -> float:
    """Value above which chi² of the best of so many searched minima is called impossible.

    Odds that a minimum is right are its odds before times the chance that right ones have such a
    chi². The best of n minima has an n-th of the odds of a single one before, because any of the
    n could be the best. So the chance at the border is n times as large.
    """
    return float(largest_chi2(freedom, min(searched * _CHANCE, 0.5)))


def overtaken(parameters: int, searched: int) -> float:
    """By how much noise lowers chi² of a wrong minimum below the right one, of so many searched.

    Let e be the difference of the rates that both predict, n the noise, in units of sigma. chi² is
    lower for the wrong minimum by 2 e·n - |e|², at most the square of the part of n along e. As e
    varies with the parameters, that part lies in one more dimension than there are parameters.
    """
    return float(largest_chi2(parameters + 1, _CHANCE / searched))


@dataclass(slots=True, eq=False)
class Arcs:
    """Measurements, of which growing parts from the first on are fitted.

    Over many turns the sum of squares has a minimum beside each guess whose phase ends up a whole
    turn off. So an arc reaches as far as the present parameters predict the motion. Where chi²
    says that the minimum of an arc is wrong, the fit starts again with other moments.

    Where the phase between two samples passes pi, no arc leads across: motions with more or fewer
    turns meet the same samples. There other minima are searched, and followed to the end.

    Attributes
    ----------
    unknowns : Unknowns
    t : ndarray, shape (m,)
        Times since the first measurement.
    measured, sigma : ndarray, shape (m, 3)
    report : callable
        Gets the number of measurements of each arc.
    most, evaluations : int
        Evaluations of the derivatives: most, and until now.
    searched : int
        Minima that were searched until now.
    stopped : str
        Why the search ended before it was complete, in words; empty if it did not.
    """

    unknowns: Unknowns
    t: Floats
    measured: Floats
    sigma: Floats
    report: Callable[[int], object]
    most: int = _ALL_EVALUATIONS
    evaluations: int = 0
    searched: int = 1
    stopped: str = ""

    @property
    def phases(self) -> Floats:
        """Bounds of the phase (rad) that passes between two samples, shape (m - 1,)."""
        rate = max(self.unknowns.fastest, self.unknowns.swing)
        return rate * np.diff(self.t)

    @np.errstate(over="ignore", invalid="ignore")  # a start whose residuals overflow is not taken
    def minima(self) -> list[Minimum]:
        """Minima for all measurements, the best first."""
        self._limit_steps()
        gaps, first = self._across(), self.unknowns.first
        # From the first samples on no arc leads across: other starts are searched below anyway.
        lost = any(before == 1 for before, _ in gaps)
        start = self._grown(first, 2 * len(first), again=not lost)
        known = first if start is None else start.x
        found, met = ([], []) if start is None else ([start], [_DESCENTS])
        for before, end in gaps:
            others, counts, nearest = self._beyond(known, before, end)
            if start is not None:
                met[0] = min(met[0], counts[0])
            found, met = found + others, met + counts[1:]
        if not found:
            return [self._beside(nearest, slice(None), whole=True)]
        best = int(np.argmin([one.squares for one in found]))
        if met[best] < _KNOWN_AGAIN and not self.stopped:
            self.stopped = (
                f"{met[best]} descents from other starts ended in this minimum: there are more "
                "minima than were searched"
            )
        return sorted(found, key=lambda one: one.squares)

    def _limit_steps(self) -> None:
        """No later run takes many times the steps of the first guess.

        A closed form takes no steps, but its derivative is integrated by ``taylor16``. Of 60 free
        bodies and 60 tops, none took more than 4.2 steps per radian of the measured phase: 4 stand
        for them.
        """
        phase = float(self.phases.sum())
        if phase > _FARTHEST:
            raise ValueError(
                f"t: the phase of the motion grows by {phase:.3g} rad, must be at most "
                f"{_FARTHEST:.3g}: a shorter time is needed"
            )
        steps = int(self.unknowns.steps(self.t)) + len(self.t) + 4 * int(phase)
        self.unknowns.most_steps = _DEARER * steps
        self.most = min(_ALL_EVALUATIONS, max(100, _DERIVED // steps))

    def _grown(self, x: Floats, least: int, *, again: bool) -> Minimum | None:
        """The minimum for all measurements, found on growing arcs.

        With ``again`` the fit of an arc that chi² does not explain starts again with other
        moments; else there is no minimum.
        """
        unexplained, most = 0, len(self.t)
        while True:
            count = max(least, min(most, self._predicted(x)))
            whole = count >= len(self.t)
            part = slice(count)
            freedom = 3 * min(count, len(self.t)) - len(x)
            best = self._beside(x, part, whole)
            if best.squares > largest_of(freedom, self.searched):
                if not again:
                    return None
                if unexplained < _UNEXPLAINED and not self.stopped:
                    best, explained = self._other(best, part, whole, freedom)
                    unexplained += not explained
            if whole:
                return best
            if again:
                self.report(count)
            x = best.x
            least, most = (math.ceil(share * count) for share in _GROWTH)
            if unexplained == _UNEXPLAINED or self.stopped:  # it will fail: sooner is better
                least = most

    def _other(self, best: Minimum, part: slice, whole: bool, freedom: int) -> tuple[Minimum, bool]:
        """The best minimum from other moments, and whether chi² explains it."""
        for other in self._nearest(part):
            self.searched += 1
            found = self._beside(other, part, whole)
            if found.squares < best.squares:
                best = found
            if best.squares <= largest_of(freedom, self.searched):
                return best, True
        return best, False

    def _residuals(self, x: Floats, part: slice) -> Floats:
        """``(model - measured) / sigma``, shape (..., m, 3)."""
        rates = self.unknowns.rates(x, self.t[part])
        return (rates - self.measured[part]) / self.sigma[part]

    def _predicted(self, x: Floats) -> int:
        """The number of measurements over which the phase goes wrong by less than 1 rad."""
        numbers = 3 * np.arange(1, len(self.t) + 1)
        misfit = np.cumsum(np.sum(np.square(self._residuals(x, slice(None))), axis=1))
        varies = np.mean(np.square((self.measured - self.measured.mean(axis=0)) / self.sigma))
        signal = max(float(varies) - 1.0, 0.0)
        below = misfit <= largest_chi2(numbers) + _AHEAD * signal * numbers
        return len(numbers) if below.all() else int(np.argmin(below))

    def _nearest(self, part: slice) -> list[Floats]:
        """The guesses of other moments whose motions are nearest to the measured one."""
        guesses = self.unknowns.other_moments(_GUESSES)
        squares = [np.sum(np.square(self._residuals(guess, part))) for guess in guesses]
        return [guesses[k] for k in np.argsort(squares)[:_TRIED]]

    def _beside(self, x: Floats, part: slice, whole: bool) -> Minimum:
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
        most = max(1, min(self.most - self.evaluations, _EVALUATIONS))
        box, sizes = unknowns.box, unknowns.sizes
        found = minimum(residuals, jacobian, x, box, sizes, gain=gain, most=most)
        if self.evaluations >= self.most:
            self.stopped = f"the search ended after {self.most} runs with derivatives"
        return found

    def _across(self) -> list[tuple[int, int]]:
        """Gaps that no arc leads across: numbers of measurements before and after each.

        The phase between two samples passes pi there, so that motions with a turn more or less
        meet the same samples: none turns faster than the fastest measured rate. Arcs tell the
        phase to less than 1 rad, so they still tell it after a gap shorter than the arc before.
        """
        count = 2 * len(self.unknowns.first)
        wide = np.flatnonzero(self.phases > np.pi) + 1
        early = [(1, count)] if np.any(wide <= count) else []
        late = [g for g in wide if g > count and self.t[g] > 2.0 * self.t[g - 1]]
        return early + [(int(g), int(g) + count) for g in late]

    def _beyond(self, x: Floats, before: int, end: int) -> tuple[list[Minimum], list[int], Floats]:
        """Minima across a gap other than the one at ``x``, how many descents met each, the nearest.

        Starts are drawn from what the measurements before the gap leave possible; the best of them
        descend together. The minima found are followed to the end of the measurements. The first
        count is for the minimum at ``x``.
        """
        unknowns, part = self.unknowns, slice(before, end)
        steps = max(unknowns.steps(self.t[part]), len(self.t[part]))
        runs = _DRAWN_FOR_EACH + (len(x) + 1) * (_ROUNDS + 1)
        number = min(_DESCENTS, _WORK // (runs * steps))
        if number < _FEWEST:
            self.stopped = f"other minima were not searched: that takes more than {_WORK} steps"
            return [], [0], x
        known = self._beside(x if before > 1 else unknowns.first, slice(before), whole=False)
        root = np.linalg.qr(known.slopes)[1]
        drawn = np.random.default_rng(0).normal(size=(number * _DRAWN_FOR_EACH, len(x)))
        starts = _folded(known.x + np.linalg.solve(root, drawn.T).T, unknowns.box)

        def residuals(x: Floats) -> Floats:
            own = self._residuals(x, part).reshape(len(x), -1)
            return np.hstack([own, (x - known.x) @ root.T])

        squares = np.sum(np.square(residuals(starts)), axis=1)
        starts = starts[np.argsort(squares, kind="stable")[:number]]
        places, squares, normal = descents(
            residuals, starts, unknowns.box, unknowns.sizes, rounds=_ROUNDS
        )
        self.searched += number
        nearest = places[np.argmin(squares)]
        near = largest_chi2(len(x))

        def beside(x: Floats, k: int) -> Any:
            off = (x - places[k]) / unknowns.sizes
            return np.einsum("...i,ij,...j", off, normal[k], off) < near

        freedom = 3 * (min(end, len(self.t)) - before)
        squares[squares > largest_of(freedom, self.searched)] = np.inf
        met, others = [0], []
        while np.isfinite(squares).any():
            k = int(np.argmin(squares))
            alike = beside(places, k) & np.isfinite(squares)
            alike[k] = True
            if beside(x, k):
                met[0] += int(alike.sum())
            else:
                others.append((places[k], int(alike.sum())))
            squares[alike] = np.inf
        count, found = min(end, len(self.t)), []
        for other, times in others[:_FOLLOWED]:
            one = self._grown(other, count, again=False)
            if one is not None:
                found.append(one)
                met.append(times)
            if len(found) == _KEPT:
                break
        if len(others) > _FOLLOWED and not found:
            self.stopped = f"of {len(others)} other minima {_FOLLOWED} were followed"
        return found, met, nearest


def _folded(x: Floats, box: tuple[Floats, Floats]) -> Floats:
    """Coordinates inside the box: those outside are mirrored at its edges."""
    low, high = box
    with np.errstate(invalid="ignore"):  # of edges that are infinite
        width = high - low
        wave = np.abs((x - low + width) % (2.0 * width) - width)
    inside = np.where(np.isfinite(width), low + wave, x)
    return np.where(np.isfinite(low), low + np.abs(inside - low), inside)
