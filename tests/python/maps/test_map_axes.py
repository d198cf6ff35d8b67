"""Maps of any number of axes; horizons, limits, torques and sizes of the noise on an axis."""

import dataclasses
import types
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rigid
from map_texts import map_text
from refusals import refuses
from rigid.cli.toml_map import parse_spec
from rigid.cli.toml_table import SpecError
from rigid.drawing.figure import new_figure
from rigid.maps.axes import check_once, make_axes
from rigid.model.parameters import PARAMETERS
from small_maps import NAMED, Floats, assert_same_map, small_map

TOP = rigid.HeavyTop(rigid.Body((1.0, 1.3, 0.7)), mgl=1.0, com=(0.0, 0.6, 0.8))
CLOUD = rigid.Start(spin=3.0, attitude_noise=rigid.normal(0.3))
ENDS = [2.0, 5.0, 11.0]
FREE: dict[str, Any] = {
    "scene": rigid.FreeBody,
    "axes": {"spin": [0.7, 1.0, 2.0]},
    "stable": rigid.no_flip(),
    "samples": 70,
}
MAPS: dict[str, dict[str, Any]] = {
    "tops with audits": {
        "scene": TOP,
        "axes": {"spin": [1.0, 3.0], "mgl": [0.5, 1.0]},
        "start": CLOUD,
        "stable": rigid.tilt_below(0.6),
        "method": "auto",
        "samples": 70,
    },
    "impossible bodies": {**FREE, "axes": {"I1": [0.1, 0.9, 5.0]}},
}


def assert_slice(
    whole: rigid.StabilityMap, index: tuple[Any, ...], part: rigid.StabilityMap
) -> None:
    for name in NAMED:
        np.testing.assert_array_equal(
            getattr(whole, name)[index], getattr(part, name), err_msg=name
        )


# Horizon and limit


@pytest.mark.parametrize("place", ["first", "last"])
@pytest.mark.parametrize("kind", MAPS)
def test_a_map_over_horizons_is_the_maps_of_each(kind: str, place: str) -> None:
    options = {**MAPS[kind], "progress": False}
    axes = options.pop("axes")
    both = {"t_end": ENDS, **axes} if place == "first" else {**axes, "t_end": ENDS}
    whole = small_map(**options, axes=both, t_end=1.0)
    assert whole.spec.t_end == max(ENDS)
    for k, end in enumerate(ENDS):
        part = small_map(**options, axes=axes, t_end=end)
        index = (..., k) if place == "first" else (k,)
        assert_slice(whole, index, part)


def test_every_horizon_and_limit_sees_the_same_bodies() -> None:
    axes = {"limit": [0.3, 0.6], "mgl": [0.5, 1.0], "t_end": ENDS}
    result = small_map(**{**MAPS["tops with audits"], "axes": axes})
    assert result.share.shape == (3, 2, 2)
    starts = result.starts(3).omega
    for index in ((0, 1, 0), (2, 0, 1), (1, 1, 1)):
        body = result.replay(index, 3)
        assert body.parameters["t_end"] == ENDS[index[0]]
    # All horizons and limits see the same bodies.
    assert (starts == starts[0, :, :1]).all()
    assert result.condition().shape == (3, 2, 2)


def test_the_law_of_the_middle_axis_holds_at_every_horizon() -> None:
    result = small_map(
        rigid.FreeBody,
        method="auto",
        axes={"t_end": np.linspace(5.0, 30.0, 12), "noise": [1e-4, 1e-3]},
        samples=400,
    )
    theory: Any = result.theory()
    assert not np.isnan(theory.share).any()
    # 24 intervals of 95 %: more than 4 misses have a chance of 1 %.
    assert result.disagreement().sum() <= 4


def test_the_condition_of_a_pixel_is_the_median_of_its_first_bodies() -> None:
    """Of each body by the function for one motion; a body of the third pixel cannot exist."""
    result = small_map(axes={"I2/I1": [1.2, 1.8, 5.0]}, samples=5, t_end=7.0)
    starts = result.starts(range(5))
    for count in (1, 2, 5):
        found = result.condition(count)
        for pixel in (0, 1):
            body = rigid.Body(result.spec.grid.moments[pixel])
            alone = rigid.condition(
                body, starts.omega[pixel, :count], starts.attitude[pixel, :count], t=[7.0]
            )
            assert found[pixel] == np.median(alone)
        assert np.isnan(found[2])
    np.testing.assert_array_equal(result.condition(), result.condition(1))
    with pytest.raises(ValueError, match="samples = 6: the map has 5 in a pixel"):
        result.condition(6)
    seen = result.outcomes(range(5))
    for name, nothing in (("outcome", ""), ("method", ""), ("flips", 0), ("steps", 0)):
        assert (getattr(seen, name)[2] == nothing).all()
        assert (getattr(seen, name)[:2] != nothing).all() == (name != "flips")


