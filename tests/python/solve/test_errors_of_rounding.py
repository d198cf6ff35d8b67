"""What rounding leaves in a run and in its check alike is stated too."""

from __future__ import annotations

import numpy as np
import pytest

import rigid
from physics import METHODS

ALMOST_A_SPHERE = (2.0 + 3e-9, 2.0 + 1e-9, 2.0 + 2.5e-9)


@pytest.mark.parametrize("method", METHODS, ids=lambda method: method.name)
def test_rates_of_almost_a_sphere_lose_the_same_rounding_each_step(method: rigid.Method) -> None:
    """The closed form is the truth: it errs by 1e-15 for each radian."""
    free = rigid.FreeBody(rigid.Body(ALMOST_A_SPHERE))
    rng = np.random.default_rng(1)
    for _ in range(6):
        omega, attitude = rng.normal(size=3), rng.normal(size=4)
        omega /= np.linalg.norm(omega)
        t, step = [rng.uniform(100.0, 300.0)], 10.0 ** rng.uniform(-1.7, -1.0)
        run = rigid.simulate(free, omega, attitude, t=t, method=method.name, step=step)
        truth = rigid.simulate(free, omega, attitude, t=t, method="exact")
        assert run.attitude is not None
        assert truth.attitude is not None
        # Quaternions are apart by half the angle.
        apart = min(np.linalg.norm(run.attitude + sign * truth.attitude) for sign in (-1.0, 1.0))
        assert 2.0 * apart <= run.error + truth.error


def test_what_no_step_changes_is_lost_whatever_the_steps() -> None:
    """Damping has ended the spin of a needle; the other rates change by less than a rounding."""
    needle = rigid.Body((0.2303702143799708, 0.23036942072553382, 3.6645151054448544e-06))
    scene = rigid.FreeBody(needle, damping=[0.0, 0.0, 103.57])
    omega, t = [0.7318133169566279, -0.5486510356094831, -1.0492894760476998], [2.45e-5]
    run = rigid.simulate(scene, omega, t=t, method="taylor12", record="rates")
    truth = rigid.simulate(scene, omega, t=t, method="taylor16", tolerance=1e-15, record="rates")
    off = np.linalg.norm(run.omega - truth.omega) / np.linalg.norm(truth.omega)
    assert 1e-14 < off <= run.error < 1e-12


def test_rates_of_a_top_that_hangs_all_but_still_carry_the_rounding_of_its_vertical() -> None:
    """Its swing of 1e-9 rad/s moves the vertical by less than a rounding in many a step."""
    body = rigid.Body((0.2954834774489046, 1.2173776693824097, 1.0451217024068815))
    com = (-0.5916854832714615, 0.479999855994827, -0.6476947021018177)
    top = rigid.HeavyTop(body, mgl=9.016663606144977, com=com)
    omega = [-1.471321292828963e-09, 1.3140610169210498e-09, -8.337226829351962e-10]
    attitude = [0.5873751745868392, -0.4196014785879164, -0.009340665928735975, -0.691981036883181]
    t = [49.099960006262855]
    run = rigid.simulate(top, omega, attitude, t=t, method="taylor12", step=0.0358662)
    truth = rigid.simulate(top, omega, attitude, t=t, method="taylor26", tolerance=1e-17)
    off = np.linalg.norm(run.omega - truth.omega) / np.linalg.norm(truth.omega)
    assert 1e-7 < off < run.error < 1e-4
