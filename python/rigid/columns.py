"""The bodies of a request as the columns that the core reads."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core
from ._check import rows
from .scenes import FreeBody, HeavyTop, Scene

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

__all__ = ["check_scene", "columns", "each_row", "fastest_rates", "laid_out"]

_IDENTITY = (1.0, 0.0, 0.0, 0.0)


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
    return laid_out(scene, rates, quaternions, n), single_omega and single_attitude


def laid_out(
    scene: Scene, rates: NDArray[np.float64], quaternions: NDArray[np.float64], n: int
) -> dict[str, Any]:
    """The columns of ``n`` bodies with these rates and unit quaternions, as they are."""
    table = {
        "scene": scene.kind,
        "moments": np.array([scene.body.moments]),
        "weight": scene.weight[np.newaxis],
        "omega": np.ascontiguousarray(np.broadcast_to(rates, (n, 3))),
        "attitude": quaternions,
    }
    outside = scene.outside
    return table if outside is None else {**table, "outside": outside}


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
