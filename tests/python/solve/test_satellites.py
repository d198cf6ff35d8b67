"""What acts on a satellite: an energy sink, a rotor, and the gravity gradient on an orbit."""

import itertools
from functools import cache, partial
from typing import Any

import numpy as np
import pytest
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

import quad_motion
import rigid
from adversarial import KINDS
from physics import Floats, present
from printed_equations import solved
from refusals import refuses
from rigid.model.bodies import bodies_of
from verdicts import judge

METHODS = [method.name for method in rigid.methods() if "rotor" in method.forces]

BODY = rigid.Body((1.0, 1.7, 2.2))
ATTITUDE = np.array([0.5, -0.3, 0.7, 0.4]) / np.linalg.norm([0.5, -0.3, 0.7, 0.4])
OMEGA = np.array([0.4, 1.0, -0.3])


def in_space(run: rigid.Run, rotor: ArrayLike = (0.0, 0.0, 0.0)) -> Floats:
    """The angular momentum in space, shape (m, 3)."""
    moments = np.array(run.spec["scene"]["body"]["moments"])
    found: Floats = run.rotation().apply(moments * run.omega + np.array(rotor))
    return found


CIRCLE = rigid.Orbit(0.7)
EVERYTHING = rigid.FreeBody(
    BODY,
    orbit=rigid.Orbit(0.7, 0.4, 1.0, normal=(0.0, 0.6, 0.8)),
    torque=rigid.Torque.body((0.01, 0.0, -0.02)) + rigid.Torque.space((0.0, 0.03, 0.01)),
    damping=(0.01, 0.02, 0.0),
    dissipation=rigid.EnergySink((0.05, 0.1, 0.02)),
    rotor=(0.3, -0.2, 0.5),
)
SCENES = {
    "rotor": rigid.FreeBody(BODY, rotor=(0.3, -0.2, 0.5)),
    "sink": rigid.FreeBody(BODY, dissipation=rigid.EnergySink(0.08)),
    "orbit": rigid.FreeBody(BODY, orbit=CIRCLE),
    "everything": EVERYTHING,
}


TIMES = np.linspace(0.0, 8.0, 5)


@cache
def truth(name: str) -> tuple[Floats, Floats]:
    """Rates and matrices at the times."""
    return solved(SCENES[name], OMEGA, ATTITUDE, TIMES)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("name", SCENES)
def test_a_fine_integration_of_the_printed_equations_agrees(name: str, method: str) -> None:
    asked: dict[str, Any] = {"t": TIMES, "method": method, "step": 1.0 / 256.0}
    run = rigid.simulate(SCENES[name], OMEGA, ATTITUDE, **asked)
    omega, matrices = truth(name)
    # RK4 has an error of some (step)^4, the others of rounding.
    allowed = 3e-9 if method == "rk4" else 3e-12
    assert np.abs(run.omega - omega).max() < allowed
    assert np.abs(run.rotation().as_matrix() - matrices).max() < allowed
    rates = rigid.simulate(SCENES[name], OMEGA, ATTITUDE, record="rates", **asked)
    assert np.abs(rates.omega - omega).max() < allowed
    # Work and impulse are integrated with the motion.
    assert max(run.energy_drift, run.momentum_drift) < allowed
    assert max(rates.energy_drift, rates.momentum_drift) < allowed
    balance = run.energy() - run.energy()[0] - run.work
    assert np.abs(balance).max() < allowed


@pytest.mark.parametrize("method", METHODS)
def test_errors_fall_with_the_order(method: str) -> None:
    order = next(known.order for known in rigid.methods() if known.name == method)
    # Few enough steps that the error is above that of rounding.
    few = {4: 16, 8: 16, 12: 8, 14: 8, 16: 8, 20: 6, 26: 4}[order]
    runs = [
        rigid.simulate(EVERYTHING, OMEGA, ATTITUDE, t=[4.0], method=method, step=4.0 / count)
        for count in (few, 2 * few)
    ]
    errors = [np.abs(run.omega[0] - truth("everything")[0][2]).max() for run in runs]
    assert np.log2(errors[0] / errors[1]) > order - 1.2


