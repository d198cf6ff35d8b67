"""Reports over revolutions: what methods keep of energy, momentum and phase."""

import dataclasses
import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rigid
from physics import ROUNDOFF, golden_scene, rotated, rotation_angle
from printed_text import refused_in
from refusals import refuses
from rigid.cli import main
from rigid.reports import compute, sweep
from rigid.reports.ensemble import ensemble_of
from rigid.reports.reference import Horizon, Reference
from rigid.reports.spec import REVOLUTIONS, make_spec
from rigid.reports.table import in_short

DOCS = Path(__file__).parents[3] / "docs"
BODY = rigid.FreeBody(rigid.Body((1.0, 1.5, 2.0)))
OMEGA = (1.0, 0.2, 0.3)
LAGRANGE = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.4)), mgl=1.0)
#: Seconds that no run of these tests needs, also on a slow machine: it ends when it is done.
ENOUGH = 600.0


def long(
    scene: Any, omega: Any, counts: list[float], methods: list[str], seconds: float = ENOUGH
) -> rigid.Report:
    return rigid.report(
        scene, omega, revolutions=counts, methods=methods, seconds=seconds, progress=False
    )


@pytest.fixture(scope="module")
def free() -> rigid.Report:
    """A free body, over up to a thousand revolutions."""
    methods = ["rk4", "splitting", "dmv10", "midpoint", "taylor16"]
    return long(BODY, OMEGA, [10, 100, 1000], methods)


def rows_at(result: rigid.Report, method: str, angle: float) -> tuple[rigid.Row, ...]:
    """The rows of a step over each number of revolutions."""
    (row,) = (row for row in result.of(method) if row.angle == angle)
    return result.growth(row)


# Growth: what theory says


def test_on_an_orbit_methods_are_compared_by_the_phase_where_no_drift_is_known() -> None:
    """``rk4`` has the order 4 there too: half the step errs by a sixteenth."""
    moon = rigid.FreeBody(rigid.Body((1.0, 1.2, 1.5)), orbit=rigid.Orbit(0.2, 0.2))
    result = long(moon, OMEGA, [1, 2], ["rk4", "dop853", "taylor20"])
    assert not result.refused
    # In shorter steps rounding, in longer ones the next order would show.
    coarse, fine = (rows_at(result, "rk4", angle)[-1].phase for angle in (0.25, 0.125))
    assert coarse / fine == pytest.approx(16.0, rel=0.25)
    text = str(result)
    assert not re.search(r"\b(inf|nan|lost)\b", text)
    assert re.search(r"^energy.*\nrk4 +\S+ +\S+ +- +-$", text, re.MULTILINE)
    assert str(rigid.Report.from_json(result.to_json())) == text


def test_the_energy_of_a_symplectic_method_stays_and_that_of_runge_kutta_goes(
    free: rigid.Report,
) -> None:
    """Backward analysis: a symplectic method keeps an energy close to that of the body.

    Of a periodic motion every revolution of ``rk4`` loses the same, beside an oscillation: from 100
    to 1000 revolutions ten times as much as from 10 to 100, as far as the loss is small.
    """
    for row in free.of("splitting"):
        first, _, third = (one.energy_drift for one in free.growth(row))
        assert third <= 1.1 * first
    for row in free.of("rk4"):
        first, second, third = (one.energy_drift for one in free.growth(row))
        if third < 1e-2:
            assert (third - second) / (second - first) == pytest.approx(10.0, rel=0.03)


def test_the_phase_of_a_symplectic_method_drifts_and_that_of_runge_kutta_accelerates(
    free: rigid.Report,
) -> None:
    """A wrong but constant rate makes an error as t, an energy that goes as t one as t**2."""
    first, second, third = (row.phase for row in rows_at(free, "splitting", 0.0625))
    assert (third - second) / (second - first) == pytest.approx(10.0, rel=0.03)
    first, second, third = (row.phase for row in rows_at(free, "rk4", 0.125))
    square = (second / 100.0 - first / 10.0) / 90.0
    linear = first / 10.0 - 10.0 * square
    assert third == pytest.approx(1000.0 * linear + 1000.0**2 * square, rel=0.05)
    assert 1000.0 * square > linear


def test_discrete_moser_veselov_and_midpoint_conserve_to_rounding(free: rigid.Report) -> None:
    """Each step rounds energy and momentum by some units in the last place, all alike at worst."""
    for method in ("dmv10", "midpoint"):
        for row in free.of(method):
            drift = max(row.energy_drift, row.momentum_drift)
            assert drift < 4.0 * 2.0 * ROUNDOFF * max(row.steps, 100)
    # Compensated sums do not even add up.
    assert rows_at(free, "taylor16", 0.25)[2].energy_drift < 50.0 * ROUNDOFF


