"""Perturbations of starts and parameters: their distributions, or a list of samples."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._checks.arguments import (
    finite_float,
    first_place,
    numbers,
    of_shape,
    one_of,
    truth,
    vector,
)
from .._checks.arrays import unit_quaternions

NOISE_KINDS = ("normal", "uniform", "direction", "uniform_attitude", "von_mises_fisher")

MOST_SAMPLES = 100_000
"""Most entries of a list of samples: a specification holds them as text."""


@dataclass(frozen=True, slots=True)
class Noise:
    """The distribution of a random perturbation, made by :func:`normal` and its siblings.

    Attributes
    ----------
    kind : str
        One of ``"normal"``, ``"uniform"``, ``"direction"``, ``"uniform_attitude"``,
        ``"von_mises_fisher"``.
    size : float or tuple of 3 floats
        Size of the distribution, one number or one for each body axis: rad/s for rates, rad for an
        attitude; the concentration of ``"von_mises_fisher"``.
    cov : tuple of tuples of float, or None
        Covariance of normal deviates that hang together, 3 x 3, or 6 x 6 of the rates and then the
        attitude. The size is 1 then.
    relative : bool
        Whether the size is a share of the nominal value, for the parameters of bodies.
    high : float or None
        The largest value of a uniform distribution from ``size`` to ``high``, for the parameters of
        bodies; None of deviations about the nominal value.
    """

    kind: str
    size: float | tuple[float, float, float] = 1.0
    cov: tuple[tuple[float, ...], ...] | None = None
    relative: bool = False
    high: float | None = None

    def __post_init__(self) -> None:
        one_of("kind", self.kind, NOISE_KINDS)
        if self.high is not None:
            self._check_ends()
            return
        object.__setattr__(self, "size", _size(self.size))
        if self.is_direction and isinstance(self.size, tuple):
            raise ValueError("kappa: expected a single concentration, got 3 numbers")
        if self.cov is not None:
            if self.kind != "normal" or self.size != 1.0:
                raise ValueError("cov: belongs to normal noise without a size; use normal(cov=...)")
            object.__setattr__(self, "cov", _covariance(self.cov))
            self.factor()

    def _check_ends(self) -> None:
        """Check the two ends of a range of values."""
        low, high = finite_float("size", self.size), finite_float("high", self.high)
        if self.kind != "uniform" or self.cov is not None or self.relative:
            raise ValueError(
                f"high = {high:g}: belongs to rigid.uniform(low, high), whose values do not depend "
                "on a nominal one"
            )
        if not low < high:
            raise ValueError(f"high = {high:g}: must be above the low end, {low:g}")
        object.__setattr__(self, "size", low)
        object.__setattr__(self, "high", high)

    @property
    def is_plain_normal(self) -> bool:
        """Whether the distribution is normal with independent components."""
        return self.kind == "normal" and self.cov is None

    @property
    def is_direction(self) -> bool:
        """Whether it is a distribution of directions, whose size is a concentration."""
        return self.kind == "von_mises_fisher"

    def factor(self) -> NDArray[np.float64]:
        """The lower triangular factor of the covariance, ``cov = factor @ factor.T``.

        Raises
        ------
        ValueError
            If the covariance is not positive semi-definite.
        """
        assert self.cov is not None
        return _lower_factor(self.cov)

    def to_dict(self) -> dict[str, Any]:
        """The noise as a JSON-able dictionary."""
        size = list(self.size) if isinstance(self.size, tuple) else self.size
        if self.cov is not None:
            return {"kind": self.kind, "cov": [list(row) for row in self.cov]}
        relative = {"relative": True} if self.relative else {}
        ends = {} if self.high is None else {"high": self.high}
        return {"kind": self.kind, "size": size, **relative, **ends}

    def describe(self, *, varied: bool = False) -> str:
        """The noise in words; ``varied`` if an axis of a map sets its size."""
        if self.kind == "uniform_attitude":
            return "uniform_attitude()"
        if varied:
            return f"{self.kind}(varied)"
        if self.cov is not None:
            return f"{self.kind}(cov {len(self.cov)} x {len(self.cov)})"
        if self.high is not None:
            return f"{self.kind}({self.size:g}, {self.high:g})"
        sizes = self.size if isinstance(self.size, tuple) else (self.size,)
        relative = ", relative" if self.relative else ""
        return f"{self.kind}({', '.join(f'{size:g}' for size in sizes)}{relative})"


def _size(value: Any) -> float | tuple[float, float, float]:
    if np.ndim(value) == 0:
        return finite_float("size", value, nonnegative=True)
    first, second, third = (
        finite_float("size", component, nonnegative=True)
        for component in vector("size", value, 3).tolist()
    )
    return first, second, third


def _covariance(value: Any) -> tuple[tuple[float, ...], ...]:
    """A symmetric matrix of finite numbers, 3 x 3 or 6 x 6."""
    array = numbers("cov", value)
    if array.shape not in ((3, 3), (6, 6)):
        raise ValueError(f"cov: expected shape (3, 3) or (6, 6), got {array.shape}")
    of_shape("cov", array)
    differs = array != array.T
    if differs.any():
        index, place = first_place(differs)
        raise ValueError(
            f"cov{place} = {array[index]:g}: must be symmetric; the entry across is "
            f"{array[index[::-1]]:g}"
        )
    return tuple(tuple(row) for row in array.tolist())


_ROUNDED = 8.0 * np.finfo(np.float64).eps
"""Error of the computed length of a unit quaternion."""

_RANK = 1e-13
"""Pivots below this share of the variance are zero: the rest of their column is rounding."""


def _lower_factor(cov: tuple[tuple[float, ...], ...]) -> NDArray[np.float64]:
    """Cholesky's factor of a positive semi-definite matrix; ValueError for other matrices.

    It uses scalars in a fixed order, so that its bits are the same on every machine; the bits of
    LAPACK are not.
    """
    n = len(cov)
    factor = np.zeros((n, n))
    for k in range(n):
        pivot = cov[k][k]
        for j in range(k):
            pivot -= float(factor[k, j]) * float(factor[k, j])
        if pivot < -_RANK * abs(cov[k][k]):
            raise ValueError("cov: must be positive semi-definite")
        is_zero = pivot <= _RANK * cov[k][k]
        factor[k, k] = 0.0 if is_zero else math.sqrt(pivot)
        for i in range(k + 1, n):
            rest = cov[i][k]
            for j in range(k):
                rest -= float(factor[i, j]) * float(factor[k, j])
            if not is_zero:
                factor[i, k] = rest / float(factor[k, k])
            elif abs(rest) > math.sqrt(_RANK * max(cov[i][i], 0.0) * cov[k][k]):
                raise ValueError("cov: must be positive semi-definite")
    return factor


def normal(
    size: float | ArrayLike | None = None,
    *,
    cov: ArrayLike | None = None,
    relative: bool = False,
) -> Noise:
    """Normal perturbations, ``size * N(0, 1)`` of each body component, or ``N(0, cov)``.

    Parameters
    ----------
    size : float or array_like, shape (3,)
        Standard deviation: rad/s for rates; rad for an attitude, where the deviates are the
        components of a rotation vector applied on the body side.
    cov : array_like, shape (3, 3) or (6, 6), optional
        Instead of a size, the covariance of the components. One of shape (6, 6), of the three rates
        and then the three components of the rotation vector, is given as the ``noise`` of a start
        without an ``attitude_noise``.
    relative : bool
        The size is a share of the nominal value: for ``vary=`` of :func:`stability_map`.

    Returns
    -------
    Noise

    Raises
    ------
    ValueError
        If a size is negative or not finite, a covariance is not symmetric and positive
        semi-definite, or not just one of them is given.

    Examples
    --------
    >>> import rigid
    >>> rigid.normal(1e-3).size
    0.001
    >>> rigid.normal([1e-3, 0.0, 1e-3]).size
    (0.001, 0.0, 0.001)
    >>> rigid.normal(cov=[[4e-6, 2e-6, 0.0], [2e-6, 4e-6, 0.0], [0.0, 0.0, 1e-8]]).describe()
    'normal(cov 3 x 3)'
    """
    if (size is None) == (cov is None):
        raise ValueError("size, cov: give one of the two to normal()")
    if size is None:
        return Noise("normal", cov=cov)  # type: ignore[arg-type]  # normalised in __post_init__
    return Noise("normal", size, relative=relative)  # type: ignore[arg-type]


def uniform(size: float | ArrayLike, high: float | None = None, *, relative: bool = False) -> Noise:
    """Independent uniform perturbations ``size * U(-1, 1)`` of each body component.

    The size is as in :func:`normal`. With two numbers: values of a parameter from the first to the
    second, whatever its nominal value, for ``vary=`` of :func:`stability_map`.

    Parameters
    ----------
    size : float or array_like, shape (3,)
        Largest deviation: rad/s for rates; rad for an attitude, where the deviates are the
        components of a rotation vector applied on the body side. With ``high`` the least value.
    high : float, optional
        The largest value.
    relative : bool
        The size is a share of the nominal value: for ``vary=`` of :func:`stability_map`.

    Returns
    -------
    Noise

    Raises
    ------
    ValueError
        If a size is negative or not finite; if ``high`` is not above the least value, or is given
        with ``relative``.

    Examples
    --------
    >>> import rigid
    >>> rigid.Start(spin=1.0, noise=rigid.uniform([0.1, 0.0, 0.1])).noise.size
    (0.1, 0.0, 0.1)
    >>> rigid.uniform(0.01, 0.1).describe()
    'uniform(0.01, 0.1)'
    """
    return Noise("uniform", size, relative=relative, high=high)  # type: ignore[arg-type]


@dataclass(frozen=True, slots=True)
class Samples:
    """A list of perturbations, of which each body takes one; made by :func:`samples`.

    Attributes
    ----------
    omega : tuple of tuples of 3 floats
        Additions to the rates (rad/s).
    attitude : tuple of tuples of 4 floats, or None
        As many rotations, unit quaternions, applied on the body side.
    weights : tuple of floats, or None
        How likely each entry is taken, up to a common factor; None if all are alike.
    in_order : bool
        Whether body k of each pixel takes entry k, and begins again after the last.
    """

    omega: tuple[tuple[float, ...], ...]
    attitude: tuple[tuple[float, ...], ...] | None = None
    weights: tuple[float, ...] | None = None
    in_order: bool = False

    def __post_init__(self) -> None:
        omega = _rows("omega", self.omega, 3)
        object.__setattr__(self, "omega", tuple(map(tuple, omega.tolist())))
        if not 0 < len(omega) <= MOST_SAMPLES:
            raise ValueError(f"omega: {len(omega)} samples, must be 1 to {MOST_SAMPLES:,}")
        if self.attitude is not None:
            attitude = _rows("attitude", self.attitude, 4)
            _same_count("attitude", len(attitude), len(omega))
            # Unit to rounding stays: a file gives back the same samples.
            off = np.abs(np.sqrt((attitude * attitude).sum(axis=1)) - 1.0) > _ROUNDED
            attitude = np.where(
                off[:, np.newaxis], unit_quaternions("attitude", attitude), attitude
            )
            object.__setattr__(self, "attitude", tuple(map(tuple, attitude.tolist())))
        truth("in_order", self.in_order)
        if self.weights is not None:
            if self.in_order:
                raise ValueError("weights: samples that are used in order have none")
            weights = numbers("weights", self.weights)
            if weights.ndim != 1:
                raise ValueError(f"weights: expected shape (n,), got {weights.shape}")
            _same_count("weights", len(weights), len(omega))
            if not (np.isfinite(weights).all() and (weights >= 0.0).all() and weights.any()):
                raise ValueError("weights: must be finite, not negative, and not all zero")
            object.__setattr__(self, "weights", tuple(weights.tolist()))

    @property
    def is_plain_normal(self) -> bool:
        """No: nothing is known of the distribution of the samples."""
        return False

    @property
    def turns(self) -> bool:
        """Whether the samples perturb the attitude."""
        return self.attitude is not None

    def shares(self) -> NDArray[np.float64] | None:
        """Cumulative chances of the entries, the last 1; None if they are used in order."""
        if self.in_order:
            return None
        return cumulative(np.ones(len(self.omega)) if self.weights is None else self.weights)

    def to_dict(self) -> dict[str, Any]:
        """The samples as a JSON-able dictionary."""
        return {"kind": "samples", **plain_fields(self)}

    def describe(self, *, varied: bool = False) -> str:
        """The samples in words; no axis of a map varies them."""
        del varied
        how = ", in order" if self.in_order else "" if self.weights is None else ", weighted"
        return f"{len(self.omega)} given samples{' with attitudes' * self.turns}{how}"


def cumulative(weights: ArrayLike) -> NDArray[np.float64]:
    """Cumulative chances by weights, the last 1."""
    sums = np.cumsum(np.asarray(weights) / np.max(weights))
    shares: NDArray[np.float64] = sums / sums[-1]
    return shares


def plain_fields(value: Any) -> dict[str, Any]:
    """The fields of a dataclass by their names, with lists for tuples, as JSON has them."""
    return {own.name: _plain(getattr(value, own.name)) for own in fields(value)}


def _plain(value: Any) -> Any:
    if isinstance(value, tuple):
        return [_plain(one) for one in value]
    return value.to_dict() if hasattr(value, "to_dict") else value


def _rows(name: str, value: Any, width: int) -> NDArray[np.float64]:
    array = numbers(name, value)
    if array.ndim != 2 or array.shape[1] != width:
        raise ValueError(f"{name}: expected shape (n, {width}), got {array.shape}")
    return of_shape(name, array)


def _same_count(name: str, count: int, wanted: int) -> None:
    if count != wanted:
        raise ValueError(f"{name}: {count} samples, but omega has {wanted}")


def samples(
    omega: ArrayLike | None = None,
    attitude: ArrayLike | None = None,
    weights: ArrayLike | None = None,
    *,
    in_order: bool = False,
) -> Samples:
    """Perturbations from a list, as the ``noise`` of a start.

    Each body takes one entry: its rates are the rates of the start plus ``omega``, its attitude is
    the attitude of the start times ``attitude``. With a start of rates 0 and no tilt they are the
    starts themselves.

    Parameters
    ----------
    omega : array_like, shape (n, 3), optional
        Additions to the rates (rad/s); default zero.
    attitude : array_like, shape (n, 4), optional
        Rotations, as unit quaternions, applied on the body side.
    weights : array_like, shape (n,), optional
        How likely each entry is taken, up to a common factor; by default all are alike. Entries are
        drawn with replacement.
    in_order : bool
        Body k of each pixel takes entry k instead, and begins again after the last.

    Returns
    -------
    Samples

    Raises
    ------
    ValueError
        If shapes do not fit or there are more than 100 000, a number is not finite, a quaternion
        has no length of 1, weights are negative or all zero, or nothing is given.

    Examples
    --------
    Tops of one energy and one ``L·gamma``:

    >>> import rigid
    >>> top = rigid.HeavyTop(rigid.Body((1.0, 1.3, 0.7)), mgl=1.0)
    >>> given = rigid.samples(*rigid.top.on_surface(top, energy=2.0, l_gamma=0.4, count=50, rng=1))
    >>> result = rigid.stability_map(
    ...     top, axes={"t_end": [1.0, 10.0]}, samples=200, stable=rigid.tilt_below(1.5), rng=1,
    ...     start=rigid.Start(omega=(0.0, 0.0, 0.0), noise=given),
    ... )
    >>> starts = result.starts(range(3))
    >>> constants = rigid.top.heavy_constants(top, starts.omega[0], starts.attitude[0])
    >>> constants.energy.round(9).tolist()
    [2.0, 2.0, 2.0]
    """
    if omega is None and attitude is None:
        raise ValueError("samples() needs omega, attitude or both")
    if omega is None:
        omega = np.zeros((len(_rows("attitude", attitude, 4)), 3))
    return Samples(omega, attitude, weights, in_order)  # type: ignore[arg-type]  # normalised


def direction(size: float | ArrayLike) -> Noise:
    """A perturbation of fixed length ``size`` in a random direction, uniform on the sphere.

    The size is as in :func:`normal`.

    Parameters
    ----------
    size : float or array_like, shape (3,)
        Length of the perturbation: rad/s for rates; rad for an attitude, as the angle of a rotation
        applied on the body side.

    Returns
    -------
    Noise

    Raises
    ------
    ValueError
        If a size is negative or not finite.

    Examples
    --------
    >>> import numpy as np, rigid
    >>> result = rigid.stability_map(
    ...     rigid.FreeBody, axes={"spin": [1.0]}, samples=100, t_end=1.0, rng=1,
    ...     start=rigid.Start(spin=1.0, axis=3, noise=rigid.direction(0.2)), stable=rigid.no_flip(),
    ... )
    >>> lengths = np.linalg.norm(result.starts(range(3)).omega[0] - [0.0, 0.0, 1.0], axis=1)
    >>> lengths.round(12).tolist()
    [0.2, 0.2, 0.2]
    """
    return Noise("direction", size)  # type: ignore[arg-type]


def uniform_attitude() -> Noise:
    """A random attitude, uniform over all rotations (for ``attitude_noise`` only).

    Returns
    -------
    Noise

    Examples
    --------
    >>> import rigid
    >>> start = rigid.Start(spin=1.0, axis=3, attitude_noise=rigid.uniform_attitude())
    >>> start.attitude_noise.kind
    'uniform_attitude'
    """
    return Noise("uniform_attitude")


def von_mises_fisher(kappa: float) -> Noise:
    """A random direction about its nominal one, with the density ``exp(kappa cos(angle))``.

    As ``attitude_noise`` the direction in space of the axis of the start: the body is turned from
    its nominal attitude about an axis across, without a twist. As ``noise`` the direction of the
    rates in the body; their length stays, and rates of zero do.

    Parameters
    ----------
    kappa : float
        Concentration, not negative. At 0 all directions are alike; if it is large, the angle is
        about the length of two normal components of standard deviation ``1 / sqrt(kappa)``.

    Returns
    -------
    Noise

    Raises
    ------
    ValueError
        If the concentration is negative or not finite.

    Notes
    -----
    The mean of the cosine is ``coth(kappa) - 1 / kappa``. R. A. Fisher, "Dispersion on a sphere",
    *Proc. R. Soc. A* 217 (1953) 295. The cosine is drawn by the inverse of its distribution: A. T.
    A. Wood, *Commun. Stat. Simul. Comput.* 23 (1994) 157; W. Jakob, "Numerically stable sampling of
    the von Mises-Fisher distribution on S2" (2012).

    Examples
    --------
    >>> import numpy as np, rigid
    >>> result = rigid.stability_map(
    ...     rigid.HeavyTop, axes={"attitude_kappa": [1.0, 100.0]}, samples=1000, t_end=1.0, rng=1,
    ...     start=rigid.Start(spin=5.0, attitude_noise=rigid.von_mises_fisher(1.0)),
    ...     stable=rigid.tilt_below(3.0),
    ... )
    >>> w, x, y, z = np.moveaxis(result.starts(range(1000)).attitude, -1, 0)
    >>> (w * w - x * x - y * y + z * z).mean(axis=1).round(2)  # the axis along the vertical
    array([0.3 , 0.99])
    """
    return Noise("von_mises_fisher", finite_float("kappa", kappa, nonnegative=True))
