"""Compute the built-in maps and draw them: ``python docs/images/maps.py [NAME ...]``.

Without names all maps that have a picture here are computed, which takes some minutes.
"""

import sys
from functools import partial

from matplotlib.figure import Figure
from matplotlib.patheffects import Normal, Stroke
from twins import save_twins

import rigid
from rigid.cli.toml_map import read_spec
from rigid.store.call import run_map

MAPS = (
    *("thrown-box", "inertia-triangle", "sleeping-top", "falling-top", "gravity-gradient"),
    *("tumbling-debris", "apophis", "dimorphos", "hyperion", "spin-orbit"),
)

REGIONS = {
    "thrown-box": (
        ("has turned over", 0.07, 0.15, 0.0),
        ("lands as thrown", 0.16, 1.5e-3, 0.0),
        ("b = 8 cm", 0.074, 3e-4, 90.0),
    ),
    "gravity-gradient": (
        ("Lagrange", 0.4, 0.9, 0.0),
        ("DeBra and Delp", 1.06, 1.6, 90.0),
        ("unstable in\nroll or yaw", 0.63, 1.3, 0.0),
        ("unstable in\nroll or yaw", 1.75, 1.25, 0.0),
    ),
}
"""Names of the regions of a map, with their places and angles (degrees)."""

BODY = {"thrown-box": 0.08}
"""The side of the box that the pages throw."""


def drawn(result: rigid.StabilityMap, name: str) -> Figure:
    """The picture of a map, with the names of its regions and the body of the pages."""
    ax = result.plot()
    if name in BODY:
        ax.axvline(BODY[name], color="black", linewidth=1.0, linestyle="dotted")
    for words, x, y, angle in REGIONS.get(name, ()):
        text = ax.text(x, y, words, color="white", ha="center", va="center", rotation=angle)
        text.set_path_effects([Stroke(linewidth=3.0, foreground="black"), Normal()])
    return ax.figure


def main(names: list[str]) -> None:
    """Write the pictures of these maps beside this file."""
    for name in names or MAPS:
        result = run_map(read_spec(name).spec)
        save_twins(name, partial(drawn, result, name))


if __name__ == "__main__":
    main(sys.argv[1:])
