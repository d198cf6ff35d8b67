"""Time under the torque of a function, over a loop by hand and over built-in damping.

The function is called for each body, or compiled from Python for eight. The loop by hand is of
numba: the same method in the same steps, rates and quaternion alone, with the torque inside.
Processor time on one thread, median of interleaved repeats.
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

BODIES, STEPS, SAMPLES, REPEATS = sized((64, 2000, 200, 5), (4, 20, 1, 1))
SATELLITES, HOURS = sized((400, 8.0), (2, 0.05))
STEP = 0.1
GAIN = 1e-3
MOMENTS = np.array([1.0, 1.5, 2.0])
BODY = rigid.Body(MOMENTS)
OMEGA = np.random.default_rng(1).normal(size=(BODIES, 3))
FASTEST = 2.5

CUBE = np.array([0.020, 0.025, 0.030])
"""Moments of a satellite of three litres (kg m²)."""
TUMBLING = np.random.default_rng(2).normal(size=(SATELLITES, 3)) * 0.1
"""Rates after the launch (rad/s)."""
FIELD, ORBIT, BRAKE = 3e-5, 1.1e-3, 1e4
"""Field above the magnetic equator (T), rate on a polar orbit (rad/s), and gain (A m² s/T)."""
WATCH = 4.0
"""Step of the satellites (s), in which they turn by half a radian at first."""


def damping(t: float, omega: Any, attitude: Any, data: Any, torque: Any) -> None:
    """The torque ``-data omega``."""
    for k in range(3):
        torque[k] = -data[0] * omega[k]


def b_dot(t: float, omega: Any, attitude: Any, data: Any, torque: Any) -> None:
    """The torque of coils that brake the change of the magnetic field, seen from the body."""
    field, turning, gain = data[0], data[1], data[2]
    u = turning * t
    s, c = np.sin(u), np.cos(u)
    bx, bz = -3.0 * field * s * c, field * (1.0 - 3.0 * s * s)
    ex, ez = -3.0 * field * turning * (c * c - s * s), -6.0 * field * turning * s * c
    w, x, y, z = attitude[0], attitude[1], attitude[2], attitude[3]
    xx, xy, xz = 1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)
    zx, zy, zz = 2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)
    b1, b2, b3 = xx * bx + zx * bz, xy * bx + zy * bz, xz * bx + zz * bz
    o1, o2, o3 = omega[0], omega[1], omega[2]
    m1 = -gain * (xx * ex + zx * ez + b2 * o3 - b3 * o2)
    m2 = -gain * (xy * ex + zy * ez + b3 * o1 - b1 * o3)
    m3 = -gain * (xz * ex + zz * ez + b1 * o2 - b2 * o1)
    torque[0] = m2 * b3 - m3 * b2
    torque[1] = m3 * b1 - m1 * b3
    torque[2] = m1 * b2 - m2 * b1


def compiled(numba: Any) -> Any:
    """The function by numba; by ctypes, and slow, without it."""
    if numba is None:
        doubles = ctypes.POINTER(ctypes.c_double)
        return ctypes.CFUNCTYPE(None, ctypes.c_double, *[doubles] * 4)(damping)
    doubles = numba.types.CPointer(numba.float64)
    return numba.cfunc(numba.void(numba.float64, *[doubles] * 4))(damping)


def rate(t: float, y: Any, moments: Any, data: Any, torque: Any, slope: Any) -> None:
    """The equations of motion under a torque."""
    a, b, c, w, x, y_, z = y
    slope[0] = ((moments[1] - moments[2]) * b * c + torque[0]) / moments[0]
    slope[1] = ((moments[2] - moments[0]) * c * a + torque[1]) / moments[1]
    slope[2] = ((moments[0] - moments[1]) * a * b + torque[2]) / moments[2]
    slope[3] = 0.5 * (-x * a - y_ * b - z * c)
    slope[4] = 0.5 * (w * a + y_ * c - z * b)
    slope[5] = 0.5 * (w * b + z * a - x * c)
    slope[6] = 0.5 * (w * c + x * b - y_ * a)


def by_hand(numba: Any, rows: Any, weights: Any, function: Any) -> Any:
    """A loop over bodies and steps of a Runge-Kutta method, until a body is slow."""
    jit = numba.njit(error_model="numpy")
    slope_of, torque_of = jit(rate), jit(function)
    stages, nodes = len(weights), rows.sum(axis=1)

    def loop(
        omega: Any, moments: Any, data: Any, step: float, steps: int, slow: float = 0.0
    ) -> Any:
        slopes, at, torque = np.empty((stages, 7)), np.empty(7), np.empty(3)
        states = np.zeros((len(omega), 7))
        states[:, :3], states[:, 3] = omega, 1.0
        for body in range(len(omega)):
            y = states[body]
            for made in range(steps):
                for i in range(stages):
                    at[:] = y
                    for j in range(i):
                        if rows[i, j] != 0.0:
                            for d in range(7):
                                at[d] += step * rows[i, j] * slopes[j, d]
                    t = (made + nodes[i]) * step
                    torque_of(t, at[:3], at[3:], data, torque)
                    slope_of(t, at, moments, data, torque, slopes[i])
                for i in range(stages):
                    for d in range(7):
                        y[d] += step * weights[i] * slopes[i, d]
                if y[0] * y[0] + y[1] * y[1] + y[2] * y[2] < slow * slow:
                    break
        return states

    return jit(loop)


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


def simulated(
    scene: Scene, method: str, omega: Any = OMEGA, step: float = STEP, steps: int = STEPS
) -> Any:
    """The rates at the end, by the public call."""
    run = rigid.simulate(
        scene, omega, t=[steps * step], method=method, step=step, check=False, threads=1
    )
    return run.omega[:, -1]


def stopped(scene: Scene, slow: float) -> Any:
    """The rates when the bodies become slow, or at the end."""
    run = rigid.simulate(
        scene,
        TUMBLING,
        t=[HOURS * 3600.0],
        until=rigid.crosses("speed", slow, -1),
        method="dop853",
        tolerance=1e-6,
        check=False,
        threads=1,
        progress=False,
    )
    ends, found = run.omega[:, -1], run.events[0]
    ends[found.body] = found.omega
    return ends


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
    built_in = rigid.FreeBody(BODY, damping=GAIN)
    scenes = {
        "called": rigid.FreeBody(BODY, torque=rigid.Torque.call(function, [GAIN])),
        "compiled": rigid.FreeBody(BODY, torque=rigid.Torque.call(damping, [GAIN])),
    }
    print("steps                      ns a step   over built-in   over numba by hand")
    for method, (rows, weights) in tables().items():
        sides: dict[str, Any] = {
            name: partial(simulated, scene, method)
            for name, scene in {**scenes, "built-in": built_in}.items()
        }
        if numba is not None:
            loop = by_hand(numba, rows, weights, damping)
            data = np.array([GAIN])
            sides["numba"] = lambda loop=loop, data=data: loop(OMEGA, MOMENTS, data, STEP, STEPS)[
                :, :3
            ]
        times = in_turns(sides, lambda ends: moved(ends, OMEGA), repeats=REPEATS)
        for side in scenes:
            each = 1e9 * float(np.median(times[side])) / (BODIES * STEPS)
            ratios = [over(name, times[side], times[name]) for name in list(sides)[2:]]
            columns = "".join(f"{ratio:16.2f}" for ratio in ratios)
            print(f"{method + ', ' + side:<26} {each:9.0f}{columns}")

    def by_function(function: Any, gain: Any) -> Scene:
        torque = rigid.Torque.call(function, gain[:, np.newaxis], fastest=FASTEST)
        return rigid.FreeBody(BODY, torque=torque)

    def by_damping(gain: Any) -> Scene:
        return rigid.FreeBody(BODY, damping=gain[:, np.newaxis] * np.ones(3))

    maps = {
        "called": partial(mapped, lambda gain: by_function(function, gain)),
        "compiled": partial(mapped, lambda gain: by_function(damping, gain)),
        "built-in": partial(mapped, by_damping),
    }
    times = in_turns(maps, lambda found: counted(found.columns, 6 * SAMPLES), repeats=REPEATS)
    for side in scenes:
        each = 1e6 * float(np.median(times[side])) / (6 * SAMPLES)
        ratio = over("map", times[side], times["built-in"])
        print(f"map, {side}: µs a body {each:.1f}, over that of built-in damping {ratio:.1f}")

    steps = round(HOURS * 3600.0 / WATCH)
    numbers = np.array([FIELD, ORBIT, BRAKE])
    cube = rigid.FreeBody(rigid.Body(CUBE), torque=rigid.Torque.call(b_dot, numbers))
    sides = {"rigid": partial(simulated, cube, "dop853", TUMBLING, WATCH, steps)}
    if numba is not None:
        loop = by_hand(numba, *tables()["dop853"], b_dot)
        sides["numba"] = lambda: loop(TUMBLING, CUBE, numbers, WATCH, steps)[:, :3]
    times = in_turns(sides, lambda ends: moved(ends, TUMBLING), repeats=REPEATS)
    each = 1e9 * float(np.median(times["rigid"])) / (SATELLITES * steps)
    line = f"{SATELLITES} detumblings in {HOURS:g} h, dop853: ns a step {each:.0f}"
    if numba is not None:
        line += f", over numba by hand {over('rigid', times['rigid'], times['numba']):.2f}"
    print(line)

    speeds = np.linalg.norm(TUMBLING, axis=1)
    slow = 0.3 * float(np.median(speeds))
    sides = {"rigid": partial(stopped, cube, slow)}
    if numba is not None:
        sides["numba"] = lambda: loop(TUMBLING, CUBE, numbers, WATCH, steps, slow)[:, :3]
    times = in_turns(sides, lambda ends: moved(ends, TUMBLING), repeats=REPEATS)
    each = 1e6 * float(np.median(times["rigid"])) / SATELLITES
    line = f"the same until their speed is {slow:.3f} rad/s, tolerance 1e-6: µs a body {each:.0f}"
    if numba is not None:
        line += f", over numba by hand {over('rigid', times['rigid'], times['numba']):.2f}"
    print(line)


if __name__ == "__main__":
    main()
