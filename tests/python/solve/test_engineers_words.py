"""Tops from mass and centre of mass, bodies as scenes: what an engineer has at hand."""

from itertools import permutations

import numpy as np
import pytest

import rigid
from physics import ROUNDOFF, tensor_of_points
from refusals import refuses
from rigid import solids

CONE = rigid.Body.cone(0.05, 0.16, mass=0.2)


def test_sides_belong_to_the_axes() -> None:
    for sides in permutations((0.25, 0.08, 0.01)):
        body = rigid.Body.box(*sides, mass=0.3)
        a, b, c = sides
        expected = [0.3 / 12 * (x * x + y * y) for x, y in ((b, c), (a, c), (a, b))]
        assert body.moments == pytest.approx(expected, rel=5 * ROUNDOFF)
        assert body.sides == sides
        assert body.mass == 0.3
    for axis in range(3):
        square = np.roll((1.0, 2.0, 2.0), axis)
        assert rigid.Body.box(*square).symmetry_axis == axis + 1
    assert rigid.Body.box(1.0, 2.0, 3.0).symmetry_axis is None


def test_a_body_is_the_scene_of_a_free_body() -> None:
    body, times = rigid.Body((1.0, 1.5, 2.0)), [0.0, 1.0]
    free, start = rigid.FreeBody(body), [0.1, 1.0, 0.2]
    assert rigid.simulate(body, start, t=times).omega.tobytes() == (
        rigid.simulate(free, start, t=times).omega.tobytes()
    )
    assert rigid.plan(body, "rates") == rigid.plan(free, "rates")
    grown = [rigid.condition(scene, start, t=times) for scene in (body, free)]
    assert np.array_equal(grown[0], grown[1])
    growth = [rigid.lyapunov(scene, start, t=[1.0]) for scene in (body, free)]
    assert np.array_equal(growth[0].exponent, growth[1].exponent)
    motion = rigid.Motion(body, start)
    motion.step(0.5)
    assert motion.scene == free
    assert sum(len(run.omega) for run in rigid.simulate_chunks(body, [start] * 3, t=times)) == 3
    grid = {"axes": {"I2": [1.4, 1.6]}, "samples": 2, "t_end": 5.0, "rng": 1}
    of_body = rigid.stability_map(body, stable=rigid.no_flip(), **grid)  # type: ignore[arg-type]
    of_scene = rigid.stability_map(free, stable=rigid.no_flip(), **grid)  # type: ignore[arg-type]
    assert np.array_equal(of_body.stable, of_scene.stable)


def test_the_sleeping_spin_of_a_cone_on_its_tip() -> None:
    # I1 = 3/5 m (r²/4 + h²), I3 = 3/10 m r² about the tip, and 3/4 h to the centre of mass.
    m, r, h, g = 0.2, 0.05, 0.16, 9.81
    across, along = 0.6 * m * (r * r / 4 + h * h), 0.3 * m * r * r
    bound = 2.0 * np.sqrt(m * g * 0.75 * h * across) / along
    top, axes = rigid.HeavyTop.from_mass(CONE, com=(0.0, 0.0, 0.12))
    assert np.array_equal(axes, np.eye(3))
    assert top.body.symmetry_axis == 3
    assert np.isclose(rigid.exact.sleeping_spin(top), bound, rtol=1e-14)
    solid = solids.cone(r, h, mass=m)
    other, axes = rigid.HeavyTop.from_properties(solid, pivot=(0, 0, 0), g=g)
    assert np.isclose(rigid.exact.sleeping_spin(other), bound, rtol=1e-14)


@pytest.mark.parametrize("seed", range(20))
def test_any_pivot_of_any_body_has_the_moments_of_its_mass_points(seed: int) -> None:
    rng = np.random.default_rng(seed)
    masses, points = rng.uniform(0.1, 1.0, 7), rng.normal(size=(7, 3))
    pivot, g = rng.normal(size=3) * 2.0, 3.7
    top, axes = rigid.HeavyTop.from_properties(
        rigid.inertia.point_masses(masses, points), pivot=pivot, g=g
    )
    mass, centre = masses.sum(), masses @ points / masses.sum()
    expected = tensor_of_points(masses, points - pivot)
    assert np.isclose(np.linalg.det(axes), 1.0, rtol=1e-13)
    size = np.abs(expected).max()
    assert np.allclose(axes @ np.diag(top.body.moments) @ axes.T, expected, atol=1e-14 * size)
    assert np.allclose(axes @ top.weight, mass * g * (centre - pivot), rtol=0, atol=1e-13 * mass)
    # The same from the body about its centre of mass, whose axes are others.
    body, own = rigid.Body.from_points(masses, points)
    again, more = rigid.HeavyTop.from_mass(body, com=own.T @ (centre - pivot), g=g)
    assert np.allclose(again.body.moments, top.body.moments, rtol=1e-12)
    assert np.allclose(own @ more @ again.weight, axes @ top.weight, atol=1e-12 * mass)


def test_gravity_is_that_of_the_earth_unless_another_one_is_given() -> None:
    body = rigid.Body.rod(2.0, mass=3.0)
    for given, g in (({}, 9.81), ({"g": 1.62}, 1.62)):
        top, _ = rigid.HeavyTop.from_mass(body, com=(0.0, 0.0, 1.0), **given)
        assert top.mgl == pytest.approx(3.0 * g, rel=1e-15)


