"""The path of the axis of a top: on the unit sphere, and unrolled as a cycloid."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import exact, top
from .._check import finite_float, positive_int, rows, sorted_times, stack, vector
from .._given import attitudes
from .._shown import undriven
from ..euler import rotation_x
from ..quaternions import matrix_to_quaternion
from ..scenes import HeavyTop
from ..solidshapes import across, ellipsoid_faces
from . import colours
from ._draw import arrow, circle, curve, fit, in_space, panels
from ._sides import eye, sides, surface

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

__all__ = [
    "Cycloids",
    "CycloidsArtists",
    "Locus",
    "LocusArtists",
    "cycloids",
    "cycloids_data",
    "loci",
    "locus",
    "locus_data",
]

Floats = NDArray[np.float64]

ELEV, AZIM = 24.0, -60.0
UP = np.array([0.0, 0.0, 1.0])
UPRIGHT = [1.0, 0.0, 0.0, 0.0]

WORDS = {
    "prolate": "loops",
    "cusp": "cusps",
    "curtate": "monotone",
    "retrograde": "against the spin",
    "steady": "steady precession",
}
"""Kinds of paths as a title says them."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Locus:
    """The path of the axis of a top on the unit sphere.

    Attributes
    ----------
    kind : str
        That of :func:`rigid.top.classify_locus`; ``"general"`` for a top without a symmetry or
        under torque or damping.
    t : ndarray, shape (m,)
        Times (s).
    point : ndarray, shape (m, 3)
        Unit vector to the centre of mass in space.
    theta, phi : ndarray, shape (m,)
        Its tilt, and the azimuth of the node line (rad).
    theta_upper, theta_lower : float or None
        Tilts of the circles between which the axis moves (rad); None of a general one.
    """

    kind: str
    t: Floats
    point: Floats
    theta: Floats
    phi: Floats
    theta_upper: float | None
    theta_lower: float | None


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LocusArtists:
    """What :func:`locus` has drawn.

    Attributes
    ----------
    ax : Axes3D
        Where.
    data : Locus
        What.
    seen, hidden : Line3D
        The path on this side of the sphere, and behind it.
    circles : tuple of Line3D
        The parts of the upper and of the lower circle on this side; none of a general top.
    start : Line3D
        The point at the first time.
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
    """The numbers under :func:`locus`.

    Parameters
    ----------
    scene : HeavyTop
        Any heavy top.
    omega : array_like, shape (3,)
        Angular velocity in the body at ``t = 0`` (rad/s).
    attitude : array_like, shape (4,), or scipy Rotation, optional
        Attitude at ``t = 0``; by default body and space axes coincide.
    t : array_like, shape (m,), optional
        Times (s), ascending. Default: ``samples`` of them, as long as the axis of a symmetric top
        takes to go around the vertical once, but four nutations or more.
    samples : int
        Their number.

    Returns
    -------
    Locus

    Raises
    ------
    ValueError
        If there are no times for a top that has no period, or the state is not finite.

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
        kind = str(top.classify_locus(scene, rates, attitude))
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
        t=times,
        point=path.point,
        theta=path.theta,
        phi=path.phi,
        theta_upper=upper,
        theta_lower=lower,
    )


def _motion(scene: HeavyTop, omega: Floats, attitude: Floats | None) -> exact.TopMotion | None:
    """The motion of a Lagrange top; None of others."""
    if not isinstance(scene, HeavyTop):
        raise TypeError(f"scene = {scene!r}: must be a rigid.HeavyTop")
    if scene.outside is not None or scene.mgl == 0.0:
        return None
    if top.heavy_constants(scene, omega, UPRIGHT).a is None:
        return None
    return exact.lagrange_top(scene, omega, attitude)


def _once_around(motion: exact.TopMotion) -> float:
    """The time of a turn about the vertical, but no shorter than four nutations."""
    period, rate = float(motion.period), abs(float(motion.precession))
    turn = 2.0 * np.pi / rate if rate > 0.0 else 0.0
    return max(turn, 4.0 * period) if np.isfinite(period) else turn


