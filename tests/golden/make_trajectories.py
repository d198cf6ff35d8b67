"""Makes reference motions again from their starts, and compares the stored digits.

    python make_trajectories.py [TEXT ...]

takes the scenes whose name contains a text, by default all of `free_*`, `lab_box`, `lagrange`,
`pendulum`, `kovalevskaya`, `heavy_asymmetric`, `forced_damped`, `chaos`, `sections`, `satellites`
and `flybys`. The equations are those of README.md, integrated by Taylor series of order 50 in
fixed-point numbers of 256 binary digits: right sides are sums of products of two variables, and so
are variables that stand for longer products.
"""

import json
import sys
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from fractions import Fraction
from math import isqrt
from operator import mul
from pathlib import Path
from typing import Any

import mpmath

BITS, ORDER = 256, 50
ONE = 1 << BITS
mpmath.mp.prec = BITS + 64

#: The last term of a series, as a share of the largest variable: 57 digits.
LAST_TERM = 2.0**-190

#: Error of the tangents of satellites and flybys, which are central differences of 1e-11: the
#: square of that times a third derivative, which grows as the cube of the tangents.
TANGENT = Fraction(1, 10**20)

Number = int | float | Fraction
Term = tuple[Number, str, str]
"""A coefficient, and the two variables of a product; "1" is one."""
Equations = dict[str, list[Term]]
Values = dict[str, int]

CYCLES = ((0, 1, 2), (1, 2, 0), (2, 0, 1))


def fixed(value: Number) -> int:
    """A number in units of 2^-256; of a double its exact value."""
    exact = Fraction(value)
    return (exact.numerator << BITS) // exact.denominator


