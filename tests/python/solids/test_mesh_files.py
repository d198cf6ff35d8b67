"""Bodies from files: closed meshes against closed forms, and links of robots."""

import struct
import sys
from pathlib import Path

import numpy as np
import pytest
import trimesh
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

import rigid
from exact_meshes import SQUARES, Mesh, ball, box, exact_properties, off, together
from physics import Floats
from rigid import meshes, rotations

ONE = box(1.0, 1.0, 1.0)
CUBE, TRIANGLES = ONE[0] + 0.5, ONE[1]
CORNER = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
CORNER_FACES = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])


def binary_stl(path: Path, corners: Floats, faces: NDArray[np.int64]) -> Path:
    """Each triangle with a normal, three corners in single precision and two bytes."""
    triangles = corners[faces].reshape(-1, 9)
    rows = b"".join(struct.pack("<12fH", 0, 0, 0, *row, 0) for row in triangles)
    path.write_bytes(b" " * 80 + struct.pack("<I", len(faces)) + rows)
    return path


def ascii_stl(path: Path, corners: Floats, faces: NDArray[np.int64]) -> Path:
    lines = ["solid part"]
    for face in corners[faces]:
        lines += ["facet normal 0 0 0", "outer loop"]
        lines += [f"vertex {x:.9e} {y:.9e} {z:.9e}" for x, y, z in face]
        lines += ["endloop", "endfacet"]
    path.write_text("\n".join([*lines, "endsolid part"]))
    return path


def obj(path: Path, corners: Floats, faces: NDArray[np.int64]) -> Path:
    lines = ["mtllib none.mtl", "o part", *(f"v {x} {y} {z}" for x, y, z in corners.tolist())]
    lines += ["f " + " ".join(str(k + 1) for k in face) for face in faces.tolist()]
    path.write_text("\n".join(lines))
    return path


WRITERS = {"a.stl": ascii_stl, "b.stl": binary_stl, "c.obj": obj}


@pytest.mark.parametrize("name", WRITERS)
def test_a_cube_of_a_file_is_the_cube(name: str, tmp_path: Path) -> None:
    path = WRITERS[name](tmp_path / name, 60.0 * CUBE, TRIANGLES)
    vertices, faces = meshes.read_mesh(path, unit=0.001)
    assert vertices.shape == (8, 3)
    assert faces.shape == (12, 3)
    load = rigid.Body.from_obj if name.endswith("obj") else rigid.Body.from_stl
    body, _ = load(path, mass=3.0, unit=0.001)
    # m a² / 6; 60 is a number of single precision.
    assert np.allclose(body.moments, 3.0 * 0.06**2 / 6.0, rtol=1e-14)
    assert body.mass == 3.0
    dense, _ = load(path, density=7800.0, unit=0.001)
    assert dense.mass is not None
    assert np.isclose(dense.mass, 7800.0 * 0.06**3, rtol=1e-14)
    about_corner, _ = load(path, mass=3.0, unit=0.001, about=(0.0, 0.0, 0.0))
    assert np.isclose(about_corner.moments[0], 3.0 * 0.06**2 / 6.0, rtol=1e-13)
    assert np.isclose(about_corner.moments[2], 11.0 / 12.0 * 3.0 * 0.06**2, rtol=1e-13)


def test_squares_of_an_obj_file_become_triangles(tmp_path: Path) -> None:
    path = obj(tmp_path / "squares.obj", CUBE, np.array(SQUARES))
    assert np.allclose(rigid.Body.from_obj(path)[0].moments, 1.0 / 6.0, rtol=1e-14)


def test_a_corner_of_a_cube(tmp_path: Path) -> None:
    # x, y, z >= 0, x + y + z <= 1: about the corner I = m/5 on the diagonal, products -m/20.
    path = binary_stl(tmp_path / "corner.stl", CORNER, CORNER_FACES)
    found = meshes.file_properties(path, mass=20.0)
    assert np.allclose(found.centre, 0.25, rtol=1e-15)
    about = found.about([0.0, 0.0, 0.0])
    assert np.allclose(about, 5.0 * np.eye(3) - np.ones((3, 3)), rtol=0, atol=1e-13)


