"""Periods of sticking with their friction, and reasons to doubt it: the result of both methods."""

from collections import Counter
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import cached_property

import numpy as np

from vibrissa.numerics.arrays import BoolArray, FloatArray, IntArray, StrArray
from vibrissa.numerics.batch import Batch
from vibrissa.sensor.identification.propagation import HALF_WIDTH, half_width, step_deviation
from vibrissa.sensor.identification.recording import FORCES
from vibrissa.sensor.identification.slips import LOST_STEP, Spans, usual_step
from vibrissa.sensor.identification.slope import Slope
from vibrissa.sensor.identification.task import Task
from vibrissa.wording import counted

# Least number of samples of a period that is not doubted.
FEW_SAMPLES = 4
# Weights of the mean over a step, by its beginning, middle and end.
SIMPSON = np.array([1.0, 4.0, 1.0]) / 6.0
# Number of periods whose lines a note lists.
LISTED_PERIODS = 3


class Grade(StrEnum):
    """Severity of a doubt, ascending.

    Attributes
    ----------
    DOUBTFUL
        The friction may be wrong: look at the readings.
    WRONG
        The readings contradict the friction: do not use it.
    """

    DOUBTFUL = "doubtful"
    WRONG = "wrong"


@dataclass(frozen=True, eq=False)
class Check:
    """A reason to doubt the friction of some periods.

    Attributes
    ----------
    periods : ndarray of bool, shape (p,)
        Whether the reason applies to each period.
    sentence : str
        The reason.
    summed : bool
        Whether the summary states the reason; the notes then leave it out.
    coarse : bool
        Whether the samples are too coarse; the summary then ends with this reason.
    """

    grade: Grade
    periods: BoolArray
    sentence: str
    summed: bool = False
    coarse: bool = False


class PeriodStatus(StrEnum):
    """Outcome of a period.

    Attributes
    ----------
    SLIP
        The period ended with a slip: μ0 is known.
    OPEN
        The end of the period was not recorded: `low` is a lower bound of μ0.
    LOCK
        The tip stuck past the lock: μ0 exceeds `low`, which is at most μ_lock. Either the tip did
        not slip, or the rod buckled laterally; rows after the buckling are not used.
    UNSURE
        There are too few samples, or too small a normal force, for the ratio of the forces: only
        `low` is known.
    BEYOND
        The period seems to end where the tip cannot slip, or it is so long that it must contain
        slips, hidden by noise. μ0 is not known.
    """

    SLIP = "slip"
    OPEN = "open"
    LOCK = "lock"
    UNSURE = "unsure"
    BEYOND = "beyond"


