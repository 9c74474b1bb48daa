"""Admissible shapes stay between clamp and surface and do not cross themselves.

A state is rejected where the rod

- dips below the level of its clamp, where the sensor's housing is;
- crosses itself, which a plane model does not describe;
- crosses the surface away from its contact point, unless only its tip may touch the surface.

The paper's model, in which only the tip may touch, has shapes that pass through the surface: with
φ1 < 0 next to the tip, or as an arch. They are not rejected, but marked ``penetrates``. In line
contact of a curved rod, the *tail* beyond the contact point hangs free and may cross the rest of
the rod.
"""

from collections.abc import Collection
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.polynomial import legendre

from vibrissa.mechanics.equations import ends
from vibrissa.mechanics.mounting import Tail, polynomial, tail
from vibrissa.mechanics.states import RodStates
from vibrissa.numerics.arrays import BoolArray, FloatArray, IntArray
from vibrissa.numerics.batch import Batch, slices
from vibrissa.numerics.roots import bracketed_root
from vibrissa.numerics.spectral import gauss_rule, legendre_series
from vibrissa.outcomes import Contact

# Rounding error of a clearance (L): a shape is inadmissible if a clearance is below minus this.
CLEARANCE_TOLERANCE = 1e-12
# Slope (rad) up to which a tip counts as level. The part of the rod that then passes through the
# surface is far smaller than `CLEARANCE_TOLERANCE`.
LEVEL_SLOPE = 1e-9
# How much larger the slope may be between the nodes than at them (rad).
SLOPE_BETWEEN_NODES = 0.05
# Distance beyond which two parts of a shape are far from each other (L).
FAR_APART = 0.03
# Smallest slope (rad) at the nodes of a curved rod that excludes a negative slope between them.
POSITIVE_SLOPE = 0.002
# Fewest nodes on which a shape is examined closely.
FEWEST_CLOSE_NODES = 64
# Further places to examine, as distances (τ) from the tip: a curved rod may form arches there.
NEXT_TO_TIP = np.geomspace(1e-6, 0.03, 48)
# A rod must turn by more than half a circle to cross itself; one that turns by less than this (rad)
# is far from doing so.
HALF_TURN = np.pi - 0.3
# Step, in nodes, between the places that are compared to find where a rod comes near itself.
COMPARED_STRIDE = 2
# Number of rods whose places are compared together; the arrays fit into the cache.
COMPARED_AT_ONCE = 64
# Fractions of the tail at which its height is examined.
TAIL_FRACTIONS = np.linspace(0.0, 1.0, 17)[1:]
# Fractions of the tail that are compared to find where a rod comes near itself.
COMPARED_TAIL_FRACTIONS = np.linspace(0.0, 1.0, 65)[1:]
# Newton's search for the nearest parts of a rod: its largest number of steps, and the longest step.
NEWTON_STEPS, LONGEST_STEP = 12, 0.05
# Last step below which the search has converged, and step at which it stops (τ).
CONVERGED_STEP, ROUNDED_STEP = 1e-8, 1e-13

BELOW_CLAMP = "the rod dips below the level of its clamp"
CROSSES_SURFACE = "the rod crosses the surface away from its contact point"
CROSSES_ITSELF = "the rod crosses itself"


@dataclass(frozen=True, eq=False, kw_only=True)
class Clearance(Batch):
    """Clearances of n rods (L): negative where a shape is inadmissible.

    A clearance is infinite where the rod has no local minimum or maximum, or turns too little to
    meet itself.

    Attributes
    ----------
    start : ndarray, shape (n,)
        Sine of the slope at the clamp: a rod that yields so much that it is negative dips at once.
    clamp : ndarray, shape (n,)
        Height above the clamp of the rod's lowest local minimum, or of its tail beyond the contact
        point.
    surface : ndarray, shape (n,)
        Depth of the rod's highest local maximum below the surface; infinite if φ1 < 0 in tip
        contact. It is also negative where the tail beyond the contact point rises above the
        surface.
    itself : ndarray, shape (n,)
        Smallest distance between two parts of the rod; negative if they overlap.
    """

    start: FloatArray
    clamp: FloatArray
    surface: FloatArray
    itself: FloatArray

    @property
    def smallest(self) -> FloatArray:
        """Smallest of the clearances, shape (n,)."""
        return np.minimum.reduce([*self.columns.values()])

    def only(self, names: Collection[str]) -> Self:
        """Return these clearances, with all others infinite."""
        others = [name for name in self.names() if name not in names]
        return replace(self, **{name: np.full_like(self.start, np.inf) for name in others})

    def reasons(self, row: int) -> str:
        """State why the shape in a row is inadmissible; empty if it is admissible."""
        limits = {
            BELOW_CLAMP: np.minimum(self.start, self.clamp),
            CROSSES_SURFACE: self.surface,
            CROSSES_ITSELF: self.itself,
        }
        return "; ".join(reason for reason, c in limits.items() if c[row] < -CLEARANCE_TOLERANCE)


