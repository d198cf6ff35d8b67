"""The numbers under the figures of motions, and that the figures show them."""

from __future__ import annotations

import runpy
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure
from numpy.typing import NDArray

import rigid
from rigid import exact, figures, free, top
from rigid.figures import colours
from small_maps import python_process

Floats = NDArray[np.float64]

GALLERY = Path(__file__).parents[2] / "docs" / "gallery"

TOP = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)
TILTED = [np.cos(np.pi / 6), np.sin(np.pi / 6), 0.0, 0.0]
SIN60 = np.sin(np.pi / 3)
ASYMMETRIC = rigid.HeavyTop(rigid.Body((1.0, 1.5, 0.6)), mgl=1.0)
DAMPED = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0, damping=(0.0, 0.0, 0.1))
BODY = rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0)))

# Starts at 60 degrees: rate of precession, spin, and the roots of f to the digits of the tables.
STARTS = {
    "cusp": (0.0, 5.0, 0.191767987534, 0.5, 2.93323201247),
    "prolate": (-0.3, 5.0, -0.00533329827606, 0.5, 3.16408329828),
    "curtate": (0.2, 5.0, 0.331089188037, 0.5, 2.80891081196),
    "curtate from below": (0.6, 5.0, 0.5, 0.611717131638, 2.64828286836),
    "prolate from below": (1.5, 5.0, 0.5, 0.992095230668, 2.97665476933),
    "retrograde": (-4.0, 1.0, -0.786708522541, 0.5, 6.91170852254),
}


def omega_of(name: str) -> list[float]:
    push, spin = STARTS[name][:2]
    return [0.0, push * SIN60, spin]


def data_of(line: Any) -> Floats:
    """What a line in a plane or in space carries, shape (m, 2) or (m, 3)."""
    got = line.get_data_3d() if hasattr(line, "get_data_3d") else line.get_data()
    return np.stack([np.asarray(part, dtype=float) for part in got], axis=1)


def joined(seen: Any, hidden: Any) -> Floats:
    """A curve from its two sides."""
    one, other = data_of(seen), data_of(hidden)
    assert (np.isnan(one) != np.isnan(other)).all()
    return np.where(np.isnan(one), other, one)


def texts(ax: Any) -> list[str]:
    return [text.get_text() for text in ax.texts]


def wrong(value: Any) -> Any:
    """What no type checker would let through."""
    return value


# The effective potential


@pytest.mark.parametrize("name", STARTS)
def test_the_well_is_as_high_as_the_energy_at_the_circles(name: str) -> None:
    data = figures.effective_potential_data(TOP, omega_of(name), TILTED)
    _, _, u1, u2, _ = STARTS[name]
    assert np.cos(data.theta_lower) == pytest.approx(u1, abs=2e-11)
    assert np.cos(data.theta_upper) == pytest.approx(u2, abs=2e-11)
    circles = np.interp([data.theta_upper, data.theta_lower], data.tilt, data.potential)
    np.testing.assert_allclose(circles, data.E_prime, rtol=2e-2)  # of the polygon
    # E', not E, is the level (erratum D-40): the energy of the spin is no part of it.
    constants = top.heavy_constants(TOP, omega_of(name), TILTED)
    assert data.E_prime == pytest.approx(float(constants.energy) - 0.25 * STARTS[name][1] ** 2)
    assert data.lowest <= data.potential.min()
    assert data.theta_upper < data.theta_steady < data.theta_lower


def test_the_path_moves_in_the_well() -> None:
    # E' - V'(theta) = ½ I1 theta'² along the motion; theta' from the rates across the axis.
    omega = omega_of("prolate")
    data = figures.effective_potential_data(TOP, omega, TILTED, samples=20001)
    run = rigid.simulate(TOP, omega, TILTED, t=np.linspace(0.0, 6.0, 400), record="axis")
    assert run.gamma is not None
    u_rate = np.cross(run.gamma, run.omega)[:, 2]
    sine = np.hypot(run.gamma[:, 0], run.gamma[:, 1])
    tilt = np.arctan2(sine, run.gamma[:, 2])
    well = np.interp(tilt, data.tilt, data.potential)
    np.testing.assert_allclose(data.E_prime - well, 0.5 * (u_rate / sine) ** 2, atol=1e-6)


