"""The command line: what is typed, what is printed and written, and the exit code."""

import csv
import re
import shlex
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest
from typer.testing import CliRunner

import vibrissa
from vibrissa.cli.app import COMMANDS, app, command_of
from vibrissa.errors import ArgumentError, RecordingError, UndeterminedError
from vibrissa.mechanics.rod import Rod
from vibrissa.outcomes import Status
from vibrissa.provenance import commit

ROD = ["--modulus", "210 GPa", "--diameter", "1 mm", "--length", "100 mm"]
WHISKER = ["--theta", "2", "--eta", "0.85"]


def run(*arguments):
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


def raising(error):
    def broken(*_, **__):
        raise error

    return broken


def test_solve_says_the_same_in_both_kinds_of_units(tmp_path):
    rod = Rod(2.1e11, 1e-3, 0.1)
    own, si = tmp_path / "own.parquet", tmp_path / "si.parquet"
    assert run("solve", *WHISKER, "--mu0", "0.4", "--step", "0.001", "-o", own).exit_code == 0
    tall = ["--theta", "2", "--eta", "85 mm", "--mu0", "0.4", "--step", "0.1 mm"]
    result = run("solve", *tall, *ROD, "-o", si)
    assert result.exit_code == 0, result.output
    one, other = (pq.read_table(path).to_pylist()[0] for path in (own, si))
    assert one["status"] == "slip" and one["x0_max"] == 0.052
    assert other["x0_max"] == pytest.approx(5.2e-3)
    assert other["force_x"] == pytest.approx(one["force_x"] * rod.force_unit)
    assert other["moment_z"] == pytest.approx(one["moment_z"] * rod.moment_unit)
    assert other["strain_most"] == pytest.approx(one["strain_most"] * 0.01)
    assert pd.read_parquet(si).attrs["units"]["force_x"] == "N"


def test_the_version_comes_with_its_commit():
    result = run("--version")
    assert result.exit_code == 0
    assert result.output == f"vibrissa {vibrissa.__version__}, commit {commit()}\n"


def test_a_table_on_standard_output_is_alone_there():
    result = run("solve", *WHISKER, "--mu0", "0.4", "-o", "-")
    (row,) = csv.DictReader(result.stdout.splitlines())
    assert row["status"] == "slip" and re.match("status +slip\n", result.stderr)


def test_scan_over_a_measured_surface_with_a_transducer(tmp_path):
    surface, out = tmp_path / "surface.csv", tmp_path / "scan.parquet"
    surface.write_text("x [mm],mu0\n0,0.3\n500,0.4\n")
    where = ["--step", "100 um", "--to", "50 mm", "--profile", surface]
    sensor = ["--transducer", "nano17-si-12-0.12", "--seed", "3"]
    assert run("scan", *WHISKER, *ROD, *where, *sensor, "-o", out).exit_code == 0
    table = pq.read_table(out).to_pydict()
    assert np.array(table["mu0"]) == pytest.approx(0.3 + 0.2 * np.array(table["contact"]))
    counts = np.array(table["force_x"]) * 320
    assert counts == pytest.approx(np.round(counts), abs=1e-9)


def test_scan_over_measured_heights_with_a_ball_at_the_tip(tmp_path):
    heights, out = tmp_path / "heights.csv", tmp_path / "scan.parquet"
    x = np.linspace(0.0, 200.0, 401)
    rows = zip(x, 20.0 * np.sin(np.pi * x), strict=True)
    heights.write_text("x [mm],height [um]\n" + "".join(f"{a},{b}\n" for a, b in rows))
    where = ["--mu0", "0.3", "--step", "100 um", "--to", "5 mm"]
    textured = ["--heights", heights, "--tip-radius", "50 um"]
    assert run("scan", *WHISKER, *ROD, *where, *textured, "-o", out).exit_code == 0
    table = pq.read_table(out).to_pandas()
    assert (table["height"].between(-20e-6, 20e-6)).all()
    ratio = (table["force_x"] / table["force_y"]).abs()
    assert ratio.to_numpy() == pytest.approx(table["apparent_friction"].to_numpy())
    # It needs friction and slope together, and has no more of both.
    alpha = -np.arctan(table["force_x"] / table["force_y"])
    assert (np.tan(np.abs(alpha - table["inclination"])) < 0.3 + 1e-9).all()


