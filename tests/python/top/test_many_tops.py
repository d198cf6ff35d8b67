"""Many tops in one call of the textbook: each has the numbers that it has alone."""

import dataclasses
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import rigid
from physics import ROUNDOFF, present, tilted
from refusals import refuses
from rigid import top

COUNT = 37
RANDOM = np.random.default_rng(77)

ACROSS = RANDOM.uniform(0.8, 1.6, COUNT)
ALONG = ACROSS * RANDOM.uniform(0.3, 1.7, COUNT)
MGL = RANDOM.uniform(0.2, 3.0, COUNT)
AXIS = np.arange(COUNT) % 3  # the symmetry axis, from 0
SIDE = np.where(np.arange(COUNT) % 2, -1.0, 1.0)
MOMENTS = np.where(np.eye(3, dtype=bool)[AXIS], ALONG[:, None], ACROSS[:, None])
COM = np.where(np.eye(3, dtype=bool)[AXIS], SIDE[:, None], 0.0)
TOPS = rigid.HeavyTop(rigid.Body(MOMENTS), mgl=MGL, com=COM)

OMEGA = RANDOM.normal(size=(COUNT, 3))
OMEGA += COM * RANDOM.uniform(3.0, 9.0, (COUNT, 1))
ATTITUDE = RANDOM.normal(size=(COUNT, 4))
TILT = RANDOM.uniform(0.1, 3.0, COUNT)
SPIN = RANDOM.uniform(2.0, 9.0, COUNT) * SIDE
PUSH = RANDOM.normal(size=COUNT)
HEIGHT = np.cos(TILT)
T = np.array([-1.0, -0.2, 0.4, 1.7])
OWN_T = np.sort(RANDOM.uniform(-1.0, 2.0, (COUNT, 4)), axis=1)
DAMPING = np.where(np.arange(COUNT) % 4 == 0, 0.0, 0.05)

KNOWN = top.heavy_constants(TOPS, OMEGA, ATTITUDE)
A, B, E_PRIME = (present(getattr(KNOWN, name)) for name in ("a", "b", "E_prime"))
A = np.where(np.arange(COUNT) % 5 == 0, B, A)
"""Every fifth pair of constants belongs to a top that passes the vertical."""

#: What is given to each top, for any part of the tops.
CALLS: dict[str, Callable[[Any, Any], Any]] = {
    "heavy_constants": lambda tops, i: top.heavy_constants(tops, OMEGA[i], ATTITUDE[i]),
    "precession_spin_rates": lambda tops, i: top.precession_spin_rates(
        tops, TILT[i], a=A[i], b=B[i]
    ),
    "gravity_torque": lambda tops, i: top.gravity_torque(tops, ATTITUDE[i]),
    "gravity_torque in space": lambda tops, i: top.gravity_torque(tops, ATTITUDE[i], frame="space"),
    "effective_potential": lambda tops, i: top.effective_potential(tops, TILT[i], a=A[i], b=B[i]),
    "effective_minimum": lambda tops, i: top.effective_minimum(tops, a=A[i], b=B[i]),
    "turning_angles": lambda tops, i: top.turning_angles(
        tops, a=present(KNOWN.a)[i], b=B[i], E_prime=E_PRIME[i]
    ),
    "steady_precession": lambda tops, i: top.steady_precession(tops, TILT[i], SPIN[i]),
    "sleeping_top": lambda tops, i: top.sleeping_top(tops, SPIN[i]),
    "upright_f": lambda tops, i: top.upright_f(tops, SPIN[i], HEIGHT[i]),
    "spin_down": lambda tops, i: top.spin_down(tops, SPIN[i], damping=DAMPING[i]),
    "classify_locus": lambda tops, i: top.classify_locus(tops, OMEGA[i], ATTITUDE[i]),
    "advance": lambda tops, i: top.advance(tops, OMEGA[i], ATTITUDE[i]),
    "locus": lambda tops, i: top.locus(tops, OMEGA[i], ATTITUDE[i], t=T),
    "locus at own times": lambda tops, i: top.locus(tops, OMEGA[i], ATTITUDE[i], t=OWN_T[i]),
    "fast_top_approx": lambda tops, i: top.fast_top_approx(
        tops, TILT[i], SPIN[i], precession=PUSH[i], t=T
    ),
    "fast_top_approx at own times": lambda tops, i: top.fast_top_approx(
        tops, TILT[i], SPIN[i], t=OWN_T[i]
    ),
}
EVERY_CALL = pytest.mark.parametrize("name", CALLS)


