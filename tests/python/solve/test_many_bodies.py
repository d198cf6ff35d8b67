"""Many bodies in one call: each moves as if it were alone, to the bit."""

import json
import pickle
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import doors
import rigid
from physics import ROUNDOFF
from refusals import refuses
from rigid import exact, figures
from rigid.model.parameters import AT_REST, PLACES, numbers_of
from rigid.model.scene import Scene, scene_from_dict

COUNT = 37  # more than a group of 32, which it does not fill
T = np.array([-1.0, -0.3, 0.0, 0.4, 1.7])
MOMENTS, SIZE, SHARES = doors.MOMENTS[:COUNT], doors.SIZE[:COUNT], doors.SHARES[:COUNT]
OMEGA, ATTITUDE, AXES = doors.OMEGA[:COUNT], doors.ATTITUDE[:COUNT], doors.AXES[:COUNT]
DAMPING = np.where(doors.SOME[:COUNT], SHARES * SIZE, 0.0)
"""Every third body is not damped."""

BODY = rigid.Body(MOMENTS)
FREE = rigid.FreeBody(BODY)
TOPS = rigid.HeavyTop(BODY, mgl=SHARES * SIZE, com=AXES)
DAMPED = rigid.FreeBody(BODY, damping=DAMPING)
DRIVEN = doors.SCENES["driven tops"](1.0, 1.0)[:COUNT]
EVENLY = rigid.FreeBody(
    BODY, damping=(DAMPING / SIZE)[:, None, None] * MOMENTS[:, None] * np.eye(3)
)


def assert_alone(run: rigid.Run, one: rigid.Run, body: int, names: tuple[str, ...]) -> None:
    """Body number ``body`` of a run has the bits of a run of its own."""
    for name in names:
        together, alone = getattr(run, name), getattr(one, name)
        if alone is None and name == "work":
            assert together is None or not together[body].any()
        elif alone is None:
            assert together is None
        else:
            assert together[body].tobytes() == np.asarray(alone).tobytes(), (name, body)


OWN_T = np.sort(np.random.default_rng(9).uniform(-2.0, 2.0, (COUNT, 6)), axis=1)
OWN_T[3] = [-1.0, -1.0, 0.0, 0.0, 0.5, 0.5]
OWN_T[4] = np.abs(OWN_T[4])[np.argsort(np.abs(OWN_T[4]))]
OWN_T[5] = -OWN_T[4, ::-1]


def test_times_of_each_body_broadcast() -> None:
    few = rigid.simulate(FREE[0], OMEGA[0], t=OWN_T[:4])
    assert few.omega.shape == (4, 6, 3)
    assert rigid.simulate(FREE[:2], OMEGA[:2], t=OWN_T[:3, None]).omega.shape == (3, 2, 6, 3)
    many = rigid.simulate(TOPS, OMEGA, ATTITUDE, t=OWN_T, method="rk4")
    assert np.isfinite(many.error).all()
    alone = rigid.simulate(TOPS[0], OMEGA[0], ATTITUDE[0], t=OWN_T[0], method="rk4")
    assert (many.error[0], many.reasons()[0]) == (alone.error, alone.reasons()[0])
    lost = rigid.simulate(TOPS, 30.0 * OMEGA, ATTITUDE, t=OWN_T, method="rk4", step=0.1)
    assert np.array_equal(np.isnan(lost.error), lost.status == rigid.Status.NOT_FINITE)


