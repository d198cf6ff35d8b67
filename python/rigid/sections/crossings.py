"""The points of a Poincaré section, and how complete they are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._checks.arguments import one_of
from .._checks.arrays import Floats
from ..drawing.colours import CLASSES, HUES, on_ground
from ..drawing.figure import axes_to_draw_on, html_with_picture, name_classes
from ..model.batch import Shape
from ..model.events import COMPONENTS
from ..model.orbit import Orbit
from ..rotations import quaternion_to_matrix
from ..solve.columns import Column, Columns, Result
from ..solve.events import Points
from ..solve.plan import Plan
from ..solve.status import Status, sentences
from .surface import Section

if TYPE_CHECKING:
    from matplotlib.axes import Axes


LABELS = {
    **{f"omega{i}": rf"$\omega_{i}$ (rad/s)" for i in (1, 2, 3)},
    **{f"gamma{i}": rf"$\gamma_{i}$" for i in (1, 2, 3)},
    **{f"angle{i}": rf"$\theta_{i}$ (rad)" for i in (1, 2, 3)},
    "t": "$t$ (s)",
}

_FAILED = {
    Status.STEP_LIMIT: "step limit: it needs more than max_steps steps",
    Status.NOT_FINITE: "not finite: a number overflowed",
    Status.DRIFTED: "drifted: energy or momentum is off; take a smaller tolerance",
}


@dataclass(frozen=True, repr=False, eq=False)
class Crossings(Points, Result):
    """The points of a Poincaré section, from :func:`poincare`: body after body, in order of time.

    With a single body the axis ``n`` of bodies is absent.

    Attributes
    ----------
    t : ndarray, shape (p,)
        Times (s), positive: a start on the surface is no point.
    omega, gamma : ndarray, shape (p, 3)
        Rates (rad/s) and the vertical, in the body.
    attitude : ndarray, shape (p, 4)
        Unit quaternions with a positive scalar, body to space.
    direction : ndarray of int8, shape (p,)
        1 where the motion rises through the surface, -1 where it falls, 0 where it touches it.
    slope : ndarray, shape (p,)
        Rate of the function that is zero on the surface. For ``"height"`` it is the second
        derivative of the height of the centre of mass (1/s²), in units of the distance of the
        centre of mass from the fixed point. 1 at equal times.
    body : ndarray of int, shape (p,)
        Index of the body, in the flat order of all.
    grazing : ndarray of bool, shape (p,)
        Points at which the motion turns so near the surface, within 1e-12 of the scale of its
        rates, that rounding may decide whether it crosses. They are kept whatever their direction.
    error : ndarray, shape (p,)
        Estimated error of ``t`` (s). A second run, with a method of another order, gives another
        value on the surface: three times the largest value until then, plus rounding, over the
        slope. So it is large or infinite at a grazing point, where the slope is about zero. For
        states at equal times the error of the states as in :attr:`Run.error`, the largest of the
        body. NaN without the second run.
    complete : ndarray of bool, shape (n,)
        Whether every crossing until ``end`` is among the points and no other: the body was run, no
        point grazes, and the motion is not on the surface all along.
    end : ndarray, shape (n,)
        Time until which the points of each body are known (s): ``t_end``, or the time of its last
        point if it has the requested number of points.
    lost_from : ndarray, shape (n,)
        Time from which on the points are lost to rounding: they belong to a motion of another start
        nearby. Infinite if there is none, NaN without a second run.
    energy_drift : ndarray, shape (n,)
        Largest relative error of the energy at the points and at the end.
    status : ndarray of uint8, shape (n,)
        A :class:`Status` for each body.
    stays : ndarray of bool, shape (n,)
        Whether a motion stays on the surface, as a steady precession does at its height.
    steps : ndarray of uint64, shape (n,)
        Steps taken.
    section : Section
        The surface, or the equal times.
    plan : Plan
        The method and the reasons.
    orbit : Orbit or None
        The orbit of the bodies, if there is one.
    spec : dict
        Scene, method, tolerance, section, end and count, as a dict.

    Notes
    -----
    In a Dataset and in a table points are rows, and ``body`` is the index of the body of each. The
    Dataset has the axis ``point``; arrays with a row for each body, such as ``complete``, have the
    axis ``motion``, in the flat order of all bodies.
    """

    _columns: Columns
    _shape: Shape
    section: Section
    plan: Plan
    orbit: Orbit | None
    spec: dict[str, Any]

    end = Column[Floats]("s", "motion")
    energy_drift = Column[Floats]("1", "motion")
    status = Column[NDArray[np.uint8]]("", "motion")
    stays = Column[NDArray[np.bool_]]("", "motion")
    steps = Column[NDArray[np.uint64]]("1", "motion")

    _ROWS = ("point",)

    def __repr__(self) -> str:
        each, whole = self._completeness()
        return f"<Crossings: {len(self)} points of {each}, {self.section.words()}; {whole}>"

    def _repr_html_(self) -> str:
        return html_with_picture(lambda ax: self.plot(ax=ax), repr(self))

    def component(self, name: str) -> Floats:
        """A column of all points by its name, such as ``"omega1"``; shape (p,).

        Parameters
        ----------
        name : str
            ``"omega1"`` to ``"omega3"``, ``"gamma1"`` to ``"gamma3"``, ``"t"``; or ``"angle1"`` to
            ``"angle3"``: the angle (rad, from -pi to pi) of a body axis about the normal of the
            orbit from the direction away from the planet, which is its libration. Without an orbit
            the angle about z of space from x.

        Returns
        -------
        ndarray, shape (p,)

        Raises
        ------
        ValueError
            If the name is unknown; the message has the known names.

        Examples
        --------
        >>> import rigid
        >>> moon = rigid.FreeBody(rigid.Body((1.0, 1.2, 1.4)), orbit=rigid.Orbit(1.0, 0.05))
        >>> each = rigid.poincare(moon, [0.0, 0.0, 1.01], every=moon.orbit.period, t_end=20.0)
        >>> each.component("angle1").round(3).tolist()
        [-0.088, 0.109, -0.048]
        """
        one_of("name", name, LABELS)
        if name == "t":
            return self.t
        if name.startswith("angle"):
            return self._angle(int(name[-1]) - 1)
        return (self.omega, self.gamma)[COMPONENTS.index(name) // 3][:, COMPONENTS.index(name) % 3]

    def _angle(self, axis: int) -> Floats:
        pointing = quaternion_to_matrix(self.attitude)[..., axis]
        frame = np.broadcast_to(np.eye(3), (len(self), 3, 3))
        if self.orbit is not None:
            numbers = np.broadcast_to(self.orbit.numbers, (*np.shape(self.complete), 9))
            each = Orbit.of_numbers(numbers.reshape(-1, 9)[self.body])
            frame = each.frame(self.t[:, np.newaxis])[:, 0]
        x, y = (np.sum(pointing * frame[..., k], axis=-1) for k in (0, 1))
        return np.asarray(np.arctan2(y, x))

    def reasons(self) -> tuple[Any, ...]:
        """A sentence for each body that says how complete its points are.

        With several leading axes the sentences are tuples of tuples.

        Returns
        -------
        tuple of str

        Examples
        --------
        >>> import rigid
        >>> top = rigid.HeavyTop(rigid.Body((1.0, 1.6, 0.7)), mgl=1.2, com=(0.6, 0.0, 0.8))
        >>> points = rigid.poincare(top, [0.3, 0.4, 1.0], [0.9, 0.3, 0.2, 0.1], t_end=30.0)
        >>> points.reasons()
        ('complete: 8 points until t = 30 s',)
        """
        shape, bodies = np.shape(self.complete), np.size(self.complete)
        counts, grazing = (
            np.bincount(body, minlength=bodies).reshape(shape)
            for body in (self.body, self.body[self.grazing])
        )
        columns = (self.stays, self.status, self.end, self.lost_from)
        return sentences(self._words, counts, grazing, *columns)

    def _words(
        self,
        count: int,
        grazing: int,
        stays: bool,
        status: int,
        end: float,
        lost: float,
    ) -> str:
        until = f"{count} points until t = {end:.6g} s"
        if status in _FAILED:
            return f"{_FAILED[Status(status)]}; {until}"
        if stays:
            return f"not complete: the motion stays on the surface; {until}"
        if grazing:
            return f"not complete: at {grazing} of {until} it grazes the surface"
        words = f"complete: {until}"
        if np.isfinite(lost):
            words += f"; from t = {lost:.4g} s on the points belong to a motion close by"
        return words

    def plot(
        self,
        x: str = "gamma1",
        y: str = "omega2",
        *,
        ax: Axes | None = None,
        size: float = 1.5,
        by: ArrayLike | None = None,
    ) -> Axes:
        """Draw the points, each body in a colour, or in the colour of its class.

        Parameters
        ----------
        x, y : str
            Columns, as in :meth:`component`; of a moon at its periapsis ``"angle1"``, ``"omega3"``.
        ax : matplotlib Axes, optional
            By default the axes of a new figure.
        size : float
            Diameter of a point (points).
        by : array_like of str, optional
            A word for each body, such as the ``verdict`` of :func:`rigid.lyapunov`: bodies with the
            same word have one colour, which a legend names. By default the colours only tell
            neighbouring bodies apart.

        Returns
        -------
        matplotlib Axes

        Raises
        ------
        ImportError
            Without matplotlib.
        ValueError
            If ``by`` has not one word for each body.

        Examples
        --------
        >>> import rigid
        >>> top = rigid.HeavyTop(rigid.Body((4.0, 4.0, 1.0)), mgl=1.0, com=(1.0, 0.0, 0.0))
        >>> start = rigid.top.on_surface(top, 1.5, 1.5, count=8, rng=2026)
        >>> points = rigid.poincare(top, *start, t_end=1e3, count=50)
        >>> verdict = rigid.lyapunov(top, *start, t=[500.0, 1000.0], check=False).verdict
        >>> ax = points.plot("gamma2", "omega3", by=verdict)
        >>> [text.get_text() for text in ax.get_legend().get_texts()]
        ['chaotic', 'regular']
        """
        across, up = self.component(x), self.component(y)
        bodies = np.size(self.complete)
        words = None if by is None else np.ravel(np.asarray(by, dtype=np.str_)).tolist()
        if words is not None and len(words) != bodies:
            raise ValueError(f"by: needs a word for each of {bodies} bodies, got {len(words)}")
        ax = axes_to_draw_on(ax)
        order = np.arange(len(self.body))
        if words is None:
            cycle = [on_ground(ax, colour) for name, colour in HUES.items() if name != "black"]
            inks = [cycle[k % len(cycle)] for k in range(bodies)]
        else:
            of_word = _class_colours(ax, words)
            inks = [of_word[word] for word in words]
            rank = np.array([list(of_word).index(word) for word in words])
            order = np.argsort(rank[self.body], kind="stable")
            name_classes(ax, of_word)
        of_point = np.array(inks)[self.body[order]]
        ax.scatter(across[order], up[order], s=size**2, c=of_point, linewidths=0.0)
        ax.set(xlabel=LABELS[x], ylabel=LABELS[y])
        return ax


def _class_colours(ax: Axes, words: Sequence[str]) -> dict[str, str]:
    """The colour of each class on these axes, those first whose points others may cover."""
    spare = [colour for colour in HUES.values() if colour not in CLASSES.values()]
    known = [word for word in CLASSES if word in words]
    others = sorted(set(words) - set(known))
    inks = [CLASSES[word] for word in known]
    inks += [spare[k % len(spare)] for k in range(len(others))]
    return {word: on_ground(ax, ink) for word, ink in zip([*known, *others], inks, strict=True)}
