"""Random free bodies and Lagrange tops, solved by their closed forms in 400 to 560 bits.

    python make_closed_forms.py          (needs gmpy2 and numpy; ten minutes)

Checks itself against the trajectories of the Taylor method beside it, then writes closed_forms.npz.
The forms are the textbook ones (Whittaker, *Analytical Dynamics*, §69-72; Landau & Lifshitz,
*Mechanics*, §37; Goldstein, *Classical Mechanics*, §5.7), with one fixed choice of axes: what
they lose near a separatrix, a pole or a symmetric body is paid for in digits. README.md says what
is stored.
"""

import json
import math
import random
import sys
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import gmpy2
import numpy as np
from gmpy2 import mpfr

FREE_BITS, TOP_BITS, CHECK_BITS = 400, 560, 900
RNG = random.Random(20261121)
HERE = Path(__file__).parent

Vector = list[Any]  # of mpfr, which has no type that a checker knows


class Input(NamedTuple):
    """A start in the conventions of the library: quaternion scalar first, not normalised."""

    family: str
    moments: tuple[float, ...]
    axis: int  # of the centre of mass, with its sign; 0 for a free body
    mgl: float
    omega: tuple[float, ...]
    attitude: tuple[float, ...]
    t: float


class State(NamedTuple):
    omega: Vector
    attitude: Vector
    fastest: Any  # the largest |omega| of the whole motion


# Elliptic functions --------------------------------------------------------------------------


def negligible() -> Any:
    """What vanishes beside one in the precision of the moment."""
    return mpfr(2) ** -gmpy2.get_context().precision


def carlson_rf(x: Any, y: Any, z: Any) -> Any:
    """R_F by duplication with a series of degree 7 (Carlson 1995; DLMF 19.36.1)."""
    close = gmpy2.root(negligible(), 8)
    while True:
        mean = (x + y + z) / 3
        if max(abs(mean - x), abs(mean - y), abs(mean - z)) < close * mean:
            break
        rx, ry, rz = gmpy2.sqrt(x), gmpy2.sqrt(y), gmpy2.sqrt(z)
        shift = rx * ry + ry * rz + rz * rx
        x, y, z = (x + shift) / 4, (y + shift) / 4, (z + shift) / 4
    a, b = 1 - x / mean, 1 - y / mean
    c = -a - b
    e2, e3 = a * b - c * c, a * b * c
    series = 1 - e2 / 10 + e3 / 14 + e2 * e2 / 24 - 3 * e2 * e3 / 44
    series += -5 * e2**3 / 208 + 3 * e3 * e3 / 104 + e2 * e2 * e3 / 16
    return series / gmpy2.sqrt(mean)


def _rc_one(e: Any) -> Any:
    """R_C(1, 1 + e)."""
    if abs(e) < mpfr(2) ** -12:
        term, total, k = mpfr(1), mpfr(0), 1
        while abs(term) > negligible():
            total += term / k
            term, k = -term * e, k + 2
        return total
    root = gmpy2.sqrt(abs(e))
    return gmpy2.atan(root) / root if e > 0 else gmpy2.atanh(root) / root


def carlson_rj(x: Any, y: Any, z: Any, p: Any) -> Any:
    """R_J for p > 0 by duplication with a series of degree 5 (Carlson 1995; DLMF 19.36.2)."""
    close = gmpy2.root(negligible(), 6)
    total, share = mpfr(0), mpfr(1)
    while True:
        mean = (x + y + z + 2 * p) / 5
        if max(abs(mean - x), abs(mean - y), abs(mean - z), abs(mean - p)) < close * mean:
            break
        rx, ry, rz, rp = gmpy2.sqrt(x), gmpy2.sqrt(y), gmpy2.sqrt(z), gmpy2.sqrt(p)
        shift = rx * ry + ry * rz + rz * rx
        d = (rp + rx) * (rp + ry) * (rp + rz)
        e = (rp - rx) * (rp - ry) * (rp - rz) / d
        total += 6 * share / d * _rc_one(e)
        share /= 4
        x, y, z, p = (x + shift) / 4, (y + shift) / 4, (z + shift) / 4, (p + shift) / 4
    a, b, c = 1 - x / mean, 1 - y / mean, 1 - z / mean
    q = -(a + b + c) / 2
    e2 = a * b + a * c + b * c - 3 * q * q
    e3 = a * b * c + 2 * e2 * q + 4 * q**3
    e4 = (2 * a * b * c + e2 * q + 3 * q**3) * q
    e5 = a * b * c * q * q
    series = 1 - 3 * e2 / 14 + e3 / 6 + 9 * e2 * e2 / 88 - 3 * e4 / 22 - 9 * e2 * e3 / 52
    return total + share * (series + 3 * e5 / 26) / (mean * gmpy2.sqrt(mean))


