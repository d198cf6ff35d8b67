"""Taylor methods that choose their steps by a tolerance."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import rigid
from physics import present, rotation_angle, tilted
from rigid.solve.methods import series_methods

FREE = rigid.FreeBody(rigid.Body([1.0, 1.6, 2.0]))
TOP = rigid.HeavyTop(rigid.Body([1.0, 1.0, 0.5]), mgl=1.2, com=[0.0, 0.0, 1.0])
OMEGA = [0.4, 0.3, 2.0]


@pytest.mark.parametrize("method", series_methods())
@pytest.mark.parametrize("scene", [FREE, TOP], ids=["free", "top"])
@pytest.mark.parametrize("tolerance", [1e-6, 1e-9, 1e-12])
def test_the_error_stays_below_the_tolerance_a_radian(
    scene: rigid.FreeBody | rigid.HeavyTop, method: str, tolerance: float
) -> None:
    t = np.linspace(-10.0, 20.0, 61)
    truth = rigid.simulate(scene, OMEGA, tilted(0.7), t=t, method="exact")
    run = rigid.simulate(scene, OMEGA, tilted(0.7), t=t, method=method, tolerance=tolerance)
    error = rotation_angle(present(run.attitude), present(truth.attitude))
    # The body turns at some 3 rad/s; rounding leaves 1e-14.
    assert np.all(error < tolerance * (1.0 + 3.0 * np.abs(t)) + 1e-14 * (1.0 + np.abs(t)))
    assert run.status == rigid.Status.FINISHED
    assert run.spec["tolerance"] == tolerance
    assert run.plan.step is None
    assert f"each body takes its own steps, last terms below {tolerance:g}" in run.plan.why


def test_a_smaller_tolerance_takes_more_steps_and_more_times_take_none() -> None:
    options: dict[str, Any] = {"method": "taylor16"}
    coarse, fine = (
        rigid.simulate(FREE, OMEGA, t=[20.0], tolerance=tolerance, **options)
        for tolerance in (1e-6, 1e-14)
    )
    assert 0 < coarse.steps < fine.steps
    often = rigid.simulate(FREE, OMEGA, t=np.linspace(0, 20, 500), tolerance=1e-14, **options)
    assert often.steps == fine.steps
    assert often.omega[-1].tobytes() == fine.omega[-1].tobytes()


@pytest.mark.parametrize("method", [None, "exact", "rk4", "splitting"])
def test_only_series_choose_their_steps(method: str | None) -> None:
    with pytest.raises(
        ValueError, match=f"tolerance = 1e-09, method = {method!r}: only 'taylor12'"
    ):
        rigid.simulate(FREE, OMEGA, t=[1.0], method=method, tolerance=1e-9)


@pytest.mark.parametrize("other", ["step", "accuracy"])
def test_a_tolerance_excludes_a_step_and_an_accuracy(other: str) -> None:
    options: dict[str, Any] = {other: 1e-3}
    with pytest.raises(ValueError, match=f"{other} = 0.001: exclude each other"):
        rigid.simulate(FREE, OMEGA, t=[1.0], method="taylor12", tolerance=1e-9, **options)


@pytest.mark.parametrize("tolerance", [0.0, -1e-9, np.nan, np.inf, 1.0])
def test_what_is_no_tolerance(tolerance: float) -> None:
    with pytest.raises(ValueError, match=r"tolerance = .*must be"):
        rigid.simulate(FREE, OMEGA, t=[1.0], method="taylor12", tolerance=tolerance)
