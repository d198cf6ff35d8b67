"""Surfaces of section: the function that is zero on each, and the direction of the crossings."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from .._checks.arguments import brief, finite_float, one_of, vector
from .._checks.arrays import Floats
from ..model.batch import three
from ..model.events import COMPONENTS, PLANE, WORDS, Event, check_reached, checked_direction
from ..model.scene import HeavyTop, Scene

HEIGHT = "height"
"""The section where the height of the centre of mass turns."""

EQUAL_TIMES = "every"
"""The section of equal times, which has no surface."""


@dataclass(frozen=True, slots=True)
class Section:
    """A surface of section, made by :func:`section`.

    Attributes
    ----------
    name : str
        ``"height"``, a component, ``"plane"`` for one of vectors, or ``"every"`` for equal times.
    omega, gamma : tuple of float
        Its normal: ``omega·w + gamma·n - value`` is zero on it, for the rates ``w`` and the
        vertical ``n`` in the body. Both zero for ``"height"``.
    value : float
        Of equal times the time between two of them (s).
    direction : int
        1 for rising crossings, -1 for falling ones, 0 for both.
    """

    name: str
    omega: tuple[float, float, float]
    gamma: tuple[float, float, float]
    value: float
    direction: int

    @property
    def is_height(self) -> bool:
        """Whether the surface follows from the centre of mass of the body."""
        return self.name == HEIGHT

    def words(self) -> str:
        """The surface in words.

        Returns
        -------
        str

        Examples
        --------
        >>> import rigid
        >>> rigid.section("omega2", direction=1).words()
        'omega2 = 0, rising'
        """
        if self.is_height:
            turn = {-1: "highest", 1: "lowest", 0: "highest or lowest"}[self.direction]
            return f"centre of mass {turn}"
        if self.name == EQUAL_TIMES:
            return f"every {self.value:.6g} s"
        if self.name in COMPONENTS:
            return f"{self.name} = {self.value:g}, {WORDS[self.direction]}"
        return f"{self.omega}·omega + {self.gamma}·gamma = {self.value:g}, {WORDS[self.direction]}"

    def event(self) -> Event:
        """The crossings as events: of the height the turns of a plane that each body has."""
        return Event(
            name=PLANE,
            omega=self.omega,
            gamma=self.gamma,
            momentum=(0.0, 0.0, 0.0),
            value=self.value,
            direction=self.direction,
            turns=self.is_height,
        )

    def normals(self, scene: Scene, weight: Floats) -> Floats:
        """The normals of the surface for bodies with these weights (n, 3).

        Raises
        ------
        ValueError
            For ``"height"`` of a body without weight.
        """
        if not self.is_height:
            rows = np.array([[*self.omega, *self.gamma]])
            return np.repeat(rows, len(weight), axis=0)
        # By a power of two, so that no square leaves the range of doubles.
        largest = np.abs(weight).max(axis=1, keepdims=True, initial=0.0)
        weight = np.ldexp(weight, -np.frexp(largest)[1])
        length = np.linalg.norm(weight, axis=1, keepdims=True)
        if not isinstance(scene, HeavyTop) or not (length > 0.0).all():
            raise ValueError(
                "section = 'height': a body without weight has no height that turns; name a "
                "component, such as 'gamma3'"
            )
        return np.concatenate([np.zeros_like(weight), weight / length], axis=1)

    def to_dict(self) -> dict[str, Any]:
        """Name, normal, value and direction as plain Python values.

        Returns
        -------
        dict
        """
        return {name: list(v) if isinstance(v, tuple) else v for name, v in asdict(self).items()}


def at_equal_times(every: float) -> Section:
    """The section of the times that are multiples of ``every`` (s)."""
    return Section(EQUAL_TIMES, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), every, 1)


def section(
    name: str | None = None,
    value: float = 0.0,
    direction: int | None = None,
    *,
    omega: ArrayLike | None = None,
    gamma: ArrayLike | None = None,
) -> Section:
    """A surface of section for :func:`poincare`, by name or by vectors.

    Parameters
    ----------
    name : str, optional
        ``"height"``: the height of the centre of mass turns, ``w·(gamma × omega) = 0`` for the
        weight ``w``. It is the rate of a bounded quantity, so that every motion that comes back
        crosses it. Or a component: ``"omega1"`` to ``"omega3"``, ``"gamma1"`` to ``"gamma3"``.
        Default: ``"height"`` without vectors.
    value : float
        The value of the component, or of ``omega·w + gamma·n``.
    direction : {1, -1, 0}, optional
        Rising or falling crossings, or both. Default: falling for ``"height"``, so its highest
        positions, else rising.
    omega, gamma : array_like, shape (3,), optional
        Instead of a name: the vectors of ``omega·w + gamma·n - value``, for the rates ``w`` and
        the vertical ``n`` in the body.

    Returns
    -------
    Section

    Raises
    ------
    ValueError
        Naming the argument, its value and the rule: an unknown name, a name beside vectors, vectors
        that are both zero, another direction, a value for ``"height"``, a value that the vertical
        never has.

    Examples
    --------
    >>> import rigid
    >>> rigid.section("omega3", value=1.5).words()
    'omega3 = 1.5, rising'
    >>> rigid.section(gamma=(1.0, 1.0, 0.0), direction=0).words()
    '(0.0, 0.0, 0.0)·omega + (1.0, 1.0, 0.0)·gamma = 0, both ways'
    """
    value = finite_float("value", value)
    if omega is not None or gamma is not None:
        if name is not None:
            raise ValueError(f"name = {brief(name)}: leave the name out beside omega or gamma")
        of_omega = np.zeros(3) if omega is None else vector("omega", omega, 3)
        of_gamma = np.zeros(3) if gamma is None else vector("gamma", gamma, 3)
        if not (of_omega.any() or of_gamma.any()):
            raise ValueError("omega, gamma: both are zero, so they are no normal of a surface")
        name = "plane"
    else:
        name = one_of("name", HEIGHT if name is None else name, (HEIGHT, *COMPONENTS))
        of_omega, of_gamma = np.zeros(3), np.zeros(3)
        if name == HEIGHT and value != 0.0:
            raise ValueError(f"value = {value}: omit the value of 'height', whose rate is zero")
        if name != HEIGHT:
            of_each = np.eye(6)[COMPONENTS.index(name)]
            of_omega, of_gamma = of_each[:3], of_each[3:]
    if direction is None:
        direction = -1 if name == HEIGHT else 1
    towards = checked_direction(direction)
    if name != HEIGHT and not of_omega.any():
        check_reached(value, of_gamma, touching=True)
    return Section(
        name=name,
        omega=three(of_omega),
        gamma=three(of_gamma),
        value=value,
        direction=towards,
    )


def checked_section(given: Section | str | None) -> Section:
    """The section of an argument: one that is made, by its name, or the default."""
    if given is None or isinstance(given, str):
        return section(given)
    if not isinstance(given, Section):
        raise TypeError(
            f"section = {brief(given)}: must be made by rigid.section, or a name, or None"
        )
    return given
