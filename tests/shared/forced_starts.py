"""Starts under forces that are hard on stated errors: one force each, strong damping, several."""

from collections.abc import Callable
from typing import Any

import numpy as np

import quad_motion
import rigid
from hard_starts import PATTERNS, Start, decades, direction, moments, swing
from physics import Floats, quaternion_product

#: Times in the first layer of a damped motion, where damping acts and steps do not follow.
LAYERS = ("geometric", "geometric", "clusters", "clusters", *PATTERNS)

MakesTorque = Callable[..., rigid.Torque]


# Parts


def constant_or_table(
    rng: np.random.Generator, make: MakesTorque, size: float, span: float
) -> rigid.Torque:
    """Constant, or a table with jumps and pulses."""
    if rng.random() < 0.5:
        return make(size * direction(rng))
    return table(rng, make, size, span)


def table(rng: np.random.Generator, make: MakesTorque, size: float, span: float) -> rigid.Torque:
    """A table over both signs of time: some knots with jumps, or a pulse."""
    knots = np.sort(rng.uniform(-span, span, int(rng.integers(0, 6))))
    knots = np.concatenate([[-span], np.repeat(knots, rng.integers(1, 3, len(knots))), [span]])
    if rng.random() < 0.3:  # a pulse
        at, width = rng.uniform(0.0, 0.9 * span), span * decades(rng, -6.0, -2.0)
        knots = np.array([-span, at, at, at + width, at + width, span])
    return make(size * rng.normal(size=(len(knots), 3)), times=knots)


def torque(rng: np.random.Generator, size: float, span: float) -> rigid.Torque:
    """In the body, in space or both."""
    where = rng.choice(["body", "space", "both"])
    made = [
        constant_or_table(rng, make, size, span)
        for name, make in (("body", rigid.Torque.body), ("space", rigid.Torque.space))
        if where in (name, "both")
    ]
    return made[0] if len(made) == 1 else made[0] + made[1]


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


def full_matrix(rng: np.random.Generator, strength: float) -> Floats:
    """Damping in directions that are no axes: at all rates, or one slow or undamped direction."""
    own = rng.choice(["any", "slow", "fast"])
    sizes = 10.0 ** rng.uniform(-4.0, 0.0, 3)
    if own == "slow":
        sizes = np.array([1.0, rng.uniform(0.1, 1.0), rng.choice([0.0, decades(rng, -8.0, -1.0)])])
    elif own == "fast":
        sizes = np.array([1.0, *(rng.choice([0.0, decades(rng, -8.0, -1.0)], 2))])
    turned = rigid.rotations.quaternion_to_matrix(rng.normal(size=4))
    matrix = turned @ np.diag(sizes) @ turned.T
    # The smallest size may have become less than zero by rounding: it is made zero or more.
    symmetric: Floats = 0.5 * strength * (matrix + matrix.T) + 1e-15 * strength * np.eye(3)
    return symmetric


def heavy(rng: np.random.Generator, body: rigid.Body, **acting: Any) -> rigid.HeavyTop:
    """A top with its centre of mass anywhere or on the third axis."""
    com = direction(rng) if rng.random() < 0.6 else np.eye(3)[2]
    return rigid.HeavyTop(body, mgl=decades(rng, -1.0, 1.0), com=com, **acting)


def near_axis(rng: np.random.Generator, off: float) -> Floats:
    """A unit vector along an axis, so far off that it leans in all directions, or not off."""
    vector: Floats = np.eye(3)[rng.integers(3)] + off * rng.normal(size=3) * rng.integers(0, 2)
    return vector


def rates(rng: np.random.Generator) -> Floats:
    """Of any direction and size, along an axis or nearly."""
    size = decades(rng, -1.0, 1.0)
    if rng.random() < 0.3:
        return size * near_axis(rng, decades(rng, -12.0, -1.0))
    return size * rng.normal(size=3)


# One force each


