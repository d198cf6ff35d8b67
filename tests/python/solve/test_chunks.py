"""Many bodies in parts are the bodies of one run."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import rigid

FREE = rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0)))
TOP = rigid.HeavyTop(rigid.Body((1.0, 1.6, 0.7)), mgl=1.2, com=(0.6, 0.0, 0.8))
RNG = np.random.default_rng(4)
OMEGA = RNG.normal(size=(70, 3))
ATTITUDE = RNG.normal(size=(70, 4))
TIMES = [0.0, 0.7, 2.0]


@pytest.mark.parametrize("chunk", [1, 32, 69, 70, 1000])
@pytest.mark.parametrize(("scene", "method"), [(FREE, "exact"), (TOP, "taylor12")])
def test_parts_have_the_bits_of_one_run(scene: rigid.FreeBody, method: str, chunk: int) -> None:
    options: dict[str, Any] = {"t": TIMES, "method": method, "check": False}
    whole = rigid.simulate(scene, OMEGA, ATTITUDE, **options)
    parts = list(rigid.simulate_chunks(scene, OMEGA, ATTITUDE, chunk=chunk, **options))
    assert [len(part.omega) for part in parts[:-1]] == [chunk] * (len(parts) - 1)
    for name in ("omega", "attitude", "energy_drift", "status"):
        joined = np.concatenate([getattr(part, name) for part in parts])
        assert joined.tobytes() == getattr(whole, name).tobytes()


@pytest.mark.parametrize("attitude", [None, ATTITUDE[0], Rotation.from_quat(ATTITUDE[0])])
def test_one_attitude_serves_all_bodies(attitude: Any) -> None:
    whole = rigid.simulate(FREE, OMEGA, attitude, t=TIMES)
    parts = rigid.simulate_chunks(FREE, OMEGA, attitude, t=TIMES, chunk=40)
    joined = np.concatenate([part.attitude for part in parts if part.attitude is not None])
    assert joined.tobytes() == (b"" if whole.attitude is None else whole.attitude.tobytes())


def test_one_start_of_the_rates_serves_all_attitudes() -> None:
    parts = list(rigid.simulate_chunks(FREE, OMEGA[0], ATTITUDE, t=TIMES, chunk=64))
    assert [part.omega.shape for part in parts] == [(64, 3, 3), (6, 3, 3)]


def test_no_bodies_have_no_parts() -> None:
    assert not list(rigid.simulate_chunks(FREE, np.empty((0, 3)), t=TIMES))


def test_a_part_is_computed_when_it_is_asked_for() -> None:
    """The states of all bodies together are beyond any memory."""
    omega = np.broadcast_to([0.1, 1.0, 0.2], (10**6, 3))
    times = np.linspace(0.0, 1.0, 10**5)
    assert next(rigid.simulate_chunks(FREE, omega, t=times, chunk=2)).omega.shape == (2, 10**5, 3)
    with pytest.raises(MemoryError, match="states of 1000000 bodies at 100000 times: "):
        rigid.simulate(FREE, omega, t=times)


def test_refused() -> None:
    with pytest.raises(ValueError, match=r"^chunk = 0: must be at least 1$"):
        rigid.simulate_chunks(FREE, OMEGA, t=TIMES, chunk=0)
    with pytest.raises(ValueError, match=r"^omega\[0, 1\] = nan: must be finite$"):
        rigid.simulate_chunks(FREE, [[0.0, np.nan, 0.0]], t=TIMES)
    with pytest.raises(ValueError, match=r"^t\[0\] = 2.0 > t\[1\] = 1.0: times must be ascending$"):
        next(rigid.simulate_chunks(FREE, OMEGA, t=[2.0, 1.0]))


def test_parts_fill_one_memory_map(tmp_path: Path) -> None:
    """Arrays for all bodies, also on the disk, get the states of each part in its rows."""
    whole = rigid.simulate(FREE, OMEGA, ATTITUDE, t=TIMES)
    rates = np.memmap(tmp_path / "omega", dtype="f8", mode="w+", shape=whole.omega.shape)
    parts = list(
        rigid.simulate_chunks(FREE, OMEGA, ATTITUDE, t=TIMES, chunk=32, out={"omega": rates})
    )
    assert all(np.shares_memory(part.omega, rates) for part in parts)
    assert rates.tobytes() == whole.omega.tobytes()


@pytest.mark.parametrize(
    ("out", "kind", "message"),
    [
        (3, TypeError, "out = 3: must be a dict of arrays by their names"),
        (
            {"omega": np.zeros((32, 3, 3))},
            ValueError,
            "out['omega']: expected a row for each of 70 bodies, got shape (32, 3, 3)",
        ),
    ],
)
def test_arrays_that_parts_cannot_fill(out: Any, kind: type[Exception], message: str) -> None:
    with pytest.raises(kind, match=re.escape(message)):
        rigid.simulate_chunks(FREE, OMEGA, t=TIMES, chunk=32, out=out)
