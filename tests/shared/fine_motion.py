"""What a map measures of a body, from SciPy's DOP853 at 1e-13: the truth shares no line of rigid.

The equations of motion stand here once more, as numbers of Python. Flips, times of leaving and the
largest tilt are sought in the dense output of the solver.
"""

from collections.abc import Callable, Iterator
from functools import cached_property, partial
from itertools import pairwise
from math import sqrt
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, minimize_scalar

from physics import angle_between, place_on_orbit, rotated
from rigid.model.measures import Measure
from rigid.model.scene import Scene

Floats = NDArray[np.float64]

#: Looks inside a step of the solver, which turns the body by some hundredths of a radian.
LOOKS = 8

#: Change of a start that tells how sensitive a value is: relative to the rates, and rad.
NUDGE = 1e-6


def _cross(a: Any, b: Any) -> list[float]:
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def _slopes(scene: Scene) -> Callable[[float, Any], list[float]]:
    """The rates of change of rates, quaternion and turned angles."""
    moments = [float(moment) for moment in np.array(scene.body.moments)]
    torque, sink = scene.torque, getattr(scene, "dissipation", None)
    weight = np.array(getattr(scene, "com", (0.0, 0.0, 0.0))) * getattr(scene, "mgl", 0.0)
    none = np.zeros(3)

    def three(value: Any) -> list[float]:
        numbers: list[float] = np.array(none if value is None else value).ravel().tolist()
        return numbers

    body, space = (three(torque and getattr(torque, name)) for name in ("in_body", "in_space"))
    damping = np.array(np.zeros((3, 3)) if scene.damping is None else scene.damping).tolist()
    rotor, drag = three(getattr(scene, "rotor", None)), three(scene.drag)
    loss, heavy = three(sink and sink.coefficient), weight.tolist()
    orbit = scene.orbit

    def slopes(t: float, y: Any) -> list[float]:
        w, q = y[:3].tolist(), y[3:7].tolist()
        size = sqrt(sum(part * part for part in q))
        a, b, c, d = (part / size for part in q)
        rows = (
            (1 - 2 * (c * c + d * d), 2 * (b * c - a * d), 2 * (b * d + a * c)),
            (2 * (b * c + a * d), 1 - 2 * (b * b + d * d), 2 * (c * d - a * b)),
            (2 * (b * d - a * c), 2 * (c * d + a * b), 1 - 2 * (b * b + c * c)),
        )
        momentum = [moments[k] * w[k] + rotor[k] for k in range(3)]
        turning, falling = _cross(momentum, w), _cross(heavy, rows[2])
        speed = sqrt(sum(rate * rate for rate in w))
        pull = [0.0, 0.0, 0.0]
        if orbit is not None:
            place = place_on_orbit(orbit, t).tolist()
            distance = sqrt(sum(part * part for part in place))
            o = [sum(rows[i][k] * place[i] for i in range(3)) for k in range(3)]
            side = _cross(o, [moments[k] * o[k] for k in range(3)])
            pull = [3.0 * float(orbit.rate) ** 2 / distance**5 * part for part in side]
        change = []
        for k in range(3):
            pushed = body[k] + pull[k] + sum(rows[i][k] * space[i] for i in range(3))
            slowed = sum(damping[k][i] * w[i] for i in range(3)) + speed * drag[k] * w[k]
            change.append((turning[k] - falling[k] + pushed - slowed) / moments[k])
        ahead = [loss[k] * change[k] / moments[k] for k in range(3)]
        lag = _cross(momentum, ahead)
        x, y_, z = (w[k] + ahead[k] for k in range(3))
        return [
            *(change[k] + lag[k] / moments[k] for k in range(3)),
            0.5 * (-b * x - c * y_ - d * z),
            0.5 * (a * x + c * z - d * y_),
            0.5 * (a * y_ + d * x - b * z),
            0.5 * (a * z + b * y_ - c * x),
            *w,
        ]

    return slopes


