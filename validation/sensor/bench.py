"""Simulated test bench that shares no code with the package: stage, surface, slips, transducer.

The stage moves in steps along x. The surface is a line whose inclination is positive if the surface
approaches the clamp along x. The tip sticks as long as |ft/fn| ≤ μ0, with the force ft along the
surface and fn normal to it. The transducer's axes are those of the stage. Quantities have the units
of `bench_rod`.
"""

from dataclasses import dataclass, field, replace
from enum import StrEnum

import numpy as np
from scipy.optimize import brentq

from validation.sensor.bench_rod import Rod, States

# Number of stage steps that are searched at once for the end of a period.
AHEAD = 100
# Place near the first contact, at which waves of the slope do not change the height (L).
FIRST = 0.5
# Number of places at which the heights of the surface are known; margin of the table of states (L).
PLACES, LEAST = 1001, 1e-5


class Slip(StrEnum):
    """Where a slip ends: at the kinetic friction, or where no friction is needed."""

    KINETIC = "kinetic"
    FREE = "free"


@dataclass(frozen=True, kw_only=True)
class Friction:
    """Static friction coefficient along the surface: a wave about a mean.

    Attributes
    ----------
    mean, wave : float
        Mean, and amplitude of the wave.
    length, phase : float
        Length (L) and phase (rad) of the wave.
    """

    mean: float = 0.3
    wave: float = 0.0
    length: float = 0.3
    phase: float = 0.0

    def __call__(self, place):
        """Return the friction coefficient at places along the surface (L)."""
        return self.mean + self.wave * np.sin(2.0 * np.pi * place / self.length + self.phase)


@dataclass(frozen=True, kw_only=True)
class Bench:
    """The true set-up.

    Attributes
    ----------
    rod : Rod
    eta : float
        Distance of the clamp from the surface, along its normal, at the start (L).
    incline : float
        Inclination of the surface (rad).
    slope, slope_length, slope_phase : float or ndarray, shape (w,)
        Amplitude (rad), length (L) and phase (rad) of waves of the slope about this inclination.
    friction : Friction
    slip : Slip
    kinetic_ratio : float
    at_rest : bool
        Whether the tip slips while the stage rests after a step; otherwise it slips during the
        step, at the exact onset.
    scale : float
        Relative amount by which the stage moves further than it reports.
    encoder : float
        Standard deviation of reported positions (L).
    creep : float
        Relative fall of the loads per decade of the number of readings.
    transducer : ndarray, shape (3, 3)
        Matrix by which the transducer multiplies the loads.
    zero, drift : ndarray, shape (3,)
        Zero of the transducer at the first reading, and its linear change up to the last reading.
    walk : ndarray, shape (3,)
        Standard deviation of a random walk of the zero, at the last reading.
    """

    rod: Rod = field(default_factory=Rod)
    eta: float = 0.85
    incline: float = 0.0
    slope: np.ndarray | float = 0.0
    slope_length: np.ndarray | float = 0.3
    slope_phase: np.ndarray | float = 0.0
    friction: Friction = field(default_factory=Friction)
    slip: Slip = Slip.KINETIC
    kinetic_ratio: float = 0.8
    at_rest: bool = True
    scale: float = 0.0
    encoder: float = 0.0
    creep: float = 0.0
    transducer: np.ndarray = field(default_factory=lambda: np.eye(3))
    zero: np.ndarray = field(default_factory=lambda: np.zeros(3))
    drift: np.ndarray = field(default_factory=lambda: np.zeros(3))
    walk: np.ndarray = field(default_factory=lambda: np.zeros(3))


def stiffer(part):
    """Return the transducer that scales loads by 1 + part, as a rod with a larger E does."""
    return (1.0 + part) * np.eye(3)


def turned(angle):
    """Return the transducer whose axes are turned by an angle (rad) from x towards y."""
    cosine, sine = np.cos(angle), np.sin(angle)
    return np.array([[cosine, sine, 0.0], [-sine, cosine, 0.0], [0.0, 0.0, 1.0]])


def crosstalk(parts):
    """Return the transducer with crosstalk: `parts` has shape (3, 3) and a zero diagonal."""
    return np.eye(3) + np.asarray(parts)


def moved(x, y):
    """Return the transducer that measures the moment about (x, y), relative to the clamp (L)."""
    return np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [y, -x, 1.0]])


@dataclass(frozen=True, kw_only=True)
class Scan:
    """A scan of n readings, with the true values.

    Attributes
    ----------
    stage : ndarray, shape (n,)
        Position that the stage reports (L).
    loads, readings : ndarray, shape (n, 3)
        Load on the clamp, and readings of the transducer.
    tip, mu0 : ndarray, shape (n,)
        Position of the tip along the surface (L), and the friction coefficient at this position.
    period : ndarray of int, shape (n,)
        Number of the period of sticking.
    """

    stage: np.ndarray
    loads: np.ndarray
    readings: np.ndarray
    tip: np.ndarray
    mu0: np.ndarray
    period: np.ndarray


