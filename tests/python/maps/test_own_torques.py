"""Maps under the torque of a function: against their built-in twins, again, and in words.

Damping and a torque in space have built-in twins, which a Taylor series classifies.
"""

import ctypes
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rigid
from refusals import refuses
from rigid.model.criterion import Criterion
from rigid.model.scene import Scene

BODY = rigid.Body((1.0, 1.5, 2.0))
DOUBLES = ctypes.POINTER(ctypes.c_double)
SIGNATURE: Any = ctypes.CFUNCTYPE(None, ctypes.c_double, DOUBLES, DOUBLES, DOUBLES, DOUBLES)
FASTEST = 3.0


@SIGNATURE  # type: ignore[untyped-decorator]
def damping(t: float, omega: Any, attitude: Any, data: Any, torque: Any) -> None:
    for k in range(3):
        torque[k] = -data[0] * omega[k]


@SIGNATURE  # type: ignore[untyped-decorator]
def in_space(t: float, omega: Any, attitude: Any, data: Any, torque: Any) -> None:
    """The torque (size, 0, size) in space, in body components."""
    w, x, y, z = attitude[:4]
    torque[0] = data[0] * (1 - 2 * (y * y + z * z) + 2 * (x * z - w * y))
    torque[1] = data[0] * (2 * (x * y - w * z) + 2 * (y * z + w * x))
    torque[2] = data[0] * (2 * (x * z + w * y) + 1 - 2 * (x * x + y * y))


def called(function: Any, gain: Any) -> rigid.Torque:
    return rigid.Torque.call(function, gain[:, np.newaxis], fastest=FASTEST)


def damped(gain: Any) -> Scene:
    return rigid.FreeBody(BODY, damping=gain[:, np.newaxis] * np.ones(3))


def damped_by_a_function(gain: Any) -> Scene:
    return rigid.FreeBody(BODY, torque=called(damping, gain))


def damped_without_a_bound(gain: Any) -> Scene:
    return rigid.FreeBody(BODY, torque=rigid.Torque.call(damping, gain[:, np.newaxis]))


def pushed(gain: Any) -> Scene:
    torque = rigid.Torque.space(gain[:, np.newaxis] * np.array([1.0, 0.0, 1.0]))
    return rigid.HeavyTop(BODY, mgl=0.5, com=(0.0, 0.6, 0.8), torque=torque)


def pushed_by_a_function(gain: Any) -> Scene:
    return rigid.HeavyTop(BODY, mgl=0.5, com=(0.0, 0.6, 0.8), torque=called(in_space, gain))


ASKED: dict[str, Any] = {
    "axes": {"gain": [0.05, 0.2], "spin": [0.4, 1.5]},
    "start": rigid.Start(spin=1.0, axis=3, noise=rigid.normal(0.2)),
    "t_end": 8.0,
    "samples": 2,
    "rng": 16,
    "threads": 1,  # two would wait for each other in Python
}
CLASSES = ("stable", "unstable", "undecided", "failed")


def counts(result: rigid.StabilityMap) -> Any:
    return np.array([getattr(result, name) for name in CLASSES])


ORBIT = rigid.Orbit(1.0, 0.1)


def librating(gain: Any) -> Scene:
    return rigid.FreeBody(BODY, orbit=ORBIT, damping=gain)


def librating_under_a_function(gain: Any) -> Scene:
    return rigid.FreeBody(BODY, orbit=ORBIT, torque=called(damping, gain))


MEASURED = {"measure": [rigid.flips(1), rigid.mean_rate(3)]}
SATELLITES = {
    "axes": {"gain": [0.05, 0.2]},
    "start": rigid.Start(omega=(0.0, 0.0, 1.0), noise=rigid.normal(0.4)),
    "samples": 12,
}
TILTED = {
    "axes": {"gain": [0.02, 0.3], "tilt": [0.1, 0.7]},
    "start": rigid.Start(spin=1.5, axis=3, noise=rigid.normal(0.2)),
    "samples": 4,
}
TWINS: list[tuple[Any, Any, dict[str, Any], Criterion]] = [
    (damped, damped_by_a_function, MEASURED, ~rigid.spin_above(0.3)),
    (damped, damped_by_a_function, MEASURED, rigid.spin_above(0.2, axis=3)),
    (damped, damped_by_a_function, MEASURED, rigid.no_flip(axis=1)),
    (damped, damped_by_a_function, MEASURED, rigid.rate_within(0.4)),
    (damped, damped_by_a_function, MEASURED, rigid.near_start(3.0)),
    (damped, damped_by_a_function, MEASURED, rigid.returns(1.0, after=3.0)),
    (librating, librating_under_a_function, SATELLITES, rigid.pointing_within(1.2, 1, either=True)),
    (librating, librating_under_a_function, SATELLITES, rigid.no_flip(axis=3)),
    (librating, librating_under_a_function, SATELLITES, rigid.rate_within(0.6)),
    (pushed, pushed_by_a_function, TILTED, rigid.tilt_below(0.8)),
    (pushed, pushed_by_a_function, TILTED, rigid.tilt_between(0.0, 1.2)),
]


