"""Rotation of rigid bodies: exact where physics allows, fast elsewhere, the error stated.

The main job is :func:`stability_map`; :func:`simulate` gives the states of bodies at wanted times.
Conventions: SI or any consistent units; body axes are principal axes; ``omega`` in the body
(rad/s); attitudes are unit quaternions, scalar first, active, body to space; gravity along ``-e3``
of space.
"""

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
    "build_info",
    "cite",
    "condition",
    "direction",
    "exact",
    "extremes",
    "load_map",
    "methods",
    "no_flip",
    "normal",
    "plan",
    "report",
    "simulate",
    "stability_map",
    "tilt_below",
    "uniform",
    "uniform_attitude",
]
