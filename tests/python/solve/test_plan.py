"""The plan says what is done, what is omitted and why; closed forms are taken where they exist."""

import dataclasses
import json
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import rigid
from physics import LISTED, METHODS, tilted
from processes import run_python
from refusals import refuses
from rigid import _timing as timing
from rigid import planning
from rigid.model.bodies import bodies_of
from rigid.model.scene import Scene
from small_maps import small_map

FREE = rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0)))
SYMMETRIC = rigid.FreeBody(rigid.Body((2.0, 3.0, 2.0)))
SPHERE = rigid.FreeBody(rigid.Body((2.0, 2.0, 2.0)))
LAGRANGE = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)
HEAVY = rigid.HeavyTop(rigid.Body((1.0, 1.4, 0.7)), mgl=1.0, com=(0.6, 0.0, 0.8))
RATES = [0.3, 1.0, 2.0]

RECORDS = ("rates", "axis", "attitude")


def lagrange(axis: int, side: float) -> rigid.HeavyTop:
    """A top symmetric about that axis, its centre of mass on one side of it."""
    moments, com = np.ones(3), np.zeros(3)
    moments[axis - 1], com[axis - 1] = 0.5, side
    return rigid.HeavyTop(rigid.Body(moments), mgl=1.0, com=com)


# Words


PLANS: list[Callable[[], rigid.Plan]] = [
    lambda: rigid.plan(FREE, "rates"),
    lambda: rigid.plan(FREE, "attitude", omega=RATES, t_end=0.1, accuracy=1e-9),
    lambda: rigid.plan(FREE, rigid.no_flip(), t_end=1.0),
    lambda: rigid.plan(LAGRANGE, rigid.tilt_below(0.5), omega=RATES, t_end=1e3),
    lambda: rigid.plan(HEAVY, "axis"),
    lambda: rigid.plan(HEAVY, "rates", omega=RATES, step=0.1),
    lambda: rigid.plan(HEAVY, "attitude", omega=RATES, t_end=1.0 / 3.0, method="splitting"),
    lambda: rigid.plan(HEAVY, rigid.tilt_below(1.0, axis=-2), omega=[0, 0, 0], t_end=1.0),
    lambda: rigid.plan(HEAVY, "rates", omega=RATES, t_end=1.0, cost=True),
    lambda: rigid.simulate(HEAVY, RATES, t=[1.0], method="taylor16", tolerance=1e-11).plan,
    lambda: small_map(samples=1).plan,
]


@pytest.mark.parametrize("make", PLANS)
def test_a_plan_round_trips_through_json_and_is_read_in_lines(
    make: Callable[[], rigid.Plan],
) -> None:
    plan = make()
    assert rigid.Plan.from_dict(plan.to_dict()) == plan
    assert rigid.Plan.from_json(plan.to_json()) == plan
    assert rigid.Plan.from_json(plan.to_json()).to_json() == plan.to_json()
    assert hash(rigid.Plan.from_json(plan.to_json())) == hash(plan)
    assert json.loads(plan.to_json())["method"] == plan.method
    with pytest.raises(dataclasses.FrozenInstanceError):
        plan.method = "rk5"  # type: ignore[misc]
    assert not hasattr(plan, "__dict__")
    facts = dict(line.split(maxsplit=1) for line in str(plan).splitlines())
    names = ["scene", "question", "method", "carried", "why", "left", "error"]
    names += ["cost"] if plan.cost is not None else []
    assert list(facts) == (names if plan.memory is None else [*names, "memory"])
    assert facts["method"].startswith(plan.method)
    assert facts["scene"] == plan.scene
    assert facts["question"] == plan.question
    assert plan.why
    for words in (*plan.why, *plan.left_out):
        assert words in facts["why"] + facts["left"]