# What is measured


def states(result: rigid.Report, method: str, angle: float, leg: int) -> rigid.Run:
    """The ensemble, run as the row says, at the end of each of its steps."""
    t_end = math.tau * result.spec.revolutions[leg] / math.hypot(*result.spec.omega)
    ensemble = ensemble_of(dataclasses.replace(result.spec, t_end=t_end))
    steps = math.ceil(math.tau * result.spec.revolutions[leg] / angle)
    times = np.linspace(0.0, t_end, steps + 1)
    step = 1.0001 * times[1]
    return rigid.simulate(
        result.spec.scene, ensemble.omega, result.spec.attitude, t=times, method=method, step=step
    )


@pytest.mark.parametrize("method", ["rk4", "splitting"])
def test_errors_are_those_of_energy_momentum_and_attitude(free: rigid.Report, method: str) -> None:
    row = rows_at(free, method, 0.25)[1]
    run: Any = states(free, method, 0.25, 1)
    momentum = np.array(BODY.body.moments) * run.omega
    energy = 0.5 * (momentum * run.omega).sum(axis=-1)
    in_space = rotated(run.attitude, momentum)
    drift = np.abs(energy / energy[:, :1] - 1.0).max()
    length = np.linalg.norm(in_space[:, :1], axis=-1)
    off = (np.linalg.norm(in_space - in_space[:, :1], axis=-1) / length).max()
    truth: Any = rigid.simulate(BODY, run.start_omega, t=[run.t[-1]], method="exact")
    phase = rotation_angle(run.attitude[:, -1], truth.attitude[:, -1]).max()
    assert row.phase == pytest.approx(phase, rel=1e-6)
    # 256 times of 2514 steps see less than all, but at least half of an oscillation.
    for seen, largest in ((row.energy_drift, drift), (row.momentum_drift, off)):
        assert 0.5 * largest - 100 * ROUNDOFF < seen < 1.0001 * largest + 100 * ROUNDOFF


def test_the_momentum_of_a_top_is_that_about_the_vertical_and_its_axis() -> None:
    result = long(LAGRANGE, (0.3, 0.1, 3.0), [20], ["rk4"])
    (row,) = rows_at(result, "rk4", 0.25)
    run: Any = states(result, "rk4", 0.25, 0)
    momentum = np.array(LAGRANGE.body.moments) * run.omega
    vertical = (momentum * run.gamma).sum(axis=-1)
    scale = np.linalg.norm(momentum[:, 0], axis=-1) + math.sqrt(1.0 * 1.0)  # mgl and I1
    off = [np.abs(of - of[:, :1]).max(axis=1) / scale for of in (vertical, momentum[..., 2])]
    largest = float(np.max(off))
    assert largest > 1e-4
    assert 0.5 * largest < row.momentum_drift < 1.0001 * largest


def test_the_energy_of_a_damped_top_is_compared_with_the_work() -> None:
    scene = rigid.HeavyTop(rigid.Body((1.0, 1.6, 0.7)), mgl=1.2, damping=0.02)
    result = long(scene, (0.4, 0.7, 2.0), [10], ["taylor16"])
    (row,) = rows_at(result, "taylor16", 0.25)
    run = states(result, "taylor16", 0.25, 0)
    lost = np.abs(run.energy()[:, -1] / run.energy()[:, 0] - 1.0)
    assert lost.min() > 0.1
    # Some units in the last place of each of 252 steps, all alike at worst.
    assert row.energy_drift < 16.0 * ROUNDOFF * 252
    assert "largest error of its balance" in str(result)


def test_states_are_looked_at_256_times_that_keep_step_with_no_period() -> None:
    """The time k lies in the k-th of 256 parts, at the fraction of k times the golden ratio."""
    ensemble = ensemble_of(make_spec(BODY, OMEGA, revolutions=[10], bodies=2))
    run = ensemble.run("rk4", 25_600)
    k = np.arange(256)
    ratio = (1.0 + math.sqrt(5.0)) / 2.0
    seen = np.rint(100.0 * (k + (k * ratio) % 1.0))
    np.testing.assert_allclose(run.t[:-1] * 25_600 / run.t[-1], seen, rtol=1e-9)
    assert run.t[-1] == ensemble.spec.t_end
    assert run.steps.tolist() == [25_600] * 2


