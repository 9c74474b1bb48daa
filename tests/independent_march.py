"""Paths of planar rods by shooting from the contact: shares no code and no rule with Vibrissa.

All rods of a batch march together. The rod is integrated from its contact point to its clamp with a
Runge-Kutta pair of order 8, in equal steps of the integral of 1/d². Derivatives are exact, by
complex steps. Only the guess of the first state is given.

Rules: a path ends where the normal force vanishes, where x0 turns back, or where the rod is lowest
between clamp and contact at the height of its clamp. A rod that turns by more than half a circle is
left there. Sticking ends at the first state with |fx| = -mu0·fy.
"""

from dataclasses import dataclass, field, replace

import numpy as np
from scipy.integrate._ivp import dop853_coefficients as pair

STEPS, STAGES = 28, 12
A, B, C = pair.A[:STAGES, :STAGES], pair.B, pair.C[:STAGES]


@dataclass
class Rods:
    """Parameters of n rods; `kappa` has the coefficients of the natural curvature, shape (n, k)."""

    theta: np.ndarray
    eta: np.ndarray
    beta: np.ndarray
    compliance: np.ndarray
    kappa: np.ndarray
    delta: np.ndarray
    x1: np.ndarray

    def take(self, rows):
        return Rods(*(value[rows] for value in vars(self).values()))


@dataclass
class Knot:
    """A state of a rod: kind of contact, its unknowns, the tangent of its path, x0 and its rate."""

    line: bool
    u: np.ndarray
    way: np.ndarray
    x0: float
    rate: float
    low: float
    crosses: bool

    @property
    def demand(self):
        return self.u[1] / self.u[2]

    @property
    def rise(self):
        return self.way[1] * self.u[2] - self.u[1] * self.way[2]


@dataclass
class Path:
    knots: list = field(default_factory=list)
    end: str = ""


def advance(rods, fx, fy, g, y, h):
    """One step of x, y, φ and m, of the length h in g = ∫ ds/d²."""
    k = 1.0 - 1.0 / rods.theta

    def slopes(g, y):
        d = 1.0 / (1.0 + k * g)
        s = g * d
        natural = np.zeros_like(s)
        for coefficient in rods.kappa.T[::-1]:
            natural = natural * s + coefficient
        sin, cos, square = np.sin(y[2]), np.cos(y[2]), d * d
        gradient = square * (fx * sin - fy * cos)
        return np.stack([square * cos, square * sin, y[3] / square + square * natural, gradient])

    stages = np.zeros((STAGES, *y.shape), dtype=y.dtype)
    for i in range(STAGES):
        at = y + h * np.tensordot(A[i, :i], stages[:i], 1)
        stages[i] = slopes(g + C[i] * h, at)
    return y + h * np.tensordot(B, stages, 1)


def integrated(rods, line, u):
    """Steps in g, and x, y, φ and m there: from the contact point, shape (steps + 1, 4, n)."""
    phi, s_c = np.where(line, 0.0, u[0]), np.where(line, u[0], 1.0)
    g = s_c / (1.0 - (1.0 - 1.0 / rods.theta) * s_c) * np.linspace(1.0, 0.0, STEPS + 1)[:, None]
    seen = [np.stack([0.0 * phi, 0.0 * phi, phi, 0.0 * phi]) + 0.0 * u.sum(axis=0)]
    for step in range(STEPS):
        seen.append(advance(rods, u[1], u[2], g[step], seen[-1], g[step + 1] - g[step]))
    return g, np.array(seen)


def closure(rods, line, u):
    """Offset x1 − x0, height, and excess of the slope at the clamp, shape (3, n)."""
    x, y, phi, m = integrated(rods, line, u)[1][-1]
    s_c = np.where(line, u[0], 1.0)
    return np.stack([1.0 - s_c - x, -y, phi - np.pi / 2 - rods.beta - rods.compliance * m])


