"""How many rows of a study's tables have which status."""

from collections import Counter
from collections.abc import Mapping

from vibrissa.errors import TableError
from vibrissa.outcomes import Status
from vibrissa.tables import query, store
from vibrissa.tables.schemas import CURVATURE_POWERS, MOUNTING, POINT
from vibrissa.wording import counted

_SCAN = ("scan", *(column.name for column in (*POINT, *MOUNTING, CURVATURE_POWERS)), "status")
_NOUNS = {
    "stiction": "grid point",
    "scans": "scan",
    "states": "state",
    "comparisons": "compared point",
}


def counts_by_status(tables: Mapping[str, query.Readable]) -> dict[str, Counter[str]]:
    """Count grid points, scans, states and comparisons by their status."""
    counts: dict[str, Counter[str]] = {}
    for name, table in tables.items():
        if name == "scans":
            scans = query.frame(table, _SCAN).drop_duplicates()
            counts[name] = Counter(scans["status"])
        elif name == "comparisons":
            rows = query.frame(table, ["status_point", "status_line"])
            counts[name] = Counter(rows.to_numpy().ravel())
        elif name in _NOUNS:
            counts[name] = store.status_counts(query.parts(table, ["status"]))
    return counts


def sentence(counts: Mapping[str, Counter[str]]) -> str:
    """Spell counts by status, a line for each table."""
    return "".join(
        f"{counted(total.total(), _NOUNS[name])}: "
        + ", ".join(f"{number:,} {status}" for status, number in sorted(total.items()))
        + "\n"
        for name, total in counts.items()
    )


def need_results(counts: Mapping[str, Counter[str]]) -> None:
    """Refuse tables with rows that failed.

    Raises
    ------
    TableError
        With the number of rows of each table.
    """
    failed = {name: total[Status.FAILED] for name, total in counts.items() if total[Status.FAILED]}
    if failed:
        numbers = ", ".join(counted(number, _NOUNS[name]) for name, number in failed.items())
        raise TableError(
            f"strict: {numbers} have the status failed; see the column message, or the report"
        )
