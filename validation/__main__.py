"""Run a long check, or what brings pages in line with the code: python -m validation NAME."""

import os
import subprocess
import sys
from collections.abc import Callable, Sequence
from importlib import import_module
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[1]
USAGE = "python -m validation NAME [options]; NAME --help lists the options of most"


class Task(NamedTuple):
    """What a name stands for: how it is run, what it does, and how long it takes on two cores."""

    run: Callable[[Sequence[str]], object]
    what: str
    time: str


def module(name: str) -> Callable[[Sequence[str]], object]:
    """Return what runs the function main of a module, which reads the options itself."""
    return lambda options: import_module(name).main()


def python(*arguments: str) -> Callable[[Sequence[str]], object]:
    """Return what runs Python with some arguments, in the root of the repository."""
    command = [sys.executable, *arguments]
    return lambda options: subprocess.run([*command, *options], cwd=ROOT).returncode


NIGHTLY, SLURM, FAULTS = (
    python("-m", "pytest", f"tests/{folder}") for folder in ("nightly", "slurm", "faults")
)
TASKS = {
    # The rod
    "published": Task(module("validation.published"), "274 numbers of others, beside ours", "30 s"),
    "survey": Task(module("validation.survey"), "solve 100,000 random points", "10 min"),
    "chains": Task(module("validation.chains"), "chains of links, beside the rod", "2 min"),
    "trailing": Task(module("validation.trailing"), "multiple shooting, retracted rods", "5 min"),
    "proof": Task(module("validation.proof.study"), "prove the numbers of a study", "10 min"),
    # The sensor
    "laboratory": Task(module("validation.sensor.laboratory"), "a bench with mistakes", "2 h"),
    "costs": Task(module("validation.sensor.costs"), "what tolerances cost in friction", "1 min"),
    # The explorer
    "explorer-agreement": Task(
        module("validation.explorer_agreement"), "random points, in the page and in Python", "1 min"
    ),
    # Speed
    "bench": Task(module("benchmarks.table"), "states per second, beside other methods", "2 min"),
    "growth": Task(module("benchmarks.growth"), "studies of 10^4 to 10^6 points", "20 min"),
    # Do the tests notice faults?
    "mutants": Task(module("validation.mutants"), "do tests notice small faults?", "1 h"),
    # Tests that `make test` leaves out
    "tests": Task(NIGHTLY, "proofs, and whatever takes long", "10 min"),
    "slurm": Task(SLURM, "a study on a SLURM, set up as root on Debian", "4 min"),
    "faults": Task(FAULTS, "kill runs, fill disks, damage files", "10 min"),
    # What pages show
    "notebooks": Task(
        python("examples/rerun.py"), "run the notebooks, keep their outputs", "2 min"
    ),
    "pages": Task(python("docs/generated.py"), "tables of the pages that the code makes", "5 s"),
    "sketch": Task(python("docs/sketch.py"), "draw docs/sketch.svg with the solver", "5 s"),
}


def listed() -> str:
    """Return a line for each name: what it does, and how long it takes."""
    return "\n".join(f"  {name:20}{task.what:54}{task.time}" for name, task in TASKS.items())


def main() -> int:
    """Run what is named first on the command line with the options that follow."""
    name, *options = sys.argv[1:] or ["--list"]
    if name in ("--list", "--help", "-h"):
        print(f"{USAGE}\n\n{listed()}")
        return 0
    if name not in TASKS:
        print(f"no such check: {name}; python -m validation --list names them", file=sys.stderr)
        return 2
    # Several processes at a time: one thread in each.
    for library in ("OMP", "OPENBLAS", "MKL"):
        os.environ.setdefault(f"{library}_NUM_THREADS", "1")
    sys.argv = [f"python -m validation {name}", *options]
    return TASKS[name].run(options) or 0


if __name__ == "__main__":
    sys.exit(main())
