"""Closed forms: random scenes solved in 400 bits and more, and laws that need no truth."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest
from scipy.special import ellipj, ellipk, elliprc, elliprd, elliprf, elliprj

import rigid
from physics import GOLDEN, ROUNDOFF, Floats, present, quaternion_product, rotation_angle
from random_scenes import Scenes, batches, compared
from rigid import _core, exact
from rigid.model.scene import Scene

with np.load(GOLDEN / "closed_forms.npz") as _file:
    TABLE = dict(_file)
FAMILIES: list[str] = TABLE["families"].tolist()
FREE = [name for name in FAMILIES if name.startswith("free")]
TOPS = [name for name in FAMILIES if name.startswith("top")]  # without plane swings


@dataclass(frozen=True)
class Case:
    """A start, its state at time t to 75 bits, and what rounding the inputs costs."""

    moments: Floats
    weight: Floats
    omega0: Floats
    attitude0: Floats
    t: float
    omega: tuple[Floats, Floats]
    attitude: tuple[Floats, Floats]
    angle: float
    kappa_omega: float
    kappa_att: float

    @property
    def scene(self) -> Scene:
        return scene(self.moments, self.weight)

    @property
    def fastest(self) -> float:
        return self.angle / abs(self.t)

    @property
    def tips_over(self) -> bool:
        """Whether rounding the inputs decides the motion: upright at rest, long on a separatrix."""
        return self.kappa_att * ROUNDOFF > 0.1

    def bars(self) -> tuple[float, float]:
        """Allowed error of the rates, relative to the fastest, and of the attitude (rad).

        The phases are products of a rate and the time, each a few roundings: a fraction of the
        angle turned. The inputs are exact, but constants made of them are rounded: as if each input
        were, to a few ulp.
        """
        phase = 1e-15 * (1.0 + self.angle)
        omega, attitude = (4.0 * ROUNDOFF * k for k in (self.kappa_omega, self.kappa_att))
        return max(phase, omega), max(phase, attitude)


def cases(family: str, stride: int = 1) -> Iterator[Case]:
    for k in np.flatnonzero(TABLE["family"] == FAMILIES.index(family))[::stride]:
        weight = np.zeros(3)
        if axis := int(TABLE["axis"][k]):
            weight[abs(axis) - 1] = np.copysign(TABLE["mgl"][k], axis)
        yield Case(
            moments=TABLE["moments"][k],
            weight=weight,
            omega0=TABLE["omega0"][k],
            attitude0=TABLE["attitude0"][k],
            t=float(TABLE["t"][k]),
            omega=(TABLE["omega"][k], TABLE["omega_low"][k]),
            attitude=(TABLE["attitude"][k], TABLE["attitude_low"][k]),
            angle=float(TABLE["angle"][k]),
            kappa_omega=float(TABLE["kappa_omega"][k]),
            kappa_att=float(TABLE["kappa_att"][k]),
        )


def scene(moments: Floats, weight: Floats) -> Scene:
    mgl = float(np.abs(weight).max())
    body = rigid.Body(moments)
    return rigid.HeavyTop(body, mgl=mgl, com=weight / mgl) if mgl else rigid.FreeBody(body)


def moved(scene: Scene, omega: Floats, attitude: Floats, t: float) -> tuple[Floats, Floats]:
    """Rates and attitude at time t, (..., 3) and (..., 4)."""
    run = rigid.simulate(scene, omega, attitude, t=[t], method="exact")
    rates, turned = run.omega[..., 0, :], present(run.attitude)[..., 0, :]
    assert np.isfinite(rates).all()
    assert np.isfinite(turned).all()
    return rates, turned


def apart(attitude: Floats, high: Floats, low: Floats) -> float:
    """Angle (rad) to an attitude known as a sum of two doubles.

    The difference is formed first: the product of an attitude and its own inverse has no vector
    part, so nothing cancels.
    """
    off = np.copysign(1.0, attitude @ high) * attitude - high - low
    inverse = high * [1.0, -1.0, -1.0, -1.0]
    return float(
        2.0 * np.arctan2(np.linalg.norm(quaternion_product(inverse, off)[1:]), abs(attitude @ high))
    )


@pytest.mark.parametrize("family", FAMILIES)
def test_rates_and_attitude_are_those_of_400_bits(family: str) -> None:
    """99 % within what rounding explains, all within twenty times that."""
    shares = []
    for case in cases(family):
        omega, attitude = moved(case.scene, case.omega0, case.attitude0, case.t)
        bars = case.bars()
        if case.tips_over:
            continue
        error = float(np.linalg.norm(omega - case.omega[0] - case.omega[1]))
        relative = error / case.fastest if case.fastest else error
        turned = apart(attitude, *case.attitude)
        shares.append((relative / bars[0], turned / bars[1]))
    worst = np.array(shares)
    assert (np.quantile(worst, 0.99, axis=0) <= 1.0).all()
    assert (worst <= 20.0).all()


def legs(case: Case, first: float, second: float) -> tuple[tuple[Floats, Floats], Floats, Floats]:
    """The state after two runs one after the other, and what an error of the first costs.

    That is measured: the second run starts again from states off by the bar in each rate, relative
    to the fastest one, and by a turn about each axis.
    """
    middle = moved(case.scene, case.omega0, case.attitude0, first)
    off, turn = case.bars()
    omega = middle[0] + off * case.fastest * np.vstack(
        [np.zeros((1, 3)), np.eye(3), np.zeros((3, 3))]
    )
    turns = np.tile([1.0, 0.0, 0.0, 0.0], (7, 1))
    turns[4:, 1:] = np.eye(3) * turn / 2.0
    after = moved(case.scene, omega, quaternion_product(middle[1], turns), second)
    rates = np.linalg.norm(after[0][1:] - after[0][0], axis=-1).sum() / (case.fastest or 1.0)
    angle = rotation_angle(*np.broadcast_arrays(after[1][1:], after[1][0])).sum()
    return (after[0][0], after[1][0]), rates, angle


def handed_over(case: Case) -> bool:
    """Whether a state in doubles can say on which side of the separatrix it is, and how far.

    In the middle of a flip the distance, the complementary parameter, is a difference of numbers of
    order one.
    """
    if not isinstance(case.scene, rigid.FreeBody):
        return True
    return bool(rigid.exact.free_body(case.scene, case.omega0).mc > 1e-10)


@pytest.mark.parametrize("family", FREE + TOPS)
def test_a_state_is_a_start(family: str) -> None:
    """The way in two halves is the whole way."""
    for case in filter(handed_over, cases(family, 9)):
        (omega, attitude), rates, angle = legs(case, case.t / 2.0, case.t / 2.0)
        bars = case.bars()
        error = float(np.linalg.norm(omega - case.omega[0] - case.omega[1]))
        assert error <= 4.0 * (bars[0] + rates) * case.fastest
        assert apart(attitude, *case.attitude) <= 4.0 * (bars[1] + angle)


@pytest.mark.parametrize("family", FREE + TOPS)
def test_the_way_back_is_the_way(family: str) -> None:
    """Minus the time, from where it led."""
    for case in filter(handed_over, cases(family, 9)):
        (omega, attitude), rates, angle = legs(case, case.t, -case.t)
        bars = case.bars()
        assert np.linalg.norm(omega - case.omega0) <= 4.0 * (bars[0] + rates) * case.fastest
        assert rotation_angle(attitude, case.attitude0) <= 4.0 * (bars[1] + angle)


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("power", [-20, -1, 7])
def test_units_of_time_and_mass_change_no_bit(family: str, power: int) -> None:
    """Powers of two are exact: rates times 2^k, times by 2^-k; moments and weight by 2^k."""
    for case in cases(family, 23):
        omega, attitude = moved(case.scene, case.omega0, case.attitude0, case.t)
        faster = scene(case.moments, np.ldexp(case.weight, 2 * power))
        rates = np.ldexp(case.omega0, power)
        other = moved(faster, rates, case.attitude0, float(np.ldexp(case.t, -power)))
        assert other[0].tobytes() == np.ldexp(omega, power).tobytes()
        assert other[1].tobytes() == attitude.tobytes()

        heavier = scene(np.ldexp(case.moments, power), np.ldexp(case.weight, power))
        other = moved(heavier, case.omega0, case.attitude0, case.t)
        assert other[0].tobytes() == omega.tobytes()
        assert other[1].tobytes() == attitude.tobytes()


#: Turns of the body that map its axes to one another: component k of a vector in the new body is
#: sign[k] times component order[k] in the old one.
RENAMINGS = [
    ((1, 2, 0), (1, 1, 1), (0.5, 0.5, 0.5, 0.5)),
    ((2, 0, 1), (1, 1, 1), (0.5, -0.5, -0.5, -0.5)),
    ((0, 1, 2), (1, -1, -1), (0.0, 1.0, 0.0, 0.0)),
    ((1, 0, 2), (1, 1, -1), (0.0, np.sqrt(0.5), np.sqrt(0.5), 0.0)),
]


@pytest.mark.parametrize("family", FREE)
@pytest.mark.parametrize(("order", "signs", "turn"), RENAMINGS)
def test_the_names_of_the_axes_are_free(
    family: str, order: tuple[int, ...], signs: tuple[int, ...], turn: tuple[float, ...]
) -> None:
    """The same body in other axes: the same state, to the rounding of the renamed attitude."""
    renaming = np.array(turn)
    for case in cases(family, 9):
        indices, flips = list(order), np.array(signs)
        renamed = scene(case.moments[indices], case.weight)
        start = quaternion_product(case.attitude0, renaming)
        omega, attitude = moved(renamed, flips * case.omega0[indices], start, case.t)
        bars = case.bars()
        off = omega - flips * (case.omega[0] + case.omega[1])[indices]
        assert np.linalg.norm(off) <= 4.0 * bars[0] * case.fastest
        assert (
            rotation_angle(attitude, quaternion_product(case.attitude[0], renaming))
            <= 4.0 * bars[1]
        )


@pytest.mark.parametrize("family", TOPS)
def test_a_turn_of_space_about_the_vertical_turns_the_motion(family: str) -> None:
    """Weight does not know north; starts on a pole, which have no azimuth, are among them."""
    turn = np.array([0.6, 0.0, 0.0, 0.8])
    for case in cases(family, 9):
        start = quaternion_product(turn, case.attitude0)
        omega, attitude = moved(case.scene, case.omega0, start, case.t)
        # The turned start is rounded relative to the whole, the given one may be exact in a small
        # tilt: what that costs is seen by turning back.
        again = moved(
            case.scene, case.omega0, quaternion_product(turn * [1, -1, -1, -1], start), case.t
        )
        bars = case.bars()
        lost, off = (np.linalg.norm(rates - case.omega[0]) for rates in (again[0], omega))
        assert off <= 4.0 * (bars[0] * case.fastest + lost)
        strayed = rotation_angle(again[1], case.attitude[0])
        angle = rotation_angle(attitude, quaternion_product(turn, case.attitude[0]))
        assert angle <= 4.0 * (bars[1] + strayed)


def test_nothing_jumps_at_the_separatrix() -> None:
    """Neighbouring doubles on both sides of it move alike until they pass the saddle.

    Moments 4, 5, 9 and rates with w1 = 3 w3 are on it. Differences grow at most as the rate of the
    saddle, sqrt((I3 - I2) (I2 - I1)/(I1 I3)) = 1/3 per radian about axis 2.
    """
    body = rigid.FreeBody(rigid.Body((4.0, 5.0, 9.0)))
    on = np.array([3.0, 0.5, 1.0])
    omega = np.array([on * [1.0 + k * 2.0**-52, 1.0, 1.0] for k in range(-4, 5)])
    start = np.tile([1.0, 0.0, 0.0, 0.0], (9, 1))
    for t in (-2.0, -0.3, 0.1, 1.0, 3.0):
        rates, attitude = moved(body, omega, start, t)
        speed = np.linalg.norm(on)
        allowed = 64.0 * ROUNDOFF * (1.0 + speed * abs(t)) * np.exp(speed * abs(t) / 3.0)
        assert np.abs(rates - rates[4]).max() <= allowed * speed
        assert rotation_angle(*np.broadcast_arrays(attitude, attitude[4])).max() <= allowed


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("third", [0.25, 1.0, 1.75])
def test_a_nearly_symmetric_body_moves_as_the_symmetric_one(axis: int, third: float) -> None:
    """One ulp in a moment: two forms that share no line differ by an ulp of the angles turned."""
    equal = np.ones(3)
    equal[axis] = third
    nearly = equal.copy()
    nearly[(axis + 1) % 3] += 2.0**-52
    omega = np.array([[0.7, -0.4, 1.1], [-1.3, 0.2, 0.5], [0.3, 0.9, -2.0]])
    for t in (-20.0, 0.5, 30.0):
        rates, attitude = moved(scene(equal, np.zeros(3)), omega, np.array([1.0, 0.0, 0.0, 0.0]), t)
        other = moved(scene(nearly, np.zeros(3)), omega, np.array([1.0, 0.0, 0.0, 0.0]), t)
        allowed = 2e-15 * (1.0 + np.linalg.norm(omega, axis=-1).max() * abs(t))
        assert np.abs(rates - other[0]).max() <= allowed * np.abs(omega).max()
        assert rotation_angle(attitude, other[1]).max() <= allowed


def test_a_top_at_a_pole_moves_as_one_beside_it() -> None:
    """Through upright and through hanging, on the pole and 1e-13 rad beside it."""
    top = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)
    omega = np.array([0.3, -0.8, 2.0])
    for pole in ([1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0]):
        on = np.array(pole)
        beside = quaternion_product(on, np.array([1.0, 3e-14, -4e-14, 0.0]))
        for t in (-3.0, 0.2, 5.0):
            rates, attitude = moved(top, omega, on, t)
            other = moved(top, omega, beside, t)
            # Growth at the rate of the saddle sqrt(mgl/I1) = 1, with spin less.
            allowed = 4e-13 * np.exp(abs(t))
            assert np.abs(rates - other[0]).max() <= allowed
            assert rotation_angle(attitude, other[1]) <= allowed


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
    mc = np.array([1e-6, 0.5, 1.0])
    np.testing.assert_allclose(
        np.pi / 2 / exact.agm(1.0, np.sqrt(mc)), ellipk(1.0 - mc), rtol=1e-10
    )
