"""States at output times, any of them, and what becomes of bodies that cannot be run."""

from typing import Any

import numpy as np
import pytest

import rigid
from physics import METHODS, Floats, present, tilted
from processes import python_process
from rigid import Status, _core

BODY = rigid.Body((1.0, 1.5, 2.0))
FREE = rigid.FreeBody(BODY)
TOP = rigid.HeavyTop(BODY, mgl=3.0, com=(0.6, 0.0, 0.8))
RATES = [0.3, 1.0, 0.2]
each_method = pytest.mark.parametrize("method", METHODS, ids=lambda method: method.name)
each_scene = pytest.mark.parametrize("scene", [FREE, TOP], ids=["free", "top"])


def omega_at(t: object, method: str = "rk4", step: float | None = 0.01) -> Floats:
    return rigid.simulate(TOP, RATES, tilted(0.4), t=t, method=method, step=step).omega  # type: ignore[arg-type]


@each_method
def test_the_state_at_zero_is_the_start(method: rigid.Method) -> None:
    start = tilted(0.4)
    for scene in (FREE, TOP):
        run = rigid.simulate(scene, RATES, start, t=[0.0], method=method.name)
        assert run.steps == 0
        # Momenta and back: half a roundoff each.
        assert run.omega[0] == pytest.approx(RATES, rel=2.0**-52)
        assert present(run.attitude)[0] == pytest.approx(start, rel=2.0**-52)
        assert run.energy_drift == run.momentum_drift == 0.0
        run = rigid.simulate(scene, RATES, start, t=[-1.0, 0.0, 0.0, 1.0], method=method.name)
        assert run.omega[1].tobytes() == run.omega[2].tobytes()
        assert run.omega[1] == pytest.approx(RATES, rel=2.0**-52)


@pytest.mark.parametrize(
    "t",
    [[0.0], [1.0], [-1.0], [-2.0, -1.0], [0.0, 0.0], [-1.0, -1.0, 1.0, 1.0], [1e-12, 1.0], [-0.0]],
)
@each_method
def test_states_belong_to_their_times(method: rigid.Method, t: list[float]) -> None:
    run = rigid.simulate(TOP, RATES, tilted(0.4), t=t, method=method.name, step=1e-3)
    assert run.t.tolist() == t
    assert run.omega.shape == (len(t), 3)
    for time, omega in zip(t, run.omega, strict=True):
        # Alone at its time it was reached with other steps: the error of the method, 1e-3 squared.
        assert omega == pytest.approx(omega_at(time, method.name, 1e-3)[0], abs=1e-6)
    for first in range(len(t) - 1):
        if t[first] == t[first + 1]:
            assert run.omega[first].tobytes() == run.omega[first + 1].tobytes()


@each_method
def test_steps_end_exactly_on_output_times(method: rigid.Method) -> None:
    """Steps of 0.25 make the way to 1 in two legs as well as in one: the same bits."""
    legs = rigid.simulate(TOP, RATES, t=[0.5, 1.0], step=0.25, method=method.name)
    whole = rigid.simulate(TOP, RATES, t=[1.0], step=0.25, method=method.name)
    assert legs.steps == whole.steps == 4
    assert legs.omega[-1].tobytes() == whole.omega[-1].tobytes()
    # A time off the grid shortens the steps of its own leg only.
    odd = rigid.simulate(TOP, RATES, t=[0.6, 1.6], step=0.25, method=method.name)
    assert odd.steps == 3 + 4


@each_method
def test_equal_steps_no_longer_than_asked(method: rigid.Method) -> None:
    for span, step, steps in [(1.0, 0.1, 10), (1.0, 0.3, 4), (0.3, 0.1, 3), (7.0, 0.07, 100)]:
        assert rigid.simulate(TOP, RATES, t=span, step=step, method=method.name).steps == steps
        assert rigid.simulate(TOP, RATES, t=-span, step=step, method=method.name).steps == steps


@each_method
def test_a_step_longer_than_the_span_is_one_step_of_the_span(method: rigid.Method) -> None:
    long = rigid.simulate(TOP, RATES, t=0.1, step=1e6, method=method.name)
    fits = rigid.simulate(TOP, RATES, t=0.1, step=0.1, method=method.name)
    assert long.steps == fits.steps == 1
    assert long.omega.tobytes() == fits.omega.tobytes()


@each_method
def test_the_past_is_the_future_with_time_reversed(method: rigid.Method) -> None:
    """omega -> -omega and t -> -t is a symmetry of a free body, kept by each method to the bit."""
    past = rigid.simulate(FREE, RATES, t=[-2.0, -1.0], step=0.1, method=method.name)
    future = rigid.simulate(FREE, np.negative(RATES), t=[1.0, 2.0], step=0.1, method=method.name)
    assert np.array_equal(past.omega, -future.omega[::-1])
    assert np.array_equal(present(past.attitude), present(future.attitude)[::-1])


