"""The critical state: its digits, its derivatives, and claims that are refused."""

import re

import pytest
from flint import arb, arb_mat
from typer.testing import CliRunner

from vibrissa import solve_curve
from vibrissa.cli.app import app
from vibrissa.errors import NotProvedError
from vibrissa.proof import Effort, lock
from vibrissa.proof.critical import prove_critical, stationary, turning
from vibrissa.proof.equilibrium import Rod, inclined, prove
from vibrissa.proof.flow import Load, shoot
from vibrissa.proof.krawczyk import examined
from vibrissa.proof.path import Path, proved_tube
from vibrissa.proof.starting import load_at

QUICK = Effort(bits=96, order=24, steps=12)
ETA = "0.85"


@pytest.fixture(scope="module")
def curve():
    return solve_curve(1, 0.85)


@pytest.fixture(scope="module")
def rod():
    with QUICK.spent():
        return Rod(theta=arb(1), eta=arb(ETA), steps=12)


@pytest.fixture(scope="module")
def critical(rod, curve):
    with QUICK.spent():
        return prove_critical(rod, load_at(curve, curve.x0_lock))


@pytest.fixture(autouse=True)
def _precision():
    with QUICK.spent():
        yield


@pytest.mark.slow
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


@pytest.mark.slow
def test_the_digits_are_those_of_the_solver(critical, curve):
    assert abs(float(critical.mu) - curve.mu_lock) < 1e-14
    assert critical.mu.rad() < 1e-15


@pytest.mark.slow
def test_states_beside_it_demand_less_friction(critical, rod):
    """Independent of second derivatives: of equilibria on both sides −tan α is smaller."""
    for shift in (-0.05, 0.05):
        mu = critical.mu - arb("1e-5")
        near = [value.mid() for value in critical.load]
        beside = prove(rod, inclined(mu), [near[0] + shift, near[1] + shift / 2, near[2]])
        assert beside.mu < critical.mu
        assert not beside.load.fx.overlaps(critical.load.fx)


@pytest.mark.slow
def test_another_order_and_other_steps_agree(critical):
    other = lock(1, ETA, effort=Effort(bits=128, order=24, steps=16))
    assert other.mu_lock.overlaps(critical.mu) and other.mu_lock.rad() < 1e-18 * other.mu_lock
    # The maximum is flat: a mu_lock that is moved by 1e-14 is another number nevertheless.
    assert not other.mu_lock.overlaps(critical.mu + arb("1e-14"))


@pytest.mark.slow
def test_a_lock_moved_by_1e_14_is_refused(critical, rod):
    system, mu = stationary(rod), critical.load.fx / critical.load.fy

    def claimed(by):
        """Claim that the critical state is within 1e-14 of a load with −tan α larger by this."""
        fx, fy, m0 = critical.load
        centre = arb_mat([[(fx + by * fy).mid()], [fy.mid()], [m0.mid()]])
        values, _ = system(centre)
        return examined(system, centre, values, arb_mat([[1e-14]] * 3))

    image, _ = claimed(0)
    assert (image[0, 0] / image[1, 0]).overlaps(mu)
    with pytest.raises(NotProvedError, match="Krawczyk"):
        claimed(1e-14)


def test_an_onset_is_no_critical_state(rod, curve):
    slip = prove(rod, inclined(arb("0.3")), load_at(curve, float(curve.onset([0.3])[0])))
    value, _ = turning(slip.load, shoot(rod.theta, slip.load, rod.steps, second=True))
    assert not value.contains(0)


def tube(rod, curve, x0, reach):
    return proved_tube(rod, Load(*map(arb, load_at(curve, x0))), arb(reach), arb(reach) / 8)


@pytest.mark.slow
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


def test_without_a_lock_there_is_nothing_to_prove():
    with pytest.raises(NotProvedError, match="no critical state is known"):
        lock(1, 0.15)


@pytest.mark.slow
def test_the_command_shows_mu_lock(monkeypatch):
    monkeypatch.setattr("vibrissa.proof.period.suitable", lambda theta: QUICK)
    result = CliRunner().invoke(app, "prove --theta 1 --eta 0.85".split())
    assert result.exit_code == 0, result.output
    shown = re.search(r"^mu_lock +(\S+) ± ", result.output, re.MULTILINE)
    assert shown[1].startswith("0.514501403494709624")