def test_the_picture_of_the_well_carries_its_numbers() -> None:
    drawn = figures.effective_potential(TOP, omega_of("cusp"), TILTED)
    data = drawn.data
    np.testing.assert_array_equal(data_of(drawn.curve)[:, 0], np.degrees(data.tilt))
    np.testing.assert_array_equal(data_of(drawn.curve)[:, 1], data.potential)
    ends = np.degrees([data.theta_upper, data.theta_lower])
    np.testing.assert_allclose(ends, [60.0, np.degrees(np.arccos(0.191767987534))], rtol=1e-10)
    for line in (drawn.level, drawn.turning):
        np.testing.assert_array_equal(data_of(line), np.stack([ends, [data.E_prime] * 2], axis=1))
    assert drawn.ax.get_xlabel() == r"tilt $\theta$ (°)"
    assert drawn.ax.get_ylabel() == "energy (J)"
    assert {"$E'$", r"$V'(\theta)$", r"$\theta_\mathrm{m}$"} < set(texts(drawn.ax))
    low, high = drawn.ax.get_ylim()
    assert low < data.lowest < data.E_prime < high


def test_a_steady_top_lies_at_the_bottom_of_the_well() -> None:
    slow = float(top.steady_precession(TOP, np.pi / 3, 5.0).slow)
    drawn = figures.effective_potential(TOP, [0.0, slow * SIN60, 5.0], TILTED)
    assert drawn.data.E_prime == pytest.approx(drawn.data.lowest, rel=1e-14)
    assert drawn.data.theta_steady == pytest.approx(np.pi / 3, rel=1e-9)
    assert r"$\theta_\mathrm{upper}$" not in texts(drawn.ax)


# The cubic


@pytest.mark.parametrize("name", STARTS)
def test_roots_of_the_cubic(name: str) -> None:
    data = figures.cubic_data(TOP, omega_of(name), TILTED)
    np.testing.assert_allclose(data.roots, STARTS[name][2:], rtol=1e-11, atol=1e-12)
    assert (data.f_allowed >= -1e-13).all()
    outside = (data.near < data.roots[0]) | (data.near > data.roots[1])
    assert (data.f_near[outside] < 0.0).all()
    known = top.heavy_constants(TOP, omega_of(name), TILTED)
    assert known.a is not None
    assert known.b is not None
    assert data.still == pytest.approx(float(known.a / known.b))
    # f is lowest where it has to be: f(±1) = -(a ∓ b)².
    ends = np.interp([1.0, -1.0], data.u, data.f)
    expected = [-((known.a - known.b) ** 2), -((known.a + known.b) ** 2)]
    np.testing.assert_allclose(ends, expected, atol=2e-3 * np.abs(data.f).max())


def test_the_height_of_a_path_obeys_the_cubic() -> None:
    omega = omega_of("prolate")
    data = figures.cubic_data(TOP, omega, TILTED, samples=4001)
    run = rigid.simulate(TOP, omega, TILTED, t=np.linspace(0.0, 6.0, 300), record="axis")
    assert run.gamma is not None
    u_rate = np.cross(run.gamma, run.omega)[:, 2]
    seen = np.interp(run.gamma[:, 2], data.allowed, data.f_allowed)
    np.testing.assert_allclose(seen, u_rate**2, atol=1e-6)
    # The precession reverses at a/b: the loop's phi' has its sign.
    phi = np.gradient(np.unwrap(top.locus(TOP, omega, TILTED, t=run.t).phi), run.t)
    apart = np.abs(run.gamma[:, 2] - data.still) > 0.01
    np.testing.assert_array_equal((phi > 0.0)[apart], (run.gamma[:, 2] < data.still)[apart])


def test_the_picture_of_the_cubic_carries_its_numbers() -> None:
    drawn = figures.cubic(TOP, omega_of("prolate"), TILTED)
    data = drawn.data
    np.testing.assert_array_equal(data_of(drawn.curve), np.stack([data.u, data.f], axis=1))
    allowed = np.stack([data.allowed, data.f_allowed], axis=1)
    np.testing.assert_array_equal(data_of(drawn.allowed), allowed)
    np.testing.assert_array_equal(data_of(drawn.roots)[:, 0], data.roots)
    assert drawn.close is not drawn.ax
    assert drawn.still is not None
    assert drawn.still.get_xdata()[0] == data.still
    assert drawn.ax.get_xlabel() == r"height $u = \cos\theta$"
    assert drawn.ax.get_ylabel() == r"$f(u) = \dot u^2$ (1/s²)"
    assert "$u_3$" in texts(drawn.ax)
    assert {"$u_1$", "$u_2$", "$a/b$"} <= set(texts(drawn.close))
    # The wide interval of the fourth kind needs no closer look, and its u3 is out of sight.
    wide = figures.cubic(TOP, omega_of("retrograde"), TILTED)
    assert wide.close is wide.ax
    assert len(data_of(wide.roots)) == 2
    assert {"$u_1$", "$u_2$"} <= set(texts(wide.ax))
    # A steady top has a double root (erratum G-21).
    slow = float(top.steady_precession(TOP, np.pi / 3, 5.0).slow)
    steady = figures.cubic(TOP, [0.0, slow * SIN60, 5.0], TILTED)
    assert "$u_1 = u_2$" in texts(steady.close)


