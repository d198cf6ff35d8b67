"""A million random tensors rebuilt from their axes: python tests/long/principal_axes.py."""

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "shared"))
from random_tensors import worst_principal_axes

BATCH = 100_000

count = int(sys.argv[1]) if len(sys.argv) > 1 else 1_000_000
rng = np.random.default_rng(1)
worst = max(worst_principal_axes(min(BATCH, count - k), rng) for k in range(0, count, BATCH))
print(f"{count} tensors, largest relative error {worst:.2g}")
sys.exit(int(worst >= 1e-14))
