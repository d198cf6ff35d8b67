"""The status of a body: how its computation ended, whether its error is small, and the remedy."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from enum import IntEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _core
from .methods import EXACT

COARSE_ERROR = 1e-3
"""Largest error of a body with status ``OK`` if no accuracy is requested."""


class Status(IntEnum):
    """How a body ended."""

    OK = 0  #: at the last requested time
    FINISHED = 0  #: another name of OK
    STOPPED = 1  #: with an event of ``until``, or when a map had classified the body
    STEP_LIMIT = 2  #: it would have needed more than ``max_steps``: not run, or stopped there
    NOT_FINITE = 3  #: overflow or NaN: too long a step, or a phase beyond 2**50 turns
    DRIFTED = 4  #: energy, momentum or unit lengths off by more than 0.1: the step is too long
    FLAGGED = 5  #: error above the requested accuracy, or 1 or more: see ``lost_from``
    UNCHECKED = 6  #: at the last requested time; its error was not estimated
    COARSE = 7  #: no accuracy was requested, and the error is above 1e-3


ARRIVED = (Status.OK, Status.FLAGGED, Status.UNCHECKED, Status.COARSE)
"""The statuses of bodies that reached the last requested time, whatever their errors."""


def error_limit(accuracy: float | None) -> float:
    """The error from which on a body is flagged."""
    return 1.0 if accuracy is None else float(accuracy)


def is_accurate(error: Any, accuracy: float | None) -> Any:
    """Whether the error, or each of an array, leaves a body ``OK``."""
    return error < (COARSE_ERROR if accuracy is None else accuracy)


def status_by_error(
    status: NDArray[np.uint8], error: NDArray[np.float64], accuracy: float | None
) -> NDArray[np.uint8]:
    """The status of bodies whose error is known: only a small error leaves them ``OK``."""
    arrived = not np.count_nonzero(status)
    if arrived and np.count_nonzero(is_accurate(error, accuracy)) == len(error):
        return status
    found = np.isnan(error) * np.uint8(Status.UNCHECKED)
    if not found.all():
        if accuracy is None:
            found[error > COARSE_ERROR] = Status.COARSE
        found[error >= error_limit(accuracy)] = Status.FLAGGED
    return found if arrived else np.where(status == Status.OK, found, status)


_STATUS_WORDS: Mapping[Status, str] = {
    Status.OK: "ok",
    Status.STOPPED: "stopped with its last event",
    Status.STEP_LIMIT: (
        "step limit: it needs more than max_steps steps; raise max_steps, take longer steps or a "
        "method of higher order"
    ),
    Status.NOT_FINITE: "not finite: a number overflowed; take shorter steps or other units",
    Status.DRIFTED: (
        f"drifted: energy, momentum or a length is off by more than {_core.DRIFT_LIMIT:g}; take "
        "shorter steps or a method of higher order"
    ),
    Status.UNCHECKED: ("unchecked: its error was not estimated; leave out check=False"),
}


_DEAD_ZONE = (
    "; a torque that jumps where a rate changes its sign, such as -sign(omega), needs a dead zone: "
    "a range of rates in which it rises evenly"
)


def ending(
    spec: Mapping[str, Any], forces: Collection[str], code: int, error: float, since: float
) -> str:
    """How a body of a run of this request ended, and the remedy, as a sentence."""
    status = Status(code)
    if status == Status.STEP_LIMIT and "function" in forces:
        return _STATUS_WORDS[status] + _DEAD_ZONE
    if status == Status.NOT_FINITE and spec["method"] == EXACT:
        return (
            "not finite: a number overflowed, or the phase passed 2**50; end the run earlier or "
            "take other units"
        )
    if status not in (Status.FLAGGED, Status.COARSE):
        return _STATUS_WORDS[status]
    cure = _cure(spec)
    if status == Status.COARSE:
        return f"coarse: the estimated error is {error:.1e}; {cure}"
    if np.isfinite(since):
        return f"flagged: the estimated error is 1 or more from t = {since:.4g} on; {cure}"
    limit = error_limit(spec["accuracy"])
    words = f"flagged: the estimated error is {error:.1e}, above the {limit:g} asked for"
    return f"{words}; {cure} or ask for a larger error"


def _cure(spec: Mapping[str, Any]) -> str:
    """The remedy against an error."""
    asked = spec.get("asked")
    if spec["method"] == EXACT:
        return "rounding makes it, so shorter steps do not help: end the run earlier"
    if spec["tolerance"] is not None and asked is None:
        return "chaos or rounding makes it, a smaller tolerance does not help: end the run earlier"
    if spec["tolerance"] is not None and spec["accuracy"] is None:
        return "end the run earlier or lower the tolerance"
    if spec["accuracy"] is None:
        return "end the run earlier or ask for an accuracy"
    if asked:
        return f"shorter steps of {spec['method']} do not help: leave out the method"
    return "shorter steps do not help: end the run earlier"


def sentences(words: Callable[..., str], *columns: NDArray[Any]) -> tuple[Any, ...]:
    """The sentence that ``words`` gives for each body from its values in the columns.

    With several leading axes the sentences are tuples of tuples; one body has one sentence.
    """
    columns = tuple(np.atleast_1d(column) for column in columns)
    if columns[0].ndim > 1:
        return tuple(sentences(words, *parts) for parts in zip(*columns, strict=True))
    return tuple(words(*values) for values in zip(*columns, strict=True))