def unit(axis: int) -> Floats:
    """A body axis, negative for its opposite."""
    vector: Floats = np.sign(axis) * np.eye(3)[abs(axis) - 1]
    return vector


class FineMotion:
    """The motion of one body from 0 to ``t_end``.

    Attributes
    ----------
    turned : float
        Angle that the body turns by (rad).
    """

    def __init__(self, scene: Scene, omega: ArrayLike, attitude: ArrayLike, t_end: float) -> None:
        start = np.concatenate([omega, attitude, np.zeros(3)])
        found = solve_ivp(
            _slopes(scene),
            (0.0, t_end),
            start,
            method="DOP853",
            rtol=1e-13,
            atol=1e-15,
            dense_output=True,
        )
        assert found.success, found.message
        self.at = found.sol
        steps = [np.linspace(a, b, LOOKS + 1)[:-1] for a, b in pairwise(found.t)]
        self.t = np.append(np.concatenate(steps), t_end)
        self.states = self.at(self.t)
        self._start = np.array(attitude)
        speed = np.linalg.norm(self.states[:3], axis=0)
        self._fastest = float(speed.max())
        self.turned = float(np.trapezoid(speed, self.t))

    def flips(self, axis: int) -> tuple[int, float]:
        """Sign changes of a rate, and the time of the first; infinite if there is none."""
        values = self.states[axis - 1]

        def rate(t: float) -> float:
            return float(self.at(t)[axis - 1])

        known: list[int] = np.flatnonzero(
            values
        ).tolist()  # a rate that is zero at the start has no sign
        times: list[float] = []
        for i, j in pairwise(known):
            if values[i] * values[j] < 0.0:
                times.append(brentq(rate, self.t[i], self.t[j], xtol=1e-14))
        # Two between looks: the rate comes near zero and goes away again.
        for i, ends in self._peaks(-np.abs(values)):
            sign = np.sign(values[i])
            if all(sign * rate(end) > 0.0 for end in ends):
                lowest = _least(partial(_times, sign, rate), ends)
                if sign * rate(lowest) < 0.0:
                    times += [brentq(rate, ends[0], lowest), brentq(rate, lowest, ends[1])]
        return len(times), min(times, default=np.inf)

    def tilt(self, t: Any, axis: int, reference: str) -> Floats:
        """Angle (rad) of a body axis from the vertical, or from where it started."""
        origin = rotated(self._start, unit(axis)) if reference == "start" else unit(3)
        return angle_between(rotated(self.attitude(t), unit(axis)), origin)

    def attitude(self, t: Floats) -> Floats:
        """Unit quaternions at some times, shape (m, 4)."""
        states = self.at(t)[3:7].T
        attitude: Floats = states / np.linalg.norm(states, axis=-1, keepdims=True)
        return attitude

    def gamma(self, t: Floats) -> Floats:
        """The upward vertical in the body, shape (m, 3)."""
        return rotated(self.attitude(t) * [1.0, -1.0, -1.0, -1.0], unit(3))

    def largest_tilt(self, axis: int, reference: str) -> float:
        """The largest of these angles (rad)."""
        looks = self.tilt(self.t, axis, reference)
        best = float(looks.max())
        # Between two looks a tilt rises by no more than the body turns. A sink turns it by a
        # little more than its rates do.
        rise = 0.6 * self._fastest * np.diff(self.t)
        for i, ends in self._peaks(looks):
            if looks[i] + rise[max(i - 1, 0) : i + 1].max() > best:
                at = _least(lambda t: -float(self.tilt(t, axis, reference)), ends)
                best = max(best, float(self.tilt(at, axis, reference)))
        return best

    def time_beyond(self, angle: float, axis: int, reference: str) -> float:
        """The first time at which the tilt is above an angle; infinite for never."""
        looks = self.tilt(self.t, axis, reference)

        def beyond(t: float) -> float:
            return float(self.tilt(t, axis, reference)) - angle

        if looks[0] > angle:
            return 0.0
        first = int(np.argmax(looks > angle)) if (looks > angle).any() else len(looks)
        for i, (begin, end) in self._peaks(looks):
            if i <= first and beyond(at := _least(lambda t: -beyond(t), (begin, end))) > 0.0:
                return float(brentq(beyond, begin, at, xtol=1e-14))
        if first == len(looks):
            return np.inf
        return float(brentq(beyond, self.t[first - 1], self.t[first], xtol=1e-14))

    def _peaks(self, looks: Floats) -> Iterator[tuple[int, tuple[float, float]]]:
        """Looks that no neighbour exceeds, with the times of their neighbours."""
        padded = np.concatenate([[-np.inf], looks, [-np.inf]])
        places: list[int] = np.flatnonzero((looks >= padded[:-2]) & (looks >= padded[2:])).tolist()
        for i in places:
            yield i, (self.t[max(i - 1, 0)], self.t[min(i + 1, len(looks) - 1)])

    def mean_rate(self, axis: int) -> float:
        """Mean over the time of the rate about a body axis."""
        return float(self.states[7:][abs(axis) - 1, -1] / self.t[-1] * np.sign(axis))

    def value(self, measure: Measure) -> float:
        """The value of a measure that needs no criterion."""
        if measure.name == "flips":
            return float(self.flips(measure.axis or 0)[0])
        if measure.name == "mean_rate":
            return self.mean_rate(measure.axis or 0)
        assert measure.name == "largest_tilt"
        return self.largest_tilt(measure.axis or 0, measure.reference or "")


