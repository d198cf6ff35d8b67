"""What a motion keeps: energy, momentum, lengths, and the way back."""

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import rigid
from physics import (
    METHODS,
    ROUNDOFF,
    Floats,
    angular_momentum,
    energy,
    gamma_of,
    golden_scene,
    present,
    rotation_angle,
    telling,
    tilted,
)
from rigid.model.scene import Scene

MILLION = 1_000_000
START = tilted(1.0)

#: Scene, rates at the start, step: turns of 0.02 to 0.1 rad a step. None has an axis of symmetry.
ASYMMETRIC: dict[str, tuple[Scene, tuple[float, float, float], float]] = {
    "free": (rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0))), (1.0, 0.5, -0.8), 0.05),
    "middle axis": (rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0))), (0.01, 1.0, 0.02), 0.05),
    "box": (rigid.FreeBody(rigid.Body.box(0.25, 0.08, 0.01)), (0.05, 1.0, 0.05), 0.02),
    "top": (
        rigid.HeavyTop(rigid.Body((1.0, 1.5, 2.0)), mgl=3.0, com=(0.6, 0.0, 0.8)),
        (0.5, 1.0, 0.8),
        0.02,
    ),
}

SYMMETRIC: dict[str, tuple[Scene, tuple[float, float, float], float]] = {
    "free": (rigid.FreeBody(rigid.Body((1.0, 1.0, 2.0))), (0.3, 1.0, 0.2), 0.01),
    "sphere": (rigid.FreeBody(rigid.Body((1.0, 1.0, 1.0))), (0.3, 1.0, 0.2), 0.01),
    "top": (rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0), (0.0, 0.2, 5.0), 0.02),
}


@cache
def million_steps(
    method: str, scene: Scene, rates: tuple[float, float, float], step: float
) -> rigid.Run:
    """States at 4000 random steps out of a million: equal intervals would beat with the motion."""
    chosen = np.sort(np.random.default_rng(1).choice(MILLION, 4000, replace=False)) + 1
    chosen[-1] = MILLION
    run = rigid.simulate(scene, rates, START, t=chosen * step, step=step, method=method)
    assert run.steps == MILLION
    return run


def energy_error(scene: Scene, run: rigid.Run, omega: Floats) -> Floats:
    gamma = None if isinstance(scene, rigid.FreeBody) else gamma_of(START)
    start = energy(scene, omega, gamma)
    return (energy(scene, run.omega, run.gamma) - start) / energy(scene, omega)


@dataclass
class Trend:
    """Straight line through block means: a mean hides the correlation within its block."""

    slope: float
    standard_error: float
    correlation: float  #: of the residuals of neighbouring blocks; near 0 if the error is honest


def trend(t: Floats, error: Floats, blocks: int = 40) -> Trend:
    x = t.reshape(blocks, -1).mean(axis=1)
    y = error.reshape(blocks, -1).mean(axis=1)
    x -= x.mean()
    slope = x @ y / (x @ x)
    residual = y - y.mean() - slope * x
    variance = residual @ residual / (blocks - 2) / (x @ x)
    correlation = residual[1:] @ residual[:-1] / (residual @ residual)
    return Trend(float(slope), float(np.sqrt(variance)), float(correlation))


@pytest.mark.parametrize("name", ASYMMETRIC)
def test_splitting_energy_is_bounded_without_drift_over_a_million_steps(name: str) -> None:
    scene, rates, step = ASYMMETRIC[name]
    omega = np.array(rates)
    run = million_steps("splitting", scene, rates, step)
    error = energy_error(scene, run, omega)
    line = trend(run.t, error)
    assert abs(line.correlation) < 0.4, "blocks too short for the standard error"
    assert abs(line.slope) < 3.0 * line.standard_error
    # And the standard error is small: the drift of the whole run hides within 3 % of the wobble.
    wobble = np.ptp(error)
    assert line.standard_error * run.t[-1] < 0.03 * wobble
    # The last tenth reaches no further than the first.
    assert np.ptp(error[-400:]) < 1.1 * np.ptp(error[:400])


def test_the_drift_of_rk4_is_seen_by_the_same_eyes() -> None:
    scene, rates, step = ASYMMETRIC["free"]
    omega = np.array(rates)
    run = million_steps("rk4", scene, rates, step)
    line = trend(run.t, energy_error(scene, run, omega))
    assert line.slope < -100.0 * line.standard_error


