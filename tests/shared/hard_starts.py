"""Starts that are hard on stated errors: free bodies and tops, near rest, saddles, separatrices."""

from dataclasses import dataclass

import numpy as np

import rigid
from physics import Floats
from rigid.model.scene import Scene

#: How output times lie.
PATTERNS = ("even", "random", "geometric", "clusters", "last")


@dataclass(frozen=True)
class Start:
    """A scene with a start; ``rate`` is about as fast as it turns or swings (rad/s)."""

    scene: Scene
    omega: Floats
    attitude: Floats
    rate: float
    longest: float = 300.0  # angle turned at this rate
    patterns: tuple[str, ...] = PATTERNS
    slowest: float = 3.3  # decades of the longest time, in units of the fastest damping

    @property
    def damping_rate(self) -> float:
        """Largest rate at which damping and drag slow the body (1/s)."""
        scene, rate = self.scene, 0.0
        if scene.damping is not None:
            rate += float(np.abs(scene.damping).max())
        if scene.drag is not None:
            rate += float(np.max(scene.drag) * np.linalg.norm(self.omega))
        return rate / min(scene.body.moments)


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
    """A top that hangs all but still."""
    body, tiny = rigid.Body(moments(rng)), decades(rng, -12.0, -1.0)
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


def many_turns(rng: np.random.Generator) -> Start:
    """A spin, steady or nearly: after many turns a phase may be wrong by whole ones."""
    shape = moments(rng)
    if rng.random() < 0.5:
        shape = np.array([1.0, 1.0, rng.uniform(0.1, 1.9)])
    omega = np.eye(3)[rng.integers(3)]
    omega = omega + decades(rng, -4.0, -0.5) * rng.normal(size=3) * rng.integers(0, 2)
    free = rigid.FreeBody(rigid.Body(shape))
    return Start(free, omega, rng.normal(size=4), 1.0, 1000.0, ("even", "last", "last"))
