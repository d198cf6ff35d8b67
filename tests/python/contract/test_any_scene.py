"""Whatever valid scene and start: no exception, and finite numbers if the status says so."""

import os
import re
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

import rigid
from physics import METHODS, Floats, angular_momentum, energy, present
from rigid.model.scene import Scene
from rigid.solve.status import ARRIVED

#: The same cases in every run; nothing is written to disk. ``tests/long/any_scene.py`` takes more.
STEADY = settings(
    max_examples=int(os.environ.get("RIGID_EXAMPLES", "25")),
    deadline=None,
    derandomize=True,
    database=None,
    phases=(Phase.generate, Phase.shrink),
    suppress_health_check=(HealthCheck.too_slow,),  # the machine may be slow
)


def decades(low: float, high: float) -> st.SearchStrategy[float]:
    return st.floats(low, high).map(lambda exponent: 10.0**exponent)


@st.composite
def bodies(draw: st.DrawFn) -> rigid.Body:
    """Moments from masses along the axes, as any body has them: ratios up to twelve decades."""
    scale = draw(decades(-20, 20))
    masses = [draw(decades(-12, 0)) for _ in range(3)]
    if draw(st.booleans()):
        masses[draw(st.integers(0, 2))] = 0.0  # flat
    if draw(st.booleans()):
        masses[0] = masses[1]  # symmetric
    if masses.count(0.0) == 2:
        masses[2] = masses[1] = 1.0
    a, b, c = (scale * mass for mass in masses)
    return rigid.Body((b + c, a + c, a + b))


def directions() -> st.SearchStrategy[Floats]:
    vectors = st.lists(st.floats(-1, 1), min_size=3, max_size=3).map(np.array)
    return vectors.filter(lambda v: np.linalg.norm(v) > 1e-3).map(lambda v: v / np.linalg.norm(v))


@st.composite
def scenes(draw: st.DrawFn) -> Scene:
    body = draw(bodies())
    if draw(st.booleans()):
        return rigid.FreeBody(body)
    mgl = draw(st.just(0.0) | decades(-20, 20))
    return rigid.HeavyTop(body, mgl=mgl, com=draw(directions()))


def quaternions() -> st.SearchStrategy[list[float]]:
    components = st.lists(st.floats(-1, 1), min_size=4, max_size=4)
    return components.filter(lambda q: sum(abs(x) for x in q) > 1e-3)


def rates() -> st.SearchStrategy[list[float]]:
    component = st.just(0.0) | st.tuples(st.sampled_from([-1.0, 1.0]), decades(-12, 6)).map(np.prod)
    return st.lists(component.map(float), min_size=3, max_size=3)


def check(run: rigid.Run) -> None:
    values = [run.omega, run.energy_drift, run.momentum_drift, run.unit_drift]
    values += [array for array in (run.gamma, run.attitude) if array is not None]
    drift = max(run.energy_drift, run.momentum_drift, run.unit_drift)
    if run.status in (*ARRIVED, rigid.Status.DRIFTED):
        assert all(np.all(np.isfinite(array)) for array in values)
        assert (run.status == rigid.Status.DRIFTED) == (drift > 0.1)
    elif run.status == rigid.Status.STEP_LIMIT:
        assert all(np.all(np.isnan(array)) for array in values)
    else:
        assert run.status == rigid.Status.NOT_FINITE
        assert not all(np.all(np.isfinite(array)) for array in values)


@pytest.mark.parametrize("method", METHODS, ids=lambda method: method.name)
@STEADY
@given(
    scene=scenes(),
    omega=rates(),
    attitude=quaternions(),
    t=st.lists(st.floats(-100, 100), max_size=5).map(sorted),
    step=st.none() | decades(-3, 3),
    record=st.sampled_from(["rates", "axis", "attitude"]),
)
def test_nothing_raises_and_the_status_is_true(method: rigid.Method, **options: Any) -> None:
    scene, omega, attitude = (options.pop(key) for key in ("scene", "omega", "attitude"))
    run = rigid.simulate(scene, omega, attitude, method=method.name, max_steps=20_000, **options)
    check(run)
    assert run.omega.shape == (len(options["t"]), 3)


@pytest.mark.parametrize("method", METHODS, ids=lambda method: method.name)
@STEADY
@given(scene=scenes(), omega=rates(), attitude=quaternions())
def test_the_default_step_is_short_enough(
    method: rigid.Method, scene: Scene, omega: list[float], attitude: list[float]
) -> None:
    """A thousand default steps, of 1/16 rad at most, keep the invariants to parts in a thousand.

    The time is that of the fastest possible turn, by the energy: omega_k^2 < 2 (T + 2 mgl) / I_k.
    """
    mgl = scene.mgl if isinstance(scene, rigid.HeavyTop) else 0.0
    moments = np.array(scene.body.moments)
    fastest = np.sqrt(2.0 * (energy(scene, omega) + 2.0 * mgl) * (1.0 / moments).sum())
    t = 1000.0 / 16.0 / fastest if fastest > 0.0 else 1.0
    run = rigid.simulate(scene, omega, attitude, t=t, method=method.name)
    # Next to a separatrix rounding decides where the body is; its invariants are kept all the same.
    assert run.status in ARRIVED
    assert run.steps <= 1100
    assert run.energy_drift < 5e-3
    assert run.momentum_drift < 5e-3
    assert run.unit_drift < 1e-3


