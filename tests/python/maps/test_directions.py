"""Directions of von Mises and Fisher: their distribution, its limits, and the bits of each draw."""

import math
from typing import Any

import numpy as np
import pytest
from scipy import stats

import rigid
from map_texts import map_text
from refusals import refuses
from rigid.cli.toml_map import parse_spec
from rigid.cli.toml_table import SpecError
from small_maps import Floats

SAMPLES = 40_000
KAPPAS = [0.0, 1e-300, 1e-9, 0.3, 3.0, 20.0, 500.0, 1e6, 1e300]
TOP = rigid.HeavyTop(rigid.Body((1.0, 1.2, 0.7)), mgl=1.0)

#: A statistic of Kolmogorov and Smirnov above this has a chance of 2 exp(-2 * 2.7**2) = 1e-6.
BOUND = 2.7 / math.sqrt(SAMPLES)


def drawn(axis: int, tilt: float = 0.0, **start: Any) -> rigid.StabilityMap:
    name = "kappa" if "noise" in start else "attitude_kappa"
    return rigid.stability_map(
        TOP,
        axes={name: KAPPAS},
        samples=SAMPLES,
        t_end=1e-9,
        stable=rigid.tilt_below(3.0),
        start=rigid.Start(spin=2.0, axis=axis, tilt=tilt, **start),
        method="rk4",
        check=0.0,
        rng=2026,
    )


def versine(kappa: float, u: float) -> float:
    """1 - cos by the inverse of the distribution, in long double."""
    x, power = np.longdouble(u), np.expm1(np.longdouble(-2.0 * kappa))
    return float(-np.log1p(x * power) / np.longdouble(kappa)) if kappa else 2.0 * u


def check_distribution(off: Floats, kappa: float) -> None:
    """Of 1 - cos, of all samples."""
    if kappa <= 1e-9:  # all directions are alike: Archimedes
        assert stats.kstest(off, "uniform", args=(0.0, 2.0)).statistic < BOUND
        return
    # P(1 - cos <= d) = expm1(-kappa d) / expm1(-2 kappa)
    found = stats.kstest(off, lambda d: np.expm1(-kappa * d) / np.expm1(-2.0 * kappa)).statistic
    assert found < BOUND
    # The mean of cos is coth(kappa) - 1 / kappa; five standard errors have a chance of 6e-7.
    lack = 1.0 / kappa - 2.0 / np.expm1(2.0 * kappa) if kappa < 300.0 else 1.0 / kappa
    assert abs(off.mean() - lack) < 5.0 * off.std() / math.sqrt(SAMPLES)


@pytest.mark.parametrize(("axis", "tilt"), [(3, 0.0), (1, 0.0), (2, 1.1)])
def test_the_axis_of_the_start_has_the_distribution(axis: int, tilt: float) -> None:
    result = drawn(axis, tilt, attitude_noise=rigid.von_mises_fisher(1.0))
    nominal = rigid.rotations.quaternion_to_matrix(result.spec.grid.attitude[0])[:, axis - 1]
    bodies = result.starts(range(SAMPLES))
    np.testing.assert_allclose(np.linalg.norm(bodies.attitude, axis=-1), 1.0, rtol=4e-16)
    for kappa, attitude in zip(KAPPAS, bodies.attitude, strict=True):
        direction = rigid.rotations.quaternion_to_matrix(attitude)[..., axis - 1]
        off = 0.5 * ((direction - nominal) ** 2).sum(axis=-1)  # accurate for small angles
        if kappa < 1e300:
            check_distribution(off, kappa)
        else:
            assert off.max() < 40.0 / kappa
        # About the nominal direction no side is preferred: Rayleigh's test of the azimuth.
        if 1e-9 <= kappa <= 500.0:
            along = np.cross(nominal, [0.6, 0.0, 0.8])
            along /= np.linalg.norm(along)
            azimuth = np.arctan2(direction @ np.cross(nominal, along), direction @ along)
            assert abs(np.exp(1j * azimuth).mean()) < 5.0 / math.sqrt(SAMPLES)
    assert not (result.status != 0).any()


