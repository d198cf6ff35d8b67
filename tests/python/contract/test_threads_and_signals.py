"""Arrays pass the border of the core as they are, and Python goes on while bodies move."""

import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rigid
from rigid import _core

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


@with_timer
def test_intervals_hear_an_interrupt() -> None:
    """A second of work for each ten thousand intervals of so many trials."""
    successes = np.arange(1, 1_000_000)
    with timeout_after(0.05):
        _core.clopper_pearson(successes, np.full_like(successes, 2**50), 0.95)


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
