"""A running map has the bytes of the quiet run, however it was computed."""

import json
import shutil
import signal
import subprocess
import time
import tracemalloc
from collections.abc import Callable
from concurrent.futures import Future, ProcessPoolExecutor, ThreadPoolExecutor
from hashlib import blake2b
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rigid
from processes import environment, python_command
from rigid._checks.progress import heeding_signals
from rigid.maps.axes import make_axes
from rigid.maps.data import COLUMNS
from rigid.maps.refine import lattice_level
from rigid.store import drive as driving
from rigid.store.drive import Intake, Task, drive, own_build
from rigid.store.head import Head
from rigid.store.resume import Part, carry_on, missing
from rigid.store.rows import FIELDS, ROW, Block, Table, compute
from rigid.store.running import Folder, Memory
from small_maps import assert_same_map, saved_bytes
from stores import SPEC, go_on, numbers, request, stops_after, stored_map


@pytest.fixture(scope="module")
def quiet() -> rigid.StabilityMap:
    """The map computed at once, without a store."""
    return rigid.stability_map(**request())


def test_rows_are_the_columns_of_maps() -> None:
    assert ROW.names == ("unit", *FIELDS)
    assert tuple(column.name for column in COLUMNS if column.reproducible) == FIELDS


def test_a_worker_makes_only_its_own_rows_of_the_grid() -> None:
    """The starts of a million pixels would be 160 MB."""
    ends = {axis.name: (axis.values[0], axis.values[-1]) for axis in SPEC.axes}
    axes = make_axes({name: np.geomspace(*two, 1000) for name, two in ends.items()})
    spec = SPEC.replace(axes=axes)
    head, units = Head.of(spec), np.array([700_000, 700_007])
    compute(head, units)  # what is cached
    tracemalloc.start()
    try:
        compute(head, units)
        assert tracemalloc.get_traced_memory()[1] < 2**20
    finally:
        tracemalloc.stop()


def test_one_sitting_after_the_other_computes_nothing_twice(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, quiet: rigid.StabilityMap
) -> None:
    monkeypatch.setattr(driving, "GROWTH", 1)  # a unit a block
    path, sittings = tmp_path / "run", 0
    while go_on(path, stop=stops_after(30)).reason == "interrupted":
        sittings += 1
    assert sittings > 2
    status = rigid.open_store(path).status()
    assert (status.missing, status.twice, status.damage) == (0, 0, [])
    reasons = sorted(writer["reason"] for writer in status.writers)
    assert reasons == ["complete", *["interrupted"] * sittings]
    assert saved_bytes(stored_map(path), tmp_path) == saved_bytes(quiet, tmp_path)


