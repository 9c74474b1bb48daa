"""Claims of the paper's Section IV, its results.

Each is a function of the evidence; where it calls a solver or takes a number from elsewhere, that
can be replaced by keyword. The verdict follows from the numbers.
"""

from collections.abc import Callable
from decimal import Decimal

import numpy as np
import pandas as pd

from vibrissa.api import solve_curve
from vibrissa.arrays import FloatArray
from vibrissa.bending import Bending
from vibrissa.curve import StickingCurve
from vibrissa.decimals import exact
from vibrissa.evidence import Evidence, bending_at_the_last_state, bending_of_steps
from vibrissa.judging import (
    CONDITION,
    CONTRADICTED,
    EXAMPLE,
    HOLDS,
    NEGLIGIBLE,
    by_bending,
    line_fit,
    rises,
    wide_sweep,
)
from vibrissa.ledger import Finding, claim
from vibrissa.steps import last_step_within

# "A few" steps are at most so many.
FEW = 10
# Least share of the variance that a straight line explains where a correlation seems linear.
SEEMS_LINEAR = 0.99


@claim(
    "sign of α",
    "IV",
    "α is zero at first and becomes negative as soon as the clamp moves.",
    "α in every state of the scans",
)
def sign_of_alpha(evidence: Evidence) -> Finding:
    alpha = evidence.scan["alpha"].to_numpy()
    moved = evidence.scan["x0"].to_numpy() > 0.0
    figures = {
        "largest |α| at x0 = 0": (np.abs(alpha[~moved]).max(), "rad"),
        "largest α at x0 > 0": (alpha[moved].max(), "rad"),
        "smallest α": (alpha[moved].min(), "rad"),
    }
    if np.abs(alpha[~moved]).max() < NEGLIGIBLE and (alpha[moved] < 0.0).all():
        return Finding(HOLDS, "so it is in every scan", figures)
    return Finding(CONTRADICTED, "some states have another sign", figures)


@claim(
    "further deformed",
    "IV",
    "The longer the clamp moves while the tip sticks, the more the rod is deformed.",
    "bending of the shapes in the first period of each scan, and the clamp's reactions",
)
def further_deformed(evidence: Evidence) -> Finding:
    before, after, moment, force = [], [], [], []
    for _, rows in evidence.scans():
        period = rows[(rows["cycle"] == 1) & (rows["phase"] == "stick")]
        bent = np.stack(bending_of_steps(period))
        before.append(bent[:, :-1])
        after.append(bent[:, 1:])
        ends = period.iloc[[0, -1]]
        moment.append(np.abs(ends["reaction_m"].to_numpy()))
        force.append(ends["f"].to_numpy())
    moments, forces = np.array(moment), np.array(force)
    gain = [late[0, -1] / early[0, 0] for early, late in zip(before, after, strict=True)]
    verdict, reason = by_bending(
        "it is deformed further",
        Bending(*np.concatenate(before, axis=1)),
        Bending(*np.concatenate(after, axis=1)),
    )
    fall = 1.0 - moments[:, 1] / moments[:, 0]
    figures = {
        "smallest growth of the energy in a period": (100 * (min(gain) - 1), "%"),
        "largest growth of the energy": (100 * (max(gain) - 1), "%"),
        "smallest growth of the force": (100 * (forces[:, 1] / forces[:, 0] - 1).min(), "%"),
        "smallest fall of the clamp moment": (100 * fall.min(), "%"),
        "largest fall of the clamp moment": (100 * fall.max(), "%"),
    }
    if (fall > 0.0).all():
        reason += "; the force at the clamp grows, but its moment gets smaller in every period"
    return Finding(verdict, reason, figures)


@claim(
    "end of sticking",
    "IV",
    "When the largest stiction force is reached, the tip begins to slip.",
    "μ0 of Figure 7 against the locking friction, the largest −tan α on the sticking curve",
)
def end_of_sticking(evidence: Evidence) -> Finding:
    locked = evidence.friction[evidence.friction["status"] == "lock"]
    figures = {
        "locking friction at θ = 2": (evidence.friction["mu_lock"].iloc[0], "1"),
        "largest μ0 of Figure 7": (evidence.friction["mu0"].max(), "1"),
        "points that never slip": (len(locked), "1"),
    }
    if not len(locked):
        return Finding(HOLDS, "it is reached for every μ0", figures)
    if len(locked) == len(evidence.friction):
        return Finding(CONTRADICTED, "it is reached for no μ0", figures)
    return Finding(CONDITION, "it is reached only for μ0 up to the locking friction", figures)


