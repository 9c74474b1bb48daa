"""How the end of the admissible shapes is found on clearances that have a closed form."""

import numpy as np
import pytest

from vibrissa.mechanics.admissibility import (
    BELOW,
    CROSSES_ITSELF,
    CROSSES_SURFACE,
    TOLERANCE,
    Clearance,
)
from vibrissa.numerics.spectral import chebyshev_nodes
from vibrissa.sticking.solving import finishing
from vibrissa.sticking.solving.finishing import STATES_LOOKED_AT


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
    """Look for the end of the admissible shapes, where clearances are known functions."""

    def known(found, at):
        nothing = lambda t: t + np.inf  # noqa: E731
        return Clearance(**{n: clearances.get(n, nothing)(at) for n in Clearance.names()})

    monkeypatch.setattr(finishing, "_looked_at", known)
    return finishing._limit(None, chebyshev_nodes(STATES_LOOKED_AT))


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
