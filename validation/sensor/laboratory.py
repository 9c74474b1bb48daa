"""Uncertainty under set-up errors: recordings of a bench that differs from the stated set-up.

A steel rod of 1 mm x 100 mm, θ = 2 at 85 mm, moves 20 mm in steps of 20 µm over a surface of
friction 0.30 ± 0.02. Slips are kinetic with κ = 0.8; the noise is 3 mN and 10 µN·m. The bench
(`bench`, `bench_rod`) shares no code with the package. Each line is a set-up error (`mistakes`).
Each method identifies the friction with the default tolerances, with the size of the error as its
tolerance ("right"), and with a tenth of this size ("small"). Covered: share of the 95 % intervals
that contain the true friction. Silently wrong: the mean error exceeds half the width of the
interval, and the recording is not doubted.
"""

import argparse
import multiprocessing
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd

from validation.records import write_record
from validation.sensor.bench import scan
from validation.sensor.bench_rod import NoStateError
from validation.sensor.laboratory_rows import ROWS, Said, sign_of
from validation.sensor.laboratory_table import passes, table
from validation.sensor.mistakes import (
    DIAMETER,
    LENGTH,
    MISTAKES,
    MODULUS,
    SURFACE,
    THETA,
    UNITS,
    bench_of,
    everything,
)
from vibrissa.errors import VibrissaError
from vibrissa.files import write_atomically
from vibrissa.outcomes import Method
from vibrissa.quantities.units import Kind
from vibrissa.sensor import PeriodStatus, Setup, identify
from vibrissa.sensor.identification.friction_summary import used_in_mean
from vibrissa.sensor.identification.identify import identify_by
from vibrissa.sensor.tolerances import TOLERABLE, assumed_tolerances

NOISE = np.array([3e-3, 3e-3, 1e-5]) / UNITS
STEP, WAY = 2e-4, 0.2
METHODS = tuple(Method)
# A recording is doubted if at least this share of its friction values is doubted.
DOUBTED = 0.5
# First seed of the table: it has no seed that was used to choose a setting.
FIRST = 1000
# Recordings with all errors drawn for each recording of another entry: the means of few recordings
# do not show whether 95 % of them are in their intervals.
DRAWN = 10


@dataclass(frozen=True, kw_only=True)
class Score:
    """Result of one recording.

    Attributes
    ----------
    read : bool
        Whether friction was identified; if not, the recording was refused.
    doubted : bool
        Whether at least half of the friction values are doubted.
    bias, half : float
        Mean error of μ0, and mean of half the width of the 95 % interval.
    covered : float
        Share of the intervals that contain the true friction.
    shared : float
        Share of the stated variance that is common to all periods.
    periods : int
        Number of friction values.
    score : float
        Error of the mean friction, in its standard deviations.
    """

    read: bool
    doubted: bool = True
    bias: float = np.nan
    half: float = np.nan
    covered: float = np.nan
    shared: float = np.nan
    periods: int = 0
    score: float = np.nan

    @property
    def accepted(self):
        """Whether friction was identified and is not doubted."""
        return self.read and not self.doubted

    @property
    def silent(self):
        """Whether the friction is wrong and not doubted."""
        return self.accepted and abs(self.bias) > self.half


def recorded(row, said, seed):
    """Simulate a recording; return the laboratory's table, and the scan with its true values."""
    generator = np.random.default_rng([seed, 2])
    bench = replace(bench_of(seed), at_rest=not row.on_the_way, encoder=row.encoder)
    sign = sign_of(seed)
    if row.all_at_once:
        bench = everything(bench, assumed_tolerances(believed().whisker.units, NOISE), generator)
    drawn = said is Said.ENOUGH
    if row.surface:
        size = row.surface * (generator.normal() if drawn else sign)
        bench = SURFACE.fixed(bench, size)
    for name, size in row.sizes.items():
        mistake = MISTAKES[name]
        if drawn:
            bench = mistake.drawn(bench, size, generator)
        else:
            bench = mistake.fixed(bench, sign * size)
    found = scan(bench, STEP, [WAY], NOISE, seed)
    loads = (found.readings * UNITS).T
    names = ("force_x [N]", "force_y [N]", "moment_z [N*m]")
    frame = pd.DataFrame({"footpoint [mm]": found.stage * LENGTH * 1e3})
    frame = frame.assign(**dict(zip(names, loads, strict=True)))
    return frame.drop(columns="moment_z [N*m]") if row.forces_alone else frame, found


def believed(**stated):
    """Return the set-up as the laboratory states it."""
    sizes = {"modulus": f"{MODULUS} Pa", "diameter": f"{DIAMETER} m", "length": f"{LENGTH} m"}
    return Setup.read(theta=THETA, eta="85 mm", **sizes, **stated)


def in_words(noise):
    """Return the noise of the channels as a set-up states it."""
    return ", ".join(map(repr, noise.tolist()))


