"""Numbers that leave the range of doubles are refused, and other objects than those meant."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import rigid
from rigid import earth, exact, figures, inertia, rotations, solids, statics, top

BODY = rigid.Body((1.0, 2.0, 2.5))
TOP = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)
HUGE = 1e300
FAST = [1.0, HUGE, 2.0]
CUBIC = {"a": 1.25, "b": 2.5, "alpha": 1.0, "beta": 2.0}

OVERFLOWS: dict[str, tuple[str, Callable[[], Any]]] = {
    "steady precession": ("spin", lambda: exact.steady_precession(TOP, 1.0, HUGE)),
    "disk": ("radius", lambda: solids.disk(HUGE)),
    "sphere": ("radius", lambda: solids.sphere(HUGE)),
    "cylinder": ("height", lambda: solids.cylinder(1.0, HUGE)),
    "box": ("a", lambda: solids.box(HUGE, 1.0, 1.0)),
    "cone": ("radius", lambda: solids.cone(HUGE, 1.0)),
    "wrench": ("forces", lambda: statics.wrench([FAST], [[1e200, 0.0, 0.0]])),
    "cubic": ("beta", lambda: top.f_u(2.0, **{**CUBIC, "beta": 1e308})),
    "roots": ("a", lambda: top.f_roots(**{**CUBIC, "a": HUGE})),
    "period of nutation": ("b", lambda: top.nutation_period(**{**CUBIC, "b": HUGE})),
    "effective potential": ("b", lambda: top.effective_potential(TOP, 1.0, a=1.0, b=HUGE)),
    "ellipticity": ("polar_radius", lambda: earth.ellipticity(HUGE, 1.0)),
    "rotation vector": ("vector", lambda: rotations.exp_so3(FAST)),
}


@pytest.mark.parametrize("name", OVERFLOWS)
def test_an_overflow_is_refused_by_the_argument_that_is_out_of_range(name: str) -> None:
    argument, call = OVERFLOWS[name]
    with pytest.raises(ValueError, match=f"^{argument} = .*range of doubles; count in other"):
        call()


OTHERS: list[Any] = [rigid.FreeBody(BODY), 0.2, [1.0], np.ones(3)]


@pytest.mark.parametrize(
    ("words", "call"),
    [
        ("scene = ", lambda: top.effective_minimum(OTHERS[0], a=1.0, b=2.0)),
        ("region = 0.2: must be a rigid.solids.", lambda: solids.density_integral(1.0, OTHERS[1])),
        (r"parts\[0\] = 1.0: must be rigid.inertia.", lambda: inertia.compose(OTHERS[2])),
        ("run = array.*: must be a rigid.Run", lambda: figures.poinsot(OTHERS[3])),
    ],
)
def test_other_objects_are_refused_as_what_they_are(words: str, call: Callable[[], Any]) -> None:
    with pytest.raises(TypeError, match=f"^{words}"):
        call()
