"""What the page says in words: what came out, what did not, and what was run."""

import os
import platform
import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from importlib import metadata
from typing import Any

import pandas as pd
import pyarrow.compute as pc

from vibrissa import __version__
from vibrissa.paper.ledger import quantities_of
from vibrissa.provenance import commit
from vibrissa.report.spelling import NO_RESULT, spell, spell_unit
from vibrissa.report.tables import SCAN, spell_counts
from vibrissa.tables import query, store
from vibrissa.tables.query import Readable
from vibrissa.wording import counted

# Reasons for rows without a result that are listed of each table.
MOST_REASONS = 40
LIBRARIES = ("numpy", "scipy", "pandas", "pyarrow", "matplotlib", "jinja2", "snakemake")


def summary(found: Mapping[str, Readable]) -> dict[str, str]:
    """Say in a few words what is in the tables: the text of each fact by its name."""
    lines = {}
    if "stiction" in found:
        lines["Grid points"] = spell_counts(_status_counts(found["stiction"]))
    if "scans" in found:
        lines["Scans"] = spell_counts(Counter(_first_rows(found["scans"])["status"]))
    if "states" in found:
        lines["States"] = spell_counts(_status_counts(found["states"]))
    if "scans" in found:
        lines["Steps of the clamp"] = str(query.count(found["scans"]))
    if "comparisons" in found:
        lines["Points in both kinds of contact"] = str(query.count(found["comparisons"]))
    residuals = [
        largest
        for name in ("stiction", "states")
        if name in found
        for part in query.parts(found[name], ["residual"])
        if (largest := pc.max(part.column("residual")).as_py()) is not None
    ]
    if residuals:
        lines["Largest residual"] = spell(max(residuals), 2)
    return lines


def troubles(found: Mapping[str, Readable]) -> list[str]:
    """Say which rows have no result, and why: the most frequent reasons of each table first."""
    return [line for name, table in found.items() for line in _troubles(name, table)]


def claim_rows(claims: Readable) -> list[dict[str, Any]]:
    """Rows of the ledger, with ``quantities``, the name and the text of each quantity."""
    rows = [row for part in query.parts(claims, claims.schema.names) for row in part.to_pylist()]
    for row in rows:
        row["quantities"] = [
            (name, f"{spell(value)} {spell_unit(unit)}".strip())
            for name, value, unit in quantities_of(row)
        ]
    return rows


@dataclass(frozen=True, kw_only=True)
class Origin:
    """Which code made a table: its version and commit."""

    table: str
    rows: int
    version: str
    commit: str

    @property
    def short(self) -> str:
        """Commit by its short name."""
        return re.sub("^([0-9a-f]{12})[0-9a-f]+", r"\1", self.commit)


def origin(name: str, table: Readable) -> Origin:
    """Read from a table's file which code made it."""
    told = {key.decode(): value.decode() for key, value in (table.schema.metadata or {}).items()}
    return Origin(
        table=name,
        rows=query.count(table),
        version=told.get(store.PROGRAM, "unknown"),
        commit=told.get(store.COMMIT, "unknown"),
    )


def environment() -> dict[str, str]:
    """Versions of the software and what is to be said of the machine, by name.

    Returns
    -------
    dict of str
        Neither the machine's name nor any path: the page is for others.
    """
    return {
        "vibrissa": f"{__version__}, commit {commit()}",
        "Python": platform.python_version(),
        **{name: metadata.version(name) for name in LIBRARIES},
        "system": f"{platform.system()}, {platform.machine()}",
        "cores": str(os.cpu_count()),
        "made": f"{datetime.now(UTC):%Y-%m-%d %H:%M} UTC",
    }


def job_times(benchmarks: Mapping[str, Sequence[str]]) -> pd.DataFrame:
    """Sum up Snakemake's benchmark files by rule.

    Parameters
    ----------
    benchmarks : mapping
        Texts of the files of each rule.

    Returns
    -------
    DataFrame
        For each ``rule`` that has files, and for all of them, the number of ``jobs``, the
        ``seconds`` of all jobs together and of the ``longest``, and the largest ``memory`` (MB).
    """
    jobs = pd.DataFrame(
        [
            {"rule": rule}
            | dict(zip(*(line.split("\t") for line in text.splitlines()[:2]), strict=True))
            for rule, texts in benchmarks.items()
            for text in texts
        ],
        columns=["rule", "s", "max_rss"],
    )
    # Snakemake writes NA for a job that was over before it could look.
    jobs[["s", "max_rss"]] = jobs[["s", "max_rss"]].apply(pd.to_numeric, errors="coerce")
    sums = {
        "jobs": ("s", "size"),
        "seconds": ("s", "sum"),
        "longest": ("s", "max"),
        "memory": ("max_rss", "max"),
    }
    every = jobs.assign(rule="all")
    times = [rows.groupby("rule", sort=False).agg(**sums) for rows in (jobs, every)]
    return pd.concat(times).fillna(0.0).reset_index()


def _status_counts(table: Readable) -> Counter[str]:
    return store.status_counts(query.parts(table, ["status"]))


def _first_rows(scans: Readable) -> pd.DataFrame:
    """First row of each scan: its axes, its status, and a footpoint if it has any steps."""
    rows = query.frame(scans, [*SCAN, "status", "footpoint"])
    return rows.drop_duplicates(list(SCAN))


def _troubles(name: str, table: Readable) -> list[str]:
    reasons: Counter[str] = Counter()
    columns = set(table.schema.names)
    for status in sorted(columns & {"status", "status_point", "status_line"}):
        said = [status, *(columns & {"message"})]
        rows = query.frame(table, said, query.one_of(status, NO_RESULT))
        for texts, count in rows.value_counts().items():
            reasons[": ".join(spell(text) for text in texts if text)] += count
    lines = [
        f"{name}: {counted(count, 'row')} {reason}"
        for reason, count in reasons.most_common(MOST_REASONS)
    ]
    if len(reasons) > MOST_REASONS:
        lines.append(f"{name}: and {len(reasons) - MOST_REASONS} more reasons; see its table")
    return lines
