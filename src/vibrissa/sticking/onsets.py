"""Onsets of slip on sticking curves, the states at displacements, and the motion after the lock.

No result of one curve depends on other curves that are read with it, not even by rounding. The last
steps before the onsets are found by `vibrissa.sticking.periods.last_steps`.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from vibrissa.mechanics.equations import shape
from vibrissa.mechanics.shape import Shape
from vibrissa.numerics.arrays import BoolArray, FloatArray, IntArray, ObjectArray
from vibrissa.numerics.roots import first_reached
from vibrissa.outcomes import Contact, End, Status
from vibrissa.sticking.piece import (
    AHEAD,
    BACK,
    CONTACT_SLACK,
    ROUNDED_FORCE,
    PathState,
    Pieces,
    Samples,
    StickingState,
)
from vibrissa.sticking.shapes import RowStates


class _Exit(NamedTuple):
    """States in which the force leaves the friction cone.

    Attributes
    ----------
    piece : ndarray of int, shape (m,)
        Index of the piece of each state.
    place, x0 : ndarray, shape (m,)
        Value of the piece's parameter, and displacement (L); NaN where the force stays inside.
    """

    piece: IntArray
    place: FloatArray
    x0: FloatArray


@dataclass(frozen=True, eq=False, kw_only=True)
class CurveArray:
    """Sticking curves that are evaluated together; `vibrissa.sticking.curve.curve_array` makes it.

    The methods take an array `index` of int, shape (m,): the curve to which each of m
    displacements x0 (L) or friction coefficients μ0 belongs.

    Attributes
    ----------
    pieces : Pieces
        Pieces of all curves, one curve after the other. Those of a curve are in the order of x0:
        first those of its retraction, then those on which the clamp pushes (x0 ≥ 0).
    retracted, pushing : ndarray of int, shape (curves,)
        Numbers of both kinds of pieces of each curve.
    x0_lock, mu_lock : ndarray, shape (curves,)
        Displacement of each curve at its lock, where −tan α is largest (L), and its critical
        friction coefficient; NaN without a lock.
    status, end : ndarray of Status and of End, shape (curves,)
        Whether each curve was solved, and why it ends.
    """

    pieces: Pieces
    retracted: IntArray
    pushing: IntArray
    x0_lock: FloatArray
    mu_lock: FloatArray
    status: ObjectArray
    end: ObjectArray

    @cached_property
    def stop(self) -> IntArray:
        """Index of each curve's last piece, plus 1."""
        return np.cumsum(self.retracted + self.pushing)

    @cached_property
    def begin(self) -> IntArray:
        """Index of each curve's first piece."""
        return np.append(0, self.stop[:-1])

    @cached_property
    def pushed(self) -> IntArray:
        """Index of each curve's first piece on which the clamp pushes (x0 ≥ 0)."""
        return self.stop - self.pushing

    @cached_property
    def has_states(self) -> BoolArray:
        """Whether each curve has states with x0 ≥ 0, where the clamp pushes."""
        return self.pushed < self.stop

    @cached_property
    def locks(self) -> BoolArray:
        """Whether each curve has a lock: its tip does not slip forward if μ0 > μ_lock."""
        return np.asarray(self.status == Status.SOLVED)

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
        """Kind of contact at the displacements `x0`; an empty text where `x0` is NaN.

        In a kink, where the kind of contact changes, only the tip touches.
        """
        known = np.flatnonzero(np.isfinite(x0))
        kinds = np.full(len(x0), "", dtype=object)
        place = self._piece_of(index[known], x0[known])
        begins = x0[known] <= self.pieces.first_x0[place]
        in_kink = begins & (self.pieces.states.s_c[place, 0] > 1.0 - CONTACT_SLACK)
        line = self.pieces.line[place] & ~in_kink
        kinds[known] = np.where(line, Contact.LINE.value, Contact.POINT.value)
        return list(kinds.tolist())

    def states(self, index: IntArray, x0: FloatArray) -> StickingState:
        """States at the displacements `x0`; NaN where `x0` is NaN."""
        known = np.flatnonzero(np.isfinite(x0))
        if len(known) < len(x0):
            states = StickingState.unknown(len(x0))
            if len(known):
                return states.with_rows(known, self.states(index[known], x0[known]))
            return states
        place, t = self._place_of(index, x0)
        states = self.pieces.with_margins(place, t, self.pieces.at(place, t))
        return replace(states, x0=x0)

    def loads(self, index: IntArray, x0: FloatArray) -> PathState:
        """States at the displacements `x0` without their margins, which take long to compute."""
        known, states = np.flatnonzero(np.isfinite(x0)), PathState.unknown(len(x0))
        place, t = self._place_of(index[known], x0[known])
        return replace(states.with_rows(known, self.pieces.at(place, t)), x0=x0)

    def _place_of(self, index: IntArray, x0: FloatArray) -> tuple[IntArray, FloatArray]:
        """Piece on which each displacement lies, and the value of its parameter there."""
        piece = self._piece_of(index, x0)
        return piece, self.pieces.places_of(piece, np.minimum(x0, self.pieces.last_x0[piece]))

    def shapes(self, index: IntArray, x0: FloatArray, s: FloatArray) -> Shape:
        """Deformed shapes at the displacements `x0`, none of which is NaN."""
        found = np.empty((3, len(x0), len(s)))
        for some in self.rod_states(index, x0):
            found[:, some.rows] = shape(some.states, s)
        return Shape(*found)

    def rod_states(self, index: IntArray, x0: FloatArray) -> Iterator[RowStates]:
        """Yield the states of the rod at the displacements `x0`, those on one piece together."""
        place, t = self._place_of(index, x0)
        for piece in np.unique(place):
            rows = np.flatnonzero(place == piece)
            yield RowStates(rows=rows, states=self.pieces.shapes[piece].states(t[rows]))

    def onset(self, index: IntArray, mu0: FloatArray) -> FloatArray:
        """Exact onsets of slip (L): the first states in which −tan α = μ0.

        NaN where the tip slips back before, or sticks up to the end of the curve.
        """
        onset = np.full(mu0.shape, np.nan)
        # Without a lock, `mu_lock` is NaN: the curve is searched up to its end.
        rows = np.flatnonzero(~(mu0 > self.mu_lock[index]))
        onset[rows] = self._exit(AHEAD, index[rows], mu0[rows]).x0
        pushed_back = np.flatnonzero(onset > self._x0_back[index])
        if len(pushed_back):
            back = self._exit(BACK, index[pushed_back], mu0[pushed_back]).x0
            onset[pushed_back[back < onset[pushed_back]]] = np.nan
        return onset

    def _exit(self, way: float, index: IntArray, mu0: FloatArray) -> _Exit:
        """Find the first states with x0 ≥ 0 in which friction holds the tip no longer.

        The tip is about to slip forward (`way` = `AHEAD`) or back (`BACK`).
        """
        samples = self._demand_ahead if way == AHEAD else self._demand_back
        piece, at, x0 = self.pushed[index], np.full(mu0.shape, np.nan), np.full(mu0.shape, np.nan)
        while True:
            rows = np.flatnonzero((piece < self.stop[index]) & np.isnan(at))
            if not len(rows):
                return _Exit(piece=piece, place=at, x0=x0)
            at[rows] = self.pieces.first_slip(piece[rows], samples, mu0[rows], mu0[rows], way)
            x0[rows] = self.pieces.displacements(piece[rows], at[rows])
            piece[rows] += np.isnan(at[rows])

    def outcomes(self, index: IntArray, mu0: FloatArray) -> tuple[FloatArray, list[Status]]:
        """Exact onset of slip (L) and status for each μ0; some curves may have no states.

        Where the tip does not slip forward, the onset is NaN. The status is then ``lock``, or the
        curve's own status if the curve has no lock and the tip does not slip back on it.
        """
        x0_slip = self.onset(index, mu0)
        otherwise = self.status.copy()
        otherwise[self.locks] = Status.LOCK
        status = otherwise[index]
        status[np.isfinite(x0_slip)] = Status.SLIP
        rows = np.flatnonzero(np.isnan(x0_slip) & ~self.locks[index] & self.has_states[index])
        if len(rows):
            back = self._exit(BACK, index[rows], mu0[rows]).x0
            status[rows[np.isfinite(back)]] = Status.LOCK
        return x0_slip, list(status)

    @cached_property
    def _demand_ahead(self) -> Samples:
        return self._demand(AHEAD)

    @cached_property
    def _demand_back(self) -> Samples:
        return self._demand(BACK)

    def _demand(self, way: float) -> Samples:
        """Sample −way·tan α, and replace the sample just past each peak by the peak."""
        pieces, peaks = self.pieces, self.pieces.peaks(way)
        demand, places = way * pieces.samples.mobilised_friction, pieces.sample_places.copy()
        after = first_reached(places, peaks.piece, peaks.place)
        demand[peaks.piece, after] = way * pieces.at(*peaks).mobilised_friction
        places[peaks.piece, after] = peaks.place
        return Samples(demand, places)

    @cached_property
    def _x0_back(self) -> FloatArray:
        """Displacement (L) at which the first sample of each curve has fx > 0; NaN if none has."""
        samples, first = self.pieces.samples, np.full(len(self.stop), np.nan)
        back = np.where(samples.reaction_fx > ROUNDED_FORCE, samples.x0, np.inf).min(axis=1)
        for row, (start, stop) in enumerate(zip(self.pushed, self.stop, strict=True)):
            some = back[start:stop]
            if np.isfinite(some).any():
                first[row] = some.min()
        return first

    def motion_end(self, index: IntArray, mu0: FloatArray) -> tuple[list[End], StickingState]:
        """How sticking ends where the tip does not slip forward, and in which state.

        The state is NaN where the end is ``not_followed``.
        """
        states = StickingState.unknown(len(mu0))
        ends = self.end[index]
        followed = np.flatnonzero(ends != End.NOT_FOLLOWED)
        final = self.stop[index[followed]] - 1
        last = self.pieces.with_margins(
            final, self.pieces.stop[final], self.pieces.states.take((final, -1))
        )
        back = self._exit(BACK, index, mu0)
        slips = np.flatnonzero(np.isfinite(back.place))
        piece, place = back.piece[slips], back.place[slips]
        slipping = self.pieces.with_margins(piece, place, self.pieces.at(piece, place))
        ends[slips] = End.SLIPS_BACK
        return list(ends), states.with_rows(followed, last).with_rows(slips, slipping)

    def trailing_end(self, index: IntArray, mu0: FloatArray) -> StickingState:
        """Last sticking states of rods that trail behind after lateral buckling; else NaN."""
        states = StickingState.unknown(len(mu0))
        swings = self.end == End.SWINGS_ASIDE
        # The trailing rod first passes the piece of the retraction next to α = 0.
        place = self.pushed[index] - 1
        # Along the retraction tan α falls towards α = 0.
        samples = Samples(-self.pieces.samples.alpha, self.pieces.sample_places)
        while True:
            sought = swings[index] & (place >= self.begin[index]) & np.isnan(states.x0)
            rows = np.flatnonzero(sought)
            if not len(rows):
                return mirrored(states, self.x0_end[index])
            level = -np.arctan(mu0[rows])
            at = self.pieces.first_slip(place[rows], samples, level, mu0[rows], BACK)
            # If tan α is below μ0 on the whole piece, the tip slips on an earlier one.
            slips = at > self.pieces.start[place[rows]]
            piece, t = place[rows[slips]], at[slips]
            found = self.pieces.with_margins(piece, t, self.pieces.at(piece, t))
            states = states.with_rows(rows[slips], found)
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
