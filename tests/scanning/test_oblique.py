"""Scans with an oblique stage, against shooting that shares no code with the package."""

from decimal import Decimal
from functools import cache

import numpy as np
import pytest

import reference
from responses import by_law, respond
from steel import identified
from vibrissa import Mounting, solve_curve, stick_slip
from vibrissa.errors import ArgumentError, NoResponseError
from vibrissa.outcomes import Contact, RodSection
from vibrissa.scanning import SlipLaw, surfaces
from vibrissa.scanning.response_over_eta import INTERPOLATION_ERROR, respond_over
from vibrissa.scanning.scan import Outcome, TipPhase
from vibrissa.scanning.simulation import simulate
from vibrissa.scanning.stage import Stage, path
from vibrissa.sensor import Setup, Whisker, scan

THETA, ETA, MU0 = 2.0, 0.85, 0.3
# φ1 and force of the first state, with which shooting begins.
FIRST = (0.55, 1.16)


@cache
def heights(section="round"):
    whisker = Whisker(theta=THETA, eta=ETA, section=RodSection(section))
    return respond_over(whisker, 0.809, 0.871)


def simulated(angle, mu0, step, turns, law="free", ratio=0.8, section="round"):
    stage = Stage(response=heights(section), eta=ETA, angle=angle)
    surface = mu0 if isinstance(mu0, surfaces.Surface) else surfaces.constant(mu0)
    scanned = simulate(stage, surface, path(step, turns), by_law(law, ratio))
    return stage, scanned


def shot(angle, positions, ratio):
    """Contact, fx, fy and period at each step by shooting; a slip ends at tan α = −ratio·μ0."""
    first = reference.solve_inclination(THETA, ETA, 0.0, FIRST)
    contact, period = reference.shoot_from_contact(THETA, *first, 0.0)[0], 1
    state, rows = np.append(first, 0.0), []
    for clamp in positions:
        height, along = ETA - clamp * np.sin(angle), clamp * np.cos(angle)
        state = reference.solve_offset(THETA, height, contact - along, state)
        if -state[2] > MU0 * state[1]:
            tan = -ratio * MU0
            phi1, p = reference.solve_inclination(THETA, height, tan, state[:2])
            state = np.array([phi1, p, p * tan])
            contact = along + reference.shoot_from_contact(THETA, *state)[0]
            period += 1
        # The clamp feels the opposite of what holds the tip.
        rows.append((contact, state[2], -state[1], period))
    return np.array(rows).T


def compared(angle, law, ratio, step, to):
    contact, fx, fy, period = shot(angle, path(step, [to]), ratio)
    _, found = simulated(angle, MU0, step, [to], law, 0.6)
    assert found.period.tolist() == period.tolist()
    assert found.contact == pytest.approx(contact, abs=1e-9)
    assert found.reactions[:, 0] == pytest.approx(fx, abs=1e-7)
    assert found.reactions[:, 1] == pytest.approx(fy, abs=1e-7)
    return period[-1]


@pytest.mark.slow
@pytest.mark.parametrize("angle", [0.1, -0.1])
def test_free_slips_are_the_cycles_of_a_study(angle):
    curve = solve_curve(THETA, ETA, mounting=Mounting(stage_angle=angle))
    study = stick_slip(curve, MU0, Decimal("0.004"), cycles=3)
    _, found = simulated(angle, MU0, "0.004", [str(study.clamp[-1])])
    assert found.phase.tolist() == study.phase.tolist()
    assert found.contact == pytest.approx(study.contact, abs=1e-12)
    assert found.reactions[:, 0] == pytest.approx(study.state.reaction_fx, abs=1e-8)
    assert found.reactions[:, 2] == pytest.approx(study.state.reaction_m, abs=1e-8)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("angle", "law", "ratio"),
    [(0.2, "free", 0.0), (-0.1, "kinetic", 0.6)],
)
def test_many_periods_of_an_oblique_stage_are_those_of_shooting(angle, law, ratio):
    assert compared(angle, law, ratio, "0.004", "0.12") >= 4


