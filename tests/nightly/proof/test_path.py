"""Paths from α = 0: tubes meet, signs are proved, an onset behind the maximum is not the first."""

from decimal import Decimal

import numpy as np
import pytest
from flint import arb

from validation.proof import NotProvedError
from validation.proof.equilibrium import Rod, inclined, prove
from validation.proof.flow import Load
from validation.proof.path import Path, proved_tube
from validation.proof.starting import load_at, path_of
from vibrissa import solve_curve

LOCK = 0.09236785  # x0 of the critical state at θ = 1, η = 0.85


@pytest.fixture(scope="module")
def curve():
    return solve_curve(1, 0.85)


@pytest.fixture(scope="module")
def rod():
    return Rod(theta=arb(1), eta=arb("0.85"), steps=12)


@pytest.fixture(scope="module")
def path(rod, curve):
    init = prove(rod, inclined(arb(0)), load_at(curve, 0.0))
    return path_of(Decimal(1), Decimal("0.85"), init, Decimal("0.1"))


def state(rod, curve, mu, x0):
    return prove(rod, inclined(arb(mu)), load_at(curve, x0))


def tube(rod, curve, x0, reach):
    return proved_tube(rod, Load(*map(arb, load_at(curve, x0))), arb(reach), arb(reach) / 8)


def test_an_onset_on_the_path_is_the_first(path, rod, curve):
    slip = state(rod, curve, "0.08", float(curve.onset([0.08])[0]))
    assert path.slips_first(slip)
    assert path.tubes[-1].rise < 0
    assert all(one.advance > 0 and one.rise > 0 for one in path.tubes if one.mu < 0.1)
    # −tan α of the tubes holds those of the states in them.
    (there,) = [one for one in path.tubes if one.holds(slip.load)][:1]
    assert there.mu.contains(slip.mu)


def test_a_state_beside_the_path_is_not_on_it(path, rod, curve):
    slip = state(rod, curve, "0.08", float(curve.onset([0.08])[0]))
    load = slip.load._replace(fy=slip.load.fy + 1)
    assert not any(one.holds(load) for one in path.tubes)
    # A path with a gap proves nothing beyond it.
    assert not Path(tubes=path.tubes[-1:]).slips_first(slip)


def test_neighbours_meet_and_others_do_not(path):
    first, second, third, *_ = path.tubes
    assert first.meets(second) and second.meets(third)
    assert not first.meets(third)


def test_an_onset_that_tubes_do_not_reach_is_not_proved(path, rod, curve):
    slip = state(rod, curve, "0.45", float(curve.onset([0.45])[0]))
    assert not Path(tubes=path.tubes[:3]).slips_first(slip)


def test_a_second_onset_behind_the_maximum_is_not_the_first(rod, curve):
    """−tan α reaches 0.513 twice; the second time it falls: the path has a fold in μ there."""
    behind = 2 * LOCK - float(curve.onset([0.513])[0])
    slip = state(rod, curve, "0.513", behind)
    middle = Load(*(value.mid() for value in slip.load))
    there = proved_tube(rod, middle, arb(2) ** -10, arb(2) ** -12)
    assert there.holds(slip.load) and there.rise < 0 and there.advance > 0
    assert not Path(tubes=[there]).slips_first(slip)


def test_a_tube_over_the_maximum_neither_rises_nor_falls(rod, curve):
    over = tube(rod, curve, LOCK, 0.02)
    assert not over.rise > 0 and not over.rise < 0
    assert over.mu.contains(arb("0.5145014034947"))
    at = state(rod, curve, "0.51", float(curve.onset([0.51])[0]))
    assert not Path(tubes=[over]).slips_first(at)


