"""From signals back to friction: periods of sticking, and μ0 of each with its uncertainty."""

from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path

import numpy as np
from scipy.stats import norm

from vibrissa.arrays import FloatArray, IntArray
from vibrissa.sensor import series
from vibrissa.sensor.quantities import Kind, Units
from vibrissa.sensor.response import Branch
from vibrissa.sensor.sticking import (
    MISFIT,
    fitted,
    jumps,
    located,
    lone_spikes,
    same_contact,
)
from vibrissa.sensor.transducer import CHANNELS, Transducer
from vibrissa.sensor.uncertainty import (
    frictions,
    least_friction,
    missed_beginnings,
    onsets,
    ratio_deviation,
    summary,
)

# More than this part of the samples off the rod's response: it is another rod, or has an offset.
MOST_OFF = 0.2


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
        Its end, or for the spacing its beginning, was not recorded: μ0 is at least `low`.
    LOCK
        The tip stuck past the lock: μ0 is above `low`, which is μ_lock; how far is not known.
    BEYOND
        Its last sticking state lies outside the states in which this rod slips: no μ0.
    """

    SLIP = "slip"
    OPEN = "open"
    LOCK = "lock"
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
        Static friction there, its standard deviation and the central 95 %. Where only a bound is
        known all but `low` are NaN.
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
    branch: Branch,
    recording: Recording,
    deviation: FloatArray | None = None,
    method: Method | str = Method.FORCES,
    step: float | None = None,
) -> Periods:
    """Find the periods of sticking in a recording, and the friction of each.

    Parameters
    ----------
    branch : Branch
        Response of the rod that was used; with pulling if the clamp went backward.
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
    x0, spread, misfit = located(branch, readings[:, used], noise, used)
    off = misfit > MISFIT
    if off.mean() > MOST_OFF:
        raise ValueError(
            f"{off.sum()} of {len(off)} samples are no state of this rod, first in line "
            f"{line[off][0]}: check rod, height, units, zero and noise"
        )
    notes += _note(line[off], "the reading is no state of this rod")
    rows = np.flatnonzero(~off)
    lone = lone_spikes(clamp[rows] - x0[rows], spread[rows])
    notes += _note(line[rows[lone]], "a lone spike")
    rows = rows[~lone]
    if len(rows) < 3:
        raise ValueError(f"too little to identify friction from: {len(rows)} usable rows")

    at = clamp[rows] - x0[rows]
    begins = np.append(0, np.flatnonzero(jumps(at, spread[rows])) + 1)
    samples = (branch, clamp[rows], readings[rows][:, used], noise, used)
    contact, contact_spread = fitted(*samples, at, begins)
    own = same_contact(*samples, begins, contact, contact_spread) == np.arange(len(begins))
    begins, contact, contact_spread = begins[own], contact[own], contact_spread[own]
    ends = np.append(begins[1:], len(rows)) - 1
    first, last = rows[begins], rows[ends]
    gap = clamp[rows[np.minimum(ends + 1, len(rows) - 1)]] - clamp[last]
    opened = np.zeros(len(begins), dtype=bool)
    opened[-1] = True

    none = np.zeros(len(begins))
    base, ratio_spread = none, none
    if method is Method.FORCES:
        # Ratio and its deviation at the last sticking sample; the model says how it goes on.
        fx, fy = readings[last, 0], readings[last, 1]
        onset = onsets(x0[last], none, gap)
        base = fx / fy - branch.demand(x0[last])
        ratio_spread = ratio_deviation(fx, fy, noise[0], noise[1])
    elif method is Method.MOMENT:
        onset = onsets(clamp[last] - contact, contact_spread, gap)
    else:
        moved = np.abs(np.diff(clamp))
        size = float(np.median(moved[moved > 0.0])) if step is None else step
        if not size > 0.0:
            raise ValueError(f"step must be positive, got {size!r}")
        early = missed_beginnings(np.append(0.0, gap[:-1]), size)
        onset = onsets(clamp[last] - clamp[first], none, gap) + early
        opened[0] = True
    sign = np.where(gap == 0.0, np.sign(clamp[last] - contact), np.sign(gap))
    found = summary(frictions(branch, onset, sign, base, ratio_spread))
    least = least_friction(
        branch,
        np.minimum.reduceat(clamp[rows], begins) - contact,
        np.maximum.reduceat(clamp[rows], begins) - contact,
        contact_spread,
    )
    # Pulled back from there a tip slips after all, but not pushed on.
    locked = (least >= branch.mu_lock) & (opened | (sign > 0.0))
    opened &= ~locked
    beyond = np.isnan(found.mean) & ~opened & ~locked
    for values in found:
        values[opened | locked] = np.nan
    found.low[opened | locked] = least[opened | locked]
    status = [
        Found.OPEN if o else Found.LOCK if k else Found.BEYOND if b else Found.SLIP
        for o, k, b in zip(opened, locked, beyond, strict=True)
    ]
    return Periods(status, first, last, branch.x1_init + contact, *found, notes)
