"""Strains of rods in a period of sticking."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from vibrissa.mechanics.bending import Bending, measure
from vibrissa.sticking.curve import StickingCurve

# States of a period among which the largest strain is sought, both ends included.
STATES = 17


def strains_in(curves: Sequence[StickingCurve], x0: Sequence[ArrayLike]) -> Bending:
    """Largest strain |φ'|·d/2 at displacements on each curve (d0/L), and its place along the rod.

    The curves have the same mounting. They are integrated together, as rows one after the other.
    """
    rows = []
    for curve, at in zip(curves, x0, strict=True):
        state = curve.state(at)
        x1, height = curve.contact_point(at)
        contact = x1 - (1.0 - state.s_c)
        values = (curve.theta, state.f, state.alpha, contact, height, state.s_c)
        rows.append(np.broadcast_arrays(*(np.atleast_1d(value) for value in values)))
    theta, f, alpha, x_c, y_c, s_c = np.concatenate(rows, axis=1)
    return measure(theta, f, alpha, x_c, y_c, s_c, curves[0].mounting)


def largest_strain(curve: StickingCurve, end: float) -> Bending:
    """Find the largest strain in a period of sticking that ends at a displacement (L)."""
    found = strains_in([curve], [np.linspace(0.0, end, STATES)])
    return found.take(np.atleast_1d(found.strain.argmax()))


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
    found = strains_in([curve], [x0])
    most, beyond = int(found.strain.argmax()), found.strain > yield_strain
    if not beyond.any():
        return None
    # From the state before the first that yields, which may be the first of all.
    first = int(beyond.argmax())
    pair = slice(max(first - 1, 0), first + 1)
    at = float(np.interp(yield_strain, found.strain[pair], x0[pair]))
    return Yield(strain=float(found.strain[most]), place=float(found.place[most]), x0=at)
