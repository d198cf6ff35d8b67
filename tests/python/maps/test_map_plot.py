"""The picture of a map: what is drawn is what was computed, where it belongs, and named."""

import base64
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import PolyCollection, QuadMesh
from matplotlib.contour import QuadContourSet
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch

import rigid
from pages import content, unpacked
from processes import python_process
from rigid.drawing.along import SIZE, _broken, write_along
from rigid.maps import page
from rigid.maps.contours import zero_lines
from rigid.maps.data import STORED
from rigid.maps.page import content_of_map
from rigid.maps.watched import watched
from small_maps import Floats, small_map, spec_of

X, Y = np.linspace(1.01, 1.99, 7), np.geomspace(1e-3, 0.1, 5)


@pytest.fixture(scope="module")
def result() -> rigid.StabilityMap:
    return small_map()


def pretended(spec: rigid.MapSpec, **changes: Any) -> rigid.StabilityMap:
    """A result with 20 stable bodies in every pixel but for these changes."""
    arrays: dict[str, Any] = {name: np.zeros(spec.shape, dtype=np.int64) for name in STORED}
    arrays["stable"] += 20
    for name, cells in changes.items():
        for index, value in cells.items():
            arrays[name][index] = value
            if name != "stable":
                arrays["stable"][index] = 0 if name == "status" else 20 - value
    return rigid.StabilityMap.from_arrays(spec, arrays)


def mesh_of(ax: Axes) -> QuadMesh:
    (mesh,) = (one for one in ax.collections if isinstance(one, QuadMesh))
    return mesh


def legend_of(ax: Axes) -> list[str]:
    legend = ax.get_legend()
    return [] if legend is None else [text.get_text() for text in legend.get_texts()]


def hatched(ax: Axes) -> dict[str, PathPatch]:
    return {str(one.get_label()): one for one in ax.patches if isinstance(one, PathPatch)}


def covers(patch: PathPatch, x: float, y: float) -> bool:
    """Whether a hatch covers a point of the axes."""
    polygons = patch.get_path().to_polygons()
    return any(mpl.path.Path(polygon).contains_point((x, y)) for polygon in polygons)


# A plane


def test_the_share_lies_under_its_values(result: rigid.StabilityMap) -> None:
    ax = result.plot()
    mesh = mesh_of(ax)
    data = mesh.get_array()
    assert data is not None
    np.testing.assert_array_equal(np.ma.getdata(data), result.share)
    assert 0.0 < result.share.mean() < 1.0
    corners = np.asarray(mesh.get_coordinates())
    assert corners.shape == (6, 8, 2)  # [y, x]
    edges_x, edges_y = corners[0, :, 0], corners[:, 0, 1]
    # Each value is in the middle of its cell, in the scale that is drawn.
    np.testing.assert_allclose(0.5 * (edges_x[1:] + edges_x[:-1]), X, rtol=1e-12)
    np.testing.assert_allclose(np.sqrt(edges_y[1:] * edges_y[:-1]), Y, rtol=1e-12)
    assert (ax.get_xscale(), ax.get_yscale()) == ("linear", "log")
    assert ax.get_xlim() == (edges_x[0], edges_x[-1])
    assert ax.get_ylim() == pytest.approx((edges_y[0], edges_y[-1]))
    assert mesh.get_clim() == (0.0, 1.0)
    assert mesh.get_cmap().name == "cividis"


def test_pixels_look_as_their_numbers_say() -> None:
    # Rendered: a map whose only stable pixel is [0, 2] is bright at the lower right, nowhere else.
    spec = spec_of(axes={"omega1": [1.0, 2.0, 3.0], "omega3": [1.0, 2.0]}, start=RATES, rng=1)
    every = {(i, j): 20 for i in range(2) for j in range(3)}
    result = pretended(spec, unstable={k: v for k, v in every.items() if k != (0, 2)})
    figure = Figure(figsize=(6, 4), dpi=50)
    ax = result.plot(ax=figure.add_axes((0.1, 0.1, 0.6, 0.6)))
    canvas = FigureCanvasAgg(figure)
    canvas.draw()  # type: ignore[no-untyped-call]
    image = np.asarray(canvas.buffer_rgba())  # type: ignore[no-untyped-call]
    bright = {}
    for row, y in enumerate([1.0, 2.0]):
        for column, x in enumerate([1.0, 2.0, 3.0]):
            across, upward = ax.transData.transform((x + 0.2, y + 0.2))
            bright[row, column] = int(image[-int(upward) - 1, int(across), 0])
    assert {place for place, red in bright.items() if red > 200} == {(0, 2)}


