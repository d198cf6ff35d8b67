"""Stability of rotations of a free body: permanent axes, a local indicator, separatrix, throws."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import exact
from .._checks.arguments import finite_float, positive_int, shaped
from .._checks.arrays import Floats, of_size_one, vectors
from .._checks.overflow import refuses_overflow
from ..model.body import Body
from ..model.body_like import BodyLike, moments_of
from ..model.scene import FreeBody
from ..model.start import body_axis
from ..solve.simulate import simulate
from .tops import asymmetric_free_top

NEXT, AFTER = [1, 2, 0], [2, 0, 1]

NOISE = 0.1
"""Noise of the lab report (rad/s): uniform between zero and this value for every component."""

STEPS = 12
"""Steps of Newton's method for a root of a cubic: in a million random ones rounding alone changes
it after 6."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PermanentRotation:
    """A rotation about a principal axis, and the evolution of a small perturbation.

    Attributes
    ----------
    K : ndarray, shape (...)
        ``(I1 - I2)(I1 - I3) omega² / (I2 I3)`` (1/s²), with I1 about the axis of rotation.
    squared : ndarray, shape (...)
        ``lambda² = -K``, the squared eigenvalue of the linearised equations (1/s²).
    frequency, growth : ndarray, shape (...)
        ``sqrt(K)`` if K is positive (rad/s), and ``sqrt(-K)`` if K is negative (1/s); else 0.
    kind : str, or ndarray of str of shape (...)
        ``"stable"``: the perturbation oscillates; ``"unstable"``: the perturbation grows
        exponentially; ``"neutral"``: K = 0, and the perturbation grows linearly, or is constant if
        all moments are equal.
    """

    K: Floats
    squared: Floats
    frequency: Floats
    growth: Floats
    kind: str | NDArray[np.str_]


@refuses_overflow
def permanent_rotation(body: BodyLike, axis: int, rate: ArrayLike = 1.0) -> PermanentRotation:
    """Stability of the rotation about a principal axis.

    The rotation is stable about the axes of the largest and of the smallest moment and unstable
    about the axis of the middle moment. If two moments are equal, only the axis of the third is
    stable. Landau and Lifshitz, *Mechanics*, § 37; Ercan 2016, § 11.

    Parameters
    ----------
    body : Body, FreeBody or array_like, shape (..., 3)
        The body, or principal moments (kg m²).
    axis : {1, 2, 3}
        The body axis of the rotation.
    rate : array_like, shape (...), optional
        Rate about the axis (rad/s); 1 by default.

    Returns
    -------
    PermanentRotation

    Raises
    ------
    ValueError
        If no body has the moments, or a value is not finite or out of range.

    Examples
    --------
    >>> import rigid
    >>> box = rigid.Body.box(0.01, 0.08, 0.25)
    >>> [str(rigid.free.permanent_rotation(box, axis).kind) for axis in (1, 2, 3)]
    ['stable', 'unstable', 'stable']
    """
    moments = moments_of(body)
    own = body_axis(axis) - 1
    i1, i2, i3 = (moments[..., (own + turn) % 3] for turn in range(3))
    size = np.abs(shaped("rate", rate))
    share = (i1 - i2) / i2 * ((i1 - i3) / i3)
    measure = share * size**2
    kinds = np.array(["unstable", "neutral", "stable"])
    return PermanentRotation(
        K=measure,
        squared=-measure,
        frequency=np.sqrt(np.maximum(share, 0.0)) * size,
        growth=np.sqrt(np.maximum(-share, 0.0)) * size,
        kind=kinds[(np.sign(share) * np.sign(size)).astype(np.intp) + 1],
    )


def gammas(body: BodyLike) -> Floats:
    """Factors of Euler's equations: ``omega1' = gamma1 omega2 omega3`` and cyclic.

    ``gamma1 = (I2 - I3) / I1`` and cyclic. The factors of a possible body lie in [-1, 1], and
    ``gamma1 + gamma2 + gamma3 + gamma1 gamma2 gamma3 = 0``, see :func:`gamma_residual`. For the box
    of Buller and Wernstål 2011, § 3.2, ``gamma1 = 561/689``, not 0.81778 (erratum S-11).

    Parameters
    ----------
    body : Body, FreeBody or array_like, shape (..., 3)
        The body, or principal moments (kg m²).

    Returns
    -------
    ndarray, shape (..., 3)

    Raises
    ------
    ValueError
        If no body has the moments.

    Examples
    --------
    >>> import numpy as np, rigid
    >>> np.round(rigid.free.gammas(rigid.Body.box(0.01, 0.08, 0.25)), 6)
    array([ 0.814224, -0.996805,  0.969231])
    """
    moments = moments_of(body)
    return (moments[..., NEXT] - moments[..., AFTER]) / moments


