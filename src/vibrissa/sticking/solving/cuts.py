"""Where pieces begin and end: each place is solved on as many nodes as it needs.

What pieces are cut at has to be exact, unlike the steps in which branches are followed.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from vibrissa.mechanics.equations import Closure, contact_position
from vibrissa.mechanics.newton import solve
from vibrissa.mechanics.states import RodStates
from vibrissa.numerics.arrays import BoolArray, FloatArray, IntArray
from vibrissa.outcomes import Contact, Parameter
from vibrissa.sticking.solving.continuation import switch_states
from vibrissa.sticking.solving.refinement import NODES_ALONG_ROD, is_resolved
from vibrissa.sticking.solving.segments import Branches, Segment


def exact_x1_init(first: Segment) -> FloatArray:
    """Contact points of the α = 0 states in which segments begin.

    Parameters
    ----------
    first : Segment
        Of n branches.

    Returns
    -------
    ndarray, shape (n,)
        NaN where not resolved.
    """
    states, line = first.at(np.zeros(len(first.origin), dtype=np.int64))
    return _exact(
        states,
        line,
        replace(first.branches, stage_angle=None),
        lambda contact, i: Closure.at_inclination(np.zeros(len(i)), contact),
        lambda states, i: contact_position(states)[0],
    )


def exact_advance(first: Segment, x0: FloatArray) -> FloatArray:
    """Advance of the last states of segments.

    Parameters
    ----------
    first : Segment
        Of n branches.
    x0 : ndarray, shape (n,)
        Displacements of these states (L).

    Returns
    -------
    ndarray, shape (n,)
        NaN where not resolved.
    """
    states, line = first.at(first.last)
    return _exact(
        states,
        line,
        first.branches,
        lambda contact, i: first.branches.take(i).closure(Parameter.X0, contact, x0[i]),
        lambda states, i: first.branches.take(i).value_of(Parameter.ADVANCE, states),
    )


def switches_between(segment: Segment, k: int, changing: IntArray) -> FloatArray:
    """Parameter at which the contact of some branches changes between two steps.

    Parameters
    ----------
    segment : Segment
    k : int
        The first of the two.
    changing : ndarray of int, shape (n,)
        The branches.

    Returns
    -------
    ndarray, shape (n,)
        NaN where not resolved.
    """
    branches = segment.branches.take(changing)
    # From the side on which the tip alone touches.
    side = np.where(segment.line[k], k + 1, k)
    guess = switch_states(segment.at(side)[0].take(changing), branches)
    return _exact(
        guess,
        np.zeros(len(changing), dtype=bool),
        branches,
        lambda contact, i: branches.take(i).tilted(Closure.at_switch(len(i))),
        lambda states, i: branches.take(i).value_of(segment.parameter, states),
    )


def _exact(
    states: RodStates,
    line: BoolArray,
    branches: Branches,
    closure: Callable[[Contact, IntArray], Closure],
    measure: Callable[[RodStates, IntArray], FloatArray],
) -> FloatArray:
    """Measure states on as many nodes as they need; NaN where there never are enough."""
    measured, height = np.full(len(states), np.nan), branches.height
    for contact, kind in ((Contact.POINT, ~line), (Contact.LINE, line)):
        rows = np.flatnonzero(kind)
        guess = states.take(rows)
        for nodes in NODES_ALONG_ROD:
            if not len(rows):
                break
            conditions = closure(contact, rows)
            solution = solve(guess.on_nodes(nodes), height[rows], conditions).states
            good = is_resolved(solution, height[rows], conditions)
            measured[rows[good]] = measure(solution.take(good), rows[good])
            rows, guess = rows[~good], guess.take(~good)
    return measured
