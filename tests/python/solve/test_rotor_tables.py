"""Rotors whose momentum a table gives: spin-up in closed form, SciPy, momentum in space."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import rigid
from physics import Floats
from refusals import refuses

METHODS = [method.name for method in rigid.methods() if "rotor" in method.forces]
KNOTS = np.array([-3.0, 0.0, 1.5, 4.0, 7.0, 12.0])
MOMENTA = np.array(
    [[0.2, 0, 0], [0, 0.1, 0.3], [0.3, 0.2, -0.4], [0, 0, 1.0], [-0.5, 0.1, 0.2], [0, 0.6, 0]]
)
BODY = rigid.Body((1.0, 1.6, 2.1))
OMEGA, ATTITUDE = np.array([0.3, -0.2, 0.5]), np.array([0.8, 0.1, 0.5, -0.3])


def tables(rotor: rigid.RotorTable, body: rigid.Body = BODY, **forces: Any) -> rigid.FreeBody:
    return rigid.FreeBody(body, rotor=rotor, **forces)


@pytest.mark.parametrize("method", METHODS)
def test_a_wheel_along_the_axis_of_symmetry_spins_up(method: str) -> None:
    """``I3 omega3 + h`` is constant; across, the rates turn by the integral of a known rate."""
    across, along = 1.3, 0.7
    h = np.array([0.0, 0.0, 0.4, 0.4, -0.2, 0.1])
    momenta = np.stack([0.0 * h, 0.0 * h, h], axis=1)
    scene = tables(rigid.RotorTable(KNOTS, momenta), rigid.Body((across, across, along)))
    t = np.linspace(0.0, 12.0, 25)
    run = rigid.simulate(scene, OMEGA, t=t, method=method)
    now = np.interp(t, KNOTS, h)
    whole = along * OMEGA[2] + now[0]
    inner = np.linspace(0.0, t, 4801)  # the trapezoids of a fine grid with all knots
    area = np.trapezoid(np.interp(inner, KNOTS, h), inner, axis=0)
    phase = ((across - along) / along * (whole * t - area) - area) / across
    turned = (OMEGA[0] + 1j * OMEGA[1]) * np.exp(-1j * phase)
    exact = np.stack([turned.real, turned.imag, (whole - now) / along], axis=1)
    # Of the trapezoids across a knot: an eighth of a spacing squared times the change of slope.
    grid = 0.125 * 0.0025**2
    allowed = run.error * np.linalg.norm(OMEGA) + 4.0 * grid
    assert (np.abs(run.omega - exact).max(axis=1) <= allowed).all()
    in_space = run.momentum("space")
    np.testing.assert_allclose(in_space, np.tile(in_space[0], (25, 1)), rtol=0.0, atol=1e-7)


@pytest.mark.parametrize("options", [{}, {"accuracy": 1e-11}, {"method": "taylor20"}])
def test_the_momentum_of_any_body_is_constant_in_space(options: dict[str, Any]) -> None:
    scene = tables(rigid.RotorTable(KNOTS, MOMENTA), dissipation=rigid.EnergySink(0.02))
    t = np.linspace(0.0, 12.0, 9)
    run = rigid.simulate(scene, OMEGA, ATTITUDE, t=t, **options)
    in_space = run.momentum("space")
    np.testing.assert_allclose(in_space, np.tile(in_space[0], (9, 1)), rtol=0.0, atol=1e-8)
    kept = rigid.free.invariants(run).L_space
    assert kept is not None
    assert np.abs(kept - in_space).max() < 1e-12


def rate(t: float, y: Floats, inertia: Floats, damping: float, torque: Floats) -> Floats:
    """``I omega' = (I omega + h) x omega - h' + torque - D omega``, on an interval of the table."""
    piece = int(np.clip(np.searchsorted(KNOTS, t, side="right") - 1, 0, len(KNOTS) - 2))
    slope = (MOMENTA[piece + 1] - MOMENTA[piece]) / (KNOTS[piece + 1] - KNOTS[piece])
    h = MOMENTA[piece] + slope * (t - KNOTS[piece])
    gained = np.cross(inertia * y + h, y) - slope + torque - damping * y
    return np.asarray(gained / inertia)


@pytest.mark.parametrize("end", [10.0, -2.0])
def test_motions_are_those_of_scipy(end: float) -> None:
    torque, damping = np.array([0.05, 0.0, -0.02]), 0.03
    scene = tables(
        rigid.RotorTable(KNOTS, MOMENTA), torque=rigid.Torque.body(torque), damping=damping
    )
    y, now = OMEGA, 0.0
    inner = [knot for knot in KNOTS if min(0.0, end) < knot < max(0.0, end)]
    for knot in sorted([*inner, end], key=abs):
        # Within an interval, where the equation has no jump.
        middle = 0.5 * (now + knot)
        piece = int(np.searchsorted(KNOTS, middle, side="right") - 1)

        def inside(t: float, y: Floats, piece: int = piece) -> Floats:
            low, high = KNOTS[piece], np.nextafter(KNOTS[piece + 1], -np.inf)
            return rate(float(np.clip(t, low, high)), y, np.array(BODY.moments), damping, torque)

        y = solve_ivp(inside, (now, knot), y, "DOP853", rtol=1e-13, atol=1e-13).y[:, -1]
        now = knot
    run = rigid.simulate(scene, OMEGA, t=[end], accuracy=1e-11)
    np.testing.assert_allclose(run.omega[0], y, rtol=0.0, atol=1e-9)
    assert run.energy_drift < 1e-9


def test_a_wheel_that_speeds_up_takes_power_from_its_body() -> None:
    """``dT/dt = -h'·omega``, less what an energy sink takes: without knots, of order 2 in time."""
    wheel = rigid.RotorTable([0.0, 2.0], MOMENTA[:2])
    sink = rigid.EnergySink((0.002, 0.004, 0.01))
    t = np.linspace(0.0, 2.0, 4001)
    for scene in (tables(wheel), tables(wheel, dissipation=sink)):
        run = rigid.simulate(scene, np.stack([OMEGA, 2.0 * OMEGA]), t=t)
        balance = rigid.free.power_balance(run)
        assert np.abs(balance.residual).max() < 1e-5
    taken = -run.omega @ (MOMENTA[1] - MOMENTA[0]) / 2.0
    assert np.abs(taken).max() > 1e-2
    # The sink takes the rest, and it only takes.
    assert (balance.power < taken).all()