# Clearances that must not be negative in the two models of contact: where only the tip may touch
# the surface, the rest of the rod may pass through it.
ALL_CLEARANCES = ("start", "clamp", "surface", "itself")
LIMITING_CLEARANCES = {Contact.POINT: ("start", "clamp", "itself"), Contact.LINE: ALL_CLEARANCES}


def clearances(
    states: RodStates, eta: FloatArray, wanted: Collection[str] = ALL_CLEARANCES
) -> Clearance:
    """Measure how far rods are from their clamps, from their surfaces and from themselves.

    Parameters
    ----------
    eta : ndarray, shape (n,)
        Height of each rod's surface above its clamp (L).
    wanted : collection of str
        Names of the clearances that are needed; all others are infinite.
    """
    start, surface, clamp, itself = np.full((4, len(states)), np.inf)
    at_clamp = (
        states.natural_slope(np.zeros(1))[:, 0] + states.clamp_compliance * ends(states).moment
    )
    high = np.maximum(states.phi.max(axis=1), at_clamp)
    low = np.minimum(states.phi.min(axis=1), at_clamp)
    curved, curls = states.curvature.shape[1] > 0, np.zeros(len(states), dtype=bool)
    if "start" in wanted:
        start = np.sin(at_clamp)
    if curved:
        _, up, turn = _tail(states)
        lowest = np.minimum(low, turn.min(axis=1))
        curls = states.line & (np.maximum(high, turn.max(axis=1)) - lowest > HALF_TURN)
        # The tail is above the surface where it rises, or begins to rise.
        rises = np.maximum(up.max(axis=1), polynomial(states.curvature, states.s_c[:, None])[:, 0])
        if "surface" in wanted:
            surface = np.where(states.line & (rises > 0.0), -rises, np.inf)
        if "clamp" in wanted:
            clamp = np.where(states.line, eta + up.min(axis=1), np.inf)
    # Where the slope stays between 0 and π, the rod rises all the way: all clearances are large.
    rising = POSITIVE_SLOPE if curved else 0.0
    near = np.flatnonzero((high > np.pi - SLOPE_BETWEEN_NODES) | (low < rising) | curls)
    if len(near):
        some = states.take(near).on_nodes(max(FEWEST_CLOSE_NODES, 2 * states.nodes))
        shapes = _Shapes.of(some, with_tail=bool(curls.any()))
        if "clamp" in wanted:
            clamp[near] = np.minimum(clamp[near], shapes.extreme(lowest=True))
        if "surface" in wanted:
            # A rod whose tip passes through the surface has no arch.
            touches = np.flatnonzero(some.line | (ends(some).phi1 >= -LEVEL_SLOPE))
            arch = eta[near[touches]] - shapes.take(touches).extreme(lowest=False)
            surface[near[touches]] = np.minimum(surface[near[touches]], arch)
        if "itself" in wanted:
            itself[near] = shapes.gaps()
    return Clearance(start=start, clamp=clamp, surface=surface, itself=itself)


def _tail(states: RodStates) -> Tail:
    """Natural shapes of the tails beyond the contact points, at the fractions `TAIL_FRACTIONS`."""
    start = np.broadcast_to(states.s_c[:, None], (len(states), len(TAIL_FRACTIONS)))
    return tail(states.curvature, start, start + TAIL_FRACTIONS * (1.0 - start))


