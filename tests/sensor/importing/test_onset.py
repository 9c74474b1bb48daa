"""When a stage began to move, by the readings alone: what is a rest, and what a pause."""

import numpy as np
import pytest

from vibrissa.errors import RecordingError
from vibrissa.sensor.identification.recording import noise_of
from vibrissa.sensor.importing.onset import Motion, _stretches, moving_by_readings


def stepped(held, pause):
    """Readings that rise in steps, each held for some samples, one of them longer; then a rest."""
    levels = np.repeat(np.arange(160.0), held)
    after = int(np.argmax(levels == 80.0))
    levels = np.r_[levels[:after], np.full(pause - held, 79.0), levels[after:], np.full(99, 160.0)]
    noise = np.random.default_rng(1).normal(0.0, 0.01, (len(levels), 2))
    return noise + levels[:, np.newaxis] * [0.2, -0.1], after + pause - held


@pytest.mark.parametrize(("held", "longest"), [(1, 20), (6, 24)])
def test_a_pause_that_is_not_longer_than_allowed_is_no_rest(held, longest):
    readings, _ = stepped(held, longest)
    assert moving_by_readings(readings, "a.csv").rows.start == 0
    readings, end = stepped(held, longest + 1)
    motion = moving_by_readings(readings, "a.csv")
    assert 0 <= end - motion.rows.start <= motion.spread
    assert 95 <= len(readings) - motion.rows.stop <= 99


def test_a_channel_without_noise_tells_no_motion():
    readings, _ = stepped(1, 60)
    dead = np.column_stack([readings[:, 0], np.zeros(len(readings))])
    for some in (dead, dead[:, :1] * 0.0):
        assert moving_by_readings(some, "a.csv") == Motion(slice(0, len(readings)), 0)


def swinging(size):
    """At rest for 60 samples; then readings that rise, and swing besides."""
    since = np.maximum(np.arange(200) - 59.0, 0.0)
    noise = np.random.default_rng(1).normal(0.0, 1.0, 200)
    return (noise + 6.0 * since + size * np.sin(0.3 * since))[:, np.newaxis]


def left(readings):
    """Squares that no constant and parabola explain, per reading, of 90 samples."""
    stretch, squares = readings[:90, 0] / noise_of(readings), []
    for begin in range(30, 64):
        since = np.maximum(np.arange(90.0) - begin, 0.0)
        terms = np.stack([np.ones(90), since, since**2], axis=1)
        squares.append(np.linalg.lstsq(terms, stretch, rcond=None)[1][0])
    return min(squares) / 90.0


def test_a_motion_that_is_no_parabola_is_asked_for():
    assert 2.5 < left(swinging(4.5)) < 3.0 < left(swinging(5.0)) < 3.5
    assert moving_by_readings(swinging(4.5), "a.csv").rows.start == 58
    said = "a.csv: where the stage begins to move cannot be told from the readings: give --from"
    with pytest.raises(RecordingError, match=said):
        moving_by_readings(swinging(5.0), "a.csv")
    said = "a.csv: where the stage stops cannot be told from the readings: give --to"
    with pytest.raises(RecordingError, match=said):
        moving_by_readings(swinging(5.0)[::-1], "a.csv")


def test_readings_are_cut_where_they_change_by_more_than_noise():
    noise = np.random.default_rng(2).normal(size=(90, 2))
    assert _stretches(noise).tolist() == [0]
    levels = np.repeat([0.0, 20.0, 0.0], 30)
    assert _stretches(noise + levels[:, np.newaxis] * [0.0, 1.0]).tolist() == [0, 30, 60]
