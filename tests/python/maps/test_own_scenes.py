"""Scenes by a function of own parameters: the maps of the same numbers, files, replay, refusals."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from scipy.stats import norm

import rigid
from map_texts import FREE, map_text
from physics import rotation_matrix
from refusals import refuses
from rigid.cli.toml_map import parse_spec
from rigid.maps.satellites import time_to_separatrix
from rigid.model.noise import Noise
from small_maps import NAMED, Floats, assert_same_map, small_map

LENGTHS, MASSES = [0.5, 1.0, 1.5], [0.8, 1.2]
CLOUD = rigid.Start(spin=3.0, attitude_noise=rigid.normal(0.3))
OPTIONS: dict[str, Any] = {
    "start": CLOUD,
    "stable": rigid.tilt_below(0.6),
    "method": "auto",
    "samples": 70,
    "t_end": 5.0,
}


def pendulum(length: Floats, mass: Floats) -> rigid.HeavyTop:
    """A rod of that length with a ball, turning about its end."""
    across = mass * length**2
    return rigid.HeavyTop(
        rigid.Body(np.stack([across, 1.1 * across, 0.3 * across], axis=-1)),
        mgl=9.81 * mass * length,
        com=(0.0, 0.0, 1.0),
    )


def damped(length: Floats, drag: Floats) -> rigid.FreeBody:
    n = len(length)
    return rigid.FreeBody(
        rigid.Body(np.stack([length, 1.2 * length, 1.5 * length], axis=-1)),
        torque=rigid.Torque.body(np.stack([0.1 * drag, 0.0 * drag, drag], axis=-1)),
        damping=drag[:, None] * np.ones((n, 3)),
    )


def test_the_map_of_a_function_is_made_of_the_maps_of_its_scenes() -> None:
    result = small_map(pendulum, axes={"length": LENGTHS, "mass": MASSES}, **OPTIONS)
    assert result.share.shape == (2, 3)
    for y, x in np.ndindex(2, 3):
        scene = pendulum(np.array([LENGTHS[x]]), np.array([MASSES[y]]))[0]
        # A pixel draws by its number: a map of as many pixels has this one at its place.
        alone = small_map(scene, axes={"spin": np.arange(6) + 3.0 - (3 * y + x)}, **OPTIONS)
        for name in NAMED:
            found, expected = getattr(result, name)[y, x], getattr(alone, name)[3 * y + x]
            np.testing.assert_array_equal(found, expected, err_msg=name)
        body = result.replay((y, x), 5)
        assert body.run.spec["scene"] == scene.to_dict()
        assert body.outcome == result.outcomes(5).outcome[y, x]


def test_torque_and_damping_of_a_function_differ_between_pixels() -> None:
    options: dict[str, Any] = {**OPTIONS, "stable": rigid.no_flip(), "samples": 10}
    options["start"] = rigid.Start(spin=1.0, axis=2, noise=rigid.normal(0.1))
    axes = {"length": [1.0, 2.0], "drag": [0.05, 0.0]}
    result = small_map(damped, axes=axes, **options)
    for y, x in np.ndindex(2, 2):
        scene = damped(np.array([axes["length"][x]]), np.array([axes["drag"][y]]))[0]
        assert result.spec.grid.scene[2 * y + x].to_dict() == scene.to_dict()
        if scene.forces:
            alone = small_map(scene, axes={"spin": np.arange(4) + 1.0 - (2 * y + x)}, **options)
            for name in NAMED:
                found, expected = getattr(result, name)[y, x], getattr(alone, name)[2 * y + x]
                np.testing.assert_array_equal(found, expected, err_msg=name)


def test_own_parameters_go_with_those_of_rigid() -> None:
    axes: dict[str, Any] = {"length": LENGTHS, "spin": [2.0, 4.0]}
    axes |= {"mass": MASSES, "t_end": [2.0, 5.0]}
    result = small_map(pendulum, axes=axes, **OPTIONS)
    assert result.share.shape == (2, 2, 2, 3)
    body = result.replay((1, 0, 1, 2), 0)
    assert body.parameters == {"length": 1.5, "spin": 4.0, "mass": 0.8, "t_end": 5.0}
    assert body.omega[2] == 4.0
    assert body.run.spec["scene"]["mgl"] == 9.81 * 0.8 * 1.5
    assert "heavy top by pendulum(length, mass)" in result.summary()


def test_each_horizon_sees_the_scenes_of_the_function() -> None:
    axes = {"length": LENGTHS, "mass": MASSES}
    both = small_map(pendulum, axes={**axes, "t_end": [2.0, 5.0]}, **OPTIONS)
    for place, t_end in enumerate((2.0, 5.0)):
        single = small_map(pendulum, axes=axes, **{**OPTIONS, "t_end": t_end})
        for name in NAMED:
            np.testing.assert_array_equal(
                getattr(both, name)[place], getattr(single, name), err_msg=name
            )


def test_files_need_the_function_again(tmp_path: Path) -> None:
    axes = {"length": LENGTHS, "mass": MASSES}
    result = small_map(pendulum, axes=axes, **OPTIONS)
    path = result.save(tmp_path / "map.npz")
    bare = rigid.load_map(path)
    bare.plot()
    assert "pendulum" in bare.summary()
    for call in (lambda: bare.replay((0, 0), 0), lambda: rigid.stability_map(bare.spec)):
        with pytest.raises(ValueError, match="a file has no functions; give 'pendulum' again"):
            call()
    whole = rigid.load_map(path, scene=pendulum)
    assert_same_map(rigid.stability_map(whole.spec, progress=False), result)
    with pytest.raises(ValueError, match="scene = damped: its source differs from 'pendulum'"):
        rigid.load_map(path, scene=damped)
    plain = small_map(samples=1).save(tmp_path / "plain.npz")
    with pytest.raises(ValueError, match="scene: no function makes the scenes of this map"):
        rigid.load_map(plain, scene=pendulum)


def test_functions_without_a_file_are_told_apart_too() -> None:
    names: dict[str, Any] = {"rigid": rigid, "np": np}
    exec("def one(a): return rigid.FreeBody(rigid.Body(np.stack([a, a, a + 0.1], -1)))", names)
    exec("def two(a): return rigid.FreeBody(rigid.Body(np.stack([a, a, a + 0.2], -1)))", names)
    specs = [
        small_map(names[name], axes={"a": [1.0, 2.0]}, samples=1, t_end=1.0).spec
        for name in ("one", "one", "two")
    ]
    assert specs[0] == specs[1] != specs[2]
    with pytest.raises(ValueError, match="its source differs from 'one'"):
        specs[0].with_functions(scene=names["two"])


test_functions_that_make_no_scene = refuses(
    [
        (lambda a, b: None, "axes: the function '<lambda>' needs an axis 'b'"),
        (lambda **kinds: None, "must name its arguments, without **"),
        (lambda *kinds: None, "kinds must be an argument by name"),
        (lambda c=1: None, "axes: none is an argument of the function '<lambda>'"),
        (lambda a: 3, TypeError, "must return a rigid.FreeBody or rigid.HeavyTop, not 3"),
        (
            lambda a: rigid.FreeBody(rigid.Body(np.ones((5, 3)))),
            "must return bodies of shape (1,), one for each number it is given, got (5,)",
        ),
    ],
    literal=True,
    by=lambda function: small_map(function, axes={"a": [1.0, 2.0]}, samples=1),
)


def test_an_axis_of_the_function_cannot_be_left_out() -> None:
    axes = {"length": LENGTHS, "mass": MASSES}
    spec = small_map(pendulum, axes=axes, **OPTIONS).spec
    with pytest.raises(ValueError, match="axes: the function of the scene needs an axis 'mass'"):
        spec.replace(axes={"length": LENGTHS})


# Maps over starts that a function gives, over semi-axes, rotors and energy sinks.


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
    assert "rotor" not in scene.forces
    assert result.replay(4, 0).run.spec["scene"]["rotor"] == [0.0, 0.6, 0.0]
    alone = rigid.FreeBody(scene.body, rotor=(0.0, 0.6, 0.0))
    one = small_map(
        alone,
        axes={"spin": [0.0, 0.1, 0.2, 0.3, 1.0]},
        start=start,
        stable=near,
        method="auto",
        t_end=600.0,
        samples=4,
    )
    np.testing.assert_array_equal(result.starts(3).omega[4], one.starts(3).omega[4])
    assert result.outcomes(3).left[4] == one.outcomes(3).left[4] or result.share[4] == 1.0
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


def test_the_flat_spin_comes_sooner_by_a_stronger_sink() -> None:
    """The rate about the axis of the smallest moment changes its sign by the mean loss of energy.

    The theory is a mean over nutations, good to 3 % for a sink of 0.02 (see the satellites).
    """
    moments, spin, across = (1.0, 1.7, 2.2), 1.3, 0.02
    sinks = np.array([0.0, 0.01, 0.02, 0.05])
    body = np.array([moments] * 3)
    known = [
        float(
            time_to_separatrix(body[:1], np.full(3, sink), np.array([spin]), np.array([across]))[0]
        )
        for sink in sinks[1:]
    ]
    start = rigid.Start(omega=(spin, 0.0, across))
    result = small_map(
        rigid.FreeBody(rigid.Body(moments)),
        axes={"dissipation": sinks},
        start=start,
        stable=rigid.no_flip(1),
        method="auto",
        samples=1,
        t_end=1.3 * max(known),
    )
    assert result.share.tolist() == [1.0, 0.0, 0.0, 0.0]
    left = np.array([result.replay(k, 0).left for k in (1, 2, 3)])
    np.testing.assert_allclose(left, known, rtol=0.1)
    assert result.theory() is None


# Starts of a given attitude: what a torque in space does to them, noise, files, refusals.


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
