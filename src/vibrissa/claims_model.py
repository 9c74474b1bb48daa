"""Claims of the paper's abstract and Sections II and III, up to the model.

Each is a function of the evidence; where it calls a solver or takes a number from elsewhere, that
can be replaced by keyword. The verdict follows from the numbers.
"""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.optimize import brentq

from vibrissa import shooting
from vibrissa.api import EquilibriumState, solve_curve, solve_state
from vibrissa.arrays import FloatArray
from vibrissa.bending import solve_and_measure
from vibrissa.evidence import Evidence, bending_of_steps
from vibrissa.judging import (
    AMBIGUOUS,
    CONDITION,
    CONTRADICTED,
    EXAMPLE,
    HOLDS,
    NEGLIGIBLE,
    rises,
)
from vibrissa.ledger import Finding, claim
from vibrissa.rod import rod_equations
from vibrissa.taper import diameter
from vibrissa.units import Rod

# The force on the example rod, in units of E·I0/L² and in N.
EXAMPLE_F, EXAMPLE_FORCE = 10.86, 7000.0
# Tensile strength of music wire, ASTM A228, the strongest of the wrought carbon steels, in Pa:
# https://www.makeitfrom.com/material-properties/ASTM-A228-SWP-A-K08500-Music-Wire
# Generous: it yields earlier, and a wire as thick as 5 mm is weaker.
STEEL_STRENGTH = 2.45e9


@claim(
    "pushed",
    "abstract",
    "The clamp is moved such that the tip is pushed.",
    "x1 − x0 in every state of the scans; how far the clamp could move the other way at θ = 2, "
    "μ0 = 0.4 before tan α is μ0",
)
def pushed(evidence: Evidence, solve: Callable[..., EquilibriumState] = solve_state) -> Finding:
    offset = (evidence.scan["x1"] - evidence.scan["footpoint"]).to_numpy()
    forward = all(rises(rows["footpoint"].to_numpy()) for _, rows in evidence.scans())
    x1 = solve_curve(2.0, evidence.eta).x1_init

    def excess(x0: float) -> float:
        state = solve(2.0, evidence.eta, x1 + x0)
        return state.reaction_fx + 0.4 * state.reaction_fy

    pulled = brentq(excess, 0.0, 0.9 * (math.sqrt(1.0 - evidence.eta**2) - x1), xtol=1e-10)
    figures = {
        "smallest x1 − x0": (offset.min(), "L"),
        "displacement when pushed": (float(evidence.by_theta("x0_slip").loc[2.0, 0.4]), "L"),
        "displacement when pulled": (pulled, "L"),
    }
    if forward and offset.min() > 0.0:
        reason = "the clamp moves towards the tip; pulled, it would slip much earlier"
        return Finding(HOLDS, reason, figures)
    return Finding(CONTRADICTED, "the tip is not always ahead of the clamp", figures)


@claim(
    "event frequency",
    "II",
    "While a fixed length is scanned, stick-slip events come at a frequency of their own for each "
    "μ0.",
    "events per length, 1/x0 at the exact onset, over the μ0 of Figure 7",
)
def event_frequency(evidence: Evidence) -> Finding:
    rows = evidence.slipping()
    frequency = 1.0 / rows["x0_slip"].to_numpy()
    stepped = 1.0 / (rows["x0_max"].to_numpy() + evidence.dx0)
    figures = {
        "events per L at the smallest μ0": (frequency[0], "1/L"),
        "events per L at the largest μ0": (frequency[-1], "1/L"),
        "values of μ0": (len(rows), "1"),
        "frequencies told apart on the step grid": (len(np.unique(stepped)), "1"),
        "values of μ0 without any event": (len(evidence.friction) - len(rows), "1"),
    }
    if not rises(-frequency):
        return Finding(CONTRADICTED, "two values of μ0 have one frequency", figures)
    if len(rows) < len(evidence.friction):
        reason = "the frequency is one-to-one, but above μ_lock there are no events at all"
        return Finding(CONDITION, reason, figures)
    return Finding(HOLDS, "the frequency is one-to-one", figures)


@claim(
    "force unit",
    "III",
    "For the example rod of steel a dimensionless force of 10.86 is a force of 7000 N.",
    "f·E·I0/L² with I0 = π·d0⁴/64",
)
def force_unit(evidence: Evidence, rod: Rod = EXAMPLE) -> Finding:
    force = EXAMPLE_F * rod.force_unit
    figures = {"force": (force, "N"), "unit of force": (rod.force_unit, "N")}
    # As far as the digits of f go.
    if abs(force / EXAMPLE_FORCE - 1.0) < 0.005 / EXAMPLE_F + 1e-4:
        return Finding(HOLDS, "it is, rounded", figures)
    return Finding(CONTRADICTED, "it is another force", figures)


