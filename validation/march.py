"""Paths of rods by shooting from the contact point, marched for many rods in lockstep.

Equations and rules are those of docs/model.md and docs/mounting.md; no code of the solver is used.
A rod is integrated from its contact point to its clamp by the Runge-Kutta method of Dormand and
Prince of order 8, in equal steps of g = ∫ ds/d², so that steps are shorter towards the tip. The
unknowns are φ1 (in line contact s_c), fx and fy. Newton's method uses the derivatives of the
integrated rod, which are integrated with it. Only the first guess of the state with α = 0 is given.

Rods are planar, or round in the ideal mounting. In line contact the natural curvature is constant
or linear: then the part beyond the contact point is highest at one of its ends.
"""

from typing import NamedTuple

import numpy as np
from scipy.integrate._ivp import dop853_coefficients as pair

# Steps along a rod, and stages of a step.
STEPS, STAGES = 36, 12
# Further places at which heights are seen, next to both ends of a rod, as parts of the range of g.
# Where an arch or a dip next to an end begins to matter, it is three times as far from this end as
# the lowest or highest point between them.
NEXT_TO_END = np.geomspace(1e-5, 0.1, 20)
LOOKS = np.concatenate([NEXT_TO_END, 1.0 - NEXT_TO_END])
# Largest step along a path, in the scaled unknowns; scales of fx and fy relative to the force f.
STRIDE = 0.08
SCALES = (0.3, 0.1)
# Newton's method: most steps; change, relative to the unknowns, below which it has converged;
# change that leads to no state; determinant of a singular matrix.
NEWTON_STEPS, SMALL, LARGE, SINGULAR = 8, 1e-8, 1e3, 1e-200
# A step along a path is repeated with a smaller length if Newton's method changes its guess by more
# than NEAR times the length, or the path turns by an angle with a smaller cosine than STRAIGHT. The
# length changes by the factors; a path is given up below the shortest.
NEAR, STRAIGHT, LONGER, SHORTER, SHORTEST = 0.25, 0.9, 1.4, 0.4, 1e-7
# Most steps along a path.
MOST_STEPS = 600
# Root finding: part of the step along the path, and value, below which it has converged.
CLOSE, ZERO = 1e-12, 3e-14
# Value below which a margin tells that an end was passed, not reached.
PASSES = 1e-10
# Documented tolerance of heights in the rule that no arch may rise through the surface (L).
RISES = 1e-12

# Functions of a state that are negative beyond an end of the path, and the names of these ends.
ENDS = ("lifts", "snaps", "dips", "dips", "arch", "curved", "tail", "swings")
LIFTS, SNAPS, CLAMP_SLOPE, LOWEST, ARCH, CURVED, TAIL, SWINGS = range(8)
# A rod that crosses itself: noticed, but not located.
CROSSES = "crosses"
# A path that was not followed; a path with a margin below zero in its last state.
LOST, PASSED = "lost", "passed"


class Rods(NamedTuple):
    """Parameters of n rods; `kappa`, shape (n, k), has the coefficients of κ0."""

    theta: np.ndarray
    eta: np.ndarray
    beta: np.ndarray
    compliance: np.ndarray
    kappa: np.ndarray
    delta: np.ndarray
    lies: np.ndarray  # whether the rod may lie on the surface
    round: np.ndarray
    x1: np.ndarray

    def take(self, rows):
        """Return some of the rods."""
        return Rods(*(values[rows] for values in self))


class Shot(NamedTuple):
    """Integrated rods: offset, height and excess of the slope at the clamp, and derivatives.

    `values` has the shape (n, 3), `by` (n, 3, 3): derivatives of each value by the unknowns. `g`
    has the shape (steps + 1, n), and `nodes` (steps + 1, 4, n): x, y, φ and m, from the contact
    point, which is the origin, to the clamp.
    """

    values: np.ndarray
    by: np.ndarray
    g: np.ndarray
    nodes: np.ndarray

    def take(self, rows):
        """Return some of the rods."""
        return Shot(self.values[rows], self.by[rows], self.g[:, rows], self.nodes[..., rows])

    def put(self, rows, other):
        """Return the rods with some replaced by others."""
        new = Shot(*(part.copy() for part in self))
        new.values[rows], new.by[rows] = other.values, other.by
        new.g[:, rows], new.nodes[..., rows] = other.g, other.nodes
        return new


