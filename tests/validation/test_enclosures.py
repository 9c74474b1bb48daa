"""A small study is proved, once, and `make check` believes no other number."""

from decimal import Decimal
from pathlib import Path

import pytest

from validation import enclosures, proof_sample
from vibrissa.outcomes import Contact
from vibrissa.proof import Effort
from vibrissa.proof.starting import path_of

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
    monkeypatch.setattr(enclosures, "suitable", lambda theta: Effort(96, 24, 12))
    monkeypatch.setattr("vibrissa.proof.table.path_of", short_path)
    path = tmp_path / "tiny.yaml"
    path.write_text(STUDY)
    output = tmp_path / "enclosures.csv"
    arguments = ["--configfile", str(path), "--output", str(output), "--jobs", "1"]
    return output, arguments


@pytest.mark.slow
def test_a_study_is_proved_once(study, capsys, monkeypatch):
    output, arguments = study
    # All numbers are proved, but not that mu_lock is the first maximum: the path ends before.
    assert enclosures.main(arguments) == 1
    said = capsys.readouterr().out
    assert "33 numbers in 5 rows are proved" in said
    assert "4 rows are on their path, 1 are not proved to be" in said
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
    assert "stiction,0.85,1,0.02,0.0001,,,,n_steps,3,0,yes,,96,24,12," in text
    # All is there: nothing is proved again.
    monkeypatch.delattr(enclosures, "ProcessPoolExecutor")
    monkeypatch.setattr(enclosures, "ProcessPoolExecutor", Idle, raising=False)
    assert enclosures.main(arguments) == 1
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


@pytest.mark.slow
def test_a_random_point_far_from_the_paper_is_proved(monkeypatch):
    monkeypatch.setattr("vibrissa.proof.period.suitable", lambda theta: Effort(96, 20, 24))
    found = proof_sample.tried(proof_sample.anywhere(1))
    assert found.radius is not None and found.radius < Decimal("1e-10")
    assert found.off < proof_sample.AGREES and found.bent_once
    assert (found.contact, found.kinds) == ("line", "point to point")


def test_a_point_that_cannot_be_proved_is_named(monkeypatch):
    monkeypatch.setattr("vibrissa.proof.period.suitable", lambda theta: Effort(64, 3, 2))
    found = proof_sample.tried(proof_sample.anywhere(1))
    assert found.radius is None and found.note and found.point.startswith("line, theta ")


def test_points_of_a_study_are_drawn_and_a_locked_tip_is_named(tmp_path):
    path = tmp_path / "line.yaml"
    path.write_text(STUDY.replace("mu0: [0.02]", "mu0: [1.2, 1.3]", 1) + "contact: line\n")
    places = proof_sample.of_study(path, 5, seed=1)
    assert {(place.contact, place.mu0) for place in places} == {
        ("line", Decimal("1.2")),
        ("line", Decimal("1.3")),
    }
    assert proof_sample.tried(places[0]).note == proof_sample.SELF_LOCKING


def test_the_sample_is_counted_by_what_became_of_it():
    common = {"point": "p", "seconds": 1.0}
    every = [
        proof_sample.Tried(
            contact=Contact.LINE, kinds="point to line", radius=Decimal(1), **common
        ),
        proof_sample.Tried(contact=Contact.POINT, note="no lock: it lifts off", **common),
        proof_sample.Tried(contact=Contact.POINT, note="no lock: it dips", **common),
    ]
    assert list(proof_sample.table(every)) == [
        "|  | point | line |",
        "| --- | --- | --- |",
        "| proved, point to line | 0 | 1 |",
        "| not proved: no lock | 2 | 0 |",
    ]
    assert next(proof_sample.summary(every)) == "1 of 3 points are proved"


def test_a_study_in_line_contact_is_refused(study, capsys):
    _, arguments = study
    path = Path(arguments[1])
    path.write_text(STUDY + "contact: line\n")
    assert enclosures.main(arguments) == 2
    assert "only tip contact" in capsys.readouterr().err


def test_a_study_of_mounted_rods_is_refused(study, capsys):
    _, arguments = study
    path = Path(arguments[1])
    path.write_text(STUDY.replace("dx0: [0.0001]", "dx0: [0.0001], clamp_angle: [0.1]"))
    assert enclosures.main(arguments) == 2
    assert "only the ideal mounting is proved" in capsys.readouterr().err