def test_a_balanced_body_needs_no_direction_of_its_centre_of_mass() -> None:
    top, _ = rigid.HeavyTop.from_mass(CONE, com=(0.0, 0.0, 0.0))
    assert top.mgl == 0.0
    assert top.body.moments == CONE.moments
    assert rigid.HeavyTop(CONE, mgl=0.0).body is CONE


@pytest.mark.parametrize(
    "body",
    [
        CONE,
        rigid.Body.box(1.0, 2.0, 3.0),
        rigid.Body.sphere(1.0),
        rigid.Body.cylinder(1.0, 2.0),
        rigid.Body.ellipsoid(1.0, 2.0, 3.0),
        rigid.Body.from_properties(solids.cone(1.0, 2.0))[0],
        rigid.Body.from_points([1.0, 1.0, 1.0], np.eye(3))[0],
    ],
)
def test_moments_about_the_centre_of_mass_make_no_top(body: rigid.Body) -> None:
    assert body.about == "centre"
    with pytest.raises(ValueError, match=r"body = .*centre of mass.*HeavyTop\.from_mass\(body, c"):
        rigid.HeavyTop(body, mgl=1.0)
    top, _ = rigid.HeavyTop.from_mass(body, com=(0.0, 0.0, 1.0), mass=body.mass)  # type: ignore[arg-type]
    assert top.body.about == "point"
    with pytest.raises(ValueError, match="about another point"):
        rigid.HeavyTop.from_mass(top.body, com=(0.0, 0.0, 1.0))


BARE, PAIR = rigid.Body((1.0, 2.0, 2.5)), rigid.Body([(1.0, 2.0, 2.5)] * 2)
from_mass, from_properties = rigid.HeavyTop.from_mass, rigid.HeavyTop.from_properties

test_what_a_top_from_its_mass_refuses = refuses(
    [
        (lambda: from_mass(BARE, com=(0, 0, 1)), "mass: is needed"),
        (lambda: from_mass(CONE, com=(0, 0, 1), mass=3.0), "mass = 3: must be 0.2, the mass of t"),
        (lambda: from_mass(BARE, com=(0, 1), mass=1.0), "com"),
        (lambda: from_mass(CONE, com=(0, 0, 1), g=-1.0), "g = -1"),
        (lambda: from_mass(PAIR, com=(0, 0, 1), mass=1.0), "expected one body"),
        (lambda: from_properties(CONE, pivot=(0, 0, 0)), TypeError, "MassProperties"),  # type: ignore[arg-type]
        (lambda: from_properties(solids.cone(1.0, 2.0), pivot=(0, 0)), "pivot"),
        (lambda: from_properties(solids.cone([1, 2], 2), pivot=(0, 0, 0)), "expected one body"),
    ],
    literal=True,
)


@pytest.mark.parametrize("name", ["box", "ellipsoid", "sphere", "cylinder", "cone"])
def test_sizes_of_many_solids_make_many_bodies(name: str) -> None:
    make = getattr(rigid.Body, name)
    sizes = {"box": [1.0, 0.5], "ellipsoid": [1.0, 0.5], "sphere": []}.get(name, [0.7])
    many = make(np.array([0.3, 0.4]), *sizes, mass=[1.0, 2.0])
    for k, (first, mass) in enumerate([(0.3, 1.0), (0.4, 2.0)]):
        one = make(first, *sizes, mass=mass)
        assert many[k].moments == one.moments
        assert many[k].mass == one.mass
    assert many.about == "centre"
    with pytest.raises(ValueError, match=r"mass \(3,\): the axes of the bodies do not broadcast"):
        make(np.array([0.3, 0.4]), *sizes, mass=[1.0, 2.0, 3.0])
    with pytest.raises(ValueError, match=r"\[1\] = -1\.0: must be positive"):
        make([0.3, -1.0], *sizes)


def test_an_axis_of_a_map_may_be_a_size_of_a_solid() -> None:
    def scene(length: float) -> rigid.FreeBody:
        return rigid.FreeBody(rigid.Body.box(length, 0.5, 0.2))

    start, axes = rigid.Start(omega=(0.1, 1.0, 0.1)), {"length": [0.8, 1.2]}
    result = rigid.stability_map(
        scene, axes=axes, start=start, stable=rigid.no_flip(2), samples=2, t_end=5.0, rng=1
    )
    assert result.stable.shape == (2,)


def test_what_is_asked_first_has_an_answer() -> None:
    body = rigid.Body((1.0, 1.0, 0.5))
    with pytest.raises(ValueError, match=r"length is 0\.12; HeavyTop\.from_mass takes com in m"):
        rigid.HeavyTop(body, mgl=1.0, com=[0.0, 0.0, 0.12])
    with pytest.raises(ValueError, match=r"omega: expected the states of a motion, shape"):
        rigid.free.poinsot(body, [0.0, 0.1, 1.0])
    asked = {"omega": [0.1, 0.0, 1.0], "t_end": 5.0}
    assert rigid.plan(body, **asked) == rigid.plan(body, "attitude", **asked)  # type: ignore[arg-type]
    for ask in (
        lambda: rigid.Torque.body(lambda t: t),  # type: ignore[arg-type]
        lambda: rigid.FreeBody(body, torque=lambda t: t),  # type: ignore[arg-type]
    ):
        with pytest.raises(TypeError, match=r"take rigid\.Torque\.call, or make steps with rigid"):
            ask()
