"""Ways to ask for motions, of many bodies that differ, for the tests of equal bits.

A door is asked for some of the bodies of a scene, in units of mass and of time. It returns the
arrays of each body.
"""

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

import rigid
from physics import METHODS, Floats, moves
from rigid.model.scene import Scene
from rigid.solve.columns import Column

COUNT = 69
"""More than two groups of 32, and no pack of eight full."""

_rng = np.random.default_rng(5)
MOMENTS = np.sort(_rng.uniform(1.0, 1.9, (COUNT, 3)), axis=1)
MOMENTS[::5, 1] = MOMENTS[::5, 0]  # symmetric
MOMENTS *= 10.0 ** _rng.integers(-3, 4, (COUNT, 1))  # from grams to tons
SIZE, SHARES = MOMENTS[:, 0], _rng.uniform(0.1, 1.0, COUNT)
OMEGA = _rng.normal(size=(COUNT, 3)) * 10.0 ** _rng.uniform(-1.5, 0.5, (COUNT, 1))
ATTITUDE = _rng.normal(size=(COUNT, 4))
SOME = np.arange(COUNT) % 3 != 0
"""Bodies on which a force acts that does not act on the others."""

AXES = np.where(SOME[:, None], _rng.normal(size=(COUNT, 3)), [0.0, 0.0, 1.0])
AXES /= np.linalg.norm(AXES, axis=1, keepdims=True)
TIMES = np.array([-0.3, 0.0, 0.5, 1.0])
OWN_TIMES = np.sort(_rng.uniform(-0.3, 1.0, (COUNT, 4)), axis=1)
OWN_TIMES[3] = [-0.2, -0.2, 0.0, 0.0]

Scenes = Callable[[float, float], Scene]


def _one(moments: tuple[float, float, float], mass: float) -> rigid.Body:
    return rigid.Body(tuple(mass * moment for moment in moments))


def _many(mass: float) -> rigid.Body:
    return rigid.Body(mass * MOMENTS)


def _damping(mass: float, time: float) -> Floats:
    rates: Floats = np.where(SOME, SHARES, 0.0)[:, None] * SIZE[:, None] * [1.0, 0.5, 0.2]
    return mass / time * rates


def _driven(mass: float, time: float) -> Scene:
    unit = mass / time**2
    table = unit * AXES[:, None] * SIZE[:, None, None] * [[0.0], [0.2], [0.1]]
    pushed = unit * np.where(SOME, SIZE, 0.0)[:, None] * [0.1, 0.0, 0.2]
    torque = rigid.Torque.body(table, times=time * np.array([-2.0, 0.5, 6.0]))
    return rigid.HeavyTop(
        _many(mass),
        mgl=unit * SHARES * SIZE,
        com=AXES,
        damping=_damping(mass, time),
        torque=torque + rigid.Torque.space(pushed),
    )


def _of_each_strength(mass: float, time: float) -> Scene:
    """Bodies that nothing slows, that are slowed weakly, evenly, and within a short step."""
    axes = np.broadcast_to(np.eye(3), (COUNT, 3, 3)) * SIZE[:, None, None]
    strengths = np.choose(np.arange(COUNT) % 4, [0.0, 0.1, 0.2, 6.0])[:, None, None]
    even = MOMENTS[:, None] / SIZE[:, None, None]
    uneven = np.where((np.arange(COUNT) % 4 == 2)[:, None, None], even, [1.0, 1.8, 1.6])
    return rigid.FreeBody(_many(mass), damping=mass / time * strengths * axes * uneven)


def _satellites(mass: float, time: float) -> Scene:
    some, others = (np.where(which, SIZE, 0.0)[:, None] for which in (SOME, SOME[::-1]))
    return rigid.FreeBody(
        _many(mass),
        orbit=rigid.Orbit(0.7 / time, np.linspace(0.0, 0.6, COUNT), 2.0, normal=(0.0, 0.6, 0.8)),
        rotor=mass / time * others * [0.3, -0.2, 0.5],
        drag=mass * some * [0.1, 0.1, 0.2],
        dissipation=rigid.EnergySink(mass * time * SIZE[:, None] * [0.05, 0.1, 0.02]),
    )


def push(t: float, omega: Any, attitude: Any, data: Any, torque: Any) -> None:
    for k in range(3):
        torque[k] = data[3] * attitude[k] - data[k] * omega[k]


def _called(mass: float, time: float) -> Scene:
    data = np.concatenate([_damping(mass, time), mass / time**2 * 0.1 * SIZE[:, None]], axis=1)
    torque = rigid.Torque.call(push, data, fastest=30.0 / time)
    return rigid.FreeBody(_many(mass), torque=torque, rotor=_satellites(mass, time).rotor)


