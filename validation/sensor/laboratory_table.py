"""Judge the friction identified from the recordings of `laboratory`, and make a table of it.

If the tolerances allow for the set-up error, an entry fails if significantly fewer than 93 % of the
intervals contain the truth, or if too many recordings are doubted or refused; significantly more
than 99 % are marked. The standard error of this coverage is that over the n recordings, and at
least √(0.95·0.05·(r + (1 − r)/p)/n): an error that is common to all p periods of a recording, with
a share r of their variance, makes all their intervals contain the truth, or none. If the tolerances
do not allow for the error, the entry fails if more than one recording in twenty is silently wrong.
"""

from dataclasses import dataclass

import numpy as np
from scipy.stats import binom

from validation.sensor.laboratory_rows import ROWS, Said, sign_of

# Stated coverage, and bounds of the observed coverage.
STATED, LOW, HIGH = 0.95, 0.93, 0.99
# Half the width of an interval with the stated coverage, in standard deviations.
HALF_WIDTH = 1.96
# Deviation from these bounds that is allowed, in standard errors.
ERRORS = 2.0
# Share of recordings that may be silently wrong or, with the right tolerances, not accepted.
SILENT = 0.05
# There are too many false alarms if their number has a lower probability than this.
UNLIKELY = 0.01


@dataclass(frozen=True, kw_only=True)
class Judged:
    """Verdict on the recordings of one entry by one method.

    Attributes
    ----------
    covered, error : float
        Share of intervals that contain the truth, and its standard error; NaN without intervals.
    fails : tuple of str
        Reasons why the entry fails.
    conservative : bool
        Whether the intervals contain the truth more often than stated.
    """

    covered: float
    error: float
    fails: tuple[str, ...] = ()
    conservative: bool = False


def judged(row, said, scores):
    """Judge one entry by its scores, one for each seed."""
    covered, error = _coverage(scores)
    if not row.contained(said):
        silent = sum(one.silent for one in scores)
        many = silent > SILENT * len(scores)
        return Judged(covered=covered, error=error, fails=("silently wrong",) * many)
    noticed = sum(not one.accepted for one in scores)
    alarms = binom.sf(noticed - 1, len(scores), SILENT) < UNLIKELY
    fails = ("doubted",) * bool(alarms)
    fails += ("covers too little",) * bool(covered + ERRORS * error < LOW)
    conservative = bool(covered - ERRORS * error > HIGH)
    return Judged(covered=covered, error=error, fails=fails, conservative=conservative)


def _coverage(scores):
    """Return the coverage, and its standard error over recordings."""
    some = [one for one in scores if one.read]
    if not some:
        return np.nan, np.nan
    covered = np.array([one.covered for one in some])
    shared = np.mean([one.shared + (1.0 - one.shared) / max(one.periods, 1) for one in some])
    variance = max(covered.var(ddof=min(1, len(some) - 1)), STATED * (1.0 - STATED) * shared)
    return float(covered.mean()), float(np.sqrt(variance / len(some)))


def by_line(scores):
    """Group scores by (row, method), then by tolerances, then by seed in increasing order."""
    found = {}
    for (number, said, seed), of_methods in sorted(scores.items(), key=lambda one: one[0][2]):
        for method, one in of_methods.items():
            ways = found.setdefault((number, method), {})
            ways.setdefault(said, {})[seed] = one
    return dict(sorted(found.items(), key=lambda item: item[0][0]))


def passes(scores):
    """Return whether there are lines, and none fails."""
    lines = by_line(scores)
    return bool(lines) and all(_verdict(*line, ways) == PASS for line, ways in lines.items())


PASS = "pass"


def _verdict(number, method, ways):
    """Format the verdict on a line of the table."""
    found = [
        f"{said}: {why}"
        for said, scores in sorted(ways.items(), key=lambda item: list(Said).index(item[0]))
        for why in judged(ROWS[number], said, list(scores.values())).fails
    ]
    return f"**fails** ({', '.join(found)})" if found else PASS


HEADER = (
    "| set-up error | method | default: bias | 95 % ± | covered | noticed "
    "| right: bias | 95 % ± | covered | noticed | small: noticed | verdict |\n"
    + "| --- " * 12
    + "|"
)


