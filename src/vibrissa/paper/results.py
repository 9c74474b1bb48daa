"""Claims of the paper's Section IV, its results."""

from decimal import Decimal
from functools import partial

import numpy as np
import pandas as pd

from vibrissa.decimals import exact
from vibrissa.mechanics.bending import Bending
from vibrissa.numerics.arrays import FloatArray
from vibrissa.numerics.steps import last_step_within
from vibrissa.paper import ledger
from vibrissa.paper.evidence import Evidence, bending_at_the_last_state, bending_of_steps
from vibrissa.paper.judging import (
    CONDITION,
    CONTRADICTED,
    EXAMPLE,
    HOLDS,
    NEGLIGIBLE,
    by_bending,
    line_fit,
    neighbours,
    rises,
    wide_sweep,
)
from vibrissa.paper.ledger import Finding
from vibrissa.sticking.api import solve_curve

claim = partial(ledger.claim, section="IV")

# "A few" steps are at most so many.
FEW = 10
# Least share of the variance that a straight line explains where a correlation seems linear.
SEEMS_LINEAR = 0.99


@claim(
    name="sign of α",
    statement="α is zero at first and becomes negative as soon as the clamp moves.",
    computed="α in every state of the scans",
)
def sign_of_alpha(evidence: Evidence) -> Finding:
    alpha = evidence.scan["alpha"].to_numpy()
    moved = evidence.scan["x0"].to_numpy() > 0.0
    at_first = np.abs(alpha[~moved]).max()
    quantities = {
        "largest |α| at x0 = 0": (at_first, "rad"),
        "largest α at x0 > 0": (alpha[moved].max(), "rad"),
        "smallest α": (alpha[moved].min(), "rad"),
    }
    if at_first < NEGLIGIBLE and (alpha[moved] < 0.0).all():
        return HOLDS.because("this is so in every scan", quantities)
    return CONTRADICTED.because("some states have another sign", quantities)


@claim(
    name="further deformed",
    statement="The longer the clamp moves while the tip sticks, the more the rod is deformed.",
    computed="bending of the shapes in the first period of each scan, and the load on the clamp",
)
def further_deformed(evidence: Evidence) -> Finding:
    periods = evidence.first_periods()
    bent = [bending_of_steps(rows) for rows in periods]
    growth = np.array([rods.energy[-1] / rods.energy[0] for rods in bent]) - 1.0
    force = np.array([rows["f"].iloc[-1] / rows["f"].iloc[0] for rows in periods]) - 1.0
    moments = (rows["reaction_m"].abs() for rows in periods)
    fall = 1.0 - np.array([moment.iloc[-1] / moment.iloc[0] for moment in moments])
    quantities = {
        "smallest growth of the energy in a period": (100 * growth.min(), "%"),
        "largest growth of the energy": (100 * growth.max(), "%"),
        "smallest growth of the force": (100 * force.min(), "%"),
        "smallest fall of the clamp moment": (100 * fall.min(), "%"),
        "largest fall of the clamp moment": (100 * fall.max(), "%"),
    }
    finding = by_bending("the rod is deformed further", *neighbours(bent), quantities)
    if (fall > 0.0).all():
        reason = (
            f"{finding.reason}; the force on the clamp grows, but the moment falls in all periods"
        )
        return finding.verdict.because(reason, quantities)
    return finding


