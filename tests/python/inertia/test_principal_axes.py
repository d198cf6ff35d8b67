"""Principal axes and moments, and the kinds of bodies that the moments tell."""

from __future__ import annotations

import numpy as np
import pytest

import rigid
from physics import ROUNDOFF
from random_tensors import worst_principal_axes
from rigid import inertia, rotations
from turning_clouds import TENSORS

RNG = np.random.default_rng(21)

#: Rounding of a sum over some mass points, relative to its largest term.
ROUNDED = 64 * ROUNDOFF


# Principal axes


def test_principal_axes_rebuild_random_tensors() -> None:
    assert worst_principal_axes(100_000, RNG) < 1e-14


def test_principal_moments_solve_the_cubic() -> None:
    """det(I - x 1) = 0: its coefficients are the trace, the sum of principal minors, and det."""
    for tensor in TENSORS:
        x1, x2, x3 = inertia.principal_axes(tensor).moments
        minors = 0.5 * (np.trace(tensor) ** 2 - np.trace(tensor @ tensor))
        assert x1 + x2 + x3 == pytest.approx(np.trace(tensor), rel=ROUNDED)
        assert x1 * x2 + x2 * x3 + x3 * x1 == pytest.approx(minors, rel=ROUNDED)
        assert x1 * x2 * x3 == pytest.approx(np.linalg.det(tensor), rel=ROUNDED)


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
