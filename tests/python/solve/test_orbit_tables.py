"""Trajectories by a table of positions, beside exact orbits and a flyby of three bodies."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from numpy.typing import ArrayLike

import rigid
from golden_orbits import GOLDEN, angle_between, case_of, scene_of, start_of
from physics import Floats, cross
from printed_equations import gathers, with_states
from refusals import refuses

METHODS = [method.name for method in rigid.methods() if "orbit" in method.forces]
FLYBYS = [case["name"] for case in GOLDEN if case["e"] > 1.0]
BODY = rigid.Body((0.61, 0.8, 1.0))
OMEGA, ATTITUDE = np.array([0.3, 0.2, 0.5]), np.array([0.8, 0.1, 0.5, -0.3])
HYPERBOLA = rigid.Orbit(1.0, 2.0, -4.0, (0.0, 0.6, 0.8), (1.0, 0.0, 0.0))
ELLIPSE = rigid.Orbit(1.0, 0.3, 0.4, (0.0, 0.6, 0.8), (1.0, 0.0, 0.0))


def table_of(orbit: rigid.Orbit, span: tuple[float, float], count: int) -> rigid.OrbitTable:
    """The orbit as an ephemeris: its mean motion and semi-major axis are one."""
    t = np.linspace(*span, count)
    return rigid.Orbit.table(t, orbit.position(t), gm=1.0)


def on(orbit: rigid.Orbit, **forces: Any) -> rigid.FreeBody:
    return rigid.FreeBody(BODY, orbit=orbit, **forces)


@pytest.mark.parametrize("count", [49, 97, 257, 1025])
@pytest.mark.parametrize("name", FLYBYS)
def test_golden_flybys_by_a_table_err_as_stated(name: str, count: int) -> None:
    case = case_of(name)
    times = [state["t"] for state in case["at"]]
    exact = scene_of(case)
    assert exact.orbit is not None
    scene = rigid.FreeBody(exact.body, orbit=table_of(exact.orbit, (0.0, times[-1]), count))
    run = rigid.simulate(scene, case["omega"], start_of(case), t=times)
    off = np.abs(run.omega - [state["omega"] for state in case["at"]]).max(axis=1)
    assert (off <= run.error * np.linalg.norm(case["omega"])).all()
    assert (angle_between(run, case["at"]) <= run.error).all()
    if count == 1025:
        assert run.error < 1e-6


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("orbit", [HYPERBOLA, ELLIPSE])
def test_every_method_tells_the_error_of_a_table(orbit: rigid.Orbit, method: str) -> None:
    t = np.linspace(1.0, 8.0, 8)
    truth = rigid.simulate(on(orbit), OMEGA, ATTITUDE, t=t, accuracy=1e-10)
    for count in (21, 33, 129):
        scene = on(table_of(orbit, (0.0, 8.0), count))
        run = rigid.simulate(scene, OMEGA, ATTITUDE, t=t, method=method)
        off = np.abs(run.omega - truth.omega).max(axis=1) / np.linalg.norm(OMEGA)
        assert (off <= run.error + truth.error).all()
        if count == 129:
            assert run.error < 1e-3


def test_the_stated_error_falls_with_the_fourth_power_of_the_spacing() -> None:
    def error(count: int) -> float:
        scene = on(table_of(ELLIPSE, (0.0, 8.0), count))
        return float(rigid.simulate(scene, OMEGA, ATTITUDE, t=[8.0]).error)

    coarse, fine = error(101), error(401)
    # At least by 4^4 = 256, less what higher orders of a coarse table add.
    assert coarse / fine > 200.0


def test_a_function_does_not_judge_what_a_coarse_table_leaves_open() -> None:
    """Between the rate along the table and the one along a table in doubt nothing is decided."""
    scene = on(table_of(ELLIPSE, (0.0, 8.0), 33))
    run = rigid.simulate(scene, OMEGA, ATTITUDE, t=[8.0])
    margin = 0.1 * float(run.error) * np.linalg.norm(run.omega)
    start = rigid.Start(omega=(0.3, 0.2, 0.5), attitude=(0.8, 0.1, 0.5, -0.3))

    def undecided(limit: float) -> int:
        def above(states: Any) -> Any:
            return states.omega[:, -1, 0] - limit

        stable = rigid.judged(above, t=[8.0])
        axes = {"omega1": OMEGA[:1]}
        found = rigid.stability_map(scene, axes=axes, start=start, stable=stable, samples=1)
        return int(found.undecided.sum())

    assert sum(undecided(run.omega[-1, 0] + side) for side in (-margin, margin)) == 1


def test_random_tables_err_as_stated() -> None:
    """Of flybys and circles, with intervals that differ by up to a factor of two."""
    rng = np.random.default_rng(7)
    for e in [0.0, 0.3, 1.3, 2.0, 4.25, 10.0] * 4:
        time = (e - 1.0) ** 1.5 / np.sqrt(e + 1.0) if e > 1.0 else 1.0
        span = time * rng.uniform(4.0, 12.0)
        orbit = rigid.Orbit(1.0, e, -0.5 * span)
        t = np.cumsum(np.append(0.0, 2.0 ** rng.uniform(-0.5, 0.5, 150)))
        t *= span / t[-1]
        ends = [0.4 * span, float(t[-1])]
        omega, attitude = rng.normal(size=3) / time, rng.normal(size=4)
        table = rigid.Orbit.table(t, orbit.position(t), gm=1.0)
        found, exact = (
            rigid.simulate(on(one), omega, attitude, t=ends, accuracy=accuracy)
            for one, accuracy in ((table, None), (orbit, 1e-11))
        )
        off = np.abs(found.omega - exact.omega).max() / np.linalg.norm(exact.omega, axis=1).max()
        assert off <= found.error + exact.error


def moon(t: float) -> Floats:
    """A body of an eightieth of the planet's mass, on a circle of radius 1 about it."""
    return np.array([np.cos(t + 2.0), np.sin(t + 2.0), 0.0])


