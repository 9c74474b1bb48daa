"""Smooth pieces of sticking curves, and the one search for where something happens on them.

Pieces of many curves stand side by side in one array (`PieceArray`), so that a call of NumPy
serves all of them. What is found on one piece does not depend on which others stand beside it, bit
for bit.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Protocol

import numpy as np

from vibrissa.mechanics.states import ContactState, Values
from vibrissa.numerics.arrays import BoolArray, FloatArray, IntArray
from vibrissa.numerics.roots import bracketed_root, first_reached, inverse_quadratic
from vibrissa.numerics.spectral import (
    chebyshev_derivative,
    chebyshev_nodes,
    chebyshev_series,
    chebyshev_transform,
    even_derivative,
    even_interpolation,
)
from vibrissa.outcomes import Contact, Parameter

# Samples of each piece between which crossings are bracketed before they are located exactly.
SAMPLES = 257
# Columns that are not known on a step grid.
MARGINS = ("stability", "stability_aside")
# Order of the spline through states on a step grid.
SPLINE_DEGREE = 5
# By how much a contact point may be beyond the tip (L), or the slope of a tip below that of the
# surface (rad), where the contact changes its kind.
CONTACT_SLACK = 1e-9


@dataclass(frozen=True, eq=False, kw_only=True)
class StickingState(ContactState):
    """Sticking equilibria: one state, or arrays of states.

    Attributes
    ----------
    x0 : ndarray or float
        Footpoint displacement since the α = 0 state, in units of L.
    """

    x0: Values


# A linear form of states for each level that is crossed: the weight of each column that counts.
Form = Callable[[FloatArray], Mapping[str, FloatArray | float]]
# Maps some columns, their first and their second derivatives to two numbers for each place.
Slope = Callable[[FloatArray, FloatArray, FloatArray], tuple[FloatArray, FloatArray]]


@dataclass(frozen=True, eq=False, kw_only=True)
class Piece:
    """A smooth piece of a sticking curve, with one kind of contact.

    Attributes
    ----------
    contact : Contact
        Kind of contact of its states.
    parameter : Parameter
        What the states are counted by.
    start, stop : float
        First and last value of the parameter (x0 in L).
    states : StickingState, columns of shape (k,)
        Known states; x0 increases.
    stepped : bool
        Whether the states stand on a step grid of x0; at Chebyshev points of the parameter
        otherwise.
    """

    contact: Contact
    parameter: Parameter
    start: float
    stop: float
    states: StickingState
    stepped: bool = False

    @property
    def first_x0(self) -> float:
        """Displacement at which the piece begins (L)."""
        return float(self.states.x0[0])

    @property
    def last_x0(self) -> float:
        """Displacement at which the piece ends (L)."""
        return float(self.states.x0[-1])

    @cached_property
    def alone(self) -> "PieceArray":
        """The piece as an array of one."""
        return PieceArray(pieces=(self,))

    def at(self, t: FloatArray) -> StickingState:
        """States at values of the parameter, shape (n,)."""
        return self.alone.at(np.zeros(len(t), dtype=np.int64), t)


def rounded_contact(s_c: FloatArray) -> FloatArray:
    """Contact points of line contact, 1 where they are beyond the tip by rounding alone."""
    return np.where(s_c > 1.0 + CONTACT_SLACK, s_c, np.minimum(s_c, 1.0))


class _Group(Protocol):
    """Pieces that are interpolated together."""

    def values(
        self, of: IntArray, t: FloatArray, columns: Sequence[int], orders: Sequence[int]
    ) -> FloatArray:
        """Interpolate derivatives of some columns, shape (len(t), orders·columns)."""

    def samples(self) -> FloatArray:
        """Interpolate columns at equally spaced places, shape (pieces, columns, SAMPLES)."""


@dataclass(frozen=True, eq=False, kw_only=True)
class _Series:
    """Pieces with equally many states at Chebyshev points.

    Attributes
    ----------
    states : ndarray, shape (n, k, columns)
    start, length : ndarray, shape (n,)
        First value of the parameter, and how far the pieces go.
    """

    states: FloatArray
    start: FloatArray
    length: FloatArray

    @cached_property
    def _coefficients(self) -> tuple[FloatArray, ...]:
        """Coefficients of the columns and of two derivatives, each of shape (n, k, columns)."""
        count = self.states.shape[1]
        derivative = chebyshev_derivative(count)
        value = chebyshev_transform(count) @ self.states
        slope = derivative @ value * (2.0 / self.length)[:, None, None]
        return value, slope, derivative @ slope * (2.0 / self.length)[:, None, None]

    def values(
        self, of: IntArray, t: FloatArray, columns: Sequence[int], orders: Sequence[int]
    ) -> FloatArray:
        """Interpolate derivatives of some columns; see `_Group`."""
        some = [self._coefficients[order].take(columns, axis=2) for order in orders]
        position = 2.0 * (t - self.start[of]) / self.length[of] - 1.0
        return chebyshev_series(np.concatenate(some, axis=2), of, position)

    def samples(self) -> FloatArray:
        """Interpolate columns well enough to bracket crossings; see `_Group`."""
        matrix = even_interpolation(self.states.shape[1], SAMPLES)
        return np.asarray(self.states.transpose(0, 2, 1) @ matrix.T)


@dataclass(frozen=True, eq=False, kw_only=True)
class _Spline:
    """One piece with states on a step grid."""

    states: StickingState

    @cached_property
    def _splines(self) -> tuple[Any, ...]:
        """Splines of the columns and of two derivatives."""
        # Not needed, and not waited for, where states are not stepped.
        from scipy.interpolate import make_interp_spline

        degree = min(SPLINE_DEGREE, len(self.states) - 1)
        # The margins of stability are not known on a step grid.
        values = np.nan_to_num(self.states.matrix())
        spline = make_interp_spline(self.states.x0, values, k=degree)
        return spline, spline.derivative(), spline.derivative(2)

    def values(
        self, of: IntArray, t: FloatArray, columns: Sequence[int], orders: Sequence[int]
    ) -> FloatArray:
        """Interpolate derivatives of some columns; see `_Group`."""
        return np.hstack([self._splines[order](t)[:, columns] for order in orders])

    def samples(self) -> FloatArray:
        """Interpolate columns at equally spaced places; see `_Group`."""
        t = np.linspace(self.states.x0[0], self.states.x0[-1], SAMPLES)
        return np.asarray(self._splines[0](t).T[None])


@dataclass(frozen=True, eq=False, kw_only=True)
class PieceArray:
    """Pieces of one or several curves.

    An argument `of`, ndarray of int of shape (n,), says on which piece each place or level is.

    Attributes
    ----------
    pieces : tuple of Piece
    """

    pieces: tuple[Piece, ...]

    @cached_property
    def start(self) -> FloatArray:
        """First values of the parameters."""
        return np.array([piece.start for piece in self.pieces])

    @cached_property
    def stop(self) -> FloatArray:
        """Last values of the parameters."""
        return np.array([piece.stop for piece in self.pieces])

    @cached_property
    def first_x0(self) -> FloatArray:
        """Displacements at which the pieces begin (L)."""
        return np.array([piece.first_x0 for piece in self.pieces])

    @cached_property
    def last_x0(self) -> FloatArray:
        """Displacements at which the pieces end (L)."""
        return np.array([piece.last_x0 for piece in self.pieces])

    @cached_property
    def last(self) -> StickingState:
        """Last states of the pieces."""
        rows = [[column[-1] for column in piece.states.columns.values()] for piece in self.pieces]
        return StickingState.from_matrix(np.array(rows).reshape(-1, len(StickingState.names())))

    @cached_property
    def line(self) -> BoolArray:
        """Whether the states are in line contact."""
        return np.array([piece.contact is Contact.LINE for piece in self.pieces], dtype=bool)

    @cached_property
    def by_x0(self) -> BoolArray:
        """Whether the states are counted by the displacement."""
        return np.array([piece.parameter is Parameter.X0 for piece in self.pieces], dtype=bool)

    @cached_property
    def stepped(self) -> BoolArray:
        """Whether the states stand on a step grid."""
        return np.array([piece.stepped for piece in self.pieces], dtype=bool)

    @cached_property
    def _grouped(self) -> list[tuple[IntArray, _Group]]:
        """Groups of pieces, each with the places of its members."""
        groups: list[tuple[IntArray, _Group]] = [
            (np.array([row]), _Spline(states=self.pieces[row].states))
            for row in np.flatnonzero(self.stepped)
        ]
        counts = np.array([len(piece.states) for piece in self.pieces])
        for count in np.unique(counts[~self.stepped]):
            rows = np.flatnonzero(~self.stepped & (counts == count))
            states = StickingState.concatenate([self.pieces[row].states for row in rows]).matrix()
            group = _Series(
                states=states.reshape(len(rows), count, -1),
                start=self.start[rows],
                length=self.stop[rows] - self.start[rows],
            )
            groups.append((rows, group))
        return groups

    @cached_property
    def _place(self) -> tuple[IntArray, IntArray]:
        """Group of each piece, and its place there."""
        group, place = np.empty((2, len(self.pieces)), dtype=np.int64)
        for number, (rows, _) in enumerate(self._grouped):
            group[rows], place[rows] = number, np.arange(len(rows))
        return group, place

    def _values(
        self, of: IntArray, t: FloatArray, names: Sequence[str], orders: Sequence[int]
    ) -> FloatArray:
        """Interpolate derivatives of some columns, of orders up to 2: (orders, columns, n)."""
        all_names = StickingState.names()
        columns = [all_names.index(name) for name in names]
        shape = len(orders), len(names), len(t)
        group, place = self._place
        if len(self._grouped) == 1:
            ((_, only),) = self._grouped
            return only.values(place[of], t, columns, orders).T.reshape(shape)
        values = np.empty((len(t), len(orders) * len(names)))
        for number, (_, each) in enumerate(self._grouped):
            rows = np.flatnonzero(group[of] == number)
            if len(rows):
                values[rows] = each.values(place[of[rows]], t[rows], columns, orders)
        return values.T.reshape(shape)

    def at(self, of: IntArray, t: FloatArray) -> StickingState:
        """States at values of the parameters."""
        (columns,) = self._values(of, t, StickingState.names(), (0,))
        states = StickingState(**dict(zip(StickingState.names(), columns, strict=True)))
        line = self.line[of]
        # No margin exceeds 1, but between the states the interpolant may.
        exact = {
            name: np.where(self.stepped[of], np.nan, np.minimum(getattr(states, name), 1.0))
            for name in MARGINS
        }
        return replace(
            states,
            **exact,
            s_c=np.where(line, rounded_contact(states.s_c), 1.0),
            phi1=np.where(line, 0.0, states.phi1),
            x0=np.where(self.by_x0[of], t, states.x0),
        )

    def at_x0(self, of: IntArray, x0: FloatArray) -> StickingState:
        """States at displacements."""
        return self.at(of, self.places_of(of, x0))

    def displacements(self, of: IntArray, t: FloatArray) -> FloatArray:
        """Displacements at values of the parameters, NaN where these are."""
        x0, sought = t.copy(), np.flatnonzero(~self.by_x0[of] & np.isfinite(t))
        if len(sought):
            x0[sought] = self.at(of[sought], t[sought]).x0
        return x0

    def places_of(self, of: IntArray, x0: FloatArray) -> FloatArray:
        """Values of the parameters at displacements."""
        sought = np.flatnonzero(~self.by_x0[of])
        if not len(sought):
            return x0
        # Pieces meet up to rounding.
        levels = np.minimum(x0[sought], self.samples.x0[of[sought], -1])
        t = x0.copy()
        t[sought] = self.first(of[sought], self.samples.x0, levels, displacement, value=levels)
        return t

    @cached_property
    def sample_places(self) -> FloatArray:
        """Equally spaced values of the parameters, both ends included, shape (pieces, SAMPLES)."""
        return np.linspace(self.start, self.stop, SAMPLES, axis=1)

    @cached_property
    def samples(self) -> StickingState:
        """States at `sample_places`, good enough to bracket crossings."""
        columns = np.empty((len(StickingState.names()), *self.sample_places.shape))
        for rows, group in self._grouped:
            columns[:, rows] = group.samples().transpose(1, 0, 2)
        return StickingState(**dict(zip(StickingState.names(), columns, strict=True)))

    def restricted(self, of: IntArray, stop: FloatArray) -> list[Piece]:
        """Cut pieces off at values of their parameters."""
        if not len(of):
            return []
        counts = [len(self.pieces[row].states) for row in of]
        places = [
            self.start[row] + (end - self.start[row]) * chebyshev_nodes(count)
            for row, end, count in zip(of, stop, counts, strict=True)
        ]
        states = self.at(np.repeat(of, counts), np.concatenate(places))
        first = np.cumsum([0, *counts])
        return [
            replace(
                self.pieces[row],
                stop=float(end),
                states=states.take(slice(begin, begin + count)).copy(),
            )
            for row, end, begin, count in zip(of, stop, first, counts, strict=False)
        ]

    def first(
        self,
        of: IntArray,
        sampled: FloatArray,
        levels: FloatArray,
        form: Form,
        *,
        value: FloatArray | float = 0.0,
        places: FloatArray | None = None,
        derivative: int = 0,
    ) -> FloatArray:
        """Find where a quantity first reaches given levels.

        Parameters
        ----------
        of : ndarray of int, shape (n,)
        sampled : ndarray, shape (pieces, samples)
            The quantity at `places`; it may fall again behind a level.
        levels : ndarray, shape (n,)
        form : callable
            Maps levels to the weights of columns in a sum that has a certain value where the
            quantity reaches the level.
        value : ndarray, shape (n,), or float
            That value.
        places : ndarray, shape (pieces, samples), optional
            Increasing values of the parameters, by default `sample_places`.
        derivative : int
            Which derivative of the states the form is taken of.

        Returns
        -------
        ndarray, shape (n,)
            Values of the parameters; NaN where no sample reaches the level.
        """
        if not len(of):
            return np.empty(0)
        t = self.sample_places if places is None else places
        after = first_reached(np.maximum.accumulate(sampled, axis=1), of, levels)
        found = np.where(after == 0, t[of, 0], np.nan)
        inside = np.flatnonzero((after > 0) & (after < t.shape[1]))
        if not len(inside):
            return found
        of, after, level = of[inside], after[inside], levels[inside]
        value = np.broadcast_to(value, levels.shape)[inside]
        low, high = t[of, after - 1], t[of, after]
        weights = form(level)
        names = tuple(weights)

        def excess(
            t: FloatArray, of: IntArray, value: FloatArray, *weighted: FloatArray
        ) -> tuple[FloatArray, FloatArray]:
            values = self._values(of, t, names, (derivative, derivative + 1))
            total, slope = (values * np.array(weighted)).sum(axis=1)
            return total - value, slope

        # Through both samples and the one before them, or behind them.
        around = np.stack([after - 1, after, np.where(after > 1, after - 2, after + 1)])
        guess = inverse_quadratic(sampled[of, around], t[of, around], level)
        each = [np.broadcast_to(weight, value.shape) for weight in weights.values()]
        found[inside] = bracketed_root(excess, low, high, of, value, *each, guess=guess)
        return found

    def largest(
        self, of: IntArray, sampled: FloatArray, columns: Sequence[str], slope: Slope
    ) -> FloatArray:
        """Find where a quantity is largest on some pieces.

        Parameters
        ----------
        of : ndarray of int, shape (n,)
        sampled : ndarray, shape (n, SAMPLES)
            The quantity at the `sample_places` of these pieces.
        columns : sequence of str
            What the quantity depends on.
        slope : callable
            Maps these columns, their slopes and their second derivatives to what has the sign of
            the quantity's slope, and to its slope.

        Returns
        -------
        ndarray, shape (n,)
            Values of the parameters.
        """

        def sloped(t: FloatArray, of: IntArray) -> tuple[FloatArray, FloatArray]:
            return slope(*self._values(of, t, columns, (0, 1, 2)))

        t, top = self.sample_places[of], np.argmax(sampled, axis=1)
        rows = np.arange(len(of))
        found = t[rows, top]
        # At an end it may still be inside by less than a sample.
        low, high = t[rows, np.maximum(top - 1, 0)], t[rows, np.minimum(top + 1, SAMPLES - 1)]
        before, after = sloped(np.append(low, high), np.tile(of, 2))[0].reshape(2, -1)
        inside = np.flatnonzero(before * after < 0.0)
        if len(inside):
            found[inside] = bracketed_root(sloped, low[inside], high[inside], of[inside])
        return found

    def turning_points(self) -> FloatArray:
        """Values of the parameters from which on x0 no longer increases; NaN if it always does."""
        turns, of = np.full(len(self.pieces), np.nan), np.flatnonzero(~self.by_x0)
        slopes = np.empty((len(self.pieces), SAMPLES))
        for row in of:
            states = self.pieces[row].states
            slopes[row] = even_derivative(len(states), SAMPLES) @ states.x0
        turns[of] = self.first(of, -slopes, np.zeros(len(of)), displacement, derivative=1)
        return turns


def displacement(level: FloatArray) -> Mapping[str, float]:
    """Linear form of states, see `Form`: their displacement."""
    return {"x0": 1.0}
