"""Parameters and start of a body, and a gyroscope's errors, from measured rates."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from .._archive import write_archive
from .._checks.arguments import brief, shaped, sorted_times, vector
from .._checks.arrays import Floats
from .._checks.moments import refuse_rods
from .._checks.overflow import refuses_overflow
from .._checks.progress import ProgressOption, reporting
from .._checks.shown import aligned
from .._checks.warned import warn_caller
from ..drawing.colours import AXES, on_ground
from ..drawing.figure import axes_to_draw_on, html_with_picture
from ..model.body import Body
from ..model.frame import checked_frame
from ..model.parameters import PARAMETERS
from ..model.scene import Scene, check_scene
from .arcs import Arcs, largest_of, overtaken
from .least_squares import UNTOLD, Minimum
from .unknowns import BIAS, DAMPING, MOMENTS, RATIOS, SCALE, SENSOR, START, Unknowns

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from scipy.spatial.transform import Rotation


_PART = 1e-3
"""Least coefficient that is named in a combination that is not determined."""

_APART = 3.0
"""Distance of another minimum in standard deviations from which on it is named."""

_REACHED = 0.01
"""A minimum is reached if a whole step would lower chi² by less than this: a tenth of a std."""


_UNITS = {
    **dict.fromkeys(BIAS, "rad/s"),
    **dict.fromkeys(SCALE, ""),
    **dict.fromkeys(SENSOR, "rad"),
}
"""Units of what belongs to the gyroscope."""

_SAVED = (
    *("names", "values", "std", "covariance", "others", "undetermined", "at_bounds"),
    *("success", "reason", "chi2", "omega", "sensor", "t", "measured", "sigma", "residuals"),
)
"""What a file has, besides the scene."""


class FitWarning(UserWarning):
    """The warning that a fit failed."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False, repr=False)
