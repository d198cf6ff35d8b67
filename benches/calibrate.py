"""Calibrates the model of error and cost of the methods: writes ``python/rigid/calibration.json``.

A run of a method of order p with steps in which the body turns by theta errs by about
``factor theta^p`` per radian turned, as long as theta is below ``largest``. The factor is the upper
quartile over random bodies of each class, and 95 of 100 err by at most ``margin`` times as much;
what chaos and saddles multiply comes on top and is found by the run itself. Those of tops are
measured at several spins, and kept beside the ratio of the weight, ``mgl / (I omega^2)``: methods
of free motions and kicks err in proportion to it, or to a power. Costs are parts of
:class:`rigid.solve.work.Work`, in its unit: processor times over those of reference runs in
between, medians of seven.

    python benches/calibrate.py            # errors and costs
    python benches/calibrate.py --costs    # costs alone
    python benches/calibrate.py --errors   # errors alone

A quick run writes nothing.
"""

from __future__ import annotations

import json
import platform
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from timing import QUICK, moved, parser, positive, sized

from rigid import _core, build_info, methods
from rigid.model.orbit import Orbit
from rigid.solve.bodies import Bodies
from rigid.solve.error_estimate import distances
from rigid.solve.methods import EXACT
from rigid.solve.request import Request
from rigid.solve.work import LANES, reference_nanoseconds

TARGET = Path(__file__).parents[1] / "python" / "rigid" / "calibration.json"
KINDS = ("free", "lagrange", "top", "forced", "further")
MEASURED = sized(KINDS, ("lagrange",))
METHODS = sized(None, 3)
"""So many of the methods; None for all."""
CLOSED = ("free", "lagrange")
"""Classes with a closed form."""
OF_WEIGHT = ("top",)
"""Classes of which the errors are measured at several ratios of the weight."""
ERRORS = ("factor", "margin", "largest")
RECORDS = ("rates", "axis", "attitude")
BODIES, BODIES_OF_MARGINS = sized((48, 192), (4, 4))
MARGIN = 5.0
RUNGE_KUTTA = ("rk4", "dop853")
"""Their errors, by a quaternion, differ most from body to body: the factor makes up for it."""
"""The least margin: a run may be longer than these, and what is chaotic grows."""
SPINS = sized((40.0, 16.0, 8.0, 4.0, 2.0, 1.0, 0.3), (40.0, 1.0))
"""How many times faster the tops spin; the ratios of their weight ascend."""
ANGLE = 30.0
"""Radians that the bodies turn at most."""
TURNS = 2.0 ** (-0.5 * np.arange(-2, 22))
"""Radians turned in a step."""

STEP = 0.007
"""Step whose cost is measured (s): an implicit step costs the more the longer it is."""

OTHER_DATA = np.ones(2**20)
"""What a program does between two calls: the caches are not those of the last call."""


def bodies(kind: str, count: int, spin: float = 1.0) -> Bodies:
    """Random bodies that turn by about a radian in a unit of time, or so many times as far."""
    # A forced body is a top under damping; further forces are those of satellites.
    rng = np.random.default_rng([2026, min(KINDS.index(kind), 2)])
    parts = rng.uniform(0.2, 1.2, (count, 3))
    moments = parts.sum(axis=1, keepdims=True) - parts
    weight = np.zeros((count, 3))
    if kind == "lagrange":
        moments[:, 1] = moments[:, 0]
        moments[:, 2] = np.minimum(moments[:, 2], 1.9 * moments[:, 0])
        weight[:, 2] = rng.uniform(0.3, 3.0, count)
    if kind in ("top", "forced"):
        direction = rng.normal(size=(count, 3))
        size = rng.uniform(0.3, 3.0, (count, 1))
        weight = size * direction / np.linalg.norm(direction, axis=1, keepdims=True)
    attitude = rng.normal(size=(count, 4))
    attitude /= np.linalg.norm(attitude, axis=1, keepdims=True)
    none, damping = np.empty((0, 3)), np.array([[0.1, 0.1, 0.1, 0.0, 0.0, 0.0]])
    table = {"times": np.array([]), "body": none, "space": none}
    orbit = Orbit(spin * rng.uniform(0.1, 1.0, count), rng.uniform(0.0, 0.5, count), 1.0)
    acting = {
        "forced": {"damping": damping},
        "further": {"damping": np.zeros((1, 6)), "further": {"orbit": orbit.numbers}},
    }
    return Bodies(
        kind="free" if kind in ("free", "further") else "top",
        shape=(count,),
        moments=moments,
        weight=weight,
        omega=spin * rng.normal(size=(count, 3)),
        attitude=attitude,
        forces=_core.Forces(**table, **acting[kind]) if kind in acting else None,
    )


