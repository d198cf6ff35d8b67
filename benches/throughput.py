"""Speed of the public calls, as ratios measured in one run.

    pip install '.[maps]' numba && python benches/throughput.py

Both sides of a ratio are timed in turn and compared by medians. One thread: thread CPU time, because
these machines are shared; two threads: wall-clock time of alternating runs.
"""

from __future__ import annotations

import resource
import statistics
import subprocess
import sys
import time
from collections.abc import Callable

import numpy as np

import rigid

BODIES, STEPS, STEP = 4096, 1000, 1e-3
WEIGHT = np.array([0.36, 0.24, 1.1])
MGL = float(np.linalg.norm(WEIGHT))
TOP = rigid.HeavyTop(rigid.Body((1.0, 1.6, 0.7)), mgl=MGL, com=WEIGHT / MGL)


def interleaved(
    sides: dict[str, Callable[[], object]], repeats: int, clock: Callable[[], float]
) -> dict[str, float]:
    """Median seconds of each side; the sides take turns."""
    seconds: dict[str, list[float]] = {name: [] for name in sides}
    for side in sides.values():
        side()
    for _ in range(repeats):
        for name, side in sides.items():
            begin = clock()
            side()
            seconds[name].append(clock() - begin)
    return {name: statistics.median(values) for name, values in seconds.items()}


def starts(n: int) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(1)
    quaternions = rng.standard_normal((n, 4))
    return rng.standard_normal((n, 3)), quaternions / np.linalg.norm(quaternions, axis=1)[:, None]


def numba_rk4() -> Callable[[np.ndarray, np.ndarray, float, int], None]:
    """The usual compiled loop: one body at a time, scalar code, fast-math allowed."""
    import numba

    @numba.njit(inline="always")
    def rate(p, a, b, c, u, v, w):  # type: ignore[no-untyped-def]
        return (
            p[0] * b * c + p[3] * v - p[6] * w,
            p[1] * c * a + p[4] * w - p[7] * u,
            p[2] * a * b + p[5] * u - p[8] * v,
            v * c - w * b,
            w * a - u * c,
            u * b - v * a,
        )

    @numba.njit(fastmath=True)
    def advance(y, p, h, n):  # type: ignore[no-untyped-def]
        g, s = 0.5 * h, h / 6.0
        for i in range(y.shape[1]):
            a, b, c, u, v, w = y[0, i], y[1, i], y[2, i], y[3, i], y[4, i], y[5, i]
            for _ in range(n):
                k = rate(p, a, b, c, u, v, w)
                l = rate(
                    p,
                    a + g * k[0],
                    b + g * k[1],
                    c + g * k[2],
                    u + g * k[3],
                    v + g * k[4],
                    w + g * k[5],
                )  # noqa: E501, E741
                m = rate(
                    p,
                    a + g * l[0],
                    b + g * l[1],
                    c + g * l[2],
                    u + g * l[3],
                    v + g * l[4],
                    w + g * l[5],
                )  # noqa: E501
                o = rate(
                    p,
                    a + h * m[0],
                    b + h * m[1],
                    c + h * m[2],
                    u + h * m[3],
                    v + h * m[4],
                    w + h * m[5],
                )  # noqa: E501
                a += s * (k[0] + 2 * (l[0] + m[0]) + o[0])
                b += s * (k[1] + 2 * (l[1] + m[1]) + o[1])
                c += s * (k[2] + 2 * (l[2] + m[2]) + o[2])
                u += s * (k[3] + 2 * (l[3] + m[3]) + o[3])
                v += s * (k[4] + 2 * (l[4] + m[4]) + o[4])
                w += s * (k[5] + 2 * (l[5] + m[5]) + o[5])
            y[0, i], y[1, i], y[2, i], y[3, i], y[4, i], y[5, i] = a, b, c, u, v, w

    return advance


