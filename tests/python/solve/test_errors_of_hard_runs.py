"""What a run says of its error is true, on runs that are hard on it; the truth is in 128 bits.

``tests/long/stated_errors.py`` takes thousands.
"""

from __future__ import annotations

import json
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

import quad_motion
import rigid
from physics import GOLDEN, Golden, golden, present
from verdicts import judge


@pytest.fixture(scope="module", autouse=True)
def _quad_numbers() -> None:
    if not quad_motion.is_available():
        pytest.skip("the C compiler has no 128-bit numbers")


RUNS, PER_TEST = 300, 50


@pytest.mark.parametrize("first", range(0, RUNS, PER_TEST))
def test_no_error_is_larger_than_what_is_said_of_it(first: int) -> None:
    for number in range(first, first + PER_TEST):
        found = judge(number, seed=2026)
        assert found.verdict != "UNDETECTED", (found.true, found.stated, found.case.code())


@pytest.mark.parametrize("ratio", [1e-12, 1e-9, 1e-6])
@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("method", ["exact", "taylor20"])
def test_a_needle_moves_as_it_must_whatever_its_ratio(ratio: float, axis: int, method: str) -> None:
    """Moments as far apart as those of a wire of a kilometre and a hair."""
    moments = np.roll([ratio, 1.0, 1.0 - 0.5 * ratio], axis)
    scene = rigid.FreeBody(rigid.Body(moments))
    omega, attitude = np.array([0.3, -0.7, 0.2]), np.array([0.1, 0.7, -0.5, 0.5])
    t = [0.0, 1.0, 10.0]
    truth = quad_motion.motion(scene, omega, attitude, t)
    assert truth is not None
    run = rigid.simulate(scene, omega, attitude, t=t, method=method, accuracy=1e-10)
    assert not run.flagged
    assert truth.rates_off(run.omega).max() <= 1e-10
    assert truth.attitude_off(present(run.attitude)).max() <= 1e-10


def _true_error(scene: Any, run: rigid.Run, omega: Any, attitude: Any, t: Any) -> float:
    """Of the rates relative to the fastest of them, of the attitude in rad."""
    truth = quad_motion.motion(scene, omega, attitude, t)
    assert truth is not None
    fastest = np.linalg.norm(truth.omega, axis=-1).max()
    off = [truth.rates_off(run.omega).max() / fastest]
    off.append(truth.attitude_off(present(run.attitude)).max())
    return float(max(off))


UPRIGHT: dict[str, tuple[Any, ...]] = {
    "any axis": (
        (0.807881845236999, 0.30249200820849054, 0.7543023089374729),
        (-0.8195363020795092, -0.36100075983146634, 0.4450153940876057),
        (0.8500045276607666, -0.2123522570079417, 0.4820776098304402, 0.0),
        "rk4",
    ),
    "nearly a sphere": (
        (2.000039221183751, 2.00008576251516, 1.999868190979242),
        (0.09994999955065213, -0.003951015524919034, 0.9949846164972332),
        (0.9987453670724168, -0.0019779894131076127, -0.05003777882025708, 0.0),
        "pmlf6",
    ),
}


@pytest.mark.parametrize("case", UPRIGHT)
def test_rounding_may_hide_that_an_upright_top_is_out_of_balance(case: str) -> None:
    """Its computed torque is zero to the bit, and both runs stay; the true top falls."""
    moments, com, attitude, method = UPRIGHT[case]
    top = rigid.HeavyTop(rigid.Body(moments), mgl=3.0, com=com)
    t = np.linspace(0.0, 10.0 * np.sqrt(max(moments) / 3.0), 12)
    run = rigid.simulate(top, [0.0] * 3, attitude, t=t, method=method)
    assert _true_error(top, run, [0.0] * 3, attitude, t) > 0.1
    assert run.status == rigid.Status.FLAGGED


@pytest.mark.parametrize("method", ["dop853", "taylor16", "splitting8"])
@pytest.mark.parametrize("tilt", [1e-9, 1e-7])
def test_rates_of_a_hardly_swinging_top_are_as_uncertain_as_its_rounded_attitude(
    method: str, tilt: float
) -> None:
    """It hangs from axis 1: its attitude, of order one, is rounded to 1e-16 of one, not of tilt."""
    top = rigid.HeavyTop(rigid.Body((0.4, 0.47, 0.45)), mgl=1.64, com=(1.0, 0.0, 0.0))
    hanging, turned = np.array([0.43, 0.56, 0.43, -0.56]), np.array([0.56, 0.43, -0.56, 0.43])
    attitude = hanging / np.linalg.norm(hanging) + tilt * turned
    t = [0.9, 1.1, 3.7]
    run = rigid.simulate(top, [0.0] * 3, attitude, t=t, method=method, accuracy=1e-11 / tilt**0.5)
    true = _true_error(top, run, [0.0] * 3, attitude, t)
    assert true <= run.error
    assert 1e-16 / tilt < run.error < 1e-13 / tilt


