"""Claims of the paper's Section IV, its results."""

from decimal import Decimal

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from vibrissa.decimals import exact
from vibrissa.mechanics.bending import Bending
from vibrissa.numerics.arrays import FloatArray
from vibrissa.numerics.steps import last_step_within
from vibrissa.paper.evidence import Evidence, bending_at_the_last_state
from vibrissa.paper.judging import (
    EXAMPLE,
    MEASURES,
    NEGLIGIBLE,
    by_bending,
    ends,
    judged,
    line_fit,
    neighbours,
    rises,
    spread,
    wide_sweep,
)
from vibrissa.paper.ledger import Finding, Quantities, judges
from vibrissa.sticking.api import solve_curve
from vibrissa.sticking.curve import StickingCurve

# Largest number of steps that counts as "a few".
FEW = 10
# Smallest R² of a straight line at which a relation seems linear.
SEEMS_LINEAR = 0.99
# Half the step of a difference quotient (L).
NEAR = 1e-6
# Standard deviation of μ0 that a sensor is allowed, and number of periods in its scan.
ALLOWED_ERROR, MANY = 0.01, 30


@judges("sign of α")
def sign_of_alpha(evidence: Evidence) -> Finding:
    alpha = evidence.scan["alpha"].to_numpy()
    moved = evidence.scan["x0"].to_numpy() > 0.0
    at_first = np.abs(alpha[~moved]).max()
    quantities = spread("α at x0 > 0", alpha[moved], "rad")
    quantities["largest |α| at x0 = 0"] = (at_first, "rad")
    is_so = at_first < NEGLIGIBLE and (alpha[moved] < 0.0).all()
    return judged(quantities, contradicted=not is_so)


@judges("further deformed")
def further_deformed(evidence: Evidence) -> Finding:
    periods = evidence.first_periods()
    bent = [evidence.bending_of(rows) for rows in periods]
    growth = np.array([rods.energy[-1] / rods.energy[0] for rods in bent]) - 1.0
    moments = (rows["reaction_m"].abs() for rows in periods)
    fall = 1.0 - np.array([moment.iloc[-1] / moment.iloc[0] for moment in moments])
    quantities = spread("growth of the energy in a period", 100 * growth, "%")
    quantities |= spread("fall of the clamp moment", 100 * fall, "%")
    return by_bending("the rod is deformed further", *neighbours(bent), quantities)


@judges("end of sticking")
def end_of_sticking(evidence: Evidence) -> Finding:
    locked = evidence.locking()
    quantities = {
        "critical friction coefficient at θ = 2": (evidence.friction["mu_lock"].iloc[0], "1"),
        "points that slip only after the rod has buckled laterally": (len(locked), "1"),
    }
    reached = np.abs(np.tan(locked["alpha_trail"].to_numpy()))
    away = np.abs(reached / locked["mu0"].to_numpy() - 1.0).max()
    quantities["largest deviation of |tan α| from μ0 there"] = (away, "1")
    return judged(quantities, contradicted=away > NEGLIGIBLE, condition=True)


@judges("μ0 from the load")
def friction_from_forces(evidence: Evidence) -> Finding:
    rows = pd.concat([evidence.taper, evidence.slipping()])

    def error(suffix: str, rows: pd.DataFrame = rows) -> FloatArray:
        ratio = (rows[f"reaction_fx{suffix}"] / rows[f"reaction_fy{suffix}"]).to_numpy()
        return ratio / rows["mu0"].to_numpy() - 1.0

    last, onset = error("_last"), np.abs(error("_slip")).max()
    trailing = np.abs(error("_trail", evidence.locking())).max(initial=0.0)
    quantities = {
        "largest error at the exact onset": (onset, "1"),
        "largest error where a trailing tip slips": (trailing, "1"),
        **spread("underestimate at the last state", -100 * last, "%"),
    }
    return judged(
        quantities,
        contradicted=max(onset, trailing, last.max()) > NEGLIGIBLE,
        condition=last.min() < -0.001,
    )


@judges("longer with θ")
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
    return judged(quantities, contradicted=not rises(shown), condition=not rises(wide))


@judges("deformation with θ")
def deformed_with_taper(evidence: Evidence) -> Finding:
    every = bending_at_the_last_state(evidence.taper)
    bent = [every.take(places) for places in evidence.taper.groupby("mu0").indices.values()]
    first, last = (Bending.concatenate([r.take(np.array([i])) for r in bent]) for i in (0, -1))
    quantities: Quantities = {}
    for name, one in MEASURES.items():
        ratio = f"{name}, ratio of θ = 3 to 1"
        quantities |= spread(ratio, one(last) / one(first), "1")
    return by_bending("the deformation is stronger", *neighbours(bent), quantities)


