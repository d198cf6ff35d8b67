"""The interface of all criteria, and criteria that are joined by logic."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import MISSING, asdict, dataclass, field, fields, replace
from typing import Any, ClassVar, Self, TypeAlias

from .._checks.arguments import brief
from .scene import Scene
from .start import Start
from .time_unit import SECONDS, Clock

Condition: TypeAlias = tuple[str, int, tuple[float, ...]]
"""Name, axis and limits of one condition as the core takes them."""

MOST_LEAVES = 8
"""Most criteria that are joined: the core takes twice as many conditions."""

SIGNS = {"and": "&", "or": "|", "not": "~"}
"""The operations by their names in files, as the core takes them."""


CRITERIA: dict[str, type[Criterion]] = {}
"""The criteria that functions of :mod:`rigid` make of numbers, by their names."""


def checked(check: Callable[[str, Any], Any], default: Any = MISSING) -> Any:
    """A field of a criterion, whose values other than the default ``check(name, value)`` gives."""
    return field(default=default, metadata={"check": check})


class Criterion(ABC):
    """A definition of *stable*: the interface of all criteria. ``str`` describes the criterion.

    Attributes
    ----------
    name : str
        Name in :data:`CRITERIA`, in map files and saved maps; a function of this name in
        :mod:`rigid` makes the criterion.
    of_numbers : bool
        Whether numbers alone make it, so that it is in :data:`CRITERIA`.
    stays : str
        A body that meets the criterion, in one word.
    record : {"rates", "axis", "attitude"}
        The state that must be integrated to observe the criterion.
    has_deviation : bool
        Whether a deviation vector is integrated with the motion.
    alone : str or None
        Why it is not joined with others; None if it is.
    limited : str or None
        The angle (rad) that the axis ``limit`` of a map sets.
    """

    __slots__ = ()

    name: ClassVar[str]
    of_numbers: ClassVar[bool] = True
    stays: ClassVar[str] = "stable"
    record: ClassVar[str]
    has_deviation: ClassVar[bool] = False
    alone: ClassVar[str | None] = None
    limited: ClassVar[str | None] = None

    def __init_subclass__(cls) -> None:
        if "name" in vars(cls) and cls.of_numbers:
            CRITERIA[cls.name] = cls

    def __post_init__(self) -> None:
        for own in fields(self):  # type: ignore[arg-type]
            value = getattr(self, own.name)
            if "check" in own.metadata and value is not own.default:
                value = own.metadata["check"](own.name, value)
                object.__setattr__(self, own.name, value)

    def resolved(self, scene: Scene, start: Start) -> Self:
        """The criterion with all defaults filled in."""
        return self

    @abstractmethod
    def conditions(self) -> tuple[Condition, ...]:
        """The conditions that the core watches: name, axis and limits of each."""

    def logic(self) -> tuple[int | str, ...]:
        """How the conditions are joined, in postfix notation: their numbers and ``& | ~``.

        Each condition stands in it once.
        """
        return (0,)

    @property
    def leaves(self) -> tuple[Criterion, ...]:
        """The criteria that are joined; the criterion itself if none are."""
        return (self,)

    def closed_form_question(self) -> tuple[str, int | None] | None:
        """Name and axis in the list of closed forms of the core; None without a closed form."""
        return None

    def check_forced(self, scene: Scene, forces: Sequence[str]) -> None:  # noqa: B027
        """Raise ValueError if a map cannot observe the criterion under torque and damping."""

    def until(self, t_end: float, clock: Clock = SECONDS) -> str:
        """The criterion with its horizon in words."""
        return f"{self} until t = {clock.time(t_end)}"

    def to_dict(self) -> dict[str, Any]:
        """The criterion as a JSON-able dictionary."""
        return {"criterion": self.name, **asdict(self)}  # type: ignore[call-overload]

    def __and__(self, other: Criterion) -> Joined:
        """Both criteria are met."""
        return _joined("and", self, other)

    def __or__(self, other: Criterion) -> Joined:
        """At least one of the criteria is met."""
        return _joined("or", self, other)

    def __invert__(self) -> Joined:
        """The criterion is not met."""
        return _joined("not", self)

    def __bool__(self) -> bool:
        """Raise TypeError: ``a and b`` would be ``b``."""
        raise TypeError("criteria are joined by &, | and ~, not by and, or and not")


@dataclass(frozen=True, slots=True)
class Joined(Criterion):
    """Criteria joined by ``&``, ``|`` or ``~``.

    Each criterion holds or fails over the whole horizon, alone: ``a | b`` is met if one of them is,
    the same one all the time; ``~a`` is met if ``a`` was left. A criterion whose class is not known
    has no effect where the others decide.

    Attributes
    ----------
    operation : {"and", "or", "not"}
    parts : tuple of Criterion
        Two, or one for ``"not"``.
    """

    name: ClassVar[str] = "joined"
    of_numbers: ClassVar[bool] = False

    operation: str
    parts: tuple[Criterion, ...]

    def __post_init__(self) -> None:
        if self.operation not in SIGNS or len(self.parts) != 1 + (self.operation != "not"):
            raise ValueError(
                f"operation = {brief(self.operation)}: must be 'and' or 'or' of two criteria, or "
                "'not' of one"
            )
        for leaf in self.leaves:
            if leaf.alone is not None:
                raise ValueError(f"{leaf.name}() {leaf.alone}: it is not joined with others")
        if len(self.leaves) > MOST_LEAVES:
            raise ValueError(
                f"{len(self.leaves)} criteria are joined: at most {MOST_LEAVES} may be"
            )
        if len(self.logic()) > 64:
            raise ValueError("the logic of the joined criteria has more than 64 terms")

    @property
    def leaves(self) -> tuple[Criterion, ...]:
        """The criteria that are joined, from left to right."""
        return tuple(leaf for part in self.parts for leaf in part.leaves)

    @property
    def record(self) -> str:  # type: ignore[override]
        """The largest state that one of the criteria needs."""
        records = ("rates", "axis", "attitude")
        return max((leaf.record for leaf in self.leaves), key=records.index)

    def resolved(self, scene: Scene, start: Start) -> Self:
        """The criteria with all defaults filled in."""
        return replace(self, parts=tuple(part.resolved(scene, start) for part in self.parts))

    def conditions(self) -> tuple[Condition, ...]:
        """The conditions of all criteria."""
        return tuple(condition for leaf in self.leaves for condition in leaf.conditions())

    def logic(self) -> tuple[int | str, ...]:
        """The logic of the criteria, joined."""
        words: list[int | str] = []
        for part in self.parts:
            first = sum(isinstance(word, int) for word in words)
            words += [word if isinstance(word, str) else word + first for word in part.logic()]
        return (*words, SIGNS[self.operation])

    def check_forced(self, scene: Scene, forces: Sequence[str]) -> None:
        """Raise ValueError if one of the criteria cannot be observed under torque and damping."""
        for leaf in self.leaves:
            leaf.check_forced(scene, forces)

    def to_dict(self) -> dict[str, Any]:
        """The criteria as a JSON-able dictionary."""
        parts = [part.to_dict() for part in self.parts]
        return {"criterion": self.name, "operation": self.operation, "parts": parts}

    def __str__(self) -> str:
        words = [f"({part})" if isinstance(part, Joined) else str(part) for part in self.parts]
        return f"not ({self.parts[0]})" if len(words) == 1 else f" {self.operation} ".join(words)


def can_be_left(logic: Sequence[int | str]) -> bool:
    """Whether the logic may turn from true to false while its conditions fail one by one.

    A condition that is not negated, or twice, decides somewhere, because it stands there once.
    """
    stack: list[set[bool]] = []  # whether conditions of a part are negated
    for word in logic:
        if isinstance(word, int):
            stack.append({False})
        elif word == "~":
            stack.append({not negated for negated in stack.pop()})
        else:
            stack.append(stack.pop() | stack.pop())
    (negated,) = stack
    return False in negated


def _joined(operation: str, *parts: Criterion) -> Joined:
    for part in parts:
        if not isinstance(part, Criterion):
            raise TypeError(f"{SIGNS[operation]} {brief(part)}: must be a criterion")
    return Joined(operation, parts)
