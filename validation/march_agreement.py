"""Onsets, locks and ends of random rods, compared with an independent march.

The march (validation/march.py) shares neither code nor rules with the solver and the explorer; only
its guess of the state with α = 0 is taken from the solver. Planar rods have all deviations of the
mounting at once; half of the clamps are rigid, and half of the stages parallel. To ten planar rods
there is one round rod in the ideal mounting. Compared are how and where the path ends, μ_lock, and
where the tip begins to slip, forward or back, with five friction coefficients: three below the
first maximum of −tan α, two above.

The march does not locate where a rod crosses itself. Of such a rod only the onsets before are
compared, and that the solver's path ends between two states of the march.

Fails if a number differs by more than 1e-9, or if the march and the solver differ in kind.
"""

import argparse
import sys
from collections import Counter
from decimal import Decimal
from typing import NamedTuple

import numpy as np

from validation import march
from validation.records import write_record
from vibrissa.mechanics.mounting import Mounting
from vibrissa.outcomes import Contact, End, RodSection, Status
from vibrissa.sticking.curve import StickingCurve
from vibrissa.sticking.periods import read_curves
from vibrissa.sticking.solving.collocation import solve_curves
from vibrissa.wording import markdown_table

TOLERATED = 1e-9
CHUNK = 250
# Ranges of β, c, both coefficients of κ0, and δ.
LEAST, MOST = (-0.3, 0.0, -0.5, -0.4, -0.08), (0.3, 0.9, 0.2, 0.3, 0.08)
# Friction coefficients, relative to the first maximum of −tan α.
FRICTION = np.array([0.3, 0.7, 0.97, 1.02, 2.0])
# Ends of the march in the words of the package.
ENDS = {
    "lifts": End.LIFTS_OFF,
    "snaps": End.SNAPS,
    "swings": End.SWINGS_ASIDE,
    **dict.fromkeys(("dips", "arch", "curved", "tail", march.CROSSES), End.OUT_OF_REACH),
}
QUANTITIES = ("x0_end", "mu_lock", "x0_slip")


class Sample(NamedTuple):
    """Rods of one kind of contact and one section."""

    theta: np.ndarray
    eta: np.ndarray
    mountings: list[Mounting]
    contact: Contact
    section: RodSection


class Comparison(NamedTuple):
    """Outcomes of the comparison: counts, largest differences, and rods that differ in kind."""

    counts: Counter
    largest: dict[str, float]
    odd: list[str]


def drawn(count: int, seed: int, contact: Contact, section: RodSection) -> Sample:
    """Draw random rods: θ from 1 to 6, η from 0.4 to 0.98; round rods have the ideal mounting."""
    random = np.random.default_rng(seed)
    theta, eta = np.exp(random.uniform(0.0, np.log(6.0), count)), random.uniform(0.4, 0.98, count)
    deviations = random.uniform(LEAST, MOST, (count, 5))
    deviations[:, [1, 4]] *= random.integers(0, 2, (count, 2))
    if section is RodSection.ROUND:
        return Sample(theta, eta, [Mounting()] * count, contact, section)
    mountings = [
        Mounting(
            clamp_angle=angle,
            clamp_compliance=compliance,
            curvature=(constant, slope),
            stage_angle=stage,
        )
        for angle, compliance, constant, slope, stage in deviations.tolist()
    ]
    return Sample(theta, eta, mountings, contact, section)


def marched(sample: Sample, curves: list[StickingCurve]) -> march.Paths:
    """Follow the rods; their first states are guessed from the curves."""
    first = [curve.state(0.0) for curve in curves]
    line = np.array([curve.contact(0.0) == "line" for curve in curves])
    guess = [float(s.s_c if lies else s.phi1) for s, lies in zip(first, line, strict=True)]
    fy = np.array([float(state.reaction_fy) for state in first])
    n, mountings = len(curves), sample.mountings
    kappa = np.zeros((n, max(len(one.coefficients) for one in mountings)))
    for row, one in zip(kappa, mountings, strict=True):
        row[: len(one.coefficients)] = one.coefficients
    rods = march.Rods(
        theta=sample.theta,
        eta=sample.eta,
        beta=np.array([one.clamp_angle for one in mountings]),
        compliance=np.array([one.clamp_compliance for one in mountings]),
        kappa=kappa,
        delta=np.array([one.stage_angle for one in mountings]),
        lies=np.full(n, sample.contact is Contact.LINE),
        round=np.full(n, sample.section is RodSection.ROUND),
        x1=np.zeros(n),
    )
    return march.march(rods, line, np.stack([guess, 0.0 * fy, fy], axis=1))


