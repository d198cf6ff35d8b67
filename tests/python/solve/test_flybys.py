"""Bodies that pass a planet on a hyperbola: the path, the passage from afar, maps and events."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import quad_motion
import rigid
from adversarial import Case
from physics import Floats, place_on_orbit
from verdicts import true_errors

GM, PERIAPSIS, SPEED = 398600.4, 38011.0, 5.8414
"""The Earth and Apophis in km and s (Farnocchia and Chodas 2021)."""

NORMAL, TOWARDS = (0.0, 0.6, 0.8), (1.0, 0.0, 0.0)

BODY = rigid.Body((0.61, 0.8, 1.0))


def apophis(time: float = 0.0) -> rigid.Orbit:
    return rigid.Orbit.flyby(GM, PERIAPSIS, SPEED, time, NORMAL, TOWARDS)


def test_a_flyby_obeys_newtons_law_of_gravity() -> None:
    # From the periapsis on, with the speed of the vis-viva equation v² = v∞² + 2 GM / q.
    speed = np.sqrt(SPEED**2 + 2.0 * GM / PERIAPSIS)
    along = speed * np.cross(NORMAL, TOWARDS)
    t = np.array([0.0, 1e3, 1e4, 1e5, 1e6])

    def rate(_: float, y: Floats) -> Floats:
        change: Floats = np.concatenate([y[3:], -GM * y[:3] / np.linalg.norm(y[:3]) ** 3])
        return change

    start = np.concatenate([PERIAPSIS * np.array(TOWARDS), along])
    path = solve_ivp(rate, (0.0, t[-1]), start, "DOP853", t, rtol=1e-13, atol=1e-9)
    found = apophis().position(t) * GM / SPEED**2
    np.testing.assert_allclose(found, path.y[:3].T, rtol=1e-11, atol=1e-6)


def test_a_flyby_passes_the_periapsis_at_its_time() -> None:
    orbit = apophis(time=3600.0)
    nearest = np.linalg.norm(orbit.position(3600.0)) * GM / SPEED**2
    assert nearest == pytest.approx(PERIAPSIS, rel=1e-14)
    np.testing.assert_allclose(orbit.position(0.0), apophis().position(-3600.0), rtol=1e-13)
    assert orbit.period == np.inf
    assert rigid.Orbit.of_numbers(orbit.numbers) == orbit
    assert rigid.Orbit.from_dict(orbit.to_dict()) == orbit


def test_positions_on_hyperbolas_are_those_of_keplers_equation() -> None:
    e = np.array([1.05, 1.3, 4.0, 100.0])
    orbit = rigid.Orbit(1.0, e, [-700.0, -3.0, 0.0, 20.0])
    for t in (-5.0, 0.0, 2.0, 400.0):
        for k, place in enumerate(orbit.position(t)):
            own = rigid.Orbit(1.0, e[k], orbit.anomaly[k])  # type: ignore[index]
            mean = abs(float(own.anomaly)) + abs(t)
            # A rounding of the mean anomaly and of the eccentric one.
            near = 1e-15 * (1.0 + mean + np.linalg.norm(place)) / min(1.0, e[k] - 1.0)
            np.testing.assert_allclose(place, place_on_orbit(own, t), rtol=0.0, atol=near)


@pytest.mark.parametrize("distance", [3.0, 30.0, 300.0])
@pytest.mark.parametrize("e", [1.05, 4.25, 30.0])
def test_a_body_that_comes_from_afar_errs_as_stated(e: float, distance: float) -> None:
    """The truth is a series in 80-bit numbers whose path begins at the periapsis."""
    nearest = e - 1.0
    along = np.arccosh((distance * nearest + 1.0) / e)
    mean = float(e * np.sinh(along) - along)
    orbit = rigid.Orbit(1.0, e, -mean, NORMAL, TOWARDS)
    fastest = np.sqrt(e * e - 1.0) / nearest**2
    omega = min(0.3 * fastest, 300.0 / mean) * np.array([0.5, 0.7, -0.4])
    t = np.array([0.5, 1.0, 1.6]) * mean
    for scene in (
        rigid.FreeBody(BODY, orbit=orbit),
        rigid.FreeBody(BODY, orbit=orbit, rotor=(0.0, 0.1 * fastest, 0.0), damping=1e-3 / mean),
    ):
        case = Case("flyby", scene, omega, np.array([0.8, 0.1, 0.5, -0.3]), t, {})
        exact = quad_motion.motion(scene, omega, case.attitude, t, **quad_motion.FAST)
        assert exact is not None
        asked: list[dict[str, Any]] = [{}, {"accuracy": 1e-6}]
        if distance < 100.0:
            # Its many equal steps would round alike by chance.
            asked.append({"method": "dop853", "accuracy": 1e-7})
        for options in asked:
            run = rigid.simulate(scene, omega, case.attitude, t=t, **options)
            assert run.status == rigid.Status.OK
            true = true_errors(case, run, None, exact).max()
            assert true <= float(run.error) <= options.get("accuracy", 1e-8)


@pytest.mark.parametrize("method", ["rk4", "dop853"])
def test_equal_steps_follow_the_anomaly_of_a_hyperbola(method: str) -> None:
    """Over its anomaly, and in the time beside a rotor that is too slow to act."""
    orbit = rigid.Orbit(1.0, 2.0, -40.0, NORMAL, TOWARDS)
    omega, t = [0.3, 0.2, 0.5], np.linspace(5.0, 80.0, 6)
    scenes = [rigid.FreeBody(BODY, orbit=orbit, rotor=rotor) for rotor in (None, (0, 0, 1e-200))]
    alone, beside = (rigid.simulate(one, omega, t=t, method=method, step=0.01) for one in scenes)
    together = alone.error + beside.error
    np.testing.assert_array_less(np.abs(alone.omega - beside.omega).max(), together)
    # No step over the anomaly is longer than the step in the time.
    assert alone.steps > beside.steps


def test_steps_over_a_hyperbola_follow_the_own_times_of_a_body() -> None:
    """Bodies that share the orbit and the next time, but not the last one."""
    scene = rigid.FreeBody(BODY, orbit=rigid.Orbit(1.0, 2.0, -10.0, NORMAL, TOWARDS))
    omega, t = [0.3, 0.2, 0.5], np.array([[5.0, 12.0], [5.0, 60.0], [5.0, 400.0]])
    options: dict[str, Any] = {"method": "dop853", "step": 0.05}
    together = rigid.simulate(scene, np.tile(omega, (3, 1)), t=t, **options)
    for body, own in enumerate(t):
        alone = rigid.simulate(scene, omega, t=own, **options)
        assert alone.steps == together.steps[body]
        assert alone.omega.tobytes() == together.omega[body].tobytes()


def test_events_past_a_planet_are_where_the_motion_is() -> None:
    scene = rigid.FreeBody(BODY, orbit=rigid.Orbit(1.0, 3.0, -20.0, NORMAL, TOWARDS))
    omega = [0.3, 0.2, 0.5]
    run: Any = rigid.simulate(scene, omega, t=[40.0], events=[rigid.crosses("omega1", 0.2)])
    times = run.events[0].t
    assert len(times) > 0
    there = rigid.simulate(scene, omega, t=times)
    np.testing.assert_allclose(there.omega[:, 0], 0.2, atol=1e-8)


def test_a_map_of_a_flyby_is_what_its_bodies_do() -> None:
    """Which of 96 bodies keep their axis near the normal of the orbit, by their own motions."""
    scene = rigid.FreeBody(BODY, orbit=rigid.Orbit(1.0, 2.5, -15.0, NORMAL, TOWARDS))
    most = 0.9
    start = rigid.Start(spin=1.0, axis=3, noise=rigid.normal(0.05))
    options: dict[str, Any] = {"axes": {"spin": [0.3, 0.6, 0.9]}, "samples": 32, "rng": 3}
    pointing = rigid.pointing_within(most, 3, "normal")
    result = rigid.stability_map(scene, start=start, stable=pointing, t_end=30.0, **options)
    t = np.linspace(0.0, 30.0, 3001)
    for pixel in range(3):
        bodies = result.starts(range(32), pixel=pixel)
        run = rigid.simulate(scene, bodies.omega, bodies.attitude, t=t, check=False)
        axis = run.rotation().as_matrix()[..., 2].reshape(32, -1, 3)
        largest = np.arccos(np.clip(axis @ np.array(NORMAL), -1.0, 1.0)).max(axis=1)
        # Between the times the axis turns by less than this.
        assert np.abs(largest - most).min() > 1e-5
        assert result.stable[pixel] == np.count_nonzero(largest < most)
    assert 0 < result.stable.sum() < 96


def test_a_map_holds_ellipses_beside_hyperbolas() -> None:
    """Each pixel is the map of its orbit alone, but for the bodies that are drawn."""
    noise = rigid.samples([[0.0, 0.0, 0.5], [0.1, 0.2, 0.4], [0.3, 0.0, 0.9]], in_order=True)
    options: dict[str, Any] = {"stable": rigid.rate_within(0.5), "t_end": 10.0, "samples": 3}
    options["start"] = rigid.Start(omega=(0.0, 0.0, 0.0), noise=noise)

    def share(axes: dict[str, list[float]], e: float) -> Floats:
        scene = rigid.FreeBody(BODY, orbit=rigid.Orbit(1.0, e, -5.0))
        found: Floats = rigid.stability_map(scene, axes=axes, **options).stable
        return found

    values = [0.0, 0.5, 0.95, 1.05, 1.5, 4.0, 50.0]
    together = share({"eccentricity": values}, 0.1)
    alone = [share({"omega3": [0.0]}, e)[0] for e in values]
    np.testing.assert_array_equal(together, alone)
    assert 0 < together.sum() < 3 * len(values)


@pytest.mark.parametrize("name", ["rate", "eccentricity", "anomaly"])
def test_sensitivities_of_a_flyby_are_differences(name: str) -> None:
    usual = {"rate": 1.0, "eccentricity": 2.5, "anomaly": -6.0}

    def run(value: float, **options: Any) -> rigid.Run:
        orbit = rigid.Orbit(**{**usual, name: value}, normal=NORMAL, periapsis=TOWARDS)
        scene = rigid.FreeBody(BODY, orbit=orbit)
        return rigid.simulate(scene, [0.3, 0.2, 0.5], t=[12.0], method="taylor20", **options)

    found: Any = run(usual[name], tangent=name).sensitivity
    # Central differences: the error of h² is below 1e-7, rounding is below 1e-9.
    h = 1e-5
    ahead, behind = (run(usual[name] + part, check=False).omega[0] for part in (h, -h))
    np.testing.assert_allclose(found[0, :3, 0], (ahead - behind) / (2.0 * h), atol=1e-7)
