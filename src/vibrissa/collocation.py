"""Sticking curves by spectral collocation: batches of (θ, η), refined until they are resolved.

A curve is solved in three stages, each for the whole batch at once: the α = 0 state; a coarse
march along x0 until −tan α has passed its maximum, which says how long the curve is; the states
at Chebyshev points of that length. The number of nodes along the rod and of states along the
curve grows until the residual between the nodes and the decay of both series are below the
tolerance.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.polynomial import chebyshev

from vibrissa.arrays import BoolArray, FloatArray
from vibrissa.buckling import initial_states
from vibrissa.curve import StickingCurve, failed_curve, sticking_curve
from vibrissa.equilibrium import (
    Closure,
    TipStates,
    clamp_moment,
    coefficient_decay,
    integral_operator,
    residual,
    solve,
    tip_position,
    tip_slope,
)
from vibrissa.spectral import chebyshev_nodes, chebyshev_transform
from vibrissa.status import Status

METHOD = "collocation"
RESIDUAL_TOLERANCE = 1e-12
# Bound on the last coefficients of both series relative to the largest.
DECAY_TOLERANCE = 1e-12
NODES_ALONG_ROD = (32, 48, 72, 108, 162)
STATES_ALONG_CURVE = (17, 33, 65, 129)
# Step of the march and its limit, relative to x1_init: at 1 the clamp stands under the contact.
MARCH_STEP = 0.05
MARCH_LIMIT = 1.5
# The curve reaches this much further than the estimated lock, so that the maximum lies inside.
BEYOND_LOCK = 1.1
# Curves that are solved together: bounds the memory and stays in the processor's cache.
BATCH = 16

NO_INITIAL_STATE = (
    "no first-mode state with alpha = 0 found; bring eta closer to 1 or theta closer to 1"
)
NO_LOCK = (
    "the march along x0 ended before -tan(alpha) had a maximum; bring eta closer to 1 or theta "
    "closer to 1"
)
NOT_FOLLOWED = (
    "the branch that begins at alpha = 0 could not be followed to this offset; it may end before"
)
NOT_RESOLVED = (
    f"residual or series decay above {RESIDUAL_TOLERANCE:g} with {NODES_ALONG_ROD[-1]} nodes along "
    f"the rod and {STATES_ALONG_CURVE[-1]} states along the curve; bring eta or theta closer to 1"
)


def solve_curves(theta: FloatArray, eta: FloatArray) -> list[StickingCurve]:
    """Solve sticking curves for pairs of taper and height.

    Parameters
    ----------
    theta, eta : ndarray, shape (n,)
        Taper factors (≥ 1) and heights of the contact point (0 < η < 1, in units of L).

    Returns
    -------
    list of StickingCurve
        In the order of the arguments; a pair without a resolved solution is ``failed``.
    """
    theta, eta = np.asarray(theta, dtype=float), np.asarray(eta, dtype=float)
    curves: list[StickingCurve] = []
    for start in range(0, len(theta), BATCH):
        batch = slice(start, start + BATCH)
        curves += _solve_batch(theta[batch], eta[batch])
    return curves


def solve_keys(keys: Sequence[Sequence[float]]) -> list[StickingCurve]:
    """Solve the curves of a block; see `solve_curves`.

    Parameters
    ----------
    keys : sequence of (theta, eta)

    Returns
    -------
    list of StickingCurve
    """
    theta, eta = np.array(keys, dtype=float).reshape(-1, 2).T
    return solve_curves(theta, eta)


def solve_offset(theta: float, eta: float, offset: float) -> tuple[TipStates | None, float, str]:
    """Solve one state with a prescribed offset x1 − x0 on the branch that begins at α = 0.

    Parameters
    ----------
    theta, eta : float
        Taper factor and height of the contact point (L).
    offset : float
        Distance of the contact point from the clamp along the surface (L).

    Returns
    -------
    state : TipStates or None
        A batch of one, or None if none was resolved.
    residual : float
        Its equilibrium residual.
    message : str
        Empty, or what went wrong and what to try.
    """
    thetas, etas = np.array([theta], dtype=float), np.array([eta], dtype=float)
    message, misfit = NO_INITIAL_STATE, np.nan
    for nodes in NODES_ALONG_ROD:
        state, found = initial_states(thetas, etas, nodes)
        if not found[0]:
            continue
        message = NOT_FOLLOWED
        x1_init = tip_position(state)[0][0]
        # The branch is followed from α = 0 in steps as small as the march's.
        count = max(1, int(np.ceil(abs(offset / x1_init - 1.0) / MARCH_STEP)))
        steps = [state]
        for target in np.linspace(x1_init, offset, count + 1)[1:]:
            closure = Closure(offset=np.array([target]))
            state, found = solve(_extrapolated(steps[-3:]), etas, closure)
            if not found[0]:
                break
            steps.append(state)
        else:
            message = NOT_RESOLVED
            misfit = float(residual(state, etas, closure)[0])
            if misfit < RESIDUAL_TOLERANCE and coefficient_decay(state)[0] < DECAY_TOLERANCE:
                return state, misfit, ""
    return None, misfit, message


def _solve_batch(theta: FloatArray, eta: FloatArray) -> list[StickingCurve]:
    """Solve one batch, with more nodes along the rod for those that need them."""
    results = _solve_on_nodes(theta, eta, NODES_ALONG_ROD[0])
    for nodes in NODES_ALONG_ROD[1:]:
        pending = [i for i, curve in enumerate(results) if curve.status is Status.FAILED]
        if not pending:
            break
        solved = _solve_on_nodes(theta[pending], eta[pending], nodes)
        for index, curve in zip(pending, solved, strict=True):
            results[index] = curve
    return results


@dataclass(frozen=True)
class _Path:
    """States along a batch of curves: the first axis counts states, the second curves."""

    theta: FloatArray
    phi: FloatArray
    fx: FloatArray
    fy: FloatArray

    @classmethod
    def stacked(cls, states: list[TipStates]) -> Self:
        return cls(
            states[0].theta,
            np.stack([s.phi for s in states]),
            np.stack([s.fx for s in states]),
            np.stack([s.fy for s in states]),
        )

    def flat(self) -> TipStates:
        """All states of all curves as one batch."""
        count = len(self.fx)
        return TipStates(
            np.tile(self.theta, count),
            self.phi.reshape(-1, self.phi.shape[-1]),
            self.fx.ravel(),
            self.fy.ravel(),
        )

    @classmethod
    def unflattened(cls, states: TipStates, count: int) -> Self:
        """Inverse of `flat` for `count` states along each curve."""
        curves = len(states) // count
        return cls(
            states.theta[:curves],
            states.phi.reshape(count, curves, -1),
            states.fx.reshape(count, curves),
            states.fy.reshape(count, curves),
        )

    def curves(self, mask: BoolArray) -> Self:
        """Select curves."""
        return type(self)(self.theta[mask], self.phi[:, mask], self.fx[:, mask], self.fy[:, mask])

    def combined(self, matrix: FloatArray) -> Self:
        """Linear combinations of the states; `matrix` is (new, old) or (curves, new, old)."""
        if matrix.ndim == 2:
            matrix = np.broadcast_to(matrix, (len(self.theta), *matrix.shape))
        return type(self)(
            self.theta,
            np.einsum("cab,bcn->acn", matrix, self.phi, optimize=True),
            np.einsum("cab,bc->ac", matrix, self.fx),
            np.einsum("cab,bc->ac", matrix, self.fy),
        )


def _solve_on_nodes(theta: FloatArray, eta: FloatArray, nodes: int) -> list[StickingCurve]:
    """Solve curves on a fixed number of nodes along the rod."""

    def failure(i: int | np.integer[Any], message: str) -> StickingCurve:
        return failed_curve(float(theta[i]), float(eta[i]), METHOD, message)

    initial, found = initial_states(theta, eta, nodes)
    results = [failure(i, NO_INITIAL_STATE) for i in range(len(theta))]
    index = np.flatnonzero(found)
    operator = integral_operator(theta[index], nodes)
    x1_init, _ = tip_position(initial.take(index))
    march = _march_to_lock(initial.take(index), eta[index], x1_init, operator)
    end = _estimated_end(march, x1_init)
    for i in index[np.isnan(end)]:
        results[i] = failure(i, NO_LOCK)

    path = None
    remaining = np.isfinite(end)
    for count in STATES_ALONG_CURVE:
        march = march.curves(remaining)
        index, x1_init, end = index[remaining], x1_init[remaining], end[remaining]
        operator = operator[remaining]
        if not len(index):
            break
        if path is None:
            guess = _interpolated_march(march, end / (x1_init * MARCH_STEP), count)
            path = _solve_path(guess, eta[index], x1_init, end, operator)
        else:
            path = _refined(path.curves(remaining), eta[index], x1_init, end, operator)
        at_states, between = _path_residuals(path, eta[index], x1_init, end)
        decays = coefficient_decay(path.flat()).reshape(count, -1).max(axis=0)
        rod_resolved = (at_states < RESIDUAL_TOLERANCE) & (decays < DECAY_TOLERANCE)
        values = _curve_values(path)
        resolved = (
            rod_resolved & (between < RESIDUAL_TOLERANCE) & (_curve_decay(values) < DECAY_TOLERANCE)
        )
        for row, i in enumerate(index):
            if resolved[row]:
                results[i] = sticking_curve(
                    float(theta[i]),
                    float(eta[i]),
                    METHOD,
                    float(x1_init[row]),
                    end[row] * chebyshev_nodes(count),
                    values[:, row],
                    float(max(at_states[row], between[row])),
                )
            else:
                results[i] = failure(i, NOT_RESOLVED)
        # More states along the curve help only where the rod itself is resolved.
        remaining = rod_resolved & ~resolved
    return results


def _march_to_lock(
    initial: TipStates, eta: FloatArray, x1_init: FloatArray, operator: FloatArray
) -> _Path:
    """Follow curves from α = 0 in equal steps until −tan α has passed its maximum.

    A curve has NaN states after the one that passed, or from where Newton's iteration failed.
    """
    steps = [initial]
    active = np.arange(len(initial))
    while len(active) and len(steps) <= round(MARCH_LIMIT / MARCH_STEP):
        guess = _extrapolated([s.take(active) for s in steps[-3:]])
        offset = x1_init[active] * (1.0 - len(steps) * MARCH_STEP)
        solution, converged = solve(guess, eta[active], Closure(offset=offset), operator[active])
        state = TipStates(
            initial.theta, *(np.full_like(a, np.nan) for a in (initial.phi, initial.fx, initial.fy))
        )
        state.put(active, solution)
        steps.append(state)
        demand, before = (s.fx[active] / s.fy[active] for s in (steps[-1], steps[-2]))
        active = active[converged & ~(demand < before)]
    return _Path.stacked(steps)


def _extrapolated(last: list[TipStates]) -> TipStates:
    """Polynomial extrapolation by one step from up to three equally spaced states."""
    weights = {1: (1.0,), 2: (-1.0, 2.0), 3: (1.0, -3.0, 3.0)}[len(last)]
    path = _Path.stacked(last).combined(np.array([weights]))
    return path.flat()


def _estimated_end(march: _Path, x1_init: FloatArray) -> FloatArray:
    """Displacement a little beyond the maximum of −tan α; NaN where the march found none."""
    demand = march.fx / march.fy
    last = np.isfinite(demand).sum(axis=0) - 1
    curves = np.arange(len(last))
    before, top, after = (demand[np.maximum(last - k, 0), curves] for k in (2, 1, 0))
    passed = (last >= 2) & (after < top)
    with np.errstate(invalid="ignore", divide="ignore"):
        vertex = 0.5 * (before - after) / (before - 2.0 * top + after)
    return np.where(passed, BEYOND_LOCK * x1_init * MARCH_STEP * (last - 1 + vertex), np.nan)


def _interpolated_march(march: _Path, end: FloatArray, count: int) -> _Path:
    """Guess at Chebyshev points on [0, end], in march steps, by quadratics through the march."""
    position = end[:, None] * chebyshev_nodes(count)
    last = np.isfinite(march.fx).sum(axis=0) - 1
    first = np.clip(np.round(position).astype(int) - 1, 0, last[:, None] - 2)
    t = position - first
    weights = np.stack([0.5 * (t - 1) * (t - 2), -t * (t - 2), 0.5 * t * (t - 1)], axis=-1)
    matrix = np.zeros((*position.shape, len(march.fx)))
    np.put_along_axis(matrix, first[..., None] + np.arange(3), weights, axis=-1)
    # NaN times a weight of zero would spoil the sums
    known = _Path(march.theta, *(np.nan_to_num(a) for a in (march.phi, march.fx, march.fy)))
    return known.combined(matrix)


def _solve_path(
    guess: _Path, eta: FloatArray, x1_init: FloatArray, end: FloatArray, operator: FloatArray
) -> _Path:
    """Solve the states at the Chebyshev points of each curve."""
    count = len(guess.fx)
    return _solve_at(guess, chebyshev_nodes(count), eta, x1_init, end, operator)


def _refined(
    coarse: _Path, eta: FloatArray, x1_init: FloatArray, end: FloatArray, operator: FloatArray
) -> _Path:
    """Solve the states between those of a coarser path and keep the ones it has."""
    count = 2 * len(coarse.fx) - 1
    between = chebyshev_nodes(count)[1::2]
    guess = coarse.combined(_chebyshev_interpolation(len(coarse.fx), between))
    new = _solve_at(guess, between, eta, x1_init, end, operator)

    def interleaved(old: FloatArray, new: FloatArray) -> FloatArray:
        both = np.empty((count, *old.shape[1:]))
        both[::2], both[1::2] = old, new
        return both

    return _Path(
        coarse.theta,
        interleaved(coarse.phi, new.phi),
        interleaved(coarse.fx, new.fx),
        interleaved(coarse.fy, new.fy),
    )


def _solve_at(
    guess: _Path,
    position: FloatArray,
    eta: FloatArray,
    x1_init: FloatArray,
    end: FloatArray,
    operator: FloatArray,
) -> _Path:
    """Solve states at `position`, given as fractions of each curve's length."""
    count = len(position)
    offset = x1_init - position[:, None] * end
    states, _ = solve(
        guess.flat(),
        np.tile(eta, count),
        Closure(offset=offset.ravel()),
        np.tile(operator, (count, 1, 1)),
    )
    return _Path.unflattened(states, count)


