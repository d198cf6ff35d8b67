"""Bars of progress, and checks of arguments, where a call would take long to come to them."""

import io
import re
from pathlib import Path

import pytest

import rigid
from rigid import _core
from rigid._checks import progress as progressing
from rigid._checks.arguments import of_known, positive_int, resolve_threads, rows
from rigid._checks.inputs import unreadable
from rigid._checks.progress import Listening, reporting
from rigid._checks.quantities import instead_of_a_text


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


WIDE, NARROW = r"100%.*2\.00k/2\.00k .*bodies/s, 3 failed\]", r"100%\|[#█]+\| 00:00 left, 3 failed"


@pytest.mark.parametrize(
    ("option", "stream", "columns", "shown"),
    [
        (None, Terminal, 120, WIDE),
        (None, Terminal, 80, WIDE),
        (None, Terminal, 79, NARROW),
        (None, io.StringIO, 120, None),
        (True, Terminal, 79, NARROW),
        (True, io.StringIO, 79, WIDE),
        (False, Terminal, 120, None),
    ],
)
def test_a_bar_fits_its_terminal_and_is_shown_elsewhere_if_it_is_asked_for(
    option: bool | None,
    stream: type[io.StringIO],
    columns: int,
    shown: str | None,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    pytest.importorskip("tqdm")
    stderr = stream()
    monkeypatch.setattr("sys.stderr", stderr)
    monkeypatch.setattr(progressing, "terminal_columns", lambda: columns)
    with reporting(option, 2000) as tell:
        tell(1000)
        tell(2000, 3)
    last = stderr.getvalue().rstrip().rpartition("\r")[2]
    assert last == "" if shown is None else re.fullmatch(shown, last), last


@pytest.mark.parametrize(
    ("total", "unit", "words"),
    [(1000, " bodies", "1000/1000"), (1001, " bodies", "1.00k/1.00k"), (100, "%", "00:00 left")],
)
def test_a_bar_counts_a_thousand_units_one_by_one_and_no_hundredths(
    total: int, unit: str, words: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("tqdm")
    stderr = io.StringIO()
    monkeypatch.setattr("sys.stderr", stderr)
    with reporting(True, total, unit=unit) as tell:
        tell(total)
    last = stderr.getvalue().rstrip().rpartition("\r")[2]
    assert words in last
    assert (unit in last.partition("%")[2]) == (unit != "%")


def test_a_call_within_one_that_is_listened_to_has_the_same_listener() -> None:
    outer, inner, asked = (Listening(option) for option in (print, None, print))
    with outer:
        for within, expected in ((inner, outer), (asked, asked)):
            with within:
                heard = _core.listen(None)
                _core.listen(heard)
                assert heard == expected._hear
        assert _core.listen(outer._hear) == outer._hear
    assert _core.listen(None) is None


def test_whole_numbers_end_below_two_to_the_63() -> None:
    assert positive_int("samples", 2**63 - 1) == 2**63 - 1
    with pytest.raises(ValueError, match=r"samples = 9223372036854775808: must be below 2\*\*63"):
        positive_int("samples", 2**63)
    assert resolve_threads(1024) == 1024
    with pytest.raises(ValueError, match="threads = 1025: must be at most 1024"):
        resolve_threads(1025)


@pytest.mark.parametrize(("length", "words"), [(499, "omega1, omega2, omega3"), (500, "omega1 to")])
def test_names_by_number_are_one_in_a_list_of_500_characters(length: int, words: str) -> None:
    numbered = "omega1, omega2, omega3, "
    known = [*numbered.rstrip(", ").split(", "), "x" * (length - len(numbered))]
    assert f"(known: {words}" in of_known("nothing", known)


def test_no_rows_are_rows() -> None:
    assert rows("omega", [], 3).shape == (0, 3)
    with pytest.raises(ValueError, match=r"omega: expected shape \(3,\) or \(n, 3\), got \(2, 0\)"):
        rows("omega", [[], []], 3)


def test_a_missing_file_is_compared_with_those_beside_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "run.npz").touch()
    monkeypatch.chdir(tmp_path)
    for path in ("rum.npz", tmp_path / "rum.npz"):
        words = f"{path}: there is no such file or folder; did you mean 'run.npz'?"
        assert unreadable(path, FileNotFoundError()) == words
    nowhere = unreadable("none/run.npz", FileNotFoundError())
    assert nowhere == "none/run.npz: there is no such file or folder"


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("mass", "1.2.3 kg", " in kg, not a text"),
        ("mass", "heavy", " in kg, not a text"),
        ("mass", "-.5e1", " in kg, not a text; leave out the quotation marks"),
        ("mass", "1. kg", " in kg, written without the unit"),
        ("mass", "3 rpm", " in kg, written without the unit"),
        ("samples", "3 rpm", ", written without the unit; 3 * rigid.units.rpm is 0.314159265359"),
    ],
)
def test_a_number_with_its_unit_is_told_how_to_write_it(name: str, text: str, words: str) -> None:
    assert instead_of_a_text(name, text) == words


def test_an_interrupted_call_says_what_is_done() -> None:
    assert str(rigid.Interrupted("1 of 2 pixels are done", None)) == "1 of 2 pixels are done"
