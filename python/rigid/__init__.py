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

from importlib import import_module
from typing import TYPE_CHECKING, Any

from . import exact
from ._checks.progress import Interrupted, Progress
from ._core import __version__
from .citing import cite
from .info import build_info
from .maps.compute import plug_in_store, stability_map
from .maps.replay import Replay
from .maps.result import StabilityMap, load_map, plug_in_explorer
from .maps.samples import Outcomes, Starts
from .maps.spec import MapSpec
from .model.body import Body
from .model.bounds import near_start, rate_within, returns, spin_above, tilt_between
from .model.criteria import no_flip, regular, tilt_below
from .model.events import Event, crosses, turns
from .model.forces import EnergySink
from .model.judged import States, judged
from .model.measures import drift, flips, largest_tilt, mean_rate, time_to_leave
from .model.mixture import Mixture, mixture
from .model.scene import FreeBody, HeavyTop
from .model.start import (
    Noise,
    Samples,
    Start,
    direction,
    normal,
    samples,
    uniform,
    uniform_attitude,
    von_mises_fisher,
)
from .model.torque import Torque
from .planning import plan
from .reports.compute import report
from .reports.result import Report
from .reports.row import Row
from .reports.stress import Extremes, extremes
from .sections.crossings import Crossings
from .sections.poincare import poincare
from .sections.surface import Section, section
from .solve.chunks import simulate_chunks
from .solve.events import Events
from .solve.fit import Fit, FitWarning, fit
from .solve.frequencies import FrequencyDrift, Lines, frequencies, frequency_drift
from .solve.growth import Growth
from .solve.lyapunov import lyapunov
from .solve.methods import Method, methods
from .solve.motion import Motion
from .solve.other_times import states_at as _states_at
from .solve.plan import Plan
from .solve.run import Run, load_run, plug_in_animator, plug_in_evaluator
from .solve.sensitivity import condition
from .solve.simulate import simulate
from .solve.status import Status

if TYPE_CHECKING:
    from os import PathLike
    from pathlib import Path

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
    from .store.store import Store, diff, merge, open_store

__all__ = [
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
    "MapSpec",
    "Method",
    "Mixture",
    "Motion",
    "Noise",
    "Outcomes",
    "Plan",
    "Progress",
    "Replay",
    "Report",
    "Row",
    "Run",
    "Samples",
    "Section",
    "StabilityMap",
    "Start",
    "Starts",
    "States",
    "Status",
    "Store",
    "Torque",
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
    "largest_tilt",
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
    "open_store",
    "particles",
    "plan",
    "poincare",
    "rate_within",
    "regular",
    "report",
    "returns",
    "rotations",
    "samples",
    "section",
    "simulate",
    "simulate_chunks",
    "solids",
    "spin_above",
    "springs",
    "stability_map",
    "statics",
    "tilt_below",
    "tilt_between",
    "time_to_leave",
    "top",
    "turns",
    "uniform",
    "uniform_attitude",
    "units",
    "von_mises_fisher",
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
        "units",
    )
)
"""Modules that are imported when they are first named."""

_OF_STORE = frozenset(("Store", "diff", "merge", "open_store"))
"""Names of :mod:`rigid.store.store`, which is imported with the first of them."""

if not TYPE_CHECKING:  # a type checker would take any name for a module

    def __getattr__(name: str) -> Any:
        if name in _LATER:
            return import_module(f".{name}", __name__)
        if name in _OF_STORE:
            return getattr(import_module(".store.store", __name__), name)
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def _animate(run: Run, path: str | PathLike[str] | None, **options: Any) -> Any:
    """:func:`rigid.animation.animate`, imported when it is first called."""
    from .animation import animate

    return animate(run, path, **options)


plug_in_animator(_animate)


def _explore(result: StabilityMap, path: str | PathLike[str], **options: Any) -> Path:
    """:func:`rigid.animation.explorer.explore`, imported when it is first called."""
    from .animation.explorer import explore

    return explore(result, path, **options)


def _widget(result: StabilityMap, **options: Any) -> Any:
    """The view of :mod:`rigid.animation.widget`, imported when it is first called."""
    from .animation.widget import MapWidget

    return MapWidget(result, **options)


plug_in_explorer(_explore, _widget)
plug_in_evaluator(_states_at)


def _run_stored(spec: MapSpec, **options: Any) -> StabilityMap:
    """:func:`rigid.store.store.run_stored`, imported when it is first called."""
    from .store.store import run_stored

    return run_stored(spec, **options)


plug_in_store(_run_stored)


def __dir__() -> list[str]:
    return sorted(globals().keys() | _LATER | _OF_STORE)
