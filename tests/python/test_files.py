"""Files are whole or not there: two writers, a full disk, names that are taken, links."""

import errno
import fcntl
import json
import os
import signal
import stat
import threading
import zipfile
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rigid
from processes import python_process
from rigid import _archive, _files
from rigid._checks.inputs import unreadable
from small_maps import assert_same_map, small_map

RUN = rigid.simulate(
    rigid.FreeBody(rigid.Body((1.0, 1.5, 2.0))), [0.1, 1.0, 0.1], t=np.linspace(0.0, 1.0, 3)
)
REPORT = rigid.report(
    rigid.FreeBody(rigid.Body((1.0, 1.5, 2.0))),
    [0.1, 1.0, 0.1],
    t_end=0.1,
    methods=["rk4"],
    bodies=1,
    errors=[1e-2],
    seconds=0.01,
    progress=False,
)

POINTS = rigid.poincare(rigid.HeavyTop.example(), [0.5, 0.25, 3.0], t_end=10.0)

GROWTH = rigid.lyapunov(
    rigid.FreeBody(rigid.Body((1.0, 1.5, 2.0))), [0.1, 1.0, 0.1], t=[10.0, 20.0, 30.0], check=False
)

FIT = rigid.fit(rigid.Body((1.0, 1.5, 2.0)), RUN.t, omega=RUN.omega, sigma=0.01, free="omega")

#: Every writer of the library, with the suffix of its files.
WRITERS: dict[str, tuple[str, Callable[[Path], Any]]] = {
    "map": (".npz", lambda path: small_map(samples=1, t_end=1.0).save(path)),
    "report": (".json", REPORT.save),
    "section": (".npz", POINTS.save),
    "run": (".npz", RUN.save),
    "growth": (".npz", GROWTH.save),
    "fit": (".npz", FIT.save),
    "map_table": (".csv", lambda path: small_map(samples=1, t_end=1.0).to_csv(path)),
    "run_table": (".csv", RUN.to_csv),
    "section_table": (".csv", POINTS.to_csv),
    "growth_table": (".csv", GROWTH.to_csv),
    "ephemeris": (".aem", lambda path: RUN.to_aem(path, epoch="2026-01-31")),
    "page": (".html", RUN.animate),
    "picture": (".gif", partial(RUN.animate, size=64)),
    "explorer": (".html", small_map(samples=1, t_end=1.0).explore),
}


@pytest.fixture(params=WRITERS)
def writer(request: pytest.FixtureRequest) -> tuple[str, Callable[[Path], Any]]:
    return WRITERS[request.param]


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


# What was there


def test_a_new_file_obeys_the_umask_and_an_old_one_keeps_its_mode(
    writer: tuple[str, Callable[[Path], Any]], tmp_path: Path
) -> None:
    suffix, write = writer
    path = tmp_path / f"a{suffix}"
    before = os.umask(0o022)
    try:
        assert write(path) == path
        assert stat.S_IMODE(path.stat().st_mode) == 0o644
        path.chmod(0o666)
        write(path)
        assert stat.S_IMODE(path.stat().st_mode) == 0o666
    finally:
        os.umask(before)
    assert names(tmp_path) == [path.name]


ENDINGS = {
    "map": ".npz or .zarr",
    "report": ".json",
    **dict.fromkeys(("section", "run", "growth", "fit"), ".npz"),
    **dict.fromkeys((name for name in WRITERS if name.endswith("_table")), ".csv or .txt"),
    "ephemeris": ".aem or .txt",
    **dict.fromkeys(("page", "picture"), ".html, .gif, .webp or .mp4"),
    "explorer": ".html",
}


@pytest.mark.parametrize("name", WRITERS)
@pytest.mark.parametrize("ending", [".nc", ".csv", "", ".npz"])
def test_a_name_that_promises_another_kind_of_file_is_refused(
    name: str, ending: str, tmp_path: Path
) -> None:
    """Not an archive of NumPy that is called ``run.csv``."""
    if ending and ending in ENDINGS[name]:
        return
    path = tmp_path / f"a{ending}"
    with pytest.raises(ValueError, match=r"^path = ") as caught:
        WRITERS[name][1](path)
    hint = {
        ".csv": "; to_csv of a run, a map or points writes a table",
        ".nc": "; to_xarray().to_netcdf of a run, a map or points writes netCDF",
    }.get(ending, "")
    known = hint if ".npz" in ENDINGS[name] else ""
    assert str(caught.value) == f"path = {str(path)!r}: must end in {ENDINGS[name]}{known}"
    assert names(tmp_path) == []


