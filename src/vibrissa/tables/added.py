"""What a block of grid points says, in its metadata, of the points that refinement added to it.

Which points are added is known when curves are solved, and not before. So each block has an account
of those that it got, and `vibrissa.tables.completeness.check_refined` compares both.
"""

import json
from collections.abc import Iterable, Iterator, Mapping
from decimal import Decimal
from pathlib import Path
from typing import Any

import pyarrow.parquet as pq

from vibrissa.decimals import exact, spell
from vibrissa.study.codec import decode_axis, decode_key, encode_axis, encode_key
from vibrissa.study.grid import CurveKey, CurvePoints, named_points
from vibrissa.tables import store
from vibrissa.tables.schemas import STICTION
from vibrissa.wording import counted

# In the metadata of a block: how it was refined, which points were added, and what is left over.
ACCOUNT = b"vibrissa.added"
# What a block without an account would say.
NOTHING = {"refining": {"refinements": {}, "gaps": {}}, "added": [], "left": []}


def refined_metadata(
    refining: Mapping[str, Any],
    points: Iterable[tuple[CurveKey, CurvePoints]],
    left: Iterable[tuple[str, str, Decimal]],
) -> dict[bytes, bytes]:
    """Metadata of a block: how it was refined, which points were added, and what is left over.

    Parameters
    ----------
    refining : mapping
        How, in plain values as JSON has them.
    points : iterable of (CurveKey, CurvePoints)
        All points of the block, curve by curve.
    left : iterable of (str, str, Decimal)
        Grid and axis of each line that is not within the tolerance everywhere, and the length of
        its gaps that are not.

    Returns
    -------
    dict of bytes
        For `account_of`.
    """
    lines = []
    for key, on_curve in points:
        frictions: dict[tuple[Any, ...], list[Decimal]] = {}
        rows = zip(on_curve.mu0, on_curve.dx0, on_curve.grids, on_curve.added_to, strict=True)
        for mu0, dx0, grids, added_to in rows:
            if added_to:
                line = spell(dx0), tuple(grids), tuple(added_to)
                frictions.setdefault(line, []).append(mu0)
        lines += [[encode_key(key), *line, encode_axis(mu0)] for line, mu0 in frictions.items()]
    said = {
        "refining": refining,
        "added": lines,
        "left": [[grid, axis, spell(length)] for grid, axis, length in left],
    }
    return {ACCOUNT: json.dumps(said).encode()}


def account_of(file: pq.ParquetFile) -> dict[str, Any]:
    """Read what a block says about its refinement; see `refined_metadata`."""
    told = (file.schema_arrow.metadata or {}).get(ACCOUNT)
    return NOTHING if told is None else json.loads(told)


def added_points(account: Mapping[str, Any]) -> Iterator[tuple[CurveKey, CurvePoints]]:
    """Points of which a block says that they were added; a curve may come several times."""
    for key, dx0, grids, added_to, frictions in account["added"]:
        pairs = [(mu0, exact(dx0)) for mu0 in decode_axis(frictions)]
        points = named_points(dict.fromkeys(pairs, grids), dict.fromkeys(pairs, added_to))
        yield decode_key(key), points


def refined_summary(paths: Iterable[str | Path]) -> str:
    """Say how many points were added to some blocks, and what is not within the tolerance.

    Parameters
    ----------
    paths : iterable of path
        Parquet files, each of which `vibrissa.tables.completeness.check_refined` accepts.

    Returns
    -------
    str
        One line.
    """
    added = 0
    left: dict[tuple[str, str], list[Decimal]] = {}
    for path in paths:
        said = account_of(store.opened(path, STICTION))
        added += sum(len(decode_axis(frictions)) for *_, frictions in said["added"])
        for grid, axis, length in said["left"]:
            left.setdefault((grid, axis), []).append(exact(length))
    if not added:
        return (
            "refine added no points: straight lines between those of the axes are within the "
            "tolerance, closest allows none, or there are no values"
        )
    found = [
        f"up to {spell(max(lengths))} of {axis} on {counted(len(lengths), 'line')} of {grid}"
        for (grid, axis), lengths in sorted(left.items())
    ]
    more = f"; not within the tolerance at closest: {', '.join(found)}" if found else ""
    return f"refine added {counted(added, 'point')}{more}"
