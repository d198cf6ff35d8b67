"""Maps over starts that a function gives, over semi-axes, rotors, energies and momenta."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rigid
from small_maps import Floats, assert_same_map, small_map

ENERGIES, MOMENTA = [1.5, 3.0], [-0.2, 0.3, 0.6]


TOP = rigid.HeavyTop(rigid.Body((1.0, 1.3, 0.7)), mgl=1.0)


def on_surface(energy: Floats, l_gamma: Floats) -> tuple[rigid.HeavyTop, Floats, Floats]:
    """A motion of that energy and that vertical momentum in each pixel."""
    starts = [
        rigid.top.on_surface(TOP, energy=one, l_gamma=other, count=1, rng=7)
        for one, other in zip(energy.tolist(), l_gamma.tolist(), strict=True)
    ]
    omega, attitude = (np.concatenate(part) for part in zip(*starts, strict=True))
    return TOP, omega, attitude


def rolled(turns: Floats) -> tuple[rigid.FreeBody, Floats]:
    body = rigid.Body((1.0, 1.5, 2.0))
    return rigid.FreeBody(body), np.stack([0.0 * turns, np.cos(turns), np.sin(turns)], axis=-1)


def surface_map(**options: Any) -> rigid.StabilityMap:
    given: dict[str, Any] = {
        "axes": {"energy": ENERGIES, "l_gamma": MOMENTA},
        "stable": rigid.tilt_below(2.0),
        "t_end": 20.0,
        "samples": 3,
    }
    return small_map(on_surface, **{**given, **options})


def test_each_pixel_starts_with_the_energy_and_momentum_of_its_axes(tmp_path: Path) -> None:
    result = surface_map()
    starts = result.starts(0)
    constants = rigid.top.heavy_constants(TOP, starts.omega, starts.attitude)
    expected_momentum, expected_energy = np.meshgrid(MOMENTA, ENERGIES, indexing="ij")
    # Some roundings of sums of numbers up to 10.
    np.testing.assert_allclose(constants.energy, expected_energy, atol=1e-13)
    np.testing.assert_allclose(constants.p_phi, expected_momentum, atol=1e-13)
    assert "with omega and attitude by on_surface(energy, l_gamma)" in result.summary()
    for pixel in np.ndindex(3, 2):
        body = result.replay(pixel, 0)
        assert body.outcome == result.outcomes(0).outcome[pixel]
        tilts = np.arccos(body.run.gamma[:, 2])
        assert (tilts.max() > 2.0) == (body.outcome == "unstable")
    path = result.save(tmp_path / "map.npz")
    bare = rigid.load_map(path)
    assert bare.spec == result.spec
    assert bare.summary() == result.summary()
    again = rigid.load_map(path, scene=on_surface)
    assert_same_map(rigid.stability_map(again.spec, progress=False), result)


def test_rates_of_a_function_are_perturbed_and_seen_by_theory() -> None:
    """Rotation near the axis of the middle moment flips, near that of the largest it does not."""
    start = rigid.Start(omega=(0.0, 0.0, 0.0), noise=rigid.normal(1e-3))
    result = small_map(
        rolled, axes={"turns": [0.0, 1.5]}, start=start, stable=rigid.no_flip(2), t_end=40.0
    )
    # At the angle 1.5 the rate about axis 2 changes its sign once in each turn about axis 3.
    assert result.share.tolist() == [0.0, 0.0]
    spread = result.starts(range(20)).omega - rolled(np.array([0.0, 1.5]))[1][:, np.newaxis]
    assert 5e-4 < spread.std() < 2e-3
    about_3 = small_map(
        rolled, axes={"turns": [0.0, 1.5]}, start=start, stable=rigid.no_flip(3), t_end=40.0
    )
    assert about_3.share[1] == 1.0


def test_the_function_and_the_start_do_not_say_the_same() -> None:
    asked: dict[str, Any] = {"stable": rigid.no_flip(2), "axes": {"turns": [0.1]}}
    with pytest.raises(ValueError, match="start: rolled gives the rates; the start must"):
        small_map(rolled, start=rigid.Start(spin=1.0), **asked)
    with pytest.raises(ValueError, match="cannot tell the axis"):
        small_map(rolled, **{**asked, "stable": rigid.no_flip()})
    for more in (
        {"axes": {"energy": [2.0], "l_gamma": [0.1], "tilt": [0.1]}},
        {"start": rigid.Start(omega=(0, 0, 0), tilt=0.1)},
    ):
        with pytest.raises(ValueError, match="on_surface gives the attitude; omit tilt and"):
            surface_map(**more)

    def short(turns: Floats) -> Any:
        return rigid.FreeBody(rigid.Body((1.0, 1.5, 2.0))), np.zeros((5, 3))

    with pytest.raises(ValueError, match=r"return omega of shape \(1, 3\), a row for each number"):
        small_map(short, **asked)

    def far_too_many(turns: Floats) -> Any:
        return (*rolled(turns), turns, turns)

    with pytest.raises(TypeError, match="omega and attitude may follow the scene"):
        small_map(far_too_many, **asked)


def test_moments_of_an_ellipsoid_follow_from_its_semi_axes() -> None:
    scene = rigid.FreeBody(rigid.Body((1.0, 1.5, 2.0)))
    axes = {"a/b": [1.0, 1.25, 3.0], "b/c": [1.0, 1.6]}
    result = small_map(scene, axes=axes, stable=rigid.no_flip(2), samples=1)
    for y, x in np.ndindex(2, 3):
        a, c = axes["a/b"][x], 1.0 / axes["b/c"][y]
        whole = rigid.Body.ellipsoid(a, 1.0, c)
        found = np.array(result.spec.grid.moments[3 * y + x])
        scaled = np.array(whole.moments) * 2.0 / whole.moments[2]
        # A few roundings.
        np.testing.assert_allclose(found, scaled, rtol=1e-15 * 8)
    assert "moments (varied, varied, 2)" in result.summary()
    # One ratio alone leaves the other: that of the body of the scene.
    ellipsoid = rigid.Body.ellipsoid(3.0, 2.0, 1.0)
    one = small_map(ellipsoid, axes={"a/b": [1.2]}, stable=rigid.no_flip(2), samples=1)
    expected = np.array(rigid.Body.ellipsoid(2.4, 2.0, 1.0).moments)
    expected *= ellipsoid.moments[2] / expected[2]
    np.testing.assert_allclose(one.spec.grid.moments[0], expected, rtol=1e-14)


@pytest.mark.parametrize("names", [("I1", "a/b"), ("b/c", "I2/I3"), ("a", "a/b")])
def test_semi_axes_say_the_moments(names: tuple[str, str]) -> None:
    scene = rigid.FreeBody(rigid.Body.box(1.0, 1.0, 1.0))
    with pytest.raises(ValueError, match="exclude each other"):
        small_map(scene, axes={name: [1.1] for name in names})
    with pytest.raises(ValueError, match=r"axes\['a/b'\]\[0\] = 0\.9: must be at least 1"):
        small_map(scene, axes={"a/b": [0.9, 1.0]})


def test_a_rotor_keeps_the_middle_axis_from_a_size_on() -> None:
    """Small changes about axis 2 grow unless h2 w > (I3 - I2) w² (Hughes 1986, § 6.3)."""
    scene = rigid.FreeBody(rigid.Body((1.0, 1.5, 2.0)))
    rotor = np.array([0.0, 0.3, 0.4, 0.51, 0.6])
    near = rigid.rate_within(0.1, frame="body")
    start = rigid.Start(spin=1.0, axis=2, noise=rigid.normal(1e-6))
    result = small_map(
        scene,
        axes={"rotor2": rotor},
        start=start,
        stable=near,
        method="auto",
        t_end=600.0,
        samples=4,
    )
    np.testing.assert_array_equal(result.share, rotor > 0.5)
    assert result.replay(4, 0).run.spec["scene"]["rotor"] == [0.0, 0.6, 0.0]
    with pytest.raises(ValueError, match="of = 'L': the momentum of the rotor is not watched"):
        small_map(scene, axes={"rotor2": rotor}, start=start, stable=rigid.rate_within(0.1, of="L"))
    with pytest.raises(ValueError, match="'rotor1' does not apply: a heavy top has none; use a"):
        small_map(rigid.HeavyTop, axes={"rotor1": [0.1]}, stable=rigid.tilt_below(1.0))


def test_energy_and_vertical_momentum_are_those_of_their_axes() -> None:
    axes: dict[str, Any] = {"energy": [0.2, 1.5, 3.0], "l_gamma": [-0.4, 0.0, 0.7]}
    start = rigid.Start(omega=(0.5, -0.2, 1.0), tilt=0.8)
    stable = rigid.tilt_below(2.0)
    both = small_map(TOP, axes=axes, start=start, stable=stable, samples=1)
    starts = both.starts(0)
    known = both.status == 0
    # At rest the energy is mgl cos(0.8) = 0.697: no start has 0.2.
    np.testing.assert_array_equal(known, [[False, True, True]] * 3)
    found = rigid.top.heavy_constants(TOP, starts.omega[known], starts.attitude[known])
    momentum, energy = np.meshgrid(axes["l_gamma"], axes["energy"], indexing="ij")
    np.testing.assert_allclose(found.energy, energy[known], atol=1e-14)
    np.testing.assert_allclose(found.p_phi, momentum[known], atol=1e-14)
    # Alone the energy scales the rates, and the momentum leaves what has none as it is.
    one = small_map(TOP, axes={"energy": [1.5]}, start=start, stable=stable, samples=1).starts(0)
    assert rigid.top.heavy_constants(TOP, one.omega, one.attitude).energy[0] == pytest.approx(1.5)
    np.testing.assert_allclose(np.cross(one.omega[0], [0.5, -0.2, 1.0]), 0.0, atol=1e-15)
    assert one.omega[0, 0] > 0.0
    other = small_map(TOP, axes={"l_gamma": [0.7]}, start=start, stable=stable, samples=1).starts(0)
    assert rigid.top.heavy_constants(TOP, other.omega, other.attitude).p_phi[0] == (
        pytest.approx(0.7)
    )
    gamma = np.array([0.0, np.sin(0.8), np.cos(0.8)])
    np.testing.assert_allclose(np.cross(other.omega[0] - [0.5, -0.2, 1.0], gamma), 0.0, atol=1e-15)
    free = small_map(axes={"energy": [0.5, 2.0]}, start=rigid.Start(spin=1.0, axis=2), samples=1)
    np.testing.assert_allclose(free.starts(0).omega[:, 1], np.sqrt([1.0 / 1.5, 4.0 / 1.5]))
    with pytest.raises(ValueError, match="'l_gamma' does not apply: a free body knows no vertical"):
        small_map(axes={"l_gamma": [0.5]})
