"""Pieces whose columns are polynomials: what is found on them, and on curves of them, is known."""

import numpy as np
import pytest
from numpy.polynomial import Polynomial

from made_curves import COLUMNS, NEEDS, curve_of, made, rising
from vibrissa.outcomes import Contact, End, Parameter, RodSection
from vibrissa.sticking.assembly import (
    NO_MAXIMUM,
    NOT_IN_PLANE,
    Event,
)
from vibrissa.sticking.curve import SAME, failed_curve
from vibrissa.sticking.piece import DISPLACEMENT, PieceArray
from vibrissa.sticking.reading import CurveArray

# From α = 0 on, and further along the advance, on which x0 turns back at t = 2.
BACK = COLUMNS | {"x0": Polynomial([-3.0, 4.0, -1.0])}
KINDS = {
    "x0": {"start": 0.0, "stop": 1.0},
    "pulled": {"start": -0.5, "stop": 0.0},
    "finer": {"start": 0.25, "stop": 1.25, "count": 17},
    "lies": {"start": 0.0, "stop": 1.0, "contact": Contact.LINE},
    "advance": {"start": 1.0, "stop": 2.5, "columns": BACK, "parameter": Parameter.ADVANCE},
}


def columns_of(name):
    return KINDS[name].get("columns", COLUMNS)


@pytest.fixture(scope="module")
def several():
    """All kinds side by side, and the place of each."""
    return PieceArray(pieces=tuple(made(**kind) for kind in KINDS.values()))


def of(name, count=1):
    return np.full(count, list(KINDS).index(name))


@pytest.mark.parametrize("name", KINDS)
def test_states_between_the_known_ones(several, name):
    start, stop = KINDS[name]["start"], KINDS[name]["stop"]
    t = start + (stop - start) * np.array([0.0, 0.123, 0.877, 1.0])
    found = several.at(of(name, 4), t)
    expected = {column: values(t) for column, values in columns_of(name).items()}
    if name == "lies":
        expected["phi1"] = 0.0 * t
    # No margin of stability is above that of a rod without load.
    expected["stability"] = np.minimum(expected["stability"], 1.0)
    for column, values in expected.items():
        assert getattr(found, column) == pytest.approx(values, abs=1e-11, nan_ok=True), column


def test_a_length_beyond_the_tip_is_none_if_it_is_rounding_and_is_shown_if_not():
    columns = COLUMNS | {"s_c": Polynomial([1.0 - 1e-10, 2e-10])}
    lies, touches = (
        made(start=0.0, stop=1.0, columns=columns, contact=contact)
        for contact in (Contact.LINE, Contact.POINT)
    )
    t = np.array([0.25, 0.75])
    assert lies.at(t).s_c == pytest.approx([1.0 - 5e-11, 1.0], abs=1e-14)
    assert touches.at(t).s_c.tolist() == [1.0, 1.0]
    beyond = made(
        start=0.0,
        stop=1.0,
        columns=COLUMNS | {"s_c": Polynomial([0.9, 0.2])},
        contact=Contact.LINE,
    )
    assert beyond.at(t).s_c == pytest.approx([0.95, 1.05], abs=1e-14)


def test_a_displacement_on_a_piece_along_the_advance(several):
    # x0 = 1 − (t − 2)², asked for up to where the piece ends.
    x0 = np.array([0.0, 0.19, 0.51, 0.75])
    states = several.at_x0(of("advance", 4), x0)
    t = 2.0 - np.sqrt(1.0 - x0)
    assert states.reaction_m == pytest.approx(BACK["reaction_m"](t), abs=1e-10)
    assert states.x0 == pytest.approx(x0, abs=1e-12)
    # Pieces meet up to rounding.
    beyond = made(1.0, 1.5, BACK, parameter=Parameter.ADVANCE).alone.at_x0(
        np.zeros(1, dtype=int), np.array([np.nextafter(0.75, 1.0)])
    )
    assert beyond.reaction_m == pytest.approx(BACK["reaction_m"](1.5), abs=1e-10)
    mixed = several.at_x0(np.concatenate([of("x0"), of("advance")]), np.array([0.19, 0.19]))
    assert mixed.reaction_fx == pytest.approx(
        [COLUMNS["reaction_fx"](0.19), BACK["reaction_fx"](t[1])]
    )