class Phase:
    """sn, cn, dn of ``u``, and Pi(n; u) in the sign of Abramowitz & Stegun; mc = 1 - m."""

    def __init__(self, u: Any, mc: Any) -> None:
        self.u, self.mc, self.quarter, self.half_turns = u, mc, None, 0
        if mc == 0:
            self.s, self.c = gmpy2.tanh(u), 1 / gmpy2.cosh(u)
            self.d, self.v, self.sn, self.cn = self.c, u, self.s, self.c
            return
        a, b, ladder = mpfr(1), gmpy2.sqrt(mc), []
        c = gmpy2.sqrt(max(mpfr(0), 1 - mc))
        while c > negligible() * a:
            a, b, c = (a + b) / 2, gmpy2.sqrt(a * b), (a - b) / 2
            ladder.append(c / a)
        self.quarter = gmpy2.const_pi() / (2 * a)
        self.half_turns = int(gmpy2.rint(u / (2 * self.quarter)))
        self.v = u - 2 * self.half_turns * self.quarter
        # Abramowitz & Stegun 16.4.
        angle = 2 ** len(ladder) * a * self.v
        for ratio in reversed(ladder):
            angle = (angle + gmpy2.asin(ratio * gmpy2.sin(angle))) / 2
        self.s, self.c = gmpy2.sin_cos(angle)
        self.d = gmpy2.sqrt(mc + (1 - mc) * self.c**2)
        sign = -1 if self.half_turns % 2 else 1
        self.sn, self.cn = sign * self.s, sign * self.c

    def third_kind(self, n: Any) -> Any:
        """Pi(n; u) for n <= 1."""
        if self.mc == 0:  # n < 0: tops and bodies leave the separatrix no other
            root = gmpy2.sqrt(-n)
            return (self.u + root * gmpy2.atan(root * self.s)) / (1 - n)
        s2 = self.s**2
        p = 1 - n * s2
        total = self.u + n / 3 * self.s * s2 * carlson_rj(self.c**2, self.d**2, mpfr(1), p)
        if self.half_turns:
            complete = n / 3 * carlson_rj(mpfr(0), self.mc, mpfr(1), 1 - n)
            total += 2 * self.half_turns * complete
        return total


def first_kind(s: Any, c: Any, d: Any) -> Any:
    """u with sn u = s and cn u = c >= 0."""
    return s * carlson_rf(c * c, d * d, mpfr(1))


# Vectors, quaternions (scalar first) and matrices -------------------------------------------------


def dot(a: Vector, b: Vector) -> Any:
    return sum((x * y for x, y in zip(a, b, strict=True)), mpfr(0))


def length(a: Vector) -> Any:
    return gmpy2.sqrt(dot(a, a))


def unit(a: Vector) -> Vector:
    size = length(a)
    return [x / size for x in a]


def times(p: Vector, q: Vector) -> Vector:
    a, b, c, d = p
    w, x, y, z = q
    return [
        a * w - b * x - c * y - d * z,
        a * x + b * w + c * z - d * y,
        a * y + c * w + d * x - b * z,
        a * z + d * w + b * y - c * x,
    ]


def turning(rate: Vector, t: Any) -> Vector:
    """Quaternion of exp(t [rate])."""
    size = length(rate)
    if size == 0:
        return [mpfr(1), mpfr(0), mpfr(0), mpfr(0)]
    s, c = gmpy2.sin_cos(size * t / 2)
    return [c, *(s / size * x for x in rate)]


def matrix(q: Vector) -> list[Vector]:
    w, x, y, z = q
    return [
        [w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z],
    ]


def quaternion(r: list[Vector]) -> Vector:
    """The inverse of ``matrix``, from the row of 4 q q^T whose diagonal element is largest."""
    a, b, c = r[2][1] - r[1][2], r[0][2] - r[2][0], r[1][0] - r[0][1]
    f, g, h = r[0][1] + r[1][0], r[0][2] + r[2][0], r[1][2] + r[2][1]
    x, y, z = r[0][0], r[1][1], r[2][2]
    rows = [
        [1 + x + y + z, a, b, c],
        [a, 1 + x - y - z, f, g],
        [b, f, 1 - x + y - z, h],
        [c, g, h, 1 - x - y + z],
    ]
    return unit(rows[max(range(4), key=lambda k: rows[k][k])])


def product(a: list[Vector], b: list[Vector]) -> list[Vector]:
    return [[dot(row, list(column)) for column in zip(*b, strict=True)] for row in a]


def transposed(a: list[Vector]) -> list[Vector]:
    return [list(row) for row in zip(*a, strict=True)]


# The motions ----------------------------------------------------------------------------------


def symmetric(moments: Vector, axis: int, omega: Vector, attitude: Vector, t: Any) -> State:
    """Free, with equal moments about the two other axes: two turns at constant rates."""
    across, along = moments[(axis + 1) % 3], moments[axis]
    spin = [mpfr(0)] * 3
    spin[axis] = (1 - along / across) * omega[axis]
    nutation = turning(spin, t)
    momentum = [i * w / across for i, w in zip(moments, omega, strict=True)]
    q = times(times(attitude, turning(momentum, t)), nutation)
    inverse = [nutation[0], *(-x for x in nutation[1:])]
    rates = times(times(inverse, [mpfr(0), *omega]), nutation)[1:]
    return State(rates, q, length(omega))


