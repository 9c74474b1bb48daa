"""What a tare tells, the zeros and their errors, travels with the recording to `identify`."""

import numpy as np
import pytest

from steel import Given, identified
from vibrissa.errors import ArgumentError, RecordingError
from vibrissa.quantities import series
from vibrissa.quantities.units import SI_UNITS
from vibrissa.scanning import surfaces
from vibrissa.sensor import Setup, scan
from vibrissa.sensor.importing import Imported, Settings, import_recording
from vibrissa.sensor.importing.tare import quiet_part, unloaded, zeros_of
from vibrissa.sensor.transducer import CHANNELS

ROD = {"modulus": "210 GPa", "diameter": "0.8 mm", "length": "100 mm"}
WHISKER = Setup.read(theta=2, eta="85 mm", **ROD).whisker
ZEROS = {"zero_force_x": "0.5 mN", "zero_force_y": "2 mN", "zero_moment_z": "0.04 N*mm"}
HEADER = {name: f"310.2 ± {size}" for name, size in ZEROS.items()} | {"rate": "50 Hz"}


@pytest.fixture(scope="module")
def signals():
    """Noisy signals of three periods of sticking."""
    return (
        scan(WHISKER, surfaces.constant(0.3), step="50 um", to="8 mm", law="kinetic")
        .measured("nano17-si-12-0.12")
        .columns()
    )


def tolerances_of(found):
    stated = (one.parameter for one in found.estimates if one.parameter.stated)
    return {one.of: one.deviation for one in stated if one.of in ZEROS}


@pytest.mark.slow
@pytest.mark.parametrize(("whisker", "name"), [(WHISKER, "a.csv"), (None, "a.parquet")])
def test_identify_reads_the_errors_of_the_zeros(tmp_path, signals, whisker, name):
    series.write(tmp_path / name, Given(signals, HEADER))
    told = ZEROS
    if whisker is None:  # the ratio of the forces has no moment
        told = {name: size for name, size in ZEROS.items() if name != "zero_moment_z"}
    travelled = identified(whisker, tmp_path / name)
    series.write(tmp_path / "retyped.csv", Given(signals))
    retyped = identified(whisker, tmp_path / "retyped.csv", tolerances=told)
    assert set(tolerances_of(travelled)) == set(told)
    assert tolerances_of(travelled) == pytest.approx(tolerances_of(retyped))
    assert np.array_equal(travelled.periods.mu0, retyped.periods.mu0, equal_nan=True)


@pytest.mark.slow
def test_a_stated_tolerance_goes_before_that_of_the_recording(tmp_path, signals):
    series.write(tmp_path / "a.csv", Given(signals, HEADER))
    stated = Setup.read(theta=2, eta="85 mm", tolerances={"zero_force_x": "exact"}, **ROD).whisker
    found = identified(stated, tmp_path / "a.csv", tolerances={"zero_force_y": "7 mN"})
    force = WHISKER.units.channels[0]
    of = tolerances_of(found)
    assert "zero_force_x" not in of and of["zero_force_y"] == pytest.approx(7e-3 / force)


def test_a_zero_without_scatter_is_subtracted_and_its_error_is_not_known():
    zeros = zeros_of({"force_y": np.full(200, 0.7)}, np.ones(200, dtype=bool))
    found = Imported(values={}, zeros=zeros, notes=(), units=SI_UNITS)
    assert found.header() == {"zero_force_y": "0.7 N"}
    assert found.report() == ("zero_force_y = 0.7 N, mean of 200 rows, subtracted",)


def test_a_wrong_line_of_the_header_is_named(tmp_path, signals):
    series.write(tmp_path / "a.csv", Given(signals, {"zero_force_x": "1 ± 2 ± 3 mN"}))
    with pytest.raises(ArgumentError, match=r"zero_force_x of .*a\.csv must be .*got .2 ± 3 mN"):
        identified(WHISKER, tmp_path / "a.csv")


def laboratory(free, lowered, signals, rest=60, offset=(0.3, -0.1, 5e-3), seed=1):
    """A file: the rod in air, lowered, at rest on the surface, and moved; zeros are not zero."""
    loads = np.stack([signals[name].values for name in CHANNELS], axis=1)
    first = loads[0]
    ramp = np.linspace(0, 1, lowered)[:, None] * first
    before = np.concatenate([np.zeros((free, 3)), ramp, np.tile(first, (rest, 1))])
    noise = np.random.default_rng(seed).normal(0.0, [3e-3, 3e-3, 1e-4], (len(before), 3))
    readings = np.concatenate([before + noise, loads]) + offset
    clamp = np.concatenate([np.zeros(len(before)), signals["footpoint"].values])
    lines = ["time [s];footpoint [m];force_x [N];force_y [N];moment_z [N*m]"]
    lines += [
        ";".join(map(repr, [row / 100, *map(float, (x, *reading))]))
        for row, (x, reading) in enumerate(zip(clamp, readings, strict=True))
    ]
    return "\n".join(lines).encode()


