"""The command line, units and tables."""

import csv
import subprocess
import sys
from decimal import Decimal
from importlib import import_module
from types import SimpleNamespace

import numpy as np
import pint
import pyarrow.parquet as pq
import pytest
from hypothesis import given
from hypothesis import strategies as st
from typer.testing import CliRunner

import vibrissa
from vibrissa.cli import options
from vibrissa.cli.app import COMMANDS, app, module_of
from vibrissa.errors import ArgumentError, RecordingError, UndeterminedError
from vibrissa.mechanics.rod import Rod
from vibrissa.outcomes import Status
from vibrissa.provenance import commit
from vibrissa.sensor import series
from vibrissa.sensor.quantities import SI, USUAL, Kind, Units, in_si
from vibrissa.sensor.transducer import Transducer, preset

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
    assert other["strain"] == pytest.approx(one["strain"] * 0.01)
    assert pq.read_schema(si).field("force_x").metadata[b"unit"] == b"N"


def test_the_version_comes_with_its_commit():
    result = run("--version")
    assert result.exit_code == 0
    assert result.output == f"vibrissa {vibrissa.__version__}, commit {commit()}\n"


@pytest.mark.slow
def test_the_exit_code_is_1_where_nothing_can_be_computed():
    planar = ("--section", "planar")
    result = run("solve", "--theta", "2", "--eta", "0.15", "--mu0", "5", *planar)
    assert result.exit_code == 1
    assert "out_of_reach" in result.output


def test_a_table_on_standard_output_is_alone_there():
    result = run("solve", *WHISKER, "--mu0", "0.4", "-o", "-")
    (row,) = csv.DictReader(result.stdout.splitlines())
    assert row["status"] == "slip" and result.stderr.startswith("status            slip\n")
    rod = ["--material", "nylon-66", "--diameter", "1 mm", "--length", "100 mm"]
    asked = [*rod, "--step", "50 um", "--mu0", "0.2", "--transducer", "nano17-si-12-0.12"]
    result = run("design", *WHISKER, *asked, "-o", "-")
    (row,) = csv.DictReader(result.stdout.splitlines())
    assert row["status"] == "none" and result.stderr.startswith("this rod cannot be used")


def test_lock_is_an_answer():
    result = run("solve", *WHISKER, "--mu0", "0.5")
    assert result.exit_code == 0
    assert "lock" in result.output and "0.47757" in result.output


@pytest.mark.slow
def test_a_mounting_is_given_with_units():
    ideal = run("solve", *WHISKER, "--mu0", "0.4")
    tilted = run("solve", *WHISKER, "--mu0", "0.4", "--clamp-angle", "2 deg")
    assert "0.052838" in ideal.output and "0.066903" in tilted.output
    both = ["--clamp-stiffness", "1000 N*m/rad", "--curvature", "-1 m^-1"]
    result = run("solve", *WHISKER, *ROD, "--mu0", "0.4", *both, "--stage-angle", "-1 deg")
    assert result.exit_code == 0 and "slip" in result.output
    tall = ["--theta", "2", "--eta", "0.98"]
    none = run("solve", *tall, "--mu0", "0.4", "--clamp-angle", "20 deg")
    assert none.exit_code == 1 and "springs to the other side" in none.output


def test_scan_writes_signals_and_truth(tmp_path):
    out, picture = tmp_path / "scan.csv", tmp_path / "scan.svg"
    where = ["--step", "100 um", "--to", "50 mm", "--to", "20 mm"]
    surface = ["--patches", "0 mm: 0.3, 60 mm: 0.4"]
    result = run("scan", *WHISKER, *ROD, *where, *surface, "-o", out, "--picture", picture)
    assert result.exit_code == 0, result.output
    with out.open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 1 + 500 + 300
    assert float(rows[-1]["footpoint [m]"]) == pytest.approx(0.02)
    for row in rows:
        assert float(row["mu0 [1]"]) == (0.3 if float(row["contact [m]"]) < 0.06 else 0.4)
    assert picture.read_bytes().startswith(b"<?xml")