def test_less_is_carried_where_less_is_asked() -> None:
    carried = [rigid.plan(FREE, record).carried for record in RECORDS]
    assert carried == [("omega",), ("omega", "gamma", "attitude"), ("omega", "attitude")]
    # A method needs the vertical of a top for its torque, a closed form does not.
    carried = [rigid.plan(HEAVY, record).carried for record in RECORDS]
    assert carried == [("omega", "gamma"), ("omega", "gamma"), ("omega", "gamma", "attitude")]
    assert rigid.plan(LAGRANGE, "rates").carried == ("omega", "attitude")
    flips = rigid.plan(FREE, rigid.no_flip(), t_end=1.0)
    assert flips.carried == ()
    assert rigid.plan(HEAVY, rigid.no_flip(1), t_end=1.0).carried == ("omega", "gamma")
    assert "rates only: no attitude" in rigid.plan(FREE, "rates").left_out
    assert "no weight: no vertical" in rigid.plan(FREE, "rates").left_out
    assert "no torque: no steps" in rigid.plan(FREE, "rates").left_out
    assert "class only: no trajectory, no attitude" in flips.left_out


#: What acts, and what is carried for rates, for attitudes and for a class: the layouts of
#: ``src/scene/layout.rs`` that ``System::carrying`` of ``src/kernel/registry.rs`` takes.
CARRIED: dict[str, tuple[dict[str, Any], tuple[str, str, str]]] = {
    "damping": ({"damping": (0.1, 0.2, 0.3)}, ("omega work", "frame work", "omega work")),
    "torque in space": (
        {"torque": rigid.Torque.space((0.1, 0.0, 0.0))},
        ("frame work", "frame work", "frame work"),
    ),
    "rotor": ({"rotor": (0.0, 0.0, 0.3)}, ("omega work", "frame work orbit", "omega work")),
    "orbit": (
        {"orbit": rigid.Orbit(1.0)},
        ("frame work orbit", "frame work orbit", "frame orbit"),
    ),
    "orbit and rotor": (
        {"orbit": rigid.Orbit(1.0), "rotor": (0.0, 0.0, 0.3)},
        ("frame work orbit", "frame work orbit", "frame work orbit"),
    ),
}


@pytest.mark.parametrize("what", CARRIED)
def test_a_plan_under_forces_tells_what_is_carried(what: str) -> None:
    forces, expected = CARRIED[what]
    scene = rigid.FreeBody(rigid.Body((1.0, 1.5, 2.0)), **forces)
    questions: list[Any] = ["rates", "attitude", rigid.no_flip()]
    for question, words in zip(questions, expected, strict=True):
        method = "taylor12" if isinstance(question, str) else "auto"
        plan = rigid.plan(scene, question, t_end=1.0, method=method)
        names = words.replace("frame", "omega gamma attitude").split()
        assert set(plan.carried) == set(names), question
        left = "; ".join(plan.left_out)
        assert ("no attitude" in left) == ("attitude" not in names)
        assert ("no work" in left) == ("work" not in names)


def test_a_plan_tells_which_forces_are_computed_although_they_do_not_act() -> None:
    """All further forces are in one kernel; without the attitude there is no orbit in it."""
    spun = rigid.FreeBody(rigid.Body((1.0, 1.5, 2.0)), rotor=(0.0, 0.0, 0.3))
    shared = "one kernel has all further forces: "
    both = f"{shared}dissipation and drag are computed as zeros"
    assert both in rigid.plan(spun, "rates").why
    every = f"{shared}the gravity gradient of an orbit, dissipation and drag are computed as zeros"
    assert every in rigid.plan(spun).why
    on_orbit = rigid.FreeBody(rigid.Body((1.0, 1.5, 2.0)), orbit=rigid.Orbit(1.0))
    assert (
        f"{shared}dissipation, a rotor and drag are computed as zeros" in rigid.plan(on_orbit).why
    )
    for alone in (rigid.plan(FREE), rigid.plan(on_orbit, rigid.no_flip(), t_end=1.0)):
        assert shared not in "; ".join(alone.why)


