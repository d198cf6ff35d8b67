"""Parameters from noisy rates: right within their stated errors, honest about what is not told."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.optimize import least_squares, lsq_linear
from scipy.spatial.transform import Rotation
from scipy.stats import kstest

import rigid
from physics import Floats
from refusals import refuses
from rigid.fits.least_squares import minimum
from rigid.fits.unknowns import Unknowns
from rigid.model.parameters import PLACES

T = np.linspace(0.0, 25.0, 150)
START = np.array([0.2, 1.0, 0.3])
BODY = rigid.Body((1.0, 1.6, 2.2))
RATIOS = ("I2/I1", "I3/I1", "omega")


def measured(scene: Any, sigma: float, seed: int, start: Any = START, **options: Any) -> Any:
    run = rigid.simulate(scene, start, t=T, check=False, **options)
    noise = np.random.default_rng(seed).normal(size=run.omega.shape)
    return run.omega + sigma * noise


def test_errors_of_many_fits_have_the_stated_covariance() -> None:
    guess, sigma = rigid.Body((1.0, 1.4, 2.0)), 0.02
    right = np.array([1.6, 2.2, *START])
    fits = [
        rigid.fit(guess, T, omega=measured(BODY, sigma, seed), sigma=sigma, free=RATIOS)
        for seed in range(40)
    ]
    # The squared distance in units of the covariance has mean 5 and variance 10 (chi-squared).
    distances = [
        (one.values - right) @ np.linalg.solve(one.covariance, one.values - right) for one in fits
    ]
    assert abs(np.mean(distances) - 5.0) < 4.0 * np.sqrt(10.0 / 40)
    left = T.size * 3 - 5
    assert abs(np.mean([one.chi2 for one in fits]) - left) < 4.0 * np.sqrt(2 * left / 40)
    assert not any(one.undetermined or one.at_bounds for one in fits)


def test_without_noise_the_parameters_come_back() -> None:
    truth = rigid.FreeBody(BODY, damping=np.diag([0.0, 0.01, 0.02]))
    guess = rigid.FreeBody(rigid.Body((1.0, 1.5, 2.3)), damping=np.diag([0.0, 0.0, 0.01]))
    found = rigid.fit(
        guess,
        T,
        omega=measured(truth, 0.0, 0, method="taylor16"),
        sigma=1e-3,
        free=("I2/I1", "I3/I1", "damping2", "damping3", "omega"),
        start=START + 0.05,
    )
    assert np.allclose(found.values, [1.6, 2.2, 0.01, 0.02, *START], rtol=0, atol=1e-8)
    assert found["damping3"] == found.values[3]
    assert np.allclose(found.scene.body.moments, (1.0, 1.6, 2.2), rtol=1e-8)
    assert np.allclose(found.omega, START, atol=1e-8)


def test_free_motion_tells_ratios_of_moments_only() -> None:
    rates = measured(BODY, 0.01, 3)
    found = rigid.fit(BODY, T, omega=rates, sigma=0.01, free=("I1", "I2", "I3", "omega"))
    assert found.undetermined == (
        "not determined by the data: equal relative changes of I1, I2, I3",
    )
    assert np.isinf(found.std[:3]).all()
    assert np.isfinite(found.std[3:]).all()
    ratios = rigid.fit(BODY, T, omega=rates, sigma=0.01, free=RATIOS)
    assert np.isclose(found["I2"] / found["I1"], ratios["I2/I1"], rtol=1e-6)
    assert ratios.undetermined == ()


def test_a_rotation_about_one_axis_tells_no_moment() -> None:
    found = rigid.fit(
        BODY,
        T,
        omega=np.tile([0.0, 0.0, 1.0], (T.size, 1)),
        sigma=0.01,
        free="I2/I1",
        start=[0.0, 0.0, 1.0],
    )
    assert found.undetermined == ("not determined by the data: I2/I1",)


def test_weight_tells_the_moments_themselves() -> None:
    top = rigid.HeavyTop(rigid.Body((1.0, 1.6, 0.7)), mgl=1.2, com=(0.6, 0.0, 0.8))
    # Short: over long times the sum of squares of a chaotic top has many minima.
    short = T[T < 5.0]
    rates = measured(top, 0.0, 0, accuracy=1e-12)[: short.size]
    guess = rigid.HeavyTop(rigid.Body((1.05, 1.5, 0.75)), mgl=1.2, com=(0.6, 0.0, 0.8))
    told: dict[str, Any] = {"omega": rates, "sigma": 1e-3, "start": rates[0]}
    found = rigid.fit(guess, short, **told, free=("I1", "I2", "I3"))
    assert np.allclose(found.values, (1.0, 1.6, 0.7), rtol=1e-7)
    assert found.undetermined == ()
    every = rigid.fit(guess, short, **told, free=("I1", "I2", "I3", "mgl"))
    assert every.undetermined == (
        "not determined by the data: equal relative changes of I1, I2, I3, mgl",
    )
    weight = rigid.fit(top, short, **told, free="mgl")
    assert np.isclose(weight["mgl"], 1.2, rtol=1e-8)


def test_no_fit_leaves_what_a_body_can_have() -> None:
    flat = rigid.Body((1.0, 1.5, 2.5))  # at the edge: I3 = I1 + I2
    for seed in range(3):
        rates = measured(flat, 0.05, seed)
        for free in (("I3",), ("I2/I1", "I3/I1"), ("I1", "I2", "I3")):
            guess = rigid.Body((1.0, 1.2 if len(free) > 1 else 1.5, 1.4))
            found = rigid.fit(guess, T, omega=rates, sigma=0.05, free=free, start=START)
            i = np.array(found.scene.body.moments)
            assert np.all(2.0 * i <= i.sum())
    undamped = rigid.Body((1.0, 1.5, 2.0))
    ends = [
        rigid.fit(
            rigid.FreeBody(undamped, damping=0.01),
            T,
            omega=measured(undamped, 0.05, seed),
            sigma=0.05,
            free=("damping1", "damping2", "damping3"),
            start=START,
        )
        for seed in range(4)
    ]
    assert all((one.values >= 0.0).all() for one in ends)
    assert any("is zero, the least that it can be" in " ".join(one.at_bounds) for one in ends)


@pytest.mark.parametrize("free", [("I2",), ("I1/I3", "I2/I3"), ("I1", "I2/I1"), ("I1", "I2", "I3")])
def test_each_derivative_is_that_of_the_residuals(free: tuple[str, ...]) -> None:
    model = Unknowns(rigid.FreeBody(BODY), START, None, free)
    x, base = model.first, model.base + model.steer @ model.first
    values, slopes = model.told(base)
    moments = dict(zip(("I1", "I2", "I3"), (1.0, 1.6, 2.2), strict=True))
    expected = [eval(name, dict(moments)) for name in free]
    assert np.allclose(values, expected, rtol=1e-8)
    assert np.allclose(model.at(x)[0].body.moments, (1.0, 1.6, 2.2), rtol=1e-8)
    for k in range(len(base)):
        step = 1e-6 * np.eye(len(base))[k]
        change = (model.told(base + step)[0] - model.told(base - step)[0]) / 2e-6
        assert np.allclose(change, slopes[:, k], atol=1e-8)


def test_derivatives_of_what_a_gyroscope_measures() -> None:
    free = ("I2/I1", "I3", "damping1", "omega", "scale", "bias2", "sensor")
    scene = rigid.FreeBody(BODY, damping=[0.01, 0.02, 0.03])
    model = Unknowns(scene, START, None, free)
    rng = np.random.default_rng(5)
    x = model.first + 0.1 * model.sizes * rng.uniform(0.0, 1.0, len(model.first))
    slopes = model.slopes(x, T) @ model.steer
    # A central difference errs by 7e2 h² of the largest slope, and by 1e-8 / h for the accuracy
    # of the rates.
    h = 1e-4
    for k, along in enumerate(h * np.eye(len(x))):
        change = (model.rates(x + along, T) - model.rates(x - along, T)) / (2.0 * h)
        assert np.abs(change - slopes[..., k]).max() < 2e-4 * np.abs(slopes[..., k]).max()


@pytest.mark.parametrize("free", [("I2",), ("I1/I3", "I2/I3"), ("I2", "I3/I1"), ("I1", "I2", "I3")])
def test_other_guesses_are_bodies_all_over_what_can_be(free: tuple[str, ...]) -> None:
    model = Unknowns(rigid.FreeBody(BODY), START, None, (*free, "omega"))
    guesses = model.other_moments(200)
    moments = np.array([model.at(guess)[0].body.moments for guess in guesses])
    moving = [name[:2] in {one[:2] for one in free} for name in ("I1", "I2", "I3")]
    assert np.allclose(moments[:, ~np.array(moving)], np.array(BODY.moments)[~np.array(moving)])
    # Possible moments are the sides of a triangle. One may be what its others leave; of two or
    # three that move, some triangle is all but flat beside each side.
    half = 0.5 * moments.sum(axis=1, keepdims=True)
    assert np.all(moments < half)
    if len(free) == 2:
        # Two of the squares of a triple of equal chances share their sum in any way alike.
        shares = (half - moments)[:, moving][:, 0] / moments[:, np.logical_not(moving)][:, 0]
        assert kstest(shares, "uniform").pvalue > 1e-3
    if len(free) == 1:
        assert np.ptp(moments[:, 1]) > 0.8 * 2.0 * min(moments[0, [0, 2]])
    else:
        assert np.all((moments / half).max(axis=0) > 0.9)
    assert all((model.at(guess)[1] == START).all() for guess in guesses)


test_what_a_fit_refuses = refuses(
    [
        ({"free": "I4"}, r"free = 'I4': is no parameter of a free body \(known: I1"),
        ({"free": "mgl"}, "free = 'mgl': a free body has no weight"),
        ({"free": "drag"}, "free = 'drag': the scene has no drag"),
        ({"free": ()}, "must be names of parameters"),
        ({"free": ("I1", "I1")}, "'I1' is named twice"),
        ({"free": ("I1", "I1/I2")}, "one moment varies by two"),
        ({"free": "sensor4"}, r"free = 'sensor4': is no parameter"),
        ({"free": ("bias", "bias2")}, r"free = \('bias', 'bias2'\): 'bias2' is named twice"),
        ({"free": ("I1/I2", "I2/I1")}, "one of the ratios follows from the others"),
        ({"free": ("I1/I2", "I2/I3", "I3/I1")}, "one of the ratios follows from the others"),
        ({"omega": np.zeros((3, 3))}, r"omega: expected shape \(150, 3\), got \(3, 3\)"),
        ({"sigma": 0.0}, "sigma = 0"),
        # 25e6 s at a rate of sqrt(3).
        (
            {"t": 1e6 * T, "start": START},
            r"t: the phase of the motion grows by 4.33e\+07 rad, must be at most",
        ),
        (
            {"sigma": 1e-200, "start": np.ones(3)},
            "t, sigma: the derivatives of the motion over sigma overflow",
        ),
        ({"sigma": np.full(150, 0.1)}, r"sigma: expected .* \(150, 1\) .* sigma\[:, np.newaxis\]"),
        ({"sigma": np.ones((2, 3))}, r"sigma: expected a number or shape \(3,\), .* got \(2, 3\)$"),
        ({"t": [], "omega": np.ones((0, 3))}, "t: must hold a time"),
        ({"start": [1.0, 2.0]}, "start"),
        ({"t": [0.0], "omega": np.ones((1, 3)), "free": ("I1", "omega")}, "4 parameters, but 3"),
    ],
    by=lambda options: rigid.fit(
        BODY, **{"t": T, "omega": np.ones((150, 3)), "sigma": 0.1, "free": "I1", **options}
    ),
)


ACROSS = [[0.1, 0.05, 0.0], [0.05, 0.1, 0.0], [0.0, 0.0, 0.1]]
ORBIT = rigid.FreeBody(BODY, orbit=rigid.Orbit(1))
TABLE = rigid.FreeBody(BODY, torque=rigid.Torque.body([(0, 0, 1), (0, 0, 0)], times=[0.0, 100.0]))
POWERS = {"mgl": 2, "damping": 1, "torque": 2, "rotor": 1, "drag": 0, "dissipation": -1}
"""Of the unit of rates in the units of numbers, which have one unit of moments each."""


@pytest.mark.parametrize("name", POWERS)
def test_a_first_guess_of_a_fit_is_off_by_what_has_the_unit_of_its_number(name: str) -> None:
    place = PLACES[name]
    assert place.guess is not None
    nothing = np.zeros((3,) * place.width)
    off, other = (np.asarray(place.guess(nothing, m * 1.3, w * 0.7)) for m, w in ((1, 1), (8, 2)))
    assert (off > 0.0).all()
    assert (other == 8.0 * 2.0 ** POWERS[name] * off).all()


# Else the times of the table would count from the first measurement without a word.
CLOCK = r"t\[0\] = 5: must be 0, because the scene has a clock"


test_what_no_fit_of_the_scene_tells = refuses(
    [
        (
            *(rigid.FreeBody(BODY, damping=ACROSS), T, "damping1"),
            "free = 'damping1': the damping of the scene is not along the body axes",
        ),
        (
            *(rigid.FreeBody(BODY, drag=0.1), T, ("drag2", "drag")),
            "'drag' and 'drag2' exclude each other",
        ),
        (TABLE, T + 5.0, ("I1", "omega"), CLOCK),
        (ORBIT, T + 5.0, ("I1", "omega"), CLOCK),
    ],
    by=lambda scene, t, free: rigid.fit(scene, t, omega=np.ones((150, 3)), sigma=0.1, free=free),
)


FORCED = {
    "torque of a thruster": (
        rigid.FreeBody(BODY, torque=rigid.Torque.body((0.01, 0.02, -0.03))),
        rigid.FreeBody(BODY),
        ("torque1", "torque2", "torque3"),
    ),
    "drag": (rigid.FreeBody(BODY, drag=0.03), rigid.FreeBody(BODY, drag=0.01), ("drag",)),
    "drag of each axis": (
        rigid.FreeBody(BODY, drag=(0.01, 0.02, 0.03)),
        rigid.FreeBody(BODY, drag=0.02),
        ("drag1", "drag2", "drag3"),
    ),
    "rotor": (
        rigid.FreeBody(BODY, rotor=(0.1, 0.2, 0.3)),
        rigid.FreeBody(BODY, rotor=(0.1, 0.1, 0.1)),
        ("rotor1", "rotor2", "rotor3", "I2/I1"),
    ),
    "energy sink": (
        rigid.FreeBody(BODY, dissipation=rigid.EnergySink(0.02)),
        rigid.FreeBody(BODY, dissipation=rigid.EnergySink(0.01)),
        ("dissipation",),
    ),
    "orbit": (
        rigid.FreeBody(BODY, orbit=rigid.Orbit(0.4, 0.3, 0.5)),
        rigid.FreeBody(BODY, orbit=rigid.Orbit(0.42, 0.25, 0.4)),
        ("rate", "eccentricity", "anomaly"),
    ),
}


@pytest.mark.parametrize("force", FORCED)
def test_a_fit_finds_the_numbers_of_every_force(force: str) -> None:
    truth, guess, free = FORCED[force]
    rates = measured(truth, 0.0, 0, accuracy=1e-11)
    found = rigid.fit(guess, T, omega=rates, sigma=1e-4, free=free, start=START)
    right = [numbers_of_name(truth, name) for name in free]
    assert found.success
    assert not found.undetermined
    assert np.allclose(found.values, right, rtol=0.0, atol=1e-7)
    assert np.allclose([numbers_of_name(found.scene, name) for name in free], found.values)


@pytest.mark.parametrize(
    ("absent", "guess"), [("drag", 0.01), ("dissipation", rigid.EnergySink(0.01))]
)
def test_a_force_that_does_not_act_ends_within_its_error_of_zero(absent: str, guess: Any) -> None:
    """Of four logs some ask for a negative coefficient: the fit ends at the bound, zero."""
    scene: Any = rigid.FreeBody(BODY, damping=0.01, **{absent: guess})
    ends = []
    for seed in range(4):
        rates = measured(rigid.FreeBody(BODY, damping=0.02), 0.01, seed)
        found = rigid.fit(scene, T, omega=rates, sigma=0.01, free=(absent, "damping"), start=START)
        assert found.success
        # Four standard deviations of each number, of a parameter at its bound with those inside.
        assert np.all(abs(found.values - [0.0, 0.02, 0.02, 0.02]) < 4.0 * found.std)
        assert found.values[0] >= 0.0
        ends.append(found.at_bounds)
    assert any(f"{absent} is zero, the least that it can be" in words for words in ends)


def numbers_of_name(scene: Any, name: str) -> float:
    """The value of a parameter, read from the attributes of the scene."""
    if name in ("rate", "eccentricity", "anomaly"):
        return float(getattr(scene.orbit, name))
    if "/" in name:
        moments = scene.body.moments
        return float(moments[int(name[1]) - 1] / moments[int(name[4]) - 1])
    of, k = (name[:-1], int(name[-1]) - 1) if name[-1].isdigit() else (name, 0)
    value = getattr(scene, of)
    if of == "torque":
        return float(value.in_body[0][k])
    return float(value.coefficient[k] if of == "dissipation" else value[k])


def test_a_log_begins_at_any_time() -> None:
    """Times in eighths of a second are exact numbers, of an epoch too: all bits are the same."""
    t = np.arange(150) / 8.0
    rates = rigid.simulate(BODY, START, t=t).omega
    rates = rates + 0.01 * np.random.default_rng(1).normal(size=rates.shape)
    guess = rigid.Body((1.0, 1.5, 2.3))
    here = rigid.fit(guess, t, omega=rates, sigma=0.01, free=RATIOS)
    assert here.success
    for first in (5.0, -9.0, 1.7e9):
        there = rigid.fit(guess, t + first, omega=rates, sigma=0.01, free=RATIOS)
        assert there.values.tolist() == here.values.tolist()
        assert there.std.tolist() == here.std.tolist()


def test_rates_along_the_axes_of_a_drawing() -> None:
    axes = rigid.rotations.quaternion_to_matrix(np.array([0.5, 0.5, -0.1, 0.7]))
    rates = measured(BODY, 0.01, 5) + np.array([0.01, 0.0, 0.02])
    free = (*RATIOS, "bias")
    guess = rigid.Body((1.0, 1.5, 2.3))
    plain = rigid.fit(guess, T, omega=rates, sigma=0.01, free=free)
    drawn = rates @ axes.T
    found = rigid.fit(guess, T, omega=drawn, sigma=0.01, free=free, frame=axes)
    # Both end within 1e-8 of the least chi²: within 1e-4 of a std.
    assert np.all(np.abs(found.values[:2] - plain.values[:2]) < 2e-4 * plain.std[:2])
    assert np.allclose(found.omega, axes @ plain.omega, rtol=0, atol=2e-4 * plain.std[2:5].max())
    bias = axes @ plain.values[5:]
    assert np.allclose(found.values[5:], bias, rtol=0, atol=2e-4 * plain.std[5:].max())


def test_the_rotation_of_the_gyroscope_in_the_body_comes_back() -> None:
    mounted = Rotation.from_rotvec([0.3, 0.68, 0.2])
    free = (*RATIOS, "sensor")
    guess, sigma = rigid.Body((1.0, 1.5, 2.3)), 0.01
    exact = rigid.simulate(BODY, START, t=T, method="taylor16").omega @ mounted.as_matrix()
    found = rigid.fit(guess, T, omega=exact, sigma=sigma, free=free)
    # The fit ends within 1e-4 of a std; without noise nothing else is off.
    assert np.all(np.abs(found.values - [1.6, 2.2, *START, 0.3, 0.68, 0.2]) < 2e-4 * found.std)
    assert np.allclose(found.sensor, mounted.as_matrix(), rtol=0.0, atol=2e-4 * found.std.max())
    assert np.allclose(found.model, exact, rtol=0.0, atol=1e-3 * sigma)
    # With noise: the squared distance of 8 numbers, of mean 8 and variance 16, over 10 fits.
    distances = []
    for seed in range(10):
        noise = sigma * np.random.default_rng(seed).normal(size=exact.shape)
        one = rigid.fit(guess, T, omega=exact + noise, sigma=sigma, free=free)
        off = one.values - [1.6, 2.2, *START, 0.3, 0.68, 0.2]
        distances.append(off @ np.linalg.solve(one.covariance, off))
    assert abs(np.mean(distances) - 8.0) < 4.0 * np.sqrt(16.0 / 10)


def test_moments_and_gyroscope_are_the_inertia_tensor_along_its_axes() -> None:
    """Of a body whose tensor along the gyroscope's axes has products of inertia."""
    tensor = np.array([[1.0, 0.2, -0.1], [0.2, 1.6, 0.15], [-0.1, 0.15, 2.2]])
    body, axes = rigid.Body.from_tensor(tensor)
    rates = rigid.simulate(body, START, t=T, frame=axes, method="taylor16").omega
    free = ("I1", "I2", "omega", "sensor")
    # Of free rotation one moment must be known: the largest.
    guess = rigid.Body((1.0, 1.6, body.moments[2]))
    found = rigid.fit(guess, T, omega=rates, sigma=1e-3, free=free)
    assert found.success
    along = found.sensor.T @ np.diag(found.scene.body.moments) @ found.sensor
    assert np.allclose(along, tensor, rtol=0.0, atol=1e-6)


