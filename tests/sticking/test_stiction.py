"""Reading periods of sticking off a curve."""

from decimal import Decimal
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vibrissa import Status, solve_curve
from vibrissa.sticking.curve import failed_curve
from vibrissa.sticking.periods import read_curve, read_curves
from vibrissa.sticking.piece import StickingState
from vibrissa.sticking.solving import shooting

D = Decimal


@pytest.fixture(scope="module")
def curve():
    return solve_curve(2.0, 0.85)


def read(curve, mu0, dx0):
    return read_curve(curve, [D(mu0)], [D(dx0)])


@settings(max_examples=60, deadline=None)
@given(st.floats(0.001, 0.477), st.decimals("0.00005", "0.2", places=5))
def test_last_step_sticks_and_the_next_one_slips(curve, mu0, dx0):
    mu0 = D(repr(mu0))
    stiction = read_curve(curve, [mu0], [dx0])
    n, onset = int(stiction.n_steps[0]), Fraction(float(stiction.x0_slip[0]))
    # Displacements of the step grid are doubles: half a unit in the last place either way.
    slack = Fraction(np.spacing(float(onset)))
    assert n * Fraction(dx0) <= onset + slack
    assert (n + 1) * Fraction(dx0) > onset - slack
    assert curve.mobilised_friction(stiction.x0_max[0]) <= float(mu0) + 1e-13


def test_states_belong_to_their_displacements(curve):
    stiction = read(curve, "0.4", "0.001")
    assert stiction.init.alpha[0] == pytest.approx(0.0, abs=1e-13)
    assert stiction.last.x0[0] == stiction.x0_max[0]
    assert -np.tan(stiction.slip.alpha[0]) == pytest.approx(0.4, abs=1e-13)
    assert stiction.slip.f[0] == pytest.approx(
        np.hypot(stiction.slip.reaction_fx[0], stiction.slip.reaction_fy[0])
    )


def test_locking_has_no_last_state(curve):
    stiction = read(curve, "0.48", "0.001")
    assert stiction.status == [Status.LOCK]
    for missing in (stiction.x0_slip, stiction.x0_max, stiction.n_steps, stiction.slip.f):
        assert np.isnan(missing[0])
    assert np.isfinite(stiction.init.f[0])


def test_step_longer_than_the_period_slips_at_once(curve):
    stiction = read(curve, "0.1", "0.01")
    assert stiction.n_steps[0] == 0 and stiction.x0_max[0] == 0.0
    assert stiction.last.f[0] == stiction.init.f[0]


def test_penetration_starts_where_the_slope_changes_sign():
    curve = solve_curve(3.0, 0.85)
    at = float(curve.mobilised_friction(curve.x0_touch))
    before, after = D(repr(round(at - 0.001, 6))), D(repr(round(at + 0.001, 6)))
    fine = D("0.00001")
    assert read_curve(curve, [before, after], [fine, fine]).penetrates.tolist() == [False, True]


def test_penetration_from_the_first_state():
    assert read(solve_curve(3.0, 0.7), "0.01", "0.1").penetrates[0]


def test_failed_curve_gives_failed_points():
    failed = failed_curve(theta=1.0, eta=0.5, method="collocation", message="why")
    stiction = read(failed, "0.3", "0.001")
    assert stiction.status == [Status.FAILED]
    assert (stiction.contact, stiction.end) == ([""], [""]) and not stiction.penetrates[0]
    assert np.isnan(stiction.init.f[0]) and np.isnan(stiction.x0_slip[0])


@pytest.fixture(scope="module")
def several():
    """Curves of all kinds: pulled, in pieces, past the lock, stepped, cut off, without states."""
    round_rods = [solve_curve(2.0, 0.85), solve_curve(5.0, 0.85, contact="line")]
    planar = [solve_curve(theta, 0.7, section="planar") for theta in (1.0, 3.0)]
    stepped = shooting.solve_curve(2.0, 0.85, 0.005, shooting.PAPER)
    crosses = solve_curve(2.0, 0.15, section="planar")
    failed = failed_curve(theta=1.0, eta=0.5, method="collocation", message="why")
    return [failed, *round_rods, crosses, *planar, stepped, failed]


def bits(stiction, rows):
    """Everything that was read of some periods, to the last bit."""
    for name, values in vars(stiction).items():
        if isinstance(values, list):
            yield name, values[rows]
            continue
        columns = values.columns if isinstance(values, StickingState) else {"": values}
        yield from ((name + column, some[rows].tobytes()) for column, some in columns.items())


@pytest.mark.slow
def test_a_period_is_the_same_whatever_is_read_with_it(several):
    mu0 = [D(k) / 40 for k in (13, 1, 7, 19, 18, 250, 30, 20)]
    dx0 = [D("0.001"), D("0.0007")] * 4
    counts = [3, 8, 5, 8, 8, 8, 8, 1]
    pairs = [(mu0[:count], dx0[:count]) for count in counts]
    numbers = [np.array(mu0[:count], dtype=float) for count in counts]
    together = read_curves(several, numbers, [dx0[:count] for count in counts])
    row = 0
    for curve, frictions, steps in zip(several, *zip(*pairs, strict=True), strict=True):
        by_itself = read_curve(curve, frictions, steps)
        rows = slice(row, row + len(frictions))
        assert dict(bits(together, rows)) == dict(bits(by_itself, slice(None)))
        for one in range(len(frictions)):
            alone = read_curve(curve, frictions[one : one + 1], steps[one : one + 1])
            assert dict(bits(by_itself, slice(one, one + 1))) == dict(bits(alone, slice(None)))
        row = rows.stop
    assert {*together.status} == {Status.SLIP, Status.LOCK, Status.FAILED, Status.OUT_OF_REACH}
