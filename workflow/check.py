"""Compare the results of a study with reference tables, or make these anew; used by the Makefile.

Usage: python workflow/check.py [--configfile FILE] [--results FOLDER] [--reference FOLDER]
                                [--output FOLDER] [--bless]

Without options: results/paper against tests/regression/paper. Exit status 1 if anything moved, 2 if
there is nothing to compare or the tables are older than the code or the study file.

A summary is added to the file that GITHUB_STEP_SUMMARY names; with GITHUB_ACTIONS=true differences
are shown beside the reference tables.
"""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path

from vibrissa.checking import ci, enclosures
from vibrissa.checking.layouts import parse_layouts
from vibrissa.checking.reference import Comparison, bless, compare_folders, need_reference
from vibrissa.errors import VibrissaError
from vibrissa.files import write_atomically
from vibrissa.pipeline import staleness
from vibrissa.pipeline.run import study_of

LAYOUT = "regression.yaml"


def compared(results: Path, reference: Path) -> Comparison:
    own = reference / LAYOUT
    path = own if own.is_file() else Path(__file__).with_name(LAYOUT)
    layouts = parse_layouts(path.read_text(encoding="utf-8"), str(path))
    return compare_folders(results, reference, layouts)


def write_output(found: Comparison, folder: Path) -> None:
    """Write the comparison for people and machines, and what `make bless` would change."""
    folder.mkdir(parents=True, exist_ok=True)
    texts = {
        "check.md": ci.markdown(found),
        "check.json": ci.json_text(found),
        "reference.diff": found.diff(),
    }
    for name, text in texts.items():
        with write_atomically(folder / name) as temporary:
            temporary.write_text(text, encoding="utf-8")


def tell_ci(found: Comparison) -> None:
    if summary := os.environ.get("GITHUB_STEP_SUMMARY"):
        with open(summary, "a", encoding="utf-8") as file:
            file.write(ci.markdown(found))
    if in_github():
        for line in ci.annotations(found):
            print(line)


def in_github() -> bool:
    return os.environ.get("GITHUB_ACTIONS") == "true"


def main(argv: list[str]) -> int:
    parser = argparse.ArgumentParser(description="Compare results with reference tables.")
    parser.add_argument("--configfile", help="study file, instead of config.yaml")
    parser.add_argument(
        "--results",
        type=Path,
        help="compare this folder as it is, instead of results/<study> if that is current",
    )
    parser.add_argument("--reference", type=Path, help="instead of tests/regression/<study>")
    parser.add_argument("--output", type=Path, help="folder for check.md, check.json, a diff")
    parser.add_argument("--bless", action="store_true", help="make the reference tables anew")
    options = parser.parse_args(argv)
    study, _ = study_of([options.configfile] if options.configfile else [])
    results = options.results or Path("results", study)
    reference = options.reference or Path("tests/regression", study)
    try:
        if options.results is None:
            staleness.need_current(results, options.configfile)
        found = compared(results, reference)
        if not options.bless:
            need_reference(found)
        for difference in found.differences:
            print(difference)
        if options.bless:
            bless(found)
            print(f"{reference} is written: review it with git diff")
            return 0
        print(found.verdict)
        if proofs := enclosures.verdict(found.enclosed):
            print(proofs)
        if options.output:
            write_output(found, options.output)
        tell_ci(found)
    except (VibrissaError, OSError) as error:
        print(f"error: {error}", file=sys.stderr)
        if in_github():
            print(ci.command("error", str(error), title="make check"))
        return 2
    return 1 if found.differences else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
