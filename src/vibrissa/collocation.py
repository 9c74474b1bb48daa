"""Sticking curves by spectral collocation: batches of (θ, η), refined until they are resolved.

A curve is solved in three stages, each for the whole batch at once: the α = 0 state; a coarse
march along x0 until −tan α has passed its maximum, which says how long the curve is and where the
contact changes its kind; the states at Chebyshev points of each piece between such changes, as a
curve is smooth only there. The number of nodes along the rod and of states along a piece grows
until the residual between the nodes and the decay of both series are below the tolerance.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields
from itertools import pairwise
from typing import Any, Self

import numpy as np

from vibrissa.arrays import FloatArray, Index, IntArray
from vibrissa.branch import Branch, begin, follow, switch_states
from vibrissa.curve import Piece, StickingCurve, failed_curve, sticking_curve
from vibrissa.equilibrium import (
    Closure,
    ContactStates,
    clamp_moment,
    coefficient_decay,
    contact_slope,
    integral_operator,
    residual,
    solve,
)
from vibrissa.spectral import chebyshev_nodes, chebyshev_transform
from vibrissa.status import Contact, Status

METHOD = "collocation"
RESIDUAL_TOLERANCE = 1e-12
# Bound on the last coefficients of both series relative to the largest.
DECAY_TOLERANCE = 1e-12
NODES_ALONG_ROD = (32, 48, 72, 108, 162)
STATES_ALONG_CURVE = (17, 33, 65, 129)
# Step of the march and its limit, relative to x1_init: at 1 the clamp stands under the contact.
MARCH_STEP = 0.05
MARCH_LIMIT = 2.0
# The curve reaches this much further than the estimated lock, so that the maximum lies inside.
BEYOND_LOCK = 1.1
# Curves that are solved together: bounds the memory and stays in the processor's cache.
BATCH = 16

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
    f"the rod and {STATES_ALONG_CURVE[-1]} states along the curve; try an eta between 0.3 and "
    "0.9999 and a theta up to 20"
)


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
) -> tuple[ContactStates | None, float, str]:
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
        A batch of one, or None if none was resolved.
    residual : float
        Its equilibrium residual.
    message : str
        Empty, or what went wrong and what to try.
    """
    thetas, etas = np.array([theta], dtype=float), np.array([eta], dtype=float)
    message, misfit = NO_INITIAL_STATE, np.nan
    for nodes in NODES_ALONG_ROD:
        branch, index = begin(thetas, etas, nodes, model)
        if not len(index):
            continue
        message = NOT_FOLLOWED
        way = float(branch.x1_init[0]) - offset
        # The branch is followed from α = 0 in steps no longer than the march's.
        count = max(1, int(np.ceil(abs(way) / (MARCH_STEP * float(branch.x1_init[0])))))
        operator = integral_operator(thetas, nodes)
        branch = follow(branch, etas, np.array([way / count]), count, model, operator, False)
        state = branch.steps[-1]
        if len(branch.steps) <= count or np.isnan(state.fx[0]):
            continue
        message = NOT_RESOLVED
        contact = Contact.LINE if branch.line[-1, 0] else Contact.POINT
        misfit = float(residual(state, etas, Closure(contact, offset=np.array([offset])))[0])
        if misfit < RESIDUAL_TOLERANCE and coefficient_decay(state)[0] < DECAY_TOLERANCE:
            return state, misfit, ""
    return None, misfit, message


def _solve_batch(theta: FloatArray, eta: FloatArray, model: Contact) -> list[StickingCurve]:
    """Solve one batch, with more nodes along the rod for those that need them."""
    results = _solve_on_nodes(theta, eta, NODES_ALONG_ROD[0], model)
    for nodes in NODES_ALONG_ROD[1:]:
        pending = [i for i, curve in enumerate(results) if curve.status is Status.FAILED]
        if not pending:
            break
        solved = _solve_on_nodes(theta[pending], eta[pending], nodes, model)
        for index, curve in zip(pending, solved, strict=True):
            results[index] = curve
    return results