@pytest.mark.parametrize("name", ["x0", "finer", "pulled"])
@pytest.mark.parametrize("share", [0.0, 0.001, 0.3, 0.9999, 1.0])
def test_a_level_is_reached_where_the_polynomial_has_it(several, name, share):
    kind = KINDS[name]
    place = kind["start"] + share * (kind["stop"] - kind["start"])
    level = -COLUMNS["reaction_m"](np.array([place]))
    # The moment falls all the way.
    at = several.first(of(name), -several.samples.reaction_m, level, {"reaction_m": -1.0}, level)
    assert at == pytest.approx(place, abs=1e-13)


def test_of_two_places_with_one_level_the_first_counts(several):
    # x0 rises to 1 and falls again.
    at = several.first(
        of("advance", 2),
        several.samples.x0,
        np.array([0.84, 0.99]),
        DISPLACEMENT,
        np.array([0.84, 0.99]),
    )
    assert at == pytest.approx([1.6, 1.9], abs=1e-12)


def test_a_curve_locks_where_its_friction_demand_is_largest():
    curve = curve_of(rising(1.5))
    assert (curve.status, curve.end, curve.end_message) == (
        "solved",
        "not_followed",
        "not followed",
    )
    assert (curve.x0_lock, curve.mu_lock) == pytest.approx((1.0, 1.0), abs=1e-12)
    assert np.isnan(curve.x0_touch) and curve.message == ""
    # The smaller root of t·(2 − t) = μ0.
    assert curve.onset([0.19, 0.75, 1.0001]) == pytest.approx([0.1, 0.5, np.nan], nan_ok=True)


@pytest.mark.parametrize("stop", [0.9, 0.999])
def test_a_curve_without_a_maximum_inside_is_none(stop):
    curve = curve_of(rising(stop))
    assert (curve.status, curve.message, curve.pieces) == ("failed", NO_MAXIMUM, ())
    falls = curve_of(rising(stop, reaction_fx=Polynomial([-0.5, 0.1])))
    assert (falls.status, falls.message) == ("failed", NO_MAXIMUM)


def test_a_maximum_in_a_kink_belongs_to_the_second_piece():
    joint = 0.7 + 0.4 * SAME
    falls = rising(1.5, start=joint, reaction_fx=Polynomial([-1.26, 0.5]))
    curve = curve_of(rising(0.7), falls)
    assert curve.x0_lock == joint
    assert curve.mu_lock == pytest.approx(0.91, abs=1e-12)
    apart = curve_of(
        rising(0.7), rising(1.5, start=0.7 + 3.0 * SAME, reaction_fx=Polynomial([-1.26, 0.5]))
    )
    assert apart.x0_lock == pytest.approx(0.7, abs=0.5 * SAME)


def test_the_largest_of_all_pieces_is_the_lock():
    first = rising(0.5, reaction_fx=Polynomial([0.0, -2.0, 2.0]))
    twice = curve_of(first, rising(1.5, start=0.5))
    assert (twice.x0_lock, twice.mu_lock) == pytest.approx((1.0, 1.0), abs=1e-12)
    low = Polynomial([-0.4])
    once = curve_of(rising(1.2), rising(1.5, start=1.2, reaction_fx=low))
    assert (once.x0_lock, once.mu_lock) == pytest.approx((1.0, 1.0), abs=1e-12)


