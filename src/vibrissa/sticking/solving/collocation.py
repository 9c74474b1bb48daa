"""Sticking curves by spectral collocation: batches of (θ, η).

A curve is solved in stages, each for the whole batch at once. Its path is followed in steps on few
nodes (`following`): that of a round rod until the clamp has passed under the contact point, and to
x0 < 0, where the tip is pulled; that of a planar one until x0 turns back. It is cut into smooth
pieces (`cutting`), and each of these is resolved (`refinement`).
"""

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from vibrissa.mechanics.aside import stability_aside
from vibrissa.mechanics.equations import Closure, contact_position
from vibrissa.mechanics.mounting import IDEAL, Mounting
from vibrissa.mechanics.states import RodStates
from vibrissa.numerics.arrays import BoolArray, FloatArray
from vibrissa.outcomes import Contact, End, RodSection, Solver, Status
from vibrissa.sticking.assembly import Solved, assembled_curves
from vibrissa.sticking.curve import StickingCurve, failed_curve
from vibrissa.sticking.piece import CONTACT_SLACK, PieceArray
from vibrissa.sticking.solving.beginning import CLOSENESS, Closeness, Rods, begin
from vibrissa.sticking.solving.branches import Branches
from vibrissa.sticking.solving.cutting import cuts, exact_x1_init, parts_of, places
from vibrissa.sticking.solving.finishing import Resolved
from vibrissa.sticking.solving.following import Ended, Followed, Knots, between, follow, solve_kinds
from vibrissa.sticking.solving.refinement import NOT_RESOLVED, STATES_ALONG_PIECE, resolve

METHOD = Solver.COLLOCATION
# Curves that are solved together: more share the overhead of each call, fewer stay in the
# processor's cache and bound the memory. Round rods have a pulled part, too.
BATCH = {RodSection.ROUND: 128, RodSection.PLANAR: 256}
# A round rod is followed until its contact point is this far behind the clamp (L).
BEHIND_CLAMP = 1e-6
# Friction up to which a pulled rod is followed: where the normal force vanishes, s_c runs so
# steeply that few paths would be resolved.
MOST_PULLED = 3.001
# Margin out of the plane below which a round rod has left it for certain, though it is found on few
# nodes.
PAST_SWING, NODES_ASIDE = -0.02, 24

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
) -> list[StickingCurve]:
    """Solve sticking curves for pairs of taper and height.

    Parameters
    ----------
    theta, eta : ndarray, shape (n,)
        Taper factors (≥ 1) and heights of the contact point (0 < η < 1, in units of L).
    model : Contact
        POINT for contact with the tip alone, LINE for the kind of contact that is possible.
    mountings : sequence of Mounting, length n, optional
        By default all are ideal.
    section : RodSection
        ROUND: the curves end where the rods swing aside, and have a pulled part where the mounting
        is ideal; PLANAR: they go on in the plane until they turn back.

    Returns
    -------
    list of StickingCurve
        In the order of the arguments; a pair without a resolved solution is ``failed``, one
        without a state to begin with ``out_of_reach``.
    """
    theta, eta = np.asarray(theta, dtype=float), np.asarray(eta, dtype=float)
    mounted = [IDEAL] * len(theta) if mountings is None else list(mountings)
    # What is ideal is solved without the terms of what is not.
    kinds = [(one.is_ideal_rod, one.stage_angle == 0.0) for one in mounted]
    curves: dict[int, StickingCurve] = {}
    for kind in dict.fromkeys(kinds):
        rows = np.flatnonzero([one == kind for one in kinds])
        size = BATCH[section if all(kind) else RodSection.PLANAR]
        for start in range(0, len(rows), size):
            batch = rows[start : start + size]
            some = [mounted[row] for row in batch]
            solved = _solve_batch(Rods.of(theta[batch], eta[batch], some), model, section)
            for row, one, curve in zip(batch, some, solved, strict=True):
                curves[int(row)] = curve if one == IDEAL else replace(curve, mounting=one)
    return [curves[row] for row in range(len(theta))]


