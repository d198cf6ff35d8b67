"""The arrays of a stability map: counts in each pixel, their checks, and shares with intervals.

The core defines the columns: a new output of a map is one row there, and appears here, in saved
files and in datasets with its name, type, unit and meaning.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _core
from .._checks.arguments import brief, first_place, of_known
from ..model.criteria import Regular
from . import sequential
from .measured import Measures
from .refine import Stages, filled, refined, stages
from .spec import MapSpec

STATUS = tuple(_core.moment_status_names())
"""The meaning of each ``status``."""

CLASSES = tuple(_core.class_names())
"""The columns that count the bodies of each class; their sum is all bodies done."""

FAILURES = ("step_limit", "not_finite", "drifted")
"""The columns that count why bodies have failed; their sum is the failed."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Column:
    """An output of a map: one number for each pixel.

    Attributes
    ----------
    name : str
        Name of the column, an attribute of :class:`MapData`.
    dtype : str
        ``"int64"`` or ``"float64"``.
    reduction : {"sum", "max", "min"}
        Operation that merges the values of two parts of the samples.
    unit : str
        Unit of the column, ``"1"`` if it has none.
    words : str
        Meaning of the column in a few words.
    reproducible : bool
        False for a measurement of the machine, which is not saved.
    """

    name: str
    dtype: str
    reduction: str
    unit: str
    words: str
    reproducible: bool

    @property
    def counts(self) -> bool:
        """Whether the numbers of the column count bodies or steps: none is negative."""
        return self.reduction == "sum" and self.unit == "1"


COLUMNS: tuple[Column, ...] = tuple(Column(**row) for row in _core.map_columns())
"""All columns, in the order of saved files."""

STORED: Mapping[str, np.dtype[Any]] = {
    **{column.name: np.dtype(column.dtype) for column in COLUMNS if column.reproducible},
    "status": np.dtype(np.uint8),
}
"""The arrays of a saved map that all others follow from, with their types."""

CONFIDENCE = 0.95
"""Least probability with which the interval of a pixel contains its true share."""


