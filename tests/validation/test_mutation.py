"""Faults that are put into the code, and which tests are asked about them."""

import ast
import json
import subprocess
import tomllib
from collections import Counter
from dataclasses import replace

import coverage
import pytest
from cosmic_ray.mutating import mutate_code

from validation.mutation import mutants, recording, run
from validation.mutation.operators import CatchNothing, DropCall, DropCondition, SwapNeighbours
from validation.mutation.recording import Recording

SOURCES = recording.sources()
TEXT = """\
import numpy as np

LIMIT = 3


def far(x: float | None, y: int = 2) -> int | None:
    if x is not None and abs(
        x
    ) > LIMIT:
        return f(x, y)
    return None
"""


def changes(text):
    return {one.change(text) for one in mutants.mutants_of("m.py", text)}


@pytest.mark.parametrize("operator", [CatchNothing, DropCall, DropCondition, SwapNeighbours])
def test_own_operators_do_what_they_say(operator):
    for example in operator.examples():
        code = example.pre_mutation_code
        assert mutate_code(code, operator(), example.occurrence) == example.post_mutation_code


def test_faults_of_a_text():
    found = changes(TEXT)
    assert ("LIMIT = 3", "LIMIT = 4") in found
    assert ("return f(x, y)", "return f(y, x)") in found
    assert (") > LIMIT:", ") >= LIMIT:") in found
    assert any(new.startswith("if abs(") for _, new in found)
    # Types are not run.
    assert not any("float" in old and "&" in new for old, new in found)
    assert not any(
        "-> int" in old and "y: int = 3" not in new and "y: int = 1" not in new
        for old, new in found
        if old.startswith("def")
    )


@pytest.mark.parametrize(
    ("number", "faults"), [("999", 2), ("1_000", 0), ("2e3", 0), ("0o755", 2), ("0x7F", 2)]
)
def test_numbers_are_changed_unless_they_are_large(number, faults):
    assert len({new for _, new in changes(f"a = {number}")}) == faults


def test_guards_are_left_alone():
    assert not changes("f(x=zip(a, b, strict=True))\n") - {
        ("f(x=zip(a, b, strict=True))", "f(x=zip(b, a, strict=True))")
    }


def test_a_sample_has_something_of_each_package_and_is_the_same_each_time():
    some = {n: text for n, text in SOURCES.items() if n.startswith(("numerics/steps", "wording"))}
    found = [one for name, text in some.items() for one in mutants.mutants_of(name, text)]
    drawn = mutants.sample(found, SOURCES, 20, seed=1, least=2)
    assert drawn == mutants.sample(found, SOURCES, 20, seed=1, least=2)
    assert drawn != mutants.sample(found, SOURCES, 20, seed=2, least=2)
    counts, all_counts = (Counter(one.package for one in some) for some in (drawn, found))
    assert counts.keys() == all_counts.keys()
    for package, count in counts.items():
        assert count == max(2, round(20 * all_counts[package] / len(found)))


@pytest.mark.parametrize(
    ("line", "span", "in_function"),
    [(3, (3, 3), False), (6, (6, 6), False), (8, (7, 9), True), (10, (10, 10), True)],
)
def test_statement_at_a_line(line, span, in_function):
    assert ast.parse(TEXT)
    found, inside = recording.statement(TEXT, line, recording.at_import(TEXT))
    assert ((found.start, found.stop - 1), inside) == (span, in_function)


def recorded(**given):
    return Recording(
        **{
            "seconds": {"tests/a/test_a.py::slow": 20.0, "tests/b/test_b.py::fast": 0.01,
                        "tests/a/test_a.py::fast": 0.05},
            "effort": {
                "tests/a/test_a.py::slow": 20.0,
                "tests/b/test_b.py::fast": 0.01,
                "tests/a/test_a.py::fast": 0.05,
            },
            "reached": {"a/m.py": {7: [0], 10: [1, 0], 11: [2]}},
            "sources": {"a/m.py": TEXT},
            "files": {},
            "broken": [],
        }
        | given
    )  # fmt: skip


def test_tests_that_reach_a_line_the_fast_ones_first():
    found = recorded().tests_of("a/m.py", 10, TEXT)
    assert found == ["tests/b/test_b.py::fast", "tests/a/test_a.py::slow"]
    # A line of a statement over several lines, in a text that has one line more by now.
    assert recorded().tests_of("a/m.py", 9, "\n" + TEXT) == ["tests/a/test_a.py::slow"]


