"""Subjects that say how exact they are, on random cases that are hard, beside truths of their own.

    python tests/long/survey_motions.py [--subject growth] [--count 500] [--seed 1] [--from 0]

The truths share no line with the library: series and extrapolation in 128-bit numbers, rational
numbers, elliptic integrals and eigenvalues in 40 digits. A case is right, off by what some
roundings of its inputs change, flagged, refused, without a truth, or UNDETECTED: these are listed,
and the script fails if there is one.
"""

import argparse
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "shared"))

from judged import VERDICTS, Judged
from judged_bodies import million_steps
from judged_subjects import SUBJECTS


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--subject", action="append", choices=SUBJECTS, help="default: all")
    parser.add_argument("--count", type=int, default=500)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--from", type=int, default=0, dest="first", help="number of the first")
    chosen = parser.parse_args()
    numbers = range(chosen.first, chosen.first + chosen.count)
    failed = False
    with ProcessPoolExecutor() as pool:
        for subject in chosen.subject or SUBJECTS:
            begin = time.perf_counter()
            judge = partial(SUBJECTS[subject], seed=chosen.seed)
            found = list(pool.map(judge, numbers, chunksize=8))
            lines(subject, found, time.perf_counter() - begin, chosen.first)
            failed |= any(one.verdict == "UNDETECTED" for one in found)
    if not chosen.subject:
        of_rates, of_sum = million_steps()
        print(f"a million steps: rates {of_rates:.1e} rad/s, the sum of their lengths {of_sum:.1e}")
        failed |= of_rates > 1e-9
    return int(failed)


def lines(subject: str, found: list[Judged], seconds: float, first: int) -> None:
    """Counts of the verdicts on each kind, and each case that was wrong."""
    print(f"{subject}, {seconds:.0f} s")
    print(f"    {'':30}", *(f"{verdict:>10}" for verdict in VERDICTS))
    for kind in [*sorted({one.kind for one in found}), "all"]:
        rows = [one.verdict for one in found if kind in ("all", one.kind)]
        print(f"    {kind:30}", *(f"{rows.count(verdict):10}" for verdict in VERDICTS))
    for number, one in enumerate(found, first):
        if one.verdict == "UNDETECTED":
            print(f"    {number}: {one.kind}, {one.off:.2e}, stated {one.stated:.2e}, {one.words}")


if __name__ == "__main__":
    sys.exit(main())
