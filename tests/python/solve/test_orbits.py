"""Bodies on Keplerian orbits: golden digits of motion and tangent, Kepler's equation, refusals."""

import json
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

import rigid
from golden_orbits import GOLDEN, angle_between, case_of, scene_of, start_of
from physics import Floats, place_on_orbit, present, rotation_angle
from refusals import refuses

NAMES = [case["name"] for case in GOLDEN]
METHODS = [method.name for method in rigid.methods() if "orbit" in method.forces]


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("method", METHODS)
def test_golden_satellites_within_the_estimated_error(name: str, method: str) -> None:
    case = case_of(name)
    times = [state["t"] for state in case["at"]]
    run = rigid.simulate(scene_of(case), case["omega"], start_of(case), t=times, method=method)
    rates = np.abs(run.omega - [state["omega"] for state in case["at"]]).max(axis=1)
    # A rounding in each step adds up at random, and the motion magnifies it. The error is stated
    # from two runs: where rounding dominates, both may err alike by chance.
    rounding = np.finfo(float).eps * np.sqrt(float(np.max(run.steps)))
    condition = np.array([np.linalg.norm(state["tangent"], 2) for state in case["at"]])
    allowed = np.maximum(run.error, rounding * condition)
    assert (rates <= allowed * np.linalg.norm(case["omega"])).all()
    assert (angle_between(run, case["at"]) <= allowed).all()


def test_a_series_that_rounds_each_step_errs_as_stated_where_rounding_is_magnified() -> None:
    """By 7000 on this orbit. A second run from a start that is rounded otherwise errs as much, and
    beside it alone every tenth of these runs erred by more than was stated."""
    case = case_of("molniya")
    times = [state["t"] for state in case["at"]]
    fastest = np.linalg.norm([state["omega"] for state in case["at"]], axis=1).max()
    for steps in range(1500, 4000, 60):
        run = rigid.simulate(
            scene_of(case),
            case["omega"],
            start_of(case),
            t=times,
            method="taylor12",
            step=times[-1] / steps,
        )
        rates = np.abs(run.omega - [state["omega"] for state in case["at"]]).max()
        assert rates <= run.error * fastest
        assert angle_between(run, case["at"]).max() <= run.error < 1e-9


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("method", METHODS)
def test_golden_tangents(name: str, method: str) -> None:
    case = case_of(name)
    times = [state["t"] for state in case["at"]]
    step = {"rk4": 1.0 / 1024.0, "dop853": 1.0 / 256.0}.get(method)
    if step is not None:
        # A passage of the periapsis takes a time as |1 - e|^1.5, by Kepler's third law.
        step *= min(1.0, (abs(1.0 - case["e"]) / 0.26) ** 1.5)
    run: Any = rigid.simulate(
        scene_of(case),
        case["omega"],
        start_of(case),
        t=times,
        method=method,
        step=step,
        tangent=True,
    )
    exact = np.array([state["tangent"] for state in case["at"]])
    size = np.abs(exact).max(axis=(1, 2))
    # The errors of rk4 are those of its order at the periapsis of the most eccentric orbit.
    allowed = {"rk4": 2e-6}.get(method, 1e-10)
    assert (np.abs(run.tangent - exact).max(axis=(1, 2)) <= allowed * size).all()


@pytest.mark.parametrize("name", NAMES)
def test_golden_positions(name: str) -> None:
    case = case_of(name)
    orbit: Any = scene_of(case).orbit
    places = orbit.position([state["t"] for state in case["at"]])
    exact = np.array([state["position"] for state in case["at"]])
    # Near a periapsis a rounding of the mean anomaly is a larger change of the eccentric one.
    last = case["at"][-1]["t"] + abs(orbit.anomaly)
    # That of a hyperbola follows from the true anomaly by some roundings, too.
    roundings = 1.0 / abs(1.0 - case["e"]) + (3.0 if case["e"] > 1.0 else 0.0)
    assert np.abs(places[:, :2] - exact).max() < 4e-16 * last * roundings
    np.testing.assert_array_equal(places[:, 2], 0.0)