def test_errors_and_steps_grow_with_the_angle_turned() -> None:
    short, long = (rigid.plan(FREE, "rates", omega=RATES, t_end=t) for t in (10.0, 1000.0))
    assert present_float(long.error) == pytest.approx(100.0 * present_float(short.error), rel=0.1)
    short, long = (
        rigid.plan(FREE, "rates", omega=RATES, t_end=t, method="rk4") for t in (10.0, 1000.0)
    )
    assert short.step == long.step
    assert long.steps == pytest.approx(100.0 * present_float(short.steps), rel=0.01)
    assert short.error is long.error is None  # of steps it is known after a run
    nothing_known = rigid.plan(HEAVY, "rates")
    assert nothing_known.step is nothing_known.steps is None
    assert nothing_known.cost is nothing_known.error is None


def test_adaptive_steps_are_told_by_their_tolerance() -> None:
    run: Any = rigid.simulate(HEAVY, RATES, t=[1.0], method="taylor16", tolerance=1e-11)
    plan = run.plan
    assert (plan.tolerance, plan.step, plan.steps) == (1e-11, None, run.steps)
    assert plan.error == run.error
    assert plan.method_words() == f"taylor16, tolerance 1e-11, about {run.steps} steps"
    assert rigid.plan(HEAVY, "rates", step=0.1).tolerance is None
    assert rigid.plan(FREE, "rates").tolerance is None


def present_float(value: float | None) -> float:
    assert value is not None
    return value


# Errors of closed forms that a plan does not know

UNFORESEEN: dict[str, tuple[Scene, Any, Any, float]] = {
    "nearly at rest": (LAGRANGE, [1e-9, 2e-9, 1e-9], tilted(np.pi), 1.0),
    "passes a saddle": (LAGRANGE, [2.0 * np.sin(0.5), 0.0, 0.0], tilted(1.0), 30.0),
}


@pytest.mark.parametrize("words", UNFORESEEN)
def test_an_error_that_is_not_foreseen_is_unknown(words: str) -> None:
    scene, omega, attitude, end = UNFORESEEN[words]
    plan = rigid.plan(scene, "attitude", omega=omega, attitude=attitude, t_end=end)
    assert (plan.method, plan.error) == ("exact", None)
    assert plan.why[-1].startswith("error unknown: ")
    assert words in plan.why[-1]
    # One such body among many is enough.
    rows = np.broadcast_to(RATES, (40, 3)).copy()
    assert rigid.plan(scene, "attitude", omega=rows, attitude=attitude, t_end=end).error is not None
    rows[7] = omega
    assert rigid.plan(scene, "attitude", omega=rows, attitude=attitude, t_end=end).error is None


def test_ten_times_slower_than_a_fall_is_nearly_at_rest() -> None:
    """A hanging top, whose weight could give it 1 rad/s."""
    for rate, known in ((0.105, True), (0.095, False)):
        plan = rigid.plan(LAGRANGE, omega=[rate, 0.0, 0.0], attitude=tilted(np.pi), t_end=1.0)
        assert (plan.error is not None) == known


# Which form


@pytest.mark.parametrize(
    ("scene", "form"),
    [(FREE, "free asymmetric"), (SYMMETRIC, "free symmetric"), (SPHERE, "axis spin")],
    ids=["asymmetric", "symmetric", "spherical"],
)
def test_every_free_body_has_a_closed_form(scene: rigid.FreeBody, form: str) -> None:
    questions: list[Any] = [*RECORDS, rigid.no_flip(), rigid.no_flip(1)]
    for question in questions:
        plan = rigid.plan(scene, question, t_end=10.0)
        assert (plan.method, plan.closed_form, plan.steps) == ("exact", form, 0)
    # The largest tilt from the start has none.
    assert rigid.plan(scene, rigid.tilt_below(0.5), t_end=10.0).closed_form is None


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize("axis", [1, 2, 3])
def test_a_top_is_symmetric_about_any_axis_with_its_mass_on_either_side(
    axis: int, side: float
) -> None:
    scene = lagrange(axis, side)
    closed: list[Any] = [*RECORDS, rigid.no_flip(axis)]
    closed += [rigid.tilt_below(0.5, axis=k) for k in (axis, -axis)]
    for question in closed:
        plan = rigid.plan(scene, question, t_end=10.0)
        assert (plan.method, plan.closed_form) == ("exact", "lagrange")
    other = axis % 3 + 1
    for question in (
        rigid.no_flip(other),
        rigid.tilt_below(0.5, axis=other),
        rigid.tilt_below(0.5, axis=axis, reference="start"),
    ):
        plan = rigid.plan(scene, question, t_end=10.0)
        assert plan.closed_form is None
        assert plan.steps
        assert plan.why[0].endswith(f": the symmetry axis is {axis}")
    run = rigid.simulate(scene, RATES, t=[1.0])
    assert run.plan.closed_form == "lagrange"
    assert run.steps == 0


