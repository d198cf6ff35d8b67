"""Pages and tables that are made from the library itself when the site is built."""

from __future__ import annotations

import inspect
import re
import tomllib
from collections.abc import Callable, Collection, Iterator, Mapping
from itertools import groupby
from pathlib import Path
from types import ModuleType

import numpy as np

import rigid
from rigid.cli import toml_map, toml_section
from rigid.cli.parser import CODES, help_on, make_parser
from rigid.cli.toml_scene import KINDS, NOISES, scene_of_keys
from rigid.cli.toml_table import keys
from rigid.maps.spec import MapSpec
from rigid.model.criterion import CRITERIA
from rigid.model.forces import FORCES, forces_in_words
from rigid.model.parameters import PARAMETERS
from rigid.reports.spec import ReportSpec

__all__ = ["write_generated_pages"]

GROUPS = {
    "rigid": ["exact", "units"],
    "Bodies": ["inertia", "solids", "meshes", "particles", "springs", "statics", "fixed_axis"],
    "Motions": ["free", "top", "earth"],
    "Rotations": ["rotations", "frames"],
    "Pictures": ["figures", "animation"],
}
"""The modules of the reference, by subject."""


SUBJECTS = {
    "Bodies and scenes": (
        *("_checks.moments", "model.body", "model.forces", "model.orbit", "model.sampled"),
        *("model.scene", "model.torque"),
    ),
    "States at output times": ("fits", "model.events", "sections", "solve"),
    "Plans and methods": ("citing", "planning", "solve.methods", "solve.plan"),
    "Maps": ("_checks.progress", "maps", "model", "store"),
    "Starts": ("maps.vary", "model.mixture", "model.noise", "model.start"),
    "Reports, extremes and validation": ("literature", "reports"),
    "This installation": ("info",),
}
"""The subjects of the page of ``rigid``, with the modules whose functions and classes it has."""


def write_generated_pages(docs: Path) -> None:
    """Write the pages of modules, and the tables and texts that other pages include."""
    folder = docs / "generated"
    folder.mkdir(exist_ok=True)
    write_explorer(docs / "_static" / "explorer.html")
    _write(docs / "map_parameters.txt", map_parameters())
    _write(folder / "criteria.txt", criterion_table())
    _write(folder / "methods_of_forces.txt", force_table())
    _write(folder / "modules.txt", module_table())
    _write(folder / "commands.txt", command_help())
    for name, text in toml_tables().items():
        _write(folder / f"toml_{name}.txt", text)
    _write(folder / "validation.txt", validation_table())
    _write(folder / "install.txt", install_commands())
    write_films(docs / "_static")
    (docs / "api").mkdir(exist_ok=True)
    _write(docs / "api" / "rigid.rst", package_page())
    for name in modules():
        _write(docs / "api" / f"{name}.rst", module_page(name))


def write_films(folder: Path) -> None:
    """The films of the first pages, by the code that the pages show."""
    folder.mkdir(exist_ok=True)
    box = rigid.FreeBody(rigid.Body.box(0.25, 0.08, 0.01, mass=0.3))
    throws = [[0.01, 10.0, 0.0], [1e-6, 10.0, 0.0]]
    two = rigid.simulate(box, throws, t=np.linspace(0.0, 2.6, 261))
    two.animate(folder / "two-throws.html", body=[0, 1], speed=0.3)


def install_commands() -> str:
    """How to install the package: from a clone, until ``pyproject.toml`` names the repository."""
    project = tomllib.loads((Path(__file__).parents[1] / "pyproject.toml").read_text())["project"]
    repository = project.get("urls", {}).get("Repository")
    if repository is not None:
        command = f"pip install '{project['name']}[maps]'"
        return f"```sh\n{command}\n```\n\nThe source is on <{repository}>.\n"
    return """```sh
# not on an index yet: in a clone, with Rust 1.89 or newer
python3 -m venv .venv && . .venv/bin/activate
pip install '.[maps]'
```
"""


def _write(path: Path, text: str) -> None:
    """Write a text; a file that would not change keeps its time, so that Sphinx keeps its page."""
    if not path.exists() or path.read_text(encoding="utf-8") != text:
        path.write_text(text, encoding="utf-8")


