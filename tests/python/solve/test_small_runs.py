"""Runs of few bodies: their arrays are made when they are read."""

from __future__ import annotations

from collections.abc import MutableMapping
from typing import Any

import numpy as np
import pytest

import rigid
from rigid import _core
from rigid.solve.request import Request
from rigid.solve.starts import bodies_of

FREE = rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0)))
RATES = [0.1, 1.0, 0.2]


def states(count: int, times: int = 1) -> _core.States:
    request = Request(
        bodies=bodies_of(FREE, np.tile(RATES, (count, 1))),
        times=np.linspace(1.0, 2.0, times),
        method="exact",
        record="attitude",
        max_steps=1,
        threads=1,
    )
    return request.states(None)


def test_states_of_few_and_of_many_bodies_have_the_same_columns() -> None:
    few, many = states(2), states(200)
    assert isinstance(few, MutableMapping)
    assert {*few} == {*many}
    assert few.worst == many.worst == few.error.max()
    assert {name for name in few if few[name] is None} == {"gamma", "tangent", "work"}
    for name in {*few} - {"nanoseconds", "gamma", "tangent", "work"}:
        assert few[name].dtype == many[name].dtype
        assert np.array_equal(few[name], many[name][:2])


def test_states_are_a_mapping() -> None:
    few = states(1)
    omega = few["omega"]
    assert few["omega"] is omega
    assert few.get("omega") is omega
    assert (few.get("spin"), few.get("spin", 3)) == (None, 3)
    assert "steps" in few
    assert few.pop("steps") == 0
    assert "steps" not in few
    few["status"] = omega
    assert few["status"] is omega
    del few["status"]
    with pytest.raises(KeyError, match="status"):
        few["status"]
    assert len(few) == len(dict(few)) == len({**few})


def test_the_attributes_of_a_run_are_read_only() -> None:
    run = rigid.simulate(FREE, RATES, t=[1.0])
    for name in ("t", "omega", "events", "spec", "nanoseconds"):
        with pytest.raises(AttributeError):
            setattr(run, name, None)


@pytest.mark.parametrize("rates", [RATES, tuple(RATES), np.array(RATES), np.array([RATES])[0]])
def test_numbers_are_the_same_however_they_are_given(rates: Any) -> None:
    run = rigid.simulate(FREE, rates, t=(1,))
    assert (
        run.omega.tobytes() == rigid.simulate(FREE, [*map(np.float64, RATES)], t=1).omega.tobytes()
    )


@pytest.mark.parametrize(
    "value",
    [[True, 0.0], ["1"], [2**53 + 1], [np.float32(1)], [], [[1.0]], 1.0, np.array(1.0), [np.nan]],
)
def test_what_is_not_plain_is_left_to_the_checks(value: Any) -> None:
    assert _core.plain_numbers(value) is None


def test_an_array_of_plain_numbers_is_itself() -> None:
    array = np.array([[0.0, 1.0, 2.0]])
    assert _core.plain_numbers(array, 3) is array
    assert _core.plain_numbers(array, ascending=True) is array
    for refused in (array[:, ::2], array.astype(">f8"), np.ma.array(array), array[:, ::-1].copy()):
        assert _core.plain_numbers(refused, 3, ascending=True) is None
    assert _core.plain_numbers(array, 2) is None