UP, DOWN = np.nextafter(1.0, [2.0, 0.0])


@pytest.mark.parametrize(
    ("moments", "com", "why"),
    [
        ((1.0, UP, 0.5), (0.0, 0.0, 1.0), "no two moments of the top are exactly equal"),
        ((1.0, DOWN, 0.5), (0.0, 0.0, 1.0), "no two moments of the top are exactly equal"),
        ((1.0, 1.0, 0.5), (1e-300, 0.0, 1.0), "the centre of mass is not on the symmetry axis"),
        ((1.0, 1.0, 0.5), (1.0, 0.0, 0.0), "the centre of mass is not on the symmetry axis"),
        ((1.0, 0.5, 1.0), (0.0, 0.0, 1.0), "the centre of mass is not on the symmetry axis"),
        ((1.0, 1.0, 1.0), (0.6, 0.8, 0.0), "the centre of mass is on no principal axis"),
    ],
)
def test_what_is_nearly_symmetric_is_not_made_symmetric(
    moments: tuple[float, ...], com: tuple[float, ...], why: str
) -> None:
    scene = rigid.HeavyTop(rigid.Body(moments), mgl=1.0, com=com)
    questions: list[Any] = [*RECORDS, rigid.tilt_below(0.5), rigid.no_flip(3)]
    cheapest = rigid.plan(scene, "rates", omega=RATES, t_end=50.0, accuracy=1e-8).method
    for question in questions:
        horizon = None if isinstance(question, str) else 50.0
        plan = rigid.plan(scene, question, omega=RATES, t_end=horizon)
        assert plan.closed_form is None
        assert plan.why[0] == f"no closed form: {why}"
        if isinstance(question, str):
            assert plan.method == cheapest
    assert rigid.simulate(scene, RATES, t=[1.0]).steps > 0


def test_a_nearly_symmetric_free_body_is_asymmetric() -> None:
    scene = rigid.FreeBody(rigid.Body((1.0, UP, 0.5)))
    assert rigid.plan(scene, "rates").scene == f"free body, moments (1.0, {float(UP)!r}, 0.5)"
    assert rigid.plan(scene, "rates").closed_form == "free asymmetric"


def test_a_top_without_weight_is_a_free_body() -> None:
    scene = rigid.HeavyTop(FREE.body, mgl=0.0)
    plan = rigid.plan(scene, "attitude", omega=RATES)
    assert (plan.method, plan.closed_form) == ("exact", "free asymmetric")
    weightless, free = (rigid.simulate(each, RATES, t=[1.0, 7.0]) for each in (scene, FREE))
    assert weightless.omega.tobytes() == free.omega.tobytes()


def test_a_swing_about_a_principal_axis_is_a_pendulum_if_all_bodies_swing() -> None:
    # The centre of mass lies across axis 2, which is horizontal and stays so.
    swinging, tumbling = [0.0, 1.5, 0.0], [0.1, 1.5, 0.0]
    start = tilted(0.0)
    top = rigid.plan(HEAVY, "rates", omega=tumbling, t_end=1.0, accuracy=1e-8).method
    assert rigid.plan(HEAVY, "rates").closed_form is None
    assert rigid.plan(HEAVY, "rates", omega=swinging, attitude=start).closed_form == "pendulum"
    assert rigid.plan(HEAVY, "rates", omega=[swinging] * 3).method == "exact"
    assert rigid.plan(HEAVY, "rates", omega=[swinging, tumbling], t_end=1.0).method == top
    assert rigid.simulate(HEAVY, swinging, start, t=[1.0]).plan.closed_form == "pendulum"
    run = rigid.simulate(HEAVY, [swinging, tumbling], start, t=[1.0], record="rates")
    assert run.plan.method == top


