"""Compare planar states of the rod with chains of links in space, which share no code with it.

The contact point of each chain lies at some distance ahead of the clamp, or as far behind it. The
chain is pushed at random and relaxes to a state of least energy. Ahead of the clamp, this must be
the planar state of the rod; behind the clamp, the mirror image of the planar state. The check fails
if an energy, extrapolated over the number of links, differs by more than 1e-5 (relative) from that
of the continuous planar rod.
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
# Size of a push, relative to the largest turn at a joint.
PUSH = 0.02
# Taper, height and contact of each rod; distances of the contact point from the clamp (x1_init).
RODS = ((1.0, 0.85, "point"), (4.0, 0.6, "point"), (4.0, 0.6, "line"), (5.0, 0.33, "line"))
DISTANCES = (0.01, 0.03, 0.1)


@dataclass(frozen=True, kw_only=True)
class Found:
    """Energies (E·I0/L) of a rod and of chains at one distance of the contact point from the clamp.

    Attributes
    ----------
    rod : float
        Continuous planar rod, contact point ahead of the clamp.
    ahead, behind : float
        Pushed chains, extrapolated; contact point ahead of the clamp, and behind it.
    straight_on : float
        Chain that is kept in its plane, contact point behind the clamp.
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
    """Return x1 − x0 where the contact point is straight above the clamp (L)."""
    curve = solve_curve(theta, eta, contact=contact)
    return curve.x1_init - curve.x0_end


def extrapolated(values: list[float]) -> float:
    """Extrapolate values for doubled numbers of links to infinitely many (Richardson)."""
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
    """Compare pushed chains with a rod, `distance` (x1_init) ahead of the clamp and behind it."""
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
    """Bending energy of a planar state from the moment of its contact force (E·I0/L)."""
    s = np.linspace(0, state.s_c, 4001)
    x, y, _ = state.shape(s)
    moment = (state.eta - y) * state.reaction_fx - (
        state.x1 - (1 - state.s_c) - x
    ) * state.reaction_fy
    return float(simpson(moment**2 / 2 / (1 - (1 - 1 / state.theta) * s) ** 4, x=s))


def main() -> None:
    """Read the options, and compare all rods at all distances."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--pushes", type=int, default=5, help="pushes of each chain on each side")
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    random, worst = np.random.default_rng(options.seed), 0.0
    print(" theta   eta contact  distance     the rod       ahead      behind     off    in plane")
    for rod in RODS:
        for distance in DISTANCES:
            found = compare(rod, distance, options.pushes, random)
            worst = float(np.max([worst, found.off, found.spread]))  # NaN stays NaN
            print(
                f"{rod[0]:6g}{rod[1]:6g} {rod[2]:>7}{distance:10g}{found.rod:12.6f}"
                f"{found.ahead:12.6f}{found.behind:12.6f}{found.off:8.0e}{found.straight_on:12.6f}"
            )
    print(f"energies differ by up to {worst:.1e}")
    if not worst < TOLERANCE:
        sys.exit(f"allowed: {TOLERANCE:g}")
