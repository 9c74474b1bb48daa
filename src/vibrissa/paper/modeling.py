"""Claims of the paper's abstract and Sections II and III, up to the model."""

import math

import numpy as np
from scipy.optimize import brentq

from vibrissa.mechanics.bending import solve_and_measure
from vibrissa.mechanics.elastica import rod_equations
from vibrissa.mechanics.taper import diameter
from vibrissa.numerics.arrays import FloatArray
from vibrissa.paper.evidence import Evidence, bending_of_steps
from vibrissa.paper.judging import (
    AMBIGUOUS,
    CONDITION,
    CONTRADICTED,
    EXAMPLE,
    HOLDS,
    NEGLIGIBLE,
    holds_if,
    rises,
)
from vibrissa.paper.ledger import Judged, judges
from vibrissa.sticking.api import solve_curve, solve_state
from vibrissa.sticking.solving import shooting

# The force on the example rod, in units of E·I0/L² and in N.
EXAMPLE_F, EXAMPLE_FORCE = 10.86, 7000.0
# Half of the last digit of f, and rounding.
EXAMPLE_TOLERANCE = 0.005 / EXAMPLE_F + 1e-4
# Tensile strength of music wire, ASTM A228, the strongest of the wrought carbon steels, in Pa:
# https://www.makeitfrom.com/material-properties/ASTM-A228-SWP-A-K08500-Music-Wire
# Generous: it yields earlier, and a wire as thick as 5 mm is weaker.
STEEL_STRENGTH = 2.45e9


@judges("pushed")
def pushed(evidence: Evidence) -> Judged:
    offset = (evidence.scan["x1"] - evidence.scan["footpoint"]).to_numpy()
    forward = all(rises(rows["footpoint"].to_numpy()) for rows in evidence.scans())
    x1 = solve_curve(2.0, evidence.eta).x1_init

    def excess(x0: float) -> float:
        state = solve_state(2.0, evidence.eta, x1 + x0)
        return state.reaction_fx + 0.4 * state.reaction_fy

    pulled = brentq(excess, 0.0, 0.9 * (math.sqrt(1.0 - evidence.eta**2) - x1), xtol=1e-10)
    quantities = {
        "smallest x1 − x0": (offset.min(), "L"),
        "displacement when pushed": (evidence.by_theta("x0_slip").loc[2.0, 0.4], "L"),
        "displacement when pulled": (pulled, "L"),
    }
    return holds_if(forward and offset.min() > 0.0), quantities


@judges("event frequency")
def event_frequency(evidence: Evidence) -> Judged:
    rows = evidence.slipping()
    frequency = 1.0 / rows["x0_slip"].to_numpy()
    stepped = 1.0 / (rows["x0_max"].to_numpy() + evidence.dx0)
    quantities = {
        "events per L at the smallest μ0": (frequency[0], "1/L"),
        "events per L at the largest μ0": (frequency[-1], "1/L"),
        "values of μ0": (len(rows), "1"),
        "different frequencies on the step grid": (len(np.unique(stepped)), "1"),
        "values of μ0 above μ_lock": (len(evidence.locking()), "1"),
    }
    if not rises(-frequency):
        return CONTRADICTED, quantities
    if not len(evidence.locking()):
        return HOLDS, quantities
    dragged = evidence.trailing()["dragged"].to_numpy()
    if len(dragged) < len(evidence.locking()):
        reason = "the frequency is one-to-one up to μ_lock; above it some tips do not slip at all"
        return CONDITION, quantities, reason
    curve = solve_curve(float(rows["theta"].iloc[0]), evidence.eta)
    same = float(curve.friction_demand(dragged[-1]))
    quantities |= {
        "events per L of the dragged rod, largest μ0": (1.0 / dragged[-1], "1/L"),
        "μ0 at which a pushed rod has as many": (same, "1"),
    }
    if not rises(dragged):
        return CONTRADICTED, quantities, "two values of μ0 above μ_lock have one frequency"
    return CONDITION, quantities


@judges("force unit")
def force_unit(evidence: Evidence) -> Judged:
    force = EXAMPLE_F * EXAMPLE.force_unit
    quantities = {"force": (force, "N"), "unit of force": (EXAMPLE.force_unit, "N")}
    return holds_if(abs(force / EXAMPLE_FORCE - 1.0) < EXAMPLE_TOLERANCE), quantities


@judges("example rod")
def example_rod(evidence: Evidence) -> Judged:
    slenderness = EXAMPLE.base_diameter / EXAMPLE.length
    limit = STEEL_STRENGTH / EXAMPLE.youngs_modulus
    strain = slenderness * bending_of_steps(evidence.scan).strain
    first, largest = strain[evidence.scan["x0"] == 0.0].min(), strain.max()
    quantities = {
        "smallest strain of a first state": (100 * first, "%"),
        "largest strain of all states": (100 * largest, "%"),
        "strain of the cylinder under f = 10.86": (
            100 * slenderness * _strain_of_cylinder(EXAMPLE_F, evidence.eta),
            "%",
        ),
        "tensile strength of the wire": (STEEL_STRENGTH / 1e6, "MPa"),
        "strain at this strength": (100 * limit, "%"),
        "largest base diameter below it": (1e3 * EXAMPLE.base_diameter * limit / largest, "mm"),
    }
    if first > limit:
        return CONTRADICTED, quantities
    return (CONDITION if largest > limit else HOLDS), quantities


def _strain_of_cylinder(f: float, eta: float) -> float:
    """Largest strain (d0/L) of the cylinder where the contact force is f (E·I0/L²)."""
    curve = solve_curve(1.0, eta)
    x0 = brentq(lambda x: float(curve.state(x).f) - f, 0.0, curve.x0_lock)
    state = curve.state(x0)
    row = (1.0, state.f, state.alpha, curve.x1_init - x0, eta)
    return float(solve_and_measure(*(np.array([value]) for value in row)).strain[0])


