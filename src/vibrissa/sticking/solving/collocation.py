"""Sticking curves by spectral collocation: batches of (θ, η).

A curve is solved in stages, each for the whole batch at once. It is followed in coarse steps on few
nodes (`continuation`): a round rod along x0 until the clamp has passed under the contact point, and
to x0 < 0, where the tip is pulled; a planar one along x0 until −tan α has passed its maximum, then
along the advance until x0 turns back. It is cut where the contact changes its kind (`sections`), as
it is smooth only between; and each piece is resolved (`refinement`).
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from vibrissa.mechanics.equations import (
    contact_position,
)
from vibrissa.mechanics.mounting import IDEAL, Mounting
from vibrissa.numerics.arrays import BoolArray, FloatArray
from vibrissa.outcomes import Contact, End, Parameter, RodSection, Solver, Status
from vibrissa.sticking.assembly import Solved, assembled_curves
from vibrissa.sticking.curve import StickingCurve, failed_curve
from vibrissa.sticking.piece import CONTACT_SLACK, PieceArray
from vibrissa.sticking.solving.beginning import Rods, begin_mounted
from vibrissa.sticking.solving.continuation import (
    ahead_of_clamp,
    both_ways,
    first_segment,
    has_swung,
    second_segment,
)
from vibrissa.sticking.solving.cuts import exact_advance, exact_x1_init
from vibrissa.sticking.solving.finishing import Resolved
from vibrissa.sticking.solving.refinement import NOT_RESOLVED, guess_from, resolve
from vibrissa.sticking.solving.sections import Sections, in_order, pieces_of, sections_of
from vibrissa.sticking.solving.segments import STEP_SIZES, Segment, StepSizes

METHOD = Solver.COLLOCATION
# Curves that are solved together: more share the overhead of each call, fewer stay in the
# processor's cache and bound the memory. Round rods have a pulled part, too.
BATCH = {RodSection.ROUND: 128, RodSection.PLANAR: 256}

NO_LOCK = "no maximum of -tan(alpha) was found along x0; try a larger eta or a theta closer to 1"
NO_SWITCH = (
    "a change of the kind of contact could not be located, or two of them lie within one step; "
    "try a slightly different eta or theta"
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
            solved = _solve_batch(Rods.of(theta[batch], eta[batch], some), model, section)
            for row, one, curve in zip(batch, some, solved, strict=True):
                curves[int(row)] = curve if one == IDEAL else replace(curve, mounting=one)
    return [curves[row] for row in range(len(theta))]


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
    sections: Mapping[Parameter, Sequence[Sections]]
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
    sections = sections_of(both, np.minimum(end, 0.0), np.maximum(stop, 0.0))
    solved = _solve_sections(both, sections, RodSection.ROUND)
    return _Followed(
        first=first,
        passed=_passed(first) | (ahead_of_clamp(first.at(first.last)[0]) < 0.0),
        sections={Parameter.X0: sections[:count]},
        solved=solved[:count],
        pulled=[
            in_order(Parameter.X0, bounds, parts)
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
    ahead = sections_of(first, zero, joint)
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
    past: list[Sections] = [None] * count
    if len(rows):
        second = second_segment(first.take(rows), sizes, model, section)
        stop = second.origin + second.last * second.step
        sections = sections_of(second, exact_advance(first.take(rows), joint[rows]), stop)
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
    branches = replace(first.branches, x1_init=exact_x1_init(first))
    if rods.mounting is None:
        branches = replace(branches, scale=branches.x1_init)
    return replace(first, branches=branches)


def _solve_sections(
    segment: Segment, sections: Sequence[Sections], section: RodSection
) -> list[list[Resolved]]:
    """Resolve the sections of each branch."""
    solved: list[list[Resolved]] = [[] for _ in sections]
    for contact in Contact:
        pieces = pieces_of(contact, segment, sections, section)
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
    sections: Mapping[Parameter, Sections],
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
    whole = {name: in_order(name, bounds, solved) for name, bounds in sections.items()}
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


def _is_possible(curve: StickingCurve) -> bool:
    """Whether no piece has the other kind of contact than it was cut out for."""
    pieces, slack = PieceArray(pieces=(*curve.pulled, *curve.pieces)), CONTACT_SLACK
    phi1, s_c = pieces.samples.phi1, pieces.samples.s_c
    lies = pieces.line[:, None]
    return bool(np.where(lies, (0.0 < s_c) & (s_c <= 1.0 + slack), phi1 >= -slack).all())
