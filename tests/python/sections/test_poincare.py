"""Poincaré sections: every point and no other, whatever else is in the call."""

import inspect
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.optimize import minimize

import rigid
from physics import METHODS, Floats
from planar_moons import MOMENTS, planar
from refusals import refuses
from rigid.rotations import quaternion_to_matrix
from rigid.sections.starts import least_energy
from section_scenes import SECTIONED, Sectioned

ASYMMETRIC = rigid.HeavyTop(rigid.Body((1.0, 1.6, 0.7)), mgl=1.2, com=(0.6, 0.0, 0.8))
KOVALEVSKAYA = rigid.HeavyTop(rigid.Body((2.0, 2.0, 1.0)), mgl=1.0, com=(1.0, 0.0, 0.0))
LAGRANGE = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0, com=(0.0, 0.0, 1.0))
GORYACHEV = rigid.HeavyTop(rigid.Body((4.0, 4.0, 1.0)), mgl=1.0, com=(1.0, 0.0, 0.0))
BOX = rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0)))
RATES = [0.3, 0.4, 1.0]

SERIES = [method.name for method in METHODS if method.series]


def energy(top: rigid.HeavyTop, points: rigid.Crossings) -> Floats:
    kinetic = 0.5 * np.sum(np.array(top.body.moments) * points.omega**2, axis=1)
    return np.asarray(kinetic + points.gamma @ np.reshape(top.weight, 3))


def l_gamma(top: rigid.HeavyTop, points: rigid.Crossings) -> Floats:
    return np.asarray(np.sum(np.array(top.body.moments) * points.omega * points.gamma, axis=1))


def points_of(known: Sectioned, **options: Any) -> rigid.Crossings:
    start = known.omega0, known.attitude0
    return rigid.poincare(known.scene, *start, known.section, t_end=known.t_end, **options)


@pytest.mark.parametrize("known", SECTIONED, ids=lambda known: known.name)
def test_every_point_of_26_digits_and_no_other(known: Sectioned) -> None:
    found = points_of(known)
    assert len(found) == len(known.t)
    # What limits a point is not the section but the motion, which magnifies the rounding of its
    # start and of its steps by its condition: up to 2e6 = exp(lambda t) of the chaotic one, up to
    # 1e4 of the others. Four roundings: half an ulp in each of seven numbers of the start, and
    # those of some hundred steps, a random walk. Over the slope it is an error of the time.
    condition = np.maximum.accumulate(
        rigid.condition(known.scene, known.omega0, known.attitude0, t=known.t)
    )
    share = 4.0 * np.finfo(float).eps * condition
    fastest = float(np.linalg.norm(known.scene.weight)) / min(known.scene.body.moments)
    rate = np.sqrt(np.sum(known.omega0**2) + fastest)
    scale = 1.0 if any(known.section.gamma) else rate
    late = share * scale / np.abs(known.slope)
    np.testing.assert_array_less(np.abs(found.t - known.t), late)
    np.testing.assert_array_less(np.abs(found.omega - known.omega).max(axis=1), rate * share)
    np.testing.assert_array_less(np.abs(found.gamma - known.gamma).max(axis=1), share)
    np.testing.assert_array_equal(found.direction, known.direction)
    bent = scale * rate * (share + rate * late)
    np.testing.assert_array_less(np.abs(found.slope - known.slope), bent)
    # So, of a motion that is not chaotic, every number is known to 1e-10, and here of that one too.
    assert late.max() < (1e-8 if known.name == "section-w4-chaotic" else 1e-10)
    np.testing.assert_allclose(found.t, known.t, rtol=0.0, atol=1e-10)
    np.testing.assert_allclose(found.omega, known.omega, rtol=0.0, atol=1e-10)
    np.testing.assert_allclose(found.gamma, known.gamma, rtol=0.0, atol=1e-10)
    assert bool(found.complete)
    assert not found.grazing.any()
    assert (found.error < 1e-9).all()
    assert (np.abs(found.t - known.t) <= found.error + 1e-13).all()
    vertical = quaternion_to_matrix(found.attitude)[:, 2]
    np.testing.assert_allclose(vertical, found.gamma, rtol=0.0, atol=1e-12)


@pytest.mark.parametrize("method", SERIES)
@pytest.mark.parametrize("known", SECTIONED, ids=lambda known: known.name)
def test_every_series_finds_the_same_points(known: Sectioned, method: str) -> None:
    found = points_of(known, method=method, tolerance=1e-14, check=False)
    assert len(found) == len(known.t)
    # A tolerance of 1e-14, magnified up to 2e6 times.
    np.testing.assert_allclose(found.t, known.t, rtol=0.0, atol=2e-8)


