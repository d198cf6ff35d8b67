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

from . import exact as exact
from ._checks.exported import exported as _exported
from ._checks.moments import MomentsWarning as MomentsWarning
from ._checks.progress import Interrupted as Interrupted
from ._checks.progress import Progress as Progress
from ._core import __version__ as __version__
from .citing import cite as cite
from .fits.fit import Fit as Fit
from .fits.fit import FitWarning as FitWarning
from .fits.fit import fit as fit
from .info import build_info as build_info
from .maps.replay import Replay as Replay
from .maps.samples import Outcomes as Outcomes
from .maps.samples import Starts as Starts
from .maps.spec import MapSpec as MapSpec
from .maps.vary import sample_bodies as sample_bodies
from .model.body import Body as Body
from .model.bounds import librates as librates
from .model.bounds import near_start as near_start
from .model.bounds import no_flip as no_flip
from .model.bounds import pitch_within as pitch_within
from .model.bounds import pointing_within as pointing_within
from .model.bounds import rate_within as rate_within
from .model.bounds import returns as returns
from .model.bounds import roll_within as roll_within
from .model.bounds import spin_above as spin_above
from .model.bounds import tilt_below as tilt_below
from .model.bounds import tilt_between as tilt_between
from .model.bounds import yaw_within as yaw_within
from .model.criteria import regular as regular
from .model.events import Event as Event
from .model.events import crosses as crosses
from .model.events import turns as turns
from .model.forces import EnergySink as EnergySink
from .model.judged import States as States
from .model.judged import judged as judged
from .model.measures import drift as drift
from .model.measures import flips as flips
from .model.measures import largest_pitch as largest_pitch
from .model.measures import largest_roll as largest_roll
from .model.measures import largest_tilt as largest_tilt
from .model.measures import largest_yaw as largest_yaw
from .model.measures import libration_amplitude as libration_amplitude
from .model.measures import mean_rate as mean_rate
from .model.measures import obliquity as obliquity
from .model.measures import spin_orbit_ratio as spin_orbit_ratio
from .model.measures import time_to_leave as time_to_leave
from .model.measures import time_to_settle as time_to_settle
from .model.mixture import Mixture as Mixture
from .model.mixture import mixture as mixture
from .model.noise import Noise as Noise
from .model.noise import Samples as Samples
from .model.noise import direction as direction
from .model.noise import normal as normal
from .model.noise import samples as samples
from .model.noise import uniform as uniform
from .model.noise import uniform_attitude as uniform_attitude
from .model.noise import von_mises_fisher as von_mises_fisher
from .model.orbit import Orbit as Orbit
from .model.orbit import OrbitTable as OrbitTable
from .model.sampled import RotorTable as RotorTable
from .model.scene import FreeBody as FreeBody
from .model.scene import HeavyTop as HeavyTop
from .model.start import Start as Start
from .model.torque import Torque as Torque
from .planning import plan as plan
from .reports.compute import report as report
from .reports.data import Row as Row
from .reports.result import Report as Report
from .reports.scheme import Scheme as Scheme
from .reports.scheme import scheme as scheme
from .reports.stress import Extremes as Extremes
from .reports.stress import extremes as extremes
from .sections.crossings import Crossings as Crossings
from .sections.poincare import poincare as poincare
from .sections.surface import Section as Section
from .sections.surface import section as section
from .solve.attitude_ephemeris import AttitudeEphemeris as AttitudeEphemeris
from .solve.attitude_ephemeris import load_aem as load_aem
from .solve.chunks import simulate_chunks as simulate_chunks
from .solve.events import Events as Events
from .solve.frequencies import FrequencyDrift as FrequencyDrift
from .solve.frequencies import Lines as Lines
from .solve.frequencies import frequencies as frequencies
from .solve.frequencies import frequency_drift as frequency_drift
from .solve.growth import Growth as Growth
from .solve.growth import LyapunovTime as LyapunovTime
from .solve.lyapunov import lyapunov as lyapunov
from .solve.methods import Method as Method
from .solve.methods import methods as methods
from .solve.motion import Motion as Motion
from .solve.plan import Plan as Plan
from .solve.run import OrbitStates as OrbitStates
from .solve.run import Run as Run
from .solve.saved import load_run as load_run
from .solve.simulate import simulate as simulate
from .solve.status import Status as Status
from .solve.tangent import condition as condition
from .store.call import stability_map as stability_map
from .store.result import StabilityMap as StabilityMap
from .store.result import load_map as load_map

if TYPE_CHECKING:  # a type checker would take any name for a module
    from . import animation as animation
    from . import earth as earth
    from . import figures as figures
    from . import fixed_axis as fixed_axis
    from . import frames as frames
    from . import free as free
    from . import inertia as inertia
    from . import meshes as meshes
    from . import particles as particles
    from . import rotations as rotations
    from . import solids as solids
    from . import springs as springs
    from . import statics as statics
    from . import top as top
    from . import units as units
    from .literature.validation import Validation as Validation
    from .literature.validation import validation as validation
    from .store.store import Store as Store
    from .store.store import diff as diff
    from .store.store import merge as merge
    from .store.store import open_store as open_store

_MODULES = (
    *("animation", "earth", "figures", "fixed_axis", "frames", "free", "inertia", "meshes"),
    *("particles", "rotations", "solids", "springs", "statics", "top", "units"),
)
_LATER = {
    **dict.fromkeys(("Store", "diff", "merge", "open_store"), ".store.store"),
    **dict.fromkeys(("Validation", "validation"), ".literature.validation"),
}
__all__ = sorted({"__version__", "exact", *_exported(globals()), *_MODULES, *_LATER})

if not TYPE_CHECKING:

    def __getattr__(name: str) -> object:
        """Modules, and what runs stored maps or the literature, are imported when first named."""
        from importlib import import_module

        if name in _LATER:
            return getattr(import_module(_LATER[name], __name__), name)
        if name in _MODULES:
            return import_module(f".{name}", __name__)
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return __all__
