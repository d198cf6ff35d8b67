"""Figures of heavy tops: the top itself, its potential and cubics, and the path of its axis."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from .. import exact, top
from .._checks.arguments import (
    finite_float,
    positive_int,
    rows,
    shaped,
    sorted_times,
    vector,
)
from .._checks.arrays import Floats, attitudes
from ..drawing import axes3d as draw
from ..drawing import colours
from ..drawing.colours import on_ground
from ..drawing.shapes import across, ellipsoid_faces
from ..model.scene import HeavyTop, check_heavy_top, require_unforced
from ..rotations.euler import euler_to_quaternion, rotation_x, rotation_z
from ..rotations.quaternions import matrix_to_quaternion
from ..top import gravity_torque
from .picture import Picture
from .rotations import node_frame

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation


UPRIGHT = (1.0, 0.0, 0.0, 0.0)
"""The attitude in which body and space axes coincide."""

ELEV = 24.0
"""Elevation of the viewer of a path (degrees)."""

FARTHEST = 4.0
"""A third root beyond this height is not drawn, because the other roots would be invisible."""


def _draw_heavy_top(data: Picture, ax: Any) -> None:
    frame, size = data.frame, float(np.linalg.norm(data.com))
    origin, black = np.zeros(3), colours.HUES["black"]
    axis, node = frame.body[2], frame.node[0]
    centre = data.rim[:-1].mean(axis=0)
    draw.cone(ax, data.rim, on_ground(ax, colours.BODY.colour), 0.3, gid="top")
    draw.curve(ax, data.rim, colours.BODY.colour, linewidth=1.6, gid="rim")
    draw.curve(ax, draw.circle(origin, draw.UP, 0.9 * size), colours.FAINT, linewidth=1.0, zorder=1)

    for along, ink, name in zip(frame.space, colours.AXES, ("x'", "y'", "z'"), strict=True):
        longer = size * (1.9 if name == "z'" else 1.1)
        draw.arrow(ax, longer * along, ink.colour, f"${name}$", **draw.DASHED)
    draw.arrow(ax, 2.0 * size * axis, colours.Z.colour, "$z$", linewidth=2.0)
    draw.arrow(ax, 1.1 * size * node, colours.NODE.colour, colours.NODE.label, linewidth=1.4)
    # psi is told on the lid, from the direction of the line of nodes to axis x of the body.
    radius = float(np.linalg.norm(data.rim[0] - centre))
    on_lid = np.array([centre, centre + radius * node])
    draw.curve(ax, on_lid, colours.NODE.colour, linewidth=1.2, linestyle="dashed")
    beside_lid = 1.35 * radius * frame.body[0]
    draw.arrow(ax, beside_lid, colours.X.colour, "$x$", start=centre, linewidth=1.8)
    phi, theta, psi = frame.angles.tolist()
    first = 0.66 * size * frame.space[0]
    draw.arc(ax, draw.UP, first, phi, black, r"$\phi$", beyond=0.68, gid="angles")
    name = r"$\theta$" if theta else ""
    draw.arc(ax, node, 1.6 * size * draw.UP, theta, black, name, beyond=1.08, gid="angles")
    first = 0.65 * radius * node
    draw.arc(ax, axis, first, psi, black, r"$\psi$", centre=centre, beyond=1.35, gid="angles")
    draw.dots(ax, origin, black, markersize=5.0, zorder=7)
    draw.dots(ax, data.com, black, markersize=6.0, zorder=7, gid="com")
    draw.label(ax, -0.15 * size * np.cross(draw.UP, node), "$O$")
    beside = 0.13 * size * frame.node[1]
    draw.label(ax, 0.5 * data.com + beside, "$l$")
    draw.label(ax, data.com + beside, "$C$")
    if data.weight.any():
        down = 0.75 * size * data.weight / np.linalg.norm(data.weight)
        name = r"$m\mathbf{g}$"
        draw.arrow(ax, down, black, name, start=data.com, linewidth=2.2, gid="weight")
    if data.mgl * abs(np.sin(theta)) > 0.0:
        along, ink = 0.8 * size * data.torque / data.mgl, colours.TORQUE
        draw.arrow(ax, along, ink.colour, linewidth=2.6, zorder=6, gid="torque")
        draw.label(ax, along + 0.13 * size * draw.UP, ink.label, ink.colour)
    ends = np.array([1.9 * size * draw.UP, 2.0 * size * axis, beside_lid + centre])
    azim = float(np.degrees(phi)) - 20.0
    draw.fit(
        ax,
        data.rim,
        draw.circle(origin, draw.UP, 1.1 * size),
        ends,
        elev=16.0,
        azim=azim,
        filled=0.86,
    )


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
        weight=-scene.mgl / distance * draw.UP,
        torque=gravity_torque(scene, euler_to_quaternion(frame.angles), frame="space"),
        rim=draw.circle(height * axis, axis, 0.45 * height, frame.body[0]),
    )


def _draw_effective_potential(data: Picture, ax: Any) -> None:
    blue, level_colour = colours.HUES["blue"], colours.HUES["vermilion"]
    draw.curve(ax, (np.degrees(data.tilt), data.potential), blue, linewidth=1.8, gid="potential")
    ends = np.degrees([data.theta_upper, data.theta_lower])
    level = ends, np.full(2, data.E_prime)
    draw.curve(ax, level, level_colour, linewidth=1.8, gid="E_prime")
    ink = on_ground(ax, level_colour)
    ax.axhline(data.E_prime, color=ink, linewidth=0.8, linestyle="dashed", zorder=1)
    turning = draw.dots(ax, level, level_colour, markersize=6, gid="turning")
    bottom = np.array([np.degrees(data.theta_steady), data.lowest])
    steady = draw.dots(ax, bottom, blue, markersize=6, gid="lowest")

    height = max(data.E_prime - data.lowest, 0.2 * data.mgl, 0.05 * abs(data.lowest))
    low, high = data.lowest - 0.75 * height, data.E_prime + 1.6 * height
    # A stiff well may lie between two tilts of the curve.
    well = np.sort([*np.degrees(data.tilt[data.potential <= high]), *ends])
    margin = 0.5 * max(float(np.ptp(well)), 1.0)
    first, last = max(well[0] - margin, 0.0), min(well[-1] + margin, 180.0)
    wide = last - first
    marks = [(data.theta_steady, data.lowest, r"$\theta_\mathrm{m}$", 0.16)]
    if ends[1] - ends[0] > 0.04 * wide:
        marks.append((data.theta_upper, data.E_prime, r"$\theta_\mathrm{upper}$", 0.06))
        marks.append((data.theta_lower, data.E_prime, r"$\theta_\mathrm{lower}$", 0.06))
    for theta, value, name, share in marks:
        place = np.degrees(theta)
        draw.curve(ax, ([place, place], [low, value]), colours.FAINT, linewidth=0.9, zorder=1)
        # Outside the well, but inside the axes.
        room = 0.12 * wide
        left = (first + room < place and theta < data.theta_steady) or place >= last - room
        beside = np.array([place + 0.01 * wide * (-1 if left else 1), low + share * (high - low)])
        draw.label(ax, beside, name, ha="right" if left else "left")
    # Write the names beside the lines, outside the well, on the side that has room.
    right = well[-1] + margin <= 180.0 or well[0] - margin < 0.0
    end = last - 0.03 * wide if right else first + 0.03 * wide
    draw.label(ax, (end, data.E_prime), "$E'$", level_colour, va="bottom")
    near = low + 0.88 * (high - low)
    seen = np.flatnonzero(data.potential <= max(near, data.potential.min()))
    place, off, side = (seen[-1], 0.02, "left") if right else (seen[0], -0.02, "right")
    across = np.degrees(data.tilt[place]) + off * wide
    beside = np.array([across, np.minimum(data.potential[place], near)])
    draw.label(ax, beside, r"$V'(\theta)$", blue, ha=side, va="top")
    ax.set(
        xlim=(first, last),
        ylim=(low, high),
        xlabel=r"tilt $\theta$ (°)",
        ylabel="energy (J)",
    )
    names = (
        r"highest ($\theta_\mathrm{upper}$) and lowest ($\theta_\mathrm{lower}$) axis: "
        "$V' = E'$",
        r"steady precession ($\theta_\mathrm{m}$): the least $V'$",
    )
    ax.legend(handles=[turning, steady], labels=names, **draw.BELOW)


def effective_potential(
    scene: HeavyTop,
    omega: ArrayLike,
    attitude: ArrayLike | Rotation | None = None,
    *,
    samples: int = 721,
) -> Picture:
    """The effective potential of a top against its tilt, and the energy of its nutation.

    The tilt moves as a particle in this well, between the circles with ``V' = E'`` (Goldstein,
    *Classical Mechanics*, § 5.7; Ercan 2016, fig. 15, where the level E must be E', erratum D-40).

    Parameters
    ----------
    scene : HeavyTop
        Two moments exactly equal, the centre of mass exactly on the third axis.
    omega : array_like, shape (3,)
        Angular velocity in the body at any time (rad/s).
    attitude : array_like, shape (4,), or scipy Rotation, optional
        Attitude at that time; by default body and space axes coincide.
    samples : int
        Number of tilts.

    Returns
    -------
    Picture
        The effective potential of a top, and the tilts that its energy allows.

        mgl : float
            Weight times distance of the centre of mass from the fixed point (J).
        tilt, potential : ndarray, shape (m,)
            Tilts between 0 and pi (rad) and ``V'`` there (J).
        E_prime : float
            Energy of the nutation (J).
        theta_upper, theta_lower : float
            Tilts of the upper and the lower circle, between which ``V' <= E'`` (rad).
        theta_steady, lowest : float
            Tilt of the minimum of ``V'`` (rad), and its value (J): the steady precession.

    Raises
    ------
    ValueError
        If the top is not symmetric, torque or damping acts, the potential is constant, or the state
        is not finite.

    Examples
    --------
    >>> import numpy as np, rigid
    >>> from rigid import figures
    >>> scene = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)
    >>> tilted = [np.cos(np.pi / 6), np.sin(np.pi / 6), 0.0, 0.0]
    >>> data = figures.effective_potential(scene, [0.0, 0.0, 5.0], tilted)
    >>> round(data.theta_upper, 9), round(data.theta_lower, 9)
    (1.047197551, 1.377833075)
    """
    known = _constants(scene, omega, attitude)
    a, b, e_prime = (known[name] for name in ("a", "b", "E_prime"))
    upper, lower = top.turning_angles(scene, a=a, b=b, E_prime=e_prime)
    steady = top.effective_minimum(scene, a=a, b=b)
    tilt = np.linspace(0.0, np.pi, samples)
    return Picture(
        _draw_effective_potential,
        panels=["plane"],
        mgl=float(scene.mgl),
        tilt=tilt,
        potential=top.effective_potential(scene, tilt, a=a, b=b).value,
        E_prime=e_prime,
        theta_upper=float(upper),
        theta_lower=float(lower),
        theta_steady=float(steady),
        lowest=float(top.effective_potential(scene, steady, a=a, b=b).value),
    )


def _constants(
    scene: HeavyTop, omega: ArrayLike, attitude: ArrayLike | Rotation | None
) -> dict[str, float]:
    """a, b, alpha, beta and E' of one symmetric top."""
    require_unforced(check_heavy_top(scene), "a picture with constants of motion")
    known = top.heavy_constants(
        scene, vector("omega", omega, 3), UPRIGHT if attitude is None else attitude
    )
    if known.a is None:
        raise ValueError(
            f"moments = {scene.body.moments}, com = {scene.com}: a symmetric top has two exactly "
            "equal moments and its centre of mass exactly on the third axis"
        )
    if np.ndim(known.energy):
        raise ValueError(f"attitude: expected a single one, got the shape {np.shape(known.energy)}")
    return {name: float(getattr(known, name)) for name in ("a", "b", "alpha", "beta", "E_prime")}