@refuses_overflow
def gamma_residual(factors: ArrayLike) -> Floats:
    """``gamma1 + gamma2 + gamma3 + gamma1 gamma2 gamma3``, zero for the factors of any body.

    Parameters
    ----------
    factors : array_like, shape (..., 3)
        Factors of Euler's equations, such as the result of :func:`gammas`.

    Returns
    -------
    ndarray, shape (...)

    Raises
    ------
    ValueError
        If a factor is not finite.

    Examples
    --------
    >>> from rigid import free
    >>> bool(abs(free.gamma_residual([0.81778, -0.99681, 0.96923])) > 1e-4)  # no body has these
    True
    """
    array = vectors("factors", factors)
    residual: Floats = array.sum(axis=-1) + array.prod(axis=-1)
    return residual


@refuses_overflow
def jacobian(factors: ArrayLike, omega: ArrayLike) -> Floats:
    """The matrix ``d omega' / d omega`` of Euler's equations without torque.

    Buller and Wernstål 2011, eq. (3). Its trace is zero and its determinant
    ``2 gamma1 gamma2 gamma3 omega1 omega2 omega3``.

    Parameters
    ----------
    factors : array_like, shape (..., 3)
        Factors of Euler's equations, such as the result of :func:`gammas`.
    omega : array_like, shape (..., 3)
        Angular velocity in the body (rad/s).

    Returns
    -------
    ndarray, shape (..., 3, 3)

    Raises
    ------
    ValueError
        If a value is not finite.

    Examples
    --------
    >>> from rigid import free
    >>> free.jacobian([0.5, -1.0, 1.0], [1.0, 2.0, 3.0]).tolist()
    [[0.0, 1.5, 1.0], [-3.0, 0.0, -1.0], [2.0, 1.0, 0.0]]
    """
    array, rates = np.broadcast_arrays(vectors("factors", factors), vectors("omega", omega))
    matrix = np.zeros((*rates.shape, 3))
    for row, (one, other) in enumerate(zip(NEXT, AFTER, strict=True)):
        matrix[..., row, one] = array[..., row] * rates[..., other]
        matrix[..., row, other] = array[..., row] * rates[..., one]
    return matrix


