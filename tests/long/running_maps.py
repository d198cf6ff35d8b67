"""Writers of a running map are killed, its logs are damaged, and the map is whole all the same.

    python tests/long/running_maps.py [--kills 100] [--flips 100000] [--seed 1]

Kills at random moments and by limits of the file size; every truncation of a log; flipped bits;
zeroed, exchanged and missing pages. Fails if a wrong row is ever read, if a lost row is not told,
if anything is raised, if a row is computed twice, or if the map differs from that of a quiet run.
"""

import argparse
import io
import os
import resource
import signal
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "shared"))

from rigid.store import drive as driving
from rigid.store.log import Found, read_log
from rigid.store.rows import Block, Table
from rigid.store.running import Folder
from stores import SPEC, go_on

#: Longest life of a writer (s): it writes a record each 0.5 ms.
LONGEST = 0.06


def killed(path: Path, seconds: float, limit: int | None) -> None:
    """One sitting in a process that is killed after some time, or when its log is so long."""
    writer = os.fork()
    if not writer:
        if limit is not None:
            signal.signal(signal.SIGXFSZ, signal.SIG_DFL)  # Python ignores it
            resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))
        real = driving.compute

        def slow(*arguments: object, **options: object) -> object:
            time.sleep(0.0005)
            return real(*arguments, **options)  # type: ignore[arg-type]

        driving.GROWTH, driving.compute = 1, slow  # type: ignore[assignment]
        try:
            go_on(path)
        finally:
            os._exit(0)
    if limit is None:
        time.sleep(seconds)
        os.kill(writer, signal.SIGKILL)
    os.waitpid(writer, 0)


def kills(count: int, random: np.random.Generator, folder: Path, quiet: bytes) -> int:
    """How many runs of killed sittings end otherwise than the quiet run."""
    wrong = sittings = 0
    path = folder / "run-0"
    for number in range(count):
        by_size = number % 6 == 5
        limit = int(random.integers(512, 20_000)) if by_size else None
        killed(path, float(random.uniform(0.0, LONGEST)), limit)
        sittings += 1
        if Folder.is_at(path) and Folder(path).table.known.sum() < 150 and sittings < 20:
            continue
        go_on(path)
        table = Folder(path).table
        wrong += table.rows.tobytes() != quiet or table.twice > 0
        path, sittings = folder / f"run-{number + 1}", 0
    return wrong


class Log:
    """A log in memory, and what is wrong about what is read from its damaged copies."""

    def __init__(self, folder: Path, quiet: Folder) -> None:
        self.run = Folder.at(folder, SPEC)
        self.run.begin()
        for block in np.array_split(quiet.table.rows[quiet.table.known], 13):
            self.run.append(Block(block.copy(), np.ones(len(block), "<f4")))
        self.run.end("complete")
        (path,) = (folder / "logs").iterdir()
        self.content = path.read_bytes()
        self.rows, self.whole = quiet.table.rows, int(quiet.table.known.sum())
        self.lost = self.wrong = self.silent = 0

    def read(self, content: bytes, *, may_end: bool = False) -> None:
        """Read a damaged copy; one that ends early tells its loss by its missing end."""
        found, table = Found(), Table(self.run.head)
        for block in read_log(io.BytesIO(content), self.run.head.seal, found):
            table.add(block, "log")
        known = table.known
        self.wrong += table.rows[known].tobytes() != self.rows[known].tobytes()
        if known.sum() < self.whole:
            self.lost += 1
            self.silent += not (found.damage or (may_end and found.end is None))


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kills", type=int, default=100)
    parser.add_argument("--flips", type=int, default=100_000)
    parser.add_argument("--seed", type=int, default=1)
    chosen = parser.parse_args()
    random = np.random.default_rng(chosen.seed)
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        go_on(folder / "quiet")
        quiet = Folder(folder / "quiet")
        wrong = kills(chosen.kills, random, folder, quiet.table.rows.tobytes())
        print(f"{chosen.kills} writers killed: {wrong} maps differ from the quiet run", flush=True)

        log = Log(folder / "log", quiet)
        content = log.content
        for length in range(len(content)):
            log.read(content[:length], may_end=True)
        print(f"{len(content)} truncations: {told(log)}", flush=True)
        for place_of_bit in random.integers(0, 8 * len(content), chosen.flips):
            copy = bytearray(content)
            copy[place_of_bit // 8] ^= 1 << int(place_of_bit % 8)
            log.read(bytes(copy))
        print(f"{chosen.flips} flipped bits: {told(log)}", flush=True)
        for number in range(3000):
            begin = int(random.integers(0, len(content)))
            length = min(int(random.integers(1, 4097)), len(content) - begin)
            page = (bytes(length), random.bytes(length), b"")[number % 3]
            log.read(content[:begin] + page + content[begin + length :])
        print(f"3000 damaged pages: {told(log)}", flush=True)
    return int(wrong + log.wrong + log.silent > 0)


def told(log: Log) -> str:
    """The counts so far."""
    return f"{log.lost} lost rows so far, {log.silent} in silence; {log.wrong} gave wrong rows"


if __name__ == "__main__":
    raise SystemExit(main())
