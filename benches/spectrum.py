"""Time of all six exponents of tops over that of heyoka's variational equations.

    pip install heyoka && python benches/spectrum.py [--cells 16]

Tops of moments (1, 1.6, 0.7), released at tilts of 0.05 to 3.09 rad with spins of 0 to 8 rad/s,
over 200 s, one thread, processor time. rigid: `lyapunov(exponents=6)` by `taylor16`, no check.
heyoka: `var_ode_sys` of rates and vertical by all of them, in batches of registers, tolerance
1e-15, not in its slower compact mode; nothing is made orthogonal. Its compilation, of a minute, is
not counted.
"""

from __future__ import annotations

import argparse
from statistics import median
from time import process_time

import numpy as np

import rigid

MOMENTS, WEIGHT = (1.0, 1.6, 0.7), np.array([0.72, 0.0, 0.96])
T = 200.0


def starts(cells: int) -> tuple[np.ndarray, np.ndarray]:
    """Spins and tilts of the cells: rates and attitudes."""
    tilt, spin = np.meshgrid(np.linspace(0.05, 3.09, cells), np.linspace(0.0, 8.0, cells))
    omega = np.zeros((cells * cells, 3))
    omega[:, 2] = spin.ravel()
    half = 0.5 * tilt.ravel()
    zero = np.zeros_like(half)
    return omega, np.stack([np.cos(half), np.sin(half), zero, zero], axis=1)


def by_rigid(omega: np.ndarray, attitude: np.ndarray) -> float:
    """Processor time of a call (s)."""
    mgl = float(np.linalg.norm(WEIGHT))
    top = rigid.HeavyTop(rigid.Body(MOMENTS), mgl=mgl, com=WEIGHT / mgl)
    begin = process_time()
    rigid.lyapunov(top, omega, attitude, t=[T], exponents=6, of="attitude", check=False, threads=1)
    return process_time() - begin


def by_heyoka(omega: np.ndarray, attitude: np.ndarray):  # type: ignore[no-untyped-def]
    """A function that integrates the bodies and returns its processor time (s)."""
    import heyoka as hy

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
    solver = hy.taylor_adaptive_batch(system, np.zeros((6, width)), tol=1e-15, compact_mode=False)
    first = solver.state.copy()
    turned = np.stack(
        [
            np.zeros(len(omega)),
            np.sin(2.0 * np.arccos(attitude[:, 0])),
            2.0 * attitude[:, 0] ** 2 - 1.0,
        ]
    )

    def run() -> float:
        begin = process_time()
        for at in range(0, len(omega), width):
            solver.set_time(0.0)
            solver.state[:] = first
            solver.state[:3] = omega[at : at + width].T
            solver.state[3:6] = turned[:, at : at + width]
            solver.propagate_until(T)
        return process_time() - begin

    return run


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cells", type=int, default=16)
    parser.add_argument("--repeats", type=int, default=5)
    options = parser.parse_args()
    omega, attitude = starts(options.cells)
    theirs = by_heyoka(omega, attitude)
    times = [(by_rigid(omega, attitude), theirs()) for _ in range(options.repeats)]
    own, other = (1e3 * median(column) / len(omega) for column in zip(*times, strict=True))
    ratio = median(b / a for a, b in times)
    print(f"all exponents: {own:.2f} ms a top, heyoka {other:.2f} ms: {ratio:.1f} times")


if __name__ == "__main__":
    main()
