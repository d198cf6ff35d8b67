"""All numbers of the literature, each beside the number of the library."""

from __future__ import annotations

import time
import tomllib
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache, partial
from importlib import import_module, resources
from typing import Any

from .._checks.arguments import one_of
from .._checks.extras import install_extra
from .._checks.progress import ProgressOption, reporting
from .._checks.shown import aligned, counted, wrapped
from ..drawing.figure import html_table
from .entry import Entry

HEADER = ("name", "published", "here", "difference", "interval", "unit")


@cache
def entries() -> tuple[Entry, ...]:
    """All entries, text by text."""
    table = resources.files(__package__).joinpath("numbers.toml").read_text(encoding="utf-8")
    found = []
    for text in tomllib.loads(table)["text"]:
        for number in text.pop("number"):
            row = {**text, **number, "compute": partial(_computed, *number["compute"])}
            for name in ("value", "within", "model"):
                if isinstance(row.get(name), list):
                    row[name] = _computed(*row[name])
            found.append(Entry(**row))
    return tuple(found)


def _computed(name: str, *arguments: Any) -> float:
    """What a function of this package returns, or a constant of it."""
    module, name = name.split(".")
    found = getattr(import_module(f".{module}", __package__), name)
    number: float = found(*arguments) if callable(found) else found
    return number


@dataclass(frozen=True, slots=True, kw_only=True)
class Compared:
    """A number of the literature beside the number that the library computes.

    Attributes
    ----------
    entry : Entry
        Quantity, published number, interval and source.
    number : float
        The number of the library.
    seconds : float
        Wall time of the computation.
    """

    entry: Entry
    number: float
    seconds: float

    @property
    def difference(self) -> float:
        """The number of the library less the published one."""
        return self.number - self.entry.value

    @property
    def agrees(self) -> bool:
        """Whether the difference lies within the interval."""
        return abs(self.difference) <= self.entry.within

    @property
    def explained(self) -> bool:
        """Whether the numbers agree, or the number is the one of the model that differs."""
        # Medians of chaotic motions scatter by some percent.
        within = min(self.entry.within, 0.1 * abs(self.entry.model))
        return self.agrees or abs(self.number - self.entry.model) <= within

    @property
    def command(self) -> str:
        """The command that computes the number."""
        return f"rigid validation {self.entry.name}"

    def to_dict(self) -> dict[str, Any]:
        """All attributes as plain Python values."""
        entry = {name: getattr(self.entry, name) for name in Entry.__slots__ if name != "compute"}
        return {
            **entry,
            "number": self.number,
            "difference": self.difference,
            "agrees": self.agrees,
            "seconds": self.seconds,
        }

    @property
    def verdict(self) -> str:
        """Whether the numbers agree, in words."""
        return "agrees" if self.agrees else "the model differs" if self.explained else "differs"

    def cells(self, digits: int = 9) -> tuple[str, ...]:
        """Name, published number, number, difference, interval and unit, as text."""
        entry = self.entry
        return (
            entry.name,
            entry.digits or f"{entry.value:.{digits}g}",
            f"{self.number:.{digits}g}",
            f"{self.difference:+.1e}",
            f"{entry.within:.2g}",
            entry.unit,
        )


@dataclass(frozen=True, slots=True)
class Validation:
    """The result of :func:`validation`: each published number beside the computed one."""

    rows: tuple[Compared, ...]

    @property
    def unexplained(self) -> tuple[Compared, ...]:
        """Rows whose numbers differ without a reason."""
        return tuple(row for row in self.rows if not row.explained)

    def __repr__(self) -> str:
        agreeing = sum(row.agrees for row in self.rows)
        models = sum(row.explained for row in self.rows) - agreeing
        return (
            f"<Validation: {counted(len(self.rows), 'number')}: {agreeing} agree, {models} of "
            f"models that differ, {len(self.unexplained)} unexplained>"
        )

    def _repr_html_(self) -> str:
        rows = [(*row.cells(), row.verdict) for row in self.rows]
        return html_table(rows, header=(*HEADER, "verdict"))

    def __str__(self) -> str:
        """A table: a row for each number; below, why models differ. A star marks what differs."""
        table: list[tuple[str, ...]] = [(*HEADER[:3], "off by ", *HEADER[4:])]
        for row in self.rows:
            name, published, here, difference, *rest = row.cells(digits=6)
            star = " " if row.agrees else "*"
            table.append((name, published, here, f"{difference}{star}", *rest))
        lines = aligned(table, right=range(1, 5))
        reasons = [
            f"* {row.entry.name}: {row.verdict}; {row.entry.reason or 'no reason is known'}"
            for row in self.rows
            if not row.agrees
        ]
        below = [wrapped(reason, indent=2) for reason in reasons]
        return "\n".join([*lines, *([""] if below else []), *below])


def validation(
    names: str | Iterable[str] | None = None, *, progress: ProgressOption = None
) -> Validation:
    """Compute numbers that the literature states, and compare them with the published ones.

    Parameters
    ----------
    names : str or iterable of str, optional
        Only the entries of these names; by default all, but those whose torque numba must compile
        only where it is installed.
    progress : bool or callable, optional
        As of :func:`stability_map`.

    Returns
    -------
    Validation

    Raises
    ------
    ValueError
        If there is no entry of such a name.
    ImportError
        If such an entry needs numba, which is not installed.

    Examples
    --------
    >>> import rigid
    >>> (row,) = rigid.validation("toutatis-precession").rows
    >>> row.entry.printed, round(row.number, 3), row.agrees
    ('7.40 ± 0.03', 7.4, True)
    """
    known = {entry.name: entry for entry in entries()}
    if names is None:
        chosen = [entry for entry in known.values() if entry.is_ready]
    else:
        wanted = [names] if isinstance(names, str) else list(names)
        chosen = [known[one_of("names", name, known)] for name in wanted]
    for entry in chosen:
        if not entry.is_ready:
            raise ImportError(install_extra(f"{entry.name} needs {entry.needs}", entry.needs))
    rows: list[Compared] = []
    with reporting(progress, len(chosen), unit=" numbers") as report:
        for done, entry in enumerate(chosen, start=1):
            begun = time.perf_counter()
            number = entry.compute()
            seconds = time.perf_counter() - begun
            rows.append(Compared(entry=entry, number=number, seconds=seconds))
            report(done)
    return Validation(tuple(rows))
