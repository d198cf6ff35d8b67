"""Running maps for users."""

from __future__ import annotations

import os
import shutil
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._checks.arguments import brief, positive_int, resolve_threads
from .._checks.progress import Interrupted, ProgressOption, checked_progress, interruptible
from .._files import published
from ..maps.dataset import write_zarr_url
from ..maps.refine import refined
from ..maps.sequential import LOOK
from ..maps.spec import MapSpec
from ..model.scene import Scene
from .compare import Verification, verify
from .compare import diff as diff
from .drive import executor_of
from .head import Head, StoreError
from .result import StabilityMap
from .resume import Part, carry_on, pixels_done, result_of
from .running import Folder, Memory
from .status import Status, status_of

MOST_UNITS = 2**22
"""Most units of a map with more samples: their rows take some hundred megabytes."""

ROWS = 2**16
"""Rows that are copied at a time."""


class PoisonedError(RuntimeError):
    """Tasks of some units have failed three times; the rest of the map is stored.

    Attributes
    ----------
    units : list of int
        The units.
    partial : StabilityMap
        The map without them.
    """

    def __init__(self, poison: dict[int, str], partial: StabilityMap) -> None:
        self.units, self.partial = list(poison), partial
        shown = ", ".join(map(str, self.units[:10])) + (", ..." if self.units[10:] else "")
        super().__init__(
            f"{len(poison):,} units were given up, their tasks failed three times: {shown}; "
            f"the last error: {poison[self.units[-1]]}"
        )