def modules() -> list[str]:
    """The public modules of the package."""
    return [name for name in rigid.__all__ if isinstance(getattr(rigid, name), ModuleType)]


def map_parameters() -> str:
    """The table of ``maps_reference.md``: parameters that differ only in their axis share a row."""

    def cells(name: str) -> tuple[str, str]:
        parameter, last = PARAMETERS[name], name[-1]
        meaning = parameter.meaning
        if last.isdigit():
            meaning = meaning.replace(last, "1, 2 or 3")
        return "" if parameter.unit == "1" else parameter.unit, meaning

    lines = ["| names | unit | meaning |", "|---|---|---|"]
    for (unit, meaning), names in groupby(PARAMETERS, key=cells):
        listed = ", ".join(f"`{name}`" for name in names)
        lines.append(f"| {listed} | {unit} | {meaning} |")
    return "\n".join(lines) + "\n"


def criterion_table() -> str:
    """The table of ``maps.md``: what each criterion says of a stable body."""
    lines = ["| criterion | a body is stable if |", "|---|---|"]
    for name in (*CRITERIA, "librates"):
        make = getattr(rigid, name)
        _, _, meaning = _summary(make).partition("Stable: ")
        lines.append(f"| {{py:func}}`{name}({', '.join(keys(make))}) <rigid.{name}>` | {meaning} |")
    return "\n".join(lines) + "\n"


def force_table() -> str:
    """The table of ``forces.md``: forces that the same methods integrate share a row."""

    def able(force: str) -> str:
        return ", ".join(f"`{one.name}`" for one in rigid.methods() if force in one.forces)

    lines = ["| forces | methods |", "|---|---|"]
    for methods, forces in groupby(("torque", "damping", *FORCES, "function"), key=able):
        lines.append(f"| {', '.join(map(forces_in_words, zip(forces)))} | {methods} |")
    return "\n".join(lines) + "\n"


def module_table() -> str:
    """The table of ``reference.md``: a line for each module."""
    lines = ["| module | what is in it |", "|---|---|"]
    for title, names in GROUPS.items():
        if title == "rigid":
            lines.append(
                "| [`rigid`](api/rigid.rst) | bodies, scenes, runs, plans, maps, reports |"
            )
        lines += [
            f"| [`rigid.{name}`](api/{name}.rst) | {_summary(getattr(rigid, name))} |"
            for name in names
        ]
    return "\n".join(lines) + "\n"


SHOWN = (
    *("toutatis-precession", "apophis-period", "envisat-2013", "mercury-libration"),
    *("phobos-libration", "earth-solar-precession", "flip-period", "moon-longitude"),
)
"""The published numbers of ``reliability.md``; ``rigid validation`` has all."""


def validation_table() -> str:
    """The table of ``reliability.md``: published numbers beside those computed now."""
    lines = ["| number | published | here |", "|---|---|---|"]
    for row in rigid.validation(SHOWN, progress=False).rows:
        entry = row.entry
        unit = f" {entry.unit}" if entry.unit else ""
        reason = f" The model differs: {entry.reason}." if entry.reason else ""
        cells = (
            f"`{entry.name}`: {entry.quantity}.{reason}",
            f"{entry.printed}{unit}" if entry.digits else entry.printed,
            f"{row.cells()[2]}{unit}",
        )
        lines.append("| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |")
    return "\n".join(lines) + "\n"


def _summary(documented: object) -> str:
    """The first sentence of a docstring, without its full stop."""
    text = inspect.getdoc(documented) or ""
    return " ".join(text.partition("\n\n")[0].split()).rstrip(".").replace("``", "`")


def module_page(name: str) -> str:
    """The page of a module: its text, and a table of its functions and classes."""
    module = getattr(rigid, name)
    full = f"rigid.{name}"
    own, others = [], []
    for public in module.__all__:
        value = getattr(module, public)
        if inspect.isclass(value) or inspect.isroutine(value):
            (own if _home(value) in (full, None) else others).append(public)
    lines = [*_head(full), *_listed(own)]
    if others:
        elsewhere = ", ".join(f":obj:`~{_home(getattr(module, item))}.{item}`" for item in others)
        lines += [f"From other modules: {elsewhere}.", ""]
    if name == "figures":
        lines += ["Colours", "-------", "", ".. automodule:: rigid.drawing.colours", "   :members:"]
    return "\n".join(lines).rstrip() + "\n"


