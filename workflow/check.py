"""Compare the results of a study with reference tables, or make these anew; used by the Makefile.

Usage: python workflow/check.py [--configfile FILE] [--results FOLDER] [--reference FOLDER]
                                [--bless]

Without options: results/paper against tests/regression/paper. Exit status 1 if anything moved, 2 if
there is nothing to compare.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from vibrissa.errors import ComparisonError, VibrissaError
from vibrissa.pipeline import regression
from vibrissa.pipeline.run import study_name

LAYOUT = "regression.yaml"


def check(results: Path, reference: Path, bless: bool) -> int:
    own = reference / LAYOUT
    path = own if own.is_file() else Path(__file__).with_name(LAYOUT)
    layouts = regression.parse_layouts(path.read_text(encoding="utf-8"), str(path))
    found = {
        name: regression.as_text(frame, layouts[name], name)
        for name, frame in regression.condensed(results).items()
        if name in layouts
    }
    stored = {
        path.stem: regression.read(path) for path in reference.glob("*.csv") if path.stem in layouts
    }
    if not stored and not bless:
        raise ComparisonError(f"{reference} has no reference tables; make them with: make bless")
    lines = [f"{name}: the whole table is missing" for name in sorted(stored.keys() - found)]
    for name, text in found.items():
        if name in stored:
            lines += regression.compare(stored[name], text, layouts[name], name)
        else:
            lines.append(f"{name}: a new table of {len(text)} rows")
    for line in lines:
        print(line)
    if bless:
        reference.mkdir(parents=True, exist_ok=True)
        for name, text in found.items():
            text = regression.blessed(stored.get(name), text, layouts[name])
            regression.write(text, reference / f"{name}.csv")
        for name in stored.keys() - found:
            (reference / f"{name}.csv").unlink()
        print(f"{reference} is written: review it with git diff")
        return 0
    rows = sum(len(text) for text in found.values())
    print(
        f"{len(lines)} differences between {results} and {reference}"
        if lines
        else f"Nothing moved: {results} has the {rows} rows of {reference}."
    )
    return 1 if lines else 0


def main(argv: list[str]) -> int:
    parser = argparse.ArgumentParser(description="Compare results with reference tables.")
    parser.add_argument("--configfile", help="study file, instead of config.yaml")
    parser.add_argument("--results", type=Path, help="instead of results/<study>")
    parser.add_argument("--reference", type=Path, help="instead of tests/regression/<study>")
    parser.add_argument("--bless", action="store_true", help="make the reference tables anew")
    options = parser.parse_args(argv)
    study = study_name([options.configfile] if options.configfile else [])
    results = options.results or Path("results", study)
    reference = options.reference or Path("tests/regression", study)
    try:
        return check(results, reference, options.bless)
    except (VibrissaError, OSError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 2


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
