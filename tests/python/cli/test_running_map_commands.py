"""The commands of running maps: what they do, print and return."""

import errno
import json
import os
import re
import signal
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rigid
from interrupts import sigint
from map_texts import SMALL
from printed_text import unwrapped
from processes import Capture
from rigid.cli import main
from rigid.store.disk import Disk
from rigid.store.rows import compute

SPEC = SMALL.replace("values = [0.4, 0.9, 1.1, 1.3]", "from = 0.4\nto = 1.4\ncount = 12").replace(
    "count = 3", "count = 8"
)

QUIET = "--no-progress"

pytestmark = pytest.mark.usefixtures("folder", "brief")


def test_a_map_is_stored_and_written(capsys: Capture) -> None:
    assert main(["map", "small.toml", "--store", "run.rigid", QUIET]) == 0
    assert main(["map", "small.toml", "--out", "plain", QUIET]) == 0
    assert Path("small.npz").read_bytes() == Path("plain.npz").read_bytes()
    assert Path("small.png").exists()
    assert capsys.readouterr().err == ""
    assert main(["map", "small.toml", "--store", "run.rigid", "--force", QUIET]) == 0
    assert len(list(Path("run.rigid/logs").iterdir())) == 1


def test_parts_wait_for_each_other(capsys: Capture) -> None:
    assert main(["map", "small.toml", "--store", "run.rigid", "--part", "1/2", QUIET]) == 75
    told = capsys.readouterr().err
    assert re.fullmatch(
        r"rigid: this part is done, others are missing; \d+ of \d+ pixels are stored; "
        r"rigid resume run.rigid computes them all\n",
        told,
    )
    assert not Path("small.npz").exists()
    assert main(["resume", "run.rigid", "--part", "2/2", QUIET]) == 0
    assert Path("run.npz").exists()
    assert main(["map", "small.toml", QUIET]) == 0
    assert main(["diff", "run.npz", "small.npz"]) == 0


def test_of_parts_that_end_together_one_writes_the_map(capsys: Capture) -> None:
    """Both find that nothing is missing."""
    for k in "12":
        main(["map", "small.toml", "--store", "run.rigid", "--part", f"{k}/2", QUIET, "--out", k])
    assert Path("2.npz").exists()
    for log in Path("run.rigid/logs").iterdir():
        if b'"part":"1/2"' in log.read_bytes():
            log.unlink()  # as if this part ended only now
    capsys.readouterr()
    again = ["map", "small.toml", "--store", "run.rigid", "--out", "3", QUIET]
    assert main([*again, "--part", "1/2"]) == 0
    told = capsys.readouterr().out
    assert told.endswith("is complete, another part writes it; rigid resume run.rigid does too\n")
    assert not Path("3.npz").exists()
    assert main(again) == 0


def test_the_speed_is_that_of_what_this_command_computed(capsys: Capture) -> None:
    main(["map", "small.toml", "--store", "run.rigid", "--part", "1/4", QUIET])
    capsys.readouterr()
    assert main(["resume", "run.rigid", QUIET]) == 0
    lines = capsys.readouterr().out.splitlines()
    speed = next(line for line in lines if line.startswith("speed"))
    found: Any = re.search(r"([\d,]+) of ([\d,]+) bodies in", speed)
    every = int(rigid.load_map("run.npz").samples.sum())
    assert [int(number) for number in found.groups()] == [0.75 * every, every]
    assert main(["resume", "run.rigid", "--out", "again", QUIET]) == 0
    assert "speed       nothing was computed: all rows were stored" in capsys.readouterr().out


def test_a_folder_goes_on_from_inside(monkeypatch: pytest.MonkeyPatch, capsys: Capture) -> None:
    main(["map", "small.toml", "--store", "run.rigid", "--part", "1/2", QUIET])
    monkeypatch.chdir("run.rigid/logs")
    assert main(["resume", "..", QUIET]) == 0
    monkeypatch.chdir("..")
    assert main(["resume", ".", "--force", QUIET]) == 0
    assert rigid.load_map("../run.npz").complete
    capsys.readouterr()
    for command in ("resume", "explore"):
        assert main([command, "/"]) == 2
    told = capsys.readouterr().err
    assert told == (
        "rigid: / is no running map: there is no head.json\n"
        "rigid: / is not a stability map: it is a folder\n"
    )


