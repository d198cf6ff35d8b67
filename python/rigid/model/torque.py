"""Forcing: applied torques and damping of a body, without its weight."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _core
from .._checks.arguments import numbers, shaped, sorted_times

__all__ = ["Damping", "Torque", "checked_damping", "checked_torque", "damping_words", "forcing_of"]

Floats = NDArray[np.float64]
Vector: TypeAlias = tuple[float, float, float]
Damping: TypeAlias = tuple[Vector, Vector, Vector]

_ZERO = (0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class Torque:
    """A torque in the body or in space, constant or a table over time.

    Made by :meth:`body` and :meth:`space`; torques add. Between the times of a table the torque is
    linear. Two values at one time are a jump. The torque is unknown outside the times of the table,
    so a run beyond them raises ValueError; if the torque ends, end the table with zeros.

    Attributes
    ----------
    times : tuple of float
        Times (s) of the table, ascending; empty if the torque is constant.
    in_body, in_space : tuple of (float, float, float)
        Torque (N m) in the body and in space at these times, or always.

    Examples
    --------
    >>> import rigid
    >>> motor = rigid.Torque.body([(0, 0, 2), (0, 0, 2), (0, 0, 0), (0, 0, 0)], times=[0, 5, 5, 60])
    >>> len((motor + rigid.Torque.space((0.1, 0.0, 0.0))).times)
    4
    """

    times: tuple[float, ...]
    in_body: tuple[Vector, ...]
    in_space: tuple[Vector, ...]

    @classmethod
    def body(cls, values: ArrayLike, *, times: ArrayLike | None = None) -> Torque:
        """A torque with these components along the axes of the body.

        Parameters
        ----------
        values : array_like, shape (3,), or (m, 3) with ``times``
            Torque (N m).
        times : array_like, shape (m,), optional
            Times (s) of the table, ascending, at least two; equal neighbours are a jump.

        Raises
        ------
        ValueError
            If the shapes do not fit, a number is not finite, or the times are not ascending.
        """
        return cls._made(values, times, 0)

    @classmethod
    def space(cls, values: ArrayLike, *, times: ArrayLike | None = None) -> Torque:
        """A torque with these components along the axes of space; arguments as in :meth:`body`."""
        return cls._made(values, times, 1)

    @classmethod
    def _made(cls, values: ArrayLike, times: ArrayLike | None, frame: int) -> Torque:
        array = shaped("torque", values)
        if times is None:
            knots = np.empty(0)
            wanted: tuple[int, ...] = (3,)
        else:
            knots = sorted_times("torque times", times)
            if len(knots) < 2:
                raise ValueError(f"torque times = {knots.tolist()}: a table has at least two times")
            wanted = (len(knots), 3)
        if array.shape != wanted:
            hint = "; give the times of a table" if times is None and array.ndim == 2 else ""
            raise ValueError(f"torque: expected shape {wanted}, got {array.shape}{hint}")
        acting = array.reshape(-1, 3)
        parts = [acting, np.zeros_like(acting)]
        made = cls(tuple(knots.tolist()), _vectors(parts[frame]), _vectors(parts[1 - frame]))
        made._forcing(None, 0)
        return made

    def __add__(self, other: Torque) -> Torque:
        """Both torques together, over the times that both tables reach."""
        if not isinstance(other, Torque):
            return NotImplemented
        knots = _common_knots(self.times, other.times)
        parts = [
            [_at(torque.times, values, knots) for values in (torque.in_body, torque.in_space)]
            for torque in (self, other)
        ]
        body, space = (_vectors(parts[0][frame] + parts[1][frame]) for frame in (0, 1))
        return Torque(tuple(knots.tolist()), body, space)

    @property
    def acts_in_space(self) -> bool:
        """Whether it has a part that is fixed in space: the rates then need the attitude."""
        return any(part != 0.0 for value in self.in_space for part in value)

    def at(self, t: ArrayLike) -> tuple[Floats, Floats]:
        """Torque in the body and in space at times ``t`` (m,), shapes (m, 3); after a jump.

        Raises
        ------
        ValueError
            If the table does not reach a time.
        """
        times = np.atleast_1d(shaped("t", t))
        if self.times:
            outside = (times < self.times[0]) | (times > self.times[-1])
            if outside.any():
                raise ValueError(
                    f"t = {times[outside][0]:g}: the table of the torque does not reach this time"
                )
        body, space = (_linear(self.times, part, times) for part in (self.in_body, self.in_space))
        return body, space

    def words(self) -> str:
        """The torque in a few words."""
        frames = [
            (name, values)
            for name, values in (("body", self.in_body), ("space", self.in_space))
            if any(part != 0.0 for value in values for part in value)
        ]
        if not frames:
            return "torque zero"
        if self.times:
            places = " and ".join(name for name, _ in frames)
            return f"torque in the {places} by a table of {len(self.times)} times".replace(
                "the space", "space"
            )
        return ", ".join(
            f"torque ({', '.join(f'{part:g}' for part in values[0])}) in "
            f"{'the body' if name == 'body' else 'space'}"
            for name, values in frames
        )

    def to_dict(self) -> dict[str, Any]:
        """The torque as a dict of numbers."""
        return {
            "times": list(self.times),
            "in_body": [list(value) for value in self.in_body],
            "in_space": [list(value) for value in self.in_space],
        }

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Torque:
        """The torque of :meth:`to_dict`."""
        times = data["times"] or None
        parts = []
        for make, values in ((cls.body, data["in_body"]), (cls.space, data["in_space"])):
            parts.append(make(values if times else values[0], times=times))
        return cls(parts[0].times, parts[0].in_body, parts[1].in_space)

    @np.errstate(over="ignore")
    def _forcing(self, damping: Damping | None, scale_exponent: int) -> _core.Forcing:
        d = damping or (_ZERO, _ZERO, _ZERO)
        entries = np.array([d[0][0], d[1][1], d[2][2], d[1][2], d[0][2], d[0][1]])
        scaled = [
            np.ldexp(np.array(x), -scale_exponent) for x in (self.in_body, self.in_space, entries)
        ]
        for name, array in (("torque", scaled[:2]), ("damping", scaled[2:])):
            if not all(np.isfinite(part).all() for part in array):
                raise ValueError(f"{name}: must be below 1e308 times the largest moment")
        return _core.Forcing(
            times=np.array(self.times, dtype=np.float64),
            body=scaled[0],
            space=scaled[1],
            damping=scaled[2].tolist(),
        )


def checked_torque(torque: object) -> Torque | None:
    """``torque`` if it is one; None if there is none."""
    if torque is None or isinstance(torque, Torque):
        return torque
    raise TypeError(
        f"torque = {torque!r}: must be a rigid.Torque: rigid.Torque.body((N1, N2, N3)) or "
        "rigid.Torque.space((N1, N2, N3))"
    )


def checked_damping(damping: ArrayLike | None) -> Damping | None:
    """The matrix of a damping given by one coefficient, three, or a matrix; None if there is none.

    Raises
    ------
    ValueError
        If it has another shape, is not finite, not symmetric, or would add energy.
    """
    if damping is None:
        return None
    array = numbers("damping", damping)
    if array.shape not in ((), (3,), (3, 3)):
        raise ValueError(f"damping: expected shape (), (3,) or (3, 3), got {array.shape}")
    if not np.isfinite(array).all():
        raise ValueError(f"damping = {array.tolist()}: must be finite")
    if array.ndim < 2:
        if np.any(array < 0.0):
            raise ValueError(f"damping = {array.tolist()}: must not be negative")
        array = np.diag(np.broadcast_to(array, 3))
    size = np.abs(array).max()
    if np.any(np.abs(array - array.T) > 1e-12 * size):
        raise ValueError(f"damping = {array.tolist()}: must be a symmetric matrix")
    if not size:
        return None
    # As a difference: the sum of two huge entries could overflow.
    first, second, third = _vectors(array + 0.5 * (array.T - array))
    forcing_of(None, (first, second, third))
    return first, second, third


def damping_words(damping: Damping) -> str:
    """The damping in a few words."""
    matrix = np.array(damping)
    diagonal = np.diag(matrix)
    if np.any(matrix - np.diag(diagonal)):
        rows = ", ".join(f"({', '.join(f'{part:g}' for part in row)})" for row in damping)
        return f"damping ({rows})"
    if np.all(diagonal == diagonal[0]):
        return f"damping {diagonal[0]:g}"
    return f"damping ({', '.join(f'{part:g}' for part in diagonal)})"


def forcing_of(
    torque: Torque | None, damping: Damping | None, scale_exponent: int = 0
) -> _core.Forcing | None:
    """Torque and damping as the core reads them; None if nothing acts.

    They are counted in units of ``2**scale_exponent``.

    Raises
    ------
    ValueError
        If they are too large for the unit.
    """
    if torque is None and damping is None:
        return None
    return (torque or Torque((), (_ZERO,), (_ZERO,)))._forcing(damping, scale_exponent)


def _vectors(array: Floats) -> tuple[Vector, ...]:
    return tuple((float(a), float(b), float(c)) for a, b, c in array)


def _common_knots(first: tuple[float, ...], second: tuple[float, ...]) -> Floats:
    """The times of both tables, as far as both reach; jumps stay."""
    if not first or not second:
        return np.array(first or second)
    begin, end = max(first[0], second[0]), min(first[-1], second[-1])
    if not begin < end:
        raise ValueError(
            f"torque times: the tables have no time in common: [{first[0]:g}, {first[-1]:g}] and "
            f"[{second[0]:g}, {second[-1]:g}]"
        )
    every = sorted({knot for knot in (*first, *second) if begin <= knot <= end})
    jumps = {knot for times in (first, second) for knot in every if times.count(knot) > 1} - {
        begin,
        end,
    }
    return np.array([knot for knot in every for _ in range(2 if knot in jumps else 1)])


def _linear(times: Sequence[float], values: Sequence[Vector], t: Floats) -> Floats:
    """A piecewise linear table at times inside it; after a jump, but for the last time."""
    array = np.array(values)
    if not times:
        return np.broadcast_to(array, (len(t), 3)).copy()
    knots = np.array(times)
    piece = np.clip(np.searchsorted(knots, t, side="right") - 1, 0, len(knots) - 2)
    return _on_piece(knots, array, piece, t)


def _on_piece(knots: Floats, values: Floats, piece: NDArray[np.intp], t: Floats) -> Floats:
    begin, end = knots[piece], knots[piece + 1]
    width = np.where(end > begin, end - begin, 1.0)
    share = ((t - begin) / width)[:, None]
    line: Floats = values[piece] + share * (values[piece + 1] - values[piece])
    return line


def _at(times: Sequence[float], values: Sequence[Vector], knots: Floats) -> Floats:
    """A table at the knots of a finer one: before a jump and after it, where there is one."""
    if not len(knots) or not times:
        return np.broadcast_to(np.array(values), (max(len(knots), 1), 3)).copy()
    own, array = np.array(times), np.array(values)
    before = np.zeros(len(knots), dtype=bool)
    before[:-1] = knots[:-1] == knots[1:]
    before[-1] = True
    after = np.searchsorted(own, knots, side="right") - 1
    left = np.searchsorted(own, knots, side="left") - 1
    piece = np.clip(np.where(before, left, after), 0, len(own) - 2)
    return _on_piece(own, array, piece, knots)
