"""What the model can describe: shapes that stay between clamp and surface and do not cross.

A solution of the equations of equilibrium need not be a shape that a rod beside a surface can have.
Nothing is returned as a number where the rod

- dips below the level of its clamp, where the sensor's housing is;
- crosses itself: the model is plane;
- crosses the surface line: where the rod lies or touches from below it has to stay there. (A shape
  that passes through the surface just before its tip, φ1 < 0, is the paper's own and is marked
  ``penetrates``; ``contact: line`` replaces it.)

The free part needs no bound of its own: it reaches up to η, so that s_c > η, and a beam of 0.3 rod
lengths or more is slender wherever the whole rod is.
"""

import numpy as np

from vibrissa.arrays import BoolArray, FloatArray
from vibrissa.equilibrium import ContactStates, contact_slope
from vibrissa.spectral import gauss_rule
from vibrissa.status import Contact

# A shape touches itself or the surface where it comes nearer than this (L).
TOLERANCE = 1e-9
# Pairs of segments that are looked at together: bounds the memory.
PAIRS_AT_ONCE = 100_000
# Fewest nodes on which a shape is looked at closely.
CLOSE_LOOK = 96

BELOW = "the rod dips below the level of its clamp"
CROSSES_SURFACE = "the rod crosses the surface away from its contact point"
CROSSES_ITSELF = "the rod crosses itself"
REASONS = (BELOW, CROSSES_SURFACE, CROSSES_ITSELF)


def violations(states: ContactStates, eta: FloatArray, contact: Contact) -> BoolArray:
    """Which shapes leave the model's reach, and how.

    Parameters
    ----------
    states : ContactStates
    eta : ndarray, shape (n,)
        Height of the surface (L).
    contact : Contact
        Kind of contact of all states.

    Returns
    -------
    ndarray of bool, shape (n, 3)
        In the order of `REASONS`.
    """
    # A first look at the nodes themselves, and a closer one at what comes near a limit.
    seen = _look(states, eta, contact, margin=0.02)
    near = np.flatnonzero(seen.any(axis=1))
    if len(near):
        finer = states.take(near).on_nodes(max(CLOSE_LOOK, 2 * states.nodes))
        seen[near] = _look(finer, eta[near], contact, margin=0.0)
    return seen


def _look(states: ContactStates, eta: FloatArray, contact: Contact, margin: float) -> BoolArray:
    rule = gauss_rule(states.nodes)
    density = states.arc_density(rule.nodes)
    x = (density * np.cos(states.phi)) @ rule.from_start.T
    y = (density * np.sin(states.phi)) @ rule.from_start.T
    below = y.min(axis=1) < -TOLERANCE
    if margin:
        # Near the clamp the rod stands upright: only what bends back over can come down to it.
        below |= (states.phi.max(axis=1) > np.pi) & (y[:, states.nodes // 8 :].min(axis=1) < margin)
    touches = (
        np.ones(len(states), dtype=bool)
        if contact is Contact.LINE
        else contact_slope(states) >= 0.0
    )
    # Between two nodes a shape can rise above both where it turns over, φ = π.
    above = y.max(axis=1) > eta + TOLERANCE
    if margin:
        turned = np.where(states.phi > np.pi / 2, y, -np.inf).max(axis=1)
        above |= turned > eta - margin
    itself = np.zeros(len(states), dtype=bool)
    # A curve that turns by less than half a circle is a graph over some axis.
    turning = np.flatnonzero(np.ptp(states.phi, axis=1) > np.pi - margin)
    if len(turning):
        itself[turning] = True if margin else _crosses_itself(x[turning, ::2], y[turning, ::2])
    return np.stack([below, touches & above, itself], axis=1)


def _crosses_itself(x: FloatArray, y: FloatArray) -> BoolArray:
    """Whether polylines cross themselves, shape (n,)."""
    points = np.stack([x, y], axis=-1)
    crosses = np.zeros(len(x), dtype=bool)
    segments = x.shape[1] - 1
    # Neighbours share a point.
    first, second = np.triu_indices(segments, 2)
    for rows in np.array_split(np.arange(len(x)), len(x) * len(first) // PAIRS_AT_ONCE + 1):
        start, way = points[rows, :-1], np.diff(points[rows], axis=1)
        between = start[:, second] - start[:, first]
        one, other = way[:, first], way[:, second]
        determinant = _cross(one, other)
        with np.errstate(divide="ignore", invalid="ignore"):
            t, u = _cross(between, other) / determinant, _cross(between, one) / determinant
        crosses[rows] = ((t >= 0.0) & (t <= 1.0) & (u >= 0.0) & (u <= 1.0)).any(axis=1)
    return crosses


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])
