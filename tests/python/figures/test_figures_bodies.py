"""Free tops, heavy tops, boxes, springs and bearings under the figures."""

from typing import Any, cast

import numpy as np
import pytest
from matplotlib.colors import to_hex

import rigid
from figure_cases import artist, artists, data_of, drawn
from refusals import refuses
from rigid import figures, fixed_axis, free, rotations, springs
from rigid.drawing import colours

OBLATE, PROLATE = (1.0, 1.0, 1.6), (1.0, 1.0, 0.55)
OMEGA = (0.9, 0.0, 2.3)
TOPS = [(OBLATE, OMEGA), (PROLATE, OMEGA), ((1.0, 0.55, 1.0), (0.9, -1.3, 0.2))]
CORNER = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [0.8, 0.9, 0.7]])
MASSES = np.array([1.0, 2.0, 1.0, 1.5, 1.0])
TILTED = np.array([[2.0, 0.0, -0.5], [0.0, 2.0, 0.2], [-0.5, 0.2, 1.5]])


def unit(vector: Any) -> Any:
    return vector / np.linalg.norm(vector, axis=-1, keepdims=True)


def heavy(mgl: float = 2.0) -> rigid.HeavyTop:
    return rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=mgl)


@pytest.mark.parametrize(("body", "omega"), TOPS)
def test_omega_turns_by_k_t_on_a_circle_about_the_axis(body: Any, omega: Any) -> None:
    t = 0.8
    data = figures.free_top_omega(body, omega, t=t)
    run = rigid.simulate(rigid.FreeBody(rigid.Body(body)), omega, t=[0.0, t])
    np.testing.assert_allclose(data.now, run.omega[..., -1, :].reshape(3), rtol=0, atol=1e-12)
    turned = rotations.rotate(data.start, data.axis, data.angle)
    np.testing.assert_allclose(data.now, turned, rtol=0, atol=1e-13)
    heights = data.path @ data.axis
    across = np.linalg.norm(data.path - np.outer(heights, data.axis), axis=1)
    np.testing.assert_allclose(heights, np.dot(omega, data.axis), rtol=1e-13)
    np.testing.assert_allclose(across, data.amplitude, rtol=1e-13)
    np.testing.assert_allclose(data.path[-1], data.path[0], rtol=0, atol=1e-13)


def test_the_sense_of_the_turn_tells_oblate_from_prolate() -> None:
    assert figures.free_top_omega(OBLATE, OMEGA).k == pytest.approx(1.38, abs=1e-15)
    assert figures.free_top_omega(PROLATE, OMEGA).k == pytest.approx(-1.035, abs=1e-15)


def test_omega_is_drawn_with_its_circle_and_the_part_across() -> None:
    data = figures.free_top_omega(OBLATE, OMEGA, t=0.9)
    ax = drawn(data)
    np.testing.assert_array_equal(artist(ax, "start").vector, OMEGA)
    np.testing.assert_array_equal(artist(ax, "now").vector, data.now)
    np.testing.assert_array_equal(data_of(artist(ax, "path")), data.path)
    assert np.abs(data_of(artist(ax, "projection")) @ data.axis).max() < 1e-15
    assert np.linalg.norm(artist(ax, "amplitude").vector) == pytest.approx(
        data.amplitude, rel=1e-14
    )
    assert to_hex(artist(ax, "now").get_edgecolor()) == colours.OMEGA.colour
    drawn(figures.free_top_omega((1, 1, 1), OMEGA, t=3.0))  # k = 0: nothing turns
    drawn(figures.free_top_omega(OBLATE, (0.0, 0.0, -2.0)))  # nothing across the axis


def test_momentum_lies_on_one_side_of_omega_or_on_the_other() -> None:
    for body, sign in ((OBLATE, -1.0), (PROLATE, 1.0)):
        (data,) = figures.coplanar_vectors([body], OMEGA).tops
        ratio = data.across / data.along
        assert np.tan(data.theta) == pytest.approx(ratio * np.tan(data.alpha), rel=1e-14)
        assert np.sign(data.theta - data.alpha) == sign
        momentum = np.array(body) * OMEGA  # omega lies in the plane of axes 1 and 3
        np.testing.assert_allclose(data.momentum, momentum[[0, 2]], rtol=1e-15)


