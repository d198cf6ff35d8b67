"""The cubic of the height of a symmetric top, and that of an upright one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import top
from .._check import vector
from ..scenes import HeavyTop
from . import colours
from ._draw import in_plane, label_in_plane, panels
from .potential import constants_of

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

__all__ = [
    "Cubic",
    "CubicArtists",
    "UprightCubic",
    "UprightCubicArtists",
    "cubic",
    "cubic_data",
    "upright_cubic",
    "upright_cubic_data",
]

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Cubic:
    """The cubic ``u'² = f(u)`` of the height of a top.

    Attributes
    ----------
    u, f : ndarray, shape (m,)
        Heights from below -1 to beyond the third root, if that is not too far, and f there (1/s²).
    allowed, f_allowed : ndarray, shape (m,)
        The same from ``u1`` to ``u2``, between which the top nutates.
    near, f_near : ndarray, shape (m,)
        The same from a little below to a little above.
    roots : ndarray, shape (3,)
        ``u1 <= u2 <= 1 <= u3``, the last inf without weight.
    still : float
        ``a / b``, the height at which the precession reverses (inf without spin).
    """

    u: Floats
    f: Floats
    allowed: Floats
    f_allowed: Floats
    near: Floats
    f_near: Floats
    roots: Floats
    still: float


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CubicArtists:
    """What :func:`cubic` has drawn.

    Attributes
    ----------
    ax, close : Axes
        Where: all of the cubic, and the allowed heights within it; the same axes if these can be
        seen without.
    data : Cubic
        What.
    curve, roots : Line2D
        The cubic and the points at the roots in sight.
    allowed : Line2D
        The positive part between -1 and 1, in the closer axes.
    still : Line2D or None
        The height of reversal, if it is in sight.
    """

    ax: Any
    close: Any
    data: Cubic
    curve: Any
    roots: Any
    allowed: Any
    still: Any | None


FARTHEST = 4.0
"""A third root beyond this height is not drawn: nothing else could be seen."""


def cubic_data(
    scene: HeavyTop,
    omega: ArrayLike,
    attitude: ArrayLike | Rotation | None = None,
    *,
    samples: int = 401,
) -> Cubic:
    """The numbers under :func:`cubic`.

    Parameters
    ----------
    scene, omega, attitude, samples
        As in :func:`rigid.figures.effective_potential_data`; ``samples`` of each curve.

    Returns
    -------
    Cubic

    Raises
    ------
    ValueError
        If the top is not symmetric or not left to itself, or the state is not finite.

    Examples
    --------
    >>> import numpy as np, rigid
    >>> from rigid import figures
    >>> scene = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)
    >>> tilted = [np.cos(np.pi / 6), np.sin(np.pi / 6), 0.0, 0.0]
    >>> data = figures.cubic_data(scene, [0.0, 0.0, 5.0], tilted)
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