def test_axes_broadcast_as_numpy_does() -> None:
    omega = np.random.default_rng(2).normal(size=(5, 4, 3))
    scene = rigid.FreeBody(rigid.Body(MOMENTS[:4]))
    run: Any = rigid.simulate(scene, omega, [1.0, 0.0, 0.0, 0.0], t=T)
    assert run.omega.shape == (5, 4, len(T), 3)
    assert run.attitude.shape == (5, 4, len(T), 4)
    assert run.status.shape == run.error.shape == run.lost_from.shape == (5, 4)
    assert run.energy().shape == (5, 4, len(T))
    reasons = run.reasons()
    assert len(reasons) == 5
    assert all(row == ("ok",) * 4 for row in reasons)
    one = rigid.simulate(scene[2], omega[3, 2], t=T)
    assert run.omega[3, 2].tobytes() == one.omega.tobytes()
    assert np.array_equal(run.energy()[3, 2], one.energy())
    assert rigid.condition(scene, omega, t=[1.0]).shape == (5, 4, 1)
    outer = rigid.FreeBody(rigid.Body(MOMENTS[:2, None]))
    assert rigid.simulate(outer, OMEGA[:3], t=[1.0]).omega.shape == (2, 3, 1, 3)
    assert rigid.simulate(FREE[0], np.zeros((2, 0, 3)), t=[1.0]).omega.shape == (2, 0, 1, 3)


def test_arrays_of_the_user_have_the_axes_of_the_bodies() -> None:
    """Driven and free bodies of one call are computed apart; both are written where they belong."""
    omega = np.broadcast_to(OMEGA[:4], (5, 4, 3))
    scene = DAMPED[:4]
    filled = {"omega": np.empty((5, 4, len(T), 3)), "work": np.empty((5, 4, len(T)))}
    run = rigid.simulate(scene, omega, t=T, method="rk4", out=filled)
    plain: Any = rigid.simulate(scene, omega, t=T, method="rk4")
    assert np.shares_memory(run.omega, filled["omega"])
    assert filled["omega"].tobytes() == plain.omega.tobytes()
    assert filled["work"].tobytes() == plain.work.tobytes()


def test_a_sweep_of_one_number_makes_many_bodies() -> None:
    one = rigid.Body((1.0, 1.2, 1.5))
    assert len(rigid.HeavyTop(one, mgl=[0.1, 0.2])) == 2
    assert len(rigid.HeavyTop(one, mgl=1.0, com=AXES)) == COUNT
    assert len(rigid.FreeBody(one, damping=[0.1, 0.2, 0.3, 0.4])) == 4
    assert rigid.FreeBody(one, damping=np.ones((5, 3))).shape == (5,)
    assert rigid.FreeBody(one, torque=rigid.Torque.body(np.ones((6, 3)))).shape == (6,)
    assert rigid.FreeBody(one, damping=[0.1, 0.2, 0.3]).shape == ()  # one for each axis


def test_a_body_of_many_tells_the_shape_of_their_moments() -> None:
    body = rigid.Body(np.ones((2, 5, 3)), physical=False)
    assert repr(body) == "Body(moments of shape (2, 5, 3), physical=False)"


def test_a_scene_is_indexed_like_an_array() -> None:
    assert [len(DRIVEN), len(BODY)] == [COUNT, COUNT]
    assert DRIVEN[3].body.moments == tuple(MOMENTS[3])
    assert DRIVEN[3].shape == BODY[3].shape == ()
    assert DRIVEN[-1] == DRIVEN[COUNT - 1] != DRIVEN[0]
    assert DRIVEN[4:9][2] == DRIVEN[6] == DRIVEN[np.array([1, 6])][1]
    assert len(list(DRIVEN)) == COUNT
    pairs = rigid.FreeBody(
        rigid.Body(MOMENTS[:6].reshape(2, 3, 3)), damping=np.full((1, 1, 3), 0.1)
    )
    assert pairs[1].shape == (3,)
    assert pairs[1, 2] == rigid.FreeBody(rigid.Body(MOMENTS[5]), damping=0.1)
    assert pairs[:, 0][1] == pairs[1, 0] == pairs[..., 0][1]
    masses = rigid.Body(MOMENTS[:2], mass=[1.0, 2.0])
    assert (masses[1].mass, rigid.FreeBody(masses)[0].body.mass) == (2.0, 1.0)
    with pytest.raises(IndexError):
        DRIVEN[COUNT]
    with pytest.raises(IndexError):
        DRIVEN[0, 0]
    for single in (DRIVEN[0], BODY[0]):
        with pytest.raises(TypeError, match="one body has no length"):
            len(single)
        with pytest.raises(TypeError, match="one body has no length"):
            single[0]


