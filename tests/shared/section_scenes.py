"""Poincaré sections known to 26 digits."""

import json
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

import rigid
from chaos_scenes import attitude_with
from physics import GOLDEN, Floats

__all__ = ["SECTIONED", "Sectioned"]


@dataclass(frozen=True)
class Sectioned:
    """A top, a surface, and every point until a time."""

    name: str
    scene: rigid.HeavyTop
    omega0: Floats
    attitude0: Floats
    t_end: float
    section: rigid.Section
    t: Floats
    omega: Floats
    gamma: Floats
    direction: NDArray[np.int8]
    slope: Floats


def _sectioned(data: dict[str, Any]) -> Sectioned:
    weight = np.array(data["weight"])
    mgl = float(np.linalg.norm(weight))
    is_height = data["section"] == "height-turn"
    points = data["points"]
    return Sectioned(
        name=data["name"],
        scene=rigid.HeavyTop(rigid.Body(data["moments"]), mgl=mgl, com=weight / mgl),
        omega0=np.array(data["omega"]),
        attitude0=attitude_with(np.array(data["gamma"])),
        t_end=data["T"],
        section=rigid.section(
            "height" if is_height else data["section"],
            value=data["value"],
            direction=data["direction"],
        ),
        t=np.array([point["t"] for point in points]),
        omega=np.array([point["omega"] for point in points]),
        gamma=np.array([point["gamma"] for point in points]),
        direction=np.array([point["direction"] for point in points], dtype=np.int8),
        # The reference has the rate of the potential energy.
        slope=np.array([point["slope"] for point in points]) / (mgl if is_height else 1.0),
    )


SECTIONED = tuple(
    _sectioned(data) for data in json.loads((GOLDEN / "sections.json").read_text())["scenes"]
)
