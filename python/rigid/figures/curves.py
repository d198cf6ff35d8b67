"""Curves over time, rate and stiffness: throws, drift, springs and bearings."""

from __future__ import annotations

from math import pi
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from .. import free
from .._checks.arguments import brief, finite_float, numbers
from ..drawing import axes3d as draw
from ..drawing import colours
from ..drawing.colours import on_ground
from ..exact.symmetry import symmetry_of
from ..fixed_axis import bearing_torques
from ..model.scene import HeavyTop
from ..solve.run import Run, scene_of
from ..springs import pair_system, spring_body
from .picture import Picture

DASHES = ("solid", "dashed", "dotted")
"""Line styles of the components 1, 2, 3, for readers who cannot distinguish the colours."""

NAMES = {
    "energy": ("$E$", colours.HUES["black"]),
    "energy less work": ("$E - W$", colours.HUES["black"]),
    "L": (r"$|\mathbf{L}|$", colours.HUES["sky"]),
    "L_space": (r"$\mathbf{L}$ in space", colours.L.colour),
    "p_phi": (r"$p_\phi$", colours.HUES["sky"]),
    "p_psi": (r"$p_\psi$", colours.L.colour),
}
"""Labels and colours of the constants."""

ROUNDING = float(np.finfo(np.float64).eps)


def _draw_throw(data: Picture, *places: Any) -> None:
    data = data.experiment
    low, high = min(data.omega.min(), 0.0), max(data.omega.max(), data.dots.max())
    room = 0.08 * (high - low)
    for k, ax in enumerate(places):
        rates = [
            draw.curve(ax, (data.t, rate), ink.colour, linewidth=1.6, linestyle=dash, gid="omega")
            for rate, ink, dash in zip(data.omega[k].T, colours.AXES, DASHES, strict=True)
        ]
        growth = data.dots_t, data.dots[k]
        points = draw.dots(ax, growth, colours.HUES["black"], markersize=3, gid="dots")
        ax.axhline(0.0, color=on_ground(ax, colours.FAINT), linewidth=0.7, zorder=1)
        ax.set(xlim=(0.0, data.t[-1]), ylim=(low - room, high + room))
        how = "exactly" if k < 3 else "with noise"
        ax.set_title(f"{how} about axis {k % 3 + 1}", fontsize="medium", loc="left")
        if k >= 3:
            ax.set_xlabel("$t$ (s)")
    for row in (0, 3):
        places[row].set_ylabel(r"$\omega$ (rad/s), growth rate (1/s)")
    names = [*(rf"$\omega_{k}$" for k in (1, 2, 3)), r"growth rate: largest Re $\lambda$"]
    places[0].figure.legend(
        handles=[*rates, points], labels=names, loc="outside lower center", ncols=4, **draw.KEY
    )


def throw(experiment: free.ThrowExperiment) -> Picture:
    """The rates of a body thrown about each of its axes, with and without noise.

    The dots are the largest real part of an eigenvalue of the Jacobian at whole seconds: the growth
    rate of a perturbation if the angular velocity were constant. The value is positive on stable
    motions too, so do not read it as stability (Buller and Wernstål 2011, fig. 3; errata S-14,
    S-15).

    Parameters
    ----------
    experiment : ThrowExperiment
        Result of :func:`rigid.free.throw_experiment`.

    Returns
    -------
    Picture
        A body thrown about the axes 1, 2, 3 without noise, then with noise: six panels.

        experiment : ThrowExperiment
            Result of :func:`rigid.free.throw_experiment`, whose attributes the artists show.

    Raises
    ------
    TypeError
        If ``experiment`` is no :class:`rigid.free.ThrowExperiment`.

    Examples
    --------
    >>> import rigid
    >>> from rigid import figures, free
    >>> thrown = free.throw_experiment(rigid.Body.box(0.01, 0.08, 0.25), [0.05, 0.05, 0.05])
    >>> axes = figures.throw(thrown).plot()
    >>> axes[0].figure.savefig("throw.png")  # doctest: +SKIP
    """
    if not isinstance(experiment, free.ThrowExperiment):
        raise TypeError(f"experiment = {brief(experiment)}: must be a rigid.free.ThrowExperiment")
    return Picture(
        _draw_throw,
        panels=["plane"] * 6,
        columns=3,
        panel_size=(11.0 / 3.0, 3.0),
        experiment=experiment,
    )


