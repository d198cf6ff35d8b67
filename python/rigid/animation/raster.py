"""Pictures of films, drawn with a depth buffer: perspective, light, and the mean of four dots."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from .._checks.arrays import Floats
from ..drawing.shapes import across, ellipsoid_faces, quads
from ..rotations.apply import to_space
from .film import BALL, Film, Part

AZIMUTH, ELEVATION = float(np.deg2rad(35.0)), float(np.deg2rad(26.0))
"""View of a picture, and initial view of a page."""

AWAY = 4.5
"""Distance of the eye from the centre, in reaches of the film; the same as in stage.js."""

DOTS = 2
"""Dots of the buffer along each side of a pixel."""

MOST_MET = 64
"""Most faces with which a face is compared at a corner; 64 at a round tip show its axis."""


class Camera:
    """The projection of a film to a square buffer."""

    def __init__(self, film: Film, size: int) -> None:
        first, second, self.up = across(film.up)
        level = np.cos(AZIMUTH) * first + np.sin(AZIMUTH) * second
        self.eye = np.cos(ELEVATION) * level + np.sin(ELEVATION) * self.up
        right = np.cross(self.up, level)
        upward = np.cross(self.eye, right)
        self.axes = np.stack([right, upward, self.eye])
        self.at = film.centre + AWAY * film.reach * self.eye
        lamp = self.eye + 0.9 * upward + 0.5 * right
        self.lamp = lamp / np.linalg.norm(lamp)
        self.size, self.reach = size, film.reach
        # A sphere of one reach fills the picture but for four parts of a hundred.
        self.scale = 0.5 * size * np.sqrt(AWAY**2 - 1.0) / 1.04

    def project(self, points: Floats) -> Floats:
        """Column, row and depth of points in space."""
        seen = (points - self.at) @ self.axes.T
        depth = -seen[..., 2]
        column = 0.5 * self.size + self.scale * seen[..., 0] / depth
        row = 0.5 * self.size - self.scale * seen[..., 1] / depth
        return np.stack([column, row, depth], axis=-1)


class Buffer:
    """Colours of the dots, and one over their depths: 0 where nothing is drawn."""

    def __init__(self, camera: Camera) -> None:
        self.camera = camera
        self.colour = np.ones((camera.size, camera.size, 3), dtype=np.float32)
        self.near = np.zeros((camera.size, camera.size), dtype=np.float32)

    def faces(
        self, faces: Floats, rgb: Floats, opacity: float = 1.0, normals: Floats | None = None
    ) -> None:
        """Polygons of one colour each; transparent ones from the farthest to the nearest.

        ``normals`` are those at the corners, (faces, corners, 3); by default polygons are flat.
        """
        if not len(faces):
            return
        corners = self.camera.project(faces)
        # The light at each corner, as surface.frag computes it, without the gloss.
        flat = _normals(faces)[:, np.newaxis]
        towards = self.camera.at - faces.mean(axis=1, keepdims=True)
        side = np.sign((flat * towards).sum(axis=-1, keepdims=True))
        normals = side * np.broadcast_to(_unit(flat) if normals is None else normals, faces.shape)
        lit = np.maximum(normals @ self.camera.lamp, 0.0)
        light = 0.52 + 0.12 * normals @ self.camera.up + 0.48 * lit
        if opacity < 1.0:
            order = np.argsort(-corners[..., 2].mean(axis=1))
            corners, rgb, light = corners[order], rgb[order], light[order]
        fan = [[0, c, c + 1] for c in range(1, faces.shape[1] - 1)]
        self._triangles(
            corners[:, fan].reshape(-1, 3, 3),
            rgb.astype(np.float32).repeat(len(fan), axis=0),
            light[:, fan].reshape(-1, 3).astype(np.float32),
            opacity,
        )

    def _triangles(
        self,
        corners: Floats,
        inks: NDArray[np.float32],
        light: NDArray[np.float32],
        opacity: float,
    ) -> None:
        low = np.maximum(np.floor(corners[..., :2].min(axis=1)), 0).astype(int)
        high = np.minimum(np.ceil(corners[..., :2].max(axis=1)), self.camera.size).astype(int)
        (x0, y0), (x1, y1), (x2, y2) = np.moveaxis(corners[..., :2], 0, -1)
        area = (x1 - x0) * (y2 - y0) - (x2 - x0) * (y1 - y0)
        drawn = (np.abs(area) > 1e-9) & (high > low).all(axis=1)
        scale = 1.0 / np.where(drawn, area, 1.0)
        # Shares of the second and the third corner, and one over the depth, which along a plane is
        # linear in the picture: value, slope along columns and slope along rows.
        second = np.stack([y0 * x2 - x0 * y2, y2 - y0, x0 - x2]) * scale
        third = np.stack([x0 * y1 - y0 * x1, y0 - y1, x1 - x0]) * scale
        one = np.array([[1.0], [0.0], [0.0]])
        first = one - second - third
        inverse = first / corners[:, 0, 2] + second / corners[:, 1, 2] + third / corners[:, 2, 2]
        planes = np.stack([first, second, third, inverse]).astype(np.float32)
        dots = np.arange(self.camera.size, dtype=np.float32) + np.float32(0.5)
        for k in np.flatnonzero(drawn):
            (left, top), (right, bottom) = low[k], high[k]
            here = slice(top, bottom), slice(left, right)
            start, across_columns, across_rows = planes[:, :, k].T[..., np.newaxis, np.newaxis]
            along_row = start + across_columns * dots[left:right]
            a, b, c, near = along_row + across_rows * dots[top:bottom, np.newaxis]
            inside = (np.minimum(np.minimum(a, b), c) >= 0.0) & (near > self.near[here])
            p, q, r = light[k]
            lit = (p * a[inside] + q * b[inside] + r * c[inside])[:, np.newaxis] * inks[k]
            if opacity == 1.0:
                self.near[here][inside] = near[inside]
                self.colour[here][inside] = lit
            else:
                behind = self.colour[here][inside]
                self.colour[here][inside] = behind + np.float32(opacity) * (lit - behind)

    def ground(self, faces: Floats) -> None:
        """A ground at the height 0 that fades outward, with the shadow of these polygons.

        The shadow is the mean of the shadows of the points of a wide lamp, as in stage.js.
        """
        from PIL import Image, ImageDraw, ImageFilter

        camera, points = self.camera, 16
        small = camera.size // DOTS
        row = DOTS * (np.arange(small) + 0.5) - 0.5 * camera.size
        ray = np.stack(np.broadcast_arrays(row, -row[:, np.newaxis], -camera.scale), axis=-1)
        ray = ray @ camera.axes  # through each pixel
        met = camera.at - ray * (camera.at[2] / np.minimum(ray[..., 2:], -1e-9))
        out = np.linalg.norm(met, axis=-1) / (1.2 * camera.reach)
        count = np.zeros((small, small))
        for k in range(points):
            far = 0.35 * np.sqrt((k + 0.5) / points)
            slope = np.array([0.25 + far * np.cos(2.4 * k), -0.2 + far * np.sin(2.4 * k)])
            flat = np.zeros_like(faces)
            flat[..., :2] = faces[..., :2] + slope * faces[..., 2:]
            mask = Image.new("1", (small, small))
            pen = ImageDraw.Draw(mask)
            for polygon in camera.project(flat)[..., :2] / DOTS:
                pen.polygon(polygon.ravel().tolist(), fill=1)
            count += np.asarray(mask)
        steps = Image.fromarray((255.0 / points * count).astype(np.uint8))
        shadow = np.asarray(steps.filter(ImageFilter.GaussianBlur(small / 100))) / 255.0
        shade = (1.0 - 0.1 * np.clip(1.0 - out, 0.0, 1.0)) * (1.0 - 0.4 * shadow)
        self.colour *= shade.astype(np.float32).repeat(DOTS, 0).repeat(DOTS, 1)[..., np.newaxis]

    def curve(self, points: Floats, rgb: Floats, strength: Floats) -> None:
        """A curve as round dots before the surfaces on which it lies."""
        seen = self.camera.project(points)
        along = np.append(0.0, np.cumsum(np.hypot(*np.diff(seen[:, :2], axis=0).T)))
        if along[-1] == 0.0:
            return
        wanted = np.arange(0.0, along[-1], 0.75)
        column, row, depth = (np.interp(wanted, along, part) for part in seen.T)
        strong = np.interp(wanted, along, strength)
        dy, dx = np.mgrid[-1:2, -1:2].reshape(2, -1, 1)
        i, j = np.rint(row + dy).astype(int), np.rint(column + dx).astype(int)
        near = np.broadcast_to(1.0 / (depth - 0.02 * self.camera.reach), i.shape)
        strong = np.broadcast_to(strong, i.shape)
        inside = (i >= 0) & (j >= 0) & (i < self.camera.size) & (j < self.camera.size)
        i, j, near, strong = i[inside], j[inside], near[inside], strong[inside]
        front = near > self.near[i, j]
        i, j, strong = i[front], j[front], strong[front]
        self.colour[i, j] = 1.0 + strong[:, np.newaxis] * (rgb - 1.0)

    def picture(self) -> NDArray[np.uint8]:
        """The pixels, each the mean of its dots."""
        total = np.zeros((self.camera.size // DOTS, self.camera.size // DOTS, 3), np.float32)
        for i in range(DOTS):
            for j in range(DOTS):
                total += self.colour[i::DOTS, j::DOTS]
        total *= np.float32(255.0 / DOTS**2)
        return np.rint(np.clip(total, 0.0, 255.0)).astype(np.uint8)


def frame_picture(
    film: Film, frame: int, size: int
) -> tuple[NDArray[np.uint8], list[tuple[Part, Floats]]]:
    """The pixels of a frame, and the places of the labels."""
    from matplotlib.colors import to_rgba_array

    camera = Camera(film, DOTS * size)
    buffer = Buffer(camera)
    attitude, begin = film.attitude[frame], film.trail_begin(frame)
    placed = [(part, part.placed(attitude, frame, begin)) for part in film.parts]
    if film.grounded:
        buffer.ground(next(points for part, points in placed if part.kind == "faces"))
    see_through = []
    for part, points in placed:
        rgb = to_rgba_array(part.colours)[:, :3]
        if part.kind == "faces":
            normals = corner_normals(part)
            if part.carried:
                normals = to_space(attitude, normals)
            inks = np.resize(rgb, (len(points), 3))
            if part.opacity < 1.0:
                see_through.append((points, inks, part.opacity, normals))
            else:
                buffer.faces(points, inks, normals=normals)
        elif part.kind in _SOLIDS:
            solid = _SOLIDS[part.kind](points[0], film.reach)
            buffer.faces(solid, np.resize(rgb, (len(solid), 3)))
    for part, points in placed:
        if part.kind in ("line", "trail") and len(points) > 1:
            ends = np.isfinite(film.trail) and part.kind == "trail"
            strength = np.linspace(0.0 if ends else 1.0, 1.0, len(points))
            buffer.curve(points, to_rgba_array(part.colours)[0, :3], strength)
    for faces, inks, opacity, normals in see_through:
        buffer.faces(faces, inks, opacity, normals)
    parts = [part for part in film.parts if part.label]
    tips = [camera.project(points[0])[:2] / DOTS for part, points in placed if part.label]
    origin = camera.project(np.zeros(3))[:2] / DOTS
    places = label_places(origin, tips, [len(part.label) for part in parts])
    return buffer.picture(), list(zip(parts, places, strict=True))


TURNS = (0.0, 0.9, -0.9, 1.6, -1.6, 2.4, -2.4)
"""Places of a label round the tip of its arrow (rad); the same as in stage.js."""


def label_places(origin: Floats, tips: list[Floats], letters: list[int]) -> list[Floats]:
    """The middles of labels, each beyond the tip of its arrow or beside it.

    A label is where it lies on the fewest labels and arrows. ``letters`` are the numbers of letters
    of the labels, of about 9 pixels each.
    """
    places: list[Floats] = []
    halves = [np.array([4.5 * count + 1.0, 8.0]) for count in letters]
    for k, tip in enumerate(tips):
        x, y = tip - origin
        options = []
        for turn in TURNS:
            angle = np.arctan2(y, x) + turn
            towards = np.array([np.cos(angle), np.sin(angle)])
            at = tip + (8.0 + np.abs(towards) @ (halves[k] * [1.0, 0.5])) * towards
            on_labels = sum(
                bool((np.abs(at - other) < halves[k] + half).all())
                for other, half in zip(places, halves, strict=False)
            )
            on_arrows = sum(
                _from_segment(at, origin, other) < 9.0 for j, other in enumerate(tips) if j != k
            )
            options.append((4.0 * on_labels + on_arrows + 0.1 * abs(turn), at))
        places.append(min(options, key=lambda option: option[0])[1])
    return places


def _from_segment(point: Floats, begin: Floats, end: Floats) -> float:
    along = end - begin
    share = np.clip((point - begin) @ along / max(float(along @ along), 1e-9), 0.0, 1.0)
    return float(np.linalg.norm(point - begin - share * along))


def corner_normals(part: Part) -> Floats:
    """Normals at the corners of polygons, averaged where faces meet at less than 45 degrees.

    Where more than :data:`MOST_MET` faces meet, so many of them are compared with each.

    Returns
    -------
    ndarray, shape (faces, corners, 3)
        Unit vectors on the side of the normal of the face, in the axes of the part.
    """
    count, corners = part.points.shape[:2]
    normals = _normals(part.points)
    units = _unit(normals)
    rounded = np.rint(1e4 * part.points.reshape(-1, 3)).astype(np.int64)
    label = np.unique(rounded, axis=0, return_inverse=True)[1].reshape(-1)
    order = np.argsort(label, kind="stable")  # corners in one place follow one another
    face = order // corners
    many = np.bincount(label)
    begin = np.repeat(np.cumsum(many) - many, many)
    many = np.repeat(many, many)
    compared = np.minimum(many, MOST_MET)
    total = np.zeros((count * corners, 3))
    for turn in range(compared.max(initial=0)):
        (one,) = np.nonzero(turn < compared)
        step = turn * many[one] // compared[one]
        other = face[begin[one] + (one - begin[one] + step) % many[one]]
        along = (units[face[one]] * units[other]).sum(axis=1)
        side = np.where(np.abs(along) > np.cos(0.25 * np.pi), np.sign(along), 0.0)
        total[order[one]] += side[:, np.newaxis] * normals[other]
    return _unit(total).reshape(count, corners, 3)


def _normals(faces: Floats) -> Floats:
    """Normals of polygons, of the length of twice their areas or so."""
    return np.cross(faces[:, 2] - faces[:, 0], faces[:, -1] - faces[:, 1])


def _unit(vectors: Floats) -> Floats:
    return np.asarray(vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-300))


def ball_faces(centre: Floats, radius: float) -> Floats:
    """A ball, shape (faces, 4, 3)."""
    return np.asarray(centre + ellipsoid_faces([radius] * 3, rings=8, sectors=16))


def planet_faces(place: Floats, reach: float) -> Floats:
    """A planet at the end of a line from the origin, shape (faces, 4, 3)."""
    first, second, along = across(place)
    turn = np.linspace(0.0, 2.0 * np.pi, 7)[:, np.newaxis]
    circle = 0.006 * reach * (np.cos(turn) * first + np.sin(turn) * second)
    line = quads(np.stack([circle, circle + np.linalg.norm(place) * along]))
    return np.concatenate([line, ball_faces(place, BALL * reach)])


def arrow_faces(tip: Floats, reach: float, *, sides: int = 12) -> Floats:
    """An arrow from the origin: a shaft and a head, shape (faces, 4, 3)."""
    length = float(np.linalg.norm(tip))
    if length == 0.0:
        return np.empty((0, 4, 3))
    first, second, along = across(tip)
    turn = np.linspace(0.0, 2.0 * np.pi, sides + 1)[:, np.newaxis]
    circle = np.cos(turn) * first + np.sin(turn) * second
    neck = length - min(0.11 * reach, 0.6 * length)
    profile = ((0.014, 0.0), (0.014, neck), (0.036, neck), (1e-4, length))
    rings = np.stack([radius * reach * circle + height * along for radius, height in profile])
    return quads(rings)


_SOLIDS: dict[str, Callable[[Floats, float], Floats]] = {
    "arrow": arrow_faces,
    "dot": lambda point, reach: ball_faces(point, 0.03 * reach),
    "planet": planet_faces,
}
"""The faces of a part that is drawn at one point of each frame."""
