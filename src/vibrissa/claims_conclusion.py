"""Claims of the paper's Section V, its conclusions.

Each is a function of the evidence; where it calls a solver or takes a number from elsewhere, that
can be replaced by keyword. The verdict follows from the numbers.
"""

import math
from collections.abc import Callable
from decimal import Decimal

import numpy as np
import pandas as pd

from vibrissa.api import EquilibriumState, solve_curve, solve_state
from vibrissa.bending import Bending
from vibrissa.curve import StickingCurve
from vibrissa.decimals import exact
from vibrissa.evidence import Evidence, bending_at_the_last_state
from vibrissa.judging import (
    AMBIGUOUS,
    CONDITION,
    CONTRADICTED,
    HOLDS,
    NEGLIGIBLE,
    by_bending,
    rises,
)
from vibrissa.ledger import Finding, claim
from vibrissa.status import Contact
from vibrissa.steps import last_step_within, step_position


@claim(
    "step size analysed",
    "V",
    "The relation of x0,max to the step Δx0 has been analysed.",
    "steps that the study has; x0,max at θ = 2, μ0 = 0.4 on steps refined from 0.01 to 0.00001",
)
def step_size_analysed(evidence: Evidence) -> Finding:
    used = {exact(step) for step in evidence.taper["dx0"]}
    used |= {exact(step) for step in evidence.scan["dx0"]}
    onset = np.array(evidence.by_theta("x0_slip").loc[2.0, 0.4])
    steps = [Decimal(10) ** -power for power in range(2, 6)]
    stepped = [float(step_position(last_step_within(onset, step), step)) for step in steps]
    error = np.array([float(onset) - value for value in stepped])
    share = error / np.array([float(step) for step in steps])
    figures = {
        "different steps in the figures": (len(used), "1"),
        "exact onset": (float(onset), "L"),
        **{f"x0,max on {step:f}": (x, "L") for step, x in zip(steps, stepped, strict=True)},
        "largest error in units of the step": (share.max(), "1"),
    }
    if not ((share >= 0.0) & (share < 1.0)).all():
        return Finding(CONTRADICTED, "the error is not less than a step", figures)
    if len(used) == 1:
        reason = (
            "the figures have one step alone and cannot show it; refined, x0,max is the exact "
            "onset rounded down to the step, low by less than one step"
        )
        return Finding(AMBIGUOUS, reason, figures)
    return Finding(HOLDS, "low by less than one step, whatever the step", figures)


@claim(
    "longer with μ0",
    "V",
    "Within a period more friction means a longer way of the clamp and a more deformed rod.",
    "x0 and bending at the last state of stiction over the μ0 of Figure 7",
)
def longer_with_friction(evidence: Evidence) -> Finding:
    rows = evidence.slipping()
    onset, stepped = rows["x0_slip"].to_numpy(), rows["x0_max"].to_numpy()
    one = rows.drop_duplicates("x0_max")  # points on one level are in one state
    bent = bending_at_the_last_state(one)
    parts = np.stack(bent)
    figures = {
        "exact onset at the smallest μ0": (onset[0], "L"),
        "exact onset at the largest μ0 that slips": (onset[-1], "L"),
        "energy at the smallest μ0": (bent.energy[0], "E*I0/L"),
        "energy at the largest μ0 that slips": (bent.energy[-1], "E*I0/L"),
        "points that lock": (len(evidence.friction) - len(rows), "1"),
    }
    if not rises(onset) or (np.diff(stepped) < 0.0).any():
        return Finding(CONTRADICTED, "the displacement does not get longer", figures)
    verdict, reason = by_bending(
        "the deformation is stronger", Bending(*parts[:, :-1]), Bending(*parts[:, 1:])
    )
    if verdict is HOLDS and len(rows) < len(evidence.friction):
        return Finding(CONDITION, f"{reason}; up to the locking friction", figures)
    return Finding(verdict, reason, figures)