@claim(
    name="end of sticking",
    statement="When static friction reaches its largest force, the tip begins to slip.",
    computed="μ0 of Figure 7 compared with the critical friction coefficient, the largest −tan α "
    "on the equilibrium path; |tan α| where a self-locking rod that has swung aside slips",
)
def end_of_sticking(evidence: Evidence) -> Finding:
    slipping, locked, trailing = evidence.slipping(), evidence.locking(), evidence.trailing()
    quantities = {
        "critical friction coefficient at θ = 2": (evidence.friction["mu_lock"].iloc[0], "1"),
        "largest μ0 of Figure 7": (evidence.friction["mu0"].max(), "1"),
        "points that never slip forward": (len(locked), "1"),
        "of these, points that slip after a swing": (len(trailing), "1"),
    }
    if not len(locked):
        return HOLDS.because("it is reached for every μ0", quantities)
    if not len(slipping) and not len(trailing):
        return CONTRADICTED.because("it is reached for no μ0", quantities)
    reason = "a pushed tip reaches it only for μ0 up to the critical friction coefficient; beyond, "
    if len(trailing) < len(locked):
        return CONDITION.because(f"{reason}some tips never slip", quantities)
    reached = np.abs(np.tan(trailing["alpha_trail"].to_numpy()))
    away = np.abs(reached / trailing["mu0"].to_numpy() - 1.0).max()
    quantities |= {
        "first x0 at which a tip slips after a swing": (trailing["x0_trail"].min(), "L"),
        "largest deviation of |tan α| from μ0 there": (away, "1"),
    }
    if away > NEGLIGIBLE:
        return CONTRADICTED.because("tips that trail slip at another friction", quantities)
    reason += (
        "a round rod swings aside, trails behind the clamp, and its tip slips when it is pulled, "
        "just where friction has reached its largest force"
    )
    return CONDITION.because(reason, quantities)


@claim(
    name="μ0 from the load",
    statement="μ0 follows from the forces and moments that are measured at the clamp.",
    computed="|Fx/Fy| at the clamp at the last sticking state and at the exact onset, compared "
    "with μ0; the same where a self-locking rod that has swung aside slips",
)
def friction_from_forces(evidence: Evidence) -> Finding:
    rows = pd.concat([evidence.taper, evidence.slipping()])
    rows = rows[rows["status"] == "slip"]

    def error(suffix: str, rows: pd.DataFrame = rows) -> FloatArray:
        ratio = (rows[f"reaction_fx{suffix}"] / rows[f"reaction_fy{suffix}"]).to_numpy()
        return ratio / rows["mu0"].to_numpy() - 1.0

    last, onset = error("_last"), np.abs(error("_slip")).max()
    trailing = np.abs(error("_trail", evidence.trailing())).max(initial=0.0)
    quantities = {
        "largest error at the exact onset": (onset, "1"),
        "largest error where a trailing tip slips": (trailing, "1"),
        "largest underestimate at the last state": (-100 * last.min(), "%"),
        "median underestimate": (-100 * float(np.median(last)), "%"),
    }
    if max(onset, trailing, last.max()) > NEGLIGIBLE:
        reason = "the ratio of the forces is not μ0 where slip begins"
        return CONTRADICTED.because(reason, quantities)
    if last.min() < -0.001:
        reason = (
            "the forces suffice, but the last state on the step grid is up to a step before slip, "
            "and its ratio is too small"
        )
        return CONDITION.because(reason, quantities)
    return HOLDS.because("the forces alone suffice", quantities)


@claim(
    name="longer with θ",
    statement="For each μ0 a stronger taper makes one period of sticking longer.",
    computed="x0 at the exact onset over the θ of Figure 6, and up to θ = 20, in tip contact",
)
def longer_with_taper(evidence: Evidence) -> Finding:
    shown = evidence.by_theta("x0_slip")
    curves = wide_sweep(evidence.eta)
    wide = np.array([curve.onset(shown.columns.to_numpy()) for curve in curves])
    longest = [curves[i].theta for i in np.nanargmax(wide, axis=0)]
    ratio = shown.iloc[-1] / shown.iloc[0]
    quantities = {"smallest ratio of x0 at the ends of Figure 6": (ratio.min(), "1")} | {
        f"θ of the longest period at μ0 = {mu0:g}": (theta, "1")
        for mu0, theta in zip(shown.columns, longest, strict=True)
    }
    if not rises(shown):
        return CONTRADICTED.because("it does not within Figure 6", quantities)
    if not rises(wide):
        reason = "in the range of Figure 6; with stronger taper the period gets shorter again"
        return CONDITION.because(reason, quantities)
    return HOLDS.because("it does throughout", quantities)


