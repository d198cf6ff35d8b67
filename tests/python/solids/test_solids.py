"""Mass properties of solids, densities and meshes, each by a way that shares no code."""

from collections.abc import Callable
from math import pi
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import quad, tplquad
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

import rigid
from exact_meshes import Mesh, ball, box, exact_properties, off, together
from physics import ROUNDOFF, Floats
from refusals import refuses
from rigid import inertia, meshes, rotations, solids

RNG = np.random.default_rng(22)
NAN = float("nan")

#: Rounding of a short formula.
ROUNDED = 8 * ROUNDOFF

BALL = solids.ellipsoid_region(0.7, 0.7, 0.7)


# Solids


def test_the_box_of_the_worked_cases() -> None:
    box = solids.box(0.25, 0.08, 0.01, mass=0.3)
    assert 12e4 / 0.3 * box.tensor.diagonal() == pytest.approx([65.0, 626.0, 689.0], rel=ROUNDED)
    body = rigid.Body.box(0.25, 0.08, 0.01, mass=0.3)
    assert box.tensor.diagonal() == pytest.approx(body.moments, rel=ROUNDED)


def test_ring_rod_and_sphere_against_sums_and_integrals() -> None:
    """Lecture notes, § 5.4, with errata G-10 (which moment of the ring) and G-13 (limits)."""
    mass, radius, length = 2.0, 1.5, 0.8
    turn = 2.0 * pi * np.arange(1000) / 1000
    circle = radius * np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=-1)
    wire = inertia.inertia_tensor(np.full(1000, mass / 1000), circle)
    ring = solids.ring(radius, mass=mass)
    assert ring.tensor == pytest.approx(wire, rel=1e-12, abs=1e-12)
    assert ring.tensor.diagonal().tolist() == [2.25, 2.25, 4.5]

    def square(z: float) -> float:
        return mass / length * z * z

    rod = solids.rod(length, mass=mass).tensor.diagonal()
    half = 0.5 * length
    assert rod == pytest.approx([quad(square, -half, half)[0]] * 2 + [0.0], rel=1e-13)
    assert quad(square, half, half)[0] == 0.0  # as printed

    density = mass / (4.0 / 3.0 * pi * radius**3)
    moment = tplquad(
        lambda r, z, _: density * r**4 * (1.0 - z * z), 0.0, 2.0 * pi, -1.0, 1.0, 0.0, radius
    )[0]
    ball = solids.sphere(radius, mass=mass)
    assert ball.tensor == pytest.approx(moment * np.eye(3), rel=1e-12)
    assert moment == pytest.approx(0.4 * mass * radius**2, rel=1e-12)


def test_the_earth_as_a_homogeneous_ellipsoid() -> None:
    polar, equatorial = 6356.7523, 6378.1370
    earth = solids.ellipsoid(equatorial, equatorial, polar).tensor.diagonal()
    # m (a² + c²)/5 about an axis of the equator, 2 m a²/5 about the axis of the poles.
    flat = 0.5 * (polar - equatorial) * (polar + equatorial) / equatorial**2
    assert (earth[0] - earth[2]) / earth[2] == pytest.approx(flat, rel=1e-12)


