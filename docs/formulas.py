"""Formulas as MathML, written when the site is built: a page needs no script to show them."""

from __future__ import annotations

import re
from typing import Any

from docutils import nodes
from latex2mathml.converter import convert
from sphinx.application import Sphinx
from sphinx.util import logging

_log = logging.getLogger(__name__)


# What browsers space otherwise than TeX: bars and slashes, and a function before its argument.
_SPACED = (
    (r"<mo(?=[^>]*>(?:&#x0007C;|&#x0002F;)<)", '<mo lspace="0" rspace="0"'),
    (r"(<mi>(?:cos|exp|ln|sin|tan)</mi>)(?=<mi>|<msub>)", r'\1<mspace width="0.167em"/>'),
)


def mathml(tex: str, display: str) -> str:
    """A formula for a page; ValueError for a command that the converter does not know."""
    written = convert(tex.replace("{aligned}", "{split}"), display=display)
    unknown = re.search(r"\\\w+|<mi>&</mi>", written)
    if unknown:
        raise ValueError(f"{unknown[0]} has no MathML")
    for found, better in _SPACED:
        written = re.sub(found, better, written)
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