@dataclass(frozen=True, eq=False, kw_only=True)
class Periods(Batch):
    """Periods of sticking of a recording; arrays have the shape (p,) unless stated.

    Attributes
    ----------
    status : ndarray of str
        One `PeriodStatus` for each period.
    first, last : ndarray of int
        Rows of the recording in which the period begins and ends.
    first_line, last_line : ndarray of int
        Line numbers of these rows in the file.
    contact : ndarray
        Position of the tip (L); NaN without a rod.
    footpoint : ndarray
        Position of the clamp in the last sample (L).
    start : ndarray
        Mobilised friction in the first sample; NaN if a force was not recorded.
    mu0, deviation, low, high : ndarray
        Static friction at the contact point, its standard deviation, and the ends of its 95 %
        interval. If only `low` is known, the others are NaN.
    common : ndarray
        Standard deviation of μ0 due to errors that all periods share, such as those of the set-up.
    by_step : ndarray
        Standard deviation of μ0 due to the step of the stage.
    effects : ndarray, shape (p, k)
        Change of μ0 per unit of error, for each of k errors that all periods share.
    checks : tuple of Check
        Reasons to doubt the friction of some periods.
    left_out : tuple of str
        Notes, such as which rows were left out, and why.
    """

    status: StrArray
    first: IntArray
    last: IntArray
    first_line: IntArray
    last_line: IntArray
    contact: FloatArray
    footpoint: FloatArray
    start: FloatArray
    mu0: FloatArray
    deviation: FloatArray
    low: FloatArray
    high: FloatArray
    common: FloatArray
    by_step: FloatArray
    effects: FloatArray
    checks: tuple[Check, ...] = ()
    left_out: tuple[str, ...] = ()

    @property
    def by_noise(self) -> FloatArray:
        """Standard deviation of μ0 due to errors other than `common` and `by_step`, shape (p,)."""
        square = self.deviation**2 - self.common**2 - self.by_step**2
        return np.asarray(np.sqrt(np.maximum(square, 0.0)))

    @property
    def notes(self) -> tuple[str, ...]:
        """Omitted rows and doubts, each with its reason."""
        return (*self.left_out, *self.doubts)

    @property
    def doubts(self) -> tuple[str, ...]:
        """Reasons to doubt periods, with lines, except those that the summary states."""
        stated = [check for check in self.checks if check.periods.any() and not check.summed]
        return tuple(f"{check.grade}: {check.sentence}{self._where(check)}" for check in stated)

    @property
    def coarse(self) -> list[str]:
        """Reasons why the samples are too coarse; empty if they are not."""
        return [check.sentence for check in self.checks if check.coarse and check.periods.any()]

    def _where(self, check: Check) -> str:
        """Lines of the first periods that a check concerns; empty if it concerns all."""
        if check.periods.all():
            return ""
        doubted = self.take(check.periods)
        lines = zip(
            doubted.first_line[:LISTED_PERIODS], doubted.last_line[:LISTED_PERIODS], strict=True
        )
        more = ", ..." if len(doubted) > LISTED_PERIODS else ""
        shown = ", ".join(f"{first}-{last}" for first, last in lines)
        return f": {len(doubted)} of {len(self)} periods, line {shown}{more}"

    def __repr__(self) -> str:
        """Numbers of periods by status."""
        each = ", ".join(f"{n} {status}" for status, n in Counter(self.status.tolist()).items())
        return f"{counted(len(self), 'period')}: {each}"

    @cached_property
    def grade(self) -> StrArray:
        """`Grade` of the worst doubt of each period; empty where there is no doubt."""
        grades = np.full(len(self), "", dtype=f"U{max(map(len, Grade))}")
        for check in sorted(self.checks, key=lambda check: list(Grade).index(check.grade)):
            grades[check.periods] = check.grade
        return grades

    @cached_property
    def doubt(self) -> StrArray:
        """Doubts of each period in words, separated by semicolons."""
        each = (
            (check.sentence for check in self.checks if check.periods[i]) for i in range(len(self))
        )
        return np.array(["; ".join(doubts) for doubts in each], dtype=str)

    def doubted(self, *checks: Check) -> "Periods":
        """Return a copy to which checks are added: reasons to doubt some periods."""
        return replace(self, checks=(*self.checks, *checks))

    def ended(self, status: StrArray, least: FloatArray) -> "Periods":
        """Return a copy with these statuses; periods without a slip have only a bound of μ0.

        Parameters
        ----------
        least : ndarray, shape (p,)
            The lower bounds.
        """
        slips = status == PeriodStatus.SLIP
        bound = np.where(status == PeriodStatus.BEYOND, np.nan, np.maximum(least, 0.0))
        return replace(
            self,
            status=status,
            mu0=np.where(slips, self.mu0, np.nan),
            deviation=np.where(slips, self.deviation, np.nan),
            low=np.where(slips, self.low, bound),
            high=np.where(slips, self.high, np.nan),
            common=np.where(slips, self.common, 0.0),
            by_step=np.where(slips, self.by_step, np.nan),
            effects=np.where(slips[:, None], self.effects, 0.0),
        )

    def on_slope(self, slope: Slope) -> "Periods":
        """Return a copy in which the error of μ0 includes the tolerance of the surface's slope."""
        if not slope.deviation > 0.0:
            return self
        # If only the lower bound is known, the error is taken for this friction.
        middle = np.where(np.isnan(self.mu0), self.low, self.mu0)
        error = slope.errors(middle)
        return replace(
            self,
            deviation=np.hypot(self.deviation, error),
            low=np.maximum(middle - np.hypot(middle - self.low, HALF_WIDTH * error), 0.0),
            high=middle + np.hypot(self.high - middle, HALF_WIDTH * error),
        )