class Solved(NamedTuple):
    """Unknowns, shape (n, 3), integrated rods, and whether Newton's method converged."""

    u: np.ndarray
    shot: Shot
    good: np.ndarray


class States(NamedTuple):
    """States on the paths of n rods.

    `u` are the unknowns, shape (n, 3); `way` is the tangent of the path. `rise` has the sign of the
    derivative of −tan α along the path; `margins`, shape (n, 8), are negative beyond an end.
    """

    line: np.ndarray
    u: np.ndarray
    way: np.ndarray
    x0: np.ndarray
    rise: np.ndarray
    margins: np.ndarray
    crosses: np.ndarray

    @property
    def demand(self):
        """Mobilised friction −tan α."""
        return self.u[:, 1] / self.u[:, 2]

    def take(self, rows):
        """Return some of the states."""
        return States(*(values[rows] for values in self))

    def put(self, rows, others):
        """Return the states with some replaced by others."""
        new = [values.copy() for values in self]
        for values, other in zip(new, others, strict=True):
            values[rows] = other
        return States(*new)


def joined(parts):
    """Return states of several batches in one batch."""
    return States(*(np.concatenate(values) for values in zip(*parts, strict=True)))


def natural_curvature(kappa, s):
    """Evaluate the polynomials κ0, one of each rod at its own s."""
    value = np.zeros_like(s)
    for coefficient in kappa.T[::-1]:
        value = value * s + coefficient
    return value


def advance(rods, u, g, z, h):
    """Take one step h in g; `z` has x, y, φ, m and their derivatives, shape (1 or 4, 4, n)."""
    k = 1.0 - 1.0 / rods.theta
    fx, fy = u[:, 1], u[:, 2]
    stages = np.empty((STAGES, *z.shape))
    flat = stages.reshape(STAGES, -1)
    for i in range(STAGES):
        at = z + h * (pair.A[i, :i] @ flat[:i]).reshape(z.shape) if i else z
        to = g + pair.C[i] * h
        d = 1.0 / (1.0 + k * to)
        square, natural = d * d, natural_curvature(rods.kappa, to * d)
        sin, cos = square * np.sin(at[0, 2]), square * np.cos(at[0, 2])
        slope = stages[i]
        slope[0, 0], slope[0, 1] = cos, sin
        slope[:, 2] = at[:, 3] / square
        slope[0, 2] += square * natural
        slope[0, 3] = fx * sin - fy * cos
        if len(z) > 1:
            turn = at[1:, 2]
            slope[1:, 0], slope[1:, 1] = -sin * turn, cos * turn
            slope[1:, 3] = (fx * cos + fy * sin) * turn
            slope[2, 3] += sin
            slope[3, 3] -= cos
    return z + h * (pair.B @ flat).reshape(z.shape)


def shoot(rods, line, u):
    """Integrate rods from their contact points to their clamps."""
    n = len(u)
    phi, s_c = np.where(line, 0.0, u[:, 0]), np.where(line, u[:, 0], 1.0)
    natural = natural_curvature(rods.kappa, s_c)
    z = np.zeros((4, 4, n))
    z[0, 2] = phi
    # A contact point at a larger s_c: the shape as before, continued by the slopes there.
    z[1] = np.where(line, np.stack([-np.ones(n), np.zeros(n), -natural, u[:, 2]]), 0.0)
    z[1, 2] = np.where(line, z[1, 2], 1.0)
    first = s_c / (1.0 - (1.0 - 1.0 / rods.theta) * s_c)
    g = first * np.linspace(1.0, 0.0, STEPS + 1)[:, None]
    nodes = [z[0]]
    for step in range(STEPS):
        z = advance(rods, u, g[step], z, -first / STEPS)
        nodes.append(z[0])
    x, y, slope, m = z.swapaxes(0, 1)
    excess = slope - rods.compliance * m
    excess[0] -= np.pi / 2 + rods.beta
    x = -x
    x[0] += 1.0 - s_c
    x[1] -= line
    found = np.stack([x, -y, excess])
    by = np.ascontiguousarray(found[:, 1:].transpose(2, 0, 1))
    return Shot(found[:, 0].T.copy(), by, g, np.array(nodes))