def test_a_single_time_is_one_time() -> None:
    assert omega_at(1.0).shape == (1, 3)
    assert omega_at(1).tobytes() == omega_at([1.0]).tobytes()
    assert rigid.simulate(TOP, [RATES] * 4, t=1.0).omega.shape == (4, 1, 3)


def test_no_times() -> None:
    run = rigid.simulate(TOP, [RATES] * 4, t=[])
    assert run.omega.shape == (4, 0, 3)
    assert run.status.tolist() == [rigid.Status.FINISHED] * 4
    assert run.steps.tolist() == [0] * 4
    assert present(run.attitude).shape == (4, 0, 4)
    assert present(run.gamma).shape == (4, 0, 3)
    own = rigid.simulate(FREE, np.ones((3, 3)), t=np.zeros((3, 0)))
    assert own.omega.shape == (3, 0, 3)
    assert own.status.tolist() == [rigid.Status.FINISHED] * 3


@pytest.mark.parametrize("record", ["rates", "axis", "attitude"])
@each_scene
def test_no_bodies(scene: rigid.FreeBody | rigid.HeavyTop, record: str) -> None:
    """An empty batch has the shape of any other batch, with no rows."""
    empties: list[Any] = [[], np.empty((0, 3)), np.empty((0, 3), dtype=int)]
    for nothing in empties:
        run = rigid.simulate(scene, nothing, t=[0.0, 1.0], record=record)
        assert run.omega.shape == (0, 2, 3)
        assert run.status.shape == run.steps.shape == run.energy_drift.shape == (0,)
        if record == "attitude":
            assert present(run.attitude).shape == (0, 2, 4)
            assert run.rotation().shape == (0, 2)
        if record == "axis":
            assert present(run.gamma).shape == (0, 2, 3)


@each_method
def test_a_body_over_the_limit_is_not_run_and_harms_no_neighbour(method: rigid.Method) -> None:
    """The default step follows the rates: the fast body needs too many."""
    omega = np.array([[0.3, 1.0, 0.2], [3e3, 1e4, 2e3], [0.1, 0.2, 0.3]])
    options: dict[str, Any] = {"t": [-1.0, 0.0, 1.0], "method": method.name}
    run = rigid.simulate(TOP, omega, max_steps=1000, **options)
    free = rigid.simulate(TOP, omega[[0, 2]], **options)
    assert run.status.tolist() == [0, 2, 0]
    assert rigid.Status(run.status[1]) is rigid.Status.STEP_LIMIT
    for name in ("omega", "gamma", "attitude", "energy_drift", "momentum_drift", "unit_drift"):
        values = getattr(run, name)
        assert np.all(np.isnan(values[1])), name
        assert values[[0, 2]].tobytes() == getattr(free, name).tobytes(), name
    assert run.steps[1] == 0


def test_the_limit_counts_all_steps_forward_and_backward() -> None:
    options: dict[str, Any] = {"t": [-1.0, 1.0], "step": 0.1}
    assert rigid.simulate(TOP, RATES, max_steps=20, **options).status == rigid.Status.FINISHED
    assert rigid.simulate(TOP, RATES, max_steps=19, **options).status == rigid.Status.STEP_LIMIT


def test_a_billion_steps_is_the_limit_by_default() -> None:
    run = rigid.simulate(TOP, RATES, t=1.0, step=0.9999e-9)
    assert run.status == rigid.Status.STEP_LIMIT
    assert np.all(np.isnan(run.omega))


def test_more_steps_than_can_be_counted_are_over_the_limit() -> None:
    """A leg of 1e21 steps and another of a few: their number must not wrap around to a few.

    In a process of its own, since a wrapped number of steps would run for ages.
    """
    code = (
        "import rigid; print(rigid.simulate(rigid.FreeBody(rigid.Body((1, 2, 3))), [1, 2, 3],"
        " t=[1.0, 1.0 + 2**-52], step=1e-21).status)"
    )
    assert python_process(code).stdout.strip() == "2"


@each_scene
def test_a_step_far_too_long_overflows_and_says_so(scene: rigid.FreeBody | rigid.HeavyTop) -> None:
    omega = np.array([[1.0, 20.0, 3.0], [1e-3, 2e-3, 1e-3]])
    run = rigid.simulate(scene, omega, t=[0.0, 1e3], step=10.0)
    assert rigid.Status(run.status[0]) is rigid.Status.NOT_FINITE
    assert not np.all(np.isfinite(run.omega[0]))
    assert run.omega[0, 0] == pytest.approx(omega[0])
    assert np.isnan(run.energy_drift[0]) or np.isinf(run.energy_drift[0])
    # The slow free body is content with such a step.
    if scene is FREE:
        assert run.status[1] == rigid.Status.FINISHED
        assert np.all(np.isfinite(run.omega[1]))


