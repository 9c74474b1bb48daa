"""Numbers, times, units and titles as programs and countries write them."""

import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vibrissa.errors import ArgumentError, RecordingError
from vibrissa.quantities.units import Kind
from vibrissa.sensor.importing import Settings, import_recording
from vibrissa.sensor.importing.clock import since_first
from vibrissa.sensor.importing.numbers import is_missing
from vibrissa.sensor.importing.titles import stated_in, unit_named

TIME = np.arange(30) / 10
TABLE = np.column_stack([TIME, 0.5 * TIME, -0.25 - 0.01 * TIME, -1.5 - 0.02 * TIME])
HEAD = "t [s];x [mm];Fx [N];Fy [N]"
NAMED = {"time": "t", "footpoint": "x", "force_x": "Fx", "force_y": "Fy"}
UNTIMED = {target: title for target, title in NAMED.items() if target != "time"}
ROWS = [";".join(f"{cell:.4f}" for cell in row) for row in TABLE]


def imported(lines, columns=NAMED, **settings):
    data = lines if isinstance(lines, bytes) else "\n".join(lines).encode()
    return import_recording(data, Settings.read(column=columns, **settings))


def checked(lines, columns=NAMED, **settings):
    found = imported(lines, columns, **settings)
    assert found.values["time"] == pytest.approx(TIME, abs=1e-6)
    assert found.values["footpoint"] * 1e3 == pytest.approx(TABLE[:, 1], abs=1e-9)
    for name, column in (("force_x", 2), ("force_y", 3)):
        assert found.values[name] == pytest.approx(TABLE[:, column], abs=1e-9)
    return found


def replaced(row, column, cell):
    cells = ROWS[row].split(";")
    cells[column] = cell
    return [HEAD, *ROWS[:row], ";".join(cells), *ROWS[row + 1 :]]


MISSING = [
    *("#N/A", "#NV", "#DIV/0!", "####", "1.#QNAN", "-1.#IND", "1.#INF", "<NA>", "inf", "-Infinity"),
    *("NaN", "-nan(ind)", "NULL", "None", "-", "--", ""),
]


@pytest.mark.parametrize("cell", MISSING)
def test_missing_values_have_many_spellings(cell):
    assert is_missing(cell)


@pytest.mark.parametrize("cell", ["0", "-1", "ok", "1e999", "#", "# tapped", "infinite"])
def test_other_cells_have_a_value(cell):
    assert not is_missing(cell)


@pytest.mark.parametrize("cell", ["#N/A", "####", "-1.#IND", ""])
def test_a_missing_value_keeps_its_row_wherever_it_stands(cell):
    values = imported(replaced(5, 2, cell)).values
    assert len(values["time"]) == 30
    assert np.flatnonzero(np.isnan(values["force_x"])).tolist() == [5]
    first = [line.replace("t [s]", "n") for line in replaced(5, 0, cell)]
    checked(first, UNTIMED, rate="10 Hz")


def test_a_comment_is_no_sample():
    lines = [HEAD, *ROWS[:5], "# tapped", "### 1;2;3;4", "// again", *ROWS[5:]]
    assert "comments in 3 rows, left out: line 7-9" in checked(lines).notes


@pytest.mark.parametrize("cell", ["-0.2550D+00", "-2.550E-1", "-.2550d0"])
def test_an_exponent_may_be_that_of_fortran(cell):
    checked(replaced(5, 2, cell))


def grouped(value, group, decimal):
    return f"{value:,.2f}".replace(",", "_").replace(".", decimal).replace("_", group)


THOUSANDS = [(".", ",", ";"), (",", ".", ";"), (",", ".", ","), ("'", ".", ";"), ("’", ",", "\t")]
THOUSANDS += [(" ", ",", ";"), ("\u202f", ",", ";"), ("\u00a0", ".", "|")]


