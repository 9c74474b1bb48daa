"""Claims of the paper's Section V, its conclusions."""

import math
from decimal import Decimal

import numpy as np
import pandas as pd

from vibrissa.decimals import exact
from vibrissa.numerics.steps import last_step_within, step_position
from vibrissa.outcomes import Contact
from vibrissa.paper.evidence import (
    Evidence,
    bending_at_the_end_of_trailing,
    bending_at_the_last_state,
)
from vibrissa.paper.judging import (
    AMBIGUOUS,
    CONDITION,
    CONTRADICTED,
    HOLDS,
    NEGLIGIBLE,
    by_bending,
    holds_if,
    neighbours,
    rises,
)
from vibrissa.paper.ledger import Judged, judges
from vibrissa.sticking.api import solve_curve, solve_state


@judges("step size analysed")
def step_size_analysed(evidence: Evidence) -> Judged:
    used = {exact(step) for rows in (evidence.taper, evidence.scan) for step in rows["dx0"]}
    onset = np.array(evidence.by_theta("x0_slip").loc[2.0, 0.4])
    steps = [Decimal(10) ** -power for power in range(2, 6)]
    stepped = [float(step_position(last_step_within(onset, step), step)) for step in steps]
    share = (float(onset) - np.array(stepped)) / np.array(steps, dtype=float)
    quantities = {
        "different steps in the figures": (len(used), "1"),
        "exact onset": (onset, "L"),
        **{
            f"x0,max with steps of {step:f}": (x, "L")
            for step, x in zip(steps, stepped, strict=True)
        },
        "largest error in units of the step": (share.max(), "1"),
    }
    if not ((share >= 0.0) & (share < 1.0)).all():
        return CONTRADICTED, quantities
    return (AMBIGUOUS if len(used) == 1 else HOLDS), quantities


@judges("longer with μ0")
def longer_with_friction(evidence: Evidence) -> Judged:
    rows = evidence.slipping()
    onset, stepped = rows["x0_slip"].to_numpy(), rows["x0_max"].to_numpy()
    # Points on one level are in one state.
    bent = bending_at_the_last_state(rows.drop_duplicates("x0_max"))
    locked, trailing = len(evidence.locking()), evidence.trailing()
    quantities = {
        "exact onset at the smallest μ0": (onset[0], "L"),
        "exact onset at the largest μ0 that slips": (onset[-1], "L"),
        "energy at the smallest μ0": (bent.energy[0], "E*I0/L"),
        "energy at the largest μ0 that slips": (bent.energy[-1], "E*I0/L"),
        "points that lock": (locked, "1"),
    }
    if not rises(onset) or (np.diff(stepped) < 0.0).any():
        return CONTRADICTED, quantities
    verdict, reason = by_bending("the deformation is stronger", *neighbours([bent]))
    if verdict is not HOLDS or not locked:
        return verdict, quantities, reason
    if len(trailing) < locked:
        reason += "; up to the critical friction coefficient; beyond, some tips never slip"
        return CONDITION, quantities, reason
    until, after = trailing["x0_trail"].to_numpy(), bending_at_the_end_of_trailing(trailing)
    quantities |= {
        "x0_trail at the smallest μ0 that locks": (until[0], "L"),
        "x0_trail at the largest μ0": (until[-1], "L"),
        "energy there": (after.energy[-1], "E*I0/L"),
        "length of a later period at the largest μ0": (trailing["dragged"].iloc[-1], "L"),
    }
    if not rises(np.concatenate([onset, until])):
        return CONTRADICTED, quantities, "the displacement does not get longer at the lock"
    if rises(np.concatenate([bent.energy, after.energy])):
        return HOLDS, quantities, f"{reason}; so it is after the rod has buckled laterally"
    reason += (
        "; up to the critical friction coefficient; beyond, the clamp moves farther still, as the "
        "rod buckles laterally and trails, but the rod is less deformed where its tip slips"
    )
    if trailing["dragged"].max() < onset[-1]:
        reason += ", and its later periods are shorter"
    return CONDITION, quantities, reason


@judges("μ0 from the moment")
def friction_from_moment(evidence: Evidence) -> Judged:
    quantities, monotone, sign_changes = {}, [], 0
    for theta in (1.0, 2.0, 3.0):
        curve = solve_curve(theta, evidence.eta)
        state = curve.state(np.linspace(0.0, curve.x0_lock, 401))
        monotone.append(rises(state.reaction_m) and rises(curve.friction_demand(state.x0)))
        sign_changes += int((np.diff(np.sign(state.reaction_m)) != 0).sum())
        quantities[f"moment at α = 0, θ = {theta:g}"] = (state.reaction_m[0], "E*I0/L")
        quantities[f"moment at the lock, θ = {theta:g}"] = (state.reaction_m[-1], "E*I0/L")
    quantities["curves on which the moment changes its sign"] = (sign_changes, "1")
    if not all(monotone):
        return CONTRADICTED, quantities
    return CONDITION, quantities


