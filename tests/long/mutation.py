"""One operator, number or function of the library is changed: does a test fail?

    python tests/long/mutation.py [--core 40] [--python 60] [--seed 1] [--only TEXT]

Takes samples of the mutants of the core (made by `cargo install cargo-mutants`) and of Python, each
in a copy of this tree below ``target/``, and runs tests until one fails: of Python those that run
the changed line, which the first run of all records in ten minutes (``pip install coverage``). The
copy's core has one instruction set, plain code with the fma of this processor: it compiles in a
third of the time. The first run compiles it twice; a mutant of the core then takes one or two
minutes. `--core 0` compiles nothing: it takes the core that `maturin develop` made.
A mutant that computes the same stands in ``tests/shared/equivalent_mutants.py``, with its reason.
The exit code is 1 if more than a twentieth of the others survives.
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
from functools import cache, partial
from itertools import accumulate
from pathlib import Path
from random import Random

sys.path.insert(0, str(Path(__file__).parents[1] / "shared"))

from equivalent_mutants import EQUIVALENT, key_of, why_equivalent
from line_tests import LineTests
from python_mutants import Mutant, python_mutants

ROOT = Path(__file__).parents[2]
COPY = ROOT / "target" / "mutation"

#: Which tests run which lines, and the library of that time; remove the folder to record it anew.
RECORDS = ROOT / "target" / "line_tests"
SOURCES = RECORDS / "sources"

#: Processor time (s) of a command by which a mutant runs without end, and its time if it waits.
LONGEST, PATIENCE = 200, 600

#: What has more than one instruction set, and what has none of them.
SETS, PLAIN = 'target_arch = "x86_64"', 'target_arch = "none"'

#: Share of the mutants that may survive.
MOST_ALIVE = 0.05

PACKAGE = "python/rigid/"
LIBRARY = Path(PACKAGE, "_core.abi3.so")
_PROFILE = "--profile=develop"

KILLED, SURVIVED, NO_PROGRAM = "killed", "survived", "does not compile"

#: Where pytest tells which tests have failed.
FAILED = COPY / ".pytest_cache" / "v" / "cache" / "lastfailed"

#: Instead of a test: a run that took too much processor time.
ENDLESS = "no end"

_MAPS = ("maps/test_map_statistics.py", "maps/test_falling_top.py")
_BITS = "contract/test_same_bits.py"
_CLOSED = (
    "exact/test_closed_forms.py",
    "exact/test_exact_quantities.py",
    "maps/test_criteria.py",
)
# What is quick and fails first stands first.
_ERRORS = (
    "solve/test_stated_errors.py",
    "solve/test_strong_damping.py",
    "solve/test_plan.py",
    "solve/test_error_estimates.py",
    "solve/test_torque_and_damping.py",
    "solve/test_errors_of_hard_runs.py",
)

#: Beginnings of the core's files, their tests in `tests/python`, and names of tests in Rust.
CORE: dict[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    "src/observe/": (
        (*_MAPS, _BITS, "maps/test_criteria.py"),
        ("flips", "events", "tilt"),
    ),
    "src/map/statistics.rs": (_MAPS, ()),
    "src/map/interval.rs": (("maps/test_map_statistics.py",), ("interval", "incomplete_beta")),
    "src/sample.rs": (("maps/test_draws.py",), ("random_starts",)),
    "src/exact/": (_CLOSED, ("closed_forms", "exact")),
    "src/accuracy/": (_ERRORS, ("accuracy",)),
    "src/estimate/": (_ERRORS, ("estimate",)),
}

#: Drawings and tutorials: their numbers are a matter of taste.
TASTE = ("animation/", "builtin/", "drawing/", "figures/", "maps/plot.py", "reports/plot.py")

#: Time (s) of the tests of a line that are tried first, and then of their whole files.
ALONE, TOGETHER = 15.0, 40.0


def core_mutants() -> Iterator[Mutant]:
    """Of cargo-mutants."""
    files = [f"--file={name}{'**/*.rs' if name.endswith('/') else ''}" for name in CORE]
    listed = _run("cargo", "mutants", "--list", "--json", *files, folder=ROOT)
    if listed.returncode:
        raise SystemExit(f"cargo install cargo-mutants\n{listed.stderr}")
    for entry in json.loads(listed.stdout):
        text = (ROOT / entry["file"]).read_text(encoding="utf-8")
        begin, end = (_offset(text, entry["span"][side]) for side in ("start", "end"))
        parts = (text[:begin], entry["replacement"], text[end:])
        words = entry["name"].split(": ", 1)[1]
        line = entry["span"]["start"]["line"]
        source = text.splitlines()[line - 1].strip()
        yield Mutant(entry["file"], line, source, words, partial("".join, parts))


def _offset(text: str, place: dict[str, int]) -> int:
    lines = text.splitlines(keepends=True)
    return sum(map(len, lines[: place["line"] - 1])) + place["column"] - 1


def _run(*command: str, folder: Path = COPY) -> subprocess.CompletedProcess[str]:
    """A command in a folder. It fails after too much time."""
    limits = ("timeout", f"{PATIENCE}", "bash", "-c", f'ulimit -t {LONGEST}; exec "$@"', "-")
    environment = os.environ | {
        "PYTHONPATH": str(COPY / "python"),
        "CARGO_TARGET_DIR": str(COPY / "target"),
        "RUSTFLAGS": "-Ctarget-cpu=native",
    }
    return subprocess.run(
        (*limits, *command),
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )


def built() -> bool:
    """Compile the copy's core for Python; False if it is no program."""
    done = _run("cargo", "build", _PROFILE, "--features=python", "--lib")
    if not done.returncode:
        library = COPY / LIBRARY
        library.unlink(missing_ok=True)
        shutil.copy(COPY / "target" / "develop" / "librigid.so", library)
    return not done.returncode


