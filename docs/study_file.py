"""Write what describes study files from their model: `make schema`.

That is docs/study_file.md, the same as config/README.md for Snakemake's workflow catalogue, and the
JSON Schema.
"""

import json
from pathlib import Path
from typing import Any

from vibrissa.study.claims import Claims
from vibrissa.study.figures import KINDS
from vibrissa.study.mistakes import spell_axis
from vibrissa.study.model import (
    ComparisonSection,
    GridSection,
    ScanSection,
    StateSection,
    Study,
)
from vibrissa.study.schema import study_schema
from vibrissa.study.values import ClosestSection, RefineSection, Section

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


def keys(schema: dict[str, Any], leave_out: tuple[str, ...] = ()) -> list[str]:
    """Table of the keys of a section."""
    lines = ["| key | what it is | default |", "| --- | --- | --- |"]
    for key, value in schema["properties"].items():
        if key in leave_out:
            continue
        needed = key in schema.get("required", ())
        default = "needed" if needed else f"`{value['default']}`" if value.get("default") else "–"
        lines.append(f"| `{key}` | {value['description']} | {default} |")
    return lines


def refine(definitions: dict[str, Any]) -> list[str]:
    """Describe how points are added to a grid."""
    closest = keys(definitions[ClosestSection.__name__])
    return [
        "",
        "### `refine`",
        "",
        f"{summary(RefineSection)} See [Points where they matter](refine.md).",
        "",
        *keys(definitions[RefineSection.__name__]),
        "",
        f"`closest`: {summary(ClosestSection)}",
        "",
        *closest,
    ]


def figures(definitions: dict[str, Any]) -> list[str]:
    """Describe the kinds of figures."""
    lines = [
        "## `figures`",
        "",
        "Each figure has a name, a `kind` and perhaps a `caption`. The other keys depend on the "
        "kind. An axis",
        "that is named below may be left out where the data have one value of it.",
    ]
    for figure in KINDS:
        schema = definitions[figure.__name__]
        kind = schema["properties"]["kind"]
        names = kind.get("enum", [kind.get("const")])
        lines += [
            "",
            f"### {', '.join(names)}",
            "",
            f"{summary(figure)} Drawn from table `{figure.table}`.",
            "",
            *keys(schema, leave_out=("kind", "caption")),
        ]
    return lines


def claims(definitions: dict[str, Any]) -> list[str]:
    """Describe the data that the paper's statements are judged by."""
    lines = [
        "## `claims`",
        "",
        summary(Claims),
        "",
        "| key | what it is | values that the data need |",
    ]
    lines.append("| --- | --- | --- |")
    for key, value in definitions["Claims"]["properties"].items():
        needs = [
            f"{axis} = {spell_axis(values)}{' only' * (axis in Claims.setup)}"
            for axis, values in Claims.needed[key].items()
        ]
        lines.append(f"| `{key}` | {value['description']} | {'; '.join(needs)} |")
    return lines


def page() -> str:
    """Write the reference page."""
    schema = study_schema()
    definitions = schema["$defs"]
    lines = [
        "# Keys of a study file",
        "",
        "<!-- made by make schema from src/vibrissa/study: edit that -->",
        "",
        f"{summary(Study)} To make one, see [A study of your own](study.md).",
        "",
        *keys(schema),
    ]
    for name, section in SECTIONS.items():
        described = keys(definitions[section.__name__])
        lines += ["", f"## `{name}`", "", f"Each has a name. {summary(section)}", "", *described]
        if name == "grids":
            lines += refine(definitions)
    lines += ["", *figures(definitions), "", *claims(definitions)]
    return "\n".join(lines) + "\n"


def catalogue_page() -> str:
    """Write the page that the workflow catalogue shows: the same from another folder."""
    return (
        page()
        .replace("# Keys of a study file", "# Configuration", 1)
        .replace("](study.md)", "](../docs/study.md)")
        .replace("](refine.md)", "](../docs/refine.md)")
    )


def schema_text() -> str:
    """Write the JSON Schema."""
    return json.dumps(study_schema(), indent=2) + "\n"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
    CATALOGUE.write_text(catalogue_page(), encoding="utf-8")
    SCHEMA.write_text(schema_text(), encoding="utf-8")
