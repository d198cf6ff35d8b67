"""While a map runs: progress, silent when asked to be, and Ctrl-C, which keeps what there is."""

from __future__ import annotations

import fcntl
import os
import pty
import select
import signal
import struct
import subprocess
import sys
import termios
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

import rigid
from rigid.progress import CHUNK_SECONDS, LONGEST_SECONDS, Pace, Work
from small_maps import assert_same_map, small_map

IMPORTS = "import numpy as np, rigid, sys, time\n"

#: About a second of work with a visible bar; one pixel of five fails.
SHORT = """
result = rigid.stability_map(
    rigid.FreeBody, axes={"spin": [0.5, 1.0, 1.5, 2.0, 1e200]}, samples=4000, t_end=200.0,
    stable=rigid.no_flip(3), start=rigid.Start(spin=1.0, axis=3, tilt=0.1), rng=1,
    method="rk4", step=0.05,
"""


def run(code: str) -> subprocess.CompletedProcess[bytes]:
    """Run code with all three streams as pipes."""
    return subprocess.run(
        [sys.executable, "-c", IMPORTS + code], capture_output=True, timeout=60, check=True
    )


# Progress


@pytest.mark.parametrize("option", ["False", "None", "lambda progress: None"])
def test_without_a_terminal_not_one_byte_is_written(option: str) -> None:
    done = run(SHORT + f"progress={option})\nassert result.complete")
    assert (done.stdout, done.stderr) == (b"", b"")


@contextmanager
def in_terminal(*command: str) -> Iterator[tuple[subprocess.Popen[bytes], int]]:
    """A process whose standard error is a terminal, and the end to read it from."""
    reader, terminal = pty.openpty()
    fcntl.ioctl(terminal, termios.TIOCSWINSZ, struct.pack("HHHH", 24, 100, 0, 0))
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=terminal)
    os.close(terminal)
    try:
        yield process, reader
    finally:
        process.kill()
        process.communicate()
        os.close(reader)


def read(reader: int, *, until: bytes = b"", seconds: float = 30.0) -> bytes:
    """What the terminal shows until it has shown that, or the process has closed it."""
    shown, end = b"", time.monotonic() + seconds
    while time.monotonic() < end and not (until and until in shown):
        if select.select([reader], [], [], 0.1)[0]:
            try:
                shown += os.read(reader, 65536)
            except OSError:  # Linux: the other end is closed
                break
    return shown


def test_in_a_terminal_a_bar_shows_bodies_rate_time_and_failures() -> None:
    with in_terminal(sys.executable, "-c", IMPORTS + SHORT + "progress=None)") as (process, reader):
        shown = read(reader).decode()
        assert process.wait(30.0) == 0
    assert "bodies/s" in shown
    assert "20.0k/20.0k" in shown
    assert "100%" in shown
    assert "failed=4000" in shown.replace("4e+3", "4000")


def test_false_is_silent_in_a_terminal_too() -> None:
    with in_terminal(sys.executable, "-c", IMPORTS + SHORT + "progress=False)") as (
        process,
        reader,
    ):
        assert read(reader) == b""
        assert process.wait(30.0) == 0


def test_true_shows_the_bar_anywhere() -> None:
    done = run(SHORT + "progress=True)")
    assert b"bodies/s" in done.stderr
    assert done.stdout == b""


def test_without_tqdm_none_is_silent_and_true_says_what_is_missing() -> None:
    blocked = "sys.modules['tqdm'] = None\n"
    code = IMPORTS + blocked + SHORT + "progress=None)"
    with in_terminal(sys.executable, "-c", code) as (process, reader):
        assert read(reader) == b""
        assert process.wait(30.0) == 0
    ask = "try:\n    " + SHORT.strip().replace("\n", "\n    ") + "progress=True)\n"
    done = run(blocked + ask + "except ImportError as error:\n    print(error)")
    assert done.stdout.decode().strip() == "a progress bar needs tqdm: pip install 'rigid[maps]'"


