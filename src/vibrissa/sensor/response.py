"""The rod's response: what the clamp feels at every offset of the contact point, pulled or pushed.

The sticking curve begins at α = 0 and goes where the clamp pushes the tip (x0 > 0). Here it is
continued to where the clamp pulls (x0 < 0), up to the state in which the surface would have to
hold the tip (fy = 0), and tabulated, so that a scan of many steps costs next to nothing.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import CubicSpline, PPoly
from scipy.optimize import brentq

from vibrissa.api import EquilibriumState, solve_curve, solve_state
from vibrissa.arrays import FloatArray
from vibrissa.bending import strains
from vibrissa.curve import StickingCurve, StickingState
from vibrissa.spectral import chebyshev_nodes, chebyshev_transform
from vibrissa.status import Contact, Status

# Knots on each smooth piece of the curve; the spline between them is good to about 1e-9.
KNOTS = 641
# States solved on each smooth piece where the clamp pulls, and the error allowed between them.
PULL_NODES = 25
PULL_TOLERANCE = 1e-7
# A normal force below this is none (E·I0/L²).
TINY = 1e-9


class NoResponse(ValueError):
    """The rod has no sticking curve, or none where the clamp pulls."""


@dataclass(frozen=True, eq=False)
class Branch:
    """Clamp reactions over the footpoint displacement x0: all that a recording tells of the rod.

    Attributes
    ----------
    reactions : PPoly
        fx, fy (E·I0/L²) and m (E·I0/L) over x0, from where pulling ends to where pushing ends.
    x0_lock : float
        Displacement at which the tip locks (L).
    x1_init : float
        Contact point in the α = 0 state, from the clamp (L).
    bounds : ndarray
        Ends of the smooth stretches: where pulling ends, kinks, α = 0, the lock, the end (L).
    """

    reactions: PPoly
    x0_lock: float
    x1_init: float
    bounds: FloatArray

    @property
    def x0_pull(self) -> float:
        """Where pulling ends: the surface would have to hold the tip (L); 0 without pulling."""
        return float(self.reactions.x[0])

    @property
    def x0_end(self) -> float:
        """Where pushing ends (L)."""
        return float(self.reactions.x[-1])

    @property
    def mu_lock(self) -> float:
        """Largest friction at which a pushed tip slips; infinite where it lifts off instead."""
        fx, fy, _ = self.reactions(self.x0_lock)
        return float(fx / fy) if fy < -TINY else float("inf")

    def __call__(self, x0: ArrayLike) -> FloatArray:
        """Clamp reactions fx, fy and m at displacements on the branch, shape x0.shape + (3,)."""
        return np.asarray(self.reactions(x0))

    def slope(self, x0: ArrayLike) -> FloatArray:
        """Differentiate the clamp reactions with respect to x0, shape x0.shape + (3,)."""
        return np.asarray(self.reactions(x0, 1))

    def demand(self, x0: ArrayLike) -> FloatArray:
        """Friction coefficient −tan α that sticking needs; negative where the clamp pulls."""
        fx, fy, _ = np.moveaxis(self(x0), -1, 0)
        return np.asarray(fx / fy)

    def demand_slope(self, x0: ArrayLike) -> FloatArray:
        """Differentiate the demand with respect to the displacement (1/L)."""
        fx, fy, _ = np.moveaxis(self(x0), -1, 0)
        fx_slope, fy_slope, _ = np.moveaxis(self.slope(x0), -1, 0)
        return np.asarray((fx_slope * fy - fx * fy_slope) / fy**2)

    @cached_property
    def _work(self) -> PPoly:
        return self.reactions.antiderivative()

    def energy(self, x0: ArrayLike) -> FloatArray:
        """Bending energy above that of the α = 0 state (E·I0/L).

        Notes
        -----
        The tip held and the clamp moved by dx0, the clamp does the work −fx·dx0.
        """
        return np.asarray(self._work(0.0)[..., 0] - self._work(x0)[..., 0])

    def normal_path(self, x0: ArrayLike) -> FloatArray:
        """Integral of the normal force |fy| over x0 (E·I0/L)."""
        return np.asarray(-self._work(x0)[..., 1])


@dataclass(frozen=True, eq=False)
class Response(Branch):
    """Branch of one rod at one height, with the curve that it was tabulated from.

    Build one with `respond`.

    Attributes
    ----------
    curve : StickingCurve
        Where the clamp pushes.
    """

    curve: StickingCurve

    @cached_property
    def _ascent(self) -> tuple[FloatArray, FloatArray]:
        """Knots up to the lock, and the largest −tan α so far."""
        x = self.reactions.x
        x = np.append(x[(x >= 0.0) & (x < self.curve.x0_lock)], self.curve.x0_lock)
        with np.errstate(divide="ignore"):
            return x, np.maximum.accumulate(self.demand(x))

    @cached_property
    def _descent(self) -> tuple[FloatArray, FloatArray]:
        """Knots from 0 down to where pulling ends, and the largest tan α so far."""
        x = self.reactions.x[self.reactions.x <= 0.0][::-1]
        fx, fy, _ = self(x).T
        tan = np.divide(-fx, fy, out=np.full_like(fx, np.inf), where=fy < 0.0)
        return x, np.maximum.accumulate(tan)

    def push_limit(self, mu0: float) -> tuple[float, bool]:
        """Largest x0 up to which a pushed tip sticks, and whether it is past the lock (L)."""
        if mu0 > self.curve.mu_lock:
            _, state = self.curve.motion_end(mu0)
            end = float(state.x0[0])
            # Where the motion was not followed past the lock nothing is known beyond it.
            return (end if np.isfinite(end) else self.curve.x0_lock), True
        return self._crossing(*self._ascent, mu0, 1.0), False

    def pull_limit(self, mu0: float) -> float:
        """Least x0 down to which a pulled tip sticks (L); −infinity without pulling."""
        if self.x0_pull == 0.0:
            return -np.inf
        return self._crossing(*self._descent, mu0, -1.0)

    def _crossing(self, x: FloatArray, demand: FloatArray, mu0: float, sign: float) -> float:
        """First displacement at which the demand passes μ0."""
        after = int(np.clip(np.searchsorted(demand, mu0), 1, len(x) - 1))

        def excess(x0: float) -> float:
            fx, fy, _ = self.reactions(x0)
            return float(mu0 * fy - sign * fx)

        low, high = float(x[after - 1]), float(x[after])
        if excess(low) * excess(high) >= 0.0:  # a root at an end, up to rounding
            return low if abs(excess(low)) < abs(excess(high)) else high
        return float(brentq(excess, low, high, xtol=1e-14))


def respond(theta: float, eta: float, contact: str = Contact.POINT, pull: bool = True) -> Response:
    """Solve and tabulate the response of one rod at one height.

    Parameters
    ----------
    theta : float
        Taper factor, at least 1.
    eta : float
        Height of the contact point, 0 < eta < 1 (L).
    contact : str
        ``point`` or ``line``, as in `vibrissa.solve_state`.
    pull : bool
        Whether to continue the curve to where the clamp pulls.

    Returns
    -------
    Response

    Raises
    ------
    NoResponse
        If the curve was not solved, or not continued to where the clamp pulls.
    ValueError
        If an argument is out of range.
    """
    curve = solve_curve(theta, eta, contact=contact)
    if curve.status is not Status.SOLVED:
        raise NoResponse(f"the sticking curve is {curve.status}: {curve.message}")
    return tabulated(curve, _pulled(curve, contact) if pull else [])


def tabulated(curve: StickingCurve, pulled: Sequence[CubicSpline] = ()) -> Response:
    """Tabulate the response of a solved curve.

    Parameters
    ----------
    curve : StickingCurve
    pulled : sequence of CubicSpline
        Reactions where the clamp pulls, if they are known.

    Returns
    -------
    Response
    """
    parts = list(pulled)
    for piece in curve.pieces:
        # Counted by its own parameter: where x0 turns back the states crowd in x0.
        values = piece.at(np.linspace(piece.start, piece.stop, KNOTS))
        parts.append(CubicSpline(values[:, 0], values[:, 1:4]))
    joined = PPoly(
        np.concatenate([part.c for part in parts], axis=1),
        np.concatenate([part.x[:-1] for part in parts] + [parts[-1].x[-1:]]),
        extrapolate=False,
    )
    kinks = [b.x0[0] for a, b in pairwise(curve.pieces) if a.contact is not b.contact]
    ends = [part.x[0] for part in parts[: -len(curve.pieces)]]
    bounds = np.unique([*ends, 0.0, *kinks, curve.x0_lock, joined.x[-1]])
    return Response(joined, curve.x0_lock, curve.x1_init, bounds, curve)


def _pulled(curve: StickingCurve, contact: str) -> list[CubicSpline]:
    """Splines from where the surface would have to hold the tip to the α = 0 state."""

    def state(x0: float) -> EquilibriumState:
        found = solve_state(curve.theta, curve.eta, curve.x1_init - x0, contact)
        if found.status is not Status.SOLVED:
            raise NoResponse(f"pulling is not covered: at x0 = {x0:.6g} {found.message}")
        return found

    # A straight rod ends the search; before it the surface has to hold the tip.
    nearest = curve.x1_init - np.sqrt(1.0 - curve.eta**2)
    low = 0.0
    for fraction in np.linspace(0.05, 0.95, 19):
        low = fraction * nearest
        if state(low).reaction_fy >= 0.0:
            break
    else:
        raise NoResponse("pulling is not covered: the surface never has to hold the tip")
    end = float(brentq(lambda x0: state(x0).reaction_fy, low, 0.0, xtol=1e-13))
    bounds = [end, 0.0]
    lies, stands = 0.0, end
    if state(lies).s_c < 1.0 and state(stands).s_c == 1.0:
        # The rod rolls off until the tip alone touches: the reactions have a kink there.
        while lies - stands > 1e-10:
            middle = 0.5 * (lies + stands)
            lies, stands = (middle, stands) if state(middle).s_c < 1.0 else (lies, middle)
        bounds = [end, stands, 0.0]

    parts = []
    for start, stop in pairwise(bounds):
        nodes = start + (stop - start) * chebyshev_nodes(PULL_NODES)
        values = np.array([_reactions(state(float(x0))) for x0 in nodes])
        series = chebyshev_transform(PULL_NODES) @ values
        x = np.linspace(start, stop, KNOTS)

        def at(
            x0: ArrayLike,
            series: FloatArray = series,
            start: float = start,
            stop: float = stop,
        ) -> FloatArray:
            position = 2.0 * (np.asarray(x0) - start) / (stop - start) - 1.0
            return np.stack([np.polynomial.chebyshev.chebval(position, c) for c in series.T], -1)

        # Between the nodes the series must agree with states that it has not seen.
        for x0 in (nodes[:2].mean(), nodes[PULL_NODES // 2 :][:2].mean(), nodes[-2:].mean()):
            error = np.abs(at(x0) - _reactions(state(float(x0)))).max()
            if error > PULL_TOLERANCE * np.abs(values).max():
                raise NoResponse(f"pulling is not covered: not resolved at x0 = {x0:.6g}")
        parts.append(CubicSpline(x, at(x)))
    return parts


def _reactions(state: EquilibriumState) -> FloatArray:
    return np.array([state.reaction_fx, state.reaction_fy, state.reaction_m])


def largest_strain(theta: float, eta: float, x1: float, state: StickingState) -> float:
    """Largest strain |φ'|·d/2 at the surface of the rod in one state, in units of d0/L.

    Parameters
    ----------
    theta, eta : float
        Taper factor and height of the contact point (L).
    x1 : float
        Distance of the tip from the clamp (L).
    state : StickingState
        One state.

    Returns
    -------
    float
    """
    contact = x1 - (1.0 - state.s_c)
    values = (theta, state.f, state.alpha, contact, eta, state.s_c)
    return float(strains(*(np.array([float(value)]) for value in values))[0])
