"""What a comparison tells a CI system: for people, for machines, and beside files."""

import json
import math
from collections.abc import Iterator
from dataclasses import asdict
from typing import Any

from vibrissa.checking import enclosures
from vibrissa.checking.differences import Change, Difference
from vibrissa.checking.reference import Comparison
from vibrissa.wording import markdown_table

# Differences that a summary shows, and that are put beside files: GitHub shows ten of a step.
MOST_ROWS, MOST_NOTES = 30, 10
# Columns of a summary.
HEAD = ("table", "column", "what", "rows", "largest change", "relative", "where")


def markdown(comparison: Comparison) -> str:
    """Summary for people, in Markdown.

    Parameters
    ----------
    comparison : Comparison

    Returns
    -------
    str
    """
    differences = comparison.differences
    mark = "❌" if differences else "✅"
    lines = [f"## {mark} Study {comparison.results.name}: reference tables", "", comparison.verdict]
    if differences:
        lines += [
            "",
            markdown_table(HEAD, map(_cells, differences[:MOST_ROWS])),
        ]
    if more := differences[MOST_ROWS:]:
        lines += ["", f"And {len(more)} more; check.json has all of them."]
    if proofs := enclosures.verdict(comparison.enclosed):
        lines += ["", proofs]
    return "\n".join(lines) + "\n"


def _cells(difference: Difference) -> list[str]:
    rows = f"{difference.rows} of {difference.of}" if difference.of else str(difference.rows or "")
    return [
        difference.table,
        difference.column,
        difference.problem,
        rows,
        _size(difference.absolute),
        _size(difference.relative),
        str(difference.absolute or difference.text.partition(": ")[2]),
    ]


def _size(change: Change | None) -> str:
    return "" if change is None or change.size is None else f"{change.size:.2g}"


def json_text(comparison: Comparison) -> str:
    """Write all that is different for machines.

    Parameters
    ----------
    comparison : Comparison

    Returns
    -------
    str
        JSON: ``passed``, ``rows``, ``verdict``, the two folders, and ``differences`` with the
        attributes of `Difference`; ``enclosed`` with how many ``numbers`` have an enclosure and how
        many of them are off by how many ``ulps``. What is no finite number is null.
    """
    content = {
        "passed": not comparison.differences,
        "verdict": comparison.verdict,
        "results": comparison.results.as_posix(),
        "reference": comparison.reference.as_posix(),
        "rows": comparison.rows,
        "differences": [_finite(asdict(one)) for one in comparison.differences],
        "enclosed": {
            "numbers": len(comparison.enclosed),
            "ulps": enclosures.histogram(comparison.enclosed),
        },
    }
    return json.dumps(content, indent=2, allow_nan=False) + "\n"


def _finite(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _finite(one) for key, one in value.items()}
    return None if isinstance(value, float) and not math.isfinite(value) else value


def annotations(comparison: Comparison) -> Iterator[str]:
    """Lines that GitHub shows beside the reference tables.

    Yields
    ------
    str
    """
    for difference in comparison.differences[:MOST_NOTES]:
        path = (comparison.reference / f"{difference.table}.csv").as_posix()
        yield command("error", difference.text, file=path, title="Reference table")


def command(kind: str, message: str, **properties: str) -> str:
    """Spell a workflow command of GitHub: ``::error file=a.csv::message``."""
    said = ",".join(f"{name}={_escaped(value, ',:')}" for name, value in properties.items())
    return f"::{kind} {said}".rstrip() + f"::{_escaped(message)}"


def _escaped(text: str, more: str = "") -> str:
    for character in "%\r\n" + more:
        text = text.replace(character, f"%{ord(character):02X}")
    return text