def with_derivatives(rods, line, u):
    """Values of `closure`, shape (n, 3), and derivatives by the unknowns, shape (n, 3, 3)."""
    n, tiny = u.shape[1], 1e-30
    many = Rods(*(np.concatenate([value] * 3) for value in vars(rods).values()))
    moved = np.concatenate([u + 1j * tiny * np.eye(3)[i][:, None] for i in range(3)], axis=1)
    found = closure(many, np.tile(line, 3), moved)
    jacobian = found.imag.reshape(3, 3, n) / tiny
    return found.real[:, :n].T, np.moveaxis(jacobian, -1, 0)


def closed(rods, found, jacobian):
    """Equations of height and slope, and their derivatives."""
    tilt = np.tan(rods.delta)
    height = found[:, 1] - rods.eta + tilt * (rods.x1 - found[:, 0])
    rows = jacobian[:, 1] - tilt[:, None] * jacobian[:, 0]
    return np.stack([height, found[:, 2]], axis=1), np.stack([rows, jacobian[:, 2]], axis=1)


def solved(rods, line, u, weights, value, steps=7):
    """States with a given weighted sum of the unknowns; also whether Newton's method converged."""
    u = u.copy()
    for _ in range(steps):
        miss, rows = closed(rods, *with_derivatives(rods, line, u))
        miss = np.column_stack([miss, np.vecdot(weights, u.T) - value])
        matrix = np.concatenate([rows, weights[:, None]], axis=1)
        bad = ~(
            np.isfinite(matrix).all(axis=(1, 2))
            & (np.abs(np.linalg.det(np.where(np.isfinite(matrix), matrix, 0.0))) > 1e-300)
        )
        matrix[bad], miss[bad] = np.eye(3), 0.0
        change = np.linalg.solve(matrix, miss[..., None])[..., 0]
        u = u - change.T
        size = np.where(bad, np.inf, np.abs(change).max(axis=1))
        if size.max(initial=0.0) < 1e-10:
            break
    return u, size < 1e-9


def knots_of(rods, line, u, before):
    """Knots of states; tangents go on in the directions `before`."""
    found, jacobian = with_derivatives(rods, line, u)
    _, rows = closed(rods, found, jacobian)
    way = np.cross(rows[:, 0], rows[:, 1])
    way /= np.linalg.norm(way, axis=1, keepdims=True)
    way *= np.sign(np.vecdot(way, before))[:, None]
    cos = np.cos(rods.delta)
    x0 = (rods.x1 - found[:, 0]) / cos
    rate = -np.vecdot(jacobian[:, 0], way) / cos
    g, shape = integrated(rods, line, u)
    low = [lowest(rods.take([i]), u[:, [i]], g[:, [i]], shape[:, :, [i]]) for i in range(len(x0))]
    loops = [
        crosses(*shape[:, :2, i].T) if np.ptp(shape[:, 2, i]) > np.pi else False
        for i in range(len(x0))
    ]
    return [
        Knot(bool(line[i]), u[:, i], way[i], x0[i], rate[i], low[i], loops[i])
        for i in range(len(x0))
    ]


def crosses(x, y):
    """Whether two parts of a line of points cross."""
    i, j = np.triu_indices(len(x) - 1, 2)

    def side(a, b, c):
        return (x[b] - x[a]) * (y[c] - y[a]) - (y[b] - y[a]) * (x[c] - x[a])

    apart = (side(i, i + 1, j) * side(i, i + 1, j + 1) < 0) & (
        side(j, j + 1, i) * side(j, j + 1, i + 1) < 0
    )
    return bool(apart.any())


def lowest(rods, u, g, shape):
    """Height of the lowest point above the clamp; the sine of the slope there if it points down."""
    _, y, phi, _ = shape[:, :, 0].T
    rise = np.sin(phi)
    low = rise[-1] if rise[-1] < 0.0 else np.inf
    for i in np.flatnonzero((rise[:-1] > 0.0) & (rise[1:] <= 0.0)):
        h = g[i + 1] - g[i]
        way = [0.0, 1.0]
        for _ in range(44):
            part = sum(way) / 2
            at = advance(rods, u[1], u[2], g[i], shape[i], part * h)
            way[int(np.sin(at[2, 0]) <= 0.0)] = part
        low = min(low, at[1, 0] - y[-1])
    return float(low)


