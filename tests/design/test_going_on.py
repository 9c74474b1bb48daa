"""The rod file of a design, with which the other commands go on."""

import tomllib
from dataclasses import replace

import pytest
from typer.testing import CliRunner

from vibrissa.cli import design as command
from vibrissa.cli.app import app
from vibrissa.design import DesignStatus, design, read_requirements
from vibrissa.design.reading import with_rod_file
from vibrissa.design.result import Design
from vibrissa.sensor.given import rod_file
from vibrissa.sensor.given.rod_file import RodFile

ASKED = {"step": "50 um", "mu0": "0.2 to 0.35"}
WIRE = """
theta = 1.2
eta = "158.4 ± 0.2 mm"
diameter = "1 mm ± 0.5 %"
length = "180 mm"
contact = "line"
material = "music-wire"
modulus = "205 ± 4 GPa"
transducer = "nano17-si-12-0.12"
section = "planar"
clamp_angle = "0 ± 0.2 deg"
"""


@pytest.fixture(scope="module")
def wire(tmp_path_factory):
    """Requirements from a rod file, of a rod with all its sizes, and the file."""
    path = tmp_path_factory.mktemp("wire") / "wire.toml"
    path.write_text(WIRE, encoding="utf-8")
    return read_requirements(**with_rod_file(path, ASKED)), path


def written(found, folder):
    path = folder / "rod.toml"
    rod_file.write(path, found.rod_file(), "a rod, 5 µm off")
    return path


def run_design(rod, output):
    """The command, of which a test replaces what takes long."""
    asked = [part for name, value in ASKED.items() for part in (f"--{name}", value)]
    return CliRunner().invoke(app, ["design", *asked, "--rod", str(rod), "-o", str(output)])


def test_what_was_given_is_in_the_rod_file_of_the_result(wire, tmp_path):
    requirements, given = wire
    found = design(requirements)
    assert found.status is DesignStatus.FOUND
    path = written(found, tmp_path)
    assert path.read_text(encoding="utf-8").startswith("# a rod, 5 µm off\n")
    before, after = RodFile.read(given), RodFile.read(path)
    assert after.reading == before.reading
    assert after.material == {"material": "music-wire", "density": "7800 kg/m^3"}
    for name in ("contact", "section", "rod", "mounting", "tolerances"):
        assert getattr(after.whisker, name) == getattr(before.whisker, name)
    assert after.whisker.theta == 1.2 and after.whisker.eta == pytest.approx(0.88, rel=1e-12)
    # And designed again it is the same rod.
    again = design(read_requirements(**with_rod_file(path, ASKED)))
    assert again.rod_file() == found.rod_file()
    assert again.deviation == pytest.approx(found.deviation, rel=1e-12)


def test_sizes_that_were_found_are_in_the_rod_file():
    asked = read_requirements(**ASKED, material="nitinol", transducer="nano17-si-12-0.12")
    size = {"theta": 1.5, "eta": 0.875, "diameter": 1.23456789012e-3, "length": 0.2 / 3}
    found = Design(status=DesignStatus.FOUND, message="", requirements=asked, **size)
    assert found.rod_file() == {
        "theta": 1.5,
        "eta": 0.875,
        "contact": "point",
        "modulus": "83 GPa",
        "diameter": "1.23456789 mm",
        "length": "66.66666667 mm",
        "density": "6500 kg/m^3",
        "material": "nitinol",
        "transducer": "nano17-si-12-0.12",
        "tolerances": {},
    }


@pytest.mark.parametrize(
    ("own", "told"),
    [
        (
            {"modulus": "3.6 GPa", "yield_strain": 0.01, "noise": "1 mN, 2 mN, 5 uN*m"},
            {"yield_strain": 0.01, "noise": "0.001 N, 0.002 N, 5e-06 N*m"},
        ),
        ({"noise": "0.003, 0.004, 0.0002"}, {"noise": "0.003, 0.004, 0.0002"}),
        (
            {"noise": "0.003, 0.004, 0.0002", "yield_strain": 1.2},
            {"yield_strain": 1.2, "noise": "0.003, 0.004, 0.0002"},
        ),
    ],
)
def test_without_names_the_numbers_are_in_the_rod_file(own, told, tmp_path):
    units = "modulus" in own
    asked = read_requirements(step="5 um" if units else "0.001", mu0="0.2", **own)
    size = {"theta": 2.0, "eta": 0.85, "diameter": 1e-3 if units else 1.0, "length": 0.1}
    found = Design(status=DesignStatus.FOUND, message="", requirements=asked, **size)
    rod = {"modulus": "3.6 GPa", "diameter": "1 mm", "length": "100 mm"} if units else {}
    shape = {"theta": 2.0, "eta": 0.85, "contact": "point"}
    assert found.rod_file() == {**shape, **rod, **told, "tolerances": {}}
    path = written(found, tmp_path)
    assert "tolerances" not in tomllib.loads(path.read_text(encoding="utf-8"))
    assert RodFile.read(path).whisker.theta == 2.0


def test_the_command_writes_a_rod_file_that_solve_reads(wire, tmp_path, monkeypatch):
    found = design(wire[0])
    monkeypatch.setattr(command, "find_design", lambda *_: found)
    monkeypatch.setattr(Design, "tolerances", lambda _: "tolerances")
    path = tmp_path / "ROD.TOML"
    result = run_design(wire[1], path)
    assert result.exit_code == 0, result.output
    assert result.output.endswith("\ntolerances\n")
    assert path.read_text(encoding="utf-8").startswith(f"# vibrissa design: {found.message}\n\n")
    solved = CliRunner().invoke(app, ["solve", "--rod", str(path), "--mu0", "0.3"])
    assert solved.exit_code == 0 and "strain_over_yield" in solved.output


def test_a_rod_that_violates_limits_is_not_written(wire, tmp_path, monkeypatch):
    found = replace(design(wire[0]), status=DesignStatus.NONE)
    monkeypatch.setattr(command, "find_design", lambda *_: found)
    # The tolerances of a rod that cannot be used are not asked for.
    monkeypatch.setattr(Design, "tolerances", lambda _: pytest.fail("tolerances are asked for"))
    path = tmp_path / "rod.toml"
    result = run_design(wire[1], path)
    assert result.exit_code == 1 and not path.exists()
    assert f"{path} is not written: the rod violates limits\n" in result.stderr


def test_the_rod_file_that_is_read_is_not_overwritten(wire):
    folder = wire[1].parent
    result = run_design(wire[1], folder / ".." / folder.name / "wire.toml")
    assert result.exit_code == 2
    assert result.output.endswith("is a file that is read: write another one\n")
    assert wire[1].read_text(encoding="utf-8") == WIRE
