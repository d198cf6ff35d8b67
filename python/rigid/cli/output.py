"""What a command prints, writes and returns: the data first, then words, then the picture."""

from __future__ import annotations

import json
import math
import os
import sys
import tempfile
from collections.abc import Callable, Mapping
from io import BytesIO
from pathlib import Path
from textwrap import fill
from typing import Any, NamedTuple

import numpy as np

from .._checks.progress import interruptible, terminal_columns
from .._checks.shown import labelled, wrapped
from .._files import published, require_replaceable

DONE, SAYS_NO, REFUSED, WRITE_ERROR, UNFINISHED = 0, 1, 2, 74, 75

EXIT_CODES: Mapping[str, str] = {
    f"{DONE}": "done; also a map whose budget is spent",
    f"{SAYS_NO}": (
        "done, and the result says no: extremes found an undetected error, validation an "
        "unexplained difference, diff a difference, verify other numbers or damage, status "
        "damage; or units of a stored map were given up"
    ),
    f"{REFUSED}": "refused before any work: the call or its input is wrong, or a file is missing",
    f"{WRITE_ERROR}": "a file or the output could not be written: the disk is full, for example",
    f"{UNFINISHED}": (
        "not finished: other parts of a stored map are missing, or pack wrote nothing because "
        "pixels are missing (--partial writes them)"
    ),
    "130, 143": "ended by Ctrl-C or SIGTERM; what was done is written",
}
"""What each exit code says; an interrupted command ends with 128 and the number of the signal."""

PICTURES = (".png", ".pdf", ".svg", ".eps", ".jpg", ".jpeg", ".tif", ".tiff", ".webp")
"""Suffixes of pictures that Matplotlib can write."""


class Target(NamedTuple):
    """The two files of a command.

    Attributes
    ----------
    data, picture : Path
    """

    data: Path
    picture: Path


def target_of(out: str | None, name: str, data: str, *, force: bool) -> Target:
    """The files of ``--out``, checked before the computation starts.

    A suffix of :data:`PICTURES` belongs to the picture; ``data`` is the suffix of the data.

    Raises
    ------
    ValueError
        If a name belongs to a directory or a folder is missing; if a file exists already, without
        ``force``.
    """
    stem, picture = Path(out or name), ".png"
    if stem.suffix in PICTURES:
        picture = stem.suffix
    if stem.suffix in (data, *PICTURES):
        stem = stem.with_suffix("")
    if not stem.name:
        raise ValueError(f"--out: {str(stem)!r} names a directory, not a file")
    target = Target(*(stem.with_name(stem.name + suffix) for suffix in (data, picture)))
    for path in target:
        require_new(path, "--out", force=force)
    if not stem.parent.is_dir():
        raise ValueError(f"--out: there is no directory {str(stem.parent)!r}")
    return target


def require_new(path: Path, argument: str, *, force: bool) -> None:
    """Raise ValueError if a file exists already, without ``force``, or cannot be replaced."""
    try:
        exists = require_replaceable(path) is not None
    except FileExistsError as error:
        raise ValueError(f"{argument}: {error}") from None
    if exists and not force:
        raise ValueError(
            f"{argument} = {str(path)!r}: exists; take another name, or replace the file with "
            "--force"
        )


def say(text: str) -> None:
    """Print a text; go on without it if no reader is left, as in ``rigid maps | head -1``."""
    try:
        print(text, flush=True)
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def tell(facts: Mapping[str, str]) -> None:
    """Print a line for each fact; long lines are wrapped."""
    say(wrapped(labelled(facts.items())))


def complain(text: str, who: str = "rigid") -> None:
    """Print a message on stderr: wrapped in a terminal, one line elsewhere."""
    text = f"{who}: {text}"
    if sys.stderr is not None and sys.stderr.isatty():
        width = max(40, terminal_columns())
        text = fill(
            text, width, subsequent_indent="  ", break_long_words=False, break_on_hyphens=False
        )
    print(text, file=sys.stderr, flush=True)


def print_list(lines: Mapping[str, Any], *, as_json: bool) -> None:
    """Print a description for each name, or all as JSON."""
    if as_json:
        say(_json(lines))
        return
    width = max(map(len, lines)) + 2
    for name, value in lines.items():
        words = ", ".join(map(str, value)) if isinstance(value, (list, tuple)) else value
        say(wrapped(f"{name:<{width}}{'unknown' if words is None else words}", width))


def _json(facts: Mapping[str, Any]) -> str:
    """JSON text; numbers that are not finite become null, because JSON has none."""

    def checked(value: Any) -> Any:
        if isinstance(value, Mapping):
            return {name: checked(part) for name, part in value.items()}
        if isinstance(value, (list, tuple)):
            return [checked(part) for part in value]
        return None if isinstance(value, float) and not math.isfinite(value) else value

    return json.dumps(checked(facts), ensure_ascii=False, indent=2)


def finished(
    save: Callable[[Path], Path],
    draw: Callable[[], Any],
    target: Target,
    what: str,
    *,
    words: Callable[[], str],
    facts: Callable[[], Mapping[str, Any]] | None,
    ended: bool,
) -> int:
    """Save the data; then print words and paths, and draw the picture. Returns the exit code.

    With ``facts`` these and the paths are printed at the end, as JSON, instead of the words.
    ``draw`` returns axes of the figure. ``ended`` is False after an interruption.
    """
    with interruptible() as stop:
        data = _saved(save, target.data, what)
    safe = f"the {what} is safe in {data}"
    drawn: str | None = None
    try:
        if stop.is_set():
            raise KeyboardInterrupt
        if facts is None:
            say(wrapped(words()))
            tell({"data": str(data)})
        try:
            content = BytesIO()
            figure = np.ravel(draw())[0].figure
            figure.savefig(content, format=target.picture.suffix[1:])
        except ImportError as error:
            line = f"none: {error}"
        else:
            with published(target.picture) as file:
                file.write(content.getvalue())
            line = drawn = str(target.picture)
        if facts is None:
            tell({"picture": line})
        else:
            say(_json({**facts(), "data": str(data), "picture": drawn}))
    except KeyboardInterrupt:
        raise KeyboardInterrupt(f"interrupted; {safe}, there is no picture") from None
    except OSError as error:
        raise OSError(f"{error}; {safe}") from None
    if not ended:
        raise KeyboardInterrupt(f"interrupted; the {what} written is partial")
    return DONE


def _saved(save: Callable[[Path], Path], data: Path, what: str) -> Path:
    """Save the data, or raise OSError with the place where the data is instead."""
    try:
        return save(data)
    except OSError as error:
        try:
            folder = tempfile.gettempdir()
            spare = save(Path(folder, f"rigid-{os.urandom(8).hex()}-{data.name}"))
        except OSError:
            raise OSError(f"{error}; the {what} is not saved") from None
        raise OSError(f"{error}; the {what} is safe in {spare}") from None
