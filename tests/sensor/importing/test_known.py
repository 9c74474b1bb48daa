"""Where a motion begins, how well a zero is known, and what settings say: as they were."""

from pathlib import Path

import numpy as np
import pytest

from known import Known, result_of
from vibrissa.sensor.importing import Settings
from vibrissa.sensor.importing.decoding import decoded
from vibrissa.sensor.importing.onset import moving_by_readings
from vibrissa.sensor.importing.preparing import inside, with_time, zeros_of
from vibrissa.sensor.importing.settings import Window, read_file
from vibrissa.sensor.quantities import Kind

KNOWN = Known(__file__)

# Samples at rest, in motion and at rest again; how far the readings go in a sample, in deviations
# of the noise; and after how many samples the tip slips.
MOTIONS = {
    "slow": (60, 150, 0, 0.5, 40),
    "slower than the noise": (80, 300, 50, 0.1, 100),
    "fast": (60, 80, 40, 20.0, 30),
    "steps of five deviations": (40, 90, 0, 5.0, 25),
    "steps of eleven deviations": (40, 90, 0, 11.0, 25),
    "no rest": (0, 200, 0, 2.0, 30),
    "a short rest": (12, 200, 12, 2.0, 30),
    "a rest of the length of a period": (30, 200, 25, 2.0, 30),
    "rest at the end": (0, 150, 90, 1.0, 30),
    "slips at once": (50, 100, 0, 3.0, 2),
    "slips after three steps": (50, 100, 0, 12.0, 3),
    "slips after four steps": (50, 100, 0, 12.0, 4),
    "slips after five steps": (50, 100, 0, 12.0, 5),
}


def moved(seed, before, during, after, speed, period):
    since = np.arange(during)
    motion = speed * (since % period + 1.0)
    pushed = np.concatenate([np.zeros(before), motion, np.full(after, motion[-1])])
    noise = np.random.default_rng(seed).normal(0.0, 1.0, (len(pushed), 2))
    return 0.01 * (noise + np.stack([-pushed, -20.0 - 0.5 * pushed], axis=1))


@pytest.mark.parametrize("name", MOTIONS)
def test_a_motion_begins_and_ends_at_the_same_samples(name):
    def found(readings):
        rows, spread = moving_by_readings(readings, "a.csv")
        return [rows.start, rows.stop, spread]

    KNOWN.check(name, [result_of(found, moved(seed, *MOTIONS[name])) for seed in range(4)])


@pytest.mark.parametrize("count", [3, 99, 100, 101, 240])
def test_a_zero_is_known_as_well(count):
    noise = np.random.default_rng(2).normal(0.0, 1.0, count + 30)
    shared = np.convolve(noise, np.ones(8), "same")
    time = 0.1 * np.arange(count + 30)
    values = {"time": time, "force_x": shared, "moment_z": noise}
    window = Window(Kind.TIME, 0.95, time[-1] - 2.0 + 1e-9)
    found = zeros_of(values, [window])
    KNOWN.check(f"zero of {count}", {name: list(zero) for name, zero in found.items()})


def test_a_window_holds_its_ends():
    values = {"time": np.arange(6.0), "force_x": np.ones(6)}
    held = inside(values, Window(Kind.TIME, 1.0, 3.0), "tare")
    assert held.tolist() == [False, True, True, True, False, False]
    there = with_time({"force_x": np.ones(3)}, 4.0, [])
    assert there["time"].tolist() == [0.0, 0.25, 0.5] and list(there) == ["time", "force_x"]


def test_a_file_with_few_zero_bytes_is_no_utf_16():
    half = b"".join(bytes([65, 0]) if n % 2 else b"BC" for n in range(40))
    assert result_of(decoded, half, "a").startswith("RecordingError: a: not a text file")
    most = b"".join(bytes([65, 0]) if n % 10 else "ℝ".encode("utf-16-le") for n in range(40))
    assert decoded(most, "a").encoding == "utf-16-le"
    assert decoded(most[:-1] + b"\0A\0", "a").encoding == "utf-16-le"
    assert decoded(b"", "a") == ("", "utf-8") and decoded(b"\x81", "a").encoding == "latin-1"


SETTINGS = {
    "all": {
        "encoding": "latin-1",
        "separator": "tab",
        "decimal": ",",
        "titles": 3,
        "columns": {"force_x": " -Fz [mN] ", "force_y": "#3", "time": "t[s]"},
        "turn": "90 deg",
        "moment_origin": "1 mm, -2 mm",
        "tare": ["0 s, 2 s", "1 mm, 3 mm"],
        "speed": "0.1 mm/s",
        "rate": "50 Hz",
        "begin": "2 s",
        "end": "3 mm",
    },
    "none": {},
    "a column that is none": {"columns": {"fx": "a"}},
    "no title": {"columns": {"force_x": " - [mN]"}},
    "a decimal sign": {"decimal": ";"},
    "a separator": {"separator": "dot"},
    "a speed": {"speed": "-1 mm/s"},
    "no speed": {"speed": "0 mm/s"},
    "a rate": {"rate": "1 s"},
    "a place": {"moment_origin": "1 mm"},
    "a beginning": {"begin": "now"},
    "an end": {"end": "3 N"},
    "a window": {"tare": ["1 s"]},
    "a window that ends where it begins": {"tare": ["1 s, 1 s"]},
    "a window that goes back": {"tare": ["2 s, 1 s"]},
    "a window of two kinds": {"tare": ["2 s, 3 mm"]},
}


def test_settings_are_read_or_refused_word_by_word():
    KNOWN.check(
        "settings", {name: result_of(Settings.read, **one) for name, one in SETTINGS.items()}
    )


FILES = {
    "whole": "columns: {force_x: Fz}\ntare: 0 s, 1 s\nfrom: 2 s\nto: 3 s\ntitles: 0\n",
    "several windows": "tare: [0 s\\, 1 s, b]\n".replace("\\", ""),
    "a key": "colums: {}\n",
    "columns": "columns: [a]\n",
    "columns of numbers": "columns: {force_x: 3}\n",
    "windows": "tare: {a: b}\n",
    "windows of numbers": "tare: [1, 2]\n",
    "true": "titles: true\n",
    "a text for a number": "titles: three\n",
    "a number for a text": "speed: 3\n",
    "a list": "- a\n",
    "nothing": "",
    "no YAML": "a: [\n",
}


def test_a_settings_file_is_read_or_refused_word_by_word(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    found = {}
    for name, text in FILES.items():
        Path("import.yaml").write_text(text, encoding="utf-8")
        found[name] = result_of(read_file, Path("import.yaml"))
    found["none"] = result_of(read_file, Path("none.yaml"))
    KNOWN.check("settings files", found)
