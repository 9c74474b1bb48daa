"""The ratio of kinetic and static friction, told by the readings after each slip.

A tip that came to rest by kinetic friction needs κ·μ0 there, and sticks at that place until it
needs μ0. So κ is the friction that the first state of a period needs over that of its onset.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from vibrissa.errors import UndeterminedError
from vibrissa.sensor.identification.reading.uncertainty import step_deviation

if TYPE_CHECKING:
    from vibrissa.sensor.identification.seen import Seen

# Fewer periods do not tell it.
FEWEST = 3
# Standard error of a median over that of a mean, of normal values.
OF_MEDIAN = float(np.sqrt(0.5 * np.pi))


@dataclass(frozen=True, kw_only=True)
class KineticRatio:
    """The ratio μk/μ0, and its standard deviation."""

    value: float
    deviation: float


def ratio_after_slips(seen: "Seen") -> KineticRatio:
    """Tell the kinetic ratio from the states after slips.

    Parameters
    ----------
    seen : Seen

    Returns
    -------
    KineticRatio
        The error of the onset by the step counts as the same in all periods, unless they scatter
        by more.

    Raises
    ------
    UndeterminedError
        If fewer than three periods begin and end with a slip, or the ratio is none below 1.
    """
    last = seen.last
    middle = seen.ending.clip(last.travel + 0.5 * last.gap)
    static = np.abs(seen.ending.demand(middle) + last.base)
    begins = seen.periods.begins
    kinetic = np.abs(seen.states.demand(seen.states.clip(seen.x0))[begins])
    by_step = step_deviation(seen.ending.demand_slope(middle), np.abs(last.gap))
    # The first begins without a slip, the last ends without.
    each, by_step = (kinetic / static)[1:-1], (kinetic / static**2 * by_step)[1:-1]
    known = np.isfinite(each)
    each, by_step = each[known], by_step[known]
    value = float(np.median(each)) if len(each) >= FEWEST else np.nan
    if not 0.0 < value < 1.0:
        raise UndeterminedError(
            "the recording does not tell the kinetic ratio after its slips: give kinetic_ratio"
        )
    scatter = float(each.std(ddof=1))
    shared = np.sqrt(max(float(by_step.mean()) ** 2 - scatter**2, 0.0))
    random = OF_MEDIAN * scatter / np.sqrt(len(each))
    return KineticRatio(value=value, deviation=float(np.hypot(random, shared)))
