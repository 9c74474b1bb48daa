"""The ratio of kinetic and static friction, told by the readings after each slip.

A tip that came to rest by kinetic friction needs κ·μ0 there, and sticks at that place until it
needs μ0. So κ is the friction that the first state of a period needs over that of its onset.
"""

from contextlib import suppress
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from vibrissa.errors import UndeterminedError
from vibrissa.sensor.identification.alternatives import STEP, Alternative
from vibrissa.sensor.identification.reading.uncertainty import step_deviation

if TYPE_CHECKING:
    from vibrissa.sensor.identification.calibration import Setup
    from vibrissa.sensor.identification.seen import Seen

# Fewer periods do not tell it.
FEWEST = 3
# A ratio that the readings tell so many times as closely should not have been given.
MUCH_CLOSER = 4.0
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
            "the recording does not tell the kinetic ratio after its slips: give it"
        )
    scatter = float(each.std(ddof=1))
    shared = np.sqrt(max(float(by_step.mean()) ** 2 - scatter**2, 0.0))
    random = OF_MEDIAN * scatter / np.sqrt(len(each))
    return KineticRatio(value=value, deviation=float(np.hypot(random, shared)))


def sharing_ratio(setup: "Setup", kinetic: KineticRatio) -> "Setup":
    """Let the error of the kinetic ratio be one that all periods share, the last one."""
    number = len(setup.displaced)
    shared = np.zeros((number + 1, number + 1))
    shared[:number, :number] = np.eye(number) if setup.shared is None else setup.shared
    shared[number, number] = kinetic.deviation**2
    step = kinetic.deviation or STEP
    more = Alternative(name="kinetic_ratio", step=step, kinetic_ratio=step)
    return replace(setup, displaced=(*setup.displaced, more), shared=shared)


def told_closer(given: float, setup: "Setup", seen: "Seen") -> tuple[str, ...]:
    """Say that the readings tell the kinetic ratio much more closely than what was given.

    Parameters
    ----------
    given : float
    setup : Setup
        With the error that was given with it, and those of the rod, which what is told has too.
    seen : Seen

    Returns
    -------
    tuple of str
        Empty where they do not tell it, or not so closely.
    """
    names = [one.name for one in setup.displaced]
    if setup.shared is None or "kinetic_ratio" not in names:
        return ()
    number = names.index("kinetic_ratio")
    deviation = float(np.sqrt(setup.shared[number, number]))
    with suppress(UndeterminedError):
        told = ratio_after_slips(seen)
        effects = np.array([_effect(seen, other) for other in setup.displaced])
        least = float(np.hypot(told.deviation, np.sqrt(effects @ setup.shared @ effects)))
        if MUCH_CLOSER * least < deviation:
            return (
                f"the states after slips tell kinetic_ratio = {told.value:.3f} ± {least:.1g}, "
                f"closer than the {given:g} ± {deviation:.2g} that was given: do not give it",
            )
    return ()


def _effect(seen: "Seen", other: Alternative) -> float:
    """Change of what the states after slips tell, per unit of something."""
    if other.kinetic_ratio:
        return 0.0
    told, before = (ratio_after_slips(seen.nearby(one)).value for one in (other, other.before))
    return (told - before) / other.step
