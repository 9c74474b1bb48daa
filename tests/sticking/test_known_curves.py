"""Whole curves, and how they were found: no number of them changes unnoticed.

That they are right is tested elsewhere, against other methods.
"""

import functools
from dataclasses import replace

import numpy as np
import pytest

from known import WITHIN, Known
from vibrissa import Mounting, solve_curve
from vibrissa.outcomes import Contact, RodSection, Status
from vibrissa.sticking.solving import collocation, continuation, refinement
from vibrissa.sticking.solving.segments import STEP_SIZES

KNOWN = Known(__file__)
TOGETHER = Mounting(
    clamp_angle=-0.05, clamp_compliance=0.1, curvature=(-0.1, -0.2), stage_angle=0.05
)
CASES = {
    "cylinder": {"theta": 1.0, "eta": 0.85},
    "paper": {"theta": 2.0, "eta": 0.85},
    "strong taper": {"theta": 4.0, "eta": 0.7},
    "very strong taper": {"theta": 12.0, "eta": 0.8},
    "lies down": {"theta": 3.0, "eta": 0.8, "contact": "line"},
    "lies from the start": {"theta": 3.0, "eta": 0.7, "contact": "line"},
    "planar": {"theta": 2.0, "eta": 0.85, "section": "planar"},
    "planar and lies down": {"theta": 3.0, "eta": 0.85, "contact": "line", "section": "planar"},
    "low": {"theta": 1.5, "eta": 0.35},
    "dips": {"theta": 1.0, "eta": 0.3126},
    "dips and is planar": {"theta": 1.0, "eta": 0.3126, "section": "planar"},
    "crosses itself": {"theta": 2.489, "eta": 0.3042, "section": "planar"},
    "crosses itself before it locks": {"theta": 2.0, "eta": 0.15, "section": "planar"},
    "nearly upright": {"theta": 1.5, "eta": 0.98},
    "leans back": {"theta": 2.0, "eta": 0.85, "mounting": Mounting(clamp_angle=0.1)},
    "yields": {"theta": 2.0, "eta": 0.85, "mounting": Mounting(clamp_compliance=0.2)},
    "curved": {"theta": 2.0, "eta": 0.85, "mounting": Mounting(curvature=(0.05, 0.1, -0.5))},
    "oblique": {"theta": 2.0, "eta": 0.85, "mounting": Mounting(stage_angle=0.1)},
    "mounted": {"theta": 3.0, "eta": 0.8, "contact": "line", "mounting": TOGETHER},
    "mounted and planar": {"theta": 2.0, "eta": 0.85, "mounting": TOGETHER, "section": "planar"},
    "swings before its lock": {"theta": 25.0, "eta": 0.93},
    "does not swing before its lock": {"theta": 25.0, "eta": 0.93, "section": "planar"},
    "lifts off": {"theta": 1.0, "eta": 0.18},
    "lifts off in its plane": {"theta": 1.0, "eta": 0.18, "section": "planar"},
    "far away": {"theta": 3.1, "eta": 0.25},
    "very far away": {"theta": 20.0, "eta": 0.3, "contact": "line"},
    "locks in a kink": {"theta": 2.3877, "eta": 0.8215, "contact": "line"},
    "slips back": {"theta": 3.0, "eta": 0.7, "contact": "line", "section": "planar"},
    "cylinder that lies down": {"theta": 1.0, "eta": 0.7, "contact": "line", "section": "planar"},
    "leaves the surface": {"theta": 2.0, "eta": 0.85, "mounting": Mounting(stage_angle=-0.1)},
    "towards the surface": {
        **{"theta": 2.5, "eta": 0.85, "contact": "line"},
        "mounting": Mounting(curvature=0.2),
    },
    "mounted, swings before its lock": {
        **{"theta": 3.8, "eta": 0.79},
        "mounting": Mounting(clamp_angle=-0.48, curvature=(1.1, 1.1)),
    },
    "leaves its plane": {
        **{"theta": 2.3, "eta": 0.85},
        "mounting": Mounting(clamp_angle=0.06, curvature=(1.13, 1.34)),
    },
    "springs": {"theta": 4.0, "eta": 0.95, "mounting": Mounting(curvature=2.0)},
    "leaves": {"theta": 2.0, "eta": 0.85, "mounting": Mounting(curvature=-2.0)},
}