@dataclass(frozen=True, eq=False)
class _Pieces:
    """Smooth pieces of a batch of curves, all with the same kind of contact.

    Attributes
    ----------
    curve : ndarray of int, shape (n,)
        Which curve of the batch a piece belongs to.
    theta, eta, x1_init : ndarray, shape (n,)
        Of that curve.
    start, length : ndarray, shape (n,)
        First displacement of the piece and how far it goes (L).
    operator : ndarray, shape (n, nodes, nodes)
        `integral_operator` of the curve's rod in point contact.
    """

    contact: Contact
    curve: IntArray
    theta: FloatArray
    eta: FloatArray
    x1_init: FloatArray
    start: FloatArray
    length: FloatArray
    operator: FloatArray

    def take(self, index: Index) -> Self:
        """Select pieces."""
        return type(self)(self.contact, *(getattr(self, f.name)[index] for f in fields(self)[1:]))

    def displacement(self, position: FloatArray) -> FloatArray:
        """Displacements at fractions of the pieces' length, shape (positions, n)."""
        return self.start + position[:, None] * self.length


@dataclass(frozen=True, eq=False)
class _Path:
    """States along a batch of pieces: the first axis counts states, the second pieces."""

    theta: FloatArray
    phi: FloatArray
    fx: FloatArray
    fy: FloatArray
    s_c: FloatArray

    @classmethod
    def stacked(cls, states: list[ContactStates]) -> Self:
        names = ("phi", "fx", "fy", "s_c")
        return cls(states[0].theta, *(np.stack([getattr(s, n) for s in states]) for n in names))

    def flat(self) -> ContactStates:
        """All states of all pieces as one batch."""
        count = len(self.fx)
        return ContactStates(
            np.tile(self.theta, count),
            self.phi.reshape(-1, self.phi.shape[-1]),
            self.fx.ravel(),
            self.fy.ravel(),
            self.s_c.ravel(),
        )

    @classmethod
    def unflattened(cls, states: ContactStates, count: int) -> Self:
        """Inverse of `flat` for `count` states along each piece."""
        pieces = len(states) // count
        return cls(
            states.theta[:pieces],
            states.phi.reshape(count, pieces, -1),
            states.fx.reshape(count, pieces),
            states.fy.reshape(count, pieces),
            states.s_c.reshape(count, pieces),
        )

    def pieces(self, index: Index) -> Self:
        """Select pieces."""
        return type(self)(
            self.theta[index],
            *(values[:, index] for values in (self.phi, self.fx, self.fy, self.s_c)),
        )

    def combined(self, matrix: FloatArray) -> Self:
        """Linear combinations of the states; `matrix` is (new, old) or (pieces, new, old)."""
        if matrix.ndim == 2:
            matrix = np.broadcast_to(matrix, (len(self.theta), *matrix.shape))
        return type(self)(
            self.theta,
            np.einsum("cab,bcn->acn", matrix, self.phi, optimize=True),
            *(np.einsum("cab,bc->ac", matrix, v) for v in (self.fx, self.fy, self.s_c)),
        )


