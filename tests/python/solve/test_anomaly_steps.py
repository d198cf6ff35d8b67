"""Equal steps of `rk4` and `dop853` on an orbit alone are those of its eccentric anomaly."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

import rigid
from physics import Floats

RATE, ECCENTRICITIES = 0.7, (0.0, 0.1, 0.5, 0.9, 0.95)
ORDERS = {"rk4": 4, "dop853": 8}
TIMES = np.array([-3.0, 0.0, 1.0, 4.0, 9.0])


def orbit(e: float) -> rigid.Orbit:
    return rigid.Orbit(RATE, e, 2.0, normal=(0.0, 0.6, 0.8))


def scene(e: float) -> rigid.FreeBody:
    return rigid.FreeBody(rigid.Body((0.9, 1.3, 1.1)), orbit=orbit(e))


def cloud(count: int) -> tuple[Floats, Floats]:
    rng = np.random.default_rng(4)
    attitudes = rng.normal(size=(count, 4))
    return rng.normal(size=(count, 3)), attitudes / np.linalg.norm(attitudes, axis=1)[:, None]


def simulated(e: float, count: int, **options: Any) -> rigid.Run:
    rates, attitudes = cloud(count)
    return rigid.simulate(scene(e), rates, attitudes, t=TIMES, check=False, **options)


def anomaly_at(e: float, t: float) -> float:
    """By bisection of Kepler's equation."""
    mean = RATE * t + 2.0
    return float(brentq(lambda at: at - e * np.sin(at) - mean, mean - 1.0, mean + 1.0, xtol=1e-15))


def attitudes_apart(run: rigid.Run, other: rigid.Run) -> float:
    assert run.attitude is not None
    assert other.attitude is not None
    sign = np.sign(np.sum(run.attitude * other.attitude, axis=-1, keepdims=True))
    return float(np.abs(sign * run.attitude - other.attitude).max())


@pytest.mark.parametrize("e", ECCENTRICITIES)
@pytest.mark.parametrize("method", ORDERS)
def test_errors_fall_with_the_order_in_the_anomaly(e: float, method: str) -> None:
    exact = simulated(e, 8, method="taylor20", tolerance=1e-16)
    # Few enough steps that the error is above that of rounding, for all eccentricities.
    counts = (1600, 3200) if method == "rk4" else (100, 200)
    errors = []
    for count in counts:
        step = 9.0 / (count * (4 if e > 0.5 else 1))
        run = simulated(e, 8, method=method, step=step)
        off = np.abs(run.omega - exact.omega).max() / np.abs(exact.omega).max()
        errors.append(max(float(off), attitudes_apart(run, exact)))
    assert errors[1] < 1e-6
    fell = np.log2(errors[0] / errors[1])
    # Half an order is that of the next term. Where rounding is reached no order is left.
    assert abs(fell - ORDERS[method]) < 0.5 or errors[1] < 1e-11


@pytest.mark.parametrize("e", [0.0, 0.3])
def test_a_step_is_the_mean_motion_times_the_given_time(e: float) -> None:
    step = 0.05
    run = simulated(e, 1, method="dop853", step=step)
    anomalies = [anomaly_at(e, t) for t in TIMES]
    # Legs begin at 0 in both directions; each ends at an output time.
    legs = np.abs(np.diff(anomalies))
    assert run.steps[0] == np.ceil(legs / (RATE * step) - 1e-9).sum()


@pytest.mark.parametrize("method", ORDERS)
def test_the_jacobi_integral_is_the_drift_on_a_circle(method: str) -> None:
    step = 0.2 if method == "dop853" else 0.01
    run = simulated(0.0, 4, method=method, step=step)
    assert run.attitude is not None
    jacobi = rigid.free.jacobi_integral(scene(0.0), run.omega, run.attitude, TIMES)
    off = np.abs(jacobi - jacobi[:, 1:2]).max(axis=1)
    # Relative to the kinetic energy and to what the orbit can add.
    scale = off / run.energy_drift
    kinetic = run.energy()[:, 1]
    assert (run.energy_drift > 1e-13).all()
    assert (run.energy_drift < 1e-7).all()
    assert ((scale > 0.9 * kinetic) & (scale < 100.0 * kinetic)).all()
    assert np.isnan(run.momentum_drift).all()
    eccentric = simulated(0.1, 4, method=method, step=step)
    assert np.isnan(eccentric.energy_drift).all()
    assert np.isnan(eccentric.momentum_drift).all()
    assert (eccentric.unit_drift < 1e-9).all()