@STEADY
@given(scene=scenes(), omega=rates(), attitude=quaternions(), step=decades(-3, 3))
def test_splitting_keeps_lengths_whatever_the_step(
    scene: Scene, omega: list[float], attitude: list[float], step: float
) -> None:
    """A hundred steps of any length: rotations, each to a few roundoffs."""
    run = rigid.simulate(scene, omega, attitude, t=100 * step, step=step, method="splitting")
    if run.status in (rigid.Status.STEP_LIMIT, rigid.Status.NOT_FINITE):
        return
    assert run.unit_drift < 1e-12
    assert np.linalg.norm(present(run.attitude)) == pytest.approx(1.0, abs=1e-12)
    if isinstance(scene, rigid.FreeBody):
        start = np.linalg.norm(angular_momentum(scene, omega))
        end = np.linalg.norm(angular_momentum(scene, run.omega[0]))
        assert end == pytest.approx(start, rel=1e-12)


# --- Torque and damping ---------------------------------------------------------------------------


@st.composite
def driven_scenes(draw: st.DrawFn) -> Scene:
    """Torques and damping over twelve decades beside the moments, singular matrices among them."""
    scene = draw(scenes())
    size = max(scene.body.moments)
    axes = np.array([draw(directions()) for _ in range(3)])
    strengths = np.array([draw(st.just(0.0) | decades(-6, 6)) for _ in range(3)])
    damping = draw(
        st.just(0.0)
        | decades(-6, 6).map(lambda c: c * size)
        | st.just(strengths * size)
        | st.just((axes.T * strengths * size) @ axes)
    )
    torque = None
    if draw(st.booleans()):
        make = draw(st.sampled_from([rigid.Torque.body, rigid.Torque.space]))
        value = draw(directions()) * draw(decades(-6, 6)) * size
        if draw(st.booleans()):
            torque = make(
                [value, 0.5 * value, -value], times=[-200.0, draw(st.floats(-9, 9)), 200.0]
            )
        else:
            torque = make(value)
    damping = 0.5 * (damping + np.transpose(damping))
    if isinstance(scene, rigid.HeavyTop):
        return rigid.HeavyTop(
            scene.body, mgl=scene.mgl, com=scene.com, torque=torque, damping=damping
        )
    return rigid.FreeBody(scene.body, torque=torque, damping=damping)


@st.composite
def satellites(draw: st.DrawFn) -> Scene:
    """Rotors, sinks and orbits over twelve decades beside the moments and a rate of one."""
    body = draw(bodies())
    size = max(body.moments)
    rotor = draw(st.none() | decades(-6, 6).map(lambda h: h * size))
    sink = draw(st.none() | decades(-6, 6).map(lambda p: p * size))
    rate = draw(st.none() | decades(-6, 6))
    return rigid.FreeBody(
        body,
        rotor=None if rotor is None else rotor * draw(directions()),
        dissipation=None if sink is None else rigid.EnergySink(sink),
        orbit=None if rate is None else rigid.Orbit(rate, draw(st.floats(0.0, 0.95))),
    )


SATELLITES = ["rk4", "dop853", "taylor12", "taylor16"]
DRIVERS = [m.name for m in METHODS if m.name in SATELLITES] + ["splitting", "etd4", "midpoint"]
OF_METHODS = [*((driven_scenes, name) for name in DRIVERS), *((satellites, m) for m in SATELLITES)]


@pytest.mark.parametrize(("kind", "method"), OF_METHODS)
@STEADY
@given(
    data=st.data(),
    omega=rates(),
    attitude=quaternions(),
    t=st.lists(st.floats(-10, 100), max_size=4).map(sorted),
    step=st.none() | decades(-3, 3),
)
def test_of_driven_bodies_and_of_satellites_the_status_is_true(
    kind: Any, method: str, data: Any, omega: list[float], attitude: list[float], **options: Any
) -> None:
    try:
        run = rigid.simulate(
            data.draw(kind()),
            omega,
            attitude,
            method=method,
            max_steps=20_000,
            check=False,
            **options,
        )
    except ValueError as error:
        # An explicit method beyond its limit of stability.
        if not re.match(r"step = .*unstable under damping", str(error)):
            raise
        return
    if run.status in ARRIVED:
        assert all(np.all(np.isfinite(present(array))) for array in (run.omega, run.attitude))
    else:
        status = rigid.Status
        assert run.status in (status.STEP_LIMIT, status.NOT_FINITE, status.DRIFTED)
