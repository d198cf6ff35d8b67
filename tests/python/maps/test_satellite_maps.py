"""Maps of satellites: the way to the flat spin, and stable attitudes on an orbit."""

import dataclasses
from statistics import NormalDist
from typing import Any

import numpy as np
import pytest

import rigid
from rigid._energy_loss import mean_products
from rigid.cli.toml_map import read_spec
from rigid.maps.satellites import median_across, time_to_separatrix
from rigid.maps.theory import predict
from rigid.maps.watched import DISTANCE, watched
from rigid.store.call import run_map
from small_maps import spec_of


def coarse(name: str, every: int, samples: int) -> rigid.StabilityMap:
    """A built-in map with some of its pixels."""
    spec = read_spec(name).spec
    axes = {axis.name: axis.values[::every] for axis in spec.axes}
    return run_map(spec.replace(axes=axes, samples=samples), progress=False)


@pytest.mark.parametrize(
    ("name", "every", "least", "lines"),
    [
        ("gravity-gradient", 6, 0.25, ["DeBra-Delp", "pitch stable"]),
        ("tumbling-debris", 6, 0.4, ["axis 1 becomes the middle one", "half pass the separatrix"]),
        ("falling-top", 15, 0.5, ["onset of the fall", "about half pass 0.5 rad by t = 100 s"]),
    ],
)
def test_built_in_maps_agree_with_their_theory(
    name: str, every: int, least: float, lines: list[str]
) -> None:
    result = coarse(name, every, 4)
    theory: Any = result.theory()
    assert not result.failed.any()
    known = np.isfinite(theory.share) & (result.status == 0)
    assert known.sum() > least * (result.status == 0).sum()
    assert {0.0, 1.0} == set(theory.share[known].tolist())
    np.testing.assert_array_equal(result.share[known], theory.share[known])
    for curve, words in zip(theory.curves, lines, strict=True):
        assert curve.label.startswith(words)


def test_the_line_where_the_long_axis_becomes_the_middle_one_is_at_equal_moments() -> None:
    long = np.linspace(2.5, 3.9, 15)
    theory: Any = predict(
        spec_of(
            scene=rigid.FreeBody(rigid.Body((2.0, 3.4, 4.0)), dissipation=rigid.EnergySink(0.1)),
            axes={"I1": long},
            start=rigid.Start(spin=1.0, axis=1, noise=rigid.normal(1e-3)),
            stable=rigid.no_flip(1),
        )
    )
    np.testing.assert_allclose(theory.curves[0].field, 3.4 / long - 1.0, rtol=0.0, atol=1e-15)


def test_roll_and_yaw_are_stable_where_the_inequality_of_debra_and_delp_says_so() -> None:
    result = coarse("gravity-gradient", 12, 1)
    theory: Any = result.theory()
    yaw, roll = np.meshgrid(*(axis.values for axis in result.spec.axes))  # over the moment of pitch
    k1, k3 = (1.0 - yaw) / roll, (1.0 - roll) / yaw
    swings, product = theory.curves[0].field, k1 * k3
    inside = (product > 0.0) & (1.0 + 3.0 * k1 + product > 4.0 * np.sqrt(np.abs(product)))
    known = np.isfinite(swings)
    np.testing.assert_array_equal(swings[known] > 0.0, inside[known])
    assert 10 < inside[known].sum() < known.sum() - 10


def roll_and_yaw(moments: tuple[float, float, float]) -> tuple[float, float]:
    """Largest rate of growth, in orbits' radians, and condition of the modes of roll and yaw.

    From ``s⁴ + (1 + 3 k1 + k1 k3) s² + 4 k1 k3 = 0``, and a mode by its ratio of yaw to roll.
    """
    roll, pitch, yaw = moments
    k1, k3 = (pitch - yaw) / roll, (pitch - roll) / yaw
    roots = np.roots([1.0, 0.0, 1.0 + 3.0 * k1 + k1 * k3, 0.0, 4.0 * k1 * k3])
    ratio = (roots**2 + 4.0 * k1) / ((1.0 - k1) * roots)
    modes = np.array([1.0 + 0.0 * roots, ratio, roots, ratio * roots])
    return float(roots.real.max()), float(np.linalg.cond(modes / np.linalg.norm(modes, axis=0)))


