"""Claims of the paper's abstract and of its Sections II and III."""

import math
from itertools import product

import numpy as np

from vibrissa.mechanics.elastica import rod_equations
from vibrissa.mechanics.taper import diameter
from vibrissa.numerics.arrays import FloatArray
from vibrissa.outcomes import SlipLaw
from vibrissa.paper.evidence import Evidence
from vibrissa.paper.judging import EXAMPLE, NEGLIGIBLE, ends, judged, rises
from vibrissa.paper.ledger import Finding, Quantities, judges
from vibrissa.scanning.cycles import steady_travel
from vibrissa.scanning.response import responses
from vibrissa.scanning.rods import MountedRod
from vibrissa.scanning.slip_model import SlipModel
from vibrissa.sticking.api import solve_curve
from vibrissa.sticking.solving import shooting

# The force on the example rod, in units of E·I0/L² and in N.
EXAMPLE_F, EXAMPLE_FORCE = 10.86, 7000.0
# Relative tolerance: half a unit in the last digit of f, and rounding.
EXAMPLE_TOLERANCE = 0.005 / EXAMPLE_F + 1e-4
# Friction coefficient, and ratios of kinetic to static friction, for which slip laws are compared.
PLAIN_FRICTION, KINETIC_RATIOS = 0.3, (0.6, 0.8)
SLOWED = (SlipLaw.KINETIC, SlipLaw.ENERGY)
# Tensile strength of music wire, ASTM A228, the strongest of the wrought carbon steels, in Pa:
# https://www.makeitfrom.com/material-properties/ASTM-A228-SWP-A-K08500-Music-Wire
# Generous: it yields earlier, and a wire as thick as 5 mm is weaker.
STEEL_STRENGTH = 2.45e9


@judges("pushed")
def pushed(evidence: Evidence) -> Finding:
    from scipy.optimize import brentq  # the report needs the statements, not this module's findings

    offset = (evidence.scan["x1"] - evidence.scan["footpoint"]).to_numpy()
    forward = all(rises(rows["footpoint"].to_numpy()) for rows in evidence.scans())
    curve = solve_curve(2.0, evidence.eta)

    def excess(x0: float) -> float:
        state = curve.state(-x0)
        return float(state.reaction_fx + 0.4 * state.reaction_fy)

    pulled = brentq(excess, 0.0, -curve.x0_pull, xtol=1e-10)
    quantities = {
        "smallest x1 − x0": (offset.min(), "L"),
        "displacement when pushed": (evidence.by_theta("x0_slip").loc[2.0, 0.4], "L"),
        "displacement when pulled": (pulled, "L"),
    }
    return judged(quantities, contradicted=not (forward and offset.min() > 0.0))


@judges("event frequency")
def event_frequency(evidence: Evidence) -> Finding:
    rows, dragged = evidence.slipping(), evidence.locking()["dragged"].to_numpy()
    frequency = 1.0 / rows["x0_slip"].to_numpy()
    quantities = ends("events per L", frequency, "1/L")
    if not rises(-frequency):
        return judged(quantities, contradicted=True)
    curve = solve_curve(float(rows["theta"].iloc[0]), evidence.eta)
    quantities |= {
        "events per L of the dragged rod, largest μ0": (1.0 / dragged[-1], "1/L"),
        "μ0 of a pushed rod with as many events": (curve.mobilised_friction(dragged[-1]), "1"),
    }
    return judged(quantities, contradicted=not rises(dragged), condition=True)