@pytest.mark.slow
def test_an_inclined_surface_is_a_stage_and_a_clamp_at_an_angle(tmp_path):
    angles = ["--stage-angle", "2 deg", "--clamp-angle", "2 deg"]
    own, si = tmp_path / "own.parquet", tmp_path / "si.parquet"
    steps = ["--mu0", "0.3", "--step", "0.002", "--to", "0.12"]
    assert run("scan", *WHISKER, *steps, *angles, "-o", own).exit_code == 0
    tall = ["--theta", "2", "--eta", "85 mm"]
    millimetres = ["--mu0", "0.3", "--step", "0.2 mm", "--to", "12 mm"]
    result = run("scan", *tall, *ROD, *millimetres, *angles, "-o", si)
    assert result.exit_code == 0, result.output
    one, other = (pq.read_table(path).to_pydict() for path in (own, si))
    assert one["period"][-1] > 2 and one["phase"] == other["phase"]
    assert np.array(other["contact"]) == pytest.approx(0.1 * np.array(one["contact"]))
    assert one["force_x"][-1] != pytest.approx(one["force_x"][0])


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


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["solve", *WHISKER, "--mu0", "much"], "mu0 must be a number"),
        (["import", "none.csv", "--settings", ".", "-o", "x.csv"], ". cannot be read: Is a direc"),
        *(
            (
                ["solve", "--theta", "2", "--eta", height, *ROD, "--mu0", "0.3"],
                "eta must lie between 0 and the length of the rod, 100 mm: write a height with its "
                f"unit, as in '85 mm', got '{height}'\n",
            )
            for height in ("85", "101 mm", "100 mm", "0 mm", "-85 mm")
        ),
        (["solve", *WHISKER, "--mu0", "-1"], "mu0 must be positive, got '-1'\n"),
        (
            ["solve", *WHISKER, *ROD, "--mu0", "0.3", "--step", "-1 um"],
            "step must be positive, got '-1 um'\n",
        ),
        (
            ["solve", *WHISKER, *ROD, "--mu0", "0.3", "--modulus", "0 GPa"],
            "the modulus of a rod must lie between 1e-30 and 1e30 Pa, got 0\n",
        ),
        (
            ["solve", *WHISKER, *ROD, "--mu0", "0.3", "--diameter", "-1 mm"],
            "the diameter of a rod must lie between 1e-30 and 1e30 m, got -0.001\n",
        ),
        (
            ["scan", *WHISKER, "--mu0", "0", "--step", "0.1", "--to", "1", "-o", "x.csv"],
            "mu0 must be positive, got '0'\n",
        ),
        (
            ["scan", *WHISKER, "--mu0", "1", "--step", "0", "--to", "1", "-o", "x.csv"],
            "step must be positive, got '0'\n",
        ),
        (
            ["scan", *WHISKER, "--patches", "0:0", "--step", "1", "--to", "1", "-o", "x.csv"],
            "mu0 of a patch must be positive, got '0'\n",
        ),
        (
            [
                *("design", "--step", "1 mm", "--mu0", "0", "--material", "nylon-66"),
                *("--transducer", "nano17-si-12-0.12"),
            ],
            "mu0: input should be greater than 0, got 0.0\n",
        ),
        (["solve", "--theta", "2", "--eta", "85 mm", "--mu0", "0.3"], "the rod is not given"),
        (["solve", *WHISKER, "--mu0", "0.3", "--length", "1 m"], "modulus, diameter missing"),
        (["solve", *WHISKER, "--mu0", "0.3", *ROD, "--step", "3 kg"], "step must be a length"),
        (["solve", *WHISKER, "--mu0", "0.3", "--material", "tin"], "a material needs the rod"),
        (["solve", *WHISKER, *ROD, "--mu0", "0.3", "--material", "tin"], "material must be one"),
        (["solve", *WHISKER, "--mu0", "0.3", "-o", "x.txt"], "ending must be"),
        (["solve", *WHISKER, "--mu0", "0.3", "--picture", "x.gif"], "ending must be"),
        (["scan", *WHISKER, "--step", "0.1", "--to", "1", "-o", "x.csv"], "give the surface"),
        (
            ["scan", *WHISKER, "--step", "0.1", "--to", "1", "-o", "x.csv", "--patches", "0:x"],
            "mu0 of a patch",
        ),
        (
            ["scan", *WHISKER, "--step", "0.1", "--to", "1", "-o", "x.csv", "--profile", "no.csv"],
            "no such file",
        ),
    ],
)
def test_mistakes_get_one_line(arguments, message, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    result = run(*arguments)
    assert result.exit_code == 2
    assert message in result.output
    assert result.output.startswith("vibrissa: ") and result.output.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("typed", "message"),
    [
        (["--clamp-angle", "3 kg"], "--clamp-angle must be an angle with a unit such as rad,"),
        (["--clamp-angle=3 kg"], "--clamp-angle must be an angle with a unit such as rad,"),
        (
            ["--clamp-compliance", "1", "--clamp-stiffness", "1"],
            "give --clamp-compliance or --clamp-stiffness, not both",
        ),
        # Here the name is that of a tolerance, or of a key of a file.
        (["--tolerance", "clamp_angle=-1"], "the tolerance of clamp_angle must not be negative"),
        (["--clamp-angle", "0", "--tolerance", "clmp_angle=1"], "; did you mean clamp_angle?"),
        (["--clamp-angle", "0", "--rod", "misspelled.toml"], "; did you mean clamp_angle?"),
        (["--rod", "heavy.toml"], "clamp_angle must be an angle"),
    ],
)
def test_options_are_named_as_they_were_typed(typed, message, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "misspelled.toml").write_text("clmp_angle = 1\n")
    (tmp_path / "heavy.toml").write_text('clamp_angle = "3 kg"\n')
    result = run("identify", "none.csv", *WHISKER, *typed, "-o", "friction.csv")
    assert result.exit_code == 2
    assert result.output.startswith("vibrissa: ") and message in result.output


