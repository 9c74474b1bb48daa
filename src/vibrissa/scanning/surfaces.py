"""Surfaces: static friction μ0 as a function of the position; the heights are in `textures`."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibrissa.errors import ArgumentError
from vibrissa.numerics.arrays import FloatArray
from vibrissa.scanning.rods import in_rod_lengths
from vibrissa.scanning.textures import Texture, check_increasing

# Number of cosines in a random surface, enough for a nearly normal distribution of its friction.
COSINES = 256
# Length of the parts of a surface that are traced by a ball (L).
TRACED_PART = 0.5
# Largest distance that counts as 0, in roundings of a position.
ROUNDINGS = 8.0


def rounding_at(position: float) -> float:
    """Return the largest distance from a position that counts as 0 (L)."""
    return ROUNDINGS * float(np.spacing(1.0 + abs(position)))


class Face(NamedTuple):
    """Surface on one side of a tip: its slope h' along the rod's direction, and its friction."""

    slope: float
    mu0: float


class Footing(NamedTuple):
    """Place on a surface at which a tip sticks.

    Attributes
    ----------
    contact, height : float
        Position along the surface, and height h there (L).
    mu0 : float
        Coefficient of static friction.
    ahead, behind : Face
        The surface ahead of the tip and behind it, which differ at a kink only. Ahead is the
        direction from the clamp to the tip.
    """

    contact: float
    height: float
    mu0: float
    ahead: Face
    behind: Face


@dataclass(frozen=True, eq=False, kw_only=True)
class Surface:
    """Static friction along a surface, and its texture.

    Attributes
    ----------
    name : str
        Name for messages.
    mu0 : callable
        Maps positions (L) to coefficients of static friction.
    start, stop : float
        Ends of the known part (L).
    spell : callable
        Formats positions (L) for messages.
    edges : ndarray, shape (n,)
        Positions of jumps and kinks of μ0 (L).
    feature : float
        Shortest length over which μ0 changes between two edges (L); infinite if μ0 is linear there.
    texture : Texture or None
        Height of the surface; None: the surface is a plane.
    """

    name: str
    mu0: Callable[[FloatArray], FloatArray] = field(repr=False)
    start: float = -np.inf
    stop: float = np.inf
    edges: FloatArray = field(default_factory=lambda: np.empty(0), repr=False)
    feature: float = field(default=1e-4, repr=False)
    spell: Callable[[float], str] = field(default=in_rod_lengths, repr=False)
    texture: Texture | None = field(default=None, repr=False)

    def with_texture(self, texture: Texture) -> "Surface":
        """Return a surface with the same friction, and the heights of a texture."""
        return replace(
            self,
            texture=texture,
            start=max(self.start, texture.start),
            stop=min(self.stop, texture.stop),
        )

    def in_lengths(self, unit: float) -> "Surface":
        """Return the surface with all lengths in units of another length, `unit` (L)."""
        return replace(
            self,
            mu0=lambda x: self.mu0(np.asarray(x) * unit),
            start=self.start / unit,
            stop=self.stop / unit,
            edges=self.edges / unit,
            feature=self.feature / unit,
            texture=None if self.texture is None else self.texture.in_lengths(unit),
        )

    def traced(self, radius: float, clamp: FloatArray) -> "Surface":
        """Return the surface under the lowest point of a ball at the tip; see `Texture.traced`.

        Parameters
        ----------
        radius : float
            Radius of the ball (L).
        clamp : ndarray
            Positions of the clamp (L), from which the tip is not further away than a rod's length.
        """
        if self.texture is None:
            return self
        # Whole parts, so that a longer path needs no new profile.
        begin = TRACED_PART * np.floor((np.min(clamp) - 1.0) / TRACED_PART)
        end = TRACED_PART * np.ceil((np.max(clamp) + 1.0) / TRACED_PART)
        return self.with_texture(self.texture.traced(radius, float(begin), float(end)))

    def __call__(self, x: FloatArray | float) -> FloatArray:
        """Look up the static friction at positions on the surface (L).

        Raises
        ------
        ArgumentError
            If a position is outside of the known part, or the friction is not positive.
        """
        x = np.asarray(x, dtype=float)
        self.check_known(x)
        mu0 = np.asarray(self.mu0(x), dtype=float)
        bad = ~(np.isfinite(mu0) & (mu0 > 0.0))
        if bad.any():
            where = float(np.broadcast_to(x, mu0.shape)[bad].ravel()[0])
            raise ArgumentError(
                f"mu0 must be positive everywhere; it is not at x = {self.spell(where)}"
            )
        return mu0

    def check_known(self, x: FloatArray | float) -> None:
        """Refuse positions on the surface outside of its known part (L).

        Raises
        ------
        ArgumentError
            If a position is outside.
        """
        x = np.asarray(x, dtype=float)
        outside = ~((x >= self.start) & (x <= self.stop))
        if outside.any():
            raise ArgumentError(
                f"the {self.name} surface is known from x = {self.spell(self.start)} to "
                f"{self.spell(self.stop)}, but the tip touches it at "
                f"x = {self.spell(float(x[outside].ravel()[0]))}: extend it to there or, if the "
                "tip does not start there, shorten the path"
            )

    def height(self, x: ArrayLike) -> FloatArray:
        """Heights at positions on the surface (L)."""
        if self.texture is None:
            return np.zeros(np.shape(x))
        return self.texture.height(np.asarray(x, dtype=float))

    def slope(self, x: ArrayLike) -> FloatArray:
        """Slope h' at positions on the surface."""
        if self.texture is None:
            return np.zeros(np.shape(x))
        return self.texture.slope(np.asarray(x, dtype=float))

    def footing(self, contact: float, side: int) -> Footing:
        """Return the place at which a tip touches, ahead of the clamp (`side` 1) or behind it (−1).

        Raises
        ------
        ArgumentError
            If the position is outside of the known part, or the friction is not positive.
        """
        mu0 = float(self(contact))
        if self.texture is None:
            face = Face(slope=0.0, mu0=mu0)
            return Footing(contact=contact, height=0.0, mu0=mu0, ahead=face, behind=face)
        ahead, behind = (
            np.clip(contact + direction * side * rounding_at(contact), self.start, self.stop)
            for direction in (1, -1)
        )
        return Footing(
            contact=contact,
            height=float(self.height(contact)),
            mu0=mu0,
            ahead=Face(slope=side * float(self.slope(ahead)), mu0=float(self(ahead))),
            behind=Face(slope=side * float(self.slope(behind)), mu0=float(self(behind))),
        )


def constant(mu0: float) -> Surface:
    """Surface with the same friction everywhere.

    Examples
    --------
    >>> print(constant(0.3)(np.array([0.0, 1.0])))
    [0.3 0.3]
    """
    return Surface(name="constant", mu0=lambda x: np.full(np.shape(x), float(mu0)), feature=np.inf)


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
        feature=np.inf,
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
        feature=np.inf,
    )


def _increasing(
    name: str, x: ArrayLike, mu0: ArrayLike, least: int
) -> tuple[FloatArray, FloatArray]:
    """Convert positions and friction to arrays; refuse positions that do not increase."""
    at, values = np.asarray(x, dtype=float), np.asarray(mu0, dtype=float)
    if len(at) < least or len(at) != len(values):
        raise ArgumentError(f"{name} must have at least {least} positions, and a mu0 for each")
    check_increasing(name, at)
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

    # The shortest of the waves is some four times as long.
    return Surface(name="random", mu0=mu0, feature=0.05 * correlation)
