"""The error of a run falls as the step to the order that the method states."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import ArrayLike, NDArray

import rigid
from physics import (
    EVERY_METHOD,
    METHODS,
    ROUNDOFF,
    Golden,
    angular_momentum,
    golden,
    golden_scene,
    present,
    rotation_angle,
    rotation_matrix,
)
from rigid.model.scene import Scene

#: Scene, the time up to which it runs, and the largest of the six steps. At that step the leading
#: term of the error rules (the body turns by about 0.1 to 0.3 rad a step), and the error of the
#: shortest step, 1/32 of it, is still 20 times above the rounding plateau of rk4, some 1e-14 times
#: the angle turned: hence the short times.
REGIMES = [
    ("free_asymmetric/generic", 17.0, 0.1),
    ("free_asymmetric/axis2", 17.0, 0.2),
    ("lab_box/axis2_1rad_1e-1", 10.0, 0.1),
    ("heavy_asymmetric/regular_tumbling", 10.0, 0.05),
    ("lagrange/monotone", 1.0, 0.02),
    ("kovalevskaya/kov_a", 7.0, 0.1),
]

HALVINGS = 0.5 ** np.arange(6)


def errors(identifier: str, method: str, until: float, step: float) -> tuple[float, float]:
    """Root mean square over the reference times: at a single one the error could vanish."""
    case = golden_scene(identifier)
    run: Any = case.run(method, until=until, step=step)
    m = len(run.t)
    of_rates = np.linalg.norm(run.omega - case.omega[:m], axis=-1)
    of_attitude = rotation_angle(run.attitude, case.attitude[:m])
    return float(np.sqrt(np.mean(of_rates**2))), float(np.sqrt(np.mean(of_attitude**2)))


def slope(steps: ArrayLike, error: ArrayLike) -> float:
    return float(np.polyfit(np.log(steps), np.log(error), 1)[0])


def fitted_order(identifier: str, method: rigid.Method, until: float) -> float:
    """Order of a method that reaches rounding within a few halvings.

    The steps divide the time to the last reference. ``log error = c + p log h + b h^2`` is fitted
    where the error lies between 1e-10 and 5e-13: so few powers of two that the next term of the
    error, b, must be known.
    """
    case = golden_scene(identifier)
    last = int(np.flatnonzero(case.t <= until)[-1])
    steps, found, count = [], [], 2
    while True:
        step = case.t[last] / count
        run = rigid.simulate(
            case.scene, case.omega0, case.attitude0, t=case.t[last], method=method.name, step=step
        )
        of_rates = float(np.linalg.norm(run.omega[0] - case.omega[last]))
        of_attitude = float(rotation_angle(present(run.attitude)[0], case.attitude[last]))
        error = float(np.hypot(of_rates, of_attitude))
        if error < 5e-13:
            break
        if error < 1e-10:
            steps.append(step)
            found.append(error)
        count = int(np.ceil(count * 2.0 ** (0.5 / method.order)))
    assert len(steps) >= 8
    h = np.array(steps)
    terms = np.column_stack([np.ones_like(h), np.log(h), h * h])
    order: float = np.linalg.lstsq(terms, np.log(found), rcond=None)[0][1]
    return order


LOW = [method for method in METHODS if method.order <= 4]
# The orders of the Taylor series are measured in single steps, by the tests of the core.
HIGH = [m for m in METHODS if m.order > 4 and not m.series]


@pytest.mark.parametrize(("identifier", "until", "largest"), REGIMES)
@pytest.mark.parametrize("method", LOW, ids=lambda method: method.name)
def test_measured_order_is_the_stated_order(
    method: rigid.Method, identifier: str, until: float, largest: float
) -> None:
    steps = largest * HALVINGS
    table = np.array([errors(identifier, method.name, until, float(step)) for step in steps])
    assert slope(steps, table[:, 0]) == pytest.approx(method.order, abs=0.1), "rates"
    assert slope(steps, table[:, 1]) == pytest.approx(method.order, abs=0.1), "attitude"


# The leading term of the others is so small that it does not rule above rounding.
@pytest.mark.parametrize(("identifier", "until", "largest"), REGIMES[1:5])
@pytest.mark.parametrize("method", HIGH, ids=lambda method: method.name)
def test_measured_order_of_methods_of_high_order(
    method: rigid.Method, identifier: str, until: float, largest: float
) -> None:
    assert fitted_order(identifier, method, until) == pytest.approx(method.order, abs=0.1)


SYMMETRIC = [c for c in golden("free_symmetric") if c.scene.body.symmetry_axis is not None]


@pytest.mark.parametrize("case", SYMMETRIC, ids=lambda case: case.id)
def test_splitting_of_the_free_symmetric_body_is_exact_for_any_step(case: Golden) -> None:
    """One step from each reference time to the next, whatever lies between."""
    run: Any = case.run("splitting", step=float(case.t[-1]))
    assert run.steps == len(case.t) - 1
    # Rounding: the condition of the problem, and of each of the steps so far the same again.
    floor = 4.0 * ROUNDOFF * (1.0 + np.arange(len(case.t)))
    of_rates = np.linalg.norm(run.omega - case.omega, axis=-1)
    assert np.all(of_rates <= floor * case.kappa_omega * np.linalg.norm(case.omega, axis=-1))
    assert np.all(rotation_angle(run.attitude, case.attitude) <= floor * case.kappa_att)


def test_bodies_that_are_symmetric_but_for_rounding_are_not_rounded_to_symmetric_ones() -> None:
    """The table of a body follows from its moments to the bit; nearly symmetric ones are split."""
    case = golden_scene("free_symmetric/near_sym_1e-12")
    coarse, fine = (case.run("splitting", step=step) for step in (0.1, 0.05))
    error = [np.abs(run.omega - case.omega).max() for run in (coarse, fine)]
    assert error[0] / error[1] == pytest.approx(4.0, abs=0.1)


# Trajectories known to 25 digits: free bodies, tops and pendulums of all kinds


FAMILIES = [
    "free_asymmetric",
    "free_symmetric",
    "lab_box",
    "lagrange",
    "pendulum",
    "kovalevskaya",
    "heavy_asymmetric",
]

#: Starts off an unstable turn by little or nothing, and exact relative to that little. A step
#: rounds relative to the whole, and 1e-16 of the whole grows to everything within these runs,
#: or (1e-3, 1e-1) to a thousand times what the condition numbers of the inputs say.
UNSTABLE = {
    "free_asymmetric/sep_w1_1e-3",
    "free_asymmetric/sep_w1_1e-6",
    "free_asymmetric/sep_w1_1e-10",
    "free_asymmetric/sep_w1_1e-12",
    "free_asymmetric/sep_w3_1e-6",
    "free_asymmetric/sep_exact",
    "lab_box/axis2_1rad_1e-10",
    "lab_box/axis2_10rad_1e-10",
    "lab_box/axis2_10rad_1e-1",
    "lagrange/waking_1e-8",
    "pendulum/planar_near_sep",
}

CASES = [case for family in FAMILIES for case in golden(family) if case.id not in UNSTABLE]


#: The series of all orders are one loop: two of them follow every fifth trajectory.
FOLLOWED = [
    pytest.param(method, case, id=f"{method.name}-{case.id}")
    for method in METHODS
    for case in (CASES[::5] if method.name in ("taylor12", "taylor26") else CASES)
]


@pytest.mark.parametrize(("method", "case"), FOLLOWED)
def test_the_error_is_the_one_that_halving_the_step_reveals(
    method: rigid.Method, case: Golden
) -> None:
    """And rounding.

    With an error c h^p, runs of steps h and h/2 differ by (2^p - 1) times the error of the finer
    one. Twice that is granted: c is not the same at every time. Inputs rounded by one part in 2^53
    cost the condition number kappa; some operations a step, in a random walk, cost more; the rotor
    of a symmetric body rounds alike in every step. Chaotic motion is followed as long as an error
    grows less than ten thousand times.
    """
    until = case.t[np.maximum(case.kappa_omega, case.kappa_att) < 1e4].max()
    # From order 16 on, steps of 0.025 rad leave rounding alone; four times longer ones nearly so.
    step = case.step_turning(0.1 if method.order >= 16 else 0.025)
    # The errors that runs state themselves are tested over the same trajectories elsewhere.
    options = {"until": until, "check": False}
    coarse, fine = (case.run(method.name, step=h, **options) for h in (step, step / 2))
    m = len(fine.t)
    # Next to a separatrix a state may be right and yet flagged.
    assert {int(coarse.status), int(fine.status)} <= {rigid.Status.UNCHECKED, rigid.Status.FLAGGED}
    rotor = method.name == "splitting" and case.scene.body.symmetry_axis is not None
    steps = float(fine.steps)
    rounding = ROUNDOFF * (10.0 * np.sqrt(steps) + (0.1 * steps if rotor else 0.0))
    share = 2.0 / (2.0**method.order - 1.0)

    scale = np.linalg.norm(case.omega[:m], axis=-1).max()
    error = np.linalg.norm(fine.omega - case.omega[:m], axis=-1).max()
    revealed = np.linalg.norm(coarse.omega - fine.omega, axis=-1).max()
    allowed = share * revealed + rounding * scale * (1.0 + case.kappa_omega[:m].max())
    assert error <= allowed

    angle = rotation_angle(present(fine.attitude), case.attitude[:m]).max()
    revealed = rotation_angle(present(coarse.attitude), present(fine.attitude)).max()
    turned = share * revealed + rounding * (1.0 + case.kappa_att[:m].max())
    assert angle <= turned

    # Momentum in space: of the same attitude and rates, so off by no more than both.
    momentum = (
        rotation_matrix(present(fine.attitude))
        @ angular_momentum(case.scene, fine.omega)[..., None]
    )
    off = np.linalg.norm(momentum[..., 0] - case.L_space[:m], axis=-1).max()
    length = np.linalg.norm(case.L_space[:m], axis=-1).max()
    assert off <= length * turned + max(case.scene.body.moments) * allowed


# Names of axes, mirrors and turns of space change no motion: the rates to the bit


Floats = NDArray[np.float64]
Change = Callable[[Scene, Floats, Floats], tuple[Scene, Floats, Floats]]

ULP = np.finfo(np.float64).eps
STEP = 1.0 / 32.0
BODIES = 60


def _scene(scene: Scene, moments: Floats, com: Floats) -> Scene:
    body = rigid.Body(moments.tolist())
    if isinstance(scene, rigid.HeavyTop):
        return rigid.HeavyTop(body, mgl=scene.mgl, com=com.tolist())
    return rigid.FreeBody(body)


def _com(scene: Scene) -> Floats:
    return np.array(scene.com if isinstance(scene, rigid.HeavyTop) else (0.0, 0.0, 1.0))


def renamed(scene: Scene, omega: Floats, attitude: Floats) -> tuple[Scene, Floats, Floats]:
    """The axes of body and space have each other's names."""
    turned = np.concatenate([attitude[..., :1], np.roll(attitude[..., 1:], 1, axis=-1)], axis=-1)
    moments = np.roll(scene.body.moments, 1)
    return _scene(scene, moments, _com(scene)), np.roll(omega, 1, axis=-1), turned


