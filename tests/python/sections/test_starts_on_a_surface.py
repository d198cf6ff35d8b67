"""Random starts of one energy and one angular momentum about the vertical, on a section."""

import numpy as np
import pytest

import rigid
from rigid.sections.starts import least_energy

TOP = rigid.HeavyTop(rigid.Body((1.0, 1.6, 0.7)), mgl=1.2, com=(0.6, 0.0, 0.8))

SURFACES = {
    "highest": rigid.section(),
    "lowest": rigid.section(direction=1),
    "rate": rigid.section("omega2", 0.3, -1),
    "vertical": rigid.section("gamma1", 0.2, 1),
    "plane": rigid.section(omega=(1.0, 0.0, 0.5), gamma=(0.0, 1.0, 0.0), value=0.1, direction=0),
}


@pytest.mark.parametrize("name", SURFACES)
def test_starts_have_energy_momentum_surface_and_direction(name: str) -> None:
    surface = SURFACES[name]
    omega, attitude = rigid.top.on_surface(TOP, 2.0, 0.4, 200, section=surface, rng=1)
    assert omega.shape == (200, 3)
    assert attitude.shape == (200, 4)
    known = rigid.top.heavy_constants(TOP, omega, attitude)
    np.testing.assert_allclose(known.energy, 2.0, rtol=0.0, atol=1e-14)
    np.testing.assert_allclose(known.p_phi, 0.4, rtol=0.0, atol=1e-14)
    run = rigid.simulate(TOP, omega, attitude, t=[0.0, 1e-6])
    normals = surface.normals(TOP, np.tile(TOP.weight, (200, 1)))
    assert run.gamma is not None
    of_omega, of_gamma = normals[:, np.newaxis, :3], normals[:, np.newaxis, 3:]
    height = np.cross(run.gamma, run.omega) if surface.is_height else run.gamma
    values = np.sum(of_omega * run.omega + of_gamma * height, axis=-1) - surface.value
    np.testing.assert_allclose(values[:, 0], 0.0, atol=2e-15)
    if surface.direction:
        assert (np.sign(values[:, 1]) == surface.direction).all()
    else:
        assert 50 < np.count_nonzero(values[:, 1] > 0.0) < 150


def test_the_same_key_gives_the_same_starts() -> None:
    first, second, other = (
        rigid.top.on_surface(TOP, 2.0, 0.4, 20, rng=key)[0] for key in (1, 1, 2)
    )
    np.testing.assert_array_equal(first, second)
    assert (first != other).any()
    # More starts begin with the same ones.
    np.testing.assert_array_equal(rigid.top.on_surface(TOP, 2.0, 0.4, 30, rng=1)[0][:20], first)


def test_the_least_energy_is_that_of_a_permanent_rotation() -> None:
    # Hanging: without momentum the centre of mass is lowest.
    assert least_energy(TOP, 0.0) == pytest.approx(-1.2, abs=1e-15)
    # A symmetric top hanging or not, about its own axis: the better of rotations about the
    # vertical with the axis at every tilt.
    top = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)
    u = np.linspace(-1.0, 1.0, 2_000_001)
    for momentum in (0.5, 1.0, 3.0):
        known = (u + 0.5 * momentum**2 / (1.0 - u**2 + 0.5 * u**2)).min()
        assert least_energy(top, momentum) == pytest.approx(known, abs=1e-12)


def test_little_above_the_least_energy_there_are_starts() -> None:
    least = least_energy(TOP, 0.4)
    omega, attitude = rigid.top.on_surface(TOP, least + 1e-2, 0.4, 10, rng=1)
    known = rigid.top.heavy_constants(TOP, omega, attitude)
    np.testing.assert_allclose(known.energy, least + 1e-2, rtol=0.0, atol=1e-14)


def test_verticals_of_a_high_energy_are_even() -> None:
    # Far above the potential every vertical is allowed: its mean is zero, each square a third.
    sphere = rigid.HeavyTop(rigid.Body((1.0, 1.0, 1.0)), mgl=1e-6)
    omega, attitude = rigid.top.on_surface(
        sphere, 10.0, 0.0, 4000, section=rigid.section(direction=0), rng=7
    )
    gamma = np.asarray(rigid.simulate(sphere, omega, attitude, t=[0.0]).gamma)[:, 0]
    # Four standard errors of 4000 draws.
    np.testing.assert_allclose(gamma.mean(axis=0), 0.0, atol=4.0 / np.sqrt(3.0 * 4000.0))
    np.testing.assert_allclose((gamma**2).mean(axis=0), 1.0 / 3.0, atol=4.0 * 0.3 / np.sqrt(4000.0))
