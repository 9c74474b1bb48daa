"""Onsets, locks and ends of leaning, yielding, curved rods against an independent march."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.special import ellipe, ellipk

from validation import march, march_agreement
from vibrissa import Mounting
from vibrissa.outcomes import Contact, RodSection

pytestmark = pytest.mark.slow
# Rods with several maxima of −tan α; one that dips next to its clamp; one that rises as an arch.
DEEP = (2.95, -5.26, 7.71, -1.2)
SPECIAL = [
    (1.77, 0.9665, Mounting(clamp_angle=-0.2556, clamp_compliance=0.884, curvature=0.042)),
    (1.72, 0.446, Mounting(clamp_angle=-0.0339, clamp_compliance=0.929, curvature=DEEP)),
    (2.7468, 0.6336, Mounting(clamp_angle=0.2345, curvature=(0.499, 0.195), stage_angle=0.0366)),
]


def sample(count, seed, contact):
    drawn = march_agreement.drawn(count, seed, contact, RodSection.PLANAR)
    theta, eta, mountings = zip(*SPECIAL, strict=True)
    return drawn._replace(
        theta=np.append(drawn.theta, theta),
        eta=np.append(drawn.eta, eta),
        mountings=[*drawn.mountings, *mountings],
    )


@pytest.mark.parametrize("contact", Contact)
def test_onsets_locks_and_ends_are_those_of_an_independent_march(contact):
    rods = sample(12, 5, contact)
    found = march_agreement.compare(rods, march_agreement.solve(rods))
    assert not found.odd
    assert found.counts["ends: snaps"] > 5 and found.counts["slips forward"] > 20
    assert found.counts["ends: lifts"] > 0 and found.counts["slips back"] > 0


def test_an_ideal_round_rod_swings_aside_where_the_clamp_passes_under_its_contact():
    rods = march_agreement.drawn(2, 7, Contact.LINE, RodSection.ROUND)
    found = march_agreement.compare(rods, march_agreement.solve(rods))
    assert not found.odd and found.counts["ends: swings"] == 2


def test_the_march_starts_from_the_closed_form_of_a_cylinder():
    modulus = np.array([0.2, 0.5, 0.7])
    quarter, n = ellipk(modulus**2), len(modulus)
    zero, no = np.zeros(n), np.full(n, False)
    rods = march.Rods(
        theta=np.ones(n),
        eta=2.0 * ellipe(modulus**2) / quarter - 1.0,
        beta=zero,
        compliance=zero,
        kappa=np.zeros((n, 2)),
        delta=zero,
        lies=no,
        round=no,
        x1=zero,
    )
    # The slope at the tip: k = sin((π/2 − φ1)/2).
    slope = np.pi / 2 - 2.0 * np.arcsin(modulus)
    start = np.stack([slope + 0.01, zero, -1.02 * quarter**2], axis=1)
    first = march.first_states(rods, no, start)
    assert first.good.all()
    assert -first.states.u[:, 2] == pytest.approx(quarter**2, rel=1e-12)
    assert first.rods.x1 == pytest.approx(2.0 * modulus / quarter, abs=1e-12)


def test_the_march_agrees_with_itself_in_other_steps(monkeypatch):
    rods = march_agreement.drawn(8, 11, Contact.LINE, RodSection.PLANAR)
    curves = march_agreement.solve(rods)
    rods = march_agreement.with_path(rods, curves)
    curves = [curve for curve in curves if curve.pieces]
    assert len(curves) > 3
    first = march_agreement.marched(rods, curves)
    monkeypatch.setattr(march, "STEPS", 60)
    monkeypatch.setattr(march, "STRIDE", 0.055)
    second = march_agreement.marched(rods, curves)
    assert first.ends == second.ends and len(second.of) > len(first.of)
    for rod in range(len(curves)):
        ends = [paths.states.x0[paths.last(rod)] for paths in (first, second)]
        locks = [march.largest_demand(paths, rod) for paths in (first, second)]
        assert ends[0] == pytest.approx(ends[1], abs=1e-10)
        assert locks[0] == pytest.approx(locks[1], abs=1e-10, nan_ok=True)
    of, mu0 = np.arange(len(curves)), np.full(len(curves), 0.25)
    onsets = [march.exits(paths, of, mu0).x0 for paths in (first, second)]
    assert onsets[0] == pytest.approx(onsets[1], abs=1e-10, nan_ok=True)


def test_a_curve_that_differs_is_noticed():
    rods = march_agreement.drawn(1, 5, Contact.POINT, RodSection.PLANAR)
    (curve,) = march_agreement.solve(rods)
    other_lock = replace(curve, mu_lock=curve.mu_lock + 2e-9)
    two = rods._replace(
        theta=np.repeat(rods.theta, 2), eta=rods.eta - [0.0, 1e-7], mountings=rods.mountings * 2
    )
    found = march_agreement.compare(two, [other_lock, curve])
    assert found.odd[0].startswith("mu_lock differs by 2e-09")
    assert any(odd.startswith("x0_end") for odd in found.odd[1:])
