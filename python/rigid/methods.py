"""The methods and what they promise."""

from __future__ import annotations

from dataclasses import dataclass

from . import _core

__all__ = ["Method", "methods"]


@dataclass(frozen=True, slots=True)
class Method:
    """What a method promises, and who found it.

    Attributes
    ----------
    name : str
        The name to ask for.
    title : str
        One line.
    order : int
        The error of a run falls as ``step**order``.
    stages : int
        Evaluations of the equations of motion, or exact partial flows, a step.
    symplectic, reversible, group_preserving : bool
        Preserves the Poisson structure; a step forward and one back is the identity; ``|L|`` of the
        free body, ``|gamma|`` and ``|q|`` stay as they are, up to rounding.
    citation, doi : str
        Where it comes from.
    """

    name: str
    title: str
    order: int
    stages: int
    symplectic: bool
    reversible: bool
    group_preserving: bool
    citation: str
    doi: str


def methods() -> tuple[Method, ...]:
    """All methods.

    Examples
    --------
    >>> import rigid
    >>> [(method.name, method.order) for method in rigid.methods()]
    [('rk4', 4), ('splitting', 2)]
    """
    return tuple(Method(**facts) for facts in _core.methods())


def method_names() -> list[str]:
    """The names of all methods."""
    return [method.name for method in methods()]
