"""Angular velocities of a thrown body, and drift of the constants of motion of a run, over time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import free
from .._checks.arguments import brief
from ..animation.states import scene_of
from ..drawing import colours
from ..drawing.axes3d import KEY, in_plane, panels
from ..drawing.colours import on_ground
from ..exact.symmetry import symmetry_of
from ..model.scene import HeavyTop
from ..solve.run import Run

__all__ = [
    "Drift",
    "DriftArtists",
    "ThrowArtists",
    "invariants",
    "invariants_data",
    "throw",
]

Floats = NDArray[np.float64]

DASHES = ("solid", "dashed", "dotted")
"""Line styles of the components 1, 2, 3, for readers who cannot distinguish the colours."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ThrowArtists:
    """Artists of the figure :func:`throw`.

    Attributes
    ----------
    axes : tuple of 6 Axes
        Axes of the runs about the axes 1, 2, 3 without noise, then with noise.
    data : ThrowExperiment
        Data of the figure.
    omega : tuple of 6 tuples of 3 Line2D
        The rates about the axes of the body.
    dots : tuple of 6 Line2D
        The local indicator at whole seconds.
    """

    axes: tuple[Any, ...]
    data: free.ThrowExperiment
    omega: tuple[tuple[Any, ...], ...]
    dots: tuple[Any, ...]


def throw(experiment: free.ThrowExperiment, *, axes: Sequence[Any] | None = None) -> ThrowArtists:
    """Draw the rates of a body thrown about each of its axes, with and without noise.

    The dots are the largest real part of an eigenvalue of the Jacobian at whole seconds: the growth
    rate of a disturbance if the angular velocity were constant. The value is positive on stable
    motions too, so do not read it as stability (Buller and Wernstål 2011, fig. 3; errata S-14,
    S-15).

    Parameters
    ----------
    experiment : ThrowExperiment
        Result of :func:`rigid.free.throw_experiment`.
    axes : sequence of 6 Axes, optional
        Axes to draw on; by default the axes of a new figure.

    Returns
    -------
    ThrowArtists

    Raises
    ------
    TypeError
        If ``experiment`` is no :class:`rigid.free.ThrowExperiment`.
    ValueError
        If there are not six axes.
    ImportError
        If Matplotlib is not installed.

    Examples
    --------
    >>> import rigid
    >>> from rigid import figures, free
    >>> thrown = free.throw_experiment(rigid.Body.box(0.01, 0.08, 0.25), [0.05, 0.05, 0.05])
    >>> drawn = figures.throw(thrown)
    >>> drawn.axes[0].figure.savefig("throw.png")  # doctest: +SKIP
    """
    if not isinstance(experiment, free.ThrowExperiment):
        raise TypeError(f"experiment = {brief(experiment)}: must be a rigid.free.ThrowExperiment")
    places = panels(axes, ["plane"] * 6, columns=3)
    if axes is None:
        places[0].figure.set_size_inches(11.0, 6.0)
    low = min(experiment.omega.min(), 0.0)
    high = max(experiment.omega.max(), experiment.dots.max())
    room = 0.08 * (high - low)
    lines, dots = [], []
    for k, ax in enumerate(places):
        rates = experiment.omega[k].T
        lines.append(
            tuple(
                ax.plot(
                    experiment.t,
                    rate,
                    color=on_ground(ax, ink.colour),
                    linewidth=1.6,
                    linestyle=dash,
                )[0]
                for rate, ink, dash in zip(rates, colours.AXES, DASHES, strict=True)
            )
        )
        dots += ax.plot(
            experiment.dots_t,
            experiment.dots[k],
            "o",
            color=on_ground(ax, colours.HUES["black"]),
            markersize=3,
        )
        ax.axhline(0.0, color=on_ground(ax, colours.FAINT), linewidth=0.7, zorder=1)
        ax.set(xlim=(0.0, experiment.t[-1]), ylim=(low - room, high + room))
        how = "exactly" if k < 3 else "with noise"
        ax.set_title(f"{how} about axis {k % 3 + 1}", fontsize="medium", loc="left")
        if k >= 3:
            ax.set_xlabel("$t$ (s)")
    for row in (0, 3):
        places[row].set_ylabel(r"$\omega$ (rad/s), growth rate (1/s)")
    names = [*(rf"$\omega_{k}$" for k in (1, 2, 3)), r"growth rate: largest Re $\lambda$"]
    places[0].figure.legend(
        handles=[*lines[0], dots[0]], labels=names, loc="outside lower center", ncols=4, **KEY
    )
    return ThrowArtists(axes=tuple(places), data=experiment, omega=tuple(lines), dots=tuple(dots))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Drift:
    """Drift of the constants of motion from their first values.

    Attributes
    ----------
    t : ndarray, shape (m,)
        Times (s).
    names : tuple of str of length k
        ``"energy"``; for a free body ``"L"``, the size of the angular momentum, and ``"L_space"``,
        the vector in space; for a heavy top ``"p_phi"``, and for a symmetric top ``"p_psi"``. Under
        torque or damping only ``"energy less work"``.
    drift : ndarray, shape (k, m)
        Size of the difference. Energies are relative to the kinetic energy at the start (under
        torque, to the largest kinetic energy) plus ``mgl``; momenta are relative to ``|L|`` at the
        start plus ``sqrt(mgl I_max)``.
    """

    t: Floats
    names: tuple[str, ...]
    drift: Floats


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class DriftArtists:
    """Artists of the figure :func:`invariants`.

    Attributes
    ----------
    ax : Axes
        Axes of the figure.
    data : Drift
        Data of the figure.
    lines : tuple of k Line2D
        The drifts, in the order of ``data.names``.
    """

    ax: Any
    data: Drift
    lines: tuple[Any, ...]


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


