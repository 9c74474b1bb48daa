"""Evaluation of sticking curves: contact, states, onsets of slip, motion after the lock.

No result of one curve depends on other curves, not even by rounding.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from vibrissa.mechanics.equations import shape
from vibrissa.mechanics.shape import Shape
from vibrissa.numerics.arrays import BoolArray, FloatArray, IntArray
from vibrissa.numerics.roots import first_reached
from vibrissa.outcomes import Contact, End, Status
from vibrissa.sticking.piece import Pieces, StickingState
from vibrissa.sticking.shapes import RowStates

if TYPE_CHECKING:
    from vibrissa.sticking.curve import StickingCurve


@dataclass(frozen=True, eq=False, kw_only=True)
class CurveArray:
    """Sticking curves that are evaluated together.

    The methods take an array `index` of int, shape (m,): the curve to which each of m
    displacements x0 (L) or friction coefficients μ0 belongs.
    """

    curves: tuple["StickingCurve", ...]

    @cached_property
    def pieces(self) -> Pieces:
        """Pieces of all curves, one curve after the other; those of a curve in the order of x0."""
        return Pieces.concatenate([p for c in self.curves for p in (c.retraction, c.pieces)])

    @cached_property
    def stop(self) -> IntArray:
        """Index of each curve's last piece, plus 1."""
        return np.cumsum([len(curve.retraction) + len(curve.pieces) for curve in self.curves])

    @cached_property
    def begin(self) -> IntArray:
        """Index of each curve's first piece."""
        return np.append(0, self.stop[:-1])

    @cached_property
    def pushed(self) -> IntArray:
        """Index of each curve's first piece on which the clamp pushes (x0 ≥ 0)."""
        return self.stop - np.array([len(curve.pieces) for curve in self.curves], dtype=np.int64)

    @cached_property
    def x0_lock(self) -> FloatArray:
        """Displacement of each curve at its lock, where −tan α is largest (L); NaN if none."""
        return np.array([curve.x0_lock for curve in self.curves])

    @cached_property
    def mu_lock(self) -> FloatArray:
        """Critical friction coefficient μ_lock of each curve; NaN without a lock."""
        return np.array([curve.mu_lock for curve in self.curves])

    @cached_property
    def has_states(self) -> BoolArray:
        """Whether each curve has states with x0 ≥ 0, where the clamp pushes."""
        return self.pushed < self.stop

    @cached_property
    def locks(self) -> BoolArray:
        """Whether each curve has a lock: its tip does not slip forward if μ0 > μ_lock."""
        return np.array([curve.status is Status.SOLVED for curve in self.curves], dtype=bool)

    @cached_property
    def x0_end(self) -> FloatArray:
        """Last displacement of each curve (L); NaN for a curve without states."""
        last = np.where(self.has_states, self.stop - 1, -1)
        return np.append(self.pieces.last_x0, np.nan)[last]

    def _piece_of(self, index: IntArray, x0: FloatArray) -> IntArray:
        """Index of the piece on which each displacement lies."""
        place, first_x0 = self.begin[index], self.pieces.first_x0
        for _ in range(int((self.stop - self.begin).max(initial=1)) - 1):
            after = np.minimum(place + 1, len(first_x0) - 1)
            place += (place + 1 < self.stop[index]) & (first_x0[after] <= x0)
        return place

    def contact(self, index: IntArray, x0: FloatArray) -> list[str]:
        """Kind of contact at the displacements `x0`; an empty text where `x0` is NaN."""
        known = np.flatnonzero(np.isfinite(x0))
        kinds = np.full(len(x0), "", dtype=object)
        line = self.pieces.line[self._piece_of(index[known], x0[known])]
        kinds[known] = np.where(line, Contact.LINE.value, Contact.POINT.value)
        return list(kinds.tolist())

    def states(self, index: IntArray, x0: FloatArray) -> StickingState:
        """States at the displacements `x0`; NaN where `x0` is NaN."""
        known = np.flatnonzero(np.isfinite(x0))
        if len(known) < len(x0):
            states = StickingState.unknown(len(x0))
            if len(known):
                states.put(known, self.states(index[known], x0[known]))
            return states
        place = self._piece_of(index, x0)
        within = np.minimum(x0, self.pieces.last_x0[place])
        return replace(self.pieces.at(place, self.pieces.places_of(place, within)), x0=x0)

    def shapes(self, index: IntArray, x0: FloatArray, s: FloatArray) -> Shape:
        """Deformed shapes at the displacements `x0`, none of which is NaN."""
        found = np.empty((3, len(x0), len(s)))
        for some in self.rod_states(index, x0):
            found[:, some.rows] = shape(some.states, s)
        return Shape(*found)

    def rod_states(self, index: IntArray, x0: FloatArray) -> Iterator[RowStates]:
        """Yield the states of the rod at the displacements `x0`, those on one piece together."""
        place = self._piece_of(index, x0)
        t = self.pieces.places_of(place, np.minimum(x0, self.pieces.last_x0[place]))
        for piece in np.unique(place):
            rows = np.flatnonzero(place == piece)
            yield RowStates(rows=rows, states=self.pieces.shapes[piece].states(t[rows]))

    def onset(self, index: IntArray, mu0: FloatArray) -> FloatArray:
        """Exact onsets of slip (L); NaN where the tip locks or the curve ends before the onset."""
        onset = np.full(mu0.shape, np.nan)
        sampled, places = self._demand_up_to_the_lock
        place = self.pushed[index]
        while True:
            # Without a lock, `mu_lock` and `x0_lock` are NaN: the curve is searched up to its end.
            sought = (place < self.stop[index]) & ~(mu0 > self.mu_lock[index]) & np.isnan(onset)
            rows = np.flatnonzero(sought)
            rows = rows[~(self.pieces.first_x0[place[rows]] > self.x0_lock[index[rows]])]
            if not len(rows):
                return onset
            level = mu0[rows]
            # The sum has the sign of −tan α − μ0 as long as the surface pushes.
            ahead: dict[str, FloatArray | float] = {"reaction_fy": level, "reaction_fx": -1.0}
            at = self.pieces.first(place[rows], sampled, level, ahead, places=places)
            onset[rows] = self.pieces.displacements(place[rows], at)
            place = place + 1

    def outcomes(self, index: IntArray, mu0: FloatArray) -> tuple[FloatArray, list[Status]]:
        """Exact onset of slip (L) and status for each μ0; some curves may have no states.

        Where the tip does not slip, the onset is NaN. The status is then ``lock``, or the curve's
        own status if the curve has no lock.
        """
        x0_slip = self.onset(index, mu0)
        otherwise = np.array([curve.status for curve in self.curves], dtype=object)
        otherwise[self.locks] = Status.LOCK
        status = otherwise[index]
        status[np.isfinite(x0_slip)] = Status.SLIP
        return x0_slip, list(status)

    @cached_property
    def _demand_up_to_the_lock(self) -> tuple[FloatArray, FloatArray]:
        """Samples of −tan α and their parameter values; a lock replaces the sample just past it."""
        pieces = self.pieces
        count = self.stop - self.begin
        x0_lock, mu_lock = np.repeat(self.x0_lock, count), np.repeat(self.mu_lock, count)
        demand, places = pieces.samples.mobilised_friction, pieces.sample_places.copy()
        before = first_reached(pieces.samples.x0, np.arange(len(x0_lock)), x0_lock)
        rows = np.flatnonzero(before < demand.shape[1])
        demand[rows, before[rows]] = mu_lock[rows]
        places[rows, before[rows]] = pieces.places_of(rows, x0_lock[rows])
        return demand, places

    def motion_end(self, index: IntArray, mu0: FloatArray) -> tuple[list[End], StickingState]:
        """How sticking ends after the lock, and in which state, for each μ0 above μ_lock.

        The state is NaN where the end is ``not_followed``.
        """
        states = StickingState.unknown(len(mu0))
        ends = np.array([curve.end for curve in self.curves], dtype=object)[index]
        followed = np.flatnonzero(ends != End.NOT_FOLLOWED)
        states.put(followed, self.pieces.states.take((self.stop[index[followed]] - 1, -1)))
        place, pieces, sampled = self.pushed[index], self.pieces, self._alpha_past_the_lock
        while True:
            rows = np.flatnonzero((place < self.stop[index]) & (ends != End.SLIPS_BACK))
            if not len(rows):
                return list(ends), states
            alpha = np.arctan(mu0[rows])
            at = pieces.first(place[rows], sampled, alpha, _slips_back(alpha))
            slips = np.isfinite(at)
            states.put(rows[slips], self.pieces.at(place[rows[slips]], at[slips]))
            ends[rows[slips]] = End.SLIPS_BACK
            place = place + 1

    @cached_property
    def _alpha_past_the_lock(self) -> FloatArray:
        """Samples of α on all pieces; −π before the lock, where no tip slips back."""
        samples = self.pieces.samples
        x0_lock = np.repeat(self.x0_lock, self.stop - self.begin)
        return np.where(samples.x0 >= x0_lock[:, None], samples.alpha, -np.pi)

    def trailing_end(self, index: IntArray, mu0: FloatArray) -> StickingState:
        """Last sticking states of rods that trail behind after lateral buckling; else NaN."""
        states = StickingState.unknown(len(mu0))
        swings = np.array([curve.end is End.SWINGS_ASIDE for curve in self.curves], dtype=bool)
        # The trailing rod first passes the piece of the retraction next to α = 0.
        place = self.pushed[index] - 1
        while True:
            sought = swings[index] & (place >= self.begin[index]) & np.isnan(states.x0)
            rows = np.flatnonzero(sought)
            if not len(rows):
                return mirrored(states, self.x0_end[index])
            alpha = np.arctan(mu0[rows])
            sampled = -self.pieces.samples.alpha
            at = self.pieces.first(place[rows], sampled, -alpha, _slips_back(alpha))
            # If tan α is below μ0 on the whole piece, the tip slips on an earlier one.
            slips = at > self.pieces.start[place[rows]]
            states.put(rows[slips], self.pieces.at(place[rows[slips]], at[slips]))
            place = place - 1


def mirrored(states: StickingState, x0_end: FloatArray | float) -> StickingState:
    """Mirror images of states: the states of a rod that trails behind its clamp.

    The rod has buckled laterally at the displacement `x0_end` (L). The mirror image of the state at
    x0 has the displacement 2·x0_end − x0.
    """
    return replace(
        states,
        x0=2.0 * x0_end - states.x0,
        reaction_fx=-states.reaction_fx,
        reaction_m=-states.reaction_m,
        phi1=np.pi - states.phi1,
    )


def _slips_back(alpha: FloatArray) -> Mapping[str, FloatArray | float]:
    """Weights of a sum of columns that is zero where the force has the inclination `alpha`."""
    return {"reaction_fy": np.tan(alpha), "reaction_fx": 1.0}
