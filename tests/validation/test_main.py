"""`python -m validation`: names, what they stand for, and what is refused."""

import subprocess
import sys

from validation import records
from validation.__main__ import ROOT, TASKS, Task, main


def run(*arguments):
    command = [sys.executable, "-m", "validation", *arguments]
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True)


def test_the_list_has_a_line_for_each_name():
    _, _, *lines = run("--list").stdout.splitlines()
    assert [line.split()[0] for line in lines] == list(TASKS)


def test_options_reach_the_check():
    assert "--pushes" in run("chains", "--help").stdout


def test_an_unknown_name_is_refused():
    refused = run("proofs")
    assert refused.returncode == 2
    assert refused.stderr == "no such check: proofs; python -m validation --list lists all\n"


def test_a_missing_package_is_named_with_what_to_type(monkeypatch, capsys):
    def pandas_is_missing(options):
        raise ModuleNotFoundError("No module named 'x'", name="pandas")

    for task, name in (
        (Task(print, "", "", needs=("pytest", "no_such_plugin")), "no_such_plugin"),
        (Task(pandas_is_missing, "", ""), "pandas"),
    ):
        monkeypatch.setitem(TASKS, "slurm", task)
        monkeypatch.setattr(sys, "argv", ["validation", "slurm"])
        assert main() == 2
        told = f"this needs {name}: type make setup LOCKS='test docs cluster'\n"
        assert capsys.readouterr().err == told


def test_a_record_has_title_command_and_findings(tmp_path, monkeypatch):
    monkeypatch.setattr(records, "FOLDER", tmp_path)
    records.write_record("chains", "Chains.\n\nMore of them.\n", "| a |\n")
    assert (tmp_path / "chains.md").read_text() == (
        "# Chains\n\nMore of them.\n\nWritten by `python -m validation chains`.\n\n| a |\n"
    )
