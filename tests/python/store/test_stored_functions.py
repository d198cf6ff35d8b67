"""Running maps of a user's functions: a folder has their digests, workers import them."""

import textwrap
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rigid
from judges import bodies, keeps_its_sign
from rigid.store.rows import Block
from rigid.store.running import Folder
from small_maps import saved_bytes, small_map

JUDGED = rigid.judged(keeps_its_sign, np.linspace(0.0, 20.0, 101), of="rates")
ASKED: dict[str, Any] = {"stable": JUDGED, "t_end": None, "measure": rigid.flips(2), "samples": 12}
OWN: dict[str, Any] = {
    "scene": bodies,
    "axes": {"length": [1.5, 2.0, 2.5], "noise": [1e-3, 0.03, 0.1], "t_end": [10.0, 20.0]},
    "samples": 12,
    "start": rigid.Start(spin=1.0, axis=2, noise=rigid.normal(0.0)),
}


@pytest.fixture(scope="module")
def pool() -> Iterator[ProcessPoolExecutor]:
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as executor:
        yield executor


@pytest.mark.parametrize("asked", [ASKED, OWN], ids=["judged", "own scene"])
def test_every_way_gives_the_same_bytes(
    tmp_path: Path, pool: ProcessPoolExecutor, asked: dict[str, Any]
) -> None:
    quiet = saved_bytes(small_map(**asked), tmp_path)
    with ThreadPoolExecutor(2) as threads:
        for number, executor in enumerate((None, threads, pool)):
            result = small_map(**asked, store=tmp_path / f"{number}", executor=executor)
            assert saved_bytes(result, tmp_path) == quiet
    function = {"stable": keeps_its_sign} if "stable" in asked else {"scene": bodies}
    store = rigid.open_store(tmp_path / "0", **function)
    assert saved_bytes(store.result(), tmp_path) == quiet
    assert store.verify(1.0).ok


def test_a_folder_needs_the_function_again(tmp_path: Path) -> None:
    path = tmp_path / "run"
    small_map(**ASKED, store=path)
    bare = rigid.open_store(path)
    assert bare.result().complete
    assert bare.spec.misses_functions
    with pytest.raises(ValueError, match="stable: a file has no functions; give 'keeps_its_sign'"):
        bare.resume(progress=False)
    assert rigid.open_store(path, stable=keeps_its_sign).resume(progress=False).complete
    with pytest.raises(ValueError, match="stable = bodies: its source differs from"):
        rigid.open_store(path, stable=bodies)

    def keeps_its_sign_otherwise(states: rigid.States) -> Any:
        return np.all(states.omega[..., 1] >= 0.0, axis=1)

    other = rigid.judged(keeps_its_sign_otherwise, JUDGED.times, of="rates")
    with pytest.raises(ValueError, match=r"holds another map .*: stable\.function\.name"):
        small_map(**{**ASKED, "stable": other}, store=path)
    own = tmp_path / "own"
    small_map(**OWN, store=own)
    with pytest.raises(ValueError, match="scene: a file has no functions; give 'bodies' again"):
        rigid.open_store(own).result()


@pytest.mark.parametrize("options", [{"samples": None, "half_width": 0.1}, {"refine": 2}])
def test_pixels_have_the_bits_of_the_full_map(options: dict[str, Any]) -> None:
    """With as many bodies as a pixel needs, and where pixels are omitted."""
    for asked in (ASKED, {**OWN, "axes": {**OWN["axes"]}}):
        if "refine" in options and "scene" in asked:
            asked["axes"] = {"length": [1.5, 2.0, 2.5], "noise": [1e-3, 0.03, 0.1]}
        result = small_map(**{**asked, **options})
        samples = result.spec.samples
        full = small_map(**{**asked, "samples": samples})
        whole = result.samples == samples
        assert whole.any()
        for name in ("stable", "undecided", "earliest", "steps"):
            np.testing.assert_array_equal(getattr(result, name)[whole], getattr(full, name)[whole])


def test_a_function_that_no_worker_can_import_is_refused(
    tmp_path: Path, pool: ProcessPoolExecutor
) -> None:
    def here(states: rigid.States) -> Any:
        return states.omega[:, 0, 0] > 0.0

    local = {**ASKED, "stable": rigid.judged(here, [1.0], of="rates"), "t_end": None}
    with pytest.raises(ValueError, match=r"stable = .*here: workers import the function by its"):
        small_map(**local, executor=pool)
    assert small_map(**local, store=tmp_path / "run").complete


def test_a_worker_with_another_source_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The module changes after the driver has imported it."""
    source = """
        def judge(states):
            return (states.omega[..., 1] > {limit}).all(axis=1)
    """
    path = tmp_path / "changing_judge.py"
    path.write_text(textwrap.dedent(source.format(limit=0.0)))
    monkeypatch.syspath_prepend(tmp_path)
    from changing_judge import judge  # type: ignore[import-not-found]

    stable = rigid.judged(judge, [0.0, 5.0], of="rates")
    path.write_text(textwrap.dedent(source.format(limit=0.5)))
    with (
        ProcessPoolExecutor(1, mp_context=get_context("spawn")) as fresh,
        pytest.raises(ValueError, match="a worker: stable = judge: its source differs from"),
    ):
        small_map(**{**ASKED, "stable": stable}, executor=fresh)
    path.unlink()
    with (
        ProcessPoolExecutor(1, mp_context=get_context("spawn")) as fresh,
        pytest.raises(ValueError, match="a worker cannot import a function of the map: No module"),
    ):
        small_map(**{**ASKED, "stable": stable}, executor=fresh)


# Running maps with measures: their logs hold bins, and every way of computing gives the same.


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