def frictions(paths: march.Paths, rod: int) -> np.ndarray:
    """Friction coefficients for a rod, relative to the first maximum of −tan α."""
    demand = paths.states.demand[np.searchsorted(paths.of, rod) : paths.last(rod)]
    falls = np.flatnonzero((np.diff(demand) < 0.0) & (demand[:-1] > 0.0))
    return FRICTION * max(demand[falls[0]] if len(falls) else demand.max(), 0.01)


def solve(sample: Sample) -> list[StickingCurve]:
    """Solve the paths of a sample."""
    theta, eta, mountings, contact, section = sample
    return solve_curves(theta, eta, contact, mountings, section)


def with_path(sample: Sample, curves: list[StickingCurve]) -> Sample:
    """Return the rods of a sample that have a path, i.e. a state with α = 0."""
    rows = [row for row, curve in enumerate(curves) if curve.pieces]
    return sample._replace(
        theta=sample.theta[rows],
        eta=sample.eta[rows],
        mountings=[sample.mountings[row] for row in rows],
    )


def compare(sample: Sample, curves: list[StickingCurve]) -> Comparison:
    """Follow the rods of a sample with the march, and compare with their curves."""
    found = Comparison(Counter(), dict.fromkeys(QUANTITIES, 0.0), [])
    some = with_path(sample, curves)
    found.counts["no state at α = 0"] += len(curves) - len(some.theta)
    curves = [curve for curve in curves if curve.pieces]
    paths = marched(some, curves)
    for rod, curve in enumerate(curves):
        compare_ends(found, paths, rod, curve)
    compare_onsets(found, paths, curves)
    return found


def note(found: Comparison, curve: StickingCurve, what: str, name: str, gap: float) -> None:
    """Take a difference into account."""
    if gap > found.largest[name] or np.isnan(gap):
        found.largest[name] = gap
    if not gap <= TOLERATED:
        found.odd.append(
            f"{name} differs by {gap:.2g}, {what}: theta={curve.theta!r}, eta={curve.eta!r}, "
            f"contact={curve.contact_model.value}, {curve.mounting}; {curve.end}, "
            f"x0_end={curve.x0_end!r} {curve.end_message}"
        )


def compare_ends(found: Comparison, paths: march.Paths, rod: int, curve: StickingCurve) -> None:
    """Compare how and where a path ends, and μ_lock."""
    end, last = paths.ends[rod], paths.last(rod)
    x0 = paths.states.x0[last]
    found.counts[f"ends: {end}"] += 1
    if end == march.LOST or curve.end is End.NOT_FOLLOWED:
        note(found, curve, f"march: {end} at {x0!r}", "x0_end", np.inf)
        return
    same = curve.end is ENDS[end]
    if end == march.CROSSES:
        before = paths.states.x0[last - 1]
        gap = 0.0 if same and before - TOLERATED <= curve.x0_end <= x0 + TOLERATED else np.inf
        note(found, curve, f"march: {end} from {before!r} to {x0!r}", "x0_end", gap)
        return
    gap = abs(x0 - curve.x0_end) if same else np.inf
    note(found, curve, f"march: {end} at {x0!r}", "x0_end", gap)
    lock = march.largest_demand(paths, rod)
    known = curve.mu_lock if curve.status is Status.SOLVED else np.nan
    equal = lock == known or (np.isnan(lock) and np.isnan(known))
    gap = 0.0 if equal else np.nan_to_num(abs(lock - known), nan=np.inf)
    note(found, curve, f"march: {lock!r}, solver: {known!r}", "mu_lock", gap)


