"""What a run says of its error is true, on runs that are hard on it; the truth is in 128 bits.

``tests/long/stated_errors.py`` takes thousands.
"""

import json
from collections import Counter
from fractions import Fraction
from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import quad_motion
import rigid
import stiff_motion
from adversarial import KINDS, Case
from judged_subjects import SUBJECTS
from physics import GOLDEN, Floats, Golden, golden, present
from printed_equations import solved
from rigid.model.scene import Scene
from strong_damping import judge as judge_damped
from verdicts import JUDGED, judge, true_errors


@pytest.fixture(scope="module", autouse=True)
def _quad_numbers() -> None:
    if not quad_motion.is_available():
        pytest.skip("the C compiler has no 128-bit numbers")


def test_no_error_is_larger_than_what_is_said_of_it() -> None:
    for number in range(50):
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
    truth: Any = quad_motion.motion(scene, omega, attitude, t)
    run = rigid.simulate(scene, omega, attitude, t=t, method=method, accuracy=1e-10)
    assert not run.flagged
    assert truth.rates_off(run.omega).max() <= 1e-10
    assert truth.attitude_off(present(run.attitude)).max() <= 1e-10


@cache
def _motion(scene: Scene, *given: bytes) -> Any:
    """The motion from these rates and this attitude, at these times."""
    return quad_motion.motion(scene, *map(np.frombuffer, given))


def true_error(scene: Scene, run: rigid.Run, omega: Any, attitude: Any) -> float:
    """Of the rates relative to the fastest of them, of vertical and attitude in rad."""
    start = (np.array(given, dtype=np.float64).tobytes() for given in (omega, attitude))
    truth = _motion(scene, *start, run.t.tobytes())
    fastest = float(np.linalg.norm(truth.omega, axis=-1).max())
    off = [truth.rates_off(run.omega).max() / fastest]
    if run.gamma is not None:
        off.append(truth.gamma_off(run.gamma).max())
    if run.attitude is not None:
        off.append(truth.attitude_off(run.attitude).max())
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
    assert true_error(top, run, [0.0] * 3, attitude) > 0.1
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
    true = true_error(top, run, [0.0] * 3, attitude)
    assert true <= run.error
    assert 1e-16 / tilt < run.error < 1e-13 / tilt


def test_a_closed_form_states_the_rounding_of_a_hardly_swinging_top() -> None:
    top = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)
    for tilt in (1e-10, 1e-8, 1e-6):
        attitude = [0.6 * tilt, 0.8, 0.6, -0.5 * tilt]
        t = [0.0, 0.7, 1.9, 3.1]
        run = rigid.simulate(top, [0.0] * 3, attitude, t=t, method="exact")
        true = true_error(top, run, [0.0] * 3, attitude)
        assert true <= run.error < 1e-13 / tilt


def test_before_it_falls_rates_of_an_upright_top_are_rounding() -> None:
    """Its attitude is off by 1e-8 only, its rates of 1e-6 rad/s by as much."""
    moments = (0.08597682510395821, 0.8781086225285188, 0.8578477191142563)
    com = (-0.007360810662476623, -0.14793833313785243, -0.9889691946945491)
    top = rigid.HeavyTop(rigid.Body(moments), mgl=2.94892245958951, com=com)
    attitude = (0.0742657569322892, -0.9960063644994468, 0.04955723180191939, 1.8e-15)
    t = [-3.6, -1.8, 1.5, 3.5]
    run = rigid.simulate(top, [0.0] * 3, attitude, t=t, method="taylor20", step=0.075)
    true = true_error(top, run, [0.0] * 3, attitude)
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
        assert true_error(top, run, omega, attitude) <= run.error


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
    truth: Any = quad_motion.motion(top, [0.0] * 3, attitude, t)
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
            true = true_error(free, run, [0.0, 0.0, 1.0], attitude)
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
        true = true_error(free, run, omega, [1.0, 0.0, 0.0, 0.0])
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
        assert true_error(top, run, omega, attitude) <= run.error


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
@pytest.mark.parametrize(
    ("kind", "few", "unit"), [({}, 2, 1e-24), (quad_motion.FAST, 4, 1e-17)], ids=["128", "80 bits"]
)
def test_the_truth_is_that_of_the_reference_trajectories(
    case: Golden, kind: Any, few: int, unit: float
) -> None:
    """To all 25 digits that these have, or to 80 bits, times the conditioning of the motion."""
    document = _document(case)
    given = case.scene, case.omega0, case.attitude0, case.t[:few]
    truth = quad_motion.motion(*given, limit=2000, **kind)
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
        # Half a unit of the 25th digit, and some roundings of these numbers.
        allowed = unit * growth
        assert float(max(rates) / fastest) <= allowed
        assert float(max(components)) <= allowed


