"""The starts that the page of the explorer draws, against those of the core."""

import itertools
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rigid
from pages import NODE, content, under_node, unpacked


@pytest.mark.skipif(NODE is None, reason="needs node")
def test_a_product_and_a_sum_are_rounded_once() -> None:
    rng = np.random.default_rng(5)
    tiny = [0.0, 1.0, -1.0, 2.0**-53, -(2.0**-106), 1e-290, -1e-290, 1e100, 1.0 + 2.0**-52]
    numbers = np.concatenate([tiny, rng.normal(size=6)])
    asked = list(itertools.product(numbers.tolist(), repeat=3))
    asked = [one for one in asked if abs(one[0] * one[1]) > 1e-300 or 0.0 in one[:2]]
    found = under_node("cases => cases.map(one => fma(...one))", asked)
    # The quotient of two whole numbers is correctly rounded in Python.
    exact = [Fraction(a) * Fraction(b) + Fraction(c) for a, b, c in asked]
    assert found == [float(one) for one in exact]


LAWS: list[Callable[..., rigid.Noise]] = [rigid.normal, rigid.uniform, rigid.direction]


@pytest.mark.skipif(NODE is None, reason="needs node")
@pytest.mark.parametrize(
    ("noise", "attitude_noise"),
    [
        *((law(0.3), None) for law in LAWS),
        *((law([0.1, 0.0, 1e-3]), law(size)) for law in LAWS for size in (1e-3, 3.0)),
        (None, rigid.uniform_attitude()),
    ],
)
def test_the_page_draws_the_starts_of_the_map_to_the_bit(
    noise: Any, attitude_noise: Any, tmp_path: Path
) -> None:
    result = rigid.stability_map(
        rigid.HeavyTop(rigid.Body((1.0, 1.3, 0.5)), mgl=1.0),
        # Pixels of other horizons draw by the same numbers; one body has impossible moments.
        axes={"spin": [-3.0, 1.0, 4.0], "t_end": [0.1, 0.2], "I3": [0.5, 9.0]},
        start=rigid.Start(spin=1.0, axis=3, tilt=0.4, noise=noise, attitude_noise=attitude_noise),
        samples=40,
        stable=rigid.tilt_below(1.0),
        rng=2**100 + 7,
    )
    draw = content(result.explore(tmp_path / "a.html"))["draw"]
    arrays = {name: unpacked(packed) for name, packed in draw.items() if "type" in packed}
    found = under_node(
        "draw => { for (const name in draw) if (!['key', 'laws'].includes(name)) "
        "draw[name] = Float64Array.from(draw[name]); "
        "return [0, 2, 4].flatMap(pixel => "
        "Array.from({length: 40}, (_, k) => startOf(draw, pixel, k))); }",
        draw | {name: array.tolist() for name, array in arrays.items()},
    )
    meant = result.starts(range(40))
    for name, column in (("omega", 0), ("attitude", 1)):
        of_map = getattr(meant, name).reshape(12, 40, -1)[[0, 2, 4]]
        np.testing.assert_array_equal([body[column] for body in found], of_map.reshape(120, -1))


MIXED = rigid.mixture([rigid.Start(spin=1.0, axis=3), rigid.Start(spin=2.0, axis=3)])
GIVEN = rigid.samples(omega=[[0.1, 0.0, 0.0], [0.0, 0.2, 0.0]])


@pytest.mark.parametrize(
    "start",
    [
        MIXED,
        rigid.Start(spin=1.0, axis=3, noise=GIVEN),
        rigid.Start(spin=1.0, axis=3, noise=rigid.normal(cov=np.diag([0.1, 0.2, 0.3]))),
        rigid.Start(spin=1.0, axis=3, noise=rigid.von_mises_fisher(20.0)),
    ],
)
def test_a_page_holds_the_starts_that_it_does_not_draw(start: Any, tmp_path: Path) -> None:
    result = rigid.stability_map(
        rigid.HeavyTop(rigid.Body((1.0, 1.3, 0.5)), mgl=1.0),
        axes={"mgl": [0.6, 1.0]},
        start=start,
        samples=4,
        t_end=1.0,
        stable=rigid.tilt_below(1.0),
        rng=7,
    )
    held = content(result.explore(tmp_path / "a.html"))
    assert "draw" not in held
    meant = result.starts(range(held["samples"]))
    assert (unpacked(held["omega"]) == meant.omega.ravel()).all()
    assert (unpacked(held["attitude"]) == meant.attitude.ravel()).all()
