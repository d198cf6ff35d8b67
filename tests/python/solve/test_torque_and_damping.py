"""Bodies under torque and damping: closed forms, balances, reference trajectories, orders."""

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from scipy.linalg import expm

import rigid
from physics import (
    ROUNDOFF,
    Golden,
    angular_momentum,
    golden,
    present,
    rotation_angle,
    rotation_matrix,
)
from refusals import refuses
from rigid.model.scene import Scene

DRIVEN = [method for method in rigid.methods() if method.forces]
EXPLICIT = [method for method in DRIVEN if not method.stiff]
SERIES = [method.name for method in DRIVEN if method.name.startswith("taylor")]
NAMES = [method.name for method in EXPLICIT]

BODY = rigid.Body((1.0, 1.6, 2.1))
TILTED = np.array([0.8, 0.36, -0.48, 0.0])
MATRIX = np.array([[0.3, 0.05, -0.1], [0.05, 0.2, 0.02], [-0.1, 0.02, 0.4]])
TABLE = np.array([[0.2, -0.5, 0.9], [1.0, 0.3, -0.7], [-0.4, 0.8, 0.1], [0.6, -0.2, 0.5]])
KNOTS = np.array([0.0, 1.3, 1.3, 4.0])
PUSHED = rigid.HeavyTop(
    BODY,
    mgl=1.5,
    com=(0.6, 0.0, 0.8),
    torque=rigid.Torque.body(TABLE, times=KNOTS) + rigid.Torque.space((0.3, -0.2, 0.1)),
    damping=MATRIX,
)

# Steps that are left to the method leave rk4 about 1e-6 a radian turned, the others rounding.
ERROR = {name: 1e-5 if name == "rk4" else 1e-12 for name in NAMES}


def integral(t: np.ndarray, torque: np.ndarray, knots: np.ndarray) -> np.ndarray:
    """Of a piecewise linear torque from its first knot to each time: trapezoids are exact."""
    total = np.zeros((len(t), torque.shape[1]))
    for (a, b), (first, second) in zip(pairwise(knots), pairwise(torque), strict=True):
        end = np.clip(t, a, b)
        share = np.where(b > a, (end - a) / max(b - a, 1e-300), 0.0)[:, None]
        total += (end - a)[:, None] * (first + 0.5 * share * (second - first))
    return total


@pytest.mark.parametrize("method", NAMES)
def test_a_damped_symmetric_body_with_an_axial_torque(method: str) -> None:
    """`w3 = N/c + (w3(0) - N/c) e^(-ct/I3)`; the rest decays while it turns about the axis."""
    i1, i3, c, torque = 1.0, 1.7, 0.4, 0.9
    scene = rigid.FreeBody(
        rigid.Body((i1, i1, i3)), torque=rigid.Torque.body((0, 0, torque)), damping=c
    )
    start, t = np.array([0.8, -0.3, 3.0]), np.linspace(0.0, 8.0, 9)
    run = rigid.simulate(scene, start, t=t, method=method)
    last, off = torque / c, start[2] - torque / c
    spin = last + off * np.exp(-c * t / i3)
    turned = last * t - off * i3 / c * np.expm1(-c * t / i3)
    across = complex(start[0], start[1]) * np.exp(-c * t / i1 - 1j * (1.0 - i3 / i1) * turned)
    known = np.column_stack([across.real, across.imag, spin])
    assert np.abs(run.omega - known).max() < ERROR[method]
    assert run.status == rigid.Status.FINISHED


