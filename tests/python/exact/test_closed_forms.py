"""Closed forms: random scenes solved in 400 bits and more, and the laws of starts and units."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import ArrayLike
from scipy.special import ellipj, ellipk, elliprc, elliprd, elliprf, elliprj

import rigid
from physics import GOLDEN, ROUNDOFF, Floats, present, quaternion_product, rotation_angle
from random_scenes import Scenes, batches, compared
from rigid import _core, exact
from rigid.model.scene import Scene

with np.load(GOLDEN / "closed_forms.npz") as _file:
    TABLE = dict(_file)
FAMILIES: list[str] = TABLE["families"].tolist()


@dataclass(frozen=True)
class Cases:
    """Starts, their states at times t to 75 bits, and what rounding the inputs costs; (n, ...)."""

    moments: Floats
    weight: Floats
    omega0: Floats
    attitude0: Floats
    t: Floats
    omega: tuple[Floats, Floats]
    attitude: tuple[Floats, Floats]
    angle: Floats
    kappa_omega: Floats
    kappa_att: Floats

    @property
    def scene(self) -> Scene:
        return scene(self.moments, self.weight)

    @property
    def fastest(self) -> Floats:
        return self.angle / np.abs(self.t)

    def bars(self) -> tuple[Floats, Floats]:
        """Allowed errors of the rates, relative to the fastest, and of the attitude (rad).

        The phases are products of a rate and the time, each a few roundings: a fraction of the
        angle turned. The inputs are exact, but constants made of them are rounded: as if each input
        were, to a few ulp.
        """
        phase = 1e-15 * (1.0 + self.angle)
        omega, attitude = (4.0 * ROUNDOFF * k for k in (self.kappa_omega, self.kappa_att))
        return np.maximum(phase, omega), np.maximum(phase, attitude)


def cases(family: str, *, handed_over: bool = False) -> Cases:
    """The cases of a family; of ``handed_over`` those whose states in doubles are good starts.

    In the middle of a flip the distance from the separatrix, the complementary parameter, is a
    difference of numbers of order one.
    """
    rows = np.flatnonzero(TABLE["family"] == FAMILIES.index(family))
    if handed_over:
        bodies, axes = rigid.Body(TABLE["moments"][rows]), TABLE["axis"][rows]
        rows = rows[(axes != 0) | (exact.free_body(bodies, TABLE["omega0"][rows]).mc > 1e-10)]
    table = {name: column[rows] for name, column in TABLE.items() if name != "families"}
    along = np.abs(table["axis"])[:, np.newaxis] == [1, 2, 3]
    return Cases(
        weight=along * (np.sign(table["axis"]) * table["mgl"])[:, np.newaxis],
        omega=(table["omega"], table["omega_low"]),
        attitude=(table["attitude"], table["attitude_low"]),
        **{name: table[name] for name in ("moments", "omega0", "attitude0", "t")},
        **{name: table[name].astype(float) for name in ("angle", "kappa_omega", "kappa_att")},
    )


def scene(moments: Floats, weight: Floats) -> Scene:
    body, mgl = rigid.Body(moments), np.abs(weight).max(axis=-1)
    if not mgl.any():
        return rigid.FreeBody(body)
    com = np.where(mgl[:, np.newaxis] > 0.0, np.sign(weight), [0.0, 0.0, 1.0])
    return rigid.HeavyTop(body, mgl=mgl, com=com)


def moved(
    scene: Scene | rigid.Body, omega: Floats, attitude: Floats, t: ArrayLike
) -> tuple[Floats, Floats]:
    """Rates and attitudes at time t, of all bodies or of each, (..., 3) and (..., 4)."""
    times = np.asarray(t)[..., np.newaxis]
    run = rigid.simulate(scene, omega, attitude, t=times, method="exact")
    rates, turned = run.omega[..., 0, :], present(run.attitude)[..., 0, :]
    assert np.isfinite(rates).all()
    assert np.isfinite(turned).all()
    return rates, turned


def rates_apart(omega: Floats, cases: Cases) -> Floats:
    """Distances of rates from the true ones (rad/s), shape (n,)."""
    distance: Floats = np.linalg.norm(omega - cases.omega[0] - cases.omega[1], axis=-1)
    return distance


def turned_apart(attitude: Floats, cases: Cases) -> Floats:
    """Angles (rad) to the true attitudes, known as sums of two doubles, shape (n,).

    The difference is formed first: the product of an attitude and its own inverse has no vector
    part, so nothing cancels.
    """
    high, low = cases.attitude
    cosine = np.vecdot(attitude, high)
    off = np.copysign(1.0, cosine)[:, np.newaxis] * attitude - high - low
    inverse = high * [1.0, -1.0, -1.0, -1.0]
    sine = np.linalg.norm(quaternion_product(inverse, off)[:, 1:], axis=-1)
    angle: Floats = 2.0 * np.arctan2(sine, np.abs(cosine))
    return angle


@pytest.mark.parametrize("family", FAMILIES)
def test_rates_and_attitude_are_those_of_400_bits(family: str) -> None:
    """99 % within what rounding explains, all within twenty times that.

    But for those whose rounded inputs decide the motion: upright at rest, long on a separatrix.
    """
    found = cases(family)
    omega, attitude = moved(found.scene, found.omega0, found.attitude0, found.t)
    fastest = np.where(found.fastest > 0.0, found.fastest, 1.0)
    shares = np.array([rates_apart(omega, found) / fastest, turned_apart(attitude, found)])
    worst = (shares / found.bars())[:, found.kappa_att * ROUNDOFF <= 0.1]
    assert (np.quantile(worst, 0.99, axis=1) <= 1.0).all()
    assert (worst <= 20.0).all()


@pytest.mark.parametrize("family", [name for name in FAMILIES if name != "swing"])
def test_a_state_is_a_start(family: str) -> None:
    """The way in two halves is the whole way.

    What errors of the first half cost is measured: the second begins again from states off by the
    bar in each rate, relative to the fastest one, and by a turn about each axis.
    """
    found = cases(family, handed_over=True)
    half, (off, turn) = found.t / 2.0, found.bars()
    middle = moved(found.scene, found.omega0, found.attitude0, half)
    omega = np.tile(middle[0], (7, 1, 1))
    omega[1:4] += np.eye(3)[:, np.newaxis] * (off * found.fastest)[:, np.newaxis]
    turns = np.tile([1.0, 0.0, 0.0, 0.0], (7, len(half), 1))
    turns[4:, :, 1:] = np.eye(3)[:, np.newaxis] * turn[:, np.newaxis] / 2.0
    rates, turned = moved(found.scene, omega, quaternion_product(middle[1], turns), half)
    lost = np.linalg.norm(rates[1:] - rates[0], axis=-1).sum(axis=0)
    angles = rotation_angle(*np.broadcast_arrays(turned[1:], turned[0])).sum(axis=0)
    assert (rates_apart(rates[0], found) <= 4.0 * (off * found.fastest + lost)).all()
    assert (turned_apart(turned[0], found) <= 4.0 * (turn + angles)).all()


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("power", [-20, -1, 7])
def test_units_of_time_and_mass_change_no_bit(family: str, power: int) -> None:
    """Powers of two are exact: rates times 2^k, times by 2^-k; moments and weight by 2^k."""
    found = cases(family)
    omega, attitude = moved(found.scene, found.omega0, found.attitude0, found.t)
    faster = scene(found.moments, np.ldexp(found.weight, 2 * power))
    rates = np.ldexp(found.omega0, power)
    other = moved(faster, rates, found.attitude0, np.ldexp(found.t, -power))
    assert other[0].tobytes() == np.ldexp(omega, power).tobytes()
    assert other[1].tobytes() == attitude.tobytes()

    heavier = scene(np.ldexp(found.moments, power), np.ldexp(found.weight, power))
    other = moved(heavier, found.omega0, found.attitude0, found.t)
    assert other[0].tobytes() == omega.tobytes()
    assert other[1].tobytes() == attitude.tobytes()


# Closed forms against Runge-Kutta steps, a small part of what tests/long does with a million


@pytest.mark.parametrize("seed", [1, 2])
def test_random_scenes_move_as_rk4_steps_them(seed: int) -> None:
    """All within the rounding of RK4 added up, nine in ten within that of random roundings."""
    expected = []
    for scenes, times in batches(np.random.default_rng(seed), 1000, 200):
        result = compared(scenes, times)
        worst = int(result.allowed.argmax())
        assert result.allowed[worst] <= 1.0, scenes.written(worst)
        expected.append(result.expected)
    assert np.quantile(np.concatenate(expected), 0.9) <= 1.0


def test_a_motion_that_is_off_by_a_part_in_a_billion_is_found(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The bars are narrow: closed forms of slightly faster starts lie beyond them."""
    states = Scenes.states

    def faster(
        self: Scenes, times: Floats, method: str, step: float, threads: int
    ) -> tuple[Floats, Floats]:
        off = 1.0 + 1e-9 * (method == "exact")
        return states(replace(self, omega=off * self.omega), times, method, step, threads)

    monkeypatch.setattr(Scenes, "states", faster)
    scenes, times = next(batches(np.random.default_rng(1), 1000, 400))
    assert (compared(scenes, times).allowed > 1.0).mean() > 0.99


