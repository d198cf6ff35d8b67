"""What holds for a map of any kind: bytes, files, JSON, stores, bodies in bulk and replayed."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import map_laws
import map_survey
import rigid
from map_kinds import KINDS, stays_low, wheel
from map_survey import Tally
from rigid.maps.file import file_size
from rigid.store.call import run_map
from small_maps import assert_same_map, in_blocks, saved_bytes, small_map

CLASSES = ("stable", "unstable", "undecided", "failed")


@pytest.fixture(scope="module", params=KINDS)
def kind(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture(scope="module")
def result(kind: str) -> rigid.StabilityMap:
    return small_map(**KINDS[kind][0], threads=1)


def of_files(kind: str) -> dict[str, Any]:
    """The functions that a file of the map does not have."""
    if "judged" in kind:
        return {"stable": stays_low}
    return {"scene": wheel} if "function" in kind else {}


def test_the_cases_see_bodies_that_stay_and_leave(result: rigid.StabilityMap) -> None:
    assert result.stable.sum() > 0
    assert result.unstable.sum() > 0


def test_threads_and_blocks_change_no_byte(
    kind: str, result: rigid.StabilityMap, tmp_path: Path
) -> None:
    expected = saved_bytes(result, tmp_path)
    for threads, units in ((1, 1), (2, 3), (3, 13), (7, 4096)):
        with in_blocks(units):
            again = small_map(**KINDS[kind][0], threads=threads)
        assert saved_bytes(again, tmp_path) == expected, (threads, units)
        assert again.receipt()["fingerprint"] == result.receipt()["fingerprint"]


def test_specifications_round_trip_through_json(result: rigid.StabilityMap) -> None:
    spec, text = result.spec, result.spec.to_json()
    for again in (rigid.MapSpec.from_json(text), rigid.MapSpec.from_dict(spec.to_dict())):
        assert again == spec
        assert hash(again) == hash(spec)
        assert again.to_json() == text


def test_a_loaded_map_equals_the_saved_one(
    kind: str, result: rigid.StabilityMap, tmp_path: Path
) -> None:
    saved = saved_bytes(result, tmp_path)
    assert len(saved) <= file_size(result.spec)
    loaded = rigid.load_map(tmp_path / "map.npz", **of_files(kind))
    assert loaded.spec == result.spec
    assert_same_map(loaded, result)
    assert loaded.complete == result.complete
    assert loaded.summary() == result.summary()
    assert KINDS[kind][1] in result.summary()
    assert saved_bytes(loaded, tmp_path) == saved
    for name, one in result.measures.items():
        np.testing.assert_array_equal(loaded.measures[name].bins, one.bins)
    assert_same_map(run_map(loaded.spec, progress=False), result)
    pixel = int(np.flatnonzero(result.status == 0)[-1])
    mine, theirs = (one.replay(pixel, 1) for one in (result, loaded))
    assert mine.omega.tobytes() == theirs.omega.tobytes()
    assert mine.attitude.tobytes() == theirs.attitude.tobytes()
    assert mine.outcome == theirs.outcome


def test_a_map_in_a_store_has_the_same_bytes(
    kind: str, result: rigid.StabilityMap, tmp_path: Path
) -> None:
    for part in ("2/2", "1/2"):
        stored = small_map(**KINDS[kind][0], store=tmp_path / "run", part=part)
    stored = small_map(**KINDS[kind][0], store=tmp_path / "run")
    assert stored.complete
    assert saved_bytes(stored, tmp_path) == saved_bytes(result, tmp_path)
    assert stored.receipt()["fingerprint"] == result.receipt()["fingerprint"]
    assert np.isfinite(stored.nanoseconds[stored.status == 0]).all()
    assert rigid.open_store(tmp_path / "run", **of_files(kind)).verify(1.0).ok


def test_bodies_in_bulk_are_counted_and_replayed(kind: str, result: rigid.StabilityMap) -> None:
    """Of pixels with bodies that stay and that leave."""
    samples = int(result.samples.max())
    every, starts = result.outcomes(range(samples), threads=2), result.starts(range(samples))
    if result.spec.half_width is None:
        for name in CLASSES:
            counted = (every.outcome == name).sum(axis=-1)
            np.testing.assert_array_equal(counted, getattr(result, name))
        drifts = ("energy_drift", "momentum_drift", "unit_drift")
        for name in drifts:
            worst = np.fmax.reduce(getattr(every, name), axis=-1)
            np.testing.assert_array_equal(worst, getattr(result, name), err_msg=name)
        if "judged" not in kind and kind != "regular":  # these have no time of each body
            left = np.where(every.outcome == "unstable", every.left, np.inf).min(axis=-1)
            np.testing.assert_array_equal(left, result.earliest)
    mixed = np.argwhere((result.stable > 0) & (result.unstable > 0))
    for pixel in map(tuple, mixed[:2].tolist()):
        for sample in range(0, int(result.samples[pixel]), 7):
            body = result.replay(pixel, sample, t=[1.0])
            index = (*pixel, sample)
            assert body.outcome == every.outcome[index]
            assert body.omega.tobytes() == starts.omega[index].tobytes()
            assert body.attitude.tobytes() == starts.attitude[index].tobytes()
            for name, values in every.measures.items():
                np.testing.assert_array_equal(body.measures[name], values[index])


# Random maps

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
