"""Starts of a given attitude: what a torque in space does to them, noise, files, refusals."""

import math
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from scipy.stats import norm

import rigid
from map_texts import FREE, map_text
from physics import rotation_matrix
from rigid.cli.toml_map import parse_spec
from rigid.model.noise import Noise
from small_maps import small_map

TORQUE, SPIN, HORIZON = 1.0, 0.002, 0.04
SPHERE = rigid.FreeBody(rigid.Body((1.0, 1.0, 1.0)), torque=rigid.Torque.space((TORQUE, 0.0, 0.0)))


def about_y(cosine: float) -> Rotation:
    """The attitude whose axis 3 has this component along the torque, which is along x."""
    return Rotation.from_euler("y", math.asin(cosine))


@pytest.mark.parametrize("cosine", [-0.9, -0.06, -0.04, 0.5])
def test_the_attitude_decides_how_a_torque_in_space_acts(cosine: float) -> None:
    """A sphere hardly turns meanwhile: its rate about axis 3 is spin + torque cos(angle) t."""
    start = rigid.Start(spin=SPIN, attitude=about_y(cosine))
    result = small_map(
        SPHERE, axes={"spin": [SPIN]}, start=start, stable=rigid.no_flip(3), t_end=HORIZON
    )
    assert result.share[0] == float(SPIN + TORQUE * cosine * HORIZON > 0.0)
    body = result.replay(0, 0)
    # Rotations by scipy, the start by quaternions of the core: two roundings.
    np.testing.assert_allclose(
        rotation_matrix(body.attitude), about_y(cosine).as_matrix(), atol=4e-16
    )


@pytest.mark.parametrize("axis", [1, 2, 3])
def test_a_leaning_top_is_one_whose_attitude_is_given(axis: int) -> None:
    """``tilt`` leans the axis about x of space; SciPy makes the same attitude."""
    com = np.eye(3)[axis - 1]
    scene = rigid.HeavyTop(rigid.Body((1.0, 1.2, 0.7)), mgl=1.0, com=com)
    laid = Rotation.from_matrix(np.roll(np.eye(3), 3 - axis, axis=0))
    options = {"axes": {"spin": [0.5, 3.0]}, "stable": rigid.tilt_below(1.0, axis=axis)}
    tilted = rigid.Start(spin=1.0, axis=axis, tilt=0.4, noise=rigid.normal(0.3))
    given = rigid.Start(
        spin=1.0, axis=axis, attitude=Rotation.from_euler("x", 0.4) * laid, noise=rigid.normal(0.3)
    )
    one, other = (small_map(scene, start=start, **options) for start in (tilted, given))
    first, second = one.starts(0), other.starts(0)
    np.testing.assert_array_equal(first.omega, second.omega)
    np.testing.assert_allclose(
        rotation_matrix(first.attitude), rotation_matrix(second.attitude), atol=1e-15
    )
    np.testing.assert_array_equal(one.stable, other.stable)


def test_the_attitude_goes_through_toml() -> None:
    attitude = (0.5, -0.5, 0.5, -0.5)
    start = rigid.Start(spin=SPIN, attitude=(1.0, -1.0, 1.0, -1.0))
    assert start.attitude == attitude
    assert rigid.Start.from_dict(start.to_dict()) == start
    assert "attitude=(0.5, -0.5, 0.5, -0.5)" in repr(start)
    assert "attitude" not in rigid.Start(spin=1.0).to_dict()
    text = map_text(
        scene=f"{FREE}\ntorque_in_space = [1.0, 0.0, 0.0]",
        start="attitude = [0.5, -0.5, 0.5, -0.5]",
        stable='criterion = "no_flip"\naxis = 3',
    )
    assert parse_spec(text, "x.toml").start == rigid.Start(spin=0.0, attitude=attitude)


def test_a_start_has_one_attitude() -> None:
    with pytest.raises(ValueError, match=r"tilt = 0\.1: the attitude is given; leave out the tilt"):
        rigid.Start(spin=1.0, tilt=0.1, attitude=(1.0, 0.0, 0.0, 0.0))
    with pytest.raises(ValueError, match=r"attitude: expected shape \(4,\), got \(2, 4\)"):
        rigid.Start(spin=1.0, attitude=np.eye(4)[:2])  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="a zero quaternion is no attitude"):
        rigid.Start(spin=1.0, attitude=(0.0, 0.0, 0.0, 0.0))
    start = rigid.Start(spin=1.0, attitude=(1.0, 0.0, 0.0, 0.0))
    with pytest.raises(ValueError, match=r"'tilt' does not apply: the attitude of the start is"):
        small_map(rigid.HeavyTop, start=start, axes={"tilt": [0.1]}, stable=rigid.tilt_below(1.0))


def test_a_file_gives_back_the_same_start_to_the_bit() -> None:
    rng = np.random.default_rng(4)
    for attitude in rng.normal(size=(300, 4)):
        start = rigid.Start(omega=(0.0, 0.1, 1.0), attitude=attitude)
        assert rigid.Start.from_dict(start.to_dict()) == start


# Attitude noise of free bodies: a torque in space makes the attitude matter, nothing else does


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
