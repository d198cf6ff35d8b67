"""Time of displacements over that of the motion, by scheme.

    python benches/tangent_costs.py [--repeats N]

Of 512 tops in equal steps, one thread: a displacement with the motion, its growth, and a derivative
by a parameter, each over the motion alone. A ratio is the median of those of runs in turns. Counted
are multiply-adds of a step: 18 of a right-hand side and 27 of its tangent.
"""

from __future__ import annotations

import argparse
from statistics import median
from time import thread_time_ns

import numpy as np

import rigid
from rigid import _core

BODIES, STEPS = 512, 1024
COUNTED = {"rk4": 2.3, "dop853": 2.2, "taylor16": 2.8, "splitting": 1.6}
METHODS = ("rk4", "dop853", "taylor12", "taylor16", "splitting", "splitting4", "splitting8")


def timed(what: str, method: str, moments: tuple[float, float, float]) -> float:
    """Processor time of a run (ns)."""
    rng = np.random.default_rng(14)
    step = 0.02 if method in ("rk4", "splitting") else 0.1
    every = {
        "scene": "top",
        "method": method,
        "moments": np.array([moments]),
        "weight": np.array([[0.72, 0.0, 0.96]]),
        "omega": rng.normal(size=(BODIES, 3)),
        "attitude": np.array([[1.0, 0.0, 0.0, 0.0]]),
        "step": np.full(BODIES, step),
        "max_steps": 10**9,
        "threads": 1,
    }
    steps = STEPS if method in ("rk4", "splitting") else STEPS // 8
    begin = thread_time_ns()
    if what == "growth":
        _core.growth(
            **every,
            displacements=rng.normal(size=(BODIES, 6)),
            scale=np.ones(BODIES),
            of_attitude=False,
            times=np.array([steps * step]),
        )
        return float(thread_time_ns() - begin)
    own = {
        "rates": {},
        "tangent": {"displacements": rng.normal(size=(BODIES, 6))},
        "sensitivity": {"changes": rng.normal(size=(BODIES, 15))},
    }[what]
    _core.simulate(**every, **own, record=what, times=np.array([[steps * step]]))
    return float(thread_time_ns() - begin)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeats", type=int, default=15)
    repeats = parser.parse_args().repeats
    print(f"{rigid.build_info()}\n")
    print("| scheme | displacement | counted | growth | by a parameter |\n|---|---|---|---|---|")
    kinds = [(method, (1.0, 1.6, 0.7)) for method in METHODS]
    kinds += [(method, (1.0, 1.0, 0.7)) for method in METHODS if method.startswith("splitting")]
    for method, moments in kinds:
        asked = ["rates", "tangent", "growth"]
        if not method.startswith("splitting"):
            asked.append("sensitivity")
        ratios: dict[str, list[float]] = {what: [] for what in asked}
        for _ in range(repeats):
            times = {what: timed(what, method, moments) for what in asked}
            for what in asked:
                ratios[what].append(times[what] / times["rates"])
        found = {what: f"{median(values):.2f}" for what, values in ratios.items()}
        name = f"`{method}`" + (", symmetric body" if moments[0] == moments[1] else "")
        counted = "" if "symmetric" in name else COUNTED.get(method, "")
        print(f"| {name} | {found['tangent']} | {counted} | {found['growth']} |"
              f" {found.get('sensitivity', '')} |")  # fmt: skip


if __name__ == "__main__":
    main()
