"""Every quantity of an event, of every kind of motion, against signs of states from SciPy.

The equations of motion are written down once more below: the states share no line with the
library. A quantity that keeps its sign between thousands of times, but for pairs that lie between
two of them, crosses its value only where the signs differ.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

import rigid
from free_motions import slowing_ball
from physics import METHODS, Floats
from printed_equations import solved

SERIES = [method.name for method in METHODS if method.series]
UNTIL = 12.0
TIMES = np.linspace(0.0, UNTIL, 6001)
NEAR = 1e-9
"""SciPy's states at a tolerance of 1e-13 are good to some 1e-11 here; the slopes exceed 1e-2."""


@dataclass(frozen=True)
class Motion:
    """A body with its start, what acts on it, and the methods that know its events."""

    scene: rigid.FreeBody | rigid.HeavyTop
    methods: tuple[str | None, ...]
    omega: tuple[float, float, float] = (0.5, 0.8, -1.1)
    attitude: tuple[float, float, float, float] = (0.9, 0.3, 0.2, 0.1)

    def states(self) -> tuple[Floats, Floats, Floats]:
        """Rates, verticals in the body and momenta in space at all times."""
        omega, matrices = solved(self.scene, self.omega, self.attitude, TIMES)
        rotor = 0.0 if self.scene.rotor is None else np.array(self.scene.rotor)
        momenta = np.matvec(matrices, omega * self.scene.body.moments + rotor)
        return omega, matrices[:, 2], momenta


ASYMMETRIC, SYMMETRIC = rigid.Body((1.0, 1.6, 0.7)), rigid.Body((1.0, 1.0, 0.5))
ROTOR = (0.2, 0.1, 0.6)
TORQUES = ((0.1, -0.2, 0.05), (-0.15, 0.1, 0.2))
MOTIONS = {
    "free": Motion(rigid.FreeBody(ASYMMETRIC), (None, *SERIES)),
    "free symmetric": Motion(rigid.FreeBody(SYMMETRIC), (None, "taylor16")),
    "lagrange": Motion(rigid.HeavyTop(SYMMETRIC, mgl=1.2), (None, *SERIES)),
    "asymmetric": Motion(rigid.HeavyTop(ASYMMETRIC, mgl=1.2, com=(0.6, 0.0, 0.8)), (None, *SERIES)),
    "forced": Motion(
        rigid.FreeBody(
            ASYMMETRIC,
            torque=rigid.Torque.body(TORQUES[0]) + rigid.Torque.space(TORQUES[1]),
            damping=0.05,
        ),
        (None, *SERIES),
    ),
    "damped top": Motion(
        rigid.HeavyTop(ASYMMETRIC, mgl=1.2, com=(0.6, 0.0, 0.8), damping=0.05), (None, "taylor16")
    ),
    "satellite": Motion(
        rigid.FreeBody(ASYMMETRIC, rotor=ROTOR, orbit=rigid.Orbit(0.7)), (None, *SERIES)
    ),
}
DIRECTIONS = {"omega": (0.3, -0.7, 0.4), "gamma": (0.5, 0.6, -0.9), "momentum": (-0.4, 0.8, 0.3)}


def watched(quantities: dict[str, Floats]) -> list[tuple[rigid.Event, Floats]]:
    """Events with what changes its sign at each: a value that is crossed, and slopes."""
    both = []
    for name, values in quantities.items():
        low, high = float(values.min()), float(values.max())
        if high - low < 1e-6:  # a constant of the motion is crossed nowhere
            continue
        level = low + 0.37 * (high - low)
        how: dict[str, Any] = {"name": name} if name not in DIRECTIONS else {name: DIRECTIONS[name]}
        both.append((rigid.crosses(value=level, **how), values - level))
        both.append((rigid.turns(**how), np.diff(values)))
    return both


@pytest.mark.parametrize("name", MOTIONS)
def test_each_quantity_crosses_and_turns_where_its_states_do(name: str) -> None:
    motion = MOTIONS[name]
    omega, gamma, momentum = motion.states()
    quantities = {
        **{f"omega{k + 1}": omega[:, k] for k in range(3)},
        **{f"gamma{k + 1}": gamma[:, k] for k in range(3)},
        **{f"tilt{k + 1}": np.arccos(gamma[:, k]) for k in range(3)},
        **{f"L{k + 1}": momentum[:, k] for k in range(3)},
        "speed": np.linalg.norm(omega, axis=1),
        "omega": omega @ DIRECTIONS["omega"],
        "gamma": gamma @ DIRECTIONS["gamma"],
        "momentum": momentum @ DIRECTIONS["momentum"],
    }
    pairs = watched(quantities)
    assert len(pairs) >= 22 if not name.startswith("free") else len(pairs) >= 14
    events = [event for event, _ in pairs]
    for method in motion.methods:
        start = motion.scene, motion.omega, motion.attitude
        run = rigid.simulate(*start, t=[0.0, UNTIL], events=events, method=method)
        for found, (event, values) in zip(run.events, pairs, strict=True):
            words = f"{method}: {event.words()}"
            assert bool(found.complete), words
            times = TIMES if len(values) == len(TIMES) else 0.5 * (TIMES[1:] + TIMES[:-1])
            # Only the signs between other times are told by those of the states.
            places = np.flatnonzero(np.diff(np.signbit(values)))
            inside = (found.t > times[0]) & (found.t < times[-1])
            assert len(places) == inside.sum(), words
            early = found.t[inside] - times[places]
            late = times[places + 1] - found.t[inside]
            # A slope from differences is that of the middle to the square of the gap.
            slack = NEAR if values.size == TIMES.size else 1e-5
            assert early.min(initial=0.0) > -slack, words
            assert late.min(initial=0.0) > -slack, words
            rising = np.where(values[places + 1] > values[places], 1, -1)
            np.testing.assert_array_equal(found.direction[inside], rising, words)