def free(moments: Vector, omega: Vector, attitude: Vector, t: Any) -> State:
    """A free body: Whittaker §69, the angle about the angular momentum as Landau & Lifshitz §37."""
    for axis in range(3):
        if moments[(axis + 1) % 3] == moments[(axis + 2) % 3]:
            return symmetric(moments, axis, omega, attitude, t)
    if sum(w != 0 for w in omega) <= 1:
        return State(omega, times(attitude, turning(omega, t)), length(omega))

    roles = sorted(range(3), key=lambda k: moments[k])
    i1, i2, i3 = (moments[k] for k in roles)
    w1, _, w3 = (omega[k] for k in roles)
    above, below = i3 * (i3 - i2) * w3 * w3, i1 * (i2 - i1) * w1 * w1
    separatrix = abs(above - below) <= (above + below) * gmpy2.sqrt(negligible())
    if above < below:
        roles.reverse()
    # Rows of a rotation from the body to axes in the order of their roles.
    sign = 1 if (roles[1] - roles[0]) % 3 == 1 else -1
    roled = [[mpfr(int(k == axis)) for k in range(3)] for axis in roles]
    roled[1] = [sign * x for x in roled[1]]
    i1, i2, i3 = (moments[k] for k in roles)
    w1, w2, w3 = (dot(row, omega) for row in roled)

    rho, rest = (i3 - i2) / (i3 - i1), (i2 - i1) / (i3 - i1)
    momentum = length([i1 * w1, i2 * w2, i3 * w3])
    u1, u2, u3 = i1 * w1 / momentum, i2 * w2 / momentum, i3 * w3 / momentum
    tilt, level = i1 * w1**2 + i2 * w2**2 * rho, i2 * w2**2 * rest + i3 * w3**2
    a1, b1, a2 = i1 * tilt / momentum**2, i3 * level / momentum**2, i2 * tilt / rho / momentum**2
    surplus = i3 * w3**2 * rho - i1 * w1**2 * rest
    mc = mpfr(0) if separatrix else surplus / (rho * level)
    rate = gmpy2.sqrt((i3 - i2) * (i3 - i1) * level / (i1 * i2 * i3))
    s1, s3 = (-1 if u1 < 0 else 1), (-1 if u3 < 0 else 1)
    s2 = s1 * s3 * (1 if i3 > i1 else -1)
    start = first_kind(s2 * u2 / gmpy2.sqrt(a2), abs(u1) / gmpy2.sqrt(a1), abs(u3) / gmpy2.sqrt(b1))
    begin, end = Phase(start, mc), Phase(start + rate * t, mc)

    after = [
        s1 * gmpy2.sqrt(a1) * end.cn,
        s2 * gmpy2.sqrt(a2) * end.sn,
        s3 * gmpy2.sqrt(b1) * end.d,
    ]
    n = -(i3 * rest) / (i1 * rho)
    turned = (end.third_kind(n) - begin.third_kind(n)) / rate
    angle = momentum * (t / i3 + (1 / i1 - 1 / i3) * turned)

    def frame(u: Vector) -> list[Vector]:
        """The node, momentum × node and the momentum, seen from the body."""
        x, y, z = u
        s = gmpy2.sqrt(x * x + y * y)
        return [[y / s, -x / s, mpfr(0)], [z * x / s, z * y / s, -s], u]

    s, c = gmpy2.sin_cos(angle)
    about = [[c, -s, mpfr(0)], [s, c, mpfr(0)], [mpfr(0), mpfr(0), mpfr(1)]]
    turn = product(product(transposed(frame([u1, u2, u3])), about), frame(after))
    turn = product(product(transposed(roled), turn), roled)
    rates = [momentum * u / i for u, i in zip(after, (i1, i2, i3), strict=True)]
    # |omega|^2 is linear in sn^2.
    ends = (
        [a1 / i1**2, b1 / i3**2],
        [a2 / i2**2, b1 * mc / i3**2],
    )
    fastest = momentum * gmpy2.sqrt(max(sum(pair) for pair in ends))
    omega = [dot(column, rates) for column in transposed(roled)]
    return State(omega, times(attitude, quaternion(turn)), fastest)


def roots(c2: Any, c1: Any, c0: Any) -> Vector:
    """The three real roots of -w^3 + c2 w^2 + c1 w + c0, ascending.

    The most solitary root by Viète's cosine and Newton's method, the others by division; a close
    pair keeps half the digits.
    """
    centre = c2 / 3
    p, q = c1 + c2 * c2 / 3, c0 + c1 * centre + 2 * centre**3
    radius = 2 * gmpy2.sqrt(p / 3)
    cosine = max(mpfr(-1), min(mpfr(1), 4 * q / radius**3))
    third = gmpy2.acos(cosine) / 3
    turn = 2 * gmpy2.const_pi() / 3
    low, middle, high = sorted(centre + radius * gmpy2.cos(third + k * turn) for k in range(3))
    w = high if high - middle > middle - low else low
    for _ in range(3):
        w += (((c2 - w) * w + c1) * w + c0) / ((3 * w - 2 * c2) * w - c1)
    if abs(w) <= gmpy2.sqrt(negligible()) * radius:
        w = mpfr(0)
    half, rest = (c2 - w) / 2, c0 / w if w else -c1
    root = gmpy2.sqrt(max(half * half - rest, mpfr(0)))
    large = half + root if half > 0 else half - root
    small = rest / large if large else mpfr(0)
    return sorted([w, large, small])


