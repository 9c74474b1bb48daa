"""States of rods for tests: made up, or those in which sticking begins."""

import numpy as np

from vibrissa.mechanics.equations import FX, ClosingCondition
from vibrissa.mechanics.mounting import IDEAL, rod_columns
from vibrissa.mechanics.newton import solve
from vibrissa.mechanics.states import RodStates
from vibrissa.outcomes import Contact
from vibrissa.sticking.solving.beginning import begin


def made_states(theta, phi, fx, fy, s_c=1.0, mountings=None):
    """States that need not satisfy any equation; those with s_c < 1 are in line contact."""
    phi = np.atleast_2d(phi)
    theta, fx, fy, s_c = (np.full(len(phi), value, dtype=float) for value in (theta, fx, fy, s_c))
    return RodStates(
        rods=rod_columns(theta, [IDEAL] * len(phi) if mountings is None else mountings),
        unknowns=np.column_stack([phi, fx, fy, s_c]),
        line=s_c < 1.0,
    )


def first_states(theta, eta, nodes, contact=Contact.POINT, mountings=None):
    """The α = 0 states of rods, all of which must have one."""
    theta, eta = (np.atleast_1d(np.array(value, dtype=float)) for value in (theta, eta))
    mountings = [IDEAL] * len(theta) if mountings is None else mountings
    stage = np.array([one.stage_angle for one in mountings])
    begun = begin(rod_columns(theta, mountings), eta, stage, nodes, contact)
    assert not begun.missing
    upright = ClosingCondition.prescribing(eta, {FX: 1.0})
    return solve(begun.states, upright).states
