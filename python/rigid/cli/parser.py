"""The arguments of the command ``rigid``, with examples in every help text."""

from __future__ import annotations

import argparse
import re
from collections.abc import Callable, Mapping
from functools import partial
from typing import NoReturn

from .._checks.arguments import nearest, of_known, one_of
from .._checks.shown import WIDTH, wrapped
from .._core import __version__
from ..reports.compute import LONG_SECONDS, SECONDS
from .output import EXIT_CODES, REFUSED, complain

_FOLDER = "folder of a running map"

CODES = "exit-codes"
"""What ``rigid help`` tells besides the help of commands."""

GROUPS: Mapping[str, tuple[str, ...]] = {
    "compute and draw": ("map", "explore", "section", "report", "new"),
    "maps in folders, by any number of processes": (
        *("resume", "status", "merge", "diff", "verify", "pack"),
    ),
    "look up and check": (
        *("maps", "sections", "reports", "tutorials", "extremes", "validation", "info", "help"),
    ),
}
"""The commands by what they are for."""

_EXAMPLES = {
    "": """\
  rigid map thrown-box          compute a built-in map: picture and data
  rigid maps                    list the built-in maps
  rigid new map my-map.toml     write a specification to change
  rigid map my-map.toml         compute the map of this specification
  rigid help map                the options of a command, and examples
  rigid help exit-codes         what the exit code of a command says
""",
    "map": """\
  rigid map thrown-box
  rigid map thrown-box --samples 256 --out fine.pdf     a picture for a paper
  rigid map thrown-box --set run.t_end=2 --out longer   another horizon
  rigid map --show thrown-box > my-map.toml             print the specification
  rigid map my-map.toml --check                         plan and cost only
  rigid map my-map.toml --json                          facts for programs
""",
    "explore": """\
  rigid map thrown-box && rigid explore thrown-box.npz
  rigid explore thrown-box.npz --samples 16 --out bodies.html
""",
    "section": """\
  rigid section kovalevskaya
  rigid section kovalevskaya --bodies 40 --out fine.pdf
  rigid section --show kovalevskaya > my-section.toml
""",
    "report": """\
  rigid report lagrange-top
  rigid report lagrange-top --method rk4 --method taylor16
  rigid report lagrange-top --long           over 1e3 to 1e6 revolutions
  rigid report --show lagrange-top > my-report.toml
""",
    "extremes": """\
  rigid extremes
  rigid extremes needle --method taylor16
""",
    "validation": """\
  rigid validation
  rigid validation toutatis-precession apophis-energy
""",
    "tutorials": """\
  rigid tutorials notebooks && jupyter lab notebooks
""",
    "new": """\
  rigid new map                                  writes my-map.toml
  rigid new map tops.toml --like sleeping-top
""",
}


class Parser(argparse.ArgumentParser):
    """A parser that answers mistakes in one line."""

    def commands(self) -> dict[str, argparse.ArgumentParser]:
        """The parsers of the commands by name."""
        return {
            name: parser
            for action in self._actions
            if isinstance(action, argparse._SubParsersAction)
            for name, parser in action.choices.items()
        }

    def error(self, message: str) -> NoReturn:
        """End with exit code 2 and one line."""
        if found := re.fullmatch(
            r"argument (\w+): invalid choice: '(.*?)' \(choose from (.*)\)", message
        ):
            known = re.findall(r"[\w-]+", found[3])
            message = f"{found[1]} = {found[2]!r}: unknown{of_known(found[2], known)}"
        elif found := re.fullmatch(r"argument (\S+): invalid (int|float) value: (.*)", message):
            kind = "whole" if found[2] == "int" else "real"
            message = f"{found[1]} = {found[3]}: must be a {kind} number"
        elif found := re.fullmatch(r"unrecognized arguments: (-\S+).*", message):
            parsers = [self, *self.commands().values()]
            options = [name for one in parsers for name in one._option_string_actions]
            hint = "" if found[1] in options else nearest(found[1], options)
            message = f"{found[1]}: this command has no such option{hint}"
        elif found := re.fullmatch(r"the following arguments are required: (.*)", message):
            message = f"needs {found[1]}; {self.prog} --help has examples"
        complain(message, self.prog)
        self.exit(REFUSED)


