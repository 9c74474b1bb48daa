"""Splines over adjacent intervals."""

from collections.abc import Sequence

import numpy as np
from scipy.interpolate import PPoly


def joined(splines: Sequence[PPoly]) -> PPoly:
    """Put splines over adjacent intervals together."""
    return PPoly(
        np.concatenate([spline.c for spline in splines], axis=1),
        np.concatenate([spline.x[:-1] for spline in splines] + [splines[-1].x[-1:]]),
        extrapolate=False,
    )