def test_a_file_that_is_called_as_an_option_keeps_its_name(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    result = run("identify", "slip_time.csv", *WHISKER, "--slip-time", "1 ms", "-o", "f.csv")
    assert result.output == "vibrissa: slip_time.csv: there is no such file\n"


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
    assert result.output == "vibrissa: in.csv is a file that is read: write another one\n"


@pytest.mark.parametrize(("law", "told"), [("free", 1), ("kinetic", 0)])
def test_a_kinetic_ratio_that_is_not_used_is_told(law, told, tmp_path):
    asked = ["scan", *WHISKER, "--mu0", "0.3", "--step", "0.1", "--to", "0.2", "--law", law]
    result = run(*asked, "--kinetic-ratio", "0.5", "-o", tmp_path / "a.csv")
    assert result.exit_code == 0
    assert result.stderr.count("the law free uses no kinetic ratio; --law kinetic") == told
    assert run(*asked, "-o", tmp_path / "a.csv").stderr == ""


def test_a_path_that_is_too_short_is_told_in_the_units_of_the_rod(tmp_path):
    asked = ["scan", *WHISKER, *ROD, "--mu0", "0.3", "--step", "1 mm", "-o", tmp_path / "a.csv"]
    assert "at least one step of 1 mm long" in run(*asked, "--to", "0.2 mm").output
    assert "a step of 1 mm is too small" in run(*asked, "--to", "1e9 km").output


def test_without_a_command_all_are_listed():
    shown = run().output
    assert shown.splitlines() == run("--help").output.splitlines() and "identify" in shown


@pytest.mark.parametrize("command", ["solve", "scan"])
def test_help_has_an_example(command):
    shown = run(command, "--help").output.replace("\n", " ")
    # Its own options alone: a shell's completion is not installed by a command.
    assert f"vibrissa {command} --theta" in shown and "--install-completion" not in shown


@pytest.mark.parametrize("name", COMMANDS)
def test_the_list_of_commands_says_what_a_command_says_itself(name):
    module = module_of(name)
    command = getattr(import_module(module), module.rpartition(".")[2])
    assert command.__doc__.partition("\n")[0] == COMMANDS[name]
    assert COMMANDS[name].split()[0] in run("--help").output


def test_the_list_of_commands_does_not_wait_for_the_solvers():
    program = """
import sys
from vibrissa.cli.app import app
app(["--help"], standalone_mode=False)
print({"numpy", "scipy", "pint", "matplotlib", "pyarrow", "rich"} & set(sys.modules))
"""
    listed = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert "identify" in listed.stdout and listed.stdout.endswith("set()\n")


@pytest.mark.slow
def test_an_onset_does_not_wait_for_libraries_that_it_does_not_need():
    program = """
import sys
from vibrissa.cli.app import app
app(sys.argv[1:], standalone_mode=False)
heavy = {"scipy", "pandas", "pyarrow", "pint", "matplotlib", "rich"}
print(heavy & {name.partition(".")[0] for name in sys.modules})
"""
    asked = ["solve", "--theta", "2", "--eta", "85 mm", *ROD, "--mu0", "0.4", "--step", "20 um"]
    solved = subprocess.run([sys.executable, "-c", program, *asked], capture_output=True, text=True)
    assert "strain" in solved.stdout and solved.stdout.endswith("set()\n")


@pytest.mark.parametrize("kind", USUAL)
def test_usual_units_are_those_of_pint(kind):
    registry = pint.UnitRegistry(non_int_type=Decimal)
    for unit, factor in USUAL[kind].items():
        known = registry.Quantity(Decimal("1.25"), registry.parse_units(unit)).to(SI[kind])
        assert (
            in_si(f"1.25 {unit}", kind, "it")
            == known.magnitude
            == Decimal("1.25") * Decimal(factor)
        )


def test_a_mistake_in_the_program_is_not_dressed_up_as_one_of_the_input(monkeypatch):
    monkeypatch.setattr("vibrissa.sensor.onset.onset_on", raising(ValueError("a mistake")))
    result = run("solve", *WHISKER, "--mu0", "0.4")
    assert isinstance(result.exception, ValueError)


def test_units_are_exact_decimals():
    units = Units(Rod(2.1e11, 1e-3, 0.1))
    assert str(units.read("20 um", Kind.LENGTH, "step")) == "0.0002"
    assert str(units.read("0.001", Kind.LENGTH, "step")) == "0.001"
    for angle in ("90°", "90 °", "90 deg"):
        assert float(units.read(angle, Kind.ANGLE, "turn")) == np.pi / 2.0
    assert units.column_factor("N*mm", Kind.MOMENT, "m") == pytest.approx(
        1e-3 / units.rod.moment_unit
    )
    assert units.column_factor("E*I0/L**2", Kind.FORCE, "f") == 1.0


@pytest.mark.slow
@given(st.text(max_size=20))
def test_any_text_is_a_quantity_or_refused_as_a_value_error(text):
    try:
        value = Units(Rod(1.0, 1.0, 1.0)).read(text, Kind.LENGTH, "step")
    except ValueError as error:
        assert "step" in str(error) or "number" in str(error)
    else:
        assert value.is_finite()


def test_transducer_rounds_clips_and_adds_noise_of_the_size_it_says():
    sensor = preset("nano17-si-12-0.12")
    assert sensor.limit == (12.0, 12.0, 0.12)
    assert sensor.resolution == pytest.approx((1 / 320, 1 / 320, 1e-3 / 64))
    true = np.tile([1.0, -2.0, 0.05], (20000, 1))
    read = sensor.measured(true, np.random.default_rng(1))
    assert (read - true).std(axis=0) == pytest.approx(sensor.deviation, rel=0.03)
    assert (read - true).mean(axis=0) == pytest.approx([0, 0, 0], abs=1e-4)
    assert sensor.measured(true * 100, np.random.default_rng(1))[0].tolist() == [12.0, -12.0, 0.12]
    readings = np.array([[12.0, -3.0, 0.1], [-1.0, -12.0, -0.12]])
    assert sensor.saturated(readings).tolist() == [[True, False, False], [False, True, True]]
    # With and without steps, a reading at the limit is one that may have been larger.
    for step in ((0.0, 0.0, 0.0), (0.5, 0.5, 0.5)):
        plain = Transducer(name="x", source="", limit=(4.0,) * 3, resolution=step, noise=step)
        at = np.array([4.0, -4.0, 4.0]) - np.array([1.0, -1.0, 1.0]) * step
        assert plain.saturated(np.stack([at, 0.99 * at])).tolist() == [[True] * 3, [False] * 3]
    with pytest.raises(ValueError, match="nano17"):
        preset("nano18")


def test_tables_come_back_as_they_were_written(tmp_path):
    values = np.array([0.1, 1 / 3, -2e-300])
    for ending in ("csv", "parquet"):
        path = tmp_path / f"t.{ending}"
        series.write(path, {"a": series.Column(values, "mm", "what it is")})
        table = series.read(path, ["a"])
        assert table.columns["a"].tolist() == values.tolist()
        assert table.units == {"a": "mm"}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a,b\n1,2\n1\n", "line 3: 1 values, but the header has 2"),
        # Decimal commas in unquoted cells.
        ("a,b\n1,2\n1,5,2,5\n", "line 3: 4 values, but the header has 2"),
        ("a,b\n1,two\n", "line 2: b must be a number, got 'two'"),
        ("a,b\n1,inf\n", "line 2: b must be finite"),
        ("a\n1\n", "column b is missing"),
        ("a,b\n", "no rows"),
        ("a,a,b\n1,2,3\n", "twice"),
        ("", "missing"),
        ('a,b\n1,"2\n', "line"),
    ],
)
def test_bad_tables_are_refused_with_their_line(text, message, tmp_path):
    path = tmp_path / "t.csv"
    path.write_text(text)
    with pytest.raises(ValueError, match=message):
        series.read(path, ["a", "b"])


