"""A laboratory's file becomes the recording that was made, or one clear message."""

import csv
import runpy
import shlex
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest
from hypothesis import given
from hypothesis import strategies as st
from typer.testing import CliRunner

from steel import SI, WHISKER
from vibrissa.cli.app import app
from vibrissa.errors import VibrissaError
from vibrissa.sensor import Whisker, scan, surfaces
from vibrissa.sensor.identification.parameters import MIXING
from vibrissa.sensor.importing import Settings, import_recording
from vibrissa.sensor.importing.preparing import about_clamp, turned

ROOT = Path(__file__).parents[3]
LABORATORY = ROOT / "examples/laboratory.txt"
MADE = runpy.run_path(str(ROOT / "examples/laboratory.py"))
TITLED = {"footpoint": "x [mm]", "force_x": "Fx [N]", "force_y": "Fy [N]"}


def run(*arguments, text=None):
    return CliRunner().invoke(app, [str(argument) for argument in arguments], input=text)


def imported(text, **settings):
    data = text.encode() if isinstance(text, str) else text
    return import_recording(data, Settings.read(**settings))


def file_of(columns, header="t [s];x [mm];Fx [N];Fy [N]"):
    rows = zip(*columns, strict=True)
    return header + "\n" + "\n".join(";".join(map(repr, map(float, row))) for row in rows)


def command_of_the_docs():
    text = (ROOT / "docs/friction.md").read_text(encoding="utf-8")
    code = text.partition("```console\n")[2].partition("```")[0].replace("\\\n", "")
    return [shlex.split(line)[1:] for line in code.splitlines()]


SAID = """\
read as cp1252, separator semicolon, decimal comma, titles in line 7, units in line 8, \
1,226 rows from line 9 on
time: Zeit in s
force_x: minus Kraft Fy in mN
force_y: Kraft Fx in mN
moment_z: Moment Mz in Nmm
the clamp position is the speed times the time since the first sample that is kept
by the readings the stage begins to move in line 259, or up to 1 line before: if you know when, \
give --from
zero of force_x: 310.254 ± 0.27 mN by 96 samples, taken off
zero of force_y: 120.221 ± 0.29 mN by 96 samples, taken off
zero of moment_z: 8.5855 ± 0.0079 N*mm by 96 samples, taken off
left out, the clamp rests, or no force acts: lines 9 to 258 and lines 1010 to 1234
laboratory.csv: 751 rows
for identify, the zeros are known to: --tolerance "zero_force_x=0.27 mN" \
--tolerance "zero_force_y=0.29 mN" --tolerance "zero_moment_z=0.0079 N*mm"
"""