# What a run says of its error is true where damping ends some rates at once and others slowly


def case(moments: Any, damping: Any, omega: Any, t: Any, **options: Any) -> Case:
    scene = rigid.FreeBody(rigid.Body(moments), damping=damping)
    upright = np.array([1.0, 0.0, 0.0, 0.0])
    return Case("damped", scene, np.array(omega), upright, np.array(t), options)


#: Nearly singular matrices: while the fast rates end, the slow one turns the body by a radian.
LAYERS = {
    "two times": case(
        (0.7723251553356494, 1.5040861659575544, 0.9026996853898018),
        [
            [309.25454043108954, 423.59983134937397, -172.91099802925422],
            [423.59983134937397, 1922.598771165088, -349.41640421887837],
            [-172.91099802925422, -349.41640421887837, 107.83386503590341],
        ],
        [1.07928097945697, 0.0, 0.0],
        [0.45914278197532227, 2.7991823127361806],
    ),
    "one undamped direction": case(
        (1.0, 1.0, 0.14389358244923742),
        [
            [27.362880803551846, -27.710823023043083, 1.657197520978254],
            [-27.710823023043083, 35.88382719025225, 12.659952744126633],
            [1.657197520978254, 12.659952744126633, 40.69353112541327],
        ],
        [0.0, 0.0, 0.48208103116157425],
        [8.635742026598802],
    ),
    "a given accuracy": case(
        (0.4439704850288112, 0.9045757936294382, 1.2075108217627957),
        [
            [280.5631096846059, -53.05573435835372, 210.49581210466727],
            [-53.05573435835372, 336.62722772680604, 164.5604628071044],
            [210.49581210466727, 164.5604628071044, 285.9220895634355],
        ],
        [0.0, 2.2580019794235464, 0.0],
        [6.452073302889339, 8.480305243155309, 12.623809798120963, 16.56864808683995],
        method="etd4",
        accuracy=2.8730975771968227e-4,
    ),
    "40000 damping times": case(
        (0.8434667207272508, 1.142998180503973, 1.311395894522842),
        [
            [28949.900775246657, 2173.8893705839027, 8080.53867069897],
            [2173.8893705839027, 15317.272571947622, 922.5183224386078],
            [8080.53867069897, 922.5183224386078, 19621.812155119846],
        ],
        [6.113737387286868, 0.0, 0.0],
        [1.0355132068328998],
        method="etd4",
    ),
}


def test_the_truth_agrees_with_a_series_in_128_bits() -> None:
    layer = LAYERS["two times"]
    acting: dict[str, Any] = {"damping": (8.0, 3.0, 0.1), "com": (0.0, 0.6, 0.8)}
    acting["torque"] = rigid.Torque.body((0.3, -0.2, 0.5))
    top = rigid.HeavyTop(rigid.Body((1.0, 1.6, 0.8)), mgl=2.0, **acting)
    for scene, omega, attitude, t in (
        (layer.scene, layer.omega, layer.attitude, layer.t),
        (top, [0.4, 1.0, -0.3], [0.5, -0.3, 0.7, 0.4], [0.5, 4.0]),
    ):
        truth: Any = stiff_motion.motion(scene, omega, attitude, t)
        series: Any = quad_motion.motion(scene, omega, attitude, t, limit=20000)
        # The collocation keeps about the square of its tolerance of 1e-12, in numbers of 1e-19.
        np.testing.assert_allclose(truth.high[:, :7], series.high[:, :7], rtol=0.0, atol=1e-15)


@pytest.mark.parametrize("name", LAYERS)
def test_a_layer_shorter_than_a_step_turns_the_body_by_what_is_stated(name: str) -> None:
    layer = LAYERS[name]
    run, row = layer.run()
    truth = stiff_motion.motion(layer.scene, layer.omega, layer.attitude, layer.t)
    assert truth is not None
    assert run.status in JUDGED
    stated = max(float(run.error), layer.options.get("accuracy", 0.0))
    assert true_errors(layer, run, row, truth).max() <= stated


