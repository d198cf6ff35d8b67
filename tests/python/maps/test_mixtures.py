"""Mixtures of starts: which start a body takes, and that nothing else depends on the others."""

from typing import Any

import numpy as np
import pytest

import rigid
from drawn_again import uniforms
from map_texts import map_text
from refusals import refuses
from rigid.cli.toml_map import parse_spec
from rigid.cli.toml_table import SpecError
from rigid.maps.plan import map_plan
from small_maps import small_map

TOP = rigid.HeavyTop(rigid.Body((1.0, 1.2, 0.7)), mgl=1.0)
QUIET = rigid.Start(spin=3.0, attitude_noise=rigid.normal(0.1))
WILD = rigid.Start(
    spin=1.0, tilt=0.4, noise=rigid.uniform(2.0), attitude_noise=rigid.von_mises_fisher(2.0)
)
GIVEN = rigid.Start(
    omega=(0.0, 0.0, 2.0), noise=rigid.samples(np.diag([0.1, 0.2, 0.3]), weights=[1, 2, 1])
)
JOINT = rigid.Start(spin=2.0, noise=rigid.normal(cov=np.diag([1, 2, 3, 4, 5, 6]) * 1e-2))
MIXED = rigid.mixture([QUIET, WILD, GIVEN, JOINT], weights=[4.0, 3.0, 2.0, 1.0])
AXES: dict[str, Any] = {"mgl": [0.5, 1.0, 2.0]}
SAMPLES = 500
NO_START: Any = 3


def of(start: Any, **options: Any) -> rigid.StabilityMap:
    chosen: dict[str, Any] = {
        "axes": AXES,
        "samples": SAMPLES,
        "t_end": 1e-6,
        "stable": rigid.tilt_below(0.8),
        "rng": 77,
        "check": 0.0,
    }
    return rigid.stability_map(TOP, start=start, **{**chosen, **options})


def test_each_body_begins_as_in_a_map_of_its_start_alone() -> None:
    """NumPy tells which: block 2 of the draws of the sample."""
    mixed = of(MIXED).starts(range(SAMPLES))
    alone = [of(start).starts(range(SAMPLES)) for start in MIXED.starts]
    shares = MIXED.shares()
    assert shares[-1] == 1.0
    for pixel, u in enumerate(uniforms(77, 2, 3, SAMPLES)[..., 0]):
        taken = np.searchsorted(shares, u, side="right")
        for number, one in enumerate(alone):
            mine = taken == number
            assert mine.any()
            for name in ("omega", "attitude"):
                np.testing.assert_array_equal(
                    getattr(mixed, name)[pixel, mine], getattr(one, name)[pixel, mine]
                )


def test_judged_bodies_and_horizons_of_a_mixture() -> None:
    def rises(states: rigid.States) -> Any:
        assert states.gamma is not None
        return states.gamma[:, -1, 2] > 0.5

    t = [0.0, 1.0, 3.0]
    axes = {"mgl": [0.5, 1.0], "t_end": [1.0, 3.0]}
    asked: dict[str, Any] = {"samples": 60, "axes": axes, "t_end": None}
    result = of(MIXED, stable=rigid.judged(rises, t), **asked)
    single = of(MIXED, stable=rigid.judged(rises, t[:2]), **{**asked, "axes": {"mgl": [0.5, 1.0]}})
    np.testing.assert_array_equal(result.stable[0], single.stable)
    assert of(MIXED, samples=1).theory() is None


def test_an_axis_sets_its_number_in_every_start() -> None:
    both = rigid.mixture([rigid.Start(spin=s, noise=rigid.normal(n)) for s, n in ((1, 1), (2, 2))])
    starts = small_map(start=both, axes={"spin": [3.0], "noise": [0.0]}, samples=50).starts(
        range(50)
    )
    assert (starts.omega == [0.0, 0.0, 3.0]).all()
    # The plan is that of the fastest start.
    fast = rigid.mixture([rigid.Start(spin=1.0, axis=2), rigid.Start(spin=9.0, axis=2)])
    slow = rigid.Start(spin=1.0, axis=2)
    steps = [
        map_plan(small_map(start=one, axes={"I2/I1": [1.5]}, samples=1).spec).steps or 0
        for one in (slow, fast)
    ]
    assert steps[1] > 5.0 * steps[0]


START = "weight = 3\nspin = 2.0"
TOML = map_text(x='name = "mgl"\nvalues = [1.0, 2.0]', start=START).replace(
    f"[start]\n{START}",
    f"[[start]]\n{START}\n[[start]]\nspin = 1.0\n"
    'attitude_noise = { kind = "normal", size = 0.1 }',
)


def test_a_mixture_is_said_in_toml() -> None:
    spec = parse_spec(TOML, "top.toml")
    other = rigid.Start(spin=1.0, attitude_noise=rigid.normal(0.1))
    assert spec.start == rigid.mixture([rigid.Start(spin=2.0), other], weights=[3, 1])
    with pytest.raises(SpecError, match=r"weights\[0\] = -3: must be positive"):
        parse_spec(TOML.replace("weight = 3", "weight = -3"), "top.toml")
    with pytest.raises(SpecError, match=r"\[start\[0\]\] unknown key 'weigth'; did you mean"):
        parse_spec(TOML.replace("weight", "weigth"), "top.toml")
    with pytest.raises(SpecError, match="unknown key 'weight'"):
        parse_spec(
            TOML.replace("[[start]]\nspin = 1.0", "")
            .replace("[[", "[")
            .replace("]]", "]")
            .replace('attitude_noise = { kind = "normal", size = 0.1 }', ""),
            "top.toml",
        )


test_bad_input_is_named = refuses(
    [
        (lambda: rigid.mixture([QUIET]), "starts: 1 are given, must be 2 to 16"),
        (lambda: rigid.mixture([QUIET] * 17), "starts: 17 are given, must be 2 to 16"),
        (
            lambda: rigid.mixture([QUIET, NO_START]),
            TypeError,
            r"starts\[1\] = 3: must be a rigid.Start",
        ),
        (
            lambda: rigid.mixture([QUIET, WILD], [1.0]),
            r"weights: expected shape \(2,\), one for each start, got \(1,\)",
        ),
        (
            lambda: rigid.mixture([QUIET, WILD], [1.0, 0.0]),
            r"weights\[1\] = 0: must be positive and finite",
        ),
        (
            lambda: small_map(
                start=rigid.mixture([rigid.Start(spin=1.0, axis=k) for k in (1, 2)]),
                axes={"spin": [1.0]},
            ),
            "stable: the starts of the mixture turn about different axes; give axis=...",
        ),
    ]
)
