"""Bodies whose parameters are random: distributions, verdicts, bits, replays, refusals."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rigid
from drawn_again import uniforms
from refusals import refuses
from rigid.maps.theory import predict
from rigid.model.parameters import PARAMETERS
from small_maps import small_map

BOX = rigid.FreeBody(rigid.Body((1.0, 2.0, 2.5)))
SEED = 2**70 + 11


def first_uniforms(block: int, pixel: int, count: int) -> Any:
    """The first uniform of a block of draws of each sample, as NumPy's Philox has it."""
    return uniforms(SEED, block, pixel + 1, count)[pixel, :, 0].astype(np.float64)


def flipping(vary: Any, **options: Any) -> rigid.StabilityMap:
    """A map of boxes that spin about their middle axis."""
    asked: dict[str, Any] = {
        "axes": {"spin": [1.0, 1.5]},
        "samples": 70,
        "t_end": 20.0,
        "stable": rigid.no_flip(2),
        "start": rigid.Start(spin=1.0, axis=2, noise=rigid.normal(1e-3)),
        "rng": SEED,
    }
    return rigid.stability_map(BOX, vary=vary, **{**asked, **options})


def test_a_uniform_parameter_is_what_numpy_draws() -> None:
    result = flipping({"I1": rigid.uniform(0.2), "I3": rigid.uniform(0.1, relative=True)})
    for pixel in (0, 1):
        drawn = result.starts(np.arange(70), pixel=pixel)
        assert drawn.draws is not None
        once = drawn.draws == 1
        first, third = (2.0 * first_uniforms(3 + k, pixel, 70) - 1.0 for k in (0, 1))
        # The third block of draws belongs to the first parameter; NumPy counts blocks from one.
        assert np.array_equal(drawn.parameters["I1"][once], (1.0 + 0.2 * first)[once])
        assert np.array_equal(drawn.parameters["I3"][once], (2.5 * (1.0 + 0.1 * third))[once])
        assert once.mean() > 0.8


@pytest.mark.parametrize("names", [("I1", "I3"), ("I3", "I1")])
def test_draws_do_not_depend_on_the_order_in_which_parameters_are_named(
    names: tuple[str, str], tmp_path: Path
) -> None:
    """NumPy draws them by the place of each name in the alphabet; a store has the same bodies."""
    vary = {name: rigid.uniform(0.05) for name in names}
    in_memory = flipping(vary)
    stored = flipping(vary, store=tmp_path / "boxes.rigid")
    for result in (in_memory, stored):
        drawn = result.starts(np.arange(70), pixel=1)
        assert drawn.draws is not None
        assert np.all(drawn.draws == 1)  # the largest draw, 2.55, is below 0.95 + 2
        for place, nominal in enumerate({"I1": 1.0, "I3": 2.5}.items()):
            name, value = nominal
            expected = value + 0.05 * (2.0 * first_uniforms(3 + place, 1, 70) - 1.0)
            assert np.array_equal(drawn.parameters[name], expected)
    assert np.array_equal(stored.stable, in_memory.stable)
    assert np.array_equal(stored.earliest, in_memory.earliest)


def test_a_normal_parameter_has_mean_and_deviation() -> None:
    result = flipping({"I2": rigid.normal(0.02, relative=True)}, samples=4000)
    values = result.starts(np.arange(4000), pixel=0).parameters["I2"]
    # Four standard errors of a mean and of a standard deviation.
    assert abs(values.mean() - 2.0) < 4.0 * 0.04 / np.sqrt(4000)
    assert abs(values.std() - 0.04) < 4.0 * 0.04 / np.sqrt(2 * 4000)


def test_each_verdict_is_that_of_the_drawn_body() -> None:
    """The truth is the closed form of the first flip of each body."""
    vary = {"I1": rigid.normal(0.1), "I3": rigid.normal(0.05, relative=True)}
    result = flipping(vary, samples=200)
    stable = np.zeros(2, dtype=int)
    for pixel in (0, 1):
        drawn = result.starts(np.arange(200), pixel=pixel)
        moments = np.column_stack(
            [drawn.parameters["I1"], np.full(200, 2.0), drawn.parameters["I3"]]
        )
        flips = rigid.exact.flip_times(rigid.Body(moments), drawn.omega, axis=2)[:, 0]
        stable[pixel] = np.count_nonzero(flips > 20.0)
        seen = result.outcomes(np.arange(200), pixel=pixel).outcome == "stable"
        assert np.array_equal(seen, flips > 20.0)
    assert result.stable.tolist() == stable.tolist()
    assert 0 < stable[0] < 200


