"""Random points, solved by the explorer and by Python.

Both solve the same equations and share no code. For each point are compared: the displacement at
which the tip slips, force, slope and contact point there, the critical friction coefficient, and
where a locked rod buckles laterally. Most points are of the ideal mounting, some of mountings with
all deviations at once. Fails if a number differs by more than 1e-8, or if one solver finds
a state that the other does not.
"""

import argparse
import json
import sys
from dataclasses import dataclass
from typing import Any

import numpy as np

from validation.node import Scripts, node
from validation.records import write_record
from vibrissa.explorer.modules import bundle
from vibrissa.mechanics.mounting import IDEAL, Mounting
from vibrissa.outcomes import Contact, End
from vibrissa.sticking.solving.collocation import solve_curves

TOLERATED = 1e-8
CHUNK = 50
THETA, ETA, MU0 = (1.0, 8.0), (0.4, 0.97), (0.02, 1.0)
# β, c, κ0 at the clamp and at the tip, δ.
DEVIATIONS = ((-0.2, 0.2), (0.0, 0.3), (-0.4, 0.3), (-0.4, 0.4), (-0.1, 0.1))
QUANTITIES = {
    "x0_slip": "x0,slip",
    "f": "f at the onset",
    "alpha": "α at the onset",
    "phi1": "φ1 at the onset",
    "s_c": "s_c at the onset",
    "m": "m(0) at the onset",
    "mu_lock": "μ_lock",
    "x0_end": "x0 where the rod buckles laterally",
}
PROGRAM = """
function answer({ theta, eta, contact, mu0, mounting }) {
  const { path, message } = solvedPath({ theta, eta, contact, round: true, mounting });
  if (!path) return { message };
  const found = { mu_lock: path.muLock, end: path.pushed.end, nodes: path.branch.rod.nodes };
  if (path.pushed.end === "swings") found.x0_end = path.x0End;
  const slip = onset(path, mu0);
  if (!slip) return found;
  return {
    ...found,
    x0_slip: displacement(path.branch, slip),
    f: force(slip), alpha: inclination(slip), phi1: slip.phi1, s_c: slip.sc, m: slip.m,
  };
}
"""


@dataclass(frozen=True, kw_only=True)
class Point:
    """One rod on one surface."""

    theta: float
    eta: float
    mu0: float
    contact: Contact
    mounting: Mounting = IDEAL

    def asked(self) -> dict[str, Any]:
        """Give the point as the page's solver takes it."""
        mounting = {
            "angle": self.mounting.clamp_angle,
            "compliance": self.mounting.clamp_compliance,
            "curvature": self.mounting.coefficients,
            "stage": self.mounting.stage_angle,
        }
        return vars(self) | {"mounting": mounting}


def points(count: int, seed: int, *, mounted: bool = False) -> list[Point]:
    """Draw points, half of them in each kind of contact."""
    random = np.random.default_rng(seed)
    values = np.column_stack([random.uniform(*span, count) for span in (THETA, ETA, MU0)])
    deviations = np.column_stack([random.uniform(*span, count) for span in DEVIATIONS])
    return [
        Point(
            theta=theta,
            eta=eta,
            mu0=mu0,
            contact=list(Contact)[number % 2],
            mounting=_mounting(*deviations[number].tolist()) if mounted else IDEAL,
        )
        for number, (theta, eta, mu0) in enumerate(values.tolist())
    ]


def _mounting(
    angle: float, compliance: float, bend: float, at_tip: float, stage: float
) -> Mounting:
    return Mounting(
        clamp_angle=angle,
        clamp_compliance=compliance,
        curvature=(bend, at_tip - bend),
        stage_angle=stage,
    )


