"""Golden values of the elliptic functions and integrals, by mpmath: writes elliptic.json here.

    python make_elliptic.py          (needs mpmath)

Values are pairs as in make_elementary.py: the nearest double, and what it misses in units of its
last place. The precision is far above 40 digits: at mc = 1e-300 the parameter m = 1 - mc needs 1000
bits, R_J with a small p and the theta series of mpmath, whose nome is then close to 1, more.
"""

import json
import random
from collections.abc import Callable
from pathlib import Path

import mpmath
from make_elementary import neighbours, pair
from mpmath import mpf

mpmath.mp.prec = 4000
RNG = random.Random(20261121)

# The largest errors among some 1e4 random points for each function.
WORST = {
    "rf": [[2.7279311556444045e-16, 1.3106918605759055e20, 9.813242600099377e-24]],
    "rc": [[2.248782394697856, -5.117900327460107], [1.3599807691885801, 1.0441063577742589]],
    "rd": [[1.7975039653957016e-06, 4452155.852719793, 24.267765757219664]],
    "rj": [
        [0.005864671074538022, 5.2502024265677995e-09, 663992.3270274576, 0.0009852408063101424]
    ],
    "agm": [[7.977490895545843e45, 3.322401417916531e-28]],
    "complete_k": [[4.495523487517495e-25]],
}


def spread(decades: float) -> float:
    """A number between 10^-decades and 10^decades, uniform in its logarithm."""
    return 10.0 ** RNG.uniform(-decades, decades)


def symmetric_points(count: int, arguments: int, decades: list[float]) -> list[list[float]]:
    """`count` points of every width; in every sixth the first argument is 0."""
    return [
        [0.0 if i == 0 and n % 6 == 0 else spread(width) for i in range(arguments)]
        for width in decades
        for n in range(count)
    ]


def rf_points() -> list[list[float]]:
    points = symmetric_points(70, 3, [0.02, 0.3, 1.0, 3.0, 30.0, 300.0])
    corners = [(x, y, z) for x in (1e-300, 1e300) for y in (1e-300, 1e300) for z in (0.0, 1.0)]
    equal = [(1.0, 1.0, 1.0), (0.0, 1.0, 1.0), (3.0, 3.0, 0.1), (1e-300, 1e-300, 1e-300)]
    return [*points, *(list(p) for p in corners + equal), *WORST["rf"]]


def rc_points() -> list[list[float]]:
    points = symmetric_points(50, 2, [0.02, 0.2, 1.0, 3.0, 30.0, 300.0])
    borders = [[1.0, y] for limit in (0.8, 1.0, 1.2) for y in neighbours(limit, 3)]
    principal = [[spread(width), -spread(width)] for width in (0.3, 3.0, 150.0) for _ in range(20)]
    return points + borders + principal + WORST["rc"]


def rd_points() -> list[list[float]]:
    return symmetric_points(60, 3, [0.02, 0.3, 1.0, 3.0, 30.0, 100.0]) + WORST["rd"]


def rj_points() -> list[list[float]]:
    points = symmetric_points(50, 4, [0.02, 0.3, 1.0, 3.0, 30.0])
    far = [[0.0, spread(3.0), spread(3.0), spread(100.0)] for _ in range(40)]
    equal = [[x, y, p, p] for x, y, p in ((1.0, 2.0, 0.5), (0.0, 1.0, 1.0), (1.0, 1.0, 1.0))]
    return points + far + equal + WORST["rj"]


def agm_points() -> list[list[float]]:
    wide = [[1.0, 10.0**-k] for k in range(0, 301, 15)]
    return symmetric_points(40, 2, [0.02, 0.3, 3.0, 150.0])[1:] + wide + WORST["agm"]


def complements(count: int) -> list[float]:
    """Complementary parameters over all their scales, towards 0 and towards 1."""
    flat = [RNG.random() for _ in range(count)]
    border = [x for near in (0.5, 1.0) for x in neighbours(near, 2) if x <= 1]
    border += [0.5 + RNG.uniform(-1e-3, 1e-3) for _ in range(count // 8)]
    small = [10.0 ** RNG.uniform(-30, 0) for _ in range(count)]
    tiny = [10.0 ** RNG.uniform(-300, -30) for _ in range(count // 4)]
    near_one = [1 - 10.0 ** RNG.uniform(-16, -0.5) for _ in range(count // 2)]
    return flat + border + small + tiny + near_one + [1e-30, 1e-300]


def quarter_period(mc: float) -> mpf:
    return mpmath.pi / 2 / mpmath.agm(1, mpmath.sqrt(mpf(mc)))


def jacobi_points() -> list[list[float]]:
    points = [
        [u, mc] for mc in (0.0, 1.0) for u in (0.0, 1e-300, 0.3, -0.5, 1.0, 3.0, -20.0, 300.0)
    ]
    for mc in complements(50):
        k = quarter_period(mc)
        turns = RNG.randrange(-5, 6)
        places = [
            RNG.uniform(-1, 1),
            RNG.uniform(-8, 8),
            RNG.choice([-1, 1]) * 10 ** RNG.uniform(0, 6),
            turns,  # as close to a zero of sn or cn as a double comes
            turns + RNG.choice([-1, 1]) * 10 ** RNG.uniform(-15, -1),
            turns + 0.5,  # on the border between two quarter periods
        ]
        points += [[float(k * mpf(place)), mc] for place in RNG.sample(places, 4)]
        points.append([10.0 ** RNG.uniform(-300, 0), mc])
    return [p for i, p in enumerate(points) if p not in points[:i]]


def jacobi(u: mpf, mc: mpf) -> tuple[mpf, mpf, mpf]:
    if mc == 0:
        return mpmath.tanh(u), mpmath.sech(u), mpmath.sech(u)
    # Less than a turn is left for mpmath, so that its series need no more digits than the values.
    k = quarter_period(mc)
    u -= 4 * k * mpmath.nint(u / (4 * k))
    sn, cn, dn = (mpmath.ellipfun(name, u, m=1 - mc) for name in ("sn", "cn", "dn"))
    return sn, cn, dn


def rows(points: list[list[float]], function: Callable[..., object]) -> list[list[float]]:
    table = []
    for point in points:
        value = function(*(mpf(x) for x in point))
        values = value if isinstance(value, tuple) else (value,)
        table.append([*point, *(y for v in values for y in pair(v))])
    return table


def main() -> None:
    tables = {
        "rf": rows(rf_points(), mpmath.elliprf),
        "rc": rows(rc_points(), mpmath.elliprc),
        "rd": rows(rd_points(), mpmath.elliprd),
        "rj": rows(rj_points(), mpmath.elliprj),
        "agm": rows(agm_points(), mpmath.agm),
        "jacobi": rows(jacobi_points(), jacobi),
        "complete_k": rows(
            [*([mc] for mc in complements(60)), *WORST["complete_k"]], quarter_period
        ),
    }
    for name, table in tables.items():
        print(name, len(table))
    body = ",\n".join(
        f' "{name}": [\n' + ",\n".join("  " + json.dumps(row) for row in table) + "\n ]"
        for name, table in tables.items()
    )
    Path(__file__).with_name("elliptic.json").write_text("{\n" + body + "\n}\n")


if __name__ == "__main__":
    main()
