"""Slips of chains of links with mass: energy, limits, and the laws."""

import numpy as np
import pytest

from validation.slip_dynamics import (
    Case,
    SlipChain,
    resting,
    slip,
    travels_by_law,
)
from vibrissa import solve_curve

pytestmark = pytest.mark.slow
COARSE = {"theta": 2.0, "mu0": 0.3, "links": 16, "step": 0.01}


def test_energy_is_kept_without_friction_and_damping():
    chain = SlipChain(2.0, 0.85, 16)
    motion = resting(chain, 2.0, 0.85, 0.02, 0.25)
    start = chain.energy(motion)
    for _ in range(40):
        motion = chain.moved(motion, 0.01, 0.0)
        lengths = np.hypot(*chain.along(motion.place))
        assert lengths == pytest.approx(chain.h, rel=1e-9)
        assert chain.energy(motion) == pytest.approx(start, abs=1e-11)
    assert np.abs(motion.velocity).max() > 0.01


def test_an_equilibrium_of_a_chain_is_that_of_the_rod():
    curve, found = solve_curve(2.0, 0.85), {}
    for links in (32, 64):
        chain = SlipChain(2.0, 0.85, links)
        first, last = (resting(chain, 2.0, 0.85, x0, mu) for x0, mu in ((0.0, 0.0), (0.026, 0.3)))
        assert first.tip[0] == pytest.approx(0.0, abs=1e-12)
        assert -last.tip[0] / last.tip[1] == pytest.approx(0.3, rel=1e-12)
        found[links] = first.place[0, -1] - last.place[0, -1]
    onset = float(curve.onset(0.3))
    assert (4 * found[64] - found[32]) / 3 == pytest.approx(onset, rel=1e-4)


def test_without_damping_a_slip_ends_where_the_law_of_energy_has_it():
    found = slip(Case(kappa=0.8, zeta=0.0, **COARSE))
    assert found.slides == 1
    assert found.travel == pytest.approx(0.647, abs=0.01)
    friction = found.history[:, 4]
    assert (np.diff(friction) < 1e-10).all()


def test_damping_shortens_a_slip():
    undamped, damped, heavy = (
        slip(Case(kappa=0.8, zeta=zeta, **COARSE)) for zeta in (0.0, 0.05, 0.5)
    )
    law = travels_by_law(Case(kappa=0.8, zeta=0.05, **COARSE))
    assert law["kinetic"] < heavy.travel < damped.travel < undamped.travel
    assert damped.travel == pytest.approx(law["damped"], abs=0.02)


@pytest.mark.parametrize("zeta", [0.0, 0.02, 0.1])
def test_the_law_damped_is_nearest_to_the_dynamics(zeta):
    case = Case(kappa=0.7, zeta=zeta, **COARSE)
    travel, laws = slip(case).travel, travels_by_law(case)
    error = {name: abs(found - travel) for name, found in laws.items()}
    assert error["damped"] == min(error.values()) < 0.03
