"""Meshes that are hard on their sums, against rational numbers."""

from __future__ import annotations

import numpy as np
import pytest

import rigid
from exact_meshes import Mesh, ball, box, exact_properties, off, together
from rigid import meshes, rotations

EPSILON = float(np.finfo(np.float64).eps)

TURN = rotations.exp_so3([0.3, 0.2, 0.5])


def assert_exact(mesh: Mesh, slenderness: float) -> None:
    """Corners that are shifted to the centre of mass round by a share of the length.

    Relative to the width this is the slenderness larger; three coordinates of twelve or more
    triangles add up to 16 roundings at most, as they have either sign.
    """
    found = meshes.mesh_properties(*mesh)
    volume, centre, tensor = exact_properties(*mesh)
    allowed = 16.0 * EPSILON * slenderness
    assert off(found.mass.reshape(1, 1), [[volume]]) < allowed
    assert off(found.tensor, tensor) < allowed
    length = np.ptp(mesh[0], axis=0).max()
    assert max(abs(float(x) - y) for x, y in zip(found.centre, map(float, centre), strict=True)) < (
        allowed * length
    )


@pytest.mark.parametrize("slenderness", [1.0, 1e2, 1e4, 1e6, 1e8, 1e10])
def test_needles_lose_no_more_than_their_slenderness(slenderness: float) -> None:
    """Products of three far corners lost its square: of a needle of 1e9 the volume was 3 % off."""
    corners, faces = box(1.0, 1.3, slenderness)
    assert_exact((corners @ TURN.T, faces), slenderness)


@pytest.mark.parametrize("slenderness", [1e3, 1e6, 1e9])
def test_plates_lose_no_more_than_their_slenderness(slenderness: float) -> None:
    corners, faces = box(slenderness, 1.3 * slenderness, 1.0)
    assert_exact((corners @ TURN.T, faces), slenderness)


@pytest.mark.parametrize("apart", [10.0, 1e3, 1e5])
def test_parts_far_from_each_other_keep_their_digits(apart: float) -> None:
    corners, faces = ball(2)
    other = corners + apart * np.array([0.48, 0.6, 0.64])
    assert_exact(together((corners, faces), (other, faces)), apart)


def test_cavities_are_taken_away() -> None:
    corners, faces = ball(1)
    inside = 0.4 * corners + np.array([0.1, -0.2, 0.05])
    assert_exact(together(box(3.0, 2.0, 2.5), (inside, faces[:, ::-1])), 1.0)


@pytest.mark.filterwarnings("error")
def test_a_mesh_whose_mass_properties_overflow_is_refused() -> None:
    corners, faces = box(1e100, 1e100, 1e100)
    with pytest.raises(ValueError, match=r"vertices = .*a result would leave the range of doubles"):
        rigid.Body.from_mesh(corners, faces)
    assert np.isfinite(rigid.Body.from_mesh(corners, faces, mass=1.0)[0].moments).all()
