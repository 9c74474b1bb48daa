"""Bring docs/tables.md in line with the tables' schemas: `python -m validation pages`."""

from pathlib import Path

from vibrissa.tables.frames import Entry, entries
from vibrissa.tables.schemas import TABLES
from vibrissa.wording import markdown_table

PAGE = Path(__file__).with_name("tables.md")
BEGIN = "<!-- made by python -m validation pages -->\n"
END = "<!-- end of what python -m validation pages made -->"
HEAD = ("column", "type", "unit", "range", "null means", "equation", "what it is")
ROWS = {
    "stiction": "One row for each grid point.",
    "scans": "One row for each step of the clamp.",
    "states": "One row for each single equilibrium.",
    "comparisons": "One row for each point that is solved in both kinds of contact.",
    "claims": "One row for each statement of the paper.",
}


def row(entry: Entry) -> tuple[str, ...]:
    """Cells of a column."""
    name, kind, unit = f"`{entry.name}`", entry.type, entry.unit
    return name, kind, unit, entry.range, entry.null, entry.equation, entry.description


def text() -> str:
    """Write the data dictionary, in Markdown."""
    lines = []
    for name, schema in TABLES.items():
        lines += [
            f"### `{name}`",
            "",
            ROWS[name],
            "",
            markdown_table(HEAD, map(row, entries(schema))),
            "",
        ]
    return "\n".join(lines)


def replaced(page: str) -> str:
    """Put the data dictionary between its marks in the page."""
    before, _, rest = page.partition(BEGIN)
    return before + BEGIN + text() + END + rest.partition(END)[2]


if __name__ == "__main__":
    PAGE.write_text(replaced(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
