"""The grid: what each axis sets, how arrays are laid out, and bodies that cannot exist."""

import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rigid
from physics import gamma_of, rotation_matrix
from rigid.model.parameters import PARAMETERS
from rigid.model.scene import Scene, scene_from_dict
from small_maps import NAMED, Floats, in_blocks, small_map

BODY = rigid.Body((1.0, 1.5, 2.0))
FREE = rigid.FreeBody(BODY)
BOX = rigid.FreeBody(rigid.Body.box(0.25, 0.08, 0.01, mass=0.3))
TOP = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.5, com=(0.0, 0.6, 0.8))
SPIN = rigid.Start(spin=3.0, axis=2, tilt=0.1)
RATES = rigid.Start(omega=(0.1, 2.0, 0.3))
CLOUD = rigid.Start(spin=3.0, noise=rigid.uniform(0.0), attitude_noise=rigid.direction(0.0))


def first_body(
    scene: Scene, start: rigid.Start, **axes: Any
) -> tuple[rigid.Replay, Scene, rigid.StabilityMap]:
    """The first body of a map of one pixel, and the scene that it moves in."""
    result = small_map(
        scene,
        axes={name.replace("_over_", "/"): [value] for name, value in axes.items()},
        start=start,
        stable=rigid.no_flip(2),
        samples=1,
        t_end=0.01,
    )
    body = result.replay(0, 0)
    return body, scene_from_dict(body.run.spec["scene"]), result


def box(a: float = 0.25, b: float = 0.08, c: float = 0.01, mass: float = 0.3) -> Any:
    return rigid.Body.box(a, b, c, mass=mass).moments


@pytest.mark.parametrize(
    ("axes", "moments"),
    [
        ({"I1": 1.2}, (1.2, 1.5, 2.0)),
        ({"I2": 1.2}, (1.0, 1.2, 2.0)),
        ({"I3": 1.2}, (1.0, 1.5, 1.2)),
        ({"I1": 1.2, "I3": 1.3}, (1.2, 1.5, 1.3)),
        ({"I1_over_I2": 0.5}, (0.75, 1.5, 2.0)),
        ({"I1_over_I3": 0.75}, (1.5, 1.5, 2.0)),
        ({"I2_over_I1": 1.25}, (1.0, 1.25, 2.0)),
        ({"I2_over_I3": 0.75}, (1.0, 1.5, 2.0)),
        ({"I3_over_I1": 1.5}, (1.0, 1.5, 1.5)),
        ({"I3_over_I2": 0.5}, (1.0, 1.5, 0.75)),
        # A ratio refers to what the other axis sets, whichever comes first.
        ({"I3": 1.6, "I2_over_I3": 0.5}, (1.0, 0.8, 1.6)),
        ({"I2_over_I3": 0.5, "I3": 1.6}, (1.0, 0.8, 1.6)),
        ({"I1_over_I2": 0.5, "I2_over_I3": 0.75}, (0.75, 1.5, 2.0)),
        ({"I2_over_I3": 0.5, "I1_over_I2": 1.25}, (1.25, 1.0, 2.0)),
        ({"I1_over_I2": 1.25, "I2_over_I3": 0.5}, (1.25, 1.0, 2.0)),
        ({"I1_over_I3": 0.5, "I2_over_I3": 0.75}, (1.0, 1.5, 2.0)),
        # Sides and mass of a box; a moment may be set on it as well.
        ({"a": 0.2}, box(a=0.2)),
        ({"b": 0.2}, box(b=0.2)),
        ({"c": 0.2}, box(c=0.2)),
        ({"mass": 2.0}, box(mass=2.0)),
        ({"b": 0.2, "mass": 2.0}, box(b=0.2, mass=2.0)),
        ({"c": 0.02, "a": 0.04}, box(a=0.04, c=0.02)),
        ({"I1_over_I2": 0.9, "c": None}, (0.9 * box()[1], *box()[1:])),
    ],
)
def test_moments_ratios_and_sides(
    axes: dict[str, float | None], moments: tuple[float, ...]
) -> None:
    given = {name: value for name, value in axes.items() if value is not None}
    of_a_box = not axes.keys().isdisjoint(("a", "b", "c", "mass"))
    _, scene, _ = first_body(BOX if of_a_box else FREE, SPIN, **given)
    assert scene.body.moments == moments


