"""Equilibrium paths of batches of rods by spectral collocation.

Paths are followed on few nodes (`following`), cut into smooth parts (`cutting`) and resolved
(`refinement`).
"""

from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from vibrissa.mechanics.equations import FX, FY, ClosingCondition, ends
from vibrissa.mechanics.lateral import lateral_stability
from vibrissa.mechanics.mounting import IDEAL, Mounting, rod_columns
from vibrissa.mechanics.newton import solve
from vibrissa.mechanics.states import RodStates
from vibrissa.numerics.arrays import BoolArray, FloatArray
from vibrissa.outcomes import Contact, End, RodSection, Solver, Status
from vibrissa.sticking.curve import StickingCurve, failed_curve
from vibrissa.sticking.locks import assembled_curves
from vibrissa.sticking.piece import CONTACT_SLACK, NO_PIECES, Pieces
from vibrissa.sticking.solving.beginning import begin
from vibrissa.sticking.solving.branches import Branches
from vibrissa.sticking.solving.cutting import cut, exact_ends, guessed
from vibrissa.sticking.solving.finishing import NONE_FINISHED, Finished, finished
from vibrissa.sticking.solving.following import (
    CLOSENESS,
    Closeness,
    Ended,
    Followed,
    Knots,
    between,
    follow,
)
from vibrissa.sticking.solving.refinement import (
    NOT_RESOLVED,
    STATES_ALONG_PART,
    StatesAlongParts,
    resolve,
)

METHOD = Solver.COLLOCATION
# Number of paths that are solved together: enough to share the overhead of each call, and few
# enough for the processor's cache.
BATCH = 256
# A round rod is followed until its contact point is this far behind the clamp (L).
BEHIND_CLAMP = 1e-6
# Value of tan α up to which a retracted rod is followed. Close to a vanishing normal force, s_c
# changes so fast that few paths could be resolved.
MOST_RETRACTED = 3.001
# Margin out of the plane below which a round rod has certainly buckled, and the number of nodes on
# which it is computed.
PAST_BUCKLING, LATERAL_NODES = -0.02, 24

NO_SWITCH = (
    "a change of the kind of contact could not be located, or two of them lie within one step; "
    "try a slightly different eta or theta"
)
NO_END = "the curve could not be followed to its end; try a slightly different eta or theta"


def solve_curves(
    theta: FloatArray,
    eta: FloatArray,
    model: Contact = Contact.POINT,
    mountings: Sequence[Mounting] | None = None,
    section: RodSection = RodSection.ROUND,
    retract: bool = False,
    onsets: bool = False,
) -> list[StickingCurve]:
    """Solve the equilibrium paths of rods with the taper factors `theta` and the heights `eta` (L).

    Parameters
    ----------
    model : Contact
        POINT: only the tip touches; LINE: the rod may also lie on the surface.
    mountings : sequence of Mounting, length n, optional
        Mounting of each rod; by default all mountings are ideal.
    section : RodSection
        ROUND: a path ends at the latest where the rod buckles laterally. PLANAR: it ends at the
        latest where x0 turns back.
    retract : bool
        Whether to solve the retraction of every rod: the clamp is pulled back (x0 < 0) until the
        normal force vanishes, or as far as the states can be resolved. If false, only round rods in
        the ideal mounting have a retraction, up to tan α = 3.
    onsets : bool
        Whether only onsets and locks are needed. Then no retraction is solved, and the curve ends
        soon after its lock, with the end ``not_followed``.

    Returns
    -------
    list of StickingCurve
        Curves in the order of the rods. Their status is ``failed`` if a path was not resolved up to
        its lock, and ``out_of_reach`` if no α = 0 state exists or if the shape becomes inadmissible
        before the lock.
    """
    theta, eta = np.asarray(theta, dtype=float), np.asarray(eta, dtype=float)
    mounted = [IDEAL] * len(theta) if mountings is None else list(mountings)
    curves: dict[int, StickingCurve] = {}
    pending = list(range(len(theta)))
    for closeness in CLOSENESS:
        for batch in _batches(pending, mounted):
            some = theta[batch], eta[batch], [mounted[row] for row in batch]
            for row, curve in zip(
                batch, _solved(*some, model, section, closeness, retract, onsets), strict=True
            ):
                # A failed attempt does not replace an earlier curve that has states.
                if curve.status is not Status.FAILED or not curves.get(row, curve).pieces:
                    curves[row] = curve
        pending = [
            row
            for row in pending
            if curves[row].status is Status.FAILED
            or (curves[row].end is End.NOT_FOLLOWED and not onsets)
            or (retract and not curves[row].retraction)
        ]
    return [curves[row] for row in range(len(theta))]


