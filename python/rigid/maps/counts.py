"""The arrays of a map from its counts, and a check that a computation can give these counts."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._checks.arguments import brief, first_place, of_known
from .data import CLASSES, COLUMNS, FAILURES, STATUS, STORED
from .spec import MapSpec

GROWTH = frozenset({"growth", "megno", "largest_exponent"})
"""Columns of the deviation vectors; they may be negative."""


def counted(spec: MapSpec, given: Mapping[str, ArrayLike]) -> dict[str, NDArray[Any]]:
    """All stored arrays of a map from some of its columns.

    Raises
    ------
    TypeError, ValueError
        See :meth:`rigid.StabilityMap.from_counts`.
    """
    if not isinstance(spec, MapSpec):
        raise TypeError(f"spec = {brief(spec)}: must be a rigid.MapSpec")
    known = [name for name in STORED if name not in ("failed", "status")]
    arrays: dict[str, NDArray[Any]] = {"status": spec.grid.status.reshape(spec.shape)}
    for name, values in given.items():
        if name == "failed":
            raise TypeError(f"failed: give its reasons {', '.join(FAILURES)}; their sum is failed")
        if name not in known:
            raise TypeError(f"{name}: is no column of a map{of_known(name, known)}")
        arrays[name] = _column(name, values, spec.shape)
    for column in COLUMNS:
        if column.reproducible and column.name not in arrays:
            nothing = 0 if STORED[column.name] == np.int64 else np.nan
            arrays[column.name] = np.full(spec.shape, nothing, dtype=STORED[column.name])
    failed = np.sum([arrays[name] for name in FAILURES], axis=0, dtype=np.int64)
    arrays["failed"] = np.asarray(failed)

    def refuse(message: str) -> None:
        raise ValueError(message)

    check_counts(spec, arrays, refuse)
    return arrays


def _column(name: str, values: ArrayLike, shape: tuple[int, ...]) -> NDArray[Any]:
    array, dtype = np.asarray(values), STORED[name]
    if array.dtype.kind not in ("iu" if dtype == np.int64 else "iuf"):
        kind = "whole" if dtype == np.int64 else "real"
        raise TypeError(f"{name} = {brief(values)}: must be {kind} numbers")
    if array.ndim and array.shape != shape:
        raise ValueError(f"{name}: expected shape {shape}, got {array.shape}")
    return np.broadcast_to(array, shape).astype(dtype)


def check_counts(
    spec: MapSpec, arrays: Mapping[str, NDArray[Any]], refuse: Callable[[str], None]
) -> None:
    """Call ``refuse(message)``, which raises, for numbers that no computation can give."""

    def refuse_where(bad: NDArray[np.bool_], name: str, rule: str) -> None:
        if bad.any():
            index, place = first_place(bad)
            refuse(f"{name}{place} = {arrays[name][index]}: {rule}")

    refuse_where(arrays["status"] >= len(STATUS), "status", "is no known code")
    most = np.where(arrays["status"] == 0, spec.samples, 0)
    for name, array in arrays.items():
        if name not in GROWTH:
            refuse_where(array < 0, name, "must not be negative")
        if name in CLASSES:
            refuse_where(array > most, name, f"more bodies than samples, {spec.samples}")
    done = np.sum([arrays[name] for name in CLASSES], axis=0)
    refuse_where(done > most, CLASSES[0], f"the classes have more bodies than {spec.samples}")
    for name in (*FAILURES, "checked", "exact"):
        refuse_where(arrays[name] > done, name, "more bodies than the classes")
    for name, whole in (("audited", "checked"), ("audited_undecided", "undecided")):
        refuse_where(arrays[name] > arrays[whole], name, f"more bodies than {whole}")
    failures = np.sum([arrays[name] for name in FAILURES], axis=0)
    refuse_where(failures != arrays["failed"], "failed", "must be the sum of its reasons")
