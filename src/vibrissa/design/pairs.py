"""Pairs (θ, η), each solved once for all sizes of rods.

Lengths are in L, forces in E·I0/L², moments in E·I0/L and strains in d0/L.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from vibrissa.design.sensitivity import Sensitivity, sensitivity_of
from vibrissa.errors import NoResponseError
from vibrissa.numerics.arrays import FloatArray
from vibrissa.outcomes import Contact, Status
from vibrissa.sensor.response.branch import Response, tabulated
from vibrissa.sensor.strain import STATES, strains_in
from vibrissa.sticking.curve import StickingCurve
from vibrissa.sticking.solving.collocation import solve_curves

# States of a period among which the largest reactions are sought.
PLACES = np.linspace(0.0, 1.0, 129)


@dataclass(frozen=True, eq=False, kw_only=True)
class Pair:
    """A pair (θ, η) and its longest period of sticking, nondimensional.

    The longest period ends where the tip slips at the largest of the k friction coefficients, or
    where it locks.

    Attributes
    ----------
    x0_slip : ndarray, shape (k,)
        Onset of slip for each friction coefficient (L); NaN where the tip locks.
    longest : float
        Length of the longest period (L).
    strain : float
        Largest strain in it (d0/L).
    """

    response: Response
    contact: Contact
    x0_slip: FloatArray
    longest: float
    strain: float

    @property
    def curve(self) -> StickingCurve:
        """Sticking curve."""
        return self.response.curve

    @cached_property
    def reactions(self) -> FloatArray:
        """Reactions fx, fy and m in the longest period, shape (n, 3)."""
        return self.response(self.longest * PLACES)

    @cached_property
    def least_slope(self) -> FloatArray:
        """Derivatives of fx and fy with respect to x0 where the sum of their squares is least."""
        slopes = self.response.slope(self.longest * PLACES)[:, :2]
        return np.asarray(slopes[np.argmin((slopes**2).sum(axis=1))])

    @cached_property
    def demand_slope(self) -> FloatArray:
        """Growth of the demand −tan α with x0 at each onset (1/L)."""
        return self.response.demand_slope(self.x0_slip)

    @cached_property
    def sensitivity(self) -> Sensitivity:
        """Sensitivity of the friction, in a period that locks up to the lock."""
        end = np.where(np.isfinite(self.x0_slip), self.x0_slip, self.response.x0_lock)
        return sensitivity_of(self.response, end, self.contact)


def survey(
    theta: FloatArray, eta: FloatArray, frictions: FloatArray, contact: Contact
) -> list[Pair]:
    """Solve pairs (θ, η) at k increasing friction coefficients; leave out those without a curve.

    Raises
    ------
    NoResponseError
        If no pair could be solved.
    """
    curves = solve_curves(theta, eta, contact)
    solved = [curve for curve in curves if curve.status is Status.SOLVED]
    if not solved:
        raise NoResponseError(f"no such rod could be solved: {curves[0].message}")
    onsets = [curve.onset(frictions) for curve in solved]
    ends = [
        float(x0[-1]) if np.isfinite(x0[-1]) else curve.x0_lock
        for curve, x0 in zip(solved, onsets, strict=True)
    ]
    largest = strains_in(solved, [np.linspace(0.0, end, STATES) for end in ends]).strain
    strain = largest.reshape(len(solved), STATES).max(axis=1)
    return [
        Pair(
            response=tabulated(curve),
            contact=contact,
            x0_slip=x0_slip,
            longest=end,
            strain=float(most),
        )
        for curve, x0_slip, end, most in zip(solved, onsets, ends, strain, strict=True)
    ]
