"""Speed of the built-in maps in closed form, in the core: random draws, verdicts and statistics.

    python benches/closed_form_maps.py

One thread, processor time, the median of twelve runs of each map.
"""

from __future__ import annotations

import numpy as np
from timing import counted, in_turns, parser, sized

from rigid.cli.toml_map import read_spec
from rigid.maps.job import to_core

REPEATS = sized(12, 1)


def seconds(name: str) -> float:
    """Processor time of a body of a map; there are none where the moments are impossible."""
    spec = read_spec(name).spec
    job = to_core(spec)
    pixels = len(job.status) // sized(1, 16)
    bodies = spec.samples * int(np.count_nonzero(job.status[:pixels] == 0))
    times = in_turns(
        {name: lambda: job.run(0, spec.samples * pixels, 1)},
        lambda columns: counted(columns, bodies),
        repeats=REPEATS,
    )
    return float(np.median(times[name])) / bodies


def main() -> None:
    """Print the nanoseconds of a body of each map."""
    parser(__doc__).parse_args()
    for name in ("thrown-box", "inertia-triangle", "sleeping-top"):
        time = seconds(name)
        print(f"{name:18}{1e9 * time:7.1f} ns a body, {1e-6 / time:5.1f} million bodies a second")


if __name__ == "__main__":
    main()
