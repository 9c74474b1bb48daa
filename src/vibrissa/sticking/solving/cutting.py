"""Paths are cut into smooth pieces, each counted by a parameter that increases all along it.

A path is cut where the contact changes its kind. Between two kinks it is counted by the
displacement as long as that grows steadily, and by the advance along a direction of its own where
the forces change faster or the displacement turns back. The places where pieces meet are solved on
as many nodes as they need: unlike the knots, they have to be exact.
"""

from dataclasses import replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from vibrissa.mechanics.equations import Closure, contact_position
from vibrissa.mechanics.newton import solve
from vibrissa.mechanics.states import RodStates
from vibrissa.numerics.arrays import BoolArray, FloatArray, IntArray
from vibrissa.numerics.spectral import chebyshev_nodes
from vibrissa.outcomes import Contact, Parameter, RodSection
from vibrissa.sticking.solving.branches import Branches
from vibrissa.sticking.solving.following import Followed, Knots, between
from vibrissa.sticking.solving.paths import Pieces
from vibrissa.sticking.solving.refinement import NODES_ALONG_ROD, is_resolved

# Least share of the displacement in the direction of a path that is counted by it.
STEADY = 0.05
# Part of the largest −tan α below which a path has passed its lock.
PAST_LOCK = 0.6
# What −tan α is at α = 0, up to the accuracy of the knots.
NO_DEMAND = 1e-4
# Least share of a direction in those of a piece that is counted along it.
ALONG = 0.4
# The displacement as a direction.
X0 = np.array([1.0, 0.0, 0.0, 0.0])


class Part(NamedTuple):
    """Part of a path to be solved as one piece.

    Attributes
    ----------
    branch : int
    first, last : int
        Knots at its ends.
    parameter : Parameter
        By which it is counted.
    direction : ndarray, shape (4,)
        Along which it is counted: that of the displacement, or one of its own.
    """

    branch: int
    first: int
    last: int
    parameter: Parameter
    direction: FloatArray


def parts_of(knots: Knots) -> list[Part]:
    """Cut paths into parts that are counted by one parameter each, in the order of the knots."""
    parts = []
    before_lock = _before_lock(knots)
    begins = np.append(np.flatnonzero(knots.step == 0.0), len(knots))
    for start, stop in pairwise(begins.tolist()):
        along = knots.direction[start:stop]
        steady = (along[:, 0] >= STEADY) & before_lock[start:stop]
        by_x0 = steady[:-1] & steady[1:]
        cuts = np.flatnonzero(by_x0[1:] != by_x0[:-1]) + 1
        for low, high in pairwise([0, *cuts.tolist(), len(by_x0)]):
            if low == high:
                continue
            parameter, bent = Parameter.X0, [(low, high, X0)]
            if not by_x0[low]:
                parameter, bent = Parameter.ADVANCE, _straight(along, low, high)
            parts += [
                Part(int(knots.branch[start]), start + i, start + j, parameter, direction)
                for i, j, direction in bent
            ]
    return parts


def _before_lock(knots: Knots) -> BoolArray:
    """Whether −tan α has not yet fallen well below its largest value, on paths that turn back."""
    with np.errstate(divide="ignore", invalid="ignore"):
        demand = np.nan_to_num(knots.states.fx / knots.states.fy, nan=-np.inf)
    before = np.ones(len(knots), dtype=bool)
    begins = np.flatnonzero(np.append(True, np.diff(knots.branch) != 0))
    for start, stop in pairwise([*begins.tolist(), len(knots)]):
        if knots.direction[stop - 1, 0] < STEADY:
            own = demand[start:stop]
            before[start:stop] = own >= PAST_LOCK * np.maximum.accumulate(own) - NO_DEMAND
    return before


def _straight(along: FloatArray, low: int, high: int) -> list[tuple[int, int, FloatArray]]:
    """Cut where the directions of a path differ too much from that of its ends."""
    middle = along[low] + along[high]
    direction = middle / np.linalg.norm(middle)
    if high - low == 1 or (along[low : high + 1] @ direction).min() > ALONG:
        return [(low, high, direction)]
    half = (low + high) // 2
    return [*_straight(along, low, half), *_straight(along, half, high)]


def exact_x1_init(branches: Branches, states: RodStates, line: BoolArray) -> FloatArray:
    """Contact points of α = 0 states (L); NaN where not resolved."""
    upright = Closure.at_inclination(np.zeros(len(line)))
    found = exact(states, line, branches.eta, upright)
    return contact_position(found)[0]


def exact(guess: RodStates, line: BoolArray, height: FloatArray, closure: Closure) -> RodStates:
    """Solve states on as many nodes as they need, and return them on the most of these.

    Parameters
    ----------
    guess : RodStates
    line : ndarray of bool, shape (n,)
        Which are in line contact.
    height : ndarray, shape (n,)
        Right side of E2.
    closure : Closure
        What is prescribed; its kind of contact does not matter.

    Returns
    -------
    RodStates
        NaN where there never are enough.
    """
    found = guess.on_nodes(NODES_ALONG_ROD[0]).unsolved()
    for contact, kind in ((Contact.POINT, ~line), (Contact.LINE, line)):
        rows, conditions = np.flatnonzero(kind), replace(closure, contact=contact)
        for nodes in NODES_ALONG_ROD:
            if not len(rows):
                break
            some = conditions.take(rows)
            states = solve(guess.take(rows).on_nodes(nodes), height[rows], some).states
            good = is_resolved(states, height[rows], some)
            found = found if found.nodes >= nodes else found.on_nodes(nodes)
            found.put(rows[good], states.take(good).on_nodes(found.nodes))
            rows = rows[~good]
    return found