def pushed(rng: np.random.Generator, make: MakesTorque) -> Start:
    """A table of torques, a third of them weak ones that move a body at rest."""
    body, omega = rigid.Body(moments(rng)), rates(rng)
    rate = float(np.linalg.norm(omega))
    if rng.random() < 0.3:
        size = decades(rng, -9.0, 0.0)
        span = decades(rng, -1.0, 1.5) / np.sqrt(size)
        omega = np.sqrt(size) * decades(rng, -12.0, -1.0) * omega * rng.integers(0, 2)
        free = rigid.FreeBody(body, torque=table(rng, make, size, 1.01 * span))
        return Start(free, omega, rng.normal(size=4), float(np.sqrt(size)), 30.0)
    size = rate**2 * decades(rng, -3.0, 0.5) * float(np.median(body.moments))
    acting: dict[str, Any] = {"torque": table(rng, make, size, 320.0 / rate)}
    rate += float(np.sqrt(size / min(body.moments)))
    if rng.random() < 0.6:
        return Start(rigid.FreeBody(body, **acting), omega, rng.normal(size=4), rate)
    top = heavy(rng, body, **acting)
    return Start(top, omega, rng.normal(size=4), rate + swing(top), 100.0)


def table_in_body(rng: np.random.Generator) -> Start:
    """A table of torques in the body."""
    return pushed(rng, rigid.Torque.body)


def table_in_space(rng: np.random.Generator) -> Start:
    """A table of torques in space."""
    return pushed(rng, rigid.Torque.space)


def drag(rng: np.random.Generator) -> Start:
    """Quadratic drag alone, with a torque that may stop the body, or with weight."""
    body, omega = rigid.Body(moments(rng)), rates(rng)
    rate, middle = float(np.linalg.norm(omega)), float(np.median(body.moments))
    coefficients = decades(rng, -3.0, 0.7) * middle * np.ones(3)
    if rng.random() < 0.5:
        coefficients *= 10.0 ** rng.uniform(-4.0, 0.0, 3) * (rng.random(3) < 0.7)
        coefficients[rng.integers(3)] += 1e-3 * middle
    acting: dict[str, Any] = {"drag": coefficients}
    beside = rng.choice(["nothing", "torque", "weight"], p=[0.4, 0.3, 0.3])
    if beside == "weight":
        top = heavy(rng, body, **acting)
        omega = omega * rng.integers(0, 2)
        attitude = rng.normal(size=4)
        if rng.random() < 0.3:  # it swings in a plane, and stops at each turn
            axis = rng.integers(3)
            com = np.eye(3)[(axis + 1) % 3]
            top = rigid.HeavyTop(body, mgl=top.mgl, com=com, **acting)
            attitude = np.eye(4)[0] + rng.normal() * np.eye(4)[1]
            omega = omega * (np.eye(3)[axis])
        return Start(top, omega, attitude, float(np.linalg.norm(omega)) + swing(top), 60.0)
    if beside == "torque":
        size = rate**2 * decades(rng, -2.0, 0.5) * middle
        acting["torque"] = constant_or_table(rng, rigid.Torque.body, size, 320.0 / rate)
        if rng.random() < 0.5:  # the body stops and turns back
            acting["torque"] = rigid.Torque.body(-size * omega / rate)
        rate += float(np.sqrt(size / min(body.moments)))
    return Start(rigid.FreeBody(body, **acting), omega, rng.normal(size=4), rate, 200.0)


def orbit(rng: np.random.Generator, rate: float, e: float = 0.0) -> rigid.Orbit:
    """An orbit in any plane."""
    normal, other = direction(rng), rng.normal(size=3)
    periapsis = np.cross(normal, other) / np.linalg.norm(np.cross(normal, other))
    anomaly = float(rng.uniform(-np.pi, np.pi)) if e else 0.0
    return rigid.Orbit(rate, e, anomaly, normal, periapsis)


def on_orbit(rng: np.random.Generator) -> Start:
    """An orbit: tumbling, slow, or near a relative equilibrium of a circle, stable or not."""
    body, speed = rigid.Body(moments(rng)), decades(rng, -1.0, 1.0)
    if rng.random() < 0.5:
        omega = rates(rng)
        speed *= float(np.linalg.norm(omega)) * decades(rng, -2.0, 0.3)
        rate = float(np.linalg.norm(omega)) + 2.0 * speed
        e = float(rng.uniform(0.0, 0.95)) if rng.random() < 0.5 else 0.0
        acting: dict[str, Any] = {"orbit": orbit(rng, speed, e)}
        if rng.random() < 0.2:
            acting["rotor"] = float(np.median(body.moments)) * rates(rng)
        if rng.random() < 0.2:
            acting["dissipation"] = rigid.EnergySink(decades(rng, -3.0, -1.0) * min(body.moments))
        rate += 2.0 * speed * ((1.0 + e) ** 0.5 * (1.0 - e) ** -1.5 - 1.0)
        return Start(rigid.FreeBody(body, **acting), omega, rng.normal(size=4), rate)
    around = orbit(rng, speed)
    columns = around.frame(0.0)
    order = rng.permutation(3)
    signs = rng.choice([-1.0, 1.0], 3)
    frame = columns[:, order] * signs
    frame[:, 2] = np.cross(frame[:, 0], frame[:, 1])
    attitude = rigid.rotations.matrix_to_quaternion(frame)
    off = rng.choice([0.0, decades(rng, -16.0, -1.0)])
    attitude = quaternion_product(attitude, np.array([1.0, *(off * rng.normal(size=3))]))
    omega = frame.T @ columns[:, 2] * speed + off * speed * rng.normal(size=3)
    scene = rigid.FreeBody(body, orbit=around)
    return Start(scene, omega, attitude, 2.0 * speed, 200.0)


