"""Compare the results of a study with reference tables, or update these; used by the Makefile.

Usage: python workflow/check.py [--configfile FILE] [--results FOLDER] [--reference FOLDER]
                                [--output FOLDER] [--bless]

By default, compare results/paper with tests/regression/paper. The reference may be the results of
another study: --reference results/other. Exit status 1 if results differ, 2 if there is nothing to
compare or other code or another study file made the tables.

A summary is appended to the file named by GITHUB_STEP_SUMMARY. With GITHUB_ACTIONS=true, GitHub
shows differences beside the reference tables.
"""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path

from vibrissa.checking import condensing, proofs
from vibrissa.checking.reference import Comparison, bless, compare_folders
from vibrissa.checking.tolerances import TableLayout, read_layouts
from vibrissa.errors import VibrissaError
from vibrissa.files import write_atomically
from vibrissa.pipeline import outdated, places
from vibrissa.study.reading import read_study

LAYOUT = "regression.yaml"


def layouts_of(reference: Path) -> dict[str, TableLayout]:
    """Read the layouts of the reference tables: from the reference's folder, or the common ones."""
    own = reference / LAYOUT
    return read_layouts(own if own.is_file() else Path(__file__).with_name(LAYOUT))


def write_output(found: Comparison, folder: Path) -> None:
    """Write check.md, check.json, and the reference tables that `make bless` would write."""
    bless(found.results, folder / "reference", layouts_of(found.reference))
    for name, text in {"check.md": found.markdown(), "check.json": found.json()}.items():
        with write_atomically(folder / name) as temporary:
            temporary.write_text(text, encoding="utf-8")


def in_github() -> bool:
    return os.environ.get("GITHUB_ACTIONS") == "true"


def annotation(text: str, file: str = "") -> str:
    """Format an error as an annotation that GitHub shows beside a file."""
    for character in "%\r\n":
        text = text.replace(character, f"%{ord(character):02X}")
    return f"::error{f' file={file}' if file else ''}::{text}"


def tell_ci(found: Comparison) -> None:
    if summary := os.environ.get("GITHUB_STEP_SUMMARY"):
        with open(summary, "a", encoding="utf-8") as file:
            file.write(found.markdown())
    if in_github():
        for difference in found.differences[:10]:  # GitHub shows ten for each step
            print(annotation(difference.text, f"{found.reference}/{difference.table}.csv"))


def run(options: argparse.Namespace) -> int:
    study = read_study(options.configfile)
    results = options.results or Path("results", study.name)
    reference = options.reference or Path("tests/regression", study.name)
    if options.results is None:
        tables = [f"tables/{name}.parquet" for name in condensing.TABLES if name in study.tables]
        outdated.need_current(study, options.configfile, tables)
    if options.bless:
        bless(results, reference, layouts_of(reference))
        print(f"{reference} is written: review it with git diff")
        return 0
    found = compare_folders(results, reference, layouts_of(reference))
    for difference in found.differences:
        print(difference.text)
    if options.output:
        write_output(found, options.output)
    tell_ci(found)
    if line := proofs.verdict(found.proved):
        print(line)
    print(found.verdict)
    return 1 if found.differences else 0


def main(argv: list[str]) -> int:
    parser = argparse.ArgumentParser(description="Compare results with reference tables.")
    parser.add_argument("--configfile", type=Path, default=places.PAPER, help="study file")
    parser.add_argument(
        "--results",
        type=Path,
        help="compare this folder, current or not, instead of results/<study>",
    )
    parser.add_argument(
        "--reference",
        type=Path,
        help="reference tables or results; default: tests/regression/<study>",
    )
    parser.add_argument("--output", type=Path, help="folder for check.md, check.json, reference/")
    parser.add_argument("--bless", action="store_true", help="update the reference tables")
    try:
        return run(parser.parse_args(argv))
    except (VibrissaError, OSError) as error:
        print(f"error: {error}", file=sys.stderr)
        if in_github():
            print(annotation(str(error)))
    return 2


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
