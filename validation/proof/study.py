"""Prove the numbers of a study.

The enclosures are written beside the study's reference tables, and `make check` compares the
study's results with them. Exit status 1 if a row is not proved.
"""

import argparse
import csv
import os
import sys
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict
from decimal import Decimal
from itertools import product
from pathlib import Path
from typing import Any

from rich.progress import track

from validation.proof.rows import Line, cycle_lines, rod_lines, state_lines
from validation.proof.starting import suitable
from vibrissa.decimals import exact, spell
from vibrissa.errors import ArgumentError, VibrissaError
from vibrissa.files import write_atomically
from vibrissa.outcomes import Contact
from vibrissa.study.axes import MOUNTING_AXES
from vibrissa.study.chunks import points_of
from vibrissa.study.grids import GridSection
from vibrissa.study.model import Study
from vibrissa.study.reading import read_study

AXES = ("eta", "theta", "mu0", "dx0")
ROW = ("table", *AXES, "state", "scan", "cycle")
COLUMNS = (*ROW, "quantity", "midpoint", "radius", "on_path", "note", "bits", "order", "steps")

# A function that proves rows, its arguments, and the taper, which determines the effort.
Job = tuple[Any, tuple[Any, ...], Decimal]


def jobs(study: Study) -> Iterator[Job]:
    """Yield the proofs of a study: the points of grids and scans, each once, and the states."""
    if study.contact is not Contact.POINT:
        raise ArgumentError(f"study {study.name}: only tip contact (contact: point) is proved")
    grids = [*study.grids.values(), *study.scans.values()]
    for (theta, eta), points in points_of_rods(study.name, grids).items():
        yield rod_lines, (theta, eta, points), theta
    for name, state in study.states.items():
        if state.contact in (None, Contact.POINT):
            theta, eta, x1 = map(exact, (state.theta, state.eta, state.x1))
            yield state_lines, (name, theta, eta, x1), theta


def points_of_rods(
    study: str, grids: Iterable[GridSection]
) -> dict[tuple[Decimal, Decimal], list[tuple[Decimal, Decimal]]]:
    """Collect the pairs (μ0, Δx0) of some grids by (θ, η), each pair once.

    Raises
    ------
    ArgumentError
        If a mounting is not ideal.
    """
    found = defaultdict(set)
    for grid in grids:
        if any(set(grid.axes[axis]) != {0.0} for axis in MOUNTING_AXES):
            raise ArgumentError(f"study {study}: only the ideal mounting is proved")
        pairs = set(product(map(exact, grid.mu0), map(exact, grid.dx0)))
        for rod in product(map(exact, grid.theta), map(exact, grid.eta)):
            found[rod] |= pairs
    return {rod: sorted(pairs) for rod, pairs in found.items()}


def proved(study: Study, processes: int | None) -> list[Line]:
    """Prove the numbers of a study, and derive the numbers of its scans."""
    wanted = list(jobs(study))
    with ProcessPoolExecutor(processes) as pool:
        results = track(pool.map(_prove, wanted), description="proved", total=len(wanted))
        found = [line for part in results for line in part]
    return sorted([*found, *cycles(study, found)], key=_order)


def _prove(job: Job) -> list[Line]:
    prove, arguments, theta = job
    effort = suitable(theta)
    spent = {name: str(value) for name, value in asdict(effort).items()}
    return [line | spent for line in prove(*arguments, effort)]


def _order(line: Line) -> tuple[object, ...]:
    axes = [Decimal(line.get(axis) or 0) for axis in (*AXES, "cycle")]
    return line["table"], line.get("scan", ""), axes, line.get("state", "")


def cycles(study: Study, found: Sequence[Line]) -> Iterator[Line]:
    """Yield the numbers of the scans' cycles, derived from the proved periods."""
    known: dict[tuple[str, ...], dict[str, Line]] = defaultdict(dict)
    for line in found:
        if line["on_path"] == "yes" and "quantity" in line:
            known[row_of(line)][line["quantity"]] = line
    for name, scan in study.scans.items():
        for point in points_of(scan.axes):
            keys = {axis: spell(exact(point[axis])) for axis in AXES}
            rod = {"table": "curves", "eta": keys["eta"], "theta": keys["theta"]}
            curve, period = known[row_of(rod)], known[row_of({"table": "stiction", **keys})]
            row = {"table": "scans", "scan": name, **keys}
            yield from cycle_lines(row, scan.cycles, curve, period)


def row_of(line: Mapping[str, str]) -> tuple[str, ...]:
    """Return the keys of a line's row."""
    return tuple(line.get(name, "") for name in ROW)


def write(found: Iterable[Line], path: Path) -> None:
    """Write the file of enclosures."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with (
        write_atomically(path) as temporary,
        temporary.open("w", encoding="utf-8", newline="") as file,
    ):
        writer = csv.DictWriter(file, COLUMNS, restval="", lineterminator="\n")
        writer.writeheader()
        writer.writerows(found)


def open_question(line: Line) -> bool:
    """Whether a line has no proof, or no proof that its state is on the path."""
    return line["on_path"] == "no" and (line["table"] != "states" or "note" in line)


def main(arguments: Sequence[str] | None = None) -> int:
    """Prove a study's numbers and write them."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--configfile", type=Path, default=Path("config.yaml"))
    parser.add_argument(
        "--output", type=Path, help="default: tests/regression/<study>/enclosures.csv"
    )
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="processes at a time")
    options = parser.parse_args(arguments)
    try:
        study = read_study(options.configfile)
        found = proved(study, options.jobs)
        path = options.output or Path("tests/regression", study.name, "enclosures.csv")
        write(found, path)
    except (VibrissaError, OSError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    numbers = [line for line in found if "quantity" in line]
    rows = len(set(map(row_of, numbers)))
    print(f"{len(numbers)} numbers in {rows} rows are proved; {path} is written")
    questions = list(filter(open_question, found))
    for line in questions:
        keys = ", ".join(f"{name} {line[name]}" for name in ROW[1:] if name in line)
        print(f"not proved: {line['table']} at {keys}: {line.get('note') or 'its path'}")
    return 1 if questions else 0
