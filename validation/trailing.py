"""Check the last sticking states of random laterally buckled rods by multiple shooting.

Each point has a taper of 1 to 20 (log-uniform), a height of 0.3 to 0.98 and a friction coefficient
between μ_lock and 3. The state in retraction in which the tip slips is solved again,
independently: integrated by DOP853 from the contact point to the clamp, in so many parts that
errors grow little. Prints the largest difference of the displacements; fails if a difference, or a
gap between two parts, exceeds 1e-11.
"""

import argparse
import sys
from typing import NamedTuple

import numpy as np
from rich.progress import track
from scipy.integrate import solve_ivp
from scipy.optimize import root

from vibrissa.mechanics.elastica import deformed_shape
from vibrissa.outcomes import Contact, Status
from vibrissa.sticking.curve import StickingCurve
from vibrissa.sticking.solving.collocation import solve_curves

CHUNK = 64
# Tolerance of the integration; tolerance of displacements (L) and of gaps between parts.
TOLERANCE, TOLERATED = 1e-13, 1e-11
# Errors grow by about exp(GROWTH) in a part; the start has relative errors up to OFF.
GROWTH, OFF = 3.0, 1e-5
MOST_FRICTION = 3.0


class Pulled(NamedTuple):
    """Multiple shooting for the state in retraction in which the tip slips.

    Attributes
    ----------
    theta, eta, mu0 : float
    contact : str
        Kind of contact.
    parts : int
        Number of parts in which the rod is integrated.
    """

    theta: float
    eta: float
    mu0: float
    contact: str
    parts: int

    def ends(self, s_c: float) -> np.ndarray:
        """Return the ends of the parts (arc lengths), from the contact point to the clamp."""
        # Parts of equal length in the phase of the bending waves of a cone.
        phase = s_c / (self.theta - (self.theta - 1) * s_c) * np.linspace(1, 0, self.parts + 1)
        return self.theta * phase / (1 + (self.theta - 1) * phase)

    def reached(self, unknowns: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
        """Return s_c, and x, y, φ and m at the start and at the end of each part.

        `unknowns` are φ1 (in line contact s_c), the normal force, and x, y, φ and m at the start of
        all parts but the first.
        """
        first, force = unknowns[:2]
        s_c, angle = (first, 0.0) if self.contact == "line" else (1.0, first)
        starts = np.vstack([[0.0, 0.0, angle, 0.0], unknowns[2:].reshape(-1, 4)])
        s = self.ends(s_c)
        bounds = zip(s, s[1:], starts, strict=False)
        return s_c, starts, np.array([self.integrated(*part, force) for part in bounds])

    def gaps(self, unknowns: np.ndarray) -> np.ndarray:
        """Return the gaps between parts, and of the last part to the clamp (height and angle)."""
        _, starts, stops = self.reached(unknowns)
        clamp = stops[-1, 1:3] - [-self.eta, np.pi / 2]
        return np.append((stops[:-1] - starts[1:]).ravel(), clamp)

    def offset(self, unknowns: np.ndarray) -> float:
        """Distance of the tip from the clamp along the surface (L)."""
        s_c, _, stops = self.reached(unknowns)
        return float(1 - s_c - stops[-1, 0])

    def integrated(self, start: float, stop: float, state: np.ndarray, force: float) -> np.ndarray:
        """Integrate x, y, φ and m from `start` to `stop`; the contact point is the origin."""

        def derivative(s: float, state: np.ndarray) -> list[float]:
            _, _, phi, m = state
            d = 1 - (1 - 1 / self.theta) * s
            cos, sin = np.cos(phi), np.sin(phi)
            return [cos, sin, m / d**4, force * (cos + self.mu0 * sin)]

        settings = {"method": "DOP853", "rtol": TOLERANCE, "atol": TOLERANCE}
        return solve_ivp(derivative, (start, stop), state, **settings).y[:, -1]


def checked(
    curve: StickingCurve, mu0: float, random: np.random.Generator
) -> tuple[float, float] | None:
    """Return the difference of x0_trail (L) and the largest gap; None if x0_trail is unknown."""
    trail = float(curve.trailing_end(mu0).x0)
    if not np.isfinite(trail):
        return None
    x0 = 2 * curve.x0_end - trail
    state = curve.state(np.array([x0])).take(0)
    s_c, offset = float(state.s_c), curve.x1_init - x0
    contact = str(curve.contact(x0))
    growth = curve.theta * np.sqrt(float(state.f)) * s_c
    pulled = Pulled(curve.theta, curve.eta, mu0, contact, 1 + int(growth / GROWTH))
    inner = pulled.ends(s_c)[1:-1]
    s = np.concatenate([[0.0], inner[::-1], [s_c]])
    shape = deformed_shape(
        curve.theta, float(state.f), float(state.alpha), offset, curve.eta, s, s_c, curve.mounting
    )
    x, y, phi = (values[-2:0:-1] for values in shape)
    x, y = x - (offset - (1 - s_c)), y - curve.eta
    fx, fy = float(state.reaction_fx), float(state.reaction_fy)
    begins = np.stack([x, y, phi, y * fx - x * fy], axis=-1)
    start = np.concatenate([[s_c if contact == "line" else float(state.phi1), -fy], begins.ravel()])
    start *= 1 + OFF * random.uniform(-1, 1, size=start.shape)
    solved = root(pulled.gaps, start, method="hybr", options={"xtol": 1e-14}).x
    gap = float(np.abs(pulled.gaps(solved)).max())
    return abs(pulled.offset(solved) - offset), gap


def check_all(points: int, seed: int) -> None:
    """Check a number of random points in each kind of contact."""
    random = np.random.default_rng(seed)
    failed = []
    for model in Contact:
        theta = np.exp(random.uniform(0, np.log(20), points))
        eta, share = random.uniform(0.3, 0.98, points), random.uniform(size=points)
        differences = []
        for begin in track(range(0, points, CHUNK), description=model.value):
            part = slice(begin, begin + CHUNK)
            curves = solve_curves(theta[part], eta[part], model)
            for curve, way in zip(curves, share[part], strict=True):
                mu0 = curve.mu_lock + way * (MOST_FRICTION - curve.mu_lock)
                locks = curve.status is Status.SOLVED and curve.mu_lock < MOST_FRICTION
                found = checked(curve, mu0, random) if locks else None
                differences += [] if found is None else found[:1]
                if found and not np.max(found) <= TOLERATED:
                    failed.append(f"{model}: {curve.theta!r} {curve.eta!r} {mu0!r}: {found}")
        print(
            f"contact: {model}, {len(differences)} of {points} points have x0_trail; displacements "
            f"differ by up to {max(differences):.1e}"
        )
    if failed:
        sys.exit("\n".join(failed))


def main() -> None:
    """Read the options and run."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--points", type=int, default=1000, help="in each kind of contact")
    parser.add_argument("--seed", type=int, default=1)
    check_all(**vars(parser.parse_args()))