def lengths(scene: Scene, run: rigid.Run, omega: Floats) -> dict[str, Floats]:
    """Relative deviations of what has a constant length."""
    found = {"q": np.linalg.norm(present(run.attitude), axis=-1) - 1.0}
    if run.gamma is not None:
        found["gamma"] = np.linalg.norm(run.gamma, axis=-1) - 1.0
    if isinstance(scene, rigid.FreeBody):
        start = np.linalg.norm(angular_momentum(scene, omega))
        found["L"] = np.linalg.norm(angular_momentum(scene, run.omega), axis=-1) / start - 1.0
    return found


@pytest.mark.parametrize("name", ASYMMETRIC)
def test_splitting_keeps_lengths_to_rounding_over_a_million_steps(name: str) -> None:
    """Five rotations a step by ever new angles: the rounding of lengths is a random walk.

    A rotation rounds its cosine, sine and four products: one roundoff of the length. Four
    standard deviations of 5e6 such steps are 1e-12; measured: 1e-13 to 2e-13. A bias of one percent
    of a roundoff a rotation would show.
    """
    scene, rates, step = ASYMMETRIC[name]
    omega = np.array(rates)
    run = million_steps("splitting", scene, rates, step)
    for what, deviation in lengths(scene, run, omega).items():
        assert np.abs(deviation).max() < 4.0 * ROUNDOFF * np.sqrt(5.0 * MILLION), what


@pytest.mark.parametrize("name", SYMMETRIC)
def test_rotor_keeps_lengths_to_a_roundoff_a_step(name: str) -> None:
    """A symmetric body turns by the same angles in all steps, and each rounds the same way.

    So the lengths err in proportion to the steps, two rotations a step of at most about two
    roundoffs each; measured: up to half a roundoff a step.
    """
    scene, rates, step = SYMMETRIC[name]
    omega = np.array(rates)
    run = million_steps("splitting", scene, rates, step)
    for what, deviation in lengths(scene, run, omega).items():
        assert np.abs(deviation).max() < 4.0 * ROUNDOFF * MILLION, what


REVERSAL = ["free_asymmetric/generic", "heavy_asymmetric/regular_tumbling", "lagrange/monotone"]


@pytest.mark.parametrize("identifier", REVERSAL)
@pytest.mark.parametrize("method", METHODS, ids=lambda method: method.name)
def test_a_reversible_method_finds_the_way_back(method: rigid.Method, identifier: str) -> None:
    """Forward to the end, and from there as far into the past."""
    case = golden_scene(identifier)
    end, step = float(case.t[3]), telling(0.02, method)
    options: dict[str, Any] = {"step": step, "method": method.name}
    there = rigid.simulate(case.scene, case.omega0, case.attitude0, t=end, **options)
    back = rigid.simulate(case.scene, there.omega[0], present(there.attitude)[0], t=-end, **options)
    assert back.steps == there.steps
    start = case.attitude0 / np.linalg.norm(case.attitude0)
    missed = max(
        np.linalg.norm(back.omega[0] - case.omega0) / np.linalg.norm(case.omega0),
        float(rotation_angle(present(back.attitude)[0], start)),
    )
    # Rounding of 2 x steps of a dozen operations each, a random walk, times the condition.
    condition = max(case.kappa_omega[:4].max(), case.kappa_att[:4].max())
    rounding = 5.0 * ROUNDOFF * condition * np.sqrt(24.0 * float(there.steps))
    if method.reversible:
        assert missed < rounding
    elif method.order <= 4:  # above, what is missing may be below rounding
        assert missed > 100.0 * rounding, "better than it says"


@pytest.mark.parametrize("table", [ASYMMETRIC, SYMMETRIC], ids=["asymmetric", "symmetric"])
@pytest.mark.parametrize("method", METHODS, ids=lambda method: method.name)
def test_the_group_is_preserved_as_stated(
    method: rigid.Method, table: dict[str, tuple[Scene, tuple[float, float, float], float]]
) -> None:
    for scene, rates, short in table.values():
        omega, step = np.array(rates), telling(5.0 * short, method)
        run = rigid.simulate(scene, omega, START, t=2000 * step, step=step, method=method.name)
        worst = max(np.abs(d).max() for d in lengths(scene, run, omega).values())
        if method.group_preserving:
            assert worst < 4.0 * ROUNDOFF * 2000
        elif method.order <= 4:
            assert worst > 100.0 * ROUNDOFF * 2000, "better than it says"


