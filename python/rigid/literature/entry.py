"""One number of the literature, and the function that computes it again."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from importlib.util import find_spec
from math import isnan, nan


@dataclass(frozen=True, slots=True, kw_only=True)
class Entry:
    """A number that a text states.

    Attributes
    ----------
    name : str
        Name of the entry, for the command line.
    quantity : str
        What the number is, with the model in which it is computed here.
    printed : str
        The number or the formula as the source has it.
    value : float
        The number, by default the printed one; of a formula its value for the body of the entry.
    within : float
        Largest difference from the number that counts as agreement, by default the printed error,
        or half a unit of the last printed digit.
    interval : str
        Where ``within`` comes from: the stated error, the rounding of the printed number, or the
        error of the computation.
    unit : str
        Unit of the number; empty for pure numbers.
    source : str
        Full reference.
    seen : str
        The text in which the number was looked up, or that it could not be.
    compute : callable
        Computes the number by the library.
    reason : str
        Why the number of a model lies outside the interval; empty where it must lie inside.
    model : float
        The number of that model by another way; NaN where there is no reason.
    needs : str
        A package without which the number would take hours; empty for most.
    """

    name: str
    quantity: str
    printed: str
    value: float = nan
    within: float = nan
    interval: str = ""
    unit: str = ""
    source: str
    seen: str
    compute: Callable[[], float]
    reason: str = ""
    model: float = nan
    needs: str = ""

    def __post_init__(self) -> None:
        if self.digits is None:
            return
        _, _, error = self.printed.partition(" ± ")
        decimals = len(self.digits.partition(".")[2])
        if isnan(self.value):
            object.__setattr__(self, "value", float(self.digits))
        if isnan(self.within):
            object.__setattr__(self, "within", float(error or f"5e-{decimals + 1}"))
        if not self.interval:
            object.__setattr__(self, "interval", "stated error" if error else "rounding")

    @property
    def is_ready(self) -> bool:
        """Whether the package that it needs is installed."""
        return not self.needs or find_spec(self.needs) is not None

    @property
    def digits(self) -> str | None:
        """The number as text, without its error; None for a formula or words."""
        found = re.fullmatch(r"([\d.]+)( ± [\d.]+)?", self.printed)
        return None if found is None else found[1]
