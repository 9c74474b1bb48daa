"""From signals back to friction: periods of sticking, and μ0 of each with its uncertainty.

Each sample of the clamp reactions lies on the rod's response, which gives its x0. Clamp position
minus x0 is constant while the tip sticks and jumps where it slips. A period's last sticking state
is at most one step before the onset: μ0 is that state's |tan α| or more, up to what one more step
would have needed. The onset is taken as uniform within the step; with the normal noise this makes a
distribution of μ0, of which mean, deviation and the central 95 % are returned.
"""

from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path

import numpy as np
from scipy.spatial import KDTree
from scipy.stats import norm

from vibrissa.arrays import BoolArray, FloatArray, IntArray
from vibrissa.sensor import series
from vibrissa.sensor.quantities import Kind, Units
from vibrissa.sensor.response import Response
from vibrissa.sensor.transducer import CHANNELS, Transducer

# A jump of this many standard deviations is a slip: by chance one of 10^9 samples shows it.
JUMP = 6.0
# Squared misfit, in standard deviations, from which on a sample is not a state of the rod.
MISFIT = 36.0
# More than this part of the samples off the rod's response: it is another rod, or has an offset.
MOST_OFF = 0.2
# Points of the response among which the nearest to a sample is sought, before Newton's step.
TABLE = 4001
NEWTON_STEPS = 4
# Equally likely values of noise, onset and beginning, evenly spread, that make a distribution:
# multiples of the powers of the inverse of the root of x⁴ = x + 1 (Roberts's sequence).
VALUES = 1024
EVENLY = 1.2207440846057596 ** -np.arange(1.0, 4.0)
COVERAGE = 0.95


class Method(StrEnum):
    """How μ0 is found.

    Attributes
    ----------
    FORCES
        The ratio of the forces in the last sticking state; the rod's model only says how much the
        ratio grows within a step.
    MOMENT
        The moment alone: all samples of a period, through the rod's model.
    SPACING
        The clamp's travel from slip to slip, if slips end at α = 0 (law ``free``).
    """

    FORCES = "forces"
    MOMENT = "moment"
    SPACING = "spacing"


class Found(StrEnum):
    """What is known of a period.

    Attributes
    ----------
    SLIP
        It ended with a slip: μ0 is known.
    OPEN
        Its end, or for the spacing its beginning, was not recorded: no μ0.
    BEYOND
        Its last sticking state lies outside the states in which this rod slips: no μ0.
    """

    SLIP = "slip"
    OPEN = "open"
    BEYOND = "beyond"


# What each method reads.
READS = {Method.FORCES: [0, 1], Method.MOMENT: [2], Method.SPACING: [0, 1, 2]}


@dataclass(frozen=True, eq=False)
class Recording:
    """A measured time series, nondimensional.

    Attributes
    ----------
    footpoint : ndarray, shape (n,)
        Clamp positions (L).
    readings : ndarray, shape (n, 3)
        fx, fy (E·I0/L²) and m (E·I0/L); NaN where missing.
    line : ndarray of int, shape (n,)
        Where each stands in its file.
    notes : tuple of str
        What was left out, and why.
    """

    footpoint: FloatArray
    readings: FloatArray
    line: IntArray
    notes: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class Periods:
    """Periods of sticking, in their order.

    Attributes
    ----------
    status : list of Found
    first, last : ndarray of int
        Rows of the recording in which the period begins and ends.
    contact : ndarray
        Position of the tip (L).
    mu0, deviation, low, high : ndarray
        Static friction there, its standard deviation and the central 95 %.
    notes : tuple of str
        What was left out, and why.
    """

    status: list[Found]
    first: IntArray
    last: IntArray
    contact: FloatArray
    mu0: FloatArray
    deviation: FloatArray
    low: FloatArray
    high: FloatArray
    notes: tuple[str, ...]


