"""Heights of a surface whose slope is larger than its tolerance, and of one that is allowed."""

import numpy as np
import pytest

from vibrissa.sensor.identification.slope import Slope
from vibrissa.sensor.identification.unevenness import unevenness_of

PLACE = np.linspace(0.0, 0.6, 60)
ALLOWED = Slope(deviation=np.radians(0.5), length=0.05).heights(PLACE)
ERROR = np.full(60, 1e-3) ** 2


def drawn(generator, factor=1.0):
    """Estimated heights of a surface whose slopes are `factor` times as large as allowed."""
    surface = generator.multivariate_normal(np.zeros(60), ALLOWED + 1e-14 * np.eye(60))
    return factor * surface + np.sqrt(ERROR) * generator.normal(size=60)


def test_the_chance_of_allowed_heights_is_seldom_small():
    generator = np.random.default_rng(1)
    chances = [unevenness_of(drawn(generator), ALLOWED, np.diag(ERROR)).chance for _ in range(500)]
    # The sum of two tests is conservative where both find the same.
    assert 0.005 < np.mean(np.array(chances) < 0.05) < 0.08


def test_slopes_three_times_as_large_are_found_where_chi_squared_is_not_enough():
    generator = np.random.default_rng(2)
    found = [unevenness_of(drawn(generator, 3.0), ALLOWED, np.diag(ERROR)) for _ in range(100)]
    assert np.mean([one.chance < 1e-3 for one in found]) > 0.6


def test_heights_that_scatter_from_place_to_place_are_found():
    rough = 2.0 * np.sqrt(ERROR) * np.random.default_rng(3).normal(size=60)
    assert unevenness_of(rough, ALLOWED, np.diag(ERROR)).chance < 1e-3
    flat = unevenness_of(np.zeros(60), ALLOWED, np.diag(ERROR))
    assert flat.chance == pytest.approx(1.0) and flat.number == 60