def locus(
    scene: HeavyTop,
    omega: ArrayLike,
    attitude: ArrayLike | Rotation | None = None,
    *,
    t: ArrayLike | None = None,
    ax: Any | None = None,
) -> LocusArtists:
    """Draw the path of the axis of a top on the unit sphere, between its two circles.

    Landau and Lifshitz, *Mechanics*, § 35; Ercan 2016, fig. 16; lecture notes, fig. 5.5. The spin
    takes no part in it.

    Parameters
    ----------
    scene, omega, attitude, t
        As in :func:`locus_data`.
    ax : Axes3D, optional
        Where to draw; by default on a new figure that pyplot does not know.

    Returns
    -------
    LocusArtists

    Raises
    ------
    ValueError
        As in :func:`locus_data`, and if the axes are not three-dimensional.
    ImportError
        Without matplotlib.

    Examples
    --------
    >>> import numpy as np, rigid
    >>> from rigid import figures
    >>> scene = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)
    >>> tilted = [np.cos(np.pi / 6), np.sin(np.pi / 6), 0.0, 0.0]
    >>> drawn = figures.locus(scene, [0.0, 0.0, 5.0], tilted)
    >>> drawn.ax.figure.savefig("locus.png")  # doctest: +SKIP
    """
    data = locus_data(scene, omega, attitude, t=t)
    ax = in_space(ax)
    towards = eye(ELEV, AZIM)
    faces = ellipsoid_faces(np.ones(3), rings=24, sectors=48)
    sphere = surface(ax, faces, "#f2f2f2", towards)
    curve(ax, circle(np.zeros(3), towards, 1.0), colours.FAINT, linewidth=1.0, zorder=2)
    red, blue = colours.HUES["vermilion"], colours.HUES["blue"]
    circles = []
    for theta, name in ((data.theta_upper, "upper"), (data.theta_lower, "lower")):
        if theta is not None:
            ring = circle(np.cos(theta) * UP, UP, float(np.sin(theta)))
            near, far = sides(ring, ring, towards)
            circles.append(curve(ax, near, blue, linewidth=1.0, zorder=3, label=name))
            curve(ax, far, blue, linewidth=0.6, linestyle="dotted", zorder=2)
    near, far = sides(data.point, data.point, towards)
    hidden = curve(ax, far, red, linewidth=0.8, alpha=0.45, zorder=2)
    seen = curve(ax, near, red, linewidth=1.8, zorder=4)
    (start,) = ax.plot(*data.point[:1].T, "o", color=red, markersize=5, zorder=5)
    arrow(ax, 0.35 * UP, colours.VERTICAL.colour, colours.VERTICAL.label, start=UP, linewidth=1.4)
    fit(ax, faces, 1.4 * UP, elev=ELEV, azim=AZIM)
    return LocusArtists(
        ax=ax,
        data=data,
        seen=seen,
        hidden=hidden,
        circles=tuple(circles),
        start=start,
        sphere=sphere,
    )


