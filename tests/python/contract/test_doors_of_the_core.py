"""The compiled module refuses what `rigid` never gives it: no panic, no half-done change."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import rigid
from refusals import refuses
from rigid import _core
from rigid.model.bodies import bodies_of
from rigid.solve.request import Request

SCENE = rigid.FreeBody(rigid.Body((1.0, 1.5, 2.0)))
OMEGA = np.array([[0.1, 1.0, 0.2], [0.3, -0.5, 0.9]])
MOST = 2**63


def unaligned(array: Any) -> Any:
    """The same numbers at an odd address, contiguous."""
    memory = np.zeros(array.nbytes + 1, np.int8)
    copy = memory[1:].view(array.dtype).reshape(array.shape)
    copy[...] = array
    assert copy.flags.c_contiguous
    assert not copy.flags.aligned
    return copy


def test_numbers_at_odd_addresses_are_the_same_numbers() -> None:
    one = unaligned(np.array([3, 7]))
    for plain, odd in [
        (_core.clopper_pearson(np.array([3, 7]), np.array([9, 9]), 0.9),
         _core.clopper_pearson(one, np.array([9, 9]), 0.9)),
        (_core.elliptic("rc", [OMEGA[:, 1], OMEGA[:, 2]]),
         _core.elliptic("rc", [unaligned(OMEGA[:, 1]), unaligned(OMEGA[:, 2])])),
    ]:  # fmt: skip
        assert all(a.tobytes() == b.tobytes() for a, b in zip(plain, odd, strict=True))
    bodies, moved = bodies_of(SCENE, OMEGA, None), bodies_of(SCENE, OMEGA, None)
    moved.omega, moved.moments = unaligned(moved.omega), unaligned(moved.moments)
    assert _core.fastest_rates(moved).tobytes() == _core.fastest_rates(bodies).tobytes()
    assert _core.first_slow(unaligned(OMEGA), 0.0, 0.95) == _core.first_slow(OMEGA, 0.0, 0.95) == 1


def test_a_force_acts_on_as_many_bodies_as_it_has_rows() -> None:
    none = np.empty((0, 3))
    with pytest.raises(ValueError, match=r"torque: expected shape \(2, 3\), got \(0, 3\)"):
        _core.Forces(times=np.arange(2.0), body=none, space=none, damping=np.eye(2, 6))
    forces = _core.Forces(times=np.empty(0), body=none, space=none, damping=np.eye(2, 6))
    assert forces.kinds(2).tolist() == [2, 2]
    with pytest.raises(
        ValueError, match=r"bodies: expected shape \(2, \.\.\.\), got \(3, \.\.\.\)"
    ):
        forces.kinds(3)
    bodies = bodies_of(SCENE, OMEGA, None)
    for rows, units, words in ((3, 1, "forces: expected"), (2, 3, "units: expected")):
        damping = np.eye(rows, 6)
        bodies.forces = _core.Forces(times=np.empty(0), body=none, space=none, damping=damping)
        with pytest.raises(ValueError, match=words):
            _core.Motion(bodies, method="rk4", time=0.0, units=np.ones(units), threads=1)


def test_no_rows_of_moments_are_no_bodies() -> None:
    none = np.empty((0, 3))
    for rows in (1, 2):
        forces = _core.Forces(
            times=np.empty(0), body=none, space=none, damping=np.ones((rows, 1)) * np.eye(1, 6)
        )
        for rates in (forces.slows_evenly, forces.damping_rates):
            assert len(rates(np.ones((1, 3)))) == rows
            if rows == 1:
                assert len(rates(none)) == 0
            else:
                with pytest.raises(ValueError, match=r"moments: expected shape \(2, \.\.\.\)"):
                    rates(none)


def test_times_of_no_body_beyond_any_array_are_refused() -> None:
    bodies = bodies_of(SCENE, np.empty((0, 3)), None)
    with pytest.raises(ValueError, match=r"reshape|too big"):
        _core.flip_times(bodies, 1, 2**62)


def test_a_direction_of_an_orbit_needs_an_orbit() -> None:
    pairs = np.zeros((2, 2, 3))
    pairs[0, [0, 1], [0, 2]] = 1.0
    with pytest.raises(ValueError, match="events = a direction of the orbit: the bodies are on no"):
        _core.section(
            bodies_of(SCENE, OMEGA, None),
            method="taylor16",
            kinds=[(False, 0, True, pairs, True, (0, False))],
            surfaces=np.zeros((2, 11 + _core.MOST_STATES)),
            ends=np.ones(2),
            count=1,
            closed=False,
            check=False,
            tolerance=1e-12,
            max_steps=1000,
            threads=1,
        )


def test_there_may_be_more_threads_than_numbers() -> None:
    """Blocks of bodies were as long as a quotient by four times the threads, which was zero."""
    n = 64
    bodies = bodies_of(SCENE, np.tile(OMEGA[0], (n, 1)), None)
    how: dict[str, Any] = {"method": "taylor16", "max_steps": 1000, "threads": MOST}
    crossings = _core.section(
        bodies,
        **how,
        kinds=[(False, 0, False, np.zeros((2, 2, 3)), False, (0, False))],
        surfaces=np.eye(1, 11 + _core.MOST_STATES).repeat(n, axis=0),
        ends=np.ones(n),
        count=1,
        closed=False,
        check=False,
        tolerance=1e-12,
    )
    assert len(crossings["status"]) == n
    # Neighbours with other numbers of steps share no group of lanes.
    growths = _core.growth(
        bodies,
        **how,
        deviations=np.tile(_core.generic_deviations()[:1], (n, 1)),
        of_attitude=False,
        times=np.array([1.0]),
        step=np.tile([0.1, 0.2], n // 2),
    )
    assert len(growths["status"]) == n


PART = {**_core.MapStatistics(1).arrays(), "pixels": np.array([0])}
BIN = [0, 65472, 2, 0, 10, 10, 0, 100, 0, -1]
"""Row of the part; key, count, offsets from 0 to 10, the halves of their sum and squares, and no
error."""


def changed(place: int, value: int) -> dict[str, Any]:
    row = BIN.copy()
    row[place] = value
    return {**PART, "stable": np.array([7]), "measures": [np.array([BIN, row])]}


@pytest.mark.parametrize(
    ("part", "words"),
    [
        ({**changed(1, 65473), "stable": np.array([-1])}, "stable = -1: must not be negative"),
        ({**changed(1, 65473), "pixels": np.array([1])}, "part = pixel 1 of 1: must be pixels"),
        (changed(0, 1), "part = a bin of row 1 of 1: must be pixels"),
        (changed(1, 1 << 17), r"a bin = \[131072, .*: must be numbers of finite values"),
        (changed(2, -2), r"a bin = \[65472, -2, .*: must be numbers of finite values"),
        (changed(3, 11), r"a bin = \[65472, 2, 11, 10, .*: must be numbers of finite values"),
        (changed(4, 1 << 46), r"a bin = .*: must be numbers of finite values"),
        (changed(5, 21), r"a bin = .*: must be numbers of finite values"),
        (changed(8, 1), r"a bin = .*: must be numbers of finite values"),
        (changed(9, 0x7FF << 52), r"a bin = .*: must be numbers of finite values"),
        (changed(2, 1 << 36), r"values of a pixel = 68719476742: must be at most 2\^36"),
        (
            {**changed(1, 65473), "stable": np.array([2**63 - 8])},
            "part = stable of pixel 0: must have sums below 2\\^63",
        ),
        (
            {**changed(1, 65473), "growth": np.array([-(2**63)])},
            "part = growth of pixel 0: must have sums below 2\\^63",
        ),
        (
            {
                name: values if name == "measures" else np.repeat(values, 2)
                for name, values in (changed(1, 65473) | {"steps": np.array([1 << 62])}).items()
            },
            "part = steps of pixel 0: must have sums below 2\\^63",
        ),
    ],
)
def test_a_part_that_is_refused_changes_no_statistics(part: dict[str, Any], words: str) -> None:
    statistics = _core.MapStatistics(1, 1)
    statistics.merge(changed(1, 65473))
    arrays, bins = statistics.arrays(), statistics.bins()
    assert (arrays["stable"].tolist(), bins[0].shape) == ([7], (2, 10))
    with pytest.raises(ValueError, match=words):
        statistics.merge(part)
    for name, values in statistics.arrays().items():
        assert np.array_equal(values, arrays[name], equal_nan=True), name
    assert np.array_equal(statistics.bins(), bins)


REQUEST = Request(
    bodies=bodies_of(SCENE, OMEGA, None),
    times=np.array([1.0, 2.0]),
    method="taylor16",
    record="attitude",
    max_steps=1000,
    threads=1,
    tolerance=1e-12,
)


test_states_of_an_accuracy_are_refused_where_the_request_does_not_fit = refuses(
    [
        ({}, np.ones(3), r"step: expected shape \(2, "),
        ({"times": np.ones((3, 2))}, None, r"t: expected shape \(2, "),
        ({"times": np.ones((1, 1, 1))}, None, r"t: expected shape \(m,\)"),
        ({"method": "euler"}, None, "method = 'euler'"),
        ({"method": "rk4"}, None, "tolerance = "),
        ({"method": "exact"}, None, "method = 'exact'"),
        ({"strides": [1, 2]}, None, "strides = given: an accuracy is of states at times"),
    ],
    by=lambda changes, step: _core.solve(replace(REQUEST, **changes), step, 1e-8, True, False),
)


def test_errors_and_distances_are_refused_for_states_of_another_shape() -> None:
    states = REQUEST.states()
    with pytest.raises(ValueError, match="omega: expected shape"):
        _core.errors_of_closed_forms(REQUEST.bodies, REQUEST.times, np.ones((2, 1, 3)))
    with pytest.raises(ValueError, match="scale: expected shape"):
        _core.distances(states, states, np.ones(3))
    for name, value in [
        ("omega", np.ones((2, 2, 4))),
        ("gamma", np.ones((1, 2, 3))),
        ("attitude", np.ones((2, 2, 3))),
        ("work", np.ones((2, 3))),
    ]:
        with pytest.raises(ValueError, match=rf"{name}: expected shape"):
            _core.distances(states, {**states, name: value})


def test_distances_of_states_in_another_order_of_memory_are_the_same() -> None:
    states = {**REQUEST.states()}
    other = {**states, "omega": states["omega"] + 0.1}
    turned = {**other, "omega": np.asfortranarray(other["omega"])}
    plain = _core.distances(states, other)
    assert plain.min() > 0.0
    assert plain.tobytes() == _core.distances(states, turned).tobytes()
