"""Show two results folders side by side; used by `make compare`.

Usage: python workflow/compare.py A B [--output FOLDER]

Writes comparison.md and figures into results/compare/A-B or the folder that is given. Exit status 0
whatever differs, 2 if there is nothing to compare.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from vibrissa.checking import side_by_side, side_by_side_page
from vibrissa.checking.layouts import parse_layouts
from vibrissa.errors import ComparisonError, VibrissaError

LAYOUT = Path(__file__).with_name("regression.yaml")


def folders(*given: str) -> list[Path]:
    if not all(given):
        raise ComparisonError("say which results: make compare A=results/a B=results/b")
    return [Path(one) for one in given]


def main(argv: list[str]) -> int:
    parser = argparse.ArgumentParser(description="Show two results folders side by side.")
    parser.add_argument("a", help="results folder")
    parser.add_argument("b", help="results folder")
    parser.add_argument("--output", type=Path, help="instead of results/compare/A-B")
    options = parser.parse_args(argv)
    try:
        a, b = folders(options.a, options.b)
        layouts = parse_layouts(LAYOUT.read_text(encoding="utf-8"), str(LAYOUT))
        found = side_by_side.side_by_side(a, b, layouts)
        names = (folder.resolve().name for folder in (a, b))
        output = options.output or Path("results/compare", "-".join(names))
        page = side_by_side_page.write(found, output)
    except (VibrissaError, OSError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    for line in side_by_side_page.lines(found):
        print(line)
    print(page)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
