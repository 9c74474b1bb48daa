"""Shapes of the rod along a smooth piece of an equilibrium path: evaluated, not integrated."""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from vibrissa.mechanics.lateral import lateral_stability
from vibrissa.mechanics.stability import stability
from vibrissa.mechanics.states import SCALARS, RodStates
from vibrissa.numerics.arrays import BoolArray, FloatArray, IntArray
from vibrissa.numerics.spectral import chebyshev_interpolation, chebyshev_transform, interpolation

# Share of the nodes on which the margins of stability are computed, and the fewest nodes.
STABILITY_NODES, FEWEST_STABILITY_NODES = 0.45, 14


class RowStates(NamedTuple):
    """States of the rod for some rows of a larger array."""

    rows: IntArray
    states: RodStates


@dataclass(frozen=True, eq=False, kw_only=True)
class SolvedParts:
    """Solved states of rods at the Chebyshev points of smooth parts that were solved together.

    Attributes
    ----------
    rods : ndarray, shape (parts, 3 + k)
        Properties of the rod of each part (`vibrissa.mechanics.mounting.rod_columns`).
    unknowns : ndarray, shape (parts, states, nodes + 3)
        Unknowns of each state, as in `vibrissa.mechanics.states.RodStates`.
    line : ndarray of bool, shape (parts,)
        Whether the rod is in line contact.
    round_rods : bool
        Whether the sections are round, so that the rods may buckle laterally.
    """

    rods: FloatArray
    unknowns: FloatArray
    line: BoolArray
    round_rods: bool

    @property
    def _count(self) -> int:
        """Number of states along each part from which the margins are computed."""
        return (self.unknowns.shape[1] + 1) // 2

    @property
    def _few(self) -> RodStates:
        """Half of the states, on fewer nodes."""
        _, states, columns = self.unknowns.shape
        chosen = chebyshev_interpolation(states, self._count) @ self.unknowns
        nodes = columns - SCALARS
        return RodStates(
            rods=np.repeat(self.rods, self._count, axis=0),
            unknowns=chosen.reshape(-1, columns),
            line=np.repeat(self.line, self._count),
        ).on_nodes(max(round(STABILITY_NODES * nodes), FEWEST_STABILITY_NODES))

    def _series(self, values: FloatArray) -> FloatArray:
        return values.reshape(-1, self._count) @ chebyshev_transform(self._count).T

    @cached_property
    def lateral_margins(self) -> FloatArray:
        """Chebyshev coefficients of `stability_aside` along each part, shape (parts, count).

        They are NaN for planar sections, and computed when they are asked for first.
        """
        few = self._few
        return self._series(
            lateral_stability(few) if self.round_rods else np.full(len(few), np.nan)
        )

    @cached_property
    def margins(self) -> FloatArray:
        """Chebyshev coefficients of `stability` and `stability_aside`, shape (parts, 2, count)."""
        return np.stack([self._series(stability(self._few)), self.lateral_margins], axis=1)


@dataclass(frozen=True, eq=False, kw_only=True)
class ShapesAlongPiece:
    """Shapes of the rod along one piece of a curve, a part of a path or a stretch of it.

    Attributes
    ----------
    parts : SolvedParts
        Solved states, also of other parts.
    row : int
        Index of the part.
    first, last : float
        Values of the continuation parameter of the first and of the last state.
    """

    parts: SolvedParts
    row: int
    first: float
    last: float

    @property
    def margins(self) -> FloatArray:
        """Chebyshev coefficients of both margins of stability, shape (2, count)."""
        return np.asarray(self.parts.margins[self.row])

    def fraction(self, t: FloatArray) -> FloatArray:
        """Fractions of the part at which the continuation parameter has the values t."""
        return np.asarray((t - self.first) / (self.last - self.first))

    def states(self, t: FloatArray) -> RodStates:
        """Interpolate the states at values of the continuation parameter, shape (n,)."""
        unknowns = self.parts.unknowns[self.row]
        return RodStates(
            rods=np.tile(self.parts.rods[self.row], (len(t), 1)),
            unknowns=interpolation(len(unknowns), self.fraction(t)) @ unknowns,
            line=np.full(len(t), self.parts.line[self.row]),
        )
