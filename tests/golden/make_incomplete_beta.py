"""Golden values of the inverse of the incomplete beta function: writes incomplete_beta.json here.

    python make_incomplete_beta.py          (needs mpmath)

A row is ``a, b, level, nearest, miss``: the x with I_x(a, b) = level, the level read as the exact
value of its double, as a pair of make_elementary.py. ``a - 1`` and ``b - 1`` count from 0.
"""

import json
import random
from pathlib import Path

import mpmath
from make_elementary import pair
from mpmath import mpf

mpmath.mp.prec = 300
RNG = random.Random(20261122)
LEVELS = (0.025, 0.0175, 1e-6, 0.5)


def tail(successes: int, trials: int, x: mpf) -> tuple[mpf, mpf]:
    """P(successes or more | x) and its derivative by x, by the sum of its terms."""
    y = 1 - x
    first = mpmath.binomial(trials, successes) * x**successes * y ** (trials - successes)
    total, term, k = mpf(0), first, successes
    while term > total * mpf(2) ** -200 and k <= trials:
        total += term
        term *= mpf(trials - k) / (k + 1) * x / y
        k += 1
    return total, successes * first / x


def inverse(successes: int, trials: int, level: float) -> mpf:
    """The x with P(successes or more | x) = level, by Newton's method in ln x."""
    x = mpf(successes) / (trials + 1)
    while True:
        value, density = tail(successes, trials, x)
        step = mpmath.log(mpf(level) / value) * value / (x * density)
        x *= mpmath.exp(step)
        if abs(step) < mpf(2) ** -90:
            return x


def points() -> list[tuple[int, int]]:
    """Successes and trials."""
    small = [(k, n) for n in (*range(1, 9), 15, 16, 17) for k in range(1, n + 1)]
    some = [(k, 64) for k in (1, 2, 5, 16, 31, 32, 33, 48, 63, 64)]
    for n in (128, 256, 1000, 4096, 10**4, 10**5, 10**6):
        ends = {1, 2, 3, n // 100, n // 10, n // 2, 9 * n // 10, n - 2, n - 1, n}
        some += [(k, n) for k in sorted({*ends, *(RNG.randrange(1, n) for _ in range(4))})]
    return small + some


def main() -> None:
    rows = [
        [k, n - k + 1, level, *pair(inverse(k, n, level))] for k, n in points() for level in LEVELS
    ]
    body = ",\n".join(" " + json.dumps(row) for row in rows)
    Path(__file__).with_name("incomplete_beta.json").write_text("[\n" + body + "\n]\n")


if __name__ == "__main__":
    main()