def test_each_body_has_its_panel() -> None:
    found = figures.coplanar_vectors([OBLATE, PROLATE, (1, 1, 1)], OMEGA)
    axes = drawn(found)
    titles = [ax.get_title() for ax in axes]
    assert ["oblate" in titles[0], "prolate" in titles[1], "spherical" in titles[2]] == [True] * 3
    for data, ax in zip(found.tops, axes, strict=True):
        omega, momentum = artist(ax, "omega"), artist(ax, "momentum")
        np.testing.assert_array_equal(omega.vector, data.omega)
        np.testing.assert_allclose(unit(momentum.vector), unit(data.momentum), atol=2e-16)
        assert np.arctan2(*momentum.vector) == pytest.approx(data.theta, abs=1e-15)
        assert to_hex(momentum.get_edgecolor()) == colours.L.colour
    drawn(figures.coplanar_vectors([OBLATE], (0.9, 0.0, -1.0)))


@pytest.mark.parametrize(("body", "omega"), TOPS)
@pytest.mark.parametrize("t", [0.0, 1.7])
def test_cones_touch_along_omega(body: Any, omega: Any, t: float) -> None:
    data = figures.cones(body, omega, t=t)
    for axis, half in ((data.axis, data.body_cone), (data.momentum, data.space_cone)):
        angle = np.arccos(unit(axis) @ unit(data.omega))
        assert angle == pytest.approx(half, abs=1e-13)
    # Axis, omega and L in one plane, L upwards.
    assert abs(np.linalg.det([data.axis, unit(data.omega), unit(data.momentum)])) < 1e-15
    np.testing.assert_allclose(unit(data.momentum), [0.0, 0.0, 1.0], rtol=0, atol=1e-14)
    for rim, axis in ((data.body_rim, data.axis), (data.space_rim, data.momentum)):
        heights = rim @ unit(axis)
        np.testing.assert_allclose(heights, data.omega @ unit(axis), rtol=1e-12)


@pytest.mark.parametrize(("body", "omega"), TOPS)
def test_the_body_cone_rolls_and_does_not_slip(body: Any, omega: Any) -> None:
    top = free.symmetric_free_top(body, omega)
    number, samples = 30, 121
    t = float(top.period) * number / (samples - 1)
    data = figures.cones(body, omega, t=t, samples=samples)
    # The generator that the body carries to omega at t, and how far the contact has gone on both.
    np.testing.assert_allclose(data.body_rim[number], data.omega, rtol=0, atol=1e-12)
    start = figures.cones(body, omega)
    rate = float(np.linalg.norm(omega))
    on_body = abs(float(top.k)) * t * rate * np.sin(data.body_cone)
    on_space = float(top.precession) * t * rate * np.sin(data.space_cone)
    assert on_body == pytest.approx(on_space, rel=1e-13)
    around = rotations.rotate(start.omega, [0.0, 0.0, 1.0], float(top.precession) * t)
    np.testing.assert_allclose(data.omega, around, rtol=0, atol=1e-12)
    # What is on the contact has no velocity.
    assert np.abs(np.cross(data.omega, data.body_rim[number])).max() < 1e-11


def test_cones_are_drawn_from_their_rims() -> None:
    data = figures.cones(PROLATE, OMEGA, t=0.4)
    ax = drawn(data)
    np.testing.assert_array_equal(data_of(artist(ax, "body_rim")), data.body_rim)
    np.testing.assert_array_equal(data_of(artist(ax, "space_rim")), data.space_rim)
    for arrow, true in (
        (artist(ax, "omega"), data.omega),
        (artist(ax, "momentum"), data.momentum),
        (artist(ax, "axis"), data.axis),
    ):
        np.testing.assert_allclose(unit(arrow.vector), unit(true), rtol=0, atol=4e-16)
    names = " ".join(text.get_text() for text in ax.texts)
    assert f"body cone\n{np.degrees(data.body_cone):.1f}°" in names
    drawn(figures.cones(OBLATE, OMEGA))


