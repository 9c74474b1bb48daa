"""Smooth pieces of a sticking curve, and the one search for where something happens on them."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from vibrissa.mechanics.states import ContactState, Values
from vibrissa.numerics.arrays import FloatArray
from vibrissa.numerics.roots import bracketed_root
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


@dataclass(frozen=True, eq=False, kw_only=True)
class StickingState(ContactState):
    """One or many equilibria on the way of the clamp while the tip sticks.

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
    def _series(self) -> tuple[Any, Any, Any]:
        """Splines, or Chebyshev coefficients, of the columns and of two derivatives."""
        values = self.states.matrix()
        if self.stepped:
            # Not needed, and not waited for, where states are not stepped.
            from scipy.interpolate import make_interp_spline

            degree = min(SPLINE_DEGREE, len(values) - 1)
            # The margins of stability are not known on a step grid.
            spline = make_interp_spline(self.states.x0, np.nan_to_num(values), k=degree)
            return spline, spline.derivative(), spline.derivative(2)
        derivative = chebyshev_derivative(len(values)) * (2.0 / (self.stop - self.start))
        value = chebyshev_transform(len(values)) @ values
        slope = derivative @ value
        return value, slope, derivative @ slope

    def _interpolant(
        self, names: Sequence[str], orders: Sequence[int]
    ) -> Callable[[FloatArray], FloatArray]:
        """Interpolant of some columns' derivatives of some orders, up to 2.

        It maps values of the parameter, shape (n,), to an array (orders, columns, n).
        """
        all_names = StickingState.names()
        index = [all_names.index(name) for name in names]
        shape = len(orders), len(names), -1
        if self.stepped:
            splines = [self._series[order] for order in orders]
            return lambda t: np.stack([spline(t).T[index] for spline in splines]).reshape(shape)
        # Side by side, as one evaluation serves all.
        series = np.hstack([self._series[order][:, index] for order in orders])
        return lambda t: chebyshev_series(series, self._position(t)).T.reshape(shape)

    def _position(self, t: FloatArray) -> FloatArray:
        """Place on [-1, 1] of values of the parameter."""
        return 2.0 * (t - self.start) / (self.stop - self.start) - 1.0

    def at(self, t: FloatArray) -> StickingState:
        """States at values of the parameter on the piece."""
        series = self._series[0]
        matrix = series(t) if self.stepped else chebyshev_series(series, self._position(t))
        states = StickingState.from_matrix(matrix)
        # No margin exceeds 1, but between the states the interpolant may.
        exact = {name: np.minimum(getattr(states, name), 1.0) for name in MARGINS}
        exact["s_c"] = np.ones(t.shape)
        if self.contact is Contact.LINE:
            exact |= {"s_c": np.minimum(states.s_c, 1.0), "phi1": np.zeros(t.shape)}
        if self.parameter is Parameter.X0:
            exact["x0"] = t
        if self.stepped:
            exact |= dict.fromkeys(MARGINS, np.full(t.shape, np.nan))
        return replace(states, **exact)

    def at_x0(self, x0: FloatArray) -> StickingState:
        """States at displacements on the piece."""
        if self.parameter is Parameter.X0:
            return self.at(x0)
        # Pieces meet up to rounding.
        levels = np.minimum(x0, self.samples.x0[-1])
        return self.at(self.first(self.samples.x0, levels, _displacement, value=levels))

    @cached_property
    def sample_places(self) -> FloatArray:
        """Equally spaced values of the parameter, both ends included, shape (SAMPLES,)."""
        return np.linspace(self.start, self.stop, SAMPLES)

    @cached_property
    def samples(self) -> StickingState:
        """States at `sample_places`, good enough to bracket crossings."""
        if self.stepped:
            return self.at(self.sample_places)
        matrix = even_interpolation(len(self.states), SAMPLES)
        return StickingState.from_matrix(matrix @ self.states.matrix())

    def restricted(self, stop: float) -> "Piece":
        """Cut the piece off at a value of its parameter."""
        t = self.start + (stop - self.start) * chebyshev_nodes(len(self.states))
        return replace(self, stop=stop, states=self.at(t))

    def first(
        self,
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
        sampled : ndarray, shape (samples,)
            The quantity at `places`; it may fall again behind a level.
        levels : ndarray, shape (n,)
        form : callable
            Maps levels to the weights of columns in a sum that has a certain value where the
            quantity reaches the level.
        value : ndarray, shape (n,), or float
            That value.
        places : ndarray, shape (samples,), optional
            Increasing values of the parameter, by default `sample_places`.
        derivative : int
            Which derivative of the states the form is taken of.

        Returns
        -------
        ndarray, shape (n,)
            Values of the parameter; NaN where no sample reaches the level.
        """
        t = self.sample_places if places is None else places
        after = np.searchsorted(np.maximum.accumulate(sampled), levels)
        found = np.full(levels.shape, np.nan)
        found[after == 0] = t[0]
        inside = (after > 0) & (after < len(t))
        if not inside.any():
            return found
        after, value = after[inside], np.broadcast_to(value, levels.shape)[inside]
        low, below, above = t[after - 1], sampled[after - 1], sampled[after]
        with np.errstate(divide="ignore", invalid="ignore"):
            share = np.clip((levels[inside] - below) / (above - below), 0.0, 1.0)

        weights = form(levels[inside])
        interpolant = self._interpolant(tuple(weights), (derivative, derivative + 1))

        def excess(
            t: FloatArray, value: FloatArray, *weights: FloatArray
        ) -> tuple[FloatArray, FloatArray]:
            weighted = np.array(weights)
            total, slope = (interpolant(t) * weighted).sum(axis=1)
            return total - value, slope

        guess = low + np.nan_to_num(share) * (t[after] - low)
        each = [np.broadcast_to(weight, value.shape) for weight in weights.values()]
        found[inside] = bracketed_root(excess, low, t[after], value, *each, guess=guess)
        return found

    def largest(
        self,
        sampled: FloatArray,
        columns: Sequence[str],
        slope: Slope,
    ) -> float:
        """Find where a quantity is largest.

        Parameters
        ----------
        sampled : ndarray, shape (SAMPLES,)
            The quantity at `sample_places`.
        columns : sequence of str
            What the quantity depends on.
        slope : callable
            Maps these columns, their slopes and their second derivatives to what has the sign of
            the quantity's slope, and to its slope.

        Returns
        -------
        float
            Value of the parameter.
        """
        interpolant = self._interpolant(columns, (0, 1, 2))

        def sloped(t: FloatArray) -> tuple[FloatArray, FloatArray]:
            return slope(*interpolant(t))

        t, top = self.sample_places, int(np.argmax(sampled))
        # At an end it may still be inside by less than a sample.
        around = t[[max(top - 1, 0), min(top + 1, SAMPLES - 1)]]
        before, after = sloped(around)[0]
        if before * after < 0.0:
            return float(bracketed_root(sloped, around[:1], around[1:])[0])
        return float(t[top])

    def turning_point(self) -> float:
        """Value of the parameter from which on x0 no longer increases; NaN if it always does."""
        slopes = even_derivative(len(self.states), SAMPLES) @ self.states.x0
        return float(self.first(-slopes, np.zeros(1), _displacement, derivative=1)[0])


def _displacement(level: FloatArray) -> Mapping[str, float]:
    return {"x0": 1.0}
