"""Bodies that something moves from rest, slows to rest, or hardly touches at all."""

from typing import Any

import numpy as np
import pytest

import rigid
from refusals import refuses

SPHERE = rigid.Body((1.0, 1.0, 1.0))
BOX = rigid.Body((1.0, 1.2, 1.5))
METHODS = ("rk4", "taylor16", "etd4", "splitting", "midpoint")


def test_from_rest_a_series_follows_the_torque_and_not_the_start() -> None:
    """A start at rest has no rate to compare with: the one that the torque leads to serves."""
    scene = rigid.FreeBody(rigid.Body((1.0, 2.0, 2.5)), torque=rigid.Torque.body((0.1, 0.2, 0.3)))
    options: dict[str, Any] = {"t": np.linspace(0.0, 50.0, 11), "method": "taylor16"}
    rates = rigid.simulate(scene, [0.0] * 3, record="rates", tolerance=1e-15, **options)
    attitude = rigid.simulate(scene, [0.0] * 3, step=0.01, **options)
    np.testing.assert_allclose(rates.omega, attitude.omega, atol=1e-12)
    hardly = rigid.simulate(scene, [1e-40, 0.0, 0.0], record="rates", tolerance=1e-15, **options)
    assert hardly.steps <= 1.1 * rates.steps


@pytest.mark.parametrize("method", METHODS)
def test_a_slew_from_rest_to_rest_is_no_drift(method: str) -> None:
    """Half forward, half back: `(N t²/2) 2` turned, and nothing left but rounding of the peak."""
    there_and_back = rigid.Torque.body(
        [(1, 0, 0), (1, 0, 0), (-1, 0, 0), (-1, 0, 0)], times=[0.0, 2.0, 2.0, 4.0]
    )
    run: Any = rigid.simulate(
        rigid.FreeBody(BOX, torque=there_and_back), [0.0] * 3, t=[0.0, 4.0], method=method
    )
    assert run.status == rigid.Status.OK
    assert np.abs(run.omega[-1]).max() < 1e-14
    assert run.energy_drift < 1e-13
    # Constant torque about a principal axis: exact for all methods but those of order 2.
    slack = 1e-3 if method in ("splitting", "midpoint") else 1e-6
    np.testing.assert_allclose(
        np.abs(run.attitude[-1]), [abs(np.cos(2.0)), np.sin(2.0), 0.0, 0.0], atol=slack
    )


@pytest.mark.parametrize("method", METHODS)
def test_a_pulse_that_damping_stops_again_is_no_drift(method: str) -> None:
    pulse = rigid.Torque.body(
        [(1, 0, 0), (1, 0, 0), (0, 0, 0), (0, 0, 0)], times=[0.0, 1.0, 1.0, 60.0]
    )
    scene = rigid.FreeBody(BOX, damping=(1.0, 1.2, 1.5), torque=pulse)
    for start in ([0.0] * 3, [1e-9, 0.0, 0.0]):
        run = rigid.simulate(scene, start, t=[60.0], method=method)
        assert run.status == rigid.Status.OK, run.reasons()


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_entering_a_side_under_a_torque_is_no_flip(sign: float) -> None:
    start, stable = rigid.Start(omega=(0.0, 0.0, 1.0)), rigid.no_flip(1)
    options: dict[str, Any] = {"axes": {"omega3": [0.0, 1.0]}, "samples": 2, "rng": 1}
    for torque in (rigid.Torque.body((sign * 0.3, 0, 0)), rigid.Torque.space((sign * 0.3, 0, 0))):
        scene = rigid.FreeBody(rigid.Body((1.1, 1.7, 2.3)), torque=torque)
        result = rigid.stability_map(scene, start=start, stable=stable, t_end=0.5, **options)
        assert result.share.tolist() == [1.0, 1.0]


def test_backward_in_time_a_damped_body_is_fast_and_its_error_is_stated() -> None:
    """`1.3 (e^{ct} - 1)/c` turned: the phase is rounded, and the statement grows with it."""
    scene = rigid.FreeBody(SPHERE, damping=0.1)
    run = rigid.simulate(scene, [0.0, 0.0, 1.3], t=[-200.0])
    assert run.error > 1e-6  # 13 e^20 rad at 1e-15 each
    lost = rigid.simulate(scene, [0.0, 0.0, 1.3], t=[-300.0])
    assert lost.status == rigid.Status.FLAGGED
    assert lost.lost_from < 0.0


def test_upright_at_rest_small_deviations_grow_for_ever() -> None:
    """As ``e^t``, times a number near one from the units: the linear equations know no size."""
    top = rigid.HeavyTop(rigid.Body((1.0, 1.2, 0.5)), mgl=1.0)
    times = np.array([20.0, 40.0, 50.0])
    found = rigid.condition(top, [0.0] * 3, t=times)
    np.testing.assert_allclose(found, np.exp(times), rtol=0.1)


@pytest.mark.parametrize(
    "scene",
    [
        rigid.HeavyTop(rigid.Body((1.0, 2.0, 3.0)), mgl=0.0),
        rigid.HeavyTop(rigid.Body((1.0, 2.0, 3.0)), mgl=1e-20),
        rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0)), damping=1e-25),
    ],
    ids=["no weight", "hardly weight", "hardly damped"],
)
def test_next_to_a_separatrix_what_hardly_acts_hides_nothing(scene: rigid.FreeBody) -> None:
    run = rigid.simulate(scene, [1e-13, 1.0, 1e-13], t=[200.0], method="rk4")
    assert run.status == rigid.Status.FLAGGED


def test_resting_bodies_under_damping_have_every_accuracy() -> None:
    run = rigid.simulate(rigid.FreeBody(BOX, damping=1.0), [0.0] * 3, t=[1.0], accuracy=1e-9)
    assert run.reasons() == ("ok",)


def test_the_map_layer_knows_of_damping_that_differs_by_pixel() -> None:
    top = rigid.HeavyTop(rigid.Body((1.0, 1.2, 0.5)), mgl=1.0)
    start, stable = rigid.Start(spin=3.0, attitude_noise=rigid.normal(1e-2)), rigid.tilt_below(0.5)
    options: dict[str, Any] = {"axes": {"damping3": [0.0, 5.0]}, "samples": 2, "rng": 3}
    result = rigid.stability_map(top, start=start, stable=stable, t_end=10.0, **options)
    body = result.replay(1, 0, t=[0.0])
    damped = rigid.HeavyTop(top.body, mgl=1.0, damping=(0.0, 0.0, 5.0))
    alone = rigid.condition(damped, body.omega, body.attitude, t=[10.0])
    assert result.condition(1)[1] == pytest.approx(alone[0], rel=1e-4)


test_what_is_refused = refuses(
    [
        (lambda: rigid.Torque.body(np.zeros((0, 3)), times=[]), "a table has at least two times"),
        (lambda: rigid.Torque.body([(0, 0, 1)] * 2, times=[0, 2]).at(np.nan), "t = nan: must be"),
        (
            lambda: rigid.plan(
                rigid.FreeBody(BOX, torque=rigid.Torque.body([(0, 0, 1)] * 2, times=[0, 2])),
                "attitude",
                omega=[0, 0, 1.0],
                t_end=5.0,
            ),
            "t = 5: the table of the torque does not reach",
        ),
    ],
)