def _draw_cubic(data: Picture, ax: Any) -> None:
    red, black = colours.HUES["vermilion"], colours.HUES["black"]
    seen = data.roots[data.roots <= data.u[-1]]
    roots = _with_roots(ax, data.u, data.f, seen, "f")
    ax.axvspan(-1.0, 1.0, color=on_ground(ax, colours.FAINT), alpha=0.2, linewidth=0.0, zorder=0)
    depth, highest = -data.f.min(), data.f_allowed.max()
    high = max(0.75 * depth, 1.4 * highest)
    ax.set(xlim=(data.u[0], data.u[-1]), ylim=(-1.08 * depth, high))
    ax.set(xlabel=r"height $u = \cos\theta$", ylabel=r"$f(u) = \dot u^2$ (1/s²)")
    if len(seen) == 3:
        draw.label(ax, (seen[2], 0.07 * depth), "$u_3$", ha="right")

    close, unit = ax, high
    if highest < 0.2 * depth:
        close = ax.inset_axes((0.16, 0.62, 0.5, 0.3))
        close.xaxis.tick_top()  # below are the lines to its place
        _with_roots(close, data.near, data.f_near, seen[:2], "f_near")
        unit = max(1.6 * highest, 0.3 * -data.f_near.min())
        close.set(xlim=(data.near[0], data.near[-1]), ylim=(-0.5 * unit, unit))
        close.tick_params(labelsize="small")
        close.locator_params(nbins=4)
        ax.indicate_inset_zoom(close, edgecolor=on_ground(ax, colours.NEUTRAL))
    allowed = draw.curve(close, (data.allowed, data.f_allowed), red, linewidth=2.4, gid="allowed")
    handles, names = [allowed], ["the top moves from $u_1$ to $u_2$"]
    if data.near[0] < data.still < data.near[-1]:
        ink = on_ground(close, black)
        still = close.axvline(data.still, color=ink, zorder=2, gid="still", **draw.DASHED)
        draw.label(close, (data.still, 0.85 * unit), "$a/b$", black)
        handles.append(still)
        names.append(r"$u = a/b$: no precession; $a = p_\phi/I_1$, $b = p_\psi/I_1$")
    if seen[1] - seen[0] < 1e-3:
        draw.label(close, (seen[0], 0.25 * unit), "$u_1 = u_2$")
    else:
        # Between the roots the curve is above their names.
        for place, name, align in ((seen[0], "$u_1$", "left"), (seen[1], "$u_2$", "right")):
            draw.label(close, (place, -0.2 * unit), name, ha=align)
    if len(seen) == 3:
        handles.append(roots)
        names.append("$u_1$, $u_2$, $u_3$: roots of $f$; the top never reaches $u_3$")
    ax.legend(handles=handles, labels=names, **draw.BELOW)


