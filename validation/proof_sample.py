"""Prove onsets of slip at random points, far beyond the paper's grid; used by `make proof-sample`.

Usage: python validation/proof_sample.py [--points N] [--seed N] [--jobs N]

θ from 1 to 8, η from 0.4 to 0.97, μ0 up to 0.98 of the critical friction coefficient, in tip
contact. What cannot be proved is printed with its reason. Exit status 1 if the solver is further
from a proved onset than 1e-11 L.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from decimal import Decimal

import numpy as np

from vibrissa import proof, solve_curve
from vibrissa.decimals import exact
from vibrissa.errors import NotProvedError
from vibrissa.outcomes import Status

THETA, ETA, SHARE = (1.0, 8.0), (0.4, 0.97), (0.02, 0.98)
# The solver promises a residual of 1e-12; next to the lock an onset is off by more.
AGREES = 1e-11


@dataclass(frozen=True, kw_only=True)
class Tried:
    """What became of a point."""

    point: str
    radius: Decimal | None = None  # of x0_slip, relative
    off: float = 0.0  # of the solver's x0_slip (L)
    bent_once: bool = False
    penetrates: bool = False
    note: str = ""


def tried(seed: int) -> Tried:
    """Prove one random point."""
    draw = np.random.default_rng(seed)
    theta, eta = (exact(round(float(draw.uniform(*span)), 4)) for span in (THETA, ETA))
    curve = solve_curve(float(theta), float(eta))
    point = f"theta {theta}, eta {eta}"
    if curve.status is not Status.SOLVED or not np.isfinite(curve.mu_lock):
        return Tried(point=point, note=f"no lock: {curve.message or 'the tip lifts off'}")
    mu0 = exact(round(float(draw.uniform(*SHARE)) * curve.mu_lock, 4))
    point += f", mu0 {mu0}"
    try:
        found = proof.onset(theta, mu0, eta)
    except NotProvedError as error:
        return Tried(point=point, note=str(error))
    middle, radius = proof.decimals(found.x0_slip)
    solved = float(curve.onset([float(mu0)])[0])
    return Tried(
        point=point,
        radius=radius / middle,
        off=abs(float(Decimal(solved) - middle)),
        bent_once=found.bent_once,
        penetrates=bool(found.slip.phi1 < 0),
    )


def main(argv: Sequence[str]) -> int:
    parser = argparse.ArgumentParser(description="Prove onsets of slip at random points.")
    parser.add_argument("--points", type=int, default=300)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    options = parser.parse_args(argv)
    begin = time.monotonic()
    with ProcessPoolExecutor(options.jobs) as pool:
        seeds = range(options.seed, options.seed + options.points)
        every = list(pool.map(tried, seeds))
    good = [one for one in every if one.radius is not None]
    print(f"{len(good)} of {len(every)} points are proved, in {time.monotonic() - begin:.0f} s")
    if good:
        radii = sorted(one.radius for one in good if one.radius is not None)
        print(f"radius of x0_slip, relative: median {radii[len(radii) // 2]:.1E}, ", end="")
        print(f"largest {radii[-1]:.1E}")
        print(f"bent once at alpha = 0, proved: {sum(one.bent_once for one in good)}")
        print(f"passing through the surface (phi1 < 0): {sum(one.penetrates for one in good)}")
        worst = max(good, key=lambda one: one.off)
        print(f"the solver is off by at most {worst.off:.1e} L, at {worst.point}")
    for one in every:
        if one.note:
            print(f"not proved: {one.point}: {one.note}")
    return 1 if any(one.off > AGREES for one in good) else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