@pytest.mark.parametrize("method", METHODS, ids=lambda method: method.name)
def test_a_free_body_conserves_with_long_steps_what_is_stated(method: rigid.Method) -> None:
    """Momentum in space and energy, in 500 steps, to a few roundings a step."""
    scene, rates, _ = ASYMMETRIC["free"]
    moments, omega = np.array(scene.body.moments), np.array(rates)
    step = (0.5 if method.conserves else 0.15) / float(np.linalg.norm(omega))
    options = {"step": step, "method": method.name, "check": False}
    run = rigid.simulate(scene, omega, START, t=[0.0, 500 * step], **options)  # type: ignore[arg-type]
    attitude = Rotation.from_quat(present(run.attitude), scalar_first=True)
    momentum = attitude.apply(moments * run.omega)
    energy = 0.5 * np.sum(moments * run.omega**2, axis=1)
    for name, value in (("momentum", momentum), ("energy", energy)):
        changed = np.linalg.norm(value[1] - value[0]) / np.linalg.norm(value[0])
        if name in method.conserves:
            assert changed < 20.0 * ROUNDOFF * 500
        elif method.order <= 4:
            assert changed > 100.0 * ROUNDOFF * 500, "better than it says"


@pytest.mark.parametrize("scene_name", ASYMMETRIC)
@pytest.mark.parametrize("method", METHODS, ids=lambda method: method.name)
def test_reported_drifts_are_those_of_the_returned_states(
    method: rigid.Method, scene_name: str
) -> None:
    scene, rates, _ = ASYMMETRIC[scene_name]
    omega, t = np.array(rates), np.linspace(0.0, 40.0, 41)
    run = rigid.simulate(scene, omega, START, t=t, step=0.1, method=method.name)
    attitude = present(run.attitude)
    kinetic, momentum = energy(scene, omega), angular_momentum(scene, omega)
    if isinstance(scene, rigid.HeavyTop):
        # The vertical is carried beside the attitude, and the worse of the two is reported.
        gammas = [present(run.gamma), gamma_of(attitude)]
        drifts = [
            energy(scene, run.omega, g) - energy(scene, omega, gamma_of(START)) for g in gammas
        ]
        energy_drift = np.abs(drifts).max() / (kinetic + scene.mgl)
        along = [(angular_momentum(scene, run.omega) * g).sum(axis=-1) for g in gammas]
        reach = np.sqrt(scene.mgl * max(scene.body.moments))
        momentum_drift = np.abs(np.array(along) - momentum @ gamma_of(START)).max()
        momentum_drift /= np.linalg.norm(momentum) + reach
    else:
        energy_drift = np.abs(energy(scene, run.omega) / kinetic - 1.0).max()
        length = np.linalg.norm(angular_momentum(scene, run.omega), axis=-1)
        momentum_drift = np.abs(length / np.linalg.norm(momentum) - 1.0).max()
    units = [attitude] if run.gamma is None else [attitude, run.gamma]
    unit_drift = max(np.abs(np.linalg.norm(v, axis=-1) - 1.0).max() for v in units)
    # The core forms |L| from |L|^2, of which the drift is the first order; the rest is rounding.
    rounding = 20.0 * ROUNDOFF
    assert run.energy_drift == pytest.approx(energy_drift, rel=1e-9, abs=rounding)
    assert run.momentum_drift == pytest.approx(
        momentum_drift, rel=2.0 * momentum_drift + 1e-9, abs=rounding
    )
    assert run.unit_drift == pytest.approx(unit_drift, rel=1e-9, abs=rounding)
    if method.name == "rk4":
        assert min(run.energy_drift, run.momentum_drift, run.unit_drift) > 1e-9


def test_what_is_not_carried_has_no_drift() -> None:
    options: dict[str, Any] = {"t": 9.0, "step": 0.2, "record": "rates"}
    free, top = (
        rigid.simulate(ASYMMETRIC[name][0], [1.0, 2.0, 3.0], **options) for name in ("free", "top")
    )
    assert free.unit_drift == 0.0
    assert free.energy_drift > 0.0
    with pytest.raises(ValueError, match="'rates': the potential energy of a top needs its vert"):
        top.energy()


@pytest.mark.parametrize("method", ["rk4", "taylor16", "midpoint"])
@pytest.mark.parametrize("damping", [0.0, 0.3])
def test_stated_errors_know_no_unit_of_mass(method: str, damping: float) -> None:
    """Of tops just released, whose rates are small beside those of their swing."""

    def error(mass: float) -> float:
        body = rigid.Body(mass * np.array([1.0, 1.5, 2.0]))
        top = rigid.HeavyTop(body, mgl=3.0 * mass, com=(0.6, 0.0, 0.8), damping=damping * mass)
        run = rigid.simulate(top, np.zeros(3), START, t=[1e-3, 1e-2], method=method, step=0.01)
        return float(run.error)

    plain = error(1.0)
    assert 0.0 < plain < 1e-3
    assert [error(2.0**power) for power in (-40, 40)] == [plain, plain]