@dataclass(frozen=True, eq=False, kw_only=True)
class _Shapes(Batch):
    """Continuous shapes, as Legendre series in the bending coordinate.

    Attributes
    ----------
    slope, along, up : ndarray
        Coefficients of φ, dx/dτ and dy/dτ.
    curvature : ndarray, shape (n, k)
        Coefficients of κ0, which give the tails at 1 < τ ≤ 2; k = 0 if no tail is examined.
    """

    slope: FloatArray
    along: FloatArray
    up: FloatArray
    s_c: FloatArray
    curvature: FloatArray

    @classmethod
    def of(cls, states: RodStates, *, with_tail: bool) -> "_Shapes":
        rule = gauss_rule(states.nodes)
        density, _ = states.densities(rule.nodes)
        cos, sin = np.cos(states.phi), np.sin(states.phi)
        return cls(
            slope=states.phi @ rule.to_coefficients.T,
            along=(density * cos) @ rule.to_coefficients.T,
            up=(density * sin) @ rule.to_coefficients.T,
            s_c=states.s_c,
            curvature=states.curvature[:, : None if with_tail else 0],
        )

    @property
    def places(self) -> FloatArray:
        """Clamp, Gauss nodes in τ, and more places next to the tip."""
        nodes = gauss_rule(self.slope.shape[1]).nodes
        return np.sort(np.concatenate([[0.0], nodes, 1.0 - NEXT_TO_TIP]))

    @property
    def end(self) -> float:
        """Value of τ at the tip."""
        return 2.0 if self.curvature.shape[1] else 1.0

    def slopes(self, tau: FloatArray) -> FloatArray:
        """Slopes φ at places τ ≤ 1; shapes as in `at`."""
        values, _ = legendre_series(self.slope.shape[1], tau)
        return _summed(values, self.slope)

    def at(self, tau: FloatArray) -> "_Places":
        """Evaluate shapes at places τ.

        The shape of `tau` is (1, places) if the places are common to all, otherwise (n, places).
        """
        values, integrals = legendre_series(self.slope.shape[1], np.minimum(tau, 1.0))
        places = _Places(
            phi=_summed(values, self.slope),
            x=_summed(integrals, self.along),
            y=_summed(integrals, self.up),
        )
        if not self.curvature.shape[1]:
            return places
        start = self.s_c[:, None]
        s = start + np.maximum(tau - 1.0, 0.0) * (1.0 - start)
        along, up, turn = tail(self.curvature, np.broadcast_to(start, s.shape), s)
        return _Places(phi=places.phi + turn, x=places.x + along, y=places.y + up)

    def rates(self, tau: FloatArray) -> "_Rates":
        """Differentiate shapes with respect to τ at places; shapes as in `at`."""
        values, _ = legendre_series(self.slope.shape[1], np.minimum(tau, 1.0))
        bend = np.asarray(2.0 * legendre.legder(self.slope, axis=1), dtype=float)
        rates = _Rates(
            bend=_summed(values, bend),
            speed=np.hypot(_summed(values, self.along), _summed(values, self.up)),
        )
        if not self.curvature.shape[1]:
            return rates
        beyond, start, length = tau > 1.0, self.s_c[:, None], 1.0 - self.s_c[:, None]
        curvature = polynomial(self.curvature, start + np.maximum(tau - 1.0, 0.0) * length)
        return _Rates(
            bend=np.where(beyond, curvature * length, rates.bend),
            speed=np.where(beyond, length, rates.speed),
        )

    def steepness(self, tau: FloatArray, rows: IntArray) -> tuple[FloatArray, FloatArray]:
        """Evaluate sin φ and its derivative with respect to τ, at one place of each of `rows`."""
        some, at = self.take(rows), tau[:, None]
        phi = some.slopes(at)[:, 0]
        return np.sin(phi), np.cos(phi) * some.rates(at).bend[:, 0]

    def extreme(self, *, lowest: bool) -> FloatArray:
        """Height of the lowest local minimum, or highest maximum; ∞ or −∞ if there is none."""
        sign, tau = 1.0 if lowest else -1.0, self.places
        rise = sign * np.sin(self.slopes(tau[None]))
        # The height has a minimum, or a maximum, between two places.
        turns = (rise[:, :-1] < 0.0) & (rise[:, 1:] >= 0.0)
        rows = np.flatnonzero(turns.any(axis=1))
        found = np.full(len(self), sign * np.inf)
        if len(rows):
            turning, index = self.take(rows), np.arange(len(rows))
            height = sign * turning.at(tau[None]).y
            height = np.where(turns[rows], np.minimum(height[:, :-1], height[:, 1:]), np.inf)
            before = height.argmin(axis=1)
            at = bracketed_root(turning.steepness, tau[before], tau[before + 1], index)
            found[rows] = turning.at(at[:, None]).y[:, 0]
        return found

    def gaps(self) -> FloatArray:
        """Smallest distance between two parts of each shape; negative if they overlap.

        Only parts between which the rod turns by more than `HALF_TURN` are compared. If there are
        none, the distance is infinite.
        """
        tau = np.append(gauss_rule(self.slope.shape[1]).nodes[::COMPARED_STRIDE], 1.0)
        if self.curvature.shape[1]:
            tau = np.append(tau, 1.0 + COMPARED_TAIL_FRACTIONS)
        seen = self.at(tau[None])
        found, start = np.full(len(self), np.inf), np.zeros((len(self), 2))
        turning = np.flatnonzero(np.ptp(seen.phi, axis=1) > HALF_TURN)
        for part in slices(len(turning), COMPARED_AT_ONCE):
            some = seen.take(turning[part])
            low = np.flatnonzero(_turns_after(some.phi))
            high = np.flatnonzero(_turns_after(some.phi[:, ::-1])[::-1])
            phi, x, y = (
                values[:, None, high] - values[:, low, None]
                for values in (some.phi, some.x, some.y)
            )
            apart = (np.abs(phi) > HALF_TURN) & (high > low[:, None] + 1)
            square = np.where(apart, x**2 + y**2, np.inf).reshape(len(phi), -1)
            pair = square.argmin(axis=1)
            found[turning[part]] = np.sqrt(square.min(axis=1))
            one, other = np.divmod(pair, len(high))
            start[turning[part]] = np.stack([tau[low[one]], tau[high[other]]], axis=1)
        near = np.flatnonzero(found < FAR_APART)
        if len(near):
            close = self.take(near)
            exact = np.fmin(*(close.nearest(start[near], tip=tip) for tip in (False, True)))
            found[near] = np.where(np.isnan(exact), found[near], exact)
        return found

    def nearest(self, start: FloatArray, *, tip: bool) -> FloatArray:
        """Refine smallest distances between two parts by Newton's method; NaN where this fails.

        Each row of `start` has the places τ of the two parts, shape (n, 2). With `tip`, the second
        part stays at the tip.
        """
        tau = start.copy()
        if tip:
            tau[:, 1] = self.end
        for _ in range(NEWTON_STEPS):
            place, rates = self.at(tau), self.rates(tau)
            cos, sin = np.cos(place.phi), np.sin(place.phi)
            tangent, normal = np.stack([cos, sin], axis=-1), np.stack([-sin, cos], axis=-1)
            way = np.stack([np.diff(place.x)[:, 0], np.diff(place.y)[:, 0]], axis=-1)
            miss, lever = np.matvec(tangent, way), np.matvec(normal, way)
            matrix = tangent @ np.swapaxes(tangent, 1, 2) * (rates.speed * [-1.0, 1.0])[:, None]
            matrix[:, [0, 1], [0, 1]] += lever * rates.bend
            if tip:
                matrix[:, 1], miss[:, 1] = (0.0, 1.0), 0.0
            # Where the matrix is singular the parts are parallel: any step will do.
            step = np.matvec(np.linalg.pinv(matrix), miss)
            tau = np.clip(tau - np.clip(step, -LONGEST_STEP, LONGEST_STEP), 0.0, self.end)
            if (np.abs(step) < ROUNDED_STEP).all():
                break
        turn = place.phi[:, 1] - place.phi[:, 0]
        found = (np.abs(step).max(axis=1) < CONVERGED_STEP) & (np.abs(turn) > HALF_TURN)
        # Parts that cross have no distance: the sine of the angle measures how far they overlap.
        crosses = (np.hypot(*way.T) < CLEARANCE_TOLERANCE) & (tau.max(axis=1) < self.end)
        gap = np.where(crosses, -np.abs(np.sin(turn)), np.sign(turn) * lever[:, 0])
        return np.where(found, gap, np.nan)