def test_a_longer_tolerance_misses_no_close_pair() -> None:
    known = next(known for known in SECTIONED if known.name == "section-close-pairs")
    found = points_of(known, tolerance=1e-10)
    assert np.diff(found.t)[0] == pytest.approx(5.7673e-3, rel=1e-3)
    assert len(found) == 4


def test_a_component_that_only_touches_its_value_grazes() -> None:
    # The polhode about axis 3 touches the largest |omega1| in every period.
    omega = np.array([0.3, 0.2, 1.5])
    quantities = rigid.exact.free_body(BOX, omega)
    period = float(quantities.period)
    top = float(quantities.amplitude[0])
    ends = {}
    for shift in (-1e-6, 0.0, 1e-6):
        found = rigid.poincare(
            BOX,
            omega,
            section=rigid.section("omega1", value=top + shift, direction=0),
            t_end=5.5 * period,
        )
        ends[shift] = found
    assert len(ends[1e-6]) == 0
    assert bool(ends[1e-6].complete)
    assert not ends[-1e-6].grazing.any()
    assert bool(ends[-1e-6].complete)
    touching = ends[0.0]
    assert touching.grazing.all()
    assert not bool(touching.complete)
    # Each maximum is one point, or the two crossings that rounding makes of it.
    groups = np.split(touching.t, np.flatnonzero(np.diff(touching.t) > 0.1 * period) + 1)
    assert len(groups) in (5, 6)
    assert len(ends[-1e-6]) == 2 * len(groups)
    np.testing.assert_allclose(np.diff([group[0] for group in groups]), period, atol=1e-5)
    assert "grazes" in touching.reasons()[0]


def test_rising_and_falling_points_are_those_of_both() -> None:
    both, rising, falling = (
        rigid.poincare(
            ASYMMETRIC,
            RATES,
            section=rigid.section("gamma1", 0.2, direction),
            t_end=60.0,
        )
        for direction in (0, 1, -1)
    )
    assert len(both) == len(rising) + len(falling) > 20
    np.testing.assert_array_equal(both.t[both.direction > 0], rising.t)
    np.testing.assert_array_equal(both.t[both.direction < 0], falling.t)
    # They alternate, as crossings of a surface do.
    assert (both.direction[1:] == -both.direction[:-1]).all()
    assert (both.slope * both.direction > 0.0).all()


def test_heights_turn_highest_or_lowest() -> None:
    com = np.array([0.6, 0.0, 0.8])
    highest = rigid.poincare(ASYMMETRIC, RATES, t_end=50.0)
    lowest = rigid.poincare(ASYMMETRIC, RATES, section=rigid.section(direction=1), t_end=50.0)
    t = np.linspace(0.0, 50.0, 5001)
    height = np.asarray(rigid.simulate(ASYMMETRIC, RATES, t=t).gamma) @ com
    inner = height[1:-1]
    for points, turns in (
        (highest, (inner > height[:-2]) & (inner > height[2:])),
        (lowest, (inner < height[:-2]) & (inner < height[2:])),
    ):
        np.testing.assert_allclose(points.t, t[1:-1][turns], atol=0.01)
    assert (highest.slope < 0.0).all()
    assert (lowest.slope > 0.0).all()


def test_a_plane_of_vectors_is_the_component() -> None:
    named, plane = (
        rigid.poincare(ASYMMETRIC, RATES, section=section, t_end=90.0)
        for section in (
            rigid.section("omega2", 0.1),
            rigid.section(omega=(0.0, 1.0, 0.0), value=0.1),
        )
    )
    np.testing.assert_array_equal(named.t, plane.t)
    np.testing.assert_array_equal(named.component("t"), named.t)
    assert len(named) > 5


def test_points_keep_the_constants_of_the_motion() -> None:
    omega, attitude = rigid.top.on_surface(ASYMMETRIC, 2.0, 0.4, count=12, rng=3)
    points = rigid.poincare(ASYMMETRIC, omega, attitude, t_end=300.0)
    # Rounding of some thousand steps, as a random walk.
    np.testing.assert_allclose(energy(ASYMMETRIC, points), 2.0, rtol=0.0, atol=1e-13)
    np.testing.assert_allclose(l_gamma(ASYMMETRIC, points), 0.4, rtol=0.0, atol=1e-13)
    np.testing.assert_allclose(np.linalg.norm(points.gamma, axis=1), 1.0, atol=1e-13)
    rate = np.cross(points.gamma, points.omega) @ np.array([0.6, 0.0, 0.8])
    np.testing.assert_allclose(rate, 0.0, atol=1e-13)
    assert points.energy_drift.max() < 1e-13
    assert points.complete.all()


