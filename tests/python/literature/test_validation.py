"""Numbers of the literature, each beside the number of the library."""

import json
import sys
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

import rigid
from printed_text import unwrapped
from rigid.cli import main
from rigid.literature import detumbling
from rigid.literature.detumbling import GAIN, hours_of_tumbling, moments, moved, satellites
from rigid.literature.entry import Entry
from rigid.literature.heavy_tops import goryachev_chaplygin_change, kovalevskaya_change
from rigid.literature.spin_orbit import HYPERION, about_normal, growing_states, in_orbits
from rigid.literature.validation import Compared, entries

ENTRIES = {entry.name: entry for entry in entries()}


#: Sixteen satellites tumble in tests/long, four here.
SATELLITES = ("delfi-pq-mean", "delfi-pq-median")


@pytest.mark.parametrize("name", [name for name in ENTRIES if name not in SATELLITES])
def test_numbers_are_those_of_the_literature(name: str) -> None:
    """Within the interval of the entry; where a model differs the entry says why, and it does."""
    (row,) = rigid.validation(name, progress=False).rows
    assert row.entry is ENTRIES[name]
    assert row.agrees != bool(row.entry.reason), row.number
    assert row.explained, row.number


def test_four_satellites_tumble_as_long_as_those_of_the_literature(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Mean and median of four scatter twice as much as those of sixteen."""
    pytest.importorskip("numba")
    monkeypatch.setattr(detumbling, "hours_of_tumbling", partial(hours_of_tumbling, 4))
    for row in rigid.validation(SATELLITES, progress=False).rows:
        assert abs(row.difference) <= 2.0 * row.entry.within
    # They stop in any minute of an hour.
    assert np.ptp(hours_of_tumbling(4) % 1.0) > 0.25


@pytest.mark.parametrize("entry", ENTRIES.values(), ids=list(ENTRIES))
def test_every_number_can_disagree(entry: Entry) -> None:
    """Its interval is small beside it; a reason explains the number of its model alone."""
    assert entry.within <= max(0.3 * abs(entry.value), 1e-9)
    assert (not entry.reason) == np.isnan(entry.model)
    for wrong in (0.5 * entry.value - 0.1, 1.5 * entry.value + 0.1):
        row = Compared(entry=entry, number=wrong, seconds=0.0)
        assert not row.explained
        assert row.verdict == "differs"


@pytest.mark.parametrize("entry", ENTRIES.values(), ids=list(ENTRIES))
def test_an_entry_has_the_number_as_it_is_printed(entry: Entry) -> None:
    assert entry.source
    assert entry.seen
    if entry.digits is None:
        assert not entry.printed.replace(".", "").isdigit()
        return
    assert float(entry.digits) == entry.value
    unit = 10.0 ** -len(entry.digits.partition(".")[2])
    if " ± " in entry.printed:
        assert entry.within == float(entry.printed.split(" ± ")[1])
    elif entry.interval == "rounding":
        assert entry.within == pytest.approx(0.5 * unit)


def test_names_are_distinct() -> None:
    assert len(ENTRIES) == len(entries()) > 20


def test_neighbours_of_integrable_tops_keep_no_fourth_integral() -> None:
    """Kovalevskaya's moments alone, and for Goryachev and Chaplygin also L·gamma = 0."""
    assert kovalevskaya_change() < 1e-9
    assert kovalevskaya_change((2.0, 2.1, 1.0)) > 0.1
    assert goryachev_chaplygin_change() < 1e-9
    assert goryachev_chaplygin_change((4.0, 4.2, 1.0)) > 0.1
    assert goryachev_chaplygin_change(l_gamma=0.5) > 0.1


def test_a_moon_that_is_nearly_round_keeps_its_plane() -> None:
    """Where Hyperion leaves it."""
    assert growing_states((0.97, 0.99, 1.0)) == 0.0
    assert growing_states() == 2.0


def test_deviations_of_hyperion_in_the_plane_grow_by_the_equation_in_the_plane() -> None:
    """``theta'' = -3/2 (B - A)/C (a/r)³ sin 2(theta - f)`` and its linear equation, by SciPy."""
    turn, e, rate = 2.0 * np.pi, 0.1, 2.0 * np.pi * 1.5
    strength = 1.5 * (HYPERION[1] - HYPERION[0]) * turn**2

    def change(_t: float, y: np.ndarray) -> list[float]:
        theta, omega, anomaly, angle, swing = y
        near = 1.0 / (1.0 - e * np.cos(anomaly))
        f = np.arctan2(np.sqrt(1.0 - e * e) * np.sin(anomaly), np.cos(anomaly) - e)
        torque = -strength * near**3
        sine, cosine = np.sin(2.0 * (theta - f)), np.cos(2.0 * (theta - f))
        return [omega, torque * sine, turn * near, swing, 2.0 * torque * cosine * angle]

    t = np.array([2.0, 4.0, 6.0])
    start = [0.0, rate, 0.0, 0.0, 1.0]
    found = solve_ivp(change, (0.0, 6.0), start, "DOP853", t, rtol=1e-12, atol=1e-12)
    size = np.hypot(found.y[3], found.y[4] / rate) * rate
    growth = rigid.lyapunov(
        in_orbits(HYPERION, e), about_normal(1.5), t=t, start=[[0.0, 0.0, 1.0, 0.0, 0.0, 0.0]]
    )
    assert size[-1] > 30.0
    # Both lose 30 to 100 times their error of 1e-11.
    np.testing.assert_allclose(growth.log_growth, np.log(size), rtol=0.0, atol=1e-8)


def test_what_differs_without_a_reason_is_found(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    wrong = replace(ENTRIES["toutatis-precession"], value=7.50)
    both = (wrong, ENTRIES["toutatis-rotation"])
    monkeypatch.setattr("rigid.literature.validation.entries", lambda: both)
    names = ["toutatis-rotation", "toutatis-precession"]
    found = rigid.validation(names, progress=False)
    assert [row.entry.name for row in found.rows] == names
    assert found.unexplained == (found.rows[1],)
    assert found.rows[1].difference == pytest.approx(-0.1, abs=1e-3)
    assert repr(found) == (
        "<Validation: 2 numbers: 1 agree, 0 of models that differ, 1 unexplained>"
    )
    assert main(["validation", *names, "--no-progress"]) == 1
    assert "differs" in capsys.readouterr().out
    assert main(["validation", names[0], "--no-progress"]) == 0


def test_the_command_prints_numbers_for_other_programs(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["validation", "earth-chandler", "--json", "--no-progress"]) == 0
    (row,) = json.loads(capsys.readouterr().out)["numbers"]
    assert row["value"] == 435.2
    assert row["number"] == pytest.approx(304.46, abs=0.01)
    assert row["agrees"] is False
    assert "not rigid" in row["reason"]


def test_the_table_has_a_row_for_each_number_and_the_reasons_below() -> None:
    entry = ENTRIES["earth-chandler"]
    row = Compared(entry=entry, number=304.45591, seconds=0.0)
    lines = str(rigid.Validation((row,))).splitlines()
    assert lines[0].split() == ["name", "published", "here", "off", "by", "interval", "unit"]
    assert lines[1].split()[:4] == ["earth-chandler", "435.2", "304.456", "-1.3e+02*"]
    assert unwrapped("\n".join(lines[3:]), 2) == (
        f"* earth-chandler: the model differs; {entry.reason}"
    )
    formula = Compared(entry=ENTRIES["flip-period"], number=2.0, seconds=0.0).cells()
    assert float(formula[1]) == pytest.approx(ENTRIES["flip-period"].value)
    assert row.command == "rigid validation earth-chandler"
    assert rigid.Validation((row,))._repr_html_().count("<tr>") == 2


def test_an_unknown_number_is_refused() -> None:
    with pytest.raises(ValueError, match=r"names = 'toutatis': did you mean 'toutatis-rotation'\?"):
        rigid.validation("toutatis")


def test_a_number_that_only_compiled_code_reaches_is_left_out_without_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    both = (ENTRIES["delfi-pq-mean"], ENTRIES["toutatis-rotation"])
    monkeypatch.setattr("rigid.literature.validation.entries", lambda: both)
    monkeypatch.setitem(sys.modules, "numba", None)
    assert [row.entry for row in rigid.validation(progress=False).rows] == [both[1]]
    with pytest.raises(ImportError, match=r"delfi-pq-mean needs numba: pip install '.*\[numba\]'"):
        rigid.validation("delfi-pq-mean", progress=False)


# The coils of Delfi-PQ, and the steps by which they seem to stop it.


TUMBLING = np.full(3, np.pi)
START = np.array([0.0, 1.0, 0.0, 0.0])


def nominal(begun: float = 0.0) -> np.ndarray:
    """The numbers of a satellite without errors, and with two equal moments."""
    equal = np.array(moments())
    equal[:2] = equal[:2].mean()
    return np.array([begun, *equal, *(3 * [0.002]), 6e-5, -8e-5, 0.0, GAIN * equal.min()])


def field(t: float) -> np.ndarray:
    """Dipole of the Earth in the axes of space (T), by rotations."""
    radius = 6728.137e3
    angle = np.radians(60.0) + np.sqrt(3.9860044181e14 / radius**3) * t
    plane = Rotation.from_euler("ZX", [210.0, 96.84895], degrees=True)
    up = plane.apply([np.cos(angle), np.sin(angle), 0.0])
    years = 2018.0 + 212.0 / 365.0 - 2015.0
    of_earth = [-1501.0 + 18.1 * years, 4797.1 - 26.6 * years, -29442.0 + 10.3 * years]
    day = 86400.0 * 365.24 / 366.24
    dipole = Rotation.from_euler("Z", 2.0 * np.pi * t / day).apply(of_earth)
    return np.asarray(1e-9 * (6371.2e3 / radius) ** 3 * (3.0 * (dipole @ up) * up - dipole))


def after_cycles(data: np.ndarray, omega: np.ndarray, cycles: int) -> np.ndarray:
    """Rates after cycles in which the coils hold their dipole, by DOP853 of SciPy."""
    body, most, stays, gain = data[1:4], data[4:7], data[7:10], data[10]

    def change(t: float, y: np.ndarray, dipole: np.ndarray) -> np.ndarray:
        rates, (x, y_, z, w) = y[:3], y[3:]
        here = Rotation.from_quat(y[3:]).inv().apply(field(data[0] + t))
        torque = np.cross(dipole, here) - np.cross(rates, body * rates)
        a, b, c = 0.5 * rates
        turn = [w * a + y_ * c - z * b, w * b + z * a - x * c, w * c + x * b - y_ * a]
        return np.array([*(torque / body), *turn, -x * a - y_ * b - z * c])

    def later(t: float, y: np.ndarray, dipole: np.ndarray, time: float) -> np.ndarray:
        made = solve_ivp(change, (t, t + time), y, "DOP853", rtol=1e-11, atol=1e-13, args=(dipole,))
        return np.asarray(made.y[:, -1])

    def reading(t: float, y: np.ndarray) -> tuple[np.ndarray, float]:
        here = Rotation.from_quat(y[3:]).inv().apply(field(data[0] + t))
        size = float(np.linalg.norm(here))
        return here / size, size

    state = np.array([*omega, *START[1:], START[0]])
    before, _ = reading(-0.25, later(0.0, state, np.zeros(3), -0.25))
    for cycle in range(cycles):
        t = 0.25 * cycle
        now, size = reading(t, state)
        wanted = -gain * (now - before) / 0.25 / size
        on = 0.25 * 0.6 * np.minimum(1.0, np.abs(wanted) / most)
        dipole = np.sign(wanted) * (on - 0.01) * most / 0.25
        state, before = later(t, state, dipole + stays, 0.25), now
    return state[:3]


@pytest.mark.parametrize("spin", [1.0, 0.04])
def test_coils_hold_their_dipole_from_reading_to_reading(spin: float) -> None:
    """As in a loop over cycles; the coils of slow bodies are partly on, those of fast ones full."""
    data, cycles = nominal(9000.0), 24
    t = np.array([0.25 * cycles])
    run = moved(data, spin * TUMBLING, START, t, step=1.0 / 64.0)
    free = rigid.simulate(rigid.Body(data[1:4]), spin * TUMBLING, START, t=t)
    found = run.omega[0] - free.omega[0]
    truth = after_cycles(data, spin * TUMBLING, cycles) - free.omega[0]
    # The field of now stands for that of the readings. On the orbit it turns by at most
    # 3 n T = 9e-4 rad in a cycle, and its size changes by less; the body turns by 1.4 or 0.05 rad.
    turn = 0.25 * float(np.linalg.norm(spin * TUMBLING))
    bound = 9e-4 * (1.0 + 1.0 / turn) * np.abs(truth).max()
    np.testing.assert_allclose(found, truth, rtol=0.0, atol=bound)


def test_the_error_of_the_source_takes_the_energy_of_a_body_that_no_torque_slows() -> None:
    """More than a third in an hour. In a time it goes as the fifth power of the step of rk4."""
    body = rigid.Body(moments())
    lost = []
    for step in (1.0 / 8.0, 1.0 / 16.0, 1.0 / 64.0):
        run = rigid.simulate(body, TUMBLING, t=[0.0, 3600.0], method="rk4", step=step, check=False)
        energy = run.energy()
        lost.append(1.0 - energy[1] / energy[0])
    assert lost[0] > 0.35
    # The next order, and the slowing itself: 1.6 % of the energy.
    assert lost[1] / lost[2] == pytest.approx(4.0**5, rel=0.02)


def test_accurate_steps_lose_less_than_a_hundredth_in_the_hour() -> None:
    """A coil that is held while the body turns by 1.4 rad hardly brakes it."""
    pytest.importorskip("numba")
    left = []
    for step in (1.0 / 8.0, 1.0 / 64.0):
        run = moved(nominal(), TUMBLING, START, np.array([0.0, 3600.0]), step)
        energy = run.energy()
        left.append(energy[1] / energy[0])
    assert left[0] < 0.65
    assert left[1] > 0.99


def test_moments_are_those_of_the_stored_runs() -> None:
    """Means of the 500 runs; those of the masses err by 17 % / √500."""
    assert moments() == pytest.approx([1.722e-3, 1.711e-3, 0.263e-3], rel=0.02)
    drawn = satellites(500, 1)[:, 1:4]
    assert drawn.mean(axis=0) == pytest.approx(moments(), rel=0.01)
    # 1/6 of the mass and 5 % of each moment.
    assert drawn.std(axis=0) / moments() == pytest.approx(np.hypot(1.0 / 6.0, 0.05), rel=0.05)
