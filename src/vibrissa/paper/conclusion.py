"""Claims of the paper's Section V, its conclusions."""

import math
from decimal import Decimal
from functools import partial

import numpy as np
import pandas as pd

from vibrissa.decimals import exact
from vibrissa.numerics.steps import last_step_within, step_position
from vibrissa.outcomes import Contact
from vibrissa.paper import ledger
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
    neighbours,
    rises,
)
from vibrissa.paper.ledger import Finding
from vibrissa.sticking.api import solve_curve, solve_state

claim = partial(ledger.claim, section="V")


@claim(
    name="step size analysed",
    statement="The relation of x0,max to the step Δx0 has been analysed.",
    computed="steps of the study; x0,max at θ = 2, μ0 = 0.4 with steps from 0.01 down to 0.00001",
)
def step_size_analysed(evidence: Evidence) -> Finding:
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
        return CONTRADICTED.because("the error is not less than a step", quantities)
    if len(used) == 1:
        reason = (
            "the figures have one step alone and cannot show it; with finer steps x0,max is the "
            "exact onset rounded down to the step grid, too small by less than one step"
        )
        return AMBIGUOUS.because(reason, quantities)
    return HOLDS.because("x0,max is too small by less than one step, whatever the step", quantities)


@claim(
    name="longer with μ0",
    statement="Within a period, more friction means that the clamp moves farther and the rod is "
    "more deformed.",
    computed="x0 and bending at the last sticking state over the μ0 of Figure 7; above μ_lock the "
    "same where a rod that has swung aside slips",
)
def longer_with_friction(evidence: Evidence) -> Finding:
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
        return CONTRADICTED.because("the displacement does not get longer", quantities)
    finding = by_bending("the deformation is stronger", *neighbours([bent]), quantities)
    if finding.verdict is not HOLDS or not locked:
        return finding
    reason = f"{finding.reason}; up to the critical friction coefficient"
    if len(trailing) < locked:
        return CONDITION.because(f"{reason}; beyond, some tips never slip", quantities)
    until, after = trailing["x0_trail"].to_numpy(), bending_at_the_end_of_trailing(trailing)
    quantities |= {
        "x0_trail at the smallest μ0 that locks": (until[0], "L"),
        "x0_trail at the largest μ0": (until[-1], "L"),
        "energy there": (after.energy[-1], "E*I0/L"),
        "length of a later period at the largest μ0": (trailing["dragged"].iloc[-1], "L"),
    }
    if not rises(np.concatenate([onset, until])):
        return CONTRADICTED.because("the displacement does not get longer at the lock", quantities)
    if rises(np.concatenate([bent.energy, after.energy])):
        return HOLDS.because(
            f"{finding.reason}; so it is after the rod has swung aside", quantities
        )
    reason += (
        "; beyond, the clamp moves farther still, as the rod swings aside and trails, but the rod "
        "is less deformed where its tip slips"
    )
    if trailing["dragged"].max() < onset[-1]:
        reason += ", and its later periods are shorter"
    return CONDITION.because(reason, quantities)


@claim(
    name="μ0 from the moment",
    statement="The forces and the moment at the clamp just before slip determine μ0.",
    computed="whether −tan α is a one-to-one function of the clamp moment up to the lock, at "
    "θ = 1, 2 and 3",
)
def friction_from_moment(evidence: Evidence) -> Finding:
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
        return CONTRADICTED.because("one moment belongs to several μ0", quantities)
    reason = "the forces alone determine μ0; the moment alone does if θ and η are known"
    if sign_changes:
        reason += "; its size alone does not, as it changes its sign"
    return CONDITION.because(reason, quantities)


@claim(
    name="longer periods with θ and μ0",
    statement="With more taper and friction the tip sticks and slides farther.",
    computed="x0,max and slides of the scans over θ and over μ0",
)
def longer_periods(evidence: Evidence) -> Finding:
    slides = evidence.slip_lengths()
    sticks = evidence.by_theta("x0_max").loc[slides.index, slides.columns]
    quantities = {
        "shortest sticking": (sticks.to_numpy().min(), "L"),
        "longest sticking": (sticks.to_numpy().max(), "L"),
        "shortest slide": (slides.to_numpy().min(), "L"),
        "longest slide": (slides.to_numpy().max(), "L"),
    }
    if all(rises(table, axis) for table in (sticks, slides) for axis in (0, 1)):
        return HOLDS.because("both get longer with θ and with μ0", quantities)
    return CONTRADICTED.because("some get shorter", quantities)


@claim(
    name="longer way",
    statement="With more taper and friction the same number of events takes a longer distance.",
    computed="distance that the clamp moves in the scans over θ and over μ0",
)
def longer_way(evidence: Evidence) -> Finding:
    lengths = evidence.scan_lengths()
    quantities = {
        "shortest distance": (lengths.to_numpy().min(), "L"),
        "longest distance": (lengths.to_numpy().max(), "L"),
        "events in each": (evidence.cycle_counts().to_numpy().min(), "1"),
    }
    if rises(lengths, 0) and rises(lengths, 1):
        return HOLDS.because("the distance gets longer with θ and with μ0", quantities)
    return CONTRADICTED.because("the distance does not always get longer", quantities)