def test_solids_against_quadrature_over_their_volume() -> None:
    """Cylinder, cone and pipe as regions; the hollow sphere as a difference of balls."""

    def cone(u: Floats) -> tuple[Floats, Floats]:
        height, angle = 3.0 * u[:, 0], 2.0 * pi * u[:, 1]
        edge = 2.0 * u[:, 0]
        points = [edge * u[:, 2] * np.cos(angle), edge * u[:, 2] * np.sin(angle), height]
        return np.stack(points, axis=-1), 3.0 * 2.0 * pi * edge**2 * u[:, 2]

    def pipe(u: Floats) -> tuple[Floats, Floats]:
        distance, angle = 1.0 + u[:, 0], 2.0 * pi * u[:, 1]
        points = [distance * np.cos(angle), distance * np.sin(angle), 3.0 * (u[:, 2] - 0.5)]
        return np.stack(points, axis=-1), 2.0 * pi * 3.0 * distance

    cases = [
        (6.0, solids.box(1.0, 2.0, 3.0), solids.box_region([-0.5, -1, -1.5], [0.5, 1, 1.5])),
        (8.0 * pi, solids.ellipsoid(1.0, 2.0, 3.0), solids.ellipsoid_region(1.0, 2.0, 3.0)),
        (12.0 * pi, solids.cylinder(2.0, 3.0), solids.cylinder_region(2.0, 3.0)),
        (9.0 * pi, solids.cylinder(2.0, 3.0, inner=1.0), solids.Region("pipe", pipe)),
        (4.0 * pi, solids.cone(2.0, 3.0), solids.Region("cone", cone)),
    ]
    for volume, formula, region in cases:
        found = solids.density_integral(1.0, region)
        assert found.converged
        assert found.properties.mass == pytest.approx(volume, rel=1e-12), region.name
        unit = found.properties.tensor / found.properties.mass
        assert formula.tensor == pytest.approx(unit, rel=1e-9, abs=1e-9), region.name
        assert formula.centre == pytest.approx(found.properties.centre, abs=1e-9), region.name
    outer, inner = (solids.sphere(r, mass=r**3) for r in (1.0, 0.6))
    hollow = solids.sphere(1.0, inner=0.6, mass=1.0 - 0.6**3)
    assert hollow.tensor == pytest.approx(outer.tensor - inner.tensor, rel=ROUNDED, abs=ROUNDED)


def test_limits_of_the_solids() -> None:
    mass, r, h = 3.0, 2.0, 1.5
    assert np.array_equal(solids.cylinder(r, 0.0).tensor, solids.disk(r).tensor)
    assert np.array_equal(solids.cylinder(0.0, h).tensor, solids.rod(h).tensor)
    assert np.array_equal(solids.disk(r, inner=r).tensor, solids.ring(r).tensor)
    assert solids.sphere(r, inner=r, mass=mass).tensor == pytest.approx(
        2.0 / 3.0 * mass * r * r * np.eye(3), rel=ROUNDED
    )
    # A thin shell keeps its digits, where R⁵ - r⁵ over R³ - r³ would not.
    thin = solids.sphere(1.0, inner=1.0 - 1e-12).tensor[0, 0]
    assert thin == pytest.approx(2.0 / 3.0 * (1.0 - 1e-12), rel=ROUNDED)
    plate = solids.box(r, h, 0.0, mass=mass).tensor.diagonal()
    assert plate[2] == pytest.approx(plate[0] + plate[1], rel=ROUNDED)
    flat = solids.ellipsoid(r, r, 0.0, mass=mass).tensor.diagonal()
    assert flat == pytest.approx(mass * r * r / 5.0 * np.array([1.0, 1.0, 2.0]), rel=ROUNDED)
    tip = solids.cone(r, h, mass=mass).about([0.0, 0.0, 0.0]).diagonal()
    side = 3.0 / 20.0 * mass * (r * r + 4.0 * h * h)
    assert tip == pytest.approx([side, side, 0.3 * mass * r * r], rel=ROUNDED)


def test_solids_of_many_sizes_at_once() -> None:
    radii = np.linspace(0.5, 2.0, 4)
    many = solids.cylinder(radii[:, None], [1.0, 2.0, 3.0], inner=0.5, mass=2.0)
    assert many.tensor.shape == (4, 3, 3, 3)
    one = solids.cylinder(radii[2], 3.0, inner=0.5, mass=2.0)
    assert np.array_equal(many.tensor[2, 2], one.tensor)
    assert solids.cone(radii, 2.0).centre.shape == (4, 3)
    assert solids.sphere(np.empty(0)).tensor.shape == (0, 3, 3)