def conditions(rods, shot):
    """Return the conditions of height and clamp, (M6) and (M3), and their derivatives."""
    tilt = np.tan(rods.delta)
    offset, height, excess = shot.values.T
    miss = np.stack([height - rods.eta + tilt * (rods.x1 - offset), excess], axis=1)
    by = np.stack([shot.by[:, 1] - tilt[:, None] * shot.by[:, 0], shot.by[:, 2]], axis=1)
    return miss, by


def solved(rods, line, u, weights, value):
    """Find states with a given weighted sum of the unknowns by Newton's method."""
    u, shot = u.copy(), shoot(rods, line, u)
    good, trying = np.zeros(len(u), dtype=bool), np.arange(len(u))
    for _ in range(NEWTON_STEPS):
        some = rods.take(trying)
        miss, by = conditions(some, shot.take(trying))
        weighted = np.vecdot(weights[trying], u[trying]) - value[trying]
        miss = np.column_stack([miss, weighted])
        matrix = np.concatenate([by, weights[trying, None]], axis=1)
        known = np.isfinite(matrix).all(axis=(1, 2)) & np.isfinite(miss).all(axis=1)
        matrix[~known] = np.eye(3)
        known &= np.abs(np.linalg.det(matrix)) > SINGULAR
        matrix[~known] = np.eye(3)
        change = np.linalg.solve(matrix, miss[..., None])[..., 0]
        size = np.abs(change).max(axis=1)
        known &= size < LARGE
        trying, size = trying[known], size[known]
        if not len(trying):
            break
        u[trying] -= change[known]
        shot = shot.put(trying, shoot(rods.take(trying), line[trying], u[trying]))
        # Convergence is quadratic: the error that is left is far smaller than the last change.
        good[trying] = size < SMALL * (1.0 + np.abs(u[trying]).max(axis=1))
        trying = trying[~good[trying]]
        if not len(trying):
            break
    return Solved(u, shot, good)


def states_of(rods, line, u, shot, before):
    """Return states; their tangents point along the directions `before`."""
    _, by = conditions(rods, shot)
    way = np.cross(by[:, 0], by[:, 1])
    way /= np.linalg.norm(way, axis=1, keepdims=True)
    way *= np.where(np.vecdot(way, before) < 0.0, -1.0, 1.0)[:, None]
    cos = np.cos(rods.delta)
    n = len(u)
    s_c = np.where(line, u[:, 0], 1.0)
    here = natural_curvature(rods.kappa, s_c)
    margins = np.full((n, len(ENDS)), np.inf)
    margins[:, LIFTS] = -u[:, 2]
    margins[:, SNAPS] = -np.vecdot(shot.by[:, 0], way) / cos
    margins[:, CLAMP_SLOPE] = np.sin(shot.nodes[-1, 2])
    look = seen(rods, u, shot)
    margins[:, LOWEST] = extreme(rods, u, look, 1.0) - shot.nodes[-1, 1]
    margins[rods.lies, ARCH] = RISES + extreme(rods, u, look, -1.0)[rods.lies]
    margins[line, CURVED] = -here[line]
    margins[line, TAIL] = RISES - tail_height(rods.kappa[line], s_c[line])
    margins[rods.round, SWINGS] = -shot.nodes[-1, 0, rods.round]
    return States(
        line=line,
        u=u,
        way=way,
        x0=(rods.x1 - shot.values[:, 0]) / cos,
        rise=way[:, 1] * u[:, 2] - u[:, 1] * way[:, 2],
        margins=margins,
        crosses=crossing(shot.nodes),
    )


