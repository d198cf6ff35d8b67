"""The free precession of the Earth: printed numbers, the two days, and the printed errors."""

from collections.abc import Callable

import numpy as np
import pytest
from scipy.integrate import tplquad

import rigid
from physics import ROUNDOFF
from refusals import refuses
from rigid import earth, free

#: Radii of the lab report (m).
POLAR, EQUATOR = 6356752.3, 6378137.0
#: Ellipticity, rate (rad/s) and tilt (rad) of the thesis.
FLAT, RATE, TILT = 0.00329, 7.29e-5, np.deg2rad(0.2 / 3600.0)


def test_euler_s_period() -> None:
    days = earth.euler_period(FLAT, RATE) / earth.SOLAR_DAY
    # D-25: printed 305 d. With one turn a day it is 1 / 0.00329.
    assert days == pytest.approx(303.209427, abs=5e-7)
    assert abs(days - 305.0) > 1.5
    turns = earth.euler_period(FLAT, earth.rotation_rate(earth.SOLAR_DAY)) / earth.SOLAR_DAY
    assert turns == pytest.approx(303.951368, abs=5e-7)
    assert earth.euler_period(1.0 / 305.0, earth.rotation_rate(1.0)) == pytest.approx(305.0)
    assert earth.euler_period(0.0, RATE) == np.inf
    # It is the period of the free symmetric top, for slight tilts.
    top = free.symmetric_free_top((1.0, 1.0, 1.0 + FLAT), [0.0, 0.0, RATE])
    assert top.period == pytest.approx(earth.euler_period(FLAT, RATE), rel=1e-12)


def test_the_wobble_of_the_thesis() -> None:
    found = earth.wobble(FLAT, RATE, TILT)
    assert pytest.approx(9.69627362e-7, abs=5e-16) == TILT
    # D-26: printed 0.00329; it is 1.00329 times the rate.
    assert found.precession / RATE == pytest.approx(1.00329, abs=1e-12)
    assert found.precession == pytest.approx(7.3139841e-5, rel=1e-8)
    assert abs(found.precession / RATE - FLAT) > 0.9
    assert found.space_period * RATE / (2 * np.pi) == pytest.approx(0.996720789, abs=5e-10)
    # D-43: printed 0.997 d, which counts turns of the Earth; in solar days it is 0.9943.
    assert found.space_period / earth.SOLAR_DAY == pytest.approx(0.994287808, abs=5e-10)
    # D-27: printed, a circle of some tens of centimetres.
    assert found.pole_circle == pytest.approx(6.177496, abs=5e-7)
    assert 2 * found.pole_circle == pytest.approx(12.4, abs=0.05)
    # The two cones: 0.2 and 0.0007 arc seconds, with all digits.
    assert found.separation == pytest.approx(3.1796e-9, rel=2e-5)
    assert found.space_circle == pytest.approx(0.02026, abs=5e-6)
    # tan(theta) = tan(alpha) / 1.00329, so alpha - theta = 0.00329 alpha / 1.00329 to alpha².
    assert found.separation == pytest.approx(FLAT / (1 + FLAT) * TILT, rel=1e-11)
    assert found.theta == pytest.approx(np.arctan(np.tan(TILT) / (1 + FLAT)), rel=1e-15)
    assert found.period * np.cos(TILT) == pytest.approx(earth.euler_period(FLAT, RATE), rel=1e-12)
    # A body that is nearly a sphere keeps the digits of its ellipticity.
    nearly = earth.wobble(1e-13, RATE, 0.5)
    expected = earth.euler_period(1e-13, RATE * np.cos(0.5))
    assert nearly.period == pytest.approx(expected, rel=4 * ROUNDOFF)
    assert nearly.separation == pytest.approx(1e-13 * np.sin(0.5) * np.cos(0.5), rel=1e-12)