def upright(i1: Any, i3: Any, mgl: Any, omega: Vector, attitude: Vector, t: Any) -> State:
    """A Lagrange top with its centre of mass on +axis 3: Whittaker §71, Goldstein §5.7.

    w = 1 - cos(tilt); alpha = q0 + i q3 and beta = q1 + i q2 have half the sum and half the
    difference of precession and spin as arguments.
    """
    size2 = dot(attitude, attitude)
    q0, q1, q2, q3 = unit(attitude)
    w1, w2, w3 = omega
    alpha0, beta0 = gmpy2.mpc(q0, q3), gmpy2.mpc(q1, q2)
    across = gmpy2.mpc(w1, w2)
    if across == 0 and (alpha0 == 0 or beta0 == 0):
        return State(omega, times(unit(attitude), turning(omega, t)), abs(w3))
    w = 2 * (attitude[1] ** 2 + attitude[2] ** 2) / size2
    lower = 2 * (attitude[0] ** 2 + attitude[3] ** 2) / size2
    g1, g2 = 2 * (q1 * q3 - q0 * q2), 2 * (q2 * q3 + q0 * q1)
    h, a = w1 * g1 + w2 * g2, i3 * w3
    slope = g2 * w1 - g1 * w2
    b = i1 * h - a * w
    b2 = i1 * h + a * lower
    e = i1 * (w1 * w1 + w2 * w2) / 2 - mgl * w
    tiny = gmpy2.sqrt(negligible())
    across_most = i1 * abs(across) * gmpy2.sqrt(w * lower)
    if abs(b) <= tiny * (across_most + abs(a * w)):
        b = mpfr(0)
    if abs(b2) <= tiny * (across_most + abs(a * lower)):
        b2 = mpfr(0)
    homoclinic = b == 0 and abs(e) <= tiny * mgl * w
    k = 2 * i1 * mgl
    linear, square = (4 * i1 * e - 2 * a * b) / k, (2 * i1 * (2 * mgl - e) - a * a) / k
    low, wa, wb = roots(square, linear, -b * b / k)
    low, wa, wb = min(low, mpfr(0)), max(wa, mpfr(0)), min(wb, mpfr(2))
    if homoclinic:
        low = wa = mpfr(0)
    if b2 == 0:
        wb = mpfr(2)
    through_top, through_bottom = b == 0 and wa == 0, b2 == 0

    rate = gmpy2.sqrt(mgl * (wb - low) / (2 * i1))
    mc = (wa - low) / (wb - low)

    def share(x: Any) -> Any:
        return gmpy2.sqrt(max(mpfr(0), min(mpfr(1), x)))

    sn, cn = (share((wb - w) / (wb - wa)), share((w - wa) / (wb - wa))) if wb > wa else (0, 1)
    start = first_kind(mpfr(sn), mpfr(cn), share((w - low) / (wb - low)))
    if slope > 0:
        start = -start
    begin, end = Phase(start, mc), Phase(start + rate * t, mc)

    total = (w3 - a / i1) * t
    difference = -total
    if not through_bottom:
        n = -(wb - wa) / (2 - wb)
        total += b2 / i1 * (end.third_kind(n) - begin.third_kind(n)) / ((2 - wb) * rate)
    if b != 0:
        n = (wb - wa) / wb
        difference += b / i1 * (end.third_kind(n) - begin.third_kind(n)) / (wb * rate)
    after = wa * end.sn**2 + wb * end.cn**2
    lower = (2 - wa) * end.sn**2 + (2 - wb) * end.cn**2

    # At a pole the modulus passes through zero and changes sign, so that the phase need not jump.
    if through_bottom:
        modulus = gmpy2.sqrt((2 - wa) / 2)
        if alpha0 != 0:
            phase = alpha0 / (modulus * begin.sn)
        else:
            phase = -beta0 * across.conjugate() / (2 * modulus * rate * begin.cn * begin.d)
        alpha = phase * modulus * end.sn
    else:
        alpha = alpha0 / abs(alpha0) * gmpy2.sqrt(lower / 2)
    if through_top:
        modulus = gmpy2.sqrt(wb / 2)
        if beta0 != 0:
            phase = beta0 / (modulus * begin.cn)
        else:
            phase = -alpha0 * across / (2 * modulus * rate * begin.sn * begin.d)
        beta = phase * modulus * end.cn
    else:
        beta = beta0 / abs(beta0) * gmpy2.sqrt(after / 2)
    alpha *= gmpy2.mpc(gmpy2.cos(total / 2), gmpy2.sin(total / 2))
    beta *= gmpy2.mpc(gmpy2.cos(difference / 2), gmpy2.sin(difference / 2))
    speed = -2 * (wb - wa) * rate * end.sn * end.cn * end.d
    across = alpha.conjugate() * beta * gmpy2.mpc(speed, (b + a * after) / i1) * 2 / (after * lower)
    # |omega|^2 is linear in w.
    fastest = gmpy2.sqrt(w3 * w3 + max(mpfr(0), 2 * (e + mgl * wb) / i1))
    q = [alpha.real, beta.real, beta.imag, alpha.imag]
    return State([across.real, across.imag, w3], unit(q), fastest)


#: Quaternions, not normalised, that turn body axis k into +axis 3; -k into -axis 3.
TO_THIRD = {3: (1, 0, 0, 0), -3: (0, 1, 0, 0), 1: (1, 0, -1, 0), -1: (1, 0, 1, 0)}
TO_THIRD |= {2: (1, 1, 0, 0), -2: (1, -1, 0, 0)}


def turned_body(axis: int) -> tuple[Vector, list[Vector]]:
    """The quaternion of TO_THIRD and the matrix of the same turn."""
    p = [mpfr(x) for x in TO_THIRD[axis]]
    return p, [[x / dot(p, p) for x in row] for row in matrix(p)]


def state(start: Input) -> State:
    """The state at start.t, in the precision of the moment."""
    parts = start.moments, start.omega, start.attitude
    moments, omega, attitude = ([mpfr(x) for x in part] for part in parts)
    return solved(moments, start.axis, mpfr(start.mgl), omega, attitude, mpfr(start.t))


def solved(moments: Vector, axis: int, mgl: Any, omega: Vector, attitude: Vector, t: Any) -> State:
    if mgl == 0:
        return free(moments, omega, unit(attitude), t)
    p, r = turned_body(axis)
    inverse = [p[0], *(-x for x in p[1:])]
    i3, i1, i2 = (moments[(abs(axis) + k) % 3] for k in (-1, 0, 1))
    if i1 != i2:  # a plane swing about the axis of the only rate: no other moment matters
        (i1,) = [i for i, rate in zip(moments, omega, strict=True) if rate]
    rates = [dot(row, omega) for row in r]
    found = upright(i1, i3, mgl, rates, times(attitude, inverse), t)
    rates = [dot(row, found.omega) for row in transposed(r)]
    return State(rates, unit(times(found.attitude, p)), found.fastest)