def test_random_matrices_of_strong_damping_have_true_errors() -> None:
    found = [judge_damped(number, seed=20) for number in range(30)]
    claimed = [one for one in found if one is not None and one.is_claimed]
    assert len(claimed) > 20
    assert all(one.excess <= 1.0 for one in claimed)


# What a run says of its error is true under drag, rotors, sinks, orbits, tables and functions


def called(t: float, w: Floats, matrix: Floats) -> Floats:
    """What ``quad_motion.called()`` computes of NUMBERS."""
    push, varying, cubic, dipole, field = np.split(np.array(NUMBERS), [3, 4, 7, 10])
    acting: Floats = push * np.cos(varying * t) - cubic * w**3 + np.cross(dipole, matrix.T @ field)
    return acting


BODY = rigid.Body((1.0, 1.6, 0.8))
NUMBERS = (0.3, -0.2, 0.1, 1.7, 0.1, 0.2, 0.05, 0.4, 0.1, -0.3, 0.2, 0.5, -0.1)


def _scenes() -> dict[str, Scene]:
    function = rigid.Torque.call(quad_motion.called(), NUMBERS, fastest=10.0)
    return {
        "drag": rigid.FreeBody(BODY, drag=(0.1, 0.3, 0.0)),
        "drag of a top": rigid.HeavyTop(BODY, mgl=1.0, com=(0.0, 0.6, 0.8), drag=0.2),
        "pendulum": rigid.HeavyTop(BODY, mgl=1.0, com=(0.0, 1.0, 0.0), drag=0.2),
        "function": rigid.FreeBody(BODY, torque=function),
    }


@pytest.mark.parametrize("name", ["drag", "drag of a top", "pendulum", "function"])
def test_the_truth_agrees_with_a_fine_integration_of_the_printed_equations(name: str) -> None:
    scene, times = _scenes()[name], np.linspace(0.5, 8.0, 6)
    plane = name == "pendulum"
    omega = np.zeros(3) if plane else np.array([0.4, 1.0, -0.3])
    attitude = np.array([0.8, 0.6, 0.0, 0.0]) if plane else np.array([0.5, -0.3, 0.7, 0.4])
    truth: Any = quad_motion.motion(scene, omega, attitude, times)
    acting = called if name == "function" else None
    rates, matrices = solved(scene, omega, attitude, times, acting)
    # DOP853 keeps 1e-13 in each of some hundred steps.
    assert np.abs(truth.omega - rates).max() < 2e-12
    quaternions = Rotation.from_quat(truth.high[:, 3:7], scalar_first=True)
    assert np.abs(quaternions.as_matrix() - matrices).max() < 2e-12


# Drag that stops a body


ENDS = np.arange(7.5, 14.0)


@cache
def swings() -> list[tuple[rigid.HeavyTop, Floats, quad_motion.Motion]]:
    """Pendulums with drag, their attitudes at the start, and their true states at the ends."""
    made = []
    for mgl in (0.3, 2.0):
        for drag in (0.05, 0.4):
            for tilt in (0.5, 2.5):
                top = rigid.HeavyTop(BODY, mgl=mgl, com=(0.0, 1.0, 0.0), drag=drag)
                attitude = np.array([np.cos(0.5 * tilt), np.sin(0.5 * tilt), 0.0, 0.0])
                truth = quad_motion.motion(top, [0.0] * 3, attitude, ENDS)
                assert truth is not None
                made.append((top, attitude, truth))
    return made


@pytest.mark.parametrize("method", [None, "dop853", "rk4", "taylor12", "taylor16", "taylor26"])
def test_a_pendulum_with_drag_stops_at_each_end_of_its_swing(method: str | None) -> None:
    """There the speed |omega| has a corner: a series continues with the wrong sign of the drag."""
    for top, attitude, truth in swings():
        for row, end in enumerate(ENDS):
            run = rigid.simulate(top, [0.0] * 3, attitude, t=[end], method=method)
            state = quad_motion.Motion(truth.high[row : row + 1], truth.low[row : row + 1])
            true = float(state.rates_off(run.omega)[0] / np.linalg.norm(state.omega))
            true = max(true, float(state.attitude_off(present(run.attitude))[0]))
            assert true <= run.error or run.status not in (rigid.Status.OK, rigid.Status.COARSE)