def test_pieces_of_few_pixels_are_counted(capsys: Capture) -> None:
    text = SPEC.replace("count = 12", "count = 2").replace("count = 8", "count = 2")
    Path("small.toml").write_text(text.replace("samples = 10", "samples = 3000"))
    assert main(["map", "small.toml", "--store", "run.rigid", "--part", "2/3", QUIET]) == 75
    assert "; 0 of 2 pixels (2 of 6 pieces) are stored; rigid" in capsys.readouterr().err


def test_parts_are_merged(capsys: Capture) -> None:
    for k in "12":
        main(["map", "small.toml", "--store", f"{k}.rigid", "--part", f"{k}/2", QUIET])
    assert main(["merge", "2.rigid", "1.rigid", "--into", "all.rigid"]) == 0
    assert " 0 are missing" in capsys.readouterr().out
    assert main(["pack", "all.rigid", "all.npz"]) == 0
    assert rigid.load_map("all.npz").complete


def test_a_packed_map_replaces_no_file_by_chance(capsys: Capture) -> None:
    main(["map", "small.toml", "--store", "run.rigid", QUIET])
    Path("notes.npz").write_text("precious")
    assert main(["pack", "run.rigid", "notes.npz"]) == 2
    assert "OUT = 'notes.npz': exists; take another name" in capsys.readouterr().err
    assert Path("notes.npz").read_text() == "precious"
    assert main(["pack", "run.rigid", "map.txt"]) == 2
    assert "OUT = 'map.txt': must end in .npz or .zarr" in capsys.readouterr().err
    assert main(["pack", "run.rigid", "notes.npz", "--force"]) == 0
    assert rigid.load_map("notes.npz").complete


def test_an_option_of_another_command_is_no_hint(capsys: Capture) -> None:
    with pytest.raises(SystemExit):
        main(["status", "run.rigid", "--json"])
    assert capsys.readouterr().err.endswith("--json: this command has no such option\n")


def damage_rows(folder: str) -> None:
    """Flip a bit in the first row of a store."""
    log = next(Path(folder, "logs").iterdir())
    content = bytearray(log.read_bytes())
    table = content.index(b"\x93NUMPY")
    content[table + 10 + int.from_bytes(content[table + 8 : table + 10], "little")] ^= 1
    log.write_bytes(content)


def test_an_unfinished_map_is_packed_only_if_that_is_asked_for(capsys: Capture) -> None:
    main(["map", "small.toml", "--store", "run.rigid", "--part", "1/4", QUIET])
    result = rigid.open_store("run.rigid").result()
    done, possible = (result.samples > 0).sum(), (result.status == 0).sum()
    capsys.readouterr()
    assert main(["pack", "run.rigid", "part.npz"]) == 75
    told = capsys.readouterr()
    assert told.out == ""
    assert told.err == (
        f"rigid: {done} of {possible} pixels are stored, nothing is written; "
        "rigid resume run.rigid goes on, --partial writes what there is\n"
    )
    assert not Path("part.npz").exists()
    assert main(["pack", "run.rigid", "part.npz", "--partial"]) == 0
    told = capsys.readouterr()
    assert told.out == "part.npz\n"
    assert f"{done} of {possible} pixels are stored, the map written is partial" in told.err
    loaded = rigid.load_map("part.npz")
    assert (loaded.complete, int(loaded.samples.sum())) == (False, done * 10)


def test_a_damaged_map_is_no_finished_one(capsys: Capture) -> None:
    main(["map", "small.toml", "--store", "run.rigid", QUIET])
    possible = int((rigid.load_map("small.npz").status == 0).sum())
    assert main(["status", "run.rigid"]) == 0
    assert main(["pack", "run.rigid", "whole.npz"]) == 0
    damage_rows("run.rigid")
    capsys.readouterr()
    assert main(["status", "run.rigid"]) == 1
    assert "damage      " in capsys.readouterr().out
    assert main(["pack", "run.rigid", "damaged.npz"]) == 75
    told = capsys.readouterr().err
    found: Any = re.match(r"rigid: (\d+) of (\d+) pixels are stored, nothing is written", told)
    assert int(found[1]) < int(found[2]) == possible
    # What is damaged is computed again: the log stays as it is, the map is whole.
    assert main(["resume", "run.rigid", "--out", "again", QUIET]) == 0
    assert main(["pack", "run.rigid", "again2.npz"]) == 0
    assert Path("again2.npz").read_bytes() == Path("whole.npz").read_bytes()
    assert main(["status", "run.rigid"]) == 1


