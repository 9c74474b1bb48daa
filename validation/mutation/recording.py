"""Which tests reach which lines, and how long they take: recorded once, and read again."""

import ast
import difflib
import hashlib
import json
import os
import shutil
import subprocess
import sys
import tempfile
from collections import defaultdict
from collections.abc import Set
from dataclasses import asdict, dataclass, field
from functools import cache, cached_property
from pathlib import Path

from coverage import CoverageData

from validation.mutation import recorder
from vibrissa.files import write_atomically

ROOT = Path(__file__).parents[2]
RECORDING = ROOT / ".mutation/recording.json"
PACKAGE = "src/vibrissa/"
# Tests that nobody runs without naming them (norecursedirs in pyproject.toml): no mutant is asked.
APART = frozenset({"slurm", "faults"})
# Seconds of processor time that part fast tests from slower ones, as recorded.
SPEEDS = (0.1, 1.0, 10.0)
# Seconds of the tests that surely reach a line which others may reach, too.
SURE = 30.0
# Read by every Python process that a test starts: the package coverage brings a .pth file for that.
SETTINGS = """\
[run]
branch = false
parallel = true
sigterm = true
data_file = {folder}/coverage
context = ${{MUTATION_CONTEXT-}}
include = */src/vibrissa/*
disable_warnings = no-data-collected, module-not-imported
"""


def copied(root: Path) -> None:
    """Copy what git has or would add, so that the checkout itself is never changed."""
    listed = ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
    names = subprocess.run(listed, cwd=ROOT, capture_output=True, text=True, check=True).stdout
    for name in filter(None, names.split("\0")):
        if (ROOT / name).is_symlink() or (ROOT / name).is_file():
            (root / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / name, root / name, follow_symlinks=False)


def environment(root: Path) -> dict[str, str]:
    """Return the variables of a process that shall run the code of a copy."""
    return os.environ | {
        "PYTHONPATH": os.pathsep.join([str(root / "src"), str(root / "validation")]),
    }


