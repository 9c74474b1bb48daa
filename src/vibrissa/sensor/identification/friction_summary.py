"""Friction of a surface from a recording, in a few numbers and lines.

Period i has the friction coefficient μ_i. Its error has the standard deviations n_i, due to the
noise of its readings, and s_i, due to the step of the stage; e_i is the change of μ_i per unit of
each error of the set-up. Friction varies from place to place with the variance t² (DerSimonian and
Laird). Errors of the set-up are common to all periods. The error due to the step is common in
part only, as periods that differ in travel end at different places of a step. The common part has
the variance s'_i² = max(0, s_i² − l²) with l² = r²·max(0, t² − 2·q), where q is the standard error
of t². The part r of the friction rises within the period; the rest is left from the slip before.
With the weights w_i, proportional to 1/(n_i² + t² + s'_i²), whose sum is 1,

    mean = Σ w_i·μ_i,   random² = Σ w_i²·(n_i² + s_i² − s'_i²),
    common² = (Σ w_i·s'_i)² + e·C·eᵀ,   e = Σ w_i·e_i.

C is the covariance of the errors that the set-up still has after the fit. If quantity k were exact,
the variance of the mean would fall by (C·e)_k²/C_kk. Errors due to the slope of the surface are
part of n_i, and correlated in neighbouring periods: random² also has their covariances.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.special import chdtrc

from vibrissa.numerics.arrays import BoolArray, FloatArray
from vibrissa.sensor.identification.findings import Findings
from vibrissa.sensor.identification.goodness import SIGNIFICANCE
from vibrissa.sensor.identification.parameters import SLOPE
from vibrissa.sensor.identification.periods import Grade, Periods, PeriodStatus
from vibrissa.sensor.identification.propagation import common_deviation, variance_between
from vibrissa.wording import counted

# If more than this part of the frictions is graded wrong, none is left out: the rod may be the
# wrong one, and the mean is printed with a warning.
MOST_WRONG = 0.5
# A quantity should be measured first if, were it exact, less than this part of the standard
# deviation remained.
HELPS = 0.95
# Largest number of such quantities that are named.
NAMED_LIMITS = 3
# Part of a variance that is rounding of a difference.
ROUNDED_PART_OF_VARIANCE = 1e-12
# Least variance.
LEAST_VARIANCE = 1e-200


@dataclass(frozen=True, eq=False, kw_only=True)
class FrictionSummary:
    """Mean friction of a recording and its uncertainty; prints as a few lines.

    Attributes
    ----------
    found : Findings
        What is summarised.
    mean : float
        Weighted mean of μ0 over the places where the tip slipped; NaN if it slipped nowhere.
    random : float
        Standard deviation of the mean due to errors that differ from period to period.
    common : float
        Standard deviation of the mean due to errors that all periods share. They do not average
        out.
    if_exact : dict of str to float
        For each quantity with a tolerance: the standard deviation that the mean would have if this
        quantity alone were exact. The smallest comes first: a better measurement of that quantity
        helps most.
    variation : float
        Standard deviation of μ0 from place to place that errors do not explain; 0 unless Cochran's
        test shows such a variation.
    used : int
        Number of periods in the mean.
    left : dict of str to int
        Periods left out of the mean: their number for each status or grade.
    least : float
        Largest lower bound of μ0 among the periods that are not graded wrong: somewhere on the
        surface μ0 is at least this large. NaN if none of these periods has a bound.
    doubtful, wrong : int
        Numbers of periods in the mean that are graded doubtful, and graded wrong. Periods graded
        wrong are in the mean only if more than half of the periods with a slip are graded wrong.
    """

    found: Findings = field(repr=False)
    mean: float = np.nan
    random: float = np.nan
    common: float = np.nan
    if_exact: dict[str, float] = field(default_factory=dict)
    variation: float = 0.0
    used: int = 0
    left: dict[str, int] = field(default_factory=dict)
    least: float = np.nan
    doubtful: int = 0
    wrong: int = 0

    @property
    def deviation(self) -> float:
        """Standard deviation of the mean due to all errors, random and common."""
        return float(np.hypot(self.random, self.common))

    @property
    def grade(self) -> Grade | None:
        """`Grade` of most periods in the mean; None if most are not in doubt."""
        if self.doubtful + self.wrong <= MOST_WRONG * self.used:
            return None
        return Grade.WRONG if self.wrong > MOST_WRONG * self.used else Grade.DOUBTFUL

    def __str__(self) -> str:
        """Format the summary as lines."""
        return "\n".join((*self.answer(), *self.details()))

    def answer(self) -> Iterator[str]:
        """Mean friction or a bound of it, and whether to rely on it, as lines."""
        yield from self._mean() if self.used else self._bound()
        if coarse := self.found.periods.coarse:
            yield from coarse
        elif self.wrong:
            yield f"do not rely on mu0: {self.wrong} periods graded wrong, see the column doubt"
        elif self.doubtful:
            yield f"{counted(self.doubtful, 'period')} in doubt: see the column doubt of the table"

    def details(self) -> Iterator[str]:
        """Parts of the uncertainty, and how well recording, set-up and methods agree, as lines."""
        if self.used:
            yield from self._parts()
        if self.found.periods.coarse:
            return
        yield from self._fit()
        beside = self.found.beside
        if beside is not None and np.isfinite(beside.difference):
            yield str(beside)
        if self.used and self.variation:
            # No reading distinguishes friction from the slope of the surface.
            slope = np.rad2deg(self.variation / (1.0 + self.mean**2))
            yield (
                f"mu0 differs from place to place by ± {self.variation:.2g}, or the slope of the "
                f"surface by ± {slope:.2g} deg more than surface_slope"
            )

    @property
    def _of(self) -> str:
        left = ", ".join(f"{number} {why}" for why, number in self.left.items())
        of = f"{self.used} of {counted(len(self.found.periods), 'period')}"
        return f"{of} (left out: {left})" if left else of

    def _bound(self) -> Iterator[str]:
        yield f"no mean of mu0: {self._of} can be used"
        if self.left == {PeriodStatus.OPEN: len(self.found.periods)}:
            yield "no slip was recorded: record on until the tip slips"
        if np.isfinite(self.least):
            at = f"somewhere on the surface mu0 is at least {self.least:.3g}"
            yield f"{at}: see the columns low and high"

    def _mean(self) -> Iterator[str]:
        # To two digits of the error, which may be 0 or unknown.
        digits = int(np.clip(1 - np.floor(np.log10(np.fmax(self.deviation, 1e-9))), 0, 9))
        doubt = " (in doubt)" if self.grade else ""
        yield f"mu0 = {self.mean:.{digits}f} ± {self.deviation:.2g}{doubt}, mean of {self._of}"

    def _parts(self) -> Iterator[str]:
        yield f"± {self.random:.1g} is random, ± {self.common:.1g} the same in all periods"
        gains = {name: to for name, to in self.if_exact.items() if to < HELPS * self.deviation}
        first = [f"{name} (then ± {to:.2g})" for name, to in gains.items()][:NAMED_LIMITS]
        if first:
            yield f"measure first: {', '.join(first)}"

    def _fit(self) -> Iterator[str]:
        fit = self.found.goodness
        causes = self.found.causes
        if fit is None or (fit.fits and not causes):
            return
        if fit.fits:
            yield "A stated value is off by far more than its tolerance. Candidates, each alone:"
        else:
            each = (
                "Candidates, each taken alone:" if causes else "No single difference explains it."
            )
            size = f"chi2 is {fit.ratio:.3g} per degree of freedom"
            if fit.chance >= SIGNIFICANCE:
                size = "the surface rises and falls by more than surface_slope allows"
            yield f"The recording does not fit the set-up ({size}). {each}"
        yield from (f"  {cause.spelled(self.found.units)}" for cause in causes)


def used_in_mean(periods: Periods) -> BoolArray:
    """Whether each period is in the mean friction: it ends with a slip, and is not graded wrong.

    If most periods with a slip are graded wrong, all of them are in the mean.
    """
    wrong = periods.grade == Grade.WRONG
    slips = periods.status == PeriodStatus.SLIP
    most = wrong[slips].sum() > MOST_WRONG * slips.sum()
    return np.asarray(slips if most else slips & ~wrong)


def summary_of(found: Findings) -> FrictionSummary:
    """Summarise the friction of the periods of an identification."""
    periods = found.periods
    wrong = found.periods.grade == Grade.WRONG
    slips = periods.status == PeriodStatus.SLIP
    used = used_in_mean(periods)
    others = periods.status[~slips].tolist() + periods.grade[slips & ~used].tolist()
    bounds = periods.low[np.isfinite(periods.low) & ~wrong]
    known = FrictionSummary(
        found=found,
        used=int(used.sum()),
        least=float(bounds.max()) if len(bounds) else np.nan,
        left={why: others.count(why) for why in sorted(set(others))},
        doubtful=int((periods.grade[used] == Grade.DOUBTFUL).sum()),
        wrong=int((periods.grade[used] == Grade.WRONG).sum()),
    )
    return _with_mean(known, periods.take(used)) if used.any() else known


def _with_mean(known: FrictionSummary, used: Periods) -> FrictionSummary:
    """Add the mean of the used periods and its uncertainty to a summary."""
    slope = known.found.slope
    covariance = known.found.covariance
    noise = used.by_noise**2
    step = used.by_step**2
    # A period without any error would have all the weight.
    floor = np.maximum(ROUNDED_PART_OF_VARIANCE * used.deviation**2, LEAST_VARIANCE)
    between, error = variance_between(used.mu0, np.maximum(noise, floor))
    rises = np.clip(np.nan_to_num(np.median(1.0 - used.start / used.mu0), nan=1.0), 0.0, 1.0)
    same_step = np.maximum(step - rises**2 * max(0.0, between - 2.0 * error), 0.0)
    weights = 1.0 / np.maximum(noise + between + same_step, floor)
    weights /= weights.sum()
    effect = weights @ used.effects
    common = np.hypot(weights @ np.sqrt(same_step), common_deviation(effect[None], covariance)[0])
    # Errors due to the slope of the surface are correlated in neighbouring periods.
    by_slope = slope.variance_of_mean(weights, used.mu0, used.footpoint)
    more = by_slope - weights**2 @ slope.errors(used.mu0) ** 2
    random = np.sqrt(weights**2 @ (noise + step - same_step) + more)
    variance = float(random**2 + common**2)
    gained = _gained(effect, known.found) | ({SLOPE: by_slope} if slope.deviation else {})
    exact = {name: float(np.sqrt(max(0.0, variance - less))) for name, less in gained.items()}
    return replace(
        known,
        mean=float(weights @ used.mu0),
        random=float(random),
        common=float(common),
        variation=_variation(used.mu0, np.maximum(noise + step, LEAST_VARIANCE)),
        if_exact=dict(sorted(exact.items(), key=lambda item: item[1])),
    )


def _gained(effect: FloatArray, found: Findings) -> dict[str, float]:
    """Return by how much the variance of the mean would fall if each quantity alone were exact."""
    names = [estimate.parameter.of for estimate in found.estimates]
    gained = {}
    along = found.covariance @ effect
    for name in dict.fromkeys(names):
        rows = np.flatnonzero([other == name for other in names])
        # The covariance is singular if one part is exact, or follows from the others.
        inverse = np.linalg.pinv(found.covariance[np.ix_(rows, rows)], hermitian=True)
        gained[name] = float(along[rows] @ inverse @ along[rows])
    return gained


def _variation(mu0: FloatArray, variance: FloatArray) -> float:
    """Estimate the variation of μ0 from place to place; 0 unless Cochran's test shows it."""
    mean = np.average(mu0, weights=1.0 / variance)
    squares = float(((mu0 - mean) ** 2 / variance).sum())
    if len(mu0) < 2 or chdtrc(len(mu0) - 1, squares) >= SIGNIFICANCE:
        return 0.0
    return float(np.sqrt(variance_between(mu0, variance)[0]))
