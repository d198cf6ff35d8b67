"""Motions whose deviation vectors are known to 26 digits."""

import json
from dataclasses import dataclass
from typing import Any

import numpy as np

import rigid
from physics import GOLDEN, Floats
from rigid.model.scene import Scene


@dataclass(frozen=True)
class Deviating:
    """A motion, its tangent at some times, and the growth of deviation vectors in two norms."""

    name: str
    family: str
    scene: Scene
    omega: Floats
    attitude: Floats
    rate_scale: float
    tangents: Floats
    t: Floats
    matrices: Floats
    growth: dict[str, dict[str, Floats]]

    def scaled(self, matrices: Floats) -> Floats:
        """The matrices with rates in units of the rate scale."""
        unit = np.array([self.rate_scale] * 3 + [1.0] * 3)
        scaled: Floats = matrices * unit / unit[:, np.newaxis]
        return scaled


def attitude_with(gamma: Floats) -> Floats:
    """An attitude in which the upward vertical is ``gamma`` in the body."""
    up = np.array([0.0, 0.0, 1.0])
    q = np.array([1.0 + gamma @ up, *np.cross(gamma, up)])
    unit: Floats = q / np.linalg.norm(q)
    return unit


def _deviating(data: dict[str, Any]) -> Deviating:
    weight = np.array(data["weight"])
    mgl = float(np.linalg.norm(weight))
    body = rigid.Body(data["moments"])
    options = {"damping": data["damping"]} if any(data["damping"]) else {}
    at = data["at"]
    return Deviating(
        name=data["name"],
        family=data["family"],
        scene=(
            rigid.HeavyTop(body, mgl=mgl, com=weight / mgl, **options)
            if mgl
            else rigid.FreeBody(body, **options)
        ),
        omega=np.array(data["omega"]),
        attitude=attitude_with(np.array(data["gamma"])),
        rate_scale=data["rate_scale"],
        tangents=np.array(data["tangents"]),
        t=np.array([state["t"] for state in at]),
        matrices=np.array([state["matrix"] for state in at]),
        growth={
            norm: {key: np.array([state[norm][key] for state in at]) for key in at[0][norm]}
            for norm in ("rates", "attitude")
        },
    )


DEVIATING = tuple(
    _deviating(data) for data in json.loads((GOLDEN / "chaos.json").read_text())["scenes"]
)
