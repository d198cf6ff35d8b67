"""Growth of a displacement on a 64 x 64 grid, against numba: processor time of one thread.

    pip install numba && python benches/regular_map.py

The asymmetric top of the map ``chaotic-top`` until T = 200, with one displacement. numba: what an
expert writes, DOP853 in lanes with a fixed step for all bodies, the table as literals, fast math;
the displacement is integrated only. rigid: the same with a step for each body, and exponent, MEGNO,
its mean and FLI. Each takes the fewest steps for which the largest drift of the energy of all
bodies is below the target. Medians of interleaved repeats.
"""

from __future__ import annotations

import statistics
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import rigid
from rigid import _core

sys.path.insert(0, str(Path(__file__).parent / "peers"))
from numba_side import DOP853, written
from tops import Form

Floats = NDArray[np.float64]

MOMENTS = np.array([1.0, 1.6, 0.7])
COM = np.array([0.3, 0.2, 0.93]) / np.linalg.norm([0.3, 0.2, 0.93])
MGL, T, TARGETS, REPEATS = 1.2, 200.0, (1e-6, 1e-10), 9
METHODS = ("dop853", "taylor12")
TOP = rigid.HeavyTop(rigid.Body(tuple(MOMENTS)), mgl=MGL, com=COM)
TILT, SPIN = np.meshgrid(np.linspace(0.05, 3.09, 64), np.linspace(0.0, 8.0, 64))


def starts() -> tuple[Floats, Floats, Floats]:
    """Rates, vertical and attitude of the 4096 bodies."""
    tilt, spin = TILT.ravel(), SPIN.ravel()
    zero = np.zeros(tilt.size)
    omega = np.stack([zero, zero, spin], axis=1)
    vertical = np.stack([zero, np.sin(tilt), np.cos(tilt)], axis=1)
    attitude = np.stack([np.cos(0.5 * tilt), np.sin(0.5 * tilt), zero, zero], axis=1)
    return omega, vertical, attitude


def columns() -> dict[str, Floats]:
    """Moments, weight, rates and attitude of the bodies."""
    omega, _, attitude = starts()
    moments, weight = (np.tile(row, (len(omega), 1)) for row in (MOMENTS, MGL * COM))
    return {"moments": moments, "weight": weight, "omega": omega, "attitude": attitude}


def displacements() -> Floats:
    """The displacement of each body at the start."""
    return np.ascontiguousarray(_core.displacement_starts(**columns())[:, 0])


def rates() -> Callable[..., tuple[Any, ...]]:
    """Rates of change of rates, vertical and displacement; the numbers of the body as literals."""
    i1, i2, i3 = MOMENTS.tolist()
    c1, c2, c3 = (MGL * COM).tolist()
    d1, d2, d3 = (i2 - i3) / i1, (i3 - i1) / i2, (i1 - i2) / i3
    c31, c21, c12, c32 = c3 / i1, c2 / i1, c1 / i2, c3 / i2
    c23, c13 = c2 / i3, c1 / i3

    def equations(u, v, w, x, y, z, a, b, c, p, q, r):  # type: ignore[no-untyped-def]
        # The vertical changes by its product with the rotation vector.
        e, f, g = y * r - z * q, z * p - x * r, x * q - y * p
        return (
            d1 * (v * w) + c31 * y - c21 * z,
            d2 * (w * u) + c12 * z - c32 * x,
            d3 * (u * v) + c23 * x - c13 * y,
            y * w - z * v,
            z * u - x * w,
            x * v - y * u,
            d1 * (b * w + v * c) + c31 * f - c21 * g,
            d2 * (c * u + w * a) + c12 * g - c32 * e,
            d3 * (a * v + u * b) + c23 * e - c13 * f,
            a + (q * w - r * v),
            b + (r * u - p * w),
            c + (p * v - q * u),
        )

    return equations


