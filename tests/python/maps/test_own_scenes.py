"""Scenes by a function of own parameters: the maps of the same numbers, files, replay, refusals."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rigid
from refusals import refuses
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
