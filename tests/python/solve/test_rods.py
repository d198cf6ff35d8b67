"""Bodies without a moment about their axis: rods and dumbbells; and mass points."""

import math
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import rigid
from refusals import refuses
from rigid import exact

ROD = rigid.Body.rod(2.0, mass=3.0)
#: About its end: I = m l²/3, mgl = m g l/2.
PENDULUM = rigid.HeavyTop.from_mass(ROD, com=(0.0, 0.0, 1.0))[0]
TIMES = np.linspace(0.0, 10.0, 41)


def axes(run: rigid.Run) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Body axis 3 in space."""
    assert run.attitude is not None
    w, x, y, z = run.attitude.T
    return np.stack([2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)], -1)


def test_a_free_rod_turns_uniformly_about_its_angular_momentum() -> None:
    run = rigid.simulate(ROD, [0.3, 0.4, 0.0], t=TIMES)
    assert run.plan.method == "exact"
    # L is along omega = (0.3, 0.4, 0), at right angles to the rod: a(t) = a cos + (l x a) sin.
    angle = 0.5 * TIMES[:, None]
    expected = np.cos(angle) * [0.0, 0.0, 1.0] + np.sin(angle) * [0.8, -0.6, 0.0]
    np.testing.assert_allclose(axes(run), expected, atol=1e-14)
    np.testing.assert_allclose(run.energy(), 0.125, rtol=1e-15)
    motion = exact.free_body(ROD, [0.3, 0.4, 0.0])
    assert (float(motion.precession), float(motion.flip_time)) == (0.5, math.inf)
    assert exact.free_body(ROD, [0.3, 0.4, 1e-17]).amplitude.tolist() == [0.3, 0.4, 0.0]


def test_a_rod_on_a_pivot_is_a_spherical_pendulum() -> None:
    """Against `a'' = (g·a a - g) k - |a'|² a`, k = mgl/I, of the end of the rod by SciPy."""
    assert PENDULUM.body.moments == (4.0, 4.0, 0.0)
    attitude = [math.cos(0.4), math.sin(0.4), 0.0, 0.0]
    omega = [0.3, 0.9, 0.0]
    run = rigid.simulate(PENDULUM, omega, attitude, t=TIMES)
    assert run.plan.method == "exact"
    strength = PENDULUM.mgl / 4.0
    up = np.array([0.0, 0.0, 1.0])

    def change(_t: float, y: Any) -> Any:
        a, rate = y[:3], y[3:]
        along = (strength * a[2] - rate @ rate) / (a @ a)
        return np.concatenate([rate, along * a - strength * up])

    start = axes(run)[0]
    turn = rigid.rotations.quaternion_to_matrix(np.array(attitude))
    first = np.concatenate([start, np.cross(turn @ omega, start)])
    truth = solve_ivp(change, (0.0, 10.0), first, "DOP853", TIMES, rtol=3e-14, atol=1e-16)
    # The length of `a` drifts with the square of the time: 3e-14 becomes 1e-11 in 10 s.
    np.testing.assert_allclose(axes(run), truth.y[:3].T, rtol=0, atol=1e-10)
    motion = exact.lagrange_top(PENDULUM, omega, attitude)
    assert motion.kind == "spherical pendulum"


@pytest.mark.parametrize("method", ["dop853", "taylor16", "splitting4"])
def test_steps_move_a_rod_as_the_closed_form_does(method: str) -> None:
    start = [0.3, 0.9, 0.0], [math.cos(0.4), math.sin(0.4), 0.0, 0.0]
    known = rigid.simulate(PENDULUM, *start, t=TIMES)
    run = rigid.simulate(PENDULUM, *start, t=TIMES, method=method, accuracy=1e-9)
    np.testing.assert_allclose(run.omega, known.omega, atol=1e-8)
    assert (run.omega[:, 2] == 0.0).all()
    motion = rigid.Motion(PENDULUM, *start, method="dop853")
    for _ in range(40):
        motion.step(0.25 / 8.0)
    np.testing.assert_allclose(motion.omega, known.omega[5], atol=1e-6)


def test_a_map_of_rods_is_that_of_spherical_pendulums() -> None:
    def share(body: rigid.Body) -> list[float]:
        result = rigid.stability_map(
            rigid.HeavyTop(body, mgl=1.0),
            axes={"tilt": [1.0, 2.0, 2.8]},
            samples=64,
            t_end=20.0,
            stable=rigid.tilt_between(0.5, math.pi, axis=3),
            start=rigid.Start(omega=(0.0, 0.0, 0.0), noise=rigid.normal((0.9, 0.9, 0.0))),
            rng=1,
        )
        found: list[float] = result.share.tolist()
        return found

    assert share(rigid.Body((1.0, 1.0, 0.0))) == share(rigid.Body((1.0, 1.0, 1.0)))


def test_a_replay_of_a_map_of_rods_moves_a_rod() -> None:
    found = maps(noise=rigid.normal((0.1, 0.1, 0.0))).replay((1,), 1)
    scene = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.0)), mgl=1.0)
    assert found.run.spec["scene"] == scene.to_dict()
    assert (found.run.omega[:, 2] == 0.0).all()
    expected = rigid.simulate(scene, found.omega, found.attitude, t=found.run.t)
    np.testing.assert_array_equal(found.run.attitude, expected.attitude)


def test_dumbbells_of_points_and_tensors_are_rods() -> None:
    body, frame = rigid.Body.from_points([1.0, 1.0], [[0.6, 0.0, 0.8], [-0.6, 0.0, -0.8]])
    assert body.moments == (0.0, pytest.approx(2.0), body.moments[1])
    np.testing.assert_allclose(np.abs(frame[:, 0]), [0.6, 0.0, 0.8], atol=1e-15)
    assert rigid.simulate(body, [0.0, 0.3, 0.4], t=[1.0]).plan.method == "exact"
    # Along the axes of the points, where the rate about the dumbbell is zero to rounding.
    run = rigid.simulate(body, [0.8, 0.3, -0.6], t=[0.0, 3.0], frame=frame)
    np.testing.assert_allclose(run.energy(), 1.09, rtol=1e-14)
    assert rigid.Body.from_tensor(rigid.solids.rod(2.0, mass=3.0).tensor)[0].moments == (0, 1, 1)


SPIN = "a rod has no moment about its axis"


test_what_would_spin_a_rod_is_refused = refuses(
    [
        (lambda: rigid.simulate(ROD, [0.3, 0.4, 0.1], t=[1.0]), f"omega = .*{SPIN} and cannot"),
        (lambda: exact.free_body(ROD, [1.0, 0.0, 1.0]), rf"omega = \[1.0, .*{SPIN} and cannot"),
        (lambda: ROD.gammas, SPIN),
        (lambda: rigid.free.euler_rhs(ROD, [0.1, 0.2, 0.0]), SPIN),
        (lambda: exact.sleeping_spin(PENDULUM), SPIN),
        (lambda: rigid.simulate(ROD, [0.1, 0.2, 0.0], t=[1.0], tangent=True), SPIN),
        (lambda: rigid.lyapunov(PENDULUM, [0.1, 0.2, 0.0], t=10.0), SPIN),
        (lambda: rigid.fit(ROD, [0, 1, 2], omega=np.ones((3, 3)), sigma=0.1, free=["I1"]), SPIN),
        (
            lambda: rigid.simulate(rigid.FreeBody(ROD, damping=0.1), [0.3, 0.4, 0.0], t=[1.0]),
            "no rod moves under damping",
        ),
        (
            lambda: rigid.simulate(
                rigid.FreeBody(ROD, orbit=rigid.Orbit(1.0)), [0.3, 0.4, 0.0], t=[1.0]
            ),
            "no rod moves under ",
        ),
        (
            lambda: rigid.simulate(
                rigid.HeavyTop(rigid.Body((1, 1, 0)), mgl=1.0, com=(1, 0, 0)), [0.1, 0, 0], t=[1.0]
            ),
            "the mass of a rod is on its axis",
        ),
        (
            lambda: rigid.Motion(ROD, [0.3, 0.4, 0.0]).step(0.1, torque=(0.0, 0.0, 1.0)),
            "torque: could spin a rod",
        ),
        (lambda: maps(noise=rigid.normal(0.1)), "noise: a rod has no moment .* with 0 for axis 3"),
        (lambda: maps(omega=(0.1, 0.2, 0.3)), f"start: omega = .*{SPIN} and cannot"),
        (lambda: maps(damping=0.1), "scene: no rod moves under damping"),
        (lambda: maps(stable=rigid.regular()), SPIN),
        (lambda: maps(com=(0.0, 1.0, 0.0)), "com: the mass of a rod is on its axis"),
        (lambda: rigid.Body.rod(0.0), "length = 0.0: must be positive"),
    ],
)


def maps(
    *,
    omega: tuple[float, float, float] = (0.1, 0.2, 0.0),
    noise: rigid.Noise | None = None,
    stable: Any = None,
    **scene: Any,
) -> rigid.StabilityMap:
    return rigid.stability_map(
        rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.0)), **{"mgl": 1.0, **scene}),
        axes={"omega1": [0.1, 0.2]},
        samples=2,
        t_end=5.0,
        stable=rigid.tilt_below(3.0) if stable is None else stable,
        start=rigid.Start(omega=omega, noise=noise),
        rng=1,
    )
