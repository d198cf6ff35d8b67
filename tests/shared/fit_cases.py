"""Random fits: a body that turns freely, a guess beside it, a gyroscope with noise and bias."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import stats

import rigid
from physics import Floats

#: Two-sided 95 % of a normal number.
WITHIN = float(stats.norm.isf(0.025))

#: A fit is wrong if noise would explain its distance from the truth once in a million fits.
CHANCE = 1e-6

#: The least chi² is at most that of the truth, but for rounding and where the iteration ends.
ROUNDING = 1e-2


@dataclass(frozen=True, eq=False)
class Finding:
    """What a fit said, and what was true.

    Attributes
    ----------
    excess : float
        chi² of the truth over that of the fit: that of as many degrees of freedom as parameters.
    held : ndarray of bool, shape (k,)
        Whether the interval of 95 % of each parameter holds its truth.
    off : float
        Largest error of a parameter in its standard deviations.
    """

    number: int
    success: bool
    reason: str
    excess: float
    held: NDArray[np.bool_]
    evaluations: int
    off: float

    @property
    def right(self) -> bool:
        """Whether chi² is not above that of the truth, and below it by what noise explains.

        And no parameter is further off than `FAR`: chi² does not tell an alias from the truth.
        """
        explained = stats.chi2.sf(self.excess, len(self.held)) > CHANCE
        return self.excess > -ROUNDING and bool(explained) and self.off < FAR


#: Standard deviations of which a normal number has more once in a billion draws.
FAR = 6.0


def random_moments(rng: np.random.Generator) -> Floats:
    """Moments all over what a body can have, ``I1 = 1``."""
    moments = 1.0 - rng.dirichlet(np.ones(3))
    ratios: Floats = moments / moments[0]
    return ratios


def guessed(rng: np.random.Generator, moments: Floats) -> Floats:
    """Possible moments, each ratio to the first within 30 % of the truth."""
    while True:
        guess: Floats = moments * (1.0 + np.append(0.0, rng.uniform(-0.3, 0.3, 2)))
        if 2.0 * guess.max() < guess.sum():
            return guess


def judged(number: int, seed: int, bias: bool) -> Finding:
    """A fit of 20 to 200 s at 10 Hz, rates of 0.3 to 2 rad/s, noise of 1e-3 to 3e-2 rad/s."""
    rng = np.random.default_rng([seed, number])
    moments = random_moments(rng)
    guess = guessed(rng, moments)
    return _judged(number, rng, moments, guess, np.arange(0.0, rng.uniform(20.0, 200.0), 0.1), bias)


def judged_few(number: int, seed: int) -> Finding:
    """Such a fit of 4 to 7 samples in 5 to 60 s."""
    rng = np.random.default_rng([seed, number])
    moments = random_moments(rng)
    guess = guessed(rng, moments)
    t = np.linspace(0.0, rng.uniform(5.0, 60.0), int(rng.integers(4, 8)))
    return _judged(number, rng, moments, guess, t, bias=False)


def judged_in_a_wrong_unit(number: int, seed: int) -> Finding:
    """Such a fit of 20 to 400 samples at 10 Hz whose times are in minutes, hours or ms: none."""
    rng = np.random.default_rng([seed, number])
    moments = random_moments(rng)
    guess = guessed(rng, moments)
    count = int(np.exp(rng.uniform(np.log(20.0), np.log(400.0))))
    t = np.linspace(0.0, 0.1 * (count - 1), count)
    unit = rng.choice([60.0, 1.0 / 60.0, 3600.0, 1e3, 1e-3])
    return _judged(number, rng, moments, guess, t, bias=False, unit=float(unit))


def _judged(
    number: int,
    rng: np.random.Generator,
    moments: Floats,
    guess: Floats,
    t: Floats,
    bias: bool,
    unit: float = 1.0,
) -> Finding:
    sigma = float(np.exp(rng.uniform(np.log(1e-3), np.log(3e-2))))
    direction = rng.normal(size=3)
    start = direction / np.linalg.norm(direction) * rng.uniform(0.3, 2.0)
    offset = 0.01 * rng.normal(size=3) if bias else np.zeros(3)
    run = rigid.simulate(rigid.Body(moments), start, t=t, record="rates", check=False)
    noise = sigma * rng.normal(size=run.omega.shape)
    measured = run.omega + offset + noise
    free = ("I2/I1", "I3/I1", "omega", *(("bias",) if bias else ()))
    found = rigid.fit(rigid.Body(guess), unit * t, omega=measured, sigma=sigma, free=free)
    truth = np.concatenate([moments[1:], start, offset if bias else []])
    return Finding(
        number=number,
        success=found.success,
        reason=found.reason,
        excess=float(np.sum(np.square(noise / sigma))) - found.chi2,
        held=np.abs(found.values - truth) <= WITHIN * found.std,
        evaluations=found.evaluations,
        off=float(np.max(np.abs(found.values - truth) / found.std)),
    )
