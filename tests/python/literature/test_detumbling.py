"""The coils of Delfi-PQ, and the steps by which they seem to stop it."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

import rigid
from rigid.literature.detumbling import GAIN, moments, moved, satellites

TUMBLING = np.full(3, np.pi)
START = np.array([0.0, 1.0, 0.0, 0.0])


def nominal(begun: float = 0.0) -> np.ndarray:
    """The numbers of a satellite without errors, and with two equal moments."""
    equal = np.array(moments())
    equal[:2] = equal[:2].mean()
    return np.array([begun, *equal, *(3 * [0.002]), 6e-5, -8e-5, 0.0, GAIN * equal.min()])


def field(t: float) -> np.ndarray:
    """Dipole of the Earth in the axes of space (T), by rotations."""
    radius = 6728.137e3
    angle = np.radians(60.0) + np.sqrt(3.9860044181e14 / radius**3) * t
    plane = Rotation.from_euler("ZX", [210.0, 96.84895], degrees=True)
    up = plane.apply([np.cos(angle), np.sin(angle), 0.0])
    years = 2018.0 + 212.0 / 365.0 - 2015.0
    of_earth = [-1501.0 + 18.1 * years, 4797.1 - 26.6 * years, -29442.0 + 10.3 * years]
    day = 86400.0 * 365.24 / 366.24
    dipole = Rotation.from_euler("Z", 2.0 * np.pi * t / day).apply(of_earth)
    return np.asarray(1e-9 * (6371.2e3 / radius) ** 3 * (3.0 * (dipole @ up) * up - dipole))


def after_cycles(data: np.ndarray, omega: np.ndarray, cycles: int) -> np.ndarray:
    """Rates after cycles in which the coils hold their dipole, by DOP853 of SciPy."""
    body, most, stays, gain = data[1:4], data[4:7], data[7:10], data[10]

    def change(t: float, y: np.ndarray, dipole: np.ndarray) -> np.ndarray:
        rates, (x, y_, z, w) = y[:3], y[3:]
        here = Rotation.from_quat(y[3:]).inv().apply(field(data[0] + t))
        torque = np.cross(dipole, here) - np.cross(rates, body * rates)
        a, b, c = 0.5 * rates
        turn = [w * a + y_ * c - z * b, w * b + z * a - x * c, w * c + x * b - y_ * a]
        return np.array([*(torque / body), *turn, -x * a - y_ * b - z * c])

    def later(t: float, y: np.ndarray, dipole: np.ndarray, time: float) -> np.ndarray:
        made = solve_ivp(change, (t, t + time), y, "DOP853", rtol=1e-11, atol=1e-13, args=(dipole,))
        return np.asarray(made.y[:, -1])

    def reading(t: float, y: np.ndarray) -> tuple[np.ndarray, float]:
        here = Rotation.from_quat(y[3:]).inv().apply(field(data[0] + t))
        size = float(np.linalg.norm(here))
        return here / size, size

    state = np.array([*omega, *START[1:], START[0]])
    before, _ = reading(-0.25, later(0.0, state, np.zeros(3), -0.25))
    for cycle in range(cycles):
        t = 0.25 * cycle
        now, size = reading(t, state)
        wanted = -gain * (now - before) / 0.25 / size
        on = 0.25 * 0.6 * np.minimum(1.0, np.abs(wanted) / most)
        dipole = np.sign(wanted) * (on - 0.01) * most / 0.25
        state, before = later(t, state, dipole + stays, 0.25), now
    return state[:3]


@pytest.mark.parametrize("spin", [1.0, 0.04])
def test_coils_hold_their_dipole_from_reading_to_reading(spin: float) -> None:
    """As in a loop over cycles; the coils of slow bodies are partly on, those of fast ones full."""
    data, cycles = nominal(9000.0), 24
    t = np.array([0.25 * cycles])
    run = moved(data, spin * TUMBLING, START, t, step=1.0 / 64.0)
    free = rigid.simulate(rigid.Body(data[1:4]), spin * TUMBLING, START, t=t)
    found = run.omega[0] - free.omega[0]
    truth = after_cycles(data, spin * TUMBLING, cycles) - free.omega[0]
    # The field of now stands for that of the readings. On the orbit it turns by at most
    # 3 n T = 9e-4 rad in a cycle, and its size changes by less; the body turns by 1.4 or 0.05 rad.
    turn = 0.25 * float(np.linalg.norm(spin * TUMBLING))
    bound = 9e-4 * (1.0 + 1.0 / turn) * np.abs(truth).max()
    np.testing.assert_allclose(found, truth, rtol=0.0, atol=bound)


def test_the_error_of_the_source_takes_the_energy_of_a_body_that_no_torque_slows() -> None:
    """More than a third in an hour. In a time it goes as the fifth power of the step of rk4."""
    body = rigid.Body(moments())
    lost = []
    for step in (1.0 / 8.0, 1.0 / 16.0, 1.0 / 64.0):
        run = rigid.simulate(body, TUMBLING, t=[0.0, 3600.0], method="rk4", step=step, check=False)
        energy = run.energy()
        lost.append(1.0 - energy[1] / energy[0])
    assert lost[0] > 0.35
    # The next order, and the slowing itself: 1.6 % of the energy.
    assert lost[1] / lost[2] == pytest.approx(4.0**5, rel=0.02)


def test_accurate_steps_lose_less_than_a_hundredth_in_the_hour() -> None:
    """A coil that is held while the body turns by 1.4 rad hardly brakes it."""
    pytest.importorskip("numba")
    left = []
    for step in (1.0 / 8.0, 1.0 / 64.0):
        run = moved(nominal(), TUMBLING, START, np.array([0.0, 3600.0]), step)
        energy = run.energy()
        left.append(energy[1] / energy[0])
    assert left[0] < 0.65
    assert left[1] > 0.99


def test_moments_are_those_of_the_stored_runs() -> None:
    """Means of the 500 runs; those of the masses err by 17 % / √500."""
    assert moments() == pytest.approx([1.722e-3, 1.711e-3, 0.263e-3], rel=0.02)
    drawn = satellites(500, 1)[:, 1:4]
    assert drawn.mean(axis=0) == pytest.approx(moments(), rel=0.01)
    # 1/6 of the mass and 5 % of each moment.
    assert drawn.std(axis=0) / moments() == pytest.approx(np.hypot(1.0 / 6.0, 0.05), rel=0.05)
