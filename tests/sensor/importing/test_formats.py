"""The same small recording in each format, written by a library and read by `vibrissa import`."""

import datetime
import io
import struct

import h5py
import nptdms
import numpy as np
import openpyxl
import pandas as pd
import pytest
from scipy.io import savemat

from vibrissa.errors import MissingExtraError, RecordingError
from vibrissa.sensor.importing import Settings, import_recording

TIME = np.arange(20) * 0.02
TABLE = np.column_stack([TIME, 1.5 * TIME, -0.3 - TIME, -0.5 + 0.1 * TIME])
TITLES, UNITS = ["t", "Weg", "Fx", "Fz"], ["s", "mm", "N", "N"]
UNITLESS = {"time": "t [s]", "footpoint": "Weg [mm]", "force_x": "Fx [N]", "force_y": "Fz [N]"}
NAMED = {target: source.partition(" ")[0] for target, source in UNITLESS.items()}


def checked(data, columns=NAMED, **settings):
    found = import_recording(data, Settings.read(column=columns, **settings), "file.mat")
    values = found.values
    assert values["time"] - values["time"][0] == pytest.approx(TIME, abs=1e-6)
    for name, size, column in zip(list(NAMED)[1:], [1e3, 1, 1], TABLE.T[1:], strict=True):
        assert values[name] * size == pytest.approx(column, abs=1e-12)
    return found


def spreadsheet(**sheets):
    book = openpyxl.Workbook()
    book.remove(book.active)
    for name, rows in sheets.items():
        sheet = book.create_sheet(name)
        for row in rows:
            sheet.append(row)
    file = io.BytesIO()
    book.save(file)
    return file.getvalue()


ROWS = [["Prüfer", "M"], [], TITLES, UNITS, *TABLE.tolist()]


def test_a_spreadsheet_is_read():
    found = checked(spreadsheet(Info=[["Prüfstand", 7]], Daten=ROWS))
    assert found.notes[0].startswith(
        "sheet Daten, decimal point, titles in line 3, units in line 4"
    )


def test_cells_of_a_spreadsheet_may_be_dates_and_errors():
    begin = datetime.datetime(2026, 3, 12, 23, 59, 59, 900_000)
    times = [begin + datetime.timedelta(seconds=time) for time in TIME]
    rows = [[time, *row[1:]] for time, row in zip(times, TABLE.tolist(), strict=True)]
    checked(spreadsheet(Daten=[["t", *TITLES[1:]], UNITS, *rows]))
    rows[3][2] = "#N/A"
    found = import_recording(
        spreadsheet(Daten=[["t", *TITLES[1:]], UNITS, *rows]), Settings.read(column=NAMED)
    )
    assert np.flatnonzero(np.isnan(found.values["force_x"])).tolist() == [3]


def matlab(variables):
    file = io.BytesIO()
    savemat(file, variables)
    return file.getvalue()


def matlab_hdf(variables):
    """Write as MATLAB 7.3 does: an HDF5 file after 512 bytes, with the class of each variable."""
    file = io.BytesIO()
    with h5py.File(file, "w", userblock_size=512) as hdf:

        def write(group, key, value):
            if isinstance(value, dict):
                struct = group.create_group(key)
                struct.attrs["MATLAB_class"] = np.bytes_("struct")
                for name, one in value.items():
                    write(struct, name, one)
                return
            array = np.atleast_2d(value).T
            data = group.create_dataset(key, data=array)
            data.attrs["MATLAB_class"] = np.bytes_("double")

        for key, value in variables.items():
            write(hdf, key, value)
    data = bytearray(file.getvalue())
    begin = b"MATLAB 7.3 MAT-file, Platform: GLNXA64"
    data[: len(begin)] = begin
    return bytes(data)


STRUCT = {"rec": dict(zip(TITLES, TABLE.T, strict=True)), "gain": 3.0, "name": "Versuch 7"}


@pytest.mark.parametrize("written", [matlab, matlab_hdf])
def test_variables_of_matlab_are_read(written):
    checked(written(dict(zip(TITLES, TABLE.T, strict=True)) | {"gain": [[1.0, 2.0]]}), UNITLESS)
    checked(written({key: STRUCT[key] for key in ("rec", "gain")}), UNITLESS)