def _solve_on_nodes(
    theta: FloatArray, eta: FloatArray, nodes: int, model: Contact
) -> list[StickingCurve]:
    """Solve curves on a fixed number of nodes along the rod."""

    def failure(i: int | np.integer[Any], message: str) -> StickingCurve:
        return failed_curve(float(theta[i]), float(eta[i]), METHOD, message)

    branch, index = begin(theta, eta, nodes, model)
    results = [failure(i, NO_INITIAL_STATE) for i in range(len(theta))]
    operator = integral_operator(theta[index], nodes)
    step = MARCH_STEP * branch.x1_init
    # With the tip alone −tan α rises to one maximum. Where the contact changes it has kinks, so the
    # whole branch is searched for its largest value.
    count, stop = round(MARCH_LIMIT / MARCH_STEP), model is Contact.POINT
    branch = follow(branch, eta[index], step, count, model, operator, stop_at_lock=stop)
    end = _estimated_end(branch) * step
    switches = _switches(branch, eta[index], step, end)
    solved: list[list[tuple[Piece, float]]] = [[] for _ in index]
    expected = np.zeros(len(index), dtype=int)
    for contact in (Contact.POINT, Contact.LINE):
        pieces = _pieces(contact, branch, switches, end, theta[index], eta[index], operator)
        expected += np.bincount(pieces.curve, minlength=len(index))
        for curve, piece, misfit in _resolve(pieces, branch, step):
            solved[curve].append((piece, misfit))

    for row, i in enumerate(index):
        if np.isnan(end[row]):
            results[i] = failure(i, NO_LOCK)
        elif switches[row] is None:
            results[i] = failure(i, NO_SWITCH)
        elif len(solved[row]) < expected[row]:
            results[i] = failure(i, NOT_RESOLVED)
        elif not all(_possible(piece, model) for piece, _ in solved[row]):
            results[i] = failure(i, NO_SWITCH)
        else:
            parts = sorted(solved[row], key=lambda part: part[0].x0[0])
            results[i] = sticking_curve(
                float(theta[i]),
                float(eta[i]),
                METHOD,
                float(branch.x1_init[row]),
                [piece for piece, _ in parts],
                max(misfit for _, misfit in parts),
            )
    return results


def _estimated_end(branch: Branch) -> FloatArray:
    """Count steps to a little beyond the maximum of −tan α; NaN where there is none inside."""
    fx, fy = (np.stack([getattr(s, name) for s in branch.steps]) for name in ("fx", "fy"))
    # From where the surface would have to pull, −tan α has no meaning.
    pulls = (fy >= 0.0) & (fx < 0.0)
    demand = np.where(pulls, -np.inf, fx / fy)
    last = np.isfinite(fy).sum(axis=0) - 1
    top = np.argmax(np.nan_to_num(demand, nan=-np.inf), axis=0)
    inside = (top >= 1) & (top < last)
    curves = np.arange(len(top))
    before, at, after = (demand[np.clip(top + k, 0, len(demand) - 1), curves] for k in (-1, 0, 1))
    with np.errstate(invalid="ignore", divide="ignore"):
        vertex = top + 0.5 * (before - after) / (before - 2.0 * at + after)
    end = np.where(inside, np.minimum(BEYOND_LOCK * vertex + 0.1, last), np.nan)
    # The tip lifts off between two steps: the curve ends with the later one.
    return np.where(pulls.any(axis=0), np.argmax(pulls, axis=0), end)


def _switches(
    branch: Branch, eta: FloatArray, step: FloatArray, end: FloatArray
) -> list[list[float] | None]:
    """Displacements at which the contact changes its kind; None where one was not found."""
    switches: list[list[float] | None] = [[] for _ in end]
    for k in range(len(branch.steps) - 1):
        changing = np.flatnonzero(
            (branch.line[k] != branch.line[k + 1])
            & np.isfinite(branch.steps[k + 1].fx)
            & (k * step < end)
        )
        if not len(changing):
            continue
        # From the side on which the tip alone touches.
        side = np.where(branch.line[k, changing], k + 1, k)
        path = _Path.stacked([branch.steps[k], branch.steps[k + 1]]).pieces(changing)
        matrix = np.zeros((len(changing), 1, 2))
        np.put_along_axis(matrix, (side - k)[:, None, None], 1.0, axis=2)
        _, offset = switch_states(path.combined(matrix).flat(), eta[changing])
        displacement = branch.x1_init[changing] - offset
        for curve, x0 in zip(changing, displacement, strict=True):
            known = switches[curve]
            slack = 1e-9 * step[curve]
            inside = k * step[curve] - slack <= x0 <= (k + 1) * step[curve] + slack
            if known is not None:
                switches[curve] = [*known, float(x0)] if inside else None
    return switches


