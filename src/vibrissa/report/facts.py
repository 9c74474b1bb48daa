"""Texts of the report: results, points without a result, claims, and software."""

import platform
import re
from collections import Counter
from collections.abc import Mapping
from datetime import UTC, datetime
from importlib import metadata
from typing import Any

import numpy as np
import pandas as pd
import pyarrow.compute as pc

from vibrissa import __version__
from vibrissa.outcomes import NO_RESULT
from vibrissa.paper.claims import CLAIMS
from vibrissa.paper.ledger import quantities_of
from vibrissa.provenance import commit, why_unknown
from vibrissa.report.spelling import spell, spell_unit
from vibrissa.tables import accuracy, query, store
from vibrissa.tables.counts import counts_by_status, sentence
from vibrissa.tables.query import Readable
from vibrissa.wording import counted

# Largest number of reasons for missing results that are listed for each table.
MOST_REASONS = 40
# Axes by which a result names its place.
NO_BREAK = "\N{NO-BREAK SPACE}"
AXES_SHOWN = ("theta", "mu0", "eta")
LIBRARIES = ("numpy", "scipy", "pandas", "pyarrow", "matplotlib", "snakemake")


def summary(found: Mapping[str, Readable]) -> dict[str, str]:
    """Count the results of each table by status, and find the largest residual.

    Each returned text has a name. For a table, the name is the number of its results, such as
    ``3 scans``, and the text has the counts by status, such as ``1 lock, 2 slip``. The text with
    the name ``largest residual`` has the largest residual of all tables.
    """
    lines = sentence(counts_by_status(found)).splitlines()
    facts = dict(line.split(": ") for line in lines)
    residuals = [
        pc.max(part.column("residual")).as_py()
        for name in ("stiction", "states")
        if name in found
        for part in query.batches(found[name], ["residual"])
    ]
    known = [residual for residual in residuals if residual is not None]
    return facts | ({"largest residual": spell(max(known), 2)} if known else {})


def results(found: Mapping[str, Readable]) -> list[str]:
    """Write the main results of a study as sentences: where tips slip, where they lock, scans."""
    lines = _results_of_points(found["stiction"]) if "stiction" in found else []
    if "scans" in found:
        where = query.one_of("cycle", [1]) & query.one_of("status", ["slip"])
        ends = pd.DataFrame()
        for part in query.batches(found["scans"], ["x0", *AXES_SHOWN], where):
            # The steps of a scan may go on in the next part.
            more = pd.concat([ends, part.to_pandas()])
            ends = more.groupby([*AXES_SHOWN], as_index=False)["x0"].max()
        if len(ends) > 1:
            least, most = (ends.loc[getattr(ends["x0"], end)()] for end in ("idxmin", "idxmax"))
            lines.append(
                f"In the scans x0,max is {_length(least['x0'])} ({_at(least)}) to "
                f"{_length(most['x0'])} ({_at(most)})."
            )
    if "friction" in found:
        read = query.frame(found["friction"], [*accuracy.POINT, *accuracy.COLUMNS])
        lines += [f"{line}." for line in accuracy.sentences(read)]
    return lines


def _results_of_points(table: Readable) -> list[str]:
    lines = []
    points = query.frame(table, ["status", "x0_slip", *AXES_SHOWN, "mu_lock"])
    slips = points[points["status"] == "slip"]
    if len(slips):
        least, most = (slips.loc[getattr(slips["x0_slip"], end)()] for end in ("idxmin", "idxmax"))
        lines.append(
            f"The clamp moves by {_length(least['x0_slip'])} ({_at(least)}) to "
            f"{_length(most['x0_slip'])} ({_at(most)}) until the tip slips."
        )
    locks = points[(points["status"] == "lock") & np.isfinite(points["mu_lock"])]
    if len(locks):
        low, high = locks["mu_lock"].min(), locks["mu_lock"].max()
        span = spell(low, 4) if low == high else f"{spell(low, 3)} to {spell(high, 3)}"
        at = "" if locks["theta"].nunique() > 1 else f" at theta = {locks['theta'].iloc[0]:g}"
        lines.append(
            f"Above a critical friction mu_lock = {span}{at}, pushing cannot make the tip slip "
            f"({counted(len(locks), 'point')})."
        )
    return lines


def _length(value: float) -> str:
    return f"{spell(value, 3)}{NO_BREAK}L"


def _at(row: pd.Series) -> str:
    return ", ".join(f"{axis}{NO_BREAK}={NO_BREAK}{row[axis]:g}" for axis in AXES_SHOWN)


def troubles(found: Mapping[str, Readable]) -> list[str]:
    """List the reasons for rows without a result, by table, the most frequent first."""
    lines = []
    for name, table in found.items():
        if name == "periods":  # the table of scans has the same reasons
            continue
        reasons: Counter[str] = Counter()
        columns = set(table.schema.names)
        for status in sorted(columns & {"status", "status_point", "status_line"}):
            said = [status, *(columns & {"message"})]
            rows = query.frame(table, said, query.one_of(status, NO_RESULT))
            for texts, count in rows.value_counts().items():
                reasons[": ".join(spell(text) for text in texts if text)] += count
        most = reasons.most_common(MOST_REASONS)
        lines += [f"{name}: {counted(count, 'row')} {reason}" for reason, count in most]
        if others := len(reasons) - len(most):
            lines.append(f"{name}: and {others} more reasons; see its table")
    return lines


def claim_rows(claims: Readable) -> list[dict[str, Any]]:
    """Return the rows of the ledger as the page shows them.

    Each row has two more keys. ``figures`` has the numbers of the figures that the statement is
    about. ``anchor`` is the HTML id of the statement. The ``quantities`` of a row are pairs of a
    name and a formatted value.
    """
    figures = {claim.name: claim.texts["figures"] for claim in CLAIMS}
    rows = query.frame(claims, claims.schema.names).to_dict("records")
    for row in rows:
        row["figures"] = figures.get(row["claim"], ())
        row["anchor"] = anchor(row["claim"])
        row["quantities"] = [
            (name, f"{spell(value)} {spell_unit(unit)}".strip())
            for name, value, unit in quantities_of(row)
        ]
    return rows


def anchor(claim: str) -> str:
    """Return the HTML id of a statement on the page."""
    return "statement-" + re.sub(r"\W+", "-", claim)


def origins(found: Mapping[str, Readable]) -> list[tuple[str, int, str, str]]:
    """List each table's name, number of rows, and version and commit of the code that made it."""
    rows = []
    for name, table in found.items():
        told = table.schema.metadata or {}
        made = (
            told.get(key.encode(), b"unknown").decode() for key in (store.PROGRAM, store.COMMIT)
        )
        rows.append((name, query.count(table), *made))
    return rows


def environment() -> dict[str, str]:
    """Return versions of the software by name, without the machine's name or paths."""
    unknown = f" ({reason})" if (reason := why_unknown()) else ""
    return {
        "vibrissa": f"{__version__}, commit {commit()}{unknown}",
        "Python": platform.python_version(),
        **{name: metadata.version(name) for name in LIBRARIES},
        "system": f"{platform.system()}, {platform.machine()}",
        "made": f"{datetime.now(UTC):%Y-%m-%d %H:%M} UTC",
    }