def stated(row, said):
    """Return the set-up with the tolerances that a laboratory states."""
    part = {Said.NOTHING: 0.0, Said.LITTLE: 0.1}.get(said, 1.0)
    tolerances = {}
    for name, size in row.tolerances.items():
        angle = TOLERABLE[name].kind is Kind.ANGLE
        if part:
            tolerances[name] = f"{part * abs(size)} rad" if angle else part * abs(size)
    assume = said is Said.NOTHING
    if row.without_rod:
        tolerances = {name: f"{size * UNITS[0]} N" for name, size in tolerances.items()}
        return Setup.read(noise=in_words(NOISE * UNITS), tolerances=tolerances, assume=assume)
    return believed(noise=in_words(NOISE), tolerances=tolerances, assume=assume)


def read(frame, row, said, method):
    """Identify the friction by one method, with the tolerances that a laboratory states."""
    return identify(stated(row, said), frame, method=method)


def scored(found, truth):
    """Compare the friction that was identified, or the refusal, with the truth."""
    if isinstance(found, VibrissaError):
        return Score(read=False)
    periods, summary = found.periods, found.summary()
    known = periods.status == PeriodStatus.SLIP
    if not known.any():
        return Score(read=False)
    mu0 = truth.mu0[periods.last[known]]
    low, high = periods.low[known], periods.high[known]
    used = used_in_mean(periods)
    error = summary.mean - truth.mu0[periods.last[used]].mean()
    grave = np.isin(periods.grade[known], ["doubtful", "wrong"])
    return Score(
        read=True,
        doubted=bool(grave.mean() >= DOUBTED),
        bias=float(np.mean(periods.mu0[known] - mu0)),
        half=float(np.mean(0.5 * (high - low))),
        covered=float(np.mean((low <= mu0) & (mu0 <= high))),
        shared=float(np.mean(periods.common[known] ** 2 / periods.deviation[known] ** 2)),
        periods=int(known.sum()),
        score=float(error / summary.deviation),
    )


def of_entry(entry, methods):
    """Score one recording by each method; an entry is (row number, tolerances, seed).

    There is no score of a drawn bench whose rod locks at one of the ratios of its table.
    """
    number, said, seed = entry
    row = ROWS[number]
    try:
        frame, truth = recorded(row, said, seed)
    except NoStateError:
        if said is not Said.ENOUGH and not row.all_at_once:
            raise
        return entry, {}
    some = [one for one in methods if one is Method.RATIO or not row.without_rod]
    by_method = identify_by(stated(row, said), frame, some)
    return entry, {
        method: scored(found, truth) for method, found in zip(some, by_method, strict=True)
    }


def written(path, scores):
    """Write all scores as a CSV table."""
    rows = [
        {"row": ROWS[number].title, "said": said, "seed": seed, "method": method, **asdict(score)}
        for (number, said, seed), by_method in scores.items()
        for method, score in by_method.items()
    ]
    with write_atomically(path) as temporary:
        pd.DataFrame(rows).to_csv(temporary, index=False)


def scores_in(path):
    """Read the scores that `written` wrote; none if there is no such file."""
    if path is None or not path.exists():
        return {}
    numbers = {row.title: number for number, row in enumerate(ROWS)}
    found = {}
    for one in pd.read_csv(path).to_dict("records"):
        entry = (numbers[one.pop("row")], Said(one.pop("said")), int(one.pop("seed")))
        method = Method(one.pop("method"))
        found.setdefault(entry, {})[method] = Score(**one)
    return found


def main():
    """Score all recordings and print the table; exit status 1 if a line fails."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=20, help="recordings for each entry")
    parser.add_argument(
        "--drawn",
        action="store_true",
        help="only recordings with all errors drawn, ten times as many",
    )
    parser.add_argument("--first", type=int, default=FIRST, help="the first of their seeds")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--record", action="store_true", help="write the record")
    parser.add_argument("--row", type=int, action="append", help="only these rows, from 0")
    parser.add_argument(
        "--scores",
        type=Path,
        help="file for the scores; those that it has count, and are not computed again",
    )
    arguments = parser.parse_args()
    rows, seeds = arguments.row or range(len(ROWS)), arguments.seeds
    if arguments.drawn:
        rows = [number for number, row in enumerate(ROWS) if row.all_at_once]
        seeds = DRAWN * arguments.seeds
    entries = [
        (number, said, seed)
        for seed in range(arguments.first, arguments.first + seeds)
        for number in rows
        for said in ROWS[number].ways
    ]
    scores = scores_in(arguments.scores)
    left = [entry for entry in entries if entry not in scores]
    with multiprocessing.Pool(arguments.workers) as pool:
        for entry, score in pool.imap_unordered(partial(of_entry, methods=METHODS), left):
            scores[entry] = score
            if arguments.scores is not None:
                written(arguments.scores, scores)
    scores = {entry: score for entry, score in scores.items() if entry[0] in rows}
    if locked := sum(not one for one in scores.values()):
        print(f"left out: {locked} of {len(scores)} recordings, whose rod locks")
    print("\n".join(table(scores)))
    if arguments.record:
        name, command = "laboratory", "laboratory"
        if arguments.drawn:
            name, command = "laboratory-drawn", "laboratory --drawn"
        write_record(name, __doc__, "\n".join(table(scores)), command)
    raise SystemExit(0 if passes(scores) else 1)
