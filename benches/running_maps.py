"""What it costs to store a map: processor time of stored and unstored runs, appends and opening.

python benches/running_maps.py [--repeats 5]
"""

from __future__ import annotations

import dataclasses
import math
import resource
import tempfile
from functools import partial
from pathlib import Path

import numpy as np
from timing import counted, in_turns, over, parser, required, sized

from rigid import StabilityMap
from rigid.cli.toml_map import read_spec
from rigid.maps.axes import make_axes
from rigid.maps.spec import MapSpec
from rigid.store.call import run_map
from rigid.store.head import Head
from rigid.store.log import Log
from rigid.store.resume import carry_on, result_of
from rigid.store.rows import ROW, Block, compute
from rigid.store.running import Folder

SIDE = sized(1000, 100)
"""Pixels of an axis of the map that is opened."""

APPENDS = sized((1, 128, 1024, 8192), (1, 64))
CALLS = 8
"""Appends of a turn: a single one takes little more than a look at the clock."""


def with_side(spec: MapSpec, pixels: int) -> MapSpec:
    """The map with so many pixels on each axis."""
    ends = {axis.name: (axis.values[0], axis.values[-1]) for axis in spec.axes}
    axes = make_axes({name: np.geomspace(*two, pixels) for name, two in ends.items()})
    return dataclasses.replace(spec, axes=axes)


def overhead(name: str, spec: MapSpec, repeats: int) -> None:
    """Stored against unstored, each on one thread, in turn."""
    with tempfile.TemporaryDirectory() as place:
        # One for each turn and for the first.
        folders = iter([Folder.at(Path(place, str(i)), spec) for i in range(repeats + 1)])

        def unstored() -> StabilityMap:
            fresh = dataclasses.replace(spec)  # without the starts of the run before
            return run_map(fresh, threads=1, progress=False)

        def stored() -> Folder:
            folder = next(folders)
            carry_on(folder, threads=1, stop=lambda: False, progress=False)
            return folder

        def check(done: StabilityMap | Folder) -> None:
            result = result_of(done, StabilityMap) if isinstance(done, Folder) else done
            counted(result.columns, result.samples.size * spec.samples)

        times = in_turns({"plain": unstored, "stored": stored}, check, repeats=repeats)
    plain, kept = (np.median(seconds) for seconds in times.values())
    more = over("stored over unstored", times["stored"], times["plain"]) - 1.0
    print(f"{name}: {plain:.3f} s, stored {kept:.3f} s: {more:+.1%}")


def append(log: Log, block: Block, count: int, repeats: int) -> None:
    """A record of so many rows."""
    size = log.path.stat().st_size

    def check(_: object) -> None:
        nonlocal size
        before, size = size, log.path.stat().st_size
        grown = f"growth of the log = {size - before} bytes: must hold {CALLS} x {count} rows"
        required(size - before >= CALLS * count * ROW.itemsize, grown)

    some = Block(block.rows[:count], block.nanoseconds[:count])
    (seconds,) = in_turns(
        {"append": partial(log.append, some)}, check, repeats=repeats, calls=CALLS
    ).values()
    print(f"append of {count} rows: {1e3 * np.median(seconds):.2f} ms")


def appends(spec: MapSpec, repeats: int) -> None:
    """Records of some sizes in one log."""
    block = compute(Head.of(spec), np.arange(APPENDS[-1]))
    assert block is not None
    with tempfile.TemporaryDirectory() as place:
        folder = Folder.at(Path(place, "run"), spec)
        folder.begin()
        assert folder._log is not None
        for count in APPENDS:
            append(folder._log, block, count, repeats)
        folder.end("interrupted")


def opening(spec: MapSpec) -> None:
    """A store of many units."""
    units = SIDE * SIDE
    with tempfile.TemporaryDirectory() as place:
        folder = Folder.at(Path(place, "run"), with_side(spec, SIDE))
        folder.begin()
        for begin in range(0, units, 8192):
            rows = np.zeros(min(8192, units - begin), ROW)
            rows["unit"] = np.arange(begin, begin + len(rows))
            folder.append(Block(rows, np.ones(len(rows), "<f4")))
        folder.end("complete")
        del folder

        def check(opened: Folder) -> None:
            known = int(opened.table.known.sum())
            required(known == units, f"units of the store = {known}: must be {units}")

        opened = {"opening": lambda: Folder(Path(place, "run"))}
        (seconds,) = in_turns(opened, check, repeats=3).values()
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(f"opening {units:,} units: {np.median(seconds):.2f} s, {memory:.0f} MB")


def main() -> None:
    options = parser(__doc__)
    options.add_argument("--repeats", type=int, default=sized(5, 1))
    repeats = options.parse_args().repeats
    spec = read_spec("thrown-box").spec
    spec = sized(spec, with_side(spec, 8))
    pixels = math.prod(spec.shape)
    overhead(f"closed form, {pixels} pixels of {spec.samples} bodies", spec, repeats)
    integrated = dataclasses.replace(spec, method="rk4", samples=8, step=sized(1e-3, 0.02))
    overhead(f"RK4, {pixels} pixels of 8 bodies", integrated, max(1, repeats // 2))
    appends(spec, repeats)
    opening(spec)


if __name__ == "__main__":
    main()
