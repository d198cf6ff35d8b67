"""Parts of a map: each has its share of the work, and together they are the map."""

import itertools
import math
import os
import tarfile
import time
from calendar import timegm
from io import BytesIO
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import rigid
from rigid.store.head import Head, divided, moment_status
from rigid.store.log import UTC
from rigid.store.resume import GOLDEN, Part, missing
from rigid.store.rows import Block
from rigid.store.running import Folder, Memory
from rigid.store.status import foresee
from small_maps import assert_same_map, saved_bytes, small_map, spec_of
from stores import SPEC, go_on, stops_after, stored_map

#: Three units for each of eight pixels.
FEW: dict[str, Any] = {
    "axes": {"noise": np.geomspace(1e-3, 0.1, 8)},
    "method": "auto",
    "samples": 3000,
}


def spec_of_grid(columns: int, rows: int, samples: int) -> rigid.MapSpec:
    axes = {"I2/I1": np.linspace(1.01, 1.99, columns), "noise": np.geomspace(1e-3, 0.1, rows)}
    return spec_of(axes=axes, method="auto", samples=samples)


def shares(spec: rigid.MapSpec, count: int) -> list[np.ndarray[Any, Any]]:
    """The units of each part of a map of which nothing is computed."""
    running = Memory(spec, divided(spec))  # as that of a folder
    todo = missing(running)
    return [todo[Part(k + 1, count).has(todo, running)] for k in range(count)]


def bodies(spec: rigid.MapSpec, units: np.ndarray[Any, Any]) -> int:
    """How many bodies units have."""
    head = Head.of(spec)
    first = units % head.segments * head.segment
    return int(np.minimum(head.segment, spec.samples - first).sum())


@pytest.mark.parametrize(
    ("spec", "count"),
    [
        (spec_of_grid(24, 16, 10), 16),
        (spec_of_grid(24, 16, 10), 24),
        (spec_of_grid(24, 16, 10), 7),
        (spec_of_grid(8, 1, 20_000), 4),
        (spec_of_grid(8, 1, 20_000), 16),
        (SPEC, 20),  # as many parts as columns, some of which have no possible body
        (SPEC, 144),  # as many as possible bodies
    ],
    ids=["rows", "columns", "odd", "few", "fewer", "impossible", "single"],
)
def test_every_part_has_its_share(spec: rigid.MapSpec, count: int) -> None:
    """No two differ by more than a unit, and they have each unit once."""
    parts = shares(spec, count)
    sizes = [len(part) for part in parts]
    assert min(sizes) > 0
    assert max(sizes) - min(sizes) <= 1
    every = np.concatenate(parts)
    possible = Memory(spec).status == 0
    assert len(np.unique(every)) == len(every) == possible.sum() * Head.of(spec).segments
    assert sum(bodies(spec, part) for part in parts) == possible.sum() * spec.samples


def test_rows_in_memory_grow_with_the_pixels_alone() -> None:
    for columns, rows, samples in ((1, 1, 10**9), (1, 1, 10**18), (30, 20, 10**6), (200, 100, 999)):
        units = Memory(spec_of_grid(columns, rows, samples)).head.units
        assert units <= max(columns * rows, 2**14 + columns * rows)
    assert Memory(spec_of_grid(8, 1, 200)).head.segment == 64