def test_axes_replace_what_the_start_says() -> None:
    assert first_body(FREE, RATES, omega1=-1.0)[0].omega.tolist() == [-1.0, 2.0, 0.3]
    assert first_body(FREE, RATES, omega2=-1.0)[0].omega.tolist() == [0.1, -1.0, 0.3]
    assert first_body(FREE, RATES, omega3=-1.0)[0].omega.tolist() == [0.1, 2.0, -1.0]
    start = rigid.Start(spin=3.0, axis=2)
    assert first_body(FREE, start, spin=-7.0)[0].omega.tolist() == [0.0, -7.0, 0.0]
    assert first_body(FREE, rigid.Start(spin=3.0), tilt=0.3)[0].omega.tolist() == pytest.approx(
        [0.0, 3.0 * math.sin(0.3), 3.0 * math.cos(0.3)], rel=1e-15
    )


@pytest.mark.parametrize("axis", [1, 2, 3])
def test_tilt_of_a_free_body_leans_the_rates_towards_the_axis_before(axis: int) -> None:
    body, _, _ = first_body(FREE, rigid.Start(spin=3.0, axis=axis), tilt=0.4)
    expected = np.zeros(3)
    expected[axis - 1], expected[axis - 2] = 3.0 * math.cos(0.4), 3.0 * math.sin(0.4)
    np.testing.assert_allclose(body.omega, expected, rtol=2.0**-52, atol=0.0)
    assert body.attitude.tolist() == [1.0, 0.0, 0.0, 0.0]


@pytest.mark.parametrize("tilt", [0.0, 0.4, -1.3, math.pi / 2, math.pi])
@pytest.mark.parametrize("axis", [1, 2, 3])
def test_tilt_of_a_top_leans_its_axis_from_the_vertical(axis: int, tilt: float) -> None:
    body, _, _ = first_body(TOP, rigid.Start(spin=3.0, axis=axis), tilt=tilt)
    gamma = np.zeros(3)
    gamma[axis - 1], gamma[axis - 2] = math.cos(tilt), math.sin(tilt)
    # Half the angle is rounded once, a product of a quaternion twice.
    np.testing.assert_allclose(gamma_of(body.attitude), gamma, atol=2e-15)
    np.testing.assert_allclose(rotation_matrix(body.attitude)[2], gamma, atol=2e-15)
    assert np.linalg.norm(body.attitude) == pytest.approx(1.0, abs=4e-16)
    assert body.omega.tolist() == (3.0 * np.eye(3)[axis - 1]).tolist()


def test_an_upright_top_about_axis_3_starts_with_the_identity() -> None:
    body, _, _ = first_body(TOP, CLOUD, tilt=0.0)
    assert body.attitude.tolist() == [1.0, 0.0, 0.0, 0.0]


def test_damping_about_an_axis_replaces_that_of_the_scene() -> None:
    damped = rigid.HeavyTop(TOP.body, mgl=TOP.mgl, com=TOP.com, damping=(0.1, 0.2, 0.3))
    for k in (1, 2, 3):
        _, scene, _ = first_body(damped, CLOUD, **{f"damping{k}": 0.7})
        expected = [0.1, 0.2, 0.3]
        expected[k - 1] = 0.7
        assert np.diag(np.array(scene.damping)).tolist() == expected
    _, scene, _ = first_body(FREE, SPIN, damping2=0.5)
    assert np.array(scene.damping).tolist() == np.diag([0.0, 0.5, 0.0]).tolist()


def test_coefficients_are_set_one_by_one_or_all_alike() -> None:
    """An axis adds a force that the scene does not have; the other coefficients stay."""
    scene = rigid.FreeBody(
        rigid.Body((1.0, 1.5, 2.0)), dissipation=rigid.EnergySink((0.01, 0.02, 0.03)), drag=0.5
    )
    for axes, sink, drag, damping in (
        ({"dissipation2": 0.04}, (0.01, 0.04, 0.03), (0.5, 0.5, 0.5), None),
        ({"dissipation": 0.04}, (0.04, 0.04, 0.04), (0.5, 0.5, 0.5), None),
        ({"drag3": 0.1}, (0.01, 0.02, 0.03), (0.5, 0.5, 0.1), None),
        ({"drag": 0.1}, (0.01, 0.02, 0.03), (0.1, 0.1, 0.1), None),
        ({"damping": 0.2}, (0.01, 0.02, 0.03), (0.5, 0.5, 0.5), 0.2 * np.eye(3)),
    ):
        _, found, _ = first_body(scene, SPIN, **axes)
        assert isinstance(found, rigid.FreeBody)
        assert found.dissipation is not None
        assert found.dissipation.coefficient == sink
        assert found.drag == drag
        assert np.array_equal(np.array(found.damping or 0.0), 0.0 if damping is None else damping)
    _, found, _ = first_body(TOP, CLOUD, drag2=0.25)
    assert isinstance(found, rigid.HeavyTop)
    assert found.drag == (0.0, 0.25, 0.0)