def test_parts_of_bodies_by_an_index_with_an_ellipsis_are_whole() -> None:
    body = rigid.Body(
        np.broadcast_to(MOMENTS[:2], (3, 2, 3)), mass=np.arange(1.0, 7.0).reshape(3, 2)
    )
    for index in (1, (1, 0), (..., 1), (1, ...), (slice(None), 1), np.array([True, False, True])):
        places = np.arange(6).reshape(3, 2)[index]
        np.testing.assert_array_equal(body[index].moments, MOMENTS[places % 2])
        np.testing.assert_array_equal(body[index].mass, 1.0 + places)


@pytest.mark.parametrize("scene", [FREE, TOPS, DAMPED, DRIVEN, EVENLY, DRIVEN[0], DRIVEN[:3]])
def test_scenes_of_many_bodies_are_saved_and_compared(scene: Scene) -> None:
    again = scene_from_dict(json.loads(json.dumps(scene.to_dict())))
    assert again == scene
    assert hash(again) == hash(scene)
    assert pickle.loads(pickle.dumps(scene)) == scene
    assert scene != FREE[:2]
    assert len(repr(scene)) < 2000


def test_one_damping_of_three_bodies_is_read_back_as_one() -> None:
    three = rigid.FreeBody(rigid.Body(MOMENTS[:3]), damping=[[1.0, 2.0, 3.0]])
    assert scene_from_dict(three.to_dict()) == three
    assert three[1:][0] == rigid.FreeBody(rigid.Body(MOMENTS[1]), damping=(1.0, 2.0, 3.0))


def test_arrays_of_a_body_are_its_own() -> None:
    moments = MOMENTS.copy()
    body = rigid.Body(moments)
    moments[0] = 0.0
    assert body == BODY
    with pytest.raises(ValueError, match="read-only"):
        body.moments[0] = 1.0  # type: ignore[index]


def test_torques_of_bodies_add() -> None:
    both = rigid.Torque.body(AXES) + rigid.Torque.space((0.0, 0.0, 1.0))
    assert both.shape == (COUNT,)
    body, space = both.at([0.0, 1.0])
    assert np.array_equal(body, np.broadcast_to(AXES[:, None], (COUNT, 2, 3)))
    assert np.array_equal(space, np.broadcast_to([0.0, 0.0, 1.0], (COUNT, 2, 3)))
    assert rigid.Torque.from_dict(json.loads(json.dumps(both.to_dict()))) == both


def test_closed_form_quantities_of_bodies_that_differ() -> None:
    motion = exact.free_body(BODY, OMEGA)
    flips = exact.flip_times(FREE, OMEGA, count=2)
    tops = rigid.HeavyTop(rigid.Body(MOMENTS[::5]), mgl=SIZE[::5] * SHARES[::5])
    starts = OMEGA[::5], ATTITUDE[::5]
    nutation = exact.lagrange_top(tops, *starts)
    reached = exact.tilt_time(tops, *starts, limit=1.0)
    slow, _ = exact.steady_precession(tops, 0.5, 100.0)
    swings = exact.pendulum_period(tops, [[0.1], [0.2]], axis=1)
    assert swings.shape == (2, len(tops))
    for body in range(COUNT):
        one = exact.free_body(BODY[body], OMEGA[body])
        assert motion.period[body] == one.period
        assert np.array_equal(motion.amplitude[body], one.amplitude)
        assert np.array_equal(flips[body], exact.flip_times(FREE[body], OMEGA[body], count=2))
    for body, (omega, attitude) in enumerate(zip(*starts, strict=True)):
        one_top = exact.lagrange_top(tops[body], omega, attitude)
        assert (nutation.kind[body], nutation.period[body]) == (one_top.kind, one_top.period)
        assert reached[body] == exact.tilt_time(tops[body], omega, attitude, limit=1.0)
        assert slow[body] == exact.steady_precession(tops[body], 0.5, 100.0).slow
        assert swings[1, body] == exact.pendulum_period(tops[body], 0.2, axis=1)
        assert exact.sleeping_spin(tops)[body] == exact.sleeping_spin(tops[body])  # type: ignore[index]
    square = exact.lagrange_top(tops[:4], np.broadcast_to(starts[0][:4], (2, 4, 3)))
    assert len(square.kind) == 2
    assert square.tilt_max.shape == (2, 4)