def _solve_batch(rods: Rods, model: Contact, section: RodSection) -> list[StickingCurve]:
    """Solve one batch, and follow those on more nodes that need it."""
    results = _solve_so(CLOSENESS[0], rods, model, section)
    for closeness in CLOSENESS[1:]:
        pending = [
            i
            for i, curve in enumerate(results)
            if curve.status is Status.FAILED or curve.end is End.NOT_FOLLOWED
        ]
        if not pending:
            break
        solved = _solve_so(closeness, rods.take(np.array(pending)), model, section)
        for index, curve in zip(pending, solved, strict=True):
            if curve.status is not Status.FAILED or results[index].status is Status.FAILED:
                results[index] = curve
    return results


def _solve_so(
    closeness: Closeness, rods: Rods, model: Contact, section: RodSection
) -> list[StickingCurve]:
    """Solve curves that are followed so closely."""
    begun = begin(rods, closeness.nodes, model)
    missing = dict(begun.missing)
    x1_init = exact_x1_init(begun.branches, begun.states, begun.line)
    missing |= {int(row): (Status.FAILED, NOT_RESOLVED) for row in begun.rows[np.isnan(x1_init)]}
    known = np.flatnonzero(np.isfinite(x1_init))
    branches = replace(begun.branches, x1_init=x1_init)
    if rods.mounting is None:
        branches = replace(branches, scale=x1_init)
    curves = {
        row: _failed(float(rods.theta[row]), float(rods.eta[row]), message, status)
        for row, (status, message) in missing.items()
    }
    if len(known):
        first = branches.take(known), begun.states.take(known), begun.line[known]
        solved = _solved(*first, model, section, closeness.longest, ideal=rods.are_ideal)
        curves |= zip(begun.rows[known].tolist(), _assembled(solved, model), strict=True)
    return [curves[row] for row in range(len(rods))]


def _solved(
    branches: Branches,
    states: RodStates,
    line: BoolArray,
    model: Contact,
    section: RodSection,
    longest: float,
    *,
    ideal: bool,
) -> list[Solved | StickingCurve]:
    """Follow branches from their first states and resolve them."""
    count = len(line)
    both = ideal and section is RodSection.ROUND
    # A round rod that is pulled is followed, too.
    twice = np.tile(np.arange(count), 2 if both else 1)
    branches, states, line = branches.take(twice), states.take(twice), line[twice]
    side = np.where(np.arange(len(twice)) < count, 1.0, -1.0)
    ended = _ended(side, section, ideal=ideal)
    followed = follow(branches, states, line, side, model, ended, longest)
    followed = followed._replace(knots=_up_to_steep(branches, followed))
    parts, whole = _resolved_parts(branches, followed, section, ideal=ideal)
    return [
        _to_be_assembled(
            branches.take(np.array([row])),
            parts[row],
            parts[count + row] if both and whole[count + row] else [],
            turned=bool(followed.turned[row] and whole[row]),
            section=section,
            ideal=ideal,
        )
        for row in range(count)
    ]


def _ended(side: FloatArray, section: RodSection, *, ideal: bool) -> Ended:
    """Where paths end, besides where the displacement turns back."""

    def ended(branches: Branches, knots: Knots) -> BoolArray:
        states = knots.states
        lifts = states.fy >= 0.0
        if section is RodSection.PLANAR:
            return lifts
        if not ideal:
            return lifts | has_swung(states)
        offset, _ = contact_position(states)
        behind = offset - (1.0 - states.s_c) < -BEHIND_CLAMP
        steep = states.fx >= -MOST_PULLED * states.fy
        return lifts | np.where(side[knots.branch] < 0.0, steep, behind)

    return ended


def _up_to_steep(branches: Branches, followed: Followed) -> Knots:
    """Put the ends of pulled paths where they need the most friction up to which they are known."""
    knots = followed.knots
    excess = knots.states.fx + MOST_PULLED * knots.states.fy
    low = np.flatnonzero(followed.ends[:-1] & ~followed.ends[1:] & (excess[:-1] > 0.0))
    low = low[(knots.branch[low] == knots.branch[low + 1]) & (knots.step[low + 1] > 0.0)]
    if not len(low):
        return knots
    step, here = knots.step[low + 1], knots.states
    share = excess[low] / (excess[low] - excess[low + 1])
    ends, pairs = step[:, None] * np.array([0.0, 1.0]), low[:, None] + np.array([0, 1])
    guess = between(knots, pairs, share * step, ends, np.ones_like(ends))
    steep = Closure.at_inclination(np.full(len(low), np.arctan(MOST_PULLED)))
    some = branches.take(knots.branch[low])
    states, found = solve_kinds(guess, some.height, some.tilted(steep), knots.line[low])
    here = here.copy()
    here.put(low[found], states.take(found))
    return replace(knots, states=here)