def test_bodies_of_solids_keep_the_order_of_their_axes() -> None:
    bodies = {
        "ellipsoid": (rigid.Body.ellipsoid(3.0, 1.0, 2.0, mass=0.5), (0.5, 1.3, 1.0)),
        "sphere": (rigid.Body.sphere(2.0, mass=5.0), (8.0, 8.0, 8.0)),
        "cylinder": (rigid.Body.cylinder(2.0, 3.0, mass=4.0), (7.0, 7.0, 8.0)),
        "disk": (rigid.Body.cylinder(2.0, 0.0, mass=4.0), (4.0, 4.0, 8.0)),
        "ring": (rigid.Body.cylinder(2.0, 0.0, inner=2.0, mass=1.0), (2.0, 2.0, 4.0)),
        "cone": (rigid.Body.cone(2.0, 4.0, mass=10.0), (12.0, 12.0, 12.0)),
    }
    for name, (body, moments) in bodies.items():
        assert body.moments == pytest.approx(moments, rel=ROUNDED), name
    assert bodies["ring"][0].mass == 1.0
    assert bodies["cylinder"][0].symmetry_axis == 3


def test_a_cone_on_its_tip_is_a_top() -> None:
    cone = solids.cone(0.03, 0.06, mass=0.1).placed([1.0, 2.0, 3.0], rotations.rotation_x(0.4))
    body, axes = rigid.Body.from_properties(cone, about=[1.0, 2.0, 3.0])
    assert body.moments == pytest.approx(
        (0.3 * 0.1 * 0.03**2, *[0.15 * 0.1 * (0.03**2 + 4 * 0.06**2)] * 2), rel=1e-12
    )
    assert np.abs(axes[:, 0] @ rotations.rotation_x(0.4)[:, 2]) == pytest.approx(1.0, abs=1e-12)


# Densities


def test_a_varying_density_against_its_integrals_by_hand() -> None:
    """A box whose density rises along axis 1, and a ball that is denser inside."""
    box = solids.density_integral(lambda x: 1.0 + x[:, 0], solids.box_region([0, 0, 0], [1, 1, 1]))
    # Mass 3/2; centre (1/2 + 1/3)/(3/2) = 5/9; variance (1/3 + 1/4)/(3/2) - (5/9)² = 13/162.
    along, across = 1.5 * 13.0 / 162.0, 1.5 / 12.0
    assert box.properties.mass == pytest.approx(1.5, rel=1e-13)
    assert box.properties.centre == pytest.approx([5.0 / 9.0, 0.5, 0.5], rel=1e-13)
    assert box.properties.tensor.diagonal() == pytest.approx(
        [2.0 * across, along + across, along + across], rel=1e-13
    )

    def gauss(points: Floats) -> Floats:
        return np.asarray(np.exp(-np.vecdot(points, points)))

    ball = solids.density_integral(gauss, BALL)
    mass = 4.0 * pi * quad(lambda r: r**2 * np.exp(-r * r), 0.0, 0.7)[0]
    moment = 8.0 / 3.0 * pi * quad(lambda r: r**4 * np.exp(-r * r), 0.0, 0.7)[0]
    assert ball.properties.mass == pytest.approx(mass, rel=1e-9)
    assert ball.properties.tensor == pytest.approx(moment * np.eye(3), rel=1e-9, abs=1e-9 * moment)


def test_halves_add_to_the_whole() -> None:
    def density(x: Floats) -> Floats:
        return 2.0 + np.sin(3.0 * x[:, 0]) * x[:, 1]

    whole = solids.density_integral(density, solids.box_region([-1, -1, -1], [1, 1, 1]))
    halves = [
        solids.density_integral(density, solids.box_region(low, high)).properties
        for low, high in (([-1, -1, -1], [0.3, 1, 1]), ([0.3, -1, -1], [1, 1, 1]))
    ]
    together = inertia.compose(halves)
    assert together.mass == pytest.approx(whole.properties.mass, rel=1e-12)
    assert together.centre == pytest.approx(whole.properties.centre, abs=1e-12)
    assert together.tensor == pytest.approx(whole.properties.tensor, abs=1e-10)


@pytest.mark.parametrize(("half", "most"), [(0.3, 0.2), (0.1, 0.35)])
def test_a_slab_between_the_first_points_is_found(half: float, most: float) -> None:
    """Of four points along x the nearest are at 0.34, of six at 0.24, of eight at 0.18."""
    region = solids.box_region([-1.0, -0.5, -0.25], [1.0, 0.5, 0.25])
    slab = solids.density_integral(lambda x: 1.0 * (np.abs(x[:, 0]) < half), region)
    assert abs(slab.properties.mass / half - 1.0) < slab.error < most
    assert not slab.converged


