"""Run a long check, or update pages from the code: python -m validation NAME."""

import os
import subprocess
import sys
from collections.abc import Callable, Sequence
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

ROOT = Path(__file__).parents[1]
INSTALL = "type make setup LOCKS='test docs cluster'"
USAGE = "python -m validation NAME [options]; most checks list their options with --help"


class Task(NamedTuple):
    """A check: the function that runs it, what it does, and how long it takes on two cores.

    `needs` has modules that only the program needs which the function starts.
    """

    run: Callable[[Sequence[str]], object]
    what: str
    time: str
    needs: Sequence[str] = ()


def module(name: str) -> Callable[[Sequence[str]], object]:
    """Return a function that runs the `main` of a module, which reads the command line itself."""
    return lambda options: import_module(name).main()


def python(*arguments: str) -> Callable[[Sequence[str]], object]:
    """Return a function that runs Python with some arguments in the root of the repository."""
    command = [sys.executable, *arguments]
    return lambda options: subprocess.run([*command, *options], cwd=ROOT).returncode


def tests(*chosen: str) -> Callable[[Sequence[str]], object]:
    """Return a function that runs the tests that pytest finds; a skipped test is a failure."""

    def run(options: Sequence[str]) -> object:
        with TemporaryDirectory() as reports:
            report = str(Path(reports, "report.xml"))
            status = python("-m", "pytest", *chosen, "--junitxml", report)(options)
            return status or python(".ci/skips.py", "--none", report)([])

    return run


TESTS = ("pytest", "hypothesis", "psutil")
CLUSTER = ("snakemake_executor_plugin_slurm", "snakemake_executor_plugin_cluster_generic")
# Those in tests/nightly, and those elsewhere that have the marker.
NIGHTLY = tests("tests", "-o", "norecursedirs=slurm faults", "-m", "nightly")
SLURM, FAULTS = tests("tests/slurm"), tests("tests/faults", "-n", "logical")
TASKS = {
    # The rod
    "published": Task(module("validation.published"), "compare 290 published numbers", "30 s"),
    "survey": Task(module("validation.survey"), "solve 100,000 random points", "10 min"),
    "stiffness": Task(module("validation.stiffness"), "compare rods of any stiffness", "1 min"),
    "march": Task(module("validation.march_agreement"), "compare rods with a march", "15 min"),
    "chains": Task(module("validation.chains"), "compare chains of links with rods", "2 min"),
    "trailing": Task(module("validation.trailing"), "solve retracted rods by shooting", "5 min"),
    "vibration": Task(module("validation.vibration"), "frequencies of chains of links", "1 min"),
    "slip-dynamics": Task(
        module("validation.slip_dynamics"), "slips of rods with mass and damping", "10 min"
    ),
    "proof": Task(module("validation.proof.study"), "prove the numbers of a study", "10 min"),
    # The sensor
    "laboratory": Task(module("validation.sensor.laboratory"), "benches with set-up errors", "2 h"),
    "costs": Task(module("validation.sensor.costs"), "effect of tolerances on friction", "1 min"),
    # The explorer
    "explorer-agreement": Task(
        module("validation.explorer_agreement"), "compare the explorer with Python", "8 min"
    ),
    # The pages
    "accessibility": Task(
        module("validation.accessibility"), "look at each page with axe-core", "2 min"
    ),
    # Speed
    "bench": Task(module("benchmarks.table"), "compare the speed with others", "2 min"),
    "growth": Task(module("benchmarks.growth"), "studies of 10^4 to 10^6 points", "20 min"),
    # Tests of the tests
    "mutants": Task(module("validation.mutants"), "count faults that tests notice", "1 h"),
    # Tests that `make test` leaves out
    "tests": Task(NIGHTLY, "tests of proofs, and slow tests", "15 min", TESTS),
    "slurm": Task(SLURM, "run a study on SLURM, as root on Debian", "4 min", (*TESTS, *CLUSTER)),
    "faults": Task(FAULTS, "kill runs, fill disks, damage files", "20 min", TESTS),
    # Contents of pages
    "notebooks": Task(python("examples/rerun.py"), "run the notebooks, store outputs", "2 min"),
    "pages": Task(
        python("docs/generated.py"), "update generated tables in pages", "5 s", ("grimp",)
    ),
    "sketch": Task(python("docs/sketch.py"), "draw docs/sketch.svg with the solver", "5 s"),
    "pictures": Task(python("docs/pictures.py"), "draw pictures of the pages", "20 s"),
}


def listed() -> str:
    """List the checks, one for each line: name, what it does, and how long it takes."""
    return "\n".join(f"  {name:20}{task.what:54}{task.time}" for name, task in TASKS.items())


def main() -> int:
    """Run the check that the command line names, with its options."""
    name, *options = sys.argv[1:] or ["--list"]
    if name in ("--list", "--help", "-h"):
        print(f"{USAGE}\n\n{listed()}")
        return 0
    if name not in TASKS:
        print(f"no such check: {name}; python -m validation --list lists all", file=sys.stderr)
        return 2
    # Several processes at a time: one thread in each.
    for library in ("OMP", "OPENBLAS", "MKL"):
        os.environ.setdefault(f"{library}_NUM_THREADS", "1")
    sys.argv = [f"python -m validation {name}", *options]
    missing = [module for module in TASKS[name].needs if find_spec(module) is None]
    if not missing:
        try:
            return TASKS[name].run(options) or 0
        except ModuleNotFoundError as error:
            missing = [str(error.name)]
    print(f"this needs {', '.join(missing)}: {INSTALL}", file=sys.stderr)
    return 2


if __name__ == "__main__":
    sys.exit(main())
