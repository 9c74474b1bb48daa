"""How pieces of curves are resolved: guesses, series, limits, each on what has a closed form."""

from dataclasses import replace

import numpy as np
import pytest

from made_curves import made_pieces, made_states
from vibrissa.mechanics.admissibility import (
    BELOW,
    CROSSES_ITSELF,
    CROSSES_SURFACE,
    TOLERANCE,
    Clearance,
)
from vibrissa.numerics.spectral import chebyshev_nodes, interpolation
from vibrissa.outcomes import Contact, Parameter
from vibrissa.sticking.piece import MARGINS, Piece, StickingState
from vibrissa.sticking.solving import finishing, refinement
from vibrissa.sticking.solving.finishing import STATES_LOOKED_AT
from vibrissa.sticking.solving.paths import combined
from vibrissa.sticking.solving.refinement import (
    DECAY_TOLERANCE,
    NODES_ALONG_ROD,
    STATES_ALONG_PIECE,
)


def test_on_many_nodes_a_state_has_ten_times_the_rounding():
    found = [refinement.residual_tolerance(nodes) for nodes in (24, 100, 101, 300)]
    assert found == [1e-12, 1e-12, 1e-11, 1e-11]


@pytest.mark.parametrize("nodes", [24, 52])
@pytest.mark.parametrize("ratio", [0.25, 0.51, 0.6, 0.75, 0.8, 0.9])
def test_nodes_are_as_many_as_a_geometric_series_needs(nodes, ratio):
    last = int(np.ceil(np.log(DECAY_TOLERANCE) / np.log(ratio)))
    expected = next((n for n in NODES_ALONG_ROD if n >= last), NODES_ALONG_ROD[-1])
    assert refinement._nodes_needed(np.array([ratio**nodes]), nodes) == [expected]


def test_a_series_that_does_not_fall_needs_the_most_nodes_and_one_that_has_ended_the_fewest():
    found = refinement._nodes_needed(np.array([1.0, np.inf, 0.0, 1e-300]), 24)
    assert found.tolist() == [NODES_ALONG_ROD[-1]] * 2 + [NODES_ALONG_ROD[0]] * 2


@pytest.mark.parametrize("count", STATES_ALONG_PIECE)
@pytest.mark.parametrize("ratio", [0.3, 0.4, 0.5, 0.55, 0.9])
def test_states_are_more_and_as_many_as_a_geometric_series_needs(count, ratio):
    # A tenth of the tolerance is aimed at.
    last = 1 + np.log(0.1 * DECAY_TOLERANCE) / np.log(ratio)
    expected = next((n for n in STATES_ALONG_PIECE if n > count and n >= last), np.inf)
    assert refinement._states_needed(np.array([ratio ** (count - 1)]), count) == [expected]


def test_a_piece_whose_series_does_not_fall_is_halved():
    found = refinement._states_needed(np.array([1.0, np.inf, 0.0]), 17)
    assert found.tolist() == [np.inf, np.inf, 25.0]
    assert refinement._states_needed(np.array([0.0]), STATES_ALONG_PIECE[-1]) == [np.inf]


def test_both_halves_of_pieces():
    pieces = made_pieces([1.0, 2.0], [0.5, 1.0])
    (first, left), (second, right) = refinement._halves(pieces)
    assert (first, second) == (0.0, 0.5)
    assert (left.start.tolist(), right.start.tolist()) == ([1.0, 2.0], [1.25, 2.5])
    assert left.length.tolist() == right.length.tolist() == [0.25, 0.5]


def series(**coefficients):
    """States along one piece by their Chebyshev coefficients; fy has a size of 5."""
    known = {"reaction_fy": [-5.0]} | coefficients
    position = 2.0 * chebyshev_nodes(9) - 1.0
    columns = {
        name: np.polynomial.chebyshev.chebval(position, known.get(name, [0.0]))[:, None]
        for name in StickingState.names()
    }
    return StickingState(**columns)


