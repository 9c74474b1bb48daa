"""Strains of a rod in a period of sticking."""

from dataclasses import dataclass

import numpy as np

from vibrissa.mechanics.bending import Strains, strains
from vibrissa.sticking.curve import StickingCurve
from vibrissa.sticking.piece import StickingState

# States of a period among which the largest strain is sought, both ends included.
STATES = 17


def strains_in(curve: StickingCurve, states: StickingState) -> Strains:
    """Largest strain |φ'|·d/2 in each of n states (d0/L), and its place along the rod (L)."""
    x1, height = curve.contact_point(states.x0)
    contact = x1 - (1.0 - states.s_c)
    values = (curve.theta, states.f, states.alpha, contact, height, states.s_c)
    theta, f, alpha, x_c, y_c, s_c = np.broadcast_arrays(*(np.atleast_1d(x) for x in values))
    return strains(theta, f, alpha, x_c, y_c, s_c, curve.mounting)


def strains_until(curve: StickingCurve, end: float) -> tuple[float, Strains]:
    """Largest strain at the end of a period of sticking, and in the whole period.

    Parameters
    ----------
    end : float
        Displacement x0 at which the period ends (L).

    Returns
    -------
    at_end : float
        In units of d0/L.
    """
    found = strains_in(curve, curve.state(np.linspace(0.0, end, STATES)))
    return float(found.largest[-1]), found.take(np.atleast_1d(found.largest.argmax()))


@dataclass(frozen=True, kw_only=True)
class Yield:
    """Place where a rod yields.

    Attributes
    ----------
    strain : float
        Largest strain, in units of d0/L.
    place : float
        Its arc length from the clamp (L).
    x0 : float
        Displacement at which the rod begins to yield (L).
    """

    strain: float
    place: float
    x0: float


def yields(curve: StickingCurve, end: float, yield_strain: float) -> Yield | None:
    """Find whether a rod yields in a period of sticking.

    Parameters
    ----------
    end : float
        Displacement x0 at which the period ends (L); at another height, as of an oblique stage, it
        may lie past the end of the curve.
    yield_strain : float
        Strain up to which the material is elastic, in units of d0/L.
    """
    x0 = np.linspace(0.0, min(end, curve.x0_end), STATES)
    found = strains_in(curve, curve.state(x0))
    most = int(found.largest.argmax())
    beyond = np.flatnonzero(found.largest > yield_strain)
    if not len(beyond):
        return None
    first = int(beyond[0])
    at = float(x0[first])
    if first > 0:
        pair = slice(first - 1, first + 1)
        at = float(np.interp(yield_strain, found.largest[pair], x0[pair]))
    return Yield(strain=float(found.largest[most]), place=float(found.place[most]), x0=at)