def test_moments_of_many_pixels_are_told_in_parts(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("rigid.store.head.PIXELS_TOGETHER", 7)
    assert set(SPEC.grid.status) == {0, 3}
    np.testing.assert_array_equal(moment_status(SPEC), SPEC.grid.status)


def test_few_pixels_are_divided_evenly() -> None:
    """8 pixels with 20 000 bodies each, in 4 parts of 40 units."""
    spec = spec_of_grid(8, 1, 20_000)
    work = [bodies(spec, part) for part in shares(spec, 4)]
    # The last unit of a pixel has 544 bodies: at worst one part has all eight of these.
    assert max(work) - min(work) <= 8 * (1024 - 544)
    assert len(set(map(len, shares(spec, 4)))) == 1


def test_no_part_is_a_column() -> None:
    """What a body costs varies along axes: a part of one column would cost more than the others.

    Their turns are shifted by multiples of the golden ratio, here in whole numbers.
    """
    assert int(GOLDEN) == (math.isqrt(5 * 2**128) - 2**64) // 2
    for part in shares(spec_of_grid(24, 16, 10), 24):
        assert len(np.unique(part % 24)) >= 8


def test_pixels_are_divided_only_where_they_are_few() -> None:
    """Other maps have the keys that they had, and the logs of earlier versions."""
    for spec in (spec_of_grid(32, 32, 10**6), spec_of_grid(8, 1, 1000), SPEC):
        head = Head.of(spec)
        assert (head.segments, head.seal) == (1, head.key)
    assert (
        Head.of(
            small_map(samples=None, half_width=0.01, axes={"spin": [1.0]}, t_end=1e-6).spec
        ).segments
        == 1
    )
    divided = Head.of(spec_of_grid(8, 1, 20_000))
    assert (divided.segments, divided.segment) == (20, 1024)
    assert divided.seal != divided.key
    huge = Head.of(spec_of_grid(1, 1, 10**9))
    assert huge.segment % 64 == 0
    assert 1000 < huge.segments <= 1024


@pytest.mark.parametrize("count", [1, 5])
def test_divided_pixels_have_the_bits_of_whole_ones(tmp_path: Path, count: int) -> None:
    whole = small_map(**FEW)
    for k in range(1, count + 1):
        small_map(**FEW, store=tmp_path / f"{k}", part=(k, count))
        assert rigid.open_store(tmp_path / f"{k}").status().done in (24 // count, 24 // count + 1)
    store = rigid.merge([tmp_path / f"{k}" for k in range(count, 0, -1)], tmp_path / "all")
    assert_same_map(store.result(), whole)
    assert saved_bytes(store.result(), tmp_path) == saved_bytes(whole, tmp_path)
    receipt = whole.receipt()
    assert store.result().receipt()["fingerprint"] == receipt["fingerprint"]
    assert store.key == store.status().key == receipt["key"]
    assert store.verify(1.0).ok
    file = whole.save(tmp_path / "map.npz")
    from rigid.store.compare import verify

    assert verify(file, share=1.0).ok


def test_part_of_a_pixel_are_its_first_bodies(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """So they are replayed, and counted with the interval of so many bodies."""
    spec = spec_of(**FEW)
    whole = small_map(**FEW)
    monkeypatch.setattr("rigid.store.drive.GROWTH", 1)
    go_on(tmp_path / "run", spec=spec, part=Part(2, 3))
    monkeypatch.undo()
    partial = stored_map(tmp_path / "run")
    folder = Folder(tmp_path / "run")
    known = folder.table.known.reshape(8, 3)
    begun = np.where(known.all(axis=1), 3, np.argmin(known, axis=1))
    np.testing.assert_array_equal(partial.samples, np.minimum(1024 * begun, 3000))
    assert set(begun) == {0, 1}  # every third unit of each pixel
    assert not partial.complete
    first = small_map(**{**FEW, "samples": 1024})
    np.testing.assert_array_equal(partial.stable[begun == 1], first.stable[begun == 1])
    pixel = int(np.argmax(begun))
    for sample in (0, 1023, 1024, 2999):
        assert partial.replay(pixel, sample).outcome == whole.replay(pixel, sample).outcome
    go_on(tmp_path / "run", spec=spec)
    assert_same_map(stored_map(tmp_path / "run"), whole)


def test_measures_of_part_of_a_pixel_are_those_of_its_first_bodies(tmp_path: Path) -> None:
    asked = {**FEW, "measure": rigid.flips(2)}
    small_map(**asked, store=tmp_path / "run", part="2/3")
    partial = stored_map(tmp_path / "run")
    path = partial.save(tmp_path / "map.npz")
    assert rigid.load_map(path).receipt()["fingerprint"] == partial.receipt()["fingerprint"]
    count = partial.measures["flips(2)"].count
    np.testing.assert_array_equal(count, partial.samples)
    assert 0 < (count == 1024).sum() < 8


def test_an_interruption_inside_of_pixels_counts_whole_ones(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("rigid.store.drive.GROWTH", 1)
    go_on(tmp_path / "run", spec=spec_of(**FEW), stop=stops_after(8))
    from rigid.store.resume import pixels_done

    units = int(Folder(tmp_path / "run").table.known.sum())
    assert units % 3
    words = f"{units // 3} of 8 pixels ({units} of 24 pieces) are stored"
    assert pixels_done(Folder(tmp_path / "run")) == words


def test_a_cost_is_foreseen_from_whole_looks_and_a_size_is_that_of_the_tables(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[tuple[int, int, int]] = []

    def made(spec: Any, pixels: Any, samples: int, *_: Any) -> Any:
        def run(begin: int, end: int, _threads: int) -> None:
            asked.append((begin, end, len(pixels) * samples))

        return SimpleNamespace(run=run)

    monkeypatch.setattr("rigid.store.status.to_core", made)
    monkeypatch.setattr("rigid._timing.REPEATED", 0.0)
    foreseen = foresee(SPEC, store=None, seeded=True, threads=1, part=None)
    assert len(asked) > 1
    assert all((begin, end) == (0, bodies) for begin, end, bodies in asked)
    go_on(tmp_path / "run")
    (log,) = (tmp_path / "run" / "logs").iterdir()
    with tarfile.open(log) as archive:
        members: list[Any] = [archive.extractfile(one) for one in archive if ".npy" in one.name]
        tables = [np.load(BytesIO(member.read())) for member in members]
    assert foreseen.stored == sum(table.nbytes for table in tables)


def test_the_status_never_tells_a_time_that_is_not_known(tmp_path: Path) -> None:
    folder = Folder.at(tmp_path / "run", SPEC)
    words = str(rigid.open_store(tmp_path / "run").status())
    assert "cost        0 s of processor time, how much is left is not known yet" in words
    go_on(tmp_path / "quiet")
    rows = Folder(tmp_path / "quiet").table.rows
    some = np.flatnonzero(rows["unit"])[:5]
    folder.begin(part="1/2")
    folder.append(Block(rows[some], np.full(5, np.nan, np.float32)))
    words = str(rigid.open_store(tmp_path / "run").status())
    folder.end("interrupted")
    assert "cost        0 s of processor time, how much is left is not known yet" in words
    assert "nan" not in words
    assert "5 of 144 are stored, 139 are missing" in words


def test_the_time_left_is_that_of_the_rows_that_are_missing(tmp_path: Path) -> None:
    """36 of 144 rows took 2 s each; their process wrote for 36 s and has half of the others."""
    go_on(tmp_path / "quiet")
    table = Folder(tmp_path / "quiet").table
    folder = Folder.at(tmp_path / "run", SPEC)
    folder.begin()
    folder.append(Block(table.rows[table.known][:36], np.full(36, 2e9, np.float32)))
    folder.read()
    (log,) = folder.logs
    assert log.writer is not None
    begun = timegm(time.strptime(log.writer["begin"], UTC))
    os.utime(tmp_path / "run" / "logs" / log.name, (begun + 36.0, begun + 36.0))
    status = rigid.open_store(tmp_path / "run").status()
    assert (status.done, status.missing) == (36, 108)
    assert status.seconds == pytest.approx(72.0)
    assert status.remaining == pytest.approx(216.0)
    (writer,) = status.writers
    assert writer["missing"] == 108
    assert writer["remaining"] == pytest.approx(108.0)  # one row a second
    assert "216 s left" in str(status)
    assert "about 108 s at its pace" in str(status)
    folder.end("interrupted")


def test_sittings_and_parts_in_any_order_fill_each_other(tmp_path: Path) -> None:
    """Parts of other counts, one after the other: nothing is computed twice."""
    spec = spec_of_grid(9, 5, 10)
    for k, n in itertools.chain([(2, 3), (1, 5)], [(k, 4) for k in range(1, 5)]):
        go_on(tmp_path / "run", spec=spec, part=Part(k, n))
    status = rigid.open_store(tmp_path / "run").status()
    assert (status.complete, status.twice) == (True, 0)


# More samples for a stored map: the first bodies are those stored, and nothing else changes.


BOX: dict[str, Any] = {
    "axes": {"I2/I1": [1.2, 1.6, 2.0, 4.5], "noise": [1e-3, 1e-2]},
    "t_end": 60.0,
    "stable": rigid.no_flip(),
    "rng": 5,
}
TOP: dict[str, Any] = {
    "axes": {"spin": [1.0, 3.0, 6.0]},
    "t_end": 4.0,
    "stable": rigid.tilt_below(0.01),
    "measure": [rigid.largest_tilt(), rigid.mean_rate(3)],
    "rng": 6,
}
MAPS: dict[str, tuple[Any, dict[str, Any], int, int]] = {
    "closed form, and bodies that cannot be": (rigid.FreeBody, BOX, 64, 256),
    "steps with an audit, and measures": (
        rigid.HeavyTop(rigid.Body((1.0, 1.6, 0.7)), mgl=1.2),
        TOP,
        128,
        300,
    ),
    "random bodies": (
        rigid.FreeBody(rigid.Body((1.0, 1.5, 2.0))),
        {
            **BOX,
            "axes": {"spin": [0.3, 1.0]},
            "t_end": 25.0,
            "vary": {"I1": rigid.normal(0.05, relative=True)},
        },
        64,
        192,
    ),
    "pixels in pieces": (
        rigid.FreeBody(rigid.Body((1.0, 1.5, 2.0))),
        {**BOX, "axes": {"spin": np.linspace(0.2, 2.0, 8)}, "t_end": 12.0},
        16_384,
        20_000,
    ),
}


@pytest.mark.parametrize("name", MAPS)
def test_more_samples_are_the_map_that_was_asked_for_at_once(name: str, tmp_path: Path) -> None:
    scene, ask, few, many = MAPS[name]
    rigid.stability_map(scene, samples=few, store=tmp_path / "few", **ask, progress=False)
    more = rigid.open_store(tmp_path / "few").extend(tmp_path / "many", samples=many)
    assert more.result().samples.max() == few
    result = more.resume(progress=False)
    once = rigid.stability_map(scene, samples=many, **ask, progress=False)
    assert result.complete
    assert result.receipt()["fingerprint"] == once.receipt()["fingerprint"]
    possible = int((once.status == 0).sum())
    assert 0.0 < np.nanmean(once.share) < 1.0
    assert result.computed == (many - few) * possible
    assert rigid.open_store(tmp_path / "many").verify(share=1.0).ok
    assert rigid.diff(result, once).same
    # The folder that was there is as it was.
    assert rigid.open_store(tmp_path / "few").result().samples.max() == few


def test_a_part_of_a_map_goes_on_with_more_samples_in_other_processes(tmp_path: Path) -> None:
    ask = {**BOX, "samples": 64}
    rigid.stability_map(rigid.FreeBody, store=tmp_path / "few", part=(1, 2), **ask, progress=False)
    done = int(rigid.open_store(tmp_path / "few").result().samples.sum())
    more = rigid.open_store(tmp_path / "few").extend(tmp_path / "many", samples=128)
    assert "copied" in str(more.status())
    ask["samples"] = 128
    for k in (1, 2):
        whole = rigid.stability_map(
            rigid.FreeBody, store=tmp_path / "many", part=(k, 2), **ask, progress=False
        )
    once = rigid.stability_map(rigid.FreeBody, **ask, progress=False)
    assert whole.receipt()["fingerprint"] == once.receipt()["fingerprint"]
    assert 0 < done < int(once.samples.sum())


def test_maps_of_other_pieces_are_not_merged(tmp_path: Path) -> None:
    ask = {**BOX, "progress": False}
    rigid.stability_map(rigid.FreeBody, store=tmp_path / "few", samples=64, **ask)
    rigid.open_store(tmp_path / "few").extend(tmp_path / "one", samples=128)
    rigid.open_store(tmp_path / "few").extend(tmp_path / "two", samples=128)
    rigid.stability_map(rigid.FreeBody, store=tmp_path / "three", samples=128, part="1/2", **ask)
    both = rigid.merge([tmp_path / "one", tmp_path / "two"], tmp_path / "both")
    assert both.status().twice == 6  # of eight pixels two are no bodies
    with pytest.raises(ValueError, match=r"three: its units have 1048576 samples, the units of"):
        rigid.merge([tmp_path / "one", tmp_path / "three"], tmp_path / "all")


def test_what_cannot_get_more_samples(tmp_path: Path) -> None:
    cases: list[tuple[dict[str, Any], int, str]] = [
        ({"samples": 64}, 64, "samples = 64: must be above 64"),
        ({"samples": 100}, 200, "the 100 stored samples of a pixel must be a multiple of 64"),
        ({"samples": 64, "check": 0.5}, 128, "half_width, refine, budget or a share to check"),
        ({"samples": 64, "budget": 200}, 128, "half_width, refine, budget or a share to check"),
        ({"half_width": 0.2}, 10**6, "half_width, refine, budget or a share to check"),
        ({"samples": 64}, 2**30, "units of 64 samples, more than 4194304; take a new store"),
    ]
    for k, (options, samples, words) in enumerate(cases):
        path = tmp_path / str(k)
        rigid.stability_map(rigid.FreeBody, store=path, **BOX, **options, progress=False)
        with pytest.raises(ValueError, match=words):
            rigid.open_store(path).extend(tmp_path / "more", samples=samples)
        assert not (tmp_path / "more").exists()
    with pytest.raises(ValueError, match="is no running map, and is not empty"):
        rigid.open_store(tmp_path / "0").extend(tmp_path, samples=128)