def cubic(
    scene: HeavyTop,
    omega: ArrayLike,
    attitude: ArrayLike | Rotation | None = None,
    *,
    samples: int = 401,
) -> Picture:
    """The cubic f(u) with its roots, and the heights between which the top nutates.

    The motion needs ``f >= 0`` and a height between -1 and 1. The precession reverses at
    ``u = a / b`` (lecture notes, fig. 5.4; a steady precession has a double root, erratum G-21).

    Parameters
    ----------
    scene, omega, attitude, samples
        As in :func:`rigid.figures.effective_potential`; each curve has ``samples`` points.

    Returns
    -------
    Picture
        The cubic ``u'² = f(u)`` of the height of a top.

        u, f : ndarray, shape (m,)
            Heights from below -1 to beyond the third root, or to beyond 1 if the third root is far
            away, and f at these heights (1/s²).
        allowed, f_allowed : ndarray, shape (m,)
            Heights from ``u1`` to ``u2``, between which the top nutates, and f there.
        near, f_near : ndarray, shape (m,)
            Heights from a little below ``u1`` to a little above ``u2``, and f there.
        roots : ndarray, shape (3,)
            Roots ``u1 <= u2 <= 1 <= u3``; u3 is inf without weight.
        still : float
            ``a / b``, the height at which the precession reverses; inf without spin.

    Raises
    ------
    ValueError
        If the top is not symmetric, torque or damping acts, or the state is not finite.

    Examples
    --------
    >>> import numpy as np, rigid
    >>> from rigid import figures
    >>> scene = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)
    >>> tilted = [np.cos(np.pi / 6), np.sin(np.pi / 6), 0.0, 0.0]
    >>> data = figures.cubic(scene, [0.0, 0.0, 5.0], tilted)
    >>> data.roots.round(9).tolist()
    [0.191767988, 0.5, 2.933232012]
    """
    constants = _constants(scene, omega, attitude)
    del constants["E_prime"]
    found = top.f_roots(**constants)
    roots = np.array([found.u1, found.u2, found.u3])
    end = roots[2] if roots[2] <= FARTHEST else 1.0
    u = np.linspace(-1.2, end + 0.06 * (end + 1.2), samples)
    allowed = np.linspace(roots[0], roots[1], samples)
    beyond = 0.25 * max(roots[1] - roots[0], 0.05)
    near = np.linspace(roots[0] - beyond, roots[1] + beyond, samples)
    return Picture(
        _draw_cubic,
        panels=["plane"],
        u=u,
        f=top.f_u(u, **constants),
        allowed=allowed,
        f_allowed=top.f_u(allowed, **constants),
        near=near,
        f_near=top.f_u(near, **constants),
        roots=roots,
        still=constants["a"] / constants["b"] if constants["b"] != 0.0 else np.inf,
    )


