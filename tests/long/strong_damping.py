"""Is what a run says of its error true under strong damping? Random runs against 80-bit numbers.

    python tests/long/strong_damping.py [--scenes 10000] [--seed 1] [--from 0]

Fails if the true error of any run that claims its error is above the larger of the error asked for
and the error stated.
"""

import argparse
import sys
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "shared"))

from strong_damping import WAYS, Judged, judge


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--scenes", type=int, default=10000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--from", type=int, default=0, dest="first", help="number of the first")
    chosen = parser.parse_args()
    numbers = range(chosen.first, chosen.first + chosen.scenes)
    with ProcessPoolExecutor() as pool:
        found = list(pool.map(partial(judge, seed=chosen.seed), numbers, chunksize=16))
    judged = [one for one in found if one is not None]
    print(f"{len(found)} runs, {len(found) - len(judged)} refused or without truth")
    for way in WAYS:
        print_way(way, [one for one in judged if one.way == way])
    undetected = [one for one in judged if one.is_claimed and not one.excess <= 1.0]
    for one in sorted(undetected, key=lambda one: -one.excess):
        print(
            f"{one.number}: UNDETECTED, {one.way}, {one.method}, damping rate times length "
            f"{one.strength:.1e}: stated {one.stated:.1e}, asked {one.asked:.1e}, "
            f"true {one.true:.1e}\n  {one.case.code()}"
        )
    return int(bool(undetected))


def print_way(way: str, runs: list[Judged]) -> None:
    """How many of the runs asked for in a way claim their error, by which methods."""
    claimed = [one for one in runs if one.is_claimed]
    worst = max((one.excess for one in claimed), default=0.0)
    methods = Counter(one.method for one in runs).most_common(4)
    names = ", ".join(f"{name} {count}" for name, count in methods)
    print(f"{way}: {len(claimed)} of {len(runs)} claimed, worst excess {worst:.2g}; {names}")


if __name__ == "__main__":
    sys.exit(main())