def test_frames_of_many_orbits() -> None:
    rng = np.random.default_rng(5)
    normal = rng.normal(size=(4, 3))
    begin = np.cross(normal, rng.normal(size=(4, 3)))
    unit = [part / np.linalg.norm(part, axis=1, keepdims=True) for part in (normal, begin)]
    rates, eccentricities = np.array([0.5, 1.0, 2.0, 3.0]), np.array([0.0, 0.3, 0.9, 0.95])
    orbit = rigid.Orbit(rates, eccentricities, 1.0, *unit)
    t = np.array([-40.0, 0.0, 0.3, 1000.0])
    places, frames = orbit.position(t), orbit.frame(t)
    assert places.shape == (4, 4, 3)
    assert frames.shape == (4, 4, 3, 3)
    each = orbit.position(np.tile(t, (4, 1)) + np.arange(4.0)[:, np.newaxis])
    for k in range(4):
        own = rigid.Orbit(rates[k], eccentricities[k], 1.0, unit[0][k], unit[1][k])
        np.testing.assert_array_equal(own.position(t), places[k])
        np.testing.assert_array_equal(own.position(t + k), each[k])
        np.testing.assert_array_equal(own.frame(0.3), frames[k, 2])
        for place, time in zip(places[k], t, strict=True):
            # The mean anomaly is rounded, here and there.
            near = 8e-16 * (1.0 + abs(rates[k] * time)) / (1.0 - eccentricities[k])
            np.testing.assert_allclose(place, place_on_orbit(own, time), atol=near)
    turned = np.swapaxes(frames, -1, -2) @ frames
    np.testing.assert_allclose(turned, np.broadcast_to(np.eye(3), turned.shape), atol=1e-15)
    np.testing.assert_allclose(np.linalg.det(frames), 1.0, atol=1e-14)
    # Against the motion the axis along points back: it is the derivative of the position there.
    ahead = orbit.position(t + 1e-6) - orbit.position(t - 1e-6)
    assert (np.sum(ahead * frames[..., 1], axis=-1) > 0.0).all()
    np.testing.assert_array_equal(orbit.period, 2.0 * np.pi / rates)


def test_a_file_gives_back_the_same_orbit_to_the_bit() -> None:
    rng = np.random.default_rng(7)
    for _ in range(300):
        normal, other = rng.normal(size=(2, 3))
        normal /= np.linalg.norm(normal)
        begin = np.cross(normal, other) / np.linalg.norm(np.cross(normal, other))
        orbit = rigid.Orbit(1.0, 0.3, 2.0, normal, begin)
        assert rigid.Orbit.from_dict(json.loads(json.dumps(orbit.to_dict()))) == orbit
        two = rigid.Orbit(1.0, [0.3, 0.3], 2.0, normal, begin)
        scene = rigid.FreeBody(rigid.Body((1.0, 1.4, 1.9)), orbit=two)
        assert scene[1].orbit == orbit


def test_each_body_has_its_orbit() -> None:
    orbit = rigid.Orbit([0.5, 1.0], [0.0, 0.6], true_anomaly=[0.0, 3.0])
    scene = rigid.FreeBody(rigid.Body((1.0, 1.4, 1.9)), orbit=orbit, rotor=(0.0, 0.1, 0.0))
    assert len(scene) == 2
    assert scene[1].orbit == rigid.Orbit(1.0, 0.6, true_anomaly=3.0)


def tilted_orbit(rate: float = 0.7, e: float = 0.4, anomaly: float = 1.0) -> rigid.Orbit:
    return rigid.Orbit(rate, e, anomaly, normal=(0.0, 0.6, 0.8))


ROTOR, DRAG, SINK = np.array([0.3, -0.2, 0.5]), np.array([0.1, 0.2, 0.05]), np.array([5, 10, 2])
FURTHER: dict[str, Any] = {
    "orbit": tilted_orbit(),
    "rotor": ROTOR,
    "drag": DRAG,
    "dissipation": rigid.EnergySink(0.01 * SINK),
}
FORCES: dict[str, dict[str, Any]] = {
    **{name: {name: value} for name, value in FURTHER.items()},
    "all": {
        **FURTHER,
        "torque": rigid.Torque.body([(0.1, 0.0, -0.2), (0.0, 0.1, 0.0)], times=[0.0, 9.0])
        + rigid.Torque.space((0.0, 0.03, 0.01)),
        "damping": (0.01, 0.02, 0.03),
    },
}
MOMENTS, OMEGA = np.array([1.0, 1.7, 2.2]), np.array([0.4, 1.0, -0.3])
ATTITUDE = np.array([0.5, -0.3, 0.7, 0.4]) / np.linalg.norm([0.5, -0.3, 0.7, 0.4])
TIMES = [1.0, 4.0]


