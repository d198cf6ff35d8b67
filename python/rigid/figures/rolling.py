"""Poinsot's construction for a free body."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import free
from .._checks.arguments import brief
from ..drawing import colours
from ..drawing.axes3d import AZIM, ELEV, UP, arrow, curve, dots, fit, label
from ..drawing.shapes import across, ellipsoid_faces, plane_face
from ..drawing.sides import eye, sides, surface
from ..model.scene import FreeBody, require_unforced
from ..rotations.apply import to_space
from ..solve.run import Run, scene_of, states_of
from .picture import Picture

Floats = NDArray[np.float64]

POLHODE, HERPOLHODE = colours.HUES["blue"], colours.HUES["black"]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PoinsotPicture(Picture):
    """The inertia ellipsoid at one time of a motion, and the plane on which it rolls.

    All points (rad/s) have components along axes of space; the third axis is parallel to L.

    Attributes
    ----------
    frame : int
        Index of the time.
    t : float
        The time (s).
    semi_axes : ndarray, shape (3,)
        Semi-axes of the ellipsoid (rad/s).
    axes : ndarray, shape (3, 3)
        Unit vectors along the axes of the ellipsoid, as rows.
    distance : float
        Distance of the invariable plane from the centre (rad/s).
    polhode : ndarray, shape (m, 3)
        The curve of contact on the ellipsoid over the whole motion, in its position at the time.
    herpolhode : ndarray, shape (m, 3)
        The curve of contact in the plane.
    contact : ndarray, shape (3,)
        The point of contact at the time, which is omega.
    """

    frame: int
    t: float
    semi_axes: Floats
    axes: Floats
    distance: float
    polhode: Floats
    herpolhode: Floats
    contact: Floats

    def _draw(self, ax: Any) -> None:
        faces = ellipsoid_faces(self.semi_axes, rings=30, sectors=60) @ self.axes
        towards = eye(ELEV, AZIM)
        style: dict[str, Any] = {"alpha": 0.7, "linewidths": 0.0, "gid": "ellipsoid"}
        surface(ax, faces, colours.BODY_FACE, towards, **style)
        foot = self.distance * UP
        radius = float(np.linalg.norm(self.herpolhode - foot, axis=1).max())
        square = plane_face(foot, UP, 1.25 * max(radius, 0.3 * self.distance))
        style = {"alpha": 0.4, "zorder": 2, "linewidths": 0.0, "gid": "plane"}
        surface(ax, square, colours.FAINT, towards, **style)
        outward = self.polhode @ self.axes.T / self.semi_axes**2 @ self.axes
        near, far = sides(self.polhode, outward, towards)
        curve(ax, near, POLHODE, linewidth=1.6, zorder=3, gid="polhode")
        curve(ax, far, POLHODE, linewidth=0.8, alpha=0.5, zorder=3, gid="polhode_hidden")
        later = self.herpolhode[self.frame :]
        curve(ax, later, HERPOLHODE, linewidth=0.9, alpha=0.6, zorder=4)
        done = self.herpolhode[: self.frame + 1]
        curve(ax, done, HERPOLHODE, linewidth=1.6, zorder=4, gid="herpolhode")
        dots(ax, done[0], HERPOLHODE, markersize=4, zorder=4)
        # Inside the ellipsoid arrows are dashed: omega ends on it, L leaves it.
        inside: dict[str, Any] = {"linestyle": "dashed", "zorder": 3}
        omega, momentum = colours.OMEGA, colours.L
        arrow(ax, self.contact, omega.colour, linewidth=1.6, gid="omega", **inside)
        leaves = UP / np.linalg.norm(self.axes @ UP / self.semi_axes)
        curve(ax, np.array([0.0 * UP, leaves]), momentum.colour, linewidth=1.6, **inside)
        outside: dict[str, Any] = {"start": leaves, "zorder": 4, "gid": "momentum"}
        arrow(ax, 1.4 * foot - leaves, momentum.colour, momentum.label, **outside)
        dots(ax, self.contact, omega.colour, markersize=6, zorder=6, gid="contact")
        right = np.cross(UP, towards)
        right /= np.linalg.norm(right)
        away = 1.0 if self.contact @ right < 0.0 else -1.0
        beside = 0.6 * self.contact - 0.07 * away * self.distance * right
        label(ax, beside, omega.label, omega.colour)
        # The names stand outside the curves, the name of the herpolhode on the side without the
        # contact.
        side = float(np.sign(near[np.nanargmax(np.abs(near @ right))] @ right))
        aside = away * right + np.cross(towards, right)
        for path, towards_name, name, colour, sign in (
            (near, side * right, "polhode", POLHODE, side),
            (self.herpolhode, aside, "herpolhode", HERPOLHODE, away),
        ):
            end = path[np.nanargmax(path @ towards_name)] + 0.03 * self.distance * sign * right
            align = "left" if sign > 0.0 else "right"
            label(ax, end, name, colour, fontsize="medium", ha=align, va="bottom")
        corner = square[0, (-away * square[0] @ right).argmax()]
        corner = corner - 0.03 * self.distance * away * right
        align = "right" if away > 0.0 else "left"
        label(ax, corner, "invariable plane", colours.NEUTRAL, fontsize="medium", ha=align)
        fit(ax, faces, square, 1.5 * foot, elev=ELEV, azim=AZIM)


def poinsot(run: Run, *, frame: int = 0) -> PoinsotPicture:
    """Poinsot's construction: the inertia ellipsoid rolls on a plane that is fixed in space.

    The ellipsoid touches the plane at omega, on the momentary axis of rotation. The point of
    contact moves along the polhode on the ellipsoid and along the herpolhode in the plane (Landau
    and Lifshitz, *Mechanics*, § 37; Goldstein, *Classical Mechanics*, § 5.6; lecture notes,
    fig. 5.3). From its first point the herpolhode is bold up to the contact, and thin after it.

    Parameters
    ----------
    run : Run
        Run of a single free body, with attitudes.
    frame : int
        Index of the time to show.

    Returns
    -------
    PoinsotPicture

    Raises
    ------
    TypeError
        If the scene of the run is no free body.
    ValueError
        If attitudes are missing, the run has several bodies, the body is at rest or under torque or
        damping, or the index is out of range.

    Examples
    --------
    >>> import numpy as np, rigid
    >>> from rigid import figures
    >>> body = rigid.FreeBody(rigid.Body((1.0, 2.0, 2.5)))
    >>> run = rigid.simulate(body, [1.1, 0.3, 0.4], t=np.linspace(0.0, 20.0, 401))
    >>> data = figures.poinsot(run, frame=100)
    >>> bool(abs(data.contact[2] - data.distance) < 1e-14)
    True
    """
    scene = scene_of(run)
    if not isinstance(scene, FreeBody):
        raise TypeError(
            f"scene = {brief(scene)}: must be a rigid.FreeBody, which Poinsot's picture shows"
        )
    require_unforced(scene, "Poinsot's picture")
    omega, attitude = states_of(run)
    k = _index("frame", frame, len(omega))
    rolled = free.poinsot(scene, omega, attitude)
    assert rolled.normal is not None
    assert rolled.contact is not None
    level = np.stack(across(rolled.normal))
    return PoinsotPicture(
        frame=k % len(run.t),
        t=float(run.t[k]),
        semi_axes=rolled.semi_axes,
        axes=to_space(attitude[k], np.eye(3)) @ level.T,
        distance=float(rolled.distance),
        polhode=to_space(attitude[k], rolled.polhode) @ level.T,
        herpolhode=rolled.contact @ level.T,
        contact=rolled.contact[k] @ level.T,
    )


def _index(name: str, value: int, length: int) -> int:
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)):
        raise TypeError(f"{name} = {brief(value)}: must be a whole number")
    if not -length <= value < length:
        raise ValueError(f"{name} = {value}: the run has {length} times")
    return int(value)
