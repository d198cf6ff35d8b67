"""All polhodes of one energy, on one ellipsoid."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import exact, free
from .._checks.arguments import brief, positive_int
from ..drawing import colours
from ..drawing.axes3d import UP, arrow, curve, fit, label
from ..drawing.shapes import ellipsoid_faces
from ..drawing.sides import sides, surface
from ..model.body_like import BodyLike, moments_of
from ..model.scene import FreeBody, require_unforced
from ..solve.run import Run, scene_of, states_of
from .picture import Picture

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Polhodes(Picture):
    """Polhodes of one energy on the inertia ellipsoid.

    Attributes
    ----------
    moments : ndarray, shape (3,)
        Moments of the body (kg m²).
    semi_axes : ndarray, shape (3,)
        Semi-axes of the ellipsoid ``omega·I omega = 2 E`` (rad/s).
    curves : ndarray, shape (4 n, m, 3)
        Closed polhodes (rad/s).
    axis : ndarray of int8, shape (4 n,)
        The axis 1, 2 or 3 that each polhode encircles, with the sign of the rate about this axis.
    separatrix : ndarray, shape (2, m, 3)
        The two ellipses through the ends of the middle axis, which separate the polhodes.
    path : ndarray, shape (k, 3), or None
        The path of a run on the same ellipsoid.
    """

    moments: Floats
    semi_axes: Floats
    curves: Floats
    axis: NDArray[np.int8]
    separatrix: Floats
    path: Floats | None = None

    def _draw(self, ax: Any) -> None:
        order = np.argsort(self.moments)
        towards = np.empty(3)
        towards[order] = 0.42, 1.0, 0.4  # the middle axis points to the viewer
        towards /= np.linalg.norm(towards)
        elev = float(np.degrees(np.arcsin(towards[2])))
        azim = float(np.degrees(np.arctan2(towards[1], towards[0])))
        faces = ellipsoid_faces(self.semi_axes, rings=30, sectors=60)
        surface(ax, faces, colours.SURFACE, towards, gid="ellipsoid")
        for points, axis in zip(self.curves, self.axis, strict=True):
            colour = colours.AXES[abs(int(axis)) - 1].colour
            near, far = sides(points, self.moments * points, towards)
            curve(ax, near, colour, linewidth=1.5, zorder=4, gid="curves")
            curve(ax, far, colour, linewidth=0.7, alpha=0.35, zorder=2, gid="curves_hidden")
        black, purple = colours.HUES["black"], colours.OMEGA.colour
        for ellipse in self.separatrix:
            near, far = sides(ellipse, self.moments * ellipse, towards)
            curve(ax, near, black, linewidth=2.0, zorder=5, gid="separatrix")
            curve(ax, far, black, linewidth=0.8, alpha=0.35, zorder=2, gid="separatrix_hidden")
        if self.path is not None:
            near, far = sides(self.path, self.moments * self.path, towards)
            curve(ax, near, purple, linewidth=3.0, zorder=5.5, gid="path")
            curve(ax, far, purple, linewidth=1.5, alpha=0.5, zorder=2, gid="path_hidden")
        names = {int(order[0]): "least", int(order[1]): "middle", int(order[2]): "largest"}
        length = np.full(3, 0.3)
        length[order[1]] = 1.1  # foreshortened
        tips = np.diag(self.semi_axes + length)
        for k, ink in enumerate(colours.AXES):
            start = np.diag(self.semi_axes)[k]
            along = tips[k] - start
            arrow(ax, along, ink.colour, start=start, linewidth=1.6, zorder=6, gid="axes")
            words = f"{k + 1}: {names[k]} moment"
            sideways = float(np.cross(UP, towards)[k])
            align = "left" if sideways > 0.1 else "right" if sideways < -0.1 else "center"
            label(ax, tips[k] + 0.1 * np.eye(3)[k], words, ink.colour, fontsize="medium", ha=align)
        fit(ax, faces, 1.05 * tips, elev=elev, azim=azim, filled=0.62)


def polhodes(body: BodyLike | Run, *, count: int = 5, samples: int = 361) -> Polhodes:
    """The polhodes of one energy on the inertia ellipsoid, with the separatrix.

    Polhodes encircle the axes of the largest and of the smallest moment: rotations about these axes
    are stable. No polhode encircles the middle axis, and a small disturbance of a rotation about it
    grows until the body has turned over (Landau and Lifshitz, *Mechanics*, § 37, fig. 51).

    Parameters
    ----------
    body : Body, FreeBody, Run or array_like, shape (3,)
        A body with three different moments; or a run of one, without torque and damping, whose own
        polhode then is the ``path``.
    count : int
        Number of polhodes around each end of the axes of the smallest and of the largest moment.
    samples : int
        Number of points of each curve; the first and the last point coincide.

    Returns
    -------
    Polhodes
        The energy is such that the largest semi-axis is 1 rad/s.

    Raises
    ------
    ValueError
        If no body has the moments, or two of them are equal; if a run has several bodies, is at
        rest or under torque or damping.

    Examples
    --------
    >>> from rigid import figures
    >>> data = figures.polhodes((1.0, 2.0, 3.0))
    >>> data.curves.shape, sorted(set(data.axis.tolist()))
    ((20, 361, 3), [-3, -1, 1, 3])
    """
    path = None
    if isinstance(body, Run):
        path, body = _path_of(body)
    moments = moments_of(body)
    if moments.shape != (3,) or len(set(moments.tolist())) < 3:
        raise ValueError(
            f"moments = {moments.tolist()}: polhodes of both kinds need three different moments"
        )
    number = positive_int("count", count)
    points = positive_int("samples", samples, minimum=2)
    small, middle, large = order = np.argsort(moments)
    semi = np.sqrt(moments[small] / moments)
    # Start on the ellipse in the plane of the first and the third axis, where the angle between
    # the separatrix and the axis of the smallest moment is known.
    i1, i2, i3 = moments[order]
    slope = np.sqrt(i1 * (i2 - i1) / (i3 * (i3 - i2)))
    parting = np.arctan2(slope * semi[small], semi[large])
    share = np.arange(1, number + 1) / (number + 1.0)
    angle = np.concatenate([share * parting, parting + share * (0.5 * np.pi - parting)])
    starts = np.zeros((2 * number, 3))
    starts[:, small], starts[:, large] = semi[small] * np.cos(angle), semi[large] * np.sin(angle)
    known = free.asymmetric_free_top(moments, starts)
    turn = np.linspace(0.0, 1.0, points)
    quarter = 0.5 * np.pi / exact.agm(1.0, np.sqrt(known.mc))
    sn, cn, dn = exact.jacobi(4.0 * quarter[:, np.newaxis] * turn, known.mc[:, np.newaxis])
    around_small = (np.abs(known.axis) == small + 1)[:, np.newaxis]
    curves = np.empty((2 * number, points, 3))
    curves[..., small] = np.where(around_small, dn, cn)
    curves[..., middle] = sn
    curves[..., large] = np.where(around_small, cn, dn)
    curves *= known.amplitude[:, np.newaxis, :]
    phase = 2.0 * np.pi * turn
    separatrix = np.empty((2, points, 3))
    for side, ellipse in zip((1.0, -1.0), separatrix, strict=True):
        ellipse[:, small] = semi[small] * np.cos(parting) * np.cos(phase)
        ellipse[:, large] = side * semi[large] * np.sin(parting) * np.cos(phase)
        ellipse[:, middle] = semi[middle] * np.sin(phase)
    return Polhodes(
        moments=moments,
        semi_axes=semi,
        curves=np.concatenate([curves, -curves]),
        axis=np.concatenate([known.axis, -known.axis]),
        separatrix=separatrix,
        path=path,
    )


def _path_of(run: Run) -> tuple[Floats, FreeBody]:
    """The rates of a run on the ellipsoid whose largest semi-axis is 1 rad/s, and its scene."""
    scene = scene_of(run)
    if not isinstance(scene, FreeBody):
        raise TypeError(
            f"scene = {brief(scene)}: must be a rigid.FreeBody, whose rates follow polhodes"
        )
    require_unforced(scene, "a polhode")
    (omega,) = states_of(run, names=["omega"])
    moments = np.array(scene.body.moments)
    size = np.sqrt((omega[0] ** 2 * moments).sum() / moments.min())
    if size == 0.0:
        raise ValueError("omega = [0, 0, 0]: a body at rest has no polhode")
    return omega / size, scene
