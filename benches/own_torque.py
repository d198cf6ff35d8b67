"""Time under the torque of a compiled function, over a loop by hand and over built-in damping.

The loop by hand is of numba: the same method in the same steps, rates and quaternion alone, with
the torque inside. Processor time on one thread, median of interleaved repeats.
``pip install numba && python benches/own_torque.py``.
"""

from __future__ import annotations

import ctypes
from functools import partial
from typing import Any

import numpy as np
from timing import counted, in_turns, installed, moved, over, parser, sized

import rigid
from rigid.model.scene import Scene

BODIES, STEPS, SAMPLES, REPEATS = sized((64, 2000, 200, 5), (4, 40, 4, 1))
STEP = 0.1
GAIN = 1e-3
MOMENTS = np.array([1.0, 1.5, 2.0])
BODY = rigid.Body(MOMENTS)
OMEGA = np.random.default_rng(1).normal(size=(BODIES, 3))
FASTEST = 2.5


def damping(t: float, omega: Any, attitude: Any, data: Any, torque: Any) -> None:
    """The torque ``-data omega``."""
    for k in range(3):
        torque[k] = -data[0] * omega[k]


def compiled(numba: Any) -> Any:
    """The function by numba; by ctypes, and slow, without it."""
    if numba is None:
        doubles = ctypes.POINTER(ctypes.c_double)
        return ctypes.CFUNCTYPE(None, ctypes.c_double, *[doubles] * 4)(damping)
    doubles = numba.types.CPointer(numba.float64)
    return numba.cfunc(numba.void(numba.float64, *[doubles] * 4))(damping)


def rate(y: Any, moments: Any, gain: float, slope: Any) -> None:
    """The equations of motion, damping among them."""
    a, b, c, w, x, y_, z = y
    slope[0] = ((moments[1] - moments[2]) * b * c - gain * a) / moments[0]
    slope[1] = ((moments[2] - moments[0]) * c * a - gain * b) / moments[1]
    slope[2] = ((moments[0] - moments[1]) * a * b - gain * c) / moments[2]
    slope[3] = 0.5 * (-x * a - y_ * b - z * c)
    slope[4] = 0.5 * (w * a + y_ * c - z * b)
    slope[5] = 0.5 * (w * b + z * a - x * c)
    slope[6] = 0.5 * (w * c + x * b - y_ * a)


def by_hand(numba: Any, rows: Any, weights: Any) -> Any:
    """A loop over bodies and steps of a Runge-Kutta method."""
    slope_of = numba.njit(error_model="numpy")(rate)
    stages = len(weights)

    def loop(omega: Any, moments: Any, gain: float, step: float, steps: int) -> Any:
        slopes, at = np.empty((stages, 7)), np.empty(7)
        states = np.zeros((len(omega), 7))
        states[:, :3], states[:, 3] = omega, 1.0
        for body in range(len(omega)):
            y = states[body]
            for _ in range(steps):
                for i in range(stages):
                    at[:] = y
                    for j in range(i):
                        if rows[i, j] != 0.0:
                            for d in range(7):
                                at[d] += step * rows[i, j] * slopes[j, d]
                    slope_of(at, moments, gain, slopes[i])
                for i in range(stages):
                    for d in range(7):
                        y[d] += step * weights[i] * slopes[i, d]
        return states

    return numba.njit(error_model="numpy")(loop)


def tables() -> dict[str, tuple[Any, Any]]:
    """The matrices and weights of the methods."""
    from scipy.integrate._ivp import dop853_coefficients as dop853

    rows = np.zeros((4, 4))
    rows[1, 0] = rows[2, 1] = 0.5
    rows[3, 2] = 1.0
    return {
        "rk4": (rows, np.array([1.0, 2.0, 2.0, 1.0]) / 6.0),
        "dop853": (np.ascontiguousarray(dop853.A[:12, :12]), dop853.B[:12].copy()),
    }


def simulated(scene: Scene, method: str) -> Any:
    """The rates at the end, by the public call."""
    run = rigid.simulate(
        scene, OMEGA, t=[STEPS * STEP], method=method, step=STEP, check=False, threads=1
    )
    return run.omega[:, -1]


def mapped(scene: Any) -> rigid.StabilityMap:
    """A map of bodies that become slow."""
    return rigid.stability_map(
        scene,
        axes={"gain": [0.05, 0.1], "spin": [0.5, 1.0, 1.5]},
        start=rigid.Start(spin=1.0, axis=3, noise=rigid.normal(0.1)),
        stable=~rigid.spin_above(0.2),
        t_end=30.0,
        samples=SAMPLES,
        rng=3,
        threads=1,
        progress=False,
    )


def main() -> None:
    """Print the table."""
    parser(__doc__).parse_args()
    numba = installed("numba")
    function = compiled(numba)
    called = rigid.FreeBody(BODY, torque=rigid.Torque.call(function, [GAIN]))
    built_in = rigid.FreeBody(BODY, damping=GAIN)
    print("steps                      ns a step   over built-in   over numba by hand")
    for method, (rows, weights) in tables().items():
        sides: dict[str, Any] = {
            "called": partial(simulated, called, method),
            "built-in": partial(simulated, built_in, method),
        }
        if numba is not None:
            loop = by_hand(numba, rows, weights)
            sides["numba"] = lambda loop=loop: loop(OMEGA, MOMENTS, GAIN, STEP, STEPS)[:, :3]
        times = in_turns(sides, lambda ends: moved(ends, OMEGA), repeats=REPEATS)
        each = 1e9 * float(np.median(times["called"])) / (BODIES * STEPS)
        ratios = [over(name, times["called"], times[name]) for name in list(sides)[1:]]
        print(f"{method:<26} {each:9.0f}" + "".join(f"{ratio:16.2f}" for ratio in ratios))

    def by_function(gain: Any) -> Scene:
        torque = rigid.Torque.call(function, gain[:, np.newaxis], fastest=FASTEST)
        return rigid.FreeBody(BODY, torque=torque)

    def by_damping(gain: Any) -> Scene:
        return rigid.FreeBody(BODY, damping=gain[:, np.newaxis] * np.ones(3))

    pair = {"called": partial(mapped, by_function), "built-in": partial(mapped, by_damping)}
    times = in_turns(pair, lambda found: counted(found.columns, 6 * SAMPLES), repeats=REPEATS)
    each = 1e6 * float(np.median(times["called"])) / (6 * SAMPLES)
    ratio = over("map", times["called"], times["built-in"])
    print(f"map, µs a body: {each:.1f}; over that of built-in damping: {ratio:.1f}")


if __name__ == "__main__":
    main()