def test_a_top_without_weight_has_no_third_root() -> None:
    light = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=0.0)
    drawn = figures.cubic(light, [0.3, 0.2, 1.0], TILTED)
    assert drawn.data.roots[2] == np.inf
    assert len(data_of(drawn.roots)) == 2


# The upright top


def test_an_upright_top_sleeps_where_f_is_negative() -> None:
    drawn = figures.upright_cubic(TOP)
    data = drawn.data
    assert data.spin_min == 4.0
    np.testing.assert_allclose(data.spin, [3.6, 4.0, 4.4], rtol=1e-15)
    beside = data.u < 1.0
    near = beside & (data.u > 0.9)
    below, at, above = data.exact
    assert (below[near] > 0.0).all()
    assert (at[beside] < 0.0).all()
    assert (above[beside] < 0.0).all()
    np.testing.assert_array_equal(data.stable, [False, True, True])
    # At the bound the printed approximation vanishes and says nothing (erratum G-19), f decides.
    np.testing.assert_array_equal(data.approximate[1], 0.0)
    np.testing.assert_allclose(at, -2.0 * (1.0 - data.u) ** 3, atol=1e-15)
    np.testing.assert_array_equal(np.sign(data.approximate[[0, 2]][:, beside]).T[0], [1.0, -1.0])
    for k in range(3):
        np.testing.assert_array_equal(data_of(drawn.exact[k])[:, 1], data.exact[k])
        np.testing.assert_array_equal(data_of(drawn.approximate[k])[:, 1], data.approximate[k])
    titles = [ax.get_title() for ax in drawn.axes]
    assert [title.split(": ")[1] for title in titles] == ["falls", "sleeps", "sleeps"]
    assert drawn.axes[0].get_ylabel() == "$f(u)$ (1/s²)"


# The locus


@pytest.mark.parametrize("name", STARTS)
def test_the_axis_stays_between_its_circles_and_touches_them(name: str) -> None:
    data = figures.locus_data(TOP, omega_of(name), TILTED)
    assert data.kind == name.split()[0]
    assert data.theta_upper is not None
    assert data.theta_lower is not None
    assert np.cos(data.theta_lower) == pytest.approx(STARTS[name][2], abs=2e-11)
    assert data.theta.min() > data.theta_upper - 1e-12
    assert data.theta.max() < data.theta_lower + 1e-12
    np.testing.assert_allclose(data.theta.min(), data.theta_upper, atol=1e-3)
    np.testing.assert_allclose(data.theta.max(), data.theta_lower, atol=1e-3)
    np.testing.assert_allclose(np.linalg.norm(data.point, axis=1), 1.0, rtol=1e-14)
    assert abs(np.ptp(data.phi)) > 0.95 * 2.0 * np.pi
    rate = np.diff(data.phi)
    # Erratum G-18: of the fourth kind the axis goes against the spin all the time.
    expected = {"curtate": (True, False), "retrograde": (False, True), "prolate": (True, True)}
    if data.kind in expected:
        assert (bool((rate > 0.0).any()), bool((rate < 0.0).any())) == expected[data.kind]


def test_the_picture_of_the_locus_carries_its_path() -> None:
    drawn = figures.locus(TOP, omega_of("cusp"), TILTED)
    data = drawn.data
    np.testing.assert_array_equal(joined(drawn.seen, drawn.hidden), data.point)
    np.testing.assert_array_equal(data_of(drawn.start), data.point[:1])
    assert [ring.get_label() for ring in drawn.circles] == ["upper", "lower"]
    for ring, theta in zip(drawn.circles, (data.theta_upper, data.theta_lower), strict=True):
        assert theta is not None
        heights = data_of(ring)[:, 2]
        np.testing.assert_allclose(heights[np.isfinite(heights)], np.cos(theta), rtol=1e-14)
    # What is seen is in front.
    elev, azim = np.radians([drawn.ax.elev, drawn.ax.azim])
    eye = np.array([np.cos(elev) * np.cos(azim), np.cos(elev) * np.sin(azim), np.sin(elev)])
    assert np.nanmin(data_of(drawn.seen) @ eye) >= -1e-12
    assert np.nanmax(data_of(drawn.hidden) @ eye) <= 1e-12


def test_panels_of_loci_are_named() -> None:
    names = ["prolate", "cusp", "curtate", "retrograde"]
    drawn = figures.loci(TOP, [omega_of(name) for name in names], TILTED)
    assert [one.data.kind for one in drawn] == names
    titles = [one.ax.get_title() for one in drawn]
    assert titles == ["loops", "cusps", "monotone", "against the spin"]