def test_a_fit_is_drawn_saved_and_read_by_a_person(tmp_path: Path) -> None:
    rates = measured(BODY, 0.01, 6)
    found = rigid.fit(BODY, T, omega=rates, sigma=0.01, free=("I2/I1", "damping3", "omega"))
    upper = found.plot()
    lower = upper.figure.axes[-1]
    drawn = [np.asarray(line.get_ydata()) for line in upper.lines]
    assert np.array_equal(drawn[0::2], rates.T)
    run = rigid.simulate(found.scene, found.omega, t=T, check=False)
    assert np.allclose(drawn[1::2], run.omega.T, rtol=0.0, atol=1e-9)
    # What the picture shows between both curves is the residual.
    left = [np.asarray(line.get_ydata()) for line in lower.lines]
    assert np.allclose(left, (run.omega - rates).T / 0.01, rtol=0.0, atol=1e-6)
    words = repr(found).splitlines()
    assert words[0].startswith("Fit of 150 samples: chi2 per degree of freedom = ")
    assert words[1].split()[0::2] == ["I2/I1", "±"]
    assert words[2].endswith("N m s")
    assert "<img" in found._repr_html_()
    with np.load(found.save(tmp_path / "fit.npz")) as file:
        assert file["covariance"].tolist() == found.covariance.tolist()
        assert np.array_equal(file["measured"], rates)
        assert file["names"].tolist() == list(found.names)
        assert json.loads(str(file["scene"])) == found.scene.to_dict()


