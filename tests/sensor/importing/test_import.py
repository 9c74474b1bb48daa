"""A laboratory's file becomes the recording that was made, or messages that name every error."""

import csv
import runpy
import shlex
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner

from vibrissa.cli.app import app
from vibrissa.errors import VibrissaError
from vibrissa.scanning import surfaces
from vibrissa.sensor import scan
from vibrissa.sensor.identification.parameters import MIXING
from vibrissa.sensor.importing import Settings, import_recording
from vibrissa.sensor.importing.importing import about_clamp, turned

ROOT = Path(__file__).parents[3]
LABORATORY = ROOT / "examples/laboratory.txt"
SETTINGS = ROOT / "examples/laboratory.toml"
MADE = runpy.run_path(str(ROOT / "examples/laboratory.py"))
TITLED = {"time": "t", "footpoint": "x [mm]", "force_x": "Fx [N]", "force_y": "Fy [N]"}
CHANNELS = ("force_x", "force_y", "moment_z")


def run(*arguments, text=None):
    return CliRunner().invoke(app, [str(argument) for argument in arguments], input=text)


def imported(text, columns=None, **settings):
    data = text.encode() if isinstance(text, str) else text
    settings = {"from" if name == "begin" else name: value for name, value in settings.items()}
    return import_recording(data, Settings.read(column=columns or {}, **settings))


def file_of(columns, header="t [s];x [mm];Fx [N];Fy [N]"):
    rows = zip(*columns, strict=True)
    return header + "\n" + "\n".join(";".join(map(repr, map(float, row))) for row in rows)


def command_of_the_docs():
    text = (ROOT / "docs/friction.md").read_text(encoding="utf-8")
    code = text.partition("```console\n")[2].partition("```")[0].replace("\\\n", "")
    return [shlex.split(line)[1:] for line in code.splitlines()]