def _draw_invariants(data: Picture, ax: Any) -> None:
    rounding = ax.axhline(ROUNDING, color=on_ground(ax, colours.FAINT), linewidth=1.0, zorder=1)
    rounding.set_label("rounding")
    floor = 0.02 * ROUNDING
    for name, values in zip(data.names, data.drift, strict=True):
        words, colour = NAMES[name]
        seen = data.t, np.maximum(values, floor)
        draw.curve(ax, seen, colour, linewidth=1.2, label=words, gid="drift")
    ax.set(yscale="log", xlim=(data.t[0], data.t[-1]), xlabel="$t$ (s)", ylabel="relative drift")
    ax.set_ylim(0.7 * floor, 10.0 * max(float(data.drift.max()), ROUNDING))
    ax.set_title(data.method, fontsize="medium", loc="left")
    ax.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False)


def invariants(run: Run) -> Picture:
    """The drift of energy and angular momentum of a run, on a logarithmic scale.

    The grey line is the rounding of a single number; a drift of exactly zero is drawn at the lower
    edge. A constant that a method conserves remains near the grey line; other constants drift.

    Parameters
    ----------
    run : Run
        Run of a single body; for a heavy top with the vertical or the attitude.

    Returns
    -------
    Picture
        Drift of the constants of motion from their first values.

        method : str
            Method of the run.
        t : ndarray, shape (m,)
            Times (s).
        names : tuple of str of length k
            ``"energy"``; for a free body ``"L"``, the size of the angular momentum, and
            ``"L_space"``, the vector in space; for a heavy top ``"p_phi"``, and for a symmetric top
            ``"p_psi"``. Under torque or damping only ``"energy less work"``.
        drift : ndarray, shape (k, m)
            Size of the difference. Energies are relative to the kinetic energy at the start (under
            torque, to the largest kinetic energy) plus ``mgl``; momenta are relative to ``|L|`` at
            the start plus ``sqrt(mgl I_max)``.

    Raises
    ------
    TypeError
        If ``run`` is no :class:`rigid.Run`.
    ValueError
        If the run has several bodies, fewer than two times or states that are not finite, or lacks
        the vertical.

    Examples
    --------
    >>> import numpy as np, rigid
    >>> from rigid import figures
    >>> scene = rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0)))
    >>> run = rigid.simulate(
    ...     scene, [1.0, 1.0, 1.0], t=np.linspace(0.0, 50.0, 101), method="rk4", step=0.05
    ... )
    >>> data = figures.invariants(run)
    >>> data.names, bool(data.drift[0].max() > 1e-9)
    (('energy', 'L', 'L_space'), True)
    """
    if not isinstance(run, Run):
        raise TypeError(f"run = {brief(run)}: must be a rigid.Run")
    if run.omega.ndim != 2 or len(run.t) < 2:
        raise ValueError(
            f"omega of shape {run.omega.shape}: needs one body at two times or more, (m, 3)"
        )
    scene = scene_of(run)
    kept = free.invariants(run)
    energy, momentum = float(kept.kinetic[0]), float(kept.L[0])
    constants: dict[str, Any] = {"energy": kept.energy}
    if run.work is not None:
        constants = {"energy less work": kept.energy - run.work}
        energy = float(kept.kinetic.max())
    elif isinstance(scene, HeavyTop):
        constants["p_phi"] = kept.p_phi  # invariants() raises for a heavy top without vertical
        if symmetry_of(scene).axis:
            constants["p_psi"] = kept.p_psi
    else:
        constants["L"] = kept.L
        if kept.L_space is not None:
            constants["L_space"] = kept.L_space
    if isinstance(scene, HeavyTop):
        energy += float(scene.mgl)
        momentum += float(np.sqrt(scene.mgl * max(scene.body.moments)))
    if energy == 0.0:
        raise ValueError("omega = [0, 0, 0]: a free body at rest has nothing to drift")
    drift = []
    for name, values in constants.items():
        change = values - values[:1]
        size = np.linalg.norm(change, axis=-1) if change.ndim == 2 else np.abs(change)
        drift.append(size / (energy if name.startswith("energy") else momentum))
    return Picture(
        _draw_invariants,
        panels=["plane"],
        method=run.spec["method"],
        t=run.t,
        names=tuple(constants),
        drift=np.array(drift),
    )