def in_python(wanted: list[Point]) -> list[dict[str, float]]:
    """Solve points of one kind of contact in Python; what is not found is left out."""
    theta, eta = (np.array([getattr(point, name) for point in wanted]) for name in ("theta", "eta"))
    found = []
    mountings = [point.mounting for point in wanted]
    for point, curve in zip(
        wanted, solve_curves(theta, eta, wanted[0].contact, mountings), strict=True
    ):
        if not curve.pieces:
            found.append({})
            continue
        x0 = curve.onset(point.mu0)
        answer = {"x0_slip": float(x0), "mu_lock": curve.mu_lock}
        if curve.end is End.SWINGS_ASIDE:
            answer["x0_end"] = curve.x0_end
        if np.isfinite(x0):
            state = curve.state(x0)
            seen = ("f", "alpha", "phi1", "s_c")
            answer |= {name: float(getattr(state, name)) for name in seen}
            answer["m"] = float(state.reaction_m)
        found.append({name: value for name, value in answer.items() if np.isfinite(value)})
    return found


def in_javascript(page: Scripts, wanted: list[Point]) -> list[dict[str, Any]]:
    """Solve points in the page's own program."""
    asked = json.dumps([point.asked() for point in wanted])
    answers = json.loads(page.evaluate(f"JSON.stringify({asked}.map(answer))"))
    # A number that is not finite is null in JSON.
    return [{key: value for key, value in row.items() if value is not None} for row in answers]


def open_solver(page: Scripts) -> None:
    """Load the solver."""
    page.evaluate(f"{bundle('solver/path.js')}\n{PROGRAM}; 0")


def differences(python: dict[str, float], browser: dict[str, Any]) -> dict[str, float]:
    """Difference of each number; infinite where only one of the two found it."""
    return {
        name: abs(python.get(name, np.inf) - browser.get(name, np.inf))
        for name in QUANTITIES
        if name in python or name in browser
    }


def compared(wanted: list[Point], page: Scripts) -> dict[Contact, list[dict[str, float]]]:
    """Compare all points."""
    found: dict[Contact, list[dict[str, float]]] = {contact: [] for contact in Contact}
    for contact, rows in found.items():
        chosen = [point for point in wanted if point.contact is contact]
        for start in range(0, len(chosen), CHUNK):
            part = chosen[start : start + CHUNK]
            pairs = zip(in_python(part), in_javascript(page, part), strict=True)
            rows += [differences(*pair) for pair in pairs]
    return found


def table(found: dict[str, list[dict[str, float]]]) -> str:
    """Write the largest differences, in Markdown; a column for each kind of points."""
    lines = [
        f"| largest difference | {' | '.join(found)} |",
        f"| --- |{' --- |' * len(found)}",
    ]
    counts = {
        "points": lambda row: True,
        "of which a period begins": lambda row: "mu_lock" in row,
        "of which the tip slips": lambda row: "x0_slip" in row,
    }
    for text, counted in counts.items():
        number = " | ".join(str(sum(map(counted, rows))) for rows in found.values())
        lines.append(f"| {text} | {number} |")
    for name, text in QUANTITIES.items():
        largest = [max(row.get(name, 0.0) for row in rows) for rows in found.values()]
        lines.append(f"| {text} | {' | '.join(f'{value:.1e}' for value in largest)} |")
    return "\n".join(lines) + "\n"


def compare_all(count: int, mounted: int, seed: int, record: bool) -> None:
    """Compare random points."""
    found = {}
    with node() as page:
        open_solver(page)
        for name, wanted in {
            "ideal": points(count, seed),
            "mounted": points(mounted, seed, mounted=True),
        }.items():
            for contact, rows in compared(wanted, page).items():
                kind = "tip" if contact is Contact.POINT else "line"
                found[f"{name}, {kind} contact"] = rows
    print(table(found), end="")
    if record:
        write_record("explorer-agreement", __doc__, table(found))
    worst = max(value for rows in found.values() for row in rows for value in row.values())
    if not worst < TOLERATED:
        sys.exit(f"a number differs by {worst:.1e}")


def main() -> None:
    """Read the options and run."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--points", dest="count", type=int, default=2000)
    parser.add_argument("--mounted", type=int, default=600)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--record", action="store_true", help="write the record")
    compare_all(**vars(parser.parse_args()))
