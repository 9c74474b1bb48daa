"""Do the tests notice small faults? Cosmic Ray puts one at a time into a clone of the last commit.

A mutant is one of those that validation/cosmic-ray.toml allows on a random line. It is tried with
the tests of its package and then with all others; those that no test noticed are shown. Exit status
1 if the tests fail without a fault, or notice fewer than 92 of 100.
"""

import argparse
import os
import random
import shutil
import subprocess
import sys
import tempfile
from collections import Counter, defaultdict
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from cosmic_ray.work_db import WorkDB, use_db
from cosmic_ray.work_item import TestOutcome, WorkItem, WorkResult

from validation.records import write_record
from vibrissa.wording import markdown_table

ROOT = Path(__file__).parents[1]
CONFIG, SESSION = "validation/cosmic-ray.toml", "session.sqlite"
PACKAGE = "src/vibrissa"
ENOUGH = 0.92
# Set where the tests of a mutant's package alone are asked.
OWN = "MUTANTS_OWN"
Tried = tuple[WorkItem, WorkResult]


def call(folder: Path, *command: str | Path) -> None:
    """Run a command in a clone, whose code and tests it imports; shows its mistakes alone."""
    paths = [str(Path(sys.executable).parent), os.environ["PATH"]]
    environment = os.environ | {
        "PATH": os.pathsep.join(paths),
        "PYTHONPATH": os.pathsep.join([str(folder / "src"), str(folder)]),
    }
    result = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True)
    if result.returncode:
        sys.exit(f"{' '.join(map(str, command))}:\n{result.stdout[-2000:]}{result.stderr[-2000:]}")


def cloned(folder: Path) -> Path:
    """Clone the last commit."""
    subprocess.run(["git", "clone", "-q", ROOT, folder], check=True)
    return folder


def drawn(clone: Path, sample: int, seed: int) -> list[WorkItem]:
    """Draw a mutant of each of some lines."""
    call(clone, "cosmic-ray", "init", CONFIG, SESSION)
    call(clone, "cr-filter-operators", SESSION, CONFIG)
    lines = defaultdict(list)
    with use_db(clone / SESSION, WorkDB.Mode.open) as database:
        for item in sorted(database.pending_work_items, key=place):
            path, (row, _), *_ = place(item)
            lines[path, row].append(item)
    draw = random.Random(seed)
    chosen = draw.sample(sorted(lines), min(sample, len(lines)))
    return [draw.choice(lines[line]) for line in chosen]


def place(item: WorkItem) -> tuple[str, tuple[int, int], str, int]:
    """Return what mutants are sorted by."""
    (one,) = item.mutations
    return str(one.module_path), one.start_pos, one.operator_name, one.occurrence


def tried(clone: Path, items: Sequence[WorkItem]) -> list[Tried]:
    """Try mutants one after the other in a clone."""
    with use_db(clone / SESSION, WorkDB.Mode.create) as database:
        database.clear()
        database.add_work_items(items)
        call(clone, "cosmic-ray", "exec", CONFIG, SESSION)
        return list(database.completed_work_items)


def notice() -> int:
    """Run in a clone: ask the tests of the changed module, of its package, and then all others."""
    command = ["git", "diff", "--name-only", PACKAGE]
    changed = [Path(path) for path in subprocess.check_output(command, text=True).splitlines()]
    asked: list[Path] = []
    for module in changed:
        name = package(module)
        asked += [*Path("tests", name).rglob(f"test_{module.stem}.py"), Path("tests", name)]
        asked += [Path("tests", f"test_{name}")]
    asked = [path for path in dict.fromkeys(asked) if path.exists()]
    asked += [] if asked and OWN in os.environ else [Path("tests")]
    options = ["-x", "-q", "-p", "no:benchmark", "-p", "no:cacheprovider", "--hypothesis-seed=0"]
    return subprocess.run([sys.executable, "-m", "pytest", *options, *asked]).returncode


def package(module: Path) -> str:
    """Name the package of a module, or the module itself."""
    return module.relative_to(PACKAGE).parts[0]


def baseline(clone: Path, items: Sequence[WorkItem]) -> None:
    """Ask the tests about the same modules with a comment more, which is a change, too."""
    for path in {place(item)[0] for item in items}:
        with (clone / path).open("a", encoding="utf-8") as file:
            file.write("# changed\n")
    call(clone, sys.executable, "-m", "validation.mutants")
    call(clone, "git", "checkout", "-q", PACKAGE)


def summary(found: Sequence[Tried]) -> Iterator[str]:
    """Count what was noticed of each package, and show what was not."""
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
    """Whether no test noticed a mutant."""
    return one[1].test_outcome is TestOutcome.SURVIVED


def main() -> int:
    """Draw mutants, try them, and say what became of them."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--sample", type=int, default=300)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--own", action="store_true", help="ask the tests of its package alone")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--record", action="store_true", help="write the record")
    options = parser.parse_args()
    if options.own:
        os.environ[OWN] = "1"
    folder = Path(tempfile.mkdtemp(prefix="mutants"))
    clones = [cloned(folder / str(number)) for number in range(options.jobs)]
    items = drawn(clones[0], options.sample, options.seed)
    baseline(clones[0], items)
    with ThreadPoolExecutor(options.jobs) as pool:
        parts = [items[number :: options.jobs] for number in range(options.jobs)]
        found = [one for part in pool.map(tried, clones, parts) for one in part]
    shutil.rmtree(folder)
    found.sort(key=lambda one: place(one[0]))
    text = f"Seed {options.seed}:\n\n" + "\n".join(summary(found))
    print(text)
    if options.record:
        write_record("mutants", __doc__ or "", text)
    return 1 if sum(map(survived, found)) > (1 - ENOUGH) * len(found) else 0


if __name__ == "__main__":
    sys.exit(notice())