class Fit:
    """Parameters of a motion with their covariance, fitted to measured rates by :func:`fit`.

    Attributes
    ----------
    success : bool
        Whether a minimum was reached, its ``chi2`` is possible, and no other minimum is. Noise of
        the given ``sigma`` has a larger chi² in less than one of a million fits. Where the best of
        n minima is taken, the chance is n in a million.
    reason : str
        The reason for success or failure, in words.
    names : tuple of str
        The free parameters; ``"omega"`` gives ``"omega1"``, ``"omega2"``, ``"omega3"``, and so do
        ``"damping"``, ``"bias"``, ``"scale"`` and ``"sensor"``.
    values : ndarray, shape (k,)
        Their best values.
    std : ndarray, shape (k,)
        Standard deviations; infinite for a parameter that takes part in a combination that the data
        do not determine.
    covariance : ndarray, shape (k, k)
        Covariance of what the data determine; its diagonal is ``std**2``.
    undetermined : tuple of str
        The combinations of parameters that the data do not determine, in words.
    at_bounds : tuple of str
        The parameters that ended at the edge of the physical range, in words. Standard deviations
        do not hold there.
    others : ndarray, shape (n, k)
        Values at other minima that explain the measurements as well, the best first: noise could
        have made their chi² larger. With them the fit is ambiguous and no success.
    chi2 : float
        Sum of the squares of the residuals.
    chi2_per_dof : float
        ``chi2 / (residuals.size - k)``: about 1 if model and ``sigma`` hold; far below 1 if
        ``sigma`` is larger than the noise. NaN for as many parameters as numbers.
    t : ndarray, shape (m,)
        Times of the measurements (s).
    measured, sigma : ndarray, shape (m, 3)
        Measured rates and their standard deviations (rad/s).
    residuals : ndarray, shape (m, 3)
        ``(model - measured) / sigma``.
    scene : FreeBody or HeavyTop
        The scene with the best values.
    omega : ndarray, shape (3,)
        The rates at the first measurement with the best values (rad/s).
    sensor : ndarray, shape (3, 3)
        The axes of the gyroscope, as columns in the axes of ``omega``: it measures
        ``scale * (omega @ sensor) + bias``. The identity, if ``"sensor"`` is not free.
    evaluations : int
        Number of runs with derivatives.
    searched : int
        Number of minima that were searched.
    """

    success: bool
    reason: str
    names: tuple[str, ...]
    values: Floats
    std: Floats
    covariance: Floats
    undetermined: tuple[str, ...]
    at_bounds: tuple[str, ...]
    others: Floats
    chi2: float
    chi2_per_dof: float
    t: Floats
    measured: Floats
    sigma: Floats
    residuals: Floats
    scene: Scene
    omega: Floats
    sensor: Floats
    evaluations: int
    searched: int

    def __getitem__(self, name: str) -> float:
        """The best value of a parameter by its name."""
        return float(self.values[self.names.index(name)])

    @property
    def model(self) -> Floats:
        """What the gyroscope would measure with the best values (rad/s), shape (m, 3)."""
        return self.measured + self.residuals * self.sigma

    def __repr__(self) -> str:
        rows = [
            (name, f"{value:.6g}", f"± {error:.1g}", _unit(name))
            for name, value, error in zip(self.names, self.values, self.std, strict=True)
        ]
        verdict = f"Fit of {len(self.t)} samples: " + ("" if self.success else "FAILED: ")
        return "\n".join(
            (verdict + self.reason, *aligned(rows, {1}), *self.undetermined, *self.at_bounds)
        )

    def _repr_html_(self) -> str:
        return html_with_picture(lambda ax: self.plot(ax), repr(self))

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw measured rates, the rates of the model, and below them the residuals.

        Parameters
        ----------
        ax : matplotlib Axes, optional
            Where to draw; a new figure if not given. Its lower third is for the residuals.

        Returns
        -------
        matplotlib Axes
            The axes of the rates; the residuals are in the last of ``ax.figure.axes``.

        Raises
        ------
        TypeError, ValueError
            If ``ax`` is no Axes, or no subplot.
        ImportError
            Without matplotlib.

        Examples
        --------
        >>> import numpy as np, rigid
        >>> t, body = np.linspace(0.0, 10.0, 50), rigid.Body((1.0, 1.5, 2.0))
        >>> rates = rigid.simulate(body, [0.1, 1.0, 0.2], t=t).omega
        >>> found = rigid.fit(body, t, omega=rates, sigma=0.01, free=("I3/I1", "omega"))
        >>> found.plot().figure.axes[-1].get_ylabel()
        'residual / sigma'
        """
        ax = axes_to_draw_on(ax)
        place = ax.get_subplotspec()
        if place is None:
            raise ValueError("ax: must be a subplot of its figure, to be divided in two")
        parts = place.subgridspec(2, 1, height_ratios=(2.0, 1.0))
        ax.set_subplotspec(parts[0])
        below = ax.figure.add_subplot(parts[1], sharex=ax)
        for k, ink in enumerate(AXES):
            colour = on_ground(ax, ink.colour)
            ax.plot(self.t, self.measured[:, k], ".", color=colour, markersize=3.0, alpha=0.5)
            ax.plot(self.t, self.model[:, k], color=colour, label=f"$\\omega_{k + 1}$ of the fit")
            below.plot(self.t, self.residuals[:, k], ".", color=colour, markersize=3.0)
        ax.tick_params(labelbottom=False)
        ax.set(ylabel="measured rate (rad/s)")
        below.set(xlabel="t (s)", ylabel="residual / sigma")
        ax.legend()
        return ax

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Save values, covariance, measurements and residuals as an ``.npz`` file.

        :func:`numpy.load` reads it. The arrays have the names of the attributes, and ``scene`` is a
        text in JSON. Nothing is pickled. The file appears whole or not at all.

        Parameters
        ----------
        path : path-like

        Returns
        -------
        Path
            The path.

        Raises
        ------
        ValueError
            If the name does not end in ``.npz``.
        OSError
            Naming the path, if the file cannot be written.

        Examples
        --------
        >>> import os, tempfile, numpy as np, rigid
        >>> t, body = np.linspace(0.0, 10.0, 50), rigid.Body((1.0, 1.5, 2.0))
        >>> rates = rigid.simulate(body, [0.1, 1.0, 0.2], t=t).omega
        >>> found = rigid.fit(body, t, omega=rates, sigma=0.01, free=("I3/I1", "omega"))
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     with np.load(found.save(os.path.join(folder, "fit.npz"))) as file:
        ...         print(file["names"][0], file["values"][0].round(6))
        I3/I1 2.0
        """
        arrays = {name: np.asarray(getattr(self, name)) for name in _SAVED}
        write_archive(path, {**arrays, "scene": json.dumps(self.scene.to_dict())})
        return Path(path)


def _unit(name: str) -> str:
    """The unit of a free parameter; empty of a ratio."""
    unit = _UNITS.get(name)
    return PARAMETERS[name].unit.replace("1", "") if unit is None else unit