def _times(factor: float, function: Callable[[float], float], t: float) -> float:
    return factor * function(t)


def _least(function: Callable[[float], float], ends: tuple[float, float]) -> float:
    found = minimize_scalar(
        function, bounds=ends, method="bounded", options={"xatol": 1e-12 * (1.0 + ends[1])}
    )
    return float(found.x)


class Truths:
    """A motion, and motions from starts beside its own: they tell how sensitive its values are."""

    def __init__(self, scene: Scene, omega: Floats, attitude: Floats, t_end: float) -> None:
        self._asked = scene, omega, attitude, t_end
        self.motion = FineMotion(scene, omega, attitude, t_end)

    @cached_property
    def beside(self) -> list[FineMotion]:
        """Motions from starts that differ by :data:`NUDGE` in two directions."""
        scene, omega, attitude, t_end = self._asked
        motions, rng = [], np.random.default_rng(1)
        for _ in range(2):
            rates, turn = rng.normal(size=(2, 3))
            w, x = attitude[:1], attitude[1:]
            half = 0.5 * NUDGE * turn / np.linalg.norm(turn)
            moved = np.concatenate([w - x @ half, x + w * half + np.cross(x, half)])
            nudge = NUDGE * np.linalg.norm(omega) * rates / np.linalg.norm(rates)
            motions.append(FineMotion(scene, omega + nudge, moved / np.linalg.norm(moved), t_end))
        return motions

    def agrees(
        self, found: ArrayLike, of: Callable[[FineMotion], ArrayLike], error: float = 1e-7
    ) -> bool:
        """Whether the numbers that a map found are those of the motion, up to an error per radian.

        The steps of a map err by about 1e-8 rad for each radian, of one body in 400 by more than
        ten times as much: 1e-7 is allowed. An error made on the way is magnified as a change of the
        start is, along one of two random directions. What such a change makes infinite, or a whole
        number more, is decided by errors.
        """
        true, error = of(self.motion), error * self.motion.turned
        if (_distance(found, true) <= 1e-9 + error).all():
            return True
        grown = np.maximum.reduce([_distance(of(one), true) / NUDGE for one in self.beside])
        return bool((_distance(found, true) <= 1e-9 + error * np.maximum(grown, 1.0)).all())


def _distance(one: ArrayLike, other: ArrayLike) -> Floats:
    """How far numbers are apart; two infinite ones are equal."""
    a, b = np.asarray(one, dtype=np.float64), np.asarray(other, dtype=np.float64)
    same = a == b
    distance: Floats = np.abs(np.where(same, 0.0, a) - np.where(same, 0.0, b))
    return distance
