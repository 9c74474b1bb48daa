"""The picture of the packages and their imports, for docs/architecture.md on the site."""

import importlib.util
from html import escape
from itertools import groupby
from pathlib import Path

spec = importlib.util.spec_from_file_location(
    "architecture", Path(__file__).parents[1] / "architecture.py"
)
if spec is None or spec.loader is None:
    raise ImportError("docs/architecture.py is missing")
architecture = importlib.util.module_from_spec(spec)
spec.loader.exec_module(architecture)

WIDTH, ROW, BOX_WIDTH, BOX_HEIGHT = 760, 84, 104, 34
STYLE = """<style>
rect { fill: #e8eef7; stroke: #4a6fa5; }
text { font: 14px sans-serif; fill: #1b2a41; text-anchor: middle; }
path { fill: none; stroke: #8a99ad; stroke-width: 1.3; }
</style>"""


def levels(imports: dict[str, set[str]]) -> dict[str, int]:
    """Count for each package how many others stand on one another below it."""
    found: dict[str, int] = {}

    def level(name: str) -> int:
        if name not in found:
            found[name] = max((level(other) + 1 for other in imports[name]), default=0)
        return found[name]

    for name in imports:
        level(name)
    return found


def drawing() -> str:
    """Draw the packages as SVG: what imports stands above what it imports."""
    imports = architecture.without_detours(architecture.package_imports())
    level = levels(imports)
    top = max(level.values())
    place: dict[str, tuple[float, float]] = {}
    names = sorted(imports, key=lambda name: (-level[name], name))
    for height, row in groupby(names, key=level.__getitem__):
        members = list(row)
        for i, name in enumerate(members):
            x = WIDTH * (i + 1) / (len(members) + 1)
            place[name] = (x, (top - height) * ROW + ROW / 2)
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {(top + 1) * ROW}">',
        STYLE,
    ]
    for name, others in imports.items():
        x, y = place[name]
        for other in sorted(others):
            to, below = place[other]
            begin, end = y + BOX_HEIGHT / 2, below - BOX_HEIGHT / 2
            middle = (begin + end) / 2
            lines.append(f'<path d="M{x} {begin} C{x} {middle} {to} {middle} {to} {end}"/>')
    for name, (x, y) in place.items():
        corner = f'x="{x - BOX_WIDTH / 2}" y="{y - BOX_HEIGHT / 2}"'
        lines.append(f'<rect {corner} width="{BOX_WIDTH}" height="{BOX_HEIGHT}" rx="6"/>')
        lines.append(f'<text x="{x}" y="{y + 5}">{escape(name)}</text>')
    return "\n".join([*lines, "</svg>", ""])