def loci(
    scene: HeavyTop,
    omega: ArrayLike,
    attitude: ArrayLike | Rotation | None = None,
    *,
    axes: Sequence[Any] | None = None,
) -> tuple[LocusArtists, ...]:
    """Draw the paths of several starts side by side, each with its kind.

    Loops, cusps, a monotone path and, what the lecture notes leave out (erratum G-18), one that is
    against the spin throughout.

    Parameters
    ----------
    scene : HeavyTop
        Any heavy top whose axis has a period.
    omega : array_like, shape (n, 3)
        Angular velocities in the body at ``t = 0`` (rad/s).
    attitude : array_like, shape (4,) or (n, 4), or scipy Rotation, optional
        Attitudes at ``t = 0``; by default body and space axes coincide.
    axes : sequence of n Axes3D, optional
        Where to draw; by default on a new figure that pyplot does not know, in two columns.

    Returns
    -------
    tuple of n LocusArtists

    Raises
    ------
    ValueError
        As in :func:`locus_data`, and if there are not n axes.
    ImportError
        Without matplotlib.

    Examples
    --------
    >>> import numpy as np, rigid
    >>> from rigid import figures
    >>> scene = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)
    >>> tilted = [np.cos(np.pi / 6), np.sin(np.pi / 6), 0.0, 0.0]
    >>> drawn = figures.loci(scene, [[0.0, -0.26, 5.0], [0.0, 0.0, 5.0]], tilted)
    >>> [one.data.kind for one in drawn]
    ['prolate', 'cusp']
    """
    rates, _ = rows("omega", omega, 3)
    start = np.array(UPRIGHT) if attitude is None else attitudes(attitude)
    if start.shape not in ((4,), (len(rates), 4)):
        raise ValueError(f"attitude: expected shape (4,) or {(len(rates), 4)}, got {start.shape}")
    starts = np.broadcast_to(start, (len(rates), 4))
    places = panels(axes, ["space"] * len(rates), columns=min(2, len(rates)))
    drawn = []
    for ax, one, quaternion in zip(places, rates, starts, strict=True):
        drawn.append(locus(scene, one, quaternion, ax=ax))
        ax.set_title(WORDS.get(drawn[-1].data.kind, drawn[-1].data.kind), fontsize="medium")
    return tuple(drawn)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Cycloids:
    """Paths of the axis of a fast top, unrolled, and the cycloids that they come near.

    Attributes
    ----------
    t : ndarray, shape (m,)
        Times (s).
    kind : ndarray of str, shape (k,)
        Of the cycloid: that of :func:`rigid.top.fast_top_approx`.
    tilt : float
        At the start (rad).
    precession : ndarray, shape (k,)
        Rates at the start (rad/s).
    phi, theta : ndarray, shape (k, m)
        Azimuth from the start and tilt by closed form (rad).
    phi_approx, theta_approx : ndarray, shape (k, m)
        The same to first order in the amplitude.
    """

    t: Floats
    kind: NDArray[np.str_]
    tilt: float
    precession: Floats
    phi: Floats
    theta: Floats
    phi_approx: Floats
    theta_approx: Floats


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CycloidsArtists:
    """What :func:`cycloids` has drawn.

    Attributes
    ----------
    axes : tuple of k Axes
        Where.
    data : Cycloids
        What.
    exact, approximate : tuple of k Line2D
        The paths and the cycloids.
    """

    axes: tuple[Any, ...]
    data: Cycloids
    exact: tuple[Any, ...]
    approximate: tuple[Any, ...]