@refuses_overflow
def local_stability(factors: ArrayLike, omega: ArrayLike) -> Floats:
    """The largest real part of the eigenvalues of :func:`jacobian`: a local indicator.

    The indicator is the growth rate of a perturbation if the angular velocity were constant: the
    eigenvalues are the roots of ``x³ - s x - q`` with ``q`` the determinant and
    ``s = gamma1 gamma2 omega3² + gamma2 gamma3 omega1² + gamma3 gamma1 omega2²``. It is
    never negative, because the trace is zero, and it is positive nearly everywhere on stable
    periodic motions. So do not read it as stability (Buller and Wernstål 2011, § 3.2, take values
    of 0 and below as stable; errata S-14, S-15). For stability use :func:`permanent_rotation`,
    :func:`circulation` or a map.

    Parameters
    ----------
    factors, omega
        As in :func:`jacobian`.

    Returns
    -------
    ndarray, shape (...)
        In 1/s.

    Raises
    ------
    ValueError
        If a value is not finite.

    Examples
    --------
    >>> import numpy as np, rigid
    >>> factors = rigid.free.gammas(rigid.Body.box(0.01, 0.08, 0.25))
    >>> np.round(rigid.free.local_stability(factors, np.eye(3)), 6)
    array([0.      , 0.888353, 0.      ])
    """
    array, rates = np.broadcast_arrays(vectors("factors", factors), vectors("omega", omega))
    (array, of_factors), (rates, of_rates) = of_size_one(array), of_size_one(rates)
    s = (array[..., NEXT] * array[..., AFTER] * rates**2).sum(axis=-1)
    q = 2.0 * (array * rates).prod(axis=-1)
    size = np.abs(q)
    # Newton's method comes down to the only positive root of x³ - s x - |q|, which is simple.
    root = np.sqrt(np.maximum(s, 0.0)) + np.cbrt(size)
    for _ in range(STEPS):
        slope = 3.0 * root * root - s
        root = (2.0 * root**3 + size) / np.where(slope > 0.0, slope, np.inf)
    # For negative q the roots change their signs, and the other two are the largest.
    inside = 0.25 * root * root - size / np.where(root > 0.0, root, np.inf)
    others = 0.5 * root + np.sqrt(np.maximum(inside, 0.0))
    largest = np.where(q < 0.0, others, root)
    return np.asarray(np.ldexp(largest, (of_factors + of_rates)[..., 0]))[()]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Circulation:
    """The axis about which the angular velocity circulates.

    Attributes
    ----------
    axis : ndarray of int8, shape (...)
        The encircled axis 1, 2 or 3, with the sign of the rate about this axis, which never
        changes; 0 at rest, on the separatrix and for a sphere.
    margin : ndarray, shape (...)
        ``2 E I2 - L²`` with the middle moment I2 (kg² m⁴/s²): positive for circulation about the
        axis of the smallest moment, negative about the axis of the largest, zero on the separatrix.
        Computed from the components of omega, because the difference of energy and momentum loses
        all digits near the separatrix.
    separatrix : ndarray, shape (...)
        ``sqrt(I3 (I3 - I2) / (I1 (I2 - I1)))`` with ascending moments: the ratio, on the
        separatrix, of the rate about the axis of the smallest moment to the rate about the axis of
        the largest. inf if the two smaller moments are equal.
    """

    axis: NDArray[np.int8]
    margin: Floats
    separatrix: Floats


@refuses_overflow
def circulation(body: BodyLike, omega: ArrayLike) -> Circulation:
    """The axis about which the angular velocity of a free body circulates, without an integration.

    Landau and Lifshitz, *Mechanics*, § 37. The result does not depend on the rate about the middle
    axis; the criterion of Buller and Wernstål 2011, § 3.2, is wrong (erratum S-12).

    Parameters
    ----------
    body : Body, FreeBody or array_like, shape (..., 3)
        The body, or principal moments (kg m²) in any order.
    omega : array_like, shape (..., 3)
        Angular velocity in the body at any time (rad/s).

    Returns
    -------
    Circulation

    Raises
    ------
    ValueError
        If no body has the moments, or a value is not finite.

    Examples
    --------
    >>> import rigid
    >>> box = rigid.Body.box(0.01, 0.08, 0.25)  # the first moment is the largest
    >>> found = rigid.free.circulation(box, [[1.0, 50.0, 0.9], [1.0, 0.1, 1.05], [1.0, 0.1, 1.1]])
    >>> found.axis.tolist(), round(float(found.separatrix), 12)
    ([1, 1, 3], 1.091042772558)
    """
    moments, rates = moments_of(body), vectors("omega", omega)
    order = np.argsort(moments, axis=-1, kind="stable")
    ascending = np.take_along_axis(moments, order, axis=-1)
    i1, i2, i3 = np.moveaxis(ascending, -1, 0)
    shape = np.broadcast_shapes(order.shape, rates.shape)
    order, rates = np.broadcast_to(order, shape), np.broadcast_to(rates, shape)
    w1, _, w3 = np.moveaxis(np.take_along_axis(rates, order, axis=-1), -1, 0)
    with np.errstate(divide="ignore"):
        ratio = np.sqrt(i3 * (i3 - i2) / (i1 * np.where(i2 > i1, i2 - i1, 1.0)))
    return Circulation(
        axis=asymmetric_free_top(moments, rates).axis,
        margin=i1 * (i2 - i1) * w1**2 - i3 * (i3 - i2) * w3**2,
        separatrix=np.where(i2 > i1, ratio, np.inf)[()],
    )