@claim(
    "μ0 from the reactions",
    "IV",
    "μ0 follows from the forces and moments that are measured at the clamp.",
    "|Fx/Fy| at the clamp at the last state of stiction and at the exact onset, against μ0",
)
def friction_from_forces(evidence: Evidence) -> Finding:
    rows = pd.concat([evidence.taper, evidence.slipping()])
    rows = rows[rows["status"] == "slip"]

    def error(suffix: str) -> FloatArray:
        ratio = (rows[f"reaction_fx{suffix}"] / rows[f"reaction_fy{suffix}"]).to_numpy()
        return ratio / rows["mu0"].to_numpy() - 1.0

    last, onset = error("_last"), np.abs(error("_slip")).max()
    figures = {
        "largest error at the exact onset": (onset, "1"),
        "largest underestimate at the last state": (-100 * last.min(), "%"),
        "median underestimate": (-100 * float(np.median(last)), "%"),
    }
    if onset > NEGLIGIBLE or last.max() > NEGLIGIBLE:
        return Finding(CONTRADICTED, "the ratio of the forces is not μ0 where slip begins", figures)
    if last.min() < -0.001:
        reason = "the forces alone suffice, but on the step grid they come up to a step too low"
        return Finding(CONDITION, reason, figures)
    return Finding(HOLDS, "the forces alone suffice", figures)


@claim(
    "longer with θ",
    "IV",
    "For each μ0 a stronger taper makes one period of sticking longer.",
    "x0 at the exact onset over the θ of Figure 6, and on to θ = 20, the tip alone in contact",
)
def longer_with_taper(
    evidence: Evidence, sweep: Callable[[float], tuple[StickingCurve, ...]] = wide_sweep
) -> Finding:
    shown = evidence.by_theta("x0_slip")
    curves = sweep(evidence.eta)
    wide = np.array([curve.onset(shown.columns.to_numpy()) for curve in curves])
    longest = [curves[int(np.nanargmax(column))].theta for column in wide.T]
    figures = {
        "smallest ratio of x0 at the ends of Figure 6": (
            (shown.iloc[-1] / shown.iloc[0]).min(),
            "1",
        ),
        **{
            f"θ of the longest period at μ0 = {mu0:g}": (theta, "1")
            for mu0, theta in zip(shown.columns, longest, strict=True)
        },
    }
    if not rises(shown):
        return Finding(CONTRADICTED, "it does not within Figure 6", figures)
    if not rises(wide):
        reason = "in Figure 6's range; with stronger taper the period gets shorter again"
        return Finding(CONDITION, reason, figures)
    return Finding(HOLDS, "it does throughout", figures)


@claim(
    "deformation with θ",
    "IV",
    "For each μ0 a stronger taper makes the deformation at the end of a period stronger.",
    "bending at the last state of stiction over the θ of Figure 6",
)
def deformed_with_taper(evidence: Evidence) -> Finding:
    before, after, ends = [], [], []
    for _, rows in evidence.taper.groupby("mu0"):
        bent = np.stack(bending_at_the_last_state(rows))
        before.append(bent[:, :-1])
        after.append(bent[:, 1:])
        ends.append(bent[:, -1] / bent[:, 0])
    verdict, reason = by_bending(
        "the deformation is stronger",
        Bending(*np.concatenate(before, axis=1)),
        Bending(*np.concatenate(after, axis=1)),
    )
    ratios = Bending(*np.array(ends).T)
    figures = {
        "energy at θ = 3 to that at 1, smallest ratio": (ratios.energy.min(), "1"),
        "energy, largest ratio": (ratios.energy.max(), "1"),
        "curvature, smallest ratio": (ratios.curvature.min(), "1"),
        "strain, smallest ratio": (ratios.strain.min(), "1"),
        "turn of the tip, smallest ratio": (ratios.turn.min(), "1"),
    }
    return Finding(verdict, reason, figures)