def test_no_place_for_the_residuals() -> None:
    found = rigid.fit(BODY, T, omega=measured(BODY, 0.01, 6), sigma=0.01, free="omega")
    with pytest.raises(ValueError, match="ax: must be a subplot of its figure"):
        found.plot(found.plot().figure.add_axes((0.0, 0.0, 1.0, 1.0)))


def test_damping_is_the_damping_of_all_axes() -> None:
    scene = rigid.FreeBody(BODY, damping=(0.01, 0.02, 0.03))
    rates = measured(scene, 0.0, 0, method="taylor16")
    found = rigid.fit(rigid.FreeBody(BODY), T, omega=rates, sigma=1e-3, free="damping", start=START)
    assert found.names == ("damping1", "damping2", "damping3")
    assert np.allclose(found.values, [0.01, 0.02, 0.03], rtol=0, atol=1e-8)


def test_a_sigma_for_each_time_and_with_a_unit() -> None:
    pint = pytest.importorskip("pint")
    degrees = pint.UnitRegistry().Quantity(0.01, "rad/s").to("deg/s")
    rates = measured(BODY, 0.01, 6)
    one, each, with_unit = (
        rigid.fit(BODY, T, omega=rates, sigma=sigma, free=RATIOS)
        for sigma in (0.01, np.full((150, 1), 0.01), degrees)
    )
    assert each.values.tolist() == one.values.tolist()
    assert np.allclose(with_unit.std, one.std, rtol=1e-6)