@pytest.mark.parametrize(
    ("moments", "factor", "share"),
    [
        ((1.6, 2.0, 1.0), 1.01, 1.0),
        ((1.6, 2.0, 1.0), 0.99, np.nan),
        ((2.0, 1.5, 1.0), 0.99, 0.0),
        ((2.0, 1.5, 1.0), 1.01, np.nan),
    ],
)
def test_roll_and_yaw_are_predicted_with_a_margin(
    moments: tuple[float, float, float], factor: float, share: float
) -> None:
    """Four standard deviations keep half of the limit; a thousandth of one passes it four times.

    Between these limits nothing is predicted.
    """
    rate, noise, t_end = 2.0, 1e-3, 8.0
    growth, condition = roll_and_yaw(moments)
    size = noise / rate
    if growth < 1e-9:
        limit = 2.0 * 4.0 * size * condition
    else:
        limit = np.exp(growth * rate * t_end) * 1e-3 * size / condition / 4.0
    assert 0.0 < limit < 1.0
    theory = predict(
        spec_of(
            scene=rigid.FreeBody(rigid.Body(moments), orbit=rigid.Orbit(rate)),
            axes={"I1": [moments[0]]},
            start=rigid.Start(
                omega=(0.0, rate, 0.0), attitude=(0.5,) * 4, noise=rigid.normal(noise)
            ),
            stable=rigid.tilt_below(factor * limit, axis=2, reference="vertical"),
            method="auto",
            t_end=t_end,
        )
    )
    np.testing.assert_array_equal(np.nan if theory is None else theory.share[0], share)


def test_the_summary_says_that_noise_of_the_attitude_is_in_the_way_of_theory() -> None:
    spec = read_spec("gravity-gradient").spec
    assert isinstance(spec.start, rigid.Start)
    noisy = dataclasses.replace(spec.start, attitude_noise=rigid.normal(1e-3))
    axes = {axis.name: axis.values[::12] for axis in spec.axes}
    none = "none is known for this map: one is without attitude_noise"
    for start, words in ((spec.start, "DeBra and Delp"), (noisy, none)):
        result = run_map(spec.replace(start=start, axes=axes, samples=1, t_end=1.0))
        (told,) = (line for line in result.summary().splitlines() if line.startswith("theory"))
        assert words in told


def passage(
    moments: tuple[float, float, float], sink: float, *, spin: float = 1.3, across: float = 0.02
) -> tuple[float, float]:
    """Times at which one body passes the separatrix, by integration and by the mean loss."""
    scene = rigid.FreeBody(rigid.Body(moments), dissipation=rigid.EnergySink(sink))
    i1, i2, i3 = sorted(moments)
    # The rates across axis 1 whose energy is that of the given rate about the largest axis.
    start = np.zeros(3)
    start[0], start[int(np.argmax(moments))] = spin, across
    expected = float(
        time_to_separatrix(
            np.array([moments]), np.full(3, sink), np.array([spin]), np.array([across])
        )[0]
    )
    t = np.linspace(0.0, 1.3 * expected, 4001)
    run = rigid.simulate(
        scene, start, t=t, method="taylor16", tolerance=1e-12, record="rates", check=False
    )
    w = run.omega[:, np.argsort(moments)]
    above = i1 * (i2 - i1) * w[:, 0] ** 2 - i3 * (i3 - i2) * w[:, 2] ** 2
    passed = t[np.flatnonzero(above < 0.0)[0]]
    flipped = t[np.flatnonzero(run.omega[:, 0] < 0.0)[0]]
    assert flipped > passed
    return float(passed), expected


@pytest.mark.parametrize("moments", [(1.0, 1.7, 2.2), (0.3, 2.0, 1.8), (1.0, 1.05, 1.9)])
def test_the_separatrix_is_reached_in_the_time_of_the_mean_loss(
    moments: tuple[float, float, float],
) -> None:
    """The weaker the sink, the better the mean over a nutation holds."""
    off = []
    for sink in (0.02, 0.005):
        passed, expected = passage(moments, sink)
        off.append(abs(passed / expected - 1.0))
    assert off[0] < 0.1
    assert off[1] < 0.03


