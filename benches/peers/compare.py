"""Time to the same error, with the attitude, on one thread: rigid against heyoka and numba.

    pip install . numba heyoka && python benches/peers/compare.py

Every side is given the fastest step, order or tolerance that brings the median error of a cloud of
bodies below the target and loses none of them; a sweep against a converged reference finds it. What
was found is then timed in turns: processor time of whole calls, medians, at the depth of the stack
that suits each side. Writes ``measured.json`` beside this file. Two minutes. A quick run writes
nothing, and does without a peer that is not installed.
"""

from __future__ import annotations

import os

# Idle threads spin, and processor time counts them.
os.environ["OPENBLAS_NUM_THREADS"] = "1"
os.environ["NUMBA_NUM_THREADS"] = "1"

import json
import platform
import sys
import time
from collections import defaultdict
from collections.abc import Callable
from dataclasses import asdict, dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))

import heyoka_side
import numba_side
import rigid_side
from timing import QUICK, in_turns, moved, parser, positive, required, share, sized
from tops import BALL, SCENES, Scene, State, errors, matrices

import rigid

BODIES, CHECKED = sized((2048, 1024), (16, 16))
"""So many are timed, and so many compared with the reference."""
REPEATS = sized(3, 1)
DEPTHS = sized((0, 1, 2, 3, 5, 7), (0,))
"""How deep in calls the sides are timed: where the stack lies changes the time of some by a fifth.
Each is given the depth that suits it."""
QUICK_SCENES = [replace(scene, t=2.0, targets=(1e-3,), goals={1e-3: 1.0}) for scene in SCENES]
LIMIT = sized(2000.0, np.inf)
"""Nanoseconds a body and unit of time from which on a sweep is given up."""


@dataclass
class Entry:
    """A side at a target."""

    scene: str
    target: float
    side: str
    scheme: str
    form: str
    unit: str
    knob: float
    error: float
    nanoseconds: float = 0.0
    """A body and unit of time, of whole calls."""
    core: float | None = None
    """The same, of the core of rigid alone."""
    chosen: str = ""
    """The scheme that an accuracy led to."""
    by_depth: list[float] = field(default_factory=list)

    @property
    def counted(self) -> bool:
        """Whether the goals are about it."""
        return BALL not in self.form and self.scheme not in ("exact", "accuracy=")


class Sweep:
    """Errors and times of a side by its knob."""

    def __init__(self, side: Any, scene: Scene, truth: State) -> None:
        self.side, self.scene, self.truth = side, scene, truth
        self.seen: dict[float, tuple[float, float]] = {}

    def at(self, knob: float) -> tuple[float, float]:
        """Median error, and nanoseconds a body and unit of time."""
        if knob not in self.seen:
            self.side.take(CHECKED)
            self.side.prepare(knob)
            # Steps that are far too long overflow.
            with np.errstate(all="ignore"):
                begin = time.process_time()
                self.side.run(knob)
                seconds = time.process_time() - begin
                apart = errors(self.side.state(), self.truth)
            # Steps that lose a body are no way to move these.
            error = float(np.median(apart)) if np.isfinite(apart).all() else np.inf
            self.seen[knob] = error, seconds * 1e9 / (CHECKED * self.scene.t)
        return self.seen[knob]

    def cheapest(self, target: float) -> float | None:
        """The knob that reaches the target in the shortest time."""
        if hasattr(self.side, "knobs"):
            good = [knob for knob in self.side.knobs() if self.at(knob)[0] <= target]
            return min(good, key=lambda knob: self.at(knob)[1], default=None)
        try:
            return self.fewest_steps(target)
        except ValueError:
            # rigid refuses a scheme that does not move this scene.
            return None

    def fewest_steps(self, target: float) -> float | None:
        below, steps = 0.0, self.scene.t / 2.0
        while self.at(round(steps))[0] > target:
            if self.at(round(steps))[1] > LIMIT:
                return None
            below, steps = steps, steps * np.sqrt(2.0)
        # To 2 %.
        for _ in range(4 if below else 0):
            middle = np.sqrt(below * steps)
            if self.at(round(middle))[0] <= target:
                steps = middle
            else:
                below = middle
        return round(steps)


def deep(depth: int, call: Callable[[], None]) -> None:
    """A call from further down the stack of C."""
    if depth:
        list(map(deep, [depth - 1], [call]))
    else:
        call()


