"""Mixtures of starts: each body takes one of several."""

from __future__ import annotations

from collections.abc import Container, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._checks.arguments import brief, numbers
from .noise import cumulative
from .start import Start

MOST_STARTS = 16


@dataclass(frozen=True, slots=True)
class Mixture:
    """Several starts, of which each body takes one at random; made by :func:`mixture`.

    Attributes
    ----------
    starts : tuple of Start
    weights : tuple of floats
        How likely each start is taken, up to a common factor.
    """

    starts: tuple[Start, ...]
    weights: tuple[float, ...]

    def __post_init__(self) -> None:
        for place, start in enumerate(self.starts):
            if not isinstance(start, Start):
                raise TypeError(f"starts[{place}] = {brief(start)}: must be a rigid.Start")
        if not 2 <= len(self.starts) <= MOST_STARTS:
            raise ValueError(f"starts: {len(self.starts)} are given, must be 2 to {MOST_STARTS}")
        weights = numbers("weights", self.weights)
        if weights.shape != (len(self.starts),):
            raise ValueError(
                f"weights: expected shape ({len(self.starts)},), one for each start, got "
                f"{weights.shape}"
            )
        wrong = ~(np.isfinite(weights) & (weights > 0.0))
        if wrong.any():
            at = int(np.argmax(wrong))
            raise ValueError(f"weights[{at}] = {weights[at]:g}: must be positive and finite")
        object.__setattr__(self, "weights", tuple(weights.tolist()))

    def shares(self) -> NDArray[np.float64]:
        """Cumulative chances of the starts, the last 1."""
        return cumulative(self.weights)

    def to_dict(self) -> dict[str, Any]:
        """The mixture as a JSON-able dictionary; :func:`start_from_dict` reads it.

        Returns
        -------
        dict
        """
        return {
            "mixture": [start.to_dict() for start in self.starts],
            "weights": list(self.weights),
        }

    def describe(self, varied: Container[str] = ()) -> str:
        """The starts in words; ``varied`` names the parts that the axes of a map set.

        Parameters
        ----------
        varied : container of str
            Names of parameters that vary.

        Returns
        -------
        str
        """
        total = sum(self.weights)
        return "; or ".join(
            f"{weight / total:.3g} of the bodies: {start.describe(varied)}"
            for start, weight in zip(self.starts, self.weights, strict=True)
        )


def mixture(starts: Iterable[Start], weights: ArrayLike | None = None) -> Mixture:
    """A mixture of starts: each body of a map takes one start at random, with its perturbations.

    Which one is a pure function of seed, pixel and sample. What a start draws does not depend on
    the other starts: a body that takes it begins as in a map of this start alone. An axis of the
    map sets its number in every start, and must apply to each.

    Parameters
    ----------
    starts : iterable of Start
        2 to 16 starts.
    weights : array_like, shape (n,), optional
        How likely each start is taken, up to a common factor; by default all are alike.

    Returns
    -------
    Mixture
        The ``start`` of a map.

    Raises
    ------
    TypeError
        If one is no start.
    ValueError
        If there are too few or too many, or a weight is not positive.

    Examples
    --------
    One throw of ten is wild:

    >>> import rigid
    >>> throw = [rigid.Start(spin=1.0, axis=2, noise=rigid.normal(size)) for size in (1e-3, 0.3)]
    >>> result = rigid.stability_map(
    ...     rigid.FreeBody, axes={"I2/I1": [1.2, 1.5, 1.8]}, samples=500, t_end=10.0, rng=1,
    ...     start=rigid.mixture(throw, weights=[9, 1]), stable=rigid.no_flip(),
    ... )
    >>> result.share.round(2)
    array([0.91, 0.92, 0.91])
    """
    several = tuple(starts)
    given = np.ones(len(several)) if weights is None else weights
    return Mixture(several, given)  # type: ignore[arg-type]  # normalised in __post_init__


def start_from_dict(data: Mapping[str, Any]) -> Start | Mixture:
    """The start or the mixture that ``to_dict`` described."""
    if "mixture" not in data:
        return Start.from_dict(data)
    return Mixture(tuple(map(Start.from_dict, data["mixture"])), data["weights"])