@pytest.mark.parametrize("name", SCENES)
def test_adaptive_steps_keep_their_tolerance(name: str) -> None:
    run = rigid.simulate(SCENES[name], OMEGA, ATTITUDE, t=TIMES, method="taylor16", tolerance=1e-12)
    assert np.abs(run.omega - truth(name)[0]).max() < 1e-11


@pytest.mark.parametrize("name", SCENES)
def test_the_balance_of_power_of_the_textbook_holds(name: str) -> None:
    t = np.linspace(0.0, 2.0, 4001)
    run = rigid.simulate(SCENES[name], OMEGA, ATTITUDE, t=t, method="taylor16")
    balance = rigid.free.power_balance(run)
    # Differences of order 2, with steps of 1 / 2000.
    assert np.abs(balance.residual).max() < 1e-5
    if name != "rotor":
        assert np.abs(balance.power).max() > 1e-2


# The energy sink.


def test_momentum_in_space_is_kept_and_the_end_is_a_flat_spin() -> None:
    body = rigid.Body((0.3, 1.7, 2.0))
    scene = rigid.FreeBody(body, dissipation=rigid.EnergySink((0.002, 0.004, 0.01)))
    t = np.linspace(0.0, 12000.0, 41)
    run = rigid.simulate(scene, [3.0, 0.02, 0.01], ATTITUDE, t=t, method="taylor16")
    momentum = in_space(run)
    size = np.linalg.norm(momentum[0])
    assert np.abs(momentum - momentum[0]).max() < 1e-12 * size
    energy = run.energy()
    assert np.all(np.diff(energy) < 1e-14 * energy[0])
    least = 0.5 * size**2 / 2.0
    assert abs(energy[-1] - least) < 1e-12 * least
    # Axis 3 lies along L.
    along = run.rotation()[-1].apply([0.0, 0.0, 1.0]) @ momentum[0] / size
    assert 1.0 - abs(along) < 1e-12


def test_a_sphere_of_viscous_fluid_lags_by_its_relative_momentum() -> None:
    """Solve ``nu lap f = 1`` for the flow ``f(r) omega' × r`` in a ball, ``f(a) = 0``."""
    a, rho, nu = 0.3, 900.0, 0.02
    r = np.linspace(0.0, a, 20001)
    flow = (r**2 - a**2) / (10.0 * nu)
    inside = np.trapezoid(rho * flow * 8.0 * np.pi / 3.0 * r**4, r)
    sink = rigid.EnergySink.viscous_sphere(a, density=rho, viscosity=nu)
    assert sink.coefficient[0] == pytest.approx(-inside, rel=1e-7)
    # f'' + 4 f'/r = 1/nu is the equation of that flow.
    slope, bend = 2.0 * r[1:] / (10.0 * nu), 2.0 / (10.0 * nu)
    np.testing.assert_allclose(bend + 4.0 * slope / r[1:], 1.0 / nu)


def test_backward_in_time_the_energy_grows() -> None:
    scene = SCENES["sink"]
    there = rigid.simulate(scene, OMEGA, t=[0.0, 5.0], method="taylor16")
    back = rigid.simulate(
        scene, there.omega[-1], present(there.attitude)[-1], t=[-5.0, 0.0], method="taylor16"
    )
    np.testing.assert_allclose(back.omega[0], OMEGA, atol=1e-12)


# The rotor.


def test_a_gyrostat_keeps_its_energy_and_its_whole_momentum() -> None:
    scene = SCENES["rotor"]
    t = np.linspace(0.0, 300.0, 31)
    run = rigid.simulate(scene, OMEGA, ATTITUDE, t=t, method="taylor20")
    momentum = in_space(run, (0.3, -0.2, 0.5))
    assert np.abs(momentum - momentum[0]).max() < 1e-12
    np.testing.assert_allclose(run.energy(), run.energy()[0], rtol=1e-12)
    assert np.abs(np.asarray(run.work)).max() < 1e-12
    kept = rigid.free.invariants(run)
    assert kept.L_space is not None
    np.testing.assert_allclose(kept.L_space, momentum, atol=1e-14)
    assert kept.drift("L_space") < 1e-12