def test_random_scenes_are_of_all_classes() -> None:
    rng = np.random.default_rng(1)
    found: set[str] = set()
    for scenes, _ in batches(rng, 2000, 2000):
        forms = _core.closed_forms(scenes.bodies)
        found.update(_core.closed_form_names()[code] for code in np.unique(forms))
    assert found == {"axis spin", "free symmetric", "free asymmetric", "lagrange", "pendulum"}


# Elliptic integrals and functions, against printed tables and identities

POSITIVE = 10.0 ** np.random.default_rng(1).uniform(-2.0, 2.0, (4, 200))


@pytest.mark.parametrize(
    ("ours", "theirs", "count"),
    [
        (exact.carlson_rf, elliprf, 3),
        (exact.carlson_rc, elliprc, 2),
        (exact.carlson_rd, elliprd, 3),
        (exact.carlson_rj, elliprj, 4),
    ],
)
def test_carlson_integrals(
    ours: Callable[..., Any], theirs: Callable[..., Any], count: int
) -> None:
    arguments = POSITIVE[:count]
    # Both are within some ulp of the truth, SciPy's third kind only for arguments of like size.
    np.testing.assert_allclose(ours(*arguments), theirs(*arguments), rtol=4e-15)
    assert np.shape(ours(*arguments[:, 0])) == ()
    assert ours(arguments[0][:, None], *arguments[1:, :1, None]).shape == (200, 1)
    zero = (0.0, *arguments[1:, 0])
    assert ours(*zero) == pytest.approx(theirs(*zero), rel=4e-15)