@pytest.mark.parametrize(
    ("lowered", "rest", "seed"),
    [(2, 60, 0), (30, 60, 2), (300, 60, 1), (2, 1, 2), (2, 0, 0)],
)
def test_rows_before_the_rod_is_lowered_are_the_tare(signals, lowered, rest, seed):
    data = laboratory(120, lowered, signals, rest, seed=seed)
    found = import_recording(data, Settings.read())
    for name, wanted in zip(CHANNELS, (0.3, -0.1, 5e-3), strict=True):
        zero = found.zeros[name]
        assert 50 <= zero.rows <= 120
        assert abs(zero.value - wanted) < 5 * zero.deviation
    begin = {"from": f"{(120 + lowered + rest) / 100} s"}
    told = import_recording(data, Settings.read(**begin))
    assert told.zeros.keys() == found.zeros.keys()
    # Neither rows that are left out nor a missing cell make another tare.
    first, *lines = data.split(b"\n")
    lines[-3] = lines[-3].rpartition(b";")[0].rpartition(b";")[0] + b";;0"
    holed = import_recording(b"\n".join([first, *lines]), Settings.read(**{"from": "4 mm"}))
    assert holed.zeros == found.zeros


@pytest.mark.parametrize("seed", range(4))
def test_a_rod_that_rests_on_the_surface_is_no_tare(signals, seed):
    """Neither as it relaxes, nor where one reading is a spike."""
    text = laboratory(0, 1, signals, seed=seed).decode().split("\n")
    rows = [line.split(";") for line in text]
    for row in range(1, 60):
        relaxed = 0.02 * np.exp(-row / 20) + (0.5 if row == 30 else 0.0)
        rows[row][2:4] = [str(float(cell) + relaxed) for cell in rows[row][2:4]]
    data = "\n".join(map(";".join, rows)).encode()
    assert not import_recording(data, Settings.read()).zeros
    loaded = laboratory(0, 0, signals, seed=seed)
    assert not import_recording(loaded, Settings.read(**{"from": "3 mm"})).zeros


def test_a_change_by_five_deviations_of_the_noise_is_a_load():
    row = np.arange(200)
    clamp = np.maximum(row - 120.0, 0.0)
    for load, free in ((6.8, 64), (7.6, 48)):  # with the noise, 4.6 and 5.1 deviations
        force = (-1.0) ** row + load * (row >= 60) - 90.0 * (row >= 80)
        assert unloaded({"footpoint": clamp, "force_y": force}, 200) == free


@pytest.mark.parametrize(("channel", "until"), [(0, 150), (2, None)])
def test_a_channel_without_readings_in_air_has_no_zero(signals, channel, until):
    lines = [line.split(";") for line in laboratory(120, 2, signals).decode().split("\n")]
    for line in lines[1:until]:
        line[2 + channel] = ""
    found = import_recording("\n".join(map(";".join, lines)).encode(), Settings.read())
    assert found.zeros.keys() == {*CHANNELS} - {CHANNELS[channel]}
    assert any("no zero for" in note for note in found.notes) == (until is not None)


@pytest.mark.slow
def test_an_imported_recording_has_the_friction_of_one_that_was_tared(tmp_path, signals):
    found = import_recording(laboratory(400, 30, signals), Settings.read())
    series.write(tmp_path / "imported.csv", found)
    series.write(tmp_path / "tared.csv", Given(signals))
    known = {"noise": "3 mN, 3 mN, 0.1 mN*m", "assume": False}
    imported, tared = (
        identified(WHISKER, tmp_path / name, **known).periods
        for name in ("imported.csv", "tared.csv")
    )
    slipped = tared.status == "slip"
    assert slipped.sum() > 3 and (imported.status == tared.status).all()
    assert imported.mu0[slipped] == pytest.approx(tared.mu0[slipped], abs=3e-3)
    frame = found.to_pandas()
    assert identified(WHISKER, frame, **known).periods.mu0 == pytest.approx(
        imported.mu0, nan_ok=True, rel=1e-6
    )


def test_a_zero_is_known_as_well_as_its_mean_scatters():
    rng, told, errors = np.random.default_rng(5), [], []
    for _ in range(60):
        noise = np.convolve(rng.standard_normal(427), np.ones(8) / 8, "valid")
        zero = zeros_of({"force_x": 0.4 + noise}, np.ones(len(noise), dtype=bool))["force_x"]
        told.append(zero.deviation)
        errors.append(zero.value - 0.4)
    # The readings share their noise; as if they did not, it would be told too small by a factor 3.
    assert np.sqrt(np.mean(np.square(told))) == pytest.approx(np.std(errors), rel=0.35)
    assert np.mean(told) > 2.0 * 0.35 / np.sqrt(420)