def test_a_missing_file_is_compared_with_those_beside_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "run.npz").touch()
    monkeypatch.chdir(tmp_path)
    for path in ("rum.npz", tmp_path / "rum.npz"):
        words = f"{path}: there is no such file or folder; did you mean 'run.npz'?"
        assert unreadable(path, FileNotFoundError()) == words
    nowhere = unreadable("none/run.npz", FileNotFoundError())
    assert nowhere == "none/run.npz: there is no such file or folder"


def make_link(path: Path) -> None:
    path.symlink_to(path.with_name("linked"))


def make_link_to_nothing(path: Path) -> None:
    path.symlink_to(path.with_name("nothing"))


@pytest.mark.parametrize(
    ("name", "make", "kind"),
    [
        *((name, os.mkdir, "a directory") for name in WRITERS),
        ("run", os.mkfifo, "a pipe"),
        ("run", make_link, "a symbolic link"),
        ("run", make_link_to_nothing, "a symbolic link"),
    ],
)
def test_what_is_no_regular_file_is_left_alone(
    name: str, make: Callable[[Path], None], kind: str, tmp_path: Path
) -> None:
    suffix, write = WRITERS[name]
    path = tmp_path / f"a{suffix}"
    (tmp_path / "linked").write_bytes(b"precious")
    make(path)
    kept = path.lstat()
    with pytest.raises(FileExistsError) as caught:
        write(path)
    assert str(caught.value) == f"path = {str(path)!r}: must be new or a regular file, it is {kind}"
    assert path.lstat() == kept
    assert (tmp_path / "linked").read_bytes() == b"precious"
    assert names(tmp_path) == sorted([path.name, "linked"])


def test_files_of_the_user_beside_a_map_are_left_alone(tmp_path: Path) -> None:
    """Neither the file nor the target of a link at the scratch name of earlier versions."""
    (tmp_path / "precious").write_bytes(b"precious")
    (tmp_path / "a.npz.part").symlink_to("precious")
    (tmp_path / "b.npz.part").write_bytes(b"mine")
    for name in ("a.npz", "b.npz"):
        small_map(samples=1, t_end=1.0).save(tmp_path / name)
        assert not (tmp_path / name).is_symlink()
    assert (tmp_path / "a.npz.part").is_symlink()
    assert (tmp_path / "precious").read_bytes() == b"precious"
    assert (tmp_path / "b.npz.part").read_bytes() == b"mine"


def test_a_link_at_the_scratch_name_is_not_followed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Even if somebody else could guess the name."""
    monkeypatch.setattr(os, "urandom", lambda count: bytes(count))
    (tmp_path / "precious").write_bytes(b"precious")
    (tmp_path / f".rigid-{'00' * 16}.part").symlink_to("precious")
    with pytest.raises(FileExistsError, match=r"a\.txt"), _files.published(tmp_path / "a.txt"):
        pytest.fail("the scratch file is not ours")
    assert (tmp_path / "precious").read_bytes() == b"precious"
    assert not (tmp_path / "a.txt").exists()


def test_a_folder_that_is_not_there_is_named(
    writer: tuple[str, Callable[[Path], Any]], tmp_path: Path
) -> None:
    suffix, write = writer
    with pytest.raises(FileNotFoundError) as caught:
        write(tmp_path / "nowhere" / f"a{suffix}")
    assert caught.value.filename == str(tmp_path / "nowhere" / f"a{suffix}")


def test_an_interruption_leaves_the_old_file(tmp_path: Path) -> None:
    path = tmp_path / "a.txt"
    path.write_bytes(b"old")

    def interrupted() -> None:
        with _files.published(path) as file:
            file.write(b"new")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert path.read_bytes() == b"old"
    assert names(tmp_path) == ["a.txt"]


def test_file_and_folder_are_synchronised_around_the_renaming(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """So that a power failure leaves the old file or the whole new one."""
    events: list[str] = []
    fsync, replace = os.fsync, os.replace

    def synchronise(descriptor: int) -> None:
        events.append("folder" if stat.S_ISDIR(os.fstat(descriptor).st_mode) else "file")
        fsync(descriptor)

    def rename(old: str, new: str) -> None:
        events.append("renamed")
        replace(old, new)

    monkeypatch.setattr(os, "fsync", synchronise)
    monkeypatch.setattr(os, "replace", rename)
    for suffix, write in WRITERS.values():
        events.clear()
        write(tmp_path / f"a{suffix}")
        assert events == ["file", "renamed", "folder"]


# Two writers


def test_two_writers_of_one_file_do_not_tear_it(tmp_path: Path) -> None:
    path = tmp_path / "map.npz"
    results = [small_map(samples=1, t_end=1.0, rng=seed) for seed in (1, 2)]
    errors: list[BaseException] = []

    def write(result: rigid.StabilityMap) -> None:
        try:
            for _ in range(40):
                result.save(path)
                loaded = rigid.load_map(path)
                assert_same_map(loaded, results[0 if loaded.spec == results[0].spec else 1])
        except BaseException as error:
            errors.append(error)

    threads = [threading.Thread(target=write, args=(result,)) for result in results]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not errors
    assert names(tmp_path) == ["map.npz"]


# Killed writers

#: Leaves its scratch file behind, as `kill -9` in the middle of a write does.
KILLED = """
import os, signal, sys
from rigid import _files

