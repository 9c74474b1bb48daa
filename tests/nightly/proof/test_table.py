"""What is proved of each row of a study's tables, and what is said where it is not."""

from decimal import Decimal

import pytest
from flint import arb

from validation.proof import NotProvedError, table
from validation.proof.flow import Effort
from validation.proof.table import (
    LOCKS,
    SELF_LOCKING,
    curve_enclosures,
    state_enclosures,
    whole_steps,
)
from vibrissa import solve_curve, solve_state

QUICK, TOO_LITTLE = Effort(96, 24, 12), Effort(64, 3, 2)
THETA, ETA, STEP = Decimal(2), Decimal("0.85"), Decimal("0.001")


class Covered:
    """A path that took no time: what follows from it is as a test says."""

    holds = True

    def slips_first(self, slip):
        return self.holds

    def locks(self, mu0):
        return self.holds

    def peaks_first(self, critical):
        return self.holds


@pytest.fixture
def paths(monkeypatch):
    """Take no time for paths."""
    monkeypatch.setattr(table, "path_of", lambda *arguments, **others: Covered())


def by_quantity(found, name):
    return {
        one.quantity: (float(one.midpoint), float(one.radius)) for one in found if one.table == name
    }


def test_every_column_is_that_of_the_curve(paths):
    found = curve_enclosures(THETA, ETA, [(Decimal("0.4"), STEP)], QUICK)
    curve = solve_curve(2.0, 0.85)
    x0_slip = float(curve.onset(0.4))
    n_steps = int(x0_slip / 0.001)
    states = {"init": 0.0, "slip": x0_slip, "last": n_steps * 0.001}
    at = {name: curve.state(x0) for name, x0 in states.items()}
    expected = {
        f"{column}_{name}": float(getattr(state, column))
        for name, state in at.items()
        for column in ("f", "phi1", "reaction_m")
    } | {
        "x0_slip": x0_slip,
        "n_steps": n_steps,
        "x0_max": n_steps * 0.001,
        "alpha_last": float(at["last"].alpha),
        "x1_init": curve.x1_init,
    }
    proved = by_quantity(found, "curves") | by_quantity(found, "stiction")
    assert {name: value for name, (value, _) in proved.items()} == pytest.approx(expected, abs=1e-9)
    assert all(0.0 < radius < 1e-9 for name, (_, radius) in proved.items() if name not in EXACT)
    assert all(proved[name][1] == 0.0 for name in EXACT)
    assert all(one.on_path and not one.note for one in found)
    assert {tuple(one.row) for one in found} == {("theta", "eta"), ("theta", "eta", "mu0", "dx0")}
    assert all(one.row["theta"] == THETA and one.row["eta"] == ETA for one in found)


EXACT = ("n_steps", "x0_max")


@pytest.mark.parametrize("holds", [True, False])
def test_only_a_path_proves_that_it_leads_there(paths, monkeypatch, holds):
    monkeypatch.setattr(Covered, "holds", holds)
    points = [(Decimal(mu0), STEP) for mu0 in ("0.2", "0.4", "0.6")]
    found = curve_enclosures(THETA, ETA, points, QUICK, lock=True)
    assert {one.on_path for one in found if one.table == "stiction"} == {holds}
    (locked,) = [one for one in found if one.note]
    assert locked.row["mu0"] == Decimal("0.6") and locked.quantity == ""
    assert locked.note == (LOCKS if holds else SELF_LOCKING)
    (critical,) = [one for one in found if one.quantity == "mu_lock"]
    assert critical.on_path == holds
    assert float(critical.midpoint) == pytest.approx(solve_curve(2.0, 0.85).mu_lock, abs=1e-9)


def test_what_is_not_proved_is_named_in_its_row(paths):
    points = [(Decimal("0.2"), STEP), (Decimal("0.4"), STEP)]
    found = curve_enclosures(THETA, ETA, points, TOO_LITTLE)
    assert [(one.table, one.row.get("mu0")) for one in found] == [
        ("curves", None),
        ("stiction", Decimal("0.2")),
        ("stiction", Decimal("0.4")),
    ]
    assert all(one.note and one.midpoint is None and not one.on_path for one in found)


def test_a_tip_that_lifts_off_has_no_critical_friction(paths):
    found = curve_enclosures(Decimal(1), Decimal("0.18"), [], QUICK, lock=True)
    assert [one.quantity for one in found] == ["x1_init", "f_init", "phi1_init", "reaction_m_init"]


def test_a_single_state_is_proved_or_named():
    found = state_enclosures("arch", THETA, ETA, Decimal("0.35"), QUICK)
    solved = solve_state(2.0, 0.85, 0.35)
    names = ("f", "alpha", "phi1", "reaction_m")
    assert {name: value for name, (value, _) in by_quantity(found, "states").items()} == (
        pytest.approx({name: getattr(solved, name) for name in names}, abs=1e-9)
    )
    assert all(one.row == {"state": "arch"} and not one.on_path for one in found)
    (named,) = state_enclosures("arch", THETA, ETA, Decimal("0.35"), TOO_LITTLE)
    assert named.note and named.row == {"state": "arch"} and named.table == "states"


def test_whole_steps_do_not_pass_the_onset():
    assert whole_steps(arb("0.0105", 1e-6), STEP) == 10
    assert whole_steps(arb("0.0005", 1e-6), STEP) == 0
    with pytest.raises(NotProvedError, match=r"a tie: a step of 0\.001 ends on the onset"):
        whole_steps(arb("0.01", 1e-9), STEP)
