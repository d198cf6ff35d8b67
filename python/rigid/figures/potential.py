"""The effective potential, in whose well the tilt of a symmetric top nutates."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import top
from .._checks.arguments import vector
from ..drawing import colours
from ..drawing.axes3d import BELOW, curve, dots, label
from ..drawing.colours import on_ground
from ..model.scene import HeavyTop, check_heavy_top, require_unforced
from .picture import Kind, Picture

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation


Floats = NDArray[np.float64]

UPRIGHT = [1.0, 0.0, 0.0, 0.0]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PotentialWell(Picture):
    """The effective potential of a top, and the tilts that its energy allows.

    Attributes
    ----------
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
    """

    mgl: float
    tilt: Floats
    potential: Floats
    E_prime: float
    theta_upper: float
    theta_lower: float
    theta_steady: float
    lowest: float

    def _kinds(self) -> list[Kind]:
        return ["plane"]

    def _draw(self, ax: Any) -> None:
        blue, level_colour = colours.HUES["blue"], colours.HUES["vermilion"]
        well_curve = np.stack([np.degrees(self.tilt), self.potential], axis=1)
        curve(ax, well_curve, blue, linewidth=1.8, gid="potential")
        ends = np.degrees([self.theta_upper, self.theta_lower])
        level = np.stack([ends, np.full(2, self.E_prime)], axis=1)
        curve(ax, level, level_colour, linewidth=1.8, gid="E_prime")
        ax.axhline(
            self.E_prime,
            color=on_ground(ax, level_colour),
            linewidth=0.8,
            linestyle="dashed",
            zorder=1,
        )
        turning = dots(ax, level, level_colour, markersize=6, gid="turning")
        bottom = np.array([np.degrees(self.theta_steady), self.lowest])
        steady = dots(ax, bottom, blue, markersize=6, gid="lowest")

        height = max(self.E_prime - self.lowest, 0.2 * self.mgl, 0.05 * abs(self.lowest))
        low, high = self.lowest - 0.75 * height, self.E_prime + 1.6 * height
        # A stiff well may lie between two tilts of the curve.
        well = np.sort([*np.degrees(self.tilt[self.potential <= high]), *ends])
        margin = 0.5 * max(float(np.ptp(well)), 1.0)
        first, last = max(well[0] - margin, 0.0), min(well[-1] + margin, 180.0)
        wide = last - first
        marks = [(self.theta_steady, self.lowest, r"$\theta_\mathrm{m}$", 0.16)]
        if ends[1] - ends[0] > 0.04 * wide:
            marks.append((self.theta_upper, self.E_prime, r"$\theta_\mathrm{upper}$", 0.06))
            marks.append((self.theta_lower, self.E_prime, r"$\theta_\mathrm{lower}$", 0.06))
        for theta, value, name, share in marks:
            place = np.degrees(theta)
            drop = np.array([[place, low], [place, value]])
            curve(ax, drop, colours.FAINT, linewidth=0.9, zorder=1)
            # Outside the well, but inside the axes.
            room = 0.12 * wide
            left = (first + room < place and theta < self.theta_steady) or place >= last - room
            beside = np.array(
                [place + 0.01 * wide * (-1 if left else 1), low + share * (high - low)]
            )
            label(ax, beside, name, ha="right" if left else "left")
        # Write the names beside the lines, outside the well, on the side that has room.
        right = well[-1] + margin <= 180.0 or well[0] - margin < 0.0
        end = last - 0.03 * wide if right else first + 0.03 * wide
        label(ax, np.array([end, self.E_prime]), "$E'$", level_colour, va="bottom")
        near = low + 0.88 * (high - low)
        seen = np.flatnonzero(self.potential <= max(near, self.potential.min()))
        place, off, side = (seen[-1], 0.02, "left") if right else (seen[0], -0.02, "right")
        across = np.degrees(self.tilt[place]) + off * wide
        beside = np.array([across, np.minimum(self.potential[place], near)])
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
) -> PotentialWell:
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
    PotentialWell

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
    known = constants_of(scene, omega, attitude)
    a, b, e_prime = (known[name] for name in ("a", "b", "E_prime"))
    upper, lower = top.turning_angles(scene, a=a, b=b, E_prime=e_prime)
    steady = top.effective_minimum(scene, a=a, b=b)
    tilt = np.linspace(0.0, np.pi, samples)
    return PotentialWell(
        mgl=float(scene.mgl),
        tilt=tilt,
        potential=top.effective_potential(scene, tilt, a=a, b=b).value,
        E_prime=e_prime,
        theta_upper=float(upper),
        theta_lower=float(lower),
        theta_steady=float(steady),
        lowest=float(top.effective_potential(scene, steady, a=a, b=b).value),
    )


def constants_of(
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
