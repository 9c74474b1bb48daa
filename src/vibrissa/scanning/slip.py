"""Where a slip of the tip ends.

While the tip slips, the clamp rests; x0 falls if the tip was pushed, and rises if it was pulled.
The kinetic energy is the integral over x0 of the tangential force less kinetic friction.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.polynomial.chebyshev import chebpts1
from scipy.interpolate import BPoly
from scipy.special import comb

from vibrissa.errors import ArgumentError
from vibrissa.numerics.arrays import FloatArray
from vibrissa.numerics.roots import first_fall
from vibrissa.outcomes import SlipLaw as SlipLaw
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


# Places in a cell, as parts of it, at which the force is computed: not its ends, where friction may
# jump. `COEFFICIENTS` times the values there are the coefficients of Bernstein polynomials.
NODES = 0.5 + 0.5 * chebpts1(DEGREE + 1)
_K, _T = np.arange(DEGREE + 1), NODES[:, None]
COEFFICIENTS = np.linalg.inv(comb(DEGREE, _K) * _T**_K * (1.0 - _T) ** (DEGREE - _K))


class Rest(NamedTuple):
    """Where a slip or a slide ends, and its energies.

    Attributes
    ----------
    x0 : float
        Displacement x0 at rest (L); NaN if x0 leaves the range of the computed states.
    released : float
        Elastic energy that the rod and its mounting lose: the work of the tangential force
        (E·I0/L).
    dissipated : float
        Work against kinetic friction (E·I0/L). NaN under the law ``free``, which has no kinetic
        friction.
    """

    x0: float
    released: float
    dissipated: float


LEFT = Rest(x0=np.nan, released=np.nan, dissipated=np.nan)


class _Forces(NamedTuple):
    """Driving force and friction along a slide, as functions of its distance (E·I0/L²)."""

    driving: BPoly
    friction: BPoly

    @property
    def excess(self) -> BPoly:
        """Driving force less friction."""
        return BPoly(self.driving.c - self.friction.c, self.driving.x)


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

    def end(self, x0: float) -> Rest:
        """Find where a tip that begins to slip at x0 comes to rest.

        Returns
        -------
        Rest
            Its numbers are NaN if x0 leaves the range of the computed states.

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
                slide = replace(self, law=SlipLaw.KINETIC, ratio=0.0)._slide(x0)
                return slide._replace(dissipated=np.nan)
            return Rest(x0=0.0, released=self._released(x0), dissipated=np.nan)
        released = dissipated = 0.0
        for _ in range(REVERSALS):
            slide = self._slide(x0)
            if np.isnan(slide.x0):
                return LEFT
            x0 = slide.x0
            released, dissipated = released + slide.released, dissipated + slide.dissipated
            holds = float(self.surface(self.response.contact(self.clamp, x0, self.side)))
            if abs(float(self.response.demand(x0))) <= holds * (1.0 + FULL):
                return Rest(x0=x0, released=released, dissipated=dissipated)
        place = f"the clamp at {self.surface.spell(self.clamp)}"
        raise ArgumentError(f"with {place} a slip has over {REVERSALS} slides: take another law")

    def _slide(self, x0: float) -> Rest:
        """Find where a slide in one direction ends; NaN if it leaves the computed states."""
        response, surface = self.response, self.surface
        # A pushed tip slides to lower x0, a pulled one to higher.
        ahead = -1.0 if x0 > 0.0 else 1.0
        contact, onward = response.contact(self.clamp, x0, self.side), -self.side * ahead
        nothing = ROUNDINGS * float(np.spacing(1.0 + abs(contact)))
        cell = min(LONGEST_CELL, surface.feature)
        kinks = np.append(ahead * (response.bounds - x0), onward * (surface.edges - contact))

        def forces(end: float) -> _Forces:
            breaks = _cells(kinks, cell, end)
            way = breaks[:-1, None] + np.diff(breaks)[:, None] * NODES
            fx, fy, _ = np.moveaxis(response(x0 + ahead * way), -1, 0)
            friction = -self.ratio * surface(contact + onward * way) * fy
            return _Forces(
                driving=BPoly(COEFFICIENTS @ (ahead * fx).T, breaks),
                friction=BPoly(COEFFICIENTS @ friction.T, breaks),
            )

        longest = abs(float(response.clip(ahead * np.inf)) - x0)
        surface_end = surface.stop if onward > 0.0 else surface.start
        known = min(longest, max(onward * (surface_end - contact), nothing))
        for part in SOUGHT:
            found = forces(part * known)
            left = found.excess
            stop = first_fall(left.antiderivative() if self.law is SlipLaw.ENERGY else left)
            if np.isfinite(stop):
                return Rest(
                    # At the edge of a patch a tip stops on the rougher side.
                    x0=x0 + ahead * (stop + 2.0 * nothing),
                    released=float(found.driving.integrate(0.0, stop)),
                    dissipated=float(found.friction.integrate(0.0, stop)),
                )
        surface(contact + onward * longest)  # raises where the surface is not known
        return LEFT

    def _released(self, x0: float) -> float:
        """Elastic energy that is released from x0 to the state with α = 0 (E·I0/L)."""
        ahead, way = (-1.0 if x0 > 0.0 else 1.0), abs(x0)
        if way == 0.0:
            return 0.0
        breaks = _cells(ahead * (self.response.bounds - x0), LONGEST_CELL, way)
        places = breaks[:-1, None] + np.diff(breaks)[:, None] * NODES
        force = ahead * self.response(x0 + ahead * places)[..., 0]
        return float(BPoly(COEFFICIENTS @ force.T, breaks).integrate(0.0, way))


def _cells(kinks: FloatArray, cell: float, end: float) -> FloatArray:
    """Cut the way from 0 to `end` (L) at kinks, and into cells of at most a given length."""
    breaks = np.concatenate([kinks, np.arange(0.0, end, cell), [0.0, end]])
    return np.unique(breaks[(breaks >= 0.0) & (breaks <= end)])