@pytest.mark.parametrize(("scene", "by_a_function", "options", "stable"), TWINS)
def test_a_map_under_a_function_is_that_of_its_twin(
    scene: Any, by_a_function: Any, options: dict[str, Any], stable: Criterion
) -> None:
    asked = {**ASKED, "stable": stable, **options}
    known = rigid.stability_map(scene, **asked)
    by_it = rigid.stability_map(by_a_function, **asked)
    assert np.array_equal(counts(by_it), counts(known))
    assert 0 < known.stable.sum() < known.samples.sum()
    # What is watched inside steps of 0.6 rad is known to 1e-6 of a turn; a time of leaving so far
    # as the margin of the criterion changes by no less than a hundredth of that.
    left = np.isfinite(known.earliest)
    assert np.array_equal(left, np.isfinite(by_it.earliest))
    assert np.allclose(by_it.earliest[left], known.earliest[left], rtol=0.0, atol=1e-4)
    for name, mine in by_it.measures.items():
        assert np.allclose(mine.mean, known.measures[name].mean, rtol=0.0, atol=1e-6)
    assert by_it.plan.method == "dop853"
    if options is MEASURED:
        assert (by_it.checked == by_it.samples).all()
        assert "cross-checked by dop853 in half the steps" in by_it.summary()


@pytest.mark.parametrize("method", ["rk4", "dop853", "midpoint"])
def test_each_method_of_functions_makes_a_map(method: str) -> None:
    asked = {**ASKED, "stable": rigid.no_flip(axis=1)}
    known = rigid.stability_map(damped, **asked)
    by_it = rigid.stability_map(damped_by_a_function, **asked, method=method)
    assert np.array_equal(by_it.stable + by_it.undecided >= known.stable, [[True] * 2] * 2)
    assert np.array_equal(by_it.unstable + by_it.undecided >= known.unstable, [[True] * 2] * 2)


@SIGNATURE  # type: ignore[untyped-decorator]
def thruster(t: float, omega: Any, attitude: Any, data: Any, torque: Any) -> None:
    """Brakes axis 3 for 7.3 s of each 50 s."""
    torque[0] = torque[1] = 0.0
    torque[2] = -data[0] if t % 50.0 < 7.3 else 0.0


def test_a_time_of_leaving_is_right_to_a_thousandth_or_undecided() -> None:
    def scene(size: Any) -> Scene:
        torque = rigid.Torque.call(thruster, size[:, np.newaxis], fastest=0.3)
        return rigid.FreeBody(BODY, torque=torque)

    spins = np.linspace(0.03, 0.06, 4)
    size, slow = 4.8e-3, 0.01
    asked: dict[str, Any] = {
        "axes": {"size": [size], "spin": spins},
        "start": rigid.Start(spin=0.1, axis=3),
        "stable": rigid.spin_above(slow),
        "measure": [rigid.time_to_leave(), rigid.mean_rate(3)],
        "threads": 1,
        "t_end": 160.0,  # the last body leaves at 106 s, by the coarsest steps later
        "samples": 1,
    }
    # The thruster must act for so long: whole firings, and a part of the last one.
    acting = (spins - slow) * BODY.moments[2] / size
    times = 50.0 * np.floor(acting / 7.3) + acting % 7.3
    for step, known in ((None, 0), (0.5, 3)):
        result = rigid.stability_map(scene, **asked, step=step)
        assert result.unstable.sum() == len(spins)
        found = result.measures["time_to_leave"]
        has = found.count[:, 0] > 0
        # Two runs that agree to a thousandth may share a part of their errors.
        assert np.allclose(found.mean[has, 0], times[has], rtol=2e-3, atol=0.0)
        assert has.sum() >= known
        words = f"{np.count_nonzero(~has)} undecided"
        (told,) = (line for line in result.summary().splitlines() if "time_to_leave" in line)
        assert told.endswith(words) == (not has.all())
        leaving = result.outcomes(0).measures["time_to_leave"]
        assert np.array_equal(np.isnan(np.ravel(leaving)), ~has)


@pytest.mark.parametrize("scene", [pushed, pushed_by_a_function])
def test_every_time_of_leaving_is_told_by_two_runs(scene: Any) -> None:
    # Of a tilt only doubtful verdicts are checked; a time that is measured is checked always.
    asked: dict[str, Any] = {**ASKED, **TILTED, "stable": rigid.tilt_below(0.8)}
    verdicts = rigid.stability_map(scene, **asked)
    assert (verdicts.checked < verdicts.samples).any()
    measured = rigid.stability_map(scene, **asked, measure=rigid.time_to_leave())
    assert (measured.checked == measured.samples).all()
    assert np.array_equal(counts(measured)[:2], counts(verdicts)[:2])


