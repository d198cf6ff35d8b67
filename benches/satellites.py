"""Satellites on eccentric orbits, against numba: processor time of one thread.

    pip install numba && python benches/satellites.py

Ellipsoids over a/b, b/c and the eccentricity, for some orbits. numba: what an expert writes,
DOP853 in lanes, rates, quaternion, and cosine and sine of the eccentric anomaly, with the fewest
equal steps by which 95 of 100 bodies err by less than 1e-6. rigid: the same steps, and the map of
what librates, unverified and verified. The map states intervals and classifies each body; numba
does neither. Medians of interleaved repeats.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from timing import Floats, counted, in_turns, moved, over, parser, sized

import rigid

sys.path.insert(0, str(Path(__file__).parent / "peers"))
from numba_side import BLOCK, DOP853, numba, written
from tops import Form

CELLS, ORBITS, REPEATS = sized((16, 10.0, 9), (4, 1.0, 1))
T, NEAR, ALLOWED = 2.0 * np.pi * ORBITS, sized(1.02, 2.0), 1e-6
AXES = {
    "a/b": np.linspace(1.05, 1.5, CELLS),
    "b/c": np.linspace(1.05, 1.5, CELLS),
    "eccentricity": np.linspace(0.0, 0.2, CELLS),
}


def grid() -> tuple[Floats, Floats]:
    """Moments and eccentricities of the bodies; the long axis points to the planet at the start."""
    ab, bc, e = (part.ravel() for part in np.meshgrid(*AXES.values()))
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

    def run(self, steps: int) -> Floats:
        states = self.start.copy()
        self.advance(states, T / steps, steps)
        return states[:3].T


def scene() -> rigid.FreeBody:
    return rigid.FreeBody(rigid.Body(MOMENTS), orbit=rigid.Orbit(1.0, ECCENTRICITY))


def simulated(method: str, steps: int) -> Floats:
    """The rates at the end by equal steps."""
    run = rigid.simulate(
        scene(), OMEGA, t=[T], method=method, step=T / steps, check=False, threads=1
    )
    return run.omega[:, 0]


def mapped(check: float) -> rigid.StabilityMap:
    """The map of what librates."""
    body = rigid.FreeBody(rigid.Body.ellipsoid(1.2, 1.1, 1.0), orbit=rigid.Orbit(1.0))
    return rigid.stability_map(
        body, axes=AXES, start=rigid.Start(omega=tuple(OMEGA[0])), stable=rigid.librates(),
        samples=1, t_end=T, rng=1, threads=1, check=check, progress=False,
    )  # fmt: skip


def fewest(run: Callable[[int], Floats]) -> int:
    """The fewest equal steps by which 95 of 100 bodies err by less than ``ALLOWED``."""
    truth = simulated("taylor20", int(64 * ORBITS))
    low, high = int(8 * ORBITS), int(512 * ORBITS)
    while high / low > NEAR:
        middle = int(np.sqrt(low * high)) + 1
        error = np.quantile(np.abs(run(middle) - truth).max(axis=1), 0.95)
        low, high = (low, middle) if error < ALLOWED else (middle, high)
    return high


def main() -> None:
    """Print the table."""
    parser(__doc__).parse_args()
    assert len(MOMENTS) % BLOCK == 0
    own = fewest(partial(simulated, "dop853"))
    ways: dict[str, tuple[Callable[[], Any], str]] = {
        "rigid dop853": (partial(simulated, "dop853", own), f"{own} steps"),
        "rigid map": (partial(mapped, 0.0), "unverified"),
        "rigid map, checked": (partial(mapped, 1.0), "verified"),
    }
    if numba is not None:
        side = Numba()
        steps = fewest(side.run)
        ways = {"numba dop853": (partial(side.run, steps), f"{steps} steps"), **ways}
    print(
        f"instruction set {rigid.build_info()['isa']}; {len(MOMENTS)} satellites, {ORBITS:g} orbits"
    )

    def check(found: Any) -> None:
        if isinstance(found, rigid.StabilityMap):
            counted(found.columns, len(MOMENTS))
        else:
            moved(found, OMEGA)

    times = in_turns({name: call for name, (call, _) in ways.items()}, check, repeats=REPEATS)
    first = next(iter(times))
    for name, seconds in times.items():
        each = 1e6 * np.median(seconds) / len(MOMENTS)
        ratio = over(f"{first} over {name}", times[first], seconds)
        words = ways[name][1]
        print(
            f"  {name:20} {words:12} {each:7.1f} us a body; {first} over it {ratio:.2f}", flush=True
        )


if __name__ == "__main__":
    main()
