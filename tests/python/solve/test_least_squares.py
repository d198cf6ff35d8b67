"""Sums of squares inside a box: the minimum, and what an iteration says that it left."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import least_squares, lsq_linear

from physics import Floats
from rigid.solve.least_squares import minimum

#: What the residuals tell to within these is looked for.
SIZES = np.full(2, 100.0)
EVERYWHERE = np.full(2, -np.inf), np.full(2, np.inf)


def valley(x: Floats) -> Floats:
    """Rosenbrock's curved valley, 1000 times as narrow as it is long."""
    return np.array([1000.0 * (x[1] - x[0] ** 2), 1.0 - x[0]])


def slopes_of_valley(x: Floats) -> Floats:
    return np.array([[-2000.0 * x[0], 1000.0], [-1.0, 0.0]])


def test_a_curved_valley_is_followed_to_its_end() -> None:
    first = np.array([-1.2, 1.0])
    found = minimum(valley, slopes_of_valley, first, EVERYWHERE, SIZES, gain=1e-20, most=60)
    assert found.gain <= 1e-20
    # Across the valley a residual of 1e-10 is 1e-13; along it, 1e-10.
    assert np.allclose(found.x, 1.0, rtol=0.0, atol=3e-10)
    # Steps that bend with the valley are longer: straight ones of the same method take 190.
    straight = least_squares(valley, first, slopes_of_valley, method="lm", xtol=1e-12)
    assert straight.njev > 3 * 60


def test_a_minimum_at_the_edge_of_the_box_is_that_of_scipy() -> None:
    rng = np.random.default_rng(0)
    for _ in range(20):
        matrix, right = rng.normal(size=(12, 4)), rng.normal(size=12)
        box = np.full(4, -0.1), np.full(4, 0.1)
        sizes = 10.0 ** rng.uniform(2.0, 4.0, 4)

        def residuals(x: Floats, matrix: Floats = matrix, right: Floats = right) -> Floats:
            off: Floats = matrix @ x - right
            return off

        def jacobian(_: Floats, matrix: Floats = matrix) -> Floats:
            return matrix

        found = minimum(residuals, jacobian, np.zeros(4), box, sizes, gain=1e-20, most=60)
        truth = lsq_linear(matrix, right, box, tol=1e-14)
        # lsq_linear stops inside its box by the root of its tolerance.
        assert np.allclose(found.x, truth.x, rtol=0.0, atol=1e-6)
        assert np.all(np.abs(found.x) <= 0.1)
        assert found.squares <= 2.0 * truth.cost * (1.0 + 1e-12)


@pytest.mark.parametrize("most", [1, 2])
def test_what_is_left_is_what_a_whole_step_gains(most: int) -> None:
    # For a linear model a straight step ends at the minimum: what is left is exact.
    matrix, right = np.array([[3.0, 1.0], [0.0, 2.0], [1.0, 0.0]]), np.array([1.0, 2.0, 3.0])
    found = minimum(
        lambda x: matrix @ x - right,
        lambda _: matrix,
        np.array([5.0, -7.0]),
        EVERYWHERE,
        SIZES,
        gain=1e-30,
        most=most,
    )
    least = np.linalg.lstsq(matrix, right)[1][0]
    assert found.gain == pytest.approx(found.squares - least, rel=1e-9)


def test_no_coordinate_is_free_in_a_corner() -> None:
    box = np.zeros(2), np.full(2, np.inf)
    found = minimum(
        lambda x: x + 1.0, lambda _: np.eye(2), np.ones(2), box, SIZES, gain=1e-12, most=40
    )
    assert found.x.tolist() == [0.0, 0.0]
    assert found.gain == 0.0


def test_what_the_residuals_do_not_tell_to_within_its_size_is_left() -> None:
    matrix = np.diag([100.0, 0.1])
    found = minimum(
        lambda x: matrix @ x - [100.0, 0.1],
        lambda _: matrix,
        np.zeros(2),
        EVERYWHERE,
        np.ones(2),
        gain=1e-12,
        most=40,
    )
    assert found.x[0] == pytest.approx(1.0, rel=1e-7)
    assert found.gain < 1e-12 < found.squares
