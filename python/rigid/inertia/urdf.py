"""Mass properties of a link of a robot, from a file in URDF."""

from __future__ import annotations

import os
from pathlib import Path
from xml.etree.ElementTree import Element, TreeBuilder
from xml.parsers import expat

import numpy as np

from .._checks.arguments import brief, one_line, shaped
from .._checks.arrays import Floats
from ..rotations import rotation_x, rotation_y, rotation_z
from ..solids.mass_properties import MassProperties

_INERTIA = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")


def link_properties(path: str | os.PathLike[str], link: str | None) -> MassProperties:
    """Mass, centre and tensor of inertia of a link; see :meth:`rigid.Body.from_urdf`."""
    content = Path(path).read_bytes()
    try:
        inertial = _inertial(_root(content), link)
        origin = inertial.find("origin")
        place = _numbers("0 0 0" if origin is None else origin.get("xyz", "0 0 0"), "origin xyz")
        angles = _numbers("0 0 0" if origin is None else origin.get("rpy", "0 0 0"), "origin rpy")
        (mass,) = _numbers(_attribute(inertial, "mass", "value"), "mass value", 1)
        xx, xy, xz, yy, yz, zz = (
            _numbers(_attribute(inertial, "inertia", name), f"inertia {name}", 1)[0]
            for name in _INERTIA
        )
        tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        # Roll, pitch and yaw are turns about the fixed axes x, y and z of the link, in this order.
        roll, pitch, yaw = angles
        turn = rotation_z(yaw) @ rotation_y(pitch) @ rotation_x(roll)
        return MassProperties(mass=mass, centre=place, tensor=turn @ tensor @ turn.T)
    except (ValueError, expat.ExpatError) as error:
        raise ValueError(f"path = {os.fspath(path)!r}: {one_line(error)}") from None


def _root(content: bytes) -> Element:
    """The element ``robot`` of a file.

    A document type is refused: its entities could name other files, or grow without end.
    """
    builder, parser = TreeBuilder(), expat.ParserCreate()
    parser.StartElementHandler = builder.start
    parser.EndElementHandler = builder.end

    def refuse(*_: object) -> None:
        raise ValueError("must have no document type and no entities")

    parser.StartDoctypeDeclHandler = refuse
    parser.Parse(content, True)
    root = builder.close()
    if root.tag != "robot":
        raise ValueError(f"is no URDF: its element is {brief(root.tag)}, not 'robot'")
    return root


def _inertial(root: Element, link: str | None) -> Element:
    """The element ``inertial`` of a link, of the only one that has it by default."""
    known = {one.get("name", ""): one.find("inertial") for one in root.iter("link")}
    heavy = {name: inertial for name, inertial in known.items() if inertial is not None}
    if link is None and len(heavy) == 1:
        return next(iter(heavy.values()))
    if link is None or link not in heavy:
        why = "has no mass" if link in known else "must name a link with a mass"
        names = ", ".join(map(repr, heavy)) or "none"
        raise ValueError(f"link = {brief(link)}: {why} (known: {names})")
    return heavy[link]


def _attribute(inertial: Element, child: str, name: str) -> str:
    found = inertial.find(child)
    value = None if found is None else found.get(name)
    if value is None:
        raise ValueError(f"inertial: {child} {name} is missing")
    return value


def _numbers(text: str, name: str, count: int = 3) -> Floats:
    """So many finite numbers of a text."""
    try:
        values = [float(part) for part in text.split()]
    except ValueError:
        hint = "; expand the file with xacro" if "${" in text else ""
        raise ValueError(f"{name} = {brief(text)}: must be numbers{hint}") from None
    if len(values) != count:
        raise ValueError(f"{name} = {brief(text)}: expected {count} numbers, got {len(values)}")
    return shaped(name, values, count)