def test_no_phase_below_the_uncertainty_of_the_reference_is_told(free: rigid.Report) -> None:
    assert [reference.method for reference in free.references] == ["exact"] * 3
    for count, reference in zip(free.spec.revolutions, free.references, strict=True):
        assert reference.worst >= 1e-15 * math.tau * count
        phases = [row.phase for row in free.rows if row.revolutions == count]
        assert min(phases) >= reference.worst
        assert count > 10 or min(phases) == reference.worst
    assert re.search(r"^taylor16 .*<\d", str(free), re.MULTILINE)


def test_the_phase_of_a_chaotic_motion_is_not_told() -> None:
    case = golden_scene("heavy_asymmetric/chaotic_strong")
    result = rigid.report(
        case.scene,
        case.omega0,
        case.attitude0,
        revolutions=[3, 300, 600],
        methods=["dop853"],
        seconds=ENOUGH,
        progress=False,
    )
    known, lost, unknown = result.references
    assert known.worst < 1e-9
    assert lost.worst >= 1.0
    assert (unknown.method, unknown.worst) == ("", math.inf), "none is looked for"
    for row in result.rows:
        assert (row.phase < 1.0) == (row.revolutions == 3)
        assert math.isfinite(row.phase) == (row.revolutions < 600)
    assert "lost over 300, as in chaos" in str(result)
    assert rigid.Report.from_json(result.to_json()) == result
    # No phase at all: then there is no column and no panel of it.
    none = dataclasses.replace(
        result,
        references=(lost, unknown, unknown),
        rows=tuple(dataclasses.replace(row, phase=math.inf) for row in result.rows),
    )
    assert "The least phase" not in str(none)
    assert "no phase is known" in str(none)
    assert none.plot().shape == (2, 2)


@pytest.mark.parametrize(
    ("errors", "following"),
    [
        ([], 16.0),
        ([(1e-4, 1e-4, 1e-2)], 8.0),
        ([(1e-3, 1e-4, 1e-2)], 8.0),  # lost
        ([(1e-4, 1e-4, 1e-2), (0.6e-4, 0.6e-4, 0.6e-2)], "rounding"),
        ([(1e-4, 1e-4, 1e-2), (0.4e-4, 0.6e-4, 0.6e-2)], 4.0),
        ([(1e-4, 1e-4, 1e-2), (0.6e-4, 0.4e-4, 0.6e-2)], 4.0),
        ([(1e-4, 1e-4, 1e-2), (0.6e-4, 0.6e-4, 0.4e-2)], 4.0),
        # Half of the best before, not of the last one.
        ([(1e-6, 1e-6, 1e-2), (1e-4, 1e-4, 1e-1), (0.6e-6, 0.6e-6, 0.6e-2)], "rounding"),
        # Rounding, a lost phase, and one below the uncertainty of the reference show nothing.
        ([(4e-13, 4e-13, 2.0), (1e-15, 1.0, 1.5)], 4.0),
        ([(2e-13, 2e-13, 2.0), (1e-15, 1e-15, 1.5)], "rounding"),
        ([(1e-15, 1e-15, 2e-9), (1e-15, 1e-15, 1e-12)], "rounding"),
        ([(1e-15, 1e-15, 4e-9), (1e-15, 1e-15, 1e-12)], 4.0),
        # A lost step after others of use.
        ([(1e-4, 1e-4, 1e-2), (1e-2, 1e-2, 1e-2)], 4.0),
        ([(1e-2, 1e-2, 1e-2)] * 9, "shortest step"),
    ],
)
def test_steps_are_halved_until_no_error_falls(
    errors: list[tuple[float, float, float]], following: float | str
) -> None:
    """Of energy, momentum and phase, in steps of 16 rad and shorter, down to 1/16 rad."""
    ensemble = ensemble_of(make_spec(BODY, OMEGA, revolutions=[10]))
    horizon = Horizon(10.0, ensemble, Reference("exact", 0, 1e-10, 1e-9), None)
    one = sweep.Sweep("rk4")
    for k, (energy, momentum, phase) in enumerate(errors):
        angle = 2.0 ** (4 - k)
        steps, state = math.ceil(20.0 * math.pi / angle), np.full(32, phase)
        one.runs[steps] = [sweep.Measured(steps, state, state, energy, momentum, 1.0, angle)]
    found = one.next_steps(horizon)
    if isinstance(following, str):
        assert (found, one.ended) == (None, following)
    else:
        assert found == (math.ceil(20.0 * math.pi / following), following)


