"""Whether intervals hold the truth as often as they say."""

import numpy as np


def cover_as_they_say(inside, share=0.95):
    """Whether the truth was inside of so many intervals as it should, up to three deviations."""
    deviation = np.sqrt(share * (1.0 - share) / len(inside))
    return abs(np.mean(inside) - share) <= 3.0 * deviation
