"""Tables that become recordings: units, times, what is left out, and what is said of it."""

import numpy as np
import pandas as pd
import pytest
from scipy.ndimage import uniform_filter1d

from steel import ROD, SCALE, SENSOR
from vibrissa.errors import RecordingError
from vibrissa.quantities.units import Kind, Units
from vibrissa.sensor.identification.recording import (
    Method,
    Recording,
    left_out,
    read_recording,
    table_of,
    units_of,
)

NAN = np.nan


def table(rows=30, **columns):
    """A scan by a millimetre a row, in SI units; columns replace or add to it."""
    size = np.ones(rows)
    known = {
        "footpoint [m]": 1e-3 * np.arange(rows),
        "force_x [N]": -1.0 * size,
        "force_y [N]": -2.0 * size,
        "moment_z [N*m]": -0.01 * size,
    }
    return pd.DataFrame(known | columns)


def read(frame, method=Method.MODEL, transducer=None, units=None):
    return read_recording(table_of(frame, method), units or Units(ROD), method, transducer)


def test_a_note_names_a_few_stretches_of_lines():
    assert left_out(np.array([3]), "off") == ("off in 1 row, left out: line 3",)
    assert left_out(np.arange(2, 12, 2), "off")[0].endswith("line 2, 4, 6, 8, 10")
    assert left_out(np.arange(2, 14, 2), "off")[0].endswith("line 2, 4, 6, 8, 10, ...")


def test_a_file_with_another_ending_is_for_import(tmp_path):
    with pytest.raises(RecordingError, match=r"\.csv or \.parquet\. If the file has other"):
        table_of(tmp_path / "lab.txt", Method.MODEL)


@pytest.mark.parametrize(
    "text",
    [
        "Footpoint [mm],Fx [N],Fy [N]\n0,1,2\n",
        "footpoint [mm];force_x [N];force_y [N]\n0,5;1,5;2\n",
        "footpoint [mm];force_x [N];force_y [N]\n0.5;1.5;2\n",
        "footpoint [µm],force_x [N],force_y [N]\n0.5,1.5,2\n",
    ],
)
def test_a_table_of_another_program_is_for_import(tmp_path, text):
    (tmp_path / "a.csv").write_text(text, encoding="latin-1")
    with pytest.raises(RecordingError, match=r"\. If the file has other titles"):
        read(tmp_path / "a.csv")
    with pytest.raises(RecordingError) as raised:
        read(table().drop(columns=["force_x [N]", "moment_z [N*m]"]))
    assert "the columns are: footpoint, force_y. If" in str(raised.value)


def test_columns_are_converted_from_their_units():
    found = read(table().rename(columns={"footpoint [m]": "footpoint [L]"}))
    assert found.clamp[:2] == pytest.approx([0.0, 0.001])
    assert found.readings[0] * SCALE == pytest.approx([-1.0, -2.0, -0.01])
    assert found.notes == ()


@pytest.mark.parametrize(
    ("method", "channel", "left"),
    [
        (Method.MODEL, "force_x [N]", 1),
        (Method.MODEL, "moment_z [N*m]", 1),
        (Method.RATIO, "force_y [N]", 1),
        (Method.RATIO, "moment_z [N*m]", 0),
    ],
)
def test_what_is_missing_or_saturated_matters_where_it_is_used(method, channel, left):
    number = [one.partition(" ")[0] for one in table().columns[1:]].index(channel.partition(" ")[0])
    limit = SENSOR.limit[number]
    for value, why in ((NAN, "a value is missing"), (-limit, "the transducer is saturated")):
        frame = table()
        frame.loc[7, channel] = value
        found = read(frame, method, SENSOR)
        assert len(found) == 30 - left
        # In a DataFrame its rows are counted from 1 on.
        if left:
            assert found.notes == (f"{why} in 1 row, left out: line 8",)
            assert 8 not in found.line
        else:
            assert found.notes == (
                "moment_z is missing or saturated in 1 row: the channel is not used",
            )
            assert np.isnan(found.readings[:, number]).all()
    # Without a transducer there is no limit.
    frame.loc[7, channel] = -limit
    assert len(read(frame, method)) == 30


def test_saturated_readings_are_those_before_the_zero_was_subtracted():
    frame = table()
    frame.loc[7, "force_x [N]"] = 0.5 - SENSOR.limit[0]
    assert not read(frame, transducer=SENSOR).notes
    frame.attrs["header"] = {"zero_force_x": "-0.5 N"}
    assert "saturated" in read(frame, transducer=SENSOR).notes[0]


