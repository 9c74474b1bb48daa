"""Paths: where they lead, and how they are cut. Ends beside those of the explorer's solver.

That one is written in another language and shares no code with this one.
"""

from itertools import pairwise

import numpy as np
import pytest

from vibrissa import Mounting, solve_curve, solve_state
from vibrissa.mechanics.equations import ends, largest_residual
from vibrissa.mechanics.mounting import IDEAL, rod_columns
from vibrissa.outcomes import Contact, End
from vibrissa.sticking.solving import cutting
from vibrissa.sticking.solving.beginning import begin
from vibrissa.sticking.solving.following import CLOSENESS, LEAST_COSINE, follow

LEANS = 0.4


@pytest.mark.parametrize(
    ("gap", "mu_lock", "x0_end"),
    [
        (0.0410609940, 0.5688906945761201, 0.6888932218646543),
        (0.0210609940, 0.5123096209987621, 0.6157274323277908),
        (0.0059999940, 0.46669131895846655, 0.5529998546504044),
        (0.0010609940, 0.4509298254410438, 0.5306063386667189),
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
    assert ends == [End.SLIPS_BACK] * 2
    assert (states.x0 < curve.x0_end).all()
    assert states.reaction_fx == pytest.approx(-np.array([1.0, 100.0]) * states.reaction_fy)


@pytest.fixture(scope="module", params=list(Contact))
def followed(request):
    rods = rod_columns(np.array([1.0, 2.0, 3.0, 5.0]), [IDEAL] * 4)
    begun = begin(rods, np.array([0.85, 0.5, 0.75, 0.9]), np.zeros(4), 40, request.param)
    both, side = np.tile(np.arange(4), 2), np.repeat([1.0, -1.0], 4)
    branches = begun.branches.take(both)

    def ended(branches, knots):
        steep = knots.states.fx > -3.0 * knots.states.fy
        return (knots.states.fy >= 0.0) | ((side[knots.branch] < 0.0) & steep)

    longest = CLOSENESS[0].longest
    paths = follow(branches, begun.states.take(both), side, request.param, ended, longest)
    return branches, paths, side


def test_knots_are_equilibria_on_the_planes_normal_to_the_path(followed):
    branches, paths, _ = followed
    knots = paths.knots
    some = branches.take(knots.branch)
    at = some.coordinates(knots.states)
    assert np.linalg.norm(knots.direction, axis=1) == pytest.approx(1.0, abs=1e-12)
    closing = some.along(knots.direction, np.vecdot(knots.direction, at))
    assert (largest_residual(knots.states, closing) < 1e-5).all()
    inside = np.flatnonzero(knots.step > 0.0)
    way = np.vecdot(knots.direction[inside - 1], at[inside] - at[inside - 1])
    assert way == pytest.approx(knots.step[inside], abs=1e-6)
    bend = np.vecdot(knots.direction[inside], knots.direction[inside - 1])
    assert (bend > LEAST_COSINE).all()


def test_each_path_begins_at_alpha_0_and_goes_to_its_side(followed):
    branches, paths, side = followed
    knots, first, last = paths.knots, paths.first, paths.last
    assert knots.branch[first].tolist() == knots.branch[last].tolist() == list(range(8))
    assert knots.states.fx[first] == pytest.approx(0.0, abs=1e-9)
    x0 = branches.take(knots.branch).displacement(ends(knots.states).offset)
    assert (x0[last] * side > 0.0).all()
    # The first ones lead beyond where x0 turns back, the others to the friction asked for.
    assert (knots.direction[last, 0][:4] < 0.0).all()
    assert (knots.states.fx[last] > -3.0 * knots.states.fy[last])[4:].all()


def test_sections_cover_a_path_and_grow_along_it_and_meet_exactly(followed):
    branches, paths, side = followed
    knots, sections = paths.knots, cutting.sections_of(paths, side)
    covered = [row for one in sections for row in range(one.first + 1, one.last + 1)]
    assert covered == np.flatnonzero(knots.step > 0.0).tolist()
    at = branches.take(knots.branch).coordinates(knots.states)
    for one in sections:
        assert (np.diff(at[one.first : one.last + 1] @ one.direction) > 0.0).all()
        assert np.linalg.norm(one.direction) == pytest.approx(1.0)
    parts = cutting.cut(branches, paths, side, sections)
    for number, (one, other) in enumerate(pairwise(sections)):
        if one.last == other.first and one.by_x0 and other.by_x0:
            end = parts.start[number] + parts.length[number]
            assert end == pytest.approx(parts.start[number + 1], abs=1e-12)


def test_a_single_state_is_found_on_both_sides_of_a_kink_and_next_to_a_limit_point():
    curve = solve_curve(3.0, 0.85, contact="line", section="planar")
    kink = next(piece.last_x0 for piece in curve.pieces)
    for x0 in (0.5 * kink, kink + 1e-6, 0.9 * curve.x0_end, curve.x0_end - 1e-6):
        state = solve_state(3.0, 0.85, curve.x1_init - x0, "line")
        known = curve.state(np.array([x0]))
        assert state.reaction_fx == pytest.approx(known.reaction_fx[0], abs=1e-7)
        assert state.s_c == pytest.approx(known.s_c[0], abs=1e-7)
