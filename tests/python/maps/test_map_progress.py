"""While a map runs: progress, silent when asked to be, and blocks of a third of a second."""

import os
import pickle
import signal
import subprocess
import threading
from collections.abc import Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

import rigid
from interrupts import LONG, seconds_until_interrupted, sigint
from processes import PATIENCE, python_process
from rigid.store.drive import SHORTEST, Intake
from rigid.store.rows import NO_BINS, ROW, Block
from rigid.store.running import Memory
from small_maps import assert_same_map, in_blocks, small_map, spec_of
from terminals import in_terminal, read

IMPORTS = "import numpy as np, rigid, sys, time\n"

#: A tenth of a second of work with a visible bar; one pixel of five fails.
SHORT = """
result = rigid.stability_map(
    rigid.FreeBody, axes={"spin": [0.5, 1.0, 1.5, 2.0, 1e200]}, samples=400, t_end=200.0,
    stable=rigid.no_flip(3), start=rigid.Start(spin=1.0, axis=3, tilt=0.1), rng=1,
    method="rk4", step=0.05,
"""


def run(code: str) -> subprocess.CompletedProcess[str]:
    """Run code with all three streams as pipes."""
    return python_process(IMPORTS + code)


# Progress


@pytest.mark.parametrize("option", ["False", "None", "lambda progress: None"])
def test_without_a_terminal_not_one_byte_is_written(option: str) -> None:
    done = run(SHORT + f"progress={option})\nassert result.complete")
    assert (done.stdout, done.stderr) == ("", "")


def shown_in_a_terminal(code: str, columns: int = 80) -> str:
    with in_terminal("-c", IMPORTS + code, columns=columns) as (process, reader):
        shown = read(reader).decode()
        assert process.wait(PATIENCE) == 0
    return shown


def test_in_a_terminal_a_bar_shows_bodies_rate_time_and_failures() -> None:
    shown = shown_in_a_terminal(SHORT + "progress=None)")
    assert "bodies/s" in shown
    assert "2.00k/2.00k" in shown
    assert "100%" in shown
    assert "400 failed" in shown


def test_in_a_narrow_terminal_the_bar_keeps_ten_cells() -> None:
    shown = shown_in_a_terminal(SHORT + "progress=None)", columns=50)
    last = shown.rstrip().rpartition("\r")[2]
    assert last.startswith("100%|")
    assert len(last) <= 50
    assert last.count("\u2588") >= 10
    assert last.endswith("00:00 left, 400 failed")


def test_false_is_silent_in_a_terminal_too() -> None:
    assert shown_in_a_terminal(SHORT + "progress=False)") == ""


def test_true_shows_the_bar_anywhere() -> None:
    done = run(SHORT + "progress=True)")
    assert "bodies/s" in done.stderr
    assert done.stdout == ""


def test_without_tqdm_none_is_silent_and_true_says_what_is_missing() -> None:
    blocked = "sys.modules['tqdm'] = None\n"
    assert shown_in_a_terminal(blocked + SHORT + "progress=None)") == ""
    ask = "try:\n    " + SHORT.strip().replace("\n", "\n    ") + "progress=True)\n"
    done = run(blocked + ask + "except ImportError as error:\n    print(error)")
    assert done.stdout.strip() == "a progress bar needs tqdm: pip install 'rigid-rotation[maps]'"