FINE = np.linspace(0.0, 5.0, 2401)


@cache
def flyby_of_three() -> Floats:
    """Rates, quaternions, places and velocities in the frame of the planet, at the fine times."""
    moments = np.array(BODY.moments)

    def acting(t: float, omega: Floats, q: Floats, states: Floats) -> tuple[Floats, Floats]:
        r, v = states[:3], states[3:]
        to_moon, own = moon(t) - r, moon(t)
        pull = to_moon / np.linalg.norm(to_moon) ** 3 - own / np.linalg.norm(own) ** 3
        o = rigid.rotations.quaternion_to_matrix(q).T @ r / np.linalg.norm(r)
        cube = np.linalg.norm(r) ** 3
        torque = 3.0 / cube * cross(o, moments * o)
        return torque, np.concatenate([v, -r / cube + pull / 80.0])

    q = ATTITUDE / np.linalg.norm(ATTITUDE)
    start = [OMEGA, q, [-3.0, 0.5, 0.4], [1.3, 0.1, 0.0]]
    return with_states(moments, acting, start, FINE, atol=1e-13)


def path_of_three(every: int) -> rigid.OrbitTable:
    return rigid.Orbit.table(FINE[::every], flyby_of_three()[::every, 7:10], gm=1.0)


def test_a_flyby_of_three_bodies_is_that_of_scipy() -> None:
    end = flyby_of_three()[-1, :3]
    for every in (40, 24, 1):
        orbit = path_of_three(every)
        run = rigid.simulate(on(orbit), OMEGA, ATTITUDE, t=[5.0])
        off = np.linalg.norm(run.omega[-1] - end) / np.linalg.norm(OMEGA)
        assert off <= run.error
    assert off < 1e-9


