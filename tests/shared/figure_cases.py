"""Motions that figures show, and what is read from a drawn figure."""

from io import BytesIO
from typing import Any

import numpy as np
from numpy.typing import NDArray

import rigid
from rigid import figures

Floats = NDArray[np.float64]

TOP = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)
TILTED = [np.cos(np.pi / 6), np.sin(np.pi / 6), 0.0, 0.0]
SIN60 = np.sin(np.pi / 3)
ASYMMETRIC = rigid.HeavyTop(rigid.Body((1.0, 1.5, 0.6)), mgl=1.0)
DAMPED = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0, damping=(0.0, 0.0, 0.1))
BODY = rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0)))

# Starts at 60 degrees: rate of precession, spin, and the roots of f to the digits of the tables.
STARTS = {
    "cusp": (0.0, 5.0, 0.191767987534, 0.5, 2.93323201247),
    "loop": (-0.3, 5.0, -0.00533329827606, 0.5, 3.16408329828),
    "monotone": (0.2, 5.0, 0.331089188037, 0.5, 2.80891081196),
    "monotone from below": (0.6, 5.0, 0.5, 0.611717131638, 2.64828286836),
    "loop from below": (1.5, 5.0, 0.5, 0.992095230668, 2.97665476933),
    "monotone retrograde": (-4.0, 1.0, -0.786708522541, 0.5, 6.91170852254),
}


def omega_of(name: str) -> list[float]:
    push, spin = STARTS[name][:2]
    return [0.0, push * SIN60, spin]


def drawn(figure: figures.Picture) -> Any:
    """The axes of a figure, which is drawn; a warning is an error."""
    axes = figure.plot()
    first = axes[0] if isinstance(axes, tuple) else axes
    first.figure.savefig(BytesIO(), format="png", dpi=40)
    return axes


def artists(axes: Any, name: str) -> list[Any]:
    """The artists of this name on axes, or on each of several."""
    panels = axes if isinstance(axes, tuple) else (axes,)
    return [one for ax in panels for one in ax.findobj(lambda one: one.get_gid() == name)]


def artist(axes: Any, name: str) -> Any:
    """The only artist of this name."""
    (one,) = artists(axes, name)
    return one


def data_of(line: Any) -> Floats:
    """What a line in a plane or in space carries, shape (m, 2) or (m, 3)."""
    got = line.get_data_3d() if hasattr(line, "get_data_3d") else line.get_data()
    return np.stack([np.asarray(part, dtype=float) for part in got], axis=1)


def joined(ax: Any, name: str) -> Floats:
    """The curves of this name, each from its two sides."""
    seen = np.array([data_of(line) for line in artists(ax, name)])
    behind = np.array([data_of(line) for line in artists(ax, f"{name}_hidden")])
    assert (np.isnan(seen) != np.isnan(behind)).all()
    return np.where(np.isnan(seen), behind, seen)


def texts(ax: Any) -> list[str]:
    return [text.get_text() for text in ax.texts]


def poinsot_run(m: int = 1201) -> Any:
    body = rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0)))
    return rigid.simulate(body, [1.1, 0.3, 0.4], [0.5, 0.5, 0.1, 0.7], t=np.linspace(0, 15, m))