SCALE = np.array([1.0, 0.3, 0.1])


def march(rods, line, u, model):
    """Follow the paths of rods from states with α = 0; return a list of `Path`."""
    n = len(rods.theta)
    force = -u[2]
    unit = np.stack([np.ones(n), SCALE[1] / force, SCALE[2] / force], axis=1)
    level = replace(rods, delta=0.0 * rods.delta)
    u, good = solved(level, line, u, np.tile([0.0, 1.0, 0.0], (n, 1)), np.zeros(n))
    assert good.all()
    rods.x1 = closure(rods, line, u)[0]
    last = knots_of(rods, line, u, np.ones((n, 3)))
    for knot in last:
        sign = np.sign(knot.rate)
        knot.way, knot.rate = sign * knot.way, sign * knot.rate
    paths, step = [Path([knot]) for knot in last], np.full(n, 0.02)
    active = np.arange(n)
    for _ in range(400):
        if not len(active):
            break
        some, at = rods.take(active), [paths[i].knots[-1] for i in active]
        kind = np.array([knot.line for knot in at])
        start = np.stack([knot.u for knot in at], axis=1)
        way = np.stack([knot.way for knot in at])
        length = np.linalg.norm(way * unit[active], axis=1)
        guess = start + (step[active] / length * way.T)
        weights = way * unit[active] ** 2
        new, good = solved(some, kind, guess, weights, np.vecdot(weights, guess.T), 5)
        good &= np.linalg.norm((new - guess).T * unit[active], axis=1) < 0.4 * step[active]
        # In line contact s_c ≤ 1, in tip contact φ1 ≥ 0, if the rod may lie on the surface.
        over = good & (model == "line") & np.where(kind, new[0] > 1.0, new[0] < 0.0)
        edge = np.where(kind, 1.0, 0.0)
        part = (edge - start[0]) / (new[0] - start[0] + (new[0] == start[0]))
        if over.any():
            rows = np.flatnonzero(over)
            first = np.tile([1.0, 0.0, 0.0], (len(rows), 1))
            near = start[:, rows] + part[rows] * (new - start)[:, rows]
            new[:, rows], good[rows] = solved(some.take(rows), kind[rows], near, first, edge[rows])
        rows = np.flatnonzero(good)
        knots = knots_of(some.take(rows), kind[rows], new[:, rows], way[rows]) if len(rows) else []
        step[active] = np.where(good, np.minimum(1.4 * step[active], 0.1), 0.4 * step[active])
        for row, knot in zip(rows, knots, strict=True):
            i = active[row]
            path = paths[i]
            path.knots.append(knot)
            path.end = ended(knot)
            if path.end or not over[row]:
                continue
            other = np.array([not knot.line])
            start_u = np.array([[1.0 if other[0] else 0.0], *knot.u[1:, None]])
            (there,) = knots_of(rods.take([i]), other, start_u, np.array([[-1.0, 0, 0]]))
            # s_c falls after the kink, φ1 rises.
            if (there.way[0] > 0.0) == bool(other[0]):
                there.way, there.rate = -there.way, -there.rate
            path.knots.append(there)
            path.end = "snaps" if there.rate < 0.0 else ""
            step[i] = 0.02
        lost = [i for i in active if step[i] < 1e-6]
        for i in lost:
            paths[i].end = paths[i].end or "lost"
        active = np.array([i for i in active if not paths[i].end], dtype=int)
    return paths


def ended(knot):
    """Why a path ends in a knot; empty if it goes on."""
    if knot.u[2] >= 0.0:
        return "lifts_off"
    if knot.rate < 0.0:
        return "snaps"
    if knot.low < 0.0:
        return "dips"
    return "turns" if knot.crosses else ""


