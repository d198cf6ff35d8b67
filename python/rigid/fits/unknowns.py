"""The free parameters of a fit: their numbers inside a box, and the rates they predict."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from .._checks.arguments import brief
from .._checks.arrays import Floats
from ..model.forces import FORCES
from ..model.parameters import AT_REST, PARAMETERS, PLACES, numbers_of, scene_of
from ..model.scene import Scene
from ..rotations.so3 import exp_so3, over, rodrigues
from ..solve.request import MOST_STEPS
from ..solve.simulate import simulate
from ..solve.tangent import checked_names, differentiable, why_not

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

    from ..solve.run import Run


MOMENTS = ("I1", "I2", "I3")
RATIOS = tuple(f"{a}/{b}" for a in MOMENTS for b in MOMENTS if a != b)
START = ("omega1", "omega2", "omega3")
BIAS = ("bias1", "bias2", "bias3")
SCALE = ("scale1", "scale2", "scale3")
SENSOR = ("sensor1", "sensor2", "sensor3")
DAMPING = ("damping1", "damping2", "damping3")
_GROUPS = {"damping": DAMPING, "omega": START, "bias": BIAS, "scale": SCALE, "sensor": SENSOR}

_EDGE = 1e-9
"""Share of the moments by which a body stays thicker than a rod or a plate."""

_NOTHING = 1e-30
"""Share of its size that a coefficient keeps at its bound of zero.

A force without coefficients would not act, and the motion would have no derivative by it.
"""

_FASTER = 10.0
"""How many times as fast as the fastest measured rates a start may turn.

Without this bound a trial far off could turn so fast that its run would hardly end.
"""

_SENSOR = 0.1
"""Bias that a gyroscope adds to the rates, or its scale, as a share of the rates."""

_MOUNTED = 0.3, math.pi / 4.0
"""Angle (rad) by which a gyroscope may be off its first axes, and the bound about each axis.

