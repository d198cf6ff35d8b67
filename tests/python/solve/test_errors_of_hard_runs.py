"""What a run says of its error is true, on runs that are hard on it; the truth is in 128 bits.

``tests/long/stated_errors.py`` takes thousands.
"""

from __future__ import annotations

import json
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

import quad_motion
import rigid
from physics import GOLDEN, Golden, golden, present
from verdicts import judge


@pytest.fixture(scope="module", autouse=True)
def _quad_numbers() -> None:
    if not quad_motion.is_available():
        pytest.skip("the C compiler has no 128-bit numbers")


RUNS, PER_TEST = 300, 50


@pytest.mark.parametrize("first", range(0, RUNS, PER_TEST))
def test_no_error_is_larger_than_what_is_said_of_it(first: int) -> None:
    for number in range(first, first + PER_TEST):
        found = judge(number, seed=2026)
        assert found.verdict != "SILENT", (found.true, found.stated, found.case.code())


@pytest.mark.parametrize("ratio", [1e-12, 1e-9, 1e-6])
@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("method", ["exact", "taylor20"])
def test_a_needle_moves_as_it_must_whatever_its_ratio(ratio: float, axis: int, method: str) -> None:
    """Moments as far apart as those of a wire of a kilometre and a hair."""
    moments = np.roll([ratio, 1.0, 1.0 - 0.5 * ratio], axis)
    scene = rigid.FreeBody(rigid.Body(moments))
    omega, attitude = np.array([0.3, -0.7, 0.2]), np.array([0.1, 0.7, -0.5, 0.5])
    t = [0.0, 1.0, 10.0]
    truth = quad_motion.motion(scene, omega, attitude, t)
    assert truth is not None
    run = rigid.simulate(scene, omega, attitude, t=t, method=method, accuracy=1e-10)
    assert not run.flagged
    assert truth.rates_off(run.omega).max() <= 1e-10
    assert truth.attitude_off(present(run.attitude)).max() <= 1e-10


FAMILIES = ("forced_damped", "free_symmetric", "lagrange", "kovalevskaya")
CASES = [case for family in FAMILIES for case in golden(family)]


def _document(case: Golden) -> dict[str, Any]:
    text = (GOLDEN / f"{case.id.split('/')[0]}.json").read_text()
    (found,) = (scene for scene in json.loads(text)["scenes"] if scene["id"] == case.id)
    return dict(found)


def _weight_is_exact(case: Golden, document: dict[str, Any]) -> bool:
    """Whether ``mass * gravity * com`` is a double: else another weight was read."""
    factor = Fraction(document["mass"]) * Fraction(document["gravity"])
    products = [factor * Fraction(component) for component in document["com"]]
    return products == [Fraction(component) for component in case.scene.weight.tolist()]


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.id)
def test_the_truth_is_that_of_the_reference_trajectories(case: Golden) -> None:
    """To all 25 digits that these have, times the conditioning of the motion."""
    document = _document(case)
    few = 4
    truth = quad_motion.motion(case.scene, case.omega0, case.attitude0, case.t[:few], limit=2000)
    if truth is None or not _weight_is_exact(case, document):
        pytest.skip("too many steps, or the weight is not a double")
    for row, sample in enumerate(document["samples"][:few]):
        x, y, z, w = map(Fraction, sample["q"])
        found = [Fraction(a) + Fraction(b) for a, b in zip(*truth.state(row), strict=True)]
        sign = 1 if found[3] * w + found[4] * x + found[5] * y + found[6] * z > 0 else -1
        rates = [abs(a - Fraction(b)) for a, b in zip(found[:3], sample["omega"], strict=True)]
        fastest = max(abs(Fraction(rate)) for rate in sample["omega"]) or 1
        components = [abs(a - sign * b) for a, b in zip(found[3:7], (w, x, y, z), strict=True)]
        growth = max(1.0, sample["kappa_att"] or 0.0, sample["kappa_omega"] or 0.0)
        # Half a unit of the 25th digit, and some roundings of 128-bit numbers.
        allowed = 1e-24 * growth
        assert float(max(rates) / fastest) <= allowed
        assert float(max(components)) <= allowed