@pytest.mark.parametrize("angles", [(0.9, 0.6, 0.8), (0.3, 2.0, -1.0), (0.0, 0.0, 0.0)])
def test_the_torque_of_the_weight_is_along_the_line_of_nodes(angles: Any) -> None:
    length, mgl = 0.7, 2.0
    data = figures.heavy_top(heavy(mgl), angles, length=length)
    np.testing.assert_allclose(data.torque, np.cross(data.com, data.weight), rtol=0, atol=1e-15)
    wanted = mgl * np.sin(angles[1]) * data.frame.node[0]
    np.testing.assert_allclose(data.torque, wanted, rtol=0, atol=1e-15)
    assert abs(data.torque[2]) < 1e-16
    assert abs(data.torque @ data.frame.body[2]) < 1e-15
    assert np.linalg.norm(data.com) == pytest.approx(length, rel=1e-15)
    # The cone that is drawn has its centre of mass there: from the apex, by quadrature.
    base = data.rim[:-1].mean(axis=0)
    part = (np.arange(4000) + 0.5) / 4000  # slices of area part²
    share = (part**3).sum() / (part**2).sum()
    np.testing.assert_allclose(data.com, share * base, rtol=1e-6, atol=1e-15)


def test_the_top_is_drawn_with_weight_and_angles() -> None:
    data = figures.heavy_top(heavy(), [0.9, 0.6, 0.8])
    ax = drawn(data)
    np.testing.assert_array_equal(artist(ax, "weight").start, data.com)
    np.testing.assert_allclose(unit(artist(ax, "weight").vector), unit(data.weight), atol=1e-16)
    np.testing.assert_allclose(unit(artist(ax, "torque").vector), unit(data.torque), atol=2e-16)
    ends = [data_of(line)[[0, -1]] for line in artists(ax, "angles")]
    np.testing.assert_allclose(unit(ends[1]), [[0, 0, 1], data.frame.body[2]], atol=2e-16)
    centre = data.rim[:-1].mean(axis=0)
    spins = unit(ends[2] - centre)
    np.testing.assert_allclose(spins, [data.frame.node[0], data.frame.body[0]], atol=1e-14)
    ax = drawn(figures.heavy_top(heavy(0.0), [0.0, 0.0, 0.0]))
    assert not artists(ax, "weight") + artists(ax, "torque")


def test_the_box_of_the_throw() -> None:
    data = figures.box(rigid.Body.box(0.01, 0.08, 0.25, mass=12.0))
    np.testing.assert_allclose(data.moments, np.array([689, 626, 65]) * 1e-4, rtol=1e-14)
    assert data.kinds == ("stable", "unstable", "stable")
    assert len({tuple(corner) for corner in data.corners.tolist()}) == 8
    np.testing.assert_allclose(np.abs(data.corners), 0.5 * data.sides * np.ones((8, 1)), rtol=0)
    lengths = np.linalg.norm(np.diff(data.corners[data.edges], axis=1)[:, 0], axis=-1)
    np.testing.assert_allclose(np.sort(lengths), np.repeat([0.01, 0.08, 0.25], 4), rtol=1e-15)
    neutral = figures.box(rigid.Body.box(0.1, 0.1, 0.3))
    assert neutral.kinds == ("neutral", "neutral", "stable")


def test_the_axes_of_the_box_start_on_its_faces() -> None:
    data = figures.box(rigid.Body.box(0.1, 0.2, 0.3))
    ax = drawn(data)
    np.testing.assert_allclose(
        [a.start for a in artists(ax, "axes")], np.diag([0.05, 0.1, 0.15]), rtol=0
    )
    directions = unit(np.array([a.vector for a in artists(ax, "axes")]))
    np.testing.assert_allclose(directions, np.eye(3), rtol=0, atol=0)
    shown = np.array([data_of(edge) for edge in artists(ax, "edges")])
    np.testing.assert_array_equal(shown, data.corners[data.edges])
    faint = [edge for edge in artists(ax, "edges") if edge.get_color() == colours.FAINT]
    assert len(faint) == 3  # those at the corner behind


@pytest.fixture(scope="module")
def springs_of_a_body() -> Any:
    return figures.spring_modes(MASSES, CORNER, [0.0, 1.0, 0.3], stiffness=[1e2, 1e3, 1e4])


