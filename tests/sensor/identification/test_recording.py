"""Tables that become recordings: units, times, what is left out, and what is said of it."""

import numpy as np
import pandas as pd
import pytest
from scipy.optimize import brentq

from steel import ROD, SCALE, SENSOR, recording_of
from vibrissa.errors import RecordingError
from vibrissa.sensor import Units
from vibrissa.sensor.identification.preparing.hum import _block, _Blocks, _frequencies, hum_of
from vibrissa.sensor.identification.recording import Method, Recording, read_recording, units_of
from vibrissa.sensor.quantities import Kind

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


def read(frame, method=Method.FORCES, transducer=None, units=None):
    return read_recording(frame, units or Units(ROD), method, transducer)


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
    for reading in (lambda path: read(path), units_of):
        with pytest.raises(RecordingError, match=r"\. vibrissa import reads other titles, enc"):
            reading(tmp_path / "a.csv")
    with pytest.raises(RecordingError) as raised:
        read(table().drop(columns="force_x [N]"))
    assert str(raised.value).endswith("there are: footpoint, force_y, moment_z")


def test_columns_without_a_unit_are_taken_in_that_of_the_rod_and_named():
    frame = table().rename(columns={"footpoint [m]": "footpoint", "moment_z [N*m]": "moment_z"})
    found = read(frame)
    assert found.clamp[:2] == pytest.approx([0.0, 0.01])
    assert found.readings[0] * SCALE == pytest.approx([-1.0, -2.0, -0.01])
    assert found.notes == (
        "the DataFrame gives no unit for these columns, taken as: footpoint in m, moment_z in N*m",
    )
    own = read(
        frame.rename(columns={"force_x [N]": "force_x", "force_y [N]": "force_y"}), units=Units()
    )
    assert "footpoint in L, force_x in E*I0/L^2, force_y in E*I0/L^2" in own.notes[0]
    assert own.clamp[1] == 1e-3 and own.readings[0].tolist() == [-1.0, -2.0, -0.01]
    assert read(table()).notes == ()


