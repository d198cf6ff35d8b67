"""The path of the axis of a top on the unit sphere, and unrolled as a cycloid."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import exact, top
from .._checks.arguments import finite_float, positive_int, rows, shaped, sorted_times, vector
from .._checks.arrays import attitudes
from ..drawing import colours
from ..drawing.axes3d import AZIM, UP, arrow, circle, curve, dots, eye, fit, label, sides, surface
from ..drawing.colours import on_ground
from ..drawing.shapes import across, ellipsoid_faces
from ..model.scene import HeavyTop, check_heavy_top, require_unforced
from ..rotations.euler import rotation_x, rotation_z
from ..rotations.quaternions import matrix_to_quaternion
from .picture import Picture

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

Floats = NDArray[np.float64]

ELEV = 24.0
UPRIGHT = [1.0, 0.0, 0.0, 0.0]


def _draw_locus(data: Picture, ax: Any) -> None:
    towards = eye(data.elev, AZIM)
    faces = ellipsoid_faces(np.ones(3), rings=24, sectors=48)
    surface(ax, faces, colours.SURFACE, towards, gid="sphere")
    curve(ax, circle(np.zeros(3), towards, 1.0), colours.FAINT, linewidth=1.0, zorder=2)
    red, blue = colours.HUES["vermilion"], colours.HUES["blue"]
    upper, lower = data.theta_upper, data.theta_lower
    if upper is not None and lower is not None:
        gap = (np.cos(upper) - np.cos(lower)) * np.cos(np.radians(data.elev))
        for theta, name, align in ((upper, "upper", "bottom"), (lower, "lower", "top")):
            ring = circle(np.cos(theta) * UP, UP, float(np.sin(theta)))
            near, far = sides(ring, ring, towards)
            gid = f"theta_{name}"
            curve(ax, near, blue, linewidth=1.0, zorder=3, gid=gid)
            dotted: dict[str, Any] = {"linewidth": 0.6, "linestyle": "dotted", "zorder": 2}
            curve(ax, far, blue, gid=f"{gid}_hidden", **dotted)
            _name_circle(ax, ring, name, blue, towards, "center" if gap > 0.1 else align)
    near, far = sides(data.point, data.point, towards)
    curve(ax, far, red, linewidth=0.8, alpha=0.45, zorder=2, gid="point_hidden")
    curve(ax, near, red, linewidth=1.8, zorder=4, gid="point")
    dots(ax, data.point[0], red, markersize=5, zorder=5, gid="start")
    up = colours.VERTICAL
    arrow(ax, 0.35 * UP, up.colour, up.label, start=UP, linewidth=1.4)
    fit(ax, faces, 1.4 * UP, elev=data.elev, azim=AZIM)


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
    rates, _ = rows("omega", omega, 3)
    start = attitudes(attitude)
    if start.shape not in ((4,), (len(rates), 4)):
        raise ValueError(f"attitude: expected shape (4,) or {(len(rates), 4)}, got {start.shape}")
    starts = np.broadcast_to(start, (len(rates), 4))
    paths = (locus(scene, one, other) for one, other in zip(rates, starts, strict=True))
    return Picture(_draw_loci, panels=["space"] * len(rates), columns=2, paths=tuple(paths))


def _draw_cycloids(data: Picture, *places: Any) -> None:
    red, black = colours.HUES["vermilion"], colours.HUES["black"]
    scale = np.sin(data.tilt)
    dashed: dict[str, Any] = {"linewidth": 1.0, "linestyle": "dashed"}
    for k, ax in enumerate(places):
        path = np.degrees([scale * data.phi[k], data.theta[k]]).T
        curve(ax, path, red, linewidth=1.8, gid="theta")
        cycloid = np.degrees([scale * data.phi_approx[k], data.theta_approx[k]]).T
        curve(ax, cycloid, black, gid="theta_approx", **dashed)
        ax.axhline(
            np.degrees(data.tilt), color=on_ground(ax, colours.FAINT), linewidth=0.8, zorder=1
        )
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
    found = top.fast_top_approx(scene, angle, rate, precession=precession, t=t)
    assert found.phi is not None
    assert found.theta is not None
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
    rates = precession[:, np.newaxis] * UP + about[:, np.newaxis] * along
    return matrix_to_quaternion(matrix), rates @ matrix