def test_the_condition_of_a_body_among_others() -> None:
    together = rigid.condition(TOPS, OMEGA, ATTITUDE, t=[0.5, 1.0])
    # By closed form alone and by steps among others: four digits are right.
    for body in (0, 1, 7):
        alone = rigid.condition(TOPS[body], OMEGA[body], ATTITUDE[body], t=[0.5, 1.0])
        np.testing.assert_allclose(together[body], alone, rtol=1e-3)


def test_the_plan_of_many_bodies_covers_the_slowest() -> None:
    plan, *alone = (
        rigid.plan(TOPS[k], omega=OMEGA[k], attitude=ATTITUDE[k], t_end=2.0, method="rk4")
        for k in (slice(None), *range(COUNT))
    )
    assert plan.step == min(one.step for one in alone if one.step)
    assert plan.steps == max(one.steps for one in alone if one.steps)
    assert rigid.plan(FREE, "rates").method == "exact"
    assert rigid.plan(TOPS, "attitude").method != "exact"


UPRIGHT, TUMBLING = [1.0, 1e-9, 0.0, 0.0], [0.8, 0.6, 0.0, 0.0]
HARD = (
    rigid.HeavyTop(
        rigid.Body([[1.0, 1.0, 0.5], [1.0, 1.0, 0.5], [0.8, 1.0, 1.3], [1.0, 1.2, 0.7]]),
        mgl=[1.0, 0.0, 0.0, 1.0],
    ),
    [[0.0] * 3, [0.3, 0.1, 2.0], [1e-4, 1.0, 1e-4], [0.0] * 3],
    [UPRIGHT, TUMBLING, TUMBLING, UPRIGHT],
)
"""A saddle, a symmetric free body, a separatrix, and an equilibrium that is no closed form."""


@pytest.mark.parametrize("method", ["exact", "splitting8", "rk4", "taylor16"])
def test_the_error_of_a_body_among_others_is_its_own(method: str) -> None:
    """Free bodies among tops, beside saddles or not."""
    scene, omega, attitude = HARD
    bodies = [0, 1, 2] if method == "exact" else [0, 1, 2, 3]
    t = [-1.0, 3.0, 30.0]
    rows = np.array(omega)[bodies], np.array(attitude)[bodies]
    run = rigid.simulate(scene[bodies], *rows, t=t, method=method)
    for k in bodies:
        one = rigid.simulate(scene[k], omega[k], attitude[k], t=t, method=method)
        assert_alone(run, one, k, ("error", "lost_from", "status"))


@pytest.mark.parametrize("method", [None, "taylor16"])
def test_bodies_at_the_step_limit_leave_the_errors_of_others_as_they_are(
    method: str | None,
) -> None:
    top = rigid.HeavyTop(rigid.Body((1.0, 1.6, 0.7)), mgl=1.2, com=(0.6, 0.0, 0.8))
    omega = np.random.default_rng(3).normal(size=(9, 3))
    omega[::3] *= 1e4
    how: dict[str, Any] = {"t": [100.0], "max_steps": 3000, "method": method}
    together = rigid.simulate(top, omega, **how)
    assert list(np.isnan(together.error)) == [True, False, False] * 3
    assert together.error[1] > 1e-5  # chaos: it is run again, for its rounding
    alone = [rigid.simulate(top, rates, **how).error for rates in omega]
    np.testing.assert_array_equal(together.error, alone)


def test_rows_are_bodies_unless_every_body_would_be_a_tensor() -> None:
    """Ones are three spheres, and as a tensor they would have two moments of zero."""
    assert rigid.Body([TENSOR, np.ones((3, 3))]).shape == (2, 3)