def _draw_spring_modes(data: Picture, spectrum: Any, limit: Any) -> None:
    number = np.arange(1, data.frequencies.size + 1)
    blue, vermilion = colours.HUES["blue"], colours.HUES["vermilion"]
    ink = on_ground(spectrum, blue)
    spectrum.vlines(number, 0.0, data.frequencies, color=ink, linewidth=1.2, zorder=1)
    for which, ink in ((slice(data.zero), vermilion), (slice(data.zero, None), blue)):
        modes = number[which], data.frequencies[which]
        draw.dots(spectrum, modes, ink, clip_on=False, gid="frequencies")
    highest = float(data.frequencies.max())
    words = f"{data.zero} at zero:\ntranslations\nand rotations"
    place = np.array([0.7, 0.06 * highest])
    draw.label(spectrum, place, words, vermilion, fontsize="medium", ha="left", va="bottom")
    spectrum.set(
        xlabel="mode",
        ylabel=f"frequency for $k$ = {data.stiffness[0]:g} N/m (rad/s)",
        ylim=(0.0, 1.08 * highest),
        xlim=(0.3, number[-1] + 0.7),
        xticks=number[:: max(1, number.size // 12)],
    )

    measured = data.stiffness, data.distance
    draw.curve(limit, measured, blue, marker="o", linewidth=1.5, gid="distance")
    law = data.distance[-1] * data.stiffness[-1] / data.stiffness
    slope = data.stiffness, 0.4 * law
    draw.curve(limit, slope, colours.NEUTRAL, linestyle="--", linewidth=1.2, gid="slope")
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
) -> Picture:
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
    Picture
        Frequencies of a body of springs, and its distance from the rigid body.

        frequencies : ndarray, shape (3 N,)
            ``sqrt(omega²)`` of the modes for the first stiffness, ascending (rad/s); zero
            frequencies are exactly 0.
        zero : int
            Number of zero frequencies: six for a body that its springs hold together.
        stiffness : ndarray, shape (n,)
            Stiffnesses of the springs (N/m), ascending.
        distance : ndarray, shape (n,)
            Largest distance (m), over time, of a particle from its position in the rigid body.
        evaluations : ndarray of int, shape (n,)
            Number of evaluations of the forces: the cost.

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
    known = k.ndim == 1 and len(k) > 1 and np.isfinite(k).all()
    if not known or (np.diff(k, prepend=0.0) <= 0.0).any():
        found = np.ravel(k).tolist()
        raise ValueError(f"stiffness = {found}: must be two or more, positive and ascending")
    times = np.linspace(0.0, finite_float("t_end", t_end, positive=True), samples)
    modes = pair_system(masses, positions, stiffness=float(k[0])).modes()
    squared = np.where(np.arange(modes.omega_squared.size) < modes.zero, 0.0, modes.omega_squared)
    paths = [spring_body(masses, positions, omega, stiffness=float(one), t=times) for one in k]
    return Picture(
        _draw_spring_modes,
        panels=["plane", "plane"],
        frequencies=np.sqrt(squared),
        zero=int(modes.zero),
        stiffness=k,
        distance=np.array([path.distance.max() for path in paths]),
        evaluations=np.array([path.evaluations for path in paths], dtype=np.intp),
    )


def _draw_bearing_torque(data: Picture, turning: Any, rising: Any) -> None:
    degrees, rate = np.degrees(data.angle), float(data.omega[-1])
    for values, ink, name in zip(data.torque.T, colours.AXES, "xyz", strict=True):
        draw.curve(turning, (degrees, values), ink.colour, linewidth=1.8, gid="torque")
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
    draw.curve(rising, (data.omega, data.size), colours.TORQUE.colour, linewidth=1.8, gid="size")
    rising.set(
        xlabel=r"rate $\omega$ (rad/s)",
        ylabel="torque of the bearings, across the axis (N m)",
        xlim=sorted((0.0, rate)),
        ylim=(0.0, None),
    )
    _grid(turning)
    _grid(rising)


def bearing_torque(
    tensor: ArrayLike, omega: float, *, omega_dot: float = 0.0, samples: int = 181
) -> Picture:
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
    Picture
        Torque of the bearings on an unbalanced body.

        angle : ndarray, shape (m,)
            Angle of rotation over one turn (rad).
        torque : ndarray, shape (m, 3)
            Torque on the body at these angles and the given rate, components in space (N m); the
            third component is the torque of the drive.
        omega : ndarray, shape (n,)
            Rates from zero to the given rate (rad/s).
        size : ndarray, shape (n,)
            Size of the torque perpendicular to the axis at these rates (N m).

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
    return Picture(
        _draw_bearing_torque,
        panels=["plane", "plane"],
        angle=angle,
        torque=bearing_torques(tensor, rate, faster, angle=angle).torque_space,
        omega=rates,
        size=np.linalg.norm(bearing_torques(tensor, rates, faster).bearing, axis=-1),
    )


def _grid(ax: Any) -> None:
    ax.grid(visible=True, which="major", color=on_ground(ax, colours.GRID), linewidth=0.8)
    ax.set_axisbelow(True)