def test_constants_are_asked_of_all_tests_of_the_module():
    assert recorded().tests_of("a/m.py", 3, TEXT) == [
        "tests/a/test_a.py::fast", "tests/b/test_b.py::fast", "tests/a/test_a.py::slow",
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("more", "inside"),
    [
        ("", True),
        ("def h():\n    f(1)\n", True),
        ("a = [f(1)]\n", False),
        ("class A:\n    a = f(1)\n", False),
        ("@f\ndef h():\n    pass\n", False),
        ("def h(a=f(1)):\n    pass\n", False),
        ("def h(a: Annotated[int, f(1)]):\n    pass\n", False),
    ],
)
def test_functions_that_a_module_uses_itself_are_run_when_it_is_imported(more, inside):
    text = "def f(x):\n    y = x\n    def g():\n        return y\n    return g\n\n"
    used = recording.at_import(text + more)
    assert recording.statement(text + more, 2, used)[1] is inside
    assert recording.statement(text + more, 4, used)[1]


def test_a_decorator_of_another_module_is_asked_of_all_tests_of_its_module():
    found = recorded().tests_of("a/m.py", 11, TEXT)
    assert found == ["tests/a/test_a.py::fast"]
    other = "@far\ndef h():\n    pass\n"
    after = recorded(sources={"a/m.py": TEXT, "a/other.py": other})
    assert set(after.tests_of("a/m.py", 11, TEXT)) == set(after.tests)
    # What surely reaches the line comes first, unless it takes long.
    other, slow = (f"tests/a/test_a.py::{name}" for name in ("fast", "slow"))
    fast = "tests/b/test_b.py::fast"
    assert after.tests_of("a/m.py", 10, TEXT) == [fast, slow, other]
    long = replace(after, effort=after.effort | {slow: recording.SURE})
    assert long.tests_of("a/m.py", 10, TEXT) == [fast, other, slow]


def test_lines_newer_than_the_recording_are_asked_of_all_tests_of_the_module_or_package():
    newer = TEXT.replace("    return None", "    y = 3\n    return None")
    assert set(recorded().tests_of("a/m.py", 11, newer)) == set(recorded().tests)
    assert recorded().tests_of("a/m.py", 12, newer) == ["tests/a/test_a.py::fast"]
    assert recorded().tests_of("a/new.py", 10, TEXT) == [
        "tests/a/test_a.py::fast", "tests/a/test_a.py::slow",
    ]  # fmt: skip


def stored(made, folder, monkeypatch):
    monkeypatch.setattr(recording, "RECORDING", folder / "new/recording.json")
    assert recording.read() is None
    recording.write(made)
    return recording.read()


def test_a_changed_file_of_tests_is_recorded_anew(tmp_path, monkeypatch):
    newer = recorded(
        seconds={"tests/a/test_a.py::new": 1.0},
        effort={"tests/a/test_a.py::new": 1.0},
        reached={"a/m.py": {11: [0]}},
        sources={"a/m.py": "\n" + TEXT},
    )
    merged = recorded().updated(newer, ["tests/a/test_a.py"])
    assert merged == stored(merged, tmp_path, monkeypatch)
    assert set(merged.tests) == {"tests/b/test_b.py::fast", "tests/a/test_a.py::new"}
    assert set(merged.tests_of("a/m.py", 11, "\n" + TEXT)) == set(merged.tests)
    # No test reaches this line any more; others of the module may do so in another way.
    assert set(merged.tests_of("a/m.py", 8, "\n" + TEXT)) == set(merged.tests)


def test_what_kills_runs_or_brings_up_a_cluster_is_never_asked():
    with (recording.ROOT / "pyproject.toml").open("rb") as file:
        apart = tomllib.load(file)["tool"]["pytest"]["ini_options"]["norecursedirs"]
    assert recording.APART < set(apart)
    asked = recording.digests()
    assert "tests/validation/test_mutation.py" in asked
    assert not [name for name in asked if "test_slurm.py" in name and "pipeline" not in name]
    assert not [name for name in asked if "faults" in name]


