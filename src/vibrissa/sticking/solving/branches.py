"""Branches of equilibria: their rods, their α = 0 states, and the conditions along them."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from vibrissa.mechanics.equations import ClosingCondition, ends
from vibrissa.mechanics.states import RodStates
from vibrissa.numerics.arrays import FloatArray
from vibrissa.numerics.batch import Batch

# Weights of fx and fy, relative to the offset, in the length of a path.
WEIGHT_OF_FX, WEIGHT_OF_FY = 0.3, 0.1


@dataclass(frozen=True, eq=False, kw_only=True)
class Branches(Batch):
    """Branches of equilibria: their rods, and quantities of the α = 0 states in which they begin.

    Attributes
    ----------
    rods : ndarray, shape (n, 3 + k)
        Properties of the rods, as in `vibrissa.mechanics.states.RodStates`.
    eta : ndarray, shape (n,)
        Height η of the contact point in the α = 0 state (L).
    tilt : ndarray, shape (n,)
        tan δ of the clamp's path.
    x1_init : ndarray, shape (n,)
        Contact point in the α = 0 state, with the clamp at x = 0 (L).
    scale, force : ndarray, shape (n,)
        Position x1 of the contact point (L) and contact force f (E·I0/L²) in the α = 0 state of the
        same rod in the ideal mounting. They scale the path coordinates (`coordinates`).
    """

    rods: FloatArray
    eta: FloatArray
    tilt: FloatArray
    x1_init: FloatArray
    scale: FloatArray
    force: FloatArray

    @property
    def cos(self) -> FloatArray:
        """Cosine of the stage angle δ."""
        return 1.0 / np.hypot(1.0, self.tilt)

    @property
    def units(self) -> FloatArray:
        """Factors that turn offset, fx, fy and s_c into path coordinates, shape (n, 4)."""
        fx, fy = WEIGHT_OF_FX / self.force, WEIGHT_OF_FY / self.force
        return np.array([-1.0 / self.scale, fx, fy, np.ones_like(fx)]).T

    def coordinates(self, states: RodStates) -> FloatArray:
        """Path coordinates of states: scaled offset x1 − x0, fx, fy and s_c, shape (n, 4).

        Lengths and directions of paths are measured in these coordinates.
        """
        return self.units * end_quantities(states)

    def along(self, direction: FloatArray, value: FloatArray) -> ClosingCondition:
        """Prescribe the component of the path coordinates along a direction (equation E3c).

        The unit vectors `direction` have the shape (n, 4). `value` is the continuation parameter.
        """
        return self.prescribing(dict(enumerate((self.units * direction).T)), value)

    def prescribing(
        self, weights: Mapping[int, FloatArray | float], value: FloatArray | float = 0.0
    ) -> ClosingCondition:
        """Prescribe, as E3, a weighted sum of offset, fx, fy, s_c and φ1; E2 prescribes the height.

        The keys of `weights` are indices of these quantities, such as FX and PHI1: fx = 0 is the
        condition for α = 0, and φ1 = 0 that for a kink of the path.
        """
        height = self.eta - self.tilt * self.x1_init
        return ClosingCondition.prescribing(height, weights, value, self.tilt)


def end_quantities(states: RodStates) -> FloatArray:
    """Offset x1 − x0 (L), fx, fy (E·I0/L²) and s_c (L) of states, shape (n, 4)."""
    return np.array([ends(states).offset, states.fx, states.fy, states.s_c]).T


def violation(states: RodStates) -> FloatArray:
    """Violation of s_c ≤ 1 (L) in line contact, or of φ1 ≥ 0 (rad) in point contact.

    A positive value means that this kind of contact is impossible.
    """
    return np.where(states.line, states.s_c - 1.0, -ends(states).phi1)