class Store:
    """A running map: a folder to which any number of processes add rows.

    Made by ``stability_map(..., store=path)``, opened by :func:`open_store`.

    Attributes
    ----------
    path : Path
        The folder.
    spec : MapSpec
        Everything that the numbers depend on.
    key : str
        BLAKE2b-128 of the specification, hexadecimal.

    Examples
    --------
    >>> import pathlib, tempfile, rigid
    >>> ask = dict(axes={"spin": [1.0, 2.0]}, samples=64, t_end=50.0, stable=rigid.no_flip(), rng=1)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = pathlib.Path(folder, "run.rigid")
    ...     _ = rigid.stability_map(rigid.FreeBody, store=path, **ask)
    ...     store = rigid.open_store(path)
    ...     store.result().share.shape
    (2,)
    """

    def __init__(self, folder: Folder) -> None:
        self._folder = folder

    def __repr__(self) -> str:
        done = int(self._folder.table.known.sum())
        return f"<rigid.Store {os.fspath(self.path)!r}: {done:,} units are stored>"

    @property
    def path(self) -> Path:
        """The folder of the map."""
        return self._folder.path

    @property
    def spec(self) -> MapSpec:
        """The specification: everything that the numbers depend on."""
        return self._folder.head.spec

    @property
    def key(self) -> str:
        """BLAKE2b-128 of the specification, hexadecimal."""
        return self._folder.head.key.hex()

    def status(self) -> Status:
        """The stored and the missing parts of the map, read from the disk now.

        Returns
        -------
        Status
            ``str()`` is a table of the writers and of the missing parts.

        Raises
        ------
        ValueError
            If rows contradict each other.

        Examples
        --------
        >>> import pathlib, tempfile, rigid
        >>> ask = dict(axes={"spin": [1, 2]}, samples=64, t_end=9, stable=rigid.no_flip(), rng=1)
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     path = pathlib.Path(folder, "run.rigid")
        ...     _ = rigid.stability_map(rigid.FreeBody, store=path, part=(1, 2), **ask)
        ...     store = rigid.open_store(path)
        ...     store.status().complete
        False
        """
        self._folder.read()
        return status_of(self._folder)

    def result(self) -> StabilityMap:
        """The map of the rows that are stored now; ``complete`` says whether rows are missing.

        Returns
        -------
        StabilityMap

        Raises
        ------
        ValueError
            If rows contradict each other.

        Examples
        --------
        >>> import pathlib, tempfile, rigid
        >>> ask = dict(axes={"spin": [1, 2]}, samples=64, t_end=9, stable=rigid.no_flip(), rng=1)
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     path = pathlib.Path(folder, "run.rigid")
        ...     _ = rigid.stability_map(rigid.FreeBody, store=path, part=(1, 2), **ask)
        ...     store = rigid.open_store(path)
        ...     store.result().samples.tolist()
        [64, 0]
        """
        self._folder.read()
        return result_of(self._folder, StabilityMap)

    def resume(
        self,
        *,
        executor: Any = None,
        threads: int | None = None,
        threads_per_task: int = 1,
        part: str | tuple[int, int] | None = None,
        progress: ProgressOption = None,
        partial: bool = False,
        allow_mixed: bool = False,
    ) -> StabilityMap:
        """Compute the missing rows, with the options of :func:`stability_map`.

        Parameters
        ----------
        executor, threads, threads_per_task, part, progress, partial
            As for :func:`stability_map`.
        allow_mixed : bool
            Accept workers of another version or commit, whose numbers may differ; :meth:`verify`
            finds those that do.

        Returns
        -------
        StabilityMap

        Raises
        ------
        Interrupted
            After Ctrl-C, unless ``partial`` is set. Finished rows are stored.
        PoisonedError
            If tasks of some units failed three times.
        ValueError
            If this machine or a worker does not compute the numbers that are stored.
        OSError
            If a row cannot be written.

        Examples
        --------
        >>> import pathlib, tempfile, rigid
        >>> ask = dict(axes={"spin": [1, 2]}, samples=64, t_end=9, stable=rigid.no_flip(), rng=1)
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     path = pathlib.Path(folder, "run.rigid")
        ...     _ = rigid.stability_map(rigid.FreeBody, store=path, part=(1, 2), **ask)
        ...     store = rigid.open_store(path)
        ...     store.resume(progress=False).complete
        True
        """
        self._folder.read()
        return run_map(
            self.spec,
            running=self._folder,
            executor=executor,
            threads=threads,
            threads_per_task=threads_per_task,
            part=part,
            progress=progress,
            partial=partial,
            allow_mixed=allow_mixed,
        )

    def extend(self, path: str | os.PathLike[str], *, samples: int) -> Store:
        """A new folder for the same map with more samples, whose first ones are those stored.

        The rows are copied, and :meth:`Store.resume` computes what is missing: the result has the
        bits of a map that was asked for so many samples at once.

        Parameters
        ----------
        path : path-like
            The new folder.
        samples : int
            Samples of a pixel, more than now.

        Returns
        -------
        Store

        Raises
        ------
        ValueError
            If the folder is not new; or if the first bodies would have other results: the map has
            ``half_width``, ``refine``, ``budget`` or a share to ``check``, or its samples are no
            multiple of 64, which are checked together.
        OSError
            If the rows cannot be written.

        Examples
        --------
        >>> import pathlib, tempfile, rigid
        >>> ask = dict(axes={"spin": [1.0, 2.0]}, t_end=50.0, stable=rigid.no_flip(), rng=1)
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     path = pathlib.Path(folder, "run.rigid")
        ...     _ = rigid.stability_map(rigid.FreeBody, store=path, samples=64, **ask)
        ...     more = rigid.open_store(path).extend(pathlib.Path(folder, "more"), samples=256)
        ...     result = more.resume(progress=False)
        >>> result.samples.tolist(), result.computed
        ([256, 256], 384)
        """
        self._folder.read()
        old, spec = self._folder.head, self.spec
        if positive_int("samples", samples) <= spec.samples:
            raise ValueError(f"samples = {samples}: must be above {spec.samples}, which are stored")
        if spec.looks is not None or refined(spec) or 0.0 < (spec.check or 0.0) < 1.0:
            raise ValueError(
                f"samples = {samples}: a map with half_width, refine, budget or a share to check "
                "gives its first bodies other results when there are more; take a new store"
            )
        segment = min(old.segment, spec.samples)
        if segment % LOOK or spec.samples % segment:
            raise ValueError(
                f"samples = {samples}: the {spec.samples} stored samples of a pixel must be a "
                f"multiple of {max(LOOK, segment % LOOK or segment)}, because so many are computed "
                "and checked together"
            )
        more = Head(replace(spec, samples=samples), segment)
        if more.units > MOST_UNITS:
            raise ValueError(
                f"samples = {samples}: makes {more.units} units of {segment} samples, more than "
                f"{MOST_UNITS}; take a new store"
            )
        Folder.require_empty(path)
        target = Folder.at(path, more.spec, segment=segment)

        def moved(units: NDArray[np.int64]) -> NDArray[np.int64]:
            pixels, place = np.divmod(units, old.segments)
            return pixels * more.segments + place

        table = self._folder.table
        known = np.flatnonzero(table.known)
        target.begin(executor="copy")
        for first in range(0, len(known), ROWS):
            block = table.block(known[first : first + ROWS])
            for units in (block.rows["unit"], block.bins[:, 0]):
                units[:] = moved(units)
            target.append(block)
        target.end("copied")
        return Store(target)

    def verify(
        self,
        share: float = 0.01,
        *,
        seed: int = 0,
        threads: int = 1,
        progress: ProgressOption = None,
    ) -> Verification:
        """Compute a random share of the stored units again and compare them bit for bit.

        A share f finds one of n wrong units with the chance 1 - (1 - f)**n. All digests of the logs
        are compared as well.

        Parameters
        ----------
        share : float
            Share of the units, in (0, 1].
        seed : int
            Seed of the choice of the units.
        threads : int
            Number of threads.
        progress : None, bool or callable
            As of :func:`stability_map`, in units of work.

        Returns
        -------
        Verification
            ``ok`` says whether all numbers agree; ``str()`` describes the result.

        Raises
        ------
        ValueError
            If the share is not in (0, 1].

        Examples
        --------
        >>> import pathlib, tempfile, rigid
        >>> ask = dict(axes={"spin": [1, 2]}, samples=64, t_end=9, stable=rigid.no_flip(), rng=1)
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     path = pathlib.Path(folder, "run.rigid")
        ...     _ = rigid.stability_map(rigid.FreeBody, store=path, **ask)
        ...     store = rigid.open_store(path)
        ...     store.verify(share=1.0).ok
        True
        """
        return verify(self._folder, share=share, seed=seed, threads=threads, progress=progress)

    def pack(self, path: str | os.PathLike[str]) -> Path | str:
        """Write the map of the rows that are stored now; the map may be incomplete.

        Parameters
        ----------
        path : path-like
            As of :meth:`StabilityMap.save`; or a URL that zarr knows, such as the URL of a bucket.

        Returns
        -------
        Path or str
            The file, or the URL.

        Raises
        ------
        FileExistsError, OSError
            As for :meth:`StabilityMap.save`.

        Examples
        --------
        >>> import pathlib, tempfile, rigid
        >>> ask = dict(axes={"spin": [1, 2]}, samples=64, t_end=9, stable=rigid.no_flip(), rng=1)
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     path = pathlib.Path(folder, "run.rigid")
        ...     _ = rigid.stability_map(rigid.FreeBody, store=path, **ask)
        ...     store = rigid.open_store(path)
        ...     rigid.load_map(store.pack(path.with_suffix(".npz"))).complete
        True
        """
        return pack(self.result(), path)