def tail_height(kappa, s_c):
    """Height of the tips of unloaded parts above their beginnings, where they are horizontal."""
    nodes, weights = np.polynomial.legendre.leggauss(12)
    s = s_c[:, None] + (1.0 - s_c[:, None]) * (nodes + 1.0) / 2.0
    integral = kappa.T / np.arange(1, kappa.shape[1] + 1)[:, None]
    turn = sum(k[:, None] * (s**j - s_c[:, None] ** j) for j, k in enumerate(integral, 1))
    return (1.0 - s_c) * (np.sin(turn) @ weights) / 2.0


class Seen(NamedTuple):
    """Rods at many places: g, and x, y, φ and m, shape (places, 4, n), from contact to clamp."""

    g: np.ndarray
    nodes: np.ndarray


def seen(rods, u, shot):
    """Return rods at the nodes and at the further places next to their ends."""
    n, steps = len(u), len(shot.g) - 1
    before = np.floor(LOOKS * steps).astype(int)
    h = (shot.g[1] - shot.g[0]) * (LOOKS * steps - before)[:, None]
    begin = shot.nodes[before].transpose(1, 0, 2).reshape(1, 4, -1)
    many = rods.take(np.tile(np.arange(n), len(LOOKS)))
    u_many = np.tile(u, (len(LOOKS), 1))
    there = advance(many, u_many, shot.g[before].ravel(), begin, h.ravel())[0]
    there = there.reshape(4, len(LOOKS), n).transpose(1, 0, 2)
    order = np.argsort(np.concatenate([np.linspace(0.0, 1.0, steps + 1), LOOKS]), kind="stable")
    g = np.concatenate([shot.g, shot.g[before] + h])[order]
    return Seen(g, np.concatenate([shot.nodes, there])[order])


def extreme(rods, u, look, sign):
    """Least value of sign·y in inner minima of sign·y; infinite for rods without one."""
    rise, y = sign * np.sin(look.nodes[:, 2]), sign * look.nodes[:, 1]
    turns = (rise[:-1] > 0.0) & (rise[1:] <= 0.0)
    near = np.where(turns, np.minimum(y[:-1], y[1:]), np.inf)
    least = np.full(len(u), np.inf)
    rows = np.flatnonzero(turns.any(axis=0))
    if not len(rows):
        return least
    part = near[:, rows].argmin(axis=0)
    rods, u = rods.take(rows), u[rows]
    begin, g = look.nodes[part, :, rows].T[None], look.g[part, rows]
    h = look.g[part + 1, rows] - g
    low, high = np.zeros(len(rows)), np.ones(len(rows))
    share = rise[part, rows] / (rise[part, rows] - rise[part + 1, rows])
    for _ in range(40):
        at = advance(rods, u, g, begin, share * h)[0]
        value = sign * np.sin(at[2])
        low, high = np.where(value > 0.0, share, low), np.where(value > 0.0, high, share)
        d = 1.0 / (1.0 + (1.0 - 1.0 / rods.theta) * (g + share * h))
        natural = natural_curvature(rods.kappa, (g + share * h) * d)
        turn = (at[3] / d**2 + d**2 * natural) * h
        with np.errstate(all="ignore"):
            new = share - value / (sign * np.cos(at[2]) * turn)
        new = np.where((new >= low) & (new <= high), new, 0.5 * (low + high))
        moved, share = np.abs(new - share).max(), new
        # The height is stationary here.
        if moved < 1e-8:
            break
    least[rows] = sign * advance(rods, u, g, begin, share * h)[0, 1]
    return least


def crossing(nodes):
    """Whether the lines through the nodes cross themselves; coarse."""
    found = np.ptp(nodes[:, 2], axis=0) > np.pi
    i, j = np.triu_indices(len(nodes) - 1, 2)
    for row in np.flatnonzero(found):
        x, y = nodes[:, :2, row].T

        def side(a, b, c, x=x, y=y):
            return (x[b] - x[a]) * (y[c] - y[a]) - (y[b] - y[a]) * (x[c] - x[a])

        first = side(i, i + 1, j) * side(i, i + 1, j + 1) < 0
        found[row] = (first & (side(j, j + 1, i) * side(j, j + 1, i + 1) < 0)).any()
    return found


