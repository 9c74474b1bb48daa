"""`make proof`: a small study is proved, once, and `make check` believes no other number."""

from pathlib import Path

import enclosures
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


def test_a_study_in_line_contact_is_refused(study, capsys):
    _, arguments = study
    path = Path(arguments[1])
    path.write_text(STUDY + "contact: line\n")
    assert enclosures.main(arguments) == 2
    assert "only tip contact" in capsys.readouterr().err
