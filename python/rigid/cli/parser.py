"""The arguments of the command ``rigid``, with examples in every help text."""

from __future__ import annotations

import argparse
import re
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any, NoReturn

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
    checks = "check the file, tell the plan, the cost and what would be written; compute nothing"
    _argument(map_, "--check", checks)
    _argument(map_, "--samples N", "bodies per pixel", int)
    _threads(map_)
    _files(map_, ".npz", "./NAME")
    _argument(map_, "--seed N", "key of the random numbers", int)
    _shown(map_)
    narrows = "instead of --samples: add bodies until each share is known to within W"
    _argument(map_, "--half-width W", narrows, float)
    refines = "compute every K-th pixel first, then the pixels between different shares"
    _argument(map_, "--refine K", refines, int)
    draws = (
        "what the picture shows: share, cost, a measure such as 'mean of flips', or the "
        "exponent of a map of chaos"
    )
    _argument(map_, "--what TEXT", draws, default="share")
    _argument(map_, "--budget N", "most bodies of the map", int)
    keeps = "keep the results in this folder; the same command goes on after an interruption"
    _argument(map_, "--store DIR", keeps)
    _parts(map_, "; needs --store")

    _running_maps(command)

    explore = command("explore", "write a page to explore a computed map in a browser")
    _argument(explore, "map FILE.npz", "a saved map, which rigid map writes")
    _argument(explore, "--out FILE.html", "the page (default: FILE.html)")
    _argument(explore, "--samples N", "how many bodies of each pixel the page shows", int)
    _threads(explore)
    _argument(explore, "--force", "replace an existing file")

    _json(command("maps", "list the built-in maps"))

    section = command("section", "compute a Poincaré section, write a picture and the data")
    _source(section, "section", "a built-in section or a TOML file")
    _argument(section, "--bodies N", "number of motions", int)
    _threads(section)
    _files(section, ".npz", "./NAME")
    _argument(section, "--seed N", "key of the random starts", int)
    _shown(section)

    _json(command("sections", "list the built-in sections"))

    report = command(
        "report", "measure error against run time of all methods, after a short or a long run"
    )
    _source(report, "report", "a built-in report or a TOML file")
    lasts = "errors of energy, momentum and phase over 1e3 to 1e6 revolutions instead"
    _argument(report, "--long", lasts)
    measures = f"seconds to measure (default: {SECONDS:g}, with --long {LONG_SECONDS:g})"
    _argument(report, "--seconds S", measures, float)
    _argument(report, "--method NAME", "only this method; may be repeated", action="append")
    _files(report, ".json", "./report-NAME")
    _shown(report)

    _json(command("reports", "list the built-in reports"))

    worst = command("extremes", "run extreme and stiff bodies by every method")
    _argument(worst, "family FAMILY", "only this family, such as needle", nargs="?")
    _argument(worst, "--method NAME", "only this method")
    _shown(worst)

    literature = command("validation", "compute numbers of the literature, and compare")
    _argument(literature, "names NAME", "only these entries", nargs="*")
    _shown(literature)

    new = command("new", "write a specification to change, as a commented TOML file")
    new.add_argument("kind", choices=("map", "section", "report"), help="what the file specifies")
    _argument(new, "file FILE.toml", "default: my-map.toml, and so on", nargs="?")
    _argument(new, "--like NAME", "the built-in specification to copy")
    _argument(new, "--force", "replace an existing file")

    written = command("tutorials", "write the tutorials as notebooks of Jupyter")
    _argument(written, "folder DIR", "a folder, made if there is none")
    _argument(written, "--force", "replace existing files")

    _json(command("info", "describe this build: version, instruction set, threads"))

    topic = command("help", "explain a command, or the exit codes")
    _argument(topic, "topic TOPIC", f"a command, or {CODES}", nargs="?")

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
    _argument(resume, "store DIR", _FOLDER)
    _threads(resume)
    _files(resume, ".npz", "DIR without its suffix")
    _shown(resume)
    _parts(resume, "")

    status = command("status", "tell what a running map has and lacks")
    _argument(status, "store DIR", _FOLDER)

    merge = command("merge", "merge running maps of one specification")
    _argument(merge, "stores DIR", "folders of running maps", nargs="+")
    _argument(merge, "--into DIR", "a new folder, or one of these", required=True)

    diff = command("diff", "tell how two maps differ")
    _argument(diff, "one A", "a folder of a running map, or a saved map")
    _argument(diff, "other B", "the map to compare with")

    verify = command("verify", "compute stored numbers again, and compare")
    _argument(verify, "map X", "a folder of a running map, or a saved map")
    share = verify.add_mutually_exclusive_group()
    some = "share of the numbers, chosen at random (default: 0.01)"
    _argument(share, "--share F", some, float, default=0.01)
    _constant(share, "--all", "share", 1.0, "all numbers that are stored")
    _argument(verify, "--seed N", "key of the random choice", int, default=0)
    _threads(verify)

    pack = command("pack", "write a running map as one file")
    _argument(pack, "store DIR", _FOLDER)
    _argument(pack, "out OUT", "the file to write, in .npz or .zarr, or a URL")
    _argument(pack, "--partial", "also write a map that is not finished")
    _argument(pack, "--force", "replace an existing file")


def _argument(
    parser: argparse._ActionsContainer,
    usage: str,
    words: str,
    kind: Callable[[str], Any] = str,
    **how: Any,
) -> None:
    """Add an argument as its usage is shown: ``--samples N`` takes a value, ``--force`` none."""
    name, _, value = usage.partition(" ")
    if value:
        parser.add_argument(name, metavar=value, help=words, type=kind, **how)
    else:
        parser.add_argument(name, action="store_true", help=words)


def _constant(
    parser: argparse._ActionsContainer, name: str, dest: str, value: object, words: str
) -> None:
    """Add an argument that gives a constant to another name."""
    parser.add_argument(name, dest=dest, action="store_const", const=value, help=words)


def _parts(parser: argparse.ArgumentParser, needs: str) -> None:
    _argument(parser, "--part K/N", f"compute only part K of N{needs}")
    _argument(parser, "--dask ADDRESS", f"compute on this Dask cluster{needs}")


def _source(parser: argparse.ArgumentParser, name: str, words: str) -> None:
    _argument(parser, f"{name} NAME|FILE.toml", words)
    _argument(parser, "--show", "print the specification and compute nothing")
    changes = "change a key of the specification, such as run.t_end=10; may be repeated"
    _argument(parser, "--set KEY=VALUE", changes, dest="changes", action="append", default=[])


def _threads(parser: argparse.ArgumentParser) -> None:
    words = "number of threads (default: all that this process may use)"
    _argument(parser, "--threads N", words, int)


def _files(parser: argparse.ArgumentParser, data: str, default: str) -> None:
    _argument(
        parser,
        "--out PATH",
        f"writes PATH.png and PATH{data} (default: {default}); a suffix such as .pdf or .svg "
        "is the format of the picture",
    )
    _argument(parser, "--force", "replace existing files")


def _shown(parser: argparse.ArgumentParser) -> None:
    _json(parser)
    words = "neither a progress bar in a terminal nor a line every 10 s elsewhere"
    _constant(parser, "--no-progress", "progress", False, words)


def _json(parser: argparse.ArgumentParser) -> None:
    _argument(parser, "--json", "print JSON for other programs")
