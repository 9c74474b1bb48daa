"""Scans and points of a study as presets of the explorer: the page solves what the tables hold."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

import numpy as np
import pandas as pd
import yaml

from vibrissa.explorer.page import IDEAL, MOUNTED, PAPER, Preset, Recording, fits
from vibrissa.outcomes import Contact, RodSection
from vibrissa.report.spelling import spell, symbol
from vibrissa.report.tables import POINT, SCAN, corners
from vibrissa.tables import query
from vibrissa.tables.query import Readable
from vibrissa.wording import counted, figure_name

# What a page can carry: rows of all scans together, and scans.
MOST_ROWS = 12_000
MOST_SCANS = 60
MOUNTING = ("clamp_angle", "clamp_compliance", "curvature", "stage_angle")
# Positions (L), forces and moments have as many decimals as can be seen.
DECIMALS = 5
COLUMNS = {"clamp": "footpoint", "fx": "reaction_fx", "fy": "reaction_fy", "m": "reaction_m"}
# Rows that a figure shows, by its name.
Selections: TypeAlias = Mapping[str, Mapping[str, Any]]


@dataclass(frozen=True, kw_only=True)
class Motion:
    """What a page offers of the scans.

    Attributes
    ----------
    what : str
        What a preset is, such as ``a scan of the study``.
    presets : tuple of Preset
    notes : tuple of str
        What is not offered, and why.
    """

    what: str
    presets: tuple[Preset, ...]
    notes: tuple[str, ...] = ()


NOTHING = Motion(what="", presets=())


def motion(found: Mapping[str, Readable], figures: Selections) -> Motion:
    """Choose what the explorer of a study's page offers, so that there is something always.

    Parameters
    ----------
    found : mapping of pyarrow.Table or Dataset
        The study's tables by name.
    figures : mapping
        Rows that the study's figures show.

    Returns
    -------
    Motion
        The study's scans; without any, points of its grids; without any, the explorer's own.
    """
    scans = of_scans(found["scans"], figures) if "scans" in found else NOTHING
    chosen = scans
    if not chosen.presets and "stiction" in found:
        chosen = of_points(found["stiction"])
    if not chosen.presets:
        chosen = Motion(what="a figure of the paper", presets=(*PAPER, *MOUNTED))
    return replace(chosen, notes=scans.notes)


def of_points(points: Readable) -> Motion:
    """Choose the points of a study's grids that the explorer can show.

    Parameters
    ----------
    points : pyarrow.Table or Dataset
        With the schema `STICTION`.

    Returns
    -------
    Motion
        Of the corners and the middle of each grid, as far as they slip or lock, are mounted as in
        the paper and lie within the range of the page's fields.
    """
    text = (points.schema.metadata or {}).get(b"vibrissa.study", b"")
    study = yaml.safe_load(text) or {}
    same = {
        "contact": study.get("contact", Contact.POINT.value),
        "section": study.get("section", RodSection.ROUND.value),
        "law": "free",
        "units": "none",
        **IDEAL,
    }
    columns = (*POINT, *MOUNTING, "status", "x0_max", "x0_slip", "mu_lock")
    presets = []
    for name, rows in corners(points, columns).items():
        ideal = rows[~rows[list(MOUNTING)].any(axis=1) & rows["status"].isin(("slip", "lock"))]
        for row in ideal.to_dict("records"):
            settings = {**{axis: float(row[axis]) for axis in POINT}, **same}
            if fits(settings):
                presets.append(_of_point(figure_name(name), row, settings))
    return Motion(what="a point of the study", presets=tuple(presets[:MOST_SCANS]))


def _of_point(grid: str, row: Mapping[str, Any], settings: Mapping[str, float | str]) -> Preset:
    if row["status"] == "lock":
        note = f"In the study’s table the tip locks: μ_lock = {spell(row['mu_lock'])}."
        clamp = 0.0
    else:
        clamp = float(row["x0_max"])
        onset = f"exact onset {spell(row['x0_slip'])}"
        note = f"In the study’s table: x0,max = {spell(clamp)}, {onset}."
    return Preset(name=_named(grid, row), note=note, settings=settings, clamp=clamp)


def _named(source: str, row: Mapping[str, Any]) -> str:
    """Name of the preset of a scan or of a point of a grid."""
    axes = ", ".join(f"{symbol(name)} = {row[name]:g}" for name in POINT)
    return f"{source}: {axes}{' (self-locking)' * (row['status'] == 'lock')}"


def of_scans(scans: Readable, figures: Selections) -> Motion:
    """Choose the scans that the explorer can repeat.

    Parameters
    ----------
    scans : pyarrow.Table or Dataset
        With the schema `SCANS`.
    figures : mapping
        Rows that the study's figures show: a scan has the name of the one that shows the least.

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
    presets = tuple(_of_scan(rows, MOST_ROWS // len(offered), figures) for rows in offered)
    return Motion(what="a scan of the study", presets=presets, notes=tuple(notes))


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


def _of_scan(rows: pd.DataFrame, most: int, figures: Selections) -> Preset:
    first = rows.iloc[0]
    kept = rows.iloc[np.linspace(0, len(rows) - 1, min(len(rows), most)).astype(int)]
    values = {
        name: (kept[column].round(DECIMALS) + 0.0).tolist() for name, column in COLUMNS.items()
    }
    return Preset(
        name=_named(_figure_of(first, figures), first),
        note="Green: stored study values.",
        settings=_settings(rows),
        recording=Recording(name=figure_name(str(first["scan"])), **values),
        play=True,
    )


def _figure_of(scan: pd.Series, figures: Selections) -> str:
    """Name of the figure that shows a scan, by most keys; without any, that of its section."""
    showing = {
        name: len(selection)
        for name, selection in figures.items()
        if "scan" in selection
        and all(scan[key] in np.atleast_1d(values) for key, values in selection.items())
    }
    return max(showing, key=showing.__getitem__, default=figure_name(str(scan["scan"])))
