"""More recordings, and longer ones, of what tests/sensor and tests/scanning have of few."""

import numpy as np
import pytest
from scipy import stats

import profiles
from adjusted import carried
from recordings import goodness_of
from responses import respond
from steel import NOISE, identified
from vibrissa.scanning import surfaces
from vibrissa.sensor import Setup, scan


@pytest.mark.parametrize(("noise", "count"), [(NOISE, 25), (None, 12)])
def test_a_recording_of_the_rod_fits_as_often_as_it_says(noise, count):
    found = goodness_of(respond(2.0, 0.85), range(count), noise)
    assert all(each.fits for each in found)
    assert np.mean([each.ratio for each in found]) == pytest.approx(1.0, abs=0.02)
    if noise is not None:
        chances = [each.chance for each in found]
        assert stats.kstest(chances, "uniform").pvalue > 1e-3


def test_what_a_recording_does_not_tell_is_carried_into_the_intervals():
    scores, shares = zip(*carried(range(16)), strict=True)
    assert 0.6 < np.sqrt(np.mean(np.square(scores))) < 1.5
    assert min(shares) > 0.01


@pytest.mark.parametrize("name", profiles.OFF)
def test_a_set_up_that_is_off_by_its_tolerance_shifts_the_profile_by_its_deviation(name):
    for shift, deviation in profiles.shifts(name):
        assert shift == pytest.approx(deviation, rel=0.05, abs=2e-6)


def test_friction_is_read_until_the_rod_is_almost_upright():
    whisker = Setup.read(theta=2.0, eta=0.85, stage_angle="-0.1 rad").whisker
    table = scan(whisker, surfaces.constant(0.3), step="0.002", to=["1.49"]).to_pandas()
    found = identified(whisker, table, noise="1e-6, 1e-6, 1e-7", assume=False).periods
    slip = found.status == "slip"
    # As it rises the tip locks in the end.
    assert slip.sum() > 15 and (found.status[~slip] == "lock").all()
    assert found.mu0[slip] == pytest.approx(0.3, abs=0.006)