def test_a_partial_map_tells_why_its_writer_ended(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(driving, "GROWTH", 1)
    reports = iter(range(100))

    def end(_progress: rigid.Progress) -> None:
        if next(reports) == 3:
            signal.raise_signal(signal.SIGTERM)

    with heeding_signals(), pytest.raises(rigid.Interrupted) as raised:
        rigid.stability_map(**request(store=tmp_path / "run", threads=1, progress=end))
    (writer,) = raised.value.partial.receipt()["writers"]
    assert writer["reason"] == "terminated"
    assert writer["units"] == (raised.value.partial.samples > 0).sum()
    # The next sitting, of the same process, is not terminated.
    folder = Folder(tmp_path / "run")
    assert carry_on(folder, threads=1, stop=stops_after(9), progress=False).reason == "interrupted"
    assert [writer["reason"] for writer in folder.writers()] == ["terminated", "interrupted"]


def test_a_coarse_lattice_comes_first_and_in_it_what_is_likely_to_take_long(tmp_path: Path) -> None:
    folder = Folder.at(tmp_path / "run", SPEC)
    shape, before = SPEC.shape, missing(folder)
    level = lattice_level(shape, before)
    assert (np.diff(level) <= 0).all()
    go_on(tmp_path / "quiet")
    rows = Folder(tmp_path / "quiet").table.rows
    known = before[level >= 4]
    cost = np.arange(len(known), dtype="<f4")
    folder.begin()
    folder.append(Block(rows[known], cost))
    folder.end("interrupted")
    after = missing(folder)
    assert set(after) == set(before) - set(known)
    mine = after[lattice_level(shape, after) == 2]
    beside = [index // 4 * 4 for index in np.unravel_index(mine, shape)]
    likely = folder.table.nanoseconds[np.ravel_multi_index(beside, shape)]
    likely = np.where(np.isnan(likely), 0.0, likely)  # no body is possible there
    assert (np.diff(likely) <= 0).all()
    assert len(np.unique(likely)) > 5


def test_a_complete_map_is_not_touched_again(tmp_path: Path) -> None:
    path = tmp_path / "run"
    go_on(path)
    before = sorted((path / "logs").iterdir())
    assert go_on(path).reason == "complete"
    assert sorted((path / "logs").iterdir()) == before


def test_an_interrupted_map_is_a_coarse_whole_one() -> None:
    pixels = np.arange(9 * 9)
    level = lattice_level((9, 9), pixels).reshape(9, 9)
    assert level[0, 0] == 16
    assert level[8, 0] == level[0, 8] == level[8, 8] == 8
    assert level[4, 6] == 2
    assert (level[1::2] == 1).all()


@pytest.mark.parametrize("count", [1, 3, 16])
def test_parts_merged_in_any_order_are_the_map(tmp_path: Path, count: int) -> None:
    go_on(tmp_path / "quiet")
    folders = []
    for number in range(1, count + 1):
        outcome = go_on(tmp_path / f"{number}", part=Part(number, count))
        assert outcome.reason == ("complete" if count == 1 else "waiting")
        folders.append(tmp_path / f"{number}")
    order = np.random.default_rng(count).permutation(count)
    merged = rigid.merge([folders[i] for i in order], tmp_path / "merged")
    assert merged.status().complete
    assert numbers(tmp_path / "merged") == numbers(tmp_path / "quiet")
    again = rigid.merge(folders[:1], tmp_path / "merged")  # a part that is there already
    assert again.status().twice == 0


def test_a_part_that_has_grown_is_merged_again(tmp_path: Path) -> None:
    """Its log, which a process goes on to write, has rows that the first copy lacks."""
    go_on(tmp_path / "quiet")
    table = Folder(tmp_path / "quiet").table
    rows = table.rows[table.known]
    writing = Folder.at(tmp_path / "part", SPEC)
    writing.begin()
    for begin in (0, 20):
        writing.append(Block(rows[begin : begin + 20], np.full(20, 1.0, np.float32)))
        merged = rigid.merge([tmp_path / "part"], tmp_path / "merged")
        assert merged.status().done == begin + 20
    writing.end("interrupted")


def test_workers_of_a_thread_pool_give_the_same_rows(quiet: rigid.StabilityMap) -> None:
    with ThreadPoolExecutor(3) as pool:
        assert_same_map(rigid.stability_map(**request(executor=pool, threads_per_task=2)), quiet)


def test_a_pool_whose_worker_is_killed_keeps_its_rows(tmp_path: Path) -> None:
    path = tmp_path / "run"
    killed = Killed(ProcessPoolExecutor(1, mp_context=get_context("spawn")), after=4)
    with pytest.raises(RuntimeError, match=r"the pool of workers broke .* are kept"):
        go_on(path, executor=killed)
    done = int(Folder(path).table.known.sum())
    assert done > 0
    go_on(path)
    go_on(tmp_path / "quiet")
    assert numbers(path) == numbers(tmp_path / "quiet")
    assert Folder(path).table.twice == 0


class Killed:
    """A pool whose workers are killed with a task."""

    def __init__(self, pool: ProcessPoolExecutor, after: int) -> None:
        self._pool, self._left, self._max_workers = pool, after, 1

    def submit(self, function: Callable[..., Any], *arguments: Any) -> Future[Any]:
        self._left -= 1
        if self._left == 0:
            for process in self._pool._processes.values():
                process.kill()
        return self._pool.submit(function, *arguments)


class Flaky:
    """An executor in this process, in which the block with a unit fails each time."""

    def __init__(self, unit: int) -> None:
        self._unit, self._max_workers, self.failed = unit, 2, 0

    def submit(self, function: Callable[..., Any], task: Task, units: Any) -> Future[Any]:
        future: Future[Any] = Future()
        if self._unit in units:
            self.failed += 1
            future.set_exception(OSError("the worker is gone"))
        else:
            future.set_result(function(task, units))
        return future


def test_a_unit_that_kills_its_workers_is_reported_and_the_rest_goes_on(tmp_path: Path) -> None:
    unit = 7 * 20 + 8
    with pytest.raises(rigid.store.store.PoisonedError, match="failed three times") as raised:
        rigid.stability_map(**request(store=tmp_path / "run", executor=Flaky(unit)))
    assert raised.value.units == [unit]
    assert not raised.value.partial.complete
    assert rigid.open_store(tmp_path / "run").status().missing == 1
    rigid.open_store(tmp_path / "run").resume(progress=False)
    assert rigid.open_store(tmp_path / "run").status().complete


class Lost(Future[Any]):
    """A task that failed; it counts how many were asked for their result."""

    asked = 0

    def result(self, timeout: float | None = None) -> Any:
        Lost.asked += 1
        return super().result(timeout)


class Broken:
    """An executor whose workers cannot work."""

    def __init__(self) -> None:
        self.submitted = 0
        Lost.asked = 0

    def submit(self, *_arguments: Any) -> Future[Any]:
        self.submitted += 1
        future = Lost()
        future.set_exception(ImportError("no rigid here"))
        return future


def test_workers_that_cannot_work_end_the_run(tmp_path: Path) -> None:
    with pytest.raises(ImportError, match="no rigid here"):
        rigid.stability_map(**request(store=tmp_path / "run", executor=Broken()))


def test_units_are_given_up_after_three_tasks_and_workers_after_a_dozen() -> None:
    memory = Memory(SPEC)
    task = Task(SPEC.to_json(), 1, None, {}, SPEC.samples)

    def poisoned(units: range, executor: Any) -> dict[int, str]:
        intake = Intake(memory, lambda *_: None, 1)  # a unit a task
        return drive(task, np.array(units), intake, executor, 1, lambda: False)

    flaky = Flaky(148)
    assert poisoned(range(146, 149), flaky) == {148: "OSError: the worker is gone"}
    assert flaky.failed == 3
    # Four units fail three times each. The thirteenth failure without any success is raised.
    assert poisoned(range(4), Broken()).keys() == {0, 1, 2, 3}
    broken = Broken()
    with pytest.raises(ImportError, match="no rigid here"):
        poisoned(range(100), broken)
    assert Lost.asked == 13
    # Two tasks for each worker wait: after six turns of two the seventh is begun.
    assert broken.submitted == 14


def test_a_worker_of_another_version_is_refused(tmp_path: Path) -> None:
    folder = Folder.at(tmp_path / "run", SPEC)
    folder.begin()
    task = Task(SPEC.to_json(), 1, ("0.0.0", None), {}, SPEC.samples)
    intake = Intake(folder, lambda *_: None, 1)
    with ThreadPoolExecutor(1) as pool, pytest.raises(ValueError, match="a worker has rigid"):
        drive(task, np.arange(160, 165), intake, pool, 1, lambda: False)
    task = Task(SPEC.to_json(), 1, own_build(), {}, SPEC.samples)
    with ThreadPoolExecutor(1) as pool:
        drive(task, np.arange(160, 165), intake, pool, 1, lambda: False)
    folder.end("interrupted")
    assert Folder(tmp_path / "run").table.known.sum() == 5


def test_killed_runs_go_on_to_the_same_bytes(tmp_path: Path) -> None:
    """Each process is killed at a random moment; the long test does it a hundred times."""
    path, random = tmp_path / "run", np.random.default_rng(1)
    go_on(tmp_path / "quiet")
    kills = 0
    for _ in range(2):
        process: Any = subprocess.Popen(
            python_command("-c", SLOW, str(path)), env=environment(), stdout=subprocess.PIPE
        )
        process.stdout.readline()  # rows are written from now on
        time.sleep(random.uniform(0.0, 0.05))
        process.kill()
        kills += process.wait() != 0
        process.stdout.close()
    assert kills
    status = rigid.open_store(path).status()
    lacking = [writer["missing"] for writer in status.writers if not writer.get("reason")]
    assert lacking == [status.missing] * kills
    assert "running or killed, wrote " in str(status)
    go_on(path)
    assert numbers(path) == numbers(tmp_path / "quiet")
    assert Folder(path).table.twice == 0


SLOW = """
import sys, time
from pathlib import Path
from stores import SPEC, Folder, carry_on
from rigid.store import resume
def one_by_one(head, todo, intake, threads, stop):
    print("begun", flush=True)
    for unit in todo:
        intake.take(compute(head, np.array([unit])))
        time.sleep(0.001)
import numpy as np
from rigid.store.head import Head
from rigid.store.rows import compute
resume.run_here = one_by_one
carry_on(Folder.at(Path(sys.argv[1]), SPEC), threads=1, stop=lambda: False, progress=False)
"""


def test_the_table_refuses_units_that_the_map_does_not_have() -> None:
    memory = Memory(SPEC)
    rows = np.zeros(1, ROW)
    rows["unit"] = memory.head.units
    with pytest.raises(ValueError, match="a row of a unit that the map does not have"):
        Table(memory.head).add(Block(rows, np.zeros(1, np.float32)), "log")


# Files of a running map that somebody removes while it is computed: nothing is claimed


def newest_log(path: Path) -> Path:
    return max((path / "logs").iterdir(), key=lambda log: log.stat().st_mtime)


def rename(path: Path) -> None:
    path.rename(path.with_name("elsewhere"))


REMOVALS: dict[str, Callable[[Path], object]] = {
    "folder": shutil.rmtree,
    "renamed": rename,
    "logs": lambda path: shutil.rmtree(path / "logs"),
    "log": lambda path: newest_log(path).unlink(),
    "head": lambda path: (path / "head.json").unlink(),
    "log of another part": lambda path: sorted((path / "logs").iterdir())[0].unlink(),
}


@pytest.mark.parametrize("what", REMOVALS)
def test_a_map_whose_rows_are_gone_is_not_complete(what: str, tmp_path: Path) -> None:
    path = tmp_path / "run"
    rigid.stability_map(**request(store=path, part=(1, 2)))
    removals = iter([REMOVALS[what]])

    def remove(_: object) -> None:
        for removal in removals:
            removal(path)

    with pytest.raises(FileNotFoundError, match="removed or renamed while the map was computed"):
        rigid.stability_map(**request(store=path, progress=remove))


def test_a_store_is_read_again_before_it_goes_on(tmp_path: Path) -> None:
    """It was opened while there were rows."""
    go_on(tmp_path / "run")
    store = rigid.open_store(tmp_path / "run")
    shutil.rmtree(tmp_path / "run" / "logs")
    assert store.resume(progress=False).computed == SPEC.samples * 144


# The running maps that each release has written are read for ever


STORES = Path(__file__).parents[2] / "golden" / "stores"
NAMES = sorted(path.name for path in STORES.iterdir() if path.is_dir())


def test_there_is_one() -> None:
    assert NAMES


@pytest.mark.parametrize("name", NAMES)
def test_the_rows_of_a_release_are_read_and_come_out_again(name: str) -> None:
    kept = json.loads((STORES / f"{name}.json").read_text())
    folder = Folder(STORES / name)
    table = folder.table
    assert folder.head.key.hex() == kept["key"]
    assert int(table.known.sum()) == kept["units"]
    assert blake2b(table.rows.tobytes(), digest_size=16).hexdigest() == kept["rows"]
    status = rigid.open_store(STORES / name).status()
    assert status.complete
    # The end of one log is torn.
    assert sorted(str(writer.get("reason")) for writer in status.writers) == [
        "None",
        "complete",
        "waiting",
    ]
    assert {writer["version"] for writer in status.writers} == {kept["version"]}
    assert len(status.damage) == 1
    assert not rigid.open_store(STORES / name).verify(1.0).wrong


@pytest.mark.parametrize("name", NAMES)
def test_a_map_of_a_release_goes_on(name: str, tmp_path: Path) -> None:
    whole = Folder(STORES / name).table
    shutil.copytree(STORES / name, tmp_path / "run")
    min((tmp_path / "run" / "logs").iterdir()).unlink()
    assert Folder(tmp_path / "run").table.known.sum() < whole.known.sum()
    assert rigid.open_store(tmp_path / "run").resume(progress=False).complete
    assert Folder(tmp_path / "run").table.rows.tobytes() == whole.rows.tobytes()
