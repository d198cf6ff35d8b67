"""Progress of a long run: the share that is done, the size of the next chunk, and interruption."""

from __future__ import annotations

import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from types import FrameType
from typing import TypeAlias

__all__ = [
    "Pace",
    "Progress",
    "ProgressOption",
    "heeding_interrupts",
    "interruptible",
    "reporting",
]

CHUNK_SECONDS = 0.3
LONGEST_SECONDS = 1.0


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


ProgressOption: TypeAlias = bool | Callable[[Progress], object] | None


@contextmanager
def reporting(
    option: ProgressOption, total: int, *, unit: str = " bodies"
) -> Iterator[Callable[[Progress], object]]:
    """The function to call with a :class:`Progress` after each chunk.

    Parameters
    ----------
    option : None, bool or callable
        ``None``: a tqdm bar if tqdm is installed and stderr is a terminal. ``True``: a tqdm bar
        anyway. ``False``: silence. A callable gets each progress.
    total : int
        Number of bodies, or of other units of work.
    unit : str
        Name of the counted unit.

    Raises
    ------
    ImportError
        For ``True`` without tqdm.
    TypeError
        For any other option.
    """
    if callable(option):
        yield option
        return
    if option is not None and not isinstance(option, bool):
        raise TypeError(f"progress = {option!r}: must be None, True, False or a callable")
    # There is no stderr under pythonw and in some services.
    in_terminal = sys.stderr is not None and sys.stderr.isatty()
    if option or (option is None and in_terminal):
        try:
            from tqdm import tqdm
        except ImportError:
            if option:
                raise ImportError("a progress bar needs tqdm: pip install 'rigid[maps]'") from None
        else:
            with tqdm(total=total, unit=unit, unit_scale=True, file=sys.stderr) as bar:

                def show(progress: Progress) -> None:
                    if progress.failures:
                        bar.set_postfix(failed=progress.failures, refresh=False)
                    bar.update(progress.done - bar.n)

                yield show
                return
    yield lambda _: None


class Pace:
    """Chunk sizes from the cost of the bodies seen so far.

    Costs differ between pixels by orders of magnitude, because a flip ends a body early. So a chunk
    is also kept below a second in case it consists of the costliest bodies only.
    """

    __slots__ = ("_costliest", "_threads", "size")

    def __init__(self, threads: int) -> None:
        self._threads = threads
        self._costliest = 0.0
        self.size = 16 * threads

    def note(self, bodies: int, seconds: float, costliest: float) -> None:
        """Fit the next size to a chunk that took ``seconds``; ``costliest`` is one body's cost."""
        self._costliest = max(self._costliest, costliest / self._threads)
        fitting = CHUNK_SECONDS * bodies / max(seconds, 1e-6)
        bounded = LONGEST_SECONDS / max(self._costliest, 1e-12)
        self.size = max(self._threads, int(min(fitting, bounded, 8.0 * self.size)))


@contextmanager
def interruptible() -> Iterator[threading.Event]:
    """Turn Ctrl-C into an event, so that a chunk is counted completely or omitted.

    Only where Python's own handler is at work: other handlers, and other threads, keep theirs.
    """
    stop = threading.Event()
    ours = (
        threading.current_thread() is threading.main_thread()
        and signal.getsignal(signal.SIGINT) is signal.default_int_handler
    )

    def note(_number: int, _frame: FrameType | None) -> None:
        stop.set()

    if ours:
        signal.signal(signal.SIGINT, note)
    try:
        yield stop
    finally:
        if ours:
            signal.signal(signal.SIGINT, signal.default_int_handler)


@contextmanager
def heeding_interrupts() -> Iterator[None]:
    """Handle SIGINT (Ctrl-C) even if the process was started with SIGINT ignored.

    A shell without job control starts background commands with SIGINT ignored, and Python then
    raises no `KeyboardInterrupt`. A command that runs for minutes must still be stoppable by
    SIGINT. Another handler stays installed, and threads other than the main one change nothing.
    """
    ignored = (
        threading.current_thread() is threading.main_thread()
        and signal.getsignal(signal.SIGINT) is signal.SIG_IGN
    )
    if ignored:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        yield
    finally:
        if ignored:
            signal.signal(signal.SIGINT, signal.SIG_IGN)