@claim(
    "μ0 from the moment",
    "V",
    "What the clamp feels just before the slip, forces and moments, tells μ0.",
    "whether −tan α is a one-to-one function of the clamp moment up to the lock, at θ = 1, 2 and 3",
)
def friction_from_moment(
    evidence: Evidence, curve_of: Callable[[float, float], StickingCurve] = solve_curve
) -> Finding:
    figures, monotone, turns = {}, [], 0
    for theta in (1.0, 2.0, 3.0):
        curve = curve_of(theta, evidence.eta)
        state = curve.state(np.linspace(0.0, curve.x0_lock, 401))
        monotone.append(rises(state.reaction_m) and rises(curve.friction_demand(state.x0)))
        turns += int((np.diff(np.sign(state.reaction_m)) != 0).sum())
        figures[f"moment at α = 0, θ = {theta:g}"] = (state.reaction_m[0], "E*I0/L")
        figures[f"moment at the lock, θ = {theta:g}"] = (state.reaction_m[-1], "E*I0/L")
    figures["curves on which the moment changes its sign"] = (turns, "1")
    if all(monotone):
        reason = (
            "the forces tell μ0 by themselves; the moment tells it, too, but its size does not, as "
            "it changes its sign, and only with θ and η known"
        )
        if not turns:
            reason = "the forces tell μ0 by themselves; the moment does if θ and η are known"
        return Finding(CONDITION, reason, figures)
    return Finding(CONTRADICTED, "one moment belongs to several μ0", figures)


@claim(
    "longer periods with θ and μ0",
    "V",
    "With more taper and friction the tip sticks and slides farther.",
    "x0,max and slides of the scans over θ and over μ0",
)
def longer_periods(evidence: Evidence) -> Finding:
    slides = evidence.slip_lengths()
    rows = evidence.by_theta("x0_max")
    sticks = rows.loc[slides.index, slides.columns]
    figures = {
        "shortest sticking": (sticks.to_numpy().min(), "L"),
        "longest sticking": (sticks.to_numpy().max(), "L"),
        "shortest slide": (slides.to_numpy().min(), "L"),
        "longest slide": (slides.to_numpy().max(), "L"),
    }
    if all(rises(table, axis) for table in (sticks, slides) for axis in (0, 1)):
        return Finding(HOLDS, "both get longer with θ and with μ0", figures)
    return Finding(CONTRADICTED, "some get shorter", figures)


@claim(
    "longer way",
    "V",
    "With more taper and friction the same number of events takes a longer way.",
    "way of the clamp in the scans over θ and over μ0",
)
def longer_way(evidence: Evidence) -> Finding:
    ways = evidence.at_end("footpoint")
    figures = {
        "shortest way": (ways.to_numpy().min(), "L"),
        "longest way": (ways.to_numpy().max(), "L"),
        "events in each": (float(evidence.at_end("cycle").to_numpy().min()), "1"),
    }
    if rises(ways, 0) and rises(ways, 1):
        return Finding(HOLDS, "the way gets longer with θ and with μ0", figures)
    return Finding(CONTRADICTED, "the way does not always get longer", figures)


@claim(
    "more steps",
    "V",
    "With more taper and friction the clamp takes more steps in all.",
    "steps in the scans over θ and over μ0",
)
def more_steps(evidence: Evidence) -> Finding:
    counts = pd.Series({key: len(rows) - 1 for key, rows in evidence.scans()}).unstack()
    figures = {
        "fewest steps": (counts.to_numpy().min(), "1"),
        "most steps": (counts.to_numpy().max(), "1"),
    }
    if not (rises(counts, 0) and rises(counts, 1)):
        return Finding(CONTRADICTED, "the number does not always rise", figures)
    if evidence.scan["dx0"].nunique() == 1:
        return Finding(HOLDS, "at the same step and number of events", figures)
    return Finding(AMBIGUOUS, "the scans have different steps", figures)


