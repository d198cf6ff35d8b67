"""The tangent of a motion: the derivative of rates and attitude by those at the start.

A small displacement of a motion is a change of its rates and a rotation vector in the body. It
obeys linear equations, which are integrated with the motion: one lane for each column.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from .methods import EXACT, SECOND, tangent_methods
from .request import Request
from .status import Status

if TYPE_CHECKING:
    from .batch import Batch

__all__ = ["ROUNDING", "check_tangent", "rate_scale", "tangent_matrices", "tangent_of"]

Floats = NDArray[np.float64]

ROUNDING = 2.0**-53
"""Tolerance of a tangent whose scheme is not given."""


def check_tangent(method: str | None) -> None:
    """Raise ValueError for a scheme without a tangent; a closed form has an integrated one."""
    if method not in (None, EXACT, *tangent_methods()):
        raise ValueError(
            f"method = {method!r}: has no tangent, because its steps are not differentiated; "
            f"{', '.join(map(repr, tangent_methods()))} have one"
        )


@np.errstate(over="ignore")
def rate_scale(batch: Batch) -> Floats:
    """Unit of the rates, ``sqrt(|omega|² + mgl / I_min)`` at the start; 1 if that is zero."""
    weight = np.linalg.norm(batch.weight, axis=1) / batch.moments.min(axis=1)
    scale: Floats = np.sqrt(np.sum(batch.omega**2, axis=1) + weight)
    return np.where(scale > 0.0, scale, 1.0)


def tangent_of(request: Request, steps: Floats | None, method: str | None) -> tuple[Floats, str]:
    """The tangent of the bodies of a request, and a sentence about it for the plan.

    A scheme that the user has named returns the tangent too, with the steps of the motion or the
    same tolerance. Else it is integrated by ``taylor16``, whose errors are those of rounding.
    """
    if method in tangent_methods():
        return tangent_matrices(request, steps), f"tangent by {method} too"
    own = replace(request, method=SECOND, tolerance=ROUNDING)
    return tangent_matrices(own, None), f"tangent by {SECOND}, its last terms below {ROUNDING:.1e}"


def tangent_matrices(request: Request, steps: Floats | None) -> Floats:
    """Derivatives of (rates, rotation vector) by those at the start, shape (n, m, 6, 6).

    Parameters
    ----------
    request : Request
        The bodies and times, with a method that has a tangent.
    steps : ndarray, shape (n,), or None
        The longest step of each body (s); None leaves them to the core.

    Returns
    -------
    ndarray
        NaN for a body that was not run or whose motion overflows; infinite where the derivative
        leaves the range of doubles.
    """
    count = len(request.batch)
    columns = replace(request.select(np.repeat(np.arange(count), 6)), record="tangent")
    found = columns.states(
        None if steps is None else np.repeat(steps, 6),
        displacements=np.tile(np.eye(6), (count, 1)),
    )
    matrices = found["tangent"].reshape(count, 6, request.times.shape[-1], 6).transpose(0, 2, 3, 1)
    moves = np.isin(found["status"][::6], (Status.OK, Status.DRIFTED))
    known = np.where(moves[:, None, None, None] & ~np.isfinite(matrices), np.inf, matrices)
    return np.ascontiguousarray(known)
