"""Moments, damping, weight and start of a body, and a gyroscope's errors, from measured rates."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._checks.arguments import brief, shaped, sorted_times, vector
from .._checks.shown import short_repr
from ..model.body import Body, refuse_rods
from ..model.scene import Scene, check_scene
from .arcs import Arcs, largest_chi2
from .least_squares import UNTOLD
from .unknowns import BIAS, MOMENTS, RATIOS, SCALE, START, Unknowns

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

__all__ = ["Fit", "FitWarning", "fit"]

Floats = NDArray[np.float64]

_PART = 1e-3
"""Least coefficient that is named in a combination that is not determined."""

_REACHED = 0.01
"""A minimum is reached if a whole step would lower chi² by less than this: a tenth of a std."""


class FitWarning(UserWarning):
    """The warning that a fit failed."""


@short_repr
@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Fit:
    """Parameters of a motion with their covariance, fitted to measured rates by :func:`fit`.

    Attributes
    ----------
    success : bool
        Whether a minimum was reached, and its ``chi2`` is possible: noise of the given ``sigma``
        has a larger one in less than one of a million fits.
    reason : str
        The reason for success or failure, in words.
    names : tuple of str
        The free parameters; ``"omega"`` gives ``"omega1"``, ``"omega2"``, ``"omega3"``, and so do
        ``"bias"`` and ``"scale"``.
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
    chi2 : float
        Sum of the squares of the residuals.
    chi2_per_dof : float
        ``chi2 / (residuals.size - k)``: about 1 if model and ``sigma`` hold; far below 1 if
        ``sigma`` is larger than the noise. NaN for as many parameters as numbers.
    residuals : ndarray, shape (m, 3)
        ``(model - measured) / sigma``.
    scene : FreeBody or HeavyTop
        The scene with the best values.
    omega : ndarray, shape (3,)
        The start with the best values (rad/s).
    evaluations : int
        Number of runs with derivatives.
    """

    success: bool
    reason: str
    names: tuple[str, ...]
    values: Floats
    std: Floats
    covariance: Floats
    undetermined: tuple[str, ...]
    at_bounds: tuple[str, ...]
    chi2: float
    chi2_per_dof: float
    residuals: Floats
    scene: Scene
    omega: Floats
    evaluations: int

    def __getitem__(self, name: str) -> float:
        """The best value of a parameter by its name."""
        return float(self.values[self.names.index(name)])

    def __str__(self) -> str:
        failure = () if self.success else (f"FAILED: {self.reason}",)
        lines = [
            f"{name:<10}{value:.6g} ± {error:.1g}"
            for name, value, error in zip(self.names, self.values, self.std, strict=True)
        ]
        return "\n".join((*failure, *lines, *self.undetermined, *self.at_bounds))


def fit(
    scene: Scene | Body,
    t: ArrayLike,
    *,
    omega: ArrayLike,
    sigma: ArrayLike,
    free: str | Sequence[str],
    start: ArrayLike | None = None,
    attitude: ArrayLike | Rotation | None = None,
) -> Fit:
    """Fit moments, damping, weight and start of a body, and gyroscope errors, to measured rates.

    Least squares by Levenberg and Marquardt's method with geodesic acceleration (Transtrum and
    Sethna, arXiv:1201.5885, 2012). The derivative is the tangent of the motion: see
    :attr:`Run.sensitivity`. Moments vary inside what a body can have, because the integrals of the
    squares of its coordinates, ``(I1 + I2 + I3) / 2 - Ik``, are bounded below by zero. A motion
    without torque determines ratios of moments only.

    Over many turns the sum of squares has many minima, one beside each guess whose phase ends up a
    whole turn off. So the fit grows: each arc of the measurements reaches as far as the parameters
    of the previous arc predict the motion to within 1 rad of phase. If chi² shows that the minimum
    of an arc is wrong, the fit starts again with other moments, spread over all possible bodies.
    :attr:`Fit.success` says whether the fit succeeded.

    Parameters
    ----------
    scene : FreeBody, HeavyTop or Body
        One body, with the first guess of all free parameters and the values of the others.
    t : array_like, shape (m,)
        Ascending times of the measurements (s).
    omega : array_like, shape (m, 3)
        Measured rates in the body (rad/s).
    sigma : float or array_like, shape (3,) or (m, 3)
        Standard deviation of the measurements (rad/s), positive.
    free : str or sequence of str
        The free parameters: ``"I1"``, ``"I2"``, ``"I3"`` (kg m²) or ratios such as ``"I2/I1"``, of
        which the first moment varies; ``"damping1"`` to ``"damping3"`` (N m s); ``"mgl"`` of a top
        (J); ``"omega"``, the rates at ``t = 0``; of the gyroscope, which measures ``scale * omega +
        bias`` along each axis, ``"bias"`` or ``"bias1"`` to ``"bias3"`` (rad/s, else 0) and
        ``"scale"`` or ``"scale1"`` to ``"scale3"`` (else 1).
    start : array_like, shape (3,), optional
        Rates at ``t = 0``, a first guess if ``"omega"`` is free. Default: the measured rates if the
        first time is 0.
    attitude : optional
        Attitude at ``t = 0``, as in :func:`simulate`.

    Returns
    -------
    Fit

    Warns
    -----
    FitWarning
        If the fit failed: its chi² is impossible for ``sigma``, or no minimum was reached. If the
        first measured rates are the start, and ``"omega"`` is not free.

    Raises
    ------
    ValueError
        Naming the argument and the rule: an unknown or repeated parameter; shapes that do not fit;
        a sigma that is not positive; no start; fewer measurements than parameters; ratios that
        follow from each other; damping that is not diagonal; derivatives that overflow in a long
        chaotic motion.

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
    spread = np.broadcast_to(shaped("sigma", sigma, positive=True), measured.shape)
    taken = False
    if start is None:
        if not len(times) or times[0] != 0.0:
            raise ValueError("start: is needed, because the first time is not 0")
        start, taken = measured[0], True
    unknowns = Unknowns(scene, vector("start", start, 3), attitude, free)
    fixed = not any(name in START for name in unknowns.names)
    if taken and fixed:
        warnings.warn(
            "start: the first measured rates, with their noise, are taken for exact; give start, "
            "or add 'omega' to free",
            FitWarning,
            stacklevel=2,
        )
    if measured.size < len(unknowns.names):
        raise ValueError(
            f"free = {brief(free)}: {len(unknowns.names)} parameters, but {measured.size} measured "
            "numbers"
        )
    arcs = Arcs(unknowns, times, measured, spread)
    found = arcs.minimum()
    if np.isinf(found.gain):
        raise ValueError(
            "t, sigma: the derivatives of the motion over sigma overflow; a shorter time or a "
            "larger sigma is needed"
        )
    base = unknowns.base + unknowns.steer @ found.x
    values, slopes = unknowns.told(base)
    by_value = found.slopes @ np.linalg.inv(slopes @ unknowns.steer)
    span = float(np.ptp(np.append(times, 0.0)))
    covariance, words = _covariance(unknowns, values, by_value, span)
    freedom = measured.size - len(values)
    success, reason = _verdict(found.squares, found.gain, freedom, fixed_start=fixed)
    if not success:
        warnings.warn(f"the fit failed: {reason}", FitWarning, stacklevel=2)
    varied, rates = unknowns.at(found.x)
    return Fit(
        success=success,
        reason=reason,
        names=unknowns.names,
        values=values,
        std=np.sqrt(np.diagonal(covariance)),
        covariance=covariance,
        undetermined=words,
        at_bounds=unknowns.edges(found.x),
        chi2=found.squares,
        chi2_per_dof=found.squares / freedom if freedom else np.nan,
        residuals=found.residuals.reshape(-1, 3),
        scene=varied,
        omega=rates,
        evaluations=arcs.evaluations,
    )