@pytest.mark.parametrize("scene", [FREE, SYMMETRIC, SPHERE, LAGRANGE, lagrange(1, -1.0), HEAVY])
def test_the_core_knows_the_closed_forms_that_are_planned(scene: Scene) -> None:
    rng = np.random.default_rng(7)
    omega, attitude = rng.normal(size=(20, 3)), rng.normal(size=(20, 4))
    forms = rigid._core.closed_forms(bodies_of(scene, omega, attitude))
    planned = rigid.plan(scene, "attitude").closed_form
    names = rigid._core.closed_form_names()
    assert {names[code] for code in forms} == {planned or ""}


# Which method


def test_a_method_or_a_step_that_is_asked_for_is_taken() -> None:
    for method in METHODS:
        run = rigid.simulate(FREE, RATES, t=[1.0], method=method.name)
        assert run.spec["method"] == run.plan.method == method.name
        assert run.plan.why == (f"method = {method.name!r} was asked for",)
    run = rigid.simulate(FREE, RATES, t=[1.0], step=0.25)
    assert run.spec["method"] == "rk4"
    assert run.steps == 4
    assert run.plan.why == ("a step was asked for",)
    run = rigid.simulate(FREE, RATES, t=[1.0], step=0.25, method="exact")
    assert (run.spec["method"], run.spec["step"]) == ("exact", None)
    assert run.steps == 0
    assert "closed form: step = 0.25 is not needed" in run.plan.left_out


@pytest.mark.parametrize("record", RECORDS)
@pytest.mark.parametrize("method", [None, "exact"])
@pytest.mark.parametrize("scene", [FREE, SYMMETRIC, SPHERE, LAGRANGE])
def test_a_closed_form_is_taken_for_the_reason_that_is_planned(
    scene: Scene, method: str | None, record: str
) -> None:
    run = rigid.simulate(scene, RATES, t=[5.0], record=record, method=method)
    assert rigid.plan(scene, record, omega=RATES, t_end=5.0, method=method).why == run.plan.why


@pytest.mark.parametrize("method", METHODS, ids=lambda method: method.name)
@pytest.mark.parametrize("scene", [FREE, SYMMETRIC, SPHERE, LAGRANGE, lagrange(2, -1.0), HEAVY])
def test_the_steps_that_are_planned_are_taken(scene: Scene, method: rigid.Method) -> None:
    rates = np.random.default_rng(3).normal(size=(10, 3))
    for omega in rates:
        run = rigid.simulate(scene, omega, tilted(0.3), t=[5.0], method=method.name)
        plan = rigid.plan(
            scene, "attitude", omega=omega, attitude=tilted(0.3), t_end=5.0, method=method.name
        )
        # The run knows its steps and its error.
        assert run.plan == dataclasses.replace(plan, steps=int(run.steps), error=float(run.error))
        # Both round the bound of the rates, perhaps across a whole number of steps.
        assert abs(int(run.steps) - (plan.steps or 0)) <= 1


@pytest.mark.parametrize("method", ["rk4", "dop853", "taylor16"])
@pytest.mark.parametrize(("eccentricity", "anomaly"), [(0.0, 0.0), (0.8, 1.0), (4.25, -20.0)])
def test_the_steps_that_are_planned_over_an_orbit_are_taken(
    method: str, eccentricity: float, anomaly: float
) -> None:
    """The steps of two of them are equal over the anomaly, and as short as far from the planet."""
    scene = rigid.FreeBody(FREE.body, orbit=rigid.Orbit(1.0, eccentricity, anomaly))
    request: dict[str, Any] = {"attitude": tilted(0.3), "method": method}
    run = rigid.simulate(scene, RATES, t=[30.0], **request)
    plan = rigid.plan(scene, "attitude", omega=RATES, t_end=30.0, **request)
    assert abs(int(run.steps) - (plan.steps or 0)) <= 1