def test_draws_that_no_body_can_have_are_repeated_and_counted() -> None:
    flat = rigid.FreeBody(rigid.Body((1.0, 1.5, 2.45)))  # I3 of 2.5 at most
    result = rigid.stability_map(
        flat,
        axes={"spin": [1.0]},
        vary={"I3": rigid.uniform(0.2)},
        samples=400,
        t_end=1.0,
        stable=rigid.no_flip(),
        rng=SEED,
    )
    drawn: Any = result.starts(np.arange(400), pixel=0)
    assert drawn.parameters["I3"].max() <= 2.5
    values = np.array([2.45 + 0.2 * (2.0 * first_uniforms(3 + k, 0, 400) - 1.0) for k in range(5)])
    first = np.argmax(values <= 2.5, axis=0)
    known = (values <= 2.5).any(axis=0)
    assert np.array_equal(drawn.draws[known], first[known] + 1)
    assert np.array_equal(drawn.parameters["I3"][known], values[first, np.arange(400)][known])


@pytest.mark.parametrize("stable", [rigid.tilt_below(0.5), rigid.regular()])
def test_a_replay_is_the_body_that_was_drawn(stable: Any) -> None:
    result = flipping({"I1": rigid.normal(0.05)}, stable=stable, samples=3)
    for sample in range(3):
        body = result.replay((1,), sample)
        drawn = result.starts(sample, pixel=1)
        assert body.parameters == {"spin": 1.5, "I1": drawn.parameters["I1"].item()}
        assert body.run.spec["scene"]["body"]["moments"][0] == body.parameters["I1"]
        assert body.omega.tolist() == drawn.omega.tolist()


def test_a_criterion_of_ones_own_reads_the_drawn_parameters() -> None:
    seen: list[Any] = []

    def judge(states: Any) -> Any:
        seen.append(states.parameters["I1"].copy())
        return states.parameters["I1"] > 1.0

    stable = rigid.judged(judge, t=[1.0])
    result = flipping({"I1": rigid.uniform(0.1)}, stable=stable, t_end=None)
    values = result.starts(np.arange(70)).parameters["I1"]
    assert np.array_equal(result.stable, np.count_nonzero(values > 1.0, axis=-1))
    assert np.unique(np.concatenate(seen)).size > 100


def test_measures_and_more_samples_until_an_interval_is_narrow() -> None:
    vary = {"I1": rigid.uniform(0.3)}
    result = flipping(vary, samples=None, half_width=0.2, measure=rigid.flips())
    alone = flipping(vary, samples=int(result.samples[0]), axes={"spin": [1.0]})
    assert alone.stable[0] == result.stable[0]
    assert result.measures["flips"].count.tolist() == result.samples.tolist()


@pytest.mark.parametrize("first", ["I1", "I1/I3"])
def test_ratios_are_drawn_after_the_moments_that_they_read(first: str) -> None:
    result = flipping({"I2/I1": rigid.uniform(0.05), first: rigid.uniform(0.02)})
    for sample in range(5):
        body = result.replay((0,), sample)
        i1, i2, i3 = body.run.spec["scene"]["body"]["moments"]
        assert i1 == body.parameters[first] * (1.0 if first == "I1" else i3)
        assert i2 == body.parameters["I2/I1"] * i1


def test_semi_axes_of_moons_are_drawn() -> None:
    """The truth are the moments of homogeneous ellipsoids, such as c² + b² about axis 1."""
    moon = rigid.FreeBody(rigid.Body.ellipsoid(1.4, 1.2, 1.0))
    vary = {"a/b": rigid.uniform(1.1, 1.3), "b/c": rigid.normal(0.05, relative=True)}
    result = rigid.stability_map(
        moon, axes={"spin": [1.0]}, vary=vary, samples=50, t_end=1.0, stable=rigid.no_flip(), rng=1
    )
    drawn: Any = result.starts(np.arange(50), pixel=0)
    b, c = drawn.parameters["b/c"], 1.0
    a = drawn.parameters["a/b"] * b
    bodies: Any = rigid.sample_bodies(moon, vary, 50, rng=1)
    right = np.stack([b * b + c * c, a * a + c * c, a * a + b * b], axis=-1)
    right *= moon.body.moments[2] / right[:, 2:]
    assert np.allclose(bodies.body.moments, right, rtol=1e-14, atol=0.0)
    assert np.unique(b).size == np.unique(drawn.parameters["a/b"]).size == 50