def _batches(rows: Sequence[int], mounted: Sequence[Mounting]) -> Iterator[list[int]]:
    """Batches of rods of one kind: ideal mounting, ideal except for the stage, or any other."""
    kinds: dict[tuple[bool, bool], list[int]] = defaultdict(list)
    for row in rows:
        kinds[mounted[row].is_ideal_rod, mounted[row].is_ideal].append(row)
    for some in kinds.values():
        yield from (some[start : start + BATCH] for start in range(0, len(some), BATCH))


def _solved(
    theta: FloatArray,
    eta: FloatArray,
    mountings: Sequence[Mounting],
    model: Contact,
    section: RodSection,
    closeness: Closeness,
    retract: bool,
    onsets: bool,
) -> list[StickingCurve]:
    """Solve the curves of rods by following paths as closely as `closeness` says."""
    rods = rod_columns(theta, mountings)
    stage_angle = np.array([one.stage_angle for one in mountings])
    begun = begin(rods, eta, stage_angle, closeness.nodes, model)
    upright = ClosingCondition.prescribing(begun.branches.eta, {FX: 1.0})
    x1_init = exact_ends(begun.states, upright)[:, 0]
    unresolved = begun.rows[np.isnan(x1_init)].tolist()
    missing = begun.missing | dict.fromkeys(unresolved, (Status.FAILED, NOT_RESOLVED))
    curves = {
        row: failed_curve(float(theta[row]), float(eta[row]), message, status)
        for row, (status, message) in missing.items()
    }
    known = np.flatnonzero(np.isfinite(x1_init))
    if len(known):
        branches, rows = replace(begun.branches, x1_init=x1_init).take(known), begun.rows[known]
        some = branches, begun.states.take(known), [mountings[row] for row in rows]
        found = _curves(*some, model, section, closeness, retract, onsets)
        curves |= zip(rows.tolist(), found, strict=True)
    return [
        replace(curves[row], mounting=mountings[row], contact_model=model)
        for row in range(len(eta))
    ]


class _ResolvedPath(NamedTuple):
    """A path of one rod, as far as it was resolved.

    Attributes
    ----------
    found : Finished
        Its resolved parts, in the order of x0.
    whole : bool
        Whether none of its parts has failed.
    turned : bool
        Whether it was followed to a kink at which x0 turns back.
    """

    found: Finished
    whole: bool
    turned: bool


class _Paths(NamedTuple):
    """Paths of one rod: the clamp pushes the tip, or is pulled back; None if not followed."""

    pushed: _ResolvedPath
    retracted: _ResolvedPath | None


def _curves(
    branches: Branches,
    states: RodStates,
    mountings: Sequence[Mounting],
    model: Contact,
    section: RodSection,
    closeness: Closeness,
    retract: bool,
    onsets: bool,
) -> list[StickingCurve]:
    """Make the curves of branches: follow each path from its first state, and resolve the path."""
    ideal = mountings[0].is_ideal
    both = (retract or (ideal and section is RodSection.ROUND)) and not onsets
    paths = _paths(
        branches,
        states,
        model,
        section,
        closeness,
        retract=retract,
        ideal=ideal,
        both=both,
        onsets=onsets,
    )
    rows = [row for row, path in enumerate(paths) if len(path.pushed.found)]
    uncut = []
    for row in rows:
        pushed, retracted = paths[row]
        retraction = NONE_FINISHED
        # A retraction on request may be resolved in part only.
        if retracted is not None and (retract or retracted.whole):
            retraction = retracted.found
        curve = _uncut(branches, row, pushed.found, retraction)
        turned = pushed.turned and pushed.whole
        end, message = (End.SNAPS, "") if turned else (End.NOT_FOLLOWED, NO_END)
        curve = replace(curve, section=section, mounting=mountings[row])
        uncut.append(replace(curve, end=end, end_message=message))
    limits = [paths[row].pushed.found.limits for row in rows]
    assembled = assembled_curves(uncut, limits) if rows else []
    curves = dict(zip(rows, assembled, strict=True))
    for row in range(len(states)):
        theta, eta = float(branches.rods[row, 0]), float(branches.eta[row])
        if row not in curves:
            curves[row] = failed_curve(theta, eta, NOT_RESOLVED)
        elif model is Contact.LINE and not _is_possible(curves[row]):
            curves[row] = failed_curve(theta, eta, NO_SWITCH)
    return [curves[row] for row in range(len(states))]


