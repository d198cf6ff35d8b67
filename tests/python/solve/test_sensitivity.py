"""The derivative of a motion by its parameters: closed forms, identities, neighbouring runs."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import rigid
from free_motions import tops_at_random
from physics import Floats, present
from refusals import refuses
from rigid.model.scene import Scene

WITH_TANGENT = [m.name for m in rigid.methods() if m.tangent and not m.symplectic]
MOMENTS = np.array([1.0, 1.6, 0.7])
COM = np.array([0.6, 0.0, 0.8])
OMEGA = np.array([0.3, 0.4, 1.0])
ATTITUDE = np.array([0.9, 0.3, 0.2, 0.1])
TIMES = [-1.0, 0.0, 0.5, 3.0]
OF_BODY = ("I1", "I2", "I3", "damping1", "damping2", "damping3", "torque1", "torque2", "torque3")
OF_TOP = (*OF_BODY, "mgl", "com")
TABLE = rigid.Torque.body(
    [[0.1, 0.0, 0.2], [0.3, -0.1, 0.0], [0.0, 0.2, 0.1]], times=[-2.0, 1.0, 4.0]
)


def made(kind: str, **changed: Any) -> Scene:
    """A scene of the tests with some of its numbers changed."""
    of_all = {"moments": MOMENTS, "mgl": 1.2, "com": COM, "torque": np.zeros(3)}
    known = {**of_all, "damping": np.zeros(3), **changed}
    body = rigid.Body(known["moments"])
    acting: dict[str, Any] = {}
    if kind == "driven":
        acting["damping"] = np.array([0.06, 0.03, 0.12]) + known["damping"]
        space = rigid.Torque.space([0.1, -0.2, 0.05])
        acting["torque"] = TABLE + space + rigid.Torque.body(known["torque"])
    else:
        acting["damping"] = known["damping"]
        if np.any(known["torque"]):
            acting["torque"] = rigid.Torque.body(known["torque"])
    if kind == "free":
        return rigid.FreeBody(body, **acting)
    # A com that is no unit vector is one with another mgl.
    size = float(np.linalg.norm(known["com"]))
    return rigid.HeavyTop(body, mgl=known["mgl"] * size, com=known["com"] / size, **acting)


KINDS = ("free", "top", "driven")


def names_of(kind: str) -> tuple[str, ...]:
    return OF_BODY if kind == "free" else OF_TOP


def sensitivity(scene: Scene, omega: Floats, names: Any, **options: Any) -> Floats:
    run = rigid.simulate(scene, omega, ATTITUDE, check=False, tangent=names, **options)
    return present(run.sensitivity)


# --- Neighbours ----------------------------------------------------------------------------------


def change(kind: str, name: str, by: float) -> Scene:
    """The scene with that parameter changed."""
    vectors = {"I": "moments", "com": "com", "damping": "damping", "torque": "torque"}
    if name == "mgl":
        return made(kind, mgl=1.2 + by)
    own = vectors[name[:-1]]
    start = {"moments": MOMENTS, "com": COM}.get(own, np.zeros(3))
    return made(kind, **{own: start + by * np.eye(3)[int(name[-1]) - 1]})


def quotient(scene: Callable[[float], Scene], size: float, **options: Any) -> Floats:
    """The derivative of runs by the argument of the scene at zero, of fourth order in its size."""
    known = {"check": False, "t": TIMES, **options}
    middle = rigid.simulate(scene(0.0), OMEGA, ATTITUDE, **known)
    back = Rotation.from_quat(present(middle.attitude), scalar_first=True).inv()
    total = np.zeros((len(known["t"]), 6))
    for steps, weight in ((1.0, 8.0), (-1.0, -8.0), (2.0, -1.0), (-2.0, 1.0)):
        run = rigid.simulate(scene(steps * size), OMEGA, ATTITUDE, **known)
        now = Rotation.from_quat(present(run.attitude), scalar_first=True)
        total += weight * np.concatenate([run.omega, (back * now).as_rotvec()], axis=1)
    return total / (12.0 * size)


@pytest.mark.parametrize("kind", KINDS)
def test_neighbours_follow_it(kind: str) -> None:
    """Differences over 1e-3 are off by 1e-12 of the fifth derivative and 1e-12 of rounding.

    Damping cannot be negative, so a body without it has neighbours on one side only: its derivative
    by damping is that of the damped bodies, and of the sphere below.
    """
    names = names_of(kind)
    run = rigid.simulate(made(kind), OMEGA, ATTITUDE, t=TIMES, tangent=names)
    found = present(run.sensitivity)
    assert (found[1] == 0.0).all()
    for column, name in enumerate(run.parameters):
        if kind != "driven" and name.startswith("damping"):
            continue
        true = quotient(partial(change, kind, name), 1e-3, method="taylor20", tolerance=1e-17)
        error = np.abs(found[..., column] - true).max()
        assert error < 1e-9 * max(1.0, np.abs(true).max()), (name, error)


@pytest.mark.parametrize("kind", ["free", "top"])
def test_without_damping_it_is_the_limit_of_weak_damping(kind: str) -> None:
    at_rest = sensitivity(made(kind), OMEGA, ("damping1", "damping2", "damping3"), t=TIMES)
    for axis in range(3):
        own = f"damping{axis + 1}"
        weak = [
            sensitivity(change(kind, own, by), OMEGA, own, t=TIMES)[..., 0] for by in (1e-5, 2e-5)
        ]
        np.testing.assert_allclose(
            at_rest[..., axis], 2.0 * weak[0] - weak[1], rtol=1e-8, atol=1e-8
        )


# --- Truths --------------------------------------------------------------------------------------


def test_a_damped_sphere() -> None:
    """It turns about a fixed axis at ``w exp(-s)``, by ``w I/D (1 - exp(-s))``, ``s = D t / I``."""
    inertia, damping, t = 0.75, 0.5, np.array([0.5, 4.0])
    sphere = rigid.FreeBody(rigid.Body((inertia,) * 3), damping=damping)
    found = sensitivity(sphere, OMEGA, ("damping", "I1", "I2", "I3"), t=t)
    slowing, left = damping * t / inertia, np.exp(-damping * t / inertia)
    turned = inertia / damping * (1.0 - left)
    by_damping = np.array([-t / inertia * left, (t * left - turned) / damping])
    by_inertia = np.array([slowing / inertia * left, (turned - t * left) / inertia])
    for column, true in ((found[..., 0], by_damping), (found[..., 1:].sum(axis=-1), by_inertia)):
        for part, size in zip((column[:, :3], column[:, 3:]), true, strict=True):
            np.testing.assert_allclose(part, size[:, None] * OMEGA, rtol=1e-13, atol=1e-14)


def test_a_torque_turns_a_body_at_rest() -> None:
    t = np.array([-2.0, 0.5, 4.0])
    body = rigid.FreeBody(rigid.Body(MOMENTS))
    found = sensitivity(body, np.zeros(3), ("torque1", "torque2", "torque3"), t=t)
    for axis, inertia in enumerate(MOMENTS):
        true = np.zeros((3, 6))
        true[:, axis], true[:, 3 + axis] = t / inertia, t**2 / (2.0 * inertia)
        np.testing.assert_allclose(found[..., axis], true, rtol=1e-14, atol=0.0)


@pytest.mark.parametrize("side", [1.0, -1.0], ids=["upright", "hanging"])
def test_a_balanced_top_falls_or_swings_if_its_centre_of_mass_moves(side: float) -> None:
    """``I2 x'' = mgl (1 ± x)`` from rest; the moments matter to nothing that rests."""
    top = rigid.HeavyTop(rigid.Body(MOMENTS), mgl=1.2, com=(0.0, 0.0, side))
    t = np.array([0.5, 6.0])
    run = rigid.simulate(top, np.zeros(3), t=t, tangent=("com1", "com2", "I1", "mgl"))
    found = present(run.sensitivity)
    for column, axis, sign in ((0, 1, 1.0), (1, 0, -1.0)):
        rate = np.sqrt(1.2 / MOMENTS[axis])
        turn = np.cosh(rate * t) - 1.0 if side > 0.0 else 1.0 - np.cos(rate * t)
        slope = rate * (np.sinh(rate * t) if side > 0.0 else np.sin(rate * t))
        true = np.zeros((2, 6))
        true[:, axis], true[:, 3 + axis] = sign * slope, sign * turn
        np.testing.assert_allclose(found[..., column], true, rtol=1e-13, atol=1e-14)
    assert (found[..., 2:] == 0.0).all()


# --- Structure -----------------------------------------------------------------------------------


def random_driven(count: int) -> tuple[rigid.HeavyTop, Floats, Floats, Floats, Floats]:
    """Tops with moments, weight, damping and torque of their own."""
    rng = np.random.default_rng(20261122)
    damping, torque = rng.uniform(0.0, 0.2, (count, 3)), rng.normal(size=(count, 3)) * 0.1
    top, omega, attitude = tops_at_random(
        count, rng, damping=damping, torque=rigid.Torque.body(torque)
    )
    return top, damping, torque, omega, attitude


@pytest.mark.parametrize("method", [None, "rk4", "dop853", "taylor12", "taylor26"])
def test_another_unit_of_mass_changes_no_motion(method: str | None) -> None:
    """``sum p dx/dp = 0`` of moments, weight, damping and torque: exact for every method."""
    top, damping, torque, omega, attitude = random_driven(300)
    run = rigid.simulate(
        top, omega, attitude, t=[1.0, 4.0], tangent=OF_TOP[:10], check=False, method=method
    )
    values = np.concatenate(
        [np.asarray(top.body.moments), damping, torque, np.asarray(top.mgl)[:, None]], axis=1
    )
    parts = present(run.sensitivity) * values[:, None, None]
    size = np.abs(parts).max(axis=(-2, -1)).max(axis=1)
    growth = np.linalg.norm(present(run.tangent), 2, axis=(-2, -1)).max(axis=1)
    assert (
        np.abs(parts.sum(axis=-1)).max(axis=(1, 2)) < 1e-14 * growth * np.maximum(size, 1)
    ).all()


def test_another_unit_of_time_changes_no_motion() -> None:
    """``dx/dw w + 2 mgl dx/dmgl + 2 N dx/dN + D dx/dD - t x' = (w, 0)`` ties it to the tangent."""
    top, damping, torque, omega, attitude = random_driven(300)
    t = np.array([1.0, 4.0])
    run = rigid.simulate(
        top, omega, attitude, t=t, tangent=OF_TOP[3:10], check=False, method="taylor16",
        tolerance=2.0**-53,
    )  # fmt: skip
    values = np.concatenate([damping, 2.0 * torque, 2.0 * np.asarray(top.mgl)[:, None]], axis=1)
    matrices = present(run.tangent)
    by_start = np.einsum("nmij,nj->nmi", matrices[..., :3], omega)
    scaled = by_start + np.einsum("nmik,nk->nmi", present(run.sensitivity), values)
    moments, weight = np.asarray(top.body.moments)[:, None], np.asarray(top.weight)[:, None]
    acting = np.cross(moments * run.omega, run.omega) + np.cross(present(run.gamma), weight)
    rates = (acting + torque[:, None] - damping[:, None] * run.omega) / moments
    flow = np.concatenate([rates, run.omega], axis=-1) * t[:, None]
    now = np.concatenate([run.omega, np.zeros_like(run.omega)], axis=-1)
    growth = np.linalg.norm(matrices, 2, axis=(-2, -1)).max(axis=1)
    assert (np.abs(scaled - flow - now).max(axis=(1, 2)) < 2e-14 * growth).all()


