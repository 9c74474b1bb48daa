"""Shapes of the rod along a smooth piece of an equilibrium path: evaluated, not integrated."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from vibrissa.mechanics.states import RodStates
from vibrissa.numerics.arrays import FloatArray, IntArray
from vibrissa.numerics.spectral import interpolation


class RowStates(NamedTuple):
    """States of the rod for some rows of a larger array."""

    rows: IntArray
    states: RodStates


@dataclass(frozen=True, eq=False, kw_only=True)
class ShapesAlongPiece:
    """Solved states of the rod at the Chebyshev points of one piece.

    Attributes
    ----------
    rod : ndarray, shape (3 + k,)
        Properties of the rod (`vibrissa.mechanics.mounting.rod_columns`).
    unknowns : ndarray, shape (states, nodes + 3)
        Unknowns of each state, as in `vibrissa.mechanics.states.RodStates`.
    line : bool
        Whether the rod is in line contact.
    first, last : float
        Values of the continuation parameter of the first and of the last state.
    """

    rod: FloatArray
    unknowns: FloatArray
    line: bool
    first: float
    last: float

    def states(self, t: FloatArray) -> RodStates:
        """Interpolate the states at values of the continuation parameter, shape (n,)."""
        position = (t - self.first) / (self.last - self.first)
        return RodStates(
            rods=np.tile(self.rod, (len(t), 1)),
            unknowns=interpolation(len(self.unknowns), position) @ self.unknowns,
            line=np.full(len(t), self.line),
        )
