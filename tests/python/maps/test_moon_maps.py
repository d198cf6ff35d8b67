"""Maps of moons on eccentric orbits, and the lines where their rotation is in resonance."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import rigid
from rigid.cli.toml_map import read_spec
from rigid.maps.axes import make_axes
from rigid.maps.moons import averaged_torque
from rigid.maps.spec import MapSpec
from rigid.maps.theory import predict
from rigid.store.call import run_map


def some_of(name: str, axes: dict[str, Any], samples: int) -> MapSpec:
    """A built-in map with other values of its axes."""
    return replace(read_spec(name).spec, axes=make_axes(axes), samples=samples)


COARSE: dict[str, dict[str, Any]] = {
    "dimorphos": {"a/b": [1.0, 1.15, 1.3, 1.45], "b/c": [1.05, 1.2, 1.35, 1.5]},
    "hyperion": {"spin": [0.5, 2.0, 3.5, 5.0], "tilt": [0.0, 1.0, 2.0, 3.0]},
    "spin-orbit": {"spin": [0.75, 1.0, 1.25, 1.5], "eccentricity": [0.0, 0.1, 0.4]},
}
LINES = {
    "dimorphos": [
        "libration at n/2",
        "libration at n",
        "slow mode of roll and yaw at n/2",
        "fast mode of roll and yaw at 3n/2",
    ],
    "hyperion": [],
    "spin-orbit": ["edges of 1:1", "edges of 3:2", "edges of 2:1"],
}


@pytest.mark.parametrize("name", COARSE)
def test_built_in_maps_of_moons_have_both_kinds_of_motion_and_their_lines(name: str) -> None:
    assert read_spec(name).spec.title
    result = run_map(some_of(name, COARSE[name], 1), progress=False)
    assert not result.failed.any()
    assert result.stable.sum() > 2
    assert result.unstable.sum() > 2
    whole = predict(read_spec(name).spec)
    assert ([] if whole is None else [curve.label for curve in whole.curves]) == LINES[name]
    if whole is not None:
        assert np.isnan(whole.share).all()
    assert ("lines, no shares" in result.summary()) == (result.theory() is not None)


def test_lines_of_a_moon_are_where_its_small_oscillations_have_half_the_rate_of_the_orbit() -> None:
    """By the eigenvalues of the linear equations of roll and yaw; the libration in closed form."""
    theory: Any = predict(read_spec("dimorphos").spec)
    ab, bc = (np.array(axis.values) for axis in read_spec("dimorphos").spec.axes)
    libration, whole, slow, fast = (curve.field for curve in theory.curves)
    # 3 (a² - b²)/(a² + b²) is 1/4 and 1.
    assert np.interp(0.0, libration[20], ab) == pytest.approx(np.sqrt(13.0 / 11.0), abs=1e-4)
    assert np.interp(0.0, whole[20], ab) == pytest.approx(np.sqrt(2.0), abs=1e-4)
    for row, column in ((10, 10), (25, 40), (50, 5)):
        a, b = ab[column] * bc[row], bc[row]
        along, across, normal = b * b + 1.0, a * a + 1.0, a * a + b * b
        # About rest on a circle: axes 1, 2, 3 away from the planet, along the motion, along the
        # normal; x and y are small turns about the first two.
        k1, k2 = (normal - along) / across, (normal - across) / along
        matrix = [
            [0.0, 0.0, 1.0, 0.0],
            [0.0, 0.0, 0.0, 1.0],
            [-k2, 0.0, 0.0, 1.0 - k2],
            [0.0, -4.0 * k1, k1 - 1.0, 0.0],
        ]
        rates = np.sort(np.abs(np.linalg.eigvals(np.array(matrix)).imag))[[0, 2]]
        assert slow[row, column] == pytest.approx(rates[0] - 0.5, abs=1e-12)
        assert fast[row, column] == pytest.approx(rates[1] - 1.5, abs=1e-12)


def test_a_moon_whose_libration_is_in_resonance_turns_over_and_its_neighbours_stay() -> None:
    on_the_line = float(np.sqrt(13.0 / 11.0))
    axes = {"a/b": [1.05, on_the_line, 1.13], "b/c": [1.15]}
    result = run_map(some_of("dimorphos", axes, 8), progress=False)
    assert result.share[0, 0] == result.share[0, 2] == 1.0
    assert result.share[0, 1] < 0.5


@pytest.mark.parametrize(
    ("p", "terms"),
    [
        (1.0, {0: 1.0, 2: -5.0 / 2.0, 4: 13.0 / 16.0, 6: -35.0 / 288.0}),
        (1.5, {1: 7.0 / 2.0, 3: -123.0 / 16.0, 5: 489.0 / 128.0}),
        (2.0, {2: 17.0 / 2.0, 4: -115.0 / 6.0, 6: 601.0 / 48.0}),
    ],
)
def test_the_averaged_torque_is_the_series_of_cayley(p: float, terms: dict[int, float]) -> None:
    e = np.array([0.0, 0.01, 0.05])
    series = sum(factor * e**power for power, factor in terms.items())
    # The next terms are e⁷ and e⁸ with factors of the order of 1.
    np.testing.assert_allclose(averaged_torque(p, e), series, rtol=0.0, atol=5.0 * 0.05**7)


def test_the_averaged_torque_does_not_depend_on_the_points_of_its_mean(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    e = np.array([0.3, 0.8, 0.95])
    found = averaged_torque(1.5, e)
    monkeypatch.setattr("rigid.maps.moons.PLACES", 1024)
    # Terms of the mean are up to 400: 400 times the rounding of a double.
    np.testing.assert_allclose(averaged_torque(1.5, e), found, rtol=0.0, atol=1e-13 * 400.0)


@pytest.mark.parametrize(("name", "p"), [("1:1", 1.0), ("3:2", 1.5), ("2:1", 2.0)])
def test_a_spin_between_the_edges_of_a_resonance_librates_and_one_outside_does_not(
    name: str, p: float
) -> None:
    """A nearly round moon, whose resonances are far apart: its mean spin is a multiple, or not."""
    moments, e = (0.9997, 1.0, 1.0003), 0.2
    strength = 3.0 * (moments[1] - moments[0]) / moments[2]
    half = float(np.sqrt(strength * averaged_torque(p, np.array([e]))[0]))
    t_end = 20.0 * 2.0 * np.pi / half
    # The swing with the orbit moves the edges by some percent of their distance.
    spins = p + half * np.array([-1.2, -0.8, 0.8, 1.2])
    result = rigid.stability_map(
        rigid.FreeBody(rigid.Body(moments), orbit=rigid.Orbit(1.0)),
        axes={"spin": spins, "eccentricity": [0.5 * e, e]},
        start=rigid.Start(spin=1.0),
        stable=rigid.librates(),
        measure=rigid.spin_orbit_ratio(3),
        samples=1,
        t_end=t_end,
        check=0.0,
        rng=1,
    )
    off = np.abs(result.measures["spin_orbit_ratio(3)"].mean[1] - p)
    # Within an oscillation of pi to either side of the middle.
    assert (off[[1, 2]] < np.pi / t_end).all()
    # A pendulum that turns over at 1.2 of the edge does so at 0.7 of it on average.
    assert (off[[0, 3]] > 0.5 * half).all()
    theory: Any = result.theory()
    (edges,) = (curve.field for curve in theory.curves if curve.label == f"edges of {name}")
    expected = half**2 * (1.0 - np.array([1.44, 0.64, 0.64, 1.44]))
    np.testing.assert_allclose(edges[1], expected, rtol=1e-9)


def lines_of(**changes: Any) -> list[str]:
    """The lines of a map of moons with such a change."""
    orbit = rigid.Orbit(1.0, changes.pop("eccentricity", 0.05), changes.pop("anomaly", 0.0))
    start = rigid.Start(omega=(0.0, 0.0, 1.0), **changes.pop("start", {}))
    scene = rigid.FreeBody(rigid.Body((0.6, 0.8, 1.0)), orbit=orbit, **changes.pop("forces", {}))
    axes = changes.pop("axes", {"a/b": [1.05, 1.2, 1.45], "b/c": [1.1, 1.45]})
    spec = replace(
        read_spec("dimorphos").spec,
        scene=scene,
        axes=make_axes(axes),
        start=start,
        **changes,
    )
    theory = predict(spec)
    return [] if theory is None else [curve.label for curve in theory.curves]


def test_lines_are_those_of_a_moon_that_faces_its_planet_on_an_ellipse() -> None:
    assert len(lines_of()) == 4
    assert len(lines_of(anomaly=np.pi, start={"noise": rigid.normal(0.01)})) == 4
    assert lines_of(eccentricity=0.0) == []
    assert lines_of(anomaly=0.5) == []
    assert lines_of(start={"attitude": (0.5, 0.5, 0.5, 0.5)}) == []
    assert lines_of(start={"attitude_noise": rigid.uniform_attitude()}) == []
    assert lines_of(forces={"rotor": (0.0, 0.0, 0.1)}) == []
    assert lines_of(axes={"a/b": [1.05, 1.45], "anomaly": [0.0, 1.0]}) == []
    edges = {"omega3": [0.5, 1.0, 1.5, 2.0, 2.5], "eccentricity": [0.1, 0.2]}
    assert lines_of(axes=edges) == ["edges of 1:1", "edges of 3:2", "edges of 2:1"]
    assert lines_of(axes=edges, anomaly=np.pi) == []


def test_a_picture_has_all_lines_and_a_title_that_fits() -> None:
    result = run_map(some_of("dimorphos", COARSE["dimorphos"], 1), progress=False)
    ax: Any = result.plot()
    legend = ax.get_legend()
    assert [text.get_text().replace("\n", " ") for text in ax.texts] == LINES["dimorphos"]
    assert not any("theory" in text.get_text() for text in legend.get_texts())
    ax.figure.canvas.draw()
    assert ax._left_title.get_window_extent().x1 < ax.figure.bbox.x1
    words = ax.get_title(loc="left")
    assert words.endswith("until t = 70 d\n1 body per pixel")