@pytest.mark.parametrize("method", [None, "dop853", "taylor16"])
def test_tangents_are_differences_of_neighbours(method: str | None) -> None:
    scene = on(
        table_of(HYPERBOLA, (0.0, 8.0), 65),
        rotor=(0.1, 0.0, 0.2),
        dissipation=rigid.EnergySink(0.05),
        damping=0.02,
    )
    names = ("I1", "rotor1", "damping2")
    options: dict[str, Any] = {"t": [6.0], "method": method, "check": False}
    if method == "dop853":
        options["step"] = 0.02
    run = rigid.simulate(scene, OMEGA, ATTITUDE, tangent=names, **options)
    assert run.tangent is not None
    assert run.sensitivity is not None
    h = 1e-4

    def ends(omega: Floats, scene: rigid.FreeBody = scene) -> Floats:
        end: Floats = rigid.simulate(scene, omega, ATTITUDE, **options).omega[-1]
        return end

    for k, axis in enumerate(np.eye(3)):
        slope = (ends(OMEGA + h * axis) - ends(OMEGA - h * axis)) / (2.0 * h)
        # Differences of the third order, and the second run of steps that are chosen anew.
        np.testing.assert_allclose(run.tangent[-1][:3, k], slope, rtol=0.0, atol=2e-6)

    def other(i1: float, h1: float, d2: float) -> rigid.FreeBody:
        moments = (BODY.moments[0] + i1, *BODY.moments[1:])
        return rigid.FreeBody(
            rigid.Body(moments),
            orbit=scene.orbit,
            rotor=(0.1 + h1, 0.0, 0.2),
            dissipation=scene.dissipation,
            damping=(0.02, 0.02 + d2, 0.02),
        )

    for k, axis in enumerate(np.eye(3)):
        above, below = (ends(OMEGA, other(*(sign * h * axis))) for sign in (1.0, -1.0))
        slope = (above - below) / (2.0 * h)
        np.testing.assert_allclose(run.sensitivity[-1][:3, k], slope, rtol=0.0, atol=2e-6)


@pytest.mark.parametrize("method", ["dop853", "rk4", "taylor20"])
@pytest.mark.parametrize("orbit", [HYPERBOLA, ELLIPSE])
def test_growth_from_any_place_of_an_orbit_is_that_of_its_positions(
    orbit: rigid.Orbit, method: str
) -> None:
    t = np.array([4.0, 8.0])
    exact, found = (
        rigid.lyapunov(on(one), OMEGA, ATTITUDE, t=t, exponents=2, method=method).spectrum
        for one in (orbit, table_of(orbit, (0.0, 8.0), 1601))
    )
    # The error of a cubic spline is about the fourth power of the spacing of its knots, 6e-10.
    np.testing.assert_allclose(found, exact, rtol=0.0, atol=1e-8)


@pytest.mark.parametrize("count", [33, 65, 257])
@pytest.mark.parametrize("orbit", [HYPERBOLA, ELLIPSE])
def test_growth_under_a_table_errs_as_stated(orbit: rigid.Orbit, count: int) -> None:
    found, exact = (
        rigid.lyapunov(on(one), OMEGA, ATTITUDE, t=[2.0, 4.0, 8.0])
        for one in (table_of(orbit, (0.0, 8.0), count), orbit)
    )
    off = np.abs(found.log_growth - exact.log_growth).max()
    assert off <= found.error + exact.error
    assert off > exact.error, "the spline errs more than the steps"


