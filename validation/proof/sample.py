"""Prove onsets of slip at random points, far beyond the paper's grid.

Each point has a taper of 1 to 8, a height of 0.4 to 0.97, tip or line contact, and a friction
coefficient up to 0.98 of the critical one. Lists each point that could not be proved. Exit status 1
if the solver is further than 1e-11 L from a proved onset, or from a proved change of contact.
"""

import argparse
import os
from collections import Counter
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from decimal import Decimal
from itertools import pairwise

import numpy as np
from flint import arb
from rich.progress import track

from validation.proof import NotProvedError
from validation.proof.digits import decimals
from validation.proof.equilibrium import Equilibrium, Rod, inclined, prove, tangential
from validation.proof.flow import Effort
from validation.proof.starting import ball, load_at, prove_at, rod_of, suitable
from vibrissa import solve_curve
from vibrissa.decimals import exact
from vibrissa.outcomes import Contact
from vibrissa.sticking.curve import StickingCurve

THETA, ETA, SHARE = (1.0, 8.0), (0.4, 0.97), (0.02, 0.98)
# The solver promises a residual of 1e-12; next to the lock an onset is off by more.
AGREES = 1e-11


@dataclass(frozen=True, kw_only=True)
class Place:
    """Where to prove an onset: at a share of the critical friction coefficient."""

    theta: Decimal
    eta: Decimal
    contact: Contact
    share: float


@dataclass(frozen=True, kw_only=True)
class Onset:
    """A proved period of sticking: its first and last state, and changes of contact between them.

    Attributes
    ----------
    init, slip : Equilibrium
    x0_slip : arb
        How far the clamp moves between the two (L).
    x0_switch : tuple of arb
        Displacements at which φ1 = 0 and s_c = 1 (L).
    """

    init: Equilibrium
    slip: Equilibrium
    x0_slip: arb
    x0_switch: tuple[arb, ...]


@dataclass(frozen=True, kw_only=True)
class Tried:
    """What became of a place.

    Attributes
    ----------
    place : Place
    outcome : str
        Contact of the first and the last state, or why there is no proof.
    radius : Decimal
        Of x0_slip, relative.
    off : float
        Largest distance of the solver's displacements from the proved ones (L).
    """

    place: Place
    outcome: str
    radius: Decimal = Decimal(0)
    off: float = 0.0


def anywhere(seed: int) -> Place:
    """Draw a random place."""
    draw = np.random.default_rng(seed)
    theta, eta = (exact(round(float(draw.uniform(*span)), 4)) for span in (THETA, ETA))
    share, contact = float(draw.uniform(*SHARE)), Contact(draw.choice(list(Contact)))
    return Place(theta=theta, eta=eta, contact=contact, share=share)


def prove_onset(curve: StickingCurve, rod: Rod, mu0: Decimal, contact: Contact) -> Onset:
    """Prove the period of sticking that the solver has, in the precision that is set.

    Raises
    ------
    NotProvedError
        If a state is not proved, or its kind of contact.
    """
    x0_slip = float(curve.onset([float(mu0)])[0])
    init = prove_at(rod, inclined(arb(0)), curve, 0.0)
    slip = prove_at(rod, inclined(ball(mu0)), curve, x0_slip)
    if contact is Contact.LINE and not (init.keeps_contact() and slip.keeps_contact()):
        raise NotProvedError("a state is too near a change of contact to tell its kind")
    switches = [prove(rod, tangential(), load_at(curve, x0)) for x0 in switched(curve, x0_slip)]
    return Onset(
        init=init,
        slip=slip,
        x0_slip=init.offset - slip.offset,
        x0_switch=tuple(init.offset - switch.offset for switch in switches),
    )


def switched(curve: StickingCurve, x0_slip: float) -> list[float]:
    """List where the contact changes its kind before the onset, as the solver has it."""
    return [
        piece.first_x0
        for before, piece in pairwise(curve.pieces)
        if piece.contact is not before.contact and piece.first_x0 < x0_slip
    ]


def tried(place: Place, effort: Effort | None = None) -> Tried:
    """Prove the onset at a place."""
    curve = solve_curve(float(place.theta), float(place.eta), contact=place.contact)
    if not np.isfinite(curve.mu_lock):
        return Tried(place=place, outcome="there is no critical state")
    mu0 = exact(round(place.share * curve.mu_lock, 4))
    effort = effort or suitable(place.theta)
    try:
        with effort.spent():
            rod = rod_of(place.theta, place.eta, effort)
            found = prove_onset(curve, rod, mu0, place.contact)
    except NotProvedError as error:
        return Tried(place=place, outcome=f"not proved: {error}")
    middle, radius = decimals(found.x0_slip)
    x0_slip = float(curve.onset([float(mu0)])[0])
    solved = (x0_slip, *switched(curve, x0_slip))
    pairs = zip(solved, (found.x0_slip, *found.x0_switch), strict=True)
    return Tried(
        place=place,
        outcome=f"proved, {found.init.contact} to {found.slip.contact}",
        radius=radius / middle,
        off=max(abs(float(arb(x0) - enclosed)) for x0, enclosed in pairs),
    )


def main(arguments: Sequence[str] | None = None) -> int:
    """Prove onsets, and count what became of them."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--points", type=int, default=300)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    options = parser.parse_args(arguments)
    places = map(anywhere, range(options.seed, options.seed + options.points))
    with ProcessPoolExecutor(options.jobs) as pool:
        every = list(track(pool.map(tried, places), total=options.points, description="proved"))
    for outcome, number in Counter((one.place.contact, one.outcome) for one in every).items():
        print(*outcome, f"{number} points", sep=": ")
    for one in every:
        if one.outcome.startswith("not proved"):
            print(one.outcome, one.place)
    worst = max(every, key=lambda one: one.off)
    print(f"largest radius of x0_slip, relative: {max(one.radius for one in every):.1E}")
    print(f"the solver is off by at most {worst.off:.1e} L, at {worst.place}")
    return 1 if worst.off > AGREES else 0
