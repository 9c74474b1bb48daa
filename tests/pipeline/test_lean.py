"""What a run leaves out of Snakemake; tests/workflow runs with it."""

import subprocess
import sys
from pathlib import Path

import pytest

from vibrissa.pipeline import lean

ROOT = Path(__file__).parents[2]
BOTH = set(lean.PLUGINS)
SLURM, RICH = sorted(BOTH)
PROFILES = str(ROOT / "workflow/profiles")


@pytest.mark.parametrize(
    ("arguments", "left_out"),
    [
        ([], BOTH),
        (["--workflow-profile", f"{PROFILES}/default"], BOTH),
        (["--workflow-profile", f"{PROFILES}/slurm"], {RICH}),
        (["--logger", "vibrissa", "rich"], {SLURM}),
        (["--slurm-requeue"], {RICH}),
        (["--executor", "mine"], set()),
        (["-e", "mine"], set()),
        (["--profile", "mine"], set()),
        (["--profile=mine"], set()),
        ([f"--workflow-profile={PROFILES}/slurm"], {RICH}),
    ],
)
def test_plugins_that_nobody_asks_for_are_left_out(arguments, left_out):
    assert lean.unused(arguments, {}) == left_out
    assert lean.unused(arguments, {"SNAKEMAKE_PROFILE": "mine"}) == set()


def test_a_profile_in_the_working_directory_may_ask_for_plugins(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "profiles/default").mkdir(parents=True)
    (tmp_path / "profiles/default/config.yaml").write_text("executor: slurm\n")
    assert lean.unused([], {}) == {RICH}


@pytest.mark.slow
def test_what_is_left_out_is_not_imported():
    """Beside them nothing but pandas is missing among the modules."""
    code = (
        "import sys; sys.argv[1:] = ['--version']\nfrom runpy import run_module\n"
        "try: run_module('vibrissa.pipeline', run_name='__main__')\n"
        "except SystemExit: print(*sys.modules)"
    )
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    modules = set(result.stdout.split())
    assert "snakemake_executor_plugin_cluster_generic" in modules
    assert not modules & (BOTH | {"pandas"})