def mirrored(scene: Scene, omega: Floats, attitude: Floats) -> tuple[Scene, Floats, Floats]:
    """Body and space in a mirror across the first axis: rates are axial vectors."""
    signs = np.array([1.0, -1.0, -1.0])
    com = _com(scene) * [-1.0, 1.0, 1.0]
    return _scene(scene, np.array(scene.body.moments), com), omega * signs, attitude * [1.0, *signs]


def turned_in_the_body(
    scene: Scene, omega: Floats, attitude: Floats
) -> tuple[Scene, Floats, Floats]:
    """The second and the third axis of the body point backward: half a turn."""
    signs = np.array([1.0, -1.0, -1.0])
    w, x, y, z = np.moveaxis(attitude, -1, 0)
    return (
        _scene(scene, np.array(scene.body.moments), _com(scene) * signs),
        omega * signs,
        np.stack([-x, w, z, -y], axis=-1),
    )


def turned_in_space(scene: Scene, omega: Floats, attitude: Floats) -> tuple[Scene, Floats, Floats]:
    """Half a turn about the vertical."""
    w, x, y, z = np.moveaxis(attitude, -1, 0)
    return scene, omega, np.stack([-z, -y, x, w], axis=-1)


SCENES: dict[str, Scene] = {
    "free": rigid.FreeBody(rigid.Body((1.0, 1.3, 1.9))),
    "symmetric": rigid.FreeBody(rigid.Body((1.3, 1.3, 1.9))),
    "top": rigid.HeavyTop(rigid.Body((1.0, 1.3, 1.9)), mgl=1.2, com=(0.6, 0.0, -0.8)),
    "lagrange": rigid.HeavyTop(rigid.Body((1.3, 1.3, 0.7)), mgl=1.2),
}
TOPS = ("top", "lagrange")
CHANGES = (renamed, mirrored, turned_in_the_body, turned_in_space)