@dataclass(frozen=True, kw_only=True)
class _Surface:
    """The surface, and the forces on a tip in contact with it."""

    bench: Bench
    states: States | None = None

    def height(self, x):
        """Height of the surface above the path of the clamp, at x (L)."""
        incline = self.bench.incline
        wave = np.atleast_1d(self.bench.slope) * self.bench.slope_length / (2.0 * np.pi)
        line = (self.bench.eta - x * np.sin(incline)) / np.cos(incline)
        return line + (np.cos(self._phase(x)) - np.cos(self._phase(FIRST))) @ wave

    def _phase(self, x):
        """Phases of the waves at x, shape (..., w)."""
        length = np.atleast_1d(self.bench.slope_length)
        return 2.0 * np.pi * np.asarray(x)[..., None] / length + self.bench.slope_phase

    def inclination(self, x):
        """Inclination of the surface at x (rad)."""
        return self.bench.incline + np.sin(self._phase(x)) @ np.atleast_1d(self.bench.slope)

    def place(self, x):
        """Position along the surface of its point at x (L)."""
        incline = self.bench.incline
        return x * np.cos(incline) - self.height(x) * np.sin(incline)

    def loads(self, stage, x):
        """Load on the clamp with the tip at x, shape (..., 3)."""
        return self.states(x - stage, self.height(x))

    def needed(self, stage, x):
        """Friction coefficient that a tip at x needs to stick, ft/fn; positive for a pushed tip."""
        fx, fy, _ = np.moveaxis(self.loads(stage, x), -1, 0)
        cosine, sine = np.cos(self.inclination(x)), np.sin(self.inclination(x))
        return (fx * cosine - fy * sine) / (fx * sine + fy * cosine)

    def mu0(self, x):
        return self.bench.friction(self.place(x))

    def onset(self, before, after, x):
        """Position of the stage, between two positions, at which a tip at x begins to slip."""
        return brentq(
            lambda stage: abs(self.needed(stage, x)) - self.mu0(x), before, after, xtol=1e-14
        )

    def rest(self, stage, x):
        """Position at which a tip that slips from x comes to rest, with the stage at rest."""
        part = self.bench.kinetic_ratio if self.bench.slip is Slip.KINETIC else 0.0
        side = np.sign(self.needed(stage, x))
        # Beyond the position that needs no friction, the required friction changes its sign.
        free = _neutral(self, stage)
        return (
            brentq(
                lambda there: side * self.needed(stage, there) - part * self.mu0(there),
                x,
                free,
                xtol=1e-14,
            )
            if part
            else free
        )


def _neutral(surface, stage):
    """Position of a tip that needs no friction."""
    low, high = stage + surface.states.low[0] + 1e-9, stage + surface.states.high[0] - 1e-9
    return brentq(lambda x: surface.needed(stage, x), low, high, xtol=1e-14)


def scan(bench, step, turns, noise, seed):
    """Simulate a scan that begins without a friction force on the tip.

    Parameters
    ----------
    bench : Bench
    step : float
        Step that the stage reports (L).
    turns : sequence of float
        Turning points of the stage (L), which begins at 0.
    noise : array_like, shape (3,)
        Standard deviation of one reading of each channel.
    seed : int

    Returns
    -------
    Scan
    """
    reported = _positions(step, turns)
    stage = reported * (1.0 + bench.scale)
    surface = _Surface(bench=bench)
    heights = surface.height(np.linspace(stage.min() + 0.2, stage.max() + 0.6, PLACES))
    states = States.tabulated(bench.rod, heights.min() - LEAST, heights.max() + LEAST)
    surface = replace(surface, states=states)
    tip, period = _stuck(surface, stage)
    generator, size = np.random.default_rng(seed), len(stage)
    softer = 1.0 - bench.creep * np.log10(1.0 + np.arange(size))
    loads = surface.loads(stage, tip) * softer[:, None]
    readings = loads @ bench.transducer.T + generator.normal(0.0, noise, loads.shape)
    readings += bench.zero + np.linspace(0.0, 1.0, size)[:, None] * bench.drift
    readings += np.cumsum(generator.normal(size=loads.shape), axis=0) * bench.walk / np.sqrt(size)
    return Scan(
        stage=reported + generator.normal(0.0, bench.encoder, size),
        loads=loads,
        readings=readings,
        tip=surface.place(tip),
        mu0=surface.mu0(tip),
        period=period,
    )


def _positions(step, turns):
    """Positions of a stage that moves in steps from one turning point to the next."""
    parts, last = [np.zeros(1)], 0.0
    for turn in turns:
        count = round(abs(turn - last) / step)
        parts.append(last + np.sign(turn - last) * step * np.arange(1, count + 1))
        last = turn
    return np.concatenate(parts)


def _stuck(surface, stage):
    """Position of the tip, and number of the period, at each position of the stage."""
    tip, period = np.empty(len(stage)), np.empty(len(stage), dtype=int)
    x, number, row = _neutral(surface, stage[0]), 1, 0
    while row < len(stage):
        ahead = slice(row, row + AHEAD)
        beyond = np.abs(_needed_within(surface, stage[ahead], x)) > surface.mu0(x)
        count = int(np.argmax(beyond)) if beyond.any() else len(beyond)
        tip[row : row + count], period[row : row + count] = x, number
        row += count
        if beyond.any():
            at = stage[row]
            if not surface.bench.at_rest:
                at = surface.onset(stage[row - 1], at, x)
            x, number = surface.rest(at, x), number + 1
    return tip, period


def _needed_within(surface, stage, x):
    """Friction coefficient needed to stick; infinite outside the tabulated states."""
    low, high = surface.states.low[0], surface.states.high[0]
    inside = (x - stage > low) & (x - stage < high)
    needed = np.full(len(stage), np.inf)
    needed[inside] = surface.needed(stage[inside], x)
    return needed
