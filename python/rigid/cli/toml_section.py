"""Specifications of Poincaré sections in TOML, the built-in ones and the user's own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from .._checks.arguments import finite_float, positive_int
from ..model.events import COMPONENTS
from ..model.scene import HeavyTop
from ..model.seed import checked_seed, seed_from
from ..sections.crossings import LABELS
from ..sections.surface import HEIGHT, Section, section
from .toml_keys import PLOT, SECTION, SECTION_RUN, SECTION_START, SURFACE
from .toml_scene import read_scene
from .toml_table import BUILTIN, Table, as_is, names_in, parsed, positive, read_source, text, three

__all__ = ["SECTIONS", "SectionSpec", "read_section", "section_names"]

SECTIONS = BUILTIN / "sections"


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


def section_names() -> list[str]:
    """Names of the built-in sections, sorted."""
    return names_in(SECTIONS)


def read_section(source: str, changes: Sequence[str] = ()) -> SectionSpec:
    """Read a built-in section by its name, or a file by its path; see ``read_spec`` of a map.

    Examples
    --------
    >>> from rigid.cli.toml_section import read_section
    >>> read_section("kovalevskaya").scene.body.moments
    (2.0, 2.0, 1.0)
    """
    name, content, file = read_source(source, "section", SECTIONS)
    document = parsed(content, file, changes)
    document.only(*SECTION)
    scene = read_scene(document.table("scene"))
    if not isinstance(scene, HeavyTop):
        raise document.table("scene").error(
            f"kind = {scene.title.replace(' ', '-')!r}: must be 'heavy-top', "
            "whose starts have one energy and one L·gamma"
        )
    start, run = document.table("start"), document.table("run")
    start.only(*SECTION_START)
    run.only(*SECTION_RUN)
    plot = document.table("plot")
    plot.only(*PLOT)
    return SectionSpec(
        name=name,
        title=document.take("title", text, default=None),
        scene=scene,
        section=_surface(document.table("section")),
        energy=start.take("energy", finite_float),
        l_gamma=start.take("l_gamma", finite_float),
        bodies=start.take("bodies", positive_int),
        seed=seed_from(start.take("seed", checked_seed, default=None)),
        points=run.take("points", positive_int, default=None),
        t_end=run.take("t_end", positive),
        x=plot.choice("x", LABELS),
        y=plot.choice("y", LABELS),
    )


def _surface(table: Table) -> Section:
    table.only(*SURFACE)
    has_vectors = "omega" in table or "gamma" in table
    name = None if has_vectors else table.choice("name", (HEIGHT, *COMPONENTS))
    return table.build(
        lambda: section(
            table.take("name", text, default=None) if has_vectors else name,
            table.take("value", finite_float, default=0.0),
            table.take("direction", as_is, default=None),
            omega=table.take("omega", three, default=None),
            gamma=table.take("gamma", three, default=None),
        )
    )