def test_the_report_of_an_integral_is_honest() -> None:
    smooth = solids.density_integral(1.0, BALL, tolerance=1e-12)
    assert smooth.converged
    assert smooth.error <= 1e-12
    assert len(smooth.changes) == len(smooth.points) - 1
    jump = solids.density_integral(
        lambda x: (x[:, 0] > 0.123) * 1.0, solids.box_region([-1, -1, -1], [1, 1, 1])
    )
    assert not jump.converged
    error = abs(jump.properties.mass / (4.0 * (1.0 - 0.123)) - 1.0)
    assert 0.05 * error < jump.error < 1.0


def test_two_points_of_one_density_and_distance_have_no_spread() -> None:
    """The deviation of a mean has n - 1 degrees of freedom: two points are the fewest."""
    two = solids.sampled_density([1.0, 1.0], [[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]], volume=2.0)
    assert two.error == 0.0
    assert two.converged


def test_sampled_densities_err_by_their_standard_error() -> None:
    ratios = []
    for _ in range(100):
        points = RNG.uniform(-1.0, 1.0, (4000, 3))
        inside = (np.linalg.norm(points, axis=1) < 0.9) * 2.0
        found = solids.sampled_density(inside, points, volume=8.0)
        mass = 8.0 / 3.0 * pi * 0.9**3
        tensor = 0.4 * mass * 0.9**2 * np.eye(3)
        error = max(
            abs(found.properties.mass / mass - 1.0),
            np.abs(found.properties.tensor - tensor).max() / tensor.max(),
        )
        ratios.append(error / found.error)
    # The largest of seven errors of about one standard error.
    assert 0.5 < np.median(ratios) < 1.7
    assert np.max(ratios) < 6.0


# Meshes

ONE = box(1.0, 1.0, 1.0)
CORNERS, BOX_FACES = ONE[0] + 0.5, ONE[1]
SIDES = np.array([0.25, 0.08, 0.01])


def hull(points: Floats) -> Mesh:
    """The convex hull as a mesh seen from outside."""
    found = ConvexHull(points)
    faces = found.simplices.copy()
    a, b, c = (points[faces[:, k]] for k in range(3))
    inwards = np.vecdot(np.cross(b - a, c - a), a - points.mean(axis=0)) < 0.0
    faces[inwards] = faces[inwards][:, ::-1]
    return points, faces


def test_a_box_of_twelve_triangles_is_the_box() -> None:
    turn = Rotation.random(rng=RNG).as_matrix()
    formula = solids.box(*SIDES, mass=SIDES.prod())
    for matrix in (np.eye(3), turn):
        found = meshes.mesh_properties(CORNERS * SIDES @ matrix.T, BOX_FACES)
        truth = formula.placed(matrix @ SIDES / 2.0, matrix)
        assert found.mass == pytest.approx(float(truth.mass), rel=1e-14)
        assert found.centre == pytest.approx(truth.centre, rel=1e-14, abs=1e-16)
        assert np.abs(found.tensor - truth.tensor).max() < 1e-14 * truth.tensor.max()


def test_far_from_the_origin_nothing_cancels() -> None:
    """A cube whose corners are whole numbers is known exactly, wherever it is."""
    for offset in (1e3, 1e8, 1e14):
        shift = offset * np.array([1.0, -3.0, 7.0])
        stray = np.concatenate([CORNERS + shift, [[0.0, 0.0, 0.0]]])  # a corner of no face
        found = meshes.mesh_properties(stray, BOX_FACES)
        assert found.mass == pytest.approx(1.0, rel=1e-14)
        assert found.centre == pytest.approx(shift + 0.5, rel=4 * ROUNDOFF)
        assert np.abs(found.tensor - np.eye(3) / 6.0).max() < 1e-15
    # Tetrahedra from the origin, the textbook sum, lose it all.
    a, b, c = ((CORNERS + 1e8)[BOX_FACES[:, k]] for k in range(3))
    assert abs(np.vecdot(a, np.cross(b, c)).sum() / 6.0 - 1.0) > 0.5


