"""Numbers of the literature, each beside the number of the library."""

import json
import sys
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import rigid
from printed_text import unwrapped
from rigid.cli import main
from rigid.literature.entry import Entry
from rigid.literature.heavy_tops import goryachev_chaplygin_change, kovalevskaya_change
from rigid.literature.spin_orbit import HYPERION, about_normal, growing_states, in_orbits
from rigid.literature.validation import Compared, entries

ENTRIES = {entry.name: entry for entry in entries()}


@pytest.mark.parametrize("name", ENTRIES)
def test_numbers_are_those_of_the_literature(name: str) -> None:
    """Within the interval of the entry; where a model differs the entry says why, and it does."""
    if ENTRIES[name].needs:
        pytest.importorskip(ENTRIES[name].needs)
    (row,) = rigid.validation(name, progress=False).rows
    assert row.entry is ENTRIES[name]
    assert row.agrees != bool(row.entry.reason), row.number
    assert row.explained, row.number


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
