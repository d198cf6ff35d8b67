"""Arrays pass the border of the core as they are, and Python goes on while bodies move."""

from __future__ import annotations

import threading
import time
from typing import Any

import numpy as np
import pytest

import rigid

FREE = rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0)))


def owner(array: Any) -> object:
    """What holds the memory of an array."""
    while isinstance(array, np.ndarray) and array.base is not None:
        array = array.base
    return array


@pytest.mark.parametrize("n", [1, 1000])
def test_results_are_memory_of_the_core_and_not_a_copy(n: int) -> None:
    run = rigid.simulate(FREE, np.ones((n, 3)), t=np.linspace(0.0, 1.0, 5))
    for array in (run.omega, run.attitude):
        assert array is not None
        assert not isinstance(owner(array), np.ndarray)
        assert array.flags.c_contiguous
        assert array.flags.writeable


def test_other_threads_run_while_bodies_move() -> None:
    """Half a second in the core: with the lock of the interpreter held nobody would count."""
    began, ended = threading.Event(), threading.Event()

    def move() -> None:
        began.set()
        rigid.simulate(FREE, [1.0, 2.0, 3.0], t=[1000.0], method="rk4", step=1e-4, check=False)
        ended.set()

    thread = threading.Thread(target=move)
    thread.start()
    began.wait()
    count = 0
    while not ended.is_set():
        count += 1
        time.sleep(1e-3)
    thread.join()
    assert count > 20
