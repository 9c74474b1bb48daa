"""What a study found, as one web page that needs nothing else: made of tables and texts alone.

The page is `report.html`, a template, with `report.css` and `report.js` put into it.
"""

import base64
import math
import os
import platform
import re
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from importlib import metadata
from itertools import product
from pathlib import Path
from typing import Any, TypeAlias

import jinja2
import pandas as pd
import pyarrow as pa
import pyarrow.compute as pc
from markupsafe import Markup

from vibrissa import __version__, animation, ledger, tables

# An SVG of more bytes shows so many lines that the PNG looks the same and is smaller.
LARGEST_SVG = 300_000
# Rows that a table of the page shows, and messages about rows without a result.
MOST_ROWS = 40
FEW_ROWS = 27
LIBRARIES = ("numpy", "scipy", "pandas", "pyarrow", "matplotlib", "jinja2", "snakemake")
NO_RESULT = ("failed", "out_of_reach")
# A table, in memory or in a file.
Readable: TypeAlias = pa.Table | tables.Stored

SYMBOLS = {
    "theta": "θ",
    "mu0": "μ0",
    "eta": "η",
    "dx0": "Δx0",
    "x0_slip": "exact onset",
    "x0_max": "x0,max",
    "n_steps": "steps",
    "mu_lock": "μ_lock",
    "f_slip": "force at onset",
    "reaction_m_slip": "moment at onset",
    "x1": "x1",
    "f": "force",
    "alpha": "α",
    "phi1": "φ1",
    "s_c": "s_c",
    "reaction_fx": "Fx",
    "reaction_fy": "Fy",
    "reaction_m": "M",
    "x0_slip_point": "onset, point",
    "x0_slip_line": "onset, line",
    "mu_lock_point": "μ_lock, point",
    "mu_lock_line": "μ_lock, line",
    "status_point": "point contact",
    "status_line": "line contact",
}
STICTION = (
    *("theta", "mu0", "eta", "dx0", "status", "contact", "x0_max", "x0_slip"),
    *("mu_lock", "f_slip", "reaction_m_slip", "residual"),
)
STATES = (
    *("state", "theta", "eta", "x1", "status", "contact", "f", "alpha", "phi1"),
    *("reaction_fx", "reaction_fy", "reaction_m", "penetrates", "residual"),
)
COMPARISONS = (
    *("theta", "mu0", "eta", "status_point", "status_line", "x0_slip_point", "x0_slip_line"),
    *("mu_lock_point", "mu_lock_line", "penetrates"),
)


@dataclass(frozen=True)
class Picture:
    """A figure with its caption.

    Attributes
    ----------
    name, caption : str
    svg, png : bytes
        The same drawing in both formats, of which the page takes one.
    """

    name: str
    caption: str
    svg: bytes
    png: bytes

    @property
    def source(self) -> str:
        """The drawing as a data URI."""
        kind, data = ("svg+xml", self.svg) if len(self.svg) <= LARGEST_SVG else ("png", self.png)
        return f"data:image/{kind};base64,{base64.b64encode(data).decode()}"


@dataclass(frozen=True)
class Run:
    """What was run, and on what: the part of the page that does not follow from the tables.

    Attributes
    ----------
    study_files : mapping of str
        Text of each study file by its name.
    environment : mapping of str
        Versions of the software and what is to be said of the machine, by name.
    benchmarks : mapping
        Texts of Snakemake's benchmark files of each rule.
    """

    study_files: Mapping[str, str]
    environment: Mapping[str, str]
    benchmarks: Mapping[str, Sequence[str]]


@dataclass(frozen=True)
class Rows:
    """Rows of a table, to be read: titles with their unit and description, and texts."""

    title: str
    note: str
    header: Sequence[tuple[str, str, str]]
    cells: Sequence[Sequence[str]]


