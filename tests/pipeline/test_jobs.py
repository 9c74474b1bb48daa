"""What a job leaves behind, run as Snakemake runs it: as a program of its own."""

import errno
import os
import signal
import subprocess
import sys

import pytest

from vibrissa.pipeline.jobs import Failure, failure

BEGINNING = """
import os, sys
from vibrissa.errors import *
from vibrissa.pipeline import jobs
with jobs.logged("job.log"):
    print("at work")
"""


@pytest.fixture
def job(tmp_path, monkeypatch):
    """Run a job of the given code; return its status, what it wrote elsewhere, and its log."""
    monkeypatch.chdir(tmp_path)

    def run(code):
        command = [sys.executable, "-c", f"{BEGINNING}    {code}"]
        result = subprocess.run(command, capture_output=True, text=True)
        log = tmp_path / "job.log"
        return result.returncode, result.stdout + result.stderr, log.is_file() and log.read_text()

    return run


def test_a_job_that_is_done_leaves_its_log_alone(job):
    assert job("print('more', file=sys.stderr)") == (0, "", "at work\nmore\n")
    assert os.listdir() == ["job.log"]
    assert failure("job.log") is None


@pytest.mark.parametrize(
    ("code", "message", "record"),
    [
        (
            "raise DamagedTableError('a.parquet', 'has no end')",
            "a.parquet has no end; delete it and run again, it is made anew",
            Failure(damaged="a.parquet"),
        ),
        ("raise TableError('no such grid')", "no such grid", Failure()),
        (
            f"raise OSError({errno.ENOSPC}, os.strerror({errno.ENOSPC}))",
            f"[Errno {errno.ENOSPC}] No space left on device",
            Failure(errno=errno.ENOSPC),
        ),
    ],
)
def test_a_job_that_is_refused_something_says_so_without_a_traceback(job, code, message, record):
    assert job(code) == (1, "", f"at work\nerror: {message}\n")
    assert failure("job.log") == record


def test_a_mistake_in_the_program_is_shown_as_one_in_the_log(job):
    status, screen, log = job("nothing.here")
    assert (status, screen) == (1, "")
    assert log.startswith("at work\nTraceback (most recent call last):\n")
    assert log.endswith("NameError: name 'nothing' is not defined\n")
    assert failure("job.log") == Failure()


def test_a_job_that_is_killed_is_not_done(job):
    status, _, log = job(f"os.kill(os.getpid(), {signal.SIGKILL})")
    assert (status, log) == (-signal.SIGKILL, "at work\n")
    assert failure("job.log") == Failure()


def test_the_record_of_an_earlier_attempt_is_removed(job):
    job("raise DamagedTableError('a.parquet', 'has no end')")
    job("pass")
    assert failure("job.log") is None


def test_a_job_that_is_done_is_done_though_somebody_has_tidied_up_its_folder(job):
    status, screen, log = job("os.remove('job.failure.json'); os.remove('job.log')")
    assert (status, screen, log) == (0, "", False)


def test_a_job_that_cannot_write_its_log_says_so(job):
    os.mkdir("job.log")
    status, screen, _ = job("pass")
    assert (status, screen) == (1, "error: [Errno 21] Is a directory: 'job.log'\n")


def test_a_job_that_has_not_begun_recorded_nothing(tmp_path):
    assert failure(tmp_path / "job.log") is None
