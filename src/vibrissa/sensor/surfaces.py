"""Surfaces: static friction μ0 as a function of the position along the surface."""

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from vibrissa.errors import ArgumentError, RecordingError
from vibrissa.numerics.arrays import FloatArray
from vibrissa.quantities import series
from vibrissa.quantities.units import Kind, Quantity, Units

# Number of cosines in a random surface, enough for a nearly normal distribution of its friction.
COSINES = 256


@dataclass(frozen=True, eq=False, kw_only=True)
class Surface:
    """Static friction along a surface.

    Attributes
    ----------
    name : str
        Name for messages.
    mu0 : callable
        Maps positions (L) to coefficients of static friction.
    start, stop : float
        Ends of the known part (L).
    units : Units
        Units of positions in messages.
    edges : ndarray, shape (n,)
        Positions of jumps and kinks of μ0 (L); between them μ0 has no feature
        that is shorter than 1e-4 L.
    """

    name: str
    mu0: Callable[[FloatArray], FloatArray] = field(repr=False)
    start: float = -np.inf
    stop: float = np.inf
    edges: FloatArray = field(default_factory=lambda: np.empty(0), repr=False)
    units: Units = field(default_factory=Units, repr=False)

    def told(self, x: float) -> str:
        """Format a position (L) in the user's units."""
        return self.units.spelled(x, Kind.LENGTH)

    def __call__(self, x: FloatArray | float) -> FloatArray:
        """Look up the static friction at positions on the surface (L).

        Raises
        ------
        ArgumentError
            If a position is outside of the known part, or the friction is not positive.
        """
        x = np.asarray(x, dtype=float)
        outside = ~((x >= self.start) & (x <= self.stop))
        if outside.any():
            raise ArgumentError(
                f"the {self.name} surface is known from x = {self.told(self.start)} to "
                f"{self.told(self.stop)}, but the tip touches it at "
                f"x = {self.told(float(x[outside].ravel()[0]))}: extend it to there or, if the tip "
                "does not start there, shorten the path"
            )
        mu0 = np.asarray(self.mu0(x), dtype=float)
        bad = ~(np.isfinite(mu0) & (mu0 > 0.0))
        if bad.any():
            where = float(np.broadcast_to(x, mu0.shape)[bad].ravel()[0])
            raise ArgumentError(
                f"mu0 must be positive everywhere; it is not at x = {self.told(where)}"
            )
        return mu0


def constant(mu0: float) -> Surface:
    """Surface with the same friction everywhere.

    Examples
    --------
    >>> print(constant(0.3)(np.array([0.0, 1.0])))
    [0.3 0.3]
    """
    return Surface(name="constant", mu0=lambda x: np.full(np.shape(x), float(mu0)))


def patches(starts: ArrayLike, mu0: ArrayLike) -> Surface:
    """Surface of patches, with a constant friction on each.

    Parameters
    ----------
    starts : array_like
        Start of each patch (L), increasing; the first patch also reaches to −infinity.

    Examples
    --------
    >>> print(patches([0.0, 0.5], [0.2, 0.4])(np.array([0.1, 0.9])))
    [0.2 0.4]
    """
    edges, values = _increasing("patches", starts, mu0, 1)
    return Surface(
        name="patched",
        mu0=lambda x: values[np.searchsorted(edges[1:], x, side="right")],
        edges=edges[1:],
    )


def profile(x: ArrayLike, mu0: ArrayLike) -> Surface:
    """Surface with friction measured at points: linear between them, unknown outside.

    Parameters
    ----------
    x : array_like
        Positions (L), increasing.

    Examples
    --------
    >>> print(profile([0.0, 1.0], [0.2, 0.6])(0.5))
    0.4
    """
    at, values = _increasing("a profile", x, mu0, 2)
    return Surface(
        name="profile",
        mu0=lambda p: np.interp(p, at, values),
        start=float(at[0]),
        stop=float(at[-1]),
        edges=at,
    )


