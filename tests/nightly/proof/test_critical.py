"""The critical state: its digits, its derivatives, and claims that are refused."""

import pytest
from flint import arb, arb_mat

from validation.proof import NotProvedError
from validation.proof.critical import prove_critical, stationary, turning
from validation.proof.equilibrium import Rod, inclined, prove
from validation.proof.flow import Load, shoot
from validation.proof.krawczyk import krawczyk
from validation.proof.path import Path, proved_tube
from validation.proof.starting import load_at
from vibrissa import solve_curve

ETA = "0.85"


@pytest.fixture(scope="module")
def curve():
    return solve_curve(1, 0.85)


@pytest.fixture(scope="module")
def rod():
    return Rod(theta=arb(1), eta=arb(ETA), steps=12)


@pytest.fixture(scope="module")
def critical(rod, curve):
    return prove_critical(rod, load_at(curve, curve.x0_lock))


@pytest.mark.parametrize("pair", [(0, 0), (0, 1), (1, 2), (2, 2)])
def test_second_derivatives_are_derivatives_of_the_first(pair):
    """By the mean value theorem a difference quotient is a derivative between its two places."""
    theta, load, width = arb(2), Load(arb(-0.9), arb(-2.3), arb(-0.05)), arb(2) ** -20
    i, j = pair
    name = Load._fields[j]
    other = load._replace(**{name: load[j] + width})
    between = load._replace(**{name: load[j].union(other[j])})
    one, two = (shoot(theta, at, 12).tip[1 + i] for at in (load, other))
    place = {(0, 0): 4, (0, 1): 5, (1, 2): 8, (2, 2): 9}[pair]
    everywhere = shoot(theta, between, 12, second=True).tip[place]
    for a, b, curvature in zip(one, two, everywhere, strict=True):
        assert ((b - a) / width).overlaps(curvature)
        assert curvature.rad() < 1e-3 * (1 + abs(curvature))


def test_the_digits_are_those_of_the_solver(critical, curve):
    assert abs(float(critical.mu) - curve.mu_lock) < 1e-14
    assert critical.mu.rad() < 1e-15


def test_a_lock_moved_by_1e_14_is_refused(critical, rod):
    def claimed(by):
        """Claim that the critical state is within 1e-14 of a load with −tan α larger by this."""
        fx, fy, m0 = critical.load
        centre = arb_mat([[(fx + by * fy).mid()], [fy.mid()], [m0.mid()]])
        return krawczyk(stationary(rod), centre, [1e-14] * 3)

    image = claimed(0)
    assert (image[0, 0] / image[1, 0]).overlaps(critical.mu)
    with pytest.raises(NotProvedError, match="Krawczyk"):
        claimed(1e-14)


def test_an_onset_is_no_critical_state(rod, curve):
    slip = prove(rod, inclined(arb("0.3")), load_at(curve, float(curve.onset([0.3])[0])))
    value, _ = turning(slip.load, shoot(rod.theta, slip.load, rod.steps, second=True))
    assert not value.contains(0)


def tube(rod, curve, x0, reach):
    return proved_tube(rod, Load(*map(arb, load_at(curve, x0))), arb(reach), arb(reach) / 8)


def test_the_first_maximum_needs_tubes_that_rise_hold_it_and_fall(rod, curve, critical):
    x0 = curve.x0_lock
    before, over, behind = (tube(rod, curve, x0 + step, 0.01) for step in (-0.02, 0.0, 0.02))
    assert before.rise > 0 and behind.rise < 0
    assert over.bend is not None and over.bend > 0 and over.holds(critical.load)
    assert Path(tubes=[before, over, behind]).peaks_first(critical)
    assert not Path(tubes=[before, behind]).peaks_first(critical)
    assert not Path(tubes=[before, over]).peaks_first(critical)
    slip = prove(rod, inclined(arb("0.3")), load_at(curve, float(curve.onset([0.3])[0])))
    assert not Path(tubes=[before, over, behind]).peaks_first(slip)
