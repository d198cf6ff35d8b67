"""Frames and small turns under the figures: what is drawn is what the physics says."""

from typing import Any

import numpy as np
import pytest
from matplotlib.colors import to_hex
from matplotlib.figure import Figure

from figure_cases import artist, artists, data_of, drawn, texts
from rigid import figures, rotations
from rigid.drawing import colours

ANGLES = (0.7, 0.6, 0.8)


def vectors(arrows: Any) -> Any:
    return np.array([arrow.vector for arrow in arrows])


def hues(artists: Any) -> list[str]:
    return [to_hex(artist.get_edgecolor()) for artist in artists]


XYZ = [ink.colour for ink in colours.AXES]


def test_a_point_is_at_the_sum_of_origin_and_relative_position() -> None:
    point = np.array([0.5, -0.9, 0.3])
    data: Any = figures.frames(ANGLES, origin=[1.0, 2.0, 3.0], point=point)
    assert data.position is not None
    np.testing.assert_allclose(data.position, data.origin + data.relative, rtol=0, atol=1e-15)
    np.testing.assert_allclose(data.body @ data.relative, point, rtol=0, atol=1e-15)
    np.testing.assert_allclose(data.body, rotations.euler_to_matrix(ANGLES).T, rtol=0, atol=0)


def test_frames_are_drawn_where_they_are() -> None:
    data = figures.frames(ANGLES, origin=[1.0, 2.0, 3.0], point=[0.5, -0.9, 0.3])
    ax = drawn(data)
    np.testing.assert_array_equal(vectors(artists(ax, "space")), np.eye(3))
    np.testing.assert_array_equal(vectors(artists(ax, "parallel")), np.eye(3))
    np.testing.assert_array_equal(vectors(artists(ax, "body")), data.body)
    for arrow in (*artists(ax, "parallel"), *artists(ax, "body"), artist(ax, "relative")):
        np.testing.assert_array_equal(arrow.start, data.origin)
    np.testing.assert_array_equal(artist(ax, "position").vector, data.position)
    assert (
        hues(artists(ax, "space"))
        == hues(artists(ax, "parallel"))
        == hues(artists(ax, "body"))
        == XYZ
    )


def test_frames_with_one_origin_and_no_point() -> None:
    data = figures.frames(ANGLES, origin=[0, 0, 0])
    ax = drawn(data)
    assert not artists(ax, "origin") + artists(ax, "relative") + artists(ax, "position")


@pytest.mark.parametrize("angles", [ANGLES, (-2.5, 2.0, -1.0), (0.4, 0.0, 0.0)])
def test_each_turn_of_euler_is_one_about_its_axis(angles: tuple[float, float, float]) -> None:
    data = figures.euler_steps(angles)
    for step in range(3):
        turn = rotations.axis_angle_matrix(data.turned_about[step], angles[step])
        np.testing.assert_allclose(
            data.axes[step + 1], data.axes[step] @ turn.T, rtol=0, atol=4e-16
        )
    np.testing.assert_allclose(
        data.axes[3], rotations.euler_to_matrix(angles).T, rtol=0, atol=4e-16
    )
    # The line of nodes lies in both equators.
    node = data.turned_about[1]
    assert abs(node @ data.axes[0, 2]) < 1e-16
    assert abs(node @ data.axes[3, 2]) < 4e-16


def test_coordinates_in_the_plane_of_the_first_turn() -> None:
    (x, y), phi = (0.35, 0.85), ANGLES[0]
    data = figures.euler_steps(ANGLES, point=(x, y))
    wanted = [x * np.cos(phi) + y * np.sin(phi), y * np.cos(phi) - x * np.sin(phi)]
    np.testing.assert_allclose(data.seen, wanted, rtol=0, atol=2e-16)
    np.testing.assert_allclose(data.seen @ data.axes[1, :2, :2], (x, y), rtol=0, atol=2e-16)
    # Erratum D-03: r sin(alpha - phi) is printed to be y', and is y''.
    printed = np.hypot(x, y) * np.sin(np.arctan2(y, x) - phi)
    assert printed == pytest.approx(data.seen[1], abs=1e-15)
    assert abs(printed - y) > 0.3