def test_progress_counts_measurements_and_what_its_user_raises_ends_a_fit() -> None:
    """Numbers of the fit that overflow are refused; numbers and errors of the user are its own."""
    told: list[rigid.Progress] = []

    def count(progress: rigid.Progress) -> None:
        told.append(progress)
        assert np.divide(progress.done, 0.0) == np.inf

    given: Any = {"omega": measured(BODY, 0.01, 6), "sigma": 0.01, "free": RATIOS}
    with np.errstate(divide="ignore"):
        rigid.fit(BODY, T, **given, progress=count)
    done = [one.done for one in told]
    assert done == sorted(done)
    assert done[-1] == told[-1].total == 150
    for error in (KeyboardInterrupt, FloatingPointError, OverflowError):

        def fails(_: rigid.Progress, error: type[BaseException] = error) -> None:
            raise error("own")

        with pytest.raises(error, match="own"):
            rigid.fit(BODY, T, **given, progress=fails)


def test_a_sigma_with_a_unit() -> None:
    pint = pytest.importorskip("pint")
    sigma = pint.UnitRegistry().Quantity(0.01, "rad/s").to("deg/s")
    rates, free = measured(BODY, 0.01, 6), ("I2/I1", "I3/I1", "omega")
    with_unit = rigid.fit(BODY, T, omega=rates, sigma=sigma, free=free)
    plain = rigid.fit(BODY, T, omega=rates, sigma=0.01, free=free)
    assert np.allclose(with_unit.std, plain.std, rtol=1e-6)


