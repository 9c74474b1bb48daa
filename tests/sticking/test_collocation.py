"""How curves are put together and tried again, on pieces that are made up."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from made_curves import NEEDS, curve_of, made, made_pieces, rising
from vibrissa.outcomes import Contact, End, RodSection, Status
from vibrissa.sticking.assembly import Limit, Solved
from vibrissa.sticking.curve import failed_curve
from vibrissa.sticking.solving import collocation, offsets
from vibrissa.sticking.solving.beginning import CLOSENESS, Rods
from vibrissa.sticking.solving.collocation import METHOD, NO_END
from vibrissa.sticking.solving.finishing import Resolved
from vibrissa.sticking.solving.offsets import StateSolution
from vibrissa.sticking.solving.refinement import NOT_RESOLVED


def resolved(start, stop, part=0, at=np.nan):
    return Resolved(part, rising(stop, start=start), 1e-13, Limit(at, ""), np.nan)


def assembled(parts=None, pulled=None, turned=False, section=RodSection.ROUND, ideal=True):
    return collocation._to_be_assembled(
        made_pieces([0.0], [1.0]),
        [resolved(0.0, 1.0), resolved(1.0, 1.5)] if parts is None else parts,
        [resolved(-0.5, 0.0)] if pulled is None else pulled,
        turned=turned,
        section=section,
        ideal=ideal,
    )


def test_a_curve_is_assembled_of_what_was_resolved():
    found = assembled()
    assert isinstance(found, Solved)
    assert [piece.start for piece in found.pieces] == [0.0, 1.0]
    assert [piece.start for piece in found.pulled] == [-0.5]
    assert (found.x1_init, found.method, found.residual) == (0.5, METHOD, 1e-13)
    assert found.swings is None and len(found.limits) == 2 and found.no_end == NO_END
    worst = assembled(pulled=[resolved(-0.5, 0.0)._replace(residual=3e-13)])
    assert worst.residual == 3e-13


def test_why_nothing_is_assembled_is_told():
    found = assembled(parts=[])
    assert (found.status, found.message) == (Status.FAILED, NOT_RESOLVED)
    assert (found.theta, found.eta, found.method) == (1.0, 0.8, METHOD)


def test_a_pulled_part_that_is_inadmissible_is_left_out():
    parts = [resolved(-0.9, -0.5, at=-0.7), resolved(-0.5, 0.0)]
    assert assembled(pulled=parts).pulled == []


def test_where_a_mounted_or_planar_rod_ends_is_sought_otherwise():
    assert assembled(section=RodSection.PLANAR).swings is None
    mounted = assembled(ideal=False)
    assert np.isnan(mounted.swings).all() and len(mounted.swings) == 2


def test_a_path_that_turns_back_in_a_kink_snaps_there():
    turned = curve_of(rising(1.5), turned=True)
    assert (turned.end, turned.x0_end) == (End.SNAPS, 1.5)
    assert curve_of(rising(1.5)).end is End.NOT_FOLLOWED


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


def test_what_is_not_solved_or_not_followed_is_tried_more_closely(monkeypatch):
    """What is known of a curve is not given up for less."""
    tries = {1.0: [DONE], 2.0: [LOST, HALF, DONE], 3.0: [HALF, LOST, LOST], 4.0: [LOST, LOST, HALF]}
    asked = []

    def solve_so(closeness, rods, model, section):
        asked.append((closeness, rods.theta.tolist()))
        number = CLOSENESS.index(closeness)
        return [tries[theta][number] for theta in rods.theta]

    monkeypatch.setattr(collocation, "_solve_so", solve_so)
    found = collocation._solve_batch(RODS, Contact.POINT, RodSection.ROUND)
    assert found == [DONE, DONE, HALF, HALF]
    again = [1.0, 2.0, 3.0, 4.0], [2.0, 3.0, 4.0], [2.0, 3.0, 4.0]
    assert asked == list(zip(CLOSENESS, again, strict=True))


def test_of_several_failures_the_last_is_told(monkeypatch):
    later = [replace(LOST, message=f"lost in steps of {one.longest}") for one in CLOSENESS]
    monkeypatch.setattr(
        collocation,
        "_solve_so",
        lambda closeness, rods, *_: [later[CLOSENESS.index(closeness)]] * len(rods),
    )
    assert collocation._solve_batch(RODS, Contact.POINT, RodSection.ROUND) == [later[-1]] * 4


def test_what_is_solved_is_not_tried_again(monkeypatch):
    monkeypatch.setattr(
        collocation,
        "_solve_so",
        lambda closeness, rods, *_: [DONE] * len(rods) if closeness is CLOSENESS[0] else None,
    )
    assert collocation._solve_batch(RODS, Contact.POINT, RodSection.ROUND) == [DONE] * 4


def test_states_that_are_not_found_are_sought_more_closely(monkeypatch):
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

    def in_offsets(rods, of, sought, closeness, model):
        asked.append(dict(zip(sought.tolist(), rods.theta[of].tolist(), strict=True)))
        return [tries[offset][CLOSENESS.index(closeness)] for offset in sought]

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
        places = [(one.part, one.piece.start) for one in batch]
        assert len(set(places)) == len(places)
    assert len({one.part for batch in batches for one in batch}) >= 3