def test_tops_without_circles_are_drawn_for_given_times() -> None:
    t = np.linspace(0.0, 5.0, 51)
    for scene in (ASYMMETRIC, DAMPED):
        drawn = figures.locus(scene, [0.2, 0.1, 5.0], TILTED, t=t)
        assert drawn.data.kind == "general"
        assert drawn.circles == ()
        path = top.locus(scene, [0.2, 0.1, 5.0], TILTED, t=t)
        np.testing.assert_array_equal(drawn.data.point, path.point)


# Cycloids


def test_fast_tops_come_near_cycloids() -> None:
    coarse, fine = (figures.cycloids_data(TOP, 1.0, spin, periods=2.0) for spin in (20.0, 40.0))
    assert coarse.kind.tolist() == ["curtate", "cusp", "prolate"]
    np.testing.assert_allclose(coarse.precession, [0.05, 0.0, -0.1], rtol=1e-14)
    errors = []
    for data in (coarse, fine):
        np.testing.assert_allclose(data.theta[:, 0], 1.0, rtol=1e-14)
        rate = np.diff(data.phi[:, :2], axis=1)[:, 0] / data.t[1]
        np.testing.assert_allclose(rate, data.precession, atol=1e-4)
        width = np.ptp(data.theta_approx, axis=1)
        errors.append(np.abs(data.theta - data.theta_approx).max(axis=1) / width)
        # phi' never reverses, stands still, reverses.
        slowest = np.diff(data.phi, axis=1).min(axis=1) / np.diff(data.phi, axis=1).max(axis=1)
        assert slowest[0] > 0.2
        assert abs(slowest[1]) < 0.01
        assert slowest[2] < -0.2
    # The error is of second order in 1 / spin, for a given number of nutations (D-38).
    np.testing.assert_allclose(errors[0] / errors[1], 4.0, rtol=0.1)


def test_any_axis_may_be_that_of_a_cycloid() -> None:
    plain = figures.cycloids_data(TOP, 1.0, 20.0)
    turned = rigid.HeavyTop(rigid.Body((0.5, 1.0, 1.0)), mgl=1.0, com=(1.0, 0.0, 0.0))
    against = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0, com=(0.0, 0.0, -1.0))
    for scene, spin in ((turned, 20.0), (against, -20.0)):
        data = figures.cycloids_data(scene, 1.0, spin)
        np.testing.assert_allclose(data.theta, plain.theta, rtol=1e-12)
        np.testing.assert_allclose(data.phi, plain.phi, atol=1e-12)
        np.testing.assert_allclose(data.theta_approx, plain.theta_approx, rtol=1e-14)


def test_the_picture_of_cycloids_carries_both_curves() -> None:
    drawn = figures.cycloids(TOP, 1.0, 20.0)
    data = drawn.data
    for k in range(3):
        for line, phi, theta in (
            (drawn.exact[k], data.phi[k], data.theta[k]),
            (drawn.approximate[k], data.phi_approx[k], data.theta_approx[k]),
        ):
            expected = np.degrees(np.stack([np.sin(1.0) * phi, theta], axis=1))
            np.testing.assert_array_equal(data_of(line), expected)
        assert drawn.axes[k].get_ylim()[0] > drawn.axes[k].get_ylim()[1]  # upward is up
        assert drawn.axes[k].get_ylabel() == r"tilt $\theta$ (°)"
    assert drawn.axes[2].get_xlabel() == r"azimuth $\phi\,\sin\theta_0$ (°)"
    assert figures.cycloids(TOP, 1.0, 20.0, pushes=[]).axes == ()


# Poinsot


def poinsot_run(m: int = 1201) -> Any:
    body = rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0)))
    return rigid.simulate(body, [1.1, 0.3, 0.4], [0.5, 0.5, 0.1, 0.7], t=np.linspace(0, 15, m))


@pytest.mark.parametrize("frame", [0, 333, -1])
def test_the_ellipsoid_touches_the_plane_in_the_contact(frame: int) -> None:
    run = poinsot_run()
    data = figures.poinsot_data(run, frame=frame)
    assert data.t == run.t[frame]
    assert data.contact[2] == pytest.approx(data.distance, rel=1e-14)
    np.testing.assert_allclose(data.herpolhode[:, 2], data.distance, rtol=1e-13)
    # The highest point of the ellipsoid is in the plane and is the contact: it is tangent there.
    reach = data.semi_axes * data.axes[:, 2]
    assert np.linalg.norm(reach) == pytest.approx(data.distance, rel=1e-13)
    highest = (data.semi_axes * reach / np.linalg.norm(reach)) @ data.axes
    np.testing.assert_allclose(highest, data.contact, atol=1e-13)
    np.testing.assert_allclose(data.axes @ data.axes.T, np.eye(3), atol=1e-14)
    assert np.linalg.det(data.axes) == pytest.approx(1.0)
    # The polhode lies on the inertia ellipsoid and on that of L².
    own = data.polhode @ data.axes.T
    moments = np.array([1.0, 2.0, 3.0])
    np.testing.assert_allclose(own, run.omega, atol=1e-13)
    np.testing.assert_allclose(((own / data.semi_axes) ** 2).sum(axis=1), 1.0, rtol=1e-13)
    square = ((moments * own) ** 2).sum(axis=1)
    np.testing.assert_allclose(square, square[0], rtol=1e-13)
    np.testing.assert_allclose(data.polhode[frame], data.contact, atol=1e-15)
    np.testing.assert_allclose(data.herpolhode[frame], data.contact, atol=1e-15)