def places(
    branches: Branches, followed: Followed, parts: list[Part]
) -> tuple[FloatArray, FloatArray]:
    """Coordinates of both ends of parts, shape (parts, 4) each; NaN where not resolved.

    Parameters
    ----------
    branches : Branches
        With exact contact points of the α = 0 states.
    followed : Followed
        What lies behind the ends of its paths does not count: these need not be exact.
    parts : list of Part

    Returns
    -------
    first, last : ndarray
    """
    knots = followed.knots
    some = branches.take(knots.branch)
    at = some.coordinates(knots.states)
    at[followed.origins, 0] = (-branches.x1_init / branches.scale)[knots.branch[followed.origins]]
    begins = knots.step == 0.0
    kinks = begins & (np.roll(knots.branch, 1) == knots.branch) & (np.arange(len(begins)) > 0)
    kinks |= np.roll(kinks, -1)
    # Parts that meet between two kinks do so where the first of them says.
    direction = np.zeros((len(knots), 4))
    for part in reversed(parts):
        direction[[part.first, part.last]] = part.direction
    rows = np.unique([row for part in parts for row in (part.first, part.last)]).astype(int)
    rows = rows[~followed.ends[rows]]
    chosen, switch = some.take(rows), kinks[rows]
    value = np.vecdot(direction[rows], at[rows])
    special = switch | followed.origins[rows]
    value[special], direction[rows[special]] = 0.0, 0.0
    closure = chosen.at_advance(value, direction[rows])
    # What begins at α = 0 or with a kink is prescribed otherwise.
    upright = followed.origins[rows]
    closure = replace(closure, of_phi1=switch.astype(float), of_fx=closure.of_fx + upright)
    line = knots.line[rows] & ~switch
    found = exact(knots.states.take(rows), line, chosen.height, closure)
    at[rows] = chosen.coordinates(found)
    return at[[part.first for part in parts]], at[[part.last for part in parts]]


class Cut(NamedTuple):
    """Pieces of one kind to be resolved, and guesses of their states at Chebyshev points."""

    pieces: Pieces
    guess: RodStates


def cuts(
    branches: Branches,
    followed: Followed,
    parts: list[Part],
    ends: tuple[FloatArray, FloatArray],
    section: RodSection,
    states: int,
) -> list[Cut]:
    """Put the parts of paths that have one kind of contact and of parameter together.

    Parameters
    ----------
    branches : Branches
    followed : Followed
    parts : list of Part
    ends : tuple of ndarray, shape (parts, 4)
        Coordinates of both ends of each part.
    section : RodSection
    states : int
        Number of states to guess along each piece.

    Returns
    -------
    list of Cut
        `Pieces.part` says which part each of them is.
    """
    if not parts:
        return []
    knots = followed.knots
    branch, first, last = (np.array([part[i] for part in parts]) for i in range(3))
    direction = np.array([part.direction for part in parts])
    by_x0 = np.array([part.parameter is Parameter.X0 for part in parts])
    some, line = branches.take(branch), knots.line[first]
    start, stop = (_value(some, at, direction, by_x0) for at in ends)
    start[by_x0 & followed.origins[first] & np.isfinite(start)] = 0.0
    stop[by_x0 & followed.origins[last] & np.isfinite(stop)] = 0.0
    known = np.isfinite(start) & np.isfinite(stop) & (stop > start)
    found = []
    for contact in Contact:
        for parameter in Parameter:
            kind = (line == (contact is Contact.LINE)) & (by_x0 == (parameter is Parameter.X0))
            rows = np.flatnonzero(kind & known)
            if not len(rows):
                continue
            pieces = Pieces(
                **some.take(rows).columns,
                contact=contact,
                parameter=parameter,
                part=rows,
                start=start[rows],
                length=(stop - start)[rows],
                direction=direction[rows],
                section=section,
            )
            guess = _guess(pieces, branches, knots, first[rows], last[rows], states)
            found.append(Cut(pieces, guess))
    return found


def _value(
    branches: Branches, at: FloatArray, direction: FloatArray, by_x0: BoolArray
) -> FloatArray:
    """Parameter at coordinates: the displacement, or the advance."""
    x0 = branches.displacement(-at[:, 0] * branches.scale)
    return np.where(by_x0, x0, np.vecdot(direction, at))


def _guess(
    pieces: Pieces, branches: Branches, knots: Knots, first: IntArray, last: IntArray, states: int
) -> RodStates:
    """Guess states at Chebyshev points by cubics between the knots and along their tangents."""
    some = branches.take(knots.branch)
    at = some.coordinates(knots.states)
    targets = pieces.value(chebyshev_nodes(states))
    low = np.empty(targets.shape, dtype=np.int64)
    value, slope = np.empty((2, *targets.shape, 2))
    by_x0 = pieces.parameter is Parameter.X0
    for k, (i, j) in enumerate(zip(first.tolist(), last.tolist(), strict=True)):
        own, way = some.take(slice(i, j + 1)), np.tile(pieces.direction[k], (j + 1 - i, 1))
        values = _value(own, at[i : j + 1], way, np.full(len(way), by_x0))
        slopes = np.vecdot(way, knots.direction[i : j + 1]) * (own.x0_unit if by_x0 else 1.0)
        place = np.clip(np.searchsorted(values, targets[:, k]) - 1, 0, j - i - 1)
        low[:, k] = i + place
        pair = place[:, None] + np.array([0, 1])
        value[:, k], slope[:, k] = values[pair], slopes[pair]
    return between(knots, np.stack([low, low + 1], -1), targets, value, slope)
