"""What is not asked for is not carried, and the rates do not notice: the same bits."""

from __future__ import annotations

import numpy as np
import pytest

import rigid
from physics import METHODS, Floats, gamma_of, present
from rigid.model.scene import Scene

SCENES: dict[str, Scene] = {
    "free": rigid.FreeBody(rigid.Body((1.0, 1.5, 2.0))),
    "free symmetric about 1": rigid.FreeBody(rigid.Body((1.0, 1.5, 1.5))),
    "free symmetric about 3": rigid.FreeBody(rigid.Body((1.0, 1.0, 0.5))),
    "sphere": rigid.FreeBody(rigid.Body((1.0, 1.0, 1.0))),
    "top": rigid.HeavyTop(rigid.Body((2.0, 1.5, 1.0)), mgl=3.0, com=(0.48, -0.64, 0.6)),
    "symmetric top": rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=3.0),
    "symmetric body off its axis": rigid.HeavyTop(
        rigid.Body((2.0, 2.0, 1.0)), mgl=3.0, com=(1.0, 0.0, 0.0)
    ),
}

EVERY = [
    pytest.param(method, scene, id=f"{method.name}-{name}")
    for method in METHODS
    for name, scene in SCENES.items()
]


def starts(n: int) -> tuple[Floats, Floats]:
    rng = np.random.default_rng(7)
    return 2.0 * rng.standard_normal((n, 3)), rng.standard_normal((n, 4))


def run(scene: Scene, method: str, record: str, step: float | None) -> rigid.Run:
    omega, attitude = starts(11)
    t = [-3.0, -0.5, 0.0, 1.0, 4.0]
    return rigid.simulate(scene, omega, attitude, t=t, method=method, record=record, step=step)


def follows_from_attitude(method: rigid.Method, scene: Scene) -> bool:
    """Whether the vertical of a top follows from the quaternion: in Runge-Kutta steps."""
    return method.name in ("rk4", "dop853") and isinstance(scene, rigid.HeavyTop)


@pytest.mark.parametrize("step", [None, 0.03])
@pytest.mark.parametrize(("method", "scene"), EVERY)
def test_rates_are_the_same_bits_whatever_else_is_asked(
    method: rigid.Method, scene: Scene, step: float | None
) -> None:
    rates, axis, attitude = (
        run(scene, method.name, record, step) for record in ("rates", "axis", "attitude")
    )
    assert rates.omega.tobytes() == axis.omega.tobytes()
    if follows_from_attitude(method, scene):
        # Another error of the method: order 4, 0.1 rad a step, some turns.
        assert attitude.omega == pytest.approx(rates.omega, abs=1e-3)
    else:
        assert attitude.omega.tobytes() == rates.omega.tobytes()
    assert np.array_equal(rates.steps, axis.steps)
    assert np.array_equal(rates.steps, attitude.steps)


@pytest.mark.parametrize(("method", "scene"), EVERY)
def test_what_was_not_asked_for_is_not_there(method: rigid.Method, scene: Scene) -> None:
    rates, axis, attitude = (
        run(scene, method.name, record, None) for record in ("rates", "axis", "attitude")
    )
    assert rates.gamma is None
    assert rates.attitude is None
    assert axis.gamma is not None
    assert axis.attitude is None
    assert attitude.attitude is not None
    if follows_from_attitude(method, scene):
        assert gamma_of(attitude.attitude) == pytest.approx(present(attitude.gamma), abs=2e-15)
    elif isinstance(scene, rigid.HeavyTop):
        assert axis.gamma.tobytes() == present(attitude.gamma).tobytes()
    else:
        # A free body has it from the attitude; carried alone it has another error of the method.
        assert attitude.gamma is None
        assert gamma_of(attitude.attitude) == pytest.approx(axis.gamma, abs=1e-4)


def test_no_rotation_without_attitude() -> None:
    with pytest.raises(ValueError, match="record = 'attitude' was not asked for"):
        run(SCENES["free"], "rk4", "rates", None).rotation()
