"""The box with its principal axes, and the heavy top with its Euler angles."""

from __future__ import annotations

from itertools import product
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._checks.arguments import brief, finite_float
from ..drawing import colours
from ..drawing.axes3d import UP, arc, arc_between, arrow, circle, cone, curve, dots, fit, label
from ..drawing.colours import on_ground
from ..drawing.shapes import box_faces
from ..free import permanent_rotation
from ..model.body import Body, check_body
from ..model.scene import HeavyTop, check_heavy_top
from ..rotations.euler import euler_to_quaternion
from ..top import gravity_torque
from .orientation import node_frame
from .picture import Picture

Floats = NDArray[np.float64]

_OUTER_EDGES = np.array([[0.0, 1.0, -1.0], [1.0, 0.0, -1.0], [-1.0, 1.0, 0.0]])
"""For each axis, the direction of its parallel edge at the outline of the visible faces."""

_AWAY = np.array([[0.0, 0.0, -1.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
"""For each axis, direction from that edge to its dimension line, in the plane of a visible face."""


def _draw_box(data: Picture, ax: Any) -> None:
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    elev, azim = 20.0, 35.0
    behind = -0.5 * data.sides  # the corner that this direction hides
    faces = box_faces(0.5 * data.sides)
    ax.add_collection3d(
        Poly3DCollection(faces, facecolor=colours.FACE, alpha=0.12, linewidth=0.0, zorder=1)
    )
    for ends in data.corners[data.edges]:
        hidden = (ends == behind).all(axis=-1).any()
        colour, width, dash = (
            (colours.FAINT, 1.0, "dashed") if hidden else (colours.NEUTRAL, 1.5, "solid")
        )
        curve(ax, ends, colour, linewidth=width, linestyle=dash, zorder=2, gid="edges")
    longest = float(data.sides.max())
    for axis, ink in enumerate(colours.AXES):
        unit = np.eye(3)[axis]
        start = 0.5 * data.sides[axis] * unit
        curve(ax, np.array([np.zeros(3), start]), ink.colour, linewidth=1.2, linestyle="dotted")
        name = (
            f"{ink.label}: {data.kinds[axis]}\n"
            rf"$I_{axis + 1} = ${_rounded(data.moments[axis])} kg m²"
        )
        tip = 0.3 * longest * unit
        arrow(ax, tip, ink.colour, name, start=start, linewidth=2.4, gid="axes")
        _dimension(ax, data.sides, axis, longest)
    tips = np.diag(0.5 * data.sides + 0.3 * longest)
    fit(ax, data.corners, tips, elev=elev, azim=azim, filled=0.8)


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


def _draw_heavy_top(data: Picture, ax: Any) -> None:
    frame, size = data.frame, float(np.linalg.norm(data.com))
    origin, black = np.zeros(3), colours.HUES["black"]
    axis, node = frame.body[2], frame.node[0]
    centre = data.rim[:-1].mean(axis=0)
    cone(ax, data.rim, on_ground(ax, colours.BODY.colour), 0.3, gid="top")
    curve(ax, data.rim, colours.BODY.colour, linewidth=1.6, gid="rim")
    curve(ax, circle(origin, UP, 0.9 * size), colours.FAINT, linewidth=1.0, zorder=1)

    for along, ink, name in zip(frame.space, colours.AXES, ("x'", "y'", "z'"), strict=True):
        longer = size * (1.9 if name == "z'" else 1.1)
        arrow(ax, longer * along, ink.colour, f"${name}$", linewidth=1.0, linestyle="dashed")
    arrow(ax, 2.0 * size * axis, colours.Z.colour, "$z$", linewidth=2.0)
    arrow(ax, 1.1 * size * node, colours.NODE.colour, colours.NODE.label, linewidth=1.4)
    # psi is told on the lid, from the direction of the line of nodes to axis x of the body.
    radius = float(np.linalg.norm(data.rim[0] - centre))
    on_lid = np.array([centre, centre + radius * node])
    curve(ax, on_lid, colours.NODE.colour, linewidth=1.2, linestyle="dashed")
    beside_lid = 1.35 * radius * frame.body[0]
    arrow(ax, beside_lid, colours.X.colour, "$x$", start=centre, linewidth=1.8)
    phi, theta, psi = frame.angles.tolist()
    named: dict[str, Any] = {"gid": "angles"}
    first = 0.66 * size * frame.space[0]
    arc(ax, UP, first, phi, black, r"$\phi$", beyond=0.68, **named)
    if theta:
        arc_between(ax, UP, axis, 1.6 * size, black, r"$\theta$", beyond=1.08, **named)
    else:
        arc(ax, UP, frame.space[0], 0.0, black, **named)
    first = 0.65 * radius * node
    arc(ax, axis, first, psi, black, r"$\psi$", centre=centre, beyond=1.35, **named)
    dots(ax, origin, black, markersize=5.0, zorder=7)
    dots(ax, data.com, black, markersize=6.0, zorder=7, gid="com")
    label(ax, -0.15 * size * np.cross(UP, node), "$O$")
    beside = 0.13 * size * frame.node[1]
    label(ax, 0.5 * data.com + beside, "$l$")
    label(ax, data.com + beside, "$C$")
    if data.weight.any():
        down = 0.75 * size * data.weight / np.linalg.norm(data.weight)
        name = r"$m\mathbf{g}$"
        arrow(ax, down, black, name, start=data.com, linewidth=2.2, gid="weight")
    if data.mgl * abs(np.sin(theta)) > 0.0:
        along, ink = 0.8 * size * data.torque / data.mgl, colours.TORQUE
        arrow(ax, along, ink.colour, linewidth=2.6, zorder=6, gid="torque")
        label(ax, along + 0.13 * size * UP, ink.label, ink.colour)
    ends = np.array([1.9 * size * UP, 2.0 * size * axis, beside_lid + centre])
    azim = float(np.degrees(phi)) - 20.0
    fit(ax, data.rim, circle(origin, UP, 1.1 * size), ends, elev=16.0, azim=azim, filled=0.86)


def heavy_top(scene: HeavyTop, angles: ArrayLike, *, length: float = 1.0) -> Picture:
    """A heavy top with its fixed point, its weight, and Euler's angles.

    The torque of the weight, ``mgl sin theta``, has the direction of the line of nodes. It has no
    component along the vertical and none along the axis, so both of these angular momenta are
    constant (Ercan 2016, fig. 14).

    Parameters
    ----------
    scene : HeavyTop
        A top whose centre of mass lies on the positive third axis.
    angles : array_like, shape (3,)
        ``phi, theta, psi`` (rad).
    length : float
        Distance ``l`` from the fixed point to the centre of mass (m); the weight is ``mgl / l``.

    Returns
    -------
    Picture
        A heavy top at one attitude, in space, with its fixed point at the origin.

        frame : Picture
            The angles and the axes of space, of the line of nodes, and of the body, as
            :func:`node_frame` makes it.
        mgl : float
            Weight times the distance of the centre of mass from the fixed point (J).
        com : ndarray, shape (3,)
            Centre of mass (m).
        weight : ndarray, shape (3,)
            Weight (N).
        torque : ndarray, shape (3,)
            Torque of the weight about the fixed point (N m).
        rim : ndarray, shape (m, 3)
            Rim of the cone that represents the top and has the same centre of mass (m).

    Raises
    ------
    TypeError
        If the scene is no heavy top.
    ValueError
        If ``com`` is not (0, 0, 1), the length is not positive, or an argument is not finite.

    Examples
    --------
    >>> import numpy as np, rigid
    >>> from rigid import figures
    >>> scene = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=2.0)
    >>> data = figures.heavy_top(scene, [0.0, np.pi / 2, 0.0])
    >>> (data.torque.round(12) + 0.0).tolist()  # along the line of nodes
    [2.0, 0.0, 0.0]
    """
    check_heavy_top(scene)
    if scene.com != (0.0, 0.0, 1.0):
        raise ValueError(f"com = {scene.com}: must be (0, 0, 1), the top is drawn about axis 3")
    distance = finite_float("length", length, positive=True)
    frame = node_frame(angles)
    axis = frame.body[2]
    height = distance / 0.75  # the centre of mass of a cone, from its apex
    return Picture(
        _draw_heavy_top,
        frame=frame,
        mgl=float(scene.mgl),
        com=distance * axis,
        weight=-scene.mgl / distance * UP,
        torque=gravity_torque(scene, euler_to_quaternion(frame.angles), frame="space"),
        rim=circle(height * axis, axis, 0.45 * height, frame.body[0]),
    )


def _dimension(ax: Any, sides: Floats, axis: int, longest: float) -> None:
    """The length of an outer edge, with a dimension line beside it."""
    grey, away = colours.NEUTRAL, longest * _AWAY[axis]
    middle = 0.5 * sides * _OUTER_EDGES[axis]
    along = sides[axis] * np.eye(3)[axis]
    for end in (middle - 0.5 * along, middle + 0.5 * along):
        curve(ax, end + np.outer([0.02, 0.09], away), grey, linewidth=0.8)
    start = middle - 0.5 * along + 0.07 * away
    heads = "<|-|>" if sides[axis] > 0.2 * longest else "-"
    arrow(ax, along, grey, start=start, linewidth=0.8, arrowstyle=heads, mutation_scale=8.0)
    # Above the arrow of axis 2, and below the box on the outer sides of its nearest corner.
    place = middle + 0.25 * along if axis == 2 else middle
    label(
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
