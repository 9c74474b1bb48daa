"""What a person sees of a run: messages before it, signals while it lasts, and its last lines."""

import os
import pty
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from vibrissa.errors import DamagedTableError, VibrissaError
from vibrissa.pipeline import jobs, ownership, places, run

ROOT = Path(__file__).parents[2]
STUDY = """study: tiny
chunk: {theta: 1}
grids: {g: {theta: {start: 1, stop: 4, step: 0.5}, mu0: [0.3], eta: [0.85], dx0: [5e-3]}}
figures: {f: {kind: taper, grid: g}}
"""


@pytest.fixture
def folder(tmp_path):
    """A folder with a study file; the workflow is that of the project."""
    (tmp_path / "tiny.yaml").write_text(STUDY)
    return tmp_path


def command(*arguments, study="tiny.yaml"):
    found = [sys.executable, str(ROOT / "workflow/run.py"), "--cores", "2", *arguments]
    return found + ["--configfile", study] * bool(study)


def called(folder, *arguments, study="tiny.yaml"):
    result = subprocess.run(
        command(*arguments, study=study), cwd=folder, capture_output=True, text=True
    )
    return result.returncode, result.stdout + result.stderr


@pytest.mark.slow
def test_a_run_ends_with_what_came_out_and_where(folder):
    status, screen = called(folder)
    assert status == 0, screen
    assert screen.startswith("Study 'tiny', 7 points in 7 chunks:\n  snakemake --configfile ")
    assert " steps (100%) done" in screen
    assert screen.splitlines()[-3:] == [
        "7 grid points: 7 slip",
        "Figures: results/tiny/figures",
        "Report: results/tiny/report.html",
    ]
    assert len(list((folder / "results/tiny/figures").glob("f.*"))) == 3
    # An earlier study file had more, and nothing is to be done.
    (folder / "results/tiny/tables/scans.parquet").write_bytes(b"old")
    status, screen = called(folder)
    assert status == 0 and "Nothing to be done" in screen
    assert "Left over from an earlier study file, in results/tiny: tables/scans.parquet" in screen
    # What only shows something does not end as if it had run.
    for option in ("-n", "--help"):
        status, screen = called(folder, option)
        assert status == 0 and "Report: results" not in screen


@pytest.mark.parametrize(
    ("arguments", "study", "words"),
    [
        ([], "none.yaml", "No such study file: none.yaml"),
        ([], ".", ". cannot be read: Is a directory"),
        (["--config", "contact=tip"], "tiny.yaml", "--config: contact: 'tip' is not allowed"),
        (["--workflow-profile", "none"], "tiny.yaml", "No such profile: none; there are: cluster"),
    ],
)
def test_a_mistake_is_one_line_before_any_work(folder, arguments, study, words):
    status, screen = called(folder, *arguments, study=study)
    assert status == 1 and screen.startswith(words) and len(screen.splitlines()) == 1
    assert [path.name for path in folder.iterdir()] == ["tiny.yaml"]


def test_all_mistakes_of_a_study_file_are_shown(folder):
    (folder / "tiny.yaml").write_text(STUDY.replace("start: 1", "start: 0").replace("taper", "pie"))
    status, screen = called(folder)
    assert status == 1
    assert [line.split(": ")[0] for line in screen.splitlines()] == ["tiny.yaml:3", "tiny.yaml:4"]


def test_a_profile_for_slurm_needs_slurm(folder, monkeypatch):
    monkeypatch.setenv("PATH", str(folder))
    status, screen = called(folder, "--workflow-profile", "slurm")
    assert status == 1 and screen.startswith("There is no command sinfo here: the profile slurm is")
    sinfo = folder / "sinfo"
    sinfo.write_text("#!/bin/sh\necho no answer >&2\nexit 1\n")
    sinfo.chmod(0o755)
    status, screen = called(folder, "--workflow-profile", "slurm")
    assert status == 1 and screen.startswith("SLURM does not answer (sinfo): no answer; when")


def started(folder, until):
    """Start a run, and wait until something is there."""
    process = subprocess.Popen(
        command(), cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    )
    while not until():
        assert process.poll() is None, process.stdout.read()
        time.sleep(0.02)
    return process


def some_chunk(folder):
    return lambda: list(folder.glob("results/tiny/chunks/g/theta*.parquet"))


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_run_that_is_stopped_says_so_and_goes_on_later(folder, number):
    process = started(folder, some_chunk(folder))
    process.send_signal(number)
    screen, _ = process.communicate(timeout=60)
    assert process.returncode == 128 + number and "Traceback" not in screen
    told = f"Stopped by {number.name}. Finished results are kept: the same command continues."
    assert screen.splitlines()[-1] == told
    status, screen = called(folder)
    assert status == 0 and "7 grid points: 7 slip" in screen


@pytest.mark.parametrize("after", [0.3, 0.8])
def test_a_run_that_is_stopped_while_it_loads_shows_no_traceback(folder, after):
    process = started(folder, (folder / ".snakemake/run.lock").exists)
    time.sleep(after)
    process.send_signal(signal.SIGINT)
    screen, _ = process.communicate(timeout=60)
    assert process.returncode == 130 and "Traceback" not in screen


@pytest.mark.slow
def test_another_run_in_the_same_folder_is_told_of_directory_and_a_killed_one_goes_on(folder):
    process = started(folder, some_chunk(folder))
    status, screen = called(folder)
    assert status == 1 and "run this study in another folder: --directory other" in screen
    # The process and the Snakemake that it started, which holds the lock otherwise.
    children = Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()
    process.kill()
    for child in map(int, children):
        os.killpg(child, signal.SIGKILL)
    process.communicate()
    status, screen = called(folder)
    assert screen.startswith("The last run was interrupted. Its finished results are")
    assert status == 0 and "7 grid points: 7 slip" in screen


@pytest.mark.slow
def test_a_terminal_shows_progress(folder):
    master, slave = pty.openpty()
    environment = os.environ | {"TERM": "xterm", "COLUMNS": "80"}
    process = subprocess.Popen(
        command("results/tiny/summary.txt"), cwd=folder, stdout=slave, stderr=slave, env=environment
    )
    os.close(slave)
    screen = b""
    while True:
        try:
            screen += os.read(master, 4096)
        except OSError:  # the other side is closed
            break
    assert process.wait() == 0
    assert b"100%" in screen and b"Report: results/tiny/report.html" in screen


@pytest.mark.slow
def test_a_job_that_fails_shows_its_reason(folder):
    (folder / "results/tiny/tables").mkdir(parents=True)
    (folder / "results/tiny/figures").write_text("a file where a folder is needed")
    status, screen = called(folder, "--keep-going")
    assert status == 1
    assert "The study is not complete; results/tiny/logs says why." in screen


def test_a_log_has_the_reason_and_damaged_tables_are_removed(tmp_path):
    log, table = tmp_path / "job.log", tmp_path / "chunk.parquet"
    table.write_text("damaged")
    streams = sys.stdout, sys.stderr
    for error, words in (
        (VibrissaError("no luck"), "error: no luck\n"),
        (OSError(28, "No space left on device"), "error: [Errno 28] No space left on device\n"),
        (KeyboardInterrupt(), "interrupted\n"),
        (DamagedTableError(table, "is bad"), f"again, it is made anew\n{table} is removed; the"),
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
    assert places.proofs("paper") == ["tests/regression/paper/enclosures.csv"]
    assert places.proofs("none") == []
    assert run.find_profile("slurm") == ROOT / "workflow/profiles/slurm"
