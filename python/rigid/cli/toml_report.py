"""Specifications of reports in TOML, the built-in ones and the user's own."""

from __future__ import annotations

from collections.abc import Sequence

from ..maps.grid import nominal_starts
from ..reports.spec import REVOLUTIONS, ReportSpec, make_spec
from .toml_scene import read_scene, read_start
from .toml_table import parsed, read_source


def read_report(
    source: str, changes: Sequence[str] = (), *, long: bool = False
) -> tuple[str, ReportSpec]:
    """Name and specification of a built-in report, or of a file; see ``read_spec`` of a map.

    Examples
    --------
    >>> from rigid.cli.toml_report import read_report
    >>> read_report("lagrange-top")[1].scene.mgl
    1.0
    """
    name, content, file = read_source(source, "report")
    return name, parse_report(content, file, changes, long=long)


def parse_report(
    content: str, file: str, changes: Sequence[str] = (), *, long: bool = False
) -> ReportSpec:
    """The report that a TOML text describes.

    A ``long`` report counts revolutions, whether or not the text gives ``t_end``.
    """
    document = parsed(content, file, changes)
    document.only("title", "scene", "start", "run")
    scene = read_scene(document.table("scene"))
    start = read_start(document.table("start"), (), noise=None, attitude_noise=None)
    grid = document.build(lambda: nominal_starts(scene, start))
    run = document.table("run")
    return run.call(
        make_spec,
        read={"t_end": lambda *_: None} if long else {},
        defaults={"revolutions": REVOLUTIONS} if long else {},
        needed=() if long or "revolutions" in run else ("t_end",),
        scene=scene,
        omega=grid.omega[0],
        attitude=grid.attitude[0],
        title=document.text("title"),
    )