def test_six_modes_have_no_frequency_and_distance_falls_as_one_over_k(
    springs_of_a_body: Any,
) -> None:
    data = springs_of_a_body
    assert data.zero == 6
    assert not data.frequencies[:6].any()
    assert (data.frequencies[6:] > 0.0).all()
    assert data.distance[1] / data.distance[2] == pytest.approx(10.0, abs=0.5)
    assert (np.diff(data.evaluations) > 0).all()
    # Erratum G-02: those of the second derivatives without the masses are no frequencies.
    system = springs.pair_system(MASSES, CORNER, stiffness=1e2)
    printed = np.sqrt(np.linalg.eigvalsh(system.hessian())[6:])
    assert np.abs(printed / data.frequencies[6:] - 1.0).max() > 0.1


def test_springs_are_drawn_as_spectrum_and_limit(springs_of_a_body: Any) -> None:
    data = springs_of_a_body
    axes = drawn(data)
    modes = np.concatenate([data_of(line) for line in artists(axes, "frequencies")])
    np.testing.assert_array_equal(modes, np.stack([np.arange(1, 16), data.frequencies], axis=1))
    distances = np.stack([data.stiffness, data.distance], axis=1)
    np.testing.assert_array_equal(data_of(artist(axes, "distance")), distances)
    slope = data_of(artist(axes, "slope"))
    assert np.ptp(slope[:, 0] * slope[:, 1]) < 1e-12 * slope[0, 0] * slope[0, 1]
    spectrum, limit = axes
    assert "rad/s" in spectrum.get_ylabel()
    assert "(N/m)" in limit.get_xlabel()
    assert "(m)" in limit.get_ylabel()
    assert (limit.get_xscale(), limit.get_yscale()) == ("log", "log")


def test_torque_in_space_is_the_rate_of_change_of_the_angular_momentum() -> None:
    omega, omega_dot, step = 10.0, 8.0, 1e-5
    data = figures.bearing_torque(TILTED, omega, omega_dot=omega_dot)
    ends = [
        fixed_axis.bearing_torques(
            TILTED,
            omega + omega_dot * h,
            angle=data.angle + omega * h + 0.5 * omega_dot * h * h,
        ).angular_momentum_space
        for h in (-step, step)
    ]
    np.testing.assert_allclose((ends[1] - ends[0]) / (2 * step), data.torque, rtol=0, atol=1e-5)
    np.testing.assert_allclose(data.torque[:, 2], 1.5 * omega_dot, rtol=1e-14)
    across = np.linalg.norm(data.torque[:, :2], axis=1)
    np.testing.assert_allclose(across, data.size[-1], rtol=1e-13)


def test_bearing_torques_are_drawn_with_units() -> None:
    data = figures.bearing_torque(TILTED, -10.0, omega_dot=8.0)
    ax = drawn(data)
    components = artists(ax, "torque")
    for line, values, ink in zip(components, data.torque.T, colours.AXES, strict=True):
        np.testing.assert_array_equal(line.get_ydata(), values)
        np.testing.assert_array_equal(line.get_xdata(), np.degrees(data.angle))
        assert line.get_color() == ink.colour
    np.testing.assert_array_equal(artist(ax, "size").get_ydata(), data.size)
    turning, rising = ax
    assert "degrees" in turning.get_xlabel()
    assert "(N m)" in turning.get_ylabel()
    assert "(rad/s)" in rising.get_xlabel()
    assert "(N m)" in rising.get_ylabel()


def test_no_size_is_too_small_or_too_large_to_draw() -> None:
    """The Earth: cones of 0.2" and of 0.0007"; then tops of atoms and of stars."""
    earth, tilt = (1.0, 1.0, 1.00329), 9.69627e-7
    data = figures.cones(earth, [7.292e-5 * tilt, 0.0, 7.292e-5])
    assert data.body_cone == pytest.approx(tilt, rel=1e-9)
    assert data.space_cone == pytest.approx(tilt * (1.0 - 1.0 / 1.00329), rel=1e-9)
    drawn(figures.cones(earth, [7.292e-5 * tilt, 0.0, 7.292e-5]))
    for scale in (1e-12, 1e12):
        moments = scale * np.array(OBLATE)
        drawn(figures.cones(moments, [0.9 / scale, 0.0, 1.3 / scale]))
        drawn(figures.free_top_omega(moments, [0.9 / scale, 0.0, 1.3 / scale], t=scale))
        drawn(figures.coplanar_vectors([moments], [0.9 / scale, 0.0, 1.3 / scale]))
        drawn(figures.box(rigid.Body.box(scale, 2 * scale, 3 * scale)))
        drawn(figures.heavy_top(heavy(scale), [0.3, 0.4, 0.5], length=scale))
        drawn(figures.bearing_torque(scale * TILTED, 10.0))