def test_the_rate_of_an_orbit_is_set() -> None:
    orbit = rigid.Orbit(0.1, 0.3, 0.2)
    scene = rigid.FreeBody(rigid.Body((1.0, 1.5, 2.0)), orbit=orbit)
    _, found, result = first_body(scene, rigid.Start(omega=(0.0, 0.0, 0.1)), rate=0.4)
    assert isinstance(found, rigid.FreeBody)
    assert found.orbit == rigid.Orbit(0.4, 0.3, 0.2)
    assert "orbit at a varied rate, eccentricity 0.3" in str(result.plan)


@pytest.mark.parametrize("name", ["damping", "dissipation", "drag"])
def test_coefficients_are_not_set_twice(name: str) -> None:
    expected = f"axes: '{name}2' and '{name}' exclude each other: both set the {name}"
    with pytest.raises(ValueError, match=re.escape(expected)):
        first_body(FREE, SPIN, **{name: 0.1, f"{name}2": 0.2})


def test_the_centre_of_mass_has_two_angles() -> None:
    """Each keeps the other; on axis 3 the azimuth is 0."""
    leaning = rigid.HeavyTop(TOP.body, mgl=2.0, com=(0.48, 0.36, 0.8))
    upright = rigid.HeavyTop(TOP.body, mgl=1.5)
    for scene, angles, com in (
        (leaning, {"com_tilt": 0.5 * np.pi}, (0.8, 0.6, 0.0)),
        (leaning, {"com_tilt": np.pi}, (0.0, 0.0, -1.0)),
        (leaning, {"com_turn": 0.5 * np.pi}, (0.0, 0.6, 0.8)),
        (leaning, {"com_turn": -np.pi, "com_tilt": 0.1}, (-np.sin(0.1), 0.0, np.cos(0.1))),
        (leaning, {"com_tilt": 0.1, "com_turn": -np.pi}, (-np.sin(0.1), 0.0, np.cos(0.1))),
        (upright, {"com_tilt": 0.3}, (np.sin(0.3), 0.0, np.cos(0.3))),
        (upright, {"com_turn": 0.3}, (0.0, 0.0, 1.0)),
    ):
        _, found, _ = first_body(scene, CLOUD, **angles)
        assert isinstance(found, rigid.HeavyTop)
        np.testing.assert_allclose(found.com, com, rtol=0.0, atol=4e-16)
        assert found.mgl == scene.mgl


def test_sizes_of_the_noise() -> None:
    # Twice the size is exactly twice the deviate of a start at rest.
    start = rigid.Start(spin=0.0, noise=rigid.uniform(5.0))
    one, two = (first_body(FREE, start, noise=size)[0].omega for size in (0.25, 0.5))
    assert (2.0 * one).tolist() == two.tolist()
    assert abs(two).max() > 0.0
    # A direction of that length, turned by exactly that angle from an upright start.
    body, _, _ = first_body(TOP, CLOUD, attitude_noise=0.3)
    assert 2.0 * math.acos(body.attitude[0]) == pytest.approx(0.3, rel=1e-14)


def test_every_parameter_is_documented() -> None:
    """The docstring names one ratio as an example; the page of maps includes the table."""
    expected = {name for name in PARAMETERS if not name.startswith("I") or "/" not in name}
    expected |= {"I2/I1"}
    text = (rigid.stability_map.__doc__ or "").partition("Names:")[2].partition("samples : int")[0]
    assert set(re.findall(r"``([^` ]+)``", text)) == expected
    # The table of the page is made from PARAMETERS when the site is built.
    page = Path(__file__).parents[3] / "docs" / "maps_reference.md"
    assert "```{include} map_parameters.txt" in page.read_text()


