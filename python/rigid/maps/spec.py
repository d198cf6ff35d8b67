"""The specification of a stability map: everything that its numbers depend on."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from .. import _core
from .._checks.arguments import brief, finite_float, one_of, positive_int
from .._moments import possible
from ..model.criteria import Criterion, check_criterion, criterion_from_dict
from ..model.scene import Scene, scene_from_dict
from ..model.seed import checked_seed
from ..model.start import Start
from ..solve.closed_form import FORCED_RULE, closed_forms, question_words, rule
from ..solve.methods import (
    AUTO,
    EXACT,
    GROWTH_FALLBACK,
    MAP_FALLBACK,
    check_method,
    map_methods,
)
from ..solve.tangent import check_tangent
from .grid import NominalStarts, grid_shape, nominal_starts
from .parameters import Axis, check_applicable, make_axes
from .sequential import Looks, checked_half_width, stop_table

__all__ = ["MapSpec"]

MOST_TITLE = 1000
"""Most characters of a title, so that a file of a map has a known size."""


@dataclass(frozen=True, kw_only=True)
class MapSpec:
    """Everything that the numbers of a map depend on; round-trips through JSON.

    Attributes
    ----------
    scene : FreeBody or HeavyTop
    start : Start
    axes : tuple of Axis
        x first, then y.
    stable : NoFlip, TiltBelow or Regular
        The criterion, with no default left open.
    t_end : float
        Horizon in s.
    samples : int
        Bodies per pixel.
    method : str
        ``"auto"``: the closed form for each body that has one, else ``"taylor12"``, or ``"dop853"``
        where displacements are integrated; ``"exact"``: closed forms only; or the name of a scheme.
    step : float or None
        Time step of the bodies that are integrated, s; None: the core picks one for each body from
        a bound of its rates.
    check : float or None
        Share of the bodies of a pixel that ``taylor16`` classifies too, as a cross-check, in
        [0, 1]; None: the bodies whose class an error could change, and an audit of the others.
        Bodies with a closed form need none.
    max_steps : int
        A body that needs more steps counts as failed.
    half_width : float or None
        A pixel gets bodies until the interval of its share is no wider than twice this;
        ``samples`` is the most that it gets.
    refine : int or None
        Every so many rows and columns are computed first, and between them what differs.
    budget : int or None
        Most bodies of the map.
    seed : int
        Key of the random numbers, 0 <= seed < 2**128.
    title : str or None
        At most 1000 characters.
    version : str
        Version of rigid.
    """

    scene: Scene
    start: Start
    axes: tuple[Axis, ...]
    stable: Criterion
    t_end: float
    samples: int
    seed: int
    method: str = AUTO
    step: float | None = None
    check: float | None = None
    max_steps: int = 1_000_000_000
    half_width: float | None = None
    refine: int | None = None
    budget: int | None = None
    title: str | None = None
    version: str = field(default_factory=lambda: str(_core.build_info()["version"]))

    def __post_init__(self) -> None:
        def put(name: str, value: object) -> None:
            object.__setattr__(self, name, value)

        if not isinstance(self.start, Start):
            raise TypeError(f"start = {brief(self.start)}: must be a rigid.Start")
        check_criterion("stable", self.stable)
        check_applicable(self.scene, self.start, self.axes)
        put("stable", self.stable.resolved(self.scene, self.start))
        put("t_end", finite_float("t_end", self.t_end, positive=True))
        put("samples", positive_int("samples", self.samples))
        put("max_steps", positive_int("max_steps", self.max_steps))
        for name, count in (
            ("samples", self.samples * math.prod(self.shape)),
            ("max_steps", self.max_steps),
        ):
            if count >= 2**63:
                raise ValueError(f"{name} = {getattr(self, name)}: too many to count")
        if self.half_width is not None:
            put("half_width", checked_half_width(self.half_width))
            last = stop_table(self.half_width).last
            if self.samples != last:
                raise ValueError(
                    f"samples = {self.samples}: with half_width = {self.half_width} they are {last}"
                )
        if self.refine is not None:
            put("refine", positive_int("refine", self.refine, minimum=2))
        if self.budget is not None:
            put("budget", positive_int("budget", self.budget))
        if self.step is not None:
            put("step", finite_float("step", self.step, positive=True))
        if self.check is not None:
            put("check", finite_float("check", self.check, nonnegative=True))
            if self.check > 1.0:
                raise ValueError(f"check = {self.check}: must lie in [0, 1]")
        one_of("method", self.method, map_methods())
        if self.is_driven:
            self.stable.check_forced()
        if self.scene.torque is not None and self.scene.torque.times:
            raise ValueError("torque: maps accept constant torques only, not a table")
        check_method(
            self.method,
            self.scene.kind,
            watched=True,
            driven=self.is_driven,
            satellite=self.scene.is_satellite,
        )
        if self.stable.displaced and self.method != AUTO:
            check_tangent(self.method, driven=self.is_driven)
        if self.method == EXACT:
            self._require_closed_forms()
        put("seed", checked_seed("seed", self.seed))
        if self.title is not None and not isinstance(self.title, str):
            raise TypeError(f"title = {brief(self.title)}: must be a string")
        if self.title is not None and len(self.title) > MOST_TITLE:
            raise ValueError(
                f"title of {len(self.title)} characters: must have at most {MOST_TITLE}"
            )
        if not isinstance(self.version, str):
            raise TypeError(f"version = {brief(self.version)}: must be a string")

    @property
    def is_driven(self) -> bool:
        """Whether torque or damping act in some pixel."""
        damped = any(axis.parameter.describes == "damping" for axis in self.axes)
        return damped or self.scene.is_driven

    @cached_property
    def grid(self) -> NominalStarts:
        """The nominal start of every pixel, computed once."""
        return nominal_starts(self.scene, self.start, self.axes)

    def __getstate__(self) -> dict[str, Any]:
        """The fields without the grid, which follows from them."""
        return {name: getattr(self, name) for name in self.__dataclass_fields__}

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the arrays: ``(ny, nx)`` or ``(nx,)``."""
        return grid_shape(self.axes)

    @property
    def varied(self) -> tuple[str, ...]:
        """The numbers of the scene and start that the axes set; a ratio sets its numerator."""
        return tuple(axis.parameter.sets or axis.name for axis in self.axes)

    def checked_samples(self, samples: range) -> int | None:
        """How many of these bodies of a pixel the second method classifies too, None if it depends.

        It then depends on the margins of the bodies.
        """
        if self.check is None:
            return None
        # 0.07 * 100 is a little more than 7.
        if self.looks is not None:
            return math.ceil(self.check * len(samples) * (1.0 - 1e-12))
        checked = math.ceil(self.check * self.samples * (1.0 - 1e-12))
        return min(max(checked - samples.start, 0), len(samples))

    @property
    def looks(self) -> Looks | None:
        """When the pixels of a sequential map stop; None for a given number of samples."""
        return None if self.half_width is None else stop_table(self.half_width)

    @property
    def criterion(self) -> str:
        """Criterion and horizon in words."""
        return self.stable.until(self.t_end)

    @property
    def scheme(self) -> str:
        """The scheme of the bodies without a closed form."""
        if self.method not in (AUTO, EXACT):
            return self.method
        return GROWTH_FALLBACK if self.stable.displaced else MAP_FALLBACK

    def _require_closed_forms(self) -> None:
        """Raise ValueError, naming the first, if a possible body has no closed form."""
        if self.is_driven:
            raise ValueError(f"method = {EXACT!r}: {FORCED_RULE}")
        moments, weight = self.grid.moments, self.grid.weight
        missing = possible(moments) & (closed_forms(self.stable, moments, weight) == "")
        if missing.any():
            flat = int(np.argmax(missing))
            pixel = tuple(int(i) for i in np.unravel_index(flat, self.shape))
            values = ", ".join(f"{moment:g}" for moment in moments[flat])
            raise ValueError(
                f"method = {EXACT!r}: no closed form of {question_words(self.stable)} for the body "
                f"of pixel {pixel}, moments ({values}); {rule(self.stable)}"
            )

    def to_dict(self) -> dict[str, Any]:
        """The specification as a JSON-able dictionary; :meth:`from_dict` is its inverse."""
        return {
            "scene": self.scene.to_dict(),
            "start": self.start.to_dict(),
            "axes": [{"name": axis.name, "values": list(axis.values)} for axis in self.axes],
            "stable": self.stable.to_dict(),
            "t_end": self.t_end,
            "samples": self.samples,
            "method": self.method,
            "step": self.step,
            "check": self.check,
            "max_steps": self.max_steps,
            # Maps without these have the bytes that they had before there were any.
            **{
                name: getattr(self, name)
                for name in ("half_width", "refine", "budget")
                if getattr(self, name) is not None
            },
            "seed": self.seed,
            "title": self.title,
            "version": self.version,
        }

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> MapSpec:
        """The specification that :meth:`to_dict` described."""
        values = dict(data)
        values["scene"] = scene_from_dict(values["scene"])
        values["start"] = Start.from_dict(values["start"])
        values["axes"] = make_axes({axis["name"]: axis["values"] for axis in values["axes"]})
        values["stable"] = criterion_from_dict(values["stable"])
        return cls(**values)

    def to_json(self) -> str:
        """The specification as JSON text; floats keep all their digits."""
        return json.dumps(self.to_dict(), allow_nan=False)

    @classmethod
    def from_json(cls, text: str) -> MapSpec:
        """The specification that :meth:`to_json` wrote."""
        return cls.from_dict(json.loads(text))