def test_the_status_is_told(capsys: Capture) -> None:
    main(["map", "small.toml", "--store", "run.rigid", "--part", "1/2", QUIET])
    capsys.readouterr()
    assert main(["status", "run.rigid"]) == 0
    told = unwrapped(capsys.readouterr().out)
    assert re.search(r"units +\d+ of \d+ are stored, \d+ are missing", told)
    assert re.search(
        r"writer +\S+\.tar: part 1/2, \d+ units in .* rigid .*; has done its part", told
    )


def test_numbers_are_verified(capsys: Capture) -> None:
    main(["map", "small.toml", "--store", "run.rigid", QUIET])
    capsys.readouterr()
    assert main(["verify", "run.rigid", "--all"]) == 0
    assert "0 differ" in capsys.readouterr().out
    assert main(["verify", "small.npz", "--share", "0.5", "--seed", "3"]) == 0
    damage_rows("run.rigid")
    assert main(["verify", "run.rigid"]) == 1
    assert "damage: " in capsys.readouterr().out


def test_differences_are_told(capsys: Capture) -> None:
    for seed in "56":
        main(["map", "small.toml", "--seed", seed, "--out", seed, QUIET])
    capsys.readouterr()
    assert main(["diff", "5.npz", "6.npz"]) == 1
    assert capsys.readouterr().out.startswith("seed: 5 and 6\n")
    assert main(["diff", "5.npz", "5.npz"]) == 0
    assert capsys.readouterr().out == "no difference\n"


def test_a_file_asks_for_sequential_and_refined_maps() -> None:
    text = SPEC.replace("samples = 10", "half_width = 0.1\nrefine = 4\nbudget = 100000")
    Path("small.toml").write_text(text)
    assert main(["map", "small.toml", QUIET]) == 0
    spec = rigid.load_map("small.npz").spec
    assert (spec.samples, spec.half_width, spec.refine, spec.budget) == (128, 0.1, 4, 100_000)
    options = ["--half-width", "0.25", "--refine", "3", "--budget", "5000", "--out", "other"]
    assert main(["map", "small.toml", *options, QUIET]) == 0
    spec = rigid.load_map("other.npz").spec
    assert (spec.samples, spec.half_width, spec.refine, spec.budget) == (64, 0.25, 3, 5000)
    assert main(["map", "small.toml", "--samples", "7", "--out", "fixed", QUIET]) == 0
    spec = rigid.load_map("fixed.npz").spec
    assert (spec.samples, spec.half_width) == (7, None)


def test_a_budget_that_is_spent_is_no_interruption(capsys: Capture) -> None:
    text = SPEC.replace("samples = 10", "half_width = 0.1\nbudget = 1500")
    Path("small.toml").write_text(text)
    for store in ([], ["--store", "run.rigid", "--out", "stored"]):
        assert main(["map", "small.toml", *store, QUIET]) == 0
        output, errors = capsys.readouterr()
        told = unwrapped(output)
        assert errors == ""
        assert re.search(
            r"until the share is known to within 0.1: so in \d+ pixels, not in \d+; seed", told
        )
        assert re.search(r"1,\d+ in \d+ of \d+ pixels; the budget of 1,500 omits \d", told)
    result = rigid.load_map("small.npz")
    assert not result.complete
    assert 1500 - result.spec.samples < result.samples.sum() <= 1500
    assert Path("stored.npz").read_bytes() == Path("small.npz").read_bytes()
    assert main(["status", "run.rigid"]) == 0
    assert f"budget      spent: {result.cut} pixels are omitted" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("line", "instead", "options", "message"),
    [
        ("samples = 10", "samples = 10\nhalf_width = 0.1", [], "samples, half_width: give one of"),
        (
            "seed = 5",
            "",
            ["--store", "x", "--part", "1/2"],
            "--part: the file must tell the seed, ",
        ),
    ],
)
def test_requests_that_make_no_sense_are_refused(
    capsys: Capture, line: str, instead: str, options: list[str], message: str
) -> None:
    Path("small.toml").write_text(SPEC.replace(line, instead))
    assert main(["map", "small.toml", *options, QUIET]) == 2
    assert message in capsys.readouterr().err