with _files.published(sys.argv[1]) as file:
    file.write(b"half")
    file.flush()
    os.kill(os.getpid(), signal.SIGKILL)
"""


def test_the_next_writer_removes_what_a_killed_one_left(tmp_path: Path) -> None:
    path = tmp_path / "a.txt"
    path.write_bytes(b"old")
    for _ in range(2):
        done = python_process(KILLED, str(path), check=False)
        assert done.returncode == -signal.SIGKILL
        assert path.read_bytes() == b"old"
        assert len(names(tmp_path)) == 2
    with _files.published(path) as file:
        file.write(b"new")
    assert path.read_bytes() == b"new"
    assert names(tmp_path) == ["a.txt"]


def test_the_scratch_file_of_a_living_writer_is_left_alone(tmp_path: Path) -> None:
    with _files.published(tmp_path / "a.txt") as slow:
        slow.write(b"slow")
        for _ in range(3):
            with _files.published(tmp_path / "b.txt") as quick:
                quick.write(b"quick")
        assert len(names(tmp_path)) == 2
    assert (tmp_path / "a.txt").read_bytes() == b"slow"
    assert names(tmp_path) == ["a.txt", "b.txt"]


def test_only_scratch_files_are_removed(tmp_path: Path) -> None:
    """Neither files with other names, nor what is no regular file."""
    (tmp_path / "precious").write_bytes(b"precious")
    kept = [".rigid-notes.part", f".rigid-{'0' * 32}.part.txt", f"rigid-{'0' * 32}.part"]
    for name in kept:
        (tmp_path / name).write_bytes(b"mine")
    link, pipe = (f".rigid-{digit * 32}.part" for digit in "12")
    (tmp_path / link).symlink_to("precious")
    os.mkfifo(tmp_path / pipe)
    with _files.published(tmp_path / "a.txt") as file:
        file.write(b"new")
    assert names(tmp_path) == sorted([*kept, link, pipe, "a.txt", "precious"])


def test_a_scratch_file_that_is_taken_away_before_it_is_locked_is_made_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Two writers begin at once, and one sweeps what the other has not locked yet."""
    flock = fcntl.flock
    removed: list[Path] = []

    def late(descriptor: int, operation: int) -> None:
        if not removed:
            removed.extend(tmp_path.glob(".rigid-*.part"))
            removed[0].unlink()
        flock(descriptor, operation)

    monkeypatch.setattr(fcntl, "flock", late)
    with _files.published(tmp_path / "a.txt") as file:
        file.write(b"whole")
    assert len(removed) == 1
    assert (tmp_path / "a.txt").read_bytes() == b"whole"
    assert names(tmp_path) == ["a.txt"]


# Archives


