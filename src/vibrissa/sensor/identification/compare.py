"""The friction by the model of the rod beside that by the ratio of the forces, which needs none.

Both read the same samples, with the covariance Σ of the readings before and C after the fit. With
the effects R and M of errors on ratio and model, their difference has the variance
R·Σ·Rᵀ + M·C·Mᵀ − 2·R·C·Mᵀ.
"""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from vibrissa.numerics.arrays import BoolArray, FloatArray
from vibrissa.sensor.identification.checks import Grade
from vibrissa.sensor.identification.periods import PeriodStatus

if TYPE_CHECKING:
    from vibrissa.sensor.identification.result import Identification

# By so many standard deviations the means differ, and the frictions of one period.
MEANS, ONE = 4.0, 6.0
# Fewer periods are not compared.
FEWEST = 3


@dataclass(frozen=True, eq=False, kw_only=True)
class Beside:
    """Friction by the model beside that by the ratio of the forces.

    Attributes
    ----------
    ratio, deviation : ndarray, shape (p,)
        μ0 of each period by the ratio, and its standard deviation; NaN where it was not read.
    difference, spread : float
        Mean of model less ratio, of periods that do not disagree by themselves unless most do, and
        its standard deviation; NaN if the periods are too few.
    off : ndarray of bool, shape (p,)
        Which periods disagree: all, where the means do.
    """

    ratio: FloatArray
    deviation: FloatArray
    number: int
    off: BoolArray
    difference: float = np.nan
    spread: float = np.nan

    @property
    def agrees(self) -> bool:
        """Whether both means agree, or are unknown."""
        return not abs(self.difference) > MEANS * self.spread


def beside(model: "Identification", ratio: "Identification") -> Beside:
    """Compare the model with the ratio of the forces, both of the same periods."""
    one, other = model.periods, ratio.periods
    known = (one.status == PeriodStatus.SLIP) & (other.status == PeriodStatus.SLIP)
    known &= other.grade != Grade.WRONG
    apart = one.mu0 - other.mu0
    own = one.by_noise**2 + other.by_noise**2
    # The onset is late by the same part of the step.
    by_step = np.abs(one.by_step - other.by_step)
    shared = _common(one.effects, other.effects, model, ratio)
    alone = known & (np.abs(apart) > ONE * np.sqrt(own + by_step**2 + shared))
    found = Beside(
        ratio=np.where(known, other.mu0, np.nan),
        deviation=np.where(known, other.deviation, np.nan),
        number=int(known.sum()),
        off=alone,
    )
    if found.number < FEWEST:
        return found
    # One that disagrees by itself does not make all of them doubtful.
    kept = known & ~alone if 2 * alone.sum() < known.sum() else known
    mine, theirs = (each.effects[kept].mean(axis=0)[None] for each in (one, other))
    variance = _common(mine, theirs, model, ratio)[0]
    variance += own[kept].mean() / kept.sum() + by_step[kept].mean() ** 2
    found = replace(found, difference=float(apart[kept].mean()), spread=float(np.sqrt(variance)))
    return found if found.agrees else replace(found, off=np.ones(len(one), dtype=bool))


def _common(
    of_model: FloatArray, of_ratio: FloatArray, model: "Identification", ratio: "Identification"
) -> FloatArray:
    """Variance of the difference by the common errors, for effects of shape (n, k) each."""
    names = [one.name for one in model.tolerances]
    places = [names.index(one.name) for one in ratio.tolerances]
    both = np.zeros_like(of_model)
    both[:, places] = of_ratio[:, : len(places)]
    found = np.einsum("ni,ij,nj->n", of_ratio, ratio.covariance, of_ratio)
    found += np.einsum("ni,ij,nj->n", of_model - 2.0 * both, model.covariance, of_model)
    return np.asarray(np.maximum(found, 0.0))