def test_the_steps_are_drawn_in_three_panels_and_a_plane() -> None:
    data = figures.euler_steps(ANGLES)
    axes = drawn(data)
    for step in range(3):
        before_and_after = vectors(artists(axes[step], "axes")).reshape(2, 3, 3)
        np.testing.assert_array_equal(before_and_after, data.axes[step : step + 2])
        line = data_of(artist(axes[step], "node"))
        line = line[np.isfinite(line).all(axis=1)]  # with a gap for the name of axis 1
        assert np.abs(np.cross(line, data.turned_about[1])).max() < 1e-15
    np.testing.assert_array_equal(artist(axes, "point").vector, data.point)
    assert [ax.name for ax in axes] == ["3d", "3d", "3d", "rectilinear"]


def test_omega_in_the_frame_of_the_line_of_nodes() -> None:
    data = figures.node_frame(ANGLES)
    rates = np.array([0.6, -0.4, 1.9])
    omega = rotations.omega_from_euler_rates(ANGLES, rates, frame="space")
    node = rotations.omega_from_euler_rates(ANGLES, rates, frame="node")
    np.testing.assert_allclose(data.node @ omega, node, rtol=0, atol=1e-15)
    np.testing.assert_allclose(data.node @ data.node.T, np.eye(3), rtol=0, atol=4e-16)
    np.testing.assert_allclose(data.node[2], data.body[2], rtol=0, atol=4e-16)

    # phi' is along the vertical, psi' along the axis; printed the other way (erratum D-24).
    def along(first: Any, second: Any) -> Any:
        return rates[0] * first + rates[1] * data.node[0] + rates[2] * second

    np.testing.assert_allclose(along(data.space[2], data.body[2]), omega, rtol=0, atol=4e-16)
    assert np.abs(along(data.body[2], data.space[2]) - omega).max() > 0.4


def test_the_node_frame_is_drawn_with_its_angles() -> None:
    data = figures.node_frame(ANGLES)
    ax = drawn(data)
    np.testing.assert_array_equal(vectors(artists(ax, "space")), np.eye(3))
    np.testing.assert_array_equal(vectors(artists(ax, "body")), data.body)
    np.testing.assert_array_equal(vectors(artists(ax, "node")), data.node[:2])
    for line, first, last, angle in zip(
        artists(ax, "angles"),
        (data.space[0], data.space[2], data.node[0]),
        (data.node[0], data.body[2], data.body[0]),
        ANGLES,
        strict=True,
    ):
        points = data_of(line)
        np.testing.assert_allclose(points[[0, -1]], [0.5 * first, 0.5 * last], rtol=0, atol=4e-16)
        length = np.linalg.norm(np.diff(points, axis=0), axis=1).sum()
        assert length == pytest.approx(0.5 * angle, rel=1e-4)
    assert r"\dot{\phi}" in " ".join(texts(ax))


def test_passive_is_active_by_the_opposite_angle() -> None:
    data = figures.active_passive(0.3, vector=[0.9, 0.4])
    opposite = figures.active_passive(-0.3, vector=[0.9, 0.4])
    np.testing.assert_allclose(data.seen, opposite.turned, rtol=0, atol=1e-16)
    np.testing.assert_allclose(data.seen @ data.axes, data.vector, rtol=0, atol=2e-16)


def test_the_first_order_of_a_turn_leaves_the_second() -> None:
    size = np.hypot(0.9, 0.4)
    for angle in (0.1, 0.05):
        data = figures.active_passive(angle, vector=[0.9, 0.4])
        left = np.linalg.norm(data.turned - data.vector - data.first_order)
        assert left == pytest.approx(0.5 * angle**2 * size, rel=1e-3)


