"""What an identification finds of friction and set-up, and whether both methods agree.

The friction by the model of the rod is compared with that by the ratio of the forces, which needs
no rod. Both use the same samples, and friction by the model has the least possible variance.
Therefore the errors that all periods share have in the difference of both methods at most the
variance that they have in the ratio (Hausman, 1978).
"""

from dataclasses import dataclass

import numpy as np

from vibrissa.numerics.arrays import BoolArray, FloatArray
from vibrissa.quantities.units import Units
from vibrissa.sensor.identification.goodness import Cause, Estimate, Goodness
from vibrissa.sensor.identification.periods import Grade, Periods, PeriodStatus
from vibrissa.sensor.identification.propagation import common_deviation
from vibrissa.sensor.identification.slope import Slope
from vibrissa.wording import counted

# Number of standard deviations above which the means disagree.
MEANS_DISAGREE = 4.0
# The same for the frictions of one period.
PERIODS_DISAGREE = 6.0
# Least number of periods whose means are compared.
FEWEST_COMPARED = 3


@dataclass(frozen=True, eq=False, kw_only=True)
class Beside:
    """Comparison of the friction by the model with the friction by the ratio of the forces.

    Attributes
    ----------
    ratio, deviation : ndarray, shape (p,)
        μ0 of each period by the ratio of the forces, and its standard deviation; NaN unless both
        methods found μ0 and that by the ratio is not graded wrong.
    difference, spread : float
        Mean of μ0 by the model less μ0 by the ratio, and the standard deviation of this mean. If
        the methods disagree in fewer than half of the periods, these periods are left out. NaN if
        fewer than `FEWEST_COMPARED` periods can be compared.
    number : int
        Number of periods in the mean.
    off : ndarray of bool, shape (p,)
        Whether the methods disagree in each period; true in all periods if the means disagree.
    """

    ratio: FloatArray
    deviation: FloatArray
    off: BoolArray
    difference: float
    spread: float
    number: int

    @property
    def agrees(self) -> bool:
        """Whether the means by both methods agree; true if they are not known."""
        return not abs(self.difference) > MEANS_DISAGREE * self.spread

    def __str__(self) -> str:
        """Format the difference as a line."""
        within = f"within {MEANS_DISAGREE:g} standard deviations"
        verdict = f"they agree {within}" if self.agrees else "they disagree: one of them is wrong"
        return (
            "the model of the rod and the ratio of the forces differ by "
            f"{self.difference:+.2g} ± {self.spread:.2g} in mu0, the mean of "
            f"{counted(self.number, 'period')}: {verdict}"
        )


@dataclass(frozen=True, eq=False, kw_only=True)
class Findings:
    """Friction of the periods of a recording, and what the recording tells of the set-up.

    Attributes
    ----------
    periods : Periods
        Nondimensional periods with their friction.
    units : Units
        Units of the results.
    estimates : tuple of Estimate
        Estimates of the quantities of the set-up that have a tolerance.
    covariance : ndarray, shape (k, k)
        Covariance of the errors that the estimates still have after the fit. With the ratio of the
        forces, the last row and column are for the error due to the degree of the polynomials that
        are fitted to the forces.
    slope : Slope
        Tolerance of the local slope of the surface.
    goodness : Goodness or None
        Whether the recording as a whole fits the given set-up; None without a rod.
    causes : tuple of Cause
        Quantities that may differ from their given values, if the recording does not fit or an
        estimate is far from its given value.
    beside : Beside or None
        Comparison of the two methods; None if only one was used.
    """

    periods: Periods
    units: Units
    estimates: tuple[Estimate, ...]
    covariance: FloatArray
    slope: Slope
    goodness: Goodness | None = None
    causes: tuple[Cause, ...] = ()
    beside: Beside | None = None

    @property
    def fits(self) -> bool:
        """Whether the recording fits the set-up; true if `goodness` is None."""
        return self.goodness is None or self.goodness.fits


def beside(model: Findings, ratio: Findings) -> Beside:
    """Compare the friction by the model with that by the ratio of the forces, period by period."""
    by_model = model.periods
    by_ratio = ratio.periods
    known = (by_model.status == PeriodStatus.SLIP) & (by_ratio.status == PeriodStatus.SLIP)
    known &= by_ratio.grade != Grade.WRONG
    apart = by_model.mu0 - by_ratio.mu0
    own = by_model.by_noise**2 + by_ratio.by_noise**2
    # Both methods have the same error of the onset within the step.
    by_step = np.abs(by_model.by_step - by_ratio.by_step)
    alone = known & (
        np.abs(apart) > PERIODS_DISAGREE * np.sqrt(own + by_step**2 + by_ratio.common**2)
    )
    difference = spread = np.nan
    # A single period that disagrees does not make all periods doubtful.
    kept = known & ~alone if 2 * alone.sum() < known.sum() else known
    if known.sum() >= FEWEST_COMPARED:
        effect = by_ratio.effects[kept].mean(axis=0)[None]
        variance = common_deviation(effect, ratio.covariance)[0] ** 2
        variance += own[kept].mean() / kept.sum() + by_step[kept].mean() ** 2
        difference, spread = float(apart[kept].mean()), float(np.sqrt(variance))
    return Beside(
        ratio=np.where(known, by_ratio.mu0, np.nan),
        deviation=np.where(known, by_ratio.deviation, np.nan),
        off=alone | (abs(difference) > MEANS_DISAGREE * spread),
        difference=difference,
        spread=spread,
        number=int(kept.sum()),
    )
