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

# What the ledger says above its table, and its columns.
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
        It is true under the condition in the reason, and not otherwise.
    AMBIGUOUS
        It has several readings, of which one is true and another false; or the computed data
        cannot decide it.
    CONTRADICTED
        The statement is false.
    """

    HOLDS = "holds"
    CONDITION = "holds with a condition"
    AMBIGUOUS = "ambiguous"
    CONTRADICTED = "contradicted"

    def counted(self, number: int) -> str:
        """Write how many statements have this verdict, as in ``1 holds`` and ``2 hold``."""
        return f"{number} {self if number == 1 else self.replace('holds', 'hold')}"


@dataclass(frozen=True, kw_only=True)
class Finding:
    """Verdict on one statement, the value and unit of each computed quantity, and the reason.

    An empty reason stands for that of `statements.toml` for the verdict.
    """

    verdict: Verdict
    quantities: Quantities
    reason: str = ""


@dataclass(frozen=True, kw_only=True)
class Claim:
    """A statement of the paper: its texts in `statements.toml`, and the function that judges it."""

    name: str
    texts: Mapping[str, Any]
    compute: Callable[[Evidence], Finding]

    def judge(self, evidence: Evidence) -> Finding:
        """Judge the statement by the evidence."""
        found = self.compute(evidence)
        return replace(found, reason=found.reason or self.texts[found.verdict.name.lower()])


def judges(name: str) -> Callable[[Callable[[Evidence], Finding]], Claim]:
    """Register the function that judges the statement of this name."""
    return lambda compute: Claim(name=name, texts=_STATEMENTS[name], compute=compute)


def claims_table(
    claims: Iterable[Claim],
    evidence: Evidence,
    *,
    study: str,
    method: Solver,
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
    """Ledger in Markdown, of a table with the schema `CLAIMS`."""
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
    """Numbers of statements, in all and by verdict, as text."""
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