@given(st.binary(max_size=200))
def test_any_file_is_read_or_refused_as_a_value_error(tmp_path_factory, data):
    path = tmp_path_factory.mktemp("fuzz") / "t.csv"
    path.write_bytes(b"a,b\n" + data)
    try:
        table = series.read(path, ["a", "b"])
    except ValueError as error:
        assert str(error).startswith(str(path))
    else:
        assert len(table.columns["a"]) == len(table.line) > 0


@pytest.mark.parametrize("cell", ["1_0", "١٢", "0x10", "1,5", "1e", "+-1", "True", "−1"])
def test_numbers_are_written_in_one_way(cell, tmp_path):
    path = tmp_path / "t.csv"
    path.write_text(f'a\n"{cell}"\n', encoding="utf-8")
    with pytest.raises(ValueError, match="line 2: a must be a number"):
        series.read(path, ["a"])


@pytest.mark.parametrize("patience, lines", [(-1.0, ["solving"]), (60.0, [])])
def test_long_work_is_shown_beside_the_result(monkeypatch, capsys, patience, lines):
    monkeypatch.setattr(options, "PATIENCE", patience)
    tell = options.progress_bars()
    for done in (1, 2):
        tell("solving", done, 2)
    told = capsys.readouterr()
    assert told.out == ""
    assert [line.split()[0] for line in told.err.splitlines() if line.strip()] == lines


@pytest.mark.parametrize(
    ("error", "code"),
    [
        (ArgumentError("no such thing"), 2),
        (RecordingError("no such thing"), 2),
        (UndeterminedError("no such thing"), 1),
        (OSError("no such thing"), 2),
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


@pytest.mark.parametrize(("status", "code"), [("slip", 0), ("lock", 0), ("failed", 1)])
def test_only_what_was_computed_is_a_success(status, code, monkeypatch):
    onset = SimpleNamespace(status=Status(status))
    monkeypatch.setattr("vibrissa.sensor.solve", lambda *_: SimpleNamespace(onset=onset))
    assert run("solve", *WHISKER, "--mu0", "0.4").exit_code == code
