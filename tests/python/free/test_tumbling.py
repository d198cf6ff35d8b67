"""Tumbling bodies by two periods: of an integration, of asteroids, and back to the state."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import rigid
from rigid import free

Pair = tuple[float, float]


def integrated_periods(moments: Any, omega: Any) -> Pair:
    """Both periods from an integration of Euler's equations with the matrix of the attitude.

    A rate that changes sign rises through zero once in each period of the rates. Between two such
    times, the azimuth of the long axis about L advances by the same angle in each period.
    """
    i = np.array(moments)
    long = int(i.argmin())
    middle = int(np.argsort(i)[1])

    def slope(_: float, state: Any) -> Any:
        w, body_to_space = state[:3], state[3:].reshape(3, 3)
        turning = np.array([[0.0, -w[2], w[1]], [w[2], 0.0, -w[0]], [-w[1], w[0], 0.0]])
        return np.concatenate([np.cross(i * w, w) / i, (body_to_space @ turning).ravel()])

    def rises(_: float, state: Any) -> float:
        return float(state[middle])

    rises.direction = 1.0  # type: ignore[attr-defined]
    start = np.concatenate([np.array(omega, dtype=float), np.eye(3).ravel()])
    rough = float(rigid.exact.free_body(rigid.Body(moments), omega).period)
    found = solve_ivp(
        slope,
        (0.0, 3.5 * rough),
        start,
        method="DOP853",
        rtol=1e-12,
        atol=1e-12,
        events=rises,
        dense_output=True,
    )
    times = found.t_events[0]
    first, last, count = times[0], times[-1], len(times) - 1
    pole = i * np.array(omega)
    pole = pole / np.linalg.norm(pole)
    across = np.cross(pole, [0.36, 0.48, 0.8])
    across /= np.linalg.norm(across)
    axes = found.sol(np.linspace(first, last, 8001))[3:].reshape(3, 3, -1)[:, long]
    azimuth = np.unwrap(np.arctan2(np.cross(pole, across) @ axes, across @ axes))
    return 2.0 * np.pi * (last - first) / (azimuth[-1] - azimuth[0]), (last - first) / count


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
def test_periods_are_those_of_an_integration(moments: Any, omega: Any, mode: str) -> None:
    """The tolerance of the integration is 1e-12; over three periods errors grow to some 1e-10."""
    found = free.spin_periods(moments, omega)
    assert found.mode == mode
    measured = integrated_periods(moments, omega)
    assert [float(found.precession), float(found.rotation)] == pytest.approx(measured, rel=1e-8)


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


def test_apophis_and_toutatis() -> None:
    """Pravec et al. 2014: E/E0 = 1.024 ± 0.013. Toutatis is in the long-axis mode; the angular
    velocity of Hudson and Ostro has a size of 104.9 degrees a day, and changes little."""
    apophis = free.spin_state((0.61, 0.965, 1.0), precession=27.38, rotation=263.0, mode="SAM")
    assert abs(apophis.energy - 1.024) < 0.013
    toutatis = free.spin_state((1.0, 3.09, 3.22), precession=7.35, rotation=5.41, mode="LAM")
    size = np.degrees(np.linalg.norm(toutatis.omega))
    assert abs(size - np.linalg.norm([20.7, 31.3, 98.0])) < 1.0


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


@pytest.mark.parametrize(
    ("moments", "periods", "mode", "message"),
    [
        ((1.0, 2.0, 3.0), (1.0, 2.0), "NPA", "mode = 'NPA': must be one of 'SAM', 'LAM'"),
        ((1.0, 2.0, 3.0), (0.0, 2.0), "SAM", "precession.*positive"),
        ((1.0, 2.0, 2.0), (1.0, 9.0), "SAM", "moments = 2.0: .*use mode='LAM'"),
        ((1.0, 1.0, 1.6), (1.0, 9.0), "LAM", "moments = 1.0: .*use mode='SAM'"),
        ((1.0, 2.0, 3.0), (1.0, 0.9), "SAM", "rotation / precession = 0.9: must be above 1,"),
        ((1.0, 2.0, 3.0), (1.0, 0.73), "LAM", "rotation / precession = 0.73: must be above 0.732"),
        ((1.0, 2.0, 3.0), (1.0, 1e5), "SAM", "rotation / precession = 100000.0: .*separatrix"),
    ],
)
def test_what_no_motion_has_is_refused(
    moments: Any, periods: Pair, mode: str, message: str
) -> None:
    with pytest.raises(ValueError, match=message):
        free.spin_state(moments, precession=periods[0], rotation=periods[1], mode=mode)