def pack(result: StabilityMap, path: str | os.PathLike[str]) -> Path | str:
    """Write a map as a file, as a folder of Zarr, or to a URL; see :meth:`Store.pack`."""
    place = os.fspath(path)
    if "://" not in place:
        return result.save(path)
    write_zarr_url(result, place)
    return place


def open_store(
    path: str | os.PathLike[str],
    *,
    scene: Callable[..., Any] | Scene | None = None,
    stable: Callable[..., Any] | None = None,
) -> Store:
    """Open the folder of a running map.

    Parameters
    ----------
    path : path-like
        The folder that ``stability_map(..., store=path)`` has made, or a copy of it.
    scene, stable : callable, optional
        The function that makes the scenes, and the function of :func:`judged`, to compute what is
        missing: a folder has digests of them alone, of their sources and of what they take from
        outside. Or the scene itself, if its torque is a function: a folder does not have it.

    Returns
    -------
    Store

    Raises
    ------
    ValueError
        If the folder holds no running map, one of another format, or rows that contradict each
        other; or if a function is another one, or takes other values: which. Nothing in the folder
        is executed, and nothing outside is read.

    Examples
    --------
    >>> import pathlib, tempfile, rigid
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = pathlib.Path(folder, "run.rigid")
    ...     result = rigid.stability_map(
    ...         rigid.FreeBody, axes={"spin": [1.0, 2.0]}, samples=10, t_end=50.0,
    ...         stable=rigid.no_flip(), rng=2026, store=path,
    ...     )
    ...     rigid.open_store(path).status().complete
    True
    """
    folder = Folder(path)
    folder.give(scene=scene, stable=stable)
    return Store(folder)