def invariants_data(run: Run) -> Drift:
    """Data of the figure :func:`invariants`, by :func:`rigid.free.invariants`.

    Parameters
    ----------
    run : Run
        Run of a single body; for a heavy top with the vertical or the attitude.

    Returns
    -------
    Drift

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
    >>> data = figures.invariants_data(run)
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
    constants = {"energy": kept.energy}
    if run.work is not None:
        constants = {"energy less work": kept.energy - run.work}
        energy = float(kept.kinetic.max())
    elif isinstance(scene, HeavyTop):
        constants["p_phi"] = _known(kept.p_phi)
        if symmetry_of(scene).axis:
            constants["p_psi"] = _known(kept.p_psi)
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
    return Drift(t=run.t, names=tuple(constants), drift=np.array(drift))


def invariants(run: Run, *, ax: Any | None = None) -> DriftArtists:
    """Draw the drift of energy and angular momentum of a run, on a logarithmic scale.

    The grey line is the rounding of a single number; a drift of exactly zero is drawn at the lower
    edge. A constant that a method conserves remains near the grey line; other constants drift.

    Parameters
    ----------
    run
        As in :func:`invariants_data`.
    ax : Axes, optional
        Axes to draw on; by default the axes of a new figure.

    Returns
    -------
    DriftArtists

    Raises
    ------
    TypeError, ValueError
        As in :func:`invariants_data`, and if the axes are not two-dimensional.
    ImportError
        If Matplotlib is not installed.

    Examples
    --------
    >>> import numpy as np, rigid
    >>> from rigid import figures
    >>> scene = rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0)))
    >>> run = rigid.simulate(
    ...     scene, [1.0, 1.0, 1.0], t=np.linspace(0.0, 50.0, 101), method="rk4", step=0.05
    ... )
    >>> drawn = figures.invariants(run)
    >>> drawn.ax.figure.savefig("drift.png")  # doctest: +SKIP
    """
    data = invariants_data(run)
    ax = in_plane(ax)
    rounding = ax.axhline(ROUNDING, color=on_ground(ax, colours.FAINT), linewidth=1.0, zorder=1)
    rounding.set_label("rounding")
    lines, floor = [], 0.02 * ROUNDING
    for name, values in zip(data.names, data.drift, strict=True):
        words, colour = NAMES[name]
        seen = np.maximum(values, floor)
        lines += ax.plot(data.t, seen, color=on_ground(ax, colour), linewidth=1.2, label=words)
    ax.set(yscale="log", xlim=(data.t[0], data.t[-1]), xlabel="$t$ (s)", ylabel="relative drift")
    ax.set_ylim(0.7 * floor, 10.0 * max(float(data.drift.max()), ROUNDING))
    method = run.spec["method"]
    ax.set_title(method, fontsize="medium", loc="left")
    ax.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False)
    return DriftArtists(ax=ax, data=data, lines=tuple(lines))


def _known(values: Floats | None) -> Floats:
    assert values is not None  # invariants() raises for a heavy top without vertical
    return values