@pytest.mark.parametrize("tolerance", [1e-6, 1e-9, 1e-12])
def test_steps_by_a_tolerance_do_not_pass_a_stop_unseen(tolerance: float) -> None:
    torque = rigid.Torque.body((-0.4, 0.0, 0.0))
    scene = rigid.FreeBody(BODY, drag=0.3, torque=torque)
    for end in np.linspace(1.5, 3.0, 11):
        options: dict[str, Any] = {"method": "taylor20", "tolerance": tolerance}
        run = rigid.simulate(scene, [1.0, 0.0, 0.0], t=[end], **options)
        if run.status in (rigid.Status.OK, rigid.Status.COARSE):
            assert true_error(scene, run, [1.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]) <= run.error


# Rounding that is alike in each step


STEADY: dict[str, tuple[Any, ...]] = {
    "almost a sphere with a sink": (
        (2.0 + 4e-15, 2.0 - 4e-15, 2.0),
        {"dissipation": rigid.EnergySink(0.0142)},
        (-0.0296, -0.0783, 0.0198),
        2834.0,
    ),
    "a spin about the axis of the least moment": (
        (0.9664545942669558, 0.10394517165269912, 0.9664545942669558),
        {"dissipation": rigid.EnergySink(0.001967613249548741)},
        (-1.6179383236877785e-08, 0.2505481514788074, 2.842437940406196e-08),
        783.0,
    ),
    "a symmetric gyrostat": (
        (0.11176810117658233, 0.11176810117658173, 0.06337886322194759),
        {"rotor": (0.007260231505677154, -0.01188827706446767, 0.004674141996392469)},
        (-0.12278561903031143, 0.20066394821834924, 0.19316122765204183),
        287.0,
    ),
}


@pytest.mark.parametrize("method", ["taylor12", "taylor16", "dop853"])
@pytest.mark.parametrize("name", STEADY)
def test_rounding_of_each_step_is_not_hidden_by_that_of_the_other_run(
    name: str, method: str
) -> None:
    moments, acting, omega, end = STEADY[name]
    scene = rigid.FreeBody(rigid.Body(moments), **acting)
    attitude = [0.3, -0.2, -0.1, 1.3]
    angle = float(np.linalg.norm(omega)) * end
    for steps in (2.5, 6.0, 40.0):
        step = end / (steps * angle)
        run = rigid.simulate(scene, omega, attitude, t=[end], method=method, step=step)
        assert true_error(scene, run, omega, attitude) <= run.error


def test_a_rotor_couples_the_rates_of_a_needle_more_closely_than_it_turns() -> None:
    """A nearly steady gyrostat: what steps lose of the slow rates moves the fast one."""
    needle = rigid.Body((0.06679393079630609, 1.9356673666703905e-08, 0.06679392524967576))
    wheel = (0.00305182261214021, 0.0011773741645351088, -0.002060064474771951)
    scene = rigid.FreeBody(needle, rotor=wheel)
    omega = [0.048738172103088714, 0.00909797363102408, -0.03289960812986399]
    attitude = [-0.10700776581902097, 0.019851236045032035, 1.3163374410028454, 0.6100993268009105]
    run = rigid.simulate(scene, omega, attitude, t=np.linspace(1e-4, 1e-3, 9), method="dop853")
    true = true_error(scene, run, omega, attitude)
    assert true <= run.error < 1e-10


# Steps and tolerances


def test_a_step_that_midpoint_divides_is_not_checked_by_its_parts() -> None:
    """Newton's method fails in the last step, which is made by quarters; so was its check."""
    needle = rigid.Body((0.1009440010458357, 1.059937203326533e-05, 0.10095006617204039))
    push = (-0.004195829647693644, -0.5849202694921044, -0.5646255601779495, 3.8008343763782158)
    cubic = (8.46147326183455e-05, 7.034292679063874e-05, 8.436424598841554e-05)
    dipole = (0.6839347003543198, -0.7248895872563402, -0.08227035880910767)
    field = (-0.02855402699111395, 0.02063327430064514, 0.029700833361111584)
    numbers = [*push, *cubic, *dipole, *field]
    scene = rigid.FreeBody(needle, torque=rigid.Torque.call(quad_motion.called(), numbers))
    omega = [0.0, 0.0, 2.435174521052942]
    attitude = [1.0444769234010371, -0.5462355477141051, -0.06717731117860552, -0.41255362991169653]
    t = [7.289629827673585e-05, 0.0063409968997836215]
    run = rigid.simulate(scene, omega, attitude, t=t, method="midpoint", step=0.0067)
    assert run.status == rigid.Status.FLAGGED or true_error(scene, run, omega, attitude) < run.error