def _pieces(
    contact: Contact,
    branch: Branch,
    switches: list[list[float] | None],
    end: FloatArray,
    theta: FloatArray,
    eta: FloatArray,
    operator: FloatArray,
) -> _Pieces:
    """Cut the curves at their switches and take the pieces with one kind of contact."""
    found: list[tuple[int, float, float]] = []
    for curve, inner in enumerate(switches):
        if inner is None or np.isnan(end[curve]):
            continue
        bounds = [0.0, *(x0 for x0 in inner if 0.0 < x0 < end[curve]), float(end[curve])]
        line = bool(branch.line[0, curve])
        for first, last in pairwise(bounds):
            if line == (contact is Contact.LINE):
                found.append((curve, first, last))
            line = not line
    curves = np.array([piece[0] for piece in found], dtype=np.int64)
    start, stop = np.array([piece[1:] for piece in found]).reshape(-1, 2).T
    return _Pieces(
        contact,
        curves,
        theta[curves],
        eta[curves],
        branch.x1_init[curves],
        start,
        stop - start,
        operator[curves],
    )


def _resolve(
    pieces: _Pieces, branch: Branch, step: FloatArray
) -> Iterator[tuple[int, Piece, float]]:
    """Solve pieces with more and more states; yields those that are resolved, with residuals."""
    path = None
    for count in STATES_ALONG_CURVE:
        if not len(pieces.curve):
            return
        if path is None:
            position = chebyshev_nodes(count)
            path = _solve_at(_guess(pieces, branch, step, position), pieces, position)
        else:
            path = _refined(path, pieces)
        at_states, between = _path_residuals(path, pieces)
        decays = coefficient_decay(path.flat()).reshape(count, -1).max(axis=0)
        rod_resolved = (at_states < RESIDUAL_TOLERANCE) & (decays < DECAY_TOLERANCE)
        values = _curve_values(path)
        resolved = (
            rod_resolved & (between < RESIDUAL_TOLERANCE) & (_curve_decay(values) < DECAY_TOLERANCE)
        )
        displacement = pieces.displacement(chebyshev_nodes(count))
        for row in np.flatnonzero(resolved):
            piece = Piece(pieces.contact, displacement[:, row], values[:, row])
            yield int(pieces.curve[row]), piece, float(max(at_states[row], between[row]))
        # More states along the piece help only where the rod itself is resolved.
        remaining = rod_resolved & ~resolved
        path, pieces = path.pieces(remaining), pieces.take(remaining)


def _guess(pieces: _Pieces, branch: Branch, step: FloatArray, position: FloatArray) -> _Path:
    """Guess states along pieces by quadratics through the three nearest steps of the march."""
    march = _Path.stacked(branch.steps).pieces(pieces.curve)
    place = pieces.displacement(position).T / step[pieces.curve, None]
    last = np.isfinite(march.fx).sum(axis=0) - 1
    first = np.clip(np.round(place).astype(int) - 1, 0, last[:, None] - 2)
    t = place - first
    weights = np.stack([0.5 * (t - 1) * (t - 2), -t * (t - 2), 0.5 * t * (t - 1)], axis=-1)
    matrix = np.zeros((*place.shape, len(march.fx)))
    np.put_along_axis(matrix, first[..., None] + np.arange(3), weights, axis=-1)
    # NaN times a weight of zero would spoil the sums
    columns = (march.phi, march.fx, march.fy, march.s_c)
    return _Path(march.theta, *(np.nan_to_num(a) for a in columns)).combined(matrix)


