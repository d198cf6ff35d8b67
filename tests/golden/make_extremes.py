"""States of the extreme cases that have a closed form, from 1000-bit arithmetic.

    python tests/golden/make_extremes.py

Needs gmpy2. Writes ``python/rigid/builtin/extremes.json``: rates, attitude and the condition of
each case, by family and name. The formulas are those of ``make_closed_forms.py``.
"""

from __future__ import annotations

import json
from pathlib import Path

import gmpy2
from make_closed_forms import Input, condition, state

import rigid
from rigid.reports.stress_cases import Case, cases

BITS = 1000
WRITTEN = Path(rigid.__file__).parent / "builtin" / "extremes.json"


def start_of(case: Case) -> Input | None:
    """The case, if it has a closed form."""
    scene = case.scene
    if scene.acting() is not None:
        return None
    mgl, axis = 0.0, 0
    if isinstance(scene, rigid.HeavyTop):
        first, second, _ = scene.body.moments
        if first != second or scene.com != (0.0, 0.0, 1.0):
            return None
        mgl, axis = scene.mgl, 3
    return Input(case.family, scene.body.moments, axis, mgl, case.omega, case.attitude, case.t)


def main() -> None:
    gmpy2.get_context().precision = BITS
    written: dict[str, dict[str, object]] = {}
    for case in cases():
        start = start_of(case)
        if start is None:
            continue
        found = state(start)
        turned, moved = condition(start, found)
        written.setdefault(case.family, {})[case.name] = {
            "omega": [float(x) for x in found.omega],
            "attitude": [float(x) for x in found.attitude],
            "condition": max(turned, moved),
        }
        print(case.family, case.name, written[case.family][case.name], flush=True)
    WRITTEN.write_text(json.dumps(written, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
