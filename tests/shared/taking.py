"""Functions that judge bodies by a limit, which each holds in another way."""

import dataclasses
import enum
import functools
import sys
import types
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

import rigid

Verdicts = NDArray[np.bool_]
Judge = Callable[[rigid.States], Verdicts]

LIMIT: Any = 0.1
TABLE = {"low": 0.1, "high": 9.0}
SETTINGS = types.ModuleType("taking_settings")
SETTINGS.limit = 0.1  # type: ignore[attr-defined]
sys.modules["taking_settings"] = SETTINGS
CYCLE: list[Any] = ["limit", 0.1]
CYCLE.append(CYCLE)


def below(states: rigid.States, limit: Any) -> Verdicts:
    """Whether the smallest axis turns slowly all the time."""
    kept: Verdicts = np.all(np.abs(states.omega[..., 0]) < limit, axis=1)
    return kept


def by_global(states: rigid.States) -> Verdicts:
    return below(states, LIMIT)


def by_inner_function(states: rigid.States) -> Verdicts:
    return np.array(
        [(lambda one: bool(np.all(np.abs(one) < LIMIT)))(b) for b in states.omega[..., 0]]
    )


def by_function_of_a_function(states: rigid.States) -> Verdicts:
    return by_global(states)


def by_itself(states: rigid.States, again: bool = True) -> Verdicts:
    return by_itself(states, False) if again else below(states, LIMIT)


def by_module(states: rigid.States) -> Verdicts:
    return below(states, SETTINGS.limit)


def by_table(states: rigid.States) -> Verdicts:
    return below(states, TABLE["low"])


def by_cycle(states: rigid.States) -> Verdicts:
    return below(states, CYCLE[2][1])


def with_default(limit: float) -> Judge:
    def judge(states: rigid.States, limit: float = limit) -> Verdicts:
        return below(states, limit)

    return judge


def with_keyword_default(limit: float) -> Judge:
    def judge(states: rigid.States, *, limit: float = limit) -> Verdicts:
        return below(states, limit)

    return judge


def with_closure(limit: Any) -> Judge:
    def judge(states: rigid.States) -> Verdicts:
        return below(states, limit)

    return judge


def with_array(limit: float) -> Judge:
    return with_closure(np.full(1, limit))


def with_partial(limit: float) -> Judge:
    return functools.partial(below, limit=limit)


def with_decorator(limit: float) -> Judge:
    inner = with_closure(limit)

    @functools.wraps(inner)
    def judge(states: rigid.States) -> Verdicts:
        return inner(states)

    return judge


@dataclasses.dataclass(frozen=True)
class Limits:
    """Numbers of a frozen dataclass."""

    low: float
    high: float = 9.0


def with_dataclass(limit: float) -> Judge:
    limits = Limits(limit)

    def judge(states: rigid.States) -> Verdicts:
        return below(states, limits.low)

    return judge


class Judging:
    """An object that can be called, and whose method can be given."""

    def __init__(self, limit: float) -> None:
        self.limit = limit

    def __call__(self, states: rigid.States) -> Verdicts:
        return self.judge(states)

    def judge(self, states: rigid.States) -> Verdicts:
        return below(states, self.limit)

    @functools.cached_property
    def used(self) -> int:
        """What is computed when it is asked for is no part of what the object is."""
        return 1


def with_object(limit: float) -> Judge:
    return Judging(limit)


def with_method(limit: float) -> Judge:
    return Judging(limit).judge


def with_class(limit: float) -> Judge:
    class Own:
        """Its limit is that of the class."""

        low = limit

        def __call__(self, states: rigid.States) -> Verdicts:
            return below(states, self.low)

    return Own()


class Pair:
    """An object that tells its state in a way of its own."""

    def __init__(self, limit: float) -> None:
        self.limit = limit

    def __getstate__(self) -> tuple[float, str]:
        return self.limit, "the limit"

    def __call__(self, states: rigid.States) -> Verdicts:
        return below(states, self.limit)


def with_set(limit: float) -> Judge:
    judges = {with_closure(limit), with_closure(0.0)}

    def judge(states: rigid.States) -> Verdicts:
        return np.any([one(states) for one in judges], axis=0)  # type: ignore[no-any-return]

    return judge


def with_list(limit: float) -> Judge:
    judges = [with_closure(0.0), with_closure(limit)]

    def judge(states: rigid.States) -> Verdicts:
        return judges[1](states)

    return judge


def with_attribute(limit: float) -> Judge:
    def judge(states: rigid.States) -> Verdicts:
        return below(states, judge.limit)  # type: ignore[attr-defined]

    judge.limit = limit  # type: ignore[attr-defined]
    return judge


class Axis(enum.Enum):
    FIRST = 0
    SECOND = 1


#: How to make a function with a limit, and the name of the limit in what it takes.
HELD: dict[str, tuple[Callable[[float], Judge], str]] = {
    "default": (with_default, "limit"),
    "keyword default": (with_keyword_default, "limit"),
    "closure": (with_closure, "limit"),
    "array": (with_array, "limit"),
    "partial": (with_partial, "limit"),
    "decorator": (with_decorator, "inner.limit"),
    "dataclass": (with_dataclass, "limits"),
    "object": (with_object, "self.limit"),
    "method": (with_method, "self.limit"),
    "class": (with_class, "with_class.<locals>.Own.low"),
    "own state": (Pair, "self.state"),
    "set of functions": (with_set, "judges"),
    "list of functions": (with_list, "judges"),
    "attribute of the function": (with_attribute, "judge.limit"),
}

#: Functions of a global, what sets it, and its name in what they take.
GLOBALS: dict[str, tuple[Judge, Callable[[Any, float], None], str]] = {
    "global": (by_global, lambda patch, x: patch.setattr("taking.LIMIT", x), "LIMIT"),
    "inner function": (by_inner_function, lambda p, x: p.setattr("taking.LIMIT", x), "LIMIT"),
    "function of a function": (
        by_function_of_a_function,
        lambda patch, x: patch.setattr("taking.LIMIT", x),
        "by_global.LIMIT",
    ),
    "itself": (by_itself, lambda patch, x: patch.setattr("taking.LIMIT", x), "LIMIT"),
    "module": (by_module, lambda patch, x: patch.setattr(SETTINGS, "limit", x), "SETTINGS.limit"),
    "table": (by_table, lambda patch, x: patch.setitem(TABLE, "low", x), "TABLE"),
    "cycle": (by_cycle, lambda patch, x: CYCLE.__setitem__(1, x), "CYCLE"),
}


def orders() -> dict[str, str]:
    """What a function takes that holds sets and dicts: the same in every process."""
    words = {f"word {k}" for k in range(50)}
    numbers = {float(k): Axis.FIRST for k in words_in_order(words)}
    both = frozenset({(1, "a"), (2, "b"), Limits(0.3)})

    def judge(states: rigid.States) -> Verdicts:
        return below(states, len(words) + len(numbers) + len(both) + ("b" in {"a", "b", "c"}))

    told: dict[str, str] = rigid.judged(judge, [1.0]).to_dict()["function"]
    return told


def words_in_order(words: set[str]) -> list[str]:
    """The numbers of words in the order of the set, which differs between processes."""
    return [word.split()[1] for word in words]
