"""The command line ``rigid``: maps, sections and reports, lists of those built in, the build.

``toml_table`` reports mistakes in a file with their location, ``toml_scene`` reads scene, start and
criterion, ``toml_map``, ``toml_section`` and ``toml_report`` the three kinds of files. Uses
``maps``, ``sections`` and ``reports``; nothing uses it.
"""

from __future__ import annotations

import argparse
import dataclasses
import os
import sys
from collections.abc import Callable, Mapping, Sequence
from io import BytesIO, TextIOWrapper
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn, TypeAlias

from .._checks.arguments import positive_int, resolve_threads
from .._checks.progress import heeding_signals, interruptible
from .._files import published, require_replaceable, require_room
from ..drawing.figure import new_figure
from ..info import build_info
from ..maps.compute import run_map
from ..maps.file import file_size
from ..maps.plan import map_plan
from ..maps.result import StabilityMap
from ..maps.sequential import checked_half_width, stop_table
from ..maps.spec import MapSpec
from ..model.seed import seed_from
from ..reports.compute import run_report
from ..reports.result import Report
from ..reports.stress import extremes
from ..sections.crossings import Crossings
from ..sections.poincare import poincare
from ..sections.starts import on_surface
from .running_maps import (
    add_commands,
    add_options,
    compute_stored,
    default_stem,
    open_and_go_on,
    run,
)
from .toml_map import builtin_names, read_spec
from .toml_report import read_report, report_names
from .toml_section import SectionSpec, read_section, section_names

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["main"]

SILENT_ERROR = 1
USAGE_ERROR = 2
WRITE_ERROR = 74
"""Exit codes; that of an interrupted command is 128 and the number of the signal."""

SECONDS, LONG_SECONDS = 30.0, 120.0
"""Time limits (s) of ``rigid report`` and ``rigid report --long``."""

POINT_SIZE = 140
"""About the bytes of a point of a section in a file."""

