"""Periods of sticking of a scan: from one slip to the next."""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import NamedTuple

import numpy as np

from vibrissa.numerics.arrays import FloatArray, IntArray, StrArray
from vibrissa.numerics.batch import Batch
from vibrissa.scanning.response import mirrored_loads
from vibrissa.scanning.slip import SlipEnd
from vibrissa.scanning.surfaces import Footing
from vibrissa.scanning.tip import Tip


class EndsBy(StrEnum):
    """How a period of sticking ends.

    Attributes
    ----------
    SLIP
        The tip slips and comes to rest.
    PATH
        The clamp reaches the end of its path while the tip sticks.
    LOCK
        The tip locked and was pushed until sticking ended; the motion after that is not computed.
    LOST
        The slip leaves the computed states.
    UNKNOWN
        The states of the rod were not computed further.
    """

    SLIP = "slip"
    PATH = "path"
    LOCK = "lock"
    LOST = "lost"
    UNKNOWN = "unknown"


class PeriodEnd(NamedTuple):
    """End of a period of sticking.

    Attributes
    ----------
    tip : Tip
        The tip where it stuck at the end of the period.
    stop : int
        First step at which it does not stick, or the number of steps of the path.
    until : float
        Clamp position at which sticking ends (L); NaN if the tip sticks to the end of the path.
    ends_by : EndsBy
    clamp : float
        Clamp position during the slip (L); NaN without a slip.
    footing : Footing or None
        Place of the tip after the slip; None if it did not come to rest.
    slip_end : SlipEnd or None
        Where the slip ends, and its energies; None if the tip did not come to rest.
    """

    tip: Tip
    stop: int
    until: float
    ends_by: EndsBy
    clamp: float = np.nan
    footing: Footing | None = None
    slip_end: SlipEnd | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class Periods(Batch):
    """Periods of sticking of a scan, one row for each; a number that is not known is NaN.

    Attributes
    ----------
    period : ndarray of int, shape (n,)
        Number of the period, from 1.
    begin, last : ndarray, shape (n,)
        Position of the clamp at its first and last step (L).
    onset : ndarray, shape (n,)
        Position of the clamp at which sticking ends, between two steps (L).
    slip : ndarray, shape (n,)
        Position of the clamp at the step in which the tip slips (L).
    steps : ndarray of int, shape (n,)
        Number of steps from `begin` to `last`.
    travel : ndarray, shape (n,)
        Way of the clamp from `begin` to `onset` (L); the clamp may turn in between.
    contact, contact_rest : ndarray, shape (n,)
        Position of the tip at the end of the period and after the slip (L).
    side : ndarray of int, shape (n,)
        1 for a tip ahead of the clamp, −1 for a tip behind it, at the end of the period.
    mu0 : ndarray, shape (n,)
        Coefficient of static friction under the tip.
    height, inclination : ndarray, shape (n,)
        Height of the surface under the tip (L), and its inclination γ (rad), as in `Scan`.
    x0_onset, x0_rest : ndarray, shape (n,)
        Displacement from the α = 0 state at `onset`, and after the slip (L).
    loads_onset, loads_rest : ndarray, shape (n, 3)
        Clamp reactions fx, fy (E·I0/L²) and m (E·I0/L) at `onset`, and after the slip.
    released, dissipated : ndarray, shape (n,)
        Elastic energy that the slip releases, and work against kinetic friction (E·I0/L).
    ends_by : ndarray of str, shape (n,)
        `EndsBy` of each period.
    """

    period: IntArray
    begin: FloatArray
    last: FloatArray
    onset: FloatArray
    slip: FloatArray
    steps: IntArray
    travel: FloatArray
    contact: FloatArray
    contact_rest: FloatArray
    side: IntArray
    mu0: FloatArray
    height: FloatArray
    inclination: FloatArray
    x0_onset: FloatArray
    x0_rest: FloatArray
    loads_onset: FloatArray
    loads_rest: FloatArray
    released: FloatArray
    dissipated: FloatArray
    ends_by: StrArray

    @property
    def apparent_friction(self) -> FloatArray:
        """|fx/fy| at the onset, which is μ0 on a plane, and tan(atan μ0 − γ) of a pushed tip."""
        fx, fy, _ = self.loads_onset.T
        return np.abs(fx / fy)

    @property
    def slip_length(self) -> FloatArray:
        """Distance between the places of the tip before and after the slip (L)."""
        return np.abs(self.contact_rest - self.contact)


def periods_of(ends: Sequence[PeriodEnd], clamp: FloatArray) -> Periods:
    """Describe the periods that end at `ends`, for the positions of a scan's clamp (L)."""
    tips = [end.tip for end in ends]
    stop = np.array([end.stop for end in ends], dtype=np.int64)
    # Each period begins in the step of the slip that ends the one before.
    begin, last = np.append(0, stop)[:-1], stop - 1
    travelled = np.append(0.0, np.cumsum(np.abs(np.diff(clamp))))
    onset = np.array([end.until for end in ends])
    side = np.array([tip.side for tip in tips], dtype=np.int64)
    contact = np.array([tip.contact for tip in tips])
    clamp_in_slip = np.array([end.clamp for end in ends])
    slips = [end.slip_end or SlipEnd(contact=np.nan, x0=np.nan) for end in ends]
    x0_rest = np.array([slip.x0 for slip in slips])
    contact_rest = np.array([slip.contact for slip in slips])
    height = np.array([tip.footing.height for tip in tips])
    slope = np.array([tip.footing.ahead.slope for tip in tips])
    height_rest = np.array([end.footing.height if end.footing else np.nan for end in ends])
    at_onset = _loading(tips, onset, contact, side, height)
    return Periods(
        period=np.arange(1, len(ends) + 1),
        begin=clamp[begin],
        last=clamp[last],
        onset=onset,
        slip=clamp_in_slip,
        steps=last - begin,
        travel=travelled[last] - travelled[begin] + np.abs(onset - clamp[last]),
        contact=contact,
        contact_rest=contact_rest,
        side=side,
        mu0=np.array([tip.mu0 for tip in tips]),
        height=height,
        inclination=0.0 - side * np.arctan(slope),
        x0_onset=side * at_onset.x0,
        x0_rest=side * x0_rest + 0.0,  # no −0
        loads_onset=at_onset.loads,
        loads_rest=_loading(tips, clamp_in_slip, contact_rest, side, height_rest, x0_rest).loads,
        released=np.array([slip.released for slip in slips]),
        dissipated=np.array([slip.dissipated for slip in slips]),
        ends_by=np.array([end.ends_by for end in ends], dtype=np.str_),
    )


class _Loading(NamedTuple):
    """Displacements of rods whose tips stick (L), and their loads."""

    x0: FloatArray
    loads: FloatArray


def _loading(
    tips: Sequence[Tip],
    clamp: FloatArray,
    contact: FloatArray,
    side: IntArray,
    height: FloatArray,
    x0: FloatArray | None = None,
) -> _Loading:
    """Displacement and loads at clamp positions; NaN where the position is NaN."""
    known = np.flatnonzero(~np.isnan(clamp))
    displacements, loads = np.full(len(clamp), np.nan), np.full((len(clamp), 3), np.nan)
    if len(known):
        stage, sign = tips[0].stage, side[known]
        states, held = stage.states(clamp[known], contact[known], sign, height[known])
        displacements[known] = held if x0 is None else x0[known]
        reactions = states.reactions(states.clip(displacements[known]))
        loads[known] = mirrored_loads(reactions, sign)
    return _Loading(x0=displacements, loads=loads)