def differences(name: str, change: Change, t: list[float], **options: Any) -> tuple[Floats, Floats]:
    """Of rates and attitudes, between the changed motions and the motions of the changed starts.

    In units of the last place of the largest rate of the body, and of 1.
    """
    rng = np.random.default_rng(len(name))
    omega, attitude = rng.standard_normal((BODIES, 3)), rng.standard_normal((BODIES, 4))
    attitude /= np.linalg.norm(attitude, axis=1)[:, None]
    scene, *start = change(SCENES[name], omega, attitude)
    plain = rigid.simulate(SCENES[name], omega, attitude, t=t, check=False, **options)
    other = rigid.simulate(scene, *start, t=t, check=False, **options)
    _, rates, attitudes = change(SCENES[name], plain.omega, present(plain.attitude))
    found = present(other.attitude)
    # A quaternion and its opposite are one attitude.
    signs = np.sign(np.sum(found * attitudes, axis=-1, keepdims=True))
    last_place = ULP * np.abs(rates).max(axis=(1, 2), keepdims=True)
    return np.abs(other.omega - rates) / last_place, np.abs(found - signs * attitudes) / ULP


def is_meant(name: str, change: Change, tops: bool) -> bool:
    """Weight knows the vertical, and not every method knows weight."""
    return name not in TOPS or (tops and change is not renamed)


@pytest.mark.parametrize(
    ("method", "name", "change"),
    [
        (method.name, name, change)
        for method in EVERY_METHOD
        for name in SCENES
        for change in CHANGES
        if is_meant(name, change, method.tops)
    ],
)
def test_a_step_knows_neither_names_nor_mirrors(method: str, name: str, change: Change) -> None:
    rates, attitudes = differences(name, change, [STEP], method=method, step=STEP)
    turned_top = name in TOPS and change in (turned_in_the_body, turned_in_space)
    assert rates.max() <= (4.0 if turned_top else 0.0)
    assert attitudes.max() <= 4.0


@pytest.mark.parametrize(
    ("name", "change"),
    [
        *((name, change) for name in ("free", "symmetric") for change in CHANGES),
        ("lagrange", mirrored),
    ],
)
def test_a_closed_form_knows_neither_names_nor_mirrors(name: str, change: Change) -> None:
    rates, attitudes = differences(name, change, [-2.0, 0.5, 30.0], method="exact")
    assert not rates.any()
    assert attitudes.max() <= 4.0
