"""States of a tapered rod by shooting, for a bench that shares no code with the package.

Axes are those of the stage: x along its motion, y normal to it, the clamp at the origin. The tip is
held at (dx, dy) by a force (fx, fy). The rod is integrated from its tip, where the moment is zero,
to the clamp, together with its derivatives with respect to slope and force at the tip. Newton's
method then fulfils the conditions at the clamp. Lengths are in units of L, forces in E·I0/L²,
moments in E·I0/L.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.polynomial import chebyshev
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline

RTOL, ATOL = 1e-12, 1e-14
# Newton's method ends at residuals below the first; a state is accepted below the second.
CONVERGED, SOLVED = 1e-13, 1e-11
NEWTON_STEPS = 25
# State from which all others are reached by continuation: θ = 2, dy = 0.85, force normal to the
# stage; its slope at the tip, fx and fy.
IDEAL_THETA, IDEAL_HEIGHT, IDEAL_STATE = 2.0, 0.85, (0.55, 0.0, -1.16)
# Tables: range of the ratio fx/fy that they cover, and numbers of nodes along dx and dy.
RATIOS = np.linspace(-0.36, 0.41, 16)
NODES, LEVELS = 32, 7
# Number of continuation steps from the known rod to another one.
PARTS = 3


class NoStateError(ValueError):
    """A rod has no state at a height, as with a ratio fx/fy at which it locks."""


@dataclass(frozen=True, kw_only=True)
class Rod:
    """A rod and its clamp, ideal by default.

    Attributes
    ----------
    theta : float
        Base over tip diameter.
    clamp_angle : float
        Angle by which the unloaded clamp leans back, against the motion of the stage (rad).
    compliance : float
        Rotation of the clamp per moment (L/(E·I0)).
    curvature : float
        Curvature of the unloaded rod (1/L); negative if it bends towards +x.
    radius : float
        Radius of a ball around the tip that rolls on the surface (L). Heights and dx are those of
        the point of contact, before the ball has rolled: dx is less by radius·slope at the tip.
    """

    theta: float = IDEAL_THETA
    clamp_angle: float = 0.0
    compliance: float = 0.0
    curvature: float = 0.0
    radius: float = 0.0


def shot(rod, slope, fx, fy):
    """Integrate n states of a rod from tip to clamp.

    Returns
    -------
    ndarray, shape (4, 4, n)
        First axis: dx, dy, error of the slope at the clamp, moment at the clamp. Second axis: the
        value, and its derivatives with respect to slope at the tip, fx and fy.
    """
    n = len(slope)
    start = np.zeros((4, 4, n))
    start[2, 0], start[2, 1] = slope, 1.0
    # The force acts below the centre of the ball: it has a moment there.
    start[3, 0], start[3, 2] = -rod.radius * fx, -rod.radius

    def derivative(from_tip, flat):
        state = flat.reshape(4, 4, n)
        _, _, phi, m = state
        stiffness = (1.0 + (1.0 / rod.theta - 1.0) * (1.0 - from_tip)) ** 4
        sine, cosine = np.sin(phi[0]), np.cos(phi[0])
        rate = np.empty_like(state)
        rate[0, 0], rate[0, 1:] = cosine, -sine * phi[1:]
        rate[1, 0], rate[1, 1:] = sine, cosine * phi[1:]
        rate[2] = -m / stiffness
        rate[2, 0] -= rod.curvature
        rate[3, 0] = fy * cosine - fx * sine
        rate[3, 1:] = -(fy * sine + fx * cosine) * phi[1:]
        rate[3, 2] -= sine
        rate[3, 3] += cosine
        return rate.ravel()

    found = solve_ivp(derivative, (0.0, 1.0), start.ravel(), method="DOP853", rtol=RTOL, atol=ATOL)
    end = found.y[:, -1].reshape(4, 4, n)
    end[0, 0] -= rod.radius * slope
    end[0, 1] -= rod.radius
    end[1, 0] += rod.radius
    end[2] -= rod.compliance * end[3]
    end[2, 0] -= 0.5 * np.pi + rod.clamp_angle
    return end


def solve(rod, dy, guess, *, dx=None, ratio=None):
    """Find n states at heights dy with tips at dx, or with fx = ratio·fy.

    Parameters
    ----------
    guess : ndarray, shape (3, n)
        Slope at the tip, fx, fy.

    Returns
    -------
    ndarray, shape (5, n)
        Slope at the tip, fx, fy, moment at the clamp, dx.
    """
    state = np.array(guess, dtype=float)
    for _ in range(NEWTON_STEPS):
        end = shot(rod, *state)
        rows = np.stack([end[1], end[2], end[0]])
        rows[0, 0] -= dy
        if ratio is None:
            rows[2, 0] -= dx
        else:
            rows[2] = 0.0
            rows[2, 0] = state[1] - ratio * state[2]
            rows[2, 2], rows[2, 3] = 1.0, -ratio
        misfit = rows[:, 0]
        if np.abs(misfit).max() < CONVERGED:
            break
        jacobian = np.moveaxis(rows[:, 1:], -1, 0)
        state -= np.linalg.solve(jacobian, misfit.T[..., None])[..., 0].T
    if not np.abs(misfit).max() < SOLVED:
        raise NoStateError(f"no state of {rod} at dy = {dy}")
    return np.concatenate([state, end[3, :1], end[0, :1]])


@dataclass(frozen=True, kw_only=True)
class States:
    """Load on the clamp as a polynomial of the tip's position.

    Attributes
    ----------
    low, high : ndarray, shape (2,)
        Bounds of dx and dy.
    coefficients : ndarray, shape (i, j, 3)
        Chebyshev coefficients of fx, fy and m.
    """

    low: np.ndarray
    high: np.ndarray
    coefficients: np.ndarray

    @classmethod
    def tabulated(cls, rod, lowest, highest):
        """Tabulate the states between two heights, with fx/fy in the range of `RATIOS`."""
        heights = np.array([0.5 * (lowest + highest)])
        if highest > lowest:
            heights = heights + 0.5 * (highest - lowest) * chebyshev.chebpts1(LEVELS)
        reached = _reached(rod, heights)
        low, high = reached[4, -1].min(), reached[4, 0].max()
        places = 0.5 * (low + high) + 0.5 * (high - low) * chebyshev.chebpts1(NODES)
        guess = [
            CubicSpline(one[4, ::-1], one[:3, ::-1].T)(places) for one in reached.T.swapaxes(1, 2)
        ]
        guess = np.stack(guess, axis=1).reshape(-1, 3).T
        dx, dy = np.repeat(places, len(heights)), np.tile(heights, NODES)
        loads = solve(rod, dy, guess, dx=dx)[1:4].T.reshape(NODES, len(heights), 3)
        along = _coefficients(NODES, loads.reshape(NODES, -1)).reshape(loads.shape)
        across = _coefficients(len(heights), np.moveaxis(along, 1, 0).reshape(len(heights), -1))
        coefficients = np.moveaxis(across.reshape(len(heights), NODES, 3), 0, 1)
        return cls(
            low=np.array([low, lowest]), high=np.array([high, highest]), coefficients=coefficients
        )

    def __call__(self, dx, dy):
        """Return the loads fx, fy, m for tips at (dx, dy), shape (..., 3)."""
        dx, dy = np.broadcast_arrays(np.asarray(dx, dtype=float), np.asarray(dy, dtype=float))
        if (dx < self.low[0]).any() or (dx > self.high[0]).any():
            raise ValueError("the tip is outside the tabulated states")
        x, y = (
            (2.0 * place - low - high) / max(high - low, 1e-300)
            for place, low, high in zip((dx, dy), self.low, self.high, strict=True)
        )
        if self.coefficients.shape[1] == 1:
            return np.moveaxis(chebyshev.chebval(x, self.coefficients[:, 0]), 0, -1)
        return np.moveaxis(chebyshev.chebval2d(x, y, self.coefficients), 0, -1)


def _coefficients(nodes, values):
    """Chebyshev coefficients of columns of values at `nodes` points of the first kind."""
    return np.linalg.solve(chebyshev.chebvander(chebyshev.chebpts1(nodes), nodes - 1), values)


@cache
def _known():
    """States of the known rod at the ratios `RATIOS`, shape (3, ratios)."""
    state, states = np.array(IDEAL_STATE)[:, None], []
    for ratio in RATIOS:
        state = solve(Rod(), IDEAL_HEIGHT, state[:3], ratio=ratio)
        states.append(state[:3, 0])
    return np.array(states).T


def _reached(rod, heights):
    """Return states at the ratios `RATIOS` and some heights, shape (5, ratios, heights)."""
    levels = len(heights)
    state, ratios = np.repeat(_known(), levels, axis=1), np.repeat(RATIOS, levels)
    for part in np.linspace(0.0, 1.0, PARTS + 1)[1:]:
        between = Rod(
            theta=IDEAL_THETA + part * (rod.theta - IDEAL_THETA),
            clamp_angle=part * rod.clamp_angle,
            compliance=part * rod.compliance,
            curvature=part * rod.curvature,
            radius=part * rod.radius,
        )
        height = IDEAL_HEIGHT + part * (np.tile(heights, len(RATIOS)) - IDEAL_HEIGHT)
        state = solve(between, height, state[:3], ratio=ratios)
    return state.reshape(5, len(RATIOS), levels)