def cubic(
    scene: HeavyTop,
    omega: ArrayLike,
    attitude: ArrayLike | Rotation | None = None,
    *,
    ax: Any | None = None,
) -> CubicArtists:
    """Draw the cubic f(u) with its roots, and the heights between which the top nutates.

    Motion needs ``f >= 0`` between -1 and 1; the precession reverses where ``u = a / b`` (lecture
    notes, fig. 5.4; a steady precession has a double root, erratum G-21).

    Parameters
    ----------
    scene, omega, attitude
        As in :func:`cubic_data`.
    ax : Axes, optional
        Where to draw; by default on a new figure that pyplot does not know.

    Returns
    -------
    CubicArtists

    Raises
    ------
    ValueError
        As in :func:`cubic_data`, and if the axes are not two-dimensional.
    ImportError
        Without matplotlib.

    Examples
    --------
    >>> import numpy as np, rigid
    >>> from rigid import figures
    >>> scene = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)
    >>> tilted = [np.cos(np.pi / 6), np.sin(np.pi / 6), 0.0, 0.0]
    >>> drawn = figures.cubic(scene, [0.0, 0.0, 5.0], tilted)
    >>> drawn.ax.figure.savefig("cubic.png")  # doctest: +SKIP
    """
    data = cubic_data(scene, omega, attitude)
    ax = in_plane(ax)
    blue, red, black = colours.HUES["blue"], colours.HUES["vermilion"], colours.HUES["black"]
    seen = data.roots[data.roots <= data.u[-1]]
    dots: dict[str, Any] = {"color": red, "marker": "o", "linestyle": "none", "markersize": 5}
    (curve,) = ax.plot(data.u, data.f, color=blue, linewidth=1.6)
    (roots,) = ax.plot(seen, np.zeros_like(seen), zorder=4, **dots)
    ax.axhline(0.0, color=colours.NEUTRAL, linewidth=0.8, zorder=1)
    ax.axvspan(-1.0, 1.0, color=colours.FAINT, alpha=0.2, linewidth=0.0, zorder=0)
    depth, highest = -data.f.min(), data.f_allowed.max()
    high = max(0.75 * depth, 1.4 * highest)
    ax.set(xlim=(data.u[0], data.u[-1]), ylim=(-1.08 * depth, high))
    ax.set(xlabel=r"height $u = \cos\theta$", ylabel=r"$f(u) = \dot u^2$ (1/s²)")
    if len(seen) == 3:
        label_in_plane(ax, np.array([seen[2], 0.07 * depth]), "$u_3$", ha="right")

    close, unit = ax, high
    if highest < 0.2 * depth:
        close = ax.inset_axes((0.16, 0.66, 0.5, 0.3))
        close.plot(data.near, data.f_near, color=blue, linewidth=1.6)
        close.plot(seen[:2], [0.0, 0.0], zorder=4, **dots)
        close.axhline(0.0, color=colours.NEUTRAL, linewidth=0.8, zorder=1)
        unit = max(1.6 * highest, 0.3 * -data.f_near.min())
        close.set(xlim=(data.near[0], data.near[-1]), ylim=(-0.5 * unit, unit))
        close.tick_params(labelsize="small")
        close.locator_params(nbins=4)
        ax.indicate_inset_zoom(close, edgecolor=colours.NEUTRAL)
    (allowed,) = close.plot(data.allowed, data.f_allowed, color=red, linewidth=2.4)
    still = None
    if data.near[0] < data.still < data.near[-1]:
        still = close.axvline(data.still, color=black, linewidth=1.0, linestyle="dashed", zorder=2)
        label_in_plane(close, np.array([data.still, 0.85 * unit]), "$a/b$", black)
    if seen[1] - seen[0] < 1e-3:
        label_in_plane(close, np.array([seen[0], 0.25 * unit]), "$u_1 = u_2$")
    else:
        for place, name in zip(seen, ("$u_1$", "$u_2$"), strict=False):
            label_in_plane(close, np.array([place, -0.18 * unit]), name)
    return CubicArtists(
        ax=ax,
        close=close,
        data=data,
        curve=curve,
        roots=roots,
        allowed=allowed,
        still=still,
    )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class UprightCubic:
    """The cubic of an upright top near the vertical.

    Attributes
    ----------
    spin : ndarray, shape (k,)
        Spins (rad/s).
    spin_min : float
        The least spin with which it sleeps (rad/s).
    u : ndarray, shape (m,)
        Heights.
    exact, approximate : ndarray, shape (k, m)
        ``f(u)`` and ``(1 - u)² (2 alpha - a²)`` (1/s²).
    stable : ndarray of bool, shape (k,)
        Whether it stays upright.
    """

    spin: Floats
    spin_min: float
    u: Floats
    exact: Floats
    approximate: Floats
    stable: NDArray[np.bool_]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class UprightCubicArtists:
    """What :func:`upright_cubic` has drawn.

    Attributes
    ----------
    axes : tuple of 3 Axes
        Where.
    data : UprightCubic
        What.
    exact, approximate : tuple of 3 Line2D
        The curves.
    """

    axes: tuple[Any, ...]
    data: UprightCubic
    exact: tuple[Any, ...]
    approximate: tuple[Any, ...]


