"""Closed meshes, and their mass properties in rational numbers."""

from fractions import Fraction
from itertools import product
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from physics import Floats

Faces: TypeAlias = NDArray[np.int64]
Mesh: TypeAlias = tuple[Floats, Faces]

#: The faces of a box.
SQUARES = (
    (0, 1, 3, 2),
    (4, 6, 7, 5),
    (0, 4, 5, 1),
    (2, 3, 7, 6),
    (0, 2, 6, 4),
    (1, 5, 7, 3),
)

_FACES_OF_AN_OCTAHEDRON = ((0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4))


def box(*sides: float) -> Mesh:
    """A box about the origin."""
    corners = 0.5 * np.array(list(product((-1.0, 1.0), repeat=3))) * sides
    faces = [half for a, b, c, d in SQUARES for half in ((a, b, c), (a, c, d))]
    return corners, np.array(faces)


def ball(halvings: int) -> Mesh:
    """An octahedron whose triangles are divided by four, corners on the unit sphere."""
    corners = [np.eye(3)[k] * sign for k in range(3) for sign in (1.0, -1.0)]
    faces = [*_FACES_OF_AN_OCTAHEDRON, *((b, a, 5) for a, b, _ in _FACES_OF_AN_OCTAHEDRON)]
    for _ in range(halvings):
        known: dict[frozenset[int], int] = {}
        divided = []
        for face in faces:
            middles = []
            for a, b in zip(face, (*face[1:], face[0]), strict=True):
                if frozenset((a, b)) not in known:
                    known[frozenset((a, b))] = len(corners)
                    corners.append(
                        (corners[a] + corners[b]) / np.linalg.norm(corners[a] + corners[b])
                    )
                middles.append(known[frozenset((a, b))])
            (a, b, c), (ab, bc, ca) = face, middles
            divided += [(a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca)]
        faces = divided
    return np.array(corners), np.array(faces)


def together(*meshes: Mesh) -> Mesh:
    """Several surfaces in one mesh."""
    corners, faces, before = [], [], 0
    for own_corners, own_faces in meshes:
        corners.append(own_corners)
        faces.append(own_faces + before)
        before += len(own_corners)
    return np.concatenate(corners), np.concatenate(faces)


def exact_properties(
    corners: Floats, faces: Faces
) -> tuple[Fraction, list[Fraction], list[list[Fraction]]]:
    """Volume, centre of mass and tensor about it for density one, of the doubles as they are.

    The solid is a sum of signed tetrahedra with the origin; a simplex with the corners ``p_k`` has
    ``V / 20 (sum p p + s s)`` as the integral of ``x x``, with ``s`` the sum of its corners.
    """
    points = [[Fraction(float(x)) for x in corner] for corner in corners]
    volume, first = Fraction(0), [Fraction(0)] * 3
    second = [[Fraction(0)] * 3 for _ in range(3)]
    for face in faces:
        a, b, c = (points[k] for k in face)
        part = sum(
            a[k] * (b[(k + 1) % 3] * c[(k + 2) % 3] - b[(k + 2) % 3] * c[(k + 1) % 3])
            for k in range(3)
        ) / Fraction(6)
        volume += part
        s = [sum(x, Fraction(0)) for x in zip(a, b, c, strict=True)]
        for i in range(3):
            first[i] += part * s[i] / 4
            for k in range(3):
                second[i][k] += part * (sum(p[i] * p[k] for p in (a, b, c)) + s[i] * s[k]) / 20
    centre = [x / volume for x in first]
    spread = [[second[i][k] - volume * centre[i] * centre[k] for k in range(3)] for i in range(3)]
    trace = sum(spread[k][k] for k in range(3))
    tensor = [[(trace if i == k else 0) - spread[i][k] for k in range(3)] for i in range(3)]
    return volume, centre, tensor


def off(found: Floats, true: list[list[Fraction]]) -> float:
    """Largest error of the entries, relative to the largest of them."""
    size = max(abs(x) for row in true for x in row)
    errors = (
        abs(Fraction(float(x)) - y)
        for rows in zip(found, true, strict=True)
        for x, y in zip(*rows, strict=True)
    )
    return float(max(errors) / size)