# Layout


def test_two_axes_are_indexed_y_first() -> None:
    x, y = [1.0, 2.0, 4.0], [0.5, 0.25]
    result = small_map(axes={"omega1": x, "omega3": y}, start=RATES, samples=2, t_end=0.01)
    for name in NAMED:
        assert getattr(result, name).shape == (2, 3), name
    assert [axis.name for axis in result.spec.axes] == ["omega1", "omega3"]
    for row in range(2):
        for column in range(3):
            body = result.replay((row, column), 1)
            assert body.omega.tolist() == [x[column], 2.0, y[row]]
            assert body.parameters == {"omega1": x[column], "omega3": y[row]}
            assert body.pixel == (row, column)
            flat = result.replay(3 * row + column, 1)
            assert flat.pixel == (row, column)
            assert flat.omega.tolist() == body.omega.tolist()
            assert body.sample == 1


def test_one_axis_gives_one_dimension() -> None:
    result = small_map(axes={"spin": [3.0, 2.0, 1.0]}, samples=1, t_end=0.01)
    assert result.share.shape == (3,)
    assert result.replay(2, 0).parameters == {"spin": 1.0}
    assert result.replay((2,), 0).pixel == (2,)
    assert result.replay(np.int64(2), np.int64(0)).pixel == (2,)  # type: ignore[arg-type]


def test_lists_tuples_and_integers_are_values() -> None:
    expected = small_map(axes={"spin": np.array([1.0, 2.0])}, samples=3)
    for values in ([1, 2], (1.0, 2.0), np.arange(1, 3), np.arange(4.0)[1::1][:2]):
        result = small_map(axes={"spin": values}, samples=3)
        assert result.spec == expected.spec
        assert result.earliest.tolist() == expected.earliest.tolist()


@pytest.mark.parametrize(
    ("pixel", "sample"),
    [((2, 0), 0), ((0, 3), 0), ((-1, 0), 0), ((0,), 0), ((0, 0, 0), 0), (6, 0), (-1, 0), (0, 2)],
)
def test_replay_outside_the_map(pixel: Any, sample: int) -> None:
    axes = {"omega1": [1.0, 2.0, 4.0], "omega3": [0.5, 0.25]}
    result = small_map(axes=axes, start=RATES, samples=2, t_end=0.01)
    message = r"sample = 2: must lie in 0 \.\. 1" if sample else "lies outside the map of shape"
    with pytest.raises(IndexError, match=message):
        result.replay(pixel, sample)
    with pytest.raises(TypeError, match=r"pixel = 0\.5: must be a whole number"):
        result.replay(0.5, sample)  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="sample = '0': must be a whole number"):
        result.replay(0, "0")  # type: ignore[arg-type]


# Impossible bodies

# Which rule breaks first: 1 not finite, 2 not positive, 3 the triangle inequality.
BIG = 1e308
IMPOSSIBLE: list[tuple[dict[str, Floats], list[int]]] = [
    ({"I1": np.array([-1.0, 0.0, 0.4, 0.5, 3.5, 3.6])}, [2, 2, 3, 0, 0, 3]),
    ({"I1/I2": np.array([-1.0, 0.3, 1.0, 9.0])}, [2, 3, 0, 3]),
    ({"I1": np.array([1.0, BIG])}, [0, 3]),
]


@pytest.mark.parametrize(("axes", "status"), IMPOSSIBLE)
def test_impossible_bodies_have_a_status_and_nothing_else(
    axes: dict[str, Floats], status: list[int]
) -> None:
    result = small_map(axes=axes, start=rigid.Start(spin=1.0, axis=2), samples=4)
    assert result.status.tolist() == status
    bad = result.status != 0
    assert result.complete
    np.testing.assert_array_equal(result.samples, np.where(bad, 0, 4))
    for name in ("stable", "unstable", "undecided", "failed", "checked", "steps"):
        assert not getattr(result, name)[bad].any(), name
    for name in ("share", "lower", "upper"):
        np.testing.assert_array_equal(np.isnan(getattr(result, name)), bad)
    assert np.isnan(result.energy_drift[bad]).all()
    with pytest.raises(ValueError, match=r"pixel = \(\d,\): no body exists there: "):
        result.replay(int(np.flatnonzero(bad)[0]), 0)


