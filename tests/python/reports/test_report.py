"""Error against run time: errors are true, orders are found, and nothing unknown is told."""

import dataclasses
import itertools
import json
import math
import os
import re
import signal
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.optimize import minimize

import rigid
from interrupts import sigint
from physics import ROUNDOFF, Floats, golden_scene, rotation_angle
from printed_text import refused_in, unwrapped
from processes import Capture
from refusals import refuses
from rigid._checks.shown import WIDTH
from rigid.cli import main
from rigid.cli.toml_report import parse_report, read_report
from rigid.cli.toml_table import SpecError, names_of
from rigid.model.scene import Scene
from rigid.reports import compute
from rigid.reports import reference as referring
from rigid.reports import sweep as sweeping
from rigid.reports.compute import run_report
from rigid.reports.data import AT_UNCERTAINTY, REFERENCE, USELESS
from rigid.reports.ensemble import ensemble_of, probe, same_steps
from rigid.reports.plot import COLOURS, OTHERS, colour_of, spread
from rigid.reports.reference import Horizon, Reference, find_horizons, find_reference
from rigid.reports.spec import ReportSpec, make_spec
from rigid.reports.sweep import Measured, Sweep, sweep_methods, time_sweeps
from rigid.reports.table import time_text
from rigid.solve.methods import run_methods

DOCS = Path(__file__).parents[3] / "docs"
BOX = rigid.FreeBody(rigid.Body.box(0.25, 0.08, 0.01, mass=0.3))
THROW = (0.1, 10.0, 0.1)
LAGRANGE = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.4)), mgl=1.0)
#: Seconds that no report of these tests needs, also on a slow machine: it ends when it is done.
ENOUGH = 600.0
ASYMMETRIC = rigid.HeavyTop(rigid.Body((1.0, 1.6, 0.7)), mgl=1.2)
TUMBLE = (0.4, 0.7, 2.0)


def reported(scene: Scene = BOX, *start: Any, **options: Any) -> rigid.Report:
    given = {"t_end": 0.5, "seconds": ENOUGH, "progress": False, **options}
    return rigid.report(scene, *(start or (THROW,)), **given)


@pytest.fixture(scope="module")
def box() -> rigid.Report:
    """Two methods against the closed form, with more time than they need."""
    return reported(methods=["exact", "rk4", "splitting"], errors=[1e-3, 1e-5])


@pytest.fixture(scope="module")
def top() -> rigid.Report:
    """A top without a closed form, and time for little more than its reference."""
    return reported(ASYMMETRIC, TUMBLE, t_end=1.0, errors=[1e-2], seconds=0.5)


# What is measured


@pytest.mark.parametrize(("method", "order"), [("rk4", 4.0), ("splitting", 2.0)])
def test_the_order_of_a_method_is_found(box: rigid.Report, method: str, order: float) -> None:
    # The shortest steps whose errors are no rounding show 3.978 and 2.000, the longest 3.83, 2.06.
    assert box.order(method) == pytest.approx(order, abs=0.03)


@pytest.mark.parametrize("order", [1, 2, 4, 8])
@pytest.mark.parametrize("share", [0.0, 0.01, 1.0])
def test_a_sweep_out_of_time_has_all_orders_that_rounding_does_not_bend(
    order: int, share: float
) -> None:
    """Steps are halved; of the last error a share of the truncation is added by rounding."""
    sweep, ensemble = Sweep("rk4", ended="time"), ensemble_of(make_spec(BOX, THROW, t_end=0.5))
    for k in range(6):
        error = 1e-2 * (0.5 ** (order * k) + share * 0.5 ** (order * 5))
        state = np.full(ensemble.spec.bodies, error)
        sweep.runs[100 * 2**k] = [Measured(100 * 2**k, state, state, 0.0, 0.0, call=1.0)]
    horizon = Horizon(0.0, ensemble, Reference("exact", 0, 1e-18, 1e-18), None)
    found = [row.order for row in sweep.rows([horizon]) if row.order is not None]
    if share < 0.1:
        assert len(found) == 5
    # Rounding is at most a tenth of an error that counts.
    np.testing.assert_allclose(found, order, rtol=0.0, atol=math.log2(1.1))


@pytest.mark.parametrize(
    ("first", "errors", "following"),
    [
        (100, [1e-2], 200),
        (100, [1e-3], 200),
        # Even longer steps would do, if there are any.
        (100, [0.9e-3], 50),
        (3, [0.9e-3], 1),
        (1, [0.9e-3], 2),
        (100, [1e-2, 1e-9], 400),
        (100, [1e-2, 0.9e-9], "smallest wanted error"),
        (100, [1e-2, 1e-12], "reference uncertainty"),
        # Of the last two none is half of the best before: with short steps, or small errors.
        (100, [1e-2, 1e-7, 0.6e-7, 0.7e-7], "rounding"),
        (100, [1e-2, 1e-7, 0.7e-7, 0.6e-7], "rounding"),
        (100, [1e-2, 1e-7, 0.7e-7, 0.5e-7], 1600),
        (100, [1e-2, 1e-7, 0.5e-7, 0.7e-7], 1600),
        (1, [1e-2, 1e-7, 1e-7, 1e-7], 16),
        (1, [1e-2, 5e-9, 5e-9, 5e-9], "rounding"),
        (1, [5e-9, 5e-9, 5e-9], "rounding"),
        (1, [5e-9, 5e-9], 4),
        (5 * 10**8, [1e-2], 10**9),
        (5 * 10**8 + 1, [1e-2], "number of steps"),
    ],
)
def test_steps_are_halved_until_nothing_new_would_be_seen(
    first: int, errors: list[float], following: int | str
) -> None:
    """Wanted are errors from 1e-3 to 1e-9; the reference is uncertain by 1e-12."""
    spec = make_spec(BOX, THROW, t_end=0.5, errors=[1e-3, 1e-9])
    ensemble = ensemble_of(spec)
    horizon = Horizon(0.0, ensemble, Reference("exact", 0, 1e-12, 1e-12), None)
    sweep = Sweep("rk4")
    # At first about a radian a step.
    assert sweep.next_steps(horizon) == (math.ceil(ensemble.angle), None)
    for k, error in enumerate(errors):
        steps, state = first * 2**k, np.full(spec.bodies, error)
        sweep.runs[steps] = [Measured(steps, state, state, 0.0, 0.0, call=1.0)]
    found = sweep.next_steps(horizon)
    assert (sweep.ended if found is None else found[0]) == following
    exact = Sweep("exact")
    assert exact.next_steps(horizon) == (0, None)
    exact.runs[0] = [Measured(0, state, state, 0.0, 0.0, call=1.0)]
    assert (exact.next_steps(horizon), exact.ended) == (None, "closed form")