@claim(
    "μ0 = 0.3 against 0.4",
    "IV",
    "With μ0 = 0.3 the clamp moves less far in a period than with 0.4, and deforms the rod less.",
    "first periods of the scans of Figures 4 and 5 compared",
)
def friction_compared(evidence: Evidence) -> Finding:
    ways, ends = {}, {}
    for key, rows in evidence.scans():
        period = rows[(rows["cycle"] == 1) & (rows["phase"] == "stick")]
        ways[key] = float(period["x0"].max())
        ends[key] = np.stack(bending_of_steps(period.iloc[[-1]]))[:, 0]
    tapers = sorted({theta for theta, _ in ways})
    low, high = min(mu for _, mu in ways), max(mu for _, mu in ways)
    less = Bending(*np.array([ends[theta, low] for theta in tapers]).T)
    more = Bending(*np.array([ends[theta, high] for theta in tapers]).T)
    ratio = [ways[theta, high] / ways[theta, low] for theta in tapers]
    figures = {
        "smallest ratio of x0,max, 0.4 to 0.3": (min(ratio), "1"),
        "largest ratio of x0,max": (max(ratio), "1"),
        "smallest ratio of the energies": ((more.energy / less.energy).min(), "1"),
    }
    if min(ratio) <= 1.0:
        return Finding(CONTRADICTED, "the clamp does not move less far", figures)
    verdict, reason = by_bending("the rod is deformed less", less, more)
    return Finding(verdict, reason, figures)


@claim(
    "few steps",
    "IV",
    "The cylinder slips after a few steps already (Figure 4a).",
    "steps to the last state of stiction at θ = 1 and μ0 = 0.3, of the paper's size and a tenth "
    "of it",
)
def few_steps(evidence: Evidence) -> Finding:
    steps, onset = evidence.by_theta("n_steps").loc[1.0], evidence.by_theta("x0_slip").loc[1.0]
    finer = last_step_within(np.array(onset[0.3]), exact(evidence.dx0) / 10)
    figures = {
        "steps at μ0 = 0.3": (steps[0.3], "1"),
        "steps at μ0 = 0.4": (steps[0.4], "1"),
        "steps at μ0 = 0.3 of a tenth of the size": (int(finer), "1"),
        "share of the steps that θ = 2 takes": (
            100 * steps[0.3] / evidence.by_theta("n_steps").loc[2.0, 0.3],
            "%",
        ),
    }
    if steps[0.3] > FEW:
        return Finding(CONTRADICTED, f"it takes more than {FEW}", figures)
    if finer > FEW:
        return Finding(CONDITION, "few for this step; a smaller one takes more", figures)
    return Finding(HOLDS, "few with a tenth of the step, too", figures)


@claim(
    "accurate drive",
    "IV",
    "With the cylinder the drive must be accurate, or the periods of sticking are missed.",
    "values of μ0 of Figure 6 at which a step of 0.01 leaves no state of stiction after the first",
)
def accurate_drive(evidence: Evidence, coarse: Decimal = Decimal("0.01")) -> Finding:
    onset = evidence.by_theta("x0_slip")
    missed = (last_step_within(onset.to_numpy(), coarse) == 0).sum(axis=1)
    figures = {
        "values missed at θ = 1": (missed[0], "1"),
        "values missed at θ = 3": (missed[-1], "1"),
        "largest step that misses none at θ = 1": (onset.loc[1.0].min(), "L"),
        "the same for the example rod": (1e3 * EXAMPLE.length * onset.loc[1.0].min(), "mm"),
    }
    if missed[0] > missed[-1]:
        return Finding(HOLDS, "the cylinder's periods are missed first", figures)
    return Finding(CONTRADICTED, "the cylinder's periods are missed no sooner", figures)


