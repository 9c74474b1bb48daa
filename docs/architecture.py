"""Bring docs/architecture.md in line with the imports: `python -m validation pages`."""

from importlib import import_module
from pathlib import Path

import grimp

PACKAGE = "vibrissa"
PAGE = Path(__file__).with_name("architecture.md")
BEGIN = "<!-- made by python -m validation pages -->\n"
END = "<!-- end of what python -m validation pages made -->"


def package_imports() -> dict[str, set[str]]:
    """Find what each package imports of the others; modules beside them are not counted."""
    graph = grimp.build_graph(PACKAGE, exclude_type_checking_imports=True, cache_dir=None)
    imports: dict[str, set[str]] = {
        child.split(".")[1]: set()
        for child in sorted(graph.find_children(PACKAGE))
        if graph.find_children(child)
    }
    for name, others in imports.items():
        for module in graph.find_descendants(f"{PACKAGE}.{name}") | {f"{PACKAGE}.{name}"}:
            found = graph.find_modules_directly_imported_by(module)
            others |= {other.split(".")[1] for other in found if "." in other} & set(imports)
        others -= {name}
    return imports


def without_detours(imports: dict[str, set[str]]) -> dict[str, set[str]]:
    """Leave out every import that a chain of other imports implies."""
    below: dict[str, set[str]] = {}

    def reached(name: str) -> set[str]:
        if name not in below:
            below[name] = imports[name].union(*map(reached, imports[name]))
        return below[name]

    return {
        name: direct - set().union(*(reached(other) for other in direct))
        for name, direct in imports.items()
    }


def purpose(name: str) -> str:
    """Give the first line of a package's docstring."""
    return (import_module(f"{PACKAGE}.{name}").__doc__ or "").partition("\n")[0]


def text() -> str:
    """Write the diagram and the table of packages, in Markdown."""
    imports = package_imports()
    lines = ["```mermaid", "flowchart TD"]
    for name, others in without_detours(imports).items():
        lines += [f"    {name} --> {other}" for other in sorted(others)] or [f"    {name}"]
    lines += [
        "```",
        "",
        "| package | what it is for | imports |",
        "| --- | --- | --- |",
    ]
    for name, others in imports.items():
        lines.append(f"| `{name}` | {purpose(name)} | {', '.join(sorted(others)) or '–'} |")
    return "\n".join(lines) + "\n"


def replaced(page: str) -> str:
    """Put the diagram and the table between their marks in the page."""
    before, _, rest = page.partition(BEGIN)
    return before + BEGIN + text() + END + rest.partition(END)[2]


if __name__ == "__main__":
    PAGE.write_text(replaced(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