def _verdict(chi2: float, gain: float, freedom: int, *, fixed_start: bool) -> tuple[bool, str]:
    """Whether a fit succeeded, and why, in words."""
    largest, per = largest_chi2(freedom), max(freedom, 1)
    if not chi2 <= largest:
        return False, (
            f"chi2 per degree of freedom = {chi2 / per:.4g}: must be below {largest / per:.4g}; "
            "the minimum is wrong, sigma is too small, or the motion has what no free parameter has"
            + ("; the start is fixed: add 'omega' to free" if fixed_start else "")
        )
    if gain > _REACHED:
        return False, f"no minimum was reached: chi2 = {chi2:.6g} would fall by {gain:.2g} or more"
    return True, f"chi2 per degree of freedom = {chi2 / per:.4g}: is below {largest / per:.4g}"


def _covariance(
    unknowns: Unknowns, values: Floats, by_value: Floats, span: float
) -> tuple[Floats, tuple[str, ...]]:
    """Covariance of the parameters, and the combinations that are not determined."""
    mass = float(max(unknowns.scene.body.moments))
    rate = float(np.linalg.norm(unknowns.start)) or 1.0
    sizes = np.empty(len(values))
    for k, name in enumerate(unknowns.names):
        if name in (*MOMENTS, *RATIOS, *SCALE):
            least = 0.0
        elif name in (*START, *BIAS):
            least = rate
        else:
            least = mass * rate**2 if name == "mgl" else mass / (span or 1.0)
        sizes[k] = max(abs(values[k]), least)
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