# Any number of axes


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ([1.0, 2.0, 4.0], "3 values, geometric"),
        ([4.0, 2.0, 1.0], "3 values, geometric"),
        ([1.0, 2.0], "2 values"),
        ([1.0, 2.0, 3.0], "3 values"),
        ([1.0, 1.001, 1.002], "3 values"),
        ([0.0, 1.0, 2.0], "3 values"),
    ],
)
def test_three_values_of_one_ratio_are_a_progression(values: list[float], words: str) -> None:
    (axis,) = make_axes({"spin": values})
    assert str(axis) == f"spin from {values[0]:g} to {values[-1]:g} rad/s ({words})"


FOUR: dict[str, Any] = {
    "I2/I1": [1.2, 1.5],
    "noise": [0.01, 0.1, 1.0],
    "spin": [0.5, 1.0, 2.0, 4.0],
    "I3": [1.9, 2.0],
}


@pytest.mark.parametrize("count", [3, 4])
def test_maps_of_three_and_four_axes(count: int, tmp_path: Path) -> None:
    axes = dict(list(FOUR.items())[:count])
    result = small_map(axes=axes, samples=5)
    assert result.share.shape == tuple(len(values) for values in reversed(axes.values()))
    for index in ((0,) * count, tuple(n - 1 for n in result.share.shape)):
        body = result.replay(index, 2)
        assert body.parameters == {
            name: values[place]
            for (name, values), place in zip(axes.items(), reversed(index), strict=True)
        }
        moments = body.run.spec["scene"]["body"]["moments"]
        assert moments[1] == body.parameters["I2/I1"]
    flat = result.replay(result.share.size - 1, 1)
    assert flat.pixel == tuple(n - 1 for n in result.share.shape)
    loaded = rigid.load_map(result.save(tmp_path / "map.npz"))
    assert_same_map(loaded, result)
    with np.load(tmp_path / "map.npz") as file:
        for name, values in zip(("x", "y", "z", "axis4"), axes.values(), strict=False):
            np.testing.assert_array_equal(file[name], values)
    dataset = loaded.to_xarray()
    assert dataset.share.dims == tuple(name.replace("/", "_over_") for name in reversed(list(axes)))
    summary = loaded.summary()
    for name in ("x", "y", "z", "axis4")[:count]:
        assert f"\n{name} " in summary


def test_a_map_may_have_as_many_axes_as_an_array() -> None:
    names = [f"k{number}" for number in range(32)]
    assert len(make_axes({name: [1.0] for name in names}, names)) == 32


def test_ratios_follow_each_other_along_three_axes() -> None:
    axes: dict[str, Any] = {"I1/I2": [0.5], "I2/I3": [0.8], "I3": [2.0]}
    for order in ((0, 1, 2), (2, 1, 0), (1, 0, 2), (1, 2, 0)):
        names = [list(axes)[k] for k in order]
        spec = small_map(axes={name: axes[name] for name in names}, samples=1, t_end=0.1).spec
        assert spec.grid.moments.tolist() == [[0.8, 1.6, 2.0]]


test_axes_that_do_not_go_together = refuses(
    [
        (["I1/I2", "I2/I3", "I3/I1"], "'I1/I2' and 'I2/I3' and 'I3/I1' set ratios that depend"),
        (["noise", "noise2"], "'noise2' and 'noise' exclude each other: both set the noise"),
        (["limit"], "'limit' does not apply: no flip about axis 2 limits no angle"),
        (["com1"], "'com1' does not apply: a free body feels no weight; use a HeavyTop"),
    ],
    literal=True,
    by=lambda axes: small_map(axes={name: [1.0] for name in axes}, samples=1),
)


test_values_of_a_top_that_do_not_go_together = refuses(
    [
        ({"com1": [1.0], "com_tilt": [0.1]}, "'com1' and 'com_tilt' exclude each other: both say"),
        (
            {"attitude_noise": [1.0], "attitude_noise3": [0.1]},
            "'attitude_noise3' and 'attitude_noise' exclude each other",
        ),
        (
            {"com1": [0.0, 1.0], "com2": [0.0], "com3": [0.0]},
            "axes: com1, com2 and com3 must not all be zero: they are a direction",
        ),
        ({"t_end": [0.0, 1.0]}, "axes['t_end'][0] = 0: must be positive"),
        ({"limit": [1.0, 4.0]}, "axes['limit'][1] = 4: must lie in [0, 3.14159] (rad)"),
        ({"noise1": [1.0]}, "'noise1' does not apply: the start has no noise"),
    ],
    literal=True,
    by=lambda axes: small_map(TOP, axes=axes, start=CLOUD, stable=rigid.tilt_below(0.5), samples=1),
)