def _with_roots(ax: Any, u: Floats, f: Floats, roots: Floats, name: str) -> Any:
    """Draw f, the line f = 0, and the roots as dots, which are returned."""
    draw.curve(ax, (u, f), colours.HUES["blue"], linewidth=1.6, gid=name)
    ax.axhline(0.0, color=on_ground(ax, colours.NEUTRAL), linewidth=0.8, zorder=1)
    red = colours.HUES["vermilion"]
    return draw.dots(ax, (roots, 0.0 * roots), red, markersize=5, zorder=4, gid="roots")


def _draw_upright_cubic(data: Picture, *places: Any) -> None:
    blue, orange = colours.HUES["blue"], colours.HUES["orange"]
    size = 1.15 * max(np.abs(data.exact).max(), np.abs(data.approximate).max())
    for k, ax in enumerate(places):
        positive = np.maximum(data.exact[k], 0.0)
        faint = on_ground(ax, blue)
        reached = ax.fill_between(data.u, positive, color=faint, alpha=0.2, linewidth=0.0)
        ax.axhline(0.0, color=on_ground(ax, colours.NEUTRAL), linewidth=0.8, zorder=1)
        near = data.u, data.approximate[k]
        approximate = draw.curve(
            ax, near, orange, linewidth=1.6, linestyle="dashed", gid="approximate"
        )
        exact = draw.curve(ax, (data.u, data.exact[k]), blue, linewidth=1.8, gid="exact")
        draw.dots(ax, (1.0, 0.0), colours.HUES["black"], markersize=5, clip_on=False, zorder=5)
        share = data.spin[k] / data.spin_min
        words = "sleeps" if data.stable[k] else "falls"
        ax.set_title(f"spin {share:.3g} × the least: {words}", fontsize="medium")
        ax.set(xlim=(data.u[0], 1.0), ylim=(-size, size), xlabel=r"height $u = \cos\theta$")
        ax.locator_params(nbins=5)
    places[0].set_ylabel("$f(u)$ (1/s²)")
    names = (
        "$f(u)$",
        r"$(1-u)^2(2\beta-b^2)$ with $\beta = 2mgl/I_1$, $b = I_3\omega_3/I_1$",
        "heights that the top reaches",
    )
    places[0].figure.legend(
        handles=[exact, approximate, reached],
        labels=names,
        loc="outside lower center",
        ncols=3,
        **draw.KEY,
    )


