"""Solvers that share no code, compared at more and harder points than in the other tests."""

from itertools import product

import numpy as np
import pytest

from validation import explorer_agreement as agreement
from validation.node import node
from vibrissa import Status, solve_curve
from vibrissa.mechanics.admissibility import CROSSES_ITSELF
from vibrissa.outcomes import Contact, RodSection
from vibrissa.sticking.solving import shooting

# Searched less closely than a study does: to see where the curve ends takes no more.
COARSE = shooting.Tolerances(rtol=1e-8, atol=1e-9, simplex=1e-8, miss=1e-6)


def test_the_explorer_and_python_agree():
    """At some of the points of `python -m validation explorer-agreement`."""
    with node() as page:
        agreement.open_solver(page)
        kinds = product((False, True), Contact, RodSection)
        for seed, (mounted, contact, section) in enumerate(kinds, 1):
            kind = {"mounted": mounted, "section": section}
            points = agreement.points(150 if mounted else 500, seed, contact, **kind)[:40]
            rows = agreement.compared(points, page)
            worst = max(max(row.values(), default=0.0) for row in rows)
            assert worst < agreement.TOLERATED, (contact, kind)


def test_both_methods_find_the_same_curve():
    shot, spectral = shooting.solve_curve(2.0, 0.85, 0.012), solve_curve(2.0, 0.85)
    assert shot.status is Status.SOLVED and shot.residual < 1e-9
    assert shot.mu_lock == pytest.approx(spectral.mu_lock, abs=1e-9)
    mu0 = [0.1, 0.3, 0.4, 0.47]
    assert shot.onset(mu0) == pytest.approx(spectral.onset(mu0), abs=1e-8)
    x0 = np.linspace(0.0, shot.x0_lock, 23)
    got, expected = shot.state(x0).columns, spectral.state(x0).columns
    for name in expected.keys() - {"stability", "stability_aside"}:
        assert got[name] == pytest.approx(expected[name], abs=1e-7)


def test_shooting_ends_where_the_rod_crosses_itself():
    curve = shooting.solve_curve(2.0, 0.15, 0.05, COARSE, RodSection.PLANAR)
    assert curve.status is Status.OUT_OF_REACH and curve.message == CROSSES_ITSELF
    assert curve.x0_end == pytest.approx(0.674, abs=1.1e-3)
    assert curve.onset([0.3])[0] == pytest.approx(0.04213929, abs=1e-7)


def test_what_cannot_be_resolved_is_failed_and_says_what_to_try():
    curve = solve_curve(50.0, 0.05)
    assert curve.status is Status.FAILED and "try a larger eta" in curve.message


def test_a_strong_taper_near_the_surface_is_resolved():
    curve = solve_curve(20.0, 0.3)
    assert curve.status is Status.SOLVED and curve.residual <= 1e-11