@pytest.mark.parametrize("record", RECORDS)
@pytest.mark.parametrize("scene", [FREE, HEAVY, rigid.HeavyTop(HEAVY.body, mgl=1.0, damping=0.1)])
@pytest.mark.parametrize("shape", [(), (7,)])
def test_the_memory_of_a_plan_is_that_of_the_states(
    scene: Scene, record: str, shape: tuple[int, ...]
) -> None:
    omega = np.broadcast_to([0.4, 0.3, 2.0], (*shape, 3))
    run = rigid.simulate(scene, omega, t=[1.0, 2.0, 3.0], record=record, method="dop853")
    columns: list[Any] = [run.omega, run.gamma, run.attitude, run.work, run.steps, run.status]
    columns += [run.energy_drift, run.momentum_drift, run.unit_drift]
    states = sum(np.asarray(column).nbytes for column in columns if column is not None)
    count = shape[0] if shape else 1
    # And the bound of the rates.
    assert run.plan.memory == states + 8 * count
    planned = rigid.plan(
        scene, record, omega=[0.4, 0.3, 2.0], t_end=3.0, method="dop853", bodies=count, times=3
    )
    assert planned.memory == run.plan.memory
    assert "\nmemory      " in str(planned)


def test_a_criterion_keeps_no_states() -> None:
    assert rigid.plan(FREE, rigid.no_flip(3), t_end=1.0).memory is None
    assert rigid.plan(FREE, "rates").memory is None
    huge: Any = rigid.plan(FREE, "attitude", bodies=10**9, times=10**6)
    assert huge.memory > 10**16
    assert "memory      5.6e+07 GB for the states" in str(huge)


# Refusals


STATES_RULE = "closed forms are known of a free body, of a top with two exactly equal moments"


def planned(**options: Any) -> Callable[[], rigid.Plan]:
    return lambda: rigid.plan(HEAVY, **{"question": "attitude", **options})


COST = "cost = True: some of the bodies are run, "

test_what_cannot_be_planned_is_refused = refuses(
    [
        (
            lambda: rigid.simulate(HEAVY, RATES, t=[1.0], method="exact"),
            [
                "method = 'exact': no closed form of rates and attitude",
                "for the heavy top, moments (1, 1.4, 0.7)",
                STATES_RULE,
            ],
        ),
        (
            lambda: rigid.simulate(
                HEAVY, [[0.0, 1.0, 0.0], [0.0, 2.0, 0.0], RATES], t=[1.0], method="exact"
            ),
            "for body 2 of the heavy top",
        ),
        (planned(method="rk5"), f"'rk5': did you mean 'rk4'? must be one of {LISTED}"),
        (planned(method="auto"), f"method = 'auto': must be one of {LISTED}"),
        (planned(step=0.0), "step = 0.0: must be positive"),
        (planned(t_end=-1.0), "t_end = -1.0: must be positive"),
        (planned(accuracy=0.0), "accuracy = 0.0: must be positive"),
        (planned(accuracy=np.nan), "accuracy = nan: must be finite"),
        (planned(accuracy=1e-6, step=0.1), "accuracy = 1e-06, step = 0.1: exclude each other"),
        (planned(accuracy=1e-6, t_end=1.0), "follows from the rates and the horizon; omega is"),
        (planned(accuracy=1e-6, omega=RATES), "t_end is missing"),
        (planned(accuracy=1e-15, omega=RATES, t_end=1.0), "1e-15: must be at least 6.0e-15"),
        (planned(attitude=[1, 0, 0, 0]), "attitude: says nothing without omega"),
        (planned(omega=[1, 2]), "omega: expected shape (..., 3)"),
        (planned(question="state"), "question = 'state': must be one of 'rates', 'axis', 'attitu"),
        (planned(question=3), TypeError, "question = 3: must be one of 'rates', 'axis', 'attitude"),
        (planned(acuracy=1e-3), TypeError, "unexpected keyword argument 'acuracy'"),
        (
            lambda: rigid.plan(3, "rates"),  # type: ignore[arg-type]
            TypeError,
            "must be a rigid.FreeBody or rigid.HeavyTop",
        ),
        (
            lambda: rigid.plan(FREE, rigid.tilt_below(0.5, reference="vertical"), t_end=1.0),
            "a free body knows no vertical",
        ),
        (planned(t_end=1.0, cost=True), f"{COST}for which omega is missing"),
        (planned(omega=RATES, cost=True), f"{COST}for which t_end is missing"),
        (planned(omega=np.empty((0, 3)), t_end=1.0, cost=True), f"{COST}and there are none"),
        (planned(question=rigid.no_flip(3), t_end=1.0, bodies=0), "bodies = 0: must be"),
    ],
    literal=True,
)


