"""Scans of a study as presets of the explorer, which solves them again."""

from collections.abc import Mapping
from typing import Any, TypeAlias

import numpy as np
import pandas as pd
import yaml

from vibrissa.explorer.page import IDEAL, MOUNTED, PAPER, Preset, Recording, fits
from vibrissa.outcomes import Contact, RodSection
from vibrissa.report.spelling import symbol
from vibrissa.report.tables import MOUNTING, POINT, SCAN
from vibrissa.study.axes import MOUNTING_AXES, in_list
from vibrissa.tables import query
from vibrissa.tables.query import Readable
from vibrissa.tables.schemas import SHAPE
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

    The presets are the first `MOST_SCANS` scans that have the ideal mounting and parameters within
    the ranges of the explorer's fields. Long scans are thinned out. Each preset is named after the
    figure that shows its scan. If several figures show it, the one whose selection has the most
    keys counts. If there are no such scans, the explorer's own presets are returned.
    """
    scans = _solved(found["scans"]) if "scans" in found else []
    offered = [scan for scan in scans if _is_repeatable(scan.iloc[0])][:MOST_SCANS]
    lost = len(scans) - len(offered)
    why = f"it shows {MOST_SCANS} at most, in the ideal mounting, with values that its fields allow"
    note = f"The explorer leaves out {counted(lost, 'scan')}: {why}." if lost else ""
    if not offered:
        return (*PAPER, *MOUNTED), note
    shared, most = _shared(found["scans"]), MOST_ROWS // len(offered)
    return tuple(_preset(rows, shared, most, figures) for rows in offered), note


def _is_repeatable(step: pd.Series) -> bool:
    is_ideal = not step[list(MOUNTING_AXES)].any() and pd.isna(step["curvature_powers"])
    return is_ideal and fits(dict(step[list(POINT)]))


def _solved(scans: Readable) -> list[pd.DataFrame]:
    """Split the rows by scan; omit scans without a result."""
    shapes = {field.name for field in SHAPE}
    rows = query.frame(scans, [name for name in scans.schema.names if name not in shapes])
    rows = rows[rows["footpoint"].notna()]
    groups = rows.groupby([*SCAN, *MOUNTING], sort=False, dropna=False)
    return [scan for _, scan in groups]


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
        recording=Recording(name=figure_name(str(first["scan"])), **values),
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
