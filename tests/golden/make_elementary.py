"""Golden values of the elementary functions, to 40 digits by mpmath: writes elementary.json here.

    python make_elementary.py          (needs mpmath)

A value is two numbers: the nearest double, and what it misses in units of its last place (-0.5 to
0.5). So the error of a result in ulp is (result - nearest) / ulp(nearest) - miss, also where the
result is subnormal.
"""

import json
import math
import random
from pathlib import Path

import mpmath
from mpmath import mpf

mpmath.mp.prec = 400  # 1e8 needs 27 bits for its quadrants, a close multiple of pi/2 another 60
RNG = random.Random(20261121)


def nearest(value: mpf) -> float:
    """The nearest double, subnormal ones included (which float(mpf) rounds twice)."""
    unit = mpf(2) ** max(-1074, mpmath.frexp(value)[1] - 53) if value else mpf(1)
    # int * int is exact; ldexp of a whole number below 2^53 does not round.
    return math.ldexp(int(mpmath.nint(value / unit)), int(mpmath.log(unit, 2)))


def pair(value: mpf) -> list[float]:
    near = nearest(value)
    return [near, round(float((value - mpf(near)) / mpf(math.ulp(near))), 6)]


def neighbours(x: float, count: int = 1) -> list[float]:
    """x and `count` doubles on either side."""
    below, above = [x], [x]
    for _ in range(count):
        below.append(math.nextafter(below[-1], -math.inf))
        above.append(math.nextafter(above[-1], math.inf))
    return below[:0:-1] + above


def signed(points: list[float]) -> list[float]:
    return [x if RNG.random() < 0.5 else -x for x in points]


def closest_to_quarter_turns(limit: float, per_binade: int) -> list[float]:
    """The doubles below `limit` that lie closest to a multiple of pi/2, in units of their spacing.

    In a binade of spacing u they are the n with n (pi/2)/u closest to an integer. Such n are sums
    of a few denominators of convergents of (pi/2)/u: those are tried.
    """
    found = []
    for exponent in range(1, math.frexp(limit)[1] + 1):
        unit = mpf(2) ** (exponent - 53)
        alpha = mpmath.pi / 2 / unit
        denominators, x, (q0, q1) = [], alpha - mpmath.floor(alpha), (0, 1)
        while q1 < 2**27:
            denominators.append(q1)
            x = 1 / x
            q0, q1 = q1, q0 + q1 * int(mpmath.floor(x))
            x -= mpmath.floor(x)
        sums = {0}
        for q in reversed(denominators[-12:]):
            sums |= {s + k * q for s in sums for k in (-1, 1, 2) if abs(s + k * q) < 2**27}
            sums = set(sorted(sums, key=lambda n: abs(n * alpha - mpmath.nint(n * alpha)))[:400])
        low, high = 2.0 ** (exponent - 1), min(limit, 2.0**exponent)
        inside = [n for n in sums if low <= n * mpmath.pi / 2 < high]
        inside.sort(key=lambda n: abs(n * alpha - mpmath.nint(n * alpha)))
        found += [float(n * mpmath.pi / 2) for n in inside[:per_binade]]
    return found


def sincos_points() -> list[float]:
    quarter = math.pi / 4
    dense = [RNG.uniform(-quarter, quarter) for _ in range(450)]
    tiny = [0.0, 5e-324, -5e-324, 2.2250738585072014e-308, 1e-300, 1e-160, -1e-20, 1e-12]
    tiny += [math.ldexp(1.5, -k) for k in range(5, 35)]
    multiples = [*range(1, 40), *(RNG.randrange(40, 63_000_000) for _ in range(60))]
    near = [float(n * mpmath.pi / 2) for n in multiples]
    close = closest_to_quarter_turns(1e8, 8)
    borders = [y for n in (1, 3, 5, 7, 9, 1001) for y in neighbours(n * quarter)]
    large = [10 ** RNG.uniform(-1, 8) for _ in range(350)] + [1e8]
    # Found wanting among 3e5 points when the low part of the reduction was added after rounding.
    large += [29.071372301539487, 47.8826055618816]
    return dense + tiny + signed(near + close + borders + large)


