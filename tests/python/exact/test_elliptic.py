"""Elliptic integrals and functions, against printed tables and identities."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.special import ellipj, ellipk, elliprc, elliprd, elliprf, elliprj

from physics import ROUNDOFF
from rigid import exact

# Elliptic functions

POSITIVE = 10.0 ** np.random.default_rng(1).uniform(-2.0, 2.0, (4, 200))


@pytest.mark.parametrize(
    ("ours", "theirs", "count"),
    [
        (exact.carlson_rf, elliprf, 3),
        (exact.carlson_rc, elliprc, 2),
        (exact.carlson_rd, elliprd, 3),
        (exact.carlson_rj, elliprj, 4),
    ],
)
def test_carlson_integrals(
    ours: Callable[..., Any], theirs: Callable[..., Any], count: int
) -> None:
    arguments = POSITIVE[:count]
    # Both are within some ulp of the truth, SciPy's third kind only for arguments of like size.
    np.testing.assert_allclose(ours(*arguments), theirs(*arguments), rtol=4e-15)
    assert np.shape(ours(*arguments[:, 0])) == ()
    assert ours(arguments[0][:, None], *arguments[1:, :1, None]).shape == (200, 1)
    zero = (0.0, *arguments[1:, 0])
    assert ours(*zero) == pytest.approx(theirs(*zero), rel=4e-15)


def test_jacobi_functions() -> None:
    u, mc = np.linspace(-20.0, 20.0, 101)[:, None], np.array([0.0, 1e-3, 0.3, 0.9, 1.0])
    found = exact.jacobi(u, mc)
    for mine, theirs in zip(found, ellipj(u, 1.0 - mc)[:3], strict=True):
        assert mine.shape == (101, 5)
        # SciPy rounds 1 - mc, which counts near mc = 0, and the argument u twenty times.
        np.testing.assert_allclose(mine, theirs, atol=1e-12)
    sn, cn, dn = exact.jacobi(5.0, mc=0.0)
    assert sn == pytest.approx(np.tanh(5.0), rel=4 * ROUNDOFF)
    assert cn == dn == pytest.approx(1.0 / np.cosh(5.0), rel=16 * ROUNDOFF)


@pytest.mark.parametrize("u", [1000.0, -1e12, np.nextafter(2.0**50, 0.0)])
def test_jacobi_functions_of_the_parameter_zero_are_sine_and_cosine(u: float) -> None:
    sn, cn, dn = exact.jacobi(u, mc=1.0)
    np.testing.assert_allclose([sn, cn], [np.sin(u), np.cos(u)], rtol=4 * ROUNDOFF)
    assert dn == 1.0


def test_carlson_integrals_of_the_largest_arguments() -> None:
    """`R_D(x, x, x) = R_J(x, x, x, x) = x^(-3/2)`."""
    x = 1e200
    for found in (exact.carlson_rd(x, x, x), exact.carlson_rj(x, x, x, x)):
        assert found == pytest.approx(1e-300, rel=16 * ROUNDOFF)


def test_the_mean_is_gauss_s() -> None:
    # Gauss, 1799: 1 / agm(1, sqrt 2) = 0.8346268416740731...
    assert 1.0 / exact.agm(1.0, np.sqrt(2.0)) == pytest.approx(0.8346268416740731, rel=4 * ROUNDOFF)
    assert exact.agm([1.0, 4.0], [[1.0], [4.0]]).shape == (2, 2)
    assert exact.agm(3.0, 3.0) == 3.0
    mc = np.array([1e-6, 0.5, 1.0])
    np.testing.assert_allclose(
        np.pi / 2 / exact.agm(1.0, np.sqrt(mc)), ellipk(1.0 - mc), rtol=1e-10
    )