def test_the_contact_is_at_rest_and_rolls() -> None:
    # The particle in contact, followed over a short time, does not move to first order.
    run = rigid.simulate(BODY, [1.1, 0.3, 0.4], t=np.array([0.0, 1e-4, 2e-4]), method="exact")
    start, middle, end = (figures.poinsot_data(run, frame=k) for k in range(3))
    particle = middle.contact @ middle.axes.T
    speed = (particle @ end.axes - particle @ start.axes) / 2e-4
    assert np.linalg.norm(speed) < 1e-7  # of second order in the step; omega² is 1.5
    # Rolling: the contact moves as fast on the ellipsoid as in the plane.
    on_plane = np.linalg.norm(np.diff(start.herpolhode, axis=0), axis=1)
    on_body = np.linalg.norm(np.diff(start.polhode, axis=0), axis=1)
    np.testing.assert_allclose(on_plane, on_body, rtol=1e-6)


def test_radii_of_the_herpolhode() -> None:
    # rho² = omega² - distance². With E and L given, omega² is linear in the square of the rate
    # about the middle axis, so its extremes are where that is zero and where it is largest.
    run = rigid.simulate(BODY, [1.1, 0.3, 0.4], t=np.linspace(0.0, 30.0, 30001))
    data = figures.poinsot_data(run)
    radius = np.hypot(*data.herpolhode[:, :2].T)
    twice_energy, square = 1.1**2 + 2.0 * 0.3**2 + 3.0 * 0.4**2, 1.1**2 + 4 * 0.3**2 + 9 * 0.4**2
    assert data.distance == pytest.approx(twice_energy / np.sqrt(square), rel=1e-14)
    largest = float(exact.free_body(BODY, [1.1, 0.3, 0.4]).amplitude[1])
    extremes = []
    for middle in (0.0, largest**2):
        sums = [twice_energy - 2.0 * middle, square - 4.0 * middle]
        others = np.linalg.solve(np.array([[1.0, 3.0], [1.0, 9.0]]), sums)
        extremes.append(np.sqrt(others.sum() + middle - data.distance**2))
    np.testing.assert_allclose([radius.min(), radius.max()], sorted(extremes), rtol=1e-6)


def test_the_picture_of_poinsot_carries_its_curves() -> None:
    drawn = figures.poinsot(poinsot_run(401), frame=100)
    data = drawn.data
    np.testing.assert_array_equal(joined(drawn.polhode, drawn.hidden), data.polhode)
    np.testing.assert_array_equal(data_of(drawn.herpolhode), data.herpolhode)
    np.testing.assert_array_equal(data_of(drawn.contact), data.contact[np.newaxis])
    np.testing.assert_array_equal(drawn.omega.vector, data.contact)
    np.testing.assert_allclose(drawn.momentum.vector[:2], 0.0)
    assert "invariable plane" in [text.strip() for text in texts(drawn.ax)]
    assert colours.L.label in texts(drawn.ax)
    assert colours.OMEGA.label in texts(drawn.ax)


# Families of polhodes

ORDERS = [(1.0, 2.0, 3.0), (3.0, 1.2, 2.5), (2.0, 2.5, 0.9), (0.0109, 0.1044, 0.1148)]


