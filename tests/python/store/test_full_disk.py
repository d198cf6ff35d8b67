"""A disk that is really full: a file system of 600 kB, which is enlarged later."""

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

import rigid
from processes import environment, python_command
from rigid.store.running import Folder

SMALL, LARGE = "600k", "20M"

#: 6400 units of about 160 bytes: they need 1 MB.
MAP = """
[scene]
kind = "free-body"
moments = [1, 1.5, 2]
[x]
name = "I2/I1"
from = 1.01
to = 1.99
count = 80
[y]
name = "noise"
from = 0.001
to = 0.1
count = 80
scale = "log"
[start]
spin = 1
axis = 2
noise = { kind = "uniform" }
[stable]
criterion = "no_flip"
[run]
samples = 4
t_end = 50
seed = 7
"""


def run(*command: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(command, capture_output=True, text=True, check=False)


@pytest.fixture
def disk(tmp_path: Path) -> Iterator[Path]:
    """The folder of a file system of 600 kB."""
    if not sys.platform.startswith("linux"):
        pytest.skip("only Linux mounts a tmpfs")
    place = tmp_path / "disk"
    place.mkdir()
    mounted = run("mount", "-t", "tmpfs", "-o", f"size={SMALL}", "tmpfs", str(place))
    if mounted.returncode:
        pytest.skip(f"a file system of {SMALL} cannot be mounted: {mounted.stderr.strip()}")
    try:
        yield place
    finally:
        run("umount", str(place)).check_returncode()


def rigid_command(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        python_command("-m", "rigid", *arguments, "--no-progress"),
        env=environment(),
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )


def test_a_map_on_a_full_disk_goes_on_when_there_is_room(disk: Path, tmp_path: Path) -> None:
    (tmp_path / "map.toml").write_text(MAP)
    full = rigid_command(tmp_path, "map", "map.toml", "--store", "disk/run", "--out", "a")
    assert full.returncode == 74
    assert "[Errno 28]" in full.stderr
    assert "pixels are stored; rigid resume disk/run goes on" in full.stderr
    stored = Folder(disk / "run").table
    assert 0 < stored.known.sum() < 6400
    assert rigid_command(tmp_path, "resume", "disk/run", "--out", "b").returncode == 74

    run("mount", "-o", f"remount,size={LARGE}", str(disk)).check_returncode()
    again = rigid_command(tmp_path, "resume", "disk/run", "--out", "c")
    assert again.returncode == 0, again.stderr
    table = Folder(disk / "run").table
    assert table.known.all()
    assert table.twice == 0
    known = stored.known
    assert table.rows[known].tobytes() == stored.rows[known].tobytes()

    assert rigid_command(tmp_path, "map", "map.toml", "--out", "quiet").returncode == 0
    assert (tmp_path / "c.npz").read_bytes() == (tmp_path / "quiet.npz").read_bytes()
    assert np.array_equal(rigid.load_map(tmp_path / "c.npz").samples, np.full((80, 80), 4))