class Motion:
    """The solution from time zero on: derivatives of variables, and variables that are defined."""

    def __init__(self, rates: Equations, defined: Equations, start: Values) -> None:
        def exact(terms: list[Term]) -> list[tuple[int, str, str]]:
            return [(fixed(c), *sorted(pair)) for c, *pair in terms if c]

        self._rates = {name: exact(terms) for name, terms in rates.items()}
        self._defined = {name: exact(terms) for name, terms in defined.items()}
        self._now, self._time, self._step, self.steps = dict(start), 0, ONE >> 30, 0

    def _series(self) -> dict[str, list[int]]:
        """Coefficients of powers of the time in units of the step."""
        series = {name: [value] for name, value in self._now.items()}
        series |= {name: [] for name in self._defined}
        for k in range(ORDER):
            products: dict[tuple[str, str], int] = {}

            def product(one: str, other: str, k: int = k, known: Any = products) -> int:
                if one == "1":  # which sorts before other names
                    return (ONE if k == 0 else 0) if other == "1" else series[other][k]
                if (one, other) not in known:
                    pairs = map(mul, series[one][: k + 1], series[other][k::-1])
                    known[one, other] = sum(pairs) >> BITS
                return int(known[one, other])

            for name, terms in self._defined.items():
                series[name].append(sum(c * product(*pair) for c, *pair in terms) >> BITS)
            for name, terms in self._rates.items():
                rate = sum(c * product(*pair) for c, *pair in terms) >> BITS
                series[name].append((self._step * rate >> BITS) // (k + 1))
        return series

    def slope(self) -> Values:
        """The derivatives of the variables."""
        return {name: ONE * values[1] // self._step for name, values in self._series().items()}

    def at(self, when: Number) -> Values:
        """The variables at a time that is not before the last one."""
        end = fixed(when)
        while self._time < end:
            series = self._series()
            # Two terms, because one of them may vanish.
            last = max(abs(series[name][k]) for name in self._now for k in (ORDER - 1, ORDER)) / ONE
            size = max(map(abs, self._now.values())) / ONE
            share = fixed(min((LAST_TERM * size / last) ** (1.0 / ORDER), 8.0) if last else 8.0)
            ends = self._time + (self._step * share >> BITS) >= end
            if ends:
                share = ((end - self._time) << BITS) // self._step
            for name in self._now:
                value = 0
                for coefficient in reversed(series[name]):
                    value = coefficient + (value * share >> BITS)
                self._now[name] = value
            step = self._step * share >> BITS
            self._time = end if ends else self._time + step
            self._step = self._step if ends else step
            self.steps += 1
        return dict(self._now)


def cross(one: str, other: str, factor: Number = 1) -> list[list[Term]]:
    """The components of a cross product of vectors, whose variables end with the axis."""
    return [
        [(factor, f"{one}{j}", f"{other}{k}"), (-factor, f"{one}{k}", f"{other}{j}")]
        for _, j, k in CYCLES
    ]


def linear(matrix: Sequence[Sequence[Number]], vector: str) -> list[list[Term]]:
    """The components of a matrix times a vector."""
    return [[(row[j], "1", f"{vector}{j}") for j in range(3)] for row in matrix]


def total(*vectors: Iterable[list[Term]]) -> list[list[Term]]:
    return [
        [term for terms in components for term in terms]
        for components in zip(*vectors, strict=True)
    ]


def minus(vector: Iterable[list[Term]]) -> list[list[Term]]:
    return [[(-c, one, other) for c, one, other in terms] for terms in vector]


def named(name: str, vector: Iterable[list[Term]]) -> Equations:
    return {f"{name}{i}": terms for i, terms in enumerate(vector)}


def diagonal(values: Sequence[Number]) -> list[list[Number]]:
    return [[values[i] if i == j else 0 for j in range(3)] for i in range(3)]


def inverse(matrix: Sequence[Sequence[Number]]) -> list[list[Fraction]]:
    """By cofactors, exactly."""
    m = [[Fraction(value) for value in row] for row in matrix]
    cofactor = [[m[j][n] * m[k][o] - m[j][o] * m[k][n] for _, n, o in CYCLES] for _, j, k in CYCLES]
    determinant = sum(a * b for a, b in zip(m[0], cofactor[0], strict=True))
    return [[cofactor[j][i] / determinant for j in range(3)] for i in range(3)]


class Body:
    """Equations of a body: rates ``w``, and whatever else is asked for.

    ``g`` is the vertical and ``a``, ``b`` the space axes 1 and 2 in the body, ``q`` the attitude;
    ``u0`` to ``u5`` and ``x0`` to ``x5`` are changes of rates and rotation vectors in the body.
    """

    def __init__(
        self,
        inertia: Sequence[Sequence[Number]],
        omega: Sequence[Number],
        *,
        weight: Sequence[Number] = (0, 0, 0),
        torque: Sequence[Number] = (0, 0, 0),
        damping: Sequence[Number] = (0, 0, 0),
        rotor: Sequence[Number] = (0, 0, 0),
    ) -> None:
        self.inertia, self._inverse = inertia, inverse(inertia)
        self._weight = [[(weight[i], "1", f"g{i}")] for i in range(3)]
        self._torque = [[(torque[i], "1", "1")] for i in range(3)]
        self._rotor = [[(rotor[i], "1", "1")] for i in range(3)]
        self._drag = diagonal([-value for value in damping])
        self._fields: list[str] = []
        self.rates: Equations = {}
        self.defined = named("L", total(linear(inertia, "w"), self._rotor))
        self.start = {f"w{i}": fixed(value) for i, value in enumerate(omega)}
        self._heavy = weight
        self._acting = [cross("L", "w"), self._torque, linear(self._drag, "w")]

    def carry(self, name: str, values: Sequence[int]) -> None:
        """A vector that is constant in space, by its components in the body."""
        self.rates |= named(name, cross(name, "w"))
        self.start |= {f"{name}{i}": value for i, value in enumerate(values)}

    def carry_vertical(self, values: Sequence[int]) -> None:
        """The vertical, with the torque of the weight: ``-weight x g``."""
        self.carry("g", values)
        self._acting.append(weighed(self._heavy, "g"))

    def carry_attitude(self, q: Sequence[int]) -> None:
        """The quaternion, scalar last: ``q' = q (w, 0)/2``."""
        half = Fraction(1, 2)
        turned = cross("q", "w", half)
        self.rates |= named("q", [[*turned[i], (half, "q3", f"w{i}")] for i in range(3)])
        self.rates["q3"] = [(-half, f"q{i}", f"w{i}") for i in range(3)]
        self.start |= {f"q{i}": value for i, value in enumerate(q)}

    def carry_orbit(self, place: Sequence[int], velocity: Sequence[int]) -> None:
        """The orbit about a unit of gravity at the origin, and the torque of its gradient.

        ``r`` is the place with its square ``r.v``; ``p`` and ``s`` are the inverse square and cube
        of the distance, whose derivatives are ``-2 p p r.v`` and ``-3 s p r.v``.
        """
        distance = isqrt(place[0] ** 2 + place[1] ** 2)
        names = ("r0", "r1", "v0", "v1", "p", "s")
        inverse_square = ONE**3 // distance**2
        values = (*place, *velocity, inverse_square, inverse_square * ONE // distance)
        self.start |= dict(zip(names, values, strict=True))
        self.defined |= {
            "d": [(1, "r0", "v0"), (1, "r1", "v1")],
            "pd": [(1, "p", "d")],
            "k": [(3, "p", "s")],
            **named("c", [[(1, "r0", f"a{i}"), (1, "r1", f"b{i}")] for i in range(3)]),
            **named("C", linear(self.inertia, "c")),
            **named("m", cross("c", "C")),
        }
        self.rates |= {"r0": [(1, "1", "v0")], "r1": [(1, "1", "v1")]}
        self.rates |= {"v0": [(-1, "r0", "s")], "v1": [(-1, "r1", "s")]}
        self.rates |= {"p": [(-2, "p", "pd")], "s": [(-3, "s", "pd")]}
        self._acting.append([[(1, "k", f"m{i}")] for i in range(3)])

    def carry_deviations(self) -> None:
        """Six changes of the start: ``u' = ...`` is the rule of products, ``x' = u - w x x``."""
        for column in range(6):
            u, x = f"u{column}", f"x{column}"
            self.defined |= named(f"D{u}", linear(self.inertia, u))
            acting = [cross(f"D{u}", "w"), cross("L", u), linear(self._drag, u)]
            if "g0" in self.rates:
                self.defined |= named(f"G{x}", cross("g", x))
                acting.append(weighed(self._heavy, f"G{x}"))
            if "k" in self.defined:
                self.defined |= named(f"c{x}", cross("c", x))
                self.defined |= named(f"C{x}", linear(self.inertia, f"c{x}"))
                self.defined |= named(f"m{x}", total(cross(f"c{x}", "C"), cross("c", f"C{x}")))
                acting.append([[(1, "k", f"m{x}{i}")] for i in range(3)])
            self.defined |= named(f"T{u}", total(*acting))
            self.rates |= named(u, linear(self._inverse, f"T{u}"))
            self.rates |= named(x, total(linear(diagonal([1, 1, 1]), u), minus(cross("w", x))))
            for i in range(3):
                self.start[f"{u}{i}"] = ONE * (column == i)
                self.start[f"{x}{i}"] = ONE * (column == i + 3)

    def motion(self) -> Motion:
        """From the start on, with ``I w' = T``."""
        defined = {**self.defined, **named("T", total(*self._acting))}
        return Motion({**self.rates, **named("w", linear(self._inverse, "T"))}, defined, self.start)


def weighed(weight: Sequence[Number], vertical: str) -> list[list[Term]]:
    """The torque of a weight at a place in the body: ``-weight x g``."""
    return [
        [
            (-Fraction(weight[j]), "1", f"{vertical}{k}"),
            (Fraction(weight[k]), "1", f"{vertical}{j}"),
        ]
        for _, j, k in CYCLES
    ]


def unit(values: Sequence[Number]) -> list[int]:
    """A quaternion of length one."""
    exact = [fixed(value) for value in values]
    length = isqrt(sum(value * value for value in exact))
    return [(value << BITS) // length for value in exact]


def rows(q: Sequence[int]) -> list[list[int]]:
    """The axes of space in the body, of a unit quaternion with the scalar last."""
    s = q[3]
    dot = sum(value * value for value in q[:3])
    matrix = []
    for i in range(3):
        row = []
        for j in range(3):
            other = 3 - i - j
            turned = 0 if i == j else q[other] * (-1 if (i, j) in ((0, 1), (1, 2), (2, 0)) else 1)
            entry = 2 * q[i] * q[j] + 2 * s * turned + ((s * s - dot) if i == j else 0)
            row.append(entry >> BITS)
        matrix.append(row)
    return matrix


def dot(one: Iterable[Number], other: Iterable[Number]) -> Fraction:
    return sum((Fraction(a) * Fraction(b) for a, b in zip(one, other, strict=True)), Fraction())


def half_unit(text: str) -> Fraction:
    """Half a unit of the last digit of a decimal number."""
    digits, _, power = text.partition("e")
    places = len(digits.partition(".")[2])
    return Fraction(10) ** (int(power or 0) - places) / 2


class Comparison:
    """The largest distance from stored numbers, in half units of their last digits."""

    def __init__(self) -> None:
        self.worst, self.numbers = 0.0, 0

    def number(self, found: int, stored: str | float, more: Fraction | int = 0) -> None:
        """Decimal texts have 25 digits, doubles 53 bits; zeros are those of a sum of size one."""
        value = Fraction(stored)
        allowed = more + (half_unit(stored) if isinstance(stored, str) else abs(value) / 2**53)
        off = abs(Fraction(found, ONE) - value)
        self.worst = max(self.worst, float(off / max(allowed, Fraction(1, 10**26))))
        self.numbers += 1

    def vector(self, found: Mapping[str, int], name: str, stored: Sequence[Any]) -> None:
        for i, value in enumerate(stored):
            self.number(found[f"{name}{i}"], value)


def trajectory(scene: Mapping[str, Any]) -> Iterator[tuple[Motion, Comparison]]:
    """A scene of the trajectories: rates, attitude, energy and angular momentum in space."""
    inertia = scene["inertia"]
    inertia = inertia if isinstance(inertia[0], list) else diagonal(inertia)
    factor = Fraction(scene["mass"]) * Fraction(scene["gravity"])
    weight = [factor * Fraction(value) for value in scene["com"]]
    damping = [scene.get("damping", 0.0)] * 3
    torque = scene.get("torque_body", (0, 0, 0))
    body = Body(inertia, scene["omega0"], weight=weight, torque=torque, damping=damping)
    q = unit(scene["q0"])
    body.carry_vertical(rows(q)[2])
    body.carry_attitude(q)
    motion, comparison = body.motion(), Comparison()
    for sample in scene["samples"]:
        now = motion.at(sample["t"])
        comparison.vector(now, "w", sample["omega"])
        q = [now[f"q{i}"] for i in range(4)]
        opposite = sum(a * fixed(Fraction(b)) for a, b in zip(q, sample["q"], strict=True)) < 0
        for value, stored in zip(q, sample["q"], strict=True):
            comparison.number(-value if opposite else value, stored)
        omega = [Fraction(now[f"w{i}"], ONE) for i in range(3)]
        momentum = [dot(row, omega) for row in inertia]
        height = [w * Fraction(now[f"g{i}"], ONE) for i, w in enumerate(weight)]
        energy = dot(momentum, omega) / 2 + sum(height)
        comparison.number(fixed(energy), sample["energy"])
        for row, stored in zip(rows(q), sample["L_space"], strict=True):
            comparison.number(fixed(dot(row, momentum) / ONE), stored)
        yield motion, comparison


def deviations(scene: Mapping[str, Any]) -> Iterator[tuple[Motion, Comparison]]:
    """A scene of `chaos.json`: the matrix of changes of the state by changes of the start."""
    moments, damping = diagonal(scene["moments"]), scene["damping"]
    body = Body(moments, scene["omega"], weight=scene["weight"], damping=damping)
    body.carry_vertical([fixed(value) for value in scene["gamma"]])
    body.carry_deviations()
    yield from tangents(body, scene)


def tangents(body: Body, scene: Mapping[str, Any]) -> Iterator[tuple[Motion, Comparison]]:
    """States and changes; of bodies on orbits a time may be rounded, as of two revolutions."""
    motion, comparison = body.motion(), Comparison()
    for state in scene["at"]:
        now = motion.at(state["t"])
        is_exact = "matrix" in state
        slope = {} if is_exact else motion.slope()

        def allowed(name: str, time: Number = state["t"], slope: Values = slope) -> Fraction:
            return Fraction(time) * abs(slope.get(name, 0)) / ONE / 2**53

        for name, key in (("w", "omega"), ("r", "position")):
            for i, stored in enumerate(state.get(key, ())):
                comparison.number(now[f"{name}{i}"], stored, allowed(f"{name}{i}"))
        matrix = state["matrix" if is_exact else "tangent"]
        largest = max(abs(stored) for row in matrix for stored in row)
        of_differences = 0 if is_exact else TANGENT * Fraction(max(largest, 5.0)) ** 3
        for i, row in enumerate(matrix):
            for column, stored in enumerate(row):
                name = f"{'ux'[i // 3]}{column}{i % 3}"
                comparison.number(now[name], stored, of_differences + allowed(name))
        if not is_exact:
            names = ("q3", "q0", "q1", "q2")
            pairs = zip(names, state["attitude"], strict=True)
            opposite = sum(now[name] * fixed(stored) for name, stored in pairs) < 0
            for name, stored in zip(names, state["attitude"], strict=True):
                found = -now[name] if opposite else now[name]
                comparison.number(found, stored, allowed(name))
        yield motion, comparison


def on_orbit(scene: Mapping[str, Any]) -> Iterator[tuple[Motion, Comparison]]:
    """A scene of `satellites.json` or `flybys.json`, whose numbers are decimal."""
    numbers = ("moments", "omega", "rotor", "attitude", "e", "true_anomaly")
    scene = {**scene, **{key: decimal(scene[key]) for key in numbers}}
    states = [{**state, "t": Fraction(f"{state['t']:.17g}")} for state in scene["at"]]
    body = Body(diagonal(scene["moments"]), scene["omega"], rotor=scene["rotor"])
    scalar, *vector = scene["attitude"]
    q = unit([*vector, scalar])
    first, second, _ = rows(q)
    body.carry("a", first)
    body.carry("b", second)
    body.carry_attitude(q)
    e, anomaly = (mpmath.mpf(x.numerator) / x.denominator for x in map(scene.get, numbers[-2:]))
    parameter = abs(1 - e * e)
    sine, cosine = mpmath.sin(anomaly), mpmath.cos(anomaly)
    distance, speed = parameter / (1 + e * cosine), 1 / mpmath.sqrt(parameter)
    place, velocity = (
        [int(mpmath.floor(value * ONE)) for value in pair]
        for pair in (
            (distance * cosine, distance * sine),
            (-speed * sine, speed * (e + cosine)),
        )
    )
    body.carry_orbit(place, velocity)
    body.carry_deviations()
    yield from tangents(body, {**scene, "at": states})


def decimal(value: Any) -> Any:
    """The decimal numbers that a program read, of which the file has the doubles."""
    return [decimal(part) for part in value] if isinstance(value, list) else Fraction(repr(value))


def crossings(scene: Mapping[str, Any]) -> Iterator[tuple[Motion, Comparison]]:
    """A scene of `sections.json`: the states at its times, which are rounded to doubles."""
    body = Body(diagonal(scene["moments"]), scene["omega"], weight=scene["weight"])
    body.carry_vertical([fixed(value) for value in scene["gamma"]])
    motion, comparison = body.motion(), Comparison()
    for point in scene["points"]:
        now = motion.at(point["t"])
        slope = motion.slope()
        for i in range(3):
            for name, key in (("w", "omega"), ("g", "gamma")):
                moved = point["t"] * abs(slope[f"{name}{i}"]) / ONE
                comparison.number(now[f"{name}{i}"], point[key][i], Fraction(moved) / 2**53)
        yield motion, comparison


FILES = {
    "free_asymmetric": trajectory,
    "free_symmetric": trajectory,
    "lab_box": trajectory,
    "lagrange": trajectory,
    "pendulum": trajectory,
    "kovalevskaya": trajectory,
    "heavy_asymmetric": trajectory,
    "forced_damped": trajectory,
    "chaos": deviations,
    "sections": crossings,
    "satellites": on_orbit,
    "flybys": on_orbit,
}


def main(texts: Sequence[str]) -> int:
    wrong = 0
    for file, check in FILES.items():
        document = json.loads((Path(__file__).parent / f"{file}.json").read_text())
        for scene in document if isinstance(document, list) else document["scenes"]:
            name = scene.get("id") or f"{file}/{scene['name']}"
            if texts and not any(text in name for text in texts):
                continue
            begin = time.perf_counter()
            *_, (motion, comparison) = check(scene)
            seconds = time.perf_counter() - begin
            agrees = comparison.worst <= 1.01
            wrong += not agrees
            print(
                f"{name:40} {comparison.numbers:5} numbers, {motion.steps:7} steps, "
                f"{seconds:6.1f} s: {'agrees' if agrees else 'DIFFERS'}, "
                f"{comparison.worst:.2f} half units",
                flush=True,
            )
    return int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