@pytest.mark.slow
def test_a_slip_on_an_oblique_stage_consumes_its_energy_at_the_present_height():
    _, found = simulated(0.1, MU0, "0.006", ["0.04"], "energy")
    at = int(np.argmax(found.phase == TipPhase.SLIP))
    height = ETA - found.clamp[at] * np.sin(0.1)
    ends = found.contact[at - 1 : at + 1] - found.clamp[at] * np.cos(0.1)
    nodes, weights = np.polynomial.legendre.leggauss(6)
    state, left = np.append(reference.solve_inclination(THETA, ETA, 0.0, FIRST), 0.0), 0.0
    for node, weight in zip(nodes, weights, strict=True):
        offset = ends.mean() + 0.5 * np.diff(ends)[0] * node
        state = reference.solve_offset(THETA, height, offset, state)
        # What holds the tip back does not, but kinetic friction does.
        left += weight * (-state[2] - 0.8 * MU0 * state[1])
    assert left == pytest.approx(0.0, abs=1e-6)
    # It passes the state in which kinetic friction balances the force.
    fx, fy, _ = found.reactions[at]
    assert fx / fy < 0.8 * MU0


@pytest.mark.parametrize(
    ("law", "turns"),
    [
        *((law, ["0.1", "0.05"]) for law in SlipLaw),
        pytest.param("energy", ["1.1", "0.8", "400"], marks=pytest.mark.slow),
    ],
)
def test_an_oblique_stage_of_no_angle_is_a_level_one(law, turns):
    """On stripes, and where the rod swings aside; however far the next step goes."""
    response = respond(THETA, ETA)
    stage = Stage(response=heights(), eta=ETA, angle=0.0)
    edges = [0.0, 0.42, 0.45, 0.46, 0.462, 0.5]
    surface = surfaces.patches(edges, [0.3, 0.25, 0.4, 0.2, 0.35, 0.9])
    positions = path("0.005" if turns[2:] else "0.001", turns[:2])
    positions = np.append(positions, [float(far) for far in turns[2:]])
    level = simulate(response, surface, positions, by_law(law, 0.7))
    found = simulate(stage, surface, positions, by_law(law, 0.7))
    assert found.outcome is level.outcome is Outcome.COMPLETE
    assert (found.phase == level.phase).all() and (found.side == level.side).all()
    assert (found.period == level.period).all() and found.period[-1] > 5
    assert found.contact == pytest.approx(level.contact, abs=1e-7)
    assert found.reactions == pytest.approx(level.reactions, abs=1e-6)


@pytest.mark.slow
def test_reactions_between_heights_are_those_that_are_solved():
    parts = heights().parts
    assert [(part.low, part.high) for part in parts] == [(0.809, ETA), (ETA, 0.871)]
    for eta in (0.8311, 0.8562):
        solved = respond(THETA, eta)
        x0 = np.linspace(solved.x0_pull + 1e-9, solved.x0_end - 1e-9, 40)
        states = heights().states(np.full(40, eta))
        size = np.abs(solved.reactions(x0)).max()
        assert (
            np.abs(states.reactions(x0) - solved.reactions(x0)).max()
            < 0.1 * INTERPOLATION_ERROR * size
        )
        # Towards the end the states stand more closely, as near a limit point.
        assert states.reactions_slope(x0)[:-1] == pytest.approx(
            solved.reactions_slope(x0)[:-1], abs=1e-5
        )
        assert heights().states(eta).reactions(x0) == pytest.approx(states.reactions(x0), abs=1e-14)


@pytest.mark.parametrize(
    ("angle", "to", "said"),
    [("60 deg", "1", "from -0.0160254 L to 0.85 L"), ("-0.1 rad", "2", "from 0.85 L to 1.04967 L")],
)
def test_a_stage_that_comes_too_near_or_goes_too_far_is_refused(angle, to, said):
    whisker = Setup.read(theta=THETA, eta=ETA, stage_angle=angle).whisker
    with pytest.raises(ArgumentError, match=f"{said}, but its .* between 0.02 L and 0.9999"):
        scan(whisker, surfaces.constant(MU0), step="0.01", to=[to])


@pytest.mark.slow
@pytest.mark.parametrize(("section", "outcome"), [("round", "complete"), ("planar", "lock")])
def test_a_rough_surface_locks_the_tip_and_a_round_rod_swings_aside(section, outcome):
    _, found = simulated(0.01, 0.6, "0.02", ["1.2"], section=section)
    assert found.outcome == outcome
    assert found.message.startswith("the tip locks at x = 0.417")
    assert TipPhase.LOCK in found.phase
    assert (found.side[-1] == "behind") == (section == "round")


def test_a_dragged_tip_is_the_mirror_image_at_its_height():
    _, found = simulated(0.02, 0.6, "0.01", ["0.6"], "kinetic")
    behind = np.flatnonzero(found.side == "behind")
    assert len(behind) > 10 and found.phase[behind[0]] == TipPhase.SWING
    state, row = np.append(reference.solve_inclination(THETA, ETA, 0.0, FIRST), 0.0), behind[-1]
    height = ETA - found.clamp[row] * np.sin(0.02)
    offset = found.clamp[row] * np.cos(0.02) - found.contact[row]
    _, p, q = reference.solve_offset(THETA, height, offset, state)
    assert found.reactions[row, :2] == pytest.approx([-q, -p], abs=1e-7)