def _paths(
    branches: Branches,
    states: RodStates,
    model: Contact,
    section: RodSection,
    closeness: Closeness,
    *,
    retract: bool,
    ideal: bool,
    both: bool,
    onsets: bool,
) -> list[_Paths]:
    """Follow and resolve the paths of rods; if `both`, those in retraction with the others."""
    count, round_rods = len(states), section is RodSection.ROUND
    side = np.ones(count)
    if both:
        branches, states = Branches.concatenate([branches] * 2), RodStates.concatenate([states] * 2)
        side = np.append(side, -side)
    most = np.inf if retract else MOST_RETRACTED
    ended = _ended(side, section, ideal, most)
    followed = follow(branches, states, side, model, ended, closeness.longest)
    followed = followed._replace(knots=_up_to_steep(branches, followed, side, most))
    if onsets:
        followed = _up_to_lock(followed)
    resolved = _resolved(branches, followed, side, model, round_rods=round_rods, ideal=ideal)
    pushed, retracted = resolved[:count], resolved[count:]
    if not retracted:
        return [_Paths(pushed=path, retracted=None) for path in pushed]
    return [_Paths(pushed=a, retracted=b) for a, b in zip(pushed, retracted, strict=True)]


def _uncut(branches: Branches, row: int, pushed: Finished, retraction: Finished) -> StickingCurve:
    """Join the resolved parts of one path to a curve that is not yet cut off at its end."""
    limits = retraction.limits
    admissible = np.isnan([limits.out_of_reach, limits.swings_aside]).all()
    return StickingCurve(
        theta=float(branches.rods[row, 0]),
        eta=float(branches.eta[row]),
        method=METHOD,
        status=Status.SOLVED,
        x1_init=float(branches.x1_init[row]),
        pieces=_from_zero(pushed.pieces),
        retraction=retraction.pieces if admissible else NO_PIECES,
        residual=float(np.append(pushed.residual, retraction.residual).max()),
    )


def _from_zero(pieces: Pieces) -> Pieces:
    """Return the pieces with the first x0 exactly 0, not up to rounding."""
    x0 = pieces.states.x0.copy()
    x0[0, 0] = 0.0
    return replace(pieces, states=replace(pieces.states, x0=x0))


def _ended(side: FloatArray, section: RodSection, ideal: bool, most: float) -> Ended:
    """Return the function that tells where paths end; `follow` also ends them where x0 turns."""

    def ended(branches: Branches, knots: Knots) -> BoolArray:
        states = knots.states
        steep = states.fx / most + states.fy >= 0.0
        if section is RodSection.PLANAR:
            pushed = np.zeros(len(knots), dtype=bool)
        elif ideal:
            pushed = ends(states).offset - (1.0 - states.s_c) < -BEHIND_CLAMP
        else:
            pushed = has_buckled(states)
        return (states.fy >= 0.0) | np.where(side[knots.branch] < 0.0, steep, pushed)

    return ended


def has_buckled(states: RodStates) -> BoolArray:
    """Whether round rods have certainly buckled laterally before they reach these plane states."""
    nodes = min(states.nodes, LATERAL_NODES)
    return np.asarray(lateral_stability(states.on_nodes(nodes)) < PAST_BUCKLING)


