"""Intervals of the friction where a slip ends short of α = 0, as tests/sensor has it of others."""

import numpy as np
import pytest

from recordings import covered
from responses import respond


@pytest.mark.parametrize("law", ["kinetic", "energy"])
def test_intervals_cover_what_they_say(law):
    within = covered(respond(2.0, 0.85), law, range(100, 110))
    # 93 to 97 % is what is promised.
    assert len(within) > 400
    assert 0.93 <= np.mean(within) <= 0.97
