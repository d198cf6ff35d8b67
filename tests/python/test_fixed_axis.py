"""A body in bearings: torques, balance, and the analogy with motion along a line."""

from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from physics import ROUNDOFF, Floats, derivative, tensor_of_points
from refusals import refuses
from rigid import fixed_axis, particles

#: Five particles; they turn about n by 0.8 t + 0.6 t².
_RNG = np.random.default_rng(3)
MASSES = _RNG.uniform(0.5, 2.0, 5)
ARMS = _RNG.normal(size=(5, 3))
INERTIA = tensor_of_points(MASSES, ARMS)
TIME, GROWTH = 0.43, 1.2


def angle(t: float) -> float:
    return 0.8 * t + 0.6 * t * t


def rate(t: float) -> float:
    return 0.8 + GROWTH * t


AXES = {"z": [0.0, 0.0, 1.0], "x": [2.0, 0.0, 0.0], "oblique": [1.0, -0.4, 0.7]}


def turn(t: float, axis: list[float]) -> Floats:
    unit = np.array(axis) / np.linalg.norm(axis)
    return np.asarray(Rotation.from_rotvec(angle(t) * unit).as_matrix())


def momenta(t: float, axis: list[float]) -> Floats:
    """Momentum and angular momentum in space, particle by particle."""
    unit = np.array(axis) / np.linalg.norm(axis)
    r = ARMS @ turn(t, axis).T
    totals = particles.particle_totals(MASSES, r, np.cross(rate(t) * unit, r))
    return np.stack([totals.momentum, totals.angular_momentum])


def rates_of_change(t: float, axis: list[float]) -> Floats:
    """Of both momenta: truncation 1e-14 and rounding 1e-13 of some tens."""
    return derivative(lambda then: momenta(then, axis), t, 2e-3)


@pytest.mark.parametrize("axis", AXES.values(), ids=AXES.keys())
def test_torque_is_the_rate_of_change_of_the_angular_momentum(axis: list[float]) -> None:
    found = fixed_axis.bearing_torques(INERTIA, rate(TIME), GROWTH, axis=axis, angle=angle(TIME))
    force, torque = rates_of_change(TIME, axis)
    np.testing.assert_allclose(found.torque_space, torque, atol=1e-9)
    np.testing.assert_allclose(
        found.angular_momentum_space, momenta(TIME, axis)[1], atol=256 * ROUNDOFF * 10
    )
    to_space = turn(TIME, axis)
    np.testing.assert_allclose(to_space @ found.torque, torque, atol=1e-9)
    # Along the axis and across it.
    unit = np.array(axis) / np.linalg.norm(axis)
    moment = unit @ INERTIA @ unit
    assert found.driving == pytest.approx(moment * GROWTH, rel=1e-14)
    assert found.bearing @ unit == pytest.approx(0.0, abs=64 * ROUNDOFF * 10)
    np.testing.assert_allclose(found.bearing + found.driving * unit, found.torque, atol=1e-14)
    # And the force on the centre of mass.
    com = MASSES @ ARMS / MASSES.sum()
    push = fixed_axis.bearing_forces(MASSES.sum(), com, rate(TIME), GROWTH, axis=axis)
    np.testing.assert_allclose(to_space @ push, force, atol=1e-9)


def test_about_z_the_torque_is_that_of_the_products() -> None:
    w = rate(TIME)
    found = fixed_axis.bearing_torques(INERTIA, w, GROWTH).torque
    ixz, iyz, izz = INERTIA[:, 2]
    expected = [ixz * GROWTH - iyz * w * w, iyz * GROWTH + ixz * w * w, izz * GROWTH]
    np.testing.assert_allclose(found, expected, rtol=1e-14)


