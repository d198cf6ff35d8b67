"""How much dearer the method of a plan is than the best one, for tops of several spins.

Each method takes the longest steps with which no body errs by more than the accuracy; what counts
is the processor time of these steps, in turns. Also printed: the time of ``accuracy=`` over that of
the best steps, and over that of one unchecked run of ``taylor16`` by a tolerance of 0.03 times the
accuracy, which errs by more than the accuracy where the motion magnifies errors.

    python benches/chosen_methods.py
"""

from __future__ import annotations

import math
from functools import partial

import numpy as np
from timing import Floats, in_turns, moved, over, parser, required, sized

import rigid
from rigid import _core
from rigid.model.bodies import bodies_of

TOP = rigid.HeavyTop(rigid.Body((1.0, 1.6, 0.7)), mgl=1.2, com=(0.6, 0.0, 0.8))
SPINS = sized((1.0, 3.0, 7.0, 15.0, 40.0), (1.0, 40.0))
ACCURACIES = sized((1e-4, 1e-6, 1e-8), (1e-6,))
ANGLE = sized(60.0, 6.0)
"""Radians that the tops turn at most."""
BODIES = sized(512, 32)
LOOKED_AT = 32
"""So many tops, or a few more, are compared with the truth."""
WITHIN = 2.0
"""Methods whose steps would take so many times as long, by the time of a first run, are not timed
again."""


HEADS = ("spin", "accuracy", "chosen", "best", "over", "accuracy=", "over once")


def cloud(spin: float, bodies: int) -> Floats:
    """Rates of tops that spin about nearly the same axis."""
    about = np.array([0.5, 0.4, 2.5])
    about /= np.linalg.norm(about)
    found: Floats = spin * (about + 4e-4 * np.random.default_rng(7).normal(size=(bodies, 3)))
    return found


def largest_error(run: rigid.Run, truth: rigid.Run) -> float:
    """The largest error of the last states of some bodies, as a run states it."""
    states, true = (
        {"omega": of.omega, "gamma": of.gamma, "attitude": of.attitude} for of in (run, truth)
    )
    error = float(_core.distances(states, true).max())
    return error if math.isfinite(error) else math.inf


def longest_step(
    omega: Floats, end: float, method: str, accuracy: float, truth: rigid.Run
) -> float | None:
    """The longest step of a method with which no top errs more, None if there is none."""

    def good(steps: int) -> bool:
        run = rigid.simulate(
            TOP, omega, t=[end], method=method, step=end / steps * (1.0 + 1e-12), check=False
        )
        return largest_error(run, truth) <= accuracy

    least, most = 4, 4
    while not good(most):
        least, most = most, 2 * most
        if most > 2**15:
            return None
    while most - least > max(1, most // 100):
        middle = (least + most) // 2
        least, most = (least, middle) if good(middle) else (middle, most)
    return end / most * (1.0 + 1e-12)


def compared(omega: Floats, end: float, accuracy: float) -> tuple[str, str, float, float, float]:
    """The plan's method, the best one, the time of the one over that of the other; that asked for.

    The last two are the time of a call with ``accuracy=`` over that of the best steps, and over
    that of a run by a tolerance.
    """
    some = omega[:: max(len(omega) // LOOKED_AT, 1)]
    truth = rigid.simulate(TOP, some, t=[end], method="taylor26", check=False)
    call = partial(rigid.simulate, TOP, omega, t=[end], threads=1)
    calls, once = {}, {}
    for method in rigid.methods():
        if not method.tops or method.order < 4:
            continue
        step = longest_step(some, end, method.name, accuracy, truth)
        if step is not None:
            calls[method.name] = partial(call, method=method.name, step=step, check=False)
            once[method.name] = min(calls[method.name]().nanoseconds for _ in range(3))
    required(calls, f"error of every fixed step: must be below {accuracy:g} for one of them")
    chosen = call(accuracy=accuracy).plan.method
    required(chosen in calls, f"error of {chosen}: must be below {accuracy:g} with some step")
    shortest = min(once.values())
    near = [name for name, time in once.items() if time <= WITHIN * shortest or name == chosen]
    others = {
        "asked": partial(call, accuracy=accuracy),
        "once": partial(call, method="taylor16", tolerance=0.03 * accuracy, check=False),
    }
    times = in_turns(
        {name: calls[name] for name in near} | others,
        lambda run: moved(run.omega[:, -1], run.start_omega, run.steps),
        repeats=sized(5, 1),
    )
    best = min(near, key=lambda name: float(np.median(times[name])))
    return (
        chosen,
        best,
        over(f"time of {chosen} over that of {best}", times[chosen], times[best]),
        over("time of accuracy= over that of the best steps", times["asked"], times[best]),
        over("time of accuracy= over that of one run", times["asked"], times["once"]),
    )


def row(spin: float, accuracy: float) -> str:
    """A line of the table."""
    omega = cloud(spin, BODIES)
    rates = bodies_of(TOP, omega, None).fastest_rates((0.0, 0.0))
    found = compared(omega, ANGLE / float(np.median(rates)), accuracy)
    return "{:6g}{:10g}  {:10}  {:10}{:8.2f}{:10.2f}{:10.2f}".format(spin, accuracy, *found)


def main() -> None:
    parser(__doc__).parse_args()
    print("{:>6}{:>10}  {:10}  {:10}{:>8}{:>10}{:>10}".format(*HEADS))
    for spin in SPINS:
        for accuracy in ACCURACIES:
            print(row(spin, accuracy), flush=True)


if __name__ == "__main__":
    main()