def test_an_icosahedron_and_finer_and_finer_balls(tmp_path: Path) -> None:
    golden = (1.0 + np.sqrt(5.0)) / 2.0
    solid = trimesh.creation.icosahedron()
    edge = float(solid.edges_unique_length.mean())
    path = obj(tmp_path / "icosahedron.obj", solid.vertices, solid.faces)
    moments = rigid.Body.from_obj(path, mass=10.0)[0].moments
    assert np.allclose(moments, golden**2 * edge**2, rtol=1e-12)
    off = []
    for k in (2, 3, 4):
        ball = trimesh.creation.icosphere(subdivisions=k)
        path = binary_stl(tmp_path / f"{k}.stl", ball.vertices, ball.faces)
        off.append(1.0 - rigid.Body.from_stl(path, mass=2.5)[0].moments[0])
    # Inscribed, so smaller, with an error of order 2 in the edge.
    assert off[2] > 0.0
    assert np.allclose([off[0] / off[1], off[1] / off[2]], 4.0, rtol=0.05)


def test_corners_that_differ_by_rounding_are_one(tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    matrix = rigid.rotations.exp_so3([0.4, -0.3, 0.8])
    corners = 1000.0 * CUBE @ matrix.T + [300.0, -200.0, 50.0]
    triangles = corners[TRIANGLES].reshape(-1, 3)
    ulp = np.spacing(np.abs(triangles).max().astype(np.float32))
    jittered = triangles + ulp * rng.choice([-1.0, 0.0, 1.0], size=triangles.shape)
    path = binary_stl(tmp_path / "jitter.stl", jittered, np.arange(36).reshape(-1, 3))
    vertices, faces = meshes.read_mesh(path)
    assert (len(vertices), len(faces)) == (8, 12)
    body, _ = rigid.Body.from_stl(path, mass=6.0, unit="m")
    assert np.allclose(body.moments, 1e6, rtol=1e-6)  # ulp of 1300 in single precision: 1.2e-4


def test_two_parts_and_triangles_without_extent(tmp_path: Path) -> None:
    far = np.concatenate([CUBE, CUBE + np.array([5.0, 0.0, 0.0])])
    both = np.concatenate([TRIANGLES, 8 + TRIANGLES, [[0, 1, 1]]])
    path = binary_stl(tmp_path / "two.stl", far, both)
    found = meshes.file_properties(path, density=1.0, unit="m")
    assert np.isclose(found.mass, 2.0, rtol=1e-15)
    assert np.allclose(found.centre, [3.0, 0.5, 0.5], rtol=1e-15)


FLIPPED = np.concatenate([TRIANGLES[:1, ::-1], TRIANGLES[1:]])


@pytest.mark.parametrize(
    ("faces", "rule"),
    [
        (TRIANGLES[1:], r".*is open \(3 such edges\)"),
        (TRIANGLES[:, ::-1], ".* the mesh is inside out"),
        (FLIPPED, ".* not consistently oriented"),
    ],
)
def test_what_is_no_closed_mesh_is_refused(
    faces: NDArray[np.int64], rule: str, tmp_path: Path
) -> None:
    with pytest.raises(ValueError, match=rf"path = '.*a\.stl': {rule}"):
        rigid.Body.from_stl(binary_stl(tmp_path / "a.stl", CUBE, faces), mass=1.0)
    with pytest.raises(ValueError, match=rf"path = '.*a\.obj': {rule}"):
        rigid.Body.from_obj(obj(tmp_path / "a.obj", CUBE, faces), mass=1.0)


@pytest.mark.parametrize(
    "name", ["Körper".encode("latin-1"), "表".encode("shift_jis"), "表".encode(), b"x y"]
)
def test_names_in_a_file_may_be_in_any_encoding(name: bytes, tmp_path: Path) -> None:
    """The second byte of a sign of Shift-JIS may look like a backslash, which joins lines."""
    text = ascii_stl(tmp_path / "a.stl", CUBE, TRIANGLES).read_bytes()
    for mark in (b"", b"\xef\xbb\xbf"):
        (tmp_path / "a.stl").write_bytes(mark + text.replace(b"part", name))
        assert np.allclose(rigid.Body.from_stl(tmp_path / "a.stl")[0].moments, 1.0 / 6.0)
    text = obj(tmp_path / "a.obj", CUBE, TRIANGLES).read_bytes()
    (tmp_path / "a.obj").write_bytes(b"# " + name + b"\n" + text.replace(b"part", name))
    assert np.allclose(rigid.Body.from_obj(tmp_path / "a.obj")[0].moments, 1.0 / 6.0)
    cube = trimesh.Trimesh(CUBE, TRIANGLES)
    for encoding in ("ascii", "binary"):
        text = trimesh.exchange.ply.export_ply(cube, encoding=encoding)
        text = text.replace(b" 1.0\n", b" 1.0\ncomment " + name + b"\n", 1)
        (tmp_path / "a.ply").write_bytes(text)
        read = meshes.file_properties(tmp_path / "a.ply")
        assert np.allclose(read.tensor, np.eye(3) / 6.0)


@pytest.mark.parametrize(
    ("content", "rule"),
    [
        (b"v 0 0 0\nv 1 0 0\nv 0 1 0\n" + 60 * b" ", "does not begin with 'solid' is no STL"),
        ("solid part\nendsolid\n".encode("utf-16"), "16 bits .UTF-16.; save it as UTF-8"),
    ],
)
def test_another_file_is_not_called_cut(content: bytes, rule: str, tmp_path: Path) -> None:
    path = tmp_path / "part.stl"
    path.write_bytes(content)
    with pytest.raises(ValueError, match=rule):
        rigid.Body.from_stl(path)


def test_a_cut_file_is_called_cut(tmp_path: Path) -> None:
    whole = binary_stl(tmp_path / "cut.stl", CUBE, TRIANGLES).read_bytes()
    for content, rule in (
        (whole[:300], "the file is cut: it has 300 bytes, and its 12 triangles take 684"),
        (whole[:60], "the file is cut: it has 60 bytes"),
        (whole + b"0123456", "7 bytes follow its 12 triangles"),
        (ascii_stl(tmp_path / "a.stl", CUBE, TRIANGLES).read_bytes()[:700], "it has no 'endsolid'"),
    ):
        (tmp_path / "cut.stl").write_bytes(content)
        with pytest.raises(ValueError, match=rf"path = '.*cut\.stl': cannot be read as .*{rule}"):
            rigid.Body.from_stl(tmp_path / "cut.stl")


def test_a_file_in_mm_needs_its_unit(tmp_path: Path) -> None:
    path = binary_stl(tmp_path / "mm.stl", np.array([240.0, 100.0, 1.0]) * CUBE, TRIANGLES)
    with pytest.warns(UserWarning, match=r"the mesh is 240 m long, and its unit is not given; giv"):
        assert rigid.Body.from_stl(path, density=2700.0)[0].mass == 64.8e6
    with pytest.warns(UserWarning, match=r"the mesh is 240 m long, and its unit is not given; giv"):
        rigid.Body.from_stl(path, mass=0.0648)
    metal, _ = rigid.Body.from_stl(path, density=2700.0, unit="mm")
    assert metal.mass == pytest.approx(0.0648, rel=1e-14)
    vertices, faces = meshes.read_mesh(path)
    for made in (
        rigid.Body.from_stl(path, density=2700.0, unit=0.001)[0],
        rigid.Body.from_mesh(vertices, faces, density=2700.0, unit="mm")[0],
    ):
        assert made == metal
    # A mass that is that of a solid, and a length that is meant.
    rigid.Body.from_stl(path, mass=64.8e6)
    rigid.Body.from_stl(path, density=2700.0, unit="m")
    with pytest.raises(ValueError, match=r"unit = 'inch': must be one of 'm', 'cm', 'mm', 'in'"):
        rigid.Body.from_stl(path, mass=1.0, unit="inch")


def test_what_is_no_mesh_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for content in (b"", b"garbage", b"solid x\nfacet\nendsolid"):
        (tmp_path / "bad.stl").write_bytes(content)
        with pytest.raises(ValueError, match=r"path = '.*bad\.stl': (has no triangles|cannot be)"):
            rigid.Body.from_stl(tmp_path / "bad.stl")
    with pytest.raises(FileNotFoundError, match="none"):
        rigid.Body.from_stl(tmp_path / "none.stl")
    with pytest.raises(ValueError, match=r"path = 'part\.step': the suffix must be one of \.obj"):
        meshes.read_mesh("part.step")
    with pytest.raises(ValueError, match="kind = 'step': must be one of"):
        meshes.read_mesh("part.step", kind="step")
    with pytest.raises(ValueError, match=r"unit = 0\.0: must be positive"):
        meshes.read_mesh("part.stl", unit=0.0)
    infinite = obj(tmp_path / "inf.obj", np.where(CUBE > 0, np.inf, CUBE), TRIANGLES)
    with pytest.raises(ValueError, match=r"inf\.obj': a corner is not finite"):
        meshes.read_mesh(infinite)
    monkeypatch.setitem(sys.modules, "trimesh", None)
    with pytest.raises(ImportError, match=r"need trimesh: pip install 'rigid-rotation\[mesh\]'"):
        rigid.Body.from_stl(tmp_path / "bad.stl")


# Meshes that are hard on their sums, against rational numbers


EPSILON = float(np.finfo(np.float64).eps)

TURN = rotations.exp_so3([0.3, 0.2, 0.5])


def assert_exact(mesh: Mesh, slenderness: float) -> None:
    """Corners that are shifted to the centre of mass round by a share of the length.

    Relative to the width this is the slenderness larger; three coordinates of twelve or more
    triangles add up to 16 roundings at most, as they have either sign.
    """
    found = meshes.mesh_properties(*mesh)
    volume, centre, tensor = exact_properties(*mesh)
    allowed = 16.0 * EPSILON * slenderness
    assert off(found.mass.reshape(1, 1), [[volume]]) < allowed
    assert off(found.tensor, tensor) < allowed
    length = np.ptp(mesh[0], axis=0).max()
    assert max(abs(float(x) - y) for x, y in zip(found.centre, map(float, centre), strict=True)) < (
        allowed * length
    )


@pytest.mark.parametrize("slenderness", [1.0, 1e2, 1e4, 1e6, 1e8, 1e10])
def test_needles_lose_no_more_than_their_slenderness(slenderness: float) -> None:
    """Products of three far corners lost its square: of a needle of 1e9 the volume was 3 % off."""
    corners, faces = box(1.0, 1.3, slenderness)
    assert_exact((corners @ TURN.T, faces), slenderness)


@pytest.mark.parametrize("slenderness", [1e3, 1e6, 1e9])
def test_plates_lose_no_more_than_their_slenderness(slenderness: float) -> None:
    corners, faces = box(slenderness, 1.3 * slenderness, 1.0)
    assert_exact((corners @ TURN.T, faces), slenderness)


@pytest.mark.parametrize("apart", [10.0, 1e3, 1e5])
def test_parts_far_from_each_other_keep_their_digits(apart: float) -> None:
    corners, faces = ball(2)
    other = corners + apart * np.array([0.48, 0.6, 0.64])
    assert_exact(together((corners, faces), (other, faces)), apart)


def test_cavities_are_taken_away() -> None:
    corners, faces = ball(1)
    inside = 0.4 * corners + np.array([0.1, -0.2, 0.05])
    assert_exact(together(box(3.0, 2.0, 2.5), (inside, faces[:, ::-1])), 1.0)


@pytest.mark.filterwarnings("error")
def test_a_mesh_whose_mass_properties_overflow_is_refused() -> None:
    corners, faces = box(1e100, 1e100, 1e100)
    with pytest.raises(ValueError, match=r"vertices = .*a result would leave the range of doubles"):
        rigid.Body.from_mesh(corners, faces)
    assert np.isfinite(rigid.Body.from_mesh(corners, faces, mass=1.0)[0].moments).all()


# Links of robots from URDF: mass, centre and tensor in the axes of the link


#: Roll, pitch and yaw about fixed axes: SciPy writes extrinsic angles in small letters.
TURNED = Rotation.from_euler("xyz", [0.3, -0.4, 0.5]).as_matrix()
TENSOR = np.array([[1.0, 0.1, -0.2], [0.1, 2.0, 0.15], [-0.2, 0.15, 2.5]])
INERTIAL = """<inertial><origin xyz="0.1 0.2 0.3" rpy="0.3 -0.4 0.5"/><mass value="2"/>
<inertia ixx="1" ixy="0.1" ixz="-0.2" iyy="2" iyz="0.15" izz="2.5"/></inertial>"""


def robot(*links: str) -> str:
    return f'<?xml version="1.0"?><robot name="arm">{"".join(links)}</robot>'


HAND = f'<link name="hand">{INERTIAL}</link>'


def body_of(
    folder: Path, text: str, link: str | None = None, about: list[float] | None = None
) -> tuple[rigid.Body, np.ndarray]:
    (folder / "arm.urdf").write_text(text)
    return rigid.Body.from_urdf(folder / "arm.urdf", link=link, about=about)


def test_a_link_has_the_tensor_of_the_file_in_its_own_axes(tmp_path: Path) -> None:
    body, axes = body_of(tmp_path, robot('<link name="world"/>', HAND))
    assert body.mass == 2.0
    found = axes @ np.diag(body.moments) @ axes.T
    assert np.allclose(found, TURNED @ TENSOR @ TURNED.T, rtol=0.0, atol=1e-14)


def test_about_the_joint_steiner_adds_the_mass_at_the_centre(tmp_path: Path) -> None:
    body, axes = body_of(tmp_path, robot(HAND), about=[0.0, 0.0, 0.0])
    r = np.array([0.1, 0.2, 0.3])
    steiner = 2.0 * (r @ r * np.eye(3) - np.outer(r, r))
    found = axes @ np.diag(body.moments) @ axes.T
    assert np.allclose(found, TURNED @ TENSOR @ TURNED.T + steiner, rtol=0.0, atol=1e-14)


def test_without_an_origin_the_axes_are_those_of_the_link(tmp_path: Path) -> None:
    plain = HAND.replace('<origin xyz="0.1 0.2 0.3" rpy="0.3 -0.4 0.5"/>', "")
    body, axes = body_of(tmp_path, robot(plain))
    assert np.allclose(axes @ np.diag(body.moments) @ axes.T, TENSOR, rtol=0.0, atol=1e-14)


def test_one_link_of_several(tmp_path: Path) -> None:
    foot = HAND.replace("hand", "foot").replace('mass value="2"', 'mass value="3"')
    assert body_of(tmp_path, robot(HAND, foot), "foot")[0].mass == 3.0
    for link, words in [
        (None, "link = None: must name a link with a mass .known: 'hand', 'foot'"),
        ("arm", "link = 'arm': must name a link with a mass"),
        ("world", "link = 'world': has no mass"),
    ]:
        with pytest.raises(ValueError, match=words):
            body_of(tmp_path, robot(HAND, foot, '<link name="world"/>'), link)


BILLION = """<!DOCTYPE robot [<!ENTITY a "0"><!ENTITY b "&a;&a;">]>"""


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("<robot", f"{BILLION}<robot", "must have no document type and no entities"),
        ("arm", "&unknown;", "undefined entity"),
        ("</robot>", "", "no element found"),
        ("robot", "sdf", "is no URDF: its element is 'sdf', not 'robot'"),
        ('value="2"', "", "inertial: mass value is missing"),
        ('izz="2.5"', "", "inertial: inertia izz is missing"),
        ('value="2"', 'value="${m}"', r"mass value = ..\{m\}.: must be numbers; expand .* xacro"),
        ('value="2"', 'value="nan"', r"mass value\[0\] = nan: must be finite"),
        ('value="2"', 'value="-2"', "mass = -2"),
        ("0.1 0.2 0.3", "0.1 0.2", "origin xyz = '0.1 0.2': expected 3 numbers, got 2"),
        ('izz="2.5"', 'izz="9"', "tensor"),
    ],
)
def test_what_is_no_robot_is_refused(tmp_path: Path, old: str, new: str, words: str) -> None:
    text = robot(HAND)
    assert old in text
    with pytest.raises(ValueError, match=rf"path = .*arm\.urdf.*: .*{words}"):
        body_of(tmp_path, text.replace(old, new))


def test_an_encoding_hides_no_entity(tmp_path: Path) -> None:
    path = tmp_path / "arm.urdf"
    path.write_bytes(robot(HAND).replace("<robot", f"{BILLION}<robot").encode("utf-16"))
    with pytest.raises(ValueError, match="must have no document type and no entities"):
        rigid.Body.from_urdf(path)