@claim(
    name="deformation with θ",
    statement="For each μ0 a stronger taper makes the deformation at the end of a period stronger.",
    computed="bending at the last sticking state over the θ of Figure 6",
)
def deformed_with_taper(evidence: Evidence) -> Finding:
    bent = [bending_at_the_last_state(rows) for _, rows in evidence.taper.groupby("mu0")]
    first, last = (Bending.concatenate([r.take(np.array([i])) for r in bent]) for i in (0, -1))
    energy = last.energy / first.energy
    quantities = {
        "energy at θ = 3 to that at 1, smallest ratio": (energy.min(), "1"),
        "energy, largest ratio": (energy.max(), "1"),
        "curvature, smallest ratio": ((last.curvature / first.curvature).min(), "1"),
        "strain, smallest ratio": ((last.strain / first.strain).min(), "1"),
        "turn of the tip, smallest ratio": ((last.turn / first.turn).min(), "1"),
    }
    return by_bending("the deformation is stronger", *neighbours(bent), quantities)


@claim(
    name="μ0 = 0.3 against 0.4",
    statement="With μ0 = 0.3 the clamp moves less far in a period than with 0.4, and deforms the "
    "rod less.",
    computed="first periods of the scans of Figures 4 and 5 compared",
)
def friction_compared(evidence: Evidence) -> Finding:
    ends = pd.concat([rows.iloc[[-1]] for rows in evidence.first_periods()])
    low, high = (ends[ends["mu0"] == mu0] for mu0 in (ends["mu0"].min(), ends["mu0"].max()))
    less, more = bending_of_steps(low), bending_of_steps(high)
    ratio = high["x0"].to_numpy() / low["x0"].to_numpy()
    quantities = {
        "smallest ratio of x0,max, 0.4 to 0.3": (ratio.min(), "1"),
        "largest ratio of x0,max": (ratio.max(), "1"),
        "smallest ratio of the energies": ((more.energy / less.energy).min(), "1"),
    }
    if ratio.min() <= 1.0:
        return CONTRADICTED.because("the clamp does not move less far", quantities)
    return by_bending("the rod is deformed less", less, more, quantities)


@claim(
    name="few steps",
    statement="The cylinder slips after a few steps already (Figure 4a).",
    computed="steps to the last sticking state at θ = 1 and μ0 = 0.3, with the paper's step and "
    "with a tenth of it",
)
def few_steps(evidence: Evidence) -> Finding:
    steps = evidence.by_theta("n_steps")
    cylinder = steps.loc[1.0, 0.3]
    onset = evidence.by_theta("x0_slip").loc[1.0, 0.3]
    finer = int(last_step_within(np.array(onset), exact(evidence.dx0) / 10))
    quantities = {
        "steps at μ0 = 0.3": (cylinder, "1"),
        "steps at μ0 = 0.4": (steps.loc[1.0, 0.4], "1"),
        "steps at μ0 = 0.3 of a tenth of the size": (finer, "1"),
        "share of the steps at θ = 2": (100 * cylinder / steps.loc[2.0, 0.3], "%"),
    }
    if cylinder > FEW:
        return CONTRADICTED.because(f"it takes more than {FEW}", quantities)
    if finer > FEW:
        return CONDITION.because("few for this step; a smaller one takes more", quantities)
    return HOLDS.because("few with a tenth of the step, too", quantities)


@claim(
    name="accurate drive",
    statement="With the cylinder the drive must be accurate, or periods of sticking are missed.",
    computed="values of μ0 of Figure 6 at which a step of 0.01 leaves no sticking state after "
    "the first",
)
def accurate_drive(evidence: Evidence) -> Finding:
    onset = evidence.by_theta("x0_slip")
    missed = (last_step_within(onset.to_numpy(), Decimal("0.01")) == 0).sum(axis=1)
    shortest = onset.loc[1.0].min()
    quantities = {
        "values missed at θ = 1": (missed[0], "1"),
        "values missed at θ = 3": (missed[-1], "1"),
        "largest step that misses none at θ = 1": (shortest, "L"),
        "the same for the example rod": (1e3 * EXAMPLE.length * shortest, "mm"),
    }
    if missed[0] > missed[-1]:
        return HOLDS.because("the cylinder's periods are missed first", quantities)
    return CONTRADICTED.because("the cylinder's periods are missed no sooner", quantities)


