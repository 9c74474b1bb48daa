"""Whether the interval of a reading contains the truth."""

import pytest

from vibrissa.outcomes import ReadingStatus
from vibrissa.readings.reading import Reading


@pytest.mark.parametrize("off", [-2.0, -1.9, 0.0, 1.9, 2.0])
def test_the_interval_has_196_standard_deviations_on_both_sides(off):
    # 0.006 and 0.008 make 0.01.
    reading = Reading(
        status=ReadingStatus.READ,
        mu0_true=0.3,
        mu0_read=0.3 + 0.01 * off,
        mu0_random=0.006,
        mu0_common=0.008,
    )
    assert reading.inside is (abs(off) < 1.96)


def test_without_an_estimate_it_is_not_known():
    assert Reading(status=ReadingStatus.REFUSED, mu0_true=0.3).inside is None