def exp_points() -> list[float]:
    wide = [RNG.uniform(-745.0, 709.7) for _ in range(350)]
    small = [RNG.uniform(-1, 1) for _ in range(150)]
    subnormal = [RNG.uniform(-745.13, -708.3) for _ in range(150)]
    tiny = [0.0, 5e-324, *signed([math.ldexp(1.3, -k) for k in range(5, 60, 2)])]
    borders = [float((n + mpf(0.5)) * mpmath.log(2)) for n in range(-1070, 1024, 35)]
    edges = [709.782712893384, 709.7, -708.3964185322641, -745.0, -745.1, -745.1332191019411]
    return wide + small + subnormal + tiny + borders + edges


def ln_points() -> list[float]:
    wide = [mpf(2) ** RNG.uniform(-1022, 1024) for _ in range(350)]
    middle = [RNG.uniform(0.5, 2) for _ in range(250)]
    near_one = neighbours(1.0, 20) + [
        1 + s * math.ldexp(1.1, -k) for k in range(4, 50) for s in (1, -1)
    ]
    borders = [float(mpmath.sqrt(2) * mpf(2) ** k) for k in range(-1021, 1023, 40)]
    edges = [2.2250738585072014e-308, 2.0, 0.5, 10.0, 1.7976931348623157e308]
    return [float(x) for x in wide] + middle + near_one + borders + edges


def rodrigues_points() -> list[float]:
    limit = (math.pi / 4) ** 2
    small = [RNG.uniform(0, limit) for _ in range(60)] + [
        10 ** RNG.uniform(-40, -1) for _ in range(30)
    ]
    large = [limit * 10 ** RNG.uniform(0, 8) for _ in range(90)]
    return [0.0, 5e-324, *small, *neighbours(limit, 5), *large]


def rodrigues(z: float) -> tuple[mpf, mpf]:
    angle = mpmath.sqrt(mpf(z))
    if z == 0:
        return mpf(1), mpf(0.5)
    # sin^2(a/2) instead of 1 - cos a, which cancels; 400 bits would not carry z = 5e-324 otherwise.
    return mpmath.sin(angle) / angle, 2 * mpmath.sin(angle / 2) ** 2 / mpf(z)


def atan2_points() -> list[tuple[float, float]]:
    angles = [RNG.uniform(-math.pi, math.pi) for _ in range(250)]
    borders = [
        n * math.pi / 8 + s * e
        for n in range(-8, 9)
        for e in (0, 1e-15, 1e-9, 1e-3)
        for s in (1, -1)
    ]
    points = [(math.sin(a), math.cos(a)) for a in angles + borders]
    points += [
        (math.ldexp(y, k), math.ldexp(x, k))
        for k, (y, x) in zip(range(-900, 900, 20), points, strict=False)
    ]
    points += [(s * 10**-k, t) for k in range(1, 300, 13) for s in (1, -1) for t in (1, -1)]
    axes = [
        (0.0, 1.0),
        (1.0, 0.0),
        (-1.0, 0.0),
        (0.0, -1.0),
        (1.0, 1.0),
        (-1.0, 1.0),
        (1.0, -1.0),
        (-1.0, -1.0),
    ]
    return points + axes


def rows(points: list[float], *functions: object) -> list[list[float]]:
    return [[x, *(y for f in functions for y in pair(f(mpf(x))))] for x in dict.fromkeys(points)]


def main() -> None:
    tables = {
        "sincos": rows(sincos_points(), mpmath.sin, mpmath.cos),
        "exp": rows(exp_points(), mpmath.exp),
        "ln": rows(ln_points(), mpmath.log),
        "atan2": [[y, x, *pair(mpmath.atan2(mpf(y), mpf(x)))] for y, x in atan2_points()],
        "rodrigues": [
            [z, *(y for value in rodrigues(z) for y in pair(value))] for z in rodrigues_points()
        ],
    }
    for name, table in tables.items():
        print(name, len(table))
    body = ",\n".join(
        f' "{name}": [\n' + ",\n".join("  " + json.dumps(row) for row in table) + "\n ]"
        for name, table in tables.items()
    )
    Path(__file__).with_name("elementary.json").write_text("{\n" + body + "\n}\n")


if __name__ == "__main__":
    main()
