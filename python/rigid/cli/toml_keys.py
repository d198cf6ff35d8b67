"""The keys of specifications in TOML, with their types, units and meanings.

The readers accept these keys and no others, and the page of the file formats is made from them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from ..maps.spec import MapSpec
from ..model.forces import FORCES, FreeForces, TopForces
from ..model.measures import MEASURES
from ..model.start import NOISE_KINDS
from ..reports.spec import BODIES, ReportSpec

__all__ = [
    "AXIS",
    "FREE_SCENE",
    "MAP",
    "MAP_RUN",
    "MEASURE",
    "NOISE",
    "ORBIT",
    "PLOT",
    "REPORT",
    "REPORT_RUN",
    "REPORT_START",
    "SCENE",
    "SECTION",
    "SECTION_RUN",
    "SECTION_START",
    "START",
    "SURFACE",
    "Key",
]


@dataclass(frozen=True, slots=True)
class Key:
    """A key of a table.

    Attributes
    ----------
    kind : str
        Type of the value.
    meaning : str
        What the value says.
    unit : str
        Unit of numbers, empty if they have none.
    default : str
        Value of a key that is omitted; empty if it must be given or there is none.
    """

    kind: str
    meaning: str
    unit: str = ""
    default: str = ""


_TITLE = {"title": Key("text", "title of the picture")}
_SCENE_TABLE = {"scene": Key("table", "body, weight, torque and damping")}

MAP: Mapping[str, Key] = {
    **_TITLE,
    **_SCENE_TABLE,
    "x": Key("table", "first axis of the grid"),
    "y": Key("table", "second axis", default="one axis only"),
    "z": Key("table", "third axis; then axis4, and so on", default="two axes only"),
    "start": Key("table", "how bodies begin, and how they are perturbed"),
    "stable": Key("table", "the criterion"),
    "run": Key("table", "horizon, number of bodies, method"),
}

REPORT: Mapping[str, Key] = {
    **_TITLE,
    **_SCENE_TABLE,
    "start": Key("table", "how the body begins"),
    "run": Key("table", "horizon, methods, errors"),
}

SECTION: Mapping[str, Key] = {
    **_TITLE,
    **_SCENE_TABLE,
    "section": Key("table", "the surface"),
    "start": Key("table", "energy and number of the motions"),
    "run": Key("table", "when the motions end"),
    "plot": Key("table", "the picture"),
}


def _further(keywords: type) -> dict[str, Key]:
    """The keys of the further forces that are keywords of a scene."""
    return {
        name: Key(force.in_toml, force.meaning, force.unit, "none")
        for name, force in FORCES.items()
        if name in keywords.__annotations__
    }


SCENE: Mapping[str, Key] = {
    "kind": Key("text", "`free-body` or `heavy-top`; a heavy top has the keys `mgl` and `com` too"),
    "moments": Key("3 numbers", "principal moments of inertia, instead of `box`", "kg m²"),
    "physical": Key("true or false", "must a body be able to have the moments", "", "true"),
    "box": Key("3 numbers", "sides of a homogeneous box along axes 1, 2, 3", "m"),
    "mass": Key("number", "mass of the box", "kg", "1"),
    "mgl": Key("number", "weight × distance from fixed point to centre of mass", "J"),
    "com": Key("3 numbers", "direction of the centre of mass in the body", "", "[0, 0, 1]"),
    "torque": Key("3 numbers", "constant torque in the body", "N m", "none"),
    "torque_in_space": Key("3 numbers", "constant torque in space", "N m", "none"),
    "damping": Key("number, 3 or 3×3", "the torque is `-damping * omega`", "N m s/rad", "none"),
    **_further(TopForces),
}

FREE_SCENE: Mapping[str, Key] = {
    **{name: key for name, key in _further(FreeForces).items() if name not in SCENE},
}
"""Further keys of the scene of a free body."""

ORBIT: Mapping[str, Key] = {
    "rate": Key("number", "mean motion: 2π over the period", "rad/s"),
    "eccentricity": Key("number", "from 0, a circle, to 0.95", "", "0"),
    "anomaly": Key("number", "mean anomaly at `t = 0`", "rad", "0"),
    "true_anomaly": Key("number", "angle from the periapsis at `t = 0`, instead", "rad", "none"),
    "normal": Key("3 numbers", "normal of the orbit in space", "", "[0, 0, 1]"),
    "periapsis": Key("3 numbers", "direction of the periapsis in space", "", "[1, 0, 0]"),
}

AXIS: Mapping[str, Key] = {
    "name": Key("text", "the parameter that varies, see below"),
    "values": Key("numbers", "its values, instead of `from`, `to` and `count`"),
    "from": Key("number", "first value"),
    "to": Key("number", "last value"),
    "count": Key("whole number", "how many values"),
    "scale": Key("text", "`linear` or `log`", "", "linear"),
}

_NOMINAL: Mapping[str, Key] = {
    "omega": Key("3 numbers", "rates in the body, instead of `spin`", "rad/s"),
    "spin": Key("number", "rate about `axis`", "rad/s"),
    "axis": Key("1, 2 or 3", "body axis of the spin and of the tilt", "", "3"),
    "tilt": Key("number", "angle of the axis from the vertical", "rad", "0"),
    "attitude": Key("4 numbers", "instead of `tilt`: quaternion (w, x, y, z)", "", "none"),
}

START: Mapping[str, Key] = {
    **_NOMINAL,
    "noise": Key("table", "random part of the rates", "", "none"),
    "attitude_noise": Key("table", "random rotation of the attitude", "", "none"),
    "weight": Key(
        "number", "how likely this one of several `[[start]]` is, relative to the others", "", "1"
    ),
}

NOISE: Mapping[str, Key] = {
    "kind": Key("text", ", ".join(f"`{kind}`" for kind in NOISE_KINDS)),
    "size": Key("number or 3", "size; omitted if an axis varies it", "rad/s or rad"),
    "kappa": Key("number", "instead of `size`: concentration of `von_mises_fisher`"),
    "cov": Key("3 x 3 or 6 x 6", "instead of `size`: covariance of `normal`", "(rad/s)², rad²"),
}

MAP_RUN: Mapping[str, Key] = {
    "t_end": Key("number", "horizon: *stable* means stable until then", "s"),
    "samples": Key("whole number", "bodies in each pixel"),
    "half_width": Key("number", "instead of `samples`: half the width of each interval"),
    "refine": Key(
        "whole number", "every such pixel first, then the pixels between different shares", "", "1"
    ),
    "budget": Key("whole number", "most bodies of the map", "", "no limit"),
    "method": Key("text", "`auto`, `exact` or a method", "", MapSpec.method),
    "step": Key("number", "time step", "s", "chosen for each body"),
    "check": Key(
        "number", "share of the integrated bodies that a second method classifies", "", "by doubt"
    ),
    "max_steps": Key(
        "whole number",
        "a body that needs more steps counts as failed",
        "",
        f"{MapSpec.max_steps:,}",
    ),
    "seed": Key("whole number", "key of the random numbers", "", "a new one"),
    "measure": Key("texts or tables", "numbers to collect of each body, see below", "", "none"),
}

MEASURE: Mapping[str, Key] = {
    "name": Key("text", ", ".join(f"`{name}`" for name in MEASURES)),
    "axis": Key("1, 2, 3, ...", "body axis of a measure that has one"),
    "reference": Key("text", "of `largest_tilt`: `vertical` or `start`"),
}

REPORT_START: Mapping[str, Key] = _NOMINAL

REPORT_RUN: Mapping[str, Key] = {
    "t_end": Key("number", "horizon; not used by `--long`", "s"),
    "revolutions": Key("numbers", "horizons in revolutions, instead of `t_end`"),
    "unit": Key("text", "name of the unit of time", "", ReportSpec.unit),
    "bodies": Key(
        "whole number",
        "perturbed bodies that are measured",
        "",
        f"{ReportSpec.bodies}, over revolutions {BODIES}",
    ),
    "errors": Key(
        "numbers",
        "errors for which the table gives the cost",
        "rad",
        ", ".join(map(str, ReportSpec.errors)),
    ),
    "seed": Key("whole number", "key of the perturbations", "", str(ReportSpec.seed)),
    "methods": Key("texts", "the methods to measure", "", "all"),
}

SURFACE: Mapping[str, Key] = {
    "name": Key("text", "`height`, or a component such as `gamma1`"),
    "value": Key("number", "value of the component on the surface", "", "0"),
    "direction": Key("1, -1 or 0", "rising, falling, or both", "", "-1 for `height`, else 1"),
    "omega": Key("3 numbers", "weights of the rates, for another plane"),
    "gamma": Key("3 numbers", "weights of the vertical"),
}

SECTION_START: Mapping[str, Key] = {
    "energy": Key("number", "energy of all motions", "J"),
    "l_gamma": Key("number", "vertical component of their angular momentum", "kg m²/s"),
    "bodies": Key("whole number", "number of motions"),
    "seed": Key("whole number", "key of the random starts", "", "a new one"),
}

SECTION_RUN: Mapping[str, Key] = {
    "points": Key("whole number", "most points of a motion", "", "no limit"),
    "t_end": Key("number", "longest time", "s"),
}

PLOT: Mapping[str, Key] = {
    "x": Key("text", "component along the horizontal axis"),
    "y": Key("text", "component along the vertical axis"),
}
