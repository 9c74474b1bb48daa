"""Scans of a study as presets of the explorer, which solves them again."""

from collections.abc import Mapping
from typing import Any, TypeAlias

import numpy as np
import pandas as pd
import yaml

from vibrissa.explorer.page import IDEAL, MOUNTED, PAPER, Preset, RecordedMotion, fits
from vibrissa.outcomes import NO_RESULT, Contact, RodSection, SlipLaw
from vibrissa.report.spelling import symbol
from vibrissa.report.tables import POINT
from vibrissa.study.axes import MOUNTING_AXES, POWERS, in_list
from vibrissa.tables.counts import SCAN, rows_of, scan_keys
from vibrissa.tables.query import Readable
from vibrissa.wording import counted, figure_name

# Largest number of rows of all scans together in a page, and of scans.
MOST_ROWS, MOST_SCANS = 12_000, 60
# Decimals of positions (L), forces and moments: further ones cannot be seen.
DECIMALS = 5
COLUMNS = {"clamp": "footpoint", "fx": "reaction_fx", "fy": "reaction_fy", "m": "reaction_m"}
# Selection of the rows of each figure, by the figure's name.
Selections: TypeAlias = Mapping[str, Mapping[str, Any]]


def motion(found: Mapping[str, Readable], figures: Selections) -> tuple[tuple[Preset, ...], str]:
    """Choose the presets of the explorer in the report; return them and a note on omitted scans.

    The presets are the first `MOST_SCANS` scans on a plane by the law ``free`` that have the ideal
    mounting and parameters within the ranges of the explorer's fields. Long scans are thinned out.
    Each preset is named after the figure that shows its scan. If several figures show it, the one
    whose selection has the most keys counts. If there are no such scans, the explorer's own presets
    are returned.
    """
    offered, lost = [], 0
    if "scans" in found:
        shown, count = pd.DataFrame(), 0
        for scans in scan_keys(found["scans"]):
            solved = scans[~scans["status"].isin(NO_RESULT)]
            count += len(solved)
            if len(shown) < MOST_SCANS:
                repeatable = solved[[_is_repeatable(scan) for _, scan in solved.iterrows()]]
                shown = pd.concat([shown, repeatable]).head(MOST_SCANS)
        offered = _steps(found["scans"], shown) if len(shown) else []
        lost = count - len(offered)
    why = (
        f"it shows {MOST_SCANS} at most, in the ideal mounting, forward over a plane by the law "
        "free, with values that its fields allow"
    )
    note = f"The explorer leaves out {counted(lost, 'scan')}: {why}." if lost else ""
    if not offered:
        return (*PAPER, *MOUNTED), note
    shared, most = _shared(found["scans"]), MOST_ROWS // len(offered)
    return tuple(_preset(rows, shared, most, figures) for rows in offered), note


def _is_repeatable(scan: pd.Series) -> bool:
    mounting = scan[[*MOUNTING_AXES]].any() or scan[[*POWERS.values()]].notna().any()
    is_free = scan["law"] == SlipLaw.FREE and pd.notna(scan["mu0"])
    return not mounting and is_free and fits(dict(scan[list(POINT)]))


def _steps(table: Readable, scans: pd.DataFrame) -> list[pd.DataFrame]:
    """Return the steps of each scan; leave out scans that go back."""
    rows = rows_of(table, [*COLUMNS.values(), "status"], scans)
    steps = [scan for _, scan in rows.groupby([*SCAN], sort=False, dropna=False)]
    return [scan for scan in steps if scan["footpoint"].is_monotonic_increasing]


def _shared(table: Readable) -> dict[str, float | str]:
    """Return the values of the explorer's fields that are the same for all scans."""
    study = yaml.safe_load((table.schema.metadata or {}).get(b"vibrissa.study", b"")) or {}
    kinds = {"contact": Contact.POINT.value, "section": RodSection.ROUND.value}
    chosen = {name: study.get(name, default) for name, default in kinds.items()}
    return {**chosen, "law": "free", "units": "none", **IDEAL}


def _preset(
    scan: pd.DataFrame, shared: Mapping[str, float | str], most: int, figures: Selections
) -> Preset:
    first = scan.iloc[0]
    kept = scan.iloc[np.linspace(0, len(scan) - 1, min(len(scan), most)).astype(int)]
    values = {
        name: (kept[column].round(DECIMALS) + 0.0).tolist() for name, column in COLUMNS.items()
    }
    axes = ", ".join(f"{symbol(name)} = {first[name]:g}" for name in POINT)
    locks = " (self-locking)" if first["status"] == "lock" else ""
    return Preset(
        name=f"{_figure_of(first, figures)}: {axes}{locks}",
        note="Green: stored study values.",
        settings={**{name: float(first[name]) for name in POINT}, **shared},
        recording=RecordedMotion(name=figure_name(str(first["scan"])), **values),
        play=True,
    )


def _figure_of(scan: pd.Series, figures: Selections) -> str:
    """Name the figure that selects a scan by the most keys, or else its set of scans."""
    showing = {
        name: len(selection)
        for name, selection in figures.items()
        if "scan" in selection
        and all(scan[key] in in_list(values) for key, values in selection.items())
    }
    return max(showing, key=showing.__getitem__, default=figure_name(str(scan["scan"])))
