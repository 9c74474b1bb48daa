"""Rods whose stiffness changes along them, compared with a shooting that shares no code with them.

Each rod has a random modulus along it, many have a bore, half of them lie on the surface, and half
have a clamp that leans and yields, a natural curvature and an oblique stage. The shooting starts at
the contact point and searches the normal force and the place or the slope of the contact, for the
state at α = 0 and for the onset of slip. The check fails if the onset x0, a load or the place of
the contact differs by more than 1e-9.
"""

import math
import sys
from argparse import ArgumentParser
from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import root

from validation.records import write_record
from vibrissa import Mounting, solve_curve, solve_onset
from vibrissa.wording import markdown_table

ALLOWED = 1e-9
# Friction coefficient of the onsets; accuracy of the integration; relative error of the guesses.
MU0, CLOSE, ASTRAY = 0.2, 1e-12, 1e-3
# Degree of the random moduli, and their bounds at equally spaced places.
DEGREE, SOFTEST, STIFFEST = 3, 0.3, 4.0


def horner(coefficients, s):
    """Evaluate a polynomial; for single numbers this is faster than NumPy."""
    value = 0.0
    for coefficient in reversed(coefficients):
        value = value * s + coefficient
    return value


@dataclass(frozen=True)
class Factor:
    """Bending stiffness over that of a solid cone of one material, as a function of s."""

    theta: float
    powers: tuple
    bore: float

    @classmethod
    def of(cls, theta, mounting):
        """Read the stiffness of a rod from its mounting."""
        powers = mounting.stiffening
        return cls(theta, powers if isinstance(powers, tuple) else (powers,), mounting.bore)

    def __call__(self, s):
        """Evaluate the factor."""
        d = 1 - (1 - 1 / self.theta) * s
        return horner((1.0, *self.powers), s) * (d**4 - self.bore**4) / (1 - self.bore**4) / d**4


@dataclass(frozen=True, kw_only=True)
class Sample:
    """A rod, the height of the surface above its clamp, and the kind of contact allowed."""

    theta: float
    eta: float
    contact: str
    mounting: Mounting


def sample(random, number):
    """Draw the rod with this number: half have line contact, half a mounting that is not ideal."""
    theta = random.uniform(1.0, 4.0)
    places = np.linspace(0.0, 1.0, DEGREE + 1)
    while True:
        moduli = np.exp(random.uniform(np.log(SOFTEST), np.log(STIFFEST), DEGREE))
        powers = np.linalg.solve(np.vander(places[1:], DEGREE + 1)[:, -2::-1], moduli - 1)
        young = np.polynomial.Polynomial([1.0, *powers])(np.linspace(0, 1, 201))
        if SOFTEST / 2 < young.min() and young.max() < 2 * STIFFEST:
            break
    made = {"stiffening": tuple(powers), "bore": random.choice([0.0, random.uniform(0, 0.9)])}
    made["bore"] /= theta
    if number % 4 > 1:
        made["clamp_angle"] = random.uniform(-0.05, 0.05)
        made["clamp_compliance"] = random.uniform(0.0, 0.2)
        made["curvature"] = (random.uniform(-0.2, -0.05), random.uniform(-0.05, 0.05))
        made["stage_angle"] = random.uniform(-0.03, 0.03)
    contact = "line" if number % 2 else "point"
    eta = random.uniform(0.5, 0.9)
    return Sample(theta=theta, eta=eta, contact=contact, mounting=Mounting(**made))


@dataclass(frozen=True, kw_only=True)
class Shot:
    """An equilibrium found by shooting: x0 is 0 at α = 0; `s_c` is 1 in tip contact."""

    offset: float
    fx: float
    fy: float
    m: float
    phi1: float
    s_c: float


