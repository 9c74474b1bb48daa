"""Does the sensor know what it does not know? Recordings of a bench that differs from what is said.

A steel rod of 1 mm x 100 mm, θ = 2 at 85 mm, moves 60 mm in steps of 20 µm over a surface of
friction 0.30 ± 0.02. Slips are kinetic with κ = 0.8; the noise is 3 mN and 10 µN·m. The bench
(`bench`, `bench_rod`) shares no code with the package. Each mistake (`mistakes`) is read in four
ways, see `Said`.
"""

import argparse
import multiprocessing
import os
from collections.abc import Mapping
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import partial
from importlib import import_module
from pathlib import Path

import numpy as np
import pandas as pd
from bench import scan
from mistakes import (
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
from vibrissa.sensor import Method, PeriodStatus, SlipLaw, Whisker, identify
from vibrissa.sensor.given.tolerances import assumed_tolerances

NOISE = np.array([3e-3, 3e-3, 1e-5]) / UNITS
STEP, WAY = 2e-4, 0.6
DEGREE = np.pi / 180.0
# Those that need the rod.
METHODS = (Method.FORCES, Method.MOMENT, Method.SPACING)
# A recording is doubted if at least this part of its frictions is.
DOUBTED = 0.5
BEGIN, END = "<!-- table of make laboratory -->", "<!-- end of the table -->"


class Said(StrEnum):
    """What a laboratory says of a mistake.

    Attributes
    ----------
    NOTHING
        The tolerances that are assumed count. The mistake has its size, in turn with both signs.
    ENOUGH
        Its size is the tolerance, one standard deviation; all else is exact.
    DRAWN
        The same, and the mistake is drawn from that tolerance.
    LITTLE
        A tenth of its size is the tolerance; all else is exact.
    """

    NOTHING = "nothing"
    ENOUGH = "enough"
    DRAWN = "drawn"
    LITTLE = "little"


@dataclass(frozen=True, kw_only=True)
class Row:
    """A mistake of the table.

    Attributes
    ----------
    title : str
    sizes : mapping of str to float
        Size of each of `MISTAKES`, all of which are made.
    surface : float
        Inclination of the surface (rad), of which clamp, stage and transducer know nothing.
    law : SlipLaw
        That is given for the spacing.
    on_the_way : bool
        Whether the tip slips while the stage moves, and not while it rests.
    all_at_once : bool
        Whether everything is drawn from the tolerances that are assumed.
    """

    title: str
    sizes: Mapping[str, float]
    surface: float = 0.0
    law: SlipLaw = SlipLaw.KINETIC
    on_the_way: bool = False
    all_at_once: bool = False

    @property
    def tolerances(self):
        """Standard deviations of which the mistake is one."""
        angles = dict.fromkeys(("clamp_angle", "stage_angle", "transducer_angle"), self.surface)
        return {**self.sizes, **(angles if self.surface else {})}

    @property
    def ways(self):
        """What may be said of it."""
        return list(Said) if self.tolerances else [Said.NOTHING]


def _one(title, name, size):
    return Row(title=title, sizes={name: size})


_DRIFT = 0.02 / UNITS[0]
ROWS = (
    Row(title="nothing", sizes={}),
    Row(title="everything, drawn from what is assumed", sizes={}, all_at_once=True),
    _one("clamp inclined by 2°", "clamp_angle", 2.0 * DEGREE),
    _one("clamp inclined by 0.5°", "clamp_angle", 0.5 * DEGREE),
    _one("E 5 % off", "modulus", 0.05),
    _one("E 1 % off", "modulus", 0.01),
    _one("θ 2.1 for 2", "theta", 0.1),
    _one("θ 2.02 for 2", "theta", 0.02),
    _one("η 1 % off", "eta", 0.0085),
    _one("clamp yields by 0.5°", "clamp_compliance", 0.018),
    _one("rod bent by 1 % of its length", "curvature", 0.08),
    _one("moment taken 1 mm beside", "moment_origin_x", 0.01),
    _one("moment taken 1 mm below", "moment_origin_y", 0.01),
    Row(title="surface inclined by 0.5°", sizes={}, surface=0.5 * DEGREE),
    _one("transducer turned by 1°", "transducer_angle", DEGREE),
    _one("transducer turned by 0.3°", "transducer_angle", 0.3 * DEGREE),
    _one("crosstalk 1 %", "crosstalk", 0.01),
    _one("stage scale 1 % off", "stage_scale", 0.01),
    Row(
        title="zeros of both forces drift by 20 mN",
        sizes={"drift_force_x": _DRIFT, "drift_force_y": _DRIFT},
    ),
    _one("κ 0.05 off", "kinetic_ratio", 0.05),
    Row(title="law free, but slips are kinetic", sizes={}, law=SlipLaw.FREE),
    Row(title="tip slips while the stage moves", sizes={}, on_the_way=True),
)


@dataclass(frozen=True, kw_only=True)
class Score:
    """How one recording was read.

    Attributes
    ----------
    read : bool
        Whether there is any friction: otherwise the recording was refused.
    doubted : bool
        Whether at least half of the frictions are in doubt.
    bias, half : float
        Mean error of μ0, and mean of half the width of the 95 % interval.
    covered : float
        Part of the intervals that hold the true friction.
    """

    read: bool
    doubted: bool = True
    bias: float = np.nan
    half: float = np.nan
    covered: float = np.nan

    @property
    def accepted(self):
        """Whether it was read and is not in doubt."""
        return self.read and not self.doubted

    @property
    def silent(self):
        """Whether it is wrong and nothing says so."""
        return self.accepted and abs(self.bias) > self.half


def recorded(row, said, seed):
    """Simulate a recording: what a laboratory has, and the scan that it is of."""
    generator = np.random.default_rng([seed, 2])
    bench = replace(bench_of(seed), at_rest=not row.on_the_way)
    sign = _sign(seed)
    if row.all_at_once:
        bench = everything(bench, assumed_tolerances(believed().units, NOISE), generator)
    if row.surface:
        size = row.surface * (generator.normal() if said is Said.DRAWN else sign)
        bench = SURFACE.fixed(bench, size)
    for name, size in row.sizes.items():
        mistake = MISTAKES[name]
        if said is Said.DRAWN:
            bench = mistake.drawn(bench, size, generator)
        else:
            bench = mistake.fixed(bench, sign * size)
    found = scan(bench, STEP, [WAY], NOISE, seed)
    loads = (found.readings * UNITS).T
    names = ("force_x [N]", "force_y [N]", "moment_z [N*m]")
    frame = pd.DataFrame({"footpoint [mm]": found.stage * LENGTH * 1e3})
    return frame.assign(**dict(zip(names, loads, strict=True))), found


def _sign(seed):
    """Sign of a mistake of a fixed size: both in turn."""
    return 1.0 if seed % 2 else -1.0


def believed():
    """Make the whisker that the laboratory believes in."""
    sizes = {"modulus": f"{MODULUS} Pa", "diameter": f"{DIAMETER} m", "length": f"{LENGTH} m"}
    return Whisker.read(THETA, "85 mm", **sizes)


def read(frame, row, said, method):
    """Read a recording as a laboratory does."""
    part = {Said.NOTHING: 0.0, Said.LITTLE: 0.1}.get(said, 1.0)
    stated = {name: part * abs(size) for name, size in row.tolerances.items() if part}
    return identify(
        believed(),
        frame,
        method=method,
        noise=NOISE,
        law=row.law,
        kinetic_ratio=0.8,
        tolerances=stated,
        assume=said is Said.NOTHING,
    )


def scored(frame, truth, row, said, method):
    """Read a recording and compare it with what is true."""
    try:
        periods = read(frame, row, said, method).periods
    except VibrissaError:
        return Score(read=False)
    known = periods.status == PeriodStatus.SLIP
    if not known.any():
        return Score(read=False)
    mu0 = truth.mu0[periods.last[known]]
    low, high = periods.low[known], periods.high[known]
    grave = np.isin(periods.grade[known], ["doubtful", "wrong"])
    return Score(
        read=True,
        doubted=bool(grave.mean() >= DOUBTED),
        bias=float(np.mean(periods.mu0[known] - mu0)),
        half=float(np.mean(0.5 * (high - low))),
        covered=float(np.mean((low <= mu0) & (mu0 <= high))),
    )


def of_entry(entry, methods):
    """Scores of one recording by each method; an entry is a row, what is said of it, and a seed."""
    number, said, seed = entry
    row = ROWS[number]
    frame, truth = recorded(row, said, seed)
    return entry, {method: scored(frame, truth, row, said, method) for method in methods}


def shown(row, method, scores):
    """One line of the table in Markdown; `scores` maps what was said to scores in order of seed."""
    nothing = scores[Said.NOTHING]
    cells = [row.title, method, *_biased(nothing), _covered(nothing), _noticed(nothing)]
    for said in (Said.ENOUGH, Said.DRAWN):
        cells += [_covered(scores[said]), _noticed(scores[said])] if said in scores else ["", ""]
    cells.append(_noticed(scores[Said.LITTLE]) if Said.LITTLE in scores else "")
    return f"| {' | '.join(cells)} |"


def _biased(scores):
    """Bias of what was read, in the direction of the mistake, and half of the 95 %."""
    some = [one for one in scores if one.read]
    if not some:
        return "", ""
    signs = np.array([_sign(seed) for seed, one in enumerate(scores) if one.read])
    bias = np.mean(signs * [one.bias for one in some])
    return f"{bias:+.4f}", f"{np.mean([one.half for one in some]):.4f}"


def _covered(scores):
    covered = [one.covered for one in scores if one.read]
    return f"{100.0 * np.mean(covered):.0f} %" if covered else ""


def _noticed(scores):
    """How many are refused, doubted and silently wrong."""
    refused = sum(not one.read for one in scores)
    doubted = sum(one.read and one.doubted for one in scores)
    silent = sum(one.silent for one in scores)
    parts = [f"{refused} refused" * bool(refused), f"{doubted} doubted" * bool(doubted)]
    parts.append(f"**{silent} silently wrong**" * bool(silent))
    return ", ".join(filter(None, parts)) or "–"


HEADER = (
    "| what is off | method | nothing said: bias | 95 % ± | covered | noticed "
    "| enough, fixed: covered | noticed | enough, drawn: covered | noticed | a tenth: noticed |\n"
    + "| --- " * 11
    + "|"
)


def table(scores):
    """Lines of the page: a table for all rows and methods, and what it shows.

    Parameters
    ----------
    scores : mapping
        From (row, what is said, seed) to a `Score` for each method.
    """
    methods = list(dict.fromkeys(method for found in scores.values() for method in found))
    by_row = {}
    for (number, said, _), found in sorted(scores.items()):
        for method, one in found.items():
            by_row.setdefault((number, method), {}).setdefault(said, []).append(one)
    drawn = max((seed for _, said, seed in scores if said is Said.DRAWN), default=-1) + 1
    fixed = max((seed for _, said, seed in scores if said is not Said.DRAWN), default=-1) + 1
    yield f"{fixed} recordings for each entry, and {drawn} where the mistake is drawn.\n"
    yield HEADER
    for (number, method), one in sorted(by_row.items(), key=lambda item: item[0][0]):
        yield shown(ROWS[number], method, one)
    yield ""
    for method in methods:
        yield _pooled(by_row, method)


def _pooled(by_row, method):
    """Say what all rows show of one method, with the standard error over recordings."""
    said = {way: [] for way in Said}
    for (_, own), ways in by_row.items():
        for way, scores in ways.items():
            said[way] += scores if own == method else []
    covered = np.array([one.covered for one in said[Said.DRAWN] if one.read])
    error = covered.std() / np.sqrt(max(len(covered), 1))
    part = f"{100.0 * covered.mean():.1f} ± {100.0 * error:.1f} %" if len(covered) else "none"
    silent = ", ".join(
        f"{sum(one.silent for one in said[way])} of {len(said[way])} ({name})"
        for way, name in (
            (Said.NOTHING, "nothing said"),
            (Said.ENOUGH, "enough, fixed"),
            (Said.DRAWN, "enough, drawn"),
            (Said.LITTLE, "a tenth"),
        )
    )
    return (
        f"- `{method}`: {part} of the intervals hold the truth where it is drawn; silently wrong: "
        f"{silent}."
    )


def main():
    """Print or write the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=20, help="recordings for each entry")
    parser.add_argument("--drawn", type=int, help="the same where mistakes are drawn")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--docs", type=Path, help="page into which the table is written")
    parser.add_argument("--row", type=int, action="append", help="only these rows, from 0")
    parser.add_argument("--method", action="append", choices=list(Method), help="only these")
    arguments = parser.parse_args()

    methods = [Method(name) for name in arguments.method or METHODS]
    drawn = arguments.seeds if arguments.drawn is None else arguments.drawn
    # All rows once, then once more, so that an interrupted run has seen all of them.
    entries = sorted(
        (
            (number, said, seed)
            for number in arguments.row or range(len(ROWS))
            for said in ROWS[number].ways
            for seed in range(drawn if said is Said.DRAWN else arguments.seeds)
        ),
        key=lambda entry: entry[2],
    )
    scores = {}
    with multiprocessing.Pool(arguments.workers, initializer=_prepared) as pool:
        for entry, found in pool.imap_unordered(partial(of_entry, methods=methods), entries):
            scores[entry] = found
    text = "\n".join(table(scores))
    print(text)
    if arguments.docs is not None:
        before, _, rest = arguments.docs.read_text(encoding="utf-8").partition(BEGIN)
        after = rest.partition(END)[2]
        with write_atomically(arguments.docs) as temporary:
            temporary.write_text(f"{before}{BEGIN}\n{text}\n{END}{after}", encoding="utf-8")


def _prepared():
    """Begin a process: other work comes first, and methods that adjust the same do so once."""
    os.nice(15)
    module = import_module("vibrissa.sensor.identification.identify")
    adjusted, last = module._adjusted, {}

    def once(rod, recording, given, transducer, asked, progress):
        spaced = asked.method is Method.SPACING
        key = recording.readings.tobytes(), spaced, asked.assume, *sorted(rod.tolerances.items())
        if key not in last:
            last.clear()
            last[key] = adjusted(rod, recording, given, transducer, asked, progress)
        return last[key]

    module._adjusted = once


if __name__ == "__main__":
    main()
