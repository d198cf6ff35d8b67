"""A hundred thousand maps, runs and closed forms in one process: neither memory nor threads grow.

    python tests/long/growth.py [--rounds 100000]

Fails if the memory grows by more than a megabyte after the first tenth, or if a thread is left.
"""

import argparse
import os
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "shared"))

import numpy as np

import rigid

MOST_GROWTH = 2**20

TOP = rigid.HeavyTop(rigid.Body((1.0, 1.6, 0.7)), mgl=1.2, com=(0.6, 0.0, 0.8))


def resident() -> int:
    """Resident memory of this process (bytes)."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGESIZE")


def threads() -> int:
    """Threads of this process, those of the core included."""
    return len(list(Path("/proc/self/task").iterdir()))


def once(number: int) -> None:
    """A map, a run, a closed form."""
    rigid.stability_map(
        rigid.FreeBody,
        axes={"I2/I1": [1.2, 1.5]},
        samples=4,
        t_end=1.0,
        stable=rigid.no_flip(),
        rng=number,
        threads=2,
        progress=False,
    )
    rigid.simulate(TOP, np.array([[0.4, 0.7, 2.0]] * 3), t=[0.5, 1.0], threads=2)
    rigid.exact.free_body(rigid.Body((1.0, 2.0, 3.0)), [0.1, 1.0, 0.1])


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=100_000)
    chosen = parser.parse_args()
    memory = running = 0
    for number in range(chosen.rounds):
        if number == chosen.rounds // 10:
            memory, running = resident(), threads()
        once(number)
    grown, left = resident() - memory, threads() - running
    print(f"{chosen.rounds} rounds: grown by {grown / 1024:.0f} kB, {left} threads left")
    return int(grown > MOST_GROWTH or left > 0)


if __name__ == "__main__":
    sys.exit(main())