@claim(
    "taper compensates",
    "IV",
    "A taper removes this sensitivity to the clamp's displacement.",
    "rise of −tan α per displacement at the onset, d(−tan α)/dx0, at θ = 1 against θ = 2 and 3",
)
def taper_compensates(
    evidence: Evidence, curve_of: Callable[[float, float], StickingCurve] = solve_curve
) -> Finding:
    frictions = evidence.by_theta("x0_slip").columns.to_numpy()
    slope = {}
    for theta in (1.0, 2.0, 3.0):
        curve = curve_of(theta, evidence.eta)
        at, h = curve.onset(frictions), 1e-6
        slope[theta] = (curve.friction_demand(at + h) - curve.friction_demand(at - h)) / (2 * h)
    least = {theta: (slope[1.0] / slope[theta]).min() for theta in (2.0, 3.0)}
    figures = {
        "rise at θ = 1, μ0 = 0.3": (float(slope[1.0][frictions == 0.3][0]), "1/L"),
        "smallest ratio of the rise at θ = 1 to θ = 2": (least[2.0], "1"),
        "smallest ratio of the rise at θ = 1 to θ = 3": (least[3.0], "1"),
    }
    if least[2.0] > 1.0 and least[3.0] > least[2.0]:
        reason = "the sensitivity gets smaller with θ; it does not vanish"
        return Finding(CONDITION, reason, figures)
    return Finding(CONTRADICTED, "the sensitivity does not get smaller with θ", figures)


@claim(
    "longer slides with θ",
    "IV",
    "A drawback of the taper are longer periods of sliding.",
    "way of the tip in a slip and of the clamp in a cycle, over the θ of Figures 4 and 5",
)
def longer_slides(evidence: Evidence) -> Finding:
    slides = evidence.slip_lengths()
    travel = (evidence.at_end("footpoint") / evidence.at_end("cycle")).to_numpy()
    figures = {
        "slide at θ = 1, μ0 = 0.3": (slides.loc[1.0, 0.3], "L"),
        "slide at θ = 3, μ0 = 0.3": (slides.loc[3.0, 0.3], "L"),
        "largest difference from the clamp's way": (
            np.abs(slides.to_numpy() - travel).max(),
            "L",
        ),
    }
    if not rises(slides):
        return Finding(CONTRADICTED, "the slides do not get longer", figures)
    if np.abs(slides.to_numpy() - travel).max() < NEGLIGIBLE:
        reason = (
            "if slip ends at α = 0, as assumed: then the tip slides exactly as far as the clamp "
            "moved in the cycle"
        )
        return Finding(CONDITION, reason, figures)
    return Finding(HOLDS, "the slides get longer", figures)


@claim(
    "longer scan with θ",
    "IV",
    "For the same number of periods a tapered rod has to scan a longer way.",
    "way of the clamp in nine cycles over the θ of Figures 4 and 5",
)
def longer_scan(evidence: Evidence) -> Finding:
    ways = evidence.at_end("footpoint")
    figures = {
        f"way at θ = {theta:g}, μ0 = {mu0:g}": (ways.loc[theta, mu0], "L")
        for theta in ways.index
        for mu0 in ways.columns
    }
    if rises(ways):
        return Finding(HOLDS, "the way gets longer with θ", figures)
    return Finding(CONTRADICTED, "the way does not get longer with θ", figures)


@claim(
    "linear in θ",
    "IV",
    "x0,max seems to grow linearly with θ for each μ0 (Figure 6).",
    "straight lines through the points of Figure 6, their R² and misfit; the same on to θ = 20, "
    "the tip alone in contact",
)
def linear_in_taper(
    evidence: Evidence, sweep: Callable[[float], tuple[StickingCurve, ...]] = wide_sweep
) -> Finding:
    stepped, onset = evidence.by_theta("x0_max"), evidence.by_theta("x0_slip")
    tapers, frictions = stepped.index.to_numpy(), stepped.columns
    stepped_fit = {mu0: line_fit(tapers, stepped[mu0].to_numpy()) for mu0 in frictions}
    fits = {mu0: line_fit(tapers, onset[mu0].to_numpy()) for mu0 in frictions}
    curves = sweep(evidence.eta)
    wide_tapers = np.array([curve.theta for curve in curves])
    wide = np.array([curve.onset(frictions.to_numpy()) for curve in curves])
    beyond = min(line_fit(wide_tapers, column)[1] for column in wide.T)
    worst, misfit = (
        min(share for _, share, _ in stepped_fit.values()),
        max(most for _, _, most in fits.values()),
    )
    steepest = max(frictions)
    x, y = tapers, onset[steepest].to_numpy()
    slope = np.polynomial.Polynomial.fit(x, y, 2).deriv()
    figures = {
        "smallest R²": (worst, "1"),
        "largest misfit of a line to the exact onset": (misfit, "L"),
        "misfit in steps": (misfit / evidence.dx0, "1"),
        **{f"slope at μ0 = {mu0:g}": (fit[0], "L") for mu0, fit in fits.items()},
        f"slope of the parabola at μ0 = {steepest:g}, smallest θ": (slope(x[0]), "L"),
        "slope of the parabola, largest θ": (slope(x[-1]), "L"),
        "smallest R² up to θ = 20": (beyond, "1"),
    }
    if worst < SEEMS_LINEAR:
        return Finding(CONTRADICTED, "a line does not fit", figures)
    if misfit < evidence.dx0 and beyond > SEEMS_LINEAR:
        return Finding(HOLDS, "a line fits to within a step, and on to θ = 20", figures)
    reasons = []
    if misfit >= evidence.dx0:
        reasons.append("the points bend away from a line by more than a step")
    if beyond <= SEEMS_LINEAR:
        reasons.append("beyond Figure 6 no line fits")
    return Finding(CONDITION, "as an impression: " + "; ".join(reasons), figures)