@refuses_overflow
def fit(
    scene: Scene | Body,
    t: ArrayLike,
    *,
    omega: ArrayLike,
    sigma: ArrayLike,
    free: str | Sequence[str],
    start: ArrayLike | None = None,
    attitude: ArrayLike | Rotation | None = None,
    frame: ArrayLike | None = None,
    progress: ProgressOption = False,
) -> Fit:
    """Fit parameters and start of a body, and errors of a gyroscope, to measured rates.

    Least squares by Levenberg and Marquardt's method with geodesic acceleration (Transtrum and
    Sethna, arXiv:1201.5885, 2012). The derivative is the tangent of the motion: see
    :attr:`Run.sensitivity`. Moments vary inside what a body can have, because the integrals of the
    squares of its coordinates, ``(I1 + I2 + I3) / 2 - Ik``, are bounded below by zero. A motion
    without torque determines ratios of moments only.

    Over many turns the sum of squares has many minima, one beside each guess whose phase ends up a
    whole turn off. So the fit grows: each arc of the measurements reaches as far as the parameters
    of the previous arc predict the motion to within 1 rad of phase. If chi² shows that the minimum
    of an arc is wrong, the fit starts again with other moments, spread over all possible bodies.

    Where the body turns by more than pi between two samples, a motion with more turns may meet the
    same samples: an alias. Across such a gap other minima are searched. Those that explain the
    measurements as well are :attr:`Fit.others`, and the fit is ambiguous.
    :attr:`Fit.success` says whether the fit succeeded. The work of a fit is bounded.

    Parameters
    ----------
    scene : FreeBody, HeavyTop or Body
        One body, with the first guess of all free parameters and the values of the others.
    t : array_like, shape (m,)
        Ascending times of the measurements (s), from any first time on, such as seconds of an
        epoch. Start and attitude belong to the first of them.
    omega : array_like, shape (m, 3)
        Measured rates in the body (rad/s); of measured attitudes, what
        :func:`rigid.rotations.omega_from_attitudes` returns.
    sigma : float or array_like, shape (3,), (m, 1) or (m, 3)
        Standard deviation of the measurements (rad/s), positive: one, or one for each axis, time,
        or both.
    free : str or sequence of str
        The free parameters: ``"I1"``, ``"I2"``, ``"I3"`` (kg m²) or ratios such as ``"I2/I1"``, of
        which the first moment varies; ``"damping"`` or ``"damping1"`` to ``"damping3"`` (N m s);
        ``"mgl"`` of a top (J); ``"torque1"`` to ``"torque3"`` (N m); the numbers of forces that the
        scene has, by the names of maps: ``"rotor1"``, ``"drag"``, ``"dissipation"``, ``"rate"``,
        ``"eccentricity"``; ``"omega"``, the rates at the first time; of the gyroscope, which
        measures ``scale * omega + bias`` along each axis, ``"bias"`` or ``"bias1"`` to ``"bias3"``
        (rad/s, else 0) and ``"scale"`` or ``"scale1"`` to ``"scale3"`` (else 1); ``"sensor"`` or
        ``"sensor1"`` to ``"sensor3"``, the rotation vector (rad, else 0) that turns the axes of
        ``frame``, or the principal axes, into the axes of the gyroscope, by less than pi / 4 about
        each axis: beyond, the same body has its moments in another order.
    start : array_like, shape (3,), optional
        Rates at the first time, a first guess if ``"omega"`` is free. Default: the measured rates.
    attitude : optional
        Attitude at the first time, as in :func:`simulate`.
    frame : array_like, shape (3, 3), optional
        The axes of the gyroscope, along which ``omega``, ``start`` and ``attitude`` are given, if
        they are not the principal axes, as in :func:`simulate`. Moments and damping belong to the
        principal axes. With ``"sensor"`` they are the first guess of the axes of the gyroscope.
    progress : None, bool or callable
        As in :func:`stability_map`, counting measurements; ``None`` is a bar in a terminal.

    Returns
    -------
    Fit

    Warns
    -----
    FitWarning
        If the fit failed: its chi² is impossible for ``sigma``, it is ambiguous, the search ended
        before it was complete, or no minimum was reached. If the first measured rates are the
        start, and ``"omega"`` is not free.

    Raises
    ------
    ValueError
        Naming the argument and the rule: an unknown or repeated parameter; shapes that do not fit;
        a sigma that is not positive; fewer measurements than parameters; ratios that follow from
        each other; damping that is not diagonal; a torque that is a table; a first time other than
        0 of a scene with a clock, the table of a torque or an orbit; a motion over more than 1e7
        rad; derivatives that overflow in a long chaotic motion.

    Examples
    --------
    >>> import numpy as np, rigid
    >>> t, rng = np.linspace(0.0, 60.0, 600), np.random.default_rng(1)
    >>> run = rigid.simulate(rigid.Body((1.0, 1.5, 2.0)), [0.1, 1.0, 0.2], t=t)
    >>> measured = run.omega + [0.005, 0.0, 0.0] + 0.01 * rng.normal(size=run.omega.shape)
    >>> guess = rigid.Body((1.0, 1.3, 2.1))
    >>> free = ("I2/I1", "I3/I1", "omega", "bias")
    >>> found = rigid.fit(guess, t, omega=measured, sigma=0.01, free=free)
    >>> found.success, bool(0.9 < found.chi2_per_dof < 1.1)
    (True, True)
    >>> bool(abs(found["I2/I1"] - 1.5) < 3 * found.std[0])
    True
    >>> free = ("I1", "I2", "I3", "omega", "bias")
    >>> rigid.fit(guess, t, omega=measured, sigma=0.01, free=free).undetermined
    ('not determined by the data: equal relative changes of I1, I2, I3',)
    """
    scene = check_scene(scene)
    refuse_rods(np.asarray(scene.body.moments))
    times = sorted_times("t", t)
    measured = shaped("omega", omega, 3)
    if measured.shape != (len(times), 3):
        raise ValueError(f"omega: expected shape {(len(times), 3)}, got {measured.shape}")
    if not len(times):
        raise ValueError("t: must hold a time, got shape (0,)")
    has_clock = scene.tables or scene.orbit is not None or "function" in scene.forces
    if times[0] != 0.0 and has_clock:
        raise ValueError(
            f"t[0] = {times[0]:.10g}: must be 0, because the scene has a clock: "
            "subtract the first time from t, and from the times of the torque"
        )
    spread = _checked_sigma(sigma, measured.shape)
    axes = None if frame is None else checked_frame(frame)
    taken = start is None
    start = measured[0] if start is None else vector("start", start, 3)
    fastest = float(np.linalg.norm(measured, axis=1).max())
    unknowns = Unknowns(scene, start, attitude, free, axes, fastest)
    fixed = not any(name in START for name in unknowns.names)
    if taken and fixed:
        warn_caller(
            "start: the first measured rates, with their noise, are taken for exact; give start, "
            "or add 'omega' to free",
            FitWarning,
        )
    if measured.size < len(unknowns.names):
        raise ValueError(
            f"free = {brief(free)}: {len(unknowns.names)} parameters, but {measured.size} measured "
            "numbers"
        )
    # The difference of nearby numbers is exact, so a large first time costs no digit.
    with reporting(progress, len(times), unit=" measurements") as report:
        arcs = Arcs(unknowns, times - times[0], measured, spread, report)
        found, *further = arcs.minima()
        report(len(times))
    if np.isinf(found.gain):
        raise ValueError(
            "t, sigma: the derivatives of the motion over sigma overflow; a shorter time or a "
            "larger sigma is needed"
        )
    base = unknowns.base + unknowns.steer @ found.x
    values, slopes = unknowns.told(base)
    by_value = found.slopes @ np.linalg.inv(slopes @ unknowns.steer)
    covariance, words = _covariance(unknowns, values, by_value, float(np.ptp(times)))
    std = np.sqrt(np.diagonal(covariance))
    freedom = measured.size - len(values)
    others = _others(arcs, found, further, values, std)
    reason = _impossible(arcs, found, freedom, fixed_start=fixed)
    if not reason and others.size:
        reason = _ambiguous(unknowns.names, others[0], values, std, arcs.phases, times)
    reason = "; ".join(filter(None, (reason, arcs.stopped)))
    if not reason and found.gain > _REACHED:
        reason = (
            f"no minimum was reached: chi2 = {found.squares:.6g} would fall by {found.gain:.2g} "
            "or more"
        )
    success = not reason
    if success:
        per = found.squares / max(freedom, 1)
        reason = f"chi2 per degree of freedom = {per:.4g}: noise of the size sigma explains it"
    else:
        warn_caller(f"the fit failed: {reason}", FitWarning)
    varied, rates = unknowns.at(found.x)
    return Fit(
        success=success,
        reason=reason,
        names=unknowns.names,
        values=values,
        std=std,
        covariance=covariance,
        undetermined=words,
        at_bounds=unknowns.edges(found.x),
        others=others,
        chi2=found.squares,
        chi2_per_dof=found.squares / freedom if freedom else np.nan,
        t=times,
        measured=measured,
        sigma=spread,
        residuals=found.residuals.reshape(-1, 3),
        scene=varied,
        omega=rates,
        sensor=unknowns.sensor(found.x),
        evaluations=arcs.evaluations,
        searched=arcs.searched,
    )


