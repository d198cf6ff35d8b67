"""The error of a run falls as the step to the order that the method states."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import ArrayLike

import rigid
from physics import METHODS, ROUNDOFF, Golden, golden, golden_scene, present, rotation_angle

#: Scene, the time up to which it runs, and the largest of the six steps. At that step the leading
#: term of the error rules (the body turns by about 0.1 to 0.3 rad a step), and the error of the
#: shortest step, 1/32 of it, is still 20 times above the rounding plateau of rk4, some 1e-14 times
#: the angle turned: hence the short times.
REGIMES = [
    ("free_asymmetric/generic", 17.0, 0.1),
    ("free_asymmetric/axis2", 17.0, 0.2),
    ("lab_box/axis2_1rad_1e-1", 10.0, 0.1),
    ("heavy_asymmetric/regular_tumbling", 10.0, 0.05),
    ("lagrange/monotone", 1.0, 0.02),
    ("kovalevskaya/kov_a", 7.0, 0.1),
]

HALVINGS = 0.5 ** np.arange(6)


def errors(identifier: str, method: str, until: float, step: float) -> tuple[float, float]:
    """Root mean square over the reference times: at a single one the error could vanish."""
    case = golden_scene(identifier)
    run = case.run(method, until=until, step=step)
    m = len(run.t)
    assert run.attitude is not None
    of_rates = np.linalg.norm(run.omega - case.omega[:m], axis=-1)
    of_attitude = rotation_angle(run.attitude, case.attitude[:m])
    return float(np.sqrt(np.mean(of_rates**2))), float(np.sqrt(np.mean(of_attitude**2)))


def slope(steps: ArrayLike, error: ArrayLike) -> float:
    return float(np.polyfit(np.log(steps), np.log(error), 1)[0])


def fitted_order(identifier: str, method: rigid.Method, until: float) -> float:
    """Order of a method that reaches rounding within a few halvings.

    The steps divide the time to the last reference. ``log error = c + p log h + b h^2`` is fitted
    where the error lies between 1e-10 and 5e-13: so few powers of two that the next term of the
    error, b, must be known.
    """
    case = golden_scene(identifier)
    last = int(np.flatnonzero(case.t <= until)[-1])
    steps, found, count = [], [], 2
    while True:
        step = case.t[last] / count
        run = rigid.simulate(
            case.scene, case.omega0, case.attitude0, t=case.t[last], method=method.name, step=step
        )
        of_rates = float(np.linalg.norm(run.omega[0] - case.omega[last]))
        of_attitude = float(rotation_angle(present(run.attitude)[0], case.attitude[last]))
        error = float(np.hypot(of_rates, of_attitude))
        if error < 5e-13:
            break
        if error < 1e-10:
            steps.append(step)
            found.append(error)
        count = int(np.ceil(count * 2.0 ** (0.5 / method.order)))
    assert len(steps) >= 8
    h = np.array(steps)
    terms = np.column_stack([np.ones_like(h), np.log(h), h * h])
    order: float = np.linalg.lstsq(terms, np.log(found), rcond=None)[0][1]
    return order


LOW = [method for method in METHODS if method.order <= 4]
# The orders of the Taylor series are measured in single steps, by the tests of the core.
HIGH = [m for m in METHODS if m.order > 4 and not m.series]


@pytest.mark.parametrize(("identifier", "until", "largest"), REGIMES)
@pytest.mark.parametrize("method", LOW, ids=lambda method: method.name)
def test_measured_order_is_the_stated_order(
    method: rigid.Method, identifier: str, until: float, largest: float
) -> None:
    steps = largest * HALVINGS
    table = np.array([errors(identifier, method.name, until, float(step)) for step in steps])
    assert slope(steps, table[:, 0]) == pytest.approx(method.order, abs=0.1), "rates"
    assert slope(steps, table[:, 1]) == pytest.approx(method.order, abs=0.1), "attitude"


# The leading term of the others is so small that it does not rule above rounding.
@pytest.mark.parametrize(("identifier", "until", "largest"), REGIMES[1:5])
@pytest.mark.parametrize("method", HIGH, ids=lambda method: method.name)
def test_measured_order_of_methods_of_high_order(
    method: rigid.Method, identifier: str, until: float, largest: float
) -> None:
    assert fitted_order(identifier, method, until) == pytest.approx(method.order, abs=0.1)


def test_rk4_has_its_order_on_the_free_symmetric_body() -> None:
    steps = 0.05 * HALVINGS
    table = [errors("free_symmetric/prolate", "rk4", 9.0, float(step)) for step in steps]
    for error in np.array(table).T:
        assert slope(steps, error) == pytest.approx(4.0, abs=0.1)


SYMMETRIC = [c for c in golden("free_symmetric") if c.scene.body.symmetry_axis is not None]


@pytest.mark.parametrize("case", SYMMETRIC, ids=lambda case: case.id)
def test_splitting_of_the_free_symmetric_body_is_exact_for_any_step(case: Golden) -> None:
    """One step from each reference time to the next, whatever lies between."""
    run = case.run("splitting", step=float(case.t[-1]))
    assert run.steps == len(case.t) - 1
    assert run.attitude is not None
    # Rounding: the condition of the problem, and of each of the steps so far the same again.
    floor = 4.0 * ROUNDOFF * (1.0 + np.arange(len(case.t)))
    of_rates = np.linalg.norm(run.omega - case.omega, axis=-1)
    assert np.all(of_rates <= floor * case.kappa_omega * np.linalg.norm(case.omega, axis=-1))
    assert np.all(rotation_angle(run.attitude, case.attitude) <= floor * case.kappa_att)


def test_bodies_that_are_symmetric_but_for_rounding_are_not_rounded_to_symmetric_ones() -> None:
    """The table of a body follows from its moments to the bit; nearly symmetric ones are split."""
    case = golden_scene("free_symmetric/near_sym_1e-12")
    coarse, fine = (case.run("splitting", step=step) for step in (0.1, 0.05))
    error = [np.abs(run.omega - case.omega).max() for run in (coarse, fine)]
    assert error[0] / error[1] == pytest.approx(4.0, abs=0.1)