@claim(
    "μ0 strengthens the taper's effect",
    "IV",
    "The larger μ0 is, the stronger is the effect of the taper.",
    "slope of x0 over θ in Figure 6, and ratio of x0 at its two ends, for each μ0",
)
def friction_strengthens(evidence: Evidence) -> Finding:
    onset = evidence.by_theta("x0_slip")
    tapers = onset.index.to_numpy()
    slopes = np.array([line_fit(tapers, onset[mu0].to_numpy())[0] for mu0 in onset.columns])
    ratios = (onset.iloc[-1] / onset.iloc[0]).to_numpy()
    figures = {}
    for mu0, slope, ratio in zip(onset.columns, slopes, ratios, strict=True):
        figures[f"slope at μ0 = {mu0:g}"] = (slope, "L")
        figures[f"ratio at μ0 = {mu0:g}"] = (ratio, "1")
    if rises(slopes) and rises(ratios):
        return Finding(HOLDS, "as a slope and as a ratio", figures)
    if rises(slopes):
        reason = "as a slope; by the factor by which the taper lengthens the period it gets weaker"
        return Finding(CONDITION, reason, figures)
    return Finding(CONTRADICTED, "the slope does not grow with μ0", figures)


@claim(
    "levels of Figure 7",
    "IV",
    "The points over μ0 lie in groups on levels.",
    "number of different values of x0,max among the points of Figure 7",
)
def levels(evidence: Evidence) -> Finding:
    rows = evidence.slipping()
    groups = rows.groupby("x0_max").size().to_numpy()
    figures = {
        "points": (len(rows), "1"),
        "levels": (len(groups), "1"),
        "most points on a level": (groups.max(), "1"),
        "levels with one point": ((groups == 1).sum(), "1"),
    }
    if len(groups) == len(rows):
        return Finding(CONTRADICTED, "every point has a level of its own", figures)
    if (groups == 1).any():
        reason = (
            "where μ0 changes x0 by less than a step from point to point; where the trend is "
            "steeper, each point has a level of its own"
        )
        return Finding(CONDITION, reason, figures)
    return Finding(HOLDS, "every level has several points", figures)


@claim(
    "cause of the levels",
    "IV",
    "The levels come from the step of the clamp, which is too coarse for the change with μ0.",
    "different values of x0 among the points of Figure 7: exact, and on finer steps",
)
def cause_of_levels(evidence: Evidence) -> Finding:
    onset = evidence.slipping()["x0_slip"].to_numpy()
    step = exact(evidence.dx0)
    count = [len(np.unique(last_step_within(onset, step / parts))) for parts in (1, 2, 5, 10)]
    distinct = len(np.unique(onset))
    figures = {
        "points": (len(onset), "1"),
        "values with the step": (count[0], "1"),
        "values with half the step": (count[1], "1"),
        "values with a fifth of the step": (count[2], "1"),
        "values with a tenth of the step": (count[3], "1"),
        "exact values": (distinct, "1"),
    }
    if distinct == len(onset) and count[0] < count[-1] and sorted(count) == count:
        return Finding(HOLDS, "the exact onset has no levels, and finer steps have more", figures)
    return Finding(CONTRADICTED, "the levels do not come from the step", figures)


