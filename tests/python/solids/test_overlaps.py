"""Meshes of several surfaces: what two of them contain would count twice."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from numpy.typing import NDArray

from rigid import meshes

Floats = NDArray[np.float64]
Mesh = tuple[Floats, NDArray[np.int64]]


def box(size: tuple[float, float, float], at: tuple[float, float, float] = (0, 0, 0)) -> Mesh:
    solid = trimesh.creation.box(size)
    return np.array(solid.vertices) + at, np.array(solid.faces)


def ball(radius: float, at: tuple[float, float, float] = (0, 0, 0)) -> Mesh:
    solid = trimesh.creation.icosphere(3, radius)
    return np.array(solid.vertices) + at, np.array(solid.faces)


def hollow(mesh: Mesh) -> Mesh:
    return mesh[0], mesh[1][:, ::-1]


def together(*parts: Mesh) -> Mesh:
    begins = np.cumsum([0, *(len(corners) for corners, _ in parts)])
    faces = [faces + begin for (_, faces), begin in zip(parts, begins, strict=False)]
    return np.concatenate([corners for corners, _ in parts]), np.concatenate(faces)


CUBE = box((1, 1, 1))

OVERLAPS = {
    "side by side, on common planes": together(CUBE, box((1, 1, 1), (0.64, 0, 0))),
    "in a corner": together(CUBE, box((1, 1, 1), (0.7, 0.8, 0.6))),
    "crossed bars, no corner in the other": together(box((10, 1, 1)), box((1, 10, 1))),
    "one in the other": together(CUBE, box((0.3, 0.3, 0.3))),
    "twice the same": together(CUBE, CUBE),
    "balls": together(ball(1.0), ball(1.0, (1.8, 0.0, 0.0))),
    "a cavity outside the body": together(ball(1.0), hollow(box((0.2, 0.2, 0.2), (0.8, 0.8, 0.8)))),
    "a core as large as its cavity and more": together(
        CUBE, hollow(box((0.4, 0.4, 0.4))), box((0.41, 0.41, 0.41))
    ),
}

LEGAL = {
    "apart": (together(ball(1.0), ball(1.0, (1.3, 1.3, 1.3))), 2),
    "touching": (together(CUBE, box((1, 1, 1), (1.0, 0.1, 0.2))), 2),
    "pressed together by rounding": (together(CUBE, box((1, 1, 1), (1 - 1e-6, 0.1, 0.2))), 2),
    "a cavity": (together(CUBE, hollow(box((0.3, 0.3, 0.3)))), 1 - 0.3**3),
    "a core in a cavity": (
        together(CUBE, hollow(box((0.3, 0.3, 0.3))), box((0.3, 0.1, 0.1))),
        1 - 0.3**3 + 0.3 * 0.1**2,
    ),
}


@pytest.mark.parametrize("name", OVERLAPS)
def test_overlapping_surfaces_are_refused(name: str) -> None:
    with pytest.raises(ValueError, match=r"faces\[\d+\] = .*overlaps another, and what both"):
        meshes.mesh_properties(*OVERLAPS[name])


@pytest.mark.parametrize("name", LEGAL)
def test_parts_and_cavities_are_legal(name: str) -> None:
    mesh, cubes = LEGAL[name]
    unit = float(meshes.mesh_properties(*(ball(1.0) if name == "apart" else CUBE)).mass)
    assert float(meshes.mesh_properties(*mesh).mass) == pytest.approx(cubes * unit, rel=1e-14)


def test_the_overlap_of_one_of_many_bodies() -> None:
    corners, faces = together(CUBE, box((1, 1, 1), (2, 0, 0)))
    many = np.stack([corners, corners, corners])
    many[1, 8:, 0] -= 1.5
    assert meshes.mesh_properties(many[::2], faces).mass.tolist() == [2.0, 2.0]
    with pytest.raises(ValueError, match="overlaps another"):
        meshes.mesh_properties(many, faces)
