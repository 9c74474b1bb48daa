"""A scan over a wave that shares no code with the package: brute force.

The rod is shot, by `reference`, at Chebyshev points of the offset of its tip and of the height. In
a slip the forces are computed at many points of the surface, and its end is sought between them.
"""

from dataclasses import dataclass

import numpy as np
from numpy.polynomial.chebyshev import chebpts1, chebval2d, chebvander
from scipy.integrate import cumulative_simpson, quad
from scipy.optimize import brentq

import reference

OFFSETS, HEIGHTS = 20, 3
# Distance of the points of the surface at which the forces are computed in a slip, and its reach.
FINE, FAR = 2e-5, 0.09


@dataclass(frozen=True)
class Rod:
    """Forces on the clamp, as polynomials of the tip's offset and of the height."""

    low: np.ndarray
    high: np.ndarray
    fx: np.ndarray
    fy: np.ndarray
    x1_init: float

    @classmethod
    def solved(cls, theta, eta, spread, first, before, behind):
        """Rod at heights eta ± spread, with offsets from x1_init - behind to x1_init + before."""
        phi1, force = reference.solve_inclination(theta, eta, 0.0, first)
        x1_init = reference.shoot_from_contact(theta, phi1, force, 0.0)[0]
        low = np.array([x1_init - behind, eta - spread])
        high = np.array([x1_init + before, eta + spread])
        offset, height = (
            a + (b - a) * 0.5 * (1.0 + chebpts1(n))
            for a, b, n in zip(low, high, (OFFSETS, HEIGHTS), strict=True)
        )
        fx, fy = np.empty((2, OFFSETS, HEIGHTS))
        nearest = int(np.abs(offset - x1_init).argmin())
        for j in range(HEIGHTS):
            for order in (range(nearest, OFFSETS), range(nearest, -1, -1)):
                state = np.array([phi1, force, 0.0])
                for i in order:
                    state = reference.solve_offset(theta, height[j], offset[i], state)
                    fx[i, j], fy[i, j] = state[2], -state[1]
        into = [np.linalg.inv(chebvander(chebpts1(n), n - 1)) for n in (OFFSETS, HEIGHTS)]
        return cls(low, high, *(into[0] @ one @ into[1].T for one in (fx, fy)), x1_init)

    def forces(self, offset, height):
        """Clamp reactions fx and fy."""
        u, v = (
            (2.0 * one - low - high) / (high - low)
            for one, low, high in zip((offset, height), self.low, self.high, strict=True)
        )
        return chebval2d(u, v, self.fx), chebval2d(u, v, self.fy)


@dataclass(frozen=True)
class Wave:
    """A surface y = eta - h with h = a·sin(k·x)."""

    eta: float
    a: float
    k: float

    def height(self, x):
        """Distance of the surface from the clamp."""
        return self.eta - self.a * np.sin(self.k * x)

    def resolved(self, rod, clamp, x):
        """Tangential and normal force on the rod, and ds/dx."""
        fx, fy = rod.forces(x - clamp, self.height(x))
        gamma = np.arctan(-self.a * self.k * np.cos(self.k * x))
        cos, sin = np.cos(gamma), np.sin(gamma)
        return fx * cos + fy * sin, fx * sin - fy * cos, 1.0 / cos


def scan(rod, wave, mu0, positions, law, ratio, zeta=0.0):
    """Return contact and number of the period of each step."""
    contact = slid(rod, wave, mu0, positions[0], rod.x1_init + positions[0], "free", ratio)
    rows, period = [], 1
    for clamp in positions:
        force, normal, _ = wave.resolved(rod, clamp, contact)
        if abs(force) > mu0 * normal:
            period += 1
            contact = slipped(rod, wave, mu0, clamp, contact, law, ratio, zeta)
        rows.append((contact, period))
    return np.array(rows).T


def slipped(rod, wave, mu0, clamp, contact, law, ratio, zeta):
    """Contact after a slip."""
    while True:
        contact = slid(rod, wave, mu0, clamp, contact, law, ratio, zeta)
        force, normal, _ = wave.resolved(rod, clamp, contact)
        if abs(force) <= mu0 * normal * (1.0 + 1e-9):
            return contact


def slid(rod, wave, mu0, clamp, contact, law, ratio, zeta=0.0):
    """Contact after a slide in the direction of the force."""
    way = -np.sign(wave.resolved(rod, clamp, contact)[0])

    def left(x):
        force, normal, stretch = wave.resolved(rod, clamp, x)
        friction = 0.0 if law == "free" else ratio * mu0 * normal
        return (-way * force - friction) * stretch

    most = rod.high[0] + clamp if way > 0 else rod.low[0] + clamp
    x = contact + way * np.arange(0.0, min(FAR, abs(most - contact)), FINE)
    values = left(x)
    if law in ("free", "kinetic"):
        stop = int(np.argmax(values[1:] <= 0.0)) + 1
        assert values[stop] <= 0.0
        return brentq(left, x[stop - 1], x[stop], xtol=1e-15)
    # Damping takes a part of the largest energy. On samples it is exact to FINE².
    energy = cumulative_simpson(values, dx=FINE, initial=0.0)
    taken = (1.0 - np.exp(-2.0 * np.pi * zeta)) * np.maximum.accumulate(energy)
    stop = int(np.argmax(energy[1:] <= taken[1:])) + 1
    assert energy[stop] <= taken[stop]

    def kept(x_end):
        begin = x[stop - 1]
        work = way * quad(left, begin, x_end, epsabs=1e-16)[0]
        return energy[stop - 1] + work - taken[stop]

    return brentq(kept, x[stop - 1], x[stop], xtol=1e-15)
