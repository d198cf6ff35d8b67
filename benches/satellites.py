"""Satellites on eccentric orbits, against numba: processor time of one thread.

    pip install numba && python benches/satellites.py

Ellipsoids over a/b, b/c and the eccentricity, for some orbits. numba: what an expert writes,
DOP853 in lanes, rates, quaternion, and cosine and sine of the eccentric anomaly, with the fewest
equal steps by which 95 of 100 bodies err by less than 1e-6. rigid: its fewest steps, which are
equal in the eccentric anomaly, and the map of what librates, unverified and verified. The map
states intervals and classifies each body; numba does neither. Then the runs alone for one
eccentricity each; from 0.5 on half of the bodies err less. Medians of interleaved repeats.
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

Ways = dict[str, tuple[Callable[[], Any], str]]

CELLS, ORBITS, REPEATS = sized((16, 10.0, 9), (4, 0.25, 1))
T, NEAR, ALLOWED = 2.0 * np.pi * ORBITS, sized(1.02, 8.0), sized(1e-6, 1.0)
RATIOS = np.linspace(1.05, 1.5, CELLS)
AXES = {"a/b": RATIOS, "b/c": RATIOS, "eccentricity": np.linspace(0.0, 0.2, CELLS)}
OMEGA = np.array([1e-3, 2e-3, 1.0])

#: One eccentricity, the orbits, and the share of the bodies that err less.
ONE = sized(
    ((0.0, 10.0, 0.95), (0.1, 10.0, 0.95), (0.5, 3.0, 0.5), (0.9, 1.0, 0.5)), ((0.5, 0.5, 0.5),)
)


class Bodies:
    """Ellipsoids on orbits of period 2 pi; the long axis points to the planet at the start."""

    def __init__(self, eccentricities: Floats, time: float, share: float) -> None:
        ab, bc, e = (part.ravel() for part in np.meshgrid(RATIOS, RATIOS, eccentricities))
        a, b, c = ab * bc, bc, np.ones_like(ab)
        self.moments = np.stack([b**2 + c**2, a**2 + c**2, a**2 + b**2], axis=1) / 5.0
        self.eccentricity, self.time, self.share = e, time, share
        self.turns = time / (2.0 * np.pi)
        self.omega = np.tile(OMEGA, (len(e), 1))
        self.attitude: Floats | None = None

    def __len__(self) -> int:
        return len(self.omega)

    @property
    def scene(self) -> rigid.FreeBody:
        """The bodies on their orbits."""
        return rigid.FreeBody(rigid.Body(self.moments), orbit=rigid.Orbit(1.0, self.eccentricity))

    def simulated(self, method: str, steps: int) -> Floats:
        """The rates at the end by equal steps."""
        run = rigid.simulate(
            self.scene, self.omega, self.attitude, t=[self.time], method=method,
            step=self.time / steps, check=False, threads=1,
        )  # fmt: skip
        return run.omega[:, 0]

    def truth(self) -> Floats:
        """The rates at the end by steps down to rounding."""
        run = rigid.simulate(self.scene, self.omega, self.attitude, t=[self.time], check=False)
        return run.omega[:, 0]

    def by_hand(self) -> tuple[Callable[..., tuple[Any, ...]], Floats]:
        """The equations of a loop by hand, and its numbers of all bodies: nine move."""
        i1, i2, i3 = self.moments.T
        e, one, zero = self.eccentricity, np.ones(len(self)), np.zeros(len(self))
        ratios = ((i2 - i3) / i1, (i3 - i1) / i2, (i1 - i2) / i3)
        rows = (*self.omega.T, one, zero, zero, zero, one, zero, *ratios, zero, zero, zero, e)
        return rates(), np.ascontiguousarray(np.stack([*rows, np.sqrt(1.0 - e * e)]))

    def fewest(self, run: Callable[[int], Floats]) -> int:
        """The fewest equal steps by which a share of the bodies err by less than ``ALLOWED``."""
        truth = self.truth()

        def errs(steps: int) -> float:
            error = np.abs(run(steps) - truth).max(axis=1) / np.linalg.norm(self.omega, axis=1)
            return float(np.quantile(np.where(np.isfinite(error), error, np.inf), self.share))

        low, high = int(8 * self.turns), int(64 * self.turns)
        while errs(high) > ALLOWED:
            low, high = high, 2 * high
        while high - low > 1 and high / low > NEAR:
            middle = int(np.sqrt(low * high)) + 1
            low, high = (low, middle) if errs(middle) < ALLOWED else (middle, high)
        return high


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

    def __init__(self, bodies: Bodies) -> None:
        equations, self.start = bodies.by_hand()
        self.bodies, start = bodies, self.start
        form = Form("satellite", 9, equations, lambda *_: start, lambda *_: ((), ()))
        fast = {"fastmath": True, "error_model": "numpy"}
        names = {"np": np, "rates": numba.njit(inline="always", **fast)(form.rates)}
        exec(written(DOP853, form, len(start) - 9), names)
        self.advance = numba.njit(**fast)(names["advance"])

    def run(self, steps: int) -> Floats:
        states = self.start.copy()
        self.advance(states, self.bodies.time / steps, steps)
        return states[:3].T


def mapped(check: float) -> rigid.StabilityMap:
    """The map of what librates."""
    body = rigid.FreeBody(rigid.Body.ellipsoid(1.2, 1.1, 1.0), orbit=rigid.Orbit(1.0))
    return rigid.stability_map(
        body, axes=AXES, start=rigid.Start(omega=tuple(OMEGA)), stable=rigid.librates(),
        samples=1, t_end=T, rng=1, threads=1, check=check, progress=False,
    )  # fmt: skip


def compared(bodies: Bodies, maps: Callable[[int], Ways]) -> None:
    """Print the rows of some bodies, and of maps that are told how many steps ``rigid`` needs."""
    own = bodies.fewest(partial(bodies.simulated, "dop853"))
    ways: Ways = {
        "rigid dop853": (partial(bodies.simulated, "dop853", own), f"{own} steps"),
        **maps(own),
    }
    if numba is not None:
        side = Numba(bodies)
        steps = bodies.fewest(side.run)
        ways = {"numba dop853": (partial(side.run, steps), f"{steps} steps"), **ways}

    def check(found: Any) -> None:
        if isinstance(found, rigid.StabilityMap):
            counted(found.columns, len(bodies))
        else:
            moved(found, bodies.omega)

    times = in_turns({name: call for name, (call, _) in ways.items()}, check, repeats=REPEATS)
    first = next(iter(times))
    for name, seconds in times.items():
        each = 1e6 * np.median(seconds) / len(bodies)
        ratio = over(f"{first} over {name}", times[first], seconds)
        words = ways[name][1]
        print(
            f"  {name:20} {words:12} {each:7.1f} us a body; {first} over it {ratio:.2f}", flush=True
        )


def main() -> None:
    """Print the tables."""
    parser(__doc__).parse_args()
    bodies = Bodies(AXES["eccentricity"], T, 0.95)
    assert len(bodies) % BLOCK == 0
    print(
        f"instruction set {rigid.build_info()['isa']}; {len(bodies)} satellites, {ORBITS:g} orbits"
    )
    compared(
        bodies,
        lambda _: {
            "rigid map": (partial(mapped, 0.0), "unverified"),
            "rigid map, checked": (partial(mapped, 1.0), "verified"),
        },
    )
    for e, orbits, share in ONE:
        print(f"eccentricity {e}, {orbits:g} orbits, {share:.0%} of the bodies")
        compared(Bodies(np.full(CELLS, e), 2.0 * np.pi * orbits, share), lambda _: {})


if __name__ == "__main__":
    main()
