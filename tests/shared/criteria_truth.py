"""What criteria say of random bodies: by maps, and by looking at a fine motion.

The motion is that of the closed form where there is one, else of Taylor series in short steps. The
angles are those of vectors and matrices, not the squares of chords that the core observes.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

import random_scenes
import rigid
from physics import angle_between, quaternion_product, rotated
from random_scenes import Scenes
from rigid import _core
from rigid.maps.core_request import CoreRequest, CoreStarts
from rigid.model import bounds
from rigid.model.criterion import Criterion
from rigid.solve.request import Request

Floats = NDArray[np.float64]

#: Horizon and distance of the looks; the fastest rate lies between 1/2 and 1 rad/s.
HORIZON, LOOK = 24.0, 0.05

#: A scalar that passes its limit by less than this may do so unseen (rad or rad/s): the steps of a
#: map are wrong by about 1e-8 rad for each radian, and a top without closed form magnifies that.
GRAZE = 3e-6


def asymmetric_tops(rng: np.random.Generator, n: int) -> Scenes:
    """Tops with any moments and any centre of mass, that do not spin for long enough for chaos."""
    halves = rng.uniform(0.2, 1.0, (n, 3))
    moments = halves.sum(axis=1, keepdims=True) - halves
    weight = rng.normal(size=(n, 3))
    weight *= rng.uniform(0.02, 0.2, (n, 1)) / np.linalg.norm(weight, axis=1, keepdims=True)
    omega = rng.uniform(-0.5, 0.5, (n, 3))
    attitude = random_scenes.any_attitude(rng, n)
    return Scenes("top", "asymmetric top", moments, weight, omega, attitude)


@dataclass(frozen=True)
class Judged:
    """Verdicts of a map with one body in each pixel."""

    job: Any
    stable: NDArray[np.bool_]
    undecided: NDArray[np.bool_]
    left: Floats


def job_of(scenes: Scenes, **asked: Any) -> _core.MapJob:
    """The request of a map with each scene in a pixel with one body."""
    n = len(scenes)
    starts = CoreStarts(
        omega=scenes.omega,
        omega_noise="none",
        omega_size=np.zeros((n, 3)),
        attitude=scenes.attitude,
        attitude_noise="none",
        attitude_size=np.zeros((n, 3)),
    )
    one_body: dict[str, Any] = {"samples": 1, "checked": 1, "seed": 0, "max_steps": 10**7}
    request = CoreRequest(
        scene=scenes.kind,
        moments=scenes.moments,
        weight=scenes.weight,
        starts=[starts],
        measures=[],
        **one_body,
        **asked,
    )
    return _core.MapJob(request)


def judged(scenes: Scenes, criterion: Criterion, method: str = "auto") -> Judged:
    """What a map says of each body."""
    job = job_of(
        scenes,
        method=method,
        conditions=criterion.conditions(),
        logic=" ".join(map(str, criterion.logic())),
        t_end=HORIZON,
        step=0.05 if method == "rk4" else None,
    )
    counted = job.run(0, len(scenes), 2)
    assert counted is not None
    assert not counted["failed"].any()
    return Judged(
        job, counted["stable"] == 1, counted["undecided"] == 1, np.array(counted["earliest"])
    )


def states(scenes: Scenes, times: Floats) -> tuple[Floats, Floats]:
    """Rates (n, m, 3) and attitudes (n, m, 4) at times of shape (1, m) or (n, m)."""
    exact = scenes.kind == "free" or scenes.family == "Lagrange top"
    request = Request(
        bodies=scenes.bodies,
        times=times if len(times) == len(scenes) else times[0],
        method="exact" if exact else "taylor20",
        record="attitude",
        max_steps=10**6,
        threads=2,
        steps=None if exact else np.full(len(scenes), LOOK),
    )
    found = request.states()
    return found["omega"], found["attitude"]


def margins(criterion: Criterion, scenes: Scenes, omega: Floats, attitude: Floats) -> Floats:
    """How far each state is within the limit of a criterion: rad or rad/s, negative beyond."""
    start = scenes.omega[:, None, :]
    origin = scenes.attitude[:, None, :]
    if isinstance(criterion, bounds.SpinAbove):
        if criterion.axis is None:
            along: Floats = np.linalg.norm(omega, axis=-1)
        else:
            along = omega[..., abs(criterion.axis) - 1] * np.sign(criterion.axis)
        above: Floats = along - criterion.rate
        return above
    if isinstance(criterion, bounds.RateWithin):
        weights = scenes.moments[:, None, :] if criterion.of == "L" else 1.0
        vector, first = omega * weights, start * weights
        if criterion.frame == "space":
            vector, first = rotated(attitude, vector), rotated(origin, first)
        return criterion.angle - angle_between(vector, np.broadcast_to(first, vector.shape))
    if isinstance(criterion, bounds.TiltBetween):
        axis = np.zeros(3)
        axis[abs(criterion.axis) - 1] = np.sign(criterion.axis)
        tilt = angle_between(
            rotated(attitude, np.broadcast_to(axis, omega.shape)), np.array([0.0, 0.0, 1.0])
        )
        nearest: Floats = np.minimum(criterion.high - tilt, tilt - criterion.low)
        return nearest
    turn = quaternion_product(
        np.broadcast_to(origin * [1.0, -1.0, -1.0, -1.0], attitude.shape), attitude
    )
    angle = 2.0 * np.arctan2(np.linalg.norm(turn[..., 1:], axis=-1), np.abs(turn[..., 0]))
    if isinstance(criterion, bounds.ReturnsNear):
        beyond: Floats = angle - criterion.angle
        return beyond
    assert isinstance(criterion, bounds.NearStart)
    within: Floats = criterion.angle - angle
    return within


@dataclass(frozen=True)
class Truth:
    """By how much each body stays within its limit, and when it first passes it."""

    least: Floats
    left: Floats


def truth(scenes: Scenes, criterion: Criterion, size: int = 500) -> Truth:
    """The least margin of each body until the horizon, and the time of the first crossing."""
    parts = [
        _truth(_some(scenes, slice(first, first + size)), criterion)
        for first in range(0, len(scenes), size)
    ]
    return Truth(
        *(np.concatenate([getattr(part, of) for part in parts]) for of in ("least", "left"))
    )


def _some(scenes: Scenes, which: Any) -> Scenes:
    columns = (scenes.moments, scenes.weight, scenes.omega, scenes.attitude)
    return Scenes(scenes.kind, scenes.family, *(column[which] for column in columns))


def _truth(scenes: Scenes, criterion: Criterion) -> Truth:
    after = criterion.after if isinstance(criterion, bounds.ReturnsNear) else 0.0
    n = len(scenes)
    times = np.linspace(after, HORIZON, round((HORIZON - after) / LOOK) + 1)

    def seen(at: Floats) -> Floats:
        return margins(criterion, scenes, *states(scenes, at))

    found = seen(times[np.newaxis])
    beyond = found < 0.0
    first = np.where(beyond.any(axis=1), beyond.argmax(axis=1), len(times))
    # The deepest look until the first beyond the limit, and closer and closer around it.
    until = np.where(np.arange(len(times)) < first[:, None], found, np.inf)
    rows = np.arange(n)
    deepest = times[np.minimum(until.argmin(axis=1), len(times) - 1)]
    least = until.min(axis=1)
    reach = LOOK
    dive = np.full(n, np.inf)
    for _ in range(4):
        near = np.clip(deepest[:, None] + reach * np.linspace(-1.0, 1.0, 41), after, HORIZON)
        around = seen(near)
        dive = np.minimum(dive, np.where(around < 0.0, near, np.inf).min(axis=1))
        deepest = near[rows, around.argmin(axis=1)]
        least = np.minimum(least, around.min(axis=1))
        reach /= 16.0
    # The crossing, between two looks.
    last = np.minimum(
        dive, np.where(first < len(times), times[np.minimum(first, len(times) - 1)], np.inf)
    )
    left = np.where(np.isfinite(last), last, np.nan)
    low = np.maximum(np.nan_to_num(left) - LOOK, after)
    high = np.nan_to_num(left)
    for _ in range(3):
        near = low[:, None] + (high - low)[:, None] * np.linspace(0.0, 1.0, 41)
        out = seen(near) < 0.0
        # The last look inside before the first one outside.
        index = np.where(out.any(axis=1), out.argmax(axis=1), 40)
        high = near[rows, index]
        low = near[rows, np.maximum(index - 1, 0)]
    return Truth(least, np.where(np.isfinite(last), high, np.inf))


def wrong_verdicts(
    criterion: Criterion, scenes: Scenes, map_: Judged, fine: Truth
) -> tuple[NDArray[np.intp], Floats]:
    """Bodies of which the map is wrong beyond what may graze; errors of times of leaving."""
    meets: Callable[[NDArray[np.bool_]], NDArray[np.bool_]] = (
        np.logical_not if isinstance(criterion, bounds.ReturnsNear) else np.asarray
    )
    kept = ~np.isfinite(fine.left)
    grazes = (np.abs(fine.least) < GRAZE) | (np.abs(fine.left - HORIZON) < GRAZE)
    wrong = (map_.stable != meets(kept)) & ~map_.undecided & ~grazes
    both = ~map_.stable & ~kept & ~map_.undecided & np.isfinite(map_.left)
    return np.flatnonzero(wrong), np.abs(map_.left[both] - fine.left[both])


def criteria(kind: str, rng: np.random.Generator) -> list[Criterion]:
    """Criteria of all kinds, with limits that some bodies pass and others do not."""

    def angle() -> float:
        return float(rng.uniform(0.05, 3.0))

    made: list[Criterion] = [
        rigid.rate_within(angle(), of=of, frame=frame)
        for of in ("omega", "L")
        for frame in ("space", "body")
        if not (kind == "free" and (of, frame) == ("L", "space"))
    ]
    made += [rigid.near_start(angle()), rigid.near_start(np.pi)]
    made += [rigid.returns(0.1 * angle(), after=float(rng.uniform(2.0, 9.0))) for _ in range(2)]
    made += [rigid.spin_above(float(rng.uniform(0.0, 0.5)), axis=axis) for axis in (None, 1, -2, 3)]
    if kind == "top":
        low, high = sorted(rng.uniform(0.0, np.pi, 2))
        made.append(rigid.tilt_between(float(low), float(high), axis=int(rng.choice([1, 2, -3]))))
    return made
