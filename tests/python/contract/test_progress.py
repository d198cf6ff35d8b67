"""Calls that may take long tell how much is done, and change no bit by it."""

import io
import re
import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rigid
from rigid import _core
from rigid._checks import progress as progressing
from small_maps import in_blocks, small_map

TOP = rigid.HeavyTop(rigid.Body((1.0, 1.6, 0.7)), mgl=1.2, com=(0.6, 0.0, 0.8))
START = [0.3, 0.4, 1.0]
MANY = np.random.default_rng(1).normal(size=(200, 3))
LONG = [0.0, 10_000.0]
THREE_RUNS = [0.0, 30_000.0]


@cache
def result() -> rigid.StabilityMap:
    """A map whose bodies are classified again in a tenth of a second or two."""
    return rigid.stability_map(
        TOP,
        axes={"spin": np.linspace(1.0, 5.0, 16)},
        samples=256,
        t_end=500.0,
        stable=rigid.tilt_below(2.0),
        rng=1,
        progress=False,
    )


#: What runs for two tenths of a second or more, of which a listener hears each twentieth; and an
#: array of its result.
CALLS: dict[str, Callable[..., Any]] = {
    "steps": lambda **how: rigid.simulate(TOP, START, t=LONG, method="dop853", **how).omega,
    "tolerance": lambda **how: (
        rigid.simulate(TOP, START, t=[0.0, 1e5], method="taylor16", tolerance=1e-12, **how).omega
    ),
    "forward and backward": lambda **how: (
        rigid.simulate(TOP, START, t=[-5e4, 5e4], method="taylor16", tolerance=1e-12, **how).omega
    ),
    "many": lambda **how: rigid.simulate(TOP, MANY, t=[0.0, 250.0], **how).omega,
    "closed form": lambda **how: (
        rigid.simulate(TOP.body, MANY, t=np.linspace(0.0, 9.0, 6000), **how).omega
    ),
    "events": lambda **how: (
        rigid.simulate(TOP, START, t=THREE_RUNS, events=rigid.crosses("omega3", 0.5), **how)
        .events[0]
        .t
    ),
    "growth": lambda **how: rigid.lyapunov(TOP, START, t=[10_000.0], **how).log_growth,
    "section": lambda **how: rigid.poincare(TOP, START, t_end=12_000.0, **how).omega,
    "equal times": lambda **how: rigid.poincare(TOP, START, every=500.0, t_end=2.5e4, **how).omega,
    "page": lambda **how: np.frombuffer(
        result().explore(samples=256, **how)._repr_html_().encode(), np.uint8
    ),
}


@pytest.mark.parametrize("name", CALLS)
def test_a_long_call_tells_what_is_done(name: str) -> None:
    records: list[rigid.Progress] = []
    found = CALLS[name](progress=records.append)
    done = [record.done for record in records]
    assert done == sorted(done)
    assert done[-1] == 100
    assert 0 <= done[0] < 100  # on a busy machine the first block may take longer
    assert {record.total for record in records} == {100}
    assert found.tobytes() == CALLS[name](progress=False).tobytes()


@pytest.mark.parametrize("name", ["steps", "tolerance", "events"])
def test_what_is_done_grows_to_the_end(name: str) -> None:
    done: list[int] = []
    CALLS[name](progress=lambda record: done.append(record.done))
    assert done[-2] > 60


def test_runs_that_follow_each_other_share_one_progress() -> None:
    records: list[rigid.Progress] = []
    listening = progressing.Listening(records.append, runs=2)
    with listening:
        for share in (0.0, 0.5, 0.5, 1.0, 0.5):
            listening._hear(share)
    assert [record.done for record in records] == [0, 25, 25, 50, 75, 100]


@pytest.mark.parametrize("name", ["steps", "tolerance", "growth", "section", "page"])
def test_what_a_listener_raises_ends_the_call(name: str) -> None:
    def stop(_: rigid.Progress) -> None:
        raise KeyboardInterrupt("enough")

    with pytest.raises(KeyboardInterrupt, match="enough"):
        CALLS[name](progress=stop)
    records: list[rigid.Progress] = []
    CALLS["many"](progress=records.append)  # nobody listens any more
    assert records[-1].done == 100


def test_a_script_gets_lines_of_long_calls(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    monkeypatch.setattr(progressing, "SECONDS_BETWEEN_LINES", 0.0)
    monkeypatch.setattr(progressing, "SHOWN_AFTER", np.inf)
    CALLS["steps"]()
    assert capsys.readouterr().err == ""
    monkeypatch.setattr(progressing, "SHOWN_AFTER", 0.0)
    monkeypatch.setattr("rigid.store.compare.TOGETHER", 4)
    for call in (
        CALLS["steps"],
        CALLS["growth"],
        CALLS["section"],
        lambda: small_map(progress=None, store=tmp_path / "run"),
        lambda: rigid.open_store(tmp_path / "run").verify(share=1.0),
    ):
        with in_blocks(4):
            call()
        assert capsys.readouterr().err.startswith("rigid: ")


def test_calls_within_another_progress_show_none_of_their_own(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(progressing, "SECONDS_BETWEEN_LINES", 0.0)
    monkeypatch.setattr(progressing, "SHOWN_AFTER", 0.0)
    with progressing.reporting(False, 1):
        CALLS["steps"]()
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize("name", CALLS)
def test_what_is_no_progress_is_refused(name: str) -> None:
    with pytest.raises(TypeError, match="progress = 3: must be None, True, False or a callable"):
        CALLS[name](progress=3)


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
    with progressing.reporting(option, 2000) as tell:
        tell(1000)
        tell(2000, 3)
    last = stderr.getvalue().rstrip().rpartition("\r")[2]
    assert last == "" if shown is None else re.fullmatch(shown, last), last


def test_without_tqdm_no_bar_is_shown_and_one_that_is_asked_for_is_missed(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    stderr = Terminal()
    monkeypatch.setattr("sys.stderr", stderr)
    monkeypatch.setitem(sys.modules, "tqdm.auto", None)
    with progressing.reporting(None, 1) as tell:
        tell(1)
    assert stderr.getvalue() == ""
    words = re.escape("a progress bar needs tqdm: pip install 'rigid-rotation[maps]'")
    with pytest.raises(ImportError, match=f"^{words}$"), progressing.reporting(True, 1):
        pass


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
    with progressing.reporting(True, total, unit=unit) as tell:
        tell(total)
    last = stderr.getvalue().rstrip().rpartition("\r")[2]
    assert words in last
    assert (unit in last.partition("%")[2]) == (unit != "%")


def test_a_call_within_one_that_is_listened_to_has_the_same_listener() -> None:
    outer, inner, asked = (progressing.Listening(option) for option in (print, None, print))
    with outer:
        for within, expected in ((inner, outer), (asked, asked)):
            with within:
                heard = _core.listen(None)
                _core.listen(heard)
                assert heard == expected._hear
        assert _core.listen(outer._hear) == outer._hear
    assert _core.listen(None) is None