def upright_cubic(
    scene: HeavyTop, spins: ArrayLike = (0.9, 1.0, 1.1), *, lowest: float = 0.6, samples: int = 301
) -> Picture:
    """The cubic near the vertical for a top with a spin below, at and above the bound of sleeping.

    The top reaches heights with positive f. At the bound the approximation is zero and does
    not decide; there ``f = -beta (1 - u)³`` is negative, so the top sleeps (lecture notes,
    fig. 5.6; erratum G-19).

    Parameters
    ----------
    scene : HeavyTop
        A Lagrange top with weight.
    spins : array_like, shape (3,)
        Spins in units of the least spin of the sleeping top.
    lowest : float
        The lowest height; the highest is 1, the vertical.
    samples : int
        Number of heights.

    Returns
    -------
    Picture
        The cubic of an upright top near the vertical.

        spin : ndarray, shape (k,)
            Spins (rad/s).
        spin_min : float
            The least spin of a sleeping top (rad/s).
        u : ndarray, shape (m,)
            Heights.
        exact, approximate : ndarray, shape (k, m)
            ``f(u)`` and ``(1 - u)² (2 beta - b²)`` (1/s²).
        stable : ndarray of bool, shape (k,)
            Whether the top stays upright.

    Raises
    ------
    ValueError
        If the top is no Lagrange top with weight, or a spin is not finite.

    Examples
    --------
    >>> import rigid
    >>> from rigid import figures
    >>> scene = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)
    >>> figures.upright_cubic(scene).stable.tolist()
    [False, True, True]
    """
    bound = float(top.sleeping_top(check_heavy_top(scene), 0.0).spin_min)
    spin = vector("spins", spins, 3) * bound
    u = np.linspace(lowest, 1.0, samples)
    exact, approximate = top.upright_f(scene, spin[:, np.newaxis], u)
    return Picture(
        _draw_upright_cubic,
        panels=["plane"] * 3,
        spin=spin,
        spin_min=bound,
        u=u,
        exact=exact,
        approximate=approximate,
        stable=top.sleeping_top(scene, spin).stable,
    )