def test_a_tip_that_lifts_off_never_locks():
    """The normal force vanishes at t = 1.2, where the surface would begin to pull."""
    lifts = rising(1.5, reaction_fy=Polynomial([-1.2, 1.0]))
    curve = curve_of(lifts, rising(2.0, start=1.5))
    assert (curve.status, curve.end, curve.end_message) == ("solved", "lifts_off", "")
    assert (curve.x0_lock, curve.mu_lock) == (pytest.approx(1.2, abs=1e-12), np.inf)
    assert len(curve.pieces) == 1 and curve.x0_end == pytest.approx(1.2, abs=1e-12)
    breaks = curve_of(lifts, events=[breaks_at(1.3)])
    assert (breaks.end, breaks.end_message) == ("lifts_off", "")
    # A tip that is pushed ahead when it lifts off has slipped back before, whatever the friction.
    bend = Polynomial([0.0, -1.0, 1.0])
    pushed = curve_of(rising(1.5, reaction_fx=bend, reaction_fy=Polynomial([-1.2, 1.0])))
    assert (pushed.end, pushed.x0_end) == ("lifts_off", pytest.approx(1.2, abs=1e-12))
    assert 0.0 < pushed.x0_lock < 1.0 and np.isfinite(pushed.mu_lock)
    assert pushed.motion_end([1.0, 1e3])[0] == ["slips_back", "slips_back"]


def breaks_at(place):
    return [Event(place, End.OUT_OF_REACH, "it breaks")]


def swings_at(place):
    return [Event(place, End.SWINGS_ASIDE)]


def test_a_curve_ends_where_its_shape_is_inadmissible():
    curve = curve_of(rising(1.5), rising(2.0, start=1.5), events=[breaks_at(1.2), []])
    assert (curve.status, curve.message, curve.end) == ("solved", "", "out_of_reach")
    assert (curve.end_message, curve.x0_end, len(curve.pieces)) == ("it breaks", 1.2, 1)
    assert curve.x0_lock == pytest.approx(1.0)


def test_a_curve_that_ends_before_its_lock_has_states_up_to_there():
    curve = curve_of(rising(1.5), events=[breaks_at(0.5)])
    assert (curve.status, curve.message) == ("out_of_reach", "it breaks")
    assert np.isnan([curve.x0_lock, curve.mu_lock]).all() and curve.x0_end == 0.5
    assert curve.onset([0.19, 0.9]) == pytest.approx([0.1, np.nan], nan_ok=True)


@pytest.mark.parametrize(
    ("beyond", "count"), [(-0.2, 1), (0.0, 1), (0.5 * SAME, 1), (1.5 * SAME, 2)]
)
def test_a_piece_that_ends_where_it_begins_is_none(beyond, count):
    """The second one, which begins at 1.25; the first has the lock."""
    curve = curve_of(rising(1.25), rising(2.0, start=1.25), events=[[], breaks_at(1.25 + beyond)])
    assert len(curve.pieces) == count and curve.end == "out_of_reach"
    assert curve.x0_end == pytest.approx(1.25, abs=2.0 * SAME)
    nothing = curve_of(rising(1.5), events=[breaks_at(0.0)])
    assert (nothing.status, nothing.message, nothing.pieces) == ("out_of_reach", "it breaks", ())


def test_a_limit_at_the_end_of_a_piece_cuts_nothing_off():
    piece = rising(1.5)
    curve = curve_of(piece, rising(2.0, start=1.5), events=[breaks_at(1.5), []])
    assert curve.pieces == (piece,) and curve.end == "out_of_reach"


def test_a_round_rod_swings_aside_where_the_clamp_passes_under_its_contact_point():
    """At x0 = x1_init, also before its lock; in line contact at x0 − s_c = x1_init − 1."""
    for x1_init in (0.6, 1.25):
        curve = curve_of(rising(1.5), section=RodSection.ROUND, x1_init=x1_init)
        assert (curve.status, curve.end, curve.end_message) == ("solved", "swings_aside", "")
        assert curve.x0_end == x1_init
        assert curve.x0_lock == pytest.approx(min(x1_init, 1.0), abs=1e-12)
    lies = made(0.0, 1.5, NEEDS | {"s_c": Polynomial([0.9, -0.2])}, contact=Contact.LINE)
    # x0 − 0.9 + 0.2 x0 = −0.1
    lying = curve_of(lies, section=RodSection.ROUND, x1_init=0.9)
    assert lying.x0_end == pytest.approx(0.8 / 1.2, abs=1e-12)


