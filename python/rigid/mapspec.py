"""The specification of a stability map: everything that its numbers depend on."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from . import _core
from ._check import finite_float, one_of, positive_int
from .criteria import Criterion, NoFlip, TiltBelow, criterion_from_dict
from .grid import Axis, check_applicable, grid_shape, make_axes, outsides, pixels
from .methods import AUTO, EXACT, check_method, map_methods
from .plan import require_closed_forms
from .scenes import Scene, scene_from_dict
from .starts import Start

__all__ = ["MAX_STEPS", "MapSpec", "checked_seed", "core_job", "seed_from"]

MAX_STEPS = 1_000_000_000


@dataclass(frozen=True, slots=True, kw_only=True)
class MapSpec:
    """Everything that the numbers of a map depend on; round-trips through JSON.

    Attributes
    ----------
    scene : FreeBody or HeavyTop
    start : Start
    axes : tuple of Axis
        x first, then y.
    stable : NoFlip or TiltBelow
        The criterion, with no default left open.
    t_end : float
        Horizon in s.
    samples : int
        Bodies per pixel.
    method : str
        ``"auto"``: the closed form for each body that has one, else ``"rk4"``; ``"exact"``: closed
        forms only; or the name of a scheme.
    step : float or None
        Time step of the bodies that are integrated, s; None: the core picks one for each body from
        a bound of its rates.
    check : float
        Share of each pixel's bodies that is judged again by ``taylor16``, in [0, 1]. Closed forms
        are not.
    max_steps : int
        A body that needs more steps counts as failed.
    seed : int
        Key of the random numbers, 0 <= seed < 2**128.
    title : str or None
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
    check: float = 1.0
    max_steps: int = MAX_STEPS
    title: str | None = None
    version: str = field(default_factory=lambda: str(_core.build_info()["version"]))

    def __post_init__(self) -> None:
        def put(name: str, value: object) -> None:
            object.__setattr__(self, name, value)

        if not isinstance(self.start, Start):
            raise TypeError(f"start = {self.start!r}: must be a rigid.Start")
        if not isinstance(self.stable, (NoFlip, TiltBelow)):
            raise TypeError(
                f"stable = {self.stable!r}: must be a criterion, rigid.no_flip() or "
                "rigid.tilt_below(angle)"
            )
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
        if self.step is not None:
            put("step", finite_float("step", self.step, positive=True))
        put("check", finite_float("check", self.check, nonnegative=True))
        if self.check > 1.0:
            raise ValueError(f"check = {self.check}: must lie in [0, 1]")
        one_of("method", self.method, map_methods())
        driven = self.is_driven
        if driven and isinstance(self.stable, TiltBelow) and self.stable.reference != "vertical":
            raise ValueError(
                f"reference = {self.stable.reference!r}: under torque and damping a map watches "
                "tilts from the vertical only"
            )
        if self.scene.torque is not None and self.scene.torque.times:
            raise ValueError("torque: a table is not known to maps; give a constant torque")
        check_method(self.method, self.scene.kind, watched=True, driven=driven)
        if self.method == EXACT:
            require_closed_forms(self)
        put("seed", checked_seed("seed", self.seed))
        if self.title is not None and not isinstance(self.title, str):
            raise TypeError(f"title = {self.title!r}: must be a string")

    @property
    def is_driven(self) -> bool:
        """Whether torque or damping act in some pixel."""
        damped = any(axis.name.startswith("damping") for axis in self.axes)
        return damped or self.scene.outside is not None

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the arrays: ``(ny, nx)`` or ``(nx,)``."""
        return grid_shape(self.axes)

    @property
    def checked_samples(self) -> int:
        """How many bodies of each pixel are judged again by the second method."""
        # 0.07 * 100 is a little more than 7.
        return math.ceil(self.check * self.samples * (1.0 - 1e-12))

    @property
    def criterion(self) -> str:
        """Criterion and horizon in words."""
        return f"{self.stable} until t = {self.t_end:g} s"

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


def core_job(spec: MapSpec) -> _core.MapJob:
    """The request of a specification, as the core reads it."""
    rows = pixels(spec.scene, spec.start, spec.axes)
    criterion, axis, limit = spec.stable.core()
    noise, attitude_noise = spec.start.noise, spec.start.attitude_noise
    return _core.MapJob(
        scene=spec.scene.kind,
        method=spec.method,
        moments=rows.moments,
        weight=rows.weight,
        omega=rows.omega,
        omega_noise="none" if noise is None else noise.kind,
        omega_size=rows.omega_size,
        attitude=rows.attitude,
        attitude_noise="none" if attitude_noise is None else attitude_noise.kind,
        attitude_size=rows.attitude_size,
        criterion=criterion,
        axis=axis,
        limit=limit,
        t_end=spec.t_end,
        step=spec.step,
        max_steps=spec.max_steps,
        samples=spec.samples,
        checked=spec.checked_samples,
        seed=spec.seed,
        outside=outsides(spec.scene, rows),
    )


def seed_from(rng: int | np.random.Generator | np.random.SeedSequence | None) -> int:
    """The 128-bit key of the random numbers that ``rng`` stands for."""
    if rng is None:
        rng = np.random.SeedSequence()
    if isinstance(rng, np.random.SeedSequence):
        low, high = rng.generate_state(2, np.uint64).tolist()
    elif isinstance(rng, np.random.Generator):
        low, high = rng.integers(2**64, size=2, dtype=np.uint64).tolist()
    elif isinstance(rng, (int, np.integer)):
        return checked_seed("rng", rng)
    else:
        raise TypeError(
            f"rng = {rng!r}: must be a whole number, a numpy Generator or SeedSequence, or None"
        )
    return int(low) | int(high) << 64


def checked_seed(name: str, seed: object) -> int:
    """``seed`` as a key of the random numbers, a whole number of at most 128 bits."""
    if isinstance(seed, bool) or not isinstance(seed, (int, np.integer)):
        raise TypeError(f"{name} = {seed!r}: must be a whole number")
    if not 0 <= int(seed) < 2**128:
        raise ValueError(f"{name} = {seed}: must lie in 0 .. 2**128 - 1")
    return int(seed)
