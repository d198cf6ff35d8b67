"""A million random scenes: closed forms against Runge-Kutta steps, which share no code.

    python tests/long/closed_forms_against_rk4.py [--scenes 1000000] [--seed 1]

Some minutes on two cores. Fails if any difference is larger than RK4 can have made it.
"""

import argparse
import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "shared"))

from physics import Floats
from random_scenes import batches, compared
from rigid._checks.arguments import resolve_threads

BATCH = 8192
SHOWN = 5
QUANTILES = (0.5, 0.9, 0.99, 0.999, 0.9999, 1.0)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--scenes", type=int, default=1_000_000)
    parser.add_argument("--seed", type=int, default=1)
    chosen = parser.parse_args()
    threads = resolve_threads(None)
    columns: dict[str, list[Floats]] = {}
    worst: list[tuple[float, str]] = []
    begin, done = time.perf_counter(), 0
    for scenes, times in batches(np.random.default_rng(chosen.seed), chosen.scenes, BATCH):
        result = compared(scenes, times, threads)
        row = np.stack([result.difference, result.expected, result.allowed])
        columns.setdefault(scenes.family, []).append(row)
        for k in np.argsort(-result.allowed)[:SHOWN]:
            text = f"{scenes.family}: {scenes.written(int(k))}, t={times.tolist()}"
            worst.append((float(result.allowed[k]), text))
        worst = sorted(worst, reverse=True)[:SHOWN]
        done += len(scenes)
        seconds = time.perf_counter() - begin
        line = (
            f"{done} of {chosen.scenes} scenes, {seconds:.0f} s, worst {worst[0][0]:.3g} of the bar"
        )
        print(f"\r{line}", end="", file=sys.stderr, flush=True)
    print(file=sys.stderr)

    violations = 0
    print("quantiles", *QUANTILES)
    for family, rows in columns.items():
        difference, expected, allowed = np.concatenate(rows, axis=1)
        beyond = int((allowed > 1.0).sum())
        violations += beyond
        print(f"{family}: {len(allowed)} scenes, {beyond} beyond the bar")
        for name, values in (
            ("difference (rad)", difference),
            ("of the expected", expected),
            ("of the allowed", allowed),
        ):
            at = np.quantile(values, QUANTILES, method="inverted_cdf")
            print(f"  {name:16}", *(f"{value:9.2e}" for value in at))
    print("worst, as shares of the bar:")
    for share, text in worst:
        print(f"  {share:.3g} {text}")
    return 1 if violations else 0


if __name__ == "__main__":
    sys.exit(main())
