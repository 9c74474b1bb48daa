"""Smooth pieces of equilibrium paths, and searches for levels and maxima on them.

No result on one piece depends on other pieces, not even by rounding.
"""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple, Self

import numpy as np
from numpy.polynomial import chebyshev

from vibrissa.mechanics.states import ContactLoads, ContactState, Values
from vibrissa.numerics.arrays import BoolArray, FloatArray, IntArray, ObjectArray
from vibrissa.numerics.batch import Batch
from vibrissa.numerics.roots import bracketed_root, first_reached
from vibrissa.numerics.spectral import (
    chebyshev_derivative,
    chebyshev_nodes,
    chebyshev_series,
    chebyshev_transform,
)

# Number of Chebyshev points at which each piece has states: the largest number that is solved.
STATES_PER_PIECE = 49
# Number of samples of each piece; they bracket crossings, which are then located exactly.
SAMPLES = 257
SAMPLE_POLYNOMIALS = chebyshev.chebvander(np.linspace(-1.0, 1.0, SAMPLES), STATES_PER_PIECE - 1)
# Forces below this are rounding errors (E·I0/L²).
ROUNDED_FORCE = 1e-9
# Rounding error where the kind of contact changes: how much s_c may exceed 1 (L) in line contact,
# or φ1 be negative (rad) in point contact.
CONTACT_SLACK = 1e-9


@dataclass(frozen=True, eq=False, kw_only=True)
class PathState(ContactLoads):
    """Equilibria on a path, without their margins of stability.

    Attributes
    ----------
    x0 : ndarray or float
        Displacement of the clamp since the α = 0 state (L).
    """

    x0: Values


@dataclass(frozen=True, eq=False, kw_only=True)
class StickingState(ContactState):
    """Sticking equilibria: one state, or arrays of states.

    The margins of stability are interpolated along the path. Their error is mostly below 1e-5, and
    below 5e-3 where two eigenvalues meet. `vibrissa.solve_state` computes exact margins of one
    state.

    Attributes
    ----------
    x0 : ndarray or float
        Displacement of the clamp since the α = 0 state (L).
    """

    x0: Values


# Ways in which a tip may slip, as signs of −tan α: forward, towards +x, and back, towards −x.
AHEAD, BACK = 1.0, -1.0


class Peaks(NamedTuple):
    """Local maxima of the mobilised friction on pieces.

    Attributes
    ----------
    piece : ndarray of int, shape (n,)
        Index of the piece on which each maximum lies.
    place : ndarray, shape (n,)
        Value of the piece's parameter at each maximum.
    """

    piece: IntArray
    place: FloatArray


class Samples(NamedTuple):
    """Samples of a quantity along pieces.

    Attributes
    ----------
    values : ndarray, shape (pieces, samples)
    places : ndarray, shape (pieces, samples)
        Values of the parameter of each piece, in increasing order.
    """

    values: FloatArray
    places: FloatArray


def rounded_contact(s_c: FloatArray) -> FloatArray:
    """Set s_c (line contact) to 1 where it exceeds 1 by no more than a rounding error."""
    return np.where(s_c > 1.0 + CONTACT_SLACK, s_c, np.minimum(s_c, 1.0))