def seen(curve):
    """What one can ask of a curve."""
    result = {
        name: getattr(curve, name)
        for name in (
            *("status", "message", "end", "end_message", "method", "section", "x1_init"),
            *("x0_lock", "mu_lock", "x0_touch", "x0_end", "x0_pull"),
        )
    }
    if not curve.pieces:
        return result
    x0 = np.array([0.0, 0.123, 0.456, 0.789, 1.0]) * curve.x0_end
    lock = curve.mu_lock if np.isfinite(curve.mu_lock) else 1.0
    result |= {
        "pieces": [
            f"{piece.contact} contact over {piece.parameter}: {len(piece.states)} states"
            for piece in (*curve.pulled, *curve.pieces)
        ],
        "begins": [piece.start for piece in (*curve.pulled, *curve.pieces)],
        "states": curve.state(x0),
        "contact": " ".join(curve.contact(x0)),
        "onsets": curve.onset(lock * np.array([0.01, 0.5, 0.99])),
    }
    if curve.pulled:
        result["pulled"] = curve.state(curve.x0_pull * np.array([1.0, 0.7, 0.2]))
        result["trails"] = curve.trailing_end(lock * np.array([1.001, 1.2, 2.0]))
    if curve.status is Status.SOLVED and np.isfinite(curve.mu_lock):
        result["past"] = curve.motion_end(lock * np.array([1.001, 1.5, 4.0]))
    return result


SLOW = ("springs", "crosses itself", "crosses itself before it locks", "very far away")


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.slow] * (name in SLOW)) for name in CASES]
)
def test_a_curve_is_the_known_one(name):
    curve = solve_curve(**CASES[name])
    assert not curve.residual > 1e-11
    # Where the branch turns back a place is known to half of the digits.
    relative = 1e-5 if curve.section == "planar" else WITHIN
    KNOWN.check(name, seen(curve), relative)


WAYS = {
    f"{model} contact in steps of {sizes.x0:g}": (model, sizes)
    for model in Contact
    for sizes in STEP_SIZES[:2]
}
RODS = (np.array([1.0, 2.0, 3.0, 6.0]), np.array([0.85, 0.5, 0.75, 0.9]))


def followed(segment):
    """How far branches were followed, and where they are then, as well as their steps tell."""
    last, line = segment.at(segment.last)
    steps = np.arange(len(segment.steps))[:, None]
    return {
        "step": segment.step,
        "steps": segment.last,
        "lies": (segment.line & (steps <= segment.last)).sum(axis=0),
        "ends in line contact": line,
        "from": segment.origin,
        "fx": last.fx,
        "fy": last.fy,
        "s_c": last.s_c,
        "tip": last.phi[:, -1],
    }


@pytest.mark.parametrize("name", WAYS)
def test_branches_are_followed_as_far_as_they_were(name):
    model, sizes = WAYS[name]
    begun, index = continuation.begin(*RODS, sizes, model)
    first = continuation.first_segment(begun, sizes, model)
    result = {
        "found": index,
        "begin": followed(begun),
        "first": followed(first),
        "both ways": followed(continuation.both_ways(begun, sizes, model)),
    } | {
        str(section): followed(continuation.second_segment(first, sizes, model, section))
        for section in RodSection
    }
    # Their states are guesses for what is solved exactly.
    KNOWN.check(name, result, 1e-4)


@pytest.mark.parametrize("name", WAYS)
def test_steps_that_are_solved_at_once_are_those_of_one_by_one(name, monkeypatch):
    model, sizes = WAYS[name]
    begun, _ = continuation.begin(*RODS, sizes, model)
    at_once = continuation.both_ways(begun, sizes, model)
    one_by_one = functools.partial(continuation.follow, longest=1)
    monkeypatch.setattr(continuation, "follow", one_by_one)
    expected = continuation.both_ways(begun, sizes, model)
    assert at_once.last.tolist() == expected.last.tolist()
    for number, (some, others) in enumerate(zip(at_once.steps, expected.steps, strict=False)):
        assert some.phi == pytest.approx(others.phi, abs=1e-5, nan_ok=True)
        known = at_once.last >= number
        assert (at_once.line[number] == expected.line[number])[known].all()


