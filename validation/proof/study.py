"""Prove the numbers of a study.

The enclosures stand beside the study's reference tables, and `make check` compares its tables with
them. Exit status 1 if there is a row that could not be proved, or, with --against, a number whose
enclosure does not overlap with that of the other file, which should be proved with another effort.
"""

import argparse
import csv
import os
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass
from decimal import Decimal, localcontext
from functools import partial
from itertools import product
from pathlib import Path

from rich.progress import track

from validation.proof.flow import Effort
from validation.proof.starting import suitable
from validation.proof.table import Enclosure, curve_enclosures, state_enclosures
from vibrissa.decimals import exact, spell
from vibrissa.errors import ArgumentError, VibrissaError
from vibrissa.files import write_atomically
from vibrissa.outcomes import Contact
from vibrissa.study.axes import MOUNTING_AXES
from vibrissa.study.model import GridSection, Study
from vibrissa.study.reading import read_study

AXES = ("eta", "theta", "mu0", "dx0")
ROW = ("table", *AXES, "state", "scan", "cycle")
COLUMNS = (*ROW, "quantity", "midpoint", "radius", "on_path", "note", "bits", "order", "steps")
# Points that one job proves: each job covers the path up to its last point.
POINTS = 24

Line = dict[str, str]


@dataclass(frozen=True)
class CurveJob:
    """Some points on one curve; the first job of a curve proves mu_lock, too."""

    theta: Decimal
    eta: Decimal
    points: Sequence[tuple[Decimal, Decimal]]
    lock: bool

    def prove(self, effort: Effort | None) -> list[Line]:
        """Return the lines of the file."""
        effort = effort or suitable(self.theta)
        found = curve_enclosures(self.theta, self.eta, self.points, effort, lock=self.lock)
        return [line_of(one, effort) for one in found]


@dataclass(frozen=True)
class StateJob:
    """A single state."""

    name: str
    theta: Decimal
    eta: Decimal
    x1: Decimal

    def prove(self, effort: Effort | None) -> list[Line]:
        """Return the lines of the file."""
        effort = effort or suitable(self.theta)
        found = state_enclosures(self.name, self.theta, self.eta, self.x1, effort)
        return [line_of(one, effort) for one in found]


Job = CurveJob | StateJob


def jobs(study: Study) -> list[Job]:
    """List what is to be proved: the points of grids and scans, each once, and the states."""
    if study.contact is not Contact.POINT:
        raise ArgumentError(f"study {study.name}: only tip contact (contact: point) is proved")
    found: list[Job] = []
    grids = [*study.grids.values(), *study.scans.values()]
    for (theta, eta), points in points_of_rods(study.name, grids).items():
        for first in range(0, len(points), POINTS):
            part = points[first : first + POINTS]
            found.append(CurveJob(theta, eta, part, lock=first == 0))
    for name, state in study.states.items():
        if state.contact in (None, Contact.POINT):
            found.append(StateJob(name, exact(state.theta), exact(state.eta), exact(state.x1)))
    return found


def points_of_rods(
    study: str, grids: Iterable[GridSection]
) -> dict[tuple[Decimal, Decimal], list[tuple[Decimal, Decimal]]]:
    """List friction coefficients and steps of some grids, by taper and height, once each.

    Raises
    ------
    ArgumentError
        If a rod is mounted in another way than in the paper.
    """
    found: dict[tuple[Decimal, Decimal], set[tuple[Decimal, Decimal]]] = {}
    for grid in grids:
        if any(set(grid.axes[axis]) != {0.0} for axis in MOUNTING_AXES):
            raise ArgumentError(f"study {study}: only the ideal mounting is proved")
        pairs = set(product(map(exact, grid.mu0), map(exact, grid.dx0)))
        for eta, theta in product(map(exact, grid.eta), map(exact, grid.theta)):
            found.setdefault((theta, eta), set()).update(pairs)
    return {rod: sorted(found[rod]) for rod in sorted(found, key=lambda rod: rod[::-1])}


def line_of(one: Enclosure, effort: Effort) -> Line:
    """Write an enclosure as text, with the effort that proved it."""
    return {
        "table": one.table,
        **{name: spelled(value) for name, value in one.row.items()},
        "quantity": one.quantity,
        "midpoint": spelled(one.midpoint),
        "radius": "" if one.radius is None else str(one.radius),
        "on_path": "yes" if one.on_path else "no",
        "note": one.note,
        **{name: str(value) for name, value in asdict(effort).items()},
    }


def spelled(value: Decimal | str | None) -> str:
    """Write a number exactly, and nothing for None."""
    return spell(value) if isinstance(value, Decimal) else value or ""


def row_of(line: Mapping[str, str]) -> tuple[str, ...]:
    """Return the keys of a line's row."""
    return tuple(line.get(name, "") for name in ROW)


def in_order(line: Mapping[str, str]) -> tuple[object, ...]:
    """Return what lines are sorted by."""
    axes = [Decimal(line.get(axis) or 0) for axis in (*AXES, "cycle")]
    return line["table"], line.get("scan", ""), axes, line.get("state", "")


