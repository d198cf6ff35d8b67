"""Errors of the closed forms against the reference numbers of tests/golden, as Markdown tables.

    python benches/closed_form_errors.py > table

The bar is that of the tests: 1e-15 (1 + angle turned), or what an error of four roundings in the
inputs costs (4 u kappa, u = 2^-53), whatever is larger.
"""

from __future__ import annotations

import json
from collections.abc import Iterable
from decimal import Decimal
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from timing import Floats, parser, positive, share, sized

import rigid

GOLDEN = Path(__file__).parents[1] / "tests" / "golden"
FILES = ("free_asymmetric", "free_symmetric", "lab_box", "lagrange", "pendulum")
SCENES = sized(None, 2)
"""So many of each file and family; None for all."""
ROUNDOFF = 2.0**-53

# Where rounding the inputs decides the motion there is nothing to compare.
LARGEST_COST = 0.1


def bar(angle: Any, kappa: Any) -> Any:
    return np.maximum(1e-15 * (1.0 + angle), 4.0 * ROUNDOFF * kappa)


def moved(
    moments: Floats, weight: Floats, omega: Floats, attitude: Floats, times: Floats
) -> tuple[Floats, Floats]:
    """Rates and attitudes of one body by closed form, (m, 3) and (m, 4)."""
    body, mgl = rigid.Body(moments), float(np.linalg.norm(weight))
    scene = rigid.HeavyTop(body, mgl=mgl, com=weight / mgl) if mgl else rigid.FreeBody(body)
    run = rigid.simulate(scene, omega, attitude, t=times, method="exact")
    assert run.attitude is not None
    return run.omega, run.attitude


def turned_between(attitude: Floats, high: Floats, low: Floats) -> Floats:
    """Angles (rad) to attitudes known as sums of two doubles, (m,).

    The difference is formed first, so that nothing cancels; its part along the attitude is length.
    """
    along = np.einsum("mi,mi->m", attitude, high)[:, None]
    off = np.copysign(1.0, along) * attitude - high - low
    off -= np.einsum("mi,mi->m", off, high)[:, None] * high
    angles: Floats = 2.0 * np.arctan2(np.linalg.norm(off, axis=-1), np.abs(along[:, 0]))
    return angles


def doubles(digits: Iterable[list[str]]) -> tuple[Floats, Floats]:
    """Decimal numbers as doubles and what those miss."""
    rows = [[Decimal(text) for text in row] for row in digits]
    high = [[float(x) for x in row] for row in rows]
    low = [
        [float(x - Decimal(h)) for x, h in zip(*pair, strict=True)]
        for pair in zip(rows, high, strict=True)
    ]
    return np.array(high), np.array(low)


def within_the_bar(name: str, shares: ArrayLike) -> float:
    """The median share: what is not the motion is above the bar, and NaN is no share."""
    positive(f"worst share of the bar, {name}", np.max(shares))
    return share(f"median share of the bar, {name}", np.median(shares))


def trajectories() -> None:
    """Each trajectory at the sample whose error is the largest share of the bar."""
    print("| scene | t_end (s) | turned (rad) | 4 u kappa | bar | attitude error | of the bar |")
    print("|---|---|---|---|---|---|---|")
    shares = []
    for file in FILES:
        for scene in json.loads((GOLDEN / f"{file}.json").read_text())["scenes"][:SCENES]:
            if isinstance(scene["inertia"][0], list):
                continue
            samples = scene["samples"]
            times = np.array([sample["t"] for sample in samples], dtype=np.float64)
            _, attitude = moved(
                np.array(scene["inertia"]),
                scene["mass"] * scene["gravity"] * np.array(scene["com"]),
                np.array(scene["omega0"]),
                np.roll(scene["q0"], 1),
                times,
            )
            high, low = doubles(sample["q"] for sample in samples)
            errors = turned_between(attitude, np.roll(high, 1, axis=-1), np.roll(low, 1, axis=-1))
            rates, _ = doubles(sample["omega"] for sample in samples)
            angles = np.linalg.norm(rates, axis=-1).max() * times
            kappa = np.array([sample["kappa_att"] or 0.0 for sample in samples])
            allowed = bar(angles, kappa)
            k = int(np.argmax(errors / allowed))
            shares.append(errors[k] / allowed[k])
            print(
                f"| {scene['id']} | {times[-1]:g} | {angles[-1]:.3g} "
                f"| {4.0 * ROUNDOFF * kappa[k]:.1e} | {allowed[k]:.1e} | {errors[k]:.1e} "
                f"| {shares[-1]:.2f} |"
            )
    median, worst = within_the_bar("all trajectories", shares), max(shares)
    print(f"\n{len(shares)} scenes: median {median:.2f}, worst {worst:.2f} of the bar.")


def families() -> None:
    """Random scenes by family, attitude and rates."""
    with np.load(GOLDEN / "closed_forms.npz") as file:
        table = dict(file)
    print("| family | scenes | attitude: median | 99 % | worst | rates: median | 99 % | worst |")
    print("|---|---|---|---|---|---|---|---|")
    everything = []
    for index, name in enumerate(table["families"].tolist()):
        chosen = (table["family"] == index) & (table["kappa_att"] * ROUNDOFF <= LARGEST_COST)
        shares = np.array([share_of_bar(table, k) for k in np.flatnonzero(chosen)[:SCENES]])
        everything.append(shares)
        print(row(name, shares))
    every = np.concatenate(everything)
    within_the_bar("all attitudes", every[:, 0])
    within_the_bar("all rates", every[:, 1])
    print(row("all", every))
    attitudes, rates = (every > 1.0).sum(axis=0)
    left_out = int((table["kappa_att"] * ROUNDOFF > LARGEST_COST).sum())
    print(f"\nErrors above the bar: {attitudes} attitudes, {rates} rates. Omitted: {left_out}")
    print(
        f"scenes, whose attitude changes by more than {LARGEST_COST} rad when inputs are rounded."
    )


def share_of_bar(table: dict[str, Any], k: int) -> tuple[float, float]:
    """Errors of attitude and rates, the latter relative to the fastest, over their bars."""
    weight = np.zeros(3)
    if axis := int(table["axis"][k]):
        weight[abs(axis) - 1] = np.copysign(table["mgl"][k], axis)
    t, angle = float(table["t"][k]), float(table["angle"][k])
    omega, attitude = moved(
        table["moments"][k], weight, table["omega0"][k], table["attitude0"][k], np.array([t])
    )
    turned = turned_between(attitude, table["attitude"][[k]], table["attitude_low"][[k]])[0]
    off = np.linalg.norm(omega[0] - table["omega"][k] - table["omega_low"][k])
    fastest = angle / abs(t)
    return (
        turned / bar(angle, float(table["kappa_att"][k])),
        (off / fastest if fastest else off) / bar(angle, float(table["kappa_omega"][k])),
    )


def row(name: str, shares: Floats) -> str:
    cells = [f"{np.quantile(column, q):.3f}" for column in shares.T for q in (0.5, 0.99, 1.0)]
    return f"| {name} | {len(shares)} | {' | '.join(cells)} |"


def main() -> None:
    parser(__doc__).parse_args()
    trajectories()
    print()
    families()


if __name__ == "__main__":
    main()
