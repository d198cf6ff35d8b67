"""Springs that approach a rigid body, and bearing torques of an unbalanced body."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._checks.arguments import finite_float, numbers
from ..drawing import colours
from ..drawing.axes3d import curve, dots, label
from ..drawing.colours import on_ground
from ..fixed_axis import bearing_torques
from ..springs import pair_system, spring_body
from .picture import Kind, Picture

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SpringModes(Picture):
    """Frequencies of a body of springs, and its distance from the rigid body.

    Attributes
    ----------
    frequencies : ndarray, shape (3 N,)
        ``sqrt(omega²)`` of the modes for the first stiffness, ascending (rad/s); zero frequencies
        are exactly 0.
    zero : int
        Number of zero frequencies: six for a body that its springs hold together.
    stiffness : ndarray, shape (n,)
        Stiffnesses of the springs (N/m), ascending.
    distance : ndarray, shape (n,)
        Largest distance (m), over time, of a particle from its position in the rigid body.
    evaluations : ndarray of int, shape (n,)
        Number of evaluations of the forces: the cost.
    """

    frequencies: Floats
    zero: int
    stiffness: Floats
    distance: Floats
    evaluations: NDArray[np.intp]

    def _kinds(self) -> list[Kind]:
        return ["plane", "plane"]

    def _draw(self, spectrum: Any, limit: Any) -> None:
        number = np.arange(1, self.frequencies.size + 1)
        blue, vermilion = colours.HUES["blue"], colours.HUES["vermilion"]
        stems = spectrum.vlines(
            number, 0.0, self.frequencies, color=on_ground(spectrum, blue), linewidth=1.2
        )
        stems.set_zorder(1)
        modes = np.stack([number, self.frequencies], axis=1)
        dots(spectrum, modes[: self.zero], vermilion, clip_on=False, gid="frequencies")
        dots(spectrum, modes[self.zero :], blue, clip_on=False, gid="frequencies")
        highest = float(self.frequencies.max())
        words = f"{self.zero} at zero:\ntranslations\nand rotations"
        place = np.array([0.7, 0.06 * highest])
        label(spectrum, place, words, vermilion, fontsize="medium", ha="left", va="bottom")
        spectrum.set(
            xlabel="mode",
            ylabel=f"frequency for $k$ = {self.stiffness[0]:g} N/m (rad/s)",
            ylim=(0.0, 1.08 * highest),
            xlim=(0.3, number[-1] + 0.7),
        )
        spectrum.set_xticks(number[:: max(1, number.size // 12)])

        measured = {"color": on_ground(limit, blue), "gid": "distance"}
        limit.plot(self.stiffness, self.distance, "o-", **measured)
        law = self.distance[-1] * self.stiffness[-1] / self.stiffness
        slope = np.stack([self.stiffness, 0.4 * law], axis=1)
        curve(limit, slope, colours.NEUTRAL, linestyle="--", linewidth=1.2, gid="slope")
        limit.set(
            xscale="log",
            yscale="log",
            xlabel="stiffness $k$ of the springs (N/m)",
            ylabel="largest distance from the rigid body (m)",
        )
        middle = len(law) // 2
        limit.annotate(
            r"$\propto 1/k$",
            (self.stiffness[middle], 0.4 * law[middle]),
            (-8.0, -8.0),
            textcoords="offset points",
            ha="right",
            va="top",
            color=on_ground(limit, colours.NEUTRAL),
        )
        _grid(spectrum)
        _grid(limit)


def spring_modes(
    masses: ArrayLike,
    positions: ArrayLike,
    omega: ArrayLike,
    *,
    stiffness: ArrayLike = (1e2, 1e3, 1e4),
    t_end: float = 1.0,
    samples: int = 51,
) -> SpringModes:
    """The modes of particles on springs, and how they become a rigid body.

    Six modes, the translations and the rotations, have the frequency zero. The other frequencies
    rise as the square root of the stiffness, and the distance from the rigid body falls as its
    inverse (lecture notes, § 5.1; six of the squared frequencies are zero, erratum G-01, and the
    squared frequencies are eigenvalues of the mass-weighted matrix, erratum G-02).

    Parameters
    ----------
    masses, positions, omega
        As in :func:`rigid.springs.spring_body`.
    stiffness : array_like, shape (n,)
        Stiffnesses (N/m) of all springs, two or more, positive and ascending.
    t_end : float
        Duration of the motion (s).
    samples : int
        Number of times at which to compute the distance.

    Returns
    -------
    SpringModes

    Raises
    ------
    ValueError
        As in :func:`rigid.springs.spring_body`, and if the stiffnesses are not positive and
        ascending.

    Examples
    --------
    >>> import numpy as np
    >>> from rigid import figures
    >>> corner = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    >>> figures.spring_modes(np.ones(4), corner, [0, 1, 0.3], stiffness=[100, 200]).zero
    6
    """
    k = numbers("stiffness", stiffness)
    if (
        k.ndim != 1
        or len(k) < 2
        or not np.isfinite(k).all()
        or (np.diff(k, prepend=0.0) <= 0).any()
    ):
        raise ValueError(
            f"stiffness = {np.ravel(k).tolist()}: must be two or more, positive and ascending"
        )
    times = np.linspace(0.0, finite_float("t_end", t_end, positive=True), samples)
    modes = pair_system(masses, positions, stiffness=float(k[0])).modes()
    squared = np.where(np.arange(modes.omega_squared.size) < modes.zero, 0.0, modes.omega_squared)
    paths = [spring_body(masses, positions, omega, stiffness=float(one), t=times) for one in k]
    return SpringModes(
        frequencies=np.sqrt(squared),
        zero=int(modes.zero),
        stiffness=k,
        distance=np.array([path.distance.max() for path in paths]),
        evaluations=np.array([path.evaluations for path in paths], dtype=np.intp),
    )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BearingTorque(Picture):
    """Torque of the bearings on an unbalanced body.

    Attributes
    ----------
    angle : ndarray, shape (m,)
        Angle of rotation over one turn (rad).
    torque : ndarray, shape (m, 3)
        Torque on the body at these angles and the given rate, components in space (N m); the third
        component is the torque of the drive.
    omega : ndarray, shape (n,)
        Rates from zero to the given rate (rad/s).
    size : ndarray, shape (n,)
        Size of the torque perpendicular to the axis at these rates (N m).
    """

    angle: Floats
    torque: Floats
    omega: Floats
    size: Floats

    def _kinds(self) -> list[Kind]:
        return ["plane", "plane"]

    def _draw(self, turning: Any, rising: Any) -> None:
        degrees, rate = np.degrees(self.angle), float(self.omega[-1])
        for values, ink, name in zip(self.torque.T, colours.AXES, "xyz", strict=True):
            points = np.stack([degrees, values], axis=1)
            curve(turning, points, ink.colour, linewidth=1.8, gid="torque")
            # Above a crest; a constant has none.
            place = int(values.argmax()) or len(values) * 9 // 10
            turning.annotate(
                rf"$\tau_{name}$",
                (degrees[place], values[place]),
                (0.0, 4.0),
                textcoords="offset points",
                color=on_ground(turning, ink.colour),
                ha="center",
                va="bottom",
            )
        turning.set(
            xlabel="turned angle (degrees)",
            ylabel=f"torque on the body at {rate:g} rad/s, in space (N m)",
            xlim=(0.0, 360.0),
            xticks=np.arange(0.0, 361.0, 90.0),
        )
        turning.margins(y=0.12)
        points = np.stack([self.omega, self.size], axis=1)
        curve(rising, points, colours.TORQUE.colour, linewidth=1.8, gid="size")
        rising.set(
            xlabel=r"rate $\omega$ (rad/s)",
            ylabel="torque of the bearings, across the axis (N m)",
            xlim=sorted((0.0, rate)),
        )
        rising.set_ylim(bottom=0.0)
        _grid(turning)
        _grid(rising)


def bearing_torque(
    tensor: ArrayLike, omega: float, *, omega_dot: float = 0.0, samples: int = 181
) -> BearingTorque:
    """The torque of the bearings on an unbalanced body.

    The torque turns with the body and rises as the square of the rate; only the component along the
    axis, from the drive, is constant (Ercan 2016, § 6, eq. (29), errata D-15, D-42).

    Parameters
    ----------
    tensor : array_like, shape (3, 3)
        Tensor of inertia in the body (kg m²), about a point of the axis z.
    omega, omega_dot : float
        Rate about the axis (rad/s), not zero, and its derivative (rad/s²).
    samples : int
        Number of points of a curve.

    Returns
    -------
    BearingTorque

    Raises
    ------
    ValueError
        If no body has the tensor, the rate is zero, or an argument is not finite.

    Examples
    --------
    >>> from rigid import figures
    >>> tilted = [[2.0, 0.0, -0.5], [0.0, 2.0, 0.0], [-0.5, 0.0, 1.5]]
    >>> data = figures.bearing_torque(tilted, 10.0)
    >>> float(data.size[-1])  # I_xz omega²
    50.0
    """
    rate, faster = finite_float("omega", omega), finite_float("omega_dot", omega_dot)
    if rate == 0.0:
        raise ValueError("omega = 0.0: must not be zero, the curves run from rest to it")
    shape = np.shape(tensor)
    if shape != (3, 3):
        raise ValueError(f"tensor: expected shape (3, 3), got {shape}")
    angle = np.linspace(0.0, 2.0 * pi, samples)
    rates = np.linspace(0.0, rate, samples)
    return BearingTorque(
        angle=angle,
        torque=bearing_torques(tensor, rate, faster, angle=angle).torque_space,
        omega=rates,
        size=np.linalg.norm(bearing_torques(tensor, rates, faster).bearing, axis=-1),
    )


def _grid(ax: Any) -> None:
    ax.grid(visible=True, which="major", color=on_ground(ax, colours.GRID), linewidth=0.8)
    ax.set_axisbelow(True)
