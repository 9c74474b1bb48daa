"""How far branches are followed and with which contact, on states that are made up."""

from dataclasses import replace

import numpy as np
import pytest

from made_curves import made_pieces, made_states
from vibrissa.mechanics.equations import Closure
from vibrissa.outcomes import Contact, Parameter, RodSection
from vibrissa.sticking.solving import continuation
from vibrissa.sticking.solving.continuation import PULL_STEPS
from vibrissa.sticking.solving.segments import STEP_SIZES, Segment

SIZES = STEP_SIZES[0]


def branches(count, **changed):
    """Branches with their first state, of rods that are made up."""
    states = made_states(np.arange(1.0, count + 1.0))
    return Segment(
        parameter=Parameter.X0,
        branches=replace(made_pieces(np.zeros(count), np.ones(count)), **changed),
        origin=np.zeros(count),
        step=np.full(count, 0.025),
        steps=[states],
        line=np.zeros((1, count), dtype=bool),
    )


@pytest.fixture
def followed(monkeypatch):
    """What is asked of `follow`: the segment, the most steps, and where branches go on."""
    asked = []

    def follow(segment, count, model, goes_on, before=None):
        asked.append((segment, count, goes_on, before))
        return segment

    monkeypatch.setattr(continuation, "follow", follow)
    return asked


def test_pushed_and_pulled_branches_are_followed_both_ways(followed, monkeypatch):
    """Pulled ones in so many steps that the last would make the rod straight."""
    eta = np.array([0.6, 0.8])
    continuation.both_ways(branches(2, eta=eta), SIZES, Contact.POINT)
    ((segment, count, goes_on, _),) = followed
    assert count == round(2.0 / SIZES.x0)
    assert segment.step.tolist()[:2] == [0.025, 0.025]
    straight = segment.branches.x1_init[2:] - PULL_STEPS * segment.step[2:]
    assert np.hypot(straight, eta) == pytest.approx(1.0)

    def on(**states):
        """Whether they go on from such a state, behind so many others."""
        number, offset = states.pop("number", 5), states.pop("offset", 0.3)
        given = {"fx": -0.5, "fy": -1.0, "s_c": 1.0} | states
        state = replace(
            made_states(np.ones(4)), **{name: np.full(4, value) for name, value in given.items()}
        )
        monkeypatch.setattr(
            continuation, "contact_position", lambda s: (np.full(len(s), offset), None)
        )
        states = replace(segment, steps=[state] * (number + 1))
        return goes_on(states, 2)[-1].reshape(2, 2).T[0].tolist()

    # Pushed: until the clamp has passed under the contact, or the tip lifts off.
    assert on()[0] and on(offset=-0.9e-6)[0] and not on(offset=-1.1e-6)[0]
    assert on(offset=0.2, s_c=0.9)[0] and not on(offset=0.09, s_c=0.9)[0]
    assert on(fy=-1e-9)[0] and not on(fy=1e-9)[0]
    # Pulled: until friction holds the tip no longer, or the rod is nearly straight.
    assert on(fx=2.9)[1] and not on(fx=3.1)[1] and on(offset=-1.0)[1]
    assert on(number=PULL_STEPS - 2)[1] and not on(number=PULL_STEPS - 1)[1]


def test_the_first_segment_goes_on_until_its_lock_is_passed(followed):
    continuation.first_segment(branches(1), SIZES, Contact.POINT)
    ((_, count, goes_on, _),) = followed
    assert count == round(2.0 / SIZES.x0)

    def on(*demand):
        states = [replace(made_states([1.0]), fx=np.array([-d]), fy=-np.ones(1)) for d in demand]
        return goes_on(replace(branches(1), steps=states), 1).tolist()

    # Well below the maximum: the place of this is sought later.
    assert on(0.1, 0.5, 0.31) == [[True]] and on(0.1, 0.5, 0.29) == [[False]]
    assert on(0.5, 0.1, 0.31) == [[True]] and on(0.1, 0.2, 0.3) == [[True]]
    assert on(0.1, 0.2, -0.1) == [[False]]


