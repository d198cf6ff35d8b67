"""The status of a body: how its computation ended, and whether its error is small."""

from __future__ import annotations

from collections.abc import Callable
from enum import IntEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray

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


def sentences(words: Callable[..., str], *columns: NDArray[Any]) -> tuple[Any, ...]:
    """The sentence that ``words`` gives for each body from its values in the columns.

    With several leading axes the sentences are tuples of tuples; one body has one sentence.
    """
    columns = tuple(np.atleast_1d(column) for column in columns)
    if columns[0].ndim > 1:
        return tuple(sentences(words, *parts) for parts in zip(*columns, strict=True))
    return tuple(words(*values) for values in zip(*columns, strict=True))