def test_a_size_for_each_component_leaves_no_single_one() -> None:
    start = rigid.Start(spin=3.0, attitude_noise=rigid.normal([0.1, 0.2, 0.3]))
    with pytest.raises(ValueError, match="the attitude noise has a size for each component"):
        small_map(TOP, axes={"attitude_noise": [0.1]}, start=start, stable=rigid.tilt_below(0.5))


def test_the_torque_of_an_axis_is_no_table() -> None:
    torque = rigid.Torque.body([(0, 0, 1), (0, 0, 2)], times=[0.0, 1.0])
    scene = rigid.FreeBody(rigid.Body((1.0, 1.5, 2.0)), torque=torque)
    with pytest.raises(ValueError, match="'torque1' does not apply: the torque of the scene is a"):
        small_map(scene, axes={"torque1": [0.1]})


def test_tables_of_more_axes() -> None:
    text = map_text(
        y='name = "limit"\nvalues = [0.5, 1.0]',
        z='name = "t_end"\nvalues = [5, 10]',
        axis4='name = "mgl"\nvalues = [0.5, 1.0]',
        run="samples = 3",
    )
    spec = parse_spec(text, "top.toml")
    assert [axis.name for axis in spec.axes] == ["spin", "limit", "t_end", "mgl"]
    assert (spec.shape, spec.t_end) == ((2, 2, 2, 2), 10.0)
    with pytest.raises(SpecError, match=r"\[axis4\] name = 'spin': the axis \[x\] has this name"):
        parse_spec(text.replace('name = "mgl"', 'name = "spin"'), "top.toml")
    with pytest.raises(SpecError, match="unknown key 'zz'; did you mean 'z'"):
        parse_spec(text.replace("[z]", "[zz]"), "top.toml")
    with pytest.raises(SpecError, match="needs the key 'z'"):
        parse_spec(text.replace("[z]", "[axis5]"), "top.toml")
    with pytest.raises(SpecError, match=r"\[run\] needs the key 't_end'"):
        parse_spec(text.replace('"t_end"', '"tilt"').replace("[5, 10]", "[0.5, 1]"), "top.toml")


# What the new axes set


def first(scene: Any, start: rigid.Start, **axes: Any) -> rigid.Replay:
    chosen = {name: [value] for name, value in axes.items()}
    result = small_map(
        scene, axes=chosen, start=start, stable=rigid.no_flip(2), samples=1, t_end=0.01
    )
    return result.replay((0,) * len(chosen), 0)


@pytest.mark.parametrize(
    ("axes", "com"),
    [
        ({"com1": 0.8}, (0.8, 0.6, 0.8)),
        ({"com2": 0.0}, (0.0, 0.0, 0.8)),
        ({"com3": -0.6, "com2": 0.0}, (0.0, 0.0, -0.6)),
        ({"com1": 3.0, "com2": 4.0, "com3": 12.0}, (3.0, 4.0, 12.0)),
    ],
)
def test_components_of_the_centre_of_mass_are_a_direction(
    axes: dict[str, float], com: tuple[float, ...]
) -> None:
    expected = np.array(com) / np.linalg.norm(com)
    body = first(TOP, CLOUD, **axes)
    # A square root, a quotient and three squares: 2 roundings.
    np.testing.assert_allclose(body.run.spec["scene"]["com"], expected, rtol=0.0, atol=4e-16)


def test_torques_of_an_axis_replace_a_component_of_that_of_the_scene() -> None:
    free = rigid.FreeBody(rigid.Body((1.0, 1.5, 2.0)))
    both = rigid.Torque.body((0.1, 0.2, 0.3)) + rigid.Torque.space((0.0, 0.0, 0.4))
    driven = rigid.FreeBody(free.body, torque=both)
    start = rigid.Start(omega=(0.1, 2.0, 0.3))
    for scene, in_body, in_space in (
        (free, [0.0, 0.7, 0.0], [0.0, 0.0, 0.0]),
        (driven, [0.1, 0.7, 0.3], [0.0, 0.0, 0.4]),
    ):
        torque = first(scene, start, torque2=0.7).run.spec["scene"]["torque"]
        assert torque["in_body"] == [in_body]
        assert torque["in_space"] == [in_space]


def test_a_torque_about_the_axis_speeds_the_spin_up() -> None:
    # About a principal axis: omega = spin + N t / I, and a flip where the torque brakes in time.
    result = small_map(
        rigid.FreeBody(rigid.Body((1.0, 1.5, 2.0))),
        axes={"torque3": [-1.0, -0.5, -0.19, 0.0, 1.0], "spin": [1.0, -1.0]},
        start=rigid.Start(spin=1.0, axis=3),
        stable=rigid.no_flip(3),
        method="auto",
        samples=1,
        t_end=10.0,
    )
    rates = np.array([-1.0, -0.5, -0.19, 0.0, 1.0])
    expected = np.array([1.0 + rates * 10.0 / 2.0 > 0.0, -1.0 + rates * 10.0 / 2.0 < 0.0])
    np.testing.assert_array_equal(result.stable == 1, expected)
    # The braked body stands still at I spin / N.
    np.testing.assert_allclose(result.earliest[0, :2], [2.0, 4.0], rtol=1e-9)
    np.testing.assert_array_equal(result.energy_drift < 1e-9, True)


