"""One operator, number or function of the library is changed: does a test fail?

    python tests/long/mutation.py [--core 40] [--python 60] [--seed 1] [--only TEXT]

Takes samples of the mutants of the core (made by `cargo install cargo-mutants`) and of Python, each
in a copy of this tree below ``target/``, and runs the tests of its file until one fails. The copy's
core has one instruction set, plain code with the fma of this processor: it compiles in a third of
the time. The first run compiles it twice; a mutant of the core then takes one or two minutes, one
of Python ten seconds. `--core 0` compiles nothing: it takes the core that `maturin develop` made.
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
from itertools import islice, zip_longest
from pathlib import Path
from random import Random

sys.path.insert(0, str(Path(__file__).parents[1] / "shared"))

from equivalent_mutants import EQUIVALENT, key_of, why_equivalent
from python_mutants import Mutant, python_mutants

ROOT = Path(__file__).parents[2]
COPY = ROOT / "target" / "mutation"

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

#: Beginnings of modules in `python/rigid`, and their tests in `tests/python`, quick ones first; the
#: longest beginning counts. What has no line is drawing: its numbers are a matter of taste.
PYTHON: dict[str, tuple[str, ...]] = {
    "_checks/": (
        "contract/test_bad_input.py",
        "contract/test_progress.py",
        "contract/test_what_is_given.py",
        "contract/test_units.py",
        "contract/test_notebook.py",
        "solve/test_targets.py",
        "maps/test_map_bad_input.py",
        "solve/test_motion.py",
        "maps/test_plan_of_a_criterion.py",
    ),
    "_checks/inputs.py": (
        "cli/test_command_line.py",
        "maps/test_map_again.py",
        "solve/test_runs_kept.py",
    ),
    "_archive.py": (
        "solve/test_runs_kept.py",
        "maps/test_map_files.py",
        "maps/test_own_starts.py",
    ),
    "_checks/matrices.py": ("rotations", "particles", "inertia"),
    "_checks/moments.py": ("inertia", "contract/test_bad_input.py", "solve/test_rods.py"),
    "_checks/progress.py": (
        "contract/test_progress.py",
        "reports/test_revolutions.py",
        "cli/test_command_line.py",
    ),
    "_energy_loss.py": ("maps/test_satellite_maps.py", "free/test_lasting_rotation.py"),
    "_files.py": ("test_files.py",),
    "_libration.py": ("free/test_free_rotation.py", "solve/test_satellites.py"),
    "_timing.py": ("solve/test_plan.py",),
    "cli/": ("cli",),
    "cli/toml_report.py": ("reports/test_report.py",),
    "cli/tutorials.py": ("contract/test_notebook.py",),
    "earth.py": ("test_earth.py",),
    "exact/": (
        "exact/test_exact_quantities.py",
        "exact/test_closed_forms.py",
        "top/test_symmetric_top.py",
        "free/test_free_rotation.py",
        "contract/test_what_is_given.py",
    ),
    "fits/arcs.py": ("fits/test_gyroscopes.py",),
    "fits/fit.py": ("fits/test_fit.py", "fits/test_gyroscopes.py"),
    "fits/least_squares.py": ("fits/test_fit.py", "fits/test_gyroscopes.py"),
    "fits/unknowns.py": ("fits/test_fit.py", "fits/test_gyroscopes.py"),
    "fixed_axis.py": ("test_fixed_axis.py",),
    "frames.py": ("test_frames.py",),
    "free/": ("free", "contract/test_what_is_given.py"),
    "free/equations.py": (
        "free/test_free_rotation.py",
        "solve/test_many_bodies.py",
        "solve/test_drag.py",
        "solve/test_satellites.py",
        "contract/test_what_is_given.py",
    ),
    "free/satellites.py": (
        "free/test_free_rotation.py",
        "free/test_lasting_rotation.py",
        "solve/test_satellites.py",
    ),
    "inertia/": ("inertia", "solids/test_solids.py"),
    "inertia/urdf.py": ("solids/test_mesh_files.py",),
    "literature/": ("literature",),
    "maps/": (
        "maps/test_map_statistics.py",
        "maps/test_map_axes.py",
        "maps/test_map_grid.py",
        "maps/test_map_bad_input.py",
        "maps/test_map_files.py",
        "maps/test_map_bits.py",
        "maps/test_every_kind.py",
        "maps/test_draws.py",
    ),
    "maps/contours.py": ("maps/test_map_theory.py", "maps/test_map_plot.py"),
    "maps/data.py": (
        "maps/test_map_statistics.py",
        "maps/test_map_again.py",
        "maps/test_map_files.py",
        "maps/test_refined_maps.py",
        "maps/test_regular_maps.py",
        "maps/test_map_grid.py",
    ),
    "maps/dataset.py": (
        "maps/test_map_files.py",
        "maps/test_refined_maps.py",
        "maps/test_measures.py",
        "store/test_zarr.py",
    ),
    "maps/file.py": ("maps/test_map_files.py", "maps/test_measures.py"),
    "maps/grid.py": (
        "maps/test_map_grid.py",
        "maps/test_own_starts.py",
        "maps/test_map_axes.py",
        "maps/test_map_bad_input.py",
        "maps/test_every_kind.py",
    ),
    "maps/judge.py": ("maps/test_judged.py", "store/test_stored_functions.py"),
    "maps/measured.py": ("maps/test_measures.py", "store/test_stored_functions.py"),
    "maps/moons.py": ("maps/test_moon_maps.py",),
    "maps/own.py": ("maps/test_own_scenes.py", "maps/test_own_starts.py"),
    "maps/page.py": ("animation/test_explorer.py", "animation/test_widget.py"),
    "maps/plan.py": ("maps/test_plan_of_a_criterion.py", "solve/test_plan.py"),
    "maps/refine.py": ("maps/test_refined_maps.py",),
    "maps/replay.py": (
        "contract/test_notebook.py",
        "maps/test_map_again.py",
        "maps/test_map_grid.py",
        "maps/test_judged.py",
        "maps/test_measures.py",
        "maps/test_every_kind.py",
    ),
    "maps/samples.py": (
        "maps/test_map_again.py",
        "maps/test_draws.py",
        "maps/test_judged.py",
        "maps/test_map_axes.py",
        "maps/test_map_bad_input.py",
    ),
    "maps/satellites.py": ("maps/test_satellite_maps.py",),
    "maps/sequential.py": ("maps/test_refined_maps.py",),
    "maps/spec.py": (
        "maps/test_map_bad_input.py",
        "maps/test_map_axes.py",
        "maps/test_map_grid.py",
        "maps/test_map_statistics.py",
        "maps/test_draws.py",
        "maps/test_own_torques.py",
        "maps/test_judged.py",
        "maps/test_map_files.py",
        "maps/test_plan_of_a_criterion.py",
        "maps/test_regular_maps.py",
        "maps/test_time_units.py",
        "maps/test_every_kind.py",
    ),
    "maps/summary.py": (
        "maps/test_time_units.py",
        "maps/test_map_statistics.py",
        "maps/test_measures.py",
        "maps/test_refined_maps.py",
        "maps/test_regular_maps.py",
        "maps/test_map_theory.py",
        "cli/test_command_line.py",
    ),
    "maps/theory.py": ("maps/test_map_theory.py", "maps/test_falling_top.py"),
    "maps/vary.py": ("maps/test_varied_bodies.py",),
    "maps/watched.py": (
        "maps/test_criteria.py",
        "maps/test_map_again.py",
        "maps/test_time_units.py",
        "maps/test_map_plot.py",
        "animation/test_explorer.py",
    ),
    "maps/words.py": (
        "maps/test_time_units.py",
        "maps/test_regular_maps.py",
        "maps/test_map_plot.py",
    ),
    "meshes.py": ("solids",),
    "model/": (
        "contract/test_bad_input.py",
        "solve/test_torque_and_damping.py",
        "fits/test_gyroscopes.py",
        "solve/test_many_bodies.py",
        "maps/test_map_bad_input.py",
        "maps/test_map_grid.py",
    ),
    "model/bodies.py": (
        "solve/test_rods.py",
        "solve/test_many_bodies.py",
        "contract/test_bad_input.py",
        "solve/test_orbit_frame.py",
        "solve/test_stated_errors.py",
    ),
    "model/body.py": (
        "contract/test_bad_input.py",
        "contract/test_units.py",
        "inertia/test_inertia.py",
        "free/test_free_rotation.py",
        "solve/test_engineers_words.py",
        "solve/test_rods.py",
        "free/test_lasting_rotation.py",
    ),
    "model/bounds.py": (
        "maps/test_criteria.py",
        "solve/test_orbits.py",
        "maps/test_plan_of_a_criterion.py",
        "maps/test_every_kind.py",
    ),
    "model/compiling.py": ("solve/test_callbacks.py", "solve/test_event_functions.py"),
    "model/criteria.py": (
        "maps/test_criteria.py",
        "maps/test_map_bad_input.py",
        "maps/test_plan_of_a_criterion.py",
        "maps/test_varied_bodies.py",
    ),
    "model/criterion.py": (
        "maps/test_criteria.py",
        "maps/test_draws.py",
        "maps/test_map_bad_input.py",
    ),
    "model/damping.py": ("solve/test_torque_and_damping.py", "solve/test_many_bodies.py"),
    "model/digest.py": ("maps/test_captured.py",),
    "model/events.py": (
        "solve/test_event_quantities.py",
        "solve/test_events.py",
        "solve/test_pointing_events.py",
    ),
    "model/forces.py": (
        "solve/test_axes_of_a_drawing.py",
        "fits/test_gyroscopes.py",
        "solve/test_drag.py",
        "maps/test_map_grid.py",
        "solve/test_satellites.py",
    ),
    "model/frame.py": ("solve/test_axes_of_a_drawing.py",),
    "model/function.py": ("solve/test_callbacks.py", "solve/test_own_states.py"),
    "model/gravity.py": ("solve/test_engineers_words.py", "solve/test_satellites.py"),
    "model/judged.py": ("maps/test_judged.py", "store/test_stored_functions.py"),
    "model/measures.py": (
        "maps/test_measures.py",
        "maps/test_frame_of_the_orbit.py",
        "maps/test_every_kind.py",
    ),
    "model/mixture.py": ("maps/test_draws.py", "maps/test_every_kind.py"),
    "model/orbit.py": (
        "solve/test_orbits.py",
        "solve/test_flybys.py",
        "solve/test_satellites.py",
        "solve/test_orbit_tables.py",
    ),
    "model/orbit_axes.py": ("maps/test_frame_of_the_orbit.py", "solve/test_pointing_events.py"),
    "model/parameters.py": (
        "maps/test_map_axes.py",
        "maps/test_map_grid.py",
        "maps/test_map_bad_input.py",
        "solve/test_sensitivity.py",
        "fits/test_fit.py",
        "maps/test_varied_bodies.py",
    ),
    "model/sampled.py": (
        "solve/test_rotor_tables.py",
        "solve/test_torque_and_damping.py",
        "solve/test_orbit_tables.py",
    ),
    "model/scene.py": (
        "contract/test_bad_input.py",
        "solve/test_engineers_words.py",
        "solve/test_axes_of_a_drawing.py",
        "solve/test_many_bodies.py",
        "solve/test_torque_and_damping.py",
        "reports/test_revolutions.py",
    ),
    "model/seed.py": ("maps/test_draws.py", "maps/test_map_bad_input.py", "maps/test_map_again.py"),
    "model/sourced.py": ("maps/test_captured.py", "maps/test_own_scenes.py"),
    "model/noise.py": (
        "maps/test_draws.py",
        "maps/test_map_bad_input.py",
        "maps/test_varied_bodies.py",
    ),
    "model/start.py": (
        "maps/test_own_scenes.py",
        "maps/test_map_grid.py",
        "maps/test_map_bad_input.py",
        "maps/test_satellite_maps.py",
    ),
    "model/time_unit.py": (
        "maps/test_time_units.py",
        "maps/test_satellite_maps.py",
        "maps/test_plan_of_a_criterion.py",
        "cli/test_command_line.py",
    ),
    "model/torque.py": (
        "contract/test_bad_input.py",
        "solve/test_torque_and_damping.py",
        "solve/test_rotor_tables.py",
        "solve/test_many_bodies.py",
        "solve/test_callbacks.py",
    ),
    "particles/": ("particles", "test_springs.py"),
    "planning.py": ("solve/test_plan.py",),
    "reports/": (
        "contract/test_constants_of_docstrings.py",
        "reports/test_report.py",
        "reports/test_revolutions.py",
    ),
    "reports/scheme.py": ("reports/test_own_schemes.py", "reports/test_report.py"),
    "reports/stress": ("reports/test_stress.py",),
    "rotations/": ("rotations", "contract/test_bad_input.py", "solve/test_orbit_frame.py"),
    "sections/": ("sections",),
    "solids/": ("solids", "contract/test_what_is_given.py"),
    "solve/": (
        "solve/test_plan.py",
        "solve/test_many_bodies.py",
        "solve/test_stated_errors.py",
        "solve/test_strong_damping.py",
        "solve/test_error_estimates.py",
        "solve/test_torque_and_damping.py",
        "solve/test_times.py",
    ),
    "solve/attitude_ephemeris.py": (
        "solve/test_attitude_ephemeris.py",
        "solve/test_runs_kept.py",
    ),
    "solve/chunks.py": (
        "solve/test_targets.py",
        "solve/test_tidy_tables.py",
        "solve/test_engineers_words.py",
    ),
    "solve/closed_form.py": (
        "maps/test_plan_of_a_criterion.py",
        "solve/test_plan.py",
        "solve/test_stated_errors.py",
    ),
    "solve/columns.py": ("solve/test_runs_kept.py", "solve/test_tidy_tables.py"),
    "solve/conserved.py": (
        "solve/test_rotor_tables.py",
        "solve/test_invariants.py",
        "solve/test_stated_errors.py",
    ),
    "solve/events.py": (
        "solve/test_events.py",
        "solve/test_event_quantities.py",
        "sections/test_poincare.py",
    ),
    "solve/frequencies.py": ("solve/test_frequencies.py",),
    "solve/growth.py": (
        "solve/test_lyapunov.py",
        "solve/test_orders.py",
        "solve/test_tidy_tables.py",
    ),
    "solve/lyapunov.py": ("solve/test_lyapunov.py", "solve/test_orbits.py"),
    "solve/motion.py": ("solve/test_motion.py",),
    "solve/plan.py": (
        "solve/test_plan.py",
        "maps/test_plan_of_a_criterion.py",
        "solve/test_runs_kept.py",
        "solve/test_stated_errors.py",
    ),
    "solve/run.py": (
        "solve/test_axes_of_a_drawing.py",
        "solve/test_invariants.py",
        "solve/test_orbits.py",
        "solve/test_many_bodies.py",
        "solve/test_events.py",
        "solve/test_runs_kept.py",
        "contract/test_notebook.py",
        "solve/test_tidy_tables.py",
        "solve/test_stated_errors.py",
        "animation/test_animation.py",
    ),
    "solve/simulate.py": (
        "solve/test_targets.py",
        "solve/test_events.py",
        "solve/test_times.py",
        "solve/test_plan.py",
        "solve/test_stated_errors.py",
    ),
    "solve/solution.py": (
        "solve/test_targets.py",
        "solve/test_many_bodies.py",
        "solve/test_stated_errors.py",
        "solve/test_plan.py",
        "solve/test_strong_damping.py",
    ),
    "solve/recording.py": ("animation/test_animation.py",),
    "solve/saved.py": ("solve/test_runs_kept.py",),
    "solve/surfaces.py": (
        "sections/test_poincare.py",
        "solve/test_events.py",
        "contract/test_same_bits.py",
        "solve/test_pointing_events.py",
        "solve/test_own_states.py",
        "solve/test_event_functions.py",
    ),
    "solve/tangent.py": (
        "solve/test_tangent.py",
        "solve/test_sensitivity.py",
        "solve/test_lyapunov.py",
        "fits/test_fit.py",
    ),
    "springs.py": ("test_springs.py",),
    "statics.py": ("test_statics.py",),
    "store/": (
        "store/test_parts.py",
        "store/test_running_maps.py",
        "store/test_damaged_logs.py",
        "store/test_proofs.py",
        "store/test_stored_functions.py",
    ),
    "store/drive.py": (
        "maps/test_map_progress.py",
        "store/test_running_maps.py",
        "store/test_parts.py",
        "store/test_proofs.py",
        "store/test_dask.py",
    ),
    "store/rows.py": (
        "contract/test_memory.py",
        "store/test_parts.py",
        "store/test_proofs.py",
        "store/test_stored_functions.py",
        "store/test_damaged_logs.py",
    ),
    "store/store.py": ("store/test_parts.py", "store/test_proofs.py"),
    "store/call.py": (
        "maps/test_map_again.py",
        "maps/test_map_bad_input.py",
        "store/test_parts.py",
    ),
    "store/result.py": (
        "maps/test_map_statistics.py",
        "maps/test_map_files.py",
        "maps/test_map_plot.py",
        "maps/test_refined_maps.py",
    ),
    "store/status.py": ("store/test_parts.py", "store/test_proofs.py", "cli/test_command_line.py"),
    "store/zooms.py": ("animation/test_widget.py",),
    "top/": ("top", "contract/test_what_is_given.py"),
    "units.py": ("contract/test_units.py",),
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
    paths = [str(Path("tests", "python", name)) for name in tests]
    done = _run(sys.executable, "-m", "pytest", "-n0", "-x", "-q", *paths)
    if not done.returncode:
        return None
    found = json.loads(FAILED.read_text()) if FAILED.is_file() else {}
    if not found and done.returncode == 1:
        raise SystemExit(done.stderr)  # pytest itself has failed
    return next((name.removeprefix("tests/python/") for name in found), ENDLESS)


@cache
def require_passing(test: str) -> None:
    """Stop if a test that has killed a mutant fails without one."""
    # All its cases: the name of one may have characters by which pytest does not find it.
    if test != ENDLESS and fails_in_python(test.partition("[")[0]):
        raise SystemExit(f"{test}: fails without a mutant")


def passes_in_rust(names: tuple[str, ...]) -> bool:
    # A million steps of plain code take more than a minute.
    options = ("--lib", "--", *names, "--skip=million_steps")
    return not _run("cargo", "test", _PROFILE, *options).returncode


def tests_of(path: str) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Files of tests in Python, and names of tests in Rust."""
    if path.startswith(PACKAGE):
        inside = path.removeprefix(PACKAGE)
        return PYTHON[max((name for name in PYTHON if inside.startswith(name)), key=len)], ()
    return next(tests for name, tests in CORE.items() if path.startswith(name))