def test_the_mean_in_air_is_that_of_counts_of_the_resolution():
    frame = pd.concat([table()] * 3, ignore_index=True)
    frame["footpoint [m]"] = 1e-4 * np.arange(len(frame))
    frame.iloc[:20, 1:] = 0.0
    frame.loc[[1, 2, 5, 8], "force_x [N]"] = 2e-3
    found = read(frame)
    assert found.air_rows == 20 and found.air[0] > 0.0


@pytest.mark.parametrize("channel", ["force_x [N]", "moment_z [N*m]"])
def test_a_channel_that_is_often_missing_is_not_used_where_the_others_suffice(channel):
    frame = table()
    frame.loc[:9, channel] = NAN
    found = read(frame)
    assert len(found) == 30
    assert f"{channel.partition(' ')[0]} is missing or saturated in 10 rows" in found.notes[0]
    # Without the other channels there is nothing else to read.
    alone = frame[["footpoint [m]", "moment_z [N*m]"]]
    assert len(read(alone)) == 30 - int(alone["moment_z [N*m]"].isna().sum())


def test_the_channels_with_fewer_gaps_are_used_where_all_have_many():
    frame = table()
    frame.loc[:9, "force_x [N]"] = NAN
    frame.loc[20:23, "moment_z [N*m]"] = NAN
    found = read(frame)
    assert len(found) == 26 and np.isnan(found.readings[:, :2]).all()
    frame.loc[:23, "moment_z [N*m]"] = NAN
    found = read(frame)
    assert len(found) == 6 and np.isfinite(found.readings).all()


def test_a_missing_position_counts_and_one_row_is_left_out_once():
    frame = table()
    frame.loc[[3, 4], "footpoint [m]"] = NAN
    frame.loc[[4, 5], "force_x [N]"] = -20.0
    missing, full = read(frame, transducer=SENSOR).notes
    assert missing == "a value is missing in 2 rows, left out: line 4-5"
    assert full == "the transducer is saturated in 1 row, left out: line 6"


@pytest.mark.parametrize(("unit", "interval"), [("s", 2.0), ("ms", 2e-3), ("min", 120.0)])
def test_the_interval_is_the_usual_one_in_seconds(unit, interval):
    times = 2.0 * np.arange(30.0)
    times[20:] += 5.0
    found = read(table(**{f"time [{unit}]": times}))
    assert found.interval == pytest.approx(interval)
    frame = table(time=times)
    assert np.isnan(read(frame).interval) and np.isnan(read(table()).interval)
    # One sample has no interval; two have one.
    assert np.isnan(read(frame.rename(columns={"time": "time [s]"}).iloc[:1]).interval)
    assert read(frame.rename(columns={"time": "time [s]"}).iloc[:2]).interval == 2.0


def test_ends_that_are_no_scan_are_noted_by_their_lines():
    clamp = np.concatenate([np.zeros(40), 1e-3 * np.arange(1, 101), np.full(20, 0.1)])
    free = np.arange(160) < 15
    force = np.where(free, 0.0, 1.0)
    frame = table(rows=160, **{"footpoint [m]": clamp})
    for name, size in (("force_x [N]", -1.0), ("force_y [N]", -2.0), ("moment_z [N*m]", 9.0)):
        frame[name] = size * force
    # What the method does not use does not tell whether the rod touches.
    found = read(frame)
    assert found.line.tolist() == list(range(40, 141))
    assert (found.air, found.air_rows) == ((0.0, 0.0, 0.0), 15)
    assert found.notes == (
        "no load: nothing touches the surface in 15 rows, left out: line 1-15",
        "the clamp rests before or after the scan in 44 rows, left out: line 16-39, 141-160",
    )


@pytest.mark.parametrize(
    ("title", "si", "wished"),
    [("footpoint [mm]", True, "mm"), ("footpoint [L]", False, None), ("footpoint", True, None)],
)
def test_without_a_rod_units_are_those_of_the_recording(title, si, wished):
    frame = table().rename(columns={"footpoint [m]": title}).drop(columns="moment_z [N*m]")
    found = units_of(table_of(frame, Method.RATIO))
    assert found.si == si and found.wished.get(Kind.LENGTH) == wished


def test_the_lag_is_the_way_of_the_clamp_during_the_delay_averaged_over_nine_samples():
    clamp = np.random.default_rng(3).normal(size=40)
    recording = Recording(clamp=clamp, readings=np.ones((40, 3)), line=np.arange(40), delay=2.0)
    expected = 2.0 * uniform_filter1d(np.gradient(clamp), 9, mode="nearest")
    assert recording.lag == pytest.approx(expected, abs=1e-14)
