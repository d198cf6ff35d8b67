"""The cubic of the height of a symmetric top, and of an upright top."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import top
from .._checks.arguments import vector
from ..drawing import colours
from ..drawing.axes3d import BELOW, KEY, curve, dots, label
from ..drawing.colours import on_ground
from ..model.scene import HeavyTop, check_heavy_top
from .picture import Kind, Picture
from .potential import constants_of

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation


Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Cubic(Picture):
    """The cubic ``u'² = f(u)`` of the height of a top.

    Attributes
    ----------
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
    """

    u: Floats
    f: Floats
    allowed: Floats
    f_allowed: Floats
    near: Floats
    f_near: Floats
    roots: Floats
    still: float

    def _kinds(self) -> list[Kind]:
        return ["plane"]

    def _draw(self, ax: Any) -> None:
        red, black = colours.HUES["vermilion"], colours.HUES["black"]
        seen = self.roots[self.roots <= self.u[-1]]
        roots = _with_roots(ax, self.u, self.f, seen, "f")
        ax.axvspan(
            -1.0, 1.0, color=on_ground(ax, colours.FAINT), alpha=0.2, linewidth=0.0, zorder=0
        )
        depth, highest = -self.f.min(), self.f_allowed.max()
        high = max(0.75 * depth, 1.4 * highest)
        ax.set(xlim=(self.u[0], self.u[-1]), ylim=(-1.08 * depth, high))
        ax.set(xlabel=r"height $u = \cos\theta$", ylabel=r"$f(u) = \dot u^2$ (1/s²)")
        if len(seen) == 3:
            label(ax, np.array([seen[2], 0.07 * depth]), "$u_3$", ha="right")

        close, unit = ax, high
        if highest < 0.2 * depth:
            close = ax.inset_axes((0.16, 0.62, 0.5, 0.3))
            close.xaxis.tick_top()  # below are the lines to its place
            _with_roots(close, self.near, self.f_near, seen[:2], "f_near")
            unit = max(1.6 * highest, 0.3 * -self.f_near.min())
            close.set(xlim=(self.near[0], self.near[-1]), ylim=(-0.5 * unit, unit))
            close.tick_params(labelsize="small")
            close.locator_params(nbins=4)
            ax.indicate_inset_zoom(close, edgecolor=on_ground(ax, colours.NEUTRAL))
        points = np.stack([self.allowed, self.f_allowed], axis=1)
        allowed = curve(close, points, red, linewidth=2.4, gid="allowed")
        handles, names = [allowed], ["the top moves from $u_1$ to $u_2$"]
        if self.near[0] < self.still < self.near[-1]:
            still = close.axvline(
                self.still,
                color=on_ground(close, black),
                linewidth=1.0,
                linestyle="dashed",
                zorder=2,
                gid="still",
            )
            label(close, np.array([self.still, 0.85 * unit]), "$a/b$", black)
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
) -> Cubic:
    """The cubic f(u) with its roots, and the heights between which the top nutates.

    The motion needs ``f >= 0`` and a height between -1 and 1. The precession reverses at
    ``u = a / b`` (lecture notes, fig. 5.4; a steady precession has a double root, erratum G-21).

    Parameters
    ----------
    scene, omega, attitude, samples
        As in :func:`rigid.figures.effective_potential`; each curve has ``samples`` points.

    Returns
    -------
    Cubic

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
    constants = constants_of(scene, omega, attitude)
    del constants["E_prime"]
    found = top.f_roots(**constants)
    roots = np.array([found.u1, found.u2, found.u3])
    end = roots[2] if roots[2] <= FARTHEST else 1.0
    u = np.linspace(-1.2, end + 0.06 * (end + 1.2), samples)
    allowed = np.linspace(roots[0], roots[1], samples)
    beyond = 0.25 * max(roots[1] - roots[0], 0.05)
    near = np.linspace(roots[0] - beyond, roots[1] + beyond, samples)
    return Cubic(
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


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class UprightCubic(Picture):
    """The cubic of an upright top near the vertical.

    Attributes
    ----------
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
    """

    spin: Floats
    spin_min: float
    u: Floats
    exact: Floats
    approximate: Floats
    stable: NDArray[np.bool_]

    def _kinds(self) -> list[Kind]:
        return ["plane"] * 3

    def _draw(self, *places: Any) -> None:
        blue, orange = colours.HUES["blue"], colours.HUES["orange"]
        size = 1.15 * max(np.abs(self.exact).max(), np.abs(self.approximate).max())
        for k, ax in enumerate(places):
            positive = np.maximum(self.exact[k], 0.0)
            reached = ax.fill_between(
                self.u, positive, color=on_ground(ax, blue), alpha=0.2, linewidth=0.0
            )
            ax.axhline(0.0, color=on_ground(ax, colours.NEUTRAL), linewidth=0.8, zorder=1)
            near = np.stack([self.u, self.approximate[k]], axis=1)
            style: dict[str, Any] = {"linestyle": "dashed", "linewidth": 1.6, "gid": "approximate"}
            approximate = curve(ax, near, orange, **style)
            true = np.stack([self.u, self.exact[k]], axis=1)
            exact = curve(ax, true, blue, linewidth=1.8, gid="exact")
            upright = np.array([1.0, 0.0])
            dots(ax, upright, colours.HUES["black"], markersize=5, clip_on=False, zorder=5)
            share = self.spin[k] / self.spin_min
            words = "sleeps" if self.stable[k] else "falls"
            ax.set_title(f"spin {share:.3g} × the least: {words}", fontsize="medium")
            ax.set(xlim=(self.u[0], 1.0), ylim=(-size, size), xlabel=r"height $u = \cos\theta$")
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
) -> UprightCubic:
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
    UprightCubic

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
    return UprightCubic(
        spin=spin,
        spin_min=bound,
        u=u,
        exact=exact,
        approximate=approximate,
        stable=top.sleeping_top(scene, spin).stable,
    )