@pytest.mark.parametrize("frame", ["body", "space"])
@pytest.mark.parametrize("c", [0.0, 0.3])
@pytest.mark.parametrize("method", NAMES)
def test_a_sphere_turned_about_a_fixed_axis(method: str, c: float, frame: str) -> None:
    """`R = R0 exp([n] theta)`, `theta` from the linear equation of its rate."""
    inertia, torque, rate = 2.0, 0.7, 1.1
    axis = np.array([2.0, -1.0, 2.0]) / 3.0
    of_space = rotation_matrix(TILTED) @ axis
    acting = rigid.Torque.body(torque * axis)
    if frame == "space":
        acting = rigid.Torque.space(torque * of_space)
    scene = rigid.FreeBody(rigid.Body([inertia] * 3), torque=acting, damping=c or None)
    t = np.linspace(0.0, 6.0, 7)
    run = rigid.simulate(scene, rate * axis, TILTED, t=t, method=method)
    if c:
        slow = -np.expm1(-c * t / inertia)
        theta = torque / c * t + (rate - torque / c) * slow * inertia / c
        omega = torque / c + (rate - torque / c) * (1.0 - slow)
    else:
        theta, omega = rate * t + torque * t**2 / (2.0 * inertia), rate + torque * t / inertia
    assert np.abs(run.omega - omega[:, None] * axis).max() < ERROR[method]
    half = theta[:, None] / 2.0
    rotation = np.hstack([np.cos(half), np.sin(half) * axis])
    w, v = TILTED[0], TILTED[1:]
    known = np.hstack(
        [
            w * rotation[:, :1] - rotation[:, 1:] @ v[:, None],
            w * rotation[:, 1:] + rotation[:, :1] * v + np.cross(v, rotation[:, 1:]),
        ]
    )
    assert rotation_angle(present(run.attitude), known).max() < ERROR[method]


@pytest.mark.parametrize("method", NAMES)
def test_a_damped_sphere_forgets_by_the_exponential_of_its_matrix(method: str) -> None:
    scene = rigid.FreeBody(rigid.Body([0.5] * 3), damping=MATRIX)
    start, t = np.array([1.0, -2.0, 0.5]), np.linspace(-1.0, 5.0, 7)
    run = rigid.simulate(scene, start, t=t, method=method, record="rates")
    known = np.array([expm(-MATRIX * time / 0.5) @ start for time in t])
    assert np.abs(run.omega - known).max() < ERROR[method] * np.abs(known).max()


@pytest.mark.parametrize("method", NAMES)
def test_a_torque_in_space_adds_its_integral_to_the_momentum_in_space(method: str) -> None:
    """For any body: `R I omega = L0 + integral`, and the work is what the energy gained."""
    scene = rigid.FreeBody(BODY, torque=rigid.Torque.space(TABLE, times=KNOTS))
    t = np.array([0.0, 0.4, 1.3, 2.0, 4.0])
    run = rigid.simulate(scene, [0.4, -1.0, 0.7], TILTED, t=t, method=method)
    momentum = (
        rotation_matrix(present(run.attitude)) @ angular_momentum(scene, run.omega)[..., None]
    )
    known = momentum[0, :, 0] + integral(t, TABLE, KNOTS)
    assert np.abs(momentum[..., 0] - known).max() < ERROR[method]
    energy = run.energy()
    assert np.abs(energy - energy[0] - present(run.work)).max() < ERROR[method]


@pytest.mark.parametrize("method", NAMES)
def test_a_table_about_a_principal_axis_is_integrated_exactly(method: str) -> None:
    """Forward and backward; rk4 has no error either, of a torque linear between knots."""
    table = np.outer(TABLE[:, 0], [0.0, 1.0, 0.0])
    scene = rigid.FreeBody(BODY, torque=rigid.Torque.body(table, times=KNOTS - 2.0))
    t = np.array([-2.0, -1.1, -0.7, 0.0, 1.0, 2.0])
    run = rigid.simulate(scene, [0.0, 2.0, 0.0], t=t, method=method)
    gained = integral(t, table, KNOTS - 2.0)
    known = [0.0, 2.0, 0.0] + (gained - gained[3]) / 1.6
    # Rounding of some hundred steps.
    assert np.abs(run.omega - known).max() < 1e-13


def is_stiff(case: Golden) -> bool:
    """Whether explicit steps that resolve the damping are millions."""
    forcing: Any = case.scene.acting()
    moments = np.array([case.scene.body.moments])
    return bool(forcing.damping_rates(moments)[0] * case.t[-1] > 1e4)


CASES = golden("forced_damped")
#: Stiff cases, of thousands of steps, by one series: all orders are one loop.
RESOLVED = [
    (method, case)
    for method in NAMES
    for case in CASES
    if method == "taylor16" or not is_stiff(case)
]


