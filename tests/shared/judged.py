"""What is said of one random case beside what is true."""

from dataclasses import dataclass

import numpy as np

__all__ = ["VERDICTS", "Judged"]

VERDICTS = ("right", "within", "flagged", "refused", "no truth", "UNDETECTED")
"""*Within*: off by what some roundings of the inputs change. *UNDETECTED*: off by more, unsaid."""


@dataclass(frozen=True)
class Judged:
    """The verdict on a case, with its true and its stated error where there are such."""

    kind: str
    verdict: str
    off: float = np.nan
    stated: float = np.nan
    words: str = ""