@pytest.mark.parametrize(
    ("method", "channel", "left"),
    [
        (Method.FORCES, "force_x [N]", 1),
        (Method.FORCES, "force_y [N]", 1),
        (Method.FORCES, "moment_z [N*m]", 0),
        (Method.MOMENT, "force_x [N]", 0),
        (Method.MOMENT, "moment_z [N*m]", 1),
        (Method.SPACING, "moment_z [N*m]", 1),
        (Method.RATIO, "force_y [N]", 1),
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
            assert found.notes == (f"{why} in 1 rows, left out: line 8",)
            assert 8 not in found.line
        elif value == -limit:
            # It says nothing of the rod where the transducer ends.
            name = channel.partition(" ")[0]
            assert found.notes == (f"{name} is at the transducer's limit in 1 rows: not used",)
            assert np.isnan(found.readings[:, number]).all()
        else:
            assert found.notes == () and np.isnan(found.readings[7, number])
    # Without a transducer there is no limit.
    frame.loc[7, channel] = -limit
    assert len(read(frame, method)) == 30


def test_a_missing_position_counts_and_one_row_is_left_out_once():
    frame = table()
    frame.loc[[3, 4], "footpoint [m]"] = NAN
    frame.loc[[4, 5], "force_x [N]"] = -20.0
    missing, full = read(frame, transducer=SENSOR).notes
    assert missing == "a value is missing in 2 rows, left out: line 4, 5"
    assert full == "the transducer is saturated in 1 rows, left out: line 6"


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


@pytest.mark.parametrize("change", [0.0, -1.0])
def test_time_must_increase(change):
    times = np.arange(30.0)
    times[12] = times[11] + change
    with pytest.raises(RecordingError, match="13: time does not increase; sort the table"):
        read(table(**{"time [s]": times}))


@pytest.mark.parametrize(("value", "said"), [(1e100, False), (-1e100, False), (-2e100, True)])
def test_what_is_larger_than_any_measurement_is_refused_with_its_row(value, said):
    frame = table(rows=3).rename(columns={"footpoint [m]": "footpoint [L]"})
    frame.loc[2, "footpoint [L]"] = value
    if not said:
        assert read(frame).clamp[2] == value
        return
    with pytest.raises(RecordingError, match=r"3: footpoint is larger than 1e\+100 in units"):
        read(frame)


def test_hum_is_taken_off_and_told_in_a_persons_units():
    time = np.arange(4000.0) / 1000.0
    wave = np.cos(100.0 * np.pi * time)
    rng = np.random.default_rng(1)
    noise = 0.01 * rng.standard_normal((4000, 2))
    frame = pd.DataFrame(
        {
            "time [s]": time,
            "footpoint [m]": 1e-6 * np.arange(4000),
            "force_x [N]": -1.0 + noise[:, 0] + 0.05 * wave,
            "force_y [N]": -2.0 + noise[:, 1],
        }
    )
    units = Units(ROD, {Kind.FORCE: "mN"})
    found = read(frame, units=units)
    (note,) = found.notes
    told, _, size = note.partition(" is taken off: ")
    assert told == "hum of 50 Hz" and size.endswith(" mN in force_x")
    assert float(size.split()[0]) == pytest.approx(50.0, abs=1.0)
    left = found.readings[:, 0] * SCALE[0] + 1.0 - noise[:, 0]
    assert np.abs(left).max() < 2e-3
    assert found.readings[:, 1] * SCALE[1] == pytest.approx(-2.0 + noise[:, 1])


def test_ends_that_are_no_scan_are_noted_by_their_lines():
    clamp = np.concatenate([np.zeros(40), 1e-3 * np.arange(1, 101), np.full(20, 0.1)])
    free = np.arange(160) < 15
    force = np.where(free, 0.0, 1.0)
    frame = table(rows=160, **{"footpoint [m]": clamp})
    for name, size in (("force_x [N]", -1.0), ("force_y [N]", -2.0), ("moment_z [N*m]", 9.0)):
        frame[name] = size * force
    # What the method does not use does not tell whether the rod touches.
    frame["moment_z [N*m]"] = 1.0
    found = read(frame)
    assert found.line.tolist() == list(range(40, 141))
    assert found.notes == (
        "no load: nothing touches the surface in 15 rows, left out: line 1, 2, 3, 4, 5, ...",
        "the clamp rests before or after the scan in 44 rows, left out: line "
        "16, 17, 18, 19, 20, ...",
    )


@pytest.mark.parametrize(
    ("title", "si", "wished"),
    [("footpoint [mm]", True, "mm"), ("footpoint [L]", False, None), ("footpoint", True, None)],
)
def test_without_a_rod_units_are_those_of_the_recording(title, si, wished):
    frame = table().rename(columns={"footpoint [m]": title}).drop(columns="moment_z [N*m]")
    found = units_of(frame)
    assert found.si == si and found.wished.get(Kind.LENGTH) == wished


def test_a_channel_that_is_not_there_has_no_part_in_the_others_that_do_not_need_it():
    readings = np.array([[1.0, 2.0, NAN], [3.0, NAN, 5.0]])
    mixed = recording_of(np.arange(2.0), readings).mixed(
        np.array([[1.0, 0.5, 0.0], [0.0, 2.0, 0.0], [1.0, 0.0, 1.0]])
    )
    expected = [[2.0, 4.0, NAN], [NAN, NAN, 8.0]]
    assert np.array_equal(mixed.readings, expected, equal_nan=True)
    off = recording_of(np.arange(2.0), readings).without(np.array([1.0, 2.0, 3.0]))
    assert np.array_equal(off.readings, [[0.0, 0.0, NAN], [2.0, NAN, 2.0]], equal_nan=True)


def test_a_recording_is_given_as_it_is():
    plain = Recording(clamp=np.zeros(2), readings=np.zeros((2, 3)), line=np.arange(2))
    assert plain.notes == () and np.isnan(plain.interval)
    assert plain.slipping is None and plain.excess is None
    assert plain.mirrored().slipping is None and plain.mirrored().excess is None


# --- Hum ---


@pytest.mark.parametrize(
    ("rate", "frequency", "samples"), [(1000.0, 50.0, 40), (1000.0, 60.0, 33), (100.0, 50.0, 8)]
)
def test_a_block_has_two_cycles_and_eight_samples_at_least(rate, frequency, samples):
    assert _block(np.arange(50.0) / rate, frequency) == samples
    # The usual interval counts.
    gaps = np.arange(50.0) / rate + np.where(np.arange(50) > 30, 1.0, 0.0)
    assert _block(gaps, frequency) == samples


@pytest.mark.parametrize(("duration", "number"), [(10.0, 19), (0.4, 3), (1000.0, 400)])
def test_frequencies_are_tried_by_a_quarter_of_a_cycle(duration, number):
    found = _frequencies(50.0, duration)
    assert len(found) == number
    assert found[0] == pytest.approx(49.8) and found[-1] == pytest.approx(50.2)
    # Between the first and the last they differ by a quarter of a cycle, or by less.
    if number < 400:
        assert (found[1] - found[0]) * duration <= 0.25


def test_hum_is_the_same_with_slips_and_a_load_that_grows():
    rng = np.random.default_rng(3)
    rows = np.arange(4000)
    time = rows / 1000.0
    wave = np.cos(2.0 * np.pi * 50.07 * time[:, None] + np.array([0.0, 1.0, 2.0]))
    amplitude = np.array([1.0, 2.0, 0.5])
    noise = 0.1 * rng.standard_normal((4000, 3))
    slips = (30.0 * (rows % 400) / 400.0)[:, None] + 1e-5 * (rows[:, None] - 2000.0) ** 2
    found = hum_of(noise + amplitude * wave + slips, time, time)
    assert found.frequency == pytest.approx(50.07, abs=1e-3)
    assert found.amplitude == pytest.approx(amplitude, abs=0.02)
    assert np.abs(found.signal - amplitude * wave).max() < 0.05
    # A time that does not begin with 0 has another phase, and the same wave.
    later = hum_of(noise + amplitude * wave + slips, time + 3.3, time)
    assert later.signal == pytest.approx(found.signal, abs=1e-6)


def waving(size, blocks=12, channels=3):
    """The clamp, which moves evenly, and readings of ±1 in turn, in so many blocks."""
    rows = np.arange(size * blocks)
    return np.column_stack([1.0 * rows, *[(-1.0) ** rows] * (channels - 1)])


@pytest.mark.parametrize("channel", [0, 1, 2])
@pytest.mark.parametrize(("part", "quiet"), [(3.99, True), (4.01, False)])
def test_a_block_that_leaves_four_times_what_most_leave_has_a_slip(channel, part, quiet):
    readings = waving(40)
    # The clamp does not show a slip.
    readings[:, 0] = readings[:, 1]
    readings[120:160, channel] *= np.sqrt(part)
    found = _Blocks.of(readings, 40)
    assert (3 in found.quiet) == (quiet or channel == 0)
    assert len(found.quiet) == len(found.rest) >= 11


@pytest.mark.parametrize(("height", "quiet"), [(17.9, True), (18.1, False)])
def test_a_second_difference_ten_times_the_usual_one_is_a_slip(height, quiet):
    # Of ±1 in turn it is 4, with the height 4 + 2·height; in a block of 400 it is little beside.
    readings = waving(400)
    readings[400 * 3 + 200, 2] += height
    found = _Blocks.of(readings, 400)
    assert found.quiet.tolist() == [block for block in range(12) if quiet or block != 3]
    # In the clamp it is none.
    moved = waving(400)
    moved[1400, 0] += 1e3
    assert len(_Blocks.of(moved, 400).quiet) == 12


def test_blocks_are_without_parabolas_and_what_is_left_over_is_no_block():
    rows = np.arange(485.0)
    readings = np.column_stack([rows, 3.0 + 0.2 * rows - 1e-3 * rows**2, (-1.0) ** rows])
    found = _Blocks.of(readings, 40)
    assert found.rest.shape[1:] == (40, 3) and len(found.quiet) <= 12
    assert np.abs(found.rest[:, :, 1]).max() < 1e-9
    assert np.abs(found.rest[:, :, 2]).max() > 0.9


@pytest.mark.parametrize(("blocks", "fits"), [(9, False), (10, True)])
def test_ten_quiet_blocks_are_the_fewest_for_a_fit(blocks, fits):
    readings = waving(40, blocks)
    readings[:, 1:] += 0.1 * np.random.default_rng(1).standard_normal((40 * blocks, 2))
    angle = np.pi * 0.1 * np.arange(40 * blocks)
    waves = np.column_stack([np.cos(angle), np.sin(angle)])
    readings[:, 1] += 0.7 * waves[:, 1]
    weights, explained = _Blocks.of(readings, 40).fitted(waves)
    assert weights.shape == (2, 3) and explained.shape == (3,)
    assert (explained[1] > 0.0) == fits
    if fits:
        assert weights[:, 1] == pytest.approx([0.0, 0.7], abs=0.1)


@pytest.mark.parametrize(("part", "fits"), [(0.99, False), (1.01, True)])
def test_a_wave_of_which_parabolas_leave_less_than_a_fifth_is_not_told(part, fits):
    readings = waving(40)
    readings[:, 1:] += 0.1 * np.random.default_rng(1).standard_normal((480, 2))
    blocks = _Blocks.of(readings, 40)
    angle = np.pi * 0.1 * np.arange(480)
    waves = np.column_stack([np.cos(angle), np.sin(angle)])
    cut = waves.reshape(12, 40, 2)
    # A wave of amplitude 1 has the mean square 1/2; a fifth of it is 1/10.
    rows = np.vander(np.linspace(-1.0, 1.0, 40), 3)
    left = cut - np.einsum("ij,bjk->bik", rows @ np.linalg.pinv(rows), cut)
    size = np.sqrt(0.1 * part / np.mean(left**2))
    assert blocks.fitted(size * waves)[1].any() == fits


@pytest.mark.parametrize(("squares", "told"), [(49.5, False), (50.5, True)])
@pytest.mark.parametrize("nominal", [50.0, 60.0])
def test_a_hum_is_told_from_fifty_squares_on(squares, told, nominal):
    time = np.arange(1000.0) / 1000.0
    noise = np.random.default_rng(1).standard_normal((1000, 3))
    wave = np.cos(2.0 * np.pi * nominal * time)

    def readings(size):
        return noise + np.column_stack([size * wave, 0.0 * wave, 0.0 * wave])

    def explained(size):
        """At the best of the frequencies that are tried."""
        blocks = _Blocks.of(np.column_stack([time, readings(size)]), _block(time, nominal))
        angles = [2.0 * np.pi * one * time for one in _frequencies(nominal, time[-1])]
        waves = [np.column_stack([np.cos(angle), np.sin(angle)]) for angle in angles]
        return max(blocks.fitted(one)[1][1] for one in waves)

    size = brentq(lambda size: explained(size) - squares, 0.1, 1.0)
    hum = hum_of(readings(size), time, time)
    assert (hum is not None) == told
    if told:
        assert (hum.amplitude > 0.0).tolist() == [True, False, False]
        assert hum.frequency == pytest.approx(nominal, abs=0.5)
    # What the clamp does, too, is no hum.
    assert hum_of(readings(1.0), time, readings(1.0)[:, 0]) is None
