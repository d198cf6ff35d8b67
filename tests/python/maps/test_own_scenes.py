"""Scenes by a function of own parameters: the maps of the same numbers, files, replay, refusals."""

import csv
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


def leaning(tilt: Floats, noise: Floats, share: Floats) -> tuple[rigid.HeavyTop, Floats, Floats]:
    """Tops that lean; the arguments are called as parameters of a map and as one of its columns."""
    half, zero = 0.5 * tilt, 0.0 * tilt
    attitude = np.stack([np.cos(half), np.sin(half), zero, zero], axis=-1)
    rates = np.stack([noise, zero, 6.0 * share], axis=-1)
    return rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0), rates, attitude


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


def test_an_argument_may_be_called_as_a_parameter_or_a_column(tmp_path: Path) -> None:
    axes = {"tilt": [0.1, 0.4, 0.6], "noise": [0.0, 0.3], "share": [0.5, 1.0]}
    start = rigid.Start(omega=(0.0, 0.0, 0.0), noise=rigid.normal(1e-3))
    options: dict[str, Any] = {**OPTIONS, "start": start, "samples": 2}
    result = small_map(leaning, axes=axes, **options)
    starts = result.starts(0)
    tilts = 2.0 * np.arcsin(starts.attitude[..., 1])
    np.testing.assert_allclose(tilts, np.broadcast_to(axes["tilt"], (2, 2, 3)), rtol=2e-15)
    nominal = np.broadcast_to([[0.0], [0.3]], (2, 2, 3))
    np.testing.assert_allclose(starts.omega[..., 0], nominal, atol=6e-3)  # six deviations
    assert "rates + normal(0.001)" in result.summary()
    with result.to_csv(tmp_path / "map.csv").open(newline="") as file:
        table = list(csv.DictReader(file))
    assert [float(row["axis_share"]) for row in table] == np.repeat(axes["share"], 6).tolist()
    assert [float(row["share"]) for row in table] == result.share.ravel().tolist()
    dataset = result.to_xarray()
    assert dataset["share"].dims == ("axis_share", "noise", "tilt")
    np.testing.assert_array_equal(dataset["axis_share"], axes["share"])


@pytest.mark.parametrize("name", ["limit", "t_end"])
def test_an_argument_is_not_called_as_a_number_of_the_map(name: str) -> None:
    functions = {"limit": lambda a, limit: None, "t_end": lambda a, t_end: None}
    with pytest.raises(ValueError, match=f"axes: '{name}' belongs to the map; call the argument"):
        small_map(functions[name], axes={"a": [1.0], name: [0.1, 0.2]})


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
    with pytest.raises(TypeError, match="axes = 3: must be a dict of names and values"):
        small_map(pendulum, axes=3, **OPTIONS)


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