class Paths(NamedTuple):
    """Paths of rods: states in their order along each path, the rod of each state, and ends."""

    rods: Rods
    states: States
    of: np.ndarray
    ends: list

    def last(self, rod):
        """Index of the last state of a rod."""
        return np.searchsorted(self.of, rod, side="right") - 1

    def pairs(self):
        """Return indices of states that another state of the same rod and contact follows."""
        line = self.states.line
        return np.flatnonzero((self.of[:-1] == self.of[1:]) & (line[:-1] == line[1:]))


def first_states(rods, line, u):
    """Solve the states with α = 0, and set x1; the paths lead to larger x0."""
    n = len(u)
    across = np.tile([0.0, 1.0, 0.0], (n, 1))
    found = solved(rods._replace(delta=np.zeros(n)), line, u, across, np.zeros(n))
    rods = rods._replace(x1=found.shot.values[:, 0])
    states = states_of(rods, line, found.u, found.shot, np.ones((n, 3)))
    sign = np.where(states.margins[:, SNAPS] < 0.0, -1.0, 1.0)
    states = states_of(rods, line, found.u, found.shot, sign[:, None] * states.way)
    # A rod that may lie on the surface does so where φ1 < 0.
    wrong = rods.lies & ~line & (found.u[:, 0] < 0.0)
    inside = (states.margins >= 0.0).all(axis=1) & ~states.crosses
    return First(rods, states, found.good & ~wrong & inside)


class First(NamedTuple):
    """Rods with their x1, states with α = 0, and whether these are admissible states."""

    rods: Rods
    states: States
    good: np.ndarray


def units(u):
    """Return what the unknowns are multiplied with, so that a step changes all of them alike.

    The force is that of the state itself: where a rod leans towards the surface, it can be small
    at α = 0.
    """
    force = np.hypot(u[:, 1], u[:, 2])
    return np.stack([np.ones(len(u)), *(scale / force for scale in SCALES)], axis=1)


class Step(NamedTuple):
    """Rods, by index, for which a next state was found; whether their contact changes there."""

    rows: np.ndarray
    states: States
    kink: np.ndarray


def next_states(rods, at, length):
    """Go one step along the paths, or to the change of contact if this is nearer."""
    unit = units(at.u)
    norm = np.linalg.norm(at.way * unit, axis=1)
    guess = at.u + (length / norm)[:, None] * at.way
    weights = at.way * unit**2
    u, shot, good = solved(rods, at.line, guess, weights, np.vecdot(weights, guess))
    good &= np.linalg.norm((u - guess) * unit, axis=1) < NEAR * length
    # In line contact s_c ≤ 1; a rod that may lie on the surface does so where φ1 < 0.
    over = good & np.where(at.line, u[:, 0] > 1.0, rods.lies & (u[:, 0] < 0.0))
    rows = np.flatnonzero(over)
    if len(rows):
        edge = np.where(at.line, 1.0, 0.0)[rows]
        change = (u - at.u)[rows]
        near = at.u[rows] + ((edge - at.u[rows, 0]) / change[:, 0])[:, None] * change
        first = np.tile([1.0, 0.0, 0.0], (len(rows), 1))
        there = solved(rods.take(rows), at.line[rows], near, first, edge)
        u[rows], good[rows], shot = there.u, there.good, shot.put(rows, there.shot)
    rows = np.flatnonzero(good)
    states = states_of(rods.take(rows), at.line[rows], u[rows], shot.take(rows), at.way[rows])
    cos = np.vecdot(states.way * unit[rows], at.way[rows] * unit[rows])
    cos /= np.linalg.norm(states.way * unit[rows], axis=1) * norm[rows]
    straight = cos > STRAIGHT
    return Step(rows[straight], states.take(straight), over[rows[straight]])


