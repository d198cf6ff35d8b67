"""Moving pictures draw light, depth, shadows and labels."""

import tracemalloc

import numpy as np
from scipy.spatial.transform import Rotation

from films import BOX, TOP, film_of, part, run_of
from rigid.animation.film import Part
from rigid.animation.raster import Buffer, Camera, _from_segment, corner_normals, label_places
from rigid.drawing.shapes import ellipsoid_faces


def test_near_surfaces_hide_far_ones() -> None:
    film = film_of(run_of(BOX, (0.0, 0.0, 1.0)))
    camera = Camera(film, 100)
    right, upward, eye = film.reach * camera.axes
    square = [-right - upward, right - upward, right + upward, upward - right]
    corners = film.centre + 0.5 * np.array(square)
    red, blue = np.array([[0.9, 0.0, 0.0]]), np.array([[0.0, 0.0, 0.9]])
    for order in (1, -1):
        buffer = Buffer(camera)
        for shift, ink in [(0.3, red), (-0.3, blue)][::order]:
            buffer.faces((corners + shift * eye)[np.newaxis], ink)
        middle = buffer.colour[50, 50]
        assert middle[0] > 0.4
        assert middle[2] == 0.0


def test_a_ball_of_polygons_is_lit_as_a_ball() -> None:
    # The picture of a ball by corners with averaged normals, and the light on the true ball.
    film = film_of(run_of(BOX, (0.0, 0.0, 1.0)))
    radius = 0.6 * film.reach
    polygons = ellipsoid_faces([radius] * 3)
    ball = Part(kind="faces", points=polygons, colours=("#ffffff",))
    camera = Camera(film, 240)
    worst = {}
    for name, normals in [("smooth", corner_normals(ball)), ("flat", None)]:
        buffer = Buffer(camera)
        buffer.faces(polygons, np.ones((len(polygons), 3)), normals=normals)
        light = buffer.colour[..., 0]
        # Rays through the dots, and where they meet the ball round the origin.
        column, row = np.meshgrid(np.arange(240) + 0.5, np.arange(240) + 0.5)
        ray = np.stack(
            [(column - 120) / camera.scale, (120 - row) / camera.scale, -np.ones_like(row)], axis=-1
        )
        ray = ray @ camera.axes / np.linalg.norm(ray, axis=-1, keepdims=True)
        along = ray @ camera.at
        under = along**2 - (camera.at @ camera.at - radius**2)
        normal = (camera.at + (-along - np.sqrt(np.maximum(under, 0.0)))[..., None] * ray) / radius
        meant = 0.52 + 0.12 * normal @ camera.up + 0.48 * np.maximum(normal @ camera.lamp, 0.0)
        inside = under > 0.1 * under.max()  # polygons end before the edge of the ball
        worst[name] = np.abs(light - meant)[inside].max()
    # Faces are h = 12.9 degrees wide. Between corners linear light errs by slope h / 4 where the
    # lamp sets (slope 0.48), and by 0.6 h² / 8 elsewhere. Faces lie by h² / 8 inside the ball,
    # which moves the place that is seen by up to three times as much near the edge.
    h = np.radians(12.9)
    assert worst["smooth"] < 0.48 * h / 4 + 0.6 * h**2 / 8 + 0.6 * 3 * h**2 / 8
    assert worst["flat"] > 0.05


def test_boxes_keep_their_edges() -> None:
    box = part(film_of(run_of(BOX)), "faces", carried=True)
    normals = corner_normals(box)
    for axis in range(3):
        for face in (2 * axis, 2 * axis + 1):
            np.testing.assert_allclose(np.abs(normals[face]), np.eye(3)[[axis] * 4], atol=1e-15)


def test_a_tip_of_thousands_of_faces_is_lit_in_memory_that_grows_with_them() -> None:
    turn = np.linspace(0.0, 2.0 * np.pi, 3001)[:, np.newaxis]
    rim = np.cos(turn) * [1.0, 0.0, 0.0] + np.sin(turn) * [0.0, 1.0, 0.0]
    tip = np.tile([0.0, 0.0, 0.3], (3000, 1))
    fan = Part(kind="faces", points=np.stack([tip, rim[:-1], rim[1:]], axis=1), colours=("#fff",))
    tracemalloc.start()
    normals = corner_normals(fan)
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert most < 3000 * 2000  # a number for each pair of faces would be 72 MB
    # Faces of a flat cone are less than 45 degrees apart: at the tip their mean is the axis.
    np.testing.assert_allclose(normals[:, 0], [[0.0, 0.0, 1.0]] * 3000, atol=1e-2)


def test_the_shadow_in_a_picture_lies_where_light_from_above_brings_it() -> None:
    leaning = [np.cos(0.3), np.sin(0.3), 0.0, 0.0]
    film = film_of(run_of(TOP, (0.0, 0.0, 9.0), leaning))
    assert film.grounded
    camera = Camera(film, 200)
    corners = part(film, "faces", carried=True).placed(film.attitude[0], 0)
    lit, bare = Buffer(camera), Buffer(camera)
    lit.ground(corners)
    bare.ground(np.zeros((0, 4, 3)))
    shadow = 1.0 - lit.colour[..., 0] / bare.colour[..., 0]
    assert 0.3 < shadow.max() < 0.4001
    row, column = (shadow @ np.ones(200)) @ np.arange(200), np.ones(200) @ shadow @ np.arange(200)
    seen = np.array([column, row]) / shadow.sum() + 0.5
    # The axis from 0.3 to 1.25 carries the widths; light falls by (0.25, -0.2) a unit of height.
    x, y, z = Rotation.from_quat(film.attitude[0], scalar_first=True).apply([0.0, 0.0, 1.0])
    ends = [
        camera.project(height * np.array([x + 0.25 * z, y - 0.2 * z, 0.0]))[:2]
        for height in (0.3, 1.25)
    ]
    assert _from_segment(seen, *ends) < 6.0  # of 200: half the width of the shadow is about 40


def test_labels_of_a_picture_avoid_labels_and_arrows() -> None:
    # L and omega point the same way, one beyond the other: the shorter one's label stands aside.
    origin, far, near = np.array([100.0, 200.0]), np.array([100.0, 40.0]), np.array([100.0, 120.0])
    first, second = label_places(origin, [far, near], [1, 1])
    np.testing.assert_allclose(first[0], 100.0)
    assert first[1] < 40.0
    assert abs(second[0] - 100.0) > 9.0
    together = label_places(origin, [far, far + np.array([1.0, 0.0])], [8, 8])
    assert (np.abs(together[0] - together[1]) > [74.0, 16.0]).any()
