"""Do the tests notice small faults? Puts them into copies of the project, one at a time.

Usage: python -m mutation [--sample 600] [--seed 1] [--jobs 2] [--since main] [--package P ...]

Exit status 1 if too few are noticed: 92 in 100 of all, or 85 in 100 of a package.
"""

import argparse
import compileall
import json
import multiprocessing
import os
import py_compile
import queue
import re
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter, defaultdict
from concurrent.futures import ThreadPoolExecutor, as_completed
from contextlib import ExitStack, suppress
from dataclasses import asdict, dataclass
from enum import StrEnum
from pathlib import Path

from validation.mutation import asking, recording
from validation.mutation.mutants import Mutant, equivalents, mutants_of, sample
from validation.mutation.recording import PACKAGE, ROOT, Recording
from vibrissa.files import write_atomically
from vibrissa.wording import markdown_table

PAGE = ROOT / "validation/records/tests.md"
BEGIN, END = "<!-- made by make mutate -->\n", "<!-- end of what make mutate made -->"
RESULTS = ROOT / ".mutation/results.jsonl"
WANTED, WANTED_OF_PACKAGE = 0.92, 0.85
# Mutants of the whole program, and of lines that differ from a commit: an hour, and minutes; and
# how many at least are of each package.
SAMPLE, SAMPLE_SINCE = 600, 60
LEAST, LEAST_SINCE = 15, 1
# Seconds of processor time, as recorded, of the tests for one mutant; what the fastest of them do
# not notice counts as not noticed. Without the recording they take a third of that.
BUDGET = 120.0
# No test is given more seconds than this, on a quiet machine.
LONGEST = 180.0
# Libraries that the tests import, loaded once; each mutant's tests run in a fork of that process.
# Nothing of the package itself: it is to be imported from the copy.
PRELOADED = [
    "numpy",
    "scipy.integrate",
    "scipy.optimize",
    "scipy.linalg",
    "scipy.interpolate",
    "scipy.special",
    "pandas",
    "pyarrow.parquet",
    "pyarrow.dataset",
    "pydantic",
    "yaml",
    "pint",
    "typer.testing",
    "hypothesis.strategies",
    "matplotlib.pyplot",
    "jinja2",
    "pytest",
]


class Outcome(StrEnum):
    """What became of a mutant."""

    NOTICED = "noticed"
    TIMED_OUT = "timed out"
    SURVIVED = "survived"
    NOT_REACHED = "not reached"
    EQUIVALENT = "equivalent"


@dataclass(frozen=True, kw_only=True)
class Result:
    """One mutant, the lines that it changed, what became of it, and the test that noticed it."""

    mutant: Mutant
    old: str
    new: str
    outcome: Outcome
    test: str = ""
    seconds: float = 0.0


class Copy:
    """A copy of the project, in which one mutant after the other is tried."""

    def __init__(self, folder: Path) -> None:
        self.root = folder / "project"
        self.root.mkdir()
        recording.copied(self.root)
        # By content, not by time: a mutant of the same second and size must not be taken for old.
        checked = py_compile.PycInvalidationMode.CHECKED_HASH
        compileall.compile_dir(self.root / "src", quiet=2, invalidation_mode=checked)

    def ask(self, tests: list[str], seconds: dict[str, float]) -> asking.Answer:
        """Run tests in a process of their own until one fails."""
        # Where others work, too, a test is not slow because of the fault.
        busy = max(1.0, os.getloadavg()[0] / (os.cpu_count() or 1))
        limits = {test: busy * min(10.0 + 5.0 * seconds[test], LONGEST) for test in tests}
        context = multiprocessing.get_context("forkserver")
        receiver, sender = context.Pipe(duplex=False)
        process = context.Process(target=asking.ask, args=(self.root, limits, sender), daemon=True)
        process.start()
        sender.close()
        process.join()
        # What the tests started and left behind.
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        with suppress(EOFError):
            return receiver.recv()
        return asking.Answer(failed="", timed_out=process.exitcode == -signal.SIGALRM, broke=True)

    def try_out(self, mutant: Mutant, source: str, tests: list[str], times: dict[str, float]):
        """Ask tests about a mutant, and put the original back."""
        path = self.root / PACKAGE / mutant.module
        path.write_text(mutant.mutated(source), encoding="utf-8")
        try:
            return self.ask(tests, times)
        finally:
            path.write_text(source, encoding="utf-8")


