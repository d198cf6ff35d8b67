"""Rotation of rigid bodies: exact where physics allows, fast elsewhere, the error stated.

The main job is :func:`stability_map`; :func:`simulate` gives the states of bodies at wanted times.
Conventions: SI or any consistent units; body axes are principal axes; ``omega`` in the body
(rad/s); attitudes are unit quaternions, scalar first, active, body to space; gravity along ``-e3``
of space.

The textbook is in modules that load when they are first named, ``rigid.particles`` say:
:mod:`~rigid.particles`, :mod:`~rigid.statics` and :mod:`~rigid.springs`; :mod:`~rigid.rotations`
and :mod:`~rigid.frames`; :mod:`~rigid.inertia`, :mod:`~rigid.solids` and :mod:`~rigid.meshes`;
:mod:`~rigid.fixed_axis`, :mod:`~rigid.free`, :mod:`~rigid.top` and :mod:`~rigid.earth`;
:mod:`~rigid.figures` and :mod:`~rigid.animation`.
"""

from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING

from . import exact
from ._core import __version__
from .bodies import Body
from .citing import cite
from .conditioning import condition
from .criteria import no_flip, tilt_below
from .extremes import Extremes, extremes
from .forces import Torque
from .info import build_info
from .mapfile import load_map
from .mapresult import Replay, StabilityMap
from .maps import stability_map
from .mapspec import MapSpec
from .methods import Method, methods
from .plan import Plan, plan
from .progress import Progress
from .report import report
from .reportresult import Report, Row
from .scenes import FreeBody, HeavyTop
from .simulate import Run, Status, simulate
from .starts import Noise, Start, direction, normal, uniform, uniform_attitude

if TYPE_CHECKING:
    from . import (
        animation,
        earth,
        figures,
        fixed_axis,
        frames,
        free,
        inertia,
        meshes,
        particles,
        rotations,
        solids,
        springs,
        statics,
        top,
    )

__all__ = [
    "Body",
    "Extremes",
    "FreeBody",
    "HeavyTop",
    "MapSpec",
    "Method",
    "Noise",
    "Plan",
    "Progress",
    "Replay",
    "Report",
    "Row",
    "Run",
    "StabilityMap",
    "Start",
    "Status",
    "Torque",
    "__version__",
    "animation",
    "build_info",
    "cite",
    "condition",
    "direction",
    "earth",
    "exact",
    "extremes",
    "figures",
    "fixed_axis",
    "frames",
    "free",
    "inertia",
    "load_map",
    "meshes",
    "methods",
    "no_flip",
    "normal",
    "particles",
    "plan",
    "report",
    "rotations",
    "simulate",
    "solids",
    "springs",
    "stability_map",
    "statics",
    "tilt_below",
    "top",
    "uniform",
    "uniform_attitude",
]

_LATER = frozenset(
    (
        "animation",
        "earth",
        "figures",
        "fixed_axis",
        "frames",
        "free",
        "inertia",
        "meshes",
        "particles",
        "rotations",
        "solids",
        "springs",
        "statics",
        "top",
    )
)
"""Modules that are imported when they are first named."""

if not TYPE_CHECKING:  # a type checker would take any name for a module

    def __getattr__(name: str) -> ModuleType:
        if name in _LATER:
            return import_module(f".{name}", __name__)
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(globals().keys() | _LATER)
