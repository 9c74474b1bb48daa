"""Prove the numbers of a study.

Without options: config.yaml, into tests/regression/<study>/enclosures.csv. What stands there
already, proved by the same code, is not proved again, so that an interrupted run goes on where it
ended. Exit status 1 if there is a row that could not be proved, or, with --against, a number whose
enclosure does not overlap with that of the other file, which should be proved with another effort.
"""

from __future__ import annotations

import argparse
import csv
import os
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import asdict, dataclass
from decimal import Decimal, localcontext
from hashlib import sha256
from itertools import product
from pathlib import Path

import flint
import typer

import vibrissa.proof
from vibrissa.decimals import exact, spell
from vibrissa.errors import ArgumentError, VibrissaError
from vibrissa.files import write_atomically
from vibrissa.outcomes import Contact
from vibrissa.proof import Effort
from vibrissa.proof.starting import suitable
from vibrissa.proof.table import Enclosure, curve_enclosures, state_enclosures
from vibrissa.study.axes import MOUNTING_AXES
from vibrissa.study.model import GridSection, Study
from vibrissa.study.reading import read_study

AXES = ("eta", "theta", "mu0", "dx0")
ROW = ("table", *AXES, "state", "scan", "cycle")
COLUMNS = (
    *ROW,
    "quantity",
    "midpoint",
    "radius",
    "on_path",
    "note",
    "bits",
    "order",
    "steps",
    "code",
)
# Points that one job proves: few, so that an interruption loses little; not too few, as each job
# covers the path up to its last point.
POINTS = 24
# What proves and encloses; the rest of the package shows it to people.
PROVES = ("critical", "digits", "equilibrium", "flow", "krawczyk", "path", "starting", "table")

Line = dict[str, str]


@dataclass(frozen=True)
class CurveJob:
    """Some points on one curve; the first job of a curve proves mu_lock, too."""

    theta: Decimal
    eta: Decimal
    points: Sequence[tuple[Decimal, Decimal]]
    effort: Effort
    lock: bool

    def run(self) -> list[Line]:
        found = curve_enclosures(self.theta, self.eta, self.points, self.effort, lock=self.lock)
        return lines(found, self.effort)

    def rows(self) -> Iterator[tuple[str, ...]]:
        curve = {"eta": spell(self.eta), "theta": spell(self.theta)}
        yield row_of({"table": "curves"} | curve)
        for mu0, dx0 in self.points:
            yield row_of({"table": "stiction", "mu0": spell(mu0), "dx0": spell(dx0)} | curve)


@dataclass(frozen=True)
class StateJob:
    """A single state."""

    name: str
    theta: Decimal
    eta: Decimal
    x1: Decimal
    effort: Effort

    def run(self) -> list[Line]:
        found = state_enclosures(self.name, self.theta, self.eta, self.x1, self.effort)
        return lines(found, self.effort)

    def rows(self) -> Iterator[tuple[str, ...]]:
        yield row_of({"table": "states", "state": self.name})


Job = CurveJob | StateJob


def jobs(study: Study, effort: Effort | None = None) -> list[Job]:
    """All that is to be proved: the points of grids and scans, each once, and the single states."""
    if study.contact is not Contact.POINT:
        raise ArgumentError(f"study {study.name}: only tip contact (contact: point) is proved")
    found: list[Job] = []
    grids = [*study.grids.values(), *study.scans.values()]
    for (theta, eta), points in points_of_rods(study.name, grids).items():
        spent = effort or suitable(theta)
        for first in range(0, len(points), POINTS):
            part = points[first : first + POINTS]
            found.append(CurveJob(theta, eta, part, spent, lock=first == 0))
    for name, state in study.states.items():
        if state.contact in (None, Contact.POINT):
            place = exact(state.theta), exact(state.eta), exact(state.x1)
            found.append(StateJob(name, *place, effort or suitable(place[0])))
    return found


