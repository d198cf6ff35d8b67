"""Maps on an orbit alone, in steps of its eccentric anomaly, against short steps in the time."""

from typing import Any

import numpy as np
import pytest

import rigid
from rigid.model.criterion import Criterion
from rigid.model.measures import Measure
from small_maps import small_map

MOMENTS = (0.9, 1.2, 1.4)

#: Limits that some bodies pass.
CRITERIA: dict[str, Criterion] = {
    "no flip": rigid.no_flip(3),
    "tilt": rigid.tilt_below(0.6, axis=3, reference="vertical"),
    "pointing": rigid.pointing_within(1.0, 1, "radial", either=True),
    "along": rigid.pointing_within(1.3, 2, "along", either=True),
    "libration": rigid.librates(1),
    "spin": rigid.spin_above(0.4, axis=3),
    "speed": rigid.spin_above(0.5),
    "rates in the body": rigid.rate_within(0.8, frame="body"),
    "rates in space": rigid.rate_within(0.9),
    "momentum": rigid.rate_within(0.6, of="L"),
    "start": rigid.near_start(1.5),
    "return": rigid.returns(1.0, 10.0),
}


#: A damping that is lost in every sum needs all variables, and steps in the time.
IN_TIME: dict[str, Any] = {"damping": 1e-300, "method": "dop853", "step": 0.02}


def mapped(
    e: float, stable: Criterion, method: str, damping: Any = None, **options: Any
) -> rigid.StabilityMap:
    scene = rigid.FreeBody(
        rigid.Body(MOMENTS), orbit=rigid.Orbit(0.7, e, 1.1, normal=(0.0, 0.6, 0.8)), damping=damping
    )
    chosen: dict[str, Any] = {
        "axes": {"t_end": [30.0]},
        "start": rigid.Start(
            omega=(0.1, 0.2, 0.8), noise=rigid.normal(0.3), attitude_noise=rigid.uniform_attitude()
        ),
        "samples": 48,
        "check": 0.0,
    }
    return small_map(scene, stable=stable, method=method, **{**chosen, **options})


@pytest.mark.parametrize("e", [0.0, 0.3])
@pytest.mark.parametrize("name", CRITERIA)
def test_bodies_leave_when_they_do_in_the_time(name: str, e: float) -> None:
    exact = mapped(e, CRITERIA[name], **IN_TIME).outcomes(range(48))
    assert (exact.outcome[0] == "unstable").sum() > 8
    for method in ("auto", "dop853"):
        found = mapped(e, CRITERIA[name], method).outcomes(range(48))
        np.testing.assert_array_equal(found.outcome, exact.outcome)
        # Default steps err by 1e-8 rad for each rad, by default; tumbling magnifies that.
        allowed = 1e-4 if method == "auto" else 1e-8
        np.testing.assert_allclose(found.left, exact.left, rtol=0.0, atol=allowed)


def test_a_chosen_dop853_is_checked_by_half_its_steps() -> None:
    """Each run of a body takes whole blocks of 16 steps."""
    first, both = (
        int(mapped(0.3, CRITERIA["libration"], "dop853", check=check).columns["steps"].sum())
        for check in (0.0, 1.0)
    )
    assert 2 * first - 48 * 2 * 16 < both - first <= 2 * first


@pytest.mark.parametrize("e", [0.0, 0.3])
@pytest.mark.parametrize(
    "measure",
    [
        rigid.mean_rate(axis=2),
        rigid.spin_orbit_ratio(axis=3),
        rigid.obliquity(axis=3),
        rigid.libration_amplitude(axis=1),
        rigid.largest_tilt(axis=3, reference="vertical"),
        rigid.flips(axis=3),
    ],
    ids=str,
)
def test_measures_are_those_in_the_time(measure: Measure, e: float) -> None:
    options: dict[str, Any] = {"measure": [measure], "axes": {"t_end": [12.0]}}
    exact = mapped(e, rigid.no_flip(3), **IN_TIME, **options).outcomes(range(48))
    found = mapped(e, rigid.no_flip(3), "dop853", **options).outcomes(range(48))
    (one,), (same,) = exact.measures.values(), found.measures.values()
    # An angle near pi has half of its digits.
    far = np.abs(np.asarray(one) - np.pi) > 1e-3
    np.testing.assert_allclose(np.asarray(same)[far], np.asarray(one)[far], rtol=1e-7, atol=1e-7)


def test_a_body_that_becomes_faster_than_its_bound_begins_again() -> None:
    """Slow bodies at the apoapsis of a flat orbit: the periapsis spins some of them up."""
    scene = rigid.FreeBody(rigid.Body((0.4, 0.9, 1.0)), orbit=rigid.Orbit(1.0, 0.9, 3.0))
    result = small_map(
        scene,
        axes={"t_end": [60.0]},
        start=rigid.Start(omega=(0.0, 0.0, 0.0), attitude_noise=rigid.uniform_attitude()),
        stable=rigid.no_flip(1),
        measure=[rigid.mean_rate(axis=3)],
        samples=64,
        check=0.0,
        method="auto",
    )
    assert not result.failed.any()
    # The length of the quaternion of a body whose steps are too long shrinks.
    assert (result.unit_drift < 1e-5).all()


def test_a_map_on_an_orbit_says_how_it_steps() -> None:
    result = mapped(0.3, rigid.no_flip(3), "auto", check=1.0)
    assert result.plan.method == "dop853"
    assert "cross-checked by dop853" in result.summary()


def test_drifts_are_those_of_the_jacobi_integral() -> None:
    circle, ellipse = (mapped(e, rigid.no_flip(3), "auto") for e in (0.0, 0.3))
    assert (circle.energy_drift < 1e-5).all()
    assert (circle.energy_drift > 0.0).all()
    assert np.isnan(ellipse.energy_drift).all()
    assert np.isnan(circle.momentum_drift).all()
