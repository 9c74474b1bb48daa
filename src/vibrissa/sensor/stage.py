"""A rod on its stage, which moves at an angle δ to the surface.

With the clamp at X, the height is

    h(X) = η − X·sin δ,

and a tip at the position x_c has the displacement from the α = 0 state of that height

    x0(X) = x1_init(h) + side·(X·cos δ − x_c),

where side is 1 for a tip ahead of the clamp, and −1 for a tip behind it (mirrored states).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from vibrissa.numerics.arrays import FloatArray
from vibrissa.sensor.response.branch import Response
from vibrissa.sensor.response.heights import HeightRange, HeightStates


@dataclass(frozen=True, eq=False, kw_only=True)
class Stage:
    """A rod on a stage that moves along the surface, or at an angle to it.

    Attributes
    ----------
    rod : Response or HeightRange
        Response at the one height of a level stage, or at all heights that an oblique stage passes.
    eta : float
        Height with the clamp at 0 (L).
    angle : float
        δ (rad), positive where the clamp approaches the surface.
    """

    rod: Response | HeightRange
    eta: float
    angle: float = 0.0

    def height(self, clamp: ArrayLike) -> FloatArray:
        """Height of the surface above the clamp (L)."""
        return np.asarray(self.eta - np.asarray(clamp) * np.sin(self.angle))

    def along(self, clamp: ArrayLike) -> FloatArray:
        """Position along the surface (L)."""
        return np.asarray(np.asarray(clamp) * np.cos(self.angle))

    def at(self, clamp: ArrayLike) -> Response | HeightStates:
        """States at the heights of clamp positions."""
        rod = self.rod
        return rod if isinstance(rod, Response) else rod.states(self.height(clamp))

    def states(
        self, clamp: ArrayLike, contact: ArrayLike, side: ArrayLike
    ) -> tuple[Response | HeightStates, FloatArray]:
        """States that a tip at a place has at clamp positions, and its displacements (L)."""
        states = self.at(clamp)
        ahead = self.along(clamp) - np.asarray(contact)
        return states, np.asarray(states.x1_init + np.asarray(side) * ahead)