def write(found: Sequence[Line], path: Path) -> None:
    """Write the lines, in the order of their rows."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with (
        write_atomically(path) as temporary,
        temporary.open("w", encoding="utf-8", newline="") as file,
    ):
        writer = csv.DictWriter(file, COLUMNS, restval="", lineterminator="\n")
        writer.writeheader()
        writer.writerows(sorted(found, key=in_order))


def read(path: Path) -> list[Line]:
    """Read the lines of a file."""
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def proved(study: Study, effort: Effort | None, processes: int | None) -> list[Line]:
    """Prove the numbers of a study."""
    wanted = jobs(study)
    # Jobs on one curve prove its state at α = 0 each; it is kept once.
    kept: dict[tuple[object, ...], Line] = {}
    with ProcessPoolExecutor(processes) as pool:
        results = pool.map(partial(_prove, effort=effort), wanted)
        for lines in track(results, description="proved", total=len(wanted)):
            kept |= {(row_of(line), line["quantity"]): line for line in lines}
    found = list(kept.values())
    return found + list(cycles(study, found))


def _prove(job: Job, effort: Effort | None) -> list[Line]:
    return job.prove(effort)


def cycles(study: Study, found: Sequence[Line]) -> Iterator[Line]:
    """Yield the steps of the scans, decided by the proved periods.

    In each cycle the tip sticks up to the last step before the onset and slips one step later; the
    contact point has then moved as far as the clamp. As −tan α rises, it is largest at the last
    step.
    """
    known = {(row_of(line), line["quantity"]): line for line in found if line["on_path"] == "yes"}
    for name, scan in study.scans.items():
        for point in scan.points():
            curve = {axis: spell(exact(point[axis])) for axis in ("eta", "theta")}
            period = curve | {axis: spell(exact(point[axis])) for axis in ("mu0", "dx0")}
            of_curve, of_period = (
                row_of({"table": table, **row})
                for table, row in (("curves", curve), ("stiction", period))
            )
            n_steps, alpha = (known.get((of_period, name)) for name in ("n_steps", "alpha_last"))
            x1 = known.get((of_curve, "x1_init"))
            if not (n_steps and alpha and x1):
                continue
            for cycle in range(1, scan.cycles + 1):
                row = period | {"table": "scans", "scan": name, "cycle": str(cycle)}
                numbers = cycle_numbers(n_steps, alpha, x1, Decimal(period["dx0"]), cycle)
                for quantity, source, value in numbers:
                    yield source | row | {"quantity": quantity, "midpoint": spell(value)}


def cycle_numbers(
    n_steps: Line, alpha: Line, x1: Line, dx0: Decimal, cycle: int
) -> list[tuple[str, Line, Decimal]]:
    """List the numbers of a cycle: the column, the line it follows from, and its value."""
    with localcontext(prec=60):
        steps, first = Decimal(n_steps["midpoint"]), Decimal(x1["midpoint"])
        moved = (steps + 1) * dx0
        return [
            ("steps", n_steps, steps + 1),
            ("slips", n_steps, Decimal(1)),
            ("footpoint_end", n_steps, cycle * moved),
            ("x0_largest", n_steps, steps * dx0),
            ("x1_begin", x1, first + (cycle - 1) * moved),
            ("x1_end", x1, first + cycle * moved),
            ("alpha_smallest", alpha, Decimal(alpha["midpoint"])),
        ]


def summary(found: Sequence[Line]) -> Iterator[str]:
    """Say what was proved, and what not."""
    good = [line for line in found if line["midpoint"]]
    yield f"{len(good)} numbers in {len({row_of(line) for line in good})} rows are proved"
    paths = {
        answer: {row_of(line) for line in found if line["on_path"] == answer}
        for answer in ("yes", "no")
    }
    states = {row for row in paths["no"] if row[0] == "states"}
    yield f"{len(paths['yes'])} rows are on their path, {len(paths['no'] - states)} are not proved"
    for line in found:
        if line["note"]:
            yield f"{line['table']} at {where(line)}: {line['note']}"


def apart(found: Sequence[Line], others: Sequence[Line]) -> list[Line]:
    """List lines that the others do not have, or whose enclosure does not overlap with theirs."""
    known = {(row_of(line), line["quantity"]): line for line in others}
    pairs = [(line, known.get((row_of(line), line["quantity"]))) for line in found]
    return [line for line, other in pairs if other is None or not overlap(line, other)]


def overlap(one: Line, other: Line) -> bool:
    """Whether two enclosures of a number overlap, or two notes are the same."""
    if not (one["midpoint"] and other["midpoint"]):
        return one["note"] == other["note"] and one["on_path"] == other["on_path"]
    distance = abs(Decimal(one["midpoint"]) - Decimal(other["midpoint"]))
    return distance <= Decimal(one["radius"]) + Decimal(other["radius"])


def where(line: Mapping[str, str]) -> str:
    """Name a line's row."""
    return ", ".join(f"{name} {line[name]}" for name in ROW[1:] if line.get(name))


def open_question(line: Mapping[str, str]) -> bool:
    """Whether a row is without a proof, or not proved to be on its path."""
    return line["on_path"] == "no" and (line["table"] != "states" or not line["midpoint"])


def main(arguments: Sequence[str] | None = None) -> int:
    """Prove a study's numbers and write them."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--configfile", type=Path, default=Path("config.yaml"))
    parser.add_argument("--output", type=Path, help="instead of tests/regression/<study>/...")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="processes at a time")
    parser.add_argument("--effort", type=int, nargs=3, metavar=("BITS", "ORDER", "STEPS"))
    parser.add_argument("--against", type=Path, help="enclosures that these must overlap with")
    options = parser.parse_args(arguments)
    differing: list[Line] = []
    try:
        study = read_study(options.configfile)
        found = proved(study, Effort(*options.effort) if options.effort else None, options.jobs)
        path = options.output or Path("tests/regression", study.name, "enclosures.csv")
        write(found, path)
        print(*summary(found), f"{path} is written", sep="\n")
        if options.against:
            differing = apart(found, read(options.against))
            print(f"{len(found) - len(differing)} of {len(found)} lines overlap")
            for line in differing:
                print(f"apart: {line['table']}.{line['quantity']} at {where(line)}")
    except (VibrissaError, OSError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    return 1 if differing or any(map(open_question, found)) else 0
