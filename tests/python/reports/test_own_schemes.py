"""Own schemes in reports: the same bodies, reference and axes as the methods of the library."""

import json
import re
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import rigid
from physics import Floats
from refusals import refuses
from rigid.model.scene import Scene
from rigid.reports.plot import OTHERS, colour_of

BOX = rigid.FreeBody(rigid.Body((1.0, 1.5, 2.0)))
TOP = rigid.HeavyTop(rigid.Body((1.0, 1.6, 0.7)), mgl=1.2, com=(0.6, 0.0, 0.8))
START = (0.3, 1.0, 0.2)


def reported(*methods: Any, scene: Scene = BOX, **options: Any) -> rigid.Report:
    given = {"bodies": 1, "seconds": 10.0, "progress": False, **options}
    return rigid.report(scene, START, methods=methods, **given)


def rates_of_change(scene: Any, omega: Floats, attitude: Floats) -> tuple[Floats, Floats]:
    """Euler's equations with weight, and those of a quaternion, written out here."""
    i = np.array(scene.body.moments)
    w, x, y, z = attitude.T
    up = np.stack([2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z], -1)
    torque = np.cross(i * omega, omega) + np.cross(up, scene.weight)
    p, q, r = omega.T
    turning = [-x * p - y * q - z * r, w * p + y * r - z * q, w * q + z * p - x * r]
    turning.append(w * r + x * q - y * p)
    return torque / i, 0.5 * np.stack(turning, axis=-1)


def energy(scene: Any, omega: Floats, attitude: Floats) -> float:
    w, x, y, z = attitude[0] / np.linalg.norm(attitude[0])
    up = np.array([2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z])
    return float(0.5 * np.array(scene.body.moments) @ omega[0] ** 2 + scene.weight @ up)


def heun(scene: Any, t: float, omega: Floats, attitude: Floats, step: float, count: int) -> Any:
    """The explicit trapezoidal rule, of order 2."""
    for _ in range(count):
        one = rates_of_change(scene, omega, attitude)
        two = rates_of_change(scene, omega + step * one[0], attitude + step * one[1])
        omega = omega + 0.5 * step * (one[0] + two[0])
        attitude = attitude + 0.5 * step * (one[1] + two[1])
    return omega, attitude


def by_scipy(scene: Any, t: float, omega: Floats, attitude: Floats, step: float, count: int) -> Any:
    """An adaptive solver, for which steps mean nothing."""

    def slope(_: float, state: Floats) -> Floats:
        parts = rates_of_change(scene, state[:, None][:3].T, state[:, None][3:].T)
        return np.concatenate([part[0] for part in parts])

    for k in range(len(omega)):
        start = np.concatenate([omega[k], attitude[k]])
        end = solve_ivp(slope, (0.0, step * count), start, rtol=1e-10, atol=1e-12).y[:, -1]
        omega[k], attitude[k] = end[:3], end[3:]
    return omega, attitude


@pytest.mark.parametrize("scene", [BOX, TOP])
def test_an_own_scheme_has_its_order_and_its_errors(scene: Scene) -> None:
    report = reported("rk4", rigid.scheme("heun", heun), scene=scene, t_end=1.0, errors=[1e-3])
    assert report.order("heun") == pytest.approx(2.0, abs=0.15)
    assert report.order("rk4") == pytest.approx(4.0, abs=0.3)
    truth = rigid.simulate(scene, START, t=[1.0], accuracy=1e-12)
    for row in report.of("heun"):
        assert row.step is not None
        first = np.array([START]), np.array([[1.0, 0.0, 0.0, 0.0]])
        omega, attitude = heun(scene, 0.0, *first, row.step, row.steps)
        # One body: the median is its error, to the uncertainty of the reference.
        off = np.abs(omega[0] - truth.omega[0]).max()
        scale = max(np.linalg.norm(START), float(np.linalg.norm(truth.omega[0])))
        assert row.rates_error == pytest.approx(off / scale, abs=1e-11)
        assert row.nanoseconds > 0.0
        start, end = energy(scene, *first), energy(scene, omega, attitude)
        kinetic = 0.5 * float(np.array(scene.body.moments) @ np.square(START))
        drift = abs(end - start) / (kinetic + float(np.linalg.norm(scene.weight)))
        assert row.energy_drift == pytest.approx(drift, rel=1e-6, abs=1e-13)
    # It stands beside ours: in the table, in the picture and in the file.
    assert re.search(r"^heun +- +2\.\d", str(report), re.MULTILINE)
    drawn = [line.get_label() for line in report.plot().get_lines()]
    assert {"heun", "rk4"} <= set(drawn)
    assert colour_of("heun") == OTHERS
    again = rigid.Report.from_json(report.to_json())
    assert again == report
    assert "schemes" not in json.loads(report.to_json())["spec"]


def test_an_own_solver_may_choose_its_steps() -> None:
    report = reported(rigid.scheme("scipy", by_scipy), t_end=1.0, bodies=2, errors=[1e-6])
    assert all(row.error < 1e-8 for row in report.of("scipy"))


def test_energy_of_an_own_scheme_grows_over_revolutions() -> None:
    """Heun's rule adds energy evenly: ten times the time, ten times the energy."""
    # A bound that no machine reaches: every step is measured.
    report = reported(rigid.scheme("heun", heun), revolutions=[3, 30], seconds=600.0)
    shortest = report.of("heun", 30.0)[-1]
    first, last = report.growth(shortest)
    assert last.energy_drift == pytest.approx(10.0 * first.energy_drift, rel=0.2)
    assert 0.0 < last.momentum_drift < 1e-2


def test_under_forces_the_energy_is_not_known() -> None:
    damped = rigid.FreeBody(rigid.Body((1.0, 1.5, 2.0)), damping=0.1)
    report = reported(rigid.scheme("heun", heun), scene=damped, t_end=0.1, errors=[1e-1])
    assert all(np.isinf(row.energy_drift) for row in report.rows)


def test_a_scheme_may_refuse_long_steps() -> None:
    """The first are of 4/7 s; steps are halved, and only what was run has a row."""

    def careful(scene: Any, t: float, omega: Floats, attitude: Floats, *how: Any) -> Any:
        if how[0] > 0.3:
            raise ValueError("so long a step would be unstable")
        return heun(scene, t, omega, attitude, *how)

    report = reported(rigid.scheme("careful", careful), t_end=4.0, errors=[1e-3])
    assert not report.refused
    assert report.rows[0].step == 4 / 14
    assert all(row.error < 0.1 for row in report.rows)


def unable(*_: object) -> Any:
    raise ValueError("needs no damping")


test_what_is_refused = refuses(
    [
        (lambda: rigid.scheme("", heun), TypeError, "name = '': must be a name"),
        (lambda: rigid.scheme("a", 3), TypeError, "function = 3: must be callable"),  # type: ignore[arg-type]
        (
            lambda: reported(rigid.scheme("rk4", heun), t_end=0.1),
            "methods[0] = 'rk4': is a method of the library",
        ),
        (
            lambda: reported(rigid.scheme("a", lambda *_: None), t_end=0.1),
            TypeError,
            "a: must return rates and attitudes of shapes (1, 3) and (1, 4), got None",
        ),
        (
            lambda: reported(rigid.scheme("a", unable), t_end=0.1),
            "methods = ['a']: none integrates the scene: a: needs no damping",
        ),
    ],
    literal=True,
)