def test_a_closed_form_states_the_rounding_of_a_hardly_swinging_top() -> None:
    top = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)
    for tilt in (1e-10, 1e-8, 1e-6):
        attitude = [0.6 * tilt, 0.8, 0.6, -0.5 * tilt]
        t = [0.0, 0.7, 1.9, 3.1]
        run = rigid.simulate(top, [0.0] * 3, attitude, t=t, method="exact")
        true = _true_error(top, run, [0.0] * 3, attitude, t)
        assert true <= run.error < 1e-13 / tilt


def test_before_it_falls_rates_of_an_upright_top_are_rounding() -> None:
    """Its attitude is off by 1e-8 only, its rates of 1e-6 rad/s by as much."""
    moments = (0.08597682510395821, 0.8781086225285188, 0.8578477191142563)
    com = (-0.007360810662476623, -0.14793833313785243, -0.9889691946945491)
    top = rigid.HeavyTop(rigid.Body(moments), mgl=2.94892245958951, com=com)
    attitude = (0.0742657569322892, -0.9960063644994468, 0.04955723180191939, 1.8e-15)
    t = [-3.6, -1.8, 1.5, 3.5]
    run = rigid.simulate(top, [0.0] * 3, attitude, t=t, method="taylor20", step=0.075)
    true = _true_error(top, run, [0.0] * 3, attitude, t)
    assert 1e-3 < true <= run.error


def test_beside_a_homoclinic_motion_two_runs_do_not_share_the_rounding_of_the_start() -> None:
    """Whatever the steps, rounding of the start becomes 1e-6 to 1e-5."""
    body = rigid.Body((0.5662616256688837, 0.5662616256688837, 0.09912709458573413))
    top = rigid.HeavyTop(body, mgl=1.6618330721352346)
    omega, attitude = (
        [0.5133244760570262, 0.0, 0.0],
        [0.98871292028394, 0.149822432444553, 0.0, 0.0],
    )
    t = [9.08335470490905]
    for steps in range(330, 345):
        run = rigid.simulate(top, omega, attitude, t=t, method="dop853", step=1.0001 * t[0] / steps)
        assert _true_error(top, run, omega, attitude, t) <= run.error


def test_rates_that_nearly_vanish_are_not_compared_with_wrong_ones_alone() -> None:
    """The motion ends upright, the run swings back: relative to its own rates it errs by 0.8."""
    body = rigid.Body((1.57621968196454, 2.373628869915154, 2.531250838111608))
    top = rigid.HeavyTop(body, mgl=2.5708457114854286)
    attitude = [0.8062589552412132, 0.5915627583725563, 0.0, 0.0]
    options: dict[str, Any] = {"method": "taylor20", "tolerance": 0.00425626915335737}
    run = rigid.simulate(
        top, [-1.5109860493553477, 0.0, 0.0], attitude, t=[11.2387817569], **options
    )
    assert run.status == rigid.Status.FLAGGED


def test_two_runs_beside_a_homoclinic_motion_may_take_the_same_wrong_side() -> None:
    """The true top stays up; both runs, whose energy is off by the steps, swing round and agree."""
    top = rigid.HeavyTop(
        rigid.Body((0.6085388618873253, 0.6085388618873253, 1.028790035163062)),
        mgl=0.806274354317776,
    )
    omega = [-0.9097677230864774, 1.6408802352225318, 0.6901046871308326]
    attitude = [0.5794697782939804, 0.8149937276101732, 0.0, 0.0]
    options: dict[str, Any] = {"method": "splitting4", "step": 0.13492800675876057}
    run = rigid.simulate(top, omega, attitude, t=[24.392128624933154], **options)
    assert run.status == rigid.Status.FLAGGED


def test_a_run_is_lost_before_its_wrong_rates_are_as_large_as_later_ones() -> None:
    """Rates of 4e-11 rad/s: a tolerance of 5e-6 lets the top swing 1e5 times as far in the end."""
    body = rigid.Body((0.9121371037752618, 1.227795458970987, 1.4035695412372222))
    com = (-0.7746009835650522, -0.19327622856717505, 0.602194001739392)
    top = rigid.HeavyTop(body, mgl=1.7898373424226022, com=com)
    attitude = [-0.22253886959903724, 0.6444573553172039, 0.6211052391030578, 0.3864963785779514]
    t = np.geomspace(0.84, 246.0, 14)
    options: dict[str, Any] = {"method": "taylor12", "tolerance": 5.38982853434088e-06}
    run = rigid.simulate(top, [0.0] * 3, attitude, t=t, **options)
    truth = quad_motion.motion(top, [0.0] * 3, attitude, t)
    assert truth is not None
    off = truth.rates_off(run.omega) / np.linalg.norm(truth.omega, axis=-1).max()
    assert (off >= 1.0).any()
    assert np.all(off[t < run.lost_from] < 1.0)