def test_a_branch_that_is_lost_is_followed_again_step_by_step(monkeypatch):
    """Whatever becomes of the others; nothing is left of states behind its end."""
    model, sizes = WAYS["line contact in steps of 0.05"]
    begun, _ = continuation.begin(*RODS, sizes, model)
    expected = continuation.both_ways(begun, sizes, model)
    seen = []
    step_by_step = continuation._step_by_step
    monkeypatch.setattr(
        continuation,
        "_step_by_step",
        lambda *a: seen.append(a[1].tolist()) or step_by_step(*a),
    )
    monkeypatch.setattr(continuation, "FEW_ITERATIONS", 2)
    found = continuation.both_ways(begun, sizes, model)
    assert any(seen) and found.last.tolist() == expected.last.tolist()
    fx, _ = found.forces
    assert (np.isfinite(fx).sum(axis=0) == found.last + 1).all()
    for number, states in enumerate(expected.steps):
        assert found.steps[number].phi == pytest.approx(states.phi, abs=1e-5, nan_ok=True)


def test_two_states_are_too_few_to_tell_that_a_branch_has_passed_its_lock_or_turned_back():
    """A quadratic is laid through three."""
    begun, _ = continuation.begin(np.array([2.0]), np.array([0.85]), STEP_SIZES[0], Contact.POINT)
    first = begun.steps[0]
    # The surface would pull, and the tip goes away from the clamp.
    states = [
        replace(first, phi=share * first.phi, fx=-np.ones(1), fy=np.ones(1))
        for share in (1.0, 0.95, 0.9, 0.85)
    ]
    segment = replace(begun, steps=states, line=np.zeros((4, 1), dtype=bool))
    for count in (1, 2, 3):
        expected = [False, True, True][3 - count :]
        assert continuation.past_lock(segment, count)[:, 0].tolist() == expected
        assert continuation.turns_back(segment, count)[:, 0].tolist() == expected


def test_a_branch_that_was_left_early_has_not_passed_its_lock():
    """Else its last state would be taken for the lock, and a finer try would not be made."""
    sizes = STEP_SIZES[0]
    begun, _ = continuation.begin(
        np.array([2.0, 1.0]), np.array([0.85, 0.18]), sizes, Contact.POINT
    )
    early = continuation.follow(begun, 2, Contact.POINT)
    assert collocation._passed(early).tolist() == [False, False]
    whole = continuation.first_segment(begun, sizes, Contact.POINT)
    # The one has a maximum, the other lifts off.
    assert collocation._passed(whole).tolist() == [True, True]


@pytest.mark.parametrize("end", range(1, 9))
def test_a_branch_ends_at_its_end_though_a_later_state_would_go_on(end):
    begun, _ = continuation.begin(np.array([2.0]), np.array([0.85]), STEP_SIZES[0], Contact.POINT)

    def but_there(segment, count):
        return np.arange(len(segment.steps))[-count:, None] != end

    assert continuation.follow(begun, 12, Contact.POINT, but_there).last == [end]


@pytest.mark.parametrize(
    "name", ["cylinder", "strong taper", "very strong taper", "lies from the start", "planar"]
)
def test_pieces_are_solved_as_often_as_they_were(name, monkeypatch):
    """Nodes, states and pieces of each try: what a curve costs."""
    tries = []
    solve_at = refinement.solve_at

    def noted(guess, pieces, position, inverse=None):
        known = "begun anew" if inverse is None else "known nearly"
        tries.append(f"{guess.nodes} x {len(position)} x {len(pieces)}, {known}")
        return solve_at(guess, pieces, position, inverse)

    monkeypatch.setattr(refinement, "solve_at", noted)
    solve_curve(**CASES[name])
    KNOWN.check(f"tries of {name}", tries)
