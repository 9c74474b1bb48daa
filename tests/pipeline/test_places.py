"""Files beside a study: those of the working directory, or else of the workflow."""

from vibrissa.pipeline import places


def test_proofs_are_those_beside_the_reference_tables(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (own,) = places.proofs("paper")
    assert own == str(places.HOME / "tests/regression/paper/enclosures.csv")
    assert places.proofs("mine") == []
    folder = tmp_path / "tests/regression/mine"
    folder.mkdir(parents=True)
    assert places.proofs("mine") == []
    (folder / "enclosures.csv").touch()
    assert places.proofs("mine") == ["tests/regression/mine/enclosures.csv"]
