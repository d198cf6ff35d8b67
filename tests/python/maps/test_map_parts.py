"""A body has the same bits in the whole map, in a part of its grid and in a batch of samples."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import rigid
from map_kinds import KINDS
from rigid import _core
from rigid.maps.data import COLUMNS
from rigid.maps.grid import nominal_starts
from rigid.maps.job import to_core
from small_maps import spec_of

#: Closed forms, audits of groups, checks of some bodies, driven bodies, and deviation vectors.
NAMES = (
    "free, impossible bodies",
    "closed forms",
    "free, tilt, splitting",
    "top, tilt from the vertical",
    "driven and damped",
    "satellites",
    "regular",
)
BATCHES = range(64), range(64, 96)


@pytest.fixture(params=NAMES, scope="module")
def spec(request: pytest.FixtureRequest) -> rigid.MapSpec:
    return spec_of(**{"t_end": 5.0, **KINDS[request.param][0], "samples": 96})


def some_of(spec: rigid.MapSpec, *pixels: int) -> NDArray[np.int64]:
    """Pixels of the grid, counted anew after its last."""
    return np.array(pixels) % np.prod(spec.shape)


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
    pixels = some_of(spec, 5, 0, 3, 3)
    some = nominal_starts(spec.scene, spec.start.starts[0], spec.axes, pixels)
    for name in ("moments", "weight", "omega", "omega_size", "attitude", "tilt", "attitude_size"):
        np.testing.assert_array_equal(getattr(some, name), getattr(spec.grid, name)[pixels])
    if some.damping is not None:
        assert spec.grid.damping is not None
        np.testing.assert_array_equal(some.damping, spec.grid.damping[pixels])


def test_a_list_of_pixels_has_the_bits_of_the_whole_map(
    spec: rigid.MapSpec, full: dict[str, NDArray[Any]]
) -> None:
    pixels = some_of(spec, 6, 1, 2, 7, 0)
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
    pixels, first = some_of(spec, 6, 1, 6, 1, 3), np.array([0, 0, 64, 0, 64])
    job = to_core(spec, pixels, 32, first)
    found: Any = job.run(0, 5 * 32, 2)
    for row, (pixel, begin) in enumerate(zip(pixels, first, strict=True)):
        alone = columns(spec, np.array([pixel]), range(begin, begin + 32))
        for name, values in alone.items():
            np.testing.assert_array_equal(found[name][row], values[0], err_msg=name)


def test_another_pixel_and_another_batch_draw_other_bodies(spec: rigid.MapSpec) -> None:
    # So the equalities above are not those of bodies that are all drawn alike.
    def drawn(pixel: int, sample: int) -> list[float]:
        job = to_core(spec, some_of(spec, pixel), 96 - sample, sample)
        omega, attitude = job.starts(np.zeros(1, np.uint64))
        return [*omega, *attitude]

    assert drawn(5, 0) != drawn(6, 0)
    assert drawn(5, 0) != drawn(5, 64)