def test_a_series_of_higher_order_does_not_err_like_the_run_that_it_checks() -> None:
    """A quarter of the tolerance left the check an error as large as that of the run."""
    free = rigid.FreeBody(rigid.Body((1.0, 1.0, 1.5725429858727238)))
    attitude = [1.442655726853607, -1.4157794617932007, -0.15259410988007058, -1.211236083494112]
    for tolerance in (1e-7, 1e-9, 1e-11):
        for end in (20.0, 60.0, 180.0):
            t = np.linspace(0.0, end, 4)
            options: dict[str, Any] = {"tolerance": tolerance, "method": "taylor12"}
            run = rigid.simulate(free, [0.0, 0.0, 1.0], attitude, t=t, **options)
            true = _true_error(free, run, [0.0, 0.0, 1.0], attitude, t)
            assert true <= run.error <= max(10.0 * true, 1e-13 * end)


@pytest.mark.parametrize("method", ["dmv10", "splitting8", "pmlf6"])
def test_equal_rotations_drift_in_one_direction(method: str) -> None:
    """The flow of a symmetric body is exact in each step: its error is rounding, always alike."""
    free = rigid.FreeBody(rigid.Body((1.0, 1.0, 1.7507614949137609)))
    omega = [9.99080298e-01, -5.53147092e-04, 1.72464093e-03]
    t, largest = [118.26243136711196], 0.0
    for steps in (2000, 2674, 4000, 8000):
        options: dict[str, Any] = {"method": method, "step": 1.0001 * t[0] / steps}
        run = rigid.simulate(free, omega, t=t, **options)
        true = _true_error(free, run, omega, [1.0, 0.0, 0.0, 0.0], t)
        assert true <= run.error
        largest = max(largest, true)
    assert largest > 1e-12


def test_few_steps_of_a_stiff_method_are_checked_by_many() -> None:
    """Its error is largest at four steps: three and six err alike."""
    rows = (
        (1155.755142463569, -106.54897650554865, -382.7203876884117),
        (-106.54897650554865, 885.6685627706772, 561.4903524012585),
        (-382.7203876884117, 561.4903524012585, 445.49909689481547),
    )
    body = rigid.Body((0.6068245496888323, 0.6068245496888323, 0.09873048749305069))
    com = (-0.14286307017297184, -0.7642070018307652, 0.6289497607389525)
    top = rigid.HeavyTop(body, mgl=4.637132828890266, com=com, damping=rows)
    omega = [0.09855184619920494, -0.12866628514937407, 0.05653979859878544]
    attitude = [0.49686893515310776, 1.3719775632944229, -0.7074860800457877, -2.20530313384639]
    t = [0.01908196592404546]
    for steps in (2, 3, 4, 6, 12, 24):
        options: dict[str, Any] = {"method": "etd4", "step": 1.0001 * t[0] / steps}
        run = rigid.simulate(top, omega, attitude, t=t, **options)
        assert _true_error(top, run, omega, attitude, t) <= run.error


FAMILIES = ("forced_damped", "free_symmetric", "lagrange", "kovalevskaya")
CASES = [case for family in FAMILIES for case in golden(family)]


def _document(case: Golden) -> dict[str, Any]:
    text = (GOLDEN / f"{case.id.split('/')[0]}.json").read_text()
    (found,) = (scene for scene in json.loads(text)["scenes"] if scene["id"] == case.id)
    return dict(found)


def _weight_is_exact(case: Golden, document: dict[str, Any]) -> bool:
    """Whether ``mass * gravity * com`` is a double: else another weight was read."""
    factor = Fraction(document["mass"]) * Fraction(document["gravity"])
    products = [factor * Fraction(component) for component in document["com"]]
    return products == [Fraction(component) for component in case.scene.weight.tolist()]


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.id)
def test_the_truth_is_that_of_the_reference_trajectories(case: Golden) -> None:
    """To all 25 digits that these have, times the conditioning of the motion."""
    document = _document(case)
    few = 4
    truth = quad_motion.motion(case.scene, case.omega0, case.attitude0, case.t[:few], limit=2000)
    if truth is None or not _weight_is_exact(case, document):
        pytest.skip("too many steps, or the weight is not a double")
    for row, sample in enumerate(document["samples"][:few]):
        x, y, z, w = map(Fraction, sample["q"])
        found = [Fraction(a) + Fraction(b) for a, b in zip(*truth.state(row), strict=True)]
        sign = 1 if found[3] * w + found[4] * x + found[5] * y + found[6] * z > 0 else -1
        rates = [abs(a - Fraction(b)) for a, b in zip(found[:3], sample["omega"], strict=True)]
        fastest = max(abs(Fraction(rate)) for rate in sample["omega"]) or 1
        components = [abs(a - sign * b) for a, b in zip(found[3:7], (w, x, y, z), strict=True)]
        growth = max(1.0, sample["kappa_att"] or 0.0, sample["kappa_omega"] or 0.0)
        # Half a unit of the 25th digit, and some roundings of 128-bit numbers.
        allowed = 1e-24 * growth
        assert float(max(rates) / fastest) <= allowed
        assert float(max(components)) <= allowed