def test_a_mounted_rod_swings_aside_where_its_margin_vanishes():
    curve = curve_of(rising(1.5), events=[swings_at(1.3)])
    assert (curve.end, curve.end_message, curve.x0_end) == ("swings_aside", "", 1.3)
    stays = curve_of(rising(1.5), events=[swings_at(np.nan)])
    assert (stays.end, stays.x0_end) == ("not_followed", 1.5)
    at_once = curve_of(rising(1.5), events=[swings_at(0.0)])
    assert (at_once.status, at_once.message) == ("out_of_reach", NOT_IN_PLANE)
    # What comes first counts.
    breaks = curve_of(rising(1.5), events=[[*swings_at(1.3), *breaks_at(1.2)]])
    assert (breaks.end, breaks.x0_end) == ("out_of_reach", 1.2)


def test_a_planar_rod_snaps_where_x0_turns_back():
    """On the second piece at t = 2, where x0 = 1.5 + (t − 1) − (t − 1)²/2."""
    columns = NEEDS | {"x0": Polynomial([0.0, 2.0, -0.5]), "reaction_fx": Polynomial([-0.5])}
    second = made(1.0, 2.5, columns, parameter=Parameter.ADVANCE)
    curve = curve_of(rising(1.5), second)
    assert (curve.end, curve.end_message) == ("snaps", "")
    assert curve.pieces[1].stop == pytest.approx(2.0, abs=1e-12)
    assert curve.x0_end == pytest.approx(2.0, abs=1e-12)


def test_where_the_rod_first_touches_the_surface_along_a_line():
    slope = {"phi1": Polynomial([0.4, -1.0])}
    assert curve_of(rising(1.5, **slope)).x0_touch == pytest.approx(0.4, abs=1e-12)
    # Past the lock it does not count.
    assert np.isnan(curve_of(rising(1.5, phi1=Polynomial([1.2, -1.0]))).x0_touch)
    short = curve_of(rising(1.5, **slope), events=[breaks_at(0.5)])
    assert short.x0_touch == pytest.approx(0.4, abs=1e-12)
    early = curve_of(rising(1.5, **slope), events=[breaks_at(0.3)])
    assert np.isnan(early.x0_touch)
    # Where it lies down in one place and only touches in another, the first counts.
    lies = made(0.6, 1.5, NEEDS, contact=Contact.LINE)
    assert curve_of(rising(0.6, **slope), lies).x0_touch == 0.6
    again = [made(at, at + 0.1, NEEDS, contact=Contact.LINE) for at in (0.6, 0.8)]
    rises = rising(0.6), again[0], rising(0.8, start=0.7), again[1], rising(1.5, start=0.9)
    assert curve_of(*rises).x0_touch == 0.6


@pytest.fixture(scope="module")
def read():
    """Curves side by side whose tip needs −tan α = t·(2 − t), pulled down to x0 = −0.8.

    The first swings aside at 2.5, the second goes on to 3 and has a kink at 1.25; the third has
    no states. Friction holds a pulled tip up to tan α = |t|·(2 + |t|).
    """
    pulled = [rising(-0.4, start=-0.8), rising(0.0, start=-0.4)]
    swings = curve_of(rising(2.75), pulled=pulled, section=RodSection.ROUND, x1_init=2.5)
    goes_on = curve_of(rising(1.25), rising(3.0, start=1.25), events=[[], breaks_at(3.0)])
    fails = failed_curve(theta=1.0, eta=0.5, method="made", message="nothing")
    return swings, goes_on, fails


def slips_back(mu0):
    """Where tan α = t·(t − 2) has grown to μ0."""
    return 1.0 + np.sqrt(1.0 + np.asarray(mu0))


def slips_ahead(mu0):
    return 1.0 - np.sqrt(1.0 - np.asarray(mu0))


