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
    """A batch of branches, each with the α = 0 state in which it begins.

    Attributes
    ----------
    tilt : ndarray, shape (n,)
        tan δ of the clamp's path.
    x1_init : ndarray, shape (n,)
        Contact point in the α = 0 state, with the clamp at x = 0 (L).
    scale, force : ndarray, shape (n,)
        Contact point (L) and contact force (E·I0/L²) in the α = 0 state of the same rod in the
        ideal mounting: the units in which the length of a path is measured.
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
        """Factors from offset, fx, fy and s_c to path coordinates, shape (n, 4)."""
        fx, fy = WEIGHT_OF_FX / self.force, WEIGHT_OF_FY / self.force
        return np.stack([-1.0 / self.scale, fx, fy, np.ones_like(fx)], axis=1)

    def coordinates(self, states: RodStates) -> FloatArray:
        """Coordinates of states, in which the length of a path is measured, shape (n, 4)."""
        return self.units * end_quantities(states)

    def along(self, direction: FloatArray, value: FloatArray) -> ClosingCondition:
        """Prescribe the continuation parameter along a direction, shape (n, 4): E3c."""
        return self.prescribing(dict(enumerate((self.units * direction).T)), value)

    def prescribing(
        self, weights: Mapping[int, FloatArray | float], value: FloatArray | float = 0.0
    ) -> ClosingCondition:
        """Prescribe a weighted sum as E3, beside E2: fx for α = 0, φ1 at a kink."""
        height = self.eta - self.tilt * self.x1_init
        return ClosingCondition.prescribing(height, weights, value, self.tilt)


def end_quantities(states: RodStates) -> FloatArray:
    """Offset, fx, fy and s_c of states, shape (n, 4)."""
    return np.stack([ends(states).offset, states.fx, states.fy, states.s_c], axis=1)


def violation(states: RodStates) -> FloatArray:
    """Violation of s_c ≤ 1 (L) or φ1 ≥ 0 (rad), positive if the contact is impossible."""
    return np.where(states.line, states.s_c - 1.0, -ends(states).phi1)
