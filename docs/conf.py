"""The pages of rigid: ``sphinx-build -W -b html docs out``."""

import sys
from pathlib import Path

import rigid

sys.path.insert(0, str(Path(__file__).parent))

from generated_pages import write_generated_pages

project = "rigid"
author = "The rigid developers"
copyright = author  # noqa: A001
release = version = rigid.__version__

extensions = [
    "myst_parser",
    "numpydoc",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.viewcode",
    "sphinx_gallery.gen_gallery",
    "dark_pictures",
    "formulas",
    "page_hooks",
]
# For contributors, in the repository only: reasons, proofs, errata of books, how the core works.
exclude_patterns = [
    "decisions/*",
    "capabilities.md",
    "errata.md",
    "how_it_works.md",
    "gallery/*",
    "_build",
    "_templates",
    "generated/*",
    "api/generated/*.examples*",
]
templates_path = ["_templates"]
html_theme = "furo"
html_title = f"rigid {release}"
html_static_path = ["_static", "style"]
html_css_files = ["site.css"]
html_favicon = "style/favicon.svg"
html_js_files = [("films.js", {"defer": "defer"})]

myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 3

autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_typehints_format = "short"
autodoc_type_aliases = {"ArrayLike": "ArrayLike", "Floats": "Floats", "Scene": "Scene"}
python_maximum_signature_line_length = 88
autosummary_generate = True
numpydoc_show_class_members = False  # members are described where they are

# The subjects of the gallery, in the order of its page.
SUBJECTS = ["throws", "free_rotation", "heavy_top", "chaos", "methods", "rotations", "forces"]

sphinx_gallery_conf = {
    "examples_dirs": ["gallery", "../python/rigid/builtin/tutorials"],
    "gallery_dirs": ["figures", "tutorial_pages"],
    "filename_pattern": r"/plot_",
    "subsection_order": [f"gallery/{subject}" for subject in SUBJECTS],
    "within_subsection_order": "FileNameSortKey",
    "abort_on_example_error": True,
    "download_all_examples": False,
    "show_signature": False,
    "write_computation_times": False,
    "min_reported_time": 3600,
    "capture_repr": (),
    "remove_config_comments": True,
    "image_srcset": ["2x"],
    "backreferences_dir": "api/backreferences",
    "doc_module": ("rigid",),
}

write_generated_pages(Path(__file__).parent)
