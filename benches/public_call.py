"""What a public call costs beside the work of its core, and beside numba and heyoka, in one table.

    pip install . numba heyoka && python benches/public_call.py [NAME ...]

Both sides of a ratio are timed in turn, on one thread, in processor time, and compared by medians.
Names select rows by their beginnings; a row that needs numba or heyoka is left out without it.
"""

from __future__ import annotations

import os

# Idle threads spin, and processor time counts them.
os.environ["OPENBLAS_NUM_THREADS"] = "1"
os.environ["NUMBA_NUM_THREADS"] = "1"

import math
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).parent / "peers"))

import rigid
from rigid.model.scene import Scene

FREE = rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0)))
WEIGHT = np.array([0.36, 0.24, 1.1])
MGL = float(np.linalg.norm(WEIGHT))
TOP = rigid.HeavyTop(rigid.Body((1.0, 1.6, 0.7)), mgl=MGL, com=WEIGHT / MGL)

Row = tuple[str, float, str, str]
"""A call, the number measured, its unit, and the number wanted."""


def in_turns(*sides: Callable[[], object], repeats: int = 7, calls: int = 1) -> list[float]:
    """Median seconds of processor time of each side; the sides take turns."""
    seconds: list[list[float]] = [[] for _ in sides]
    for side in sides:
        side()
    for _ in range(repeats):
        for side, times in zip(sides, seconds, strict=True):
            begin = time.thread_time_ns()
            for _ in range(calls):
                side()
            times.append((time.thread_time_ns() - begin) / calls * 1e-9)
    return [statistics.median(times) for times in seconds]


def rates(count: int) -> np.ndarray:
    return np.random.default_rng(1).normal(size=(count, 3))


def small_call() -> Iterator[Row]:
    (seconds,) = in_turns(
        lambda: rigid.simulate(FREE, [0.1, 1.0, 0.2], t=[1.0]), repeats=21, calls=200
    )
    yield "free body, 1 body x 1 time", seconds * 1e6, "µs", "<= 30"


def large_call() -> Iterator[Row]:
    omega = rates(100_000)
    shares = []
    for _ in range(15):
        begin = time.thread_time_ns()
        run = rigid.simulate(FREE, omega, t=[1.0], threads=1)
        shares.append((time.thread_time_ns() - begin) / run.nanoseconds)
    yield "free body, 1e5 x 1: call over core", statistics.median(shares), "", "<= 1.25"