def _checked_sigma(sigma: ArrayLike, shape: tuple[int, ...]) -> Floats:
    """The standard deviation of each measured number."""
    given = shaped("sigma", sigma, positive=True, unit="rad/s")
    try:
        return np.broadcast_to(given, shape)
    except ValueError:
        hint = "; one for each time is sigma[:, np.newaxis]" if given.shape == shape[:1] else ""
        raise ValueError(
            f"sigma: expected a number or shape (3,), {(shape[0], 1)} or {shape}, "
            f"got {given.shape}{hint}"
        ) from None


def _impossible(arcs: Arcs, found: Minimum, freedom: int, *, fixed_start: bool) -> str:
    """That chi² is impossible, in words; empty if it is not."""
    chi2, largest, per = found.squares, largest_of(freedom, arcs.searched), max(freedom, 1)
    if chi2 <= largest:
        return ""
    return (
        f"chi2 per degree of freedom = {chi2 / per:.4g}: must be below {largest / per:.4g}; "
        "the minimum is wrong, sigma is too small, or the motion has what no free parameter has"
        + ("; the start is fixed: add 'omega' to free" if fixed_start else "")
    )


def _others(
    arcs: Arcs, found: Minimum, further: Sequence[Minimum], values: Floats, std: Floats
) -> Floats:
    """Values of other minima that noise could exchange with the best, shape (n, k)."""
    unknowns = arcs.unknowns
    most = found.squares + overtaken(len(values), arcs.searched)
    kept = [values]
    for one in further:
        if one.squares <= most:
            other = unknowns.told(unknowns.base + unknowns.steer @ one.x)[0]
            if all(np.any(np.abs(other - known) > _APART * std) for known in kept):
                kept.append(other)
    return np.reshape(kept[1:], (-1, len(values)))


