"""The pages of rigid: ``sphinx-build -W -b html docs out``."""

from itertools import groupby
from pathlib import Path

import rigid
from rigid.maps.parameters import PARAMETERS

project = "rigid"
author = "The rigid developers"
copyright = author  # noqa: A001
release = version = rigid.__version__

extensions = [
    "myst_parser",
    "numpydoc",
    "sphinx.ext.autodoc",
    "sphinx.ext.mathjax",
    "sphinx_gallery.gen_gallery",
]
exclude_patterns = ["gallery/*", "_build"]
html_theme = "furo"
html_title = f"rigid {release}"

myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 3

autodoc_member_order = "bysource"
autodoc_typehints = "none"  # the docstrings say what goes in
numpydoc_show_class_members = False  # members are described where they are

sphinx_gallery_conf = {
    "examples_dirs": "gallery",
    "gallery_dirs": "figures",
    "filename_pattern": r"/plot_",
    "within_subsection_order": "FileNameSortKey",
    "abort_on_example_error": True,
    "download_all_examples": False,
    "show_signature": False,
    "remove_config_comments": True,
}


def write_map_parameters(path: Path) -> None:
    """Write the table of ``maps.md``: a row for the parameters of one meaning."""
    lines = ["| names | unit | meaning |", "|---|---|---|"]
    words = {name: (p.unit, p.meaning.rstrip(" 123")) for name, p in PARAMETERS.items()}
    for (unit, meaning), names in groupby(words, key=words.__getitem__):
        listed = ", ".join(f"`{name}`" for name in names)
        lines.append(f"| {listed} | {'' if unit == '1' else unit} | {meaning} |")
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


write_map_parameters(Path(__file__).with_name("map_parameters.txt"))
