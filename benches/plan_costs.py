"""How close the costs of plans are: processor times of random runs over those that plans promise.

A unit of work is measured again before each run, so that other programs disturb both alike.

    python benches/plan_costs.py [--runs 400] [--seed 11]
"""

from __future__ import annotations

import dataclasses
import sys
from collections import defaultdict
from pathlib import Path
from typing import Any

import numpy as np
from timing import moved, parser, positive, required, sized

import rigid
from rigid.solve.methods import EXACT
from rigid.solve.work import reference_nanoseconds

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "shared"))

from error_survey import random_scene

BODIES = sized({1: 25, 32: 5, 4096: 3}, {1: 3, 32: 2, 64: 2})
"""Numbers of bodies, and of runs of which the median counts: one body takes microseconds, and the
first runs more."""
WITHIN = 1.5


def measured_over_planned(rng: np.random.Generator) -> tuple[str, int, float] | None:
    """Method, number of bodies and ratio of a random run; None if the method is refused."""
    scene, omega, attitude = random_scene(rng)
    if rng.random() < 0.25:
        scene = dataclasses.replace(scene, damping=float(rng.choice([0.1, 1.0, 10.0])))
    bodies = int(rng.choice(list(BODIES)))
    swing = np.linalg.norm(scene.weight) / min(scene.body.moments)
    span = rng.uniform(2.0, 100.0) / (np.linalg.norm(omega) + np.sqrt(swing))
    states = int(rng.choice([1, 1, 10, 50])) if bodies < max(BODIES) else int(rng.choice([1, 10]))
    t = np.linspace(span / states, span, states)
    if rng.random() < 0.3:
        t = np.sort(rng.uniform(0.0, span, states))
    names = [None, *(method.name for method in rigid.methods())]
    options: dict[str, Any] = {"method": names[rng.integers(len(names))], "check": False}
    rows = omega * (1.0 + 0.3 * rng.normal(size=(bodies, 3))) if bodies > 1 else omega
    ratios = []
    try:
        for _ in range(BODIES[bodies]):
            unit = reference_nanoseconds()
            run = rigid.simulate(scene, rows, attitude, t=t, threads=1, **options)
            assert run.plan.work is not None
            ratios.append(run.nanoseconds / bodies / unit / run.plan.work)
    except ValueError:
        return None
    method = run.plan.method
    moved(np.reshape(run.omega, (bodies, len(t), 3))[:, -1], rows, run.steps + (method == EXACT))
    return method, bodies, positive(f"cost of {method} over that of its plan", np.median(ratios))


def main() -> None:
    options = parser(__doc__)
    options.add_argument("--runs", type=int, default=sized(400, 15))
    options.add_argument("--seed", type=int, default=11)
    chosen = options.parse_args()
    rng = np.random.default_rng(chosen.seed)
    ratios: dict[tuple[str, int], list[float]] = defaultdict(list)
    for _ in range(chosen.runs):
        found = measured_over_planned(rng)
        if found is not None:
            method, bodies, ratio = found
            ratios[method, bodies].append(ratio)
            ratios["all", bodies].append(ratio)
    required(ratios, f"runs = {chosen.runs}: must be enough for one that is not refused")
    print(f"{'method':12}{'bodies':>7}{'runs':>6}{'least':>7}{'median':>8}{'most':>7}  within 1.5")
    for (method, bodies), of_runs in sorted(ratios.items()):
        all_ = np.array(of_runs)
        within = np.mean((all_ < WITHIN) & (all_ > 1.0 / WITHIN))
        print(
            f"{method:12}{bodies:7}{len(all_):6}{all_.min():7.2f}{np.median(all_):8.2f}"
            f"{all_.max():7.2f}{within:12.1%}"
        )


if __name__ == "__main__":
    main()
