"""The bodies of a request as the columns that the core reads."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core
from ._check import rows
from .forces import outside_of
from .scenes import FreeBody, HeavyTop, Scene

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

__all__ = ["check_scene", "columns", "each_row", "fastest_rates", "laid_out", "unit_of"]

_IDENTITY = (1.0, 0.0, 0.0, 0.0)

SLOWEST = 1e-140
"""Squares of slower rates, and their products, would underflow (rad/s)."""


def check_scene(scene: object) -> Scene:
    """``scene`` if it is one."""
    if not isinstance(scene, (FreeBody, HeavyTop)):
        raise TypeError(f"scene = {scene!r}: must be a rigid.FreeBody or rigid.HeavyTop")
    return scene


def columns(
    scene: Scene, omega: ArrayLike, attitude: ArrayLike | Rotation | None
) -> tuple[dict[str, Any], bool]:
    """Scene, moments, weight, rates and attitudes; and whether there is a single body.

    The rates have a row for each body; one row of the others may serve all.

    Raises
    ------
    ValueError
        If an array is not finite, has the wrong shape, or holds a zero quaternion.
    """
    rates, single_omega = rows("omega", omega, 3)
    quaternions, single_attitude = _attitudes(attitude)
    n = _common_length(rates, quaternions, single_omega, single_attitude)
    table = laid_out(scene, rates, quaternions, n, unit_of(scene))
    _check_time_unit(table)
    return table, single_omega and single_attitude


def _check_time_unit(table: Mapping[str, Any]) -> None:
    """Refuse rates whose squares are lost below the smallest double."""
    swing = np.sqrt(np.abs(table["weight"]).max() / table["moments"].min())
    rates = np.maximum(np.abs(table["omega"]).max(axis=1), swing)
    slow = np.flatnonzero((rates > 0.0) & (rates < SLOWEST))
    if len(slow):
        raise ValueError(
            f"omega[{slow[0]}]: the rates of the body are {rates[slow[0]]:.3g} rad/s at most; they "
            f"must be zero or reach {SLOWEST:g} rad/s: count the time in another unit"
        )


def laid_out(
    scene: Scene,
    rates: NDArray[np.float64],
    quaternions: NDArray[np.float64],
    n: int,
    unit: int = 0,
) -> dict[str, Any]:
    """The columns of ``n`` bodies with these rates and unit quaternions, as they are.

    Moments, weight, torque and damping are counted in ``2**unit``.
    """
    table = {
        "scene": scene.kind,
        "moments": counted("moments", np.array([scene.body.moments]), unit),
        "weight": counted("mgl", scene.weight[np.newaxis], unit),
        "omega": np.ascontiguousarray(np.broadcast_to(rates, (n, 3))),
        "attitude": quaternions,
    }
    outside = outside_of(scene.torque, scene.damping, unit)
    return table if outside is None else {**table, "outside": outside}


def unit_of(scene: Scene) -> int:
    """Exponent of two of the unit in which a scene's moments are counted: the largest is near one.

    So no product with rates leaves the range of doubles, and the unit of moments, torques and
    energies changes no bit of a motion.
    """
    return int(np.frexp(max(scene.body.moments))[1])


@np.errstate(over="ignore")
def counted(name: str, values: NDArray[np.float64], unit: int) -> NDArray[np.float64]:
    """The values in that unit.

    Raises
    ------
    ValueError
        If they are too large for it.
    """
    scaled = np.ldexp(values, -unit)
    if not np.isfinite(scaled).all():
        raise ValueError(
            f"{name} = {np.abs(values).max():g}: must be below 1e308 times the largest moment, "
            f"which is of the order of {math.ldexp(1.0, unit):g}"
        )
    return scaled


def fastest_rates(
    table: Mapping[str, Any], span: tuple[float, float], method: str | None = None
) -> NDArray[np.float64]:
    """Bounds of ``|omega|`` between two times around 0, or the rates that a method's steps follow.

    Without torque and damping they hold for all times, and the two are the same.
    """
    if "outside" in table:
        return _core.fastest_rates(**each_row(table), span=span, method=method)
    return _core.fastest_rates(**each_row(table))


def each_row(table: Mapping[str, Any]) -> dict[str, Any]:
    """The same columns with the moments written out for each body."""
    moments = np.broadcast_to(table["moments"], table["omega"].shape)
    return {**table, "moments": np.ascontiguousarray(moments)}


def _attitudes(attitude: ArrayLike | Rotation | None) -> tuple[NDArray[np.float64], bool]:
    """Unit quaternions, and whether there is only one for all bodies."""
    if attitude is None:
        return np.array([_IDENTITY]), True
    if hasattr(attitude, "as_quat"):
        attitude = attitude.as_quat(scalar_first=True)
    quaternions, single = rows("attitude", attitude, 4)
    squares = np.einsum("ni,ni->n", quaternions, quaternions)
    if not np.all((squares > 1e-200) & (squares < 1e200)):
        largest = np.abs(quaternions).max(axis=1)
        if np.any(largest == 0.0):
            index = int(np.flatnonzero(largest == 0.0)[0])
            raise ValueError(f"attitude[{index}] = {[0.0] * 4}: a zero quaternion is no attitude")
        # Scaled by a power of two, which is exact, so that no square leaves the range of doubles.
        quaternions = np.ldexp(quaternions, -np.frexp(largest)[1][:, None])
        squares = np.einsum("ni,ni->n", quaternions, quaternions)
    return quaternions / np.sqrt(squares)[:, None], single


def _common_length(
    rates: NDArray[np.float64],
    quaternions: NDArray[np.float64],
    single_omega: bool,
    single_attitude: bool,
) -> int:
    if single_attitude:
        return len(rates)
    if single_omega or len(rates) == len(quaternions):
        return len(quaternions)
    raise ValueError(
        f"attitude: expected shape ({len(rates)}, 4) to go with omega {rates.shape}, "
        f"got {quaternions.shape}"
    )