REPORT_SIZE = 2**20
"""More bytes than the file of a report has."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; returns the exit code.

    0: done. 1: `rigid extremes` has found a silent error, `rigid diff` a difference, `rigid verify`
    wrong numbers, or some units of a stored map were given up. 2: refused before any work. 74: a
    file or the output could not be written. 75: other parts of a stored map are not finished. 130,
    143: ended by Ctrl-C or SIGTERM.

    Parameters
    ----------
    arguments : sequence of str, optional
        By default those of the process.
    """
    if isinstance(sys.stdout, TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")  # as stderr: a terminal may be ASCII
    with heeding_signals() as interrupted:
        try:
            options = _parser().parse_args(arguments)
            command = {
                "map": _map,
                "resume": _resume,
                **dict.fromkeys(("status", "merge", "diff", "verify", "pack"), run),
                "maps": _maps,
                "section": _section,
                "sections": _sections,
                "report": _report,
                "reports": _reports,
                "extremes": _extremes,
                "info": _info,
            }[options.command]
            code = command(options)
            print(end="", flush=True)
            return code
        except OSError as error:
            print(f"rigid: {error}", file=sys.stderr)
            return WRITE_ERROR
        except (RuntimeError, ValueError) as error:
            print(f"rigid: {error}", file=sys.stderr)
            return USAGE_ERROR
        except KeyboardInterrupt as stop:
            print(f"rigid: {str(stop) or 'interrupted'}", file=sys.stderr)
            return interrupted()


def _map(options: argparse.Namespace) -> int:
    named = read_spec(options.map)
    spec = named.spec
    if options.samples is not None:
        spec = dataclasses.replace(spec, samples=options.samples, half_width=None)
    if options.half_width is not None:
        half_width = checked_half_width(options.half_width)
        most = stop_table(half_width).last
        spec = dataclasses.replace(spec, half_width=half_width, samples=most)
    if options.refine is not None:
        spec = dataclasses.replace(spec, refine=options.refine)
    if options.budget is not None:
        spec = dataclasses.replace(spec, budget=options.budget)
    if options.seed is not None:
        spec = dataclasses.replace(spec, seed=seed_from(options.seed))
    stem = _stem(options.out, named.name, (".npz", ".png"))
    threads = resolve_threads(options.threads)
    require_room(_with_suffix(stem, ".npz"), file_size(spec))
    print(f"{'plan':<12}{_plan(spec)}", flush=True)
    if options.store is not None:
        seeded = named.seeded or options.seed is not None
        return _finished_map(compute_stored(spec, options, seeded=seeded), stem)
    for name in ("part", "dask"):
        if getattr(options, name) is not None:
            raise ValueError(f"--{name}: needs --store")
    result = run_map(
        spec, threads=threads, progress=None if options.progress else False, partial=True
    )
    return _finished_map(result, stem)


def _finished_map(result: StabilityMap | int, stem: Path) -> int:
    """Write a map, and return the exit code; or return the one of a map without a result."""
    if isinstance(result, int):
        return result
    return _finished(
        result, stem, ".npz", "map", lambda: f"{result.summary()}\n{'speed':<12}{_speed(result)}"
    )


def _resume(options: argparse.Namespace) -> int:
    stem = _stem(options.out, default_stem(options.store), (".npz", ".png"))
    return _finished_map(open_and_go_on(options), stem)


def _plan(spec: MapSpec) -> str:
    made = map_plan(spec)
    return "; ".join([made.method_words(), *made.why])


def _maps(options: argparse.Namespace) -> int:
    specs = {name: read_spec(name).spec for name in builtin_names()}
    axes = {name: " x ".join(axis.name for axis in spec.axes) for name, spec in specs.items()}
    return _list({name: f"{spec.title} ({axes[name]})" for name, spec in specs.items()})


def _section(options: argparse.Namespace) -> int:
    spec = read_section(options.section)
    if options.bodies is not None:
        spec = dataclasses.replace(spec, bodies=positive_int("--bodies", options.bodies))
    if options.seed is not None:
        spec = dataclasses.replace(spec, seed=seed_from(options.seed))
    stem = _stem(options.out, spec.name, (".npz", ".png"))
    threads = resolve_threads(options.threads)
    omega, attitude = on_surface(
        spec.scene, spec.energy, spec.l_gamma, spec.bodies, spec.section, spec.seed
    )
    require_room(_with_suffix(stem, ".npz"), POINT_SIZE * spec.bodies * (spec.points or 1))
    points = poincare(
        spec.scene,
        omega,
        attitude,
        spec.section,
        t_end=spec.t_end,
        count=spec.points,
        check=False,
        threads=threads,
        progress=None if options.progress else False,
    )
    return _finished(_SectionResult(points, spec), stem, ".npz", "section", lambda: f"{points}")


def _sections(_options: argparse.Namespace) -> int:
    specs = {name: read_section(name) for name in section_names()}
    return _list(
        {
            name: f"{spec.title} (energy {spec.energy:g} J, L·gamma {spec.l_gamma:g})"
            for name, spec in specs.items()
        }
    )


@dataclasses.dataclass(frozen=True, slots=True)
class _SectionResult:
    """Points with their picture, as :func:`_finished` writes results."""

    points: Crossings
    spec: SectionSpec
    complete: bool = True
    """An interrupted section has no points."""

    def save(self, path: Path) -> Path:
        return self.points.save(path)

    def plot(self, ax: Axes) -> Axes:
        drawn = self.points.plot(self.spec.x, self.spec.y, ax=ax)
        if self.spec.title is not None:
            drawn.set_title(self.spec.title)
        return drawn


_Result: TypeAlias = StabilityMap | Report | _SectionResult


def _report(options: argparse.Namespace) -> int:
    named = read_report(options.report, methods=options.method)
    spec = named.spec
    if options.long:
        spec = dataclasses.replace(spec, t_end=named.t_end_long)
    seconds = options.seconds
    if seconds is None:
        seconds = LONG_SECONDS if options.long else SECONDS
    stem = _stem(options.out, f"report-{named.name}", (".json", ".png"))
    require_room(_with_suffix(stem, ".json"), REPORT_SIZE)
    result = run_report(
        spec, seconds=seconds, progress=None if options.progress else False, partial=True
    )
    return _finished(result, stem, ".json", "report", lambda: f"{result}\n")


def _reports(options: argparse.Namespace) -> int:
    specs = {name: read_report(name).spec for name in report_names()}
    return _list(
        {name: f"{spec.title} (t = {spec.t_end:g} {spec.unit})" for name, spec in specs.items()}
    )


def _extremes(options: argparse.Namespace) -> int:
    found = extremes(
        options.family, method=options.method, progress=None if options.progress else False
    )
    print(found)
    for cell in found.wrong:
        print(
            f"rigid: {cell.case.family}, {cell.case.name}, {cell.method}: {cell.error:.1e}, not "
            f"within {cell.bound:.1e}",
            file=sys.stderr,
        )
    return SILENT_ERROR if found.wrong else 0


def _info(options: argparse.Namespace) -> int:
    return _list({name: _words(value) for name, value in build_info().items()})


def _words(value: object) -> str:
    if isinstance(value, (list, tuple)):
        return ", ".join(map(str, value))
    return "unknown" if value is None else str(value)


def _stem(out: str | None, name: str, suffixes: tuple[str, ...]) -> Path:
    """The output path without suffix, checked before the computation starts."""
    stem = Path(out or name)
    if stem.suffix in suffixes:
        stem = stem.with_suffix("")
    if not stem.name:
        raise ValueError(f"--out: {str(stem)!r} names a directory, not a file")
    for suffix in suffixes:
        try:
            require_replaceable(_with_suffix(stem, suffix))
        except FileExistsError as error:
            raise ValueError(f"--out: {error}") from None
    if not stem.parent.is_dir():
        raise ValueError(f"--out: there is no directory {str(stem.parent)!r}")
    return stem


def _with_suffix(stem: Path, suffix: str) -> Path:
    return stem.with_name(stem.name + suffix)


def _speed(result: StabilityMap) -> str:
    done = int(result.samples.sum())
    rate = done / result.elapsed if result.elapsed > 0.0 else 0.0
    threads = f"{result.threads} thread{'s' if result.threads > 1 else ''}"
    return f"{rate:,.0f} bodies per second, {result.elapsed:.2f} s on {threads}"


def _finished(result: _Result, stem: Path, suffix: str, what: str, words: Callable[[], str]) -> int:
    """Save the data; then print words and paths, and draw the picture. Returns the exit code."""
    with interruptible() as stop:
        data = _saved(result, _with_suffix(stem, suffix), what)
    safe = f"the {what} is safe in {data}"
    picture = _with_suffix(stem, ".png")
    try:
        if stop.is_set():
            raise KeyboardInterrupt
        print(words())
        print(f"{'data':<12}{data}", flush=True)
        try:
            content = _drawn(result)
        except ImportError as error:
            print(f"{'picture':<12}none: {error}", flush=True)
        else:
            with published(picture) as file:
                file.write(content)
            print(f"{'picture':<12}{picture}", flush=True)
    except KeyboardInterrupt:
        raise KeyboardInterrupt(f"interrupted; {safe}, there is no picture") from None
    except OSError as error:
        raise OSError(f"{error}; {safe}") from None
    if not result.complete:
        raise KeyboardInterrupt(f"interrupted; the {what} written is partial")
    return 0


def _saved(result: _Result, data: Path, what: str) -> Path:
    """Save the data, or raise OSError that tells where the data is instead."""
    try:
        return result.save(data)
    except OSError as error:
        import tempfile

        try:
            folder = tempfile.gettempdir()
            spare = result.save(Path(folder, f"rigid-{os.urandom(8).hex()}-{data.name}"))
        except OSError:
            raise OSError(f"{error}; the {what} is not saved") from None
        raise OSError(f"{error}; the {what} is safe in {spare}") from None


def _drawn(result: _Result) -> bytes:
    """The picture as PNG."""
    figure = new_figure()
    result.plot(figure.add_subplot())
    content = BytesIO()
    figure.savefig(content, format="png")
    return content.getvalue()


def _list(lines: Mapping[str, str]) -> int:
    """Print a description for each name."""
    width = max(map(len, lines)) + 2
    for name, text in lines.items():
        print(f"{name:<{width}}{text}")
    return 0


class _Parser(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        self.exit(USAGE_ERROR, f"{self.prog}: {message}\n")


def _parser() -> _Parser:
    parser = _Parser(prog="rigid", description="Stability of rotating rigid bodies.")
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    map_ = commands.add_parser("map", help="compute a stability map, write a picture and the data")
    map_.add_argument("map", metavar="NAME|FILE.toml", help="a built-in map or a specification")
    map_.add_argument("--samples", type=int, metavar="N", help="bodies per pixel")
    map_.add_argument("--threads", type=int, metavar="N", help="default: all this process may use")
    map_.add_argument(
        "--out", metavar="PATH", help="writes PATH.png and PATH.npz (default: ./NAME)"
    )
    map_.add_argument("--seed", type=int, metavar="N", help="key of the random numbers")
    map_.add_argument(
        "--no-progress", dest="progress", action="store_false", help="no progress bar"
    )
    map_.add_argument(
        "--half-width", type=float, metavar="W", help="bodies until each share is known so well"
    )
    map_.add_argument(
        "--refine", type=int, metavar="K", help="first every K-th pixel, then where shares differ"
    )
    map_.add_argument("--budget", type=int, metavar="N", help="most bodies of the map")
    map_.add_argument(
        "--store", metavar="DIR", help="keep what is computed in this folder, and go on from there"
    )
    add_options(map_)
    add_commands(commands)
    commands.add_parser("maps", help="list the built-in maps")
    section = commands.add_parser(
        "section", help="compute a Poincaré section, write a picture and the data"
    )
    section.add_argument(
        "section", metavar="NAME|FILE.toml", help="a built-in section or a specification"
    )
    section.add_argument("--bodies", type=int, metavar="N", help="number of motions")
    section.add_argument(
        "--threads", type=int, metavar="N", help="default: all this process may use"
    )
    section.add_argument(
        "--out", metavar="PATH", help="writes PATH.png and PATH.npz (default: ./NAME)"
    )
    section.add_argument("--seed", type=int, metavar="N", help="key of the random starts")
    section.add_argument(
        "--no-progress", dest="progress", action="store_false", help="no progress bar"
    )
    commands.add_parser("sections", help="list the built-in sections")
    report = commands.add_parser("report", help="error against run time of all methods")
    report.add_argument("report", metavar="NAME|FILE.toml", help="a built-in scene or your own")
    report.add_argument("--long", action="store_true", help="the longer horizon, and more time")
    report.add_argument(
        "--seconds",
        type=float,
        metavar="S",
        help=f"about how long to measure (default: {SECONDS:g}, with --long {LONG_SECONDS:g})",
    )
    report.add_argument(
        "--method", action="append", metavar="NAME", help="only this one; may be repeated"
    )
    report.add_argument(
        "--out", metavar="PATH", help="writes PATH.png and PATH.json (default: ./report-NAME)"
    )
    report.add_argument(
        "--no-progress", dest="progress", action="store_false", help="no progress bar"
    )
    commands.add_parser("reports", help="list the built-in reports")
    worst = commands.add_parser("extremes", help="extreme and stiff bodies by every method")
    worst.add_argument("family", nargs="?", metavar="FAMILY", help="only these, such as needle")
    worst.add_argument("--method", metavar="NAME", help="only this one")
    worst.add_argument(
        "--no-progress", dest="progress", action="store_false", help="no progress bar"
    )
    commands.add_parser("info", help="describe this build")
    return parser
