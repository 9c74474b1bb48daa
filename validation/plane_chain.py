"""A rod in its plane that shares no code with the package: rigid links, joined by springs.

Links of equal length h follow each other from the clamp to the contact point. Half a link separates
the clamp from the middle of the first link. Masses are at the ends of the links. The angles of the
links are the unknowns.
"""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from scipy.linalg import eigh, null_space
from scipy.optimize import brentq

# Largest correction of Newton's iteration at its end, and largest number of corrections.
CORRECTION, MOST_CORRECTIONS = 1e-13, 60


def diameter(s, theta):
    """Diameter in units of d0."""
    return 1 - (1 - 1 / theta) * s


@dataclass(frozen=True, kw_only=True)
class PlaneChain:
    """Chain of `count` links up to the contact point at the arc length `s_c`.

    With `flat`, the rest of the rod lies on the surface, and a spring joins the last link to it.
    The clamp leans by `clamp_angle` (rad) and turns by `compliance` per moment; `curvature` has the
    coefficients of 1, s, s², … in the natural curvature. `factor` and `heaviness` map arc lengths
    to the bending stiffness and the mass per length over those of a solid cone of one material.
    """

    theta: float
    count: int
    s_c: float = 1.0
    flat: bool = False
    clamp_angle: float = 0.0
    compliance: float = 0.0
    curvature: tuple = (0.0,)
    factor: Callable = np.ones_like
    heaviness: Callable = np.ones_like
    h: float = field(init=False)
    springs: np.ndarray = field(init=False)
    unloaded: np.ndarray = field(init=False)
    masses: np.ndarray = field(init=False)

    def __post_init__(self):
        """Compute springs, their unloaded turns, and masses."""
        h = self.s_c / self.count
        # Each joint has the spring and the mass of the rod between the middles of its links; the
        # first and the last one, of half a link.
        middle = np.concatenate([[0.0], h * (np.arange(self.count) + 0.5), [self.s_c]])
        lengths, centre = np.diff(middle), 0.5 * (middle[1:] + middle[:-1])
        springs = diameter(centre, self.theta) ** 4 * self.factor(centre) / lengths
        springs[0] = 1 / (1 / springs[0] + self.compliance)
        springs[-1] *= self.flat
        turn = np.polynomial.Polynomial(self.curvature).integ()
        unloaded = np.diff(turn(middle))
        masses = lengths * diameter(centre, self.theta) ** 2 * self.heaviness(centre)
        for name, value in {
            "h": h,
            "springs": springs,
            "unloaded": unloaded,
            "masses": masses,
        }.items():
            object.__setattr__(self, name, value)

    def turns(self, phi):
        """Turn of each joint, from the clamp to the surface (rad)."""
        return np.diff(phi, prepend=np.pi / 2 + self.clamp_angle, append=0.0)

    def force(self, phi):
        """Return the derivatives of the elastic energy by the angles (E·I0/L)."""
        moments = self.springs * (self.turns(phi) - self.unloaded)
        return moments[:-1] - moments[1:]

    def end(self, phi):
        """Position of the contact point relative to the clamp (L)."""
        return self.h * np.array([np.cos(phi).sum(), np.sin(phi).sum()])

    def end_by_angles(self, phi):
        """Return the derivatives of `end` by the angles, shape (2, count)."""
        return self.h * np.array([-np.sin(phi), np.cos(phi)])

    def stiffness(self, phi, load):
        """Second derivatives of the energy minus the work of the contact force `load`."""
        diagonal = self.springs[:-1] + self.springs[1:]
        diagonal = diagonal + self.h * (load[0] * np.cos(phi) + load[1] * np.sin(phi))
        beside = np.diag(-self.springs[1:-1], 1)
        return np.diag(diagonal) + beside + beside.T

    def mass(self, phi):
        """Matrix of the kinetic energy ½·φ'ᵀ·M·φ'."""
        behind = np.cumsum(self.masses[::-1])[::-1][1:]
        last = np.maximum.outer(np.arange(self.count), np.arange(self.count))
        return self.h**2 * behind[last] * np.cos(np.subtract.outer(phi, phi))

    def held_at(self, place, phi, load):
        """Return angles and contact force of the equilibrium near `phi` that ends at `place`."""
        for _ in range(MOST_CORRECTIONS):
            by_angles = self.end_by_angles(phi)
            residual = np.concatenate([self.force(phi) - load @ by_angles, place - self.end(phi)])
            matrix = np.block(
                [[self.stiffness(phi, load), -by_angles.T], [-by_angles, np.zeros((2, 2))]]
            )
            change = np.linalg.solve(matrix, residual)
            phi, load = phi - change[:-2], load - change[-2:]
            if np.abs(change[:-2]).max() < CORRECTION:
                return phi, load
        raise RuntimeError("the chain has no equilibrium near the guess")

    def frequencies(self, phi, load, how_many, *, slides=False):
        """Return the lowest natural frequencies about a state, with its contact point held.

        With `slides`, only its height is held, and the flat part moves along the surface.
        """
        by_angles, mass = self.end_by_angles(phi), self.mass(phi)
        if slides:
            # Simpson's rule is exact for the mass per length, a polynomial of degree two.
            s = np.linspace(self.s_c, 1.0, 3)
            per_length = diameter(s, self.theta) ** 2 * self.heaviness(s)
            flat = (1 - self.s_c) * (per_length @ [1 / 6, 4 / 6, 1 / 6])
            mass = mass + flat * np.outer(by_angles[0], by_angles[0])
        free = null_space(by_angles[1:] if slides else by_angles)
        stiff, mass = (free.T @ one @ free for one in (self.stiffness(phi, load), mass))
        # 1/ω² are the largest eigenvalues of this problem, and so they are exact to rounding. The
        # smallest ω² of the inverse problem would have errors as large as that of the largest ω².
        last = len(mass) - 1
        try:
            inverse = eigh(
                mass, stiff, eigvals_only=True, subset_by_index=[last - how_many + 1, last]
            )
        except np.linalg.LinAlgError:
            # The state is no minimum of the energy.
            return np.full(how_many, np.nan)
        return 1 / np.sqrt(inverse[::-1])


def chain_state(theta, count, offset, eta, guess, *, s_c=1.0, **mounting):
    """Equilibrium of a chain whose tip is at (offset, eta), near a `guess`: slope over arc length.

    With s_c < 1 the chain lies on the surface; s_c is a guess then, and the place where the chain
    lies down follows from the condition that it transmits no moment there.

    Returns
    -------
    chain, phi, load
    """

    def at(place):
        chain = PlaneChain(theta=theta, count=count, s_c=place, flat=s_c < 1, **mounting)
        middles = chain.h * (np.arange(count) + 0.5)
        angles, forces = guess(middles * s_c / place)
        phi, load = chain.held_at(np.array([offset - (1 - place), eta]), angles, forces)
        return chain, phi, load

    if s_c < 1:
        s_c_own = brentq(
            lambda place: at(place)[1][-1], s_c - 0.02, min(s_c + 0.02, 1.0), xtol=1e-13
        )
        return at(s_c_own)
    return at(1.0)
