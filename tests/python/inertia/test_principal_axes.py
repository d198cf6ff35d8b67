"""Principal axes and moments, and the kinds of bodies that the moments tell."""

from itertools import pairwise

import numpy as np
import pytest
from numpy import pi

import rigid
from physics import ROUNDOFF, Floats
from random_tensors import worst_principal_axes
from rigid import inertia, rotations
from turning_clouds import TENSORS

RNG = np.random.default_rng(21)

#: Rounding of a sum over some mass points, relative to its largest term.
ROUNDED = 64 * ROUNDOFF


# Principal axes


def test_principal_axes_rebuild_random_tensors() -> None:
    # tests/long/principal_axes.py takes as many as wished.
    assert worst_principal_axes(20_000, RNG) < 1e-14


def test_only_a_principal_moment_leaves_a_direction() -> None:
    """Ercan 2016, § 7.2, prints I where the eigenvalue I_1 must stand: erratum D-18."""
    tensor = TENSORS[0]
    first = inertia.principal_axes(tensor).moments[0]
    smallest = [np.linalg.svd(tensor - x * np.eye(3))[1][2] for x in (first, 1.1 * first)]
    assert smallest[0] < ROUNDED * np.trace(tensor)
    assert smallest[1] > 1e-3


def test_axes_of_equal_moments_are_laid_down() -> None:
    assert np.array_equal(inertia.principal_axes(2.0 * np.eye(3)).axes, np.eye(3))
    oblate = inertia.principal_axes(np.diag([1.0, 1.0, 1.5]))
    assert np.array_equal(oblate.axes, np.eye(3))
    prolate = inertia.principal_axes(np.diag([2.0, 2.0, 1.0]))
    assert np.array_equal(prolate.axes, np.eye(3)[:, [2, 0, 1]])
    # Rounding of the tensor, as another machine would round it, moves them by as little.
    for moments in ([1.0, 1.0, 1.5], [2.0, 2.0, 1.0], [1.0, 1.0, 1.0]):
        turn = rotations.exp_so3(RNG.normal(size=3))
        tensor = turn @ np.diag(moments) @ turn.T
        tensor = 0.5 * (tensor + tensor.T)
        axes = inertia.principal_axes(tensor).axes
        for _ in range(20):
            noise = RNG.uniform(-1.0, 1.0, (3, 3)) * ROUNDOFF
            again = inertia.principal_axes(tensor + noise + noise.T).axes
            assert np.abs(again - axes).max() < 64 * ROUNDOFF


def test_a_rod_has_a_moment_zero() -> None:
    """The lecture calls the tensor positive definite: not for its own rod, erratum G-11."""
    points = np.outer(np.linspace(-1.0, 1.0, 11), rotations.exp_so3([0.3, 0.2, 0.1])[2])
    found = inertia.principal_axes(inertia.inertia_tensor(np.ones(11), points))
    assert found.moments[0] <= ROUNDED * found.moments[2]
    assert found.moments[0] >= 0.0
    assert found.moments[1] == pytest.approx(found.moments[2], rel=ROUNDED)


def test_principal_axes_are_those_of_the_core() -> None:
    for tensor in TENSORS:
        body, axes = rigid.Body.from_tensor(tensor)
        found = inertia.principal_axes(tensor)
        assert found.moments == pytest.approx(body.moments, rel=ROUNDED)
        assert found.axes == pytest.approx(axes, abs=1e-12)


# Kinds of bodies


@pytest.mark.parametrize(
    ("moments", "kind", "axis", "flat"),
    [
        ([1.0, 2.0, 2.5], "asymmetric", 0, False),
        ([1.0, 2.0, 3.0], "asymmetric", 0, True),
        ([1.5, 1.0, 1.0], "oblate", 1, False),
        ([1.0, 2.0, 1.0], "oblate", 2, True),
        ([2.0, 0.5, 2.0], "prolate", 2, False),
        ([2.0, 2.0, 0.0], "rod", 3, True),
        ([3.0, 3.0, 3.0], "spherical", 0, False),
        ([0.0, 0.0, 0.0], "point", 0, True),
        ([1.0, 1.0, 2.1], "impossible", 0, False),
        ([-0.1, 1.0, 1.0], "impossible", 0, False),
        ([1.0, 0.0, 0.0], "impossible", 0, False),
    ],
)
def test_kinds_of_bodies(moments: list[float], kind: str, axis: int, flat: bool) -> None:
    found = inertia.classify_body(moments)
    assert (str(found.kind), int(found.axis), bool(found.flat)) == (kind, axis, flat)
    tiny = inertia.classify_body(1e-200 * np.array(moments))
    assert str(tiny.kind) == kind


def test_kinds_of_many_bodies() -> None:
    found = inertia.classify_body([[1.0, 1.0, 1.5], [1.0, 1.0 + 1e-9, 1.5]])
    assert found.kind.tolist() == ["oblate", "asymmetric"]
    loose = inertia.classify_body([1.0, 1.0 + 1e-9, 1.5], tolerance=1e-8)
    assert str(loose.kind) == "oblate"
    assert inertia.classify_body(np.empty((0, 3))).kind.shape == (0,)


def test_no_cloud_breaks_the_triangle_inequality() -> None:
    masses, points = RNG.uniform(0.0, 1.0, (20_000, 4)), RNG.normal(size=(20_000, 4, 3))
    moments = inertia.principal_axes(inertia.inertia_tensor(masses, points)).moments
    kinds = inertia.classify_body(moments)
    assert set(kinds.kind) == {"asymmetric"}
    assert not kinds.flat.any()
    points[..., 2] = 0.0
    lamina = inertia.classify_body(
        inertia.principal_axes(inertia.inertia_tensor(masses, points)).moments
    )
    assert lamina.flat.all()


# Symmetries of clouds of mass points, and what they say of the tensor of inertia


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


@pytest.mark.parametrize(
    ("along", "off", "size"), [(False, 0.95, 8), (False, 3.0, 1), (True, 0.95, 8), (True, 1.4, 1)]
)
def test_a_point_some_tolerances_off_its_image_breaks_the_symmetry(
    along: bool, off: float, size: int
) -> None:
    """Of a brick's corners one is moved, across or along its radius, by tolerances of 1e-8.

    The centre follows by an eighth, so that images miss by three quarters to the whole. Along the
    radius that of the opposite corner grows by an eighth: the two differ by three quarters.
    """
    points = solid("brick")
    way = points[5] if along else np.cross(points[5], [0.0, 0.0, 1.0])
    points[5] += off * 1e-8 * np.linalg.norm(points[5]) * way / np.linalg.norm(way)
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
