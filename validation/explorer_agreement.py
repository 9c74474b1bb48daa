"""Random points, solved by the explorer and by Python.

Both solve the same equations and share no code. At each point, these numbers are compared: the
displacement at which the tip slips; force, slope, contact point and clamp moment at this onset; the
critical friction coefficient; and where and how the path ends (`x0_end`, `ends_by`). Most points
have the ideal mounting, some have all deviations of the mounting at once; rods are round or planar.
The check fails if a number differs by more than the tolerance, or if one solver finds a state that
the other does not find.
"""

import argparse
import json
import sys
from dataclasses import replace
from itertools import product
from typing import Any, NamedTuple

import numpy as np

from validation.node import Scripts, node
from validation.records import write_record
from vibrissa.explorer.modules import bundle
from vibrissa.mechanics.mounting import IDEAL, Mounting
from vibrissa.outcomes import Contact, End, RodSection
from vibrissa.sticking.curve import StickingCurve
from vibrissa.sticking.solving.collocation import solve_curves
from vibrissa.wording import markdown_table

TOLERATED = 1e-10
CHUNK = 50
THETA, ETA, MU0 = (1.0, 8.0), (0.4, 0.97), (0.02, 1.0)
# Ranges of β, c, κ0 at the clamp and at the tip, and δ.
# Bounds of the stiffening, and of the bore over the diameter of the tip; no bore below 0.
STIFFENED = ((-0.7, 3.0), (-0.8, 0.8))
DEVIATIONS = ((-0.2, 0.2), (0.0, 0.3), (-0.4, 0.3), (-0.4, 0.4), (-0.1, 0.1))
QUANTITIES = ("x0_slip", "f", "alpha", "phi1", "s_c", "reaction_m", "mu_lock", "x0_end", "ends_by")
# Ends of paths in the page's program; `ends_by` is the place in this list.
ENDS = {
    "swings": End.SWINGS_ASIDE,
    "snaps": End.SNAPS,
    "lifts": End.LIFTS_OFF,
    "inadmissible": End.OUT_OF_REACH,
    "lost": End.NOT_FOLLOWED,
}
PROGRAM = """
function answer({ theta, eta, contact, mu0, mounting, section }) {
  const round = section === "round";
  const { path, message } = solvedPath({ theta, eta, contact, round, mounting });
  if (!path) return { message };
  const found = { mu_lock: path.muLock, end: path.pushed.end, nodes: path.branch.rod.nodes };
  found.x0_end = path.x0End;
  const slip = onset(path, mu0);
  if (!slip) return found;
  return {
    ...found,
    x0_slip: displacement(path.branch, slip),
    f: force(slip), alpha: inclination(slip), phi1: slip.phi1, s_c: slip.sc, reaction_m: slip.m,
  };
}
"""


class Point(NamedTuple):
    """A rod, its contact with the surface, and the friction coefficient."""

    theta: float
    eta: float
    mu0: float
    contact: Contact
    mounting: Mounting = IDEAL
    section: RodSection = RodSection.ROUND

    def asked(self) -> dict[str, Any]:
        """Return the point as input of the page's solver."""
        mounting = {
            "angle": self.mounting.clamp_angle,
            "compliance": self.mounting.clamp_compliance,
            "curvature": self.mounting.coefficients,
            "stage": self.mounting.stage_angle,
            "making": self.mounting.making._asdict(),
        }
        return self._asdict() | {"mounting": mounting}


def points(
    count: int,
    seed: int,
    contact: Contact,
    *,
    mounted: bool = False,
    stiffened: bool = False,
    section: RodSection = RodSection.ROUND,
) -> list[Point]:
    """Draw random points in one kind of contact; if `mounted`, with random mountings.

    If `stiffened`, the modulus changes along the rods, and half of them have a bore.
    """
    random = np.random.default_rng(seed)
    values = np.column_stack([random.uniform(*span, count) for span in (THETA, ETA, MU0)])
    deviations = np.column_stack([random.uniform(*span, count) for span in DEVIATIONS])
    mountings = [
        Mounting(
            clamp_angle=angle,
            clamp_compliance=compliance,
            curvature=(bend, at_tip - bend),
            stage_angle=stage,
        )
        for angle, compliance, bend, at_tip, stage in deviations.tolist()
    ]
    mountings = mountings if mounted else [IDEAL] * count
    if stiffened:
        made = random.uniform(*zip(*STIFFENED, strict=True), (count, 2)).tolist()
        mountings = [
            replace(one, stiffening=stiffening, bore=max(0.0, wall) / theta)
            for one, (stiffening, wall), (theta, *_) in zip(mountings, made, values, strict=True)
        ]
    drawn = zip(values.tolist(), mountings, strict=True)
    return [Point(*value, contact, mounting, section) for value, mounting in drawn]


