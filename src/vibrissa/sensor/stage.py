"""A rod on its stage, which moves at an angle δ to the surface.

With the clamp at X, the height is

    h(X) = η − X·sin δ,

and a tip at the position x_c has the displacement from the α = 0 state of that height

    x0(X) = x1_init(h) + side·(X·cos δ − x_c),

where side is 1 for a tip ahead of the clamp, and −1 for a tip behind it (mirrored states).
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from vibrissa.numerics.arrays import FloatArray
from vibrissa.sensor.response.branch import Branch, Response
from vibrissa.sensor.response.heights import HeightRange, HeightStates


@dataclass(frozen=True, eq=False, kw_only=True)
class LevelStage:
    """A rod on a stage that moves along the surface, δ = 0."""

    response: Response

    @property
    def x1_init(self) -> float:
        """Contact point in the α = 0 state, with the clamp at 0 (L)."""
        return self.response.x1_init

    @property
    def swings(self) -> bool:
        """Whether a tip that locks is dragged in the end; see `Branch`."""
        return self.response.swings

    def along(self, clamp: ArrayLike) -> FloatArray:
        """Position along the surface (L)."""
        return np.asarray(clamp)

    def branch(self, clamp: float) -> Branch:
        """Branch at the height of a clamp position."""
        return self.response

    def states(
        self, clamp: ArrayLike, contact: ArrayLike, side: ArrayLike
    ) -> tuple[Branch, FloatArray]:
        """States that a tip at a place has at clamp positions, and its displacements (L)."""
        return self.response, _displaced(self.response.x1_init, clamp, contact, side)


@dataclass(frozen=True, eq=False, kw_only=True)
class ObliqueStage:
    """A rod on a stage that moves at an angle to the surface.

    Attributes
    ----------
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

    @property
    def swings(self) -> bool:
        """Whether a tip that locks is dragged in the end; see `Branch`."""
        return self.heights.swings

    def height(self, clamp: ArrayLike) -> FloatArray:
        """Height of the surface above the clamp (L)."""
        return np.asarray(self.eta - np.asarray(clamp) * np.sin(self.angle))

    def along(self, clamp: ArrayLike) -> FloatArray:
        """Position along the surface (L)."""
        return np.asarray(np.asarray(clamp) * np.cos(self.angle))

    def branch(self, clamp: float) -> Branch:
        """Branch at the height of a clamp position."""
        return self.heights.at(float(self.height(clamp)))

    def states(
        self, clamp: ArrayLike, contact: ArrayLike, side: ArrayLike
    ) -> tuple[HeightStates, FloatArray]:
        """States that a tip at a place has at clamp positions, and its displacements (L)."""
        states = self.heights.states(self.height(clamp))
        return states, _displaced(states.x1_init, self.along(clamp), contact, side)


def _displaced(
    x1_init: ArrayLike, along: ArrayLike, contact: ArrayLike, side: ArrayLike
) -> FloatArray:
    return np.asarray(x1_init + np.asarray(side) * (np.asarray(along) - np.asarray(contact)))
