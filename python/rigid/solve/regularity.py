"""Whether a motion is regular or chaotic, from its mean MEGNO at a few times.

The mean MEGNO of a motion whose displacements grow like a power ``t**p`` of the time stays at
``2 p``; it grows like ``lambda T / 2`` where they grow exponentially, so it doubles with the time.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["CHECKPOINTS", "RESOLVED", "RULE", "Rule"]

Floats = NDArray[np.float64]

CHECKPOINTS = (0.125, 0.25, 0.5, 1.0)
"""Shares of the horizon at which the mean MEGNO is looked at."""

RESOLVED = 10.0
"""An exponent above this over the horizon brings the mean MEGNO above ``high``."""


@dataclass(frozen=True, slots=True)
class Rule:
    """When a run is called regular, and when chaotic.

    Attributes
    ----------
    sure, low : float
        Regular: a mean MEGNO below ``sure``, or below ``low`` and less than 1/2 above that at half
        of the horizon. The limit of regular motions is 2.
    high, ratio : float
        Chaotic: a mean MEGNO above ``high`` and above ``ratio`` times that at half of the time; at
        an earlier time than the horizon only above twice ``high``. Quadratic growth gives 4 and a
        ratio of one, exponential growth a ratio of two.
    """

    sure: float = 2.1
    low: float = 3.0
    high: float = 5.0
    ratio: float = 1.5

    def of_run(self, means: Floats) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        """Whether runs are regular, and whether chaotic, from mean MEGNOs (n, 4) at checkpoints."""
        eighth, quarter, half, end = means.T
        regular = (end < self.sure) | ((end < self.low) & (end - half < 0.5))
        chaotic = (end > self.high) & (end > self.ratio * half)
        for before, now in ((eighth, quarter), (quarter, half)):
            chaotic |= (now > 2.0 * self.high) & (now > self.ratio * before)
        return regular, chaotic

    def verdict(self, first: Floats, second: Floats | None) -> NDArray[np.str_]:
        """``regular``, ``chaotic`` or ``undecided``; ``failed`` where a run has no number.

        Both runs must be regular; for a chaotic motion one must be chaotic and the other not
        regular.
        """
        known = np.isfinite(first).all(axis=1)
        with np.errstate(invalid="ignore"):
            regular, chaotic = self.of_run(first)
            if second is not None:
                known &= np.isfinite(second).all(axis=1)
                again, wild = self.of_run(second)
                regular, chaotic = regular & again, (chaotic & ~again) | (wild & ~regular)
        named = np.select([~known, regular, chaotic], ["failed", "regular", "chaotic"], "undecided")
        return np.asarray(named, dtype=np.str_)


RULE = Rule()
"""Of 4096 random motions of each of four integrable families it called one chaotic over a time of
100, beside a separatrix of the Kovalevskaya top, and none over 400."""
