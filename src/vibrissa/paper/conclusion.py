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
    ENERGY,
    NEGLIGIBLE,
    by_bending,
    ends,
    judged,
    neighbours,
    rises,
    spread,
)
from vibrissa.paper.ledger import Finding, Quantities, Verdict, judges
from vibrissa.sticking.api import solve_curve, solve_state


@judges("step size analysed")
def step_size_analysed(evidence: Evidence) -> Finding:
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
def longer_with_friction(evidence: Evidence) -> Finding:
    rows, locked = evidence.slipping(), evidence.locking()
    onset, until = rows["x0_slip"].to_numpy(), locked["x0_trail"].to_numpy()
    # Points on one level of the step grid have the same last sticking state.
    bent = bending_at_the_last_state(rows.drop_duplicates("x0_max"))
    quantities = ends("exact onset", onset, "L") | ends("energy", bent.energy, ENERGY)
    if not rises(onset) or (np.diff(rows["x0_max"]) < 0.0).any():
        return judged(quantities, contradicted=True)
    found = by_bending("the deformation is stronger", *neighbours([bent]), quantities)
    if found.verdict is not Verdict.HOLDS:
        return found
    after = bending_at_the_end_of_trailing(locked).energy
    quantities |= ends("x0_trail above the lock,", until, "L")
    quantities |= ends("energy above the lock,", after, ENERGY)
    return judged(
        quantities,
        contradicted=not rises(np.concatenate([onset, until])),
        condition=not rises(np.concatenate([bent.energy, after])),
    )


@judges("μ0 from the moment")
def friction_from_moment(evidence: Evidence) -> Finding:
    quantities: Quantities = {}
    monotone, sign_changes = True, 0
    for theta in (1.0, 2.0, 3.0):
        curve = solve_curve(theta, evidence.eta)
        state = curve.state(np.linspace(0.0, curve.x0_lock, 401))
        monotone &= rises(state.reaction_m) and rises(curve.mobilised_friction(state.x0))
        sign_changes += int((np.diff(np.sign(state.reaction_m)) != 0).sum())
        quantities |= spread(f"moment up to the lock, θ = {theta:g}", state.reaction_m, ENERGY)
    quantities["curves on which the moment changes its sign"] = (sign_changes, "1")
    return judged(quantities, contradicted=not monotone, condition=True)


@judges("longer periods with θ and μ0")
def longer_periods(evidence: Evidence) -> Finding:
    slides = evidence.slip_lengths()
    sticks = evidence.by_theta("x0_max").loc[slides.index, slides.columns]
    quantities = spread("period of sticking", sticks, "L") | spread("slide", slides, "L")
    return judged(quantities, contradicted=not (rises(sticks, 0, 1) and rises(slides, 0, 1)))


@judges("longer way")
def longer_way(evidence: Evidence) -> Finding:
    lengths = evidence.scan_lengths()
    events = evidence.cycle_counts().to_numpy().min()
    quantities = {**spread("distance", lengths, "L"), "events in each scan": (events, "1")}
    return judged(quantities, contradicted=not rises(lengths, 0, 1))


@judges("more steps")
def more_steps(evidence: Evidence) -> Finding:
    counts = evidence.of_scans(lambda rows: len(rows) - 1)
    quantities = spread("number of steps", counts, "1")
    several = evidence.scan["dx0"].nunique() > 1
    return judged(quantities, contradicted=not rises(counts, 0, 1), ambiguous=several)


@judges("more events with μ0")
def more_events(evidence: Evidence) -> Finding:
    distance = evidence.scan_lengths().to_numpy().max()
    # The slip takes a step, too.
    events = round(distance / evidence.dx0) // (evidence.by_theta("n_steps") + 1)
    pushed, dragged = evidence.slipping()["x0_slip"].iloc[-1], evidence.locking()["dragged"].iloc[0]
    quantities = {
        "distance": (distance, "L"),
        **ends("events at θ = 2", events.loc[2.0], "1"),
        "length of a period just below μ_lock": (pushed, "L"),
        "length of a period of the dragged rod just above μ_lock": (dragged, "L"),
    }
    more = np.diff(events.to_numpy(), axis=1)
    return judged(quantities, contradicted=(more < 0).all(), ambiguous=not (more > 0).all())


@judges("negative φ1 in Figure 8")
def negative_slope(evidence: Evidence) -> Finding:
    phi1, alpha = float(evidence.state["phi1"]), float(evidence.state["alpha"])
    quantities = {"φ1": (phi1, "rad"), "−tan α": (-math.tan(alpha), "1")}
    return judged(quantities, contradicted=phi1 >= 0.0)


@judges("penetration in Figure 8")
def penetration(evidence: Evidence) -> Finding:
    height = float(np.max(evidence.state["shape_y"])) - float(evidence.state["eta"])
    quantities = {"height above the surface": (height, "L")}
    return judged(quantities, contradicted=height <= NEGLIGIBLE)


@judges("correct in theory")
def correct_in_theory(evidence: Evidence) -> Finding:
    residual, margin = float(evidence.state["residual"]), float(evidence.state["stability"])
    quantities = {"residual": (residual, "1"), "least second variation": (margin, "1")}
    return judged(quantities, contradicted=residual > NEGLIGIBLE, condition=margin <= 0.0)


@judges("contact along a line")
def line_contact(evidence: Evidence) -> Finding:
    points = pd.concat([evidence.taper, evidence.friction])
    passing = int(points["penetrates"].astype(bool).sum())
    theta, eta, x1 = (float(evidence.state[name]) for name in ("theta", "eta", "x1"))
    lying = solve_state(theta, eta, x1, Contact.LINE)
    quantities = {
        f"points that penetrate, of {len(points)} in Figures 6 and 7": (passing, "1"),
        "f in tip contact": (evidence.state["f"], "E*I0/L^2"),
        "f in line contact": (lying.f, "E*I0/L^2"),
    }
    no_rod = not (passing or evidence.state["penetrates"])
    return judged(quantities, contradicted=no_rod, condition=not passing)