def read_recording(
    path: Path, units: Units, method: Method, transducer: Transducer | None = None
) -> Recording:
    """Read a time series from a table with columns such as ``footpoint [mm],force_x [N]``.

    Parameters
    ----------
    path : Path
        CSV or Parquet; columns ``footpoint`` and those that the method reads, each with its unit;
        an optional ``time`` must increase.
    units : Units
    method : Method
    transducer : Transducer, optional
        Whose limits tell which readings are saturated.

    Returns
    -------
    Recording
        Without rows that miss a value or are saturated; its notes name their lines.

    Raises
    ------
    ValueError
        If the table cannot be used; the message names the line.
    """
    names = ["footpoint", *(CHANNELS[i] for i in READS[method])]
    spare = [name for name in CHANNELS if name not in names]
    table = series.read(path, names, ["time", *spare])
    if "time" in table.columns:
        late = np.flatnonzero(~(np.diff(table.columns["time"]) > 0.0))
        if len(late):
            raise ValueError(
                f"{table.place(int(late[0]) + 1)}: time does not increase; sort the table, or "
                "leave the column out"
            )
    kinds = dict(zip(["footpoint", *CHANNELS], "length force force moment".split(), strict=True))
    readings = np.full((len(table.line), 3), np.nan)
    for name in [*names, *(name for name in spare if name in table.columns)]:
        if name not in table.units:
            raise ValueError(f"{path}, line 1: {name} needs its unit, as in '{name} [mm]'")
        factor = units.column_factor(table.units[name], Kind(kinds[name]), f"{path}: {name}")
        table.columns[name] *= factor
        if name != "footpoint":
            readings[:, CHANNELS.index(name)] = table.columns[name]
    used = READS[method]
    missing = np.isnan(table.columns["footpoint"]) | np.isnan(readings[:, used]).any(axis=1)
    notes = _note(table.line[missing], "a value is missing")
    keep = ~missing
    if transducer is not None:
        scale = [units.unit(kind) for kind in (Kind.FORCE, Kind.FORCE, Kind.MOMENT)]
        full = transducer.saturated(readings * scale)[:, used].any(axis=1) & keep
        notes += _note(table.line[full], "the transducer is saturated")
        keep &= ~full
    return Recording(table.columns["footpoint"][keep], readings[keep], table.line[keep], notes)


def _note(lines: IntArray, why: str) -> tuple[str, ...]:
    if not len(lines):
        return ()
    shown = ", ".join(str(line) for line in lines[:5]) + (", ..." if len(lines) > 5 else "")
    return (f"{why} in {len(lines)} rows, left out: line {shown}",)


def noise_of(readings: FloatArray) -> FloatArray:
    """Estimate the standard deviation of each channel's noise from its second differences.

    Parameters
    ----------
    readings : ndarray, shape (n, 3)

    Returns
    -------
    ndarray, shape (3,)
        Slips do not count, as they are outliers among the differences.
    """
    second = np.abs(np.diff(readings, n=2, axis=0))
    rough = np.median(second, axis=0) / norm.ppf(0.75)
    usual = np.where(second <= 4.0 * rough, second, np.nan)
    return np.asarray(np.sqrt(np.nanmean(usual**2, axis=0) / 6.0))


