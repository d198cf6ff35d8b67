"""Poinsot's construction for a free body, and all polhodes of one energy."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import exact, free
from .._checks.arguments import brief, positive_int
from ..drawing import colours
from ..drawing.axes3d import AZIM, ELEV, UP, arrow, curve, dots, eye, fit, label, sides, surface
from ..drawing.shapes import across, ellipsoid_faces, plane_face
from ..model.body_like import BodyLike, moments_of
from ..model.scene import FreeBody, require_unforced
from ..rotations.apply import to_space
from ..solve.run import Run, scene_of, states_of
from .picture import Picture

Floats = NDArray[np.float64]

POLHODE, HERPOLHODE = colours.HUES["blue"], colours.HUES["black"]


def _draw_poinsot(data: Picture, ax: Any) -> None:
    faces = ellipsoid_faces(data.semi_axes, rings=30, sectors=60) @ data.axes
    towards = eye(ELEV, AZIM)
    style: dict[str, Any] = {"alpha": 0.7, "linewidths": 0.0, "gid": "ellipsoid"}
    surface(ax, faces, colours.BODY_FACE, towards, **style)
    foot = data.distance * UP
    radius = float(np.linalg.norm(data.herpolhode - foot, axis=1).max())
    square = plane_face(foot, UP, 1.25 * max(radius, 0.3 * data.distance))
    style = {"alpha": 0.4, "zorder": 2, "linewidths": 0.0, "gid": "plane"}
    surface(ax, square, colours.FAINT, towards, **style)
    outward = data.polhode @ data.axes.T / data.semi_axes**2 @ data.axes
    near, far = sides(data.polhode, outward, towards)
    curve(ax, near, POLHODE, linewidth=1.6, zorder=3, gid="polhode")
    curve(ax, far, POLHODE, linewidth=0.8, alpha=0.5, zorder=3, gid="polhode_hidden")
    later = data.herpolhode[data.frame :]
    curve(ax, later, HERPOLHODE, linewidth=0.9, alpha=0.6, zorder=4)
    done = data.herpolhode[: data.frame + 1]
    curve(ax, done, HERPOLHODE, linewidth=1.6, zorder=4, gid="herpolhode")
    dots(ax, done[0], HERPOLHODE, markersize=4, zorder=4)
    # Inside the ellipsoid arrows are dashed: omega ends on it, L leaves it.
    inside: dict[str, Any] = {"linestyle": "dashed", "zorder": 3}
    omega, momentum = colours.OMEGA, colours.L
    arrow(ax, data.contact, omega.colour, linewidth=1.6, gid="omega", **inside)
    leaves = UP / np.linalg.norm(data.axes @ UP / data.semi_axes)
    curve(ax, np.array([0.0 * UP, leaves]), momentum.colour, linewidth=1.6, **inside)
    outside: dict[str, Any] = {"start": leaves, "zorder": 4, "gid": "momentum"}
    arrow(ax, 1.4 * foot - leaves, momentum.colour, momentum.label, **outside)
    dots(ax, data.contact, omega.colour, markersize=6, zorder=6, gid="contact")
    right = np.cross(UP, towards)
    right /= np.linalg.norm(right)
    away = 1.0 if data.contact @ right < 0.0 else -1.0
    beside = 0.6 * data.contact - 0.07 * away * data.distance * right
    label(ax, beside, omega.label, omega.colour)
    # The names stand outside the curves, the name of the herpolhode on the side without the
    # contact.
    side = float(np.sign(near[np.nanargmax(np.abs(near @ right))] @ right))
    aside = away * right + np.cross(towards, right)
    for path, towards_name, name, colour, sign in (
        (near, side * right, "polhode", POLHODE, side),
        (data.herpolhode, aside, "herpolhode", HERPOLHODE, away),
    ):
        end = path[np.nanargmax(path @ towards_name)] + 0.03 * data.distance * sign * right
        align = "left" if sign > 0.0 else "right"
        label(ax, end, name, colour, fontsize="medium", ha=align, va="bottom")
    corner = square[0, (-away * square[0] @ right).argmax()]
    corner = corner - 0.03 * data.distance * away * right
    align = "right" if away > 0.0 else "left"
    label(ax, corner, "invariable plane", colours.NEUTRAL, fontsize="medium", ha=align)
    fit(ax, faces, square, 1.5 * foot, elev=ELEV, azim=AZIM)


def poinsot(run: Run, *, frame: int = 0) -> Picture:
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
    Picture
        The inertia ellipsoid at one time of a motion, and the plane on which it rolls.

        All points (rad/s) have components along axes of space; the third axis is parallel to L.

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
            The curve of contact on the ellipsoid over the whole motion, in its position at the
            time.
        herpolhode : ndarray, shape (m, 3)
            The curve of contact in the plane.
        contact : ndarray, shape (3,)
            The point of contact at the time, which is omega.

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
    return Picture(
        _draw_poinsot,
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


def _draw_polhodes(data: Picture, ax: Any) -> None:
    order = np.argsort(data.moments)
    towards = np.empty(3)
    towards[order] = 0.42, 1.0, 0.4  # the middle axis points to the viewer
    towards /= np.linalg.norm(towards)
    elev = float(np.degrees(np.arcsin(towards[2])))
    azim = float(np.degrees(np.arctan2(towards[1], towards[0])))
    faces = ellipsoid_faces(data.semi_axes, rings=30, sectors=60)
    surface(ax, faces, colours.SURFACE, towards, gid="ellipsoid")
    for points, axis in zip(data.curves, data.axis, strict=True):
        colour = colours.AXES[abs(int(axis)) - 1].colour
        near, far = sides(points, data.moments * points, towards)
        curve(ax, near, colour, linewidth=1.5, zorder=4, gid="curves")
        curve(ax, far, colour, linewidth=0.7, alpha=0.35, zorder=2, gid="curves_hidden")
    black, purple = colours.HUES["black"], colours.OMEGA.colour
    for ellipse in data.separatrix:
        near, far = sides(ellipse, data.moments * ellipse, towards)
        curve(ax, near, black, linewidth=2.0, zorder=5, gid="separatrix")
        curve(ax, far, black, linewidth=0.8, alpha=0.35, zorder=2, gid="separatrix_hidden")
    if data.path is not None:
        near, far = sides(data.path, data.moments * data.path, towards)
        curve(ax, near, purple, linewidth=3.0, zorder=5.5, gid="path")
        curve(ax, far, purple, linewidth=1.5, alpha=0.5, zorder=2, gid="path_hidden")
    names = {int(order[0]): "least", int(order[1]): "middle", int(order[2]): "largest"}
    length = np.full(3, 0.3)
    length[order[1]] = 1.1  # foreshortened
    tips = np.diag(data.semi_axes + length)
    for k, ink in enumerate(colours.AXES):
        start = np.diag(data.semi_axes)[k]
        along = tips[k] - start
        arrow(ax, along, ink.colour, start=start, linewidth=1.6, zorder=6, gid="axes")
        words = f"{k + 1}: {names[k]} moment"
        sideways = float(np.cross(UP, towards)[k])
        align = "left" if sideways > 0.1 else "right" if sideways < -0.1 else "center"
        label(ax, tips[k] + 0.1 * np.eye(3)[k], words, ink.colour, fontsize="medium", ha=align)
    fit(ax, faces, 1.05 * tips, elev=elev, azim=azim, filled=0.62)


def polhodes(body: BodyLike | Run, *, count: int = 5, samples: int = 361) -> Picture:
    """The polhodes of one energy on the inertia ellipsoid, with the separatrix.

    Polhodes encircle the axes of the largest and of the smallest moment: rotations about these axes
    are stable. No polhode encircles the middle axis, and a small disturbance of a rotation about it
    grows until the body has turned over (Landau and Lifshitz, *Mechanics*, § 37, fig. 51).

    Parameters
    ----------
    body : Body, FreeBody, Run or array_like, shape (3,)
        A body with three different moments; or a run of one, without torque and damping, whose own
        polhode then is the ``path``.
    count : int
        Number of polhodes around each end of the axes of the smallest and of the largest moment.
    samples : int
        Number of points of each curve; the first and the last point coincide.

    Returns
    -------
    Picture
        Polhodes of one energy on the inertia ellipsoid.

        moments : ndarray, shape (3,)
            Moments of the body (kg m²).
        semi_axes : ndarray, shape (3,)
            Semi-axes of the ellipsoid ``omega·I omega = 2 E`` (rad/s).
        curves : ndarray, shape (4 n, m, 3)
            Closed polhodes (rad/s).
        axis : ndarray of int8, shape (4 n,)
            The axis 1, 2 or 3 that each polhode encircles, with the sign of the rate about this
            axis.
        separatrix : ndarray, shape (2, m, 3)
            The two ellipses through the ends of the middle axis, which separate the polhodes.
        path : ndarray, shape (k, 3), or None
            The path of a run on the same ellipsoid.

        The energy is such that the largest semi-axis is 1 rad/s.

    Raises
    ------
    ValueError
        If no body has the moments, or two of them are equal; if a run has several bodies, is at
        rest or under torque or damping.

    Examples
    --------
    >>> from rigid import figures
    >>> data = figures.polhodes((1.0, 2.0, 3.0))
    >>> data.curves.shape, sorted(set(data.axis.tolist()))
    ((20, 361, 3), [-3, -1, 1, 3])
    """
    path = None
    if isinstance(body, Run):
        path, body = _path_of(body)
    moments = moments_of(body)
    if moments.shape != (3,) or len(set(moments.tolist())) < 3:
        raise ValueError(
            f"moments = {moments.tolist()}: polhodes of both kinds need three different moments"
        )
    number = positive_int("count", count)
    points = positive_int("samples", samples, minimum=2)
    small, middle, large = order = np.argsort(moments)
    semi = np.sqrt(moments[small] / moments)
    # Start on the ellipse in the plane of the first and the third axis, where the angle between
    # the separatrix and the axis of the smallest moment is known.
    i1, i2, i3 = moments[order]
    slope = np.sqrt(i1 * (i2 - i1) / (i3 * (i3 - i2)))
    parting = np.arctan2(slope * semi[small], semi[large])
    share = np.arange(1, number + 1) / (number + 1.0)
    angle = np.concatenate([share * parting, parting + share * (0.5 * np.pi - parting)])
    starts = np.zeros((2 * number, 3))
    starts[:, small], starts[:, large] = semi[small] * np.cos(angle), semi[large] * np.sin(angle)
    known = free.asymmetric_free_top(moments, starts)
    turn = np.linspace(0.0, 1.0, points)
    quarter = 0.5 * np.pi / exact.agm(1.0, np.sqrt(known.mc))
    sn, cn, dn = exact.jacobi(4.0 * quarter[:, np.newaxis] * turn, known.mc[:, np.newaxis])
    around_small = (np.abs(known.axis) == small + 1)[:, np.newaxis]
    curves = np.empty((2 * number, points, 3))
    curves[..., small] = np.where(around_small, dn, cn)
    curves[..., middle] = sn
    curves[..., large] = np.where(around_small, cn, dn)
    curves *= known.amplitude[:, np.newaxis, :]
    phase = 2.0 * np.pi * turn
    separatrix = np.empty((2, points, 3))
    for side, ellipse in zip((1.0, -1.0), separatrix, strict=True):
        ellipse[:, small] = semi[small] * np.cos(parting) * np.cos(phase)
        ellipse[:, large] = side * semi[large] * np.sin(parting) * np.cos(phase)
        ellipse[:, middle] = semi[middle] * np.sin(phase)
    return Picture(
        _draw_polhodes,
        moments=moments,
        semi_axes=semi,
        curves=np.concatenate([curves, -curves]),
        axis=np.concatenate([known.axis, -known.axis]),
        separatrix=separatrix,
        path=path,
    )


def _path_of(run: Run) -> tuple[Floats, FreeBody]:
    """The rates of a run on the ellipsoid whose largest semi-axis is 1 rad/s, and its scene."""
    scene = scene_of(run)
    if not isinstance(scene, FreeBody):
        raise TypeError(
            f"scene = {brief(scene)}: must be a rigid.FreeBody, whose rates follow polhodes"
        )
    require_unforced(scene, "a polhode")
    (omega,) = states_of(run, names=["omega"])
    moments = np.array(scene.body.moments)
    size = np.sqrt((omega[0] ** 2 * moments).sum() / moments.min())
    if size == 0.0:
        raise ValueError("omega = [0, 0, 0]: a body at rest has no polhode")
    return omega / size, scene