def test_nothing_is_predicted_near_the_time_of_the_separatrix() -> None:
    """Within a tenth of the times of the largest and of the smallest noise that is likely.

    The spin has the noise, too. A period of small nutations is added, whose mean the loss is.
    """
    moments, noise, spin, sink = (1.0, 1.7, 2.2), 0.01, 1.3, 0.02
    spins = spin + 4.0 * noise * np.array([-1.0, 1.0, -1.0, 1.0])
    large, small = 4.0 * noise, 1e-3 * noise
    times = time_to_separatrix(
        np.array([moments] * 4), np.full(3, sink), spins, np.array([large, large, small, small])
    )
    last, first = times[:2].min(), times[2:].max()
    assert last < first  # the smaller the noise, the later
    about_1, about_3 = np.sqrt([(0.7 * 1.2) / (1.7 * 2.2), (1.2 * 0.5) / (1.0 * 1.7)])
    before = 2.0 * np.pi / (about_1 * spins[0])
    after = 2.0 * np.pi / (about_3 * spins[0] / 2.2)  # L is I1 spin
    for t_end, share in (
        (0.89 * last - before, 1.0),
        (0.91 * last - before, np.nan),
        (1.09 * first + after, np.nan),
        (1.11 * first + after, 0.0),
    ):
        spec = spec_of(
            scene=rigid.FreeBody(rigid.Body(moments), dissipation=rigid.EnergySink(sink)),
            axes={"spin": [spin]},
            start=rigid.Start(spin=spin, axis=1, noise=rigid.normal(noise)),
            stable=rigid.no_flip(1),
            method="auto",
            t_end=float(t_end),
        )
        theory = predict(spec)  # None if it has nothing to say
        np.testing.assert_array_equal(np.nan if theory is None else theory.share[0], share)
        # Nothing is known of the distribution of samples, whatever their size.
        drawn = rigid.samples(np.random.default_rng(1).normal(0.0, noise, (9, 3)))
        given = rigid.Start(spin=spin, axis=1, noise=drawn)
        assert predict(spec.replace(start=given, samples=9)) is None


def test_next_to_a_symmetric_body_the_separatrix_is_near() -> None:
    """So the time to it, which grows with the smallest moment, falls in the end."""
    known = [passage((i1, 1.7, 2.0), 0.01, across=1e-3) for i1 in (1.5, 1.68, 1.699)]
    passed, expected = np.array(known).T
    # Less than one loss for each nutation: the start within it moves the passage by half of one.
    np.testing.assert_allclose(passed, expected, rtol=0.06)
    for times in (passed, expected):
        assert times[0] < times[1] > times[2]


def test_means_of_products_of_jacobi_functions() -> None:
    m = np.array([0.0, 1e-9, 0.9e-5, 1.1e-5, 1e-3, 0.3, 0.9, 0.999])
    u = (
        (np.arange(4096) + 0.5)
        / 4096.0
        * (0.5 * np.pi / rigid.exact.agm(1.0, np.sqrt(1.0 - m)))[:, np.newaxis]
    )  # a quarter of a period, where the midpoint rule is exact to rounding
    sn, cn, dn = (part**2 for part in rigid.exact.jacobi(u, np.broadcast_to(1.0 - m, u.T.shape).T))
    expected = [(m * (sn * cn).mean(axis=1)), (sn * dn).mean(axis=1), (cn * dn).mean(axis=1)]
    for found, mean in zip(mean_products(m, 1.0 - m), expected, strict=True):
        # 1e-10 of m/8 where the series ends, 1e-16 / m of it where the difference begins.
        np.testing.assert_allclose(found, mean, rtol=1e-9, atol=1e-15)


@pytest.mark.parametrize(
    ("moments", "size"),
    [
        ((1.0, 2.0, 2.0), (1.0, 1.0)),
        ((1.0, 1.001, 1.9), (1.0, 1.0)),
        ((1.0, 1.5, 1.2), (0.4, 3.0)),
        ((1.0, 1.6, 1.9), (0.0, 2.0)),
    ],
)
def test_half_of_the_nutations_are_larger_than_the_median(
    moments: tuple[float, float, float], size: tuple[float, float]
) -> None:
    """By quantiles of the normal distribution about both axes."""
    inertia = np.array(moments)
    weights = inertia[1:] * (inertia[1:] - inertia[0])
    number = 2000
    normal = np.array([NormalDist().inv_cdf((k + 0.5) / number) for k in range(number)])
    first, second = weights * np.square(size)
    energy = first * normal[:, np.newaxis] ** 2 + second * normal**2
    median = median_across(inertia[np.newaxis], np.array([size]))[0]
    # The quantiles are a grid of 2000 steps of 1/2000 in the chance.
    assert abs((energy > median**2 * weights.max()).mean() - 0.5) < 1.0 / number


def test_methods_that_integrate_no_rotor_are_refused_in_maps() -> None:
    scene = rigid.FreeBody(rigid.Body((1.0, 1.6, 2.0)), rotor=(0.1, 0.0, 0.2))
    asked: Any = {"axes": {"spin": [0.5, 1.0]}, "samples": 2, "t_end": 10.0, "progress": False}
    with pytest.raises(ValueError, match="method = 'etd4': does not integrate a rotor"):
        rigid.stability_map(scene, stable=rigid.no_flip(2), method="etd4", **asked)


