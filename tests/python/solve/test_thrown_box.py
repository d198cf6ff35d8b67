"""The box of a lab report: 0.25 m x 0.08 m x 0.01 m, thrown about each of its axes at 1 rad/s.

Axis 1 (the report's x) is normal to the largest face, axis 2 (y) is the middle one, axis 3 (z) is
along the longest side. The reference numbers come from a Taylor series in 40-digit arithmetic.
"""

from itertools import permutations

import pytest

import rigid
from physics import METHODS, ROUNDOFF, golden_number, present, rotation_matrix

BOX = rigid.Body.box(0.01, 0.08, 0.25)
SCENE = rigid.FreeBody(BOX)

#: The error of 30 s, and a step at which each method stays below its tolerance.
STEP = 2.5e-3

#: Error after a throw with that step, by the order.
ERRORS = {2: 3e-5}
SMALL = 2e-11


def test_moments_are_689_626_65() -> None:
    # A side in binary is half a roundoff off, its square one; squares, sums, mass/12: three more.
    assert [12e4 * moment for moment in BOX.moments] == pytest.approx(
        [689, 626, 65], rel=5 * ROUNDOFF
    )


def test_sides_belong_to_the_axes() -> None:
    for sides in permutations((0.25, 0.08, 0.01)):
        body = rigid.Body.box(*sides, mass=0.3)
        a, b, c = sides
        expected = [0.3 / 12 * (x * x + y * y) for x, y in ((b, c), (a, c), (a, b))]
        assert body.moments == pytest.approx(expected, rel=5 * ROUNDOFF)
        assert body.sides == sides
        assert body.mass == 0.3
    assert rigid.Body.box(1.0, 2.0, 2.0).symmetry_axis == 1
    assert rigid.Body.box(2.0, 1.0, 2.0).symmetry_axis == 2
    assert rigid.Body.box(2.0, 2.0, 1.0).symmetry_axis == 3
    assert rigid.Body.box(1.0, 2.0, 3.0).symmetry_axis is None


@pytest.mark.parametrize("axis", ["x", "y", "z"])
@pytest.mark.parametrize("method", METHODS, ids=lambda method: method.name)
def test_fixed_noise_of_one_twentieth(method: rigid.Method, axis: str) -> None:
    """All components 0.05 rad/s off a turn about one axis: where the box is after 30 s."""
    start = [0.05, 0.05, 0.05]
    start["xyz".index(axis)] = 1.05
    step, tolerance = STEP, ERRORS.get(method.order, SMALL)
    run = rigid.simulate(SCENE, start, t=30.0, method=method.name, step=step)
    # The middle axis enlarges an error some 20 times more than the others.
    assert run.omega[0] == pytest.approx(golden_number(f"box.run_{axis}.w(30)"), abs=tolerance)
    if axis == "y":
        matrix = rotation_matrix(present(run.attitude)[0]).ravel()
        assert matrix == pytest.approx(golden_number("box.run_y.R(30)"), abs=tolerance)