def modules() -> list[str]:
    """The modules that have tests here."""
    places = (place.relative_to(ROOT) for place in (ROOT / PACKAGE).rglob("*.py"))
    paths = (place.as_posix() for place in places if place.name != "plot.py")
    return sorted(path for path in paths if path.removeprefix(PACKAGE).startswith((*PYTHON,)))


def fate(path: str) -> tuple[str, str]:
    """What becomes of the copy with a changed file, and by which test; those in Rust come first."""
    python, rust = tests_of(path)
    if rust:
        if _run("cargo", "test", _PROFILE, "--lib", "--no-run").returncode:
            return NO_PROGRAM, ""
        if not passes_in_rust(rust):
            return KILLED, "a test in Rust"
    if not path.startswith(PACKAGE) and not built():
        return NO_PROGRAM, ""
    killer = fails_in_python(*python)
    return (SURVIVED, "") if killer is None else (KILLED, killer)


def fate_of(mutant: Mutant) -> tuple[str, str]:
    """What becomes of a mutant, and by which test; afterwards the copy is as it was."""
    place = COPY / mutant.path
    original = place.read_bytes()
    place.write_bytes(_of_the_copy(mutant.path, mutant.text().encode()))
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
    for names in sorted({names for _, names in map(tests_of, {m.path for m in sample}) if names}):
        if not passes_in_rust(names):
            raise SystemExit(f"{names}: fail without a mutant")
    for mutant in sample:
        begin = time.perf_counter()
        said, killer = fate_of(mutant)
        seconds = time.perf_counter() - begin
        print(f"{said:17} {seconds:4.0f} s  {mutant}  {killer.rpartition('::')[2]}", flush=True)
        fates.setdefault(mutant.path, Counter())[said] += 1
        if mutant.path.startswith(PACKAGE) and killer:
            require_passing(killer)
    total = sum(fates.values(), Counter())
    print(f"\n{'file':40} {KILLED:>8} {SURVIVED:>8} {NO_PROGRAM:>17}")
    for path, counts in [*fates.items(), ("all", total)]:
        print(f"{path:40} {counts[KILLED]:8} {counts[SURVIVED]:8} {counts[NO_PROGRAM]:17}")
    return int(total[SURVIVED] > MOST_ALIVE * (total[KILLED] + total[SURVIVED]))


if __name__ == "__main__":
    sys.exit(main())
