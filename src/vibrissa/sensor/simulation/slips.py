"""Slip laws: where a slip ends, by the balance of forces or of energy along the path of the tip.

The clamp rests, and x0 falls (in retraction it rises). The integral of the tangential force less
kinetic friction over x0 is the kinetic energy.
"""

from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.polynomial.chebyshev import chebpts1
from scipy.interpolate import BPoly
from scipy.special import comb

from vibrissa.errors import ArgumentError
from vibrissa.numerics.arrays import FloatArray
from vibrissa.numerics.roots import first_fall
from vibrissa.sensor.response.branch import States
from vibrissa.sensor.surfaces import Surface

# Relative rounding of a demand that mobilises all friction.
FULL = 1e-9
# A tip that comes to rest where it cannot stick slides back; each slide is shorter than the last.
REVERSALS = 100
# Parts of the longest way of a tip, in which its end is sought one after the other.
PARTS = (0.05, 0.25, 1.0)
# Longest cell of the way (L), and degree of the force on it.
CELL, DEGREE = 1e-4, 6
# Roundings of a position that are no distance.
ROUNDINGS = 8.0


class SlipLaw(StrEnum):
    """Where a slip ends.

    Attributes
    ----------
    FREE
        At α = 0, where no friction is needed (the paper's assumption).
    KINETIC
        Where |tan α| = μk: the tip creeps, without inertia.
    ENERGY
        Where kinetic friction has dissipated the released bending energy, at zero velocity.
    """

    FREE = "free"
    KINETIC = "kinetic"
    ENERGY = "energy"


def _bernstein(t: FloatArray) -> FloatArray:
    """Bernstein polynomials of the degree at parts `t` of a cell, one row for each part."""
    k = np.arange(DEGREE + 1)
    return np.asarray(comb(DEGREE, k) * t[:, None] ** k * (1.0 - t[:, None]) ** (DEGREE - k))


# Where in a cell, as parts of it, friction and forces are evaluated: never at its ends, where
# friction may jump. Values there to coefficients.
NODES = 0.5 + 0.5 * chebpts1(DEGREE + 1)
COEFFICIENTS = np.linalg.inv(_bernstein(NODES))


@dataclass(frozen=True, kw_only=True)
class Slip:
    """A slip of a tip while the clamp rests.

    Attributes
    ----------
    response : States
        At the present height.
    ratio : float
        Kinetic over static friction.
    clamp : float
        Position of the clamp along the surface (L).
    side : int
        1 for a tip ahead of the clamp, −1 for one behind it.
    """

    response: States
    surface: Surface
    law: SlipLaw
    ratio: float
    clamp: float = 0.0
    side: int = 1

    def end(self, x0: float) -> float:
        """Find where a tip that begins to slip at x0 comes to rest.

        Returns
        -------
        float
            Displacement (L); NaN if the tip leaves the states of the response.

        Raises
        ------
        ArgumentError
            If the tip comes to where the surface is not known, or does not come to rest.
        """
        if self.law is SlipLaw.FREE:
            return 0.0
        x0 = float(self.response.clip(x0))
        for _ in range(REVERSALS):
            x0 = self._slide(x0)
            if np.isnan(x0):
                return x0
            holds = float(self.surface(self.response.contact(self.clamp, x0, self.side)))
            if abs(float(self.response.demand(x0))) <= holds * (1.0 + FULL):
                return x0
        place = self.surface.told(self.clamp)
        raise ArgumentError(f"the slip with the clamp at {place} does not come to rest")

    def _slide(self, x0: float) -> float:
        """Where a slide in one direction ends; NaN if it does not."""
        response, surface = self.response, self.surface
        # A pushed tip slides to lower x0, a pulled one to higher.
        ahead = -1.0 if x0 > 0.0 else 1.0
        contact, onward = response.contact(self.clamp, x0, self.side), -self.side * ahead
        nothing = ROUNDINGS * float(np.spacing(1.0 + abs(contact)))
        kinks = np.append(ahead * (response.bounds - x0), onward * (surface.edges - contact))

        def excess_force(end: float) -> BPoly:
            """Tangential force less kinetic friction (E·I0/L²) over the way, cell by cell."""
            breaks = np.concatenate([kinks, np.arange(0.0, end, CELL), [0.0, end]])
            breaks = np.unique(breaks[(breaks >= 0.0) & (breaks <= end)])
            way = breaks[:-1, None] + np.diff(breaks)[:, None] * NODES
            fx, fy, _ = np.moveaxis(response(x0 + ahead * way), -1, 0)
            force = ahead * fx + self.ratio * surface(contact + onward * way) * fy
            return BPoly(COEFFICIENTS @ force.T, breaks)

        longest = abs(float(response.clip(ahead * np.inf)) - x0)
        surface_end = surface.stop if onward > 0.0 else surface.start
        known = min(longest, max(onward * (surface_end - contact), nothing))
        for part in PARTS:
            left = excess_force(part * known)
            stop = first_fall(left.antiderivative() if self.law is SlipLaw.ENERGY else left)
            if np.isfinite(stop):
                # At the edge of a patch a tip stops on the rougher side.
                return x0 + ahead * (stop + 2.0 * nothing)
        surface(contact + onward * longest)  # says where it is not known
        return np.nan
