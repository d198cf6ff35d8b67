"""The request of a call: what holds for every criterion, every number of a scene, every body."""

import functools
import inspect
from contextlib import nullcontext
from dataclasses import MISSING, fields
from typing import Any

import numpy as np
import pytest

import rigid
from rigid.model.criterion import CRITERIA, can_be_left
from rigid.model.parameters import AT_REST, PLACES, numbers_of
from rigid.model.sourced import Sourced


@pytest.mark.parametrize("name", CRITERIA)
def test_a_function_that_makes_a_criterion_has_the_defaults_of_its_class(name: str) -> None:
    of_function = inspect.signature(getattr(rigid, name)).parameters
    for own in fields(CRITERIA[name]):  # type: ignore[arg-type]
        known = of_function[own.name].default
        assert known == (inspect.Parameter.empty if own.default is MISSING else own.default)


def test_joined_criteria_are_left_if_one_that_they_need_is_left() -> None:
    a, b, back = rigid.no_flip(1), rigid.tilt_between(0.1, 0.2), rigid.returns(0.1, after=1.0)
    for left in (a, a & b, a | ~b, ~(~a & b), ~back, ~(back | ~a)):
        assert can_be_left(left.logic()), left
    # A body that has left a criterion does not come back to it.
    for never in (~a, ~a & ~b, ~(a | b), back, back | ~b, ~(~back & a)):
        assert not can_be_left(never.logic()), never


MOMENTS = np.array([[1.0, 1.5, 2.0], [40.0, 50.0, 60.0]])
TWO = np.array([0.1, 0.2])
EACH = np.array([[0.1, 0.2, 0.3], [0.4, 0.5, 0.6]])
SCENES: list[rigid.FreeBody | rigid.HeavyTop] = [
    rigid.FreeBody(
        rigid.Body(MOMENTS),
        torque=rigid.Torque.body(EACH),
        damping=EACH,
        dissipation=rigid.EnergySink(EACH),
        rotor=EACH,
        drag=EACH,
        orbit=rigid.Orbit(TWO, TWO, TWO),
    ),
    rigid.HeavyTop(rigid.Body(MOMENTS), mgl=TWO, com=[[0.0, 0.6, 0.8], [1.0, 0.0, 0.0]]),
]


def test_gravity_is_that_of_the_earth_unless_another_one_is_given() -> None:
    body = rigid.Body.rod(2.0, mass=3.0)
    for given, g in (({}, 9.81), ({"g": 1.62}, 1.62)):
        top, _ = rigid.HeavyTop.from_mass(body, com=(0.0, 0.0, 1.0), **given)
        assert top.mgl == pytest.approx(3.0 * g, rel=1e-15)


def test_damping_of_as_many_numbers_as_bodies_is_asked_for_its_axes() -> None:
    words = r"write \(3, 3, 3\) for a matrix of each, \(1, 3\) for three "
    with pytest.raises(ValueError, match=words):
        rigid.FreeBody(rigid.Body([[1.0, 1.5, 2.0]] * 3), damping=[1.0, 2.0, 3.0])


@pytest.mark.parametrize("scene", SCENES, ids=lambda scene: type(scene).__name__)
def test_the_numbers_of_many_bodies_are_those_of_each(scene: Any) -> None:
    """A body's part of its numbers has the axes that its place says."""
    places = [name for name in PLACES if _stands_in(scene, name)]
    assert len(places) > 3
    together = numbers_of(scene, AT_REST, places, 2)
    for k in range(2):
        for name, alone in numbers_of(scene[k], AT_REST, places, 1).items():
            np.testing.assert_array_equal(together[name][k], alone[0], err_msg=name)


def _stands_in(scene: Any, name: str) -> bool:
    try:
        numbers_of(scene[0], AT_REST, [name], 1)
    except (AttributeError, AssertionError, TypeError):
        return False
    return True


POWERS = {"mgl": 2, "damping": 1, "torque": 2, "rotor": 1, "drag": 0, "dissipation": -1}
"""Of the unit of rates in the units of numbers, which have one unit of moments each."""


@pytest.mark.parametrize("name", POWERS)
def test_a_first_guess_of_a_fit_is_off_by_what_has_the_unit_of_its_number(name: str) -> None:
    place = PLACES[name]
    assert place.guess is not None
    nothing = np.zeros((3,) * place.width)
    off, other = (np.asarray(place.guess(nothing, m * 1.3, w * 0.7)) for m, w in ((1, 1), (8, 2)))
    assert (off > 0.0).all()
    assert (other == 8.0 * 2.0 ** POWERS[name] * off).all()