def test_products_change_in_space_and_the_moment_about_the_axis_does_not() -> None:
    """It is printed as time-dependent; and eq. (29) with products of the body is another torque."""
    then, now = (tensor_of_points(MASSES, ARMS @ turn(t, AXES["z"]).T) for t in (0.0, 0.9))
    assert then[2, 2] == pytest.approx(15.386947, abs=5e-7)
    assert now[2, 2] == pytest.approx(float(then[2, 2]), rel=1e-14)
    assert (then[0, 2], now[0, 2]) == (pytest.approx(0.40, abs=5e-3), pytest.approx(0.96, abs=5e-3))
    # If it did depend on time as the products do, the torque about z would not be I_zz omega'.
    found = fixed_axis.bearing_torques(then, [0.3, 5.0], GROWTH)
    assert found.driving.tolist() == [then[2, 2] * GROWTH] * 2
    # The tempting misuse: eq. (29) is in space, its products are not those of the body.
    truth = rates_of_change(TIME, AXES["z"])[1]
    misused = turn(TIME, AXES["z"]) @ (then[:, 2] * GROWTH)
    assert np.abs(misused - truth).max() > 0.05 * np.abs(truth).max()
    right = fixed_axis.bearing_torques(then, rate(TIME), GROWTH, angle=angle(TIME)).torque_space
    np.testing.assert_allclose(right, truth, atol=1e-9)


def wheel() -> tuple[Floats, Floats]:
    """Two regular hexagons about the z axis, at different heights."""
    phase = np.arange(6) * np.pi / 3
    ring = np.stack([np.cos(phase), np.sin(phase), 0 * phase], axis=1)
    up = np.array([0.0, 0.0, 1.0])
    arms = np.concatenate([ring + 0.4 * up, 0.3 * ring - 0.9 * up])
    return np.ones(12), arms


def test_a_symmetric_wheel_is_balanced_and_needs_no_bearing() -> None:
    masses, arms = wheel()
    inertia = tensor_of_points(masses, arms)
    com = masses @ arms / masses.sum()
    found = fixed_axis.balance_test(inertia, mass=masses.sum(), com=com)
    assert found.balanced
    assert inertia[2, 2] == pytest.approx((arms[:, :2] ** 2).sum(), rel=1e-14)
    torque = fixed_axis.bearing_torques(inertia, 100.0, 3.0)
    # Rounding of the products times omega².
    assert np.abs(torque.bearing).max() < 1e4 * 64 * ROUNDOFF
    assert torque.driving == pytest.approx(3.0 * inertia[2, 2])


def test_balance_at_rest_and_balance_when_turning_are_two_things() -> None:
    masses, arms = wheel()
    # A weight on the rim: neither. Two, opposite and at different heights: at rest only.
    for extra, static, dynamic in (
        ([[1.0, 0, 0.4]], False, False),
        ([[1.0, 0, 0.4], [-1.0, 0, -0.9]], True, False),
        ([[1.0, 0, 0.4], [-1.0, 0, 0.4]], True, True),
        ([[1.0, 0, 0.0]], False, True),
    ):
        both = np.concatenate([arms, extra])
        weights = np.concatenate([masses, 0.1 * np.ones(len(extra))])
        found = fixed_axis.balance_test(
            tensor_of_points(weights, both), mass=weights.sum(), com=weights @ both / weights.sum()
        )
        assert (bool(found.static), bool(found.dynamic)) == (static, dynamic)
        assert bool(found.balanced) == (static and dynamic)
        force = fixed_axis.bearing_forces(weights.sum(), weights @ both / weights.sum(), 10.0)
        assert np.linalg.norm(force) == pytest.approx(
            weights.sum() * float(found.offset) * 100.0, abs=1e-11
        )
        torque = fixed_axis.bearing_torques(tensor_of_points(weights, both), 10.0)
        assert np.linalg.norm(torque.bearing) == pytest.approx(
            float(found.product) * 100.0, abs=1e-11
        )


def test_a_principal_axis_is_dynamically_balanced() -> None:
    _, axes = np.linalg.eigh(INERTIA)
    for axis in axes.T:
        found = fixed_axis.balance_test(INERTIA, mass=1.0, com=3.0 * axis, axis=axis)
        assert found.balanced
    assert not fixed_axis.balance_test(INERTIA, mass=1.0, com=[0.0, 0, 0], axis=[1, 0, 0]).balanced
    # A rod, whose moment about itself is zero, turns about itself for nothing.
    rod = fixed_axis.bearing_torques(np.diag([2.0, 2.0, 0.0]), 5.0, 3.0)
    assert rod.torque.tolist() == [0.0, 0.0, 0.0]