# What is said of it


def test_rows_go_from_long_steps_to_short_ones_that_are_of_use(free: rigid.Report) -> None:
    assert free.complete
    for method in free.methods:
        angles = [row.angle or 0.0 for row in free.of(method)]
        assert angles == sorted(angles, reverse=True)
        # Moser-Veselov steps refuse more than a radian.
        assert angles[0] <= (1.0 if method == "dmv10" else 16.0)
        for row in free.of(method):
            drifts = [one.energy_drift for one in free.growth(row)]
            assert len(drifts) == 3
            assert drifts[0] < sweep.LOST_ENERGY
            assert drifts == sorted(drifts)
            assert row.nanoseconds > 0.0
    assert free.of("rk4") != ()


def test_the_common_time_is_the_least_that_every_method_needs(free: rigid.Report) -> None:
    rows = free.at_common_time()
    assert [row.method for row in rows] == list(free.methods)
    assert all(row.nanoseconds <= free.common_time for row in rows)
    assert free.common_time in {row.nanoseconds for row in free.rows}


@pytest.mark.parametrize(("longer", "horizon"), [(4, 100), (3, 100), (2, 10), (0, 10)])
def test_the_horizon_is_what_three_of_four_steps_were_run_over(
    free: rigid.Report, longer: int, horizon: float
) -> None:
    steps = [row for row in free.rows if row.method == "rk4" and row.revolutions == 10][:4]
    further = [one for step in steps[:longer] for one in free.growth(step)[1:2]]
    some = dataclasses.replace(free, rows=(*steps, *further))
    assert len(steps) == 4
    assert some.horizon == horizon
    assert {row.revolutions for row in some.of("rk4")} == {horizon}


def test_the_front_is_not_dominated(free: rigid.Report) -> None:
    front = free.front("phase")
    assert front
    for row in front:
        assert not any(
            other.nanoseconds < row.nanoseconds and other.phase < row.phase
            for other in free.rows
            if other.revolutions == row.revolutions == 1000
        )


def test_same_steps_are_one_row_and_what_is_refused_is_listed() -> None:
    result = long(LAGRANGE, (0.3, 0.1, 3.0), [5], ["rk4", "etd4", "dmv2"])
    assert result.methods == ("rk4",)
    assert result.same == {"rk4": ("etd4",)}
    assert result.of("etd4") == result.of("rk4")
    assert "free bodies only" in result.refused["dmv2"]
    assert "not for     dmv2" in str(result)


def test_a_method_that_keeps_nothing_is_listed(monkeypatch: pytest.MonkeyPatch) -> None:
    for module in (sweep, compute):
        monkeypatch.setattr(module, "ANGLES", (2.0,))
    result = long(BODY, OMEGA, [1000], ["rk4"])
    assert result.rows == ()
    assert result.refused["rk4"] == (
        "no step down to 2.0 rad that there was time for keeps the energy"
    )
    assert "not for     rk4" in str(result)
    assert result.plot().shape == (2, 2)


def test_what_there_was_no_time_for_is_left_open() -> None:
    result = rigid.report(
        BODY, OMEGA, revolutions=[10, 1e9], methods=["rk4"], seconds=0.5, progress=False
    )
    assert result.complete
    assert {row.revolutions for row in result.rows} == {10}
    assert result.horizon == 10
    assert re.search(r"^rk4 .* -$", str(result), re.MULTILINE)


def test_no_reference_is_looked_for_beyond_the_time() -> None:
    """A thousand million revolutions by a series of order 26 in 50 steps each take hours."""
    top = rigid.HeavyTop(rigid.Body((1.0, 1.6, 0.7)), mgl=0.01)
    result = long(top, (0.1, 0.2, 2.0), [5, 1e9], ["rk4"], seconds=60.0)
    assert [reference.method for reference in result.references] == ["taylor26", ""]
    assert all((row.phase < 1.0) == (row.revolutions == 5) for row in result.rows)
    assert "no time to find it over 1e9" in str(result)
    hasty = long(top, (0.1, 0.2, 2.0), [1e5], ["rk4"], seconds=1e-3)
    assert [reference.method for reference in hasty.references] == [""]
    assert "reference   no time to find it" in str(hasty)