ONE = rigid.Body((1.0, 1.2, 1.5))
EYE = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
TENSOR = np.ones((3, 3)) + np.eye(3)
BAD = MOMENTS / SIZE[:, None]
BAD[17] = (1.0, 1.0, 2.5)


def by_rk4(scene: Scene, **options: Any) -> Callable[[], object]:
    return lambda: rigid.simulate(scene, OMEGA[0], t=[1.0], method="rk4", **options)


REFUSED: list[tuple[Any, ...]] = [
    (lambda: rigid.Body(BAD), "moments[17] = (1, 1, 2.5): no moment may exceed"),
    (
        lambda: rigid.Body(BAD.reshape(1, COUNT, 3)),
        "moments[0, 17] = (1, 1, 2.5): no moment may exceed",
    ),
    (lambda: rigid.Body([[1, 1, np.nan]]), "moments[0] = (1, 1, NaN): "),
    (lambda: rigid.Body([TENSOR, TENSOR]), "take rigid.Body.from_tensor"),
    (lambda: rigid.Body([np.zeros((3, 3)), TENSOR]), "moments[0, 0] = (0, 0, 0)"),
    # Neither a body: a determinant of zero, and two negative moments.
    (lambda: rigid.Body([[1, 0, 0.5], [0, 1, 0.5], [0.5, 0.5, 0.5]]), "moments[0] = ("),
    (lambda: rigid.Body(np.diag([-1.0, -1.0, 1.0])), "moments[0] = ("),
    (lambda: rigid.Body(MOMENTS, mass=[1.0, 2.0]), "moments (37,), mass (2,): "),
    (lambda: rigid.Body((1, 1, 1), mass=[1.0]), "mass: expected shape () or (), got"),
    (lambda: rigid.Body(MOMENTS[:1], sides=(1, 1, 1)), "sides: belong to one body"),
    (lambda: rigid.HeavyTop(ONE, mgl=[1.0, -2.0]), "mgl[1] = -2.0: must not be neg"),
    (
        lambda: rigid.HeavyTop(ONE, mgl=1.0, com=[[0, 0, 1], [0, 0, 2]]),
        "com[1] = [0.0, 0.0, 2.0]: must be a unit vector to 0.0001, its length is 2",
    ),
    (
        lambda: rigid.HeavyTop(rigid.Body(MOMENTS[:4]), mgl=np.ones(5)),
        "moments (4,), mgl (5,): the axes of the bodies do not broadcast",
    ),
    (
        lambda: rigid.FreeBody(BODY, damping=np.where(np.arange(COUNT) == 7, -1.0, 1.0)),
        "damping[7] = -1.0: must not be negative",
    ),
    (
        lambda: rigid.FreeBody(ONE, damping=[EYE, [[1, 2, 0], [2, 1, 0], [0, 0, 1]]]),
        "damping[1] = [[1.0, 2.0, 0.0], [2.0, 1.0, 0.0], [0.0, 0.0, 1.0]]: must be positive semi",
    ),
    (
        lambda: rigid.FreeBody(ONE, damping=[EYE, [[1, 1, 0], [0, 1, 0], [0, 0, 1]]]),
        "damping[1] = [[1.0, 1.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]: must be a symmetric",
    ),
    (
        lambda: rigid.FreeBody(rigid.Body(MOMENTS[:3]), damping=[1.0, 2.0, 3.0]),
        "damping: shape (3,) can be read in two ways for bodies of shape (3,); write (3, 3, 3) for "
        "a matrix of each, (1, 3) for three ",
    ),
    (
        lambda: rigid.FreeBody(rigid.Body(MOMENTS[:4]), damping=np.ones(5)),
        "damping: expected shape (), (3,) or (3, 3) after the axes (4,) of the bodies, got (5,)",
    ),
    (
        lambda: rigid.Torque.body(np.ones((4, 3))) + rigid.Torque.space(np.ones((5, 3))),
        "torque (4,), other torque (5,): the axes of the bodies do not broadcast",
    ),
    (
        lambda: rigid.simulate(FREE, OMEGA[:3], t=[1.0]),
        "scene (37,), omega (3,): the axes of the bodies do not broadcast",
    ),
    (
        lambda: rigid.simulate(
            FREE, np.where(np.arange(COUNT) == 9, 1e-200, 1.0)[:, None] * OMEGA, t=1
        ),
        "omega[9]: the rates of the body are",
    ),
    (
        by_rk4(
            rigid.HeavyTop(rigid.Body((1e-3, 1e-3, 1e-3)), mgl=[1.0, 1e308], com=(0.6, 0.0, 0.8))
        ),
        "mgl[1] = 1e+308: must be below 1e+153 times the least moment, 0.001",
    ),
    (
        by_rk4(rigid.FreeBody(ONE, damping=[1.0, 1e4, 1.0, 1.0]), step=0.1),
        "step = 1e-1 of body 1: 'rk4' is unstable",
    ),
    (
        lambda: rigid.simulate(
            FREE, OMEGA, t=np.where(np.arange(COUNT)[:, None] == 5, [2, 1], [1, 2])
        ),
        "t[5, 0] = 2.0 > t[5, 1] = 1.0: times must be ascending",
    ),
    (
        lambda: rigid.simulate(FREE, OMEGA, t=np.ones((4, 2))),
        "scene (37,), omega (37,), t (4,): the axes of the bodies do not broadcast",
    ),
    (lambda: rigid.condition(FREE, OMEGA, t=OWN_T), "t: expected shape (m,), got (37, 6)"),
    (
        lambda: rigid.simulate_chunks(FREE, OMEGA[:, None], t=[1.0]),
        "omega: expected one axis of bodies, got bodies of shape (37, 37)",
    ),
    (
        lambda: rigid.simulate(TOPS, OMEGA, t=[1.0], method="exact"),
        "method = 'exact': no closed form of rates and attitude at output times for body 1 of the",
    ),
    (
        lambda: exact.lagrange_top(rigid.HeavyTop(rigid.Body(MOMENTS[:2]), mgl=1.0), OMEGA[0]),
        "moments[1] = ",
    ),
    (
        lambda: exact.sleeping_spin(rigid.HeavyTop(rigid.Body((1, 1, 0.5)), mgl=[1.0, 0.0])),
        "mgl[1] = 0: a top without weight is a free body; use exact.free_body",
    ),
    (
        lambda: exact.pendulum_period(rigid.HeavyTop(ONE, mgl=[1.0, 0.0]), 0.1, axis=1),
        "mgl[1] = 0, com[1] = (0.0, 0.0, 1.0): a pendulum about axis 1 needs a weight",
    ),
    *(
        (call, "scene: expected one body, got bodies of shape (37,); take one of them, scene[0]")
        for call in (
            lambda: rigid.plan(FREE, rigid.no_flip(), t_end=1.0),
            lambda: rigid.report(FREE, OMEGA[0], t_end=1.0),
            lambda: figures.upright_cubic(TOPS),
            lambda: figures.cycloids(TOPS, 1.0, 40.0),
        )
    ),
    (
        lambda: rigid.particles.propagate_body(
            BODY, np.zeros(3), np.zeros(3), OMEGA, force=np.zeros(3), t=[1.0]
        ),
        "body: expected one body, got bodies of shape (37,)",
    ),
    (
        lambda: rigid.free.power_balance(rigid.simulate(FREE, OMEGA, t=OWN_T)),
        "t[3, 0] = -1.0: is given twice; the rate of the kinetic energy needs distinct times",
    ),
    (
        lambda: rigid.free.power_balance(FREE, OMEGA[:4, None] * np.ones((3, 1)), t=T[:3]),
        "scene (37,), omega (4,): the axes of the bodies do not broadcast",
    ),
    (
        lambda: rigid.free.invariants(TOPS, OMEGA[:3], ATTITUDE),
        "omega (3,), attitude (37,): the axes of the bodies do not broadcast",
    ),
    (lambda: BODY.symmetry_axis, "body: expected one body, got bodies of shape (37,)"),
]