@claim(
    "more events with μ0",
    "V",
    "Summing up: at a given θ more friction brings about more events.",
    "events on the way of the longest scan, for each θ and μ0 of Figure 6",
)
def more_events(evidence: Evidence) -> Finding:
    way = evidence.at_end("footpoint").to_numpy().max()
    periods = evidence.by_theta("n_steps") + 1  # the slip takes a step, too
    steps = round(way / evidence.dx0)
    events = steps // periods
    figures = {"way": (way, "L")} | {
        f"events at θ = {theta:g}, μ0 = {mu0:g}": (events.loc[theta, mu0], "1")
        for theta in (1.0, 2.0, 3.0)
        for mu0 in events.columns
    }
    more = np.diff(events.to_numpy(), axis=1)
    if (more > 0).all():
        return Finding(HOLDS, "there are more", figures)
    if (more < 0).all():
        reason = (
            "on a given way there are fewer for each θ, as the sentences before it imply: each "
            "event takes longer"
        )
        return Finding(CONTRADICTED, reason, figures)
    return Finding(AMBIGUOUS, "for some θ there are more, for some fewer", figures)


@claim(
    "negative φ1 in Figure 8",
    "V",
    "A cylinder with x1 = 0.15 and y1 = 0.55 has a negative slope at its tip.",
    "φ1 of the equilibrium of lowest force",
)
def negative_slope(evidence: Evidence) -> Finding:
    phi1 = float(evidence.state["phi1"])
    figures = {
        "φ1": (phi1, "rad"),
        "f": (float(evidence.state["f"]), "E*I0/L^2"),
        "−tan α": (-math.tan(float(evidence.state["alpha"])), "1"),
    }
    if phi1 < 0.0:
        return Finding(HOLDS, "it is", figures)
    return Finding(CONTRADICTED, "it is not", figures)


@claim(
    "penetration in Figure 8",
    "V",
    "This shape passes through the surface.",
    "highest point of the shape over the surface",
)
def penetration(evidence: Evidence) -> Finding:
    over = float(np.max(evidence.state["shape_y"])) - float(evidence.state["eta"])
    figures = {"height over the surface": (over, "L")}
    if over > NEGLIGIBLE:
        return Finding(HOLDS, "it does", figures)
    return Finding(CONTRADICTED, "it stays below", figures)


@claim(
    "correct in theory",
    "V",
    "As a solution of the model the shape of Figure 8 is correct.",
    "residual of the equations and the least second variation of the energy",
)
def correct_in_theory(evidence: Evidence) -> Finding:
    residual, margin = float(evidence.state["residual"]), float(evidence.state["stability"])
    figures = {"residual": (residual, "1"), "least second variation": (margin, "1")}
    if residual > NEGLIGIBLE:
        return Finding(CONTRADICTED, "it does not satisfy the equations", figures)
    if margin <= 0.0:
        return Finding(CONDITION, "it is an equilibrium, but not a stable one", figures)
    return Finding(HOLDS, "it is a stable equilibrium of the model", figures)


@claim(
    "contact along a line",
    "V",
    "Not every situation comes out realistic; contact along a whole line has to be considered.",
    "points of Figures 6 and 7 whose rods penetrate; Figure 8's rod in contact along a line",
)
def line_contact(
    evidence: Evidence, solve: Callable[..., EquilibriumState] = solve_state
) -> Finding:
    points = pd.concat([evidence.taper, evidence.friction])
    passing = int(points["penetrates"].astype(bool).sum())
    theta, eta, x1 = (float(evidence.state[name]) for name in ("theta", "eta", "x1"))
    lying = solve(theta, eta, x1, Contact.LINE)
    figures = {
        "points of Figures 6 and 7 that penetrate": (passing, "1"),
        "points": (len(points), "1"),
        "f with the tip alone in contact": (float(evidence.state["f"]), "E*I0/L^2"),
        "f along a line": (lying.f, "E*I0/L^2"),
        "free length along a line": (lying.s_c, "L"),
    }
    if not evidence.state["penetrates"] and not passing:
        return Finding(CONTRADICTED, "no rod penetrates", figures)
    if not passing:
        reason = "for states like Figure 8; no point of the paper's other figures needs it"
        return Finding(CONDITION, reason, figures)
    return Finding(HOLDS, "points of Figures 6 and 7 need it, too", figures)