def matrix_of(run: rigid.Run) -> Floats:
    found: Floats = run.rotation().as_matrix()
    return found


def parted(ahead: rigid.Run, behind: rigid.Run, size: float) -> Floats:
    """Half of the difference of two runs over a size: of the rates, and as a rotation vector."""
    rates = (ahead.omega - behind.omega) / (2.0 * size)
    turned = np.swapaxes(matrix_of(behind), -1, -2) @ matrix_of(ahead)
    turned = 0.5 * (turned - np.swapaxes(turned, -1, -2))
    vectors = np.stack([turned[:, 2, 1], turned[:, 0, 2], turned[:, 1, 0]], axis=-1)
    return np.concatenate([rates, vectors / (2.0 * size)], axis=-1)


def run_of(name: str, change: dict[str, Any] | None = None, **others: Any) -> rigid.Run:
    acting = {**FORCES[name], **(change or {})}
    body = rigid.Body(others.pop("moments", MOMENTS))
    omega = others.pop("omega", OMEGA)
    scene = rigid.FreeBody(body, **acting)
    given = {"method": "taylor20", "t": TIMES, "check": False, **others}
    return rigid.simulate(scene, omega, ATTITUDE, **given)


SIZE = 1e-4
#: Of a central difference: SIZE² times a third derivative, and rounding over SIZE.
NEAR = 3e-7


@pytest.mark.parametrize("method", ["dop853", "taylor12", "taylor20"])
@pytest.mark.parametrize("name", FORCES)
def test_tangents_are_the_derivatives_of_motions(name: str, method: str) -> None:
    run: Any = run_of(name, tangent=True, method=method)
    for k in range(3):
        off = SIZE * np.eye(3)[k]
        exact = parted(run_of(name, omega=OMEGA + off), run_of(name, omega=OMEGA - off), SIZE)
        np.testing.assert_allclose(run.tangent[:, :, k], exact, atol=NEAR)


CHANGES: dict[str, Any] = {
    "I2": lambda x: {"moments": MOMENTS + np.array([0.0, x, 0.0])},
    "damping": lambda x: {"damping": np.array([0.01, 0.02, 0.03]) + x},
    "torque2": lambda x: {"torque": FORCES["all"]["torque"] + rigid.Torque.body((0, x, 0))},
    "rotor3": lambda x: {"rotor": ROTOR + x * np.eye(3)[2]},
    "drag": lambda x: {"drag": DRAG + x},
    "dissipation": lambda x: {"dissipation": rigid.EnergySink(0.01 * SINK + x)},
    "rate": lambda x: {"orbit": tilted_orbit(rate=0.7 + x)},
    "eccentricity": lambda x: {"orbit": tilted_orbit(e=0.4 + x)},
    "anomaly": lambda x: {"orbit": tilted_orbit(anomaly=1.0 + x)},
}


@pytest.mark.parametrize("method", ["dop853", "taylor12", "taylor20"])
@pytest.mark.parametrize("parameter", CHANGES)
def test_sensitivities_are_the_derivatives_by_parameters(parameter: str, method: str) -> None:
    name = "orbit" if parameter == "anomaly" else "all"

    def moved(x: float) -> rigid.Run:
        given = CHANGES[parameter](x)
        return run_of(name, given, moments=given.pop("moments", MOMENTS))

    run: Any = run_of(name, tangent=parameter, method=method)
    exact = parted(moved(SIZE), moved(-SIZE), SIZE)
    np.testing.assert_allclose(run.sensitivity[..., 0], exact, atol=NEAR)


