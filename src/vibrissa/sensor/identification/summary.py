"""Friction of a surface by a recording, in a few numbers and lines.

Period i has the friction μ_i, with errors n_i by the readings, s_i by the step and e_i by the
set-up, which all periods share. The friction varies by t² (DerSimonian and Laird). The step has
the shared part s'_i² = max(0, s_i² − l²), where l² is t² less two of its standard errors. With
the weights w_i = 1/(n_i² + t² + s'_i²), normalised,

    mean = Σ w_i·μ_i,   random² = Σ w_i²·(n_i² + s_i² − s'_i²),
    common² = (Σ w_i·s'_i)² + (Σ w_i·e_i)·C·(Σ w_i·e_i)ᵀ.

An exact tolerance i takes (C·e)_i²/C_ii off the variance of the mean, where C is the covariance
of what remains of the errors, and e the change of the mean per unit of each.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.special import chdtrc

from vibrissa.numerics.arrays import BoolArray, FloatArray
from vibrissa.sensor.identification.checks import Grade
from vibrissa.sensor.identification.compare import Beside
from vibrissa.sensor.identification.goodness import LEVEL, Cause, Goodness, Tolerance
from vibrissa.sensor.identification.parameters import SLOPE
from vibrissa.sensor.identification.periods import Periods, PeriodStatus
from vibrissa.sensor.identification.slope import PLANE, Slope
from vibrissa.sensor.identification.uncertainty import common_deviation, variance_between
from vibrissa.sensor.quantities import Units
from vibrissa.wording import counted

# Where more than this part of the frictions is graded wrong, none is left out: the rod is another
# one, and the mean is given with a warning.
MOST_WRONG = 0.5
# What leaves more of the standard deviation if it were exact is not to be measured first.
HELPS = 0.95
# So many of those are named.
NAMED = 3
# Part of a variance that rounding leaves of a difference, and a variance that is none.
ROUNDING, LEAST = 1e-12, 1e-200


@dataclass(frozen=True, eq=False, kw_only=True)
class Setting:
    """Common data of the periods of a recording.

    Attributes
    ----------
    covariance : ndarray, shape (k, k)
        Of what remains of these errors.
    goodness : Goodness or None
        Whether the recording as a whole fits the given set-up; None without a rod.
    causes : tuple of Cause
        What may be other than it was given, if it does not, or only far off.
    beside : Beside or None
        The model of the rod beside the ratio of the forces.
    """

    units: Units
    tolerances: tuple[Tolerance, ...] = ()
    covariance: FloatArray = field(default_factory=lambda: np.zeros((0, 0)))
    slope: Slope = PLANE
    goodness: Goodness | None = None
    causes: tuple[Cause, ...] = ()
    beside: Beside | None = None

    @property
    def fits(self) -> bool:
        """Whether the recording fits what was given, as far as is known."""
        return self.goodness is None or self.goodness.fits


@dataclass(frozen=True, eq=False, kw_only=True)
class FrictionSummary:
    """Mean friction of a recording and its uncertainty; prints as a few lines.

    Attributes
    ----------
    mean : float
        Weighted mean of μ0 over the places where the tip slipped; NaN if nowhere.
    random : float
        Its standard deviation by errors that differ from period to period.
    common : float
        Its standard deviation by what all periods share. It does not average out.
    if_exact : dict of str to float
        What `deviation` would be if one tolerance were exact and the others as they are, the
        smallest first: what to measure first.
    variation : float
        Standard deviation of μ0 from place to place, beyond its errors; 0 where it is not certain.
    periods, used : int
        How many there are, and how many the mean is of.
    left : dict of str to int
        Why the others are left out: their status, or the grade of their doubts.
    least : float
        Largest lower bound of μ0 in any period, but those graded wrong; NaN if there is none.
    doubtful, wrong : int
        How many of those used are graded so.
    setting : Setting
    coarse : str
        Why the recording is too coarse; empty where it is not.
    """

    mean: float = np.nan
    random: float = np.nan
    common: float = np.nan
    if_exact: dict[str, float] = field(default_factory=dict)
    variation: float = 0.0
    periods: int = 0
    used: int = 0
    left: dict[str, int] = field(default_factory=dict)
    least: float = np.nan
    doubtful: int = 0
    wrong: int = 0
    setting: Setting
    coarse: str = ""

    @property
    def deviation(self) -> float:
        """Standard deviation of the mean."""
        return float(np.hypot(self.random, self.common))

    def __str__(self) -> str:
        """Format it as lines."""
        return "\n".join(self._lines())

    def _lines(self) -> Iterator[str]:
        yield from self._mean()
        if self.coarse:
            yield self.coarse
            return
        yield from self._fit()
        if not self.used:
            return
        if self.wrong:
            yield f"do not rely on it: {self.wrong} of them are graded wrong, see the column doubt"
        elif self.doubtful:
            are = "is" if self.doubtful == 1 else "are"
            yield f"{self.doubtful} of them {are} in doubt: see the columns grade and doubt"
        beside = self.setting.beside
        if beside is not None and beside.compared:
            said = "they agree" if beside.agrees else "they disagree: one of them is wrong"
            size = f"{beside.difference:+.2g} ± {beside.spread:.1g}"
            of = f"the model of the rod and the ratio of the forces differ by {size}"
            yield f"{of} in {counted(beside.number, 'period')}: {said}"
        if self.variation:
            yield f"mu0 differs from place to place by ± {self.variation:.2g}"

    def _mean(self) -> Iterator[str]:
        left = ", ".join(f"{number} {why}" for why, number in self.left.items())
        of = f"{self.used} of {counted(self.periods, 'period')}"
        of += f" (left out: {left})" if left else ""
        if not self.used:
            yield f"no mean of mu0, from {of}"
            if self.left == {PeriodStatus.OPEN: self.periods}:
                yield "no slip was recorded: record on until the tip slips"
            if np.isfinite(self.least):
                yield (
                    f"mu0 is at least {self.least:.3g} at one place or more: see the columns low "
                    "and high"
                )
            return
        yield f"mu0 = {_rounded(self.mean, self.deviation)} ± {self.deviation:.2g}, mean of {of}"
        yield f"± {self.random:.1g} is random, ± {self.common:.1g} the same in all periods"
        gains = {name: to for name, to in self.if_exact.items() if to < HELPS * self.deviation}
        first = [f"{name} (then ± {to:.2g})" for name, to in gains.items()][:NAMED]
        if first:
            yield f"measure first: {', '.join(first)}"

    def _fit(self) -> Iterator[str]:
        fit, causes = self.setting.goodness, self.setting.causes
        if fit is None or (fit.fits and not causes):
            return
        if fit.fits:
            yield "A given value is far off for its tolerance. Candidates, each taken alone:"
        else:
            found = "Candidates, each taken alone:" if causes else ""
            found = found or "No single difference explains it."
            size = f"chi2 is {fit.ratio:.3g} per degree of freedom"
            if fit.chance >= LEVEL:
                size = "the surface rises and falls by more than surface_slope allows"
            yield f"The recording does not fit the set-up ({size}). {found}"
        yield from (f"  {one.spelled(self.setting.units)}" for one in causes)


def summary_of(periods: Periods, setting: Setting) -> FrictionSummary:
    """Summarise the friction of some periods."""
    slips = periods.status == PeriodStatus.SLIP
    used = slips & ~_left_out(periods, slips)
    others = periods.status[~slips].tolist() + periods.grade[slips & ~used].tolist()
    bounds = periods.low[np.isfinite(periods.low) & (periods.grade != Grade.WRONG)]
    coarse = [one.sentence for one in periods.checks if one.coarse and one.periods.any()]
    known = FrictionSummary(
        periods=len(periods),
        used=int(used.sum()),
        least=float(bounds.max()) if len(bounds) else np.nan,
        left={why: others.count(why) for why in sorted(set(others))},
        doubtful=int((periods.grade[used] == Grade.DOUBTFUL).sum()),
        wrong=int((periods.grade[used] == Grade.WRONG).sum()),
        setting=setting,
        coarse="".join(coarse),
    )
    return _with_mean(known, periods.take(used)) if used.any() else known


def _with_mean(known: FrictionSummary, some: Periods) -> FrictionSummary:
    """Add the mean of the used periods."""
    setting, whole, step = known.setting, some.deviation**2, some.by_step**2
    noise = np.maximum(whole - some.common**2 - step, 0.0)
    between, error = variance_between(some.mu0, _weighed(noise, some))
    same_step = np.maximum(step - max(0.0, between - 2.0 * error), 0.0)
    weights = _weights(_weighed(noise + between + same_step, some))
    by_slope, more = _by_slope(some, weights, setting)
    effect = weights @ some.effects
    by_setup = common_deviation(effect[None], setting.covariance)[0]
    common = np.sqrt(
        (weights @ np.sqrt(same_step)) ** 2 + by_setup**2 + (weights @ some.shared) ** 2
    )
    random = np.sqrt(weights**2 @ (noise + step - same_step) + more)
    whole_deviation = float(np.hypot(random, common))
    exact = if_exact(effect, setting, whole_deviation)
    if setting.slope.deviation > 0.0:
        exact[SLOPE] = float(np.sqrt(max(0.0, whole_deviation**2 - by_slope)))
    return replace(
        known,
        mean=float(weights @ some.mu0),
        random=float(random),
        common=float(common),
        variation=_variation(some.mu0, noise + step),
        if_exact=dict(sorted(exact.items(), key=lambda item: item[1])),
    )


def _by_slope(some: Periods, weights: FloatArray, setting: Setting) -> tuple[float, float]:
    """Variance of the mean by the slope of the surface, and what neighbours share of it."""
    error = setting.slope.errors(some.mu0)
    by_slope = setting.slope.variance_of_mean(weights, some.mu0, some.footpoint)
    return by_slope, by_slope - float(weights**2 @ error**2)


def if_exact(effect: FloatArray, setting: Setting, deviation: float) -> dict[str, float]:
    """Give the standard deviation that remains of a value if one tolerance were exact."""
    covariance, names = setting.covariance, [one.of for one in setting.tolerances]
    along, left = covariance @ effect, {}
    for name in dict.fromkeys(names):
        rows = np.flatnonzero([one == name for one in names])
        # Parts of which one is known by the others, or known, have no inverse.
        inverse = np.linalg.pinv(covariance[np.ix_(rows, rows)], hermitian=True)
        gained = float(along[rows] @ inverse @ along[rows])
        left[name] = float(np.sqrt(max(0.0, deviation**2 - gained)))
    return left


def _weighed(variance: FloatArray, some: Periods) -> FloatArray:
    """Variances by which periods are weighed: one without any error would have all the weight."""
    return np.maximum(variance, np.maximum(ROUNDING * some.deviation**2, LEAST))


def _weights(variance: FloatArray) -> FloatArray:
    """Weights of values with these variances, with the sum 1."""
    inverse = 1.0 / variance
    return np.asarray(inverse / inverse.sum())


def _variation(mu0: FloatArray, variance: FloatArray) -> float:
    """Estimate the variation from place to place; 0 where Cochran's test is not certain."""
    variance = np.maximum(variance, LEAST)
    squares = float(((mu0 - _weights(variance) @ mu0) ** 2 / variance).sum())
    if len(mu0) < 2 or chdtrc(len(mu0) - 1, squares) >= LEVEL:
        return 0.0
    return float(np.sqrt(variance_between(mu0, variance)[0]))


def _left_out(periods: Periods, slips: BoolArray) -> BoolArray:
    """Periods with the grade wrong; none if most periods with a friction have it."""
    wrong = periods.grade == Grade.WRONG
    most = wrong[slips].sum() > MOST_WRONG * slips.sum()
    return np.zeros(len(wrong), dtype=bool) if most else wrong


def _rounded(value: float, error: float) -> str:
    """Value to two digits of its error, which may be 0 or unknown."""
    digits = int(np.clip(1 - np.floor(np.log10(np.fmax(error, 1e-9))), 0, 9))
    return f"{value:.{digits}f}"
