"""Ctrl-C while a map runs keeps what there is, and ends the program unless it asked to go on."""

import os
import pickle
import signal
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rigid
from interrupts import LONG, seconds_until_interrupted, sigint
from processes import PATIENCE
from small_maps import assert_same_map, in_blocks, small_map
from terminals import in_terminal, read

#: Bodies of every second row and column, which come first: 3 x 4 pixels of 20.
DONE = 240


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


@pytest.fixture(params=["raised by the callable", "a signal"])
def ctrl_c(request: pytest.FixtureRequest) -> Callable[[], None]:
    """Interrupt a map from its progress."""

    def raised() -> None:
        raise KeyboardInterrupt

    return raised if request.param == "raised by the callable" else signalled


def signalled() -> None:
    os.kill(os.getpid(), signal.SIGINT)


def test_an_interrupted_map_is_a_coarse_part_of_the_whole_one(
    ctrl_c: Callable[[], None], tmp_path: Path
) -> None:
    whole = small_map()

    def interrupt(progress: rigid.Progress) -> None:
        if progress.done >= DONE:
            ctrl_c()

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


def test_ctrl_c_ends_a_loop_of_maps_and_brings_the_part_that_is_done(
    ctrl_c: Callable[[], None],
) -> None:
    whole = small_map()
    begun: list[int] = []

    def interrupt(progress: rigid.Progress) -> None:
        if len(begun) == 2 and progress.done == DONE:
            ctrl_c()

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
            signalled()

    with pytest.raises(rigid.Interrupted, match="35 of 35 pixels are done") as caught:
        small_map(progress=interrupt)
    assert_same_map(caught.value.partial, small_map())
    assert small_map(progress=interrupt, partial=True).complete


def test_a_second_ctrl_c_ends_at_once() -> None:
    def impatient(progress: rigid.Progress) -> None:
        signalled()
        signalled()

    with in_blocks(1), pytest.raises(KeyboardInterrupt) as caught:
        small_map(progress=impatient, partial=True)
    assert not isinstance(caught.value, rigid.Interrupted)
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_other_handlers_and_other_threads_are_left_alone() -> None:
    called = []
    with sigint(lambda *_: called.append(1)):
        handler = signal.getsignal(signal.SIGINT)
        with in_blocks(25):
            result = small_map(progress=lambda progress: signalled())
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
    listening, heard, noted = (threading.Event() for _ in range(3))
    calls: list[int] = []

    def hear(*_: object) -> None:
        if not heard.is_set():
            heard.set()
            raise KeyboardInterrupt

    def interrupt(progress: rigid.Progress) -> None:
        calls.append(progress.done)
        assert listening.wait(PATIENCE)  # what the main thread does before is not guarded
        # A signal between the last look at signals and the wait does not end the wait: again.
        for _ in range(int(PATIENCE / 0.1)):
            if heard.wait(0.1):
                break
            signalled()
        assert noted.wait(PATIENCE)

    def listen(computing: Future[rigid.StabilityMap]) -> None:
        listening.set()
        computing.result(PATIENCE)

    with sigint(hear), in_blocks(5), ThreadPoolExecutor(1) as pool:
        computing = pool.submit(small_map, progress=interrupt)
        with pytest.raises(KeyboardInterrupt):
            listen(computing)
        assert not computing.done()
        noted.set()
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
    ("handler", "number", "code"),
    [(signal.SIG_IGN, signal.SIGINT, 130), (signal.default_int_handler, signal.SIGTERM, 143)],
)
def test_an_interrupted_command_writes_what_there_is(
    handler: Any, number: signal.Signals, code: int, tmp_path: Path
) -> None:
    """Also where a shell has started it in the background, so that it ignores SIGINT at first."""
    (tmp_path / "big.toml").write_text(BIG)
    command = ("map", str(tmp_path / "big.toml"), "--out", str(tmp_path / "big"))
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


def test_an_interrupted_call_says_what_is_done() -> None:
    assert str(rigid.Interrupted("1 of 2 pixels are done", None)) == "1 of 2 pixels are done"