def test_a_spectrum_on_an_orbit_has_the_zeros_of_theory() -> None:
    # At rest on a stable circle all exponents are zero, two of them by theory.
    body = rigid.Body((2.0, 2.1, 0.3))
    found = {
        e: rigid.lyapunov(
            rigid.FreeBody(body, orbit=rigid.Orbit(1.0, e)),
            [0.05, 0.1, 1.4],
            ATTITUDE,
            t=[300.0],
            exponents=6,
        )
        for e in (0.0, 0.3)
    }
    assert [int(growth.zeros) for growth in found.values()] == [2, 0]
    for growth in found.values():
        # The flow keeps the volume of states: the exponents add up to zero.
        assert abs(growth.spectrum[-1].sum()) < 1e-9
    sink = rigid.FreeBody(body, dissipation=rigid.EnergySink(0.05))
    damped = rigid.lyapunov(sink, [0.3, 0.2, 1.0], t=[300.0], exponents=6, of="attitude")
    assert int(damped.zeros) == 4
    assert (np.sort(damped.spectrum[-1])[:2] < -1e-3).all()


def test_wisdoms_hyperion_is_chaotic_and_a_distant_orbit_is_not() -> None:
    """Wisdom, Peale and Mignard 1984: Hyperion tumbles."""
    hyperion = rigid.Body((0.5656, 0.7928, 1.0))
    axes = {"t_end": [100.0]}
    for e, moments, expected in ((0.1, hyperion, 0), (0.0, rigid.Body((0.99, 0.995, 1.0)), 4)):
        result = rigid.stability_map(
            rigid.FreeBody(moments, orbit=rigid.Orbit(2.0 * np.pi, e)),
            axes=axes,
            start=rigid.Start(spin=8.8, axis=3, tilt=0.5, noise=rigid.normal(1e-3)),
            stable=rigid.regular(),
            samples=4,
            rng=1,
        )
        assert int(result.stable[0]) == expected
        assert int(result.unstable[0]) == 4 - expected


def test_moments_that_differ_by_a_thousandth_have_no_long_axis_in_common() -> None:
    """Of one pixel axis 1 is the long one, of the other axis 2: which one librates?"""

    def shapes(excess: Floats) -> rigid.FreeBody:
        moments = np.stack([1.0 + excess, np.ones_like(excess), np.full_like(excess, 1.9)], axis=-1)
        return rigid.FreeBody(rigid.Body(moments), orbit=rigid.Orbit(1.0))

    with pytest.raises(ValueError, match="axis: is needed, because the long axis of the bodies"):
        rigid.stability_map(
            shapes,
            axes={"excess": [-5e-4, 5e-4]},
            stable=rigid.librates(),
            samples=1,
            t_end=1.0,
        )