def test_a_moment_that_overflows_is_not_finite() -> None:
    # 1e200 times 1e200: an infinite moment, of which nothing but the status must be seen.
    result = small_map(
        axes={"I3": [1.2, 1e200], "I1/I3": [0.9, 1e200]},
        start=rigid.Start(spin=1.0, axis=2),
        samples=3,
    )
    assert result.status.tolist() == [[0, 3], [3, 1]]
    assert result.samples.tolist() == [[3, 0], [0, 0]]


def test_impossible_bodies_harm_no_neighbour() -> None:
    # Draws depend on the number of the pixel: so the same pixels are compared, the impossible ones
    # of one map being possible in the other.
    start = rigid.Start(spin=1.0, axis=2, noise=rigid.normal(0.05))
    good = np.array([0.8, 0.9, 1.1, 1.2, 1.3])
    bad = np.array([-2.0, 0.1, 1.1, 1.2, 7.0])
    clean = small_map(axes={"I1": good}, start=start, samples=37)
    for units in (1, 10):
        with in_blocks(units):
            mixed = small_map(axes={"I1": bad}, start=start, samples=37)
        assert mixed.status.tolist() == [2, 3, 0, 0, 3]
        for name in NAMED:
            np.testing.assert_array_equal(
                getattr(mixed, name)[2:4], getattr(clean, name)[2:4], err_msg=name
            )
    assert clean.unstable[2] > 0


def test_a_map_of_impossible_bodies_only() -> None:
    start = rigid.Start(spin=1.0, axis=2)
    result = small_map(axes={"I1": [10.0, 11.0]}, start=start, method="auto")
    assert result.complete
    assert result.samples.sum() == 0
    assert result.theory() is None
    assert "2 impossible pixels" in result.summary()
    assert "worst drift energy unknown, momentum unknown" in result.summary()
    assert result.plan.why == ("no pixel has a possible body: nothing is done",)


def test_a_flat_box_is_possible_at_equality() -> None:
    assert small_map(axes={"I3": [2.5]}, start=rigid.Start(spin=1.0)).status.tolist() == [0]


# What is omitted of a request


@pytest.mark.parametrize("scene", [rigid.FreeBody, rigid.HeavyTop])
def test_a_class_stands_for_a_documented_scene(scene: Any) -> None:
    result = small_map(
        scene, axes={"spin": [5.0]}, stable=rigid.tilt_below(0.5), samples=1, t_end=0.1
    )
    if scene is rigid.FreeBody:
        assert result.spec.scene == FREE
        assert result.spec.start == rigid.Start(spin=1.0, axis=2, noise=rigid.normal(1e-3))
        assert result.spec.stable == rigid.tilt_below(0.5, reference="start")
    else:
        assert result.spec.scene == rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)
        assert result.spec.start == rigid.Start(spin=5.0, attitude_noise=rigid.normal(1e-3))
        assert result.spec.stable == rigid.tilt_below(0.5, reference="vertical")


@pytest.mark.parametrize("order", [(0, 1, 2), (1, 2, 0), (2, 0, 1), (0, 2, 1)])
def test_a_free_body_spins_about_its_middle_axis_by_default(order: tuple[int, ...]) -> None:
    moments = np.array([1.0, 1.5, 2.0])[list(order)]
    result = small_map(
        rigid.FreeBody(rigid.Body(moments)), axes={"noise": [0.01]}, samples=1, t_end=0.1
    )
    assert result.spec.start.starts[0].axis == int(np.flatnonzero(moments == 1.5)[0]) + 1
    assert result.spec.stable == rigid.no_flip(result.spec.start.starts[0].axis)


@pytest.mark.parametrize(
    ("start", "axis"),
    [
        (rigid.Start(spin=1.0), 3),
        (rigid.Start(spin=1.0, axis=1, tilt=1.5), 1),
        (rigid.Start(omega=(0.1, -2.0, 1.0)), 2),
    ],
)
def test_no_flip_watches_the_axis_of_the_start(start: rigid.Start, axis: int) -> None:
    result = small_map(axes={"I1": [1.0]}, start=start, samples=1, t_end=0.1)
    assert result.spec.stable == rigid.no_flip(axis)
