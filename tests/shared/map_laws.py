"""The draws of maps against distributions of SciPy, and how often intervals hold known shares.

Deviates are carried to uniforms by the distribution functions of their law. Of these uniforms each
column, all columns together, neighbouring samples and neighbouring pixels are tested.
"""

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from scipy import stats
from scipy.spatial.transform import Rotation

import rigid
from fine_motion import Floats
from map_survey import Tally

UNLIKELY = 1e-4
"""Chance that any of all tests of a survey fails although every law is what it is called."""

NOMINAL = (0.7, -1.1, 2.4)
TOP = rigid.HeavyTop(rigid.Body((1.0, 1.3, 0.7)), mgl=1.0)


def draws(seed: int, samples: int) -> Tally:
    """Tests of all laws, each of two pixels of so many samples."""
    tally, rng = Tally(), np.random.default_rng(seed)
    found: dict[str, float] = {}
    for name, uniforms in _laws(rng, samples):
        for what, p in _battery(uniforms):
            found[f"{name}: {what}"] = p
    found.update(_choices(rng, samples))
    for name, p in found.items():
        tally.count(p > UNLIKELY / len(found), f"{name} of seed {seed}: p = {p:.1e}")
    return tally


def _starts(samples: int, seed: int, **start: Any) -> tuple[Floats, Floats]:
    """Rates (2, samples, 3) and attitudes (2, samples, 4); no body is integrated."""
    result = rigid.stability_map(
        TOP,
        axes={"mgl": [1.0, 2.0]},
        start=start.pop("start", None) or rigid.Start(omega=NOMINAL, **start),
        stable=rigid.no_flip(1),
        samples=samples,
        t_end=1.0,
        max_steps=1,
        rng=seed,
        progress=False,
    )
    starts = result.starts(range(samples))
    return starts.omega, starts.attitude


def _turns(attitude: Floats) -> Floats:
    """Rotation vectors of attitudes, whose nominal one is the identity."""
    vectors = Rotation.from_quat(attitude.reshape(-1, 4), scalar_first=True).as_rotvec()
    return np.asarray(vectors).reshape(*attitude.shape[:-1], 3)


def _of_direction(vectors: Floats, height: Callable[[Floats], Floats]) -> Floats:
    """Uniforms of directions about axis 3: from their height by its distribution, and azimuth."""
    up = vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)
    azimuth = np.arctan2(up[..., 1], up[..., 0]) / (2.0 * np.pi) + 0.5
    return np.stack([height(up), azimuth], axis=-1)


def _even(up: Floats) -> Floats:
    """Of uniform directions: Archimedes."""
    height: Floats = 0.5 * (up[..., 2] + 1.0)
    return height


def _laws(rng: np.random.Generator, samples: int) -> Iterator[tuple[str, Floats]]:
    """Each law, and its deviates as uniforms of shape (2, samples, k)."""

    def seed() -> int:
        return int(rng.integers(2**62))

    sizes = 10.0 ** rng.uniform(-6.0, 0.0, 3)
    for law, cdf in (
        (rigid.normal, stats.norm.cdf),
        (rigid.uniform, stats.uniform(-1.0, 2.0).cdf),
    ):
        omega, _ = _starts(samples, seed(), noise=law(sizes))
        # A sum with the nominal rate is rounded: ties and gaps of 1e-16, far below 1 / samples.
        yield f"{law.__name__} rates", cdf((omega - NOMINAL) / sizes)
        _, attitude = _starts(samples, seed(), attitude_noise=law(0.5 * sizes))
        yield f"{law.__name__} attitudes", cdf(_turns(attitude) / (0.5 * sizes))
    omega, attitude = _starts(
        samples, seed(), noise=rigid.direction(sizes), attitude_noise=rigid.direction(0.3)
    )
    yield "directions of rates", _of_direction((omega - NOMINAL) / sizes, _even)
    yield "directions of attitudes", _of_direction(_turns(attitude), _even)
    omega, attitude = _starts(
        samples, seed(), noise=rigid.normal(0.2), attitude_noise=rigid.normal(0.2)
    )
    both = np.concatenate([omega - NOMINAL, _turns(attitude)], axis=-1)
    yield "rates and attitudes of one body", stats.norm.cdf(both / 0.2)
    for kappa in (0.3, 20.0, 1e5):
        yield from _of_kappa(kappa, samples, seed)
    _, attitude = _starts(samples, seed(), attitude_noise=rigid.uniform_attitude())
    vectors = _turns(attitude)
    angle = np.linalg.norm(vectors, axis=-1)
    columns = [(angle - np.sin(angle))[..., None] / np.pi, _of_direction(vectors, _even)]
    yield "uniform attitudes", np.concatenate(columns, axis=-1)
    turned = np.asarray(
        Rotation.from_quat(attitude.reshape(-1, 4), scalar_first=True).apply([0.6, 0.0, 0.8])
    )
    yield "an axis of uniform attitudes", _of_direction(turned.reshape(2, -1, 3), _even)
    for size in (3, 6):
        factor = np.tril(rng.normal(size=(size, size)) * 0.1)
        cov = factor @ factor.T
        noise = rigid.normal(cov=0.5 * (cov + cov.T))
        omega, attitude = _starts(samples, seed(), noise=noise)
        deviates = np.concatenate([omega - NOMINAL, _turns(attitude)], axis=-1)[..., :size]
        white = np.linalg.solve(np.linalg.cholesky(cov), deviates[..., None])[..., 0]
        yield f"covariance {size} x {size}", stats.norm.cdf(white)
        # No factor: the squared Mahalanobis distance.
        squares = np.einsum("...i,ij,...j", deviates, np.linalg.inv(cov), deviates)
        yield f"distances, covariance {size} x {size}", stats.chi2(size).cdf(squares)[..., None]