def cycloids_data(
    scene: HeavyTop,
    tilt: float,
    spin: float,
    *,
    pushes: ArrayLike = (0.5, 0.0, -1.0),
    periods: float = 4.0,
    samples: int = 801,
) -> Cycloids:
    """The numbers under :func:`cycloids`.

    Parameters
    ----------
    scene : HeavyTop
        A Lagrange top with weight.
    tilt : float
        Tilt at the start (rad), a turning point.
    spin : float
        Rate about the body axis that the centre of mass lies on (rad/s), not zero.
    pushes : array_like, shape (k,)
        Rates of precession at the start, in units of ``omega_P = mgl / (I3 omega3)``: 0 for a top
        that is let go, 1 for one that goes on steadily, and less than 0 for loops.
    periods : float
        Length, in periods of the nutation to first order.
    samples : int
        Number of times.

    Returns
    -------
    Cycloids

    Raises
    ------
    ValueError
        If the top is not symmetric or not left to itself, has no spin, or an argument is out of
        range.

    Examples
    --------
    >>> import rigid
    >>> from rigid import figures
    >>> scene = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)
    >>> figures.cycloids_data(scene, 1.0, 40.0).kind.tolist()
    ['curtate', 'cusp', 'prolate']
    """
    undriven(scene, "cycloids")
    angle = finite_float("tilt", tilt)
    rate = finite_float("spin", spin)
    shares = stack("pushes", pushes, None)
    if shares.ndim != 1:
        raise ValueError(f"pushes: expected shape (k,), got {shares.shape}")
    mean = top.fast_top_approx(scene, angle, rate)
    length = finite_float("periods", periods, positive=True) * 2.0 * np.pi / abs(mean.nutation)
    t = np.linspace(0.0, length, positive_int("samples", samples, minimum=2))
    precession = shares * mean.mean_precession
    found = top.fast_top_approx(scene, angle, rate, precession=precession, t=t)
    assert found.phi is not None
    assert found.theta is not None
    attitude, omega = _turning_point(scene, angle, rate, precession)
    path = top.locus(scene, omega, attitude, t=t)
    return Cycloids(
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
    rates = precession[:, np.newaxis] * UP + about[:, np.newaxis] * along
    return matrix_to_quaternion(matrix), rates @ matrix


def cycloids(
    scene: HeavyTop,
    tilt: float,
    spin: float,
    *,
    pushes: ArrayLike = (0.5, 0.0, -1.0),
    periods: float = 4.0,
    axes: Sequence[Any] | None = None,
) -> CycloidsArtists:
    """Draw the path of the axis of a fast top, unrolled, and the cycloid that it comes near.

    Goldstein, *Classical Mechanics*, § 5.7; Ercan 2016, fig. 16 and eqs. (65)-(68): curtate, cusped
    or prolate as ``|omega_P - omega_0|`` is below, at or above ``omega_P``.

    Parameters
    ----------
    scene, tilt, spin, pushes, periods
        As in :func:`cycloids_data`.
    axes : sequence of k Axes, optional
        Where to draw; by default on a new figure that pyplot does not know, one above the other.

    Returns
    -------
    CycloidsArtists

    Raises
    ------
    ValueError
        As in :func:`cycloids_data`, and if there are not k axes.
    ImportError
        Without matplotlib.

    Examples
    --------
    >>> import rigid
    >>> from rigid import figures
    >>> scene = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)
    >>> drawn = figures.cycloids(scene, 1.0, 40.0)
    >>> drawn.axes[0].figure.savefig("cycloids.png")  # doctest: +SKIP
    """
    data = cycloids_data(scene, tilt, spin, pushes=pushes, periods=periods)
    places = panels(axes, ["plane"] * len(data.kind), columns=1)
    if axes is None and places:
        places[0].figure.set_size_inches(7.0, 2.2 * len(places))
    red, black = colours.HUES["vermilion"], colours.HUES["black"]
    scale = np.sin(data.tilt)
    exact_lines: list[Any] = []
    approximate: list[Any] = []
    for k, ax in enumerate(places):
        for phi, theta, lines, style in (
            (data.phi[k], data.theta[k], exact_lines, {"color": red, "linewidth": 1.8}),
            (
                data.phi_approx[k],
                data.theta_approx[k],
                approximate,
                {"color": black, "linewidth": 1.0, "linestyle": "dashed"},
            ),
        ):
            lines += ax.plot(np.degrees(scale * phi), np.degrees(theta), **style)
        ax.axhline(np.degrees(data.tilt), color=colours.FAINT, linewidth=0.8, zorder=1)
        ax.set_title(WORDS.get(str(data.kind[k]), str(data.kind[k])), fontsize="medium", loc="left")
        ax.set_aspect("equal", adjustable="datalim")
        ax.invert_yaxis()
        ax.set_ylabel(r"tilt $\theta$ (°)")
    if places:
        first_order = "dashed: the cycloid of first order"
        places[0].set_title(first_order, fontsize="small", loc="right")
        places[-1].set_xlabel(r"azimuth $\phi\,\sin\theta_0$ (°)")
    return CycloidsArtists(
        axes=tuple(places), data=data, exact=tuple(exact_lines), approximate=tuple(approximate)
    )