@each_scene
def test_rotations_do_not_overflow_but_the_drift_tells(
    scene: rigid.FreeBody | rigid.HeavyTop,
) -> None:
    run = rigid.simulate(scene, [1.0, 20.0, 3.0], t=[0.0, 1e3], step=10.0, method="splitting")
    assert np.all(np.isfinite(run.omega))
    assert run.energy_drift > 0.01
    # From a tenth on the motion is called what it is.
    drifted = max(run.energy_drift, run.momentum_drift) > 0.1
    assert run.status == (rigid.Status.DRIFTED if drifted else rigid.Status.FLAGGED)


def test_lost_energy_is_a_status_and_harms_no_neighbour() -> None:
    omega = np.array([[0.1, 0.2, 0.1], [1.0, 8.0, 3.0]])
    options: dict[str, Any] = {"t": [0.0, 5.0], "step": 0.5}
    run = rigid.simulate(FREE, omega, **options)
    assert run.status.tolist() == [rigid.Status.FINISHED, rigid.Status.DRIFTED]
    assert run.energy_drift[0] < 1e-6
    assert max(run.energy_drift[1], run.momentum_drift[1]) > 0.1
    alone = rigid.simulate(FREE, omega[0], **options)
    assert run.omega[0].tobytes() == alone.omega.tobytes()


@pytest.mark.parametrize("record", ["axis", "attitude"])
def test_an_overflow_of_the_attitude_alone_is_noticed(record: str) -> None:
    """The rates of a sphere are constant, whatever the step: only the attitude overflows."""
    sphere = rigid.FreeBody(rigid.Body((1.0, 1.0, 1.0)))
    run = rigid.simulate(sphere, [0.0, 0.0, 1000.0], tilted(0.4), t=150.0, step=1.0, record=record)
    carried = present(run.gamma if record == "axis" else run.attitude)
    assert not np.all(np.isfinite(carried))
    assert rigid.Status(int(run.status)) is rigid.Status.NOT_FINITE


@each_method
def test_the_default_step_turns_by_the_angle_of_the_method(method: rigid.Method) -> None:
    """A body turning about a principal axis has its bound reached: 16 steps a radian by rk4."""
    steps = np.ceil(40.0 / method.angle_per_step)
    for axis in range(3):
        omega = [0.0, 0.0, 0.0]
        omega[axis] = 4.0
        run = rigid.simulate(FREE, omega, t=10.0, method=method.name)
        # Kinetic energy bounds the rate about the smallest moment by up to sqrt(I_max / I_min).
        assert steps <= run.steps <= np.ceil(steps * np.sqrt(sum(2.0 / m for m in BODY.moments)))


@each_scene
def test_a_body_at_rest(scene: rigid.FreeBody | rigid.HeavyTop) -> None:
    run = rigid.simulate(scene, [0.0, 0.0, 0.0], t=[0.0, 1.0, 1000.0])
    assert run.status == rigid.Status.FINISHED
    assert run.momentum_drift < 1e-6
    if scene is FREE:
        assert np.array_equal(run.omega, np.zeros((3, 3)))
        assert np.array_equal(present(run.attitude), [[1.0, 0.0, 0.0, 0.0]] * 3)
    else:
        assert np.abs(run.omega[1]).max() > 0.1


def test_an_attitude_that_lost_its_length_is_not_believed() -> None:
    sphere = rigid.FreeBody(rigid.Body((1.0, 1.0, 1.0)))
    run = rigid.simulate(sphere, [1.0, 0.0, 0.0], t=[0.0, 100.0], step=2.0)
    assert run.energy_drift == run.momentum_drift == 0.0
    assert run.unit_drift > 0.1
    assert run.status == rigid.Status.DRIFTED


def test_rates_whose_squares_would_vanish_are_refused() -> None:
    """Their energies underflow, and drift could not be told; another unit of time loses nothing."""
    body = rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0)))
    with pytest.raises(ValueError, match="count the time in another unit"):
        rigid.simulate(body, [1e-162, 1e-162, 2e-162], t=[0.0, 1e163], step=3e162)


# The status of a body: one list of codes, that of the core


def test_codes_are_those_of_the_core() -> None:
    """Python adds the codes of an error estimate, which the core does not make."""
    core = {name.upper().replace(" ", "_"): code for code, name in enumerate(_core.status_names())}
    python = {name: int(status) for name, status in Status.__members__.items()}
    assert core.items() <= python.items()
    assert python.keys() - core.keys() == {"OK", "FLAGGED", "UNCHECKED", "COARSE"}
    assert Status["OK"] is Status["FINISHED"]