def against_numba() -> None:
    advance = numba_rk4()
    omega, attitude = starts(BODIES)
    i1, i2, i3 = TOP.body.moments
    c1, c2, c3 = TOP.weight
    p = np.array([(i2 - i3) / i1, (i3 - i1) / i2, (i1 - i2) / i3]
                 + [c3 / i1, c1 / i2, c2 / i3, c2 / i1, c3 / i2, c1 / i3])  # fmt: skip
    gamma = rigid.simulate(TOP, omega, attitude, t=[0.0], record="axis").gamma[:, 0]
    y = np.concatenate([omega.T, gamma.T])
    state = y.copy()

    def numba_side() -> None:
        state[:] = y
        advance(state, p, STEP, STEPS)

    def rigid_side() -> rigid.Run:
        return rigid.simulate(
            TOP, omega, attitude, t=[STEPS * STEP], step=STEP, record="axis", threads=1
        )

    seconds = interleaved({"numba": numba_side, "rigid": rigid_side}, 9, time.process_time)
    error = np.abs(state[:3].T - rigid_side().omega[:, 0]).max()
    work = BODIES * STEPS * 1e-6
    print(f"RK4 (omega, gamma), one core, same states to {error:.0e}:")
    print(f"  numba, one body at a time, fastmath {work / seconds['numba']:8.1f} M body-steps/s")
    print(f"  rigid.simulate                      {work / seconds['rigid']:8.1f} M body-steps/s")
    print(
        f"  ratio                               {seconds['numba'] / seconds['rigid']:8.2f}   (goal 8)"
    )


def overhead_of_the_call() -> None:
    """Time of a call with n and with 2 n steps: what does not grow with the steps is overhead."""
    bodies, steps = 100_000, 1000
    omega, attitude = starts(bodies)

    def call(n: int) -> Callable[[], object]:
        return lambda: rigid.simulate(
            TOP, omega, attitude, t=[n * STEP], step=STEP, record="axis", threads=1
        )

    seconds = interleaved({"n": call(steps), "2n": call(2 * steps)}, 9, time.process_time)
    kernel = seconds["2n"] - seconds["n"]
    print(
        f"simulate on {bodies} bodies, {steps} steps: {seconds['n']:.3f} s, of it kernel {kernel:.3f} s"
    )
    print(f"  call / bare kernel                  {seconds['n'] / kernel:8.3f}   (goal 1.05)")


def two_threads() -> None:
    def call(threads: int) -> Callable[[], object]:
        return lambda: rigid.stability_map(
            rigid.FreeBody,
            axes={"I2/I1": np.linspace(1.05, 1.95, 50), "noise": np.geomspace(1e-4, 0.1, 50)},
            samples=200,
            t_end=100.0,
            stable=rigid.no_flip(axis=2),
            start=rigid.Start(spin=1.0, axis=2, noise=rigid.normal(1e-3)),
            rng=1,
            threads=threads,
            progress=False,
        )

    ratios = []
    one, two = call(1), call(2)
    for _ in range(9):
        begin = time.perf_counter()
        one()
        middle = time.perf_counter()
        two()
        ratios.append((middle - begin) / (time.perf_counter() - middle))
    quartiles = statistics.quantiles(ratios, n=4)
    print("map of 500 000 bodies, wall clock:")
    print(
        f"  2 threads / 1 thread                {statistics.median(ratios):8.2f}   (goal 1.8; "
        f"quartiles {quartiles[0]:.2f}, {quartiles[2]:.2f}; best {max(ratios):.2f})"
    )


_MEMORY = """
import sys, numpy as np, rigid
samples = int(sys.argv[1])
rigid.stability_map(
    rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0))),
    axes={"spin": np.linspace(1.0, 2.0, 100), "noise": np.linspace(0.01, 0.1, 100)},
    samples=samples, t_end=0.5, stable=rigid.no_flip(axis=2), check=0.0,
    start=rigid.Start(spin=1.0, axis=2, noise=rigid.normal(0.1)), rng=1, progress=False)
# Not getrusage: its maximum is inherited from the parent.
print(next(line.split()[1] for line in open("/proc/self/status") if line.startswith("VmHWM")))
"""


def memory() -> None:
    def peak(samples: int) -> float:
        command = [sys.executable, "-c", _MEMORY, str(samples)]
        return (
            int(subprocess.run(command, check=True, capture_output=True, text=True).stdout) / 1024
        )

    small, large = peak(10), peak(10_000)
    print("peak memory of a map of 10 000 pixels:")
    print(
        f"  1e5 bodies {small:.0f} MB, 1e8 bodies {large:.0f} MB: difference {large - small:.1f} MB (goal 50)"
    )


if __name__ == "__main__":
    info = rigid.build_info()
    print({name: info[name] for name in ("version", "commit", "profile", "isa", "threads")})
    against_numba()
    overhead_of_the_call()
    two_threads()
    memory()
    usage = resource.getrusage(resource.RUSAGE_SELF)
    print(f"this run: {usage.ru_utime:.0f} s of processor time")
