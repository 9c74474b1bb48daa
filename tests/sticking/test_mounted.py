"""Sticking curves of rods in other mountings than the paper's, against independent methods."""

from functools import cache

import numpy as np
import pytest
from scipy.integrate import cumulative_simpson, quad, solve_ivp

from vibrissa import (
    Mounting,
    Status,
    friction_from_travel,
    solve_curve,
    solve_onset,
    solve_state,
    stick_slip,
)
from vibrissa.errors import ArgumentError
from vibrissa.mechanics.elastica import deformed_shape
from vibrissa.outcomes import Contact, RodSection
from vibrissa.sticking.solving.collocation import solve_curves

ALONE = {
    "clamp_angle": Mounting(clamp_angle=0.1),
    "leaning": Mounting(clamp_angle=-0.1),
    "clamp_compliance": Mounting(clamp_compliance=0.2),
    "curvature": Mounting(curvature=-0.2),
    "towards": Mounting(curvature=0.2),
    "polynomial": Mounting(curvature=(0.05, 0.1, -0.5)),
    "stage_angle": Mounting(stage_angle=0.1),
    "leaving": Mounting(stage_angle=-0.1),
}
TOGETHER = Mounting(
    clamp_angle=-0.05, clamp_compliance=0.1, curvature=(-0.1, -0.2), stage_angle=0.05
)
MOUNTINGS = ALONE | {"together": TOGETHER}


@cache
def curve(theta, eta, mounting, contact=Contact.POINT):
    return solve_curve(theta, eta, contact=contact, mounting=mounting)


def natural(mounting):
    return np.polynomial.Polynomial(mounting.coefficients)


def misses(found, state):
    """Integrate from the contact point to the clamp with DOP853; what the clamp misses."""
    mounting, kappa = found.mounting, natural(found.mounting)
    s_c = float(state.s_c)

    def derivative(s, unknowns):
        _, _, phi, m = unknowns
        d = 1 - (1 - 1 / found.theta) * s
        gradient = state.reaction_fx * np.sin(phi) - state.reaction_fy * np.cos(phi)
        return [np.cos(phi), np.sin(phi), kappa(s) + m / d**4, gradient]

    # The clamp moves along its stage, the contact point keeps its place.
    x = found.x1_init - state.x0 * np.cos(mounting.stage_angle) - (1 - s_c)
    y = found.eta - state.x0 * np.sin(mounting.stage_angle)
    start = [float(x), float(y), float(state.phi1), 0.0]
    end = solve_ivp(derivative, (s_c, 0.0), start, "DOP853", rtol=1e-13, atol=1e-13).y[:, -1]
    slope = np.pi / 2 + mounting.clamp_angle + mounting.clamp_compliance * end[3]
    return [end[0], end[1], end[2] - slope, end[3] - state.reaction_m]


@pytest.mark.slow
@pytest.mark.parametrize("name", MOUNTINGS)
@pytest.mark.parametrize("contact", Contact)
def test_an_integration_from_the_contact_meets_the_clamp(name, contact):
    found = curve(3.0, 0.8, MOUNTINGS[name], contact)
    assert found.pieces and found.residual < 1e-12
    pieces = found.pieces
    states = pieces.at(np.arange(len(pieces)), 0.3 * pieces.start + 0.7 * pieces.stop)
    for state in map(states.take, range(len(pieces))):
        assert misses(found, state) == pytest.approx([0.0] * 4, abs=5e-12)


def elastic_energy(found, x0):
    """Energy of rod and clamp, from the shape that the force gives."""
    s = np.linspace(0.0, 1.0, 801)
    state, (x1, y1) = found.state(x0), found.contact_point(x0)
    x, y, _ = deformed_shape(
        found.theta, state.f, state.alpha, x1, y1, s, float(state.s_c), found.mounting
    )
    x_c = x1 - (1 - state.s_c)
    moment = -state.reaction_fy * (x - x_c) + state.reaction_fx * (y - y1)
    moment[s > state.s_c] = 0.0
    density = 0.5 * moment**2 / (1 - (1 - 1 / found.theta) * s) ** 4
    spring = 0.5 * found.mounting.clamp_compliance * state.reaction_m**2
    return cumulative_simpson(density, x=s)[-1] + spring