@pytest.mark.parametrize("moments", ORDERS)
def test_polhodes_have_one_energy_and_each_its_momentum(moments: Any) -> None:
    data = figures.polhodes_data(moments, count=4, samples=181)
    own = np.array(moments)
    energy = (own * data.curves**2).sum(axis=-1)
    np.testing.assert_allclose(energy, own.min(), rtol=1e-13)
    momentum = ((own * data.curves) ** 2).sum(axis=-1)
    np.testing.assert_allclose(momentum, momentum[:, :1] + 0.0 * momentum, rtol=1e-12)
    np.testing.assert_allclose(data.curves[:, 0], data.curves[:, -1], atol=1e-14)
    # On each side of the separatrix L² = 2 E I2, about the axis it says, which keeps its sign.
    middle = np.sort(own)[1]
    about_least = np.abs(data.axis) == own.argmin() + 1
    np.testing.assert_array_equal(momentum[:, 0] < energy[:, 0] * middle, about_least)
    for curve, axis in zip(data.curves, data.axis, strict=True):
        assert (np.sign(curve[:, abs(axis) - 1]) == np.sign(axis)).all()
    counts = np.unique(data.axis, return_counts=True)[1]
    np.testing.assert_array_equal(counts, 4)
    on_border = ((own * data.separatrix) ** 2).sum(axis=-1)
    np.testing.assert_allclose(on_border, own.min() * middle, rtol=1e-13)
    np.testing.assert_allclose((own * data.separatrix**2).sum(axis=-1), own.min(), rtol=1e-13)


def test_a_motion_stays_on_its_polhode() -> None:
    data = figures.polhodes_data((1.0, 2.0, 3.0), count=3, samples=4001)
    for curve in data.curves[[0, 4, 7]]:
        run = rigid.simulate(BODY, curve[0], t=np.linspace(0.0, 20.0, 60), record="rates")
        apart = np.linalg.norm(run.omega[:, np.newaxis] - curve, axis=-1).min(axis=1)
        assert apart.max() < 2e-3  # half the distance of two points of the curve


def test_the_picture_of_polhodes_carries_the_family() -> None:
    drawn = figures.polhodes((1.0, 2.0, 3.0), count=3)
    data = drawn.data
    for k, points in enumerate(data.curves):
        np.testing.assert_array_equal(joined(drawn.seen[k], drawn.hidden[k]), points)
        colour = colours.AXES[abs(data.axis[k]) - 1].colour
        assert drawn.seen[k].get_color() == colour
    assert len(drawn.separatrix) == 2
    words = texts(drawn.ax)
    assert words == ["1: least moment", "2: middle moment", "3: largest moment"]
    figures.polhodes(rigid.Body((3.0, 1.2, 2.5)))


# The throw


def test_the_picture_of_the_throw_carries_the_experiment() -> None:
    thrown = free.throw_experiment(rigid.Body.box(0.01, 0.08, 0.25), [0.05, 0.05, 0.05])
    drawn = figures.throw(thrown)
    for k in range(6):
        for axis in range(3):
            line = drawn.omega[k][axis]
            np.testing.assert_array_equal(data_of(line)[:, 0], thrown.t)
            np.testing.assert_array_equal(data_of(line)[:, 1], thrown.omega[k, :, axis])
            assert line.get_color() == colours.AXES[axis].colour
        dots = np.stack([np.arange(31.0), thrown.dots[k]], axis=1)
        np.testing.assert_array_equal(data_of(drawn.dots[k]), dots)
        assert dots[:, 1].min() >= 0.0  # never below zero (erratum S-14)
    # Clean runs stand still, and their dots are 0, the growth rate about the middle axis, 0.
    np.testing.assert_array_equal(np.ptp(thrown.omega[:3], axis=1), 0.0)
    np.testing.assert_allclose(thrown.dots[:3].T, [[0.0, 0.888352678, 0.0]] * 31, atol=1e-9)
    # On the lasting motions with noise most dots are positive too (erratum S-15).
    assert (thrown.dots[[3, 5]] > 1e-3).mean() > 0.5
    seen = data_of(drawn.omega[4][1])[-1]
    np.testing.assert_allclose(seen, [30.0, -1.04874988073], rtol=1e-10)
    titles = [ax.get_title(loc="left") for ax in drawn.axes]
    assert titles[0] == "cleanly about axis 1"
    assert titles[5] == "with noise about axis 3"
    assert drawn.axes[3].get_xlabel() == "$t$ (s)"
    assert drawn.axes[0].get_ylabel() == r"$\omega$ (rad/s)"
    assert r"max Re $\lambda$ (1/s)" in texts(drawn.axes[0])


# Drift


def test_the_largest_drift_is_that_of_the_run() -> None:
    free_run = rigid.simulate(
        BODY, [1.0, 1.0, 1.0], t=np.linspace(0.0, 50.0, 101), method="rk4", step=0.05
    )
    data = figures.invariants_data(free_run)
    assert data.names == ("energy", "L", "L_space")
    assert data.drift[0].max() == pytest.approx(float(free_run.energy_drift), rel=1e-6)
    assert data.drift[1].max() == pytest.approx(float(free_run.momentum_drift), rel=1e-6)
    assert (data.drift[2] >= data.drift[1] * (1.0 - 1e-6)).all()  # a vector and its size
    # Without the attitude, the vertical of which has an error of its own.
    top_run = rigid.simulate(
        TOP,
        omega_of("cusp"),
        TILTED,
        t=np.linspace(0.0, 50.0, 101),
        method="rk4",
        step=0.02,
        record="axis",
    )
    data = figures.invariants_data(top_run)
    assert data.names == ("energy", "p_phi", "p_psi")
    assert data.drift[0].max() == pytest.approx(float(top_run.energy_drift), rel=1e-6)
    assert data.drift[1].max() == pytest.approx(float(top_run.momentum_drift), rel=1e-6)
    assert data.drift[2].max() == 0.0  # I3 omega3 of equal moments is no sum
    np.testing.assert_array_equal(data.drift[:, 0], 0.0)