def periods_of(
    task: Task, along: FloatArray, own: FloatArray, common: FloatArray, effects: FloatArray
) -> Periods:
    """Make periods that all end with a slip, and grade those with few or lost samples.

    Parameters
    ----------
    along : ndarray, shape (p, 3)
        Friction at the beginning, in the middle and at the end of the step in which the tip slips.
    own, common : ndarray, shape (p,)
        Standard deviations of the friction, due to errors that are independent in each period and
        due to errors that all periods share.
    effects : ndarray, shape (p, k)
        Change of μ0 per unit of error, for each of k errors that all periods share.
    """
    recording = task.recording
    spans = task.spans
    growth = np.abs(along[:, 2] - along[:, 0])
    by_step = step_deviation(growth, 1.0)
    normal = np.hypot(own, common)
    mu0 = along @ SIMPSON
    width = half_width(0.5 * growth, normal)
    fx, fy = recording.readings[spans.begins][:, FORCES].T
    return Periods(
        status=np.full(len(spans), PeriodStatus.SLIP),
        first=task.row[spans.begins],
        last=task.row[spans.ends],
        first_line=recording.line[spans.begins],
        last_line=recording.line[spans.ends],
        contact=np.full(len(spans), np.nan),
        footpoint=recording.clamp[spans.ends],
        start=task.ends.sign * np.divide(fx, fy, out=np.full(len(fx), np.nan), where=fy != 0.0),
        mu0=mu0,
        deviation=np.hypot(by_step, normal),
        low=np.maximum(mu0 - width, 0.0),
        high=mu0 + width,
        common=common,
        by_step=by_step,
        effects=effects,
        checks=tuple(_checks_of(recording.smooth, spans)),
        left_out=recording.notes,
    )


def _checks_of(clamp: FloatArray, spans: Spans) -> list[Check]:
    """Check the clamp's path and the number of samples."""
    ends = spans.ends
    usual = usual_step(clamp)
    gap = clamp[spans.after] - clamp[ends]
    lost = spans.cut | (np.abs(gap) > LOST_STEP * usual)
    came = clamp[ends] - clamp[np.maximum(ends - FEW_SAMPLES, spans.begins)]
    went = clamp[np.minimum(spans.after + FEW_SAMPLES, len(clamp) - 1)] - clamp[spans.after]
    turned = came * np.where(went == 0.0, gap, went) < 0.0
    few = spans.counts < FEW_SAMPLES
    coarse = bool(np.median(spans.counts) < 2 * FEW_SAMPLES)
    # A period of few samples may be a spike; the period before then went on. The last period of a
    # recording may be short for another reason.
    before = np.append(few[1:-1], [False, False])[: len(few)]
    finer = f"fewer than {FEW_SAMPLES} samples in a period: sample more finely"
    jumped = "samples are missing at a period's end, or the clamp jumped or turned (measure again)"
    spike = "too few samples: a spike, or the clamp rests (cut that off by import --from, --to)"
    return [
        Check(Grade.DOUBTFUL, (lost | turned) & ~spans.passes, jumped),
        # Where most periods have few samples only a finer recording helps.
        Check(Grade.WRONG, few & coarse, finer, summed=True, coarse=True),
        Check(Grade.WRONG, few & (not coarse), spike),
        Check(Grade.DOUBTFUL, before & (not coarse), "too few samples in the next period"),
    ]