def rotor(rng: np.random.Generator) -> Start:
    """A gyrostat: any rotation, a steady one, nearly a steady one."""
    shape, omega = moments(rng), rates(rng)
    rate = float(np.linalg.norm(omega))
    own = decades(rng, -3.0, 1.0) * rate * float(np.median(shape))
    wheel = own * (direction(rng) if rng.random() < 0.7 else near_axis(rng, 0.0))
    if rng.random() < 0.4:  # the whole momentum is along the rates
        wheel = rng.uniform(-3.0, 3.0) * float(np.median(shape)) * omega - shape * omega
        off = rng.choice([0.0, decades(rng, -16.0, -1.0)])
        omega = omega + off * rate * rng.normal(size=3)
    rate += float(np.linalg.norm(wheel)) / min(shape)
    scene = rigid.FreeBody(rigid.Body(shape), rotor=wheel)
    return Start(scene, omega, rng.normal(size=4), rate)


def energy_sink(rng: np.random.Generator) -> Start:
    """Internal dissipation on the way to the flat spin, weak and as strong as the law allows."""
    shape, omega = moments(rng), rates(rng)
    rate = float(np.linalg.norm(omega))
    if rng.random() < 0.3:  # about the axis of the least moment, which is unstable now
        axis = np.eye(3)[shape.argmin()]
        omega = rate * (axis + decades(rng, -12.0, -1.0) * rng.normal(size=3))
    size = decades(rng, -4.0, -0.3) * float(min(shape)) / rate
    each = rng.random(3) if rng.random() < 0.5 else np.ones(3)
    acting: dict[str, Any] = {"dissipation": rigid.EnergySink(size * each)}
    if rng.random() < 0.2:
        acting["rotor"] = direction(rng) * decades(rng, -2.0, 0.0) * rate * float(np.median(shape))
        rate += float(np.linalg.norm(acting["rotor"])) / min(shape)
    return Start(rigid.FreeBody(rigid.Body(shape), **acting), omega, rng.normal(size=4), rate)


def beside_a_function(
    rng: np.random.Generator, body: rigid.Body, rate: float
) -> tuple[dict[str, Any], float]:
    """Further forces, each with a chance, and how much faster a body may turn by them."""
    acting: dict[str, Any] = {}
    middle, faster = float(np.median(body.moments)), 0.0
    if rng.random() < 0.3:
        acting["rotor"] = direction(rng) * decades(rng, -2.0, 0.0) * rate * middle
        faster += float(np.linalg.norm(acting["rotor"])) / min(body.moments)
    if rng.random() < 0.3:
        acting["drag"] = decades(rng, -3.0, -0.3) * middle * np.ones(3)
    if rng.random() < 0.3:
        acting["dissipation"] = rigid.EnergySink(
            decades(rng, -4.0, -1.0) * min(body.moments) / rate
        )
    if rng.random() < 0.4:
        speed, e = rate * decades(rng, -2.0, 0.0), float(rng.choice([0.0, rng.uniform(0.0, 0.6)]))
        acting["orbit"] = orbit(rng, speed, e)
        faster += 5.0 * speed * (1.0 + e) ** 0.5 * (1.0 - e) ** -1.5
    return acting, faster


