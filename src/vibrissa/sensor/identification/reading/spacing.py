"""Friction from the spacing of slips: how far the clamp travels from one slip to the next.

A period of sticking begins where the slip before it came to rest, at r, and ends at the onset o:
the clamp travels T = o − r. Both depend on the friction under the tip, which is the same at both
ends of a period. So T determines the friction as soon as the slip law determines r:

- ``free``: r = 0;
- ``kinetic``: the friction that the rod needs at r is κ·μ0, on the side from which the tip came;
  where the clamp pulls, two frictions may have the same travel;
- ``energy``: the friction along the whole slip counts: see `energy`;
- no law: as the tip sticks at r, it needs at most μ0 there, on either side. The largest T for a
  friction μ0 is that from the far side; the least is 0.
"""

from dataclasses import dataclass
from itertools import product

import numpy as np

from vibrissa.errors import ArgumentError
from vibrissa.numerics.arrays import BoolArray, FloatArray
from vibrissa.sensor.response.branch import Branch
from vibrissa.sensor.simulation.slips import SlipLaw

# Onsets at which the travel is tabulated.
POINTS = 4001
# Part of the way to where pulling ends, where any friction would be needed.
ALMOST = 0.9999


@dataclass(frozen=True, eq=False, kw_only=True)
class Spacing:
    """Onset over travel, for each pair of directions of the clamp before and after the period.

    Build one with `spacing`.

    Attributes
    ----------
    tables : dict
        For the direction of the clamp at the slip before the period and that at its end (1 forward,
        −1 backward): travels and onsets (L), both measured in the latter direction.
    sure : frozenset
        Pairs of directions for which the travel determines the onset; for the others it gives a
        lower bound.
    """

    tables: dict[tuple[int, int], tuple[FloatArray, FloatArray]]
    sure: frozenset[tuple[int, int]]

    def gives_bounds(self, before: FloatArray, after: FloatArray) -> BoolArray:
        """Tell for which periods the onset is only a lower bound."""
        bounds = np.zeros(len(after), dtype=bool)
        for came, goes in self.tables:
            if (came, goes) not in self.sure:
                bounds |= _moved(before, after, came, goes)
        return bounds

    def onset(self, travel: FloatArray, before: FloatArray, after: FloatArray) -> FloatArray:
        """Find the displacements at the onset for travels of the clamp.

        Parameters
        ----------
        travel : ndarray, shape (n, k)
            Travels of n periods (L).
        before, after : ndarray, shape (n,)
            Directions of the clamp at both ends of each period.

        Returns
        -------
        ndarray, shape (n, k)
            For travels that this rod cannot have, beyond its onsets.
        """
        onset = np.array(travel)
        for (came, goes), (travels, onsets) in self.tables.items():
            rows = _moved(before, after, came, goes)
            way = goes * travel[rows]
            beyond = np.maximum(way - travels[-1], 0.0) + np.minimum(way - travels[0], 0.0)
            onset[rows] = goes * (np.interp(way, travels, onsets) + beyond)
        return onset


def _moved(before: FloatArray, after: FloatArray, came: int, goes: int) -> BoolArray:
    """Which periods begin and end with the clamp moving in these directions."""
    came_so, goes_so = (np.where(way < 0.0, -1, 1) for way in (before, after))
    return np.asarray((came_so == came) & (goes_so == goes))


def spacing(branch: Branch, law: SlipLaw | None, kinetic_ratio: float | None = None) -> Spacing:
    """Tabulate the onset over the travel.

    Parameters
    ----------
    branch : Branch
    law : SlipLaw or None
        With ``free`` and ``kinetic`` the travel determines the onset; without a law, or with
        ``energy``, it gives a lower bound.
    kinetic_ratio : float, optional
        μk/μ0 for ``kinetic`` and ``energy``, above 0 and below 1: at 1 there is no slip.

    Returns
    -------
    Spacing

    Raises
    ------
    ArgumentError
        If the ratio is out of range.
    """
    needs_ratio = law in (SlipLaw.KINETIC, SlipLaw.ENERGY)
    if needs_ratio and not (kinetic_ratio is not None and 0.0 < kinetic_ratio < 1.0):
        raise ArgumentError(
            f"the spacing of {law} slips needs a kinetic ratio above 0 and below 1, got "
            f"{'none' if kinetic_ratio is None else kinetic_ratio}"
        )
    ends = {1: branch.x0_lock, -1: ALMOST * branch.x0_pull}
    needed, onsets = {}, {}
    for way, end in ends.items():
        needed[way], onsets[way] = onset_table(branch, end)
    tables, sure = {}, set()
    for came, goes in product((1, -1), repeat=2):
        onset, mu0 = onsets[goes], needed[goes]
        if law is SlipLaw.FREE:
            travel = onset
        elif law is SlipLaw.KINETIC:
            rest = np.interp((kinetic_ratio or 0.0) * mu0, needed[came], onsets[came])
            travel = onset - came * goes * rest
        if law in (SlipLaw.FREE, SlipLaw.KINETIC) and (np.diff(travel) >= 0.0).all():
            sure.add((came, goes))
        else:
            travel = onset + np.interp(mu0, needed[-goes], onsets[-goes])
        tables[came, goes] = travel, onset
    return Spacing(tables=tables, sure=frozenset(sure))


def onset_table(branch: Branch, end: float) -> tuple[FloatArray, FloatArray]:
    """Tabulate the friction with which a tip sticks up to a displacement, and the displacement.

    Parameters
    ----------
    branch : Branch
    end : float
        Where the table ends (L), below 0 for a tip that is pulled.

    Returns
    -------
    mu0, x0 : ndarray
        The friction rises; displacements as magnitudes (L).
    """
    x0 = np.linspace(0.0, end, POINTS)[:-1]
    return np.maximum.accumulate(np.abs(branch.demand(x0))), np.abs(x0)
