"""Branches of equilibria: what they belong to, and the conditions that hold along them."""

from dataclasses import dataclass, replace

import numpy as np

from vibrissa.mechanics.equations import Closure, contact_position, path_coordinates
from vibrissa.mechanics.states import RodStates
from vibrissa.numerics.arrays import FloatArray
from vibrissa.numerics.batch import Batch
from vibrissa.outcomes import Contact


@dataclass(frozen=True, eq=False, kw_only=True)
class Branches(Batch):
    """A batch of branches: what they belong to and the α = 0 states in which they begin.

    Attributes
    ----------
    theta, eta : ndarray, shape (n,)
        Taper factors and heights of the surface (L).
    x1_init : ndarray, shape (n,)
        Contact point in the α = 0 state, with the clamp at x = 0 (L).
    scale, force : ndarray, shape (n,)
        Contact point (L) and contact force (E·I0/L²) in the α = 0 state of the same rod in the
        ideal mounting: the units in which the way along a branch is measured.
    stage_angle : ndarray, shape (n,), or None
        Angle δ of the clamp's way to the surface (rad); None where it moves along the surface.
    """

    theta: FloatArray
    eta: FloatArray
    x1_init: FloatArray
    scale: FloatArray
    force: FloatArray
    stage_angle: FloatArray | None = None

    @property
    def height(self) -> FloatArray:
        """Right side of E2."""
        if self.stage_angle is None:
            return self.eta
        return self.eta - np.tan(self.stage_angle) * self.x1_init

    def tilted(self, closure: Closure) -> Closure:
        """Conditions with E2 for the way of the clamp."""
        if self.stage_angle is None:
            return closure
        return replace(closure, tilt=np.tan(self.stage_angle))

    def at_x0(self, x0: FloatArray, contact: Contact = Contact.POINT) -> Closure:
        """Conditions that hold after displacements of the clamp."""
        along = x0 if self.stage_angle is None else x0 * np.cos(self.stage_angle)
        return self.tilted(Closure.at_offset(self.x1_init - along, contact))

    def at_advance(
        self, advance: FloatArray, direction: FloatArray, contact: Contact = Contact.POINT
    ) -> Closure:
        """Conditions that hold so far along a direction."""
        closure = Closure.at_advance(advance, direction, self.scale, self.force, contact)
        return self.tilted(closure)

    def coordinates(self, states: RodStates) -> FloatArray:
        """Coordinates in which the way along a branch is measured, shape (n, 4)."""
        offset, _ = contact_position(states)
        return path_coordinates(offset, states, self.scale, self.force)

    def x0(self, states: RodStates) -> FloatArray:
        """Displacement of the clamp in given states (L)."""
        return self.displacement(contact_position(states)[0])

    def displacement(self, offset: FloatArray) -> FloatArray:
        """Displacement of the clamp (L) by the offset of the contact point."""
        x0 = self.x1_init - offset
        return x0 if self.stage_angle is None else x0 / np.cos(self.stage_angle)

    @property
    def x0_unit(self) -> FloatArray:
        """Displacement of the clamp for each unit of the first coordinate (L)."""
        return self.scale if self.stage_angle is None else self.scale / np.cos(self.stage_angle)
