"""Verdicts of all criteria against fine motions of many random bodies.

    python tests/long/criteria.py                 # 10 000 bodies for each criterion; some minutes
    python tests/long/criteria.py --bodies 1000

No verdict may be wrong, in four families: free bodies without and with symmetry, Lagrange tops and
tops without symmetry. Prints how many bodies are undecided, and how far the times of leaving are
from those of the fine motion.
"""

import argparse
import sys

import numpy as np

from criteria_truth import asymmetric_tops, criteria, judged, truth, wrong_verdicts
from random_scenes import free, tops


def main() -> int:
    """Compare; the number of criteria with a wrong verdict."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--bodies", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=2026)
    options = parser.parse_args()
    rng = np.random.default_rng(options.seed)
    n, bad = options.bodies, 0
    families = (
        lambda: free(rng, n, equal=False),
        lambda: free(rng, n, equal=True),
        lambda: tops(rng, n),
        lambda: asymmetric_tops(rng, n),
    )
    for family in families:
        scenes = family()
        for criterion in criteria(scenes.kind, rng):
            verdicts = judged(scenes, criterion)
            wrong, late = wrong_verdicts(criterion, scenes, verdicts, truth(scenes, criterion))
            bad += bool(wrong.size)
            print(
                f"{scenes.family:16} {verdicts.stable.mean():6.1%} stable "
                f"{verdicts.undecided.mean():7.2%} undecided {wrong.size:3} wrong "
                f"late {np.quantile(late, 0.99) if late.size else 0.0:.0e} s  {criterion}",
                flush=True,
            )
            for row in wrong[:2]:
                print("   ", scenes.written(int(row)), flush=True)
    return bad


if __name__ == "__main__":
    sys.exit(main())
