"""Time of all six exponents of tops over that of heyoka's variational equations.

    pip install heyoka && python benches/spectrum.py [--cells 16]

Tops of moments (1, 1.6, 0.7), released at tilts of 0.05 to 3.09 rad with spins of 0 to 8 rad/s,
over 200 s, one thread, processor time. rigid: `lyapunov(exponents=6)` by `taylor16`, no check.
heyoka: `var_ode_sys` of rates and vertical by all of them, in batches of registers, tolerance
1e-15, not in its slower compact mode; nothing is made orthogonal. Its compilation, of a minute, is
not counted.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from timing import QUICK, Moved, in_turns, installed, moved, over, parser, sized

import rigid

MOMENTS, WEIGHT = (1.0, 1.6, 0.7), np.array([0.72, 0.0, 0.96])
T = sized(200.0, 10.0)


def starts(cells: int) -> tuple[np.ndarray, np.ndarray]:
    """Spins and tilts of the cells: rates and attitudes."""
    tilt, spin = np.meshgrid(np.linspace(0.05, 3.09, cells), np.linspace(0.0, 8.0, cells))
    omega = np.zeros((cells * cells, 3))
    omega[:, 2] = spin.ravel()
    half = 0.5 * tilt.ravel()
    zero = np.zeros_like(half)
    return omega, np.stack([np.cos(half), np.sin(half), zero, zero], axis=1)


def by_rigid(omega: np.ndarray, attitude: np.ndarray) -> Callable[[], Moved]:
    """A function that computes the exponents of the bodies."""
    mgl = float(np.linalg.norm(WEIGHT))
    top = rigid.HeavyTop(rigid.Body(MOMENTS), mgl=mgl, com=WEIGHT / mgl)
    options = {"exponents": 6, "of": "attitude", "check": False, "threads": 1}

    def run() -> Moved:
        found = rigid.lyapunov(top, omega, attitude, t=[T], **options)
        return found.spectrum[:, -1], 0.0, found.steps

    return run


def by_heyoka(hy: Any, omega: np.ndarray, attitude: np.ndarray) -> Callable[[], Moved]:
    """A function that integrates the bodies with all deviation vectors."""
    w1, w2, w3, g1, g2, g3 = variables = hy.make_vars("w1", "w2", "w3", "g1", "g2", "g3")
    (i1, i2, i3), (c1, c2, c3) = MOMENTS, WEIGHT
    rates = [
        ((i2 - i3) * w2 * w3 + g2 * c3 - g3 * c2) / i1,
        ((i3 - i1) * w3 * w1 + g3 * c1 - g1 * c3) / i2,
        ((i1 - i2) * w1 * w2 + g1 * c2 - g2 * c1) / i3,
        g2 * w3 - g3 * w2,
        g3 * w1 - g1 * w3,
        g1 * w2 - g2 * w1,
    ]
    system = hy.var_ode_sys(list(zip(variables, rates, strict=True)), hy.var_args.vars, order=1)
    width = hy.recommended_simd_size()
    solver = hy.taylor_adaptive_batch(system, np.zeros((6, width)), tol=1e-15, compact_mode=QUICK)
    first = solver.state.copy()
    turned = np.stack(
        [
            np.zeros(len(omega)),
            np.sin(2.0 * np.arccos(attitude[:, 0])),
            2.0 * attitude[:, 0] ** 2 - 1.0,
        ]
    )

    def run() -> Moved:
        begin, end = np.tile(first, (1, len(omega) // width)), []
        begin[:6] = np.concatenate([omega.T, turned])
        for at in range(0, len(omega), width):
            solver.set_time(0.0)
            solver.state[:] = begin[:, at : at + width]
            solver.propagate_until(T)
            end.append(solver.state.copy())
        return np.concatenate(end, axis=1).T, begin.T

    return run


def main() -> None:
    arguments = parser(__doc__)
    arguments.add_argument("--cells", type=int, default=sized(16, 4))
    arguments.add_argument("--repeats", type=int, default=sized(5, 1))
    options = arguments.parse_args()
    omega, attitude = starts(options.cells)
    sides = {"rigid": by_rigid(omega, attitude)}
    heyoka = installed("heyoka")
    if heyoka is not None:
        sides["heyoka"] = by_heyoka(heyoka, omega, attitude)
    times = in_turns(sides, lambda found: moved(*found), repeats=options.repeats)
    for name, seconds in times.items():
        ratio = over(f"{name} over rigid", seconds, times["rigid"])
        row = f"all exponents by {name}: {1e3 * np.median(seconds) / len(omega):.2f} ms a top"
        print(f"{row}, {ratio:.1f} times the time of rigid")


if __name__ == "__main__":
    main()
