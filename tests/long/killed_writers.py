"""A map is written again and again, and its writer is killed: the file is whole all the same.

    python tests/long/killed_writers.py [--kills 1000] [--seed 1]

Fails if the file is ever anything but one of the two maps that the writers write, or if the next
writer leaves what the killed ones left beside it.
"""

import argparse
import os
import signal
import sys
import tempfile
import time
from pathlib import Path
from random import Random

sys.path.insert(0, str(Path(__file__).parents[1] / "shared"))

import rigid
from small_maps import small_map

#: Longest life of a writer (s): some writes.
LONGEST = 0.02


def write_until_killed(maps: list[rigid.StabilityMap], target: Path) -> None:
    """Never returns."""
    while True:
        for one in maps:
            one.save(target)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kills", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1)
    chosen = parser.parse_args()
    rng = Random(chosen.seed)
    maps = [small_map(rng=seed) for seed in (1, 2)]
    with tempfile.TemporaryDirectory() as folder:
        target = Path(folder, "map.npz")
        whole = {one.save(target).read_bytes() for one in maps}
        torn = 0
        for _ in range(chosen.kills):
            writer = os.fork()
            if not writer:
                write_until_killed(maps, target)
            time.sleep(rng.uniform(0.0, LONGEST))
            os.kill(writer, signal.SIGKILL)
            os.waitpid(writer, 0)
            torn += target.read_bytes() not in whole
        maps[0].save(target)
        left = len(list(Path(folder).iterdir())) - 1
    print(f"{chosen.kills} writers killed: {torn} torn files, {left} scratch files left")
    return int(torn + left > 0)


if __name__ == "__main__":
    sys.exit(main())
