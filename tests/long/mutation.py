"""One operator, number or function of the library is changed: does a test fail?

    python tests/long/mutation.py [--core 40] [--python 60] [--seed 1] [--only TEXT]

Takes samples of the mutants of the core (made by `cargo install cargo-mutants`) and of Python, each
in a copy of this tree below ``target/``, and runs the tests of its file until one fails. The copy's
core has one instruction set, plain code with the fma of this processor: it compiles in a third of
the time. The first run compiles it twice; a mutant of the core then takes one or two minutes, one
of Python ten seconds. `--core 0` compiles nothing: it takes the core that `maturin develop` made.
The exit code is 1 if more than a tenth of the sample survives.
"""

import argparse
import json
import os
import shutil
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Iterator
from itertools import islice, zip_longest
from pathlib import Path
from random import Random

sys.path.insert(0, str(Path(__file__).parents[1] / "shared"))

from python_mutants import Mutant, python_mutants

ROOT = Path(__file__).parents[2]
COPY = ROOT / "target" / "mutation"

#: Processor time (s) of a command by which a mutant runs without end.
LONGEST = 200

#: What has more than one instruction set, and what has none of them.
SETS, PLAIN = 'target_arch = "x86_64"', 'target_arch = "none"'

LIBRARY = Path("python", "rigid", "_core.abi3.so")
_PROFILE = "--profile=develop"

KILLED, SURVIVED, NO_PROGRAM = "killed", "survived", "does not compile"

_MAPS = ("maps/test_map_statistics.py", "maps/test_falling_top.py", "maps/test_map_honesty.py")
_BITS = "contract/test_same_bits.py"
_CLOSED = (
    "exact/test_closed_forms.py",
    "exact/test_exact_quantities.py",
    "maps/test_closed_classification.py",
)
# What is quick and fails first stands first.
_ERRORS = (
    "solve/test_stated_errors.py",
    "solve/test_stated_errors.py",
    "solve/test_stated_errors.py",
    "solve/test_strong_damping.py",
    "solve/test_strong_damping.py",
    "solve/test_plan.py",
    "solve/test_error_estimates.py",
    "solve/test_torque_and_damping.py",
    "solve/test_errors_of_hard_runs.py",
)
_EXACT = (
    "exact/test_exact_quantities.py",
    "exact/test_closed_forms.py",
    "top/test_symmetric_top.py",
    "free/test_free_rotation.py",
    "contract/test_bad_input.py",
    "exact/test_closed_forms.py",
)

#: Beginnings of the core's files, their tests in `tests/python`, and names of tests in Rust.
CORE: dict[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    "src/observe/": (
        (*_MAPS, _BITS, "maps/test_closed_classification.py"),
        ("flips", "events", "tilt"),
    ),
    "src/map/statistics.rs": (_MAPS, ()),
    "src/map/interval.rs": (("maps/test_map_intervals.py",), ("interval", "incomplete_beta")),
    "src/sample.rs": (("maps/test_draws.py",), ("random_starts",)),
    "src/exact/": (_CLOSED, ("closed_forms", "exact")),
    "src/accuracy/": (_ERRORS, ("accuracy",)),
    "src/estimate/": (_ERRORS, ("estimate",)),
}

#: Modules, and their tests in `tests/python`.
PYTHON: dict[str, tuple[str, ...]] = {
    "python/rigid/solve/solution.py": _ERRORS,
    "python/rigid/exact/elliptic.py": _EXACT,
    "python/rigid/exact/flips.py": _EXACT,
    "python/rigid/exact/free.py": _EXACT,
    "python/rigid/exact/top.py": _EXACT,
}


def core_mutants() -> Iterator[Mutant]:
    """Of cargo-mutants."""
    files = [f"--file={name}{'**/*.rs' if name.endswith('/') else ''}" for name in CORE]
    listed = _run("cargo", "mutants", "--list", "--json", *files, folder=ROOT)
    if listed.returncode:
        raise SystemExit(f"cargo install cargo-mutants\n{listed.stderr}")
    for entry in json.loads(listed.stdout):
        text = (ROOT / entry["file"]).read_text(encoding="utf-8")
        begin, end = (_offset(text, entry["span"][side]) for side in ("start", "end"))
        changed = text[:begin] + entry["replacement"] + text[end:]
        words = entry["name"].split(": ", 1)[1]
        yield Mutant(entry["file"], entry["span"]["start"]["line"], words, changed)


def _offset(text: str, place: dict[str, int]) -> int:
    lines = text.splitlines(keepends=True)
    return sum(map(len, lines[: place["line"] - 1])) + place["column"] - 1


def _run(*command: str, folder: Path = COPY) -> subprocess.CompletedProcess[str]:
    """A command in a folder. It fails after too much processor time."""
    limited = ("bash", "-c", f'ulimit -t {LONGEST}; exec "$@"', "-", *command)
    environment = os.environ | {
        "PYTHONPATH": str(COPY / "python"),
        "CARGO_TARGET_DIR": str(COPY / "target"),
        "RUSTFLAGS": "-Ctarget-cpu=native",
    }
    return subprocess.run(
        limited, cwd=folder, env=environment, capture_output=True, text=True, check=False
    )


