"""A small study is proved, with the steps of its scans; what is not proved is named."""

import csv
from decimal import Decimal

import pytest
from flint import arb

from validation.proof import NotProvedError, rows
from validation.proof import study as proof_of_study
from validation.proof.flow import Effort
from validation.proof.rows import LOCKS, SELF_LOCKING, rod_lines, state_lines, whole_steps
from vibrissa import solve_curve, solve_state

QUICK, TOO_LITTLE = Effort(96, 24, 12), Effort(64, 3, 2)
THETA, ETA, STEP = Decimal(2), Decimal("0.85"), Decimal("0.001")
STUDY = """
study: tiny
grids:
  one: {theta: [1], mu0: [0.02, 0.6], eta: [0.85], dx0: [0.0001]}
scans:
  run: {theta: [1], mu0: [0.02], eta: [0.85], dx0: [0.0001], cycles: 2}
states:
  arch: {theta: 1, eta: 0.85, x1: 0.4}
"""


@pytest.fixture
def prove(tmp_path, monkeypatch):
    """Prove a study; return the exit status and the lines by row and quantity."""
    monkeypatch.setattr(proof_of_study, "suitable", lambda theta: QUICK)

    def proved(text):
        study, output = tmp_path / "tiny.yaml", tmp_path / "enclosures.csv"
        study.write_text(text)
        options = ["--configfile", str(study), "--output", str(output), "--jobs", "1"]
        status = proof_of_study.main(options)
        if not output.exists():
            return status, {}
        with output.open() as file:
            lines = list(csv.DictReader(file))
        keys = [(line["table"], line["mu0"], line["cycle"], line["quantity"]) for line in lines]
        return status, dict(zip(keys, lines, strict=True))

    return proved


def test_a_study_is_proved(prove, capsys):
    status, lines = prove(STUDY)
    assert status == 0
    assert "\n33 numbers in 5 rows are proved" in capsys.readouterr().out
    assert {line["on_path"] for key, line in lines.items() if key[0] != "states"} == {"yes"}
    lock = Decimal(lines["curves", "", "", "mu_lock"]["midpoint"])
    assert abs(lock - Decimal("0.5145014034947096245")) < Decimal("1e-18")
    assert lines["stiction", "0.6", "", ""]["note"] == LOCKS
    assert lines["stiction", "0.02", "", "n_steps"]["midpoint"] == "3"
    assert lines["stiction", "0.02", "", "n_steps"]["steps"] == "12"
    # Scans follow: three steps, and the tip slips at the fourth.
    cycle = {
        name: Decimal(lines["scans", "0.02", "2", name]["midpoint"])
        for name in ("steps", "slips", "footpoint_end", "x0_largest", "x1_begin", "x1_end")
    }
    first = Decimal(lines["curves", "", "", "x1_init"]["midpoint"])
    assert list(cycle.values()) == [
        4,
        1,
        Decimal("0.0008"),
        Decimal("0.0003"),
        first + Decimal("0.0004"),
        first + Decimal("0.0008"),
    ]


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        (STUDY + "contact: line\n", "only tip contact"),
        (
            STUDY.replace("dx0: [0.0001]", "dx0: [0.0001], clamp_angle: [0.1]"),
            "only the ideal mounting is proved",
        ),
    ],
)
def test_a_study_of_other_rods_is_refused(prove, capsys, text, reason):
    assert prove(text) == (2, {})
    assert reason in capsys.readouterr().err


class Covered:
    """A path that took no time: what follows from it is as a test says."""

    holds = True

    def slips_first(self, *states):
        return self.holds

    def locks(self, mu0):
        return self.holds

    def peaks_first(self, critical):
        return self.holds


@pytest.fixture
def paths(monkeypatch):
    """Take no time for paths."""
    monkeypatch.setattr(rows, "path_of", lambda *arguments: Covered())


def numbers(lines):
    return {
        one["quantity"]: (float(one["midpoint"]), float(one["radius"]))
        for one in lines
        if "quantity" in one
    }


def test_every_column_is_that_of_the_curve(paths):
    found = numbers(rod_lines(THETA, ETA, [(Decimal("0.4"), STEP)], QUICK))
    curve = solve_curve(2.0, 0.85)
    x0_slip = float(curve.onset(0.4))
    n_steps = int(x0_slip / 0.001)
    at = {
        "init": curve.state(0.0),
        "slip": curve.state(x0_slip),
        "last": curve.state(n_steps / 1e3),
    }
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
        "mu_lock": curve.mu_lock,
    }
    assert {name: value for name, (value, _) in found.items()} == pytest.approx(expected, abs=1e-9)
    exact = {name for name, (_, radius) in found.items() if radius == 0.0}
    assert exact == {"n_steps", "x0_max"}
    assert all(radius < 1e-9 for _, radius in found.values())


@pytest.mark.parametrize("holds", [True, False])
def test_only_a_path_proves_that_it_leads_there(paths, monkeypatch, holds):
    monkeypatch.setattr(Covered, "holds", holds)
    points = [(Decimal(mu0), STEP) for mu0 in ("0.2", "0.6")]
    answer, found = "yes" if holds else "no", list(rod_lines(THETA, ETA, points, QUICK))
    assert {one["on_path"] for one in found if one["table"] == "stiction"} == {answer}
    (locked,) = [one for one in found if "note" in one]
    assert locked["mu0"] == "0.6" and "quantity" not in locked
    assert locked["note"] == (LOCKS if holds else SELF_LOCKING)
    assert [one["on_path"] for one in found if one.get("quantity") == "mu_lock"] == [answer]


def test_what_is_not_proved_is_named_in_its_row(paths):
    points = [(Decimal("0.2"), STEP), (Decimal("0.4"), STEP)]
    found = list(rod_lines(THETA, ETA, points, TOO_LITTLE))
    rows_of = [(one["table"], one.get("mu0")) for one in found]
    assert rows_of == [("curves", None), ("stiction", "0.2"), ("stiction", "0.4")]
    assert all(one["note"] and "midpoint" not in one and one["on_path"] == "no" for one in found)


def test_a_tip_that_lifts_off_has_no_critical_friction(paths):
    found = numbers(rod_lines(Decimal(1), Decimal("0.18"), [], QUICK))
    assert list(found) == ["x1_init", "f_init", "phi1_init", "reaction_m_init"]


def test_a_single_state_is_proved_or_named():
    found = numbers(state_lines("arch", THETA, ETA, Decimal("0.35"), QUICK))
    solved = solve_state(2.0, 0.85, 0.35)
    names = ("f", "alpha", "phi1", "reaction_m")
    assert {name: value for name, (value, _) in found.items()} == (
        pytest.approx({name: getattr(solved, name) for name in names}, abs=1e-9)
    )
    (named,) = state_lines("arch", THETA, ETA, Decimal("0.35"), TOO_LITTLE)
    assert named["note"] and named["state"] == "arch" and named["table"] == "states"


def test_whole_steps_do_not_pass_the_onset():
    assert whole_steps(arb("0.0105", 1e-6), STEP) == 10
    assert whole_steps(arb("0.0005", 1e-6), STEP) == 0
    with pytest.raises(NotProvedError, match=r"a tie: a step of 0\.001 ends on the onset"):
        whole_steps(arb("0.01", 1e-9), STEP)