def test_what_is_kept_depends_on_the_scene() -> None:
    t = np.linspace(0.0, 10.0, 51)
    general = rigid.simulate(ASYMMETRIC, [0.2, 0.1, 5.0], TILTED, t=t)
    assert figures.invariants_data(general).names == ("energy", "p_phi")
    rates = rigid.simulate(BODY, [1.0, 1.0, 1.0], t=t, record="rates")
    assert figures.invariants_data(rates).names == ("energy", "L")
    driven = rigid.simulate(DAMPED, [0.1, 0.1, 5.0], TILTED, t=t, method="dop853", step=0.01)
    data = figures.invariants_data(driven)
    assert data.names == ("energy less work",)
    assert data.drift.max() < 1e-10  # the energy itself falls by more than a tenth
    kept = free.invariants(driven).energy
    assert np.ptp(kept) > 0.1 * kept[0]


def test_the_picture_of_drift_carries_it() -> None:
    run = rigid.simulate(
        BODY, [1.0, 1.0, 1.0], t=np.linspace(0.0, 50.0, 101), method="splitting4", step=0.05
    )
    drawn = figures.invariants(run)
    floor = 0.02 * np.finfo(float).eps
    for line, values in zip(drawn.lines, drawn.data.drift, strict=True):
        np.testing.assert_array_equal(data_of(line)[:, 0], run.t)
        np.testing.assert_array_equal(data_of(line)[:, 1], np.maximum(values, floor))
    assert drawn.ax.get_yscale() == "log"
    assert drawn.ax.get_xlabel() == "$t$ (s)"
    assert drawn.ax.get_ylabel() == "relative drift"
    assert drawn.data.drift[1:].max() < 1e-13  # the scheme keeps L, in space too
    assert drawn.data.drift[0].max() > 1e-10


# Refusals