test_impossible_orbits_are_refused = refuses(
    [
        (lambda: rigid.Orbit(0.0), r"rate = 0.0: must be positive"),
        (
            lambda: rigid.Orbit(1.0, 1.0),
            r"eccentricity = 1: must be at most 0.95 \(an ellipse\), or from",
        ),
        (lambda: rigid.Orbit(1.0, 2e6), r"eccentricity = 2e\+06: .* 1e\+06 \(a hyperbola\)"),
        (
            lambda: rigid.Orbit(1.0, 2.0, -2e6),
            "anomaly = -2e\\+06: must be within 1e\\+06 rad; begin",
        ),
        (
            lambda: rigid.Orbit(1.0, 2.0, true_anomaly=2.5),
            "true_anomaly = 2.5: must be within the asymptotes of the hyperbola, 2.0944 rad",
        ),
        (lambda: rigid.Orbit.flyby(-1.0, 1.0, 1.0), "gm = -1.0: must be positive"),
        (  # the Earth in m³/s², but km and km/s
            lambda: rigid.Orbit.flyby(3.986e14, 38011.0, 5.84),
            r"eccentricity = 1.0*\d*: 1 \+ periapsis speed² / gm must .* in the same units\?",
        ),
        (
            lambda: rigid.Orbit.flyby(1.0, 1.0, 1.0, towards=(0.0, 0.6, 0.8)),
            r"towards = \[0.0, 0.6, 0.8\]: must be at right angles to normal",
        ),
        (lambda: rigid.Orbit.flyby(1.0, 1.0, 1.0, towards=(1, 1, 0)), "towards = .* a unit vector"),
        (lambda: rigid.Orbit(1.0, [0.1, 0.96]), r"eccentricity\[1\] = 0.96"),
        (lambda: rigid.Orbit(1.0, -0.1), r"eccentricity = -0.1: must not be negative"),
        (lambda: rigid.Orbit(1.0, 0.1, 1.0, true_anomaly=1.0), "anomaly, true_anomaly: give one"),
        (lambda: rigid.Orbit(1.0, normal=(1.0, 1.0, 0.0)), "normal = .*: must be a unit vector"),
        (
            lambda: rigid.Orbit(1.0, periapsis=(0.6, 0.0, 0.8)),
            r"periapsis = \[0.6, 0.0, 0.8\]: must be at right angles to normal",
        ),
        (
            lambda: rigid.Orbit(1.0, 0.3, 1.1e3),
            "anomaly = 1100: must be within 1000 rad; leave out",
        ),
        (
            lambda: rigid.Orbit(1.0, 0.3).position([1.0, 1e17]),
            r"t = 1e\+17: the orbit turns by more",
        ),
        (
            lambda: rigid.poincare(
                rigid.FreeBody(rigid.Body(MOMENTS), **FORCES["orbit"]),
                OMEGA,
                every=1e-12,
                t_end=10.0,
            ),
            "every = 1e-12: gives more than 1e\\+08 points",
        ),
        (
            lambda: rigid.Orbit([1.0, 2.0], [0.1, 0.2, 0.3]),
            "the axes of the bodies do not broadcast",
        ),
        (
            lambda: rigid.FreeBody(rigid.Body(MOMENTS), orbit=1.0),  # type: ignore[arg-type]
            "orbit = 1.0: must be a rigid.Orbit",
        ),
        (
            lambda: run_of("orbit", method="midpoint"),
            "method = 'midpoint': does not integrate the gravity gradient of an orbit",
        ),
        (lambda: run_of("rotor", tangent="rate"), "tangent = 'rate': the scene has no orbit"),
    ],
    kind=(ValueError, TypeError),
)


# Bodies on eccentric orbits: the periapsis magnifies rounding, and the stated error knows it


#: Moments, orbit, rates, attitude, time, and the rates and attitude then in 128-bit numbers, by
#: series of order 40 at 1e-32 and at 1e-34.
CASES: list[tuple[Any, ...]] = [
    (
        (0.96, 1.4, 1.08),
        rigid.Orbit(1.0, 0.95, 3.0),
        (1.5, -0.8, 0.0),
        (-0.9, 1.6, -0.5, 1.0),
        21.0,
        [-47.144768105891046, 18.015249793679153, -51.307041785797004],
        [0.1937888712995388, -0.4636536523376335, 0.8557385984334749, 0.12321775515539854],
    ),
    (
        (0.46, 0.34, 0.4),
        rigid.Orbit(1.0, 0.9, 3.0),
        (-1.0, 0.9, 1.4),
        (0.6, -1.6, 0.6, -0.5),
        26.0,
        [-8.289400899970136, -9.798108551795925, -1.2103222050030062],
        [-0.004653530758618171, 0.6118211325020102, -0.49415420292933127, 0.6176284240566602],
    ),
]

TUMBLING = rigid.FreeBody(rigid.Body((0.9, 1.3, 1.1)), orbit=rigid.Orbit(1.0, 0.9, 2.0))


def cloud(count: int) -> Floats:
    rates: Floats = np.random.default_rng(5).normal(size=(count, 3))
    return rates


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("options", [{}, {"accuracy": 1e-5}])
def test_rounding_that_a_periapsis_magnifies_is_in_the_stated_error(
    case: tuple[Any, ...], options: dict[str, Any]
) -> None:
    moments, orbit, omega, attitude, t, rates, turned = case
    scene = rigid.FreeBody(rigid.Body(moments), orbit=orbit)
    run: Any = rigid.simulate(scene, omega, attitude, t=[t], **options)
    sign = np.sign(run.attitude[0] @ turned)
    true = max(
        np.linalg.norm(run.omega[0] - rates) / np.linalg.norm(rates),
        2.0 * np.linalg.norm(sign * run.attitude[0] - turned),
    )
    assert run.status == rigid.Status.OK
    # Equal steps were off by 1.1e-5 and 5.3e-8.
    assert true < float(run.error) < 1e-6