# Sums of squares inside a box: the minimum, and what an iteration says that it left


#: What the residuals tell to within these is looked for.
SIZES = np.full(2, 100.0)
EVERYWHERE = np.full(2, -np.inf), np.full(2, np.inf)


def valley(x: Floats) -> Floats:
    """Rosenbrock's curved valley, 1000 times as narrow as it is long."""
    return np.array([1000.0 * (x[1] - x[0] ** 2), 1.0 - x[0]])


def slopes_of_valley(x: Floats) -> Floats:
    return np.array([[-2000.0 * x[0], 1000.0], [-1.0, 0.0]])


def test_a_curved_valley_is_followed_to_its_end() -> None:
    first = np.array([-1.2, 1.0])
    found = minimum(valley, slopes_of_valley, first, EVERYWHERE, SIZES, gain=1e-20, most=60)
    assert found.gain <= 1e-20
    # Across the valley a residual of 1e-10 is 1e-13; along it, 1e-10.
    assert np.allclose(found.x, 1.0, rtol=0.0, atol=3e-10)
    # Steps that bend with the valley are longer: straight ones of the same method take 190.
    straight = least_squares(valley, first, slopes_of_valley, method="lm", xtol=1e-12)
    assert straight.njev > 3 * 60


def test_a_minimum_at_the_edge_of_the_box_is_that_of_scipy() -> None:
    rng = np.random.default_rng(0)
    for _ in range(20):
        matrix, right = rng.normal(size=(12, 4)), rng.normal(size=12)
        box = np.full(4, -0.1), np.full(4, 0.1)
        sizes = 10.0 ** rng.uniform(2.0, 4.0, 4)

        def residuals(x: Floats, matrix: Floats = matrix, right: Floats = right) -> Floats:
            off: Floats = matrix @ x - right
            return off

        def jacobian(_: Floats, matrix: Floats = matrix) -> Floats:
            return matrix

        found = minimum(residuals, jacobian, np.zeros(4), box, sizes, gain=1e-20, most=60)
        truth = lsq_linear(matrix, right, box, tol=1e-14)
        # lsq_linear stops inside its box by the root of its tolerance.
        assert np.allclose(found.x, truth.x, rtol=0.0, atol=1e-6)
        assert np.all(np.abs(found.x) <= 0.1)
        assert found.squares <= 2.0 * truth.cost * (1.0 + 1e-12)