Beyond 45 degrees the same body has its principal axes in another order, nearer to the gyroscope's.
"""


class Unknowns:
    """The free parameters, and the numbers inside a box by which they vary.

    The base numbers are free moments and other parameters of the scene, rates, and errors of a
    gyroscope; ``base + steer @ x`` gives them from coordinates ``x`` inside the box. The ``sizes``
    of the coordinates are how far off a first guess may be.
    """

    def __init__(
        self,
        scene: Scene,
        start: Floats,
        attitude: ArrayLike | Rotation | None,
        free: str | Sequence[str],
        frame: Floats | None = None,
        fastest: float = np.inf,
    ) -> None:
        self.scene, self.start, self.attitude, self.frame = scene, start, attitude, frame
        self.fastest, self.most_steps = fastest, MOST_STEPS
        self.names = _checked_names(scene, free)
        moments = [name for name in self.names if name in (*MOMENTS, *RATIOS)]
        self._moving = sorted(MOMENTS.index(name[:2]) for name in moments)
        if len(set(self._moving)) < len(self._moving):
            raise ValueError(f"free = {brief(free)}: one moment varies by two of the parameters")
        if moments and not scene.body.physical:
            raise ValueError(
                f"free = {brief(free)}: the search stays within moments that a body can have; "
                "give the scene a body without physical=False"
            )
        ratios = {name[:2]: name[3:] for name in moments if name in RATIOS}
        if len(ratios) == 3 or any(ratios.get(below) == above for above, below in ratios.items()):
            raise ValueError(f"free = {brief(free)}: one of the ratios follows from the others")
        # The base numbers, in the order of the names, each moment in the place of its name.
        self.numbers = tuple(name[:2] if name in moments else name for name in self.names)
        of_run = (*START, *BIAS, *SCALE, *SENSOR)
        self._by_run = tuple(name for name in self.numbers if name not in of_run)
        self._rows = {name: PARAMETERS[name] for name in self._by_run if name not in MOMENTS}
        self._places = {"moments", *(row.place for row in self._rows.values())}
        known = (*self._by_run, *of_run)
        self._columns = [known.index(name) for name in self.numbers]
        self._is_aligned = not any(name in SENSOR for name in self.numbers)
        self._boxes()

    def _boxes(self) -> None:
        i = np.array(self.scene.body.moments)
        unit = float(i.max())
        self.base = np.zeros(len(self.numbers))
        self.steer = np.eye(len(self.numbers))
        low, high = np.full(len(self.numbers), -np.inf), np.full(len(self.numbers), np.inf)
        first, sizes = self.base.copy(), np.ones(len(self.numbers))
        mean = float(np.linalg.norm(self.start)) or 1.0
        fast, (off, turn) = _FASTER * max(self.fastest, mean), _MOUNTED
        of_run = {  # first guess, bounds and size
            **{name: (w, -fast, fast, mean) for name, w in zip(START, self.start, strict=True)},
            **dict.fromkeys(BIAS, (0.0, -np.inf, np.inf, _SENSOR * mean)),
            **dict.fromkeys(SCALE, (1.0, 0.0, np.inf, _SENSOR)),
            **dict.fromkeys(SENSOR, (0.0, -turn, turn, off)),
        }
        for k, name in enumerate(self.numbers):
            if name in of_run:
                first[k], low[k], high[k], sizes[k] = of_run[name]
            elif name in self._rows:
                row = self._rows[name]
                every = numbers_of(self.scene, AT_REST, {row.place}, 1)[row.place][0]
                first[k] = every[row.index].mean()
                guess = PLACES[row.place].guess
                assert guess is not None  # the names are checked
                off_by = np.broadcast_to(guess(every, unit, mean), every.shape)
                sizes[k] = off_by[row.index].max()
                low[k], high[k] = row.lowest, row.highest
                if row.gap is not None:
                    below, above = row.gap
                    beyond = first[k] > below
                    low[k], high[k] = (above, row.highest) if beyond else (row.lowest, below)
                elif row.open_end:
                    low[k] = _EDGE * first[k]
                elif row.place in FORCES and row.lowest == 0.0:
                    low[k] = _NOTHING * sizes[k]
                    first[k] = max(first[k], low[k])
        place = {j: self.numbers.index(MOMENTS[j]) for j in self._moving}
        squares = 0.5 * i.sum() - i  # the integrals of x², y², z² over the mass
        edge = _EDGE * unit
        if len(place) == 1:
            ((j, k),) = place.items()
            others = np.delete(i, j)
            low[k], high[k] = abs(others[0] - others[1]) + edge, others.sum() - edge
            first[k], sizes[k] = np.clip(i[j], low[k] + edge, high[k] - edge), unit
        elif len(place) == 2:
            # The fixed moment is the sum of two squares: one varies, and the third does.
            (j, m), fixed = self._moving, 3 - sum(self._moving)
            a, b = place[j], place[m]
            self.base[a] = i[fixed]
            self.steer[np.ix_([a, b], [a, b])] = [[-1.0, 1.0], [1.0, 1.0]]
            low[[a, b]], high[a] = edge, i[fixed] - edge
            first[a] = np.clip(squares[j], 2 * edge, i[fixed] - 2 * edge)
            first[b], sizes[[a, b]] = max(squares[fixed], 2 * edge), unit
        elif len(place) == 3:
            rows = [place[j] for j in range(3)]
            self.steer[np.ix_(rows, rows)] = 1.0 - np.eye(3)
            low[rows], sizes[rows] = edge, unit
            first[rows] = np.maximum(squares, 2 * edge)
        self.box, self.first, self.sizes = (low, high), first, sizes

    def other_moments(self, count: int) -> Floats:
        """First guesses spread over the moments that a body can have, shape (count, k).

        A repeated fit has the same guesses. None if no moment varies.
        """
        if not self._moving:
            return np.empty((0, len(self.first)))
        i = np.array(self.scene.body.moments)
        squares = np.random.default_rng(0).dirichlet(np.ones(3), count) * (0.5 * i.sum())
        guesses = np.tile(self.first, (count, 1))
        low, high = self.box
        columns = [self.numbers.index(MOMENTS[j]) for j in self._moving]
        if len(columns) == 1:
            shares = squares[:, :1] / squares.sum(axis=1, keepdims=True)
            guesses[:, columns] = low[columns] + shares * (high - low)[columns]
        elif len(columns) == 2:
            (j, m), fixed = self._moving, 3 - sum(self._moving)
            scale = i[fixed] / (squares[:, j] + squares[:, m])
            guesses[:, columns] = squares[:, [j, fixed]] * scale[:, np.newaxis]
        else:
            guesses[:, columns] = squares
        return np.clip(guesses, low, high)

    def _values(self, x: Floats) -> dict[str, Floats]:
        return dict(
            zip(self.numbers, np.moveaxis(self.base + x @ self.steer.T, -1, 0), strict=True)
        )

    def at(self, x: Floats) -> tuple[Scene, Floats]:
        """Scene and start that belong to coordinates, shape (k,), or of n bodies to (n, k)."""
        values, bodies = self._values(x), x.shape[:-1]
        numbers = numbers_of(self.scene, AT_REST, self._places, math.prod(bodies))
        moments = _taken(values, MOMENTS, self.scene.body.moments, bodies).reshape(-1, 3)
        for name, row in self._rows.items():
            row.put(numbers, values[name].ravel())
        varied = scene_of(self.scene, numbers, moments)
        return varied if bodies else varied[0], _taken(values, START, self.start, bodies)

    def steps(self, t: Floats) -> int:
        """Steps of a run of the first guess."""
        return int(self._run(self.first, t, tangent=False).steps)

    @property
    def swing(self) -> float:
        """The rate of oscillations by weight and rotor of the first guess (rad/s)."""
        least = min(self.scene.body.moments)
        weight = float(np.linalg.norm(self.scene.weight))
        rotor = float(np.linalg.norm(self.scene.momentum_of_rotor(0.0)))
        return math.sqrt(weight / least) + rotor / least

    def _run(self, x: Floats, t: Floats, tangent: bool | tuple[str, ...]) -> Run:
        scene, start = self.at(x)
        return simulate(
            scene,
            start,
            self.attitude,
            t=t,
            record="rates",
            check=False,
            tangent=tangent,
            max_steps=self.most_steps,
            frame=self.frame,
        )

    def sensor(self, x: Floats) -> Floats:
        """The axes of the gyroscope in the axes of the rates, as columns, shape (..., 3, 3)."""
        return exp_so3(_taken(self._values(x), SENSOR, (0.0,) * 3, x.shape[:-1]))

    def rates(self, x: Floats, t: Floats) -> Floats:
        """The rates that a gyroscope would measure, shape (..., m, 3); NaN of a run too long."""
        values, bodies = self._values(x), x.shape[:-1]
        scale = _taken(values, SCALE, (1.0,) * 3, bodies)[..., np.newaxis, :]
        bias = _taken(values, BIAS, (0.0,) * 3, bodies)[..., np.newaxis, :]
        rates: Floats = self._run(x, t, tangent=False).omega
        if not self._is_aligned:
            rates = rates @ self.sensor(x)
        return rates * scale + bias

    def slopes(self, x: Floats, t: Floats) -> Floats:
        """Derivatives of :meth:`rates` of one body by the base numbers, shape (m, 3, k)."""
        run = self._run(x, t, tangent=self._by_run or True)
        assert run.tangent is not None
        columns, omega, values = [run.tangent[:, :3, :3]], run.omega, self._values(x)
        if run.sensitivity is not None:
            columns.insert(0, run.sensitivity[:, :3])
        scale = _taken(values, SCALE, (1.0,) * 3, ())[:, np.newaxis]
        if not self._is_aligned:
            axes = self.sensor(x)
            omega, columns = omega @ axes, [axes.T @ part for part in columns]
        columns = [scale * part for part in columns]
        columns.append(np.broadcast_to(np.eye(3), (len(t), 3, 3)))
        columns.append(omega[:, np.newaxis, :] * np.eye(3))
        if not self._is_aligned:
            # exp(hat(v + dv)).T omega changes by its cross product with J dv.
            jacobian = _right_jacobian(_taken(values, SENSOR, (0.0,) * 3, ()))
            turned = np.cross(omega[:, np.newaxis], jacobian.T)
            columns.append(scale * np.swapaxes(turned, 1, 2))
        return np.concatenate(columns, axis=-1)[..., self._columns]

    def told(self, base: Floats) -> tuple[Floats, Floats]:
        """Values of the named parameters, and their derivatives by the base numbers."""
        values, slopes = base.copy(), np.eye(len(base))
        moments = dict(zip(MOMENTS, self.scene.body.moments, strict=True))
        moments |= {n: v for n, v in zip(self.numbers, base, strict=True) if n in MOMENTS}
        for k, name in enumerate(self.names):
            if name in RATIOS:
                above, below = moments[name[:2]], moments[name[3:]]
                values[k], slopes[k, k] = above / below, 1.0 / below
                if name[3:] in self.numbers:
                    slopes[k, self.numbers.index(name[3:])] = -above / below**2
        return values, slopes

    def edges(self, x: Floats) -> tuple[str, ...]:
        """The parameters at their bounds, in words."""
        low, high = self.box
        below, above = x - low < 1e-6 * self.sizes, high - x < 1e-6 * self.sizes
        near = below | above
        words = []
        for k, name in enumerate(self.numbers):
            if near[k] and name not in (*MOMENTS, *START):
                end = low[k] if below[k] else high[k]
                value = "zero" if abs(end) <= _NOTHING * self.sizes[k] else f"{end:g}"
                which = "least" if below[k] else "most"
                words.append(f"{name} is {value}, the {which} that it can be")
        if any(near[k] for k, name in enumerate(self.numbers) if name in MOMENTS):
            words.append("the moments belong to a flat body, the edge of what a body can have")
        return tuple(words)


def _right_jacobian(v: Floats) -> Floats:
    """``J`` with ``exp(hat(v + dv)) = exp(hat(v)) exp(hat(J dv))`` to first order, shape (3, 3).

    ``1 - (1 - cos x)/x² hat(v) + (x - sin x)/x³ hat(v)²`` with ``x = |v|``: the integral of
    ``exp(-s hat(v))`` over ``s`` from 0 to 1, with Rodrigues' formula.
    """
    x = np.linalg.norm(v, axis=-1)
    once = 2.0 * over(np.sin(0.5 * x), x, 0.5) ** 2
    return rodrigues(v, -once, over(x - np.sin(x), x**3, 0.0))


def _taken(
    values: dict[str, Floats], names: Sequence[str], others: ArrayLike, bodies: tuple[int, ...]
) -> Floats:
    """The values of these names, and default values for the others; shape (..., 3)."""
    known = zip(names, np.asarray(others).tolist(), strict=True)
    parts = [np.broadcast_to(values.get(name, other), bodies) for name, other in known]
    return np.stack(parts, axis=-1)


def _checked_names(scene: Scene, free: str | Sequence[str]) -> tuple[str, ...]:
    """The names of the free parameters: not of the direction to a centre of mass alone."""
    rows = {
        name: PARAMETERS[name]
        for name in differentiable(scene)
        if name not in (*MOMENTS, "damping") and PLACES[PARAMETERS[name].place].guess
    }
    known = (*MOMENTS, *RATIOS, *rows, *_GROUPS, *START, *BIAS, *SCALE, *SENSOR)
    names = checked_names(
        "free", free, known, _GROUPS, lambda name: why_not(name, scene, f" of a {scene.title}")
    )
    for name in names:
        reason = rows[name].why_not(scene, AT_REST) if name in rows else ""
        if reason:
            raise ValueError(f"free = {name!r}: {reason}")
        whole = rows[name].place if name in rows else name
        if whole != name and whole in names:
            raise ValueError(f"free = {brief(free)}: {whole!r} and {name!r} exclude each other")
    return names
