"""A small study is proved, with the steps of its scans."""

from decimal import Decimal
from pathlib import Path

import pytest

from validation.proof import study as proof_of_study
from validation.proof.flow import Effort
from validation.proof.starting import path_of

STUDY = """
study: tiny
grids:
  one: {theta: [1], mu0: [0.02], eta: [0.85], dx0: [0.0001]}
scans:
  run: {theta: [1], mu0: [0.02], eta: [0.85], dx0: [0.0001], cycles: 2}
states:
  arch: {theta: 1, eta: 0.85, x1: 0.4}
"""


def short_path(theta, eta, init, beyond, over):
    """A path that ends before −tan α has its maximum, where it would take long to go."""
    return path_of(theta, eta, init, beyond=beyond)


@pytest.fixture
def study(tmp_path, monkeypatch):
    monkeypatch.setattr(proof_of_study, "suitable", lambda theta: Effort(96, 24, 12))
    monkeypatch.setattr("validation.proof.table.path_of", short_path)
    path = tmp_path / "tiny.yaml"
    path.write_text(STUDY)
    output = tmp_path / "enclosures.csv"
    arguments = ["--configfile", str(path), "--output", str(output), "--jobs", "1"]
    return output, arguments


def test_a_study_is_proved(study, capsys):
    output, arguments = study
    # All numbers are proved, but not that mu_lock is the first maximum: the path ends before.
    assert proof_of_study.main(arguments) == 1
    said = capsys.readouterr().out
    assert "33 numbers in 5 rows are proved" in said
    assert "4 rows are on their path, 1 are not proved" in said
    text = output.read_text()
    (line,) = [one for one in text.splitlines() if ",mu_lock," in one]
    assert line.startswith("curves,0.85,1,,,,,,mu_lock,0.5145014034947096245") and ",no,," in line
    # Scans follow: three steps, and the tip slips at the fourth.
    cycle = "scans,0.85,1,0.02,0.0001,,run,2,"
    for number in ("steps,4,0", "slips,1,0", "footpoint_end,0.0008,0", "x0_largest,0.0003,0"):
        assert f"{cycle}{number},yes,," in text
    x1_init, x1_end = (
        next(Decimal(one.split(",")[9]) for one in text.splitlines() if one.startswith(begin))
        for begin in ("curves,0.85,1,,,,,,x1_init,", f"{cycle}x1_end,")
    )
    assert x1_end - x1_init == Decimal("0.0008")
    assert "stiction,0.85,1,0.02,0.0001,,,,n_steps,3,0,yes,,96,24,12\n" in text


def line(midpoint, radius, **others):
    return {
        "table": "curves",
        "quantity": "x",
        "midpoint": midpoint,
        "radius": radius,
        "note": "",
        "on_path": "yes",
    } | others


def test_two_proofs_of_a_number_must_overlap():
    one = line("0.123456", "2E-6")
    assert proof_of_study.apart([one], [line("0.123459", "1E-6")]) == []
    assert proof_of_study.apart([one], [line("0.123460", "1E-6")]) == [one]
    # What only one of them has is apart, too, and a tip that locks must lock in both.
    assert proof_of_study.apart([one], []) == [one]
    locks = line("", "", note="locks")
    assert proof_of_study.apart([locks], [locks]) == []
    assert proof_of_study.apart([locks], [locks | {"on_path": "no"}]) == [locks]


def test_a_study_in_line_contact_is_refused(study, capsys):
    _, arguments = study
    path = Path(arguments[1])
    path.write_text(STUDY + "contact: line\n")
    assert proof_of_study.main(arguments) == 2
    assert "only tip contact" in capsys.readouterr().err


def test_a_study_of_mounted_rods_is_refused(study, capsys):
    _, arguments = study
    path = Path(arguments[1])
    path.write_text(STUDY.replace("dx0: [0.0001]", "dx0: [0.0001], clamp_angle: [0.1]"))
    assert proof_of_study.main(arguments) == 2
    assert "only the ideal mounting is proved" in capsys.readouterr().err
