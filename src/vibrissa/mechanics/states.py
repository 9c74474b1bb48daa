"""States of the rod: its shape, the contact force that bends it, and what is seen of both."""

from dataclasses import dataclass, replace
from typing import Any, Self, TypeAlias

import numpy as np

from vibrissa.mechanics.mounting import Mountings
from vibrissa.mechanics.taper import arc_density, arc_length, densities
from vibrissa.numerics.arrays import FloatArray, Index
from vibrissa.numerics.batch import Batch
from vibrissa.numerics.spectral import refinement_matrix

# The columns of states that the equations determine; the others are given.
UNKNOWNS = ("phi", "fx", "fy", "s_c")
# A column of a batch, or a number where there is one state alone.
Values: TypeAlias = Any


@dataclass(frozen=True, eq=False, kw_only=True)
class RodStates(Batch):
    """The unknowns of equilibrium for a batch of rods: shapes with their contact forces.

    Attributes
    ----------
    theta : ndarray, shape (n,)
        Taper factors.
    phi : ndarray, shape (n, nodes)
        Slope angle at the Gauss nodes in τ on the free part, in rad.
    fx, fy : ndarray, shape (n,)
        Contact force on the rod, in units of E·I0/L²; f·sin α and −f·cos α.
    s_c : ndarray, shape (n,)
        Arc length of the contact point, in units of L.
    mounting : Mountings or None
        Clamp and natural shape of each rod; None where all are as in the paper.
    """

    theta: FloatArray
    phi: FloatArray
    fx: FloatArray
    fy: FloatArray
    s_c: FloatArray
    mounting: Mountings | None = None

    @property
    def nodes(self) -> int:
        """Number of collocation nodes along the rod."""
        return int(self.phi.shape[-1])

    def on_nodes(self, nodes: int) -> Self:
        """Interpolate the slopes to another number of nodes."""
        return replace(self, phi=self.phi @ refinement_matrix(self.nodes, nodes)[1:-1].T)

    def unsolved(self) -> Self:
        """Return as many states of the same rods, all unknowns NaN."""
        columns = self.columns
        unknowns: dict[str, Any] = {n: np.full_like(columns[n], np.nan) for n in UNKNOWNS}
        return replace(self, **unknowns)

    def forget(self, index: Index) -> None:
        """Set the unknowns of some states to NaN, in place."""
        for name in UNKNOWNS:
            vars(self)[name][index] = np.nan

    def arc_length(self, tau: FloatArray) -> FloatArray:
        """Arc length at bending coordinates of the free part, shape (n, len(tau))."""
        return arc_length(tau, self.theta[:, None], self.s_c[:, None])

    def arc_density(self, tau: FloatArray) -> FloatArray:
        """Arc length per bending coordinate on the free part, shape (n, len(tau))."""
        return arc_density(tau, self.theta[:, None], self.s_c[:, None])

    def densities(self, tau: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Arc length and bending compliance per bending coordinate, each (n, len(tau))."""
        return densities(tau, self.theta[:, None], self.s_c[:, None])


@dataclass(frozen=True, eq=False, kw_only=True)
class ContactState(Batch):
    """What an equilibrium shows at the clamp and at the contact point, for one or many of them.

    Attributes
    ----------
    reaction_fx, reaction_fy, reaction_m : ndarray or float
        Reading of a force-torque sensor under the clamp: f·sin α, −f·cos α (E·I0/L²) and
        m(0) (E·I0/L).
    phi1 : ndarray or float
        Slope at the contact point, in rad.
    s_c : ndarray or float
        Arc length of the contact point, in units of L; 1 in point contact.
    stability : ndarray or float
        Smallest eigenvalue of the second variation of the energy, clamp and contact point held:
        positive where the equilibrium is stable; NaN where the method does not tell.
    stability_aside : ndarray or float
        The same out of the plane, of a rod with a round section; NaN also where the rod cannot
        leave its plane.
    """

    reaction_fx: Values
    reaction_fy: Values
    reaction_m: Values
    phi1: Values
    s_c: Values
    stability: Values
    stability_aside: Values

    @property
    def f(self) -> Values:
        """Magnitude of the contact force, in units of E·I0/L²."""
        return np.hypot(self.reaction_fx, self.reaction_fy)

    @property
    def alpha(self) -> Values:
        """Inclination of the contact force, in rad."""
        return np.arctan2(self.reaction_fx, -self.reaction_fy)

    @property
    def friction_demand(self) -> Values:
        """Friction coefficient −tan α that the contact needs to stick; infinite without load."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return self.reaction_fx / self.reaction_fy