def fails_in_python(*tests: str) -> str | None:
    """The first test that fails, or the word of a run without end; None if none fails."""
    FAILED.unlink(missing_ok=True)
    done = _run(sys.executable, "-m", "pytest", "-n0", "-x", "-q", *tests)
    if not done.returncode:
        return None
    found = json.loads(FAILED.read_text()) if FAILED.is_file() else {}
    if not found and done.returncode == 1:
        raise SystemExit(done.stderr)  # pytest itself has failed
    return next(iter(found), ENDLESS)


@cache
def require_passing(test: str) -> None:
    """Stop if a test that has killed a mutant fails without one."""
    # All its cases: the name of one may have characters by which pytest does not find it. Some
    # tests have a limit of time, which a busy machine may pass once.
    if test != ENDLESS and all(fails_in_python(test.partition("[")[0]) for _ in range(2)):
        raise SystemExit(f"{test}: fails without a mutant")


def passes_in_rust(names: tuple[str, ...]) -> bool:
    # A million steps of plain code take more than a minute.
    options = ("--lib", "--", *names, "--skip=million_steps")
    return not _run("cargo", "test", _PROFILE, *options).returncode


def modules() -> list[str]:
    """The modules that are mutated."""
    places = (
        place.relative_to(ROOT / PACKAGE).as_posix() for place in (ROOT / PACKAGE).rglob("*.py")
    )
    return sorted(PACKAGE + place for place in places if not place.startswith(TASTE))


@cache
def recorded() -> LineTests:
    """Which tests run which lines; recorded once, on all cores."""
    if not SOURCES.is_dir():
        files = sorted(
            (ROOT / "tests" / "python").rglob("test_*.py"), key=lambda f: f.stat().st_size
        )
        # The benches measure times, which a tracer changes.
        names = [str(place.relative_to(ROOT)) for place in files if place.stem != "test_benches"]
        path = os.pathsep.join(str(ROOT / name) for name in ("python", "tests/shared"))
        count = os.cpu_count() or 1
        runs = []
        for k in range(count):
            record = RECORDS / f"{k}.json"
            record.parent.mkdir(parents=True, exist_ok=True)
            command = (sys.executable, "-m", "pytest", "-n0", "-p", "line_tests", *names[k::count])
            environment = os.environ | {"LINE_TESTS": str(record), "PYTHONPATH": path}
            runs.append((record, subprocess.Popen(command, cwd=ROOT, env=environment)))
        for record, run in runs:
            run.wait()
            if not record.is_file():
                raise SystemExit(f"{record}: pytest ended without a record")
        shutil.copytree(ROOT / PACKAGE, SOURCES)
    return LineTests(sorted(RECORDS.glob("*.json")), SOURCES)


