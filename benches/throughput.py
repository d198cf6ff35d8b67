"""Speed of the public calls, as ratios measured in one run.

    pip install '.[maps]' numba && python benches/throughput.py

Both sides of a ratio are timed in turn and compared by medians. One thread: processor time, because
machines are shared; two threads: wall-clock time of alternating runs.
"""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import time
from collections.abc import Callable
from typing import Any

# Idle BLAS threads spin, and processor time counts them.
os.environ["OPENBLAS_NUM_THREADS"] = "1"

import numpy as np
from timing import counted, in_turns, installed, moved, over, parser, positive, required, sized

import rigid

BODIES, STEPS = sized((4096, 1000), (64, 50))
STEP = 1e-3
REPEATS = sized(9, 1)
WEIGHT = np.array([0.36, 0.24, 1.1])
MGL = float(np.linalg.norm(WEIGHT))
TOP = rigid.HeavyTop(rigid.Body((1.0, 1.6, 0.7)), mgl=MGL, com=WEIGHT / MGL)


def starts(n: int) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(1)
    quaternions = rng.standard_normal((n, 4))
    return rng.standard_normal((n, 3)), quaternions / np.linalg.norm(quaternions, axis=1)[:, None]


def numba_rk4(numba: Any) -> Callable[[np.ndarray, np.ndarray, float, int], None]:
    """The usual compiled loop: one body at a time, scalar code, fast-math allowed."""

    @numba.njit(inline="always", fastmath=True)
    def rate(p, y, h, k):  # type: ignore[no-untyped-def]
        a, b, c = y[0] + h * k[0], y[1] + h * k[1], y[2] + h * k[2]
        u, v, w = y[3] + h * k[3], y[4] + h * k[4], y[5] + h * k[5]
        return (
            p[0] * b * c + p[3] * v - p[6] * w,
            p[1] * c * a + p[4] * w - p[7] * u,
            p[2] * a * b + p[5] * u - p[8] * v,
            v * c - w * b,
            w * a - u * c,
            u * b - v * a,
        )

    @numba.njit(fastmath=True)
    def advance(states, p, h, n):  # type: ignore[no-untyped-def]
        for i in range(states.shape[1]):
            y0, y1, y2 = states[0, i], states[1, i], states[2, i]
            y3, y4, y5 = states[3, i], states[4, i], states[5, i]
            for _ in range(n):
                y = (y0, y1, y2, y3, y4, y5)
                k1 = rate(p, y, 0.0, y)
                k2 = rate(p, y, 0.5 * h, k1)
                k3 = rate(p, y, 0.5 * h, k2)
                k4 = rate(p, y, h, k3)
                y0 += h / 6.0 * (k1[0] + 2.0 * (k2[0] + k3[0]) + k4[0])
                y1 += h / 6.0 * (k1[1] + 2.0 * (k2[1] + k3[1]) + k4[1])
                y2 += h / 6.0 * (k1[2] + 2.0 * (k2[2] + k3[2]) + k4[2])
                y3 += h / 6.0 * (k1[3] + 2.0 * (k2[3] + k3[3]) + k4[3])
                y4 += h / 6.0 * (k1[4] + 2.0 * (k2[4] + k3[4]) + k4[4])
                y5 += h / 6.0 * (k1[5] + 2.0 * (k2[5] + k3[5]) + k4[5])
            states[0, i], states[1, i], states[2, i] = y0, y1, y2
            states[3, i], states[4, i], states[5, i] = y3, y4, y5

    return advance


def against_numba() -> None:
    numba = installed("numba")
    if numba is None:
        return
    advance = numba_rk4(numba)
    omega, attitude = starts(BODIES)
    i1, i2, i3 = TOP.body.moments
    c1, c2, c3 = TOP.weight
    ratios = [(i2 - i3) / i1, (i3 - i1) / i2, (i1 - i2) / i3]
    p = np.array([*ratios, c3 / i1, c1 / i2, c2 / i3, c2 / i1, c3 / i2, c1 / i3])
    gamma = rigid.simulate(TOP, omega, attitude, t=[0.0], record="axis").gamma[:, 0]
    y = np.concatenate([omega.T, gamma.T])

    def numba_side() -> np.ndarray:
        state = y.copy()
        advance(state, p, STEP, STEPS)
        return state[:3].T

    def rigid_side() -> np.ndarray:
        return rigid.simulate(
            TOP, omega, attitude, t=[STEPS * STEP], step=STEP, record="axis", threads=1
        ).omega[:, 0]

    sides = {"numba": numba_side, "rigid": rigid_side}
    times = in_turns(sides, lambda end: moved(end, omega), repeats=REPEATS)
    error = np.abs(numba_side() - rigid_side()).max()
    required(error < 1e-6, f"distance of the states = {error:.0e}: must be below 1e-6")
    seconds = {name: np.median(turns) for name, turns in times.items()}
    work = BODIES * STEPS * 1e-6
    print(f"RK4 (omega, gamma), one core, same states to {error:.0e}:")
    print(f"  numba, one body at a time, fastmath {work / seconds['numba']:8.1f} M body-steps/s")
    print(f"  rigid.simulate                      {work / seconds['rigid']:8.1f} M body-steps/s")
    ratio = over("numba over rigid", times["numba"], times["rigid"])
    print(f"  ratio                               {ratio:8.2f}   (goal 8)")


