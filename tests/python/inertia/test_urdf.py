"""Links of robots from URDF: mass, centre and tensor in the axes of the link."""

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import rigid

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
    # Roll, pitch and yaw about fixed axes: SciPy writes extrinsic angles in small letters.
    turn = Rotation.from_euler("xyz", [0.3, -0.4, 0.5]).as_matrix()
    assert body.mass == 2.0
    found = axes @ np.diag(body.moments) @ axes.T
    assert np.allclose(found, turn @ TENSOR @ turn.T, rtol=0.0, atol=1e-14)


def test_about_the_joint_steiner_adds_the_mass_at_the_centre(tmp_path: Path) -> None:
    body, axes = body_of(tmp_path, robot(HAND), about=[0.0, 0.0, 0.0])
    turn = Rotation.from_euler("xyz", [0.3, -0.4, 0.5]).as_matrix()
    r = np.array([0.1, 0.2, 0.3])
    steiner = 2.0 * (r @ r * np.eye(3) - np.outer(r, r))
    found = axes @ np.diag(body.moments) @ axes.T
    assert np.allclose(found, turn @ TENSOR @ turn.T + steiner, rtol=0.0, atol=1e-14)


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
def test_what_is_refused(tmp_path: Path, old: str, new: str, words: str) -> None:
    text = robot(HAND)
    assert old in text
    with pytest.raises(ValueError, match=rf"path = .*arm\.urdf.*: .*{words}"):
        body_of(tmp_path, text.replace(old, new))


def test_an_encoding_hides_no_entity(tmp_path: Path) -> None:
    path = tmp_path / "arm.urdf"
    path.write_bytes(robot(HAND).replace("<robot", f"{BILLION}<robot").encode("utf-16"))
    with pytest.raises(ValueError, match="must have no document type and no entities"):
        rigid.Body.from_urdf(path)