def test_a_start_on_the_surface_is_no_point() -> None:
    omega, attitude = rigid.top.on_surface(KOVALEVSKAYA, 1.5, 0.5, count=20, rng=5)
    points = rigid.poincare(KOVALEVSKAYA, omega, attitude, t_end=20.0)
    assert points.t.min() > 0.1


@pytest.mark.parametrize(
    ("top", "level", "momentum", "constant"),
    [
        (LAGRANGE, 2.0, 0.5, lambda w, n: w[:, 2]),
        (
            KOVALEVSKAYA,
            1.5,
            0.5,
            lambda w, n: np.abs((w[:, 0] + 1j * w[:, 1]) ** 2 - (n[:, 0] + 1j * n[:, 1])) ** 2,
        ),
        (
            GORYACHEV,
            1.5,
            0.0,
            lambda w, n: w[:, 2] * (w[:, 0] ** 2 + w[:, 1] ** 2) - w[:, 0] * n[:, 2],
        ),
    ],
    ids=["Lagrange", "Kovalevskaya", "Goryachev-Chaplygin"],
)
def test_points_of_an_integrable_motion_lie_on_its_curve(
    top: rigid.HeavyTop,
    level: float,
    momentum: float,
    constant: Callable[[Floats, Floats], Floats],
) -> None:
    omega, attitude = rigid.top.on_surface(top, level, momentum, count=8, rng=1)
    points = rigid.poincare(top, omega, attitude, t_end=400.0)
    assert points.complete.all()
    found = constant(points.omega, points.gamma)
    run: Any = rigid.simulate(top, omega, attitude, t=[0.0])
    start = constant(run.omega[:, 0], run.gamma[:, 0])
    # Rounding of some thousand steps; Goryachev's and Chaplygin's only grows on that level.
    np.testing.assert_allclose(found, start[points.body], rtol=0.0, atol=1e-11)
    assert (np.bincount(points.body) > 30).all()


def test_every_maximum_of_a_lagrange_top_has_one_height() -> None:
    omega, attitude = rigid.top.on_surface(LAGRANGE, 2.0, 0.5, count=6, rng=2)
    points = rigid.poincare(LAGRANGE, omega, attitude, t_end=200.0)
    for body in range(6):
        heights = points.gamma[points.body == body, 2]
        np.testing.assert_allclose(heights, heights[0], atol=1e-12)
        # One maximum a nutation, and the periods are those of the cubic.
        known = rigid.top.heavy_constants(LAGRANGE, omega[body], attitude[body])
        constants: Any = {name: getattr(known, name) for name in ("a", "b", "alpha", "beta")}
        period = rigid.top.nutation_period(**constants)
        np.testing.assert_allclose(
            np.diff(points.t[points.body == body]), float(period), rtol=1e-11
        )


def test_a_free_body_crosses_a_vertical_of_space() -> None:
    omega = [0.3, 0.2, 1.5]
    points = rigid.poincare(
        BOX, omega, [0.9, 0.1, 0.2, 0.3], section=rigid.section("gamma1"), t_end=50.0
    )
    exact: Any = rigid.simulate(BOX, omega, [0.9, 0.1, 0.2, 0.3], t=points.t, method="exact")
    vertical = quaternion_to_matrix(exact.attitude)[:, 2]
    np.testing.assert_allclose(vertical, points.gamma, atol=1e-12)
    np.testing.assert_allclose(vertical[:, 0], 0.0, atol=1e-12)
    t = np.linspace(0.0, 50.0, 20001)
    dense: Any = rigid.simulate(BOX, omega, [0.9, 0.1, 0.2, 0.3], t=t, method="exact")
    gamma1 = quaternion_to_matrix(dense.attitude)[:, 2, 0]
    assert len(points) == np.count_nonzero((gamma1[:-1] < 0.0) & (gamma1[1:] >= 0.0))


