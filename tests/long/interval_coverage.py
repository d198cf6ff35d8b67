"""The exact coverage of sequential intervals, and that of simulated pixels with unknown bodies.

    python tests/long/interval_coverage.py [--widths 100] [--shares 500] [--pixels 10000]

Fails if the least coverage over all tried shares, and over both sides of the ends of the intervals,
is below 0.95 for any half width, or that of the simulated pixels.
"""

import argparse
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "shared"))

from rigid.maps.data import interval
from rigid.maps.sequential import CONFIDENCE, LOOK, stop_table
from stopping import least_coverage


def simulated(half_width: float, p: float, unknown: float, pixels: int) -> float:
    """The share of simulated pixels whose interval holds p; of their bodies some are unknown."""
    random, looks = np.random.default_rng(1), stop_table(half_width)
    stable = np.zeros(pixels, np.int64)
    either, samples = np.zeros_like(stable), np.zeros_like(stable)
    active = np.ones(pixels, np.bool_)
    while active.any():
        new = random.random((int(active.sum()), LOOK))
        hidden = random.random(new.shape) < unknown
        stable[active] += ((new < p) & ~hidden).sum(axis=1)
        either[active] += hidden.sum(axis=1)
        samples[active] += LOOK
        active &= ~looks.stops(stable, either, samples)
    lower = interval(stable, samples, CONFIDENCE)[0]
    upper = interval(stable + either, samples, CONFIDENCE)[1]
    return float(((lower <= p) & (p <= upper)).mean())


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--widths", type=int, default=100)
    parser.add_argument("--shares", type=int, default=500)
    parser.add_argument("--pixels", type=int, default=10_000)
    chosen = parser.parse_args()
    found: dict[float, float] = {}
    for half_width in np.geomspace(0.01, 0.25, chosen.widths).tolist():
        # The bands grow with 1 / width: few shares where a recursion has thousands of states.
        count = chosen.shares if half_width > 0.02 else chosen.shares // 3
        found |= least_coverage([half_width], count)
    worst = min(found, key=lambda half_width: found[half_width])
    print(f"least coverage {found[worst]:.4f}, of half width {worst:.4f}")
    least = 1.0
    for p in (0.0, 0.003, 0.05, 0.2, 0.5, 0.93, 1.0):
        for unknown in (0.005, 0.02):
            least = min(least, simulated(0.05, p, unknown, chosen.pixels))
    print(f"least coverage of simulated pixels with unknown bodies {least:.4f}")
    return int(found[worst] < 0.95 or least < 0.95)


if __name__ == "__main__":
    raise SystemExit(main())