def test_the_cheapest_run_comes_first_and_every_method_runs_once(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Twice the steps cost twice the time: 0.1, 0.2, ... s for one method, 0.3, 0.6, ... s for two.

    The last runs, of 0.8 s and 1.2 s, would end after the two seconds that there are.
    """
    clock, order = [0.0], []
    cost = {"rk4": 0.1, "dop853": 0.3}

    def measure(_: Horizon, method: str, steps: int, _angle: None) -> Measured:
        order.append(method)
        clock[0] += cost[method] * 2.0 ** (order.count(method) - 1)
        state = np.full(2, 1.0 / steps)
        return Measured(steps, state, state, 0.0, 0.0, call=1.0)

    monkeypatch.setattr(sweeping, "_measure", measure)
    monkeypatch.setattr("rigid.reports.sweep.time.perf_counter", lambda: clock[0])
    ensemble = ensemble_of(make_spec(BOX, THROW, t_end=0.5, bodies=2, errors=[1e-9]))
    horizon = Horizon(0.0, ensemble, Reference("exact", 0, 1e-12, 1e-12), None)
    sweeps, told = [Sweep("rk4"), Sweep("dop853")], []
    sweep_methods(
        horizon, sweeps, lambda seconds: clock[0] + seconds < 2.0, lambda: told.append(clock[0])
    )
    assert order == ["rk4", "dop853", "rk4", "rk4", "dop853"]
    np.testing.assert_allclose(told, [0.1, 0.4, 0.6, 1.0, 1.6])
    assert [sweep.ended for sweep in sweeps] == ["time", "time"]


@pytest.mark.parametrize(
    ("work", "steps", "known_until", "times"),
    [
        (1e7, 10, math.inf, 1),
        (4e6, 10, math.inf, 1),
        (3.9e6, 10, math.inf, 2),
        (1e6, 10, math.inf, 4),
        (0.0, 10**3, math.inf, 10**6),  # a thousand million steps in all
        (0.0, 2 * 10**9, math.inf, 1),
        (1e6, 10, 1.2, 2),  # a table of the scene that ends before three horizons
        (1e6, 10, 0.5, 1),
    ],
)
def test_a_timed_call_works_for_four_milliseconds_if_the_scene_goes_so_far(
    work: float, steps: int, known_until: float, times: int
) -> None:
    """The time of a body until the horizon is that of the call over bodies and horizons."""
    asked: list[int] = []

    class Known:
        spec = SimpleNamespace(scene=SimpleNamespace(known_until=known_until), t_end=0.5, bodies=8)

        def run(self, method: str, steps: int, *, times: int) -> Any:
            asked.append(times)
            return SimpleNamespace(nanoseconds=8e6, steps=np.full(8, times * steps))

    ensemble: Any = Known()
    spent = sweeping._time_steps(ensemble, "rk4", steps, work)
    assert asked == [times]
    assert spent == pytest.approx(8e6 / (8 * times))


@pytest.mark.parametrize(("limit", "rounds"), [(60.0, 9), (7.0, 3)])
def test_rounds_of_timings_go_on_until_nine_or_the_time_is_over(
    limit: float, rounds: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each of two steps takes a second of 60, or of seven: the fourth round would not end."""
    ensemble = ensemble_of(make_spec(BOX, THROW, t_end=0.5, bodies=2))
    state = np.zeros(2)
    clock = [0.0]

    def spent(*_: object) -> float:
        clock[0] += 1.0
        return clock[0]

    monkeypatch.setattr(sweeping, "_time_steps", spent)
    monkeypatch.setattr(sweeping, "_time_closed_form", spent)
    monkeypatch.setattr("rigid.reports.sweep.time.perf_counter", lambda: clock[0])
    runs = [Measured(steps, state, state, 0.0, 0.0, call=1.0) for steps in (0, 10)]
    sweeps = [Sweep("exact", {0: [runs[0]]}), Sweep("rk4", {10: [runs[1]]})]
    told: list[float] = []
    time_sweeps(ensemble, sweeps, lambda more: clock[0] + more <= limit, told.append)
    assert [len(run.times) for run in runs] == [rounds, rounds]
    assert sorted(runs[0].times + runs[1].times) == [*range(1, 2 * rounds + 1)]
    np.testing.assert_allclose(told, np.arange(2 * rounds) / 18.0)


def test_errors_are_those_of_the_state_against_the_closed_form(box: rigid.Report) -> None:
    """The first body of the ensemble is the given one; the median is that of one body."""
    alone = reported(methods=["rk4"], bodies=1, errors=[1e-3])
    truth: Any = rigid.simulate(BOX, THROW, t=[0.5])
    for row in alone.rows:
        assert row.step is not None
        run: Any = rigid.simulate(
            BOX, THROW, t=[0.5], method="rk4", step=np.nextafter(row.step, 1.0)
        )
        assert run.steps == row.steps
        rates = np.abs(run.omega - truth.omega).max()
        rates /= max(np.linalg.norm(THROW), np.linalg.norm(truth.omega))
        angle = float(rotation_angle(run.attitude, truth.attitude)[0])
        # Differences of numbers of size one: their rounding, and that of the angle.
        assert row.rates_error == pytest.approx(rates, rel=1e-9, abs=8 * ROUNDOFF)
        assert row.attitude_error == pytest.approx(angle, rel=1e-9, abs=8 * ROUNDOFF)
        assert row.error == row.worst == max(row.rates_error, row.attitude_error)
        assert row.energy_drift == run.energy_drift
        assert row.momentum_drift == run.momentum_drift


def test_steps_double_from_about_a_radian_until_the_smallest_wanted_error(
    box: rigid.Report,
) -> None:
    for method in ("rk4", "splitting"):
        rows = box.of(method)
        assert all(a.steps == b.steps // 2 for a, b in itertools.pairwise(rows))
        assert any(0.5 <= row.angle <= 1.0 for row in rows if row.angle is not None)
        assert rows[-1].error < 1e-5 <= rows[-2].error
        assert box.ended[method] == "smallest wanted error"
        assert rows[0].error >= 1e-3 or rows[0].steps == 1


def test_every_time_is_positive_and_has_a_spread(box: rigid.Report) -> None:
    assert box.complete
    assert box.rounds >= 1
    for row in box.rows:
        assert row.nanoseconds > 0.0
        assert row.total == pytest.approx(row.nanoseconds * 0.5)
        assert row.spread is not None
        assert row.spread >= 0.0


def test_the_closed_form_is_the_reference_and_says_how_far_it_may_be_off(box: rigid.Report) -> None:
    (row,) = box.of("exact")
    assert (box.reference.method, box.reference.steps) == ("exact", 0)
    assert row.mark == REFERENCE
    assert row.error == box.reference.uncertainty
    assert 0.0 < box.reference.uncertainty <= box.reference.worst < 1e-11


# The reference


@pytest.mark.parametrize("name", ["regular_tumbling", "chaotic_a", "chaotic_strong"])
def test_a_converged_reference_is_as_exact_as_it_says(name: str) -> None:
    case = golden_scene(f"heavy_asymmetric/{name}")
    k = 1  # the first time after the start
    spec = make_spec(case.scene, case.omega0, case.attitude0, t_end=case.t[k], bodies=8)
    ensemble = ensemble_of(spec)
    usable, refused = probe(ensemble, spec.methods)
    assert "exact" in refused
    reference, truth = find_reference(ensemble, usable, lambda _: True)
    assert truth.attitude is not None
    off = float(rotation_angle(truth.attitude[0, -1], case.attitude[k]))
    of_rates = np.abs(truth.omega[0, -1] - case.omega[k]).max() / np.linalg.norm(case.omega0)
    # The golden start is normalised exactly, ours is rounded: its condition.
    rounded = ROUNDOFF * case.kappa_att[k]
    assert off <= reference.worst + rounded
    assert of_rates <= reference.worst + ROUNDOFF * case.kappa_omega[k]
    assert reference.uncertainty < 1e-10


def test_the_reference_is_not_converged_in_no_time_and_says_so() -> None:
    spec = make_spec(ASYMMETRIC, TUMBLE, t_end=20.0, bodies=8)
    ensemble = ensemble_of(spec)
    hasty, short = find_reference(ensemble, ["splitting"], lambda _: False)
    _, truth = find_reference(ensemble, ["rk4"], lambda _: True)
    off = np.maximum(*ensemble.distance(short, truth))
    assert np.median(off) <= hasty.uncertainty
    assert hasty.uncertainty > 1e-4


class Converging:
    """An ensemble whose runs of n and 2 n steps are apart as told."""

    angle, rates = 10.0, np.array([0.0, 0.0])
    spec = SimpleNamespace(t_end=1.0)

    def __init__(self, apart: list[float], fewest: int = 1) -> None:
        self._apart, self._fewest = apart, fewest
        self.runs: list[int] = []
        self.made: dict[int, Any] = {}

    def run(self, method: str, steps: int) -> Any:
        assert method == "taylor26"
        if steps < self._fewest:
            raise ValueError("so long a step is unstable")
        self.runs.append(steps)
        self.made[steps] = SimpleNamespace(steps=steps)
        return self.made[steps]

    def distance(self, before: Any, after: Any) -> tuple[Floats, Floats]:
        assert after.steps == 2 * before.steps
        apart = self._apart[len(self.runs) - 2]
        return np.array([apart, 4.0 * apart]), np.zeros(2)


@pytest.mark.parametrize(
    ("apart", "steps", "error"),
    [
        # The last two runs are as far apart as rounding drives them: of the run before, both.
        ([1e-3, 1e-8, 1e-12, 2e-12], 160, 2e-12),
        ([1e-3, 1e-8, 2e-12, 1e-12], 160, 2e-12),
        ([1e-3, 1e-8, 1e-12, 0.4e-12, 0.3e-12], 320, 0.4e-12),
        # Not before three are compared, nor above a millionth: the medians are 2.5 times these.
        ([1e-12, 1e-12, 1e-12], 80, 1e-12),
        ([2e-6, 1e-6, 1e-6, 3e-7, 3e-7], 320, 3e-7),
    ],
)
def test_a_reference_has_converged_where_half_the_step_brings_nothing_new(
    apart: list[float], steps: int, error: float
) -> None:
    """From half a radian a step, that is 20 steps of 10 rad."""
    ensemble: Any = Converging(apart)
    found, truth = find_reference(ensemble, ["rk4", "taylor26", "dop853"], lambda _: True)
    assert ensemble.runs == [20 * 2**k for k in range(len(apart) + 1)]
    assert (found.method, found.steps) == ("taylor26", steps)
    assert truth is ensemble.made[steps]
    assert found.uncertainty == pytest.approx(2.5 * error)
    assert found.worst == 4.0 * error


def test_a_reference_ends_when_the_next_run_would_take_too_long(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A run of n steps takes n s, and the next one twice as long; two comparisons are made."""
    ensemble: Any = Converging([1e-3, 1e-5, 1e-7, 1e-9], fewest=50)
    monkeypatch.setattr(
        "rigid.reports.reference.time.perf_counter", lambda: float(sum(ensemble.runs))
    )
    asked: list[float] = []

    def allowed(seconds: float) -> bool:
        asked.append(seconds)
        return seconds < 1000.0

    found, truth = find_reference(ensemble, ["taylor26"], allowed)
    # 20 and 40 steps are too few.
    assert ensemble.runs == [80, 160, 320, 640]
    assert asked == [640.0, 1280.0]
    assert found.steps == 640
    assert truth is ensemble.made[640]
    assert found.worst == pytest.approx(4e-7)
    # Rounding is 1e-15 of a radian, and of each that is turned.
    exact: Any = Converging([0.0] * 3)
    exact.rates = np.array([1.0, 5.0])
    found, _ = find_reference(exact, ["taylor26"], lambda _: True)
    assert found.uncertainty == pytest.approx(4e-15)
    assert found.worst == pytest.approx(6e-15)


def test_a_method_that_takes_no_step_is_no_reference() -> None:
    """Steps of 10 rad are halved down to a sixteenth of a radian."""
    ensemble: Any = Converging([], fewest=10**9)
    with pytest.raises(ValueError, match="unstable"):
        find_reference(ensemble, ["taylor26"], lambda _: True)
    shortest: Any = Converging([0.0] * 3, fewest=300)
    assert find_reference(shortest, ["taylor26"], lambda _: True)[0].steps == 1280


@pytest.mark.parametrize(
    ("revolutions", "limit", "lost", "tried", "known"),
    [
        # The first search is of ten revolutions, and shows what one of them costs.
        ([100.0, 1000.0], 1e9, math.inf, [10.0, 100.0, 1000.0], [True, True]),
        ([3.0, 30.0], 1e9, math.inf, [3.0, 3.0, 30.0], [True, True]),
        ([100.0, 1000.0], 500.0, math.inf, [10.0, 100.0], [True, False]),
        ([100.0, 1000.0], 50.0, math.inf, [10.0], [False, False]),
        ([100.0, 1000.0, 1e4], 1e9, 1000.0, [10.0, 100.0, 1000.0], [True, True, False]),
    ],
)
def test_a_longer_reference_is_looked_for_while_there_is_time_and_phase(
    revolutions: list[float],
    limit: float,
    lost: float,
    tried: list[float],
    known: list[bool],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Each takes a second a revolution; from ``lost`` revolutions on its phase is unknown."""
    spec = make_spec(BOX, THROW, revolutions=revolutions, bodies=2)
    searched: list[float] = []

    def find(ensemble: Any, *_: object) -> Any:
        searched.append(round(ensemble.spec.t_end / spec.time_of(1.0), 9))
        worst = 1.0 if searched[-1] >= lost else 0.9
        return Reference("taylor26", 1, worst, worst), None

    monkeypatch.setattr(referring, "find_reference", find)
    monkeypatch.setattr("rigid.reports.reference.time.perf_counter", lambda: float(sum(searched)))
    told: list[int] = []
    found = find_horizons(
        spec, ["rk4"], lambda seconds: seconds < limit, lambda: told.append(len(searched))
    )
    assert searched == tried
    assert [bool(horizon.reference.method) for horizon in found] == known
    assert [horizon.revolutions for horizon in found] == revolutions
    assert len(told) == 1 + len(revolutions)


def test_runs_that_agree_to_the_bit_have_converged() -> None:
    """Over a short time runs of half the step are the same numbers, and no search goes on."""
    ensemble = ensemble_of(make_spec(ASYMMETRIC, (0.3, 1.2, 0.5), t_end=1.0, bodies=8))
    more = iter([True] * 12)
    reference, _ = find_reference(ensemble, ["taylor26"], lambda _: next(more, False))
    assert next(more, False)
    assert reference.steps < 100


def test_no_error_below_the_uncertainty_of_the_reference_is_told(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("rigid.reports.sweep.MOST_ROUNDS", 1)  # times are not looked at
    few = {"methods": ["rk4", "taylor16"], "bodies": 8}
    result = reported(ASYMMETRIC, TUMBLE, t_end=0.2, errors=[1e-15], **few)
    bound = result.reference.uncertainty
    assert all(row.error >= bound for row in result.rows)
    assert result.of("rk4")[-1].mark == AT_UNCERTAINTY
    assert result.of("rk4")[-1].error == bound
    assert result.cheapest(1e-15) == ()
    assert sum(row.mark == AT_UNCERTAINTY for row in result.front()) <= 1


def test_after_the_horizon_of_chaos_rows_are_marked() -> None:
    case = golden_scene("heavy_asymmetric/chaotic_strong")
    start = case.omega0, case.attitude0
    result = reported(case.scene, *start, t_end=60.0, methods=["splitting"], bodies=32, seconds=0.3)
    useless = [row for row in result.rows if row.error >= 1.0]
    assert useless
    assert {row.mark for row in useless} <= {USELESS, "failed"}
    assert all(row.error < 1.0 for row in result.front())


def test_what_is_not_applicable_is_listed_with_its_reason(top: rigid.Report) -> None:
    assert "no closed form" in top.refused["exact"]
    assert "exact" not in top.methods
    assert "not for     exact: no closed form" in str(top)
    assert top.reference.method != "exact"


def test_a_step_that_is_too_long_to_be_stable_refuses_no_method() -> None:
    """Over the horizon in one step ``rk4`` would be unstable; in short ones it is not."""
    damped = rigid.HeavyTop(ASYMMETRIC.body, mgl=1.2, damping=1.0)
    result = reported(damped, TUMBLE, t_end=50.0, methods=["rk4"], seconds=0.3)
    assert result.refused == {}
    assert min(row.error for row in result.of("rk4")) < 1e-3


@pytest.mark.parametrize(
    "forces",
    [
        {"torque": rigid.Torque.body([(0.0, 0.0, 1.0), (0.0, 0.5, 1.0)], times=[0.0, 5.0])},
        {"rotor": rigid.RotorTable([0.0, 5.0], [(0.0, 0.0, 0.0), (0.0, 0.0, 1.0)])},
    ],
    ids=["torque", "rotor"],
)
def test_a_table_may_end_where_the_report_ends(forces: Any) -> None:
    """No timed run goes on beyond it, and the order of ``rk4`` is 4."""
    scene = rigid.FreeBody(rigid.Body((1.0, 1.5, 2.0)), **forces)
    few = {"methods": ["rk4", "taylor20"], "bodies": 2}
    result = reported(scene, (0.3, 0.2, 0.5), t_end=5.0, errors=[1e-6], seconds=10.0, **few)
    assert result.refused == {}
    assert result.order("rk4") == pytest.approx(4.0, abs=0.5)


# One row for each motion


MOTIONS: dict[str, tuple[Scene, tuple[float, float, float]]] = {
    "asymmetric": (BOX, THROW),
    "symmetric": (rigid.FreeBody(rigid.Body((1.0, 1.0, 1.0033))), (0.1, 0.0, 6.3)),
    "sphere": (rigid.FreeBody(rigid.Body((2.0, 2.0, 2.0))), (0.1, 0.2, 0.3)),
    "lagrange": (LAGRANGE, (0.1, 0.0, 6.0)),
    "top": (ASYMMETRIC, TUMBLE),
    "damped": (rigid.HeavyTop(ASYMMETRIC.body, mgl=1.2, damping=0.1), TUMBLE),
    "at rest": (BOX, (0.0, 0.0, 0.0)),
}


def bits(scene: Scene, omega: Any, method: str, step: float) -> bytes | None:
    """The states of a body on the way and after a long run; None if steps may not be so long."""
    t = step * np.array([1.0, 2.0, 7.0, 40.0])
    limit = next(one.damping_limit for one in rigid.methods() if one.name == method)
    if scene.damping is not None and step * np.max(scene.damping) / min(scene.body.moments) > (
        limit or 0.0
    ):
        return None
    run = rigid.simulate(scene, omega, t=t, method=method, step=step, check=False)
    assert run.attitude is not None
    return run.omega.tobytes() + run.attitude.tobytes()


@pytest.mark.parametrize("name", MOTIONS)
def test_a_report_has_one_row_for_each_motion(name: str) -> None:
    """Two names in different rows part in some step; names of one row agree to the bit in all."""
    scene, omega = MOTIONS[name]
    spec = make_spec(scene, omega, t_end=1.0, bodies=8)
    ensemble = ensemble_of(spec)
    usable, _ = probe(ensemble, spec.methods)
    same = same_steps(ensemble, usable)
    every = [one for method, others in same.items() for one in (method, *others)]
    assert sorted(every) == sorted(usable)
    # Turns of up to ten radians a step: of slow bodies series agree to the bit in shorter ones.
    rate = float(ensemble.rates.max())
    steps = [angle / rate if rate else angle for angle in (0.37, 2.9, 10.0)]
    of = {
        method: [bits(scene, omega, method, step) for step in steps]
        for method in usable
        if method != "exact"
    }
    for method, others in same.items():
        for other in others:
            assert of[method] == of[other], (method, other)
    distinct = [method for method in same if method != "exact"]
    for one, other in itertools.combinations(distinct, 2):
        assert of[one] != of[other], (one, other)


def test_what_is_one_motion_on_simple_bodies() -> None:
    """Exact flows of a symmetric free body, and a drift of a free body between kicks of nothing."""

    def of(name: str) -> dict[str, set[str]]:
        scene, omega = MOTIONS[name]
        ensemble = ensemble_of(make_spec(scene, omega, t_end=1.0, bodies=8))
        usable, _ = probe(ensemble, run_methods())
        return {one: set(others) for one, others in same_steps(ensemble, usable).items()}

    exact_flows = {method.name for method in rigid.methods() if method.symplectic}
    of_symmetric = of("symmetric")
    (best,) = exact_flows & of_symmetric.keys()
    assert of_symmetric[best] == exact_flows - {best}
    orders = {method.name: method.order for method in rigid.methods()}
    assert orders[best] == max(orders[name] for name in exact_flows)
    drifts = of("asymmetric")["dmv10"]
    assert {"chin4a", "pmlf4", "pmlf6"} <= drifts
    assert not any(name.startswith("dmv") for name in drifts)
    for name in ("asymmetric", "symmetric", "lagrange", "top"):
        assert of(name)["rk4"] == {"etd4"}
    assert "etd4" in of("damped")


def test_a_method_is_known_by_all_of_its_names() -> None:
    report = rigid.report(
        BOX, THROW, t_end=0.2, methods=["etd4", "dop853", "rk4"], errors=[1e-2], seconds=0.2
    )
    assert report.same == {"etd4": ("rk4",)}
    assert report.methods == tuple(report.ended) == ("etd4", "dop853")
    assert report.of("rk4") == report.of("etd4") != ()
    assert report.cost("rk4", 1e-2) == report.cost("etd4", 1e-2)
    assert report.order("rk4") == report.order("etd4")
    assert rigid.Report.from_json(report.to_json()) == report
    assert "\n\nMethods with bit-identical results share a row:\netd4        = rk4\n" in str(report)


def test_many_names_are_wrapped(box: rigid.Report) -> None:
    names = tuple(f"method{k}" for k in range(30))
    many = dataclasses.replace(box, same={"rk4": names})
    assert max(map(len, str(many).splitlines())) <= WIDTH
    lines = str(many).splitlines()
    first = next(k for k, line in enumerate(lines) if line.startswith("rk4         = method0, "))
    last = next(k for k, line in enumerate(lines) if line.endswith("method29"))
    # Further lines begin below the first name.
    assert all(line[:15].rstrip(" ") == " " * 14 + "m" for line in lines[first + 1 : last + 1])
    assert " ".join(line.strip() for line in lines[first : last + 1])[14:] == ", ".join(names)


def timed(box: rigid.Report, times: dict[str, list[float]]) -> rigid.Report:
    """A report of methods that reach 1e-3 in one row each, measured so often (ns)."""
    (like,) = box.of("exact")
    rows = []
    for method, repeats in times.items():
        low, middle, high = np.percentile(repeats, (25.0, 50.0, 75.0)).tolist()
        spread = high - low if len(repeats) > 1 else None
        rows.append(
            dataclasses.replace(
                like, method=method, nanoseconds=middle, total=middle, spread=spread, mark=""
            )
        )
    rounds = min(len(repeats) for repeats in times.values())
    spec = dataclasses.replace(box.spec, errors=(1e-3,))
    return dataclasses.replace(box, spec=spec, rows=tuple(rows), rounds=rounds, same={})


def starred(report: rigid.Report) -> set[str]:
    lines = str(report).splitlines()
    return {line.split()[0] for line in lines if re.search(r"\d\*", line)}


def test_no_method_is_starred_by_noise(box: rigid.Report) -> None:
    """Of times drawn from one distribution none is the least: all methods have a star, or none.

    Medians of two samples of n differ by more than twice the distances of their quartiles in 1.5,
    0.6 and 0.01 % of draws for n = 3, 5 and 9. Bounds: more of 600 draws have a chance below 1e-3.
    """
    rng = np.random.default_rng(8)
    for repeats, most in ((3, 19), (5, 11), (9, 2)):
        alone = 0
        for _ in range(600):
            times = 100.0 * np.exp(0.1 * rng.standard_exponential((2, repeats)))
            report = timed(box, {"rk4": times[0].tolist(), "dop853": times[1].tolist()})
            alone += len(report.cheapest(1e-3)) < 2
        assert alone <= most, (repeats, alone)


CLOSE = {"rk4": [100.0, 104.0, 108.0], "dop853": [115.0, 119.0, 123.0], "taylor16": [150.0] * 3}
BUSY = {"rk4": [100.0] * 3, "dop853": [190.0, 199.0, 1500.0], "taylor16": [90.0, 201.0, 2000.0]}
FORM = {"exact": [50.0] * 3, "rk4": [70.0] * 3, "dop853": [90.0] * 3}


@pytest.mark.parametrize(
    ("times", "cheapest", "of_schemes"),
    [
        # Quartiles are 4 apart for two of them: medians must differ by more than 16.
        (CLOSE, ("rk4", "dop853"), ("rk4", "dop853")),
        ({**CLOSE, "dop853": [117.0, 121.0, 125.0]}, ("rk4",), ("rk4",)),
        # On a busy machine the quartiles of one method are farther apart than all medians.
        (BUSY, ("rk4", "dop853"), ("rk4", "dop853")),
        # A closed form, and the cheapest method beside it.
        (FORM, ("exact",), ("rk4",)),
    ],
)
def test_a_margin_above_the_spread_of_repeats_is_a_star_and_none_above_twice_the_least(
    box: rigid.Report, times: Any, cheapest: tuple[str, ...], of_schemes: tuple[str, ...]
) -> None:
    report = timed(box, times)
    assert report.cheapest(1e-3) == cheapest
    assert report.cheapest(1e-3, schemes=True) == of_schemes
    assert starred(report) == {*cheapest, *of_schemes}


@pytest.mark.parametrize("repeats", [1, 2])
def test_too_few_repeats_tell_no_cheapest(box: rigid.Report, repeats: int) -> None:
    report = timed(box, {"rk4": [100.0] * repeats, "dop853": [300.0] * repeats})
    assert report.cheapest(1e-3) == ()
    assert starred(report) == set()
    assert f"median of {repeats}, too few to tell the cheapest" in unwrapped(str(report))
    # One alone has none beside it.
    assert timed(box, {"rk4": [100.0] * repeats}).cheapest(1e-3) == ("rk4",)


def test_the_ensemble_depends_on_its_seed_and_on_nothing_else() -> None:
    def ensemble(seed: int) -> Any:
        return ensemble_of(make_spec(BOX, (0.0, 10.0, 0.1), t_end=1.0, seed=seed)).omega

    one = ensemble(1)
    assert np.array_equal(one, ensemble(1))
    assert not np.array_equal(one, ensemble(2))
    assert np.array_equal(one[0], (0.0, 10.0, 0.1))
    assert np.all(one[:, 0] == 0.0), "what is zero stays zero"
    assert np.std(one[1:, 1] / 10.0) == pytest.approx(1e-3, rel=0.4)


# What is said of it


def test_the_front_is_not_dominated_and_everything_else_is(box: rigid.Report) -> None:
    def beats(a: rigid.Row, b: rigid.Row) -> bool:
        no_worse = a.nanoseconds <= b.nanoseconds and a.error <= b.error
        return no_worse and (a.nanoseconds, a.error) != (b.nanoseconds, b.error)

    schemes = [row for row in box.rows if row.method != "exact"]
    for front, rows in ((box.front(), list(box.rows)), (box.front(schemes=True), schemes)):
        assert front
        for row in rows:
            beaten = any(beats(other, row) for other in rows)
            assert (row in front) == (not beaten and row.error < 1.0)
        assert all(a.error > b.error for a, b in itertools.pairwise(front))


def test_the_cost_of_an_error_lies_between_the_steps_around_it(box: rigid.Report) -> None:
    for method in ("rk4", "splitting"):
        rows = box.of(method)
        for row in rows[1:]:
            assert box.cost(method, row.error) == pytest.approx(row.nanoseconds)
        cost: Any = box.cost(method, 1e-5)
        low, high = sorted(row.nanoseconds for row in rows[-2:])
        assert low * (1 - 1e-12) <= cost <= high * (1 + 1e-12)
        assert box.cost(method, 0.1 * rows[-1].error) is None
    costs = {method: box.cost(method, 1e-3) for method in box.methods}
    assert box.cheapest(1e-3)[0] == min(costs, key=lambda name: costs[name] or math.inf)
    assert set(box.cheapest(1e-3, schemes=True)) <= {"rk4", "splitting"}


def test_a_cost_is_interpolated_in_the_logarithms_of_error_and_time(box: rigid.Report) -> None:
    """Of the order 2: a tenth of the error takes the root of ten times as long."""
    (like,) = box.of("exact")
    times = (100.0, 1000.0)
    rows = [
        dataclasses.replace(
            like, method="rk4", nanoseconds=time, error=1.0 / time**2, spread=spread * time, mark=""
        )
        for time, spread in zip(times, (0.02, 0.01), strict=True)
    ]
    report = dataclasses.replace(box, rows=tuple(rows), same={})
    for error, cost in ((0.5, 100.0), (1e-4, 100.0), (1e-5, 10**2.5), (1e-6, 1000.0)):
        assert report.cost("rk4", error) == pytest.approx(cost)
    assert report.cost("rk4", 0.9e-6) is None
    # The scatter is that of the row around it that scatters more.
    assert report._cost("rk4", 1e-5) == pytest.approx((10**2.5, 0.02 * 10**2.5))
    lost = dataclasses.replace(rows[0], error=math.inf)
    assert dataclasses.replace(report, rows=(lost, rows[1])).cost("rk4", 1e-5) == 1000.0


@pytest.mark.parametrize(
    ("nanoseconds", "digits", "words"),
    [
        (0.012345, 3, "0.0123"),
        (99.96, 3, "100"),
        (999.4, 3, "999"),
        (999.6, 3, "1,000"),
        (12345.6, 3, "12,346"),
        (9.4, 1, "9"),
        (9.6, 1, "10"),
        (67.8, 1, "68"),
    ],
)
def test_times_have_three_digits_or_all_before_the_point(
    nanoseconds: float, digits: int, words: str
) -> None:
    assert time_text(nanoseconds, digits) == words


def test_a_row_of_the_front_shows_its_numbers(box: rigid.Report) -> None:
    (like,) = box.of("exact")
    row = dataclasses.replace(
        like,
        method="rk4",
        steps=1234567,
        angle=0.123456,
        nanoseconds=12345.6,
        spread=67.8,
        error=1.234e-4,
        worst=5.67e-3,
        energy_drift=7.6e-9,
        momentum_drift=math.inf,
        order=3.97,
        mark="",
    )
    least = dataclasses.replace(
        like,
        method="dop853",
        nanoseconds=99999.9,
        spread=None,
        error=1e-9,
        worst=2e-8,
        energy_drift=6e-15,
        momentum_drift=math.inf,
        mark=AT_UNCERTAINTY,
    )
    errors = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5)
    spec = dataclasses.replace(box.spec, errors=errors)
    report = dataclasses.replace(box, spec=spec, rows=(row, least), rounds=3, same={})
    front = str(report).partition("\nfront")[2].splitlines()
    assert [line.split() for line in front[2:]] == [
        ["rk4", "1,234,567", "0.12", "12,346", "68", "1.2e-04", "5.7e-03", "8e-09", "-"],
        ["dop853", "0", "-", "100,000", "-", "<1.0e-09", "2.0e-08", "6e-15", "-"],
    ]
    # Four errors stand side by side, and the fifth in a table of its own.
    one, other = (part.splitlines() for part in str(report).split("\n\n")[1:3])
    assert one[1].split() == ["order", "1e-01", "1e-02", "1e-03", "1e-04"]
    assert other[1].split() == ["order", "1e-05"]
    assert one[2].split()[:4] == ["rk4", "4", "4.0", "12,346*"]
    assert one[3].split()[:3] == ["dop853", "8", "-"]


def test_a_long_reason_is_cut_to_a_hundred_characters(box: rigid.Report) -> None:
    for count, shown in ((100, "x" * 100), (101, "x" * 97 + "...")):
        refused = {"dmv2": f"method = 'dmv2': {'x' * count}; take another"}
        text = unwrapped(str(dataclasses.replace(box, refused=refused)))
        assert f"\nnot for     dmv2: {shown}\n" in text


def test_the_table_names_methods_reference_and_wanted_errors(box: rigid.Report) -> None:
    text = str(box)
    assert "reference   exact, closed form; may be off by" in text
    for part in ("rk4", "splitting", "1e-03", "1e-05", "avx512" if "avx512" in text else "isa"):
        assert part in text or part == "isa"
    assert max(map(len, text.splitlines())) <= WIDTH


def test_json_there_and_back(box: rigid.Report, top: rigid.Report, tmp_path: Path) -> None:
    for result in (box, top):
        assert rigid.Report.from_json(result.to_json()) == result
        assert ReportSpec.from_dict(json.loads(result.spec.to_json())) == result.spec
    lost = dataclasses.replace(box.rows[-1], error=math.inf, worst=math.inf, mark="failed")
    broken = dataclasses.replace(box, rows=(lost,))
    assert rigid.Report.from_json(broken.to_json()) == broken
    path = box.save(tmp_path / "box.json")
    data = json.loads(path.read_text(encoding="utf-8"))
    assert data["machine"]["isa"] == rigid.build_info()["isa"]
    assert data["machine"]["rigid"] == rigid.__version__
    assert {"cpu", "python", "numpy"} <= set(data["machine"])


HOSTILE = "[" * 10**5, '{"format": ' + "1" * 5000 + "}", '{"' + "k" * 10**5 + '": 1}'


@pytest.mark.parametrize(
    "text", ["", "[]", "{}", '{"format": "rigid report", "format_version": 9}', *HOSTILE]
)
def test_what_is_no_report_is_refused_in_a_line(text: str) -> None:
    with pytest.raises(ValueError, match="text: is not a report") as caught:
        rigid.Report.from_json(text)
    assert len(str(caught.value)) < 500


@pytest.mark.parametrize(
    ("key", "value", "rule"),
    [
        ("nanoseconds", 0.0, "nanoseconds = 0.0: must be positive"),
        ("nanoseconds", None, "nanoseconds = None: must be a number"),
        ("error", -1.0, "error = -1.0: must not be negative"),
        ("error", math.nan, "NaN: is not JSON"),
        ("steps", "many", "steps = 'many': must be a real number"),
        ("method", 4, "method = 4: must be a string"),
        ("more", 4, "more"),
        ("same", {"rk4": [4]}, "same: 4: must be a name"),
        ("references", [], "references: must be as many as horizons"),
    ],
)
def test_rows_that_no_measurement_gives_are_refused(
    box: rigid.Report, key: str, value: object, rule: str
) -> None:
    data = json.loads(box.to_json())
    (data if key in data else data["rows"][0])[key] = value
    with pytest.raises(ValueError, match="text: is not a report") as caught:
        rigid.Report.from_json(json.dumps(data))
    assert rule in str(caught.value)


def test_the_picture_names_each_method_at_the_end_of_its_line(box: rigid.Report) -> None:
    methods = ("rk4", "taylor12", "taylor16", "splitting", "chin4a", "dmv2", "dmv10")
    rows = [
        dataclasses.replace(row, method=method, nanoseconds=factor * row.nanoseconds)
        for factor, method in enumerate(methods, 1)
        for row in box.of("rk4")
    ]
    many = dataclasses.replace(box, rows=(*box.of("exact"), *rows))
    ax = many.plot()
    ax.figure.draw_without_rendering()
    assert ax.get_legend() is None
    assert ax.get_xscale() == ax.get_yscale() == "log"
    names = {text.get_text(): text for text in ax.texts}
    assert set(many.methods) < set(names)
    inside = ax.get_window_extent()
    boxes = [names[method].get_window_extent() for method in many.methods]
    assert not any(a.overlaps(b) for a, b in itertools.combinations(boxes, 2))
    assert all(inside.x1 < one.x0 and one.x1 <= ax.figure.bbox.x1 for one in boxes)
    lines = {line.get_label(): line for line in ax.lines}
    for method in many.methods:
        colours = {names[method].get_color(), lines[method].get_color()}
        assert colours == {colour_of(method)}


def test_names_are_spread_by_the_least_squares() -> None:
    """Against SciPy's constrained minimum, for ends that crowd at the bottom and in the middle."""
    heights = [0.0, 0.01, 0.011, 0.3, 0.31, 0.31, 0.9, 0.99]
    apart, count = 0.06, 8
    found = minimize(
        lambda places: float(((places - heights) ** 2).sum()),
        np.linspace(0.0, 1.0, count),
        constraints=[
            {"type": "ineq", "fun": lambda places: np.diff(places) - apart},
            {"type": "ineq", "fun": lambda places: np.array([places[0], 1.0 - places[-1]])},
        ],
        method="SLSQP",
        options={"ftol": 1e-14, "maxiter": 500},
    )
    placed = spread(heights, apart)
    assert np.diff(placed).min() >= apart - 1e-15
    np.testing.assert_allclose(placed, found.x, atol=1e-6)  # of the optimiser


def test_a_slow_family_does_not_stretch_the_axis(box: rigid.Report) -> None:
    slow = [
        dataclasses.replace(row, method="midpoint", nanoseconds=1e6 * row.nanoseconds)
        for row in box.of("rk4")
    ]
    with_it = dataclasses.replace(box, rows=(*box.rows, *slow))
    slowest = max(row.nanoseconds for row in box.rows)
    assert with_it.plot().get_xlim()[1] <= 3.0 * slowest


def test_every_method_has_the_colour_of_its_family() -> None:
    assert COLOURS.keys() == {"exact", *(method.family for method in rigid.methods())}
    assert colour_of("exact") == COLOURS["exact"]
    assert all(colour_of(one.name) == COLOURS[one.family] for one in rigid.methods())
    assert colour_of("splitting of mine") == OTHERS


def header_of(text: str) -> dict[str, str]:
    lines = unwrapped(text.partition("\n\n")[0]).splitlines()
    return {line[:12].strip(): line[12:] for line in lines if not line.startswith("not for")}


@pytest.mark.parametrize("name", names_of("report"))
def test_the_table_in_the_docs_is_that_of_the_report_as_it_is_now(name: str) -> None:
    text = (DOCS / "reports" / f"{name}.txt").read_text(encoding="utf-8")
    costs = text.split("\n\n")[1].partition("\n")[2]  # without the heads of columns
    known = set(re.findall(r"^([a-z]+\w*) ", costs, re.MULTILINE))
    for others in re.findall(r"^[a-z]+\w* += (.*)$", unwrapped(text, 14), re.MULTILINE):
        known |= set(others.split(", "))
    refused = refused_in(text)
    assert known | refused == {"exact", *(method.name for method in rigid.methods())}
    assert not known & refused
    spec = read_report(name)[1]
    header = header_of(text)
    assert header["report"] == spec.title
    assert header["scene"] == spec.scene.words()
    assert f"{spec.bodies} close to it, seed {spec.seed}; t = {spec.t_end:g}" in header["bodies"]
    assert (DOCS / "reports" / f"{name}.png").is_file()
    assert f"reports/{name}.png" in (DOCS / "methods.md").read_text(encoding="utf-8")


# Progress, interruption


def test_progress_only_grows_and_ends_at_its_total() -> None:
    seen: list[rigid.Progress] = []
    rigid.report(BOX, THROW, t_end=0.2, methods=["rk4"], seconds=0.2, progress=seen.append)
    done = [progress.done for progress in seen]
    assert done == sorted(set(done))
    assert done[-1] == seen[-1].total == 100


def test_a_processor_without_a_file_about_it_is_named_by_its_kind(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def missing(*_: object, **__: object) -> None:
        raise FileNotFoundError

    monkeypatch.setattr("builtins.open", missing)
    monkeypatch.setattr("platform.processor", lambda: "")
    monkeypatch.setattr("platform.machine", lambda: "arm64")
    assert compute._cpu() == "arm64"


def test_stages_share_the_time(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of 1000 s 150 are for the reference, 200 for a run of each step, the rest for repeats."""
    ends: dict[str, float] = {}

    def until(name: str, allowed: Callable[[float], bool]) -> None:
        ends[name] = max(seconds for seconds in range(0, 1100, 10) if allowed(seconds))

    def find(spec: Any, usable: Any, allowed: Any, told: Any) -> Any:
        until("reference", allowed)
        return find_horizons(spec, usable, allowed, told)

    monkeypatch.setattr(compute, "find_horizons", find)
    for name in ("sweep_methods", "time_sweeps"):
        monkeypatch.setattr(
            compute, name, lambda _one, _sweeps, allowed, _told, name=name: until(name, allowed)
        )
    rigid.report(BOX, THROW, t_end=0.2, methods=["exact"], seconds=1000.0, progress=False)
    # Up to the few seconds that are gone.
    assert ends == {"reference": 140, "sweep_methods": 190, "time_sweeps": 990}


def test_hundredths_are_told_once_and_never_fewer(monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[rigid.Progress] = []
    with compute.hundredths(seen.append, time.perf_counter(), refused=2) as told:
        for share in (0.0, 0.009, 0.01, 0.019, 0.005, 0.5, 0.999, 1.0, 2.0):
            told(share)
    assert [(one.done, one.failures) for one in seen] == [(1, 2), (50, 2), (99, 2), (100, 2)]
    words: list[str] = []

    @contextmanager
    def reporting(*_: Any, failed: Callable[[int], str], **__: Any) -> Iterator[None]:
        words.extend(map(failed, (1, 2)))
        yield

    monkeypatch.setattr(compute, "reporting", reporting)
    with compute.hundredths(None, 0.0, refused=0):
        pass
    assert words == ["1 method does not apply", "2 methods do not apply"]


@pytest.mark.parametrize("until", [1, 30])
def test_an_interruption_leaves_what_is_known(until: int) -> None:
    def press(progress: rigid.Progress) -> None:
        if progress.done >= until:
            raise KeyboardInterrupt

    request: dict[str, Any] = {"t_end": 0.2, "methods": ["exact", "rk4"], "seconds": 1.0}
    with pytest.raises(rigid.Interrupted, match="runs are done; the attribute 'partial'") as caught:
        rigid.report(BOX, THROW, progress=press, **request)
    assert not caught.value.partial.complete
    assert caught.value.partial.rows
    result = rigid.report(BOX, THROW, progress=press, partial=True, **request)
    assert not result.complete
    assert result.rows
    assert "partial" in str(result)
    assert rigid.Report.from_json(result.to_json()) == result
    assert "partial" in result.plot().get_title(loc="left")


def test_an_interruption_before_the_first_run_leaves_nothing(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def press(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("rigid.reports.compute.sweep_methods", press)
    with pytest.raises(KeyboardInterrupt) as caught:
        rigid.report(BOX, THROW, t_end=0.2, methods=["rk4"], partial=True, progress=False)
    assert not isinstance(caught.value, rigid.Interrupted)


# Bad input


test_mistakes_name_argument_value_and_rule = refuses(
    [
        ({"scene": "box"}, ["scene = 'box'", "must be a rigid.FreeBody or rigid.HeavyTop"]),
        ({"omega": [1.0, 2.0]}, ["omega", "shape (3,)"]),
        ({"omega": [1.0, np.nan, 2.0]}, ["omega[1] = nan", "finite"]),
        ({"attitude": [0.0] * 4}, ["attitude = [0.0, 0.0, 0.0, 0.0]", "zero quaternion"]),
        ({"attitude": np.eye(4)}, ["attitude", "shape (4,)"]),
        ({"t_end": None}, ["t_end, revolutions: give one of the two"]),
        ({"revolutions": [10]}, ["t_end, revolutions: give one of the two"]),
        ({"t_end": 0.0}, ["t_end = 0.0: must be positive"]),
        ({"t_end": np.inf}, ["t_end = inf: must be finite"]),
        ({"t_end": 1e18}, ["t_end = 1e+18: must be at most", "in which", "1e+09 revolutions"]),
        ({"methods": ["rk5"]}, ["methods[0] = 'rk5'", "did you mean 'rk4'?"]),
        ({"methods": ["rk4", "rk4"]}, ["methods[1] = 'rk4'", "already"]),
        ({"methods": []}, ["methods = []", "at least one"]),
        ({"methods": "rk4"}, ["methods = 'rk4'", "['rk4']"]),
        ({"bodies": 0}, ["bodies = 0: must be at least 1"]),
        ({"bodies": 4097}, ["bodies = 4097: must be at most 4096"]),
        ({"errors": []}, ["errors", "at least one"]),
        ({"errors": [1e-3, 2.0]}, ["errors[1] = 2.0", "[1e-15, 1)"]),
        ({"errors": [1.0]}, ["errors[0] = 1.0"]),
        ({"errors": [0.9e-15]}, ["errors[0] = 9e-16"]),
        ({"seconds": -1.0}, ["seconds = -1.0: must be positive"]),
        ({"rng": "dice"}, ["rng = 'dice'"]),
        ({"unit": 3}, ["unit = 3"]),
        ({"progress": "yes"}, ["progress = 'yes'"]),
    ],
    literal=True,
    kind=(TypeError, ValueError),
    by=lambda change: rigid.report(
        **{"scene": BOX, "omega": THROW, "t_end": 0.1, "seconds": 0.1, **change}
    ),
)


def test_a_scene_that_no_method_accepts_is_refused_with_the_reasons() -> None:
    with pytest.raises(ValueError, match=r"methods = \['exact'\]: none .* no closed form"):
        rigid.report(
            rigid.HeavyTop(rigid.Body((1.0, 1.6, 0.7)), mgl=1.0, com=(0.6, 0.0, 0.8)),
            (0.0, 0.1, 1.0),
            t_end=1.0,
            methods=["exact"],
        )


# Named scenes and the command

SPEC = """
title = "A small report"
[scene]
kind = "free-body"
moments = [1.0, 1.5, 2.0]
[start]
omega = [0.1, 1.0, 0.2]
[run]
t_end = 1.0
bodies = 32
errors = [1e-2, 1e-4]
methods = ["exact", "rk4"]
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "small.toml").write_text(SPEC)
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize("name", names_of("report"))
def test_built_in_scenes_can_be_moved(name: str) -> None:
    known, spec = read_report(name)
    assert known == name
    assert spec.title
    ensemble = ensemble_of(spec)
    usable, _ = probe(ensemble, spec.methods)
    assert "rk4" in usable
    assert ("exact" in usable) == (name not in ("asymmetric-top", "damped-top", "satellite"))


@pytest.mark.parametrize(
    ("line", "instead", "parts"),
    [
        ("t_end = 1.0", "t_ende = 1.0", ["[run] unknown key 't_ende'; did you mean 't_end'?"]),
        ("t_end = 1.0", "", ["[run] needs the key 't_end'"]),
        ("bodies = 32", "revolutions = [10]", ["[run] t_end, revolutions: give one of the two"]),
        ("t_end = 1.0", "revolutions = [0]", ["[run] revolutions[0] = 0.0: must be above 0"]),
        ("t_end = 1.0", "t_end = -1.0", ["[run] t_end = -1.0: must be positive"]),
        ("bodies = 32", "t_end_long = 2.0", ["[run] unknown key 't_end_long'"]),
        ("omega =", "omege =", ["[start] unknown key 'omege'; did you mean 'omega'?"]),
        ('"rk4"]', '"rk5"]', ["[run] methods[1] = 'rk5'", "did you mean 'rk4'?"]),
        ("bodies = 32", "bodies = 0", ["[run] bodies = 0: must be at least 1"]),
        ("[scene]", "[scene", ["is not valid TOML"]),
    ],
)
def test_mistakes_in_a_file_tell_the_place(line: str, instead: str, parts: list[str]) -> None:
    assert line in SPEC
    with pytest.raises(SpecError) as caught:
        parse_report(SPEC.replace(line, instead, 1), "small.toml")
    for part in ["small.toml: ", *parts]:
        assert part in str(caught.value)


def test_the_command_writes_data_and_picture_and_prints_the_table(
    folder: Path, capsys: Capture
) -> None:
    assert main(["report", "small.toml", "--seconds", "0.3", "--no-progress"]) == 0
    output, errors = capsys.readouterr()
    assert errors == ""
    names = {path.name for path in folder.iterdir()} - {"small.toml"}
    assert names == {"report-small.json", "report-small.png"}
    assert (folder / "report-small.png").read_bytes().startswith(b"\x89PNG\r\n")
    result = rigid.Report.from_json((folder / "report-small.json").read_text(encoding="utf-8"))
    assert output.startswith(str(result))
    assert result.spec.title == "A small report"
    assert set(result.methods) == {"exact", "rk4"}


@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_an_interrupted_command_saves_the_runs_that_are_done(
    number: signal.Signals,
    code: int,
    folder: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: Capture,
) -> None:
    def press(progress: rigid.Progress) -> None:
        os.kill(os.getpid(), number)

    def interrupted(spec: ReportSpec, **options: Any) -> rigid.Report:
        return run_report(spec, **{**options, "progress": press})

    monkeypatch.setattr("rigid.cli.run_report", interrupted)
    with sigint(signal.default_int_handler):
        assert main(["report", "small.toml"]) == code
    output, errors = capsys.readouterr()
    assert errors == "rigid: interrupted; the report written is partial\n"
    saved = rigid.Report.from_json((folder / "report-small.json").read_text(encoding="utf-8"))
    assert not saved.complete
    assert saved.rows
    assert output.startswith(str(saved))


def test_options_of_the_command(folder: Path) -> None:
    arguments = ["--seconds", "0.3", "--method", "rk4", "--out", "there.json"]
    assert main(["report", "small.toml", *arguments]) == 0
    result = rigid.Report.from_json((folder / "there.json").read_text(encoding="utf-8"))
    assert result.methods == ("rk4",)
    assert (folder / "there.png").exists()


def test_built_in_reports_are_listed(capsys: Capture) -> None:
    assert main(["reports"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines] == names_of("report")
    assert {"asymmetric-top", "earth", "fast-top", "lagrange-top", "thrown-box"} <= set(
        names_of("report")
    )


@pytest.mark.parametrize(
    ("arguments", "part"),
    [
        (["thrown-bix"], "no built-in report is called 'thrown-bix'; did you mean 'thrown-box'?"),
        (["small.toml", "--method", "rk5"], "methods[0] = 'rk5'"),
        (["small.toml", "--seconds", "0"], "seconds = 0.0: must be positive"),
        (["small.toml", "--out", "no/where"], "--out: there is no directory 'no'"),
    ],
)
@pytest.mark.usefixtures("folder")
def test_mistakes_on_the_command_line_are_one_line(
    arguments: list[str], part: str, capsys: Capture
) -> None:
    assert main(["report", *arguments]) == 2
    output, errors = capsys.readouterr()
    assert output == ""
    assert errors.startswith("rigid: ")
    assert part in errors
    assert errors.count("\n") == 1


def test_the_columns_of_a_table_tell_their_units(box: rigid.Report) -> None:
    report = timed(box, {"rk4": [100.0] * 3, "dop853": [300.0] * 3})
    lines = str(report).splitlines()
    costs = next(k for k, line in enumerate(lines) if line.startswith("* cheapest"))
    assert lines[costs].split()[-2:] == ["ns/s", "at"]
    assert lines[costs + 1].split() == ["order", "1e-03"]
    front = next(k for k, line in enumerate(lines) if line.startswith("front"))
    units = ["ns/s", "rad", "rad", "rel.", "rel."]
    assert lines[front + 1].split() == units