def has_swung(states: RodStates) -> BoolArray:
    """Whether states in the plane lie beyond where a round rod leaves it."""
    nodes = min(states.nodes, NODES_ASIDE)
    return np.asarray(stability_aside(states.on_nodes(nodes)) < PAST_SWING)


class _Whole(NamedTuple):
    """Resolved pieces of each path, in order, up to the first part that could not be resolved."""

    pieces: list[list[Resolved]]
    whole: list[bool]


def _resolved_parts(
    branches: Branches, followed: Followed, section: RodSection, *, ideal: bool
) -> _Whole:
    """Cut paths into parts and resolve these."""
    knots, parts = followed.knots, parts_of(followed.knots)
    first, last = places(branches, followed, parts)
    if ideal and section is RodSection.ROUND:
        # In tip contact the clamp passes under the contact point where the offset is zero: nothing
        # counts behind.
        tip = ~knots.line[[part.last for part in parts]]
        last[tip, 0] = np.minimum(last[tip, 0], 0.0)
    solved: dict[int, list[Resolved]] = defaultdict(list)
    lengths = np.full(len(parts), np.nan)
    for cut in cuts(branches, followed, parts, (first, last), section, STATES_ALONG_PIECE[0]):
        lengths[cut.pieces.part] = cut.pieces.length
        for one in resolve(cut.pieces, cut.guess):
            solved[one.part].append(one)
    pieces: list[list[Resolved]] = [[] for _ in range(len(branches))]
    whole = [True] * len(branches)
    for number, part in enumerate(parts):
        found = sorted(solved[number], key=lambda one: one.piece.start)
        covered = sum(one.piece.stop - one.piece.start for one in found)
        whole[part.branch] &= bool(covered > lengths[number] * (1.0 - 1e-9))
        if whole[part.branch]:
            pieces[part.branch] += found
    return _Whole(pieces, whole)


def _failed(
    theta: float, eta: float, message: str, status: Status = Status.FAILED
) -> StickingCurve:
    return failed_curve(theta=theta, eta=eta, method=METHOD, message=message, status=status)


def _assembled(found: Sequence[Solved | StickingCurve], model: Contact) -> list[StickingCurve]:
    """Put curves together, all at once; what is a curve already remains as it is."""
    curves = iter(assembled_curves([one for one in found if isinstance(one, Solved)]))
    whole = [next(curves) if isinstance(one, Solved) else one for one in found]
    if model is not Contact.LINE:
        return whole
    return [
        curve if _is_possible(curve) else _failed(curve.theta, curve.eta, NO_SWITCH)
        for curve in whole
    ]


def _to_be_assembled(
    branch: Branches,
    parts: Sequence[Resolved],
    pulled: Sequence[Resolved],
    *,
    turned: bool,
    section: RodSection,
    ideal: bool,
) -> Solved | StickingCurve:
    """Put the resolved pieces of one curve together, or say why there are none."""
    theta, eta = float(branch.theta[0]), float(branch.eta[0])
    if not parts:
        return _failed(theta, eta, NOT_RESOLVED)
    # By definition, not up to rounding.
    parts[0].piece.states.x0[0] = 0.0
    if any(np.isfinite(part.limit.at) for part in pulled):
        pulled = []
    return Solved(
        theta=theta,
        eta=eta,
        method=METHOD,
        x1_init=float(branch.x1_init[0]),
        pieces=[part.piece for part in parts],
        residual=max(part.residual for part in (*parts, *pulled)),
        limits=[part.limit for part in parts],
        pulled=[part.piece for part in pulled],
        section=section,
        swings=None if ideal else [part.swing for part in parts],
        turned=turned,
        no_end=NO_END,
    )


def _is_possible(curve: StickingCurve) -> bool:
    """Whether no piece has the other kind of contact than it was cut out for."""
    pieces, slack = PieceArray(pieces=(*curve.pulled, *curve.pieces)), CONTACT_SLACK
    phi1, s_c = pieces.samples.phi1, pieces.samples.s_c
    lies = pieces.line[:, None]
    return bool(np.where(lies, (0.0 < s_c) & (s_c <= 1.0 + slack), phi1 >= -slack).all())
