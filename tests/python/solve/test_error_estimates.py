"""The estimated error is at least the error; an accuracy is met, refused or flagged."""

import itertools
from dataclasses import replace
from decimal import Decimal
from typing import Any

import numpy as np
import pytest

import rigid
from error_survey import final_error, survey
from physics import EVERY_METHOD, Floats, Golden, golden, present, rotation_angle, tilted
from refusals import refuses
from rigid.solve.choose_method import roots
from rigid.solve.methods import series_methods

TOP = rigid.HeavyTop(rigid.Body((1.0, 1.6, 0.7)), mgl=1.2, com=(0.6, 0.0, 0.8))


def test_random_scenes() -> None:
    """True errors are at most the estimated ones, which are seldom much larger."""
    ratios, missed = survey(200, seed=2026)
    assert not missed
    assert len(ratios) > 150
    assert np.mean(ratios <= 1.0) >= 0.99
    assert 0.05 <= np.median(ratios) <= 1.0


FAMILIES = ("free_asymmetric", "free_symmetric", "lagrange", "heavy_asymmetric", "kovalevskaya")
CASES = [case for family in FAMILIES for case in golden(family)]


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.id)
def test_every_method_gives_the_accuracy_or_says_that_it_does_not(case: Golden) -> None:
    known = case.kappa_att < 1e6
    last = int(np.flatnonzero(known)[min(2, known.sum() - 1)])
    fastest = float(np.linalg.norm(case.omega, axis=-1).max())
    start = case.scene, case.omega0, case.attitude0
    options: dict[str, Any] = {"t": [case.t[last]], "max_steps": 5_000}
    met = 0
    for method in EVERY_METHOD:
        for accuracy in (1e-6, 1e-9, 1e-12):
            try:
                run = rigid.simulate(*start, accuracy=accuracy, method=method.name, **options)
            except ValueError:
                continue  # beyond float64, or not for this body
            if run.status != rigid.Status.FINISHED or run.flagged:
                continue
            error = final_error(run, case.omega[last], case.attitude[last], fastest)
            assert error <= accuracy, (method.name, accuracy, float(run.error))
            met += 1
    assert met >= 3


def test_the_steps_of_tops_are_made_for_1e_8_and_all_tops_are_checked() -> None:
    """Without a method, a step and an accuracy."""
    rng = np.random.default_rng(22)
    omega = np.array([0.2, 0.1, 3.0]) + 0.1 * rng.normal(size=(100, 3))
    t = np.linspace(0.0, 10.0, 11)
    run = rigid.simulate(TOP, omega, tilted(0.5), t=t)
    truth = rigid.simulate(TOP, omega, tilted(0.5), t=t, method="taylor26", check=False)
    apart = rotation_angle(present(run.attitude), present(truth.attitude))
    assert np.all(apart.max(axis=1) <= run.error)
    # The model is that of a body in the middle of many.
    assert np.median(run.error) <= 1e-8
    assert np.all(run.error <= 1e-6)
    assert np.all(run.status == rigid.Status.OK)
    assert run.spec["accuracy"] is None
    assert run.plan.accuracy == 1e-8
    assert "the step follows from the error of 1e-08 at the end" in run.plan.why
    assert run.plan.error == run.error.max()
    unchecked = rigid.simulate(TOP, omega, tilted(0.5), t=t, check=False)
    assert unchecked.plan == replace(run.plan, error=None)
    assert np.all(unchecked.status == rigid.Status.UNCHECKED)


