"""A scan that shares no code with the package: brute force on states of `reference`.

The rod is shot at Chebyshev points of x0. A slip goes from edge to edge of the surface: between two
edges the friction is one number, so that energies are antiderivatives of Chebyshev series, and the
first root of the balance is sought among many samples.
"""

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import Chebyshev
from scipy.optimize import brentq

import reference

NODES = 29
# Parts of the way from edge to edge at which the first root of a balance is bracketed.
SAMPLES = np.concatenate([np.geomspace(1e-8, 1e-3, 40), np.linspace(0.0025, 1.0, 400)])


@dataclass(frozen=True)
class Rod:
    """Forces on a rod in tip contact: p is the normal one, q holds the tip back where positive."""

    x1_init: float
    p: Chebyshev
    q: Chebyshev
    pull: float  # x0 at which p vanishes
    end: float

    @classmethod
    def solved(cls, theta, eta, first, low, high):
        """Rod from x0 = `low`, where p has vanished, to `high`; `first` is (phi1, p) at α = 0."""
        phi1, force = reference.solve_inclination(theta, eta, 0.0, first)
        x1_init = reference.shoot_from_contact(theta, phi1, force, 0.0)[0]
        middle, half = 0.5 * (low + high), 0.5 * (high - low)
        x0 = middle + half * np.polynomial.chebyshev.chebpts1(NODES)
        states = np.empty((NODES, 3))
        for side in (np.flatnonzero(x0 < 0.0)[::-1], np.flatnonzero(x0 >= 0.0)):
            known = [(0.0, np.array([phi1, force, 0.0]))]
            for i in side:
                guess = known[-1][1]
                if len(known) > 1:
                    (a, before), (b, last) = known[-2:]
                    guess = last + (last - before) * (x0[i] - b) / (b - a)
                states[i] = reference.solve_offset(theta, eta, x1_init - x0[i], guess)
                known.append((x0[i], states[i]))
        p, q = (Chebyshev.fit(x0, values, NODES - 1, domain=[low, high]) for values in states.T[1:])
        # The force on the rod is (q, -p) in `reference`.
        return cls(x1_init, p, -q, brentq(p, low, 0.0, xtol=1e-15), high)

    def demand(self, x0):
        return self.q(x0) / self.p(x0)


@dataclass(frozen=True)
class Scan:
    """Steps up to `outcome`: complete, lock (the tip sticks past the states known here) or lost."""

    outcome: str
    contact: np.ndarray
    period: np.ndarray
    slips: (
        np.ndarray
    )  # a row for each: x0 of the last step before it, clamp, x0 before, x0 after, mu


def scan(rod, edges, mu0, positions, law, ratio, zeta=0.0):
    """Move the clamp; friction is mu0[i] before edges[i], and mu0[-1] after the last edge."""
    contact, period = rod.x1_init, 1
    mu = mu0[np.searchsorted(edges, contact)]
    contacts, periods, slips = [], [], []
    x0_last = 0.0
    outcome = "complete"
    for clamp in positions:
        x0 = clamp - contact + rod.x1_init
        if x0 > rod.end:
            outcome = "lock"
            break
        if x0 <= rod.pull or abs(rod.demand(x0)) > mu:
            period += 1
            rest = slipped(rod, edges, mu0, clamp, max(x0, rod.pull), law, ratio, zeta)
            if rest is None:
                outcome = "lost"
                break
            x0_rest = clamp - rest[0] + rod.x1_init
            slips.append((x0_last, clamp, x0, x0_rest, mu))
            contact, mu = rest
            x0 = x0_rest
        x0_last = x0
        contacts.append(contact)
        periods.append(period)
    return Scan(outcome, np.array(contacts), np.array(periods), np.reshape(slips, (-1, 5)))


def onset(rod, x0_last, x0_slip, mu):
    """Where sticking ends between two steps, as x0."""
    if x0_slip <= rod.pull:
        x0_slip = rod.pull + 1e-13

    def left(x0):
        return mu - abs(rod.demand(x0))

    return brentq(left, x0_last, x0_slip, xtol=1e-15)


def slipped(rod, edges, mu0, clamp, x0, law, ratio, zeta):
    """Contact point after a slip and the friction there; None if the tip leaves the surface."""
    if law == "free":
        contact = clamp + rod.x1_init
        return contact, mu0[np.searchsorted(edges, contact)]
    while True:
        found = slid(rod, edges, mu0, clamp, x0, law, ratio, zeta)
        if found is None:
            return None
        x0, mu = found
        if abs(rod.demand(x0)) <= mu * (1 + 1e-9):
            return clamp - x0 + rod.x1_init, mu


def slid(rod, edges, mu0, clamp, x0, law, ratio, zeta):
    """Rest of a slide in one direction, as x0, and the friction there.

    By the laws energy (zeta = 0) and damped the tip stops where its energy has fallen to a part of
    the largest one so far.
    """
    down = x0 > 0  # x0 falls, the tip moves to greater x
    if law == "kinetic":
        goal = 0.0
    else:
        goal = rod.pull if down else rod.end
    marks = clamp + rod.x1_init - np.asarray(edges)
    inner = marks[(marks < x0) & (marks > goal)] if down else marks[(marks > x0) & (marks < goal)]
    inner = np.sort(inner)[::-1] if down else np.sort(inner)
    work, normal = rod.q.integ(), rod.p.integ()
    begin, energy, largest = x0, 0.0, 0.0
    taken = 1.0 - np.exp(-2.0 * np.pi * zeta)
    for end in [*inner, goal]:
        mu = mu0[np.searchsorted(edges, clamp + rod.x1_init - 0.5 * (begin + end))]

        def left(x, begin=begin, energy=energy, mu=mu):
            if law == "kinetic":
                return np.abs(rod.q(x)) - ratio * mu * rod.p(x)
            lost = ratio * mu * np.abs(normal(begin) - normal(x))
            return energy + work(begin) - work(x) - lost

        if law == "kinetic" and left(begin) <= 0:
            return begin, mu

        def net(x, mu=mu):
            return (1.0 if down else -1.0) * rod.q(x) - ratio * mu * rod.p(x)

        def above(x, level, left=left):
            return left(x) - level

        x = begin + (end - begin) * SAMPLES
        if law == "kinetic":
            level = np.zeros(len(x))
        else:
            # The tip is fastest, and its energy largest, where it is driven no longer.
            turns = np.flatnonzero((net(x[:-1]) > 0) & (net(x[1:]) <= 0))
            fastest = [brentq(net, x[i], x[i + 1], xtol=1e-15) for i in turns]
            x = np.insert(x, turns + 1, fastest)
            level = taken * np.maximum.accumulate(np.append(largest, left(x)))[1:]
        stops = np.flatnonzero((left(x) <= level) & (net(x) <= 1e-12))
        if len(stops):
            first = stops[0]
            before = begin if first == 0 else x[first - 1]
            if left(before) <= level[first]:
                return before, mu
            return brentq(above, before, x[first], args=(level[first],), xtol=1e-15), mu
        begin, energy, largest = end, left(end), max(largest, left(x).max())
    return None
