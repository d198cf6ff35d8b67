"""Free tops, symmetric and asymmetric, and their cones, against paths and printed numbers."""

import numpy as np
import pytest
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation
from scipy.special import ellipj, ellipk, ellipkinc

import rigid
from free_motions import OBLATE, PROLATE, SPUN, moments_at_random, path
from physics import ROUNDOFF, Floats, angle_between, golden_number, present, rotation_matrix, tilted
from rigid import Body, FreeBody, free

RANDOM = np.random.default_rng(38)


# The symmetric free top


@pytest.mark.parametrize(("body", "k"), [(OBLATE, 1.38), (PROLATE, -1.035)])
def test_the_symmetric_free_top_of_the_table(body: tuple[float, float, float], k: float) -> None:
    """By Goldstein, § 5.6; the numbers k are those of the worked cases."""
    found = free.symmetric_free_top(body, SPUN)
    across, spin = SPUN[0], SPUN[2]
    assert found.axis == 3
    assert found.k == pytest.approx(k, rel=4 * ROUNDOFF)
    assert found.spin == -found.k
    assert found.period == pytest.approx(2.0 * np.pi / abs(k), rel=8 * ROUNDOFF)
    assert found.frequency == pytest.approx(abs(k) / (2.0 * np.pi), rel=8 * ROUNDOFF)
    alpha, theta = np.arctan(across / spin), np.arctan(body[0] * across / (body[2] * spin))
    assert found.alpha == pytest.approx(alpha, rel=8 * ROUNDOFF)
    assert found.theta == pytest.approx(theta, rel=8 * ROUNDOFF)
    assert found.space_cone == pytest.approx(abs(alpha - theta), rel=16 * ROUNDOFF)
    momentum = np.hypot(body[0] * across, body[2] * spin)
    assert found.precession == pytest.approx(momentum / body[0], rel=8 * ROUNDOFF)


@pytest.mark.parametrize("body", [OBLATE, PROLATE])
@pytest.mark.parametrize("spin", [2.3, -2.3])
def test_the_symmetric_free_top_on_its_path(body: tuple[float, float, float], spin: float) -> None:
    start = np.array([0.9, 0.4, spin])
    attitude = [0.8, 0.36, -0.48, 0.0]
    found = free.symmetric_free_top(body, start, attitude, t=np.linspace(0.0, 3.0, 301))
    omega, turn = path(body, start, np.linspace(0.0, 3.0, 301), attitude)
    assert np.array_equal(present(found.omega), omega)
    t = np.linspace(0.0, 3.0, 301)
    # omega in the body: amplitude, phase and the signed rate k.
    phase = float(found.k) * t + float(found.phase)
    circle = float(found.amplitude) * np.stack([np.cos(phase), np.sin(phase)], axis=-1)
    np.testing.assert_allclose(omega[:, :2], circle, atol=1e-14)
    # Cones: omega against L in space, omega and L against the axis.
    in_space = np.einsum("tij,tj->ti", turn, omega)
    momentum = np.einsum("tij,tj->ti", turn, omega * np.array(body))
    axis = turn[:, :, 2]
    np.testing.assert_allclose(angle_between(in_space, momentum), found.space_cone, atol=1e-14)
    np.testing.assert_allclose(angle_between(in_space, axis), found.alpha, atol=1e-14)
    np.testing.assert_allclose(angle_between(momentum, axis), found.theta, atol=1e-14)
    assert found.space_cone == pytest.approx(abs(found.alpha - found.theta), abs=1e-15)
    assert np.abs(np.linalg.det(np.stack([axis, in_space, momentum], axis=1))).max() < 1e-14
    # Precession: the angle of the axis about L, and rolling of the cones.
    along = momentum[0] / np.linalg.norm(momentum[0])
    node = np.cross(along, axis)
    turned = np.unwrap(np.arctan2((np.cross(node[0], node) @ along), node @ node[0]))
    assert turned[-1] / 3.0 == pytest.approx(found.precession, rel=1e-13)
    assert found.precession * np.sin(found.theta) == pytest.approx(
        found.rate * np.sin(found.alpha), rel=1e-14
    )
    # Euler's rates about L: omega3 = phi' cos(theta) + psi'.
    third = found.precession * np.cos(found.theta) + found.spin
    assert third == pytest.approx(spin, rel=1e-13)
    # D-20: the printed k/2 is no frequency, and the printed period is negative if prolate.
    measured = abs(np.ptp(np.unwrap(np.arctan2(omega[:, 1], omega[:, 0])))) / (2 * np.pi * 3.0)
    assert found.frequency == pytest.approx(measured, rel=1e-13)
    assert abs(abs(found.k) / 2 - measured) > 0.3
    assert (2 * np.pi / ((body[2] - 1.0) * spin) > 0.0) == (found.k > 0.0)
    # D-22: the printed half angle of the space cone is theta.
    assert abs(found.theta - angle_between(in_space, momentum)[0]) > 0.05