def make_parser() -> Parser:
    """The parser of the command line."""
    in_columns = partial(argparse.RawDescriptionHelpFormatter, width=WIDTH)
    parser = Parser(
        prog="rigid",
        usage="rigid COMMAND ...",
        description="How rigid bodies rotate, and which of these motions are stable.",
        formatter_class=in_columns,
    )
    parser.add_argument("--version", action="version", version=f"rigid {__version__}")
    commands = parser.add_subparsers(
        prog="rigid", dest="command", metavar="COMMAND", help=argparse.SUPPRESS
    )
    lines: dict[str, str] = {}

    def command(name: str, words: str) -> argparse.ArgumentParser:
        examples = _EXAMPLES.get(name)
        lines[name] = wrapped(f"  {name:<12}{words}", indent=14)
        return commands.add_parser(
            name,
            description=wrapped(f"{words[0].upper()}{words[1:]}.", indent=0),
            epilog=f"examples:\n{examples}" if examples else None,
            formatter_class=in_columns,
        )

    map_ = command("map", "compute a stability map, write a picture and the data")
    _source(map_, "map", "a built-in map, a TOML file, or a saved map (.npz) to compute again")
    map_.add_argument(
        "--check",
        action="store_true",
        help="check the file, tell the plan, the cost and what would be written; compute nothing",
    )
    map_.add_argument("--samples", type=int, metavar="N", help="bodies per pixel")
    _threads(map_)
    _files(map_, ".npz", "./NAME")
    map_.add_argument("--seed", type=int, metavar="N", help="key of the random numbers")
    _shown(map_)
    map_.add_argument(
        "--half-width",
        type=float,
        metavar="W",
        help="instead of --samples: add bodies until each share is known to within W",
    )
    map_.add_argument(
        "--refine",
        type=int,
        metavar="K",
        help="compute every K-th pixel first, then the pixels between different shares",
    )
    map_.add_argument(
        "--what",
        metavar="TEXT",
        default="share",
        help="what the picture shows: share, cost, a measure such as 'mean of flips', or the "
        "exponent of a map of chaos",
    )
    map_.add_argument("--budget", type=int, metavar="N", help="most bodies of the map")
    map_.add_argument(
        "--store",
        metavar="DIR",
        help="keep the results in this folder; the same command goes on after an interruption",
    )
    _parts(map_, "; needs --store")
    _running_maps(command)
    explore = command("explore", "write a page to explore a computed map in a browser")
    explore.add_argument("map", metavar="FILE.npz", help="a saved map, which rigid map writes")
    explore.add_argument("--out", metavar="FILE.html", help="the page (default: FILE.html)")
    explore.add_argument(
        "--samples", type=int, metavar="N", help="how many bodies of each pixel the page shows"
    )
    _threads(explore)
    explore.add_argument("--force", action="store_true", help="replace an existing file")
    _json(command("maps", "list the built-in maps"))

    section = command("section", "compute a Poincaré section, write a picture and the data")
    _source(section, "section", "a built-in section or a TOML file")
    section.add_argument("--bodies", type=int, metavar="N", help="number of motions")
    _threads(section)
    _files(section, ".npz", "./NAME")
    section.add_argument("--seed", type=int, metavar="N", help="key of the random starts")
    _shown(section)
    _json(command("sections", "list the built-in sections"))

    report = command(
        "report", "measure error against run time of all methods, after a short or a long run"
    )
    _source(report, "report", "a built-in report or a TOML file")
    report.add_argument(
        "--long",
        action="store_true",
        help="errors of energy, momentum and phase over 1e3 to 1e6 revolutions instead",
    )
    report.add_argument(
        "--seconds",
        type=float,
        metavar="S",
        help=f"seconds to measure (default: {SECONDS:g}, with --long {LONG_SECONDS:g})",
    )
    report.add_argument(
        "--method", action="append", metavar="NAME", help="only this method; may be repeated"
    )
    _files(report, ".json", "./report-NAME")
    _shown(report)
    _json(command("reports", "list the built-in reports"))

    worst = command("extremes", "run extreme and stiff bodies by every method")
    worst.add_argument(
        "family", nargs="?", metavar="FAMILY", help="only this family, such as needle"
    )
    worst.add_argument("--method", metavar="NAME", help="only this method")
    _shown(worst)

    literature = command("validation", "compute numbers of the literature, and compare")
    literature.add_argument("names", nargs="*", metavar="NAME", help="only these entries")
    _shown(literature)

    new = command("new", "write a specification to change, as a commented TOML file")
    new.add_argument("kind", choices=("map", "section", "report"), help="what the file specifies")
    new.add_argument("file", nargs="?", metavar="FILE.toml", help="default: my-map.toml, and so on")
    new.add_argument("--like", metavar="NAME", help="the built-in specification to copy")
    new.add_argument("--force", action="store_true", help="replace an existing file")

    written = command("tutorials", "write the tutorials as notebooks of Jupyter")
    written.add_argument("folder", metavar="DIR", help="a folder, made if there is none")
    written.add_argument("--force", action="store_true", help="replace existing files")

    _json(command("info", "describe this build: version, instruction set, threads"))
    topic = command("help", "explain a command, or the exit codes")
    topic.add_argument("topic", nargs="?", metavar="TOPIC", help=f"a command, or {CODES}")
    groups = [
        "\n".join([f"{title}:", *(lines[name] for name in names)])
        for title, names in GROUPS.items()
    ]
    parser.epilog = "\n\n".join([*groups, f"examples:\n{_EXAMPLES['']}"])
    return parser