@pytest.mark.parametrize("section", RodSection)
def test_the_second_segment_goes_on_where_the_first_ended_until_it_turns_back(
    followed, monkeypatch, section
):
    """The state before is guessed on the way that the first segment came."""
    values = {1.0: 0.2, 2.0: 0.6}
    first = replace(branches(1), steps=[made_states([value]) for value in (0.0, 1.0, 2.0)])
    first = replace(first, line=np.array([[False], [False], [True]]))
    monkeypatch.setattr(
        type(first.branches),
        "value_of",
        lambda self, parameter, states: np.array([values[fx] for fx in states.fx]),
    )
    continuation.second_segment(first, SIZES, Contact.LINE, section)
    ((segment, count, goes_on, before),) = followed
    assert (segment.parameter, segment.origin.tolist()) == (Parameter.ADVANCE, [0.6])
    assert segment.step.tolist() == [SIZES.advance] and segment.line.tolist() == [[True]]
    # An advance by 0.4 came with fx from 1 to 2.
    assert before.fx == pytest.approx([2.0 - SIZES.advance / 0.4])
    assert before.phi == pytest.approx(made_states(before.fx).phi)
    assert (before.fy, before.s_c) == (
        pytest.approx(-2.0 * before.fx),
        pytest.approx(3.0 * before.fx),
    )
    # Up to an advance of 50 at the latest.
    assert count == int(np.ceil(50.0 / SIZES.advance))
    offsets = {1.0: 0.5, 2.0: 0.4, 3.0: 0.41}
    monkeypatch.setattr(
        continuation, "contact_position", lambda s: (np.array([offsets[fx] for fx in s.fx]), None)
    )
    monkeypatch.setattr(continuation, "has_swung", lambda states: states.fx == 2.0)
    steps = [made_states([value]) for value in (1.0, 1.0, 2.0)]
    assert goes_on(replace(segment, steps=steps), 1).tolist() == [[section is RodSection.PLANAR]]
    back = [made_states([value]) for value in (1.0, 2.0, 3.0)]
    assert goes_on(replace(segment, steps=back), 1).tolist() == [[False]]


CASES = {
    # Kind that is tried first; s_c and φ1 of what is found with either kind (None: not found);
    # the kind in the end, None where there is no state.
    "touches": (False, (1.0, 0.2), None, False),
    "passes through and lies": (False, (1.0, -0.2), (0.9, 0.0), True),
    "passes through and lies up to its tip": (False, (1.0, -0.2), (1.0, 0.0), True),
    "passes through and cannot lie": (False, (1.0, -0.2), (1.1, 0.0), None),
    "passes through and is lost": (False, (1.0, -0.2), None, None),
    "is lost": (False, None, (0.9, 0.0), None),
    "lies": (True, None, (0.9, 0.0), True),
    "lies up to its tip": (True, None, (1.0, 0.0), True),
    "lies beyond its tip and touches": (True, (1.0, 0.2), (1.1, 0.0), False),
    "lies beyond its tip and passes through": (True, (1.0, -0.2), (1.1, 0.0), None),
    "peels off": (True, (1.0, 0.0), None, False),
    "lies down altogether": (True, None, (-0.1, 0.0), None),
}


def active(monkeypatch, names, model):
    """Solve made-up states with the kind of contact that is possible."""
    known = [CASES[name][1:3] for name in names]

    def solve_kinds(guess, eta, closure, line, iterations):
        number = guess.theta.astype(int)
        found = [known[i][int(lies)] for i, lies in zip(number, line, strict=True)]
        lost = np.array([one is None for one in found])
        # Where a search has not converged it ends somewhere.
        values = np.array([(0.5, 0.5) if one is None else one for one in found])
        return replace(guess, s_c=values[:, 0], fx=values[:, 1]), ~lost

    monkeypatch.setattr(continuation, "_solve_kinds", solve_kinds)
    monkeypatch.setattr(
        continuation, "ends", lambda s: type("Ends", (), {"phi1": s.fx, "moment": s.fx})
    )
    guess = replace(made_states(np.ones(len(names))), theta=np.arange(len(names), dtype=float))
    line = np.array([CASES[name][0] for name in names])
    closure = Closure.at_offset(np.zeros(len(names)), Contact.POINT)
    states, kind, found = continuation.with_active_contact(
        guess, np.ones(len(names)), closure, line, model
    )
    assert np.isfinite(states.fx).tolist() == found.tolist() == np.isfinite(states.s_c).tolist()
    return [bool(lies) if good else None for lies, good in zip(kind, found, strict=True)]