def _of_kappa(kappa: float, samples: int, seed: Callable[[], int]) -> Iterator[tuple[str, Floats]]:
    """Directions of von Mises and Fisher: of rates about theirs, and of the axis of a body."""

    def height(up: Floats) -> Floats:
        off = 0.5 * ((up - [0.0, 0.0, 1.0]) ** 2).sum(axis=-1)  # 1 - cos, also of small angles
        share: Floats = np.expm1(-kappa * off) / np.expm1(-2.0 * kappa)
        return share

    law = rigid.von_mises_fisher(kappa)
    omega, _ = _starts(samples, seed(), noise=law)
    to_third, _ = Rotation.align_vectors([[0.0, 0.0, 1.0]], [np.array(NOMINAL)])
    about = np.asarray(to_third.apply(omega.reshape(-1, 3))).reshape(omega.shape)
    yield f"rates, kappa {kappa:g}", _of_direction(about, height)
    _, attitude = _starts(samples, seed(), attitude_noise=law)
    axis = Rotation.from_quat(attitude.reshape(-1, 4), scalar_first=True).apply([0.0, 0.0, 1.0])
    yield f"axis, kappa {kappa:g}", _of_direction(np.asarray(axis).reshape(omega.shape), height)


def _battery(uniforms: Floats) -> Iterator[tuple[str, float]]:
    """Chances of what is at least as uneven, if all numbers are independent and uniform."""
    _, samples, columns = uniforms.shape
    for k in range(columns):
        for pixel in range(2):
            p = stats.kstest(uniforms[pixel, :, k], "uniform").pvalue
            yield f"column {k} of pixel {pixel}", float(p)
        yield f"pixels, column {k}", _correlation(uniforms[0, :, k], uniforms[1, :, k])
        for lag in (1, 2, 64):
            one, other = uniforms[0, :-lag, k], uniforms[0, lag:, k]
            yield f"lag {lag}, column {k}", _correlation(one, other)
        for other_column in range(k):
            yield (
                f"columns {other_column} and {k}",
                _correlation(uniforms[0, :, other_column], uniforms[0, :, k]),
            )
    # As many cells of all columns together as there are 20 samples for each.
    side = int(max(2, min(8, (samples / 20) ** (1.0 / columns))))
    if side**columns <= samples / 5:
        cells = np.clip((uniforms[0] * side).astype(np.int64), 0, side - 1)
        counts = np.bincount(cells @ side ** np.arange(columns), minlength=side**columns)
        yield f"{side}^{columns} cells", float(stats.chisquare(counts).pvalue)


def _correlation(one: Floats, other: Floats) -> float:
    """Chance of a correlation at least as large; Fisher's z of uniforms is as of normals."""
    z = np.arctanh(np.corrcoef(one, other)[0, 1]) * np.sqrt(len(one) - 3)
    return float(2.0 * stats.norm.sf(abs(z)))


def _choices(rng: np.random.Generator, samples: int) -> Iterator[tuple[str, float]]:
    """Which entry of a list, and which start of a mixture, a body takes."""
    entries = np.arange(1.0, 8.0)[:, None] * [1.0, 0.0, 0.0]
    weights = rng.uniform(0.1, 1.0, 7)
    weights[2] = 0.0
    omega, _ = _starts(
        samples, int(rng.integers(2**62)), noise=rigid.samples(entries, weights=weights)
    )
    taken = np.rint(omega[..., 0] - NOMINAL[0]).astype(np.int64) - 1
    yield from _chosen("samples", taken, weights)
    starts = [rigid.Start(spin=float(k), noise=rigid.uniform(0.1)) for k in range(1, 6)]
    weights = rng.uniform(0.1, 1.0, 5)
    omega, _ = _starts(samples, int(rng.integers(2**62)), start=rigid.mixture(starts, weights))
    taken = np.rint(omega[..., 2]).astype(np.int64) - 1
    yield from _chosen("mixture", taken, weights)
    deviates = (omega - (taken[..., None] + 1.0) * [0.0, 0.0, 1.0]) / 0.1
    for what, p in _battery(0.5 * (deviates + 1.0)):
        yield f"deviates of a mixture: {what}", p
    for k in range(3):
        groups = [deviates[taken == number][:, k] for number in range(5)]
        yield f"starts of a mixture, rate {k}", float(stats.kruskal(*groups).pvalue)