@pytest.mark.parametrize("name", ["stage_angle", "leaving", "together"])
@pytest.mark.parametrize("contact", Contact)
def test_work_along_the_stage_is_the_gain_of_energy(name, contact):
    found = curve(2.0, 0.7, MOUNTINGS[name], contact)
    end = 0.9 * found.x0_lock
    direction = found.mounting.stage_angle

    def force(x0):
        state = found.state(x0)
        return -(state.reaction_fx * np.cos(direction) + state.reaction_fy * np.sin(direction))

    kinks = [x0 for x0 in found.pieces.first_x0[1:] if x0 < end]
    work = quad(force, 0.0, end, points=kinks or None, epsabs=1e-11)[0]
    gain = elastic_energy(found, end) - elastic_energy(found, 0.0)
    assert abs(work) > 1e-3
    assert gain == pytest.approx(work, abs=2e-8)


def test_a_state_does_not_know_by_which_stage_it_was_reached():
    found = curve(2.0, 0.8, TOGETHER)
    x1, y1 = found.contact_point(0.08)
    assert y1 == pytest.approx(0.8 - 0.08 * np.sin(0.05), abs=1e-15)
    here, there = solve_state(2.0, float(y1), float(x1), mounting=TOGETHER), found.state(0.08)
    assert here.reaction_fx == pytest.approx(there.reaction_fx, abs=1e-10)
    assert here.reaction_m == pytest.approx(there.reaction_m, abs=1e-10)
    assert here.stability == pytest.approx(there.stability, abs=1e-5)


@pytest.mark.slow
@pytest.mark.parametrize("contact", ["point", pytest.param("line", marks=pytest.mark.nightly)])
def test_stability_is_lost_where_the_branch_turns_back(contact):
    random = np.random.default_rng(3)
    count = 12
    theta, eta = random.uniform(1, 8, count), random.uniform(0.5, 0.95, count)
    mountings = [
        Mounting(clamp_angle=a, clamp_compliance=c, curvature=(k, -0.1), stage_angle=d)
        for a, c, k, d in random.uniform([-0.1, 0, -0.3, -0.1], [0.1, 0.3, 0, 0.1], (count, 4))
    ]
    kinks = 0
    for found in solve_curves(theta, eta, contact, mountings, RodSection.PLANAR):
        assert found.end == "snaps" and found.residual < 1e-12
        end = found.state(found.x0_end)
        kink = end.s_c > 1.0 - 1e-9 and abs(end.phi1) < 1e-9
        kinks += kink
        assert end.stability > 0.0 if kink else abs(end.stability) < 1e-5
    assert kinks <= (3 if contact is Contact.LINE else 0)


STRAIGHT = {
    "clamp_angle": Mounting(clamp_angle=0.1),
    "leaning": Mounting(clamp_angle=-0.1, stage_angle=0.05),
    "clamp_compliance": Mounting(clamp_angle=-0.05, clamp_compliance=0.3),
    "stage_angle": Mounting(stage_angle=-0.1),
}


@pytest.mark.parametrize("name", STRAIGHT)
@pytest.mark.parametrize("contact", Contact)
def test_a_straight_rod_swings_aside_on_the_axis_of_its_unloaded_clamp(name, contact):
    mounting = STRAIGHT[name]
    found = curve(3.0, 0.7, mounting, contact)
    assert (found.status, found.end) == ("solved", "swings_aside")
    x, y = found.contact_point(found.x0_end)
    x_c = x - (1 - found.state(found.x0_end).s_c)
    beta = mounting.clamp_angle
    assert x_c * np.cos(beta) + y * np.sin(beta) == pytest.approx(0.0, abs=1e-11)
    # Up to there it stays in its plane, and slips and locks as if it were held there.
    states = found.state(np.linspace(0.0, found.x0_end, 40))
    assert (states.stability_aside[:-1] > 0).all()
    planar = solve_curve(3.0, 0.7, contact=contact, mounting=mounting, section="planar")
    assert found.mu_lock == pytest.approx(planar.mu_lock, abs=1e-11)
    assert found.x0_lock < found.x0_end < planar.x0_end


