"""Specifications of Poincaré sections in TOML, the built-in ones and the user's own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from .._checks.arguments import finite_float, one_of, positive_int
from ..model.scene import HeavyTop
from ..model.seed import checked_seed, seed_from
from ..sections.crossings import LABELS
from ..sections.surface import Section, section
from .toml_scene import read_scene
from .toml_table import parsed, read_source


@dataclass(frozen=True, slots=True)
class SectionSpec:
    """A section with random starts of one energy and one ``L·gamma``.

    Attributes
    ----------
    name, title : str
    scene : HeavyTop
    section : Section
    energy, l_gamma : float
        Of all starts (J, kg m²/s).
    bodies, seed : int
    points : int or None
        Most points of a body.
    t_end : float
        Longest time (s).
    x, y : str
        Columns of the picture.
    """

    name: str
    title: str | None
    scene: HeavyTop
    section: Section
    energy: float
    l_gamma: float
    bodies: int
    seed: int
    points: int | None
    t_end: float
    x: str
    y: str


def read_section(source: str, changes: Sequence[str] = ()) -> SectionSpec:
    """Read a built-in section by its name, or a file by its path; see ``read_spec`` of a map.

    Examples
    --------
    >>> from rigid.cli.toml_section import read_section
    >>> read_section("kovalevskaya").scene.body.moments
    (2.0, 2.0, 1.0)
    """
    name, content, file = read_source(source, "section")
    document = parsed(content, file, changes)
    document.only("title", "scene", "section", "start", "run", "plot")
    scene = read_scene(document.table("scene"))
    if not isinstance(scene, HeavyTop):
        raise document.table("scene").error(
            f"kind = {scene.title.replace(' ', '-')!r}: must be 'heavy-top', "
            "whose starts have one energy and one L·gamma"
        )
    return SectionSpec(
        name=name,
        title=document.text("title"),
        scene=scene,
        section=document.table("section").call(section),
        **document.table("start").call(starts),
        **document.table("run").call(run),
        **document.table("plot").call(plot),
    )


def starts(energy: float, l_gamma: float, bodies: int, seed: int | None = None) -> dict[str, Any]:
    """The starts of a section.

    Parameters
    ----------
    energy : float
        Energy of all motions (J).
    l_gamma : float
        Vertical component of their angular momentum (kg m²/s).
    bodies : int
        Number of motions.
    seed : int, optional
        Key of the random starts, by default a new one.
    """
    return {
        "energy": finite_float("energy", energy),
        "l_gamma": finite_float("l_gamma", l_gamma),
        "bodies": positive_int("bodies", bodies),
        "seed": seed_from(None) if seed is None else checked_seed("seed", seed),
    }


def run(t_end: float, points: int | None = None) -> dict[str, Any]:
    """When the motions end.

    Parameters
    ----------
    t_end : float
        Longest time (s).
    points : int, optional
        Most points of a motion, by default without a limit.
    """
    return {
        "t_end": finite_float("t_end", t_end, positive=True),
        "points": None if points is None else positive_int("points", points),
    }


def plot(x: str, y: str) -> dict[str, Any]:
    """The picture.

    Parameters
    ----------
    x : str
        Component along the horizontal axis.
    y : str
        Component along the vertical axis.
    """
    return {"x": one_of("x", x, LABELS), "y": one_of("y", y, LABELS)}
