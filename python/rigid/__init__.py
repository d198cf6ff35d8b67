"""Rotation of rigid bodies: exact where physics allows, fast elsewhere, the error stated.

The main job is :func:`stability_map`; :func:`simulate` gives the states of bodies at given times.
Conventions: SI or any consistent units; body axes are principal axes; ``omega`` in the body
(rad/s); attitudes are unit quaternions, scalar first, active, body to space; gravity along ``-e3``
of space.

The modules of the textbook are imported on first access, for example ``rigid.particles``:
:mod:`~rigid.particles`, :mod:`~rigid.statics` and :mod:`~rigid.springs`; :mod:`~rigid.rotations`
and :mod:`~rigid.frames`; :mod:`~rigid.inertia`, :mod:`~rigid.solids` and :mod:`~rigid.meshes`;
:mod:`~rigid.fixed_axis`, :mod:`~rigid.free`, :mod:`~rigid.top` and :mod:`~rigid.earth`;
:mod:`~rigid.figures` and :mod:`~rigid.animation`; :mod:`~rigid.units`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from . import exact
from ._checks.moments import MomentsWarning
from ._checks.progress import Interrupted, Progress
from ._core import __version__
from .citing import cite
from .fits.fit import Fit, FitWarning, fit
from .info import build_info
from .maps.replay import Replay
from .maps.samples import Outcomes, Starts
from .maps.spec import MapSpec
from .maps.vary import sample_bodies
from .model.body import Body
from .model.bounds import (
    librates,
    near_start,
    pitch_within,
    pointing_within,
    rate_within,
    returns,
    roll_within,
    spin_above,
    tilt_between,
    yaw_within,
)
from .model.criteria import no_flip, regular, tilt_below
from .model.events import Event, crosses, turns
from .model.forces import EnergySink
from .model.judged import States, judged
from .model.measures import (
    drift,
    flips,
    largest_pitch,
    largest_roll,
    largest_tilt,
    largest_yaw,
    libration_amplitude,
    mean_rate,
    obliquity,
    spin_orbit_ratio,
    time_to_leave,
    time_to_settle,
)
from .model.mixture import Mixture, mixture
from .model.noise import (
    Noise,
    Samples,
    direction,
    normal,
    samples,
    uniform,
    uniform_attitude,
    von_mises_fisher,
)
from .model.orbit import Orbit, OrbitTable
from .model.sampled import RotorTable
from .model.scene import FreeBody, HeavyTop
from .model.start import Start
from .model.torque import Torque
from .planning import plan
from .reports.compute import report
from .reports.data import Row
from .reports.result import Report
from .reports.scheme import Scheme, scheme
from .reports.stress import Extremes, extremes
from .sections.crossings import Crossings
from .sections.poincare import poincare
from .sections.surface import Section, section
from .solve.attitude_ephemeris import AttitudeEphemeris, load_aem
from .solve.chunks import simulate_chunks
from .solve.events import Events
from .solve.frequencies import FrequencyDrift, Lines, frequencies, frequency_drift
from .solve.growth import Growth, LyapunovTime
from .solve.lyapunov import lyapunov
from .solve.methods import Method, methods
from .solve.motion import Motion
from .solve.plan import Plan
from .solve.run import OrbitStates, Run
from .solve.saved import load_run
from .solve.simulate import simulate
from .solve.status import Status
from .solve.tangent import condition
from .store.call import stability_map
from .store.result import StabilityMap, load_map

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
        units,
    )
    from .literature.validation import Validation, validation
    from .store.store import Store, diff, merge, open_store

__all__ = [
    "AttitudeEphemeris",
    "Body",
    "Crossings",
    "EnergySink",
    "Event",
    "Events",
    "Extremes",
    "Fit",
    "FitWarning",
    "FreeBody",
    "FrequencyDrift",
    "Growth",
    "HeavyTop",
    "Interrupted",
    "Lines",
    "LyapunovTime",
    "MapSpec",
    "Method",
    "Mixture",
    "MomentsWarning",
    "Motion",
    "Noise",
    "Orbit",
    "OrbitStates",
    "OrbitTable",
    "Outcomes",
    "Plan",
    "Progress",
    "Replay",
    "Report",
    "RotorTable",
    "Row",
    "Run",
    "Samples",
    "Scheme",
    "Section",
    "StabilityMap",
    "Start",
    "Starts",
    "States",
    "Status",
    "Store",
    "Torque",
    "Validation",
    "__version__",
    "animation",
    "build_info",
    "cite",
    "condition",
    "crosses",
    "diff",
    "direction",
    "drift",
    "earth",
    "exact",
    "extremes",
    "figures",
    "fit",
    "fixed_axis",
    "flips",
    "frames",
    "free",
    "frequencies",
    "frequency_drift",
    "inertia",
    "judged",
    "largest_pitch",
    "largest_roll",
    "largest_tilt",
    "largest_yaw",
    "librates",
    "libration_amplitude",
    "load_aem",
    "load_map",
    "load_run",
    "lyapunov",
    "mean_rate",
    "merge",
    "meshes",
    "methods",
    "mixture",
    "near_start",
    "no_flip",
    "normal",
    "obliquity",
    "open_store",
    "particles",
    "pitch_within",
    "plan",
    "poincare",
    "pointing_within",
    "rate_within",
    "regular",
    "report",
    "returns",
    "roll_within",
    "rotations",
    "sample_bodies",
    "samples",
    "scheme",
    "section",
    "simulate",
    "simulate_chunks",
    "solids",
    "spin_above",
    "spin_orbit_ratio",
    "springs",
    "stability_map",
    "statics",
    "tilt_below",
    "tilt_between",
    "time_to_leave",
    "time_to_settle",
    "top",
    "turns",
    "uniform",
    "uniform_attitude",
    "units",
    "validation",
    "von_mises_fisher",
    "yaw_within",
]

if not TYPE_CHECKING:  # a type checker would take any name for a module
    _LATER = {
        **dict.fromkeys(("Store", "diff", "merge", "open_store"), ".store.store"),
        **dict.fromkeys(("Validation", "validation"), ".literature.validation"),
    }

    def __getattr__(name: str) -> object:
        """Modules, and what runs stored maps or the literature, are imported when first named."""
        from importlib import import_module

        if name in _LATER:
            return getattr(import_module(_LATER[name], __name__), name)
        if name in __all__:
            return import_module(f".{name}", __name__)
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
