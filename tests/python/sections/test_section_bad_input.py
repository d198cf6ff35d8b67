"""What a section cannot answer is refused with the argument, its value and the rule."""

from collections.abc import Callable

import numpy as np
import pytest

import rigid
from refusals import refuses

TOP = rigid.HeavyTop(rigid.Body((1.0, 1.6, 0.7)), mgl=1.2, com=(0.6, 0.0, 0.8))
BOX = rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0)))
RATES = [0.3, 0.4, 1.0]
LIGHT = rigid.HeavyTop(rigid.Body((1.0, 1.6, 0.7)), mgl=[1.2, 0.0])

Call = Callable[[], object]

REFUSED: list[tuple[Call, str]] = [
    (lambda: rigid.section("omega4"), "name = 'omega4': must be one of 'height'"),
    (
        lambda: rigid.section("omega1", gamma=(0, 0, 1)),
        "name = 'omega1': leave the name out beside omega or gamma",
    ),
    (lambda: rigid.section(omega=(0, 0, 0)), "omega, gamma: both are zero"),
    (lambda: rigid.section("omega1", direction=2), "direction = 2: must be 1, -1 or 0"),
    (lambda: rigid.section(value=0.1), "value = 0.1: omit the value of 'height'"),
    (lambda: rigid.section("gamma2", 1.5), "value = 1.5: never crossed"),
    (
        lambda: rigid.section(gamma=(0.3, 0.4, 0.0), value=0.6),
        "value = 0.6: never crossed; along this direction the vertical has components from -0.5",
    ),
    (lambda: rigid.section("omega1", np.inf), "value = inf: must be finite"),
    (lambda: rigid.poincare(BOX, RATES, t_end=1.0), "section = 'height': a body without weight"),
    (
        lambda: rigid.poincare(LIGHT, [RATES, RATES], t_end=1.0),
        "section = 'height': a body without weight",
    ),
    (
        lambda: rigid.poincare(TOP, RATES, t_end=1.0, method="dop853"),
        "method = 'dop853': only a Taylor method is a polynomial inside its steps",
    ),
    (
        lambda: rigid.poincare(BOX, RATES, section="gamma1", t_end=1.0, method="exact"),
        "method = 'exact': only a Taylor method",
    ),
    (lambda: rigid.poincare(TOP, RATES, t_end=0.0), "t_end = 0.0: must be positive"),
    (lambda: rigid.poincare(TOP, RATES, t_end=1.0, count=0), "count = 0: must be at least"),
    (
        lambda: rigid.poincare(TOP, RATES, t_end=1.0, tolerance=2.0),
        "tolerance = 2e0: must be positive and below one",
    ),
    (
        lambda: rigid.top.on_surface(TOP, -1.3, 0.0, 5),
        "energy = -1.3: must be at least -1.2 J with l_gamma = 0.0",
    ),
    (lambda: rigid.top.on_surface(TOP, -1.1, 2.0, 5), "energy = -1.1: must be at least"),
    (
        lambda: rigid.top.on_surface(
            rigid.HeavyTop(rigid.Body((1.0, 1.6, 0.7)), mgl=1.2, damping=0.1), 2.0, 0.1, 5
        ),
        "a surface of one energy needs a scene without damping",
    ),
    (
        lambda: rigid.top.on_surface(TOP, 2.0, 0.4, 5, section=rigid.section("omega3", 50.0)),
        "section: 0 of .* random verticals have a crossing",
    ),
    (
        lambda: rigid.frequencies(np.linspace(0.0, 1.0, 50) ** 2, np.zeros(50)),
        "must be evenly spaced",
    ),
    (
        lambda: rigid.frequencies(np.ones(32), np.ones(32)),
        r"t: from 1\.0 to 1\.0: their span must be positive",
    ),
    (
        lambda: rigid.frequencies(np.linspace(-1.0, 1.0, 32) * 1.5e308, np.ones(32)),
        "their span must be positive, finite",
    ),
    (
        lambda: rigid.frequencies(np.arange(32.0), [[1.0, 2.0], [3.0]]),
        "must be an array of numbers",
    ),
    (lambda: rigid.frequencies([0.0, 1.0], [0.0, 1.0]), "t: 2 times, but lines need"),
    (
        lambda: rigid.frequencies(np.arange(32.0), np.zeros(32), count=5),
        "count = 5: must be at most an eighth of the 32 times",
    ),
    (
        lambda: rigid.frequencies(np.arange(32.0), np.zeros(31)),
        r"z: expected shape \(..., 32\), got \(31,\)",
    ),
    (lambda: rigid.frequencies(np.arange(32.0), np.full(32, np.nan)), "z: must be finite"),
    (lambda: rigid.frequencies(np.arange(32.0), ["a"] * 32), "must be an array of numbers"),
    (
        lambda: rigid.frequency_drift(rigid.simulate(BOX, RATES, t=np.arange(64.0)), of="gamma"),
        "of = 'gamma': the run has no gamma",
    ),
    (
        lambda: rigid.poincare(TOP, RATES, t_end=1.0).component("energy"),
        "name = 'energy': must be one of",
    ),
]


test_bad_input_is_refused_with_its_rule = refuses(REFUSED)


def test_another_type_is_refused() -> None:
    with pytest.raises(TypeError, match=r"section = 3: must be made by rigid\.section"):
        rigid.poincare(TOP, RATES, section=3, t_end=1.0)  # type: ignore[arg-type]
    with pytest.raises(TypeError, match=r"section = 3: must be made by rigid\.section"):
        rigid.top.on_surface(TOP, 2.0, 0.4, 5, section=3)  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="run = 3: must be a Run"):
        rigid.frequency_drift(3)  # type: ignore[arg-type]