test_the_bad_one_is_named = refuses(REFUSED, literal=True)


def test_the_textbook_of_bodies_that_differ() -> None:
    run = rigid.simulate(TOPS, OMEGA, ATTITUDE, t=T, method="rk4")
    kept = rigid.free.invariants(run)
    crossings = rigid.free.crossings(BODY, OMEGA, count=2)
    assert crossings.shape == (COUNT, 3, 2)
    for body in (0, 1, 36):
        one = rigid.simulate(TOPS[body], OMEGA[body], ATTITUDE[body], t=T, method="rk4")
        alone = rigid.free.invariants(one)
        assert np.array_equal(kept.kinetic[body], alone.kinetic)
        # The sum of three products in another order.
        np.testing.assert_allclose(kept.energy[body], alone.energy, rtol=4 * ROUNDOFF)
        np.testing.assert_allclose(run.energy()[body], one.energy(), rtol=4 * ROUNDOFF)
        assert np.array_equal(
            crossings[body], rigid.free.crossings(BODY[body], OMEGA[body], count=2)
        )
    assert rigid.free.invariants(TOPS, OMEGA, ATTITUDE).energy.shape == (COUNT,)
    assert rigid.free.gammas(BODY).shape == (COUNT, 3)


def test_an_animation_shows_one_of_many_bodies(tmp_path: Any) -> None:
    # No body turns by half a turn between two frames.
    times = np.linspace(-1.0, 1.7, 10)
    run = rigid.simulate(FREE, OMEGA, ATTITUDE, t=times)
    one = rigid.simulate(FREE[5], OMEGA[5], ATTITUDE[5], t=times)
    pages = [tmp_path / name for name in ("many.html", "one.html")]
    run.animate(pages[0], body=5)
    one.animate(pages[1])
    assert pages[0].read_text() == pages[1].read_text()
    square = rigid.simulate(FREE[:2], np.ones((3, 2, 3)), t=T)
    with pytest.raises(ValueError, match=r"needs one axis of bodies, \(n, m, 3\)"):
        square.animate(pages[0], body=0)
    apart = rigid.simulate(FREE, OMEGA, t=OWN_T)
    with pytest.raises(ValueError, match=r"t of shape \(37, 6\): needs times that all bodies"):
        apart.animate(pages[0], body=0)