def test_a_run_shows_itself_in_a_line() -> None:
    one = rigid.simulate(TOP, [0.2, 0.1, 3.0], t=[1.0, 2.0])
    assert repr(one) == f"Run(one body at 2 times; {one.plan.method}; error {one.error:.1e}; ok)"
    # An error that may surprise beside the word: without an accuracy `ok` means below 1e-3.
    rough = rigid.simulate(TOP, [0.2, 0.1, 3.0], t=[1.0, 2.0], method="rk4", step=0.05)
    assert 1e-6 < rough.error < 1e-3
    ok = f"error {rough.error:.1e}; ok (error below 0.001))"
    assert repr(rough) == f"Run(one body at 2 times; rk4; {ok}"
    # The error of another body says nothing about a body that is ok.
    rates = [[0.0, 0.0, 0.1], [0.2, 0.1, 40.0]]
    pair = rigid.simulate(TOP, rates, t=[1.0], method="rk4", step=0.02)
    fine, coarse = pair.error
    assert fine < 1e-6 < 1e-3 < coarse
    assert pair.status.tolist() == [0, 7]
    assert repr(pair).endswith(f"error {coarse:.1e}; 1 ok, 1 coarse)")
    asked = rigid.simulate(TOP, [0.2, 0.1, 3.0], t=[1.0, 2.0], method="rk4", accuracy=1e-3)
    assert repr(asked) == f"Run(one body at 2 times; rk4; error {asked.error:.1e}; ok)"
    omega = np.array([[0.2, 0.1, 30.0], [0.1, 0.3, 0.2]])
    some = rigid.simulate(TOP, omega, t=[1.0], method="rk4", max_steps=200, check=False)
    words = "error unknown; 1 step_limit, 1 unchecked)"
    assert repr(some) == f"Run(2 bodies at 1 time; rk4; {words}"
    assert repr(rigid.simulate(TOP, omega[:0], t=[1.0])) == (
        "Run(0 bodies at 1 time; exact; error unknown; nothing)"
    )


def test_a_top_that_turns_so_often_that_rounding_exceeds_1e_8_is_integrated_all_the_same() -> None:
    omega = [[0.2, 0.1, 3e6], [0.2, 0.1, 3.0], [1e200, 0.0, 0.0]]
    run = rigid.simulate(TOP, omega, t=[10.0], max_steps=1000)
    limit, ok = rigid.Status.STEP_LIMIT, rigid.Status.OK
    assert run.status.tolist() == [limit, ok, limit]
    assert run.error[1] <= 1e-7
    with pytest.raises(ValueError, match="accuracy = 1e-08: must be at least"):
        rigid.simulate(TOP, omega[0], t=[10.0], accuracy=1e-8)
    with pytest.raises(ValueError, match=r"1\.19209e-07: must be at least 1\.2e-07 in float32"):
        rigid.simulate(TOP, omega[1], t=[10.0], accuracy=2.0**-23, dtype=np.float32)


@pytest.mark.parametrize(
    "options", [{"method": "dop853", "step": 0.05}, {"accuracy": 1e-8}, {}], ids=str
)
def test_chaos_is_flagged_from_some_time_on(options: dict[str, Any]) -> None:
    """The swing of a bare asymmetric top is chaotic: in the end two step sizes share no digit."""
    t = np.linspace(0.0, 400.0, 81)
    run = rigid.simulate(TOP, [0.1, 0.0, 0.2], tilted(0.3), t=t, **options)
    assert run.flagged
    assert 0.0 < float(run.lost_from) < 400.0
    assert run.error >= 1.0
    # Before, the run is what any other makes of it.
    other = rigid.simulate(TOP, [0.1, 0.0, 0.2], tilted(0.3), t=t, method="taylor20")
    before = t < 0.5 * float(run.lost_from)
    assert np.abs(run.omega - other.omega)[before].max() < 1.0


def test_every_body_of_a_large_call_with_a_step_is_checked() -> None:
    rng = np.random.default_rng(5)
    omega = rng.normal(size=(100, 3))
    options: dict[str, Any] = {"t": [5.0], "method": "rk4", "step": 0.05}
    run = rigid.simulate(TOP, omega, tilted(0.3), **options)
    truth = rigid.simulate(TOP, omega, tilted(0.3), t=[5.0], method="taylor20")
    assert run.error.shape == run.lost_from.shape == (100,)
    error = np.linalg.norm(run.omega - truth.omega, axis=-1)[:, 0]
    assert np.all(error <= run.error * np.linalg.norm(truth.omega, axis=-1)[:, 0])
    unchecked = rigid.simulate(TOP, omega, tilted(0.3), check=False, **options)
    assert np.isnan(unchecked.error).all()
    assert unchecked.omega.tobytes() == run.omega.tobytes()


