"""The command line ``rigid``: maps, sections and reports, lists of those built in, the build.

``parser`` has the arguments and help, ``output`` prints and writes, ``running_maps`` has the
commands on stores. ``toml_table`` reads tables of files as the arguments of functions,
``toml_scene`` reads scene, start and criterion, ``toml_map``, ``toml_section`` and
``toml_report`` the three kinds of files. Uses ``maps``, ``sections``, ``reports`` and
``literature``; nothing uses it.
"""

from __future__ import annotations

import argparse
import dataclasses
import sys
import warnings
from collections.abc import Callable, Mapping, Sequence
from io import TextIOWrapper
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .._checks.arguments import positive_int, resolve_threads
from .._checks.inputs import require_readable
from .._checks.progress import heeding_signals
from .._checks.shown import counted, labelled, wrapped
from .._files import published, require_ending, require_room
from ..drawing.figure import new_figure
from ..info import build_info
from ..maps.data import CLASSES, FAILURES
from ..maps.file import file_size
from ..maps.plan import map_plan
from ..maps.plot import SHARE, check_what
from ..maps.sequential import checked_half_width, stop_table
from ..maps.spec import MapSpec
from ..model.seed import seed_from
from ..reports.compute import run_report
from ..reports.stress import extremes
from ..sections.crossings import Crossings
from ..sections.poincare import poincare
from ..sections.starts import on_surface
from ..solve.plan import Plan, memory_words
from ..store.call import run_map
from ..store.result import StabilityMap, load_map
from .output import (
    DONE,
    REFUSED,
    SAYS_NO,
    WRITE_ERROR,
    Target,
    complain,
    finished,
    print_list,
    require_new,
    say,
    target_of,
    tell,
)
from .parser import help_on, make_parser
from .running_maps import computed, require_shared, run
from .toml_map import NamedSpec, read_spec
from .toml_report import read_report
from .toml_section import SectionSpec, read_section
from .toml_table import names_of, read_source
from .tutorials import notebooks

if TYPE_CHECKING:
    from matplotlib.axes import Axes

POINT_SIZE = 140
"""Approximate bytes of a point of a section in a file."""

REPORT_SIZE = 2**20
"""More bytes than the file of a report has."""