def test_turns_beyond_the_digits_of_a_phase_are_refused() -> None:
    """At 3e17 rad a double does not tell the angle: there are no rates to return."""
    top = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)
    beyond, starts = [0.0, 1e17], np.stack([[0.0, 0.0, 1.0], SPUN])
    for call in (
        lambda: free.symmetric_free_top(OBLATE, starts, t=beyond),
        lambda: free.asymmetric_free_top((1.0, 2.0, 2.5), starts, t=beyond),
        lambda: rigid.top.locus(top, starts, tilted(0.3), t=beyond),
    ):
        with pytest.raises(
            ValueError, match=r"^omega\[[01]\] = .*: the motion is not finite: .*phase"
        ):
            call()


def test_symmetric_limits() -> None:
    sphere = free.symmetric_free_top((2.0, 2.0, 2.0), [1.0, 2.0, 3.0])
    assert sphere.k == sphere.space_cone == 0.0
    assert sphere.period == np.inf
    straight = free.symmetric_free_top(OBLATE, [0.0, 0.0, -2.0])
    assert straight.body_cone == straight.space_cone == straight.amplitude == 0.0
    assert straight.alpha == straight.theta == pytest.approx(np.pi)
    rest = free.symmetric_free_top(OBLATE, [0.0, 0.0, 0.0])
    assert rest.precession == rest.alpha == rest.k == 0.0
    nearly = free.symmetric_free_top((1.0, 1.0, 1.0 + 2.0**-50), SPUN)
    assert nearly.k == pytest.approx(2.3 * 2.0**-50, rel=4 * ROUNDOFF)
    # |k| <= |omega|, with equality for a flat body spun about its axis.
    flat = free.symmetric_free_top((1.0, 1.0, 2.0), [[0.0, 0.0, 3.0], [1.0, 0.0, 3.0]])
    assert flat.k.tolist() == [3.0, 3.0]
    assert (flat.k <= flat.rate).all()
    # The axis may be any: for the first, alpha = (I1 - I3) omega1 / I3 as seen along it.
    for turns in range(3):
        renamed = free.symmetric_free_top(np.roll(OBLATE, turns), np.roll(SPUN, turns))
        assert renamed.axis == (turns + 2) % 3 + 1
        same = free.symmetric_free_top(OBLATE, SPUN)
        for name in ("k", "precession", "alpha", "theta", "space_cone", "phase"):
            assert getattr(renamed, name) == getattr(same, name)


# The asymmetric free top


@pytest.mark.parametrize("scale", [1e-300, 1e-162, 1e200])
def test_the_cones_do_not_depend_on_the_unit_of_time(scale: float) -> None:
    known = free.symmetric_free_top((1.0, 1.0, 1.6), [0.9, 0.0, 2.3])
    found = free.symmetric_free_top((1.0, 1.0, 1.6), [0.9 * scale, 0.0, 2.3 * scale])
    for name in ("alpha", "theta", "body_cone", "space_cone"):
        assert getattr(found, name) == pytest.approx(getattr(known, name), rel=4 * ROUNDOFF)
    for name in ("rate", "k", "precession", "spin", "amplitude", "frequency"):
        value = scale * getattr(known, name)
        assert getattr(found, name) == pytest.approx(value, rel=4 * ROUNDOFF, abs=0.0)