def test_torque_and_damping_act_on_the_way_to_a_section() -> None:
    values = [[0.1, 0.0, 0.0], [0.0, 0.2, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]]
    torque = rigid.Torque.body(values, times=[0.0, 7.0, 15.0, 41.0])
    top = rigid.HeavyTop(
        rigid.Body((1.0, 1.6, 0.7)), mgl=1.2, com=(0.6, 0.0, 0.8), torque=torque, damping=0.01
    )
    points = rigid.poincare(top, RATES, t_end=40.0)
    run = rigid.simulate(top, RATES, t=points.t, method="taylor16")
    np.testing.assert_allclose(run.omega, points.omega, atol=1e-9)
    assert run.gamma is not None
    np.testing.assert_allclose(run.gamma, points.gamma, atol=1e-9)
    t = np.linspace(0.0, 40.0, 8001)
    height = np.asarray(rigid.simulate(top, RATES, t=t).gamma) @ np.array([0.6, 0.0, 0.8])
    peaks = (height[1:-1] > height[:-2]) & (height[1:-1] > height[2:])
    assert len(points) == np.count_nonzero(peaks)


def test_points_that_are_reported_on_are_the_same() -> None:
    omega = np.random.default_rng(1).normal(size=(70, 3))
    points, told = (
        rigid.poincare(ASYMMETRIC, omega, t_end=30.0, progress=progress)
        for progress in (None, lambda _: None)
    )
    np.testing.assert_array_equal(points.t, told.t)
    assert (np.diff(points.body) >= 0).all()


def test_a_count_ends_each_body() -> None:
    rng = np.random.default_rng(2)
    omega = rng.normal(size=(5, 3))
    whole = rigid.poincare(ASYMMETRIC, omega, t_end=100.0)
    some = rigid.poincare(ASYMMETRIC, omega, t_end=100.0, count=4)
    assert (np.bincount(some.body) == 4).all()
    for body in range(5):
        first = whole.t[whole.body == body][:4]
        np.testing.assert_array_equal(some.t[some.body == body], first)
        assert some.end[body] == first[-1]
    assert (whole.end == 100.0).all()


def test_a_motion_on_the_surface_stays_there() -> None:
    # Steady precession of an upright spin: the height never changes.
    points = rigid.poincare(LAGRANGE, [0.0, 0.0, 5.0], t_end=10.0)
    assert len(points) == 0
    assert bool(points.stays)
    assert not bool(points.complete)
    assert "stays on the surface" in points.reasons()[0]


def test_a_body_at_rest_crosses_nothing() -> None:
    points = rigid.poincare(BOX, [0.0, 0.0, 0.0], section=rigid.section("gamma1", 0.5), t_end=9.0)
    assert len(points) == 0
    assert bool(points.complete)


def test_the_error_covers_the_difference_from_a_sharper_run() -> None:
    loose = rigid.poincare(ASYMMETRIC, RATES, t_end=40.0, tolerance=1e-9)
    sharp = rigid.poincare(ASYMMETRIC, RATES, t_end=40.0)
    assert len(loose) == len(sharp)
    off = np.abs(loose.t - sharp.t)
    assert 1e-12 < off.max() < 1e-3
    assert (off <= 3.0 * loose.error).all()


def test_the_error_covers_points_whose_two_runs_agree_by_chance() -> None:
    # Fast tops are regular; a third method knows their points to rounding too. Where the run and
    # its check agreed by chance, the error was that of the time alone, a sixth of the truth.
    rng = np.random.default_rng(11)
    fast = np.concatenate([0.3 * rng.normal(size=(40, 2)), rng.uniform(8.0, 12.0, (40, 1))], axis=1)
    points = rigid.poincare(ASYMMETRIC, fast, section="gamma1", t_end=12.0)
    third = rigid.poincare(
        ASYMMETRIC, fast, section="gamma1", t_end=12.0, method="taylor26", tolerance=1e-17
    )
    off = np.abs(points.t - third.t)
    assert len(off) > 400
    assert (off <= points.error).all()
    assert points.error.max() < 1e-12


@pytest.mark.parametrize("power", [-265, 250])
def test_the_unit_of_time_does_not_matter(power: int) -> None:
    # Powers of two change no digit while all products are normal numbers: those of the smaller
    # unit are not, whose mgl has a square below all doubles.
    unit = 2.0**power
    known = rigid.poincare(ASYMMETRIC, RATES, t_end=30.0)
    top = rigid.HeavyTop(rigid.Body((1.0, 1.6, 0.7)), mgl=1.2 * unit * unit, com=(0.6, 0.0, 0.8))
    found = rigid.poincare(top, unit * np.array(RATES), t_end=30.0 / unit)
    rtol = 0.0 if power > 0 else 1e-13
    np.testing.assert_allclose(found.t * unit, known.t, rtol=rtol)
    np.testing.assert_allclose(found.gamma, known.gamma, rtol=rtol, atol=rtol)
    assert bool(found.complete)