def test_many_rates_and_bodies_at_once() -> None:
    bodies = np.stack([INERTIA, tensor_of_points(MASSES, 2.0 * ARMS)])
    found = fixed_axis.bearing_torques(bodies, np.ones((4, 1)), [1.0, 2.0])
    assert found.torque.shape == (4, 2, 3)
    assert found.driving.shape == (4, 2)
    np.testing.assert_allclose(
        found.torque[2, 1], fixed_axis.bearing_torques(bodies[1], 1.0, 2.0).torque
    )
    assert fixed_axis.bearing_torques(bodies[:0], 1.0).torque.shape == (0, 3)
    assert fixed_axis.balance_test(bodies[:0], mass=1.0, com=np.zeros(3)).static.shape == (0,)


# The analogy


def dimension(*parts: tuple[fixed_axis.Quantity, int]) -> tuple[int, ...]:
    """That of a product of powers."""
    return tuple(
        sum(power * quantity.dimension[unit] for quantity, power in parts) for unit in range(3)
    )


def test_the_analogy_has_seven_rows_with_the_same_laws_on_both_sides() -> None:
    table = fixed_axis.analogy_table()
    assert [row.rotation.symbol for row in table] == [
        "I_zz",
        "phi",
        "omega",
        "omega'",
        "L_z",
        "I_zz omega²/2",
        "N_z",
    ]
    second = fixed_axis.Quantity("time", "t", "s", (0, 0, 1))
    for side in ("rotation", "translation"):
        inertia, place, speed, growth, momentum, energy, drive = (
            getattr(row, side) for row in table
        )
        assert dimension((place, 1), (second, -1)) == speed.dimension
        assert dimension((speed, 1), (second, -1)) == growth.dimension
        assert dimension((inertia, 1), (speed, 1)) == momentum.dimension
        assert dimension((inertia, 1), (speed, 2)) == energy.dimension
        assert dimension((inertia, 1), (growth, 1)) == drive.dimension
        assert dimension((drive, 1), (place, 1)) == energy.dimension
        assert dimension((drive, 1), (second, 1)) == momentum.dimension
    # The two sides differ by lengths alone, that of an arm; an energy is an energy.
    for row in table:
        mass, _, time = np.subtract(row.rotation.dimension, row.translation.dimension)
        assert (mass, time) == (0, 0)
    assert table[5].rotation.dimension == table[5].translation.dimension


#: Units as printed, in kg, m and s.
UNITS = {
    "kg": (1, 0, 0),
    "m": (0, 1, 0),
    "m²": (0, 2, 0),
    "rad": (0, 0, 0),
    "s": (0, 0, 1),
    "s²": (0, 0, 2),
    "J": (1, 2, -2),
    "N": (1, 1, -2),
}


def test_units_are_those_of_the_dimensions() -> None:
    for row in fixed_axis.analogy_table():
        for quantity in (row.rotation, row.translation):
            above, _, below = quantity.unit.partition("/")
            total = np.sum([UNITS[unit] for unit in above.split()], axis=0)
            if below:
                total = total - UNITS[below]
            assert tuple(total) == quantity.dimension


