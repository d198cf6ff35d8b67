"""Angular velocities of a thrown body, and drift of the constants of motion of a run, over time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from .. import free
from .._checks.arguments import brief
from ..drawing import colours
from ..drawing.axes3d import KEY, curve, dots
from ..drawing.colours import on_ground
from ..exact.symmetry import symmetry_of
from ..model.scene import HeavyTop
from ..solve.run import Run, scene_of
from .picture import Kind, Picture

Floats = NDArray[np.float64]

DASHES = ("solid", "dashed", "dotted")
"""Line styles of the components 1, 2, 3, for readers who cannot distinguish the colours."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Throw(Picture):
    """A body thrown about the axes 1, 2, 3 without noise, then with noise: six panels.

    Attributes
    ----------
    experiment : ThrowExperiment
        Result of :func:`rigid.free.throw_experiment`, whose attributes the artists show.
    """

    _columns: ClassVar[int | None] = 3
    _panel_size: ClassVar[tuple[float, float] | None] = (11.0 / 3.0, 3.0)

    experiment: free.ThrowExperiment

    def _kinds(self) -> list[Kind]:
        return ["plane"] * 6

    def _draw(self, *places: Any) -> None:
        data = self.experiment
        low, high = min(data.omega.min(), 0.0), max(data.omega.max(), data.dots.max())
        room = 0.08 * (high - low)
        for k, ax in enumerate(places):
            rates = [
                curve(
                    ax,
                    np.stack([data.t, rate], axis=1),
                    ink.colour,
                    linewidth=1.6,
                    linestyle=dash,
                    gid="omega",
                )
                for rate, ink, dash in zip(data.omega[k].T, colours.AXES, DASHES, strict=True)
            ]
            growth = np.stack([data.dots_t, data.dots[k]], axis=1)
            points = dots(ax, growth, colours.HUES["black"], markersize=3, gid="dots")
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
            handles=[*rates, points], labels=names, loc="outside lower center", ncols=4, **KEY
        )


def throw(experiment: free.ThrowExperiment) -> Throw:
    """The rates of a body thrown about each of its axes, with and without noise.

    The dots are the largest real part of an eigenvalue of the Jacobian at whole seconds: the growth
    rate of a disturbance if the angular velocity were constant. The value is positive on stable
    motions too, so do not read it as stability (Buller and Wernstål 2011, fig. 3; errata S-14,
    S-15).

    Parameters
    ----------
    experiment : ThrowExperiment
        Result of :func:`rigid.free.throw_experiment`.

    Returns
    -------
    Throw

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
    return Throw(experiment=experiment)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Drift(Picture):
    """Drift of the constants of motion from their first values.

    Attributes
    ----------
    method : str
        Method of the run.
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

    method: str
    t: Floats
    names: tuple[str, ...]
    drift: Floats

    def _kinds(self) -> list[Kind]:
        return ["plane"]

    def _draw(self, ax: Any) -> None:
        rounding = ax.axhline(ROUNDING, color=on_ground(ax, colours.FAINT), linewidth=1.0, zorder=1)
        rounding.set_label("rounding")
        floor = 0.02 * ROUNDING
        for name, values in zip(self.names, self.drift, strict=True):
            words, colour = NAMES[name]
            seen = np.stack([self.t, np.maximum(values, floor)], axis=1)
            curve(ax, seen, colour, linewidth=1.2, label=words, gid="drift")
        ax.set(
            yscale="log", xlim=(self.t[0], self.t[-1]), xlabel="$t$ (s)", ylabel="relative drift"
        )
        ax.set_ylim(0.7 * floor, 10.0 * max(float(self.drift.max()), ROUNDING))
        ax.set_title(self.method, fontsize="medium", loc="left")
        ax.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False)


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


def invariants(run: Run) -> Drift:
    """The drift of energy and angular momentum of a run, on a logarithmic scale.

    The grey line is the rounding of a single number; a drift of exactly zero is drawn at the lower
    edge. A constant that a method conserves remains near the grey line; other constants drift.

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
    return Drift(method=run.spec["method"], t=run.t, names=tuple(constants), drift=np.array(drift))


def _known(values: Floats | None) -> Floats:
    assert values is not None  # invariants() raises for a heavy top without vertical
    return values