def test_both_readings_of_a_turn_are_drawn() -> None:
    data = figures.active_passive(0.3)
    ax = drawn(data)
    np.testing.assert_array_equal(artist(ax, "turned").vector, data.turned)
    np.testing.assert_array_equal(artist(ax, "first_order").start, data.vector)
    np.testing.assert_array_equal(artist(ax, "first_order").vector, data.first_order)
    turned = vectors(artists(ax, "axes"))
    np.testing.assert_allclose(
        turned / np.linalg.norm(turned, axis=1, keepdims=True), data.axes, atol=2e-16
    )
    assert hues(artists(ax, "axes")) == XYZ[:2]
    assert [panel.get_aspect() for panel in ax] == [1.0, 1.0]


def test_a_unit_vector_moves_across_itself_and_the_axis() -> None:
    angle = 1e-4
    data = figures.unit_vector_change(angle)
    np.testing.assert_array_equal(data.first_order, [0.0, 0.0, -angle])
    np.testing.assert_allclose(data.change, data.first_order, rtol=0, atol=0.51 * angle**2)
    # Erratum D-05: the caption lets it move along -x1, where the change is of second order.
    assert abs(data.change[0]) < 1e-4 * abs(data.change[2])
    for unit in (1, 2, 3):
        for about in {1, 2, 3} - {unit}:
            other = figures.unit_vector_change(angle, unit=unit, about=about)
            np.testing.assert_allclose(
                other.change / angle, np.cross(other.about, other.unit), rtol=0, atol=angle
            )


def test_the_change_of_a_unit_vector_is_drawn_at_its_tip() -> None:
    data = figures.unit_vector_change(0.3, unit=2, about=3)
    ax = drawn(data)
    np.testing.assert_array_equal(vectors(artists(ax, "axes")), np.eye(3))
    change = artist(ax, "change")
    np.testing.assert_array_equal(change.start, [0.0, 1.0, 0.0])
    np.testing.assert_allclose(
        change.start + change.vector, artist(ax, "turned").vector, rtol=0, atol=1e-16
    )
    np.testing.assert_array_equal(artist(ax, "first_order").vector, data.first_order)
    assert hues(artists(ax, "axes")) == XYZ


def test_points_of_a_body_go_on_circles_about_the_axis() -> None:
    positions, omega = np.random.default_rng(7).normal(size=(6, 3)), np.array([0.3, -0.2, 1.2])
    data = figures.rotating_body(positions, omega)
    for later in (1e-5, -1e-5):
        moved = rotations.rotate(positions, omega, later * np.linalg.norm(omega))
        np.testing.assert_allclose((moved - positions) / later, data.velocities, atol=2e-5)
    np.testing.assert_allclose(
        np.linalg.norm(data.circles, axis=-1),
        np.broadcast_to(np.linalg.norm(positions, axis=-1)[:, np.newaxis], (6, 97)),
        rtol=1e-14,
    )
    heights = data.circles @ omega
    np.testing.assert_allclose(heights, heights[:, :1] * np.ones(97), rtol=0, atol=1e-14)
    np.testing.assert_allclose(data.circles[:, 0], positions, rtol=0, atol=0)


def test_velocities_are_drawn_to_one_scale() -> None:
    positions = [[1.0, 0.0, 0.0], [0.0, 2.0, 0.5], [0.0, 0.0, 1.0]]
    data = figures.rotating_body(positions, [0.0, 0.0, 3.0])
    ax = drawn(data)
    shown, true = vectors(artists(ax, "velocities")), data.velocities
    scale = np.linalg.norm(shown[1]) / np.linalg.norm(true[1])
    np.testing.assert_allclose(shown, scale * true, rtol=0, atol=1e-15)
    np.testing.assert_array_equal(data_of(artist(ax, "positions")), positions)
    # The position of the point that is farthest from the axis.
    np.testing.assert_array_equal(artist(ax, "position").vector, positions[1])
    assert not artists(ax, "velocities")[2].get_visible()  # on the axis
    assert to_hex(artist(ax, "omega").get_edgecolor()) == colours.OMEGA.colour


