"""Springs that approach a rigid body, and bearing torques of an unbalanced body."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import pi
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._checks.arguments import finite_float, numbers
from ..drawing import colours
from ..drawing.axes3d import label, panels
from ..drawing.colours import on_ground
from ..fixed_axis import bearing_torques
from ..springs import pair_system, spring_body

__all__ = [
    "BearingTorque",
    "BearingTorqueArtists",
    "SpringModes",
    "SpringModesArtists",
    "bearing_torque",
    "bearing_torque_data",
    "spring_modes",
    "spring_modes_data",
]

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SpringModes:
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


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SpringModesArtists:
    """Artists of the figure :func:`spring_modes`.

    Attributes
    ----------
    axes : tuple of 2 Axes
        Axes of the spectrum, and of the distance against the stiffness.
    data : SpringModes
        Data of the figure.
    rigid, elastic : Line2D
        Modes without and with a frequency, against their number.
    distance, slope : Line2D
        The distances, and a line proportional to the inverse of the stiffness.
    """

    axes: tuple[Any, ...]
    data: SpringModes
    rigid: Any
    elastic: Any
    distance: Any
    slope: Any


def spring_modes_data(
    masses: ArrayLike,
    positions: ArrayLike,
    omega: ArrayLike,
    *,
    stiffness: ArrayLike = (1e2, 1e3, 1e4),
    t_end: float = 1.0,
    samples: int = 51,
) -> SpringModes:
    """Modes and distances of the figure :func:`spring_modes`.

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
    >>> figures.spring_modes_data(np.ones(4), corner, [0, 1, 0.3], stiffness=[100, 200]).zero
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