def _refined(coarse: _Path, pieces: _Pieces) -> _Path:
    """Solve the states between those of a coarser path and keep the ones it has."""
    count = 2 * len(coarse.fx) - 1
    between = chebyshev_nodes(count)[1::2]
    guess = coarse.combined(_chebyshev_interpolation(len(coarse.fx), between))
    new = _solve_at(guess, pieces, between)

    def interleaved(old: FloatArray, new: FloatArray) -> FloatArray:
        both = np.empty((count, *old.shape[1:]))
        both[::2], both[1::2] = old, new
        return both

    names = ("phi", "fx", "fy", "s_c")
    columns = (interleaved(getattr(coarse, name), getattr(new, name)) for name in names)
    return _Path(coarse.theta, *columns)


def _closure(pieces: _Pieces, position: FloatArray) -> Closure:
    """Offsets at fractions of the pieces' length, as one batch."""
    offset = pieces.x1_init - pieces.displacement(position)
    return Closure(pieces.contact, offset=offset.ravel())


def _solve_at(guess: _Path, pieces: _Pieces, position: FloatArray) -> _Path:
    """Solve states at fractions of the pieces' length."""
    count = len(position)
    operator = None
    if pieces.contact is Contact.POINT:
        operator = np.tile(pieces.operator, (count, 1, 1))
    closure = _closure(pieces, position)
    states, _ = solve(guess.flat(), np.tile(pieces.eta, count), closure, operator)
    return _Path.unflattened(states, count)


def _chebyshev_interpolation(count: int, position: FloatArray) -> FloatArray:
    """Matrix from values at `count` Chebyshev points on [0, 1] to values at `position`.

    The barycentric formula: its rounding does not grow with the number of points. No position may
    be one of them.
    """
    weights = (-1.0) ** np.arange(count)
    weights[[0, -1]] *= 0.5
    matrix = weights / (position[:, None] - chebyshev_nodes(count))
    return matrix / matrix.sum(axis=1, keepdims=True)


def _path_residuals(path: _Path, pieces: _Pieces) -> tuple[FloatArray, FloatArray]:
    """Largest residual of each piece at its states, and interpolated half-way between them."""
    count = len(path.fx)
    middle = chebyshev_nodes(2 * count - 1)[1::2]
    halfway = path.combined(_chebyshev_interpolation(count, middle))

    def largest(path: _Path, position: FloatArray) -> FloatArray:
        misfit = residual(
            path.flat(), np.tile(pieces.eta, len(position)), _closure(pieces, position)
        )
        # NaN marks a state that was not found
        return np.nan_to_num(misfit, nan=np.inf).reshape(len(position), -1).max(axis=0)

    return largest(path, chebyshev_nodes(count)), largest(halfway, middle)


def _curve_values(path: _Path) -> FloatArray:
    """fx, fy, m, φ1 and s_c at the states, shape (states, pieces, 5)."""
    states = path.flat()
    values = [states.fx, states.fy, clamp_moment(states), contact_slope(states), states.s_c]
    return np.stack(values, axis=-1).reshape(*path.fx.shape, 5)


def _curve_decay(values: FloatArray) -> FloatArray:
    """Size of the last Chebyshev coefficients along the pieces relative to the largest."""
    transform = chebyshev_transform(len(values))
    coefficients = np.abs(np.einsum("ab,bcv->acv", transform, values))
    # On a short piece a column may be nearly zero: fx and m are judged by the size of the force,
    # an angle or a length by its absolute size.
    largest = coefficients.max(axis=0)
    force = largest[:, [1]]
    scale = np.maximum(largest, np.hstack([force, force, force, *np.ones((2, *force.shape))]))
    return (coefficients[-2:].max(axis=0) / scale).max(axis=-1)


def _possible(piece: Piece, model: Contact) -> bool:
    """Whether a piece has nowhere the other kind of contact than it was cut out for."""
    if model is Contact.POINT:
        return True
    x0 = np.linspace(piece.x0[0], piece.x0[-1], 257)
    _, _, _, phi1, s_c = piece.evaluate(x0).T
    slack = 1e-9
    if piece.contact is Contact.POINT:
        return bool(phi1.min() >= -slack)
    return bool(s_c.max() <= 1.0 + slack and s_c.min() > 0.0)