def parts(found: Any) -> dict[str, Any]:
    """The arrays of a result, by name."""
    if dataclasses.is_dataclass(found):
        return {field.name: getattr(found, field.name) for field in dataclasses.fields(found)}
    return dict(enumerate(found)) if isinstance(found, tuple) else {"": found}  # type: ignore[arg-type]


def assert_same(found: Any, expected: Any) -> None:
    """Numbers to four roundings: sums of three products have another order, sines other lanes."""
    if np.asarray(expected).dtype.kind == "f":
        # Of sums that cancel: in units of their terms, which are of the order of ten.
        np.testing.assert_allclose(found, expected, rtol=4 * ROUNDOFF, atol=40 * ROUNDOFF)
    else:
        assert np.array_equal(found, expected)


@EVERY_CALL
def test_a_top_among_others_has_the_numbers_of_one_alone(name: str) -> None:
    many = parts(CALLS[name](TOPS, slice(None)))
    for body in range(COUNT):
        alone = parts(CALLS[name](TOPS[body], body))
        assert alone.keys() == many.keys()
        for part, expected in alone.items():
            assert many[part].shape == (COUNT, *np.shape(expected))
            assert_same(many[part][body], expected)


@EVERY_CALL
def test_leading_axes_of_tops_are_those_of_the_result(name: str) -> None:
    grid = np.arange(6).reshape(2, 3)
    square, flat = (parts(CALLS[name](TOPS[i], i)) for i in (grid, grid.ravel()))
    for part, found in square.items():
        assert found.shape == (2, 3, *flat[part].shape[1:])
        assert_same(found.reshape(flat[part].shape), flat[part])


@EVERY_CALL
def test_no_tops_have_no_numbers(name: str) -> None:
    none = slice(0, 0)
    for found in parts(CALLS[name](TOPS[none], none)).values():
        assert found.shape[0] == 0


def test_axes_of_tops_and_states_broadcast() -> None:
    column = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=[[1.0], [2.0]])
    omega, attitude = [[0.2, 0.1, 5.0], [0.0, 0.0, 4.0], [0.3, 0.0, -3.0]], tilted(1.0)
    found = top.heavy_constants(column, omega, attitude)
    # The kinetic energy and the momenta do not depend on the weight, but have the axes of it.
    for part in parts(found).values():
        assert part.shape == (2, 3)
    assert np.array_equal(found.kinetic[0], found.kinetic[1])
    assert np.array_equal(present(found.beta)[:, 0], [2.0, 4.0])
    assert np.shape(top.classify_locus(column, omega, attitude)) == (2, 3)
    assert top.locus(column, omega, attitude, t=T).point.shape == (2, 3, 4, 3)
    assert top.effective_potential(column, [0.1, 0.2, 0.3], a=1.0, b=2.0).value.shape == (2, 3)
    assert top.effective_minimum(column, a=[1.0, 1.5, 2.0], b=2.0).shape == (2, 3)
    assert top.fast_top_approx(column, 1.0, [5.0, 6.0, 7.0]).theta_start.shape == (2, 3)
    asleep = top.sleeping_top(column, [3.9, 4.0, 6.0])
    assert asleep.stable.tolist() == [[False, True, True], [False, False, True]]
    assert np.shape(asleep.spin_min) == (2, 1)
    down = top.spin_down(column, [5.0, 6.0, 7.0], damping=[[0.1], [0.2]])
    assert (down.onset.shape, np.shape(down.decay)) == ((2, 3), (2, 1))
    lying = np.stack([tilted(angle) for angle in (0.1, 0.2, 0.3)])
    assert top.gravity_torque(column, lying).shape == (2, 3, 3)
    # The weight is that of all: the torque has the axes of the moments nevertheless.
    bodies = rigid.HeavyTop(rigid.Body([[1.0, 1.0, 0.5], [1.2, 1.2, 0.5]]), mgl=1.0)
    assert top.gravity_torque(bodies, tilted(1.0)).shape == (2, 3)
    # Of one top: states at several attitudes.
    several = rigid.free.invariants(column[0, 0], omega[0], lying)
    assert several.kinetic.shape == several.L.shape == (3,)
    assert several.L_body.shape == (3, 3)


