"""Random runs that are hard on stated errors: scenes, starts, wanted times and methods.

Each is one of :data:`KINDS`. Angles and times are counted in the body's own unit of time, so that
the truth costs a bounded number of steps.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

import rigid
from physics import EVERY_METHOD, Floats
from rigid.model.scene import Scene

#: Most steps of any run: a body that needs more has a status that says so.
MAX_STEPS = 100_000

#: How wanted times lie.
PATTERNS = ("even", "random", "geometric", "clusters", "last")

#: Bodies of a large call: more than a sample of them.
CROWD = 40


@dataclass(frozen=True)
class Case:
    """A call of ``simulate``, the body of which that is judged, and where it came from."""

    kind: str
    scene: Scene
    omega: Floats
    attitude: Floats
    t: Floats
    options: Mapping[str, Any]
    others: Floats | None = None

    def run(self) -> tuple[rigid.Run, int | None]:
        """The run, and the row of the body in it; None for a single body."""
        options = {**self.options, "max_steps": MAX_STEPS, "threads": 1}
        if self.others is None:
            return rigid.simulate(self.scene, self.omega, self.attitude, t=self.t, **options), None
        row = len(self.others) // 2 + 1  # not among those that a sample of 32 takes
        rates = np.insert(self.others, row, self.omega, axis=0)
        return rigid.simulate(self.scene, rates, self.attitude, t=self.t, **options), row

    def code(self) -> str:
        """The call as code."""
        given = ", ".join(f"{name}={value!r}" for name, value in self.options.items())
        omega: Any = self.omega.tolist()
        if self.others is not None:
            omega = f"[... {omega} among {len(self.others)} others]"
        scene = repr(self.scene).replace("body=", "", 1)
        return f"simulate({scene}, {omega}, {self.attitude.tolist()}, t={self.t.tolist()}, {given})"


@dataclass(frozen=True)
class Start:
    """A scene with a start; ``rate`` is about as fast as it turns or swings (rad/s)."""

    scene: Scene
    omega: Floats
    attitude: Floats
    rate: float
    longest: float = 300.0  # angle turned at this rate
    patterns: tuple[str, ...] = PATTERNS

    @property
    def damping_rate(self) -> float:
        """Largest rate at which damping slows the body (1/s)."""
        if self.scene.damping is None:
            return 0.0
        return float(np.abs(self.scene.damping).max() / min(self.scene.body.moments))


# Parts


def decades(rng: np.random.Generator, low: float, high: float) -> float:
    """A number whose logarithm to base 10 is uniform."""
    return float(10.0 ** rng.uniform(low, high))


def direction(rng: np.random.Generator, axes: int = 3) -> Floats:
    """A unit vector."""
    v = rng.normal(size=axes)
    unit: Floats = v / np.linalg.norm(v)
    return unit


def moments(rng: np.random.Generator) -> Floats:
    """Of any body; of symmetric, nearly symmetric, nearly spherical, flat and needle-like ones."""
    parts = 10.0 ** rng.uniform(-1.5, 0.0, 3)
    shape = rng.choice(["any", "symmetric", "nearly", "sphere", "flat", "needle"], p=SHAPES)
    if shape == "symmetric":
        parts[1] = parts[0]
    elif shape == "nearly":
        parts[1] = parts[0] * (1.0 + decades(rng, -15.0, -2.0))
    elif shape == "sphere":
        parts = 1.0 + rng.normal(size=3) * decades(rng, -15.0, -2.0)
    elif shape == "flat":
        parts[2] = rng.choice([0.0, decades(rng, -16.0, -2.0)])
    elif shape == "needle":
        parts[:2] *= decades(rng, -8.0, -2.0)
    parts = rng.permutation(parts)
    found: Floats = parts.sum() - parts
    return found


SHAPES = (0.4, 0.15, 0.15, 0.1, 0.1, 0.1)


def turned_to(axis: Floats, tilt: float, azimuth: float) -> Floats:
    """An attitude in which a direction of the body is tilted from the vertical by an angle."""
    up = np.array([0.0, 0.0, 1.0])
    q = np.array([1.0 + axis[2], *np.cross(axis, up)])
    q = np.array([0.0, 1.0, 0.0, 0.0]) if np.linalg.norm(q) < 1e-8 else q / np.linalg.norm(q)
    half = 0.5 * tilt
    lean = np.array([np.cos(half), np.sin(half) * np.cos(azimuth), np.sin(half) * np.sin(azimuth)])
    return rigid.rotations.quaternion_product([*lean, 0.0], q)


def torque(rng: np.random.Generator, size: float, span: float) -> rigid.Torque:
    """In the body, in space or both; constant, or a table with jumps and pulses."""

    def one(make: Callable[..., rigid.Torque]) -> rigid.Torque:
        if rng.random() < 0.5:
            return make(size * direction(rng))
        knots = np.sort(rng.uniform(-span, span, int(rng.integers(0, 6))))
        knots = np.concatenate([[-span], np.repeat(knots, rng.integers(1, 3, len(knots))), [span]])
        if rng.random() < 0.3:  # a pulse
            at, width = rng.uniform(0.0, 0.9 * span), span * decades(rng, -6.0, -2.0)
            knots = np.array([-span, at, at, at + width, at + width, span])
        return make(size * rng.normal(size=(len(knots), 3)), times=knots)

    where = rng.choice(["body", "space", "both"])
    if where == "both":
        return one(rigid.Torque.body) + one(rigid.Torque.space)
    return one(rigid.Torque.body if where == "body" else rigid.Torque.space)


def damping(rng: np.random.Generator, strength: float) -> Any:
    """One coefficient, three, one axis, or a matrix of any rank."""
    kind = rng.choice(["all", "three", "one", "matrix"])
    if kind == "all":
        return strength
    if kind == "three":
        return strength * 10.0 ** rng.uniform(-6.0, 0.0, 3)
    if kind == "one":
        return strength * np.eye(3)[rng.integers(3)]
    rows = rng.normal(size=(int(rng.integers(1, 4)), 3))
    matrix = rows.T @ (rows * 10.0 ** rng.uniform(-4.0, 0.0, (len(rows), 1)))
    matrix = 0.5 * (matrix + matrix.T)
    return strength * matrix / np.abs(matrix).max()


def swing(top: rigid.HeavyTop) -> float:
    """About the rate of small swings (rad/s)."""
    return float(np.sqrt(top.mgl / np.median(top.body.moments)))


# Kinds


def anything(rng: np.random.Generator) -> Start:
    """Any free body or top, also about a principal axis, any start."""
    body = rigid.Body(moments(rng))
    omega = rng.normal(size=3) * decades(rng, -1.0, 1.0)
    attitude = rng.normal(size=4)
    if rng.random() < 0.4:
        return Start(rigid.FreeBody(body), omega, attitude, float(np.linalg.norm(omega)))
    com = direction(rng) if rng.random() < 0.6 else np.eye(3)[2]
    top = rigid.HeavyTop(body, mgl=decades(rng, -1.0, 1.0), com=com)
    return Start(top, omega, attitude, float(np.linalg.norm(omega)) + swing(top))


def near_rest(rng: np.random.Generator) -> Start:
    """A top that hangs all but still, or a body at rest that a weak torque moves."""
    body, tiny = rigid.Body(moments(rng)), decades(rng, -12.0, -1.0)
    if rng.random() < 0.25:
        size = decades(rng, -9.0, 0.0)
        span = decades(rng, -1.0, 1.5) / np.sqrt(size)
        driven = rigid.FreeBody(body, torque=torque(rng, size, 1.01 * span))
        omega = np.sqrt(size) * tiny * rng.normal(size=3) * rng.integers(0, 2)
        return Start(driven, omega, rng.normal(size=4), float(np.sqrt(size)), 30.0)
    com = direction(rng) if rng.random() < 0.7 else np.eye(3)[rng.integers(3)]
    top = rigid.HeavyTop(body, mgl=decades(rng, -1.0, 1.0), com=com)
    attitude = turned_to(com, np.pi - tiny * rng.normal(), rng.uniform(0.0, 7.0))
    omega = tiny * swing(top) * rng.normal(size=3) * rng.integers(0, 2)
    return Start(top, omega, attitude, swing(top))


def saddle(rng: np.random.Generator) -> Start:
    """A symmetric top, or a pendulum, that all but comes to rest upright."""
    first, mgl = decades(rng, -0.3, 0.3), decades(rng, -0.5, 0.5)
    third = first * rng.uniform(0.1, 1.9)
    tilt, off = rng.uniform(0.05, 3.0), rng.choice([0.0, decades(rng, -16.0, -1.0)])
    spin = rng.choice([0.0, rng.uniform(-1.0, 1.0)]) * 1.9 * np.sqrt(mgl * first) / third
    advance = third * spin * (1.0 - np.cos(tilt)) / (first * np.sin(tilt) ** 2)
    square = 2.0 * mgl * (1.0 - np.cos(tilt)) / first - (advance * np.sin(tilt)) ** 2
    if square < 0.0:
        return saddle(rng)
    fall = np.sqrt(square) * (1.0 + off * rng.choice([-1.0, 1.0])) * rng.choice([-1.0, 1.0])
    omega = np.array([fall, advance * np.sin(tilt), spin])
    attitude = np.array([np.cos(0.5 * tilt), np.sin(0.5 * tilt), 0.0, 0.0])
    shape = (first, first, third)
    if spin == 0.0 and rng.random() < 0.5:
        shape = (first, abs(first - third) + 0.9 * min(first, third), third)
    top = rigid.HeavyTop(rigid.Body(shape), mgl=mgl)
    return Start(top, omega, attitude, swing(top) + abs(float(spin)), 60.0)


def separatrix(rng: np.random.Generator) -> Start:
    """A free body near its separatrix, or near an axis."""
    shape = np.sort(moments(rng))
    omega = rng.normal(size=3)
    off = decades(rng, -9.0, -1.0)
    i1, i2, i3 = shape
    if rng.random() < 0.5 or i2 - i1 < 1e-3 * i2:
        omega = off * omega
        omega[rng.integers(3)] = rng.choice([-1.0, 1.0])
    else:
        omega[0] = omega[2] * np.sqrt(i3 * (i3 - i2) / (i1 * (i2 - i1)))
        omega[0] *= 1.0 + off * rng.choice([-1.0, 1.0])
    omega *= decades(rng, -1.0, 1.0)
    order = rng.permutation(3)
    body = rigid.FreeBody(rigid.Body(shape[order]))
    return Start(body, omega[order], rng.normal(size=4), float(np.linalg.norm(omega)), 100.0)


def upright(rng: np.random.Generator) -> Start:
    """A top upright to rounding or nearly, at rest, or spinning nearly as fast as it must."""
    body = rigid.Body(moments(rng))
    com = direction(rng) if rng.random() < 0.6 else np.eye(3)[2]
    tilt = rng.choice([0.0, decades(rng, -16.0, -1.0)])
    mgl = decades(rng, -1.0, 1.0)
    top = rigid.HeavyTop(body, mgl=mgl, com=com)
    omega = np.zeros(3)
    if rng.random() < 0.6:
        about = float((com**2) @ np.array(body.moments))
        limit = 2.0 * np.sqrt(mgl * np.median(body.moments)) / about
        omega = limit * (1.0 + decades(rng, -6.0, 0.0) * rng.choice([-1.0, 1.0])) * com
    attitude = turned_to(com, tilt, rng.uniform(0.0, 7.0))
    return Start(top, omega, attitude, swing(top) + float(np.linalg.norm(omega)), 60.0)


def damped(rng: np.random.Generator) -> Start:
    """Damping of any strength, with or without a torque and weight."""
    body = rigid.Body(moments(rng))
    fast = decades(rng, -1.0, 1.5)
    omega = fast * rng.normal(size=3)
    strength = decades(rng, rng.choice([-3.0, 1.0]), 4.0)
    outside: dict[str, Any] = {"damping": damping(rng, strength)}
    rate = fast
    if rng.random() < 0.5:
        size = decades(rng, -2.0, 0.0) * (strength * fast + fast**2)
        outside["torque"] = torque(rng, size, 1e3 / fast)
        rate += float(min(size / strength, np.sqrt(size / min(body.moments))))
    if rng.random() < 0.5:
        free = rigid.FreeBody(body, **outside)
        return Start(free, omega, rng.normal(size=4), rate, 100.0, LAYERS)
    com = direction(rng) if rng.random() < 0.6 else np.eye(3)[2]
    top = rigid.HeavyTop(body, mgl=decades(rng, -1.0, 1.0), com=com, **outside)
    return Start(top, omega, rng.normal(size=4), rate + swing(top), 100.0, LAYERS)


#: Times in the first layer of a damped motion, where damping acts and steps do not follow.
LAYERS = ("geometric", "geometric", "clusters", "clusters", *PATTERNS)


def driven(rng: np.random.Generator) -> Start:
    """Torques in the body and in space, with little damping or none."""
    body = rigid.Body(moments(rng))
    omega = rng.normal(size=3) * decades(rng, -1.0, 1.0)
    rate = float(np.linalg.norm(omega))
    size = rate**2 * decades(rng, -2.0, 0.5) * float(np.median(body.moments))
    outside: dict[str, Any] = {"torque": torque(rng, size, 120.0 / rate)}
    if rng.random() < 0.4:
        outside["damping"] = damping(rng, decades(rng, -4.0, -0.5) * rate)
    rate += float(np.sqrt(size / min(body.moments)))
    if rng.random() < 0.5:
        return Start(rigid.FreeBody(body, **outside), omega, rng.normal(size=4), rate, 100.0)
    top = rigid.HeavyTop(body, mgl=decades(rng, -1.0, 1.0), com=direction(rng), **outside)
    return Start(top, omega, rng.normal(size=4), rate + swing(top), 100.0)


def many_turns(rng: np.random.Generator) -> Start:
    """A spin, steady or nearly: after many turns a phase may be wrong by whole ones."""
    shape = moments(rng)
    if rng.random() < 0.5:
        shape = np.array([1.0, 1.0, rng.uniform(0.1, 1.9)])
    omega = np.eye(3)[rng.integers(3)]
    omega = omega + decades(rng, -4.0, -0.5) * rng.normal(size=3) * rng.integers(0, 2)
    free = rigid.FreeBody(rigid.Body(shape))
    return Start(free, omega, rng.normal(size=4), 1.0, 1000.0, ("even", "last", "last"))


def satellite(rng: np.random.Generator) -> Start:
    """A rotor, a sink and an orbit, one or some of them, with or without torque and damping."""
    shape = moments(rng)
    body = rigid.Body(shape)
    omega = rng.normal(size=3) * decades(rng, -1.0, 1.0)
    rate = float(np.linalg.norm(omega))
    outside: dict[str, Any] = {}
    acts = rng.random(3) < 0.55
    acts[rng.integers(3)] = True
    longest = 100.0
    if acts[0]:
        rotor = direction(rng) * decades(rng, -3.0, 1.0) * rate * float(np.median(shape))
        outside["rotor"] = rotor
        rate += float(np.linalg.norm(rotor)) / min(shape)
    if acts[1]:
        size = decades(rng, -4.0, -0.5) * float(min(shape)) / rate
        each = rng.random(3) if rng.random() < 0.5 else np.ones(3)
        outside["dissipation"] = rigid.EnergySink(size * each)
    if acts[2]:
        normal, other = direction(rng), rng.normal(size=3)
        towards = np.cross(normal, other) / np.linalg.norm(np.cross(normal, other))
        speed = decades(rng, -3.0, 0.5) * rate
        outside["torque"] = rigid.Torque.gravity_gradient(
            rate=speed, normal=normal, towards=towards
        )
        rate += 2.0 * speed
    if rng.random() < 0.25:
        own = torque(rng, rate**2 * decades(rng, -3.0, -0.5), 120.0 / rate)
        outside["torque"] = own + outside["torque"] if "torque" in outside else own
    if rng.random() < 0.25:
        outside["damping"] = damping(rng, decades(rng, -4.0, -1.0) * rate)
    return Start(rigid.FreeBody(body, **outside), omega, rng.normal(size=4), rate, longest)


Kinds: TypeAlias = Mapping[str, tuple[float, Callable[[np.random.Generator], Start]]]

SATELLITES: Kinds = {"satellite": (1.0, satellite)}

KINDS: Kinds = {
    "anything": (0.16, anything),
    "near rest": (0.12, near_rest),
    "saddle": (0.12, saddle),
    "separatrix": (0.08, separatrix),
    "upright": (0.10, upright),
    "damped": (0.22, damped),
    "driven": (0.12, driven),
    "many turns": (0.08, many_turns),
}


# Times and methods


def wanted(rng: np.random.Generator, start: Start, *, short: bool) -> Floats:
    """Times of the states: even, random, geometric, in clusters, one alone, some negative."""
    low, high = (-1.3, 0.3) if short else (-0.5, float(np.log10(start.longest)))
    span = decades(rng, low, high) / start.rate
    slowed = start.damping_rate
    if slowed > 0.0:
        span = min(span, decades(rng, -1.0, 3.3) / slowed)
    count = int(rng.integers(1, 30))
    pattern = rng.choice(start.patterns)
    if pattern == "even":
        t = np.linspace(0.0, span, count + 1)
    elif pattern == "random":
        t = np.sort(rng.uniform(0.0, span, count))
    elif pattern == "geometric":
        t = np.geomspace(span * decades(rng, -7.0, -1.0), span, count + 1)
    elif pattern == "clusters":
        centres = span * rng.uniform(0.0, 1.0, int(rng.integers(1, 4)))
        widths = span * 10.0 ** rng.uniform(-7.0, -2.0, count + 1)
        t = np.sort(rng.choice(centres, count + 1) + widths)
    else:
        t = np.array([span])
    if rng.random() < 0.1:
        t = np.sort(np.append(t, t[rng.integers(len(t))]))
    if rng.random() < 0.12 and slowed * span < 3.0:
        t = np.sort(np.where(rng.random(len(t)) < 0.5, -t, t)) + 0.0
    reach = start.scene.torque.times if start.scene.torque else ()
    return np.clip(t, reach[0], reach[-1]) if reach else t


def random_case(rng: np.random.Generator, kinds: Kinds = KINDS) -> Case:
    """One of the kinds, with a method and what is asked of it."""
    kind = str(rng.choice(list(kinds), p=[weight for weight, _ in kinds.values()]))
    start = kinds[kind][1](rng)
    scene = start.scene
    able = [
        one
        for one in EVERY_METHOD
        if (one.driven or not scene.is_driven)
        and (one.tops or not scene.directions)
        and (one.satellite or not scene.is_satellite)
    ]
    options: dict[str, Any] = {}
    mode = rng.choice(["default", "method", "step", "tolerance"], p=[0.3, 0.35, 0.15, 0.2])
    asked = float(rng.choice([1e-6, 1e-9, decades(rng, -11.0, -2.0)]))
    if mode in ("default", "method") and rng.random() < 0.6:
        options["accuracy"] = asked
    if mode == "tolerance":
        able = [one for one in able if one.series]
        options["tolerance"] = decades(rng, -14.0, -2.0)
    if mode != "default":
        options["method"] = able[rng.integers(len(able))].name
    if mode == "step":
        options["step"] = decades(rng, -1.5, 0.5) / start.rate
    record = str(rng.choice(["attitude", "axis", "rates"], p=[0.7, 0.15, 0.15]))
    if record != "attitude":
        options["record"] = record
    t = wanted(rng, start, short=mode == "tolerance" and rng.random() < 0.5)
    others = None
    if mode != "tolerance" and rng.random() < 0.04:
        others = start.omega + 1e-3 * start.rate * rng.normal(size=(CROWD, 3))
        if rng.random() < 0.5:  # calm ones
            others = np.broadcast_to(np.eye(3)[2] * np.linalg.norm(start.omega), (CROWD, 3)).copy()
    return Case(kind, scene, start.omega, start.attitude, t, options, others)
