"""Surfaces: static friction μ0 as a function of the position along them."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from vibrissa.arrays import FloatArray

# Cosines in a random surface: enough for its values to be close to normally distributed.
COSINES = 256


@dataclass(frozen=True, eq=False)
class Friction:
    """Static friction along a surface.

    Attributes
    ----------
    name : str
        What kind of surface it is.
    mu0 : callable
        Maps positions (L) to coefficients of static friction.
    start, stop : float
        Where it is known (L).
    """

    name: str
    mu0: Callable[[FloatArray], FloatArray]
    start: float = -np.inf
    stop: float = np.inf

    def __call__(self, x: FloatArray | float) -> FloatArray:
        """Look up the static friction at positions on the surface (L).

        Raises
        ------
        ValueError
            If a position lies where the surface is not known or the friction is not positive.
        """
        x = np.asarray(x, dtype=float)
        outside = ~((x >= self.start) & (x <= self.stop))
        if outside.any():
            raise ValueError(
                f"the {self.name} surface is known from x = {self.start:.6g} to {self.stop:.6g} "
                f"(in units of L), but the tip comes to x = {float(x[outside].ravel()[0]):.6g}"
            )
        mu0 = np.asarray(self.mu0(x), dtype=float)
        bad = ~(np.isfinite(mu0) & (mu0 > 0.0))
        if bad.any():
            where = float(np.broadcast_to(x, mu0.shape)[bad].ravel()[0])
            raise ValueError(f"mu0 must be positive everywhere; it is not at x = {where:.6g}")
        return mu0


def constant(mu0: float) -> Friction:
    """Surface with the same friction everywhere."""
    if not (np.isfinite(mu0) and mu0 > 0.0):
        raise ValueError(f"mu0 must be positive, got {mu0!r}")
    return Friction("constant", lambda x: np.full(np.shape(x), float(mu0)))


def patches(starts: Sequence[float], mu0: Sequence[float]) -> Friction:
    """Surface of patches.

    Parameters
    ----------
    starts : sequence of float
        Where each patch begins (L), increasing; the first also reaches to −infinity.
    mu0 : sequence of float
        Its friction.
    """
    edges, values = np.asarray(starts, dtype=float), np.asarray(mu0, dtype=float)
    if len(edges) == 0 or len(edges) != len(values):
        raise ValueError("patches need as many starts as values of mu0, at least one")
    if np.any(~(np.diff(edges) > 0.0)):
        raise ValueError("patches must be in order: each start greater than the one before")
    return Friction("patched", lambda x: values[np.searchsorted(edges[1:], x, side="right")])


def profile(x: ArrayLike, mu0: ArrayLike) -> Friction:
    """Surface measured at points, linear in between and unknown outside.

    Parameters
    ----------
    x : array_like
        Positions (L), increasing.
    mu0 : sequence of float
        Friction there.
    """
    at, values = np.asarray(x, dtype=float), np.asarray(mu0, dtype=float)
    if len(at) < 2 or len(at) != len(values):
        raise ValueError("a profile needs at least two points (x, mu0)")
    if np.any(~(np.diff(at) > 0.0)):
        row = int(np.flatnonzero(~(np.diff(at) > 0.0))[0]) + 2
        raise ValueError(f"x of a profile must increase; it does not at point {row}")
    return Friction("profile", lambda p: np.interp(p, at, values), float(at[0]), float(at[-1]))


def random(
    seed: int, mean: float, deviation: float, correlation: float, least: float = 0.02
) -> Friction:
    """Random texture: a normal process with a Gaussian correlation, the same for the same seed.

    Parameters
    ----------
    seed : int
        Not negative.
    mean, deviation : float
        Of μ0.
    correlation : float
        Distance at which the correlation has fallen to exp(−1/2) (L).
    least : float
        What μ0 does not fall below, as friction cannot be negative.
    """
    if not (mean > 0.0 and deviation >= 0.0 and correlation > 0.0 and least > 0.0):
        raise ValueError(
            "a random surface needs mean, correlation and least above 0, deviation not below 0"
        )
    generator = np.random.default_rng(seed)
    wave = generator.standard_normal(COSINES) / correlation
    phase = generator.uniform(0.0, 2.0 * np.pi, COSINES)
    size = deviation * np.sqrt(2.0 / COSINES)

    def mu0(x: FloatArray) -> FloatArray:
        waves = np.cos(np.asarray(x)[..., None] * wave + phase).sum(axis=-1)
        return np.maximum(least, mean + size * waves)

    return Friction("random", mu0)