# Condition numbers ----------------------------------------------------------------------------


def turn_between(p: Vector, q: Vector) -> Any:
    """Angle (rad) between two attitudes that are close or opposite."""
    inverse = [p[0], *(-x for x in p[1:])]
    turn = times(inverse, q)
    return 2 * length(turn[1:])


def condition(start: Input, found: State) -> tuple[float, float]:
    """Change of the attitude (rad) and of the rates (relative to the fastest) per relative change.

    Root sum of squares over the inputs, by a change of each by 2^-53, which is what rounding does:
    where the motion is not smooth in an input (a separatrix) that is the number that matters.
    Moments equal to the bit are changed together.
    """
    change = mpfr(2) ** -53
    flat = [*start.moments, start.mgl, *start.omega, *start.attitude, start.t]
    groups = [[k] for k in range(3, 12) if flat[k] != 0]
    for moment in dict.fromkeys(start.moments):
        groups.append([k for k in range(3) if start.moments[k] == moment])
    if start.mgl == 0:
        # Turning space turns everything after: no need to solve again.
        groups = [group for group in groups if group[0] not in range(7, 11)]
    turned = moved = mpfr(0)
    for group in groups:
        other = [mpfr(x) * (1 + change) if k in group else mpfr(x) for k, x in enumerate(flat)]
        near = solved(other[:3], start.axis, other[3], other[4:7], other[7:11], other[11])
        turned += (turn_between(found.attitude, near.attitude) / change) ** 2
        off = length([x - y for x, y in zip(found.omega, near.omega, strict=True)])
        moved += (off / change / found.fastest) ** 2 if found.fastest else 0
    if start.mgl == 0:
        q = unit([mpfr(x) for x in start.attitude])
        turned += sum(4 * x * x * (1 - x * x) for x in q)
    return float(gmpy2.sqrt(turned)), float(gmpy2.sqrt(moved))


# Scenes -----------------------------------------------------------------------------------------


def decades(low: float, high: float) -> float:
    """Log-uniform between 10^low and 10^high."""
    return 10.0 ** RNG.uniform(low, high)


def sign() -> float:
    return RNG.choice((-1.0, 1.0))


def normal(n: int = 3) -> tuple[float, ...]:
    return tuple(RNG.gauss(0, 1) for _ in range(n))


def duration(rate: float) -> float:
    """1e-3 to 1e3 turns, a few times 1e5, either way."""
    turns = 1e5 if RNG.random() < 0.03 else decades(-3, 3)
    return sign() * turns * 2 * math.pi / rate


def is_body(moments: Sequence[float]) -> bool:
    """Moments that no rounding puts beyond the triangle inequality."""
    a, b, c = sorted(moments)
    return a > 0 and a + b >= c


def generic_moments() -> tuple[float, ...]:
    """Any body: sorted moments whose smallest is anything down to a millionth of the largest."""
    small = decades(-6, -0.01)
    return small, RNG.uniform(max(small, 1 - small), 1), 1.0


def needle() -> tuple[float, ...]:
    small = decades(-6, -1)
    return small, 1 - small * decades(-3, 0), 1.0


def lamina() -> tuple[float, ...]:
    """Flat, or nearly."""
    small, middle = decades(-6, 0), RNG.uniform(0.5, 1)
    flat = small + middle
    return small, middle, RNG.choice((flat, flat * (1 - small * decades(-15, -1))))


def nearly_symmetric() -> tuple[float, ...]:
    pair = 1 + decades(-15.6, -1)
    return 1.0, pair, min(2.0, decades(-6, 0.3)) if RNG.random() < 0.7 else RNG.uniform(0.3, 2)


def nearly_spherical() -> tuple[float, ...]:
    apart = decades(-15, -1)
    return 1.0, 1 + apart * RNG.random(), 1 + apart


def equal_pair() -> tuple[float, ...]:
    return 1.0, 1.0, min(2.0, decades(-6, 0.31))


def sphere() -> tuple[float, ...]:
    return (RNG.uniform(0.5, 2),) * 3


BODIES = (generic_moments, needle, lamina, nearly_symmetric, nearly_spherical)


def sorted_body(make: Callable[[], tuple[float, ...]]) -> tuple[float, ...]:
    """Three different moments, ascending."""
    while True:
        moments = tuple(sorted(make()))
        if len(set(moments)) == 3 and is_body(moments):
            return moments


def about(axis: int, *, off: Sequence[float]) -> tuple[float, ...]:
    """A turn about an axis at about one, disturbed by ``off`` on the other two."""
    rates = [0.0, 0.0, 0.0]
    rates[axis] = sign() * RNG.uniform(0.5, 2)
    rates[(axis + 1) % 3], rates[(axis + 2) % 3] = off
    return tuple(rates)


def near_separatrix(moments: tuple[float, ...]) -> tuple[float, ...]:
    """About the middle axis with little on one other or on both, or nearly none in S on both."""
    little, kind = decades(-14, -1), RNG.randrange(4)
    i1, i2, i3 = moments
    level = math.sqrt(i1 * (i2 - i1) / (i3 * (i3 - i2)))
    offs = {
        0: (0.0, sign() * little),
        1: (sign() * little, 0.0),
        2: (sign() * little, sign() * little * decades(-2, 2)),
        3: (sign() * little * level * (1 + sign() * decades(-15, -1)), sign() * little),
    }
    large = sign() * decades(-3, 0)  # on the separatrix, but far from the middle axis
    if RNG.random() < 0.2:
        return about(1, off=(large * level * (1 + sign() * decades(-15, -1)), large))
    return about(1, off=offs[kind])  # axis 3, then axis 1


