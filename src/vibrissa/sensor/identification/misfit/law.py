"""Whether slips end where their law says: frictions by travels beside those by the last states."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from vibrissa.numerics.arrays import FloatArray
from vibrissa.sensor.identification.reading.methods import AT_REST, EITHER, ON_THE_WAY
from vibrissa.sensor.identification.reading.uncertainty import common_deviation

if TYPE_CHECKING:
    from vibrissa.sensor.identification.friction import Periods

# Fewer periods do not test a law; by so many standard deviations they do not fit it.
FEWEST, CERTAIN = 3, 4.0
# By so many it is told when the tip slips.
LIKELY = 3.0


@dataclass(frozen=True, kw_only=True)
class Apart:
    """How far frictions by travels are from those by last states, on average.

    Attributes
    ----------
    size, deviation : float
        Mean difference, and its standard deviation.
    half_step : float
        What a tip does that slips while the stage moves: up to a step earlier, half of it on
        average. That makes the travels shorter.
    """

    size: float
    deviation: float
    half_step: float

    @property
    def off_law(self) -> bool:
        """Whether slips do not end as the law says."""
        return abs(self.size) > self.half_step + CERTAIN * self.deviation

    @property
    def early(self) -> tuple[float, float]:
        """Whether the tip slips while the stage moves or at rest, as far as this tells."""
        nearer_rest = self.size + 0.5 * self.half_step
        if abs(nearer_rest) < LIKELY * self.deviation:
            return EITHER
        return AT_REST if nearer_rest > 0.0 else ON_THE_WAY


def apart(travels: "Periods", states: "Periods", shared: FloatArray | None) -> Apart:
    """Compare frictions by travels with those by last states.

    Parameters
    ----------
    travels, states : Periods
        The same p periods, read by either; the travels as of a tip that slips at rest.
    shared : ndarray, shape (k, k), or None
        Covariance of the k things that all periods share; None where they are independent.

    Returns
    -------
    Apart
        Unknown to within all there is, where fewer than three periods are read by both.
    """
    known = np.isfinite(travels.mu0) & np.isfinite(states.mu0)
    if known.sum() < FEWEST:
        return Apart(size=0.0, deviation=np.inf, half_step=0.0)
    travels, states = travels.take(known), states.take(known)
    effects = (travels.effects - states.effects).mean(axis=0, keepdims=True)
    common = common_deviation(effects, np.eye(effects.shape[1]) if shared is None else shared)[0]
    own = sum(one.deviation**2 - one.common**2 for one in (travels, states))
    random = np.sqrt(np.maximum(own, 0.0).mean() / len(travels))
    return Apart(
        size=float((travels.mu0 - states.mu0).mean()),
        deviation=float(np.hypot(common, random)),
        # What is uniform within a step has a deviation of 1/√12 of it.
        half_step=float(np.sqrt(3.0) * travels.by_step.mean()),
    )


def remaining_part(needed: FloatArray, mu0: FloatArray) -> float:
    """Part of its friction that the tip needs where it has come to rest, of the usual period.

    Parameters
    ----------
    needed, mu0 : ndarray, shape (p,)
        Friction that the first state of each period needs, and the friction there.
    """
    known = np.isfinite(mu0)
    return float(np.median(np.abs(needed[known]) / mu0[known]))
