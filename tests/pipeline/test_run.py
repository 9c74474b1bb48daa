"""What a person sees of a run: messages before it, signals while it lasts, and logs of jobs."""

import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from runs import ROOT, TINY
from vibrissa.errors import DamagedTableError, VibrissaError
from vibrissa.pipeline import jobs, ownership, places, run


@pytest.mark.parametrize(
    ("arguments", "study", "words"),
    [
        ([], "none.yaml", "none.yaml cannot be read: No such file"),
        ([], ".", ". cannot be read: Is a directory"),
        (["--config", "contact=tip"], "tiny.yaml", "--config: contact: 'tip' is not allowed"),
        (["--workflow-profile", "none"], "tiny.yaml", "No such profile: none; there are: cluster"),
    ],
)
def test_a_mistake_is_one_line_before_any_work(fresh, arguments, study, words):
    status, screen = fresh.call(*arguments, study=study)
    assert status == 1 and screen.startswith(words) and len(screen.splitlines()) == 1
    assert [path.name for path in fresh.root.iterdir()] == ["tiny.yaml"]


def test_all_mistakes_of_a_study_file_are_shown(fresh):
    fresh.write("tiny.yaml", TINY.replace("[1.5, 2]", "[0.5]").replace("kind: taper", "kind: pie"))
    status, screen = fresh.call()
    assert status == 1
    assert [line.split(": ")[0] for line in screen.splitlines()] == ["tiny.yaml:5", "tiny.yaml:11"]


def test_a_profile_for_slurm_needs_slurm(fresh, monkeypatch):
    monkeypatch.setenv("PATH", str(fresh.root))
    status, screen = fresh.call("--workflow-profile", "slurm")
    assert status == 1 and screen.startswith("There is no command sinfo here: the profile slurm is")
    sinfo = fresh.root / "sinfo"
    sinfo.write_text("#!/bin/sh\necho no answer >&2\nexit 1\n")
    sinfo.chmod(0o755)
    status, screen = fresh.call("--workflow-profile", "slurm")
    assert status == 1 and screen.startswith("SLURM does not answer (sinfo): no answer; when")


@pytest.mark.slow
def test_a_run_that_is_stopped_says_so(fresh):
    """And goes on later; `python -m validation faults` stops runs at random times."""
    process = subprocess.Popen(
        [sys.executable, ROOT / "workflow/run.py", "--configfile", "tiny.yaml", "--cores", "1"],
        cwd=fresh.root,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    while not fresh.chunks():
        assert process.poll() is None, process.stdout.read()
        time.sleep(0.02)
    process.send_signal(signal.SIGINT)
    screen, _ = process.communicate(timeout=60)
    assert process.returncode == 128 + signal.SIGINT and "Traceback" not in screen
    told = "Stopped by SIGINT. Finished results are kept: the same command continues."
    assert screen.splitlines()[-1] == told


def test_a_log_has_the_reason_and_damaged_tables_are_removed(tmp_path):
    log, table = tmp_path / "job.log", tmp_path / "chunk.parquet"
    table.write_text("damaged")
    streams = sys.stdout, sys.stderr
    for error, words in (
        (VibrissaError("no luck"), "error: no luck\n"),
        (OSError(28, "No space left on device"), "error: [Errno 28] No space left on device\n"),
        (KeyboardInterrupt(), "interrupted\n"),
        (DamagedTableError(table, "is bad"), f"again: it is made again\n{table} is removed; the"),
    ):
        with pytest.raises(SystemExit), jobs.logged(log):
            raise error
        sys.stdout, sys.stderr = streams
        assert words in log.read_text()
    assert not table.exists()
    with pytest.raises(ZeroDivisionError), jobs.logged(log):
        _ = 1 / 0
    sys.stdout, sys.stderr = streams


def test_results_belong_to_one_study_file(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    first, copy = Path("first.yaml"), Path("copy.yaml")
    for path in (first, copy):
        path.write_text("study: a\n")
    ownership.check("results/a", first)
    ownership.claim("results/a", first.absolute())
    assert Path("results/a/study_file.txt").read_text() == "first.yaml\n"
    ownership.check("results/a", first.absolute())
    with pytest.raises(VibrissaError, match="give the key study another value in copy"):
        ownership.check("results/a", copy)
    first.write_text("study: b\n")
    ownership.check("results/a", copy)
    ownership.claim("results/a", copy)
    assert Path("results/a/study_file.txt").read_text() == "copy.yaml\n"


def test_places_are_those_of_the_clone(monkeypatch):
    assert places.HOME == ROOT and places.SNAKEFILE.is_file() and places.PAPER.is_file()
    monkeypatch.chdir(ROOT)
    assert places.near(places.SNAKEFILE) == Path("Snakefile")
    assert run.find_profile("slurm") == ROOT / "workflow/profiles/slurm"
