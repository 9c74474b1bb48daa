"""Natural frequencies of bent rods, compared with chains of links that share no code with them.

Each chain has its own equilibrium, and in line contact its own place where it lies down. The check
fails if a frequency that is extrapolated from two chains differs by more than 1e-6 (relative), if
the first one of 400 links does by more than 1e-4, or if the order of convergence is not 2.
"""

import sys
from dataclasses import dataclass

import numpy as np

from validation.plane_chain import chain_state, diameter
from validation.records import write_record
from validation.stiffness import Factor
from vibrissa import Mounting, solve_curve, solve_state
from vibrissa.mechanics.mounting import IDEAL
from vibrissa.wording import markdown_table

COUNTS = (100, 200, 400)
EXTRAPOLATED, FINEST, ORDER = 1e-6, 1e-4, 0.02


@dataclass(frozen=True, kw_only=True)
class Bent:
    """A bent state: a rod, its mounting, and the part of its path from α = 0 at which it is.

    `slides` states that only the height of the contact point is held.
    """

    theta: float
    eta: float
    part: float
    contact: str = "point"
    slides: bool = False
    mounting: Mounting = IDEAL


LEANING = Mounting(clamp_angle=0.1, clamp_compliance=0.3)
CURVED = Mounting(clamp_angle=-0.05, curvature=(-0.4, 0.3))
# The modulus changes along the rod, which has a bore.
TUBE = Mounting(stiffening=(0.8, -0.5), bore=0.3)
NAMES = {IDEAL: "ideal", TUBE: "a tube of changing modulus"}
BENT = (
    Bent(theta=1.0, eta=0.85, part=0.1),
    Bent(theta=1.0, eta=0.6, part=0.8),
    Bent(theta=2.0, eta=0.85, part=0.5),
    Bent(theta=4.0, eta=0.7, part=0.2),
    Bent(theta=2.0, eta=0.85, part=0.1, slides=True),
    Bent(theta=2.0, eta=0.8, part=0.3, mounting=LEANING),
    Bent(theta=3.0, eta=0.85, part=0.3, mounting=CURVED),
    Bent(theta=4.0, eta=0.6, part=0.4, contact="line"),
    Bent(theta=3.0, eta=0.7, part=0.2, contact="line"),
    Bent(theta=4.0, eta=0.6, part=0.1, contact="line", slides=True),
    Bent(theta=2.0, eta=0.8, part=0.3, mounting=TUBE),
    Bent(theta=3.0, eta=0.6, part=0.3, contact="line", slides=True, mounting=TUBE),
)


@dataclass(frozen=True, kw_only=True)
class Compared:
    """Frequencies of a rod and of chains: first and second, in √(E·I0/(ρA0·L⁴)).

    Attributes
    ----------
    rod : ndarray, shape (2,)
    chains : ndarray, shape (counts, 2)
    """

    rod: np.ndarray
    chains: np.ndarray

    @property
    def order(self):
        """Order of convergence of the first frequency, from three chains."""
        coarse, middle, fine = self.chains[:, 0]
        return float(np.log2((middle - coarse) / (fine - middle)))

    @property
    def finest(self):
        """Relative differences of the frequencies of the longest chain."""
        return self.chains[-1] / self.rod - 1

    @property
    def extrapolated(self):
        """Relative differences of frequencies extrapolated to infinitely many links."""
        return ((4 * self.chains[-1] - self.chains[-2]) / 3) / self.rod - 1


def heaviness(s, theta, bore):
    """Mass per length of a tube over that of a solid cone."""
    d = diameter(s, theta)
    return (d**2 - bore**2) / (1 - bore**2) / d**2


def compare(bent, counts=COUNTS):
    """Compute the frequencies of a rod and of chains."""
    curve = solve_curve(bent.theta, bent.eta, contact=bent.contact, mounting=bent.mounting)
    x0 = bent.part * curve.x0_end
    offset = curve.x1_init - x0
    state = solve_state(bent.theta, bent.eta, offset, bent.contact, bent.mounting)
    tip = "slides" if bent.slides else "sticks"
    rod = curve.frequencies(x0, 2, tip)

    def guess(s):
        return state.shape(s)[2], np.array([state.reaction_fx, state.reaction_fy])

    mounting = {
        "clamp_angle": bent.mounting.clamp_angle,
        "compliance": bent.mounting.clamp_compliance,
        "curvature": bent.mounting.coefficients,
        "factor": Factor.of(bent.theta, bent.mounting),
        "heaviness": lambda s: heaviness(s, bent.theta, bent.mounting.bore),
    }
    chains = []
    for count in counts:
        chain, phi, load = chain_state(
            bent.theta, count, offset, bent.eta, guess, s_c=state.s_c, **mounting
        )
        chains.append(chain.frequencies(phi, load, 2, slides=bent.slides))
    return Compared(rod=rod, chains=np.array(chains))


def main():
    """Compare all bent states, write the record, and print the largest differences."""
    found = [compare(bent) for bent in BENT]
    rows = [
        [
            *(f"{value:g}" for value in (bent.theta, bent.eta, bent.part)),
            f"{bent.contact}, {'slides' if bent.slides else 'sticks'}",
            NAMES.get(bent.mounting, "leans, yields or is curved"),
            *(f"{value:.6f}" for value in one.rod),
            *(f"{value:+.1e}" for value in (*one.finest, *one.extrapolated)),
            f"{one.order:.3f}",
        ]
        for bent, one in zip(BENT, found, strict=True)
    ]
    head = ["θ", "η", "x0/x0,end", "contact, tip", "mounting", "ω1", "ω2"]
    head += ["400 links: ω1", "ω2", "extrapolated: ω1", "ω2", "order"]
    write_record("vibration", __doc__, markdown_table(head, rows))
    finest = max(abs(one.finest[0]) for one in found)
    extrapolated = max(np.abs(one.extrapolated).max() for one in found)
    order = max(abs(one.order - 2) for one in found)
    print(f"400 links: {finest:.1e}; extrapolated: {extrapolated:.1e}; order: 2 ± {order:.3f}")
    if not (finest < FINEST and extrapolated < EXTRAPOLATED and order < ORDER):
        sys.exit(f"allowed: {FINEST:g}, {EXTRAPOLATED:g}, {ORDER:g}")
