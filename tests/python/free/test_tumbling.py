"""Tumbling bodies by two periods: of an integration, of asteroids, and back to the state."""

import math
from typing import Any

import numpy as np
import pytest

import rigid
from printed_equations import solved
from refusals import refuses
from rigid import exact, free


@pytest.mark.parametrize(
    ("moments", "omega", "mode"),
    [
        ((1.0, 2.0, 2.5), (0.3, 0.4, 1.0), "SAM"),
        ((2.5, 1.0, 2.0), (-1.0, 0.3, 0.4), "SAM"),
        ((1.0, 2.0, 2.5), (1.5, 0.4, 0.6), "LAM"),
        ((3.235, 3.0836, 1.0), (0.588, 0.253, -1.719), "LAM"),
        ((0.61, 0.965, 1.0), (0.01, 0.2, 0.11), "SAM"),
        ((1.0, 1.0, 1.6), (0.3, 0.1, 1.0), "SAM"),
        ((0.4, 1.0, 1.0), (1.0, 0.2, 0.5), "LAM"),
    ],
)
def test_periods_are_those_of_an_integration(
    moments: tuple[float, ...], omega: tuple[float, ...], mode: str
) -> None:
    """After a period the rates return, and not before; the long axis turns on about L alike."""
    found = free.spin_periods(moments, omega)
    assert found.mode == mode
    t = float(found.rotation) * np.linspace(0.0, 3.0, 3001)
    scene = rigid.FreeBody(rigid.Body(moments))
    rates, to_space = solved(scene, omega, [1.0, 0.0, 0.0, 0.0], t)
    away = np.linalg.norm(rates - omega, axis=1) / np.linalg.norm(omega)
    # The tolerance of the integration is 1e-13; over three periods errors grow to some 1e-10.
    assert away[[1000, 2000, 3000]].max() < 1e-8
    assert away[100:900].min() > 1e-2
    pole = np.array(moments) * omega
    across = np.cross(pole, [0.36, 0.48, 0.8])
    axis = to_space[:, :, np.argmin(moments)]
    sine, cosine = axis @ np.cross(pole, across) / np.linalg.norm(pole), axis @ across
    turns = np.ptp(np.unwrap(np.arctan2(sine, cosine))[[0, -1]]) / (2.0 * np.pi)
    assert t[-1] / turns == pytest.approx(float(found.precession), rel=1e-8)


def test_a_symmetric_body_has_the_rates_of_euler() -> None:
    """Prolate: phi' = L/I, psi' = L cos(theta) (1/I3 - 1/I); Landau and Lifshitz, § 33."""
    across, along, momentum, tilt = 1.0, 0.4, 2.0, 1.1
    omega = np.array([momentum * np.sin(tilt) / across, 0.0, momentum * np.cos(tilt) / along])
    found = free.spin_periods((across, across, along), omega)
    assert found.mode == "LAM"
    turned = momentum * np.cos(tilt) * (1.0 / along - 1.0 / across)
    assert float(found.precession) == pytest.approx(2.0 * np.pi * across / momentum, rel=1e-14)
    assert float(found.rotation) == pytest.approx(2.0 * np.pi / turned, rel=1e-14)


def test_a_state_has_the_periods_it_was_made_from() -> None:
    """From small nutations to 1e-150 beside the separatrix, for many bodies of one call."""
    rng = np.random.default_rng(2026)
    moments = np.sort(rng.uniform(0.5, 1.0, (200, 3)), axis=1)  # any of these are possible
    small, middle, large = moments.T
    shuffled = rng.permuted(moments, axis=1)
    slow = np.sqrt((middle - small) * (large - small) / (middle * large))
    least = {
        "SAM": np.sqrt(small * middle / ((large - small) * (large - middle))),
        "LAM": (1.0 - slow) / slow,
    }
    for mode, limit in least.items():
        for above in (1e-6, 0.3, 3.0, 30.0):
            rotation = 7.0 * limit * (1.0 + above)
            found = free.spin_state(shuffled, precession=7.0, rotation=rotation, mode=mode)
            assert np.all(found.mode == mode)
            again = free.spin_periods(shuffled, found.omega)
            np.testing.assert_array_equal(again.rotation, found.rotation)
            np.testing.assert_allclose(found.precession, 7.0, rtol=1e-13)
            # Rounding of the ratio of the moments moves the limit of small nutations by 1e-15.
            np.testing.assert_allclose(found.rotation, rotation, rtol=1e-12)
            bounds = (
                (np.ones(200), large / middle) if mode == "SAM" else (large / middle, large / small)
            )
            assert (found.energy > bounds[0] * (1.0 - 1e-13)).all()
            assert (found.energy < bounds[1] * (1.0 + 1e-13)).all()


