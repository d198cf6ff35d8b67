"""Films show the surface of a body that the user gives."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import rigid
from films import BOX, TILTED, TOP, film_of, part, run_of


def test_a_mesh_is_shown_where_the_body_is() -> None:
    # An L of two boxes, whose principal axes are not those in which it is described.
    corners, faces = l_shape()
    solid = rigid.meshes.mesh_properties(corners, faces, mass=2.0)
    body, axes = rigid.Body.from_properties(solid)
    own = corners - solid.centre
    run = run_of(rigid.FreeBody(body), (0.1, 0.2, 3.0)).in_frame(axes)
    film = film_of(run, shape=(own, faces))
    assert film.view == "box"
    shown = part(film, "faces", carried=True)
    space = shown.placed(film.attitude[13], 13)
    # In space the corners are where the attitude of the axes of the mesh brings them.
    meant = run.rotation()[13].apply(own)[np.array(faces)]
    np.testing.assert_allclose(space, meant / np.linalg.norm(own, axis=1).max(), atol=1e-12)
    # The same in principal axes.
    plain = film_of(run.in_frame(None), shape=(own @ axes, faces))
    np.testing.assert_allclose(part(plain, "faces", carried=True).points, shown.points, atol=1e-12)
    # Their second moments are those of the body, up to the square of the scale.
    again = rigid.meshes.mesh_properties(*welded(shown.points), mass=2.0)
    scale = np.linalg.norm(own, axis=1).max()
    np.testing.assert_allclose(again.tensor * scale**2, np.diag(body.moments), atol=1e-12)
    top_film = film_of(run_of(TOP, (0.0, 0.0, 5.0), TILTED), shape=(own, faces))
    assert top_film.view == "top"
    assert part(top_film, "faces", carried=True).points.shape == (len(faces), 3, 3)


def l_shape() -> tuple[Any, list[list[int]]]:
    outline = np.array([[0, 0], [3, 0], [3, 1], [1, 1], [1, 2], [0, 2]], dtype=float)
    low, high = np.insert(outline, 2, 0.0, axis=1), np.insert(outline, 2, 0.5, axis=1)
    cap = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]]
    sides = [[k, (k + 1) % 6, 6 + (k + 1) % 6] for k in range(6)]
    sides += [[k, 6 + (k + 1) % 6, 6 + k] for k in range(6)]
    faces = [[a, c, b] for a, b, c in cap] + [[a + 6, b + 6, c + 6] for a, b, c in cap] + sides
    return np.concatenate([low, high]), faces


def welded(polygons: Any) -> tuple[Any, Any]:
    corners, index = np.unique(polygons.reshape(-1, 3).round(12), axis=0, return_inverse=True)
    return corners, index.reshape(-1, 3)


def test_faces_of_a_mesh_may_have_four_corners() -> None:
    square = [[1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0]]
    film = film_of(run_of(BOX), shape=(square, [[0, 1, 2, 3]]))
    np.testing.assert_array_equal(part(film, "faces", carried=True).points, [square])


@pytest.mark.parametrize(
    ("shape", "message"),
    [
        (([[[0, 0, 0]]], [[0, 0, 0]]), r"shape\[0\]: the corners need the shape \(v, 3\)"),
        (
            ([[0, 0, 1]], [[0.0, 0.0, 0.0]]),
            r"shape\[1\]: the faces need whole numbers of shape",
        ),
        (
            ([[0, 0, 1]], [[0, 0]]),
            r"\(f, n\) with n >= 3, not int64 of shape \(1, 2\)",
        ),
        (([[0, 0, 1]], [[0, 0, 1]]), r"shape\[1\]: no corner 1 among 1 corners"),
        (([[0, 0, 1]], [[0, 0, -1]]), r"shape\[1\]: no corner -1 among 1 corners"),
        (([[0, 0, 0]], [[0, 0, 0]]), r"shape\[0\]: all corners of the faces are at the origin"),
    ],
)
def test_a_surface_that_is_none_is_refused(shape: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        run_of(BOX).animate(shape=shape)
    with pytest.raises(ValueError, match="view = 'poinsot': does not show the shape; omit one"):
        run_of(BOX).animate(view="poinsot", shape=shape)


def test_what_is_no_pair_and_no_text_is_refused() -> None:
    for shape in (5, [[0, 0, 1], [0, 1, 0], [1, 0, 0]]):
        with pytest.raises(TypeError, match=r"shape = .*: must be a pair, \(vertices, faces\)"):
            run_of(BOX).animate(shape=shape)
    with pytest.raises(TypeError, match="caption = 5: must be a text"):
        run_of(BOX).animate(caption=5)