def in_python(wanted: list[Point]) -> list[dict[str, float]]:
    """Solve points of one kind of contact in Python."""
    found = []
    for start in range(0, len(wanted), CHUNK):
        theta, eta, mu0, contact, mountings, section = zip(
            *wanted[start : start + CHUNK], strict=True
        )
        rods = np.array(theta), np.array(eta)
        curves = solve_curves(*rods, contact[0], mountings, section[0])
        found += [numbers(*pair) for pair in zip(curves, mu0, strict=True)]
    return found


def numbers(curve: StickingCurve, mu0: float) -> dict[str, float]:
    """Return the quantities of a point on its path; those that do not exist are left out."""
    if not curve.pieces:
        return {}
    x0 = curve.onset(mu0)
    answer = {
        "x0_slip": float(x0),
        "mu_lock": curve.mu_lock,
        "x0_end": curve.x0_end,
        "ends_by": float([*ENDS.values()].index(curve.end)),
    }
    if np.isfinite(x0):
        state = curve.state(x0)
        seen = ("f", "alpha", "phi1", "s_c", "reaction_m")
        answer |= {name: float(getattr(state, name)) for name in seen}
    return {name: value for name, value in answer.items() if np.isfinite(value)}


def in_javascript(page: Scripts, wanted: list[Point]) -> list[dict[str, Any]]:
    """Solve points in the page's own program."""
    asked = json.dumps([point.asked() for point in wanted])
    answers = json.loads(page.evaluate(f"JSON.stringify({asked}.map(answer))"))
    # A number that is not finite is null in JSON.
    found = [{key: value for key, value in row.items() if value is not None} for row in answers]
    places = {name: float(place) for place, name in enumerate(ENDS)}
    return [row | {"ends_by": places[row["end"]]} if "end" in row else row for row in found]


def open_solver(page: Scripts) -> None:
    """Load the solver."""
    page.evaluate(f"{bundle('solver/path.js')}\n{PROGRAM}; 0")


def differences(python: dict[str, float], browser: dict[str, Any]) -> dict[str, float]:
    """Return the difference of each number; infinite if only one solver found it."""
    return {
        name: abs(python.get(name, np.inf) - browser.get(name, np.inf))
        for name in QUANTITIES
        if name in python or name in browser
    }


def compared(wanted: list[Point], page: Scripts) -> list[dict[str, float]]:
    """Compare points of one kind of contact."""
    pairs = zip(in_python(wanted), in_javascript(page, wanted), strict=True)
    return [differences(*pair) for pair in pairs]


def table(found: dict[str, list[dict[str, float]]]) -> str:
    """Format the largest differences in Markdown, a column for each kind of point."""
    rows = [["points", *(str(len(points)) for points in found.values())]]
    for name, what in (("mu_lock", "a path"), ("x0_slip", "an onset of slip")):
        numbers = (sum(name in point for point in points) for points in found.values())
        rows.append([f"points with {what}", *map(str, numbers)])
    for name in QUANTITIES:
        largest = (max(one.get(name, 0.0) for one in points) for points in found.values())
        rows.append([f"`{name}`", *(f"{value:.1e}" for value in largest)])
    return markdown_table(["largest difference", *found], rows)


def main() -> None:
    """Read the options, and compare random points."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--points", type=int, default=500, help="in each kind of contact")
    parser.add_argument("--mounted", type=int, default=500)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--record", action="store_true", help="write the record")
    options = parser.parse_args()
    found: dict[str, list[dict[str, float]]] = {}
    with node() as page:
        open_solver(page)
        for kind, count in {"ideal": options.points, "mounted": options.mounted}.items():
            for contact, section in product(Contact, RodSection):
                # Other rods in each kind of contact, half of them round.
                seed = options.seed + len(found)
                mounted = kind == "mounted"
                wanted = points(count // 2, seed, contact, mounted=mounted, section=section)
                found[f"{kind}, {contact}, {section}"] = compared(wanted, page)
    print(table(found))
    if options.record:
        write_record("explorer-agreement", __doc__, table(found))
    worst = max(value for rows in found.values() for row in rows for value in row.values())
    if not worst < TOLERATED:
        sys.exit(f"a number differs by {worst:.1e}")
