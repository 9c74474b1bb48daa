"""An oblique stage: the clamp comes nearer to the surface, or leaves it, as it moves.

The stage moves at an angle δ to the surface. With the clamp at X on its way, the height is

    h(X) = η − X·sin δ,

and a tip at the position x_c has the displacement from the α = 0 state of that height

    x0(X) = X·cos δ + x1_init(h) − x_c.

A tip behind the clamp has the opposite x0(X) − x1_init, and mirrored states, as on a level stage.
A state depends on height and x0 alone, not on how they were reached. So the response at all heights
that the stage passes serves every period of sticking, and a slip, during which the stage rests, is
that of a level stage at the present height.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import cached_property, partial
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq, minimize_scalar

from vibrissa.numerics.arrays import BoolArray, FloatArray, IntArray
from vibrissa.numerics.steps import passes
from vibrissa.sensor.quantities import chosen
from vibrissa.sensor.response.branch import Branch
from vibrissa.sensor.response.height_range import HeightRange, HeightStates
from vibrissa.sensor.simulation.scanning import Outcome, SurfaceScan, TipPhase, TipSide
from vibrissa.sensor.simulation.slips import SlipLaw, Slips
from vibrissa.sensor.surfaces import Surface

# Clamp positions at which a period is looked at, before its end is sought between two of them.
LOOKS = 257
# Heights that are nearer to each other than this have one guide (L).
GUIDE = 5e-4


@dataclass(frozen=True, eq=False, kw_only=True)
class ObliqueStage:
    """A rod on a stage that moves at an angle to the surface.

    Attributes
    ----------
    heights : HeightRange
        The rod at all heights that the stage passes.
    eta : float
        Height with the clamp at 0 (L).
    angle : float
        δ (rad), positive where the clamp approaches the surface.
    """

    heights: HeightRange
    eta: float
    angle: float

    @cached_property
    def x1_init(self) -> float:
        """Contact point in the α = 0 state, with the clamp at 0 (L)."""
        return float(self.heights.states(np.array(self.eta)).x1_init)

    def height(self, clamp: ArrayLike) -> FloatArray:
        """Height of the surface above the clamp (L)."""
        return np.asarray(self.eta - np.asarray(clamp) * np.sin(self.angle))

    def above(self, clamp: FloatArray) -> tuple[HeightStates, FloatArray]:
        """States at clamp positions, and the places from which displacements count (L).

        As `Branch.above`; the place of a contact is where it is, from `x1_init`.
        """
        states = self.heights.states(self.height(clamp))
        return states, self.along(clamp) + states.x1_init - self.x1_init

    @property
    def swings(self) -> bool:
        """Whether a tip that locks is dragged in the end; see `Branch`."""
        return self.heights.swings

    @property
    def level(self) -> Branch:
        """Branch with the clamp at 0."""
        return self.heights.at(self.eta)

    def guides(self, clamp: FloatArray) -> Iterator[tuple[Branch, IntArray]]:
        """Branches that are near to the states at clamp positions, each with their numbers."""
        low, high = self.heights.low, self.heights.high
        number = np.floor((np.clip(self.height(clamp), low, high) - low) / GUIDE).astype(np.int64)
        for one in np.unique(number):
            middle = low + (float(one) + 0.5) * GUIDE
            yield self.heights.at(min(middle, high)), np.flatnonzero(number == one)

    def covers(self, clamp: FloatArray) -> BoolArray:
        """Whether the height at clamp positions is known."""
        height = self.height(clamp)
        return ~(passes(height, self.heights.high) | passes(-height, -self.heights.low))

    def along(self, clamp: ArrayLike) -> FloatArray:
        """Position along the surface (L)."""
        return np.asarray(np.asarray(clamp) * np.cos(self.angle))

    def states(
        self, clamp: ArrayLike, contact: FloatArray | float, side: IntArray | int
    ) -> tuple[HeightStates, FloatArray]:
        """States that a tip at a place has at clamp positions, and its displacements (L).

        Behind the clamp, where the side is −1, displacements are those of the mirror image.
        """
        states = self.heights.states(self.height(clamp))
        return states, np.asarray(states.x1_init + side * (self.along(clamp) - contact))


@dataclass(frozen=True, kw_only=True)
class _Start:
    """How sticking begins: at the step `begin`, of a tip at `contact` on one side of the clamp.

    Without a slip the tip goes on sticking, with the friction `mu0`, since the clamp was at `clamp`
    (L): before the step.
    """

    begin: int
    clamp: float
    contact: float
    side: int
    mu0: float
    slipped: bool = True


class _Exit(StrEnum):
    """How the tip leaves the states in which it sticks: as the one that holds it gives way."""

    FORWARD = "forward"
    BACKWARD = "backward"
    END = "end"
    PULL = "pull"


@dataclass(frozen=True, kw_only=True)
class _Part:
    """Sticking on one side of the clamp, from its first step to before the step `end`.

    It ends with the clamp at `until` (L); NaN at the end of the path.
    """

    start: _Start
    end: int
    until: float
    exit: _Exit | None
    past_lock: bool


def simulate_oblique(
    stage: ObliqueStage,
    surface: Surface,
    positions: FloatArray,
    law: SlipLaw | str = SlipLaw.FREE,
    kinetic_ratio: float = 0.8,
    progress: Callable[[int], None] = lambda done: None,
) -> SurfaceScan:
    """Move the clamp of an oblique stage over a surface.

    Parameters
    ----------
    stage : ObliqueStage
    surface : Surface
    positions : ndarray
        Clamp positions along the stage (L), as from `path`.
    law, kinetic_ratio
        As in `vibrissa.sensor.scan`.
    progress : callable
        Told after each period how many steps are done.

    Returns
    -------
    SurfaceScan
        Up to where the height is not known any more.

    Raises
    ------
    ArgumentError
        If an argument is out of range, or the tip comes to where the surface is not known.
    """
    positions, law = np.asarray(positions, dtype=float), chosen(SlipLaw, law, "law")
    slips = partial(Slips, surface=surface, law=law, ratio=kinetic_ratio)
    slips(response=stage.heights.at(stage.eta))  # refuses an impossible ratio
    known, outcome, end = _known(stage, positions, surface.told)
    parts: list[_Part] = []
    start = _Start(
        begin=0,
        clamp=float(positions[0]),
        contact=stage.x1_init,
        side=1,
        mu0=float(surface(stage.x1_init)),
    )
    while True:
        part = _part(stage, positions[:known], start)
        parts.append(part)
        progress(part.end)
        if part.exit is None:
            break
        clamp = float(positions[part.end])
        if part.past_lock and part.exit is not _Exit.FORWARD:
            if not (part.exit is _Exit.END and stage.heights.swings):
                outcome = Outcome.LOCK
                end = _locked(part, float(positions[part.end - 1]), surface.told)
                break
            start = replace(
                start,
                begin=part.end,
                clamp=part.until,
                contact=_swung(stage, part),
                side=-start.side,
                slipped=False,
            )
            continue
        branch = stage.heights.at(float(stage.height(clamp)))
        _, x0 = stage.states(clamp, start.contact, start.side)
        along = float(stage.along(clamp))
        rest = slips(response=branch).rest(along, float(x0), start.side)
        if np.isnan(rest):
            outcome, end = Outcome.LOST, _lost(part, clamp, surface.told)
            break
        contact = branch.contact(along, rest, start.side)
        start = _Start(
            begin=part.end,
            clamp=clamp,
            contact=contact,
            side=start.side,
            mu0=float(surface(contact)),
        )
    said = (_swings(parts, positions, surface.told), end)
    return _assembled(stage, positions, parts, outcome, "; ".join(filter(None, said)))


def _known(
    stage: ObliqueStage, positions: FloatArray, told: Callable[[float], str]
) -> tuple[int, Outcome, str]:
    """Count the steps at which the height is known, and say why the next one is not."""
    height = stage.height(positions)
    for out, outcome, reason in (
        (passes(-height, -stage.heights.low), Outcome.NEAR, stage.heights.below),
        (passes(height, stage.heights.high), Outcome.AWAY, stage.heights.above),
    ):
        if out.any():
            first = int(np.argmax(out))
            message = (
                f"the stage takes the clamp at {told(float(positions[first]))} to the height "
                f"{told(float(height[first]))}: {reason}"
            )
            return first, outcome, message
    return len(positions), Outcome.COMPLETE, ""


def _swung(stage: ObliqueStage, part: _Part) -> float:
    """Find where the tip is when the rod has swung aside (L).

    It is where it was, unless the rod lies on the surface: then its tail turns about the contact
    point.
    """
    states, x0 = stage.states(part.until, part.start.contact, part.start.side)
    return float(stage.along(part.until) + part.start.side * (x0 - states.x1_init))


def _swings(parts: Sequence[_Part], positions: FloatArray, told: Callable[[float], str]) -> str:
    """Say where the rod swings aside first; empty if it does not."""
    for part, after in pairwise(parts):
        start = part.start
        if not after.start.slipped:
            return (
                f"the tip locks at x = {told(start.contact)}, where mu0 = {start.mu0:.6g}; with "
                f"the clamp at {told(float(positions[part.end]))} the rod swings aside, and its "
                "tip is dragged behind"
            )
    return ""


def _locked(part: _Part, clamp: float, told: Callable[[float], str]) -> str:
    return (
        f"the tip locks at x = {told(part.start.contact)}, where mu0 = {part.start.mu0:.6g}; "
        f"pushed on, it cannot stick beyond the clamp at {told(clamp)}"
    )


def _lost(part: _Part, clamp: float, told: Callable[[float], str]) -> str:
    return (
        f"the slip from x = {told(part.start.contact)}, with the clamp at {told(clamp)}, has so "
        "much energy that the tip leaves the states that are known"
    )


def _part(stage: ObliqueStage, positions: FloatArray, start: _Start) -> _Part:
    """Follow the tip until it leaves what it can stick to on this side."""
    tip = _Tip(stage=stage, contact=start.contact, mu0=start.mu0, side=start.side)
    clamp = positions[start.begin :]
    low = tip.limit(start.clamp, min(start.clamp, clamp.min()), -1.0)
    high = tip.limit(start.clamp, max(start.clamp, clamp.max()), 1.0)
    # A tip that has just slipped rests; one whose rod has swung aside may have to slip at once.
    first = int(start.slipped)
    out = first + np.flatnonzero((passes(clamp, high) | passes(-clamp, -low))[first:])
    if not len(out):
        return _Part(start=start, end=len(positions), until=np.nan, exit=None, past_lock=False)
    at = high if clamp[out[0]] > high else low
    states, x0 = stage.states(at, start.contact, start.side)
    return _Part(
        start=start,
        end=start.begin + int(out[0]),
        until=float(at),
        exit=list(_Exit)[int(np.argmin(tip.reserves(at)))],
        past_lock=bool(x0 > states.x0_lock),
    )


@dataclass(frozen=True, kw_only=True)
class _Tip:
    """A tip that sticks at one place.

    Attributes
    ----------
    stage : ObliqueStage
    contact, mu0 : float
        Where it is (L), and the friction there.
    side : int
        1 ahead of the clamp, −1 behind it.
    """

    stage: ObliqueStage
    contact: float
    mu0: float
    side: int

    def reserves(self, clamp: ArrayLike) -> FloatArray:
        """Tell what is left of what holds the tip at clamp positions, in the order of `_Exit`.

        Of the friction forward and backward, and of the way to both ends of the states (L);
        negative where the tip does not stick.
        """
        states, x0 = self.stage.states(clamp, self.contact, self.side)
        with np.errstate(divide="ignore"):
            demand = states.demand(states.clip(x0))
        return np.array(
            [self.mu0 - demand, self.mu0 + demand, states.x0_end - x0, x0 - states.x0_pull]
        )

    def _reserve(self, clamp: ArrayLike) -> FloatArray:
        return np.asarray(self.reserves(clamp).min(axis=0))

    def limit(self, begin: float, end: float, way: float) -> float:
        """Where sticking ends as the clamp goes to a position, one way; infinite if nowhere."""
        states, _ = self.stage.states(begin, self.contact, self.side)
        stretch = way * float(states.x0_end - states.x0_pull)
        while begin != end:
            until = begin + stretch if abs(stretch) < abs(end - begin) else end
            clamp, left = self._looked(np.linspace(begin, until, LOOKS))
            out = np.flatnonzero(left[1:] <= 0.0)
            if len(out):
                before, after = clamp[out[0]], clamp[out[0] + 1]
                # It may begin at the end of what it can stick to, up to rounding.
                if left[out[0]] <= 0.0:
                    return float(before)
                return float(brentq(self._reserve, before, after, xtol=1e-14))
            begin = until
        return way * np.inf

    def _looked(self, clamp: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Look at clamp positions and, between them, at minima that may be below zero."""
        left = self._reserve(clamp)
        inner = left[1:-1]
        falls = np.maximum(left[:-2] - inner, left[2:] - inner)
        lowest = (inner <= left[:-2]) & (inner <= left[2:]) & (inner < falls)
        for i in np.flatnonzero(lowest) + 1:
            bounds = sorted((clamp[i - 1], clamp[i + 1]))
            found = minimize_scalar(self._reserve, bounds=bounds, method="bounded")
            clamp, left = np.append(clamp, found.x), np.append(left, found.fun)
        order = np.argsort(np.abs(clamp - clamp[0]))
        return clamp[order], left[order]


