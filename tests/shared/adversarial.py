"""Random runs that are hard on stated errors: scenes, starts, output times and methods.

Each is one of :data:`KINDS`. Angles and times are counted in the body's own unit of time, so that
the truth costs a bounded number of steps.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

import forced_starts as forced
import hard_starts as hard
import rigid
from hard_starts import Start, decades
from physics import EVERY_METHOD, Floats
from rigid.model.scene import Scene

#: Most steps of any run: a body that needs more has a status that says so.
MAX_STEPS = 100_000

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


Kinds: TypeAlias = Mapping[str, tuple[float, Callable[[np.random.Generator], Start]]]

#: Each kind with how often it is drawn.
KINDS: Kinds = {
    "anything": (10.0, hard.anything),
    "near rest": (8.0, hard.near_rest),
    "saddle": (8.0, hard.saddle),
    "separatrix": (6.0, hard.separatrix),
    "upright": (7.0, hard.upright),
    "many turns": (5.0, hard.many_turns),
    "damped": (12.0, forced.damped),
    "strongly damped": (10.0, forced.strongly_damped),
    "driven": (6.0, forced.driven),
    "satellite": (4.0, forced.satellite),
    "drag": (5.0, forced.drag),
    "orbit": (4.0, forced.on_orbit),
    "rotor": (4.0, forced.rotor),
    "energy sink": (4.0, forced.energy_sink),
    "function": (3.0, forced.function),
    "table in body": (2.0, forced.table_in_body),
    "table in space": (2.0, forced.table_in_space),
}


# Times and methods


def output_times(rng: np.random.Generator, start: Start, *, short: bool) -> Floats:
    """Times of the states: even, random, geometric, in clusters, one alone, some negative."""
    low, high = (-1.3, 0.3) if short else (-0.5, float(np.log10(start.longest)))
    span = decades(rng, low, high) / start.rate
    slowed = start.damping_rate
    if slowed > 0.0:
        span = min(span, decades(rng, -1.0, start.slowest) / slowed)
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
    weights = np.array([weight for weight, _ in kinds.values()])
    kind = str(rng.choice(list(kinds), p=weights / weights.sum()))
    start = kinds[kind][1](rng)
    scene = start.scene
    able = [
        one
        for one in EVERY_METHOD
        if set(scene.forces) <= set(one.forces) and (one.tops or not scene.directions)
    ]
    options: dict[str, Any] = {}
    mode = rng.choice(["default", "method", "step", "tolerance"], p=[0.3, 0.35, 0.15, 0.2])
    if scene.torque is not None and scene.torque.function is not None:
        bound = scene.torque.function.fastest
        mode = "step" if bound is None else "method" if mode == "tolerance" else mode
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
    t = output_times(rng, start, short=mode == "tolerance" and rng.random() < 0.5)
    others = None
    if mode != "tolerance" and rng.random() < 0.04:
        others = start.omega + 1e-3 * start.rate * rng.normal(size=(CROWD, 3))
        if rng.random() < 0.5:  # calm ones
            others = np.broadcast_to(np.eye(3)[2] * np.linalg.norm(start.omega), (CROWD, 3)).copy()
    return Case(kind, scene, start.omega, start.attitude, t, options, others)