@pytest.mark.parametrize("place", [7, 8])
@pytest.mark.parametrize(
    ("name", "unit"),
    [("reaction_fx", 5.0), ("reaction_m", 5.0), ("phi1", 1.0), ("s_c", 1.0), ("x0", 1.0)],
)
def test_the_last_coefficients_tell_how_far_a_series_falls(name, unit, place):
    """In units of the force, of a radian or of the length; of the column, where it is larger."""
    last = [0.0] * place + [1e-3]
    assert refinement._curve_decay(series(**{name: last})) == pytest.approx(1e-3 / unit)
    large = [20.0, *last[1:]]
    assert refinement._curve_decay(series(**{name: large})) == pytest.approx(1e-3 / 20.0)
    before = [0.0] * 6 + [1e-3]
    assert refinement._curve_decay(series(**{name: before})) < 1e-15
    # Of all columns the largest counts.
    both = series(**{"reaction_fx": [0.0] * 8 + [1e-4], "phi1": [0.0] * 8 + [1e-5], name: last})
    assert refinement._curve_decay(both) == pytest.approx(1e-3 / unit)


def test_a_margin_need_not_fall_and_what_is_not_found_never_does():
    rough = series(**{name: [0.0] * 8 + [1.0] for name in MARGINS})
    assert refinement._curve_decay(rough) < 1e-15
    assert refinement._curve_decay(replace(rough, phi1=np.full((9, 1), np.nan))) == np.inf


def test_a_contact_beyond_the_tip_is_the_tip_up_to_rounding_alone():
    """Else it would not be seen that the rod cannot lie along the surface there."""
    path = replace(made_states(np.ones((4, 1))), s_c=np.array([[0.9], [1.0], [1.0 + 1e-12], [1.1]]))
    states = refinement._sticking_states(path, made_pieces([0.0], [1.0]))
    assert states.s_c[:, 0].tolist() == [0.9, 1.0, 1.0, 1.1]


def test_where_nothing_is_found_the_guess_remains():
    old, new = made_states([[1.0], [2.0]]), made_states([[3.0], [np.nan]])
    better = refinement._updated(old, new)
    assert better.fx.tolist() == [[3.0], [2.0]] and better.s_c.tolist() == [[9.0], [6.0]]


@pytest.mark.parametrize("place", [0.004, 0.06, 0.31, 0.5, 0.93, 0.9961])
@pytest.mark.parametrize("power", [1, 2])
def test_a_dip_is_found_however_narrow(place, power):
    """A parabola, or a kink, that falls below zero in a ten-thousandth of the interval."""

    def depth(below):
        return lambda at: np.abs(at - place) ** power - below

    narrow = 0.5e-4**power
    at = finishing._dip(depth(narrow), 0.0, 1.0)
    assert abs(at - place) < 0.5e-4
    # The same that stays above.
    assert np.isnan(finishing._dip(depth(-narrow), 0.0, 1.0))
    assert np.isnan(finishing._dip(depth(0.0), 0.0, 1.0))


@pytest.mark.parametrize("place", [0.0, 0.02, 0.4999, 1.0])
def test_the_first_inadmissible_shape(place):
    def look(at):
        far = np.full(len(at), np.inf)
        return Clearance(clamp=np.where(at < place, 1.0, -1.0), surface=far, itself=far)

    found = finishing._first_inadmissible(look, 0.0, 1.0)
    assert found == pytest.approx(place, abs=1.1e-11) and found >= place


# From the lowest point of (t - p)² - 10⁻⁸ to where it is inadmissible.
DEPTH = np.sqrt(1e-8 - TOLERANCE)


def limit(monkeypatch, **clearances):
    """Look for the end of the admissible shapes, where clearances are known functions of fx."""

    def known(path, contact, at):
        t = combined(interpolation(len(path), at), path).fx
        return Clearance(
            **{name: clearances.get(name, lambda t: t + np.inf)(t) for name in Clearance.names()}
        )

    monkeypatch.setattr(finishing, "_looked_at", known)
    path = made_states(chebyshev_nodes(17)[:, None])
    return finishing._limit(path, Contact.POINT, chebyshev_nodes(STATES_LOOKED_AT))