def located(rods, low, high, value):
    """Knots between pairs of knots in which a function of a knot changes its sign."""
    kind = np.array([knot.line for knot in low])
    first, second = (np.stack([knot.u for knot in some], axis=1) for some in (low, high))
    weights = np.stack([knot.way for knot in low])
    start = np.vecdot(weights, first.T)
    length = np.vecdot(weights, second.T) - start
    below, above = np.zeros(len(low)), np.ones(len(low))
    sign = np.array([value(knot) < 0.0 for knot in low])
    for _ in range(36):
        part = 0.5 * (below + above)
        guess = first + part * (second - first)
        u, good = solved(rods, kind, guess, weights, start + part * length, 8)
        assert good.all()
        found = knots_of(rods, kind, u, weights)
        before = np.array([value(knot) < 0.0 for knot in found]) == sign
        below, above = np.where(before, part, below), np.where(before, above, part)
    return found


def finish(rods, paths):
    """Cut paths at their ends, and add the knots in which the mobilised friction is extreme."""
    for end, value in (
        ("lifts_off", lambda knot: knot.u[2]),
        ("snaps", lambda knot: -knot.rate),
        ("dips", lambda knot: -knot.low),
    ):
        rows = [
            i
            for i, path in enumerate(paths)
            if path.end == end and path.knots[-2].line == path.knots[-1].line
        ]
        if rows:
            pairs = [paths[i].knots[-2:] for i in rows]
            for i, knot in zip(
                rows, located(rods.take(rows), *zip(*pairs, strict=True), value), strict=True
            ):
                paths[i].knots[-1] = knot
    places = []
    for i, path in enumerate(paths):
        for k, (a, b) in enumerate(zip(path.knots[:-1], path.knots[1:], strict=True)):
            if a.line == b.line and (a.rise > 0.0) != (b.rise > 0.0):
                places.append((i, k))
    if places:
        pairs = [(paths[i].knots[k], paths[i].knots[k + 1]) for i, k in places]
        rows = [i for i, _ in places]
        found = located(rods.take(rows), *zip(*pairs, strict=True), lambda knot: knot.rise)
        for (i, k), knot in reversed(list(zip(places, found, strict=True))):
            paths[i].knots.insert(k + 1, knot)
    return paths


def most(path):
    """Supremum of −tan α on a path, and x0 there."""
    if path.end == "lifts_off" and path.knots[-1].u[1] < 0.0:
        return np.inf, path.knots[-1].x0
    inner = path.knots[:-1] if path.end == "lifts_off" else path.knots
    top = max(inner, key=lambda knot: knot.demand)
    return top.demand, top.x0


def exits(rods, paths, mu0):
    """First exits from the friction cone: x0, and 1 forward, −1 back or 0 without an exit."""
    places = []
    for i, path in enumerate(paths):
        for a, b in zip(path.knots[:-1], path.knots[1:], strict=True):
            force = [way for way in (1.0, -1.0) if -way * b.u[1] + mu0[i] * b.u[2] > 0.0]
            if force:
                places.append((i, a, b, force[0]))
                break
    x0, way = np.full(len(paths), np.nan), np.zeros(len(paths))
    for i, a, b, out in places:
        kind, part = np.array([a.line]), 0.5
        weights = np.array([[0.0, out, -mu0[i]]])
        miss = [float(weights[0] @ knot.u) for knot in (a, b)]
        part = miss[0] / (miss[0] - miss[1])
        u, good = solved(rods.take([i]), kind, (a.u + part * (b.u - a.u))[:, None], weights, 0.0)
        at = (rods.x1[i] - closure(rods.take([i]), kind, u)[0, 0]) / np.cos(rods.delta[i])
        assert good.all() and a.x0 - 1e-9 <= at <= b.x0 + 1e-9
        x0[i], way[i] = at, out
    return x0, way