@pytest.mark.parametrize("orbit", [HYPERBOLA, ELLIPSE])
def test_places_and_frames_are_those_of_the_orbit(orbit: rigid.Orbit) -> None:
    table = table_of(orbit, (0.0, 8.0), 801)
    t = np.linspace(0.05, 7.95, 40)
    np.testing.assert_allclose(table.position(t), orbit.position(t), rtol=0.0, atol=1e-7)
    np.testing.assert_allclose(table.frame(t), orbit.frame(t), rtol=0.0, atol=1e-5)
    assert table.position(1.0).shape == (3,)
    assert table.frame(1.0).shape == (3, 3)
    states = orbit.to_space(np.tile(OMEGA, (40, 1)), np.tile(ATTITUDE, (40, 1)), t)
    for found, expected in zip(
        table.to_space(np.tile(OMEGA, (40, 1)), np.tile(ATTITUDE, (40, 1)), t), states, strict=True
    ):
        np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-4)
    run = rigid.simulate(on(table), OMEGA, ATTITUDE, t=t)
    assert run.attitude is not None
    seen, exact = run.in_orbit_frame(), orbit.from_space(run.omega, run.attitude, t)
    np.testing.assert_allclose(seen.omega, exact[0], rtol=0.0, atol=1e-4)
    np.testing.assert_allclose(
        rigid.free.roll_pitch_yaw(table, run.attitude, t, axes=(1, 3)),
        rigid.free.roll_pitch_yaw(orbit, run.attitude, t, axes=(1, 3)),
        rtol=0.0,
        atol=1e-4,
    )


def test_the_frame_of_a_path_in_space_turns_as_its_axes_do() -> None:
    orbit = path_of_three(3)
    when, h = np.array([1.0, 2.0, 3.0]), 1e-4
    frame, turning = orbit._turning(when)
    slope = (orbit.frame(when + h) - orbit.frame(when - h)) / (2.0 * h)
    about = np.einsum("mij,mj->mi", frame, turning)
    expected = np.cross(about[:, np.newaxis], np.swapaxes(frame, 1, 2))
    # The bend of a cubic spline is linear between its knots: an eighth of h² times its own bend.
    np.testing.assert_allclose(np.swapaxes(slope, 1, 2), expected, rtol=0.0, atol=1e-3)


def test_events_know_the_table() -> None:
    scene = on(table_of(HYPERBOLA, (0.0, 8.0), 65))
    run = rigid.simulate(
        scene, OMEGA, ATTITUDE, t=[8.0], events=[rigid.crosses("omega1", 0.2), rigid.turns("speed")]
    )
    for event in run.events:
        assert len(event.t)
    at = rigid.simulate(scene, OMEGA, ATTITUDE, t=run.events[0].t)
    np.testing.assert_allclose(at.omega[:, 0], 0.2, rtol=0.0, atol=1e-7)


def away(t: float, omega: Any, attitude: Any, orbit_position: Any) -> float:
    """The space component of the place along (1, 2, 2)/3."""
    return float(orbit_position[0] + 2.0 * orbit_position[1] + 2.0 * orbit_position[2]) / 3.0


def test_a_function_is_told_the_positions_of_a_table_at_its_times() -> None:
    gm = 8.0
    t = np.linspace(0.0, 8.0, 65)
    places = HYPERBOLA.position(t)
    scene = on(rigid.Orbit.table(t, places, gm=gm))
    along = places @ np.array([1.0, 2.0, 2.0]) / 3.0 / 2.0  # over the cube root of gm
    knots = (5, 20, 33, 64)
    events = [rigid.crosses(away, along[k]) for k in knots]
    run = rigid.simulate(scene, OMEGA, ATTITUDE, t=[8.0], events=events)
    for found, k in zip(run.events, knots, strict=True):
        # The place is a smooth function whose slope is about one: rounding of a few units.
        assert np.abs(found.t - t[k]).min() < 1e-13