def test_all_that_was_read_and_decided_is_said(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    reading, _ = command_of_the_docs()
    reading[reading.index("-o") + 1] = "laboratory.csv"
    assert run(*reading).output == SAID


def test_the_laboratory_file_is_what_its_script_writes(tmp_path):
    MADE["main"](tmp_path)
    new, old = ((folder / LABORATORY.name).read_bytes() for folder in (tmp_path, ROOT / "examples"))
    new, old = (data.decode("latin-1").replace(",", ".").split("\r\n") for data in (new, old))
    assert new[:8] == old[:8] and len(new) == len(old)
    for one, other in zip(new[8:-1], old[8:-1], strict=True):
        assert np.array(one.split(";"), float) == pytest.approx(
            np.array(other.split(";"), float), abs=0.011
        )


@pytest.mark.slow
def test_a_german_laboratory_file_is_read_by_the_command_of_the_docs(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    reading, identifying = command_of_the_docs()
    result = run(*reading)
    assert result.exit_code == 0, result.output
    result = run(*identifying, "--method", "model")
    assert result.exit_code == 0, result.output
    with (tmp_path / identifying[identifying.index("-o") + 1]).open() as file:
        rows = [row for row in csv.DictReader(file) if row["status"] == "slip"]
    assert len(rows) == 15
    errors = [(float(row["mu0 [1]"]) - 0.3) / float(row["deviation [1]"]) for row in rows]
    assert np.abs(errors).max() < 4.0 and np.abs(np.mean(errors)) < 4.0 / np.sqrt(len(rows))
    assert not any("recording as a whole" in row["doubt"] for row in rows)


def test_settings_of_a_file_are_those_of_the_options(tmp_path, monkeypatch):
    monkeypatch.chdir(ROOT)
    reading, _ = command_of_the_docs()
    reading[reading.index("-o") + 1] = str(tmp_path / "options.csv")
    assert run(*reading).exit_code == 0
    settings = ["--settings", "examples/laboratory.yaml", "-o", tmp_path / "file.csv"]
    assert run("import", LABORATORY, *settings).exit_code == 0
    assert (tmp_path / "file.csv").read_bytes() == (tmp_path / "options.csv").read_bytes()
    other = ["--settings", "examples/laboratory.yaml", "--speed", "2 mm/s"]
    assert run("import", LABORATORY, *other, "-o", tmp_path / "other.parquet").exit_code == 0
    table = pq.read_table(tmp_path / "other.parquet").to_pydict()
    assert table["footpoint"][-1] == pytest.approx(0.03, abs=1e-4)


def test_rest_approach_and_lift_off_are_found_without_a_position():
    found = imported(LABORATORY.read_bytes(), **settings_of_the_laboratory())
    # 2 s free, 1 s lowered, 2 s at rest; 15 mm at 1 mm/s.
    assert found.values["time"][0] == pytest.approx(5.0, abs=0.041)
    assert found.values["time"][-1] == pytest.approx(20.0, abs=0.041)
    assert any("lines 9 to 25" in said for said in found.said)


def settings_of_the_laboratory():
    return {
        "columns": {
            "time": "Zeit",
            "force_x": "-Kraft Fy",
            "force_y": "Kraft Fx",
            "moment_z": "Moment Mz",
        },
        "moment_origin": "0 mm, -20 mm",
        "tare": ["0 s, 1.9 s"],
        "speed": "1 mm/s",
    }


@pytest.mark.parametrize("seed", range(4))
def test_a_motion_of_large_steps_begins_behind_the_rest(seed):
    """A step of the readings that looks like a slip does not let samples of the rest in."""
    pushed = np.r_[np.zeros(60), 0.2 * np.arange(1, 80)]
    noise = np.random.default_rng(seed).normal(0.0, 0.01, (2, len(pushed)))
    fx, fy = noise + [[0.0], [-20.0]] + np.array([[-1.0], [-0.5]]) * pushed
    text = file_of([np.arange(len(pushed)) * 0.02, pushed, fx, fy])
    columns = {"time": "t", "force_x": "Fx [N]", "force_y": "Fy [N]"}
    found = imported(text, columns=columns, speed="1 mm/s")
    assert found.values["time"][0] == pytest.approx(1.2)
    said = "by the readings the stage begins to move in line 62, or up to 1 line before"
    assert any(text.startswith(said) for text in found.said)
    assert "no tare: readings without load are taken as 0" in found.said
    given = imported(text, columns=columns, speed="1 mm/s", begin="1 s", tare=["0 s, 1 s"])
    assert not any("begins to move" in text or "no tare" in text for text in given.said)


def test_the_load_is_that_of_the_rod_within_the_errors_of_the_zeros():
    found = imported(LABORATORY.read_bytes(), **settings_of_the_laboratory())
    signals = scan(
        MADE["WHISKER"],
        surfaces.constant(0.3),
        step="20 um",
        to=["15 mm"],
        law="kinetic",
        kinetic_ratio=0.8,
    )
    names = ("force_x", "force_y", "moment_z")
    shift = round((5.0 - found.values["time"][0]) * 50)
    read = np.stack([found.values[name] for name in names], axis=1)[shift:][:700]
    error = read - signals.readings[: len(read)]
    zero = np.array([found.zeros[name].deviation for name in names])
    assert np.abs(error.mean(axis=0) / zero).max() < 4.5
    turned_zeros = np.array([0.31, 0.12, 2.4e-3 - 0.02 * -0.31])
    told = np.array([found.zeros[name].value for name in names])
    assert np.abs((told - turned_zeros) / zero).max() < 4.5


def test_a_moment_about_another_point_has_the_arms_from_there():
    """The load acts at the contact: its arms from any point tell the moment about it."""
    whisker = Whisker.read(2, "85 mm", modulus="210 GPa", diameter="1 mm", length="100 mm")
    signals = scan(whisker, surfaces.constant(0.3), step="0.1 mm", to=["8 mm"])
    fx, fy, moment = signals.readings.T
    contact = (signals.truth.contact - signals.truth.clamp) * 0.1
    point = np.array([0.012, -0.03])
    arm = np.stack([contact, np.full(len(contact), 0.085)], axis=1) - point
    about = arm[:, 0] * fy - arm[:, 1] * fx
    assert np.abs(about - moment).max() > 1e-3
    values = {"force_x": fx, "force_y": fy, "moment_z": about}
    assert about_clamp(values, tuple(point))["moment_z"] == pytest.approx(moment, abs=1e-7)


@pytest.mark.parametrize("name", ["transducer_angle", "moment_origin_x", "moment_origin_y"])
def test_signs_are_those_of_the_tolerances(name):
    """What is undone is what `identify` calls an error of that size and sign."""
    readings = np.random.default_rng(3).standard_normal((5, 3))
    size = 1e-6
    undone = readings - size * readings @ MIXING[name].T
    values = dict(zip(("force_x", "force_y", "moment_z"), readings.T, strict=True))
    here = {
        "transducer_angle": lambda: turned(values, size),
        "moment_origin_x": lambda: about_clamp(values, (size, 0.0)),
        "moment_origin_y": lambda: about_clamp(values, (0.0, size)),
    }[name]()
    assert np.stack(list(here.values()), axis=1) == pytest.approx(undone, abs=1e-10)


def test_axes_turned_by_90_degrees_are_swapped_with_one_sign():
    text = file_of([np.arange(30), np.arange(30), np.full(30, 2.0), np.full(30, 5.0)])
    found = imported(text, columns=TITLED, turn="90 deg").values
    assert found["force_x"] == pytest.approx(-5.0) and found["force_y"] == pytest.approx(2.0)
    back = imported(text, columns=TITLED | {"force_x": "-Fy [N]", "force_y": "Fx [N]"}).values
    assert back["force_x"] == pytest.approx(found["force_x"])
    assert back["force_y"] == pytest.approx(found["force_y"])


@pytest.mark.slow
def test_a_zero_is_known_as_well_as_its_mean_scatters():
    rng, told, errors = np.random.default_rng(5), [], []
    for _ in range(60):
        noise = np.convolve(rng.standard_normal(427), np.ones(8) / 8, "valid")
        time = np.arange(len(noise)) * 0.01
        text = file_of([time, time, 0.4 + noise, -1.0 + noise])
        whole = {"begin": "0 s", "end": "9 s", "tare": ["0 s, 9 s"]}
        found = imported(text, columns=TITLED | {"time": "t"}, **whole)
        told.append(found.zeros["force_x"].deviation)
        errors.append(found.zeros["force_x"].value - 0.4)
    # The readings share their noise; as if they did not, it would be told too small by a factor 3.
    assert np.sqrt(np.mean(np.square(told))) == pytest.approx(np.std(errors), rel=0.35)
    assert np.mean(told) > 2.0 * 0.35 / np.sqrt(420)


def test_rest_and_lift_off_are_cut_where_the_position_was_recorded():
    x = np.concatenate([np.zeros(40), np.arange(200) * 0.02, np.full(60, 3.98)])
    fy = np.concatenate([np.linspace(0, -1, 40), np.full(200, -1.0), np.linspace(-1, 0, 60)])
    jitter = np.random.default_rng(2).uniform(-1e-3, 1e-3, len(x))
    found = imported(file_of([np.arange(len(x)), x + jitter, 0.1 * fy, fy]), columns=TITLED)
    assert found.values["force_y"] == pytest.approx(-1.0, abs=0.03)
    assert 199 <= len(found.values["force_y"]) <= 204
    assert any(said.startswith("left out, the clamp rests") for said in found.said)
    given = imported(
        file_of([np.arange(len(x)), x, 0.1 * fy, fy]), columns=TITLED, begin="1 mm", end="2 mm"
    )
    assert given.values["footpoint"] * 1e3 == pytest.approx(np.arange(1.0, 2.01, 0.02))
    # What is not said is found.
    begun = imported(file_of([np.arange(len(x)), x, 0.1 * fy, fy]), columns=TITLED, begin="1 mm")
    assert begun.values["footpoint"][0] == pytest.approx(1e-3)
    assert 149 <= len(begun.values["footpoint"]) <= 153
    ended = imported(file_of([np.arange(len(x)), x, 0.1 * fy, fy]), columns=TITLED, end="2 mm")
    # Why rows are left out is said as it is.
    half = "left out, as given, or the clamp rests, or no force acts"
    for one, why in ((given, "left out, as given"), (begun, half), (ended, half)):
        assert why in [said.partition(": lines")[0] for said in one.said]


def test_a_recording_without_rest_stays_whole():
    x = np.arange(120) * 0.02
    text = file_of([np.arange(120), x, np.sin(x), -1 + 0 * x])
    assert len(imported(text, columns=TITLED).values["footpoint"]) == 120


def test_missing_values_stay_missing():
    text = file_of([np.arange(50)] * 4).replace("7.0;7.0;7.0;7.0", "7.0;7.0;;NaN")
    found = imported(text, columns=TITLED)
    assert np.flatnonzero(np.isnan(found.values["force_x"])).tolist() == [7]
    assert "force_x is missing in 1 row" in found.said


def test_a_file_in_which_no_row_is_whole_is_kept():
    lines = file_of([np.arange(50)] * 4).split("\n")
    some = [line.split(";") for line in lines[1:]]
    for row, cells in enumerate(some):
        cells[2 + row % 2] = ""
    found = imported("\n".join([lines[0], *map(";".join, some)]), columns=TITLED)
    assert np.isfinite(found.values["force_x"]).sum() == 25 and len(found.values["footpoint"]) == 50
    assert {f"{name} is missing in 25 rows" for name in ("force_x", "force_y")} <= set(found.said)


@pytest.mark.parametrize(
    ("header", "unit", "size"),
    [
        ("Fx [mN]", "", 1e-3),
        ("Fx (mN)", "", 1e-3),
        ("Fx / mN", "", 1e-3),
        ("Fx in mN", "", 1e-3),
        ("Fx", " [mN]", 1e-3),
        ("Fx [N]", " [mN]", 1e-3),
    ],
)
def test_a_unit_stands_in_the_title_or_is_told(header, unit, size):
    text = file_of([np.arange(30)] * 4, f"t;x [mm];{header};Fy [N]")
    found = imported(text, columns=TITLED | {"force_x": f"-Fx{unit}"})
    assert found.values["force_x"] == pytest.approx(-np.arange(30) * size)
    assert any("although the file says N" in said for said in found.said) == (header == "Fx [N]")


@pytest.mark.parametrize("unit", ["Nmm", "N·mm", "N*mm", "mNm", "N mm"])
def test_a_moment_may_be_written_without_a_sign_between(unit):
    text = file_of([np.arange(30)] * 4, f"t;x [mm];M [{unit}];Fy [N]")
    found = imported(text, columns={"footpoint": "x", "moment_z": "M"})
    assert found.values["moment_z"] == pytest.approx(np.arange(30) * 1e-3)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({}, "none of force_x"),
        (
            {"columns": {"force_x": "Fz"}},
            r"no column Fz. There are in line 1: t, x, Fx, Fy \(--titles names another line\)",
        ),
        ({"columns": {"force_x": "Fx"}}, "Fx has no unit"),
        ({"columns": {"force_x": "Fx [mm]"}}, "must have the unit of a force"),
        ({"columns": {"fx": "Fx"}}, "column must be one of time, footpoint"),
        ({"columns": {"force_x": "-"}}, "needs the title"),
        ({"columns": {"force_x": "Fx [N]"}}, "--column 'footpoint=...', or give --speed"),
        ({"columns": {"force_x": "Fx [N]"}, "speed": "1 mm/s"}, "column time, or the rate"),
        ({"columns": {"force_x": "Fx [N]"}, "speed": "1 mm"}, "speed must be a speed"),
        ({"columns": TITLED, "speed": "1 mm/s"}, "give the speed or the column"),
        ({"columns": TITLED, "tare": ["0 s, 2 s"]}, "tare needs the column time"),
        ({"columns": TITLED, "tare": ["9 mm, 99 m"]}, "too few"),
        ({"columns": TITLED, "tare": ["2 s, 0 s"]}, "tare must go"),
        ({"columns": TITLED, "moment_origin": "1 mm, 0 mm"}, "no moment_z"),
        ({"columns": TITLED, "moment_origin": "1 mm"}, "needs two lengths"),
        ({"columns": TITLED, "begin": "4 m"}, "no row is left"),
        ({"columns": TITLED, "titles": 99}, "no line 99"),
        ({"columns": TITLED, "encoding": "Morse"}, "encoding must be"),
        ({"columns": TITLED, "decimal": ";"}, "decimal must be"),
        ({"columns": TITLED, "separator": "dash"}, "separator must be one of"),
        ({"columns": {"force_x": "x [N]", "time": "Fx [s]"}, "speed": "1 mm/s"}, "not increase"),
    ],
)
def test_mistakes_are_named(settings, message):
    text = file_of(
        [np.arange(8), np.arange(8) / 1e3, np.full(8, 2.0), np.full(8, -1.0)], "t;x;Fx;Fy"
    )
    with pytest.raises(VibrissaError, match=message) as caught:
        imported(text, **settings)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("colums: {}", "colums is no setting"),
        ("columns: 3", "columns must hold"),
        ("tare: 3", "tare must be"),
        ("titles: yes", "titles must be a number"),
        ("speed: 3", "speed must be a text"),
        ("- a", "must hold keys"),
        ("a: [", "not a YAML file"),
    ],
)
def test_mistakes_of_a_settings_file_are_named(text, message, tmp_path):
    (tmp_path / "import.yaml").write_text(text)
    result = run(
        "import", LABORATORY, "--settings", tmp_path / "import.yaml", "-o", tmp_path / "a.csv"
    )
    assert result.exit_code == 2 and message in result.output
    assert result.output.count("\n") == 1 and not (tmp_path / "a.csv").exists()


