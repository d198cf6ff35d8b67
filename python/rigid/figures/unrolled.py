"""The path of the axis of a fast top, unrolled as a cycloid."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import top
from .._checks.arguments import finite_float, positive_int, shaped
from ..drawing import colours
from ..drawing.axes3d import panels
from ..drawing.colours import on_ground
from ..drawing.shapes import across
from ..model.scene import HeavyTop, check_heavy_top, require_unforced
from ..rotations.euler import rotation_x
from ..rotations.quaternions import matrix_to_quaternion
from .paths import UP

if TYPE_CHECKING:
    pass

__all__ = ["Cycloids", "CycloidsArtists", "cycloids", "cycloids_data"]

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Cycloids:
    """Paths of the axis of a fast top, unrolled, and the cycloids that approximate them.

    Attributes
    ----------
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
    """Artists of the figure :func:`cycloids`.

    Attributes
    ----------
    axes : tuple of k Axes
        Axes of the figure.
    data : Cycloids
        Data of the figure.
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
    """Data of the figure :func:`cycloids`.

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
    Cycloids

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
    >>> figures.cycloids_data(scene, 1.0, 40.0).kind.tolist()
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
    """Draw the path of the axis of a fast top, unrolled, and the cycloid that approximates it.

    Goldstein, *Classical Mechanics*, § 5.7; Ercan 2016, fig. 16 and eqs. (65)-(68): monotone, cusp
    or loop as ``|omega_P - omega_0|`` is below, at or above ``omega_P``.

    Parameters
    ----------
    scene, tilt, spin, pushes, periods
        As in :func:`cycloids_data`.
    axes : sequence of k Axes, optional
        Axes to draw on; by default the axes of a new figure, one above the other.

    Returns
    -------
    CycloidsArtists

    Raises
    ------
    ValueError
        As in :func:`cycloids_data`, and if there are not k axes.
    ImportError
        If Matplotlib is not installed.

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
            (
                data.phi[k],
                data.theta[k],
                exact_lines,
                {"color": on_ground(ax, red), "linewidth": 1.8},
            ),
            (
                data.phi_approx[k],
                data.theta_approx[k],
                approximate,
                {"color": on_ground(ax, black), "linewidth": 1.0, "linestyle": "dashed"},
            ),
        ):
            lines += ax.plot(np.degrees(scale * phi), np.degrees(theta), **style)
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
    return CycloidsArtists(
        axes=tuple(places), data=data, exact=tuple(exact_lines), approximate=tuple(approximate)
    )