def identify(
    response: Response,
    recording: Recording,
    deviation: FloatArray | None = None,
    method: Method | str = Method.FORCES,
    step: float | None = None,
) -> Periods:
    """Find the periods of sticking in a recording, and the friction of each.

    Parameters
    ----------
    response : Response
        Of the rod that was used; with pulling if the clamp went backward.
    recording : Recording
        In the order in which it was made.
    deviation : ndarray, shape (3,), optional
        Standard deviation of one reading of fx, fy (E·I0/L²) and m (E·I0/L); estimated from the
        recording by default.
    method : Method
    step : float, optional
        Step of the stage (L), which the spacing needs where samples were lost; by default the
        median distance of successive clamp positions.

    Returns
    -------
    Periods

    Raises
    ------
    ValueError
        If the recording is too short, has no measurable noise, or does not fit the rod.
    """
    method = Method(method)
    clamp, readings, line = recording.footpoint, recording.readings, recording.line
    used = [i for i in READS[method] if not np.isnan(readings[:, i]).any()]
    if len(clamp) < 3 or not used:
        raise ValueError(f"too little to identify friction from: {len(clamp)} usable rows")
    noise = (noise_of(readings) if deviation is None else np.asarray(deviation))[used]
    if not (np.isfinite(noise).all() and (noise > 0.0).all()):
        raise ValueError("the noise of the readings cannot be estimated from them: give it")

    notes = recording.notes
    x0, spread, misfit = _located(response, readings[:, used], noise, used)
    off = misfit > MISFIT
    if off.mean() > MOST_OFF:
        raise ValueError(
            f"{off.sum()} of {len(off)} samples are no state of this rod, first in line "
            f"{line[off][0]}: check rod, height, units, zero and noise"
        )
    notes += _note(line[off], "the reading is no state of this rod")
    rows = np.flatnonzero(~off)
    lone = _lone(clamp[rows] - x0[rows], spread[rows])
    notes += _note(line[rows[lone]], "a lone spike")
    rows = rows[~lone]
    if len(rows) < 3:
        raise ValueError(f"too little to identify friction from: {len(rows)} usable rows")

    at = clamp[rows] - x0[rows]
    begins = np.append(0, np.flatnonzero(_jumps(at, spread[rows], 1)) + 1)
    ends = np.append(begins[1:], len(rows)) - 1
    place, place_spread = _fitted(
        response, clamp[rows], readings[rows][:, used], noise, used, at, begins
    )
    after = np.minimum(ends + 1, len(rows) - 1)
    gap = clamp[rows[after]] - clamp[rows[ends]]
    opened = np.zeros(len(begins), dtype=bool)
    opened[-1] = True

    last = rows[ends]
    base = np.zeros(len(begins))
    early, size = np.zeros(len(begins)), 1.0
    if method is Method.FORCES:
        # Ratio and its deviation at the last sticking sample; the model says how it goes on.
        fx, fy = readings[last, 0], readings[last, 1]
        x_last, x_spread = x0[last], np.zeros(len(begins))
        base = fx / fy - response.demand(x_last)
        ratio_spread = np.hypot(noise[0] / fy, fx * noise[1] / fy**2)
    else:
        ratio_spread = np.zeros(len(begins))
        x_last, x_spread = clamp[last] - place, place_spread
    if method is Method.SPACING:
        x_last, x_spread = clamp[last] - clamp[rows[begins]], np.zeros(len(begins))
        moved = np.abs(np.diff(clamp))
        size = float(np.median(moved[moved > 0.0])) if step is None else step
        if not size > 0.0:
            raise ValueError(f"step must be positive, got {size!r}")
        # A slip in a gap of the recording may have ended at any step of it.
        early = np.append(0.0, gap[:-1])
        place = clamp[rows[begins]]
        opened[0] = True
    mean, sd, low, high = _distribution(
        response, x_last, x_spread, gap, early, size, base, ratio_spread
    )
    beyond = np.isnan(mean) & ~opened
    for values in (mean, sd, low, high):
        values[opened] = np.nan
    status = [
        Found.OPEN if o else Found.BEYOND if b else Found.SLIP
        for o, b in zip(opened, beyond, strict=True)
    ]
    contact = response.curve.x1_init + place
    return Periods(status, rows[begins], last, contact, mean, sd, low, high, notes)