def test_each_body_has_its_wheel() -> None:
    momenta = np.stack([MOMENTA, -MOMENTA, 0.5 * MOMENTA])
    # The core scales each body by a power of two of its own.
    bodies = rigid.Body(np.outer([1.0, 40.0, 0.03], BODY.moments))
    many = tables(rigid.RotorTable(KNOTS, momenta), bodies)
    assert many.shape == (3,)
    t = np.array([[1.0, 2.0], [3.0, 4.0], [5.0, 9.0]])
    together = rigid.simulate(many, OMEGA, ATTITUDE, t=t)
    for k in range(3):
        alone = tables(rigid.RotorTable(KNOTS, momenta[k]), bodies[k])
        assert many[k] == alone
        run = rigid.simulate(alone, OMEGA, ATTITUDE, t=t[k])
        np.testing.assert_array_equal(together.omega[k], run.omega)
        np.testing.assert_array_equal(together.momentum()[k], run.momentum())


def test_a_constant_table_is_a_rotor() -> None:
    h = [0.1, -0.3, 0.4]
    by_table = tables(rigid.RotorTable(KNOTS, np.tile(h, (6, 1))))
    constant = rigid.FreeBody(BODY, rotor=h)
    runs = [rigid.simulate(scene, OMEGA, t=[9.0], accuracy=1e-12) for scene in (by_table, constant)]
    np.testing.assert_allclose(runs[0].omega, runs[1].omega, rtol=0.0, atol=1e-11)


def test_a_table_in_the_axes_of_a_drawing() -> None:
    axes = rigid.rotations.quaternion_to_matrix(ATTITUDE / np.linalg.norm(ATTITUDE))
    drawn = rigid.FreeBody(BODY, rotor=rigid.RotorTable(KNOTS, MOMENTA @ axes.T), frame=axes)
    assert isinstance(drawn.rotor, rigid.RotorTable)
    np.testing.assert_allclose(drawn.rotor.momentum, MOMENTA, rtol=0.0, atol=1e-15)


def test_a_function_acts_beside_the_table() -> None:
    def brake(t: float, omega: Any, attitude: Any, data: Any, torque: Any) -> None:
        for k in range(3):
            torque[k] = -0.03 * omega[k]

    called = tables(rigid.RotorTable(KNOTS, MOMENTA), torque=rigid.Torque.call(brake, fastest=3.0))
    damped = tables(rigid.RotorTable(KNOTS, MOMENTA), damping=0.03)
    runs = [rigid.simulate(scene, OMEGA, t=[10.0], accuracy=1e-9) for scene in (called, damped)]
    np.testing.assert_allclose(runs[0].omega, runs[1].omega, rtol=0.0, atol=1e-8)


def small_map(**options: Any) -> Any:
    return rigid.stability_map(
        tables(rigid.RotorTable(KNOTS, MOMENTA)),
        **{
            "axes": {"omega1": [0.1, 1.2]},
            "start": rigid.Start(omega=(0.1, 0.2, 0.3), noise=rigid.normal(0.2)),
            "stable": rigid.no_flip(3),
            "samples": 40,
            "t_end": 10.0,
            "rng": 1,
            **options,
        },
    )


def test_maps_under_a_table_are_those_of_their_runs() -> None:
    result = small_map()
    for pixel in range(2):
        for sample in range(0, 40, 8):
            one = result.replay(pixel=pixel, sample=sample)
            run = rigid.simulate(
                result.spec.scene, one.omega, one.attitude, t=np.linspace(0.0, 10.0, 4001)
            )
            flips = bool(np.any(np.diff(np.sign(run.omega[:, 2]))))
            assert one.outcome == ("unstable" if flips else "stable")
            np.testing.assert_allclose(one.run.omega[-1], run.omega[-1], rtol=0.0, atol=1e-6)


test_what_a_table_cannot = refuses(
    [
        (lambda: rigid.RotorTable([0.0], [(0, 0, 1)]), "t of 1 times: must be two or more"),
        (lambda: rigid.RotorTable([0, 0], [(0, 0, 1)] * 2), "no two of them equal"),
        (lambda: rigid.RotorTable([0, 1], [(0, 0, 1)]), r"momentum: expected shape \(..., 2, 3\)"),
        (lambda: rigid.RotorTable([0, 1], [(0, 0, np.nan)] * 2), "momentum.* must be finite"),
        (
            lambda: rigid.simulate(tables(rigid.RotorTable([0, 1], MOMENTA[:2])), OMEGA, t=[2.0]),
            "t = 2: the table of the rotor does not reach this time",
        ),
        (lambda: small_map(axes={"rotor1": [0.1, 0.2]}), "the rotor of the scene is a table"),
        (
            lambda: rigid.simulate(
                tables(rigid.RotorTable(KNOTS, MOMENTA)),
                OMEGA,
                t=[1.0],
                events=[rigid.crosses("L1", 0.1)],
            ),
            "the momentum of a rotor by a table is not watched",
        ),
    ]
)
