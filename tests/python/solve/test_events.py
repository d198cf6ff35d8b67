"""Events of runs against closed forms: all of them, to the error that is stated, and no other."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pint
import pytest
from scipy.special import ellipk, ellipkinc

import quad_motion
import rigid
from physics import METHODS, Floats, present
from refusals import refuses
from rigid.rotations import euler_to_quaternion, quaternion_to_matrix

MOMENTS = (1.0, 2.0, 3.0)
BOX = rigid.FreeBody(rigid.Body(MOMENTS))
LAGRANGE = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0, com=(0.0, 0.0, 1.0))
ASYMMETRIC = rigid.HeavyTop(rigid.Body((1.0, 1.6, 0.7)), mgl=1.2, com=(0.6, 0.0, 0.8))
TILTED = euler_to_quaternion([0.3, 0.5, 0.1])
SERIES = [method.name for method in METHODS if method.series]
OTHERS = [method.name for method in METHODS if not method.series]


class Euler:
    """The free body that begins with ``(a, 0, c)`` and turns about axis 3 on the whole.

    Landau and Lifshitz, Mechanics, § 37: ``omega2 = size sn(rate t, m)``, with the signs of the
    equation ``I2 omega2' = (I3 - I1) omega3 omega1``.
    """

    def __init__(self, a: float, c: float) -> None:
        first, second, third = MOMENTS
        self.start = [a, 0.0, c]
        twice, square = first * a**2 + third * c**2, (first * a) ** 2 + (third * c) ** 2
        self.rate = np.sqrt((third - second) * (square - twice * first) / np.prod(MOMENTS))
        share = (second - first) * (twice * third - square)
        self.m = share / ((third - second) * (square - twice * first))
        self.size = np.sqrt((twice * third - square) / (second * (third - second)))
        self.quarter = ellipk(self.m) / self.rate

    def crossings(self, value: float, until: float) -> Floats:
        """The times at which ``omega2`` is ``value``, by Legendre's integral."""
        first = ellipkinc(np.arcsin(value / self.size), self.m) / self.rate
        turns = 4.0 * self.quarter * np.arange(-1, until / (4.0 * self.quarter) + 1)
        times = np.sort(np.concatenate([first + turns, 2.0 * self.quarter - first + turns]))
        wanted: Floats = times[(times > 1e-9) & (times <= until)]
        return wanted


@pytest.mark.parametrize("method", [None, "exact", *SERIES])
@pytest.mark.parametrize("value", [0.0, 0.1, -0.3])
def test_crossings_of_a_free_body_are_legendres_integrals(method: str | None, value: float) -> None:
    body = Euler(0.7, 0.8)
    expected = body.crossings(value, 200.0)
    assert len(expected) > 40
    run = rigid.simulate(
        BOX, body.start, t=[200.0], method=method, events=rigid.crosses("omega2", value)
    )
    (found,) = run.events
    assert bool(found.complete)
    assert len(found) == len(expected)
    # SciPy's integrals are good to some roundings; the time of the last is 200.
    assert (np.abs(found.t - expected) <= found.error + 4e-15 * expected).all()
    np.testing.assert_allclose(found.t, expected, rtol=1e-12, atol=0.0)
    np.testing.assert_array_equal(found.direction, np.sign(found.slope))
    assert set(found.direction[:2]) == {1, -1}
    np.testing.assert_allclose(found.omega[:, 1], value, rtol=0.0, atol=1e-14 * 200.0)


def test_a_closed_form_keeps_its_crossings_after_ten_thousand_turns() -> None:
    body = Euler(0.7, 0.8)
    expected = body.crossings(0.2, 2e4)
    run = rigid.simulate(BOX, body.start, t=[2e4], events=rigid.crosses("omega2", 0.2))
    (found,) = run.events
    assert len(found) == len(expected) > 4000
    assert (np.abs(found.t - expected) <= found.error + 4e-15 * expected).all()