@pytest.mark.parametrize(
    ("name", "reason"),
    [("clamp", BELOW), ("surface", CROSSES_SURFACE), ("itself", CROSSES_ITSELF)],
)
def test_a_piece_ends_where_its_first_clearance_vanishes(monkeypatch, name, reason):
    # Between any two of the places at which it is known.
    for place in (0.001, 0.3337, 0.999):
        at, how = limit(monkeypatch, **{name: lambda t, place=place: place - t})
        assert at == pytest.approx(place, abs=2e-11) and how == reason
    at, how = limit(monkeypatch, **{name: lambda t: (t - 0.4321) ** 2 - 1e-8})
    assert at == pytest.approx(0.4321 - DEPTH, abs=2e-11) and how == reason
    at, how = limit(monkeypatch, **{name: lambda t: (t - 0.4321) ** 2 + 1e-8})
    assert np.isnan(at) and how == ""
    at, how = limit(monkeypatch, **{name: lambda t: t - 0.5})
    assert (at, how) == (0.0, reason)


def test_shapes_that_are_far_from_any_limit_are_not_looked_at_again(monkeypatch):
    """A clearance that is large, that only falls or rises, or too flat to dip below zero."""
    asked = []

    def seen(clearance):
        return lambda t: asked.append(len(t)) or clearance(t)

    steep = lambda t: 0.11 + 9.0 * np.abs(t - 0.4)  # noqa: E731
    for clearance in (steep, lambda t: 1.0 + t, lambda t: 0.05 + 0.0 * t):
        asked.clear()
        at, how = limit(monkeypatch, itself=seen(clearance))
        assert np.isnan(at) and how == "" and asked == [STATES_LOOKED_AT]


def test_of_several_limits_the_first_counts(monkeypatch):
    given = {"surface": lambda t: (t - 0.3) ** 2 - 1e-8, "itself": lambda t: 0.7 - t}
    at, how = limit(monkeypatch, **given)
    assert at == pytest.approx(0.3 - DEPTH, abs=2e-11) and how == CROSSES_SURFACE
    # Though at the next place at which all are known, 0.402, both are negative.
    at, how = limit(monkeypatch, surface=lambda t: 0.34 - t, itself=lambda t: 0.33 - t)
    assert at == pytest.approx(0.33, abs=2e-11) and how == CROSSES_ITSELF
    both = limit(monkeypatch, clamp=lambda t: 0.7 - t, itself=lambda t: 0.7 - t)
    assert both[1] == f"{BELOW}; {CROSSES_ITSELF}"


def test_what_jumps_ends_where_it_does(monkeypatch):
    at, how = limit(monkeypatch, surface=lambda t: np.where(t > 0.3337, -1.0, np.inf))
    assert at == pytest.approx(0.3337, abs=2e-11) and how == CROSSES_SURFACE


@pytest.mark.parametrize("place", [0.05, 0.7, 0.99])
def test_a_rod_leaves_its_plane_where_its_exact_margin_vanishes(monkeypatch, place):
    """The margin on few nodes is off by a little; fx is the share of the piece."""
    monkeypatch.setattr(finishing, "stability_aside", lambda s: (place - s.fx) * (1.0 + s.fx))
    path = made_states(chebyshev_nodes(17)[:, None])
    t = 2.0 + 3.0 * chebyshev_nodes(9)
    columns = dict.fromkeys(StickingState.names(), 0.0 * t) | {"x0": t}
    columns["stability_aside"] = 2.0 + 3.0 * place + 6e-4 - t

    def piece(**changed):
        states = StickingState(**columns | changed)
        kind = {"contact": Contact.POINT, "parameter": Parameter.X0}
        return Piece(**kind, start=2.0, stop=5.0, states=states)

    assert finishing._swing(path, piece()) == pytest.approx(2.0 + 3.0 * place, abs=1e-11)
    assert np.isnan(finishing._swing(path, piece(stability_aside=5.1 - t)))
    assert finishing._swing(path, piece(stability_aside=1.9 - t)) == 2.0
