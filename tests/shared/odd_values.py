"""Odd but valid arguments of the library, and mistakes: the parts of the cases of ``fuzz.py``."""

from collections.abc import Callable, Sequence
from random import Random
from typing import Any

import numpy as np

import rigid
from physics import EVERY_METHOD, Floats
from rigid.model.scene import Scene

#: Share of the arguments of a case that a mistake replaces.
MISTAKES = 0.012


def decades(rng: Random, low: float, high: float) -> float:
    """A number whose logarithm to base 10 is uniform."""
    return float(10.0 ** rng.uniform(low, high))


def mistake(rng: Random) -> Any:
    """What no argument may be, and what some may not."""
    return rng.choice(
        [
            *(float("nan"), float("inf"), -float("inf"), -1.0, 0.0, -0.0, 5e-324, 1e308, -1e-320),
            *(10**400, -(2**63), 2**64, 10**5000, True, None, "", "x" * 300, "\ud800", b"\xff"),
            *([], [[]], {}, (), object(), 1j, [1.0, "2"], [[1.0], [2.0, 3.0]], range(3), Ellipsis),
            *(np.longdouble("1e400"), np.float32("nan"), np.datetime64("2020"), np.void(b"ab")),
            *(np.array([]), np.zeros((0, 3)), np.zeros((2, 2, 2)), np.array(None), np.ma.masked),
            *(np.ma.masked_invalid([1.0, np.nan, 2.0]), np.array(["a", "b", "c"]), np.array([1j])),
            *(np.array([1.0, 2.0, 3.0], dtype=object), np.array([b"1", b"2", b"3"])),
            *(np.full(3, np.longdouble("1e400")), np.array([10**400, 1, 1], dtype=object), max),
            *(lambda: None, rigid, rigid.Body, np.nan * np.ones(3), np.ones(10**5), [1e308] * 3),
        ]
    )


def perhaps(rng: Random, value: Any) -> Any:
    """The value, or a mistake."""
    return mistake(rng) if rng.random() < MISTAKES else value


def number(rng: Random, value: float) -> Any:
    """A number as other types have it, if they hold it."""
    kinds: list[Callable[[float], Any]] = [
        *(float, float, float, np.float64, np.array, np.longdouble, np.float32),
        *(lambda x: np.array(x, dtype=">f8"), lambda x: int(x) if x == int(x) else x),
    ]
    with np.errstate(all="ignore"):
        other = rng.choice(kinds)(value)
        held = bool(np.isfinite(other)) and (float(other) != 0.0) == (value != 0.0)
    return perhaps(rng, other if held else value)


def whole(rng: Random, value: int) -> Any:
    """A whole number of other types."""
    return perhaps(rng, rng.choice([int, int, np.int64, np.uint64])(value))


def array(rng: Random, values: Any) -> Any:
    """An array in another type, byte order or layout, with the same or nearly the same numbers."""
    plain = np.array(values, dtype=np.float64)
    if not plain.ndim or not plain.size:
        return perhaps(rng, plain.tolist())
    with np.errstate(all="ignore"):
        short = plain.astype(np.float32)
    holds = np.isfinite(short).all() and (short != 0).all()
    return perhaps(rng, short if holds and rng.random() < 0.08 else form(rng, plain))


def form(rng: Random, plain: Floats) -> Any:
    """The same numbers in another type, byte order or layout."""

    def strided(step: int) -> Floats:
        wide = np.repeat(plain, abs(step), axis=-1)
        return wide[..., ::step] if step > 0 else wide[..., ::-1][..., ::step]

    def unaligned() -> Floats:
        return np.frombuffer(b"x" + plain.tobytes(), dtype=np.float64, offset=1).reshape(
            plain.shape
        )

    def read_only() -> Floats:
        copy = plain.copy()
        copy.flags.writeable = False
        return copy

    makers: list[Callable[[], Any]] = [
        *(lambda: plain, plain.tolist, plain.tolist, lambda: plain.astype(">f8")),
        *(lambda: np.asfortranarray(plain), lambda: strided(2), lambda: strided(-3), read_only),
        *(unaligned, lambda: plain.astype(np.longdouble), lambda: np.ma.array(plain)),
    ]
    return rng.choice(makers)()


# Bodies and scenes


def moments(rng: Random) -> list[float]:
    """Of any body, over many decades; symmetric, flat and needle-like ones among them."""
    scale = decades(rng, -20, 20) if rng.random() < 0.3 else 1.0
    parts = [decades(rng, -12 if rng.random() < 0.1 else -1, 0) for _ in range(3)]
    if rng.random() < 0.2:
        parts[rng.randrange(3)] = 0.0
    if rng.random() < 0.4:
        parts[0] = parts[1] = max(parts[:2])
    a, b, c = (scale * part for part in parts)
    return [b + c, a + c, a + b]


def body(rng: Random) -> rigid.Body:
    """However its moments are known."""
    kind = rng.random()
    if kind < 0.7:
        mass = number(rng, decades(rng, -9, 9)) if rng.random() < 0.2 else None
        return rigid.Body(array(rng, moments(rng)), mass=mass)
    sides = [number(rng, decades(rng, -3, 3)) for _ in range(3)]
    mass = number(rng, decades(rng, -9, 9))
    if kind < 0.85:
        return rigid.Body.box(*sides, mass=mass)
    if kind < 0.92:
        return rigid.Body.ellipsoid(*sides, mass=mass)
    return rigid.Body.from_tensor(array(rng, np.diag(moments(rng))))[0]


