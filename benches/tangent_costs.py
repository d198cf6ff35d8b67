"""Time of deviation vectors over that of the motion, by method.

    python benches/tangent_costs.py [--repeats N]

Of 512 tops in equal steps, one thread: a deviation vector with the motion, its growth, and a
derivative by a parameter, each over the motion alone. A ratio is the median of those of runs in
turns. Counted are multiply-adds of a step: 18 of a right-hand side and 27 of its tangent.
"""

from __future__ import annotations

from functools import partial

import numpy as np
from timing import Moved, in_turns, moved, over, parser, sized

import rigid
from rigid import _core
from rigid.model.bodies import Bodies
from rigid.model.forces import CHANGES
from rigid.solve.request import Request

BODIES, STEPS = sized((512, 1024), (512, 128))
COUNTED = {"rk4": 2.3, "dop853": 2.2, "taylor16": 2.8, "splitting": 1.6}
METHODS = ("rk4", "dop853", "taylor12", "taylor16", "splitting", "splitting4", "splitting8")


def run(what: str, method: str, moments: tuple[float, float, float]) -> Moved:
    """What a run of the core has made of what it had at the start, in so many steps."""
    rng = np.random.default_rng(14)
    omega, deviations = rng.normal(size=(BODIES, 3)), rng.normal(size=(BODIES, 6))
    step = 0.02 if method in ("rk4", "splitting") else 0.1
    bodies = Bodies(
        kind="top",
        shape=(BODIES,),
        moments=np.array([moments]),
        weight=np.array([[0.72, 0.0, 0.96]]),
        omega=omega,
        attitude=np.array([[1.0, 0.0, 0.0, 0.0]]),
    )
    longest = np.full(BODIES, step)
    steps = STEPS if method in ("rk4", "splitting") else STEPS // 8
    if what == "growth":
        done = _core.growth(
            bodies,
            method=method,
            step=longest,
            max_steps=10**9,
            threads=1,
            deviations=deviations,
            of_attitude=False,
            times=np.array([steps * step]),
        )
        return done["logs"][:, 0], 0.0, done["steps"]
    own, start, end = {
        "rates": ({}, omega, "omega"),
        "tangent": ({"deviations": deviations}, deviations, "tangent"),
        "sensitivity": (
            {"changes": rng.normal(size=(BODIES, CHANGES))},
            0.0,
            "tangent",
        ),
    }[what]
    done = Request(
        bodies=bodies,
        times=np.array([steps * step]),
        method=method,
        record=what,
        max_steps=10**9,
        threads=1,
        steps=longest,
    ).states(**own)
    return done[end][:, 0], start, done["steps"]


def main() -> None:
    options = parser(__doc__)
    options.add_argument("--repeats", type=int, default=sized(15, 1))
    repeats = options.parse_args().repeats
    print(f"{rigid.build_info()}\n")
    print("| method | deviation | counted | growth | by a parameter |\n|---|---|---|---|---|")
    kinds = [(method, (1.0, 1.6, 0.7)) for method in METHODS]
    kinds += [(method, (1.0, 1.0, 0.7)) for method in METHODS if method.startswith("splitting")]
    for method, moments in kinds:
        asked = ["rates", "tangent", "growth"]
        if not method.startswith("splitting"):
            asked.append("sensitivity")
        times = in_turns(
            {what: partial(run, what, method, moments) for what in asked},
            lambda found: moved(*found),
            repeats=repeats,
        )
        found = {what: f"{over(what, time, times['rates']):.2f}" for what, time in times.items()}
        name = f"`{method}`" + (", symmetric body" if moments[0] == moments[1] else "")
        counted = "" if "symmetric" in name else COUNTED.get(method, "")
        print(f"| {name} | {found['tangent']} | {counted} | {found['growth']} |"
              f" {found.get('sensitivity', '')} |")  # fmt: skip


if __name__ == "__main__":
    main()