def test_a_matrix_beside_its_times_is_read():
    columns = UNITLESS | {"footpoint": "F(:,1) [mm]", "force_x": "F(:,2) [N]"}
    columns["force_y"] = "F(:,3) [N]"
    found = checked(matlab({"t": TIME, "F": TABLE[:, 1:], **{"name": "x"}}), columns)
    assert found.notes[0] == "table t, 20 rows"


def test_several_structs_are_listed_and_one_is_chosen():
    struct = STRUCT["rec"]
    data = matlab({"first": struct, "second": struct | {"Fx": 2 * struct["Fx"]}})
    with pytest.raises(RecordingError) as error:
        checked(data, UNITLESS)
    assert str(error.value).splitlines() == [
        "file.mat: there are several tables: choose one, as in --table 'first'",
        "  first: 20 rows of t, Weg, Fx, Fz",
        "  second: 20 rows of t, Weg, Fx, Fz",
    ]
    checked(data, UNITLESS, table="first")
    with pytest.raises(RecordingError, match="there is no table called 'third': choose one"):
        checked(data, UNITLESS, table="third")


def test_sheets_and_groups_are_listed_too():
    sheets = spreadsheet(A=ROWS, B=ROWS)
    groups = tdms({"A": True, "B": True})
    for data, columns in ((sheets, NAMED), (groups, NAMED | {"time": "time"})):
        with pytest.raises(RecordingError, match="choose one, as in --table 'A'\n  A: 20 rows"):
            checked(data, columns)
        checked(data, columns, table="B")


def tdms(groups):
    file = io.BytesIO()
    with nptdms.TdmsWriter(file) as writer:
        for group, waveform in groups.items():
            begin = 0 if not waveform else 1
            channels = [
                nptdms.ChannelObject(
                    group,
                    title,
                    column,
                    properties={"unit_string": unit}
                    | ({"wf_increment": 0.02, "wf_start_offset": 0.0} if waveform else {}),
                )
                for title, unit, column in list(zip(TITLES, UNITS, TABLE.T, strict=True))[begin:]
            ]
            writer.write_segment(channels)
    return file.getvalue()


@pytest.mark.parametrize("waveform", [False, True])
def test_a_tdms_file_is_read_with_its_units_and_its_time(waveform):
    checked(tdms({"Messung": waveform}), NAMED | {"time": "time" if waveform else "t"})


def test_times_of_day_of_a_tdms_file_count_from_the_first():
    file = io.BytesIO()
    times = np.datetime64("2026-03-12T23:59:59.9", "us") + (TIME * 1e6).astype("timedelta64[us]")
    with nptdms.TdmsWriter(file) as writer:
        columns = zip(TITLES, [times, *TABLE.T[1:]], strict=True)
        writer.write_segment([nptdms.ChannelObject("a", *column) for column in columns])
    checked(file.getvalue(), UNITLESS | {"time": "t"})


@pytest.mark.parametrize("clock", [False, True])
def test_a_parquet_file_is_read(clock):
    frame = pd.DataFrame(dict(zip(TITLES, TABLE.T, strict=True)))
    frame.attrs["units"] = dict(zip(TITLES, UNITS, strict=True))
    if clock:
        frame.index = pd.Timestamp("2026-03-12") + pd.to_timedelta(frame.pop("t"), unit="s")
    file = io.BytesIO()
    frame.to_parquet(file)
    checked(file.getvalue())


LVM_HEAD = """LabVIEW Measurement\t
Writer_Version\t2
Separator\tTab
Decimal_Separator\t,
X_Columns\t{columns}
***End_of_Header***\t
"""
SEGMENT = """\t
Channels\t3\t\t\t
Samples\t10\t10\t10\t
Y_Unit_Label\tmm\tN\tN\t
X_Dimension\tTime\tTime\tTime\t
X0\t{begin}\t{begin}\t{begin}\t
Delta_X\t0,020000\t0,020000\t0,020000\t
***End_of_Header***\t\t\t\t
X_Value\tWeg\tFx\tFz\tComment
"""


def labview(columns="One", segments=((0, 10), (10, 20))):
    text = LVM_HEAD.format(columns=columns)
    for first, last in segments:
        text += SEGMENT.format(begin=f"{TIME[first]:.2f}".replace(".", ","))
        for row in TABLE[first:last]:
            cells = ["" if columns == "No" else f"{row[0]:.6f}", *(f"{one:.6f}" for one in row[1:])]
            remark = "\ttapped" if row[0] == TIME[first + 3] else ""
            text += "\t".join(cells).replace(".", ",") + remark + "\n"
    return text.encode()


