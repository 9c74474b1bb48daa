"""Solve random points of the whole range in both kinds of contact, and count their outcomes.

The taper is drawn log-uniformly from 1 to 20, the height uniformly from 0.3 to 0.999 and, for each
such rod, several friction coefficients uniformly from 0 to 2. Prints the number of points by status
and, above the lock, by the end of sticking; the largest residual; the smallest stability on the
paths; and every path that is not followed to its end.

With --mounted each rod has a mounting of its own, all four deviations at once: clamp_angle within
20 degrees, clamp_compliance up to 0.5, a linear curvature with coefficients within 0.5, and
stage_angle within 10 degrees.

Exit status 1 if a point fails, a residual is too large, or a path is not stable.
"""

import argparse
import sys
from collections import Counter

import numpy as np
from rich.progress import track

from vibrissa.mechanics.mounting import Mounting
from vibrissa.outcomes import Contact, End, RodSection, Status
from vibrissa.sticking.curve import StickingCurve
from vibrissa.sticking.solving.collocation import solve_curves

CHUNK = 64
# Bounds of clamp_angle, clamp_compliance, both coefficients of curvature, and stage_angle.
LEAST = (-np.radians(20), 0.0, -0.5, -0.5, -np.radians(10))
MOST = (np.radians(20), 0.5, 0.5, 0.5, np.radians(10))
# Number of displacements at which stability is evaluated on each path, all before its end: at the
# end it vanishes if the rod snaps.
LOOKS = 40
# Largest residual of a solved state.
RESIDUAL = 1e-11


def outcomes(curve: StickingCurve, mu0: np.ndarray) -> list[str]:
    """Return the outcome for each friction coefficient on a path."""
    if curve.status is not Status.SOLVED:
        return [curve.status.value] * len(mu0)
    locks = mu0 > curve.mu_lock
    ends = curve.motion_end(mu0[locks])[0] if locks.any() else []
    known = np.isfinite(curve.onset(mu0[~locks]))
    slips = ["slip" if one else "failed: no onset" for one in known]
    return slips + [f"lock, then {end}" for end in ends]


def mounting(random: np.random.Generator) -> Mounting:
    """Draw a random mounting."""
    angle, compliance, constant, slope, stage = random.uniform(LEAST, MOST)
    return Mounting(
        clamp_angle=angle,
        clamp_compliance=compliance,
        curvature=(constant, slope),
        stage_angle=stage,
    )


def survey(curves: int, points: int, seed: int, mounted: bool, section: RodSection) -> bool:
    """Solve the points and print their outcomes; return whether none fails."""
    good, random = True, np.random.default_rng(seed)
    theta = np.exp(random.uniform(0.0, np.log(20.0), curves))
    eta = random.uniform(0.3, 0.999, curves)
    mu0 = random.uniform(0.0, 2.0, (curves, points))
    mountings = [mounting(random) if mounted else Mounting() for _ in range(curves)]
    for model in Contact:
        counts: Counter[str] = Counter()
        residual, stability, odd = 0.0, np.inf, []
        for start in track(range(0, curves, CHUNK), description=model.value):
            part = slice(start, start + CHUNK)
            for curve, friction in zip(
                solve_curves(theta[part], eta[part], model, mountings[part], section),
                mu0[part],
                strict=True,
            ):
                counts.update(outcomes(curve, friction))
                reachable = curve.status is not Status.OUT_OF_REACH
                if curve.end is End.NOT_FOLLOWED and (reachable or not mounted):
                    odd.append(curve)
                if curve.status is Status.SOLVED:
                    residual = float(np.max([residual, curve.residual]))  # NaN stays NaN
                    states = curve.state(np.linspace(0.0, curve.x0_end, LOOKS, endpoint=False))
                    stability = float(np.min([stability, states.stability.min()]))
        print(f"\ncontact: {model}, {curves} curves, {sum(counts.values())} points")
        for outcome, number in counts.most_common():
            print(f"  {outcome:28}{number:8}")
        print(f"  largest residual            {residual:10.1e}")
        print(f"  least stability             {stability:10.1e}")
        failed = [name for name in counts if name.startswith(Status.FAILED)]
        good = good and not failed and residual < RESIDUAL and stability > 0.0
        for curve in odd:
            message = curve.message or curve.end_message
            print(
                f"  {curve.status}: theta {curve.theta!r}, eta {curve.eta!r}, "
                f"{curve.mounting}: {message}"
            )
    return good


def main() -> None:
    """Read the options and run."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--curves", type=int, default=2500)
    parser.add_argument("--points", type=int, default=20, help="for each curve")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--mounted", action="store_true", help="in random mountings")
    parser.add_argument("--section", type=RodSection, default=RodSection.ROUND)
    if not survey(**vars(parser.parse_args())):
        sys.exit("a point failed, a residual is too large, or a path is not stable")