EYE = np.eye(3)
REFUSED: list[tuple[Any, ...]] = [
    (
        lambda: fixed_axis.bearing_torques(np.diag([1.0, 1.0, 3.0]), 1.0),
        "tensor: no body has the principal moments (1, 1, 3)",
    ),
    (
        lambda: fixed_axis.bearing_torques(np.diag([1.0, -1.0, 1.0]), 1.0),
        "tensor: no body has the principal moments (-1, 1, 1)",
    ),
    (
        lambda: fixed_axis.bearing_torques(EYE + np.diag([0.5, 0.0], 1), 1.0),
        "tensor[0, 1] = 0.5, but its mirror entry is 0.0",
    ),
    (
        lambda: fixed_axis.bearing_torques(EYE[0], 1.0),
        "tensor: expected shape (..., 3, 3), got (3,)",
    ),
    (
        lambda: fixed_axis.bearing_torques(EYE, 1.0, axis=[0, 0, 0]),
        "axis = [0.0, 0.0, 0.0]: an axis needs a direction",
    ),
    (lambda: fixed_axis.bearing_torques(EYE, np.nan), "omega = nan: must be finite"),
    (
        lambda: fixed_axis.bearing_torques(EYE, [1.0, 2.0], [1.0, 2.0, 3.0]),
        "the shapes do not broadcast",
    ),
    (lambda: fixed_axis.bearing_forces(-2.0, [0, 0, 0], 1.0), "mass = -2.0: must not be negative"),
    (lambda: fixed_axis.balance_test(EYE, mass=0.0, com=[0, 0, 0]), "mass = 0.0: must be positive"),
    (
        lambda: fixed_axis.balance_test(EYE, mass=1.0, com=[0, 0, 0], rtol=-1e-9),
        "rtol = -1e-09: must not be negative",
    ),
    (
        lambda: fixed_axis.bearing_reactions(EYE, 1.0, [0, 0, 0], 1.0, at=(1, 1)),
        "at = [1.0, 1.0]: must be two places",
    ),
    (lambda: fixed_axis.two_plane_balance(EYE, 1.0, [0, 0, 0], at=(1, 2, 3)), "at"),
    (lambda: fixed_axis.two_plane_balance(EYE, -1.0, [0, 0, 0], at=(1, 2)), "mass = -1"),
]


test_refusals_name_the_argument_and_the_rule = refuses(REFUSED, literal=True)


# Two bearings and two planes


@pytest.mark.parametrize("axis", AXES.values(), ids=AXES)
def test_two_reactions_carry_the_rates_of_change_of_both_momenta(axis: list[float]) -> None:
    unit, at = np.array(axis) / np.linalg.norm(axis), (-0.7, 1.9)
    com = MASSES @ ARMS / MASSES.sum()
    forces = fixed_axis.bearing_reactions(
        INERTIA, MASSES.sum(), com, rate(TIME), GROWTH, at=at, axis=axis
    )
    in_space = forces @ turn(TIME, axis).T
    force, torque = rates_of_change(TIME, axis)
    assert np.allclose(in_space.sum(axis=0), force, rtol=0, atol=1e-10)
    moments = sum(np.cross(z * unit, f) for z, f in zip(at, in_space, strict=True))
    assert np.allclose(moments, torque - (torque @ unit) * unit, rtol=0, atol=1e-10)
    assert np.allclose(forces @ unit, 0.0, rtol=0, atol=1e-13)


@pytest.mark.parametrize("axis", AXES.values(), ids=AXES)
def test_masses_added_in_two_planes_free_the_bearings(axis: list[float]) -> None:
    unit, at, radius = np.array(axis) / np.linalg.norm(axis), (-0.4, 1.1), 0.3
    com = MASSES @ ARMS / MASSES.sum()
    added = fixed_axis.two_plane_balance(INERTIA, MASSES.sum(), com, at=at, axis=axis)
    sizes = np.linalg.norm(added, axis=-1)
    places = np.outer(at, unit) + radius * added / sizes[:, None]
    masses, arms = np.append(MASSES, sizes / radius), np.vstack([ARMS, places])
    whole, centre = tensor_of_points(masses, arms), masses @ arms / masses.sum()
    assert fixed_axis.balance_test(
        whole, mass=masses.sum(), com=centre, axis=axis, rtol=1e-14
    ).balanced
    left = fixed_axis.bearing_reactions(whole, masses.sum(), centre, 10.0, at=(0, 2), axis=axis)
    before = fixed_axis.bearing_reactions(INERTIA, MASSES.sum(), com, 10.0, at=(0, 2), axis=axis)
    assert np.abs(left).max() < 1e-13 * np.abs(before).max()