def test_another_map_in_the_folder_is_refused(capsys: Capture) -> None:
    main(["map", "small.toml", "--store", "run.rigid", QUIET])
    capsys.readouterr()
    assert main(["map", "small.toml", "--store", "run.rigid", "--seed", "6", "--force", QUIET]) == 2
    told = capsys.readouterr().err
    assert told.endswith(
        "run.rigid holds another map (there and asked for): seed: 5 and 6; take another folder\n"
    )
    assert main(["resume", "elsewhere", QUIET]) == 2
    assert "elsewhere: there is no such file or folder" in capsys.readouterr().err


def test_a_full_disk_is_resumed(monkeypatch: pytest.MonkeyPatch, capsys: Capture) -> None:
    real, left = Disk.write, iter(range(3))

    def write(disk: Disk, descriptor: int, buffers: list[bytes]) -> int:
        if next(left, None) is None:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return real(disk, descriptor, buffers)

    with monkeypatch.context() as full:
        full.setattr(Disk, "write", write)
        assert main(["map", "small.toml", "--store", "run.rigid", QUIET]) == 74
    told = capsys.readouterr().err
    assert "No space left on device" in told
    assert re.search(r"[1-9]\d* of \d+ pixels are stored; rigid resume run.rigid goes on", told)
    assert main(["resume", "run.rigid", "--out", "small", QUIET]) == 0
    assert rigid.open_store("run.rigid").status().twice == 0


@pytest.mark.parametrize(
    ("number", "code", "how"),
    [(signal.SIGINT, 130, "interrupted"), (signal.SIGTERM, 143, "terminated")],
)
def test_signals_end_the_command_and_keep_what_is_computed(
    number: signal.Signals, code: int, how: str, monkeypatch: pytest.MonkeyPatch, capsys: Capture
) -> None:
    """With the third block of one pixel."""
    before = iter(range(2))

    def interrupted(*arguments: Any, **options: Any) -> Any:
        if next(before, None) is None:
            os.kill(os.getpid(), number)
        return compute(*arguments, **options)

    with monkeypatch.context() as slow, sigint(signal.default_int_handler):
        slow.setattr("rigid.store.drive.compute", interrupted)
        slow.setattr("rigid.store.drive.GROWTH", 1)
        stored = ["--store", "run.rigid", "--threads", "1", QUIET]
        assert main(["map", "small.toml", *stored]) == code
    told = capsys.readouterr().err
    assert re.fullmatch(
        rf"rigid: {how}; \d+ of \d+ pixels are stored; rigid resume run.rigid goes on\n", told
    )
    store = rigid.open_store("run.rigid")
    done = int(np.sum(store.result().samples > 0))
    assert 0 < done < 96
    (writer,) = store.status().writers
    assert (writer["reason"], writer["units"]) == (how, done)
    assert main(["resume", "run.rigid", "--out", "small", QUIET]) == 0
    assert rigid.open_store("run.rigid").status().twice == 0


def test_progress_is_told_line_by_line_where_there_is_no_terminal(
    monkeypatch: pytest.MonkeyPatch, capsys: Capture
) -> None:
    monkeypatch.setattr("rigid._checks.progress.SECONDS_BETWEEN_LINES", 0.0)
    for part, code, who in (("1/2", 75, "part 1/2: "), (None, 0, "")):
        more = [] if part is None else ["--part", part]
        assert main(["map", "small.toml", "--store", "run.rigid", *more]) == code
        lines = [
            line
            for line in capsys.readouterr().err.splitlines()
            if "others are missing" not in line
        ]
        assert lines
        for line in lines:
            assert re.fullmatch(rf"rigid: {who}\d+% done after \d+ s, about \d+ s to go", line)


