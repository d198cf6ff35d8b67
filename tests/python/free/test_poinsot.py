"""Poinsot's picture: polhode, herpolhode and the ellipsoid that rolls."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

import rigid
from free_motions import OBLATE, SPUN, angle
from physics import Floats, present, rotation_matrix
from rigid import free

# Poinsot


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
    assert angle(gradient, np.broadcast_to(present(found.normal), gradient.shape)).max() < 1e-13
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
