"""Sticking curves by spectral collocation: batches of (θ, η).

A curve is solved in stages, each for the whole batch at once. It is followed in coarse steps on few
nodes (`vibrissa.sticking.continuation`): a round rod along x0 until the clamp has passed under the
contact point, and to x0 < 0, where the tip is pulled; a planar one along x0 until −tan α has passed
its maximum, then along the advance until x0 turns back. It is cut where the contact changes its
kind, as it is smooth only between; and each piece is resolved (`vibrissa.sticking.refinement`).
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from vibrissa.mechanics.admissibility import clearances
from vibrissa.mechanics.equations import (
    Closure,
    coefficient_decay,
    contact_position,
    largest_residual,
)
from vibrissa.mechanics.mounting import IDEAL, Mounting, Mountings
from vibrissa.mechanics.newton import solve
from vibrissa.mechanics.stability import stability
from vibrissa.mechanics.states import RodStates
from vibrissa.numerics.arrays import BoolArray, FloatArray, IntArray
from vibrissa.outcomes import Contact, End, Parameter, RodSection, Solver, Status
from vibrissa.sticking.beginning import NO_INITIAL_STATE, Rods, begin_mounted
from vibrissa.sticking.continuation import (
    ahead_of_clamp,
    both_ways,
    first_segment,
    follow,
    has_swung,
    second_segment,
    switch_states,
)
from vibrissa.sticking.curve import Solved, StickingCurve, assembled_curves, failed_curve
from vibrissa.sticking.piece import PieceArray
from vibrissa.sticking.refinement import (
    DECAY_TOLERANCE,
    NODES_ALONG_ROD,
    RESIDUAL_TOLERANCE,
    Pieces,
    Resolved,
    guess_from,
    residual_tolerance,
    resolve,
)
from vibrissa.sticking.segments import Branches, Segment, StepSizes

METHOD = Solver.COLLOCATION
# How branches are followed: more closely where the step sizes before lead nowhere, or past a change
# of the contact. The pieces have nodes and states of their own.
STEP_SIZES = (
    StepSizes(nodes=24, x0=0.05, advance=0.15),
    StepSizes(nodes=48, x0=0.02, advance=0.03),
    StepSizes(nodes=108, x0=0.01, advance=0.005),
)
# Curves that are solved together: more share the overhead of each call, fewer stay in the
# processor's cache and bound the memory. Round rods have a pulled part, too.
BATCH = {RodSection.ROUND: 128, RodSection.PLANAR: 256}

# A state with a smaller margin of stability stands at a limit point.
FOLD_MARGIN = 1e-3
NO_LOCK = "no maximum of -tan(alpha) was found along x0; try a larger eta or a theta closer to 1"
NO_SWITCH = (
    "a change of the kind of contact could not be located, or two of them lie within one step; "
    "try a slightly different eta or theta"
)
NOT_FOLLOWED = (
    "no state at this x1 was found on the branch that begins at alpha = 0; it may end before"
)
NOT_RESOLVED = (
    f"residual or series decay above {RESIDUAL_TOLERANCE:g} with {NODES_ALONG_ROD[-1]} nodes along "
    f"the rod; try an eta between 0.3 and 0.9999 and a theta up to 20"
)
AT_FOLD = (
    "the branch turns back here: at its limit point no state can be resolved; try an x1 that is "
    "larger by 1e-9 or more"
)
NO_ROUND_END = "the curve could not be followed to where the clamp passes under the contact"
NO_END = "the curve could not be followed from the lock to where it turns back"


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
            solved = _solve_batch(_rods(theta[batch], eta[batch], some), model, section)
            for row, one, curve in zip(batch, some, solved, strict=True):
                curves[int(row)] = curve if one == IDEAL else replace(curve, mounting=one)
    return [curves[row] for row in range(len(theta))]


def _rods(theta: FloatArray, eta: FloatArray, mountings: Sequence[Mounting]) -> Rods:
    """Rods of one kind: all ideal or none, and their stages likewise."""
    ideal, along = mountings[0].is_ideal_rod, mountings[0].stage_angle == 0.0
    return Rods(
        theta=theta,
        eta=eta,
        mounting=None if ideal else Mountings.of(mountings),
        stage_angle=None if along else np.array([one.stage_angle for one in mountings]),
    )


class StateSolution(NamedTuple):
    """One state that was sought, or why it was not found.

    Attributes
    ----------
    state : RodStates or None
        A batch of one, or None if none was resolved that is admissible.
    residual : float
        Its equilibrium residual.
    status : Status
        ``solved``, ``out_of_reach`` or ``failed``.
    message : str
        Empty, or what went wrong and what to try.
    """

    state: RodStates | None
    residual: float
    status: Status
    message: str


def solve_offsets(
    theta: FloatArray,
    eta: FloatArray,
    of: IntArray,
    offsets: FloatArray,
    model: Contact,
    mountings: Sequence[Mounting],
) -> list[StateSolution]:
    """Solve states with prescribed offsets x1 − x0 on the branches that begin at α = 0.

    Parameters
    ----------
    theta, eta : ndarray, shape (n,)
        Taper factors and heights of the surface (L).
    of : ndarray of int, shape (m,)
        Which of the rods each state belongs to.
    offsets : ndarray, shape (m,)
        Distances of the tip from the clamp along the surface (L).
    model : Contact
        POINT for contact with the tip alone, LINE for the kind of contact that is possible.
    mountings : sequence of Mounting, length n
        Their stages have no part in a single state.

    Returns
    -------
    list of StateSolution
    """
    mounted = [replace(one, stage_angle=0.0) for one in mountings]
    solutions = [StateSolution(None, np.nan, Status.FAILED, NO_INITIAL_STATE)] * len(offsets)
    pending = np.arange(len(offsets))
    for sizes in STEP_SIZES:
        kinds = np.array([mounted[rod].is_ideal_rod for rod in of[pending]], dtype=bool)
        for ideal in np.unique(kinds):
            rows = pending[kinds == ideal]
            rods, which = np.unique(of[rows], return_inverse=True)
            some = _rods(theta[rods], eta[rods], [mounted[rod] for rod in rods])
            for row, solution in zip(
                rows, _in_offsets(some, which, offsets[rows], sizes, model), strict=True
            ):
                solutions[row] = solution
        pending = pending[[solutions[row].status is Status.FAILED for row in pending]]
    return solutions


def _in_offsets(
    rods: Rods, of: IntArray, offsets: FloatArray, sizes: StepSizes, model: Contact
) -> list[StateSolution]:
    """Solve states with prescribed offsets in steps of given sizes."""
    begun, index, missing = begin_mounted(rods, sizes, model)
    place = np.full(len(rods), -1)
    place[index] = np.arange(len(index))
    solutions = [StateSolution(None, np.nan, Status.FAILED, NOT_FOLLOWED)] * len(offsets)
    for row in np.flatnonzero(place[of] < 0):
        status, message = missing[int(of[row])]
        solutions[row] = solutions[row]._replace(status=status, message=message)
    rows = np.flatnonzero(place[of] >= 0)
    if len(rows):
        found = _at_offsets(begun.take(place[of[rows]]), offsets[rows], sizes, model)
        for row, solution in zip(rows, found, strict=True):
            solutions[row] = solution
    return solutions


def _at_offsets(
    begun: Segment, offsets: FloatArray, sizes: StepSizes, model: Contact
) -> list[StateSolution]:
    """Follow branches to offsets, one for each."""
    # From α = 0 in steps no longer than those of the first segment.
    way = begun.branches.x1_init - offsets
    count = max(1, int(np.ceil((np.abs(way) / (sizes.x0 * begun.branches.scale)).max())))
    segment = follow(replace(begun, step=way / count), count, model)
    solutions = [StateSolution(None, np.nan, Status.FAILED, NOT_FOLLOWED)] * len(offsets)
    followed, line = segment.last >= count, segment.line[-1]
    for contact, kind in ((Contact.POINT, ~line), (Contact.LINE, line)):
        rows = np.flatnonzero(followed & kind)
        if len(rows):
            closure = Closure.at_offset(offsets[rows], contact)
            eta = segment.branches.eta[rows]
            found = _resolved_states(segment.steps[-1].take(rows), eta, closure)
            for row, solution in zip(rows, found, strict=True):
                solutions[row] = solution
    return solutions


def _resolved_states(guess: RodStates, eta: FloatArray, closure: Closure) -> list[StateSolution]:
    """Solve states of one kind of contact, each on as many nodes as it needs."""
    solutions: dict[int, StateSolution] = {}
    sought = np.arange(len(eta))
    for nodes in NODES_ALONG_ROD:
        height, closed = eta[sought], closure.take(sought)
        states = solve(guess.take(sought).on_nodes(nodes), height, closed).states
        residual = largest_residual(states, height, closed)
        resolved = _is_resolved(states, height, closed)
        rows = np.flatnonzero(resolved)
        shapes = clearances(states.take(rows), height[rows], closed.contact)
        for i, row in enumerate(rows):
            solution = StateSolution(
                states.take(rows[[i]]), float(residual[row]), Status.SOLVED, ""
            )
            if how := shapes.reasons(i):
                solution = solution._replace(state=None, status=Status.OUT_OF_REACH, message=how)
            solutions[int(sought[row])] = solution
        sought = sought[~resolved]
        if not len(sought):
            break
    at_fold = stability(guess.take(sought), closure.contact) < FOLD_MARGIN
    for row, folds in zip(sought, at_fold, strict=True):
        why = AT_FOLD if folds else NOT_RESOLVED
        solutions[int(row)] = StateSolution(None, np.nan, Status.FAILED, why)
    return [solutions[row] for row in range(len(eta))]


def _is_resolved(states: RodStates, eta: FloatArray, closure: Closure) -> BoolArray:
    """Whether states satisfy the equations between their nodes, and have enough of these."""
    accurate = largest_residual(states, eta, closure) < residual_tolerance(states.nodes)
    return accurate & (coefficient_decay(states) < DECAY_TOLERANCE)


def _solve_batch(rods: Rods, model: Contact, section: RodSection) -> list[StickingCurve]:
    """Solve one batch, and follow those more closely that need it."""
    results = _in_steps(rods, STEP_SIZES[0], model, section)
    for sizes in STEP_SIZES[1:]:
        pending = [
            i
            for i, curve in enumerate(results)
            if curve.status is Status.FAILED or curve.end is End.NOT_FOLLOWED
        ]
        if not pending:
            break
        solved = _in_steps(rods.take(np.array(pending)), sizes, model, section)
        for index, curve in zip(pending, solved, strict=True):
            if curve.status is not Status.FAILED or results[index].status is Status.FAILED:
                results[index] = curve
    return results


class _Section(NamedTuple):
    """Part of a segment between two changes of the contact: first and last value, and its kind."""

    start: float
    stop: float
    line: bool


# None where the sections of a branch are not known.
_Sections = list[_Section] | None


class _Followed(NamedTuple):
    """Curves as they were followed and resolved, an item for each.

    Attributes
    ----------
    first : Segment
        From the first states on, where the clamp pushes.
    passed : ndarray of bool, shape (n,)
        Whether each was followed far enough.
    sections : mapping of Parameter to list
        Sections of the segments where the clamp pushes.
    solved, pulled : list of list of Resolved
        Pieces of these, and of the segments where it pulls.
    """

    first: Segment
    passed: BoolArray
    sections: Mapping[Parameter, Sequence[_Sections]]
    solved: Sequence[Sequence[Resolved]]
    pulled: Sequence[Sequence[Resolved]]


def _in_steps(
    rods: Rods, sizes: StepSizes, model: Contact, section: RodSection
) -> list[StickingCurve]:
    """Solve curves in steps of given sizes."""
    begun, index, missing = begin_mounted(rods, sizes, model)
    results: dict[int, StickingCurve] = {}
    for row, (status, message) in missing.items():
        theta, eta = float(rods.theta[row]), float(rods.eta[row])
        results[row] = _failed(theta, eta, message, status)
    if len(index):
        if section is RodSection.ROUND and rods.are_ideal:
            followed = _follow_round(begun, rods, sizes, model)
        else:
            followed = _follow_planar(begun, rods, sizes, model, section)
        found: dict[int, Solved | StickingCurve] = {
            int(i): _to_be_assembled(
                theta=float(rods.theta[i]),
                eta=float(rods.eta[i]),
                x1_init=float(followed.first.branches.x1_init[row]),
                passed=bool(followed.passed[row]),
                sections={name: bounds[row] for name, bounds in followed.sections.items()},
                solved=followed.solved[row],
                pulled=followed.pulled[row],
                section=section,
                ideal=rods.are_ideal,
            )
            for row, i in enumerate(index)
        }
        results |= _assembled(found, model)
    return [results[row] for row in range(len(rods))]


def _follow_round(begun: Segment, rods: Rods, sizes: StepSizes, model: Contact) -> _Followed:
    """Follow round rods to where they swing aside, and to where they are pulled off."""
    count = len(begun.origin)
    ahead = np.arange(count)
    both = both_ways(begun, sizes, model)
    first = _exactly_begun(both.take(ahead), rods)
    both = replace(both, branches=first.branches.take(np.tile(ahead, 2)))
    end = both.last * both.step
    # In point contact the clamp passes under the contact point at x1_init: nothing counts behind.
    lies = both.line[both.last, np.arange(2 * count)]
    stop = np.where(lies, end, np.minimum(end, both.branches.x1_init))
    sections = _sections(both, np.minimum(end, 0.0), np.maximum(stop, 0.0))
    solved = _solve_sections(both, sections, RodSection.ROUND)
    return _Followed(
        first=first,
        passed=_passed(first) | (ahead_of_clamp(first.at(first.last)[0]) < 0.0),
        sections={Parameter.X0: sections[:count]},
        solved=solved[:count],
        pulled=[
            _whole(Parameter.X0, bounds, parts)
            for bounds, parts in zip(sections[count:], solved[count:], strict=True)
        ],
    )


def _follow_planar(
    begun: Segment, rods: Rods, sizes: StepSizes, model: Contact, section: RodSection
) -> _Followed:
    """Follow rods in their plane to where they turn back."""
    first = _exactly_begun(first_segment(begun, sizes, model), rods)
    count = len(first.origin)
    zero, joint = np.zeros(count), first.last * first.step
    ahead = _sections(first, zero, joint)
    solved = _solve_sections(first, ahead, section)
    # The second segments are followed once the first ones are solved: not of what is inadmissible,
    # nor where the tip lifts off or the rod leaves its plane, nor where the initial state is not
    # resolved.
    admissible = [
        not any(np.isfinite([part.limit.at, part.swing]).any() for part in parts)
        for parts in solved
    ]
    resolved = np.isfinite(first.branches.x1_init)
    rows = np.flatnonzero(admissible & resolved & (first.at(first.last)[0].fy < 0.0))
    past: list[_Sections] = [None] * count
    if len(rows):
        second = second_segment(first.take(rows), sizes, model, section)
        stop = second.origin + second.last * second.step
        sections = _sections(second, _exact_advance(first.take(rows), joint[rows]), stop)
        ended = _turned(second)
        if section is RodSection.ROUND:
            ended |= has_swung(second.at(second.last)[0])
        good = np.flatnonzero(ended & [part is not None for part in sections])
        known = [sections[i] for i in good]
        found = _solve_sections(second.take(good), known, section)
        for row, some, parts in zip(rows[good], known, found, strict=True):
            past[row] = some
            solved[row] += parts
    return _Followed(
        first=first,
        passed=_passed(first),
        sections={Parameter.X0: ahead, Parameter.ADVANCE: past},
        solved=solved,
        pulled=[[]] * count,
    )


def _exactly_begun(first: Segment, rods: Rods) -> Segment:
    """Segment with the exact contact points of its first states.

    What the pieces are cut at has to be exact, unlike the steps: it is solved on more nodes.
    """
    branches = replace(first.branches, x1_init=_exact_x1_init(first))
    if rods.mounting is None:
        branches = replace(branches, scale=branches.x1_init)
    return replace(first, branches=branches)


def _solve_sections(
    segment: Segment, sections: Sequence[_Sections], section: RodSection
) -> list[list[Resolved]]:
    """Resolve the sections of each branch."""
    solved: list[list[Resolved]] = [[] for _ in sections]
    for contact in Contact:
        pieces = _pieces(contact, segment, sections, section)
        for part in resolve(pieces, guess_from(segment, pieces)) if len(pieces) else ():
            solved[part.curve].append(part)
    return solved


def _passed(first: Segment) -> BoolArray:
    """Whether the first segments have found a maximum of −tan α or the tip lifting off."""
    fx, fy = first.forces
    last, rows = first.last, np.arange(len(first.origin))
    with np.errstate(invalid="ignore", divide="ignore"):
        demand = np.nan_to_num(fx / fy, nan=-np.inf)
    pulls = (fy[last, rows] >= 0.0) & (fx[last, rows] < 0.0)
    return pulls | (demand[last, rows] < np.maximum(demand.max(axis=0), 1e-300))


def _turned(segment: Segment) -> BoolArray:
    """Whether x0 decreases in the last step of each branch."""
    now, before = (contact_position(segment.at(segment.last - back)[0])[0] for back in (0, 1))
    return now > before


def _exact_x1_init(first: Segment) -> FloatArray:
    """Contact points of the α = 0 states; NaN where not resolved."""
    states, line = first.at(np.zeros(len(first.origin), dtype=np.int64))
    return _exact(
        states,
        line,
        replace(first.branches, stage_angle=None),
        lambda contact, i: Closure.at_inclination(np.zeros(len(i)), contact),
        lambda states, i: contact_position(states)[0],
    )


def _exact_advance(first: Segment, x0: FloatArray) -> FloatArray:
    """Advance of the states at given displacements, the last ones; NaN where not resolved."""
    states, line = first.at(first.last)
    return _exact(
        states,
        line,
        first.branches,
        lambda contact, i: first.branches.take(i).closure(Parameter.X0, contact, x0[i]),
        lambda states, i: first.branches.take(i).value_of(Parameter.ADVANCE, states),
    )


def _exact(
    states: RodStates,
    line: BoolArray,
    branches: Branches,
    closure: Callable[[Contact, IntArray], Closure],
    measure: Callable[[RodStates, IntArray], FloatArray],
) -> FloatArray:
    """Measure states on as many nodes as they need; NaN where there never are enough."""
    measured, height = np.full(len(states), np.nan), branches.height
    for contact, kind in ((Contact.POINT, ~line), (Contact.LINE, line)):
        rows = np.flatnonzero(kind)
        guess = states.take(rows)
        for nodes in NODES_ALONG_ROD:
            if not len(rows):
                break
            conditions = closure(contact, rows)
            solution = solve(guess.on_nodes(nodes), height[rows], conditions).states
            good = _is_resolved(solution, height[rows], conditions)
            measured[rows[good]] = measure(solution.take(good), rows[good])
            rows, guess = rows[~good], guess.take(~good)
    return measured


def _sections(segment: Segment, start: FloatArray, stop: FloatArray) -> list[_Sections]:
    """Cut segments where the contact changes its kind."""
    inner: list[list[float] | None] = [[] for _ in start]
    last = segment.last
    for k in range(len(segment.steps) - 1):
        changing = np.flatnonzero((segment.line[k] != segment.line[k + 1]) & (k < last))
        if not len(changing):
            continue
        switches = _switches(segment, k, changing)
        for curve, at in zip(changing.tolist(), switches, strict=True):
            known = inner[curve]
            # Segments are followed on fewer nodes than the switches are solved on.
            place = (at - segment.origin[curve]) / segment.step[curve]
            if known is not None:
                inner[curve] = [*known, float(at)] if k - 0.1 <= place <= k + 1.1 else None
    sections: list[_Sections] = []
    for curve, values in enumerate(inner):
        low, high = float(start[curve]), float(stop[curve])
        if values is None or not np.isfinite([low, high]).all() or last[curve] < 2:
            sections.append(None)
            continue
        # A pulled rod is followed downwards.
        bounds = [low, *sorted(min(max(value, low), high) for value in values), high]
        first = bool(segment.line[0 if segment.step[curve] > 0.0 else last[curve], curve])
        parts = [_Section(a, b, first ^ bool(i % 2)) for i, (a, b) in enumerate(pairwise(bounds))]
        sections.append([part for part in parts if part.start < part.stop])
    return sections


def _switches(segment: Segment, k: int, changing: IntArray) -> FloatArray:
    """Parameter at which the contact of some branches changes between step k and the next."""
    branches = segment.branches.take(changing)
    # From the side on which the tip alone touches.
    side = np.where(segment.line[k], k + 1, k)
    guess = switch_states(segment.at(side)[0].take(changing), branches)
    return _exact(
        guess,
        np.zeros(len(changing), dtype=bool),
        branches,
        lambda contact, i: branches.take(i).tilted(Closure.at_switch(len(i))),
        lambda states, i: branches.take(i).value_of(segment.parameter, states),
    )


def _pieces(
    contact: Contact, segment: Segment, sections: Sequence[_Sections], section: RodSection
) -> Pieces:
    """Pieces of a segment that have one kind of contact."""
    found = [
        (curve, part)
        for curve, parts in enumerate(sections)
        for part in parts or ()
        if part.line == (contact is Contact.LINE)
    ]
    curves = np.array([curve for curve, _ in found], dtype=np.int64)
    start = np.array([part.start for _, part in found], dtype=float)
    return Pieces(
        **segment.branches.take(curves).columns,
        contact=contact,
        parameter=segment.parameter,
        curve=curves,
        start=start,
        length=np.array([part.stop for _, part in found], dtype=float) - start,
        section=section,
    )


def _failed(
    theta: float, eta: float, message: str, status: Status = Status.FAILED
) -> StickingCurve:
    return failed_curve(theta=theta, eta=eta, method=METHOD, message=message, status=status)


def _assembled(
    found: Mapping[int, Solved | StickingCurve], model: Contact
) -> dict[int, StickingCurve]:
    """Put curves together, all at once; what is a curve already remains as it is."""
    solved = {row: one for row, one in found.items() if isinstance(one, Solved)}
    curves = dict(zip(solved, assembled_curves(list(solved.values())), strict=True))
    if model is Contact.LINE:
        curves = {
            row: curve if _is_possible(curve) else _failed(curve.theta, curve.eta, NO_SWITCH)
            for row, curve in curves.items()
        }
    return {row: one for row, one in found.items() if isinstance(one, StickingCurve)} | curves


def _to_be_assembled(
    *,
    theta: float,
    eta: float,
    x1_init: float,
    passed: bool,
    sections: Mapping[Parameter, _Sections],
    solved: Sequence[Resolved],
    pulled: Sequence[Resolved],
    section: RodSection,
    ideal: bool,
) -> Solved | StickingCurve:
    """Order the resolved pieces of one curve, or say why there is none."""
    if not passed:
        return _failed(theta, eta, NO_LOCK)
    if sections[Parameter.X0] is None:
        return _failed(theta, eta, NO_SWITCH if np.isfinite(x1_init) else NOT_RESOLVED)
    whole = {name: _whole(name, bounds, solved) for name, bounds in sections.items()}
    if not whole[Parameter.X0]:
        return _failed(theta, eta, NOT_RESOLVED)
    parts = [part for name in whole for part in whole[name]]
    if any(np.isfinite(part.limit.at) for part in pulled):
        pulled = []
    return Solved(
        theta=theta,
        eta=eta,
        method=METHOD,
        x1_init=x1_init,
        pieces=[part.piece for part in parts],
        residual=max(part.residual for part in (*parts, *pulled)),
        limits=[part.limit for part in parts],
        pulled=[part.piece for part in pulled],
        section=section,
        swings=None if ideal else [part.swing for part in parts],
        no_end=NO_ROUND_END if ideal and section is RodSection.ROUND else NO_END,
    )


def _whole(parameter: Parameter, sections: _Sections, solved: Sequence[Resolved]) -> list[Resolved]:
    """Order the resolved pieces of a segment; none if they do not cover it."""
    parts = [part for part in solved if part.piece.parameter is parameter]
    length = sum(section.stop - section.start for section in sections or ())
    covered = sum(part.piece.stop - part.piece.start for part in parts)
    if covered <= length * (1.0 - 1e-9):
        return []
    return sorted(parts, key=lambda part: part.piece.start)


def _is_possible(curve: StickingCurve) -> bool:
    """Whether no piece has the other kind of contact than it was cut out for."""
    pieces, slack = PieceArray(pieces=(*curve.pulled, *curve.pieces)), 1e-9
    phi1, s_c = pieces.samples.phi1, pieces.samples.s_c
    lies = pieces.line[:, None]
    return bool(np.where(lies, (0.0 < s_c) & (s_c <= 1.0 + slack), phi1 >= -slack).all())
