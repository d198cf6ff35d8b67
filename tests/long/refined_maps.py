"""Refined maps have the bits of full ones, and nine times fewer bodies where a border is sharp.

    python tests/long/refined_maps.py

Every built-in map on its own grid with few bodies, full and with ``refine=16`` and 8; then
``inertia-triangle`` with 481 x 481 pixels against a map of 256 other bodies in each pixel. Fails if
a pixel of a refined map differs from that of the full one in any column, if 481 x 481 pixels take
more than an eighth of the bodies, or a twenty-fifth if they stop as soon as their interval is
narrow, or if more than 1.1 times the pixels of the full map are on the wrong side of one half.
"""

import dataclasses
from typing import Any

import numpy as np

import rigid
from rigid.cli.toml_map import read_spec
from rigid.cli.toml_table import names_of
from rigid.maps.axes import make_axes
from rigid.maps.data import COLUMNS
from rigid.maps.sequential import stop_table
from rigid.store.store import run_map

SAMPLES = 8

#: Of the widest interval at a share of one half, if it is looked at once (SciPy): 2 * 0.05.
FIXED = 448


def run(spec: rigid.MapSpec) -> rigid.StabilityMap:
    result: rigid.StabilityMap = run_map(
        spec,
        store=None,
        seeded=True,
        executor=None,
        threads=None,
        threads_per_task=1,
        part=None,
        progress=False,
        partial=False,
    )
    return result


def differing(spec: rigid.MapSpec, strides: tuple[int, ...]) -> dict[int, tuple[int, int]]:
    """Of each stride: computed pixels, and those of them that differ from the full map."""
    full = run(spec)
    found = {}
    for stride in strides:
        part = run(dataclasses.replace(spec, refine=stride))
        done = (part.stage != rigid.maps.refine.LEFT_OUT) & (part.status == 0)
        wrong = np.zeros(done.shape, np.bool_)
        for column in COLUMNS:
            if column.reproducible:
                one, other = full.columns[column.name], part.columns[column.name]
                same = (one == other) | ((one != one) & (other != other))
                wrong |= ~same
        found[stride] = int(done.sum()), int((wrong & done).sum())
    return found


def triangle() -> bool:
    """Whether the large map is as good as it should be."""
    small = read_spec("inertia-triangle").spec
    axes = {axis.name: np.linspace(axis.values[0], axis.values[-1], 481) for axis in small.axes}
    spec = dataclasses.replace(small, axes=make_axes(axes))
    truth = run(dataclasses.replace(spec, samples=256, seed=999)).share
    possible = np.isfinite(truth)

    def told(name: str, **changes: Any) -> tuple[int, float]:
        if "half_width" in changes:
            changes["samples"] = stop_table(changes["half_width"]).last
        result = run(dataclasses.replace(spec, **changes))
        share = result.filled if "refine" in changes else result.share
        bodies = int(result.samples.sum())
        wrong = float(((share > 0.5) != (truth > 0.5))[possible].mean())
        error = float(np.sqrt(np.mean((share - truth)[possible] ** 2)))
        print(f"{name}: {bodies} bodies, error {error:.4f}, wrong side {wrong:.5f}", flush=True)
        return bodies, wrong

    full, wrong = told("full")
    refined, wrong_refined = told("refined", refine=16)
    both, _ = told("both", refine=16, half_width=0.05)
    fixed = FIXED * int(possible.sum())
    print(f"{full / refined:.1f} and {fixed / both:.1f} times fewer bodies")
    return full >= 8 * refined and fixed >= 25 * both and wrong_refined <= 1.1 * wrong


def main() -> int:
    bad = 0
    for name in names_of("map"):
        spec = dataclasses.replace(read_spec(name).spec, samples=SAMPLES, half_width=None)
        for stride, (pixels, wrong) in differing(spec, (16, 8)).items():
            print(f"{name}, refine={stride}: {pixels} pixels, {wrong} differ", flush=True)
            bad += wrong
    return int(bad > 0 or not triangle())


if __name__ == "__main__":
    raise SystemExit(main())