def ends(table: Bodies, method: str, record: str, steps: Any, time_: float) -> Any:
    """The states after a time."""
    return simulate(table, method, record, steps, np.array([time_]))


def simulate(table: Bodies, method: str, record: str, steps: Any, times: Any) -> Any:
    """The states at some times, by one thread; those that are found are not those of the start."""
    states = Request(
        bodies=table,
        times=times,
        method=method,
        record=record,
        max_steps=10**9,
        threads=1,
    ).states(steps)
    found = (states["status"] == 0) & np.isfinite(states["omega"]).all(axis=(1, 2))
    if found.any():
        made = states["steps"][found] + (method == EXACT)
        moved(states["omega"][found, -1], table.omega[found], made)
    return states


class Truth:
    """Random bodies of a class, and where they are after ``ANGLE``."""

    def __init__(self, kind: str, count: int, spin: float = 1.0) -> None:
        self.table = bodies(kind, count, spin)
        self.rates = _core.fastest_rates(self.table)
        self.until = ANGLE / float(np.median(self.rates))
        best = max(methods(), key=lambda method: (not method.symplectic, method.order))
        exact = kind in CLOSED
        self.states = ends(
            self.table,
            EXACT if exact else best.name,
            "attitude",
            None if exact else 0.25 * best.order / 26.0 / self.rates,
            self.until,
        )

    def errors(self, name: str, turn: float) -> Any:
        """The errors of a method with steps of that angle; infinite where it fails."""
        states = ends(self.table, name, "attitude", turn / self.rates, self.until)
        with np.errstate(all="ignore"):
            error = distances(states, self.states)[:, 0]
        return np.where((states["status"] == 0) & np.isfinite(error), error, np.inf)

    def ratio(self) -> float:
        """The median of the ratios of the weight."""
        size = np.linalg.norm(self.table.weight, axis=1) / self.table.moments.min(axis=1)
        return float(np.median(size / self.rates**2))

    def model(self, order: int, turn: float) -> Any:
        """The error of the model with a factor of one."""
        return self.rates * self.until * turn**order


def margin(name: str, order: int, factor: float, largest: float, truth: Truth) -> float:
    """How many times the error of the model 95 of 100 bodies keep, whatever the step."""
    least = MARGIN
    for turn in TURNS:
        if turn > largest:
            continue
        error = truth.errors(name, turn)
        # Less than what rounding leaves says nothing.
        if np.quantile(error, 0.95) < 1e-11:
            break
        least = max(least, float(np.quantile(error / (factor * truth.model(order, turn)), 0.95)))
    return least


def errors(name: str, order: int, truth: Truth) -> tuple[float, float] | None:
    """Factor and longest step of a method; None if it does not move these bodies."""
    factors, found = [], []
    for turn in TURNS:
        try:
            error = truth.errors(name, turn)
        except ValueError:
            return None
        # Less than what rounding leaves says nothing.
        model = error / truth.model(order, turn)
        # Of infinite errors there is no quantile.
        with np.errstate(invalid="ignore"):
            factors.append(float(np.quantile(model, 0.75)))
            found.append(float(np.quantile(error, 0.75)))
        if found[-1] < 1e-12:
            break
    usable = [i for i, error in enumerate(found) if 1e-11 < error < 1e-2]
    if not usable:  # the longest step has the least share of rounding
        usable = [next(i for i, error in enumerate(found) if error < 1e-2)]
    factor = float(np.median([factors[i] for i in usable]))
    fitting = [i for i in usable if factors[i] < 5.0 * factor]
    return factor, float(TURNS[min(fitting)])


