"""The paper's statements, each with the verdict of a computation: as a table and in Markdown."""

import tomllib
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from enum import StrEnum
from pathlib import Path
from typing import Any, TypeAlias

import pyarrow as pa

from vibrissa.outcomes import Solver
from vibrissa.paper.evidence import Evidence
from vibrissa.tables.schemas import CLAIMS, NONE
from vibrissa.wording import markdown_table

# Text above the table of the ledger, and heads of its columns.
UNITS = (
    "Where no other unit is given, lengths are in units of the rod's length L, forces in E·I0/L², "
    "moments and energies in E·I0/L."
)
HEAD = ("§", "statement", "what was computed", "quantities", "verdict")
_STATEMENTS = tomllib.loads(Path(__file__).with_name("statements.toml").read_text("utf-8"))
# Value and unit of each computed quantity by its name.
Quantities: TypeAlias = dict[str, tuple[Any, str]]


class Verdict(StrEnum):
    """Verdict of a computation on a statement.

    Attributes
    ----------
    HOLDS
        The statement is true.
    CONDITION
        The statement is true only under the condition that the reason gives.
    AMBIGUOUS
        The statement is true in one reading and false in another, or the computed data cannot
        decide it.
    CONTRADICTED
        The statement is false.
    """

    HOLDS = "holds"
    CONDITION = "holds with a condition"
    AMBIGUOUS = "ambiguous"
    CONTRADICTED = "contradicted"

    def counted(self, number: int) -> str:
        """Format the number of statements with this verdict, as in ``1 holds`` and ``2 hold``."""
        return f"{number} {self if number == 1 else self.replace('holds', 'hold')}"


@dataclass(frozen=True, kw_only=True)
class Finding:
    """Verdict on one statement, the value and unit of each computed quantity, and the reason.

    If the reason is empty, `statements.toml` has the reason of the verdict.
    """

    verdict: Verdict
    quantities: Quantities
    reason: str = ""


@dataclass(frozen=True, kw_only=True)
class Claim:
    """A statement of the paper: its entry in `statements.toml`, and the function that judges it."""

    name: str
    texts: Mapping[str, Any]
    compute: Callable[[Evidence], Finding]

    def judge(self, evidence: Evidence) -> Finding:
        """Judge the statement by the evidence."""
        found = self.compute(evidence)
        return replace(found, reason=found.reason or self.texts[found.verdict.name.lower()])


def judges(name: str) -> Callable[[Callable[[Evidence], Finding]], Claim]:
    """Return a decorator that turns the judging function of a statement into a `Claim`."""
    return lambda compute: Claim(name=name, texts=_STATEMENTS[name], compute=compute)


def claims_table(
    claims: Iterable[Claim], evidence: Evidence, *, study: str, method: Solver
) -> pa.Table:
    """Judge claims; return a table with the schema `CLAIMS`."""
    rows = []
    for one in claims:
        finding = one.judge(evidence)
        rows.append(
            {
                **one.texts,
                "study": study,
                "method": method,
                "claim": one.name,
                "quantity_name": list(finding.quantities),
                "quantity_value": [float(value) for value, _ in finding.quantities.values()],
                "quantity_unit": [unit for _, unit in finding.quantities.values()],
                "verdict": finding.verdict,
                "reason": finding.reason,
            }
        )
    return pa.Table.from_pylist(rows, schema=CLAIMS)


def markdown(table: pa.Table) -> str:
    """Format a table with the schema `CLAIMS` in Markdown."""
    rows = (
        (
            row["section"],
            f"**{row['claim']}.** {row['statement']}",
            row["computed"],
            "; ".join(
                f"{name}: {value:.5g}{'' if unit == NONE else f' {unit}'}"
                for name, value, unit in quantities_of(row)
            ),
            f"**{row['verdict']}**: {row['reason']}",
        )
        for row in table.to_pylist()
    )
    return f"""# The paper's statements, judged by computation

{summary(table)}. {UNITS}

{markdown_table(HEAD, rows)}
"""


def summary(table: pa.Table) -> str:
    """Format the number of statements, in total and by verdict."""
    counts = verdict_counts(table.column("verdict").to_pylist())
    return f"{len(table)} statements: {', '.join(one.counted(n) for one, n in counts.items())}"


def verdict_counts(verdicts: Iterable[str]) -> dict[Verdict, int]:
    """Count the statements with each verdict that occurs."""
    counts = Counter(verdicts)
    return {verdict: counts[verdict] for verdict in Verdict if counts[verdict]}


def quantities_of(row: Mapping[str, Any]) -> Iterable[tuple[str, float, str]]:
    """Name, value and unit of each quantity of a row of the ledger."""
    columns = (row[f"quantity_{what}"] for what in ("name", "value", "unit"))
    return zip(*columns, strict=True)
