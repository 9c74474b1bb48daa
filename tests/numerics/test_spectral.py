"""Collocation matrices: exact for polynomials, accurate to rounding."""

import numpy as np
import pytest
from numpy.polynomial import Polynomial, chebyshev
from scipy.special import legendre_p_all

from vibrissa.numerics.spectral import (
    chebyshev_nodes,
    chebyshev_roots,
    chebyshev_series,
    chebyshev_transform,
    gauss_rule,
    legendre_series,
)


@pytest.mark.parametrize("n", [2, 5, 32, 72])
def test_integrals_of_polynomials_are_exact(n):
    rule = gauss_rule(n)
    poly = Polynomial(np.cos(np.arange(n)) / (1 + np.arange(n)))
    integral = poly.integ()
    values = poly(rule.nodes)
    total = integral(1.0) - integral(0.0)
    assert rule.weights @ values == pytest.approx(total, abs=1e-14)
    assert rule.from_start @ values == pytest.approx(integral(rule.nodes) - integral(0), abs=1e-14)
    assert rule.to_end @ values == pytest.approx(integral(1) - integral(rule.nodes), abs=1e-14)


@pytest.mark.parametrize("n", [24, 48, 108, 162])
def test_coefficients_and_values_are_inverse_to_rounding(n):
    rule = gauss_rule(n)
    values = np.cos(7 * rule.nodes)
    again = legendre_series(n, rule.nodes)[0] @ rule.to_coefficients @ values
    assert np.abs(again - values).max() < 3e-15 * n


@pytest.mark.parametrize("n", [1, 2, 24, 108])
def test_legendre_polynomials_are_those_of_scipy(n):
    tau = np.linspace(0.0, 1.0, 50).reshape(2, 25)
    values, _ = legendre_series(n, tau)
    expected = legendre_p_all(n - 1, 2.0 * tau - 1.0)[0]
    assert np.moveaxis(values, -1, 0) == pytest.approx(expected, rel=0.0, abs=2e-14)


@pytest.mark.parametrize("k", [2, 9, 17])
def test_chebyshev_points_are_nested(k):
    assert chebyshev_nodes(2 * k - 1)[::2] == pytest.approx(chebyshev_nodes(k), abs=1e-16)


@pytest.mark.parametrize("k", [2, 17, 129])
def test_chebyshev_transform_gives_the_coefficients_of_the_interpolant(k):
    coefficients = np.sin(1.0 + np.arange(k))
    values = chebyshev.chebval(2 * chebyshev_nodes(k) - 1, coefficients)
    assert chebyshev_transform(k) @ values == pytest.approx(coefficients, abs=1e-13)


def test_chebyshev_series_are_those_of_numpy_and_stand_alone():
    random = np.random.default_rng(2)
    coefficients = random.normal(size=(3, 2, 40))
    which = random.integers(0, 3, 600)
    x = np.append(random.uniform(-1.0, 1.0, 597), [-1.0, 0.0, 1.0])
    values = chebyshev_series(coefficients, which, x)
    for group in range(3):
        rows = which == group
        expected = chebyshev.chebval(x[rows], coefficients[group].T).T
        assert values[rows] == pytest.approx(expected, rel=0.0, abs=1e-12)
    for row in (0, 255, 256, 599):
        only = slice(row, row + 1)
        assert np.array_equal(chebyshev_series(coefficients, which[only], x[only]), values[only])


@pytest.mark.parametrize(
    ("roots", "found"),
    [([-0.5, 0.2], [0.25, 0.6]), ([0.3j, -0.3j], []), ([1.1, -0.4], [0.3]), ([1.0], [1.0])],
)
def test_roots_are_those_on_the_interval_up_to_rounding(roots, found):
    series = np.real(chebyshev.poly2cheb(np.poly(roots)[::-1]))
    assert chebyshev_roots(series) == pytest.approx(found, abs=1e-9)