def timed(entries: list[tuple[Any, Entry]], scene: Scene) -> None:
    """Fills in the times: the sides take turns."""
    unit = BODIES * scene.t
    omega, cores = scene.cloud(BODIES), defaultdict(list)
    for side, entry in entries:
        side.take(BODIES)
        side.prepare(entry.knob)

    def check(taken: tuple[int, Any]) -> None:
        index, side = taken
        moved(side.state()[0][:CHECKED], omega[:CHECKED])
        if side.side == "rigid":
            cores[index].append(side.nanoseconds / unit)

    def call(index: int, depth: int) -> tuple[int, Any]:
        side, entry = entries[index]
        deep(depth, partial(side.run, entry.knob))
        return index, side

    every = range(len(entries))
    sides = {f"{i} at {depth}": partial(call, i, depth) for depth in DEPTHS for i in every}
    times = in_turns(sides, check, repeats=REPEATS)
    for index, (side, entry) in enumerate(entries):
        of_depths = [times[f"{index} at {depth}"] * 1e9 / unit for depth in DEPTHS]
        entry.by_depth = [float(np.median(turns)) for turns in of_depths]
        entry.nanoseconds = min(entry.by_depth)
        if entry.side == "rigid" and not QUICK:
            # The sides take turns at all depths. Brief closed forms tell the time that passed.
            share("core of a call", np.max(cores[index] / np.transpose(of_depths).ravel()))
            entry.core = float(np.median(cores[index]))
            entry.chosen = side.chosen


def measured(scene: Scene) -> tuple[list[Entry], dict[str, float]]:
    """All sides at all targets of a scene, and what is known of the reference."""
    omega = scene.cloud(BODIES)
    rotation = matrices(scene.attitude()[None])[0]
    other = rigid_side.Rigid(scene, "taylor26", omega)
    other.take(CHECKED)
    if heyoka_side.hy is None:
        other.run(16 * scene.t)
        truth = other.state()
    else:
        truth = heyoka_side.reference(scene, omega[:CHECKED], rotation)
    moved(truth[0], omega[:CHECKED])
    other.run(8 * scene.t)
    apart = errors(other.state(), truth)
    reference = {"median": positive("distance of the references", np.median(apart))}
    reference["largest"] = float(apart.max())
    found = f"distance of the references, {scene.name} = {reference['median']:.1e}"
    most = 0.1 * min(scene.targets)
    required(reference["median"] <= most, f"{found}: must be at most {most:.0e}")

    sweeps = [
        Sweep(side, scene, truth)
        for side in [
            *heyoka_side.sides(scene, omega, rotation),
            *numba_side.sides(scene, omega, rotation),
            *rigid_side.sides(scene, omega),
        ]
    ]
    entries: list[Entry] = []
    for target in scene.targets:
        found = [(sweep, sweep.cheapest(target)) for sweep in sweeps]
        # Without steps to look for: what rigid chooses, or its closed form.
        chosen = rigid_side.Closed if scene.symmetric else rigid_side.Accuracy
        found.append((Sweep(chosen(scene, omega), scene, truth), target))
        race = []
        for sweep, knob in found:
            if knob is not None:
                side = sweep.side
                error = positive(f"error of {side.side} {side.scheme}", sweep.at(knob)[0])
                names = (side.side, side.scheme, side.name, side.unit)
                race.append((side, Entry(scene.name, target, *names, knob, error)))
        timed(race, scene)
        entries += [entry for _, entry in race]
    return entries, reference


def best(entries: list[Entry], side: str, *, counted: bool = True) -> Entry | None:
    """The fastest of a side; or of what the goals leave out."""
    chosen = [e for e in entries if e.side == side and e.counted == counted]
    return min(chosen, key=lambda entry: entry.nanoseconds, default=None)


def row(entry: Entry, ours: Entry) -> str:
    knob = f"{entry.unit} {entry.knob:g}" if entry.unit else "-"
    if entry.unit == "accuracy":
        knob += f": {entry.chosen}"
    name = f"{entry.side} {entry.scheme}{', ' if entry.form else ''}{entry.form}"
    core = "" if entry.core is None else f" (core {entry.core:.1f})"
    return (
        f"| {name} | {knob} | {entry.error:.1e} | {entry.nanoseconds:.1f}{core} "
        f"| {entry.nanoseconds / ours.nanoseconds:.2f} |"
    )