def function(rng: np.random.Generator) -> Start:
    """The torque of a function of time, rates and attitude, of which a bound is known or not."""
    body, omega = rigid.Body(moments(rng)), rates(rng)
    rate, least = float(np.linalg.norm(omega)), min(body.moments)
    size = rate**2 * float(np.median(body.moments))
    acts = rng.random(3) < 0.6
    acts[rng.integers(3)] = True
    varying = decades(rng, -1.0, 0.7) * rate
    push = acts[0] * decades(rng, -3.0, 0.3) * size * direction(rng)
    cubic = acts[1] * decades(rng, -3.0, -0.3) * float(np.median(body.moments)) / rate
    dipole, field = direction(rng), acts[2] * decades(rng, -3.0, 0.3) * size * direction(rng)
    numbers = [*push, varying, *(cubic * rng.random(3)), *dipole, *field]
    strength = float(np.linalg.norm(push) + np.linalg.norm(field))
    longest = 100.0
    reached = rate * np.sqrt(max(body.moments) / least) + strength / least * longest / rate
    acting: dict[str, Any] = {}
    is_free, faster = rng.random() < 0.6, 0.0
    if is_free and rng.random() < 0.5:
        acting, faster = beside_a_function(rng, body, rate)
    fastest = (
        min(reached + varying + faster, 30.0 * (rate + faster)) if rng.random() < 0.6 else None
    )
    acting["torque"] = rigid.Torque.call(quad_motion.called(), numbers, fastest=fastest)
    rate += float(np.sqrt(strength / least)) + varying + faster
    if is_free:
        return Start(rigid.FreeBody(body, **acting), omega, rng.normal(size=4), rate, longest)
    top = heavy(rng, body, **acting)
    return Start(top, omega, rng.normal(size=4), rate + swing(top), longest)


# Damping


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
    top = heavy(rng, body, **outside)
    return Start(top, omega, rng.normal(size=4), rate + swing(top), 100.0, LAYERS)


def strongly_damped(rng: np.random.Generator) -> Start:
    """Damping much faster than the turning, by full matrices, from rates about one axis or all."""
    body = rigid.Body(moments(rng))
    fast = decades(rng, -1.0, 1.0)
    omega = fast * (near_axis(rng, 0.0) if rng.random() < 0.4 else rng.normal(size=3))
    strength = decades(rng, 1.0, 5.0) * fast * float(np.median(body.moments))
    full = full_matrix(rng, strength)
    outside: dict[str, Any] = {"damping": full if rng.random() < 0.8 else damping(rng, strength)}
    if rng.random() < 0.3:
        outside["torque"] = torque(rng, decades(rng, -3.0, 0.0) * strength * fast, 1e3 / fast)
    attitude = rng.normal(size=4)
    if rng.random() < 0.6:
        free = rigid.FreeBody(body, **outside)
        return Start(free, omega, attitude, fast, 100.0, LAYERS, 4.0)
    top = heavy(rng, body, **outside)
    return Start(top, omega, attitude, fast + swing(top), 100.0, LAYERS, 4.0)


# Several forces


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


def satellite(rng: np.random.Generator) -> Start:
    """Some of a rotor, a sink, drag and an orbit, with or without torque and damping."""
    shape = moments(rng)
    body = rigid.Body(shape)
    omega = rng.normal(size=3) * decades(rng, -1.0, 1.0)
    rate = float(np.linalg.norm(omega))
    outside: dict[str, Any] = {}
    acts = rng.random(4) < 0.5
    acts[rng.integers(4)] = True
    if acts[0]:
        wheel = direction(rng) * decades(rng, -3.0, 1.0) * rate * float(np.median(shape))
        outside["rotor"] = wheel
        rate += float(np.linalg.norm(wheel)) / min(shape)
    if acts[1]:
        size = decades(rng, -4.0, -0.5) * float(min(shape)) / rate
        each = rng.random(3) if rng.random() < 0.5 else np.ones(3)
        outside["dissipation"] = rigid.EnergySink(size * each)
    if acts[2]:
        speed = decades(rng, -3.0, 0.5) * rate
        outside["orbit"] = orbit(rng, speed)
        rate += 2.0 * speed
    if acts[3]:
        outside["drag"] = decades(rng, -3.0, 0.0) * float(np.median(shape)) * rng.random(3)
    if rng.random() < 0.25:
        outside["torque"] = torque(rng, rate**2 * decades(rng, -3.0, -0.5), 120.0 / rate)
    if rng.random() < 0.25:
        outside["damping"] = damping(rng, decades(rng, -4.0, -1.0) * rate)
    return Start(rigid.FreeBody(body, **outside), omega, rng.normal(size=4), rate, 100.0)
