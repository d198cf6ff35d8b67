"""What a public call costs beside the work of its core, and beside numba and heyoka, in one table.

    pip install . numba heyoka && python benches/public_call.py [NAME ...]

Both sides of a ratio are timed in turn, on one thread, in processor time, and compared by medians.
Names select rows by their beginnings; a row that needs numba or heyoka is omitted without it.
"""

from __future__ import annotations

import os

# Idle threads spin, and processor time counts them.
os.environ["OPENBLAS_NUM_THREADS"] = "1"
os.environ["NUMBA_NUM_THREADS"] = "1"

import dataclasses
import subprocess
import sys
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from timing import (
    Moved,
    counted,
    in_turns,
    installed,
    moved,
    over,
    parser,
    positive,
    required,
    share,
    sized,
)

sys.path.insert(0, str(Path(__file__).parent / "peers"))

import chosen_methods

import rigid
from rigid.exact import FreeMotion
from rigid.model.scene import Scene

FREE = rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0)))
WEIGHT = np.array([0.36, 0.24, 1.1])
MGL = float(np.linalg.norm(WEIGHT))
TOP = rigid.HeavyTop(rigid.Body((1.0, 1.6, 0.7)), mgl=MGL, com=WEIGHT / MGL)

Row = tuple[str, float, str, str]
"""A call, the number measured, its unit, and the number wanted."""


def ran(run: rigid.Run) -> None:
    """Every body has moved: by steps, unless in closed form."""
    omega = run.omega.reshape(-1, len(run.t), 3)
    moved(omega[:, -1], run.start_omega, run.steps + (run.plan.method == "exact"))


def rates(count: int) -> np.ndarray:
    return np.random.default_rng(1).normal(size=(count, 3))


def answered(found: object) -> None:
    """A call of one body has given an answer."""
    if isinstance(found, rigid.Run):
        ran(found)
    elif isinstance(found, rigid.Plan):
        positive("error of the plan", found.error or 0.0)
    elif isinstance(found, FreeMotion):
        positive("period", float(found.period))
    else:
        required(np.isfinite(np.asarray(found)).all(), f"answer = {found}: must be finite")


def small_calls() -> Iterator[Row]:
    numbers = [0.1, 1.0, 0.2]
    sides: dict[str, Callable[[], object]] = {
        "asarray": partial(np.asarray, numbers),
        "simulate, 1 time": partial(rigid.simulate, FREE, numbers, t=[1.0]),
        "exact.flip_times": partial(rigid.exact.flip_times, FREE, numbers),
        "exact.free_body": partial(rigid.exact.free_body, FREE, numbers),
        "plan": partial(rigid.plan, FREE, omega=numbers, t_end=1.0),
    }
    times = in_turns(sides, answered, repeats=sized(21, 1), calls=sized(1000, 100))
    for call in list(sides)[1:]:
        row = f"free body, 1 body: {call}"
        yield row, float(np.median(times[call])) * 1e6, "µs", ""
        row = f"{row} over np.asarray of 3 numbers"
        yield row, over(row, times[call], times["asarray"]), "", "<= 45"


def large_call() -> Iterator[Row]:
    omega, cores = rates(sized(100_000, 5000)), []

    def check(run: rigid.Run) -> None:
        ran(run)
        cores.append(run.nanoseconds * 1e-9)

    call = partial(rigid.simulate, FREE, omega, t=[1.0], threads=1)
    (seconds,) = in_turns({"call": call}, check, repeats=sized(15, 1)).values()
    core = share("core of a call", float(np.median(cores / seconds)))
    yield "free body, 1e5 x 1: call over core", 1.0 / core, "", "<= 1.25"


PEAK = """
import resource, sys, numpy as np, rigid
scene = rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0)))
omega = np.random.default_rng(1).normal(size=(int(sys.argv[1]), 3))
t = np.linspace(0.0, 10.0, 10)
rigid.simulate(scene, omega[:100], t=t)
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
run = rigid.simulate(scene, omega, t=t, threads=1)
after = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
names = ("omega", "attitude", "energy_drift", "momentum_drift", "unit_drift", "status", "steps",
         "error", "lost_from")
print((after - before) * 1024 / sum(getattr(run, name).nbytes for name in names))
"""


def memory() -> Iterator[Row]:
    command = [sys.executable, "-c", PEAK, str(sized(10**6, 10**5))]
    done = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True)
    yield "free body, 1e6 x 10: peak memory over result", float(done.stdout), "", "<= 1.1"