def crossings(body: Body | FreeBody, omega: ArrayLike, *, count: int = 1) -> Floats:
    """First ``count`` times at which each rate of a free body changes sign.

    The function calls :func:`rigid.exact.flip_times` for all three axes.

    Parameters
    ----------
    body : Body or FreeBody
        The body.
    omega : array_like, shape (..., 3)
        Angular velocity in the body at ``t = 0`` (rad/s).
    count : int
        Number of times.

    Returns
    -------
    ndarray, shape (..., 3, count)
        Times > 0 (s) for the axes 1, 2, 3, ascending; inf if the rate does not change sign again.

    Raises
    ------
    TypeError
        If ``body`` is neither a :class:`rigid.Body` nor a :class:`rigid.FreeBody`.
    ValueError
        If omega is not finite or the count is not positive.

    Examples
    --------
    >>> import numpy as np, rigid
    >>> np.round(rigid.free.crossings(rigid.Body((1.0, 2.0, 3.0)), [1e-3, 1.0, 0.0]), 6)
    array([[      inf],
           [14.365712],
           [28.731424]])
    """
    scene = body if isinstance(body, FreeBody) else FreeBody(body)
    rates = vectors("omega", omega)
    number = positive_int("count", count)
    times = [exact.flip_times(scene, rates, axis=axis, count=number) for axis in (1, 2, 3)]
    return np.stack(times, axis=-2)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ThrowExperiment:
    """Six runs: about the axes 1, 2, 3 without noise, then with noise.

    Attributes
    ----------
    t : ndarray, shape (m,)
        Times (s).
    omega : ndarray, shape (6, m, 3)
        Angular velocity in the body (rad/s).
    dots_t : ndarray, shape (k,)
        Times of the indicator: whole seconds (s).
    dots : ndarray, shape (6, k)
        :func:`rigid.free.local_stability` at these times (1/s): a local indicator, not stability.
    noise : ndarray, shape (3, 3)
        Angular velocities added to the starts of the last three runs (rad/s).
    """

    t: Floats
    omega: Floats
    dots_t: Floats
    dots: Floats
    noise: Floats


def throw_experiment(
    body: Body,
    noise: ArrayLike | np.random.Generator,
    *,
    t_end: float = 30.0,
    samples: int = 601,
) -> ThrowExperiment:
    """Closed-form motion of a body thrown at 1 rad/s about each axis, with and without noise.

    Buller and Wernstål 2011, appendix and Fig. 3. The report does not give the seed of its noise
    (S-18), so pass the noise as an argument.

    Parameters
    ----------
    body : Body
        The body; the report uses ``Body.box(0.01, 0.08, 0.25)``.
    noise : array_like, shape (3,) or (3, 3), or numpy.random.Generator
        Angular velocity (rad/s) added to every start, or one for each of the axes 1, 2, 3. A
        generator draws nine numbers uniform between 0 and 0.1.
    t_end : float
        Length of a run (s).
    samples : int
        Number of times, equally spaced from 0 on.

    Returns
    -------
    ThrowExperiment

    Raises
    ------
    TypeError
        If ``body`` is no body.
    ValueError
        If the noise has another shape, or a value is not finite or out of range.

    Examples
    --------
    >>> import numpy as np, rigid
    >>> box = rigid.Body.box(0.01, 0.08, 0.25)
    >>> thrown = rigid.free.throw_experiment(box, [0.05, 0.05, 0.05])
    >>> np.round(thrown.omega[4, -1], 6)
    array([ 0.06814 , -1.04875 ,  0.071071])
    """
    end = finite_float("t_end", t_end, positive=True)
    t = np.linspace(0.0, end, positive_int("samples", samples, minimum=2))
    if isinstance(noise, np.random.Generator):
        added = NOISE * noise.random((3, 3))
    else:
        added = shaped("noise", noise)
        if added.shape not in ((3,), (3, 3)):
            raise ValueError(f"noise: expected shape (3,) or (3, 3), got {added.shape}")
        added = np.broadcast_to(added, (3, 3)).copy()
    starts = np.concatenate([np.eye(3), np.eye(3) + added])
    scene = FreeBody(body)
    seconds = np.arange(0.0, np.floor(end) + 1.0)
    omega, dotted = (
        simulate(scene, starts, t=times, method="exact", record="rates").omega
        for times in (t, seconds)
    )
    return ThrowExperiment(
        t=t,
        omega=omega,
        dots_t=seconds,
        dots=local_stability(gammas(body), dotted),
        noise=added,
    )
