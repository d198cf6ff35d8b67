"""The heights and tilts that a symmetric top reaches: its effective potential and its cubics."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import top
from .._checks.arguments import vector
from ..drawing import colours
from ..drawing.axes3d import BELOW, KEY, curve, dots, label
from ..drawing.colours import on_ground
from ..model.scene import HeavyTop, check_heavy_top, require_unforced
from .picture import Picture

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

Floats = NDArray[np.float64]

UPRIGHT = [1.0, 0.0, 0.0, 0.0]


def _draw_effective_potential(data: Picture, ax: Any) -> None:
    blue, level_colour = colours.HUES["blue"], colours.HUES["vermilion"]
    well_curve = np.stack([np.degrees(data.tilt), data.potential], axis=1)
    curve(ax, well_curve, blue, linewidth=1.8, gid="potential")
    ends = np.degrees([data.theta_upper, data.theta_lower])
    level = np.stack([ends, np.full(2, data.E_prime)], axis=1)
    curve(ax, level, level_colour, linewidth=1.8, gid="E_prime")
    ax.axhline(
        data.E_prime,
        color=on_ground(ax, level_colour),
        linewidth=0.8,
        linestyle="dashed",
        zorder=1,
    )
    turning = dots(ax, level, level_colour, markersize=6, gid="turning")
    bottom = np.array([np.degrees(data.theta_steady), data.lowest])
    steady = dots(ax, bottom, blue, markersize=6, gid="lowest")

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
        drop = np.array([[place, low], [place, value]])
        curve(ax, drop, colours.FAINT, linewidth=0.9, zorder=1)
        # Outside the well, but inside the axes.
        room = 0.12 * wide
        left = (first + room < place and theta < data.theta_steady) or place >= last - room
        beside = np.array([place + 0.01 * wide * (-1 if left else 1), low + share * (high - low)])
        label(ax, beside, name, ha="right" if left else "left")
    # Write the names beside the lines, outside the well, on the side that has room.
    right = well[-1] + margin <= 180.0 or well[0] - margin < 0.0
    end = last - 0.03 * wide if right else first + 0.03 * wide
    label(ax, np.array([end, data.E_prime]), "$E'$", level_colour, va="bottom")
    near = low + 0.88 * (high - low)
    seen = np.flatnonzero(data.potential <= max(near, data.potential.min()))
    place, off, side = (seen[-1], 0.02, "left") if right else (seen[0], -0.02, "right")
    across = np.degrees(data.tilt[place]) + off * wide
    beside = np.array([across, np.minimum(data.potential[place], near)])
    label(ax, beside, r"$V'(\theta)$", blue, ha=side, va="top")
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
    ax.legend(handles=[turning, steady], labels=names, **BELOW)


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
        label(ax, np.array([seen[2], 0.07 * depth]), "$u_3$", ha="right")

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
    points = np.stack([data.allowed, data.f_allowed], axis=1)
    allowed = curve(close, points, red, linewidth=2.4, gid="allowed")
    handles, names = [allowed], ["the top moves from $u_1$ to $u_2$"]
    if data.near[0] < data.still < data.near[-1]:
        still = close.axvline(
            data.still,
            color=on_ground(close, black),
            linewidth=1.0,
            linestyle="dashed",
            zorder=2,
            gid="still",
        )
        label(close, np.array([data.still, 0.85 * unit]), "$a/b$", black)
        handles.append(still)
        names.append(r"$u = a/b$: no precession; $a = p_\phi/I_1$, $b = p_\psi/I_1$")
    if seen[1] - seen[0] < 1e-3:
        label(close, np.array([seen[0], 0.25 * unit]), "$u_1 = u_2$")
    else:
        # Between the roots the curve is above their names.
        for place, name, align in ((seen[0], "$u_1$", "left"), (seen[1], "$u_2$", "right")):
            label(close, np.array([place, -0.2 * unit]), name, ha=align)
    if len(seen) == 3:
        handles.append(roots)
        names.append("$u_1$, $u_2$, $u_3$: roots of $f$; the top never reaches $u_3$")
    ax.legend(handles=handles, labels=names, **BELOW)


FARTHEST = 4.0
"""A third root beyond this height is not drawn, because the other roots would be invisible."""


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
    curve(ax, np.stack([u, f], axis=1), colours.HUES["blue"], linewidth=1.6, gid=name)
    ax.axhline(0.0, color=on_ground(ax, colours.NEUTRAL), linewidth=0.8, zorder=1)
    points = np.stack([roots, np.zeros_like(roots)], axis=1)
    return dots(ax, points, colours.HUES["vermilion"], markersize=5, zorder=4, gid="roots")


def _draw_upright_cubic(data: Picture, *places: Any) -> None:
    blue, orange = colours.HUES["blue"], colours.HUES["orange"]
    size = 1.15 * max(np.abs(data.exact).max(), np.abs(data.approximate).max())
    for k, ax in enumerate(places):
        positive = np.maximum(data.exact[k], 0.0)
        reached = ax.fill_between(
            data.u, positive, color=on_ground(ax, blue), alpha=0.2, linewidth=0.0
        )
        ax.axhline(0.0, color=on_ground(ax, colours.NEUTRAL), linewidth=0.8, zorder=1)
        near = np.stack([data.u, data.approximate[k]], axis=1)
        style: dict[str, Any] = {"linestyle": "dashed", "linewidth": 1.6, "gid": "approximate"}
        approximate = curve(ax, near, orange, **style)
        true = np.stack([data.u, data.exact[k]], axis=1)
        exact = curve(ax, true, blue, linewidth=1.8, gid="exact")
        upright = np.array([1.0, 0.0])
        dots(ax, upright, colours.HUES["black"], markersize=5, clip_on=False, zorder=5)
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
        **KEY,
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
