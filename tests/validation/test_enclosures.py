"""`make proof`: a small study is proved, once, and `make check` believes no other number."""

from decimal import Decimal
from pathlib import Path

import enclosures
import proof_sample
import pytest

from vibrissa.proof import Effort

STUDY = """
study: tiny
grids:
  one: {theta: [1], mu0: [0.02], eta: [0.85], dx0: [0.0001]}
states:
  arch: {theta: 1, eta: 0.85, x1: 0.4}
"""


@pytest.fixture
def study(tmp_path, monkeypatch):
    monkeypatch.setattr(enclosures, "suitable", lambda theta: Effort(96, 24, 12))
    path = tmp_path / "tiny.yaml"
    path.write_text(STUDY)
    output = tmp_path / "enclosures.csv"
    arguments = ["--configfile", str(path), "--output", str(output), "--jobs", "1"]
    return output, arguments


def test_a_study_is_proved_once(study, capsys, monkeypatch):
    output, arguments = study
    assert enclosures.main(arguments) == 0
    said = capsys.readouterr().out
    assert "18 numbers in 3 rows are proved" in said
    assert "2 rows are on their path, 0 are not proved to be" in said
    text = output.read_text()
    assert "stiction,0.85,1,0.02,0.0001,,n_steps,3,0,yes,,96,24,12," in text
    # All is there: nothing is proved again.
    monkeypatch.delattr(enclosures, "ProcessPoolExecutor")
    monkeypatch.setattr(enclosures, "ProcessPoolExecutor", Idle, raising=False)
    assert enclosures.main(arguments) == 0
    assert output.read_text() == text


class Idle:
    """A pool that takes no jobs."""

    def __init__(self, processes):
        pass

    def __enter__(self):
        return self

    def __exit__(self, *error):
        pass


def test_what_other_code_has_proved_is_proved_again(study, monkeypatch):
    output, arguments = study
    output.write_text("table,code\nstiction,000000000000\n")
    monkeypatch.setattr(enclosures, "ProcessPoolExecutor", Idle)
    with pytest.raises(AttributeError):
        enclosures.main(arguments)


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
    assert enclosures.apart([one], [line("0.123459", "1E-6")]) == []
    assert enclosures.apart([one], [line("0.123460", "1E-6")]) == [one]
    # What only one of them has is apart, too, and a tip that locks must lock in both.
    assert enclosures.apart([one], []) == [one]
    locks = line("", "", note="locks")
    assert enclosures.apart([locks], [locks]) == []
    assert enclosures.apart([locks], [locks | {"on_path": "no"}]) == [locks]


def test_a_random_point_far_from_the_paper_is_proved(monkeypatch):
    monkeypatch.setattr("vibrissa.proof.period.suitable", lambda theta: Effort(96, 20, 24))
    found = proof_sample.tried(1)
    assert found.radius is not None and found.radius < Decimal("1e-10")
    assert found.off < proof_sample.AGREES and found.bent_once


def test_a_point_that_cannot_be_proved_is_named(monkeypatch):
    monkeypatch.setattr("vibrissa.proof.period.suitable", lambda theta: Effort(64, 3, 2))
    found = proof_sample.tried(1)
    assert found.radius is None and found.note and found.point.startswith("theta ")


def test_a_study_in_line_contact_is_refused(study, capsys):
    _, arguments = study
    path = Path(arguments[1])
    path.write_text(STUDY + "contact: line\n")
    assert enclosures.main(arguments) == 2
    assert "only tip contact" in capsys.readouterr().err