@pytest.mark.parametrize("most", [1, 2])
def test_what_is_left_is_what_a_whole_step_gains(most: int) -> None:
    # For a linear model a straight step ends at the minimum: what is left is exact.
    matrix, right = np.array([[3.0, 1.0], [0.0, 2.0], [1.0, 0.0]]), np.array([1.0, 2.0, 3.0])
    found = minimum(
        lambda x: matrix @ x - right,
        lambda _: matrix,
        np.array([5.0, -7.0]),
        EVERYWHERE,
        SIZES,
        gain=1e-30,
        most=most,
    )
    least = np.linalg.lstsq(matrix, right)[1][0]
    assert found.gain == pytest.approx(found.squares - least, rel=1e-9)


def test_no_coordinate_is_free_in_a_corner() -> None:
    box = np.zeros(2), np.full(2, np.inf)
    found = minimum(
        lambda x: x + 1.0, lambda _: np.eye(2), np.ones(2), box, SIZES, gain=1e-12, most=40
    )
    assert found.x.tolist() == [0.0, 0.0]
    assert found.gain == 0.0


def test_what_the_residuals_do_not_tell_to_within_its_size_is_left() -> None:
    matrix = np.diag([100.0, 0.1])
    found = minimum(
        lambda x: matrix @ x - [100.0, 0.1],
        lambda _: matrix,
        np.zeros(2),
        EVERYWHERE,
        np.ones(2),
        gain=1e-12,
        most=40,
    )
    assert found.x[0] == pytest.approx(1.0, rel=1e-7)
    assert found.gain < 1e-12 < found.squares