def _under_tables(mass: float, time: float) -> Scene:
    t = np.linspace(-1.0, 6.0, 15)
    path = np.stack([t - 2.0, np.ones(15), 0.1 * t], axis=1)
    momenta = mass / time * np.where(SOME, SIZE, 0.0)[:, None, None] * [[0.1, 0.0, 0.2], [0.3] * 3]
    return rigid.FreeBody(
        _many(mass),
        orbit=rigid.Orbit.table(time * t, path, gm=0.5 / time**2),
        rotor=rigid.RotorTable([-1.0 * time, 6.0 * time], momenta),
        damping=_damping(mass, time),
    )


SCENES: dict[str, Scenes] = {
    "free": lambda mass, _: rigid.FreeBody(_one((1.0, 1.5, 2.0), mass)),
    "symmetric": lambda mass, _: rigid.FreeBody(_one((1.5, 1.0, 1.5), mass)),
    "lagrange": lambda mass, time: rigid.HeavyTop(
        _one((1.0, 1.0, 0.5), mass), mgl=3.0 * mass / time**2
    ),
    "top": lambda mass, time: rigid.HeavyTop(
        _one((1.0, 1.5, 2.0), mass), mgl=3.0 * mass / time**2, com=(0.48, -0.64, 0.6)
    ),
    "driven": lambda mass, time: rigid.FreeBody(
        _one((1.0, 1.625, 0.75), mass),
        damping=0.25 * mass / time,
        torque=rigid.Torque.body(mass / time**2 * np.array([0.5, 0.0, 0.25])),
    ),
    "free bodies": lambda mass, _: rigid.FreeBody(_many(mass)),
    "tops": lambda mass, time: rigid.HeavyTop(
        _many(mass), mgl=mass / time**2 * np.where(SOME, SHARES, 0.0) * SIZE, com=AXES
    ),
    "driven tops": _driven,
    "damped bodies": _of_each_strength,
    "satellites": _satellites,
    "under tables": _under_tables,
    "under a function": _called,
}

OF_POINTS = ("t", "omega", "gamma", "attitude", "direction", "slope", "grazing", "error")

# Doors: scene, some of the bodies, units of mass and of time, threads


def _of_each(result: Any, names: tuple[str, ...], count: int | None) -> list[dict[str, Any]]:
    found = {name: getattr(result, name) for name in names}
    arrays = {name: np.asarray(array) for name, array in found.items() if array is not None}
    if count is None:
        return [arrays]
    return [{name: array[k] for name, array in arrays.items()} for k in range(count)]


def _columns(of: type) -> tuple[str, ...]:
    known = (name for name, column in vars(of).items() if isinstance(column, Column))
    return tuple(name for name in known if name not in ("t", "zeros"))


def _start(scene: Scene, rows: Any, time: float) -> tuple[Scene, Floats, Floats, int | None]:
    omega: Floats = OMEGA[rows] / time
    of = scene[rows] if scene.shape else scene
    return of, omega, ATTITUDE[rows], None if omega.ndim == 1 else len(omega)


def parameters(scene: Scene) -> tuple[str, ...]:
    """Parameters of the scene for the derivatives of its motions."""
    return ("I1", "damping", "torque1", *(("mgl", "com3") if scene.directions else ()))


def simulated(
    scene: Scene,
    rows: Any,
    mass: float,
    time: float,
    threads: int,
    *,
    own: bool = False,
    step: float | None = None,
    varied: bool = False,
    **options: Any,
) -> list[dict[str, Any]]:
    of, omega, attitude, count = _start(scene, rows, time)
    t = time * (OWN_TIMES[rows] if own else TIMES)
    step = None if step is None else step * time
    if varied:
        options |= {"tangent": parameters(scene), "check": False}
    run = rigid.simulate(of, omega, attitude, t=t, threads=threads, step=step, **options)
    return _of_each(run, _columns(rigid.Run), count)


def elsewhere(
    scene: Scene, rows: Any, mass: float, time: float, threads: int
) -> list[dict[str, Any]]:
    """States at other times than those of the call."""
    of, omega, attitude, count = _start(scene, rows, time)
    run = rigid.simulate(of, omega, attitude, t=[time], threads=threads)
    return _of_each(run.at(time * np.array([0.7, 0.2])), _columns(rigid.Run), count)


def watched(
    scene: Scene, rows: Any, mass: float, time: float, threads: int, *, until: bool = False
) -> list[dict[str, Any]]:
    of, omega, attitude, count = _start(scene, rows, time)
    events = [rigid.crosses("omega2", 0.1 / time), rigid.turns("gamma3")]
    asked: Any = {"until": events[0], "count": 2} if until else {}
    run = rigid.simulate(
        of, omega, attitude, t=[0.0, 5.0 * time], threads=threads, events=events, **asked
    )
    found = _of_each(run, _columns(rigid.Run), count)
    for number, event in enumerate(run.events):
        for k, arrays in enumerate(found):
            own = event if count is None else event.of(k)
            arrays |= {f"{name} of event {number}": getattr(own, name) for name in OF_POINTS}
    return found


