"""Means of normal numbers within bounds, beside integrals over them."""

import numpy as np
import pytest

from vibrissa.sensor.identification.bounded import mean_within

MEAN = np.array([-0.4, 0.3])
COVARIANCE = np.array([[1.0, 0.6], [0.6, 2.0]])
FREE = np.array([np.inf, np.inf])


def integrated(low, high):
    """The mean of the two numbers within bounds, by the midpoint rule."""
    spread = 8.0 * np.sqrt(np.diag(COVARIANCE))
    edges = np.linspace(np.maximum(MEAN - spread, low), np.minimum(MEAN + spread, high), 601)
    x, y = (0.5 * (edges[1:] + edges[:-1])).T
    places = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1)
    off = places - MEAN
    weight = np.exp(-0.5 * ((off @ np.linalg.inv(COVARIANCE)) * off).sum(axis=-1))
    return (weight[..., None] * places).sum(axis=(0, 1)) / weight.sum()


@pytest.mark.parametrize(
    ("low", "high", "error"),
    [
        ([0.0, -np.inf], FREE, 1e-4),
        ([-np.inf, 2.0], FREE, 1e-4),
        (-FREE, [np.inf, -1.0], 1e-4),
        # With two bounds the numbers are not normal after the first cut.
        ([0.0, -np.inf], [np.inf, 0.5], 0.03),
        ([0.0, 0.0], FREE, 0.03),
    ],
)
def test_means_are_those_of_an_integral(low, high, error):
    low, high = np.asarray(low), np.asarray(high)
    within = mean_within(MEAN, COVARIANCE, low, high)
    assert within == pytest.approx(integrated(low, high), abs=error)
    assert np.abs(within - MEAN).min() > 0.1


def test_a_number_that_is_mirrored_at_its_mean():
    within = mean_within(np.zeros(1), np.eye(1), np.zeros(1), np.full(1, np.inf))
    assert within == pytest.approx(np.sqrt(2.0 / np.pi), rel=1e-12)


@pytest.mark.parametrize("far", [20.0, 1e3, 1e6])
def test_bounds_far_away(far):
    mean, low = np.array([far, 0.0]), np.array([0.0, -np.inf])
    # No likely value is cut off.
    assert mean_within(mean, COVARIANCE, low, FREE) == pytest.approx(mean, abs=1e-12)
    # All are: the first number is as near to its bound as it can be, and the other one follows.
    within = mean_within(-mean, COVARIANCE, low, FREE)
    assert 0.9 / far < within[0] < 1.1 / far
    assert within[1] == pytest.approx(0.6 * far, rel=0.01)
