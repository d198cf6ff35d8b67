"""Numbers of maps against truths that share no line with the library.

    python tests/long/survey_maps.py                               # all subjects; some minutes
    python tests/long/survey_maps.py --subject measures --count 2000 --seed 7

Subjects: ``measures`` of bodies, by SciPy's DOP853 at 1e-13; ``horizons``: pixels of maps with axes
``t_end`` and ``limit``; ``classes`` along them that the start tells; states of ``judged`` bodies;
``draws`` of all laws; ``coverage`` of intervals. Prints what was right, flagged as unsure or
refused, and each number that was wrong and not flagged; fails if there is one.
"""

import argparse
import sys
import time
from collections.abc import Callable, Mapping
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "shared"))

import map_laws
import map_survey
from map_survey import Tally

SUBJECTS: dict[str, tuple[int, Callable[[int, int], Mapping[str, Tally]]]] = {
    "measures": (1000, map_survey.measures),
    "horizons": (300, lambda seed, count: {"horizons": map_survey.horizons(seed, count)}),
    "classes": (300, lambda seed, count: {"classes": map_survey.known_classes(seed, count)}),
    "judged": (500, lambda seed, count: {"judged": map_survey.judged_states(seed, count)}),
    "draws": (100_000, lambda seed, count: {"draws": map_laws.draws(seed, count)}),
    "coverage": (5000, map_laws.coverage),
}
"""Subjects with their count by default: maps, samples or pixels of each share."""


def main() -> int:
    """Survey; 1 if a number was wrong and not flagged."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--subject", choices=SUBJECTS, action="append")
    parser.add_argument("--count", type=int)
    parser.add_argument("--seed", type=int, default=1)
    chosen = parser.parse_args()
    failed = False
    for name in chosen.subject or SUBJECTS:
        usual, survey = SUBJECTS[name]
        begun = time.perf_counter()
        tallies = survey(chosen.seed, chosen.count or usual)
        for of, tally in tallies.items():
            print(f"{of}: {tally}", flush=True)
            for note in tally.notes:
                print("   ", note)
        print(f"{name} took {time.perf_counter() - begun:.0f} s", flush=True)
        failed |= any(tally.undetected for tally in tallies.values())
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
