"""Tables of the sensor: what is written, what is read of it, and what a mistake is called."""

import io
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from steel import Given
from vibrissa.errors import ArgumentError, RecordingError
from vibrissa.quantities import series
from vibrissa.quantities.series import Column

COLUMNS = {
    "footpoint": Column(np.array([0.1, np.nan, 1e-300]), "mm", "position of the clamp"),
    "period": Column(np.array([1, 2, 3]), "1", "number"),
    "side": Column(np.array(["ahead", "behind", ""]), "", "where the tip is"),
}
TEXT = "footpoint [mm],period [1],side\n0.1,1,ahead\nnan,2,behind\n1e-300,3,\n"


def read(tmp_path, text, names=("a",), optional=(), name="r.csv"):
    path = tmp_path / name
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return series.read(path, names, optional)


def test_a_csv_file_is_written_as_it_is_said(tmp_path, capsys):
    series.write(tmp_path / "a.CSV", Given(COLUMNS))
    assert (tmp_path / "a.CSV").read_bytes() == TEXT.encode()
    series.write(Path("-"), Given(COLUMNS))
    assert capsys.readouterr().out == TEXT


@pytest.mark.parametrize("name", ["a.csv", "a.parquet", "a.Parquet"])
def test_what_is_written_is_read(tmp_path, name):
    path = tmp_path / name
    series.write(path, Given(COLUMNS))
    table = series.read(path, ["footpoint"], ["period", "height"])
    assert list(table.columns) == ["footpoint", "period"]
    assert table.columns["footpoint"] == pytest.approx([0.1, np.nan, 1e-300], nan_ok=True, rel=0)
    assert table.columns["period"].tolist() == [1.0, 2.0, 3.0]
    assert table.units == {"footpoint": "mm", "period": "1"}
    first = 2 if name == "a.csv" else 1
    assert table.line.tolist() == [first, first + 1, first + 2]
    assert table.place(1) == f"{path}, line {first + 1}"


def test_a_parquet_file_says_unit_and_meaning_of_each_column(tmp_path):
    series.write(tmp_path / "a.parquet", Given(COLUMNS))
    attrs = pd.read_parquet(tmp_path / "a.parquet").attrs
    assert attrs["units"] == {"footpoint": "mm", "period": "1", "side": ""}
    assert attrs["descriptions"]["side"] == "where the tip is"


def test_lines_are_those_of_the_file_whatever_stands_between(tmp_path):
    table = read(tmp_path, '\ufeff# a line\na [N] ,"b,c"\r\n1,2\n\n"3","4,"\r5,6\n')
    assert table.columns["a"].tolist() == [1.0, 3.0, 5.0] and table.units == {"a": "N"}
    assert table.line.tolist() == [3, 5, 6] and table.header == {}
    (tmp_path / "c.csv").write_text("a,b,b,,\n1,2,3,,\n")  # what is not needed may occur twice
    assert series.read(tmp_path / "c.csv", ["a"]).columns["a"].tolist() == [1.0]


@pytest.mark.parametrize("name", ["a.csv", "a.parquet"])
def test_quantities_of_the_whole_table_are_read_as_they_are_written(tmp_path, name):
    header = {"zero_force_x": "310.254 ± 0.27 mN", "zero_force_y": "1 ± 2 N"}
    series.write(tmp_path / name, Given(COLUMNS, header))
    assert series.read(tmp_path / name, ["footpoint"]).header == header
    frame = pd.DataFrame({"footpoint [mm]": [1.0]})
    frame.attrs["header"] = header
    assert series.read(frame, ["footpoint"]).header == header


def test_standard_input_is_read(monkeypatch):
    monkeypatch.setattr("sys.stdin", SimpleNamespace(buffer=io.BytesIO(TEXT.encode())))
    table = series.read(Path("-"), ["footpoint"])
    assert table.source == "standard input" and len(table.line) == 3


