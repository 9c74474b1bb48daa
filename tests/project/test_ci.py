"""The composite action and the CI of this repository: their steps, run in a shell."""

import re
import subprocess
import sys
from pathlib import Path

import yaml

ROOT = Path(__file__).parents[2]
ACTION = yaml.safe_load((ROOT / "action.yml").read_text())
JOBS = yaml.safe_load((ROOT / ".github/workflows/ci.yml").read_text())["jobs"]


def test_only_steps_without_expressions_are_given_to_the_shell():
    for step in ACTION["runs"]["steps"]:
        assert "${{" not in step.get("run", "")


def test_every_job_has_a_limit_and_each_part_of_the_one_script_has_a_job():
    script = (ROOT / ".ci/run").read_text()
    parts = {
        name
        for names in re.findall(r"^ +([\w| ]+)\) ", script, re.M)
        for name in names.split(" | ")
    }
    named = []
    for name in ("ci", "docs", "nightly"):
        workflow = yaml.safe_load((ROOT / f".github/workflows/{name}.yml").read_text())
        for job in workflow["jobs"].values():
            assert job["timeout-minutes"] <= 60
            for step in job["steps"]:
                for command in re.findall(r"\.ci/run ([\w ]+)", step.get("run", "")):
                    named += command.split()
    assert set(named) == parts - {"push", "night", "check"}
    assert [step["uses"] for step in JOBS["check"]["steps"]] == ["actions/checkout@v4", "./"]


def test_a_part_that_does_not_exist_is_refused():
    result = subprocess.run([ROOT / ".ci/run", "reports"], capture_output=True, text=True)
    assert result.returncode == 2
    assert result.stderr.startswith("no such part: reports; there are: push, night, lint")


def test_of_a_report_the_skipped_tests_are_told_as_pytest_takes_them(tmp_path):
    """Of a module that is skipped as a whole the report has the name alone."""
    cases = [
        ("tests.explorer.test_page.TestPage", "test_b[a b::c]", "<skipped/>"),
        ("tests.explorer.test_page", "test_a", "<skipped/>"),
        ("", "tests.test_files", "<skipped/>"),
        ("tests.test_files", "test_c", ""),
    ]
    lines = [
        f'<testcase classname="{module}" name="{name}">{skipped}</testcase>'
        for module, name, skipped in cases
    ]
    (tmp_path / "report.xml").write_text(f"<testsuite>{''.join(lines)}</testsuite>")
    command = [sys.executable, ".ci/skips.py", "--tests", tmp_path / "report.xml"]
    told = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout
    assert told.splitlines() == [
        "tests/explorer/test_page.py::TestPage::test_b[a b::c]",
        "tests/explorer/test_page.py::test_a",
        "tests/test_files.py",
    ]


def test_the_workflow_in_the_docs_gives_the_action_what_it_takes():
    (text,) = re.findall(r"```yaml\n(name: .*?)```", (ROOT / "docs/ci.md").read_text(), re.DOTALL)
    _, step = yaml.safe_load(text)["jobs"]["check"]["steps"]
    assert set(step["with"]) <= set(ACTION["inputs"])