def test_points_of_a_chaotic_motion_are_lost_at_last() -> None:
    points = rigid.poincare(ASYMMETRIC, RATES, [0.9, 0.3, 0.2, 0.1], t_end=400.0)
    # Its exponent is 0.31: rounding grows to 1e-3 in about 100 s.
    assert 60.0 < float(points.lost_from) < 250.0
    assert points.status == rigid.Status.FLAGGED
    assert bool(points.complete)
    assert "the points belong to a motion close by" in points.reasons()[0]


def test_too_many_steps_and_overflow_have_a_status() -> None:
    points = rigid.poincare(ASYMMETRIC, [RATES, [0.3, 0.4, 1e120]], t_end=1e5, max_steps=100)
    assert points.status.tolist() == [rigid.Status.STEP_LIMIT] * 2
    assert not points.complete.any()
    assert points.end[0] < 1e3


def test_sections_maps_and_growth_stop_after_as_many_steps_as_motions() -> None:
    asked = (rigid.poincare, rigid.lyapunov, rigid.MapSpec)
    limits = {inspect.signature(one).parameters["max_steps"].default for one in asked}
    assert limits == {10**9}
    assert "Default: 10**9;" in (rigid.simulate.__doc__ or "")


def test_leading_axes_of_bodies_are_kept() -> None:
    omega = np.random.default_rng(4).normal(size=(2, 3, 3))
    points = rigid.poincare(ASYMMETRIC, omega, t_end=10.0)
    assert points.complete.shape == points.status.shape == (2, 3)
    assert points.body.max() == 5
    assert [len(row) for row in points.reasons()] == [3, 3]


def test_a_picture_shows_every_point() -> None:
    points = rigid.poincare(ASYMMETRIC, [RATES, [0.1, 0.2, 2.0]], t_end=50.0)
    ax = points.plot("gamma1", "omega3")
    (drawn,) = ax.collections
    np.testing.assert_array_equal(
        np.asarray(drawn.get_offsets()), np.stack([points.gamma[:, 0], points.omega[:, 2]], axis=1)
    )
    assert (ax.get_xlabel(), ax.get_ylabel()) == (r"$\gamma_1$", r"$\omega_3$ (rad/s)")


def test_a_picture_has_one_colour_for_each_class() -> None:
    pytest.importorskip("matplotlib")
    from matplotlib.colors import to_hex

    omega, attitude = rigid.top.on_surface(GORYACHEV, 1.5, 1.5, count=8, rng=2026)
    points = rigid.poincare(GORYACHEV, omega, attitude, t_end=200.0, count=20)
    verdict = rigid.lyapunov(GORYACHEV, omega, attitude, t=[500.0, 1e3], check=False).verdict
    assert set(verdict) == {"chaotic", "regular"}
    ax = points.plot("gamma2", "omega3", by=verdict)
    legend: Any = ax.get_legend()
    words = [text.get_text() for text in legend.get_texts()]
    inks = [line.get_color() for line in legend.get_lines()]
    assert words == ["chaotic", "regular"]  # islands of regular motions lie on the sea
    (drawn,) = ax.collections
    dots: Any = drawn
    of_point = {
        tuple(place): to_hex(colour)
        for place, colour in zip(dots.get_offsets(), dots.get_facecolors(), strict=True)
    }
    places = np.stack([points.component("gamma2"), points.component("omega3")], axis=1)
    for place, body in zip(places, points.body, strict=True):
        assert of_point[tuple(place)] == inks[words.index(verdict[body])]
    with pytest.raises(ValueError, match="by: needs a word for each of 8 bodies, got 2"):
        points.plot(by=["chaotic", "regular"])


def test_a_file_has_the_points(tmp_path: Path) -> None:
    points = rigid.poincare(ASYMMETRIC, RATES, t_end=20.0)
    with np.load(points.save(tmp_path / "points.npz")) as file:
        for name in (
            "t",
            "omega",
            "gamma",
            "attitude",
            "direction",
            "grazing",
            "error",
            "complete",
        ):
            np.testing.assert_array_equal(file[name], getattr(points, name))
        assert '"t_end": 20.0' in str(file["spec"])