def own_inertia() -> Iterator[Row]:
    omega = rates(sized(20_000, 100))
    moments = 1.0 + np.random.default_rng(2).uniform(size=(len(omega), 3))
    scenes = {"own": rigid.FreeBody(rigid.Body(moments)), "one": FREE}
    for count in (50, 200):
        t = np.linspace(0.0, 10.0, count)
        call = partial(rigid.simulate, omega=omega, t=t, threads=1)
        sides = {of: partial(call, scene) for of, scene in scenes.items()}
        times = in_turns(sides, ran, repeats=sized(5, 1))
        row = f"2e4 bodies of their own inertia x {count} over one inertia"
        yield row, over(row, times["own"], times["one"]), "", "<= 1.2"


def stepper() -> Iterator[Row]:
    motion = rigid.Motion(FREE, [0.1, 1.0, 0.2])
    torques = [(0.0, 0.01 * i, 0.1) for i in range(-50, 50)]

    def steps() -> Moved:
        start = np.array(motion.omega)
        for torque in torques:
            motion.step(1e-3, torque)
        return motion.omega, start

    (seconds,) = in_turns(
        {"steps": steps}, lambda found: moved(*found), repeats=sized(21, 1), calls=sized(20, 2)
    ).values()
    yield "Motion.step, one body, torque changing", float(np.median(seconds)) * 1e4, "µs", "<= 5"


def frames() -> Iterator[Row]:
    omega = rates(sized(2000, 20))
    moments = 1.0 + np.random.default_rng(2).uniform(size=omega.shape)
    for words, some in (("all", slice(None)), ("one", slice(1))):
        motion = rigid.Motion(rigid.Body(moments), omega, threads=1)

        def frame(motion: rigid.Motion = motion, some: slice = some) -> Moved:
            start = motion.omega
            turned = start.copy()
            turned[some] *= -1.0
            motion.omega = turned
            motion.step(1 / 64)
            return motion.omega, start

        (seconds,) = in_turns(
            {"frame": frame}, lambda found: moved(*found), repeats=sized(21, 1), calls=sized(20, 2)
        ).values()
        row = f"Motion of 2000 different bodies: rates of {words} set, and a step"
        yield row, float(np.median(seconds)) * 1e3, "ms", "<= 1"


def checked_accuracy() -> Iterator[Row]:
    omega = chosen_methods.cloud(2.6, sized(4096, 64))
    asked = chosen_methods.compared(omega, sized(20.0, 2.0), 1e-6)[-1]
    yield "asymmetric top, accuracy=1e-6, over the best step", asked, "", "<= 2.7"


def map_check() -> Iterator[Row]:
    pixels, samples = sized((8, 64), (2, 16))
    spec: dict[str, Any] = {
        "axes": {"mgl": np.linspace(0.05, 1.2, pixels), "noise": np.geomspace(1e-4, 1e-2, pixels)},
        "samples": samples,
        "t_end": 20.0,
        "start": rigid.Start(omega=(0.3, 0.1, 2.0), noise=rigid.normal(1e-3)),
        "stable": rigid.tilt_below(3.0),
        "rng": 1,
        "progress": False,
        "threads": 1,
    }
    best = rigid.plan(TOP, "rates", omega=[0.3, 0.1, 2.0], t_end=20.0, accuracy=1e-6)
    call = partial(rigid.stability_map, TOP, **spec)
    times = in_turns(
        {"checked": call, "bare": partial(call, method=best.method, step=best.step, check=0.0)},
        lambda result: counted(result.columns, pixels * pixels * samples),
        repeats=sized(3, 1),
    )
    row = "integrated map with its check over bare integration"
    yield row, over(row, times["checked"], times["bare"]), "", "<= 1.3"