def test_the_columns_of_one_name_are_sums_of_others() -> None:
    top, _, _, omega, attitude = random_driven(50)
    names = ("mgl", "com", "damping", "damping1", "damping2", "damping3")
    run = rigid.simulate(top, omega, attitude, t=[2.0], tangent=names, check=False)
    assert run.parameters == ("mgl", "com1", "com2", "com3", *names[2:])
    found = present(run.sensitivity)
    weights = np.asarray(top.mgl)[:, None, None], np.asarray(top.com)[:, None, None]
    size = np.abs(found).max()
    by_mgl = weights[0] * found[..., 0] - (weights[1] * found[..., 1:4]).sum(axis=-1)
    assert np.abs(by_mgl).max() < 1e-13 * size
    assert np.abs(found[..., 4] - found[..., 5:].sum(axis=-1)).max() < 1e-13 * size


@pytest.mark.parametrize("method", WITH_TANGENT)
@pytest.mark.parametrize("kind", KINDS)
def test_its_order_is_that_of_the_method(method: str, kind: str) -> None:
    order = next(m.order for m in rigid.methods() if m.name == method)
    names, t = names_of(kind), [2.0]
    true = sensitivity(made(kind), OMEGA, names, t=t)
    step = 0.05 if order == 4 else 0.25 if order < 12 else 0.5
    errors = [
        np.abs(
            sensitivity(made(kind), OMEGA, names, t=t, method=method, step=step / k) - true
        ).max()
        for k in (1, 2)
    ]
    assert errors[1] < max(errors[0] * 2.0 ** (1.0 - order), 1e-13)