@pytest.mark.parametrize("steps", [{"accuracy": 1e-11}, {"method": "rk4", "step": 2e-3}], ids=str)
def test_a_function_is_told_the_spline_of_a_table(steps: Any) -> None:
    table = table_of(ELLIPSE, (0.0, 8.0), 33)
    scene = on(table, torque=rigid.Torque.call(gathers, states=3))
    run = rigid.simulate(scene, OMEGA, ATTITUDE, t=[8.0], **steps)
    assert run.states is not None
    # The integrand is smooth between knots: Gauss's rule of each interval errs by rounding.
    nodes, weights = np.polynomial.legendre.leggauss(20)
    half = 0.5 * np.diff(table.t)[:, np.newaxis]
    places = table.position((table.t[:-1, np.newaxis] + half * (1.0 + nodes)).ravel())
    whole = (half * weights).ravel() @ places
    np.testing.assert_allclose(run.states[-1], whole, rtol=0.0, atol=1e-10)


@pytest.mark.parametrize("count", [33, 65, 257])
@pytest.mark.parametrize("orbit", [HYPERBOLA, ELLIPSE])
def test_what_functions_make_of_a_table_errs_as_stated(orbit: rigid.Orbit, count: int) -> None:
    """Their states, and the events of a function of the place, are those of the exact orbit."""
    torque = rigid.Torque.call(gathers, states=3)
    events = [rigid.crosses(away, float(away(0.0, None, None, orbit.position(5.0))))]
    found, exact = (
        rigid.simulate(on(one, torque=torque), OMEGA, ATTITUDE, t=[4.0, 8.0], events=events)
        for one in (table_of(orbit, (0.0, 8.0), count), orbit)
    )
    assert found.states is not None
    assert exact.states is not None
    off = np.abs(found.states - exact.states).max() / np.abs(exact.states).max()
    assert exact.error < off <= found.error + exact.error
    (event,), (truth,) = found.events, exact.events
    assert np.abs(truth.t - 5.0).min() < 1e-12
    assert len(event.t) == len(truth.t)
    assert (np.abs(event.t - truth.t) <= event.error + truth.error).all()


@pytest.mark.parametrize("count", [257, 1025])
@pytest.mark.parametrize("name", FLYBYS)
def test_events_of_golden_flybys_by_a_table_err_as_stated(name: str, count: int) -> None:
    """A rate has its golden value at the golden time."""
    case = case_of(name)
    times = [state["t"] for state in case["at"]]
    exact = scene_of(case)
    assert exact.orbit is not None
    scene = rigid.FreeBody(exact.body, orbit=table_of(exact.orbit, (0.0, times[-1]), count))
    known = [
        (rigid.crosses(f"omega{k + 1}", rate), state["t"])
        for state in case["at"][:-1]
        for k, rate in enumerate(state["omega"])
    ]
    events = [event for event, _ in known]
    run = rigid.simulate(scene, case["omega"], start_of(case), t=times[-1:], events=events)
    for event, (_, t) in zip(run.events, known, strict=True):
        off = np.abs(event.t - t)
        nearest = np.argmin(off)
        assert off[nearest] <= event.error[nearest]


def test_the_power_of_the_gradient_is_the_rate_of_the_energy() -> None:
    t = np.linspace(0.0, 8.0, 4001)
    run = rigid.simulate(on(table_of(HYPERBOLA, (0.0, 8.0), 129)), OMEGA, ATTITUDE, t=t)
    assert run.energy_drift < 1e-9
    residual = rigid.free.power_balance(run).residual
    # The difference over two steps of 0.002.
    assert np.abs(residual[1:-1]).max() < 1e-5


def test_samples_of_a_map_are_classified_as_their_runs() -> None:
    result, exact = (
        rigid.stability_map(
            scene,
            axes={"omega3": [0.1, 0.3, 0.6]},
            start=rigid.Start(omega=(0.3, 0.2, 0.5), attitude_noise=rigid.normal(0.5)),
            stable=rigid.no_flip(1),
            measure=rigid.largest_tilt(reference="vertical"),
            samples=30,
            t_end=8.0,
            rng=1,
        )
        for scene in (
            on(table_of(HYPERBOLA, (0.0, 8.0), 33)),
            on(HYPERBOLA, torque=rigid.Torque.body((0.0, 0.0, 0.0))),
        )
    )
    assert result.stable.sum() not in (0, 90)
    np.testing.assert_array_equal(result.stable, exact.stable)
    np.testing.assert_array_equal(result.unstable, exact.unstable)


