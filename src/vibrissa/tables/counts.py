"""Counts of the rows of a study's tables by status."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

from vibrissa.errors import TableError
from vibrissa.outcomes import Status
from vibrissa.study.axes import AXES, LAW_AXES, POWERS, SURFACE_AXES
from vibrissa.tables import query
from vibrissa.wording import counted

if TYPE_CHECKING:
    import pandas as pd

# What identifies a scan.
SCAN = ("scan", *AXES, *POWERS.values(), "surface", *SURFACE_AXES, *LAW_AXES)
_NOUNS = {
    "stiction": "grid point",
    "scans": "scan",
    "friction": "reading",
    "states": "state",
    "comparisons": "compared solution",
}


def counts_by_status(tables: Mapping[str, query.Readable]) -> dict[str, Counter[str]]:
    """Count grid points, scans, readings, states and comparisons by their status."""
    counts: dict[str, Counter[str]] = {name: Counter() for name in tables if name in _NOUNS}
    for name, total in counts.items():
        if name == "scans":
            for scans in scan_keys(tables[name]):
                total.update(scans["status"])
            continue
        statuses = [column for column in tables[name].schema.names if column.startswith("status")]
        for part in query.batches(tables[name], statuses):
            for column in statuses:
                total.update(part.column(column).to_pandas().value_counts().to_dict())
    return counts


def scan_keys(table: query.Readable) -> Iterator[pd.DataFrame]:
    """Yield a row for each scan, with `SCAN` and its status, a part of the table at a time.

    The rows of a scan follow each other in the table.
    """
    import pandas as pd

    last: list[pd.DataFrame] = []
    for part in query.batches(table, [*SCAN, "status"]):
        scans = pd.concat([*last, part.to_pandas()]).drop_duplicates(ignore_index=True)
        # The last scan of a part may go on in the next one.
        yield scans.iloc[len(last) :]
        last = [scans.tail(1)]


def rows_of(table: query.Readable, columns: Sequence[str], scans: pd.DataFrame) -> pd.DataFrame:
    """Return the rows of some scans, which are rows that `scan_keys` yields."""
    import pandas as pd

    names = list(dict.fromkeys([*SCAN, *columns]))
    keys = scans[[*SCAN]].assign(order=range(len(scans)))
    parts = [part.to_pandas().merge(keys) for part in query.batches(table, names)]
    kept = pd.concat([part for part in parts if len(part)], ignore_index=True)
    return kept.sort_values("order", kind="stable", ignore_index=True)


def sentence(counts: Mapping[str, Counter[str]]) -> str:
    """Format counts by status, one line for each table."""
    return "".join(
        f"{counted(total.total(), _NOUNS[name])}: "
        + ", ".join(f"{number:,} {status}" for status, number in sorted(total.items()))
        + "\n"
        for name, total in counts.items()
    )


def need_results(counts: Mapping[str, Counter[str]]) -> None:
    """Refuse results with the status ``failed``.

    Raises
    ------
    TableError
        If there are such results; the message counts them for each table.
    """
    failed = {name: total[Status.FAILED] for name, total in counts.items() if total[Status.FAILED]}
    if failed:
        numbers = ", ".join(counted(number, _NOUNS[name]) for name, number in failed.items())
        raise TableError(
            f"the study has strict: true, but {numbers} have the status 'failed'; see the report, "
            "or the column 'message' of the tables"
        )