class Numba:
    """All bodies, by so many equal steps."""

    def __init__(self) -> None:
        import numba

        omega, vertical, _ = starts()
        tangent = displacements()
        self.start = np.ascontiguousarray(np.concatenate([omega, vertical, tangent], axis=1).T)
        form = Form("top", 12, rates(), lambda *_: self.start, lambda *_: ((), ()))
        fast = {"fastmath": True, "error_model": "numpy"}
        names = {"np": np, "rates": numba.njit(inline="always", **fast)(form.rates)}
        exec(written(DOP853, form, 0), names)
        self.advance = numba.njit(**fast)(names["advance"])

    def run(self, steps: float) -> Floats:
        states = self.start.copy()
        self.advance(states, T / int(steps), int(steps))
        return states

    def drift(self, steps: float) -> float:
        begin, end = energy(self.start), energy(self.run(steps))
        scale = 0.5 * (MOMENTS[:, None] * self.start[:3] ** 2).sum(axis=0) + MGL
        return float(np.max(np.abs(end - begin) / scale))


def energy(states: Floats) -> Floats:
    turning = 0.5 * (MOMENTS[:, None] * states[:3] ** 2).sum(axis=0)
    height: Floats = MGL * (COM[:, None] * states[3:6]).sum(axis=0)
    return turning + height


class Rigid:
    """All bodies by a method, in steps of an angle of the bound of their rates."""

    def __init__(self, method: str) -> None:
        self.method = method
        self.bodies = {"scene": "top", **columns()}
        self.rates = _core.fastest_rates(**self.bodies)
        self.scale = _core.rate_units(**columns())
        self.displacements = displacements()

    def run(self, per_radian: float) -> dict[str, Any]:
        return _core.growth(
            **self.bodies,
            method=self.method,
            displacements=self.displacements,
            scale=self.scale,
            of_attitude=False,
            times=np.array([T]),
            step=1.0 / (per_radian * self.rates),
            max_steps=10**9,
            threads=1,
        )

    def drift(self, per_radian: float) -> float:
        return float(self.run(per_radian)["energy_drift"].max())


class Map:
    """The map of verdicts, by the default method or by a scheme."""

    def __init__(self, check: float) -> None:
        self.check = check

    def run(self, _: float) -> rigid.StabilityMap:
        axes = {"tilt": TILT[0], "spin": SPIN[:, 0]}
        return rigid.stability_map(
            TOP, axes=axes, start=rigid.Start(spin=0.0), samples=1, t_end=T, rng=1, threads=1,
            stable=rigid.regular(), check=self.check, progress=False,
        )  # fmt: skip


def fewest(side: Numba | Rigid, target: float, low: float, high: float) -> float:
    """The least knob whose drift is below the target."""
    while high / low > 1.01:
        middle = float(np.sqrt(low * high))
        low, high = (low, middle) if side.drift(middle) <= target else (middle, high)
    return high


def main() -> None:
    """Print the table."""
    numba = Numba()
    print(f"instruction set {rigid.build_info()['isa']}; {REPEATS} repeats")
    for target in TARGETS:
        ways: dict[str, tuple[Any, float]] = {
            "numba dop853": (numba, fewest(numba, target, 200, 2e4))
        }
        for method in METHODS:
            side = Rigid(method)
            ways[f"rigid {method}"] = (side, fewest(side, target, 0.1, 30.0))
        if target == TARGETS[0]:
            ways["rigid map"] = (Map(0.0), 0.0)
            ways["rigid map, checked"] = (Map(1.0), 0.0)
        times: dict[str, list[float]] = {name: [] for name in ways}
        ratios: dict[str, list[float]] = {name: [] for name in ways}
        for _ in range(REPEATS):
            for name, (side, knob) in ways.items():
                begin = time.process_time()
                side.run(knob)
                times[name].append(1e3 * (time.process_time() - begin))
                ratios[name].append(times["numba dop853"][-1] / times[name][-1])
        print(f"drift of the energy below {target:g}")
        for name, (_, knob) in ways.items():
            middle, ratio = statistics.median(times[name]), statistics.median(ratios[name])
            least = min(times[name])
            row = f"  {name:20} knob {knob:8.2f} {middle:8.1f} ms, least {least:8.1f}"
            print(f"{row}; numba over it {ratio:.2f}", flush=True)


if __name__ == "__main__":
    main()
