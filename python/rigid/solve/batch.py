"""The bodies of a call as the core reads them: columns of equal length, in one unit."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _core
from .._checks.arguments import rows
from .._checks.arrays import unit_quaternions
from ..model.scene import Scene
from ..model.torque import forcing_of

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

__all__ = ["Batch"]

Floats = NDArray[np.float64]

_IDENTITY = (1.0, 0.0, 0.0, 0.0)

SLOWEST = 1e-140
"""Squares of slower rates, and their products, would underflow (rad/s)."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Batch:
    """Bodies of one kind, under one torque and damping, with their starts.

    Attributes
    ----------
    kind : str
        The :attr:`kind <rigid.model.scene.Scene.kind>` of their scene.
    moments, weight : ndarray, shape (n, 3) or (1, 3)
        Principal moments and ``mgl com``; one row may serve all bodies.
    omega : ndarray, shape (n, 3)
        Angular velocities in the body (rad/s).
    attitude : ndarray, shape (n, 4) or (1, 4)
        Unit quaternions; one row may serve all bodies.
    forcing : Forcing or None
        Torque and damping, None if nothing acts.
    scale_exponent : int
        Moments, weight and forcing are counted in units of ``2**scale_exponent``.
    """

    kind: str
    moments: Floats
    weight: Floats
    omega: Floats
    attitude: Floats
    forcing: _core.Forcing | None = None
    scale_exponent: int = 0
    _rates: dict[object, Floats] = field(default_factory=dict, init=False, repr=False)

    @classmethod
    def from_input(
        cls, scene: Scene, omega: ArrayLike, attitude: ArrayLike | Rotation | None
    ) -> tuple[Self, bool]:
        """The bodies that a call describes, and whether it describes a single one.

        Raises
        ------
        ValueError
            If an array is not finite, has the wrong shape, or holds a zero quaternion, if the rates
            are so slow that their squares underflow, or the weight, torque or damping so large that
            they overflow in the unit of the moments.
        """
        rates, single_omega = rows("omega", omega, 3)
        quaternions, single_attitude = _attitudes(attitude)
        count = _common_length(rates, quaternions, single_omega, single_attitude)
        # The largest moment is near one in this unit: no product with rates leaves the range of
        # doubles, and the unit of moments, torques and energies changes no bit of a motion.
        exponent = int(np.frexp(max(scene.body.moments))[1])
        batch = cls.of_scene(scene, rates, quaternions, count, exponent)
        batch._check_time_unit()
        return batch, single_omega and single_attitude

    @classmethod
    def of_scene(
        cls,
        scene: Scene,
        omega: Floats,
        attitude: Floats,
        count: int,
        scale_exponent: int = 0,
    ) -> Self:
        """``count`` bodies of a scene with these rates and unit quaternions, as they are."""
        return cls(
            kind=scene.kind,
            moments=_scaled("moments", np.array([scene.body.moments]), scale_exponent),
            weight=_scaled("mgl", scene.weight[np.newaxis], scale_exponent),
            omega=np.ascontiguousarray(np.broadcast_to(omega, (count, 3))),
            attitude=attitude,
            forcing=forcing_of(scene.torque, scene.damping, scale_exponent),
            scale_exponent=scale_exponent,
        )

    def __len__(self) -> int:
        return len(self.omega)

    def columns(self) -> dict[str, Any]:
        """The arguments of the core for these bodies."""
        columns: dict[str, Any] = {
            "scene": self.kind,
            "moments": self.moments,
            "weight": self.weight,
            "omega": self.omega,
            "attitude": self.attitude,
        }
        return columns if self.forcing is None else {**columns, "forcing": self.forcing}

    def full_columns(self) -> dict[str, Any]:
        """The arguments of the core with a row of moments for each body."""
        moments = np.broadcast_to(self.moments, self.omega.shape)
        return {**self.columns(), "moments": np.ascontiguousarray(moments)}

    def select(self, bodies: NDArray[np.intp]) -> Self:
        """Some of the bodies."""
        chosen = self._mapped(lambda column: column[bodies])
        chosen._rates.update({key: rates[bodies] for key, rates in self._rates.items()})
        return chosen

    def repeat(self, count: int) -> Self:
        """Each body ``count`` times in a row."""
        return self._mapped(lambda column: np.repeat(column, count, axis=0))

    def _mapped(self, change: Callable[[Floats], Floats]) -> Self:
        """The batch with its columns changed; a row that serves all bodies stays."""

        def changed(column: Floats) -> Floats:
            return change(column) if len(column) == len(self) else column

        return replace(
            self,
            moments=changed(self.moments),
            weight=changed(self.weight),
            omega=changed(self.omega),
            attitude=changed(self.attitude),
        )

    def fastest_rates(self, span: tuple[float, float], method: str | None = None) -> Floats:
        """Bounds of ``|omega|`` (rad/s), shape (n,); each is computed once.

        Parameters
        ----------
        span : tuple of float
            First and last time (s), around 0.
        method : str, optional
            Instead of bounds: the rates that the steps of this method follow. Without torque and
            damping the bounds hold for all times and are these rates.
        """
        free = self.forcing is None
        key = None if free else (span, method)
        if key not in self._rates:
            rates = (
                _core.fastest_rates(**self.full_columns())
                if free
                else _core.fastest_rates(**self.full_columns(), span=span, method=method)
            )
            rates.flags.writeable = False
            self._rates[key] = rates
        return self._rates[key]

    def closed_forms(self) -> NDArray[np.str_]:
        """The closed form of the states of each body from its start, or ""; shape (n,)."""
        if self.forcing is not None:
            return np.full(len(self), "")
        return np.array(_core.closed_forms(**self.full_columns()), dtype=np.str_)

    def _check_time_unit(self) -> None:
        """Raise ValueError for rates whose squares underflow."""
        swing = np.sqrt(np.abs(self.weight).max() / self.moments.min())
        rates = np.maximum(np.abs(self.omega).max(axis=1), swing)
        slow = np.flatnonzero((rates > 0.0) & (rates < SLOWEST))
        if len(slow):
            raise ValueError(
                f"omega[{slow[0]}]: the rates of the body are {rates[slow[0]]:.3g} rad/s at most; "
                f"they must be zero or reach {SLOWEST:g} rad/s: count the time in another unit"
            )


@np.errstate(over="ignore")
def _scaled(name: str, values: Floats, exponent: int) -> Floats:
    """The values in units of ``2**exponent``; ValueError if they are too large for it."""
    scaled: Floats = np.ldexp(values, -exponent)
    if not np.isfinite(scaled).all():
        raise ValueError(
            f"{name} = {np.abs(values).max():g}: must be below 1e308 times the largest moment, "
            f"which is of the order of {math.ldexp(1.0, exponent):g}"
        )
    return scaled


def _attitudes(attitude: ArrayLike | Rotation | None) -> tuple[Floats, bool]:
    """Unit quaternions, and whether there is only one for all bodies."""
    if attitude is None:
        return np.array([_IDENTITY]), True
    if hasattr(attitude, "as_quat"):
        attitude = attitude.as_quat(scalar_first=True)
    quaternions, single = rows("attitude", attitude, 4)
    return unit_quaternions("attitude", quaternions), single


def _common_length(
    rates: Floats, quaternions: Floats, single_omega: bool, single_attitude: bool
) -> int:
    if single_attitude:
        return len(rates)
    if single_omega or len(rates) == len(quaternions):
        return len(quaternions)
    raise ValueError(
        f"attitude: expected shape ({len(rates)}, 4) to go with omega {rates.shape}, "
        f"got {quaternions.shape}"
    )
