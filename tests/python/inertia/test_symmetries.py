"""Symmetries of clouds of mass points, and what they say of the tensor of inertia."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from numpy import pi

from physics import ROUNDOFF, Floats
from rigid import inertia, rotations

RNG = np.random.default_rng(21)

#: Rounding of a sum over some mass points, relative to its largest term.
ROUNDED = 64 * ROUNDOFF


# Symmetries


def polygon(order: int) -> Floats:
    """Two rings of so many points each, twisted against each other: only its axis is left."""
    turn = 2.0 * pi * np.arange(order) / order
    rings = [(1.0, turn, 0.3), (0.4, turn + 0.3, -0.2)]
    return np.concatenate(
        [np.stack([r * np.cos(a), r * np.sin(a), 0 * a + z], axis=-1) for r, a, z in rings]
    )


@pytest.mark.parametrize("order", [2, 3, 4, 5, 6, 7, 12])
def test_an_axis_of_order_three_or_more_makes_two_moments_equal(order: int) -> None:
    turn = rotations.exp_so3([0.4, -0.8, 1.3])
    points = polygon(order) @ turn.T + [1.0, 2.0, 3.0]
    found = inertia.symmetry_check(points)
    assert found.orders.tolist() == [order]
    assert np.abs(found.axes[0] @ turn[:, 2]) == pytest.approx(1.0, abs=1e-12)
    assert (found.size, found.inversion, len(found.planes)) == (order, False, 0)
    cloud = inertia.point_masses(np.ones(2 * order), points)
    assert found.centre == pytest.approx(cloud.centre, abs=ROUNDED)
    kind = inertia.classify_body(inertia.principal_axes(cloud.tensor).moments)
    assert (str(kind.kind) == "asymmetric") == (order == 2)
    principal(cloud.tensor, found.axes)


def principal(tensor: Floats, directions: Floats) -> None:
    """Each direction is a principal axis."""
    assert np.cross(directions, directions @ tensor) == pytest.approx(
        np.zeros_like(directions), abs=1e-9 * np.trace(tensor)
    )


def test_a_mirror_plane_holds_the_centre_and_two_principal_axes() -> None:
    half = RNG.normal(size=(5, 3))
    turn = rotations.exp_so3([0.4, -0.8, 1.3])
    points = np.concatenate([half, half * [1.0, 1.0, -1.0]]) @ turn.T + 3.0
    masses = np.tile(RNG.uniform(0.5, 2.0, 5), 2)
    found = inertia.symmetry_check(points, masses)
    assert (found.size, len(found.axes), len(found.planes)) == (2, 0, 1)
    assert np.abs(found.planes[0] @ turn[:, 2]) == pytest.approx(1.0, abs=1e-12)
    assert found.planes[0] @ (found.centre - 3.0) == pytest.approx(0.0, abs=1e-12)
    principal(inertia.point_masses(masses, points).tensor, found.planes)
    masses[0] *= 1.01  # the same places with other masses have no such plane
    assert inertia.symmetry_check(points, masses).size == 1


@pytest.mark.parametrize(("off", "size"), [(0.5, 8), (20.0, 1)])
def test_a_point_20_tolerances_off_its_image_breaks_the_symmetry(off: float, size: int) -> None:
    """Of a brick's corners one is moved, at right angles to its radius, by tolerances of 1e-9."""
    points = solid("brick")
    across = np.cross(points[5], [0.0, 0.0, 1.0])
    points[5] += off * 1e-9 * np.linalg.norm(points[5]) * across / np.linalg.norm(across)
    assert inertia.symmetry_check(points).size == size


#: Order of the group, axes by order, planes, inversion (Schoenflies: D2h, Oh, Td, Ih, D3h).
GROUPS = {
    "brick": (8, {2: 3}, 3, True),
    "cube": (48, {4: 3, 3: 4, 2: 6}, 9, True),
    "tetrahedron": (24, {3: 4, 2: 3}, 6, False),
    "icosahedron": (120, {5: 6, 3: 10, 2: 15}, 15, True),
    "triangle": (12, {3: 1, 2: 3}, 4, False),
}


def solid(name: str) -> Floats:
    signs: Floats = np.array(np.meshgrid(*[[-1.0, 1.0]] * 3)).reshape(3, -1).T
    if name == "brick":
        return np.asarray(signs * [1.0, 2.0, 3.0])
    if name == "cube":
        return signs
    if name == "tetrahedron":
        return np.asarray(signs[signs.prod(axis=1) > 0.0])
    if name == "triangle":
        return np.asarray(polygon(3)[:3])
    golden = 0.5 * (1.0 + np.sqrt(5.0))
    flat = np.array([[0.0, s, t * golden] for s in (-1.0, 1.0) for t in (-1.0, 1.0)])
    return np.concatenate([np.roll(flat, k, axis=1) for k in range(3)])


@pytest.mark.parametrize("name", GROUPS)
def test_groups_of_known_solids(name: str) -> None:
    points = solid(name) @ rotations.exp_so3([0.4, -0.8, 1.3]).T + 5.0
    found = inertia.symmetry_check(points)
    size, axes, planes, inversion = GROUPS[name]
    assert (found.size, len(found.planes), found.inversion) == (size, planes, inversion)
    orders, counts = np.unique(found.orders, return_counts=True)
    assert dict(zip(orders.tolist(), counts.tolist(), strict=True)) == axes
    assert all(first >= second for first, second in pairwise(found.orders))


def test_clouds_on_a_line() -> None:
    line = rotations.exp_so3([0.4, -0.8, 1.3])[2]
    even = inertia.symmetry_check(np.outer([-1.0, 0.0, 1.0], line) + 1.0)
    assert (even.orders.tolist(), len(even.planes), even.inversion, even.size) == ([0], 1, True, 0)
    uneven = inertia.symmetry_check(np.outer([-1.0, 0.0, 1.5], line), [1.0, 2.0, 1.0])
    assert (uneven.orders.tolist(), len(uneven.planes), uneven.inversion) == ([0], 0, False)
    assert np.abs(uneven.axes[0] @ line) == pytest.approx(1.0, abs=1e-12)