@pytest.mark.parametrize("mass", [-1000, -530, 500, 1000])
@pytest.mark.parametrize("time", [-530, 530, 800])
def test_a_state_does_not_depend_on_the_units_of_mass_and_time(mass: int, time: int) -> None:
    """By powers of two, so to the last digit."""
    moments, periods = np.array([0.61, 0.965, 1.0]), np.array([27.38, 263.0])
    one, other = (
        free.spin_state(np.ldexp(moments, m), precession=turn[0], rotation=turn[1], mode="SAM")
        for m, turn in ((0, periods), (mass, np.ldexp(periods, time)))
    )
    assert np.array_equal(np.ldexp(one.omega, -time), other.omega)
    assert np.ldexp([one.precession, one.rotation], time).tolist() == [
        other.precession,
        other.rotation,
    ]
    assert one.energy == other.energy
    motion = exact.free_body(rigid.Body(np.ldexp(moments, mass)), other.omega)
    assert motion.period == other.rotation


@pytest.mark.parametrize(
    ("moments", "rotation", "mode"),
    [((0.61, 0.965, 1.0), 80.0, "SAM"), ((3.235, 1.0, 3.0836), 5.4, "LAM")],
)
def test_a_state_with_a_pole_has_the_phases_of_the_motion(
    moments: tuple[float, ...], rotation: float, mode: str
) -> None:
    """Closed form: after a period of the rates phi has grown by ``2 pi rotation / precession``."""
    rng = np.random.default_rng(5)
    poles = rng.normal(size=(6, 3))
    poles = np.concatenate([poles / np.linalg.norm(poles, axis=1)[:, np.newaxis], -np.eye(3)])
    phases = rng.uniform(-7.0, 7.0, (9, 2))
    given: Any = {"precession": 7.0, "rotation": rotation, "mode": mode, "pole": poles}
    found = free.spin_state(moments, phases=phases, **given)
    assert found.attitude is not None
    to_space = rigid.rotations.quaternion_to_matrix(found.attitude)
    momentum = np.matvec(to_space, np.array(moments) * found.omega)
    size = np.linalg.norm(momentum, axis=1)
    np.testing.assert_allclose(momentum, size[:, np.newaxis] * poles, atol=1e-14 * size[0])
    # Phi is the angle about the pole from its node e3 x L to the node of the long axis, L x axis.
    long = to_space[:, :, np.argmin(moments)]
    first = np.cross([0.0, 0.0, 1.0], poles)
    first[np.abs(poles[:, 2]) == 1.0] = [0.0, 1.0, 0.0]
    node = np.cross(poles, long)
    angle = np.arctan2((np.cross(first, node) * poles).sum(axis=1), (first * node).sum(axis=1))
    turns = (angle - phases[:, 0]) / (2.0 * np.pi)
    assert np.abs(turns - turns.round()).max() < 1e-14
    period = float(found.rotation[0])
    run = rigid.simulate(
        rigid.Body(moments), found.omega, found.attitude, t=[0.31 * period, period]
    )
    for k, share in enumerate((0.31, 1.0)):
        turned = [0.31, 2.0 * np.pi * share]
        later = free.spin_state(moments, phases=phases + turned, **given)
        np.testing.assert_allclose(later.omega, run.omega[:, k], atol=1e-13)
    after = phases + 2.0 * np.pi * np.array([rotation / 7.0, 1.0])
    same = free.spin_state(moments, phases=after, **given)
    assert same.attitude is not None
    assert run.attitude is not None
    apart = np.abs(np.vecdot(same.attitude, run.attitude[:, 1]))
    np.testing.assert_allclose(apart, 1.0, rtol=1e-14)


def test_motions_without_two_periods_have_no_mode() -> None:
    for moments, omega in (
        ((1.0, 2.0, 3.0), (0.0, 0.0, 1.0)),
        ((1.0, 2.0, 3.0), (0.0, 1.0, 0.0)),
        ((1.0, 1.0, 1.0), (0.1, 0.2, 0.3)),
        ((1.0, 2.0, 2.5), (0.0, 0.0, 0.0)),
    ):
        found = free.spin_periods(moments, omega)
        assert found.mode == ""
        assert np.isnan(found.precession)
        assert np.isnan(found.rotation)
    assert free.spin_periods((1.0, 2.0, 3.0), (0.0, 0.0, 2.0)).energy == 1.0