def package_page() -> str:
    """The page of the package: its text, and tables of its functions and classes by subject."""
    title_of = {home: title for title, homes in SUBJECTS.items() for home in homes}
    names: dict[str, list[str]] = {title: [] for title in SUBJECTS}
    for public in rigid.__all__:
        module = getattr(getattr(rigid, public), "__module__", None)
        if module is not None:  # neither a module nor the version
            homes = [home for home in title_of if module.startswith(f"rigid.{home}")]
            names[title_of[max(homes, key=len)]].append(public)
    lines = _head("rigid")
    for title, own in names.items():
        lines += [title, "-" * len(title), "", *_listed(own)]
    return "\n".join(lines)


def _head(module: str) -> list[str]:
    """The begin of the page of a module."""
    title = [module, "=" * len(module), ""]
    text = [f".. automodule:: {module}", "   :no-members:", ""]
    return [*title, *text, f".. currentmodule:: {module}", ""]


def _listed(names: list[str]) -> list[str]:
    """A table of functions and classes, each with its own page."""
    options = [".. autosummary::", "   :toctree: generated", "   :nosignatures:", ""]
    return [*options, *(f"   {name}" for name in names), ""]


def _home(value: object) -> str | None:
    """The public module whose own function or class this is."""
    for name in ["", *modules()]:
        module = getattr(rigid, name) if name else rigid
        own = f"rigid.{name}" if name else "rigid"
        public = getattr(module, "__all__", ())
        if any(getattr(module, item) is value for item in public) and (
            not name or value.__module__.startswith(own)
        ):
            return own
    return None


def toml_tables() -> dict[str, str]:
    """The tables of keys in ``maps_reference.md``: the keys are the arguments of a function."""
    top, free = (keys(KINDS[kind]) for kind in ("heavy-top", "free-body"))
    only_free = [key for key in free if key not in top]
    outside = [key for key in keys(rigid.FreeBody) if key not in free]
    scene: list[Callable[..., object]] = [scene_of_keys, rigid.FreeBody, rigid.HeavyTop]
    not_in_run = ("scene", "start", "axes", "vary", "stable", "title", "own", "version")
    not_in_report = ("scene", "omega", "attitude", "title", "version", "schemes")
    return {
        "axis": key_table(
            [toml_map.listed, toml_map.spaced], (), ("values", "from", "to", "count")
        ),
        "map_run": key_table([MapSpec], not_in_run, ("samples", "seed")),
        "scene": key_table(scene, ("scene", *outside, *only_free)),
        "free_scene": key_table([rigid.FreeBody], (*outside, *top)),
        "orbit": key_table([rigid.Orbit]),
        "orbit_flyby": key_table([rigid.Orbit.flyby]),
        "orbit_table": key_table([rigid.Orbit.table]),
        "rotor_table": key_table([rigid.RotorTable]),
        "start": key_table([rigid.Start]),
        "report_start": key_table([rigid.Start], ("noise", "attitude_noise")),
        "report_run": key_table([ReportSpec], not_in_report, ("methods",)),
        "surface": key_table([rigid.section]),
        "section_start": key_table([toml_section.starts]),
        "section_run": key_table([toml_section.run]),
        "plot": key_table([toml_section.plot]),
        "criteria": choice_table("criterion", CRITERIA),
        "measures": choice_table("name", toml_map.MAKES),
        "noises": choice_table("kind", NOISES),
    }


