"""Check that the tests notice small faults, put one at a time into a clone of the last commit.

Cosmic Ray makes the faulty programs (mutants): validation/cosmic-ray.toml defines which faults, and
lines are drawn at random. For each mutant, the tests that run the faulty line are run, quick tests
before slow ones. Mutants that none of them notices are shown; of 170 that any test noticed, these
noticed 169. Exit status 1 if the tests fail without a fault, or if they notice fewer than 92 of 100
mutants, those included that change nothing: the record counts them by hand.
"""

import argparse
import json
import os
import random
import re
import shutil
import subprocess
import sys
import tempfile
from collections import Counter, defaultdict
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from cosmic_ray.work_db import WorkDB, use_db
from cosmic_ray.work_item import TestOutcome, WorkerOutcome, WorkItem, WorkResult
from coverage import CoverageData

from validation.records import write_record
from vibrissa.wording import markdown_table

ROOT = Path(__file__).parents[1]
CONFIG, SESSION = "validation/cosmic-ray.toml", "session.sqlite"
PACKAGE = "src/vibrissa"
# File with the tests that run each line of each file.
COVERING = "covering.json"
PYTEST = [sys.executable, *"-m pytest -x -q -p no:benchmark -p no:cacheprovider".split()]
# A mutant that keeps a test from ending is noticed after so long (s).
PYTEST += ["-o", "faulthandler_timeout=300", "-o", "faulthandler_exit_on_timeout=true"]
ENOUGH = 0.92
Tried = tuple[WorkItem, WorkResult]


def call(folder: Path, *command: str | Path) -> None:
    """Run a command with a clone's code and tests; if it fails, exit with its output."""
    paths = [str(Path(sys.executable).parent), os.environ["PATH"]]
    environment = os.environ | {
        "PATH": os.pathsep.join(paths),
        "PYTHONPATH": os.pathsep.join([str(folder / "src"), str(folder)]),
    }
    result = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True)
    if result.returncode:
        sys.exit(f"{' '.join(map(str, command))}:\n{result.stdout[-2000:]}{result.stderr[-2000:]}")


def changed(folder: Path, *since: str) -> Iterator[tuple[str, int]]:
    """Yield file and number of each line that differs from a commit, by default the last one."""
    command = ["git", "diff", "-U0", *since, "--", PACKAGE]
    path = ""
    for row in subprocess.check_output(command, cwd=folder, text=True).splitlines():
        if row.startswith("+++ "):
            path = row.removeprefix("+++ b/")
        if hunk := re.match(r"@@ \S+ \+(\d+)(?:,(\d+))? @@", row):
            first, count = int(hunk[1]), int(hunk[2] or 1)
            yield from ((path, number) for number in range(first, first + count))


def drawn(clone: Path, sample: int, seed: int, since: str | None) -> list[WorkItem]:
    """Draw lines, and one mutant of each; with `since`, only lines changed since this commit."""
    call(clone, "cosmic-ray", "init", CONFIG, SESSION)
    call(clone, "cr-filter-operators", SESSION, CONFIG)
    lines = defaultdict(list)
    with use_db(clone / SESSION, WorkDB.Mode.open) as database:
        for item in sorted(database.pending_work_items, key=place):
            path, (row, _), *_ = place(item)
            lines[path, row].append(item)
    among = set(lines) if since is None else set(lines) & set(changed(clone, since))
    draw = random.Random(seed)
    chosen = draw.sample(sorted(among), min(sample, len(among)))
    return [draw.choice(lines[line]) for line in chosen]


def place(item: WorkItem) -> tuple[str, tuple[int, int], str, int]:
    """Return the sort key of a mutant: file, position, operator and its occurrence."""
    (one,) = item.mutations
    return str(one.module_path), one.start_pos, one.operator_name, one.occurrence


def covering(clone: Path) -> dict[str, dict[int, list[str]]]:
    """Run all tests, after adding a comment to each file; list the tests that run each line."""
    files = sorted((clone / PACKAGE).rglob("*.py"))
    for path in files:
        with path.open("a", encoding="utf-8") as file:
            file.write("# changed\n")
    options = ["-n", "auto", f"--cov={PACKAGE}", "--cov-context=test", "--cov-report="]
    call(clone, *PYTEST, *options, "tests")
    call(clone, "git", "checkout", "-q", PACKAGE)
    data = CoverageData(str(clone / ".coverage"))
    data.read()
    # A context is the name of a test and its phase: test_one|run.
    return {
        str(path.relative_to(clone)): {
            line: sorted({one.rpartition("|")[0] for one in contexts} - {""})
            for line, contexts in data.contexts_by_lineno(str(path)).items()
        }
        for path in files
    }