@pytest.mark.parametrize("scale", [1e-90, 1e-3, 1e60])
def test_tiny_and_huge_meshes(scale: float) -> None:
    found = meshes.mesh_properties(CORNERS * scale, BOX_FACES, mass=6.0, unit="m")
    assert found.tensor / scale**2 == pytest.approx(np.eye(3), rel=1e-14, abs=1e-14)


def test_any_polyhedron_against_rational_numbers() -> None:
    for n in (4, 5, 20, 200):
        points, faces = hull(RNG.normal(size=(n, 3)) * [1.0, 2.0, 0.3] + 5.0)
        found = meshes.mesh_properties(points, faces, density=2.0, unit="m")
        volume, centre, tensor = exact_properties(points, faces)
        assert found.mass == pytest.approx(2.0 * float(volume), rel=1e-13)
        assert found.centre == pytest.approx(list(map(float, centre)), rel=1e-13)
        assert off(0.5 * found.tensor, tensor) < 1e-12


def test_many_bodies_with_the_same_faces() -> None:
    sides = RNG.uniform(0.5, 2.0, (5, 3))
    found = meshes.mesh_properties(CORNERS * sides[:, None], BOX_FACES, mass=1.0)
    formula = solids.box(*sides.T)
    assert found.tensor == pytest.approx(formula.tensor, rel=1e-13, abs=1e-14)
    none = meshes.mesh_properties(np.empty((0, 8, 3)), BOX_FACES)
    assert none.tensor.shape == (0, 3, 3)


def mesh(faces: NDArray[Any], corners: Floats = CORNERS) -> Callable[[], object]:
    return lambda: meshes.mesh_properties(corners, faces)


TWO = np.concatenate([1.1 * CORNERS, CORNERS + np.array([3.0, 0.0, 0.0])])
FLIPPED = np.concatenate([BOX_FACES[:1, ::-1], BOX_FACES[1:]])
FIN = np.concatenate([BOX_FACES, [[0, 1, 8], [8, 1, 0]]])
NEEDLE = np.array([[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]])
LINE = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 1.0]])
DOUBLE = np.array([[0, 1, 2], [2, 1, 0]])


test_refused = refuses(
    [
        (mesh(BOX_FACES[1:]), r"no triangle on its other side; the mesh is open \(3 such edges"),
        (mesh(BOX_FACES[:, ::-1]), "the volume inside is -1; the mesh is inside out"),
        (mesh(np.concatenate([BOX_FACES, 8 + BOX_FACES[:, ::-1]]), TWO), "out and is no cavity"),
        (mesh(FLIPPED), "in the same direction; the faces are not consistently oriented"),
        (mesh(FIN, np.concatenate([CORNERS, [[0, 0, 3]]])), "an edge of more than two triangles"),
        (mesh(NEEDLE, LINE), r"faces\[0\] = \[0, 1, 2\]: a triangle without area"),
        (mesh(np.array([[0, 1, 1]])), r"faces\[0\] = \[0, 1, 1\]: a triangle with a corner twice"),
        (mesh(DOUBLE), "inside out .* or encloses nothing"),
        (mesh(np.array([[0, 1, 8]])), r"faces\[0, 2\] = 8: there is no such corner among 8"),
        (mesh(BOX_FACES * 1.0), "faces: expected whole numbers"),
        (mesh(BOX_FACES, CORNERS * NAN), r"vertices\[0, 0\] = nan: must be finite"),
        (mesh(BOX_FACES, CORNERS[0]), "vertices: expected shape"),
        (
            lambda: meshes.mesh_properties(CORNERS, BOX_FACES, density=1.0, mass=1.0),
            "density and mass: give one of them",
        ),
        (lambda: meshes.mesh_properties(CORNERS, BOX_FACES, density=0), "density = 0.0: must be"),
        (lambda: meshes.mesh_properties(CORNERS, BOX_FACES, mass=-1), "mass = -1.0: must be pos"),
        (lambda: solids.box(1, -2, 3), "b = -2.0: must not be negative"),
        (lambda: solids.sphere(1, mass=0), "mass = 0.0: must be positive"),
        (lambda: solids.disk([1, 2], inner=[0.5, 3]), r"inner\[1\] = 3.0: must not exceed the rad"),
        (lambda: solids.cone(NAN, 1), "radius.* = nan: must be finite"),
        (lambda: solids.box_region([0, 0, 0], [1, 0, 1]), "the region is empty"),
        (lambda: solids.ellipsoid_region(1, 0, 1), "b = 0.0: must be positive"),
        (lambda: solids.cylinder_region(1, -1), "height = -1.0: must be positive"),
        (lambda: solids.density_integral(-1.0, BALL), r"density\[0\] = -1.0: must not be negative"),
        (lambda: solids.density_integral(0.0, BALL), "their sum is 0; a body needs mass"),
        (lambda: solids.density_integral(lambda x: x * x, BALL), "density: expected shape"),
        (lambda: solids.sampled_density([1.0], [[0, 0, 0]], 1.0), "at least two"),
        (lambda: rigid.Body.sphere(0), "radius = 0.0: must be positive"),
        (lambda: rigid.Body.cylinder(1, 1, mass=-1), "mass = -1.0: must be positive"),
    ]
)


