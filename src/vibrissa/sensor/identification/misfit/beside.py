"""The friction by the model of the rod beside that by the ratio of the forces, which needs none.

Both read the same samples. So what they share does not count where they are compared: errors of the
readings, and the part of a step that the onset is late, as far as it does the same to both. An
error ε of the readings has the variance Σ before and C after the adjustment. The ratio, with the
effects R, has the error R·ε; the model, with the effects M, has M·δ with the covariance C of δ,
which is also that of δ and ε. So the variance of the difference is R·Σ·Rᵀ + M·C·Mᵀ − 2·R·C·Mᵀ.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from vibrissa.numerics.arrays import BoolArray, FloatArray, IntArray
from vibrissa.sensor.identification.adjusting.adjustment import Tolerance
from vibrissa.sensor.identification.friction import Periods, PeriodStatus
from vibrissa.sensor.identification.misfit.doubts import Grade

# By so many standard deviations the means differ, and the frictions of one period.
MEANS, ONE = 4.0, 6.0
# A variance that is none.
TINY = 1e-30
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
    common = _common(one.effects, other.effects, model, ratio)
    # The first shift is the error by how the forces curve.
    shared = np.sqrt(common + other.shifts[:, 0] ** 2)
    own = np.maximum(one.deviation**2 - one.common**2 - one.by_step**2, 0.0)
    own += np.maximum(other.deviation**2 - other.common**2 - other.by_step**2, 0.0)
    by_step = np.abs(one.by_step - other.by_step)
    alone = known & (np.abs(apart) > ONE * np.sqrt(own + by_step**2 + shared**2))
    # One that disagrees by itself does not make all of them doubtful.
    kept = known & ~alone if 2 * alone.sum() < known.sum() else known
    number, difference, spread = int(known.sum()), np.nan, np.nan
    if number >= FEWEST:
        columns = one.effects, other.effects, other.shifts
        of_model, of_ratio, shifts = (each[kept].mean(axis=0, keepdims=True) for each in columns)
        variance = _common(of_model, of_ratio, model, ratio)[0] + shifts[0, 0] ** 2
        variance += (own[kept] + by_step[kept] ** 2).mean() / kept.sum()
        variance += _step_of_all(apart[kept], by_step[kept], own[kept])
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


def _step_of_all(apart: FloatArray, by_step: FloatArray, own: FloatArray) -> float:
    """Variance of the mean difference by a part of the step that all onsets are late alike.

    A tip that slips at rest begins each period in a step of the stage. Where the friction hardly
    varies the next onset is late by the same part of a step again. And where coarse steps do not
    tell whether it slips at rest, half of what that does to the travel is in all of them. Errors
    that are alike are a line over what a step does to each; what differences scatter around it,
    beyond other errors, is not of that kind.
    """
    from_mean = by_step - by_step.mean()
    slope = (from_mean @ apart) / max(from_mean @ from_mean, TINY)
    around = apart - apart.mean() - slope * from_mean
    scatter = max(float((around**2).mean() - own.mean()), 0.0)
    alike = max(1.0 - scatter / max(float((by_step**2).mean()), TINY), 0.0)
    return alike * float(by_step.mean()) ** 2


def _same(model: Periods, ratio: Periods) -> IntArray:
    """Row of the ratio's period that ends in the same line as each of the model's; −1 if none."""
    rows = {line: row for row, line in enumerate(ratio.last_line.tolist())}
    return np.array([rows.get(line, -1) for line in model.last_line.tolist()], dtype=int)


def _common(of_model: FloatArray, of_ratio: FloatArray, model: Read, ratio: Read) -> FloatArray:
    """Variance of the difference by what all periods share, for effects of shape (n, k) each."""
    places = {one.name: i for i, one in enumerate(model.tolerances)}
    both = [(i, places[one.name]) for i, one in enumerate(ratio.tolerances) if one.name in places]
    shared = np.zeros((len(ratio.tolerances), len(model.tolerances)))
    for mine, theirs in both:
        shared[mine] = model.covariance[theirs]
    found = np.einsum("ni,ij,nj->n", of_ratio, ratio.covariance, of_ratio)
    found += np.einsum("ni,ij,nj->n", of_model, model.covariance, of_model)
    found -= 2.0 * np.einsum("ni,ij,nj->n", of_ratio, shared, of_model)
    return np.asarray(np.maximum(found, 0.0))