@pytest.mark.parametrize(
    ("call", "error", "message"),
    [
        (lambda: figures.cubic(ASYMMETRIC, [0, 0, 1]), ValueError, "moments = .* two moments"),
        (
            lambda: figures.effective_potential(DAMPED, [0, 0, 1]),
            ValueError,
            "energy and momenta of a top: needs a scene without torque and damping",
        ),
        (lambda: figures.cubic(wrong(BODY), [0, 0, 1]), TypeError, "must be a rigid.HeavyTop"),
        (lambda: figures.cubic(TOP, [0, 0]), ValueError, r"omega: expected shape \(3,\)"),
        (lambda: figures.cubic(TOP, [0, 0, np.nan]), ValueError, "nan: must be finite"),
        (
            lambda: figures.cubic(TOP, [0, 0, 1], [TILTED, TILTED]),
            ValueError,
            "attitude: expected a single one",
        ),
        (lambda: figures.upright_cubic(TOP, [1, 2]), ValueError, r"spins: expected shape \(3,\)"),
        (lambda: figures.upright_cubic(DAMPED), ValueError, "torque and damping"),
        (
            lambda: figures.locus(ASYMMETRIC, [0, 0, 1]),
            ValueError,
            r"t = None: the axis of this top has no period \(general\)",
        ),
        (lambda: figures.locus(TOP, [0, 0, 5]), ValueError, r"no period \(sleeping\)"),
        (lambda: figures.locus(wrong(BODY), [0, 0, 5]), TypeError, "must be a rigid.HeavyTop"),
        (
            lambda: figures.locus(TOP, [0, 0, 5], [TILTED]),
            ValueError,
            r"attitude: expected shape \(4,\)",
        ),
        (
            lambda: figures.loci(TOP, [[0, 0, 5]], [TILTED, TILTED]),
            ValueError,
            r"attitude: expected shape \(4,\) or \(1, 4\)",
        ),
        (lambda: figures.cycloids(TOP, 1.0, 0.0), ValueError, "a fast top needs a spin"),
        (lambda: figures.cycloids(TOP, 4.0, 9.0), ValueError, "tilt = 4.0: must lie in"),
        (lambda: figures.cycloids(DAMPED, 1.0, 9.0), ValueError, "cycloids: needs a scene"),
        (lambda: figures.cycloids(TOP, 1.0, 9.0, periods=0), ValueError, "periods = 0.0"),
        (
            lambda: figures.cycloids(TOP, 1.0, 9.0, pushes=[[1.0]]),
            ValueError,
            r"pushes: expected shape \(k,\)",
        ),
        (lambda: figures.poinsot(poinsot_run(3), frame=3), ValueError, "frame = 3: the run has 3"),
        (
            lambda: figures.poinsot(poinsot_run(3), frame=wrong(0.5)),
            TypeError,
            "must be a whole number",
        ),
        (
            lambda: figures.poinsot(rigid.simulate(TOP, [0, 0, 1], t=[0, 1])),
            TypeError,
            "that of a rigid.FreeBody",
        ),
        (
            lambda: figures.poinsot(rigid.simulate(BODY, [0, 0, 1], t=[0, 1], record="rates")),
            ValueError,
            "record = 'rates': record = 'attitude' is needed",
        ),
        (
            lambda: figures.poinsot(rigid.simulate(BODY, [0, 0, 0], t=[0, 1])),
            ValueError,
            "no invariable plane",
        ),
        (
            lambda: figures.poinsot(
                rigid.simulate(rigid.FreeBody(BODY.body, damping=0.1), [0, 0, 1], t=[0, 1])
            ),
            ValueError,
            "Poinsot's picture: needs a scene without",
        ),
        (lambda: figures.polhodes((1, 1, 1.5)), ValueError, "three different moments"),
        (lambda: figures.polhodes((1, 2, 4)), ValueError, "triangle inequality"),
        (lambda: figures.polhodes((1, 2, 2.5), count=0), ValueError, "count = 0: must be at least"),
        (lambda: figures.throw(wrong(None)), TypeError, "experiment = None: must be a"),
        (lambda: figures.invariants(wrong(None)), TypeError, "run = None: must be a rigid.Run"),
        (
            lambda: figures.invariants(rigid.simulate(BODY, [[0, 0, 1]], t=[0, 1])),
            ValueError,
            r"omega of shape \(1, 2, 3\): needs one body",
        ),
        (
            lambda: figures.invariants(rigid.simulate(BODY, [0, 0, 0], t=[0, 1])),
            ValueError,
            "at rest has nothing to drift",
        ),
        (
            lambda: figures.invariants(rigid.simulate(TOP, [0, 0, 1], t=[0, 1], record="rates")),
            ValueError,
            "the energy of a heavy top needs it",
        ),
        (
            lambda: figures.poinsot(poinsot_run(3), ax=Figure().add_subplot()),
            ValueError,
            "needs 3-D axes",
        ),
        (
            lambda: figures.cubic(TOP, [0, 0, 1], ax=Figure().add_subplot(projection="3d")),
            ValueError,
            "needs 2-D axes",
        ),
        (
            lambda: figures.upright_cubic(TOP, axes=[Figure().add_subplot()]),
            ValueError,
            "has 3 panels, got 1 axes",
        ),
    ],
)
def test_what_cannot_be_drawn_is_refused(call: Any, error: Any, message: str) -> None:
    with pytest.raises(error, match=message):
        call()


def test_without_matplotlib_it_is_said_what_is_missing() -> None:
    code = (
        "import sys; sys.modules['matplotlib'] = sys.modules['matplotlib.figure'] = None\n"
        "from rigid import figures\n"
        "figures.polhodes_data((1.0, 2.0, 3.0))\n"
        "try:\n"
        "    figures.polhodes((1.0, 2.0, 3.0))\n"
        "except ImportError as error:\n"
        "    print(error)\n"
    )
    said = python_process(code).stdout.strip()
    assert said == "plotting needs matplotlib: pip install 'rigid[maps]'"


# The gallery


@pytest.mark.parametrize(
    "name",
    [
        "cubic",
        "cycloids",
        "effective_potential",
        "invariants",
        "locus",
        "poinsot",
        "polhodes",
        "stability_map",
        "throw",
        "upright_cubic",
        "work_precision",
    ],
)
def test_gallery(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """The page draws its figure, says what it shows, and leaves nothing open."""
    monkeypatch.setenv("MPLBACKEND", "Agg")
    import matplotlib.pyplot as plt

    plt.switch_backend("Agg")
    shown: list[int] = []
    monkeypatch.setattr(plt, "show", lambda: shown.extend(plt.get_fignums()))
    names = runpy.run_path(str(GALLERY / f"plot_{name}.py"))
    for number in set(shown):
        plt.figure(number).savefig(BytesIO(), format="png", dpi=40)
    plt.close("all")
    assert len(shown) >= 1
    title, line = str(names["__doc__"]).splitlines()[:2]
    assert line == "=" * len(title)
