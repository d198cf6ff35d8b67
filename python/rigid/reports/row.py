"""One line of a report, a method with a step; and the Pareto front of lines."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Protocol, TypeVar

__all__ = ["AT_UNCERTAINTY", "FAILED", "REFERENCE", "USELESS", "Row", "pareto"]

REFERENCE = "reference"
AT_UNCERTAINTY = "at reference uncertainty"
USELESS = "error >= 1"
FAILED = "failed"


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """One method with one step. Times are processor times of one body, in ns.

    Attributes
    ----------
    method : str
        Name of the method.
    steps : int
        Steps until ``t_end``; 0 by closed form.
    step, angle : float or None
        Step in units of time, and a bound of the angle turned in it (rad).
    nanoseconds, spread : float; float or None
        Time per unit of time of the motion: median, and distance of the quartiles; None of a
        single timing. In a partial report that may be a call with all that is around it.
    total : float
        Time until ``t_end``.
    error, worst : float
        Error of the state at ``t_end``: the largest component of the error of the rates, relative
        to ``|omega|``, or the angle to the true attitude (rad), whichever is larger. Median of the
        ensemble, and its worst body. Infinite for a body that did not arrive.
    rates_error, attitude_error : float
        Medians of the two.
    energy_drift, momentum_drift : float
        As in :class:`rigid.Run`, worst of the ensemble.
    order : float or None
        Measured order: slope from the row before, if both errors are well above rounding and below
        0.1.
    mark : str
        Empty; ``"reference"``; ``"at reference uncertainty"``: the errors are bounds, equal to the
        uncertainty of the reference; ``"error >= 1"``: the state is unknown, for example in chaos
        after a long time; ``"failed"``.
    """

    method: str
    steps: int
    step: float | None
    angle: float | None
    nanoseconds: float
    spread: float | None
    total: float
    error: float
    worst: float
    rates_error: float
    attitude_error: float
    energy_drift: float
    momentum_drift: float
    order: float | None
    mark: str


class Timed(Protocol):
    """A row with a time."""

    @property
    def nanoseconds(self) -> float:
        """Processor time."""


Line = TypeVar("Line", bound=Timed)


def pareto(rows: Iterable[Line], error: Callable[[Line], float]) -> tuple[Line, ...]:
    """The Pareto front from fast to exact: no other row is both faster and more accurate.

    Rows with an error of 1 or more do not compete.
    """
    best, front = 1.0, []
    for row in sorted(rows, key=lambda row: (row.nanoseconds, error(row))):
        if error(row) < best:
            best = error(row)
            front.append(row)
    return tuple(front)
