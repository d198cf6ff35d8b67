"""Random fits of moments from noisy rates: how many are right, and do the rest say so?

    python tests/long/fits.py [--count 500] [--seed 1] [--kinds KIND ...] [--workers N]

Without and with a free bias of the gyroscope; of 4 to 7 samples; with times in a wrong unit, where
no fit is right. Fails if a wrong one says that it succeeded. Of the first two also if less than
97 % are right, or if the intervals of 95 % hold less than 93 % or more than 97 % of the truths.
"""

import argparse
import sys
import time
import warnings
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "shared"))

import rigid
from fit_cases import Finding, judged, judged_few, judged_in_a_wrong_unit

LEAST_RIGHT, COVERAGE = 0.97, (0.93, 0.97)

KINDS = {
    "bias none": partial(judged, bias=False),
    "bias free": partial(judged, bias=True),
    "few samples": judged_few,
    "wrong unit": judged_in_a_wrong_unit,
}


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=500)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--kinds", nargs="+", default=list(KINDS), choices=KINDS)
    parser.add_argument("--workers", type=int, help="processes; by default one a processor")
    chosen = parser.parse_args()
    with ProcessPoolExecutor(chosen.workers, initializer=expect_failures) as pool:
        wrong = [table(pool, kind, chosen.count, chosen.seed) for kind in chosen.kinds]
    return int(any(wrong))


def expect_failures() -> None:
    """Failed fits are counted here, so none need warn."""
    warnings.simplefilter("ignore", rigid.FitWarning)


def table(pool: ProcessPoolExecutor, kind: str, count: int, seed: int) -> bool:
    """Print what was found; whether it is too bad."""
    begin = time.perf_counter()
    judge = partial(KINDS[kind], seed=seed)
    findings: list[Finding] = list(pool.map(judge, range(count), chunksize=4))
    seconds = (time.perf_counter() - begin) / count
    none_is_right, dense = kind == "wrong unit", kind.startswith("bias")
    right = [one for one in findings if one.success and one.right and not none_is_right]
    undetected = [one for one in findings if one.success and one not in right]
    failed = [one for one in findings if not one.success]
    evaluations = [one.evaluations for one in findings]
    print(
        f"{kind}: {len(right)} of {count} right, {len(failed)} flagged, "
        f"{len(undetected)} UNDETECTED; "
        f"{np.mean(evaluations):.1f} evaluations, most {max(evaluations)}; "
        f"{seconds:.2f} s a fit"
    )
    for one in undetected:
        print(f"  {one.number}: UNDETECTED, chi2 above that of the truth by {-one.excess:.1f}")
    if not dense:
        return bool(undetected)
    held = np.array([one.held for one in findings if one.success])
    print(f"  intervals of 95 % hold {held.mean():.4f}; of each parameter {held.mean(0).round(3)}")
    for one in failed:
        print(f"  {one.number}: {one.reason}")
    covered = COVERAGE[0] <= held.mean() <= COVERAGE[1]
    return len(right) < LEAST_RIGHT * count or bool(undetected) or not covered


if __name__ == "__main__":
    sys.exit(main())