def _increasing(
    name: str, x: ArrayLike, mu0: ArrayLike, least: int
) -> tuple[FloatArray, FloatArray]:
    """Convert positions and friction to arrays; refuse positions that do not increase."""
    at, values = np.asarray(x, dtype=float), np.asarray(mu0, dtype=float)
    if len(at) < least or len(at) != len(values):
        raise ArgumentError(f"{name} must have at least {least} positions, and a mu0 for each")
    falls = np.flatnonzero(~(np.diff(at) > 0.0))
    if len(falls):
        raise ArgumentError(
            f"positions of {name} must increase: number {falls[0] + 2} is not above the one before"
        )
    return at, values


def random(
    seed: int, mean: float, deviation: float, correlation: float, least: float = 0.02
) -> Surface:
    """Surface with random, normally distributed friction, whose correlation is Gaussian.

    Parameters
    ----------
    mean, deviation : float
        Mean and standard deviation of μ0.
    least : float
        Smallest μ0, which replaces smaller values of the random process.
    correlation : float
        Distance at which the correlation has fallen to exp(−1/2) (L).
    """
    if not (mean > 0.0 and deviation >= 0.0 and correlation > 0.0 and least > 0.0):
        raise ArgumentError(
            "a random surface: mean, correlation and 'least' must be positive, and deviation not "
            "negative"
        )
    generator = np.random.default_rng(seed)
    wave = generator.standard_normal(COSINES) / correlation
    phase = generator.uniform(0.0, 2.0 * np.pi, COSINES)
    size = deviation * np.sqrt(2.0 / COSINES)

    def mu0(x: FloatArray) -> FloatArray:
        waves = np.cos(np.asarray(x)[..., None] * wave + phase).sum(axis=-1)
        return np.maximum(least, mean + size * waves)

    return Surface(name="random", mu0=mu0)


def read_surface(
    units: Units,
    *,
    mu0: Quantity | None = None,
    patches: str | None = None,
    profile: Path | None = None,
    texture: str | None = None,
    seed: int = 0,
) -> Surface:
    """Read a surface from exactly one of mu0, patches, profile and texture.

    Parameters
    ----------
    patches : str, optional
        Start and friction of each patch: ``"0 mm: 0.3, 50 mm: 0.4"``.
    profile : Path, optional
        Table with the columns ``x`` and ``mu0``.
    texture : str, optional
        Mean, standard deviation and correlation length of a random surface: ``"0.3, 0.04, 2 mm"``.

    Raises
    ------
    ArgumentError
        If there is not exactly one description, or an argument is out of range.
    RecordingError
        If the table cannot be read.
    """
    if sum(given is not None for given in (mu0, patches, profile, texture)) != 1:
        raise ArgumentError(
            "describe the surface by exactly one of mu0, patches, profile and texture"
        )
    if mu0 is not None:
        return constant(float(units.read_positive(mu0, Kind.NUMBER, "mu0")))
    if patches is not None:
        return _read_patches(patches, units)
    if profile is not None:
        return _read_profile(profile, units)
    return _read_texture(texture or "", seed, units)


def _read_patches(text: str, units: Units) -> Surface:
    pairs = [part.partition(":") for part in text.split(",")]
    starts = [float(units.read(start, Kind.LENGTH, "start of a patch")) for start, *_ in pairs]
    mu0 = [float(units.read_positive(one, Kind.NUMBER, "mu0 of a patch")) for *_, one in pairs]
    return patches(starts, mu0)


def _read_profile(path: Path, units: Units) -> Surface:
    table = series.read(path, ["x", "mu0"])
    missing = np.isnan(table.columns["x"] + table.columns["mu0"])
    if missing.any():
        raise RecordingError(f"{table.place(int(np.argmax(missing)))}: x or mu0 is missing")
    factor = units.column_factor(table.units.get("x", "L"), Kind.LENGTH, f"{path}: x")
    return profile(table.columns["x"] * factor, table.columns["mu0"])


def _read_texture(text: str, seed: int, units: Units) -> Surface:
    parts = text.split(",")
    if len(parts) != 3:
        raise ArgumentError(f"texture needs 'mean, deviation, correlation length', got {text!r}")
    mean, deviation = (float(units.read(part, Kind.NUMBER, "texture")) for part in parts[:2])
    correlation = float(units.read(parts[2], Kind.LENGTH, "correlation length of the texture"))
    return random(seed, mean, deviation, correlation)