@judges("longer periods with θ and μ0")
def longer_periods(evidence: Evidence) -> Judged:
    slides = evidence.slip_lengths()
    sticks = evidence.by_theta("x0_max").loc[slides.index, slides.columns]
    quantities = {
        "shortest sticking": (sticks.to_numpy().min(), "L"),
        "longest sticking": (sticks.to_numpy().max(), "L"),
        "shortest slide": (slides.to_numpy().min(), "L"),
        "longest slide": (slides.to_numpy().max(), "L"),
    }
    return holds_if(
        all(rises(table, axis) for table in (sticks, slides) for axis in (0, 1))
    ), quantities


@judges("longer way")
def longer_way(evidence: Evidence) -> Judged:
    lengths = evidence.scan_lengths()
    quantities = {
        "shortest distance": (lengths.to_numpy().min(), "L"),
        "longest distance": (lengths.to_numpy().max(), "L"),
        "events in each": (evidence.cycle_counts().to_numpy().min(), "1"),
    }
    return holds_if(rises(lengths, 0) and rises(lengths, 1)), quantities


@judges("more steps")
def more_steps(evidence: Evidence) -> Judged:
    counts = evidence.of_scans(lambda rows: len(rows) - 1)
    quantities = {
        "fewest steps": (counts.to_numpy().min(), "1"),
        "most steps": (counts.to_numpy().max(), "1"),
    }
    if not (rises(counts, 0) and rises(counts, 1)):
        return CONTRADICTED, quantities
    return (HOLDS if evidence.scan["dx0"].nunique() == 1 else AMBIGUOUS), quantities


@judges("more events with μ0")
def more_events(evidence: Evidence) -> Judged:
    distance = evidence.scan_lengths().to_numpy().max()
    # The slip takes a step, too.
    events = round(distance / evidence.dx0) // (evidence.by_theta("n_steps") + 1)
    quantities = {"distance": (distance, "L")} | {
        f"events at θ = {theta:g}, μ0 = {mu0:g}": (events.loc[theta, mu0], "1")
        for theta in (1.0, 2.0, 3.0)
        for mu0 in events.columns
    }
    more = np.diff(events.to_numpy(), axis=1)
    reason = (
        "on a given distance there are fewer for each θ, as follows from the paper's own "
        "sentences before it: each event takes longer"
    )
    if len(trailing := evidence.trailing()):
        pushed = 1.0 / float(evidence.slipping()["x0_slip"].iloc[-1])
        dragged = 1.0 / float(trailing["dragged"].iloc[0])
        quantities["events per L just below μ_lock"] = (pushed, "1/L")
        quantities["events per L of the dragged rod just above it"] = (dragged, "1/L")
        if dragged > pushed:
            reason += "; there are more only from below μ_lock to above it, where rods are dragged"
    if (more > 0).all():
        return HOLDS, quantities
    if (more < 0).all():
        return CONTRADICTED, quantities, reason
    return AMBIGUOUS, quantities


@judges("negative φ1 in Figure 8")
def negative_slope(evidence: Evidence) -> Judged:
    phi1 = float(evidence.state["phi1"])
    quantities = {
        "φ1": (phi1, "rad"),
        "f": (evidence.state["f"], "E*I0/L^2"),
        "−tan α": (-math.tan(evidence.state["alpha"]), "1"),
    }
    return holds_if(phi1 < 0.0), quantities


@judges("penetration in Figure 8")
def penetration(evidence: Evidence) -> Judged:
    height = float(np.max(evidence.state["shape_y"])) - float(evidence.state["eta"])
    quantities = {"height above the surface": (height, "L")}
    return holds_if(height > NEGLIGIBLE), quantities


@judges("correct in theory")
def correct_in_theory(evidence: Evidence) -> Judged:
    residual, margin = float(evidence.state["residual"]), float(evidence.state["stability"])
    quantities = {"residual": (residual, "1"), "least second variation": (margin, "1")}
    if residual > NEGLIGIBLE:
        return CONTRADICTED, quantities
    return (CONDITION if margin <= 0.0 else HOLDS), quantities


@judges("contact along a line")
def line_contact(evidence: Evidence) -> Judged:
    points = pd.concat([evidence.taper, evidence.friction])
    passing = int(points["penetrates"].astype(bool).sum())
    theta, eta, x1 = (float(evidence.state[name]) for name in ("theta", "eta", "x1"))
    lying = solve_state(theta, eta, x1, Contact.LINE)
    quantities = {
        "points of Figures 6 and 7 that penetrate": (passing, "1"),
        "points": (len(points), "1"),
        "f in tip contact": (evidence.state["f"], "E*I0/L^2"),
        "f in line contact": (lying.f, "E*I0/L^2"),
        "free length in line contact": (lying.s_c, "L"),
    }
    if passing:
        return HOLDS, quantities
    return (CONTRADICTED if not evidence.state["penetrates"] else CONDITION), quantities
