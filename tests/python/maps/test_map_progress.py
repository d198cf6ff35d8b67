"""While a map runs: progress, silent when asked to be, and blocks of a third of a second."""

import numpy as np
import pytest

import rigid
from processes import PATIENCE, python_process
from rigid.store.drive import SHORTEST, Intake
from rigid.store.rows import NO_BINS, ROW, Block
from rigid.store.running import Memory
from small_maps import in_blocks, small_map, spec_of
from terminals import in_terminal, read

IMPORTS = "import rigid\n"

#: A tenth of a second of work with a visible bar; one pixel of five fails.
SHORT = """
result = rigid.stability_map(
    rigid.FreeBody, axes={"spin": [0.5, 1.0, 1.5, 2.0, 1e200]}, samples=400, t_end=200.0,
    stable=rigid.no_flip(3), start=rigid.Start(spin=1.0, axis=3, tilt=0.1), rng=1,
    method="rk4", step=0.05,
"""


# Progress


def test_without_a_terminal_not_one_byte_is_written() -> None:
    code = "".join(f"{SHORT}progress={one})\n" for one in (False, None, "lambda progress: None"))
    done = python_process(f"{IMPORTS}{code}assert result.complete")
    assert (done.stdout, done.stderr) == ("", "")


def test_in_a_narrow_terminal_the_bar_keeps_ten_cells() -> None:
    code = f"{IMPORTS}{SHORT}progress=None)"
    with in_terminal("-c", code, columns=50) as (process, reader):
        shown = read(reader).decode()
        assert process.wait(PATIENCE) == 0
    last = shown.rstrip().rpartition("\r")[2]
    assert last.startswith("100%|")
    assert len(last) <= 50
    assert last.count("\u2588") >= 10
    assert last.endswith("00:00 left, 400 failed")


@pytest.mark.parametrize("units", [1, 3, 100])
def test_a_callable_gets_records_that_only_grow(units: int) -> None:
    records: list[rigid.Progress] = []
    axes = {"I1": [0.1, 0.9, 1.2, 5.0]}  # the outer two are impossible and cost nothing
    with in_blocks(units):
        result = small_map(
            axes=axes,
            start=rigid.Start(spin=1.0, axis=2, noise=rigid.normal(0.1)),
            samples=150,  # of 64, 64 and 22
            progress=records.append,
        )
    done = [record.done for record in records]
    assert done[-1] == 300 == result.samples.sum()
    assert len(done) == -(-6 // units)
    assert (np.diff([0, *done]) > 0).all()
    assert {record.total for record in records} == {300}
    elapsed = [record.elapsed for record in records]
    assert (np.diff([0.0, *elapsed]) >= 0.0).all()
    assert elapsed[-1] <= result.elapsed
    for record in records:
        assert record.rate == record.done / record.elapsed
        left = record.total - record.done
        assert record.remaining == pytest.approx(left / record.rate, rel=1e-12, abs=1e-300)
    assert {record.failures for record in records} == {0}


def test_failures_are_counted_while_it_runs() -> None:
    records: list[rigid.Progress] = []
    with in_blocks(1):
        result = small_map(
            axes={"spin": [1.0, 2.0, 1e200]},
            start=rigid.Start(spin=1.0, axis=3, tilt=0.1),
            samples=10,
            progress=records.append,
        )
    # The lattice of every second pixel comes first.
    assert [record.failures for record in records] == [0, 10, 10]
    assert result.failed.sum() == 10


def test_a_record_before_the_first_body_promises_nothing() -> None:
    record = rigid.Progress(done=0, total=10, elapsed=0.0, failures=0)
    assert record.rate == 0.0
    assert record.remaining == float("inf")
    assert rigid.Progress(done=10, total=10, elapsed=0.0, failures=0).remaining == 0.0


# Blocks


class Nowhere(Memory):
    """Keeps no rows."""

    def append(self, *_: object) -> None:
        """Forget rows."""


def test_blocks_settle_near_a_third_of_a_second_and_stay_short() -> None:
    # A machine that needs 1 ms a unit in the first half and 1 ms / 100 in the second.
    intake = Intake(Nowhere(spec_of(samples=1)), lambda *_: None, threads=1)
    seconds = []
    for round_ in range(60):
        cost, units = (1e-3 if round_ < 30 else 1e-5), intake.units
        seconds.append(units * cost)
        costs = np.full(units, 1e9 * cost, np.float32)
        intake.take(Block(np.zeros(units, ROW), costs, NO_BINS))
    assert max(seconds) <= 4.0 * SHORTEST
    assert seconds[20] == pytest.approx(SHORTEST, rel=0.1)
    # What once was costly may come again: a block stays short enough for that.
    assert intake.units * 1e-3 <= 4.0 * SHORTEST * 1.01


def taken(
    costs: list[float],
    monkeypatch: pytest.MonkeyPatch,
    *,
    threads: int = 1,
    append: float = 0.0,
    seconds: float | None = None,
    blocks: int = 1,
) -> int:
    """Units of the next block after some whose units cost these times and took so long to keep."""
    clock = 0.0

    class Slow(Nowhere):
        def append(self, *_: object) -> None:
            nonlocal clock
            clock += append

    monkeypatch.setattr("rigid.store.drive.time.perf_counter", lambda: clock)
    intake = Intake(Slow(spec_of(samples=1)), lambda *_: None, threads)
    for _ in range(blocks):
        cost = np.resize(1e9 * np.array(costs), intake.units).astype(np.float32)
        intake.take(Block(np.zeros(intake.units, ROW), cost, NO_BINS), seconds)
    return intake.units


def test_a_block_is_as_long_as_its_units_and_the_disk_allow(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The first has sixteen bodies a thread, and each at most eight times the one before."""
    assert Intake(Nowhere(spec_of(samples=4)), lambda *_: None, threads=2).units == 8
    assert Intake(Nowhere(spec_of(samples=100)), lambda *_: None, threads=1).units == 1
    assert taken([1e-9], monkeypatch) == 8 * 16
    assert taken([0.0], monkeypatch, blocks=2) == 8 * 8 * 16
    # A third of a second, or fifty times the time to keep a block, up to a minute.
    for append, wanted in ((0.0, 0.3), (0.006, 0.3), (0.02, 1.0), (1.0, 50.0), (10.0, 60.0)):
        units = taken([0.01], monkeypatch, append=append, blocks=5)
        assert units == pytest.approx(wanted / 0.01, abs=1.0)
    # The wall time where it is known; else the processor time over the threads.
    assert taken([1e-6], monkeypatch, seconds=0.6) == 8
    assert taken([0.01], monkeypatch, threads=4, blocks=3) == pytest.approx(120, abs=1)
    # One costly unit: four such blocks of its kind at most.
    assert taken([0.1, *[0.0] * 15], monkeypatch) == pytest.approx(12, abs=1)