def test_a_block_shows_the_body_of_the_points() -> None:
    data = figures.rotating_body([[0.5, -1.0, 0.2]], [0.0, 0.0, 3.0], sides=(1.0, 2.0, 0.4))
    ax = drawn(data)
    faces: Any = data.faces
    assert artist(ax, "faces") is not None
    corners = {tuple(corner) for corner in faces.reshape(-1, 3).round(12).tolist()}
    assert corners == {(x, y, z) for x in (-0.5, 0.5) for y in (-1.0, 1.0) for z in (-0.2, 0.2)}
    points_alone = figures.rotating_body([[1.0, 0.0, 0.0]], [0.0, 0.0, 3.0])
    assert not artists(points_alone.plot(), "faces")


def test_given_axes_are_used() -> None:
    figure = Figure()
    space, plane = figure.add_subplot(1, 2, 1, projection="3d"), figure.add_subplot(1, 2, 2)
    assert figures.frames(ANGLES).plot(space) is space
    assert figures.active_passive(0.2).plot([plane, figure.add_subplot()])[0] is plane


def panel_in_space(figure: Figure) -> Any:
    return figure.add_axes((0.0, 0.0, 1.0, 1.0), projection="3d", proj_type="ortho")


def test_bodies_are_seen_to_scale_and_whole() -> None:
    """A sphere of points is as wide as it is high, and fills the axes without leaving them."""
    from mpl_toolkits.mplot3d.proj3d import proj_transform

    from rigid.drawing.axes3d import fit

    points = np.random.default_rng(3).normal(size=(4000, 3))
    points *= 1e-6 / np.linalg.norm(points, axis=1, keepdims=True)
    ax = panel_in_space(Figure(figsize=(8.0, 6.0)))
    fit(ax, points + 5e-6)
    ax.figure.canvas.draw()
    x, y, _ = proj_transform(*(points + 5e-6).T, ax.get_proj())
    assert np.ptp(x) == pytest.approx(np.ptp(y), rel=0.01)
    assert np.ptp(x) == pytest.approx(0.88 * ax.viewLim.width, rel=0.02)
    limits = [ax.get_xlim3d(), ax.get_ylim3d(), ax.get_zlim3d()]
    sides = np.diff(limits, axis=1)[:, 0]
    np.testing.assert_allclose(sides, sides[0], rtol=1e-9)


@pytest.mark.parametrize("size", [(8.0, 3.0), (3.0, 8.0)])
def test_wide_and_high_axes_are_filled(size: tuple[float, float]) -> None:
    """Axes in space are square; points that fill wide or high axes are drawn beyond the square."""
    from mpl_toolkits.mplot3d.proj3d import proj_transform

    from rigid.drawing.axes3d import curve, fit

    page = np.array([[0.0, -size[0], -size[1]], [0.0, size[0], size[1]]])  # seen along x
    figure = Figure(figsize=size)
    ax = panel_in_space(figure)
    line = curve(ax, page, "black")
    fit(ax, page, elev=0.0, azim=0.0)
    figure.draw_without_rendering()
    x, y, _ = proj_transform(*page.T, ax.get_proj())
    ends = ax.transData.transform(np.stack([x, y], axis=1))
    np.testing.assert_allclose(np.ptp(ends, axis=0), 0.88 * np.array(figure.bbox.size), rtol=0.02)
    assert not line.get_clip_on()


@pytest.mark.parametrize("angle", [0.0, np.pi, -4.0])
def test_special_angles_draw_without_a_word(angle: float) -> None:
    drawn(figures.frames([angle, angle, angle], point=[0, 0, 0]))
    drawn(figures.euler_steps([angle, angle, angle]))
    drawn(figures.node_frame([angle, angle, angle]))
    drawn(figures.active_passive(angle))
    drawn(figures.unit_vector_change(angle))