def test_each_state_has_the_kind_of_contact_that_is_possible(monkeypatch):
    expected = [case[3] for case in CASES.values()]
    assert active(monkeypatch, list(CASES), Contact.LINE) == expected
    for name, case in CASES.items():
        assert active(monkeypatch, [name], Contact.LINE) == [case[3]], name


def test_with_point_contact_alone_a_tip_may_pass_through(monkeypatch):
    names = ["touches", "passes through and lies", "is lost"]
    assert active(monkeypatch, names, Contact.POINT) == [False, False, None]


@pytest.mark.parametrize("angle", [None, 0.1, -0.2])
def test_a_stage_moves_the_clamp_and_the_height(angle):
    """x1 − x0·cos δ, and η falls by x0·sin δ: (E2) has what does not depend on x0 on one side."""
    given = None if angle is None else np.array([angle])
    one = made_pieces([0.0], [1.0], stage_angle=given)
    x0, tilt = np.array([0.3]), 0.0 if angle is None else angle
    offset = one.offset(x0)
    assert offset == pytest.approx(0.5 - 0.3 * np.cos(tilt))
    assert one.displacement(offset) == pytest.approx(x0)
    # With the height of the tip above the clamp, η − x0·sin δ:
    assert one.height + np.tan(tilt) * offset == pytest.approx(0.8 - 0.3 * np.sin(tilt))
    closure = one.closure(Parameter.X0, Contact.POINT, x0)
    assert closure.tilt == (None if angle is None else pytest.approx(np.tan(tilt)))


def test_a_branch_that_is_replaced_ends_where_the_other_does():
    four = replace(
        branches(2),
        steps=[made_states([value, 10.0 + value]) for value in range(1, 5)],
        line=np.array([[False, True]] * 4),
    )
    two = replace(
        branches(1),
        steps=[made_states([21.0]), made_states([22.0])],
        line=np.array([[False], [True]]),
    )
    found = four.with_branches(np.array([0]), two)
    fx, _ = found.forces
    assert fx[:, 1].tolist() == [11.0, 12.0, 13.0, 14.0]
    assert fx[:2, 0].tolist() == [21.0, 22.0] and np.isnan(fx[2:, 0]).all()
    assert found.line.tolist() == [[False, True], [True, True], [True, True], [True, True]]
    assert found.last.tolist() == [1, 3] and four.last.tolist() == [3, 3]
    states, line = found.at(np.array([1, 2]))
    assert states.fx.tolist() == [22.0, 13.0] and line.tolist() == [True, True]


@pytest.mark.parametrize("ends", [1, 2, 5])
@pytest.mark.parametrize("longest", [1, 8])
def test_a_branch_of_which_no_state_is_found_any_more_ends_there(monkeypatch, ends, longest):
    """However many steps are solved at once; the other branch goes on."""

    def solved(guess, eta, closure, line, model, iterations):
        found = (guess.theta > 1.0) | (guess.fx < ends + 0.5)
        states = replace(guess, fx=np.round(guess.fx))
        states.forget(~found)
        return states, line, found

    monkeypatch.setattr(continuation, "with_active_contact", solved)
    two = replace(made_states([0.0, 0.0]), theta=np.array([1.0, 2.0]))
    # One step before the first state fx is −1: it grows by 1 in each.
    before = replace(made_states([-1.0, -1.0]), theta=two.theta)
    segment = replace(branches(2), steps=[two])
    found = continuation.follow(segment, 7, Contact.POINT, before=before, longest=longest)
    assert found.last.tolist() == [ends, 7]
    fx, _ = found.forces
    assert fx[:, 1].tolist() == list(range(8))
    assert fx[: ends + 1, 0].tolist() == list(range(ends + 1))
