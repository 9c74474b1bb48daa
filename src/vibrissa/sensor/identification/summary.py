"""What a recording says about the friction of a surface, in a few numbers and lines.

The periods used have the frictions μ_i. Their errors are n_i by the readings, which are
independent, s_i by the step of the stage, and c_ik by one thing k that is not known of the setup,
which moves all periods together. The friction itself may vary from place to place.

The errors by the step are independent only where the onsets lie anywhere within their steps. On a
surface of constant friction all periods have the same length, and so the same error. The scatter
of the frictions tells: beyond the noise it is

    t² = max(0, v − mean of n_i²),   v = variance of μ_i,

by the surface and by the step. What it does not surely show of s_i is taken as shared by all
periods, s'_i² = max(0, s_i² − l²), where l is t with the lower end of the 95 % interval of v. With
the weights w_i = 1/(n_i² + t² + s'_i²), normalised,

    mean = Σ w_i·μ_i,   random² = Σ w_i²·(n_i² + s_i² − s'_i²),
    common² = (Σ w_i·s'_i)² + Σ_k (Σ_i w_i·c_ik)².

The slope of the surface is in n_i; what neighbours share of it is added to random².

This is the mean over the places where the tip slipped. How far it is from that of other places is
another question: places that are near to each other may be alike.

If a tolerance i were exact, its error would be known to be 0. That takes (C·e)_i²/C_ii off the
variance of the mean, where C is the covariance of what remains of the errors, and e the change of
the mean per unit of each; for several parts of i the same with blocks of C.

Whether the surface varies is told by Q = Σ (μ_i − μ̄)²/r_i² with r_i² = n_i² + s_i² and the mean μ̄
of weights 1/r_i²: if it does not, Q is at most χ² with one degree of freedom less than periods.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum

import numpy as np

from vibrissa.numerics.arrays import BoolArray, FloatArray
from vibrissa.sensor.identification.friction import Periods, PeriodStatus
from vibrissa.sensor.identification.misfit.beside import Beside
from vibrissa.sensor.identification.misfit.doubts import Grade
from vibrissa.sensor.identification.misfit.goodness import LEVEL, Goodness
from vibrissa.sensor.identification.reading.slope import NAME as SLOPE
from vibrissa.sensor.identification.reading.slope import slope_errors, variance_of_mean
from vibrissa.sensor.identification.reading.uncertainty import COVERAGE
from vibrissa.wording import counted

# Where more than this part of the frictions is graded wrong, none is left out: the rod is another
# one, and the mean is given with a warning.
MOST_WRONG = 0.5
# What leaves more of the standard deviation if it were exact is not to be measured first.
HELPS = 0.95
# So many causes of a misfit are named, of those that explain this part of it.
NAMED, EXPLAINS = 3, 0.1
# Part of a variance that rounding leaves of a difference, and a variance that is none.
ROUNDING, LEAST = 1e-12, 1e-200


class Source(StrEnum):
    """Where the uncertainty of one period comes from."""

    STEP = "the step of the stage"
    READINGS = "the noise of the readings and the slope of the surface"
    COMMON = "what is not known of the setup"


@dataclass(frozen=True, kw_only=True)
class FrictionSummary:
    """Friction of a recording; prints as a few lines.

    Attributes
    ----------
    mean : float
        Weighted mean of μ0 over the places where the tip slipped; NaN if nowhere.
    random : float
        Its standard deviation by errors that differ from period to period.
    common : float
        Its standard deviation by what all periods share. It does not average out.
    alike : tuple of str
        What that is, the largest part first.
    if_exact : dict of str to float
        What `deviation` would be if one tolerance were exact and the others as they are, the
        smallest first: what to measure first.
    variation : float
        Standard deviation of μ0 from place to place, beyond its errors.
    chi2, chance : float
        Q, and the probability of such a value or a larger one if the surface does not vary.
    degrees : int
        Degrees of freedom of Q.
    single : float
        Standard deviation of μ0 of one period, in the weighted quadratic mean.
    sources : dict of Source to float
        Parts of its square, the largest first.
    periods, used : int
        How many there are, and how many the mean is of.
    left : dict of str to int
        Why the others are left out: their status, or the grade of their doubts.
    least : float
        Largest lower bound of μ0 in any period, but those graded wrong; NaN if there is none.
    doubtful, wrong : int
        How many of those used are graded so.
    goodness : Goodness or None
        Whether the recording as a whole fits what was given.
    causes : tuple of str
        What may be other than it was given, if it does not.
    beside : Beside or None
        The model of the rod beside the ratio of the forces.
    far : tuple of str
        With what alone it fits, and what may stand for that; empty where it fits what was given.
    """

    mean: float = np.nan
    random: float = np.nan
    common: float = np.nan
    alike: tuple[str, ...] = ()
    if_exact: dict[str, float] = field(default_factory=dict)
    variation: float = np.nan
    chi2: float = 0.0
    chance: float = 1.0
    degrees: int = 0
    single: float = np.nan
    sources: dict[Source, float] = field(default_factory=dict)
    periods: int = 0
    used: int = 0
    left: dict[str, int] = field(default_factory=dict)
    least: float = np.nan
    doubtful: int = 0
    wrong: int = 0
    goodness: Goodness | None = None
    causes: tuple[str, ...] = ()
    beside: Beside | None = None
    far: tuple[str, ...] = ()

    @property
    def deviation(self) -> float:
        """Standard deviation of the mean."""
        return float(np.hypot(self.random, self.common))

    @property
    def varies(self) -> bool:
        """Whether the friction of the surface varies by more than its errors."""
        return self.chance < LEVEL

    def __str__(self) -> str:
        """Say it in lines."""
        return "\n".join(self._lines())

    def _lines(self) -> Iterator[str]:
        yield from self._mean()
        yield from self._fit()
        if not self.used:
            return
        if self.wrong:
            yield f"do not rely on it: {self.wrong} of them are graded wrong, see the column doubt"
        elif self.doubtful:
            are = "is" if self.doubtful == 1 else "are"
            yield f"{self.doubtful} of them {are} in doubt: see the columns grade and doubt"
        if self.beside is not None and self.beside.compared:
            yield self._compared(self.beside)
        if self.degrees and self.varies:
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
        alike = f" ({', '.join(self.alike)})" if self.alike else ""
        yield f"± {self.random:.1g} is random, ± {self.common:.1g} the same in all periods{alike}"
        gains = {name: to for name, to in self.if_exact.items() if to < HELPS * self.deviation}
        first = [f"{name} (then ± {to:.2g})" for name, to in gains.items()][:NAMED]
        if first:
            yield f"measure first: {', '.join(first)}"

    def _fit(self) -> Iterator[str]:
        fit = self.goodness
        if fit is None or not fit.degrees > 0:
            return
        if fit.fits and self.far:
            yield f"The recording fits only with {self.far[0]}"
            yield from self.far[1:]
            return
        if fit.fits:
            return
        may = "What may be other, each if it alone is:"
        found = may if self.causes else "No single thing that is other explains it."
        size = f"chi2 is {fit.ratio:.3g} per degree of freedom"
        yield f"The recording does not fit what was given ({size}). {found}"
        for text in self.causes:
            yield f"  {text}"
        for name, part in fit.noisier.items():
            yield (
                f"{name} scatters {part:.2g} times as much as the noise that was given: give that, "
                "or none, and it is estimated"
            )
        if self.far:
            yield f"By the recording is {self.far[0]}"
            yield from self.far[1:]

    def _compared(self, beside: Beside) -> str:
        said = "they agree" if beside.agrees else "they disagree: one of them is wrong"
        of = f"the model of the rod and the ratio of the forces differ {beside.size}"
        return f"{of} in {counted(beside.number, 'period')}: {said}"


def summary_of(
    periods: Periods,
    unknowns: Sequence[str] = (),
    tolerances: Sequence[str] = (),
    covariance: FloatArray | None = None,
    slope: float = 0.0,
    slope_length: float = np.inf,
    causes: tuple[str, ...] = (),
    beside: Beside | None = None,
    far: tuple[str, ...] = (),
) -> FrictionSummary:
    """Summarise the friction of some periods.

    Parameters
    ----------
    periods : Periods
    unknowns : sequence of str
        What is not known exactly of the setup, beside the tolerances.
    tolerances : sequence of str, length k
        Of which tolerance each effect of the periods is.
    covariance : ndarray, shape (k, k), optional
        Of what remains of their errors.
    slope, slope_length : float
        Standard deviation of the slope of the surface (rad), and over which distance it is alike
        (L).
    causes : tuple of str
        What may be other than it was given, if the recording does not fit.
    beside : Beside, optional
    far : tuple of str
        With what alone the recording fits.

    Returns
    -------
    FrictionSummary

    Notes
    -----
    By the spacing with the law ``energy`` neighbours are read together. Their errors are
    correlated, which is not counted.
    """
    slips = periods.status == PeriodStatus.SLIP
    used = slips & ~_left_out(periods, slips)
    others = periods.status[~slips].tolist() + periods.grade[slips & ~used].tolist()
    bounds = periods.low[np.isfinite(periods.low) & (periods.grade != Grade.WRONG)]
    known = FrictionSummary(
        periods=len(periods),
        used=int(used.sum()),
        least=float(bounds.max()) if len(bounds) else np.nan,
        left={why: others.count(why) for why in sorted(set(others))},
        goodness=periods.goodness,
        causes=causes,
        beside=beside,
        far=far,
    )
    if not used.any():
        return known
    some = periods.take(used)
    error, weights = slope_errors(some.mu0, slope), _weights_of(some)
    by_slope = variance_of_mean(weights, error, some.footpoint, slope_length)
    # Neighbours have much of it in common.
    more = by_slope - float(weights**2 @ error**2)
    adjusted = covariance is not None and bool(tolerances)
    found = _with_mean(known, some, ("tolerances", *unknowns) if adjusted else unknowns)
    found = replace(found, random=float(np.sqrt(found.random**2 + more)))
    exact = {}
    if covariance is not None and tolerances:
        exact = if_exact(weights @ some.effects, covariance, tolerances, found.deviation)
    if slope > 0.0:
        exact[SLOPE] = float(np.sqrt(max(0.0, found.deviation**2 - by_slope)))
    return replace(found, if_exact=dict(sorted(exact.items(), key=lambda item: item[1])))


def if_exact(
    effect: FloatArray, covariance: FloatArray, names: Sequence[str], deviation: float
) -> dict[str, float]:
    """Give the standard deviation that remains of a value if one tolerance were exact.

    Parameters
    ----------
    effect : ndarray, shape (k,)
        Change of the value per unit of each of k errors.
    covariance : ndarray, shape (k, k)
        Of these.
    names : sequence of str, length k
        Of which tolerance each is.
    deviation : float
        Of the value, by these errors and by others.

    Returns
    -------
    dict of str to float
        For each tolerance, the smallest first.
    """
    along, left = covariance @ effect, {}
    for name in dict.fromkeys(names):
        rows = np.flatnonzero([one == name for one in names])
        # Parts of which one is known by the others, or known, have no inverse.
        inverse = np.linalg.pinv(covariance[np.ix_(rows, rows)], hermitian=True)
        gained = float(along[rows] @ inverse @ along[rows])
        left[name] = float(np.sqrt(max(0.0, deviation**2 - gained)))
    return dict(sorted(left.items(), key=lambda item: item[1]))


def _random_parts(some: Periods) -> tuple[FloatArray, FloatArray]:
    """Variances of the periods by the step and by noise: what is left beside what all share."""
    step, whole = some.by_step**2, some.deviation**2
    return step, np.maximum(whole - some.common**2 - step, 0.0)


def _weighed(variance: FloatArray, some: Periods) -> FloatArray:
    """Variances by which periods are weighed: one without any error would have all the weight."""
    return np.maximum(variance, np.maximum(ROUNDING * some.deviation**2, LEAST))


def _weights_of(some: Periods) -> FloatArray:
    """Weights of the periods in their mean."""
    step, noise = _random_parts(some)
    scattered, surely = _scatter(some.mu0, noise)
    return _weights(_weighed(noise + scattered + np.maximum(step - surely, 0.0), some))


def _with_mean(known: FrictionSummary, some: Periods, unknowns: Sequence[str]) -> FrictionSummary:
    """Add what the periods used say together."""
    step, noise = _random_parts(some)
    scattered, surely = _scatter(some.mu0, noise)
    same_step = np.sqrt(np.maximum(step - surely, 0.0))
    weights = _weights_of(some)
    by_step = float(weights @ same_step)
    by_setup = float(np.linalg.norm(weights @ some.shifts))
    parts = sorted([(by_step, (Source.STEP,)), (by_setup, tuple(unknowns))], reverse=True)
    random = _weighed(noise + step, some)
    chi2 = float(((some.mu0 - _weights(random) @ some.mu0) ** 2 / random).sum())
    degrees = len(some) - 1
    return replace(
        known,
        mean=float(weights @ some.mu0),
        random=float(np.sqrt(weights**2 @ (noise + step - same_step**2))),
        common=float(np.hypot(by_step, by_setup)),
        alike=tuple(name for part, names in parts if part > 0.0 for name in names),
        variation=float(np.sqrt(max(0.0, scattered - step.mean()))),
        chi2=chi2,
        chance=_chance(degrees, chi2),
        degrees=degrees,
        single=float(np.sqrt(weights @ some.deviation**2)),
        sources=_sources(some, weights),
        doubtful=int((some.grade == Grade.DOUBTFUL).sum()),
        wrong=int((some.grade == Grade.WRONG).sum()),
    )


def _left_out(periods: Periods, slips: BoolArray) -> BoolArray:
    """Tell which periods are graded wrong; none where most of those with a friction are."""
    wrong = periods.grade == Grade.WRONG
    most = wrong[slips].sum() > MOST_WRONG * slips.sum()
    return np.zeros(len(wrong), dtype=bool) if most else wrong


def _weights(variance: FloatArray) -> FloatArray:
    """Weights of values with these variances, with the sum 1."""
    inverse = 1.0 / variance
    return np.asarray(inverse / inverse.sum())


def _scatter(values: FloatArray, noise: FloatArray) -> tuple[float, float]:
    """Variance of values beyond that of their noise, and its lower bound, t² and l²."""
    from scipy.special import chdtri  # a third of a second to load

    if len(values) < 2:
        return 0.0, 0.0
    degrees, variance, known = len(values) - 1, float(values.var(ddof=1)), float(noise.mean())
    low = variance * degrees / float(chdtri(degrees, 0.5 * (1.0 - COVERAGE)))
    return max(0.0, variance - known), max(0.0, low - known)


def _chance(degrees: int, chi2: float) -> float:
    from scipy.special import chdtrc

    return float(chdtrc(degrees, chi2)) if degrees else 1.0


def _sources(some: Periods, weights: FloatArray) -> dict[Source, float]:
    """Parts of the mean square deviation of one period, the largest first."""
    squares = some.deviation**2, some.by_step**2, some.common**2
    whole, step, common = (float(weights @ square) for square in squares)
    parts = {
        Source.STEP: step,
        Source.READINGS: max(0.0, whole - step - common),
        Source.COMMON: common,
    }
    # Their sum: the deviation is that of finitely many values, and may be a little less.
    total = sum(parts.values())
    shown = {source: part / total for source, part in parts.items() if part > 0.0}
    return dict(sorted(shown.items(), key=lambda item: -item[1]))


def _rounded(value: float, error: float) -> str:
    """Value to two digits of its error, which may be 0 or unknown."""
    digits = int(np.clip(1 - np.floor(np.log10(np.fmax(error, 1e-9))), 0, 9))
    return f"{value:.{digits}f}"
