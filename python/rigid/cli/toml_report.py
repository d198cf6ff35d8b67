"""Specifications of reports in TOML, the built-in ones and the user's own."""

from __future__ import annotations

from collections.abc import Sequence

from .._checks.arguments import finite_float, positive_int
from ..maps.grid import nominal_starts
from ..model.seed import checked_seed
from ..reports.spec import REVOLUTIONS, ReportSpec, make_spec
from .toml_keys import REPORT, REPORT_RUN, REPORT_START
from .toml_scene import read_scene, read_start
from .toml_table import BUILTIN, as_is, names_in, parsed, read_source, text

__all__ = ["REPORTS", "parse_report", "read_report", "report_names"]

REPORTS = BUILTIN / "reports"


def report_names() -> list[str]:
    """Names of the built-in reports, sorted."""
    return names_in(REPORTS)


def read_report(
    source: str,
    changes: Sequence[str] = (),
    *,
    methods: Sequence[str] | None = None,
    long: bool = False,
) -> tuple[str, ReportSpec]:
    """Name and specification of a built-in report, or of a file; see ``read_spec`` of a map.

    Examples
    --------
    >>> from rigid.cli.toml_report import read_report
    >>> read_report("lagrange-top")[1].scene.mgl
    1.0
    """
    name, content, file = read_source(source, "report", REPORTS)
    return name, parse_report(content, file, changes, methods=methods, long=long)


def parse_report(
    content: str,
    file: str,
    changes: Sequence[str] = (),
    *,
    methods: Sequence[str] | None = None,
    long: bool = False,
) -> ReportSpec:
    """The report that a TOML text describes; ``methods`` replaces the methods of the text.

    A ``long`` report counts revolutions, whether or not the text gives ``t_end``.
    """
    document = parsed(content, file, changes)
    document.only(*REPORT)
    scene = read_scene(document.table("scene"))
    nominal = document.table("start")
    nominal.only(*REPORT_START)
    start = read_start(nominal, [])
    run = document.table("run")
    run.only(*REPORT_RUN)
    revolutions = run.take("revolutions", as_is, default=REVOLUTIONS if long else None)
    t_end = None
    if revolutions is None or ("t_end" in run and not long):
        t_end = run.take("t_end", finite_float)
    grid = document.build(lambda: nominal_starts(scene, start))
    return run.build(
        lambda: make_spec(
            scene,
            grid.omega[0],
            grid.attitude[0],
            t_end=t_end,
            revolutions=revolutions,
            methods=run.take("methods", as_is, default=None) if methods is None else methods,
            bodies=run.take("bodies", positive_int, default=None),
            errors=run.take("errors", as_is, default=ReportSpec.errors),
            seed=run.take("seed", checked_seed, default=ReportSpec.seed),
            unit=run.take("unit", text, default=ReportSpec.unit),
            title=document.take("title", text, default=None),
        )
    )