@dataclass(frozen=True, kw_only=True)
class Recording:
    """Which tests reach which lines of the package.

    Attributes
    ----------
    seconds
        How long each test took when it was recorded, with the fixtures that it shares.
    effort
        The same in seconds of processor time: which tests are asked first.
    reached
        For each module and line the numbers of the tests, as `seconds` lists them.
    sources
        The text of each module, as it was.
    files
        A digest of each file of tests with its cases, as it was.
    broken
        Tests that fail in a copy as it is; they are not asked.
    shared
        The fixtures that each test shares with others, by their names.
    fixtures
        The effort of these, which is in `effort` of each test that needs them.

    """

    seconds: dict[str, float]
    effort: dict[str, float]
    reached: dict[str, dict[int, list[int]]]
    sources: dict[str, str]
    files: dict[str, str]
    broken: list[str]
    shared: dict[str, list[str]] = field(default_factory=dict)
    fixtures: dict[str, float] = field(default_factory=dict)

    @cached_property
    def tests(self) -> list[str]:
        return list(self.seconds)

    def updated(self, newer: "Recording", files: list[str]) -> "Recording":
        """Return this recording with the tests of some files as a newer one has them."""
        kept = [test for test in self.tests if test.partition("::")[0] not in files]
        seconds = {test: self.seconds[test] for test in kept} | newer.seconds
        effort = {test: self.effort[test] for test in kept} | newer.effort
        number = {test: place for place, test in enumerate(seconds)}
        reached: dict[str, dict[int, set[int]]] = defaultdict(lambda: defaultdict(set))
        for recorded in (self, newer):
            for module, lines in recorded.reached.items():
                for line, tests in lines.items():
                    # Lines are counted as in the newer text.
                    at = line if recorded is newer else self.line_now(newer, module, line)
                    names = (recorded.tests[test] for test in tests)
                    reached[module][at].update(number[name] for name in names if name in number)
        return Recording(
            seconds=seconds,
            effort=effort,
            reached=listed(reached),
            sources=newer.sources,
            files=newer.files,
            broken=sorted({*newer.broken, *self.broken} - newer.seconds.keys()),
            shared={test: self.shared.get(test, []) for test in kept} | newer.shared,
            fixtures=self.fixtures | newer.fixtures,
        )

    @cached_property
    def used_at_import(self) -> set[str]:
        """Names that some module uses outside of functions, as it does a decorator of another."""
        return set().union(*map(at_import, self.sources.values()))

    def affordable(self, tests: list[str], budget: float) -> list[str]:
        """Return the first tests that together take no longer than a budget, one at least.

        A fixture that several of them share is made once.
        """
        spent, chosen, made = 0.0, [], set[str]()
        for test in tests:
            shared = self.shared.get(test, [])
            spent += self.effort[test] - sum(self.fixtures[name] for name in made & set(shared))
            if chosen and spent > budget:
                break
            chosen.append(test)
            made.update(shared)
        return chosen

    def line_now(self, newer: "Recording", module: str, line: int) -> int:
        """Return the line of a newer text that is a line of this one, or lies next to it."""
        return newer.recorded_line(module, line, self.sources.get(module, ""))

    def recorded_line(self, module: str, line: int, text: str) -> int:
        """Return the line of the recorded module that is now this line, or lies next to it."""
        nearest = line
        for block in matching(self.sources.get(module, ""), text):
            if block.size and block.b < line:
                nearest = block.a + min(line - block.b, block.size)
        return nearest

    def knows(self, module: str, line: int, text: str) -> bool:
        """Whether a line was there when the tests were recorded."""
        blocks = matching(self.sources.get(module, ""), text)
        return any(block.b < line <= block.b + block.size for block in blocks)

    def tests_of(self, module: str, line: int, text: str) -> list[str]:
        """Return the tests that reach a line, in the order in which they are asked.

        What runs when a module is imported (constants, tables, classes, decorators) is reached by
        every test that reaches a function of the module, and maybe by others of the package. The
        same is assumed of lines that are newer than the recording, or that no test reached in it.
        """
        lines = self.reached.get(module, {})
        span, in_function = statement(text, line, at_import(text) | self.used_at_import)
        folder = f"tests/{module.rpartition('/')[0].partition('/')[0]}"
        recorded = [self.recorded_line(module, at, text) for at in span]
        reach = set().union(*(lines.get(at, ()) for at in recorded))
        sure = self.ordered([self.tests[n] for n in reach], folder)
        if in_function and reach and self.knows(module, line, text):
            return sure
        near = (n for n, test in enumerate(self.tests) if test.startswith(folder))
        others = self.ordered([self.tests[n] for n in reach.union(*lines.values(), near)], folder)
        # Names may collide, so what surely reaches the line comes first; but of what does so as it
        # imports the module, the slow ones are left to the end.
        return list(dict.fromkeys([*self.affordable(sure, SURE), *others]))

    def ordered(self, tests: list[str], folder: str) -> list[str]:
        """Return fast tests before slow ones, and among these those of the package first.

        Tests of about the same time come file by file, as those of a file share fixtures.
        """
        costs = {test: sum(self.effort[test] > limit for limit in SPEEDS) for test in tests}
        fastest: dict[tuple[int, str], float] = {}
        for test, cost in costs.items():
            key = cost, test.partition("::")[0]
            fastest[key] = min(self.effort[test], fastest.get(key, self.effort[test]))

        def place(test: str) -> tuple[int, bool, float, str, float]:
            file, cost = test.partition("::")[0], costs[test]
            outside = not file.startswith(folder)
            return cost, outside, fastest[cost, file], file, self.effort[test]

        return sorted(tests, key=place)


@cache
def matching(old: str, new: str) -> list[difflib.Match]:
    """Return which lines of two texts are the same."""
    matcher = difflib.SequenceMatcher(None, old.splitlines(), new.splitlines(), autojunk=False)
    return matcher.get_matching_blocks()


def statement(text: str, line: int, used_at_import: Set[str]) -> tuple[range, bool]:
    """Return the lines of the statement (without its body) at a line; is it within a function?

    Not within one that is used at import: that runs when a module is imported.
    """
    span, in_function = range(line, line + 1), False
    node: ast.AST = ast.parse(text)
    while True:
        inside = [
            child
            for child in ast.walk(node)
            if child is not node
            and isinstance(child, ast.stmt | ast.excepthandler)
            and child.lineno <= line <= (child.end_lineno or 0)
        ]
        if not inside:
            return span, in_function
        outer = min(inside, key=lambda child: (child.lineno, -(child.end_lineno or 0)))
        body = getattr(outer, "body", None)
        last = body[0].lineno - 1 if body else outer.end_lineno
        span = range(outer.lineno, max(outer.lineno, last or 0) + 1)
        if line < (body[0].lineno if body else 0):
            return span, in_function
        in_function |= isinstance(outer, ast.FunctionDef) and outer.name not in used_at_import
        node = outer


@cache
def at_import(text: str) -> set[str]:
    """Return the names that a module uses outside of the bodies of functions."""
    names: set[str] = set()
    nodes: list[ast.AST] = [ast.parse(text)]
    while nodes:
        node = nodes.pop()
        if isinstance(node, ast.Name):
            names.add(node.id)
        if isinstance(node, ast.FunctionDef):
            # Defaults and annotations are in the arguments.
            nodes += [*node.decorator_list, node.args]
        else:
            nodes += ast.iter_child_nodes(node)
    return names