def test_the_accuracy_that_is_asked_for_changes_no_bit_on_an_orbit() -> None:
    every: list[dict[str, Any]] = [{}, {"accuracy": 1e-4}, {"accuracy": 1e-11}, {"check": False}]
    runs = [rigid.simulate(TUMBLING, [1.0, 0.3, 0.2], t=[20.0], **options) for options in every]
    assert len({run.omega.tobytes() for run in runs}) == 1


def test_a_run_on_an_orbit_has_the_same_bits_at_other_times() -> None:
    run = rigid.simulate(TUMBLING, cloud(3), t=[0.0, 20.0], accuracy=1e-6)
    again = run.at([7.0, 20.0])
    assert again.omega[:, 1].tobytes() == run.omega[:, 1].tobytes()
    assert (again.error <= 1e-6).all()


def test_the_plan_of_a_run_on_an_orbit_says_how_it_steps() -> None:
    plan = rigid.plan(TUMBLING, omega=[1.0, 0.3, 0.2], t_end=20.0)
    run = rigid.simulate(TUMBLING, [1.0, 0.3, 0.2], t=[20.0])
    assert plan.method == run.plan.method == run.spec["method"] == "taylor20"
    assert plan.step is run.plan.step is None
    assert any("short near the periapsis" in reason for reason in plan.why)
    assert plan.why == run.plan.why
    given = rigid.simulate(TUMBLING, [1.0, 0.3, 0.2], t=[20.0], step=0.01)
    assert given.plan.method == "rk4"


def test_drag_that_stops_a_libration_on_an_orbit_is_in_the_stated_error() -> None:
    # In the plane of the orbit: the rate passes zero, where the speed has a corner.
    scene = rigid.FreeBody(
        rigid.Body((1.0, 1.6, 2.0)),
        orbit=rigid.Orbit(1.0, 0.7, 2.0),
        torque=rigid.Torque.body((0.0, 0.0, -0.2)),
        drag=0.3,
    )
    run = rigid.simulate(scene, [0.0, 0.0, 0.4], t=np.linspace(0.0, 12.0, 25))
    fine = rigid.simulate(
        scene, [0.0, 0.0, 0.4], t=np.linspace(0.0, 12.0, 25), method="rk4", step=2e-4, check=False
    )
    assert (run.omega[:, 2] > 0.0).any()
    assert (run.omega[:, 2] < 0.0).any()
    off = np.abs(run.omega - fine.omega).max() / np.abs(fine.omega).max()
    assert off < float(run.error) < 1e-8


def test_a_body_that_drag_stops_has_its_bits_without_a_check_and_reaches_an_accuracy() -> None:
    scene = rigid.FreeBody(
        rigid.Body((1.0, 1.5, 2.0)),
        orbit=rigid.Orbit(1e-9),
        torque=rigid.Torque.body((0.0, 0.0, -0.2)),
        drag=0.5,
    )
    rates, t = [0.0, 0.0, 0.5], [0.0, 1.0, 3.0, 10.0]
    # 2 w' = -0.2 - 0.5 |w| w, the gradient of 1e-18 apart: w goes through 0 as tan, then as tanh.
    end, rate = np.sqrt(0.4), 0.5 * np.sqrt(0.1)
    stop = np.arctan(0.5 / end) / rate
    true = [end * (np.tan if s < stop else np.tanh)(rate * (stop - s)) for s in t]
    runs = [rigid.simulate(scene, rates, t=t), rigid.simulate(scene, rates, t=t, check=False)]
    assert runs[0].omega.tobytes() == runs[1].omega.tobytes()
    assert runs[1].at(t).omega.tobytes() == runs[1].omega.tobytes()
    fine = rigid.simulate(scene, rates, t=t, accuracy=1e-10)
    for run, accuracy in ((runs[0], 1e-8), (fine, 1e-10)):
        off = np.abs(run.omega[:, 2] - true).max() / 0.5
        assert off < float(run.error) < accuracy
        assert run.status == rigid.Status.OK
    # The steps of a companion that tumbles are those of the series.
    both = rigid.simulate(scene, [rates, [0.3, 0.2, 0.5]], t=t, check=False)
    assert both.omega[0].tobytes() == runs[0].omega.tobytes()


