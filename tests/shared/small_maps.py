"""Small maps that the tests of the map layer share."""

import dataclasses
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import rigid
from rigid.maps.data import STORED
from rigid.store.drive import Intake

Floats = NDArray[np.float64]

#: Everything in a result that is no measurement of the machine.
NAMED = (*STORED, "samples", "share", "lower", "upper")


def small_map(scene: Any = rigid.FreeBody, **options: Any) -> rigid.StabilityMap:
    """An integrated map of 5 x 7 pixels across the flip of a free body, unless told otherwise."""
    chosen: dict[str, Any] = {
        "method": "rk4",
        "axes": {"I2/I1": np.linspace(1.01, 1.99, 7), "noise": np.geomspace(1e-3, 0.1, 5)},
        "samples": 20,
        "t_end": 20.0,
        "stable": rigid.no_flip(),
        "rng": 1,
        "progress": False,
    }
    return rigid.stability_map(scene, **{**chosen, **options})


@contextmanager
def in_blocks(units: int) -> Iterator[None]:
    """Maps are computed so many units at a time, as by a machine of that speed."""
    patched = pytest.MonkeyPatch()
    fixed = property(lambda _: units, lambda _, fitted: None)
    patched.setattr(Intake, "units", fixed, raising=False)
    try:
        yield
    finally:
        patched.undo()


def saved_bytes(result: rigid.StabilityMap, folder: Path) -> bytes:
    """What the file of a map holds."""
    return result.save(folder / "map.npz").read_bytes()


def assert_same_map(one: rigid.StabilityMap, other: rigid.StabilityMap) -> None:
    """All numbers of two results agree to the bit."""
    for name in NAMED:
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name), err_msg=name)
        assert getattr(one, name).dtype == getattr(other, name).dtype


def spec_of(**options: Any) -> rigid.MapSpec:
    """The specification of :func:`small_map`, from a map that costs nothing."""
    spec = small_map(**{**options, "samples": 1, "t_end": 1e-6}).spec
    return dataclasses.replace(
        spec, samples=options.get("samples", 20), t_end=options.get("t_end", 20.0)
    )