def test_jacobi_functions() -> None:
    u, mc = np.linspace(-20.0, 20.0, 101)[:, None], np.array([0.0, 1e-3, 0.3, 0.9, 1.0])
    found = exact.jacobi(u, mc)
    for mine, theirs in zip(found, ellipj(u, 1.0 - mc)[:3], strict=True):
        assert mine.shape == (101, 5)
        # SciPy rounds 1 - mc, which counts near mc = 0, and the argument u twenty times.
        np.testing.assert_allclose(mine, theirs, atol=1e-12)
    sn, cn, dn = exact.jacobi(5.0, mc=0.0)
    assert sn == pytest.approx(np.tanh(5.0), rel=4 * ROUNDOFF)
    assert cn == dn == pytest.approx(1.0 / np.cosh(5.0), rel=16 * ROUNDOFF)


@pytest.mark.parametrize("u", [1000.0, -1e12, np.nextafter(2.0**50, 0.0)])
def test_jacobi_functions_of_the_parameter_zero_are_sine_and_cosine(u: float) -> None:
    sn, cn, dn = exact.jacobi(u, mc=1.0)
    np.testing.assert_allclose([sn, cn], [np.sin(u), np.cos(u)], rtol=4 * ROUNDOFF)
    assert dn == 1.0


def test_carlson_integrals_of_the_largest_arguments() -> None:
    """`R_D(x, x, x) = R_J(x, x, x, x) = x^(-3/2)`."""
    x = 1e200
    for found in (exact.carlson_rd(x, x, x), exact.carlson_rj(x, x, x, x)):
        assert found == pytest.approx(1e-300, rel=16 * ROUNDOFF)


def test_the_mean_is_gauss_s() -> None:
    # Gauss, 1799: 1 / agm(1, sqrt 2) = 0.8346268416740731...
    assert 1.0 / exact.agm(1.0, np.sqrt(2.0)) == pytest.approx(0.8346268416740731, rel=4 * ROUNDOFF)
    assert exact.agm([1.0, 4.0], [[1.0], [4.0]]).shape == (2, 2)
    assert exact.agm(3.0, 3.0) == 3.0
    # It is homogeneous; products of such numbers leave the range of doubles.
    unit = 2.0**600 * np.array([[1.0], [2.0**-1200]])
    assert np.array_equal(exact.agm(unit * [1.0, 1e-300], unit), unit * exact.agm([1.0, 1e-300], 1))
    assert exact.agm(1e308, 1e308) == 1e308
    assert exact.agm(5e-324, 5e-324) == 5e-324
    mc = np.array([1e-6, 0.5, 1.0])
    np.testing.assert_allclose(
        np.pi / 2 / exact.agm(1.0, np.sqrt(mc)), ellipk(1.0 - mc), rtol=1e-10
    )
