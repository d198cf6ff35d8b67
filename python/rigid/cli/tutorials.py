"""The tutorials as notebooks, made from the scripts that the site shows.

A script is one of sphinx-gallery: its docstring and its comments below ``# %%`` are text, in the
little of reStructuredText that the tutorials use.
"""

from __future__ import annotations

import ast
import json
import re
from collections.abc import Mapping
from importlib import resources
from typing import Any

from .. import _core

_TESTS = re.compile(
    r"^ *# sphinx_gallery_start_ignore\n.*?^ *# sphinx_gallery_end_ignore\n", re.M | re.S
)
"""What a reader does not see: the numbers of a tutorial are tested where they stand."""


def notebooks() -> Mapping[str, str]:
    """The notebooks by the names of their files, as JSON of Jupyter's format 4.5."""
    folder = resources.files("rigid") / "builtin" / "tutorials"
    names = sorted(one.name for one in folder.iterdir() if one.name.endswith(".py"))
    return {
        f"{name.removeprefix('plot_').removesuffix('.py')}.ipynb": notebook(
            (folder / name).read_text(encoding="utf-8")
        )
        for name in names
    }


def notebook(script: str) -> str:
    """A script as a notebook."""
    tree = ast.parse(script)
    first = tree.body[0]
    cells = [_cell("markdown", markdown(ast.get_docstring(tree) or ""))]
    rest = "".join(script.splitlines(keepends=True)[first.end_lineno :])
    begin, *blocks = re.split(r"^# %%\n", rest, flags=re.M)
    cells.append(_cell("code", _TESTS.sub("", begin)))
    for block in blocks:
        text, code = re.findall(r"\A((?:#[^\n]*\n)*)(.*)\Z", block, re.DOTALL)[0]
        if text:
            cells.append(_cell("markdown", markdown(re.sub(r"^# ?", "", text, flags=re.M))))
        cells.append(_cell("code", _TESTS.sub("", code)))
    kept = [cell for cell in cells if cell["source"]]
    for number, cell in enumerate(kept):
        cell["id"] = f"cell-{number}"
    kernel = {"name": "python3", "display_name": "Python 3", "language": "python"}
    content = {
        "cells": kept,
        "metadata": {"kernelspec": kernel, "rigid": _core.__version__},
        "nbformat": 4,
        "nbformat_minor": 5,
    }
    return json.dumps(content, indent=1, ensure_ascii=False) + "\n"


def markdown(text: str) -> str:
    """Text of a tutorial in Markdown: headings, formulas, links and names of code."""
    text = re.sub(r"^(.+)\n=+$", r"# \1", text, flags=re.M)
    text = re.sub(r"^(.+)\n--+$", r"## \1", text, flags=re.M)
    text = re.sub(r":doc:`([^<`]+?) <[^`]+>`", r"\1", text)
    text = re.sub(r":(?:doc|func):`~?([^`]+)`", r"`\1`", text)
    text = re.sub(r"^\.\. math:: (.+)$", r"$$\1$$", text, flags=re.M)
    text = re.sub(r":math:`([^`]+)`", lambda found: f"${' '.join(found[1].split())}$", text)
    return re.sub(r"``([^`]+)``", r"`\1`", text)


def _cell(kind: str, source: str) -> dict[str, Any]:
    """A cell of a notebook, with its lines."""
    cell: dict[str, Any] = {
        "cell_type": kind,
        "metadata": {},
        "source": source.strip("\n").splitlines(keepends=True),
    }
    return cell if kind == "markdown" else {**cell, "execution_count": None, "outputs": []}
