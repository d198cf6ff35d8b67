"""The tangent of a motion: the derivative of rates and attitude by the start and by parameters.

A small deviation vector of a motion is a change of its rates and a rotation vector in the body. It
obeys linear equations, which are integrated with the motion: one lane for each column. The vector
of a parameter begins at zero, and the change of the parameter is a torque in its equations.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._checks.arguments import one_of
from .._checks.arrays import Floats
from ..model.forces import forces_in_words
from .methods import EXACT, TO_ROUNDING, run_methods, tangent_methods
from .request import Request
from .status import Status

ROUNDING = 2.0**-53
"""Tolerance of a tangent for which no method is given."""


def check_tangent(
    method: str | None, *, forces: tuple[str, ...], by_parameters: bool = False
) -> None:
    """Raise ValueError for a method without a tangent; a closed form has an integrated one."""
    if "function" in forces:
        raise ValueError(
            "torque: the derivative of a function is not known, so no deviation vectors are "
            "integrated; take starts that differ by 1e-6 and compare their runs"
        )
    known = tangent_methods(forced=bool(forces) or by_parameters)
    if method in (None, EXACT, *known):
        return
    one_of("method", method, run_methods())
    where = f"under {forces_in_words(forces)}" if forces else "by parameters"
    why = "has no tangent, because its steps are not differentiated"
    if method in tangent_methods():
        why = f"has no tangent {where}"
    raise ValueError(f"method = {method!r}: {why}; {', '.join(map(repr, known))} have one")


def tangent_of(
    request: Request, method: str | None, change: tuple[Floats, NDArray[np.intc]] | None
) -> tuple[Floats, Floats | None, str]:
    """The tangent of the bodies of a request, the derivative by parameters, and a sentence.

    A method that the user has named returns the tangent too, with the steps of the motion or the
    same tolerance. Else it is integrated by ``taylor16``, whose errors are of the size of rounding.
    """
    words = f"tangent by {method} too"
    if method not in tangent_methods():
        request = replace(request, method=TO_ROUNDING, tolerance=ROUNDING, steps=None)
        words = f"tangent by {TO_ROUNDING}, its last terms below {ROUNDING:.1e}"
    sensitivity = None if change is None else _sensitivity(request, *change)
    return tangent_matrices(request), sensitivity, words


def tangent_matrices(request: Request) -> Floats:
    """Derivatives of (rates, rotation vector) by their values at the start, shape (n, m, 6, 6).

    Parameters
    ----------
    request : Request
        The bodies and times, with a method that has a tangent.

    Returns
    -------
    ndarray
        NaN for a body that was not run or whose motion overflows; infinite where the derivative
        leaves the range of doubles.
    """
    starts = np.tile(np.eye(6), (len(request.bodies), 1))
    return _columns(request, "tangent", 6, deviations=starts)


def _sensitivity(request: Request, changes: Floats, exponents: NDArray[np.intc]) -> Floats:
    """Derivatives of (rates, rotation vector) by parameters, shape (n, m, 6, k)."""
    rows = np.ascontiguousarray(changes.reshape(-1, changes.shape[2]))
    found = _columns(request, "sensitivity", changes.shape[1], changes=rows)
    with np.errstate(over="ignore"):
        return np.ldexp(found, exponents[:, np.newaxis, np.newaxis, :])


def _columns(request: Request, record: str, width: int, **causes: Any) -> Floats:
    """Deviation vectors of each body in columns, shape (n, m, 6, width), a lane for each column.

    Their causes are deviation vectors at the start or changes of parameters, (n width, ...).
    """
    count = len(request.bodies)
    columns = replace(request.select(np.repeat(np.arange(count), width)), record=record)
    found = columns.states(**causes)
    matrices = found["tangent"].reshape(count, width, request.times.shape[-1], 6)
    moves = np.isin(found["status"][::width], (Status.OK, Status.DRIFTED))
    known = np.where(moves[:, None, None, None] & ~np.isfinite(matrices), np.inf, matrices)
    return np.ascontiguousarray(known.transpose(0, 2, 3, 1))