def test_a_rotor_of_a_body_at_rest_does_not_move_it() -> None:
    scene = rigid.FreeBody(BODY, rotor=(0.0, 0.0, 2.0))
    run = rigid.simulate(scene, [0.0, 0.0, 0.0], t=[0.0, 10.0])
    np.testing.assert_array_equal(run.omega, 0.0)


# The gravity gradient.


def on_orbit(moments: ArrayLike, rate: float = 1.0) -> tuple[rigid.FreeBody, Rotation]:
    """Roll along the motion, pitch along the normal, yaw towards the centre, at t = 0.

    The normal is z of space and the centre in its direction x, so the motion is along -y.
    """
    scene = rigid.FreeBody(rigid.Body(moments), orbit=rigid.Orbit(rate, periapsis=(-1, 0, 0)))
    axes = np.array([[0.0, -1.0, 0.0], [0.0, 0.0, 1.0], [-1.0, 0.0, 0.0]]).T
    return scene, Rotation.from_matrix(axes)


def test_moons_and_satellites_have_one_convention() -> None:
    """The frequencies do not depend on the order of the axes, which the result names."""
    moon = rigid.Body.ellipsoid(1.3, 1.1, 1.0)
    known = rigid.free.libration(moon, rate=1.0)
    assert known.axes.tolist() == [1, 3]
    assert (str(known.region), str(known.reason)) == ("Lagrange", "")
    # The swing in the plane of the orbit: 3 (B - A) / C of Murray and Dermott, § 5.4.
    a, b, c = moon.moments
    assert known.pitch == pytest.approx(np.sqrt(3.0 * (b - a) / c), rel=1e-14)
    for order in itertools.permutations(range(3)):
        turned = np.array(moon.moments)[list(order)]
        axes = order.index(0) + 1, order.index(2) + 1
        for found in (
            rigid.free.libration(turned, rate=1.0),
            rigid.free.libration(turned, rate=1.0, axes=axes),
            rigid.free.libration(turned, rate=1.0, axes=(-axes[0], axes[1])),
        ):
            assert found.pitch == known.pitch
            assert found.roll_yaw.tolist() == known.roll_yaw.tolist()
            assert np.abs(found.axes).tolist() == list(axes)


def test_a_rest_without_frequencies_says_why() -> None:
    found = rigid.free.libration(
        [[1.0, 1.0, 1.5], [2.0, 2.0, 1.0], [1.0, 1.0, 1.0], [1.0, 1.5, 2.0]], rate=1.0
    )
    assert found.reason.tolist() == [
        "pitch is neutral",
        "roll and yaw are neutral",
        "pitch is neutral; roll and yaw are neutral",
        "",
    ]
    across = rigid.free.libration((1.0, 1.5, 2.0), rate=1.0, axes=(3, 1))
    assert str(across.reason) == "pitch is unstable; roll and yaw are unstable"
    with pytest.raises(ValueError, match=r"axes = \(1, -1\): must be two different axes"):
        rigid.free.libration((1.0, 1.5, 2.0), rate=1.0, axes=(1, -1))
    with pytest.raises(ValueError, match=r"axes = 3: must be two body axes, such as \(1, 3\)"):
        rigid.free.libration((1.0, 1.5, 2.0), rate=1.0, axes=3)  # type: ignore[arg-type]


