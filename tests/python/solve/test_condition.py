"""How much a motion magnifies a small change of its start, against what is known exactly."""

from __future__ import annotations

import math

import numpy as np
import pytest

import rigid
from physics import present

CUBE = rigid.FreeBody(rigid.Body((1.0, 1.0, 1.0)))
BOX = rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0)))


def test_a_cube_turns_ahead_of_its_neighbour() -> None:
    """Faster by delta, it is ahead by delta t: a shear, [[1, 0], [angle, 1]]."""
    times = np.array([0.0, 0.5, 1.0, 10.0, 1000.0])
    found = rigid.condition(CUBE, [0.0, 0.6, 0.8], t=times)
    np.testing.assert_allclose(found, 0.5 * (times + np.sqrt(times**2 + 4.0)), rtol=1e-13)


def test_about_the_middle_axis_it_grows_as_the_linear_theory_says() -> None:
    rate = math.sqrt((2.0 - 1.0) * (3.0 - 2.0) / (1.0 * 3.0))
    early, late = rigid.condition(BOX, [0.0, 1.0, 0.0], t=[20.0, 26.0])
    # The attitude is the integral of what grows: less by a constant, e^{-rate t} of it.
    assert late / early == pytest.approx(math.exp(rate * 6.0), rel=1e-4)


def test_about_the_stable_axes_it_grows_like_the_time() -> None:
    for omega in ([1.0, 1e-3, 1e-3], [1e-3, 1e-3, 1.0]):
        early, late = rigid.condition(BOX, omega, t=[100.0, 1000.0])
        assert late / early == pytest.approx(10.0, rel=0.01)


def test_beyond_a_separatrix_it_is_that_of_neighbours_in_closed_form() -> None:
    """It passes the saddle on 1e-13: neighbours that are much nearer to each other part by 1e13."""
    omega, aside, t = [1e-13, 1.0, 1e-13], 1e-17, [60.0]
    found = rigid.condition(BOX, omega, t=t)[0]
    ends = []
    for change in (-aside, aside):
        run = rigid.simulate(BOX, [1e-13 + change, 1.0, 1e-13], t=t, check=False)
        ends.append((run.omega[0], present(run.attitude)[0]))
    (w1, q1), (w2, q2) = ends
    turn = 2.0 * rigid.rotations.quaternion_product(q1 * [1.0, -1.0, -1.0, -1.0], q2)[1:]
    parted = np.hypot(np.linalg.norm(w2 - w1), np.linalg.norm(turn)) / (2.0 * aside)
    # The unit of the rates is 1: a change of the first rate is nearly the worst change.
    assert 1e12 < parted < found < 3.0 * parted


def test_a_chaotic_top_grows_exponentially_and_a_regular_one_does_not() -> None:
    top = rigid.HeavyTop(rigid.Body((1.0, 1.6, 0.7)), mgl=1.2, com=(0.6, 0.0, 0.8))
    chaotic, regular = rigid.condition(
        top, [[0.3, 0.4, 1.0], [0.1, 0.0, 20.0]], [0.9, 0.3, 0.2, 0.1], t=[10.0, 40.0]
    )
    assert regular[1] / regular[0] == pytest.approx(4.0, rel=0.5)
    assert chaotic[1] / chaotic[0] > 50.0


def test_neighbours_of_a_run_are_as_far_apart_as_it_says() -> None:
    """Two runs whose rates differ by 1e-9 at the start, which is less than that of the scale."""
    top = rigid.HeavyTop(rigid.Body((1.0, 1.6, 0.7)), mgl=1.2, com=(0.6, 0.0, 0.8))
    omega, times = np.array([0.3, 0.4, 1.0]), [5.0, 10.0]
    factor = rigid.condition(top, omega, t=times)
    for k in range(3):
        aside = omega.copy()
        aside[k] += 1e-9
        runs = [
            rigid.simulate(top, w, t=times, method="taylor16", check=False) for w in (omega, aside)
        ]
        assert runs[0].attitude is not None
        assert runs[1].attitude is not None
        parted = 2.0 * np.linalg.norm(runs[0].attitude - runs[1].attitude, axis=-1)
        assert (parted <= 1.001 * factor * 1e-9 + 1e-13).all()


def test_the_layer_of_a_map() -> None:
    """Thrown about the middle axis a box is sensitive, about the largest it is not."""
    result = rigid.stability_map(
        rigid.FreeBody,
        axes={"I2/I1": np.array([1.5, 2.5])},
        start=rigid.Start(spin=1.0, axis=2, noise=rigid.normal(1e-3)),
        stable=rigid.no_flip(2),
        samples=3,
        t_end=15.0,
        rng=4,
        progress=False,
    )
    layer = result.condition(3)
    assert layer.shape == result.share.shape
    assert layer[0] > 10.0 * layer[1]
    body = result.replay(0, 0)
    alone = rigid.condition(
        rigid.FreeBody(rigid.Body((1.0, 1.5, 2.0))), body.omega, body.attitude, t=[15.0]
    )
    np.testing.assert_allclose(result.condition(1)[0], alone[0], rtol=1e-12)


def test_impossible_pixels_have_no_condition() -> None:
    result = rigid.stability_map(
        rigid.FreeBody,
        axes={"I3": np.array([2.0, 9.0])},
        stable=rigid.no_flip(),
        samples=2,
        t_end=5.0,
        rng=4,
        progress=False,
    )
    assert np.isnan(result.condition()).tolist() == [False, True]
    with pytest.raises(ValueError, match=r"samples = 3: the map has 2 in a pixel"):
        result.condition(3)


def test_what_overflows_has_none_and_nobody_has_no_rows() -> None:
    assert rigid.condition(BOX, np.zeros((0, 3)), t=[1.0]).shape == (0, 1)
    assert np.isnan(rigid.condition(BOX, [1e200, 1e200, 1.0], t=[1e200]))[0]