def test_archives_beyond_4_gb_are_written_and_their_directory_is_measured(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As ZIP does from some size on: the numbers of the directory are in another record."""
    monkeypatch.setattr(zipfile, "ZIP64_LIMIT", 100)
    numbers = np.arange(100.0)
    _archive.write_archive(tmp_path / "a.npz", {"one": numbers, "two": -numbers})
    with (tmp_path / "a.npz").open("rb") as file:
        # A header of 46 bytes, the name, and sizes of 8 bytes where the limit is passed: both of
        # the first, and of the second also its place.
        length = 2 * (46 + len("one.npy")) + 4 + 16 + 4 + 24
        archive = _archive.Archive(file, directory=length)
        assert (archive.read("two") == -numbers).all()
        with pytest.raises(_archive.ForeignError, match="is larger than"):
            _archive.Archive(file, directory=length - 1)


def test_arrays_of_another_version_of_the_format_are_refused(tmp_path: Path) -> None:
    with zipfile.ZipFile(tmp_path / "a.npz", "w") as archive, archive.open("x.npy", "w") as entry:
        np.lib.format.write_array(entry, np.ones(3), version=(2, 0))
    with (
        (tmp_path / "a.npz").open("rb") as file,
        pytest.raises(_archive.DamageError, match=r"x is not of version 1\.0 of the npy format"),
    ):
        _archive.Archive(file).read("x")


# A full disk

#: Every writer over an old file, in a process whose files cannot grow beyond some bytes.
FULL = """
import json, os, resource, sys
import test_files
from pathlib import Path

for name, (suffix, _) in test_files.WRITERS.items():
    Path(sys.argv[1], f"{name}{suffix}").write_bytes(b"old")
for limit in (300, 0):
    resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))
    found = {}
    for name, (suffix, write) in test_files.WRITERS.items():
        path = Path(sys.argv[1], f"{name}{suffix}")
        try:
            write(path)
        except OSError as error:
            found[name] = [error.errno, error.filename, path.read_bytes().decode()]
        try:
            test_files._files.require_room(path, 10**6)
        except OSError as error:
            found[f"room of {name}"] = [error.errno, error.filename, path.read_bytes().decode()]
    print(json.dumps(found))
print(*os.listdir(sys.argv[1]))
"""


def test_a_full_disk_is_an_error_that_names_the_file_and_leaves_the_old_one(
    tmp_path: Path,
) -> None:
    *every, left = python_process(FULL, str(tmp_path)).stdout.splitlines()
    paths = {name: str(tmp_path / f"{name}{suffix}") for name, (suffix, _) in WRITERS.items()}
    expected = {}
    for name, path in paths.items():
        expected[name] = expected[f"room of {name}"] = [errno.EFBIG, path, "old"]
    assert [json.loads(found) for found in every] == [expected] * 2
    assert sorted(left.split()) == sorted(Path(path).name for path in paths.values())


def test_a_system_without_a_call_is_no_obstacle(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Some cannot synchronise folders, some cannot look for room, some have no locks."""
    fsync = os.fsync

    def synchronise(descriptor: int) -> None:
        if stat.S_ISDIR(os.fstat(descriptor).st_mode):
            raise OSError(errno.EINVAL, "Invalid argument")
        fsync(descriptor)

    def allocate(*_: int) -> None:
        raise OSError(errno.EOPNOTSUPP, "Operation not supported")

    monkeypatch.setattr(os, "fsync", synchronise)
    monkeypatch.setattr(os, "posix_fallocate", allocate)
    monkeypatch.setattr(_files, "fcntl", None)
    _files.require_room(tmp_path / "a.txt", 100)
    with _files.published(tmp_path / "a.txt") as file:
        file.write(b"whole")
    assert (tmp_path / "a.txt").read_bytes() == b"whole"


def test_a_failing_disk_is_an_error(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(_: int) -> None:
        raise OSError(errno.EIO, "Input/output error")

    (tmp_path / "a.txt").write_bytes(b"old")
    monkeypatch.setattr(os, "fsync", fail)
    published = _files.published(tmp_path / "a.txt")
    with pytest.raises(OSError, match=r"Input/output error: .*a\.txt"), published as file:
        file.write(b"new")
    assert (tmp_path / "a.txt").read_bytes() == b"old"
    assert names(tmp_path) == ["a.txt"]


def test_room_is_looked_for_and_not_kept(tmp_path: Path) -> None:
    path = tmp_path / "a.npz"
    _files.require_room(path, 10**6)
    assert names(tmp_path) == []
    path.mkdir()
    with pytest.raises(FileExistsError, match="it is a directory"):
        _files.require_room(path, 1)
    with pytest.raises(FileNotFoundError, match=r"nowhere/b\.npz"):
        _files.require_room(tmp_path / "nowhere" / "b.npz", 1)
