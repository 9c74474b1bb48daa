"""Paths: where they lead, and how they are cut. Ends beside those of the explorer's solver.

That one is written in another language and shares no code with this one.
"""

import numpy as np
import pytest

from vibrissa import Mounting, solve_curve, solve_onset, solve_state
from vibrissa.outcomes import End

LEANS = 0.4


@pytest.mark.slow
@pytest.mark.parametrize(
    ("gap", "mu_lock", "x0_end"),
    [
        (0.0410609940, 0.5688906945761201, 0.6888932218646543),
        (0.0210609940, 0.5123096209987621, 0.6157274323277908),
        (0.0059999940, 0.46669131895846655, 0.5529998546504044),
        pytest.param(
            *(0.0010609940, 0.4509298254410438, 0.5306063386667189), marks=pytest.mark.nightly
        ),
    ],
)
def test_a_rod_that_leans_forward_and_nearly_reaches_the_surface(gap, mu_lock, x0_end):
    """Its force grows from nearly nothing within a displacement of about the gap squared."""
    eta = np.cos(LEANS) - gap
    curve = solve_curve(1.0, round(eta, 6), mounting=Mounting(clamp_angle=-LEANS), section="planar")
    assert curve.end is End.SNAPS
    assert (curve.mu_lock, curve.x0_end) == pytest.approx((mu_lock, x0_end), abs=1e-10)


@pytest.mark.parametrize(
    ("theta", "eta", "mounting", "mu_lock", "x0_end"),
    [
        # x0 turns back in a kink: where the rod has rolled off the surface again.
        (
            3.2234,
            0.3543,
            Mounting(clamp_angle=0.1332, clamp_compliance=0.17, stage_angle=-0.0724),
            0.6166811472467423,
            1.3563050262056735,
        ),
        # s_c rises from 0.41 to 0.56 within little.
        (2.0, 0.191, Mounting(), 0.879666895507872, 1.15623),
        (2.0, 0.25, Mounting(), 0.8455819552013847, 1.28776),
    ],
)
def test_a_planar_rod_that_lies_down_is_followed_to_its_end(theta, eta, mounting, mu_lock, x0_end):
    curve = solve_curve(theta, eta, mounting=mounting, contact="line", section="planar")
    turns = mounting != Mounting()
    assert curve.end is (End.SNAPS if turns else End.OUT_OF_REACH)
    assert curve.mu_lock == pytest.approx(mu_lock, abs=1e-11)
    assert curve.x0_end == pytest.approx(x0_end, abs=1e-10 if turns else 1e-5)


def test_a_rod_that_a_stage_takes_off_the_surface_lifts_off():
    curve = solve_curve(2.0, 0.906149, mounting=Mounting(stage_angle=-0.3))
    assert curve.end is End.LIFTS_OFF and curve.status == "solved"
    last = curve.state(np.array([curve.x0_end]))
    assert last.reaction_fy[0] == pytest.approx(0.0, abs=1e-9) and last.reaction_fx[0] > 0.0
    # Whatever the friction, it has slipped back before.
    ends, states = curve.motion_end(np.array([1.0, 100.0]))
    assert ends.tolist() == [End.SLIPS_BACK] * 2
    assert (states.x0 < curve.x0_end).all()
    assert states.reaction_fx == pytest.approx(-np.array([1.0, 100.0]) * states.reaction_fy)


def test_a_tip_that_does_not_slip_back_between_two_rises_of_its_demand_slips_forward():
    mounting = Mounting(stage_angle=-0.1, clamp_angle=0.33, curvature=-0.37)
    curve = solve_curve(2.7, 0.93, mounting=mounting)
    assert curve.end is End.LIFTS_OFF and curve.mu_lock == np.inf
    demand = curve.mobilised_friction(np.linspace(0.0, 0.364367, 2001))
    assert 0.1369 < demand.max() < 0.137 and demand.min() < -0.15
    # Between the two rises the tip slips back, unless friction holds it.
    ends, states = curve.motion_end(np.array([0.138, 0.15]))
    assert ends.tolist() == [End.SLIPS_BACK] * 2
    assert states.mobilised_friction == pytest.approx([-0.138, -0.15])
    x0 = curve.onset([0.1365, 0.138, 0.15, 10.0])
    assert np.isnan(x0[1:3]).all() and x0[0] < 0.364367 < x0[3] < curve.x0_end
    assert curve.mobilised_friction(x0[[0, 3]]) == pytest.approx([0.1365, 10.0])
    onset = solve_onset(2.7, 0.15, 0.93, mounting=mounting)
    assert (onset.status, onset.end) == ("lock", "slips_back")
    assert "it slips back before -tan alpha reaches mu0" in onset.message
    assert float(onset.ended.x0) == states.x0[1]


def test_a_single_state_is_found_on_both_sides_of_a_kink_and_next_to_a_limit_point():
    curve = solve_curve(3.0, 0.85, contact="line", section="planar")
    kink = curve.pieces.last_x0[0]
    for x0 in (0.5 * kink, kink + 1e-6, 0.9 * curve.x0_end, curve.x0_end - 1e-6):
        state = solve_state(3.0, 0.85, curve.x1_init - x0, "line")
        known = curve.state(np.array([x0]))
        assert state.reaction_fx == pytest.approx(known.reaction_fx[0], abs=1e-7)
        assert state.s_c == pytest.approx(known.s_c[0], abs=1e-7)