@pytest.mark.parametrize("method", [None, "taylor16"])
def test_an_event_at_the_end_is_one_and_at_the_start_is_none(method: str | None) -> None:
    # About axis 3 the first axis of space is level with body axis 1 every half turn.
    body = rigid.FreeBody(rigid.Body((1.0, 1.0, 1.5)))
    flat = rigid.rotations.euler_to_quaternion([0.0, np.pi / 2.0, 0.0])
    rate, level = np.pi / 4.0, rigid.crosses("gamma1", 0.0)
    for share, count in ((1.0 + 1e-13, 3), (1.0 - 1e-13, 2)):
        run = rigid.simulate(
            body, [0.0, 0.0, rate], flat, t=[0.0, 12.0 * share], events=level, method=method
        )
        (found,) = run.events
        # At 0 gamma1 = sin(rate t) begins to rise: it is no crossing; then at 4, 8 and 12 s.
        assert len(found) == count
        np.testing.assert_allclose(found.t, [4.0, 8.0, 12.0][:count], rtol=1e-14)
        np.testing.assert_array_equal(found.direction, [-1, 1, -1][:count])


@pytest.mark.parametrize("method", [None, "taylor16"])
@pytest.mark.parametrize("value", [1e-4, 1e-8, 0.0, -1e-8])
def test_a_component_of_the_momentum_that_touches_its_value(
    method: str | None, value: float
) -> None:
    # Under a torque in space that is linear in the time, L2 is the parabola (t - 3)²: it touches
    # the value 0, crosses a value above it twice, and misses one below.
    torque = rigid.Torque.space([(0.0, -6.0, 0.0), (0.0, 18.0, 0.0)], times=[0.0, 12.0])
    scene = rigid.FreeBody(rigid.Body((1.0, 1.4, 1.8)), torque=torque)
    start = np.array([0.0, 9.0, 0.0]) / 1.4
    run = rigid.simulate(
        scene, start, t=[0.0, 12.0], events=rigid.crosses("L2", value), method=method
    )
    (found,) = run.events
    if value > 0.0:
        # Rounding of L2, 81 at most, over the slope.
        error = 64.0 * 81.0 * 2.0**-52 / (2.0 * np.sqrt(value))
        expected = 3.0 + np.sqrt(value) * np.array([-1.0, 1.0])
        np.testing.assert_allclose(found.t, expected, rtol=0.0, atol=error)
        np.testing.assert_array_equal(found.direction, [-1, 1])
        assert bool(found.complete)
    elif value == 0.0:
        assert found.grazing.all()
        assert not bool(found.complete)
        np.testing.assert_allclose(found.t, 3.0, atol=1e-6)
    else:
        assert len(found) == 0
        assert bool(found.complete)


@pytest.mark.parametrize("way", ["damping", "drag", "callback"])
def test_a_run_ends_when_the_body_is_slow(way: str) -> None:
    rates = np.array([[0.3, -0.2, 0.9], [2.0, 1.0, -0.5], [0.05, 0.0, 0.0]])
    speed, slow = np.linalg.norm(rates, axis=1), 0.1
    ball = slowing_ball(way)
    with np.errstate(invalid="ignore"):
        expected = 4.0 * (1.0 / slow - 1.0 / speed) if way == "drag" else 4.0 * np.log(speed / slow)
    run = rigid.simulate(ball, rates, t=[0.0, 200.0], until=rigid.crosses("speed", slow, -1))
    (found,) = run.events
    assert found.count.tolist() == [1, 1, 0]  # the last one is slow from the start
    np.testing.assert_allclose(found.t, expected[:2], rtol=1e-9)
    assert (np.abs(found.t - expected[:2]) <= found.error).all()
    np.testing.assert_allclose(np.linalg.norm(found.omega, axis=1), slow, rtol=1e-9)
    assert np.isnan(run.omega[:2, -1]).all()
    assert np.isfinite(run.omega[2]).all()


def test_an_event_says_which_way_its_quantity_goes() -> None:
    crossed = [rigid.crosses("omega2", 0.5, way).words() for way in (1, -1, 0)]
    assert crossed == [f"omega2 = 0.5, {way}" for way in ("rising", "falling", "both ways")]
    turned = [rigid.turns("gamma3", way).words() for way in (1, -1, 0)]
    assert turned == [f"gamma3 {way}" for way in ("lowest", "highest", "turns")]
