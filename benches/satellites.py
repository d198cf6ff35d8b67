"""Satellites on eccentric orbits, against numba: processor time of one thread.

    pip install numba && python benches/satellites.py

Ellipsoids over a/b, b/c and the eccentricity, for some orbits. numba: what an expert writes,
DOP853 in lanes with a fixed step for all bodies, rates, quaternion, and cosine and sine of the
eccentric anomaly. rigid: the same steps by the kernel, and the map, unverified and verified. The
map states an interval and an error; numba states neither. Medians of interleaved repeats.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from timing import Floats, in_turns, moved, over, parser, required, sized

import rigid

sys.path.insert(0, str(Path(__file__).parent / "peers"))
from numba_side import BLOCK, DOP853, numba, written
from tops import Form

CELLS, ORBITS, REPEATS = sized((16, 10.0, 9), (4, 1.0, 1))
T, STEPS = 2.0 * np.pi * ORBITS, int(128 * ORBITS)


def grid() -> tuple[Floats, Floats]:
    """Moments and eccentricities of the bodies; the long axis points to the planet at the start."""
    shape = (
        np.linspace(1.05, 1.5, CELLS),
        np.linspace(1.05, 1.5, CELLS),
        np.linspace(0.0, 0.2, CELLS),
    )
    ab, bc, e = (part.ravel() for part in np.meshgrid(*shape))
    a, b, c = ab * bc, bc, np.ones_like(ab)
    moments = np.stack([b**2 + c**2, a**2 + c**2, a**2 + b**2], axis=1) / 5.0
    return moments, e


MOMENTS, ECCENTRICITY = grid()
OMEGA = np.tile([1e-3, 2e-3, 1.0], (len(MOMENTS), 1))


def rates() -> Callable[..., tuple[Any, ...]]:
    """Rates of change of rates, quaternion, cosine and sine of the eccentric anomaly."""

    def equations(u, v, w, a, b, c, d, x, y, p, q, r, f, g, h, e, k):  # type: ignore[no-untyped-def]
        near = 1.0 / (1.0 - e * x)
        px, py = (x - e) * near, k * y * near
        o1 = (1.0 - 2.0 * (c * c + d * d)) * px + 2.0 * (b * c + a * d) * py
        o2 = 2.0 * (b * c - a * d) * px + (1.0 - 2.0 * (b * b + d * d)) * py
        o3 = 2.0 * (b * d + a * c) * px + 2.0 * (c * d - a * b) * py
        pull = 3.0 * near * near * near
        return (
            p * (v * w - pull * o2 * o3),
            q * (w * u - pull * o3 * o1),
            r * (u * v - pull * o1 * o2),
            0.5 * (-b * u - c * v - d * w),
            0.5 * (a * u + c * w - d * v),
            0.5 * (a * v + d * u - b * w),
            0.5 * (a * w + b * v - c * u),
            -y * near,
            x * near,
        )

    return equations


class Numba:
    """All bodies by the hand-written loop."""

    name = "numba dop853"

    def __init__(self) -> None:
        i1, i2, i3 = MOMENTS.T
        e, one, zero = ECCENTRICITY, np.ones(len(MOMENTS)), np.zeros(len(MOMENTS))
        ratios = ((i2 - i3) / i1, (i3 - i1) / i2, (i1 - i2) / i3)
        rows = (*OMEGA.T, one, zero, zero, zero, one, zero, *ratios, zero, zero, zero, e)
        self.start = np.ascontiguousarray(np.stack([*rows, np.sqrt(1.0 - e * e)]))
        form = Form("satellite", 9, rates(), lambda *_: self.start, lambda *_: ((), ()))
        fast = {"fastmath": True, "error_model": "numpy"}
        names = {"np": np, "rates": numba.njit(inline="always", **fast)(form.rates)}
        exec(written(DOP853, form, len(self.start) - 9), names)
        self.advance = numba.njit(**fast)(names["advance"])

    def run(self) -> Floats:
        states = self.start.copy()
        self.advance(states, T / STEPS, STEPS)
        return states[:3].T


def scene() -> rigid.FreeBody:
    return rigid.FreeBody(rigid.Body(MOMENTS), orbit=rigid.Orbit(1.0, ECCENTRICITY))


class Rigid:
    """All bodies by the kernel."""

    name = "rigid dop853"

    def run(self) -> Floats:
        run = rigid.simulate(
            scene(), OMEGA, t=[T], method="dop853", step=T / STEPS, check=False, threads=1
        )
        return run.omega[:, 0]


def main() -> None:
    """Print the table."""
    parser(__doc__).parse_args()
    assert len(MOMENTS) % BLOCK == 0
    sides: list[Any] = [Rigid()] if numba is None else [Numba(), Rigid()]
    print(f"instruction set {rigid.build_info()['isa']}; {len(MOMENTS)} satellites, {STEPS} steps")
    found = {side.name: side.run() for side in sides}
    apart = [np.abs(rates - found[Rigid.name]).max(axis=1) for rates in found.values()]
    required(np.median(apart) < 1e-6, f"rates differ by {np.median(apart):.1e}: must agree")
    times = in_turns(
        {side.name: side.run for side in sides}, lambda rates: moved(rates, OMEGA), repeats=REPEATS
    )
    for name, seconds in times.items():
        each = 1e9 * np.median(seconds) / (len(MOMENTS) * STEPS)
        ratio = over(f"{sides[0].name} over {name}", times[sides[0].name], seconds)
        print(f"  {name:14} {each:7.1f} ns a step; {sides[0].name} over it {ratio:.2f}", flush=True)


if __name__ == "__main__":
    main()
