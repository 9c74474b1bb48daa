"""Stick-slip scans as the frames of an animation: rounded, and thinned out where there are many."""

from typing import Any

import numpy as np
import pandas as pd

from vibrissa.report.spelling import symbol
from vibrissa.report.tables import POINT, REACTIONS, SCAN
from vibrissa.tables import query
from vibrissa.tables.frames import swung_aside
from vibrissa.tables.query import Readable

# What a page can carry: frames of all scans together, scans, and points of a shape.
MOST_FRAMES = 6000
MOST_SCANS = 60
MOST_POINTS = 51
# Lengths are whole numbers of this unit (L): a tenth of a pixel of a wide screen.
PRECISION = 1e-4
# Angles of the frames in which a round rod swings aside: its plane turns by half a turn (degrees).
TURNS = range(15, 180, 15)


def runs(scans: Readable) -> list[dict[str, Any]]:
    """Frames of each scan that has any.

    Parameters
    ----------
    scans : pyarrow.Table or Dataset
        With the schema `SCANS`.

    Returns
    -------
    list of dict
        Of the first `MOST_SCANS` scans. Each has a ``label``, its ``scan``, ``theta``, ``mu0``,
        ``eta`` and ``dx0``, ``status`` and ``steps``, the arc lengths ``s`` (L) of its shapes,
        ``shapes``, lists of x and y in turn relative to the clamp in units of `PRECISION`, and for
        each frame its shape's number (``shape``), the positions of ``clamp`` and ``contact`` (L),
        ``cycle``, whether the tip has just slipped (``slip``), by how much the plane of a rod that
        swings aside has turned (``turn``, in degrees), and the load on the clamp ``fx`` and ``fy``
        (E·I0/L²) and ``m`` (E·I0/L).
    """
    table = query.frame(scans, scans.schema.names)
    table = table[table["footpoint"].notna()]
    groups = list(table.groupby(list(SCAN), sort=False))[:MOST_SCANS]
    return [_run(rows, MOST_FRAMES // len(groups)) for _, rows in groups]


def _run(rows: pd.DataFrame, most: int) -> dict[str, Any]:
    first = rows.iloc[0]
    steps = len(rows)
    rows = _with_turns(rows.iloc[_kept(rows, most)])
    stride = -(-(len(first["shape_s"]) - 1) // (MOST_POINTS - 1))
    numbers: dict[tuple[int, ...], int] = {}
    frames = []
    for clamp, x, y in zip(rows["footpoint"], rows["shape_x"], rows["shape_y"], strict=True):
        points = np.column_stack([_thinned(x, stride) - clamp, _thinned(y, stride)])
        shape = tuple(np.rint(points / PRECISION).astype(int).ravel().tolist())
        # Every cycle goes through the same shapes.
        frames.append(numbers.setdefault(shape, len(numbers)))
    axes = ", ".join(f"{symbol(name)} = {first[name]:g}" for name in POINT)
    return {
        "label": f"{first['scan']}: {axes}{' (self-locking)' * (first['status'] == 'lock')}",
        "scan": first["scan"],
        "status": first["status"],
        **{name: float(first[name]) for name in POINT},
        "steps": steps,
        "s": [round(float(value), 6) for value in _thinned(first["shape_s"], stride)],
        "shapes": [list(shape) for shape in numbers],
        "shape": frames,
        "clamp": _rounded(rows["footpoint"]),
        "contact": _rounded(rows["x1"]),
        "cycle": [int(cycle) for cycle in rows["cycle"]],
        "slip": [int(phase == "slip") for phase in rows["phase"]],
        "turn": rows["turn"].to_list(),
        **{name.removeprefix("reaction_"): _rounded(rows[name]) for name in REACTIONS},
    }


def _kept(rows: pd.DataFrame, most: int) -> list[int]:
    """Numbers of the rows that are shown: about `most`, with those on both sides of each jump."""
    last = len(rows) - 1
    jumps = np.flatnonzero((rows["phase"] == "slip") | (swung_aside(rows).astype(int).diff() > 0))
    spread = np.linspace(0, last, min(len(rows), most)).astype(int)
    if 2 * len(jumps) > most:
        return list(dict.fromkeys(spread.tolist()))
    return sorted({*spread.tolist(), *jumps.tolist(), *(jumps - 1).tolist()})


def _with_turns(rows: pd.DataFrame) -> pd.DataFrame:
    """Put in rows of a rod that swings aside, as it is seen from the side while its plane turns.

    Clamp and contact point rest meanwhile. Lengths, force and moment in the drawing's plane shrink
    to their projections.
    """
    rows = rows.assign(turn=0)
    swung = swung_aside(rows).to_numpy()
    if not swung.any() or swung.all():
        return rows
    after = int(np.argmax(swung))
    before = rows.iloc[after - 1]
    turned = rows.iloc[[after - 1] * len(TURNS)].assign(turn=TURNS)
    seen = np.cos(np.radians(TURNS))
    clamp = before["footpoint"]
    turned["shape_x"] = list(clamp + seen[:, None] * (np.asarray(before["shape_x"]) - clamp))
    turned["x1"] = clamp + seen * (before["x1"] - clamp)
    for name in ("reaction_fx", "reaction_m"):
        turned[name] = seen * before[name]
    return pd.concat([rows.iloc[:after], turned, rows.iloc[after:]])


def _thinned(values: Any, stride: int) -> Any:
    """Every `stride`-th value, and the last one."""
    kept = list(range(0, len(values) - 1, stride))
    return np.asarray(values)[[*kept, len(values) - 1]]


def _rounded(values: pd.Series) -> list[float | None]:
    """Numbers to five decimals; None where there is none, which JSON can say."""
    return [round(float(value), 5) + 0.0 if np.isfinite(value) else None for value in values]