def test_nothing_to_check() -> None:
    at_start = rigid.simulate(TOP, [1.0, 2.0, 3.0], t=[0.0], method="rk4")
    assert at_start.error == 0.0
    limited = rigid.simulate(TOP, [1.0, 2.0, 3.0], t=[10.0], method="rk4", max_steps=3)
    assert np.isnan(limited.error)
    assert not limited.flagged


@pytest.mark.parametrize("steps", [1, 2, 3, 5])
def test_the_error_of_few_steps_that_falls_unevenly_is_not_hidden(steps: int) -> None:
    """One step of a needle errs by 0.0064 and two by 0.0066: they differ by little."""
    needle = rigid.Body((0.07053171142101301, 6.338778491626895e-06, 0.07053460861857404))
    omega, t = [-7.545957124771188e-05, -0.00011260872047220763, 0.9999505132800264], [0.535]
    exact = rigid.simulate(needle, omega, t=t)
    for method in ("splitting", "rk4", "midpoint", "splitting4"):
        step = 1.01 * t[0] / steps
        run = rigid.simulate(needle, omega, t=t, method=method, step=step)
        assert np.linalg.norm(run.omega - exact.omega) < run.error


# Runs to an accuracy: how near they come to it, in which steps, and what these depend on


BODY = rigid.Body((1.0, 1.6, 0.7))
TOP_ASKED = rigid.HeavyTop(BODY, mgl=1.2, com=(0.6, 0.0, 0.8))
MANY = 600


def cloud(spin: float = 2.6, count: int = MANY) -> Floats:
    rng = np.random.default_rng(7)
    rates: Floats = spin * (np.array([0.19, 0.15, 0.97]) + 4e-4 * rng.normal(size=(count, 3)))
    return rates


def true_errors(run: rigid.Run) -> Floats:
    """Error of the last states, as runs state it, by a series of order 26."""
    omega, t = run.start_omega, run.t[-1:]
    truth = rigid.simulate(TOP_ASKED, omega, t=t, method="taylor26", check=False)
    size = np.maximum(*(np.linalg.norm(of.omega[:, -1], axis=-1) for of in (run, truth)))
    rates = np.linalg.norm(run.omega - truth.omega, axis=-1)[:, -1] / size
    angles = rotation_angle(present(run.attitude), present(truth.attitude))[:, -1]
    largest: Floats = np.maximum(rates, angles)
    return largest


@pytest.mark.parametrize("spin", [2.6, 5.0, 10.0])
@pytest.mark.parametrize("accuracy", [1e-4, 1e-6, 1e-8])
def test_tops_of_a_cloud_err_less_than_stated(spin: float, accuracy: float) -> None:
    run = rigid.simulate(TOP_ASKED, cloud(spin), t=[50.0 / spin], accuracy=accuracy)
    assert np.all(true_errors(run) <= run.error)
    assert not run.flagged.any()


def test_chaotic_tops_seldom_err_by_more_than_is_stated() -> None:
    """Errors grow by a factor of 1e4 and more: two runs may err alike by chance."""
    rng = np.random.default_rng(5)
    run = rigid.simulate(TOP_ASKED, rng.normal(size=(MANY, 3)), t=[50.0], accuracy=1e-5)
    assert np.count_nonzero(true_errors(run) > run.error) <= 0.01 * MANY
    assert np.count_nonzero(run.flagged) <= 0.01 * MANY


@pytest.mark.parametrize(
    ("method", "accuracy"),
    [(None, None), *itertools.product(["pmlf6", "rk4", "dop853"], [1e-4, 1e-7, 1e-10])],
)
def test_the_plan_of_a_run_has_the_step_that_was_made(
    method: str | None, accuracy: float | None
) -> None:
    start: tuple[Any, ...] = (TOP_ASKED, [0.5, 0.4, 2.0])
    run: Any = rigid.simulate(*start, t=[10.0], accuracy=accuracy, method=method)
    assert run.plan.step == 10.0 / run.steps
    assert (run.plan.steps, run.plan.error) == (run.steps, run.error)
    # The quotient is rounded: a step that is shorter by it would make one step more.
    step = run.plan.step * (1.0 + 1e-15)
    again = rigid.simulate(*start, t=[10.0], method=run.plan.method, step=step)
    assert again.omega.tobytes() == run.omega.tobytes()
    # A step that was asked for is told as it is, although a whole number of steps are shorter.
    assert rigid.simulate(*start, t=[10.0], method="rk4", step=0.03).plan.step == 0.03


