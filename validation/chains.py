"""Compare a chain of links in space, which shares no code with the rod, with the planar states.

Each chain has its contact point at some distance ahead of the clamp, or as far behind it. It is
pushed at random and relaxes to a state of least energy. Ahead of the clamp that is to be the planar
state of the rod, behind it the mirror image of that state, both with the energy of the continuous
planar rod: by Richardson's extrapolation over the number of links, to 1e-5. Fails otherwise.
"""

import argparse
import sys
from dataclasses import dataclass

import numpy as np
from scipy.integrate import simpson

from validation.rod_chain import Chain
from vibrissa import solve_curve, solve_state

COUNTS = (20, 40, 80)
TOLERANCE = 1e-5
# Size of a push, of the largest turn at a joint.
PUSH = 0.02
# Taper, height and contact, and distances from the clamp in units of x1_init.
RODS = ((1.0, 0.85, "point"), (4.0, 0.6, "point"), (4.0, 0.6, "line"), (5.0, 0.33, "line"))
DISTANCES = (0.01, 0.03, 0.1)


@dataclass(frozen=True, kw_only=True)
class Found:
    """Energies (E·I0/L) at a distance of the contact point from the clamp.

    Attributes
    ----------
    rod : float
        Of the continuous rod in its plane, ahead of the clamp.
    ahead, behind : float
        Of pushed chains, extrapolated, with the contact point ahead of the clamp and behind it.
    straight_on : float
        Of a chain with the contact point behind the clamp that is kept in its plane.
    spread : float
        Largest relative difference between pushes.
    aside : float
        Largest distance of a relaxed chain from the plane (L).
    """

    rod: float
    ahead: float
    behind: float
    straight_on: float
    spread: float
    aside: float

    @property
    def off(self) -> float:
        """Largest relative difference from the continuous rod."""
        return max(abs(energy / self.rod - 1) for energy in (self.ahead, self.behind))


def contact_over_clamp(theta: float, eta: float, contact: str) -> float:
    """Place of the tip, seen from the clamp, where the contact point is over the clamp (L)."""
    curve = solve_curve(theta, eta, contact=contact)
    return curve.x1_init - curve.x0_end


def extrapolated(values: list[float]) -> float:
    """Limit for ever more links, each value for twice as many, of a series in 1/count²."""
    for power in range(1, len(values)):
        pairs = zip(values[1:], values[:-1], strict=True)
        values = [(4**power * fine - coarse) / (4**power - 1) for fine, coarse in pairs]
    return values[0]


def compare(
    rod: tuple[float, float, str],
    distance: float,
    pushes: int,
    random: np.random.Generator,
    counts: tuple[int, ...] = COUNTS,
) -> Found:
    """Push chains at a distance ahead of the clamp and behind it (in units of x1_init)."""
    theta, eta, contact = rod
    x1_init = solve_curve(theta, eta, contact=contact).x1_init
    state = solve_state(theta, eta, contact_over_clamp(*rod) + distance * x1_init, contact)
    place = state.x1 - (1 - state.s_c)
    target = np.array([place, eta, 0.0])
    ahead, behind, spread, aside = [], [], 0.0, 0.0
    for count in counts:
        chain = Chain(theta, count, state.s_c, tail=contact == "line")
        planar = chain.planar(lambda s: state.shape(s)[2])
        size = PUSH * np.abs(planar).max()
        for energies, side in ((ahead, 1), (behind, -1)):
            ends = [
                chain.minimum(
                    target * [side, 1, 1], planar + size * random.normal(size=planar.shape)
                )[0]
                for _ in range(pushes)
            ]
            found = [chain.energy(end) for end in ends]
            energies.append(float(np.mean(found)))
            spread = max(spread, np.ptp(found) / energies[-1])
            aside = max(aside, *(np.abs(chain.links(end)[2][:, 2]).max() for end in ends))
    straight_on, _ = chain.minimum(target * [-1, 1, 1], planar)
    return Found(
        rod=energy_of(state),
        ahead=extrapolated(ahead),
        behind=extrapolated(behind),
        straight_on=chain.energy(straight_on),
        spread=spread,
        aside=aside,
    )


def energy_of(state) -> float:
    """Bending energy of a planar state by the moment of its contact force (E·I0/L)."""
    s = np.linspace(0, state.s_c, 4001)
    x, y, _ = state.shape(s)
    moment = (state.eta - y) * state.reaction_fx - (
        state.x1 - (1 - state.s_c) - x
    ) * state.reaction_fy
    return float(simpson(moment**2 / 2 / (1 - (1 - 1 / state.theta) * s) ** 4, x=s))


def main() -> None:
    """Read the options, and compare all rods at all distances."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--pushes", type=int, default=5, help="for each chain, on each side")
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    random, worst = np.random.default_rng(options.seed), 0.0
    print(" theta   eta contact  distance     the rod       ahead      behind     off    in plane")
    for rod in RODS:
        for distance in DISTANCES:
            found = compare(rod, distance, options.pushes, random)
            worst = max(worst, found.off, found.spread)
            print(
                f"{rod[0]:6g}{rod[1]:6g} {rod[2]:>7}{distance:10g}{found.rod:12.6f}"
                f"{found.ahead:12.6f}{found.behind:12.6f}{found.off:8.0e}{found.straight_on:12.6f}"
            )
    print(f"energies differ by up to {worst:.1e}")
    if not worst < TOLERANCE:
        sys.exit(f"allowed: {TOLERANCE:g}")