def _draw_locus(data: Picture, ax: Any) -> None:
    towards = draw.eye(data.elev, draw.AZIM)
    faces = ellipsoid_faces(np.ones(3), rings=24, sectors=48)
    draw.surface(ax, faces, colours.SURFACE, towards, gid="sphere")
    draw.curve(ax, draw.circle(np.zeros(3), towards, 1.0), colours.FAINT, linewidth=1.0, zorder=2)
    red, blue = colours.HUES["vermilion"], colours.HUES["blue"]
    right = rotation_z(np.radians(draw.AZIM))[:, 1]
    page_up = np.cross(towards, right)
    upper, lower = data.theta_upper, data.theta_lower
    if upper is not None and lower is not None:
        gap = (np.cos(upper) - np.cos(lower)) * np.cos(np.radians(data.elev))
        for theta, name, align in ((upper, "upper", "bottom"), (lower, "lower", "top")):
            ring = draw.circle(np.cos(theta) * draw.UP, draw.UP, float(np.sin(theta)))
            near, far = draw.sides(ring, ring, towards)
            gid = f"theta_{name}"
            draw.curve(ax, near, blue, linewidth=1.0, zorder=3, gid=gid)
            hidden = f"{gid}_hidden"
            draw.curve(ax, far, blue, linewidth=0.6, linestyle="dotted", zorder=2, gid=hidden)
            # The name stands beside the sphere, whose edge is there at this height on the page.
            end = ring[np.argmax(ring @ right)]
            height = float(end @ page_up)
            place = np.sqrt(max(1.0 - height**2, 0.0)) * right + height * page_up
            thread = np.array([end, place + 0.04 * right])
            draw.curve(ax, thread, blue, linewidth=0.5, zorder=3)
            text, va = f"  $\\theta_\\mathrm{{{name}}}$", "center" if gap > 0.1 else align
            draw.label(ax, place, text, blue, fontsize="medium", ha="left", va=va)
    near, far = draw.sides(data.point, data.point, towards)
    draw.curve(ax, far, red, linewidth=0.8, alpha=0.45, zorder=2, gid="point_hidden")
    draw.curve(ax, near, red, linewidth=1.8, zorder=4, gid="point")
    draw.dots(ax, data.point[0], red, markersize=5, zorder=5, gid="start")
    up = colours.VERTICAL
    draw.arrow(ax, 0.35 * draw.UP, up.colour, up.label, start=draw.UP, linewidth=1.4)
    draw.fit(ax, faces, 1.4 * draw.UP, elev=data.elev, azim=draw.AZIM)


def locus(
    scene: HeavyTop,
    omega: ArrayLike,
    attitude: ArrayLike | Rotation | None = None,
    *,
    t: ArrayLike | None = None,
    samples: int = 1201,
    elev: float = ELEV,
) -> Picture:
    """The path of the axis of a top on the unit sphere, between its two circles.

    Landau and Lifshitz, *Mechanics*, § 35; Ercan 2016, fig. 16; lecture notes, fig. 5.5. The figure
    does not show the spin.

    Parameters
    ----------
    scene : HeavyTop
        Any heavy top.
    omega : array_like, shape (3,)
        Angular velocity in the body at ``t = 0`` (rad/s).
    attitude : array_like, shape (4,), or scipy Rotation, optional
        Attitude at ``t = 0``; by default body and space axes coincide.
    t : array_like, shape (m,), optional
        Times (s), ascending. Default: ``samples`` times over one turn of a symmetric top's axis
        about the vertical, but over four nutations at least.
    samples : int
        Number of times.
    elev : float
        Elevation of the viewer (degrees). From as many degrees as the lower circle is tilted, the
        whole path is on the visible side.

    Returns
    -------
    Picture
        The path of the axis of a top on the unit sphere.

        kind : str
            Kind of path, as in :func:`rigid.top.classify_locus`; ``"general"`` for a top that is
            not symmetric or is under torque or damping.
        retrograde : bool
            Whether the mean precession is against the spin.
        t : ndarray, shape (m,)
            Times (s).
        point : ndarray, shape (m, 3)
            Unit vector to the centre of mass in space.
        theta, phi : ndarray, shape (m,)
            Tilt of the axis, and azimuth of the node line (rad).
        theta_upper, theta_lower : float or None
            Tilts of the circles between which the axis moves (rad); None for the kind
            ``"general"``.
        elev : float
            Elevation of the viewer (degrees).

    Raises
    ------
    ValueError
        If you pass no times for a top without a period, or the state is not finite.

    Examples
    --------
    >>> import numpy as np, rigid
    >>> from rigid import figures
    >>> scene = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)
    >>> tilted = [np.cos(np.pi / 6), np.sin(np.pi / 6), 0.0, 0.0]
    >>> figures.locus(scene, [0.0, 0.0, 5.0], tilted).kind
    'cusp'
    """
    elevation = finite_float("elev", elev)
    rates = vector("omega", omega, 3)
    if attitude is not None:
        attitude = attitudes(attitude)
        if attitude.shape != (4,):
            raise ValueError(f"attitude: expected shape (4,), got {attitude.shape}")
    motion, kind, upper, lower = None, "general", None, None
    unforced = not check_heavy_top(scene).forces and scene.mgl != 0.0
    if unforced and top.heavy_constants(scene, rates, UPRIGHT).a is not None:
        motion = exact.lagrange_top(scene, rates, attitude)
        kind = str(motion.kind)
        upper, lower = float(motion.tilt_min), float(motion.tilt_max)
    if t is None:
        length = 0.0
        if motion is not None:
            period, rate = float(motion.period), abs(float(motion.precession))
            turn = 2.0 * np.pi / rate if rate > 0.0 else 0.0
            length = max(turn, 4.0 * period) if np.isfinite(period) else turn
        if not 0.0 < length < np.inf:
            raise ValueError(f"t = None: the axis of this top has no period ({kind}), give times")
        t = np.linspace(0.0, length, positive_int("samples", samples, minimum=2))
    times = sorted_times("t", t)
    path = top.locus(scene, rates, attitude, t=times)
    return Picture(
        _draw_locus,
        kind=kind,
        retrograde=motion is not None and bool(motion.retrograde),
        t=times,
        point=path.point,
        theta=path.theta,
        phi=path.phi,
        theta_upper=upper,
        theta_lower=lower,
        elev=elevation,
    )


