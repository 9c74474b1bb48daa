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
