"""Prove onsets of slip at random points, far beyond the paper's grid.

θ from 1 to 8, η from 0.4 to 0.97, μ0 up to 0.98 of the critical friction coefficient; every point
in tip contact or in line contact, by chance. With a study file: random points of its grids, in the
study's contact. Points are printed as they are done, and in the end a
table: how many are proved, and why the others are not. Exit status 1 if the solver is further from
a proved onset than 1e-11 L.
"""

from __future__ import annotations

import argparse
import os
import random
import sys
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from decimal import Decimal
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np

from validation.enclosures import points_of_rods
from vibrissa import proof, solve_curve
from vibrissa.decimals import exact
from vibrissa.errors import NotProvedError, VibrissaError
from vibrissa.outcomes import Contact
from vibrissa.study.reading import read_study

THETA, ETA, SHARE = (1.0, 8.0), (0.4, 0.97), (0.02, 0.98)
# The solver promises a residual of 1e-12; next to the lock an onset is off by more.
AGREES = 1e-11
NO_LOCK = "there is no critical state"
SELF_LOCKING = "self-locking, there is no onset"


@dataclass(frozen=True, kw_only=True)
class Tried:
    """What became of a point."""

    point: str
    contact: Contact
    seconds: float
    kinds: str = ""  # contact of the first and the last state, where it is proved
    radius: Decimal | None = None  # of x0_slip, relative
    off: float = 0.0  # of the solver's x0_slip (L)
    bent_once: bool = False
    note: str = ""

    def __str__(self) -> str:
        """Say what became of it."""
        what = self.note or f"{self.kinds}, radius {self.radius:.1E}, off {self.off:.1e}"
        return f"{self.point}: {what}, {self.seconds:.1f} s"


@dataclass(frozen=True, kw_only=True)
class Place:
    """Where to prove an onset: at μ0, or at a share of the critical friction coefficient."""

    theta: Decimal
    eta: Decimal
    contact: Contact
    share: float = 0.0
    mu0: Decimal | None = None


def anywhere(seed: int) -> Place:
    """Draw a random point."""
    draw = np.random.default_rng(seed)
    theta, eta = (exact(round(float(draw.uniform(*span)), 4)) for span in (THETA, ETA))
    share, contact = float(draw.uniform(*SHARE)), Contact(draw.choice(list(Contact)))
    return Place(theta=theta, eta=eta, contact=contact, share=share)


def of_study(path: Path, number: int, seed: int) -> list[Place]:
    """Draw random points of a study's grids."""
    study = read_study(path)
    points = [
        Place(theta=theta, eta=eta, contact=study.contact, mu0=mu0)
        for (theta, eta), pairs in points_of_rods(study.name, study.grids.values()).items()
        for mu0 in dict.fromkeys(mu0 for mu0, _ in pairs)
    ]
    return random.Random(seed).sample(points, min(number, len(points)))


def tried(place: Place) -> Tried:
    """Prove the onset at a point."""
    begin = time.process_time()
    theta, eta, contact = place.theta, place.eta, place.contact
    point = f"{contact}, theta {theta}, eta {eta}"

    def became(**found: Any) -> Tried:
        seconds = time.process_time() - begin
        return Tried(point=point, contact=contact, seconds=seconds, **found)

    curve = solve_curve(float(theta), float(eta), contact=contact)
    if not np.isfinite(curve.mu_lock):
        return became(note=f"{NO_LOCK}: {curve.message or 'the tip lifts off'}")
    mu0 = place.mu0 or exact(round(place.share * curve.mu_lock, 4))
    point += f", mu0 {mu0}"
    if mu0 > curve.mu_lock:
        return became(note=SELF_LOCKING)
    try:
        found = proof.onset(theta, mu0, eta, contact=contact)
    except NotProvedError as error:
        return became(note=str(error))
    middle, radius = proof.decimals(found.x0_slip)
    solved = float(curve.onset([float(mu0)])[0])
    return became(
        kinds=f"{found.init.contact} to {found.slip.contact}",
        radius=radius / middle,
        off=abs(float(Decimal(solved) - middle)),
        bent_once=found.bent_once,
    )


def table(every: Sequence[Tried]) -> Iterator[str]:
    """Count the points by what became of them, for each kind of contact, in Markdown."""
    yield f"| {' | '.join(['', *Contact])} |"
    yield f"| --- |{' --- |' * len(Contact)}"
    outcomes = [one.kinds or one.note.partition(":")[0] for one in every]
    proved = sorted({one.kinds for one in every if one.kinds})
    for outcome in [*proved, *sorted(set(outcomes) - set(proved))]:
        counts = [
            sum(
                o == outcome and one.contact is contact
                for one, o in zip(every, outcomes, strict=True)
            )
            for contact in Contact
        ]
        name = f"proved, {outcome}" if outcome in proved else f"not proved: {outcome}"
        yield f"| {name} | {' | '.join(map(str, counts))} |"


def summary(every: Sequence[Tried]) -> Iterator[str]:
    """Say how narrow the enclosures are, and how far the solver is off."""
    good = [one for one in every if one.radius is not None]
    seconds = sorted(one.seconds for one in every)
    yield f"{len(good)} of {len(every)} points are proved"
    yield f"processor time of a point: median {median(seconds):.1f} s, longest {seconds[-1]:.1f} s"
    if good:
        radii = [one.radius for one in good if one.radius is not None]
        yield f"radius of x0_slip, relative: median {median(radii):.1E}, largest {max(radii):.1E}"
        yield f"bent once at alpha = 0, proved: {sum(one.bent_once for one in good)}"
        worst = max(good, key=lambda one: one.off)
        yield f"the solver is off by at most {worst.off:.1e} L, at {worst.point}"


def main(argv: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description="Prove onsets of slip at random points.")
    parser.add_argument("--points", type=int, default=300)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--configfile", type=Path, help="points of this study instead")
    options = parser.parse_args(argv)
    try:
        places = (
            of_study(options.configfile, options.points, options.seed)
            if options.configfile
            else [anywhere(options.seed + number) for number in range(options.points)]
        )
    except VibrissaError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    every = []
    with ProcessPoolExecutor(options.jobs) as pool:
        for one in pool.map(tried, places):
            every.append(one)
            print(f"{len(every)} of {len(places)}: {one}", flush=True)
    for line in (*table(every), *summary(every)):
        print(line)
    return 1 if any(one.off > AGREES for one in every) else 0