def _draw_loci(data: Picture, *panels: Any) -> None:
    for ax, one in zip(panels, data.paths, strict=True):
        _draw_locus(one, ax)
        title = f"{one.kind}, retrograde" if one.retrograde else one.kind
        ax.set_title(title, fontsize="medium")


def loci(
    scene: HeavyTop, omega: ArrayLike, attitude: ArrayLike | Rotation | None = None
) -> Picture:
    """The paths of several starts side by side, each with its kind.

    :func:`rigid.top.classify_locus` says the kind; ``retrograde`` is added if the mean precession
    is against the spin.

    Parameters
    ----------
    scene : HeavyTop
        Any heavy top whose axis has a period.
    omega : array_like, shape (n, 3)
        Angular velocities in the body at ``t = 0`` (rad/s).
    attitude : array_like, shape (4,) or (n, 4), or scipy Rotation, optional
        Attitudes at ``t = 0``; by default body and space axes coincide.

    Returns
    -------
    Picture
        The paths of several starts.

        paths : tuple of Picture
            The figure of each path, as :func:`locus` makes it.

    Raises
    ------
    ValueError
        As in :func:`locus`.

    Examples
    --------
    >>> import numpy as np, rigid
    >>> from rigid import figures
    >>> scene = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)
    >>> tilted = [np.cos(np.pi / 6), np.sin(np.pi / 6), 0.0, 0.0]
    >>> found = figures.loci(scene, [[0.0, -0.26, 5.0], [0.0, 0.0, 5.0]], tilted)
    >>> [one.kind for one in found.paths]
    ['loop', 'cusp']
    """
    rates = rows("omega", omega, 3)
    start = attitudes(attitude)
    if start.shape not in ((4,), (len(rates), 4)):
        raise ValueError(f"attitude: expected shape (4,) or {(len(rates), 4)}, got {start.shape}")
    starts = np.broadcast_to(start, (len(rates), 4))
    paths = (locus(scene, one, other) for one, other in zip(rates, starts, strict=True))
    return Picture(_draw_loci, panels=["space"] * len(rates), columns=2, paths=tuple(paths))


def _draw_cycloids(data: Picture, *places: Any) -> None:
    red, black = colours.HUES["vermilion"], colours.HUES["black"]
    scale = np.sin(data.tilt)
    for k, ax in enumerate(places):
        path = np.degrees(scale * data.phi[k]), np.degrees(data.theta[k])
        draw.curve(ax, path, red, linewidth=1.8, gid="theta")
        cycloid = np.degrees(scale * data.phi_approx[k]), np.degrees(data.theta_approx[k])
        draw.curve(ax, cycloid, black, gid="theta_approx", **draw.DASHED)
        faint = on_ground(ax, colours.FAINT)
        ax.axhline(np.degrees(data.tilt), color=faint, linewidth=0.8, zorder=1)
        ax.set_title(str(data.kind[k]), fontsize="medium", loc="left")
        ax.set_aspect("equal", adjustable="datalim")
        ax.invert_yaxis()
        ax.set_ylabel(r"tilt $\theta$ (°)")
    if places:
        first_order = "dashed: the cycloid of first order"
        places[0].set_title(first_order, fontsize="small", loc="right")
        places[-1].set_xlabel(r"azimuth $\phi\,\sin\theta_0$ (°)")


