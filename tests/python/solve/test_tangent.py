"""The derivative of a motion by its start: 26 digits, closed forms, and its structure."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import rigid
from chaos_scenes import DEVIATING, Deviating, attitude_with
from free_motions import tops_at_random
from physics import Floats, present
from refusals import refuses
from rigid.model.scene import Scene

WITH_TANGENT = [method.name for method in rigid.methods() if method.tangent]
SPLITTINGS = ["splitting", "splitting4", "splitting8"]
TOP = rigid.HeavyTop(rigid.Body((1.0, 1.6, 0.7)), mgl=1.2, com=(0.6, 0.0, 0.8))
BOX = rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0)))
DAMPED = rigid.HeavyTop(
    rigid.Body((1.0, 1.6, 0.7)),
    mgl=1.2,
    com=(0.6, 0.0, 0.8),
    damping=[0.06, 0.03, 0.12],
    torque=rigid.Torque.space([0.1, -0.2, 0.05]) + rigid.Torque.body([0.0, 0.1, 0.2]),
)
TIMES = [-1.0, 0.0, 0.5, 3.0]


def tangent(scene: Scene, omega: Floats, attitude: Floats | None = None, **options: Any) -> Floats:
    run = rigid.simulate(scene, omega, attitude, check=False, tangent=True, **options)
    return present(run.tangent)


def hat(v: Floats) -> Floats:
    """The matrix of ``v ×``."""
    x, y, z = v
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def exponential(matrix: Floats) -> Floats:
    """Its exponential to 1e-16: powers of extended precision, where SciPy has 1e-13."""
    small: NDArray[np.longdouble] = matrix.astype(np.longdouble) / 64.0
    term: NDArray[np.longdouble] = np.eye(len(matrix), dtype=np.longdouble)
    total = term
    for k in range(1, 60):
        term = np.asarray(term @ small / k)
        total = total + term
    for _ in range(6):
        total = total @ total
    return np.asarray(total, dtype=np.float64)


def jacobian(scene: Scene, omega: Floats, gamma: Floats) -> Floats:
    """The matrix of the linear equations of a deviation vector, by cross products."""
    moments = np.array(scene.body.moments)
    inertia, inverse = np.diag(moments), np.diag(1.0 / moments)
    spin = inverse @ (hat(inertia @ omega) - hat(omega) @ inertia)
    # (gamma × x) × w = -w × (gamma × x).
    weight = inverse @ -hat(scene.weight) @ hat(gamma)
    return np.block([[spin, weight], [np.eye(3), -hat(omega)]])


# --- Data ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("case", DEVIATING, ids=lambda case: case.name)
@pytest.mark.parametrize("method", [None, "taylor16"])
def test_matrices_of_26_digits(case: Deviating, method: str | None) -> None:
    """The rounding of the start costs 1e-16 times the square of the growth, over what is left."""
    tolerance = None if method is None else 1e-16
    found = tangent(
        case.scene, case.omega, case.attitude, t=case.t, method=method, tolerance=tolerance
    )
    true, scaled = case.scaled(case.matrices), case.scaled(found)
    sizes = np.linalg.norm(true, 2, axis=(1, 2))
    error = np.linalg.norm(scaled - true, 2, axis=(1, 2)) / sizes
    assert (error <= np.maximum(1e-13, 3e-14 * sizes.max() ** 2 / sizes)).all()


@pytest.mark.parametrize("method", WITH_TANGENT)
def test_the_order_of_the_tangent_is_that_of_the_method(method: str) -> None:
    order = next(m.order for m in rigid.methods() if m.name == method)
    omega, t = np.array([0.5, 0.4, 2.0]), [2.0]
    true = tangent(TOP, omega, t=t)
    # A step at which truncation is far above rounding and well below one.
    step = 0.05 if order <= 4 else 0.25 if order < 12 else 0.5
    errors = [
        np.abs(tangent(TOP, omega, t=t, method=method, step=step / k) - true).max() for k in (1, 2)
    ]
    assert errors[1] < max(errors[0] * 2.0 ** (1.0 - order), 1e-13)


# --- Structure -----------------------------------------------------------------------------------


FINE: dict[str, dict[str, Any]] = {
    "dop853": {"step": 0.02},
    "taylor12": {"step": 0.05},
    "taylor16": {"tolerance": 2.0**-53},
    "taylor20": {"step": 0.1},
}
"""Methods with steps (s) or tolerances that leave no truncation."""


@pytest.mark.parametrize("method", FINE)
def test_the_structure_of_the_tangent(method: str) -> None:
    """Flow, turns about the vertical and gradients of the integrals, of 1000 random tops.

    Rounding is relative to the largest matrix until then: the worst was 2e-15 of it.
    """
    scene, omega, attitude = tops_at_random(1000, np.random.default_rng(20260728))
    t = [0.0, 1.0, 3.0]
    run = rigid.simulate(
        scene, omega, attitude, t=t, method=method, check=False, tangent=True, **FINE[method]
    )
    matrices = present(run.tangent)[:, 1:]
    size = np.linalg.norm(matrices, 2, axis=(-2, -1)).max(axis=1)[:, None]
    moments, weight = np.array(scene.body.moments)[:, None], np.asarray(scene.weight)[:, None]
    gamma, momentum = present(run.gamma), moments * run.omega
    rates = (np.cross(momentum, run.omega) + np.cross(gamma, weight)) / moments

    def both(first: Floats, second: Floats) -> Floats:
        return np.concatenate(np.broadcast_arrays(first, second), axis=-1)

    for moved in (both(rates, run.omega), both(np.zeros(3), gamma)):
        error = np.linalg.norm(
            moved[:, 1:] - np.einsum("nmij,nj->nmi", matrices, moved[:, 0]), axis=-1
        )
        assert (error < 1e-14 * size * np.linalg.norm(moved, axis=-1).max(axis=1)[:, None]).all()
    for gradient in (
        both(momentum, np.cross(weight, gamma)),
        both(moments * gamma, np.cross(momentum, gamma)),
    ):
        error = np.linalg.norm(
            np.einsum("nmi,nmij->nmj", gradient[:, 1:], matrices) - gradient[:, :1], axis=-1
        )
        assert (error < 1e-14 * size * np.linalg.norm(gradient, axis=-1).max(axis=1)[:, None]).all()


@pytest.mark.parametrize("symmetric", [False, True], ids=["any", "symmetric"])
@pytest.mark.parametrize("method", SPLITTINGS)
def test_splittings_are_symplectic_at_any_step(method: str, symmetric: bool) -> None:
    """``N.T J N = J`` of the steps themselves, however wrong they are.

    So singular values come in pairs ``s s' = 1``, and the volume is kept. They turn tops about the
    vertical and free bodies about every axis as they should: the steps commute with it.
    """
    scene, omega, attitude = tops_at_random(1000, np.random.default_rng(20260728))
    if symmetric:
        moments = np.array(scene.body.moments)
        # Body k is symmetric about axis k mod 3.
        for axis in range(3):
            across = moments[axis::3, (axis + 2) % 3]
            moments[axis::3, (axis + 1) % 3] = across
            moments[axis::3, axis] = np.minimum(moments[axis::3, axis], 1.9 * across)
        scene = rigid.HeavyTop(rigid.Body(moments), mgl=scene.mgl, com=scene.com)
    form = np.block([[np.zeros((3, 3)), np.eye(3)], [-np.eye(3), np.zeros((3, 3))]])
    for step, count in ((0.05, 20), (0.5, 20), (4.0, 2)):
        run = rigid.simulate(
            scene, omega, attitude, t=[0.0, count * step], method=method, step=step, check=False,
            tangent=True,
        )  # fmt: skip
        gamma, matrices = present(run.gamma), present(run.tangent)[:, 1]
        moments = np.array(scene.body.moments)[:, np.newaxis]
        charts = np.zeros((1000, 2, 6, 6))
        charts[:, :, :3, 3:] = np.eye(3)
        charts[:, :, 3:, :3] = moments[..., np.newaxis] * np.eye(3)
        # The columns of the matrix of L × are L × e.
        columns = np.cross((moments * run.omega)[:, :, np.newaxis], np.eye(3))
        charts[:, :, 3:, 3:] = -0.5 * np.swapaxes(columns, 2, 3)
        n = charts[:, 1] @ matrices @ np.linalg.inv(charts[:, 0])
        size = np.linalg.norm(n, 2, axis=(1, 2))
        lost = np.abs(np.swapaxes(n, 1, 2) @ form @ n - form).max(axis=(1, 2))
        assert (lost < 1e-13 * size**2).all()
        values = np.linalg.svd(n, compute_uv=False)
        assert (np.abs(values * values[:, ::-1] - 1.0).max(axis=1) < 1e-13 * size**2).all()
        turns = np.concatenate([np.zeros_like(gamma), gamma], axis=2)
        turned = np.einsum("nij,nj->ni", matrices, turns[:, 0])
        # In steps of 4 s, which are far too long, a deviation vector grows more inside a step than
        # over it, and what rounds there is lost: 5e-12 of 3e12 of one top with splitting8.
        least = 1e-12 if step < 1.0 else 1e-11
        assert (np.abs(turned - turns[:, 1]).max(axis=1) < least * size).all()
        momenta = np.concatenate([moments * gamma, np.cross(moments * run.omega, gamma)], axis=2)
        kept = np.abs(np.einsum("ni,nij->nj", momenta[:, 1], matrices) - momenta[:, 0])
        bound = least * size * np.linalg.norm(momenta[:, 0], axis=1)
        assert (kept.max(axis=1) < bound).all()


# --- Truths --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("scene", "omega", "gamma"),
    [
        (BOX, [0.0, 1.0, 0.0], [0.0, 0.6, 0.8]),
        (rigid.FreeBody(rigid.Body((1.0, 1.0, 1.0))), [0.0, 0.6, 0.8], [0.0, 0.0, 1.0]),
        (rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0), [0.0, 0.0, 3.0], [0.0, 0.0, 1.0]),
        (rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0), [0.0, 0.0, 5.0], [0.0, 0.0, 1.0]),
        (rigid.HeavyTop(rigid.Body((1.0, 1.5, 0.75)), mgl=1.0), [0.0, 0.0, 1.0], [0.0, 0.0, 1.0]),
        (rigid.HeavyTop(rigid.Body((1.0, 1.5, 2.0)), mgl=1.0), [0.0, 0.0, 0.0], [0.0, 0.0, 1.0]),
    ],
    ids=["middle axis", "sphere", "awake", "sleeping", "upright, asymmetric", "upright, at rest"],
)
def test_about_a_permanent_axis_it_is_the_exponential_of_a_constant_matrix(
    scene: Scene, omega: list[float], gamma: list[float]
) -> None:
    times = np.array([0.5, 2.0, 8.0])
    found = tangent(scene, np.array(omega), attitude_with(np.array(gamma)), t=times)
    constant = jacobian(scene, np.array(omega), np.array(gamma))
    for time, matrix in zip(times, found, strict=True):
        true = exponential(constant * time)
        assert np.abs(matrix - true).max() < 1e-14 * np.linalg.norm(true, 2)


# --- Interface -----------------------------------------------------------------------------------


OPTIONS: list[dict[str, Any]] = [{}, *({"method": name} for name in WITH_TANGENT), {"step": 0.01}]
#: Splittings have no tangent under damping.
ASKED: list[tuple[Scene, dict[str, Any]]] = [
    (scene, options)
    for scene in (TOP, BOX, DAMPED)
    for options in OPTIONS
    if not (scene is DAMPED and options.get("method") in SPLITTINGS)
]


@pytest.mark.parametrize(("scene", "options"), ASKED, ids=str)
def test_it_changes_no_bit_of_the_motion(scene: Scene, options: dict[str, Any]) -> None:
    starts = np.array([[0.5, 0.4, 2.0], [0.1, 1.0, 0.3]])
    every: list[Any] = [False, True]
    if options.get("method") not in SPLITTINGS:
        every.append(("I1", "damping2", "torque3"))  # splittings have no derivatives by parameters
    without, *others = (
        rigid.simulate(scene, starts, t=TIMES, tangent=asked, **options) for asked in every
    )
    with_it = others[0]
    for other in others:
        for name in ("omega", "gamma", "attitude", "work", "error", "steps", "energy_drift"):
            a, b = getattr(other, name), getattr(without, name)
            assert (a is None) == (b is None)
            assert a is None or a.tobytes() == b.tobytes(), name
        assert present(other.tangent).tobytes() == present(with_it.tangent).tobytes()
    assert without.tangent is without.sensitivity is with_it.sensitivity is None
    assert with_it.parameters == ()
    assert present(with_it.tangent).shape == (2, 4, 6, 6)
    assert (present(with_it.tangent)[:, 1] == np.eye(6)).all()
    assert any(words.startswith("tangent by") for words in with_it.plan.why)


def test_bodies_of_any_shape_and_with_times_of_their_own() -> None:
    omega = np.random.default_rng(3).normal(size=(2, 3, 3))
    times = np.sort(np.random.default_rng(4).uniform(-1.0, 2.0, (2, 3, 5)))
    together = tangent(TOP, omega, t=times)
    assert together.shape == (2, 3, 5, 6, 6)
    assert (together[1, 2] == tangent(TOP, omega[1, 2], t=times[1, 2])).all()
    assert tangent(TOP, omega[0, 0], t=[1.0]).shape == (1, 6, 6)
    assert tangent(TOP, omega[:0], t=[1.0]).shape == (0, 3, 1, 6, 6)


test_methods_without_a_tangent_are_refused_by_name = refuses(
    [
        *((DAMPED, one, [f"'{one}': has no tangent under torque and da"]) for one in SPLITTINGS),
        *(
            (BOX, one, [f"method = '{one}': has no tangent, because ", " have one"])
            for one in ("chin4a", "pmlf4", "dmv10", "midpoint", "etd4")
        ),
    ],
    by=lambda scene, method: rigid.simulate(
        scene, [0.1, 1.0, 0.1], t=TIMES, method=method, tangent=True
    ),
)


def test_a_closed_form_has_an_integrated_tangent() -> None:
    run = rigid.simulate(BOX, [0.1, 1.0, 0.1], t=TIMES, method="exact", tangent=True)
    assert run.plan.method == "exact"
    assert "tangent by taylor16" in run.plan.why[-1]
    assert run.steps == 0


def test_what_is_not_run_has_no_tangent_and_what_overflows_is_infinite() -> None:
    found = tangent(
        TOP, np.array([0.5, 0.4, 2.0]), t=[1.0, 1e3], method="rk4", step=0.1, max_steps=20
    )
    assert np.isnan(found).all()
    fallen = rigid.HeavyTop(rigid.Body((1.0, 1.5, 2.0)), mgl=1.0)
    upright = tangent(fallen, np.zeros(3), t=[600.0, 900.0])
    assert np.isfinite(upright[0]).all()
    assert np.isinf(upright[1]).any()


# How much a motion magnifies a small change of its start, against what is known exactly


CUBE = rigid.FreeBody(rigid.Body((1.0, 1.0, 1.0)))


def test_a_cube_turns_ahead_of_its_neighbour() -> None:
    """Faster by delta, it is ahead by delta t: a shear, [[1, 0], [angle, 1]]."""
    times = np.array([0.0, 0.5, 1.0, 10.0, 1000.0])
    found = rigid.condition(CUBE, [0.0, 0.6, 0.8], t=times)
    np.testing.assert_allclose(found, 0.5 * (times + np.sqrt(times**2 + 4.0)), rtol=1e-13)


def test_beyond_a_separatrix_it_is_that_of_neighbours_in_closed_form() -> None:
    """It passes the saddle on 1e-13: neighbours that are much nearer to each other part by 1e13."""
    omega, aside, t = [1e-13, 1.0, 1e-13], 1e-17, [60.0]
    found = rigid.condition(BOX, omega, t=t)[0]
    ends = []
    for change in (-aside, aside):
        run = rigid.simulate(BOX, [1e-13 + change, 1.0, 1e-13], t=t, check=False)
        ends.append((run.omega[0], present(run.attitude)[0]))
    (w1, q1), (w2, q2) = ends
    turn = 2.0 * rigid.rotations.quaternion_product(q1 * [1.0, -1.0, -1.0, -1.0], q2)[1:]
    parted = np.hypot(np.linalg.norm(w2 - w1), np.linalg.norm(turn)) / (2.0 * aside)
    # The unit of the rates is 1: a change of the first rate is nearly the worst change.
    assert 1e12 < parted < found < 3.0 * parted


def test_neighbours_of_a_run_are_as_far_apart_as_it_says() -> None:
    """Two runs whose rates differ by 1e-9 at the start, which is less than that of the scale."""
    top = rigid.HeavyTop(rigid.Body((1.0, 1.6, 0.7)), mgl=1.2, com=(0.6, 0.0, 0.8))
    omega, times = np.array([0.3, 0.4, 1.0]), [5.0, 10.0]
    factor = rigid.condition(top, omega, t=times)
    for k in range(3):
        aside = omega.copy()
        aside[k] += 1e-9
        runs: Any = [
            rigid.simulate(top, w, t=times, method="taylor16", check=False) for w in (omega, aside)
        ]
        parted = 2.0 * np.linalg.norm(runs[0].attitude - runs[1].attitude, axis=-1)
        assert (parted <= 1.001 * factor * 1e-9 + 1e-13).all()


def test_the_layer_of_a_map() -> None:
    """Thrown about the middle axis a box is sensitive, about the largest it is not."""
    result = rigid.stability_map(
        rigid.FreeBody,
        axes={"I2/I1": np.array([1.5, 2.5])},
        start=rigid.Start(spin=1.0, axis=2, noise=rigid.normal(1e-3)),
        stable=rigid.no_flip(2),
        samples=3,
        t_end=15.0,
        rng=4,
        progress=False,
    )
    layer = result.condition(3)
    assert layer.shape == result.share.shape
    assert layer[0] > 10.0 * layer[1]
    body = result.replay(0, 0)
    alone = rigid.condition(
        rigid.FreeBody(rigid.Body((1.0, 1.5, 2.0))), body.omega, body.attitude, t=[15.0]
    )
    np.testing.assert_allclose(result.condition(1)[0], alone[0], rtol=1e-12)


def test_impossible_pixels_have_no_condition() -> None:
    result = rigid.stability_map(
        rigid.FreeBody,
        axes={"I3": np.array([2.0, 9.0])},
        stable=rigid.no_flip(),
        samples=2,
        t_end=5.0,
        rng=4,
        progress=False,
    )
    assert np.isnan(result.condition()).tolist() == [False, True]
    with pytest.raises(ValueError, match=r"samples = 3: the map has 2 in a pixel"):
        result.condition(3)


def test_what_overflows_has_none_and_nobody_has_no_rows() -> None:
    assert rigid.condition(BOX, np.zeros((0, 3)), t=[1.0]).shape == (0, 1)
    assert np.isnan(rigid.condition(BOX, [1e200, 1e200, 1.0], t=[1e200]))[0]
