"""Time of maps by a custom criterion, over those of the criterion that states the same thing.

Processor time on one thread, median of interleaved repeats. ``python benches/custom_criterion.py``.
"""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray
from timing import counted, in_turns, over, parser, sized

import rigid

HORIZON = 50.0
SPINS, SAMPLES, REPEATS = sized((9, 500, 5), (3, 10, 1))

MAP: dict[str, Any] = {
    "scene": rigid.HeavyTop(rigid.Body((1.0, 1.2, 0.6)), mgl=1.0),
    "axes": {"spin": np.linspace(2.0, 6.0, SPINS)},
    "start": rigid.Start(spin=4.0, tilt=0.3, attitude_noise=rigid.normal(0.1)),
    "samples": SAMPLES,
    "check": 1.0,
    "rng": 3,
    "threads": 1,
    "progress": False,
}

LOOKS = (126, 251, 501)


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
    parser(__doc__).parse_args()
    pairs = {
        "no_flip(3)": (rigid.no_flip(3), keeps_its_sign, "rates"),
        "tilt_below(0.6)": (rigid.tilt_below(0.6), stays_low, "axis"),
        "tilt_below(3.0)": (rigid.tilt_below(3.0), is_not_hanging, "axis"),
    }
    print(f"{'criterion':18}{'of it':>10}" + "".join(f"{looks:>10} looks" for looks in LOOKS))
    for name, (criterion, function, of) in pairs.items():
        ways = {name: criterion}
        for looks in LOOKS:
            ways[str(looks)] = rigid.judged(function, np.linspace(0.0, HORIZON, looks), of=of)
        times = in_turns(
            {
                way: partial(rigid.stability_map, stable=stable, t_end=HORIZON, **MAP)
                for way, stable in ways.items()
            },
            lambda result: counted(result.columns, SPINS * SAMPLES),
            repeats=REPEATS,
        )
        own, *judged = (1e6 / (SPINS * SAMPLES) * turns for turns in times.values())
        row = "".join(
            f"{np.median(one):9.1f} us {over('judged over criterion', one, own):3.1f}"
            for one in judged
        )
        print(f"{name:18}{np.median(own):7.1f} us{row}")


if __name__ == "__main__":
    main()