def cycloids(
    scene: HeavyTop,
    tilt: float,
    spin: float,
    *,
    pushes: ArrayLike = (0.5, 0.0, -1.0),
    periods: float = 4.0,
    samples: int = 801,
) -> Picture:
    """The path of the axis of a fast top, unrolled, and the cycloid that approximates it.

    Goldstein, *Classical Mechanics*, § 5.7; Ercan 2016, fig. 16 and eqs. (65)-(68): monotone, cusp
    or loop as ``|omega_P - omega_0|`` is below, at or above ``omega_P``.

    Parameters
    ----------
    scene : HeavyTop
        A Lagrange top with weight.
    tilt : float
        Tilt at the start (rad), a turning point.
    spin : float
        Rate about the body axis through the centre of mass (rad/s), not zero.
    pushes : array_like, shape (k,)
        Rates of precession at the start, in units of ``omega_P = mgl / (I3 omega3)``: 0 for a top
        released from rest, 1 for steady precession, less than 0 for loops.
    periods : float
        Duration, in periods of the nutation to first order.
    samples : int
        Number of times.

    Returns
    -------
    Picture
        Paths of the axis of a fast top, unrolled, and the cycloids that approximate them.

        t : ndarray, shape (m,)
            Times (s).
        kind : ndarray of str, shape (k,)
            Kind of the cycloid, from :func:`rigid.top.fast_top_approx`.
        tilt : float
            At the start (rad).
        precession : ndarray, shape (k,)
            Rates at the start (rad/s).
        phi, theta : ndarray, shape (k, m)
            Azimuth relative to the start and tilt (rad), by closed form.
        phi_approx, theta_approx : ndarray, shape (k, m)
            Azimuth and tilt to first order in the amplitude.

    Raises
    ------
    ValueError
        If the top is not symmetric, torque or damping acts, the spin is zero, or an argument is out
        of range.

    Examples
    --------
    >>> import rigid
    >>> from rigid import figures
    >>> scene = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)
    >>> figures.cycloids(scene, 1.0, 40.0).kind.tolist()
    ['monotone', 'cusp', 'loop']
    """
    require_unforced(check_heavy_top(scene), "a picture of cycloids")
    angle = finite_float("tilt", tilt)
    rate = finite_float("spin", spin)
    shares = shaped("pushes", pushes, None)
    if shares.ndim != 1:
        raise ValueError(f"pushes: expected shape (k,), got {shares.shape}")
    mean = top.fast_top_approx(scene, angle, rate)
    length = finite_float("periods", periods, positive=True) * 2.0 * np.pi / abs(mean.nutation)
    t = np.linspace(0.0, length, positive_int("samples", samples, minimum=2))
    precession = shares * mean.mean_precession
    found: Any = top.fast_top_approx(scene, angle, rate, precession=precession, t=t)
    attitude, omega = _turning_point(scene, angle, rate, precession)
    path = top.locus(scene, omega, attitude, t=t)
    return Picture(
        _draw_cycloids,
        panels=["plane"] * len(shares),
        columns=1,
        panel_size=(7.0, 2.2),
        t=t,
        kind=np.asarray(found.kind),
        tilt=angle,
        precession=precession,
        phi=path.phi - path.phi[:, :1],
        theta=path.theta,
        phi_approx=found.phi,
        theta_approx=found.theta,
    )


def _turning_point(
    scene: HeavyTop, tilt: float, spin: float, precession: Floats
) -> tuple[Floats, Floats]:
    """Attitude (4,) with the node line along the first axis of space, and rates (k, 3)."""
    com = np.array(scene.com)
    matrix = rotation_x(tilt) @ np.stack(across(com))
    along = matrix @ com
    side = float(np.sign(com.sum()))
    about = side * spin - precession * along[2]
    rates = precession[:, np.newaxis] * draw.UP + about[:, np.newaxis] * along
    return matrix_to_quaternion(matrix), rates @ matrix
