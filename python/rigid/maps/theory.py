"""Prediction of a map by theory, for the cases with a known theory.

Free body, criterion *no flip about axis j*
    With moments sorted ``I1 <= I2 <= I3``, the sign of
    ``2 E I2 - L² = I1 (I2 - I1) w1² - I3 (I3 - I2) w3²`` determines which axis the rates circulate
    about: the smallest (positive) or the largest (negative). About that axis there is never a flip;
    every other rate changes its sign at least once in half a period. Formed from components,
    because the difference of the invariants loses all its digits near the separatrix.

    A spin ``W`` about the middle axis leaves along the heteroclinic orbit
    ``w = (A1 sech, W tanh, A3 sech)(lam (t - t_flip))`` with
    ``lam = W sqrt((I3 - I2)(I2 - I1) / (I1 I3))``,
    ``A1 = W sqrt(I2 (I3 - I2) / (I1 (I3 - I1)))``, ``A3 = W sqrt(I2 (I2 - I1) / (I3 (I3 - I1)))``.
    Matched to the unstable amplitude ``u = (w1 -+ w3 A1/A3) / 2`` of the linear stage, it flips at
    ``t_flip = ln(2 A1 / |u|) / lam``. With normal noise, P(no flip until t) is the normal
    probability of ``|u| < 2 A1 exp(-lam t)``.

Symmetric heavy top spinning about its own axis, criterion *tilt from the vertical below an angle*
    Released with spin ``w`` and tilt ``th``, its axis at rest, the top nutates between ``th`` and
    the other root ``x`` of ``sin² x = a (cos th - cos x)``, ``a = (I3 w)² / (2 I1 mgl)``. It passes
    a limit ``x`` if ``cos th < cos x + sin² x / a``: for vanishing tilt if ``a < 1 + cos x``, which
    for a vanishing limit is the bound of the sleeping top, ``w = 2 sqrt(mgl I1) / I3``. Below that
    bound the tilt ``x`` grows along the homoclinic orbit
    ``1 - cos x = (2 I1 g² / mgl) sech²(g (t - t0))``, ``g = sqrt(4 mgl I1 - (I3 w)²) / (2 I1)``. A
    top released so near the vertical that it does not reach the limit within the horizon counts as
    stable. With normal noise of the attitude the tilt at release has a Rayleigh distribution. Above
    the bound no fall is predicted of a horizon that ends before the nutation has turned round.

Symmetric heavy top, damped only about its symmetry axis
    The spin decays as ``w exp(-c t / I3)``, and the weight has no moment about the axis. As long as
    ``I3 w > 2 sqrt(mgl I1)`` the top sleeps; it reaches the bound at
    ``t_b = (I3 / c) ln(I3 w / (2 sqrt(mgl I1)))``. From there on a tilt grows at the rate
    ``g = sqrt(4 mgl I1 - (I3 w)²) / (2 I1)``, which increases as the root of the time:
    ``ln(limit / tilt) = (2/3) sqrt(2 c mgl / (I1 I3)) (t - t_b)^(3/2)``. The lag is to the time of
    the spin-down as ``c^(2/3)``: the bound is exact in the limit of slow damping. So the bound is
    the onset of the fall, and the border of the criterion lies about one lag later. The prediction
    is 1 before the onset and 0 after twice the lag of the smallest tilts; between them it is not
    made.

Landau and Lifshitz, *Mechanics*, §§ 35, 37; Goldstein, *Classical Mechanics*, §§ 5.6, 5.7.

Satellites are predicted in :mod:`.satellites`, and lines of moons are in :mod:`.moons`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .. import _core
from .._checks.arrays import Floats
from .._checks.shown import angle_words
from ..model.bounds import NoFlip, TiltBelow
from ..model.forces import FORCES
from ..model.noise import Noise
from ..model.scene import FreeBody, HeavyTop
from ..model.start import Start
from .data import MapData
from .moons import attitude_resonances, spin_orbit_resonances
from .satellites import NORMAL_REACH, RAYLEIGH_HALF, Predicted, flat_spin, on_orbit
from .spec import MapSpec

Flags = NDArray[np.bool_]

SMALL = 0.05
"""Largest perturbation for the formula of the middle axis, as a share of the separatrix."""

BAND = 2**16
"""Most pixels that are predicted at once for counts alone, unless a row has more."""

# Median of |N(0, 1)|, in standard deviations.
_NORMAL_HALF = 0.6744897501960817


@dataclass(frozen=True, slots=True, eq=False)
class Curve:
    """A line to draw on a map: where ``field`` (of grid shape, NaN where unknown) is zero."""

    label: str
    field: Floats


@dataclass(frozen=True, slots=True, eq=False)
class Theory:
    """A prediction for a map.

    Attributes
    ----------
    label : str
        The basis of the prediction, in one line.
    share : ndarray
        Predicted share of stable bodies in each pixel, NaN where there is no prediction.
    curves : tuple of Curve
        Lines to draw; those that do not cross the grid are omitted.
    """

    label: str
    share: Floats
    curves: tuple[Curve, ...]

    @property
    def is_empty(self) -> bool:
        """Whether the theory predicts no share and has no line."""
        return not self.curves and bool(np.isnan(self.share).all())


def predict(spec: MapSpec) -> Theory | None:
    """The prediction for a map, or None where none is known.

    Parameters
    ----------
    spec : MapSpec
        The specification; its seed has no effect.

    Returns
    -------
    Theory or None
    """
    if spec.misses_functions or spec.vary or not isinstance(spec.start, Start):
        return None
    if len(spec.parts) > 1:
        return _of_parts(spec)
    moons = [attitude_resonances, spin_orbit_resonances]
    predictors = [_free_no_flip, _symmetric_top, flat_spin, on_orbit, *moons]
    varied = {axis.parameter.place for axis in spec.axes}
    if spec.own is not None or not varied.isdisjoint({"torque", *FORCES}):
        # Satellites and tops read the scene of all pixels.
        predictors = [_free_no_flip, *(moons if spec.own is None else [])]
    with np.errstate(all="ignore"):  # impossible and degenerate pixels end as NaN
        for predictor in predictors:
            found = predictor(spec)
            theory = None if found is None else _theory(spec, *found)
            if theory is not None and not theory.is_empty:
                return theory
    return None


def _of_parts(spec: MapSpec) -> Theory | None:
    """The predictions for all horizons and limits of a map, without lines."""
    found = [predict(part.spec) for part in spec.parts]
    known = [theory for theory in found if theory is not None]
    if not known:
        return None
    share = np.full(math.prod(spec.shape), np.nan)
    for part, theory in zip(spec.parts, found, strict=True):
        if theory is not None:
            share[part.pixels] = theory.share.ravel()
    label = known[0].label
    if len({theory.label for theory in known}) > 1:
        label = f"{label}, and so for the other horizons and limits"
    return Theory(label, share.reshape(spec.shape), ())


def disagreement(data: MapData, theory: Theory | None) -> Flags:
    """Pixels whose predicted share lies outside [lower, upper]; none without a theory."""
    if theory is None:
        return np.zeros(data.spec.shape, dtype=np.bool_)
    return _outside(theory.share, data.lower, data.upper)


def _outside(share: Floats, lower: Floats, upper: Floats) -> Flags:
    outside: Flags = (share < lower) | (share > upper)
    return outside


@dataclass(frozen=True, slots=True)
class Agreement:
    """How many pixels of a map agree with theory.

    Attributes
    ----------
    label : str
        The basis of the prediction.
    compared : int
        Pixels with a prediction and samples.
    disagree : int
        Pixels among these whose predicted share lies outside [lower, upper].
    unknown : int
        Pixels with samples for which nothing is predicted.
    """

    label: str
    compared: int
    disagree: int
    unknown: int


def agreement(data: MapData) -> Agreement | None:
    """How many pixels agree with theory, or None where no theory is known.

    Bands of the last axis are predicted one after another: a prediction of a million pixels at once
    takes 400 MB.
    """
    labels, compared, disagree, unknown = [], 0, 0, 0
    for band, spec in _bands(data.spec):
        theory = predict(spec)
        lower, upper = data.lower[band], data.upper[band]
        share = np.full(lower.shape, np.nan) if theory is None else theory.share
        known, sampled = ~np.isnan(share), ~np.isnan(lower)
        compared += int((known & sampled).sum())
        unknown += int((~known & sampled).sum())
        disagree += int(_outside(share, lower, upper).sum())
        labels += [] if theory is None else [theory.label]
    # The label of a band names what its pixels needed; the longest names all of it.
    return Agreement(max(labels, key=len), compared, disagree, unknown) if labels else None


def _bands(spec: MapSpec) -> Iterator[tuple[slice, MapSpec]]:
    """The map in bands of its last axis, with their place in the arrays."""
    *others, last = spec.axes
    count = len(last.values)
    rows = max(BAND * count // math.prod(spec.shape), 1)
    if spec.own is not None or rows >= count:
        yield slice(0, count), spec
        return
    for begin in range(0, count, rows):
        band = slice(begin, begin + rows)
        axes = (*others, replace(last, values=last.values[band]))
        yield band, spec.replace(axes=axes, refine=None, budget=None)


def _theory(spec: MapSpec, label: str, share: Floats, curves: dict[str, Floats]) -> Theory:
    shaped = {name: field.reshape(spec.shape) for name, field in curves.items()}
    crossing = tuple(
        Curve(name, field)
        for name, field in shaped.items()
        if (field > 0.0).any() and (field < 0.0).any()
    )
    return Theory(label, share.reshape(spec.shape), crossing)


def _first(spec: MapSpec) -> Start:
    """The only start of the map."""
    return spec.start.starts[0]


# Free body


def _free_no_flip(spec: MapSpec) -> Predicted | None:
    stable, grid, noise = spec.stable, spec.grid, _first(spec).noise
    if spec.forces or not isinstance(spec.scene, FreeBody) or not isinstance(stable, NoFlip):
        return None
    sized = isinstance(noise, Noise) and noise.cov is None and not noise.is_direction
    if noise is not None and not sized:
        return None  # its size is no bound of what it adds to the rates
    tested = stable.conditions()[0][1] - 1
    order = np.argsort(grid.moving, axis=1, kind="stable")
    moments, omega, size = (
        np.take_along_axis(array, order, axis=1)
        for array in (grid.moving, grid.omega, grid.omega_size)
    )
    moments[~grid.possible] = np.nan
    place = np.argmax(order == tested, axis=1)  # 0, 1, 2: smallest, middle, largest
    normal = noise is not None and noise.is_plain_normal
    reach = NORMAL_REACH * size if normal else size
    nearest = np.maximum(np.abs(omega) - reach, 0.0)
    farthest = np.abs(omega) + reach
    towards_small = _circulation(moments, nearest[:, 0], farthest[:, 2])
    towards_large = -_circulation(moments, farthest[:, 0], nearest[:, 2])
    keeps = ((place == 0) & (towards_small > 0.0)) | ((place == 2) & (towards_large > 0.0))
    margin = np.maximum(np.maximum(towards_small, towards_large), 0.0)
    flips = ~keeps & (_half_period(moments, nearest, margin) <= spec.t_end)
    flips &= (farthest > 0.0).sum(axis=1) > 1  # about a principal axis no rate changes
    keeps &= np.take_along_axis(nearest, place[:, np.newaxis], axis=1)[:, 0] > 0.0
    share = np.select([keeps, flips], [1.0, 0.0], np.nan)
    curves = {"separatrix": _separatrix(moments, omega, place)}
    label = "separatrix 2 E I2 = L²"

    if noise is None or normal:
        parity = _parity(order)
        law, excess = _middle_axis_law(moments, omega, size, parity, spec.t_end)
        law = np.where(place == 1, law, np.nan)
        if not np.isnan(law).all():
            share = np.where(np.isnan(law), share, law)
            label += "; heteroclinic flip time about the middle axis"
            name = "half have flipped by" if normal else "first flip at"
            until = f"{spec.horizon}, for small perturbations"
            curves[f"{name} {until}"] = np.where(np.isnan(law), np.nan, excess)
    return label, share, curves


def _circulation(moments: Floats, w1: Floats, w3: Floats) -> Floats:
    """``2 E I2 - L²`` from components; positive: circulates about the smallest axis."""
    i1, i2, i3 = moments.T
    result: Floats = i1 * (i2 - i1) * w1 * w1 - i3 * (i3 - i2) * w3 * w3
    return result


def _half_period(moments: Floats, least: Floats, margin: Floats) -> Floats:
    """Longest time between sign changes of a rate, for a distance ``margin`` from the separatrix.

    ``least`` are the smallest sizes of the rates: the time falls with them and with the distance.

    The rates are Jacobi functions with argument ``p t``; half a period is ``2 K / p`` and the
    complementary parameter ``1 - m`` is formed from components.
    """
    i1, i2, i3 = moments.T
    w1, w2, w3 = least.T
    above_small = i2 * (i2 - i1) * w2 * w2 + i3 * (i3 - i1) * w3 * w3  # L² - 2 E I1
    below_large = i1 * (i3 - i1) * w1 * w1 + i2 * (i3 - i2) * w2 * w2  # 2 E I3 - L²
    # Both orders of the two products are squares of p; the larger one belongs to the region.
    square = np.maximum((i3 - i2) * above_small, (i2 - i1) * below_large)
    complement = np.clip((i3 - i1) * margin / square, 0.0, 1.0)
    means = _core.elliptic("agm", [np.ones_like(complement), np.sqrt(complement)])[0]
    quarter = 0.5 * np.pi / means
    return np.where(margin > 0.0, 2.0 * quarter * np.sqrt(i1 * i2 * i3 / square), np.inf)


def _separatrix(moments: Floats, omega: Floats, place: NDArray[np.intp]) -> Floats:
    """Positive where the nominal start circulates about the tested axis, zero on the separatrix.

    In units of a moment and continued linearly into the region where the tested axis is the middle
    one, so that the zero is interpolated well between pixels.
    """
    i1, i2, i3 = moments.T
    w1, _, w3 = omega.T
    about_small = (i2 - i1) - i3 * (i3 - i2) * w3 * w3 / (i1 * w1 * w1)
    about_large = (i3 - i2) - i1 * (i2 - i1) * w1 * w1 / (i3 * w3 * w3)
    middle = -np.minimum(i2 - i1, i3 - i2)
    return np.choose(place, [about_small, middle, about_large])


def _parity(order: NDArray[np.intp]) -> Floats:
    """+1 where sorting the axes keeps the frame right-handed, -1 where it mirrors it."""
    return np.where((order[:, 1] - order[:, 0]) % 3 == 1, 1.0, -1.0)


def _middle_axis_law(
    moments: Floats, omega: Floats, size: Floats, parity: Floats, t_end: float
) -> tuple[Floats, Floats]:
    """P(no flip until t_end) near the middle axis, and the logarithmic distance from 1/2."""
    i1, i2, i3 = moments.T
    spin = np.abs(omega[:, 1])
    rate = spin * np.sqrt((i3 - i2) * (i2 - i1) / (i1 * i3))
    a1 = spin * np.sqrt(i2 * (i3 - i2) / (i1 * (i3 - i1)))
    a3 = spin * np.sqrt(i2 * (i2 - i1) / (i3 * (i3 - i1)))
    ratio = a1 / a3
    # w1' ~ (I2 - I3) w2 w3: the growing direction has w1 and w3 of opposite sign for positive spin.
    unstable = 0.5 * (omega[:, 0] - parity * np.sign(omega[:, 1]) * ratio * omega[:, 2])
    spread = 0.5 * np.hypot(size[:, 0], ratio * size[:, 2])
    bound = 2.0 * a1 * np.exp(-rate * t_end)
    root = math.sqrt(2.0) * spread
    chance = 0.5 * (_erf((bound - unstable) / root) + _erf((bound + unstable) / root))
    share = np.where(spread > 0.0, chance, np.where(np.abs(unstable) < bound, 1.0, 0.0))
    perturbation = np.maximum(np.abs(omega), size)
    small = np.maximum(perturbation[:, 0], perturbation[:, 2]) <= SMALL * np.minimum(a1, a3)
    small &= spin > 0.0
    # Noise of the spin changes the growth rate; the effect on the exponent must be small.
    small &= size[:, 1] * rate * t_end <= 0.25 * spin
    share[~small] = np.nan
    return share, np.log(bound / np.hypot(_NORMAL_HALF * spread, unstable))


_erf = np.vectorize(math.erf, otypes=[np.float64])


# Heavy symmetric top


class _Top(NamedTuple):
    """Symmetric tops that are released at rest in all but their spin, one for each pixel."""

    mgl: Floats
    cross: Floats
    axial: Floats
    spin: Floats
    size: Floats
    limit: float
    symmetric: Flags
    known: Flags


def _symmetric_top(spec: MapSpec) -> Predicted | None:
    scene, stable, start, grid = spec.scene, spec.stable, _first(spec), spec.grid
    noise = start.attitude_noise
    if (
        not isinstance(scene, HeavyTop)
        or not isinstance(stable, TiltBelow)
        or stable.reference != "vertical"
        or stable.axis != start.axis
        or tuple(scene.com) != tuple(np.eye(3)[start.axis - 1])
        or start.attitude is not None
        or start.noise is not None
        or (noise is not None and not noise.is_plain_normal)
    ):
        return None
    assert isinstance(grid.scene, HeavyTop)
    k = start.axis - 1
    cross, spin, size = grid.moments[:, k - 1], grid.omega[:, k], grid.attitude_size[:, 0]
    symmetric = grid.possible & (cross == grid.moments[:, k - 2])
    known = symmetric & (np.abs(grid.omega).sum(axis=1) == np.abs(spin))
    known &= (grid.attitude_size == size[:, np.newaxis]).all(axis=1)
    mgl, axial = np.broadcast_to(grid.scene.mgl, len(cross)), grid.moments[:, k]
    top = _Top(mgl, cross, axial, spin, size, stable.angle, symmetric, known)
    if not spec.forces:
        return _nutation(spec, top)
    is_falling = scene.torque is None and "damping" in spec.forces and noise is not None
    return _fall(spec, top, k) if is_falling else None


def _nutation(spec: MapSpec, top: _Top) -> Predicted:
    mgl, cross, axial, spin, size, limit, symmetric, known = top
    tilt = np.abs(spec.grid.tilt)
    known &= (tilt == 0.0) | (size == 0.0)
    known &= (tilt != 0.0) | (size > 0.0)
    momentum = (axial * spin) ** 2
    bound = 4.0 * mgl * cross
    critical = np.maximum(
        _nutation_bound(momentum, mgl * cross, limit),
        _horizon_bound(momentum, mgl, cross, limit, spec.t_end),
    )
    chance = -np.expm1(-0.5 * (critical / size) ** 2)
    share = np.where(size > 0.0, chance, tilt < critical)
    # A top that sleeps passes no limit before its nutation has turned round.
    turned = _half_nutation(momentum, mgl, cross, np.where(size > 0.0, critical, tilt))
    early = (momentum >= bound) & (share < 1.0) & ~(turned <= spec.t_end)
    share = np.where(known & ~np.isnan(critical) & ~early, share, np.nan)
    sleeping = np.where(symmetric, np.abs(axial * spin) / np.sqrt(bound) - 1.0, np.nan)
    curves = {"sleeping-top bound $\\omega_3 = 2\\sqrt{mgl\\,I_1}/I_3$": sleeping}
    released = np.where(size > 0.0, RAYLEIGH_HALF * size, tilt)
    verb = "passes" if _first(spec).attitude_noise is None else "half pass"
    name = f"{verb} {angle_words(limit)} by {spec.horizon}"
    curves[name] = np.where(known, critical - released, np.nan)
    label = f"nutation of a symmetric top released at rest, until {spec.horizon}"
    return label, share, curves


def _fall(spec: MapSpec, top: _Top, k: int) -> Predicted:
    """Of tops whose spin about axis ``k`` is damped."""
    mgl, cross, axial, spin, size, limit, _, known = top
    others = spec.grid.damping
    c = others[:, k, k].copy()
    others[:, k, k] = 0.0
    known &= (spec.grid.tilt == 0.0) & ~others.any(axis=(1, 2))
    bound = np.log(np.abs(axial * spin) / (2.0 * np.sqrt(mgl * cross))) * axial / c
    lag = falling_lag(mgl, cross, axial, c, limit / (1e-3 * size))
    # Before the bound a tilt swings out to its nutation, which grows as the spin falls.
    left = np.abs(spin) * np.exp(-c * spec.t_end / axial)
    slowing = _nutation_rate(np.abs(spin), top) * _nutation_rate(left, top)
    swing = NORMAL_REACH * size * axial * np.abs(spin) / (2.0 * cross * np.sqrt(slowing))
    share = np.where((spec.t_end < bound) & (swing < limit), 1.0, np.nan)
    # A tilt of a thousandth of the noise or less is drawn once in two million samples. A large
    # limit is reached when the spin has fallen further: until a = 1 + cos(limit).
    further = 0.5 * axial / c * math.log(2.0 / (1.0 + math.cos(limit)))
    share = np.where(spec.t_end > np.maximum(bound, 0.0) + 2.0 * lag + further, 0.0, share)
    share = np.where(known & (6.0 * size < limit), share, np.nan)
    half = falling_lag(mgl, cross, axial, c, limit / (RAYLEIGH_HALF * size))
    until, angle = spec.horizon, angle_words(limit)
    bound = np.where(known, bound, np.nan)  # the lines too are of symmetric tops
    curves = {
        "onset of the fall $\\omega_3(t) = 2\\sqrt{mgl\\,I_1}/I_3$": bound / spec.t_end - 1.0,
        f"about half pass {angle} by {until}": (bound + half) / spec.t_end - 1.0,
    }
    words = "no fall before the onset, all fallen two lags later"
    label = f"quasi-static spin-down until {until} ({words})"
    return label, share, curves


def _nutation_rate(spin: Floats, top: _Top) -> Floats:
    """Rate (rad/s) of the small nutations of tops that sleep; NaN of others."""
    rate: Floats = np.sqrt((top.axial * spin) ** 2 - 4.0 * top.mgl * top.cross) / (2.0 * top.cross)
    return rate


def falling_lag(mgl: Floats, cross: Floats, axial: Floats, c: Floats, growth: Floats) -> Floats:
    """Time after the bound in which a tilt grows by a factor ``growth``; see the module text."""
    rate = np.sqrt(2.0 * c * mgl / (cross * axial))
    lag: Floats = (1.5 * np.log(growth) / rate) ** (2.0 / 3.0)
    return lag


def _nutation_bound(momentum: Floats, weight: Floats, limit: float) -> Floats:
    """Largest tilt at release whose nutation stays below the limit; ``weight`` is ``mgl I1``."""
    cosine = math.cos(limit) + math.sin(limit) ** 2 * 2.0 * weight / momentum
    return np.where(cosine < 1.0, np.arccos(cosine), 0.0)


def _half_nutation(momentum: Floats, mgl: Floats, cross: Floats, tilt: Floats) -> Floats:
    """Time in which a top that is released at a tilt nutates to its largest tilt.

    The height u of the axis obeys ``u'² = (2 mgl / I1) (u1 - u) (u - u2) (u3 - u)`` with the height
    ``u1`` at release; ``u2`` and ``u3`` are the roots of ``1 - u² = a (u1 - u)``.
    """
    a, height = momentum / (2.0 * mgl * cross), np.cos(tilt)
    apart = np.sqrt(a * a - 4.0 * (a * height - 1.0))
    complement = (0.5 * (a + apart) - height) / apart
    means = _core.elliptic("agm", [np.ones_like(complement), np.sqrt(complement)])[0]
    time: Floats = np.pi / means / np.sqrt(2.0 * mgl / cross * apart)
    return time


def _horizon_bound(
    momentum: Floats, mgl: Floats, cross: Floats, limit: float, t_end: float
) -> Floats:
    """Largest tilt at release that has not grown to the limit by ``t_end``; 0 without growth."""
    growing = momentum < 4.0 * mgl * cross
    growth = np.sqrt(4.0 * mgl * cross - momentum) / (2.0 * cross)
    crest, edge = 2.0 * cross * growth**2 / mgl, 1.0 - math.cos(limit)
    lead = np.arccosh(np.sqrt(crest / edge))
    tilt = 8.0 * cross * growth**2 / mgl * np.exp(-growth * t_end - lead)
    bound = np.where(growing & (crest > edge), np.minimum(tilt, limit), 0.0)
    # The match to the linear stage needs a few times of growth.
    return np.where(growing & (growth * t_end < 3.0), np.nan, bound)
