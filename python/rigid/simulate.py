"""States of one body or many at wanted times."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core
from ._check import finite_float, one_of, positive_int, resolve_threads, rows, sorted_times
from .methods import method_names
from .scenes import FreeBody, HeavyTop, Scene

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

__all__ = ["Run", "Status", "simulate"]

_IDENTITY = (1.0, 0.0, 0.0, 0.0)
_RECORDS = ("rates", "axis", "attitude")


class Status(IntEnum):
    """How a body ended."""

    FINISHED = 0  #: at the last wanted time
    STOPPED = 1  #: when the question of a map was answered
    STEP_LIMIT = 2  #: not run: it would have needed more than ``max_steps``
    NOT_FINITE = 3  #: a number overflowed or became NaN: the step is too long
    DRIFTED = 4  #: energy, momentum or unit lengths off by more than 0.1: the step is too long


@dataclass(frozen=True, slots=True)
class Run:
    """What :func:`simulate` returns. With a single body the leading axis ``n`` is absent.

    Attributes
    ----------
    t : ndarray, shape (m,)
        Times (s).
    omega : ndarray, shape (n, m, 3)
        Angular velocity in the body (rad/s).
    gamma : ndarray, shape (n, m, 3), or None
        Upward vertical seen from the body, if it was carried.
    attitude : ndarray, shape (n, m, 4), or None
        Quaternion, scalar first, body to space, if it was recorded. Not renormalised.
    energy_drift : ndarray, shape (n,)
        Largest error of the energy at a wanted time, relative to the kinetic energy at the start
        (plus ``mgl`` for a top).
    momentum_drift : ndarray, shape (n,)
        The same of the conserved angular momentum: ``|L|`` of a free body, relative to itself;
        ``L·gamma`` of a top, relative to ``|L| + sqrt(mgl I_max)`` at the start.
    unit_drift : ndarray, shape (n,)
        Largest deviation of ``|gamma|`` and ``|q|`` from one; 0 if neither is carried.
    status : ndarray of uint8, shape (n,)
        A :class:`Status` for each body.
    steps : ndarray of uint64, shape (n,)
        Steps taken.
    spec : dict
        Scene, method, step and record, as plain data.
    """

    t: NDArray[np.float64]
    omega: NDArray[np.float64]
    gamma: NDArray[np.float64] | None
    attitude: NDArray[np.float64] | None
    energy_drift: NDArray[np.float64]
    momentum_drift: NDArray[np.float64]
    unit_drift: NDArray[np.float64]
    status: NDArray[np.uint8]
    steps: NDArray[np.uint64]
    spec: dict[str, Any]

    def rotation(self) -> Rotation:
        """The attitudes as a SciPy ``Rotation`` of shape ``(n, m)`` (active, body to space).

        Raises
        ------
        ValueError
            If the attitude was not recorded.
        """
        if self.attitude is None:
            raise ValueError(
                "record = 'attitude' was not asked for: there is no attitude to return"
            )
        from scipy.spatial.transform import Rotation

        return Rotation.from_quat(self.attitude, scalar_first=True)


def simulate(
    scene: Scene,
    omega: ArrayLike,
    attitude: ArrayLike | Rotation | None = None,
    *,
    t: ArrayLike,
    method: str = "rk4",
    step: float | None = None,
    record: str = "attitude",
    max_steps: int = 10**9,
    threads: int | None = None,
) -> Run:
    """Integrate one body or many and return their states at the wanted times.

    Each body is independent of the others: its numbers are the same bits alone, in any batch, on
    any processor and for any number of threads.

    Parameters
    ----------
    scene : FreeBody or HeavyTop
        The body and what acts on it.
    omega : array_like, shape (3,) or (n, 3)
        Angular velocity at ``t = 0`` in the body (rad/s).
    attitude : array_like, shape (4,) or (n, 4), or scipy Rotation, optional
        Attitude at ``t = 0``: quaternion, scalar first, body to space; normalised here. Default:
        body and space axes coincide.
    t : array_like, shape (m,)
        Wanted times (s), ascending; negative times are reached backward from 0.
    method : str
        One of :func:`rigid.methods`. Steps are equal between wanted times and end exactly on them.
    step : float, optional
        Largest step (s). Default: each body turns by at most 1/16 rad a step, from a bound of its
        rates.
    record : {"attitude", "axis", "rates"}
        What is carried: the attitude; or the vertical seen from the body; or rates only. Asking for
        less is faster and changes no bit of the rates.
    max_steps : int
        A body that would need more is not run and has the status ``STEP_LIMIT``.
    threads : int, optional
        Default: ``RIGID_NUM_THREADS``, else the cores that this process may use.

    Returns
    -------
    Run
        Named arrays; see :class:`Run`.

    Raises
    ------
    ValueError
        Naming the argument, its value and the rule: not finite, wrong shape, zero quaternion,
        unsorted times, unknown method or record, step not positive.

    Examples
    --------
    >>> import numpy as np, rigid
    >>> book = rigid.FreeBody(rigid.Body.box(0.01, 0.08, 0.25, mass=0.3))
    >>> run = rigid.simulate(book, [1e-10, 1.0, 1e-10], t=[0.0, 26.634], step=0.01)
    >>> bool(abs(run.omega[-1, 1]) < 1e-3)  # it has left the middle axis by then
    True
    """
    if not isinstance(scene, (FreeBody, HeavyTop)):
        raise TypeError(f"scene = {scene!r}: must be a rigid.FreeBody or rigid.HeavyTop")
    rates, single_omega = rows("omega", omega, 3)
    quaternions, single_attitude = _attitudes(attitude)
    n = _common_length(rates, quaternions, single_omega, single_attitude)
    times = sorted_times("t", t)
    one_of("method", method, method_names())
    one_of("record", record, _RECORDS)
    if step is not None:
        step = finite_float("step", step, positive=True)
    states = _core.simulate(
        **_columns(scene, rates, quaternions, n),
        method=method,
        record=record,
        step=None if step is None else np.full(n, step),
        max_steps=positive_int("max_steps", max_steps),
        threads=resolve_threads(threads),
        times=times.tolist(),
    )
    spec = {"scene": scene.to_dict(), "method": method, "step": step, "record": record}
    return _to_run(states, times, spec, single=single_omega and single_attitude)


def replay_steps(
    scene: Scene,
    omega: NDArray[np.float64],
    attitude: NDArray[np.float64],
    *,
    method: str,
    step: float,
    strides: Sequence[int],
) -> Run:
    """A body of a map again: its states after these numbers of steps of exactly ``step``."""
    states = _core.simulate(
        **_columns(scene, omega.reshape(1, 3), attitude.reshape(1, 4), 1),
        method=method,
        record="attitude",
        step=np.array([step]),
        max_steps=2**63,
        threads=1,
        strides=list(strides),
    )
    times = np.cumsum(strides) * step
    spec = {"scene": scene.to_dict(), "method": method, "step": step, "record": "attitude"}
    return _to_run(states, times, spec, single=True)


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


def _columns(
    scene: Scene, rates: NDArray[np.float64], quaternions: NDArray[np.float64], n: int
) -> dict[str, Any]:
    """The bodies of a scene as the columns that the core reads; one row may serve all."""
    return {
        "scene": scene.kind,
        "moments": np.array([scene.body.moments]),
        "weight": scene.weight[np.newaxis],
        "omega": np.ascontiguousarray(np.broadcast_to(rates, (n, 3))),
        "attitude": quaternions,
    }


def _to_run(
    states: dict[str, Any], times: NDArray[np.float64], spec: dict[str, Any], *, single: bool
) -> Run:
    def of_body(values: Any) -> Any:
        return values[0] if single and values is not None else values

    return Run(
        t=times,
        omega=of_body(states["omega"]),
        gamma=of_body(states["vertical"]),
        attitude=of_body(states["attitude"]),
        energy_drift=of_body(states["energy_drift"]),
        momentum_drift=of_body(states["momentum_drift"]),
        unit_drift=of_body(states["unit_drift"]),
        status=of_body(states["status"]),
        steps=of_body(states["steps"]),
        spec=spec,
    )