def march(rods, line, u):
    """Follow paths from guesses of the states with α = 0 to their ends, and locate these."""
    rods, last, good = first_states(rods, line, u)
    n = len(u)
    parts, of, ends = [last], [np.arange(n)], np.where(good, "", LOST).astype(object)
    length, active = np.full(n, STRIDE / 4), np.flatnonzero(good)
    for _ in range(MOST_STEPS):
        if not len(active):
            break
        step = next_states(rods.take(active), last.take(active), length[active])
        found, shorter = active[step.rows], np.delete(active, step.rows)
        length[found] = np.minimum(LONGER * length[found], STRIDE)
        length[shorter] *= SHORTER
        parts.append(step.states)
        of.append(found)
        last = last.put(found, step.states)
        passed = (step.states.margins < 0.0).any(axis=1)
        ends[found[step.states.crosses]] = CROSSES
        ends[found[passed]] = PASSED
        ends[active[length[active] < SHORTEST]] = LOST
        kinks = found[step.kink & (ends[found] == "")]
        if len(kinks):
            there = other_side(rods.take(kinks), last.take(kinks))
            parts.append(there)
            of.append(kinks)
            last = last.put(kinks, there)
            length[kinks] = STRIDE / 4
            for row in np.flatnonzero((there.margins < 0.0).any(axis=1)):
                ends[kinks[row]] = ENDS[int((there.margins[row] < 0.0).argmax())]
        active = active[ends[active] == ""]
    ends[active] = LOST
    order = np.argsort(np.concatenate(of), kind="stable")
    paths = Paths(rods, joined(parts).take(order), np.concatenate(of)[order], ends.tolist())
    return with_peaks(with_ends(paths))


def other_side(rods, states):
    """Return states at a change of contact in the other kind of contact, and where they lead."""
    line = ~states.line
    u = np.column_stack([np.where(line, 1.0, 0.0), states.u[:, 1:]])
    shot = shoot(rods, line, u)
    # s_c falls, and φ1 rises.
    leads = np.where(line, -1.0, 1.0)[:, None] * np.array([1.0, 0.0, 0.0])
    return states_of(rods, line, u, shot, leads)


def located(rods, first, second, value):
    """Return states between others in which a function of states changes its sign.

    `value(states, rows)` is positive in the first states. Regula falsi (Illinois), and bisection in
    every fourth trial.
    """
    weights = first.way * units(first.u) ** 2
    start = np.vecdot(weights, first.u)
    length = np.vecdot(weights, second.u) - start
    trying = np.arange(len(start))
    low, high = np.zeros(len(start)), np.ones(len(start))
    at_low, at_high = value(first, trying), value(second, trying)
    side, found = np.zeros(len(start)), second
    for trial in range(80):
        if not len(trying):
            break
        a, b, fa, fb = low[trying], high[trying], at_low[trying], at_high[trying]
        with np.errstate(all="ignore"):
            share = a + (b - a) * fa / (fa - fb)
        halve = ~((share > a) & (share < b)) | (trial % 4 == 3)
        share = np.where(halve, 0.5 * (a + b), share)
        some, kind, from_here = rods.take(trying), first.line[trying], first.u[trying]
        guess = from_here + share[:, None] * (second.u[trying] - from_here)
        aim = start[trying] + share * length[trying]
        u, shot, good = solved(some, kind, guess, weights[trying], aim)
        if not good.all():
            raise ArithmeticError("no state was found between two states of a path")
        states = states_of(some, kind, u, shot, first.way[trying])
        found = found.put(trying, states)
        here = value(states, trying)
        # An end that stays twice counts half.
        now = np.where(here > 0.0, 1.0, -1.0)
        again = np.where(now == side[trying], 0.5, 1.0)
        low[trying], high[trying] = np.where(here > 0.0, share, a), np.where(here > 0.0, b, share)
        at_low[trying] = np.where(here > 0.0, here, again * fa)
        at_high[trying] = np.where(here > 0.0, again * fb, here)
        side[trying] = now
        trying = trying[(np.abs(here) > ZERO) & (high[trying] - low[trying] > CLOSE)]
    return found