PEAK = """
import resource, numpy as np, rigid
scene = rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0)))
omega = np.random.default_rng(1).normal(size=(10**6, 3))
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
    done = subprocess.run([sys.executable, "-c", PEAK], capture_output=True, text=True, check=True)
    yield "free body, 1e6 x 10: peak memory over result", float(done.stdout), "", "<= 1.1"


def own_inertia() -> Iterator[Row]:
    omega, t = rates(20_000), np.linspace(0.0, 10.0, 200)
    moments = 1.0 + np.random.default_rng(2).uniform(size=(len(omega), 3))
    try:
        scene = rigid.FreeBody(rigid.Body(moments))
    except ValueError:
        return  # bodies have one inertia in this version
    own, shared = in_turns(
        lambda: rigid.simulate(scene, omega, t=t, threads=1),
        lambda: rigid.simulate(FREE, omega, t=t, threads=1),
        repeats=5,
    )
    yield "2e4 bodies of their own inertia x 200 over one inertia", own / shared, "", "<= 1.2"


def stepper() -> Iterator[Row]:
    motion = rigid.Motion(FREE, [0.1, 1.0, 0.2])
    torques = [(0.0, 0.01 * i, 0.1) for i in range(-50, 50)]

    def steps() -> None:
        for torque in torques:
            motion.step(1e-3, torque)

    (seconds,) = in_turns(steps, repeats=21, calls=20)
    yield "Motion.step, one body, torque changing", seconds * 1e4, "µs", "<= 5"


def checked_accuracy() -> Iterator[Row]:
    omega = np.array([0.3, 0.1, 2.0]) + 1e-3 * rates(4096)
    truth = rigid.simulate(TOP, omega[:64], t=[20.0], method="taylor20", check=False)

    def error(method: str, step: float) -> float:
        run = rigid.simulate(TOP, omega[:64], t=[20.0], method=method, step=step, check=False)
        assert run.attitude is not None
        assert truth.attitude is not None
        apart = np.linalg.norm(run.attitude - truth.attitude, axis=-1)
        return float(2.0 * np.median(apart))

    best = []
    for method in rigid.methods():
        if not (method.tops and method.order >= 4):
            continue
        for steps in np.geomspace(20, 4000, 24):
            step = 20.0 / math.ceil(steps)
            if error(method.name, step) < 1e-6:
                best.append((method.name, step))
                break

    def fixed(method: str, step: float) -> Callable[[], object]:
        return lambda: rigid.simulate(
            TOP, omega, t=[20.0], method=method, step=step, check=False, threads=1
        )

    asked, *others = in_turns(
        lambda: rigid.simulate(TOP, omega, t=[20.0], accuracy=1e-6, threads=1),
        *(fixed(*choice) for choice in best),
        repeats=3,
    )
    yield "asymmetric top, accuracy=1e-6, over the best step", asked / min(others), "", "<= 1.8"


def map_check() -> Iterator[Row]:

    spec: dict[str, Any] = {
        "axes": {"mgl": np.linspace(0.05, 1.2, 8), "noise": np.geomspace(1e-4, 1e-2, 8)},
        "samples": 64,
        "t_end": 20.0,
        "start": rigid.Start(omega=(0.3, 0.1, 2.0), noise=rigid.normal(1e-3)),
        "stable": rigid.tilt_below(3.0),
        "rng": 1,
        "progress": False,
        "threads": 1,
    }
    best = rigid.plan(TOP, "rates", omega=[0.3, 0.1, 2.0], t_end=20.0, accuracy=1e-6)
    checked, bare = in_turns(
        lambda: rigid.stability_map(TOP, **spec),
        lambda: rigid.stability_map(TOP, **spec, method=best.method, step=best.step, check=0.0),
        repeats=3,
    )
    yield "integrated map with its check over bare integration", checked / bare, "", "<= 1.3"


def against_numba() -> Iterator[Row]:
    """Fixed steps of RK4, of the bodies of `peers`: a free body's rates, and a top's vertical."""
    try:
        import numba_side
    except ImportError:
        return
    import tops

    scene = tops.SCENES[0]
    omega, steps = scene.cloud(2048), 2000
    h = scene.t / steps
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

    free = rigid.FreeBody(rigid.Body(scene.moments))
    heavy = rigid.HeavyTop(rigid.Body(scene.moments), mgl=scene.mgl, com=scene.com)
    vertical = np.tile([[0.0], [0.0], [1.0]], len(omega))
    for words, ours, record, rates_of, start in (
        ("rates", free, "rates", euler, omega.T),
        ("top with vertical", heavy, "axis", top, np.concatenate([omega.T, vertical])),
    ):
        form = tops.Form(words, len(start), rates_of, lambda w, _: w.T, lambda y, _: (y[:3].T, y))
        theirs = numba_side.Numba(scene, form, "RK4", np.ascontiguousarray(start))
        theirs.take(len(omega))
        theirs.prepare(steps)

        def own(ours: Scene = ours, record: str = record) -> rigid.Run:
            return rigid.simulate(
                ours,
                omega,
                t=[scene.t],
                method="rk4",
                step=h * (1 + 1e-12),
                record=record,
                check=False,
                threads=1,
            )

        run = own()
        theirs.run(steps)
        # The same steps of the same equations, but for the order of operations.
        assert int(run.steps[0]) == steps
        assert np.abs(run.omega[:, -1] - theirs.states[:3].T).max() < 1e-6
        numba, rust = in_turns(lambda theirs=theirs: theirs.run(steps), own, repeats=9)
        yield f"RK4, {words}: numba in lanes over rigid", numba / rust, "", ">= 1"


DAYS = 3.0 * 86400.0


def against_heyoka() -> Iterator[Row]:
    try:
        import heyoka as hy
    except ImportError:
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

    own, theirs = in_turns(
        lambda: rigid.simulate(
            body, start, t=[DAYS], method="taylor16", tolerance=1e-12, check=False, threads=1
        ),
        propagate,
        repeats=5,
    )
    yield "one damped body, 3 days, taylor16, over heyoka", own / theirs, "", "<= 1.5"


ROWS: dict[str, Callable[[], Iterator[Row]]] = {
    "small": small_call,
    "large": large_call,
    "memory": memory,
    "inertia": own_inertia,
    "stepper": stepper,
    "accuracy": checked_accuracy,
    "map": map_check,
    "numba": against_numba,
    "heyoka": against_heyoka,
}


def main() -> None:
    asked = tuple(sys.argv[1:]) or tuple(ROWS)
    print(f"{'call':<56}{'measured':>10}      wanted")
    for name, measured in ROWS.items():
        if name.startswith(asked):
            for call, number, unit, wanted in measured():
                print(f"{call:<56}{number:>10.3g} {unit:<4} {wanted}", flush=True)


if __name__ == "__main__":
    main()