TABLE = table_of(HYPERBOLA, (0.0, 8.0), 17)


@pytest.mark.parametrize("name", ["rate", "normal", "period", "numbers", "no_such_name"])
def test_a_table_has_no_attributes_of_ellipses(name: str) -> None:
    assert hasattr(TABLE, "gm")
    assert not hasattr(TABLE, name)
    assert getattr(TABLE, name, None) is None


def test_tables_are_told_and_compared_by_their_times() -> None:
    assert repr(TABLE) == "OrbitTable(17 times from 0 to 8)"
    assert table_of(HYPERBOLA, (0.0, 8.0), 33) != TABLE


CIRCLE = np.stack([np.cos(np.arange(9.0)), np.sin(np.arange(9.0)), np.zeros(9)], axis=1)
"""Positions of a circle, 57 degrees apart."""


def small_map(**options: Any) -> Any:
    return rigid.stability_map(
        on(TABLE),
        **{
            "axes": {"omega1": [0.1, 0.2]},
            "stable": rigid.no_flip(3),
            "start": rigid.Start(omega=(0.1, 0.2, 0.3)),
            "samples": 4,
            "t_end": 1.0,
            **options,
        },
    )


def made(t: ArrayLike, positions: ArrayLike = CIRCLE, gm: float = 1.0) -> rigid.OrbitTable:
    return rigid.Orbit.table(t, positions, gm)


test_what_a_table_cannot = refuses(
    [
        (
            lambda: made(np.arange(8.0), CIRCLE[:8]),
            "positions: expected shape .9 or more, 3., got .8, 3.",
        ),
        (lambda: made(np.arange(9.0)), "turns by more than 45 degrees"),
        (lambda: made(np.arange(9.0) ** 2), "t = 1: the intervals before and after it"),
        (lambda: made([0, 1, 2, 3, 4, 4, 6, 7, 8]), "t of 9 times: .* no two of them equal"),
        (lambda: made(np.arange(9.0), CIRCLE[:8]), r"positions: expected shape \(9, 3\)"),
        (lambda: made(np.arange(9.0), 0.0 * CIRCLE), r"positions\[0\] = 0: must not be the planet"),
        (lambda: made(np.arange(9.0), gm=0.0), "gm = 0.0: must be positive"),
        (lambda: TABLE.position(9.0), "t = 9: the table of the orbit does not reach this time"),
        (
            lambda: rigid.simulate(on(TABLE), OMEGA, t=[9.0]),
            "t = 9: the table of the orbit does not reach this time",
        ),
        (
            lambda: rigid.plan(on(TABLE), omega=OMEGA, t_end=9.0),
            "t = 9: the table of the orbit does not reach this time",
        ),
        (
            lambda: rigid.plan(on(made(TABLE.t + 1.0, TABLE.position(TABLE.t)))),
            "t = 0: the table of the orbit does not reach this time",
        ),
        (lambda: TABLE.period, "OrbitTable.* has no rate"),
        (
            lambda: rigid.simulate(on(TABLE), OMEGA, t=[1.0], events=[rigid.crosses("roll", 0.1)]),
            "not watched along the table",
        ),
        (lambda: small_map(axes={"rate": [1.0, 2.0]}), "the orbit of the scene is a table"),
        (lambda: small_map(stable=rigid.yaw_within(1.0)), "not watched along the table"),
        (lambda: small_map(stable=rigid.regular()), "not integrated under a table over time"),
        (lambda: small_map(t_end=9.0), "t = 9: the table of the orbit does not reach this time"),
        (lambda: small_map(time_unit="orbit"), "has no rate"),
    ]
)