def overhead_of_the_call() -> None:
    """Time of a call with n and with 2 n steps: what does not grow with the steps is overhead."""
    bodies, steps = sized((100_000, 1000), (2000, 500))
    omega, attitude = starts(bodies)

    def call(n: int) -> Callable[[], rigid.Run]:
        return lambda: rigid.simulate(
            TOP, omega, attitude, t=[n * STEP], step=STEP, record="axis", threads=1
        )

    times = in_turns(
        {"n": call(steps), "2n": call(2 * steps)},
        lambda run: moved(run.omega[:, 0], omega, run.steps),
        repeats=sized(9, 3),
    )
    once = float(np.median(times["n"]))
    kernel = positive(f"time of {steps} steps more", float(np.median(times["2n"])) - once)
    print(f"simulate on {bodies} bodies, {steps} steps: {once:.3f} s, kernel {kernel:.3f} s")
    print(f"  call / bare kernel                  {once / kernel:8.3f}   (goal 1.05)")


def two_threads() -> None:
    pixels, samples = sized((50, 200), (5, 20))
    bodies = pixels * pixels * samples

    def call(threads: int) -> Callable[[], rigid.StabilityMap]:
        return lambda: rigid.stability_map(
            rigid.FreeBody,
            axes={
                "I2/I1": np.linspace(1.05, 1.95, pixels),
                "noise": np.geomspace(1e-4, 0.1, pixels),
            },
            samples=samples,
            t_end=100.0,
            stable=rigid.no_flip(axis=2),
            start=rigid.Start(spin=1.0, axis=2, noise=rigid.normal(1e-3)),
            rng=1,
            threads=threads,
            progress=False,
        )

    times = in_turns(
        {"one": call(1), "two": call(2)},
        lambda result: counted(result.columns, bodies),
        repeats=REPEATS,
        clock=time.perf_counter,
    )
    ratio = over("2 threads over 1 thread", times["one"], times["two"])
    low, high, best = np.quantile(times["one"] / times["two"], [0.25, 0.75, 1.0])
    print(f"map of {bodies} bodies, wall clock:")
    print(
        f"  2 threads / 1 thread                {ratio:8.2f}   (goal 1.8; "
        f"quartiles {low:.2f}, {high:.2f}; best {best:.2f})"
    )


_MEMORY = """
import sys, numpy as np, rigid
samples = int(sys.argv[1])
result = rigid.stability_map(
    rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0))),
    axes={"spin": np.linspace(1.0, 2.0, 100), "noise": np.linspace(0.01, 0.1, 100)},
    samples=samples, t_end=0.5, stable=rigid.no_flip(axis=2), check=0.0,
    start=rigid.Start(spin=1.0, axis=2, noise=rigid.normal(0.1)), rng=1, progress=False)
assert result.samples.sum() == 10_000 * samples
# Not getrusage: its maximum is inherited from the parent.
print(next(line.split()[1] for line in open("/proc/self/status") if line.startswith("VmHWM")))
"""


def memory() -> None:
    def peak(samples: int) -> float:
        command = [sys.executable, "-c", _MEMORY, str(samples)]
        done = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True)
        return positive("peak memory", int(done.stdout) / 1024)

    few, many = sized((10, 10_000), (1, 10))
    small, large = peak(few), peak(many)
    print("peak memory of a map of 10 000 pixels:")
    print(
        f"  {few * 10**4:.0e} bodies {small:.0f} MB, {many * 10**4:.0e} bodies {large:.0f} MB: "
        f"{large - small:+.1f} MB (goal 50)"
    )


def main() -> None:
    parser(__doc__).parse_args()
    info = rigid.build_info()
    print({name: info[name] for name in ("version", "commit", "profile", "isa", "threads")})
    against_numba()
    overhead_of_the_call()
    two_threads()
    memory()
    usage = resource.getrusage(resource.RUSAGE_SELF)
    print(f"this run: {usage.ru_utime:.0f} s of processor time")


if __name__ == "__main__":
    main()