def in_air_before_and_after(signals, jump, seed=1, before=400, after=400):
    """A file: the rod in air, lowered, at rest, moved, at rest, lifted off, and in air again.

    The zero of force_y jumps when the clamp begins to move.
    """
    loads = np.stack([signals[name].values for name in CHANNELS], axis=1)
    first, last = loads[0], loads[-1]
    ramp = np.linspace(0, 1, 30)[:, None]
    parts = [np.zeros((before, 3)), ramp * first, np.tile(first, (60, 1))]
    begin = sum(map(len, parts))
    parts += [loads, np.tile(last, (60, 1)), ramp[::-1] * last, np.zeros((after, 3))]
    every = np.concatenate(parts)
    clamp = np.zeros(len(every))
    clamp[begin : begin + len(loads)] = signals["footpoint"].values
    clamp[begin + len(loads) :] = clamp[begin + len(loads) - 1]
    noise = np.random.default_rng(seed).normal(0.0, [3e-3, 3e-3, 1e-4], (len(every), 3))
    every = every + noise + (0.3, -0.1, 5e-3)
    every[begin:, 1] += jump
    lines = ["time [s];footpoint [m];force_x [N];force_y [N];moment_z [N*m]"]
    lines += [
        ";".join(map(repr, [row / 100, *map(float, (x, *reading))]))
        for row, (x, reading) in enumerate(zip(clamp, every, strict=True))
    ]
    return "\n".join(lines).encode(), begin, begin + len(loads)


def scanned(begin, end):
    return {"from": f"{begin / 100} s", "to": f"{(end - 1) / 100} s"}


@pytest.mark.parametrize("jump", [0.0, 0.06, -0.06])
def test_rows_in_air_after_the_scan_are_a_second_tare(signals, jump):
    data, begin, end = in_air_before_and_after(signals, jump)
    found = import_recording(data, Settings.read(**scanned(begin, end)))
    force, other = found.zeros["force_y"], found.zeros["force_x"]
    assert other.change == 0.0 and other.value == pytest.approx(0.3, abs=5 * other.deviation)
    said = [line for line in found.report() if "changes by" in line or "agree" in line]
    assert len(said) == 1
    if not jump:
        assert force.change == 0.0 and said[0].startswith("the zeros after the scan agree: ")
        return
    assert said[0].startswith("force_y changes by ")
    assert force.change == pytest.approx(jump, abs=2e-3)
    # A steady change is subtracted: what is left of a jump is within the error of the zero.
    truth = signals["force_y"].values
    left = (found.values["force_y"] - truth).mean()
    assert force.deviation == pytest.approx(abs(jump) / np.sqrt(12), rel=0.1)
    assert abs(left) < 2.0 * force.deviation


def test_rows_in_air_after_the_scan_are_the_tare_if_there_are_none_before(signals):
    data, begin, end = in_air_before_and_after(signals, 0.0, before=0)
    found = import_recording(data, Settings.read(**scanned(begin, end)))
    for name, wanted in zip(CHANNELS, (0.3, -0.1, 5e-3), strict=True):
        assert abs(found.zeros[name].value - wanted) < 5 * found.zeros[name].deviation
    assert any("rows without load only after the scan: " in note for note in found.notes)


@pytest.mark.parametrize(("window", "part"), [("0 s, 4.4 s", (0.0, 4.0)), ("2 s, 4.9 s", (2, 4))])
def test_a_window_that_contains_load_is_refused_with_the_part_that_would_do(signals, window, part):
    data, begin, end = in_air_before_and_after(signals, 0.0)
    with pytest.raises(RecordingError) as error:
        import_recording(data, Settings.read(tare=window, **scanned(begin, end)))
    message = str(error.value)
    assert "change in the window of --tare by more than their noise: choose a part" in message
    proposed = message.partition("--tare '")[2].rstrip("'")
    ends = [float(one.removesuffix(" s")) for one in proposed.split(", ")]
    assert part[0] <= ends[0] < ends[1] <= part[1] + 0.05
    assert ends[1] - ends[0] > 0.6 * (part[1] - part[0])
    zeros = import_recording(data, Settings.read(tare=proposed, **scanned(begin, end))).zeros
    assert zeros["force_y"].value == pytest.approx(-0.1, abs=2e-3)


def test_a_window_among_rows_that_may_be_loaded_is_compared_with_those_farther_away(signals):
    data, *_ = in_air_before_and_after(signals, 0.0)
    found = import_recording(data, Settings.read(tare="3.7 s, 3.9 s"))
    (said,) = (line for line in found.report() if "agree" in line)
    assert said.startswith("the zeros after the scan agree: ")


def test_a_window_at_rest_on_the_surface_is_refused(signals):
    data, begin, end = in_air_before_and_after(signals, 0.0)
    with pytest.raises(
        RecordingError, match=r"force_y is under load in the window of --tare: .* '0 "
    ):
        import_recording(data, Settings.read(tare="4.35 s, 4.85 s", **scanned(begin, end)))


@pytest.mark.parametrize("size", [0.0, 0.02])
def test_noise_hum_and_a_spike_are_no_load(size):
    """Nor is noise that a filter has smoothed."""
    rng = np.random.default_rng(7)
    smooth = np.convolve(rng.standard_normal(439), np.ones(40) / 40, "valid")
    hum = np.sin(np.arange(400) * 0.7)
    load = np.concatenate([np.zeros(400), np.full(400, -0.4)])
    kept = np.arange(800) >= 400
    for each in (rng.standard_normal(400), smooth, hum):
        readings = load + 0.003 * rng.standard_normal(800)
        readings[:400] += size * each
        readings[37] += 0.3
        assert quiet_part(readings, kept, ~kept).all()