def test_the_shortest_step_of_many_tops_is_that_of_the_plan() -> None:
    rates = [[0.5, 0.4, 2.5], [0.5, 0.4, 25.0]]
    run = rigid.simulate(TOP_ASKED, rates, t=[3.0, 9.0], accuracy=1e-7, method="dop853")
    assert run.steps[1] > 5 * run.steps[0]
    assert (run.plan.step, run.plan.steps) == (9.0 / run.steps[1], run.steps[1])


@pytest.mark.parametrize("method", ["chin4a", "pmlf4"])
def test_free_motions_and_kicks_err_in_proportion_to_the_weight_over_the_spin(method: str) -> None:
    """At equal angles a step, four times the spin leaves a sixteenth of ``mgl / (I omega²)``."""
    errors = []
    for spin in (8.0, 32.0):
        options: dict[str, Any] = {"t": [30.0 / spin], "method": method}
        run = rigid.simulate(TOP_ASKED, cloud(spin, 32), step=0.5 / spin, check=False, **options)
        errors.append(float(np.median(true_errors(run))))
    assert errors[0] / errors[1] == pytest.approx(16.0, rel=0.3)


@pytest.mark.parametrize(
    ("options", "remedy"),
    [
        ({"accuracy": 1e-11}, "shorter steps do not help: end the run earlier"),
        ({}, "end the run earlier or ask for an accuracy"),
        ({"method": "taylor16", "tolerance": 1e-11}, "end the run earlier or lower the tolerance"),
        (
            {"events": rigid.crosses("omega1")},
            "chaos or rounding makes it, a smaller tolerance does not help: end the run earlier",
        ),
    ],
    ids=str,
)
def test_the_remedy_of_a_lost_top_is_an_earlier_end(options: dict[str, Any], remedy: str) -> None:
    lost, earlier = (
        rigid.simulate(TOP_ASKED, [0.3, 0.4, 1.0], t=[end], **options) for end in (200.0, 10.0)
    )
    assert lost.status == rigid.Status.FLAGGED
    assert f"; {remedy}" in lost.reasons()[0]
    assert earlier.status == rigid.Status.OK


def test_the_remedy_of_a_method_that_misses_the_accuracy_works() -> None:
    scene = rigid.FreeBody(rigid.Body((1.0, 1.1, 1.2)), rotor=(0.0, 0.0, 0.3))
    given: dict[str, Any] = {"t": [3000.0], "accuracy": 1e-9}
    run = rigid.simulate(scene, [0.0, 0.0, 2.0], method="dop853", **given)
    assert run.status == rigid.Status.FLAGGED
    assert "shorter steps of dop853 do not help: leave out the method" in run.reasons()[0]
    assert rigid.simulate(scene, [0.0, 0.0, 2.0], **given).status == rigid.Status.OK


@pytest.mark.parametrize("times", [2, 31, 301])
def test_steps_are_shortened_for_the_drift_beside_a_separatrix_too(times: int) -> None:
    box = rigid.FreeBody(rigid.Body.box(0.01, 0.08, 0.25, mass=0.3))
    t = np.linspace(0.0, 30.0, times)
    run = rigid.simulate(box, [0.05, 1.02, 0.07], t=t, method="splitting4", accuracy=1e-6)
    exact = rigid.simulate(box, [0.05, 1.02, 0.07], t=t)
    assert run.status == rigid.Status.OK
    assert np.abs(run.omega - exact.omega).max() < run.error * np.linalg.norm([0.05, 1.02, 0.07])


