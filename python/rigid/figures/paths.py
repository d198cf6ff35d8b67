"""The path of the axis of a top on the unit sphere."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import exact, top
from .._checks.arguments import finite_float, positive_int, rows, sorted_times, vector
from .._checks.arrays import attitudes
from ..drawing import colours
from ..drawing.axes3d import AZIM, UP, arrow, circle, curve, dots, fit, label
from ..drawing.shapes import ellipsoid_faces
from ..drawing.sides import eye, sides, surface
from ..model.scene import HeavyTop, check_heavy_top
from ..rotations.euler import rotation_z
from .picture import Kind, Picture

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation


Floats = NDArray[np.float64]

ELEV = 24.0
UPRIGHT = [1.0, 0.0, 0.0, 0.0]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Locus(Picture):
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
    elev : float
        Elevation of the viewer (degrees).
    """

    kind: str
    retrograde: bool
    t: Floats
    point: Floats
    theta: Floats
    phi: Floats
    theta_upper: float | None
    theta_lower: float | None
    elev: float

    def _draw(self, ax: Any) -> None:
        towards = eye(self.elev, AZIM)
        faces = ellipsoid_faces(np.ones(3), rings=24, sectors=48)
        surface(ax, faces, colours.SURFACE, towards, gid="sphere")
        curve(ax, circle(np.zeros(3), towards, 1.0), colours.FAINT, linewidth=1.0, zorder=2)
        red, blue = colours.HUES["vermilion"], colours.HUES["blue"]
        upper, lower = self.theta_upper, self.theta_lower
        if upper is not None and lower is not None:
            gap = (np.cos(upper) - np.cos(lower)) * np.cos(np.radians(self.elev))
            for theta, name, align in ((upper, "upper", "bottom"), (lower, "lower", "top")):
                ring = circle(np.cos(theta) * UP, UP, float(np.sin(theta)))
                near, far = sides(ring, ring, towards)
                gid = f"theta_{name}"
                curve(ax, near, blue, linewidth=1.0, zorder=3, gid=gid)
                dotted: dict[str, Any] = {"linewidth": 0.6, "linestyle": "dotted", "zorder": 2}
                curve(ax, far, blue, gid=f"{gid}_hidden", **dotted)
                _name_circle(ax, ring, name, blue, towards, "center" if gap > 0.1 else align)
        near, far = sides(self.point, self.point, towards)
        curve(ax, far, red, linewidth=0.8, alpha=0.45, zorder=2, gid="point_hidden")
        curve(ax, near, red, linewidth=1.8, zorder=4, gid="point")
        dots(ax, self.point[0], red, markersize=5, zorder=5, gid="start")
        up = colours.VERTICAL
        arrow(ax, 0.35 * UP, up.colour, up.label, start=UP, linewidth=1.4)
        fit(ax, faces, 1.4 * UP, elev=self.elev, azim=AZIM)


def locus(
    scene: HeavyTop,
    omega: ArrayLike,
    attitude: ArrayLike | Rotation | None = None,
    *,
    t: ArrayLike | None = None,
    samples: int = 1201,
    elev: float = ELEV,
) -> Locus:
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
    return Locus(
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


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Loci(Picture):
    """The paths of several starts.

    Attributes
    ----------
    paths : tuple of Locus
        The paths.
    """

    _columns: ClassVar[int | None] = 2

    paths: tuple[Locus, ...]

    def _kinds(self) -> list[Kind]:
        return ["space"] * len(self.paths)

    def _draw(self, *panels: Any) -> None:
        for ax, one in zip(panels, self.paths, strict=True):
            one._draw(ax)
            title = f"{one.kind}, retrograde" if one.retrograde else one.kind
            ax.set_title(title, fontsize="medium")


def loci(scene: HeavyTop, omega: ArrayLike, attitude: ArrayLike | Rotation | None = None) -> Loci:
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
    Loci

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
    return Loci(paths=tuple(paths))
