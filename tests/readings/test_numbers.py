"""Random numbers of a recording: what they depend on."""

import numpy as np
import pytest

from vibrissa.readings.reading import generator_of
from vibrissa.study.readings import digest_of_point

POINT = {"theta": 2.0, "eta": 0.85, "dx0": 0.001, "mu0": 0.3, "law": "free", "clamp_angle": 0.0}


def numbers(point, seed=1, recording=1):
    return generator_of(point, seed, recording).normal(size=5)


def test_an_axis_that_is_added_changes_no_numbers():
    added = POINT | {"adhesion": 0.0}
    assert np.array_equal(numbers(added), numbers(POINT))
    assert digest_of_point(added) == digest_of_point(POINT)


@pytest.mark.parametrize(
    "other",
    [
        {"point": POINT | {"theta": 3.0}},
        {"point": POINT | {"clamp_angle": 0.1}},
        {"point": POINT | {"curvature": (0.0, 0.1)}},
        {"point": POINT | {"adhesion": 0.1}},
        {"point": {key: value for key, value in POINT.items() if key != "mu0"} | {"mean": 0.3}},
        {"point": POINT, "seed": 2},
        {"point": POINT, "recording": 2},
    ],
)
def test_each_point_seed_and_recording_has_numbers_of_its_own(other):
    assert not np.isin(numbers(**other), numbers(POINT)).any()