@claim(
    name="taper compensates",
    statement="A taper removes this sensitivity to the clamp's displacement.",
    computed="rise of −tan α per displacement at the onset, d(−tan α)/dx0, at θ = 1 compared with "
    "θ = 2 and 3",
)
def taper_compensates(evidence: Evidence) -> Finding:
    frictions = evidence.by_theta("x0_slip").columns.to_numpy()
    slope = {}
    for theta in (1.0, 2.0, 3.0):
        curve = solve_curve(theta, evidence.eta)
        at, h = curve.onset(frictions), 1e-6
        slope[theta] = (curve.friction_demand(at + h) - curve.friction_demand(at - h)) / (2 * h)
    least = {theta: (slope[1.0] / slope[theta]).min() for theta in (2.0, 3.0)}
    quantities = {
        "rise at θ = 1, μ0 = 0.3": (slope[1.0][frictions == 0.3][0], "1/L"),
        "smallest ratio of the rise at θ = 1 to θ = 2": (least[2.0], "1"),
        "smallest ratio of the rise at θ = 1 to θ = 3": (least[3.0], "1"),
    }
    if least[2.0] > 1.0 and least[3.0] > least[2.0]:
        reason = "the sensitivity gets smaller with θ; it does not vanish"
        return CONDITION.because(reason, quantities)
    return CONTRADICTED.because("the sensitivity does not get smaller with θ", quantities)


@claim(
    name="longer slides with θ",
    statement="A drawback of the taper is longer periods of sliding.",
    computed="distance that the tip moves in a slip and the clamp in a cycle, over the θ of "
    "Figures 4 and 5",
)
def longer_slides(evidence: Evidence) -> Finding:
    slides = evidence.slip_lengths()
    travel = evidence.scan_lengths() / evidence.cycle_counts()
    difference = (slides - travel).abs().to_numpy().max()
    quantities = {
        "slide at θ = 1, μ0 = 0.3": (slides.loc[1.0, 0.3], "L"),
        "slide at θ = 3, μ0 = 0.3": (slides.loc[3.0, 0.3], "L"),
        "largest difference from the clamp's travel": (difference, "L"),
    }
    if not rises(slides):
        return CONTRADICTED.because("the slides do not get longer", quantities)
    if difference < NEGLIGIBLE:
        reason = (
            "if slip ends at α = 0, as the paper assumes: then the tip slides exactly as far as "
            "the clamp moved in the cycle"
        )
        return CONDITION.because(reason, quantities)
    return HOLDS.because("the slides get longer", quantities)


@claim(
    name="longer scan with θ",
    statement="For the same number of periods a tapered rod has to scan a longer distance.",
    computed="distance that the clamp moves in nine cycles over the θ of Figures 4 and 5",
)
def longer_scan(evidence: Evidence) -> Finding:
    lengths = evidence.scan_lengths()
    quantities = {
        f"distance at θ = {theta:g}, μ0 = {mu0:g}": (lengths.loc[theta, mu0], "L")
        for theta in lengths.index
        for mu0 in lengths.columns
    }
    if rises(lengths):
        return HOLDS.because("the distance gets longer with θ", quantities)
    return CONTRADICTED.because("the distance does not get longer with θ", quantities)


@claim(
    name="linear in θ",
    statement="x0,max seems to grow linearly with θ for each μ0 (Figure 6).",
    computed="straight lines through the points of Figure 6, their R² and largest deviation; the "
    "same up to θ = 20, in tip contact",
)
def linear_in_taper(evidence: Evidence) -> Finding:
    stepped, onset = evidence.by_theta("x0_max"), evidence.by_theta("x0_slip")
    tapers, frictions = onset.index.to_numpy(), onset.columns
    lines = {mu0: line_fit(tapers, onset[mu0].to_numpy()) for mu0 in frictions}
    worst = min(line_fit(tapers, stepped[mu0].to_numpy()).r_squared for mu0 in frictions)
    deviation = max(line.deviation for line in lines.values())
    curves = wide_sweep(evidence.eta)
    wide_tapers = np.array([curve.theta for curve in curves])
    wide = np.array([curve.onset(frictions.to_numpy()) for curve in curves])
    beyond = min(line_fit(wide_tapers, column).r_squared for column in wide.T)
    steepest = frictions.max()
    slope = np.polynomial.Polynomial.fit(tapers, onset[steepest].to_numpy(), 2).deriv()
    quantities = {
        "smallest R²": (worst, "1"),
        "largest deviation of the exact onset from a line": (deviation, "L"),
        "deviation in steps": (deviation / evidence.dx0, "1"),
        **{f"slope at μ0 = {mu0:g}": (line.slope, "L") for mu0, line in lines.items()},
        f"slope of the parabola at μ0 = {steepest:g}, smallest θ": (slope(tapers[0]), "L"),
        "slope of the parabola, largest θ": (slope(tapers[-1]), "L"),
        "smallest R² up to θ = 20": (beyond, "1"),
    }
    if worst < SEEMS_LINEAR:
        return CONTRADICTED.because("a line does not fit", quantities)
    reasons = {
        "the exact onset deviates from a line by more than a step": deviation >= evidence.dx0,
        "beyond Figure 6 no line fits": beyond <= SEEMS_LINEAR,
    }
    if not any(reasons.values()):
        return HOLDS.because("a line fits to within a step, and up to θ = 20", quantities)
    found = "; ".join(reason for reason, applies in reasons.items() if applies)
    return CONDITION.because(f"as an impression: {found}", quantities)