def with_ends(paths):
    """Return paths that end where the first margin vanishes."""
    states, ends = paths.states, list(paths.ends)
    rods = np.array([i for i, end in enumerate(ends) if end == PASSED], dtype=int)
    least = 0.0
    while len(rods):
        last = paths.last(rods)
        which, kind = np.nonzero(states.margins[last] < least)
        first, second = states.take(last[which] - 1), states.take(last[which])
        found = located(
            paths.rods.take(rods[which]),
            first,
            second,
            lambda states, rows, kind=kind: states.margins[np.arange(len(rows)), kind[rows]],
        )
        far = np.vecdot(first.way, found.u - first.u)
        for row in np.unique(which):
            mine = np.flatnonzero(which == row)
            nearest = mine[far[mine].argmin()]
            states = states.put(last[[row]], found.take([nearest]))
            ends[rods[row]] = ENDS[kind[nearest]]
        # A margin may be below zero between two states alone: it shows where another one vanishes.
        least = -PASSES
        rods = rods[(states.margins[last] < least).any(axis=1)]
    return paths._replace(states=states, ends=ends)


def with_peaks(paths):
    """Return paths with the states in which the mobilised friction is extreme."""
    states, before = paths.states, paths.pairs()
    before = before[(states.rise[before] > 0.0) != (states.rise[before + 1] > 0.0)]
    if not len(before):
        return paths
    of, sign = paths.of[before], np.where(states.rise[before] > 0.0, 1.0, -1.0)
    found = located(
        paths.rods.take(of),
        states.take(before),
        states.take(before + 1),
        lambda states, rows: sign[rows] * states.rise,
    )
    order = np.argsort(np.append(np.arange(len(paths.of)), before + 0.5), kind="stable")
    return paths._replace(
        states=joined([states, found]).take(order), of=np.append(paths.of, of)[order]
    )


def largest_demand(paths, rod):
    """Largest −tan α on a path: infinite where the normal force vanishes at α < 0.

    NaN if the shape becomes inadmissible while −tan α is larger than before.
    """
    end, last = paths.ends[rod], paths.last(rod)
    demand = paths.states.demand[np.searchsorted(paths.of, rod) : last + 1]
    if end == "lifts":
        return np.inf if paths.states.u[last, 1] < 0.0 else demand[:-1].max()
    largest = demand.max()
    return largest if end in ("snaps", "swings") or demand[-1] < largest else np.nan


class Exits(NamedTuple):
    """First states out of the friction cone: x0, and 1 forward, −1 back or 0 if there is none."""

    x0: np.ndarray
    way: np.ndarray


def exits(paths, of, mu0):
    """Return where tips of rods with the indices `of` begin to slip with friction `mu0`."""
    fx, fy = paths.states.u[:, 1], paths.states.u[:, 2]
    x0, way, after = np.full(len(of), np.nan), np.zeros(len(of)), np.zeros(len(of), dtype=int)
    for row, (rod, friction) in enumerate(zip(of, mu0, strict=True)):
        part = slice(np.searchsorted(paths.of, rod), paths.last(rod) + 1)
        out = np.flatnonzero(np.abs(fx[part]) + friction * fy[part] > 0.0)
        if len(out):
            after[row] = part.start + out[0]
            way[row] = -np.sign(fx[after[row]])
    rows = np.flatnonzero(way)
    if not len(rows):
        return Exits(x0, way)
    first, second = (paths.states.take(after[rows] - back) for back in (1, 0))
    rods = paths.rods.take(of[rows])
    weights = np.column_stack([0.0 * rows, way[rows], -mu0[rows]])
    miss, beyond = np.vecdot(weights, first.u), np.vecdot(weights, second.u)
    guess = first.u + (miss / (miss - beyond))[:, None] * (second.u - first.u)
    _, shot, good = solved(rods, first.line, guess, weights, 0.0 * miss)
    at = (rods.x1 - shot.values[:, 0]) / np.cos(rods.delta)
    good &= (at > first.x0 - 1e-9) & (at < second.x0 + 1e-9)
    x0[rows] = np.where(good, at, np.inf)
    return Exits(x0, way)
