"""Falls of the load, by which slips are found."""

import numpy as np
import pytest
from scipy.signal import find_peaks

from vibrissa.sensor.identification.slips import SLIP_FALL, _large_falls


@pytest.mark.parametrize("seed", range(10))
def test_large_falls_are_those_from_prominent_peaks_to_the_lowest_load_after_them(seed):
    load = np.cumsum(np.random.default_rng(seed).normal(scale=0.6 * SLIP_FALL, size=300))
    # A fall may begin in the first row: a lower load before that row makes it a peak.
    peaks = find_peaks(np.append(-np.inf, load), prominence=SLIP_FALL)[0] - 1
    troughs = [
        start + int(load[start:stop].argmin())
        for start, stop in zip(peaks, [*peaks[1:], len(load)], strict=True)
    ]
    assert len(peaks) > 10
    assert list(_large_falls(load.tolist())) == list(zip(peaks.tolist(), troughs, strict=True))


def test_a_fall_begins_after_the_last_of_equal_loads():
    load = [0.0, 2 * SLIP_FALL, 2 * SLIP_FALL, 2 * SLIP_FALL, 0.0, 0.0]
    assert list(_large_falls(load)) == [(3, 4)]