@pytest.mark.parametrize("units", [1, 3, 100])
def test_a_callable_gets_records_that_only_grow(units: int) -> None:
    records: list[rigid.Progress] = []
    axes = {"I1": [0.1, 0.9, 1.2, 5.0]}  # the outer two are impossible and cost nothing
    with in_blocks(units):
        result = small_map(
            axes=axes,
            start=rigid.Start(spin=1.0, axis=2, noise=rigid.normal(0.1)),
            samples=150,  # of 64, 64 and 22
            progress=records.append,
        )
    done = [record.done for record in records]
    assert done[-1] == 300 == result.samples.sum()
    assert len(done) == -(-6 // units)
    assert (np.diff([0, *done]) > 0).all()
    assert {record.total for record in records} == {300}
    elapsed = [record.elapsed for record in records]
    assert (np.diff([0.0, *elapsed]) >= 0.0).all()
    assert elapsed[-1] <= result.elapsed
    for record in records:
        assert record.rate == record.done / record.elapsed
        left = record.total - record.done
        assert record.remaining == pytest.approx(left / record.rate, rel=1e-12, abs=1e-300)
    assert {record.failures for record in records} == {0}


def test_failures_are_counted_while_it_runs() -> None:
    records: list[rigid.Progress] = []
    with in_blocks(1):
        result = small_map(
            axes={"spin": [1.0, 2.0, 1e200]},
            start=rigid.Start(spin=1.0, axis=3, tilt=0.1),
            samples=10,
            progress=records.append,
        )
    # The lattice of every second pixel comes first.
    assert [record.failures for record in records] == [0, 10, 10]
    assert result.failed.sum() == 10


def test_a_record_before_the_first_body_promises_nothing() -> None:
    record = rigid.Progress(done=0, total=10, elapsed=0.0, failures=0)
    assert record.rate == 0.0
    assert record.remaining == float("inf")
    assert rigid.Progress(done=10, total=10, elapsed=0.0, failures=0).remaining == 0.0


# Blocks


class Nowhere(Memory):
    """Keeps no rows."""

    def append(self, *_: object) -> None:
        """Forget rows."""


def test_blocks_settle_near_a_third_of_a_second_and_stay_short() -> None:
    # A machine that needs 1 ms a unit in the first half and 1 ms / 100 in the second.
    intake = Intake(Nowhere(spec_of(samples=1)), lambda *_: None, threads=1)
    seconds = []
    for round_ in range(60):
        cost, units = (1e-3 if round_ < 30 else 1e-5), intake.units
        seconds.append(units * cost)
        costs = np.full(units, 1e9 * cost, np.float32)
        intake.take(Block(np.zeros(units, ROW), costs, NO_BINS))
    assert max(seconds) <= 4.0 * SHORTEST
    assert seconds[20] == pytest.approx(SHORTEST, rel=0.1)
    # What once was costly may come again: a block stays short enough for that.
    assert intake.units * 1e-3 <= 4.0 * SHORTEST * 1.01


def taken(
    costs: list[float],
    monkeypatch: pytest.MonkeyPatch,
    *,
    threads: int = 1,
    append: float = 0.0,
    seconds: float | None = None,
    blocks: int = 1,
) -> int:
    """Units of the next block after some whose units cost these times and took so long to keep."""
    clock = 0.0

    class Slow(Nowhere):
        def append(self, *_: object) -> None:
            nonlocal clock
            clock += append

    monkeypatch.setattr("rigid.store.drive.time.perf_counter", lambda: clock)
    intake = Intake(Slow(spec_of(samples=1)), lambda *_: None, threads)
    for _ in range(blocks):
        cost = np.resize(1e9 * np.array(costs), intake.units).astype(np.float32)
        intake.take(Block(np.zeros(intake.units, ROW), cost, NO_BINS), seconds)
    return intake.units


def test_a_block_is_as_long_as_its_units_and_the_disk_allow(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The first has sixteen bodies a thread, and each at most eight times the one before."""
    assert Intake(Nowhere(spec_of(samples=4)), lambda *_: None, threads=2).units == 8
    assert Intake(Nowhere(spec_of(samples=100)), lambda *_: None, threads=1).units == 1
    assert taken([1e-9], monkeypatch) == 8 * 16
    assert taken([0.0], monkeypatch, blocks=2) == 8 * 8 * 16
    # A third of a second, or fifty times the time to keep a block, up to a minute.
    for append, wanted in ((0.0, 0.3), (0.006, 0.3), (0.02, 1.0), (1.0, 50.0), (10.0, 60.0)):
        units = taken([0.01], monkeypatch, append=append, blocks=5)
        assert units == pytest.approx(wanted / 0.01, abs=1.0)
    # The wall time where it is known; else the processor time over the threads.
    assert taken([1e-6], monkeypatch, seconds=0.6) == 8
    assert taken([0.01], monkeypatch, threads=4, blocks=3) == pytest.approx(120, abs=1)
    # One costly unit: four such blocks of its kind at most.
    assert taken([0.1, *[0.0] * 15], monkeypatch) == pytest.approx(12, abs=1)


# Ctrl-C while a map runs keeps what there is, and ends the program unless it asked to go on.


#: Bodies of every second row and column, which come first: 3 x 4 pixels of 20.
DONE = 240

AGAIN = 10.0
"""Seconds after which a signal that was not heard is sent again."""


@pytest.fixture(autouse=True)
def _foreground() -> Iterator[None]:
    """As in the foreground of a shell; in its background SIGINT is ignored."""
    with sigint(signal.default_int_handler):
        yield


def test_errors_of_a_callable_come_through() -> None:
    def complain(progress: rigid.Progress) -> None:
        raise ZeroDivisionError(f"after {progress.done}")

    with in_blocks(2), pytest.raises(ZeroDivisionError, match="after 40"):
        small_map(progress=complain)
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


@pytest.mark.parametrize("how", ["raised by the callable", "a signal"])
def test_an_interrupted_map_is_a_coarse_part_of_the_whole_one(how: str, tmp_path: Path) -> None:
    whole = small_map()

    def interrupt(progress: rigid.Progress) -> None:
        if progress.done >= DONE:
            if how == "raised by the callable":
                raise KeyboardInterrupt
            os.kill(os.getpid(), signal.SIGINT)

    with in_blocks(1):
        partial = small_map(progress=interrupt, partial=True)
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    assert not partial.complete
    coarse = np.zeros((5, 7), np.bool_)
    coarse[::2, ::2] = True
    np.testing.assert_array_equal(partial.samples, np.where(coarse, 20, 0))
    for name in ("stable", "unstable", "earliest", "energy_drift", "share", "lower"):
        np.testing.assert_array_equal(getattr(partial, name)[coarse], getattr(whole, name)[coarse])
    # And it is a result like any other.
    assert f"{DONE:,} of 700 (stopped early)" in partial.summary()
    assert np.isnan(partial.share[~coarse]).all()
    assert partial.to_xarray().attrs["complete"] == 0
    loaded = rigid.load_map(partial.save(tmp_path / "partial.npz"))
    assert not loaded.complete
    assert_same_map(loaded, partial)
    assert f"stopped after {DONE:,} bodies" in partial.plot().get_title(loc="left")


@pytest.mark.parametrize("how", ["raised by the callable", "a signal"])
def test_ctrl_c_ends_a_loop_of_maps_and_brings_the_part_that_is_done(how: str) -> None:
    whole = small_map()
    begun: list[int] = []

    def interrupt(progress: rigid.Progress) -> None:
        if len(begun) == 2 and progress.done == DONE:
            if how == "raised by the callable":
                raise KeyboardInterrupt
            os.kill(os.getpid(), signal.SIGINT)

    def six_maps() -> None:
        for number in range(6):
            begun.append(number)
            small_map(progress=interrupt)

    with in_blocks(1), pytest.raises(KeyboardInterrupt) as caught:
        six_maps()
    assert begun == [0, 1]
    assert isinstance(caught.value, rigid.Interrupted)
    assert str(caught.value).startswith("12 of 35 pixels are done; the attribute 'partial'")
    partial = caught.value.partial
    assert not partial.complete
    assert partial.samples.sum() == DONE
    np.testing.assert_array_equal(partial.stable[::2, ::2], whole.stable[::2, ::2])
    again = pickle.loads(pickle.dumps(caught.value))
    assert str(again) == str(caught.value)
    assert_same_map(again.partial, partial)


def test_ctrl_c_with_the_last_body_is_not_lost() -> None:
    def interrupt(progress: rigid.Progress) -> None:
        if progress.done == progress.total:
            os.kill(os.getpid(), signal.SIGINT)

    with pytest.raises(rigid.Interrupted, match="35 of 35 pixels are done") as caught:
        small_map(progress=interrupt)
    assert_same_map(caught.value.partial, small_map())
    assert small_map(progress=interrupt, partial=True).complete


def test_a_second_ctrl_c_ends_at_once() -> None:
    def impatient(progress: rigid.Progress) -> None:
        os.kill(os.getpid(), signal.SIGINT)
        os.kill(os.getpid(), signal.SIGINT)

    with in_blocks(1), pytest.raises(KeyboardInterrupt) as caught:
        small_map(progress=impatient, partial=True)
    assert not isinstance(caught.value, rigid.Interrupted)
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_other_handlers_and_other_threads_are_left_alone() -> None:
    called = []
    with sigint(lambda *_: called.append(1)):
        handler = signal.getsignal(signal.SIGINT)
        with in_blocks(25):
            result = small_map(progress=lambda progress: os.kill(os.getpid(), signal.SIGINT))
        assert signal.getsignal(signal.SIGINT) is handler
    assert result.complete
    assert called == [1, 1]

    results: list[rigid.StabilityMap] = []
    thread = threading.Thread(target=lambda: results.append(small_map()))
    thread.start()
    thread.join()
    assert_same_map(results[0], result)


def test_ctrl_c_reaches_the_main_thread_while_a_pool_computes() -> None:
    """The pool completes its map all the same."""
    listening, heard = threading.Event(), threading.Event()
    calls: list[int] = []

    def interrupt(progress: rigid.Progress) -> None:
        calls.append(progress.done)
        if len(calls) == 1:
            assert listening.wait(PATIENCE)  # what the main thread does before is not guarded
            os.kill(os.getpid(), signal.SIGINT)
            return
        # A signal between the last look at signals and the wait does not end the wait: again.
        for _ in range(int(PATIENCE / AGAIN)):
            if heard.wait(AGAIN):
                return
            os.kill(os.getpid(), signal.SIGINT)
        raise AssertionError("the main thread heard no signal")

    def listen(computing: Future[rigid.StabilityMap]) -> None:
        listening.set()
        computing.result(PATIENCE)

    with in_blocks(5), ThreadPoolExecutor(1) as pool:
        computing = pool.submit(small_map, progress=interrupt)
        with pytest.raises(KeyboardInterrupt):
            listen(computing)
        assert not computing.done()
        heard.set()
        completed = computing.result(PATIENCE)
    assert len(calls) > 2
    assert completed.complete
    assert_same_map(completed, small_map())


@pytest.mark.parametrize("size", LONG)
def test_ctrl_c_ends_hours_of_work(size: str) -> None:
    seconds_until_interrupted(size)


BIG = """
[scene]
kind = "free-body"
moments = [1.0, 1.5, 2.0]
[x]
name = "spin"
values = [1.0, 2.0, 3.0]
[start]
axis = 3
noise = { kind = "normal", size = 0.01 }
[stable]
criterion = "no_flip"
[run]
t_end = 2000.0
method = "rk4"
samples = 1_000_000
seed = 1
"""


@pytest.mark.parametrize(
    ("place", "number", "code"),
    [
        ("foreground", signal.SIGINT, 130),
        ("background", signal.SIGINT, 130),
        ("foreground", signal.SIGTERM, 143),
    ],
)
def test_an_interrupted_command_writes_what_there_is(
    place: str, number: signal.Signals, code: int, tmp_path: Path
) -> None:
    """Also where a shell has started it in the background, so that it ignores SIGINT at first."""
    (tmp_path / "big.toml").write_text(BIG)
    command = ("map", str(tmp_path / "big.toml"), "--out", str(tmp_path / "big"))
    handler = signal.SIG_IGN if place == "background" else signal.default_int_handler
    with sigint(handler), in_terminal("-m", "rigid", *command) as (process, reader):
        shown = read(reader, until=b"k/3.00M")  # some thousand bodies are done
        assert b"k/3.00M" in shown
        process.send_signal(number)
        output, _ = process.communicate(timeout=PATIENCE)
        shown += read(reader)
    assert process.returncode == code
    assert b"rigid: interrupted; the map written is partial" in shown
    assert b"Traceback" not in shown
    assert b"(stopped early)" in output
    result = rigid.load_map(tmp_path / "big.npz")
    assert not result.complete
    assert result.samples.sum() > 1000
    assert (tmp_path / "big.png").read_bytes().startswith(b"\x89PNG")