def _assembled(
    stage: ObliqueStage,
    positions: FloatArray,
    parts: Sequence[_Part],
    outcome: Outcome,
    message: str,
) -> SurfaceScan:
    """Put the parts together, one row for each step."""
    starts = [part.start for part in parts]
    begins = np.array([start.begin for start in starts])
    slipped = np.array([start.slipped for start in starts])
    counts = np.array([part.end for part in parts]) - begins
    clamp = positions[: counts.sum()]
    contact = np.repeat([start.contact for start in starts], counts)
    side = np.repeat([start.side for start in starts], counts)
    states, x0 = stage.states(clamp, contact, side)
    # A rod that swings aside and slips within one step leaves a part without rows.
    later = (begins > 0) & (counts > 0)
    slip, swing = np.zeros((2, len(clamp)), dtype=bool)
    slip[begins[later & slipped]] = True
    swing[begins[later & ~slipped]] = True
    return SurfaceScan(
        outcome=outcome,
        message=message,
        clamp=clamp,
        contact=contact,
        x0=side * x0 + 0.0,  # no −0
        reactions=states(states.clip(x0)) * np.stack([side, np.ones(len(side)), side], axis=1),
        mu0=np.repeat([start.mu0 for start in starts], counts),
        period=np.repeat(np.cumsum(slipped), counts),
        phase=np.select(
            [slip, swing, x0 > states.x0_lock],
            [TipPhase.SLIP, TipPhase.SWING, TipPhase.LOCK],
            TipPhase.STICK,
        ),
        side=np.where(side == 1, TipSide.AHEAD, TipSide.BEHIND),
    )