@dataclass(frozen=True, eq=False, kw_only=True)
class _Places(Batch):
    """Shapes at some places: slope φ and position x, y; shape (n, places) each."""

    phi: FloatArray
    x: FloatArray
    y: FloatArray


@dataclass(frozen=True, eq=False, kw_only=True)
class _Rates(Batch):
    """Derivatives with respect to τ at some places: dφ/dτ and ds/dτ; shape (n, places) each."""

    bend: FloatArray
    speed: FloatArray


def _turns_after(phi: FloatArray) -> BoolArray:
    """Whether one of the rods turns by more than `HALF_TURN` between each place and a later one."""
    most = np.maximum.accumulate(phi[:, ::-1], axis=1)[:, ::-1]
    least = np.minimum.accumulate(phi[:, ::-1], axis=1)[:, ::-1]
    return np.asarray((np.maximum(most - phi, phi - least) > HALF_TURN).any(axis=0))


def _summed(basis: FloatArray, coefficients: FloatArray) -> FloatArray:
    """Sum series; the first axis of `basis` has the length 1 if all have the same places."""
    basis = basis[..., : coefficients.shape[1]]
    if len(basis) == 1:  # one matrix product
        return np.asarray(coefficients @ basis[0].T)
    return np.matvec(basis, coefficients)