def test_no_parameter_at_random_leaves_the_body() -> None:
    bodies = rigid.sample_bodies(BOX, {}, 3, rng=1)
    assert np.array_equal(bodies.body.moments, np.tile(BOX.body.moments, (3, 1)))


def test_no_theory_is_claimed_of_bodies_that_vary() -> None:
    assert predict(flipping(None).spec) is not None
    varied = flipping({"I1": rigid.normal(0.01)})
    assert predict(varied.spec) is None
    assert varied.plan.why[0] == "parameters vary: in closed form each body that has one"


test_what_cannot_vary = refuses(
    [
        ({"spin": rigid.normal(0.1)}, "vary: 'spin' belongs to the start; give the start a noise"),
        ({"t_end": rigid.normal(0.1)}, "vary: 't_end' cannot vary from body to body"),
        (
            {"com_tilt": rigid.normal(0.1)},
            "vary: 'com_tilt' cannot vary from body to body; use com1, com2, com3",
        ),
        ({"I4": rigid.normal(0.1)}, "vary: 'I4' is no parameter (known: I1"),
        ({"mgl": rigid.normal(0.1)}, "vary: 'mgl' does not apply: a free body feels no weight"),
        ({"a": rigid.normal(0.1)}, "vary: 'a' does not apply: the sides of the body are not known"),
        (
            {"I2": rigid.normal(0.1), "I2/I1": rigid.normal(0.1)},
            "vary: 'I2' and 'I2/I1' both set I2",
        ),
        (
            {"drag2": rigid.normal(0.1), "drag": rigid.normal(0.1)},
            "vary: 'drag2' and 'drag' exclude each other: both set the drag",
        ),
        (
            {"drag1": rigid.normal(0.1, relative=True)},
            "vary: 'drag1' is 0, and a share of 0 varies nothing; give an absolute size",
        ),
        (
            {"I1": rigid.normal(1e9)},
            "vary: none of 1000 draws gave a body that can exist, in pixel 0, sample 0; take a",
        ),
    ],
    literal=True,
    by=lambda vary: flipping(vary),
)


test_what_is_no_distribution_of_a_parameter = refuses(
    [
        (["I1"], "vary = ['I1']: must be a dict of names and distributions"),
        ({"I1": 0.1}, "vary['I1'] = 0.1: must be rigid.normal(size), rigid.uniform(size), with"),
        ({"I1": rigid.normal([1.0, 2.0, 3.0])}, "vary['I1'] = normal(1, 2, 3): must be"),
        ({"I1": rigid.direction(0.1)}, "vary['I1'] = direction(0.1): must be"),
    ],
    literal=True,
    kind=TypeError,
    by=lambda vary: flipping(vary),
)


test_what_no_map_of_bodies_that_vary_has = refuses(
    [
        (
            lambda: small_map(
                rigid.FreeBody(rigid.Body.box(0.3, 0.2, 0.1, mass=1.0)),
                axes={"I1": [0.004]},
                vary={"a": rigid.normal(0.01)},
            ),
            "'I1' and 'a' exclude each other: the moments of a box",
        ),
        (lambda: rigid.uniform(0.2, 0.1), "high = 0.1: must be above the low end, 0.2"),
        (lambda: rigid.uniform(0.1, np.nan), "high = nan: must be finite"),
        (
            lambda: rigid.uniform(0.1, 0.2, relative=True),
            "high = 0.2: belongs to rigid.uniform(low, high), whose values do not depend on a",
        ),
        (
            lambda: rigid.Start(spin=1.0, noise=rigid.uniform(0.1, 0.2)),
            "noise = uniform(0.1, 0.2): a start has absolute noise; a range of values is for vary=",
        ),
        (
            lambda: rigid.Start(spin=1.0, noise=rigid.normal(0.1, relative=True)),
            "noise = normal(0.1, relative): a start has absolute",
        ),
    ],
    literal=True,
)


def test_a_range_of_values_does_not_depend_on_the_nominal_one(tmp_path: Path) -> None:
    result = flipping({"I3": rigid.uniform(2.1, 2.9)})
    drawn = result.starts(np.arange(70), pixel=0)
    assert drawn.draws is not None
    once = drawn.draws == 1
    values = 2.5 + 0.4 * (2.0 * first_uniforms(3, 0, 70) - 1.0)
    # Doubles near 2.5 are 4e-16 apart.
    assert drawn.parameters["I3"][once] == pytest.approx(values[once], rel=4e-16)
    assert once.mean() > 0.8
    path = tmp_path / "map.npz"
    result.save(path)
    again = rigid.load_map(path).starts(np.arange(70), pixel=0)
    assert np.array_equal(again.parameters["I3"], drawn.parameters["I3"])