@pytest.mark.parametrize(("method", "case"), RESOLVED, ids=lambda one: getattr(one, "id", one))
def test_the_error_is_the_one_that_halving_the_step_reveals(method: str, case: Golden) -> None:
    """And rounding; bounds as in the test of that name for bodies that nothing acts on.

    With an error c h^p, runs of steps h and h/2 differ by (2^p - 1) times the error of the finer
    one; twice that is granted. Rounding: a random walk of some operations a step, times the
    condition of the problem.
    """
    coarse = case.run(method, check=False)
    fine = case.run(method, step=case.t[-1] / (2.0 * float(coarse.steps)), check=False)
    assert coarse.status == fine.status == rigid.Status.UNCHECKED
    order = next(known.order for known in EXPLICIT if known.name == method)
    share = 2.0 / (2.0**order - 1.0)
    rounding = 10.0 * ROUNDOFF * np.sqrt(float(fine.steps))

    scale = np.linalg.norm(case.omega, axis=-1).max()
    error = np.linalg.norm(fine.omega - case.omega, axis=-1).max()
    revealed = np.linalg.norm(coarse.omega - fine.omega, axis=-1).max()
    assert error < share * revealed + rounding * scale * (1.0 + case.kappa_omega.max())
    angle = rotation_angle(present(fine.attitude), case.attitude).max()
    revealed = rotation_angle(present(coarse.attitude), present(fine.attitude)).max()
    assert angle < share * revealed + rounding * (1.0 + case.kappa_att.max())

    # The balance holds: its residual is below the error that the steps left in the rates.
    energy, work = fine.energy(), present(fine.work)
    size = np.abs(energy).max() + np.abs(work).max()
    off = np.abs(energy - energy[0] - work).max() / size
    assert off < 10.0 * (error / scale + angle + rounding)
    # Reported relative to the energy that the body can reach: in these scenes up to ten times more
    # than it does reach.
    assert off < 20.0 * fine.energy_drift + 1e-14


@pytest.mark.parametrize("method", EXPLICIT, ids=lambda method: method.name)
def test_knots_and_jumps_of_a_torque_cost_no_order(method: rigid.Method) -> None:
    """Error against the series of order 26 in steps a tenth of what it needs."""
    start = ([0.4, -1.0, 0.7], TILTED)
    truth = rigid.simulate(PUSHED, *start, t=[4.0], method="taylor26", step=0.02)
    steps: list[float] = []
    found: list[float] = []
    count = 4.0
    while len(found) < 40:
        run = rigid.simulate(
            PUSHED, *start, t=[4.0], method=method.name, step=4.0 / count, check=False
        )
        error = float(np.linalg.norm(run.omega - truth.omega))
        if error < 1e-13:
            break
        if error < 1e-3:
            # Two legs, 1.3 and 2.7 long, each in whole steps.
            steps.append(4.0 / float(run.steps))
            found.append(error)
        count = max(count * 2.0 ** (1.0 / method.order), count + 1.0)
    if len(found) < 5:
        assert method.order >= 16  # too few steps above rounding to fit an order
        return
    order = np.polyfit(np.log(steps), np.log(found), 1)[0]
    assert order > method.order - 0.7
    # The residual of the power balance tells the error: it falls alike.
    coarse, fine = (
        rigid.simulate(PUSHED, *start, t=[4.0], method=method.name, step=step, check=False)
        for step in (0.2, 0.1)
    )
    if coarse.energy_drift > 1e-11:
        assert fine.energy_drift < coarse.energy_drift / 2.0 ** (method.order - 1.5)


def test_a_run_may_end_with_the_table_of_its_torque_on_both_sides() -> None:
    """The time that it covers, added to its first time, exceeds the last by a rounding."""
    first, last = -0.1, 0.3
    assert first + (last - first) > last
    always = rigid.Torque.body((0.1, 0.0, 0.0))
    table = rigid.Torque.body([(0.1, 0.0, 0.0)] * 2, times=[first, last])
    runs = [
        rigid.simulate(rigid.FreeBody(BODY, torque=torque), [0.1, 0.2, 0.3], t=[first, last])
        for torque in (always, table)
    ]
    # The same steps but for the rounding of their ends.
    assert np.abs(runs[0].omega - runs[1].omega).max() < 1e-14


@pytest.mark.parametrize("method", SERIES)
def test_series_choose_their_steps_between_the_knots(method: str) -> None:
    t = [0.0, 1.3, 2.0, 4.0]
    truth = rigid.simulate(PUSHED, [0.4, -1.0, 0.7], TILTED, t=t, method="taylor26", step=0.02)
    run = rigid.simulate(PUSHED, [0.4, -1.0, 0.7], TILTED, t=t, method=method, tolerance=1e-15)
    assert np.abs(run.omega - truth.omega).max() < 1e-13
    assert np.abs(present(run.work) - present(truth.work)).max() < 1e-13
    assert np.abs(run.omega - truth.omega).max() < run.error < 1e-11