def test_a_curved_rod_swings_aside_where_its_margin_vanishes():
    found = curve(3.0, 0.8, Mounting(curvature=(-0.1, -0.2)), Contact.LINE)
    assert found.end == "swings_aside"
    x, y = found.contact_point(found.x0_end)
    at_end = solve_state(3.0, float(y), float(x), "line", found.mounting)
    assert at_end.stability_aside == pytest.approx(0.0, abs=1e-10)
    # It leaves its plane before the contact point is on the axis.
    assert x - (1 - at_end.s_c) > 1e-3


def test_where_a_mounted_rod_goes_is_not_computed():
    onset = solve_onset(2.0, 0.8, 0.85, mounting=Mounting(clamp_angle=0.05))
    assert (onset.status, onset.end) == ("lock", "swings_aside")
    assert "buckles laterally at x0 = 0.4" in onset.message
    assert "in this mounting the motion beyond is not computed" in onset.message
    assert np.isnan(onset.trail.x0) and np.isfinite(onset.ended.x0)


def test_a_rod_curved_towards_the_surface_may_swing_before_it_locks():
    mounting = Mounting(clamp_angle=-0.48, curvature=(1.1, 1.1))
    found = curve(3.8, 0.79, mounting)
    planar = solve_curve(3.8, 0.79, mounting=mounting, section="planar")
    assert found.x0_lock == found.x0_end < planar.x0_lock
    assert found.mu_lock == pytest.approx(float(planar.mobilised_friction(found.x0_end)), rel=1e-9)
    # Still more, and it is not stable in its plane from the start.
    none = curve(2.3, 0.85, Mounting(clamp_angle=0.06, curvature=(1.13, 1.34)))
    assert none.status == "out_of_reach" and not none.pieces
    assert "the rod leaves its plane already at alpha = 0" in none.message


def test_the_ideal_mounting_is_the_paper_s_digit_by_digit():
    theta, eta = np.array([1.0, 2.0, 4.0]), np.array([0.85, 0.7, 0.85])
    odd = Mounting(clamp_angle=0.05, stage_angle=0.02)
    plain = solve_curves(theta, eta, Contact.LINE)
    # Whatever else is in the batch.
    mixed = solve_curves(
        np.repeat(theta, 2), np.repeat(eta, 2), Contact.LINE, [Mounting(), odd] * len(theta)
    )[::2]
    for a, b in zip(plain, mixed, strict=True):
        assert (a.mu_lock, a.x1_init, a.residual) == (b.mu_lock, b.x1_init, b.residual)
        for name, values in a.pieces.states.columns.items():
            assert np.array_equal(values, getattr(b.pieces.states, name), equal_nan=True)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("theta", "eta", "mounting", "said"),
    [
        (1, 0.98, Mounting(clamp_angle=0.3), "the rod springs to the other side"),
        (4, 0.95, Mounting(curvature=2.0), "the rod springs to the other side"),
        (1, 0.85, Mounting(clamp_angle=-1.2), "the rod does not press on the surface"),
        (2, 0.85, Mounting(curvature=-2.0), "the rod does not press on the surface"),
    ],
)
def test_a_branch_that_does_not_exist_is_a_status(theta, eta, mounting, said):
    found = solve_curve(theta, eta, mounting=mounting)
    assert found.status == "out_of_reach" and said in found.message
    onset = solve_onset(theta, 0.3, eta, mounting=mounting)
    assert onset.status == "out_of_reach" and onset.message == found.message
    state = solve_state(theta, eta, 0.1, mounting=mounting)
    assert state.status == "out_of_reach" and said in state.message