# Sections of equal times: states at the multiples of a period


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
    starts = np.array([RATES, [0.1, 0.2, 2.0]])
    points = rigid.poincare(ASYMMETRIC, starts, every=0.7, t_end=7.0)
    assert repr(points) == "<Crossings: 20 points of 2 bodies, every 0.7 s; complete>"
    t = 0.7 * np.arange(1, 11)
    run: Any = rigid.simulate(ASYMMETRIC, starts, t=t, method="dop853", step=0.01, check=False)
    # The errors of the other method.
    np.testing.assert_allclose(points.omega, run.omega.reshape(-1, 3), atol=1e-9)
    np.testing.assert_allclose(points.gamma, run.gamma.reshape(-1, 3), atol=1e-9)
    np.testing.assert_array_equal(points.t, np.tile(t, 2))
    np.testing.assert_array_equal(points.body, np.repeat([0, 1], 10))
    assert (points.attitude[:, 0] >= 0.0).all()
    assert (points.error < 1e-11).all()
    assert points.reasons() == ("complete: 10 points until t = 7 s",) * 2
    np.testing.assert_array_equal(
        rigid.poincare(ASYMMETRIC, starts[0], every=0.7, t_end=7.0, count=3).omega, points.omega[:3]
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
    points = rigid.poincare(ASYMMETRIC, RATES, every=1.0, t_end=9.0, max_steps=2, check=False)
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
    by=lambda more: rigid.poincare(ASYMMETRIC, RATES, t_end=7.0, **more),
)


# Starts on a surface


SURFACES = {
    "highest": rigid.section(),
    "lowest": rigid.section(direction=1),
    "rate": rigid.section("omega2", 0.3, -1),
    "vertical": rigid.section("gamma1", 0.2, 1),
    "plane": rigid.section(omega=(1.0, 0.0, 0.5), gamma=(0.0, 1.0, 0.0), value=0.1, direction=0),
}


@pytest.mark.parametrize("name", SURFACES)
def test_starts_have_energy_momentum_surface_and_direction(name: str) -> None:
    surface = SURFACES[name]
    omega, attitude = rigid.top.on_surface(ASYMMETRIC, 2.0, 0.4, 200, section=surface, rng=1)
    assert omega.shape == (200, 3)
    assert attitude.shape == (200, 4)
    known = rigid.top.heavy_constants(ASYMMETRIC, omega, attitude)
    np.testing.assert_allclose(known.energy, 2.0, rtol=0.0, atol=1e-14)
    np.testing.assert_allclose(known.p_phi, 0.4, rtol=0.0, atol=1e-14)
    run: Any = rigid.simulate(ASYMMETRIC, omega, attitude, t=[0.0, 1e-6])
    normals = surface.normals(ASYMMETRIC, np.tile(ASYMMETRIC.weight, (200, 1)))
    of_omega, of_gamma = normals[:, np.newaxis, :3], normals[:, np.newaxis, 3:]
    height = np.cross(run.gamma, run.omega) if surface.is_height else run.gamma
    values = np.sum(of_omega * run.omega + of_gamma * height, axis=-1) - surface.value
    np.testing.assert_allclose(values[:, 0], 0.0, atol=2e-15)
    if surface.direction:
        assert (np.sign(values[:, 1]) == surface.direction).all()
    else:
        assert 50 < np.count_nonzero(values[:, 1] > 0.0) < 150


def test_the_same_key_gives_the_same_starts() -> None:
    first, second, other = (
        rigid.top.on_surface(ASYMMETRIC, 2.0, 0.4, 20, rng=key)[0] for key in (1, 1, 2)
    )
    np.testing.assert_array_equal(first, second)
    assert (first != other).any()
    # More starts begin with the same ones.
    np.testing.assert_array_equal(
        rigid.top.on_surface(ASYMMETRIC, 2.0, 0.4, 30, rng=1)[0][:20], first
    )