def upright_cubic_data(
    scene: HeavyTop, spins: ArrayLike = (0.9, 1.0, 1.1), *, lowest: float = 0.6, samples: int = 301
) -> UprightCubic:
    """The numbers under :func:`upright_cubic`.

    Parameters
    ----------
    scene : HeavyTop
        A Lagrange top with weight.
    spins : array_like, shape (3,)
        In units of the least spin with which the top sleeps.
    lowest : float
        The lowest of the heights, which end at 1, the vertical.
    samples : int
        Their number.

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
    >>> figures.upright_cubic_data(scene).stable.tolist()
    [False, True, True]
    """
    shares = vector("spins", spins, 3)
    sleeping = top.sleeping_top(scene, 0.0)
    spin = shares * sleeping.spin_min
    u = np.linspace(lowest, 1.0, samples)
    exact, approximate = top.upright_f(scene, spin[:, np.newaxis], u)
    return UprightCubic(
        spin=spin,
        spin_min=sleeping.spin_min,
        u=u,
        exact=exact,
        approximate=approximate,
        stable=top.sleeping_top(scene, spin).stable,
    )


def upright_cubic(
    scene: HeavyTop,
    spins: ArrayLike = (0.9, 1.0, 1.1),
    *,
    axes: Sequence[Any] | None = None,
) -> UprightCubicArtists:
    """Draw f near the vertical of a top that spins below, at and above the bound of sleeping.

    Where f is positive the top can go. At the bound the approximation vanishes and says nothing;
    f itself, ``-alpha (1 - u)³``, is negative: the top sleeps (lecture notes, fig. 5.6; erratum
    G-19).

    Parameters
    ----------
    scene, spins
        As in :func:`upright_cubic_data`.
    axes : sequence of 3 Axes, optional
        Where to draw; by default on a new figure that pyplot does not know.

    Returns
    -------
    UprightCubicArtists

    Raises
    ------
    ValueError
        As in :func:`upright_cubic_data`, and if there are not three axes.
    ImportError
        Without matplotlib.

    Examples
    --------
    >>> import rigid
    >>> from rigid import figures
    >>> scene = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)
    >>> drawn = figures.upright_cubic(scene)
    >>> drawn.axes[0].figure.savefig("upright.png")  # doctest: +SKIP
    """
    data = upright_cubic_data(scene, spins)
    places = panels(axes, ["plane"] * 3, columns=3)
    blue, orange = colours.HUES["blue"], colours.HUES["orange"]
    size = 1.15 * max(np.abs(data.exact).max(), np.abs(data.approximate).max())
    exact, approximate = [], []
    for k, ax in enumerate(places):
        positive = np.maximum(data.exact[k], 0.0)
        ax.fill_between(data.u, positive, color=blue, alpha=0.2, linewidth=0.0)
        ax.axhline(0.0, color=colours.NEUTRAL, linewidth=0.8, zorder=1)
        approximate += ax.plot(
            data.u, data.approximate[k], color=orange, linestyle="dashed", linewidth=1.6
        )
        exact += ax.plot(data.u, data.exact[k], color=blue, linewidth=1.8)
        ax.plot(1.0, 0.0, "o", color=colours.HUES["black"], markersize=5, clip_on=False, zorder=5)
        share = data.spin[k] / data.spin_min
        words = "sleeps" if data.stable[k] else "falls"
        ax.set_title(f"spin {share:.3g} × the least: {words}", fontsize="medium")
        ax.set(xlim=(data.u[0], 1.0), ylim=(-size, size), xlabel=r"height $u = \cos\theta$")
        ax.locator_params(nbins=5)
    places[0].set_ylabel("$f(u)$ (1/s²)")
    left = data.u[0] + 0.05 * (1.0 - data.u[0])
    bold: dict[str, Any] = {"ha": "left", "fontsize": "medium"}
    label_in_plane(places[-1], np.array([left, 0.9 * size]), "$f(u)$", blue, **bold)
    nearby = r"$(1-u)^2(2\alpha-a^2)$"
    label_in_plane(places[-1], np.array([left, 0.72 * size]), nearby, orange, **bold)
    return UprightCubicArtists(
        axes=tuple(places), data=data, exact=tuple(exact), approximate=tuple(approximate)
    )