RATES = rigid.Start(omega=(0.1, 1.0, 0.1), noise=rigid.normal(0.1))


def test_decreasing_and_single_values_have_cells_too() -> None:
    result = small_map(axes={"spin": [3.0, 2.0, 1.0], "noise": [0.01]}, samples=4)
    corners = np.asarray(mesh_of(result.plot()).get_coordinates())
    np.testing.assert_allclose(corners[0, :, 0], [3.5, 2.5, 1.5, 0.5])
    np.testing.assert_allclose(corners[:, 0, 1], [0.005, 0.015])
    np.testing.assert_array_equal(mesh_of(result.plot()).get_array(), result.share)


def test_labels_say_what_stable_means_and_until_when() -> None:
    result = small_map(title="My map")
    ax = result.plot()
    assert ax.get_xlabel() == "$I_2/I_1$"
    assert ax.get_ylabel() == "perturbation of the rates (rad/s)"
    title = ax.get_title(loc="left")
    assert title.splitlines()[0] == "My map"
    assert "stable: no flip about axis 2 until t = 20 s" in title
    assert "20 bodies per pixel" in title
    figure: Any = ax.figure
    (bar,) = (one for one in figure.axes if one is not ax)
    assert bar.get_ylabel() == "share stable until t = 20 s"


def test_pictures_and_pages_without_a_title_are_named_after_their_scene() -> None:
    moving = rigid.FreeBody(rigid.Body((0.7, 1.0, 1.2)), orbit=rigid.Orbit(1e-3))
    free = rigid.FreeBody(moving.body)
    for scene, name in ((moving, "satellite"), (free, "free body"), (rigid.HeavyTop, "heavy top")):
        result = small_map(scene, axes={"spin": [1.0, 2.0]}, samples=1, t_end=0.1)
        title = result.plot().get_title(loc="left").splitlines()[0]
        assert title == f"Stability of a {name}"
        assert content_of_map(result, 1)["title"] == title


