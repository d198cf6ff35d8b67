"""The path of the axis of a fast top, unrolled as a cycloid."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import top
from .._checks.arguments import finite_float, positive_int, shaped
from ..drawing import colours
from ..drawing.axes3d import UP, curve
from ..drawing.colours import on_ground
from ..drawing.shapes import across
from ..model.scene import HeavyTop, check_heavy_top, require_unforced
from ..rotations.euler import rotation_x
from ..rotations.quaternions import matrix_to_quaternion
from .picture import Kind, Picture

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Cycloids(Picture):
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

    _columns: ClassVar[int | None] = 1
    _panel_size: ClassVar[tuple[float, float] | None] = (7.0, 2.2)

    t: Floats
    kind: NDArray[np.str_]
    tilt: float
    precession: Floats
    phi: Floats
    theta: Floats
    phi_approx: Floats
    theta_approx: Floats

    def _kinds(self) -> list[Kind]:
        return ["plane"] * len(self.kind)

    def _draw(self, *places: Any) -> None:
        red, black = colours.HUES["vermilion"], colours.HUES["black"]
        scale = np.sin(self.tilt)
        dashed: dict[str, Any] = {"linewidth": 1.0, "linestyle": "dashed"}
        for k, ax in enumerate(places):
            path = np.degrees([scale * self.phi[k], self.theta[k]]).T
            curve(ax, path, red, linewidth=1.8, gid="theta")
            cycloid = np.degrees([scale * self.phi_approx[k], self.theta_approx[k]]).T
            curve(ax, cycloid, black, gid="theta_approx", **dashed)
            ax.axhline(
                np.degrees(self.tilt), color=on_ground(ax, colours.FAINT), linewidth=0.8, zorder=1
            )
            ax.set_title(str(self.kind[k]), fontsize="medium", loc="left")
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
) -> Cycloids:
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