@pytest.mark.parametrize(
    ("file", "changed"),
    [
        ("test_a.py", {"test_a.py"}),
        ("a.yaml", {"test_a.py"}),
        ("inputs.yaml", {"test_b.py"}),
        ("other.yaml", set()),
    ],
)
def test_cases_in_a_file_beside_a_test_are_a_part_of_it(file, changed, tmp_path):
    folder = tmp_path / "tests/x"
    folder.mkdir(parents=True)
    (folder / "test_a.py").write_text("KNOWN = Known(__file__)")
    (folder / "test_b.py").write_text('open("inputs.yaml")')
    for name in ("a.yaml", "inputs.yaml", "other.yaml"):
        (folder / name).write_text("case: 1")
    before = recording.digests(tmp_path)
    (folder / file).write_text("case: 2")
    after = recording.digests(tmp_path)
    assert {name for name in before if after[name] != before[name]} == {
        f"tests/x/{name}" for name in changed
    }


@pytest.fixture
def checkout(tmp_path, monkeypatch):
    """Make a small project of two commits' worth of changes."""
    folder = tmp_path / "src/vibrissa/a"
    folder.mkdir(parents=True)
    (folder / "old.py").write_text("one = 1\ntwo = 2\nthree = 3\n")
    (folder / "gone.py").write_text("gone = 1\n")

    def git(*arguments):
        who = ("-c", "user.name=a", "-c", "user.email=a@b.c")
        subprocess.run(["git", *who, *arguments], cwd=tmp_path, check=True, capture_output=True)

    git("init", "-q")
    git("add", ".")
    git("commit", "-qm", "first")
    monkeypatch.setattr(run, "ROOT", tmp_path)
    return folder


def test_only_lines_that_differ_are_changed_and_all_of_a_new_module(checkout):
    assert run.changed_lines("HEAD") == {}
    (checkout / "old.py").write_text("one = 1\ntwo = 4\nthree = 3\nfour = 4\nfive = 5\n")
    (checkout / "gone.py").unlink()
    (checkout / "new.py").write_text("one = 1\n\ntwo = 2\n")
    (checkout / "notes.txt").write_text("no module\n")
    lines = run.changed_lines("HEAD")
    assert {name: lines[name] for name in ("a/old.py", "a/new.py")} == {
        "a/old.py": {2, 4, 5},
        "a/new.py": {1, 2, 3},
    }


def test_an_unknown_commit_is_refused_in_the_words_of_git(checkout):
    with pytest.raises(SystemExit, match=r"git diff: fatal: .*nowhere"):
        run.changed_lines("nowhere")


def test_a_fixture_that_tests_share_is_paid_for_once():
    """Else a table of forty rows, each a test of its own, would be asked for five rows."""
    tests = ["dear", "cheap", "alone", "late"]
    one = recorded(
        effort={"dear": 10.1, "cheap": 10.2, "alone": 3.0, "late": 1.0},
        shared={"dear": ["f"], "cheap": ["f"]},
        fixtures={"f": 10.0},
    )
    assert one.affordable(tests, 14.3 + 1e-9) == tests
    assert one.affordable(tests, 14.2) == tests[:3]
    assert one.affordable(tests, 10.2) == tests[:1]
    assert one.affordable(tests, 1.0) == tests[:1]


def test_a_recording_says_what_each_test_shares(tmp_path, monkeypatch):
    lines = [
        {"fixture": "f", "seconds": 2.0, "effort": 3.0},
        *(
            {"test": test, "outcome": "passed", "seconds": 1.0, "effort": 0.5, "fixtures": needs}
            for test, needs in {"a": ["f", "free"], "b": []}.items()
        ),
    ]
    (tmp_path / "1.jsonl").write_text("".join(json.dumps(line) + "\n" for line in lines))
    data = coverage.CoverageData(basename=str(tmp_path / "coverage.1"))
    data.set_context("f")
    data.add_lines({f"{tmp_path}/src/vibrissa/wording.py": [7]})
    data.write()
    found = recording.merged(tmp_path, tmp_path)
    assert found.effort == {"a": 3.5, "b": 0.5} and found.seconds == {"a": 3.0, "b": 1.0}
    assert found.shared == {"a": ["f"], "b": []} and found.fixtures == {"f": 3.0}
    assert found.reached == {"wording.py": {7: [0]}}


def test_a_recording_that_reached_nothing_is_refused(tmp_path):
    entry = {"test": "t", "outcome": "passed", "seconds": 1.0, "effort": 1.0, "fixtures": []}
    (tmp_path / "1.jsonl").write_text(json.dumps(entry) + "\n")
    with pytest.raises(SystemExit, match="coverage did not start"):
        recording.merged(tmp_path, tmp_path)