def test_rest_in_the_region_of_debra_and_delp_is_stable_and_its_complement_is_not() -> None:
    rng = np.random.default_rng(5)
    sums = 0
    for _ in range(300):
        moments = np.sort(rng.uniform(0.05, 1.0, 3))
        if moments[2] >= moments[0] + moments[1]:
            continue
        # In the region of DeBra and Delp roll has the largest moment and pitch the least.
        moments = rng.permutation(moments) if rng.random() < 0.5 else moments[[2, 0, 1]]
        found = rigid.free.libration(moments, rate=1.0, axes=(3, 2))
        # The linearised equations, from differences of the equations of motion.
        exponents = np.linalg.eigvals(linearised(moments))
        is_stable = bool(np.abs(exponents.real).max() < 1e-6)
        assert bool(found.stable) == is_stable, moments
        unknown = bool(np.isnan([float(found.pitch), *found.roll_yaw]).any())
        assert unknown == (found.reason != "") == (not is_stable)
        if is_stable:
            frequencies = np.sort([float(found.pitch), *found.roll_yaw])
            np.testing.assert_allclose(np.sort(exponents.imag)[3:], frequencies, rtol=1e-8)
            sums += found.region == "DeBra-Delp"
    assert sums > 3


def linearised(own: Floats) -> Floats:
    """The matrix of small deviation vectors from rest on the orbit, by central differences."""
    moments = np.array(own)

    def rate(y: Floats) -> Floats:
        turn = Rotation.from_rotvec(y[:3]).as_matrix().T
        omega = y[3:] + turn @ np.array([0.0, 1.0, 0.0])
        o = turn @ np.array([0.0, 0.0, 1.0])
        acting = np.cross(moments * omega, omega) + 3.0 * np.cross(o, moments * o)
        normal = turn @ np.array([0.0, 1.0, 0.0])
        change = acting / moments - np.cross(normal, y[3:])
        return np.concatenate([y[3:], change])

    step = 1e-5
    return np.stack(
        [(rate(step * unit) - rate(-step * unit)) / (2.0 * step) for unit in np.eye(6)], axis=-1
    )


def test_the_jacobi_integral_is_constant_on_the_orbit() -> None:
    scene = SCENES["orbit"]
    t = np.linspace(0.0, 200.0, 41)
    run = rigid.simulate(scene, OMEGA, ATTITUDE, t=t, method="taylor20")
    jacobi = rigid.free.jacobi_integral(scene, run.omega, run.attitude, t)
    assert np.ptp(jacobi) < 1e-12 * run.energy().max()
    assert np.ptp(run.energy()) > 1e-2
    with_rotor = rigid.FreeBody(BODY, orbit=scene.orbit, rotor=(0.2, 0.1, -0.4))
    run = rigid.simulate(with_rotor, OMEGA, ATTITUDE, t=t, method="taylor20")
    jacobi = rigid.free.jacobi_integral(with_rotor, run.omega, run.attitude, t)
    assert np.ptp(jacobi) < 1e-12 * run.energy().max()


def test_dissipation_on_an_orbit_only_drains_the_jacobi_integral() -> None:
    """Of attitudes at rest the one of the least energy attracts: pitch along the normal."""
    scene, _ = on_orbit((1.5, 1.9, 1.1))
    damped = rigid.FreeBody(scene.body, orbit=scene.orbit, dissipation=rigid.EnergySink(0.15))
    t = np.linspace(0.0, 600.0, 301)
    run = rigid.simulate(damped, [0.2, 0.9, 0.1], ATTITUDE, t=t, method="taylor16")
    jacobi = rigid.free.jacobi_integral(damped, run.omega, run.attitude, t)
    assert np.all(np.diff(jacobi) < 1e-12)
    np.testing.assert_allclose(np.abs(run.omega[-1]), [0.0, 1.0, 0.0], atol=1e-4)