def _chosen(name: str, taken: Any, weights: Floats) -> Iterator[tuple[str, float]]:
    """Of choices: their counts, and those of neighbouring bodies together."""
    shares = weights / weights.sum()
    likely = shares > 0.0
    counts = np.bincount(taken.ravel(), minlength=len(shares))
    yield f"{name}, entries of no weight", float(not counts[~likely].any())
    expected = shares[likely] * taken.size
    yield f"{name}, counts", float(stats.chisquare(counts[likely], expected).pvalue)
    pairs = np.zeros((len(shares), len(shares)))
    np.add.at(pairs, (taken[:, :-1], taken[:, 1:]), 1.0)
    table = pairs[likely][:, likely]
    yield f"{name}, neighbours", float(stats.chi2_contingency(table).pvalue)


# Intervals

DISC = rigid.FreeBody(rigid.Body((1.0, 1.0, 2.0)))

SHARES = (0.003, 0.02, 0.05, 0.1, 0.11, 0.2, 0.3, 0.5, 0.7, 0.9, 0.97, 0.998)


def disc_map(shares: Any, pixels: int, seed: int, **options: Any) -> tuple[Any, Floats]:
    """A map whose columns have these shares, in closed form, and the shares of its columns.

    The rate of a disc about axis 1 is ``cos(omega3 t)`` times its start: it keeps its sign until
    t = 1 if ``omega3``, uniform in [-s, s], is below pi/2. That is the share ``pi / (2 s)``.
    """
    sizes = np.sort(0.5 * np.pi / np.asarray(shares))
    chosen: dict[str, Any] = {"stable": rigid.no_flip(1), "t_end": 1.0, **options}
    result = rigid.stability_map(
        DISC,
        axes={"noise3": sizes, "omega1": np.linspace(1.0, 1.1, pixels)},
        start=rigid.Start(omega=(1.0, 0.0, 0.0), noise=rigid.uniform([0.0, 0.0, 1.0])),
        rng=seed,
        progress=False,
        **chosen,
    )
    return result, 0.5 * np.pi / sizes


def hiding(which: str) -> Any:
    """The same criterion by a function that calls some bodies undecided."""

    def verdict(states: rigid.States) -> Floats:
        spin = np.abs(states.omega[:, 0, 2])
        stable = spin < 0.5 * np.pi
        chance = np.modf(1e6 * spin)[0]
        hidden = {
            "any": chance < 0.05,
            "stable": stable & (chance < 0.1),
            "unstable": ~stable & (chance < 0.1),
        }[which]
        out: Floats = np.where(hidden, np.nan, np.where(stable, 1.0, -1.0))
        return out

    return rigid.judged(verdict, [0.0, 1.0], of="rates")


RULES: dict[str, dict[str, Any]] = {
    "samples=1": {"samples": 1},
    "samples=7": {"samples": 7},
    "samples=64": {"samples": 64},
    "samples=300": {"samples": 300},
    "half_width=0.25": {"half_width": 0.25},
    "half_width=0.1": {"half_width": 0.1},
    "half_width=0.05": {"half_width": 0.05},
    "half_width=0.1, refine": {"half_width": 0.1, "refine": 8},
    "samples=64, refine": {"samples": 64, "refine": 8},
    "samples=64, budget": {"samples": 64, "refine": 8, "budget": 100_000},
    "half_width=0.1, budget": {"half_width": 0.1, "refine": 8, "budget": 200_000},
    "samples=20, 5 % undecided": {"samples": 20, "stable": hiding("any")},
    "samples=64, stable undecided": {"samples": 64, "stable": hiding("stable")},
    "samples=64, unstable undecided": {"samples": 64, "stable": hiding("unstable")},
    "half_width=0.2, 5 % undecided": {"half_width": 0.2, "stable": hiding("any")},
    "half_width=0.2, stable undecided": {"half_width": 0.2, "stable": hiding("stable")},
    "half_width=0.2, unstable undecided": {"half_width": 0.2, "stable": hiding("unstable")},
}
"""Ways to say how many bodies a pixel gets."""


def coverage(seed: int, pixels: int) -> dict[str, Tally]:
    """Of each rule: shares that are held often enough or not.

    A share is held too rarely if so few of the intervals of 95 % have a chance below
    :data:`UNLIKELY` among all shares and rules.
    """
    found = {}
    for number, (name, options) in enumerate(RULES.items()):
        tally = Tally()
        width = options.get("half_width", 0.1)
        # Where coverage is least: next to twice the half width.
        tried = np.unique([*SHARES, 1.96 * width, 2.04 * width])
        result, shares = disc_map(tried[tried < 1.0], pixels, seed + number, **options)
        known = result.samples > 0
        holds = (result.lower <= shares) & (shares <= result.upper) & known
        for share, held, of in zip(shares, holds.sum(axis=0), known.sum(axis=0), strict=True):
            if not of:
                continue
            chance = float(stats.binom.cdf(held, of, 0.95))
            tally.count(
                chance > UNLIKELY / (len(RULES) * len(tried)),
                (f"{name} of seed {seed}: {share:g} is held {held} times of {of}"),
            )
        found[name] = tally
    return found