@judges("event frequency by any slip law")
def frequency_by_laws(evidence: Evidence) -> Finding:
    rows = evidence.slipping()
    (response,) = responses([MountedRod(theta=float(rows["theta"].iloc[0]), eta=evidence.eta)])
    mu0 = rows["mu0"].to_numpy()
    quantities: Quantities = {}
    frequencies: list[float] = []
    falls: dict[str, bool] = {}
    for law, ratio in ((SlipLaw.FREE, 1.0), *product(SLOWED, KINETIC_RATIOS)):
        model = SlipModel.of(law, ratio)
        *travel, plain = steady_travel(response, np.append(mu0, PLAIN_FRICTION), model)
        name = f"{law}, μk/μ0 = {ratio:g}" if law in SLOWED else str(law)
        frequencies.append(1.0 / plain)
        quantities[f"events per L at μ0 = {PLAIN_FRICTION:g}, law {name}"] = (
            frequencies[-1],
            "1/L",
        )
        # Where a slip lifts the tip off there is no further period, and the travel is NaN.
        stops = np.flatnonzero(~(np.diff(travel) > 0.0))
        falls[law] = falls.get(law, True) and not len(stops)
        if len(stops):
            quantities[f"μ0 up to which it falls, law {name}"] = (mu0[stops[0]], "1")
    taken = float(response.demand(1.0 / max(frequencies)))
    quantities["μ0 by the law free for the largest of these numbers"] = (taken, "1")
    several = max(frequencies) > (1.0 + NEGLIGIBLE) * min(frequencies)
    return judged(
        quantities,
        contradicted=not (falls[SlipLaw.FREE] and falls[SlipLaw.KINETIC]),
        condition=several or not falls[SlipLaw.ENERGY],
    )


@judges("force unit")
def force_unit(evidence: Evidence) -> Finding:
    force = EXAMPLE_F * EXAMPLE.force_unit
    quantities = {"force": (force, "N"), "unit of force": (EXAMPLE.force_unit, "N")}
    return judged(quantities, contradicted=abs(force / EXAMPLE_FORCE - 1.0) >= EXAMPLE_TOLERANCE)


@judges("example rod")
def example_rod(evidence: Evidence) -> Finding:
    slenderness = EXAMPLE.base_diameter / EXAMPLE.length
    limit = STEEL_STRENGTH / EXAMPLE.youngs_modulus
    strain = slenderness * evidence.bending_of(evidence.scan).strain
    first, largest = strain[evidence.scan["x0"] == 0.0].min(), strain.max()
    quantities = {
        "smallest strain of a first state": (100 * first, "%"),
        "largest strain of all states": (100 * largest, "%"),
        "strain at the tensile strength of the wire": (100 * limit, "%"),
        "largest d0 below that strain": (1e3 * EXAMPLE.base_diameter * limit / largest, "mm"),
    }
    return judged(quantities, contradicted=first > limit, condition=largest > limit)


def printed_diameter(s: float, theta: FloatArray) -> FloatArray:
    """Diameter by equation (1) as printed, with d1 = d0/θ, in units of d0."""
    return 1.0 - (1.0 - 1.0 / theta**2) * s


@judges("taper of eq. (1)")
def printed_taper(evidence: Evidence) -> Finding:
    tapers = evidence.by_theta("x0_slip").index.to_numpy()
    by_1 = printed_diameter(1.0, tapers)
    # The stiffness is the reciprocal of the curvature under unit moment.
    state = np.array([0.0, 0.0, math.pi / 2])
    bent = [rod_equations(theta, 1.0, 0.0, -1.0, 0.0)(1.0, state)[2] for theta in tapers]
    by_2 = np.array(bent) ** -0.25
    corrected = np.abs(diameter(1.0, tapers) - by_2).max()
    quantities = {
        "tip diameter by (1) at the largest θ": (by_1[-1], "d0"),
        "tip diameter by (2)": (by_2[-1], "d0"),
        "largest difference from (2) if (1) has d1 for d1/θ": (corrected, "d0"),
    }
    same = np.abs(by_1 - by_2) < NEGLIGIBLE
    only_cylinder = not same[tapers > 1.0].any()
    return judged(quantities, contradicted=only_cylinder, ambiguous=not same.all())