def test_onsets_on_curves_side_by_side(read):
    of = np.array([2, 0, 1, 0, 1, 1])
    mu0 = np.array([0.5, 0.5, 0.97, 1.1, 1e-6, 1.0 + 1e-9])
    x0, status = CurveArray(curves=read).outcomes(of, mu0)
    expected = [np.nan, slips_ahead(0.5), slips_ahead(0.97), np.nan, slips_ahead(1e-6), np.nan]
    assert x0 == pytest.approx(expected, abs=1e-9, nan_ok=True)
    assert status == ["failed", "slip", "slip", "lock", "slip", "lock"]


def test_how_sticking_ends_past_the_lock(read):
    """It slips back where tan α has grown to μ0, if the curve does not end before."""
    of, mu0 = np.array([0, 0, 1, 1, 1]), np.array([1.1, 1.3, 1.1, 2.99, 3.01])
    ends, states = CurveArray(curves=read).motion_end(of, mu0)
    assert ends == ["slips_back", "swings_aside", "slips_back", "slips_back", "out_of_reach"]
    expected = [slips_back(1.1), 2.5, slips_back(1.1), slips_back(2.99), 3.0]
    assert states.x0 == pytest.approx(expected, abs=1e-10)
    assert np.tan(states.alpha[[0, 2, 3]]) == pytest.approx(mu0[[0, 2, 3]], abs=1e-9)
    unknown = curve_of(rising(1.5)).motion_end([1.1])
    assert unknown[0] == ["not_followed"] and np.isnan(unknown[1].x0).all()


@pytest.mark.parametrize("mu0", [1.1, 1.3, 2.0, 2.2])
def test_where_a_rod_slips_that_trails_behind_its_clamp(read, mu0):
    """Where the pulled tip slips, as far behind the swing as the pulled state is before it."""
    pull = np.sqrt(1.0 + mu0) - 1.0
    # The mirrored states count from the swing at 2.5 back to the pulled ones.
    state = read[0].trailing_end(mu0)
    assert state.x0 == pytest.approx(5.0 + pull, abs=1e-10)
    assert state.alpha == pytest.approx(-np.arctan(mu0), abs=1e-10)
    assert state.reaction_fy == pytest.approx(-1.0) and state.reaction_fx == pytest.approx(-mu0)
    assert state.phi1 == pytest.approx(np.pi - 0.5)
    assert state.reaction_m == pytest.approx(-COLUMNS["reaction_m"](-pull))


def test_a_rod_trails_no_farther_than_is_known(read):
    """With the most friction it slips beyond the last pulled state, where nothing is known."""
    most = 0.8 * 2.8
    of, mu0 = np.array([0, 0, 1, 2]), np.array([most - 1e-6, most + 1e-6, 1.1, 1.1])
    x0 = CurveArray(curves=read).trailing_end(of, mu0).x0
    assert np.isfinite(x0).tolist() == [True, False, False, False]


def test_states_and_contacts_on_curves_side_by_side(read):
    curves = CurveArray(curves=read)
    of, x0 = np.array([0, 1, 1, 0, 1, 2]), np.array([-0.4, 1.25, 1.3, -0.6, 3.0, np.nan])
    states = curves.states(of, x0)
    assert states.x0 == pytest.approx(x0, abs=1e-12, nan_ok=True)
    assert states.reaction_m == pytest.approx(COLUMNS["reaction_m"](x0), abs=1e-11, nan_ok=True)
    assert curves.x0_end == pytest.approx([2.5, 3.0, np.nan], nan_ok=True)
    assert curves.contact(of, x0) == ["point"] * 5 + [""]
    assert (curves.has_states.tolist(), curves.locks.tolist()) == (
        [True, True, False],
        [True, True, False],
    )


def test_the_contact_changes_where_the_next_piece_begins():
    lies = made(0.6, 1.5, NEEDS, contact=Contact.LINE)
    curve = curve_of(rising(0.6), lies)
    assert curve.contact([0.0, np.nextafter(0.6, 0.0), 0.6, 1.5, np.nan]) == [
        *("point", "point", "line", "line", ""),
    ]
