"""The custom criterion, which a function of the user decides."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from .._checks.arguments import one_of, sorted_times
from .._checks.arrays import Floats
from .._checks.quantities import plain
from .criterion import Condition, Criterion
from .sourced import Sourced

RECORDS = ("attitude", "axis", "rates")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class States:
    """States of some bodies of a map, the argument of the function of :func:`judged`.

    Attributes
    ----------
    t : ndarray, shape (m,)
        Times, s.
    omega : ndarray, shape (n, m, 3)
        Rates in the body, rad/s.
    gamma : ndarray, shape (n, m, 3), or None
        Upward vertical in the body; with ``of="attitude"`` or ``of="axis"``.
    attitude : ndarray, shape (n, m, 4), or None
        Quaternions (w, x, y, z); with ``of="attitude"``.
    states : ndarray, shape (n, m, k), or None
        States of :meth:`Torque.call` with ``states=k``.
    parameters : dict of str to ndarray, shape (n,)
        Values of the axes of the map.
    """

    t: Floats
    omega: Floats
    gamma: Floats | None
    attitude: Floats | None
    states: Floats | None
    parameters: Mapping[str, Floats]


@dataclass(frozen=True, slots=True)
class Custom(Criterion):
    """Stable if a function of the states returns true for a body; made by :func:`judged`."""

    name: ClassVar[str] = "judged"
    of_numbers: ClassVar[bool] = False
    alone: ClassVar[str | None] = "has a function, which can join conditions itself"

    source: Sourced
    times: tuple[float, ...]
    of: str = "attitude"

    @property
    def record(self) -> str:  # type: ignore[override]
        """The state that is integrated."""
        return self.of

    def until_time(self, t_end: float) -> Custom:
        """The criterion whose function sees the times up to one of them."""
        return replace(self, times=tuple(t for t in self.times if t <= t_end))

    def conditions(self) -> tuple[Condition, ...]:
        """The condition of a request that draws the starts; the core does not watch it."""
        return (("no_flip", 1, ()),)

    def closed_form_question(self) -> tuple[str, None]:
        """Bodies whose states have a closed form are not integrated."""
        return "states", None

    def verdicts(self, states: States) -> Floats:
        """The answers of the function: positive for stable, NaN for undecided."""
        found = np.asarray(plain("stable", self.source.call("stable")(states)))
        count = len(states.omega)
        if found.shape != (count,) or found.dtype.kind not in "bif":
            raise ValueError(
                f"stable = {self.source.name}: must return a boolean or a number for each body, of "
                f"shape ({count},), got {found.dtype} of shape {found.shape}"
            )
        return found.astype(np.float64)

    def to_dict(self) -> dict[str, Any]:
        """Name and digests of the function, its times, and the states it gets."""
        return {
            "criterion": self.name,
            "function": self.source.to_dict(),
            "times": list(self.times),
            "of": self.of,
        }

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Custom:
        """The criterion that :meth:`to_dict` described; its function must be given again."""
        of = one_of("of", data["of"], RECORDS)
        return cls(Sourced.from_dict(data["function"]), _times(data["times"]), of)

    def __str__(self) -> str:
        return f"judged by {self.source.name}"


def judged(
    function: Callable[[States], ArrayLike], t: ArrayLike, *, of: str = "attitude"
) -> Custom:
    """Stable by a custom criterion: a function of the states of a body at given times decides.

    The bodies are drawn, integrated, counted and checked as for any criterion. Each integrated body
    is integrated by a second method too: if the function says otherwise of these states, the body
    is undecided. Bodies whose motion has a closed form are not integrated. States between the times
    are not checked.

    Parameters
    ----------
    function : callable
        ``function(states)`` gets the states of some bodies, and returns for each whether it is
        stable, shape (n,): a boolean, or a number that is positive if the body is stable, and NaN
        if that is undecided. What it says of a body must not depend on the other bodies, which are
        those that happen to be computed together. ``states.t`` (m,); ``states.omega`` (n, m, 3),
        rad/s; ``states.gamma`` (n, m, 3), the upward vertical in the body; ``states.attitude``
        (n, m, 4), quaternions; ``states.states`` (n, m, k), the states of :meth:`Torque.call` with
        ``states=k``; ``states.parameters``: the values of the axes of the map by their
        names, (n,), among them ``limit``, which the function may take as it likes. Saved maps hold
        digests of its source and of what it takes from outside: default arguments, closures,
        globals that its code names, attributes of ``self``, and the same of the functions it calls.
    t : array_like, shape (m,)
        Times, s, ascending. The last one is the horizon of the map. With an axis ``t_end`` of the
        map, whose values are among the times, the function sees those up to the horizon.
    of : {"attitude", "axis", "rates"}
        Recorded states: all; rates, and the vertical of tops; or rates alone, which costs less.
        Omitted states are None.

    Returns
    -------
    Judged

    Raises
    ------
    TypeError
        If it is no function, or takes something from outside that has no digest, such as a file.
    ValueError
        If the times are negative or not ascending, or ``of`` is unknown.

    Examples
    --------
    >>> import numpy as np, rigid
    >>> def keeps_its_sign(states):
    ...     return (states.omega[..., 1] > 0.0).all(axis=1)
    >>> asked = {"axes": {"spin": [1.0, 2.0]}, "samples": 20, "rng": 1}
    >>> t = np.linspace(0.0, 50.0, 501)
    >>> result = rigid.stability_map(
    ...     rigid.FreeBody, stable=rigid.judged(keeps_its_sign, t, of="rates"), **asked
    ... )
    >>> flips = rigid.stability_map(rigid.FreeBody, stable=rigid.no_flip(), t_end=50.0, **asked)
    >>> bool((result.stable == flips.stable).all())
    True
    """
    return Custom(Sourced.of("function", function), _times(t), one_of("of", of, RECORDS))


def _times(t: ArrayLike) -> tuple[float, ...]:
    times = sorted_times("t", t)
    if not times.size or times[0] < 0.0 or times[-1] <= 0.0:
        raise ValueError("t: must be times from 0 on, the last one positive")
    return tuple(times.tolist())