@pytest.mark.parametrize(("group", "decimal", "separator"), THOUSANDS)
def test_separators_of_thousands_are_read(group, decimal, separator):
    table = TABLE[:, [0, 1, 1, 1]] + [0.0, 0.0, 1234567.0, -1234.5]
    quote = '"' if separator in (group, decimal) else ""
    lines = [
        separator.join(f"{quote}{grouped(cell, group, decimal)}{quote}" for cell in row)
        for row in table
    ]
    found = imported([HEAD.replace(";", separator), *lines]).values
    assert found["force_x"] == pytest.approx(np.round(table[:, 2], 2))
    assert found["force_y"] == pytest.approx(np.round(table[:, 3], 2), abs=0.006)


@pytest.mark.slow
@settings(max_examples=20, deadline=None)
@given(
    st.lists(st.integers(-(10**10), 10**10), min_size=12, max_size=30),
    st.sampled_from([".,", ",."]),
)
def test_numbers_with_groups_come_back_or_are_asked_for(numbers, signs):
    group, decimal = signs
    rows = [numbers[i : i + 3] for i in range(0, len(numbers) - 2, 3)]
    lines = [";".join(grouped(one / 100, group, decimal) for one in row) for row in rows]
    columns = {"footpoint": "#1 [m]", "force_x": "#2 [N]", "force_y": "#3 [N]"}
    found = imported(lines, columns, rate="1 Hz").values
    read = np.stack([found[name] for name in columns], axis=1)
    assert read == pytest.approx(np.array(rows) / 100)


def test_groups_that_no_number_proves_are_refused_with_their_cause():
    lines = replaced(5, 3, "1,234")
    with pytest.raises(RecordingError, match=r"(?s)line 7: force_y .*'1,234' seems to have a sep"):
        imported(lines)


@pytest.mark.parametrize("encoding", ["utf-8", "utf-16", "utf-16-le", "utf-16-be", "cp1252"])
@pytest.mark.parametrize("end", ["", "\0" * 500])
def test_encodings_are_found_and_nul_bytes_at_the_end_left_out(encoding, end):
    text = "\n".join(["Prüfstand 7", HEAD, *ROWS]) + "\n" + end
    checked(text.encode(encoding))


def clocked(times, date=""):
    """Write times of a clock beginning at 23:59:59."""
    seconds = [round(86399 + time, 3) for time in times]
    cells = [
        f"{date.format(day=11 + int(one // 86400))}{int(one % 86400) // 3600:02d}:"
        f"{int(one % 3600) // 60:02d}:{one % 60:06.3f}"
        for one in seconds
    ]
    return ["t;x [mm];Fx [N];Fy [N]", *map(later, cells, ROWS)]


def later(cell, row):
    return ";".join([cell, *row.split(";")[1:]])


DATES = ["", "2026-03-{day} ", "2026-03-{day}T", "2026/03/{day} ", "{day}.03.2026 "]


@pytest.mark.parametrize("date", DATES)
def test_times_of_a_clock_count_from_the_first_row_past_midnight(date):
    found = checked(clocked(TIME, date))
    assert "time: t in s (times of a clock), from the first row" in found.notes
    cut = imported(clocked(TIME, date), **{"from": "0.5 s", "to": "1 s"}).values["time"]
    assert cut == pytest.approx(TIME[5:11])


