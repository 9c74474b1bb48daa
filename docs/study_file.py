"""Write what describes study files from their model.

That is docs/study_file.md, the same as config/README.md for Snakemake's workflow catalogue, and the
JSON Schema.
"""

import json
from pathlib import Path
from typing import Any

from vibrissa.study.axes import spell_values
from vibrissa.study.claims import Claims
from vibrissa.study.figures import KINDS, TABLES
from vibrissa.study.model import (
    ComparisonSection,
    GridSection,
    ScanSection,
    StateSection,
    Study,
)
from vibrissa.study.schema import study_schema
from vibrissa.study.sections import Section

PAGE = Path(__file__).with_name("study_file.md")
CATALOGUE = PAGE.parents[1] / "config/README.md"
SCHEMA = PAGE.parents[1] / "workflow/schemas/study.schema.json"
SECTIONS = {
    "grids": GridSection,
    "scans": ScanSection,
    "states": StateSection,
    "comparisons": ComparisonSection,
}


def summary(section: type[Section]) -> str:
    """Give the first line of a docstring."""
    return (section.__doc__ or "").partition("\n")[0]


def table(head: str, rows: list[tuple[str, ...]]) -> list[str]:
    """Write a table in Markdown; the head separates its cells by a stroke."""
    names = [cell.strip() for cell in head.split("|")]
    return ["| " + " | ".join(row) + " |" for row in (names, ["---"] * len(names), *rows)]


def keys(schema: dict[str, Any]) -> list[str]:
    """Table of the keys of a section."""
    rows = []
    for key, value in schema["properties"].items():
        default = value.get("default")
        shown = "–" if default in (None, "", {}) else f"`{json.dumps(default)}`"
        needed = key in schema.get("required", ())
        rows.append((f"`{key}`", value["description"], "required" if needed else shown))
    return table("key | what it is | default", rows)


def figures() -> list[str]:
    """Describe the kinds of figures."""
    rows = [
        (
            f"`{name}`",
            kind.shows,
            f"`{kind.source}` (table `{TABLES[kind.source]}`)",
            ", ".join(f"`{key}`" for key in (*kind.required, *kind.single)) or "–",
        )
        for name, kind in KINDS.items()
    ]
    return [
        "## `figures`",
        "",
        "Each figure has a name, a `kind`, the key that names what it is drawn from, and perhaps a",
        "`caption`. The key of an axis may be left out where the data have one value of it.",
        "",
        *table("kind | what it shows | drawn from | further keys", rows),
    ]


def claims(definitions: dict[str, Any]) -> list[str]:
    """Describe the data by which the paper's statements are judged."""
    rows = []
    for key, value in definitions["Claims"]["properties"].items():
        needs = [
            f"{axis} = {spell_values(values)}{' only' * (axis in Claims.setup)}"
            for axis, values in Claims.needed[key].items()
        ]
        rows.append((f"`{key}`", value["description"], "; ".join(needs)))
    head = "key | what it is | values that the data need"
    return ["## `claims`", "", summary(Claims), "", *table(head, rows)]


def page() -> str:
    """Write the reference page."""
    schema = study_schema()
    definitions = schema["$defs"]
    lines = [
        "# Keys of a study file",
        "",
        "<!-- made from src/vibrissa/study: edit that -->",
        "",
        f"{summary(Study)} To make one, see [A study of your own](study.md).",
        "",
        *keys(schema),
    ]
    for name, section in SECTIONS.items():
        described = keys(definitions[section.__name__])
        lines += ["", f"## `{name}`", "", f"Each has a name. {summary(section)}", "", *described]
    lines += ["", *figures(), "", *claims(definitions)]
    return "\n".join(lines) + "\n"


def catalogue_page() -> str:
    """Write the page that the workflow catalogue shows: the same from another folder."""
    return (
        page()
        .replace("# Keys of a study file", "# Configuration", 1)
        .replace("](study.md)", "](../docs/study.md)")
    )


def schema_text() -> str:
    """Write the JSON Schema."""
    return json.dumps(study_schema(), indent=2) + "\n"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
    CATALOGUE.write_text(catalogue_page(), encoding="utf-8")
    SCHEMA.write_text(schema_text(), encoding="utf-8")