@pytest.mark.parametrize("chunk", [1, 7, 100, None])
def test_a_callable_gets_records_that_only_grow(chunk: int | None) -> None:
    records: list[rigid.Progress] = []
    axes = {"I1": [0.1, 0.9, 1.2, 5.0]}  # the outer two are impossible and cost nothing
    result = small_map(
        axes=axes,
        start=rigid.Start(spin=1.0, axis=2, noise=rigid.normal(0.1)),
        samples=30,
        chunk=chunk,
        progress=records.append,
    )
    done = [record.done for record in records]
    assert done[-1] == 60 == result.samples.sum()
    assert (np.diff([0, *done]) > 0).all()
    if chunk is not None:
        assert done == [*range(chunk, 60, chunk), 60]
    assert {record.total for record in records} == {60}
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
    result = small_map(
        axes={"spin": [1.0, 2.0, 1e200]},
        start=rigid.Start(spin=1.0, axis=3, tilt=0.1),
        samples=10,
        chunk=5,
        progress=records.append,
    )
    assert [record.failures for record in records] == [0, 0, 0, 0, 5, 10]
    assert result.failed.sum() == 10


def test_a_record_before_the_first_body_promises_nothing() -> None:
    record = rigid.Progress(done=0, total=10, elapsed=0.0, failures=0)
    assert record.rate == 0.0
    assert record.remaining == float("inf")
    assert rigid.Progress(done=10, total=10, elapsed=0.0, failures=0).remaining == 0.0


def test_errors_of_a_callable_come_through() -> None:
    def complain(progress: rigid.Progress) -> None:
        raise ZeroDivisionError(f"after {progress.done}")

    with pytest.raises(ZeroDivisionError, match="after 7"):
        small_map(progress=complain, chunk=7)
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


# Chunks


def test_chunks_settle_near_a_third_of_a_second_and_never_pass_one() -> None:
    # A machine that needs 1 ms a body in the first half and 1 ms / 100 in the second.
    pace = Pace(threads=2)
    seconds = []
    for round_ in range(60):
        cost = 1e-3 if round_ < 30 else 1e-5
        bodies = pace.size
        seconds.append(bodies * cost)
        pace.note(bodies, seconds[-1], 2.0 * cost)
    assert max(seconds) <= LONGEST_SECONDS
    assert seconds[20] == pytest.approx(CHUNK_SECONDS, rel=0.1)
    # What once was costly may come again: a chunk stays short enough for that.
    assert pace.size * 1e-3 <= LONGEST_SECONDS * 1.01


def test_impossible_pixels_are_skipped_in_the_count() -> None:
    work = Work(np.array([False, True, False, False, True, True]), samples=4)
    assert work.total == 12
    assert [work.flat(done) for done in (0, 1, 3)] == [4, 5, 7]
    assert [work.flat(done) for done in (5, 7, 8, 11)] == [17, 19, 20, 23]


# Ctrl-C


@pytest.mark.parametrize("how", ["raised by the callable", "a signal"])
def test_an_interrupted_map_is_the_beginning_of_the_whole_one(how: str, tmp_path: Path) -> None:
    whole = small_map()

    def interrupt(progress: rigid.Progress) -> None:
        if progress.done >= 250:
            if how == "raised by the callable":
                raise KeyboardInterrupt
            os.kill(os.getpid(), signal.SIGINT)

    partial = small_map(chunk=50, progress=interrupt)
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    assert not partial.complete
    done, full = 250, 12  # bodies, and pixels of 20
    assert partial.samples.sum() == done
    np.testing.assert_array_equal(partial.samples.ravel()[:full], 20)
    np.testing.assert_array_equal(partial.samples.ravel()[full], done % 20)
    np.testing.assert_array_equal(partial.samples.ravel()[full + 1 :], 0)
    for name in ("stable", "unstable", "earliest", "energy_drift", "share", "lower"):
        np.testing.assert_array_equal(
            getattr(partial, name).ravel()[:full], getattr(whole, name).ravel()[:full]
        )
    # And it is a result like any other.
    assert f"{done:,} of 700 (stopped early)" in partial.summary()
    assert np.isnan(partial.share.ravel()[full + 1 :]).all()
    assert partial.to_xarray().attrs["complete"] == 0
    loaded = rigid.load_map(partial.save(tmp_path / "partial.npz"))
    assert not loaded.complete
    assert_same_map(loaded, partial)
    assert f"stopped after {done:,} bodies" in partial.plot().get_title(loc="left")