def _ambiguous(
    names: tuple[str, ...],
    other: Floats,
    values: Floats,
    std: Floats,
    phases: Floats,
    times: Floats,
) -> str:
    """Which other values explain the measurements, and where the phase is lost, in words."""
    apart = np.flatnonzero(np.abs(other - values) > _APART * std)
    named = ", ".join(f"{names[k]} = {other[k]:.4g} instead of {values[k]:.4g}" for k in apart)
    gap, wide = int(np.argmax(phases)), int(np.sum(phases > np.pi))
    return (
        f"ambiguous: {named} explains the measurements as well. The phase between samples passes "
        f"pi in {wide} of {len(phases)} gaps: it grows by up to {phases[gap]:.3g} rad from "
        f"t = {times[gap]:.10g} to {times[gap + 1]:.10g}"
    )


def _covariance(
    unknowns: Unknowns, values: Floats, by_value: Floats, span: float
) -> tuple[Floats, tuple[str, ...]]:
    """Covariance of the parameters, and the combinations that are not determined."""
    mass = float(max(unknowns.scene.body.moments))
    rate = float(np.linalg.norm(unknowns.start)) or 1.0
    least = {
        **dict.fromkeys((*MOMENTS, *RATIOS, *SCALE), 0.0),
        **dict.fromkeys((*START, *BIAS), rate),
        **dict.fromkeys(SENSOR, 1.0),
        **dict.fromkeys(DAMPING, mass / (span or 1.0)),
        "mgl": mass * rate**2,
    }
    names = zip(unknowns.names, unknowns.sizes, strict=True)
    sizes = np.maximum(np.abs(values), [least.get(name, size) for name, size in names])
    _, strengths, turns = np.linalg.svd(by_value * sizes, full_matrices=False)
    told = strengths > 1.0 / UNTOLD
    inverse = turns[told].T / strengths[told]
    covariance = sizes[:, np.newaxis] * (inverse @ inverse.T) * sizes
    words = []
    for direction in turns[~told]:
        parts = direction / direction[np.argmax(np.abs(direction))]
        inside = np.abs(parts) > _PART
        covariance[inside, inside] = np.inf
        named = [name for name, used in zip(unknowns.names, inside, strict=True) if used]
        words.append(_combination(named, (parts * sizes)[inside], values[inside]))
    return covariance, tuple(f"not determined by the data: {combination}" for combination in words)


def _combination(names: list[str], changes: Floats, values: Floats) -> str:
    """A combination of parameters that the data leaves undetermined, in words."""
    if len(names) == 1:
        return names[0]
    if values.all() and np.ptp(changes / values) < 1e-4 * np.abs(changes / values).max():
        return f"equal relative changes of {', '.join(names)}"
    parts = changes / changes[np.argmax(np.abs(changes))]
    shares = (f"{name} by {part:+.3g}" for name, part in zip(names, parts, strict=True))
    return f"changes of {', '.join(shares)} together"
