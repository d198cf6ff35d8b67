"""The methods, their names and their properties."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from functools import cache

from .. import _core
from .._checks.shown import aligned
from ..drawing.figure import html_table
from ..model.forces import forces_in_words

EXACT = "exact"
"""The closed form of the motion, where there is one."""

AUTO = "auto"
"""In a map: the closed form for each body that has one, else :data:`MAP_FALLBACK`."""

_CHOSEN = _core.chosen_methods()

STIFF = _CHOSEN["stiff"]
"""The default method for strong damping."""

FALLBACK = _CHOSEN["default"]
"""The default method of bodies without a closed form."""

MAP_FALLBACK = _CHOSEN["map"]
"""The default method of the samples of a map without a closed form."""

MANY_TIMES = _CHOSEN["many_times"]
"""The default method of motions that a criterion of the user judges at its times."""

TO_ROUNDING = _CHOSEN["to_rounding"]
"""The method of motions that are asked for to rounding; it classifies judged motions again."""

SERIES, SERIES_TOLERANCE = _CHOSEN["series"], _core.SERIES_TOLERANCE
"""The series, with its tolerance, that leaves rounding alone."""

SECOND = _CHOSEN["second"]
"""The method that classifies the samples of a map again."""

FUNCTION = _CHOSEN["function"]
"""The method that knows its motion inside steps under a callback, and adapts its steps there."""

GROWTH_SECOND = _CHOSEN["second_growth"]
"""The second method of a map that measures the growth of deviation vectors."""


@dataclass(frozen=True, slots=True)
class Method:
    """Name, order, costs and properties of a method, and its source.

    Attributes
    ----------
    name : str
        The name for the argument ``method`` of functions.
    title, family : str
        One line; methods of one kind have one family, and one colour in pictures.
    order : int
        The error of a run falls as ``step**order``.
    stages : int
        Number, in each step, of evaluations of the equations of motion, exact partial flows, orders
        of a series, or Newton's steps.
    symplectic, reversible, group_preserving : bool
        Whether it preserves the Poisson structure; whether a step forward and a step back are the
        identity; whether ``|L|`` of the free body, ``|gamma|`` and ``|q|`` stay constant to
        rounding.
    conserves : tuple of str
        The quantities of a free body that stay constant to rounding with any step: ``"momentum"``,
        in space, and ``"energy"``.
    tangent : bool
        Whether it integrates small deviation vectors with the motion; a symplectic method only for
        bodies without torque and damping, and not by parameters.
    forces : tuple of str
        The forces that it integrates: ``"torque"``, ``"damping"``, ``"function"`` and the names of
        the others; empty if none.
    stiff : bool
        Whether it is stable for damping of any strength.
    tops, maps : bool
        Whether it integrates bodies with weight, not only free ones; whether it has a state after
        every step, which a map needs.
    series : bool
        Whether it is a Taylor series, which can take adaptive steps.
    compensated : bool
        Whether it carries the rounding error of a fixed step to the next step, as a Taylor series
        with a tolerance always does.
    damping_limit : float or None
        The largest product of step and damping rate with which it is stable, infinite if it is
        stiff; None if it integrates no forces.
    angle_per_step : float
        Largest angle (rad) by which a body turns in a default step.
    longest_angle : float
        Largest angle (rad) of a step that the method bears: over 1000 rad the energy, the angular
        momentum and the length of the quaternion change by less than 1e-3.
    citation, doi : str
        Publication of the method.
    """

    name: str
    title: str
    family: str
    order: int
    stages: int
    symplectic: bool
    reversible: bool
    group_preserving: bool
    conserves: tuple[str, ...]
    tangent: bool
    forces: tuple[str, ...]
    stiff: bool
    tops: bool
    maps: bool
    series: bool
    compensated: bool
    damping_limit: float | None
    angle_per_step: float
    longest_angle: float
    citation: str
    doi: str


class Methods(tuple[Method, ...]):
    """Methods, shown as a table."""

    __slots__ = ()

    HEADER = ("name", "order", "symplectic", "on the group", "conserves", "method")

    def _rows(self) -> list[tuple[str, ...]]:
        return [
            (
                method.name,
                str(method.order),
                "yes" if method.symplectic else "",
                "yes" if method.group_preserving else "",
                ", ".join(method.conserves),
                method.title,
            )
            for method in self
        ]

    def __repr__(self) -> str:
        return "\n".join(aligned([self.HEADER, *self._rows()]))

    def _repr_html_(self) -> str:
        return html_table(self._rows(), header=self.HEADER)


def methods() -> Methods:
    """All methods that make steps, with their properties; ``"exact"`` is not among them.

    Returns
    -------
    tuple of Method
        It prints as a table.

    Examples
    --------
    >>> import rigid
    >>> [(method.name, method.order) for method in rigid.methods() if not method.symplectic][:3]
    [('rk4', 4), ('dop853', 8), ('taylor12', 12)]
    """
    return _METHODS


_METHODS = Methods(Method(**facts) for facts in _core.methods())


@cache
def method_named(name: str) -> Method:
    """The method of a name."""
    return next(method for method in _METHODS if method.name == name)


def order_of(name: str) -> int:
    """The order of a method."""
    return method_named(name).order


@cache
def run_methods() -> tuple[str, ...]:
    """The names that :func:`rigid.simulate` accepts."""
    return (EXACT, *(method.name for method in methods()))


def series_methods() -> list[str]:
    """The names of the Taylor methods, which can take adaptive steps."""
    return [method.name for method in methods() if method.series]


def adaptive_methods(forces: Collection[str]) -> list[str]:
    """The names of the methods with adaptive steps and a motion inside steps."""
    return [FUNCTION] if "function" in forces else series_methods()


@cache
def tangent_methods(*, forced: bool = False) -> tuple[str, ...]:
    """The methods that integrate deviation vectors, of forced bodies and by parameters."""
    known = (method for method in methods() if method.tangent)
    return tuple(method.name for method in known if not (forced and method.symplectic))


def map_methods() -> list[str]:
    """The names that a map accepts for some scene; :func:`check_method` refuses others."""
    return [AUTO, *run_methods()]


def check_method(name: str, kind: str, *, watched: bool, forces: Collection[str] = ()) -> None:
    """Raise ValueError if a method does not integrate the scene, or cannot be observed."""
    if name in (AUTO, EXACT):
        return
    _core.check_method(name, kind, watched)
    left_out = [force for force in forces if force not in method_named(name).forces]
    if left_out:
        words = forces_in_words(left_out)
        known = (method.name for method in methods() if set(forces) <= set(method.forces))
        others = ", ".join(map(repr, known))
        raise ValueError(f"method = {name!r}: does not integrate {words}; use one of {others}")