def fate(mutant: Mutant) -> tuple[str, str]:
    """What becomes of the copy with a changed file, and by which test."""
    path = mutant.path
    if path.startswith(PACKAGE):
        return _fate_of_python(mutant)
    python, rust = next(tests for name, tests in CORE.items() if path.startswith(name))
    if rust:
        if _run("cargo", "test", _PROFILE, "--lib", "--no-run").returncode:
            return NO_PROGRAM, ""
        if not passes_in_rust(rust):
            return KILLED, "a test in Rust"
    if not built():
        return NO_PROGRAM, ""
    killer = fails_in_python(*(f"tests/python/{name}" for name in python))
    return (SURVIVED, "") if killer is None else (KILLED, killer)


def _fate_of_python(mutant: Mutant) -> tuple[str, str]:
    """The tests of the line, then the files that they stand in, as far as the times allow."""
    tests = recorded()
    names = tests.of_line(mutant.path.removeprefix(PACKAGE), mutant.line)
    files = list(dict.fromkeys(name.partition("::")[0] for name in names))
    times = Counter[str]()
    for name, seconds in tests.seconds.items():
        times[name.partition("::")[0]] += seconds
    for group, seconds, most in ((names, tests.seconds, ALONE), (files, times, TOGETHER)):
        total = accumulate(seconds.get(name, 0.0) for name in group)
        chosen = [name for name, until in zip(group, total, strict=True) if until < most]
        killer = fails_in_python(*(chosen or group[:1])) if group else None
        if killer is not None:
            return KILLED, killer
    return SURVIVED, "" if names else "(no test runs it)"


def fate_of(mutant: Mutant) -> tuple[str, str]:
    """What becomes of a mutant, and by which test; afterwards the copy is as it was."""
    place = COPY / mutant.path
    original = place.read_bytes()
    place.write_bytes(_of_the_copy(mutant.path, mutant.text().encode()))
    try:
        return fate(mutant)
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
    """So many at random, of those whose description has a text."""
    asked = [mutant for mutant in mutants if only is None or only in str(mutant)]
    return Random(seed).sample(asked, min(count, len(asked)))


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--core", type=int, default=40, help="mutants of the core")
    parser.add_argument("--python", type=int, default=60, help="mutants of Python")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", help="mutants whose description has this text")
    chosen = parser.parse_args()
    COPY.mkdir(parents=True, exist_ok=True)
    _copy()
    every = [mutant for path in modules() for mutant in python_mutants(ROOT, path)]
    gone = EQUIVALENT.keys() - set(map(key_of, every))
    if gone:
        raise SystemExit(f"no mutants any more: {gone}")
    of_python = [mutant for mutant in every if not why_equivalent(mutant)]
    of_core = list(core_mutants()) if chosen.core else []
    print(f"{len(of_core)} mutants of the core, {len(of_python)} of Python", flush=True)
    sample = _sample(of_python, chosen.python, chosen.seed, chosen.only)
    sample += _sample(of_core, chosen.core, chosen.seed, chosen.only)

    fates: dict[str, Counter[str]] = {}
    if all(mutant.path.startswith(PACKAGE) for mutant in sample) and (ROOT / LIBRARY).is_file():
        shutil.copy(ROOT / LIBRARY, COPY / LIBRARY)
    elif not built():
        raise SystemExit("the unchanged core does not compile")
    of_rust = [m.path for m in sample if not m.path.startswith(PACKAGE)]
    for begin_of, (_, names) in CORE.items():
        asked = names and any(path.startswith(begin_of) for path in of_rust)
        if asked and not passes_in_rust(names):
            raise SystemExit(f"{names}: fail without a mutant")
    for mutant in sample:
        begin = time.perf_counter()
        said, killer = fate_of(mutant)
        seconds = time.perf_counter() - begin
        print(f"{said:17} {seconds:4.0f} s  {mutant}  {killer.rpartition('::')[2]}", flush=True)
        fates.setdefault(mutant.path, Counter())[said] += 1
        if mutant.path.startswith(PACKAGE) and said == KILLED:
            require_passing(killer)
    total = sum(fates.values(), Counter())
    print(f"\n{'file':40} {KILLED:>8} {SURVIVED:>8} {NO_PROGRAM:>17}")
    for path, counts in [*fates.items(), ("all", total)]:
        print(f"{path:40} {counts[KILLED]:8} {counts[SURVIVED]:8} {counts[NO_PROGRAM]:17}")
    return int(total[SURVIVED] > MOST_ALIVE * (total[KILLED] + total[SURVIVED]))


if __name__ == "__main__":
    sys.exit(main())
