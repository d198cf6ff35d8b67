"""Lyapunov exponents and chaos indicators: against 26 digits, closed forms and theory."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.spatial.transform import Rotation

import quad_motion
import rigid
from chaos_scenes import DEVIATING, Deviating
from judged_growth import judge_growth
from physics import Floats, gamma_of, present
from refusals import refuses
from rigid import _core
from rigid.model.bodies import bodies_of
from rigid.model.scene import Scene

TOP = rigid.HeavyTop(rigid.Body((1.0, 1.6, 0.7)), mgl=1.2, com=(0.6, 0.0, 0.8))
BOX = rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0)))
CHAOTIC, REGULAR = [0.3, 0.4, 1.0], [0.1, 0.0, 20.0]
ATTITUDE = [0.9, 0.3, 0.2, 0.1]
ALL: dict[str, Any] = {"of": "attitude", "exponents": 6, "check": False}


# --- Data ----------------------------------------------------------------------------------------


def grown(case: Deviating, **options: Any) -> rigid.Growth:
    return rigid.lyapunov(case.scene, case.omega, case.attitude, **options)


@pytest.mark.parametrize("of", ["rates", "attitude"])
@pytest.mark.parametrize("case", DEVIATING, ids=lambda case: case.name)
def test_growth_of_26_digits(case: Deviating, of: str) -> None:
    """As exact as the matrices: rounding of the start costs the square of the growth."""
    true = case.growth[of]
    found = grown(case, t=case.t, of=of, exponents=4, start=case.tangents, check=False)
    sizes = np.linalg.norm(case.scaled(case.matrices), 2, axis=(1, 2))
    allowed = 3.0 * np.maximum(1e-13, 3e-14 * sizes.max() ** 2 / sizes)
    assert (np.abs(found.log_growth - true["log_growth"]) < allowed).all()
    np.testing.assert_allclose(found.megno, true["megno"], rtol=0.0, atol=1e-8)
    np.testing.assert_allclose(found.mean_megno, true["mean_megno"], rtol=0.0, atol=1e-6)
    for name in ("sali", "gali"):
        values, known = present(getattr(found, name)), true[name] > 1e-8
        np.testing.assert_allclose(values[known], true[name][known], rtol=1e-6)


def test_the_error_of_growth_covers_the_truth_of_26_digits() -> None:
    """The check of a series in its own steps agreed to the last bit, and the error was zero."""
    ratios = []
    for case in DEVIATING:
        times = case.t[case.t > 0.0]
        for of in ("rates", "attitude"):
            found = grown(case, t=times, of=of, start=case.tangents[0])
            true = case.growth[of]["log_growth"][case.t > 0.0]
            ratios.append(np.abs(found.log_growth - true).max() / float(found.error))
    # The start as doubles differs from that of 26 digits by rounding, which both runs share.
    assert np.mean(np.array(ratios) <= 1.0) > 0.9
    assert max(ratios) < 2.0


@pytest.mark.skipif(not quad_motion.is_available(), reason="no 128-bit numbers")
@pytest.mark.parametrize("number", [8, 22, 50, 58, 60, 134, 158])
def test_the_error_of_growth_has_the_rounding_that_both_runs_share(number: int) -> None:
    """Their logarithms agree to the last bits; one rounding of each was stated, two are wrong."""
    found = judge_growth(number, seed=2)
    assert found.verdict == "right", (found.off, found.stated)


@pytest.mark.parametrize("power", [-1000, -700, 700, 1000])
def test_the_size_of_a_deviation_does_not_matter(power: int) -> None:
    start = np.array([1.0, -2.0, 3.0, 1.0, 0.5, -1.0])
    known, found = (
        rigid.lyapunov(TOP, [0.3, 0.4, 1.0], t=[10.0, 20.0], start=vector)
        for vector in (start, np.ldexp(start, power))
    )
    np.testing.assert_array_equal(found.log_growth, known.log_growth)
    np.testing.assert_array_equal(found.mean_megno, known.mean_megno)


@pytest.mark.parametrize("case", DEVIATING, ids=lambda case: case.name)
def test_the_spectrum_is_that_of_a_decomposition_in_26_digits(case: Deviating) -> None:
    """``ln`` of the diagonal of R of the whole matrix, however often it is made orthogonal."""
    unit = np.diag([case.rate_scale] * 3 + [1.0] * 3)
    for of, count in (("attitude", 6), ("rates", 3)):
        found = grown(case, t=case.t, of=of, exponents=count, start=unit[:count], check=False)
        logs = found.spectrum * case.t[:, None]
        true = case.growth[of]["log_qr"]
        # The worst was 6e-11, beside a separatrix.
        np.testing.assert_allclose(logs, true[:, :count], rtol=0.0, atol=3e-10)
        if count == 6:
            np.testing.assert_allclose(logs.sum(axis=1), true.sum(axis=1), rtol=0.0, atol=1e-13)


@pytest.mark.parametrize("case", DEVIATING, ids=lambda case: case.name)
def test_trapezoids_of_small_steps(case: Deviating) -> None:
    """In steps of a tenth of a radian."""
    found = rigid.lyapunov(
        case.scene, case.omega, case.attitude, t=case.t, start=case.tangents[0], method="dop853"
    )
    true = case.growth["rates"]
    np.testing.assert_allclose(found.megno, true["megno"], rtol=0.0, atol=2e-4)
    np.testing.assert_allclose(found.mean_megno, true["mean_megno"], rtol=0.0, atol=5e-4)
    # Its own error estimate is above its error.
    assert (np.abs(found.log_growth - true["log_growth"]) <= found.error + 1e-9).all()


# --- Truths --------------------------------------------------------------------------------------


@pytest.mark.parametrize("turned", [1.0, 10.0, 100.0])
def test_a_sphere_beside_a_faster_one(turned: float) -> None:
    """``L = ln(1 + a²)/2`` at the angle a: MEGNO and its mean in arcus tangents."""
    rate = 2.5
    sphere = rigid.FreeBody(rigid.Body((1.0, 1.0, 1.0)))
    omega = rate * np.array([0.0, 0.6, 0.8])
    found = rigid.lyapunov(
        sphere, omega, t=[turned / rate], of="attitude", start=[*omega, 0.0, 0.0, 0.0]
    )
    integral = quad(lambda a: np.arctan(a) / a, 0.0, turned, epsabs=1e-13, limit=200)[0]
    assert found.log_growth[0] == pytest.approx(0.5 * np.log1p(turned**2), abs=1e-13)
    assert found.megno[0] == pytest.approx(2.0 - 2.0 * np.arctan(turned) / turned, abs=1e-8)
    assert found.mean_megno[0] == pytest.approx(2.0 - 2.0 * integral / turned, abs=1e-6)
    assert found.fli[0] == found.log_growth[0]


@pytest.mark.parametrize(
    ("scene", "omega", "rate"),
    [
        # sqrt((I2 - I1)(I3 - I2) / (I1 I3)) w2.
        (BOX, [0.0, 1.5, 0.0], 1.5 / np.sqrt(3.0)),
        # sqrt(mgl / A - (C n / 2 A)²).
        (rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0), [0.0, 0.0, 2.0], np.sqrt(0.75)),
        # sqrt(mgl / min(I1, I2)).
        (rigid.HeavyTop(rigid.Body((1.0, 1.5, 2.0)), mgl=1.0), [0.0, 0.0, 0.0], 1.0),
    ],
    ids=["middle axis", "sleeping top awake", "upright at rest"],
)
def test_exponents_of_unstable_equilibria(scene: Scene, omega: list[float], rate: float) -> None:
    """After a while the growth is ``rate t``, and MEGNO the rate times the time, nearly."""
    found = rigid.lyapunov(scene, omega, t=[10.0, 12.0, 20.0], of="attitude", check=False)
    slope = np.diff(found.log_growth)[0] / 2.0
    # What decays and what turns is exp(-2 rate t) and exp(-rate t) of it.
    assert slope == pytest.approx(rate, rel=2.0 * np.exp(-10.0 * rate))
    assert found.megno[-1] == pytest.approx(rate * 20.0, abs=3.0)
    assert found.mean_megno[-1] == pytest.approx(0.5 * rate * 20.0, abs=3.0)


def test_exponents_of_all_signs_add_up_to_the_damping() -> None:
    """The sum is ``-tr(D / I)`` at any time, under any torque."""
    acting: dict[str, Any] = {"damping": (0.06, 0.03, 0.12)}
    acting["torque"] = rigid.Torque.space([0.1, -0.2, 0.05])
    found = rigid.lyapunov(replace(TOP, **acting), CHAOTIC, ATTITUDE, t=[1.0, 10.0, 100.0], **ALL)
    trace = -(0.06 / 1.0 + 0.03 / 1.6 + 0.12 / 0.7)
    np.testing.assert_allclose(found.spectrum.sum(axis=1), trace, rtol=0.0, atol=1e-12)
    assert found.pairing is None


def test_a_free_body_coming_to_rest_keeps_the_exponents_of_its_damping() -> None:
    body = rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0)), damping=[0.5, 0.6, 0.3])
    found = rigid.lyapunov(body, [0.3, 0.2, 0.4], t=[100.0, 200.0], **ALL)
    rates = np.diff(found.spectrum * found.t[:, None], axis=0)[0] / 100.0
    np.testing.assert_allclose(rates, [0.0, 0.0, 0.0, -0.1, -0.3, -0.5], atol=1e-6)
    assert found.zeros == 3


def test_exponents_come_in_pairs_and_four_are_zero() -> None:
    """What is zero in the limit is some ``ln t / t`` at a time."""
    found = rigid.lyapunov(TOP, CHAOTIC, ATTITUDE, t=[2000.0], **ALL)
    assert found.zeros == 4
    assert found.spectrum[0, 0] > 0.25
    np.testing.assert_allclose(found.spectrum[0, 1:5], 0.0, atol=3.0 * np.log(2000.0) / 2000.0)
    assert (present(found.pairing) < 3.0 * np.log(2000.0) / 2000.0).all()
    others = rigid.lyapunov(TOP, CHAOTIC, ATTITUDE, t=[2000.0], exponents=5, check=False)
    assert others.zeros == 3
    assert others.spectrum[0, 0] == pytest.approx(found.spectrum[0, 0], abs=0.02)


@pytest.mark.parametrize(("scene", "zeros"), [(BOX, (5, 6)), (TOP, (3, 4))])
def test_zeros_known_from_theory(scene: Scene, zeros: tuple[int, int]) -> None:
    for of, number in zip(("rates", "attitude"), zeros, strict=True):
        assert rigid.lyapunov(scene, CHAOTIC, t=[5.0], of=of, check=False).zeros == number


@pytest.mark.parametrize(
    ("of", "torque"), [("attitude", [0.1, -0.2, 0.15]), ("rates", [0.0, 0.0, 0.15])]
)
def test_growth_under_a_torque_in_space(of: str, torque: list[float]) -> None:
    """The rotation vector about the vertical counts where the torque turns with it."""
    pushed = rigid.FreeBody(BOX.body, torque=rigid.Torque.space(torque))
    times, start = np.array([1.0, 5.0, 20.0]), np.array([0.3, -0.2, 0.5, 0.1, 0.4, -0.3])
    run = rigid.simulate(pushed, CHAOTIC, ATTITUDE, t=times, tangent=True, check=False)
    found = rigid.lyapunov(pushed, CHAOTIC, ATTITUDE, t=times, of=of, start=start)
    sizes = []
    for matrix, attitude in zip(
        [np.eye(6), *present(run.tangent)], [ATTITUDE, *present(run.attitude)], strict=True
    ):
        rates, turn = (matrix @ start)[:3] / np.linalg.norm(CHAOTIC), (matrix @ start)[3:]
        seen = turn if of == "attitude" else np.cross(gamma_of(np.array([attitude]))[0], turn)
        sizes.append(np.hypot(np.linalg.norm(rates), np.linalg.norm(seen)))
    true = np.log(np.array(sizes[1:]) / sizes[0])
    np.testing.assert_allclose(found.log_growth, true, rtol=0.0, atol=1e-11)


def test_the_size_of_the_rates_is_refused_where_turns_about_the_vertical_change_them() -> None:
    """The logarithm of growth was off by up to 4, and by up to 550 times what was stated."""
    pushed = rigid.FreeBody(BOX.body, torque=rigid.Torque.space([0.1, 0.0, 0.15]))
    words = "of = 'rates': the rates do not see turns about the vertical, which matter"
    with pytest.raises(ValueError, match=words):
        rigid.lyapunov(pushed, CHAOTIC, t=[1.0], of="rates")
    assert rigid.lyapunov(pushed, CHAOTIC, t=[1.0]).spec["of"] == "attitude"
    options: dict[str, Any] = {"axes": {"spin": [1.0]}, "samples": 2, "t_end": 1.0, "rng": 1}
    with pytest.raises(ValueError, match=words):
        rigid.stability_map(pushed, stable=rigid.regular("rates"), **options)
    named, usual = (
        rigid.stability_map(pushed, stable=rigid.regular(of), **options)
        for of in ("attitude", None)
    )
    assert str(named.spec.stable) == str(usual.spec.stable)


@pytest.mark.parametrize("method", ["splitting", "splitting4", "splitting8"])
def test_exponents_of_splittings_add_up_to_zero_at_any_step(method: str) -> None:
    """Their steps keep volumes, whether or not they follow the motion."""
    for step in (0.02, 0.3):
        options = {"t": [5.0, 60.0], "method": method, "step": step, **ALL}
        found = rigid.lyapunov(TOP, CHAOTIC, ATTITUDE, **options)
        assert (np.abs((found.spectrum * found.t[:, None]).sum(axis=1)) < 1e-11).all()


UNDAMPED = [case for case in DEVIATING if not case.scene.forces]


@pytest.mark.parametrize("case", UNDAMPED, ids=lambda case: case.name)
def test_growth_by_splittings(case: Deviating) -> None:
    """Of any body without damping: the error is that of the steps, and the estimate is above it."""
    found = rigid.lyapunov(
        case.scene, case.omega, case.attitude, t=case.t, start=case.tangents[0], method="splitting8"
    )
    true = case.growth["rates"]
    assert (np.abs(found.log_growth - true["log_growth"]) <= found.error + 1e-9).all()
    np.testing.assert_allclose(found.mean_megno, true["mean_megno"], rtol=0.0, atol=1e-2)


# --- Verdicts ------------------------------------------------------------------------------------


def integrable(kind: str, count: int) -> tuple[Scene, Floats, Floats]:
    """Random starts of a family whose motions are all regular, off its separatrices."""
    rng = np.random.default_rng(20261122)
    omega, attitude = rng.normal(size=(count, 3)), rng.normal(size=(count, 4))
    attitude /= np.linalg.norm(attitude, axis=1, keepdims=True)
    if kind == "euler":
        return BOX, omega, attitude
    if kind == "lagrange":
        return rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0), omega, attitude
    if kind == "kovalevskaya":
        body = rigid.Body((2.0, 2.0, 1.0))
        return rigid.HeavyTop(body, mgl=1.0, com=(1.0, 0.0, 0.0)), omega, attitude
    # Goryachev-Chaplygin: no momentum about the vertical.
    moments = np.array([4.0, 4.0, 1.0])
    weighed = moments * gamma_of(attitude)
    omega -= weighed * ((omega * weighed).sum(axis=1) / (weighed**2).sum(axis=1))[:, None]
    return rigid.HeavyTop(rigid.Body(moments), mgl=1.0, com=(1.0, 0.0, 0.0)), omega, attitude


@pytest.mark.parametrize(
    ("kind", "undecided"),
    [("euler", 0.002), ("lagrange", 0.002), ("kovalevskaya", 0.01), ("goryachev-chaplygin", 0.01)],
)
def test_no_integrable_motion_is_called_chaotic(kind: str, undecided: float) -> None:
    scene, omega, attitude = integrable(kind, 256)
    verdict = rigid.lyapunov(scene, omega, attitude, t=[100.0]).verdict
    assert not (verdict == "chaotic").any()
    # Three standard deviations above the share of many.
    assert (verdict == "undecided").sum() <= 256 * undecided + 3.0 * np.sqrt(256 * undecided) + 1.0


@pytest.mark.parametrize("kind", ["middle axis", "upright"])
def test_what_is_integrable_is_undecided_beside_a_separatrix_and_never_chaotic(kind: str) -> None:
    """For ``ln(1 / distance)`` over the exponent deviation vectors grow like those of chaos."""
    rng = np.random.default_rng(30)
    away = 10.0 ** rng.uniform(-9.0, -3.0, (60, 1)) * rng.normal(size=(60, 3))
    scene: Scene = BOX
    omega, attitude = away + np.array([0.0, 1.5, 0.0]), np.array(ATTITUDE)
    if kind == "upright":
        scene = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)
        omega, attitude = away + np.array([0.0, 0.0, 1.5]), np.array([1.0, 0.0, 0.0, 0.0])
    found = rigid.lyapunov(scene, omega, attitude, t=[30.0])
    assert set(found.verdict.tolist()) <= {"regular", "undecided"}
    grown = (found.log_growth[:, -1] > 12.0) & (found.mean_megno[:, -1] > 5.0)
    assert grown.sum() > 5
    assert (found.verdict[grown] == "undecided").all()
    # Under a torque nothing is known by theorem.
    driven = rigid.FreeBody(BOX.body, torque=rigid.Torque.body([1e-12, 0.0, 0.0]))
    assert (rigid.lyapunov(driven, [0.0, 1.5, 0.0], t=[30.0]).verdict) == "chaotic"


def test_regular_motions_may_have_grown_faster_than_what_their_horizon_shows() -> None:
    """The exponent of a finite time keeps what a deviation vector grew beside a separatrix."""
    top = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)
    omega = [[away, 0.0, 1.5] for away in np.geomspace(1e-7, 1e-5, 16)]
    found = rigid.lyapunov(top, omega, t=[400.0])
    regular = found.verdict == "regular"
    assert regular.sum() > 12
    assert (found.exponent[regular, -1] > found.resolution).sum() > 2
    words = found.reasons()[int(np.flatnonzero(regular)[0])]
    assert words.startswith("regular: no growth like exp(k t) with k above 0.025 1/s")


def test_deviations_of_a_verdict_keep_the_momentum_about_the_vertical() -> None:
    """The derivative of ``I w · gamma`` along them, by central differences, is zero."""
    scene, omega, attitude = integrable("kovalevskaya", 64)
    bodies = bodies_of(scene, omega, attitude)
    unit = np.sqrt((omega**2).sum(axis=1) + 1.0)

    def momentum(deviation: Floats) -> Floats:
        turned = Rotation.from_quat(attitude, scalar_first=True) * Rotation.from_rotvec(
            deviation[:, 3:]
        )
        gamma = turned.inv().apply([0.0, 0.0, 1.0])
        moments = np.array(scene.body.moments)
        total: Floats = (moments * (omega + deviation[:, :3]) * gamma).sum(axis=1)
        return total

    starts = _core.deviation_starts(bodies)
    others = np.tile(_core.generic_deviations()[0], (64, 1))
    others[:, :3] *= unit[:, None]
    kept, also_kept, changed = (
        np.abs(momentum(1e-5 * along) - momentum(-1e-5 * along)) / 2e-5 / unit
        for along in (starts[:, 0], starts[:, 1], others)
    )
    # Truncation is 1e-10, rounding 2^-53 / 1e-5, each times some units.
    assert kept.max() < 1e-9
    assert also_kept.max() < 1e-9
    assert np.median(changed) > 0.1


def test_resonances_of_a_goryachev_chaplygin_top_are_quadratic_in_the_time_off_its_level() -> None:
    """A mean MEGNO of 4 where the motion changes with ``L·gamma``, and of 2 where it may not."""
    scene, omega, attitude = integrable("goryachev-chaplygin", 128)
    generic = _core.generic_deviations()[0]
    kept, changed = (
        rigid.lyapunov(scene, omega, attitude, t=[400.0], start=start, check=False)
        for start in (None, generic)
    )
    assert (kept.mean_megno < 3.0).all()
    assert (changed.mean_megno > 3.0).mean() > 0.02
    assert changed.mean_megno.max() < 5.0


def test_verdicts_on_a_chaotic_sea_and_on_islands() -> None:
    found = rigid.lyapunov(TOP, [CHAOTIC, REGULAR], ATTITUDE, t=[100.0, 400.0])
    assert found.verdict.tolist() == ["chaotic", "regular"]
    assert found.resolution == 0.025
    assert found.exponent[0, -1] > 0.2 > found.resolution > found.exponent[1, -1]
    assert found.lost_from[0] < 200.0
    assert np.isinf(found.lost_from[1])
    assert found.error[1] < 1e-10
    chaotic, regular = found.reasons()
    assert 0.2 < found.exponent[0, -1] < 0.4
    assert chaotic.startswith(f"chaotic: exponent {found.exponent[0, -1]:.3g}")
    assert "the motion itself is lost from t = " in chaotic
    assert regular.startswith(
        "regular: no growth like exp(k t) with k above 0.025 1/s until t = 400 s"
    )


def test_a_body_that_is_not_run_has_failed() -> None:
    found = rigid.lyapunov(TOP, [CHAOTIC, REGULAR], t=[100.0], max_steps=1000)
    assert found.verdict.tolist() == ["chaotic", "failed"]
    assert found.status.tolist()[1] == rigid.Status.STEP_LIMIT
    assert np.isnan(found.log_growth[1]).all()
    assert found.reasons()[1].startswith("failed: step limit")


# --- Interface -----------------------------------------------------------------------------------


def test_the_first_exponent_has_the_same_bits_beside_others() -> None:
    omega = np.random.default_rng(5).normal(size=(70, 3))
    one, two, four = (
        rigid.lyapunov(TOP, omega, ATTITUDE, exponents=count, t=[5.0, 30.0], check=False)
        for count in (1, 2, 4)
    )
    for name in ("log_growth", "megno", "mean_megno", "fli"):
        assert getattr(four, name).tobytes() == getattr(one, name).tobytes(), name
    assert two.log_growth.shape == (70, 2)
    assert present(two.gali).shape == (70, 2, 1)
    assert one.sali is None


def test_a_long_horizon_overflows_nothing() -> None:
    found = rigid.lyapunov(TOP, CHAOTIC, ATTITUDE, t=[5000.0], exponents=2, check=False)
    assert found.log_growth[0] > 1000.0
    assert np.isfinite(found.mean_megno).all()
    assert present(found.sali)[0] == 0.0


test_bad_arguments_are_refused_by_name = refuses(
    [
        ({"of": "speed"}, "of = 'speed': must be one of 'rates', 'attitude'"),
        ({"exponents": 6}, "exponents = 6: must be at most 5 for of = 'rates'"),
        ({"exponents": 7, "of": "attitude"}, "exponents = 7: must be at most 6"),
        ({"t": [0.0, 1.0]}, "t = 0.0: must be positive times"),
        ({"t": []}, r"t = \[\]: must be positive times"),
        ({"t": [2.0, 1.0]}, "times must be ascending"),
        ({"method": "exact"}, "method = 'exact': deviation vectors are integrated"),
        ({"method": "dmv10"}, "method = 'dmv10': has no tangent"),
        *(
            ({"start": start}, "start: a deviation vector of body 0 has no size by of = 'rates'")
            for start in ([0.0] * 6, [0.0] * 5 + [1.0])
        ),
        ({"start": np.ones((2, 6)), "exponents": 2}, "start: .* depend on each other"),
        ({"start": np.ones(5)}, r"start: expected shape \(1, 6\)"),
        ({"start": np.full(6, np.nan)}, "start"),
    ],
    by=lambda options: rigid.lyapunov(TOP, CHAOTIC, **{"t": [1.0], **options}),
)


@pytest.mark.filterwarnings("error")
def test_rates_whose_square_overflows_fail_without_a_warning() -> None:
    growth = rigid.lyapunov(TOP, [1e200, 1.0, 1.0], t=[1.0], max_steps=1000)
    assert growth.verdict == "failed"
    points = rigid.poincare(TOP, [1e200, 1.0, 1.0], t_end=1.0, max_steps=1000)
    assert points.status != rigid.Status.OK
    assert not bool(points.complete)


# --- Lyapunov times -------------------------------------------------------------------------------


def test_the_error_of_parts_is_the_scatter_of_an_ensemble() -> None:
    """64 neighbours in one chaotic zone are independent after some hundred Lyapunov times.

    Their standard deviation is known to 1/sqrt(2 63) = 9 %, that of seven parts to 27 % of each
    body, and to 4 % of all: three of both together are a third.
    """
    near = np.array(ATTITUDE) + 1e-6 * np.random.default_rng(1).normal(size=(64, 4))
    growth = rigid.lyapunov(TOP, CHAOTIC, near, t=np.linspace(100.0, 1600.0, 16))
    assert (growth.verdict == "chaotic").all()
    found, exponent = growth.lyapunov_time(), growth.exponent[:, -1]
    np.testing.assert_allclose(found.time, 1.0 / exponent, rtol=1e-14)
    # The error of one over a number is the error of the number over its square.
    errors = found.error * exponent**2
    ratio = np.sqrt(np.mean(errors**2)) / exponent.std(ddof=1)
    assert 0.67 < ratio < 1.5


@pytest.mark.parametrize("parts", [4, 8])
def test_the_error_of_equal_parts_is_that_of_a_mean(parts: int) -> None:
    growth = rigid.lyapunov(TOP, CHAOTIC, ATTITUDE, t=np.linspace(50.0, 400.0, 8))
    log = np.concatenate([[0.0], growth.log_growth])[:: 8 // parts]
    exponents = np.diff(log) / (400.0 / parts)
    expected = exponents.std(ddof=1) / np.sqrt(parts) / exponents.mean() ** 2
    found = growth.lyapunov_time(parts)
    np.testing.assert_allclose(found.time, 1.0 / exponents.mean(), rtol=1e-14)
    np.testing.assert_allclose(found.error, expected, rtol=1e-12)


def test_regular_motions_have_no_lyapunov_time() -> None:
    """A box far from its separatrix is regular, one beside it neither."""
    rates = [[1.0, 0.1, 0.1], [1e-12, 1.0, 0.0]]
    growth = rigid.lyapunov(BOX, rates, t=np.linspace(5.0, 40.0, 8))
    assert growth.verdict.tolist() == ["regular", "undecided"]
    found = growth.lyapunov_time()
    assert np.isinf(found.time[0])
    assert np.isnan(found.time[1])
    assert np.isnan(found.error).all()
    words = growth.reasons()[1]
    assert words.startswith("undecided until t = 40 s; the mean MEGNO is ")
    assert words.endswith("; take a longer time")


def test_growth_has_no_error_once_the_motion_is_lost() -> None:
    """Until then it is that of the same run to an earlier time; after it none is stated."""
    times = np.array([20.0, 40.0, 60.0, 400.0, 600.0])
    whole = rigid.lyapunov(TOP, CHAOTIC, ATTITUDE, t=times, step=0.05)
    assert 60.0 < whole.lost_from < 400.0
    assert whole.error < 1e-3
    again = rigid.lyapunov(TOP, CHAOTIC, ATTITUDE, t=times, step=0.03, method="taylor20")
    apart = np.abs(whole.log_growth - again.log_growth)
    assert (apart[:3] <= whole.error + again.error).all()
    assert apart[-1] > 0.1  # two motions, whose growth differs by chance
    late = rigid.lyapunov(TOP, CHAOTIC, ATTITUDE, t=[400.0, 600.0], step=0.05)
    assert np.isnan(late.error)


def test_parts_need_times() -> None:
    growth = rigid.lyapunov(TOP, CHAOTIC, ATTITUDE, t=[100.0, 200.0])
    with pytest.raises(ValueError, match="parts = 8: the run has 2 times"):
        growth.lyapunov_time()
    with pytest.raises(ValueError, match="parts = 3: must be"):
        growth.lyapunov_time(3)
    with pytest.raises(ValueError, match=r"t = \[1\.0\]: a plot needs two times or more"):
        rigid.lyapunov(BOX, CHAOTIC, t=[1.0]).plot()