def test_segments_of_a_labview_file_are_joined_where_their_times_go_on():
    checked(labview(), NAMED | {"time": "X_Value"})
    with pytest.raises(RecordingError, match="several tables: choose one, as in --table '1'"):
        checked(labview(segments=((0, 10), (0, 10))), NAMED | {"time": "X_Value"})


def test_no_segment_of_a_labview_file_is_lost_in_silence():
    """`lvm_read` takes a segment without an empty line before it for a part of the file's head."""
    head, rest = LVM_HEAD.format(columns="One"), labview()[len(LVM_HEAD.format(columns="One")) :]
    data = (head.rstrip() + "\n").encode() + rest.lstrip()
    with pytest.raises(RecordingError, match=r"of 2 segments .* only 1 can be read"):
        checked(data, NAMED | {"time": "X_Value"})


def test_times_that_a_labview_file_leaves_out_are_computed():
    checked(labview("No", [(0, 20)]), NAMED | {"time": "time"})


@pytest.mark.parametrize(
    ("data", "library"),
    [
        (spreadsheet(A=ROWS), "python_calamine"),
        (matlab_hdf(STRUCT["rec"]), "mat73"),
        (tdms({"A": True}), "nptdms"),
        (labview(), "lvm_read"),
    ],
)
def test_a_missing_library_is_one_line(data, library, monkeypatch):
    monkeypatch.setattr("vibrissa.extras.find_spec", lambda name: None if name == library else True)
    with pytest.raises(MissingExtraError) as error:
        checked(data)
    assert str(error.value) == f"this needs {library}: pip install 'vibrissa[files]'"


@pytest.mark.parametrize(
    "data",
    [
        spreadsheet(A=ROWS)[:2000],
        matlab(STRUCT)[:300],
        matlab_hdf(STRUCT["rec"])[:3000],
        tdms({"A": True})[:40],
        b"PAR1" + bytes(100),
        labview()[:150],
    ],
)
def test_a_damaged_file_is_a_message(data):
    with pytest.raises(RecordingError, match=r"file\.mat: (not a .* that can be read|no table)"):
        checked(data)


@pytest.mark.parametrize(
    "data",
    [matlab({"gain": 3.0, "name": "Versuch"}), matlab_hdf({"gain": 3.0})],
)
def test_variables_without_a_table_are_named(data):
    with pytest.raises(RecordingError, match=r"no table was found.*variables: gain"):
        checked(data)


def element(kind, data):
    """Write an element of a MATLAB file: its type, its length, and its data in eights of bytes."""
    return struct.pack("<II", kind, len(data)) + data + bytes(-len(data) % 8)


def matlab_object(variable, kind):
    """Write a file with an object of a class, as MATLAB 7 does: its data are references."""
    references = struct.pack("<6I", 0xDD000000, 2, 1, 1, 1, 1)
    flags, size = struct.pack("<II", 13, 0), struct.pack("<ii", 6, 1)
    inner = [element(6, flags), element(5, size), element(1, b""), element(6, references)]
    parts = [element(6, struct.pack("<II", 17, 0))]
    parts += [element(1, text.encode()) for text in (variable, "MCOS", kind)]
    parts.append(element(14, b"".join(inner)))
    head = b"MATLAB 5.0 MAT-file".ljust(116) + bytes(8) + struct.pack("<HH", 0x0100, 0x4D49)
    return head + element(14, b"".join(parts))


def matlab_hdf_object(variable, kind):
    data = io.BytesIO(matlab_hdf({variable: np.array([0xDD000000, 2, 1, 1, 1, 1])}))
    with h5py.File(data, "r+") as file:
        file[variable].attrs["MATLAB_class"] = np.bytes_(kind)
        file[variable].attrs["MATLAB_object_decode"] = np.int32(3)
    return data.getvalue()


@pytest.mark.parametrize("written", [matlab_object, matlab_hdf_object])
@pytest.mark.parametrize(
    ("kind", "function"), [("table", "writetable"), ("timetable", "writetimetable")]
)
def test_a_table_of_matlab_is_refused_with_the_command_that_writes_it(written, kind, function):
    with pytest.raises(RecordingError) as error:
        checked(written("run7", kind))
    assert str(error.value) == (
        f"file.mat: run7 is a {kind} object, which only MATLAB can read: type "
        f"{function}(run7, 'run7.csv') in MATLAB, and import run7.csv"
    )