_READERS: Mapping[str, Callable[[str], Any]] = {
    "map": lambda source: read_spec(source).spec,
    "section": read_section,
    "report": lambda source: read_report(source)[1],
}
_WORDS: Mapping[str, Callable[[Any], str]] = {
    "map": lambda spec: " x ".join(axis.name for axis in spec.axes),
    "section": lambda spec: f"energy {spec.energy:g} J, L·gamma {spec.l_gamma:g}",
    "report": lambda spec: f"t = {spec.t_end:g} {spec.unit}",
}
_COPIED = {"map": "thrown-box", "section": "kovalevskaya", "report": "lagrange-top"}
"""Of each kind who reads a specification, what lists say of it, and which ``rigid new`` copies."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; returns the exit code, one of :data:`.output.EXIT_CODES`.

    Parameters
    ----------
    arguments : sequence of str, optional
        By default the arguments of the process.
    """
    if isinstance(sys.stdout, TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")  # as stderr: a terminal may be ASCII
    with heeding_signals() as interrupted, warnings.catch_warnings():
        # Without the place in the code of rigid.
        warnings.showwarning = lambda message, *_, **__: complain(f"warning: {message}")
        try:
            parser = make_parser()
            options = parser.parse_args(arguments)
            if options.command in (None, "help"):
                say(help_on(parser, getattr(options, "topic", None)))
                return DONE
            if getattr(options, "show", False):
                return _show(options)
            command = {
                "map": _map,
                "explore": _explore,
                "resume": _resume,
                **dict.fromkeys(("status", "merge", "diff", "verify", "pack"), run),
                **dict.fromkeys(("maps", "sections", "reports"), _list),
                "new": _new,
                "section": _section,
                "report": _report,
                "extremes": _extremes,
                "validation": _validation,
                "tutorials": _tutorials,
                "info": _info,
            }[options.command]
            return command(options)
        except OSError as error:
            complain(str(error))
            return WRITE_ERROR
        except (ImportError, RuntimeError, ValueError) as error:
            complain(str(error))
            return REFUSED
        except KeyboardInterrupt as stop:
            complain(str(stop) or "interrupted")
            return interrupted()


def _map(options: argparse.Namespace) -> int:
    named = _named_map(options.map, options.changes)
    spec = named.spec
    names = ("samples", "half_width", "refine", "budget", "seed")
    chosen = {name: getattr(options, name) for name in names}
    changes = {name: value for name, value in chosen.items() if value is not None}
    if {"samples", "half_width"} <= changes.keys():
        raise ValueError("--samples, --half-width: give one of the two")
    if "samples" in changes:
        changes["half_width"] = None
    if "half_width" in changes and changes["half_width"] is not None:
        changes["samples"] = stop_table(checked_half_width(options.half_width)).last
    spec = dataclasses.replace(spec, **changes)
    check_what(spec, options.what)
    seeded = named.seeded or options.seed is not None
    require_shared(options, seeded=seeded)
    target = target_of(options.out, named.name, ".npz", force=options.force)
    threads = resolve_threads(options.threads)
    require_room(target.data, file_size(spec))
    if options.check:
        return _checked(spec, named.name, target, threads, options, seeded)
    if not options.json:
        tell(_planned(map_plan(spec)))
    if options.store is not None:
        into = {"spec": spec, "store": options.store, "seeded": seeded}
        return _finished_map(computed(options, run_map, **into), target, named.name, options)
    result = run_map(spec, threads=threads, progress=options.progress, partial=True)
    return _finished_map(result, target, named.name, options)


def _checked(
    spec: MapSpec,
    name: str,
    target: Target,
    threads: int,
    options: argparse.Namespace,
    seeded: bool,
) -> int:
    """Tell the plan of a map, its cost by some bodies, and the files that it would write."""
    from ..store.status import foresee

    call = foresee(spec, store=options.store, seeded=seeded, threads=threads, part=options.part)
    sizes = {"data": file_size(spec)}
    files = {"data": str(target.data), "picture": str(target.picture), "store": options.store}
    if options.store is not None:
        sizes["store"] = call.stored
    if options.json:
        facts = {"name": name, **dataclasses.asdict(call)}
        print_list({**facts, "bytes": sizes, **files}, as_json=True)
        return DONE
    most, share = "at most " if call.at_most else "", ""
    if options.part is not None:
        share = f", part {options.part}"
    free = counted(threads, "free thread")
    lines = {
        "map": spec.title or name,
        **_planned(call.plan),
        "bodies": f"{most}{call.bodies:,} in {call.pixels:,} pixels{share}",
        "cost": f"{most or 'about '}{call.seconds:.2g} s on {free}",
        "size": ", ".join(f"{where} {memory_words(size)}" for where, size in sizes.items()),
        "would write": ", ".join(map(str, filter(None, files.values()))),
    }
    tell(lines)
    return DONE


def _finished_map(
    result: StabilityMap | int, target: Target, name: str, options: argparse.Namespace
) -> int:
    """Write a map and return the exit code; a map without a result has its own exit code."""
    if isinstance(result, int):
        return result
    what = getattr(options, "what", SHARE)
    return finished(
        result.save,
        lambda: result.plot(what=what),
        target,
        "map",
        words=lambda: f"{result.summary()}\n{labelled([('speed', _speed(result))])}",
        facts=(lambda: _map_facts(name, result)) if options.json else None,
        ended=result.ended,
    )


def _explore(options: argparse.Namespace) -> int:
    source = Path(options.map)
    target = Path(options.out or source.with_suffix(".html"))
    if not source.exists() and options.map in names_of("map"):
        saved = source.with_name(f"{source.name}.npz")
        hint = f"did you mean {saved}?" if saved.exists() else f"compute it: rigid map {source}"
        raise ValueError(f"{source}: is a built-in map and no file; {hint}")
    require_readable(source)
    result = load_map(source)
    require_new(target, "--out", force=options.force)
    page = result.explore(target, samples=options.samples, threads=options.threads, saved_as=source)
    tell({"page": str(page)})
    return DONE


def _resume(options: argparse.Namespace) -> int:
    from ..store.store import open_store

    stem = Path(options.store.rstrip("/")).with_suffix("")
    target = target_of(options.out, str(stem), ".npz", force=options.force)
    require_readable(options.store)
    result = computed(options, open_store(options.store).resume)
    return _finished_map(result, target, stem.name, options)


def _map_facts(name: str, result: StabilityMap) -> dict[str, Any]:
    """The numbers of a map that ``--json`` prints."""
    theory = result.theory()
    return {
        "name": name,
        "complete": result.complete,
        "plan": result.plan.to_dict(),
        **{key: int(result.columns[key].sum()) for key in (*CLASSES, *FAILURES)},
        "theory": None
        if theory is None
        else {"label": theory.label, "disagreeing": int(result.disagreement(theory).sum())},
        "measures": {
            name: dict(zip(("bodies", "mean", "least", "largest"), one.totals(), strict=True))
            for name, one in result.measures.items()
        },
        "elapsed": result.elapsed,
        "threads": result.threads,
        "computed": result.computed,
        "spec": result.spec.to_dict(),
    }


def _named_map(source: str, changes: Any) -> NamedSpec:
    """The map to compute: a built-in map, a map in a TOML file, or the map of an older result."""
    path = Path(source)
    if path.suffix != ".npz":
        return read_spec(source, changes)
    if changes:
        raise ValueError("--set: changes a TOML file; an older result has --samples and --seed")
    require_readable(path)
    # Beside the older result, which stays as it is.
    return NamedSpec(f"{path.stem}-again", load_map(path).spec.replace(), seeded=True)


def _planned(plan: Plan) -> dict[str, str]:
    """What is computed and why, and what is not."""
    return {
        "plan": "; ".join([plan.method_words(), *plan.why]),
        "left out": "; ".join(plan.left_out) or "nothing",
    }


def _list(options: argparse.Namespace) -> int:
    """List the built-in maps, sections or reports."""
    kind = options.command.removesuffix("s")
    specs = {name: _READERS[kind](name) for name in names_of(kind)}
    said = {name: f"{spec.title} ({_WORDS[kind](spec)})" for name, spec in specs.items()}
    print_list(said, as_json=options.json)
    return DONE


def _section(options: argparse.Namespace) -> int:
    spec = read_section(options.section, options.changes)
    if options.bodies is not None:
        spec = dataclasses.replace(spec, bodies=positive_int("--bodies", options.bodies))
    if options.seed is not None:
        spec = dataclasses.replace(spec, seed=seed_from(options.seed))
    target = target_of(options.out, spec.name, ".npz", force=options.force)
    threads = resolve_threads(options.threads)
    omega, attitude = on_surface(
        spec.scene, spec.energy, spec.l_gamma, spec.bodies, spec.section, spec.seed
    )
    require_room(target.data, POINT_SIZE * spec.bodies * (spec.points or 1))
    points = poincare(
        spec.scene,
        omega,
        attitude,
        spec.section,
        t_end=spec.t_end,
        count=spec.points,
        check=False,
        threads=threads,
        progress=options.progress,
    )

    def draw() -> Axes:
        drawn = points.plot(spec.x, spec.y, ax=new_figure().add_subplot())
        drawn.set_title(spec.title or "")
        return drawn

    return finished(
        points.save,
        draw,
        target,
        "section",
        words=lambda: f"{points}",
        facts=(lambda: _section_facts(points, spec)) if options.json else None,
        ended=True,  # an interrupted section has no points
    )


def _section_facts(points: Crossings, spec: SectionSpec) -> dict[str, Any]:
    """The numbers of a section that ``--json`` prints."""
    return {
        "name": spec.name,
        "section": points.section.to_dict(),
        "bodies": spec.bodies,
        "points": len(points),
        "complete": bool(points.complete.all()),
        "plan": points.plan.to_dict(),
        "scene": spec.scene.to_dict(),
        "seed": spec.seed,
    }


def _report(options: argparse.Namespace) -> int:
    chosen = [f"run.methods={options.method}"] if options.method else []
    name, spec = read_report(options.report, [*options.changes, *chosen], long=options.long)
    stem = f"report-{name}-long" if options.long else f"report-{name}"
    target = target_of(options.out, stem, ".json", force=options.force)
    require_room(target.data, REPORT_SIZE)
    result = run_report(spec, seconds=options.seconds, progress=options.progress, partial=True)
    return finished(
        result.save,
        result.plot,
        target,
        "report",
        words=lambda: f"{result}\n",
        facts=(lambda: {"name": name, **result.to_dict()}) if options.json else None,
        ended=result.complete,
    )


def _extremes(options: argparse.Namespace) -> int:
    found = extremes(options.family, method=options.method, progress=options.progress)
    if options.json:
        cells = [
            {
                **dataclasses.asdict(dataclasses.replace(cell, case=None)),  # type: ignore[arg-type]
                "family": cell.case.family,
                "case": cell.case.name,
            }
            for cell in found.cells
        ]
        print_list({"counts": found.counts(), "cells": cells}, as_json=True)
    else:
        say(str(found))
    for cell in found.wrong:
        complain(
            f"{cell.case.family}, {cell.case.name}, {cell.method}: the error {cell.error:.1e} is "
            f"above {cell.bound:.1e}, and the status does not tell"
        )
    return SAYS_NO if found.wrong else DONE


def _validation(options: argparse.Namespace) -> int:
    # The values of formulas are computed when the entries are imported.
    from ..literature.validation import validation

    found = validation(options.names or None, progress=options.progress)
    if options.json:
        print_list({"numbers": [row.to_dict() for row in found.rows]}, as_json=True)
    else:
        say(str(found))
        for row in found.rows if options.names else ():
            say("\n" + wrapped(f"{row.entry.name}: {row.entry.quantity}. {row.entry.source}.", 2))
    return SAYS_NO if found.unexplained else DONE


def _tutorials(options: argparse.Namespace) -> int:
    """Write the tutorials as notebooks."""
    folder = Path(options.folder)
    made = {folder / name: content for name, content in notebooks().items()}
    for path in made:
        require_new(path, "DIR", force=options.force)
    folder.mkdir(parents=True, exist_ok=True)
    for path, content in made.items():
        with published(path) as file:
            file.write(content.encode())
    say(f"wrote {len(made)} notebooks into {folder}")
    return DONE


def _info(options: argparse.Namespace) -> int:
    print_list(build_info(), as_json=options.json)
    return DONE


def _show(options: argparse.Namespace) -> int:
    """Print the specification of a map, section or report, if it is valid."""
    kind = options.command
    if options.changes:
        raise ValueError("--show prints the file as it is: leave --set out")
    source = getattr(options, kind)
    _, content, _ = read_source(source, kind)
    _READERS[kind](source)
    say(content.rstrip("\n"))
    return DONE


def _new(options: argparse.Namespace) -> int:
    """Write a specification to change."""
    kind = options.kind
    name = options.like or _COPIED[kind]
    path = Path(options.file or f"my-{kind}.toml")
    require_ending(path, [".toml"], "file")
    _, content, _ = read_source(name, kind)
    require_new(path, "file", force=options.force)
    with published(path) as file:
        file.write(content.encode())
    say(f"wrote {path}; change it, then:\n  rigid {kind} {path}")
    return DONE


def _speed(result: StabilityMap) -> str:
    """What this command computed, in its own time: other rows of a store were there before."""
    done, every = result.computed, int(result.samples.sum())
    if not done:
        return "nothing was computed: all rows were stored"
    rate = done / result.elapsed if result.elapsed > 0.0 else 0.0
    threads = counted(result.threads, "thread")
    share = "" if done == every else f"{done:,} of {every:,} bodies in "
    return f"{rate:,.0f} bodies per second, {share}{result.elapsed:.2f} s on {threads}"