def test_the_plan_under_all_further_forces_has_nothing_to_leave_out() -> None:
    scene = rigid.FreeBody(
        rigid.Body((0.9, 1.3, 1.1)),
        orbit=rigid.Orbit(1.0, 0.5),
        rotor=(0.0, 0.1, 0.0),
        drag=0.1,
        dissipation=rigid.EnergySink(1e-3),
    )
    plan = rigid.plan(scene, omega=[1.0, 0.3, 0.2], t_end=20.0)
    assert not any("computed as zeros" in reason for reason in plan.why)


# Equal steps of `rk4` and `dop853` on an orbit alone are those of its eccentric anomaly


RATE, ECCENTRICITIES = 0.7, (0.0, 0.1, 0.5, 0.9, 0.95, 1.05, 1.5, 4.0)
ORDERS = {"rk4": 4, "dop853": 8}
TIMES_ANOMALY = np.array([-3.0, 0.0, 1.0, 4.0, 9.0])


def orbit(e: float) -> rigid.Orbit:
    return rigid.Orbit(RATE, e, 2.0, normal=(0.0, 0.6, 0.8))


def scene(e: float) -> rigid.FreeBody:
    return rigid.FreeBody(rigid.Body((0.9, 1.3, 1.1)), orbit=orbit(e))


def cloud_anomaly(count: int) -> tuple[Floats, Floats]:
    rng = np.random.default_rng(4)
    attitudes = rng.normal(size=(count, 4))
    return rng.normal(size=(count, 3)), attitudes / np.linalg.norm(attitudes, axis=1)[:, None]


def simulated(e: float, count: int, **options: Any) -> rigid.Run:
    rates, attitudes = cloud_anomaly(count)
    return rigid.simulate(scene(e), rates, attitudes, t=TIMES_ANOMALY, check=False, **options)


def anomaly_at(e: float, t: float) -> float:
    """By bisection of Kepler's equation."""
    mean = RATE * t + 2.0
    return float(brentq(lambda at: at - e * np.sin(at) - mean, mean - 1.0, mean + 1.0, xtol=1e-15))


def apart(run: rigid.Run, other: rigid.Run) -> float:
    return float(rotation_angle(present(run.attitude), present(other.attitude)).max())


@pytest.mark.parametrize("e", ECCENTRICITIES)
@pytest.mark.parametrize("method", ORDERS)
def test_errors_fall_with_the_order_in_the_anomaly(e: float, method: str) -> None:
    exact = simulated(e, 8, method="taylor20", tolerance=1e-16)
    # Few enough steps that the error is above that of rounding, for all eccentricities.
    counts = (1600, 3200) if method == "rk4" else (100, 200)
    errors = []
    for count in counts:
        step = 9.0 / (count * (4 if e > 0.5 else 1))
        run = simulated(e, 8, method=method, step=step)
        off = np.abs(run.omega - exact.omega).max() / np.abs(exact.omega).max()
        errors.append(max(float(off), apart(run, exact)))
    assert errors[1] < 1e-6
    fell = np.log2(errors[0] / errors[1])
    # Half an order is that of the next term. Where rounding is reached no order is left.
    assert abs(fell - ORDERS[method]) < 0.5 or errors[1] < 1e-11


@pytest.mark.parametrize("e", [0.0, 0.3])
def test_a_step_is_the_mean_motion_times_the_given_time(e: float) -> None:
    step = 0.05
    run = simulated(e, 1, method="dop853", step=step)
    anomalies = [anomaly_at(e, t) for t in TIMES_ANOMALY]
    # Legs begin at 0 in both directions; each ends at an output time.
    legs = np.abs(np.diff(anomalies))
    assert run.steps[0] == np.ceil(legs / (RATE * step) - 1e-9).sum()


