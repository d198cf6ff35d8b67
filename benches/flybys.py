"""Apophis passes the Earth, against numba: processor time of one thread, and what becomes of it.

    pip install numba && python benches/flybys.py

Bodies like Apophis in random attitudes, five days before the passage, for ten days. numba: what an
expert writes, DOP853 in lanes, rates, quaternion, and the place on the hyperbola, with the fewest
equal steps by which 95 of 100 bodies err by less than 1e-6. rigid: its fewest steps, and the map of
what keeps its short-axis mode, unverified and verified, with steps for an error of 1e-8 and with
these fewest steps. The map states intervals and classifies
each body; numba does neither. Then a million bodies through the flyby, verified, and how their
tumbling changes. Medians of interleaved repeats.
"""

from __future__ import annotations

from collections.abc import Callable
from time import perf_counter, process_time
from typing import Any

import numpy as np
from satellites import BLOCK, Bodies, compared
from timing import Floats, parser, sized

import rigid

DAY = 86400.0
GM, PERIAPSIS, SPEED = 398600.44, 38011.0, 5.8414  # km³/s², km, km/s
MOMENTS = (0.729, 0.947, 1.0)
SPIN, TILT = 6.5e-5, 0.35  # rad/s; rad, from the short axis

COUNT, MANY = sized((4096, 1_000_000), (BLOCK, 64))

ORBIT = rigid.Orbit.flyby(gm=GM, periapsis=PERIAPSIS, speed=SPEED, time=5.0 * DAY)
SCENE = rigid.FreeBody(rigid.Body(MOMENTS), orbit=ORBIT)
START = rigid.Start(spin=SPIN, axis=3, tilt=TILT, attitude_noise=rigid.uniform_attitude())


class Flybys(Bodies):
    """Bodies in random attitudes before the passage."""

    def __init__(self, count: int) -> None:
        drawn = mapped(0.0, count).starts(np.arange(count), pixel=0)
        self.moments = np.tile(MOMENTS, (count, 1))
        self.omega, self.attitude = drawn.omega, drawn.attitude
        self.time, self.share = 10.0 * DAY, 0.95
        self.turns = 1.0

    @property
    def scene(self) -> rigid.FreeBody:
        """The body on its hyperbola."""
        return SCENE

    def by_hand(self) -> tuple[Callable[..., tuple[Any, ...]], Floats]:
        """The equations of a loop by hand, and its numbers of all bodies: nine move."""
        i1, i2, i3 = self.moments.T
        one = np.ones(len(self))
        ratios = ((i2 - i3) / i1, (i3 - i1) / i2, (i1 - i2) / i3)
        place = ORBIT.position(0.0)
        e, n = float(ORBIT.eccentricity), float(ORBIT.rate)
        minor = np.sqrt(e * e - 1.0)
        cosh, sinh = e - place[0], place[1] / minor
        moving = (*self.omega.T, *self.attitude.T, cosh * one, sinh * one)
        return rates(), np.stack([*moving, *ratios, n * one, e * one, minor * one])


def rates() -> Callable[..., tuple[Any, ...]]:
    """Rates of change of rates, quaternion, cosh and sinh of the anomaly, in seconds."""

    def equations(u, v, w, a, b, c, d, x, y, p, q, r, n, e, k):  # type: ignore[no-untyped-def]
        near = 1.0 / (e * x - 1.0)
        px, py = (e - x) * near, k * y * near
        o1 = (1.0 - 2.0 * (c * c + d * d)) * px + 2.0 * (b * c + a * d) * py
        o2 = 2.0 * (b * c - a * d) * px + (1.0 - 2.0 * (b * b + d * d)) * py
        o3 = 2.0 * (b * d + a * c) * px + 2.0 * (c * d - a * b) * py
        pull = 3.0 * n * n * near * near * near
        return (
            p * (v * w - pull * o2 * o3),
            q * (w * u - pull * o3 * o1),
            r * (u * v - pull * o1 * o2),
            0.5 * (-b * u - c * v - d * w),
            0.5 * (a * u + c * w - d * v),
            0.5 * (a * v + d * u - b * w),
            0.5 * (a * w + b * v - c * u),
            n * y * near,
            n * x * near,
        )

    return equations


def mapped(check: float, samples: int = COUNT, **options: Any) -> rigid.StabilityMap:
    """The map of what keeps the sense of rotation about its short axis."""
    return rigid.stability_map(
        SCENE, axes={"tilt": [TILT]}, start=START, stable=rigid.no_flip(3), samples=samples,
        t_end=10.0 * DAY, rng=1, check=check, progress=False, **{"threads": 1, **options},
    )  # fmt: skip


def like(steps: int) -> dict[str, Any]:
    """The method and the step of as many steps."""
    return {"method": "dop853", "step": 10.0 * DAY / steps}


def changed(bodies: Flybys) -> None:
    """Print how effective rate and pole of the momentum of some bodies change."""
    run = rigid.simulate(SCENE, bodies.omega, bodies.attitude, t=[0.0, bodies.time])
    momentum = run.omega * np.asarray(MOMENTS)
    energy = 0.5 * np.sum(momentum * run.omega, axis=-1)
    size = np.linalg.norm(momentum, axis=-1)
    effective = 2.0 * energy / size  # omega_e of Samarasinha and A'Hearn (1991)
    ratio = effective[:, 1] / effective[:, 0]
    turned = rigid.rotations.quaternion_to_matrix(run.attitude) @ momentum[..., np.newaxis]
    in_space = turned[..., 0] / size[..., np.newaxis]
    shift = np.degrees(np.arccos(np.clip(np.sum(in_space[:, 0] * in_space[:, 1], -1), -1.0, 1.0)))
    for name, values in (("effective rate, after over before", ratio), ("pole, degrees", shift)):
        low, middle, high = np.quantile(values, (0.05, 0.5, 0.95))
        print(f"  {name}: median {middle:.3g}, 5 % below {low:.3g}, 5 % above {high:.3g}")


def main() -> None:
    """Print the tables."""
    parser(__doc__).parse_args()
    bodies = Flybys(COUNT)
    print(f"instruction set {rigid.build_info()['isa']}; {COUNT} bodies, ten days")
    compared(
        bodies,
        lambda steps: {
            "rigid map": (lambda: mapped(0.0), "unverified"),
            "rigid map, checked": (lambda: mapped(1.0), "verified"),
            "map, 1e-6": (lambda: mapped(0.0, **like(steps)), "unverified"),
            "map, 1e-6, checked": (lambda: mapped(1.0, **like(steps)), "verified"),
        },
    )
    changed(bodies)
    wall, own = perf_counter(), process_time()
    result = mapped(1.0, MANY, threads=None)
    wall, own = perf_counter() - wall, process_time() - own
    low, high = result.lower.item(), result.upper.item()
    print(
        f"{MANY} bodies, verified: {wall:.2f} s, {1e6 * own / MANY:.2f} us of processor a body; "
        f"{result.share.item():.4f} keep the sense of their short axis, {low:.4f} to {high:.4f}; "
        f"{int(result.undecided.sum())} undecided"
    )


if __name__ == "__main__":
    main()