@pytest.mark.parametrize("date", DATES[1:])
def test_a_clock_takes_its_dates_from_another_column(date):
    # By the clock alone the second half of the rows would seem to come on the same day.
    days = [0 if number < len(TIME) // 2 else 86400 for number in range(len(TIME))]
    cells = clocked(TIME + np.array(days) - 1.0, date.strip(" T") + " ")[1:]
    rows = [cell.replace(" ", ";", 1) for cell in cells]
    found = imported(["Day;t;x [mm];Fx [N];Fy [N]", *rows])
    assert found.values["time"] == pytest.approx(TIME + days)
    assert (
        "time: t in s (times of a clock with the dates in Day), from the first row" in found.notes
    )


@pytest.mark.parametrize("titles", ["stamp.sec;stamp.nanosec", "t_secs;t_nsecs", "sec;nanosec"])
def test_seconds_and_nanoseconds_of_ros_are_one_time(titles):
    first, second = titles.split(";")
    late = [1773310350.7 + time for time in TIME]
    cells = [f"{int(time)};{round(1e9 * (time % 1)):d}" for time in late]
    rows = list(map(later, cells, ROWS))
    found = imported([f"{titles};x [mm];Fx [N];Fy [N]", *rows], NAMED | {"time": first})
    assert found.values["time"] == pytest.approx(TIME, abs=1e-6)
    assert f"time: {first} in s plus {second} in ns, from the first row" in found.notes


def test_dates_that_may_be_read_in_two_ways_are_refused():
    with pytest.raises(RecordingError, match="11/03/2026 to 12/03/2026 may be day/month or month"):
        imported(clocked(TIME, "{day}/03/2026 "))


def test_half_days_and_missing_times():
    import pandas as pd

    cells = pd.Series(["11:59:59 AM", "", "12:00:01 pm", "1:00:00 PM"])
    found = since_first(cells, "a", np.array([False, True, False, False]))
    assert found == pytest.approx([0.0, np.nan, 2.0, 3601.0], nan_ok=True)


@pytest.mark.parametrize(("unit", "size"), [("s", 1), ("ms", 1e3), ("us", 1e6), ("ns", 1e9)])
def test_counts_since_1970_count_from_the_first_row(unit, size):
    stamps = [f"{int(1770000000 * size) + round(time * size)}" for time in TIME]
    if unit == "s":
        stamps = [f"{1770000000 + time:.3f}" for time in TIME]
    found = checked(["%t;x [mm];Fx [N];Fy [N]", *map(later, stamps, ROWS)])
    assert any(f"t in {unit} since 1970, from the first row" in note for note in found.notes)
    checked([f"t [{unit}];x [mm];Fx [N];Fy [N]", *map(later, stamps, ROWS)])


def test_a_window_beyond_the_file_names_its_ends():
    with pytest.raises(RecordingError, match=r"times of the file are 0 s to 2\.9 s, the clamp pos"):
        imported([HEAD, *ROWS], **{"from": "99 s"})
    with pytest.raises(RecordingError, match=r"clamp positions of the file are 0 mm to 1\.45 mm$"):
        imported([HEAD, *ROWS], tare="30 mm, 40 mm")


UNITS = [
    *(("Newton", Kind.FORCE, 1.0), ("Newtons", Kind.FORCE, 1.0), ("kp", Kind.FORCE, 9.80665)),
    *(("kg", Kind.FORCE, 9.80665), ("g", Kind.FORCE, 9.80665e-3), ("lb", Kind.FORCE, 4.448222)),
    *(("MM", Kind.LENGTH, 1e-3), ("Sec", Kind.TIME, 1.0), ("Ncm", Kind.MOMENT, 0.01)),
    *(("in-lbf", Kind.MOMENT, 0.1129848), ("oz-in", Kind.MOMENT, 0.00706155)),
    *(("lb-in", Kind.MOMENT, 0.1129848), ("NMM", Kind.MOMENT, 1e-3), ("MN", Kind.FORCE, 1e6)),
]


@pytest.mark.parametrize(("text", "kind", "size"), UNITS)
def test_units_are_known_by_the_names_that_programs_give_them(text, kind, size):
    unit = unit_named(text, kind)
    assert unit.size == pytest.approx(size, rel=1e-6)
    assert ("taken as a force" in unit.remark) == (text in ("kg", "g", "lb", "oz-in", "lb-in"))


@pytest.mark.parametrize(
    ("text", "kind"), [("kg", Kind.LENGTH), ("V", Kind.FORCE), ("", Kind.TIME)]
)
def test_other_texts_are_no_units(text, kind):
    assert unit_named(text, kind) is None


def test_an_ending_that_may_be_a_word_is_no_unit_or_is_shown_as_a_question():
    columns = {"time": "t", "footpoint": "x_in", "force_x": "F_dyn", "force_y": "F_N"}
    with pytest.raises(RecordingError) as error:
        imported(["t_s;x_in;F_dyn;F_N", *ROWS], columns)
    assert "column x_in has no unit: add it" in str(error.value)
    assert "column F_dyn has no unit: add it" in str(error.value)
    found = checked(["t_s;x_mm;Fx_N;F_N", *ROWS], NAMED | {"force_y": "F_N"})
    assert (
        'force_y: F_N in N? The ending may be no unit: if so, state the unit, as in --column "'
        in (next(note for note in found.notes if note.startswith("force_y")))
    )
    # A unit that is stated, or in a row of units, is none in question.
    found = imported(["t_s;x_mm;Fx_N;F_N", "s;mm;mN;mN", *ROWS], NAMED | {"force_y": "F_N"})
    assert "force_y: F_N in mN" in found.notes


@pytest.mark.parametrize(
    ("head", "columns", "message"),
    [
        (HEAD, {"force_x": "Fx [mN]"}, "column Fx [N] is in N by the file, but in mN by the opt"),
        ("t;x;Fx;Fy\ns;mm;N;N", {"force_x": "Fx [mN]"}, "column Fx is in N by the file, but in mN"),
        ("t;x;Fx;Fy\ns;mm;V;N", {"force_x": "Fx [mN]"}, '"force_x=Fx * 2.5 N/V"'),
        ("t;x;Fx [N];Fy\ns;mm;mN;N", {}, "column Fx [N] is in N and mN by the file: state which"),
        ("t;x;Fx;Fy\ns;mm;V;N", {}, "got 'V'; convert a voltage by a factor"),
        (HEAD, {"force_x": "Fx * 2 N/V"}, "is in N by the file, but its factor is N/V"),
        (HEAD, {"force_x": "Fx * 2 mm/N"}, "factor of column Fx [N] must be in N per unit"),
    ],
)
def test_units_that_contradict_the_file_are_refused(head, columns, message):
    with pytest.raises(RecordingError, match=re.escape(message)):
        imported([head, *ROWS], NAMED | columns)


def test_a_unit_that_decides_between_two_of_the_file_is_taken():
    lines = ["t;x;Fx [N];Fy\ns;mm;mN;N", *ROWS]
    assert imported(lines, NAMED | {"force_x": "Fx [mN]"}).values["force_x"][0] == -0.25e-3


@pytest.mark.parametrize(
    ("title", "source", "size"),
    [
        ("Ch1 [V]", "Ch1 * 12.5 N/V", 12.5),
        ("Ch1 [mV]", "-Ch1 * 12.5 N/V", -0.0125),
        ("Ch1", "Ch1 [mV] * 12.5 N/V", 0.0125),
        ("Ch1", "Ch1 * -2e-3 mN/count", -2e-6),
        ("Ch1 [counts]", "Ch1 * 2 mN/counts", 2e-3),
        ("Ch1", "Ch1 * 2 mN", 2e-3),
        ("Ch1 [N]", "Ch1 * 0.001", 1e-3),
        ("Ch1 * 2 [mN]", "Ch1 * 2 [mN]", 1e-3),
    ],
)
def test_a_factor_converts_a_signal(title, source, size):
    head = f"t [s];x [mm];{title};Fy [N]"
    found = imported([head, *ROWS], NAMED | {"force_x": source})
    assert found.values["force_x"] == pytest.approx(size * TABLE[:, 2])


def test_a_factor_must_be_a_number():
    with pytest.raises(
        ArgumentError, match=r"the factor of column Ch1 must be a number, got '1\.2\.3"
    ):
        stated_in("Ch1 * 1.2.3 N/V")


HEADS = {
    "dashes": [HEAD, "---;---;---;---"],
    "units that are half unknown": ["t;x;Fx;Fy", "s;mm;rpm;bar"],
    "remarks": [HEAD, "raw;raw;raw;raw"],
    "numbers of the columns": ["t;x;Fx;Fy", "s;mm;N;N", "1;2;3;4"],
    "numbers from 0": [HEAD, "0;1;2;3"],
}


@pytest.mark.parametrize("name", HEADS)
def test_lines_below_the_titles_are_no_titles_and_no_sample(name):
    known = {"force_x": "Fx [N]", "force_y": "Fy [N]"} if "unknown" in name else {}
    found = checked([*HEADS[name], *ROWS], NAMED | known)
    assert "titles in line 1" in found.notes[0]
    assert any("numbers of the columns" in note for note in found.notes) == ("numbers" in name)


def test_whole_numbers_are_a_sample():
    rows = [f"{n};{n + 1};{n + 2};{n + 3}" for n in range(1, 9)]
    assert len(imported([HEAD, *rows]).values["time"]) == 8


def test_lines_of_titles_and_units_may_be_stated():
    lines = ["t;x;Fx;Fy", "s;mm;N;N", "raw;cal;a;b", *ROWS]
    with pytest.raises(
        RecordingError, match=r"add its number, .* --title-line 7 \(line 1: t, x, Fx"
    ):
        imported(lines)
    checked(lines, title_line="1")
    checked(
        ["t;x;F;M", "s;mm;N;N", *ROWS], {**NAMED, "force_x": "#3", "force_y": "#4"}, unit_line="2"
    )
    with pytest.raises(
        RecordingError, match="--unit-line 9 is no line above the table with 4 cells"
    ):
        imported(lines, unit_line="9")


def test_remarks_beyond_the_last_column_are_left_out():
    lines = [HEAD, *ROWS[:7], ROWS[7] + ";tapped", *ROWS[8:]]
    assert "remarks beyond the last column in 1 row, left out: line 9" in checked(lines).notes
    shorter = [f"{row};ok" for row in ROWS]
    shorter[4] = ROWS[4]
    checked([f"{HEAD};remark", *shorter])
    with pytest.raises(RecordingError, match="line 9: 5 values, but line 2 has 4"):
        imported([HEAD, *ROWS[:7], ROWS[7] + ";0.5", *ROWS[8:]])


@pytest.mark.parametrize(
    ("stated", "message"),
    [
        ({"rate": "100 Hz"}, r"--rate is 100 Hz, but by the column t \[s\] it is 10 Hz: leave out"),
        (
            {"speed": "5 mm/s", "from": "0 s", "to": "2 s"},
            "10 mm from .*footpoint .* by 1 mm: leav",
        ),
    ],
)
def test_settings_that_contradict_the_file_are_refused(stated, message):
    columns = UNTIMED if "rate" in stated else NAMED
    columns = {name: title for name, title in columns.items() if name != "footpoint"}
    lines = [HEAD.replace("x [mm]", "footpoint [mm]"), *ROWS]
    with pytest.raises(RecordingError, match=message):
        imported(lines, columns, **stated)


def test_settings_that_agree_with_the_file_are_taken():
    lines = [HEAD.replace("x [mm]", "footpoint [mm]"), *ROWS]
    columns = {"force_x": "Fx", "force_y": "Fy"}
    checked(lines, columns, rate="10 Hz")
    checked(lines, columns | {"time": "t"}, speed="0.5 mm/s", **{"from": "0 s", "to": "9 s"})
    # A coarse clock may differ by its step.
    coarse = [later(f"10:12:{30 + int(t)}", row) for t, row in zip(TIME, ROWS, strict=True)]
    checked([HEAD.replace("x [mm]", "footpoint [mm]"), *coarse], columns, rate="10 Hz")
