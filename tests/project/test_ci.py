"""The composite action and the CI of this repository: their steps, run in a shell."""

import re
import subprocess
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).parents[2]
ACTION = yaml.safe_load((ROOT / "action.yml").read_text())
JOBS = yaml.safe_load((ROOT / ".github/workflows/ci.yml").read_text())["jobs"]


def test_only_steps_without_expressions_are_given_to_the_shell():
    for step in ACTION["runs"]["steps"]:
        assert "${{" not in step.get("run", "")


def test_every_job_has_a_limit_and_names_a_part_of_the_one_script():
    parts = re.findall(r"^ +([\w]+)\) ", (ROOT / ".ci/run").read_text(), re.MULTILINE)
    documentation = yaml.safe_load((ROOT / ".github/workflows/docs.yml").read_text())["jobs"]
    named = []
    for job in (*JOBS.values(), *documentation.values()):
        assert job["timeout-minutes"] <= 60
        for step in job["steps"]:
            named += re.findall(r"\.ci/run (\w+)", step.get("run", ""))
    assert set(named) | {"rest"} == set(parts) - {"all", "check"}
    assert [step["uses"] for step in JOBS["check"]["steps"]] == ["actions/checkout@v4", "./"]


def test_a_part_that_does_not_exist_is_refused():
    result = subprocess.run([ROOT / ".ci/run", "reports"], capture_output=True, text=True)
    assert result.returncode == 2
    assert result.stderr.startswith("no such part: reports; there are: bare, rest, slurm, study")


@pytest.mark.parametrize("page", ["docs/ci.md"])
def test_the_workflow_in_the_docs_gives_the_action_what_it_takes(page):
    texts = re.findall(r"```yaml\n(.*?)```", (ROOT / page).read_text(), re.DOTALL)
    (text,) = [text for text in texts if "OWNER/vibrissa" in text]
    steps = yaml.safe_load(text)["jobs"]["check"]["steps"]
    assert set(steps[1]["with"]) <= set(ACTION["inputs"])
    assert len(text.partition("steps:\n")[2].splitlines()) == 5
