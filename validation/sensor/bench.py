"""A bench for a sensor that shares no code with the package: stage, surface, slips, transducer.

The stage moves in steps along x. The surface is a line, inclined by an angle that is positive
where the surface comes nearer on the way. The tip sticks as long as |ft/fn| ≤ μ0, with the force
along the surface and normal to it. The transducer's axes are those of the stage. All is in units of
the rod, see `bench_rod`.
"""

from dataclasses import dataclass, field
from enum import StrEnum

import numpy as np
from scipy.optimize import brentq

from validation.sensor.bench_rod import Rod, States

# Steps of the stage in which the end of a period is sought at once.
AHEAD = 100


class Slip(StrEnum):
    """Where a slip ends: at the kinetic friction, or where no friction is needed."""

    KINETIC = "kinetic"
    FREE = "free"


@dataclass(frozen=True, kw_only=True)
class Friction:
    """Static friction along the surface, a wave about a mean.

    Attributes
    ----------
    mean, wave : float
        Mean, and amplitude of the wave.
    length, phase : float
        Its length (L) and phase (rad).
    """

    mean: float = 0.3
    wave: float = 0.0
    length: float = 0.3
    phase: float = 0.0

    def __call__(self, place):
        """Friction at places along the surface."""
        return self.mean + self.wave * np.sin(2.0 * np.pi * place / self.length + self.phase)


@dataclass(frozen=True, kw_only=True)
class Bench:
    """What is really there.

    Attributes
    ----------
    rod : Rod
    eta : float
        Distance of the clamp from the surface, along its normal, at the start (L).
    incline : float
        Inclination of the surface (rad).
    slope, slope_length, slope_phase : float
        Amplitude (rad), length (L) and phase (rad) of a wave of the slope about that.
    friction : Friction
    slip : Slip
    kinetic_ratio : float
    at_rest : bool
        Whether the tip slips while the stage rests after a step, or on the way at the very onset.
    scale : float
        Part by which the stage moves further than it reports.
    encoder : float
        Standard deviation of a position that it reports (L).
    creep : float
        Part by which the loads fall per decade of readings.
    transducer : ndarray, shape (3, 3)
        By which it multiplies the loads.
    zero, drift : ndarray, shape (3,)
        Its zero at the first reading, and how much that changes up to the last, in a line.
    walk : ndarray, shape (3,)
        Standard deviation of a further change up to there, in a random walk.
    """

    rod: Rod = field(default_factory=Rod)
    eta: float = 0.85
    incline: float = 0.0
    slope: float = 0.0
    slope_length: float = 0.3
    slope_phase: float = 0.0
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
    """Transducer that shows loads larger by a part, as those of a rod of a larger E."""
    return (1.0 + part) * np.eye(3)


def turned(angle):
    """Transducer whose axes are turned from x to y."""
    cosine, sine = np.cos(angle), np.sin(angle)
    return np.array([[cosine, sine, 0.0], [-sine, cosine, 0.0], [0.0, 0.0, 1.0]])


def crosstalk(parts):
    """Transducer whose channels show parts of one another, shape (3, 3) with a diagonal of 0."""
    return np.eye(3) + np.asarray(parts)


def moved(x, y):
    """Transducer that tells the moment about the point (x, y) of the clamp."""
    return np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [y, -x, 1.0]])


@dataclass(frozen=True, kw_only=True)
class Scan:
    """A scan in n readings, and what is true of it.

    Attributes
    ----------
    stage : ndarray, shape (n,)
        Position that the stage reports (L).
    loads, readings : ndarray, shape (n, 3)
        Load on the clamp, and what the transducer says.
    tip, mu0 : ndarray, shape (n,)
        Place of the tip along the surface (L), and the friction there.
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
    """The line of the surface, and the forces on a tip there."""

    bench: Bench
    states: States

    def height(self, x):
        """Of the surface over the way of the stage."""
        incline = self.bench.incline
        wave = self.bench.slope * self.bench.slope_length / (2.0 * np.pi)
        line = (self.bench.eta - x * np.sin(incline)) / np.cos(incline)
        return line + wave * np.cos(self._phase(x))

    def _phase(self, x):
        return 2.0 * np.pi * x / self.bench.slope_length + self.bench.slope_phase

    def inclination(self, x):
        """Inclination of the surface at places over the way of the stage (rad)."""
        return self.bench.incline + self.bench.slope * np.sin(self._phase(x))

    def place(self, x):
        """Place along the surface of the point at x."""
        incline = self.bench.incline
        return x * np.cos(incline) - self.height(x) * np.sin(incline)

    def loads(self, stage, x):
        """Load on the clamp by a tip at x."""
        return self.states(x - stage, self.height(x))

    def needed(self, stage, x):
        """Friction that a tip at x needs to stick: ft/fn, positive where it is pushed."""
        fx, fy, _ = np.moveaxis(self.loads(stage, x), -1, 0)
        cosine, sine = np.cos(self.inclination(x)), np.sin(self.inclination(x))
        return (fx * cosine - fy * sine) / (fx * sine + fy * cosine)

    def mu0(self, x):
        return self.bench.friction(self.place(x))

    def onset(self, before, after, x):
        """Position of the stage between two at which a tip at x slips."""
        return brentq(
            lambda stage: abs(self.needed(stage, x)) - self.mu0(x), before, after, xtol=1e-14
        )

    def rest(self, stage, x):
        """Where a tip that slips from x with the stage at rest comes to rest."""
        part = self.bench.kinetic_ratio if self.bench.slip is Slip.KINETIC else 0.0
        side = np.sign(self.needed(stage, x))
        # Beyond where no friction is needed it would be needed the other way.
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
    """Tip that needs no friction."""
    low, high = stage + surface.states.low[0] + 1e-9, stage + surface.states.high[0] - 1e-9
    return brentq(lambda x: surface.needed(stage, x), low, high, xtol=1e-14)


def scan(bench, step, turns, noise, seed):
    """Simulate a scan that begins with a tip that needs no friction.

    Parameters
    ----------
    bench : Bench
    step : float
        That the stage reports (L).
    turns : sequence of float
        Positions to which the stage goes, one after the other, from 0 (L).
    noise : array_like, shape (3,)
        Standard deviation of one reading of each channel.
    seed : int

    Returns
    -------
    Scan
    """
    reported = _positions(step, turns)
    stage = reported * (1.0 + bench.scale)
    heights = bench.eta / np.cos(bench.incline) - np.tan(bench.incline) * np.array(
        [stage.min() + 0.2, stage.max() + 0.6]
    )
    wave = abs(bench.slope) * bench.slope_length / (2.0 * np.pi)
    states = States.tabulated(bench.rod, heights.min() - wave, heights.max() + wave)
    surface = _Surface(bench=bench, states=states)
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
    """Positions of a stage that goes from turn to turn in steps."""
    parts, last = [np.zeros(1)], 0.0
    for turn in turns:
        count = round(abs(turn - last) / step)
        parts.append(last + np.sign(turn - last) * step * np.arange(1, count + 1))
        last = turn
    return np.concatenate(parts)


def _stuck(surface, stage):
    """Tip and number of the period at each position of the stage."""
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
    """Friction that is needed, infinite past the states that are tabulated."""
    low, high = surface.states.low[0], surface.states.high[0]
    inside = (x - stage > low) & (x - stage < high)
    needed = np.full(len(stage), np.inf)
    needed[inside] = surface.needed(stage[inside], x)
    return needed
