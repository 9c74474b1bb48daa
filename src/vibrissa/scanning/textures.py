"""Textures: the height of a surface along the scan, and the profile that a ball tip traces.

Heights are positive out of the material, towards the clamp, as a profilometer gives them. With the
height h(x), the surface is at the distance η − h(x) from the clamp.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from vibrissa.errors import ArgumentError
from vibrissa.numerics.arrays import FloatArray, IntArray

if TYPE_CHECKING:
    from scipy.interpolate import PPoly

# Number of cells in the length of a wave. In a cell, h is a polynomial of degree 6 to rounding.
CELLS_PER_WAVE = 20
# Number of points in a correlation length of a random texture, and of correlation lengths after
# which it repeats.
POINTS_PER_CORRELATION, CORRELATIONS = 32, 2048
# Steepest wall of a groove (rad).
STEEPEST_WALL = np.radians(89.9)
# Number of points of a traced profile in the radius of the tip, and in a piece of a texture that is
# no cubic polynomial.
POINTS_PER_RADIUS, POINTS_PER_PIECE = 20, 10
# Largest |u|/r at which a ball touches: there its slope is 200.
TOUCHING_RIM = 1.0 - 1.25e-5
# Distance of points that count as one, in radii of the tip.
SAME_POINT = 1e-9
# Slope from which on a piece of a traced profile is a wall.
WALL_SLOPE = 1.0
# Number of traced profiles that are kept, some megabytes each.
KEPT_TRACED = 8
# Halvings in which the place where the ball touches is found.
HALVINGS = 52


@dataclass(frozen=True, eq=False, kw_only=True)
class Texture:
    """Height h of a surface along the scan; h is continuous.

    Attributes
    ----------
    height, slope : callable
        Map positions (L) to h (L) and to h'. At a kink, the slope is the one to its right.
    breaks : callable
        Maps two positions to the positions between them that divide h into smooth pieces (L).
    degree : int
        Degree of a polynomial to which h is equal in each piece, exactly or up to rounding.
    low, high : float
        Bounds of h (L).
    start, stop : float
        Ends of the known part (L).
    """

    height: Callable[[FloatArray], FloatArray] = field(repr=False)
    slope: Callable[[FloatArray], FloatArray] = field(repr=False)
    breaks: Callable[[float, float], FloatArray] = field(repr=False)
    low: float
    high: float
    degree: int = 3
    start: float = -np.inf
    stop: float = np.inf

    def __add__(self, other: "Texture") -> "Texture":
        """Return the texture whose height is the sum of two."""
        return Texture(
            height=lambda x: self.height(x) + other.height(x),
            slope=lambda x: self.slope(x) + other.slope(x),
            breaks=lambda begin, end: np.union1d(self.breaks(begin, end), other.breaks(begin, end)),
            low=self.low + other.low,
            high=self.high + other.high,
            degree=max(self.degree, other.degree),
            start=max(self.start, other.start),
            stop=min(self.stop, other.stop),
        )

    def with_lay(self, angle: float) -> "Texture":
        """Return the texture along a scan that is oblique to its lay.

        Parameters
        ----------
        angle : float
            Angle between the motion and the direction across the grooves (rad): lengths along the
            scan grow by 1/cos.

        Raises
        ------
        ArgumentError
            If the angle is not between −90° and 90°.

        Examples
        --------
        >>> oblique = wave(1e-4, 0.02).with_lay(np.radians(60))
        >>> print(oblique.height(np.array([0.01])).round(9))
        [0.0001]
        """
        if not abs(angle) < 0.5 * np.pi:
            raise ArgumentError(f"lay must lie between -90 and 90 degrees, got {angle!r} rad")
        part = float(np.cos(angle))
        return replace(
            self,
            height=lambda x: self.height(np.asarray(x) * part),
            slope=lambda x: self.slope(np.asarray(x) * part) * part,
            breaks=lambda begin, end: self.breaks(begin * part, end * part) / part,
            start=self.start / part,
            stop=self.stop / part,
        )

    def in_lengths(self, unit: float) -> "Texture":
        """Return the texture with all lengths in units of another length, `unit` (L)."""
        return replace(
            self,
            height=lambda x: self.height(np.asarray(x) * unit) / unit,
            slope=lambda x: self.slope(np.asarray(x) * unit),
            breaks=lambda begin, end: self.breaks(begin * unit, end * unit) / unit,
            low=self.low / unit,
            high=self.high / unit,
            start=self.start / unit,
            stop=self.stop / unit,
        )

    def traced(self, radius: float, start: float, stop: float) -> "Texture":
        """Return the profile that the lowest point of a ball traces (ISO 3274).

        It is the dilation by a disc, h_r(x) = max over |u| ≤ r of h(x + u) + √(r² − u²) − r, with a
        kink where the disc touches twice. Between points it is a cubic polynomial.

        Parameters
        ----------
        radius : float
            Radius r of the ball (L); 0 returns the texture itself.
        start, stop : float
            Ends of the part that is needed (L). The traced profile ends a radius before the known
            part of the texture.

        Raises
        ------
        ArgumentError
            If the radius is negative, or the known part is shorter than the ball.
        """
        if not 0.0 <= radius < np.inf:
            raise ArgumentError(f"tip_radius must be a number from 0 on, got {radius!r}")
        if radius == 0.0:
            return self
        start, stop = max(start, self.start + radius), min(stop, self.stop - radius)
        if not start < stop:
            raise ArgumentError("the known part of the texture is shorter than the ball of the tip")
        return _traced(self, radius, start, stop)


def wave(amplitude: float, wavelength: float, phase: float = 0.0) -> Texture:
    """Texture h = amplitude·sin(2π·x/wavelength + phase).

    Parameters
    ----------
    amplitude, wavelength : float
        In L; the wavelength is positive.
    phase : float
        In rad.

    Examples
    --------
    >>> print(wave(2e-4, 0.02).height(np.array([0.0, 0.005])))
    [0.     0.0002]
    """
    if not (wavelength > 0.0 and np.isfinite(amplitude)):
        raise ArgumentError("a wave: wavelength must be positive, and amplitude a finite number")
    number = 2.0 * np.pi / wavelength
    return Texture(
        height=lambda x: amplitude * np.sin(number * np.asarray(x) + phase),
        slope=lambda x: amplitude * number * np.cos(number * np.asarray(x) + phase),
        breaks=lambda begin, end: _multiples(wavelength / CELLS_PER_WAVE, begin, end),
        low=-abs(amplitude),
        high=abs(amplitude),
        degree=6,
    )


def incline(slope: float, low: float, high: float) -> Texture:
    """Plane h = slope·x, for heights between two bounds (L).

    Examples
    --------
    >>> print(incline(0.1, -0.1, 0.1).height(np.array([0.5])))
    [0.05]
    """
    if not (slope != 0.0 and np.isfinite(slope) and low < high):
        raise ArgumentError("an incline: slope must not be 0, and low must be below high")
    start, stop = sorted((low / slope, high / slope))
    return Texture(
        height=lambda x: slope * np.asarray(x, dtype=float),
        slope=lambda x: np.full(np.shape(x), slope),
        breaks=lambda begin, end: np.empty(0),
        low=low,
        high=high,
        start=start,
        stop=stop,
    )


def grooves(
    width: float, depth: float, pitch: float, wall: float = np.radians(80.0), offset: float = 0.0
) -> Texture:
    """Texture of equal grooves in a plane.

    Parameters
    ----------
    width, depth, pitch : float
        Width of a groove at the plane, its depth, and the distance from groove to groove (L).
    wall : float
        Inclination of the walls (rad), at most 89.9°. Walls that meet above the depth form a V.
    offset : float
        Position at which one of the grooves begins (L).

    Examples
    --------
    >>> steps = grooves(width=0.01, depth=1e-3, pitch=0.02, wall=np.radians(45))
    >>> print(steps.height(np.array([-0.001, 0.0005, 0.005])))
    [ 0.     -0.0005 -0.001 ]
    """
    if not (0.0 < width < pitch < np.inf and 0.0 < depth < np.inf):
        raise ArgumentError(
            "grooves: width and depth must be positive, and pitch larger than width"
        )
    if not 0.0 < wall <= STEEPEST_WALL:
        raise ArgumentError(f"grooves: wall must be above 0 and at most 89.9 deg, got {wall!r} rad")
    rise = float(np.tan(wall))
    ramp = depth / rise
    if 2.0 * ramp < width:
        corners = np.array([0.0, ramp, width - ramp, width])
    else:
        depth = 0.5 * width * rise
        corners = np.array([0.0, 0.5 * width, width])
    heights = np.where((corners == 0.0) | (corners == width), 0.0, -depth)
    slopes = np.append(np.diff(heights) / np.diff(corners), 0.0)

    def place(x: ArrayLike) -> FloatArray:
        return np.asarray((np.asarray(x, dtype=float) - offset) % pitch)

    def breaks(begin: float, end: float) -> FloatArray:
        first = _multiples(pitch, begin - offset - pitch, end - offset) + offset
        found = (first[:, None] + corners).ravel()
        return found[(found > begin) & (found < end)]

    def slope(x: ArrayLike) -> FloatArray:
        piece = np.searchsorted(corners, place(x), side="right") - 1
        return np.asarray(slopes[piece])

    return Texture(
        height=lambda x: np.interp(place(x), corners, heights),
        slope=slope,
        breaks=breaks,
        low=-depth,
        high=0.0,
    )


def rough(deviation: float, correlation: float, seed: int = 0) -> Texture:
    """Random texture with normally distributed heights, whose correlation is Gaussian.

    Parameters
    ----------
    deviation : float
        Standard deviation of h, the roughness Rq (L).
    correlation : float
        Distance at which the correlation has fallen to exp(−1/2) (L). The root mean square of the
        slope is deviation/correlation.
    seed : int
        The same seed gives the same texture. It repeats after 2048 correlation lengths.
    """
    if not (0.0 <= deviation < np.inf and 0.0 < correlation < np.inf):
        raise ArgumentError(
            "a rough texture: deviation must not be negative, and correlation must be positive"
        )
    count = CORRELATIONS * POINTS_PER_CORRELATION
    generator = np.random.default_rng(seed)
    # The Fourier coefficients of a Gaussian correlation are Gaussian, too.
    number = 2.0 * np.pi * np.arange(count // 2 + 1) / CORRELATIONS
    size = np.exp(-0.25 * number**2)
    size[0] = 0.0
    size *= 0.5 * deviation * count / np.sqrt((size**2).sum())
    parts = generator.standard_normal((2, len(size)))
    values = np.fft.irfft(size * (parts[0] + 1j * parts[1]), count)
    x = np.arange(count + 1) * (correlation / POINTS_PER_CORRELATION)
    from scipy.interpolate import CubicSpline  # takes longer to load than a scan on a plane

    spline = CubicSpline(x, np.append(values, values[0]), bc_type="periodic")
    slope, spacing = spline.derivative(), correlation / POINTS_PER_CORRELATION
    # Between its points the spline may exceed their extremes a little.
    margin = 0.01 * float(np.ptp(values))
    return Texture(
        height=lambda x: spline(x),
        slope=lambda x: slope(x),
        breaks=lambda begin, end: _multiples(spacing, begin, end),
        low=float(values.min()) - margin,
        high=float(values.max()) + margin,
    )


def measured(x: ArrayLike, height: ArrayLike) -> Texture:
    """Texture measured at points: linear between them, unknown outside.

    Parameters
    ----------
    x, height : array_like
        Positions, increasing, and the height at each (L).

    Raises
    ------
    ArgumentError
        If there are fewer than two points, a number is missing, or positions do not increase.

    Examples
    --------
    >>> ramp = measured([0.0, 1.0, 2.0], [0.0, 0.1, 0.1])
    >>> print(ramp.height(np.array([0.5])), ramp.slope(np.array([1.0])))
    [0.05] [0.]
    """
    at, values = np.asarray(x, dtype=float), np.asarray(height, dtype=float)
    if at.ndim != 1 or len(at) < 2 or at.shape != values.shape:
        raise ArgumentError("a measured texture must have at least 2 positions, and a height each")
    missing = np.flatnonzero(~np.isfinite(at + values))
    if len(missing):
        raise ArgumentError(f"heights: number {missing[0] + 1} has no position or no height")
    check_increasing("heights", at)
    return _pieces(np.stack([np.diff(values) / np.diff(at), values[:-1]]), at)


def check_increasing(name: str, x: FloatArray) -> None:
    """Refuse positions that do not increase, shape (n,).

    Raises
    ------
    ArgumentError
        With the first position that is not above the one before, and what is there: its `name`.
    """
    falls = np.flatnonzero(~(np.diff(x) > 0.0))
    if len(falls):
        raise ArgumentError(
            f"positions of {name} must increase: number {falls[0] + 2} is not above the one before"
        )


def _multiples(step: float, begin: float, end: float) -> FloatArray:
    """Multiples of a step strictly between two positions."""
    found = step * np.arange(np.floor(begin / step), np.ceil(end / step) + 1)
    return np.asarray(found[(found > begin) & (found < end)])


def _pieces(coefficients: FloatArray, x: FloatArray) -> Texture:
    """Texture of polynomials between breaks x; `coefficients` as in `scipy.interpolate.PPoly`."""
    from scipy.interpolate import PPoly  # takes longer to load than a scan on a plane

    return splined(PPoly(coefficients, x))


def splined(heights: "PPoly") -> Texture:
    """Texture of a piecewise polynomial between its first and its last break.

    Its bounds are those of the heights at the breaks.
    """
    slope, x = heights.derivative(), heights.x
    values = np.append(heights(x[:-1]), heights(x[-1]))

    def breaks(begin: float, end: float) -> FloatArray:
        return np.asarray(x[np.searchsorted(x, begin, "right") : np.searchsorted(x, end, "left")])

    return Texture(
        height=lambda x: heights(x),
        slope=lambda x: slope(x),
        breaks=breaks,
        low=float(values.min()),
        high=float(values.max()),
        degree=len(heights.c) - 1,
        start=float(x[0]),
        stop=float(x[-1]),
    )


# --- The profile that a ball traces ---


@lru_cache(KEPT_TRACED)
def _traced(texture: Texture, radius: float, start: float, stop: float) -> Texture:
    """Trace a texture with a disc between two positions (L)."""
    first, last = max(start - radius, texture.start), min(stop + radius, texture.stop)
    count = int(np.ceil((last - first) * POINTS_PER_RADIUS / radius))
    breaks = np.concatenate([[first], texture.breaks(first, last), [last]])
    parts = POINTS_PER_PIECE if texture.degree > 3 else 1
    within = np.interp(np.arange(parts * (len(breaks) - 1)) / parts, np.arange(len(breaks)), breaks)
    support = np.unique(
        np.concatenate([np.linspace(first, last, count + 1), within, [start, stop]])
    )
    # Positions that differ by rounding are one.
    support = support[np.diff(support, prepend=-np.inf) > SAME_POINT * radius]
    heights = texture.height(support)
    x = support[(support >= start) & (support <= stop)]
    best = _highest(support, heights, x, radius)
    low, high = support[np.maximum(best - 1, 0)], support[np.minimum(best + 1, len(support) - 1)]
    touched = _touched(texture, radius, x, low, high)
    left = right = touched
    # Where the place of contact jumps, the disc touches twice, and the profile has a kink.
    jump = np.flatnonzero(best[1:] > best[:-1] + 2)
    if len(jump):
        at = _met(texture, radius, x[jump], x[jump + 1], touched[jump], touched[jump + 1])
        inside = (at > x[jump]) & (at < x[jump + 1])
        jump, at = jump[inside], at[inside]
        sides = [
            _touched(texture, radius, at, low[jump + side], high[jump + side]) for side in (0, 1)
        ]
        order = np.argsort(np.append(x, at), kind="stable")
        x, left, right = (
            np.append(one, more)[order]
            for one, more in ((x, at), (touched, sides[0]), (touched, sides[1]))
        )
    values = np.maximum(_lowest(texture, radius, x, left), _lowest(texture, radius, x, right))
    return _hermite(x, values, _rim_slope(radius, left - x), _rim_slope(radius, right - x))


def _highest(support: FloatArray, heights: FloatArray, x: FloatArray, radius: float) -> IntArray:
    """Find the number of the support point at which a disc over each x is highest.

    It does not fall with x, so that the middle of a range of x bounds the search in both halves.
    """
    first = np.searchsorted(support, x - radius, side="left")
    last = np.searchsorted(support, x + radius, side="right") - 1
    best = np.zeros(len(x), dtype=np.int64)
    low, high = np.array([0]), np.array([len(x) - 1])
    known = np.zeros(len(x), dtype=bool)
    while len(low):
        middle = (low + high) // 2
        known[middle] = True
        before, after = low - 1, high + 1
        begin = np.maximum(first[middle], np.where(before >= 0, best[before], 0))
        bound = np.where(after < len(x), best[np.minimum(after, len(x) - 1)], len(support) - 1)
        end = np.maximum(np.minimum(last[middle], bound), begin)
        count = end - begin + 1
        starts = np.append(0, np.cumsum(count)[:-1])
        row = np.repeat(np.arange(len(middle)), count)
        at = np.arange(count.sum()) - starts[row] + begin[row]
        u = support[at] - x[middle][row]
        value = heights[at] + np.sqrt(np.maximum(radius**2 - u**2, 0.0))
        most = np.maximum.reduceat(value, starts)
        place = np.flatnonzero(value == most[row])
        best[middle] = at[place[np.searchsorted(row[place], np.arange(len(middle)))]]
        halves = np.concatenate(
            [np.stack([low, middle - 1], axis=1), np.stack([middle + 1, high], axis=1)]
        )
        halves = halves[halves[:, 0] <= halves[:, 1]]
        low, high = halves[np.argsort(halves[:, 0])].T
    return best


def _touched(
    texture: Texture, radius: float, x: FloatArray, low: FloatArray, high: FloatArray
) -> FloatArray:
    """Find where a disc over x touches between two positions: where both slopes are the same."""
    reach = TOUCHING_RIM * radius
    low, high = np.maximum(low, x - reach), np.minimum(high, x + reach)
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        rises = texture.slope(middle) > _rim_slope(radius, middle - x)
        low, high = np.where(rises, middle, low), np.where(rises, high, middle)
    return 0.5 * (low + high)


def _rim_slope(radius: float, u: FloatArray) -> FloatArray:
    """Slope of the traced profile if the disc touches at the distance u ahead of its centre."""
    u = np.clip(u, -TOUCHING_RIM * radius, TOUCHING_RIM * radius)
    return np.asarray(u / np.sqrt(radius**2 - u**2))


def _lowest(texture: Texture, radius: float, x: FloatArray, touched: FloatArray) -> FloatArray:
    """Height of the lowest point of a disc over x that touches at a given place."""
    u = touched - x
    return np.asarray(texture.height(touched) + np.sqrt(np.maximum(radius**2 - u**2, 0.0)) - radius)


def _met(
    texture: Texture,
    radius: float,
    low: FloatArray,
    high: FloatArray,
    left: FloatArray,
    right: FloatArray,
) -> FloatArray:
    """Find the positions x at which a disc touches at two given places."""
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        before = _lowest(texture, radius, middle, left) > _lowest(texture, radius, middle, right)
        low, high = np.where(before, middle, low), np.where(before, high, middle)
    return 0.5 * (low + high)


def _hermite(x: FloatArray, values: FloatArray, left: FloatArray, right: FloatArray) -> Texture:
    """Piecewise cubic texture with given values, and slopes on the left and right of each point.

    On steep walls, slopes are cut to three times the mean slope, so that no piece overshoots.
    """
    width = np.diff(x)
    mean = np.diff(values) / width
    begin, end = (
        np.where(
            np.abs(one) > WALL_SLOPE,
            np.sign(mean) * np.clip(np.sign(mean) * one, 0.0, 3.0 * np.abs(mean)),
            one,
        )
        for one in (right[:-1], left[1:])
    )
    coefficients = np.stack(
        [
            (begin + end - 2.0 * mean) / width**2,
            (3.0 * mean - 2.0 * begin - end) / width,
            begin,
            values[:-1],
        ]
    )
    return _pieces(coefficients, x)
