"""Calls that may take long tell how much is done, and change no bit by it."""

import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
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


# Arrays pass the border of the core as they are, and Python goes on while bodies move.


FREE = rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0)))


def owner(array: Any) -> object:
    """What holds the memory of an array."""
    while isinstance(array, np.ndarray) and array.base is not None:
        array = array.base
    return array


@pytest.mark.parametrize("n", [20, 1000])
def test_results_are_memory_of_the_core_and_not_a_copy(n: int) -> None:
    """But for a few numbers, which are copied sooner."""
    run = rigid.simulate(FREE, np.ones((n, 3)), t=np.linspace(0.0, 1.0, 5))
    for array in (run.omega, run.attitude):
        assert array is not None
        assert not isinstance(owner(array), np.ndarray)
        assert array.flags.c_contiguous
        assert array.flags.writeable


ARGUMENTS = np.linspace(0.0, 1.0, 2_000_000)


def elliptic_functions() -> None:
    """Some tenths of a second in the core, in closed form."""
    _core.elliptic("jacobi", [ARGUMENTS, ARGUMENTS])


def move() -> None:
    """A tenth of a second or two of short steps."""
    rigid.simulate(FREE, [1.0, 2.0, 3.0], t=[500.0], method="rk4", step=1e-4, check=False)


@pytest.mark.parametrize("call", [move, elliptic_functions])
def test_other_threads_run_while_the_core_works(call: Callable[[], None]) -> None:
    """With the lock of the interpreter held nobody would count."""
    began, ended = threading.Event(), threading.Event()

    def work() -> None:
        began.set()
        call()
        ended.set()

    thread = threading.Thread(target=work)
    thread.start()
    began.wait()
    rounds = 0
    while not ended.is_set():
        rounds += 1
        time.sleep(1e-3)
    thread.join()
    assert rounds > 20


THREADS = Path("/proc/self/task")

with_timer = pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="no timer of signals")


@contextmanager
def timeout_after(seconds: float, action: Callable[[], object] = lambda: None) -> Iterator[None]:
    """A signal whose handler calls the action and raises TimeoutError, which is expected."""

    def handler(*_: Any) -> None:
        action()
        raise TimeoutError

    previous = signal.signal(signal.SIGALRM, handler)
    try:
        signal.setitimer(signal.ITIMER_REAL, seconds)
        with pytest.raises(TimeoutError):
            yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, previous)


@with_timer
def test_signals_are_handled_while_closed_forms_are_evaluated() -> None:
    """The handler of the signal ends the call: with a list of numbers left, not at its end."""
    # Processor time, which other programs do not change.
    begun = time.process_time()
    elliptic_functions()
    whole = time.process_time() - begun
    begun = time.process_time()
    with timeout_after(0.05 * whole):
        elliptic_functions()
    assert time.process_time() - begun < 0.7 * whole


def move_for_minutes(bodies: int, threads: int, **options: Any) -> None:
    """Integrate tops for a million seconds."""
    top = rigid.HeavyTop(rigid.Body((1.0, 1.2, 0.5)), mgl=1.0)
    omega = np.tile([0.1, 0.2, 3.0], (bodies, 1))
    rigid.simulate(top, omega, t=[1e6], threads=threads, check=False, **options)


@with_timer
@pytest.mark.parametrize("threads", [1, 2])
@pytest.mark.parametrize("bodies", [1, 65])
@pytest.mark.parametrize(
    "options", [{"method": "rk4", "step": 1e-3}, {"method": "taylor16", "tolerance": 1e-12}]
)
def test_signals_are_handled_while_bodies_are_integrated(
    options: dict[str, Any], bodies: int, threads: int
) -> None:
    with timeout_after(0.1):
        move_for_minutes(bodies, threads, **options)


@with_timer
@pytest.mark.skipif(not THREADS.exists(), reason="the system does not list the threads")
def test_a_call_with_one_thread_starts_none() -> None:
    counts = [len(list(THREADS.iterdir()))]
    with timeout_after(0.1, lambda: counts.append(len(list(THREADS.iterdir())))):
        move_for_minutes(65, 1, method="rk4", step=1e-3)
    assert counts[0] == counts[1]
