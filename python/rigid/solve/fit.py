"""Moments, damping, weight and start of a body from measured rates, by least squares."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._checks.arguments import brief, nearest, shaped, sorted_times, vector
from ..model.body import Body
from ..model.scene import Scene, check_scene
from .simulate import simulate

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

__all__ = ["Fit", "fit"]

Floats = NDArray[np.float64]

_MOMENTS = ("I1", "I2", "I3")
_RATIOS = tuple(f"{a}/{b}" for a in _MOMENTS for b in _MOMENTS if a != b)
_DAMPING = ("damping1", "damping2", "damping3")
_START = ("omega1", "omega2", "omega3")

_EDGE = 1e-9
"""Share of the moments by which a body stays thicker than a rod or a plate."""

_UNTOLD = 1.0
"""A combination whose relative standard deviation is above this is not determined."""

_PART = 1e-3
"""Smaller parts of a combination that is not determined are not named."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Fit:
    """Parameters of a motion from measured rates, made by :func:`fit`.

    Attributes
    ----------
    names : tuple of str
        The free parameters; ``"omega"`` gives ``"omega1"``, ``"omega2"``, ``"omega3"``.
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
        What ended at the edge of the physical range, in words.
    chi2 : float
        Sum of the squares of the residuals; about ``residuals.size - k`` if model and ``sigma``
        hold.
    residuals : ndarray, shape (m, 3)
        ``(model - measured) / sigma``.
    scene : FreeBody or HeavyTop
        The scene with the best values.
    omega : ndarray, shape (3,)
        The start with the best values (rad/s).
    evaluations : int
        Runs with derivatives that it took.
    """

    names: tuple[str, ...]
    values: Floats
    std: Floats
    covariance: Floats
    undetermined: tuple[str, ...]
    at_bounds: tuple[str, ...]
    chi2: float
    residuals: Floats
    scene: Scene
    omega: Floats
    evaluations: int

    def __getitem__(self, name: str) -> float:
        """The best value of a parameter by its name."""
        return float(self.values[self.names.index(name)])

    def __str__(self) -> str:
        lines = [
            f"{name:<10}{value:.6g} ± {error:.1g}"
            for name, value, error in zip(self.names, self.values, self.std, strict=True)
        ]
        return "\n".join((*lines, *self.undetermined, *self.at_bounds))


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
    """Moments, damping, weight and start of a body from measured rates.

    Least squares by SciPy (trust region with bounds; Branch, Coleman and Li, *SIAM J. Sci. Comput.*
    21 (1999) 1). The derivative is the tangent of the motion: see :attr:`Run.sensitivity`. Moments
    vary inside what a body can have, because the integrals of the squares of its coordinates,
    ``(I1 + I2 + I3) / 2 - Ik``, are bounded below by zero. A motion without torque tells ratios of
    moments only.

    The minimum is that beside the first guess. Over many turns, or where motions part quickly,
    there are others: a ``chi2`` far above the number of measurements tells that the guess was too
    far away. Fit a short piece first, and take its result as the guess for all.

    Parameters
    ----------
    scene : FreeBody, HeavyTop or Body
        One body, with the first guess of all parameters and the values of those that are not free.
    t : array_like, shape (m,)
        Ascending times of the measurements (s).
    omega : array_like, shape (m, 3)
        Measured rates in the body (rad/s).
    sigma : float or array_like, shape (3,) or (m, 3)
        Standard deviation of the measurements (rad/s), positive.
    free : str or sequence of str
        The free parameters: ``"I1"``, ``"I2"``, ``"I3"`` (kg m²) or ratios such as ``"I2/I1"``, of
        which the first moment varies; ``"damping1"`` to ``"damping3"`` (N m s); ``"mgl"`` of a top
        (J); ``"omega"``, the rates at ``t = 0``.
    start : array_like, shape (3,), optional
        Rates at ``t = 0``, a first guess if ``"omega"`` is free. Default: the measured rates if the
        first time is 0.
    attitude : optional
        Attitude at ``t = 0``, as in :func:`simulate`.

    Returns
    -------
    Fit

    Raises
    ------
    ValueError
        Naming the argument and the rule: an unknown parameter or one named twice, shapes that do
        not fit, a sigma that is not positive, no start, less measurements than parameters, damping
        that is not diagonal.
    ImportError
        Without SciPy.

    Examples
    --------
    >>> import numpy as np, rigid
    >>> t, rng = np.linspace(0.0, 20.0, 200), np.random.default_rng(1)
    >>> run = rigid.simulate(rigid.Body((1.0, 1.5, 2.0)), [0.1, 1.0, 0.2], t=t)
    >>> measured = run.omega + 0.01 * rng.normal(size=run.omega.shape)
    >>> guess = rigid.Body((1.0, 1.3, 2.1))
    >>> found = rigid.fit(guess, t, omega=measured, sigma=0.01, free=("I2/I1", "I3/I1", "omega"))
    >>> bool(abs(found["I2/I1"] - 1.5) < 3 * found.std[0])
    True
    >>> rigid.fit(guess, t, omega=measured, sigma=0.01, free=("I1", "I2", "I3")).undetermined
    ('not determined by the data: equal relative changes of I1, I2, I3',)
    """
    try:
        from scipy.optimize import least_squares
    except ImportError:
        raise ImportError("fit() needs SciPy: pip install 'rigid[maps]'") from None
    scene = check_scene(scene)
    times = sorted_times("t", t)
    measured = shaped("omega", omega, 3)
    if measured.shape != (len(times), 3):
        raise ValueError(f"omega: expected shape {(len(times), 3)}, got {measured.shape}")
    spread = np.broadcast_to(shaped("sigma", sigma, positive=True), measured.shape)
    if start is None:
        if not len(times) or times[0] != 0.0:
            raise ValueError("start: is needed, because the first time is not 0")
        start = measured[0]
    model = _Model(scene, vector("start", start, 3), free)
    if measured.size < len(model.names):
        raise ValueError(
            f"free = {brief(free)}: {len(model.names)} parameters, but {measured.size} measured "
            "numbers"
        )

    last: list[Any] = [None, None, None, 0]

    def evaluated(x: Floats) -> None:
        if last[0] is not None and np.array_equal(last[0], x):
            return
        varied, rates = model.at(x)
        run = simulate(
            varied, rates, attitude, t=times, record="rates", check=False, tangent=model.tangent
        )
        assert run.tangent is not None
        columns = [run.tangent[:, :3, :3]]
        if run.sensitivity is not None:
            columns.insert(0, run.sensitivity[:, :3])
        by_base = np.concatenate(columns, axis=-1)[..., model.columns] / spread[..., np.newaxis]
        last[:] = [x.copy(), (run.omega - measured) / spread, by_base, last[3] + 1]

    def residuals(x: Floats) -> Floats:
        evaluated(x)
        return np.asarray(last[1]).ravel()

    def jacobian(x: Floats) -> Floats:
        evaluated(x)
        return np.asarray(last[2]).reshape(measured.size, -1) @ model.steer

    found = least_squares(
        residuals,
        model.first,
        jacobian,
        bounds=model.bounds,
        x_scale=model.sizes,
        xtol=1e-12,
        ftol=1e-12,
        gtol=1e-12,
    )
    evaluated(found.x)
    varied, rates = model.at(found.x)
    base = model.base + model.steer @ found.x
    values, slopes = model.told(base)
    by_value = np.asarray(last[2]).reshape(measured.size, -1) @ np.linalg.inv(slopes)
    span = float(np.ptp(np.append(times, 0.0)))
    covariance, words = _covariance(model, values, by_value, base, span)
    return Fit(
        names=model.names,
        values=values,
        std=np.sqrt(np.diagonal(covariance)),
        covariance=covariance,
        undetermined=words,
        at_bounds=model.edges(found.x),
        chi2=float(np.sum(np.square(last[1]))),
        residuals=np.asarray(last[1]),
        scene=varied,
        omega=rates,
        evaluations=int(last[3]),
    )


