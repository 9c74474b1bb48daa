"""A scan: the clamp moves in steps over a surface, and the tip sticks and slips.

At the first step at which |tan(α − γ)| > μ0, for the inclination γ of the surface, the tip slips
while the clamp rests. `simulate` goes from period to period: it finds the end of each period
directly, not step by step. A self-locking tip sticks until the rod, if it is round, buckles
laterally. After that the clamp drags the tip: the states of the rod are mirror images of states in
which the tip is ahead of the clamp.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from vibrissa.errors import ArgumentError, EndedScanError
from vibrissa.numerics.arrays import FloatArray
from vibrissa.scanning import messages
from vibrissa.scanning.periods import EndsBy, PeriodEnd
from vibrissa.scanning.response import Response
from vibrissa.scanning.scan import Outcome, Scan, TipPhase, TipSide
from vibrissa.scanning.slide import Lost
from vibrissa.scanning.slip import Flight, Slip, SlipEnd
from vibrissa.scanning.slip_model import FREE_SLIP, SlipModel
from vibrissa.scanning.stage import Stage
from vibrissa.scanning.surfaces import Surface
from vibrissa.scanning.tip import ClampPath, EndOfSticking, Margin, Tip


def simulate(
    stage: Response | Stage,
    surface: Surface,
    positions: FloatArray,
    model: SlipModel = FREE_SLIP,
    slips: int | None = None,
) -> Scan:
    """Simulate a scan: find the state of the rod at each step of the clamp over a surface.

    Parameters
    ----------
    stage : Response or Stage
        The rod on its stage; a `Response` is on a level stage.
    surface : Surface
    positions : ndarray
        Clamp positions along the stage (L), as from `path`; the scan begins in the α = 0 state.
    model : SlipModel
        Where a slip ends.
    slips : int, optional
        Number of slips after which the scan ends.

    Returns
    -------
    Scan
        A row for each step, up to the end of the path or of the computed motion.

    Raises
    ------
    ArgumentError
        If the tip leaves the known part of the surface, or if the path or the law may need states
        with x0 < 0 (the clamp pulled back) that were not solved.
    EndedScanError
        If this happens after the scan has begun; the error has the scan up to there.
    """
    positions = np.asarray(positions, dtype=float)
    if isinstance(stage, Response):
        stage = Stage(response=stage, eta=stage.curve.eta)
    _check_states(stage, surface, positions, model)
    course = _Course(
        stage=stage, surface=surface, model=model, clamp_path=ClampPath.through(positions)
    )
    start = course.start()
    tip, end = start.tip, start.end
    if tip is None:
        return Scan.without_rows(end.outcome, end.message)
    tips = [tip]
    periods: list[PeriodEnd] = []
    flights = list(start.flights)
    buckling = ""
    # Each period but the last one ends with a slip, after which the tip sticks at another place.
    while tip is not None and (slips is None or len(periods) < slips):
        following = course.after(tip)
        if following.period is not None:
            periods.append(following.period)
        if following.tip is not None:
            tips.append(following.tip)
        flights += following.flights
        buckling = buckling or following.buckling
        end, tip = following.end, following.tip
    # After the last of `slips` slips the scan has one more row.
    steps = periods[-1].stop if tip is None else tip.begin + 1
    texts = (buckling, messages.of_flights(flights, surface), end.message)
    message = "; ".join(filter(None, texts))
    scan = _assembled(tips, tuple(periods), positions[:steps], end.outcome, message)
    if end.error is not None:
        raise EndedScanError(str(end.error), scan)
    return scan


def _check_states(stage: Stage, surface: Surface, positions: FloatArray, model: SlipModel) -> None:
    """Refuse a scan that may need states of the rod that were not solved."""
    if surface.texture is not None and isinstance(stage.response, Response):
        raise ArgumentError(
            "on a surface with heights the rod must be solved over a range of distances: make its "
            "stage by stage_of(rod, positions, texture=...)"
        )
    retracts = model.law.overshoots or stage.angle < 0.0 or (np.diff(positions) < 0.0).any()
    if (retracts or surface.texture is not None) and stage.at(positions[0]).x0_pull == 0.0:
        raise ArgumentError(
            "states in which the clamp is pulled back (x0 < 0) could not be solved. The laws "
            "'energy' and 'damped' need them, and so does a path backward or away from the "
            "surface, and a surface with heights: choose another path or law"
        )


class _End(NamedTuple):
    """How a scan ends, and why; the error is one that ended it after it had begun."""

    outcome: Outcome
    message: str = ""
    error: ArgumentError | None = None

    @classmethod
    def off_surface(cls, error: ArgumentError) -> "_End":
        """End of a scan whose tip leaves the known part of the surface."""
        return cls(outcome=Outcome.OUT_OF_REACH, message=str(error), error=error)


class _Following(NamedTuple):
    """What follows at the start of a scan, and where a tip no longer sticks.

    Attributes
    ----------
    tip : Tip or None
        The tip at the place where it sticks next; None if the scan ends.
    period : PeriodEnd or None
        The period of sticking that ends; None if it goes on after lateral buckling.
    end : _End
        How the scan ends, if it does.
    flights : tuple of Flight
        Flights of the tip in its slip.
    buckling : str
        Message where the rod buckles laterally; empty if it does not.
    """

    tip: Tip | None = None
    period: PeriodEnd | None = None
    end: _End = _End(outcome=Outcome.COMPLETE)
    flights: tuple[Flight, ...] = ()
    buckling: str = ""


@dataclass(frozen=True, eq=False, kw_only=True)
class _Course:
    """The inputs of a scan: they determine where the tip sticks, one place after the other."""

    stage: Stage
    surface: Surface
    model: SlipModel
    clamp_path: ClampPath

    def slip(self, clamp: float, side: int) -> Slip:
        """Return a slip with the clamp at a position (L)."""
        return Slip(
            stage=self.stage, surface=self.surface, model=self.model, clamp=clamp, side=side
        )

    def start(self) -> _Following:
        """Find where the tip sticks at the first position of the clamp: on a plane, at α = 0."""
        clamp = float(self.clamp_path.positions[0])
        contact = self.stage.at(clamp).contact(float(self.stage.along(clamp)), 0.0, 1)
        # At first no tangential force acts, as after a slip that ends where no friction is needed.
        slip = replace(self, model=FREE_SLIP).slip(clamp, 1).follow(contact)
        if slip.lost is not None:
            return _Following(end=self.lost(slip, contact, clamp))
        footing = self.surface.footing(slip.contact, 1)
        tip = Tip(stage=self.stage, footing=footing, clamp=clamp, x0_rest=slip.x0)
        return _Following(tip=tip, flights=slip.flights)

    def after(self, tip: Tip) -> _Following:
        """Find where a tip no longer sticks, and what follows there."""
        sticking = tip.sticks_until(self.clamp_path)
        if sticking.stop == len(self.clamp_path):
            return _Following(period=_period(tip, sticking, EndsBy.PATH))
        leaving = tip.exit(sticking.until)
        if leaving.margin is Margin.END and self.stage.response.swings:
            return self._after_buckling(tip, sticking)
        if leaving.margin is Margin.ROOM:
            message = messages.of_height_out_of_reach(tip, sticking, self.surface)
            end = _End(outcome=Outcome.OUT_OF_REACH, message=message)
            return _Following(period=_period(tip, sticking, EndsBy.UNKNOWN), end=end)
        response = self.stage.response
        if leaving.margin is Margin.END and isinstance(response, Response) and not response.whole:
            end = _End(outcome=Outcome(response.curve.status), message=response.curve.message)
            return _Following(period=_period(tip, sticking, EndsBy.UNKNOWN), end=end)
        if leaving.margin is Margin.END or (leaving.locked and leaving.margin is Margin.BACKWARD):
            last = float(self.clamp_path.positions[sticking.stop - 1])
            message = messages.of_locked_tip(tip, sticking, last, self.surface)
            end = _End(outcome=Outcome.LOCK, message=message)
            return _Following(period=_period(tip, sticking, EndsBy.LOCK), end=end)
        # Friction is exceeded, or the clamp has pulled the rod to its last state.
        return self._after_slip(tip, sticking)

    def _after_buckling(self, tip: Tip, sticking: EndOfSticking) -> _Following:
        """Move the tip to its mirror image about the clamp; the period of sticking goes on.

        On a surface with heights, where the tip alone touches, it stays at its place.
        """
        clamp = float(self.clamp_path.positions[sticking.stop])
        buckling = messages.of_lateral_buckling(tip, sticking, clamp, self.surface)
        contact = tip.contact
        if self.surface.texture is None:
            contact = 2.0 * float(self.stage.along(sticking.until)) - tip.contact
        try:
            footing = self.surface.footing(contact, -tip.side)
        except ArgumentError as error:
            period = _period(tip, sticking, EndsBy.UNKNOWN)
            return _Following(period=period, end=_End.off_surface(error), buckling=buckling)
        swung = Tip(
            stage=self.stage,
            footing=footing,
            side=-tip.side,
            clamp=sticking.until,
            begin=sticking.stop,
            x0_rest=np.nan,
            slipped=False,
        )
        return _Following(tip=swung, buckling=buckling)

    def _after_slip(self, tip: Tip, sticking: EndOfSticking) -> _Following:
        """Let the tip slip, with the clamp at the first step at which it does not stick."""
        clamp = float(self.clamp_path.positions[sticking.stop])
        period = _period(tip, sticking, EndsBy.SLIP)._replace(clamp=clamp)
        try:
            slip = self.slip(clamp, tip.side).follow(tip.contact)
            footing = self.surface.footing(slip.contact, tip.side) if slip.lost is None else None
        except ArgumentError as error:
            period = period._replace(ends_by=EndsBy.UNKNOWN)
            return _Following(period=period, end=_End.off_surface(error))
        if footing is None:
            return _Following(
                period=period._replace(ends_by=EndsBy.LOST),
                end=self.lost(slip, tip.contact, clamp),
                flights=slip.flights,
            )
        rests = replace(
            tip,
            footing=footing,
            clamp=clamp,
            begin=sticking.stop,
            x0_rest=slip.x0,
            slipped=True,
        )
        period = period._replace(footing=footing, slip_end=slip)
        return _Following(tip=rests, period=period, flights=slip.flights)

    def lost(self, slip: SlipEnd, begin: float, clamp: float) -> _End:
        """Return the end of a scan whose slip from the position `begin` (L) is lost."""
        assert slip.lost is not None
        message = messages.of_lost_slip(slip.lost, begin, slip.contact, clamp, self.surface)
        outcome = Outcome.OUT_OF_REACH if slip.lost is Lost.DEEP else Outcome.LOST
        return _End(outcome=outcome, message=message)


def _period(tip: Tip, sticking: EndOfSticking, ends_by: EndsBy) -> PeriodEnd:
    """Return the period of sticking that ends with a tip at its place."""
    return PeriodEnd(tip=tip, stop=sticking.stop, until=sticking.until, ends_by=ends_by)


def _assembled(
    tips: Sequence[Tip],
    periods: tuple[PeriodEnd, ...],
    clamp: FloatArray,
    outcome: Outcome,
    message: str,
) -> Scan:
    """Assemble a scan, with one row for each step, from the places at which the tip stuck."""
    stage = tips[0].stage
    begins = np.array([tip.begin for tip in tips])
    slipped = np.array([tip.slipped for tip in tips])
    counts = np.diff(begins, append=len(clamp))

    def in_rows(values: list[float] | list[int]) -> FloatArray:
        return np.repeat(values, counts)

    contact = in_rows([tip.contact for tip in tips])
    side = np.repeat([tip.side for tip in tips], counts)
    height = in_rows([tip.footing.height for tip in tips])
    slope = in_rows([tip.footing.ahead.slope for tip in tips])
    states, x0 = stage.states(clamp, contact, side, height)
    # In the step of a slip x0 is known without the rounding of positions.
    x0_rest = np.full(len(clamp), np.nan)
    x0_rest[begins[counts > 0]] = np.array([tip.x0_rest for tip in tips])[counts > 0]
    x0 = np.where(np.isnan(x0_rest), x0, x0_rest)
    phase = np.where(x0 > states.x0_lock, TipPhase.LOCK, TipPhase.STICK)
    # If the rod buckles laterally and slips in the same step, the tip in between has no row.
    later = (begins > 0) & (counts > 0)
    phase[begins[later]] = np.where(slipped[later], TipPhase.SLIP, TipPhase.SWING)
    return Scan(
        outcome=outcome,
        message=message,
        stage=stage,
        clamp=clamp,
        contact=contact,
        x0=side * x0 + 0.0,  # no −0
        mu0=in_rows([tip.mu0 for tip in tips]),
        height=height,
        inclination=0.0 - side * np.arctan(slope),
        period=np.repeat(np.cumsum(slipped), counts),
        phase=phase,
        side=np.where(side == 1, TipSide.AHEAD, TipSide.BEHIND),
        ends=periods,
    )
