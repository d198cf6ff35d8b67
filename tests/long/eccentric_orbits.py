"""Is the error of a body on an eccentric orbit what is stated? Random orbits, by default and with
an accuracy, against numbers of 80 bits.

    python tests/long/eccentric_orbits.py [--orbits 3000] [--seed 1]

Every orbit has an eccentricity from 0 to 0.95, with none, one or two of a torque, damping, a rotor,
drag and internal dissipation beside. A run whose true error is above the stated one is looked at
again in 128 bits. The script fails if that is so in more than one of 200 runs that are not flagged,
or if the true error is above twice the stated one in more than one of 1000.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "shared"))

import forced_starts as forced
import quad_motion
import rigid
from adversarial import Case
from hard_starts import decades
from physics import Floats
from verdicts import JUDGED, true_errors

MOST_ABOVE, MOST_ABOVE_TWICE = 1 / 200, 1 / 1000

#: Classes of eccentricities in the table.
BOUNDS = (0.0, 0.5, 0.75, 0.95)


def beside(rng: np.random.Generator, moments: Floats) -> dict[str, Any]:
    """None, one or two of the other forces."""
    names = ["torque", "damping", "rotor", "drag", "dissipation"]
    acting: dict[str, Any] = {}
    for name in rng.choice(names, int(rng.integers(3)), replace=False):
        size = decades(rng, -3.0, -0.5)
        if name == "torque":
            where = rigid.Torque.body if rng.random() < 0.5 else rigid.Torque.space
            acting[name] = where(tuple(size * rng.normal(size=3)))
        elif name == "damping":
            acting[name] = size
        elif name == "rotor":
            acting[name] = rng.normal(size=3) * float(np.median(moments))
        elif name == "drag":
            acting[name] = size * rng.random(3)
        else:
            acting[name] = rigid.EnergySink(0.1 * size)
    return acting


def case(rng: np.random.Generator) -> tuple[Case, float]:
    """A body that tumbles on an orbit of period 2 pi, and the eccentricity."""
    moments = np.sort(rng.uniform(0.3, 1.6, 3))
    moments[2] = min(moments[2], 0.98 * (moments[0] + moments[1]))
    moments = rng.permutation(moments)
    e = float(rng.uniform(0.0, 0.95))
    scene = rigid.FreeBody(
        rigid.Body(moments), orbit=forced.orbit(rng, 1.0, e), **beside(rng, moments)
    )
    last = rng.uniform(12.0, 30.0)
    t = np.array([last])
    if rng.random() < 0.5:
        t = np.sort(rng.uniform(0.0, last, int(rng.integers(2, 20))))
    return Case("orbit", scene, 2.0 * rng.normal(size=3), rng.normal(size=4), t, {}), e


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--orbits", type=int, default=3000)
    parser.add_argument("--seed", type=int, default=1)
    chosen = parser.parse_args()
    table = np.zeros((2, len(BOUNDS) - 1, 4), dtype=int)
    ratios = []
    for number in range(chosen.orbits):
        rng = np.random.default_rng([chosen.seed, number])
        orbit, e = case(rng)
        given = orbit.scene, orbit.omega, orbit.attitude, orbit.t
        fast = quad_motion.motion(
            *given, tolerance=quad_motion.FAST_TOLERANCE, number="long double"
        )
        assert fast is not None
        each: list[dict[str, Any]] = [{}, {"accuracy": decades(rng, -10.0, -4.0)}]
        for kind, options in enumerate(each):
            run = rigid.simulate(*given[:3], t=orbit.t, threads=1, **options)
            counts = table[kind, np.searchsorted(BOUNDS, e) - 1]
            counts[0] += 1
            if int(run.status) not in JUDGED:
                counts[1] += 1
                continue
            stated = float(run.error)
            true = float(true_errors(orbit, run, None, fast).max())
            if true > stated:
                exact = quad_motion.motion(*given)
                assert exact is not None
                true = float(true_errors(orbit, run, None, exact).max())
            ratios.append(true / stated)
            if true > stated:
                counts[2] += 1
                counts[3] += true > 2.0 * stated
                print(f"{number}: {options}, e {e:.2f}, true {true:.1e}, stated {stated:.1e}")
                print(f"    {orbit.code()}", flush=True)
    print(f"{'':10} {'e':>12} {'runs':>6} {'flagged':>8} {'above':>6} {'above twice':>12}")
    for kind, name in enumerate(("default", "accuracy=")):
        for low, high, row in zip(BOUNDS, BOUNDS[1:], table[kind], strict=False):
            words = f"{low:g} to {high:g}"
            print(f"{name:10} {words:>12} {row[0]:6} {row[1]:8} {row[2]:6} {row[3]:12}")
    at = np.quantile(ratios, [0.05, 0.5, 0.95]).round(4).tolist()
    print(f"true error / stated error, quantiles 5, 50, 95 %: {at}")
    above, twice = table[..., 2].sum() / len(ratios), table[..., 3].sum() / len(ratios)
    return int(above > MOST_ABOVE or twice > MOST_ABOVE_TWICE)


if __name__ == "__main__":
    sys.exit(main())
