"""What takes minutes or needs a quiet machine: ``pytest -n 0 -s tests/long``.

One file, so that the tests run one after the other, also with several workers.
"""

import signal
import subprocess
from pathlib import Path

import pytest

import rigid
from interrupts import LONG, seconds_until_interrupted, sigint
from processes import environment, python_command

SCRIPTS = (
    "any_scene",
    "closed_forms_against_rk4",
    "criteria",
    "eccentric_orbits",
    "error_estimates",
    "failed_allocations",
    "fits",
    "fuzz",
    "growth",
    "interval_coverage",
    "killed_writers",
    "own_states",
    "principal_axes",
    "pulses",
    "refined_maps",
    "regular",
    "result_hashes",
    "running_maps",
    "stated_errors",
    "survey_maps",
    "survey_motions",
    "there_and_back",
)


@pytest.mark.parametrize("name", SCRIPTS)
def test_script_finds_nothing_wrong(name: str) -> None:
    script = Path(__file__).with_name(f"{name}.py")
    done = subprocess.run(python_command(str(script)), env=environment(), check=False)
    assert done.returncode == 0


def test_reference_motions_are_made_again() -> None:
    """One of each kind of file; the others take hours."""
    script = Path(__file__).parents[1] / "golden" / "make_trajectories.py"
    scenes = ("kov_a", "torque_axis3", "section-close-pairs", "chaos/asymmetric", "/circular")
    done = subprocess.run(python_command(str(script), *scenes), env=environment(), check=False)
    assert done.returncode == 0


def test_sixteen_satellites_tumble_as_long_as_those_of_the_literature() -> None:
    pytest.importorskip("numba")
    found = rigid.validation(("delfi-pq-mean", "delfi-pq-median"), progress=False)
    assert all(row.agrees for row in found.rows)


@pytest.mark.parametrize("size", LONG)
def test_ctrl_c_returns_within_two_seconds(size: str) -> None:
    with sigint(signal.default_int_handler):
        assert seconds_until_interrupted(size) < 2.0
