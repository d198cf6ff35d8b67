"""Bodies on Keplerian orbits: golden digits of motion and tangent, Kepler's equation, refusals."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import rigid

Floats = NDArray[np.float64]

GOLDEN = json.loads((Path(__file__).parents[2] / "golden" / "satellites.json").read_text())
NAMES = [case["name"] for case in GOLDEN]
METHODS = [method.name for method in rigid.methods() if "orbit" in method.forces]


def scene_of(case: dict[str, Any]) -> rigid.FreeBody:
    orbit = rigid.Orbit(1.0, case["e"], true_anomaly=case["true_anomaly"])
    rotor = case["rotor"] if any(case["rotor"]) else None
    return rigid.FreeBody(rigid.Body(case["moments"]), orbit=orbit, rotor=rotor)


def case_of(name: str) -> dict[str, Any]:
    return next(case for case in GOLDEN if case["name"] == name)


def start_of(case: dict[str, Any]) -> Floats:
    attitude = np.array(case["attitude"])
    return attitude / np.linalg.norm(attitude)


def angle_between(run: rigid.Run, golden: list[dict[str, Any]]) -> Floats:
    """Angles (rad) between the attitudes of a run and those of the golden states."""
    assert run.attitude is not None
    exact = np.array([state["attitude"] for state in golden])
    exact /= np.linalg.norm(exact, axis=1, keepdims=True)
    signs = np.sign(np.sum(run.attitude * exact, axis=1, keepdims=True))
    return 2.0 * np.linalg.norm(run.attitude - signs * exact, axis=1)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("method", METHODS)
def test_golden_satellites_within_the_estimated_error(name: str, method: str) -> None:
    case = case_of(name)
    times = [state["t"] for state in case["at"]]
    run = rigid.simulate(scene_of(case), case["omega"], start_of(case), t=times, method=method)
    rates = np.abs(run.omega - [state["omega"] for state in case["at"]]).max(axis=1)
    assert run.error_estimate is not None
    speed = np.linalg.norm(case["omega"])
    allowed = np.maximum(run.error_estimate, 1e-13)
    assert (rates <= allowed * max(speed, 1.0)).all()
    assert (angle_between(run, case["at"]) <= allowed).all()


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("method", METHODS)
def test_golden_tangents(name: str, method: str) -> None:
    case = case_of(name)
    times = [state["t"] for state in case["at"]]
    step = 1.0 / 256.0 if method in ("rk4", "dop853") else None
    run = rigid.simulate(
        scene_of(case), case["omega"], start_of(case), t=times, method=method, step=step, tangent=True
    )
    assert run.tangent is not None
    exact = np.array([state["tangent"] for state in case["at"]])
    size = np.abs(exact).max(axis=(1, 2))
    # Rounding of the start and of the steps, magnified as a deviation vector is; 1e-16 of each of
    # some thousand steps. The golden tangent has 18 digits.
    allowed = {"rk4": 2e-6}.get(method, 1e-10)
    assert (np.abs(run.tangent - exact).max(axis=(1, 2)) <= allowed * size).all()