@pytest.mark.parametrize("order", [2, 4, 6, 8, 10])
def test_roots_of_steps_are_those_of_each_number_alone(order: int) -> None:
    numbers: Floats = np.random.default_rng(1).uniform(1e-12, 1e3, 999)
    found = roots(numbers, order)
    assert all(roots(numbers[k : k + 1], order)[0] == found[k] for k in range(0, 999, 37))
    # The rounded exponent, 1/6 or 1/10, errs by half a unit, which ``|ln x| <= 28`` multiplies; the
    # power by an order multiplies the rounding of each root by it.
    unit = np.finfo(np.float64).eps
    assert np.abs(found**order / numbers - 1.0).max() < (14.0 + order) * unit


@pytest.mark.parametrize("order", [2, 4, 8])
def test_roots_of_the_orders_of_most_methods_are_square_roots_each_rounded(order: int) -> None:
    """Decimal arithmetic knows 28 digits; a power by 1/4 rounds otherwise, and not everywhere."""
    numbers: list[float] = np.random.default_rng(1).uniform(1e-12, 1e3, 99).tolist()
    rounded = numbers
    for _ in range(order.bit_length() - 1):
        rounded = [float(Decimal(number).sqrt()) for number in rounded]
    assert roots(np.array(numbers), order).tolist() == rounded


SPUN = rigid.Body((1.0, 1.1, 1.2))

STEADY: dict[str, tuple[rigid.FreeBody, float]] = {
    "rotor": (rigid.FreeBody(SPUN, rotor=(0.0, 0.0, 0.3)), 0.0),
    "sink": (rigid.FreeBody(SPUN, dissipation=rigid.EnergySink(0.05)), 0.0),
    "orbit": (rigid.FreeBody(rigid.Body((1.0, 1.0, 1.2)), orbit=rigid.Orbit(rate=1.0)), 0.0),
    "torque": (rigid.FreeBody(SPUN, torque=rigid.Torque.body([0.0, 0.0, 1e-9])), 1e-9 / 1.2),
}
"""Bodies that spin about axis 3, and the acceleration of the spin (rad/s²)."""


@pytest.mark.parametrize("name", STEADY)
def test_a_steady_spin_of_twenty_thousand_radians_is_accurate(name: str) -> None:
    """Rounding of equal steps, all alike, exceeds the accuracy; a series does not add it up."""
    scene, acceleration = STEADY[name]
    t = 12566.0
    run: Any = rigid.simulate(scene, [0.0, 0.0, 2.0], t=[t], accuracy=1e-8)
    half = t + 0.25 * acceleration * t * t
    turn = np.array([np.cos(half), 0.0, 0.0, np.sin(half)])
    assert run.status == rigid.Status.OK
    assert rotation_angle(run.attitude[0], turn) <= float(run.error) < 1e-8


def test_the_limit_of_steps_holds_for_the_run_and_not_for_its_check() -> None:
    """A series of order 16 needs more steps for the check than one of order 26 for the run."""
    options: dict[str, Any] = {"t": [20.0], "method": "taylor26", "accuracy": 1e-8}
    free = rigid.simulate(TOP_ASKED, [0.3, 0.4, 1.0], **options)
    limited = rigid.simulate(TOP_ASKED, [0.3, 0.4, 1.0], **options, max_steps=int(free.steps))
    assert limited.status == rigid.Status.OK
    assert limited.error == free.error


def test_no_body_is_planned_by_the_method_that_was_asked_for() -> None:
    none = rigid.simulate(TOP_ASKED, np.zeros((0, 3)), t=[1.0], method="rk4", accuracy=1e-6)
    assert (none.plan.method, none.plan.tolerance, none.plan.steps) == ("rk4", None, 0)
    assert rigid.plan(FREE, omega=np.zeros((0, 3)), t_end=1.0, method="rk4").steps == 0


