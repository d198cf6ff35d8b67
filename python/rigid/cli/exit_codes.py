"""The exit codes of the command by their meanings, as ``rigid --help`` and the docs list them."""

from __future__ import annotations

from collections.abc import Mapping

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