@judges("μ0 = 0.3 against 0.4")
def friction_compared(evidence: Evidence) -> Finding:
    ends = pd.concat([rows.iloc[[-1]] for rows in evidence.first_periods()])
    low, high = (ends[ends["mu0"] == mu0] for mu0 in (ends["mu0"].min(), ends["mu0"].max()))
    less, more = evidence.bending_of(low), evidence.bending_of(high)
    ratio = high["x0"].to_numpy() / low["x0"].to_numpy()
    quantities = spread("ratio of x0,max, μ0 = 0.4 to 0.3", ratio, "1")
    quantities |= spread("ratio of the energies", more.energy / less.energy, "1")
    if ratio.min() <= 1.0:
        return judged(quantities, contradicted=True)
    return by_bending("the rod is deformed less", less, more, quantities)


@judges("few steps")
def few_steps(evidence: Evidence) -> Finding:
    steps = evidence.by_theta("n_steps")
    cylinder = steps.loc[1.0, 0.3]
    onset = evidence.by_theta("x0_slip").loc[1.0, 0.3]
    finer = int(last_step_within(np.array(onset), exact(evidence.dx0) / 10))
    quantities = {
        "steps at μ0 = 0.3": (cylinder, "1"),
        "steps with a tenth of the step": (finer, "1"),
        "share of the steps at θ = 2": (100 * cylinder / steps.loc[2.0, 0.3], "%"),
    }
    return judged(quantities, contradicted=cylinder > FEW, condition=finer > FEW)


@judges("important for a sensor")
def important_for_sensor(evidence: Evidence) -> Finding:
    curves = [solve_curve(theta, evidence.eta) for theta in (1.0, 2.0, 3.0)]
    onset = np.array([float(curve.onset(0.3)) for curve in curves])
    slope = np.array([float(_slope(curve, at)) for curve, at in zip(curves, onset, strict=True)])
    # An onset is uniformly distributed over a step.
    step = ALLOWED_ERROR * np.sqrt(12.0) / slope
    quantities = {f"step at θ = {theta}": (at, "L") for theta, at in enumerate(step, 1)}
    quantities |= {
        f"way of {MANY} periods at θ = {theta}": (MANY * at, "L")
        for theta, at in enumerate(onset, 1)
    }
    return judged(quantities, contradicted=not (rises(step) and rises(onset)), condition=True)


@judges("accurate drive")
def accurate_drive(evidence: Evidence) -> Finding:
    onset = evidence.by_theta("x0_slip")
    missed = (last_step_within(onset.to_numpy(), Decimal("0.01")) == 0).sum(axis=1)
    shortest = onset.loc[1.0].min()
    quantities = {
        "values of μ0 missed at θ = 1": (missed[0], "1"),
        "values of μ0 missed at θ = 3": (missed[-1], "1"),
        "largest step of the example rod to miss no μ0": (1e3 * EXAMPLE.length * shortest, "mm"),
    }
    return judged(quantities, contradicted=missed[0] <= missed[-1])


def _slope(curve: StickingCurve, at: ArrayLike) -> FloatArray:
    """Differentiate the mobilised friction −tan α with respect to x0 (1/L)."""
    low, high = np.asarray(at) - NEAR, np.asarray(at) + NEAR
    rise = curve.mobilised_friction(high) - curve.mobilised_friction(low)
    return np.asarray(rise / (2.0 * NEAR))


@judges("taper compensates")
def taper_compensates(evidence: Evidence) -> Finding:
    frictions = evidence.by_theta("x0_slip").columns.to_numpy()
    rise = {}
    for theta in (1.0, 2.0, 3.0):
        curve = solve_curve(theta, evidence.eta)
        rise[theta] = _slope(curve, curve.onset(frictions))
    least = {theta: (rise[1.0] / rise[theta]).min() for theta in (2.0, 3.0)}
    quantities = {
        f"smallest ratio of the rise at θ = 1 to θ = {theta:g}": (ratio, "1")
        for theta, ratio in least.items()
    }
    return judged(quantities, contradicted=not rises([1.0, *least.values()]), condition=True)


@judges("longer slides with θ")
def longer_slides(evidence: Evidence) -> Finding:
    slides = evidence.slip_lengths()
    travel = evidence.scan_lengths() / evidence.cycle_counts()
    difference = (slides - travel).abs().to_numpy().max()
    quantities = {
        **spread("slide", slides, "L"),
        "largest difference from the clamp's travel": (difference, "L"),
    }
    return judged(quantities, contradicted=not rises(slides), condition=difference < NEGLIGIBLE)


@judges("longer scan with θ")
def longer_scan(evidence: Evidence) -> Finding:
    lengths = evidence.scan_lengths()
    quantities = spread("distance", lengths, "L")
    return judged(quantities, contradicted=not rises(lengths))


