"""Speed of the built-in maps in closed form, in the core: random draws, verdicts and statistics.

    python benches/closed_form_maps.py

One thread, processor time, the median of twelve runs of each map.
"""

from __future__ import annotations

import math
from statistics import median
from time import thread_time

from rigid.cli.toml_map import read_spec
from rigid.maps.job import to_core

REPEATS = 12


def main() -> None:
    """Print the nanoseconds of a body of each map."""
    for name in ("thrown-box", "inertia-triangle", "sleeping-top"):
        spec = read_spec(name).spec
        job, bodies = to_core(spec), math.prod(spec.shape) * spec.samples
        seconds = []
        for _ in range(REPEATS):
            begin = thread_time()
            job.run(0, bodies, 1)
            seconds.append(thread_time() - begin)
        time = median(seconds) / bodies
        print(f"{name:18}{1e9 * time:7.1f} ns a body, {1e-6 / time:5.1f} million bodies a second")


if __name__ == "__main__":
    main()
