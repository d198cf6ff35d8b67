"""Running maps with measures: their logs hold bins, and every way of computing gives the same."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rigid
from rigid.store.rows import Block
from rigid.store.running import Folder
from small_maps import saved_bytes, small_map

MEASURED: dict[str, Any] = {
    "measure": (rigid.time_to_leave(), rigid.flips(1), rigid.mean_rate(-2), rigid.drift()),
}


def measured(**options: Any) -> rigid.StabilityMap:
    return small_map(**{**MEASURED, **options})


@pytest.fixture(scope="module")
def quiet() -> rigid.StabilityMap:
    """The map computed at once, without a store."""
    return measured()


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Folder:
    """The same map, stored."""
    path = tmp_path_factory.mktemp("map") / "run"
    measured(store=path)
    return Folder(path)


def test_sittings_parts_and_merges_have_the_same_bytes(
    tmp_path: Path, quiet: rigid.StabilityMap
) -> None:
    for number in (1, 2, 3):
        measured(store=tmp_path / f"{number}", part=(number, 3))
    merged = rigid.merge([tmp_path / f"{n}" for n in (3, 1, 2, 1)], tmp_path / "all")
    assert saved_bytes(merged.result(), tmp_path) == saved_bytes(quiet, tmp_path)
    store = rigid.open_store(tmp_path / "1")
    assert not store.result().complete
    assert saved_bytes(store.resume(progress=False), tmp_path) == saved_bytes(quiet, tmp_path)


def test_segments_of_a_pixel_are_merged(
    tmp_path: Path, quiet: rigid.StabilityMap, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: dict[str, Any] = {"samples": 150, "axes": {"I2/I1": [1.2, 1.5, 1.8]}}
    expected = measured(**asked)
    monkeypatch.setattr("rigid.store.head.SEGMENT", 64)
    result = measured(store=tmp_path / "run", **asked)
    assert Folder(tmp_path / "run").head.segments == 3
    assert saved_bytes(result, tmp_path) == saved_bytes(expected, tmp_path)


def test_as_many_bodies_as_a_pixel_needs(tmp_path: Path) -> None:
    """The values are those of the bodies that the pixel got, whatever the looks."""
    asked: dict[str, Any] = {
        "samples": None,
        "half_width": 0.1,
        "axes": {"noise": [1e-3, 3e-3, 0.1]},
    }
    result = measured(**asked)
    assert saved_bytes(measured(store=tmp_path / "run", **asked), tmp_path) == saved_bytes(
        result, tmp_path
    )
    assert len(set(result.samples)) > 1
    np.testing.assert_array_equal(result.measures["flips"].count, result.samples)
    for pixel, samples in enumerate(result.samples):
        alone = measured(**{**asked, "half_width": None, "samples": int(samples)})
        for name, one in result.measures.items():
            same = alone.measures[name]
            for number in ("count", "mean", "std", "least", "largest"):
                np.testing.assert_array_equal(
                    getattr(one, number)[pixel], getattr(same, number)[pixel]
                )
    assert result.replay(1, 3, t=[0.0]).measures["flips(1)"] >= 0


def test_pixels_that_are_left_out_have_no_values() -> None:
    full = measured(samples=30)
    result = measured(samples=30, refine=2, budget=500)
    left_out = result.samples == 0
    assert left_out.any()
    for name, one in result.measures.items():
        assert np.isnan(one.mean[left_out]).all()
        assert np.isnan(one.quantile(0.5)[left_out]).all()
        assert not one.count[left_out].any()
        np.testing.assert_array_equal(one.mean[~left_out], full.measures[name].mean[~left_out])
    result.plot(what="mean of flips")


def altered(run: Folder, path: Path, count: int) -> Folder:
    """A running map of some rows, of which the first has one other bin, under valid digests."""
    block = run.table.block(np.flatnonzero(run.table.known)[:count])
    block.bins[0, 3] += 1
    folder = Folder.at(path, run.head.spec)
    folder.begin()
    folder.append(block)
    folder.end("interrupted")
    return folder


def test_another_value_is_refused_and_found(
    run: Folder, tmp_path: Path, quiet: rigid.StabilityMap
) -> None:
    folder = altered(run, tmp_path / "run", 5)
    with pytest.raises(ValueError, match=r"computed: unit 0 has two results: values of \w+"):
        measured(store=folder.path)
    found = rigid.open_store(folder.path).verify(1.0)
    assert len(found.wrong) == 1
    assert found.wrong[0].startswith("pixel 0: values of ")
    with pytest.raises(ValueError, match="unit 0 has two results: values of"):
        rigid.merge([run.path, folder.path], tmp_path / "all")
    numbers = rigid.diff(folder.path, run.path).numbers
    assert any(text.startswith("values of ") for text in numbers)
    saved = quiet.save(tmp_path / "map.npz")
    assert not rigid.diff(saved, folder.path).same
    assert isinstance(run.table.block(np.array([3, 1])), Block)