@pytest.fixture
def reading(tmp_path, monkeypatch):
    """The two commands of the docs, which write to a folder of the test."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    return command_of_the_docs()


@pytest.mark.slow
def test_a_german_laboratory_file_is_read_by_the_command_of_the_docs(reading):
    result = run(*reading[0])
    assert result.exit_code == 0, result.output
    result = run(*reading[1], "--method", "model")
    assert result.exit_code == 0, result.output
    with Path(reading[1][reading[1].index("-o") + 1]).open() as file:
        rows = [row for row in csv.DictReader(file) if row["status"] == "slip"]
    assert len(rows) == 15
    errors = [(float(row["mu0 [1]"]) - 0.3) / float(row["deviation [1]"]) for row in rows]
    assert np.abs(errors).max() < 4.0 and np.abs(np.mean(errors)) < 4.0 / np.sqrt(len(rows))
    assert not any("recording as a whole" in row["doubt"] for row in rows)


def test_the_laboratory_file_is_what_its_script_writes(tmp_path):
    MADE["main"](tmp_path)
    new, old = ((folder / LABORATORY.name).read_bytes() for folder in (tmp_path, ROOT / "examples"))
    new, old = (data.decode("latin-1").replace(",", ".").split("\r\n") for data in (new, old))
    assert new[:8] == old[:8] and len(new) == len(old)
    for one, other in zip(new[8:-1], old[8:-1], strict=True):
        assert np.array(one.split(";"), float) == pytest.approx(
            np.array(other.split(";"), float), abs=0.011
        )


def test_settings_of_a_file_are_those_of_the_options(reading, tmp_path):
    assert run(*reading[0]).exit_code == 0
    settings = ["--settings", SETTINGS, "-o", "file.csv"]
    assert run("import", LABORATORY, *settings).exit_code == 0
    assert Path("file.csv").read_bytes() == Path("recording.csv").read_bytes()
    faster = ["--settings", SETTINGS, "--speed", "2 mm/s", "-o", "other.parquet"]
    assert run("import", LABORATORY, *faster).exit_code == 0
    frame = pd.read_parquet("other.parquet")
    assert frame["footpoint"].iloc[-1] == pytest.approx(0.03, abs=1e-4)
    assert frame.attrs["header"]["zero_force_x"] == "310.2 ± 0.3 mN"


def test_the_load_is_that_of_the_rod_within_the_errors_of_the_zeros():
    found = import_recording(LABORATORY.read_bytes(), Settings.read(SETTINGS))
    asked = {"step": "20 um", "to": ["15 mm"], "law": "kinetic", "kinetic_ratio": 0.8}
    signals = scan(MADE["WHISKER"], surfaces.constant(0.3), **asked)
    read = np.stack([found.values[name] for name in CHANNELS], axis=1)
    error = (read - signals.readings).mean(axis=0)
    zero = np.array([found.zeros[name].deviation for name in CHANNELS])
    assert np.abs(error / zero).max() < 4.5
    turned_zeros = np.array([0.31, 0.12, 2.4e-3 - 0.02 * -0.31])
    told = np.array([found.zeros[name].value for name in CHANNELS])
    assert np.abs((told - turned_zeros) / zero).max() < 4.5


@pytest.mark.parametrize("name", ["transducer_angle", "moment_origin_x", "moment_origin_y"])
def test_signs_are_those_of_the_tolerances(name):
    """What is undone is what `identify` calls an error of that size and sign."""
    readings = np.random.default_rng(3).standard_normal((5, 3))
    size = 1e-6
    undone = readings - size * readings @ MIXING[name].T
    values = dict(zip(CHANNELS, readings.T, strict=True))
    here = {
        "transducer_angle": lambda: turned(values, size),
        "moment_origin_x": lambda: about_clamp(values, (size, 0.0)),
        "moment_origin_y": lambda: about_clamp(values, (0.0, size)),
    }[name]()
    assert np.stack(list(here.values()), axis=1) == pytest.approx(undone, abs=1e-10)


def test_axes_turned_by_90_degrees_are_swapped_with_one_sign():
    text = file_of([np.arange(30), np.arange(30), np.full(30, 2.0), np.full(30, 5.0)])
    found = imported(text, TITLED, turn="90 deg").values
    assert found["force_x"] == pytest.approx(-5.0) and found["force_y"] == pytest.approx(2.0)
    back = imported(text, TITLED | {"force_x": "-Fy [N]", "force_y": "Fx [N]"}).values
    assert back["force_x"] == pytest.approx(found["force_x"])
    assert back["force_y"] == pytest.approx(found["force_y"])


def test_the_rows_between_two_times_or_positions_are_kept():
    time = np.arange(100)
    text = file_of([time, 0.1 * time, np.sin(time), -1 + 0 * time])
    times = {"begin": "10 s", "to": "20 s"}
    by_time = imported(text, TITLED, **times).values
    assert by_time["time"].tolist() == list(range(10, 21))
    by_place = imported(text, TITLED, begin="1 mm", to="2 mm").values
    assert by_place["time"].tolist() == list(range(10, 21))
    # There and back, and backward.
    for place in (5.0 - np.abs(5.0 - 0.1 * time), 9.0 - 0.1 * time):
        ends = (f"{place[row]} mm" for row in (10, 20))
        windowed = imported(
            file_of([time, place, time, time]), TITLED, begin=next(ends), to=next(ends)
        )
        assert windowed.values["time"].tolist() == list(range(10, 21))
    forces = {"force_x": "Fx", "force_y": "Fy"}
    untimed = file_of([time, 0.1 * time, np.sin(time), -1 + 0 * time], "n;x;Fx [N];Fy [N]")
    steady = imported(untimed, forces, **times, speed="1 mm/s", rate="2 Hz").values
    assert steady["footpoint"] == pytest.approx(np.arange(21) * 5e-4)


def test_missing_values_stay_missing():
    text = file_of([np.arange(50)] * 4).replace("7.0;7.0;7.0;7.0", "7.0;7.0;;#NV")
    found = imported(text, TITLED)
    assert np.flatnonzero(np.isnan(found.values["force_x"])).tolist() == [7]
    assert "force_x is missing in 1 row" in found.notes


@pytest.mark.parametrize(
    ("header", "unit", "size"),
    [
        ("Fx [mN]", "", 1e-3),
        ("Fx (mN)", "", 1e-3),
        ("Fx / mN", "", 1e-3),
        ("Fx in mN", "", 1e-3),
        ("Fx_mN", "", 1e-3),
        ("Fx mN", "", 1e-3),
        ("Fx", " [mN]", 1e-3),
        ("Fx [mN]", " [mN]", 1e-3),
    ],
)
def test_a_unit_stands_in_the_title_or_is_told(header, unit, size):
    text = file_of([np.arange(30)] * 4, f"t_s;stage_mm;{header};Fy [N]")
    columns = {"time": "t", "footpoint": "stage", "force_x": f"-Fx{unit}", "force_y": "fy"}
    found = imported(text, columns)
    assert found.values["force_x"] == pytest.approx(-np.arange(30) * size)
    assert found.values["footpoint"] == pytest.approx(np.arange(30) * 1e-3)
    assert "time: t_s in s" in found.notes


@pytest.mark.parametrize("unit", ["Nmm", "N·mm", "N*mm", "mNm", "N mm", "N-mm", "N.mm", "N⋅mm"])
def test_a_moment_may_be_written_without_a_sign_between(unit):
    text = file_of([np.arange(30)] * 4, f"t [s];x [mm];M [{unit}];Fy [N]")
    found = imported(text, {"footpoint": "x", "moment_z": "M"})
    assert found.values["moment_z"] == pytest.approx(np.arange(30) * 1e-3)


FORCE = {"force_x": "Fx [N]"}


@pytest.mark.parametrize(
    ("columns", "settings"),
    [
        ({}, {}),
        ({"time": "t [s]"}, {}),
        ({"force_x": "Fz"}, {}),
        ({"force_x": "Fx", "footpoint": "x"}, {}),
        ({"force_x": "Fx [mm]"}, {}),
        ({"fx": "Fx"}, {}),
        (FORCE, {"speed": "1 mm/s"}),
        (FORCE, {"speed": "1 mm", "rate": "-1 Hz"}),
        ({"force_x": "Fx"}, {"turn": "1 deg"}),
        (TITLED, {"moment_origin": "1 mm"}),
        (TITLED, {"begin": "4"}),
        (TITLED, {"rate": "1 Hz"}),
        (TITLED, {"speed": "1 mm/s", "tare": "0 mm, 2 mm"}),
        (TITLED, {"decimal": ";"}),
        (TITLED, {"speeed": "1"}),
    ],
)
def test_mistakes_are_named_together(columns, settings, snapshot):
    text = file_of([np.arange(8), np.arange(8) / 1e3, np.full(8, 2), -np.ones(8)], "t;x;Fx;Fy")
    with pytest.raises(VibrissaError) as caught:
        imported(text, columns, **settings)
    assert str(caught.value) == snapshot


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"tare": "28 mm, 99 m"}, "the file: the tare has fewer than 3 readings of force_x, "),
        ({"moment_origin": "1 mm, 0 mm"}, "there is no column moment_z"),
        ({"begin": "4 m"}, "no row is left between --from and --to"),
        ({"tare": "0 s, 2 s"}, "no column time: .*; if the file has none, give --rate '50 Hz'"),
    ],
)
def test_settings_that_do_not_fit_the_file_are_refused(settings, message):
    text = file_of([np.arange(30)] * 4, "n;x [mm];Fx [N];Fy [N]")
    columns = {name: title for name, title in TITLED.items() if name != "time"}
    with pytest.raises(VibrissaError, match=message):
        imported(text, columns, **settings)


@pytest.mark.parametrize(
    ("time", "message"),
    [
        ([0, 1, 1, 3, 2], "line 4: time does not increase.*\n.*line 6: time does not increase"),
        (["12:00:01"] * 5, "line 3: time does not increase"),
        (["12:00:01", "noon", *"345"], "line 3: time must be a time such as .*, got 'noon'"),
    ],
)
def test_times_that_are_none_are_named(time, message):
    text = "t [s];x [mm];Fx [N]\n" + "\n".join(f"{each};{n};1.5" for n, each in enumerate(time))
    with pytest.raises(VibrissaError, match=f"(?s){message}"):
        imported(text, {"time": "t", "footpoint": "x", "force_x": "Fx"})


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("colums = {}", "'colums' is not a key; did you mean column?"),
        ('decimal = ";"', "decimal: input should be '.' or ','"),
        ("speed = 3", "speed"),
    ],
)
def test_mistakes_of_a_settings_file_are_named(text, message, tmp_path):
    (tmp_path / "import.toml").write_text(text)
    result = run(
        "import", LABORATORY, "--settings", tmp_path / "import.toml", "-o", tmp_path / "a.csv"
    )
    assert result.exit_code == 2 and message in result.output, result.output
    assert result.output.count("\n") == 1 and not (tmp_path / "a.csv").exists()


@pytest.mark.slow
def test_standard_input_and_output():
    data = LABORATORY.read_bytes()
    piped = run("import", "-", "--settings", SETTINGS, "-o", "-", text=data)
    assert piped.exit_code == 0
    assert piped.stdout.splitlines()[3].startswith("time [s],footpoint [m],force_x [N]")
    assert "decimal comma" in piped.stderr and "751 rows" in piped.stderr
    rod = ["--theta", 2, "--eta", "85 mm", "--modulus", "210 GPa", "--diameter", "0.8 mm"]
    found = run("identify", "-", *rod, "--length", "100 mm", "-o", "-", text=piped.stdout)
    assert found.exit_code == 0 and found.stdout.startswith("status,contact [m]")
    assert "is random" in found.stderr and found.stdout.count("\n") == 17
    alone = run("identify", "-", "--method", "ratio", "-o", "-", text=piped.stdout)
    assert alone.exit_code == 0 and alone.stdout.startswith("status,contact [m]")
