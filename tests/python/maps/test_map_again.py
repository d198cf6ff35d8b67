"""What was saved is run again; bodies of a map in bulk; maps of counts made elsewhere."""

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rigid
from refusals import refuses
from rigid.cli import main
from rigid.maps.data import STORED
from small_maps import assert_same_map, saved_bytes, small_map, spec_of

TOP = rigid.HeavyTop(rigid.Body((1.0, 1.3, 0.7)), mgl=1.0)
NAMES = (
    *("flips", "steps", "left", "tilt", "exponent", "mean_megno"),
    *("energy_drift", "momentum_drift", "unit_drift", "step"),
)


def tops(**options: Any) -> rigid.StabilityMap:
    """Integrated tops with audits of groups of 64 bodies; one pixel has an impossible body."""
    chosen: dict[str, Any] = {
        "method": "auto",
        "axes": {"spin": [1.0, 3.0], "I1": [0.9, 1.0, 9.0]},
        "start": rigid.Start(spin=3.0, attitude_noise=rigid.normal(0.3)),
        "stable": rigid.tilt_below(0.6),
        "samples": 70,
        "t_end": 8.0,
    }
    return small_map(TOP, **{**chosen, **options})


# Run again


def test_a_map_of_an_older_version_is_run_by_this_one() -> None:
    spec = dataclasses.replace(spec_of(samples=1), version="0.0.1")
    again = rigid.stability_map(spec, progress=False).spec
    assert again == dataclasses.replace(spec, version=rigid.__version__)


def test_the_command_runs_a_result_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    older = saved_bytes(small_map(), tmp_path)
    assert main(["map", "map.npz", "--samples", "30", "--no-progress"]) == 0
    assert (tmp_path / "map.npz").read_bytes() == older
    assert_same_map(rigid.load_map(tmp_path / "map-again.npz"), small_map(samples=30))
    assert "30 per pixel" in capsys.readouterr().out
    assert main(["map", "none.npz"]) == 2
    assert "none.npz: there is no such file or folder" in capsys.readouterr().err


test_what_a_specification_leaves_no_room_for = refuses(
    [
        (
            lambda spec: rigid.stability_map(spec, samples=5),
            "samples = 5: the specification has its own; change it by spec.replace(samples=...)",
        ),
        (lambda spec: rigid.stability_map(spec, rng=5), "spec.replace(seed=...)"),
        (
            lambda spec: rigid.stability_map(spec.scene, samples=5, t_end=1.0),
            "stability_map() needs axes and stable",
        ),
        (
            lambda spec: spec.replace(sample=5),
            "sample: is no field of a specification; did you mean 'samples'? (known: scene, ",
        ),
    ],
    literal=True,
    kind=TypeError,
    by=lambda call: call(spec_of(samples=1)),
)


# Bodies in bulk


def test_starts_of_one_body_and_of_impossible_ones() -> None:
    result = tops()
    every = result.starts(range(70))
    assert every.omega.shape == (3, 2, 70, 3)
    assert every.attitude.shape == (3, 2, 70, 4)
    one = result.starts(sample=5)
    np.testing.assert_array_equal(one.omega, every.omega[:, :, 5])
    np.testing.assert_array_equal(one.attitude, every.attitude[:, :, 5])
    assert np.isnan(every.omega[2]).all()  # an impossible body
    assert np.isnan(every.attitude[2]).all()


@pytest.mark.parametrize("stable", [rigid.tilt_below(0.6), rigid.no_flip(3), rigid.regular()])
def test_an_outcome_is_that_of_its_replay_whoever_is_asked_for_with_it(stable: Any) -> None:
    result = tops(stable=stable, check=None)
    numbers = np.array([[69, 3], [64, 0]])
    some = result.outcomes(numbers)
    for pixel, place in (((0, 1), (0, 0)), ((1, 0), (0, 1)), ((1, 1), (1, 1))):
        body = result.replay(pixel, int(numbers[place]))
        alone = result.outcomes(int(numbers[place]), pixel=pixel)
        assert some.outcome[pixel][place] == alone.outcome == body.outcome
        for name in NAMES:
            expected = np.asarray(getattr(body, name))
            for found in (getattr(some, name)[pixel][place], getattr(alone, name)):
                np.testing.assert_array_equal(found, expected, err_msg=name)


def test_closed_forms_have_outcomes_too() -> None:
    result = small_map(method="exact")
    every = result.outcomes(range(20))
    assert set(every.method.ravel()) == {"exact"}
    of_steps = tops().outcomes(0)
    np.testing.assert_array_equal(np.where(tops().status, "", "dop853"), of_steps.method)


