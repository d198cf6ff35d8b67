"""Growth of a deviation vector on a 64 x 64 grid, against numba: processor time of one thread.

    pip install numba && python benches/regular_map.py

The asymmetric top of the map ``chaotic-top`` until T = 200, with one deviation vector. numba: what
an expert writes, DOP853 in lanes with a fixed step for all bodies, the table as literals, fast
math; the deviation vector is integrated only. rigid: the same, with exponent, MEGNO, its mean and
FLI. Each takes the fewest equal steps for which the largest drift of the energy of all bodies is
below the target. Medians of interleaved repeats.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from timing import Floats, counted, in_turns, moved, over, parser, share, sized

import rigid
from rigid import _core
from rigid.model.bodies import Bodies

sys.path.insert(0, str(Path(__file__).parent / "peers"))
from numba_side import DOP853, numba, written
from tops import Form

MOMENTS = np.array([1.0, 1.6, 0.7])
COM = np.array([0.3, 0.2, 0.93]) / np.linalg.norm([0.3, 0.2, 0.93])
MGL = 1.2
CELLS, T, TARGETS, REPEATS = sized((64, 200.0, (1e-6, 1e-10), 9), (4, 10.0, (1e-6,), 1))
NEAR = sized(1.01, 3.0)
"""Factor to which the fewest steps are found."""
METHODS = ("dop853", "taylor12")
TOP = rigid.HeavyTop(rigid.Body(tuple(MOMENTS)), mgl=MGL, com=COM)
TILT, SPIN = np.meshgrid(np.linspace(0.05, 3.09, CELLS), np.linspace(0.0, 8.0, CELLS))


def starts() -> tuple[Floats, Floats, Floats]:
    """Rates, vertical and attitude of the bodies."""
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


def bodies() -> Bodies:
    """The bodies, as the core reads them."""
    return Bodies(kind="top", shape=(CELLS * CELLS,), **columns())


def deviations() -> Floats:
    """The deviation vector of each body at the start."""
    return np.ascontiguousarray(_core.deviation_starts(bodies())[:, 0])


def rates() -> Callable[..., tuple[Any, ...]]:
    """Rates of change of rates, gamma and deviation; the numbers of the body as literals."""
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

    name = "numba dop853"
    knobs = T, 100.0 * T
    """The fewest steps and the most."""

    def __init__(self) -> None:
        omega, vertical, _ = starts()
        tangent = deviations()
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

    def check(self, states: Floats) -> None:
        moved(states.T, self.start.T)


def energy(states: Floats) -> Floats:
    turning = 0.5 * (MOMENTS[:, None] * states[:3] ** 2).sum(axis=0)
    height: Floats = MGL * (COM[:, None] * states[3:6]).sum(axis=0)
    return turning + height


class Rigid:
    """All bodies by a method, by so many equal steps."""

    knobs = Numba.knobs

    def __init__(self, method: str) -> None:
        self.method, self.name = method, f"rigid {method}"
        self.bodies = bodies()
        self.deviations = deviations()

    def run(self, steps: float) -> dict[str, Any]:
        return _core.growth(
            self.bodies,
            method=self.method,
            deviations=self.deviations,
            of_attitude=False,
            times=np.array([T]),
            step=np.full(CELLS * CELLS, T / int(steps)),
            max_steps=10**9,
            threads=1,
        )

    def drift(self, steps: float) -> float:
        return float(self.run(steps)["energy_drift"].max())

    def check(self, found: dict[str, Any]) -> None:
        moved(found["logs"][:, 0], 0.0, found["steps"])


class Map:
    """The map of verdicts, by the default method or by another."""

    def __init__(self, name: str, again: float) -> None:
        self.name, self.again = name, again

    def run(self, _: float) -> rigid.StabilityMap:
        axes = {"tilt": TILT[0], "spin": SPIN[:, 0]}
        return rigid.stability_map(
            TOP, axes=axes, start=rigid.Start(spin=0.0), samples=1, t_end=T, rng=1, threads=1,
            stable=rigid.regular(), check=self.again, progress=False,
        )  # fmt: skip

    def check(self, result: rigid.StabilityMap) -> None:
        counted(result.columns, CELLS * CELLS)


def fewest(side: Numba | Rigid, target: float) -> float:
    """The least knob whose drift is below the target."""
    low, high = side.knobs
    while high / low > NEAR:
        middle = float(np.sqrt(low * high))
        low, high = (low, middle) if side.drift(middle) <= target else (middle, high)
    share(f"drift of {side.name} over the target", side.drift(high) / target)
    return high


def main() -> None:
    """Print the table."""
    parser(__doc__).parse_args()
    sides = [*map(Rigid, METHODS)] if numba is None else [Numba(), *map(Rigid, METHODS)]
    maps = [Map("rigid map", 0.0), Map("rigid map, checked", 1.0)]
    print(f"instruction set {rigid.build_info()['isa']}; {REPEATS} repeats")
    for target in TARGETS:
        ways: list[tuple[Any, float]] = [(side, fewest(side, target)) for side in sides]
        if target == TARGETS[0]:
            ways += [(of_verdicts, 0.0) for of_verdicts in maps]
        times = in_turns(
            {side.name: lambda side=side, knob=knob: (side, side.run(knob)) for side, knob in ways},
            lambda done: done[0].check(done[1]),
            repeats=REPEATS,
        )
        first, *_ = times.values()
        print(f"drift of the energy below {target:g}")
        for side, knob in ways:
            seconds = times[side.name]
            row = f"  {side.name:20} knob {knob:8.2f} {1e3 * np.median(seconds):8.1f} ms"
            least = f"least {1e3 * seconds.min():8.1f}"
            ratio = over(f"{ways[0][0].name} over {side.name}", first, seconds)
            print(f"{row}, {least}; {ways[0][0].name} over it {ratio:.2f}", flush=True)


if __name__ == "__main__":
    main()
