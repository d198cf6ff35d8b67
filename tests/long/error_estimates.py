"""Is the stated error honest? Ten thousand scenes: python tests/long/error_estimates.py [COUNT]."""

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "shared"))
from error_survey import survey

ratios, missed = survey(int(sys.argv[1]) if len(sys.argv) > 1 else 10_000, seed=1)
within = float(np.mean(ratios <= 1.0))
print(f"{len(ratios)} runs, {within:.2%} within, median {np.median(ratios):.3f}")
print(f"largest ratios {np.sort(ratios)[-5:].round(2).tolist()}, undetected misses {len(missed)}")
for one in missed:
    print(one)
sys.exit(int(bool(missed) or within < 0.99 or not 0.05 <= np.median(ratios) <= 1.0))
