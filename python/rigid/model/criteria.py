"""The criteria of a map: definitions of *stable*; the horizon is stated elsewhere.

A new criterion is one more class here or in ``bounds.py``, and the function that makes it; the core
selects the observable by the name that :meth:`Criterion.conditions` gives.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import MISSING, dataclass, fields, replace
from functools import partial
from typing import Any, ClassVar, Self

import numpy as np

from .._checks.arguments import brief, finite_float, one_of
from . import bounds as bounds  # whose criteria come first in CRITERIA
from .criterion import CRITERIA, Condition, Criterion, Joined, checked
from .judged import Custom
from .scene import Scene
from .start import Start
from .time_unit import SECONDS, Clock

POSITIVE = partial(finite_float, positive=True)

NORMS = ("rates", "attitude")
"""The parts of a deviation vector whose growth is measured: rates and vertical, or rates and
attitude."""


@dataclass(frozen=True, slots=True)
class Regular(Criterion):
    """Stable while the motion is regular, not chaotic; made by :func:`regular`."""

    name: ClassVar[str] = "regular"
    stays: ClassVar[str] = "regular"
    record: ClassVar[str] = "axis"
    has_deviation: ClassVar[bool] = True
    alone: ClassVar[str | None] = "integrates a deviation vector"

    of: str | None = checked(partial(one_of, known=NORMS), None)
    sure: float = checked(POSITIVE, 2.1)
    low: float = checked(POSITIVE, 3.0)
    high: float = checked(POSITIVE, 5.0)
    ratio: float = checked(POSITIVE, 1.5)

    def __post_init__(self) -> None:
        Criterion.__post_init__(self)  # super() does not know a class with slots
        if self.sure > self.low:
            raise ValueError(f"sure = {self.sure:g}: must be at most low = {self.low:g}")
        if self.low >= self.high:
            raise ValueError(f"low = {self.low:g}: must be below high = {self.high:g}")
        if self.ratio <= 1.0:
            raise ValueError(f"ratio = {self.ratio:g}: must be above 1, the ratio of a power law")

    @property
    def limits(self) -> tuple[float, float, float, float]:
        """The numbers of the rule, as the core takes them."""
        return self.sure, self.low, self.high, self.ratio

    def resolution(self, t_end: float) -> float:
        """The smallest exponent (1/s) that a horizon (s) can show.

        The mean MEGNO of an exponent is half of it times the horizon.
        """
        return 2.0 * self.high / t_end

    def resolved(self, scene: Scene, start: Start) -> Self:
        """The criterion with the norm that serves the scene."""
        return replace(self, of=norm_of(self.of, scene))

    def conditions(self) -> tuple[Condition, ...]:
        """Name, no axis, and the numbers of the rule as the core takes them."""
        return ((f"regular_{self.of}", 0, self.limits),)

    def closed_form_question(self) -> tuple[str, None]:
        """Free bodies and Lagrange tops are regular by theorem."""
        return "regular", None

    def until(self, t_end: float, clock: Clock = SECONDS) -> str:
        """The criterion with its horizon, and the least exponent that it can show, in words."""
        seen = clock.rate(self.resolution(t_end))
        return f"{self}: no exponent above {seen} until t = {clock.time(t_end)}"

    def __str__(self) -> str:
        return "regular with its attitude" if self.of == "attitude" else "regular"


def regular(
    of: str | None = None,
    sure: float = 2.1,
    low: float = 3.0,
    high: float = 5.0,
    ratio: float = 1.5,
) -> Regular:
    """Stable: the motion is regular, as far as its horizon can show; unstable: it is chaotic.

    A small deviation vector is integrated with the motion. The vector grows like a power of the
    time on regular motions, and exponentially on chaotic ones. The mean MEGNO then stays constant,
    or doubles with the time. A motion that is neither yet is undecided. A map runs each body twice,
    by two methods and from two deviation vectors, which keep ``L·gamma`` of a top without torque
    and damping. A body is regular if both runs are; chaotic if one is and the other is not regular.

    Parameters
    ----------
    of : {"rates", "attitude"}, optional
        The size of a deviation vector, and its default, as in :func:`rigid.lyapunov`.
    sure, low : float
        A run is regular if its mean MEGNO at the horizon is below ``sure``, or below ``low`` and
        less than 1/2 above its value at half of the horizon. The limit of regular motions is 2.
    high, ratio : float
        A run is chaotic if its mean MEGNO is above ``high`` and above ``ratio`` times its value at
        half of the time. At a quarter and at half of the horizon the mean MEGNO must be above twice
        ``high``; the run then ends. Quadratic growth gives 4 and a ratio of 1, exponential growth a
        ratio of 2.

    Returns
    -------
    Regular

    Raises
    ------
    ValueError
        If ``of`` is unknown, or unless ``sure <= low < high`` and ``ratio > 1``.

    Notes
    -----
    *Regular* always means: no growth like ``exp(k t)`` with ``k`` above ``2 high / T`` until the
    horizon ``T``; growth that ends before may have been faster. Free bodies and symmetric tops with
    their centre of mass on the axis are regular by theorem and not run; exactly on a separatrix
    they are undecided. Other motions on a separatrix may be called chaotic although they are not; a
    little noise of the start leads off it.

    References
    ----------
    P. M. Cincotta, C. Simó, Astron. Astrophys. Suppl. 147 (2000) 205, doi 10.1051/aas:2000108.

    Examples
    --------
    >>> import rigid
    >>> rigid.regular().until(200.0)
    'regular: no exponent above 0.05/s until t = 200 s'
    """
    return Regular(of, sure, low, high, ratio)


def norm_of(of: str | None, scene: Scene) -> str:
    """The norm of deviation vectors of a scene: the norm of the rates if it shows all growth.

    Raises
    ------
    ValueError
        If the norm that is given does not see what a torque makes grow.
    """
    turns = scene.orbit is not None or (
        scene.torque is not None and bool(np.any(np.asarray(scene.torque.in_space)[..., :2]))
    )
    if of is None:
        return "attitude" if turns else "rates"
    if one_of("of", of, NORMS) == "rates" and turns:
        raise ValueError(
            f"of = {of!r}: the rates do not see turns about the vertical, which matter on an orbit "
            "and under a torque in space that is not vertical; use 'attitude'"
        )
    return of


def check_criterion(name: str, criterion: object) -> Criterion:
    """``criterion``, if it is a criterion."""
    if isinstance(criterion, Criterion):
        return criterion
    raise TypeError(f"{name} = {brief(criterion)}: must be a criterion, {known_criteria()}")


def known_criteria() -> str:
    """The functions that make criteria, with their required arguments, in words."""
    calls = []
    for known in CRITERIA.values():
        needed = [own.name for own in fields(known) if own.default is MISSING]  # type: ignore[arg-type]
        calls.append(f"rigid.{known.name}({', '.join(needed)})")
    return " or ".join(calls)


def criterion_from_dict(data: Mapping[str, Any]) -> Criterion:
    """The criterion that :meth:`Criterion.to_dict` described."""
    values = dict(data)
    name = values.pop("criterion")
    if name == Custom.name:
        return Custom.from_dict(values)
    if name == Joined.name:
        parts = tuple(criterion_from_dict(part) for part in values["parts"])
        return Joined(values["operation"], parts)
    return CRITERIA[name](**values)
