"""Time of maps that a function judges, over those of the criterion that states the same thing.

Processor time on one thread, median of interleaved repeats. ``python benches/judged.py``.
"""

from __future__ import annotations

import statistics
import time
from typing import Any

import numpy as np
from numpy.typing import NDArray

import rigid

HORIZON = 50.0

MAP: dict[str, Any] = {
    "scene": rigid.HeavyTop(rigid.Body((1.0, 1.2, 0.6)), mgl=1.0),
    "axes": {"spin": np.linspace(2.0, 6.0, 9)},
    "start": rigid.Start(spin=4.0, tilt=0.3, attitude_noise=rigid.normal(0.1)),
    "samples": 500,
    "check": 1.0,
    "rng": 3,
    "threads": 1,
    "progress": False,
}

LOOKS = (126, 251, 501)

REPEATS = 5


def keeps_its_sign(states: rigid.States) -> NDArray[np.bool_]:
    """As ``no_flip(3)``."""
    kept: NDArray[np.bool_] = np.all(states.omega[..., 2] > 0.0, axis=1)
    return kept


def stays_low(states: rigid.States) -> NDArray[np.bool_]:
    """As ``tilt_below(0.6)``."""
    assert states.gamma is not None
    kept: NDArray[np.bool_] = np.all(states.gamma[..., 2] > np.cos(0.6), axis=1)
    return kept


def is_not_hanging(states: rigid.States) -> NDArray[np.bool_]:
    """As ``tilt_below(3.0)``."""
    assert states.gamma is not None
    kept: NDArray[np.bool_] = np.all(states.gamma[..., 2] > np.cos(3.0), axis=1)
    return kept


def main() -> None:
    """Print the table."""
    pairs = {
        "no_flip(3)": (rigid.no_flip(3), keeps_its_sign, "rates"),
        "tilt_below(0.6)": (rigid.tilt_below(0.6), stays_low, "axis"),
        "tilt_below(3.0)": (rigid.tilt_below(3.0), is_not_hanging, "axis"),
    }
    print(f"{'criterion':18}{'of it':>10}" + "".join(f"{looks:>10} looks" for looks in LOOKS))
    for name, (criterion, function, of) in pairs.items():
        ways = [criterion] + [
            rigid.judged(function, np.linspace(0.0, HORIZON, looks), of=of) for looks in LOOKS
        ]
        times: list[list[float]] = [[] for _ in ways]
        for _ in range(REPEATS):
            for way, stable in zip(times, ways, strict=True):
                begin = time.process_time()
                result = rigid.stability_map(stable=stable, t_end=HORIZON, **MAP)
                way.append(1e6 * (time.process_time() - begin) / result.samples.sum())
        own, *judged = (statistics.median(way) for way in times)
        row = "".join(f"{one:9.1f} us {one / own:3.1f}" for one in judged)
        print(f"{name:18}{own:7.1f} us{row}")


if __name__ == "__main__":
    main()