# Meshes of several surfaces: what two of them contain would count twice


def at(mesh: Mesh, *place: float) -> Mesh:
    return mesh[0] + place, mesh[1]


def hollow(mesh: Mesh) -> Mesh:
    return mesh[0], mesh[1][:, ::-1]


ROUND = ball(3)

OVERLAPS = {
    "side by side, on common planes": together(ONE, at(ONE, 0.64, 0, 0)),
    "in a corner": together(ONE, at(ONE, 0.7, 0.8, 0.6)),
    "crossed bars, no corner in the other": together(box(10, 1, 1), box(1, 10, 1)),
    "one in the other": together(ONE, box(0.3, 0.3, 0.3)),
    "twice the same": together(ONE, ONE),
    "balls": together(ROUND, at(ROUND, 1.8, 0.0, 0.0)),
    "a cavity outside the body": together(ROUND, hollow(at(box(0.2, 0.2, 0.2), 0.8, 0.8, 0.8))),
    "a core as large as its cavity and more": together(
        ONE, hollow(box(0.4, 0.4, 0.4)), box(0.41, 0.41, 0.41)
    ),
}

LEGAL = {
    "apart": (together(ROUND, at(ROUND, 1.3, 1.3, 1.3)), 2),
    "touching": (together(ONE, at(ONE, 1.0, 0.1, 0.2)), 2),
    "pressed together by rounding": (together(ONE, at(ONE, 1 - 1e-6, 0.1, 0.2)), 2),
    "a cavity": (together(ONE, hollow(box(0.3, 0.3, 0.3))), 1 - 0.3**3),
    "a core in a cavity": (
        together(ONE, hollow(box(0.3, 0.3, 0.3)), box(0.3, 0.1, 0.1)),
        1 - 0.3**3 + 0.3 * 0.1**2,
    ),
}


@pytest.mark.parametrize("name", OVERLAPS)
def test_overlapping_surfaces_are_refused(name: str) -> None:
    with pytest.raises(ValueError, match=r"faces\[\d+\] = .*overlaps another, and what both"):
        meshes.mesh_properties(*OVERLAPS[name])


@pytest.mark.parametrize("name", LEGAL)
def test_parts_and_cavities_are_legal(name: str) -> None:
    mesh, cubes = LEGAL[name]
    unit = float(meshes.mesh_properties(*(ROUND if name == "apart" else ONE)).mass)
    assert float(meshes.mesh_properties(*mesh).mass) == pytest.approx(cubes * unit, rel=1e-14)


def test_the_overlap_of_one_of_many_bodies() -> None:
    corners, faces = together(ONE, at(ONE, 2, 0, 0))
    many = np.stack([corners, corners, corners])
    many[1, 8:, 0] -= 1.5
    assert meshes.mesh_properties(many[::2], faces).mass.tolist() == [2.0, 2.0]
    with pytest.raises(ValueError, match="overlaps another"):
        meshes.mesh_properties(many, faces)