def test_an_orbit_that_is_nearly_a_parabola_is_drawn_again() -> None:
    satellite = rigid.FreeBody(rigid.Body((1.0, 2.0, 2.5)), orbit=rigid.Orbit(1.0, 0.9))
    drawn: Any = rigid.sample_bodies(satellite, {"eccentricity": rigid.uniform(0.3)}, 400, rng=SEED)
    e = np.asarray(drawn.orbit.eccentricity)
    assert not np.any((e > 0.95) & (e < 1.05))
    # Of the interval 0.6 to 1.2 a share of 7/10 ends below 0.95: four standard deviations.
    assert abs(np.mean(e < 0.95) - 0.7) < 4.0 * np.sqrt(0.7 * 0.3 / 400)


def test_a_draw_that_one_of_three_coefficients_cannot_have_is_repeated() -> None:
    scene = rigid.FreeBody(BOX.body, damping=(0.3, 0.01, 0.3))
    bodies: Any = rigid.sample_bodies(scene, {"damping": rigid.uniform(0.1)}, 50, rng=SEED)
    each = np.diagonal(bodies.damping, axis1=1, axis2=2)
    # All three have one deviation: of -0.01 at least, where the smallest vanishes.
    np.testing.assert_allclose(each - each[:, 1:2], [[0.29, 0.0, 0.29]] * 50, atol=1e-16)
    assert 0.0 <= each[:, 1].min() < 0.02


def test_every_parameter_of_a_body_can_vary() -> None:
    scenes: dict[str, rigid.FreeBody | rigid.HeavyTop] = {
        "free": rigid.FreeBody(
            rigid.Body((1.0, 1.5, 2.0)),
            orbit=rigid.Orbit(0.1, 0.1),
            rotor=(0.1, 0.2, 0.3),
            drag=0.1,
            dissipation=rigid.EnergySink(0.01),
            torque=rigid.Torque.body((0.1, 0.1, 0.1)),
            damping=0.1,
        ),
        "box": rigid.FreeBody(rigid.Body.box(0.3, 0.2, 0.1, mass=1.0)),
        "ellipsoid": rigid.FreeBody(rigid.Body.ellipsoid(1.4, 1.2, 1.0)),
        "top": rigid.HeavyTop(rigid.Body((1.0, 1.5, 2.0)), mgl=1.0, com=(0.6, 0.0, 0.8)),
    }
    of_start = {"spin", "tilt", "energy", "l_gamma", "kappa", "attitude_kappa", "limit", "t_end"}
    for name, row in PARAMETERS.items():
        if row.place in ("com angles", "omega", "noise", "attitude_noise"):
            continue
        if name in of_start:
            continue
        of_places = {"mgl": "top", "com": "top", "box": "box", "semi-axes": "ellipsoid"}
        scene = of_places.get(row.place, "free")
        result = rigid.stability_map(
            scenes[scene],
            axes={"spin": [0.5]},
            vary={name: rigid.uniform(1e-3)},
            samples=4,
            t_end=0.5,
            stable=rigid.spin_above(0.1),
        )
        assert np.unique(result.starts(np.arange(4), pixel=0).parameters[name]).size == 4, name
        assert result.failed.sum() == 0, name


def test_sampled_bodies_are_the_bodies_of_a_map() -> None:
    vary = {"I1": rigid.normal(0.1), "damping": rigid.uniform(0.5, relative=True)}
    scene = rigid.FreeBody(BOX.body, damping=0.02)
    bodies = rigid.sample_bodies(scene, vary, 70, rng=SEED)
    result = rigid.stability_map(
        scene,
        axes={"spin": [1.0]},
        vary=vary,
        samples=70,
        t_end=1.0,
        stable=rigid.no_flip(),
        rng=SEED,
    )
    drawn = result.starts(np.arange(70), pixel=0).parameters
    assert np.array_equal(np.asarray(bodies.body.moments)[:, 0], drawn["I1"])
    damping = np.asarray(bodies.damping)
    assert np.array_equal(damping, drawn["damping"][:, np.newaxis, np.newaxis] * np.eye(3))
    with pytest.raises(ValueError, match="count = 0"):
        rigid.sample_bodies(scene, vary, 0)