# The cost of a plan is measured on some of the bodies, in a given time. No test asserts a time.


PAIR = rigid.FreeBody(rigid.Body([[[1.0, 2.0, 3.0]], [[1.0, 1.5, 2.0]]]))


class Clock:
    """A clock that stands still but for what is said to take time (s)."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.now = 0.0
        monkeypatch.setattr(timing, "time", self)

    def process_time(self) -> float:
        return self.now


CALLS: dict[str, tuple[float, float, float, int]] = {
    "one in closed form": (3e-5, 1e-6, 0.0, 1),
    "many in closed form": (3e-5, 5e-7, 0.0, 10**7),
    "one by steps": (1e-3, 0.0, 1e-3, 1),
    "a thousand": (1e-3, 1e-6, 1e-5, 1000),
    "more than can be run": (1e-3, 1e-6, 1e-4, 10**6),
    "a long one": (1e-3, 0.0, 1e4, 1),
    "a thousand long ones": (1e-3, 1e-6, 1.0, 1000),
    "much before the first step": (1e-2, 2e-3, 1e-3, 1000),
    "a slow call": (1e-2, 1e-6, 1e-5, 1000),
}
"""Time of the call, of a body, and of the motion of a body, and bodies."""


@pytest.mark.parametrize("name", CALLS)
def test_the_time_of_a_body_is_found_in_a_given_time(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    call, body, motion, most = CALLS[name]
    clock, runs = Clock(monkeypatch), []

    def run(count: int, share: float) -> tuple[int, float]:
        runs.append((count, share))
        clock.now += call + count * (body + share * motion)
        return runs[-1]

    seconds, whole = timing.seconds_of_one(run, most)
    assert seconds == pytest.approx(call / most + body + motion, rel=0.25)
    assert clock.now <= timing.BUDGET
    assert max(count for count, _ in runs) <= most
    assert (whole is None) == (runs[-1][1] < 1.0)
    if whole is not None:
        assert whole[1] == 1.0


def test_no_more_bodies_are_run_than_the_time_allows(monkeypatch: pytest.MonkeyPatch) -> None:
    clock, runs = Clock(monkeypatch), []

    def slow(scene: Any, omega: Any, attitude: Any, *, t: Any, **asked: Any) -> rigid.Run:
        """Each body takes 1 ms for each second of its motion."""
        runs.append((len(omega), float(t[-1])))
        clock.now += 1e-3 * len(omega) * float(t[-1])
        return rigid.simulate(scene, omega, attitude, t=t, **asked)

    monkeypatch.setattr(planning, "simulate", slow)
    rows = np.tile(RATES, (2000, 1))
    plan = rigid.plan(HEAVY, omega=rows, t_end=1.0, times=3, cost=True)
    assert plan.cost == pytest.approx(1e6, rel=1e-5)
    assert sum(count * end for count, end in runs) <= 1e3 * timing.BUDGET
    assert max(count for count, _ in runs) == 512
    plan = rigid.plan(HEAVY, omega=rows[:9], t_end=1.0, cost=True)
    assert plan.cost == pytest.approx(1e6, rel=1e-5)
    assert runs[-1] == (9, 1.0)


STATES: dict[str, tuple[rigid.FreeBody | rigid.HeavyTop, dict[str, Any]]] = {
    "free body": (FREE, {"omega": RATES}),
    "top": (HEAVY, {"omega": RATES, "attitude": Rotation.from_rotvec([0.1, 0.2, 0.3])}),
    "one repeated": (HEAVY, {"omega": RATES, "bodies": 20}),
    "many": (HEAVY, {"omega": np.tile(RATES, (20, 1)), "times": 5, "accuracy": 1e-6}),
    "broadcast": (PAIR, {"omega": np.tile(RATES, (3, 1)), "attitude": np.eye(4)[0]}),
    "step": (HEAVY, {"omega": RATES, "method": "rk4", "step": 0.01}),
}


def test_times_are_known_where_the_time_of_the_process_is_limited() -> None:
    """Under a limit, as of a batch system, the clock of a process ticks 250 times a second."""
    pytest.importorskip("resource", reason="no limits of processes here")
    run_python(
        "-c",
        "import resource; _, hard = resource.getrlimit(resource.RLIMIT_CPU)\n"
        "most = 500 if hard == resource.RLIM_INFINITY else hard\n"
        "resource.setrlimit(resource.RLIMIT_CPU, (most, most)); import rigid\n"
        "body = rigid.Body((1.0, 2.0, 3.0))\n"
        "assert rigid.plan(body, omega=[0.1, 1.0, 0.2], t_end=100.0, cost=True).cost > 0.0\n"
        "still = rigid.scheme('still', lambda scene, t, omega, attitude, *_: (omega, attitude))\n"
        "report = rigid.report(body, omega=[0.0, 1.0, 0.0], t_end=1.0, methods=[still])\n"
        "assert {row.method for row in report.rows} == {'still'}",
    )


@pytest.mark.parametrize("name", STATES)
def test_only_a_cost_that_is_asked_for_is_measured(name: str) -> None:
    scene, asked = STATES[name]
    plan = rigid.plan(scene, "axis", t_end=1.0, **asked)
    assert plan.cost is None
    assert "cost" not in str(plan)
    timed: Any = rigid.plan(scene, "axis", t_end=1.0, cost=True, **asked)
    assert timed.cost > 0.0
    assert " a body\n" in str(timed)
    assert dataclasses.replace(timed, cost=None, error=plan.error) == plan
    assert 0.0 < timed.error < 1.0


@pytest.mark.parametrize(
    ("nanoseconds", "words"),
    [
        (999.0, "999 ns"),
        (1e3, "1 µs"),
        (2.5e4, "25 µs"),
        (1e6, "1 ms"),
        (1e9, "1 s"),
        (9e10, "90 s"),
    ],
)
def test_a_cost_is_told_in_the_largest_unit_that_it_reaches(nanoseconds: float, words: str) -> None:
    plan = rigid.plan(HEAVY, "axis", omega=RATES, t_end=1.0)
    assert f"cost        {words} a body\n" in f"{dataclasses.replace(plan, cost=nanoseconds)}\n"


def test_the_error_of_steps_is_that_of_the_bodies_that_were_run() -> None:
    rows = np.random.default_rng(1).normal(size=(10, 3))
    run = rigid.simulate(HEAVY, rows, t=[5.0], method="dop853")
    plan = rigid.plan(HEAVY, omega=rows, t_end=5.0, method="dop853", cost=True)
    assert plan.error == run.error.max()
    # Of many bodies by a method few are checked; the others have no error.
    plan = rigid.plan(HEAVY, omega=np.tile(rows, (5, 1)), t_end=5.0, method="dop853", cost=True)
    assert plan.error == pytest.approx(run.error.max(), rel=1e-6)
    coarse = rigid.plan(HEAVY, omega=rows, t_end=300.0, method="rk4", step=0.5, cost=True)
    assert coarse.error is None


def test_the_error_of_a_part_of_the_horizon_is_not_that_of_the_whole(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(timing, "BUDGET", 0.0)
    plan = rigid.plan(HEAVY, omega=RATES, t_end=10.0, cost=True)
    assert plan.error is None
    assert plan.cost is not None
