"""The friction by the model of the rod beside that by the ratio of the forces, which needs none.

Both read the same samples. So what they share does not count where they are compared. An error ε of
the readings has the variance Σ before and C after the fit. The ratio, with the effects R, has the
error R·ε; the model, with the effects M, has M·δ with the covariance C of δ, which is also that of
δ and ε. So the variance of the difference is R·Σ·Rᵀ + M·C·Mᵀ − 2·R·C·Mᵀ.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from vibrissa.numerics.arrays import BoolArray, FloatArray, IntArray
from vibrissa.sensor.identification.adjusted import Tolerance
from vibrissa.sensor.identification.checks import Grade
from vibrissa.sensor.identification.periods import Periods, PeriodStatus

# By so many standard deviations the means differ, and the frictions of one period.
MEANS, ONE = 4.0, 6.0
# Fewer periods are not compared.
FEWEST = 3


@dataclass(frozen=True, kw_only=True)
class Read:
    """Periods as one way shows them, and what is not known of it.

    Attributes
    ----------
    periods : Periods
    tolerances : tuple of Tolerance
        In the order of the effects of the periods.
    covariance : ndarray, shape (k, k)
    """

    periods: Periods
    tolerances: Sequence[Tolerance]
    covariance: FloatArray


@dataclass(frozen=True, eq=False, kw_only=True)
class Beside:
    """Friction by the model beside that by the ratio of the forces.

    Attributes
    ----------
    ratio, deviation : ndarray, shape (p,)
        μ0 of each of the model's periods by the ratio, and its standard deviation; NaN where it was
        not read.
    difference, spread : float
        Mean of model less ratio, of periods that do not disagree by themselves unless most do, and
        its standard deviation.
    number : int
        Of how many periods.
    off : ndarray of bool, shape (p,)
        Which of the model's periods disagree: all, where the means do.
    """

    ratio: FloatArray
    deviation: FloatArray
    difference: float
    spread: float
    number: int
    off: BoolArray

    @property
    def compared(self) -> bool:
        """Whether enough periods are read by both."""
        return self.number >= FEWEST

    @property
    def agrees(self) -> bool:
        """Whether the means do, or are not known."""
        return not abs(self.difference) > MEANS * self.spread

    @property
    def size(self) -> str:
        """The difference in words."""
        return f"by {self.difference:+.2g} ± {self.spread:.1g}"


def beside(model: Read, ratio: Read) -> Beside:
    """Compare the model with the ratio of the forces, period by period.

    Periods are the same where they end in the same sample.
    """
    one, rows = model.periods, _same(model.periods, ratio.periods)
    other = ratio.periods.take(np.maximum(rows, 0))
    known = (rows >= 0) & (one.status == PeriodStatus.SLIP) & (other.status == PeriodStatus.SLIP)
    known &= other.grade != Grade.WRONG
    mu0, deviation = (np.where(known, each, np.nan) for each in (other.mu0, other.deviation))
    apart = one.mu0 - mu0
    shared = _common(one.effects, other.effects, model, ratio) + other.shared**2
    own = _own_variance(one) + _own_variance(other)
    # The onset is late by the same part of the step.
    by_step = np.abs(one.by_step - other.by_step)
    alone = known & (np.abs(apart) > ONE * np.sqrt(own + by_step**2 + shared))
    # One that disagrees by itself does not make all of them doubtful.
    kept = known & ~alone if 2 * alone.sum() < known.sum() else known
    number, difference, spread = int(known.sum()), np.nan, np.nan
    if number >= FEWEST:
        mine, theirs = (each[kept].mean(axis=0)[None] for each in (one.effects, other.effects))
        variance = _common(mine, theirs, model, ratio)[0] + other.shared[kept].mean() ** 2
        variance += own[kept].mean() / kept.sum() + by_step[kept].mean() ** 2
        difference, spread = float(apart[kept].mean()), float(np.sqrt(variance))
    found = Beside(
        ratio=mu0,
        deviation=deviation,
        difference=difference,
        spread=spread,
        number=number,
        off=alone,
    )
    return found if found.agrees else replace(found, off=np.ones(len(one), dtype=bool))


def _own_variance(periods: Periods) -> FloatArray:
    """Variance of each friction by noise alone."""
    squares = periods.deviation**2 - periods.common**2 - periods.by_step**2
    return np.maximum(squares, 0.0)


def _same(model: Periods, ratio: Periods) -> IntArray:
    """Row of the ratio's period that ends in the same line as each of the model's; −1 if none."""
    rows = {line: row for row, line in enumerate(ratio.last_line.tolist())}
    return np.array([rows.get(line, -1) for line in model.last_line.tolist()], dtype=int)


def _common(of_model: FloatArray, of_ratio: FloatArray, model: Read, ratio: Read) -> FloatArray:
    """Variance of the difference by what all periods share, for effects of shape (n, k) each."""
    places = {one.name: i for i, one in enumerate(model.tolerances)}
    shared = np.zeros((len(ratio.tolerances), len(model.tolerances)))
    for i, one in enumerate(ratio.tolerances):
        if one.name in places:
            shared[i] = model.covariance[places[one.name]]
    found = np.einsum("ni,ij,nj->n", of_ratio, ratio.covariance, of_ratio)
    found += np.einsum("ni,ij,nj->n", of_model, model.covariance, of_model)
    found -= 2.0 * np.einsum("ni,ij,nj->n", of_ratio, shared, of_model)
    return np.asarray(np.maximum(found, 0.0))