class _Model:
    """The free parameters, and the numbers inside boxes by which they vary.

    The base numbers are free moments, damping, weight and rates; ``base + steer @ x`` gives them
    from coordinates ``x`` with bounds.
    """

    def __init__(self, scene: Scene, start: Floats, free: str | Sequence[str]) -> None:
        self.scene, self.start = scene, start
        self.names = _checked_names(scene, free)
        moments = [name for name in self.names if name in (*_MOMENTS, *_RATIOS)]
        self.moving = sorted(_MOMENTS.index(name[:2]) for name in moments)
        if len(set(self.moving)) < len(self.moving):
            raise ValueError(f"free = {brief(free)}: one moment varies by two of the parameters")
        # The base numbers, in the order of the names, each moment in the place of its name.
        self.numbers = tuple(name[:2] if name in moments else name for name in self.names)
        matrix = np.zeros((3, 3)) if scene.damping is None else np.array(scene.damping)
        if any(name in _DAMPING for name in self.names) and np.any(
            matrix - np.diag(np.diagonal(matrix))
        ):
            raise ValueError("free: damping is fitted along the axes; that of the scene is not")
        self.damping = matrix
        base = tuple(name for name in self.numbers if name not in _START)
        self.tangent: bool | tuple[str, ...] = base or True
        known = [*base, *_START]
        self.columns = [known.index(name) for name in self.numbers]
        self._boxes()

    def _boxes(self) -> None:
        i = np.array(self.scene.body.moments)
        unit = float(i.max())
        self.base = np.zeros(len(self.numbers))
        self.steer = np.eye(len(self.numbers))
        low, high = np.full(len(self.numbers), -np.inf), np.full(len(self.numbers), np.inf)
        first, sizes = self.base.copy(), np.ones(len(self.numbers))
        mean = float(np.linalg.norm(self.start)) or 1.0
        for k, name in enumerate(self.numbers):
            if name in _START:
                first[k], sizes[k] = self.start[_START.index(name)], mean
            elif name in _DAMPING:
                j = _DAMPING.index(name)
                first[k], low[k], sizes[k] = self.damping[j, j], 0.0, unit * mean
            elif name == "mgl":
                first[k] = self.scene.mgl  # type: ignore[attr-defined]
                low[k], sizes[k] = 0.0, first[k] or unit * mean**2
        place = {j: self.numbers.index(_MOMENTS[j]) for j in self.moving}
        squares = 0.5 * i.sum() - i  # the integrals of x², y², z² over the mass
        edge = _EDGE * unit
        if len(place) == 1:
            ((j, k),) = place.items()
            others = np.delete(i, j)
            low[k], high[k] = abs(others[0] - others[1]) + edge, others.sum() - edge
            first[k], sizes[k] = np.clip(i[j], low[k] + edge, high[k] - edge), unit
        elif len(place) == 2:
            # The fixed moment is the sum of two squares: one varies, and the third does.
            (j, m), fixed = self.moving, 3 - sum(self.moving)
            a, b = place[j], place[m]
            self.base[a] = i[fixed]
            self.steer[np.ix_([a, b], [a, b])] = [[-1.0, 1.0], [1.0, 1.0]]
            low[[a, b]], high[a] = edge, i[fixed] - edge
            first[a] = np.clip(squares[j], 2 * edge, i[fixed] - 2 * edge)
            first[b], sizes[[a, b]] = max(squares[fixed], 2 * edge), unit
        elif len(place) == 3:
            rows = [place[j] for j in range(3)]
            self.steer[np.ix_(rows, rows)] = 1.0 - np.eye(3)
            low[rows], sizes[rows] = edge, unit
            first[rows] = np.maximum(squares, 2 * edge)
        self.bounds, self.first, self.sizes = (low, high), first, sizes

    def at(self, x: Floats) -> tuple[Scene, Floats]:
        """Scene and start of coordinates."""
        values = dict(zip(self.numbers, (self.base + self.steer @ x).tolist(), strict=True))
        moments = [
            values.get(name, old)
            for name, old in zip(_MOMENTS, self.scene.body.moments, strict=True)
        ]
        rates = [values.get(name, old) for name, old in zip(_START, self.start, strict=True)]
        own = {"mgl": values["mgl"]} if "mgl" in values else {}
        damping = self.scene.damping
        if any(name in values for name in _DAMPING):
            diagonal = [values.get(name, self.damping[j, j]) for j, name in enumerate(_DAMPING)]
            damping = np.diag(diagonal)
        return self.scene.replaced(Body(moments), damping, **own), np.array(rates)

    def told(self, base: Floats) -> tuple[Floats, Floats]:
        """Values of the named parameters, and their derivatives by the base numbers."""
        values, slopes = base.copy(), np.eye(len(base))
        moments = dict(zip(_MOMENTS, self.scene.body.moments, strict=True))
        moments |= {n: v for n, v in zip(self.numbers, base, strict=True) if n in _MOMENTS}
        for k, name in enumerate(self.names):
            if name in _RATIOS:
                above, below = moments[name[:2]], moments[name[3:]]
                values[k], slopes[k, k] = above / below, 1.0 / below
                if name[3:] in self.numbers:
                    slopes[k, self.numbers.index(name[3:])] = -above / below**2
        return values, slopes

    def edges(self, x: Floats) -> tuple[str, ...]:
        """What lies at its bound, in words."""
        low, high = self.bounds
        near = (x - low < 1e-6 * self.sizes) | (high - x < 1e-6 * self.sizes)
        words = [
            f"{name} is zero, the least that it can be"
            for name, is_near in zip(self.numbers, near, strict=True)
            if is_near and name not in _MOMENTS
        ]
        if any(near[k] for k, name in enumerate(self.numbers) if name in _MOMENTS):
            words.append("the moments are those of a flat body, the edge of what a body can have")
        return tuple(words)


