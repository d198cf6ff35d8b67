"""States in arrays of the user, and in single precision."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import rigid
from rigid.model.scene import Scene
from rigid.solve.request import Request
from rigid.solve.starts import bodies_of

FREE = rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0)))
TOP = rigid.HeavyTop(rigid.Body((1.0, 1.6, 0.7)), mgl=1.2, com=(0.6, 0.0, 0.8))
SLOWED = rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0)), damping=(0.1, 0.2, 0.3))
RNG = np.random.default_rng(4)
OMEGA = RNG.normal(size=(40, 3))
TIMES = [0.0, 0.7, 2.0]
ULP = 2.0**-24
"""Relative rounding to single precision."""

CASES: list[tuple[Scene, dict[str, Any]]] = [
    (FREE, {}),
    (FREE, {"record": "rates"}),
    (TOP, {"method": "taylor12"}),
    (TOP, {"method": "rk4", "record": "axis", "check": False}),
    (TOP, {"accuracy": 1e-5}),
    (SLOWED, {"method": "taylor16", "tolerance": 1e-10}),
]

NAMES = {"omega": 3, "gamma": 3, "attitude": 4, "work": 1}


def arrays(run: rigid.Run) -> dict[str, np.ndarray]:
    found = {name: getattr(run, name) for name in NAMES}
    return {name: array for name, array in found.items() if array is not None}


@pytest.mark.parametrize("single_body", [False, True])
@pytest.mark.parametrize(("scene", "options"), CASES)
def test_given_arrays_are_filled_with_the_bits_of_new_ones(
    scene: Scene, options: dict[str, Any], single_body: bool
) -> None:
    omega = OMEGA[0] if single_body else OMEGA
    run = rigid.simulate(scene, omega, t=TIMES, **options)
    out = {name: np.full_like(array, np.nan) for name, array in arrays(run).items()}
    again = rigid.simulate(scene, omega, t=TIMES, **options, out=out)
    for name, array in arrays(run).items():
        assert out[name].tobytes() == array.tobytes()
        assert np.may_share_memory(getattr(again, name), out[name])
        assert getattr(again, name).shape == array.shape
    assert (again.status == run.status).all()


@pytest.mark.parametrize("single_body", [False, True])
@pytest.mark.parametrize(("scene", "options"), CASES)
def test_single_precision_rounds_states_of_double_precision(
    scene: Scene, options: dict[str, Any], single_body: bool
) -> None:
    omega = OMEGA[0] if single_body else OMEGA
    run = rigid.simulate(scene, omega, t=TIMES, **options)
    half = rigid.simulate(scene, omega, t=TIMES, **options, dtype=np.float32)
    for name, array in arrays(run).items():
        rounded = getattr(half, name)
        if name == "work":
            assert rounded.tobytes() == array.tobytes()
        else:
            assert rounded.tobytes() == array.astype(np.float32).tobytes()
            assert (np.abs(rounded - array) <= ULP * np.abs(array)).all()
    known = ~np.isnan(run.error)
    assert np.array_equal(half.error[known], (run.error + 2.0**-23)[known])


def test_given_arrays_may_have_single_precision() -> None:
    out = {"attitude": np.empty((40, 3, 4), dtype=np.float32)}
    run = rigid.simulate(FREE, OMEGA, t=TIMES, out=out)
    plain = rigid.simulate(FREE, OMEGA, t=TIMES)
    assert plain.attitude is not None
    assert out["attitude"].tobytes() == plain.attitude.astype(np.float32).tobytes()
    assert run.omega.tobytes() == plain.omega.tobytes()


def test_the_same_arrays_are_filled_again_and_again() -> None:
    out = {"omega": np.empty((40, 3, 3)), "attitude": np.empty((40, 3, 4))}
    for factor in (1.0, 2.0):
        rigid.simulate(FREE, factor * OMEGA, t=TIMES, out=out)
        assert np.array_equal(out["omega"], rigid.simulate(FREE, factor * OMEGA, t=TIMES).omega)


READ_ONLY = np.empty((40, 3, 3))
READ_ONLY.flags.writeable = False


@pytest.mark.parametrize(
    ("options", "error", "words"),
    [
        ({"dtype": np.float16}, ValueError, "dtype = float16: must be float64 or float32"),
        ({"out": {"omega": [0.0]}}, TypeError, "out['omega'] = [0.0]: must be an array"),
        (
            {"out": {"gamma": np.empty((40, 3, 3))}},
            ValueError,
            "out = 'gamma': must be one of 'omega'",
        ),
        (
            {"out": {"omega": np.empty((40, 3))}},
            ValueError,
            "out['omega']: must be writeable and C-contiguous, of shape (40, 3, 3) and float64",
        ),
        ({"out": {"omega": np.empty((40, 3, 3), dtype=int)}}, ValueError, "out['omega']: must be"),
        ({"out": {"omega": np.empty((40, 3, 6))[..., ::2]}}, ValueError, "out['omega']: must be"),
        ({"out": {"omega": READ_ONLY}}, ValueError, "out['omega']: must be writeable"),
        (
            {"dtype": np.float32, "accuracy": 1e-7},
            ValueError,
            "accuracy = 1e-07: must be at least 1.2e-07 in float32",
        ),
    ],
)
def test_refused(options: dict[str, Any], error: type[Exception], words: str) -> None:
    with pytest.raises(error) as caught:
        rigid.simulate(FREE, OMEGA, t=TIMES, **options)
    assert str(caught.value).startswith(words)


@pytest.mark.parametrize("rate", [1e-31, 1e31])
def test_rates_beyond_single_precision_are_refused(rate: float) -> None:
    omega = [[0.0, 1.0, 0.0], [0.0, rate, 0.0]]
    with pytest.raises(
        ValueError, match=r"^dtype = float32: the rates of body 1 reach 1\.53e[+-]31 rad"
    ):
        rigid.simulate(FREE, omega, t=[0.0], dtype=np.float32)


@pytest.mark.parametrize("array", [np.empty((1, 2, 3)), np.empty((1, 1, 3), dtype=int)])
def test_the_core_refuses_arrays_that_it_cannot_fill(array: np.ndarray) -> None:
    with pytest.raises(
        ValueError, match=r"^omega: expected shape \[1, 1, 3\] of float64 or float32"
    ):
        Request(
            bodies=bodies_of(FREE, [1.0, 1.0, 1.0]),
            times=np.zeros(1),
            method="exact",
            record="rates",
            max_steps=1,
            threads=1,
        ).states(None, out={"omega": array})
