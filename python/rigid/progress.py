"""Progress of a long run: a bar in a terminal, silence elsewhere, or a callable."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TypeAlias


@dataclass(frozen=True, slots=True, kw_only=True)
class Progress:
    """How far a map is.

    Attributes
    ----------
    done, total : int
        Bodies finished, and all of them.
    elapsed : float
        Seconds since the start.
    rate : float
        Bodies per second so far.
    remaining : float
        Seconds left at this rate; inf before the first body.
    failures : int
        Bodies whose motion could not be computed.
    """

    done: int
    total: int
    elapsed: float
    failures: int

    @property
    def rate(self) -> float:
        return self.done / self.elapsed if self.elapsed > 0.0 else 0.0

    @property
    def remaining(self) -> float:
        if self.done == self.total:
            return 0.0
        return (self.total - self.done) / self.rate if self.done else float("inf")


ProgressOption: TypeAlias = bool | Callable[[Progress], object] | None


@contextmanager
def reporting(option: ProgressOption, total: int) -> Iterator[Callable[[Progress], object]]:
    """What to call with a `Progress` after each chunk.

    Parameters
    ----------
    option : None, bool or callable
        ``None``: a tqdm bar if tqdm is installed and stderr is a terminal. ``True``: a tqdm bar
        anyway. ``False``: silence. A callable is called itself.
    total : int
        Number of bodies.

    Raises
    ------
    ImportError
        For ``True`` without tqdm.
    """
    if callable(option):
        yield option
        return
    if option not in (None, True, False):
        raise TypeError(f"progress must be None, True, False or a callable, got {option!r}")
    if option is False or (option is None and not _bar_wanted()):
        yield lambda progress: None
        return
    try:
        from tqdm import tqdm
    except ImportError:
        raise ImportError("a progress bar needs tqdm: pip install 'rigid[maps]'") from None
    with tqdm(total=total, unit=" bodies", unit_scale=True, file=sys.stderr) as bar:

        def show(progress: Progress) -> None:
            if progress.failures:
                bar.set_postfix(failed=progress.failures, refresh=False)
            bar.update(progress.done - bar.n)

        yield show


def _bar_wanted() -> bool:
    # stderr is None under pythonw and in some services.
    if sys.stderr is None or not sys.stderr.isatty():
        return False
    try:
        import tqdm  # noqa: F401
    except ImportError:
        return False
    return True