def points_of_rods(
    study: str, grids: Iterable[GridSection]
) -> dict[tuple[Decimal, Decimal], list[tuple[Decimal, Decimal]]]:
    """Friction coefficients and steps of some grids of a study, by taper and height, once each.

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


def lines(found: Sequence[Enclosure], effort: Effort) -> list[Line]:
    """Enclosures as text, with how they were proved."""
    made = {name: str(value) for name, value in asdict(effort).items()}
    return [
        {
            "table": one.table,
            **{name: spelled(value) for name, value in one.row.items()},
            "quantity": one.quantity,
            "midpoint": spelled(one.midpoint),
            "radius": "" if one.radius is None else str(one.radius),
            "on_path": "yes" if one.on_path else "no",
            "note": one.note,
            **made,
            "code": code(),
        }
        for one in found
    ]


def spelled(value: Decimal | str | None) -> str:
    return spell(value) if isinstance(value, Decimal) else value or ""


def code() -> str:
    """Digest of the code that proves and of the version of Arb."""
    digest = sha256(flint.__FLINT_VERSION__.encode())
    for name in PROVES:
        digest.update(Path(vibrissa.proof.__file__).with_name(f"{name}.py").read_bytes())
    return digest.hexdigest()[:12]


def row_of(line: Mapping[str, str]) -> tuple[str, ...]:
    return tuple(line.get(name, "") for name in ROW)


def read(path: Path) -> list[Line]:
    """Lines that the code of today has proved."""
    if not path.is_file():
        return []
    with path.open(encoding="utf-8", newline="") as file:
        return [line for line in csv.DictReader(file) if line.get("code") == code()]


def write(found: Sequence[Line], path: Path) -> None:
    """Write the lines, in the order of their rows."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with (
        write_atomically(path) as temporary,
        temporary.open("w", encoding="utf-8", newline="") as f,
    ):
        writer = csv.DictWriter(f, COLUMNS, restval="", lineterminator="\n")
        writer.writeheader()
        writer.writerows(sorted(found, key=in_order))


def in_order(line: Mapping[str, str]) -> tuple[object, ...]:
    axes = [Decimal(line.get(axis) or 0) for axis in (*AXES, "cycle")]
    return line["table"], line.get("scan", ""), axes, line.get("state", "")


def proved(
    wanted: Sequence[Job], path: Path, processes: int, tell: Callable[[int, int], None]
) -> list[Line]:
    """Prove what the file does not have, and write it there."""
    efforts = {row: asdict(job.effort) for job in wanted for row in job.rows()}
    known = [line for line in read(path) if made_with(line, efforts.get(row_of(line)))]
    done = set(map(row_of, known))
    missing = [job for job in wanted if not done.issuperset(job.rows())]
    # Jobs on one curve prove its state at α = 0 each; it is kept once.
    kept = {(row_of(line), line["quantity"]): line for line in known}
    with ProcessPoolExecutor(processes) as pool:
        for count, future in enumerate(as_completed([pool.submit(job.run) for job in missing])):
            kept |= {(row_of(line), line["quantity"]): line for line in future.result()}
            write(list(kept.values()), path)
            tell(count + 1, len(missing))
    write(list(kept.values()), path)
    return list(kept.values())


def cycles(study: Study, found: Sequence[Line]) -> Iterator[Line]:
    """Steps of the scans, decided by the proved periods.

    In each cycle the tip sticks up to the last step before the onset and slips one step later; the
    contact point has then moved as far as the clamp. As −tan α rises, it is largest at the last
    step.
    """
    known = {(row_of(line), line["quantity"]): line for line in found if line["on_path"] == "yes"}
    for name, scan in study.scans.items():
        for point in scan.points():
            dx0 = exact(point["dx0"])
            on_curve = {axis: spell(exact(point[axis])) for axis in ("eta", "theta")}
            at_point = on_curve | {"mu0": spell(exact(point["mu0"])), "dx0": spell(dx0)}
            n_steps, alpha, x1 = (
                known.get((row_of({"table": table, **row}), quantity))
                for table, row, quantity in (
                    ("stiction", at_point, "n_steps"),
                    ("stiction", at_point, "alpha_last"),
                    ("curves", on_curve, "x1_init"),
                )
            )
            if not (n_steps and alpha and x1):
                continue
            for cycle in range(1, scan.cycles + 1):
                row = at_point | {"table": "scans", "scan": name, "cycle": str(cycle)}
                for quantity, source, value in cycle_numbers(n_steps, alpha, x1, dx0, cycle):
                    yield source | row | {"quantity": quantity, "midpoint": spell(value)}