def test_other_handlers_and_other_threads_are_left_alone() -> None:
    called = []
    previous = signal.signal(signal.SIGINT, lambda *_: called.append(1))
    try:
        handler = signal.getsignal(signal.SIGINT)
        result = small_map(chunk=500, progress=lambda progress: os.kill(os.getpid(), signal.SIGINT))
        assert signal.getsignal(signal.SIGINT) is handler
    finally:
        signal.signal(signal.SIGINT, previous)
    assert result.complete
    assert called == [1, 1]

    results: list[rigid.StabilityMap] = []
    thread = threading.Thread(target=lambda: results.append(small_map()))
    thread.start()
    thread.join()
    assert_same_map(results[0], result)


LONG = {
    "many bodies": 'axes={"spin": np.linspace(1.0, 2.0, 100)}, samples=10**7, t_end=50.0',
    # Seconds for a single body: the interrupt has to get through to the kernel.
    "long bodies": 'axes={"spin": [1.0, 1.1]}, samples=200, t_end=2e7, max_steps=10**10',
    "one body": 'axes={"spin": [1.0]}, samples=1, t_end=1e8, max_steps=10**10, check=0.0',
}


@pytest.mark.parametrize("size", LONG)
def test_ctrl_c_returns_within_two_seconds(size: str) -> None:
    code = f"""
print("ready", flush=True)
result = rigid.stability_map(
    rigid.FreeBody, {LONG[size]}, stable=rigid.no_flip(), rng=1, progress=False,
    method="rk4", start=rigid.Start(spin=1.0, axis=3, noise=rigid.normal(0.01)),
)
done = int(result.samples.sum())
assert not result.complete and done == result.stable.sum() + result.unstable.sum()
assert {size != "many bodies"} or done > 0
result.summary()
print("partial", flush=True)
"""
    with subprocess.Popen(
        [sys.executable, "-c", IMPORTS + code], stdout=subprocess.PIPE, stderr=subprocess.PIPE
    ) as process:
        try:
            assert process.stdout is not None
            assert process.stdout.readline() == b"ready\n"
            time.sleep(0.7)
            assert process.poll() is None, "it was over before it could be interrupted"
            process.send_signal(signal.SIGINT)
            begun = time.monotonic()
            output, errors = process.communicate(timeout=30.0)
            waited = time.monotonic() - begun
        finally:
            process.kill()
    assert output == b"partial\n", errors
    assert process.returncode == 0
    assert waited < 2.0


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
samples = 100_000_000
seed = 1
"""


def test_an_interrupted_command_writes_what_there_is_and_exits_with_130(tmp_path: Path) -> None:
    (tmp_path / "big.toml").write_text(BIG)
    command = (
        *(sys.executable, "-m", "rigid.cli", "map", str(tmp_path / "big.toml")),
        *("--out", str(tmp_path / "big")),
    )
    with in_terminal(*command) as (process, reader):
        shown = read(reader, until=b"k/300M")  # some thousand bodies are done
        assert b"k/300M" in shown
        process.send_signal(signal.SIGINT)
        output, _ = process.communicate(timeout=30.0)
        shown += read(reader, seconds=2.0)
    assert process.returncode == 130
    assert b"rigid: interrupted; the map written is partial" in shown
    assert b"Traceback" not in shown
    assert b"(stopped early)" in output
    result = rigid.load_map(tmp_path / "big.npz")
    assert not result.complete
    assert result.samples.sum() > 1000
    assert (tmp_path / "big.png").read_bytes().startswith(b"\x89PNG")
