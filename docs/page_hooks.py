"""What Sphinx does to the pages of rigid besides its own work."""

from __future__ import annotations

import re
from html import escape
from textwrap import shorten
from typing import Any

from docutils import nodes
from numpydoc.docscrape import ClassDoc
from search_terms import TERMS
from sphinx.application import Sphinx
from sphinx.ext.autosummary import autosummary_toc

WIDE = 3
"""Tables with so many columns become lists on a phone."""


DESCRIBED = 155
"""Characters of a description that search engines show."""


def put_into_index(app: Sphinx, page: str, source: list[str]) -> None:
    """Put what readers search for into the index of the site, at the title of its page."""
    entries = ", ".join(f"! {term}" for term in TERMS.get(page, ()))
    if not entries:
        return
    if app.env.doc2path(page).suffix == ".md":
        source[0] = re.sub(
            r"^# .*\n", rf"\g<0>\n```{{index}} {entries}\n```\n", source[0], count=1, flags=re.M
        )
    else:
        source[0] = f".. index:: {entries}\n\n{source[0]}"


def describe(
    app: Sphinx, page: str, template: str, context: dict[str, Any], doctree: nodes.document | None
) -> None:
    """Describe a page by its first sentences, for search engines and previews of links."""
    first = next(doctree.findall(nodes.paragraph), None) if doctree is not None else None
    if first is not None:
        words = " ".join(first.astext().split())
        short = shorten(words, DESCRIBED, placeholder=" …")
        context["metatags"] += f'<meta name="description" content="{escape(short)}">'


def name_cells(app: Sphinx, doctree: nodes.document) -> None:
    """Give cells of a wide table the head of their column: a phone shows it beside the cell.

    Names of tests are folded: they are longer than all the rest.
    """
    for table in doctree.findall(nodes.tgroup):
        if table["cols"] < WIDE:
            continue
        table.parent["classes"].append("wide")
        heads = [entry.astext() for entry in next(table.findall(nodes.thead))[0]]
        for row in next(table.findall(nodes.tbody)):
            for head, cell in list(zip(heads, row, strict=True))[1:]:
                if head in ("test", "tests"):
                    opened = f"<details><summary>{head}</summary>"
                    cell.insert(0, nodes.raw("", opened, format="html"))
                    cell.append(nodes.raw("", "</details>", format="html"))
                elif cell.astext():
                    cell.insert(0, nodes.container("", nodes.Text(head), classes=["column"]))


def tidy_signature(
    app: Sphinx, what: str, name: str, value: Any, options: object, args: str | None, result: str
) -> tuple[str, str] | None:
    """Write types and defaults as a user does; a class that users do not make has no arguments.

    The docstring of such a class names no parameters.
    """
    if what == "class" and not ClassDoc(value)["Parameters"]:
        return "", ""
    return None if args is None else (_as_written(args), _as_written(result or ""))


def _as_written(signature: str) -> str:
    for shown, written in (
        (r"<class '([\w.]+)'>", r"\1"),
        (r"TypeAliasForwardRef\('(\w+)'\)", r"\1"),
        (r"ndarray\[tuple\[Any, \.\.\.\], dtype\[(\w+)\]\]", r"NDArray[\1]"),
    ):
        signature = re.sub(shown, written, signature)
    return signature


def list_on_one_page(app: Sphinx, doctree: nodes.document) -> None:
    """Leave the functions of a module to the table of its page: they make every sidebar long."""
    for table in list(doctree.findall(autosummary_toc)):
        table.parent.remove(table)


def share_sidebar(
    app: Sphinx, page: str, template: str, context: dict[str, Any], doctree: object
) -> None:
    """Write the sidebar once for the pages of a folder that are not in it: it is the same."""
    if page not in app.env.metadata or "orphan" in app.env.metadata[page]:
        written, folder = context["toctree"], page.rpartition("/")[0]

        def toctree(**options: Any) -> str:
            if folder not in _SIDEBARS:
                _SIDEBARS[folder] = written(**options)
            return _SIDEBARS[folder]

        context["toctree"] = toctree


_SIDEBARS: dict[str, str] = {}


def setup(app: Sphinx) -> dict[str, bool]:
    """Before Sphinx collects the entries of tables of contents, and before numpydoc."""
    app.connect("source-read", put_into_index)
    app.connect("doctree-read", name_cells)
    app.connect("doctree-read", list_on_one_page, priority=400)
    app.connect("html-page-context", share_sidebar, priority=400)
    app.connect("html-page-context", describe)
    app.connect("autodoc-process-signature", tidy_signature, priority=400)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
