"""The composite action: its steps, run in a shell."""

import json
import os
import re
import shutil
import subprocess
import sys
import venv

import pytest
import yaml

from runs import ROOT

ACTION = yaml.safe_load((ROOT / "action.yml").read_text())
STUDY = """
study: whisker
grids:
  main: {theta: [2], mu0: [0.3, 5], eta: [0.85], dx0: [0.005]}
"""


class Runner:
    """What GitHub gives to the steps of an action, as far as they use it."""

    def __init__(self, folder):
        self.action, self.workspace = folder / "the action", folder / "their repository"
        self.summary = folder / "summary.md"
        self.action.mkdir()
        for name in ("src", "workflow"):
            ignored = shutil.ignore_patterns("__pycache__")
            shutil.copytree(ROOT / name, self.action / name, ignore=ignored)
        for name in ("Snakefile", "config.yaml", "Makefile", "pyproject.toml"):
            shutil.copy(ROOT / name, self.action)
        shutil.copytree(ROOT / "locks", self.action / "locks")
        self._install()
        self.workspace.mkdir()
        (self.workspace / "whisker.yaml").write_text(STUDY)

    def _install(self):
        """Make what `make setup` would make, of the packages that are here."""
        venv.create(self.action / ".venv")
        (packages,) = self.action.glob(".venv/lib/*/site-packages")
        paths = [str(self.action / "src"), *(p for p in sys.path if p.endswith("site-packages"))]
        (packages / "all.pth").write_text("\n".join(paths))
        (self.action / ".venv/.study").write_text(f"{self.action}\n")

    def step(self, name, **inputs):
        """Run a step as GitHub's bash does."""
        (step,) = [step for step in ACTION["runs"]["steps"] if step.get("name") == name]
        given = {key: value["default"] for key, value in ACTION["inputs"].items()} | inputs
        assert step["shell"] == "bash"
        environment = os.environ | {
            "GITHUB_ACTION_PATH": str(self.action),
            "GITHUB_WORKSPACE": str(self.workspace),
            "GITHUB_STEP_SUMMARY": str(self.summary),
            "GITHUB_ACTIONS": "true",
        }
        for key, value in step["env"].items():
            (found,) = re.fullmatch(r"\$\{\{ inputs\.(\S+) \}\}", value).groups()
            environment[key] = given[found]
        command = ["bash", "--noprofile", "--norc", "-eo", "pipefail", "-c", step["run"]]
        return subprocess.run(
            command, cwd=self.workspace, env=environment, capture_output=True, text=True
        )


@pytest.mark.slow
def test_another_repository_runs_and_checks_its_study(tmp_path):
    runner = Runner(tmp_path)
    inputs = {"study": "whisker.yaml", "reference": "reference"}
    ran = runner.step("Run the study", **inputs)
    assert ran.returncode == 0, ran.stderr
    assert (runner.action / "results/whisker/report.html").is_file()

    compare = "Compare with the reference tables"
    refused = runner.step(compare, **inputs)
    assert refused.returncode and "::error::" in refused.stdout
    (runner.workspace / "reference").mkdir()
    bless = [sys.executable, "workflow/check.py", "--results", "results/whisker", "--bless"]
    reference = ["--reference", str(runner.workspace / "reference")]
    subprocess.run([*bless, *reference], cwd=runner.action, check=True, capture_output=True)

    curves = runner.workspace / "reference/curves.csv"
    blessed = curves.read_text()
    curves.write_text(blessed.replace(",0.4775", ",0.4875"))
    moved = runner.step(compare, **inputs)
    assert moved.returncode
    assert "::error file=" in moved.stdout and "curves.mu_lock: 1 of 1 rows moved" in moved.stdout
    assert "| curves | mu_lock | moved | 1 |" in runner.summary.read_text()
    output = runner.action / "results/check.out"
    assert json.loads((output / "check.json").read_text())["passed"] is False
    assert (output / "reference/curves.csv").read_text() == blessed
