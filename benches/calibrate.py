"""Calibrates the model of error and cost of the schemes: writes ``python/rigid/calibration.json``.

A run of a scheme of order p with steps in which the body turns by theta errs by about
``factor theta^p`` per radian turned, as long as theta is below ``largest``. The factor is the upper
quartile over random bodies of each class; what chaos and saddles multiply comes on top and is found
by the run itself. Times are of the processor, median of five, a step of one of 512 bodies.

    python benches/calibrate.py
"""

from __future__ import annotations

import json
import platform
from pathlib import Path
from typing import Any

import numpy as np

from rigid import _core, build_info, methods
from rigid.solve.error_estimate import distances

TARGET = Path(__file__).parents[1] / "python" / "rigid" / "calibration.json"
KINDS = ("free", "lagrange", "top", "driven")
RECORDS = ("rates", "axis", "attitude")
BODIES = 48
ANGLE = 30.0
"""Radians that the bodies turn at most."""
TURNS = 2.0 ** (-0.5 * np.arange(-2, 22))
"""Radians turned in a step."""


def bodies(kind: str, count: int) -> dict[str, Any]:
    """Random bodies that turn by about a radian in a unit of time."""
    # A driven body is a top under damping.
    rng = np.random.default_rng([2026, min(KINDS.index(kind), 2)])
    parts = rng.uniform(0.2, 1.2, (count, 3))
    moments = parts.sum(axis=1, keepdims=True) - parts
    weight = np.zeros((count, 3))
    if kind == "lagrange":
        moments[:, 1] = moments[:, 0]
        moments[:, 2] = np.minimum(moments[:, 2], 1.9 * moments[:, 0])
        weight[:, 2] = rng.uniform(0.3, 3.0, count)
    if kind in ("top", "driven"):
        direction = rng.normal(size=(count, 3))
        size = rng.uniform(0.3, 3.0, (count, 1))
        weight = size * direction / np.linalg.norm(direction, axis=1, keepdims=True)
    attitude = rng.normal(size=(count, 4))
    attitude /= np.linalg.norm(attitude, axis=1, keepdims=True)
    zero = np.zeros((1, 3))
    damped = _core.Forcing(
        times=np.array([]), body=zero, space=zero, damping=[0.1, 0.1, 0.1, 0.0, 0.0, 0.0]
    )
    return {
        **({"forcing": damped} if kind == "driven" else {}),
        "scene": "free" if kind == "free" else "top",
        "moments": moments,
        "weight": weight,
        "omega": rng.normal(size=(count, 3)),
        "attitude": attitude,
    }


def ends(table: dict[str, Any], method: str, record: str, steps: Any, time_: float) -> Any:
    """The states after a time."""
    return _core.simulate(
        **table,
        method=method,
        record=record,
        step=steps,
        max_steps=10**9,
        threads=1,
        times=np.array([time_]),
    )


def errors(kind: str, name: str, order: int, truths: dict[str, Any]) -> tuple[float, float]:
    """Factor and longest step of a scheme."""
    table = bodies(kind, BODIES)
    rates = _core.fastest_rates(**table)
    until = truths["until"]
    factors, found = [], []
    for turn in TURNS:
        try:
            states = ends(table, name, "attitude", turn / rates, until)
        except ValueError:
            return np.nan, np.nan
        error = distances(states, truths["states"])[:, 0]
        good = (states["status"] == 0) & np.isfinite(error)
        error = np.where(good, error, np.inf)
        # Less than what rounding leaves says nothing.
        model = error / (rates * until * turn**order)
        factors.append(float(np.quantile(model, 0.75)))
        found.append(float(np.quantile(error, 0.75)))
        if found[-1] < 1e-12:
            break
    usable = [i for i, error in enumerate(found) if 1e-11 < error < 1e-2]
    if not usable:
        usable = [int(np.argmin(found))]
    factor = float(np.median([factors[i] for i in usable]))
    fitting = [i for i in usable if factors[i] < 5.0 * factor]
    return factor, float(TURNS[min(fitting)])


def cost(kind: str, name: str, record: str) -> float:
    """Nanoseconds a step."""
    table = bodies(kind, 512)
    if kind == "driven" and record == "rates":
        # Of rates alone that need no directions.
        table = {**table, "scene": "free", "weight": np.zeros((512, 3))}
    count, samples = 64, []
    for _ in range(5):
        states = ends(table, name, record, np.full(512, 0.01 / count), 0.01)
        samples.append(states["nanoseconds"] / float(states["steps"].sum()))
        count = max(64, min(4096, int(2e6 / (samples[-1] * 512.0))))
    return float(np.median(samples[1:]))


def main() -> None:
    schemes: dict[str, Any] = {}
    best = max(methods(), key=lambda method: (not method.symplectic, method.order))
    for kind in KINDS:
        table = bodies(kind, BODIES)
        rates = _core.fastest_rates(**table)
        until = ANGLE / float(np.median(rates))
        exact = kind in ("free", "lagrange")
        truth = ends(
            table,
            "exact" if exact else best.name,
            "attitude",
            None if exact else 0.25 * best.order / 26.0 / rates,
            until,
        )
        for method in methods():
            if kind == "driven" and not method.driven:
                continue
            factor, largest = errors(
                kind, method.name, method.order, {"until": until, "states": truth}
            )
            if not np.isfinite(factor):
                continue
            costs = {record: round(cost(kind, method.name, record), 2) for record in RECORDS}
            entry = {"factor": float(f"{factor:.3g}"), "largest": float(f"{largest:.3g}")}
            schemes.setdefault(method.name, {})[kind] = {**entry, "nanoseconds": costs}
            print(f"{kind:<10}{method.name:<12}{factor:10.2e}{largest:8.3f}  {costs}", flush=True)
    machine = {
        "processor": platform.processor() or platform.machine(),
        "isa": build_info()["isa"],
        "bodies": BODIES,
        "angle": ANGLE,
    }
    TARGET.write_text(json.dumps({"machine": machine, "methods": schemes}, indent=1) + "\n")


if __name__ == "__main__":
    main()
