"""The three turns of Euler's angles, one by one."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._checks.arguments import vector
from ..drawing import colours
from ..drawing.axes3d import arc, arrow_in_plane, curve, fit, label, triad
from ..rotations.euler import euler_to_matrix, rotation_z
from .picture import Kind, Picture

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class EulerSteps(Picture):
    """The three turns of Euler's angles.

    Attributes
    ----------
    angles : ndarray, shape (3,)
        ``phi, theta, psi`` (rad).
    axes : ndarray, shape (4, 3, 3)
        Unit vectors along the axes, as rows, before the first turn and after each turn, with
        components in space.
    turned_about : ndarray, shape (3, 3)
        Unit vectors along the axes of the turns: the vertical, the line of nodes, body axis z.
    point, seen : ndarray, shape (2,)
        Coordinates of a point in the plane of the first turn, along the axes before and after it.
    """

    _columns: ClassVar[int | None] = 2

    angles: Floats
    axes: Floats
    turned_about: Floats
    point: Floats
    seen: Floats

    def _kinds(self) -> list[Kind]:
        return ["space", "space", "space", "plane"]

    def _draw(self, *panels: Any) -> None:
        *spaces, plane = panels
        for step, ax in enumerate(spaces):
            kept = 0 if step == 1 else 2
            old, new = ([f"${name}$" for name in _NAMES[k]] for k in (step, step + 1))
            new[kept] = f"{old[kept][:-1]} = {new[kept][1:]}"
            old[kept] = ""
            origin = np.zeros(3)
            dashed: dict[str, Any] = {"linewidth": 1.0, "linestyle": "dashed"}
            triad(ax, self.axes[step], origin, old, gid="axes", **dashed)
            triad(ax, self.axes[step + 1], origin, new, linewidth=2.4, gid="axes")
            # Beyond the tip of axis 1 is its name.
            node = self.turned_about[1] * np.array([[-0.4], [1.0], [np.nan], [1.35], [1.6]])
            dashdot: dict[str, Any] = {"linewidth": 1.2, "linestyle": "dashdot", "zorder": 3}
            curve(ax, node, colours.NODE.colour, gid="node", **dashdot)
            turned = [axis for axis in range(3) if axis != kept]
            for axis, radius in zip(turned, (0.55, 0.7), strict=True):
                arc(
                    ax,
                    self.turned_about[step],
                    radius * self.axes[step, axis],
                    float(self.angles[step]),
                    colours.ANGLE.colour,
                    TURNS[step],
                )
            label(ax, 1.72 * self.turned_about[1], "$N$", colours.NODE.colour)
            ax.set_title(f"{step + 1}.  {TURNS[step]} {_ABOUT[step]}", fontsize="medium")
            fit(ax, self.axes, node[[0, -1]], elev=24.0, azim=azimuth(self.angles[0]), filled=0.8)
        _draw_turned_plane(plane, self)


def euler_steps(angles: ArrayLike, *, point: ArrayLike = (0.35, 0.85)) -> EulerSteps:
    """The three turns of Euler's angles one by one, and the first turn in its plane.

    The turns are by phi about the vertical, by theta about the line of nodes ``x'' = X``, and by
    psi about ``Z = z``; dashed lines are the axes before a turn. In the plane of the first turn
    ``x'' = x' cos phi + y' sin phi`` and ``y'' = y' cos phi - x' sin phi`` (Ercan 2016, figs. 2-5,
    eq. (1) with y'' in the second line, erratum D-03; lecture notes, fig. 5.2).

    Parameters
    ----------
    angles : array_like, shape (3,)
        ``phi, theta, psi`` (rad).
    point : array_like, shape (2,)
        A point of the plane ``x' y'``.

    Returns
    -------
    EulerSteps

    Raises
    ------
    ValueError
        If an argument is not finite or has the wrong shape.

    Examples
    --------
    >>> import numpy as np
    >>> from rigid import figures
    >>> data = figures.euler_steps([np.pi / 2, 0.3, 0.0], point=[0.0, 2.0])
    >>> data.seen.round(12).tolist(), data.turned_about[1].round(12).tolist()
    ([2.0, 0.0], [0.0, 1.0, 0.0])
    """
    phi, theta, psi = vector("angles", angles, 3).tolist()
    steps = euler_to_matrix(
        [[0.0, 0.0, 0.0], [phi, 0.0, 0.0], [phi, theta, 0.0], [phi, theta, psi]]
    )
    axes = np.swapaxes(steps, -1, -2)
    seen_from = vector("point", point, 2)
    return EulerSteps(
        angles=np.array([phi, theta, psi]),
        axes=axes,
        turned_about=np.stack([axes[0, 2], axes[1, 0], axes[2, 2]]),
        point=seen_from,
        seen=(rotation_z(phi, passive=True) @ np.append(seen_from, 0.0))[:2],
    )


_NAMES = (
    ("x'", "y'", "z'"),
    ("x''", "y''", "z''"),
    ("X", "Y", "Z"),
    ("x", "y", "z"),
)
TURNS = (r"$\phi$", r"$\theta$", r"$\psi$")
_ABOUT = ("about $z'$", "about the line of nodes", "about $z$")


def _draw_turned_plane(ax: Any, data: EulerSteps) -> None:
    """The plane of the first turn, with the coordinates of a point along both pairs of axes."""
    longest = max(1.0, 1.15 * float(np.linalg.norm(data.point)))
    for step, names, style in (
        (0, _NAMES[0], {"linewidth": 1.0, "linestyle": "dashed"}),
        (1, _NAMES[1], {"linewidth": 2.4}),
    ):
        for axis, ink in enumerate(colours.AXES[:2]):
            along = longest * data.axes[step, axis, :2]
            arrow_in_plane(ax, along, ink.colour, f"${names[axis]}$", **style)
            foot = (data.point, data.seen)[step][axis] * data.axes[step, axis, :2]
            curve(ax, np.array([data.point, foot]), ink.colour, linewidth=0.9, linestyle="dotted")
    turned = np.linspace(0.0, data.angles[0], 49)[:, np.newaxis]
    curve(
        ax,
        0.35 * longest * np.hstack([np.cos(turned), np.sin(turned)]),
        colours.ANGLE.colour,
    )
    half = 0.5 * data.angles[0]
    label(ax, 0.44 * longest * np.array([np.cos(half), np.sin(half)]), TURNS[0])
    arrow_in_plane(ax, data.point, colours.HUES["black"], "$P$", linewidth=1.6, gid="point")
    corners = np.vstack([np.zeros((1, 2)), longest * data.axes[:2, :2, :2].reshape(-1, 2)])
    low, high = corners.min(axis=0), corners.max(axis=0)
    margin = 0.14 * longest
    ax.set_aspect("equal", anchor="N")  # its title as high as the titles of the other panels
    ax.set(
        xlim=(low[0] - margin, high[0] + margin),
        ylim=(low[1] - margin, high[1] + margin),
        title="the first turn seen from $z'$",
    )
    ax.title.set_fontsize("medium")
    ax.set_axis_off()


def azimuth(phi: float) -> float:
    """Azimuth of the view (degrees): between the first axis of space and the line of nodes."""
    return float(np.degrees(0.5 * phi)) - 16.0  # aside, so that it does not hide body axis z
