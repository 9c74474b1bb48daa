"""Stick-slip scans as presets of the explorer: the page solves what the table holds."""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from vibrissa.explorer.page import Preset, Recording, fits
from vibrissa.report.spelling import symbol
from vibrissa.report.tables import POINT, SCAN
from vibrissa.tables import query
from vibrissa.tables.query import Readable
from vibrissa.wording import counted

# What a page can carry: rows of all scans together, and scans.
MOST_ROWS = 12_000
MOST_SCANS = 60
MOUNTING = ("clamp_angle", "clamp_compliance", "curvature", "stage_angle")
# Positions (L), forces and moments have as many decimals as can be seen.
DECIMALS = 5
COLUMNS = {"clamp": "footpoint", "fx": "reaction_fx", "fy": "reaction_fy", "m": "reaction_m"}


@dataclass(frozen=True, kw_only=True)
class Motion:
    """What a page offers of the scans.

    Attributes
    ----------
    presets : tuple of Preset
    notes : tuple of str
        What is not offered, and why.
    """

    presets: tuple[Preset, ...]
    notes: tuple[str, ...]


def motion(scans: Readable) -> Motion:
    """Choose the scans that the explorer can repeat.

    Parameters
    ----------
    scans : pyarrow.Table or Dataset
        With the schema `SCANS`.

    Returns
    -------
    Motion
        Of the first `MOST_SCANS` scans that are mounted as in the paper and within the range of the
        page's fields. Each carries its rows, thinned out where there are many.
    """
    table = query.frame(scans, scans.schema.names)
    table = table[table["footpoint"].notna()]
    groups = [rows for _, rows in table.groupby([*SCAN, *MOUNTING], sort=False, dropna=False)]
    ideal = [rows for rows in groups if not rows[list(MOUNTING)].any(axis=None)]
    offered = [rows for rows in ideal if fits(_settings(rows))]
    notes = []
    if others := len(groups) - len(ideal):
        notes.append(f"Not offered, as not mounted as in the paper: {counted(others, 'scan')}.")
    if others := len(ideal) - len(offered):
        notes.append(f"Not offered, as outside of the fields' range: {counted(others, 'scan')}.")
    if len(offered) > MOST_SCANS:
        notes.append(f"These are the first {MOST_SCANS} of {len(offered)} scans.")
    offered = offered[:MOST_SCANS]
    presets = tuple(_preset(rows, MOST_ROWS // len(offered)) for rows in offered)
    return Motion(presets=presets, notes=tuple(notes))


def _settings(rows: pd.DataFrame) -> dict[str, float | str]:
    """Values of the page's fields."""
    lies = bool((rows["s_c"] < 1.0).any())
    # Only a round rod has a margin out of its plane; shooting does not tell.
    planar = rows["stability_aside"].isna().all() and bool((rows["method"] == "collocation").all())
    return {
        **{name: float(rows.iloc[0][name]) for name in POINT},
        "contact": "line" if lies else "point",
        "section": "planar" if planar else "round",
        "law": "free",
        "units": "none",
    }


def _preset(rows: pd.DataFrame, most: int) -> Preset:
    first = rows.iloc[0]
    axes = ", ".join(f"{symbol(name)} = {first[name]:g}" for name in POINT)
    kept = rows.iloc[np.linspace(0, len(rows) - 1, min(len(rows), most)).astype(int)]
    values = {
        name: (kept[column].round(DECIMALS) + 0.0).tolist() for name, column in COLUMNS.items()
    }
    return Preset(
        name=f"{first['scan']}: {axes}{' (self-locking)' * (first['status'] == 'lock')}",
        note="Green: what the table of this study has.",
        settings=_settings(rows),
        recording=Recording(name=str(first["scan"]), **values),
        play=True,
    )
