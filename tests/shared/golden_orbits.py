"""Bodies on orbits and flybys whose motions are known to 33 digits."""

import json
from pathlib import Path
from typing import Any

import numpy as np

import rigid
from physics import Floats

GOLDEN = [
    case
    for name in ("satellites.json", "flybys.json")
    for case in json.loads((Path(__file__).parents[1] / "golden" / name).read_text())
]


def scene_of(case: dict[str, Any]) -> rigid.FreeBody:
    orbit = rigid.Orbit(1.0, case["e"], true_anomaly=case["true_anomaly"])
    rotor = case["rotor"] if any(case["rotor"]) else None
    return rigid.FreeBody(rigid.Body(case["moments"]), orbit=orbit, rotor=rotor)


def case_of(name: str) -> dict[str, Any]:
    return next(case for case in GOLDEN if case["name"] == name)


def start_of(case: dict[str, Any]) -> Floats:
    attitude: Floats = np.array(case["attitude"])
    unit: Floats = attitude / np.linalg.norm(attitude)
    return unit


def angle_between(run: rigid.Run, golden: list[dict[str, Any]]) -> Floats:
    """Angles (rad) between the attitudes of a run and those of the golden states."""
    assert run.attitude is not None
    exact = np.array([state["attitude"] for state in golden])
    exact /= np.linalg.norm(exact, axis=1, keepdims=True)
    signs = np.sign(np.sum(run.attitude * exact, axis=1, keepdims=True))
    angles: Floats = 2.0 * np.linalg.norm(run.attitude - signs * exact, axis=1)
    return angles
