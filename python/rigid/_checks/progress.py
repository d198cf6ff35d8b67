"""Progress of a long run: the share that is done, and interruption."""

from __future__ import annotations

import os
import signal
import sys
import threading
import time
import warnings
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from types import FrameType
from typing import Any, TypeAlias

from .. import _core
from .arguments import brief
from .extras import install_extra
from .notebook import in_notebook
from .overflow import numbers_of_user

NARROW = 80
"""Columns of a terminal below which a bar has neither numbers of bodies nor a rate."""

MANY = 1000
"""Units that a bar counts one by one; of more it shows three digits."""

SHOWN_AFTER = 2.0
"""Seconds after which a call of the core shows its progress by itself."""

SECONDS_BETWEEN_LINES = 10.0
"""Time between two lines of progress where no bar is shown."""

NARROW_BAR = "{percentage:3.0f}%|{bar}| {remaining} left{postfix}"

PERCENT = "%"
"""The unit of a total of 100, whose bar has neither a number of units nor a rate."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Progress:
    """Progress of a map.

    Attributes
    ----------
    done, total : int
        Bodies finished, and all of them.
    elapsed : float
        Seconds since the start.
    failures : int
        Bodies whose motion could not be computed.
    rate : float
        Bodies per second so far.
    remaining : float
        Seconds left at this rate; inf before the first body.
    """

    done: int
    total: int
    elapsed: float
    failures: int

    @property
    def rate(self) -> float:
        """Bodies per second so far."""
        return self.done / self.elapsed if self.elapsed > 0.0 else 0.0

    @property
    def remaining(self) -> float:
        """Seconds left at this rate; inf before the first body."""
        if self.done == self.total:
            return 0.0
        return (self.total - self.done) / self.rate if self.rate > 0.0 else float("inf")


def terminal_columns() -> int:
    """Columns of the terminal of standard error, 80 if it does not tell."""
    try:
        return os.get_terminal_size(sys.stderr.fileno()).columns or 80
    except (AttributeError, OSError, ValueError):
        return 80


ProgressOption: TypeAlias = bool | Callable[[Progress], object] | None


def checked_progress(option: object) -> None:
    """Raise TypeError for what is no :data:`ProgressOption`."""
    if option is not None and not isinstance(option, bool) and not callable(option):
        raise TypeError(f"progress = {brief(option)}: must be None, True, False or a callable")


@contextmanager
def reporting(
    option: ProgressOption,
    total: int,
    *,
    unit: str = " bodies",
    who: str = "",
    begun: float | None = None,
    failed: Callable[[int], str] = "{:,} failed".format,
) -> Iterator[Callable[..., None]]:
    """The function to call with the number that is done, and of failures, after each part.

    Parameters
    ----------
    option : None, bool or callable
        ``None``: a tqdm bar in a terminal or a notebook, if tqdm is installed; else a line on
        standard error every 10 s. ``True``: a tqdm bar anyway. ``False``: silence. A callable gets
        each progress.
    total : int
        Number of bodies, or of other units of work.
    unit : str
        Name of the counted unit.
    who : str
        How a line begins.
    begun : float, optional
        When the work began, by ``time.perf_counter``; by default now.
    failed : callable
        What a bar says of so many failures.

    Raises
    ------
    ImportError
        For ``True`` without tqdm.
    TypeError
        For any other option.
    """
    checked_progress(option)
    begun = time.perf_counter() if begun is None else begun
    _showing.depth = _depth() + 1

    def tell(done: int, failures: int = 0) -> None:
        elapsed = time.perf_counter() - begun
        show(Progress(done=done, total=max(total, done), elapsed=elapsed, failures=failures))

    try:
        with _shown(option, total, unit, who, failed) as show:
            yield tell
    finally:
        _showing.depth -= 1


_showing = threading.local()


def _depth() -> int:
    """How many progresses this thread shows; a call within another shows nothing by default."""
    return getattr(_showing, "depth", 0)


@contextmanager
def _shown(
    option: ProgressOption, total: int, unit: str, who: str, failed: Callable[[int], str]
) -> Iterator[Callable[[Progress], object]]:
    if callable(option):
        yield numbers_of_user()(option)
        return
    # There is no stderr under pythonw and in some services.
    in_terminal = sys.stderr is not None and sys.stderr.isatty()
    if option or (option is None and (in_terminal or in_notebook())):
        try:
            with warnings.catch_warnings():  # tqdm warns where a notebook has no widgets
                warnings.simplefilter("ignore")
                from tqdm.auto import tqdm
        except ImportError:
            if option:
                raise ImportError(install_extra("a progress bar needs tqdm", "maps")) from None
        else:
            # The bar keeps at least 10 cells in a narrow terminal, which the numbers would take.
            narrow = in_terminal and terminal_columns() < NARROW
            shape = NARROW_BAR if narrow or unit == PERCENT else None
            with tqdm(
                total=total, unit=unit, unit_scale=total > MANY, file=sys.stderr, bar_format=shape
            ) as bar:

                def show(progress: Progress) -> None:
                    if progress.failures:
                        bar.set_postfix_str(failed(progress.failures), refresh=False)
                    bar.update(progress.done - bar.n)

                yield show
                return
    yield _lines(who) if option is None and sys.stderr is not None else lambda _: None


def _lines(who: str) -> Callable[[Progress], None]:
    shown = 0.0

    def show(progress: Progress) -> None:
        nonlocal shown
        if progress.elapsed < shown + SECONDS_BETWEEN_LINES or progress.done == progress.total:
            return
        shown = progress.elapsed
        print(
            f"rigid: {who}{progress.done / progress.total:.0%} done after "
            f"{progress.elapsed:.0f} s, about {progress.remaining:.0f} s to go",
            file=sys.stderr,
            flush=True,
        )

    return show


class Listening:
    """While it is entered, progress of the calls of the core in this thread, in hundredths.

    Nothing is shown within another progress, and by default nothing in the first seconds.

    Parameters
    ----------
    option : None, bool or callable
        As of :func:`reporting`.
    runs : int
        About how many calls of equal length follow each other.
    """

    _report: Callable[..., None]

    def __init__(self, option: ProgressOption, runs: int = 1) -> None:
        if option is not None:
            checked_progress(option)
        self._option, self._runs = option, runs

    def __enter__(self) -> None:
        # A call may take some microseconds: what is shown later is made later.
        if self._option is None and _depth():
            self._option = False
        if self._option is False:
            return
        self._before = _core.listen(self._hear)
        if self._before is not None and self._option is None:
            _core.listen(self._before)
            self._option = False
        self._stack: ExitStack | None = None
        self._begun = time.perf_counter()

    def __exit__(self, kind: object, *_: object) -> None:
        if self._option is False:
            return
        _core.listen(self._before)
        if self._stack is not None:
            with self._stack:
                if kind is None:
                    self._tell(100)

    def _hear(self, share: float) -> None:
        """A call of the core has done this share of its work."""
        if self._stack is None:
            if self._option is None and time.perf_counter() - self._begun < SHOWN_AFTER:
                return
            self._stack = ExitStack()
            shown = reporting(self._option, 100, unit=PERCENT, begun=self._begun)
            self._report = self._stack.enter_context(shown)
            self._last, self._number, self._done = 0.0, 0, 0
        self._number += share < self._last
        self._last = share
        self._tell(min(int(100.0 * (self._number + share) / self._runs), 99))

    def _tell(self, done: int) -> None:
        self._done = max(done, self._done)
        self._report(self._done)


class Interrupted(KeyboardInterrupt):
    """Ctrl-C ended a map or a report: a ``KeyboardInterrupt`` that holds what is finished.

    Attributes
    ----------
    partial : StabilityMap or Report
        The result of the finished part. It is complete if Ctrl-C came with the last body.

    Examples
    --------
    >>> import rigid
    >>> def press_ctrl_c(progress):
    ...     raise KeyboardInterrupt
    >>> try:
    ...     rigid.stability_map(
    ...         rigid.FreeBody, axes={"spin": [1.0, 2.0]}, samples=10, t_end=50.0,
    ...         stable=rigid.no_flip(), progress=press_ctrl_c, threads=1,
    ...     )
    ... except rigid.Interrupted as interrupted:
    ...     print(interrupted)
    ...     interrupted.partial.samples.tolist()
    1 of 2 pixels are done; the attribute 'partial' of this exception is their map
    [10, 0]
    """

    def __init__(self, message: str, partial: Any) -> None:
        super().__init__(message, partial)
        self.partial = partial

    def __str__(self) -> str:
        return str(self.args[0])


@contextmanager
def interruptible() -> Iterator[threading.Event]:
    """Turn Ctrl-C into an event, so that a part is counted completely or omitted.

    A second Ctrl-C raises ``KeyboardInterrupt`` at once. Only where Python's own handler is at
    work: other handlers, and other threads, keep theirs.
    """
    stop = threading.Event()
    ours = (
        threading.current_thread() is threading.main_thread()
        and signal.getsignal(signal.SIGINT) is signal.default_int_handler
    )

    def note(number: int, frame: FrameType | None) -> None:
        if stop.is_set():
            signal.default_int_handler(number, frame)
        stop.set()

    if ours:
        signal.signal(signal.SIGINT, note)
    try:
        yield stop
    finally:
        if ours:
            signal.signal(signal.SIGINT, signal.default_int_handler)


_terminated = threading.Event()
"""Set by SIGTERM, in :func:`heeding_signals`."""


def terminated() -> bool:
    """Whether SIGTERM, and not Ctrl-C, ends the command."""
    return _terminated.is_set()


@contextmanager
def heeding_signals() -> Iterator[Callable[[], int]]:
    """Handle SIGTERM as SIGINT (Ctrl-C), and SIGINT even if the process started with it ignored.

    Batch systems end a job with SIGTERM; what is finished must be saved then, too. Further SIGTERM
    change nothing. A shell without job control starts background commands with SIGINT ignored, and
    Python then raises no `KeyboardInterrupt`. A command that runs for minutes must still be
    stoppable by SIGINT. Other handlers stay installed, and threads other than the main one change
    nothing.

    Yields
    ------
    callable
        Exit code of a command that was interrupted: 128 and the number of the signal.
    """

    def terminate(_number: int, _frame: FrameType | None) -> None:
        if not _terminated.is_set():
            _terminated.set()
            signal.raise_signal(signal.SIGINT)

    before: dict[signal.Signals, Any] = {}
    if threading.current_thread() is threading.main_thread():
        if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
            before[signal.SIGINT] = signal.signal(signal.SIGINT, signal.default_int_handler)
        if signal.getsignal(signal.SIGTERM) is signal.SIG_DFL:
            before[signal.SIGTERM] = signal.signal(signal.SIGTERM, terminate)
    try:
        yield lambda: 128 + (signal.SIGTERM if _terminated.is_set() else signal.SIGINT)
    finally:
        _terminated.clear()
        for number, handler in before.items():
            signal.signal(number, handler)
