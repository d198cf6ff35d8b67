"""Random scenes with a closed form, many at once, and their motion compared with RK4."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from physics import ROUNDOFF, Floats, quaternion_product, rotation_angle
from rigid.model.bodies import Bodies
from rigid.solve.request import Request

#: How far each way the bodies are followed: the angle turned at the fastest rate (rad).
REACH = 9.0

#: Step of RK4 and of its repetition with half of it, likewise (rad).
STEP = 2.0**-9

#: Step of the motions that measure how errors grow, and the size of the errors (rad).
ROUGH_STEP, NUDGE = 2.0**-5, 2.0**-20

#: States that are compared, each way.
STATES = 4


@dataclass(frozen=True)
class Scenes:
    """Bodies with their starts; a bound of all rates lies between 1/2 and 1 rad/s."""

    kind: str
    family: str
    moments: Floats
    weight: Floats
    omega: Floats
    attitude: Floats

    def __len__(self) -> int:
        return len(self.omega)

    @property
    def bodies(self) -> Bodies:
        """The bodies as the core reads them."""
        return Bodies(
            kind=self.kind,
            shape=(len(self),),
            moments=self.moments,
            weight=self.weight,
            omega=self.omega,
            attitude=self.attitude,
        )

    def in_units(self, time: int, mass: int) -> Scenes:
        """The same motion 2^time times as fast, of bodies 2^mass times as heavy; exact."""
        return replace(
            self,
            moments=np.ldexp(self.moments, mass),
            weight=np.ldexp(self.weight, mass + 2 * time),
            omega=np.ldexp(self.omega, time),
        )

    def written(self, row: int) -> str:
        """A start as code."""
        start = (("moments", self.moments), ("weight", self.weight), ("omega", self.omega))
        parts = [f"{name}={array[row].tolist()}" for name, array in start]
        return ", ".join([*parts, f"attitude={self.attitude[row].tolist()}"])

    def states(
        self, times: Floats, method: str, step: float, threads: int = 2
    ) -> tuple[Floats, Floats]:
        """Rates (n, m, 3) and attitudes (n, m, 4) at the times."""
        request = Request(
            bodies=self.bodies,
            times=times,
            method=method,
            record="attitude",
            max_steps=10**6,
            threads=threads,
            steps=None if method == "exact" else np.full(len(self), step),
        )
        states = request.states()
        return states["omega"], states["attitude"]


# Drawing


def decades(rng: np.random.Generator, low: float, high: float, n: int) -> Floats:
    """Numbers whose logarithm to base 10 is uniform."""
    numbers: Floats = 10.0 ** rng.uniform(low, high, n)
    return numbers


def signs(rng: np.random.Generator, shape: int | tuple[int, ...]) -> Floats:
    """1 or -1."""
    return rng.choice(np.array([-1.0, 1.0]), shape)


def mixed(rng: np.random.Generator, *columns: Floats) -> Floats:
    """Each row from one of the arrays, which one is left to chance."""
    which = rng.integers(len(columns), size=len(columns[0]))
    picked: Floats = np.stack(columns)[which, np.arange(len(which))]
    return picked


def any_attitude(rng: np.random.Generator, n: int) -> Floats:
    return _unit(rng.normal(size=(n, 4)))


def _unit(q: Floats) -> Floats:
    unit: Floats = q / np.linalg.norm(q, axis=-1, keepdims=True)
    return unit


def _moments(rng: np.random.Generator, n: int, *, equal: bool) -> Floats:
    """Ascending moments a + b, of positive halves: all that the triangle inequality allows.

    Where two halves are equal or nearly so the body is symmetric, where one is next to nothing it
    is a needle or a flat body.
    """

    def below(half: Floats) -> Floats:
        near = half * (1.0 - decades(rng, -16.0, -1.0, n))
        return mixed(rng, half * rng.uniform(size=n), half * decades(rng, -6.0, 0.0, n), near)

    large = np.ones(n)
    middle = below(large)
    small = mixed(
        rng, below(middle), below(middle), middle * decades(rng, -16.0, -6.0, n), 0 * large
    )
    if equal:
        sphere, oblate, prolate = np.eye(3)[rng.choice(3, n, p=[0.1, 0.45, 0.45])].T > 0.0
        middle = np.where(sphere | oblate, large, middle)
        small = np.where(sphere | prolate, middle, small)
    return np.stack([middle + small, large + small, large + middle], axis=-1)


def _free_omega(rng: np.random.Generator, moments: Floats) -> Floats:
    """Rates in any direction, near an axis, near the separatrix, in a plane of two axes."""
    n = len(moments)
    anywhere = rng.normal(size=(n, 3)) / moments ** rng.choice([0.0, 0.5, 1.0], (n, 1))
    tiny = decades(rng, -15.0, 0.0, 3 * n).reshape(n, 3) * signs(rng, (n, 3))
    axis = rng.integers(3, size=n)
    tiny[np.arange(n), axis] = signs(rng, n)
    plane = anywhere.copy()
    plane[np.arange(n), axis] = rng.choice([0.0, -0.0], n)

    # I1 w1^2 (I2 - I1) = I3 w3^2 (I3 - I2) on the separatrix.
    separatrix = rng.normal(size=(n, 3))
    i1, i2, i3 = moments.T
    split = (i3 - i2) / np.maximum(i2 - i1, 1e-3 * ROUNDOFF * i3)
    first = np.abs(separatrix[:, 2]) * np.sqrt(i3 / i1 * split)
    off = mixed(rng, decades(rng, -16.0, 0.0, n) * signs(rng, n), 0.0 * first)
    away = mixed(rng, np.ones(n), decades(rng, -12.0, 0.0, n))
    separatrix[:, 0] = np.where(split < 1e6, first * (1.0 + off) * signs(rng, n), 1.0)
    separatrix[:, [0, 2]] *= away[:, None]
    return mixed(rng, anywhere, tiny, separatrix, separatrix, plane)


def free(rng: np.random.Generator, n: int, *, equal: bool) -> Scenes:
    """Free bodies with three moments in any order, of which some, if so, are equal."""
    moments = _moments(rng, n, equal=equal)
    omega = _free_omega(rng, moments)
    order = rng.permuted(np.tile(np.arange(3), (n, 1)), axis=1)
    moments, omega = (np.take_along_axis(v, order, axis=1) for v in (moments, omega))
    # The polhode bounds each rate: 2 T I3 - L^2 and L^2 - 2 T I1 are sums of positive terms.
    i = np.sort(moments, axis=1)
    w2 = np.take_along_axis(omega, np.argsort(moments, axis=1), axis=1) ** 2
    twice = (i * w2).sum(axis=1)
    d1 = i[:, 1] * (i[:, 1] - i[:, 0]) * w2[:, 1] + i[:, 2] * (i[:, 2] - i[:, 0]) * w2[:, 2]
    d3 = i[:, 0] * (i[:, 2] - i[:, 0]) * w2[:, 0] + i[:, 1] * (i[:, 2] - i[:, 1]) * w2[:, 1]
    with np.errstate(divide="ignore", invalid="ignore"):
        first = np.fmin(twice / i[:, 0], d3 / (i[:, 0] * (i[:, 2] - i[:, 0])))
        third = np.fmin(twice / i[:, 2], d1 / (i[:, 2] * (i[:, 2] - i[:, 0])))
    fastest = np.sqrt(first + twice / i[:, 1] + third)
    family = "free symmetric" if equal else "free asymmetric"
    return _slowed(
        Scenes("free", family, moments, 0.0 * moments, omega, any_attitude(rng, n)), fastest
    )


def _slowed(scenes: Scenes, fastest: Floats) -> Scenes:
    """The scenes in units of time, powers of two, that put the fastest rate between 1/2 and 1."""
    power = -np.frexp(fastest)[1][:, None]
    weight, omega = np.ldexp(scenes.weight, 2 * power), np.ldexp(scenes.omega, power)
    return replace(scenes, weight=weight, omega=omega)


def tilts(rng: np.random.Generator, n: int) -> Floats:
    """Angles from the vertical, near to it and exactly there among them."""
    near = decades(rng, -13.0, 0.0, n)
    anywhere = rng.uniform(0.0, np.pi, n)
    pole = rng.choice([0.0, np.pi], n)
    return mixed(rng, near, anywhere, np.pi - near, anywhere, near, anywhere, pole)


def tops(rng: np.random.Generator, n: int) -> Scenes:
    """Lagrange tops about any axis, the centre of mass on either side of the fixed point."""
    third = mixed(
        rng, decades(rng, -6.0, 0.0, n), rng.uniform(0.0, 2.0, n), np.ones(n), 2 * np.ones(n)
    )
    tilt = tilts(rng, n)
    # phi, psi of the turns about the vertical and the axis; sums and differences of them count.
    half_sum, half_difference = rng.uniform(-np.pi, np.pi, (2, n))
    cos, sin = np.cos(0.5 * tilt), np.sin(0.5 * tilt)
    # What is exactly hanging has no cosine.
    cos[tilt == np.pi] = 0.0
    attitude = np.stack(
        [
            cos * np.cos(half_sum),
            sin * np.cos(half_difference),
            sin * np.sin(half_difference),
            cos * np.sin(half_sum),
        ],
        axis=-1,
    )
    sign = signs(rng, n)
    # mgl and the transverse moment 1. Spins: any, none, the slowest that sleeps and nearly that.
    threshold = (
        2.0 / third * (1.0 + mixed(rng, 0 * third, decades(rng, -16.0, 0.0, n) * signs(rng, n)))
    )
    spin = mixed(rng, rng.uniform(0.0, 20.0, n), rng.uniform(0.0, 20.0, n), 0 * third, threshold)
    spin *= signs(rng, n)
    spin[rng.uniform(size=n) < 0.01] = -0.0
    # Across the axis, the rates along the line of nodes tilt the top, those beside it turn it.
    node = half_sum - half_difference
    along, beside = (np.stack([np.cos(a), -np.sin(a)], axis=-1) for a in (node, node - 0.5 * np.pi))
    size = mixed(rng, np.ones(n), decades(rng, -12.0, 1.0, n))[:, None]
    # A steady precession turns at a root of cos(tilt) rate^2 - I3 spin rate + mgl = 0.
    z, a = sign * np.cos(tilt), third * spin
    root = np.sqrt(np.maximum(a * a - 4.0 * z, 0.0))
    rate = 2.0 * sign / np.copysign(np.maximum(np.abs(a) + root, 1e-3), a)
    steady = (rate * sin * cos * 2.0)[:, None] * beside
    # Through the upright pole with nothing to spare: 2 (1 - cos) of energy.
    fall = (np.sqrt(2.0 * np.maximum(1.0 - z, 0.0)) * signs(rng, n))[:, None] * along
    fall *= 1.0 + mixed(rng, 0 * third, decades(rng, -16.0, 0.0, n))[:, None]
    anywhere, still = rng.normal(size=(n, 2)), np.zeros((n, 2))
    across = mixed(rng, size * anywhere, size * along, size * beside, still, steady, fall)
    spin = np.where(rng.uniform(size=n) < 0.1, 0.0, spin)
    mgl = mixed(rng, np.ones(n), np.ones(n), decades(rng, -12.0, 0.0, n))
    omega = np.concatenate([across, spin[:, None]], axis=1)
    moments = np.stack([np.ones(n), np.ones(n), third], axis=-1)
    weight = np.stack([0 * mgl, 0 * mgl, sign * mgl], axis=-1)
    # The energy bounds the rates across; the pendulum's own rate is one too.
    fastest = np.sqrt(spin**2 + (across**2).sum(axis=1) + 4.0 * mgl)

    axis = rng.integers(3, size=n)
    rows, turn = np.arange(n)[:, None], (np.arange(3) - axis[:, None] + 2) % 3
    moments, weight, omega = moments[rows, turn], weight[rows, turn], omega[rows, turn]
    attitude = quaternion_product(attitude, THIRD_TO[axis])
    return _slowed(Scenes("top", "Lagrange top", moments, weight, omega, _unit(attitude)), fastest)


#: Turn of the body that makes its third axis the axis 1, 2, 3.
THIRD_TO = np.array([[0.5, -0.5, -0.5, -0.5], [0.5, 0.5, 0.5, 0.5], [1.0, 0.0, 0.0, 0.0]])


def swings(rng: np.random.Generator, n: int) -> Scenes:
    """Bodies that swing about a level principal axis, the weight across it."""
    moments = _moments(rng, n, equal=False)
    moments = rng.permuted(moments, axis=1)
    axis, one = rng.integers(2, size=n), np.arange(n)
    tilt = tilts(rng, n) * signs(rng, n)
    attitude, weight, omega = np.zeros((n, 4)), np.zeros((n, 3)), np.zeros((n, 3))
    attitude[:, 0], attitude[one, axis + 1] = np.cos(0.5 * tilt), np.sin(0.5 * tilt)
    side = rng.uniform(-np.pi, np.pi, n)
    aside = rng.choice([1.0, 0.0], n)
    mgl = decades(rng, -12.0, 0.0, n) * moments[one, axis]
    weight[one, (axis + 1) % 3] = mgl * np.cos(side) * aside
    weight[one, (axis + 2) % 3] = mgl * np.where(aside == 0.0, 1.0, np.sin(side))
    own = np.sqrt(mgl / moments[one, axis])
    rate = mixed(rng, 2.0 * own, own * decades(rng, -12.0, 1.0, n), rng.uniform(0.0, 1.0, n))
    omega[one, axis] = rate * signs(rng, n)
    # Out of the plane errors grow as fast as the smallest moment lets them.
    fastest = np.sqrt(rate**2 + 4.0 * mgl / moments.min(axis=1))
    return _slowed(Scenes("top", "plane swing", moments, weight, omega, _unit(attitude)), fastest)


#: What is drawn, with its share.
FAMILIES: tuple[tuple[float, Callable[[np.random.Generator, int], Scenes]], ...] = (
    (0.40, lambda rng, n: free(rng, n, equal=False)),
    (0.10, lambda rng, n: free(rng, n, equal=True)),
    (0.45, tops),
    (0.05, swings),
)


def batches(rng: np.random.Generator, total: int, size: int) -> Iterator[tuple[Scenes, Floats]]:
    """``total`` scenes in batches, each batch in its own units of time and mass, with its times."""
    shares = np.array([share for share, _ in FAMILIES])
    counts = np.diff(np.round(total * np.concatenate([[0.0], np.cumsum(shares)])).astype(int))
    for count, (_, draw) in zip(counts, FAMILIES, strict=True):
        for first in range(0, count, size):
            scenes = draw(rng, min(size, count - first))
            # Whole numbers of the roughest step: each leg then has exactly twice the steps.
            last = int(REACH / ROUGH_STEP)
            inner = 1 + rng.choice(last - 1, size=(2, STATES - 1), replace=False)
            backward, forward = np.sort(np.column_stack([inner, [last, last]]))
            power, mass = rng.integers(-40, 41, size=2)
            times = ROUGH_STEP * np.concatenate([-backward[::-1], forward])
            yield scenes.in_units(int(power), int(mass)), np.ldexp(times, -power)


# Comparison


@dataclass(frozen=True)
class Comparison:
    """Differences between closed form and RK4 as shares of what is expected and of what is allowed.

    Attributes
    ----------
    difference : ndarray, shape (n,)
        Largest over the times: rates relative to the fastest, attitudes in rad.
    expected, allowed : ndarray, shape (n,)
        Largest share of either bar; infinite where a state is not finite.
    """

    scenes: Scenes
    times: Floats
    difference: Floats
    expected: Floats
    allowed: Floats


def compared(scenes: Scenes, times: Floats, threads: int = 2) -> Comparison:
    """Closed forms against RK4 with half the step, extrapolated from the run with the whole one.

    The truncation is a fifteenth of the difference of the runs; an eighth of it is granted to the
    next order, which has one more step of 1/512. Each step of RK4 rounds the state, and that grows
    as errors of the start do: with the root of the number of steps where roundings are as good as
    random, which is expected. Where the motion is slow they all go the same way, so that their
    number itself is allowed. The closed form is granted some ulp of the angle turned and of each of
    its constants.
    """
    unit = float(REACH / np.abs(times).max())
    rates, attitudes = scenes.states(times, "exact", 0.0, threads)
    coarse = scenes.states(times, "rk4", STEP / unit, threads)
    fine = scenes.states(times, "rk4", 0.5 * STEP / unit, threads)
    left_out = [(b - a) / 15.0 for a, b in zip(coarse, fine, strict=True)]
    truncation = np.linalg.norm(left_out[0], axis=-1) / unit + 2.0 * np.linalg.norm(
        left_out[1], axis=-1
    )
    off = np.linalg.norm(rates - fine[0] - left_out[0], axis=-1) / unit
    difference = np.maximum(off, rotation_angle(attitudes, fine[1] + left_out[1]))

    angle = np.abs(times) * unit
    growth, steps = _growth(scenes, times, unit, threads), 2.0 * angle / STEP
    constant = truncation / 8.0 + 1e-15 * (1.0 + angle) + 4.0 * ROUNDOFF * growth
    expected, allowed = (constant + ROUNDOFF * n * growth for n in (np.sqrt(steps), steps))

    def largest(share: Floats) -> Floats:
        worst: Floats = np.where(np.isfinite(share), share, np.inf).max(axis=1)
        return worst

    shares = (difference, difference / expected, difference / allowed)
    return Comparison(scenes, times, *(largest(share) for share in shares))


def _growth(scenes: Scenes, times: Floats, unit: float, threads: int) -> Floats:
    """By how much errors of the start have grown at most until each time (n, m), at least 1.

    Measured by RK4 from starts off in one rate or by a turn about one axis, all six.
    """

    def moved(omega: Floats, attitude: Floats) -> tuple[Floats, Floats]:
        start = replace(scenes, omega=omega, attitude=attitude)
        return start.states(times, "rk4", ROUGH_STEP / unit, threads)

    rates, attitudes = moved(scenes.omega, scenes.attitude)
    squares = np.zeros(attitudes.shape[:-1])
    for nudge in NUDGE * np.eye(3):
        turn = np.concatenate([[1.0], 0.5 * nudge])
        for omega, attitude in (
            moved(scenes.omega + unit * nudge, scenes.attitude),
            moved(scenes.omega, quaternion_product(scenes.attitude, turn)),
        ):
            squares += ((omega - rates) ** 2).sum(axis=-1) / unit**2
            squares += rotation_angle(attitude, attitudes) ** 2
    growth = np.maximum(np.sqrt(squares) / NUDGE, 1.0)
    back, ahead = growth[:, times < 0.0], growth[:, times > 0.0]
    so_far = np.maximum.accumulate(back[:, ::-1], axis=1)[:, ::-1]
    return np.concatenate([so_far, np.maximum.accumulate(ahead, axis=1)], axis=1)