@pytest.mark.parametrize("method", NAMES)
def test_less_recorded_changes_no_rate(method: str) -> None:
    def rates(scene: Scene, record: str) -> np.ndarray:
        return rigid.simulate(
            scene, [1.0, 2.0, -0.5], TILTED, t=[0.7, 3.0], method=method, record=record
        ).omega

    for record in ("rates", "axis"):
        assert rates(PUSHED, record).tobytes() == rates(PUSHED, "attitude").tobytes()
    # Without directions the sums are others: rounding.
    damped = rigid.FreeBody(BODY, damping=MATRIX)
    assert np.abs(rates(damped, "rates") - rates(damped, "attitude")).max() < 1e-14


@pytest.mark.parametrize("damping", [None, (3e-4, 4e-4, 5e-4)])
def test_few_steps_are_checked_at_the_last_time(damping: tuple[float, ...] | None) -> None:
    """Five steps to two times: at the first both runs make the same two steps and agree."""
    scene = rigid.FreeBody(rigid.Body((0.553, 0.492, 1.0)), damping=damping)
    start, t = [-0.55264732, -0.78478036, 0.74874577], [1.5, 5.0]
    run = rigid.simulate(scene, start, t=t, accuracy=1e-6, method="dop853")
    truth = rigid.simulate(scene, start, t=t, method="taylor26", tolerance=1e-15, check=False)
    error = np.linalg.norm(run.omega - truth.omega, axis=-1).max() / np.linalg.norm(start)
    assert run.steps <= 12
    assert error < run.error


def test_an_accuracy_is_kept_and_the_error_is_believed() -> None:
    start = ([0.4, -1.0, 0.7], TILTED)
    truth = rigid.simulate(PUSHED, *start, t=[1.0, 4.0], method="taylor26", step=0.02)
    for accuracy in (1e-4, 1e-8, 1e-11):
        run = rigid.simulate(PUSHED, *start, t=[1.0, 4.0], accuracy=accuracy)
        size = np.linalg.norm(truth.omega, axis=-1).max()
        error = max(
            np.linalg.norm(run.omega - truth.omega, axis=-1).max() / size,
            rotation_angle(present(run.attitude), present(truth.attitude)).max(),
        )
        assert error <= run.error <= accuracy
        assert not run.flagged


@pytest.mark.parametrize("moments", [(1.0, 1.6, 2.1), (1.5, 1.0, 1.5), (2.0, 2.0, 2.0)])
def test_a_damping_that_is_a_multiple_of_the_inertia_only_slows(
    moments: tuple[float, float, float],
) -> None:
    """`omega(t) = e^(-kt) omega_free(s)`, the attitude that of the free body at `s`."""
    k = 0.37
    body = rigid.Body(moments)
    scene = rigid.FreeBody(body, damping=k * np.array(moments))
    start, t = [0.3, 1.2, -0.4], np.array([-1.0, 0.0, 1e-9, 2.0, 60.0])
    run = rigid.simulate(scene, start, TILTED, t=t)
    assert run.plan.method == "exact"
    assert "slowed" in str(run.plan)
    free = rigid.simulate(rigid.FreeBody(body), start, TILTED, t=-np.expm1(-k * t) / k)
    # Two exponentials, each rounded.
    known = np.exp(-k * t)[:, None] * free.omega
    assert np.abs(run.omega - known).max() < 1e-14 * np.abs(known).max()
    assert rotation_angle(present(run.attitude), present(free.attitude)).max() < 1e-14
    stepped = rigid.simulate(scene, start, TILTED, t=t, method="taylor16")
    assert np.abs(run.omega - stepped.omega).max() < 1e-13
    assert rotation_angle(present(run.attitude), present(stepped.attitude)).max() < 1e-13
    assert np.abs(present(run.work) - present(stepped.work)).max() < 1e-13
    assert np.abs(run.energy() - run.energy()[1] - present(run.work)).max() < 1e-13
    other = rigid.FreeBody(body, damping=k * np.array(moments) + [0.0, 0.0, 1e-3])
    with pytest.raises(ValueError, match="multiple of its inertia"):
        rigid.simulate(other, start, t=t, method="exact")


