"""How friction is read from the last sticking state of each period: a class for each method."""

from dataclasses import dataclass, replace
from typing import ClassVar, Self

import numpy as np
from scipy.ndimage import find_objects, label

from vibrissa.errors import ArgumentError, RecordingError
from vibrissa.numerics.arrays import BoolArray, FloatArray
from vibrissa.sensor.identification.alternatives import Alternative
from vibrissa.sensor.identification.reading.energy import FEWEST, read_travels
from vibrissa.sensor.identification.reading.kinetic import ratio_after_slips
from vibrissa.sensor.identification.reading.spacing import spacing
from vibrissa.sensor.identification.reading.uncertainty import (
    MANY,
    LastStates,
    Summary,
    Values,
    friction_of,
    normal_summary,
    ratio_deviation,
)
from vibrissa.sensor.identification.recording import Method
from vibrissa.sensor.identification.seen import Seen
from vibrissa.sensor.quantities import chosen
from vibrissa.sensor.response.branch import Branch
from vibrissa.sensor.simulation.slips import SlipLaw

# Whether a tip slips while the stage moves: see `BySpacing.early`.
AT_REST, ON_THE_WAY, EITHER = (0.0, 0.0), (1.0, 1.0), (0.0, 1.0)


class ByMoment:
    """From the moment alone: the model of the rod says the rest.

    Attributes
    ----------
    from_slip : bool
        Whether a period needs the slip before it.
    """

    from_slip: ClassVar[bool] = False

    def friction(
        self, seen: Seen, common: FloatArray, values: Values = MANY
    ) -> tuple[Summary, BoolArray]:
        """Find the friction of every period, and for which of them only bounds are known.

        Parameters
        ----------
        seen : Seen
        common : ndarray, shape (p,)
            Standard deviation of the error that all periods share.
        values : Values
            By which its distribution is represented.
        """
        found = friction_of(seen.branch, self._last_states(seen), common, values=values)
        return found, np.zeros(len(found), dtype=bool)

    def as_if(self, other: Alternative) -> "ByMoment":
        """Give the method as if the law of slips were a little other."""
        return self

    def _last_states(self, seen: Seen) -> LastStates:
        return seen.last


class ByForces(ByMoment):
    """From the ratio of the forces, measured in the last state; the model says how it goes on."""

    def _last_states(self, seen: Seen) -> LastStates:
        fx, fy, _ = seen.samples.readings[seen.periods.ends].T
        return replace(
            seen.last,
            deviation=np.zeros(len(fx)),
            base=seen.last.base + fx / fy - seen.ending.demand(seen.ending.clip(seen.last.travel)),
            ratio_deviation=ratio_deviation(fx, fy, *seen.channels.noise),
        )


@dataclass(frozen=True, kw_only=True)
class BySpacing(ByMoment):
    """From the clamp's travel from slip to slip.

    Attributes
    ----------
    step : float
        Step of the stage (L).
    law : SlipLaw or None
        Where slips end, if that is known.
    kinetic_ratio : float or None
        μk/μ0, for the laws that need it; None where the states after slips are to tell it.
    more : float
        By how much the ratio is larger than they tell.
    early : tuple of float
        Whether the tip slips while the stage moves, 1, or at rest, 0: one or the other.
    """

    from_slip: ClassVar[bool] = True
    step: float
    law: SlipLaw | None
    kinetic_ratio: float | None
    more: float = 0.0
    early: tuple[float, float] = AT_REST

    @property
    def estimates_ratio(self) -> bool:
        """Whether the ratio of the frictions is to be told by the states after slips.

        By the law ``energy`` they do not: the friction on the whole way of a slip counts.
        """
        return self.kinetic_ratio is None and self.law is SlipLaw.KINETIC

    def as_if(self, other: Alternative) -> Self:
        """Give the method as if the ratio of the frictions were a little larger."""
        return replace(self, more=self.more + other.kinetic_ratio)

    def _ratio(self, seen: Seen) -> float | None:
        known = ratio_after_slips(seen).value if self.estimates_ratio else self.kinetic_ratio
        return None if known is None else known + self.more

    def friction(
        self, seen: Seen, common: FloatArray, values: Values = MANY
    ) -> tuple[Summary, BoolArray]:
        """Find the friction of every period, and for which of them only bounds are known.

        Raises
        ------
        ArgumentError
            If the stage is oblique.
        """
        branch, last = seen.branch, self._last_states(seen)
        if not isinstance(branch, Branch):
            raise ArgumentError(
                "the method spacing needs a stage along the surface, with stage_angle 0: use the "
                "method forces or moment"
            )
        before = np.append(0.0, last.sign[:-1])
        ratio = self._ratio(seen)
        relation = spacing(branch, self.law, ratio)
        found = friction_of(
            branch,
            last,
            common,
            self.step,
            lambda travel, part: relation.onset(travel, before[part], last.sign[part]),
            values,
        )
        unsure = relation.gives_bounds(before, last.sign)
        if self.law is SlipLaw.ENERGY and ratio is not None:
            for run in self._runs(last):
                travel, gap, place = last.travel[run], last.gap[run], seen.contacts.place[run]
                mean, own = read_travels(branch, ratio, travel, gap, place)
                # What came before the first of them is not known.
                mean[0] = np.nan
                known = ~np.isnan(mean)
                rows = np.arange(run.start, run.stop)[known]
                deviation = np.hypot(own[known], common[rows])
                found.put(rows, normal_summary(branch, mean[known], deviation))
                unsure[rows] = False
        return found, unsure

    def _last_states(self, seen: Seen) -> LastStates:
        last, none = seen.last, np.zeros(len(seen.periods))
        # What lags does so at both slips alike.
        begin = np.append(seen.samples.clamp[0], (last.clamp + last.clamp_gap)[:-1])
        return replace(
            last,
            travel=last.clamp - begin,
            deviation=none,
            gap_before=np.append(0.0, last.gap[:-1]),
            early_low=none + self.early[0],
            early_high=none + self.early[1],
            early_mean=none + (0.5 if self.estimates_ratio else 0.0),
            lag_low=none,
            lag_high=none,
        )

    def _runs(self, last: LastStates) -> list[slice]:
        """Periods in a row that end by slips forward in single steps, enough to read together."""
        single = (last.gap > 0.5 * self.step) & (last.gap < 1.5 * self.step)
        runs = [run for (run,) in find_objects(label((last.sign > 0.0) & single)[0])]
        return [run for run in runs if run.stop - run.start >= FEWEST]


def reader_of(
    method: Method,
    clamp: FloatArray,
    step: float | None,
    law: SlipLaw | str | None,
    kinetic_ratio: float | None,
) -> ByMoment:
    """Set up a method; without a step it is the usual distance of successive clamp positions.

    Raises
    ------
    ArgumentError
        If the step is not positive or the law is none.
    RecordingError
        If the step is not known, as the clamp never moves.
    """
    if method is Method.RATIO:
        raise ArgumentError("the method ratio uses no rod: read_ratio reads by it")
    if method is Method.MOMENT:
        return ByMoment()
    if method is Method.FORCES:
        return ByForces()
    law = None if law is None else chosen(SlipLaw, law, "law")
    if step is None:
        moved = np.abs(np.diff(clamp))
        if not moved.any():
            raise RecordingError("the clamp never moves: column footpoint has one value")
        step = float(np.median(moved[moved > 0.0]))
    if not step > 0.0:
        raise ArgumentError(f"step must be positive, got {step!r}")
    return BySpacing(step=step, law=law, kinetic_ratio=kinetic_ratio)