@claim(
    name="more steps",
    statement="With more taper and friction the clamp takes more steps in all.",
    computed="steps in the scans over θ and over μ0",
)
def more_steps(evidence: Evidence) -> Finding:
    counts = evidence.of_scans(lambda rows: len(rows) - 1)
    quantities = {
        "fewest steps": (counts.to_numpy().min(), "1"),
        "most steps": (counts.to_numpy().max(), "1"),
    }
    if not (rises(counts, 0) and rises(counts, 1)):
        return CONTRADICTED.because("the number does not always rise", quantities)
    if evidence.scan["dx0"].nunique() == 1:
        return HOLDS.because("with the same step and number of events", quantities)
    return AMBIGUOUS.because("the scans have different steps", quantities)


@claim(
    name="more events with μ0",
    statement="In summary, at a given θ more friction leads to more events.",
    computed="events over the distance of the longest scan, for each θ and μ0 of Figure 6; events "
    "per length on both sides of μ_lock in Figure 7",
)
def more_events(evidence: Evidence) -> Finding:
    distance = evidence.scan_lengths().to_numpy().max()
    # The slip takes a step, too.
    events = round(distance / evidence.dx0) // (evidence.by_theta("n_steps") + 1)
    quantities = {"distance": (distance, "L")} | {
        f"events at θ = {theta:g}, μ0 = {mu0:g}": (events.loc[theta, mu0], "1")
        for theta in (1.0, 2.0, 3.0)
        for mu0 in events.columns
    }
    more = np.diff(events.to_numpy(), axis=1)
    exception = ""
    if len(trailing := evidence.trailing()):
        pushed = 1.0 / float(evidence.slipping()["x0_slip"].iloc[-1])
        dragged = 1.0 / float(trailing["dragged"].iloc[0])
        quantities["events per L just below μ_lock"] = (pushed, "1/L")
        quantities["events per L of the dragged rod just above it"] = (dragged, "1/L")
        if dragged > pushed:
            exception = (
                "; there are more only from below μ_lock to above it, where rods are dragged"
            )
    if (more > 0).all():
        return HOLDS.because("there are more", quantities)
    if (more < 0).all():
        reason = (
            "on a given distance there are fewer for each θ, as follows from the paper's own "
            "sentences before it: each event takes longer"
        )
        return CONTRADICTED.because(f"{reason}{exception}", quantities)
    return AMBIGUOUS.because("for some θ there are more, for some fewer", quantities)


@claim(
    name="negative φ1 in Figure 8",
    statement="A cylinder with x1 = 0.15 and y1 = 0.55 has a negative slope at its tip.",
    computed="φ1 of the equilibrium of lowest force",
)
def negative_slope(evidence: Evidence) -> Finding:
    phi1 = float(evidence.state["phi1"])
    quantities = {
        "φ1": (phi1, "rad"),
        "f": (evidence.state["f"], "E*I0/L^2"),
        "−tan α": (-math.tan(evidence.state["alpha"]), "1"),
    }
    if phi1 < 0.0:
        return HOLDS.because("it is negative", quantities)
    return CONTRADICTED.because("it is not negative", quantities)


@claim(
    name="penetration in Figure 8",
    statement="This shape passes through the surface.",
    computed="highest point of the shape above the surface",
)
def penetration(evidence: Evidence) -> Finding:
    height = float(np.max(evidence.state["shape_y"])) - float(evidence.state["eta"])
    quantities = {"height above the surface": (height, "L")}
    if height > NEGLIGIBLE:
        return HOLDS.because("it does", quantities)
    return CONTRADICTED.because("it stays below", quantities)


@claim(
    name="correct in theory",
    statement="As a solution of the model the shape of Figure 8 is correct.",
    computed="residual of the equations and the least second variation of the energy",
)
def correct_in_theory(evidence: Evidence) -> Finding:
    residual, margin = float(evidence.state["residual"]), float(evidence.state["stability"])
    quantities = {"residual": (residual, "1"), "least second variation": (margin, "1")}
    if residual > NEGLIGIBLE:
        return CONTRADICTED.because("it does not satisfy the equations", quantities)
    if margin <= 0.0:
        return CONDITION.because("it is an equilibrium, but not a stable one", quantities)
    return HOLDS.because("it is a stable equilibrium of the model", quantities)


@claim(
    name="contact along a line",
    statement="Not every situation comes out realistic; contact along a whole line has to be "
    "considered.",
    computed="points of Figures 6 and 7 whose rods penetrate; Figure 8's rod in line contact",
)
def line_contact(evidence: Evidence) -> Finding:
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
        return HOLDS.because("points of Figures 6 and 7 need it, too", quantities)
    if not evidence.state["penetrates"]:
        return CONTRADICTED.because("no rod penetrates", quantities)
    reason = "for states like Figure 8; no point of the paper's other figures needs it"
    return CONDITION.because(reason, quantities)
