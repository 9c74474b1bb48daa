"""A ledger of statements and what a computation says to each: as a table and to read."""

from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

import pyarrow as pa

from vibrissa.evidence import Evidence
from vibrissa.tables import CLAIMS


class Verdict(StrEnum):
    """What a computation says to a statement.

    Attributes
    ----------
    HOLDS
        It is so.
    CONDITION
        It is so where the reason says, and not elsewhere.
    AMBIGUOUS
        It can be read in ways of which one holds and another does not, or what was shown cannot
        decide it.
    CONTRADICTED
        It is not so.
    """

    HOLDS = "holds"
    CONDITION = "holds with a condition"
    AMBIGUOUS = "ambiguous"
    CONTRADICTED = "contradicted"


@dataclass(frozen=True)
class Finding:
    """Verdict on one statement.

    Attributes
    ----------
    verdict : Verdict
    reason : str
        The condition or the reason.
    figures : mapping
        Value and unit of each computed figure by its name.
    """

    verdict: Verdict
    reason: str
    figures: Mapping[str, tuple[float, str]]


@dataclass(frozen=True)
class Claim:
    """A statement with the computation that decides it.

    Attributes
    ----------
    name : str
        Short name.
    section : str
        Section of the paper.
    statement : str
        What it says, in other words.
    computed : str
        What decides it.
    judge : callable
        Returns the `Finding`; takes the evidence and, by keyword, what else may be put in place of
        what is computed.
    """

    name: str
    section: str
    statement: str
    computed: str
    judge: Callable[..., Finding]

    def __call__(self, evidence: Evidence, **other: Any) -> Finding:
        """Judge the statement."""
        return self.judge(evidence, **other)


def claim(
    name: str, section: str, statement: str, computed: str
) -> Callable[[Callable[..., Finding]], Claim]:
    """Make a claim of the function that judges it; see `Claim`."""
    return lambda judge: Claim(name, section, statement, computed, judge)


def claims_table(claims: Iterable[Claim], evidence: Evidence) -> pa.Table:
    """Judge claims.

    Parameters
    ----------
    claims : iterable of Claim
    evidence : Evidence

    Returns
    -------
    pyarrow.Table
        With the schema `CLAIMS`.
    """
    rows = []
    for one in claims:
        finding = one(evidence)
        rows.append(
            {
                "claim": one.name,
                "section": one.section,
                "statement": one.statement,
                "computed": one.computed,
                "figure_name": list(finding.figures),
                "figure_value": [float(value) for value, _ in finding.figures.values()],
                "figure_unit": [unit for _, unit in finding.figures.values()],
                "verdict": finding.verdict,
                "reason": finding.reason,
            }
        )
    return pa.Table.from_pylist(rows, schema=CLAIMS)


def markdown(table: pa.Table) -> str:
    """Ledger to read, in the order of the table.

    Parameters
    ----------
    table : pyarrow.Table
        With the schema `CLAIMS`.

    Returns
    -------
    str
    """
    lines = [
        "# What a computation says to the paper's statements",
        "",
        f"{verdict_counts(table)}. Lengths are in units of the rod's length L, forces in E·I0/L², "
        "moments and energies in E·I0/L, where no other unit is given.",
        "",
        "| § | statement | what was computed | figures | verdict |",
        "| --- | --- | --- | --- | --- |",
    ]
    for row in table.to_pylist():
        figures = zip(row["figure_name"], row["figure_value"], row["figure_unit"], strict=True)
        shown = "; ".join(
            f"{name}: {value:.5g}{'' if unit == '1' else f' {unit}'}"
            for name, value, unit in figures
        )
        cells = [
            row["section"],
            f"**{row['claim']}.** {row['statement']}",
            row["computed"],
            shown,
            f"**{row['verdict']}**: {row['reason']}",
        ]
        lines.append("| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |")
    return "\n".join(lines) + "\n"


def verdict_counts(table: pa.Table) -> str:
    """How many statements got which verdict, as text."""
    counts = Counter(table.column("verdict").to_pylist())
    shown = [f"{counts[verdict]} {verdict}" for verdict in Verdict if counts[verdict]]
    return f"{len(table)} statements: {', '.join(shown)}"