@pytest.mark.slow
def test_a_height_without_a_response_is_refused():
    leaning = Setup.read(theta=2.0, eta=0.99, clamp_angle="20 deg", stage_angle="1 deg").whisker
    with pytest.raises(NoResponseError, match="alpha = 0"):
        scan(leaning, surfaces.constant(0.3), step="0.01", to=["0.1"])


@pytest.mark.parametrize("angle", [0.1, -0.1])
def test_a_tip_sticks_past_the_lock_from_the_largest_demand_along_the_stage_on(angle):
    """However little less friction there is, and however short the way on which it is less."""
    largest = solve_curve(THETA, ETA, mounting=Mounting(stage_angle=angle)).mu_lock
    for part, slips in ((-1e-6, True), (-1e-8, True), (1e-8, False), (1e-6, False)):
        _, found = simulated(angle, largest * (1.0 + part), "0.02", ["0.2"])
        assert (TipPhase.SLIP in found.phase) == slips


@pytest.mark.slow
def test_the_tail_of_a_rod_that_lies_on_the_surface_swings_about_the_contact_point():
    near = respond_over(Whisker(theta=3.0, eta=0.85, contact=Contact.LINE), 0.849, 0.85)
    stage = Stage(response=near, eta=0.85, angle=1e-6)
    positions = path("0.01", ["0.85"])
    found = simulate(stage, surfaces.constant(0.9), positions)
    level = simulate(respond(3.0, 0.85, "line"), surfaces.constant(0.9), positions)
    assert (found.phase == level.phase).all() and found.period[-1] > 1
    (swing,) = np.flatnonzero(found.phase == TipPhase.SWING)
    assert found.contact[swing] < found.contact[swing - 1] - 0.01
    assert found.contact == pytest.approx(level.contact, abs=1e-4)
    assert found.reactions == pytest.approx(level.reactions, abs=1e-3)


@pytest.mark.parametrize(("wild", "said"), [(1e5, "to 0.85 L"), (-1e5, "to 5")])
def test_a_recorded_position_at_which_the_rod_cannot_be_is_refused(wild, said):
    whisker = Setup.read(theta=THETA, eta=ETA, stage_angle="3 deg").whisker
    table = scan(whisker, surfaces.constant(MU0), step="0.002", to=["0.2"]).to_pandas()
    table.loc[40, "footpoint"] = wild
    with pytest.raises(NoResponseError, match=f"distances from .*{said}.*check the positions"):
        identified(whisker, table, noise="1e-6, 1e-6, 1e-7", assume=False)


@pytest.mark.nightly
@pytest.mark.slow
def test_friction_is_read_as_the_rod_rises():
    """A rod that becomes almost upright is in tests/nightly, too."""
    whisker = Setup.read(theta=THETA, eta=ETA, stage_angle="-0.1 rad").whisker
    table = scan(whisker, surfaces.constant(MU0), step="0.002", to=["0.9"]).to_pandas()
    found = identified(whisker, table, noise="1e-6, 1e-6, 1e-7", assume=False).periods
    slip = found.status == "slip"
    assert slip.sum() > 10 and (~slip).sum() == 1
    assert found.mu0[slip] == pytest.approx(MU0, abs=0.006)


@pytest.mark.slow
@pytest.mark.parametrize("angle", ["3 deg", pytest.param("-3 deg", marks=pytest.mark.nightly)])
def test_friction_is_read_at_the_height_of_each_period(angle):
    whisker = Setup.read(theta=THETA, eta=ETA, stage_angle=angle).whisker
    surface = surfaces.random(1, 0.3, 0.04, 0.02)
    signals = scan(whisker, surface, step="0.0005", to=["0.3", "0.1"])
    found = identified(whisker, signals.to_pandas(), noise="1e-6, 1e-6, 1e-7", assume=False)
    slip = found.periods.status == "slip"
    assert slip.sum() > 20 and len(slip) == signals.truth.period[-1]
    ends = found.periods.last[slip]
    assert found.periods.contact[slip] == pytest.approx(signals.truth.contact[ends], abs=1e-6)
    error = found.periods.mu0[slip] - signals.truth.mu0[ends]
    assert (np.abs(error) < 2.0 * found.periods.deviation[slip]).all()
    assert error.std() < 0.006
