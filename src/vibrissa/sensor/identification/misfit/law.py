"""Whether slips end where their law says: frictions by travels beside those by the last states."""

from typing import TYPE_CHECKING

import numpy as np

from vibrissa.numerics.arrays import FloatArray
from vibrissa.sensor.identification.reading.uncertainty import common_deviation

if TYPE_CHECKING:
    from vibrissa.sensor.identification.friction import Periods

# Fewer periods do not test a law; by so many standard deviations they do not fit it.
FEWEST, CERTAIN = 3, 4.0


def off_law(travels: "Periods", states: "Periods", shared: FloatArray | None) -> bool:
    """Tell whether frictions by travels and by last states disagree.

    Parameters
    ----------
    travels, states : Periods
        The same p periods, read by either.
    shared : ndarray, shape (k, k), or None
        Covariance of the k things that all periods share; None where they are independent.
    """
    known = np.isfinite(travels.mu0 - states.mu0)
    if known.sum() < FEWEST:
        return False
    travels, states = travels.take(known), states.take(known)
    effects = (travels.effects - states.effects).mean(axis=0, keepdims=True)
    common = common_deviation(effects, np.eye(effects.shape[1]) if shared is None else shared)[0]
    own = sum(one.deviation**2 - one.common**2 for one in (travels, states))
    random = np.sqrt(np.maximum(own, 0.0).mean() / len(travels))
    # A tip that slips while the stage moves does so up to a step earlier: half of it on average,
    # and uniform within a step are √12 deviations.
    allowed = np.sqrt(3.0) * travels.by_step.mean()
    apart = abs(float((travels.mu0 - states.mu0).mean()))
    return bool(apart > allowed + CERTAIN * np.hypot(common, random))


def remaining_part(needed: FloatArray, mu0: FloatArray) -> float:
    """Part of its friction that the tip needs where it has come to rest, of the usual period.

    Parameters
    ----------
    needed, mu0 : ndarray, shape (p,)
        Friction that the first state of each period needs, and the friction there.
    """
    known = np.isfinite(mu0)
    return float(np.median(np.abs(needed[known]) / mu0[known]))
