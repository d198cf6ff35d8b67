"""What a scene and a run keep for later: never stale, never large, and the same when it is read."""

import copy
import json
import pickle
from collections.abc import MutableMapping
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import pytest

import rigid
from rigid import _core
from rigid._checks.arguments import resolve_threads
from rigid.model.bodies import bodies_of
from rigid.model.scene import Scene, scene_from_dict
from rigid.solve.request import Request

BODY = rigid.Body((1.0, 1.6, 0.7))
FREE = rigid.FreeBody(BODY)
TOP = rigid.HeavyTop(BODY, mgl=1.2, com=(0.6, 0.0, 0.8))
RATES = np.array([[0.3, 0.1, 2.0], [0.5, -0.2, 1.0]])
QUATERNIONS = np.array([[0.5, -0.5, 0.5, 0.5], [1.0, 0.0, 0.0, 0.0]])

STEPS: dict[str, Any] = {"method": "rk4", "step": 0.01, "check": False}

# Equal scenes: the components of `com` differ by the sign of a zero.
SIGNED = [
    rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0, com=(zero, 0.0, 1.0))
    for zero in (0.0, -0.0)
]

MANY = rigid.FreeBody(rigid.Body([[1.0, 2.0, 2.5], [1.0, 1.0, 1.8]]), damping=[0.1, 0.0])

_, AXES = rigid.Body.from_tensor([[2.0, 0.3, 0.0], [0.3, 2.5, 0.1], [0.0, 0.1, 3.0]])

ORBIT = rigid.Orbit(0.7, 0.4, 1.0, normal=(0.0, 0.6, 0.8))
KNOTS = np.linspace(0.0, 9.0, 33)
LENGTHS = (0.05, 0.1, 0.02)

#: What files and other processes give back, and words of it.
FURTHER: dict[str, tuple[Scene, str]] = {
    "orbit": (rigid.FreeBody(BODY, orbit=ORBIT), "orbit at 0.7 rad/s, eccentricity 0.4"),
    "orbits": (
        rigid.FreeBody(BODY, orbit=rigid.Orbit([0.5, 1.0], [0.0, 0.6], true_anomaly=[0.0, 3.0])),
        "orbit of each",
    ),
    "orbit by a table": (
        rigid.FreeBody(BODY, orbit=rigid.Orbit.table(KNOTS, ORBIT.position(KNOTS), gm=1.0)),
        "orbit by a table of 33 times",
    ),
    "rotor": (rigid.FreeBody(BODY, rotor=(0.3, -0.2, 0.5)), "rotor (0.3, -0.2, 0.5)"),
    "rotors": (rigid.FreeBody(BODY, rotor=np.ones((2, 3))), "rotor of each"),
    "rotor by a table": (
        rigid.FreeBody(BODY, rotor=rigid.RotorTable(KNOTS, np.outer(KNOTS, LENGTHS))),
        "rotor by a table of 33 times",
    ),
    "sink": (
        rigid.FreeBody(BODY, dissipation=rigid.EnergySink(LENGTHS)),
        "dissipation (0.05, 0.1, 0.02)",
    ),
    "drag": (rigid.FreeBody(BODY, drag=LENGTHS), "drag (0.05, 0.1, 0.02)"),
    "pushed": (
        rigid.HeavyTop(
            BODY,
            mgl=1.5,
            com=(0.6, 0.0, 0.8),
            torque=rigid.Torque.body(np.outer(KNOTS, LENGTHS), times=KNOTS)
            + rigid.Torque.space((0.3, -0.2, 0.1)),
            damping=[[0.3, 0.05, -0.1], [0.05, 0.2, 0.02], [-0.1, 0.02, 0.4]],
        ),
        "torque in the body and space by a table of 33 times, damping ((0.3, 0.05, -0.1), ",
    ),
}

SCENES: dict[str, Scene] = {
    "free": FREE,
    "top": TOP,
    "without weight": rigid.HeavyTop(BODY, mgl=0.0),
    "com (0, 0, 1)": SIGNED[0],
    "com (-0, 0, 1)": SIGNED[1],
    "many": MANY,
    "damped, of many": MANY[0],
    "undamped, of many": MANY[1],
    "in a frame": rigid.FreeBody(BODY, damping=(0.1, 0.2, 0.3), frame=AXES),
    "driven": rigid.FreeBody(BODY, torque=rigid.Torque.body((0.1, 0.0, 0.0))),
}


def renewed(scene: Scene) -> Scene:
    """The scene as it was before it was used."""
    return pickle.loads(pickle.dumps(scene))  # type: ignore[no-any-return]


@pytest.mark.parametrize("name", [*SCENES, *FURTHER])
def test_a_scene_comes_back_from_files_and_other_processes(name: str) -> None:
    scene, words = FURTHER[name] if name in FURTHER else (SCENES[name], "")
    assert words in scene.words()
    for again in (scene_from_dict(json.loads(json.dumps(scene.to_dict()))), renewed(scene)):
        assert again == scene
        assert (repr(again), hash(again)) == (repr(scene), hash(scene))
        assert again.to_dict() == scene.to_dict()
    for other, (further, _) in FURTHER.items():
        assert (scene == further) == (name == other)