DISTINCT_T = np.where(np.arange(COUNT)[:, None] == 3, np.linspace(-1.0, 1.5, 6), OWN_T)


@pytest.mark.parametrize("t", [DISTINCT_T[3], DISTINCT_T], ids=["of all", "of each"])
def test_power_and_energy_of_bodies_that_differ(t: Any) -> None:
    run = rigid.simulate(DRIVEN, OMEGA, ATTITUDE, t=t, method="rk4", step=0.01)
    extra = 0.1 * SIZE[:, None, None] * OMEGA[:, None]

    def both(run: rigid.Run, scene: Scene, t: Any, torque: Any) -> list[rigid.free.PowerBalance]:
        of_run = rigid.free.power_balance(run, torque=torque, frame="space")
        states = scene, run.omega, run.attitude
        return [of_run, rigid.free.power_balance(*states, t=t, torque=torque, frame="space")]

    found = both(run, DRIVEN, t, extra)
    assert found[0].rate.shape == (COUNT, 6)
    for body in range(COUNT):
        own, scene = t[body] if t.ndim > 1 else t, DRIVEN[body]
        one = rigid.simulate(scene, OMEGA[body], ATTITUDE[body], t=own, method="rk4", step=0.01)
        # The vertical of a run is that of its attitude to the error of its steps only.
        alone = both(one, scene, own, extra[body])
        # The products with the matrix of the damping may be added in another order; the power of
        # each component is some 100 W per unit of the moments.
        rounding = 400 * ROUNDOFF * SIZE[body]
        for name in ("power", "rate", "residual"):
            for many, single in zip(found, alone, strict=True):
                apart = getattr(many, name)[body] - getattr(single, name)
                assert np.abs(apart).max() <= rounding