def test_short_midpoint_steps_with_a_function_keep_their_order() -> None:
    """Of each step no more than rounding remains unsolved: what remains would add up."""
    body = rigid.Body((0.8048410640769278, 0.8048410640769278, 0.1287856289190128))
    com = (0.365507345893554, 0.5439261858570715, 0.7553467312677195)
    push = (3.117170485207157e-05, 5.9583011907523526e-05, 1.4148471036108738e-05)
    cubic = (0.006042238935413087, 0.004321917198544746, 0.004836899694109336)
    dipole = (-0.7019338092594152, 0.6731868104831485, -0.23261222154068426)
    field = (-0.004592584247625178, -0.0004005385892071506, 0.015969991577588362)
    numbers = [*push, 0.01855481131667694, *cubic, *dipole, *field]
    torque = rigid.Torque.call(quad_motion.called(), numbers, fastest=10.0)
    top = rigid.HeavyTop(body, mgl=1.8228979671500962, com=com, torque=torque)
    omega, end = [0.0, 0.1052273657111239, 0.0], 0.6284786894562857
    attitude = [0.12625573285713065, 0.2804305477908753, 3.6066621535181835, 0.7931723555217911]
    off = []
    for steps in (5000, 20000):
        options: dict[str, Any] = {"method": "midpoint", "step": end / steps, "check": False}
        run = rigid.simulate(top, omega, attitude, t=[end], **options)
        off.append(true_error(top, run, omega, attitude))
    # 16 by the order, less what rounding of 20 000 steps leaves.
    assert off[0] < 2e-8
    assert off[1] < off[0] / 12.0


def test_the_work_of_strong_damping_converges_more_slowly_than_the_rates() -> None:
    moments, strength = (0.931648853337754, 0.931648853337754, 0.10856695840058495), 22507.2
    scene = rigid.FreeBody(rigid.Body(moments), damping=strength)
    omega = np.array([-0.9592172223327229, -0.04856543631989676, 0.00700584791946999])
    t = np.linspace(0.0, 1.15e-3, 6)
    for tolerance in (1e-13, 7e-14, 3e-14, 1e-14):
        options: dict[str, Any] = {"method": "taylor16", "tolerance": tolerance}
        run = rigid.simulate(scene, omega, t=t, **options)
        truth: Any = quad_motion.motion(scene, omega, [1.0, 0.0, 0.0, 0.0], t)
        # The rates never exceed those of the start with the energy about the least moment.
        energy = 0.5 * float(omega @ (np.array(moments) * omega))
        assert truth.work_off(present(run.work)).max() / energy <= run.error


# Random runs


FORCES = ("drag", "orbit", "rotor", "energy sink", "function", "table in body", "table in space")


@pytest.mark.parametrize("kind", FORCES)
def test_no_error_under_a_force_is_larger_than_what_is_said_of_it(kind: str) -> None:
    for number in range(8):
        found = judge(number, seed=3, kinds={kind: KINDS[kind]})
        assert found.verdict != "UNDETECTED", (found.true, found.stated, found.case.code())
        assert found.early < 1.0
        # A drift that is computed anew is rounded otherwise.
        assert found.unbalanced < 1e-15


# Growth, lines, tensors, meshes, frames, other times and steps beside truths of their own


COUNTS = {
    **dict.fromkeys(("growth", "other times", "throws"), 3),
    **dict.fromkeys(("drift of lines", "frames"), 6),
    **dict.fromkeys(("poinsot", "springs", "steps", "tables", "verdicts"), 8),
    "growth under torques in space": 12,
    **dict.fromkeys(("cones", "lines", "meshes", "statics", "tensors"), 20),
}


@pytest.mark.parametrize("subject", COUNTS)
def test_nothing_is_wrong_that_passes_for_right(subject: str) -> None:
    cases = [SUBJECTS[subject](number, 2026) for number in range(COUNTS[subject])]
    assert not [one for one in cases if one.verdict == "UNDETECTED"]
    found = Counter(one.verdict for one in cases)
    assert found["right"] >= len(cases) // 3 > 0, found  # most have a truth