def _chebyshev_interpolation(count: int, position: FloatArray) -> FloatArray:
    """Matrix from values at `count` Chebyshev points on [0, 1] to values at `position`."""
    basis = chebyshev.chebvander(2.0 * position - 1.0, count - 1)
    return basis @ chebyshev_transform(count)


def _path_residuals(
    path: _Path, eta: FloatArray, x1_init: FloatArray, end: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Largest residual of each curve at its states, and interpolated half-way between them."""
    count = len(path.fx)
    middle = chebyshev_nodes(2 * count - 1)[1::2]
    halfway = path.combined(_chebyshev_interpolation(count, middle))

    def largest(path: _Path, position: FloatArray) -> FloatArray:
        offset = x1_init - position[:, None] * end
        misfit = residual(path.flat(), np.tile(eta, len(position)), Closure(offset=offset.ravel()))
        # NaN marks a state that was not found
        return np.nan_to_num(misfit, nan=np.inf).reshape(len(position), -1).max(axis=0)

    return largest(path, chebyshev_nodes(count)), largest(halfway, middle)


def _curve_values(path: _Path) -> FloatArray:
    """fx, fy, m and φ1 at the states, shape (states, curves, 4)."""
    states = path.flat()
    values = [states.fx, states.fy, clamp_moment(states), tip_slope(states)]
    return np.stack(values, axis=-1).reshape(*path.fx.shape, 4)


def _curve_decay(values: FloatArray) -> FloatArray:
    """Size of the last Chebyshev coefficients along the curve relative to the largest."""
    transform = chebyshev_transform(len(values))
    coefficients = np.abs(np.einsum("ab,bcv->acv", transform, values))
    return (coefficients[-2:].max(axis=0) / coefficients.max(axis=0)).max(axis=-1)