def test_the_work_is_that_of_a_series_in_the_time() -> None:
    run = simulated(0.5, 8, method="dop853", step=0.01)
    exact = simulated(0.5, 8, method="taylor20", tolerance=1e-16)
    assert run.work is not None
    assert exact.work is not None
    assert np.abs(run.work - exact.work).max() < 1e-12 * np.abs(exact.energy()).max()


def test_the_attitude_is_continuous_over_many_orbits() -> None:
    body = scene(0.3)
    t = np.linspace(0.0, 60.0, 1201)
    run = rigid.simulate(body, [0.1, 0.2, 0.9], t=t, method="dop853", step=0.05, check=False)
    assert run.attitude is not None
    # Between two times the body turns by less than 0.2 rad.
    assert np.abs(np.diff(run.attitude, axis=0)).max() < 0.1
    few = rigid.simulate(body, [0.1, 0.2, 0.9], t=t[::100], method="dop853", step=0.05, check=False)
    assert few.attitude is not None
    # The same sign where no time lies between, and the same motion within its error.
    np.testing.assert_allclose(few.attitude, run.attitude[::100], atol=1e-8)


@pytest.mark.parametrize("method", ORDERS)
def test_the_stated_error_is_no_less_than_the_true_one(method: str) -> None:
    rates, attitudes = cloud(32)  # of more some are not checked
    es = np.linspace(0.0, 0.9, 32)
    many = rigid.FreeBody(rigid.Body((0.9, 1.3, 1.1)), orbit=rigid.Orbit(RATE, es, 2.0))
    exact = rigid.simulate(
        many, rates, attitudes, t=[9.0], method="taylor20", tolerance=1e-16, check=False
    )
    for step in (0.1, 0.02):
        run = rigid.simulate(many, rates, attitudes, t=[9.0], method=method, step=step)
        sizes = np.linalg.norm(exact.omega[:, 0], axis=1)
        off = np.linalg.norm((run.omega - exact.omega)[:, 0], axis=1) / sizes
        assert np.isin(run.status, (rigid.Status.OK, rigid.Status.COARSE)).all()
        assert (off <= run.error).all()


def test_steps_that_are_counted_are_those_of_the_time() -> None:
    # A motion is told its steps in the time.
    motion = rigid.Motion(scene(0.5), [0.3, 0.2, 0.9], method="dop853")
    for _ in range(40):
        motion.step(0.025)
    run = rigid.simulate(
        scene(0.5), [0.3, 0.2, 0.9], t=[1.0], method="taylor20", tolerance=1e-16, check=False
    )
    np.testing.assert_allclose(motion.omega, run.omega[0], atol=1e-12)


def test_a_slow_orbit_keeps_the_digits_of_the_time() -> None:
    # The gradient of 1e-16 is nothing beside the rates: the motion is that of a free body.
    body = rigid.Body((0.9, 1.3, 1.1))
    far = rigid.FreeBody(body, orbit=rigid.Orbit(1e-8, 0.3, 2.0))
    t = [10.0, 100.0]
    run = rigid.simulate(far, [1.0, 2.0, 0.5], t=t, method="dop853", step=0.01, check=False)
    free = rigid.simulate(rigid.FreeBody(body), [1.0, 2.0, 0.5], t=t, method="exact")
    np.testing.assert_allclose(run.omega, free.omega, rtol=0.0, atol=1e-12)
    assert attitudes_apart(run, free) < 1e-12