def page(study: str, found: Mapping[str, Readable], pictures: Iterable[Picture], run: Run) -> str:
    """Write the page.

    Parameters
    ----------
    study : str
        The study's name.
    found : mapping of pyarrow.Table or Stored
        The study's tables by name: ``stiction`` and, where there are any, ``scans``, ``states``,
        ``comparisons`` and ``claims``. Of one in a file as much is held as the page shows.
    pictures : iterable of Picture
    run : Run

    Returns
    -------
    str
        HTML that refers to nothing outside itself.
    """
    here = Path(__file__)
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(here.parent),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.policies["json.dumps_kwargs"] = {"separators": (",", ":")}
    claims = _rows_of(found["claims"]) if "claims" in found else []
    runs = animation.runs(found["scans"]) if "scans" in found else []
    return environment.get_template("report.html").render(
        study=study,
        style=Markup(here.with_suffix(".css").read_text(encoding="utf-8")),
        program=Markup(here.with_suffix(".js").read_text(encoding="utf-8")),
        summary=_summary(found),
        runs=_labelled(runs),
        motion=_motion(runs, found.get("scans")),
        pictures=list(pictures),
        verdicts=_verdicts(claims),
        claims=[_claim(row) for row in claims],
        tables=[rows for name, table in found.items() for rows in _sections(name, table)],
        troubles=[line for name, table in found.items() for line in _troubles(name, table)],
        provenance=[_provenance(name, table) for name, table in found.items()],
        jobs=job_rows(run.benchmarks),
        run=run,
    )


def environment() -> dict[str, str]:
    """Versions of the software and what is to be said of the machine, by name.

    Returns
    -------
    dict of str
        Neither the machine's name nor any path: the page is for others.
    """
    return {
        "vibrissa": f"{__version__}, commit {tables.commit()}",
        "Python": platform.python_version(),
        **{name: metadata.version(name) for name in LIBRARIES},
        "system": f"{platform.system()}, {platform.machine()}",
        "cores": str(os.cpu_count()),
        "made": f"{datetime.now(UTC):%Y-%m-%d %H:%M} UTC",
    }


