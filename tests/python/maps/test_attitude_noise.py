"""Attitude noise of free bodies: a torque in space makes the attitude matter, nothing else does."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.stats import norm

import rigid
from physics import rotation_matrix
from rigid.model.start import Noise
from small_maps import small_map

TORQUE, SPIN, HORIZON = 1.0, 0.002, 0.04
SPHERE = rigid.FreeBody(rigid.Body((1.0, 1.0, 1.0)), torque=rigid.Torque.space((TORQUE, 0.0, 0.0)))


def sphere_map(noise: Noise, **options: Any) -> rigid.StabilityMap:
    given: dict[str, Any] = {
        "axes": {"spin": [SPIN]},
        "start": rigid.Start(spin=SPIN, axis=3, attitude_noise=noise),
        "stable": rigid.no_flip(3),
        "t_end": HORIZON,
        "samples": 20_000,
        "check": 0.0,
    }
    return small_map(SPHERE, **{**given, **options})


def test_a_torque_in_space_stops_the_spin_of_bodies_that_point_against_it() -> None:
    """A sphere hardly turns meanwhile: its rate about axis 3 is spin + torque cos(angle) t.

    From any attitude the cosine is uniform in [-1, 1], so the rate changes its sign with a chance
    of (1 - spin / (torque t)) / 2. The body turns by 1e-3 rad until then: the share is that exact.
    """
    result = sphere_map(rigid.uniform_attitude())
    chance = 0.5 * (1.0 - SPIN / (TORQUE * HORIZON))
    spread = math.sqrt(chance * (1.0 - chance) / result.spec.samples)
    assert 1.0 - result.share[0] == pytest.approx(chance, abs=4.0 * spread + 1e-3)
    for sample in range(60):
        body = result.replay(0, sample)
        cosine = rotation_matrix(body.attitude)[0, 2]
        turned = -SPIN / (TORQUE * cosine)  # the time of the sign change
        assert (body.outcome == "unstable") == (0.0 < turned < HORIZON)
        if body.outcome == "unstable":
            assert body.left == pytest.approx(turned, rel=2e-3)
        # The trajectory of the start that was drawn tells the same.
        assert (body.run.omega[:, 2].min() < 0.0) == (body.outcome == "unstable")


def test_the_size_of_the_attitude_noise_is_an_axis_of_a_map() -> None:
    """A small rotation tilts axis 3 to or from the torque by a normal angle of that size."""
    sizes = np.array([0.0, 0.025, 0.05, 0.1])
    result = sphere_map(rigid.normal(0.0), axes={"attitude_noise": sizes})
    ratio = np.divide(SPIN / (TORQUE * HORIZON), sizes, out=np.full(4, np.inf), where=sizes > 0.0)
    chance = norm.cdf(-ratio)
    spread = np.sqrt(chance * (1.0 - chance) / result.spec.samples)
    # Terms of second order in the size, 0.1 at most, change a normal angle by half its square.
    np.testing.assert_array_less(abs(1.0 - result.share - chance), 4.0 * spread + 5e-3)
    assert result.share[0] == 1.0


def test_without_a_torque_in_space_the_noise_would_change_nothing() -> None:
    start = rigid.Start(spin=1.0, attitude_noise=rigid.normal(0.1))
    body = rigid.Body((1.0, 1.5, 2.0))
    for scene in (
        rigid.FreeBody(body),
        rigid.FreeBody(body, damping=0.1),
        rigid.FreeBody(body, torque=rigid.Torque.body((0.3, 0.0, 0.0))),
        rigid.FreeBody(body, torque=rigid.Torque.space((0.0, 0.0, 0.0))),
    ):
        with pytest.raises(ValueError, match="without a torque in space has no effect"):
            small_map(scene, start=start, axes={"spin": [1.0]})
