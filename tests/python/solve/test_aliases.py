"""Fits of few samples, across pauses and in a wrong unit of time: no alias passes for a success."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import pytest
from scipy import stats
from scipy.integrate import solve_ivp

import rigid
from fit_cases import judged_few
from physics import Floats
from rigid.solve import arcs
from rigid.solve.least_squares import descents

START = np.array([0.1, 1.0, 0.2])
GUESS = rigid.Body((1.0, 1.3, 2.1))
FREE = ("I2/I1", "I3/I1", "omega")
SIGMA = 0.01


def rates(t: Floats, moments: Floats, start: Floats) -> Floats:
    """Euler's equations by SciPy, to about 1e-9 after 60 s."""

    def change(_: float, w: Floats) -> Floats:
        slope: Floats = np.cross(moments * w, w) / moments
        return slope

    found = solve_ivp(change, (0.0, t[-1]), start, "DOP853", t_eval=t, rtol=1e-12, atol=1e-13)
    result: Floats = found.y.T
    return result


def fitted(t: Floats, seed: int, unit: float = 1.0) -> tuple[Any, Floats]:
    noise = SIGMA * np.random.default_rng([seed, len(t)]).normal(size=(len(t), 3))
    measured = rates(t, np.array([1.0, 1.5, 2.0]), START) + noise
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", rigid.FitWarning)
        return rigid.fit(GUESS, unit * t, omega=measured, sigma=SIGMA, free=FREE), measured


@pytest.mark.filterwarnings("ignore:the fit failed")
@pytest.mark.parametrize("number", [8, 13, 14, 48, 85])
def test_a_fit_of_few_samples_is_right_or_says_that_it_is_not(number: int) -> None:
    # A descent from the guess ended 70 to 970 std off the truth, with a possible chi².
    found = judged_few(number, seed=1)
    assert found.right if found.success else "phase between samples passes pi" in found.reason


def test_an_alias_meets_the_samples_as_well() -> None:
    t = np.linspace(0.0, 60.0, 4)
    found, measured = fitted(t, 0)
    assert not found.success
    assert "ambiguous: " in found.reason
    assert "3 of 3 gaps" in found.reason
    for values in (found.values, *found.others):
        predicted = rates(t, np.array([1.0, *values[:2]]), values[2:])
        chi2 = np.sum(np.square((predicted - measured) / SIGMA))
        assert chi2 < found.chi2 + arcs.overtaken(5, found.searched) + 1e-3
    # Far from each other: 20 standard deviations and more.
    assert np.all(np.abs(found.others - found.values).max(axis=1) > 0.01)


def test_few_samples_suffice_if_the_phase_between_them_stays_small() -> None:
    for seed in range(4):
        found, _ = fitted(np.linspace(0.0, 12.0, 7), seed)
        assert found.success
        assert found.others.shape == (0, 5)
        assert np.all(np.abs(found.values - [1.5, 2.0, *START]) < 5.0 * found.std)


def test_times_in_a_wrong_unit_are_no_success() -> None:
    # At I2/I1 = 1.336 chi² is 1.08 a degree of freedom, and was taken for a success.
    found, _ = fitted(np.linspace(0.0, 60.0, 100), 1, unit=60.0)
    assert not found.success
    assert "99 of 99 gaps" in found.reason


def test_a_pause_in_which_the_phase_is_lost_is_told() -> None:
    """Three seconds tell the moments to some 5 %, which is 30 rad of phase after ten minutes."""

    def around(pause: float) -> Floats:
        return np.append(np.arange(30) / 10.0, pause + np.arange(20) / 10.0)

    found, _ = fitted(around(600.0), 3)
    assert not found.success
    assert "passes pi in 1 of 49 gaps" in found.reason
    short, _ = fitted(around(20.0), 3)
    assert short.success
    assert np.all(np.abs(short.values - [1.5, 2.0, *START]) < 5.0 * short.std)


def test_the_work_of_a_fit_is_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(arcs, "_ALL_EVALUATIONS", 60)
    t = np.arange(100) / 10.0
    measured = np.random.default_rng(2).normal(size=(100, 3))
    with pytest.warns(rigid.FitWarning, match="the search ended after 60 runs with derivatives"):
        found = rigid.fit(GUESS, t, omega=measured, sigma=SIGMA, free=FREE)
    assert found.evaluations <= 60 + 50


def test_chi2_of_the_best_of_many_minima() -> None:
    for searched in (1, 30, 1000):
        beyond = stats.chi2.sf(arcs.largest_of(50, searched), 50)
        assert beyond < 1e-6 * searched
        assert stats.chi2.sf(arcs.overtaken(5, searched), 6) < 1e-6 / searched
    # Of noise in 30 numbers, the chance that a plane of 2 parameters away from the truth is nearer.
    # At the distance sqrt(D) a minimum is nearer by D most often: here once in 300 draws.
    rng, least = np.random.default_rng(3), 12.0
    noise = rng.normal(size=(200_000, 30))
    away = noise.copy()
    away[:, 0] -= np.sqrt(least)
    lower = np.sum(noise**2, axis=1) - np.sum(away[:, [0, *range(3, 30)]] ** 2, axis=1) > least
    assert 0.0 < lower.mean() < stats.chi2.sf(least, 3)


def test_descents_from_many_starts_end_in_the_minima() -> None:
    """Of (x² - 1)² + (y - 2)²: two, at the edge of the box."""

    def residuals(x: Floats) -> Floats:
        return np.stack([x[:, 0] ** 2 - 1.0, x[:, 1] - 2.0], axis=1)

    starts = np.random.default_rng(4).uniform(0.5, 1.0, (50, 2)) * [3.0, 1.0]
    starts[::2, 0] *= -1.0
    box = np.array([-5.0, -5.0]), np.array([5.0, 1.0])
    x, squares, normal = descents(residuals, starts, box, np.ones(2), rounds=20)
    assert np.allclose(np.abs(x), 1.0, atol=1e-4)
    assert (np.sign(x[:, 0]) == np.sign(starts[:, 0])).all()
    assert np.allclose(squares, 1.0, atol=1e-6)
    assert np.allclose(normal, np.diag([4.0, 1.0]), atol=1e-3)