@claim(
    "example rod",
    "III",
    "A steel rod of d0 = 5 mm and L = 100 mm is an example of the beam.",
    "largest strain max|φ'|·d/(2L) in the states of Figures 3 to 5, against tensile strength over "
    "E of the strongest carbon steel wire (music wire, ASTM A228, by makeitfrom.com)",
)
def example_rod(evidence: Evidence, rod: Rod = EXAMPLE) -> Finding:
    slenderness = rod.base_diameter / rod.length
    limit = STEEL_STRENGTH / rod.youngs_modulus
    strain = slenderness * bending_of_steps(evidence.scan).strain
    first = strain[evidence.scan["x0"] == 0.0]
    curve = solve_curve(1.0, evidence.eta)
    x0 = brentq(lambda x: float(curve.state(x).f) - EXAMPLE_F, 0.0, curve.x0_lock)
    at = curve.state(x0)
    (bent,) = solve_and_measure(
        *(np.array([v]) for v in (1.0, at.f, at.alpha, curve.x1_init - x0, evidence.eta))
    ).strain
    figures = {
        "smallest strain of a first state": (100 * first.min(), "%"),
        "largest strain of all states": (100 * strain.max(), "%"),
        "strain of the cylinder under f = 10.86": (100 * bent * slenderness, "%"),
        "tensile strength of the wire": (STEEL_STRENGTH / 1e6, "MPa"),
        "strain that it bears": (100 * limit, "%"),
        "largest base diameter that stays below": (
            1e3 * rod.base_diameter * limit / strain.max(),
            "mm",
        ),
    }
    if first.min() > limit:
        return Finding(
            CONTRADICTED, "the strongest carbon steel does not bear even the first states", figures
        )
    if strain.max() > limit:
        return Finding(CONDITION, "only states of small strain can be borne", figures)
    return Finding(HOLDS, "all states can be borne", figures)


def printed_diameter(s: float, theta: float, length: float = 1.0) -> float:
    """Equation (1) as printed, in units of d0, with d1 = d0/θ put in."""
    return 1.0 - (1.0 - 1.0 / theta**2) / length * s


@claim(
    "taper of eq. (1)",
    "III",
    "Equation (1) is the tapered rod with θ = d0/d1 that equation (2) is derived from.",
    "tip diameter by (1) as printed and by the stiffness in (2), for the θ of Figure 6",
)
def printed_taper(
    evidence: Evidence, printed: Callable[[float, float], float] = printed_diameter
) -> Finding:
    tapers = evidence.by_theta("x0_slip").index.to_numpy()
    by_1 = np.array([printed(1.0, theta) for theta in tapers])
    # The stiffness is the reciprocal of the curvature under unit moment.
    state = np.array([0.0, 0.0, math.pi / 2])
    by_2 = np.array(
        [rod_equations(theta, 1.0, 0.0, -1.0, 0.0)(1.0, state)[2] ** -0.25 for theta in tapers]
    )
    corrected = diameter(1.0, tapers)
    figures = {
        "tip diameter by (1) at the largest θ": (by_1[-1], "d0"),
        "tip diameter by (2)": (by_2[-1], "d0"),
        "largest difference from (2) with d1 for d1/θ": (np.abs(corrected - by_2).max(), "d0"),
    }
    same = np.abs(by_1 - by_2) < NEGLIGIBLE
    if same.all():
        return Finding(HOLDS, "both are the same rod", figures)
    if not same[tapers > 1.0].any():
        reason = "(1) prints d1/θ where d1 must stand; they agree for the cylinder alone"
        return Finding(CONTRADICTED, reason, figures)
    return Finding(AMBIGUOUS, "they agree for some tapers", figures)


@claim(
    "arc length",
    "III",
    "The rod's length is L = s·[length] with s between 0 and 1, and equation (1) divides s by L.",
    "tip diameter by (1), its misprint mended, at s = 1 with L = 1 and with L = 100 mm, at θ = 2",
)
def arc_length(evidence: Evidence, length: float = 1e3 * EXAMPLE.length) -> Finding:
    def tip(length: float) -> float:
        return 1.0 - (1.0 - 1.0 / 2.0) / length * 1.0

    figures = {
        "tip diameter with L = 1": (tip(1.0), "d0"),
        "tip diameter with L = 100": (tip(length), "d0"),
    }
    if abs(tip(length) - tip(1.0)) < NEGLIGIBLE:
        return Finding(HOLDS, "s and L have one unit", figures)
    reason = "s is in units of L in (2), but in (1) only if L stands for 1; otherwise in mm"
    return Finding(AMBIGUOUS, reason, figures)


