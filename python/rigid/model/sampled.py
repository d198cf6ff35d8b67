"""Values over time from tables: of a torque, of the momentum of a rotor, of a trajectory."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._checks.arguments import shaped, sorted_times
from .._checks.arrays import Floats
from .batch import Index, Shape, frozen, taken
from .frame import turned


class Sampled:
    """Vectors at the times of a table, which a force of a scene takes in place of numbers.

    Attributes
    ----------
    t : ndarray, shape (m,)
        Times (s), ascending.
    """

    __slots__ = ()

    t: Floats

    @property
    @abstractmethod
    def samples(self) -> Floats:
        """What the core reads, shape (..., m, 3)."""

    def to_dict(self) -> dict[str, Any]:
        """The table as a dict of numbers, from which its class or constructor makes it again.

        Returns
        -------
        dict
        """
        names: Sequence[str] = self.__slots__
        return {name: np.asarray(getattr(self, name)).tolist() for name in names}

    def __eq__(self, other: object) -> bool:
        return type(other) is type(self) and self.to_dict() == other.to_dict()

    def __hash__(self) -> int:
        return hash((type(self).__name__, self.samples.tobytes()))

    def __repr__(self) -> str:
        return f"{type(self).__name__}({len(self.t)} times from {self.t[0]:g} to {self.t[-1]:g})"


@dataclass(frozen=True, slots=True, init=False, eq=False, repr=False)
class RotorTable(Sampled):
    """The angular momentum of a rotor over time, linear between the times of a table.

    With the momentum ``h`` relative to the body, ``I omega' = (I omega + h) × omega - h' + …``: the
    motor of the rotor turns the body by ``-h'`` (Hughes, *Spacecraft Attitude Dynamics*, 1986,
    § 6.2). The whole momentum ``I omega + h`` changes in space by other torques alone.

    Parameters
    ----------
    t : array_like, shape (m,)
        Times (s), two or more, each after the one before.
    momentum : array_like, shape (m, 3) or (..., m, 3)
        Angular momentum (kg m²/s) in the body at these times; leading axes give each body its own.

    Attributes
    ----------
    t : ndarray, shape (m,)
    momentum : ndarray, shape (..., m, 3)

    Raises
    ------
    ValueError
        If there are fewer than two times, or two are equal; if a number is not finite; if there is
        not one momentum for each time.

    Examples
    --------
    A wheel along axis 3 takes the whole momentum of a body within 10 s:

    >>> import rigid
    >>> wheel = rigid.RotorTable([0.0, 10.0], [(0.0, 0.0, 0.0), (0.0, 0.0, 0.6)])
    >>> satellite = rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0)), rotor=wheel)
    >>> run = rigid.simulate(satellite, [0.0, 0.0, 0.2], t=[0.0, 5.0, 10.0])
    >>> (run.omega[:, 2].round(9) + 0.0).tolist()
    [0.2, 0.1, 0.0]
    """

    t: Floats
    momentum: Floats

    def __init__(self, t: ArrayLike, momentum: ArrayLike) -> None:
        times = table_times(t)
        array = shaped("momentum", momentum, len(times), 3, unit="kg m²/s")
        object.__setattr__(self, "t", times)  # the dataclass is frozen
        object.__setattr__(self, "momentum", frozen(array))

    @property
    def samples(self) -> Floats:
        """The momenta."""
        return self.momentum

    @property
    def shape(self) -> Shape:
        """The axes of the bodies: ``()`` of one rotor, ``(n,)`` of one for each of n bodies."""
        return self.momentum.shape[:-2]

    def of(self, shape: Shape, index: Index) -> Self:
        """The rotors of some of the bodies of this shape."""
        return type(self)(self.t, taken(self.momentum, 2, shape, index))

    def turned(self, axes: Floats) -> Self:
        """The rotor with other body axes."""
        return type(self)(self.t, turned(axes, self.momentum))

    def at(self, t: ArrayLike) -> Floats:
        """Momentum (kg m²/s) at times, shape (..., m, 3).

        Parameters
        ----------
        t : array_like, shape (m,) or (..., m)
            Times (s), of all bodies or of each.

        Returns
        -------
        ndarray, shape (..., m, 3)

        Raises
        ------
        ValueError
            If the table does not reach a time.

        Examples
        --------
        >>> import rigid
        >>> rigid.RotorTable([0.0, 4.0], [(0, 0, 0), (0, 0, 2)]).at([1.0])[:, 2].tolist()
        [0.5]
        """
        return linear("rotor", self.t, self.momentum, t)

    def words(self) -> str:
        """The rotor in a few words."""
        return f"rotor by a table of {len(self.t)} times"


def table_times(t: ArrayLike) -> Floats:
    """The times of a table without jumps."""
    times = sorted_times("t", t)
    if len(times) < 2 or np.any(times[1:] == times[:-1]):
        raise ValueError(f"t of {len(times)} times: must be two or more, no two of them equal")
    return frozen(times)


def reached(name: str, knots: Sequence[float] | Floats, t: ArrayLike) -> Floats:
    """Times, if a table with these knots reaches them; no knots are constant values."""
    times = np.atleast_1d(shaped("t", t))
    outside = (times < knots[0]) | (times > knots[-1]) if len(knots) else np.False_
    if np.any(outside):
        when = times[outside][0]
        raise ValueError(f"t = {when:g}: the table of the {name} does not reach this time")
    return times


def linear(name: str, knots: Sequence[float] | Floats, values: ArrayLike, t: ArrayLike) -> Floats:
    """A piecewise linear table at times that it reaches; after a jump, but for the last time."""
    times, array = reached(name, knots, t), np.array(values)
    if not len(knots):
        return np.broadcast_to(array, (*array.shape[:-2], len(times), 3)).copy()
    begins = np.array(knots)
    piece = np.clip(np.searchsorted(begins, times, side="right") - 1, 0, len(begins) - 2)
    return on_piece(begins, array, piece, times)


def on_piece(knots: Floats, values: Floats, piece: NDArray[np.intp], t: Floats) -> Floats:
    """The table at times on some of its pieces, shape (m,) or (..., m) as the times."""
    begin, end = knots[piece], knots[piece + 1]
    width = np.where(end > begin, end - begin, 1.0)
    share = ((t - begin) / width)[..., np.newaxis]
    lead = np.broadcast_shapes(values.shape[:-2], piece.shape[:-1])
    every = np.broadcast_to(values, (*lead, *values.shape[-2:]))
    at = np.broadcast_to(piece, (*lead, piece.shape[-1]))[..., np.newaxis]
    first = np.take_along_axis(every, at, axis=-2)
    line: Floats = first + share * (np.take_along_axis(every, at + 1, axis=-2) - first)
    return line
