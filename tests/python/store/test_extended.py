"""More samples for a stored map: the first bodies are those stored, and nothing else changes."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rigid

BOX: dict[str, Any] = {
    "axes": {"I2/I1": [1.2, 1.6, 2.0, 4.5], "noise": [1e-3, 1e-2]},
    "t_end": 60.0,
    "stable": rigid.no_flip(),
    "rng": 5,
}
TOP: dict[str, Any] = {
    "axes": {"spin": [1.0, 3.0, 6.0]},
    "t_end": 4.0,
    "stable": rigid.tilt_below(0.01),
    "measure": [rigid.largest_tilt(), rigid.mean_rate(3)],
    "rng": 6,
}
MAPS: dict[str, tuple[Any, dict[str, Any], int, int]] = {
    "closed form, and bodies that cannot be": (rigid.FreeBody, BOX, 64, 256),
    "steps with an audit, and measures": (
        rigid.HeavyTop(rigid.Body((1.0, 1.6, 0.7)), mgl=1.2),
        TOP,
        128,
        300,
    ),
    "random bodies": (
        rigid.FreeBody(rigid.Body((1.0, 1.5, 2.0))),
        {
            **BOX,
            "axes": {"spin": [0.3, 1.0]},
            "t_end": 25.0,
            "vary": {"I1": rigid.normal(0.05, relative=True)},
        },
        64,
        192,
    ),
    "pixels in pieces": (
        rigid.FreeBody(rigid.Body((1.0, 1.5, 2.0))),
        {**BOX, "axes": {"spin": np.linspace(0.2, 2.0, 8)}, "t_end": 12.0},
        16_384,
        20_000,
    ),
}


@pytest.mark.parametrize("name", MAPS)
def test_more_samples_are_the_map_that_was_asked_for_at_once(name: str, tmp_path: Path) -> None:
    scene, ask, few, many = MAPS[name]
    rigid.stability_map(scene, samples=few, store=tmp_path / "few", **ask, progress=False)
    more = rigid.open_store(tmp_path / "few").extend(tmp_path / "many", samples=many)
    assert more.result().samples.max() == few
    result = more.resume(progress=False)
    once = rigid.stability_map(scene, samples=many, **ask, progress=False)
    assert result.complete
    assert result.receipt()["fingerprint"] == once.receipt()["fingerprint"]
    possible = int((once.status == 0).sum())
    assert 0.0 < np.nanmean(once.share) < 1.0
    assert result.computed == (many - few) * possible
    assert rigid.open_store(tmp_path / "many").verify(share=1.0).ok
    assert rigid.diff(result, once).same
    # The folder that was there is as it was.
    assert rigid.open_store(tmp_path / "few").result().samples.max() == few


def test_a_part_of_a_map_goes_on_with_more_samples_in_other_processes(tmp_path: Path) -> None:
    ask = {**BOX, "samples": 64}
    rigid.stability_map(rigid.FreeBody, store=tmp_path / "few", part=(1, 2), **ask, progress=False)
    done = int(rigid.open_store(tmp_path / "few").result().samples.sum())
    more = rigid.open_store(tmp_path / "few").extend(tmp_path / "many", samples=128)
    assert "copied" in str(more.status())
    ask["samples"] = 128
    for k in (1, 2):
        whole = rigid.stability_map(
            rigid.FreeBody, store=tmp_path / "many", part=(k, 2), **ask, progress=False
        )
    once = rigid.stability_map(rigid.FreeBody, **ask, progress=False)
    assert whole.receipt()["fingerprint"] == once.receipt()["fingerprint"]
    assert 0 < done < int(once.samples.sum())


def test_maps_of_other_pieces_are_not_merged(tmp_path: Path) -> None:
    ask = {**BOX, "progress": False}
    rigid.stability_map(rigid.FreeBody, store=tmp_path / "few", samples=64, **ask)
    rigid.open_store(tmp_path / "few").extend(tmp_path / "one", samples=128)
    rigid.open_store(tmp_path / "few").extend(tmp_path / "two", samples=128)
    rigid.stability_map(rigid.FreeBody, store=tmp_path / "three", samples=128, part="1/2", **ask)
    both = rigid.merge([tmp_path / "one", tmp_path / "two"], tmp_path / "both")
    assert both.status().twice == 6  # of eight pixels two are no bodies
    with pytest.raises(ValueError, match=r"three: its units have 1048576 samples, the units of"):
        rigid.merge([tmp_path / "one", tmp_path / "three"], tmp_path / "all")


def test_what_cannot_get_more_samples(tmp_path: Path) -> None:
    cases: list[tuple[dict[str, Any], int, str]] = [
        ({"samples": 64}, 64, "samples = 64: must be above 64"),
        ({"samples": 100}, 200, "the 100 stored samples of a pixel must be a multiple of 64"),
        ({"samples": 64, "check": 0.5}, 128, "half_width, refine, budget or a share to check"),
        ({"samples": 64, "budget": 200}, 128, "half_width, refine, budget or a share to check"),
        ({"half_width": 0.2}, 10**6, "half_width, refine, budget or a share to check"),
        ({"samples": 64}, 2**30, "units of 64 samples, more than 4194304; take a new store"),
    ]
    for k, (options, samples, words) in enumerate(cases):
        path = tmp_path / str(k)
        rigid.stability_map(rigid.FreeBody, store=path, **BOX, **options, progress=False)
        with pytest.raises(ValueError, match=words):
            rigid.open_store(path).extend(tmp_path / "more", samples=samples)
        assert not (tmp_path / "more").exists()
    with pytest.raises(ValueError, match="is no running map, and is not empty"):
        rigid.open_store(tmp_path / "0").extend(tmp_path, samples=128)