def test_on_an_orbit_the_rates_are_bounded() -> None:
    """The bound from the Jacobi integral holds, and does not grow with the horizon."""
    rng = np.random.default_rng(3)
    for _ in range(40):
        moments = rng.uniform(1.0, 1.9, 3)
        rate = float(10.0 ** rng.uniform(-2.0, 1.0))
        scene = rigid.FreeBody(
            rigid.Body(moments),
            orbit=rigid.Orbit(rate),
            rotor=rng.normal(size=3),
        )
        omega = rng.normal(size=3)
        bodies = bodies_of(scene, omega)
        bounds = [float(bodies.fastest_rates((0.0, horizon))[0]) for horizon in (20.0, 1e6)]
        assert bounds[0] == bounds[1]
        run = rigid.simulate(scene, omega, t=np.linspace(0.0, 20.0, 400), record="rates")
        assert np.linalg.norm(run.omega, axis=1).max() <= bounds[0]


# Requests.


def test_nothing_acts_if_all_is_zero() -> None:
    scene = rigid.FreeBody(BODY, rotor=(0.0, 0.0, 0.0), dissipation=rigid.EnergySink(0.0))
    assert scene == rigid.FreeBody(BODY)
    assert rigid.plan(scene, "rates").method == "exact"


BY_MIDPOINT = "'midpoint': does not integrate (a rotor|dissipation|drag|the gravity gradient)"

test_bad_numbers_are_refused = refuses(
    [
        *(
            (partial(rigid.simulate, scene, OMEGA, t=[1.0], method="midpoint"), BY_MIDPOINT)
            for scene in SCENES.values()
        ),
        (
            lambda: rigid.FreeBody(BODY, dissipation=0.1),  # type: ignore[arg-type]
            TypeError,
            "must be a rigid.EnergySink",
        ),
        (lambda: rigid.EnergySink(-1.0), r"coefficient = -1.0: must not be negative"),
        (lambda: rigid.EnergySink((1.0, np.nan, 0.0)), r"coefficient\[1\] = nan: must be finite"),
        (lambda: rigid.EnergySink((1.0, 2.0)), r"coefficient: expected shape \(\) or \(..., 3\)"),
        (
            lambda: rigid.EnergySink.viscous_sphere(0.0, density=1.0, viscosity=1.0),
            "radius = 0.0: must be positive",
        ),
        (
            lambda: rigid.EnergySink.viscous_sphere(1e60, density=1.0, viscosity=1.0),
            "radius = 1e\\+60: the coefficient, inf, leaves the range of doubles",
        ),
        (lambda: rigid.FreeBody(BODY, rotor=(1.0, 2.0)), r"rotor: expected shape \(..., 3\), got"),
        (
            lambda: rigid.free.jacobi_integral(SCENES["sink"], OMEGA, ATTITUDE, 0.0),
            "has no orbit; give rigid.FreeBody one by orbit=",
        ),
        (
            lambda: rigid.free.jacobi_integral(EVERYTHING, OMEGA, ATTITUDE, 0.0),
            "the Jacobi integral is constant on a circle",
        ),
        (
            lambda: rigid.simulate(
                rigid.FreeBody(rigid.Body([1e-300] * 3), rotor=(1e10, 0.0, 0.0)), OMEGA, t=[1.0]
            ),
            "rotor: must be below 1e308 times the largest moment",
        ),
    ]
)


@pytest.mark.parametrize("name", SCENES)
def test_points_of_a_section_lie_on_it(name: str) -> None:
    points = rigid.poincare(SCENES[name], OMEGA, ATTITUDE, "omega2", t_end=40.0)
    assert len(points.t) >= 3
    omega, _ = solved(SCENES[name], OMEGA, ATTITUDE, np.array([0.0, *points.t]))
    assert np.abs(omega[1:, 1]).max() < 1e-10


@pytest.mark.skipif(not quad_motion.is_available(), reason="no 128-bit numbers")
def test_stated_errors_of_random_satellites_are_true() -> None:
    """Rotors, sinks and orbits of all sizes against 128-bit numbers of another program.

    ``tests/long/stated_errors.py --kinds satellite`` runs more of them.
    """
    kinds = {"satellite": KINDS["satellite"]}
    findings = [judge(number, 1, kinds) for number in range(10)]
    verdicts = [one.verdict for one in findings]
    assert verdicts.count("UNDETECTED") == 0
    assert verdicts.count("right") > 7