def tried(clone: Path, items: Sequence[WorkItem]) -> list[Tried]:
    """Try mutants one after the other in a clone; leave out those that cannot be made."""
    with use_db(clone / SESSION, WorkDB.Mode.create) as database:
        database.clear()
        database.add_work_items(items)
        call(clone, "cosmic-ray", "exec", CONFIG, SESSION)
        # Some replacements of exceptions cannot be made.
        results = list(database.completed_work_items)
        return [one for one in results if one[1].worker_outcome is WorkerOutcome.NORMAL]


def notice() -> int:
    """Run the tests of the changed line: quick ones first, those of its own package first.

    A line without tests runs on import or in other processes: the tests of its file are run
    instead, but slow ones of its own package only, which holds nearly all that notice.
    """
    tests = json.loads(Path(COVERING).read_text(encoding="utf-8"))
    path, line = next(changed(Path()))
    of_file = {test for names in tests.get(path, {}).values() for test in names}
    own = f"tests/{package(Path(path))}/"
    of_line = tests.get(path, {}).get(str(line), [])
    quick = sorted(of_line or of_file, key=lambda test: (own not in test, test))
    slow = of_line or [test for test in quick if own in test]
    for mark, chosen in (("not slow", quick), ("slow", slow)) if quick else (("", ["tests"]),):
        command = [*PYTEST, "--hypothesis-seed=0", "-m", mark, *chosen]
        status = subprocess.run(command).returncode if chosen else 0
        if status not in (pytest.ExitCode.OK, pytest.ExitCode.NO_TESTS_COLLECTED):
            return status
    return 0


def package(module: Path) -> str:
    """Return the package of a module, or the module itself if it has none."""
    return module.relative_to(PACKAGE).parts[0]


def summary(found: Sequence[Tried]) -> Iterator[str]:
    """Count the noticed mutants of each package, and show the others as diffs."""
    packages = [package(Path(place(item)[0])) for item, _ in found]
    missed = Counter(p for p, one in zip(packages, found, strict=True) if survived(one))
    rows = [
        [name, str(count), str(count - missed[name])]
        for name, count in sorted(Counter(packages).items())
    ]
    total = ["all", str(len(found)), str(len(found) - missed.total())]
    yield markdown_table(["package", "mutants", "noticed"], [*rows, total])
    for _, result in filter(survived, found):
        lines = result.diff.splitlines()[2:]
        yield "\n```diff\n" + "\n".join(line for line in lines if line[:1] in "+-") + "\n```"


def survived(one: Tried) -> bool:
    """Whether no test noticed a mutant, or the tests could not be run."""
    return one[1].test_outcome is not TestOutcome.KILLED


def main() -> int:
    """Draw mutants, try them, and report the result."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--sample", type=int, default=300)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--since", metavar="REV", help="only in lines changed since a commit")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--record", action="store_true", help="write the record")
    options = parser.parse_args()
    folder = Path(tempfile.mkdtemp(prefix="mutants"))
    clones = [folder / str(number) for number in range(options.jobs)]
    for clone in clones:
        subprocess.run(["git", "clone", "-q", ROOT, clone], check=True)
    items = drawn(clones[0], options.sample, options.seed, options.since)
    tests = json.dumps(covering(clones[0]))
    for clone in clones:
        (clone / COVERING).write_text(tests, encoding="utf-8")
    with ThreadPoolExecutor(options.jobs) as pool:
        parts = [items[number :: options.jobs] for number in range(options.jobs)]
        found = [one for part in pool.map(tried, clones, parts) for one in part]
    shutil.rmtree(folder)
    found.sort(key=lambda one: place(one[0]))
    text = f"Seed {options.seed}:\n\n" + "\n".join(summary(found))
    print(text)
    if options.record:
        write_record("mutants", __doc__ or "", text)
    return 0 if found and sum(map(survived, found)) <= (1 - ENOUGH) * len(found) else 1


if __name__ == "__main__":
    sys.exit(notice())