@dataclass(frozen=True, eq=False, kw_only=True)
class Pieces(Batch):
    """Smooth pieces of one or several curves, each with one kind of contact.

    Along each piece one continuation parameter grows. The methods take an array `index` of int,
    shape (n,): the piece to which each of n parameter values, displacements or levels belongs.

    Attributes
    ----------
    line : ndarray of bool, shape (pieces,)
        Whether all states of a piece are in line contact; otherwise all are in point contact.
    by_x0 : ndarray of bool, shape (pieces,)
        Whether the parameter of a piece is x0. Where the force changes fast or x0 turns back, the
        parameter is a weighted sum of offset, force and s_c instead (equation E3c of
        `vibrissa.mechanics.equations`).
    start, stop : ndarray, shape (pieces,)
        First and last value of each parameter (in L if it is x0).
    states : PathState, columns of shape (pieces, STATES_PER_PIECE)
        States at the Chebyshev points between `start` and `stop`. A piece is directed towards
        larger x0.
    shapes : ndarray of ShapesAlongPiece, shape (pieces,)
        Shapes of the rod along each piece; None where the solver was shooting.
    """

    line: BoolArray
    by_x0: BoolArray
    start: FloatArray
    stop: FloatArray
    states: PathState
    shapes: ObjectArray

    @property
    def first_x0(self) -> FloatArray:
        """Displacements at which the pieces begin (L)."""
        return np.asarray(self.states.x0[:, 0])

    @property
    def last_x0(self) -> FloatArray:
        """Displacements at which the pieces end (L)."""
        return np.asarray(self.states.x0[:, -1])

    @cached_property
    def _coefficients(self) -> tuple[FloatArray, ...]:
        """Chebyshev coefficients of the columns and of their first and second derivatives.

        Each array has the shape (pieces, columns, STATES_PER_PIECE).
        """
        derivative, scale = chebyshev_derivative(STATES_PER_PIECE).T, 2.0 / (self.stop - self.start)
        value = (
            np.stack([*self.states.columns.values()], axis=1)
            @ chebyshev_transform(STATES_PER_PIECE).T
        )
        slope = value @ derivative * scale[:, None, None]
        return value, slope, slope @ derivative * scale[:, None, None]

    def values(
        self, index: IntArray, t: FloatArray, names: Collection[str], orders: Sequence[int]
    ) -> FloatArray:
        """Interpolate derivatives of orders 0 to 2 of some columns, shape (orders, columns, n)."""
        columns = [PathState.names().index(name) for name in names]
        some = [self._coefficients[order].take(columns, axis=1) for order in orders]
        start, stop = self.start[index], self.stop[index]
        position = 2.0 * (t - start) / (stop - start) - 1.0
        values = chebyshev_series(np.concatenate(some, axis=1), index, position)
        return values.T.reshape(len(orders), len(columns), len(t))

    def _sampled(self, order: int) -> PathState:
        """Differentiate the states at `sample_places`; `order` 0 returns the states themselves."""
        sampled = self._coefficients[order] @ SAMPLE_POLYNOMIALS.T
        return PathState.from_matrix(np.moveaxis(sampled, 1, -1))

    def at(self, index: IntArray, t: FloatArray) -> PathState:
        """Interpolate states at the parameter values `t`."""
        (columns,) = self.values(index, t, PathState.names(), (0,))
        states = PathState.from_matrix(columns.T)
        line = self.line[index]
        return replace(
            states,
            s_c=np.where(line, rounded_contact(states.s_c), 1.0),
            phi1=np.where(line, 0.0, states.phi1),
            x0=np.where(self.by_x0[index], t, states.x0),
        )

    @cached_property
    def _margins(self) -> FloatArray:
        """Chebyshev coefficients of both margins along the parts, (pieces, 2, STATES_PER_PIECE)."""
        margins = np.zeros((len(self), 2, STATES_PER_PIECE))
        for row, along in enumerate(self.shapes):
            if along is None:
                margins[row] = np.nan
            else:
                margins[row, :, : along.margins.shape[1]] = along.margins
        return margins

    def with_margins(self, index: IntArray, t: FloatArray, states: PathState) -> StickingState:
        """Add the margins of stability to the states at the parameter values `t`."""
        known = [along is not None for along in self.shapes]
        first, length = np.ones((2, len(self)))
        first[known] = [along.first for along in self.shapes[known]]
        length[known] = [along.last - along.first for along in self.shapes[known]]
        position = 2.0 * (t - first[index]) / length[index] - 1.0
        # No margin exceeds 1, but between the states the interpolant may.
        margins = np.minimum(chebyshev_series(self._margins, index, position), 1.0)
        return StickingState(
            **states.columns, stability=margins[:, 0], stability_aside=margins[:, 1]
        )

    def displacements(self, index: IntArray, t: FloatArray) -> FloatArray:
        """Displacements x0 (L) at the parameter values `t`; NaN where `t` is NaN."""
        x0, sought = t.copy(), np.flatnonzero(~self.by_x0[index] & np.isfinite(t))
        if len(sought):
            x0[sought] = self.at(index[sought], t[sought]).x0
        return x0

    def places_of(self, index: IntArray, x0: FloatArray) -> FloatArray:
        """Parameter values at the displacements `x0` (L)."""
        sought = np.flatnonzero(~self.by_x0[index])
        if not len(sought):
            return x0
        # Neighbouring pieces meet up to rounding only.
        levels = np.minimum(x0[sought], self.samples.x0[index[sought], -1])
        t = x0.copy()
        t[sought] = self.first_sum(index[sought], {"x0": 1.0}, levels)
        return t

    @cached_property
    def sample_places(self) -> FloatArray:
        """Equally spaced parameter values from `start` to `stop`, shape (pieces, SAMPLES)."""
        return np.linspace(self.start, self.stop, SAMPLES, axis=1)

    @cached_property
    def samples(self) -> PathState:
        """States at `sample_places`.

        Those at the ends are exact, the others accurate enough to bracket a root.
        """
        samples, ends = self._sampled(0), [0, -1]
        for name, values in samples.columns.items():
            values[:, ends] = getattr(self.states, name)[:, ends]
        return samples

    def up_to(self, stop: FloatArray) -> Self:
        """Cut each piece off at the value `stop` of its parameter."""
        return self.cut_to(self.start, stop)

    def cut_to(self, start: FloatArray, stop: FloatArray) -> Self:
        """Cut each piece to the part between two values of its parameter."""
        places = start[:, None] + (stop - start)[:, None] * chebyshev_nodes(STATES_PER_PIECE)
        states = self.at(np.repeat(np.arange(len(self)), STATES_PER_PIECE), places.ravel())
        states = states.each(lambda values: values.reshape(places.shape))
        return replace(self, start=start, stop=stop, states=states)

    def first(
        self,
        index: IntArray,
        samples: Samples,
        levels: FloatArray,
        excess: Callable[[FloatArray, IntArray], tuple[FloatArray, FloatArray]],
    ) -> FloatArray:
        """Find where a quantity first reaches a level.

        Parameters
        ----------
        samples : Samples
            Samples of the quantity, which need not increase. They bracket the place.
        levels : ndarray, shape (n,)
            Level of the quantity, for each index.
        excess : callable
            Maps parameter values and the rows of `index` to which they belong to values and slopes
            of a function that is zero where the quantity has its level. This place is found to
            rounding error.

        Returns
        -------
        ndarray, shape (n,)
            Parameter values at which the levels are first reached; NaN if no sample reaches them.
        """
        if not len(index):
            return np.empty(0)
        values, t = samples
        after = first_reached(np.maximum.accumulate(values, axis=1), index, levels)
        found = np.where(after == 0, t[index, 0], np.nan)
        rows = np.flatnonzero((after > 0) & (after < t.shape[1]))
        if not len(rows):
            return found
        piece, after = index[rows], after[rows]
        low, high = t[piece, after - 1], t[piece, after]
        before, behind = values[piece, after - 1], values[piece, after]
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            share = np.nan_to_num((levels[rows] - before) / (behind - before))
        guess = low + np.clip(share, 0.0, 1.0) * (high - low)
        found[rows] = bracketed_root(excess, low, high, rows, guess=guess)
        return found

    def first_sum(
        self, index: IntArray, weights: Mapping[str, float], levels: FloatArray, derivative: int = 0
    ) -> FloatArray:
        """Find where a weighted sum of columns first reaches a level, as `first` does.

        Parameters
        ----------
        weights : mapping
            Weights in the sum, by names of the columns.
        derivative : int
            0 to sum the columns, 1 to sum their derivatives with respect to the parameter.
        """
        columns = self._sampled(derivative) if derivative else self.samples
        sampled = [weight * getattr(columns, name) for name, weight in weights.items()]
        factors = np.array(list(weights.values()))

        def excess(t: FloatArray, rows: IntArray) -> tuple[FloatArray, FloatArray]:
            values = self.values(index[rows], t, weights, (derivative, derivative + 1))
            total, slope = factors @ values
            return total - levels[rows], slope

        return self.first(index, Samples(sum(sampled), self.sample_places), levels, excess)

    def first_slip(
        self, index: IntArray, samples: Samples, levels: FloatArray, mu0: FloatArray, way: float
    ) -> FloatArray:
        """Find where the force first leaves the friction cone, as `first` does.

        The tip is about to slip forward (`way` = `AHEAD`) or back (`BACK`). The samples and levels
        are those of −tan α or of another measure of the inclination.
        """

        def excess(t: FloatArray, rows: IntArray) -> tuple[FloatArray, FloatArray]:
            # The sum has the sign of −way·tan α − μ0 as long as the surface pushes.
            forces = self.values(index[rows], t, ("reaction_fx", "reaction_fy"), (0, 1))
            value, slope = mu0[rows] * forces[:, 1] - way * forces[:, 0]
            return value, slope

        return self.first(index, samples, levels, excess)

    def peaks(self, way: float) -> Peaks:
        """Local maxima of −tan α (`way` = `AHEAD`) or tan α (`BACK`), ends of pieces included.

        Only states count in which friction keeps the tip from slipping this way.
        """
        held = way * self.samples.reaction_fx <= 0.0
        demand = np.where(held, way * self.samples.mobilised_friction, -np.inf)
        before, after = demand[:, :-1], demand[:, 1:]
        highest = held.copy()
        highest[:, 1:] &= after >= before
        highest[:, :-1] &= before >= after
        piece, top = np.nonzero(highest)
        t = self.sample_places

        def slope(t: FloatArray, index: IntArray) -> tuple[FloatArray, FloatArray]:
            """Return fy² times the derivative of fx/fy, and the derivative of this product."""
            force, first, second = self.values(index, t, ("reaction_fx", "reaction_fy"), (0, 1, 2))
            (fx, fy), (dfx, dfy), (ddfx, ddfy) = force, first, second
            return dfx * fy - fx * dfy, ddfx * fy - fx * ddfy

        # If the largest sample is at an end, the maximum may be between it and the next sample.
        low, high = t[piece, np.maximum(top - 1, 0)], t[piece, np.minimum(top + 1, SAMPLES - 1)]
        found, inside = t[piece, top], slope(low, piece)[0] * slope(high, piece)[0] < 0.0
        found[inside] = bracketed_root(slope, low[inside], high[inside], piece[inside])
        return Peaks(piece=piece, place=found)

    def turning_points(self) -> FloatArray:
        """Parameter values at which x0 has a maximum; NaN on pieces where x0 only increases."""
        turns, index = np.full(len(self), np.nan), np.flatnonzero(~self.by_x0)
        if len(index):
            turns[index] = self.first_sum(index, {"x0": -1.0}, np.zeros(len(index)), derivative=1)
        return turns


NO_PIECES = Pieces(
    line=np.empty(0, dtype=bool),
    by_x0=np.empty(0, dtype=bool),
    start=np.empty(0),
    stop=np.empty(0),
    states=PathState.unknown((0, STATES_PER_PIECE)),
    shapes=np.empty(0, dtype=object),
)
