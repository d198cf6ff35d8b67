"""Statics: forces in balance, the simple machines, the central axis."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.optimize import minimize

import rigid
from physics import ROUNDOFF, Floats
from refusals import refuses
from rigid import statics

RNG = np.random.default_rng(8)
FORCES = RNG.normal(size=(4, 3))
POINTS = RNG.normal(size=(4, 3))
BALANCED = FORCES - FORCES.mean(axis=0)


def torque_by_hand(forces: Floats, points: Floats, about: Floats) -> Floats:
    """Component by component."""
    total = np.zeros(3)
    for f, r in zip(forces, points - about, strict=True):
        total += [r[1] * f[2] - r[2] * f[1], r[2] * f[0] - r[0] * f[2], r[0] * f[1] - r[1] * f[0]]
    return total


def test_forces_without_a_sum_have_one_torque_about_every_point() -> None:
    centres = RNG.normal(size=(100, 3)) * 5.0
    found = statics.equilibrium(BALANCED, POINTS, about=centres)
    truth = torque_by_hand(BALANCED, POINTS, np.zeros(3))
    assert found.torque.shape == (100, 3)
    np.testing.assert_allclose(found.torque, np.tile(truth, (100, 1)), atol=256 * ROUNDOFF * 10)
    # With a sum they have not: the reference point is not arbitrary.
    other = statics.equilibrium(FORCES, POINTS, about=centres).torque
    assert np.ptp(other, axis=0).min() > 1.0
    origin = statics.equilibrium(FORCES, POINTS).torque
    moved = origin - np.cross(centres, FORCES.sum(axis=0))
    np.testing.assert_allclose(other, moved, atol=256 * ROUNDOFF * 10)


def test_each_force_has_its_own_arm() -> None:
    """Printed with one arm for all, the torque is another number."""
    truth = torque_by_hand(FORCES, POINTS, np.zeros(3))
    found = statics.equilibrium(FORCES, POINTS).torque
    np.testing.assert_allclose(found, truth, atol=32 * ROUNDOFF)
    printed = np.cross(POINTS[0], FORCES).sum(axis=0)
    assert np.abs(printed - truth).max() > 0.5


def test_rest_needs_both_sums_to_vanish() -> None:
    pair = [[0, 0, 5], [0, 0, -5]]
    apart, along = [[1, 0, 0], [-1, 0, 0]], [[0, 0, 7], [0, 0, -2]]
    assert not statics.equilibrium(pair, apart).balanced
    assert statics.equilibrium(pair, along).balanced
    assert not statics.equilibrium([[0, 0, 5], [0, 0, -4]], along).balanced
    # Not to the last bit: 0.1 + 0.2 - 0.3 is not zero.
    assert statics.equilibrium([[0.1, 0, 0], [0.2, 0, 0], [-0.3, 0, 0]], np.ones((3, 3))).balanced
    assert statics.equilibrium(np.zeros((0, 3)), np.zeros((0, 3))).balanced
    assert statics.equilibrium(np.zeros((0, 4, 3)), np.zeros((4, 3))).balanced.shape == (0,)


def test_constant_momenta_are_not_yet_rest() -> None:
    # D-44: forces in equilibrium keep P and L constant; a body at rest has neither.
    pair, along = [[0, 0, 5], [0, 0, -5]], [[0, 0, 7], [0, 0, -2]]
    assert statics.equilibrium(pair, along).balanced
    scene = rigid.FreeBody(rigid.Body((1.0, 1.5, 2.0)))
    moving: Any = rigid.simulate(scene, [0.3, 1.0, 0.2], t=[0.0, 5.0])
    momentum = moving.rotation().apply(moving.momentum())
    assert np.abs(momentum[1] - momentum[0]).max() < 1e-13
    assert np.abs(moving.attitude[1] - moving.attitude[0]).max() > 0.5
    resting: Any = rigid.simulate(scene, [0.0, 0.0, 0.0], t=[0.0, 5.0])
    assert (resting.momentum() == 0.0).all()
    assert (resting.attitude[1] == resting.attitude[0]).all()


# The six simple machines, without friction. The law is that of virtual work: the work of the effort
# in a small displacement is that of the load. Each takes the effort, and gives forces and points.

LOAD = 30.0

Machine = Callable[[float], tuple[Any, Any]]


def lever(effort: float) -> tuple[Any, Any]:
    support = LOAD + effort
    return [[0, 0, -LOAD], [0, 0, -effort], [0, 0, support]], [[-0.2, 0, 0], [0.6, 0, 0], [0, 0, 0]]


def wheel_and_axle(effort: float) -> tuple[Any, Any]:
    """The strands leave the axle downwards and the wheel at 40 degrees; the bearing holds."""
    angle = np.radians(40.0)
    strand = effort * np.array([np.cos(angle), 0.0, np.sin(angle)])
    rim = 0.5 * np.array([-np.sin(angle), 0.0, np.cos(angle)])
    load = np.array([0.0, 0.0, -LOAD])
    return [load, strand, -load - strand], [[-0.1, 0.3, 0], [rim[0], 0.3, rim[2]], [0, 0.3, 0]]


def pulley(effort: float) -> tuple[Any, Any]:
    """A movable one: it hangs in two strands of the same rope."""
    return [[0, 0, effort], [0, 0, effort], [0, 0, -LOAD]], [[-0.1, 0, 0], [0.1, 0, 0], [0, 0, -1]]


SLOPE = 0.3


def inclined_plane(effort: float) -> tuple[Any, Any]:
    up, out = [np.cos(SLOPE), 0.0, np.sin(SLOPE)], [-np.sin(SLOPE), 0.0, np.cos(SLOPE)]
    push = LOAD * np.cos(SLOPE)
    return [[0, 0, -LOAD], np.multiply(effort, up), np.multiply(push, out)], [[2, 0, 0]] * 3


def wedge(effort: float) -> tuple[Any, Any]:
    """Each face, at the angle SLOPE to the effort, pushes with LOAD."""
    side, up = LOAD * np.cos(SLOPE), LOAD * np.sin(SLOPE)
    return (
        [[0, 0, -effort], [side, 0, up], [-side, 0, up]],
        [[0, 0, 1], [-0.1, 0, 0], [0.1, 0, 0]],
    )


RISE, RADIUS, ARM = 0.004, 0.01, 0.25


def screw(effort: float) -> tuple[Any, Any]:
    """Twelve threads side by side push along their normals; two efforts turn it upwards."""
    angle = np.linspace(0.0, 2 * np.pi, 12, endpoint=False)
    slope = np.arctan(RISE / (2 * np.pi * RADIUS))
    around = np.stack([-np.sin(angle), np.cos(angle), 0 * angle], axis=1)
    normal = np.cos(slope) * np.array([0.0, 0.0, 1.0]) - np.sin(slope) * around
    push = LOAD / 12 / np.cos(slope)
    thread = RADIUS * np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    turning = [[0.0, 0, -LOAD], [0, effort, 0], [0, -effort, 0]]
    return (
        np.concatenate([turning, push * normal]),
        np.concatenate([[[0.0, 0, 0], [ARM, 0, 0], [-ARM, 0, 0]], thread]),
    )


#: Displacements of the load and of the effort for one and the same motion of the machine.
MACHINES: list[tuple[Machine, float, float]] = [
    (lever, 0.2, 0.6),
    (wheel_and_axle, 0.1, 0.5),
    (pulley, 1.0, 2.0),
    (inclined_plane, np.sin(SLOPE), 1.0),
    (wedge, 2.0 * np.sin(SLOPE), 1.0),
    (screw, RISE, 2 * np.pi * 2 * ARM),
]


@pytest.mark.parametrize(
    ("machine", "rise", "way"), MACHINES, ids=[machine.__name__ for machine, _, _ in MACHINES]
)
def test_simple_machines_balance_by_the_law_of_virtual_work(
    machine: Machine, rise: float, way: float
) -> None:
    effort = LOAD * rise / way
    assert statics.equilibrium(*machine(effort)).balanced
    for wrong in (0.999 * effort, 1.001 * effort, 0.0):
        assert not statics.equilibrium(*machine(wrong)).balanced


# Equilibrant and central axis


@pytest.mark.parametrize("about", [[0.0, 0.0, 0.0], [2.0, -1.0, 0.5]])
def test_the_equilibrant_makes_both_sums_vanish(about: list[float]) -> None:
    add = statics.equilibrant(FORCES, POINTS, about=about)
    assert add.needs_force
    assert add.needs_couple
    # The couple as two opposite forces, one metre apart across it.
    size = np.linalg.norm(add.couple)
    arm = np.cross(add.couple, [0.3, 0.4, 0.5])
    arm /= np.linalg.norm(arm)
    pair = np.cross(add.couple, arm)
    forces = np.concatenate([FORCES, [add.force, pair, -pair]])
    points = np.concatenate([POINTS, [about, arm, 0.0 * arm]])
    assert np.linalg.norm(np.cross(arm, pair)) == pytest.approx(float(size), rel=1e-14)
    whole = statics.equilibrium(forces, points, rtol=64 * ROUNDOFF)
    assert whole.balanced


@pytest.mark.parametrize("unit", [2.0**-1000, 1.0, 2.0**900])
def test_units_do_not_decide_what_balances(unit: float) -> None:
    """Squares of such forces and arms leave the range of doubles."""
    up, apart = [0.0, 0.0, unit], [[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]]
    assert not statics.equilibrium([up], [[0.0, 0.0, 0.0]]).balanced
    assert statics.equilibrium([up, [0.0, 0.0, -unit]], [[0.0, 0.0, 0.0]] * 2).balanced
    assert not statics.equilibrium([up, [0.0, 0.0, -unit]], apart).balanced
    long = (np.array(apart) * 2.0**-600).tolist()
    assert not statics.equilibrium([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]], long).balanced
    pair = statics.wrench([up, up], apart)
    assert pair.pitch == 0.0


def test_which_of_the_two_is_needed() -> None:
    through = statics.equilibrant([[0, 0, 2], [0, 1, 0]], [[1, 1, 4], [1, 3, 1]], about=[1, 1, 1])
    assert (bool(through.needs_force), bool(through.needs_couple)) == (True, False)
    assert through.force.tolist() == [0.0, -1.0, -2.0]
    couple = statics.equilibrant([[0, 0, 5], [0, 0, -5]], [[1, 0, 0], [-1, 0, 0]], about=[9, 9, 9])
    assert (bool(couple.needs_force), bool(couple.needs_couple)) == (False, True)
    assert couple.couple.tolist() == [0.0, 10.0, 0.0]
    nothing = statics.equilibrant([[0, 0, 5], [0, 0, -5]], [[1, 0, 0], [1, 0, 3]])
    assert (bool(nothing.needs_force), bool(nothing.needs_couple)) == (False, False)


def test_on_the_central_axis_the_couple_is_along_the_force_and_smallest() -> None:
    about = np.array([0.3, -0.7, 1.1])
    found = statics.wrench(FORCES, POINTS, about=about)
    assert found.has_axis
    np.testing.assert_allclose(found.force, FORCES.sum(axis=0), atol=4 * ROUNDOFF)
    np.testing.assert_allclose(np.cross(found.couple, found.force), 0.0, atol=64 * ROUNDOFF)
    for along in (-3.0, 0.0, 10.0):
        here = statics.equilibrium(FORCES, POINTS, about=found.point + along * found.force)
        np.testing.assert_allclose(here.torque, found.couple, atol=512 * ROUNDOFF)
    np.testing.assert_allclose(found.pitch * found.force, found.couple, atol=64 * ROUNDOFF)
    # Nearest to the reference point, and nowhere is the torque smaller.
    assert (found.point - about) @ found.force == pytest.approx(0.0, abs=64 * ROUNDOFF)
    least = minimize(
        lambda at: float((statics.equilibrium(FORCES, POINTS, about=at).torque ** 2).sum()),
        about,
        options={"gtol": 1e-12},
    )
    assert np.sqrt(least.fun) == pytest.approx(float(np.linalg.norm(found.couple)), rel=1e-10)
    # The same axis from everywhere.
    other = statics.wrench(FORCES, POINTS, about=[5.0, 5.0, 5.0])
    np.testing.assert_allclose(
        np.cross(other.point - found.point, found.force), 0.0, atol=512 * ROUNDOFF
    )
    assert other.pitch == pytest.approx(float(found.pitch), rel=1e-13)


def test_parallel_forces_have_a_resultant_and_a_couple_has_no_axis() -> None:
    # Weights at 1 and 4: 1 and 2 N, their resultant at 3; its couple is nothing.
    weights = statics.wrench([[0, 0, -1], [0, 0, -2]], [[1, 0, 0], [4, 0, 0]])
    np.testing.assert_allclose(weights.point, [3.0, 0.0, 0.0], atol=4 * ROUNDOFF * 3)
    assert weights.pitch == 0.0
    assert np.abs(weights.couple).max() == 0.0
    pair = statics.wrench([[0, 0, 5], [0, 0, -5]], [[1, 0, 0], [-1, 0, 0]], about=[1.0, 2.0, 3.0])
    assert not pair.has_axis
    assert pair.pitch == np.inf
    assert pair.couple.tolist() == pair.torque.tolist() == [0.0, -10.0, 0.0]
    assert pair.point.tolist() == [1.0, 2.0, 3.0]
    nothing = statics.wrench(np.zeros((2, 3)), np.ones((2, 3)))
    assert not nothing.has_axis
    assert nothing.pitch == 0.0
    assert nothing.couple.tolist() == [0.0, 0.0, 0.0]


def test_many_systems_at_once() -> None:
    systems = np.stack([FORCES, BALANCED, 0.0 * FORCES])
    found = statics.wrench(systems, POINTS)
    assert found.has_axis.tolist() == [True, False, False]
    assert found.pitch.tolist()[1:] == [np.inf, 0.0]
    assert not np.isnan(found.point).any()
    assert found.pitch[0] == statics.wrench(FORCES, POINTS).pitch
    assert statics.wrench(np.zeros((0, 4, 3)), POINTS).point.shape == (0, 3)


REFUSED: list[tuple[Any, ...]] = [
    (
        lambda: statics.equilibrium(FORCES, POINTS[:3]),
        "forces (4, 3), points (3, 3): each force needs its point",
    ),
    (
        lambda: statics.equilibrium(FORCES[0], POINTS[0]),
        "forces: expected shape (..., N, 3), got (3,)",
    ),
    (lambda: statics.equilibrant(FORCES * np.nan, POINTS), "forces[0, 0] = nan: must be finite"),
    (
        lambda: statics.wrench(FORCES, POINTS, about=np.inf * np.ones(3)),
        "about[0] = inf: must be finite",
    ),
    (
        lambda: statics.wrench(np.ones((2, 4, 3)), np.ones((5, 4, 3))),
        "forces (2, 4, 3), points (5, 4, 3), about (1, 3): the shapes do not broadcast",
    ),
    (lambda: statics.equilibrium(FORCES, POINTS, rtol=-1.0), "rtol = -1.0: must not be negative"),
]


test_refusals_name_the_argument_and_the_rule = refuses(REFUSED, literal=True)