test_what_no_motion_has_is_refused = refuses(
    [
        ((1.0, 2.0, 3.0), (1.0, 2.0), "NPA", "mode = 'NPA': must be one of 'SAM', 'LAM'"),
        ((1.0, 2.0, 3.0), (0.0, 2.0), "SAM", "precession.*positive"),
        ((1.0, 2.0, 2.0), (1.0, 9.0), "SAM", "moments = 2.0: .*use mode='LAM'"),
        ((1.0, 1.0, 1.6), (1.0, 9.0), "LAM", "moments = 1.0: .*use mode='SAM'"),
        ((1.0, 2.0, 3.0), (1.0, 0.9), "SAM", "rotation / precession = 0.9: must be above 1,"),
        ((1.0, 2.0, 3.0), (1.0, 0.73), "LAM", "rotation / precession = 0.73: must be above 0.732"),
        ((1.0, 2.0, 3.0), (1.0, 1e5), "SAM", "rotation / precession = 100000.0: .*separatrix"),
    ],
    by=lambda moments, periods, mode: free.spin_state(
        moments, precession=periods[0], rotation=periods[1], mode=mode
    ),
)


test_phases_need_a_pole = refuses(
    [
        ({"phases": [0.0, 1.0]}, "phases: .*give pole"),
        ({"pole": [0.0, 0.0, 2.0]}, "pole = .*unit vector"),
        ({"pole": [0.0, 0.0, 1.0], "phases": 1.0}, r"phases: expected shape \(..., 2\)"),
    ],
    by=lambda given: free.spin_state(
        (0.61, 0.965, 1.0), precession=7.0, rotation=80.0, mode="SAM", **given
    ),
)


def test_the_body_that_has_no_such_motion_is_named() -> None:
    """In the short-axis mode a ratio is above that of small nutations, which is
    sqrt(I1 I2 / ((I3 - I1) (I3 - I2))): 1 of the moments 1, 2, 3, and 1.29 of 1, 2, 2.8."""
    moments = [[1.0, 2.0, 3.0], [1.0, 2.0, 2.8], [1.0, 2.0, 3.0], [1.0, 2.0, 2.8]]
    least = np.sqrt(2.0 / (1.8 * 0.8))
    words = rf"precession\[1\] = 1.1: must be above {least:.6g}, .*; 1 of the other bodies have"
    with pytest.raises(ValueError, match=words):
        free.spin_state(moments, precession=1.0, rotation=1.1, mode="SAM")


# Loss of energy over ages: the averaged motion against integrations and a closed form


YEAR = 365.25 * 86400.0


def energy_of(moments: Any, omega: Any) -> Any:
    momentum = np.array(moments) * omega
    return max(moments) * (momentum * omega).sum(axis=-1) / (momentum**2).sum(axis=-1)


@pytest.mark.parametrize(
    ("moments", "omega", "parts"),
    [
        ((1.0, 4.0, 4.2), (2.0, 0.01, 0.0), (1.0, 1.0, 1.0)),
        ((2.5, 1.0, 2.0), (0.05, 0.9, 0.1), (1.0, 0.2, 3.0)),
        ((1.0, 2.0, 2.5), (0.5, 0.3, 1.0), (0.0, 1.0, 0.0)),
    ],
)
def test_the_mean_is_the_motion_up_to_the_loss_in_a_period(
    moments: Any, omega: Any, parts: Any
) -> None:
    """The averaging theorem: the difference is of the first order in the sink.

    It is below the energy that is lost in a period, and falls with the sink: by 4 of theory, with
    the phase of the nutation at the output times by 2.5 at least.
    """
    differences = []
    for size in (0.04, 0.01):
        sink = rigid.EnergySink(size * np.array(parts))
        t = np.linspace(0.0, 60.0 / size, 401)
        mean = free.relaxation(moments, omega, t, sink)
        scene = rigid.FreeBody(rigid.Body(moments), dissipation=sink)
        run = rigid.simulate(scene, omega, t=t, record="rates", accuracy=1e-9)
        difference = np.abs(energy_of(moments, run.omega) - mean.states.energy)
        lost = np.abs(np.gradient(mean.states.energy, t)) * mean.states.rotation
        assert difference.max() < lost.max()
        assert mean.states.energy[0] - mean.states.energy[-1] > 0.9 * (mean.states.energy[0] - 1.0)
        differences.append(difference.max())
    assert differences[1] < differences[0] / 2.5


