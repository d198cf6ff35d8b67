"""Wrong rows are found: before others are added, by verification and merging. Right ones pass."""

import json
import re
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rigid
from refusals import refuses
from rigid.store import resume
from rigid.store.disk import Disk
from rigid.store.head import MOST_BYTES
from rigid.store.log import Log
from rigid.store.rows import ROW, Block
from rigid.store.running import Folder, Memory
from rigid.store.store import Store
from small_maps import in_blocks, small_map, spec_of
from stores import SPEC, go_on, numbers, request, stops_after

UNITS = np.array([145, 146, 147, 148, 150, 151])


def altered(path: Path, count: int, wrong: int) -> Folder:
    """A running map of some rows, of which the first are wrong under valid digests."""
    quiet = path.parent / "quiet"
    if not quiet.exists():
        go_on(quiet)
    rows = Folder(quiet).table.rows[np.flatnonzero(Folder(quiet).table.known)[:count]].copy()
    rows["stable"][:wrong] += 1
    folder = Folder.at(path, SPEC)
    folder.begin()
    folder.append(Block(rows, np.zeros(count, "<f4")))
    folder.end("interrupted")
    return folder


@pytest.mark.parametrize("count", [1, 5, 16])
def test_a_map_with_an_altered_row_among_few_is_refused(tmp_path: Path, count: int) -> None:
    folder = altered(tmp_path / "run", count, 1)
    logs = sorted((folder.path / "logs").iterdir())
    with pytest.raises(ValueError, match=r"not compute the numbers that are stored: .* stable"):
        rigid.stability_map(**request(store=folder.path))
    assert len(sorted((folder.path / "logs").iterdir())) == len(logs) + 1  # a log without rows
    assert Folder(folder.path).table.known.sum() == count


def test_right_rows_are_never_refused(tmp_path: Path) -> None:
    folder = altered(tmp_path / "run", 100, 0)
    assert go_on(folder.path).reason == "complete"


