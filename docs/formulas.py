"""Formulas as MathML, written when the site is built: a page needs no script to show them."""

from __future__ import annotations

import re
from typing import Any

from docutils import nodes
from latex2mathml.converter import convert
from sphinx.application import Sphinx
from sphinx.util import logging

_log = logging.getLogger(__name__)


def mathml(tex: str, display: str) -> str:
    """A formula for a page; ValueError for a command that the converter does not know."""
    written = convert(tex, display=display)
    unknown = re.search(r"\\\w+", written)
    if unknown:
        raise ValueError(f"{unknown[0]} has no MathML")
    return written


def _append(self: Any, node: nodes.Element, display: str) -> None:
    try:
        self.body.append(mathml(node.astext(), display))
    except Exception as error:  # each error of the converter is a fault of the formula
        _log.warning("formula %r: %s", node.astext(), error, location=node)


def _inline(self: Any, node: nodes.Element) -> None:
    _append(self, node, "inline")
    raise nodes.SkipNode


def _displayed(self: Any, node: nodes.Element) -> None:
    self.body.append(self.starttag(node, "div", CLASS="formula"))
    _append(self, node, "block")
    self.body.append("</div>")
    raise nodes.SkipNode


def setup(app: Sphinx) -> dict[str, bool]:
    """Make this the renderer of formulas."""
    app.add_html_math_renderer("mathml", (_inline, None), (_displayed, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