@pytest.mark.parametrize("method", ORDERS)
def test_the_jacobi_integral_is_the_drift_on_a_circle(method: str) -> None:
    step = 0.2 if method == "dop853" else 0.01
    run = simulated(0.0, 4, method=method, step=step)
    assert run.attitude is not None
    jacobi = rigid.free.jacobi_integral(scene(0.0), run.omega, run.attitude, TIMES_ANOMALY)
    off = np.abs(jacobi - jacobi[:, 1:2]).max(axis=1)
    # Relative to the kinetic energy and to what the orbit can add.
    scale = off / run.energy_drift
    kinetic = run.energy()[:, 1]
    assert (run.energy_drift > 1e-13).all()
    assert (run.energy_drift < 1e-7).all()
    assert ((scale > 0.9 * kinetic) & (scale < 100.0 * kinetic)).all()
    assert np.isnan(run.momentum_drift).all()
    eccentric = simulated(0.1, 4, method=method, step=step)
    assert np.isnan(eccentric.energy_drift).all()
    assert np.isnan(eccentric.momentum_drift).all()
    assert (eccentric.unit_drift < 1e-9).all()


def test_the_work_is_that_of_a_series_in_the_time() -> None:
    run: Any = simulated(0.5, 8, method="dop853", step=0.01)
    exact: Any = simulated(0.5, 8, method="taylor20", tolerance=1e-16)
    assert np.abs(run.work - exact.work).max() < 1e-12 * np.abs(exact.energy()).max()


def test_the_attitude_is_continuous_over_many_orbits() -> None:
    body = scene(0.3)
    t = np.linspace(0.0, 60.0, 1201)
    run: Any = rigid.simulate(body, [0.1, 0.2, 0.9], t=t, method="dop853", step=0.05, check=False)
    # Between two times the body turns by less than 0.2 rad.
    assert np.abs(np.diff(run.attitude, axis=0)).max() < 0.1
    few = rigid.simulate(body, [0.1, 0.2, 0.9], t=t[::100], method="dop853", step=0.05, check=False)
    assert few.attitude is not None
    # The same sign where no time lies between, and the same motion within its error.
    np.testing.assert_allclose(few.attitude, run.attitude[::100], atol=1e-8)


@pytest.mark.parametrize("method", ORDERS)
def test_the_stated_error_is_no_less_than_the_true_one(method: str) -> None:
    rates, attitudes = cloud_anomaly(32)  # of more some are not checked
    es = np.linspace(0.0, 0.9, 32)
    many = rigid.FreeBody(rigid.Body((0.9, 1.3, 1.1)), orbit=rigid.Orbit(RATE, es, 2.0))
    exact = rigid.simulate(
        many, rates, attitudes, t=[9.0], method="taylor20", tolerance=1e-16, check=False
    )
    for step in (0.1, 0.02):
        run = rigid.simulate(many, rates, attitudes, t=[9.0], method=method, step=step)
        sizes = np.linalg.norm(exact.omega[:, 0], axis=1)
        off = np.linalg.norm((run.omega - exact.omega)[:, 0], axis=1) / sizes
        assert np.isin(run.status, (rigid.Status.OK, rigid.Status.COARSE)).all()
        assert (off <= run.error).all()


def test_a_slow_orbit_keeps_the_digits_of_the_time() -> None:
    # The gradient of 1e-16 is nothing beside the rates: the motion is that of a free body.
    body = rigid.Body((0.9, 1.3, 1.1))
    far = rigid.FreeBody(body, orbit=rigid.Orbit(1e-8, 0.3, 2.0))
    t = [10.0, 100.0]
    run = rigid.simulate(far, [1.0, 2.0, 0.5], t=t, method="dop853", step=0.01, check=False)
    free = rigid.simulate(rigid.FreeBody(body), [1.0, 2.0, 0.5], t=t, method="exact")
    np.testing.assert_allclose(run.omega, free.omega, rtol=0.0, atol=1e-12)
    assert apart(run, free) < 1e-12


def test_an_orbit_is_written_without_its_default_numbers() -> None:
    assert repr(rigid.Orbit(1e-3, eccentricity=0.1)) == "Orbit(rate=0.001, eccentricity=0.1)"
