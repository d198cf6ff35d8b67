"""The bits of results, whatever rounding and flush modes another library has left set."""

from __future__ import annotations

import signal
from collections.abc import Callable
from functools import partial
from types import FrameType
from typing import Any

import numpy as np
import pytest

import rigid
from float_modes import CAN_BE_SET, MODES, control_word, float_mode
from physics import METHODS, Floats
from rigid import _core

pytestmark = pytest.mark.skipif(not CAN_BE_SET, reason="needs glibc on x86-64")

BOX = rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0)))
LAGRANGE = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.7)), mgl=1.2)
TOP = rigid.HeavyTop(rigid.Body((1.0, 1.6, 0.7)), mgl=1.2, com=(0.6, 0.0, 0.8))
FORCED = rigid.FreeBody(
    rigid.Body((1.0, 2.0, 3.0)),
    torque=rigid.Torque.space((0.1, 0.2, 0.3)),
    damping=np.diag([0.1, 0.2, 0.3]),
)
OMEGA, ATTITUDE = np.array([0.1, 1.0, 2.0]), np.array([0.9, 0.3, 0.2, 0.1])
TIMES = np.linspace(0.0, 20.0, 41)
#: Rates near the least normal number, beside rates of one: flushed, they would stop.
TINY = np.array([[1e-308, 1.0, 3e-308], [2e-308, 1e-309, 1.0]])
MAP: dict[str, Any] = {
    "axes": {"spin": np.linspace(2.0, 6.0, 4)},
    "start": rigid.Start(spin=5.0, attitude_noise=rigid.normal(0.1)),
    "t_end": 20.0,
    "samples": 64,
    "rng": 2026,
    "progress": False,
}
TENSOR = [[2.0, 0.1, 0.3], [0.1, 3.0, 0.2], [0.3, 0.2, 4.0]]
COUNTS = np.arange(1, 4000)
SLEEPS, REGULAR = rigid.tilt_below(0.5), rigid.regular()


def states(scene: rigid.FreeBody | rigid.HeavyTop, **options: Any) -> list[Floats]:
    run = rigid.simulate(scene, OMEGA, ATTITUDE, t=TIMES, check=False, **options)
    assert run.attitude is not None
    return [run.omega, run.attitude]


def events() -> list[Floats]:
    watched = [rigid.crosses("L2", 0.2), rigid.turns("gamma1")]
    run = rigid.simulate(TOP, OMEGA, ATTITUDE, t=TIMES, events=watched)
    return [array for event in run.events for array in (event.t, event.omega, event.attitude)]


def moved() -> list[Floats]:
    motion = rigid.Motion(FORCED, OMEGA, ATTITUDE)
    for _ in range(50):
        motion.step(0.1, torque=(0.0, 0.1, 0.0))
    return [motion.omega, motion.attitude, np.array(motion.t)]


def mapped(stable: Any) -> list[Floats]:
    result = rigid.stability_map(TOP, stable=stable, **MAP)
    names = ["share", "lower", "upper", "energy_drift", "earliest"]
    return [np.asarray(getattr(result, name)) for name in names]


COMPUTED: dict[str, Callable[[], list[Floats]]] = {
    "closed form": lambda: states(BOX),
    "closed form of a top": lambda: states(LAGRANGE),
    "tiny rates": lambda: [rigid.simulate(BOX, TINY, t=TIMES, check=False).omega],
    **{f"{m.name} of a top": partial(states, TOP, method=m.name) for m in METHODS},
    **{f"{m.name} of a body": partial(states, FORCED, method=m.name) for m in METHODS if m.forces},
    "etd4": lambda: states(FORCED, method="etd4"),
    "events": events,
    "steps of a motion": moved,
    "growth": lambda: [rigid.lyapunov(TOP, OMEGA, ATTITUDE, t=TIMES[1:]).log_growth],
    "flips": lambda: [np.asarray(rigid.exact.flip_times(BOX, OMEGA, count=3))],
    "map": lambda: mapped(SLEEPS),
    "map of verdicts": lambda: mapped(REGULAR),
    "principal axes": lambda: [np.array(_core.principal_axes(TENSOR)[1])],
    "unit quaternions": lambda: [_core.unit_quaternions(ATTITUDE[np.newaxis])],
    "intervals": lambda: list(_core.clopper_pearson(COUNTS, np.full_like(COUNTS, 4000), 0.95)),
}


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("name", COMPUTED)
def test_no_bit_follows_the_mode_of_the_processor(name: str, mode: str) -> None:
    expected = COMPUTED[name]()
    with float_mode(mode):
        before = control_word()
        found = COMPUTED[name]()
        assert control_word() == before
    for array, same in zip(found, expected, strict=True):
        assert array.tobytes() == same.tobytes()


def test_the_modes_are_those_of_the_thread() -> None:
    # Else the test above would show nothing.
    one, three, tiny = np.float64(1.0), np.float64(3.0), np.float64(2.0**-1022)
    thirds = {}
    for mode in MODES:
        with float_mode(mode):
            thirds[mode] = (one / three, tiny * np.float64(0.5) == 0.0, -one / three)
    assert thirds["up"][0] > thirds["down"][0] == thirds["to zero"][0]
    assert thirds["down"][2] < thirds["to zero"][2]
    assert thirds["flush"][1]
    assert not thirds["up"][1]


def test_intervals_hear_an_interrupt() -> None:
    # A second of work for each ten thousand intervals of so many trials.
    successes = np.arange(1, 1_000_000)

    def interrupt(_signal: int, _frame: FrameType | None) -> None:
        raise KeyboardInterrupt

    previous = signal.signal(signal.SIGALRM, interrupt)
    signal.setitimer(signal.ITIMER_REAL, 0.05)
    try:
        with pytest.raises(KeyboardInterrupt):
            _core.clopper_pearson(successes, np.full_like(successes, 2**50), 0.95)
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, previous)