def result(
    mutant: Mutant, source: str, recorded: Recording, copies: "queue.Queue[Copy]", known: dict
) -> Result:
    """Try a mutant in a copy that nobody uses meanwhile."""
    old, new = mutant.change(source)
    if (mutant.module, old, new) in known:
        return Result(mutant=mutant, old=old, new=new, outcome=Outcome.EQUIVALENT)
    tests = recorded.affordable(recorded.tests_of(mutant.module, mutant.line, source), BUDGET)
    if not tests:
        return Result(mutant=mutant, old=old, new=new, outcome=Outcome.NOT_REACHED)
    copy, begin = copies.get(), time.monotonic()
    try:
        answer = copy.try_out(mutant, source, tests, recorded.seconds)
    finally:
        copies.put(copy)
    if answer.timed_out:
        outcome = Outcome.TIMED_OUT
    elif answer.failed or answer.broke:
        outcome = Outcome.NOTICED
    else:
        outcome = Outcome.SURVIVED
    seconds = time.monotonic() - begin
    return Result(
        mutant=mutant, old=old, new=new, outcome=outcome, test=answer.failed, seconds=seconds
    )


def changed_lines(since: str) -> dict[str, set[int]]:
    """Return the lines of each module that differ from those of a commit; all of a new one."""
    lines, module = defaultdict(set), ""
    for name in _git("ls-files", "--others", "--exclude-standard", "--", PACKAGE).splitlines():
        count = len((ROOT / name).read_bytes().splitlines())
        lines[name.partition(PACKAGE)[2]].update(range(1, count + 1))
    diff = _git("diff", "--unified=0", "--no-color", "--relative", since, "--", PACKAGE)
    for line in diff.splitlines():
        if line.startswith("+++ "):
            module = line.partition(PACKAGE)[2]
        elif found := re.match(r"@@ -\S+ \+(\d+)(?:,(\d+))? @@", line):
            first, count = int(found[1]), int(found[2] or 1)
            lines[module].update(range(first, first + count))
    return lines


def _git(*arguments: str) -> str:
    """Return what git prints; where it refuses, as an unknown commit, end with its words."""
    result = subprocess.run(["git", *arguments], cwd=ROOT, capture_output=True, text=True)
    if result.returncode:
        sys.exit(f"git {arguments[0]}: {result.stderr.strip().splitlines()[0]}")
    return result.stdout


def up_to_date(jobs: int, again: bool) -> Recording:
    """Return the recording, with what new or changed files of tests reach."""
    recorded, digests = recording.read(), recording.digests()
    if again or recorded is None:
        print("Recording which test reaches which line: all tests run once, slowly.", flush=True)
        recorded = recording.record([], jobs)
    elif changed := [name for name, text in digests.items() if recorded.files.get(name) != text]:
        tests = [name for name in changed if Path(name).name.startswith("test_")]
        print("Recording again what has changed:", *tests, flush=True)
        recorded = recorded.updated(recording.record(tests, jobs), changed) if tests else recorded
    recording.write(recorded)
    if recorded.broken:
        print("Not asked, as they fail in a copy as it is:", *recorded.broken, sep="\n  ")
    return recorded


def run(chosen: list[Mutant], sources: dict[str, str], recorded: Recording, jobs: int):
    """Try mutants, print each result as it comes, and return them all."""
    known, results = equivalents(), []
    RESULTS.parent.mkdir(exist_ok=True)
    with ExitStack() as stack, RESULTS.open("w", encoding="utf-8") as file:
        copies: queue.Queue[Copy] = queue.Queue()
        for _ in range(jobs):
            folder = stack.enter_context(tempfile.TemporaryDirectory(prefix="vibrissa-mutant-"))
            copies.put(Copy(Path(folder)))
        pool = stack.enter_context(ThreadPoolExecutor(jobs))
        # An interrupted run does not wait for its tests.
        stack.callback(end_tests)
        stack.callback(pool.shutdown, wait=False, cancel_futures=True)
        futures = [
            pool.submit(result, mutant, sources[mutant.module], recorded, copies, known)
            for mutant in chosen
        ]
        for done in as_completed(futures):
            one = done.result()
            results.append(one)
            file.write(json.dumps(asdict(one)) + "\n")
            file.flush()
            report(one, results, len(chosen))
        suspects = refuted(
            sorted({one.test for one in results if one.test}), copies.get(), recorded
        )
    if suspects:
        print("These tests fail without a fault, too; what they noticed does not count:", *suspects)
    return [one for one in results if one.test not in suspects]


def end_tests() -> None:
    """End the processes in which tests are still run."""
    for process in multiprocessing.active_children():
        process.kill()


