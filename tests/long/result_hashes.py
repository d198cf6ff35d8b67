"""Hashes of results, to show that a change of the code changes no bit of any result.

    python tests/long/result_hashes.py                 # compare with tests/golden/result_hashes.txt
    python tests/long/result_hashes.py --compare FILE  # compare with another file
    python tests/long/result_hashes.py --write FILE    # write all hashes to a file
    python tests/long/result_hashes.py --only core/run/top    # cases whose names begin so
    python tests/long/result_hashes.py --isa avx2 --isa scalar

The ``rigid`` that Python imports is used; ``PYTHONPATH=python`` takes that of this checkout.

Every case of ``result_cases.py`` and ``result_cases_textbook.py`` is computed through the public
interface, once for each instruction set in a process of its own (``RIGID_ISA``), and all arrays and
statuses of the case are hashed together. The instruction sets must agree with each other; then the
hashes are compared with those of the file. The exit code is 1 if a hash differs or a case of the
file was not computed. On one core AVX-512 takes about one minute, AVX2 two, and plain code, where
fma is a call of the C library, more than five. To see which case a change reaches, write a file
before the change and compare with it after the change.

The name of a case begins with one of three words:

``core/``
    The result is the same on every processor: it is computed by the core alone. Only these hashes
    are in ``tests/golden/result_hashes.txt``. The file was made by ``--write FILE`` and
    ``--portable``.
``machine/``
    A function of NumPy or of libm, such as ``np.sin`` or ``np.linalg.svd``, has a part in the
    result: error estimates, runs with an ``accuracy``, condition, reports, the textbook. Compare
    only with a file from the same machine and the same NumPy.
``attitude/``
    As ``machine/``, and the function normalises quaternions given by the user.

``--flip NAME`` flips the lowest bit of the first array of the cases whose names begin so. It proves
that the comparison can fail.
"""

import argparse
import os
import subprocess
import sys
import time
import traceback
from pathlib import Path

REFERENCE = Path(__file__).parents[1] / "golden" / "result_hashes.txt"
PORTABLE = "core/"
FAILED = "failed"
"""What stands in place of a hash where a case raised what it should not."""
KNOWN_ISAS = ("avx512", "avx2", "scalar")


def main() -> int:
    """Compute, compare, write; returns the exit code."""
    options = _parser().parse_args()
    if options.child:
        return _print_hashes(options.only, options.flip)
    import rigid

    available = rigid.build_info()["isa_available"]
    wanted = options.isa or list(KNOWN_ISAS)
    for isa in wanted:
        if isa not in available:
            print(f"NOT RUN: this processor or build has no {isa}")
    used = [isa for isa in wanted if isa in available]
    if not used:
        print("no instruction set left to run")
        return 1
    found = {isa: _of_isa(isa, options) for isa in used}
    first = found[used[0]]
    good = FAILED not in first.values()
    for isa in used[1:]:
        good &= _same(found[isa], first, isa, used[0])
    if options.write:
        kept = {n: h for n, h in first.items() if not options.portable or n.startswith(PORTABLE)}
        _write(Path(options.write), kept)
        print(f"{len(kept)} hashes written to {options.write}")
    if options.compare or not options.write:
        file = Path(options.compare or REFERENCE)
        known = {n: h for n, h in _read(file).items() if n.startswith(options.only)}
        good &= _same(first, known, f"this run ({used[0]})", str(file))
    print("all hashes agree" if good else "THE HASHES DO NOT ALL AGREE")
    return 0 if good else 1


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        description="Hashes of results, to show that a change of the code changes no bit of them."
    )
    parser.add_argument("--compare", metavar="FILE", help=f"default: {REFERENCE.name}")
    parser.add_argument("--write", metavar="FILE", help="write the hashes to this file")
    parser.add_argument("--portable", action="store_true", help="write only the cases core/...")
    parser.add_argument("--only", metavar="NAME", default="", help="cases that begin so")
    parser.add_argument("--isa", action="append", choices=KNOWN_ISAS, help="default: all")
    parser.add_argument("--flip", metavar="NAME", help="flip a bit of the cases that begin so")
    parser.add_argument("--child", action="store_true", help=argparse.SUPPRESS)
    return parser


def _of_isa(isa: str, options: argparse.Namespace) -> dict[str, str]:
    """The hashes of all cases by one instruction set, computed in a process of its own."""
    command = [sys.executable, "-W", "error", __file__, "--child", "--only", options.only]
    if options.flip:
        command += ["--flip", options.flip]
    begun = time.perf_counter()
    done = subprocess.run(
        command, env={**os.environ, "RIGID_ISA": isa}, stdout=subprocess.PIPE, text=True, check=True
    )
    found = _parsed(done.stdout)
    refused, failed = (list(found.values()).count(word) for word in ("refused", FAILED))
    words = f"{len(found)} cases, of which {refused} are refused and {failed} failed"
    print(f"{isa}: {words}; {time.perf_counter() - begun:.0f} s", flush=True)
    return found


def _print_hashes(only: str, flip: str | None) -> int:
    from result_cases import cases, digest

    for name, compute in cases():
        if name.startswith(only):
            flipped = flip is not None and name.startswith(flip)
            try:
                value = digest(compute(), flip=flipped)
            except Exception:  # the other cases are computed all the same
                traceback.print_exc()
                value = FAILED
            print(f"{value}  {name}", flush=True)
    return 0


def _same(found: dict[str, str], known: dict[str, str], here: str, there: str) -> bool:
    """Whether no hash differs from a known one; says which do."""
    changed = [name for name in known if name in found and found[name] != known[name]]
    missing = [name for name in known if name not in found]
    new = [name for name in found if name not in known]
    for what, names in (("DIFFERS", changed), ("NOT COMPUTED", missing)):
        for name in names[:40]:
            print(f"{what}: {name}")
        if len(names) > 40:
            print(f"{what}: and {len(names) - 40} more")
    compared = len(known) - len(missing)
    words = f"{here} against {there}: {compared} compared, {len(changed)} differ"
    print(f"{words}, {len(missing)} not computed, {len(new)} not in the second")
    if not compared:
        print("nothing was compared")
    return bool(compared) and not changed and not missing


def _write(file: Path, hashes: dict[str, str]) -> None:
    file.write_text("".join(f"{value}  {name}\n" for name, value in hashes.items()))


def _read(file: Path) -> dict[str, str]:
    return _parsed(file.read_text())


def _parsed(text: str) -> dict[str, str]:
    pairs = (line.split("  ", 1) for line in text.splitlines())
    return {name: value for value, name in pairs}


if __name__ == "__main__":
    sys.exit(main())