def _covariance(
    model: _Model, values: Floats, by_value: Floats, base: Floats, span: float
) -> tuple[Floats, tuple[str, ...]]:
    """Covariance of the parameters, and the combinations that are not determined."""
    mass = float(max(model.scene.body.moments))
    rate = float(np.linalg.norm(model.start)) or 1.0
    sizes = np.empty(len(values))
    for k, name in enumerate(model.names):
        least = {"mgl": mass * rate**2}.get(name, rate if name in _START else mass / (span or 1.0))
        relative = name in _MOMENTS or name in _RATIOS
        sizes[k] = abs(values[k]) if relative else max(abs(values[k]), least)
    _, strengths, turns = np.linalg.svd(by_value * sizes, full_matrices=True)
    strengths = np.append(strengths, np.zeros(len(values) - len(strengths)))
    told = strengths > 1.0 / _UNTOLD
    inverse = turns[told].T / strengths[told]
    covariance = sizes[:, np.newaxis] * (inverse @ inverse.T) * sizes
    words = []
    for direction in turns[~told]:
        parts = direction / direction[np.argmax(np.abs(direction))]
        inside = np.abs(parts) > _PART
        covariance[inside, inside] = np.inf
        named = [name for name, used in zip(model.names, inside, strict=True) if used]
        if len(named) == 1:
            words.append(f"not determined by the data: {named[0]}")
        elif np.allclose(parts[inside], 1.0, atol=1e-4):
            words.append(
                f"not determined by the data: equal relative changes of {', '.join(named)}"
            )
        else:
            shares = ", ".join(
                f"{name} by {part:+.3g}" for name, part in zip(named, parts[inside], strict=True)
            )
            words.append(f"not determined by the data: relative changes of {shares} together")
    return covariance, tuple(words)


def _checked_names(scene: Scene, free: str | Sequence[str]) -> tuple[str, ...]:
    known = (*_MOMENTS, *_RATIOS, *_DAMPING, "omega", *(("mgl",) if "mgl" in scene.fields else ()))
    given = (free,) if isinstance(free, str) else free
    if not isinstance(given, Sequence) or not given:
        raise ValueError(f"free = {brief(free)}: must be names of parameters")
    names: list[str] = []
    for name in given:
        if name not in known:
            raise ValueError(
                f"free = {brief(name)}: is no parameter of a {scene.title}; known are "
                f"{', '.join(map(repr, known))}{nearest(str(name), known)}"
            )
        for own in _START if name == "omega" else (name,):
            if own in names:
                raise ValueError(f"free = {brief(free)}: {name!r} is named twice")
            names.append(own)
    return tuple(names)
