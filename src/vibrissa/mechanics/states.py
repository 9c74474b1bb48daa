"""States of rods: shapes with their contact forces, and loads on the clamp."""

from dataclasses import dataclass
from functools import lru_cache
from typing import Any, TypeAlias

import numpy as np

from vibrissa.mechanics.mounting import (
    BORE,
    CLAMP_ANGLE,
    CLAMP_COMPLIANCE,
    CLAMP_SLOPE,
    CURVATURE,
    POWERS,
    THETA,
    polynomial,
)
from vibrissa.mechanics.taper import (
    Making,
    arc_length,
    arc_length_growth,
    densities,
    density_growth,
    stiffness_factor,
    stiffness_growth,
)
from vibrissa.numerics.arrays import BoolArray, FloatArray
from vibrissa.numerics.batch import Batch
from vibrissa.numerics.spectral import gauss_rule, legendre_series

# A column of a batch, or one number for a single state.
Values: TypeAlias = Any
# Unknowns besides the slopes: fx, fy and s_c.
SCALARS = 3


@dataclass(frozen=True, eq=False, kw_only=True)
class RodStates(Batch):
    """A batch of equilibria, or of guesses for them.

    Attributes
    ----------
    rods : ndarray, shape (n, 12 + k)
        Properties of each rod (`vibrissa.mechanics.mounting.rod_columns`).
    unknowns : ndarray, shape (n, nodes + 3)
        Slopes φ (rad) at the Gauss nodes in τ between clamp and contact point; contact force
        fx = f·sin α and fy = −f·cos α (E·I0/L²) on the rod; arc length s_c of the contact
        point (L).
    line : ndarray of bool, shape (n,)
        Whether the rod is in line contact and touches tangentially at s_c; otherwise only its tip
        touches.
    """

    rods: FloatArray
    unknowns: FloatArray
    line: BoolArray

    @property
    def nodes(self) -> int:
        """Number of collocation nodes between clamp and contact point."""
        return int(self.unknowns.shape[-1]) - SCALARS

    @property
    def theta(self) -> FloatArray:
        """Taper factor."""
        return self.rods[..., THETA]

    @property
    def clamp_angle(self) -> FloatArray:
        """Inclination β of the clamp (rad)."""
        return self.rods[..., CLAMP_ANGLE]

    @property
    def clamp_compliance(self) -> FloatArray:
        """Compliance c of the clamp (L/(E·I0))."""
        return self.rods[..., CLAMP_COMPLIANCE]

    @property
    def curvature(self) -> FloatArray:
        """Coefficients of the natural curvature, shape (n, k); k = 0 if all rods are straight."""
        return self.rods[..., CURVATURE]

    @property
    def making(self) -> Making | None:
        """Bores and moduli as columns of shape (n, 1); None if all rods are solid, of one material.

        Coefficients that are zero for all rods are left out.
        """
        if not self.rods[:, BORE : POWERS.stop].any():
            return None
        powers = self.rods[:, POWERS]
        count = int(np.append(0, np.flatnonzero(powers.any(axis=0)) + 1)[-1])
        return Making(bore=self.rods[:, BORE, None], powers=tuple(powers.T[:count, :, None]))

    @property
    def phi(self) -> FloatArray:
        """Slopes at the nodes (rad), shape (n, nodes)."""
        return self.unknowns[..., :-SCALARS]

    @property
    def fx(self) -> FloatArray:
        """Contact force along the surface (E·I0/L²)."""
        return self.unknowns[..., -3]

    @property
    def fy(self) -> FloatArray:
        """Contact force normal to the surface (E·I0/L²), negative where the rod presses on it."""
        return self.unknowns[..., -2]

    @property
    def s_c(self) -> FloatArray:
        """Arc length of the contact point (L)."""
        return self.unknowns[..., -1]

    def on_nodes(self, nodes: int) -> "RodStates":
        """Interpolate the slopes to another number of nodes."""
        return self.with_unknowns(self.unknowns @ transfer(self.nodes, nodes))

    def with_unknowns(self, unknowns: FloatArray) -> "RodStates":
        """Replace the unknowns; rods and kinds of contact stay the same."""
        return RodStates(rods=self.rods, unknowns=unknowns, line=self.line)

    def densities(self, tau: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Evaluate ds/dτ (L) and B⁻¹·ds/dτ (L/(E·I0)) at `tau`, each of shape (n, len(tau))."""
        theta, s_c = self.theta[:, None], self.s_c[:, None]
        arc, compliance = densities(tau, theta, s_c)
        if (making := self.making) is not None:
            compliance = compliance / stiffness_factor(self.arc_length(tau), theta, making)
        return arc, compliance

    def density_growth(self, tau: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return ∂/∂s_c of the logarithms of both `densities` at a fixed τ, in 1/L."""
        theta, s_c = self.theta[:, None], self.s_c[:, None]
        arc, compliance = density_growth(tau, theta, s_c)
        if (making := self.making) is not None:
            growth = stiffness_growth(self.arc_length(tau), theta, making)
            compliance = compliance - growth * arc_length_growth(tau, theta, s_c)
        return arc, compliance

    def arc_length(self, tau: FloatArray) -> FloatArray:
        """Arc length at the bending coordinates `tau` (L), shape (n, len(tau))."""
        return arc_length(tau, self.theta[:, None], self.s_c[:, None])

    def natural_slope(self, tau: FloatArray) -> FloatArray:
        """Slope of the unloaded rod at `tau`, π/2 + β + ∫₀ˢ κ0 du (rad).

        The shape is (n, len(tau)), or (n, 1) if all rods are straight.
        """
        upright = CLAMP_SLOPE + self.clamp_angle[:, None]
        if not self.curvature.shape[1]:
            return upright
        s = self.arc_length(tau)
        return upright + s * polynomial(
            self.curvature / np.arange(1, self.curvature.shape[1] + 1), s
        )


@lru_cache
def transfer(nodes: int, other: int) -> FloatArray:
    """Matrix that interpolates unknowns from `nodes` to `other` nodes: ``unknowns @ matrix``."""
    matrix = np.eye(nodes + SCALARS, other + SCALARS, k=other - nodes)
    if nodes != other:
        matrix[:, :other] = 0.0
        values, _ = legendre_series(nodes, gauss_rule(other).nodes)
        matrix[:nodes, :other] = (values @ gauss_rule(nodes).to_coefficients).T
    matrix.flags.writeable = False
    return matrix


@dataclass(frozen=True, eq=False, kw_only=True)
class ContactLoads(Batch):
    """Loads and contact of one equilibrium, or of many.

    Attributes
    ----------
    reaction_fx, reaction_fy, reaction_m : ndarray or float
        Reading of a force-torque sensor under the clamp: f·sin α, −f·cos α (E·I0/L²) and
        m(0) (E·I0/L).
    phi1 : ndarray or float
        Slope at the contact point, in rad.
    s_c : ndarray or float
        Arc length of the contact point, in units of L; 1 in point contact.
    """

    reaction_fx: Values
    reaction_fy: Values
    reaction_m: Values
    phi1: Values
    s_c: Values

    @property
    def f(self) -> Values:
        """Magnitude of the contact force, in units of E·I0/L²."""
        return np.hypot(self.reaction_fx, self.reaction_fy)

    @property
    def alpha(self) -> Values:
        """Inclination of the contact force, in rad."""
        return np.arctan2(self.reaction_fx, -self.reaction_fy)

    @property
    def mobilised_friction(self) -> Values:
        """Mobilised friction −tan α; infinite where fy = 0."""
        with np.errstate(divide="ignore", invalid="ignore"):
            # The surface cannot pull: at lift-off fy may be positive by rounding.
            return self.reaction_fx / -np.maximum(0.0 - self.reaction_fy, 0.0)


@dataclass(frozen=True, eq=False, kw_only=True)
class ContactState(ContactLoads):
    """Loads, contact and stability of one equilibrium, or of many; see also `ContactLoads`.

    Attributes
    ----------
    stability : ndarray or float
        Margin of stability in the plane (`vibrissa.mechanics.stability`): positive where the
        equilibrium is stable; NaN if the solver was shooting.
    stability_aside : ndarray or float
        Margin out of the plane (`vibrissa.mechanics.lateral`): positive where the rod stays in its
        plane; NaN if the solver was shooting, and for a planar section.
    """

    stability: Values
    stability_aside: Values