def interval(
    successes: NDArray[np.int64], trials: NDArray[np.int64], confidence: float = CONFIDENCE
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The Clopper-Pearson interval of each share, by default of 95 %; NaN without trials.

    Whatever the true share, its own interval holds it with a chance of 95 % or more. C. J. Clopper
    and E. S. Pearson, *Biometrika* 26 (1934) 404.
    """
    lower, upper = _core.clopper_pearson(successes.ravel(), trials.ravel(), confidence)
    return lower.reshape(successes.shape), upper.reshape(successes.shape)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MapData:
    """The numbers of a stability map; :class:`rigid.StabilityMap` describes each.

    All arrays have grid shape. Each of :data:`COLUMNS` is an attribute by its name.

    Attributes
    ----------
    spec : MapSpec
        Everything the numbers depend on.
    columns : dict of str to ndarray
        The arrays of :data:`COLUMNS` by name.
    status : ndarray of uint8
        Index in :data:`STATUS`; 0 for a possible body.
    samples : ndarray of int64
        Bodies done, the sum of the four classes.
    measures : Measures
        The values of each measure by its name.
    share, lower, upper : ndarray
        Share of stable bodies with its 95 % interval, each pixel's own.
    elapsed : float
        Wall time in s; NaN in a loaded map.
    threads : int
        Threads used; 0 in a loaded map.
    computed : int
        Bodies that the call computed; 0 in a loaded map.
    writers : tuple of dict
        Receipts of the processes that computed a map of a store.
    """

    spec: MapSpec
    columns: Mapping[str, NDArray[Any]]
    status: NDArray[np.uint8]
    samples: NDArray[np.int64]
    measures: Measures
    share: NDArray[np.float64]
    lower: NDArray[np.float64]
    upper: NDArray[np.float64]
    elapsed: float
    threads: int
    computed: int = 0
    writers: tuple[Mapping[str, Any], ...] = ()

    def __getattr__(self, name: str) -> NDArray[Any]:
        if name != "columns" and name in self.columns:
            return self.columns[name]
        raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")

    def __dir__(self) -> list[str]:
        return [*object.__dir__(self), *self.columns]

    @classmethod
    def from_arrays(
        cls,
        spec: MapSpec,
        arrays: Mapping[str, NDArray[Any]],
        bins: Sequence[NDArray[np.int64]] | None = None,
        *,
        elapsed: float = math.nan,
        threads: int = 0,
        computed: int = 0,
        writers: tuple[Mapping[str, Any], ...] = (),
    ) -> Self:
        """The result that follows from the counted arrays, whose names :data:`STORED` lists.

        ``bins`` are the histograms of the measures, (n, 10) each, as the core gives them; by
        default of no values.
        Columns that are not given, as those that are not saved, are NaN.
        """
        unknown = np.full(spec.shape, np.nan)
        columns = {
            column.name: arrays[column.name].reshape(spec.shape)
            if column.name in arrays
            else unknown
            for column in COLUMNS
        }
        stable, unstable, undecided, failed = (columns[name] for name in CLASSES)
        decided = stable + unstable
        share = np.full(spec.shape, np.nan)
        np.divide(stable, decided, out=share, where=decided > 0)
        classified = decided + undecided
        unknown, trials, confidence = undecided, classified, CONFIDENCE
        if spec.looks is not None:
            # A failed body may be either, too: the chance of a stop must not depend on failures.
            unknown, trials = undecided + failed, classified + failed
            confidence = sequential.CONFIDENCE
        return cls(
            spec=spec,
            columns=columns,
            status=arrays["status"].reshape(spec.shape),
            samples=classified + failed,
            measures=Measures(spec.measure, bins, spec.shape),
            share=share,
            lower=interval(stable, trials, confidence)[0],
            upper=interval(stable + unknown, trials, confidence)[1],
            elapsed=elapsed,
            threads=threads,
            computed=computed,
            writers=writers,
        )

    @property
    def chaotic_share(self) -> NDArray[np.float64]:
        """Share of the bodies that miss the criterion, such as the chaotic: ``1 - share``."""
        share: NDArray[np.float64] = 1.0 - self.share
        return share

    @property
    def resolution(self) -> float:
        """The smallest exponent (1/s) that the horizon can show; NaN if no exponent is measured.

        Where the horizon is an axis, the exponent of the longest horizon.
        """
        stable = self.spec.stable
        return stable.resolution(self.spec.t_end) if isinstance(stable, Regular) else math.nan

    @property
    def exponent(self) -> NDArray[np.float64]:
        """Mean exponent (1/s) of the integrated bodies; NaN if no body was integrated.

        The exponent of a body is the logarithm of the growth of its deviation vector over the time
        that it ran.
        """
        return self._mean("growth") / self.spec.horizons

    @property
    def mean_megno(self) -> NDArray[np.float64]:
        """Mean over the integrated bodies of their mean MEGNO at the end of their run."""
        return self._mean("megno")

    def _mean(self, name: str) -> NDArray[np.float64]:
        """The mean over the integrated bodies, from the fixed-point sum in a column."""
        measured = isinstance(self.spec.stable, Regular) * (self.samples - self.failed - self.exact)
        mean = np.full(self.spec.shape, np.nan)
        sums = np.asarray(self.columns[name], dtype=np.float64) / _core.FIXED_POINT
        np.divide(sums, measured, out=mean, where=measured > 0)
        return mean

    @property
    def complete(self) -> bool:
        """Whether all requested bodies are computed, and no budget omitted pixels."""
        return self.ended and not self.cut

    @property
    def ended(self) -> bool:
        """Whether the computation is over: the map is complete, or its budget is spent."""
        if refined(self.spec):
            return not len(self._stages.wanted)
        return bool(self.finished[self.status == 0].all())

    @property
    def cut(self) -> int:
        """Number of pixels that the budget omitted; with ``refine`` in its last stage.

        A pixel is omitted if the most bodies that it may need do not fit.
        """
        return 0 if self.spec.budget is None else self._stages.cut

    @property
    def finished(self) -> NDArray[np.bool_]:
        """Pixels whose bodies are all computed; with ``half_width`` pixels with enough bodies."""
        looks = self.spec.looks
        if looks is None:
            finished: NDArray[np.bool_] = self.samples == self.spec.samples
            return finished
        return looks.stops(self.stable, self.undecided + self.failed, self.samples)

    @property
    def _stages(self) -> Stages:
        ends = [self.lower, self.upper]
        return stages(self.spec, self.status, self.finished, self.samples, ends)

    @property
    def stage(self) -> NDArray[np.uint8]:
        """The stage of refinement that computes each pixel; 0 without it, 255 if omitted."""
        if not refined(self.spec):
            return np.zeros(self.spec.shape, dtype=np.uint8)
        return self._stages.stage

    @property
    def cells(self) -> NDArray[np.int64]:
        """First and last row, first and last column of the cells that refinement did not split."""
        if not refined(self.spec):
            return np.zeros((0, 4), dtype=np.int64)
        return self._stages.cells

    @property
    def filled(self) -> NDArray[np.float64]:
        """The share; between the computed pixels of a refined map the bilinear interpolation.

        Interpolated shares are for pictures. They are never counted.
        """
        if not refined(self.spec):
            return self.share
        return filled(self.share, self.status, self.finished, self.cells)

    @property
    def narrow(self) -> NDArray[np.bool_]:
        """Pixels whose interval is no wider than twice ``half_width``; none without one."""
        half_width = self.spec.half_width
        if half_width is None:
            return np.zeros(self.spec.shape, dtype=np.bool_)
        narrow: NDArray[np.bool_] = self.upper - self.lower <= 2.0 * half_width
        return narrow


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
