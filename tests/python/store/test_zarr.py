"""The Zarr product: what xarray reads is the map, and damage is refused."""

from pathlib import Path

import numpy as np
import pytest

import rigid
from small_maps import small_map

xarray = pytest.importorskip("xarray")
pytest.importorskip("zarr")

FLIPS = 25


@pytest.fixture(scope="module")
def result() -> rigid.StabilityMap:
    return small_map(samples=4)


def contents(folder: Path) -> dict[str, bytes]:
    files = (path for path in folder.rglob("*") if path.is_file())
    return {str(path.relative_to(folder)): path.read_bytes() for path in files}


def test_xarray_reads_the_map(result: rigid.StabilityMap, tmp_path: Path) -> None:
    path = result.save(tmp_path / "map.zarr")
    expected = result.to_xarray().drop_vars("nanoseconds")
    with xarray.open_zarr(path, consolidated=False) as found:
        assert found.load().identical(expected)
    assert [one.name for one in tmp_path.iterdir()] == ["map.zarr"]


def test_equal_maps_are_equal_bytes(result: rigid.StabilityMap, tmp_path: Path) -> None:
    one, other = result.save(tmp_path / "a.zarr"), small_map(samples=4).save(tmp_path / "b.zarr")
    assert contents(one) == contents(other)


def test_flipped_bits_in_the_numbers_are_refused(
    result: rigid.StabilityMap, tmp_path: Path
) -> None:
    path, random = result.save(tmp_path / "map.zarr"), np.random.default_rng(1)
    chunks = sorted(one for one in path.rglob("c/*") if one.is_file()) + sorted(path.rglob("c/0/0"))
    assert len(chunks) > 20
    for chunk in random.choice(np.array(chunks), FLIPS):
        content = bytearray(chunk.read_bytes())
        content[random.integers(len(content))] ^= 1 << int(random.integers(8))
        whole = chunk.read_bytes()
        chunk.write_bytes(content)
        with pytest.raises(ValueError), xarray.open_zarr(path, consolidated=False) as found:
            found.load()
        chunk.write_bytes(whole)


def test_a_name_that_is_taken_is_refused(result: rigid.StabilityMap, tmp_path: Path) -> None:
    path = result.save(tmp_path / "map.zarr")
    before = contents(path)
    with pytest.raises(FileExistsError, match="must be new"):
        result.save(path)
    assert contents(path) == before


def test_stores_are_packed_for_urls(tmp_path: Path) -> None:
    result = small_map(samples=4, store=tmp_path / "run")
    store = rigid.open_store(tmp_path / "run")
    assert store.pack(tmp_path / "map.npz") == tmp_path / "map.npz"
    url = "memory://map.zarr"  # as that of a bucket
    assert store.pack(url) == url
    with xarray.open_zarr(url, consolidated=False) as found:
        np.testing.assert_array_equal(found["stable"], result.stable)