def shoot(one, ratio, line, guess, x1_init=None):
    """Shoot the equilibrium with fx = ratio·fy, from the guess (fy, s_c or φ1).

    The height of the contact point is η at α = 0, where `x1_init` is None, and follows the stage
    elsewhere.
    """
    mounting, factor = one.mounting, Factor.of(one.theta, one.mounting)
    natural = mounting.curvature if isinstance(mounting.curvature, tuple) else (mounting.curvature,)

    def integrated(unknown):
        fy, contact = unknown
        s_c, phi1 = (contact, 0.0) if line else (1.0, contact)

        def change(s, state):
            _, _, phi, m = state.tolist()
            cos, sin = math.cos(phi), math.sin(phi)
            d = 1 - (1 - 1 / one.theta) * s
            bend = m / (d**4 * factor(s)) + horner(natural, s)
            return [cos, sin, bend, fy * (ratio * sin - cos)]

        # The contact point is the origin.
        x, y, phi, m = solve_ivp(
            change, (s_c, 0.0), [0.0, 0.0, phi1, 0.0], method="DOP853", rtol=CLOSE, atol=CLOSE
        ).y[:, -1]
        return Shot(offset=-x + 1 - s_c, fx=ratio * fy, fy=fy, m=m, phi1=phi1, s_c=s_c), -y, phi

    def misses(unknown):
        found, height, phi = integrated(unknown)
        slope = np.pi / 2 + mounting.clamp_angle + mounting.clamp_compliance * found.m
        fallen = 0.0
        if x1_init is not None:
            fallen = np.tan(mounting.stage_angle) * (x1_init - found.offset)
        return [phi - slope, height - one.eta + fallen]

    solved = root(misses, guess, method="hybr", options={"xtol": 1e-12})
    missed = np.abs(misses(solved.x)).max()
    if missed > 1e-10:
        raise RuntimeError(f"the shooting misses by {missed:.1e}: {one}")
    return integrated(solved.x)[0]


@dataclass(frozen=True, kw_only=True)
class Compared:
    """Status of an onset, number of its two states in line contact, and largest difference."""

    status: str
    lying: int
    gap: float


def compare(one):
    """Compare the state at α = 0 and the onset of slip of a rod with those of the shooting."""
    place = {"contact": one.contact, "mounting": one.mounting}
    curve = solve_curve(one.theta, one.eta, **place)
    onset = solve_onset(one.theta, MU0, one.eta, **place)
    if onset.status != "slip":
        return Compared(status=str(onset.status), lying=0, gap=np.nan)
    first, slip = curve.state(0.0), onset.slip
    shots = []
    for state, ratio in ((first, 0.0), (slip, MU0)):
        line = float(state.s_c) < 1.0
        contact = float(state.s_c) * (1 - 1e-3 * ASTRAY) if line else float(state.phi1) + ASTRAY
        guess = [float(state.reaction_fy) * (1 + ASTRAY), contact]
        shots.append(shoot(one, ratio, line, guess, shots[0].offset if shots else None))
    way = np.cos(one.mounting.stage_angle)
    gaps = [(shots[0].offset - shots[1].offset) / way - onset.x0_slip]
    for state, shot in zip((first, slip), shots, strict=True):
        force = 1 + abs(shot.fy)
        gaps += [(state.reaction_fx - shot.fx) / force, (state.reaction_fy - shot.fy) / force]
        gaps += [(state.reaction_m - shot.m) / force, state.phi1 - shot.phi1, state.s_c - shot.s_c]
    lying = sum(float(state.s_c) < 1 for state in (first, slip))
    return Compared(status=str(onset.status), lying=lying, gap=float(np.abs(gaps).max()))


def main():
    """Compare random rods, and write the record."""
    parser = ArgumentParser(description=__doc__)
    parser.add_argument("--rods", type=int, default=100, help="number of rods")
    options = parser.parse_args()
    random = np.random.default_rng(7)
    kinds, skipped, number = {}, {}, 0
    while sum(map(len, kinds.values())) < options.rods:
        one = sample(random, number)
        found = compare(one)
        kind = one.contact, "ideal" if number % 4 < 2 else "leans, yields, is curved, oblique"
        if np.isfinite(found.gap):
            kinds.setdefault(kind, []).append(found)
        else:
            skipped[found.status] = skipped.get(found.status, 0) + 1
        number += 1
    rows = []
    for kind, found in sorted(kinds.items()):
        counts = len(found), sum(one.lying for one in found)
        rows.append([*kind, *map(str, counts), f"{max(one.gap for one in found):.1e}"])
    head = ["contact", "mounting", "rods", "states that lie on the surface", "largest difference"]
    left = ", ".join(f"{status}: {count}" for status, count in skipped.items()) or "none"
    text = markdown_table(head, rows) + f"\n\nRods without an onset, left out: {left}.\n"
    write_record("stiffness", __doc__, text)
    worst = max(one.gap for found in kinds.values() for one in found)
    print(f"{options.rods} rods, largest difference {worst:.1e}; left out: {left}")
    if not worst < ALLOWED:
        sys.exit(f"allowed: {ALLOWED:g}")


if __name__ == "__main__":
    main()
