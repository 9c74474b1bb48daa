"""The command that designs a rod."""

import re

import pytest
from typer.testing import CliRunner

from vibrissa.cli.app import app


def run(*arguments):
    return CliRunner().invoke(app, ["design", *(str(argument) for argument in arguments)])


NANO = ["--transducer", "nano17-si-12-0.12", "--step", "50 um", "--mu0", "0.2 to 0.4"]
SHAPE = ["--theta", "2", "--eta", "0.85"]


def test_the_rod_of_the_paper_on_the_command_line():
    size = ["--diameter", "5 mm", "--length", "100 mm"]
    result = run("--material", "steel-s235", *NANO, *SHAPE, *size)
    assert result.exit_code == 1
    assert result.output.startswith("this rod cannot be used: it violates the constraints moment_z")
    assert re.search(r"strain +0\.0363 +< 0\.000746 +48\.[67] times", result.output)
    assert re.search(r"force_y +1\.47e\+03 N", result.output)


@pytest.mark.slow
def test_a_search_on_the_command_line(tmp_path):
    rod = tmp_path / "rod.toml"
    where = ["--length", "100 mm, 150 mm", "--eta", "0.85, 0.87", "--theta", "1, 2"]
    result = run("--material", "music-wire", *NANO, *where, "-o", rod)
    assert result.exit_code == 0, result.output
    assert re.search(r", length 1[05]0 mm$", result.output, re.M)
    assert rod.read_text(encoding="utf-8").startswith("# vibrissa design: the best of ")
    solved = CliRunner().invoke(app, ["solve", "--rod", str(rod), "--mu0", "0.3"])
    assert solved.exit_code == 0 and solved.stderr == ""


def test_a_rod_that_violates_constraints_is_not_written(tmp_path):
    size, path = ["--diameter", "5 mm", "--length", "100 mm"], tmp_path / "rod.toml"
    result = run("--material", "steel-s235", *NANO, *SHAPE, *size, "-o", path)
    assert result.stdout.startswith("this rod cannot be used")
    assert result.exit_code == 1 and not path.exists()
    assert f"{path} is not written: the rod violates constraints\n" in result.stderr


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([*NANO, "--material", "music-wire", "--rod", "no.toml"], "No such file"),
        ([*NANO, "--material", "music-wire", "--safety", "x"], "safety must be a number, got 'x'"),
        ([*NANO, "--material", "music-wire", "-o", "d.txt"], "ending must be"),
        ([*NANO, "--material", "music-wire", "-o", "d.csv"], "the ending must be .toml"),
    ],
)
def test_mistakes_get_one_line(arguments, message, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    result = run(*arguments)
    assert result.exit_code == 2, result.output
    assert message in result.output
    assert result.output.startswith("vibrissa: ") and result.output.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_a_weak_material_is_named_and_impossible_heights_do_not_stop_the_ratio(tmp_path):
    rod = ["--modulus", "210 GPa", "--diameter", "0.7 mm", "--length", "100 mm", *SHAPE]
    asked = ["--mu0", "0.3", "--step", "100 um", "--to", "10 mm", "-o", str(tmp_path / "a.csv")]
    weak = CliRunner().invoke(app, ["scan", *rod, "--material", "steel-s235", *asked])
    assert weak.exit_code == 0 and "structural steel S235 is elastic" in weak.stderr
    # These positions lead to heights below 0: the ratio of the forces does not need them.
    below = [*rod, "--method", "ratio", "--eta", "5 mm", "--stage-angle", "60 deg"]
    asked = ["identify", str(tmp_path / "a.csv"), "--noise", "3 mN, 3 mN, 10 uN*m", *below]
    assert CliRunner().invoke(app, [*asked, "-o", str(tmp_path / "b.csv")]).exit_code == 0