def on_separatrix() -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Whole numbers with I3 (I3 - I2) w3^2 = I1 (I2 - I1) w1^2."""
    while True:
        i1, i2, i3 = sorted(RNG.sample(range(2, 80), 3))
        p, q = i3 * (i3 - i2), i1 * (i2 - i1)
        common = math.gcd(p, q)
        x, y = math.isqrt(p // common), math.isqrt(q // common)
        if i1 + i2 >= i3 and x * x * common == p and y * y * common == q:
            scale = sign() * 2.0 ** RNG.randrange(-20, 1)
            middle = RNG.choice((0.0, sign() * RNG.uniform(0.1, 40)))
            return (float(i1), float(i2), float(i3)), (scale * x, middle, sign() * scale * y)


def permuted(moments: Sequence[float], omega: Sequence[float]) -> tuple[Any, Any]:
    order = RNG.sample(range(3), 3)
    return tuple(moments[k] for k in order), tuple(omega[k] for k in order)


def free_start(family: str) -> tuple[Sequence[float], Sequence[float]]:
    """Moments and rates, axes sorted."""
    by_body = {
        "needle": needle,
        "lamina": lamina,
        "nearly symmetric": nearly_symmetric,
        "nearly spherical": nearly_spherical,
    }
    if family in ("symmetric", "spherical"):
        return {"symmetric": equal_pair, "spherical": sphere}[family](), normal()
    if family == "on the separatrix":
        return on_separatrix()
    if family in by_body:
        moments = sorted_body(by_body[family])
        return moments, RNG.choice((normal(), [sign() * decades(-8, 0) for _ in range(3)]))
    moments = sorted_body(RNG.choice(BODIES))
    if family == "near the separatrix":
        return moments, near_separatrix(moments)
    if family == "near a principal axis":
        off = sign() * decades(-14, -1), sign() * decades(-14, -1)
        return moments, about(RNG.choice((0, 2)), off=off)
    if family == "about a principal axis":
        return moments, about(RNG.randrange(3), off=(0.0, 0.0))
    if family == "any rates":
        return moments, [sign() * decades(-8, 0) for _ in range(3)]
    return sorted_body(generic_moments), normal()


def free_scene(family: str) -> Input:
    moments, omega = permuted(*free_start(family))
    moments = [math.ldexp(x, k) for k in [RNG.randrange(-40, 41)] for x in moments]
    omega = [math.ldexp(x, k) for k in [RNG.randrange(-40, 41)] for x in omega]
    t = duration(math.hypot(*omega))
    return Input("free, " + family, tuple(moments), 0, 0.0, tuple(omega), normal(4), t)


def tilted(tilt: float, *, yaw: float = 0.0) -> tuple[float, ...]:
    """An attitude with that tilt; small components stay small."""
    direction = RNG.uniform(-math.pi, math.pi)
    s, c = math.sin(tilt / 2), math.cos(tilt / 2)
    x, y = s * math.cos(direction + yaw), s * math.sin(direction + yaw)
    return c * math.cos(yaw), x, y, c * math.sin(yaw)


def gamma_of(q: Sequence[float]) -> tuple[float, ...]:
    w, x, y, z = q
    size = sum(v * v for v in q)
    return 2 * (x * z - w * y) / size, 2 * (y * z + w * x) / size, 1 - 2 * (x * x + y * y) / size


def precessing(q: Sequence[float], rate: float, spin: float) -> tuple[float, ...]:
    """Body rates of a precession about the vertical with that third rate."""
    g1, g2, _ = gamma_of(q)
    return rate * g1, rate * g2, spin


class Upright(NamedTuple):
    """A top with its centre of mass on +axis 3."""

    i1: float
    i3: float
    mgl: float
    omega: tuple[float, ...]
    attitude: tuple[float, ...]


def any_top() -> tuple[float, float, float]:
    i1 = RNG.uniform(0.5, 2)
    i3 = RNG.choice((i1, 2 * i1, *(min(2.0, decades(-6, 0.3)) * i1 for _ in range(8))))
    return i1, i3, RNG.choice((1.0, decades(-6, 6), RNG.uniform(0.2, 5)))


def homoclinic(off: float) -> Upright:
    """Energy and momentum of the upright top to the last digit, from a Pythagorean attitude."""
    c, s, n = RNG.choice(((3, 4, 5), (15, 8, 17), (63, 16, 65), (255, 32, 257)))
    i1, i3 = 2.0 ** RNG.randrange(-2, 3), 2.0 ** RNG.randrange(-4, 1)
    spin = RNG.choice((0, RNG.randrange(1, 9))) * c / 8 / i3
    across = RNG.randrange(1, 40) / 8, i3 * spin * s / (i1 * c)
    if i3 > 2 * i1:
        i3 = 2 * i1
        across = across[0], i3 * spin * s / (i1 * c)
    mgl = i1 * (across[0] ** 2 + across[1] ** 2) * n * n / (4 * s * s)
    attitude = (float(c), float(s), 0.0, 0.0)
    return Upright(i1, i3, mgl, (across[0] * (1 + off), across[1], spin), attitude)


def top_start(family: str) -> Upright:
    i1, i3, mgl = any_top()
    swing = math.sqrt(mgl / i1)
    yaw = RNG.choice((0.0, RNG.uniform(-math.pi, math.pi)))
    threshold = 2 * math.sqrt(mgl * i1) / i3
    any_tilt = tilted(RNG.uniform(0, math.pi), yaw=yaw)
    spin = sign() * swing * decades(-3, 3)
    near = decades(-14, -1)
    nudge = tuple(RNG.choice((0.0, 1.0, decades(-2, 2))) * near * swing * x for x in normal(2))
    if family == "any":
        omega = tuple(x * swing * decades(-3, 3) for x in normal())
        attitude = RNG.choice((normal(4), any_tilt))
    elif family in ("near upright", "near hanging"):
        attitude = tilted(near, yaw=yaw)
        if family == "near hanging":
            w, x, y, z = attitude
            attitude = (x, w, z, y)
        omega = (*nudge, RNG.choice((spin, sign() * threshold * decades(-1, 1))))
    elif family == "at the threshold":
        attitude = tilted(RNG.choice((near, 0.0)), yaw=yaw)
        if attitude[1] == 0 == nudge[0]:
            nudge = (near * swing, 0.0)
        factor = RNG.choice((1.0, 1 + sign() * decades(-12, -1)))
        omega = (*nudge, sign() * factor * threshold)
    elif family in ("from upright", "from hanging"):
        attitude = (math.cos(yaw), 0.0, 0.0, math.sin(yaw))
        if family == "from hanging":
            attitude = (0.0, attitude[0], attitude[3], 0.0)
        size = swing * decades(-12, 1)
        omega = (size * RNG.gauss(0, 1), size, RNG.choice((spin, 0.0)))
    elif family == "past a pole":
        # b = 0 (through the top) or b2 = 0 (the bottom), to rounding or a little more.
        attitude, off = any_tilt, RNG.choice((0.0, sign() * near))
        g1, g2, g3 = gamma_of(attitude)
        s2 = g1 * g1 + g2 * g2
        rate = i3 * spin * RNG.choice((1 - g3, -1 - g3)) / (i1 * s2) * (1 + off)
        sway = swing * decades(-3, 1) * RNG.gauss(0, 1)
        omega = (rate * g1 + sway * g2, rate * g2 - sway * g1, spin)
    elif family == "sleeping or hanging":
        attitude = (math.cos(yaw), 0.0, 0.0, math.sin(yaw))
        if RNG.random() < 0.5:
            attitude = (0.0, attitude[0], attitude[3], 0.0)
        omega = (0.0, 0.0, RNG.choice((spin, sign() * threshold, sign() * threshold * 0.5, 0.0)))
    elif family == "steady":
        while True:
            attitude = tilted(RNG.uniform(0.01, 3.1), yaw=yaw)
            spin = sign() * swing * decades(-3, 3)
            g3, a = gamma_of(attitude)[2], i3 * spin
            root = a * a - 4 * i1 * mgl * g3
            if root >= 0:
                break
        large = a + math.copysign(math.sqrt(root), a)
        omega = precessing(attitude, RNG.choice((2 * mgl / large, large / (2 * i1 * g3))), spin)
    elif family == "released at rest":
        attitude, omega = any_tilt, (0.0, 0.0, RNG.choice((spin, 0.0)))
    elif family == "fast":
        attitude = any_tilt
        omega = (*(swing * x for x in normal(2)), sign() * swing * decades(2, 3.5))
    elif family == "spherical pendulum":
        attitude = RNG.choice((normal(4), any_tilt))
        omega = (*(swing * x * decades(-3, 1) for x in normal(2)), 0.0)
    elif family == "planar pendulum":
        half = RNG.uniform(-math.pi, math.pi)
        attitude = (math.cos(half), math.sin(half), 0.0, 0.0)
        g3 = gamma_of(attitude)[2]
        edge = swing * math.sqrt(max(0.0, 2 * (1 - g3)))  # of turning over
        edge *= 1 + sign() * decades(-14, -1)
        omega = (RNG.choice((swing * decades(-3, 2), edge)), 0.0, 0.0)
    elif family == "to upright":
        return homoclinic(0.0)
    elif family == "nearly to upright":
        return homoclinic(sign() * near)
    else:  # weightless
        mgl, attitude, omega = 0.0, normal(4), normal()
    return Upright(i1, i3, mgl, omega, attitude)


def top_scene(family: str) -> Input:
    start = top_start(family)
    axis = RNG.choice((3, 3, 3, -3, -3, 1, -1, 2, -2))
    p, r = turned_body(axis)
    rates = [sum(float(r[k][j]) * start.omega[k] for k in range(3)) for j in range(3)]
    attitude = [float(x) for x in times(list(start.attitude), [float(x) for x in p])]
    moments = [start.i1] * 3
    moments[abs(axis) - 1] = start.i3
    size, pace = RNG.randrange(-40, 41), RNG.randrange(-20, 21)
    moments = [math.ldexp(x, size) for x in moments]
    rates = [math.ldexp(x, pace) for x in rates]
    mgl = math.ldexp(start.mgl, size + 2 * pace)
    swing = math.ldexp(math.sqrt(start.mgl / start.i1), pace)
    t = duration(max(math.hypot(*rates), swing))
    if family == "to upright":
        t = sign() * RNG.uniform(0, 8) / swing
    return Input("top, " + family, tuple(moments), axis, mgl, tuple(rates), tuple(attitude), t)


def swing_scene() -> Input:
    """A body without symmetry that swings about a horizontal principal axis."""
    moments = permuted(sorted_body(generic_moments), (0, 0, 0))[0]
    hinge = RNG.choice((0, 1))
    axis = RNG.choice([s * (k + 1) for k in range(3) for s in (1, -1) if k != hinge])
    mgl = decades(-3, 3)
    pace = math.sqrt(mgl / moments[hinge])
    omega, half = [0.0] * 3, RNG.uniform(-math.pi, math.pi)
    attitude = [math.cos(half), 0.0, 0.0, 0.0]
    omega[hinge], attitude[hinge + 1] = sign() * pace * decades(-3, 2), math.sin(half)
    t = duration(max(pace, abs(omega[hinge])))
    return Input("swing", moments, axis, mgl, tuple(omega), tuple(attitude), t)


FREE = {
    "any moments": 900,
    "any rates": 500,
    "needle": 400,
    "lamina": 400,
    "nearly symmetric": 500,
    "nearly spherical": 400,
    "symmetric": 300,
    "spherical": 100,
    "near the separatrix": 900,
    "on the separatrix": 100,
    "near a principal axis": 500,
    "about a principal axis": 100,
}
TOPS = {
    "any": 1100,
    "near upright": 500,
    "near hanging": 500,
    "at the threshold": 300,
    "from upright": 250,
    "from hanging": 250,
    "past a pole": 400,
    "sleeping or hanging": 150,
    "steady": 350,
    "released at rest": 300,
    "fast": 200,
    "spherical pendulum": 300,
    "planar pendulum": 200,
    "to upright": 100,
    "nearly to upright": 100,
    "weightless": 100,
}
SWINGS = 300


def scenes() -> Iterator[Input]:
    for family, count in FREE.items():
        yield from (free_scene(family) for _ in range(count))
    for family, count in TOPS.items():
        yield from (top_scene(family) for _ in range(count))
    yield from (swing_scene() for _ in range(SWINGS))


# Checks and the file ---------------------------------------------------------------------------


def check_carlson() -> None:
    """Values of Carlson (1995), printed to 14 digits."""
    gmpy2.get_context().precision = FREE_BITS
    for value, digits in (
        (carlson_rf(mpfr(1), mpfr(2), mpfr(0)), "1.3110287771461"),
        (carlson_rf(mpfr(2), mpfr(3), mpfr(4)), "0.58408284167715"),
        (carlson_rj(mpfr(0), mpfr(1), mpfr(2), mpfr(3)), "0.77688623778582"),
        (carlson_rj(mpfr(2), mpfr(3), mpfr(4), mpfr(5)), "0.14297579667157"),
    ):
        assert abs(value - mpfr(digits)) < 1e-13, digits


def check_taylor() -> None:
    """All trajectories of the Taylor method that have a closed form."""
    worst = mpfr(0)
    for family in ("free_asymmetric", "free_symmetric", "lab_box", "lagrange", "pendulum"):
        for scene in json.loads((HERE / f"{family}.json").read_text())["scenes"]:
            com = scene["com"]
            if isinstance(scene["inertia"][0], list):
                continue
            gmpy2.get_context().precision = TOP_BITS
            (axis,) = [k + 1 for k in range(3) if com[k]] or [0]
            mgl = mpfr(scene["mass"]) * mpfr(scene["gravity"]) * mpfr(com[axis - 1])
            axis = -axis if mgl < 0 else axis
            moments, rates = ([mpfr(x) for x in scene[key]] for key in ("inertia", "omega0"))
            x, y, z, w = (mpfr(v) for v in scene["q0"])
            for sample in scene["samples"]:
                found = solved(moments, axis, abs(mgl), rates, [w, x, y, z], mpfr(sample["t"]))
                x1, y1, z1, w1 = (mpfr(v) for v in sample["q"])
                off = [a - mpfr(b) for a, b in zip(found.omega, sample["omega"], strict=True)]
                turned = turn_between([w1, x1, y1, z1], found.attitude)
                error = max(turned, length(off) / (found.fastest or 1))
                assert error < 1e-22, (scene["id"], sample["t"], float(error))
                worst = max(worst, error)
    print(f"Taylor method: worst difference {float(worst):.1e}")


def bits(start: Input) -> int:
    return FREE_BITS if start.mgl == 0 else TOP_BITS


def split(numbers: Vector) -> tuple[list[float], list[float]]:
    """Doubles and what they miss."""
    high = [float(x) for x in numbers]
    return high, [float(x - mpfr(h)) for x, h in zip(numbers, high, strict=True)]


def main() -> None:
    check_carlson()
    check_taylor()
    names, columns = list[str](), dict[str, list[Any]]()

    def put(**values: Any) -> None:
        for key, value in values.items():
            columns.setdefault(key, []).append(value)

    for index, start in enumerate(scenes()):
        gmpy2.get_context().precision = bits(start)
        found = state(start)
        if index % 50 == 0:
            gmpy2.get_context().precision = CHECK_BITS
            again = state(start)
            assert turn_between(again.attitude, found.attitude) < 1e-28, start
            gmpy2.get_context().precision = bits(start)
        turned, moved = condition(start, found)
        omega, omega_low = split(found.omega)
        attitude, attitude_low = split(found.attitude)
        if start.family not in names:
            names.append(start.family)
        put(family=names.index(start.family), moments=start.moments, axis=start.axis, mgl=start.mgl)
        put(omega0=start.omega, attitude0=start.attitude, t=start.t)
        put(omega=omega, omega_low=omega_low, attitude=attitude, attitude_low=attitude_low)
        put(kappa_att=turned, kappa_omega=moved, angle=float(found.fastest * abs(mpfr(start.t))))
        if index % 500 == 0:
            print(index, start.family, file=sys.stderr, flush=True)
    small = ("omega_low", "attitude_low", "kappa_att", "kappa_omega", "angle")
    kinds: dict[str, Any] = {
        "family": np.uint8,
        "axis": np.int8,
        **dict.fromkeys(small, np.float32),
    }
    arrays = {key: np.array(value, kinds.get(key, np.float64)) for key, value in columns.items()}
    assert all(np.isfinite(array).all() for array in arrays.values())
    np.savez_compressed(HERE / "closed_forms.npz", families=np.array(names), **arrays)


if __name__ == "__main__":
    main()