@pytest.mark.parametrize("power", [-900, -600, -535, 500])
def test_quantities_scale_with_the_unit_of_time(power: int) -> None:
    """By a power of two, so to the last digit."""
    moments, rates = (1.0, 1.5, 2.0), np.array([[0.3, 0.2, 3.0], [0.31, 0.25, 2.99]])
    turned = np.array([[1.0, 0.0, 0.0, 0.0], [0.8, 0.0, 0.6, 0.0]])
    one = free.poinsot(moments, rates, turned)
    other = free.poinsot(moments, np.ldexp(rates, power), turned)
    for name in ("semi_axes", "distance", "polhode", "contact", "herpolhode", "radius"):
        assert np.array_equal(np.ldexp(getattr(one, name), power), getattr(other, name)), name
    for name in ("normal", "residual", "slip"):
        assert np.array_equal(getattr(one, name), getattr(other, name)), name
    one_cone, other_cone = (
        free.cones((1.0, 1.0, 1.6), np.ldexp(rates[0], scale)) for scale in (0, power)
    )
    assert np.array_equal(one_cone.body_curve, other_cone.body_curve)
    assert np.array_equal(one_cone.space_curve, other_cone.space_curve)
    frequency = free.asymmetric_free_top(moments, rates).frequency
    found = free.asymmetric_free_top(moments, np.ldexp(rates, power)).frequency
    assert np.array_equal(np.ldexp(frequency, power), found)
    body = FreeBody(Body(moments))
    momentum = free.invariants(body, rates).L
    found = free.invariants(body, np.ldexp(rates, power)).L
    assert np.array_equal(np.ldexp(momentum, power), found)
    for axis in (1, 2):
        known = free.permanent_rotation(moments, axis)
        scaled = free.permanent_rotation(moments, axis, 2.0**power)
        assert scaled.kind == known.kind
        assert scaled.growth == np.ldexp(known.growth, power)
        assert scaled.frequency == np.ldexp(known.frequency, power)


def test_the_asymmetric_free_top_of_the_table() -> None:
    found = free.asymmetric_free_top((1.0, 2.0, 3.0), [0.3, 0.2, 1.2], t=[10.0])
    # Landau and Lifshitz, Mechanics, § 37, of a polhode about axis 3: L² > 2 E I2.
    twice, squared = 0.09 + 2 * 0.04 + 3 * 1.44, 0.09 + 4 * 0.04 + 9 * 1.44
    m = (2 - 1) * (twice * 3 - squared) / ((3 - 2) * (squared - twice))
    rate = np.sqrt((3 - 2) * (squared - twice) / 6)
    assert found.period == pytest.approx(4.0 * ellipk(m) / rate, rel=4e-15)
    assert found.m == pytest.approx(m, rel=2e-14)
    name = "free.I(1,2,3).w(0.3,0.2,1.2).t10"
    assert present(found.omega)[0] == pytest.approx(golden_number(f"{name}.w"), abs=1e-13)
    matrix = rotation_matrix(present(found.attitude)[0]).ravel()
    assert matrix == pytest.approx(golden_number(f"{name}.R_body_to_lab"), abs=1e-13)


def test_rates_are_jacobi_functions() -> None:
    moments = moments_at_random(60, RANDOM)
    omega = RANDOM.normal(size=(60, 3))
    t = np.linspace(0.0, 7.0, 15)
    found = free.asymmetric_free_top(moments, omega, t=t)
    # T = 4 K / p with SciPy's K.
    np.testing.assert_allclose(4.0 * ellipk(found.m) / found.frequency, found.period, rtol=1e-11)
    for body in range(60):
        axis = abs(int(found.axis[body])) - 1
        middle = int(np.argsort(moments[body])[1])
        other = 3 - axis - middle
        # The phase at the start, where the middle rate is amplitude sn; sn, cn, dn are SciPy's.
        sine = omega[body, middle] / found.amplitude[body, middle]
        m, p = float(found.m[body]), float(found.frequency[body])
        start = float(ellipkinc(np.arcsin(np.clip(sine, -1.0, 1.0)), m))
        if free.euler_rhs(moments[body], omega[body])[middle] < 0.0:
            start = float(2.0 * ellipk(m)) - start
        sn, cn, dn, _ = ellipj(start + p * t, m)
        rates = present(found.omega)[body]
        np.testing.assert_allclose(rates[:, middle] / found.amplitude[body, middle], sn, atol=1e-9)
        np.testing.assert_allclose(
            np.abs(rates[:, other]) / found.amplitude[body, other], np.abs(cn), atol=1e-8
        )
        np.testing.assert_allclose(
            np.abs(rates[:, axis]) / found.amplitude[body, axis], dn, atol=1e-9
        )


def test_towards_the_symmetric_top() -> None:
    symmetric = free.symmetric_free_top(OBLATE, SPUN)
    nearly = free.asymmetric_free_top((1.0, 1.0 + 1e-13, 1.6), SPUN)
    assert nearly.period == pytest.approx(symmetric.period, rel=1e-12)
    assert nearly.frequency == pytest.approx(abs(symmetric.k), rel=1e-12)
    assert free.asymmetric_free_top(OBLATE, SPUN).m == 0.0


