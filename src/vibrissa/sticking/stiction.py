"""Friction enters: what a sticking curve answers for every μ0 and Δx0.

The exact onset x0_slip is where −tan α = μ0. On the step grid the paper's x0,max is the last state
of stiction, the largest multiple of Δx0 that does not pass the onset; slip happens one step later.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal

import numpy as np

from vibrissa.numerics.arrays import BoolArray, FloatArray
from vibrissa.numerics.steps import last_step_within, step_position
from vibrissa.outcomes import Contact, Status
from vibrissa.sticking.curve import StickingCurve
from vibrissa.sticking.piece import StickingState


@dataclass(frozen=True, eq=False, kw_only=True)
class Stiction:
    """Periods of sticking on one curve, one for each pair of μ0 and Δx0.

    Attributes
    ----------
    status : list of Status
        ``slip``, ``lock``, or what the curve has instead of states.
    x0_slip : ndarray, shape (n,)
        Exact onset of slip (L); NaN where there is none.
    n_steps : ndarray of float, shape (n,)
        Steps to the last sticking state; NaN where there is none.
    x0_max : ndarray, shape (n,)
        Last state of stiction on the step grid, n_steps·Δx0 (L).
    penetrates : ndarray of bool, shape (n,)
        Whether φ1 < 0 somewhere up to the last sticking state (up to the lock where it locks), so
        that the point-contact shape passes through the surface.
    contact : list of str
        Kind of contact at the onset of slip (at the lock where it locks); empty elsewhere.
    init, last, slip : StickingState
        States at α = 0, at the last sticking step and at the exact onset; NaN where there is none.
    end : list of str
        Where the tip locks, how sticking ends past the lock
        (`vibrissa.outcomes.End`); empty elsewhere.
    ended : StickingState
        The state in which it does; NaN elsewhere and where the curve was not followed.
    trail : StickingState
        Last sticking state of a rod that has swung aside; NaN elsewhere.
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
    """Read periods of sticking off a curve.

    Parameters
    ----------
    curve : StickingCurve
    mu0, dx0 : sequence of Decimal, length n
        Pairs of friction coefficient and exact step size (L).

    Returns
    -------
    Stiction
    """
    n = len(mu0)
    friction = np.array([float(mu) for mu in mu0])
    x0_slip, status = curve.outcomes(friction)
    slips = np.isfinite(x0_slip)
    n_steps, x0_max = np.full(n, np.nan), np.full(n, np.nan)
    for step in set(dx0):
        rows = np.array([step == other for other in dx0]) & slips
        count = last_step_within(x0_slip[rows], step)
        n_steps[rows], x0_max[rows] = count, step_position(count, step)
    # A rod that is free to lie down does not pass through the surface.
    touches = all(piece.contact is Contact.POINT for piece in curve.pieces)
    sticks_until = np.where(slips, x0_max, curve.x0_lock)
    end, ended, trail = [""] * n, StickingState.unknown(n), StickingState.unknown(n)
    locks = np.flatnonzero([what is Status.LOCK for what in status])
    if len(locks):
        ends, states = curve.motion_end(friction[locks])
        for row, how in zip(locks, ends, strict=True):
            end[row] = how.value
        ended.put(locks, states)
        trail.put(locks, curve.trailing_end(friction[locks]))
    # All that is asked of the curve at once: the first state, and two for each point.
    x0_init = 0.0 if curve.pieces else np.nan
    states = curve.states_where_known(np.concatenate([[x0_init], x0_max, x0_slip]))
    return Stiction(
        status=status,
        x0_slip=x0_slip,
        n_steps=n_steps,
        x0_max=x0_max,
        # At 0 already, or strictly before the last sticking state; NaN compares as no.
        penetrates=touches & ((curve.x0_touch == 0.0) | (curve.x0_touch < sticks_until)),
        contact=curve.contact(np.where(slips, x0_slip, curve.x0_lock)),
        init=states.take(np.zeros(n, dtype=np.int64)),
        last=states.take(slice(1, n + 1)),
        slip=states.take(slice(n + 1, None)),
        end=end,
        ended=ended,
        trail=trail,
    )
