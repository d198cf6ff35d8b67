"""What readers search for, and the page that they want to find first.

Sphinx searches its index before titles, names and texts. ``page_hooks.py`` puts these terms into
the index when it reads a page; ``check_site.py`` searches for each of them on the built site.
"""

TERMS = {
    "installation": ("install", "pip", "citation"),
    "quickstart": ("first steps", "thrown box"),
    "bodies": ("inertia tensor", "mesh", "stl", "measurements", "gyroscope"),
    "runs": ("csv", "gif", "events", "animation"),
    "forces": ("gravity gradient", "numba", "damping", "torque", "satellite"),
    "maps": ("stability map", "explorer", "criterion", "monte carlo"),
    "large_maps": ("resume", "dask", "cluster"),
    "chaos": ("chaos", "lyapunov exponent", "megno"),
    "methods": ("accuracy", "integrator", "closed form", "step size"),
    "maps_reference": ("toml", "command line", "axes"),
    "notation": ("euler angles", "quaternion order", "units", "conventions", "glossary"),
    "reliability": ("error", "validation", "reproducible"),
    "figures/index": ("built-in maps", "gallery"),
    "tutorial_pages/plot_3_toutatis": ("toutatis",),
    "tutorial_pages/plot_4_hyperion": ("hyperion",),
    "tutorial_pages/plot_5_dimorphos": ("dimorphos",),
    "tutorial_pages/plot_6_apophis": ("apophis",),
    "tutorial_pages/plot_7_detumbling": ("b-dot", "detumbling"),
}
"""Terms by page."""
