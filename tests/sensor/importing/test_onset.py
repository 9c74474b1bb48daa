"""When a stage began to move, by the readings alone: what is a rest, and what a pause."""

import numpy as np
import pytest

from vibrissa.sensor.importing.onset import moving_by_readings


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