def _up_to_steep(branches: Branches, followed: Followed, side: FloatArray, most: float) -> Knots:
    """If a path in retraction passes tan α = `most`, move its end back to this value."""
    knots = followed.knots
    excess = knots.states.fx / most + knots.states.fy
    last = np.flatnonzero(followed.last & (side[knots.branch] < 0.0) & (excess > 0.0))
    last = last[knots.step[last] > 0.0]
    if not len(last):
        return knots
    some, low = branches.take(knots.branch[last]), knots.take(last - 1)
    share = excess[last - 1] / (excess[last - 1] - excess[last])
    steep = some.prescribing({FX: 1.0 / most, FY: 1.0})
    states, found, _ = solve(between(low, knots.take(last), share), steep)
    return replace(knots, states=knots.states.with_rows(last[found], states.take(found)))


def _up_to_lock(followed: Followed) -> Followed:
    """Cut off paths at the knot after the one with the largest −tan α, if that is not the first.

    The exact maximum is between the two knots beside the largest one.
    """
    knots, begins = followed.knots, np.flatnonzero(followed.first)
    states, number = knots.states, np.arange(len(knots))
    with np.errstate(divide="ignore", invalid="ignore"):
        demand = np.where(states.fy < 0.0, states.fx / states.fy, np.inf)
    largest = np.maximum.reduceat(demand, begins)[knots.branch]
    # A kink has two knots with the same state.
    at = np.maximum.reduceat(np.where(demand == largest, number, 0), begins)[knots.branch]
    beyond = (number > at + 1) & ~followed.first[at]
    turned = followed.turned.copy()
    turned[knots.branch[beyond]] = False
    return Followed(knots=knots.take(~beyond), turned=turned)


def _resolved(
    branches: Branches,
    followed: Followed,
    side: FloatArray,
    model: Contact,
    *,
    round_rods: bool,
    ideal: bool,
) -> list[_ResolvedPath]:
    """Resolve the parts of each path, in the order of x0, up to a failure."""
    knots, parts = followed.knots, cut(branches, followed, side)
    if round_rods and ideal:
        # In point contact the rod buckles where the offset is zero: later states are not needed.
        under = (side * branches.x1_init)[parts.branch] - parts.start
        tip = parts.by_x0 & ~parts.line & (side[parts.branch] > 0.0)
        shorter = np.where(tip, np.minimum(parts.length, under), parts.length)
        parts = replace(parts, length=shorter)
    known = parts.take(np.flatnonzero(parts.length > 0.0))
    guess = StatesAlongParts(
        parts=known, unknowns=guessed(known, branches, knots, STATES_ALONG_PART[0])
    )
    solved = (
        finished(one, branches, side, model, round_rods=round_rods, ideal=ideal)
        for one in resolve(guess)
    )
    found = Finished.concatenate([NONE_FINISHED, *solved])
    length = found.pieces.stop - found.pieces.start
    covered = np.bincount(found.knot, length, len(knots))[parts.first]
    complete = covered > parts.length * (1.0 - 1e-9)
    # A path is kept up to the first part that could not be resolved.
    whole, counts = np.ones(len(side), dtype=bool), np.zeros(len(knots), dtype=bool)
    for knot, branch, known in zip(parts.first, parts.branch, complete, strict=True):
        whole[branch] &= known
        counts[knot] = whole[branch]
    paths = []
    for branch in range(len(side)):
        rows = np.flatnonzero(counts[found.knot] & (knots.branch[found.knot] == branch))
        rows = rows[np.argsort(found.pieces.first_x0[rows])]
        paths.append(
            _ResolvedPath(
                found=found.take(rows),
                whole=bool(whole[branch]),
                turned=bool(followed.turned[branch]),
            )
        )
    return paths


def _is_possible(curve: StickingCurve) -> bool:
    """Whether the kind of contact of each piece is possible in all its states."""
    pieces, slack = Pieces.concatenate([curve.retraction, curve.pieces]), CONTACT_SLACK
    phi1, s_c = pieces.samples.phi1, pieces.samples.s_c
    lies = pieces.line[:, None]
    return bool(np.where(lies, (0.0 < s_c) & (s_c <= 1.0 + slack), phi1 >= -slack).all())
