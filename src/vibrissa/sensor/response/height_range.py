"""One rod at all heights of a range, interpolated to `EXACT`: for an oblique stage."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from vibrissa.errors import NoResponseError
from vibrissa.mechanics.mounting import IDEAL, Mounting
from vibrissa.numerics.arrays import FloatArray, IntArray
from vibrissa.outcomes import Contact, RodSection
from vibrissa.sensor.response.branch import TINY, Branch, States
from vibrissa.sensor.response.heights import Heights, Solve, interpolated, solver

# Error of the reactions between the heights that are solved, of the largest reaction.
EXACT = 1e-8
# Widest and narrowest part of a range, and the least and the largest height (L).
WIDEST, NARROWEST = 0.05, 2e-4
LOWEST, HIGHEST = 0.02, 0.9999
# Points that are evaluated together.
BLOCK = 65536
# Gauss points of the work along a branch.
WORK = np.polynomial.legendre.leggauss(24)


@dataclass(frozen=True, eq=False, kw_only=True)
class HeightRange:
    """Branches of one rod over a range of heights, part by part.

    Attributes
    ----------
    parts : tuple of Heights
        From low to high, each beginning where the one before ends.
    below, above : str
        Why the range ends before the requested heights; empty where it does not.
    """

    parts: tuple[Heights, ...]
    below: str
    above: str

    @property
    def low(self) -> float:
        """Least height (L)."""
        return self.parts[0].low

    @property
    def high(self) -> float:
        """Largest height (L)."""
        return self.parts[-1].high

    @property
    def swings(self) -> bool:
        """Whether a tip that locks is dragged in the end; see `Branch`."""
        return all(part.branches[0].swings for part in self.parts)

    def part_of(self, eta: ArrayLike) -> IntArray:
        """Find the number of the part in which each height lies."""
        inner = [part.low for part in self.parts[1:]]
        return np.asarray(np.searchsorted(inner, eta, side="right"))

    def at(self, eta: float) -> Branch:
        """Interpolate the branch at a height of the range."""
        return self.parts[int(self.part_of(eta))].at(eta)

    def states(self, eta: ArrayLike) -> "HeightStates":
        """States at heights, which are clipped to the range."""
        return HeightStates(heights=self, eta=np.clip(eta, self.low, self.high))


@dataclass(frozen=True, eq=False, kw_only=True)
class HeightStates(States):
    """States of a rod, one height for each displacement.

    Attributes
    ----------
    eta : ndarray
        Heights (L).
    """

    heights: HeightRange
    eta: FloatArray

    @cached_property
    def _landmarks(self) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """End of pulling, lock, end and x1_init, each of the shape of the heights (L)."""
        flat = self.eta.ravel()
        found = np.empty((4, len(flat)))
        of = self.heights.part_of(flat)
        for number, part in enumerate(self.heights.parts):
            on = np.flatnonzero(of == number)
            if len(on):
                found[:, on] = part.landmarks(flat[on])[:, [0, part.lock, -2, -1]].T
        pull, lock, end, x1_init = found.reshape(4, *self.eta.shape)
        return pull, lock, end, x1_init

    @property
    def x0_pull(self) -> FloatArray:
        """Where pulling ends (L); 0 without pulling."""
        return self._landmarks[0]

    @property
    def x0_lock(self) -> FloatArray:
        """Where −tan α is largest at this height (L)."""
        return self._landmarks[1]

    @property
    def x0_end(self) -> FloatArray:
        """Where pushing ends (L)."""
        return self._landmarks[2]

    @property
    def x1_init(self) -> FloatArray:
        """Contact point in the α = 0 state, from the clamp (L)."""
        return self._landmarks[3]

    @property
    def mu_lock(self) -> FloatArray:
        """Largest friction at which a pushed tip slips at this height."""
        fx, fy, _ = np.moveaxis(self(self.x0_lock), -1, 0)
        return np.divide(fx, fy, out=np.full_like(fx, np.inf), where=fy < -TINY)

    def __call__(self, x0: ArrayLike) -> FloatArray:
        """Clamp reactions fx, fy and m, shape x0.shape + (3,)."""
        return self._reactions(x0, 0)

    def slope(self, x0: ArrayLike) -> FloatArray:
        """Differentiate the clamp reactions with respect to x0, shape x0.shape + (3,)."""
        return self._reactions(x0, 1)

    def clip(self, x0: ArrayLike) -> FloatArray:
        """Nearest displacements that are known (L)."""
        return np.clip(x0, self.x0_pull, self.x0_end)

    def _reactions(self, x0: ArrayLike, order: int) -> FloatArray:
        x0 = np.asarray(x0, dtype=float)
        flat, eta = x0.ravel(), self.eta.ravel()
        found, of = np.empty((len(flat), 3)), self.heights.part_of(eta)
        for number, part in enumerate(self.heights.parts):
            on = np.flatnonzero(of == number)
            for start in range(0, len(on), BLOCK):
                some = on[start : start + BLOCK]
                found[some] = part.reactions(flat[some], eta[some], order)
        return found.reshape(*x0.shape, 3)

    def energy(self, x0: ArrayLike) -> FloatArray:
        """Bending energy above that of the α = 0 state of this height (E·I0/L)."""
        x0, (nodes, weights) = np.asarray(x0, dtype=float), WORK
        force = [self(0.5 * (node + 1.0) * x0)[..., 0] for node in nodes]
        return np.asarray(-0.5 * x0 * np.tensordot(weights, force, axes=1))


def respond_over(
    theta: float,
    eta: float,
    low: float,
    high: float,
    contact: str = Contact.POINT,
    pull: bool = True,
    mounting: Mounting = IDEAL,
    section: str = RodSection.ROUND,
    progress: Callable[[float], None] = lambda done: None,
) -> HeightRange:
    """Solve a rod at all heights around η that have a response.

    Parameters
    ----------
    low, high : float
        Range of heights, with `eta` in it (L).

    Raises
    ------
    NoResponseError
        If the rod has no response at `eta`, or it is not resolved next to it.
    """
    solve = solver(theta, contact, pull, mounting, section)
    solve(np.array([eta]))
    total = high - low
    downwards, below = _marched(solve, eta, max(low, LOWEST), lambda way: progress(way / total))
    if not below and low < LOWEST:
        below = "the clamp touches the surface"
    upwards, above = _marched(
        solve, eta, min(high, HIGHEST), lambda way: progress((eta - low + way) / total)
    )
    if not above and high > HIGHEST:
        above = "the rod stands upright and lifts off"
    parts = (*reversed(downwards), *upwards)
    if not parts:
        raise NoResponseError(below or above)
    return HeightRange(parts=parts, below=below, above=above)


def _marched(
    solve: Solve, start: float, stop: float, progress: Callable[[float], None]
) -> tuple[list[Heights], str]:
    """Parts between two heights, up to the first failure, and its reason."""
    parts: list[Heights] = []
    width, at, upwards = WIDEST, start, stop > start
    while at != stop:
        end = min(at + width, stop) if upwards else max(at - width, stop)
        try:
            found = interpolated(solve, min(at, end), max(at, end), EXACT)
        except NoResponseError as error:
            width = 0.5 * abs(end - at)
            if width < NARROWEST:
                return parts, str(error)
        else:
            parts.append(found)
            at = end
            progress(abs(at - start))
    return parts, ""