def against_numba() -> Iterator[Row]:
    """Fixed steps of RK4, of the bodies of `peers`: a free body's rates, and a top's vertical."""
    import numba_side
    import tops

    if numba_side.numba is None:
        return
    bodies, steps, t = sized((2048, 2000, 50.0), (16, 400, 10.0))
    scene = dataclasses.replace(tops.SCENES[0], t=t)
    omega = scene.cloud(bodies)
    (a, b, c), (x1, x2, x3) = scene.moments, scene.weight

    def euler(u, v, w):  # type: ignore[no-untyped-def]
        return ((b - c) / a) * (v * w), ((c - a) / b) * (w * u), ((a - b) / c) * (u * v)

    def top(u, v, w, x, y, z):  # type: ignore[no-untyped-def]
        return (
            ((b - c) / a) * (v * w) + (x3 / a) * y - (x2 / a) * z,
            ((c - a) / b) * (w * u) + (x1 / b) * z - (x3 / b) * x,
            ((a - b) / c) * (u * v) + (x2 / c) * x - (x1 / c) * y,
            y * w - z * v,
            z * u - x * w,
            x * v - y * u,
        )

    def row(words: str, ours: Scene, record: str, rates_of: Any, start: np.ndarray) -> Row:
        form = tops.Form(words, len(start), rates_of, lambda w, _: w.T, lambda y, _: (y[:3].T, y))
        theirs = numba_side.Numba(scene, form, "RK4", np.ascontiguousarray(start))
        theirs.take(bodies)
        theirs.prepare(steps)
        own = partial(rigid.simulate, ours, omega, t=[scene.t], method="rk4", record=record)
        own = partial(own, step=scene.t / steps * (1 + 1e-12), check=False, threads=1)

        def check(run: rigid.Run | None) -> None:
            ran(run) if run else moved(theirs.states[:3].T, omega)

        sides = {"numba": partial(theirs.run, steps), "rigid": own}
        times = in_turns(sides, check, repeats=sized(9, 1))
        # The same steps of the same equations, but for the order of operations.
        run = own()
        apart = float(np.abs(run.omega[:, -1] - theirs.states[:3].T).max())
        required(apart < 1e-6, f"distance of the states = {apart:.1e}: must be below 1e-6")
        required(run.steps[0] == steps, f"steps of rigid = {run.steps[0]}: must be {steps}")
        name = f"RK4, {words}: numba in lanes over rigid"
        return name, over(name, times["numba"], times["rigid"]), "", ">= 1"

    free = rigid.FreeBody(rigid.Body(scene.moments))
    heavy = rigid.HeavyTop(rigid.Body(scene.moments), mgl=scene.mgl, com=scene.com)
    vertical = np.tile([[0.0], [0.0], [1.0]], bodies)
    yield row("rates", free, "rates", euler, omega.T)
    yield row("top with vertical", heavy, "axis", top, np.concatenate([omega.T, vertical]))


DAYS = sized(3.0, 0.01) * 86400.0


def against_heyoka() -> Iterator[Row]:
    hy = installed("heyoka")
    if hy is None:
        return
    moments, damping = (1.0, 1.6, 2.1), 1e-6
    body = rigid.FreeBody(rigid.Body(moments), damping=damping)
    start = [0.02, 0.1, 0.03]
    names = hy.make_vars("u", "v", "w", "p", "q", "r", "s")
    u, v, w, p, q, r, s = names
    a, b, c = moments
    equations = [
        (b - c) / a * v * w - damping / a * u,
        (c - a) / b * w * u - damping / b * v,
        (a - b) / c * u * v - damping / c * w,
        -0.5 * (q * u + r * v + s * w),
        0.5 * (p * u + r * w - s * v),
        0.5 * (p * v + s * u - q * w),
        0.5 * (p * w + q * v - r * u),
    ]
    begin = [*start, 1.0, 0.0, 0.0, 0.0]
    integrator = hy.taylor_adaptive(list(zip(names, equations, strict=True)), begin, tol=1e-12)

    def propagate() -> None:
        integrator.time = 0.0
        integrator.state[:] = begin
        integrator.propagate_until(DAYS)

    def check(run: rigid.Run | None) -> None:
        ran(run) if run else moved(integrator.state, begin)

    own = partial(rigid.simulate, body, start, t=[DAYS], method="taylor16", tolerance=1e-12)
    sides = {"rigid": partial(own, check=False, threads=1), "heyoka": propagate}
    times = in_turns(sides, check, repeats=sized(5, 1))
    row = "one damped body, 3 days, taylor16, over heyoka"
    yield row, over(row, times["rigid"], times["heyoka"]), "", "<= 1.5"


ROWS: dict[str, Callable[[], Iterator[Row]]] = {
    "small": small_calls,
    "large": large_call,
    "memory": memory,
    "inertia": own_inertia,
    "stepper": stepper,
    "frames": frames,
    "accuracy": checked_accuracy,
    "map": map_check,
    "numba": against_numba,
    "heyoka": against_heyoka,
}


def main() -> None:
    options = parser(__doc__)
    options.add_argument("rows", nargs="*", help="beginnings of " + ", ".join(ROWS))
    asked = tuple(options.parse_args().rows) or tuple(ROWS)
    print(f"{'call':<68}{'measured':>10}      wanted")
    for name, measured in ROWS.items():
        if name.startswith(asked):
            for call, number, unit, wanted in measured():
                positive(call, number)
                print(f"{call:<68}{number:>10.3g} {unit:<4} {wanted}", flush=True)


if __name__ == "__main__":
    main()
