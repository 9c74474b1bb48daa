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
from vibrissa.sensor.response.branch import Branch
from vibrissa.sensor.surfaces import Surface

# Relative rounding of a demand that mobilises all friction.
FULL = 1e-9
# A tip that comes to rest where it cannot stick slides back; each slide is shorter than the last.
REVERSALS = 100
# Degree of the force on a cell: a cubic response times a linear friction needs 4.
DEGREE = 6
# The way is searched in stretches: the first, and how much longer each is than the one before.
STRETCH, GROWTH = 0.005, 2.0
# Longest cell (L), and where in a cell, as parts of it, the force and its interpolant are compared.
LONGEST = 1e-3
BETWEEN = np.linspace(0.02, 0.98, 6)
# Relative error of the friction allowed there.
TOLERANCE = 1e-9
# A friction that needs more cells in one slip is too fine.
MOST_CELLS = 50_000
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
# friction may jump. Values there to coefficients, and to values between.
NODES = 0.5 + 0.5 * chebpts1(DEGREE + 1)
COEFFICIENTS = np.linalg.inv(_bernstein(NODES))
INTERPOLATION = _bernstein(BETWEEN) @ COEFFICIENTS


@dataclass(frozen=True, kw_only=True)
class _Way:
    """Path of a slipping tip, measured from the beginning of the slip."""

    x0: float
    ahead: float
    contact: float
    side: int

    @property
    def nothing(self) -> float:
        """Length that counts as zero, by rounding (L)."""
        return ROUNDINGS * float(np.spacing(1.0 + abs(self.contact)))

    def displacement(self, way: FloatArray) -> FloatArray:
        """Displacement x0 (L)."""
        return self.x0 + self.ahead * way

    def position(self, way: FloatArray | float) -> FloatArray:
        """Contact point (L)."""
        return np.asarray(self.contact - self.side * self.ahead * way)

    def to(self, position: FloatArray | float) -> FloatArray:
        """Way to a contact point, negative if that is behind (L)."""
        return np.asarray(self.side * self.ahead * (self.contact - position))


@dataclass(frozen=True, kw_only=True)
class Slips:
    """Where slips end on a surface, by one law.

    Attributes
    ----------
    ratio : float
        Kinetic over static friction, above 0 and up to 1.
    """

    response: Branch
    surface: Surface
    law: SlipLaw
    ratio: float

    def __post_init__(self) -> None:
        """Refuse an impossible ratio."""
        if not 0.0 < self.ratio <= 1.0:
            raise ArgumentError(f"kinetic_ratio must lie above 0 and up to 1, got {self.ratio!r}")

    def rest(self, clamp: float, x0: float, side: int = 1) -> float:
        """Find where a tip that slips comes to rest.

        Parameters
        ----------
        clamp : float
            Position of the clamp (L).

        Returns
        -------
        float
            Displacement (L); NaN if the tip leaves the states of the response.

        Raises
        ------
        ArgumentError
            If the tip comes to where the surface is not known or its friction varies too finely.
        """
        if self.law is SlipLaw.FREE:
            return 0.0
        response = self.response
        x0 = float(response.clip(x0))
        for _ in range(REVERSALS):
            x0 = self._slide(clamp, x0, side)
            if np.isnan(x0):
                return x0
            holds = float(self.surface(response.contact(clamp, x0, side)))
            if abs(float(response.demand(x0))) <= holds * (1.0 + FULL):
                return x0
        raise ArgumentError(
            f"the slip with the clamp at {self.surface.told(clamp)} does not come to rest"
        )

    def _slide(self, clamp: float, x0: float, side: int) -> float:
        """Where a slide in one direction ends; NaN if it does not."""
        # A pushed tip slides to lower x0, a pulled one to higher.
        ahead = -1.0 if x0 > 0.0 else 1.0
        contact = self.response.contact(clamp, x0, side)
        way = _Way(x0=x0, ahead=ahead, contact=contact, side=side)
        end = self._longest(way)
        onward = side * ahead < 0.0
        surface_end = float(way.to(self.surface.stop if onward else self.surface.start))
        known = min(end, surface_end)
        begin, length, energy = 0.0, STRETCH, 0.0
        while begin < known:
            until = min(begin + length, known)
            left = self._excess_force(way, begin, until)
            if self.law is SlipLaw.ENERGY:
                left = left.antiderivative()
                left.c += energy
                energy = float(left.c[-1, -1])
            stop = first_fall(left)
            if np.isfinite(stop):
                # At the edge of a patch a tip stops on the rougher side.
                return x0 + ahead * (stop + 2.0 * way.nothing)
            begin, length = until, GROWTH * length
        if known < end:
            self.surface(way.position(end))  # says that it is not known there
        return np.nan

    def _longest(self, way: _Way) -> float:
        """Distance to the end of the response; creeping ends at α = 0."""
        if self.law is SlipLaw.KINETIC:
            return abs(way.x0)
        response = self.response
        return way.x0 - response.x0_pull if way.ahead < 0.0 else response.x0_end - way.x0

    def _excess_force(self, way: _Way, begin: float, end: float) -> BPoly:
        """Tangential force less kinetic friction (E·I0/L²) on a part of the path, cell by cell."""
        start, width, mu0 = self._cells(way, self._bounds(way, begin, end))
        at = way.displacement(start[:, None] + width[:, None] * NODES)
        fx, fy, _ = np.moveaxis(self.response(at), -1, 0)
        force = way.ahead * fx + self.ratio * mu0 * fy
        return BPoly(COEFFICIENTS @ force.T, np.append(start, end))

    def _bounds(self, way: _Way, begin: float, end: float) -> FloatArray:
        """Find the breaks of response and friction on a part of the path (L)."""
        edges = way.to(self.surface.edges)
        edges = np.unique([begin, *edges[(edges > begin) & (edges < end)], end])
        inner = way.ahead * (self.response.reactions.x - way.x0)
        inner = np.append(inner, np.arange(begin, end, LONGEST))
        inner = inner[(inner > begin) & (inner < end)]
        after = np.searchsorted(edges, inner)
        apart = np.minimum(inner - edges[after - 1], edges[after] - inner) > way.nothing
        return np.union1d(edges, inner[apart])

    def _cells(self, way: _Way, bounds: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Cells, halved until friction is a polynomial on each: begin, width, friction at nodes."""
        start, width = bounds[:-1], np.diff(bounds)
        done, count = [], len(start)
        while len(start):
            mu0, seen = (
                self.surface(way.position(start[:, None] + width[:, None] * parts))
                for parts in (NODES, BETWEEN)
            )
            error = np.abs(mu0 @ INTERPOLATION.T - seen).max(axis=1)
            rough = (error > TOLERANCE * seen.max(axis=1)) & (width > way.nothing)
            count += int(rough.sum())
            if count > MOST_CELLS:
                where = float(way.position(start[rough][0]))
                raise ArgumentError(
                    f"mu0 of the {self.surface.name} surface varies too finely near x = "
                    f"{self.surface.told(where)} to follow a slip over it: give it as patches or "
                    "as a profile, or smoother"
                )
            done.append((start[~rough], width[~rough], mu0[~rough]))
            half = 0.5 * width[rough]
            start, width = np.append(start[rough], start[rough] + half), np.append(half, half)
        start, width, mu0 = (np.concatenate(parts) for parts in zip(*done, strict=True))
        order = np.argsort(start)
        return start[order], width[order], mu0[order]