VALUES = {
    r"float or array_like, shape \(\.\.\.\)": "number",
    r"(, shape )?(\(\.\.\.\)|or \(\.\.\., 3\))|, optional|, or scipy Rotation| or None": "",
    r"array_like, shape \((\d),\)": r"\1 numbers",
    r"array_like(, shape \(\w+,\))?": "numbers",
    r"\bfloat\b": "number",
    r"\bint\b": "whole number",
    r"\bstr\b": "text",
    r"\bbool\b": "true or false",
    r"text or \(text, number\)": "text, or text and number",
    "tuple of text": "texts",
    "tuple of number": "numbers",
    "EnergySink": "number or 3 numbers",
    "Noise or Samples|Noise|Orbit": "table",
    "Torque": "3 numbers",
    "tuple of Measure": "names or tables",
    r"[{}]": "",
}
"""The types of docstrings in the words of files."""


def described(make: Callable[..., object]) -> Iterator[tuple[str, str, str]]:
    """Name, type and meaning of the arguments of a function, from its docstring."""
    text = inspect.getdoc(make) or ""
    part = re.search(r"^(?:Parameters|Attributes)\n-+\n(.*?)(?:\n\n|\Z)(?!    )", text, re.S | re.M)
    entries = re.findall(
        r"^(\S.*?) : (.*)\n((?:    .*\n?|\n)+)", f"{part[1] if part else ''}\n", re.M
    )
    for names, kind, meaning in entries:
        for name in names.split(", "):
            yield name, kind, " ".join(meaning.split())


def key_table(
    makes: list[Callable[..., object]],
    without: Collection[str] = (),
    optional: Collection[str] = (),
) -> str:
    """The keys of a table whose values are the arguments of functions, without some.

    Some that a function needs are ``optional`` in a file.
    """
    lines = ["| key | value | default | meaning |", "|---|---|---|---|"]
    seen = set(without)
    for make in makes:
        known = keys(make)
        for name, kind, meaning in described(make):
            key = name.removesuffix("_")
            if key in seen or key not in known:
                continue
            seen.add(key)
            value = kind
            for of_python, of_file in VALUES.items():
                value = re.sub(of_python, of_file, value)
            meaning = re.sub(r":\w+:`~?([^`]*)`", r"`\1`", meaning).replace("``", "`")
            meaning = re.sub(r"\bNone:", "omitted:", meaning)
            cells = [
                f"`{key}`",
                value.strip(),
                "" if key in optional else _default(known[key]),
                meaning,
            ]
            lines.append("| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |")
    return "\n".join(lines) + "\n"


def choice_table(word: str, makes: Mapping[str, Callable[..., object]]) -> str:
    """The functions that a key may name, with the other keys of each."""
    lines = [f"| `{word}` | other keys, with defaults |", "|---|---|"]
    for name, make in makes.items():
        given = {key: _default(one) for key, one in keys(make).items()}
        listed = [
            f"`{key}`" + {"": "", "required": " (required)"}.get(value, f" = {value}")
            for key, value in given.items()
        ]
        lines.append(f"| `{name}` | {', '.join(listed) or 'none'} |")
    return "\n".join(lines) + "\n"


def _default(parameter: inspect.Parameter) -> str:
    value = parameter.default
    if value is parameter.empty:
        return "required"
    if value in (None, ()):
        return ""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, tuple):
        return str(list(value))
    return f"{value:,}" if isinstance(value, int) else repr(value)


def command_help() -> str:
    """The help of every command, and the exit codes."""
    parser = make_parser()
    parts = []
    for name, command in {"": parser, **parser.commands()}.items():
        title = f"rigid {name}".strip()
        parts.append(f"### {title}\n\n```text\n{command.format_help().rstrip()}\n```\n")
    parts.append(f"### rigid help {CODES}\n\n```text\n{help_on(parser, CODES)}\n```\n")
    return "\n".join(parts)


def write_explorer(path: Path) -> None:
    """The page of ``maps.md`` to try: the sleeping top."""
    path.parent.mkdir(exist_ok=True)
    result = rigid.stability_map(
        rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0),
        axes={"spin": np.linspace(2.0, 6.0, 41), "attitude_noise": np.geomspace(1e-3, 0.3, 30)},
        start=rigid.Start(spin=5.0, attitude_noise=rigid.normal(0.01)),
        stable=rigid.tilt_below(0.5),
        t_end=40.0,
        samples=64,
        rng=2026,
        progress=False,
        title="The sleeping top",
    )
    result.explore(path)
