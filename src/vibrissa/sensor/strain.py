"""Strains of rods in a period of sticking."""

from collections.abc import Sequence

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