def test_the_least_energy_is_that_of_a_permanent_rotation() -> None:
    # Hanging: without momentum the centre of mass is lowest.
    assert least_energy(ASYMMETRIC, 0.0) == pytest.approx(-1.2, abs=1e-15)
    # A symmetric top, whose rotations about the vertical have the axis at a tilt of cosine u: the
    # energy u + L²/2 (1 - u²/2) is least where its derivative is zero, or at an end.
    for momentum in (0.5, 1.0, 3.0, 30.0, 3e4):  # at 3e4 the weight has 2e-9 of the energy
        roots = np.roots([0.25, 0.0, -1.0, 0.5 * momentum**2, 1.0])
        u = np.concatenate([roots.real[np.abs(roots.imag) < 1e-9], [-1.0, 1.0]])
        u = u[np.abs(u) <= 1.0]
        known = (u + 0.5 * momentum**2 / (1.0 - 0.5 * u**2)).min()
        assert least_energy(LAGRANGE, momentum) == pytest.approx(known, rel=1e-15, abs=1e-15)
    # A fast top whose centre of mass lies across its axis, with the largest moment across the axis:
    # it turns about the centre of mass, which hangs.
    fast = rigid.HeavyTop(rigid.Body((1.6, 1.6, 0.7)), mgl=1.0, com=(1.0, 0.0, 0.0))
    assert least_energy(fast, 3e4) == pytest.approx(3e4**2 / 3.2 - 1.0, rel=3e-16)


@pytest.mark.parametrize("com", [(0.6, 0.0, 0.8), (0.0, 1.0, 0.0), (0.48, 0.64, 0.6), (0, 0, 1)])
@pytest.mark.parametrize("moments", [(1.0, 1.6, 0.7), (1.6, 1.6, 0.7), (1.0, 1.0, 1.6)])
@pytest.mark.parametrize("momentum", [0.3, 1.5, 30.0])
def test_the_least_energy_is_that_of_a_search_over_all_verticals(
    moments: tuple[float, ...], com: tuple[float, ...], momentum: float
) -> None:
    def effective(gamma: Floats) -> Floats:
        unit = gamma / np.linalg.norm(gamma, axis=-1, keepdims=True)
        kinetic = 0.5 * momentum**2 / (unit**2 @ np.array(moments))
        return np.asarray(unit @ np.array(com) + kinetic)

    verticals = np.random.default_rng(1).normal(size=(2000, 3))
    begun = verticals[np.argsort(effective(verticals))[:4]]
    searched = min(minimize(effective, each, tol=1e-12).fun for each in begun)
    top = rigid.HeavyTop(rigid.Body(moments), mgl=1.0, com=com)
    # The energies beside a minimum differ by the square of the distance, so rounding is left.
    assert least_energy(top, momentum) == pytest.approx(searched, rel=2e-15, abs=2e-15)


def test_little_above_the_least_energy_there_are_starts() -> None:
    least = least_energy(ASYMMETRIC, 0.4)
    omega, attitude = rigid.top.on_surface(ASYMMETRIC, least + 1e-2, 0.4, 10, rng=1)
    known = rigid.top.heavy_constants(ASYMMETRIC, omega, attitude)
    np.testing.assert_allclose(known.energy, least + 1e-2, rtol=0.0, atol=1e-14)


def test_verticals_of_a_high_energy_are_even() -> None:
    # Far above the potential every vertical is allowed: its mean is zero, each square a third.
    sphere = rigid.HeavyTop(rigid.Body((1.0, 1.0, 1.0)), mgl=1e-6)
    omega, attitude = rigid.top.on_surface(
        sphere, 10.0, 0.0, 4000, section=rigid.section(direction=0), rng=7
    )
    gamma = np.asarray(rigid.simulate(sphere, omega, attitude, t=[0.0]).gamma)[:, 0]
    # Four standard errors of 4000 draws.
    np.testing.assert_allclose(gamma.mean(axis=0), 0.0, atol=4.0 / np.sqrt(3.0 * 4000.0))
    np.testing.assert_allclose((gamma**2).mean(axis=0), 1.0 / 3.0, atol=4.0 * 0.3 / np.sqrt(4000.0))


# Refusals


LIGHT = rigid.HeavyTop(rigid.Body((1.0, 1.6, 0.7)), mgl=[1.2, 0.0])