def test_the_rates_keep_their_length() -> None:
    result = drawn(2, noise=rigid.von_mises_fisher(1.0))
    rates = result.starts(range(SAMPLES)).omega
    np.testing.assert_allclose(np.linalg.norm(rates, axis=-1), 2.0, rtol=2e-15)
    for kappa, omega in zip(KAPPAS[:-1], rates, strict=False):
        off = 0.125 * ((omega - [0.0, 2.0, 0.0]) ** 2).sum(axis=-1)
        check_distribution(off, kappa)
    np.testing.assert_allclose(rates[-1] - [0.0, 2.0, 0.0], 0.0, atol=2.0 * math.sqrt(80e-300))
    # Of any direction, and of the opposite of the third axis, where one of the axes across turns.
    for nominal in ((1.0, -2.0, 0.5), (0.0, 0.0, -2.0), (0.0, 0.0, 0.0)):
        spec = result.spec.replace(
            start=rigid.Start(omega=nominal, noise=rigid.von_mises_fisher(3))
        )
        omega = (
            rigid.stability_map(spec.replace(axes={"kappa": [3.0]}), progress=False)
            .starts(range(SAMPLES))
            .omega[0]
        )
        length = math.hypot(*nominal)
        np.testing.assert_allclose(np.linalg.norm(omega, axis=-1), length, rtol=2e-15)
        if length:
            check_distribution(1.0 - omega @ nominal / length**2, 3.0)
        else:
            assert not omega.any()


def test_numpy_draws_each_direction_again() -> None:
    """To some roundings: the angle is 2 asin(sqrt(versine / 2)), its azimuth 2 pi u."""
    result = drawn(3, attitude_noise=rigid.von_mises_fisher(1.0))
    bodies = result.starts(range(5)).attitude
    for pixel, kappa in enumerate(KAPPAS):
        for sample in range(5):
            philox = np.random.Philox(key=result.spec.seed, counter=[1, sample, pixel, 0])
            u = np.random.Generator(philox).random(4)
            half = 0.5 * versine(kappa, u[0])
            turn = 2.0 * math.pi * u[1]
            expected = [
                math.sqrt(1.0 - half),
                math.sqrt(half) * math.cos(turn),
                math.sqrt(half) * math.sin(turn),
                0.0,
            ]
            # sqrt halves the 8 ulp of the versine; a sine has 1e-16 of its argument besides.
            np.testing.assert_allclose(
                bodies[pixel, sample], expected, rtol=2e-15, atol=4e-16 * math.sqrt(half)
            )


TOML = map_text(
    x='name = "attitude_kappa"\nvalues = [1.0, 2.0]',
    start="""spin = 2.0
attitude_noise = { kind = "von_mises_fisher" }
noise = { kind = "von_mises_fisher", kappa = 4.0 }""",
)


def test_directions_are_said_in_toml() -> None:
    (start,) = parse_spec(TOML, "top.toml").start.starts
    assert start.noise == rigid.von_mises_fisher(4.0)
    assert start.attitude_noise == rigid.von_mises_fisher(0.0)
    with pytest.raises(SpecError, match="kappa: an axis of the map sets kappa; omit the key here"):
        parse_spec(TOML.replace('fisher" }', 'fisher", kappa = 1.0 }', 1), "top.toml")
    with pytest.raises(SpecError, match="needs the key 'kappa'"):
        parse_spec(TOML.replace(", kappa = 4.0", ""), "top.toml")
    with pytest.raises(SpecError, match="unknown key 'size'"):
        parse_spec(TOML.replace("kappa = 4.0", "size = 4.0"), "top.toml")


test_bad_input_is_named = refuses(
    [
        (lambda: rigid.von_mises_fisher(-1.0), "kappa = -1.0: must not be negative"),
        (lambda: rigid.von_mises_fisher(math.inf), "kappa = inf: must be finite"),
        (
            lambda: rigid.Start(
                spin=1.0, noise=type(rigid.normal(1.0))("von_mises_fisher", (1.0, 2.0, 3.0))
            ),
            "kappa: expected a single concentration, got 3 numbers",
        ),
        (
            lambda: drawn(3, noise=rigid.normal(1.0)),
            "axes: 'kappa' does not apply: the start has no noise=rigid.von_mises_fisher",
        ),
        (
            lambda: drawn(3, attitude_noise=rigid.normal(1.0)),
            "axes: 'attitude_kappa' does not apply: the start has no attitude_noise=rigid.von",
        ),
        (
            lambda: drawn(3, noise=rigid.von_mises_fisher(1.0)).spec.replace(axes={"noise": [1.0]}),
            "axes: 'noise' does not apply: the noise of the start has a concentration; use kappa",
        ),
        (
            lambda: drawn(3, attitude_noise=rigid.von_mises_fisher(1.0)).spec.replace(
                axes={"attitude_noise": [1.0]}
            ),
            "the attitude noise has a concentration; use attitude_kappa",
        ),
    ]
)