def test_on_the_separatrix_the_rates_are_hyperbolic() -> None:
    # I1 (I2 - I1) w1² = I3 (I3 - I2) w3²: 4 * 2.5 * 3² = 9 * 2.5 * 2².
    t = np.linspace(0.0, 3.0, 7)
    found = free.asymmetric_free_top((4.0, 6.5, 9.0), [3.0, 0.0, 2.0], t=t)
    assert found.m == 1.0
    assert found.period == np.inf
    rates = present(found.omega)
    p = float(found.frequency)
    np.testing.assert_allclose(rates[:, 0], 3.0 / np.cosh(p * t), atol=1e-14)
    np.testing.assert_allclose(rates[:, 2], 2.0 / np.cosh(p * t), atol=1e-14)
    np.testing.assert_allclose(np.abs(rates[:, 1]), found.amplitude[1] * np.tanh(p * t), atol=1e-14)


def test_the_complementary_parameter_comes_from_the_components() -> None:
    moments = np.array([65.0, 626.0, 689.0])
    omega = np.array([1e-10, 1.0, 1e-10])
    found = free.asymmetric_free_top(moments, omega)
    assert found.mc == pytest.approx(1.957904e-21, rel=3e-7)
    assert found.period == pytest.approx(113.592275339, rel=5e-12)
    # 2 E I2 - L² from energy and momentum is rounding.
    naive = (moments * omega**2).sum() * 626.0 - ((moments * omega) ** 2).sum()
    assert free.circulation(moments, omega).margin == pytest.approx(-6.942e-17, rel=1e-12)
    assert abs(naive - -6.942e-17) > 0.5 * 6.942e-17


# Cones


@pytest.mark.parametrize(
    ("body", "rolling"), [(OBLATE, "inside"), (PROLATE, "outside"), ((1.0, 1.0, 1.0), "none")]
)
def test_cones_roll(body: tuple[float, float, float], rolling: str) -> None:
    attitude = np.array([0.8, 0.36, -0.48, 0.0])
    found = free.cones(body, SPUN, attitude, samples=721)
    assert found.rolling == rolling
    t = np.linspace(0.0, 4.0, 41)
    omega, turn = path(body, SPUN, t, attitude)
    in_body = omega / np.linalg.norm(omega, axis=-1, keepdims=True)
    in_space = np.einsum("tij,tj->ti", turn, in_body)
    momentum = turn[0] @ (np.array(body) * SPUN)
    if rolling == "none":
        assert np.ptp(in_space, axis=0).max() < 1e-14
        return
    # D-21, D-23: in space omega turns about L on the space cone, in the body on the body cone.
    np.testing.assert_allclose(angle_between(in_space, momentum), found.space_cone, atol=1e-14)
    np.testing.assert_allclose(angle_between(in_body, np.eye(3)[2]), found.body_cone, atol=1e-14)
    assert abs(found.body_cone - found.space_cone) > 0.1
    # The path lies on the curves: 1/720 of a turn from one point to the next.
    for curve, seen in ((found.body_curve, in_body), (found.space_curve, in_space)):
        nearest = angle_between(seen[:, None, :], curve[None]).min(axis=1)
        assert nearest.max() < np.pi / 720
        np.testing.assert_allclose(curve[0], seen[0], atol=1e-15)
        np.testing.assert_allclose(curve[-1], curve[0], atol=1e-15)
    # The curves run as omega moves: in the body by Euler's equations, in space R omega' with it.
    change = free.euler_rhs(body, SPUN)
    assert (found.body_curve[1] - found.body_curve[0]) @ change > 0.0
    assert (found.space_curve[1] - found.space_curve[0]) @ (turn[0] @ change) > 0.0
    # Oblate: L lies between the axis and omega, so that the space cone is within the body cone.
    axis = turn[0][:, 2]
    inside = angle_between(momentum, axis) < angle_between(in_space[0], axis)
    assert inside == (rolling == "inside")


# The frame of the axis