def spell(value: Any, digits: int = 5) -> str:
    """Spell a value of a table: some digits, a true minus sign, and a dash for nothing."""
    if value is None or (isinstance(value, float) and math.isnan(value)):
        return "–"
    if isinstance(value, str):
        return value.replace("_", " ") if value in NO_RESULT else value
    if isinstance(value, bool):
        return "yes" if value else "no"
    text = f"{value:.{digits}g}"
    if exponent := re.fullmatch(r"(.*)e([+-])0*(\d+)", text):
        raised = str(exponent[3]).translate(str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹"))
        text = f"{exponent[1]}·10{'⁻' if exponent[2] == '-' else ''}{raised}"
    return text.replace("-", "−").replace("inf", "∞")


def unit_text(unit: str) -> str:
    """Spell a unit of a table's column; nothing for a plain number."""
    return "" if unit == tables.NONE else unit.replace("*", "·").replace("^2", "²")


def job_rows(benchmarks: Mapping[str, Sequence[str]]) -> list[tuple[str, int, float, float, float]]:
    """Sum up Snakemake's benchmark files by rule.

    Parameters
    ----------
    benchmarks : mapping
        Texts of the files of each rule.

    Returns
    -------
    list of tuple
        Rule, number of jobs, seconds of all of them, seconds of the longest and largest memory
        (MB), without rules that have no files; then the same of all rules.
    """
    rows: list[tuple[str, int, float, float, float]] = []
    for rule, texts in benchmarks.items():
        jobs = [
            dict(zip(*(line.split("\t") for line in text.splitlines()[:2]), strict=True))
            for text in texts
        ]
        if jobs:
            seconds = [float(job["s"]) for job in jobs]
            # Snakemake writes NA for a job that was over before it could look.
            memory = [float(job["max_rss"]) for job in jobs if job["max_rss"] not in ("NA", "-")]
            rows.append((rule, len(jobs), sum(seconds), max(seconds), max(memory, default=0.0)))
    if rows:
        _, counts, sums, longest, largest = zip(*rows, strict=True)
        rows.append(("all", sum(counts), sum(sums), max(longest), max(largest)))
    return rows


def _labelled(runs: list[dict[str, Any]]) -> list[dict[str, Any]]:
    for run in runs:
        axes = ", ".join(f"{SYMBOLS[name]} = {run[name]:g}" for name in animation.AXES)
        run["label"] = f"{run['scan']}: {axes}{' (locks)' * (run['status'] == 'lock')}"
    return runs


def _motion(runs: Sequence[Mapping[str, Any]], scans: Readable | None) -> list[str]:
    """Say what a viewer of the animation would not see."""
    lines = []
    if any(run["status"] == "lock" for run in runs):
        lines.append("A tip that locks never slips back: its scan is shown as far as it sticks.")
    if any(len(run["shape"]) < run["steps"] for run in runs):
        lines.append("Long scans are thinned out: not every step is shown.")
    if scans is not None:
        total = len(_scan_statuses(scans, solved=True))
        if len(runs) < total:
            lines.append(f"These are the first {len(runs)} of {total} scans.")
    return lines


def _rows_of(table: Readable) -> list[dict[str, Any]]:
    return [row for part in tables.parts_of(table, table.schema.names) for row in part.to_pylist()]


def _scan_statuses(scans: Readable, solved: bool = False) -> dict[tuple[Any, ...], str]:
    """Statuses of the scans by their name and axes, of all or of those that have steps."""
    statuses: dict[tuple[Any, ...], str] = {}
    for part in tables.parts_of(scans, [*_RUN, "status", "footpoint"]):
        rows = part.filter(pc.field("footpoint").is_valid()) if solved else part
        columns = [rows.column(name).to_pylist() for name in (*_RUN, "status")]
        statuses |= {tuple(key): status for *key, status in zip(*columns, strict=True)}
    return statuses


def _summary(found: Mapping[str, Readable]) -> list[tuple[str, str]]:
    """Say in a few words what is in the tables."""
    lines = []
    for name, what in (("stiction", "Grid points"), ("scans", "Scans"), ("states", "States")):
        if name in found:
            counts = (
                Counter(_scan_statuses(found[name]).values())
                if name == "scans"
                else tables.status_counts(tables.parts_of(found[name], ["status"]))
            )
            lines.append((what, _counts(counts)))
    if "scans" in found:
        lines.append(("Steps of the clamp", spell(len(found["scans"]), 9)))
    if "comparisons" in found:
        lines.append(("Points in both kinds of contact", spell(len(found["comparisons"]), 9)))
    residuals = [
        largest
        for name in ("stiction", "states")
        if name in found
        for part in tables.parts_of(found[name], ["residual"])
        if (largest := pc.max(part.column("residual")).as_py()) is not None
    ]
    if residuals:
        lines.append(("Largest residual", spell(max(residuals), 2)))
    return lines


_RUN = ("scan", *animation.AXES)


def _counts(statuses: Mapping[str, int]) -> str:
    """Say how many there are, and how many of them have which status."""
    counts, total = sorted(statuses.items()), sum(statuses.values())
    if len(counts) < 2:
        return f"{total}" + "".join(f", {'all ' * (n > 1)}{spell(s)}" for s, n in counts)
    return f"{total}: " + ", ".join(f"{n} {spell(s)}" for s, n in counts)


def _verdicts(claims: Sequence[Mapping[str, Any]]) -> list[tuple[str, int]]:
    found = [row["verdict"] for row in claims]
    return [(verdict, found.count(verdict)) for verdict in ledger.Verdict if verdict in found]


def _claim(row: Mapping[str, Any]) -> dict[str, Any]:
    figures = zip(row["figure_name"], row["figure_value"], row["figure_unit"], strict=True)
    shown = [(name, f"{spell(value)} {unit_text(unit)}".strip()) for name, value, unit in figures]
    return {**row, "figures": shown}


def _sections(name: str, table: Readable) -> list[Rows]:
    """Key rows of one of the study's tables."""
    return _SECTIONS[name](table) if name in _SECTIONS and len(table) else []


def _compact(
    title: str,
    note: str,
    header: Sequence[tuple[str, str, str]],
    cells: Sequence[Sequence[str]],
    total: int,
) -> Rows:
    """Rows as the page shows them: what is the same in all of them is said once, in the note."""
    alike = [len(cells) > 1 and len({row[i] for row in cells}) == 1 for i in range(len(header))]
    same = [
        f"{name} = {cells[0][i]}"
        for i, (name, _, _) in enumerate(header)
        if alike[i] and cells[0][i] != "–"
    ]
    if total > len(cells):
        note += f" Shown are the first {len(cells)} of {total} rows."
    if same:
        note += f" In all rows: {', '.join(same)}."
    return Rows(
        title,
        note.strip(),
        [column for column, drop in zip(header, alike, strict=True) if not drop],
        [[text for text, drop in zip(row, alike, strict=True) if not drop] for row in cells],
    )


def _rows(table: Readable, rows: pd.DataFrame, names: Sequence[str], title: str, note: str) -> Rows:
    fields = [table.schema.field(name) for name in names]
    header = [
        (
            SYMBOLS.get(field.name, field.name),
            unit_text(field.metadata[b"unit"].decode()),
            field.metadata[b"description"].decode(),
        )
        for field in fields
    ]
    shown = rows[list(names)].head(MOST_ROWS).astype(object)
    cells = [
        [
            spell(value, 2 if name == "residual" else 5)
            for name, value in zip(names, row, strict=True)
        ]
        for row in shown.itertuples(index=False)
    ]
    return _compact(title, note, header, cells, len(rows))


def key_rows(rows: pd.DataFrame, axes: Sequence[str]) -> pd.DataFrame:
    """Rows at the first, middle and last value of each axis.

    Parameters
    ----------
    rows : DataFrame
        Rows on a grid.
    axes : sequence of str
        Columns that span the grid.

    Returns
    -------
    DataFrame
        Without the middle values where they would make too many.
    """
    wanted = set(product(*_key_values({name: set(rows[name]) for name in axes}).values()))
    keep = [key in wanted for key in rows[list(axes)].itertuples(index=False, name=None)]
    return rows[keep].sort_values(list(axes))


def _key_values(values: Mapping[str, set[float]]) -> dict[str, list[float]]:
    """First, middle and last value of each axis, without the middle ones if they are too many."""
    ordered = {name: sorted(axis) for name, axis in values.items()}
    chosen = {name: sorted({v[0], v[len(v) // 2], v[-1]}) for name, v in ordered.items()}
    if math.prod(map(len, chosen.values())) > FEW_ROWS:
        chosen = {name: sorted({v[0], v[-1]}) for name, v in ordered.items()}
    return chosen


def _stiction(table: Readable) -> list[Rows]:
    counts: dict[str, Counter[str]] = {}
    values: dict[str, dict[str, set[float]]] = {}
    for part in tables.parts_of(table, ["grids", *animation.AXES, "status"]):
        for name in pc.unique(pc.list_flatten(part.column("grids"))).to_pylist():
            of_grid = tables.chosen(part, {"grid": name})
            counts.setdefault(name, Counter()).update(tables.status_counts([of_grid]))
            axes = values.setdefault(name, {axis: set() for axis in animation.AXES})
            for axis, seen in axes.items():
                seen.update(pc.unique(of_grid.column(axis)).to_pylist())
    sections = []
    for name in sorted(counts):
        keys = tables.frame(table, STICTION, {"grid": name, **_key_values(values[name])})
        keys = keys.sort_values(list(animation.AXES))
        note = f"Points: {_counts(counts[name])}."
        if len(keys) < counts[name].total():
            note += " Here are the corners and the middle of the grid."
        sections.append(_rows(table, keys, STICTION, f"Grid {name}", note))
    return sections


def _scans(table: Readable) -> list[Rows]:
    """Say of each scan how long it is and between what values the clamp's readings go."""
    rows = tables.frame(table, [*_RUN, "status", "footpoint", "cycle", "x0", *animation.READINGS])
    groups = [(key, group) for key, group in rows.groupby(list(_RUN), sort=False)]
    description = {field.name: field.metadata[b"description"].decode() for field in table.schema}
    force, moment = unit_text(tables.FORCE), unit_text(tables.MOMENT)
    header = [
        ("scan", "", description["scan"]),
        *((SYMBOLS[name], "", description[name]) for name in animation.AXES),
        ("status", "", description["status"]),
        ("cycles", "", "stick-slip cycles"),
        ("states", "", "rows of the table"),
        ("sticks for", unit_text(tables.LENGTH), "largest clamp displacement in a cycle"),
        ("Fx", force, f"{description['reaction_fx']}, least and greatest"),
        ("Fy", force, f"{description['reaction_fy']}, least and greatest"),
        ("M", moment, f"{description['reaction_m']}, least and greatest"),
    ]
    cells = []
    for key, group in groups[:MOST_ROWS]:
        solved = group[group["footpoint"].notna()]
        cells.append(
            [
                *(spell(value) for value in (*key, group["status"].iloc[0])),
                spell(solved["cycle"].max(), 9),
                spell(len(solved), 9),
                spell(solved["x0"].max()),
                *(_span(solved[name]) for name in animation.READINGS),
            ]
        )
    return [_compact("Scans", "", header, cells, len(groups))]


def _span(values: pd.Series) -> str:
    """Least and greatest value; what is only rounding against the greatest size is nought."""
    if values.empty:
        return "–"
    ends = values.min(), values.max()
    size = max(map(abs, ends))
    return " … ".join(spell(end if abs(end) > 1e-9 * size else 0.0, 4) for end in ends)


def _states(table: Readable) -> list[Rows]:
    return [_rows(table, tables.frame(table, STATES), STATES, "Single states", "")]


def _comparisons(table: Readable) -> list[Rows]:
    rows = tables.frame(table, table.schema.names)
    sections = []
    for name, points in rows.groupby("comparison", sort=False):
        keys = key_rows(points, ("theta", "mu0", "eta"))
        note = f"{len(points)} points; the rod would pass through the surface in "
        note += f"{int(points['penetrates'].sum())} of them."
        sections.append(_rows(table, keys, COMPARISONS, f"Comparison {name}", note))
    return sections


_SECTIONS: dict[str, Callable[[Readable], list[Rows]]] = {
    "stiction": _stiction,
    "scans": _scans,
    "states": _states,
    "comparisons": _comparisons,
}


def _troubles(name: str, table: Readable) -> list[str]:
    """Say what there is no result for, by the reason."""
    lines: Counter[str] = Counter()
    columns = {"status", "status_point", "status_line"}.intersection(table.schema.names)
    for column in sorted(columns):
        told = ["message"] if "message" in table.schema.names else []
        for part in tables.parts_of(table, [column, *told], {column: list(NO_RESULT)}):
            for status, *message in zip(*map(pa.ChunkedArray.to_pylist, part.columns), strict=True):
                lines[": ".join(filter(None, [spell(status), *message]))] += 1
    shown = [
        f"{name}: {count} row{'s' * (count > 1)} {reason}"
        for reason, count in lines.most_common(MOST_ROWS)
    ]
    if len(lines) > MOST_ROWS:
        shown.append(f"{name}: and {len(lines) - MOST_ROWS} more reasons; see its table")
    return shown


def _provenance(name: str, table: Readable) -> dict[str, Any]:
    """Which code made a table, by what the file says."""
    said = {key.decode(): value.decode() for key, value in (table.schema.metadata or {}).items()}
    commits = {said.get("vibrissa.commit", "unknown")}
    commits.update(said.get("vibrissa.part_commits", "").split())
    return {
        "name": name,
        "rows": len(table),
        "version": said.get("vibrissa.version", "unknown"),
        "commits": [
            (commit, re.sub("^([0-9a-f]{12})[0-9a-f]+", r"\1", commit))
            for commit in sorted(commits)
        ],
    }
