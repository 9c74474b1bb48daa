"""A tip that sticks at one place: clamp positions between which it sticks, and its end."""

from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq, minimize_scalar

from vibrissa.numerics.arrays import FloatArray
from vibrissa.sensor.response.branch import Response
from vibrissa.sensor.stage import Stage

# Clamp positions at which a period is looked at, before its end is sought between two of them.
LOOKS = 257


class Exit(StrEnum):
    """Reason why a period of sticking ends.

    Attributes
    ----------
    FORWARD, BACKWARD
        The friction that holds a pushed tip, or a pulled one.
    END, PULL
        The equilibrium: pushing ends, or the normal force of a pulled tip vanishes.
    """

    FORWARD = "forward"
    BACKWARD = "backward"
    END = "end"
    PULL = "pull"


@dataclass(frozen=True, kw_only=True)
class Tip:
    """A tip that sticks at one place.

    Attributes
    ----------
    contact, mu0 : float
        Position on the surface (L), and static friction there.
    """

    stage: Stage
    contact: float
    mu0: float
    side: int = 1

    def reserves(self, clamp: ArrayLike) -> FloatArray:
        """Margins of sticking at clamp positions, in the order of `Exit`.

        Margins of the friction forward and backward, distances to both ends of the states (L);
        negative where the tip does not stick.
        """
        states, x0 = self.stage.states(clamp, self.contact, self.side)
        with np.errstate(divide="ignore"):
            demand = states.demand(states.clip(x0))
        return np.array(
            [self.mu0 - demand, self.mu0 + demand, states.x0_end - x0, x0 - states.x0_pull]
        )

    def exit(self, clamp: float) -> Exit:
        """Margin that ends a period of sticking."""
        return list(Exit)[int(np.argmin(self.reserves(clamp)))]

    def interval(self, begin: float, least: float, most: float) -> tuple[float, float]:
        """Clamp positions between which a tip that sticks at `begin` goes on sticking (L).

        They are sought from `least` to `most`, and infinite if sticking does not end there.
        """
        response = self.stage.rod
        if isinstance(response, Response):
            # As exact as the equilibrium path: a step that ends on the onset of slip sticks.
            x0 = np.array([response.pull_limit(self.mu0), response.push_limit(self.mu0)[0]])
            low, high = np.sort(self.contact + self.side * (x0 - response.x1_init)).tolist()
            return low, high
        return (
            self._limit(begin, min(begin, least), -1.0),
            self._limit(begin, max(begin, most), 1.0),
        )

    def _limit(self, begin: float, end: float, way: float) -> float:
        """Where sticking ends as the clamp goes to a position, one way; infinite if nowhere."""
        states, _ = self.stage.states(begin, self.contact, self.side)
        stretch = way * float(states.x0_end - states.x0_pull)
        while begin != end:
            until = begin + stretch if abs(stretch) < abs(end - begin) else end
            clamp, left = self._looked(np.linspace(begin, until, LOOKS))
            out = np.flatnonzero(left[1:] <= 0.0)
            if len(out):
                before, after = clamp[out[0]], clamp[out[0] + 1]
                # It may begin at the end of what it can stick to, up to rounding.
                if left[out[0]] <= 0.0:
                    return float(before)
                return float(brentq(self._least_reserve, before, after, xtol=1e-14))
            begin = until
        return way * np.inf

    def _looked(self, clamp: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Margins at clamp positions, and at minima between them that may be below zero."""
        left = self._least_reserve(clamp)
        inner = left[1:-1]
        falls = np.maximum(left[:-2] - inner, left[2:] - inner)
        lowest = (inner <= left[:-2]) & (inner <= left[2:]) & (inner < falls)
        for i in np.flatnonzero(lowest) + 1:
            bounds = sorted((clamp[i - 1], clamp[i + 1]))
            found = minimize_scalar(self._least_reserve, bounds=bounds, method="bounded")
            clamp, left = np.append(clamp, found.x), np.append(left, found.fun)
        order = np.argsort(np.abs(clamp - clamp[0]))
        return clamp[order], left[order]

    def _least_reserve(self, clamp: ArrayLike) -> FloatArray:
        return np.asarray(self.reserves(clamp).min(axis=0))