def work(kind: str, name: str, record: str) -> list[float]:
    """The parts of the work of a method or of the closed form."""
    rates_alone = kind == "forced" and record == "rates"

    def time_(count: int, states: int, steps: int, ends: int = 1) -> float:
        table = bodies(kind, count)
        if rates_alone:
            # Of rates alone that need no directions.
            table = replace(table, kind="free", weight=np.zeros((1, 3)))
        times = np.linspace(0.0, STEP * steps, states + 1)[1:]
        # The last of the bodies makes all the steps; the others make fewer.
        made = steps - np.arange(count)[::-1] * (ends - 1) / max(count - 1, 1)
        step = None if name == EXACT else STEP * steps / made
        found = []
        for _ in range(7):
            unit = reference_nanoseconds()
            OTHER_DATA.sum()
            found.append(simulate(table, name, record, step, times)["nanoseconds"] / unit)
        return float(np.median(found))

    def of_a_step(count: int) -> float:
        more = time_(count, 1, stepped) - time_(count, 1, 1)
        return positive(f"time of a step of {name}", more / (stepped - 1))

    once, outputs, stepped, many = 1, 65, 257, 8 * LANES
    alone = time_(1, once, 1)
    step_of_one, step, end = 0.0, 0.0, 0.0
    if name != EXACT:
        step_of_one, step = of_a_step(1), of_a_step(LANES)
        end = max((time_(LANES, 1, stepped, LANES) - time_(LANES, 1, stepped)) / (LANES - 1), 0.0)
    of_one = (time_(1, outputs, outputs) - alone) / (outputs - 1) - step_of_one
    first = time_(many, once, 1)
    of_group = (time_(many, outputs, outputs) - first) / (outputs - 1) * LANES / many - step
    state = max((of_group - of_one) / (LANES - 1), 0.0)
    group_state = max(of_one - state, 0.0)
    body = max((first - alone) / many - state - (group_state + step) / LANES, 0.0)
    call = max(alone - body - state - group_state - step_of_one, 0.0)
    parts = (call, body, group_state, state, step_of_one, step, end)
    return [rounded(part) for part in parts]


def calibrated_errors(kind: str) -> tuple[dict[str, dict[str, Any]], list[float]]:
    """Factors, margins and longest steps of each method that moves bodies of a class, by ratios."""
    spins = SPINS if kind in OF_WEIGHT else (1.0,)
    # The rates of satellites stay far below their bounds, those of gyrostats reach them.
    known = "forced" if kind == "further" else kind
    truths = [(Truth(known, BODIES, s), Truth(known, BODIES_OF_MARGINS, s)) for s in spins]
    found: dict[str, dict[str, Any]] = {}
    for method in methods()[:METHODS]:
        needed = {"forced": "damping", "further": "orbit"}
        if kind in needed and needed[kind] not in method.forces:
            continue
        for truth, many in truths:
            limits = errors(method.name, method.order, truth)
            if limits is not None:
                factor, largest = limits
                of_many = margin(method.name, method.order, factor, largest, many)
                if method.name in RUNGE_KUTTA:
                    factor, of_many = factor * of_many / MARGIN, MARGIN
                values = (factor, of_many, largest)
                for part, value in zip(ERRORS, values, strict=True):
                    of_part = found.setdefault(method.name, {}).setdefault(part, [])
                    of_part.append(rounded(positive(f"{part} of {method.name}", value)))
    return found, [rounded(many.ratio()) for _, many in truths]


def rounded(value: float) -> float:
    return float(f"{value:.3g}")


def main() -> None:
    options = parser(__doc__)
    parts = options.add_mutually_exclusive_group()
    parts.add_argument("--costs", action="store_true", help="keep the errors of the file")
    parts.add_argument("--errors", action="store_true", help="keep the costs of the file")
    chosen = options.parse_args()
    known = json.loads(TARGET.read_text())
    calibrated: dict[str, Any] = {}
    closed: dict[str, Any] = known["closed forms"]
    ratios: dict[str, list[float]] = known["ratios"]
    for kind in MEASURED:
        of_kind = {name: at[kind] for name, at in known["methods"].items() if kind in at}
        if chosen.costs:
            found = {name: {part: old[part] for part in ERRORS} for name, old in of_kind.items()}
        else:
            found, of_weight = calibrated_errors(kind)
            if kind in OF_WEIGHT:
                ratios[kind] = of_weight
        for name, entry in found.items():
            if chosen.errors:
                entry["work"] = of_kind[name]["work"]
            else:
                entry["work"] = {record: work(kind, name, record) for record in RECORDS}
            calibrated.setdefault(name, {})[kind] = entry
            print(f"{kind:<10}{name:<12}{entry}", flush=True)
        if kind in CLOSED and not chosen.errors:
            closed[kind] = {record: work(kind, EXACT, record) for record in RECORDS}
            print(kind, closed[kind], flush=True)
    machine = {
        "processor": platform.processor() or platform.machine(),
        "isa": build_info()["isa"],
        "bodies": BODIES,
        "angle": ANGLE,
    }
    written = {
        "machine": machine,
        "ratios": ratios,
        "methods": calibrated,
        "closed forms": closed,
    }
    if not QUICK:
        TARGET.write_text(json.dumps(written, indent=1) + "\n")


if __name__ == "__main__":
    main()
