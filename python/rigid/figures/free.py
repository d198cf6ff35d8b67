"""Figures of free bodies: the box, Poinsot's construction, polhodes, and the symmetric top."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from .. import exact, free
from .._checks.arguments import brief, finite_float, positive_int, vector, whole
from .._checks.arrays import Floats
from ..drawing import axes3d as draw
from ..drawing import colours
from ..drawing.shapes import across, box_faces, ellipsoid_faces, plane_face
from ..free import cones as cones_of
from ..free import permanent_rotation, symmetric_free_top
from ..model.body import Body, check_body
from ..model.body_like import BodyLike, moments_of
from ..model.scene import FreeBody, require_unforced
from ..rotations.apply import to_space
from ..rotations.quaternions import matrix_to_quaternion, quaternion_to_matrix
from ..rotations.so3 import rotate
from ..solve.run import Run, scene_of, states_of
from .picture import Picture

POLHODE, HERPOLHODE = colours.HUES["blue"], colours.HUES["black"]

_OUTER_EDGES = np.array([[0.0, 1.0, -1.0], [1.0, 0.0, -1.0], [-1.0, 1.0, 0.0]])
"""For each axis, the direction of its parallel edge at the outline of the visible faces."""


_AWAY = np.array([[0.0, 0.0, -1.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
"""For each axis, direction from that edge to its dimension line, in the plane of a visible face."""


def _draw_box(data: Picture, ax: Any) -> None:
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    behind = -0.5 * data.sides  # the corner that nobody sees from the viewer's direction
    faces = box_faces(0.5 * data.sides)
    ax.add_collection3d(
        Poly3DCollection(faces, facecolor=colours.FACE, alpha=0.12, linewidth=0.0, zorder=1)
    )
    for ends in data.corners[data.edges]:
        hidden = (ends == behind).all(axis=-1).any()
        colour, width, dash = (
            (colours.FAINT, 1.0, "dashed") if hidden else (colours.NEUTRAL, 1.5, "solid")
        )
        draw.curve(ax, ends, colour, linewidth=width, linestyle=dash, zorder=2, gid="edges")
    longest = float(data.sides.max())
    for axis, ink in enumerate(colours.AXES):
        unit = np.eye(3)[axis]
        start = 0.5 * data.sides[axis] * unit
        draw.curve(
            ax, np.array([np.zeros(3), start]), ink.colour, linewidth=1.2, linestyle="dotted"
        )
        inertia = _rounded(data.moments[axis])
        name = f"{ink.label}: {data.kinds[axis]}\n$I_{axis + 1} = ${inertia} kg m²"
        tip = 0.3 * longest * unit
        draw.arrow(ax, tip, ink.colour, name, start=start, linewidth=2.4, gid="axes")
        _dimension(ax, data.sides, axis, longest)
    tips = np.diag(0.5 * data.sides + 0.3 * longest)
    draw.fit(ax, data.corners, tips, elev=20.0, azim=35.0, filled=0.8)


def box(body: Body) -> Picture:
    """A box with its principal axes, its moments, and the stability of rotations about them.

    The axis through the largest face has the largest moment, the axis through the smallest face the
    smallest moment. The box tumbles if it is thrown with a spin about the third axis (Buller and
    Wernstål 2011, fig. 2).

    Parameters
    ----------
    body : Body
        A homogeneous box, made by :meth:`rigid.Body.box`.

    Returns
    -------
    Picture
        A homogeneous box and the stability of rotations about its axes.

        sides, moments : ndarray, shape (3,)
            Sides along, and moments about, the axes 1, 2, 3 (m, kg m²).
        corners : ndarray, shape (8, 3)
            Corners of the box (m).
        edges : ndarray of int, shape (12, 2)
            Indices of the two corners of each edge.
        kinds : tuple of 3 str
            Whether a rotation about an axis is ``"stable"``, ``"unstable"`` or ``"neutral"``.

    Raises
    ------
    TypeError
        If ``body`` is no :class:`rigid.Body`.
    ValueError
        If the body has no sides.

    Examples
    --------
    >>> import rigid
    >>> from rigid import figures
    >>> figures.box(rigid.Body.box(0.01, 0.08, 0.25)).kinds
    ('stable', 'unstable', 'stable')
    """
    if check_body(body).sides is None:
        raise ValueError(
            f"body = {brief(body)}: its sides are not known; create it by rigid.Body.box"
        )
    signs = np.array(list(product((-1.0, 1.0), repeat=3)))
    pairs = np.array(
        [(a, b) for a in range(8) for b in range(a) if np.abs(signs[a] - signs[b]).sum() == 2.0]
    )
    first, second, third = (str(permanent_rotation(body, axis).kind) for axis in (1, 2, 3))
    sides = np.array(body.sides)
    return Picture(
        _draw_box,
        sides=sides,
        moments=np.array(body.moments),
        corners=0.5 * signs * sides,
        edges=pairs,
        kinds=(first, second, third),
    )


def _dimension(ax: Any, sides: Floats, axis: int, longest: float) -> None:
    """The length of an outer edge, with a dimension line beside it."""
    grey, away = colours.NEUTRAL, longest * _AWAY[axis]
    middle = 0.5 * sides * _OUTER_EDGES[axis]
    along = sides[axis] * np.eye(3)[axis]
    for end in (middle - 0.5 * along, middle + 0.5 * along):
        draw.curve(ax, end + np.outer([0.02, 0.09], away), grey, linewidth=0.8)
    start = middle - 0.5 * along + 0.07 * away
    heads = "<|-|>" if sides[axis] > 0.2 * longest else "-"
    draw.arrow(ax, along, grey, start=start, linewidth=0.8, arrowstyle=heads, mutation_scale=8.0)
    # Above the arrow of axis 2, and below the box on the outer sides of its nearest corner.
    place = middle + 0.25 * along if axis == 2 else middle
    draw.label(
        ax,
        place + 0.1 * away,
        f"{sides[axis]:g} m",
        grey,
        fontsize="medium",
        ha="right" if axis == 1 else "left",
        va="center" if axis == 2 else "top",
    )


def _rounded(value: float) -> str:
    """A number with three digits, in TeX if it has a power of ten."""
    mantissa, _, exponent = f"{value:.3g}".partition("e")
    return rf"${mantissa}\cdot 10^{{{int(exponent)}}}$" if exponent else mantissa


def _draw_poinsot(data: Picture, ax: Any) -> None:
    faces = ellipsoid_faces(data.semi_axes, rings=30, sectors=60) @ data.axes
    towards = draw.eye(draw.ELEV, draw.AZIM)
    draw.surface(ax, faces, colours.BODY_FACE, towards, alpha=0.7, linewidths=0.0, gid="ellipsoid")
    foot = data.distance * draw.UP
    radius = float(np.linalg.norm(data.herpolhode - foot, axis=1).max())
    square = plane_face(foot, draw.UP, 1.25 * max(radius, 0.3 * data.distance))
    faint = colours.FAINT
    draw.surface(ax, square, faint, towards, alpha=0.4, zorder=2, linewidths=0.0, gid="plane")
    outward = data.polhode @ data.axes.T / data.semi_axes**2 @ data.axes
    near, far = draw.sides(data.polhode, outward, towards)
    draw.curve(ax, near, POLHODE, linewidth=1.6, zorder=3, gid="polhode")
    draw.curve(ax, far, POLHODE, linewidth=0.8, alpha=0.5, zorder=3, gid="polhode_hidden")
    later = data.herpolhode[data.frame :]
    draw.curve(ax, later, HERPOLHODE, linewidth=0.9, alpha=0.6, zorder=4)
    done = data.herpolhode[: data.frame + 1]
    draw.curve(ax, done, HERPOLHODE, linewidth=1.6, zorder=4, gid="herpolhode")
    draw.dots(ax, done[0], HERPOLHODE, markersize=4, zorder=4)
    # Inside the ellipsoid arrows are dashed: omega ends on it, L leaves it.
    inside: dict[str, Any] = {"linestyle": "dashed", "zorder": 3}
    omega, momentum = colours.OMEGA, colours.L
    draw.arrow(ax, data.contact, omega.colour, linewidth=1.6, gid="omega", **inside)
    leaves = draw.UP / np.linalg.norm(data.axes @ draw.UP / data.semi_axes)
    draw.curve(ax, np.array([0.0 * draw.UP, leaves]), momentum.colour, linewidth=1.6, **inside)
    outside: dict[str, Any] = {"start": leaves, "zorder": 4, "gid": "momentum"}
    draw.arrow(ax, 1.4 * foot - leaves, momentum.colour, momentum.label, **outside)
    draw.dots(ax, data.contact, omega.colour, markersize=6, zorder=6, gid="contact")
    right = np.cross(draw.UP, towards)
    right /= np.linalg.norm(right)
    away = 1.0 if data.contact @ right < 0.0 else -1.0
    beside = 0.6 * data.contact - 0.07 * away * data.distance * right
    draw.label(ax, beside, omega.label, omega.colour)
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
        draw.label(ax, end, name, colour, fontsize="medium", ha=align, va="bottom")
    corner = square[0, (-away * square[0] @ right).argmax()]
    corner = corner - 0.03 * data.distance * away * right
    align = "right" if away > 0.0 else "left"
    draw.label(ax, corner, "invariable plane", colours.NEUTRAL, fontsize="medium", ha=align)
    draw.fit(ax, faces, square, 1.5 * foot, elev=draw.ELEV, azim=draw.AZIM)


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
    scene = _free_body(run, "which Poinsot's picture shows", "Poinsot's picture")
    omega, attitude = states_of(run)
    k = whole("frame", frame)
    if not -len(omega) <= k < len(omega):
        raise ValueError(f"frame = {frame}: the run has {len(omega)} times")
    rolled: Any = free.poinsot(scene, omega, attitude)
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


def _free_body(run: Run, why: str, picture: str) -> FreeBody:
    """The scene of a run without torque and damping."""
    scene = scene_of(run)
    if not isinstance(scene, FreeBody):
        raise TypeError(f"scene = {brief(scene)}: must be a rigid.FreeBody, {why}")
    require_unforced(scene, picture)
    return scene


def _draw_polhodes(data: Picture, ax: Any) -> None:
    order = np.argsort(data.moments)
    towards = np.empty(3)
    towards[order] = 0.42, 1.0, 0.4  # the middle axis points to the viewer
    towards /= np.linalg.norm(towards)
    elev = float(np.degrees(np.arcsin(towards[2])))
    azim = float(np.degrees(np.arctan2(towards[1], towards[0])))
    faces = ellipsoid_faces(data.semi_axes, rings=30, sectors=60)
    draw.surface(ax, faces, colours.SURFACE, towards, gid="ellipsoid")
    for points, axis in zip(data.curves, data.axis, strict=True):
        colour = colours.AXES[abs(int(axis)) - 1].colour
        near, far = draw.sides(points, data.moments * points, towards)
        draw.curve(ax, near, colour, linewidth=1.5, zorder=4, gid="curves")
        draw.curve(ax, far, colour, linewidth=0.7, alpha=0.35, zorder=2, gid="curves_hidden")
    black, purple = colours.HUES["black"], colours.OMEGA.colour
    for ellipse in data.separatrix:
        near, far = draw.sides(ellipse, data.moments * ellipse, towards)
        draw.curve(ax, near, black, linewidth=2.0, zorder=5, gid="separatrix")
        draw.curve(ax, far, black, linewidth=0.8, alpha=0.35, zorder=2, gid="separatrix_hidden")
    if data.path is not None:
        near, far = draw.sides(data.path, data.moments * data.path, towards)
        draw.curve(ax, near, purple, linewidth=3.0, zorder=5.5, gid="path")
        draw.curve(ax, far, purple, linewidth=1.5, alpha=0.5, zorder=2, gid="path_hidden")
    names = {int(order[0]): "least", int(order[1]): "middle", int(order[2]): "largest"}
    length = np.full(3, 0.3)
    length[order[1]] = 1.1  # foreshortened
    tips = np.diag(data.semi_axes + length)
    for k, ink in enumerate(colours.AXES):
        start = np.diag(data.semi_axes)[k]
        along = tips[k] - start
        draw.arrow(ax, along, ink.colour, start=start, linewidth=1.6, zorder=6, gid="axes")
        words = f"{k + 1}: {names[k]} moment"
        sideways = float(np.cross(draw.UP, towards)[k])
        align = "left" if sideways > 0.1 else "right" if sideways < -0.1 else "center"
        draw.label(ax, tips[k] + 0.1 * np.eye(3)[k], words, ink.colour, fontsize="medium", ha=align)
    draw.fit(ax, faces, 1.05 * tips, elev=elev, azim=azim, filled=0.62)


def polhodes(body: BodyLike | Run, *, count: int = 5, samples: int = 361) -> Picture:
    """The polhodes of one energy on the inertia ellipsoid, with the separatrix.

    Polhodes encircle the axes of the largest and of the smallest moment: rotations about these axes
    are stable. No polhode encircles the middle axis, and a small perturbation of a rotation about
    it grows until the body has turned over (Landau and Lifshitz, *Mechanics*, § 37, fig. 51).

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
        run, body = body, _free_body(body, "whose rates follow polhodes", "a polhode")
        (path,) = states_of(run, names=["omega"])
    moments = moments_of(body)
    if path is not None:
        size = np.sqrt((path[0] ** 2 * moments).sum() / moments.min())
        if size == 0.0:
            raise ValueError("omega = [0, 0, 0]: a body at rest has no polhode")
        path = path / size
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
    separatrix[..., small] = semi[small] * np.cos(parting) * np.cos(phase)
    separatrix[..., middle] = semi[middle] * np.sin(phase)
    separatrix[..., large] = np.outer([1.0, -1.0], semi[large] * np.sin(parting) * np.cos(phase))
    return Picture(
        _draw_polhodes,
        moments=moments,
        semi_axes=semi,
        curves=np.concatenate([curves, -curves]),
        axis=np.concatenate([known.axis, -known.axis]),
        separatrix=separatrix,
        path=path,
    )