@claim(
    "sense of α",
    "III",
    "The force at the tip is inclined by α, counted counter-clockwise.",
    "moment in (2) against that of the force (0, −f) turned by ±α, at many states",
)
def sense_of_alpha(
    evidence: Evidence, equations: Callable[..., Callable[..., Any]] = rod_equations
) -> Finding:
    rows = evidence.scan.iloc[:: max(1, len(evidence.scan) // 50)]
    misfit = {1: 0.0, -1: 0.0}
    for row in rows.itertuples():
        x, y, phi = row.shape_x[25], row.shape_y[25], row.shape_phi[25]
        s, position = row.shape_s[25], (x, y, phi)
        bent = equations(row.theta, row.f, row.alpha, row.x1, row.eta)(s, np.array(position))[2]
        for sense in misfit:
            fx, fy = row.f * math.sin(sense * row.alpha), -row.f * math.cos(row.alpha)
            moment = (row.x1 - x) * fy - (row.eta - y) * fx
            expected = moment / float(diameter(s, row.theta)) ** 4
            misfit[sense] = max(misfit[sense], abs(bent - expected))
    figures = {
        "misfit, counter-clockwise": (misfit[1], "1/L"),
        "misfit, clockwise": (misfit[-1], "1/L"),
    }
    if misfit[1] < NEGLIGIBLE:
        return Finding(HOLDS, "(2) has the force f·(sin α, −cos α)", figures)
    return Finding(CONTRADICTED, "(2) has another force", figures)


@claim(
    "two unknowns",
    "III",
    "Equations (2) with the boundary conditions (3) have two unknown quantities.",
    "singular values of the derivative of the tip's miss with respect to f and α at θ = 2, and of "
    "the misses with a given φ1 as a third",
)
def two_unknowns(
    evidence: Evidence, shoot: Callable[..., tuple[float, float, float]] = shooting.shoot
) -> Finding:
    curve = solve_curve(2.0, evidence.eta)
    state = curve.state(0.5 * curve.x0_lock)
    x1 = curve.x1_init - 0.5 * curve.x0_lock

    def misses(f: float, alpha: float) -> FloatArray:
        x, y, phi = shoot(2.0, f, alpha, x1, evidence.eta)
        return np.array([x - x1, y - evidence.eta, phi])

    f, alpha, h = float(state.f), float(state.alpha), 1e-4
    derivative = np.stack(
        [
            (misses(f + h, alpha) - misses(f - h, alpha)) / (2 * h),
            (misses(f, alpha + h) - misses(f, alpha - h)) / (2 * h),
        ],
        axis=1,
    )
    both = np.linalg.svd(derivative[:2], compute_uv=False)
    rank = int((both > 1e-6 * both[0]).sum()) if both[0] > 0.0 else 0
    figures = {
        "smaller singular value": (both[-1], "1"),
        "larger singular value": (both[0], "1"),
        "unknowns that the tip's position determines": (rank, "1"),
        "conditions with a given φ1": (len(derivative), "1"),
        "independent ones of them": (np.linalg.matrix_rank(derivative), "1"),
    }
    if rank == 2:
        reason = (
            "f and α while the tip sticks, f and x1 at α = 0, if φ1 is read as a name for the "
            "outcome φ(1); as a given value it would be one condition too many"
        )
        return Finding(CONDITION, reason, figures)
    return Finding(CONTRADICTED, "the tip's position does not determine f and α", figures)


@claim(
    "shooting",
    "III",
    "A Runge–Kutta integration inside a simplex search, both MATLAB's own, solves the problem.",
    "the same procedure with MATLAB's default tolerances for the periods of Figures 4 and 5",
)
def default_shooting(
    evidence: Evidence, tolerances: shooting.Tolerances = shooting.PAPER
) -> Finding:
    off: list[int] = []
    worst = 0.0
    for (theta, mu0), rows in evidence.scans():
        walk = shooting.walk(theta, evidence.eta, evidence.dx0, mu0, tolerances)
        steps = int((rows["step"][rows["cycle"] == 1]).max()) - 1
        off.append(abs(len(walk) - 2 - steps))
        solved = rows["f"].to_numpy()[: steps + 1]
        shot = np.array([state.f for state in walk[: steps + 1]])
        worst = max(worst, float(np.abs(shot / solved[: len(shot)] - 1.0).max()))
    figures = {
        "periods": (len(off), "1"),
        "periods of another number of steps": (sum(steps > 0 for steps in off), "1"),
        "largest difference in steps": (max(off), "1"),
        "largest error of f": (100 * worst, "%"),
    }
    if max(off) == 0:
        return Finding(HOLDS, "every period has the right number of steps", figures)
    if max(off) == 1:
        reason = "with tighter tolerances than the defaults, which miss a step of some periods"
        return Finding(CONDITION, reason, figures)
    return Finding(CONTRADICTED, "periods end several steps early or late", figures)