@claim(
    name="μ0 strengthens the taper's effect",
    statement="The larger μ0 is, the stronger is the effect of the taper.",
    computed="slope of x0 over θ in Figure 6, and ratio of x0 at its two ends, for each μ0",
)
def friction_strengthens(evidence: Evidence) -> Finding:
    onset = evidence.by_theta("x0_slip")
    tapers = onset.index.to_numpy()
    slopes = np.array([line_fit(tapers, onset[mu0].to_numpy()).slope for mu0 in onset.columns])
    ratios = (onset.iloc[-1] / onset.iloc[0]).to_numpy()
    quantities = {}
    for mu0, slope, ratio in zip(onset.columns, slopes, ratios, strict=True):
        quantities[f"slope at μ0 = {mu0:g}"] = (slope, "L")
        quantities[f"ratio at μ0 = {mu0:g}"] = (ratio, "1")
    if rises(slopes) and rises(ratios):
        return HOLDS.because("as a slope and as a ratio", quantities)
    if rises(slopes):
        reason = "as a slope; the factor by which the taper lengthens the period falls with μ0"
        return CONDITION.because(reason, quantities)
    return CONTRADICTED.because("the slope does not grow with μ0", quantities)


@claim(
    name="levels of Figure 7",
    statement="The points over μ0 lie in groups on levels.",
    computed="number of different values of x0,max among the points of Figure 7",
)
def levels(evidence: Evidence) -> Finding:
    rows = evidence.slipping()
    groups = rows.groupby("x0_max").size().to_numpy()
    quantities = {
        "points": (len(rows), "1"),
        "levels": (len(groups), "1"),
        "most points on a level": (groups.max(), "1"),
        "levels with one point": ((groups == 1).sum(), "1"),
    }
    if len(groups) == len(rows):
        return CONTRADICTED.because("every point has a level of its own", quantities)
    if (groups == 1).any():
        reason = (
            "where x0 changes by less than a step from point to point; where it changes faster, "
            "each point has a level of its own"
        )
        return CONDITION.because(reason, quantities)
    return HOLDS.because("every level has several points", quantities)


@claim(
    name="cause of the levels",
    statement="The levels come from the step of the clamp, which is too coarse for the change with "
    "μ0.",
    computed="different values of x0 among the points of Figure 7: exact, and with finer steps",
)
def cause_of_levels(evidence: Evidence) -> Finding:
    onset = evidence.slipping()["x0_slip"].to_numpy()
    step = exact(evidence.dx0)
    parts = {"the step": 1, "half the step": 2, "a fifth of the step": 5, "a tenth of the step": 10}
    counts = [len(np.unique(last_step_within(onset, step / n))) for n in parts.values()]
    distinct = len(np.unique(onset))
    quantities = {
        "points": (len(onset), "1"),
        **{f"values with {name}": (n, "1") for name, n in zip(parts, counts, strict=True)},
        "exact values": (distinct, "1"),
    }
    if distinct == len(onset) and counts[0] < counts[-1] and sorted(counts) == counts:
        reason = "the exact onset has no levels, and with finer steps there are more"
        return HOLDS.because(reason, quantities)
    return CONTRADICTED.because("the levels do not come from the step", quantities)


