"""Sticking curves by spectral collocation: batches of (θ, η).

A curve is solved in stages, each for the whole batch at once: it is followed in coarse steps on few
nodes (`vibrissa.branch`), first along x0 until −tan α has passed its maximum, then along the
advance until x0 turns back; it is cut where the contact changes its kind, as it is smooth only
between; and each piece is resolved (`vibrissa.pieces`).
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from vibrissa.arrays import BoolArray, FloatArray, IntArray
from vibrissa.branch import (
    Leg,
    Pace,
    begin,
    first_leg,
    follow,
    parameter_of,
    second_leg,
    switch_states,
)
from vibrissa.curve import Piece, StickingCurve, failed_curve, sticking_curve
from vibrissa.equilibrium import (
    Closure,
    ContactStates,
    coefficient_decay,
    contact_position,
    residual,
    solve,
    stability,
)
from vibrissa.pieces import (
    DECAY_TOLERANCE,
    NODES_ALONG_ROD,
    RESIDUAL_TOLERANCE,
    Pieces,
    Resolved,
    guess_from,
    residual_tolerance,
    resolve,
)
from vibrissa.reach import REASONS, violations
from vibrissa.status import Contact, End, Parameter, Status

METHOD = "collocation"
# How branches are followed: more closely where the pace before leads nowhere, or past a change of
# the contact. The pieces have nodes and states of their own.
PACES = (Pace(24, 0.05, 0.15), Pace(48, 0.02, 0.03), Pace(108, 0.01, 0.005))
# Curves that are solved together: bounds the memory and stays in the processor's cache.
BATCH = 256

NO_INITIAL_STATE = (
    "no first-mode state with alpha = 0 found; try a larger eta or a theta closer to 1"
)
NO_LOCK = (
    "the march along x0 ended before -tan(alpha) had a maximum; try a larger eta or a theta closer "
    "to 1"
)
NO_SWITCH = (
    "a change of the kind of contact could not be located, or there is more than one within a step "
    "of the march; try a slightly different eta or theta"
)
NOT_FOLLOWED = (
    "the branch that begins at alpha = 0 could not be followed to this offset; it may end before"
)
NOT_RESOLVED = (
    f"residual or series decay above {RESIDUAL_TOLERANCE:g} with {NODES_ALONG_ROD[-1]} nodes along "
    f"the rod; try an eta between 0.3 and 0.9999 and a theta up to 20"
)
NO_END = "the curve could not be followed from the lock to where it turns back"


def solve_curves(
    theta: FloatArray, eta: FloatArray, model: Contact = Contact.POINT
) -> list[StickingCurve]:
    """Solve sticking curves for pairs of taper and height.

    Parameters
    ----------
    theta, eta : ndarray, shape (n,)
        Taper factors (≥ 1) and heights of the contact point (0 < η < 1, in units of L).
    model : Contact
        POINT for contact with the tip alone, LINE for the kind of contact that is possible.

    Returns
    -------
    list of StickingCurve
        In the order of the arguments; a pair without a resolved solution is ``failed``.
    """
    theta, eta = np.asarray(theta, dtype=float), np.asarray(eta, dtype=float)
    curves: list[StickingCurve] = []
    for start in range(0, len(theta), BATCH):
        batch = slice(start, start + BATCH)
        curves += _solve_batch(theta[batch], eta[batch], model)
    return curves


def solve_keys(keys: Sequence[Sequence[float]], contact: str) -> list[StickingCurve]:
    """Solve the curves of a block; see `solve_curves`.

    Parameters
    ----------
    keys : sequence of (theta, eta)
    contact : str
        ``point`` or ``line``.

    Returns
    -------
    list of StickingCurve
    """
    theta, eta = np.array(keys, dtype=float).reshape(-1, 2).T
    return solve_curves(theta, eta, Contact(contact))


def solve_offset(
    theta: float, eta: float, offset: float, model: Contact = Contact.POINT
) -> tuple[ContactStates | None, float, Status, str]:
    """Solve one state with a prescribed offset x1 − x0 on the branch that begins at α = 0.

    Parameters
    ----------
    theta, eta : float
        Taper factor and height of the surface (L).
    offset : float
        Distance of the tip from the clamp along the surface (L).
    model : Contact
        POINT for contact with the tip alone, LINE for the kind of contact that is possible.

    Returns
    -------
    state : ContactStates or None
        A batch of one, or None if none was resolved within the model's reach.
    residual : float
        Its equilibrium residual.
    status : Status
        ``solved``, ``out_of_reach`` or ``failed``.
    message : str
        Empty, or what went wrong and what to try.
    """
    thetas, etas = np.array([theta], dtype=float), np.array([eta], dtype=float)
    message, misfit = NO_INITIAL_STATE, np.nan
    for pace in PACES:
        leg, index = begin(thetas, etas, pace, model)
        if not len(index):
            continue
        message = NOT_FOLLOWED
        way = float(leg.x1_init[0]) - offset
        # The branch is followed from α = 0 in steps no longer than those of the first leg.
        count = max(1, int(np.ceil(abs(way) / (pace.x0 * float(leg.x1_init[0])))))
        leg = replace(leg, step=np.array([way / count]))
        leg = follow(leg, etas, count, model)
        if leg.last[0] < count:
            continue
        message = NOT_RESOLVED
        contact = Contact.LINE if leg.line[-1, 0] else Contact.POINT
        closure = Closure(contact, offset=np.array([offset]))
        for nodes in NODES_ALONG_ROD:
            state, _, _ = solve(leg.steps[-1].on_nodes(nodes), etas, closure)
            misfit = float(residual(state, etas, closure)[0])
            if misfit < residual_tolerance(nodes) and coefficient_decay(state)[0] < DECAY_TOLERANCE:
                violated = violations(state, etas, contact)[0]
                if violated.any():
                    return None, misfit, Status.OUT_OF_REACH, _reasons(violated)
                return state, misfit, Status.SOLVED, ""
    return None, misfit, Status.FAILED, message


def _reasons(violated: BoolArray) -> str:
    return "; ".join(reason for reason, is_so in zip(REASONS, violated, strict=True) if is_so)


def _solve_batch(theta: FloatArray, eta: FloatArray, model: Contact) -> list[StickingCurve]:
    """Solve one batch, and follow those more closely that need it."""
    results = _solve_at_pace(theta, eta, PACES[0], model)
    for pace in PACES[1:]:
        pending = [
            i
            for i, curve in enumerate(results)
            if curve.status is Status.FAILED or curve.end is End.NOT_FOLLOWED
        ]
        if not pending:
            break
        solved = _solve_at_pace(theta[pending], eta[pending], pace, model)
        for index, curve in zip(pending, solved, strict=True):
            if curve.status is not Status.FAILED or results[index].status is Status.FAILED:
                results[index] = curve
    return results


def _solve_at_pace(
    theta: FloatArray, eta: FloatArray, pace: Pace, model: Contact
) -> list[StickingCurve]:
    """Solve curves whose legs are followed at a certain pace."""
    results = [
        failed_curve(float(t), float(e), METHOD, NO_INITIAL_STATE)
        for t, e in zip(theta, eta, strict=True)
    ]
    first, index = first_leg(theta, eta, pace, model)
    if not len(index):
        return results
    theta, eta = theta[index], eta[index]
    # What the pieces are cut at has to be exact, unlike the legs: solve it on more nodes.
    x1_init = _exact(
        *(*first.at(np.zeros(len(index), dtype=np.int64)), eta),
        lambda contact, i: Closure(contact, alpha=np.zeros(len(i))),
        lambda states, i: contact_position(states)[0],
    )
    joint = first.last * first.step
    advance = _exact(
        *(*first.at(first.last), eta),
        lambda contact, i: Closure(contact, offset=x1_init[i] - joint[i]),
        lambda states, i: parameter_of(Parameter.ADVANCE, states, x1_init[i], first.force[i]),
    )
    cuts: dict[tuple[Parameter, int], _Cuts] = {}
    solved: list[list[Resolved]] = [[] for _ in index]
    parts = _cuts(first, eta, x1_init, np.zeros(len(index)), joint)
    legs = [(np.arange(len(index)), first, parts)]
    # The second legs are followed once the first ones are solved: not of what is out of reach, nor
    # where the tip lifts off.
    while legs:
        rows, leg, parts = legs.pop(0)
        cuts |= {(leg.parameter, row): cut for row, cut in zip(rows.tolist(), parts, strict=True)}
        for contact in Contact:
            pieces = _pieces(contact, leg, parts, theta[rows], eta[rows], x1_init[rows])
            for piece in resolve(pieces, guess_from(leg, pieces)) if len(pieces) else ():
                solved[rows[piece.curve]].append(piece)
        if leg is first:
            within = [not any(np.isfinite(piece.reach) for piece in pieces) for pieces in solved]
            rows = np.flatnonzero(within & (first.at(first.last)[0].fy < 0.0))
            if len(rows):
                leg = second_leg(first.take(rows), eta[rows], model, pace)
                stop = leg.origin + leg.last * leg.step
                parts = _cuts(leg, eta[rows], x1_init[rows], advance[rows], stop)
                good = np.flatnonzero(_turned(leg) & [part is not None for part in parts])
                legs.append((rows[good], leg.take(good), [parts[row] for row in good]))
    passed = _passed(first)
    for row, i in enumerate(index):
        results[i] = _assembled(
            failed_curve(float(theta[row]), float(eta[row]), METHOD, NO_LOCK),
            float(x1_init[row]),
            bool(passed[row]),
            [cuts.get((parameter, row)) for parameter in Parameter],
            solved[row],
            model,
        )
    return results


def _passed(first: Leg) -> BoolArray:
    """Whether the first legs have found a maximum of −tan α or the tip lifting off."""
    fx, fy = first.forces
    last, rows = first.last, np.arange(len(first.x1_init))
    with np.errstate(invalid="ignore", divide="ignore"):
        demand = np.nan_to_num(fx / fy, nan=-np.inf)
    pulls = (fy[last, rows] >= 0.0) & (fx[last, rows] < 0.0)
    return pulls | (demand[last, rows] < np.maximum(demand.max(axis=0), 1e-300))


def _turned(leg: Leg) -> BoolArray:
    """Whether the legs have passed the end of stability."""
    last, rows = leg.last, np.arange(len(leg.x1_init))
    offsets = np.stack([contact_position(states)[0] for states in leg.steps])
    back = (last >= 2) & (offsets[last, rows] > offsets[np.maximum(last - 1, 0), rows])
    states, line = leg.at(last)
    for contact, kind in ((Contact.POINT, ~line), (Contact.LINE, line)):
        lost = np.flatnonzero(kind & ~back & (last >= 2))
        if len(lost):
            back[lost] = stability(states.take(lost), contact) < 0.0
    return back


def _exact(
    states: ContactStates,
    line: BoolArray,
    eta: FloatArray,
    closure: Callable[[Contact, IntArray], Closure],
    measure: Callable[[ContactStates, IntArray], FloatArray],
) -> FloatArray:
    """Measure states on as many nodes as they need; NaN where there never are enough."""
    measured = np.full(len(states), np.nan)
    for contact, kind in ((Contact.POINT, ~line), (Contact.LINE, line)):
        rows = np.flatnonzero(kind)
        guess = states.take(rows)
        for nodes in NODES_ALONG_ROD:
            if not len(rows):
                break
            conditions = closure(contact, rows)
            solution, _, _ = solve(guess.on_nodes(nodes), eta[rows], conditions)
            good = (residual(solution, eta[rows], conditions) < residual_tolerance(nodes)) & (
                coefficient_decay(solution) < DECAY_TOLERANCE
            )
            measured[rows[good]] = measure(solution.take(good), rows[good])
            rows, guess = rows[~good], guess.take(~good)
    return measured


# First and last value of the parameter of each piece, and whether it is in line contact; None where
# the pieces are not known.
_Cuts = list[tuple[float, float, bool]] | None


def _cuts(
    leg: Leg, eta: FloatArray, x1_init: FloatArray, start: FloatArray, stop: FloatArray
) -> list[_Cuts]:
    """Cut legs where the contact changes its kind."""
    inner: list[list[float] | None] = [[] for _ in eta]
    last = leg.last
    for k in range(len(leg.steps) - 1):
        changing = np.flatnonzero((leg.line[k] != leg.line[k + 1]) & (k < last))
        switches = _switches(leg, k, changing, eta, x1_init)
        for curve, at in zip(changing.tolist(), switches, strict=True):
            known = inner[curve]
            # Legs are followed on fewer nodes than the switches are solved on.
            place = (at - leg.origin[curve]) / leg.step[curve]
            if known is not None:
                inner[curve] = [*known, float(at)] if k - 0.1 <= place <= k + 1.1 else None
    cuts: list[_Cuts] = []
    for curve, values in enumerate(inner):
        low, high = float(start[curve]), float(stop[curve])
        if values is None or not np.isfinite([low, high]).all() or last[curve] < 2:
            cuts.append(None)
            continue
        bounds = [low, *(min(max(value, low), high) for value in values), high]
        first = bool(leg.line[0, curve])
        parts = [(a, b, first ^ bool(i % 2)) for i, (a, b) in enumerate(pairwise(bounds))]
        cuts.append([part for part in parts if part[0] < part[1]])
    return cuts


def _switches(
    leg: Leg, k: int, changing: IntArray, eta: FloatArray, x1_init: FloatArray
) -> FloatArray:
    """Parameter at which the contact of some branches changes between step k and the next."""
    # From the side on which the tip alone touches.
    side = np.where(leg.line[k], k + 1, k)
    guess = switch_states(leg.at(side)[0].take(changing), eta[changing])

    def parameter(states: ContactStates, i: IntArray) -> FloatArray:
        rows = changing[i]
        return parameter_of(leg.parameter, states, x1_init[rows], leg.force[rows])

    point = np.zeros(len(changing), dtype=bool)
    return _exact(guess, point, eta[changing], lambda contact, i: Closure(), parameter)


def _pieces(
    contact: Contact,
    leg: Leg,
    cuts: list[_Cuts],
    theta: FloatArray,
    eta: FloatArray,
    x1_init: FloatArray,
) -> Pieces:
    """Pieces of a leg that have one kind of contact."""
    found = [
        (curve, start, stop)
        for curve, parts in enumerate(cuts)
        for start, stop, line in parts or ()
        if line == (contact is Contact.LINE)
    ]
    curves = np.array([piece[0] for piece in found], dtype=np.int64)
    start, stop = np.array([piece[1:] for piece in found], dtype=float).reshape(-1, 2).T
    return Pieces(
        contact,
        leg.parameter,
        curves,
        theta[curves],
        eta[curves],
        x1_init[curves],
        leg.force[curves],
        start,
        stop - start,
    )


def _assembled(
    failed: StickingCurve,
    x1_init: float,
    passed: bool,
    cuts: list[_Cuts],
    solved: list[Resolved],
    model: Contact,
) -> StickingCurve:
    """Put the resolved pieces of one curve together and find where it ends."""
    if not passed:
        return failed
    if cuts[0] is None:
        return replace(failed, message=NO_SWITCH if np.isfinite(x1_init) else NOT_RESOLVED)
    parts: list[list[Resolved]] = []
    for parameter, bounds in zip(Parameter, cuts, strict=True):
        pieces = sorted((p for p in solved if p.parameter is parameter), key=lambda p: p.start)
        whole = sum(stop - start for start, stop, _ in bounds or ())
        covered = sum(piece.stop - piece.start for piece in pieces)
        parts.append(pieces if covered > whole * (1.0 - 1e-9) else [])
    if not parts[0]:
        return replace(failed, message=NOT_RESOLVED)
    every = [Piece(p.contact, p.parameter, p.start, p.stop, p.values) for p in parts[0] + parts[1]]
    curve = sticking_curve(
        failed.theta,
        failed.eta,
        METHOD,
        x1_init,
        every,
        max(piece.residual for piece in parts[0] + parts[1]),
        [(piece.reach, _reasons(piece.violated)) for piece in parts[0] + parts[1]],
        NO_END,
    )
    if model is Contact.LINE and not all(map(_possible, curve.pieces)):
        return replace(failed, message=NO_SWITCH)
    return curve


def _possible(piece: Piece) -> bool:
    """Whether a piece has nowhere the other kind of contact than it was cut out for."""
    _, _, _, _, phi1, s_c, _ = piece.scan[1].T
    slack = 1e-9
    if piece.contact is Contact.POINT:
        return bool(phi1.min() >= -slack)
    return bool(s_c.max() <= 1.0 + slack and s_c.min() > 0.0)
