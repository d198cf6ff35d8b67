"""Time of a Poincaré section: 64 motions of an asymmetric top, 10 000 points each.

python benches/sections.py [--threads N]
"""

from __future__ import annotations

import argparse
import time

import rigid

TOP = rigid.HeavyTop(rigid.Body((1.0, 1.6, 0.7)), mgl=1.2, com=(0.6, 0.0, 0.8))
BODIES, POINTS = 64, 10_000
REPEATS = 5


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--threads", type=int, default=1)
    threads = parser.parse_args().threads
    omega, attitude = rigid.top.on_surface(TOP, 2.0, 0.4, BODIES, rng=2026)
    print(f"{rigid.build_info()['isa']}, {threads} thread(s); the least of {REPEATS} runs")
    print(f"{'tolerance':>10} {'checked':>8} {'wall s':>8} {'CPU s':>8} {'drift':>9} {'points':>8}")
    for tolerance, check in ((1e-12, False), (2.0**-57, False), (2.0**-57, True)):
        wall, cpu = [], []
        for _ in range(REPEATS):
            begin = time.perf_counter(), time.process_time()
            points = rigid.poincare(
                TOP,
                omega,
                attitude,
                t_end=1e9,
                count=POINTS,
                tolerance=tolerance,
                check=check,
                threads=threads,
            )
            wall.append(time.perf_counter() - begin[0])
            cpu.append(time.process_time() - begin[1])
        print(
            f"{tolerance:10.1e} {check!s:>8} {min(wall):8.2f} {min(cpu):8.2f} "
            f"{points.energy_drift.max():9.1e} {len(points):8}"
        )


if __name__ == "__main__":
    main()
