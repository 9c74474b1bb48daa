"""How curves are cut, put together and tried again, on branches and pieces that are made up."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from made_curves import NEEDS, curve_of, made, made_pieces, made_states, rising
from vibrissa.outcomes import Contact, End, Parameter, RodSection, Status
from vibrissa.sticking.assembly import Limit, Solved
from vibrissa.sticking.curve import failed_curve
from vibrissa.sticking.solving import collocation, offsets, sections
from vibrissa.sticking.solving.beginning import Rods
from vibrissa.sticking.solving.collocation import (
    METHOD,
    NO_END,
    NO_LOCK,
    NO_ROUND_END,
    NO_SWITCH,
)
from vibrissa.sticking.solving.finishing import Resolved
from vibrissa.sticking.solving.offsets import StateSolution
from vibrissa.sticking.solving.refinement import NOT_RESOLVED
from vibrissa.sticking.solving.segments import STEP_SIZES, Segment


def branch(kinds, step=0.1, origin=0.0, last=None, fx=None, fy=None):
    """A segment of one branch with its kinds of contact: p and l."""
    fx = -np.arange(1.0, len(kinds) + 1.0) if fx is None else np.array(fx)
    fx = np.where(np.arange(len(kinds)) > (len(kinds) if last is None else last), np.nan, fx)
    steps = [made_states([value]) for value in fx]
    if fy is not None:
        steps = [replace(one, fy=np.array([y])) for one, y in zip(steps, fy, strict=True)]
    return Segment(
        parameter=Parameter.X0,
        branches=made_pieces([0.0], [1.0]),
        origin=np.array([origin]),
        step=np.array([step]),
        steps=steps,
        line=np.array([[kind == "l"] for kind in kinds]),
    )


def cut(monkeypatch, segment, switches, start=0.0, stop=0.45):
    """Cut a branch at known places."""
    at = iter(switches)
    monkeypatch.setattr(sections, "switches_between", lambda *_: np.array([next(at)]))
    (found,) = sections.sections_of(segment, np.array([start]), np.array([stop]))
    assert not list(at)
    return None if found is None else [(one.start, one.stop, one.line) for one in found]


def test_a_branch_is_cut_where_its_contact_changes(monkeypatch):
    assert cut(monkeypatch, branch("ppppp"), []) == [(0.0, 0.45, False)]
    assert cut(monkeypatch, branch("lllll"), []) == [(0.0, 0.45, True)]
    once = [(0.0, 0.17, False), (0.17, 0.45, True)]
    assert cut(monkeypatch, branch("pplll"), [0.17]) == once
    twice = [(0.0, 0.17, True), (0.17, 0.32, False), (0.32, 0.45, True)]
    assert cut(monkeypatch, branch("llppl"), [0.17, 0.32]) == twice
    # What comes behind its last state is nothing.
    assert cut(monkeypatch, branch("pplpp", last=2), [0.17]) == once


def test_a_pulled_branch_is_cut_from_its_end(monkeypatch):
    pulled = cut(monkeypatch, branch("lllpp", step=-0.1), [-0.27], -0.4, 0.0)
    assert pulled == [(-0.4, -0.27, False), (-0.27, 0.0, True)]
    thrice = cut(monkeypatch, branch("plplp", step=-0.1), [-0.05, -0.15, -0.25, -0.35], -0.4, 0.0)
    assert [line for *_, line in thrice] == [False, True, False, True, False]
    assert [start for start, *_ in thrice] == [-0.4, -0.35, -0.25, -0.15, -0.05]


def test_a_change_at_an_end_leaves_one_piece(monkeypatch):
    assert cut(monkeypatch, branch("plll"), [0.0], stop=0.3) == [(0.0, 0.3, True)]
    assert cut(monkeypatch, branch("pppl"), [0.28], stop=0.25) == [(0.0, 0.25, False)]
    # Up to rounding, before and behind the ends.
    assert cut(monkeypatch, branch("plll"), [-1e-13], stop=0.3) == [(0.0, 0.3, True)]


@pytest.mark.parametrize(
    ("place", "fits"), [(0.15, True), (0.195, True), (0.089, False), (0.091, True), (0.211, False)]
)
def test_a_change_lies_between_its_steps_but_for_what_few_nodes_are_off(monkeypatch, place, fits):
    found = cut(monkeypatch, branch("pplll"), [place])
    assert (found is not None) == fits


@pytest.mark.parametrize(
    ("start", "stop", "last"), [(np.nan, 0.4, 4), (0.0, np.nan, 4), (0.0, 0.1, 1)]
)
def test_a_branch_without_known_ends_or_with_two_states_is_not_cut(monkeypatch, start, stop, last):
    assert cut(monkeypatch, branch("ppppp", last=last), [], start, stop) is None
    assert cut(monkeypatch, branch("pppll"), [np.nan]) is None


def test_three_states_are_enough(monkeypatch):
    assert cut(monkeypatch, branch("ppp"), [], stop=0.2) == [(0.0, 0.2, False)]


@pytest.mark.parametrize(
    ("fx", "fy", "passed"),
    [
        # −tan α = fx/fy: past its maximum, still rising, and where the surface would have to pull.
        ([-1.0, -2.0, -1.5], [-1.0, -1.0, -1.0], True),
        ([-1.0, -2.0, -2.5], [-1.0, -1.0, -1.0], False),
        ([-1.0, -2.0, -2.5], [-1.0, -0.5, 0.1], True),
        ([-1.0, -2.0, -2.5], [-1.0, -0.5, 0.0], True),
        # A tip that is pushed back by a surface that pulls is none that lifts off.
        ([0.0, 1.0, 2.0], [-1.0, -1.0, 1.0], False),
        ([0.0, 0.0, 0.0], [-1.0, -1.0, -1.0], True),
    ],
)
def test_a_branch_has_passed_its_lock_or_lifts_off(fx, fy, passed):
    assert collocation._passed(branch("ppp", fx=fx, fy=fy)).tolist() == [passed]


def test_a_branch_turns_back_where_x0_falls_in_its_last_step(monkeypatch):
    """x1 − x0 grows again; a state behind the last one counts as little as one before."""
    ahead = {-1.0: 0.5, -2.0: 0.4, -3.0: 0.3, -4.0: 0.35, -5.0: 0.2}

    def position(states):
        return np.array([ahead[float(fx)] for fx in states.fx]), None

    monkeypatch.setattr(collocation, "contact_position", position)
    assert [collocation._turned(branch("ppppp", last=last)).tolist() for last in (2, 3, 4)] == [
        [False],
        [True],
        [False],
    ]


def resolved(start, stop, curve=0, at=np.nan, parameter=Parameter.X0):
    piece = replace(rising(stop, start=start), parameter=parameter)
    return Resolved(curve, piece, 1e-13, Limit(at, ""), np.nan)


def in_point_contact(*bounds):
    return [sections.Section(a, b, False) for a, b in bounds]


def test_pieces_of_a_segment_are_put_in_order_if_they_cover_it():
    late, early = resolved(0.6, 1.0), resolved(0.0, 0.6)
    other = resolved(0.0, 2.0, parameter=Parameter.ADVANCE)
    whole = in_point_contact((0.0, 0.4), (0.4, 1.0))
    advancing = in_point_contact((0.0, 2.0))
    assert sections.in_order(Parameter.X0, whole, [late, other, early]) == [early, late]
    assert sections.in_order(Parameter.ADVANCE, advancing, [late, other]) == [other]
    assert sections.in_order(Parameter.X0, whole, [late]) == []
    assert sections.in_order(Parameter.X0, whole, [other]) == []
    assert sections.in_order(Parameter.X0, None, []) == []
    # Up to rounding.
    short = resolved(0.0, 0.6 - 1e-10)
    assert sections.in_order(Parameter.X0, whole, [short, late]) == [short, late]
    shorter = resolved(0.0, 0.6 - 1e-8)
    assert sections.in_order(Parameter.X0, whole, [shorter, late]) == []


def assembled(**changed):
    given = {
        **{"theta": 2.0, "eta": 0.8, "x1_init": 0.5, "passed": True, "ideal": True},
        "sections": {
            Parameter.X0: in_point_contact((0.0, 1.0)),
            Parameter.ADVANCE: in_point_contact((1.0, 1.5)),
        },
        "solved": [resolved(1.0, 1.5, parameter=Parameter.ADVANCE), resolved(0.0, 1.0)],
        **{"pulled": [resolved(-0.5, 0.0)], "section": RodSection.ROUND},
    }
    return collocation._to_be_assembled(**given | changed)


def test_a_curve_is_assembled_of_what_was_resolved():
    found = assembled()
    assert isinstance(found, Solved)
    assert [piece.start for piece in found.pieces] == [0.0, 1.0]
    assert [piece.start for piece in found.pulled] == [-0.5]
    assert (found.x1_init, found.method, found.residual) == (0.5, METHOD, 1e-13)
    assert found.swings is None and len(found.limits) == 2 and found.no_end == NO_ROUND_END
    worst = assembled(pulled=[resolved(-0.5, 0.0)._replace(residual=3e-13)])
    assert worst.residual == 3e-13


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"passed": False}, NO_LOCK),
        ({"sections": {Parameter.X0: None}}, NO_SWITCH),
        ({"sections": {Parameter.X0: None}, "x1_init": np.nan}, NOT_RESOLVED),
        ({"solved": [resolved(0.0, 0.5)]}, NOT_RESOLVED),
    ],
)
def test_why_nothing_is_assembled_is_told(changed, said):
    found = assembled(**changed)
    assert (found.status, found.message, found.end_message) == (Status.FAILED, said, said)
    assert (found.theta, found.eta, found.method) == (2.0, 0.8, METHOD)


def test_a_pulled_part_that_is_inadmissible_is_left_out():
    parts = [resolved(-0.9, -0.5, at=-0.7), resolved(-0.5, 0.0)]
    assert assembled(pulled=parts).pulled == []


def test_where_a_mounted_or_planar_rod_ends_is_sought_otherwise():
    planar = assembled(section=RodSection.PLANAR)
    assert planar.swings is None and planar.no_end == NO_END
    mounted = assembled(ideal=False)
    assert np.isnan(mounted.swings).all() and len(mounted.swings) == 2
    assert mounted.no_end == NO_END


@pytest.mark.parametrize(
    ("kind", "columns", "possible"),
    [
        (Contact.POINT, {"phi1": 0.0}, True),
        (Contact.POINT, {"phi1": -1e-10}, True),
        (Contact.POINT, {"phi1": -1e-8}, False),
        (Contact.LINE, {"s_c": 0.7, "phi1": -0.5}, True),
        (Contact.LINE, {"s_c": 1.0 + 1e-10}, True),
        (Contact.LINE, {"s_c": 1.0 + 1e-8}, False),
        (Contact.LINE, {"s_c": 0.0}, False),
    ],
)
def test_a_piece_with_the_other_kind_of_contact_is_not_possible(kind, columns, possible):
    polynomials = NEEDS | {name: np.polynomial.Polynomial([one]) for name, one in columns.items()}
    curve = SimpleNamespace(pulled=(), pieces=(made(0.0, 1.0, polynomials, contact=kind),))
    assert collocation._is_possible(curve) == possible
    assert collocation._is_possible(replace(curve_of(rising(1.5)), pieces=curve.pieces)) == possible
    beside_it = SimpleNamespace(pulled=curve.pieces, pieces=(rising(1.0),))
    assert collocation._is_possible(beside_it) == possible


RODS = Rods(theta=np.arange(1.0, 5.0), eta=np.full(4, 0.8))
DONE = replace(curve_of(rising(1.5)), end=End.SNAPS)
HALF = replace(DONE, end=End.NOT_FOLLOWED)
LOST = failed_curve(theta=1.0, eta=0.8, method=METHOD, message="lost")


def test_what_is_not_solved_or_not_followed_is_tried_in_smaller_steps(monkeypatch):
    """What is known of a curve is not given up for less."""
    tries = {1.0: [DONE], 2.0: [LOST, HALF, DONE], 3.0: [HALF, LOST, LOST], 4.0: [LOST, LOST, HALF]}
    asked = []

    def in_steps(rods, sizes, model, section):
        asked.append((sizes, rods.theta.tolist()))
        number = STEP_SIZES.index(sizes)
        return [tries[theta][number] for theta in rods.theta]

    monkeypatch.setattr(collocation, "_in_steps", in_steps)
    found = collocation._solve_batch(RODS, Contact.POINT, RodSection.ROUND)
    assert found == [DONE, DONE, HALF, HALF]
    again = [1.0, 2.0, 3.0, 4.0], [2.0, 3.0, 4.0], [2.0, 3.0, 4.0]
    assert asked == list(zip(STEP_SIZES, again, strict=True))


def test_of_several_failures_the_last_is_told(monkeypatch):
    later = [replace(LOST, message=f"lost in steps of {sizes.x0}") for sizes in STEP_SIZES]
    monkeypatch.setattr(
        collocation,
        "_in_steps",
        lambda rods, sizes, *_: [later[STEP_SIZES.index(sizes)]] * len(rods),
    )
    assert collocation._solve_batch(RODS, Contact.POINT, RodSection.ROUND) == [later[-1]] * 4


def test_what_is_solved_is_not_tried_again(monkeypatch):
    monkeypatch.setattr(
        collocation,
        "_in_steps",
        lambda rods, sizes, *_: [DONE] * len(rods) if sizes is STEP_SIZES[0] else None,
    )
    assert collocation._solve_batch(RODS, Contact.POINT, RodSection.ROUND) == [DONE] * 4


def test_states_that_are_not_found_are_sought_in_smaller_steps(monkeypatch):
    """Those that are out of reach stay so; each belongs to its rod."""
    found, far = (StateSolution(None, 0.0, status, "") for status in ("solved", "out_of_reach"))
    lost = StateSolution(None, np.nan, Status.FAILED, "lost")
    tries = {
        0.1: [found],
        0.2: [lost, found],
        0.3: [far],
        0.4: [lost, lost, lost],
        0.5: [lost, lost, found],
    }
    asked = []

    def in_offsets(rods, of, sought, sizes, model):
        asked.append(dict(zip(sought.tolist(), rods.theta[of].tolist(), strict=True)))
        return [tries[offset][STEP_SIZES.index(sizes)] for offset in sought]

    monkeypatch.setattr(offsets, "_in_offsets", in_offsets)
    of, sought = np.array([0, 2, 1, 2, 0]), np.array([0.1, 0.2, 0.3, 0.4, 0.5])
    mountings = [collocation.IDEAL] * 4
    result = offsets.solve_offsets(RODS.theta, RODS.eta, of, sought, Contact.POINT, mountings)
    assert result == [found, found, far, lost, found]
    assert asked == [
        {0.1: 1.0, 0.2: 3.0, 0.3: 2.0, 0.4: 3.0, 0.5: 1.0},
        {0.2: 3.0, 0.4: 3.0, 0.5: 1.0},
        {0.4: 3.0, 0.5: 1.0},
    ]


def test_rods_of_one_kind_are_solved_together_in_batches_of_their_size(monkeypatch):
    """In the order of the arguments; round ideal rods have a size of their own."""
    tilted = collocation.Mounting(clamp_angle=0.1)
    oblique = collocation.Mounting(stage_angle=0.1)
    monkeypatch.setattr(collocation, "BATCH", {RodSection.ROUND: 2, RodSection.PLANAR: 3})
    asked = []

    def solve_batch(rods, model, section):
        asked.append(rods.theta.tolist())
        return [replace(DONE, theta=theta) for theta in rods.theta]

    monkeypatch.setattr(collocation, "_solve_batch", solve_batch)
    theta = np.arange(1.0, 11.0)
    mountings = [
        tilted,
        collocation.IDEAL,
        tilted,
        *[collocation.IDEAL] * 4,
        tilted,
        oblique,
        tilted,
    ]
    curves = collocation.solve_curves(theta, 0.1 * theta / 1.1, Contact.POINT, mountings)
    assert [curve.theta for curve in curves] == theta.tolist()
    assert [curve.mounting for curve in curves] == mountings
    assert asked == [[1.0, 3.0, 8.0], [10.0], [2.0, 4.0], [5.0, 6.0], [7.0], [9.0]]
    asked.clear()
    collocation.solve_curves(theta[:4], theta[:4] / 5.0, section=RodSection.PLANAR)
    assert asked == [[1.0, 2.0, 3.0], [4.0]]


def test_each_part_of_a_batch_is_resolved_once(monkeypatch):
    """Also where one piece needs more states, or is halved, while another is done."""
    batches, resolve = [], collocation.resolve

    def noted(pieces, guess):
        batches.append(list(resolve(pieces, guess)))
        return batches[-1]

    monkeypatch.setattr(collocation, "resolve", noted)
    collocation.solve_curves(np.array([1.0, 2.0, 4.0]), np.array([0.85, 0.5, 0.7]))
    for batch in batches:
        places = [(one.curve, one.piece.start) for one in batch]
        assert len(set(places)) == len(places)
    assert {one.curve for batch in batches for one in batch} >= {0, 1, 2}
