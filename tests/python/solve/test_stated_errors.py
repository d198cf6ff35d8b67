"""What a run says of its error where two runs could agree and both be wrong."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import ArrayLike

import rigid
from physics import METHODS, Floats, present, rotation_angle, tilted
from rigid import Status
from rigid.model.scene import Scene

TOP = rigid.HeavyTop(rigid.Body((1.0, 1.2, 0.5)), mgl=1.0, com=(0.6, 0.0, 0.8))


def errors(run: rigid.Run, truth: rigid.Run) -> Floats:
    """True error at each time: of the rates relative to the fastest, of the attitude in rad."""
    size = np.linalg.norm(truth.omega, axis=-1).max()
    rates = np.linalg.norm(run.omega - truth.omega, axis=-1) / size
    angles: Floats = rotation_angle(present(run.attitude), present(truth.attitude))
    largest: Floats = np.maximum(rates, angles)
    return largest


def both(
    scene: Scene, omega: Any, t: Any, attitude: Any = None, **options: Any
) -> tuple[rigid.Run, Floats]:
    """A run, and its true errors by a series of order 26."""
    run = rigid.simulate(scene, omega, attitude, t=t, **options)
    truth = rigid.simulate(scene, omega, attitude, t=t, method="taylor26", check=False)
    return run, errors(run, truth)


# The layer in which strong damping forgets the start

LAYER = rigid.FreeBody(
    rigid.Body((0.8, 1.7, 2.2)), damping=8000.0, torque=rigid.Torque.body((4e3, -3e3, 5e3))
)
EARLY = [1e-4, 1e-3, 0.01, 0.03, 0.1, 0.3]


@pytest.mark.parametrize("t", [EARLY, np.geomspace(1e-4, 0.3, 8)], ids=["decades", "geometric"])
@pytest.mark.parametrize("method", [None, "etd4", "splitting", "midpoint"])
def test_output_times_closer_than_a_step_do_not_hide_its_error(method: str | None, t: Any) -> None:
    run, true = both(LAYER, [3.0, -10.0, 1.0], t, method=method)
    assert true.max() > 1e-10
    assert true.max() <= run.error


def test_rates_that_ring_instead_of_decaying_are_flagged() -> None:
    """Damping ends the rates in 1e-6 s; 44 and 88 steps of the midpoint rule both keep them."""
    scene = rigid.FreeBody(rigid.Body((0.12, 0.1, 0.15)), damping=1e5)
    run = rigid.simulate(scene, [-1.8, -3.0, -0.7], t=[2.5], method="midpoint", step=0.057)
    assert np.linalg.norm(run.omega) > 1.0
    assert run.status == Status.FLAGGED
    fine = rigid.simulate(scene, [-1.8, -3.0, -0.7], t=[1e-5], method="midpoint", step=1e-7)
    assert fine.error < 1e-2


@pytest.mark.parametrize("t", [EARLY, np.geomspace(1e-4, 0.3, 8)], ids=["decades", "geometric"])
def test_the_whole_record_keeps_an_accuracy(t: Any) -> None:
    """The largest error is that of an early time."""
    run, true = both(LAYER, [3.0, -10.0, 1.0], t, accuracy=1e-8)
    assert run.plan.method == "etd4"
    assert run.status == Status.OK
    assert true.max() <= run.error <= 1e-8


@pytest.mark.parametrize("method", ["rk4", "dop853", "splitting", "taylor12", "chin4a", "pmlf4"])
def test_every_interval_is_checked_by_other_steps(method: str) -> None:
    """One to three steps lie between the output times: shorter steps must be more of them."""
    top = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)
    for steps in (0.9, 1.05, 1.9, 2.4):
        t = np.cumsum(np.full(12, 0.3 * steps))
        run = rigid.simulate(top, [0.4, 0.7, 2.0], tilted(0.6), t=t, method=method, step=0.3)
        true = errors(run, rigid.simulate(top, [0.4, 0.7, 2.0], tilted(0.6), t=t, method="exact"))
        assert true.max() <= run.error <= max(20.0 * true.max(), 1e-13)


# Steps that follow a tolerance


@pytest.mark.parametrize(
    ("method", "tolerance", "end"),
    [
        ("taylor12", 1e-2, 0.5),
        ("taylor12", 1e-3, 0.3),
        ("taylor12", 1e-6, 0.3),
        ("taylor20", 1e-3, 0.8),
        ("taylor26", 1e-3, 1.0),
    ],
)
def test_a_run_of_a_single_step_is_checked_by_another_series(
    method: str, tolerance: float, end: float
) -> None:
    start: Any = [0.1, 0.2, 2.0]
    run = rigid.simulate(TOP, start, t=[end], method=method, tolerance=tolerance)
    assert run.steps == 1
    truth = rigid.simulate(TOP, start, t=[end], method="taylor16", step=0.01)
    true = float(errors(run, truth).max())
    assert true > 1e-11
    assert true <= run.error


@pytest.mark.filterwarnings("ignore:torque = .* numba cannot compile it")
@pytest.mark.parametrize("check", [True, False])
def test_a_body_that_hit_the_step_limit_is_not_run_again(check: bool) -> None:
    calls: list[float] = []

    def look(t: float, omega: Any, attitude: Any, data: Any, torque: Any) -> None:
        calls.append(omega[2])
        torque[:] = 0.0

    scene = rigid.FreeBody(TOP.body, torque=rigid.Torque.call(look))
    options: dict[str, Any] = {"method": "dop853", "tolerance": 1e-12, "max_steps": 100}
    run = rigid.simulate(
        scene, [[0.1, 0.2, 2.0], [1.0, 2.0, 200.0]], t=[2.0], check=check, **options
    )
    assert run.status[1] == Status.STEP_LIMIT
    assert np.isnan(run.error[1])
    assert run.error[0] < 1e-9 if check else np.isnan(run.error[0])
    # A step has twelve stages, rejected ones included; the motion inside a step takes three more.
    assert sum(abs(rate) > 100.0 for rate in calls) < 15 * 2 * 100


# Saddles


def test_beside_a_homoclinic_motion_the_closed_form_says_what_rounding_becomes() -> None:
    """In 34-digit arithmetic the state at t = 25 is 3.9e-4 from that of the rounded start."""
    top = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=2.0)
    c = 1.0 - np.cos(1.0)
    start = [np.sqrt(4.0 * c - (c / np.sin(1.0)) ** 2), np.sin(1.0) / (2.0 - c), 2.0]
    run = rigid.simulate(top, start, tilted(1.0), t=[25.0], accuracy=1e-9)
    assert run.plan.method == "exact"
    assert run.error >= 3.9e-4
    assert run.status == Status.FLAGGED
    early = rigid.simulate(top, start, tilted(1.0), t=[5.0], accuracy=1e-9)
    assert early.status == Status.OK
    late = rigid.simulate(top, start, tilted(1.0), t=[100.0])
    assert late.status == Status.FLAGGED
    assert 20.0 < late.lost_from < 40.0
    assert "shorter steps do not help" in late.reasons()[0]


def test_far_from_a_saddle_a_closed_form_errs_by_rounding() -> None:
    top = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)
    run = rigid.simulate(top, [0.3, 0.2, 3.0], tilted(0.5), t=[100.0])
    assert run.status == Status.OK
    assert run.error < 1e-12


UPRIGHT = rigid.HeavyTop(rigid.Body((1.0, 1.3, 0.6)), mgl=1.0, com=(0.6, 0.0, 0.8))


@pytest.mark.parametrize("method", [None, "rk4", "dop853", "splitting8", "taylor20", "midpoint"])
@pytest.mark.parametrize("sign", [1.0, -1.0], ids=["hanging", "upright"])
def test_upright_to_rounding_a_top_is_lost_when_rounding_has_grown(
    sign: float, method: str | None
) -> None:
    """The centre of mass is upright as floats have it: it falls, nobody knows where to or when.

    It leaves the saddle at the rate sqrt(mgl/I), 0.877 to 1.08 1/s: rounding is 1 after 33 to 42 s.
    Relative to rates that are rounding themselves the error is 1 as soon as they are above 1e-13 of
    what the top can reach, after 6 s at the earliest.
    Hanging, the same start stays where it is.
    """
    half = 0.5 * np.arctan2(0.6, 0.8)
    attitude = np.array([np.cos(half), 0.0, -np.sin(half), 0.0])
    if sign > 0.0:
        attitude = np.array([np.sin(half), 0.0, np.cos(half), 0.0])
    t = np.linspace(0.0, 60.0, 31)
    run = rigid.simulate(UPRIGHT, [0.0] * 3, attitude, t=t, method=method)
    if sign > 0.0:
        assert run.status in (Status.OK, Status.COARSE)
        assert np.abs(run.omega).max() < 1e-14
    else:
        assert run.status == Status.FLAGGED
        assert 6.0 <= run.lost_from <= 44.0


def test_at_rest_upright_to_the_bit_a_top_stays() -> None:
    top = rigid.HeavyTop(rigid.Body((1.0, 1.3, 0.6)), mgl=1.0)
    for method in (None, "rk4", "taylor20"):
        run = rigid.simulate(top, [0.0] * 3, t=[100.0], method=method)
        assert run.status == Status.OK
        assert not run.omega.any()


@pytest.mark.parametrize("damping", [0.3, 30.0])
def test_damping_slows_the_fall_of_an_upright_top(damping: float) -> None:
    """The exponent is that of the damped saddle: 0.87 and 0.033 1/s about axis 2.

    Rounding is 1 after 41 s and after 1060 s.
    """
    top = rigid.HeavyTop(rigid.Body((1.3, 1.0, 0.6)), mgl=1.0, com=(0.6, 0.0, 0.8), damping=damping)
    half = 0.5 * np.arctan2(0.6, 0.8)
    attitude = [np.cos(half), 0.0, -np.sin(half), 0.0]
    exponent = np.sqrt(1.0 + 0.25 * damping**2) - 0.5 * damping
    fall = -np.log(6.7e-16) / exponent
    t = fall * np.array([0.5, 0.7, 0.9, 1.1])
    run = rigid.simulate(top, [0.0] * 3, attitude, t=t, method="taylor16")
    assert run.status == Status.FLAGGED
    assert 0.9 * fall <= run.lost_from <= 1.1 * fall


# Slow bodies, whole turns


@pytest.mark.parametrize(
    ("method", "accuracy"),
    [("dop853", 1e-8), ("splitting", 1e-5), ("rk4", None), ("splitting", None)],
)
@pytest.mark.parametrize("size", [1e-9, 1e-12])
def test_a_top_that_hardly_swings_is_compared_with_its_own_rates(
    method: str, accuracy: float | None, size: float
) -> None:
    """It could reach 2 rad/s; turned by 2e-9 rad it never exceeds 2e-9 rad/s."""
    top = rigid.HeavyTop(rigid.Body((1.0, 1.3, 0.6)), mgl=1.0)
    start = size * np.array([0.3, 0.2, 1.0])
    attitude = [size, 1.0, 0.3 * size, 0.0]
    t = np.linspace(0.0, 100.0, 14)
    run, true = both(top, start, t, attitude, method=method, accuracy=accuracy)
    assert true.max() > 1e-10
    assert true.max() <= run.error
    if accuracy is not None:
        assert run.error <= accuracy


def test_rates_that_have_decayed_to_rounding_are_those_of_a_body_at_rest() -> None:
    """Below 1e-13 of the fastest rate of a body only rounding is left."""
    top = rigid.HeavyTop(rigid.Body((1.0, 1.3, 0.6)), mgl=1.0, com=(0.6, 0.0, 0.8), damping=1.0)
    run = rigid.simulate(top, [0.3, 0.2, 1.0], t=[300.0], accuracy=1e-9)
    assert np.abs(run.omega).max() < 1e-15
    assert run.status == Status.OK


def test_a_step_longer_than_the_layer_ends_the_rates_as_the_damping_does() -> None:
    """A single step from the start would leave 1e-11 of the rates; the damping leaves 1e-15."""
    scene = rigid.FreeBody(rigid.Body((0.47, 1.03, 0.7)), damping=(872.0, 3352.0, 13.7))
    t = [1.77, 1.79, 1.81, 2.49, 2.79]
    run = rigid.simulate(scene, [0.58, -0.29, 0.49], t=t, method="etd4", step=1.0)
    assert np.abs(run.omega).max() < 1e-15
    assert run.status == Status.OK
    truth = rigid.simulate(scene, [0.58, -0.29, 0.49], t=t, method="taylor26", check=False)
    turned = rotation_angle(present(run.attitude), present(truth.attitude))
    assert turned.max() <= run.error


def test_two_runs_that_part_by_whole_turns_do_not_look_equal() -> None:
    """The midpoint rule turns by `2 atan(h omega/2)` a step: 8.7 rad less than 419.5 in the end."""
    tumbling = rigid.FreeBody(rigid.Body((1.0, 1.0, 1.5)))
    long = rigid.simulate(tumbling, [0.1, 0.2, 1.0], t=[3000.0], method="rk4", step=0.713)
    assert long.status == Status.FLAGGED
    wheel = rigid.FreeBody(rigid.Body((1.0, 1.0, 2.0)))
    times = [[0.0, 419.5], [0.0, 1.0], [0.0, 0.0], [200.0, 419.5]]
    options: dict[str, Any] = {"method": "midpoint", "step": 0.5}
    run = rigid.simulate(wheel, [[0.0, 0.0, 1.0]] * 4, t=times, **options)
    lost = [Status.FLAGGED, Status.COARSE, Status.OK, Status.FLAGGED]
    assert run.status.tolist() == lost
    assert run.error[2] == 0.0
    assert 0.0 < run.lost_from[0] < 60.0
    for body, t in enumerate(times):
        one = rigid.simulate(wheel, [0.0, 0.0, 1.0], t=t, **options)
        assert (run.error[body], run.lost_from[body]) == (one.error, one.lost_from)


def test_the_error_of_the_work_is_stated() -> None:
    """A torque against damping: in the end the rate is N/c in any run, and the work I (N/c)²/2."""
    scene = rigid.FreeBody(
        rigid.Body((2.0, 2.0, 2.0)), torque=rigid.Torque.body((0.0, 0.0, 3.0)), damping=2.0
    )
    run = rigid.simulate(scene, [0.0] * 3, t=[60.0], method="rk4", step=0.5, record="rates")
    assert abs(run.omega[0, 2] - 1.5) < 1e-12
    energy = 0.5 * 2.0 * 1.5**2
    off = abs(float(present(run.work)[0]) - energy) / energy
    assert 1e-6 < off <= run.error


@pytest.mark.parametrize("method", ["taylor12", "taylor20", "taylor26"])
def test_the_error_of_the_work_is_stated_by_tolerance(method: str) -> None:
    """A sphere under torque: w = N/D + (w0 - N/D) exp(-D t/I), and the work is the energy gained.

    The series of the power, of the squares of the rates, converge more slowly than those that the
    tolerance is about.
    """
    moment, damping, t = 0.8, 280.0, 0.25
    torque, omega = np.array([43.0, -18.0, -17.0]), np.array([1.97, 1.65, 0.69])
    sphere = rigid.Body((moment,) * 3)
    scene = rigid.FreeBody(sphere, torque=rigid.Torque.body(torque), damping=damping)
    late = torque / damping + (omega - torque / damping) * np.exp(-damping * t / moment)
    at_start, at_end = (0.5 * moment * np.sum(w**2) for w in (omega, late))
    for tolerance in (1e-3, 5e-5, 1e-6, 1e-8, 1e-10):
        run = rigid.simulate(scene, omega, t=[t], method=method, tolerance=tolerance)
        off = abs(float(present(run.work)[0]) - (at_end - at_start)) / at_start
        assert 1e-14 < off <= run.error


# Statuses


def test_no_body_speaks_for_another() -> None:
    """Body 7 is chaotic among 40 fast tops."""
    top = rigid.HeavyTop(rigid.Body((1.0, 1.6, 0.7)), mgl=1.2, com=(0.6, 0.0, 0.8))
    omega = np.tile([0.1, 0.2, 40.0], (40, 1)) + np.linspace(0.0, 0.1, 40)[:, None]
    omega[7] = [0.1, 0.0, 0.2]
    run = rigid.simulate(top, omega, tilted(0.3), t=[400.0], method="taylor16")
    assert np.flatnonzero(run.status != Status.OK).tolist() == [7]
    alone = rigid.simulate(top, omega[7], tilted(0.3), t=[400.0], method="taylor16")
    assert alone.status == run.status[7] == Status.FLAGGED
    assert (alone.error, alone.lost_from) == (run.error[7], run.lost_from[7])


def test_without_a_check_a_run_is_not_called_ok() -> None:
    run = rigid.simulate(TOP, [0.1, 0.2, 2.0], t=[1.0], check=False)
    assert run.status == Status.UNCHECKED
    assert run.reasons()[0] == "unchecked: its error was not estimated; leave out check=False"
    assert np.isnan(run.error)


def test_a_coarse_run_is_not_called_ok() -> None:
    run = rigid.simulate(TOP, [0.1, 0.2, 2.0], t=[20.0], method="rk4", step=0.3)
    assert 1e-3 < run.error < 1.0
    assert run.status == Status.COARSE
    assert run.reasons() == (
        f"coarse: the estimated error is {float(run.error):.1e}; end the run earlier or ask for an "
        "accuracy",
    )
    finer = rigid.simulate(TOP, [0.1, 0.2, 2.0], t=[20.0], method="rk4", step=0.05)
    assert finer.status == Status.OK
    asked = rigid.simulate(TOP, [0.1, 0.2, 2.0], t=[20.0], accuracy=1e-2)
    assert asked.status == Status.OK


def test_no_bodies_and_no_times_have_no_errors() -> None:
    for scene in (rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0), TOP):
        none = rigid.simulate(scene, np.zeros((0, 3)), t=[1.0, 2.0])
        assert none.error.shape == (0,)
        assert rigid.simulate(scene, [0.1, 0.2, 0.3], t=[]).error < 1e-14


# A closed form errs by a rounding for each radian turned, and says so


#: A ball: its rate is constant, so that the angle turned is known.
BALL = rigid.FreeBody(rigid.Body((2.0, 2.0, 2.0)))
OMEGA = np.array([1.0, -2.0, 2.0])
RATE, ROUNDING = 3.0, 1e-15

#: Each component of the rates is bounded by the energy.
BOUND = np.sqrt(3.0) * RATE


@pytest.mark.parametrize("t", [[0.0], [0.25], [1e3], [-7.0], [-40.0, 2.0], [1e3, 1e6]])
def test_the_error_is_a_rounding_for_each_radian(t: list[float]) -> None:
    run = rigid.simulate(BALL, OMEGA, t=t)
    span = max(t[-1], 0.0) - min(t[0], 0.0)
    assert run.error == pytest.approx(ROUNDING * (1.0 + BOUND * span), rel=1e-12, abs=0.0)
    assert run.lost_from == np.inf


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_after_so_many_radians_the_phase_is_lost(sign: float) -> None:
    run = rigid.simulate(BALL, OMEGA, t=np.sort(sign * np.array([1.0, 3e14])))
    assert run.error >= 1.0
    assert run.lost_from == pytest.approx(sign / (ROUNDING * BOUND), rel=1e-12)
    assert run.flagged


# What rounding leaves in a run and in its check alike is stated too


ALMOST_A_SPHERE = (2.0 + 3e-9, 2.0 + 1e-9, 2.0 + 2.5e-9)


@pytest.mark.parametrize("method", METHODS, ids=lambda method: method.name)
def test_rates_of_almost_a_sphere_lose_the_same_rounding_each_step(method: rigid.Method) -> None:
    """The closed form is the truth: it errs by 1e-15 for each radian."""
    free = rigid.FreeBody(rigid.Body(ALMOST_A_SPHERE))
    rng = np.random.default_rng(1)
    for _ in range(6):
        omega, attitude = rng.normal(size=3), rng.normal(size=4)
        omega /= np.linalg.norm(omega)
        t, step = [rng.uniform(100.0, 300.0)], 10.0 ** rng.uniform(-1.7, -1.0)
        run: Any = rigid.simulate(free, omega, attitude, t=t, method=method.name, step=step)
        truth: Any = rigid.simulate(free, omega, attitude, t=t, method="exact")
        assert rotation_angle(run.attitude, truth.attitude)[0] <= run.error + truth.error


def test_what_no_step_changes_is_lost_whatever_the_steps() -> None:
    """Damping has ended the spin of a needle; the other rates change by less than a rounding."""
    needle = rigid.Body((0.2303702143799708, 0.23036942072553382, 3.6645151054448544e-06))
    scene = rigid.FreeBody(needle, damping=[0.0, 0.0, 103.57])
    omega, t = [0.7318133169566279, -0.5486510356094831, -1.0492894760476998], [2.45e-5]
    run = rigid.simulate(scene, omega, t=t, method="taylor12", record="rates")
    truth = rigid.simulate(scene, omega, t=t, method="taylor16", tolerance=1e-15, record="rates")
    off = np.linalg.norm(run.omega - truth.omega) / np.linalg.norm(truth.omega)
    assert 1e-14 < off <= run.error < 1e-12


def test_rates_of_a_top_that_hangs_all_but_still_carry_the_rounding_of_its_vertical() -> None:
    """Its swing of 1e-9 rad/s moves the vertical by less than a rounding in many a step."""
    body = rigid.Body((0.2954834774489046, 1.2173776693824097, 1.0451217024068815))
    com = (-0.5916854832714615, 0.479999855994827, -0.6476947021018177)
    top = rigid.HeavyTop(body, mgl=9.016663606144977, com=com)
    omega = [-1.471321292828963e-09, 1.3140610169210498e-09, -8.337226829351962e-10]
    attitude = [0.5873751745868392, -0.4196014785879164, -0.009340665928735975, -0.691981036883181]
    t = [49.099960006262855]
    run = rigid.simulate(top, omega, attitude, t=t, method="taylor12", step=0.0358662)
    truth = rigid.simulate(top, omega, attitude, t=t, method="taylor26", tolerance=1e-17)
    off = np.linalg.norm(run.omega - truth.omega) / np.linalg.norm(truth.omega)
    assert 1e-7 < off < run.error < 1e-4


# Stated errors of the midpoint rule where its own errors are known in closed form


INERTIA = 2.0
SPHERE = rigid.Body([INERTIA] * 3)

FOURFOLD = 4.0
"""Three times the difference of two runs, which is the whole error at most, and what rings."""


def lag(steps: int, angle: float) -> float:
    """By how much the rule is late after steps of this angle (rad)."""
    return float(steps * (angle - 2.0 * np.arctan(angle / 2.0)))


def spinning(steps: int, angle: float, times: list[float]) -> rigid.Run:
    """A sphere after so many equal steps of this angle (rad)."""
    spin = [0.0, 0.0, steps * angle / times[-1]]
    step = times[-1] / steps
    return rigid.simulate(rigid.FreeBody(SPHERE), spin, t=times, method="midpoint", step=step)


@pytest.mark.parametrize("angle", [0.1, 0.2, 0.3, 0.35, 0.5])
def test_the_lag_of_a_sphere_is_stated(angle: float) -> None:
    """Also where the two runs are compared on the way: from 0.3 rad a step on."""
    error = lag(100, angle)
    run = spinning(100, angle, [1.0])
    assert run.steps == 100
    assert error < run.error < FOURFOLD * error


@pytest.mark.parametrize("end", [0.05, 20.0])
def test_two_runs_that_part_by_a_whole_turn_are_told_apart(end: float) -> None:
    """In half the steps it is late by a quarter: both runs are about a third of a turn off."""
    steps, low, high = 800, 0.1, 1.0
    while high - low > 1e-15:
        middle = 0.5 * (low + high)
        parted = lag(steps, middle) - lag(2 * steps, 0.5 * middle)
        low, high = (middle, high) if parted < 2.0 * np.pi else (low, middle)
    off = lag(steps, low) % (2.0 * np.pi)
    assert off > 2.0
    # A time soon after the start does not show it.
    assert spinning(steps, low, [end / steps, end]).error > off


def damped(damping: ArrayLike, rates: ArrayLike, times: list[float], steps: int) -> rigid.Run:
    scene = rigid.FreeBody(SPHERE, damping=damping)
    step = times[-1] / steps
    return rigid.simulate(scene, rates, t=times, method="midpoint", step=step, record="rates")


@pytest.mark.parametrize(("product", "steps"), [(100, 64), (100, 16), (3, 8)])
def test_rates_that_damping_should_have_ended_are_stated(product: float, steps: int) -> None:
    """Of steps of so many damping times, of which some is left after an even number of them.

    The truth is below 1e-5 of what is recorded, so that all of that is error. Stated is three times
    by what two runs part, the second of twice the steps, and what is left of the first. What
    they part by is relative to the rates of the first, which err by as much.
    """
    end, half = 1.4, 0.5 * product
    strength = INERTIA * product * steps / end
    run = damped(strength, [0.0, 0.0, 1e-3], [0.5 * end, end], steps)
    taken = np.array([steps // 2, steps])
    left = ((half - 1.0) / (half + 1.0)) ** taken
    again = ((half / 2 - 1.0) / (half / 2 + 1.0)) ** (2 * taken)
    np.testing.assert_allclose(run.omega[:, 2], 1e-3 * left, rtol=1e-9)
    parted = 3.0 * np.abs(left - again) / left[0]
    parted = np.where(parted < 1.0, parted / (1.0 - parted), parted)
    assert run.error == pytest.approx(np.max(parted + left / left[0]), rel=1e-6)
    assert run.flagged


def test_rates_that_damping_leaves_alone_are_stated() -> None:
    """Of steps of 1e7 damping times both runs leave the rates as they were."""
    run = damped(INERTIA * 1e7 * 64, [0.0, 0.0, 1e-3], [1.0], 64)
    assert run.omega[0, 2] == pytest.approx(1e-3, rel=1e-4)
    assert 1.0 <= run.error < FOURFOLD
    assert run.flagged


def test_nothing_rings_at_the_start() -> None:
    """Relative to the start, which is exact, the rest is small."""
    steps, product = 64, 8.0
    run = damped(INERTIA * product * steps, [0.0, 0.0, 1.0], [0.0, 1.0], steps)
    off = abs(run.omega[1, 2])
    assert off == pytest.approx((3.0 / 5.0) ** steps, rel=1e-6)
    assert off < run.error < FOURFOLD * off + 1e-13


def test_a_body_at_rest_does_not_ring() -> None:
    assert damped(1e6, [0.0, 0.0, 0.0], [1.0], 4).error < 1e-14


def test_a_small_rate_that_rings_beside_a_large_one_that_has_ended() -> None:
    """The first rate falls below one, as it should; the third stays at one, and should not."""
    steps, slow = 64, 10.0
    run = damped(np.diag([slow, 1e8, 1e8]), [100.0, 0.0, 1.0], [1.0], steps)
    truth = np.array([[100.0 * np.exp(-slow / INERTIA), 0.0, 0.0]])
    np.testing.assert_allclose(run.omega[:, 0], truth[:, 0], rtol=0.01)
    assert run.omega[0, 2] == pytest.approx(1.0, abs=1e-3)
    off = np.linalg.norm(run.omega - truth) / np.linalg.norm(run.omega)
    assert off > 0.8
    assert run.error > off


def test_a_step_that_resolves_the_damping_does_not_ring() -> None:
    """`h k = 1/16`: the rate falls as it should, in five damping times."""
    rate = 5.0
    run = damped(INERTIA * rate, [0.0, 0.0, 1.0], [0.2, 1.0], 80)
    truth = np.exp(-rate * np.array([0.2, 1.0]))
    off = np.abs(run.omega[:, 2] - truth).max() / truth.max()
    assert off < run.error < FOURFOLD * off
