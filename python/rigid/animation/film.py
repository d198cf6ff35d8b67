"""Films: the parts of an animated scene, and the attitudes that move the parts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._checks.arguments import brief, finite_float, one_of, one_time, shaped
from .._checks.arrays import Floats, attitudes, of_size_one
from .._checks.moments import refuse_rods, rods, symmetry_axis
from .._checks.quantities import plain
from ..drawing import colours
from ..drawing.shapes import (
    STEM,
    across,
    box_faces,
    cone_faces,
    ellipsoid_faces,
    plane_face,
    top_faces,
)
from ..rotations.apply import to_space
from .story import Recording, story_of, tilt_of

VIEWS = ("box", "cones", "poinsot")
"""Views of a free body; a heavy top has one, ``"top"``."""

LONGEST = 20.0
"""Time (s) in which a longer motion is shown, if no speed is given; so does the explorer."""

PLANET, BALL = 2.0, 0.09
"""Where a planet is drawn, and its radius as a share of the reach: no more than a direction."""

UP = np.array([0.0, 0.0, 1.0])

AXES = tuple(ink.colour for ink in colours.AXES)
BODY, SPACE = colours.FACE, colours.SPACE.colour


@dataclass(frozen=True, slots=True, eq=False)
class Part:
    """A part of the drawing.

    Attributes
    ----------
    kind : {"faces", "line", "trail", "arrow", "dot", "planet"}
        Polygons; a curve; a curve up to the point of the frame; an arrow from the origin; a point;
        a planet at the end of a line from the origin.
    points : ndarray
        Shape (faces, corners, 3) of polygons, (points, 3) of a curve, and (frames, 3) of a trail,
        an arrow, a dot or a planet, or (1, 3) if it is the same in all frames.
    colours : tuple of str
        Colours of the polygons, repeated in this order.
    opacity : float
        1 is opaque.
    carried : bool
        Whether the points are fixed in the body instead of in space.
    label : str
        Text at the tip of an arrow.
    meaning : str
        What it shows, for the legend.
    """

    kind: str
    points: Floats
    colours: tuple[str, ...]
    opacity: float = 1.0
    carried: bool = False
    label: str = ""
    meaning: str = ""

    def placed(self, attitude: Floats, frame: int, since: int = 0) -> Floats:
        """The points in space in a frame, from its attitude; trails from ``since``."""
        points = self.points
        if self.kind == "trail":
            points = points[since : frame + 1]
        elif self.kind in ("arrow", "dot", "planet"):
            points = points[frame : frame + 1] if len(points) > 1 else points
        return to_space(attitude, points) if self.carried else points


@dataclass(frozen=True, slots=True, eq=False)
class Chart:
    """A strip chart beside a film: some quantities against time.

    Attributes
    ----------
    label : str
        Quantity and unit.
    names, colours : tuple of str
        Name and colour of each curve.
    values : ndarray, shape (curves, frames)
        The values of each curve.
    """

    label: str
    names: tuple[str, ...]
    colours: tuple[str, ...]
    values: Floats


@dataclass(frozen=True, slots=True, eq=False)
class Polhode:
    """The direction of L in the body, and the separatrix on the sphere of directions.

    Attributes
    ----------
    points : ndarray, shape (frames, 3)
        Unit vectors along the principal axes.
    separatrix : tuple of ndarray, shape (n, 3)
        Great circles through the axis of the middle moment; none if two moments are equal.
    """

    points: Floats
    separatrix: tuple[Floats, ...]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Film:
    """The frames of an animation: one for each time of a run.

    Attributes
    ----------
    view : str
        One of :data:`VIEWS`, or ``"top"``.
    title : str
        The scene in words.
    story : str
        The motion in a sentence.
    name : str
        The rates at the first time, which tell the film from the one beside it.
    t : ndarray, shape (frames,)
        Times of the run (s).
    shown : ndarray, shape (frames,)
        Duration of each frame (s); the last two durations are equal.
    speed : float
        Factor by which the film is faster than the motion.
    attitude : ndarray, shape (frames, 4)
        Attitudes of the run.
    parts : tuple of Part
        Parts of the drawing, in units of a length that depends on the view.
    up : ndarray, shape (3,)
        Unit vector in space that points upward in the picture.
    centre : ndarray, shape (3,)
        The centre of the picture, on the line through the origin along ``up``.
    reach : float
        Largest distance of a point of any frame from the centre.
    trail : float
        Length of trails in seconds of the run; inf if they have no end.
    chart : Chart
        Rates of a free body, tilt of a top.
    polhode : Polhode or None
        Of a free body without torque and damping.
    grounded : bool
        Whether there is a ground under the origin: the body never reaches below it.
    """

    view: str
    title: str
    story: str
    name: str
    t: Floats
    shown: Floats
    speed: float
    attitude: Floats
    parts: tuple[Part, ...]
    up: Floats
    centre: Floats
    reach: float
    trail: float
    chart: Chart
    polhode: Polhode | None
    grounded: bool

    def trail_begin(self, frame: int) -> int:
        """Index of the oldest point of a trail that a frame shows."""
        if np.isinf(self.trail):
            return 0
        recent = np.abs(self.t[frame] - self.t[: frame + 1]) <= self.trail
        return int(recent.argmax())

    @property
    def digits(self) -> int:
        """Number of decimals at which the times of neighbouring frames differ."""
        steps = np.diff(self.t)
        shortest = steps[steps > 0.0].min(initial=1.0)
        return int(np.ceil(-np.log10(shortest) - 1e-9))


def film_of(
    one: Recording,
    *,
    view: str | None = None,
    speed: float | None = None,
    trail: float | None = None,
    shape: tuple[ArrayLike, ArrayLike] | None = None,
) -> Film:
    """The frames of an animation of a body, with the arguments of :meth:`rigid.Run.animate`."""
    t, omega, attitude = one.t, one.omega, one.attitude
    momentum, _ = of_size_one(one.momentum, (0, 1))  # only its direction is shown
    if trail is not None and trail != np.inf:
        trail = finite_float("trail", trail, positive=True)
    if len(t) < 2:
        raise one_time("an animation", t)
    span = abs(float(t[-1] - t[0]))
    if speed is None:
        speed = max(1.0, span / LONGEST)
    speed = finite_float("speed", speed, positive=True)
    view = _chosen(one, view, shape is not None)
    solid = None if shape is None else faces_of(shape, frame=one.frame)
    size = float(np.linalg.norm(momentum[0]))
    chart, polhode = Chart("ω (rad/s)", ("ω₁", "ω₂", "ω₃"), AXES, omega.T), None
    grounded = False
    if view == "top":
        parts, up = _top(one, solid), UP
        chart = Chart("tilt (°)", (), (AXES[2],), tilt_of(one)[np.newaxis])
        body = (parts[0].placed(attitude[k], k) for k in _some_frames(attitude))
        grounded = min(float(corners[..., 2].min()) for corners in body) > -0.02
    elif one.orbit is not None:
        radial, _, normal = np.moveaxis(one.orbit, -1, 0)
        parts, up = _box(one, momentum, solid) + _planet(-radial, normal[0]), normal[0]
    elif one.forces:
        # A rotor and an energy sink leave the angular momentum at rest in space.
        keeps = {*one.forces} <= {"rotor", "dissipation"} and size > 0.0
        parts, up = _box(one, momentum, solid), momentum[0] / size if keeps else UP
    else:
        if size == 0.0:
            raise ValueError("omega = [0, 0, 0]: a free body at rest does not move")
        up, polhode = momentum[0] / size, _polhode(one.moments, omega)
        if view == "box":
            parts = _box(one, momentum[:1], solid)
        else:
            parts = _cones(one, momentum[:1]) if view == "cones" else _poinsot(one)
    steps = np.diff(t)
    if trail is None:
        trail = np.inf if view == "poinsot" else 0.25 * span
        if one.orbit is not None:  # of many revolutions the last two turns or so
            trail = min(trail, 12.0 / max(float(np.linalg.norm(omega, axis=1).mean()), 1e-300))
    centre, reach = _room(parts, attitude, up)
    return Film(
        view=view,
        title=one.title,
        story=story_of(one, view),
        name=f"ω = ({', '.join(f'{rate:.3g}' for rate in omega[0])}) rad/s",
        t=t,
        shown=np.append(steps, steps[-1]) / speed,
        speed=speed,
        attitude=attitude,
        parts=parts,
        up=up,
        centre=centre,
        reach=reach,
        trail=float(trail),
        chart=chart,
        polhode=polhode,
        grounded=grounded,
    )


def faces_of(shape: tuple[ArrayLike, ArrayLike], *, frame: Floats | None) -> Floats:
    """The polygons of a mesh along the principal axes, with its farthest corner at distance one.

    Parameters
    ----------
    shape : tuple (vertices, faces)
        Corners of shape (v, 3) in any unit of length, from the origin of the body, and the indices
        of the corners of each polygon, from 0, whole numbers of shape (f, n) with n >= 3.
    frame : ndarray, shape (3, 3), or None
        The axes of the corners, as :attr:`rigid.Run.frame`; None if they are principal axes.

    Returns
    -------
    ndarray, shape (f, n, 3)

    Raises
    ------
    TypeError
        If it is no pair.
    ValueError
        If the arrays have other shapes, a face names a corner that is not there, or all used
        corners are at the origin.

    Examples
    --------
    >>> from rigid.animation.film import faces_of
    >>> corners = [[0, 0, 0], [4, 0, 0], [0, 2, 0], [0, 0, 2]]
    >>> faces_of((corners, [[0, 2, 1]]), frame=None)[0]
    array([[0. , 0. , 0. ],
           [0. , 0.5, 0. ],
           [1. , 0. , 0. ]])
    """
    if not isinstance(shape, (tuple, list)) or len(shape) != 2:
        raise TypeError(f"shape = {brief(shape)}: must be a pair, (vertices, faces)")
    vertices, faces = shape
    points = shaped("shape[0]", vertices, 3)
    if points.ndim != 2:
        raise ValueError(f"shape[0]: the corners need the shape (v, 3), not {points.shape}")
    index = np.asarray(plain("shape[1]", faces))
    if index.ndim != 2 or index.dtype.kind not in "iu" or not len(index) or index.shape[1] < 3:
        raise ValueError(
            f"shape[1]: the faces need whole numbers of shape (f, n) with n >= 3, not "
            f"{index.dtype} of shape {index.shape}"
        )
    if index.min() < 0 or index.max() >= len(points):
        bad = int(index.max() if index.max() >= len(points) else index.min())
        raise ValueError(f"shape[1]: no corner {brief(bad)} among {len(points)} corners")
    if frame is not None:
        points = points @ frame  # back from the axes of the drawing
    polygons = points[index]
    farthest = float(np.linalg.norm(polygons, axis=-1).max())
    if farthest == 0.0:
        raise ValueError("shape[0]: all corners of the faces are at the origin")
    return np.asarray(polygons / farthest)


def side_by_side(films: Sequence[Film]) -> list[Film]:
    """The films with one scale, one centre, and a ground if all have it."""
    heights = [float(film.centre @ film.up) for film in films]
    height = 0.5 * (min(heights) + max(heights))
    reach = max(abs(at - height) + film.reach for at, film in zip(heights, films, strict=True))
    grounded = all(film.grounded for film in films)
    return [
        replace(film, centre=height * film.up, reach=reach, grounded=grounded) for film in films
    ]


def _polhode(moments: Floats, omega: Floats) -> Polhode:
    """Path and separatrix; on the separatrix the energy is ``L² / (2 I)`` of the middle axis."""
    momentum = moments * omega
    points = momentum / np.linalg.norm(momentum, axis=1, keepdims=True)
    if len(set(moments.tolist())) < 3:
        return Polhode(points, ())
    low, mid, high = np.argsort(moments)
    inverse = 1.0 / moments
    first, last = inverse[low] - inverse[mid], inverse[mid] - inverse[high]
    turn = np.linspace(0.0, 2.0 * np.pi, 97)
    circles = []
    for sign in (1.0, -1.0):
        circle = np.zeros((97, 3))
        circle[:, mid] = np.cos(turn)
        circle[:, low] = np.sin(turn) * np.sqrt(last / (first + last))
        circle[:, high] = sign * np.sin(turn) * np.sqrt(first / (first + last))
        circles.append(circle)
    return Polhode(points, tuple(circles))


def _room(parts: tuple[Part, ...], attitude: Floats, up: Floats) -> tuple[Floats, float]:
    """Centre and radius of a sphere around all parts, from at most 64 frames."""
    places = (part.placed(attitude[k], k) for k in _some_frames(attitude) for part in parts)
    cloud = np.concatenate([points.reshape(-1, 3) for points in places])
    heights = cloud @ up
    centre = 0.5 * (heights.min() + heights.max()) * up
    reach = float(np.linalg.norm(cloud - centre, axis=1).max())
    has_planet = any(part.kind == "planet" for part in parts)
    return centre, (1.0 + 1.5 * BALL) * reach if has_planet else reach


def _some_frames(attitude: Floats) -> NDArray[np.int64]:
    return np.unique(np.linspace(0, len(attitude) - 1, 64).astype(int))


def _chosen(one: Recording, view: str | None, has_shape: bool) -> str:
    """The requested view, or the default view of the scene."""
    if view is not None:
        one_of("view", view, ("top",) if one.is_top else VIEWS)
        if view in ("cones", "poinsot"):
            if one.forces:
                raise ValueError(
                    f"scene = {one.title}: view = {view!r} needs a scene without {one.acting}; "
                    "rigid.simulate integrates the motion"
                )
            if has_shape:
                raise ValueError(f"view = {view!r}: does not show the shape; omit one of them")
            refuse_rods(one.moments)
        return view
    if one.is_top:
        return "top"
    if one.sides is not None or one.forces or has_shape or rods(one.moments):
        return "box"
    return "cones" if len(set(one.moments.tolist())) == 2 else "poinsot"


def _box(one: Recording, momentum: Floats, solid: Floats | None) -> tuple[Part, ...]:
    """A thrown box, or a solid, with its axes, omega and L, relative to the centre of mass."""
    meaning = ""
    if solid is None:
        sides = one.sides
        if sides is None:
            # The homogeneous box with these moments: squared sides are proportional to second
            # moments.
            spread = _spread(one.moments)
            meaning = "" if (spread >= 0.0).all() else "flat box: no body has the moments"
            sides = np.sqrt(np.maximum(spread, 0.0)).tolist()
        half = np.maximum(np.array(sides) / max(sides), 0.02)
        solid, inks = box_faces(half), tuple(colour for colour in AXES for _ in range(2))
    else:
        half, inks = np.abs(solid).max(axis=(0, 1)), (BODY,)
    return (
        Part("faces", solid, inks, carried=True, meaning=meaning),
        *(
            Part(
                "arrow", tip[np.newaxis], (ink,), carried=True, label=name, meaning="principal axes"
            )
            for tip, ink, name in zip(np.diag(half + 0.35), AXES, "123", strict=True)
        ),
        *_vectors(one, momentum, length=1.5),
    )


def _cones(one: Recording, momentum: Floats) -> tuple[Part, ...]:
    """Body cone and space cone, which touch along omega."""
    moments, omega = one.moments, one.omega[0]
    number = symmetry_axis(moments)
    if number is None:
        found = moments.tolist()
        raise ValueError(f"moments = {found}: a symmetric top has two exactly equal moments")
    k = number - 1
    axis = np.eye(3)[k] * (1.0 if omega[k] >= 0.0 else -1.0)
    in_body, in_space = (BODY, colours.FACE_STRIPE), (colours.FAINT, colours.BAND)
    body = cone_faces(axis, _angle(omega, axis))
    space = cone_faces(momentum[0], _angle(omega, moments * omega))
    tip, ink = 1.15 * axis[np.newaxis], (colours.HUES["black"],)
    return (
        Part("faces", body, in_body, opacity=0.55, carried=True, meaning="cone of ω in the body"),
        Part("faces", space, in_space, opacity=0.75, meaning="cone of ω in space"),
        Part("arrow", tip, ink, carried=True, label="axis", meaning="symmetry axis"),
        *_vectors(one, momentum, length=1.3),
    )


def _angle(one: Floats, other: Floats) -> float:
    """Angle between two vectors, without loss of digits near zero."""
    one, other = (vector / np.linalg.norm(vector) for vector in (one, other))
    return float(np.arctan2(np.linalg.norm(np.cross(one, other)), one @ other))


def _poinsot(one: Recording) -> tuple[Part, ...]:
    """The inertia ellipsoid, which rolls on the invariable plane: polhode and herpolhode."""
    moments, omega = one.moments, one.omega
    in_body = moments * omega[0]
    size = np.linalg.norm(in_body)
    twice_energy = (in_body * omega[0]).sum()
    semi_axes = np.sqrt(twice_energy / moments)
    unit = float(semi_axes.max())
    contact = to_space(attitudes(one.attitude), omega) / unit
    normal = to_space(one.attitude[0], in_body) / size
    foot = normal * (float(twice_energy / size) / unit)
    width = 1.25 * max(float(np.linalg.norm(contact - foot, axis=-1).max()), 0.4)
    solid = ellipsoid_faces(semi_axes / unit, rings=18, sectors=36)
    stripes = (BODY,) * 9 + (colours.FACE_STRIPE,) * 9
    return (
        Part("faces", solid, stripes, opacity=0.7, carried=True, meaning="inertia ellipsoid"),
        Part(
            "faces",
            plane_face(foot, normal, width),
            (SPACE,),
            opacity=0.25,
            meaning="plane at rest",
        ),
        Part("line", omega / unit, (colours.ON_FACE,), carried=True, meaning="polhode"),
        Part("trail", contact, (SPACE,), meaning="herpolhode"),
        Part("dot", contact, (colours.OMEGA.colour,)),
        _omega(contact),
        _momentum(1.35 * foot[np.newaxis]),
    )


def _top(one: Recording, solid: Floats | None) -> tuple[Part, ...]:
    """A top on its fixed point, and the path of the tip of its stem on a sphere."""
    direction = one.com
    inks: tuple[str, ...] = (BODY,)
    tip, path = 1.0, "path of the axis through the centre of mass"
    if solid is None:
        solid = top_faces(direction, _spread(one.moments))
        inks, tip = (BODY,) * 6 + (AXES[0],) * 6, STEM
    turn = np.linspace(0.0, 2.0 * np.pi, 49)
    ring = np.stack([np.cos(turn), np.sin(turn), 0.0 * turn], axis=1)  # marks the fixed point
    return (
        Part("faces", solid, inks, carried=True),
        Part("trail", tip * to_space(attitudes(one.attitude), direction), (AXES[2],), meaning=path),
        Part("arrow", 1.6 * UP[np.newaxis], (colours.VERTICAL.colour,), label="vertical"),
        Part("line", 0.12 * ring, (SPACE,), meaning="fixed point"),
    )


def _planet(direction: Floats, normal: Floats) -> tuple[Part, ...]:
    """The direction to the planet in each frame, and the plane in which the planet goes round."""
    first, second, _ = across(normal)
    turn = np.linspace(0.0, 2.0 * np.pi, 97)[:, np.newaxis]
    ring = PLANET * (np.cos(turn) * first + np.sin(turn) * second)
    ink = colours.PLANET.colour
    return (
        Part("line", ring, (colours.FAINT,), meaning="plane of the orbit"),
        Part(
            "planet",
            PLANET * direction,
            (ink,),
            label="planet",
            meaning="direction to the planet",
        ),
    )


def _vectors(one: Recording, momentum: Floats, *, length: float) -> tuple[Part, ...]:
    """Omega and its path, and L, in space; L is at most ``length`` long, omega 0.8 ``length``."""
    rates = to_space(attitudes(one.attitude), one.omega)
    rates = _of_length(0.8 * length, rates)
    return (
        Part("trail", rates, (SPACE,), meaning="path of ω"),
        _omega(rates),
        _momentum(_of_length(length, momentum)),
    )


def _of_length(length: float, vectors: Floats) -> Floats:
    """The vectors with the longest of them of this length; zero vectors stay zero."""
    longest = float(np.linalg.norm(vectors, axis=-1).max())
    return vectors if longest == 0.0 else length / longest * vectors


def _omega(points: Floats) -> Part:
    ink = colours.OMEGA.colour
    return Part("arrow", points, (ink,), label="ω", meaning="angular velocity")


def _momentum(points: Floats) -> Part:
    ink = colours.L.colour
    return Part("arrow", points, (ink,), label="L", meaning="angular momentum")


def _spread(moments: Floats) -> Floats:
    """``∫ x_i² dm`` along each principal axis."""
    return np.asarray(0.5 * moments.sum() - moments)
