"""Pictures for the dark theme: beside NAME.png stands NAME-dark.png, or one is made of NAME.png."""

from __future__ import annotations

from functools import reduce
from pathlib import Path
from typing import TYPE_CHECKING

from PIL import Image, ImageChops

from rigid.drawing.colours import DARK

if TYPE_CHECKING:
    from docutils import nodes
    from sphinx.application import Sphinx

GROUND, INK, LIFT = tuple(bytes.fromhex(DARK[1:])), 0xEB, 0.8
"""The colour of dark pages, how bright black becomes, and a power below 1, which brightens."""

MAP, STRONG, GREY = 0.2, 77, 4
"""A picture is a map if such a share of it has a difference of its components from STRONG on.

In a map only what has a smaller difference than GREY changes.
"""

MIDDLE = range(0x6A, 0x80)
"""Greys that stay in a map: the colour map is grey in its middle, and these greys change little."""


def darkened(picture: Image.Image) -> Image.Image:
    """The picture on dark ground: light and dark change places, and hues stay.

    The colours of a map have a meaning, so that only greys change there.
    """
    bands = picture.split()
    most, least = (reduce(pick, bands) for pick in (ImageChops.lighter, ImageChops.darker))
    turned = Image.merge(
        "RGB",
        [
            ImageChops.add(ImageChops.invert(most), ImageChops.subtract(band, least)).point(
                [ground + round((INK - ground) * (c / 255) ** LIFT) for c in range(256)]
            )
            for band, ground in zip(bands, GROUND, strict=True)
        ],
    )
    chroma = ImageChops.subtract(most, least)
    counts = chroma.histogram()
    if sum(counts[STRONG:]) <= MAP * sum(counts):
        return turned
    changes = chroma.point([min(255, max(0, 510 - 510 * c // GREY)) for c in range(256)])
    changes = ImageChops.darker(changes, most.point([255 * (c not in MIDDLE) for c in range(256)]))
    return Image.composite(turned, picture, changes)


def twin(docs: Path, picture: Path) -> str:
    """The dark twin of a picture, from the root of the pages."""
    drawn = picture.with_name(f"{picture.stem}-dark{picture.suffix}")
    if not drawn.is_file():
        folder = docs / "generated" / "dark"
        folder.mkdir(parents=True, exist_ok=True)
        drawn = folder / "-".join(picture.relative_to(docs).parts)
        if not drawn.is_file() or drawn.stat().st_mtime < picture.stat().st_mtime:
            darkened(Image.open(picture).convert("RGB")).save(drawn)
    return f"/{drawn.relative_to(docs).as_posix()}"


def show_twins(app: Sphinx, doctree: nodes.document) -> None:
    """Show each picture in the light theme and its twin in the dark one."""
    from docutils import nodes
    from sphinx_gallery.directives import imgsgnode

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