test_bad_input_is_refused_with_its_rule = refuses(
    [
        (lambda: rigid.section("omega4"), "name = 'omega4': must be one of 'height'"),
        (
            lambda: rigid.section("omega1", gamma=(0, 0, 1)),
            "name = 'omega1': leave the name out beside omega or gamma",
        ),
        (lambda: rigid.section(omega=(0, 0, 0)), "omega, gamma: both are zero"),
        (lambda: rigid.section("omega1", direction=2), "direction = 2: must be 1, -1 or 0"),
        (lambda: rigid.section(value=0.1), "value = 0.1: omit the value of 'height'"),
        (lambda: rigid.section("gamma2", 1.5), "value = 1.5: never crossed"),
        (
            lambda: rigid.section(gamma=(0.3, 0.4, 0.0), value=0.6),
            "value = 0.6: never crossed; along this direction the vertical has components from -0",
        ),
        (lambda: rigid.section("omega1", np.inf), "value = inf: must be finite"),
        (
            lambda: rigid.poincare(BOX, RATES, t_end=1.0),
            "section = 'height': a body without weight",
        ),
        (
            lambda: rigid.poincare(LIGHT, [RATES, RATES], t_end=1.0),
            "section = 'height': a body without weight",
        ),
        (
            lambda: rigid.poincare(ASYMMETRIC, RATES, t_end=1.0, method="dop853"),
            "method = 'dop853': only a Taylor method is a polynomial inside its steps",
        ),
        (
            lambda: rigid.poincare(BOX, RATES, section="gamma1", t_end=1.0, method="exact"),
            "method = 'exact': only a Taylor method",
        ),
        (lambda: rigid.poincare(ASYMMETRIC, RATES, t_end=0.0), "t_end = 0.0: must be positive"),
        (
            lambda: rigid.poincare(ASYMMETRIC, RATES, t_end=1.0, count=0),
            "count = 0: must be at least",
        ),
        (
            lambda: rigid.poincare(ASYMMETRIC, RATES, t_end=1.0, tolerance=2.0),
            "tolerance = 2e0: must be positive and below one",
        ),
        (
            lambda: rigid.top.on_surface(ASYMMETRIC, -1.3, 0.0, 5),
            "energy = -1.3: must be at least -1.2 J with l_gamma = 0.0",
        ),
        (lambda: rigid.top.on_surface(ASYMMETRIC, -1.1, 2.0, 5), "energy = -1.1: must be at least"),
        (
            lambda: rigid.top.on_surface(
                rigid.HeavyTop(rigid.Body((1.0, 1.6, 0.7)), mgl=1.2, damping=0.1), 2.0, 0.1, 5
            ),
            "a surface of one energy needs a scene without damping",
        ),
        (
            lambda: rigid.top.on_surface(
                ASYMMETRIC, 2.0, 0.4, 5, section=rigid.section("omega3", 50.0)
            ),
            "section: 0 of .* random verticals have a crossing",
        ),
        (
            lambda: rigid.frequencies(np.linspace(0.0, 1.0, 50) ** 2, np.zeros(50)),
            "must be evenly spaced",
        ),
        (
            lambda: rigid.frequencies(np.ones(32), np.ones(32)),
            r"t: from 1\.0 to 1\.0: their span must be positive",
        ),
        (
            lambda: rigid.frequencies(np.linspace(-1.0, 1.0, 32) * 1.5e308, np.ones(32)),
            "their span must be positive, finite",
        ),
        (
            lambda: rigid.frequencies(np.arange(32.0), [[1.0, 2.0], [3.0]]),
            "must be an array of numbers",
        ),
        (lambda: rigid.frequencies([0.0, 1.0], [0.0, 1.0]), "t: 2 times, but lines need"),
        (
            lambda: rigid.frequencies(np.arange(32.0), np.zeros(32), count=5),
            "count = 5: must be at most an eighth of the 32 times",
        ),
        (
            lambda: rigid.frequencies(np.arange(32.0), np.zeros(31)),
            r"z: expected shape \(..., 32\), got \(31,\)",
        ),
        (lambda: rigid.frequencies(np.arange(32.0), np.full(32, np.nan)), "z: must be finite"),
        (lambda: rigid.frequencies(np.arange(32.0), ["a"] * 32), "must be an array of numbers"),
        (
            lambda: rigid.frequency_drift(
                rigid.simulate(BOX, RATES, t=np.arange(64.0)), of="gamma"
            ),
            "of = 'gamma': the run has no gamma",
        ),
        (
            lambda: rigid.poincare(ASYMMETRIC, RATES, t_end=1.0).component("energy"),
            "name = 'energy': must be one of",
        ),
    ]
)


def test_another_type_is_refused() -> None:
    with pytest.raises(TypeError, match=r"section = 3: must be made by rigid\.section"):
        rigid.poincare(ASYMMETRIC, RATES, section=3, t_end=1.0)  # type: ignore[arg-type]
    with pytest.raises(TypeError, match=r"section = 3: must be made by rigid\.section"):
        rigid.top.on_surface(ASYMMETRIC, 2.0, 0.4, 5, section=3)  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="run = 3: must be a Run"):
        rigid.frequency_drift(3)  # type: ignore[arg-type]
