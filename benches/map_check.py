"""Time of integrated maps with their check, over the bare integration and over a check of all.

Processor time on one thread, median of interleaved repeats. ``python benches/map_check.py``.
"""

from __future__ import annotations

import math
from functools import partial
from typing import Any

import numpy as np
from timing import Floats, counted, in_turns, over, parser, sized

import rigid

PIXELS, FALLING, SAMPLES, REPEATS = sized((24, 12, 16, 5), (3, 2, 2, 1))
"""Pixels of an axis of the first map and of the second; samples of the second; turns."""

COM = np.array([0.36, 0.24, 1.1]) / np.linalg.norm([0.36, 0.24, 1.1])

MAPS: dict[str, dict[str, Any]] = {
    "asymmetric top": {
        "scene": rigid.HeavyTop(rigid.Body((1.0, 1.6, 0.7)), mgl=1.0, com=COM),
        "axes": {
            "mgl": np.linspace(0.05, 1.2, PIXELS),
            "noise": np.geomspace(1e-4, 1e-2, PIXELS),
        },
        "start": rigid.Start(spin=1.5, axis=3, noise=rigid.normal(1e-3)),
        "stable": rigid.tilt_below(3.0),
        "t_end": 20.0,
        "samples": 4 * SAMPLES,
    },
    "falling top": {
        "scene": rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0),
        "axes": {
            "spin": np.linspace(3.0, 12.0, FALLING * 3 // 2),
            "damping3": np.geomspace(5e-4, 0.02, FALLING),
        },
        "start": rigid.Start(spin=5.0, attitude_noise=rigid.normal(0.01)),
        "stable": rigid.tilt_below(0.5),
        "t_end": 100.0,
        "samples": SAMPLES,
    },
}

WAYS: dict[str, dict[str, Any]] = {
    "bare": {"check": 0.0},
    "checked": {},
    "all checked": {"check": 1.0},
    "rk4, all checked": {"method": "rk4", "check": 1.0},
}


def microseconds(request: dict[str, Any]) -> dict[str, Floats]:
    """Processor time of a body in each way."""
    bodies = request["samples"] * math.prod(len(axis) for axis in request["axes"].values())
    common = {**request, "rng": 1, "threads": 1, "progress": False}
    times = in_turns(
        {way: partial(rigid.stability_map, **common, **more) for way, more in WAYS.items()},
        lambda result: counted(result.columns, bodies),
        repeats=REPEATS,
    )
    return {way: 1e6 / bodies * seconds for way, seconds in times.items()}


def main() -> None:
    """Print the table."""
    parser(__doc__).parse_args()
    print(f"{'map':16}" + "".join(f"{way:>18}" for way in WAYS) + f"{'checked / bare':>16}")
    for name, request in MAPS.items():
        times = microseconds(request)
        row = "".join(f"{np.median(times[way]):15.2f} us" for way in WAYS)
        print(f"{name:16}{row}{over('checked / bare', times['checked'], times['bare']):16.2f}")


if __name__ == "__main__":
    main()
