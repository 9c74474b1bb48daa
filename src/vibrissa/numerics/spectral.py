"""Polynomial collocation on [0, 1]: Gauss–Legendre along the rod, Chebyshev along a curve."""

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.polynomial import chebyshev, legendre

from vibrissa.numerics.arrays import FloatArray, IntArray
from vibrissa.numerics.batch import slices

# Number of positions at which series are evaluated together; their arrays fit into the cache.
PLACES_AT_ONCE = 2048
# Distance from the real interval [-1, 1] up to which a root counts as lying on it.
ROOT_TOLERANCE = 1e-8


class GaussRule(NamedTuple):
    """Gauss–Legendre nodes on [0, 1], and operations on values at the nodes.

    Attributes
    ----------
    weights : ndarray, shape (n,)
        Quadrature weights of ∫₀¹.
    from_start, to_end : ndarray, shape (n, n)
        Map values at the nodes to the integrals ∫₀^τ and ∫_τ¹ at each node τ.
    to_coefficients : ndarray, shape (n, n)
        Maps values at the nodes to Legendre coefficients.
    """

    nodes: FloatArray
    weights: FloatArray
    from_start: FloatArray
    to_end: FloatArray
    to_coefficients: FloatArray


@lru_cache
def gauss_rule(n: int) -> GaussRule:
    """Gauss–Legendre rule with `n` nodes on [0, 1].

    Parameters
    ----------
    n : int
        Number of nodes, at least 1.
    """
    t, _ = legendre.leggauss(n)
    vandermonde = legendre.legvander(t, n)
    degree = np.arange(n)
    # leggauss loses three digits in the weights next to the ends; the Christoffel sum does not.
    w = 1.0 / (vandermonde[:, :n] ** 2 @ (degree + 0.5))
    to_coefficients = (degree + 0.5)[:, None] * (vandermonde[:, :n] * w[:, None]).T
    nodes = 0.5 * (t + 1.0)
    from_start = legendre_series(n, nodes)[1] @ to_coefficients
    weights = 0.5 * w
    rule = (nodes, weights, from_start, weights - from_start, to_coefficients)
    return GaussRule(*map(_frozen, rule))


