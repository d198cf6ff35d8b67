"""Pictures for the dark theme: beside NAME.png stands NAME-dark.png, or one is made of NAME.png."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from docutils import nodes
from numpy.typing import NDArray
from PIL import Image
from sphinx.application import Sphinx
from sphinx_gallery.directives import imgsgnode

GROUND = np.array([0x13, 0x14, 0x16], dtype=np.float32) / 255
"""The colour of dark pages."""

MAP, STRONG = 0.2, 0.3
"""A picture is a map if such a share of it has a difference of its components above STRONG."""


def darkened(rgb: NDArray[np.float32]) -> NDArray[np.float32]:
    """The picture on dark ground: light and dark change places, hues and strong colours stay.

    The colours of a map have a meaning, so that only greys change there.
    """
    most, least = rgb.max(-1, keepdims=True), rgb.min(-1, keepdims=True)
    chroma = most - least
    stays = 0.1 if (chroma > STRONG).mean() > MAP else 0.4
    changed = np.clip(2.0 - 2.0 * chroma / stays, 0.0, 1.0)
    turned = GROUND + (0.92 - GROUND) * (rgb + 1.0 - most - least)
    return changed * turned + (1.0 - changed) * rgb


def twin(docs: Path, picture: Path) -> str:
    """The dark twin of a picture, from the root of the pages."""
    drawn = picture.with_name(f"{picture.stem}-dark{picture.suffix}")
    if not drawn.is_file():
        folder = docs / "generated" / "dark"
        folder.mkdir(parents=True, exist_ok=True)
        drawn = folder / "-".join(picture.relative_to(docs).parts)
        if not drawn.is_file() or drawn.stat().st_mtime < picture.stat().st_mtime:
            rgb = np.asarray(Image.open(picture).convert("RGB"), dtype=np.float32) / 255
            Image.fromarray((255 * darkened(rgb)).round().astype(np.uint8)).save(drawn)
    return f"/{drawn.relative_to(docs).as_posix()}"


def show_twins(app: Sphinx, doctree: nodes.document) -> None:
    """Show each picture in the light theme and its twin in the dark one."""
    docs = Path(app.srcdir)
    page = Path(app.env.doc2path(app.env.docname)).parent

    def dark_name(uri: str) -> str:
        return twin(docs, docs / uri[1:] if uri.startswith("/") else (page / uri).resolve())

    for light in [*doctree.findall(nodes.image), *doctree.findall(imgsgnode)]:
        if not light["uri"].endswith(".png"):
            continue
        dark = light.deepcopy()
        dark["uri"] = dark_name(light["uri"])
        if light.get("srcset"):  # of the gallery: NAME, NAME 2x
            names = [part.split() for part in light["srcset"].split(",")]
            dark["srcset"] = ", ".join(" ".join([dark_name(uri), *size]) for uri, *size in names)
        for node, theme in ((light, "only-light"), (dark, "only-dark")):
            if isinstance(node, imgsgnode):
                node["class"] = [" ".join([*(node["class"] or []), theme])]
            else:
                node["classes"] = [*node["classes"], theme]
        light.parent.insert(light.parent.index(light) + 1, dark)


def setup(app: Sphinx) -> dict[str, bool]:
    """Before Sphinx collects the pictures of a page."""
    app.connect("doctree-read", show_twins, priority=400)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