def test_a_slow_body_is_planned_by_its_own_rates() -> None:
    """Not as if it turned by a radian, or as if damping slowed it at 1 1/s."""
    slow: dict[str, Any] = {"omega": [0.0, 0.0, 1e-3], "t_end": 100.0}
    assert rigid.plan(FREE, **slow).error == pytest.approx(1.1e-15, rel=1e-12)
    assert rigid.plan(FREE, **slow, accuracy=1.2e-15).method == "exact"
    with pytest.raises(ValueError, match=r"accuracy = 1\.05e-15: must be at least"):
        rigid.plan(FREE, **slow, accuracy=1.05e-15)
    damped = rigid.FreeBody(FREE.body, damping=(0.5, 0.6, 0.6))
    assert "strong damping, at a rate of 0.5 1/s: etd4" in rigid.plan(damped, **slow).why


def test_an_accuracy_above_one_is_as_one_under_a_function(no_numba: None) -> None:
    def brake(t: float, omega: Floats, attitude: Floats, data: Floats, torque: Floats) -> None:
        for k in range(3):
            torque[k] = -0.1 * omega[k]

    scene = rigid.FreeBody(rigid.Body((1.0, 1.6, 2.0)), torque=rigid.Torque.call(brake))
    run, same = (
        rigid.simulate(scene, [0.3, 0.4, 1.0], t=[1.0], accuracy=accuracy)
        for accuracy in (200.0, 1.0)
    )
    assert run.omega.tobytes() == same.omega.tobytes()


# Taylor methods that choose their steps by a tolerance


FREE = rigid.FreeBody(rigid.Body([1.0, 1.6, 2.0]))
TOP_TOLERANCE = rigid.HeavyTop(rigid.Body([1.0, 1.0, 0.5]), mgl=1.2, com=[0.0, 0.0, 1.0])
OMEGA = [0.4, 0.3, 2.0]


@pytest.mark.parametrize("method", series_methods())
@pytest.mark.parametrize("scene", [FREE, TOP_TOLERANCE], ids=["free", "top"])
@pytest.mark.parametrize("tolerance", [1e-6, 1e-9, 1e-12])
def test_the_error_stays_below_the_tolerance_a_radian(
    scene: rigid.FreeBody | rigid.HeavyTop, method: str, tolerance: float
) -> None:
    t = np.linspace(-10.0, 20.0, 61)
    truth = rigid.simulate(scene, OMEGA, tilted(0.7), t=t, method="exact")
    run = rigid.simulate(scene, OMEGA, tilted(0.7), t=t, method=method, tolerance=tolerance)
    error = rotation_angle(present(run.attitude), present(truth.attitude))
    # The body turns at some 3 rad/s; rounding leaves 1e-14.
    assert np.all(error < tolerance * (1.0 + 3.0 * np.abs(t)) + 1e-14 * (1.0 + np.abs(t)))
    assert run.status == rigid.Status.FINISHED
    assert run.spec["tolerance"] == tolerance
    assert run.plan.step is None
    assert f"each body takes its own steps, last terms below {tolerance:g}" in run.plan.why


def test_a_smaller_tolerance_takes_more_steps_and_more_times_take_none() -> None:
    options: dict[str, Any] = {"method": "taylor16"}
    coarse, fine = (
        rigid.simulate(FREE, OMEGA, t=[20.0], tolerance=tolerance, **options)
        for tolerance in (1e-6, 1e-14)
    )
    assert 0 < coarse.steps < fine.steps
    often = rigid.simulate(FREE, OMEGA, t=np.linspace(0, 20, 500), tolerance=1e-14, **options)
    assert often.steps == fine.steps
    assert often.omega[-1].tobytes() == fine.omega[-1].tobytes()


test_a_tolerance_and_what_it_goes_with = refuses(
    [
        *(
            ({"method": method}, f"tolerance = 1e-09, method = {method!r}: only 'taylor12'")
            for method in (None, "exact", "rk4", "splitting")
        ),
        *(({other: 1e-3}, f"{other} = 0.001: exclude each") for other in ("step", "accuracy")),
        *(
            ({"tolerance": one}, ["tolerance = ", "must be"])
            for one in (0.0, -1e-9, np.nan, np.inf, 1.0)
        ),
    ],
    literal=True,
    by=lambda options: rigid.simulate(
        FREE, OMEGA, t=[1.0], **{"method": "taylor12", "tolerance": 1e-9, **options}
    ),
)