def test_power_of_a_sweep_has_the_axes_of_the_bodies() -> None:
    t = np.linspace(0.0, 1.0, 5)
    omega = np.broadcast_to([0.1, 0.2, 3.0], (5, 3))
    motors = rigid.Torque.body([[0.0, 0.0, 0.1], [0.0, 0.0, 0.2]])
    tops = rigid.HeavyTop(ONE, mgl=[[1.0], [2.0], [3.0]], torque=motors)
    found = rigid.free.power_balance(tops, omega, [1.0, 0.5, 0.0, 0.0], t=t)
    assert found.power.shape == found.rate.shape == found.residual.shape == (3, 2, 5)
    # The rates are constant: the motors, at the same rates, differ by 0.1 N m at 3 rad/s.
    np.testing.assert_allclose(found.power[:, 1] - found.power[:, 0], 0.3, rtol=1e-13)


def test_bodies_of_one_call_have_the_methods_that_they_need() -> None:
    moments = [[1.0, 1.0, 2.0], [1.0, 1.5, 2.2], [1.0, 1.5, 2.2], [1.0, 1.2, 1.4]]
    omega, bodies = np.random.default_rng(3).normal(size=(4, 3)), rigid.Body(moments)
    # A Lagrange top, a top without symmetry, a body without weight, and another top.
    tops = rigid.HeavyTop(bodies, mgl=[1.0, 1.0, 0.0, 2.0])
    # Damped not at all, weakly, strongly, and evenly.
    strengths = [[0.0, 0.0, 0.0], [0.1, 0.2, 0.3], [50.0, 90.0, 80.0], [0.125, 0.15, 0.175]]
    damped = rigid.FreeBody(bodies, damping=[np.diag(strength) for strength in strengths])
    for scene, methods in (
        (tops, ["exact", "dop853", "exact", "dop853"]),
        (damped, ["exact", "dop853", "etd4", "exact"]),
    ):
        alone = [rigid.simulate(scene[k], omega[k], t=[0.0, 7.0]).plan.method for k in range(4)]
        assert alone == methods
    plan = rigid.simulate(damped, omega, t=[0.0, 7.0]).plan
    assert plan.method == "dop853"
    assert plan.why[-2:] == ("2 of 4 bodies in closed form", "1 of 4 bodies by etd4")
    assert rigid.plan(damped, "attitude", omega=omega, t_end=7.0).why[-2:] == plan.why[-2:]


TWO = np.array([0.1, 0.2])
EACH = np.array([[0.1, 0.2, 0.3], [0.4, 0.5, 0.6]])
UNDER_ALL: list[rigid.FreeBody | rigid.HeavyTop] = [
    rigid.FreeBody(
        rigid.Body(MOMENTS[:2]),
        torque=rigid.Torque.body(EACH),
        damping=EACH,
        dissipation=rigid.EnergySink(EACH),
        rotor=EACH,
        drag=EACH,
        orbit=rigid.Orbit(TWO, TWO, TWO),
    ),
    rigid.HeavyTop(rigid.Body(MOMENTS[:2]), mgl=TWO, com=[[0.0, 0.6, 0.8], [1.0, 0.0, 0.0]]),
]


@pytest.mark.parametrize("scene", UNDER_ALL, ids=lambda scene: type(scene).__name__)
def test_the_numbers_of_many_bodies_are_those_of_each(scene: Any) -> None:
    """A body's part of its numbers has the axes that its place says."""
    places = [name for name in PLACES if _stands_in(scene, name)]
    assert len(places) > 3
    together = numbers_of(scene, AT_REST, places, 2)
    for k in range(2):
        for name, alone in numbers_of(scene[k], AT_REST, places, 1).items():
            np.testing.assert_array_equal(together[name][k], alone[0], err_msg=name)


def _stands_in(scene: Any, name: str) -> bool:
    try:
        numbers_of(scene[0], AT_REST, [name], 1)
    except (AttributeError, AssertionError, TypeError):
        return False
    return True