def built() -> bool:
    """Compile the copy's core for Python; False if it is no program."""
    done = _run("cargo", "build", _PROFILE, "--features=python", "--lib")
    if not done.returncode:
        library = COPY / LIBRARY
        library.unlink(missing_ok=True)
        shutil.copy(COPY / "target" / "develop" / "librigid.so", library)
    return not done.returncode


def passes_in_python(files: tuple[str, ...]) -> bool:
    paths = [str(Path("tests", "python", name)) for name in files]
    options = ("-n0", "-x", "-q", "-p", "no:cacheprovider", "-W", "ignore::pytest.PytestWarning")
    return not _run(sys.executable, "-m", "pytest", *options, *paths).returncode


def passes_in_rust(names: tuple[str, ...]) -> bool:
    # A million steps of plain code take more than a minute.
    options = ("--lib", "--", *names, "--skip=million_steps")
    return not _run("cargo", "test", _PROFILE, *options).returncode


def tests_of(path: str) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Files of tests in Python, and names of tests in Rust."""
    if path in PYTHON:
        return PYTHON[path], ()
    return next(tests for name, tests in CORE.items() if path.startswith(name))


def fate(path: str) -> str:
    """What becomes of the copy with a changed file. Tests in Rust, the quicker ones, come first."""
    python, rust = tests_of(path)
    if rust:
        if _run("cargo", "test", _PROFILE, "--lib", "--no-run").returncode:
            return NO_PROGRAM
        if not passes_in_rust(rust):
            return KILLED
    if path not in PYTHON and not built():
        return NO_PROGRAM
    return SURVIVED if passes_in_python(python) else KILLED


def fate_of(mutant: Mutant) -> str:
    """What becomes of a mutant; afterwards the copy is as it was."""
    place = COPY / mutant.path
    original = place.read_bytes()
    place.write_bytes(_of_the_copy(mutant.path, mutant.text.encode()))
    try:
        return fate(mutant.path)
    finally:
        place.write_bytes(original)


def _copy() -> None:
    """Bring the copy up to date; what cargo compiled there stays."""
    names = _run("git", "ls-files", "-co", "--exclude-standard", folder=ROOT).stdout.splitlines()
    for name in names:
        source, target = ROOT / name, COPY / name
        if not source.is_file():
            continue
        content = _of_the_copy(name, source.read_bytes())
        if not (target.is_file() and target.read_bytes() == content):
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_bytes(content)
            shutil.copymode(source, target)


def _of_the_copy(name: str, content: bytes) -> bytes:
    """What a file holds in the copy."""
    return content.replace(SETS.encode(), PLAIN.encode()) if name.startswith("src/") else content


def _sample(mutants: list[Mutant], count: int, seed: int, only: str | None) -> list[Mutant]:
    """As many of each group of files with the same tests, as far as there are so many."""
    if only is not None:
        return [mutant for mutant in mutants if only in str(mutant)]
    groups: dict[object, list[Mutant]] = {}
    for mutant in Random(seed).sample(mutants, len(mutants)):
        groups.setdefault(tests_of(mutant.path), []).append(mutant)
    turns = zip_longest(*groups.values())
    drawn = (mutant for turn in turns for mutant in turn if mutant is not None)
    return sorted(islice(drawn, count), key=str)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--core", type=int, default=40, help="mutants of the core")
    parser.add_argument("--python", type=int, default=60, help="mutants of Python")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", help="all mutants whose description has this text")
    chosen = parser.parse_args()
    COPY.mkdir(parents=True, exist_ok=True)
    _copy()
    of_python = [mutant for path in PYTHON for mutant in python_mutants(ROOT, path)]
    of_core = list(core_mutants()) if chosen.core else []
    print(f"{len(of_core)} mutants of the core, {len(of_python)} of Python", flush=True)
    sample = _sample(of_python, chosen.python, chosen.seed, chosen.only)
    sample += _sample(of_core, chosen.core, chosen.seed, chosen.only)

    fates: dict[str, Counter[str]] = {}
    if all(mutant.path in PYTHON for mutant in sample) and (ROOT / LIBRARY).is_file():
        shutil.copy(ROOT / LIBRARY, COPY / LIBRARY)
    elif not built():
        raise SystemExit("the unchanged core does not compile")
    for path in {tests_of(mutant.path): mutant.path for mutant in sample}.values():
        if fate(path) != SURVIVED:
            raise SystemExit(f"{path}: its tests fail without a mutant")
    for mutant in sample:
        begin = time.perf_counter()
        said = fate_of(mutant)
        print(f"{said:17} {time.perf_counter() - begin:4.0f} s  {mutant}", flush=True)
        fates.setdefault(mutant.path, Counter())[said] += 1
    total = sum(fates.values(), Counter())
    print(f"\n{'file':40} {KILLED:>8} {SURVIVED:>8} {NO_PROGRAM:>17}")
    for path, counts in [*fates.items(), ("all", total)]:
        print(f"{path:40} {counts[KILLED]:8} {counts[SURVIVED]:8} {counts[NO_PROGRAM]:17}")
    return int(total[SURVIVED] > 0.1 * (total[KILLED] + total[SURVIVED]))


if __name__ == "__main__":
    sys.exit(main())
