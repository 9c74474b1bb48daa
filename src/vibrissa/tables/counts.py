"""Counts of the rows of a study's tables by status."""

from collections import Counter
from collections.abc import Mapping

from vibrissa.errors import TableError
from vibrissa.outcomes import Status
from vibrissa.study.axes import AXES
from vibrissa.tables import query
from vibrissa.wording import counted

_SCAN = ("scan", *AXES, "curvature_powers", "status")
_NOUNS = {
    "stiction": "grid point",
    "scans": "scan",
    "states": "state",
    "comparisons": "compared solution",
}


def counts_by_status(tables: Mapping[str, query.Readable]) -> dict[str, Counter[str]]:
    """Count grid points, scans, states and comparisons by their status."""
    counts: dict[str, Counter[str]] = {name: Counter() for name in tables if name in _NOUNS}
    for name, total in counts.items():
        if name == "scans":
            total.update(query.frame(tables[name], _SCAN).drop_duplicates()["status"])
            continue
        statuses = [column for column in tables[name].schema.names if column.startswith("status")]
        for part in query.batches(tables[name], statuses):
            for column in statuses:
                total.update(part.column(column).to_pandas().value_counts().to_dict())
    return counts


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
