"""Extreme and stiff bodies by every method: right, flagged or refused."""

import dataclasses
import re
import time
from pathlib import Path

import pytest

import rigid
from printed_text import unwrapped
from refusals import refuses
from rigid import _core
from rigid.reports.stress_cases import cases

TABLE = Path(__file__).parents[3] / "docs" / "reports" / "extremes.txt"


@pytest.fixture(scope="module")
def found() -> rigid.Extremes:
    return rigid.extremes(progress=False)


def test_the_table_in_the_docs_has_the_cases_of_today() -> None:
    """Family by family: what a case is called says what is extreme, so a changed case shows."""
    rows = re.findall(r"^ ? ?\S.*?(?=\s{2}|$)", TABLE.read_text(encoding="utf-8"), re.MULTILINE)
    asked: list[str] = []
    for case in cases():
        if case.family not in asked:
            asked.append(case.family)
        asked.append(f"  {case.name}")
    assert rows[1 : len(asked) + 1] == asked


def test_no_answer_is_wrong_without_saying_so(found: rigid.Extremes) -> None:
    assert [(c.case.family, c.case.name, c.method, c.error) for c in found.wrong] == []
    assert "unknown" not in found.counts(), "a case without a truth shows nothing"
    # Most cells have an answer: flags and refusals are no way out.
    assert found.counts()["right"] > len(found.cells) / 2


def test_every_cell_has_a_verdict_and_a_reason(found: rigid.Extremes) -> None:
    verdicts = {"right", "flagged", "refused", "step limit", "not finite", "drifted"}
    for cell in found.cells:
        assert cell.verdict in verdicts
        assert cell.reason
        if cell.verdict == "right":
            assert cell.error <= cell.bound


def test_the_closed_form_is_right_wherever_there_is_one(found: rigid.Extremes) -> None:
    """Within 1e-13 and what rounding of the start does, which is four times 2^-53 condition."""
    exact = [c for c in found.cells if c.method == "exact" and c.verdict != "refused"]
    assert len(exact) > 60
    for cell in exact:
        if cell.verdict == "flagged":
            # 1e15 rad: rounding of the time alone is a tenth of a turn.
            assert abs(cell.case.t) >= 1e15
            continue
        assert cell.verdict == "right"
        assert cell.error < max(1e-13, cell.bound if cell.bound > 1e-8 else 1e-8 / 4)


def test_every_scene_without_damping_has_a_method_that_is_right(found: rigid.Extremes) -> None:
    asked = [case for case in cases() if case.step is None and abs(case.t) < 1e12]
    for case in asked:
        same = (case.family, case.name)
        mine = [c.verdict for c in found.cells if (c.case.family, c.case.name) == same]
        assert "right" in mine, (same, mine)


def test_the_table_counts_its_cells(found: rigid.Extremes) -> None:
    text = str(found)
    last = unwrapped(text, indent=2).splitlines()[-1]
    assert last.startswith(f"no undetected error in {len(found.cells):,} runs: ")
    assert f"{found.counts()['right']} right" in last
    wrong = dataclasses.replace(found.cells[0], verdict="undetected error")
    assert str(rigid.Extremes((wrong, wrong))).endswith("2 undetected errors in 2 runs")
    assert str(rigid.Extremes((wrong,))).endswith("1 undetected error in 1 run")
    assert sum(found.counts().values()) == len(found.cells)
    assert "omega = (1e-14, 1, 1e-14)" in text


def told(text: str) -> str:
    """The words of a table without the seconds, and without the digits of errors of rounding.

    The latter depend on the mathematical library that computes a start or a truth.
    """
    timeless = re.sub(r" \d+\.\d\b", "", text)
    return " ".join(re.sub(r"\de-1[4-9]", "rounding", timeless).split())


def test_the_table_in_the_docs_is_that_of_today(found: rigid.Extremes) -> None:
    """How many results are right, their largest error, and the verdicts of all others."""
    assert told(str(found)) == told(TABLE.read_text(encoding="utf-8"))


def test_one_family_by_one_method() -> None:
    some = rigid.extremes("near spherical", method="taylor16", progress=False)
    assert {cell.method for cell in some.cells} == {"taylor16"}
    assert len(some.cells) == 6


def test_the_seconds_of_all_cells_are_those_of_the_call() -> None:
    """Of runs, and of refusals."""
    begin = time.perf_counter()
    some = rigid.extremes("damping", method="exact", progress=False)
    whole = time.perf_counter() - begin
    assert {cell.verdict for cell in some.cells} == {"right", "refused"}
    assert all(cell.seconds > 0.0 for cell in some.cells)
    assert sum(cell.seconds for cell in some.cells) < whole


test_unknown_names_are_refused = refuses(
    [
        ({"family": "pancake"}, "family = 'pancake': must be one of 'needle', 'lamina'"),
        ({"method": "euler"}, "method = 'euler': must be one of 'exact', 'rk4'"),
    ],
    by=lambda options: rigid.extremes(**options),
)


# Status and reasons


def test_the_codes_of_the_status_are_those_of_the_core() -> None:
    for code, name in enumerate(_core.status_names()):
        assert rigid.Status[name.upper().replace(" ", "_")] == code


def test_reasons_say_how_each_body_ended() -> None:
    box = rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0)))
    starts = [[1.0, 0.0, 0.1], [1e-12, 1.0, 1e-12], [1e200, 1e200, 1.0], [1e9, 1.0, 1.0]]
    run = rigid.simulate(box, starts, t=[100.0], method="rk4", max_steps=10**6)
    ok, lost, overflow, slow = run.reasons()
    assert ok == "ok"
    assert lost.startswith("flagged: the estimated error is 1 or more from t = ")
    assert lost.endswith(" on; end the run earlier or ask for an accuracy")
    assert overflow in (
        "not finite: a number overflowed; take shorter steps or other units",
        slow,
    )
    assert slow == (
        "step limit: it needs more than max_steps steps; raise max_steps, take longer steps or a "
        "method of higher order"
    )
    assert run.status.tolist()[:2] == [rigid.Status.OK, rigid.Status.FLAGGED]
    above = rigid.simulate(
        rigid.HeavyTop(rigid.Body((1.0, 1.6, 0.7)), mgl=1.2, com=(0.6, 0.0, 0.8)),
        [0.3, 0.4, 1.0],
        [0.9, 0.3, 0.2, 0.1],
        t=[200.0],
        accuracy=1e-10,
    )
    assert "above the 1e-10 asked for" in above.reasons()[0] or "1 or more" in above.reasons()[0]


def test_next_to_a_separatrix_a_lost_side_is_flagged_from_the_first_flip_on() -> None:
    """Both runs of RK4 agree, being wrong alike; the states tell that they left their polhode."""
    box = rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0)))
    start = [1e-12, 1.0, 1e-12]
    run = rigid.simulate(box, start, t=[40.0, 100.0], method="taylor16")
    first = rigid.exact.flip_times(box, start, count=1)[0]
    assert run.status == rigid.Status.FLAGGED
    assert run.lost_from == pytest.approx(first)
    before = rigid.simulate(box, start, t=[40.0], method="taylor16")
    assert before.status == rigid.Status.OK
    assert before.error < 1e-2