def table(scores):
    """Yield the text of the record: a table line for each row and method, then a summary.

    Parameters
    ----------
    scores : mapping
        From (row number, tolerances, seed) to a mapping from method to `Score`.
    """
    lines = by_line(scores)
    seeds = sorted({seed for _, _, seed in scores})
    yield f"{len(seeds)} recordings for each entry, with the seeds {_ranges(seeds)}.\n"
    yield HEADER
    for (number, method), ways in lines.items():
        yield _shown(number, method, ways)
    yield ""
    failing = sum(_verdict(*line, ways) != PASS for line, ways in lines.items())
    yield f"{failing} of {len(lines)} lines fail."
    yield ""
    for method in dict.fromkeys(method for _, method in lines):
        yield _pooled(lines, method)


def _ranges(seeds):
    """Write increasing numbers as ranges, such as ``1 to 20, 40 to 59``."""
    begins = [one for one in seeds if one - 1 not in seeds]
    ends = [one for one in seeds if one + 1 not in seeds]
    return ", ".join(f"{begin} to {end}" for begin, end in zip(begins, ends, strict=True))


def _shown(number, method, ways):
    """Format a line of the table in Markdown."""
    cells = [ROWS[number].title, str(method)]
    for said in (Said.NOTHING, Said.ENOUGH):
        if said not in ways:
            cells += [""] * 4
            continue
        scores = list(ways[said].values())
        found = judged(ROWS[number], said, scores)
        more = ", more than it says" if found.conservative else ""
        shown = f"{100.0 * found.covered:.0f} ± {100.0 * found.error:.0f} %{more}"
        cells += [
            *_biased(ROWS[number], ways[said], said),
            shown if np.isfinite(found.covered) else "–",
        ]
        cells.append(_noticed(scores))
    cells.append(_noticed(ways[Said.LITTLE].values()) if Said.LITTLE in ways else "")
    return f"| {' | '.join([*cells, _verdict(number, method, ways)])} |"


def _biased(row, scores, said):
    """Format the mean bias, signed by the error's direction, and half the 95 % interval."""
    some = {seed: one for seed, one in scores.items() if one.read}
    if not some:
        return "–", "–"
    both = said is not Said.ENOUGH and row.tolerances
    signs = [sign_of(seed) if both else 1.0 for seed in some]
    bias = np.mean([sign * one.bias for sign, one in zip(signs, some.values(), strict=True)])
    return f"{bias:+.4f}", f"{np.mean([one.half for one in some.values()]):.4f}"


def _noticed(scores):
    """Format the numbers of refused, doubted and silently wrong recordings."""
    refused = sum(not one.read for one in scores)
    doubted = sum(one.read and one.doubted for one in scores)
    silent = sum(one.silent for one in scores)
    parts = [f"{refused} refused" * bool(refused), f"{doubted} doubted" * bool(doubted)]
    parts.append(f"{silent} silently wrong" * bool(silent))
    return ", ".join(filter(None, parts)) or "–"


def _pooled(lines, method):
    """Summarise all rows of one method, with the standard error over recordings."""
    scores = {said: [] for said in Said}
    for (number, own), ways in lines.items():
        for said, of_seeds in ways.items():
            if own == method and (said is not Said.ENOUGH or ROWS[number].contained(said)):
                scores[said] += of_seeds.values()
    if not scores[Said.ENOUGH]:
        return f"- `{method}`: {_means(lines, method)}"
    covered, error = _coverage(scores[Said.ENOUGH])
    silent = ", ".join(
        f"{sum(one.silent for one in scores[said])} of {len(scores[said])} ({name})"
        for said, name in ((Said.NOTHING, "default"), (Said.LITTLE, "small"))
    )
    return (
        f"- `{method}`: {100.0 * covered:.1f} ± {100.0 * error:.1f} % of the intervals hold the "
        f"truth with the right tolerances; silently wrong: {silent}. {_means(lines, method)}"
    )


def _means(lines, method):
    """Say how often the mean is in its interval if all errors are drawn, and what is doubted."""
    drawn = [
        one
        for (number, own), ways in lines.items()
        if own == method and ROWS[number].all_at_once
        for one in ways[Said.NOTHING].values()
    ]
    scores = np.array([one.score for one in drawn if one.read])
    if not len(scores):
        return ""
    inside = np.mean(np.abs(scores) < HALF_WIDTH)
    error = np.sqrt(STATED * (1.0 - STATED) / len(scores))
    doubted = sum(not one.accepted for one in drawn)
    return (
        f"All errors drawn: the mean is in its interval in {100.0 * inside:.1f} ± "
        f"{100.0 * error:.1f} % of {len(scores)} recordings, its errors have the root mean square "
        f"{np.sqrt(np.mean(scores**2)):.2f} in standard deviations; {doubted} are doubted."
    )