def test_a_frame_has_units_in_its_titles_or_beside_them():
    frame = pd.DataFrame({"a [N]": [1.0, None], "b": ["2", " NA "], "c": [True, False]})
    frame.attrs["units"] = {"b": "m", "a": "kN"}
    table = series.read(frame, ["a", "b"])
    assert table.units == {"a": "N", "b": "m"} and table.line.tolist() == [1, 2]
    assert np.isnan(table.columns["a"]).tolist() == [False, True]
    assert np.isnan(table.columns["b"]).tolist() == [False, True]
    with pytest.raises(
        RecordingError, match=r"the DataFrame, line 1: c must be empty or a number.*got 'True'"
    ):
        series.read(frame, ["c"])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("b,c\n1,2\n", "r.csv: column a is missing; the columns are: b, c"),
        ("", "r.csv: column a is missing; the columns are: none"),
        ("a\n", "r.csv: the table has no rows"),
        ("a,b\n1,2\n3\n", "r.csv, line 3: 1 value, but line 1 has 2"),
        ("a,b\n1,2,3\n", "r.csv, line 2: 3 values, but line 1 has 2"),
        ("a [N],b,a [m]\n1,2,3\n", "r.csv: column a occurs twice"),
        (b"a\n\xff\n", "r.csv: not a text file in UTF-8"),
        ('a\n"1"2\n', "r.csv, line 2: unpaired quotes (',' expected after '\"')"),
    ],
)
def test_a_mistake_is_named_with_its_place(tmp_path, text, message):
    with pytest.raises(RecordingError) as raised:
        read(tmp_path, text)
    assert str(raised.value) == f"{tmp_path}/{message}"


@pytest.mark.parametrize(
    "cell", ["inf", "1_0", "1 2", "1..", "١", "1e999", "1e60", "0x1", "True", "+"]
)
def test_all_wrong_cells_are_named(tmp_path, cell):
    with pytest.raises(RecordingError) as raised:
        read(tmp_path, f"a,b\n1,{cell}\n{cell},2\n", ["a", "b"])
    must = f"must be empty or a number such as 0.012 or 1.2e-2, at most 1e+50, got {cell!r}"
    where = f"{tmp_path / 'r.csv'}, line"
    assert str(raised.value).splitlines() == [f"{where} 2: b {must}", f"{where} 3: a {must}"]


def test_of_many_wrong_lines_some_are_named(tmp_path):
    with pytest.raises(RecordingError) as raised:
        read(tmp_path, "a\n" + 50 * "x\n")
    assert len(str(raised.value).splitlines()) == 11 and str(raised.value).endswith("and 40 more")
    with pytest.raises(RecordingError, match=r"(?s)line 3: 1 value, .*line 4: 3 values"):
        read(tmp_path, "a,b\n1,2\n3\n1,2,3\n")


NUMBERS = [("1", 1.0), (" -1.5E+3 ", -1500.0), ("+.5", 0.5), ("5.", 5.0)]
MISSING = ["", " ", "NaN", " nan ", "NA", "na", "null", "None", "-"]


@pytest.mark.parametrize(("cell", "value"), [*NUMBERS, *((cell, np.nan) for cell in MISSING)])
def test_numbers_are_read_as_they_are_written_and_missing_values_are_nan(tmp_path, cell, value):
    (found,) = read(tmp_path, f"a,b\n{cell},x\n").columns["a"]
    assert found == pytest.approx(value, rel=0, nan_ok=True)


def test_a_file_that_cannot_be_is_refused_before_any_work(tmp_path):
    with pytest.raises(ArgumentError, match=r"a\.txt: the ending must be \.csv or \.parquet"):
        series.write(tmp_path / "a.txt", Given(COLUMNS))
    with pytest.raises(FileNotFoundError):
        series.write(tmp_path / "no" / "a.csv", Given(COLUMNS))
    (tmp_path / "a.parquet").write_text("a\n1\n")
    with pytest.raises(RecordingError, match=r"a\.parquet: not a Parquet file: "):
        series.read(tmp_path / "a.parquet", ["a"])
    with pytest.raises(ValueError, match="length"):
        series.write(tmp_path / "b.csv", Given(COLUMNS | {"more": Column([1.0], "", "")}))
    assert not (tmp_path / "b.csv").exists()


def test_a_result_is_a_frame_with_its_units():
    frame = Given(COLUMNS).to_pandas()
    assert list(frame) == list(COLUMNS) and frame["side"].tolist() == ["ahead", "behind", ""]
    assert frame.attrs == {
        "header": {},
        "units": {"footpoint": "mm", "period": "1", "side": ""},
        "descriptions": {name: one.description for name, one in COLUMNS.items()},
    }