@claim(
    "no exact trend",
    "IV",
    "These points do not tell how exactly x0,max depends on μ0.",
    "error of the stepped values against the exact onset, and misfit of a line to them",
)
def no_exact_trend(evidence: Evidence) -> Finding:
    rows = evidence.slipping()
    stepped, onset = rows["x0_max"].to_numpy(), rows["x0_slip"].to_numpy()
    error = onset - stepped
    misfit = line_fit(rows["mu0"].to_numpy(), stepped)[2]
    figures = {
        "largest error of the stepped value": (error.max(), "L"),
        "largest relative error": (100 * (error / onset).max(), "%"),
        "misfit of a line to the stepped values, in steps": (misfit / evidence.dx0, "1"),
    }
    if error.max() < NEGLIGIBLE:
        return Finding(CONTRADICTED, "the stepped values are the exact ones", figures)
    if misfit > evidence.dx0:
        reason = (
            "of the stepped values; that the trend is no line they show by many steps, and the "
            "exact onset gives it for every μ0"
        )
        return Finding(CONDITION, reason, figures)
    return Finding(HOLDS, "the steps hide whether the trend is a line", figures)


@claim(
    "non-linear in μ0",
    "IV",
    "x0,max does not seem to depend linearly on μ0.",
    "slope of the exact onset at both ends of Figure 7; power of x0_lock − x0 in μ_lock − μ0 close "
    "to the lock, by solving θ = 2",
)
def nonlinear_in_friction(
    evidence: Evidence, curve_of: Callable[[float, float], StickingCurve] = solve_curve
) -> Finding:
    rows = evidence.slipping()
    mu0, onset = rows["mu0"].to_numpy(), rows["x0_slip"].to_numpy()
    slope = np.diff(onset) / np.diff(mu0)
    misfit = line_fit(mu0, onset)[2]
    curve = curve_of(float(rows["theta"].iloc[0]), evidence.eta)
    below = curve.mu_lock * np.geomspace(1e-6, 1e-4, 9)
    left = curve.x0_lock - curve.onset(curve.mu_lock - below)
    power = np.polynomial.Polynomial.fit(np.log(below), np.log(left), 1).convert().coef[1]
    figures = {
        "slope at the smallest μ0": (slope[0], "L"),
        "slope at the largest μ0": (slope[-1], "L"),
        "misfit of a line, in steps": (misfit / evidence.dx0, "1"),
        "power of x0_lock − x0 at the lock": (power, "1"),
        "μ_lock, where the trend ends": (curve.mu_lock, "1"),
        "x0_lock": (curve.x0_lock, "L"),
    }
    if misfit > evidence.dx0:
        reason = "steeper and steeper, at the end like a square root with a vertical tangent"
        if abs(power - 0.5) > 0.01:
            reason = "but not like a square root at the lock"
        return Finding(HOLDS, reason, figures)
    return Finding(CONTRADICTED, "a line fits to within a step", figures)


@claim(
    "periods repeat",
    "IV",
    "Where slip ends at α = 0, a new period of sticking begins from the initial state.",
    "reactions and shapes of each cycle of the scans against the first",
)
def periods_repeat(evidence: Evidence) -> Finding:
    worst, cycles = 0.0, []
    for _, rows in evidence.scans():
        cycles.append(int(rows["cycle"].max()))
        first = rows[rows["cycle"] == 1].iloc[1:]  # without the state at the very beginning
        values = np.stack([first[name] for name in ("f", "alpha", "reaction_m", "phi1")])
        for _, others in rows[rows["cycle"] > 1].groupby("cycle"):
            again = np.stack([others[name] for name in ("f", "alpha", "reaction_m", "phi1")])
            if again.shape != values.shape:
                return Finding(CONTRADICTED, "cycles have different numbers of steps", {})
            worst = max(worst, float(np.abs(again - values).max()))
    figures = {"cycles": (min(cycles), "1"), "largest difference": (worst, "1")}
    if worst < NEGLIGIBLE:
        return Finding(HOLDS, "every cycle is the first one, moved on", figures)
    return Finding(CONTRADICTED, "later cycles differ from the first", figures)