def test_a_flat_spin_is_predicted_only_where_nothing_but_the_sink_acts_on_a_spin() -> None:
    def predicted(**changes: Any) -> object:
        axes = changes.pop("axes", {"spin": [1.0, 2.0]})
        start = changes.pop("start", rigid.Start(spin=1.0, axis=1, noise=rigid.normal(1e-3)))
        sink = rigid.EnergySink(0.05)
        scene = rigid.FreeBody(rigid.Body((1.0, 2.0, 2.2)), dissipation=sink, **changes)
        return predict(
            spec_of(scene=scene, axes=axes, start=start, stable=rigid.no_flip(1), t_end=50.0)
        )

    theory: Any = predicted(axes={"spin": [0.0, 1.0]})
    np.testing.assert_array_equal(theory.share, [np.nan, 1.0])
    assert predicted(orbit=rigid.Orbit(0.5)) is None
    assert predicted(drag=0.01) is None
    assert predicted(axes={"dissipation": [0.01, 0.02]}) is None
    nutating = rigid.Start(omega=(1.0, 0.1, 0.0), noise=rigid.normal(1e-3))
    assert predicted(axes={"omega1": [1.0, 2.0]}, start=nutating) is None


def test_the_words_of_a_map_on_an_orbit_are_those_of_its_axes_and_of_what_is_constant() -> None:
    """Its eccentricity is an axis; neither energy nor momentum is constant."""
    xarray = pytest.importorskip("xarray")
    result = rigid.stability_map(
        rigid.FreeBody(rigid.Body((1.0, 1.2, 1.5)), orbit=rigid.Orbit(1.0)),
        axes={"eccentricity": [0.0, 0.1]},
        start=rigid.Start(spin=1.0, axis=3),
        stable=rigid.judged(lambda states: states.omega[:, -1, 2] > 0.0, t=[1.0, 2.0]),
        samples=1,
        t_end=xarray.DataArray(2.0),
        rng=1,
    )
    said = result.summary()
    assert "orbit at 1 rad/s, eccentricity varied" in said
    assert "circular" not in said
    # On the ellipse, not on the circle beside it, the distance from the planet changes.
    assert DISTANCE in [chart for chart, _ in watched(result.spec)]
    circles = result.spec.replace(axes={"eccentricity": [0.0]})
    assert DISTANCE not in [chart for chart, _ in watched(circles)]
    drift = next(line for line in said.splitlines() if line.startswith("worst drift"))
    assert "energy" not in drift
    assert "unit lengths" in drift


def test_an_asteroid_keeps_its_mode_as_energy_and_momentum_say() -> None:
    """After the passage a free body turns about its short axis if L² / 2E exceeds the moment I2.

    The criterion looks at signs of a rate all along; here is the state at the end, a month later.
    """
    axes = {"eccentricity": [2.0, 4.25], "tilt": [0.35, 1.2]}
    spec = read_spec("apophis").spec.replace(samples=24, axes=axes)
    result = rigid.stability_map(spec, progress=False)
    assert not result.failed.any()
    for pixel in np.ndindex(2, 2):
        drawn = result.starts(range(24), pixel=pixel)
        parts = [result.replay(pixel, k).run.spec["scene"]["orbit"] for k in range(24)]
        orbit = rigid.Orbit(
            np.array([part["rate"] for part in parts]),
            np.array([part["eccentricity"] for part in parts]),
            drawn.parameters["anomaly"],
        )
        scene = rigid.FreeBody(spec.scene.body, orbit=orbit)
        run = rigid.simulate(scene, drawn.omega, drawn.attitude, t=[spec.t_end])
        assert run.error.max() < 1e-6
        moments = np.array(spec.scene.body.moments)
        momenta, twice = moments * run.omega[:, 0], np.sum(moments * run.omega[:, 0] ** 2, axis=1)
        short = np.sum(momenta**2, axis=1) / twice > moments[1]
        kept = short & (run.omega[:, 0, 2] > 0.0)
        seen = result.outcomes(range(24), pixel=pixel).outcome
        assert (seen[~kept] == "unstable").all()
        # A body may roll over and back during the passage.
        assert np.count_nonzero((seen == "stable") != kept) <= 2
    assert result.share[0, 1] > 0.9  # "likely to remain in a short axis mode", Benson et al. 2023
    assert result.share[0, 0] < 0.9