@pytest.mark.parametrize(
    ("moments", "omega"), [((1.0, 1.0, 1.6), (0.8, 0.1, 0.5)), ((0.5, 1.2, 1.2), (1.0, 0.02, 0.05))]
)
def test_a_symmetric_body_relaxes_by_its_closed_form(moments: Any, omega: Any) -> None:
    """``tan(theta)`` of L and the axis of symmetry falls as exp(-P (I3 - I1) L² t / (I3 I1³)).

    Of a prolate body it grows, and the end is a flat spin about no particular axis.
    """
    i, w = np.array(moments), np.array(omega)
    own = 2 if i[0] == i[1] else 0
    along, across = i[own], i[1]
    momentum = i * w
    square = momentum @ momentum
    t, sink = np.array([0.0, 3.0, 1e2, 2e3, 1e9]), 1e-3
    start = math.hypot(*np.delete(momentum, own)) / momentum[own]
    exponent = -sink * (along - across) * square * t / (along * across**3)
    tangent = start * np.exp(np.minimum(exponent, 300.0))
    cosine = 1.0 / (1.0 + tangent**2)
    expected = i.max() * (cosine / along + (1.0 - cosine) / across)
    found = free.relaxation(moments, omega, t, rigid.EnergySink(sink))
    # Rounding of the start and of the sum of some hundred panels.
    np.testing.assert_allclose(found.states.energy, expected, rtol=1e-13)
    assert found.separatrix == (0.0 if own == 2 else np.inf)


@pytest.mark.parametrize("tilt", [1e-4, 1e-3])
def test_a_sink_about_the_axis_of_the_spin_alone_damps_a_nutation_as_one_over_the_time(
    tilt: float,
) -> None:
    """Only ``I3 w3' = (I1 - I2) w1 w2`` loses energy, at twice the frequency of the nutation.

    With ``w1 = a cos``, ``w2 = b sin`` and the energy X above the least one, ``I1 (I3 - I1) a² =
    I2 (I3 - I2) b² = 2 X I3``, and the mean of ``w3'²`` is ``((I1 - I2) a b / I3)²/8``: so ``X' =
    -k X²``.
    """
    (i1, i2, i3), spin, sink = (1.0, 2.0, 2.5), 1.0, 3e-3
    k = 0.5 * sink * (i1 - i2) ** 2 / (i1 * i2 * (i3 - i1) * (i3 - i2))
    start = 0.5 * i1 * tilt**2 * (i3 - i1) / i3
    t = np.array([0.0, 0.5, 3.0]) / (k * start)
    found = free.relaxation((i1, i2, i3), [tilt, 0.0, spin], t, rigid.EnergySink((0, 0, sink)))
    above = found.states.energy - 1.0
    # Further terms are smaller by the square of the tilt; a rounding of 1 is 1e-16 of X.
    slack = 10.0 * tilt**2 + 1e-14 / above[-1]
    np.testing.assert_allclose(above / above[0], 1.0 / (1.0 + k * start * t), rtol=slack)


def test_l_is_constant_and_the_modes_follow_each_other() -> None:
    moments, omega = (4.2, 1.0, 4.0), (0.0, 2.0, 0.01)
    t = np.linspace(0.0, 5e3, 101)
    found = free.relaxation(moments, omega, t, rigid.EnergySink(0.01))
    momentum = np.linalg.norm(np.array(moments) * found.states.omega, axis=1)
    np.testing.assert_allclose(momentum, np.linalg.norm(np.array(moments) * omega), rtol=1e-14)
    assert 0.0 < found.separatrix < 5e3
    assert (np.array(found.states.mode) == np.where(t <= found.separatrix, "LAM", "SAM")).all()
    assert (np.diff(found.states.energy) < 0.0).all()
    before, after = free.relaxation(
        moments,
        omega,
        found.separatrix * np.array([1.0 - 1e-9, 1.0 + 1e-9]),
        rigid.EnergySink(0.01),
    ).states.energy
    assert before > 4.2 / 4.0 > after
    assert before - after < 1e-7