def spring_modes(
    masses: ArrayLike,
    positions: ArrayLike,
    omega: ArrayLike,
    *,
    stiffness: ArrayLike = (1e2, 1e3, 1e4),
    t_end: float = 1.0,
    axes: Sequence[Any] | None = None,
) -> SpringModesArtists:
    """Draw the modes of particles on springs, and how they become a rigid body.

    Six modes, the translations and the rotations, have the frequency zero. The other frequencies
    rise as the square root of the stiffness, and the distance from the rigid body falls as its
    inverse (lecture notes, § 5.1; six of the squared frequencies are zero, erratum G-01, and the
    squared frequencies are eigenvalues of the mass-weighted matrix, erratum G-02).

    Parameters
    ----------
    masses, positions, omega, stiffness, t_end
        As in :func:`spring_modes_data`.
    axes : sequence of 2 Axes, optional
        Axes to draw on; by default the axes of a new figure.

    Returns
    -------
    SpringModesArtists

    Raises
    ------
    ValueError
        As in :func:`spring_modes_data`, and if there are not two axes.
    ImportError
        If Matplotlib is not installed.

    Examples
    --------
    >>> import numpy as np
    >>> from rigid import figures
    >>> corner = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    >>> drawn = figures.spring_modes(np.ones(4), corner, [0, 1, 0.3], stiffness=[100, 200])
    >>> drawn.axes[0].figure.savefig("springs.png")  # doctest: +SKIP
    """
    data = spring_modes_data(masses, positions, omega, stiffness=stiffness, t_end=t_end)
    spectrum, limit = panels(axes, ["plane", "plane"])
    number = np.arange(1, data.frequencies.size + 1)
    blue, vermilion = colours.HUES["blue"], colours.HUES["vermilion"]
    stems = spectrum.vlines(
        number, 0.0, data.frequencies, color=on_ground(spectrum, blue), linewidth=1.2
    )
    stems.set_zorder(1)
    held = slice(None, data.zero), slice(data.zero, None)
    rigid, elastic = (
        spectrum.plot(
            number[part],
            data.frequencies[part],
            "o",
            color=on_ground(spectrum, colour),
            clip_on=False,
        )[0]
        for part, colour in zip(held, (vermilion, blue), strict=True)
    )
    highest = float(data.frequencies.max())
    words = f"{data.zero} at zero:\ntranslations\nand rotations"
    label(
        spectrum,
        np.array([0.7, 0.06 * highest]),
        words,
        vermilion,
        fontsize="medium",
        ha="left",
        va="bottom",
    )
    spectrum.set(
        xlabel="mode",
        ylabel=f"frequency for $k$ = {data.stiffness[0]:g} N/m (rad/s)",
        ylim=(0.0, 1.08 * highest),
        xlim=(0.3, number[-1] + 0.7),
    )
    spectrum.set_xticks(number[:: max(1, number.size // 12)])

    (distance,) = limit.plot(data.stiffness, data.distance, "o-", color=on_ground(limit, blue))
    law = data.distance[-1] * data.stiffness[-1] / data.stiffness
    (slope,) = limit.plot(
        data.stiffness, 0.4 * law, "--", color=on_ground(limit, colours.NEUTRAL), linewidth=1.2
    )
    limit.set(
        xscale="log",
        yscale="log",
        xlabel="stiffness $k$ of the springs (N/m)",
        ylabel="largest distance from the rigid body (m)",
    )
    middle = len(law) // 2
    limit.annotate(
        r"$\propto 1/k$",
        (data.stiffness[middle], 0.4 * law[middle]),
        (-8.0, -8.0),
        textcoords="offset points",
        ha="right",
        va="top",
        color=on_ground(limit, colours.NEUTRAL),
    )
    for ax in (spectrum, limit):
        ax.grid(visible=True, which="major", color=on_ground(ax, colours.GRID), linewidth=0.8)
        ax.set_axisbelow(True)
    return SpringModesArtists(
        axes=(spectrum, limit),
        data=data,
        rigid=rigid,
        elastic=elastic,
        distance=distance,
        slope=slope,
    )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BearingTorque:
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


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BearingTorqueArtists:
    """Artists of the figure :func:`bearing_torque`.

    Attributes
    ----------
    axes : tuple of 2 Axes
        Axes of the torque against the angle, and against the rate.
    data : BearingTorque
        Data of the figure.
    components : tuple of 3 Line2D
        The torque in space against the angle.
    size : Line2D
        The size of the torque perpendicular to the axis, against the rate.
    """

    axes: tuple[Any, ...]
    data: BearingTorque
    components: tuple[Any, ...]
    size: Any


def bearing_torque_data(
    tensor: ArrayLike, omega: float, *, omega_dot: float = 0.0, samples: int = 181
) -> BearingTorque:
    """Torques of the figure :func:`bearing_torque`, by :func:`rigid.fixed_axis.bearing_torques`.

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
    >>> data = figures.bearing_torque_data(tilted, 10.0)
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


def bearing_torque(
    tensor: ArrayLike,
    omega: float,
    *,
    omega_dot: float = 0.0,
    axes: Sequence[Any] | None = None,
) -> BearingTorqueArtists:
    """Draw the torque of the bearings on an unbalanced body.

    The torque turns with the body and rises as the square of the rate; only the component along the
    axis, from the drive, is constant (Ercan 2016, § 6, eq. (29), errata D-15, D-42).

    Parameters
    ----------
    tensor, omega, omega_dot
        As in :func:`bearing_torque_data`.
    axes : sequence of 2 Axes, optional
        Axes to draw on; by default the axes of a new figure.

    Returns
    -------
    BearingTorqueArtists

    Raises
    ------
    ValueError
        As in :func:`bearing_torque_data`, and if there are not two axes.
    ImportError
        If Matplotlib is not installed.

    Examples
    --------
    >>> from rigid import figures
    >>> tilted = [[2.0, 0.0, -0.5], [0.0, 2.0, 0.0], [-0.5, 0.0, 1.5]]
    >>> drawn = figures.bearing_torque(tilted, 10.0, omega_dot=2.0)
    >>> drawn.axes[0].figure.savefig("bearing.png")  # doctest: +SKIP
    """
    data = bearing_torque_data(tensor, omega, omega_dot=omega_dot)
    turning, rising = panels(axes, ["plane", "plane"])
    degrees = np.degrees(data.angle)
    components = []
    for values, ink, name in zip(data.torque.T, colours.AXES, "xyz", strict=True):
        (line,) = turning.plot(degrees, values, color=on_ground(turning, ink.colour), linewidth=1.8)
        components.append(line)
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
        ylabel=f"torque on the body at {float(omega):g} rad/s, in space (N m)",
        xlim=(0.0, 360.0),
        xticks=np.arange(0.0, 361.0, 90.0),
    )
    turning.margins(y=0.12)
    (size,) = rising.plot(
        data.omega, data.size, color=on_ground(rising, colours.TORQUE.colour), linewidth=1.8
    )
    rising.set(
        xlabel=r"rate $\omega$ (rad/s)",
        ylabel="torque of the bearings, across the axis (N m)",
        xlim=sorted((0.0, float(omega))),
    )
    rising.set_ylim(bottom=0.0)
    for ax in (turning, rising):
        ax.grid(visible=True, which="major", color=on_ground(ax, colours.GRID), linewidth=0.8)
        ax.set_axisbelow(True)
    return BearingTorqueArtists(
        axes=(turning, rising), data=data, components=tuple(components), size=size
    )
