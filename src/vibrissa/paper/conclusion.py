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
    ENERGY,
    HOLDS,
    NEGLIGIBLE,
    by_bending,
    ends,
    holds_if,
    judged,
    neighbours,
    rises,
    spread,
)
from vibrissa.paper.ledger import Judged, Quantities, judges
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
        **spread("x0,max with steps of 0.01 to 0.00001", stepped, "L"),
        "largest error in units of the step": (share.max(), "1"),
    }
    return judged(
        quantities,
        contradicted=not ((share >= 0.0) & (share < 1.0)).all(),
        ambiguous=len(used) == 1,
    )


@judges("longer with μ0")
def longer_with_friction(evidence: Evidence) -> Judged:
    rows, locked = evidence.slipping(), evidence.locking()
    onset, until = rows["x0_slip"].to_numpy(), locked["x0_trail"].to_numpy()
    # Points on one level are in one state.
    bent = bending_at_the_last_state(rows.drop_duplicates("x0_max"))
    quantities = ends("exact onset", onset, "L") | ends("energy", bent.energy, ENERGY)
    if not rises(onset) or (np.diff(rows["x0_max"]) < 0.0).any():
        return CONTRADICTED, quantities
    verdict, reason = by_bending("the deformation is stronger", *neighbours([bent]))
    if verdict is not HOLDS:
        return verdict, quantities, reason
    after = bending_at_the_end_of_trailing(locked).energy
    quantities |= ends("x0_trail above the lock,", until, "L")
    quantities |= ends("energy above the lock,", after, ENERGY)
    if not rises(np.concatenate([onset, until])):
        return CONTRADICTED, quantities, "the displacement does not get longer at the lock"
    if rises(np.concatenate([bent.energy, after])):
        return HOLDS, quantities, f"{reason}; so it is after the rod has buckled laterally"
    reason += (
        "; up to the critical friction coefficient; beyond, the clamp moves farther still, as the "
        "rod buckles laterally and trails, but the rod is less deformed where its tip slips"
    )
    return CONDITION, quantities, reason


@judges("μ0 from the moment")
def friction_from_moment(evidence: Evidence) -> Judged:
    quantities: Quantities = {}
    monotone, sign_changes = [], 0
    for theta in (1.0, 2.0, 3.0):
        curve = solve_curve(theta, evidence.eta)
        state = curve.state(np.linspace(0.0, curve.x0_lock, 401))
        monotone.append(rises(state.reaction_m) and rises(curve.mobilised_friction(state.x0)))
        sign_changes += int((np.diff(np.sign(state.reaction_m)) != 0).sum())
        quantities |= spread(f"moment up to the lock, θ = {theta:g}", state.reaction_m, ENERGY)
    quantities["curves on which the moment changes its sign"] = (sign_changes, "1")
    return (CONDITION if all(monotone) else CONTRADICTED), quantities


@judges("longer periods with θ and μ0")
def longer_periods(evidence: Evidence) -> Judged:
    slides = evidence.slip_lengths()
    sticks = evidence.by_theta("x0_max").loc[slides.index, slides.columns]
    quantities = spread("period of sticking", sticks, "L") | spread("slide", slides, "L")
    rising = [rises(table, axis) for table in (sticks, slides) for axis in (0, 1)]
    return holds_if(all(rising)), quantities


@judges("longer way")
def longer_way(evidence: Evidence) -> Judged:
    lengths = evidence.scan_lengths()
    events = evidence.cycle_counts().to_numpy().min()
    quantities = {**spread("distance", lengths, "L"), "events in each": (events, "1")}
    return holds_if(rises(lengths, 0) and rises(lengths, 1)), quantities


@judges("more steps")
def more_steps(evidence: Evidence) -> Judged:
    counts = evidence.of_scans(lambda rows: len(rows) - 1)
    quantities = spread("number of steps", counts, "1")
    rising = rises(counts, 0) and rises(counts, 1)
    several = evidence.scan["dx0"].nunique() > 1
    return judged(quantities, contradicted=not rising, ambiguous=several)


@judges("more events with μ0")
def more_events(evidence: Evidence) -> Judged:
    distance = evidence.scan_lengths().to_numpy().max()
    # The slip takes a step, too.
    events = round(distance / evidence.dx0) // (evidence.by_theta("n_steps") + 1)
    quantities = {"distance": (distance, "L"), **ends("events at θ = 2", events.loc[2.0], "1")}
    more = np.diff(events.to_numpy(), axis=1)
    if not (more < 0).all():
        return (HOLDS if (more > 0).all() else AMBIGUOUS), quantities
    reason = (
        "on a given distance there are fewer for each θ, as follows from the paper's own "
        "sentences before it: each event takes longer"
    )
    pushed, dragged = evidence.slipping()["x0_slip"].iloc[-1], evidence.locking()["dragged"].iloc[0]
    quantities["length of a period just below μ_lock"] = (pushed, "L")
    quantities["length of a period of the dragged rod just above it"] = (dragged, "L")
    if dragged < pushed:
        reason += "; there are more only from below μ_lock to above it, where rods are dragged"
    return CONTRADICTED, quantities, reason


@judges("negative φ1 in Figure 8")
def negative_slope(evidence: Evidence) -> Judged:
    phi1, alpha = float(evidence.state["phi1"]), float(evidence.state["alpha"])
    return holds_if(phi1 < 0.0), {"φ1": (phi1, "rad"), "−tan α": (-math.tan(alpha), "1")}


@judges("penetration in Figure 8")
def penetration(evidence: Evidence) -> Judged:
    height = float(np.max(evidence.state["shape_y"])) - float(evidence.state["eta"])
    return holds_if(height > NEGLIGIBLE), {"height above the surface": (height, "L")}


@judges("correct in theory")
def correct_in_theory(evidence: Evidence) -> Judged:
    residual, margin = float(evidence.state["residual"]), float(evidence.state["stability"])
    quantities = {"residual": (residual, "1"), "least second variation": (margin, "1")}
    return judged(quantities, contradicted=residual > NEGLIGIBLE, condition=margin <= 0.0)


@judges("contact along a line")
def line_contact(evidence: Evidence) -> Judged:
    points = pd.concat([evidence.taper, evidence.friction])
    passing = int(points["penetrates"].astype(bool).sum())
    theta, eta, x1 = (float(evidence.state[name]) for name in ("theta", "eta", "x1"))
    lying = solve_state(theta, eta, x1, Contact.LINE)
    quantities = {
        f"of {len(points)} points of Figures 6 and 7, those that penetrate": (passing, "1"),
        "f in tip contact": (evidence.state["f"], "E*I0/L^2"),
        "f in line contact": (lying.f, "E*I0/L^2"),
    }
    no_rod = not (passing or evidence.state["penetrates"])
    return judged(quantities, contradicted=no_rod, condition=not passing)
