"""Numbers of maps beside truths of their own: SciPy, NumPy, distributions and known shares.

``tests/long/survey_maps.py`` takes some hundred times as many.
"""

from collections.abc import Callable, Mapping

import pytest

import map_laws
import map_survey
from map_survey import Tally

SURVEYS: dict[str, Callable[[], Mapping[str, Tally]]] = {
    "measures": lambda: map_survey.measures(2026, 8),
    "horizons": lambda: {"horizons": map_survey.horizons(2026, 12)},
    "classes": lambda: {"classes": map_survey.known_classes(2026, 6)},
    "judged": lambda: {"judged": map_survey.judged_states(2026, 6)},
    "draws": lambda: {"draws": map_laws.draws(2026, 5000)},
    "coverage": lambda: map_laws.coverage(2026, 100),
}


@pytest.mark.parametrize("name", SURVEYS)
def test_no_number_is_wrong_that_is_not_flagged(name: str) -> None:
    for of, tally in SURVEYS[name]().items():
        assert not tally.undetected, (of, tally.notes)
        assert tally.right > 0.6 * tally.tried > 0, (of, str(tally))