# --- Interface -----------------------------------------------------------------------------------


def test_a_column_is_that_of_a_run_that_asks_for_no_other() -> None:
    omega = np.random.default_rng(5).normal(size=(2, 3, 3))
    together = sensitivity(made("top"), omega, ("I1", "mgl", "com"), t=TIMES)
    assert together.shape == (2, 3, 4, 6, 5)
    alone = sensitivity(made("top"), omega[1, 2], "mgl", t=TIMES)
    assert alone.tobytes() == np.ascontiguousarray(together[1, 2, ..., 1:2]).tobytes()
    assert sensitivity(made("top"), omega[:0], "mgl", t=[1.0]).shape == (0, 3, 1, 6, 1)


def test_what_is_not_run_has_none() -> None:
    found = sensitivity(made("top"), OMEGA, "mgl", t=[1.0, 1e3], method="rk4", max_steps=20)
    assert np.isnan(found).all()


def test_a_body_that_rests_for_long_takes_few_steps() -> None:
    """What is zero and stays zero has no size that its terms could be small against."""
    hanging = rigid.HeavyTop(rigid.Body(MOMENTS), mgl=1.2, com=(0.0, 0.0, -1.0))
    run = rigid.simulate(
        hanging, np.zeros(3), t=[100.0], tangent="I1", method="taylor16", tolerance=1e-16,
        max_steps=1000, check=False,
    )  # fmt: skip
    assert (present(run.sensitivity) == 0.0).all()


test_bad_names_are_refused = refuses(
    [
        ("top", ("I1", "mgL"), r"tangent = 'mgL': is no parameter; did you mean 'mgl'\? \(known: "),
        ("free", "mgl", r"tangent = 'mgl': a free body has no weight \(known: I1, "),
        ("top", ("com2", "com"), r"tangent = \('com2', 'com'\): 'com2' is named twice"),
        ("top", {"I1"}, r"tangent = {'I1'}: must be True, False or names of parameters"),
        ("top", b"I1", r"tangent = b'I1': must be True, False or names of parameters"),
        ("top", 3, r"tangent = 3: must be True, False or names of parameters"),
        ("top", (), r"tangent = \(\): must be True, False or names of parameters"),
        ("top", (1,), r"tangent = 1: is no parameter"),
    ],
    by=lambda scene, names: sensitivity(made(scene), OMEGA, names, t=[1.0]),
)


def test_an_unknown_method_has_no_tangent_to_miss() -> None:
    with pytest.raises(ValueError, match=r"method = 'taylor15': did you mean 'taylor16'\? must"):
        rigid.simulate(made("top"), OMEGA, t=[1.0], tangent=True, method="taylor15")