def compare_onsets(found: Comparison, paths: march.Paths, curves: list[StickingCurve]) -> None:
    """Compare where the tip begins to slip."""
    rods = [rod for rod, end in enumerate(paths.ends) if end != march.LOST]
    friction = [frictions(paths, rod) for rod in rods]
    steps = [[Decimal(1)] * len(FRICTION)] * len(rods)
    solver = read_curves([curves[rod] for rod in rods], friction, steps)
    of, mu0 = np.repeat(rods, len(FRICTION)), np.concatenate(friction)
    exits = march.exits(paths, of, mu0)
    forward = np.array([status is Status.SLIP for status in solver.status])
    back = np.array(solver.end) == End.SLIPS_BACK
    x0 = np.where(forward, solver.x0_slip, np.where(back, solver.ended.x0, np.nan))
    way = np.where(forward, 1.0, np.where(back, -1.0, 0.0))
    for row, rod in enumerate(of):
        name = {1.0: "slips forward", -1.0: "slips back", 0.0: "sticks to the end"}[exits.way[row]]
        if paths.ends[rod] == march.CROSSES and not exits.way[row]:
            continue
        found.counts[name] += 1
        gap = np.inf
        if way[row] == exits.way[row]:
            gap = np.nan_to_num(abs(x0[row] - exits.x0[row]), nan=0.0)
        what = f"mu0 = {mu0[row]!r}, march: {name} at {exits.x0[row]!r}, solver: {x0[row]!r}"
        note(found, curves[rod], what, "x0_slip", gap)


def chunks(rods: int, seed: int, contact: Contact) -> list[Sample]:
    """Draw the rods of one kind of contact, in parts."""
    sizes = [min(CHUNK, rods - start) for start in range(0, rods, CHUNK)]
    planar = [
        drawn(size, seed + part, contact, RodSection.PLANAR) for part, size in enumerate(sizes)
    ]
    return [*planar, drawn(max(rods // 10, 1), seed, contact, RodSection.ROUND)]


def compared(samples: list[Sample]) -> Comparison:
    """Compare samples, and put the results together."""
    parts = []
    for sample in samples:
        parts.append(compare(sample, solve(sample)))
        counts, largest, odd = parts[-1]
        print("\n".join([str(dict(counts)), f"largest differences: {largest}", *odd]), flush=True)
    return Comparison(
        sum((part.counts for part in parts), Counter()),
        {name: max(part.largest[name] for part in parts) for name in QUANTITIES},
        [one for part in parts for one in part.odd],
    )


def table(found: dict[str, Comparison], rods: dict[str, int]) -> str:
    """Format counts and largest differences in Markdown, a column for each kind of contact."""
    names = sorted(set().union(*(part.counts for part in found.values())))
    rows = [["rods", *(str(count) for count in rods.values())]]
    rows += [[name, *(str(part.counts[name]) for part in found.values())] for name in names]
    rows += [
        [
            f"largest difference of `{name}`",
            *(f"{part.largest[name]:.1e}" for part in found.values()),
        ]
        for name in QUANTITIES
    ]
    return markdown_table(["", *found], rows)


def main() -> None:
    """Read the options, and compare random rods."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rods", type=int, default=1000, help="in each kind of contact")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--contact", type=Contact, nargs="*", default=list(Contact))
    parser.add_argument("--record", action="store_true", help="write the record")
    options = parser.parse_args()
    found, rods = {}, {}
    for contact in options.contact:
        samples = chunks(options.rods, options.seed, contact)
        found[contact.value] = compared(samples)
        rods[contact.value] = sum(len(sample.theta) for sample in samples)
    result = table(found, rods)
    print(result)
    if options.record:
        write_record("march", __doc__, result)
    odd = [one for part in found.values() for one in part.odd]
    if odd:
        sys.exit(f"{len(odd)} numbers differ")