def test_the_frame_of_the_axis_needs_no_torque() -> None:
    body, nu = np.array([1.0, 1.0, 1.4]), 0.8
    frame = free.steady_axis_frame(body, nu, tilt=0.3)
    omega = frame + np.array([0.0, 0.0, nu])
    torque = np.cross(frame, body * omega)
    np.testing.assert_allclose(torque, 0.0, atol=1e-15)
    # S-03: the printed line of the second component, with I0 where Iz is meant.
    printed = frame[2] * frame[0] - frame[0] * 1.0 * (frame[2] + nu)
    assert abs(printed) > 0.1
    # With the numbers of the proof the printed line leaves -0.296.
    z = free.steady_axis_frame(body, nu)[2]
    assert z * 0.37 - 0.37 * (z + nu) == pytest.approx(-0.296, abs=1e-12)
    # S-04: |Omega| = nu Iz / ((I0 - Iz) cos), not times a radius and the cosine.
    size = np.linalg.norm(frame)
    assert size == pytest.approx(abs(nu * 1.4 / (1.0 - 1.4)) / np.cos(0.3), rel=1e-14)
    assert abs(size - abs(nu * 1.4 * 2.0 * np.cos(0.3) / (1.0 - 1.4))) > 1.0
    # Parallel to L = I0 Omega; the same rates as those of the free top; and back.
    np.testing.assert_allclose(body * omega, 1.0 * frame, atol=1e-14)
    top_of_it = free.symmetric_free_top(body, omega)
    assert top_of_it.precession == pytest.approx(size, rel=1e-14)
    assert top_of_it.k == pytest.approx(-nu, rel=1e-14)
    assert free.steady_axis_spin(body, frame) == pytest.approx(nu, rel=1e-14)
    assert free.steady_axis_frame(body, [nu, 0.0]).tolist()[1] == [0.0, 0.0, 0.0]


# Poinsot's picture: polhode, herpolhode and the ellipsoid that rolls


def extremes(moments: ArrayLike, omega: ArrayLike) -> tuple[Floats, float, list[float]]:
    """Largest rates, distance of the plane, least and largest radius of the herpolhode.

    From the invariants: the polhode is extreme where one rate vanishes. Moments ascending, and a
    polhode about the first axis.
    """
    i1, i2, i3 = np.asarray(moments, dtype=np.float64)
    w = np.asarray(omega, dtype=np.float64)
    twice = i1 * w[0] ** 2 + i2 * w[1] ** 2 + i3 * w[2] ** 2
    squared = (i1 * w[0]) ** 2 + (i2 * w[1]) ** 2 + (i3 * w[2]) ** 2
    assert squared < twice * i2
    a1 = (twice * i3 - squared) / (i1 * (i3 - i1))
    a2 = (squared - twice * i1) / (i2 * (i2 - i1))
    a3 = (squared - twice * i1) / (i3 * (i3 - i1))
    # On the other crossing w3 = 0: w1² i1 + w2² i2 = 2 E and the same with the squares.
    b1 = (twice * i2 - squared) / (i1 * (i2 - i1))
    distance = twice / np.sqrt(squared)
    radii = sorted([float(np.sqrt(a1 + a3 - distance**2)), float(np.sqrt(b1 + a2 - distance**2))])
    return np.sqrt([a1, a2, a3]), distance, radii


def test_the_worked_polhode_belongs_to_no_body() -> None:
    # The formulas of this test reproduce the printed numbers of (1, 2, 3.5)...
    largest, distance, radii = extremes((1, 2, 3.5), (1.1, 0.3, 0.4))
    np.testing.assert_allclose(largest, [1.14804181109, 0.888819441732, 0.424936970116], rtol=1e-11)
    assert distance == pytest.approx(1.03788027605, rel=1e-11)
    assert radii == pytest.approx([0.287757767190, 0.649134778878], rel=1e-11)
    # ...but 1 + 2 < 3.5.
    with pytest.raises(ValueError, match="triangle inequality"):
        free.poinsot((1, 2, 3.5), [[1.1, 0.3, 0.4]])


