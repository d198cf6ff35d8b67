"""Time of integrated maps with their check, over the bare integration and over a check of all.

Processor time on one thread, median of interleaved repeats. ``python benches/map_check.py``.
"""

from __future__ import annotations

import statistics
import time
from typing import Any

import numpy as np

import rigid

COM = np.array([0.36, 0.24, 1.1]) / np.linalg.norm([0.36, 0.24, 1.1])

MAPS: dict[str, dict[str, Any]] = {
    "asymmetric top": {
        "scene": rigid.HeavyTop(rigid.Body((1.0, 1.6, 0.7)), mgl=1.0, com=COM),
        "axes": {"mgl": np.linspace(0.05, 1.2, 24), "noise": np.geomspace(1e-4, 1e-2, 24)},
        "start": rigid.Start(spin=1.5, axis=3, noise=rigid.normal(1e-3)),
        "stable": rigid.tilt_below(3.0),
        "t_end": 20.0,
        "samples": 64,
    },
    "falling top": {
        "scene": rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0),
        "axes": {"spin": np.linspace(3.0, 12.0, 18), "damping3": np.geomspace(5e-4, 0.02, 12)},
        "start": rigid.Start(spin=5.0, attitude_noise=rigid.normal(0.01)),
        "stable": rigid.tilt_below(0.5),
        "t_end": 100.0,
        "samples": 16,
    },
}

WAYS: dict[str, dict[str, Any]] = {
    "bare": {"check": 0.0},
    "checked": {},
    "all checked": {"check": 1.0},
    "rk4, all checked": {"method": "rk4", "check": 1.0},
}

REPEATS = 5


def main() -> None:
    """Print the table."""
    print(f"{'map':16}" + "".join(f"{way:>18}" for way in WAYS) + f"{'checked / bare':>16}")
    for name, request in MAPS.items():
        times: dict[str, list[float]] = {way: [] for way in WAYS}
        for _ in range(REPEATS):
            for way, options in WAYS.items():
                begin = time.process_time()
                result = rigid.stability_map(**request, **options, rng=1, threads=1, progress=False)
                spent = time.process_time() - begin
                times[way].append(1e6 * spent / result.samples.sum())
        median = {way: statistics.median(values) for way, values in times.items()}
        row = "".join(f"{median[way]:15.2f} us" for way in WAYS)
        print(f"{name:16}{row}{median['checked'] / median['bare']:16.2f}")


if __name__ == "__main__":
    main()