test_what_cannot_be_drawn_is_refused = refuses(
    [
        (lambda: figures.free_top_omega((1, 2, 3), OMEGA), "symmetr"),
        (lambda: figures.free_top_omega(OBLATE, [0, 0, 0]), "has no axis"),
        (lambda: figures.free_top_omega(OBLATE, OMEGA, t=np.inf), "t = inf"),
        (lambda: figures.coplanar_vectors([], OMEGA), "bodies: expected at least"),
        (lambda: figures.coplanar_vectors([(1, 1, 9)], OMEGA), "triangle"),
        (lambda: figures.cones(OBLATE, [0, 0, 2]), "no cone rolls"),
        (lambda: figures.cones(OBLATE, [2, 0, 0]), "no cone rolls"),
        (lambda: figures.cones((1, 1, 1), OMEGA), "no cone rolls"),
        (lambda: figures.box(cast(Any, (1, 2, 3))), TypeError, "must be a rigid.Body"),
        (lambda: figures.box(rigid.Body((1, 2, 3))), "sides are not known"),
        (
            lambda: figures.heavy_top(cast(Any, "top"), [0, 0, 0]),
            TypeError,
            "must be a rigid.HeavyTop",
        ),
        (
            lambda: figures.heavy_top(
                rigid.HeavyTop(rigid.Body((1, 1, 1)), mgl=1.0, com=(1, 0, 0)), [0, 0, 0]
            ),
            r"com = \(1.0, 0.0, 0.0\): must be",
        ),
        (lambda: figures.heavy_top(heavy(), [0, 0, 0], length=0.0), "length = 0.0"),
        (
            lambda: figures.spring_modes(MASSES, CORNER, [0, 0, 1], stiffness=[10.0]),
            "two or more, positive and ascending",
        ),
        (
            lambda: figures.spring_modes(MASSES, CORNER, [0, 0, 1], stiffness=[10.0, 5.0]),
            "two or more, positive and ascending",
        ),
        (lambda: figures.bearing_torque(TILTED, 0.0), "omega = 0.0"),
        (lambda: figures.bearing_torque(np.eye(2), 1.0), r"expected shape \(3, 3\)"),
        (lambda: figures.bearing_torque(np.diag([1, 1, 9]), 1.0), "no body has"),
        (lambda: figures.frames([0, 1]), r"angles: expected shape \(3,\)"),
        (lambda: figures.frames([0, np.nan, 1]), r"angles\[1\] = nan: must be finite"),
        (
            lambda: figures.euler_steps([0.7, 0.6, 0.8], point=[1, 2, 3]),
            r"point: expected shape \(2,\)",
        ),
        (lambda: figures.active_passive(0.1, vector=[0, 0]), r"vector = \[0.0, 0.0\]: must not"),
        (lambda: figures.unit_vector_change(0.1, unit=4), "axis = 4: must be one of"),
        (lambda: figures.unit_vector_change(0.1, about=1), "does not turn about itself"),
        (lambda: figures.rotating_body([], [0, 0, 1]), "positions: expected shape"),
        (lambda: figures.rotating_body(np.empty((0, 3)), [0, 0, 1]), "of one or more"),
        (lambda: figures.rotating_body([[1, 0, 0]], [0, 0, 0]), "omega = .*must not be zero"),
        (
            lambda: figures.rotating_body([[1, 0, 0]], [0, 0, 1], sides=(1, 0, 1)),
            r"sides = \[1.0, 0.0, 1.0\]: must be positive",
        ),
    ]
)