def test_the_plan_says_what_acts_and_which_method_moves_it() -> None:
    text = str(rigid.plan(PUSHED, "attitude", omega=[1, 2, 3], t_end=4.0))
    assert "torque in the body and space by a table of 4 times" in text
    assert "damping ((0.3, 0.05, -0.1), " in text
    assert "no closed form under torque and damping" in text
    plan = rigid.plan(rigid.FreeBody(BODY, damping=(0, 0, 0.2)), "rates")
    assert plan.carried == ("omega", "work")
    assert "damping (0, 0, 0.2)" in plan.scene
    assert {"rk4", "dop853", "taylor16"} <= {method.name for method in DRIVEN}


def test_torques_add_where_both_tables_reach() -> None:
    first = rigid.Torque.body(TABLE, times=KNOTS)
    second = rigid.Torque.space([[1, 0, 0], [0, 1, 0], [0, 0, 4]], times=[-1.0, 0.5, 3.0])
    both = first + second
    assert both.times == (0.0, 0.5, 1.3, 1.3, 3.0)
    t = np.array([0.0, 0.2, 0.5, 1.0, 1.3, 2.9])
    for k, torque in enumerate((first, second)):
        assert np.abs(both.at(t)[k] - torque.at(t)[k]).max() < 1e-15
    before = both.at(np.nextafter(1.3, 0.0))[0][0]
    assert np.abs(before - TABLE[1]).max() < 1e-14
    with pytest.raises(ValueError, match="no time in common"):
        first + rigid.Torque.body(TABLE[:2], times=[5.0, 6.0])


def free(**options: Any) -> Any:
    return lambda: rigid.FreeBody(BODY, **options)


def run(scene: Scene, **options: Any) -> Any:
    return lambda: rigid.simulate(scene, [1.0, 2.0, 3.0], **{"t": [1.0], **options})


STIFF = rigid.FreeBody(BODY, damping=1e4)
test_refusals_name_the_argument_its_value_and_the_rule = refuses(
    [
        (free(damping=-1.0), ["damping = -1.0: must not be negative"]),
        (free(damping=(1, -2, 1)), ["damping = [1.0, -2.0, 1.0]", "must not be negative"]),
        (free(damping=np.nan), ["damping = nan: must be finite"]),
        (free(damping="much"), TypeError, ["damping = 'much': must be real numbers"]),
        (
            free(damping=[[1, 0.1, 0], [0.1 + 1e-6, 1, 0], [0, 0, 1]]),
            ["must be a symmetric matrix"],
        ),
        (
            free(damping=[[1, 2, 0], [2, 1, 0], [0, 0, 1]]),
            ["damping = [[1.0, 2.0, 0.0], [2.0, 1.0, 0.0]", "must be positive semi-definite"],
        ),
        (free(torque=(0, 0, 1)), TypeError, ["torque = (0, 0, 1): must be a rigid.Torque"]),
        (lambda: rigid.Torque.body((1, 2)), ["torque: expected shape (..., 3), got (2,)"]),
        (
            lambda: rigid.Torque.body(TABLE, times=[0, 1, 2]),
            ["torque: expected shape (..., 3, 3), got (4, 3)"],
        ),
        (
            lambda: rigid.Torque.body(TABLE, times=[0, 1, 3, 2]),
            ["torque times[2] = 3.0 > torque times[3] = 2.0: times must be ascending"],
        ),
        (
            lambda: rigid.Torque.body(TABLE, times=[0, 1, 1, 1]),
            ["torque times = [1.0, 1.0, 1.0]: at most two values may share a time"],
        ),
        (
            lambda: rigid.Torque.body(TABLE[:1], times=[0]),
            ["torque times = [0.0]: a table has at least two times"],
        ),
        (lambda: rigid.Torque.body((0, np.inf, 0)), ["torque[1] = inf: must be finite"]),
        (run(PUSHED, t=[4.5]), ["t = 4.5: the table of the torque does not reach this time"]),
        (
            run(PUSHED, t=[-0.5, 1.0]),
            ["t = -0.5: the table of the torque does not reach this time"],
        ),
        (
            run(STIFF, step=0.1, method="rk4"),
            ["step = 1e-1: 'rk4' is unstable under damping with steps beyond 2.778e-4", "1e4"],
        ),
        (run(STIFF, method="chin4a"), ["method = 'chin4a': does not integrate ", "'taylor16'"]),
    ]
)