def test_each_component_of_the_noise_has_an_axis() -> None:
    start = rigid.Start(
        omega=(0.0, 0.0, 0.0), noise=rigid.uniform(0.5), attitude_noise=rigid.uniform(0.25)
    )
    whole: Floats = first(TOP, start, mgl=1.0).omega
    for k in (1, 2, 3):
        one = first(TOP, start, **{f"noise{k}": 1.0}).omega
        expected = whole.copy()
        expected[k - 1] *= 2.0
        assert one.tolist() == expected.tolist()
    # A size of zero about two axes leaves a turn about the third.
    turned = first(TOP, start, attitude_noise1=0.0, attitude_noise2=0.0).attitude
    assert turned[1:3].tolist() == [0.0, 0.0]
    assert turned[3] != 0.0
    sizes = rigid.Start(omega=(0.0, 0.0, 0.0), attitude_noise=rigid.uniform([0.0, 0.0, 0.25]))
    np.testing.assert_array_equal(abs(first(TOP, sizes, mgl=1.0).attitude[3]), abs(turned[3]))


# Pictures


def test_three_and_four_axes_are_small_pictures() -> None:
    for count in (3, 4):
        axes = dict(list(FOUR.items())[:count])
        result = small_map(axes=axes, samples=2, t_end=5.0)
        panels = result.plot()
        shape = (2 if count == 4 else 1, 4)
        assert panels.shape == shape
        for row, column in np.ndindex(*shape):
            panel = panels[row, column]
            mesh = panel.collections[0].get_array()
            index = (column,) if count == 3 else (row, column)
            np.testing.assert_array_equal(np.asarray(mesh).reshape(3, 2), result.share[index])
            assert f"spin = {FOUR['spin'][column]:g} rad/s" in panel.get_title()
        panels[0, 0].figure.canvas.draw()


def test_a_slice_is_drawn_as_a_map_of_its_axes() -> None:
    result = small_map(axes=FOUR, samples=2, t_end=5.0)
    ax = result.plot(at={"spin": 2.0, "I3": 1.9})
    np.testing.assert_array_equal(
        np.asarray(ax.collections[0].get_array()).reshape(3, 2), result.share[0, 2]
    )
    assert "spin = 2 rad/s, I3 = 1.9 kg m²" in ax.get_title(loc="left")
    line = result.plot(at={"spin": 2.0, "I3": 1.9, "noise": 0.1})
    np.testing.assert_array_equal(line.lines[0].get_ydata(), result.share[0, 2, 1])


test_slices_that_a_map_has_not = refuses(
    [
        ({"spim": 1.0}, "at: 'spim' is no axis of the map; did you mean 'spin'?"),
        ({"spin": 1.1}, "at['spin'] = 1.1: is no value of the axis; the nearest is 1"),
        (dict.fromkeys(FOUR, 1.0) | {"I2/I1": 1.2, "I3": 2.0}, "at: must leave an axis to draw"),
    ],
    literal=True,
    by=lambda at: small_map(axes=FOUR, samples=1, t_end=0.1).plot(at=at),
)


def test_more_axes_than_a_picture_shows() -> None:
    five = {**{name: values[:1] for name, values in FOUR.items()}, "t_end": [0.1]}
    result = small_map(axes=five, samples=1)
    with pytest.raises(ValueError, match="at: must give values of spin, I3, t_end: small pictures"):
        result.plot()
    ax = new_figure().add_subplot()
    with pytest.raises(ValueError, match="at: must give values of spin, I3, t_end: one picture"):
        result.plot(ax)


def test_two_names_of_one_number_exclude_each_other() -> None:
    """A period, should there be one, sets the rate of the orbit."""
    rate = PARAMETERS["rate"]
    period = dataclasses.replace(rate, number=np.reciprocal)
    named: list[Any] = [
        types.SimpleNamespace(name=name, parameter=row)
        for name, row in (("rate", rate), ("period", period))
    ]
    with pytest.raises(ValueError, match=r"^axes: 'rate' and 'period' both set rate$"):
        check_once("axes", named)
    # Its derivative is not that by the number of the core.
    scene = rigid.FreeBody(rigid.Body((1.0, 1.5, 2.0)), orbit=rigid.Orbit(0.5, 0.1))
    assert rate.has_derivative(scene)
    assert not period.has_derivative(scene)