def _located(
    response: Response, readings: FloatArray, noise: FloatArray, used: list[int]
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Nearest state of the rod to each sample: x0, its standard deviation, squared misfit."""
    table = np.linspace(response.x0_pull, response.curve.x0_lock, TABLE)
    values = response(table)[:, used]
    if used == [2]:
        # One channel tells states apart only as long as it grows.
        back = np.flatnonzero(np.diff(values[:, 0]) <= 0.0)
        stop = int(back[0]) + 1 if len(back) else TABLE
        table, values = table[:stop], values[:stop]
    _, nearest = KDTree(values / noise).query(readings / noise)
    x0 = table[nearest]
    inside = (table[0], table[-1])
    for _ in range(2):
        slope = response.slope(x0)[:, used] / noise
        miss = (readings - response(x0)[:, used]) / noise
        weight = (slope**2).sum(axis=1)
        x0 = np.clip(x0 + (slope * miss).sum(axis=1) / weight, *inside)
    miss = (readings - response(x0)[:, used]) / noise
    return x0, 1.0 / np.sqrt(weight), (miss**2).sum(axis=1)


def _jumps(at: FloatArray, spread: FloatArray, apart: int) -> BoolArray:
    """Whether the contact differs between samples that are so many rows apart."""
    allowed = JUMP * np.hypot(spread[apart:], spread[:-apart])
    return np.asarray(np.abs(at[apart:] - at[:-apart]) > allowed)


def _lone(at: FloatArray, spread: FloatArray) -> BoolArray:
    """Whether a sample jumps away and the next one back to where it was."""
    lone = np.zeros(len(at), dtype=bool)
    if len(at) > 2:
        one = _jumps(at, spread, 1)
        lone[1:-1] = one[:-1] & one[1:] & ~_jumps(at, spread, 2)
    return lone


def _fitted(
    response: Response,
    clamp: FloatArray,
    readings: FloatArray,
    noise: FloatArray,
    used: list[int],
    at: FloatArray,
    begins: IntArray,
) -> tuple[FloatArray, FloatArray]:
    """One contact for all samples of each period, by least squares, and its deviation."""
    counts = np.diff(np.append(begins, len(clamp)))
    place = np.add.reduceat(at, begins) / counts
    for _ in range(NEWTON_STEPS):
        x0 = np.clip(clamp - np.repeat(place, counts), response.x0_pull, response.x0_end)
        slope = response.slope(x0)[:, used] / noise
        miss = (readings - response(x0)[:, used]) / noise
        weight = np.add.reduceat((slope**2).sum(axis=1), begins)
        place = place - np.add.reduceat((slope * miss).sum(axis=1), begins) / weight
    return place, 1.0 / np.sqrt(weight)


def _distribution(
    response: Response,
    x_last: FloatArray,
    x_spread: FloatArray,
    gap: FloatArray,
    early: FloatArray,
    step: float,
    base: FloatArray,
    ratio_spread: FloatArray,
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Mean, deviation and central 95 % of μ0, of the noise and the onset within the step."""
    u, z, v = ((np.arange(1, VALUES + 1)[:, None] * EVENLY) % 1.0).T
    z = norm.ppf(z)
    x_last, x_spread, gap, early, base, ratio_spread = (
        values[:, None] for values in (x_last, x_spread, gap, early, base, ratio_spread)
    )
    steps = np.maximum(1.0, np.round(np.abs(early) / step))
    x = x_last + x_spread * z + gap * u + np.sign(early) * np.floor(v * steps) * step
    sign = np.where(gap == 0.0, np.sign(x_last), np.sign(gap))
    # It did slip: onsets past the lock, or where the surface would have to hold, are none.
    possible = (x > response.x0_pull) & (x <= response.curve.x0_lock)
    inside = np.clip(x, response.x0_pull, response.curve.x0_lock)
    mu0 = sign * (response.demand(inside) + base + ratio_spread * z)
    possible &= mu0 > 0.0
    mu0 = np.where(possible, mu0, np.inf)
    mu0.sort(axis=1)
    count = np.isfinite(mu0).sum(axis=1)
    safe = np.maximum(count, 1)
    finite = np.where(np.isfinite(mu0), mu0, 0.0)
    mean = finite.sum(axis=1) / safe
    sd = np.sqrt(np.maximum(0.0, (finite**2).sum(axis=1) / safe - mean**2))

    def quantile(part: float) -> FloatArray:
        rank = np.clip(part * safe - 0.5, 0.0, safe - 1.0)
        below = np.floor(rank).astype(np.int64)
        above = np.minimum(below + 1, safe - 1)
        row = np.arange(len(mu0))
        weight = rank - below
        return np.asarray(mu0[row, below] * (1.0 - weight) + mu0[row, above] * weight)

    tail = 0.5 * (1.0 - COVERAGE)
    with np.errstate(invalid="ignore"):
        results = [mean, sd, quantile(tail), quantile(1.0 - tail)]
    for values in results:
        values[count == 0] = np.nan
    return results[0], results[1], results[2], results[3]