def test_the_picture_has_a_panel_for_each_error_against_time_and_against_revolutions(
    free: rigid.Report,
) -> None:
    grid = free.plot()
    assert grid.shape == (2, 3)
    for ax in grid.flat:
        assert ax.get_xscale() == ax.get_yscale() == "log"
        assert ax.get_ylabel().startswith("error of the ")
        names = {text.get_text() for text in ax.texts if text.get_text() in free.methods}
        assert names
        assert names <= {line.get_label() for line in ax.lines}
    energy, momentum, _ = grid[0]
    for ax in (energy, momentum):  # the phase of some is lost
        assert {text.get_text() for text in ax.texts} >= set(free.methods)
    assert all(ax.get_xlim()[0] < 10 < 1000 < ax.get_xlim()[1] for ax in grid[1])


@pytest.mark.parametrize(
    ("count", "words"), [(1e6, "1e6"), (1e3, "1e3"), (100.0, "100"), (2.5e4, "25000")]
)
def test_numbers_of_revolutions_are_short(count: float, words: str) -> None:
    assert in_short(count) == words


# Progress, interruption, bad input, the command


@pytest.mark.parametrize("partial", [False, True])
def test_an_interruption_leaves_what_is_known(
    partial: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    # Ctrl-C after the first runs of each step, before they are made longer.
    monkeypatch.setattr("rigid.reports.compute.lengthen", interrupted)
    request: dict[str, Any] = {"revolutions": [1000], "methods": ["rk4"], "seconds": 1.0}
    if partial:
        result = rigid.report(BODY, OMEGA, partial=True, **request)
    else:
        with pytest.raises(rigid.Interrupted, match="'partial' of this exception") as caught:
            rigid.report(BODY, OMEGA, **request)
        result = caught.value.partial
    assert not result.complete
    assert result.rows
    assert "the run is partial" in str(result)
    assert "partial" in repr(result)


def test_an_interruption_before_the_first_run_leaves_nothing() -> None:
    def press(*_: object) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt) as caught:
        rigid.report(BODY, OMEGA, revolutions=[10], seconds=1e-3, progress=press, partial=True)
    assert not isinstance(caught.value, rigid.Interrupted)


test_mistakes_name_argument_value_and_rule = refuses(
    [
        ({"omega": (0.0, 0.0, 0.0)}, r"omega = \[0.0, 0.0, 0.0\]: must not be zero; a long"),
        ({"revolutions": []}, "revolutions: expected shape .* with at least one number"),
        ({"revolutions": 10.0}, "revolutions: expected shape"),
        (
            {"revolutions": [10, 10]},
            r"revolutions\[1\] = 10.0: must be above 10 and at most 1e\+09",
        ),
        ({"revolutions": [0]}, r"revolutions\[0\] = 0.0: must be above 0"),
        (
            {"revolutions": [np.nextafter(1e9, np.inf)]},
            r"revolutions\[0\] = 1000000000.0000001: must be above 0 and at most 1e\+09",
        ),
        ({"methods": ["exact"]}, r"methods = \['exact'\]: none .*: exact: makes no steps"),
        (
            {"scene": LAGRANGE, "methods": ["dmv2"]},
            "none integrates the scene: dmv2: .*free bodies",
        ),
    ],
    by=lambda change: rigid.report(
        **{"scene": BODY, "omega": OMEGA, "revolutions": [10], "seconds": 0.1, **change}
    ),
)


def test_the_command_writes_data_and_picture_and_prints_the_table(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    arguments = ["--long", "--method", "rk4", "--seconds", "0.2", "--no-progress"]
    assert main(["report", "thrown-box", *arguments]) == 0
    names = {path.name for path in tmp_path.iterdir()}
    assert names == {"report-thrown-box-long.json", "report-thrown-box-long.png"}
    text = (tmp_path / "report-thrown-box-long.json").read_text(encoding="utf-8")
    result = rigid.Report.from_json(text)
    assert result.spec.revolutions == REVOLUTIONS
    assert capsys.readouterr().out.startswith(str(result))


@pytest.mark.parametrize(
    "path", sorted((DOCS / "reports").glob("*-long.txt")), ids=lambda p: p.stem
)
def test_the_table_in_the_docs_has_the_methods_of_today(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    known = {method.name for method in rigid.methods()}
    tables = text.partition("\n\n")[2]
    measured = set(re.findall(r"^([a-z]+\w*) +[\d.]+ ", tables, re.MULTILINE))
    refused = refused_in(text)
    assert measured <= known
    assert refused <= known
    assert {"rk4", "dop853", "midpoint"} <= measured
    assert path.with_suffix(".png").is_file()
    assert f"reports/{path.stem}.png" in (DOCS / "methods.md").read_text(encoding="utf-8")