def cycle_numbers(
    n_steps: Line, alpha: Line, x1: Line, dx0: Decimal, cycle: int
) -> Iterator[tuple[str, Line, Decimal]]:
    """Numbers of a cycle: the column, the line it follows from, and its value."""
    with localcontext(prec=60):
        steps = Decimal(n_steps["midpoint"])
        moved = (steps + 1) * dx0
        first = Decimal(x1["midpoint"])
        return iter(
            [
                ("steps", n_steps, steps + 1),
                ("slips", n_steps, Decimal(1)),
                ("footpoint_end", n_steps, cycle * moved),
                ("x0_largest", n_steps, steps * dx0),
                ("x1_begin", x1, first + (cycle - 1) * moved),
                ("x1_end", x1, first + cycle * moved),
                ("alpha_smallest", alpha, Decimal(alpha["midpoint"])),
            ]
        )


def made_with(line: Line, effort: Mapping[str, int] | None) -> bool:
    """Whether a line is wanted, and was proved with this effort."""
    return effort is not None and all(line[name] == str(value) for name, value in effort.items())


def summary(found: Sequence[Line], seconds: float) -> Iterator[str]:
    """What was proved, and what not."""
    good = [line for line in found if line["midpoint"]]
    rows = len({row_of(line) for line in good})
    widths = [
        (Decimal(line["radius"]) / abs(Decimal(line["midpoint"])), line)
        for line in good
        if Decimal(line["radius"])
    ]
    widest, line = max(widths, key=lambda pair: pair[0])
    yield f"{len(good)} numbers in {rows} rows are proved, in {seconds:.0f} s"
    paths = [
        {row_of(line) for line in found if line["on_path"] == answer} for answer in ("yes", "no")
    ]
    states = {row for row in paths[1] if row[0] == "states"}
    yield f"{len(paths[0])} rows are on their path, {len(paths[1] - states)} are not proved to be"
    yield f"widest: {widest:.1E} of the value, {line['quantity']} at {where(line)}"
    for line in found:
        if line["note"]:
            yield f"{line['table']} at {where(line)}: {line['note']}"


def apart(found: Sequence[Line], others: Sequence[Line]) -> list[Line]:
    """Lines that the others do not have, or whose enclosure does not overlap with theirs."""
    known = {(row_of(line), line["quantity"]): line for line in others}
    return [
        line
        for line in found
        if (other := known.get((row_of(line), line["quantity"]))) is None
        or not overlap(line, other)
    ]


def overlap(one: Line, other: Line) -> bool:
    if not (one["midpoint"] and other["midpoint"]):
        return one["note"] == other["note"] and one["on_path"] == other["on_path"]
    distance = abs(Decimal(one["midpoint"]) - Decimal(other["midpoint"]))
    return distance <= Decimal(one["radius"]) + Decimal(other["radius"])


def where(line: Mapping[str, str]) -> str:
    return ", ".join(f"{name} {line[name]}" for name in ROW[1:] if line.get(name))


def main(argv: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description="Prove the numbers of a study.")
    parser.add_argument("--configfile", type=Path, default=Path("config.yaml"))
    parser.add_argument("--output", type=Path, help="instead of tests/regression/<study>/...")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="processes at a time")
    parser.add_argument("--effort", type=int, nargs=3, metavar=("BITS", "ORDER", "STEPS"))
    parser.add_argument("--against", type=Path, help="enclosures that these must overlap with")
    options = parser.parse_args(argv)
    differing: list[Line] = []
    try:
        study = read_study(Path(options.configfile))
        wanted = jobs(study, Effort(*options.effort) if options.effort else None)
        path = options.output or Path("tests/regression", study.name, "enclosures.csv")
        begin = time.monotonic()
        with typer.progressbar(length=1000, label="proved", file=sys.stderr) as bar:
            found = proved(
                wanted, path, options.jobs, lambda n, of: bar.update(1000 * n // of - bar.pos)
            )
        found += cycles(study, found)
        write(found, path)
        for line in summary(found, time.monotonic() - begin):
            print(line)
        print(f"{path} is written")
        if options.against:
            differing = apart(found, read(options.against))
            print(f"{len(found) - len(differing)} of {len(found)} lines overlap")
            for line in differing:
                print(f"apart: {line['table']}.{line['quantity']} at {where(line)}")
    except (VibrissaError, OSError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    return 1 if differing or any(map(open_question, found)) else 0


def open_question(line: Mapping[str, str]) -> bool:
    """Whether a row is without a proof, or not proved to be on its path."""
    return line["on_path"] == "no" and (line["table"] != "states" or not line["midpoint"])