def test_poinsot_s_ellipsoid_rolls() -> None:
    body, omega = rigid.Body((1.0, 2.0, 2.5)), np.array([1.1, 0.3, 0.4])
    largest, distance, radii = extremes(body.moments, omega)
    motion = free.asymmetric_free_top(body, omega)
    np.testing.assert_allclose(motion.amplitude, largest, rtol=1e-14)
    # The radii are reached where a rate reverses.
    times = np.sort(free.crossings(body, omega, count=2)[1:].ravel())
    scene, start = rigid.FreeBody(body), [0.8, 0.36, -0.48, 0.0]
    run = rigid.simulate(scene, omega, start, t=times)
    turning = free.poinsot(body, run.omega, run.attitude)
    np.testing.assert_allclose(np.sort(present(turning.radius))[[0, -1]], radii, rtol=1e-12)
    t = np.linspace(0.0, 12.0, 2001)
    run = rigid.simulate(scene, omega, start, t=t)
    found = free.poinsot(body, run.omega, run.attitude)
    assert found.distance == pytest.approx(distance, rel=1e-15)
    assert np.abs(present(found.residual)).max() < 1e-13
    radius = present(found.radius)
    assert radius.min() >= radii[0] * (1 - 1e-12)
    assert radius.max() <= radii[1] * (1 + 1e-12)
    # The polhode is on the ellipsoid of energy and on that of momentum; the ellipsoid of energy
    # has its gradient along L there.
    moments = np.array(body.moments)
    shares = (found.polhode / found.semi_axes) ** 2
    np.testing.assert_allclose(shares.sum(axis=1), 1.0, atol=1e-14)
    momenta = (moments * found.polhode) ** 2
    np.testing.assert_allclose(momenta.sum(axis=1), momenta[0].sum(), rtol=1e-13)
    turn = rotation_matrix(present(run.attitude))
    gradient = np.einsum("tij,tj->ti", turn, found.polhode / found.semi_axes**2)
    assert (
        angle_between(gradient, np.broadcast_to(present(found.normal), gradient.shape)).max()
        < 1e-13
    )
    # Contact = foot of the normal and a point in the plane.
    in_plane = present(found.contact) - found.distance * present(found.normal)
    np.testing.assert_allclose(np.linalg.norm(in_plane, axis=1), radius, atol=1e-13)
    # Right-handed with the normal, the first axis towards that of space farthest from the normal.
    normal, flat = present(found.normal), present(found.herpolhode)
    far = np.eye(3)[np.abs(normal).argmin()]
    first = far - normal * (normal @ far)
    np.testing.assert_allclose(flat[:, 0], in_plane @ first / np.linalg.norm(first), atol=1e-13)
    second = np.cross(normal, first) / np.linalg.norm(first)
    np.testing.assert_allclose(flat[:, 1], in_plane @ second, atol=1e-13)
    # Rolling: the body point in contact has no velocity, omega × omega = 0; by the path, the
    # lengths rolled agree to second order.
    slips = [
        abs(present(free.poinsot(body, run.omega[::n], present(run.attitude)[::n]).slip))
        for n in (8, 4, 1)
    ]
    assert slips[0] / slips[1] == pytest.approx(4.0, abs=0.1)
    assert slips[2] < 1e-4
    # With a further turning about L the contact stays in the plane, but slips; without turning it
    # leaves the plane.
    half = 0.15 * t[:, None]
    extra = Rotation.from_rotvec(2.0 * half * present(found.normal))
    slipping = free.poinsot(body, run.omega, extra * run.rotation())
    assert np.abs(present(slipping.residual)).max() < 1e-13
    assert abs(present(slipping.slip)) > 0.1
    still = free.poinsot(body, run.omega, np.tile([1.0, 0.0, 0.0, 0.0], (2001, 1)))
    assert np.abs(present(still.residual)).max() > 0.1


def test_symmetric_polhodes_are_circles() -> None:
    run = rigid.simulate(rigid.FreeBody(rigid.Body(OBLATE)), SPUN, t=np.linspace(0.0, 9.0, 91))
    found = free.poinsot(OBLATE, run.omega, run.attitude)
    top_of_it = free.symmetric_free_top(OBLATE, SPUN)
    radius = np.hypot(0.9, 2.3) * np.sin(top_of_it.space_cone)
    np.testing.assert_allclose(present(found.radius), radius, rtol=1e-13)
    np.testing.assert_allclose(np.hypot(*found.polhode.T[:2]), 0.9, rtol=1e-13)
    assert found.distance == pytest.approx(np.hypot(0.9, 2.3) * np.cos(top_of_it.space_cone))
    # Rates alone tell the plane's distance and the polhode.
    assert free.poinsot(OBLATE, run.omega).contact is None


def test_a_rod_has_a_cylinder() -> None:
    found = free.poinsot((1.0, 1.0, 0.0), [[0.6, -0.3, 0.0]])
    assert found.semi_axes[2] == np.inf
    # G-16: a whole line of the cylinder touches: its points are on it and on the plane.
    line = np.array([0.6, -0.3, 0.0]) + np.outer(np.linspace(-2, 2, 9), [0.0, 0.0, 1.0])
    np.testing.assert_allclose(((line / found.semi_axes) ** 2).sum(axis=1), 1.0, rtol=1e-15)
    normal = np.array([0.6, -0.3, 0.0]) / np.hypot(0.6, 0.3)
    np.testing.assert_allclose(line @ normal, found.distance, rtol=1e-15)