def test_rows_are_bodies_unless_every_body_would_be_a_tensor() -> None:
    tensor = np.ones((3, 3)) + np.eye(3)
    with pytest.raises(ValueError, match=r"take rigid\.Body\.from_tensor"):
        rigid.Body([tensor, tensor])
    # Ones are three spheres, and as a tensor they would have two moments of zero.
    assert rigid.Body([tensor, np.ones((3, 3))]).shape == (2, 3)
    with pytest.raises(ValueError, match=r"moments\[0, 0\] = \(0, 0, 0\)"):
        rigid.Body([np.zeros((3, 3)), tensor])
    # Neither a body: a determinant of zero, and two negative moments.
    for matrix in ([[1.0, 0.0, 0.5], [0.0, 1.0, 0.5], [0.5, 0.5, 0.5]], np.diag([-1.0, -1.0, 1.0])):
        with pytest.raises(ValueError, match=r"moments\[0\] = \("):
            rigid.Body(matrix)


def test_a_weight_ends_where_squares_of_its_rates_near_the_largest_double() -> None:
    body = rigid.Body((1.0, 1.5, 2.0))
    assert rigid.simulate(rigid.HeavyTop(body, mgl=0.99e153), [0.0, 0.0, 1.0], t=[0.0]).steps == 0
    with pytest.raises(
        ValueError, match=r"mgl = 1.01e\+153: must be below 1e\+153 times the least"
    ):
        rigid.simulate(rigid.HeavyTop(body, mgl=1.01e153), [0.0, 0.0, 1.0], t=[0.0])


LARGE = (10.0, 10.0, 10.0)


@pytest.mark.parametrize(
    ("sides", "mass", "light"),
    [
        ((5.0, 5.0, 5.0), 1.5, False),
        ((5.1, 1.0, 1.0), 0.5, True),
        (LARGE, 100.0, False),
        (LARGE, 99.0, True),
        (LARGE, 1.0, False),
    ],
)
def test_a_large_box_lighter_than_any_solid_has_other_units(
    sides: tuple[float, float, float], mass: float, light: bool
) -> None:
    """Above 5 m and below 0.1 kg/m³; a mass of 1 stands for any."""
    warns = pytest.warns(UserWarning, match="is lighter than any solid") if light else nullcontext()
    with warns:
        rigid.Body.box(*sides, mass=mass)


def test_a_component_of_a_covariance_may_have_no_variance() -> None:
    assert rigid.normal(cov=np.diag([4.0, 0.0, 1.0])).cov == ((4, 0, 0), (0, 0, 0), (0, 0, 1))
    # Of a single direction, to rounding; and what is more than rounding beside small variances.
    assert rigid.normal(cov=np.outer([0.1, 0.3, 0.7], [0.1, 0.3, 0.7]))
    for off, small in ((1e-9, 0.0), (1e-8, 1e-6)):
        with pytest.raises(ValueError, match="cov: must be positive semi-definite"):
            rigid.normal(cov=[[1.0, 1.0, off], [1.0, 1.0, 0.0], [off, 0.0, small]])


def test_damping_in_the_axes_of_a_drawing_is_symmetric_to_the_bit() -> None:
    axes = rigid.rotations.quaternion_to_matrix(np.array([0.8, 0.1, 0.5, -0.3]) / np.sqrt(0.99))
    one = np.array([[0.3, 0.05, -0.1], [0.05, 0.2, 0.02], [-0.1, 0.02, 0.4]])
    for given in (one, np.stack([one, 2.0 * one, one[::-1, ::-1]])):
        scene = rigid.FreeBody(rigid.Body((1.0, 1.5, 2.0)), damping=given, frame=axes)
        found = np.array(scene.damping)
        assert (found == np.swapaxes(found, -1, -2)).all()
        np.testing.assert_allclose(axes @ found @ axes.T, given, rtol=0.0, atol=1e-15)


def test_a_function_without_a_source_is_doubted_unless_it_was_carried() -> None:
    made: dict[str, Any] = {}
    exec("def above(states):\n    return states", made)
    known = Sourced("above", "0" * 64, function=made["above"])
    assert "its source differs from 'above'" in known.doubt("stable")
    assert known.given("stable", made["above"], carried=True) == known


def test_what_wraps_a_function_is_another_one_unless_it_is_a_cache() -> None:
    def above(states: Any) -> Any:
        return states

    @functools.wraps(above)
    def below(states: Any) -> Any:
        return -above(states)

    class Twice:
        def __init__(self, function: Any) -> None:
            self.__wrapped__ = function

        def __call__(self, states: Any) -> Any:
            return 2.0 * self.__wrapped__(states)

    known, other, twice, cached = (
        Sourced.of("stable", one).sha256
        for one in (above, below, Twice(above), functools.cache(above))
    )
    assert len({known, other, twice}) == 3
    assert cached == known


def test_parts_of_bodies_by_an_index_with_an_ellipsis_are_whole() -> None:
    body = rigid.Body(np.broadcast_to(MOMENTS, (3, 2, 3)), mass=np.arange(1.0, 7.0).reshape(3, 2))
    for index in (1, (1, 0), (..., 1), (1, ...), (slice(None), 1), np.array([True, False, True])):
        places = np.arange(6).reshape(3, 2)[index]
        np.testing.assert_array_equal(body[index].moments, MOMENTS[places % 2])
        np.testing.assert_array_equal(body[index].mass, 1.0 + places)
