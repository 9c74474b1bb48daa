"""Periods of sticking, found on sticking curves for any μ0 and Δx0.

The paper's x0,max is the largest multiple of Δx0 that does not pass the exact onset x0_slip.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal
from typing import NamedTuple

import numpy as np

from vibrissa.numerics.arrays import BoolArray, FloatArray, IntArray
from vibrissa.numerics.steps import last_step_within, step_position
from vibrissa.outcomes import Status
from vibrissa.sticking.curve import StickingCurve, curve_array
from vibrissa.sticking.onsets import CurveArray
from vibrissa.sticking.piece import StickingState


@dataclass(frozen=True, eq=False, kw_only=True)
class Stiction:
    """Periods of sticking, one for each requested curve, μ0 and Δx0.

    Attributes
    ----------
    status : list of Status
        ``slip`` if the tip slips forward, ``lock`` if it locks; otherwise the status of the curve.
    x0_slip : ndarray, shape (n,)
        Exact onset of slip (L); NaN unless the tip slips.
    n_steps : ndarray of float, shape (n,)
        Number of steps Δx0 to the last sticking state; NaN unless the tip slips.
    x0_max : ndarray, shape (n,)
        Displacement of the last sticking state on the step grid, n_steps·Δx0 (L).
    penetrates : ndarray of bool, shape (n,)
        Whether the point-contact shape passes through the surface before the onset or the lock.
    contact : list of str
        Kind of contact at the onset of slip or, of a locked tip, in the critical state or where
        the tip slips back before; else empty.
    init, last, slip : StickingState
        States at α = 0, at the last sticking step and at the exact onset; NaN if not reached.
    end : list of str
        How sticking of a locked tip ends (`vibrissa.outcomes.End`); empty unless the tip locks.
    ended : StickingState
        State in which sticking of a locked tip ends; NaN if `end` is empty or ``not_followed``.
    trail : StickingState
        Last sticking state of a rod that has buckled laterally and trails behind its clamp; NaN for
        other rods, and where the curve's retraction ends before this state.
    """

    status: list[Status]
    x0_slip: FloatArray
    n_steps: FloatArray
    x0_max: FloatArray
    penetrates: BoolArray
    contact: list[str]
    init: StickingState
    last: StickingState
    slip: StickingState
    end: list[str]
    ended: StickingState
    trail: StickingState


def read_curve(curve: StickingCurve, mu0: Sequence[Decimal], dx0: Sequence[Decimal]) -> Stiction:
    """Find periods of sticking on one curve; see `read_curves`."""
    return read_curves([curve], [np.array([float(mu) for mu in mu0])], [dx0])


def read_curves(
    curves: Sequence[StickingCurve], mu0: Sequence[FloatArray], dx0: Sequence[Sequence[Decimal]]
) -> Stiction:
    """Find periods of sticking on curves.

    For each curve, `mu0` has an array of friction coefficients, and `dx0` as many exact steps Δx0
    (L). The n-th μ0 and the n-th Δx0 give one period. No period depends on others, not even by
    rounding.
    """
    together = curve_array(curves)
    index = np.repeat(np.arange(len(curves)), [len(pairs) for pairs in mu0])
    friction = np.concatenate(mu0)
    x0_slip, status = together.outcomes(index, friction)
    last = last_steps(x0_slip, [step for pairs in dx0 for step in pairs])
    locks = np.flatnonzero(np.array(status, dtype=object) == Status.LOCK)
    ends = _ends_of_locks(together, index, friction, locks)
    # A tip may slip back before the critical state is reached.
    sticks_until = np.where(
        np.isfinite(x0_slip), x0_slip, np.fmin(together.x0_lock[index], ends.state.x0)
    )
    # Evaluate all states together: the first one of each curve, and two of each period.
    x0_init = np.where(together.has_states, 0.0, np.nan)
    states = together.states(
        np.concatenate([np.arange(len(curves)), index, index]),
        np.concatenate([x0_init, last.x0, x0_slip]),
    )
    of_periods = states.take(slice(len(curves), None))
    return Stiction(
        status=status,
        x0_slip=x0_slip,
        n_steps=last.number,
        x0_max=last.x0,
        penetrates=_penetrates(curves, index, sticks_until),
        contact=together.contact(index, sticks_until),
        init=states.take(index),
        last=of_periods.take(slice(len(index))),
        slip=of_periods.take(slice(len(index), None)),
        end=ends.end,
        ended=ends.state,
        trail=ends.trail,
    )


class _EndsOfLocks(NamedTuple):
    """How and where sticking ends in n periods with a locked tip; empty or NaN in others.

    Attributes
    ----------
    end : list of str
    state, trail : StickingState
        Columns of shape (n,), as `ended` and `trail` of `Stiction`.
    """

    end: list[str]
    state: StickingState
    trail: StickingState


def _ends_of_locks(
    curves: CurveArray, index: IntArray, mu0: FloatArray, locks: IntArray
) -> _EndsOfLocks:
    """Find the ends of the periods with the numbers `locks`; `index` has the curve of each."""
    ends = [""] * len(index)
    state, trail = StickingState.unknown(len(index)), StickingState.unknown(len(index))
    if len(locks):
        found, states = curves.motion_end(index[locks], mu0[locks])
        for row, how in zip(locks.tolist(), found, strict=True):
            ends[row] = how.value
        state = state.with_rows(locks, states)
        trail = trail.with_rows(locks, curves.trailing_end(index[locks], mu0[locks]))
    return _EndsOfLocks(end=ends, state=state, trail=trail)


def _penetrates(
    curves: Sequence[StickingCurve], index: IntArray, sticks_until: FloatArray
) -> BoolArray:
    """Whether rods in point contact pass through the surface before sticking ends (L)."""
    # A rod that may lie on the surface does not pass through it.
    touches = np.array([not curve.pieces.line.any() for curve in curves])
    x0_touch = np.array([curve.x0_touch for curve in curves])[index]
    # The first touch is at 0, or strictly before the onset; comparisons with NaN are false.
    return np.asarray(touches[index] & ((x0_touch == 0.0) | (x0_touch < sticks_until)))


class LastSteps(NamedTuple):
    """Last steps at which tips stick; NaN without an onset.

    Attributes
    ----------
    number : ndarray of float, shape (n,)
        Number of steps Δx0 from α = 0.
    x0 : ndarray, shape (n,)
        Displacement after these steps (L).
    """

    number: FloatArray
    x0: FloatArray


def last_steps(x0_slip: FloatArray, dx0: Sequence[Decimal]) -> LastSteps:
    """Find the last step Δx0 (L) that does not pass each onset of slip (L)."""
    counts, x0 = np.full(len(x0_slip), np.nan), np.full(len(x0_slip), np.nan)
    slips = np.isfinite(x0_slip)
    numbers: dict[Decimal, int] = {}
    which = np.array([numbers.setdefault(step, len(numbers)) for step in dx0])
    for step, number in numbers.items():
        rows = np.flatnonzero(slips & (which == number))
        count = last_step_within(x0_slip[rows], step)
        counts[rows], x0[rows] = count, step_position(count, step)
    return LastSteps(number=counts, x0=x0)