def test_one_top_among_symmetric_ones_may_have_no_symmetry() -> None:
    moments = MOMENTS.copy()
    moments[5] = (1.0, 1.2, 1.5)
    mixed = rigid.HeavyTop(rigid.Body(moments), mgl=MGL, com=COM)
    found = top.heavy_constants(mixed, OMEGA, ATTITUDE)
    others = np.arange(COUNT) != 5
    for name in ("p_psi", "E_prime", "a", "b", "alpha", "beta"):
        values = present(getattr(found, name))
        assert np.array_equal(np.isnan(values), ~others)
        assert np.array_equal(values[others], present(getattr(KNOWN, name))[others])
    alone = top.heavy_constants(mixed[5], OMEGA[5], ATTITUDE[5])
    assert alone.a is alone.p_psi is None
    assert_same(found.energy[5], alone.energy)
    # A top without weight is symmetric all the same.
    light = rigid.HeavyTop(rigid.Body(MOMENTS[:2]), mgl=[0.0, 1.0], com=COM[:2])
    assert np.isfinite(present(top.heavy_constants(light, OMEGA[:2], ATTITUDE[:2]).a)).all()


# Refusals

BAD = MOMENTS.copy()
BAD[17] = (1.0, 1.2, 1.5)
MIXED = rigid.HeavyTop(rigid.Body(BAD), mgl=MGL, com=COM)
LIGHT = rigid.HeavyTop(TOPS.body, mgl=np.where(np.arange(COUNT) == 9, 0.0, MGL), com=COM)
WHO = "moments[17] = (1.0, 1.2, 1.5), com[17] = (0.0, 0.0, -1.0): a symmetric top has two exactly"
WRONG_AXES = "scene (37,), omega (3,): the axes of the bodies do not broadcast"


test_the_bad_top_is_named = refuses(
    [
        (lambda: top.precession_spin_rates(MIXED, 1.0, a=1.0, b=2.0), WHO),
        (lambda: top.effective_potential(MIXED, 1.0, a=1.0, b=2.0), WHO),
        (lambda: top.effective_minimum(MIXED, a=1.0, b=2.0), WHO),
        (lambda: top.turning_angles(MIXED, a=1.0, b=2.0, E_prime=1.0), WHO),
        (lambda: top.fast_top_approx(MIXED, 1.0, 5.0), WHO),
        (lambda: top.classify_locus(MIXED, OMEGA), "moments[17] = "),
        (lambda: top.upright_f(MIXED[np.arange(20).reshape(4, 5)], 5.0, 0.5), "moments[3, 2] = "),
        (lambda: top.sleeping_top(LIGHT, 5.0), "mgl[9] = 0: a top without weight"),
        (lambda: top.spin_down(LIGHT, 5.0, damping=0.1), "mgl[9] = 0: a top without weight"),
        (
            lambda: top.spin_down(TOPS, 5.0, damping=np.where(np.arange(COUNT) == 4, -1.0, 0.0)),
            "damping[4] = -1.0: must not be negative",
        ),
        (
            lambda: top.effective_minimum(LIGHT, a=0.0, b=0.0),
            "a[9] = 0, b[9] = 0: the effective potential is constant",
        ),
        (
            lambda: top.turning_angles(
                TOPS, a=A, b=B, E_prime=np.where(np.arange(COUNT) == 6, -99.0, 99.0)
            ),
            "alpha[6] = ",
        ),
        (
            lambda: top.fast_top_approx(TOPS, 1.0, np.where(np.arange(COUNT) == 8, 0.0, 1.0)),
            "spin[8] = 0.0: a fast top needs a spin",
        ),
        (lambda: top.heavy_constants(TOPS, OMEGA[:3], tilted(1.0)), WRONG_AXES),
        (lambda: top.classify_locus(TOPS, OMEGA[:3]), WRONG_AXES),
        (lambda: top.locus(TOPS, OMEGA[:3], t=[0.0]), WRONG_AXES),
        (
            lambda: top.gravity_torque(TOPS, ATTITUDE[:3]),
            "scene (37,), attitude (3,): the axes of the bodies do not broadcast",
        ),
        (
            lambda: top.turning_angles(TOPS, a=A[:3], b=1.0, E_prime=1.0),
            "scene (37,), a (3,): the axes of the bodies do not broadcast",
        ),
        (
            lambda: top.fast_top_approx(TOPS, 1.0, 5.0, t=np.ones((4, 2))),
            "scene (37,), t (4,): the axes of the bodies do not broadcast",
        ),
    ],
    literal=True,
)