def _draw_free_top_omega(data: Picture, ax: Any) -> None:
    size = float(np.linalg.norm(data.start))
    purple, black = colours.OMEGA.colour, colours.HUES["black"]
    along = (data.start @ data.axis) * data.axis
    reach = np.maximum(1.3 * data.amplitude, 0.6 * size) * np.ones(3)
    which = int(data.axis.argmax())
    reach[which] = 1.25 * size
    for axis, ink in enumerate(colours.AXES):
        draw.arrow(ax, reach[axis] * np.eye(3)[axis], ink.colour, ink.label, linewidth=1.4)
    draw.curve(ax, data.path, purple, linewidth=1.4, gid="path")
    shadow = data.path - along
    draw.curve(ax, shadow, colours.FAINT, linewidth=1.4, gid="projection")
    # Arrow heads show the direction along the path.
    for place in range(len(data.path) // 6, len(data.path) - 2, len(data.path) // 3):
        start = data.path[place]
        step = data.path[place + 1] - start
        draw.arrow(ax, step, purple, start=start, linewidth=0.0, mutation_scale=14.0)
    drop = np.array([data.now, data.now - along])
    dashed: dict[str, Any] = {"linestyle": "dashed"}
    draw.curve(ax, drop, colours.FAINT, linewidth=1.0, **dashed)
    # Draw the vector at time 0 only if it differs from the vector at time t.
    draw.arrow(ax, data.start, purple, linewidth=1.2, alpha=0.7, gid="start", **dashed)
    draw.arrow(ax, data.now, purple, r"$\boldsymbol{\omega}(t)$", linewidth=2.4, gid="now")
    draw.arrow(ax, data.now - along, black, "$A$", linewidth=1.8, gid="amplitude")
    draw.curve(ax, np.array([np.zeros(3), data.start - along]), black, linewidth=0.9, **dashed)
    if data.amplitude > 0.0:
        first = 0.5 * (data.start - along)
        draw.arc(ax, data.axis, first, data.angle, black, "$k\\,t$", beyond=1.5)
        centre = np.array([data.now, along])
        draw.curve(ax, centre, colours.FAINT, linewidth=1.0, **dashed)
    name = r"$\omega_" + str(which + 1) + "$"
    aside = np.roll(np.array([0.0, -0.14 * size, 0.0]), which - 2)
    draw.label(ax, along + aside, name, colours.AXES[which].colour)
    draw.fit(ax, data.path, shadow, np.diag(reach), np.zeros(3), elev=20.0, azim=35.0)


def free_top_omega(
    body: BodyLike, omega: ArrayLike, *, t: float = 0.0, samples: int = 121
) -> Picture:
    """How omega turns about the axis of a free symmetric top in the body frame.

    The component along the axis is constant; the perpendicular component turns by ``k t`` on a
    circle of radius ``A``, in opposite directions for oblate and prolate tops (Ercan 2016, fig. 10,
    eqs. (43)-(45)).

    Parameters
    ----------
    body : Body, FreeBody or array_like, shape (3,)
        The body, or principal moments (kg m²), two of them exactly equal.
    omega : array_like, shape (3,)
        Angular velocity in the body at time 0 (rad/s), not zero.
    t : float
        Time (s).
    samples : int
        Number of points of the path.

    Returns
    -------
    Picture
        The angular velocity of a free symmetric top in the body frame.

        axis : ndarray, shape (3,)
            Unit vector along the axis of symmetry.
        k : float
            Rate at which omega turns about the axis (rad/s).
        amplitude : float
            ``A``, the size of the component of omega perpendicular to the axis (rad/s).
        angle : float
            ``k t`` (rad).
        path : ndarray, shape (m, 3)
            omega over one period, closed (rad/s); constant for ``k = 0``.
        start, now : ndarray, shape (3,)
            omega at time 0 and at the time ``t`` (rad/s).

    Raises
    ------
    ValueError
        If the top is not symmetric, omega is zero, or an argument is not finite.

    Examples
    --------
    >>> from rigid import figures
    >>> data = figures.free_top_omega((1.0, 1.0, 1.6), [0.9, 0.0, 2.3], t=1.0)
    >>> round(data.angle, 12), data.amplitude
    (1.38, 0.9)
    """
    rates = turning(omega)
    time = finite_float("t", t)
    period = float(symmetric_free_top(body, rates).period)
    whole = np.linspace(0.0, period if np.isfinite(period) else 0.0, samples)
    path: Any = symmetric_free_top(body, rates, t=whole)
    now: Any = symmetric_free_top(body, rates, t=[time])
    return Picture(
        _draw_free_top_omega,
        axis=np.eye(3)[int(path.axis) - 1],
        k=float(path.k),
        amplitude=float(path.amplitude),
        angle=float(path.k) * time,
        path=path.omega,
        start=rates,
        now=now.omega[0],
    )


def _draw_coplanar_vectors(data: Picture, *panels: Any) -> None:
    for ax, one in zip(panels, data.tops, strict=True):
        _draw_coplanar(one, ax)


def coplanar_vectors(bodies: Sequence[BodyLike], omega: ArrayLike) -> Picture:
    """L, omega and the axis of free symmetric tops in their common plane.

    ``tan theta = (I / I3) tan alpha``: L lies between the axis and omega if the top is oblate, and
    omega between the axis and L if it is prolate (Ercan 2016, figs. 11a, b, eqs. (47), (48)).

    Parameters
    ----------
    bodies : sequence of Body, FreeBody or array_like, shape (3,)
        A body for each panel, for example an oblate and a prolate top; or its principal moments
        (kg m²), two of them exactly equal.
    omega : array_like, shape (3,)
        Angular velocity in the body (rad/s), not zero, used for all bodies.

    Returns
    -------
    Picture
        L, omega and the axis of free symmetric tops, each in their common plane.

        tops : tuple of Picture
            The panel of each body, with the attributes

            along, across : float
                Moments about the axis of symmetry, ``I3``, and about a perpendicular axis, ``I``
                (kg m²).
            omega, momentum : ndarray, shape (2,)
                Components of omega (rad/s) and of L (kg m²/s) perpendicular to the axis and along
                it.
            alpha, theta : float
                Angles of omega and of L from the axis (rad).

    Raises
    ------
    ValueError
        If there are no bodies, a top is not symmetric, does not turn, or an argument is not finite.

    Examples
    --------
    >>> from rigid import figures
    >>> oblate, prolate = figures.coplanar_vectors([(1, 1, 1.6), (1, 1, 0.55)], [0.9, 0, 2.3]).tops
    >>> oblate.theta < oblate.alpha, prolate.theta < prolate.alpha
    (True, False)
    """
    if len(bodies) == 0:
        raise ValueError("bodies: expected at least one, got none")
    rates, tops = turning(omega), []
    for body in bodies:
        top = symmetric_free_top(body, rates)
        moments, which = moments_of(body), int(top.axis) - 1
        across, along = float(moments[which - 2]), float(moments[which])
        flat = np.array([float(top.amplitude), rates[which]])
        one = Picture(
            _draw_coplanar,
            panels=["plane"],
            along=along,
            across=across,
            omega=flat,
            momentum=np.array([across, along]) * flat,
            alpha=float(top.alpha),
            theta=float(top.theta),
        )
        tops.append(one)
    return Picture(_draw_coplanar_vectors, panels=["plane"] * len(tops), tops=tuple(tops))


def _draw_coplanar(data: Picture, ax: Any) -> None:
    size = float(np.linalg.norm(data.omega))
    longer = 1.25 * size
    draw.arrow(ax, np.array([0.0, longer]), colours.Z.colour, "axis", linewidth=1.6)
    momentum = longer * data.momentum / np.linalg.norm(data.momentum)
    for name, arrow_of, ink in (
        ("omega", data.omega, colours.OMEGA),
        ("momentum", momentum, colours.L),
    ):
        draw.arrow(ax, arrow_of, ink.colour, ink.label, linewidth=2.4, gid=name)
    for angle, radius, text in ((data.alpha, 0.62, r"$\alpha$"), (data.theta, 0.4, r"$\theta$")):
        end = 0.5 * np.pi - angle
        draw.arc_in_plane(ax, radius * size, 0.5 * np.pi, end, text, beyond=1.0 + 0.06 / radius)
    kind = "oblate: $I_3 > I$" if data.along > data.across else "prolate: $I_3 < I$"
    sign = "<" if data.theta < data.alpha else ">"
    if data.along == data.across:
        kind, sign = "spherical: $I_3 = I$", "="
    ax.set_title(rf"{kind},  $\theta {sign} \alpha$", fontsize="medium", y=0.95)
    low = -0.08 if data.omega[1] >= 0.0 else -1.42
    ax.set_aspect("equal")
    ax.set(xlim=(-0.25 * size, 1.3 * size), ylim=(low * size, 1.55 * size))
    ax.set_axis_off()


def turning(omega: ArrayLike) -> Floats:
    """The angular velocity, which must not be zero."""
    rates = vector("omega", omega, 3)
    if not rates.any():
        raise ValueError(f"omega = {rates.tolist()}: must not be zero, a body at rest has no axis")
    return rates


def _draw_cones(data: Picture, ax: Any) -> None:
    for name, rim, ink, alpha in (
        ("space", data.space_rim, colours.SPACE, 0.35),
        ("body", data.body_rim, colours.BODY, 0.25),
    ):
        draw.cone(ax, rim, ink.colour, alpha, gid=f"{name}_cone")
        draw.curve(ax, rim, ink.colour, linewidth=1.8, zorder=2, gid=f"{name}_rim")
    # Generators of the body cone show the rotation of the body.
    for end in data.body_rim[:-1:10]:
        draw.curve(ax, np.array([np.zeros(3), end]), colours.BODY.colour, linewidth=0.7, zorder=2)
    size = float(np.linalg.norm(data.omega))
    omega, axis = 1.12 * data.omega, 1.3 * size * data.axis
    momentum = 1.4 * size * data.momentum / np.linalg.norm(data.momentum)
    for name, along, colour, text, width in (
        ("omega", omega, colours.OMEGA.colour, colours.OMEGA.label, 2.6),
        ("momentum", momentum, colours.L.colour, colours.L.label, 2.2),
        ("axis", axis, colours.Z.colour, "axis", 2.2),
    ):
        draw.arrow(ax, along, colour, text, linewidth=width, gid=name)
    azim = float(np.degrees(np.arctan2(*data.space_rim[0, 1::-1]))) - 90.0
    # The names stand outside the cones, each on its own side of the page.
    right = rotate(np.array([0.0, 1.0, 0.0]), [0.0, 0.0, 1.0], np.radians(azim))
    towards = 1.0 if data.axis @ right >= 0.0 else -1.0
    for rim, angle, name, side, height in (
        (data.body_rim, data.body_cone, "body cone", towards, "top"),
        (data.space_rim, data.space_cone, "space cone", -towards, "center"),
    ):
        outermost = rim[np.argmax(side * (rim @ right))]
        place = 0.5 * outermost + 0.07 * side * size * right
        if height == "top":  # below the edge, however flat it lies
            place[2] -= 0.06 * size
        text = f"{name}\n{np.degrees(angle):.1f}°"
        align = "left" if side > 0.0 else "right"
        draw.label(ax, place, text, colours.NEUTRAL, fontsize="medium", va=height, ha=align)
    # Room for the whole motion around L and a fixed view, so that all frames have equal scales.
    shown = np.vstack([data.body_rim, data.space_rim, momentum, axis, omega])
    swept = rotate(shown[:, np.newaxis, :], [0.0, 0.0, 1.0], np.linspace(0.0, 2.0 * np.pi, 25))
    draw.fit(ax, swept, np.zeros(3), elev=16.0, azim=azim, filled=0.84)


def cones(body: BodyLike, omega: ArrayLike, *, t: float = 0.0, samples: int = 121) -> Picture:
    """The body cone of a free symmetric top as it rolls on the space cone.

    The cones touch along omega, the momentary axis of rotation. The space cone has the half angle
    ``|alpha - theta|`` about L, the body cone alpha about the axis (Ercan 2016, figs. 12a, b,
    errata D-21 to D-23). For the frames of an animation draw successive times ``t``.

    Parameters
    ----------
    body : Body, FreeBody or array_like, shape (3,)
        The body, or principal moments (kg m²), two of them exactly equal.
    omega : array_like, shape (3,)
        Angular velocity in the body at time 0 (rad/s).
    t : float
        Time (s).
    samples : int
        Number of points of a rim.

    Returns
    -------
    Picture
        The cones of a free symmetric top at one time, in space with L upwards.

        body_cone, space_cone : float
            Half angles (rad).
        rolling : str
            ``"outside"`` for a prolate top; ``"inside"`` for an oblate top, whose body cone
            encloses the space cone.
        omega, momentum, axis : ndarray, shape (3,)
            omega (rad/s), L (kg m²/s) and the unit vector along the axis in the direction of the
            spin.
        body_rim, space_rim : ndarray, shape (m, 3)
            The circles of omega in the body and in space (rad/s), with components in space. The
            body carries the first circle; both start with omega at time 0.

    Raises
    ------
    ValueError
        If the top is not symmetric, omega and L are parallel, so that no cone rolls, or an argument
        is not finite.

    Examples
    --------
    >>> from rigid import figures
    >>> data = figures.cones((1.0, 1.0, 0.55), [0.9, 0.0, 2.3], t=1.0)
    >>> data.rolling, round(data.space_cone, 9)
    ('outside', 0.245389808)
    """
    rates = turning(omega)
    time = finite_float("t", t)
    start = _upright(moments_of(body) * rates)
    found = cones_of(body, rates, start, samples=samples)
    if str(found.rolling) == "none":
        raise ValueError(
            f"omega = {rates.tolist()}: no cone rolls if omega and L are parallel, as they are "
            "along the axis, perpendicular to the axis, and for a sphere"
        )
    top: Any = symmetric_free_top(body, rates, start, t=[time])
    turn = quaternion_to_matrix(top.attitude[0])
    size = float(top.rate)
    which = int(top.axis) - 1
    return Picture(
        _draw_cones,
        body_cone=float(found.body_cone),
        space_cone=float(found.space_cone),
        rolling=str(found.rolling),
        omega=turn @ top.omega[0],
        momentum=turn @ (moments_of(body) * top.omega[0]),
        axis=np.copysign(1.0, rates[which]) * turn[:, which],
        body_rim=size * found.body_curve @ turn.T,
        space_rim=size * found.space_curve,
    )


def _upright(momentum: Floats) -> Floats:
    """Quaternion of the attitude in which a vector of the body points upwards in space."""
    up = momentum / np.linalg.norm(momentum)
    side = np.cross(up, np.eye(3)[np.argmin(np.abs(up))])
    side /= np.linalg.norm(side)
    return matrix_to_quaternion(np.stack([side, np.cross(up, side), up]))