def slow_at_the_end(states: Any) -> Any:
    return np.linalg.norm(states.omega[:, -1], axis=-1) < 0.3


def test_a_custom_criterion_needs_no_bound_of_the_rates() -> None:
    asked = {**ASKED, "stable": rigid.judged(slow_at_the_end, t=[4.0, 8.0])}
    del asked["t_end"]
    known = rigid.stability_map(damped, **asked)
    by_it = rigid.stability_map(damped_without_a_bound, **asked)
    assert np.array_equal(counts(by_it), counts(known))
    assert 0 < known.stable.sum() < known.samples.sum()
    assert by_it.checked.sum() == by_it.samples.sum()
    replay = by_it.replay((1, 1), 1)
    assert replay.run.spec["tolerance"] is not None
    by_steps = rigid.stability_map(damped_without_a_bound, **asked, step=0.2)
    assert np.array_equal(counts(by_steps), counts(known))


def test_a_body_of_the_map_is_replayed_with_its_bits() -> None:
    result = rigid.stability_map(damped_by_a_function, **ASKED, stable=~rigid.spin_above(0.3))
    replay = result.replay((0, 1), 1)
    assert replay.outcome in CLASSES
    last = np.linalg.norm(replay.run.omega[-1])
    assert (last < 0.3) == (replay.outcome == "stable")


def test_a_body_that_begins_without_the_watched_rate_gets_its_sign_from_the_function() -> None:
    # Nothing turns at first: the torque, which points along -1, decides about the sign of omega1.
    def negative(gain: Any) -> Scene:
        return rigid.FreeBody(BODY, torque=called(in_space, -gain))

    result = rigid.stability_map(
        negative,
        axes={"gain": [0.1, 0.2]},
        start=rigid.Start(omega=(0.0, 0.0, 0.0)),
        stable=rigid.no_flip(axis=1),
        t_end=0.5,
        samples=2,
        rng=1,
    )
    assert result.stable.tolist() == [2, 2]


def test_the_numbers_of_a_map_do_not_depend_on_threads_or_blocks() -> None:
    asked = {**ASKED, "stable": rigid.no_flip(axis=1)}
    one = rigid.stability_map(damped_by_a_function, **{**asked, "threads": 2})
    assert rigid.diff(one, rigid.stability_map(damped_by_a_function, **asked)).same


# One scene for all pixels, which a file does not have


def one_scene(gain: float = 0.1) -> rigid.FreeBody:
    return rigid.FreeBody(BODY, torque=rigid.Torque.call(damping, [gain], fastest=FASTEST))


OF_ONE: dict[str, Any] = {
    **ASKED,
    "axes": {"spin": [0.4, 1.5]},
    "stable": ~rigid.spin_above(0.3),
}


def test_a_saved_map_asks_for_its_scene_in_words(tmp_path: Path) -> None:
    result = rigid.stability_map(one_scene(), **OF_ONE)
    path = result.save(tmp_path / "map.npz")
    read = rigid.load_map(path)
    assert np.array_equal(read.stable, result.stable)
    with pytest.raises(ValueError, match="its torque is a function, which no file has"):
        read.replay((1,), 0)
    again = rigid.load_map(path, scene=one_scene())
    assert np.array_equal(again.replay((1,), 0).run.omega, result.replay((1,), 0).run.omega)
    with pytest.raises(ValueError, match="differs from the scene of the map"):
        rigid.load_map(path, scene=one_scene(0.2))


def test_a_stored_map_goes_on_with_its_scene_and_not_without(tmp_path: Path) -> None:
    whole = rigid.stability_map(one_scene(), **OF_ONE)
    for part in ("1/2", "2/2"):
        stored = rigid.stability_map(one_scene(), **OF_ONE, store=tmp_path / "run", part=part)
        if part == "1/2":
            with pytest.raises(ValueError, match="its torque is a function, which no file has"):
                rigid.open_store(tmp_path / "run").resume()
    assert np.array_equal(stored.stable, whole.stable)
    rigid.open_store(tmp_path / "run", scene=one_scene()).resume()


def test_other_processes_cannot_call_the_function() -> None:
    asked = {**OF_ONE, "threads": None}
    refused = pytest.raises(ValueError, match="which other processes cannot call")
    with ProcessPoolExecutor(1) as executor, refused:
        rigid.stability_map(one_scene(), **asked, executor=executor)


test_what_a_map_under_a_function_cannot_do_is_refused = refuses(
    [
        (rigid.no_flip(), {"scene": damped_without_a_bound}, "step: is needed, because the rates"),
        (rigid.regular(), {}, "the derivative of a function is not known"),
        (rigid.no_flip(), {"method": "etd4"}, "does not integrate the torque of a function"),
    ],
    by=lambda stable, changed: rigid.stability_map(
        **{"scene": damped_by_a_function, **ASKED, "stable": stable, **changed}
    ),
)