def test_a_package_that_is_missing_is_named_in_a_line(
    capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    main(["map", "small.toml", "--store", "run.rigid", QUIET])
    capsys.readouterr()
    for name in ("zarr", "zarr.codecs", "distributed"):
        monkeypatch.setitem(sys.modules, name, None)
    assert main(["pack", "run.rigid", "run.zarr"]) == 2
    assert capsys.readouterr().err.startswith("rigid: a .zarr needs zarr: pip install ")
    stored = ["--store", "run.rigid", "--force", QUIET]
    assert main(["map", "small.toml", "--dask", "tcp://x:1", *stored]) == 2
    assert capsys.readouterr().err.startswith("rigid: --dask needs Dask: pip install ")
    assert not Path("run.zarr").exists()


def test_a_check_tells_what_this_call_would_compute(capsys: Capture) -> None:
    """Without other parts, and without what is stored; and how large the files become."""
    ask = ["map", "small.toml", "--store", "run.rigid", "--json"]

    def facts(*options: str) -> dict[str, Any]:
        capsys.readouterr()
        assert main([*ask, "--check", *options]) == 0
        found: dict[str, Any] = json.loads(capsys.readouterr().out)
        return found

    whole = facts()
    assert (whole["pixels"], whole["bodies"], whole["at_most"]) == (80, 800, False)
    assert sum(facts("--part", f"{k}/3")["bodies"] for k in (1, 2, 3)) == 800
    assert not Path("run.rigid").exists()
    assert main([*ask, QUIET, "--part", "1/4"]) == 75
    before = sum(log.stat().st_size for log in Path("run.rigid/logs").iterdir())
    rest = facts()
    assert (rest["pixels"], rest["bodies"]) == (60, 600)
    assert facts("--part", "1/4")["bodies"] == 0
    assert facts("--part", "2/4")["pixels"] == 20
    assert main([*ask, "--check", "--seed", "6"]) == 2
    assert "holds another map (there and asked for): seed: 5 and 6" in capsys.readouterr().err
    assert main([*ask, QUIET]) == 0
    written = sum(log.stat().st_size for log in Path("run.rigid/logs").iterdir()) - before
    # Headers of the log and of its records besides.
    assert rest["bytes"]["store"] < written < rest["bytes"]["store"] + 2**15
    assert rest["bytes"]["data"] >= Path("small.npz").stat().st_size > 0.5 * rest["bytes"]["data"]


def test_a_check_tells_the_folder_too(capsys: Capture) -> None:
    assert main(["map", "small.toml", "--store", "run.rigid", "--check"]) == 0
    assert capsys.readouterr().out.endswith("would write small.npz, small.png, run.rigid\n")
    assert not Path("run.rigid").exists()


def test_a_map_without_a_seed_goes_on_with_that_of_its_folder(capsys: Capture) -> None:
    Path("small.toml").write_text(SPEC.replace("seed = 5", ""))
    assert main(["map", "small.toml", "--store", "run.rigid", QUIET]) == 0
    capsys.readouterr()
    again = ["map", "small.toml", "--store", "run.rigid", "--force"]
    assert main([*again, "--check"]) == 0
    assert "bodies      0 in 0 pixels" in capsys.readouterr().out


def test_a_folder_that_cannot_be_made_is_told_alone(capsys: Capture) -> None:
    Path("file").touch()
    assert main(["map", "small.toml", "--store", "file/run", QUIET]) == 74
    told = capsys.readouterr().err
    assert re.fullmatch(r"rigid: \[Errno \d+\] .*'; rigid resume file/run goes on\n", told)


def test_a_cluster_that_does_not_answer_is_a_wrong_call(
    capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    distributed = pytest.importorskip("distributed")

    def silent(address: str) -> None:
        raise OSError("timed out")

    asked = ["map", "small.toml", "--store", "a.rigid", "--dask", "tcp://x:1", QUIET]
    monkeypatch.setattr(distributed, "Client", silent)
    assert main(asked) == 2
    assert "--dask = 'tcp://x:1': no scheduler answers (timed out)" in capsys.readouterr().err
    monkeypatch.setattr(distributed, "Client", lambda _: ThreadPoolExecutor(1))
    assert main(asked) == 0
    assert rigid.load_map("small.npz").complete
