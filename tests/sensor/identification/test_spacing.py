"""Friction from the spacing of slips: each law's relation, against scans and the exact onset."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from steel import recording_of
from vibrissa.sensor import surfaces
from vibrissa.sensor.identification.calibration import known_setup
from vibrissa.sensor.identification.friction import PeriodStatus, find_periods
from vibrissa.sensor.identification.reading.spacing import spacing
from vibrissa.sensor.identification.recording import Method
from vibrissa.sensor.response.branch import respond
from vibrissa.sensor.simulation.scanning import path, simulate
from vibrissa.sensor.simulation.slips import SlipLaw

RESPONSE = respond(2.0, 0.85)
QUIET = np.array([1e-5, 1e-5, 1e-5])


def travels(law, ratio, mu0, turns=("0.2",), step="0.00001"):
    """Travel, onset and directions before and after of each whole period, from a fine scan."""
    result = simulate(RESPONSE, surfaces.constant(mu0), path(step, turns), law, ratio)
    begins = np.flatnonzero(np.diff(result.period)) + 1
    first, last = begins[:-1], begins[1:] - 1
    moves = np.sign(np.diff(result.clamp))
    travel = result.clamp[last] - result.clamp[first]
    return travel, result.x0[last], moves[first - 1], moves[last]


@pytest.mark.parametrize("law", [SlipLaw.FREE, SlipLaw.KINETIC])
@pytest.mark.parametrize("turns", [("0.2",), ("0.1", "0.01")])
def test_onset_is_the_one_of_a_scan(law, turns):
    relation = spacing(RESPONSE, law, 0.7)
    for mu0 in (0.1, 0.3, 0.45):
        travel, onset, before, after = travels(law, 0.7, mu0, turns)
        assert (before != after).sum() == len(turns) - 1
        sure = ~relation.gives_bounds(before, after)
        # Pulled on and on, two frictions may have the same travel.
        assert (sure == ((law is SlipLaw.FREE) | (before > 0.0) | (after > 0.0))).all()
        travel, onset, before, after = (v[sure] for v in (travel, onset, before, after))
        found = relation.onset(travel[:, None], before, after)[:, 0]
        # To within the step: where the rod is pulled friction grows fast with it.
        assert found == pytest.approx(onset, abs=4e-5)


@pytest.mark.parametrize("mu0", [0.1, 0.3, 0.45])
def test_onset_is_the_exact_one_of_the_curve(mu0):
    exact, rest = (float(RESPONSE.curve.onset(value)) for value in (mu0, 0.7 * mu0))
    relation = spacing(RESPONSE, SlipLaw.KINETIC, 0.7)
    found = relation.onset(np.array([[exact - rest]]), np.ones(1), np.ones(1))
    assert found[0, 0] == pytest.approx(exact, abs=1e-7)


@pytest.mark.slow
@given(st.floats(0.05, 0.47), st.floats(0.1, 0.95), st.sampled_from(SlipLaw))
def test_without_a_law_the_bound_holds_for_each(mu0, ratio, law):
    travel, _, before, after = travels(law, ratio, mu0, step="0.0001")
    onset = spacing(RESPONSE, None).onset(travel[:, None], before, after)
    assert (RESPONSE.demand(np.maximum(onset, 0.0)) <= mu0 + 1e-9).all()


def test_travel_beyond_that_of_the_lock_is_no_onset_of_this_rod():
    relation = spacing(RESPONSE, SlipLaw.FREE)
    onset = relation.onset(np.array([[0.2, -0.1]]), np.ones(1), np.ones(1))[0]
    assert onset[0] > RESPONSE.x0_lock and onset[1] < 0.0


@pytest.mark.parametrize("ratio", [None, 0.0, 1.0])
def test_kinetic_slips_need_their_ratio(ratio):
    with pytest.raises(ValueError, match="kinetic ratio"):
        spacing(RESPONSE, SlipLaw.KINETIC, ratio)


@pytest.mark.parametrize("law", [SlipLaw.KINETIC, SlipLaw.ENERGY])
def test_taken_for_another_law_the_spacing_is_wrong_and_without_one_it_is_a_bound(law):
    surface = surfaces.random(2, 0.3, 0.04, 0.02)
    truth = simulate(RESPONSE, surface, path("0.0005", ["0.5"]), law, 0.8)
    recording = recording_of(truth.clamp, truth.reactions)
    setup = known_setup(RESPONSE)
    bound = find_periods(setup, recording, QUIET, method=Method.SPACING)
    unsure = bound.status == PeriodStatus.UNSURE
    assert unsure.sum() >= len(unsure) - 2 and np.isnan(bound.mu0).all()
    mu0 = truth.mu0[bound.last]
    assert (bound.low < mu0)[unsure].all() and (mu0 < bound.high)[unsure].all()
    wrong = find_periods(setup, recording, QUIET, method=Method.SPACING, law="free")
    assert np.mean((wrong.low < mu0) & (mu0 < wrong.high)) < 0.1
