"""Onsets, locks and ends of leaning, yielding, curved rods against an independent march."""

from decimal import Decimal

import numpy as np
import pytest

import independent_march as march
from vibrissa import Mounting, Status
from vibrissa.outcomes import Contact, End, RodSection
from vibrissa.sticking.solving.collocation import solve_curves
from vibrissa.sticking.stiction import read_curves

pytestmark = pytest.mark.slow
# Rods in each kind of contact, and the tolerance (L).
COUNT, CLOSE = 8, 1e-9
# The ends of the march, in the words of the package.
ENDS = {"lifts_off": End.LIFTS_OFF, "snaps": End.SNAPS, "dips": End.OUT_OF_REACH}
# A rod whose demand rises twice.
TWICE = Mounting(clamp_angle=-0.2556, clamp_compliance=0.884, curvature=(0.042, 0.0))


def drawn(count, seed, contact):
    """Random rods; in line contact they are curved away from the surface."""
    random = np.random.default_rng(seed)
    most = 0.2 if contact is Contact.POINT else -0.02
    theta, eta = np.exp(random.uniform(0.0, np.log(6.0), count)), random.uniform(0.4, 0.98, count)
    mountings = [
        Mounting(
            clamp_angle=float(random.uniform(-0.3, 0.3)),
            clamp_compliance=float(random.choice([0.0, random.uniform(0.0, 0.9)])),
            curvature=(float(random.uniform(-0.5, most)), float(random.uniform(-0.4, 0.01))),
            stage_angle=float(random.choice([0.0, random.uniform(-0.08, 0.08)])),
        )
        for _ in range(count)
    ]
    return theta, eta, mountings


def followed(theta, eta, mountings, curves, contact):
    """Rods and paths of the march; only its guess of the first state is taken from the curves."""
    names = ("clamp_angle", "clamp_compliance", "stage_angle")
    beta, compliance, delta = (np.array([getattr(m, name) for m in mountings]) for name in names)
    kappa = np.array([(*m.coefficients, 0.0)[:2] for m in mountings])
    rods = march.Rods(theta, eta, beta, compliance, kappa, delta, np.zeros(len(theta)))
    first = [curve.state(0.0) for curve in curves]
    line = np.array([curve.contact(0.0) == "line" for curve in curves])
    start = np.array(
        [float(s.s_c if lies else s.phi1) for s, lies in zip(first, line, strict=True)]
    )
    fy = np.array([float(state.reaction_fy) for state in first])
    paths = march.march(rods, line, np.stack([start, 0.0 * fy, fy]), contact.value)
    return rods, march.finish(rods, paths)


def frictions(path):
    """Five friction coefficients: three below the first maximum of the demand, two above."""
    demand = np.array([knot.demand for knot in path.knots[:-1]])
    falls = np.flatnonzero((np.diff(demand) < 0.0) & (demand[:-1] > 0.0))
    first = demand[falls[0]] if len(falls) else demand.max()
    return first * np.array([0.3, 0.7, 0.97, 1.02, 2.0])


def exit_of(curve, mu0):
    """First exit from the cone, as `march.exits` returns it."""
    found = read_curves([curve], [np.array([mu0])], [[Decimal(1)]])
    if found.status[0] is Status.SLIP:
        return float(found.x0_slip[0]), 1.0
    back = found.end[0] == End.SLIPS_BACK
    return (float(found.ended.x0[0]), -1.0) if back else (np.nan, 0.0)


@pytest.mark.parametrize("contact", Contact)
def test_onsets_locks_and_ends_are_those_of_an_independent_march(contact):
    theta, eta, mountings = drawn(COUNT, 5, contact)
    theta, eta = np.append(theta, 1.77), np.append(eta, 0.9665)
    mountings.append(TWICE)
    curves = solve_curves(theta, eta, contact, mountings, RodSection.PLANAR)
    rows = [row for row, curve in enumerate(curves) if curve.pieces]
    curves, mountings = [curves[row] for row in rows], [mountings[row] for row in rows]
    rods, paths = followed(theta[rows], eta[rows], mountings, curves, contact)
    compared = 0
    for i, (curve, path) in enumerate(zip(curves, paths, strict=True)):
        if path.end == "turns":  # the march does not locate where a rod crosses itself
            continue
        compared += 1
        assert curve.end is ENDS[path.end]
        assert curve.x0_end == pytest.approx(path.knots[-1].x0, abs=CLOSE)
        if curve.status is Status.SOLVED:
            assert curve.mu_lock == pytest.approx(march.most(path)[0], abs=CLOSE)
        for mu0 in frictions(path):
            x0, way = march.exits(rods.take([i]), [path], [mu0])
            assert exit_of(curve, mu0) == (pytest.approx(x0[0], abs=CLOSE, nan_ok=True), way[0])
    assert compared > COUNT // 2