def test_a_sink_of_a_damping_time_damps_a_nutation_in_that_time() -> None:
    """A nutation of 1e-3: its energy, to 1e-6, and the mean, to the loss in a period, 6e-3."""
    moments, rate, time = (1.0, 2.0, 2.5), 1.0, 2000.0
    sink = free.sink_of_damping(moments, rate, time)
    scene = rigid.FreeBody(rigid.Body(moments), dissipation=sink)
    run = rigid.simulate(scene, [1e-3, 0.0, rate], t=[0.0, time], record="rates", accuracy=1e-9)
    start, end = energy_of(moments, run.omega) - 1.0
    assert math.sqrt(end / start) == pytest.approx(math.exp(-1.0), rel=6e-3)


def test_toutatis_is_damped_later_than_its_age() -> None:
    """Harris 1994: asteroids as slow as Toutatis need more than the age of the solar system."""
    state = free.spin_state((1.0, 3.09, 3.22), precession=7.35, rotation=5.41, mode="LAM")
    omega = state.omega / 86400.0
    rate = float(np.linalg.norm(np.array([1.0, 3.09, 3.22]) * omega)) / 3.22
    time = free.damping_time(1220.0, rate, density=2000.0, rigidity=5e9, quality=100.0)
    assert time > 4.5e9 * YEAR
    sink = free.sink_of_damping((1.0, 3.09, 3.22), rate, time)
    found = free.relaxation((1.0, 3.09, 3.22), omega, np.array([0.0, 1e6, 1e9]) * YEAR, sink)
    assert found.states.mode.tolist() == ["LAM"] * 3  # type: ignore[union-attr]


test_what_does_not_relax_is_refused = refuses(
    [
        ([0.0, 0.0, 1.0], [1.0], 0.1, r"omega = \[0.0, 0.0, 1.0\].*does not nutate"),
        ([0.0, 1.0, 0.0], [1.0], 0.1, "does not nutate"),
        ([0.1, 0.0, 1.0], [-1.0], 0.1, r"t\[0\] = -1.0: must not be negative"),
        ([0.1, 0.0, 1.0], [1.0], 0.0, "drains nothing; give each axis a coefficient"),
        ([0.1, 0.0, 1.0], [1.0], [[0.1] * 3] * 2, "the sink of one body; loop over bodies"),
        ([[0.1, 0.0, 1.0]], [1.0], 0.1, r"shape \(3,\), \(1, 3\): one body at a time"),
    ],
    by=lambda omega, t, sink: free.relaxation((1.0, 2.0, 2.5), omega, t, rigid.EnergySink(sink)),
)


def test_arguments_of_damping_are_checked() -> None:
    with pytest.raises(TypeError, match=r"sink = 0.1: must be a rigid.EnergySink"):
        free.relaxation((1.0, 2.0, 2.5), [0.1, 0.0, 1.0], [1.0], 0.1)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="two largest are equal"):
        free.sink_of_damping((1.0, 2.0, 2.0), 1.0, 1.0)
    with pytest.raises(ValueError, match=r"body of shape \(1, 3\): one body at a time"):
        free.sink_of_damping([(1.0, 2.0, 2.5)], 1.0, 1.0)
    with pytest.raises(ValueError, match=r"quality = 0.0: must be positive"):
        free.damping_time(1.0, 1.0, density=1.0, rigidity=1.0, quality=0.0)


def test_numbers_beyond_the_range_of_doubles_are_refused() -> None:
    words = "leaves the range of doubles; count in other units"
    with pytest.raises(ValueError, match=f"radius = 1e-200, rate = 1: the time, inf s, {words}"):
        free.damping_time(1e-200, 1.0, density=1.0, rigidity=1.0, quality=1.0)
    with pytest.raises(ValueError, match=f"rate = 1e-170, time = 1: the coefficient, inf, {words}"):
        free.sink_of_damping((1.0, 2.0, 2.5), 1e-170, 1.0)
    with pytest.raises(ValueError, match=f"radius = 1e-60: the coefficient, 0, {words}"):
        rigid.EnergySink.viscous_sphere(1e-60, density=1.0, viscosity=1.0)
    # The sink is in proportion to the moments, however small.
    one, small = (
        free.sink_of_damping(np.array((1.0, 2.0, 2.5)) * u, 1.0, 1e3) for u in (1, 2e-150)
    )
    np.testing.assert_allclose(small.coefficient, np.array(one.coefficient) * 2e-150, rtol=1e-14)
    energies = [
        float(
            free.spin_periods(np.array((1.0, 4.0, 4.2)) * u, np.array([2.0, 0.5, 0.1]) * v).energy
        )
        for u, v in ((1.0, 1.0), (1e-200, 1.0), (1.0, 1e-170))
    ]
    np.testing.assert_allclose(energies, energies[0], rtol=1e-14)
