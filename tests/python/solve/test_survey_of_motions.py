"""Growth, lines, tensors, meshes, frames, other times and steps beside truths of their own.

``tests/long/survey_motions.py`` takes 500 cases of each.
"""

from __future__ import annotations

from collections import Counter

import pytest

import quad_motion
from judged_subjects import SUBJECTS

COUNTS = {
    "growth": 6,
    "growth under torques in space": 12,
    "verdicts": 40,
    "lines": 100,
    "drift of lines": 15,
    "tensors": 60,
    "meshes": 60,
    "frames": 15,
    "other times": 8,
    "steps": 20,
    "statics": 60,
    "cones": 60,
    "poinsot": 20,
    "throws": 4,
    "springs": 30,
    "tables": 20,
}


@pytest.fixture(scope="module", autouse=True)
def _quad_numbers() -> None:
    if not quad_motion.is_available():
        pytest.skip("the C compiler has no 128-bit numbers")


@pytest.mark.parametrize("subject", COUNTS)
def test_nothing_is_wrong_that_passes_for_right(subject: str) -> None:
    cases = [SUBJECTS[subject](number, 2026) for number in range(COUNTS[subject])]
    assert not [one for one in cases if one.verdict == "UNDETECTED"]
    found = Counter(one.verdict for one in cases)
    assert found["right"] >= len(cases) // 3 > 0, found  # most have a truth