MISTAKES = """
scan WHISKER --mu0 0.3 --step 0.1 --to 1 -o x.csv --wave 0.1
scan WHISKER --mu0 0.3 --step 0.1 --to 1 -o x.csv --grooves '0.02, 0.001, 0.01'
scan WHISKER --mu0 0.3 --step 0.1 --to 1 -o x.csv --heights no.csv
scan WHISKER --mu0 0.3 --step 0.1 --to 1 -o x.csv --wave '0.001, 0.02' --tip-radius '-1'
scan WHISKER --mu0 0.3 --step 0.1 --to 1 -o x.csv --wave '0.001, 0.02' --contact line
scan WHISKER --mu0 0.3 --step 0.1 --to 1 -o x.csv --lay '30 deg'
solve WHISKER --mu0 much
solve WHISKER --mu0 -1
solve WHISKER --mu0 0.3 --length '1 m'
solve WHISKER --mu0 0.3 --material tin
solve WHISKER --mu0 0.3 -o x.txt
solve WHISKER --mu0 0.3 -o no/x.csv
solve WHISKER ROD --mu0 0.3 --step '-1 um'
solve WHISKER ROD --mu0 0.3 --step '3 kg'
solve WHISKER ROD --mu0 0.3 --modulus '0 GPa'
solve WHISKER ROD --mu0 0.3 --material tin
solve --theta 2 --eta 85 ROD --mu0 0.3
solve --theta 2 --eta '85 mm' --mu0 0.3
scan WHISKER --patches 0:0 --step 1 --to 1 -o x.csv
scan WHISKER --step 0.1 --to 1 -o x.csv
scan WHISKER --step 0.1 --to 1 -o x.csv --patches 0:x
scan WHISKER --step 0.1 --to 1 -o x.csv --profile no.csv
identify a.csv --theta 2 ROD
"""


@pytest.mark.parametrize("line", MISTAKES.strip().splitlines())
def test_mistakes_get_one_line(line, tmp_path, monkeypatch, snapshot):
    monkeypatch.chdir(tmp_path)
    typed = line.replace("WHISKER", shlex.join(WHISKER)).replace("ROD", shlex.join(ROD))
    result = run(*shlex.split(typed))
    assert result.exit_code == 2 and result.output == snapshot
    assert result.output.startswith("vibrissa: ") and result.output.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_the_set_up_is_read_from_file_options_and_set_together(tmp_path):
    path = tmp_path / "setup.toml"
    path.write_text(
        'theta = "2 ± 0.02"\neta = 0.85\nclamp_compliance = 0.1\n[tolerances]\neta = 0.001\n'
    )
    asked = ["solve", "--mu0", "0.3", "--rod", path]
    result = run(*asked)
    stiff = run(*asked, "--set", "clamp_compliance=0.05")
    direct = run("solve", "--mu0", "0.3", *WHISKER, "--set", "clamp_compliance=0.05")
    assert stiff.exit_code == 0 and stiff.stdout == direct.stdout != result.stdout
    other = run(*asked, "--theta", "2.1")
    assert other.exit_code == 0 and other.stdout != result.stdout


@pytest.mark.parametrize(
    ("typed", "message"),
    [
        (["--clamp-angle", "3 kg"], "clamp_angle must be an angle with a unit such as rad,"),
        (["--set", "clmp_angle=1"], "'clmp_angle' is not a key; did you mean clamp_angle?"),
        (["--set", "clamp_angle"], "--set needs name=value, got 'clamp_angle'"),
        (["--set", "section=flat"], "section: input should be 'round' or 'planar'"),
        (["--tolerance", "clmp_angle=1"], "; did you mean clamp_angle?"),
        (["--tolerance", "eta=1", "--tolerance", "eta=2"], "--tolerance eta is given twice"),
    ],
)
def test_a_set_up_that_is_not_allowed_is_refused(typed, message):
    result = run("identify", "none.csv", *WHISKER, *typed)
    assert result.exit_code == 2 and message in result.output
    assert result.output.startswith("vibrissa: ") and result.output.count("\n") == 1


def test_each_error_is_a_line():
    result = run("solve", "--mu0", "0.3", "--theta", "x", "--eta", "1 kg", "--contact", "flat")
    assert result.exit_code == 2 and result.output.count("vibrissa: ") == 3


def test_solve_takes_the_material_of_a_set_up(tmp_path):
    path = tmp_path / "rod.toml"
    size = 'theta = 2\neta = 0.85\ndiameter = "1 mm"\nlength = "100 mm"\nmodulus = "210 GPa"\n'

    def warned(last, *more):
        path.write_text(size + last)
        return run("solve", "--rod", path, "--mu0", "0.3", *more).stderr

    # It yields at 0.65 of 1840 MPa.
    wire = warned('material = "music-wire"\ndensity = "7800 kg/m^3"\n')
    assert f"elastic up to {0.65 * 1840e6 / 210e9:.2%}" in wire and "the rod yields" in wire
    assert "its material is elastic up to 0.50%" in warned('yield_strain = "0.005"\n')
    # An option takes the place of its alternative.
    assert warned('yield_strain = "0.012"\n', "--material", "music-wire") == wire
    assert warned('yield_strain = "0.012"\n') == "" and "even music wire" in warned("")


@pytest.mark.parametrize(
    "arguments",
    [
        ["identify", "in.csv", *WHISKER],
        ["import", "in.csv"],
        ["scan", *WHISKER, "--profile", "in.csv", "--step", "0.1", "--to", "1"],
    ],
)
def test_a_command_does_not_write_over_what_it_reads(arguments, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "in.csv").write_text("x,mu0\n0,0.3\n1,0.3\n")
    result = run(*arguments, "-o", "./in.csv")
    assert result.exit_code == 2
    assert result.output == "vibrissa: in.csv is an input: give the output another name\n"