def legendre_series(n: int, tau: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Evaluate `n` ≥ 1 Legendre polynomials on [0, 1] at `tau`, and their integrals from 0.

    Both results have the shape tau.shape + (n,).
    """
    # As sums of Chebyshev polynomials: as fast as scipy.special, which takes a third of a second to
    # load, and as exact.
    polynomials = np.moveaxis(chebyshev_polynomials(2.0 * tau - 1.0, n + 1), 0, -1)
    vandermonde = polynomials @ legendre_to_chebyshev(n + 1)
    degree = np.arange(1, n)
    integrals = np.empty((*tau.shape, n))
    integrals[..., 0] = tau
    integrals[..., 1:] = (vandermonde[..., 2:] - vandermonde[..., : n - 1]) / (4 * degree + 2)
    return np.asarray(vandermonde[..., :n]), integrals


@lru_cache
def legendre_to_chebyshev(k: int) -> FloatArray:
    """Matrix from k ≥ 2 Legendre coefficients on [-1, 1] to the Chebyshev coefficients.

    By G. Szegő, Orthogonal Polynomials, 1939, (4.9.3): P_n(cos t) = Σ a_i·a_(n−i)·cos((n − 2i)·t),
    with the sum over i from 0 to n and a_i = (1/2)·(3/4)···((2i−1)/(2i)).
    """
    share = np.cumprod(np.append(1.0, 1.0 - 0.5 / np.arange(1, k)))
    matrix = np.zeros((k, k))
    for degree in range(k):
        i = np.arange(degree + 1)
        np.add.at(matrix[:, degree], np.abs(degree - 2 * i), share[i] * share[degree - i])
    return _frozen(matrix)


@lru_cache
def chebyshev_nodes(k: int) -> FloatArray:
    """Chebyshev points of the second kind on [0, 1], increasing, ends included; k ≥ 2.

    The points for `k` are every second one of the points for 2·k − 1.
    """
    return _frozen(0.5 * (1.0 - np.cos(np.pi * np.arange(k) / (k - 1))))


@lru_cache
def chebyshev_transform(k: int) -> FloatArray:
    """Matrix from values at `chebyshev_nodes(k)` to the k Chebyshev coefficients on [0, 1]."""
    # T_n at the nodes by its definition: recurrence from rounded nodes would lose a factor n².
    index = np.arange(k)
    polynomials = (-1.0) ** index[:, None] * np.cos(np.pi * np.outer(index, index) / (k - 1))
    # Discrete orthogonality with halved ends: the inverse in closed form, free of rounding growth.
    half = np.ones(k)
    half[[0, -1]] = 0.5
    return _frozen((2.0 / (k - 1)) * half[:, None] * polynomials * half)


@lru_cache
def chebyshev_derivative(k: int) -> FloatArray:
    """Matrix from k ≥ 2 Chebyshev coefficients on [-1, 1] to those of the derivative."""
    matrix = np.zeros((k, k))
    matrix[:-1] = chebyshev.chebder(np.eye(k))
    return _frozen(matrix)


def interpolation(count: int, position: FloatArray) -> FloatArray:
    """Matrix from values at `count` Chebyshev points on [0, 1] to values at `position`."""
    polynomials = chebyshev_polynomials(2.0 * position - 1.0, count)
    return np.asarray(polynomials.T @ chebyshev_transform(count))


@lru_cache
def chebyshev_interpolation(count: int, other: int) -> FloatArray:
    """Matrix from values at `count` Chebyshev points on [0, 1] to values at `other` of them.

    The values at both ends stay exactly the same.
    """
    matrix = interpolation(count, chebyshev_nodes(other))
    matrix[[0, -1]] = np.eye(count)[[0, -1]]
    return _frozen(matrix)


def chebyshev_roots(coefficients: FloatArray) -> FloatArray:
    """Find the roots of a Chebyshev series in [-1, 1].

    Returns
    -------
    ndarray
        Roots, increasing, mapped from [-1, 1] to [0, 1].
    """
    series = np.trim_zeros(coefficients, "b")
    # No Chebyshev polynomial exceeds 1: a constant term larger than all others excludes roots.
    if len(series) < 2 or np.abs(series[0]) > np.abs(series[1:]).sum():
        return np.empty(0)
    roots = chebyshev.chebroots(series)
    real = np.sort(roots.real[np.abs(roots.imag) < ROOT_TOLERANCE])
    real = real[np.abs(real) < 1.0 + ROOT_TOLERANCE]
    return np.asarray(np.clip(0.5 * (real + 1.0), 0.0, 1.0))


def chebyshev_series(coefficients: FloatArray, which: IntArray, position: FloatArray) -> FloatArray:
    """Evaluate one group of Chebyshev series at each position.

    Parameters
    ----------
    coefficients : ndarray, shape (n, v, k)
        Coefficients of `v` series in each of `n` groups; k is at least 2.
    which : ndarray of int, shape (m,)
        Group to evaluate at each position.
    position : ndarray, shape (m,)
        Positions in [-1, 1].

    Returns
    -------
    ndarray, shape (m, v)
        Values. No row depends on the other positions, not even by rounding.
    """
    x = np.clip(position, -1.0, 1.0)
    values = np.empty((len(x), coefficients.shape[1]))
    for some in slices(len(x), PLACES_AT_ONCE):
        # Contiguous rows, as for a single position, so that sums are taken in the same order.
        polynomials = np.ascontiguousarray(chebyshev_polynomials(x[some], coefficients.shape[2]).T)
        values[some] = np.matvec(coefficients[which[some]], polynomials)
    return values


def chebyshev_polynomials(x: FloatArray, count: int) -> FloatArray:
    """Evaluate the first `count` ≥ 2 Chebyshev polynomials at x, shape (count, *x.shape).

    The number of known polynomials is doubled by T_(m+n) = 2·T_m·T_n − T_(m−n): a few operations on
    arrays, where the recurrence over n needs `count` of them.
    """
    values = np.empty((count, *x.shape))
    values[0], values[1] = 1.0, x
    known = 1  # highest degree so far
    while known < count - 1:
        more = min(known, count - 1 - known)
        lower = values[known - more : known][::-1]
        values[known + 1 : known + more + 1] = 2.0 * values[known] * values[1 : more + 1] - lower
        known += more
    return values


def _frozen(array: FloatArray) -> FloatArray:
    """Make a cached array read-only, as all callers share it."""
    array.flags.writeable = False
    return array
