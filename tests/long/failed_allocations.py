"""One allocation of the core fails, each in turn: no wrong result, no corruption, no silent end.

    python tests/long/failed_allocations.py [--most 10000]

Each call is made once for each of its allocations, in a process of its own. The process gives the
right result, raises `MemoryError`, or ends with Rust's message that memory was not allocated: the
small allocations of the core know no other way. Those of NumPy and of the C library do not fail.
"""

import argparse
import ctypes
import os
import re
import signal
import subprocess
import sys
import tempfile
import traceback
from collections import Counter
from collections.abc import Callable
from pathlib import Path

SHARED = Path(__file__).parents[1] / "shared"
sys.path.insert(0, str(SHARED))

RIGHT, REFUSED, WRONG = 0, 10, 11

#: What a process says that ends because there is no memory.
CLEAN_END = re.compile(rb"memory allocation of \d+ bytes failed")


def calls() -> dict[str, Callable[[], bytes]]:
    """Calls of the core, with threads; each gives the bytes of its result."""
    import numpy as np

    import rigid

    rates = np.random.default_rng(1).standard_normal((70, 3))
    free = rigid.FreeBody(rigid.Body((1.0, 1.3, 1.9)))
    top = rigid.HeavyTop(rigid.Body((1.0, 1.3, 1.9)), mgl=1.2, com=(0.6, 0.0, 0.8))

    def stability_map() -> bytes:
        found = rigid.stability_map(
            rigid.FreeBody,
            axes={"I2/I1": [1.2, 1.5, 1.8]},
            samples=40,
            t_end=5.0,
            stable=rigid.no_flip(),
            method="rk4",
            check=0.1,
            rng=1,
            threads=3,
            progress=False,
        )
        return found.stable.tobytes() + found.earliest.tobytes()

    def steps() -> bytes:
        return rigid.simulate(top, rates, t=[0.5, 1.0], method="rk4", threads=3).omega.tobytes()

    def adaptive() -> bytes:
        run = rigid.simulate(top, rates, t=[0.5], method="taylor16", tolerance=1e-9, threads=3)
        return run.omega.tobytes()

    def closed_form() -> bytes:
        return rigid.simulate(free, rates, t=[0.5, 1.0], threads=3).omega.tobytes()

    def elliptic() -> bytes:
        return rigid.exact.carlson_rj(*np.abs(rates[:, :3].T), 2.0).tobytes()

    return {one.__name__: one for one in (stability_map, steps, adaptive, closed_form, elliptic)}


def outcome(call: Callable[[], bytes], right: bytes, number: int) -> int:
    """What becomes of a call whose allocation `number` fails."""
    libc = ctypes.CDLL(None)
    libc.fail_allocation(number)
    try:
        code = RIGHT if call() == right else WRONG
    except MemoryError:
        code = REFUSED
    finally:
        libc.fail_allocation(0)
    # After a refusal the same process computes what it should.
    return code if call() == right else WRONG


def ended(call: Callable[[], bytes], right: bytes, number: int, errors: Path) -> str:
    """How a process ended whose allocation `number` failed."""
    child = os.fork()
    if not child:
        os.dup2(os.open(errors, os.O_WRONLY | os.O_CREAT | os.O_TRUNC), 2)
        signal.alarm(60)
        try:
            os._exit(outcome(call, right, number))
        except BaseException:
            traceback.print_exc()
            os._exit(1)
    _, status = os.waitpid(child, 0)
    if os.WIFSIGNALED(status):
        said = errors.read_bytes()
        clean = os.WTERMSIG(status) == signal.SIGABRT and CLEAN_END.search(said)
        return "ended in words" if clean else f"signal {os.WTERMSIG(status)}: {said[-200:]!r}"
    names = {RIGHT: "right", REFUSED: "MemoryError", WRONG: "a wrong result"}
    code = os.WEXITSTATUS(status)
    return names.get(code, f"exit code {code}: {errors.read_bytes()[-200:]!r}")


def watch_the_core() -> None:
    """Number the allocations of the core alone."""
    from rigid import _core

    lines = Path("/proc/self/maps").read_text().splitlines()
    ranges = [line.split()[0].split("-") for line in lines if line.endswith(str(_core.__file__))]
    ends = (int(ranges[0][0], 16), int(ranges[-1][1], 16))
    ctypes.CDLL(None).watch(*map(ctypes.c_void_p, ends))


def survey(most: int) -> int:
    watch_the_core()
    libc = ctypes.CDLL(None)
    libc.allocations.restype = ctypes.c_long
    bad = 0
    with tempfile.TemporaryDirectory() as folder:
        for name, call in calls().items():
            right = call()
            libc.fail_allocation(0)
            call()
            count = min(libc.allocations(), most)
            found = Counter(
                ended(call, right, number, Path(folder, "errors")) for number in range(1, count + 1)
            )
            print(f"{name}: {count} allocations", *found.items(), sep="\n    ", flush=True)
            bad += sum(found.values()) - sum(
                found[good] for good in ("right", "MemoryError", "ended in words")
            )
    return int(bad > 0)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--most", type=int, default=10_000, help="allocations of a call")
    chosen = parser.parse_args()
    if "failing_malloc" in os.environ.get("LD_PRELOAD", ""):
        return survey(chosen.most)
    with tempfile.TemporaryDirectory() as folder:
        library = Path(folder, "failing_malloc.so")
        source = SHARED / "failing_malloc.c"
        subprocess.run(["cc", "-O1", "-shared", "-fPIC", source, "-o", library], check=True)
        environment = os.environ | {"LD_PRELOAD": str(library), "OPENBLAS_NUM_THREADS": "1"}
        return subprocess.run([sys.executable, *sys.argv], env=environment, check=False).returncode


if __name__ == "__main__":
    sys.exit(main())