def report(scene: Scene, entries: list[Entry]) -> list[dict[str, Any]]:
    """Prints the tables of a scene; its ratios against the goals."""
    ratios = []
    for target in scene.targets:
        here = sorted((e for e in entries if e.target == target), key=lambda e: e.nanoseconds)
        ours = best(here, "rigid")
        peers = {side: best(here, side) for side in ("heyoka", "numba")}
        reached = [peer for peer in peers.values() if peer is not None]
        if ours is None:
            print(f"\n{scene.name}, {target:.0e}: not reached")
            continue
        print(f"\n{scene.name}, t = {scene.t:g}, median error {target:.0e}\n")
        print("| side | fastest | error | ns a body and unit of time | over rigid |")
        print("|---|---|---|---|---|")
        for entry in here:
            print(row(entry, ours))
        if not reached:
            print("\nno peer reaches it")
            continue
        peer = min(reached, key=lambda entry: entry.nanoseconds)
        ratio, goal = peer.nanoseconds / ours.nanoseconds, scene.goals[target]
        verdict = "reached" if ratio >= goal else "NOT reached"
        print(f"\nbetter peer ({peer.side} {peer.scheme}) over rigid {ours.scheme}: ", end="")
        print(f"{ratio:.2f}, goal {goal:g}: {verdict}")
        if ours.core:
            print(f"of the core of rigid alone: {peer.nanoseconds / ours.core:.2f}")
        line: dict[str, Any] = {"scene": scene.name, "target": target, "goal": goal, "ratio": ratio}
        line |= {"peer": f"{peer.side} {peer.scheme}, {peer.form}", "rigid": ours.scheme}
        for side, entry in peers.items():
            line[side] = entry and entry.nanoseconds / ours.nanoseconds
            by_hand = best(here, side, counted=False)
            if by_hand:
                print(f"{side}, {BALL}: {by_hand.nanoseconds / ours.nanoseconds:.2f}")
                line[f"{side}, {BALL}"] = by_hand.nanoseconds / ours.nanoseconds
        ratios.append(line)
    return ratios


def machine() -> dict[str, Any]:
    model = platform.processor() or platform.machine()
    cpuinfo = Path("/proc/cpuinfo")
    if cpuinfo.exists():
        facts = dict(
            (part.strip() for part in line.split(":", 1))
            for line in cpuinfo.read_text().split("\n\n")[0].splitlines()
        )
        names = ("model name", "cpu family", "model")
        model = ", ".join(f"{name} {facts.get(name, '?')}" for name in names)
    info = rigid.build_info()
    return {
        "processor": model,
        "python": platform.python_version(),
        "rigid": {name: info[name] for name in ("version", "commit", "isa")},
        "heyoka": getattr(heyoka_side.hy, "__version__", None),
        "numba": getattr(numba_side.numba, "__version__", None),
        "numpy": np.__version__,
    }


def main() -> None:
    options = parser(__doc__)
    options.add_argument("--out", type=Path, default=Path(__file__).with_name("measured.json"))
    out = options.parse_args().out
    both = heyoka_side.hy and numba_side.numba
    required(QUICK or both, "peers: heyoka and numba must both be installed")
    facts: dict[str, Any] = {
        "machine": machine(),
        "bodies": BODIES,
        "checked": CHECKED,
        "repeats": REPEATS,
    }
    print(facts["machine"])
    everything: list[Entry] = []
    facts |= {"references apart": {}, "ratios": []}
    for scene in sized(SCENES, QUICK_SCENES):
        entries, reference = measured(scene)
        print(
            f"\n{scene.name}: {CHECKED} bodies; the reference and rigid taylor26 differ by "
            f"{reference['median']:.1e} (median), {reference['largest']:.1e} (largest)"
        )
        facts["references apart"][scene.name] = reference
        facts["ratios"] += report(scene, entries)
        everything += entries
    facts["entries"] = [asdict(entry) for entry in everything]
    if not QUICK:
        out.write_text(json.dumps(facts, indent=1) + "\n")
        print(f"\n{out.name} written")
    print(f"{time.process_time():.0f} s of processor time")


if __name__ == "__main__":
    main()
