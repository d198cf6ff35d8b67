"""The path of the axis of a top on the unit sphere."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import exact, top
from .._checks.arguments import finite_float, positive_int, rows, sorted_times, vector
from .._checks.arrays import attitudes
from ..drawing import colours
from ..drawing.axes3d import arrow, circle, curve, fit, in_space, label, panels
from ..drawing.colours import on_ground
from ..drawing.shapes import ellipsoid_faces
from ..drawing.sides import eye, sides, surface
from ..model.scene import HeavyTop, check_heavy_top
from ..rotations.euler import rotation_z

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

__all__ = [
    "Locus",
    "LocusArtists",
    "loci",
    "locus",
    "locus_data",
]

Floats = NDArray[np.float64]

ELEV, AZIM = 24.0, -60.0
UP = np.array([0.0, 0.0, 1.0])
UPRIGHT = [1.0, 0.0, 0.0, 0.0]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Locus:
    """The path of the axis of a top on the unit sphere.

    Attributes
    ----------
    kind : str
        Kind of path, as in :func:`rigid.top.classify_locus`; ``"general"`` for a top that is not
        symmetric or is under torque or damping.
    retrograde : bool
        Whether the mean precession is against the spin.
    t : ndarray, shape (m,)
        Times (s).
    point : ndarray, shape (m, 3)
        Unit vector to the centre of mass in space.
    theta, phi : ndarray, shape (m,)
        Tilt of the axis, and azimuth of the node line (rad).
    theta_upper, theta_lower : float or None
        Tilts of the circles between which the axis moves (rad); None for the kind ``"general"``.
    """

    kind: str
    retrograde: bool
    t: Floats
    point: Floats
    theta: Floats
    phi: Floats
    theta_upper: float | None
    theta_lower: float | None


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LocusArtists:
    """Artists of the figure :func:`locus`.

    Attributes
    ----------
    ax : Axes3D
        Axes of the figure.
    data : Locus
        Data of the figure.
    seen, hidden : Line3D
        The path on the visible and on the hidden side of the sphere.
    circles : tuple of Line3D
        The visible parts of the upper and of the lower circle; empty for the kind ``"general"``.
    start : Line3D
        The end of the axis at the first time.
    sphere : Poly3DCollection
        The unit sphere.
    """

    ax: Any
    data: Locus
    seen: Any
    hidden: Any
    circles: tuple[Any, ...]
    start: Any
    sphere: Any


def locus_data(
    scene: HeavyTop,
    omega: ArrayLike,
    attitude: ArrayLike | Rotation | None = None,
    *,
    t: ArrayLike | None = None,
    samples: int = 1201,
) -> Locus:
    """Data of the figure :func:`locus`.

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

    Returns
    -------
    Locus

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
    >>> figures.locus_data(scene, [0.0, 0.0, 5.0], tilted).kind
    'cusp'
    """
    rates = vector("omega", omega, 3)
    if attitude is not None:
        attitude = attitudes(attitude)
        if attitude.shape != (4,):
            raise ValueError(f"attitude: expected shape (4,), got {attitude.shape}")
    motion = _motion(scene, rates, attitude)
    kind, upper, lower = "general", None, None
    if motion is not None:
        kind = str(motion.kind)
        upper, lower = float(motion.tilt_min), float(motion.tilt_max)
    if t is None:
        length = 0.0 if motion is None else _once_around(motion)
        if not 0.0 < length < np.inf:
            raise ValueError(f"t = None: the axis of this top has no period ({kind}), give times")
        t = np.linspace(0.0, length, positive_int("samples", samples, minimum=2))
    times = sorted_times("t", t)
    path = top.locus(scene, rates, attitude, t=times)
    return Locus(
        kind=kind,
        retrograde=motion is not None and bool(motion.retrograde),
        t=times,
        point=path.point,
        theta=path.theta,
        phi=path.phi,
        theta_upper=upper,
        theta_lower=lower,
    )


def _motion(scene: HeavyTop, omega: Floats, attitude: Floats | None) -> exact.TopMotion | None:
    """The motion of a Lagrange top; None for other tops."""
    check_heavy_top(scene)
    if scene.forces or scene.mgl == 0.0:
        return None
    if top.heavy_constants(scene, omega, UPRIGHT).a is None:
        return None
    return exact.lagrange_top(scene, omega, attitude)


def _once_around(motion: exact.TopMotion) -> float:
    """The time of a turn about the vertical, but at least four nutations."""
    period, rate = float(motion.period), abs(float(motion.precession))
    turn = 2.0 * np.pi / rate if rate > 0.0 else 0.0
    return max(turn, 4.0 * period) if np.isfinite(period) else turn


def locus(
    scene: HeavyTop,
    omega: ArrayLike,
    attitude: ArrayLike | Rotation | None = None,
    *,
    t: ArrayLike | None = None,
    elev: float = ELEV,
    ax: Any | None = None,
) -> LocusArtists:
    """Draw the path of the axis of a top on the unit sphere, between its two circles.

    Landau and Lifshitz, *Mechanics*, § 35; Ercan 2016, fig. 16; lecture notes, fig. 5.5. The figure
    does not show the spin.

    Parameters
    ----------
    scene, omega, attitude, t
        As in :func:`locus_data`.
    elev : float
        Elevation of the viewer (degrees). From as many degrees as the lower circle is tilted, the
        whole path is on the visible side.
    ax : Axes3D, optional
        Axes to draw on; by default the axes of a new figure.

    Returns
    -------
    LocusArtists

    Raises
    ------
    ValueError
        As in :func:`locus_data`, and if the axes are not three-dimensional.
    ImportError
        If Matplotlib is not installed.

    Examples
    --------
    >>> import numpy as np, rigid
    >>> from rigid import figures
    >>> scene = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)
    >>> tilted = [np.cos(np.pi / 6), np.sin(np.pi / 6), 0.0, 0.0]
    >>> drawn = figures.locus(scene, [0.0, 0.0, 5.0], tilted)
    >>> drawn.ax.figure.savefig("locus.png")  # doctest: +SKIP
    """
    elevation = finite_float("elev", elev)
    data = locus_data(scene, omega, attitude, t=t)
    ax = in_space(ax)
    towards = eye(elevation, AZIM)
    faces = ellipsoid_faces(np.ones(3), rings=24, sectors=48)
    sphere = surface(ax, faces, colours.SURFACE, towards)
    curve(ax, circle(np.zeros(3), towards, 1.0), colours.FAINT, linewidth=1.0, zorder=2)
    red, blue = colours.HUES["vermilion"], colours.HUES["blue"]
    circles = []
    upper, lower = data.theta_upper, data.theta_lower
    if upper is not None and lower is not None:
        gap = (np.cos(upper) - np.cos(lower)) * np.cos(np.radians(elevation))
        for theta, name, align in ((upper, "upper", "bottom"), (lower, "lower", "top")):
            ring = circle(np.cos(theta) * UP, UP, float(np.sin(theta)))
            near, far = sides(ring, ring, towards)
            circles.append(curve(ax, near, blue, linewidth=1.0, zorder=3, label=name))
            curve(ax, far, blue, linewidth=0.6, linestyle="dotted", zorder=2)
            _name_circle(ax, ring, name, blue, towards, "center" if gap > 0.1 else align)
    near, far = sides(data.point, data.point, towards)
    hidden = curve(ax, far, red, linewidth=0.8, alpha=0.45, zorder=2)
    seen = curve(ax, near, red, linewidth=1.8, zorder=4)
    (start,) = ax.plot(*data.point[:1].T, "o", color=on_ground(ax, red), markersize=5, zorder=5)
    arrow(ax, 0.35 * UP, colours.VERTICAL.colour, colours.VERTICAL.label, start=UP, linewidth=1.4)
    fit(ax, faces, 1.4 * UP, elev=elevation, azim=AZIM)
    return LocusArtists(
        ax=ax,
        data=data,
        seen=seen,
        hidden=hidden,
        circles=tuple(circles),
        start=start,
        sphere=sphere,
    )


def _name_circle(
    ax: Any, ring: Floats, name: str, colour: str, towards: Floats, align: str
) -> None:
    """Name a circle beside the sphere."""
    right = rotation_z(np.radians(AZIM))[:, 1]
    page_up = np.cross(towards, right)
    end = ring[np.argmax(ring @ right)]
    # The edge of the sphere at this height on the page.
    height = float(end @ page_up)
    place = np.sqrt(max(1.0 - height**2, 0.0)) * right + height * page_up
    curve(ax, np.array([end, place + 0.04 * right]), colour, linewidth=0.5, zorder=3)
    text = f"  $\\theta_\\mathrm{{{name}}}$"
    label(ax, place, text, colour, fontsize="medium", ha="left", va=align)


def loci(
    scene: HeavyTop,
    omega: ArrayLike,
    attitude: ArrayLike | Rotation | None = None,
    *,
    axes: Sequence[Any] | None = None,
) -> tuple[LocusArtists, ...]:
    """Draw the paths of several starts side by side, each with its kind.

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
    axes : sequence of n Axes3D, optional
        Axes to draw on; by default the axes of a new figure with two columns.

    Returns
    -------
    tuple of n LocusArtists

    Raises
    ------
    ValueError
        As in :func:`locus_data`, and if there are not n axes.
    ImportError
        If Matplotlib is not installed.

    Examples
    --------
    >>> import numpy as np, rigid
    >>> from rigid import figures
    >>> scene = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)
    >>> tilted = [np.cos(np.pi / 6), np.sin(np.pi / 6), 0.0, 0.0]
    >>> drawn = figures.loci(scene, [[0.0, -0.26, 5.0], [0.0, 0.0, 5.0]], tilted)
    >>> [one.data.kind for one in drawn]
    ['loop', 'cusp']
    """
    rates, _ = rows("omega", omega, 3)
    start = attitudes(attitude)
    if start.shape not in ((4,), (len(rates), 4)):
        raise ValueError(f"attitude: expected shape (4,) or {(len(rates), 4)}, got {start.shape}")
    starts = np.broadcast_to(start, (len(rates), 4))
    places = panels(axes, ["space"] * len(rates), columns=min(2, len(rates)))
    drawn = []
    for ax, one, quaternion in zip(places, rates, starts, strict=True):
        drawn.append(locus(scene, one, quaternion, ax=ax))
        data = drawn[-1].data
        title = f"{data.kind}, retrograde" if data.retrograde else data.kind
        ax.set_title(title, fontsize="medium")
    return tuple(drawn)
