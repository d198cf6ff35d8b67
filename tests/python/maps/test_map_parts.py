"""A body has the same bits in the whole map, in a part of its grid and in a batch of samples."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import rigid
from rigid import _core
from rigid.maps.data import COLUMNS
from rigid.maps.grid import nominal_starts
from rigid.maps.job import to_core
from small_maps import spec_of

TOP = rigid.HeavyTop(rigid.Body((1.0, 1.2, 0.5)), mgl=1.0)

#: Closed forms, audits of groups, checks of some bodies, driven bodies, and deviation vectors.
SPECS: dict[str, dict[str, Any]] = {
    "flips": {},
    "closed forms": {"method": "auto"},
    "tilts with audits": {
        "scene": TOP,
        "axes": {"spin": np.linspace(1.0, 4.0, 7), "attitude_noise": [0.01, 0.1]},
        "stable": rigid.tilt_below(0.5),
        "method": "auto",
    },
    "some checked": {"check": 0.7},
    "damped, with impossible bodies": {
        "axes": {"damping1": [0.0, 0.01, 0.1], "I2/I1": [0.1, 1.2, 1.8, 3.5]},
        "method": "auto",
    },
    "regular motions": {
        "scene": TOP,
        "axes": {"spin": np.linspace(1.0, 4.0, 4), "tilt": [0.3, 1.0]},
        "start": rigid.Start(spin=3.0, attitude_noise=rigid.normal(0.01)),
        "stable": rigid.regular(),
        "method": "auto",
    },
}

BATCHES = range(64), range(64, 96)


@pytest.fixture(params=SPECS, scope="module")
def spec(request: pytest.FixtureRequest) -> rigid.MapSpec:
    return spec_of(**{"samples": 96, "t_end": 5.0, **SPECS[request.param]})


def columns(
    spec: rigid.MapSpec, pixels: NDArray[np.int64] | None = None, samples: range | None = None
) -> dict[str, NDArray[Any]]:
    """The reproducible columns of these samples of these pixels."""
    span = samples or range(spec.samples)
    job = to_core(spec, pixels, len(span), span.start)
    part: Any = job.run(0, len(job.status) * len(span), 2)
    return {one.name: part[one.name] for one in COLUMNS if one.reproducible}


@pytest.fixture(scope="module")
def full(spec: rigid.MapSpec) -> dict[str, NDArray[Any]]:
    return columns(spec)


def test_the_nominal_starts_of_some_pixels_are_rows_of_those_of_all(spec: rigid.MapSpec) -> None:
    pixels = np.array([5, 0, 3, 3])
    some = nominal_starts(spec.scene, spec.start.starts[0], spec.axes, pixels)
    for name in ("moments", "weight", "omega", "omega_size", "attitude", "tilt", "attitude_size"):
        np.testing.assert_array_equal(getattr(some, name), getattr(spec.grid, name)[pixels])
    if some.damping is not None:
        assert spec.grid.damping is not None
        np.testing.assert_array_equal(some.damping, spec.grid.damping[pixels])


def test_a_list_of_pixels_has_the_bits_of_the_whole_map(
    spec: rigid.MapSpec, full: dict[str, NDArray[Any]]
) -> None:
    pixels = np.array([6, 1, 2, 7, 0])
    for name, values in columns(spec, pixels).items():
        np.testing.assert_array_equal(values, full[name][pixels], err_msg=name)


def test_two_batches_merge_to_the_whole_map(
    spec: rigid.MapSpec, full: dict[str, NDArray[Any]]
) -> None:
    pixels = np.arange(len(full["stable"]))[::-1].copy()
    merged = _core.MapStatistics(len(pixels))
    for batch in reversed(BATCHES):
        nothing = {"nanoseconds": np.zeros(len(pixels)), "pixels": np.arange(len(pixels))}
        merged.merge({**columns(spec, pixels, batch), **nothing})
    arrays = merged.arrays()
    for name, values in full.items():
        np.testing.assert_array_equal(arrays[name], values[pixels], err_msg=name)


def test_rows_of_any_pixels_and_first_samples_are_one_request(
    spec: rigid.MapSpec, full: dict[str, NDArray[Any]]
) -> None:
    pixels, first = np.array([6, 1, 6, 1, 3]), np.array([0, 32, 64, 0, 64]) // 64 * 64
    job = to_core(spec, pixels, 32, first)
    found: Any = job.run(0, 5 * 32, 2)
    for row, (pixel, begin) in enumerate(zip(pixels, first, strict=True)):
        alone = columns(spec, np.array([pixel]), range(begin, begin + 32))
        for name, values in alone.items():
            np.testing.assert_array_equal(found[name][row], values[0], err_msg=name)


def test_another_pixel_and_another_batch_draw_other_bodies(spec: rigid.MapSpec) -> None:
    # So the equalities above are not those of bodies that are all drawn alike.
    def drawn(pixel: int, sample: int) -> list[float]:
        job = to_core(spec, np.array([pixel]), 96 - sample, sample)
        omega, attitude = job.starts(np.zeros(1, np.uint64))
        return [*omega, *attitude]

    assert drawn(5, 0) != drawn(6, 0)
    assert drawn(5, 0) != drawn(5, 64)