def refuted(tests: list[str], copy: Copy, recorded: Recording) -> set[str]:
    """Return those of the tests that noticed a mutant which fail without any, too."""
    found: set[str] = set()
    while tests:
        answer = copy.ask(tests, recorded.seconds)
        if not answer.failed:
            break
        found.add(answer.failed)
        tests = tests[tests.index(answer.failed) + 1 :]
    return found


def report(one: Result, results: list[Result], total: int) -> None:
    """Print one line for a mutant, and two more if nothing noticed it."""
    where = f"{one.mutant.module}:{one.mutant.line} {one.mutant.operator}"
    share = f"{100 * noticed_share(results):.0f} % noticed"
    print(
        f"[{len(results)}/{total}, {share}] {one.outcome}: {where} {one.seconds:.0f} s", flush=True
    )
    if one.outcome in (Outcome.SURVIVED, Outcome.NOT_REACHED):
        print(f"    - {one.old}\n    + {one.new}", flush=True)


def noticed_share(results: list[Result]) -> float:
    """Return the part of the mutants that the tests noticed, of those that can be noticed."""
    counts = Counter(one.outcome for one in results if one.outcome != Outcome.EQUIVALENT)
    return (counts[Outcome.NOTICED] + counts[Outcome.TIMED_OUT]) / max(counts.total(), 1)


def summary(results: list[Result]) -> tuple[str, bool]:
    """Return a table of the packages, and whether enough was noticed in each and in all."""
    packages: dict[str, list[Result]] = defaultdict(list)
    for one in results:
        packages[one.mutant.package].append(one)
    columns = ["package", "tried", *Outcome, "share"]
    rows, enough = [], noticed_share(results) >= WANTED
    for name, found in [*sorted(packages.items()), ("**all**", results)]:
        counts = Counter(one.outcome for one in found)
        share = noticed_share(found)
        enough &= share >= WANTED_OF_PACKAGE
        rows.append(
            [
                name,
                str(len(found)),
                *(str(counts[kind]) for kind in Outcome),
                f"{100 * share:.0f} %",
            ]
        )
    return markdown_table(columns, rows), enough


def written(table: str, seed: int) -> None:
    """Put the table into the docs."""
    before, _, rest = PAGE.read_text(encoding="utf-8").partition(BEGIN)
    with write_atomically(PAGE) as temporary:
        temporary.write_text(
            f"{before}{BEGIN}\nSeed {seed}:\n\n{table}\n\n{END}{rest.partition(END)[2]}", "utf-8"
        )


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument(
        "--sample",
        type=int,
        help=f"number of mutants: {SAMPLE}, or {SAMPLE_SINCE} of the lines that differ",
    )
    parser.add_argument("--seed", type=int, default=1, help="other seeds, other mutants")
    parser.add_argument("--jobs", type=int, default=2, help="tried at the same time")
    parser.add_argument("--since", help="only lines that differ from this commit")
    parser.add_argument("--package", action="append", help="only these packages or modules")
    parser.add_argument("--record", action="store_true", help="record again what tests reach")
    parser.add_argument("--docs", action="store_true", help=f"write the table into {PAGE.name}")
    arguments = parser.parse_args()
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    multiprocessing.get_context("forkserver").set_forkserver_preload(PRELOADED)
    sources = recording.sources()
    mutants = [mutant for name, text in sources.items() for mutant in mutants_of(name, text)]
    if arguments.since:
        lines = changed_lines(arguments.since)
        mutants = [mutant for mutant in mutants if mutant.line in lines.get(mutant.module, ())]
    if arguments.package:
        wanted = tuple(arguments.package)
        mutants = [mutant for mutant in mutants if mutant.module.startswith(wanted)]
        for name in wanted:
            if not any(module.startswith(name) for module in sources):
                parser.error(f"no such package or module: {name}")
    usual, least = (SAMPLE_SINCE, LEAST_SINCE) if arguments.since else (SAMPLE, LEAST)
    chosen = sample(mutants, sources, arguments.sample or usual, arguments.seed, least)
    print(f"{len(chosen)} of {len(mutants)} mutants, seed {arguments.seed}", flush=True)
    if not chosen:
        return 0
    recorded = up_to_date(arguments.jobs, arguments.record)
    results = run(chosen, sources, recorded, arguments.jobs)
    page, enough = summary(results)
    print(page)
    if arguments.docs and not arguments.package:
        written(page, arguments.seed)
    return 0 if enough else 1