def test_locking_needs_the_maximum_below_mu0(rod, curve):
    before, behind = (tube(rod, curve, LOCK + step, 0.01) for step in (-0.02, 0.02))
    over = tube(rod, curve, LOCK, 0.02)
    assert Path(tubes=[before, over, behind]).locks(arb("0.52"))
    assert not Path(tubes=[before, over, behind]).locks(arb("0.513"))
    assert not Path(tubes=[before, over]).locks(arb("0.52"))


def test_a_tube_that_is_too_long_is_refused(rod, curve):
    with pytest.raises(NotProvedError):
        tube(rod, curve, 0.02, 1.0)


def test_a_fold_of_the_path_is_not_proved_as_a_path_without(rod, curve):
    """Behind the maximum fx has an extremum: there two equilibria with the same fx meet."""
    x0 = np.linspace(LOCK, 0.4, 400)
    fold = x0[np.argmin(curve.state(x0).reaction_fx)]
    assert LOCK < fold < 0.39
    for reach in (2.0**-4, 2.0**-8, 2.0**-12):
        with pytest.raises(NotProvedError):
            tube(rod, curve, float(fold), reach)
    # Beside the fold there is one.
    assert tube(rod, curve, float(fold) - 0.05, 2.0**-8).rise < 0


class Piece:
    """A tube of which only what is proved of it is known."""

    def __init__(self, rise, advance=1, mu=0.3, bend=None, holds=False):
        self.rise, self.advance, self.mu, self.bend, self._holds = rise, advance, mu, bend, holds

    def holds(self, load):
        return self._holds


UP, DOWN, HERE = Piece(1), Piece(-1), Piece(1, holds=True)
# Where the sign of the rise is open, and that of its change is proved or not.
TOP, TURNED, FLAT = Piece(0, bend=1), Piece(0, bend=-1), Piece(0, bend=0)
TOP_HERE = Piece(0, bend=1, holds=True)
BACK = Piece(1, advance=0)


class State:
    load = None


@pytest.mark.parametrize(
    ("tubes", "proved"),
    [
        ([UP, HERE], True),
        ([HERE, DOWN], True),
        ([UP, UP], False),
        ([DOWN, HERE], False),
        ([TOP, HERE], False),
        ([BACK, HERE], False),
        ([Piece(1, advance=-1), HERE], False),
        ([Piece(0, holds=True)], False),
        ([], False),
    ],
)
def test_an_onset_is_the_first_if_all_before_it_rises(tubes, proved):
    assert Path(tubes=tubes).slips_first(State()) is proved


@pytest.mark.parametrize(
    ("tubes", "proved"),
    [
        ([UP, TOP, DOWN], True),
        ([UP, Piece(0, mu=0.5), DOWN], False),
        ([UP, Piece(0, mu=0.4), DOWN], False),
        ([UP, DOWN, Piece(1, mu=9)], True),
        ([BACK, DOWN], False),
        ([UP, TOP], False),
        ([], False),
    ],
)
def test_a_tip_locks_if_all_up_to_the_fall_needs_less(tubes, proved):
    assert Path(tubes=tubes).locks(0.4) is proved


@pytest.mark.parametrize(
    ("tubes", "proved"),
    [
        ([UP, TOP_HERE, DOWN], True),
        ([UP, TOP, TOP_HERE, DOWN], True),
        ([UP, TOP_HERE, TOP, DOWN], True),
        ([UP, Piece(0, bend=-1, holds=True), TURNED, DOWN], True),
        ([UP, TOP_HERE, TURNED, DOWN], False),
        ([UP, TURNED, TOP_HERE, DOWN], False),
        ([UP, TOP_HERE, FLAT, DOWN], False),
        ([UP, TOP, DOWN], False),
        ([UP, HERE, DOWN], False),
        ([UP, Piece(0, advance=0, bend=1, holds=True), DOWN], False),
        ([UP, TOP_HERE], False),
        ([], False),
    ],
)
def test_a_maximum_is_the_first_if_the_rise_changes_its_sign_once(tubes, proved):
    assert Path(tubes=tubes).peaks_first(State()) is proved