def digests(root: Path = ROOT) -> dict[str, str]:
    """Return a digest of each Python file of the tests that may be asked, with its cases."""
    paths = sorted((root / "tests").rglob("*.py"))
    return {
        path.relative_to(root).as_posix(): digest(path)
        for path in paths
        if APART.isdisjoint(path.relative_to(root).parts)
    }


def digest(path: Path) -> str:
    """Return a digest of a file of tests and of the YAML beside it: of its name, or named in it."""
    text = path.read_bytes()
    own = f"{path.stem.removeprefix('test_')}.yaml"
    cases = [
        file.read_bytes()
        for file in sorted(path.parent.glob("*.yaml"))
        if file.name == own or file.name.encode() in text
    ]
    return hashlib.sha256(b"".join([text, *cases])).hexdigest()


def sources(root: Path = ROOT) -> dict[str, str]:
    """Return the text of each module of the package by its path within the package."""
    folder = root / PACKAGE
    paths = sorted(folder.rglob("*.py"))
    return {path.relative_to(folder).as_posix(): path.read_text("utf-8") for path in paths}


def record(tests: list[str], jobs: int) -> Recording:
    """Run tests (all of them: no names) in a copy, and find out what each of them reaches."""
    with tempfile.TemporaryDirectory(prefix="vibrissa-recording-") as folder:
        root, data = Path(folder, "project"), Path(folder, "data")
        data.mkdir()
        copied(root)
        settings = Path(folder, "coveragerc")
        settings.write_text(SETTINGS.format(folder=data), encoding="utf-8")
        pytest = [
            sys.executable,
            "-m",
            "pytest",
            "-q",
            "-p",
            "no:benchmark",
            "-p",
            "no:cacheprovider",
        ]
        subprocess.run(
            [*pytest, "-p", recorder.__name__, "-n", str(jobs), "--dist", "worksteal", *tests],
            cwd=root,
            env=environment(root)
            | {"COVERAGE_PROCESS_START": str(settings), recorder.FOLDER: str(data)},
        )
        return merged(data, root)


def merged(folder: Path, root: Path) -> Recording:
    """Put together what the processes of a recording have written about a copy."""
    entries = [
        json.loads(line)
        for path in folder.glob("*.jsonl")
        for line in path.read_text("utf-8").splitlines()
    ]
    fixtures = {entry["fixture"]: entry for entry in entries if "fixture" in entry}
    runs = [entry for entry in entries if "test" in entry]
    broken = {run["test"] for run in runs if run["outcome"] == "failed"}
    runs = [run for run in runs if run["outcome"] == "passed" and run["test"] not in broken]
    users = defaultdict(list)
    for number, run in enumerate(runs):
        for name in [run["test"], *run["fixtures"]]:
            users[name].append(number)
    reached: dict[str, dict[int, set[int]]] = defaultdict(lambda: defaultdict(set))
    for path in folder.glob("coverage.*"):
        data = CoverageData(basename=str(path))
        data.read()
        for file in data.measured_files():
            # The checkout's own code, which a test may run on purpose, is never mutated.
            if file.startswith(f"{ROOT}/") or not file.endswith(".py"):
                continue
            module = file.rpartition(PACKAGE)[2]
            for line, contexts in data.contexts_by_lineno(file).items():
                for context in filter(None, contexts):
                    reached[module][line].update(users.get(context, ()))
    if runs and not reached:
        sys.exit("coverage did not start in the processes of the tests: make setup installs it")
    seconds, effort = (
        {
            run["test"]: run[kind]
            + sum(fixtures[name][kind] for name in run["fixtures"] if name in fixtures)
            for run in runs
        }
        for kind in ("seconds", "effort")
    )
    return Recording(
        seconds=seconds,
        effort=effort,
        reached=listed(reached),
        sources=sources(root),
        files=digests(root),
        broken=sorted(broken),
        shared={
            run["test"]: [name for name in run["fixtures"] if name in fixtures] for run in runs
        },
        fixtures={name: entry["effort"] for name, entry in fixtures.items()},
    )


def listed(reached: dict[str, dict[int, set[int]]]) -> dict[str, dict[int, list[int]]]:
    """Return sets of tests as lists, as they are stored, without lines that no test reaches."""
    return {
        module: {line: sorted(tests) for line, tests in lines.items() if tests}
        for module, lines in reached.items()
    }


def read() -> Recording | None:
    if not RECORDING.exists():
        return None
    stored = json.loads(RECORDING.read_text("utf-8"))
    stored["reached"] = {
        module: {int(line): tests for line, tests in lines.items()}
        for module, lines in stored["reached"].items()
    }
    return Recording(**stored)


def write(recording: Recording) -> None:
    RECORDING.parent.mkdir(exist_ok=True)
    with write_atomically(RECORDING) as temporary:
        temporary.write_text(json.dumps(asdict(recording)), "utf-8")