@pytest.mark.parametrize("method", ["exact", "taylor20", "taylor12"])
def test_a_pair_of_crossings_inside_a_step_is_seen(method: str) -> None:
    body = Euler(0.7, 0.8)
    for below in (1e-3, 1e-6, 1e-9):
        value = body.size * (1.0 - below)
        expected = body.crossings(value, 10.0 * body.quarter)
        pair, end = rigid.crosses("omega2", value), [10.0 * body.quarter]
        (found,) = rigid.simulate(BOX, body.start, t=end, method=method, events=pair).events
        assert found.direction.tolist() == [1, -1] * (len(expected) // 2)
        # Near its largest value the rate is a parabola: rounding of the value moves both.
        error = 1e-15 / np.sqrt(below)
        np.testing.assert_allclose(found.t, expected, rtol=0.0, atol=10.0 * error)
        assert not found.grazing.any()


@pytest.mark.parametrize("method", ["exact", "taylor20"])
def test_what_touches_the_value_is_flagged(method: str) -> None:
    body = Euler(0.7, 0.8)
    events = [rigid.crosses("omega2", share * body.size) for share in (1.0, 1.001)]
    run = rigid.simulate(BOX, body.start, t=[8.0 * body.quarter], method=method, events=events)
    touched, missed = run.events
    assert touched.grazing.all()
    assert not bool(touched.complete)
    assert len(missed) == 0
    assert bool(missed.complete)
    near = touched.t % (4.0 * body.quarter)
    np.testing.assert_allclose(near, body.quarter, rtol=0.0, atol=1e-6)


def test_rates_turn_at_quarter_periods() -> None:
    body = Euler(0.7, 0.8)
    for method in ("exact", "taylor20"):
        end, events = [20.0 * body.quarter + 0.1], [rigid.turns("omega2", way) for way in (0, -1)]
        run = rigid.simulate(BOX, body.start, t=end, method=method, events=events)
        both, largest = run.events
        np.testing.assert_allclose(both.t, body.quarter * np.arange(1, 20, 2), rtol=1e-12)
        sign = np.sign(both.omega[:, 1])
        np.testing.assert_array_equal(both.direction, -sign)
        np.testing.assert_allclose(np.abs(both.omega[:, 1]), body.size, rtol=1e-13)
        np.testing.assert_array_equal(largest.t, both.t[sign > 0])
        late = np.abs(both.t - body.quarter * np.arange(1, 20, 2))
        assert (late <= both.error + 4e-15 * both.t).all()


def test_the_tilt_of_a_lagrange_top_is_that_of_its_closed_form() -> None:
    omega = [0.0, 0.3, 6.0]
    motion = rigid.exact.lagrange_top(LAGRANGE, omega, TILTED)
    limit = 0.5 * float(motion.tilt_min + motion.tilt_max)
    events = [rigid.crosses("tilt3", limit, -1), *(rigid.turns("tilt3", way) for way in (1, -1))]
    run = rigid.simulate(LAGRANGE, omega, TILTED, t=[30.0], events=events)
    falling, least, largest = run.events
    first = float(rigid.exact.tilt_time(LAGRANGE, omega, TILTED, limit=limit))
    assert abs(falling.t[0] - first) <= falling.error[0] + 4e-15 * first
    assert len(falling) > 10
    for event in run.events:
        np.testing.assert_allclose(np.diff(event.t), motion.period, rtol=1e-12)
    np.testing.assert_allclose(falling.tilt(3), limit, rtol=1e-13)
    np.testing.assert_allclose(least.tilt(), motion.tilt_min, rtol=1e-12)
    np.testing.assert_allclose(largest.tilt(), motion.tilt_max, rtol=1e-12)


def test_random_events_agree_with_those_of_another_method() -> None:
    rng = np.random.default_rng(11)
    compared = 0
    for trial in range(24):
        first, second = rng.uniform(0.6, 1.0, 2)
        direction = rng.normal(size=3)
        scene: rigid.FreeBody | rigid.HeavyTop
        if trial % 3 == 0:
            scene = rigid.HeavyTop(rigid.Body((first, first, second)), mgl=rng.uniform(0.1, 3.0))
            methods = ("exact", "taylor20")
        elif trial % 3 == 1:
            com = direction / np.linalg.norm(direction)
            body = rigid.Body((first, second, 0.8))
            scene = rigid.HeavyTop(body, mgl=rng.uniform(0.1, 3.0), com=com, damping=0.1)
            methods = ("taylor20", "taylor16")
        else:
            torque = rigid.Torque.body(rng.normal(size=(3, 3)), times=[0.0, 5.0, 20.0])
            torque += rigid.Torque.space(0.3 * direction)
            scene = rigid.FreeBody(rigid.Body((first, second, 0.8)), torque=torque, damping=0.1)
            methods = ("taylor26", "taylor12")
        axis = int(rng.integers(1, 4))
        events = [
            rigid.crosses(f"omega{axis}", 0.5 * rng.normal()),
            rigid.crosses(f"tilt{axis}", rng.uniform(0.2, 2.9)),
            rigid.crosses(momentum=rng.normal(size=3), value=0.3 * rng.normal()),
            rigid.turns(f"omega{axis}"),
            rigid.turns("L1"),
        ]
        start, attitude = rng.normal(size=3), rng.normal(size=4)
        runs = [
            rigid.simulate(scene, start, attitude, t=[20.0], events=events, method=method)
            for method in methods
        ]
        for one, other in zip(runs[0].events, runs[1].events, strict=True):
            assert len(one) == len(other)
            compared += len(one)
            assert (np.abs(one.t - other.t) <= one.error + other.error).all()
    assert compared > 500


def test_states_of_events_are_those_of_the_run() -> None:
    for scene in (LAGRANGE, ASYMMETRIC):
        events = [rigid.crosses("gamma1", 0.1), rigid.crosses("L1"), rigid.turns("omega2")]
        run = rigid.simulate(scene, [0.3, 0.4, 1.0], TILTED, t=[20.0], events=events)
        for event in run.events:
            assert len(event) >= 2
            states: Any = run.at(event.t)
            np.testing.assert_allclose(states.omega, event.omega, rtol=0.0, atol=1e-12)
            sign = np.sign(states.attitude[:, :1])
            np.testing.assert_allclose(sign * states.attitude, event.attitude, atol=1e-12)
            assert (event.error < 1e-10).all()


STARTS = np.random.default_rng(5).normal(size=(70, 3))


def test_events_change_no_bit_of_the_states() -> None:
    times = np.linspace(0.0, 10.0, 11)
    for scene, method in ((BOX, None), (ASYMMETRIC, "taylor16"), (LAGRANGE, "exact")):
        plain = rigid.simulate(scene, STARTS, TILTED, t=times, method=method)
        events = [rigid.crosses("omega2"), rigid.turns("omega1")]
        watched = rigid.simulate(scene, STARTS, TILTED, t=times, method=method, events=events)
        for name in ("omega", "attitude", "error", "status", "steps", "energy_drift"):
            np.testing.assert_array_equal(getattr(plain, name), getattr(watched, name), name)
        np.testing.assert_array_equal(watched.end, 10.0)
        # An event that is watched with others has the bits of one that is watched alone.
        alone = rigid.simulate(scene, STARTS, TILTED, t=times, method=method, events=events[1])
        for name in ("t", "slope", "error"):
            one, other = alone.events[0], watched.events[1]
            np.testing.assert_array_equal(getattr(one, name), getattr(other, name), name)
        first = watched.events[0]
        np.testing.assert_array_equal(np.repeat(np.arange(70), first.count), first.body)


@pytest.mark.parametrize("method", ["exact", "taylor16", None])
def test_an_event_ends_the_record_of_a_body(method: str | None) -> None:
    times = np.linspace(0.0, 4.0, 41)
    flip = rigid.crosses("omega2", 0.0, -1)
    free = rigid.simulate(BOX, STARTS, t=times, method=method, events=flip)
    ended: Any = rigid.simulate(BOX, STARTS, t=times, method=method, until=flip)
    firsts = [free.events[0].of(body).t[:1] for body in range(70)]
    last = np.array([t[0] if len(t) else 4.0 for t in firsts])
    stopped = np.array([len(t) == 1 for t in firsts])
    assert 20 < stopped.sum() < 70
    assert ended.end is not None
    np.testing.assert_array_equal(ended.end, last)
    np.testing.assert_array_equal(ended.status == rigid.Status.STOPPED, stopped)
    after = times > last[:, np.newaxis]
    assert np.isnan(ended.omega[after]).all()
    assert np.isnan(ended.attitude[after]).all()
    np.testing.assert_array_equal(ended.omega[~after], free.omega[~after])
    known = ~np.isnan(ended.error)
    assert (ended.error[known] <= free.error[known]).all()
    np.testing.assert_array_equal(ended.events[0].count, stopped)
    assert "stopped with its last event" in ended.reasons()
    other = ended.at([1.0, 3.9, 2.0]).omega
    later = np.array([1.0, 3.9, 2.0]) > last[:, np.newaxis]
    np.testing.assert_array_equal(np.isnan(other[..., 0]), later)


def test_a_count_ends_the_record_with_that_event() -> None:
    body = Euler(0.7, 0.8)
    times = body.crossings(0.0, 100.0)
    zero, high = rigid.crosses("omega2"), rigid.crosses("omega2", 0.2)
    run = rigid.simulate(BOX, body.start, t=[0.0, 100.0], until=zero, count=5)
    assert float(np.asarray(run.end)) == run.events[0].t[-1]
    np.testing.assert_allclose(run.events[0].t, times[:5], rtol=1e-12)
    both = rigid.simulate(BOX, body.start, t=[0.0, 100.0], events=[high, zero], count=5)
    assert sum(len(one) for one in both.events) == 5
    last = max(one.t[-1] for one in both.events)
    assert float(np.asarray(both.end)) == last
    # An event of until that is watched already is not watched twice; another one comes last.
    some = rigid.simulate(BOX, body.start, t=[100.0], events=[high, zero], until=[zero])
    assert [one.event for one in some.events] == [high, zero]
    assert len(some.events[1]) == 1
    added = rigid.simulate(BOX, body.start, t=[100.0], events=[high], until=zero, count=2)
    assert [one.event for one in added.events] == [high, zero]
    np.testing.assert_allclose(added.events[1].t, times[:2], rtol=1e-12)
    assert (added.events[0].t < times[1]).all()
    # A body that ends with its last time is not stopped.
    free = rigid.simulate(BOX, body.start, t=[0.0, 1.0], until=zero, count=10**6)
    assert int(free.status) == rigid.Status.OK


def test_bodies_of_several_axes_have_times_of_their_own() -> None:
    starts = STARTS[:6].reshape(2, 3, 3)
    times = np.linspace(0.0, 1.0, 5) * np.arange(10.0, 16.0).reshape(2, 3, 1)
    run: Any = rigid.simulate(BOX, starts, t=times, events=rigid.crosses("omega1"))
    np.testing.assert_array_equal(run.end, times[..., -1])
    event = run.events[0]
    assert event.count.shape == event.complete.shape == (2, 3)
    alone = rigid.simulate(BOX, starts[1, 2], t=times[1, 2], events=rigid.crosses("omega1"))
    np.testing.assert_array_equal(event.of((1, 2)).t, alone.events[0].t)
    assert (event.t <= run.end.ravel()[event.body]).all()
    with pytest.raises(IndexError, match=r"body = \(2, 0\): must be the index of one of the bod"):
        event.of((2, 0))


def test_no_bodies_have_no_events() -> None:
    run = rigid.simulate(BOX, np.zeros((0, 3)), t=[0.0, 1.0], until=rigid.crosses("omega1"))
    assert len(run.events[0]) == 0
    assert run.events[0].offsets.tolist() == [0]
    assert run.at([0.5]).omega.shape == (0, 1, 3)


def test_a_start_with_the_value_is_no_event() -> None:
    run = rigid.simulate(BOX, [0.0, 0.0, 1.0], t=[10.0], events=[rigid.crosses("omega1")])
    assert len(run.events[0]) == 0
    assert not bool(run.events[0].complete)  # it has the value all along
    body = Euler(0.7, 0.8)
    moving = rigid.simulate(BOX, body.start, t=[1.9 * body.quarter], events=rigid.crosses("omega2"))
    assert len(moving.events[0]) == 0
    assert bool(moving.events[0].complete)


def test_events_of_a_body_beside_its_separatrix_are_kept_by_the_closed_form() -> None:
    start = [1e-10, 1.0, 1e-10]
    run = rigid.simulate(BOX, start, t=[400.0], events=rigid.crosses("omega2"))
    expected = rigid.exact.flip_times(BOX, start, count=len(run.events[0]))
    assert len(expected) == 5
    np.testing.assert_allclose(run.events[0].t, expected, rtol=1e-12)


def test_the_stated_error_of_a_turn_covers_the_distance_from_a_sharp_run() -> None:
    """Inside loose steps a rate errs more than the states do."""
    scene = rigid.FreeBody(ASYMMETRIC.body, orbit=rigid.Orbit(0.7))
    rng = np.random.default_rng(5)
    omega, attitude = rng.normal(size=(20, 3)), rng.normal(size=(20, 4))
    watched = [rigid.turns("speed"), rigid.turns("pitch", axes=(1, 3)), rigid.turns("L1")]
    options: dict[str, Any] = {"t": [40.0], "events": watched, "method": "taylor20"}
    loose, sharp = (
        rigid.simulate(scene, omega, attitude, tolerance=size, **options).events
        for size in (1e-9, 1e-17)
    )
    for one, other in zip(loose, sharp, strict=True):
        off = np.abs(one.t - other.t)
        assert len(off) > 600
        assert (off <= one.error + other.error).all()
        # Three times the difference of two runs, the largest until then.
        assert np.quantile(one.error[off > 0.0] / off[off > 0.0], 0.1) < 20.0


def test_events_are_saved_with_their_run(tmp_path: Path) -> None:
    events, end = [rigid.crosses("omega1", 0.1), rigid.turns("L1")], rigid.crosses("omega2")
    run = rigid.simulate(BOX, STARTS[:5], t=[0.0, 20.0], events=events, until=end)
    again = rigid.load_run(run.save(tmp_path / "run.npz"))
    assert len(again.events) == 3
    for one, other in zip(run.events, again.events, strict=True):
        assert one.event == other.event
        np.testing.assert_array_equal(one.t, other.t)
        np.testing.assert_array_equal(one.of(3).omega, other.of(3).omega)
    np.testing.assert_array_equal(run.end, again.end)
    np.testing.assert_array_equal(run.at([3.0]).omega, again.at([3.0]).omega)


@pytest.mark.parametrize("method", ["exact", "taylor16", "rk4", "dop853", "splitting4"])
def test_a_run_is_known_at_other_times(method: str) -> None:
    run = rigid.simulate(BOX, STARTS[:4], TILTED, t=[0.0, 5.0, 10.0], method=method)
    times = [9.9, 0.1, 5.0, 4.7]
    other, truth = run.at(times), rigid.simulate(BOX, STARTS[:4], TILTED, t=sorted(times))
    np.testing.assert_array_equal(other.t, times)
    order = np.argsort(times)
    fastest = np.linalg.norm(truth.omega, axis=-1).max(axis=1)
    apart = np.linalg.norm(other.omega[:, order] - truth.omega, axis=-1).max(axis=1) / fastest
    assert (apart <= other.error + truth.error).all()
    assert (other.error < 1e-3).all()
    assert other.attitude is not None
    assert truth.attitude is not None
    np.testing.assert_allclose(other.attitude[:, order], truth.attitude, atol=3e-3)


def test_at_has_the_bits_of_a_run_with_these_times() -> None:
    times = np.linspace(0.0, 9.0, 7)
    for scene, options in (
        (BOX, {}),
        (ASYMMETRIC, {"method": "taylor16", "tolerance": 1e-12}),
        (LAGRANGE, {"method": "exact", "record": "rates"}),
    ):
        coarse = rigid.simulate(scene, STARTS, TILTED, t=[-2.0, 9.0], **options)
        fine = rigid.simulate(scene, STARTS, TILTED, t=times, **options)
        np.testing.assert_array_equal(coarse.at(times).omega, fine.omega)
    own = rigid.simulate(BOX, STARTS[:2], t=[[0.0, 1.0], [0.0, 2.0]])
    assert own.at([[0.5], [1.5]]).omega.shape == (2, 1, 3)
    assert own.at([0.5, 0.2, 0.9]).omega.shape == (2, 3, 3)
    np.testing.assert_array_equal(
        own.at([[0.9, 0.1], [1.5, 1.0]]).omega[1],
        rigid.simulate(BOX, STARTS[1], t=[1.0, 1.5]).omega[::-1],
    )


def test_at_continues_what_a_torque_does() -> None:
    torque = rigid.Torque.body([(0.0, 0.0, 1.0), (0.0, 0.0, 0.0)], times=[0.0, 10.0])
    scene = rigid.FreeBody(rigid.Body(MOMENTS), torque=torque, damping=0.1)
    run = rigid.simulate(scene, STARTS[:3], t=[0.0, 10.0])
    other = run.at([4.0, 2.0])
    again: Any = rigid.simulate(scene, STARTS[:3], t=[0.0, 2.0, 4.0, 10.0])
    np.testing.assert_allclose(other.omega, again.omega[:, [2, 1]], rtol=0.0, atol=1e-8)
    assert other.work is not None
    np.testing.assert_allclose(other.work, again.work[:, [2, 1]], rtol=0.0, atol=1e-8)


def test_values_with_units_are_numbers_in_si_units() -> None:
    quantity: Any = pint.UnitRegistry().Quantity
    assert np.isclose(rigid.crosses("omega1", quantity(30.0, "rpm")).value, np.pi, rtol=1e-15)
    assert np.isclose(rigid.crosses("tilt2", quantity(90.0, "degree")).value, np.pi / 2.0)
    assert np.isclose(rigid.crosses("L1", quantity(2.0, "g m²/s")).value, 2e-3)
    for name, wrong in (("omega1", "m"), ("gamma1", "kg"), ("tilt1", "s"), ("L3", "J")):
        with pytest.raises(ValueError, match=r"^value in \w+: (must be in|takes numbers)"):
            rigid.crosses(name, quantity(0.5, wrong))
    with pytest.raises(ValueError, match=r"^omega in meter: takes numbers without units"):
        rigid.crosses(omega=quantity([1.0, 0.0, 0.0], "m"))


RUN = rigid.simulate(BOX, [0.1, 1.0, 0.2], t=[0.0, 1.0])
PAIR = rigid.simulate(BOX, STARTS[:2], t=[0.0, 1.0])


def simulated(**options: Any) -> Callable[[], object]:
    return lambda: rigid.simulate(BOX, [0.1, 1.0, 0.2], **{"t": [0.0, 1.0], **options})


ZERO = rigid.crosses("omega1")

test_refused = refuses(
    [
        (
            lambda: rigid.crosses("omega4"),
            "name = 'omega4': did you mean 'omega3'? must be one of 'omega1'",
        ),
        (rigid.turns, "name: give the name of a quantity, or the vectors of one"),
        (
            lambda: rigid.crosses("omega1", gamma=(0, 0, 1)),
            "name = 'omega1': leave the name out beside omega, gamma, momentum",
        ),
        (lambda: rigid.turns(momentum=(0, 0, 0)), "omega, gamma, momentum: all are zero"),
        (lambda: rigid.crosses("omega1", 0.0, 2), "direction = 2: must be 1, -1 or 0"),
        (lambda: rigid.turns("omega1", True), "direction = True: must be 1"),
        (lambda: rigid.crosses("omega1", np.nan), "value = nan: must be finite"),
        (lambda: rigid.crosses("gamma2", 1.0), "value = 1.0: never crossed; along"),
        (lambda: rigid.crosses("tilt1", 3.2), "value = 3.2: never crossed; a tilt lies bet"),
        (lambda: rigid.crosses("speed", 0.0), "value = 0.0: never crossed; a speed is positive"),
        (lambda: rigid.crosses("speed", -1.0), "value = -1.0: never crossed; a speed is positive"),
        (simulated(count=2), "count = 2: needs events or until"),
        (simulated(until=ZERO, count=0), "count = 0: must be at least"),
        (simulated(events=[ZERO] * 33), "events: 33 of them; a run watches 32 at most"),
        (simulated(events=ZERO, t=[-1.0, 1.0]), "t = -1: events are found forward"),
        (lambda: RUN.at([1.5]), "t = 1.5: must be inside the run, which is from t = 0"),
        (
            lambda: RUN.at([1.0 + 1e-9]),
            "t = 1.000000001: must be inside the run, which is from t = 0.0 to 1.0",
        ),
        (lambda: PAIR.at([[0.5], [-0.5]]), "t = -0.5: must be inside the run"),
        (lambda: RUN.at([np.nan]), "t[0] = nan: must be finite"),
        (
            lambda: PAIR.at(np.zeros((3, 1))),
            "t: expected shape (k,) or (2, 'k') for bodies of shape (2,), got (3, 1)",
        ),
        *(
            (simulated(**{argument: wrong}), TypeError, [f"{argument} = ", "must be made by rigid"])
            for argument in ("events", "until")
            for wrong in ("omega1", 3, [ZERO, "omega1"], [abs])
        ),
        *(
            (
                simulated(method=method, events=ZERO),
                [f"method = '{method}': has no events", "'exact', 'taylor12'"],
            )
            for method in OTHERS
        ),
    ],
    literal=True,
)


def test_events_in_the_axes_of_a_drawing_are_those_of_its_components() -> None:
    body, axes = rigid.Body.from_tensor([[2.0, 0.3, 0.0], [0.3, 2.5, 0.1], [0.0, 0.1, 3.0]])
    start, times = np.array([0.3, 1.0, 0.2]), [0.0, 20.0]
    events = [rigid.crosses("omega2", 0.3), rigid.crosses("gamma1", 0.1), rigid.crosses("L1", 0.5)]
    run = rigid.simulate(body, start, TILTED, t=times, frame=axes, events=events)
    for event, component in zip(run.events[:2], ("omega", "gamma"), strict=True):
        assert len(event) >= 1
        along = getattr(event, component)[:, {"omega": 1, "gamma": 0}[component]]
        np.testing.assert_allclose(along, event.event.value, rtol=0.0, atol=1e-13)
        states = run.at(event.t)
        np.testing.assert_allclose(states.omega, event.omega, rtol=0.0, atol=1e-12)
        vertical = quaternion_to_matrix(event.attitude)[:, 2]
        np.testing.assert_allclose(vertical, event.gamma, rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(run.at(run.events[2].t).momentum("space")[:, 0], 0.5, atol=1e-12)
    turned = axes.T @ start, run.in_frame(None).start_attitude
    second = rigid.crosses(omega=axes.T @ [0.0, 1.0, 0.0], value=0.3)
    principal = rigid.simulate(body, *turned, t=times, events=second)
    np.testing.assert_allclose(principal.events[0].t, run.events[0].t, rtol=1e-12)
    back = run.in_frame(None).events[0].omega
    np.testing.assert_allclose(back, principal.events[0].omega, rtol=0.0, atol=1e-12)


def test_a_momentum_that_is_constant_and_never_crosses_disturbs_no_other_event() -> None:
    watched = [rigid.crosses("omega2"), rigid.crosses("gamma3", 0.2)]
    alone, both = (
        rigid.simulate(BOX, STARTS, TILTED, t=[0.0, 9.0], events=events, method="taylor16")
        for events in (watched, [*watched, rigid.crosses("L1", 100.0)])
    )
    assert len(both.events[2]) == 0
    for event, same in zip(alone.events, both.events[:2], strict=True):
        np.testing.assert_array_equal(event.t, same.t)
        assert (same.error < 1e-10).all()


def test_a_run_with_events_keeps_the_accuracy_of_a_run_without_them() -> None:
    omega, times = np.array([0.3, 0.4, 3.0]), np.linspace(0.0, 10.0, 11)
    run = rigid.simulate(ASYMMETRIC, omega, TILTED, t=times, events=rigid.crosses("omega2"))
    truth: Any = quad_motion.motion(ASYMMETRIC, omega, TILTED, times)
    true = truth.rates_off(run.omega) / np.linalg.norm(truth.omega, axis=-1).max()
    assert max(true.max(), truth.attitude_off(present(run.attitude)).max()) <= run.error <= 1e-8
    assert (run.plan.method, run.plan.tolerance) == ("taylor20", 1e-16)
    assert any("inside its steps, where events are" in reason for reason in run.plan.why)
    options: dict[str, Any] = {"t": times, "events": rigid.crosses("omega2"), "accuracy": 1e-5}
    asked = rigid.simulate(ASYMMETRIC, omega, TILTED, **options)
    assert asked.omega.tobytes() == run.omega.tobytes()