@judges("linear in θ")
def linear_in_taper(evidence: Evidence) -> Finding:
    stepped, onset = evidence.by_theta("x0_max"), evidence.by_theta("x0_slip")
    tapers, frictions = onset.index.to_numpy(), onset.columns
    deviation = max(line_fit(tapers, onset[mu0].to_numpy()).deviation for mu0 in frictions)
    worst = min(line_fit(tapers, stepped[mu0].to_numpy()).r_squared for mu0 in frictions)
    curves = wide_sweep(evidence.eta)
    wide_tapers = np.array([curve.theta for curve in curves])
    wide = np.array([curve.onset(frictions.to_numpy()) for curve in curves])
    beyond = min(line_fit(wide_tapers, column).r_squared for column in wide.T)
    quantities = {
        "smallest R²": (worst, "1"),
        "largest deviation of the exact onset from a line": (deviation, "L"),
        "deviation in steps": (deviation / evidence.dx0, "1"),
        "smallest R² up to θ = 20": (beyond, "1"),
    }
    bends = deviation >= evidence.dx0 or beyond <= SEEMS_LINEAR
    return judged(quantities, contradicted=worst < SEEMS_LINEAR, condition=bends)


@judges("μ0 strengthens the taper's effect")
def friction_strengthens(evidence: Evidence) -> Finding:
    onset = evidence.by_theta("x0_slip")
    tapers = onset.index.to_numpy()
    slopes = np.array([line_fit(tapers, onset[mu0].to_numpy()).slope for mu0 in onset.columns])
    ratios = (onset.iloc[-1] / onset.iloc[0]).to_numpy()
    quantities = ends("slope", slopes, "L") | ends("ratio of θ = 3 to 1", ratios, "1")
    return judged(quantities, contradicted=not rises(slopes), condition=not rises(ratios))


@judges("levels of Figure 7")
def levels(evidence: Evidence) -> Finding:
    rows = evidence.slipping()
    groups = rows.groupby("x0_max").size().to_numpy()
    quantities = {
        f"levels of {len(rows)} points": (len(groups), "1"),
        **spread("number of points on a level", groups, "1"),
    }
    return judged(quantities, contradicted=len(groups) == len(rows), condition=(groups == 1).any())


@judges("cause of the levels")
def cause_of_levels(evidence: Evidence) -> Finding:
    onset = evidence.slipping()["x0_slip"].to_numpy()
    step = exact(evidence.dx0)
    counts = [len(np.unique(last_step_within(onset, step / part))) for part in (1, 2, 5, 10)]
    distinct = len(np.unique(onset))
    quantities = {
        f"values of {len(onset)} points with the step": (counts[0], "1"),
        "values with a tenth of the step": (counts[-1], "1"),
        "exact values": (distinct, "1"),
    }
    is_so = distinct == len(onset) and counts[0] < counts[-1] and sorted(counts) == counts
    return judged(quantities, contradicted=not is_so)


@judges("no exact trend")
def no_exact_trend(evidence: Evidence) -> Finding:
    rows = evidence.slipping()
    stepped, onset = rows["x0_max"].to_numpy(), rows["x0_slip"].to_numpy()
    error = onset - stepped
    deviation = line_fit(rows["mu0"].to_numpy(), stepped).deviation
    quantities = {
        "largest error of the stepped value": (error.max(), "L"),
        "deviation of the stepped values from a line, in steps": (deviation / evidence.dx0, "1"),
    }
    return judged(
        quantities, contradicted=error.max() < NEGLIGIBLE, condition=deviation > evidence.dx0
    )


@judges("non-linear in μ0")
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
        **ends("slope", slope, "L"),
        "deviation from a line, in steps": (deviation / evidence.dx0, "1"),
        "power of x0_lock − x0 at the lock": (power, "1"),
        "μ_lock, where the trend ends": (curve.mu_lock, "1"),
    }
    if deviation <= evidence.dx0:
        return judged(quantities, contradicted=True)
    at_the_end = "at the end" if abs(power - 0.5) <= 0.01 else "but not"
    reason = (
        f"it gets steeper and steeper, {at_the_end} like a square root. Above μ_lock, sticking "
        "ends only after the rod has buckled laterally"
    )
    return judged(quantities, contradicted=False, reason=reason)


@judges("periods repeat")
def periods_repeat(evidence: Evidence) -> Finding:
    worst = 0.0
    for rows in evidence.scans():
        # Without the first row: each later cycle starts from the slip that ends the cycle before.
        first, *others = (_seen_from_clamp(cycle) for _, cycle in rows.iloc[1:].groupby("cycle"))
        if any(other.shape != first.shape for other in others):
            return judged({}, contradicted=True)
        worst = max(worst, *(float(np.abs(other - first).max()) for other in others))
    cycles = evidence.cycle_counts().to_numpy().min()
    quantities = {"cycles": (cycles, "1"), "largest difference": (worst, "1")}
    return judged(quantities, contradicted=worst >= NEGLIGIBLE)


def _seen_from_clamp(steps: pd.DataFrame) -> FloatArray:
    """Return load, tip slope, tip position and shape with the clamp at 0, one row for each step."""
    clamp = steps["footpoint"].to_numpy()[:, None]
    state = steps[["f", "alpha", "reaction_m", "phi1"]].to_numpy()
    tip = steps[["x1"]].to_numpy() - clamp
    x, y = (np.stack(steps[axis].to_list()) for axis in ("shape_x", "shape_y"))
    return np.hstack([state, tip, x - clamp, y])