@claim(
    name="no exact trend",
    statement="These points do not show how exactly x0,max depends on μ0.",
    computed="error of the stepped values compared with the exact onset, and their largest "
    "deviation from a line",
)
def no_exact_trend(evidence: Evidence) -> Finding:
    rows = evidence.slipping()
    stepped, onset = rows["x0_max"].to_numpy(), rows["x0_slip"].to_numpy()
    error = onset - stepped
    deviation = line_fit(rows["mu0"].to_numpy(), stepped).deviation
    quantities = {
        "largest error of the stepped value": (error.max(), "L"),
        "largest relative error": (100 * (error / onset).max(), "%"),
        "deviation of the stepped values from a line, in steps": (deviation / evidence.dx0, "1"),
    }
    if error.max() < NEGLIGIBLE:
        return CONTRADICTED.because("the stepped values are the exact ones", quantities)
    if deviation > evidence.dx0:
        reason = (
            "for the stepped values; but they deviate from a line by many steps, so the trend is "
            "not linear, and the exact onset gives it for every μ0"
        )
        return CONDITION.because(reason, quantities)
    return HOLDS.because("the steps hide whether the trend is a line", quantities)


@claim(
    name="non-linear in μ0",
    statement="x0,max does not seem to depend linearly on μ0.",
    computed="slope of the exact onset at both ends of Figure 7; power of x0_lock − x0 in "
    "μ_lock − μ0 close to the lock, by solving θ = 2",
)
def nonlinear_in_friction(evidence: Evidence) -> Finding:
    rows = evidence.slipping()
    mu0, onset = rows["mu0"].to_numpy(), rows["x0_slip"].to_numpy()
    slope = np.diff(onset) / np.diff(mu0)
    deviation = line_fit(mu0, onset).deviation
    curve = solve_curve(float(rows["theta"].iloc[0]), evidence.eta)
    below = curve.mu_lock * np.geomspace(1e-6, 1e-4, 9)
    left = curve.x0_lock - curve.onset(curve.mu_lock - below)
    power = line_fit(np.log(below), np.log(left)).slope
    quantities = {
        "slope at the smallest μ0": (slope[0], "L"),
        "slope at the largest μ0": (slope[-1], "L"),
        "deviation from a line, in steps": (deviation / evidence.dx0, "1"),
        "power of x0_lock − x0 at the lock": (power, "1"),
        "μ_lock, where the trend ends": (curve.mu_lock, "1"),
        "x0_lock": (curve.x0_lock, "L"),
    }
    if deviation > evidence.dx0:
        reason = (
            "it gets steeper and steeper, at the end like a square root with a vertical tangent"
        )
        if abs(power - 0.5) > 0.01:
            reason = "but not like a square root at the lock"
        if len(trailing := evidence.trailing()):
            quantities["x0_trail at the smallest μ0 above μ_lock"] = (
                trailing["x0_trail"].iloc[0],
                "L",
            )
            reason += "; above the lock sticking ends only after the rod has swung aside"
        return HOLDS.because(reason, quantities)
    return CONTRADICTED.because("a line fits to within a step", quantities)


@claim(
    name="periods repeat",
    statement="Where slip ends at α = 0, a new period of sticking begins from the initial state.",
    computed="load on the clamp and shapes of each cycle of the scans compared with the first",
)
def periods_repeat(evidence: Evidence) -> Finding:
    columns = ["f", "alpha", "reaction_m", "phi1"]
    worst = 0.0
    for rows in evidence.scans():
        # Without the state at the very beginning, which no cycle before it ends with.
        first, *others = (cycle[columns].to_numpy() for _, cycle in rows.iloc[1:].groupby("cycle"))
        if any(other.shape != first.shape for other in others):
            return CONTRADICTED.because("cycles have different numbers of steps", {})
        worst = max(worst, *(float(np.abs(other - first).max()) for other in others))
    cycles = evidence.cycle_counts().to_numpy().min()
    quantities = {"cycles": (cycles, "1"), "largest difference": (worst, "1")}
    if worst < NEGLIGIBLE:
        return HOLDS.because(
            "every cycle is the first one, shifted by the clamp's travel", quantities
        )
    return CONTRADICTED.because("later cycles differ from the first", quantities)