def merge(paths: Sequence[str | os.PathLike[str]], into: str | os.PathLike[str]) -> Store:
    """Merge running maps of one specification into one folder.

    Parameters
    ----------
    paths : sequence of path-like
        Folders of running maps.
    into : path-like
        A new folder, or the folder of a running map of the same specification.

    Returns
    -------
    Store

    Raises
    ------
    ValueError
        If a folder holds another map, with what differs; or if two rows of one unit differ, with
        the unit and the numbers. Then nothing is written.

    Examples
    --------
    >>> import pathlib, tempfile, rigid
    >>> ask = dict(axes={"spin": [1.0, 2.0]}, samples=64, t_end=50.0, stable=rigid.no_flip(), rng=1)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     parts = [pathlib.Path(folder, name) for name in ("one", "two")]
    ...     for k, path in enumerate(parts, 1):
    ...         _ = rigid.stability_map(rigid.FreeBody, store=path, part=(k, 2), **ask)
    ...     rigid.merge(parts, pathlib.Path(folder, "whole")).status().complete
    True
    """
    if isinstance(paths, (str, bytes)):
        raise TypeError(f"paths = {brief(paths)}: must be a sequence of folders")
    folders = [Folder(path) for path in paths]
    if not folders:
        raise ValueError("paths: must name at least one running map")
    first = folders[0]
    if Folder.is_at(into):
        folders.append(Folder(into))
    for folder in folders[1:]:
        folder.head.require_spec(first.head.spec, folder.path)
        if folder.head.segment != first.head.segment:
            raise StoreError(
                f"{folder.path}: its units have {folder.head.segment} samples, the units of "
                f"{first.path} have {first.head.segment}: only one of the two was extended"
            )
        first.table.add(folder.table.block(np.flatnonzero(folder.table.known)), folder.path)
    target = Folder.at(into, first.head.spec, segment=first.head.segment)
    for folder in folders:
        for log in folder.logs:
            source, copy = folder.path / "logs" / log.name, target.path / "logs" / log.name
            if not (copy.exists() and copy.stat().st_size >= source.stat().st_size):
                with source.open("rb") as file, published(copy) as whole:
                    shutil.copyfileobj(file, whole)
    target.read()
    return Store(target)


def run_map(
    spec: MapSpec,
    *,
    store: str | os.PathLike[str] | None = None,
    seeded: bool = True,
    running: Memory | None = None,
    executor: Any = None,
    threads: int | None = None,
    threads_per_task: int = 1,
    part: str | tuple[int, int] | None = None,
    progress: ProgressOption = None,
    partial: bool = False,
    allow_mixed: bool = False,
) -> StabilityMap:
    """The map of a specification, in a folder or in memory; see :func:`rigid.stability_map`.

    A map that is ``running`` goes on.
    """
    # Whatever is refused leaves no new folder.
    workers, each = resolve_threads(threads), positive_int("threads_per_task", threads_per_task)
    share = Part.of(part)
    if executor is not None:
        executor_of(executor)
    checked_progress(progress)
    begun = time.perf_counter()
    if store is not None:
        running = Folder.at(store, spec if seeded else Folder.seeded(spec, store))
    running = running or Memory(spec)
    with interruptible() as stop:
        outcome = None
        try:
            outcome = carry_on(
                running,
                threads=workers,
                stop=stop.is_set,
                executor=executor,
                threads_per_task=each,
                part=share,
                allow_mixed=allow_mixed,
                progress=progress,
            )
        except KeyboardInterrupt:
            if stop.is_set():
                raise  # the second Ctrl-C
        elapsed = time.perf_counter() - begun
        result = result_of(running, StabilityMap, elapsed=elapsed, threads=workers)
    if (outcome is None or stop.is_set()) and not partial:
        if isinstance(running, Folder):
            words = f"{pixels_done(running)}; the same call goes on"
        else:
            done = pixels_done(running, "done")
            words = f"{done}; the attribute 'partial' of this exception is their map"
        raise Interrupted(words, result)
    if outcome is not None and outcome.poison:
        raise PoisonedError(outcome.poison, result)
    return result