def cut(
    scene: Scene, rows: Any, mass: float, time: float, threads: int, *, section: str
) -> list[dict[str, Any]]:
    of, omega, attitude, count = _start(scene, rows, time)
    points = rigid.poincare(of, omega, attitude, section=section, t_end=6.0 * time, threads=threads)
    found = _of_each(points, (*_columns(rigid.Crossings), "complete", "lost_from"), count)
    for k, arrays in enumerate(found):
        own = points.body == k
        arrays |= {f"{name} of a point": getattr(points, name)[own] for name in OF_POINTS}
    return found


def stepped(
    scene: Scene, rows: Any, mass: float, time: float, threads: int, *, method: str
) -> list[dict[str, Any]]:
    of, omega, attitude, count = _start(scene, rows, time)
    motion = rigid.Motion(of, omega, attitude, method=method)
    push = 0.125 * np.asarray(of.body.moments) / time**2
    for torque in (None, None, push, None):
        motion.step(time / 64.0, torque if "torque" in _method(method).forces else None)
    return _of_each(motion, ("omega", "attitude"), count)


def grown(
    scene: Scene, rows: Any, mass: float, time: float, threads: int, **options: Any
) -> list[dict[str, Any]]:
    of, omega, attitude, count = _start(scene, rows, time)
    t = time * np.array([1.0, 2.5])
    options = {"of": "attitude", "threads": threads, **options}
    growth = rigid.lyapunov(of, omega, attitude, t=t, **options)
    return _of_each(growth, _columns(rigid.Growth), count)


def _method(name: str) -> rigid.Method:
    return next(method for method in rigid.methods() if method.name == name)


Door = Callable[[Scene, Any, float, float, int], list[dict[str, Any]]]

DOORS: dict[str, Door] = {
    **{m.name: partial(simulated, method=m.name, step=0.05, check=False) for m in METHODS},
    "etd4": partial(simulated, method="etd4", step=0.05, check=False),
    **{
        f"{name} in checked steps": partial(simulated, method=name)
        for name in ("rk4", "dop853", "etd4", "splitting", "midpoint", "taylor16")
    },
    "chosen method": simulated,
    "an accuracy": partial(simulated, accuracy=1e-6),
    "an accuracy of a method": partial(simulated, accuracy=1e-7, method="dop853"),
    "steps of a method": partial(simulated, method="rk4", check=False),
    "too long steps": partial(simulated, method="splitting", step=1.0, check=False),
    "a tolerance": partial(simulated, method="taylor12", tolerance=1e-9),
    "own times": partial(simulated, own=True),
    "steps to own times": partial(simulated, own=True, method="rk4"),
    "rates": partial(simulated, record="rates", method="dop853", check=False),
    "axis": partial(simulated, record="axis", method="rk4", check=False),
    "tangent": partial(simulated, tangent=True, check=False),
    "tangent by parameters": partial(simulated, varied=True),
    "tangent by parameters in steps": partial(simulated, varied=True, method="dop853"),
    "tangent by parameters in a series": partial(simulated, varied=True, method="taylor16"),
    "tangent of splittings": partial(simulated, tangent=True, method="splitting4", check=False),
    "other times": elsewhere,
    "events": watched,
    "last event": partial(watched, until=True),
    "motion": partial(stepped, method="dop853"),
    "motion by splitting4": partial(stepped, method="splitting4"),
    "growth": grown,
    "growth by steps": partial(grown, exponents=3, method="dop853", check=False),
    "section of a rate": partial(cut, section="omega2"),
    "section of the height": partial(cut, section="height"),
    "growth of rates": partial(grown, of="rates", exponents=3, method="dop853", check=False),
}


def opens(name: str, scene: Scene) -> bool:
    """Whether the door knows the forces of the scene."""
    words, forces = set(name.split()), set(scene.forces)
    method = next((m for m in rigid.methods() if m.name in words), None)
    if method is not None:
        return moves(method, scene)
    if "function" in forces:
        return name == "motion"  # the others take seconds in Python
    if "splittings" in words:
        return not forces
    if name == "section of the height":
        return isinstance(scene, rigid.HeavyTop) and bool(np.all(scene.mgl))
    if name == "growth of rates":
        return forces <= {"damping"}
    return name != "too long steps" or forces <= {"torque", "damping"}


CASES = [
    (scene, door) for scene, make in SCENES.items() for door in DOORS if opens(door, make(1.0, 1.0))
]


def asked(
    scene: str, door: str, rows: Any, mass: float = 1.0, time: float = 1.0, threads: int = 1
) -> list[dict[str, Any]]:
    """The arrays of each body of some rows."""
    return DOORS[door](SCENES[scene](mass, time), rows, mass, time, threads)