@pytest.mark.parametrize("name", ["starts", "outcomes"])
@pytest.mark.parametrize(
    ("sample", "kind", "message"),
    [
        (20, IndexError, "sample = 20: must lie in 0 .. 19"),
        ([0, -1], IndexError, "sample = -1: must lie in 0 .. 19"),
        (1.5, TypeError, "sample = 1.5: must be a whole number, or an array of them"),
    ],
)
def test_bodies_that_the_map_has_not(
    name: str, sample: Any, kind: type[Exception], message: str
) -> None:
    with pytest.raises(kind) as caught:
        getattr(small_map(), name)(sample)
    assert str(caught.value) == message


def test_outcomes_outside_the_map() -> None:
    with pytest.raises(IndexError, match="lies outside the map of shape"):
        small_map().outcomes(0, pixel=(5, 0))


# Counts made elsewhere


def test_counts_make_the_map_that_they_come_from(tmp_path: Path) -> None:
    result = tops(max_steps=100, check=1.0)
    stored = {name: getattr(result, name) for name in STORED if name not in ("failed", "status")}
    made = rigid.StabilityMap.from_counts(result.spec, **stored)
    assert_same_map(made, result)
    assert made.replay((0, 0), 3).outcome == result.replay((0, 0), 3).outcome
    assert_same_map(rigid.load_map(made.save(tmp_path / "made.npz")), made)


def test_three_counts_are_enough_for_intervals_theory_and_a_picture(tmp_path: Path) -> None:
    result = small_map(method="auto")
    made = rigid.StabilityMap.from_counts(
        result.spec, stable=result.stable, unstable=result.unstable
    )
    for name in ("share", "lower", "upper", "samples"):
        np.testing.assert_array_equal(getattr(made, name), getattr(result, name))
    assert made.complete
    np.testing.assert_array_equal(made.disagreement(), result.disagreement())
    assert made.plot().get_xlabel() == result.plot().get_xlabel()
    assert_same_map(rigid.load_map(made.save(tmp_path / "made.npz")), made)
    with pytest.raises(ValueError, match="computed again give exact = 20, the map has 0"):
        made.replay((0, 0), 0)


test_counts_that_no_computation_gives = refuses(
    [
        ({"stable": 21}, "stable[0, 0] = 21: more bodies than samples, 20"),
        ({"stable": 15, "unstable": 6}, "stable[0, 0] = 15: the classes have more bodies than 20"),
        ({"unstable": -1}, "unstable[0, 0] = -1: must not be negative"),
        ({"stable": [1, 2]}, "stable: expected shape (5, 7), got (2,)"),
        ({"stable": 1.5}, TypeError, "stable = 1.5: must be whole numbers"),
        ({"failed": 1}, TypeError, "failed: give its reasons step_limit, not_finite, drifted"),
        ({"drift": 1}, TypeError, "drift: is no column of a map; did you mean 'drifted'?"),
        ({"exact": 3}, "exact[0, 0] = 3: more bodies than the classes"),
    ],
    literal=True,
    by=lambda counts: rigid.StabilityMap.from_counts(
        spec_of(), **{"stable": 1, "unstable": 1, **counts}
    ),
)


def test_counts_of_a_scene_by_a_function_have_its_axes() -> None:
    """Axes of the user, whose names are the arguments of a function that makes the scenes."""

    def plates(width: Any, depth: Any) -> rigid.FreeBody:
        one = np.ones_like(width)
        return rigid.FreeBody(rigid.Body(np.stack([one, one + width, one + width * depth], -1)))

    function: Any = plates
    axes: Any = {"width": [0.2, 0.4], "depth": [0.1, 0.2, 0.3]}
    spec = rigid.MapSpec(
        scene=function,
        start=rigid.Start(spin=1.0),
        axes=axes,
        stable=rigid.no_flip(),
        t_end=50.0,
        samples=10,
        seed=0,
    )
    stable = np.arange(6).reshape(3, 2)
    made = rigid.StabilityMap.from_counts(spec, stable=stable, unstable=10 - stable)
    assert [axis.name for axis in made.spec.axes] == ["width", "depth"]
    np.testing.assert_array_equal(made.share, stable / 10.0)
    computed = rigid.stability_map(
        plates, axes=axes, start=rigid.Start(spin=1.0), stable=rigid.no_flip(), t_end=50.0,
        samples=10, rng=0, progress=False,
    )  # fmt: skip
    assert computed.spec == spec


def test_counts_of_no_specification() -> None:
    spec: Any = "map.toml"
    with pytest.raises(TypeError, match=r"spec = 'map.toml': must be a rigid.MapSpec"):
        rigid.StabilityMap.from_counts(spec, stable=1, unstable=1)