@pytest.mark.parametrize(
    ("count", "seconds", "expected"),
    [
        (16, 0.0, 16),
        (17, 0.0, 9),  # each second one
        (100, 0.0, 15),  # each seventh
        (100, np.nan, 15),
        (100, 0.125, 4),
        (100, 0.6, 1),
    ],
)
def test_some_rows_are_computed_again_for_half_a_second(
    count: int, seconds: float, expected: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Sixteen at most, at equal distances; one at least."""
    units = np.arange(count) + 3
    rows = np.zeros(count, ROW)
    rows["unit"] = units
    memory = Memory(SPEC)
    memory.append(Block(rows, np.full(count, 1e9 * seconds, np.float32)))
    again: list[int] = []

    def computed(_head: object, units: np.ndarray[Any, Any], *_: object) -> Block:
        again.extend(units.tolist())
        return memory.table.block(units)

    monkeypatch.setattr(resume, "compute", computed)
    resume._compute_again(memory, 1, lambda: False)
    step = -(-count // 16)
    assert again == units[::step][:expected].tolist()


def test_verification_finds_every_altered_row(tmp_path: Path) -> None:
    folder = altered(tmp_path / "run", 100, 29)
    found = rigid.open_store(folder.path).verify(1.0)
    assert (found.units, found.checked, len(found.wrong), found.ok) == (100, 100, 29, False)
    assert "stable is" in found.wrong[0]
    some = rigid.open_store(folder.path).verify(0.1, seed=4)
    assert some.checked == 10
    assert set(some.wrong) <= set(found.wrong)
    lines = str(found).splitlines()
    assert lines[0] == "100 of 100 units were computed again: 29 differ"
    assert lines[1:21] == found.wrong[:20]
    assert lines[21:] == ["and 9 more"]
    assert rigid.open_store(tmp_path / "quiet").verify(1.0).ok


def test_verification_reads_saved_maps(tmp_path: Path) -> None:
    path = small_map(samples=4).save(tmp_path / "map.npz")
    from rigid.store.compare import verify

    assert str(verify(path, share=1.0)) == "35 of 35 units were computed again: 0 differ"


@pytest.mark.parametrize(("share", "rule"), [(0.0, "must be positive"), (1.5, "at most 1")])
def test_shares_of_verification_are_checked(tmp_path: Path, share: float, rule: str) -> None:
    go_on(tmp_path / "run")
    with pytest.raises(ValueError, match=rule):
        rigid.open_store(tmp_path / "run").verify(share)


def test_rows_that_contradict_each_other_are_refused(tmp_path: Path) -> None:
    folder = altered(tmp_path / "run", 100, 1)
    with pytest.raises(ValueError, match=r"quiet: unit \d+ has two results: stable \d+ and \d+"):
        rigid.merge([folder.path, tmp_path / "quiet"], tmp_path / "merged")
    assert not (tmp_path / "merged").exists()


def test_another_map_is_refused_with_what_differs(tmp_path: Path) -> None:
    path = tmp_path / "run"
    go_on(path)
    with pytest.raises(ValueError, match=r"holds another map .*: seed: 1 and 2"):
        rigid.stability_map(**request(store=path, rng=2))
    with pytest.raises(ValueError, match=r"samples: 20 and 21; seed: 1 and 3"):
        rigid.stability_map(**request(store=path, rng=3, samples=21))
    go_on(tmp_path / "other", spec=spec_of())
    # Of the y axis ends and number, and the method: five are told.
    told = "x.from: 1.01 and 0.5; x.to: 1.99 and 3.5; x.count: 7 and 20; y.count: 5 and 12; "
    with pytest.raises(ValueError, match=re.escape(told) + r'method: "rk4" and "auto"; take'):
        rigid.merge([path, tmp_path / "other"], tmp_path / "merged")


@pytest.mark.parametrize(
    ("values", "difference"),
    [
        (np.linspace(0.5, 4.0, 20), "x.to: 3.5 and 4.0"),
        (np.linspace(0.5, 3.5, 10), "x.count: 20 and 10"),
        (np.geomspace(0.5, 3.5, 20), "x.values[1]: 0.65789"),
        (None, 'x.name: "I2/I1" and "noise"; x.from: 0.5 and 0.001; '),
    ],
)
def test_an_axis_differs_in_the_words_of_its_file(
    values: np.ndarray[Any, Any] | None, difference: str, tmp_path: Path
) -> None:
    """Not in the second of its values: a changed end changes them all."""
    axes = {axis.name: np.array(axis.values) for axis in SPEC.axes}
    other = {"noise": axes["noise"]} if values is None else {**axes, "I2/I1": values}
    go_on(tmp_path / "run")
    with pytest.raises(ValueError, match=re.escape(f"(there and asked for): {difference}")):
        rigid.stability_map(**request(store=tmp_path / "run", axes=other))


def test_without_a_seed_the_one_of_the_folder_is_kept(tmp_path: Path) -> None:
    one, other = (rigid.stability_map(**request(store=tmp_path / "run", rng=None)) for _ in "12")
    assert one.spec.seed == other.spec.seed


def test_a_title_is_no_part_of_the_key(tmp_path: Path) -> None:
    go_on(tmp_path / "run")
    asked = request(store=tmp_path / "run", title="Another", time_unit="min")
    result = rigid.stability_map(**asked)
    assert result.complete
    assert (result.spec.title, result.spec.time_unit) == ("Another", "min")
    assert len(list((tmp_path / "run" / "logs").iterdir())) == 1


HEAD: dict[str, tuple[Callable[[dict[str, object]], object], str]] = {
    "long": (
        lambda head: json.dumps(head) + " " * MOST_BYTES,
        f"is no running map: its head has more than {MOST_BYTES} B",
    ),
    "no JSON": (lambda head: "x", "is no running map: Expecting value"),
    "other JSON": (lambda head: "[]", "is no running map: its head.json has another format"),
    "other format": (
        lambda head: json.dumps({**head, "format_version": 2}),
        "has format version 2, this version of rigid reads 1: take another folder",
    ),
    "no specification": (
        lambda head: json.dumps({**head, "spec": {}}),
        "holds a broken specification",
    ),
    "other columns": (
        lambda head: json.dumps({**head, "columns": [], "version": "9.9.9"}),
        "columns differ from this version of rigid; version 9.9.9 made the map",
    ),
}


@pytest.mark.parametrize("change", HEAD)
def test_heads_that_are_none_are_refused(tmp_path: Path, change: str) -> None:
    path = tmp_path / "run"
    go_on(path)
    edit, message = HEAD[change]
    head = json.loads((path / "head.json").read_text())
    (path / "head.json").write_text(str(edit(head)))
    with pytest.raises(ValueError, match=message):
        rigid.open_store(path)


def test_a_folder_that_is_no_running_map_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"is no running map: there is no head\.json"):
        rigid.open_store(tmp_path)
    (tmp_path / "thesis.tex").write_text("mine")
    with pytest.raises(ValueError, match="is no running map, and is not empty"):
        rigid.stability_map(**request(store=tmp_path))
    assert [path.name for path in tmp_path.iterdir()] == ["thesis.tex"]


def test_a_head_that_is_replaced_meanwhile_is_noticed(tmp_path: Path) -> None:
    path = tmp_path / "run"
    go_on(path, stop=stops_after(1))
    store = rigid.open_store(path)
    head = json.loads((path / "head.json").read_text())
    head["spec"]["seed"] = 5
    (path / "head.json").write_text(json.dumps(head))
    with pytest.raises(ValueError, match=r"head.json was replaced and belongs to another map"):
        store.status()


def in_store(options: dict[str, object]) -> None:
    try:
        rigid.stability_map(**request(**options))
    finally:
        assert not Path("x").exists()


test_options_of_stores_are_checked = refuses(
    [
        ({"part": "1/2"}, "part = '1/2': needs store=..., the folder of all parts"),
        ({"part": "3/2", "store": "x"}, "part = '3/2': must be k/n with 1 <= k <= n"),
        ({"part": "a", "store": "x"}, "part = 'a': must be k/n with 1 <= k <= n"),
        ({"part": 3, "store": "x"}, TypeError, "part = 3: must be 'k/n' or (k, n)"),
        ({"part": (1.0, 3), "store": "x"}, TypeError, "part = (1.0, 3): must be 'k/n' or (k, n)"),
        ({"part": (1, 2, 3), "store": "x"}, "part = (1, 2, 3): must be k/n with 1"),
        (
            {"part": "1/99999999999999999999", "store": "x"},
            "part = '1/99999999999999999999': must be k/n with 1 <= k <= n <= 2147483648",
        ),
        ({"threads_per_task": 0, "store": "x"}, "threads_per_task = 0: must be"),
        ({"threads": 0, "store": "x"}, "threads = 0: must be"),
        ({"executor": 3, "store": "x"}, TypeError, "executor = 3: must have the method submit"),
        ({"progress": 3, "store": "x"}, TypeError, "progress = 3: must be None, True, False"),
    ],
    literal=True,
    by=in_store,
)


def test_maps_that_are_merged_are_named_one_by_one(tmp_path: Path) -> None:
    with pytest.raises(TypeError, match="paths = 'a': must be a sequence of folders"):
        rigid.merge("a", tmp_path)
    with pytest.raises(ValueError, match="paths: must name at least one running map"):
        rigid.merge([], tmp_path)


def test_differences_of_one_map_are_told_by_column(tmp_path: Path) -> None:
    folder = altered(tmp_path / "run", 100, 3)
    found = rigid.diff(folder.path, tmp_path / "quiet")
    assert not found.same
    assert found.specification == []
    assert found.numbers[0] == "44 pixels are in the second only"
    turned = rigid.diff(tmp_path / "quiet", folder.path)
    assert turned.numbers[0] == "44 pixels are in the first only"
    assert found.numbers[1].startswith("stable: 3 pixels differ, the first at (")
    assert str(rigid.diff(tmp_path / "quiet", tmp_path / "quiet")) == "no difference"


def test_a_pixel_of_fewer_bodies_is_no_other_number(tmp_path: Path) -> None:
    """A part has the first bodies of a pixel: their counts are others than those of all."""
    asked: dict[str, Any] = {"axes": {"noise": [0.01]}, "samples": 5000}
    whole = small_map(**asked)
    part = small_map(store=tmp_path / "part", part=(1, 3), **asked)
    assert 0 < part.samples[0] < 5000
    assert rigid.diff(part, whole).numbers == ["1 pixels have more bodies in the second"]
    assert rigid.diff(whole, part).numbers == ["1 pixels have more bodies in the first"]


def test_differences_of_two_maps_are_told_by_their_intervals() -> None:
    one, two, shorter = small_map(rng=1), small_map(rng=2), small_map(t_end=2.0)
    found = rigid.diff(one, two)
    assert found.specification == ["seed: 1 and 2"]
    assert re.match(r"0 of 35 pixels have intervals that do not meet", found.numbers[0])
    apart = np.abs(one.share - two.share)
    place = tuple(int(i) for i in np.unravel_index(apart.argmax(), apart.shape))
    assert found.numbers[1:] == [
        f"largest difference of shares: {apart.max():.3g} at {place}: "
        f"{one.share[place]:.6g} and {two.share[place]:.6g}"
    ]
    told = int(re.match(r"(\d+) of", rigid.diff(one, shorter).numbers[0])[1])  # type: ignore[index]
    meet = (one.lower <= shorter.upper) & (shorter.lower <= one.upper)
    assert told == (~meet).sum() > 3

    def stop(_: rigid.Progress) -> None:
        raise KeyboardInterrupt

    with in_blocks(7):
        begun = small_map(rng=2, partial=True, progress=stop)
    known = int((begun.samples > 0).sum())
    assert 0 < known < 35
    for first, second in ((one, begun), (begun, one)):
        numbers_of_both = rigid.diff(first, second).numbers
        assert numbers_of_both[0].startswith(f"0 of {known} pixels")
        assert "nan" not in numbers_of_both[1]
    axes = {"I2/I1": [1.2, 1.5]}
    assert rigid.diff(one, small_map(axes=axes)).numbers == [
        "the axes differ: the pixels cannot be compared"
    ]


def test_the_fingerprint_is_that_of_the_numbers(tmp_path: Path) -> None:
    one, same, other = small_map(), small_map(title="x", threads=1), small_map(rng=2)
    prints = [result.receipt()["fingerprint"] for result in (one, same, other)]
    assert prints[0] == prints[1] != prints[2]
    assert rigid.load_map(one.save(tmp_path / "map.npz")).receipt()["fingerprint"] == prints[0]


def test_the_status_counts_rows_writers_and_damage(tmp_path: Path) -> None:
    folder = altered(tmp_path / "run", 10, 0)
    log = next((folder.path / "logs").iterdir())
    with log.open("r+b") as file:
        file.truncate(log.stat().st_size - 1024)
    status = rigid.open_store(folder.path).status()
    assert (status.done, status.units - status.missing, status.bodies) == (10, 10, 200)
    assert not status.complete
    assert status.writers[0]["units"] == 10
    assert "10 of" in str(status)
    assert "twice" not in str(status)
    shutil.copy(log, log.with_name("20260101T000000Z-0123456789ab.tar"))
    status = rigid.open_store(folder.path).status()
    assert (status.done, status.twice) == (10, 10)
    assert "twice       10 rows were computed twice, with equal bytes" in str(status)
    assert repr(rigid.open_store(folder.path)).endswith("10 units are stored>")
    assert isinstance(rigid.open_store(folder.path), Store)


def test_two_logs_never_have_one_name(tmp_path: Path) -> None:
    folder = Folder.at(tmp_path / "run", SPEC)
    logs = [Log(folder.path / "logs", folder.head.seal, {}, folder._disk) for _ in range(3)]
    assert len({one.path for one in logs}) == 3
    for one in logs:
        one.close("complete")
    assert numbers(folder.path) == Folder(folder.path).table.rows.tobytes()


def test_rows_are_on_the_disk_after_half_a_second(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    clock, written = [0.0], 0

    class Counting(Disk):
        def synchronise(self, descriptor: int) -> None:
            nonlocal written
            written += 1
            super().synchronise(descriptor)

    monkeypatch.setattr("rigid.store.log.time.monotonic", lambda: clock[0])
    folder = Folder.at(tmp_path / "run", SPEC)
    own = Log(folder.path / "logs", folder.head.seal, {}, Counting())
    rows = Block(np.zeros(1, ROW), np.zeros(1, np.float32))
    for clock[0], expected in ((0.4, 1), (0.5, 2), (0.9, 2), (1.0, 3), (1.4, 3)):
        own.append(rows)
        assert written == expected
    own.close("complete")
    assert written == 4
