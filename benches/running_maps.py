"""What it costs to store a map: processor time of stored and unstored runs, appends and opening.

python benches/running_maps.py [--repeats 5]
"""

from __future__ import annotations

import argparse
import dataclasses
import resource
import tempfile
import time
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np

from rigid.cli.toml_map import read_spec
from rigid.maps.compute import run_map
from rigid.maps.parameters import make_axes
from rigid.maps.spec import MapSpec
from rigid.store.compute import compute
from rigid.store.resume import carry_on
from rigid.store.rows import ROW
from rigid.store.running import Folder

MILLION = 1_000_000


def cost(work: Any) -> float:
    """Processor time, s."""
    begin = time.process_time()
    work()
    return time.process_time() - begin


def overhead(name: str, spec: MapSpec, repeats: int) -> None:
    """Stored against unstored, each on one thread, in turn."""
    plain, stored = [], []
    for _ in range(repeats):
        fresh = dataclasses.replace(spec)  # without the starts of the run before
        plain.append(cost(lambda: run_map(fresh, threads=1, progress=False)))  # noqa: B023
        with tempfile.TemporaryDirectory() as place:
            folder = Folder.at(Path(place, "run"), spec)
            stored.append(
                cost(lambda: carry_on(folder, threads=1, stop=lambda: False, progress=False))  # noqa: B023
            )
    ratio = median(b / a - 1.0 for a, b in zip(plain, stored, strict=True))
    print(f"{name}: {median(plain):.3f} s, stored {median(stored):.3f} s: {ratio:+.1%}")


def appends(spec: MapSpec, repeats: int) -> None:
    """One record."""
    block = compute(spec, np.arange(8192))
    assert block is not None
    rows, nanoseconds, _ = block
    with tempfile.TemporaryDirectory() as place:
        folder = Folder.at(Path(place, "run"), spec)
        folder.begin()
        for count in (1, 128, 1024, 8192):
            log = folder._log
            assert log is not None
            costs = [
                cost(lambda: log.append(rows[:count], nanoseconds[:count]))  # noqa: B023
                for _ in range(20 * repeats)
            ]
            print(f"append of {count} rows: {1e3 * median(costs):.2f} ms")
        folder.end("interrupted")


def opening(spec: MapSpec) -> None:
    """A store of a million units."""
    ends = {axis.name: (axis.values[0], axis.values[-1]) for axis in spec.axes}
    axes = make_axes({name: np.geomspace(*two, 1000) for name, two in ends.items()})
    many = dataclasses.replace(spec, axes=axes)
    with tempfile.TemporaryDirectory() as place:
        folder = Folder.at(Path(place, "run"), many)
        folder.begin()
        for begin in range(0, MILLION, 8192):
            rows = np.zeros(min(8192, MILLION - begin), ROW)
            rows["unit"] = np.arange(begin, begin + len(rows))
            folder.append(rows, np.ones(len(rows), "<f4"))
        folder.end("complete")
        del folder
        begin_time = time.perf_counter()
        seconds = cost(lambda: Folder(Path(place, "run")))
        wall = time.perf_counter() - begin_time
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(f"opening {MILLION:,} units: {seconds:.2f} s ({wall:.2f} s of wall), {memory:.0f} MB")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeats", type=int, default=5)
    repeats = parser.parse_args().repeats
    spec = read_spec("thrown-box").spec
    overhead("closed form, 19200 pixels of 64 bodies", spec, repeats)
    integrated = dataclasses.replace(spec, method="rk4", samples=8, step=1e-3)
    overhead("RK4, 19200 pixels of 8 bodies", integrated, max(1, repeats // 2))
    appends(spec, repeats)
    opening(spec)


if __name__ == "__main__":
    main()