@judges("arc length")
def arc_length(evidence: Evidence) -> Finding:
    tips = [1.0 - (1.0 - 1.0 / 2.0) / length for length in (1.0, 1e3 * EXAMPLE.length)]
    quantities = {
        "tip diameter with L = 1": (tips[0], "d0"),
        "tip diameter with L in mm": (tips[1], "d0"),
    }
    differ = abs(tips[1] - tips[0]) >= NEGLIGIBLE
    return judged(quantities, contradicted=False, ambiguous=differ)


@judges("sense of α")
def sense_of_alpha(evidence: Evidence) -> Finding:
    rows = evidence.scan.iloc[:: max(1, len(evidence.scan) // 50)]
    deviation = {1: 0.0, -1: 0.0}
    for row in rows.itertuples():
        s, x, y, phi = (
            values[25] for values in (row.shape_s, row.shape_x, row.shape_y, row.shape_phi)
        )
        slopes = rod_equations(row.theta, row.f, row.alpha, row.x1, row.eta)
        _, _, bent = slopes(s, np.array((x, y, phi)))
        for sense in deviation:
            fx, fy = row.f * math.sin(sense * row.alpha), -row.f * math.cos(row.alpha)
            moment = (row.x1 - x) * fy - (row.eta - y) * fx
            expected = moment / float(diameter(s, row.theta)) ** 4
            deviation[sense] = max(deviation[sense], abs(bent - expected))
    quantities = {
        "deviation, counter-clockwise": (deviation[1], "1/L"),
        "deviation, clockwise": (deviation[-1], "1/L"),
    }
    return judged(quantities, contradicted=deviation[1] >= NEGLIGIBLE)


@judges("two unknowns")
def two_unknowns(evidence: Evidence) -> Finding:
    curve = solve_curve(2.0, evidence.eta)
    state = curve.state(0.5 * curve.x0_lock)
    x1 = curve.x1_init - 0.5 * curve.x0_lock

    def misses(f: float, alpha: float) -> FloatArray:
        x, y, phi = shooting.shoot(2.0, f, alpha, x1, evidence.eta)
        return np.array([x - x1, y - evidence.eta, phi])

    f, alpha, h = float(state.f), float(state.alpha), 1e-4
    by_f = misses(f + h, alpha) - misses(f - h, alpha)
    by_alpha = misses(f, alpha + h) - misses(f, alpha - h)
    derivative = np.stack([by_f, by_alpha], axis=1) / (2 * h)
    position = np.linalg.matrix_rank(derivative[:2], tol=1e-6 * np.linalg.norm(derivative[:2]))
    quantities = {
        "unknowns that the tip's position determines": (position, "1"),
        "conditions with a given φ1": (len(derivative), "1"),
        "independent conditions": (np.linalg.matrix_rank(derivative), "1"),
    }
    return judged(quantities, contradicted=position != 2, condition=True)


@judges("shooting")
def default_shooting(evidence: Evidence) -> Finding:
    off: list[int] = []
    errors: list[float] = []
    # Up to its end, a walk with a smaller μ0 is the same.
    largest = float(evidence.scan["mu0"].max())
    walks = {
        theta: shooting.walk(theta, evidence.eta, evidence.dx0, largest, shooting.PAPER)
        # Python computes with its own numbers faster than with NumPy's.
        for theta in map(float, evidence.scan["theta"].unique())
    }
    for rows in evidence.first_periods():
        theta, mu0 = float(rows["theta"].iloc[0]), float(rows["mu0"].iloc[0])
        steps = len(rows) - 1
        walk = shooting.until_slip(walks[theta], mu0)
        off.append(abs(len(walk) - 2 - steps))
        shot = np.array([state.f for state in walk[: steps + 1]])
        errors.append(float(np.abs(shot / rows["f"].to_numpy()[: len(shot)] - 1.0).max()))
    quantities = {
        f"periods with a wrong number of steps, of {len(off)}": (np.count_nonzero(off), "1"),
        "largest difference in steps": (max(off), "1"),
        "largest error of f": (100 * max(errors), "%"),
    }
    return judged(quantities, contradicted=max(off) > 1, condition=max(off) == 1)
