"""The bounds of the parameters: at each of them there is a rod, a little beyond there is none."""

import numpy as np
import pytest

from vibrissa import Mounting
from vibrissa.errors import VibrissaError
from vibrissa.scanning.response_over_eta import check_range
from vibrissa.sensor import Whisker
from vibrissa.sensor.identification.derivatives import moved, scale_of
from vibrissa.sensor.identification.parameters import parameters_of, ranges_of
from vibrissa.sensor.tolerances import TOLERABLE

WHISKERS = [
    Whisker(theta=2.0, eta=0.85),
    Whisker(
        theta=1.5,
        eta=0.7,
        mounting=Mounting(clamp_angle=0.2, clamp_compliance=0.02, stage_angle=-0.1),
    ),
]


def with_change(given, **sizes):
    return moved(given, dict.fromkeys(TOLERABLE, 0.0) | sizes)


@pytest.mark.parametrize("given", WHISKERS, ids=["ideal", "mounted"])
def test_at_each_bound_there_is_a_rod_whose_height_is_allowed(given):
    for name, one in ranges_of(given).items():
        assert one.low <= 0.0 < one.high, name
        for size in (one.low, one.high):
            if np.isfinite(size) and name != "length":
                rod = with_change(given, **{name: size})
                check_range(rod, rod.eta, rod.eta)
                assert scale_of(dict.fromkeys(TOLERABLE, 0.0) | {name: size}) > 0.0


@pytest.mark.parametrize("given", WHISKERS, ids=["ideal", "mounted"])
def test_beyond_the_bounds_of_the_height_the_taper_and_the_clamp_nothing_can_be_solved(given):
    ranges = ranges_of(given)
    for name, size in (
        ("theta", ranges["theta"].low - 1e-6),
        ("theta", ranges["theta"].high + 1e-6),
        ("eta", ranges["eta"].low - 1e-6),
        ("eta", ranges["eta"].high + 1e-6),
        ("clamp_compliance", ranges["clamp_compliance"].low - 1e-6),
    ):
        with pytest.raises(VibrissaError):
            rod = with_change(given, **{name: size})
            check_range(rod, rod.eta, rod.eta)
            rod.response  # noqa: B018


def test_every_step_of_a_difference_quotient_stays_within_the_bounds_or_at_them():
    for given in WHISKERS:
        for one in parameters_of({}, frozenset(), np.ones(3), given):
            assert one.low <= one.step <= one.high, one.name


def test_without_a_rod_nothing_is_fitted_and_nothing_bounded():
    assert ranges_of(None) == {}
    assert all(np.isinf(one.high) for one in parameters_of({}, frozenset(), np.ones(3)))
