"""Where a slip of the tip ends.

While the tip slips, the clamp rests; x0 falls if the tip was pushed, and rises if it was pulled.
The kinetic energy is the integral over x0 of the tangential force less kinetic friction.
"""

from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np
from numpy.polynomial.chebyshev import chebpts1
from scipy.interpolate import BPoly
from scipy.special import comb

from vibrissa.errors import ArgumentError
from vibrissa.numerics.roots import first_fall
from vibrissa.scanning.response import States
from vibrissa.scanning.surfaces import Surface

# Relative excess of |tan α| over μ0 at which a tip still sticks, for rounding.
FULL = 1e-9
# Largest number of slides in a slip: a tip that stops where it cannot stick slides back, less far.
REVERSALS = 100
# Parts of the longest possible slide, within which its end is sought, one part after the other.
SOUGHT = (0.05, 0.25, 1.0)
# Longest cell of a slide (L), and degree of the polynomial of the force in a cell.
LONGEST_CELL, DEGREE = 1e-3, 6
# Number of places at which a state with α = 0 is sought before a slip.
LOOKS = 257
# Largest distance that counts as 0, in roundings of a position.
ROUNDINGS = 8.0


class SlipLaw(StrEnum):
    """Where a slip ends.

    Attributes
    ----------
    FREE
        At α = 0, where no friction is needed (the paper's assumption).
    KINETIC
        Where |tan α| = μk: the tip slides so slowly that inertia plays no part.
    ENERGY
        Where kinetic friction has dissipated the released bending energy, at zero velocity.
    """

    FREE = "free"
    KINETIC = "kinetic"
    ENERGY = "energy"


# Places in a cell, as parts of it, at which the force is computed: not its ends, where friction may
# jump. `COEFFICIENTS` times the values there are the coefficients of Bernstein polynomials.
NODES = 0.5 + 0.5 * chebpts1(DEGREE + 1)
_K, _T = np.arange(DEGREE + 1), NODES[:, None]
COEFFICIENTS = np.linalg.inv(comb(DEGREE, _K) * _T**_K * (1.0 - _T) ** (DEGREE - _K))


@dataclass(frozen=True, kw_only=True)
class Slip:
    """A slip of the tip, during which the clamp rests.

    Attributes
    ----------
    response : States
        States of the rod over x0, at the present height of the surface above the clamp.
    ratio : float
        Kinetic over static friction, μk/μ0.
    clamp : float
        Position of the clamp along the surface (L).
    side : int
        1 for a tip ahead of the clamp, −1 for a tip behind it.
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
            Displacement x0 at rest (L); NaN if x0 leaves the range of the computed states.

        Raises
        ------
        ArgumentError
            If the tip reaches an unknown part of the surface, or slides to and fro for too long.
        """
        x0 = float(self.response.clip(x0))
        if self.law is SlipLaw.FREE:
            # Where a pushed tip was pushed back before, it meets a state with α = 0 there.
            between = self.response.demand(np.linspace(0.0, x0, LOOKS)[1:])
            if x0 > 0.0 and between.min() < 0.0:
                return replace(self, law=SlipLaw.KINETIC, ratio=0.0)._slide(x0)
            return 0.0
        for _ in range(REVERSALS):
            x0 = self._slide(x0)
            if np.isnan(x0):
                return x0
            holds = float(self.surface(self.response.contact(self.clamp, x0, self.side)))
            if abs(float(self.response.demand(x0))) <= holds * (1.0 + FULL):
                return x0
        place = f"the clamp at {self.surface.spell(self.clamp)}"
        raise ArgumentError(f"with {place} a slip has over {REVERSALS} slides: take another law")

    def _slide(self, x0: float) -> float:
        """Find x0 where a slide in one direction ends (L); NaN if it leaves the computed states."""
        response, surface = self.response, self.surface
        # A pushed tip slides to lower x0, a pulled one to higher.
        ahead = -1.0 if x0 > 0.0 else 1.0
        contact, onward = response.contact(self.clamp, x0, self.side), -self.side * ahead
        nothing = ROUNDINGS * float(np.spacing(1.0 + abs(contact)))
        cell = min(LONGEST_CELL, surface.feature)
        kinks = np.append(ahead * (response.bounds - x0), onward * (surface.edges - contact))

        def excess_force(end: float) -> BPoly:
            """Tangential force minus kinetic friction (E·I0/L²), as a function of the distance."""
            breaks = np.concatenate([kinks, np.arange(0.0, end, cell), [0.0, end]])
            breaks = np.unique(breaks[(breaks >= 0.0) & (breaks <= end)])
            way = breaks[:-1, None] + np.diff(breaks)[:, None] * NODES
            fx, fy, _ = np.moveaxis(response(x0 + ahead * way), -1, 0)
            force = ahead * fx + self.ratio * surface(contact + onward * way) * fy
            return BPoly(COEFFICIENTS @ force.T, breaks)

        longest = abs(float(response.clip(ahead * np.inf)) - x0)
        surface_end = surface.stop if onward > 0.0 else surface.start
        known = min(longest, max(onward * (surface_end - contact), nothing))
        for part in SOUGHT:
            left = excess_force(part * known)
            stop = first_fall(left.antiderivative() if self.law is SlipLaw.ENERGY else left)
            if np.isfinite(stop):
                # At the edge of a patch a tip stops on the rougher side.
                return x0 + ahead * (stop + 2.0 * nothing)
        surface(contact + onward * longest)  # raises where the surface is not known
        return np.nan