def test_a_page_has_as_many_bodies_as_fit_into_its_bytes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Their starts too, if it cannot draw them; MOST_BYTES counts what is compressed."""
    start = rigid.Start(spin=1.0, axis=2, noise=rigid.normal(cov=1e-2 * np.eye(3)))
    axes = {"I2/I1": np.linspace(1.1, 1.9, 9), "spin": np.linspace(1.0, 2.0, 8)}
    result = small_map(axes=axes, start=start, samples=64)
    monkeypatch.setattr(page, "MOST_BYTES", 40_000)
    held = content(result.explore(tmp_path / "map.html"))
    texts = [held[name]["data"] for name in ("omega", "attitude", "outcome", "left")]
    size = sum(len(base64.b64decode(text)) for text in texts)
    assert 0.8 * page.MOST_BYTES < size <= page.MOST_BYTES


def test_a_page_holds_starts_of_one_energy_where_moments_vary(tmp_path: Path) -> None:
    """It cannot draw them: the rates of each body follow from its own moments."""
    result = small_map(
        axes={"energy": [0.5, 1.0]},
        start=rigid.Start(spin=1.0, axis=2),
        vary={"I2": rigid.uniform(0.2)},
        samples=5,
    )
    held = content(result.explore(tmp_path / "map.html"))
    drawn = result.starts(range(5))
    assert unpacked(held["omega"]).tobytes() == drawn.omega.tobytes()
    twice = drawn.parameters["I2"] * drawn.omega[..., 1] ** 2
    np.testing.assert_allclose(twice, [[1.0] * 5, [2.0] * 5], rtol=1e-15)


def test_the_page_watches_returns_from_their_time_on() -> None:
    (chart, (limit,)), *_ = watched(spec_of(stable=rigid.returns(0.5, after=3.0)))
    assert (chart["what"], chart["after"]) == ("turn", 3.0)
    assert (limit == np.degrees(0.5)).all()


def test_one_body_in_a_pixel_has_a_class_and_a_refined_map_has_shares_too() -> None:
    swatches = ["stable", "unstable"]
    ax = small_map(samples=1).plot()
    assert len(ax.figure.axes) == 1
    assert legend_of(ax)[:2] == swatches
    refined = small_map(samples=1, refine=2)
    ax = refined.plot()
    drawn: Any = np.ma.asarray(mesh_of(ax).get_array())
    assert ((drawn > 0.0) & (drawn < 1.0)).any()  # between the corners of cells
    assert len(ax.figure.axes) == 2  # a bar of colours
    assert not set(swatches) & set(legend_of(ax))


def test_a_given_axes_is_used(result: rigid.StabilityMap) -> None:
    figure = Figure()
    ax = figure.add_subplot()
    assert result.plot(ax=ax) is ax
    assert result.plot().figure is not figure


# Hatches

PLANE = {"axes": {"I2/I1": X, "noise": Y}}
MARKS = {
    "impossible body": {"status": {(0, 0): 3, (0, 1): 3, (4, 6): 2}},
    "not computed": {"stable": {(1, 1): 0, (2, 2): 0}},
    "failed > 5 %": {"failed": {(0, 0): 2, (3, 5): 20, (1, 1): 1}},
    "undecided > 5 %": {"undecided": {(2, 3): 2, (2, 4): 10, (4, 0): 1}},
}
AT_THE_LIMIT = {"failed > 5 %": (1, 1), "undecided > 5 %": (4, 0)}  # 1 of 20 is not above


@pytest.mark.parametrize("label", MARKS)
def test_cells_without_a_true_share_are_hatched_with_a_legend(label: str) -> None:
    (cells,) = MARKS[label].values()
    ax = pretended(spec_of(**PLANE), **MARKS[label]).plot()
    patches = hatched(ax)
    assert set(patches) == {label}
    assert patches[label].get_hatch()
    assert label in legend_of(ax)
    for row, y in enumerate(Y):
        for column, x in enumerate(X):
            expected = (row, column) in cells and AT_THE_LIMIT.get(label) != (row, column)
            assert covers(patches[label], float(x), float(y)) == expected, (row, column)
    data = mesh_of(ax).get_array()
    assert data is not None
    if label == "impossible body":
        assert np.ma.getmaskarray(data).sum() == 3  # no colour, not even that of 0


def test_failed_and_undecided_pixels_keep_the_colour_of_their_share() -> None:
    """Rendered: more than half of a hatched pixel has the colour of its share."""
    spec = spec_of(axes={"omega1": [1.0, 2.0], "omega3": [1.0, 2.0]}, start=RATES, rng=1)
    marked = {"failed": {(0, 0): 4}, "undecided": {(1, 1): 4}}
    result = pretended(spec, **marked, unstable={(0, 1): 20})
    figure = Figure(figsize=(8, 8), dpi=100)
    ax = result.plot(ax=figure.add_axes((0.1, 0.1, 0.7, 0.7)))
    canvas = FigureCanvasAgg(figure)
    canvas.draw()  # type: ignore[no-untyped-call]
    image = np.asarray(canvas.buffer_rgba())[::-1, :, :3]  # type: ignore[no-untyped-call]
    for row, column in np.ndindex(2, 2):
        (left, low), (right, high) = (
            ax.transData.transform((column + 1 + side, row + 1 + side)).astype(int)
            for side in (-0.4, 0.4)
        )
        cell = image[low:high, left:right].reshape(-1, 3).astype(int)
        share = 255.0 * np.array(mpl.colormaps["cividis"](result.share[row, column])[:3])
        kept = float((abs(cell - share).max(axis=1) <= 2).mean())
        if any((row, column) in cells for cells in marked.values()):
            assert 0.5 < kept < 0.99, (row, column)
        else:
            assert kept == 1.0


def test_hatches_differ_and_there_are_none_without_need() -> None:
    spec = spec_of(**PLANE)
    everything: dict[str, Any] = {}
    for row, marks in enumerate(MARKS.values()):
        for name, cells in marks.items():
            everything[name] = dict.fromkeys([(row, 0), (row, 1)], next(iter(cells.values())))
    ax = pretended(spec, **everything).plot()
    patterns = [patch.get_hatch() for patch in hatched(ax).values()]
    assert len(set(patterns)) == len(patterns) == 4
    assert hatched(pretended(spec).plot()) == {}


def test_the_curve_of_theory_is_drawn_and_named() -> None:
    result = small_map(
        axes={"I2": np.linspace(0.8, 2.4, 12), "tilt": np.linspace(0.0, 1.5, 10)},
        start=rigid.Start(spin=1.0, axis=2),
        samples=1,
    )
    ax = result.plot()
    assert [text.get_text() for text in ax.texts] == ["separatrix"]
    assert not any("theory" in text for text in legend_of(ax))
    none = small_map(
        axes={"tilt": [0.1, 0.2], "noise": [0.1, 0.2]},
        start=rigid.Start(spin=1.0, noise=rigid.normal(0.0)),
        stable=rigid.tilt_below(0.3),
    )
    assert none.theory() is None
    drawn = none.plot()
    assert not drawn.texts
    assert not any("theory" in text for text in legend_of(drawn))


def curve_of(ax: Axes) -> Floats:
    """Points of the first line of theory of a picture, (x, y)."""
    contour, *_ = (one for one in ax.collections if isinstance(one, QuadContourSet))
    (path,) = contour.get_paths()
    return np.asarray(path.vertices)


def test_the_separatrix_is_drawn_to_a_twentieth_of_a_pixel() -> None:
    # A spin about axis 2, tilted towards axis 1; I1 = 1, I3 = 2: 2 E I2 = L² is tan² = I2 (I2 - 2).
    # On 13 pixels the interpolated line would be 0.2 pixels off where the border begins.
    x, y = np.linspace(1.5, 2.4, 13), np.linspace(0.0, 1.2, 11)
    start = rigid.Start(spin=1.0, axis=2)
    ax = pretended(spec_of(axes={"I2": x, "tilt": y}, start=start)).plot()
    drawn = curve_of(ax)
    tilt = np.linspace(-0.1, 1.2, 100_001)
    exact = np.stack([1.0 + np.sqrt(1.0 + np.tan(tilt) ** 2), tilt], axis=1)
    pixel = np.array([x[1] - x[0], y[1] - y[0]])
    distance = [np.linalg.norm((exact - point) / pixel, axis=1).min() for point in drawn]
    assert max(distance) < 0.05
    # From the lower edge of the cells to the right one.
    assert drawn[:, 0].max() == ax.get_xlim()[1]
    assert drawn[:, 1].min() == ax.get_ylim()[0]


def test_a_line_of_theory_reaches_the_edges_that_are_values() -> None:
    # The lower edge would be a negative damping, and without damping there is no onset.
    axes = {"spin": np.linspace(4.2, 9.0, 9), "damping3": np.linspace(0.0, 4e-3, 9)}
    start = rigid.Start(spin=5.0, attitude_noise=rigid.normal(1e-2))
    options: dict[str, Any] = {"stable": rigid.tilt_below(0.5), "rng": 1, "progress": False}
    result = rigid.stability_map(
        rigid.HeavyTop, axes=axes, start=start, samples=1, t_end=1e-6, **options
    )
    spec = result.spec.replace(t_end=100.0)
    ax = pretended(spec).plot()
    onset = curve_of(ax)
    assert 0.0 < onset[:, 1].min() < 2.5e-4
    assert onset[:, 0].max() == ax.get_xlim()[1]
    # ln(I3 w / 2) I3 / c = t_end, to a twentieth of a pixel.
    damping = 0.5 * np.log(onset[:, 0] / 4.0) / 100.0
    assert np.abs(damping - onset[:, 1]).max() < 0.05 * 5e-4


def test_a_line_of_theory_ends_at_the_pixels_where_no_body_is_beyond_them() -> None:
    # At the lower edge the moment is zero: such a body is a rod, which cannot spin about its axis.
    axes = {"I3": [0.25, 0.75, 1.25], "spin": np.linspace(1.0, 10.0, 8)}
    top = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)
    start = rigid.Start(spin=3.0, tilt=0.1)
    asked: dict[str, Any] = {"scene": top, "start": start, "stable": rigid.tilt_below(0.5)}
    drawn = curve_of(pretended(spec_of(**asked, axes=axes)).plot())
    assert (drawn[:, 0].min(), drawn[:, 0].max()) == (0.25, 1.25)


def test_a_body_that_has_left_is_shown_with_the_time() -> None:
    """As a picture of its rates with a line and a word, where a stable body has rates alone."""
    result = small_map(axes={"noise": [1e-3, 1e-2]}, t_end=30.0)
    words: dict[str, list[str]] = {}

    def drawn(draw: Callable[[Any], object], text: str, **_: Any) -> str:
        ax = Figure().add_subplot()
        draw(ax)
        words[text.partition(";")[2].split()[0]] = [one.get_text() for one in ax.texts]
        return text

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("rigid.maps.replay.html_with_picture", drawn)
        for sample in range(20):
            result.replay(0, sample)._repr_html_()
    assert words == {"stable;": [], "unstable": ["left"]}


def test_a_line_of_theory_belongs_to_its_slice() -> None:
    tilts, moments = np.linspace(0.0, 1.2, 11), [1.6, 2.0]
    axes = {"I2": np.linspace(1.5, 2.4, 13), "tilt": tilts, "I3": moments}
    result = pretended(spec_of(axes=axes, start=rigid.Start(spin=1.0, axis=2)))
    for middle in moments:
        # I2 (I2 - I3) = (I3 - I1) I1 tan².
        moment, tilt = curve_of(result.plot(at={"I3": middle})).T
        exact = np.arctan(np.sqrt(np.maximum(moment * (moment - middle) / (middle - 1.0), 0.0)))
        assert np.abs(np.abs(tilt) - exact).max() < 0.05


# A line


def test_a_line_has_its_interval_as_a_band() -> None:
    result = small_map(axes={"noise": np.geomspace(1e-3, 0.1, 9)})
    ax = result.plot()
    share = next(line for line in ax.lines if line.get_label() == "share")
    np.testing.assert_array_equal(share.get_xdata(), result.spec.axes[0].values)
    np.testing.assert_array_equal(share.get_ydata(), result.share)
    (band,) = (one for one in ax.collections if isinstance(one, PolyCollection))
    outline = np.asarray(band.get_paths()[0].vertices)
    for x, lower, upper in zip(result.spec.axes[0].values, result.lower, result.upper, strict=True):
        heights: Floats = outline[outline[:, 0] == x, 1]
        assert (heights.min(), heights.max()) == (lower, upper)
    theory: Any = result.theory()
    line = next(line for line in ax.lines if line.get_label() == "theory")
    np.testing.assert_array_equal(line.get_ydata(), theory.share)
    assert legend_of(ax) == ["share", "95 % interval", "theory"]
    assert ax.get_xscale() == "log"
    assert ax.get_ylabel() == "share stable until t = 20 s"
    assert ax.get_ylim() == (-0.02, 1.02)


def test_a_line_hatches_impossible_bodies() -> None:
    x = np.array([0.1, 0.9, 1.1, 1.3, 9.0])
    ax = small_map(axes={"I1": x}, start=rigid.Start(spin=1.0, axis=2)).plot()
    patch = hatched(ax)["impossible body"]
    assert [covers(patch, float(value), 0.5) for value in x] == [True, False, False, False, True]


# Manners


def test_no_global_state_is_touched() -> None:
    code = (
        "import sys, matplotlib, rigid\n"
        "def settings():  # to ask for the backend would load one\n"
        "    keys = set(matplotlib.rcParams) - {'backend'}\n"
        "    return {key: matplotlib.rcParams[key] for key in keys}\n"
        "before = settings()\n"
        "result = rigid.stability_map(rigid.FreeBody, axes={'spin': [1.0, 2.0]}, samples=2,\n"
        "    t_end=1.0, stable=rigid.no_flip(), progress=False)\n"
        "result.plot().figure.savefig('/dev/null', format='png')\n"
        "assert settings() == before\n"
        "assert 'matplotlib.pyplot' not in sys.modules\n"
    )
    python_process(code, DISPLAY="", MPLBACKEND="")


def test_without_matplotlib_it_is_said_what_is_missing(
    result: rigid.StabilityMap, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[tuple[str, Callable[[], object], str]] = [
        ("matplotlib.figure", result.plot, "plotting needs matplotlib"),
        ("xarray", result.to_xarray, "to_xarray() needs xarray"),
    ]
    for module, ask, needs in asked:
        monkeypatch.setitem(sys.modules, module, None)
        with pytest.raises(ImportError) as caught:
            ask()
        assert str(caught.value) == f"{needs}: pip install 'rigid-rotation[maps]'"


def test_drawing_a_large_map_takes_no_loop_over_its_pixels() -> None:
    # 100 x 100 cells with a hatch in every second one make two artists, not five thousand.
    axes = {"spin": np.linspace(1.0, 2.0, 100), "noise": np.geomspace(1e-3, 0.1, 100)}
    start = rigid.Start(spin=1.0, axis=2, noise=rigid.normal(0.0))
    spec = spec_of(axes=axes, start=start, check=0.0)
    cells = {(i, j): 20 for i in range(100) for j in range(i % 2, 100, 2)}
    ax = pretended(spec, undecided=cells).plot()
    assert len(ax.patches) == 1
    assert len(ax.get_children()) < 30


def test_a_plane_one_pixel_high_is_drawn_without_curves() -> None:
    result = rigid.stability_map(
        rigid.HeavyTop,
        axes={"spin": [3.0, 4.0, 5.0], "attitude_noise": [1e-3]},
        samples=2,
        t_end=5.0,
        stable=rigid.tilt_below(0.5),
        rng=1,
    )
    assert len(result.plot().collections) == 1


@pytest.mark.parametrize("what", ["exponent", "mean_megno", "largest_exponent"])
def test_a_map_of_chaos_shows_the_growth_bright_where_it_is_small(what: str) -> None:
    result = rigid.stability_map(
        rigid.HeavyTop(rigid.Body((1.0, 1.6, 0.7)), mgl=1.0),
        axes={"spin": [0.5, 6.0], "tilt": [0.4, 0.8]},
        stable=rigid.regular(),
        t_end=60.0,
        samples=1,
        rng=1,
    )
    mesh = result.plot(what=what).collections[0]
    drawn = np.ma.getdata(mesh.get_array()).reshape(2, 2)
    np.testing.assert_array_equal(drawn, getattr(result, what))
    brightness = mesh.to_rgba(mesh.get_array().ravel())[:, :3].sum(axis=1)
    assert np.argmax(brightness) == np.argmin(drawn)
    with pytest.raises(ValueError, match=r"needs a map with the criterion rigid\.regular"):
        rigid.stability_map(
            rigid.HeavyTop,
            axes={"spin": [1.0]},
            stable=rigid.tilt_below(0.5),
            t_end=1.0,
            samples=1,
        ).plot(what=what)


# Names of lines of theory: beside their line, rotated as it is, and over no other line


DPI = 100
EM = SIZE / 72.0 * DPI
"""Size of the font (pixels)."""


def unit_square(size: tuple[float, float] = (6.4, 5.2)) -> Axes:
    ax = Figure(figsize=size, dpi=DPI).add_subplot()
    ax.set(xlim=(0.0, 1.0), ylim=(0.0, 1.0))
    return ax


def pixels(ax: Axes, points: Any) -> Floats:
    return np.asarray(ax.transData.transform(points))


def line(slope: float, height: float) -> Floats:
    x = np.linspace(0.0, 1.0, 50)
    return np.stack([x, height + slope * x], axis=1)


@pytest.mark.parametrize("size", [(6.4, 5.2), (3.2, 2.6)])
def test_a_name_lies_beside_its_line_and_over_no_other(size: tuple[float, float]) -> None:
    ax = unit_square(size)
    own, other = line(0.8, 0.0), line(0.8, 0.13)
    ends = write_along(ax, "a line", [own], [other])
    assert ends is not None
    (name,) = ax.texts
    first, last = pixels(ax, ends)
    begin, end = pixels(ax, [own[0], own[-1]])
    along = (end - begin) / np.hypot(*(end - begin))
    across = np.array([-along[1], along[0]])
    # Half a line of text from its own line; the name's height is 1.25 font sizes.
    assert abs((first - begin) @ across) == pytest.approx(0.625 * EM, rel=1e-6)
    assert (last - first) @ across == pytest.approx(0.0, abs=1e-6)
    assert name.get_rotation() == pytest.approx(np.degrees(np.arctan2(*along[::-1])), abs=1e-9)
    assert abs((first - pixels(ax, other[0])) @ across) > 0.625 * EM


def test_names_of_crossing_lines_do_not_overlap() -> None:
    ax = unit_square()
    lines = {"rising": line(1.0, 0.0), "falling": line(-1.0, 1.0), "level": line(0.0, 0.5)}
    written: list[Floats] = []
    for name, own in lines.items():
        others = [other for other in lines.values() if other is not own]
        ends = write_along(ax, name, [own], others + written)
        assert ends is not None
        written.append(ends)
    middles = [pixels(ax, np.linspace(ends[0], ends[1], 30)) for ends in written]
    for k, one in enumerate(middles):
        for other in middles[:k]:
            assert np.hypot(*(one[:, np.newaxis] - other).transpose(2, 0, 1)).min() > EM


def test_a_name_without_a_straight_stretch_is_not_written() -> None:
    """The circle has 0.04 x 500 pixels of radius, a name of eight letters needs 50 in a row."""
    ax = unit_square()
    turn = np.linspace(0.0, 2.0 * np.pi, 90)
    circle = 0.5 + 0.04 * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    assert write_along(ax, "aname" * 6, [circle], []) is None
    assert not ax.texts


def test_a_long_name_is_broken_but_no_formula_and_no_time() -> None:
    assert list(_broken("passes $a + b = c$ by t = 40 s")) == [
        "passes $a + b = c$ by t = 40 s",
        "passes $a + b = c$\nby t = 40 s",
        "passes\n$a + b = c$ by\nt = 40 s",
    ]


# Lines where a field is zero, for the lines of theory in pages


def test_a_circle_is_one_closed_line() -> None:
    h = 0.05
    x, y = np.arange(-30, 31) * h, np.arange(-25, 26) * h
    (line,) = zero_lines(x, y, x**2 + y[:, np.newaxis] ** 2 - 1.0)
    assert (line[0] == line[-1]).all()
    # The field has the second derivative 2: it is off a chord by up to h²/4, and its slope is 2.
    assert np.abs(np.hypot(*line.T) - 1.0).max() <= h * h / 8.0
    angles = np.unwrap(np.arctan2(*line.T))
    assert abs(angles[-1] - angles[0]) == pytest.approx(2.0 * np.pi)


@pytest.mark.parametrize("place", [-0.97, 0.33, 0.97])
def test_a_line_ends_at_the_edges_and_where_the_field_is_unknown(place: float) -> None:
    """Also in the first and in the last column of squares."""
    x, y = np.linspace(-1.0, 1.0, 21), np.linspace(0.0, 2.0, 41)
    field = np.tile(x - place, (41, 1))
    field[20] = np.nan
    first, second = sorted(zero_lines(x, y, field), key=lambda line: line[:, 1].min())
    np.testing.assert_allclose(np.concatenate([first, second])[:, 0], place, rtol=1e-15)
    assert {0.0, y[19]} == {*first[[0, -1], 1]}
    assert {y[21], 2.0} == {*second[[0, -1], 1]}


def test_hyperbolas_do_not_meet() -> None:
    x = np.linspace(-2.0, 2.0, 41)
    lines = zero_lines(x, x, x * x[:, np.newaxis] - 0.1)
    assert len(lines) == 2
    # Each branch lies on one side, and x y is linear along every side of the grid.
    assert [len({*np.sign(line[:, 0])}) for line in lines] == [1, 1]
    for line in lines:
        np.testing.assert_allclose(np.prod(line, axis=1), 0.1, rtol=1e-13)


def test_a_line_does_not_go_on_at_the_other_edge() -> None:
    """It falls by a row of squares from the left to the right edge."""
    x, y = np.linspace(-1.0, 1.0, 21), np.linspace(0.0, 2.0, 41)
    (line,) = zero_lines(x, y, y[:, np.newaxis] - 1.05 + 0.025 * x)
    assert sorted(line[[0, -1], 0]) == [-1.0, 1.0]
    np.testing.assert_allclose(line[:, 1], 1.05 - 0.025 * line[:, 0], rtol=1e-14)