def help_on(parser: Parser, topic: str | None) -> str:
    """The help of a command, of all commands by default, or the exit codes.

    Raises
    ------
    ValueError
        If there is no such topic.
    """
    if topic == CODES:
        return "\n".join(wrapped(f"{code:<10}{text}", 10) for code, text in EXIT_CODES.items())
    named = parser.commands()
    if topic is None:
        return parser.format_help().rstrip()
    return named[one_of("TOPIC", topic, [*named, CODES])].format_help().rstrip()


def _running_maps(command: Callable[[str, str], argparse.ArgumentParser]) -> None:
    """The commands that work on stores."""
    resume = command("resume", "go on with a running map")
    resume.add_argument("store", metavar="DIR", help=_FOLDER)
    _threads(resume)
    _files(resume, ".npz", "DIR without its suffix")
    _shown(resume)
    _parts(resume, "")
    status = command("status", "tell what a running map has and lacks")
    status.add_argument("store", metavar="DIR", help=_FOLDER)
    merge = command("merge", "merge running maps of one specification")
    merge.add_argument("stores", metavar="DIR", nargs="+", help="folders of running maps")
    merge.add_argument("--into", required=True, metavar="DIR", help="a new folder, or one of these")
    diff = command("diff", "tell how two maps differ")
    diff.add_argument("one", metavar="A", help="a folder of a running map, or a saved map")
    diff.add_argument("other", metavar="B", help="the map to compare with")
    verify = command("verify", "compute stored numbers again, and compare")
    verify.add_argument("map", metavar="X", help="a folder of a running map, or a saved map")
    share = verify.add_mutually_exclusive_group()
    share.add_argument(
        "--share",
        type=float,
        default=0.01,
        metavar="F",
        help="share of the numbers, chosen at random (default: 0.01)",
    )
    share.add_argument(
        "--all", dest="share", action="store_const", const=1.0, help="all numbers that are stored"
    )
    verify.add_argument("--seed", type=int, default=0, metavar="N", help="key of the random choice")
    _threads(verify)
    pack = command("pack", "write a running map as one file")
    pack.add_argument("store", metavar="DIR", help=_FOLDER)
    pack.add_argument("out", metavar="OUT", help="the file to write, in .npz or .zarr, or a URL")
    pack.add_argument(
        "--partial", action="store_true", help="also write a map that is not finished"
    )
    pack.add_argument("--force", action="store_true", help="replace an existing file")


def _parts(parser: argparse.ArgumentParser, needs: str) -> None:
    parser.add_argument("--part", metavar="K/N", help=f"compute only part K of N{needs}")
    parser.add_argument("--dask", metavar="ADDRESS", help=f"compute on this Dask cluster{needs}")


def _source(parser: argparse.ArgumentParser, name: str, words: str) -> None:
    parser.add_argument(name, metavar="NAME|FILE.toml", help=words)
    parser.add_argument(
        "--show", action="store_true", help="print the specification and compute nothing"
    )
    parser.add_argument(
        "--set",
        dest="changes",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="change a key of the specification, such as run.t_end=10; may be repeated",
    )


def _threads(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--threads",
        type=int,
        metavar="N",
        help="number of threads (default: all that this process may use)",
    )


def _files(parser: argparse.ArgumentParser, data: str, default: str) -> None:
    parser.add_argument(
        "--out",
        metavar="PATH",
        help=f"writes PATH.png and PATH{data} (default: {default}); a suffix such as .pdf or .svg "
        "is the format of the picture",
    )
    parser.add_argument("--force", action="store_true", help="replace existing files")


def _shown(parser: argparse.ArgumentParser) -> None:
    _json(parser)
    parser.add_argument(
        "--no-progress",
        dest="progress",
        action="store_const",
        const=False,
        help="neither a progress bar in a terminal nor a line every 10 s elsewhere",
    )


def _json(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--json", action="store_true", help="print JSON for other programs")