@pytest.mark.slow
def test_a_branch_ends_where_two_states_meet():
    # At the end of the branch the force needed changes like a square root.
    angles = np.linspace(0.0, 0.3, 31)
    mountings = [Mounting(clamp_angle=angle) for angle in angles]
    curves = solve_curves(np.ones(31), np.full(31, 0.98), Contact.POINT, mountings)
    exists = np.array([found.status == "solved" for found in curves])
    last = int(np.flatnonzero(exists)[-1])
    assert 5 < last < 30 and exists[: last + 1].all()
    force = np.array([-float(found.state(0.0).reaction_fy) for found in curves[: last + 1]])
    growth = np.diff(force)
    assert growth[-1] > 3 * growth[len(growth) // 2] > 0


@pytest.mark.slow
def test_a_rod_curved_towards_the_surface_may_not_lie_on_it():
    mounting = Mounting(curvature=0.1)
    # Neither may its tip come to lie level: the rod arches over the surface just before it.
    found = curve(4.0, 0.85, mounting, Contact.LINE)
    assert found.status == "out_of_reach" and "crosses the surface" in found.message
    assert not found.pieces.line.any()
    assert 0.0 < found.state(found.x0_end).phi1 < 1e-3
    # Where only the tip may touch, the arch passes through the surface from the same state on.
    through = curve(4.0, 0.85, mounting, Contact.POINT)
    assert through.status == "solved" and through.x0_touch == pytest.approx(found.x0_end, abs=1e-9)
    # Where it would lie there from the start, nothing is left.
    none = curve(3.0, 0.7, mounting, Contact.LINE)
    assert none.status == "out_of_reach" and not none.pieces


def test_each_cycle_of_an_oblique_stage_has_the_curve_of_its_height():
    found = curve(2.0, 0.85, Mounting(stage_angle=0.05))
    scan = stick_slip(found, 0.3, 0.005, 3)
    shapes = scan.shapes()
    assert shapes.residual.max() < 1e-11 and scan.message == ""
    assert scan.clamp == pytest.approx(0.005 * np.arange(len(scan.step)), abs=1e-15)
    begins = np.flatnonzero(scan.phase == "slip")
    assert len(begins) == 3 and scan.cycle[begins].tolist() == [1, 2, 3]
    assert scan.step[begins].tolist() == np.diff(begins, prepend=0).tolist()
    for begin, end in zip([0, *begins], [*begins, len(scan.step)], strict=True):
        # The tip keeps its place, on the surface, until it slips.
        assert np.ptp(scan.contact[begin:end]) < 1e-12
        assert shapes.y[begin:end, -1] == pytest.approx(0.85, abs=1e-9)
        own = curve(2.0, 0.85 - scan.clamp[begin] * np.sin(0.05), found.mounting)
        x0 = scan.clamp[begin:end] - scan.clamp[begin]
        assert scan.state.reaction_fx[begin:end] == pytest.approx(own.state(x0).reaction_fx)
        # It slips at the first step at which it has to.
        if end < len(scan.step):
            assert x0[-1] < own.onset(0.3) < x0[-1] + 0.005


@pytest.mark.slow
def test_cycles_of_an_oblique_stage_end_where_the_tip_does_not_slip_any_more():
    leaving = curve(2.0, 0.85, Mounting(stage_angle=-0.3))
    scan = stick_slip(leaving, 0.3, 0.01, 20)
    assert scan.cycle[-1] == 4 and scan.phase[-1] == "stick" and scan.status is Status.LOCK
    assert scan.outcome == "out_of_reach" and "to distances from 0.85 L to 1.0" in scan.message
    assert curve(2.0, 0.906149, leaving.mounting).mu_lock < 0.3
    scan = stick_slip(curve(2.0, 0.9, Mounting(stage_angle=-0.5)), 0.01, 0.25, 20)
    assert scan.outcome == "out_of_reach" and scan.slips == 0
    assert "to distances from 0.9 L to 1.01986 L, but its distance to" in scan.message


def test_shooting_knows_the_ideal_mounting_alone():
    with pytest.raises(ArgumentError, match="solves the ideal mounting of a solid rod alone"):
        solve_curve(2.0, 0.85, "shooting", 0.01, mounting=Mounting(clamp_angle=0.1))
    with pytest.raises(ArgumentError, match=r"mounting must be a Mounting, got 0\.1"):
        solve_curve(2.0, 0.85, mounting=0.1)


def test_a_curve_says_why_it_ends_where_its_tail_is_about_to_rise():
    """The shapes change their kind at the end itself: rounding decides what is seen there."""
    mounting = Mounting(
        clamp_angle=-0.1707383241752089,
        clamp_compliance=0.4427402635327662,
        curvature=(0.01570343656754858, 0.23792268295927077),
        stage_angle=-0.08968922109020497,
    )
    found = curve(5.95019845118145, 0.8393079164502655, mounting, Contact.LINE)
    assert found.status == "out_of_reach" and "crosses the surface" in found.message


# A rod whose −tan α rises to 0.254, falls below zero, and rises again until it lifts off.
TWICE = Mounting(clamp_angle=-0.2556, clamp_compliance=0.884, curvature=0.042)


@pytest.mark.parametrize("section", ["round", pytest.param("planar", marks=pytest.mark.nightly)])
def test_a_tip_held_by_more_friction_than_the_first_maximum_slips_on_the_second_rise(section):
    found = [
        solve_onset(1.77, mu0, 0.9665, mounting=TWICE, section=section) for mu0 in (0.2, 0.3, 0.6)
    ]
    # From another program, which shoots from the contact point.
    assert [float(onset.x0_slip) for onset in found[1:]] == pytest.approx(
        [0.474485888, 0.477928455], abs=1e-9
    )
    assert [onset.status for onset in found] == ["slip"] * 3 and found[0].x0_slip < 1e-4
    assert all(onset.mu_lock == np.inf for onset in found)
    whole = solve_curve(1.77, 0.9665, mounting=TWICE, section=section)
    x1, height = whole.contact_point(found[1].x0_slip)
    alone = solve_state(1.77, float(height), float(x1), mounting=TWICE)
    assert alone.reaction_fx / alone.reaction_fy == pytest.approx(0.3, abs=1e-9)
    assert alone.stability > 0.9


def test_friction_follows_from_a_travel_on_the_second_rise():
    found = friction_from_travel(1.77, 0.9665, 0.474, 0.001, mounting=TWICE, section="planar")
    assert 0.2542 < found.low < 0.3 < found.high < 0.6
    whole = solve_curve(1.77, 0.9665, mounting=TWICE, section="planar")
    assert whole.onset([found.low, found.high]) == pytest.approx([0.474, 0.475], abs=1e-9)
    # Between the maxima −tan α is below the first one.
    with pytest.raises(ArgumentError, match="no friction lets the tip slip in the step"):
        friction_from_travel(1.77, 0.9665, 0.3, 0.001, mounting=TWICE, section="planar")


@pytest.mark.parametrize("contact", Contact)
def test_a_yielding_rod_ends_where_it_begins_to_dip_at_its_clamp(contact):
    mounting = Mounting(
        clamp_angle=-0.0339, clamp_compliance=0.929, curvature=(2.95, -5.26, 7.71, -1.2)
    )
    found = solve_curve(1.72, 0.446, contact=contact, mounting=mounting, section="planar")
    assert found.end == "out_of_reach" and "dips below the level" in found.end_message
    assert found.x0_end == pytest.approx(0.0692685, abs=5e-8)
    end = found.state(found.x0_end)
    slope = np.pi / 2 + mounting.clamp_angle + mounting.clamp_compliance * end.reaction_m
    assert slope == pytest.approx(0.0, abs=1e-10)