@pytest.mark.parametrize("name", FURTHER)
def test_single_steps_are_those_of_a_run(name: str) -> None:
    """A motion is told its steps in the time, whatever a run steps over."""
    scene = FURTHER[name][0]
    run = rigid.simulate(scene, RATES[0], QUATERNIONS[0], t=[4.0], method="taylor20")
    motion = rigid.Motion(scene, RATES[0], QUATERNIONS[0], method="dop853")
    for _ in range(256):
        motion.step(1.0 / 64.0)
    np.testing.assert_allclose(motion.omega, run.omega[..., -1, :], rtol=0.0, atol=1e-11)


def test_a_scene_is_told_by_what_acts() -> None:
    assert "rotor=(0.3, -0.2, 0.5)" in repr(FURTHER["rotor"][0])
    assert rigid.FreeBody(BODY, damping=0.0) == FREE
    assert FREE.to_dict().keys() == {"kind", "body"}


def everything(scene: Scene, **options: Any) -> tuple[Any, ...]:
    run = rigid.simulate(scene, RATES, t=[0.0, 0.7, 2.0], **options)
    arrays = (run.omega, run.attitude, run.error, run.energy_drift, run.status, run.start_omega)
    return (*(np.asarray(array).tobytes() for array in arrays), run.spec, run.plan)


@pytest.mark.parametrize("options", [{}, STEPS], ids=["closed form or cheapest", "steps"])
def test_a_scene_that_was_used_gives_what_a_new_one_gives(options: dict[str, Any]) -> None:
    for _ in range(2):
        for name, scene in SCENES.items():
            new, copied = renewed(scene), copy.copy(scene)
            shape, forces = scene.shape, scene.forces
            assert (new.shape, new.forces) == (shape, forces), name
            assert everything(scene, **options) == everything(new, **options), name
            assert everything(scene, **options) == everything(copied, **options), name


def test_equal_scenes_keep_what_is_their_own() -> None:
    one, other = SIGNED
    assert one == other
    words = [rigid.simulate(scene, RATES[0], t=[1.0]).plan.scene for scene in SIGNED]
    assert words == [one.words(), other.words()]
    assert words[0] != words[1]


def test_a_body_of_many_keeps_nothing_of_the_others() -> None:
    assert MANY.shape == (2,)
    assert [part.shape for part in MANY] == [(), ()]
    assert [bool(part.forces) for part in MANY] == [True, False]
    assert [rigid.simulate(part, RATES[0], t=[1.0]).work is None for part in MANY] == [False, True]


def test_a_scene_keeps_no_large_array() -> None:
    moments = 1.0 + np.random.default_rng(1).uniform(size=(1000, 3))
    scenes = [rigid.FreeBody(rigid.Body(moments)), rigid.FreeBody(BODY, damping=0.1), FREE, TOP]
    for scene in scenes:
        for states in (1, 50):
            rigid.simulate(scene, [0.1, 1.0, 0.2], t=np.linspace(0.0, 1.0, states))
        # One entry for each function, whatever was asked; a dozen numbers each.
        assert len(scene._made) < 7
        assert len(pickle.dumps(list(scene._made.values()))) < 2000


def test_threads_share_a_scene() -> None:
    scene = renewed(TOP)
    alone = everything(renewed(TOP))
    with ThreadPoolExecutor(8) as pool:
        found = list(pool.map(lambda _: everything(scene), range(16)))
    assert all(one == alone for one in found)


# The plan of a run, which is made when it is read.


@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize(
    "options", [{}, STEPS, {"method": "taylor16", "tolerance": 1e-10}, {"accuracy": 1e-7}]
)
def test_a_plan_that_is_read_late_is_that_of_the_call(name: str, options: dict[str, Any]) -> None:
    omega, attitude, times = RATES.copy(), QUATERNIONS.copy(), np.array([0.5, 2.0])
    early = rigid.simulate(SCENES[name], RATES, QUATERNIONS, t=times.copy(), **options).plan
    run = rigid.simulate(SCENES[name], omega, attitude, t=times, **options)
    omega[:], attitude[:], times[:] = 1e3, 0.1, 7.0
    assert run.plan == early
    assert run.plan is run.plan
    assert run.spec["method"] == early.method


def test_the_plan_of_a_run_is_the_plan_that_is_asked_for() -> None:
    run = rigid.simulate(TOP, RATES, t=[2.0], **STEPS)
    options: dict[str, Any] = {"omega": RATES, "t_end": 2.0, "method": "rk4", "step": 0.01}
    assert run.plan == rigid.plan(TOP, "attitude", **options)


