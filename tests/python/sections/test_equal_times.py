"""Sections of equal times: states at the multiples of a period."""

from __future__ import annotations

from pathlib import Path

import numpy as np

import rigid
from planar_moons import MOMENTS, planar
from refusals import refuses

TOP = rigid.HeavyTop(rigid.Body((1.0, 1.6, 0.7)), mgl=1.2, com=(0.6, 0.0, 0.8))


def test_a_symmetric_free_body_comes_back_in_each_period_of_its_rates() -> None:
    """In the body the rates go round axis 3 at ``(I3 - I1) w3 / I1``."""
    body, omega = rigid.Body((1.0, 1.0, 1.5)), np.array([[0.3, 0.0, 1.2], [0.0, -0.1, 0.8]])
    for start in omega:
        period = 2.0 * np.pi / (0.5 * start[2])
        points = rigid.poincare(body, start, every=period, t_end=20.5 * period)
        assert len(points) == 20
        # 20 periods of some 10 rad, each to rounding, and 2e-16 of the period in each.
        np.testing.assert_allclose(points.omega, [start] * 20, atol=1e-13)
        momentum = np.array(body.moments) * start
        np.testing.assert_allclose(points.gamma @ momentum, np.full(20, momentum[2]), atol=1e-12)


def test_points_are_the_states_of_a_run() -> None:
    starts = np.array([[0.3, 0.4, 1.0], [0.1, 0.2, 2.0]])
    points = rigid.poincare(TOP, starts, every=0.7, t_end=7.0)
    assert repr(points) == "<Crossings: 20 points of 2 bodies, every 0.7 s; complete>"
    t = 0.7 * np.arange(1, 11)
    run = rigid.simulate(TOP, starts, t=t, method="dop853", step=0.01, check=False)
    assert run.gamma is not None
    # The errors of the other method.
    np.testing.assert_allclose(points.omega, run.omega.reshape(-1, 3), atol=1e-9)
    np.testing.assert_allclose(points.gamma, run.gamma.reshape(-1, 3), atol=1e-9)
    np.testing.assert_array_equal(points.t, np.tile(t, 2))
    np.testing.assert_array_equal(points.body, np.repeat([0, 1], 10))
    assert (points.attitude[:, 0] >= 0.0).all()
    assert (points.error < 1e-11).all()
    assert points.reasons() == ("complete: 10 points until t = 7 s",) * 2
    np.testing.assert_array_equal(
        rigid.poincare(TOP, starts[0], every=0.7, t_end=7.0, count=3).omega, points.omega[:3]
    )


def test_a_moon_at_each_periapsis_is_that_of_its_equation() -> None:
    """Angle and rate of the long axis, as in figure 2 of Wisdom, Peale and Mignard (1984)."""
    e, turns = 0.1, 12
    orbit = rigid.Orbit(1.0, e)
    moon = rigid.FreeBody(rigid.Body(MOMENTS), orbit=orbit)
    rates = np.array([0.9, 1.3, 1.5, 2.4])
    starts = np.stack([0.0 * rates, 0.0 * rates, rates], axis=-1)
    period = float(orbit.period)
    end = turns * period
    points = rigid.poincare(moon, starts, every=period, t_end=end)
    assert points.complete.all()
    angle, rate = points.component("angle1"), points.omega[:, 2]
    for k, start in enumerate(rates):
        # Angles and rates between times of SciPy, by its own dense polynomial: to 1e-9.
        t, theta, _ = planar(0.0, start, e, end, count=turns + 1)
        np.testing.assert_allclose(points.t[points.body == k], t[1:], rtol=1e-15)
        off = (angle[points.body == k] - theta[1:] + np.pi) % (2.0 * np.pi) - np.pi
        np.testing.assert_allclose(off, 0.0, atol=1e-7)
    # The rates by the same equation, as differences of angles a thousandth later.
    later = np.array([planar(0.0, one, e, end, count=turns * 4000 + 1)[1] for one in rates])
    step = end / (turns * 4000)
    each = later[:, 4000::4000], later[:, 3999::4000][:, :turns], later[:, 3998::4000][:, :turns]
    slopes = (3.0 * each[0] - 4.0 * each[1] + each[2]) / (2.0 * step)
    np.testing.assert_allclose(rate, slopes.ravel(), atol=1e-5)
    # An orbit for each body turns the angle of each by its own frame.
    both = rigid.FreeBody(moon.body, orbit=rigid.Orbit(1.0, [e, e], [0.0, np.pi]))
    each_own = rigid.poincare(both, starts[0], every=period, t_end=20.0)
    assert each_own.component("angle1")[:3].tolist() == angle[:3].tolist()
    assert abs(each_own.component("angle1")[3] - angle[0]) > 0.1


def test_a_body_that_was_not_run_is_not_complete(tmp_path: Path) -> None:
    points = rigid.poincare(TOP, [0.3, 0.4, 1.0], every=1.0, t_end=9.0, max_steps=2, check=False)
    assert not points.complete
    assert len(points) == 0
    assert points.reasons()[0].startswith("step limit")
    saved = np.load(points.save(tmp_path / "points.npz"))
    assert '"name": "every"' in str(saved["spec"])


test_equal_times_that_are_none = refuses(
    [
        ({"every": 0.0}, r"every = 0\.0: must be positive"),
        ({"every": 8.0}, r"every = 8: must not be above t_end = 7"),
        ({"every": 1.0, "section": "gamma3"}, "section = 'gamma3': leave it out beside every"),
    ],
    by=lambda more: rigid.poincare(TOP, [0.3, 0.4, 1.0], t_end=7.0, **more),
)