def printed_diameter(s: float, theta: float, length: float = 1.0) -> float:
    """Equation (1) as printed, in units of d0, with d1 = d0/θ put in."""
    return 1.0 - (1.0 - 1.0 / theta**2) / length * s


@judges("taper of eq. (1)")
def printed_taper(evidence: Evidence) -> Judged:
    tapers = evidence.by_theta("x0_slip").index.to_numpy()
    by_1 = np.array([printed_diameter(1.0, theta) for theta in tapers])
    # The stiffness is the reciprocal of the curvature under unit moment.
    state = np.array([0.0, 0.0, math.pi / 2])
    by_2 = np.array(
        [rod_equations(theta, 1.0, 0.0, -1.0, 0.0)(1.0, state)[2] ** -0.25 for theta in tapers]
    )
    corrected = diameter(1.0, tapers)
    quantities = {
        "tip diameter by (1) at the largest θ": (by_1[-1], "d0"),
        "tip diameter by (2)": (by_2[-1], "d0"),
        "largest difference from (2) if (1) has d1 for d1/θ": (
            np.abs(corrected - by_2).max(),
            "d0",
        ),
    }
    same = np.abs(by_1 - by_2) < NEGLIGIBLE
    if same.all():
        return HOLDS, quantities
    return (CONTRADICTED if not same[tapers > 1.0].any() else AMBIGUOUS), quantities


@judges("arc length")
def arc_length(evidence: Evidence) -> Judged:
    def tip(length: float) -> float:
        return 1.0 - (1.0 - 1.0 / 2.0) / length * 1.0

    in_mm = tip(1e3 * EXAMPLE.length)
    quantities = {
        "tip diameter with L = 1": (tip(1.0), "d0"),
        "tip diameter with L = 100": (in_mm, "d0"),
    }
    return (HOLDS if abs(in_mm - tip(1.0)) < NEGLIGIBLE else AMBIGUOUS), quantities


@judges("sense of α")
def sense_of_alpha(evidence: Evidence) -> Judged:
    rows = evidence.scan.iloc[:: max(1, len(evidence.scan) // 50)]
    deviation = {1: 0.0, -1: 0.0}
    for row in rows.itertuples():
        s, x, y, phi = (
            values[25] for values in (row.shape_s, row.shape_x, row.shape_y, row.shape_phi)
        )
        slopes = rod_equations(row.theta, row.f, row.alpha, row.x1, row.eta)
        bent = slopes(s, np.array((x, y, phi)))[2]
        for sense in deviation:
            fx, fy = row.f * math.sin(sense * row.alpha), -row.f * math.cos(row.alpha)
            moment = (row.x1 - x) * fy - (row.eta - y) * fx
            expected = moment / float(diameter(s, row.theta)) ** 4
            deviation[sense] = max(deviation[sense], abs(bent - expected))
    quantities = {
        "deviation, counter-clockwise": (deviation[1], "1/L"),
        "deviation, clockwise": (deviation[-1], "1/L"),
    }
    return holds_if(deviation[1] < NEGLIGIBLE), quantities


@judges("two unknowns")
def two_unknowns(evidence: Evidence) -> Judged:
    curve = solve_curve(2.0, evidence.eta)
    state = curve.state(0.5 * curve.x0_lock)
    x1 = curve.x1_init - 0.5 * curve.x0_lock

    def misses(f: float, alpha: float) -> FloatArray:
        x, y, phi = shooting.shoot(2.0, f, alpha, x1, evidence.eta)
        return np.array([x - x1, y - evidence.eta, phi])

    f, alpha, h = float(state.f), float(state.alpha), 1e-4
    derivative = np.stack(
        [
            (misses(f + h, alpha) - misses(f - h, alpha)) / (2 * h),
            (misses(f, alpha + h) - misses(f, alpha - h)) / (2 * h),
        ],
        axis=1,
    )
    larger, smaller = np.linalg.svd(derivative[:2], compute_uv=False)
    rank = int(larger > 0.0) + int(smaller > 1e-6 * larger)
    quantities = {
        "smaller singular value": (smaller, "1"),
        "larger singular value": (larger, "1"),
        "unknowns that the tip's position determines": (rank, "1"),
        "conditions with a given φ1": (len(derivative), "1"),
        "independent ones of them": (np.linalg.matrix_rank(derivative), "1"),
    }
    return (CONDITION if rank == 2 else CONTRADICTED), quantities


@judges("shooting")
def default_shooting(evidence: Evidence) -> Judged:
    off: list[int] = []
    worst = 0.0
    for rows in evidence.first_periods():
        theta, mu0, steps = rows["theta"].iloc[0], rows["mu0"].iloc[0], len(rows) - 1
        walk = shooting.walk(theta, evidence.eta, evidence.dx0, mu0, shooting.PAPER)
        off.append(abs(len(walk) - 2 - steps))
        shot = np.array([state.f for state in walk[: steps + 1]])
        exact = rows["f"].to_numpy()[: len(shot)]
        worst = max(worst, float(np.abs(shot / exact - 1.0).max()))
    quantities = {
        "periods": (len(off), "1"),
        "periods with another number of steps": (sum(steps > 0 for steps in off), "1"),
        "largest difference in steps": (max(off), "1"),
        "largest error of f": (100 * worst, "%"),
    }
    if max(off) == 0:
        return HOLDS, quantities
    return (CONDITION if max(off) == 1 else CONTRADICTED), quantities