@pytest.mark.slow
def test_standard_input_and_output(tmp_path):
    arguments = ["--settings", ROOT / "examples/laboratory.yaml", "-o", "-"]
    piped = run("import", "-", *arguments, text=LABORATORY.read_bytes())
    assert piped.exit_code == 0 and piped.stdout.startswith("time [s],footpoint [m],force_x [N]")
    assert "read as cp1252" in piped.stderr and "751 rows" in piped.stderr
    found = run(
        "identify",
        "-",
        *WHISKER,
        *SI[:2],
        "--diameter",
        "0.8 mm",
        *SI[4:],
        "-o",
        "-",
        text=piped.stdout,
    )
    assert found.exit_code == 0 and found.stdout.startswith("status,contact [m]")
    assert "is random" in found.stderr and found.stdout.count("\n") == 17
    simulated = run("scan", *WHISKER, "--mu0", 0.3, "--step", 0.01, "--to", 0.2, "-o", "-")
    assert simulated.exit_code == 0 and simulated.stdout.count("\n") == 22


PIECES = st.sampled_from(
    [
        *(b"x [mm]", b"Fx [N]", b"Fy [N]", b";", b",", b"\t", b" ", b"\n", b"\r\n", b"1", b"2,5"),
        *(b"0.5", b"1,234", b"-", b'"', b"\xb5", b"\xff\xfe", b"NaN", b"e5", b"#", b"\x00"),
    ]
)


@given(st.lists(PIECES, max_size=60).map(b"".join) | st.binary(max_size=300))
def test_any_bytes_are_a_table_or_one_message(data):
    try:
        found = imported(data, columns=TITLED)
    except VibrissaError as error:
        assert "\n" not in str(error)
    else:
        assert len({len(values) for values in found.values.values()}) == 1
        assert all(not np.isinf(values).any() for values in found.values.values())