def test_the_earth_of_the_report() -> None:
    flat = float(earth.ellipticity(POLAR, EQUATOR))
    across, _, along = earth.ellipsoid_moments(POLAR, EQUATOR, mass=5.97e24)
    assert along / across - 1.0 == pytest.approx(flat, rel=1e-12)
    # Of a homogeneous ellipsoid; the report has -0.00334719222.
    of_moments = (EQUATOR**2 - POLAR**2) / (EQUATOR**2 + POLAR**2)
    assert flat == pytest.approx(of_moments, rel=1e-12)
    assert (along - across) / along == pytest.approx(of_moments / (1.0 + of_moments), rel=1e-12)
    # In turns a day, omega = Omega + nu = 1.
    found = earth.wobble(flat, 2 * np.pi, 0.0)
    turns = float(found.precession) / (2 * np.pi)
    assert turns == pytest.approx(1.0 + of_moments, rel=1e-12)
    nu = float(free.steady_axis_spin((across, across, along), [0.0, 0.0, turns]))
    assert turns / nu == pytest.approx(-1.0 / of_moments - 1.0, rel=1e-11)
    assert 1.0 / nu == pytest.approx(-1.0 / of_moments, rel=1e-11)
    assert turns + nu == pytest.approx(1.0, rel=1e-14)
    assert found.period == pytest.approx(297.757864493, rel=1e-11)
    assert turns * earth.rotation_rate(earth.SOLAR_DAY) == pytest.approx(7.29662843e-5, rel=2e-9)
    # S-06: printed with a minus sign before 598 pi / (298 * 86400).
    assert 598 * np.pi / (298 * 86400) == pytest.approx(7.29660859e-5, rel=2e-9)
    # S-08: one turn takes a sidereal day.
    sidereal = turns * earth.rotation_rate()
    assert sidereal == pytest.approx(7.31661e-5, rel=1e-6)
    assert sidereal * earth.SOLAR_DAY / (2 * np.pi) == pytest.approx(1.006106, abs=5e-7)
    # S-05: Omega across the axis, b/R = 10 m over the polar radius.
    frame = free.steady_axis_frame((across, across, along), nu, tilt=10.0 / POLAR)
    assert frame[0] / frame[2] == pytest.approx(1.573130355e-6, rel=1e-9)
    # S-07: read as the angle of axis and L, that of axis and omega is nearly the same; read as that
    # of L and omega it is 298.8 times as much.
    top = free.symmetric_free_top((across, across, along), frame + np.array([0.0, 0.0, nu]))
    assert top.alpha == pytest.approx(1.5784e-6, rel=1e-5)
    assert top.theta == pytest.approx(10.0 / POLAR, rel=1e-12)
    assert 10.0 / POLAR / -((across - along) / along) == pytest.approx(4.70e-4, rel=1e-3)


def test_moments_of_an_ellipsoid() -> None:
    volume = 4.0 / 3.0 * np.pi * 2.0 * 2.0 * 1.5

    def mean(part: Callable[[float, float, float], float]) -> float:
        """Over the ellipsoid with semi axes 2, 2, 1.5, by quadrature in its own sphere."""

        def density(r: float, theta: float, phi: float) -> float:
            x = 2.0 * r * np.sin(theta) * np.cos(phi)
            y = 2.0 * r * np.sin(theta) * np.sin(phi)
            inside = part(x, y, 1.5 * r * np.cos(theta))
            return float(inside * r * r * np.sin(theta) * 6.0 / volume)

        return float(tplquad(density, 0, 2 * np.pi, 0, np.pi, 0, 1, epsabs=1e-8)[0])

    found = earth.ellipsoid_moments(1.5, 2.0)
    assert found[0] == found[1] == pytest.approx(mean(lambda x, y, z: y * y + z * z), rel=1e-8)
    assert found[2] == pytest.approx(mean(lambda x, y, z: x * x + y * y), rel=1e-8)
    assert rigid.Body(found).symmetry_axis == 3
    assert earth.ellipticity(1.0, 1.0) == 0.0
    assert earth.wobble([0.1, 0.2], 1.0, [[0.0], [0.1], [0.2]]).period.shape == (3, 2)
    assert earth.wobble(np.empty(0), 1.0, 0.1).period.shape == (0,)


test_what_has_no_answer_is_refused = refuses(
    [
        (lambda: earth.rotation_rate(0.0), "day = 0.0: must be positive"),
        (lambda: earth.euler_period(-1.0, 1.0), "ellipticity = -1.0: must be above -1"),
        (lambda: earth.euler_period(0.1, np.nan), "rate = nan: must be finite"),
        (lambda: earth.ellipticity(1.0, -1.0), "equatorial_radius = -1.0: must be positive"),
        (lambda: earth.ellipsoid_moments(0.0, 1.0), "polar_radius = 0.0: must be positive"),
        (lambda: earth.ellipsoid_moments(1.0, 1.0, mass=0.0), "mass = 0.0: must be positive"),
        (lambda: earth.wobble(1.5, 1.0, 0.1), "ellipticity = 1.5: must be at most 1"),
        (lambda: earth.wobble(0.1, 1.0, 2.0), "tilt = 2.0: must lie in [0, pi/2] (rad)"),
        (lambda: earth.wobble(0.1, 1.0, 0.1, radius=0.0), "radius = 0.0: must be positive"),
    ],
    literal=True,
)