def test_a_path_that_is_too_short_or_too_long_is_refused(tmp_path):
    asked = ["scan", *WHISKER, *ROD, "--mu0", "0.3", "--step", "1 mm", "-o", tmp_path / "a.csv"]
    assert "at least one step long" in run(*asked, "--to", "0.2 mm").output
    assert "the step is too small" in run(*asked, "--to", "1e9 km").output


def test_a_file_that_cannot_be_written_is_refused_before_anything_is_computed(
    tmp_path, monkeypatch
):
    folder = tmp_path / "a.csv"
    folder.mkdir()
    result = run("solve", *WHISKER, "--mu0", "0.4", "-o", folder)
    assert result.exit_code == 2
    assert f"{folder} cannot be written: it must be a file" in result.output
    monkeypatch.setattr("os.access", lambda *_: False)
    result = run("solve", *WHISKER, "--mu0", "0.4", "-o", tmp_path / "b.csv")
    assert result.exit_code == 2 and result.output.count("\n") == 1
    assert "in a folder that can be written to" in result.output


def test_every_page_that_a_message_names_is_there():
    root = Path(__file__).parents[2]
    sources = "".join(path.read_text() for path in (root / "src").rglob("*.py"))
    named = set(re.findall(r"""see_page\(["'](.*?)["']\)""", sources))
    titles = {path.read_text().partition("\n")[0] for path in (root / "docs").glob("*.md")}
    assert named and {f"# {name}" for name in named} <= titles


def test_without_a_command_all_are_listed():
    shown = run().output
    assert shown.strip() == run("--help").output.strip() == run("-h").output.strip()
    assert all(name in shown for name in COMMANDS)


@pytest.mark.parametrize("name", COMMANDS)
def test_help_fits_80_columns_in_panels_and_has_an_example(name, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.setenv("TERMINAL_WIDTH", "80")
    shown = run(name, "-h").output
    assert max(map(len, shown.splitlines())) <= 80 and "…" not in shown
    assert shown == run(name, "--help").output
    assert COMMANDS[name] in " ".join(command_of(name).help.split())
    assert f"Example: vibrissa {name} " in shown or f"Examples: vibrissa {name} " in shown
    # Completion is installed by the program, not by a command.
    assert "--install-completion" not in shown
    panels = {"solve": "Rod Mounting Output", "identify": "Rod Mounting Signals Output"}
    for panel in panels.get(name, "").split():
        assert f"╭─ {panel} ─" in shown


def test_a_mistyped_command_gets_a_suggestion():
    result = run("slove", *WHISKER)
    assert result.exit_code == 2 and "Did you mean 'solve'?" in result.output
    assert "Did you mean" not in run("xyzzy").output


@pytest.mark.slow
def test_an_onset_does_not_wait_for_libraries_that_it_does_not_need():
    program = """
import sys
from vibrissa.cli.app import app
app(sys.argv[1:], standalone_mode=False)
heavy = {"pandas", "pyarrow", "pint", "matplotlib", "rich", "uncertainties"}
print(heavy & {name.partition(".")[0] for name in sys.modules})
"""
    asked = ["solve", *WHISKER, "--mu0", "0.4", "--step", "0.0002"]
    solved = subprocess.run([sys.executable, "-c", program, *asked], capture_output=True, text=True)
    assert "strain" in solved.stdout and solved.stdout.endswith("set()\n")


def test_a_mistake_in_the_program_is_not_dressed_up_as_one_of_the_input(monkeypatch):
    monkeypatch.setattr("vibrissa.sensor.onset.onset_on", raising(ValueError("a mistake")))
    result = run("solve", *WHISKER, "--mu0", "0.4")
    assert isinstance(result.exception, ValueError)


@pytest.mark.parametrize(
    ("error", "code"),
    [
        (ArgumentError("no such thing"), 2),
        (RecordingError("no such thing"), 2),
        (UndeterminedError("no such thing"), 1),
        (OSError(2, "no such thing"), 2),
    ],
)
def test_what_a_user_can_mend_is_one_line_and_an_exit_code(error, code, monkeypatch):
    monkeypatch.setattr("vibrissa.sensor.solve", raising(error))
    result = run("solve", *WHISKER, "--mu0", "0.4")
    assert (result.exit_code, result.stdout) == (code, "")
    assert result.stderr == "vibrissa: no such thing\n"


def test_a_pipe_that_is_closed_is_left_to_the_shell(monkeypatch):
    monkeypatch.setattr("vibrissa.sensor.solve", raising(BrokenPipeError("closed")))
    with pytest.raises(BrokenPipeError):
        app(["solve", *WHISKER, "--mu0", "0.4"], standalone_mode=False)


def test_a_failure_is_no_success(monkeypatch):
    onset = SimpleNamespace(status=Status.FAILED)
    monkeypatch.setattr("vibrissa.sensor.solve", lambda *_: SimpleNamespace(onset=onset))
    assert run("solve", *WHISKER, "--mu0", "0.4").exit_code == 1