def unit(rng: Random, size: int = 3) -> Floats:
    """A unit vector, often along an axis."""
    vector = np.array([rng.gauss(0.0, 1.0) for _ in range(size)])
    if rng.random() < 0.3:
        vector = np.eye(size)[rng.randrange(size)] * rng.choice([-1.0, 1.0])
    long: Floats = vector / np.linalg.norm(vector)
    return long


def torque(rng: Random, size: float, span: float) -> rigid.Torque:
    """In the body or in space, constant or a table, or a sum."""
    make = rng.choice([rigid.Torque.body, rigid.Torque.space])
    if rng.random() < 0.6:
        made = make(array(rng, size * unit(rng)))
    else:
        knots = sorted([-span, span, *(rng.uniform(-span, span) for _ in range(rng.randrange(4)))])
        if rng.random() < 0.3:
            knots.insert(1, knots[0] if len(knots) < 3 else knots[1])
        values = [size * unit(rng) for _ in knots]
        made = make(array(rng, values), times=array(rng, knots))
    return made + torque(rng, size, span) if rng.random() < 0.2 else made


def damping(rng: Random, size: float) -> Any:
    """One coefficient, three or a matrix."""
    kind = rng.random()
    if kind < 0.4:
        return number(rng, size)
    if kind < 0.7:
        return array(rng, [size * rng.choice([0.0, 1.0, decades(rng, -6, 0)]) for _ in range(3)])
    axis = unit(rng)
    return array(rng, size * np.outer(axis, axis))


def scene(rng: Random, *, constant: bool = False) -> Scene:
    """A free body or a top, with torque and damping or without."""
    made = body(rng)
    scale = max(made.moments)
    outside: dict[str, Any] = {}
    if rng.random() < 0.25:
        outside["damping"] = damping(rng, scale * decades(rng, -4, 2))
    if rng.random() < 0.25:
        known = torque(rng, scale * decades(rng, -4, 2), 1e12)
        if not constant or not known.times:
            outside["torque"] = known
    if rng.random() < 0.5:
        return rigid.FreeBody(made, **outside)
    mgl = number(rng, scale * rng.choice([0.0, 1.0, decades(rng, -6, 4)]))
    com = perhaps(rng, unit(rng).tolist()) if rng.random() < 0.5 else (0.0, 0.0, 1.0)
    return rigid.HeavyTop(made, mgl=mgl, com=com, **outside)


# Starts and options


def rates(rng: Random, count: int | None) -> Floats:
    """Angular velocities (rad/s), some of them zero or next to nothing."""
    size = rng.choice([1.0, 1.0, decades(rng, -6, 3)])
    values = np.array([rng.gauss(0.0, size) for _ in range(3 * (count or 1))])
    for k in range(len(values)):
        if rng.random() < 0.1:
            values[k] = rng.choice([0.0, -0.0, 1e-300, 1e-12 * size, size])
    shaped: Floats = values.reshape((3,) if count is None else (count, 3))
    return shaped


def attitude(rng: Random, count: int | None) -> Any:
    """None, quaternions of any length, or a SciPy rotation."""
    if rng.random() < 0.3:
        return None
    rows = count if count is not None and rng.random() < 0.5 else None
    values = np.array([unit(rng, 4) for _ in range(rows or 1)]) * rng.choice([1.0, -1.0, 1e-150, 7])
    values = values if rows is not None else values[0]
    if rng.random() < 0.1:
        from scipy.spatial.transform import Rotation

        return Rotation.from_quat(values)
    return array(rng, values)


def times(rng: Random, rate: float) -> list[float]:
    """Ascending times, most of them within some turns."""
    span = decades(rng, -3, 2) / rate
    low = -span if rng.random() < 0.2 else 0.0
    found = sorted(rng.uniform(low, span) for _ in range(rng.choice([0, 1, 1, 2, 3, 6])))
    if found and rng.random() < 0.2:
        found.append(found[-1])
    return [0.0, *found] if low == 0.0 and rng.random() < 0.3 else found


def fastest(made: Scene, omega: Floats) -> float:
    """About the rate of turning and swinging (rad/s)."""
    acting = np.abs(made.weight).max()
    if made.torque is not None:
        acting += np.abs([*made.torque.in_body, *made.torque.in_space]).max()
    size = max(made.body.moments)
    with np.errstate(over="ignore"):
        rate = float(np.abs(omega).max() + np.sqrt(acting / size))
    return rate if 1e-100 < rate < 1e100 else 1.0


def method(rng: Random, made: Scene, *, maps: bool = False) -> str | None:
    """A method that moves the scene, or none; seldom any word."""
    able = [
        one.name
        for one in EVERY_METHOD
        if (one.forces or not made.forces)
        and (one.tops or not made.directions)
        and (one.maps or not maps)
    ]
    chosen: Sequence[str | None] = [None, None, rng.choice(able)]
    word: str | None = perhaps(rng, rng.choice(chosen))
    return word
