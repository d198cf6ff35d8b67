"""Time of a Poincaré section: 64 motions of an asymmetric top, 10 000 points each.

python benches/sections.py [--threads N]

The least processor time of five runs of one thread, or their least wall clock of more.
"""

from __future__ import annotations

import time
from functools import partial

from timing import in_turns, moved, parser, positive, required, sized

import rigid

TOP = rigid.HeavyTop(rigid.Body((1.0, 1.6, 0.7)), mgl=1.2, com=(0.6, 0.0, 0.8))
BODIES, POINTS, REPEATS = sized((64, 10_000, 5), (4, 50, 1))


def main() -> None:
    options = parser(__doc__)
    options.add_argument("--threads", type=int, default=1)
    threads = options.parse_args().threads
    clock = time.process_time if threads == 1 else time.perf_counter
    omega, attitude = rigid.top.on_surface(TOP, 2.0, 0.4, BODIES, rng=2026)
    common = {"t_end": 1e9, "count": POINTS, "threads": threads}
    drifts: list[float] = []

    def check(points: rigid.Crossings) -> None:
        whole = f"points of {BODIES} bodies = {len(points)}: must be {POINTS} each"
        required(len(points) == BODIES * POINTS, whole)
        moved(points.omega, omega[points.body], points.steps[points.body])
        drifts.append(positive("drift of the energy", points.energy_drift.max()))

    print(f"{rigid.build_info()['isa']}, {threads} thread(s); the least of {REPEATS} runs")
    print(f"{'tolerance':>10} {'checked':>8} {'seconds':>8} {'drift':>9} {'points':>8}")
    for tolerance, again in ((1e-12, False), (2.0**-57, False), (2.0**-57, True)):
        run = partial(rigid.poincare, TOP, omega, attitude, **common, tolerance=tolerance)
        (seconds,) = in_turns(
            {"section": partial(run, check=again)}, check, repeats=REPEATS, clock=clock
        ).values()
        print(
            f"{tolerance:10.1e} {again!s:>8} {seconds.min():8.2f} {drifts[-1]:9.1e} "
            f"{BODIES * POINTS:8}"
        )


if __name__ == "__main__":
    main()