def test_a_run_is_copied_and_pickled_with_its_plan() -> None:
    run = rigid.simulate(TOP, RATES, t=[2.0], **STEPS)
    for again in (pickle.loads(pickle.dumps(run)), copy.deepcopy(run), copy.copy(run)):
        assert again.plan == run.plan
        assert repr(again) == repr(run)
        assert again.omega.tobytes() == run.omega.tobytes()


def test_threads_read_one_plan() -> None:
    for _ in range(20):
        run = rigid.simulate(TOP, RATES, t=[2.0], **STEPS)
        with ThreadPoolExecutor(8) as pool:
            plans = list(pool.map(lambda _, run=run: run.plan, range(8)))
        assert all(plan == plans[0] for plan in plans)


# The start of a run.


def test_a_run_keeps_its_start_when_the_arrays_of_the_caller_change() -> None:
    omega, attitude, t = RATES.copy(), QUATERNIONS.copy(), np.array([2.0])
    run = rigid.simulate(FREE, omega, attitude, t=t)
    omega[:], attitude[:] = 9.0, 0.5
    t /= 3600.0
    assert run.t.tolist() == [2.0]
    assert np.array_equal(run.start_omega, RATES)
    assert np.array_equal(run.at([2.0]).omega, run.omega)
    for start in (run.start_omega, run.start_attitude):
        with pytest.raises(ValueError, match="read-only"):
            start[0] = 0.0


def test_a_single_body_needs_one_thread(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("RIGID_NUM_THREADS", raising=False)
    assert resolve_threads(None, 1) == 1
    assert resolve_threads(3, 1) == 3
    monkeypatch.setenv("RIGID_NUM_THREADS", "many")
    with pytest.raises(ValueError, match="RIGID_NUM_THREADS = 'many': must be a whole number"):
        rigid.simulate(FREE, RATES[0], t=[1.0])


# Runs of few bodies: their arrays are made when they are read


FREE_FEW = rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0)))
RATES_FEW = [0.1, 1.0, 0.2]


def states(count: int, times: int = 1) -> _core.States:
    request = Request(
        bodies=bodies_of(FREE_FEW, np.tile(RATES_FEW, (count, 1))),
        times=np.linspace(1.0, 2.0, times),
        method="exact",
        record="attitude",
        max_steps=1,
        threads=1,
    )
    return request.states()


def test_states_of_few_and_of_many_bodies_have_the_same_columns() -> None:
    few, many = states(2), states(200)
    assert isinstance(few, MutableMapping)
    assert {*few} == {*many}
    assert few.worst == many.worst == few.error.max()
    assert {name for name in few if few[name] is None} == {"gamma", "states", "tangent", "work"}
    for name in {*few} - {"nanoseconds", "gamma", "states", "tangent", "work"}:
        assert few[name].dtype == many[name].dtype
        assert np.array_equal(few[name], many[name][:2])


def test_states_are_a_mapping() -> None:
    few = states(1)
    omega = few["omega"]
    assert few["omega"] is omega
    assert few.get("omega") is omega
    assert (few.get("spin"), few.get("spin", 3)) == (None, 3)
    assert "steps" in few
    assert few.pop("steps") == 0
    assert "steps" not in few
    few["status"] = omega
    assert few["status"] is omega
    del few["status"]
    with pytest.raises(KeyError, match="status"):
        few["status"]
    assert len(few) == len(dict(few)) == len({**few})


def test_the_attributes_of_a_run_are_read_only() -> None:
    run = rigid.simulate(FREE_FEW, RATES_FEW, t=[1.0])
    for name in ("t", "omega", "events", "spec", "nanoseconds"):
        with pytest.raises(AttributeError):
            setattr(run, name, None)


@pytest.mark.parametrize(
    "rates", [RATES_FEW, tuple(RATES_FEW), np.array(RATES_FEW), np.array([RATES_FEW])[0]]
)
def test_numbers_are_the_same_however_they_are_given(rates: Any) -> None:
    run = rigid.simulate(FREE_FEW, rates, t=(1,))
    assert (
        run.omega.tobytes()
        == rigid.simulate(FREE_FEW, [*map(np.float64, RATES_FEW)], t=1).omega.tobytes()
    )


@pytest.mark.parametrize(
    "value",
    [[True, 0.0], ["1"], [2**53 + 1], [np.float32(1)], [], [[1.0]], 1.0, np.array(1.0), [np.nan]],
)
def test_what_is_not_plain_is_left_to_the_checks(value: Any) -> None:
    assert _core.plain_numbers(value) is None


def test_an_array_of_plain_numbers_is_itself() -> None:
    array = np.array([[0.0, 1.0, 2.0]])
    assert _core.plain_numbers(array, 3) is array
    assert _core.plain_numbers(array, ascending=True) is array
    for refused in (array[:, ::2], array.astype(">f8"), np.ma.array(array), array[:, ::-1].copy()):
        assert _core.plain_numbers(refused, 3, ascending=True) is None
    assert _core.plain_numbers(array, 2) is None
